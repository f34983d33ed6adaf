"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact  # noqa: E402
from law import Law  # noqa: E402


def solution():
    law, out = Law(HERE), {}
    for k in range(5):
        kn, _, gamma, *_ = law.of("concrete", f"human_{k}")
        gap, rate = Impact(kn, gamma, 80).after(0.01, 1, 0.06)
        out |= {f"{k}.x": 0.01 - gap, f"{k}.vx": -rate}
    return out
