"""Barrier cases: what a barrier gets, beside closed forms and the Green Guide's table; the FMU of a case."""

import hashlib
import math
import os
import re
import subprocess
import sys

import pytest
from crowd import REPOSITORY


def barriers(lemons, target, *words):
    """What the example prints."""
    command = [sys.executable, REPOSITORY / "examples/barriers.py", target, *map(str, words)]
    done = subprocess.run(command, env={**os.environ, "LEMONS": str(lemons)}, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=900)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_columns_press_with_the_sum_of_their_pushes(lemons, tmp_path):
    """In one file without friction n p, to the last digit shown; never more than what feet hold."""
    said = barriers(lemons, tmp_path, "columns", "--seeds", 1, "--people", 1, 4)
    (row,) = re.findall(r"^one file, round, no friction +(\S+) \(1\.00\) +(\S+) \(1\.00\)$", said, re.MULTILINE)
    assert row == ("1.00", "1.00")
    feet = [[float(number) for number in found] for found in re.findall(r"^ +(\d+) N: ([\d.]+), and ([\d.]+) if all lean$", said, re.MULTILINE)]
    assert len(feet) == 6 and all(seen <= 1.01 * most <= 1.02 * 20e-3 * push for push, seen, most in feet)
    assert feet[-1][1:] == feet[-2][1:] and feet[0][2] == pytest.approx(1.0)


def test_a_packed_barrier_is_the_same_again(lemons, tmp_path):
    """The digest is of the file, packing again gives the same bytes, and the FMU gives the results in it."""
    said = barriers(lemons, tmp_path, "fmu")
    (digest,) = re.findall(r"SHA-256 ([0-9a-f]{64})$", said, re.MULTILINE)
    packed = (tmp_path / "barrier.fmu").read_bytes()
    assert hashlib.sha256(packed).hexdigest() == digest and "the same bits" in said
    barriers(lemons, tmp_path, "fmu")
    assert (tmp_path / "barrier.fmu").read_bytes() == packed


@pytest.mark.long
def test_one_push_gives_both_columns_of_the_green_guide(lemons, tmp_path):
    """5.0 kN/m at 4.3 m on 10° and at 3.1 m on 25°, within 10 %; where feet hold all or nothing of the slope, one of them is wrong."""
    said = barriers(lemons, tmp_path, "terrace", "--seeds", 2)
    rows = re.findall(r"^push +(\d+) N, held ([\d.]+), +\d+ seeds: 10°: ([\d.]+) .*25°: ([\d.]+) ", said, re.MULTILINE)
    fits = {(int(push), float(held)): [abs(float(load) / 5.0 - 1) < 0.1 for load in loads] for push, held, *loads in rows}
    assert len(fits) == 7
    assert fits[180, 0.45] == [True, True]
    assert all(not all(within) for (_, held), within in fits.items() if held in (0.0, 1.0))


@pytest.mark.long
def test_an_alley_presses_as_its_people_and_its_ground(lemons, tmp_path):
    """The foot gets what people and ground give, but for the friction of the sides, which holds either way; the plane's formula gives their load."""
    said = barriers(lemons, tmp_path, "alley", "--seeds", 1, "--length", 6)
    foot, given = map(float, re.search(r"^the foot: (\d+) N/m; what people and ground give: (\d+) N/m$", said, re.MULTILINE).groups())
    # 2 × friction × length/width, if the sides bear as much as the foot: of a silo that is filled, and of one that is pushed up.
    friction = 2 * 0.1 * 6 / 3.2
    assert -math.expm1(-friction) / friction * 0.95 < foot / given < math.expm1(friction) / friction
    plane, sides = map(float, re.search(r"^all +\d+ +\d+ +(\d+) +(\d+)$", said, re.MULTILINE).groups())
    assert sides == pytest.approx(plane, rel=0.25)
