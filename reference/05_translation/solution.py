"""The closed form of README.md."""

import math


def solution():
    rate, t = 4.5, 1.0
    kept = math.exp(-rate * t)
    way = (1 - kept) / rate
    return {"0.x": way, "0.y": 0.5 * way, "0.theta": 0.0, "0.vx": kept, "0.vy": 0.5 * kept, "0.omega": 0.0}
