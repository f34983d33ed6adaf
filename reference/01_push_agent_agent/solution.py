"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact, two  # noqa: E402
from law import Law  # noqa: E402


def solution():
    kn, _, gamma, *_ = Law(HERE).of("human", "human")
    x0, x1, v0, v1 = two(80, 60, 0, 0.46, 1, 0, 0.45, Impact(kn, gamma, 80 * 60 / 140), 0.05)
    return {"0.x": x0, "1.x": x1, "0.vx": v0, "1.vx": v1}
