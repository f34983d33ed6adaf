"""Communication points: those of the package are to the last bit those of the command, whose own are in a table."""

import csv

from crowd import REPOSITORY
from lemons_fmu.clock import clock_of, points_between, steps_between

# Written by `CLOCK_TABLE=write cargo test -p lemons-master --lib clock`.
TABLE = REPOSITORY / "tests/clock.csv"


def test_points_are_those_of_the_command():
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 2000
    short = 0
    for row in rows:
        step, until = float(row["step"]), float(row["until"])
        assert clock_of(0.0, until, step) == (int(row["steps"]), float(row["last"])), row
        if steps_between(0.0, until, step) > 1_000_000:
            continue  # the points of a long run need gigabytes
        points = points_between(0.0, until, step)
        assert len(points) - 1 == int(row["steps"]), row
        assert points[-1] == float(row["last"]), row
        assert points[len(points) // 2] == float(row["middle"]), row
        short += points[-1] == until != (len(points) - 1) * step
    # Ends that are multiples but for rounding, and others, are in it.
    assert 0 < short < len(rows) and sum(float(row["last"]) != float(row["until"]) for row in rows) > 100
