"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from law import Law  # noqa: E402


def solution():
    """Each contact bears the pushes of all behind it; its overlap is the load over k_n."""
    law, push = Law(HERE), 180.0
    x = 5 * push / law.of("human", "concrete")[0]
    out = {"0.x": x, "0.wall": 5 * push}
    for k in range(1, 5):
        x += (5 - k) * push / law.of("human", "human")[0] - 0.4
        out[f"{k}.x"] = x
    return out
