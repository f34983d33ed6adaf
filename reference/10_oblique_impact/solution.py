"""Converged: README.md says how."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from law import Law  # noqa: E402
from law import solved  # noqa: E402

NAMES = [f"{k}.{component}" for k in range(6) for component in ("vx", "vy", "omega")]


def solution():
    return solved(HERE, NAMES)


def closed():
    """Without a normal damper, and where it slides all the time: the impulse of friction is mu times 2 m v_n; the arm shrinks with h."""
    kn, _, _, _, mu = Law(HERE).of("human", "concrete")
    out = {}
    for k, degrees in enumerate([5, 20, 40, 60, 75, 85]):
        vn, vt = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        out[f"{k}.vx"] = -vn
        if degrees >= 75:
            deepest = vn * math.sqrt(80 / kn)
            h_force = kn * deepest**2 * math.pi / 2 * math.sqrt(80 / kn)  # the integral of h F_n
            out |= {f"{k}.vy": vt - 2 * mu * vn, f"{k}.omega": -mu * (0.2 * 2 * 80 * vn - h_force / 2) / 1.6}
    return out
