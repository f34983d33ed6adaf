"""Converged: README.md says how."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Impact  # noqa: E402
from law import Law  # noqa: E402
from law import solved  # noqa: E402

NAMES = [f"{k}.{component}" for k in range(3) for component in ("vx", "vy", "omega")]


def solution():
    return solved(HERE, NAMES)


def closed():
    kn, _, gamma, *_ = Law(HERE).of("human", "concrete")
    return {f"{k}.vx": -Impact(kn, gamma, 80).restitution for k in range(3)}
