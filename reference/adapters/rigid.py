"""What engines of hard bodies take from a Trial: restitution and friction instead of springs. No engine itself."""

import math

import numpy as np
from law import Scene
from run import CannotExpress


def restitution(kn, gamma, mass):
    """Of an impact of a spring and a damper (cases 01, 02, 09)."""
    rate = gamma / (2 * mass)
    return math.exp(-rate * math.pi / math.sqrt(kn / mass - rate * rate))


class Hard:
    """Of each disk restitution and friction; the walls' friction. Walls give back nothing by themselves: the larger one of two counts."""

    def __init__(self, trial):
        s = self.scene = Scene(trial)
        if (s.across != s.along).any():
            raise CannotExpress("no friction that depends on the gaze")
        if trial.name[:2] == "25":
            raise CannotExpress("no heights")
        self.restitution, self.friction, self.wall_friction = [0.0] * len(s.owner), [0.0] * len(s.owner), 0.0
        for wall in (False, True):  # what a wall says comes last, and counts
            for n in np.flatnonzero((s.face >= 0) == wall):
                i, j = s.i[n], s.j[n]
                m = s.mass[s.owner[i]]
                if not wall:
                    m = m * s.mass[s.owner[j]] / (m + s.mass[s.owner[j]])
                e = restitution(s.kn[n], s.gn[n], m)
                for disk in (i,) if wall else (i, j):
                    self.restitution[disk], self.friction[disk] = float(e), float(s.mu[n])
                if wall:
                    self.wall_friction = float(s.mu[n])
