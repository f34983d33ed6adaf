"""The closed form of README.md."""

import math


def solution():
    rate, t = 4.5, 0.5
    kept = math.exp(-rate * t)
    way = t - (1 - kept) / rate
    out = {}
    for pose, twist, final in (("x", "vx", 400 / 89 / rate), ("y", "vy", -150 / 89 / rate), ("theta", "omega", 6 / 1.85 / rate)):
        out |= {f"0.{pose}": final * way, f"0.{twist}": final * (1 - kept)}
    return out
