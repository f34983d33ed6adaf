"""The closed form of README.md."""

import math


def solution():
    rate, t = 4.5, 1.0
    kept = math.exp(-rate * t)
    return {"0.theta": 3 * (1 - kept) / rate, "0.omega": 3 * kept}
