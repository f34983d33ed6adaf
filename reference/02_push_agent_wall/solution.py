"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact  # noqa: E402
from law import Law  # noqa: E402


def solution():
    kn, _, gamma, *_ = Law(HERE).of("human", "concrete")
    gap, rate = Impact(kn, gamma, 80).after(0.01, 1, 0.05)
    return {"0.x": 0.01 - gap, "0.vx": -rate}
