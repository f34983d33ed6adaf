"""What was measured, in few numbers; README.md says how they are derived.

python solution.py DIRECTORY     derives them again, from a copy of the record (force per mass of person 0, places of the heads)
"""

import sys
from pathlib import Path

import numpy as np
from scipy.integrate import trapezoid

MASS = 89.0  # [kg] of person 0
REST = 2.2  # [s] the time until which everybody stands
START = (0.0, 0.279, 0.692, 1.07, 1.448)  # [m] x at the start
WAY = (0.404, 0.37, 0.292, 0.186, 0.113)  # [m] how far the heads came along x


def solution():
    return {f"{k}.x": start + way for k, (start, way) in enumerate(zip(START, WAY))}


def derived(directory):
    """The force on person 0 [N], how long [s], the greatest way of each head [m], its standard deviation at rest [m]."""
    time, push = np.loadtxt(Path(directory, "external_force_per_mass.txt"), skiprows=1).T
    impulse = trapezoid(push, time)
    middle = trapezoid(push * time, time) / impulse
    # A constant force that lasts T has the variance T^2/12 of its times.
    lasts = np.sqrt(12 * trapezoid(push * (time - middle) ** 2, time) / impulse)
    t, person, x = np.loadtxt(Path(directory, "measured_head_trajectories.csv"), delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
    rest = [x[(person == k) & (t < REST)] for k in range(len(START))]
    ways = [x[person == k].max() - at.mean() for k, at in enumerate(rest)]
    return MASS * impulse / lasts, lasts, ways, [at.std() for at in rest]


if __name__ == "__main__":
    print(*derived(sys.argv[1]), sep="\n")
