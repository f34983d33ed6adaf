"""The closed form of README.md."""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Flat  # noqa: E402
from law import Law  # noqa: E402


def solution():
    law, weight, out = Law(HERE).of("human", "concrete"), 784.8, {}
    for k, degrees in enumerate([10, 30, 60]):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        disk = Flat(80, 1.6, 0.2, law, weight * c, weight * s, 0.0).advance(0.5)
        height = 0.2 - weight * c / law[0]
        out |= {f"{k}.x": 3 * k + height * s + disk.x * c, f"{k}.y": height * c - disk.x * s}
        out |= {f"{k}.theta": disk.theta, f"{k}.vx": disk.v * c, f"{k}.vy": -disk.v * s, f"{k}.omega": disk.omega}
    return out
