"""People who walk against closed forms and published ranges: the quick cases of examples/validation.py (docs/validation.md)."""

import importlib.util
import math

import numpy as np
import pytest
from crowd import REPOSITORY

pytestmark = pytest.mark.long

SPEC = importlib.util.spec_from_file_location("validation", REPOSITORY / "examples" / "validation.py")
validation = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(validation)


@pytest.fixture(autouse=True)
def command(lemons, tmp_path, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))
    validation.leave.cache_clear()


def cells(table):
    """The rows of a Markdown table below its head, by their first cell."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    return {row[0]: row[1:] for row in rows}


def test_one_person_keeps_the_speed(tmp_path):
    """RiMEA 1: 40 m at 1.34 m/s take 29.85 s. In the first 1.5 m the speed relaxes as exp(-4.5 t / s)."""
    (table,), _ = validation.rimea_1(tmp_path)
    rows = cells(table)
    for model in validation.MODELS:
        time = float(rows[model][0])
        assert math.isclose(time, 40 / validation.SPEED, rel_tol=2e-3), model
        assert 26 <= time <= 34, "the range of the test case"


def test_nobody_goes_through_the_walls_of_a_corner(tmp_path):
    """RiMEA 6."""
    (table,), _ = validation.rimea_6(tmp_path, quick=True)
    for model, (outside, deepest, last) in cells(table).items():
        assert int(outside) == 0, model
        assert float(deepest) < 5, f"{model}: a body is {deepest} mm in a wall"
        # Nobody is faster than the fastest on the shortest way, and nobody stays.
        fastest = validation.SPEED + 2 * validation.SPREAD
        assert (4 + 9.5) / fastest < float(last) < 60, model


def test_deepest_in_walls_and_inside_see_what_is_wrong():
    import pandas as pd

    rows = pd.DataFrame({"id": [0, 0], "x": [0.5, 0.15], "y": [1.0, 1.0], "theta": [0.0, math.pi / 2]})
    disk = [np.array([[0.0, 0.1, 0.1]])]  # turned to the left it reaches 0.2 m towards -x
    assert math.isclose(validation.deepest_in_walls(rows, disk, [[(0, 0), (0, 2)]]), 0.05)
    assert validation.inside(validation.CORNER, np.array([[1.0, 1.0], [11.0, 11.0], [5.0, 5.0]])).tolist() == [True, True, False]


def test_flow_through_a_bottleneck(tmp_path):
    """Handbooks have 1.2 to 1.3 /(m s), experiments 1.6 to 2.4: each model is on its side."""
    for model, low, high in [("collision-free-speed", 0.8, 1.5), ("rotational", 1.5, 2.4)]:
        times = validation.leave(tmp_path, model, 1.2, 40, 1)
        assert len(times) == 40, "nobody is stuck"
        assert low < validation.steady(times) / 1.2 < high


def test_single_file_is_the_closed_form(tmp_path):
    """Who keeps a time gap T is so fast that the gap to the next body is v T: d = depth + v T, here 16 and 28 people."""
    (table, _), _ = validation.single_file(tmp_path, quick=True)
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    for model, people, spacing, speed, _ in rows:
        if model == "rotational":
            # d = 2 r + b + v T with the constants of the model. Speeds have a noise.
            assert abs(float(spacing) - (0.39 + 0.9 * float(speed))) < 0.05
        elif model == "collision-free-speed":
            assert 0.2 < float(spacing) - 1.0 * float(speed) < 0.3, "the depth of a chest"
        else:
            assert float(speed) > 0.98 * validation.SPEED, "nobody keeps a distance"


@pytest.mark.parametrize("model", ["rotational", "collision-free-speed"])
def test_nobody_spins_in_front_of_two_exits(tmp_path, model):
    """In a dense queue the direction of walking may jump from one side to the other: people do not turn with it round and round.
    (Others may roll somebody a little more than once round.)"""
    validation.lemons("crowd", "--number", 120, "--box", "12x8", "--door", "12,2,0.9", "--door", "12,6,1.4", "--leave", "--model", model, "-o", tmp_path / "room")
    rows = validation.frames_of(validation.run(tmp_path / "room", 30))
    turned = rows.groupby("id")["theta"].agg(lambda angles: np.ptp(np.unwrap(angles)))
    assert len(turned) == 120 and turned.max() < 3 * math.pi
