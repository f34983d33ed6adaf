"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact  # noqa: E402
from law import Law  # noqa: E402


def solution():
    kn, _, gamma, *_ = Law(HERE).of("human", "concrete")
    impact = Impact(kn, gamma, 80)
    (gap_x, rate_x), (gap_y, rate_y) = (impact.after(0.1, u, 0.25) for u in (1.0, 0.6))
    return {"0.x": 0.1 - gap_x, "0.y": 0.1 - gap_y, "0.vx": -rate_x, "0.vy": -rate_y}
