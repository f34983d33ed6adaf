"""What engines of hard bodies take from a Trial: restitution and friction instead of springs. No engine itself."""

import math

import numpy as np
from law import Scene
from run import CannotExpress


#: [m] Distance at the start within which pairs of disks tell restitution and friction: all, but in large crowds of one kind.
WITHIN = math.inf


def restitution(kn, gamma, mass):
    """Of an impact of a spring and a damper (cases 01, 02, 09)."""
    rate = gamma / (2 * mass)
    return math.exp(-rate * math.pi / math.sqrt(kn / mass - rate * rate))


class Hard:
    """Of each disk its restitution; friction of disks among themselves, and of disks at walls. Walls give back nothing by themselves: the larger
    restitution of two counts. So disks that touch walls and each other have that of the walls."""

    def __init__(self, trial):
        s = self.scene = Scene(trial, WITHIN)
        if (s.across != s.along).any():
            raise CannotExpress("our adapter has no floor that depends on the gaze")
        if trial.name[:2] == "25":
            raise CannotExpress("our adapter has no heights")
        self.restitution = [0.0] * len(s.owner)
        for wall in (False, True):  # what a wall says comes last, and counts
            for n in np.flatnonzero((s.face >= 0) == wall):
                i, j = s.i[n], s.j[n]
                m = s.mass[s.owner[i]]
                if not wall:
                    m = m * s.mass[s.owner[j]] / (m + s.mass[s.owner[j]])
                e = restitution(s.kn[n], s.gn[n], m)
                for disk in (i,) if wall else (i, j):
                    self.restitution[disk] = float(e)
        if WITHIN < math.inf:  # who is near nobody is as the others are
            self.restitution = [max(self.restitution)] * len(s.owner)
        of_pairs, of_walls = ({float(mu) for mu in s.mu[(s.face >= 0) == wall]} for wall in (False, True))
        if max(len(of_pairs), len(of_walls)) > 1 or (of_pairs == {0.0} and max(of_walls, default=0.0) > 0):
            raise CannotExpress("our adapter has one friction of disks and one of walls, the former above zero")
        wall = max(of_walls, default=0.0)
        self.disk_friction = max(of_pairs, default=wall)
        #: Friction at walls is `ratio` times that of disks among themselves.
        self.ratio = wall / self.disk_friction if wall else 0.0
