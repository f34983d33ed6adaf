"""Converged: README.md says how."""

import cmath
import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from law import solved  # noqa: E402

NAMES = [f"{k}.{component}" for k in range(2) for component in ("x", "y", "theta", "vx", "vy", "omega")]


def solution():
    return solved(HERE, NAMES)


def closed():
    """Who does not turn is slower along the gaze and across it, each by its rate; the turn of the other is that of a single rate."""
    gaze, t, out = cmath.exp(1j * math.pi / 6), 1.0, {}
    seen = 1 / gaze
    v = gaze * complex(seen.real * math.exp(-0.5 * t), seen.imag * math.exp(-30 * t))
    r = gaze * complex(seen.real * (1 - math.exp(-0.5 * t)) / 0.5, seen.imag * (1 - math.exp(-30 * t)) / 30)
    out |= {"0.x": r.real, "0.y": r.imag, "0.vx": v.real, "0.vy": v.imag}
    return out | {"1.theta": 3 * (1 - math.exp(-t)), "1.omega": 3 * math.exp(-t)}
