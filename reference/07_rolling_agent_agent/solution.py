"""Converged: README.md says how."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from law import solved  # noqa: E402

NAMES = ["0.x", "0.y", "0.theta", "0.vx", "0.vy", "0.omega", "1.x", "1.y", "1.theta", "1.vx", "1.vy", "1.omega"]


def solution():
    return solved(HERE, NAMES)
