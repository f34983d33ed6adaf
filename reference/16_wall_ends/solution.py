"""Converged: README.md says how."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact  # noqa: E402
from law import Law  # noqa: E402
from law import solved  # noqa: E402

NAMES = [f"{k}.{component}" for k in range(3) for component in ("x", "y", "vx", "vy", "omega")]


def solution():
    return solved(HERE, NAMES)


def closed():
    """The first two meet one point each, head-on: an impact of one spring."""
    kn, _, gamma, *_ = Law(HERE).of("human", "concrete")
    gap, rate = Impact(kn, gamma, 80).after(0.01, 1, 0.06)
    return {f"{k}.{name}": value for k in range(2) for name, value in (("x", 0.01 - gap), ("y", 2.0 * k), ("vx", -rate), ("vy", 0.0), ("omega", 0.0))}
