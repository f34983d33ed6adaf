"""The closed form of README.md."""


def solution():
    """Springs without dampers and friction give back what they take; the last disk is on the bisector, and comes back on it."""
    return {f"{k}.speed": 1.0 for k in range(4)} | {"4.vx": -1.0, "4.vy": 0.0}
