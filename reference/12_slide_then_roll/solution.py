"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Flat  # noqa: E402
from law import Law  # noqa: E402


def solution():
    disk = Flat(80, 1.6, 0.2, Law(HERE).of("human", "concrete"), 500.0, 0.0, 3.0).advance(1.0)
    return {"0.x": disk.x, "0.vx": disk.v, "0.theta": disk.theta, "0.omega": disk.omega}
