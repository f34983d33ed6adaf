"""Converged: README.md says how."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from law import solved  # noqa: E402

NAMES = [f"{k}.{component}" for k in range(4) for component in ("x", "y", "theta", "vx", "vy", "omega")]


def solution():
    return solved(HERE, NAMES)
