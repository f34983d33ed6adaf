"""People who walk and leave, from Python, against what the command writes."""

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest
from crowd import TRIAL_DOOR
from lemons_fmu import Crowd, FmuError, Trial, load, simulate, sweep


@pytest.fixture(scope="module")
def leaving(lemons, tmp_path_factory):
    """Twenty people who leave a room by a door."""
    trial = tmp_path_factory.mktemp("leaving") / "leaving"
    options = "--number 20 --box 5x4 --door 5,2,1 --leave --seed 2".split()
    subprocess.run([lemons, "crowd", *options, "-o", trial], check=True, capture_output=True)
    return trial


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def written(lemons, tmp_path, trial, *options):
    table = tmp_path / "command.csv"
    command = [lemons, "run", trial, *options, "-o", table, "--outputs", tmp_path / "outputs.csv"]
    subprocess.run(command, check=True, capture_output=True)
    with table.open(newline="") as file:
        return list(csv.reader(file))


def same(table, rows):
    """To the last bit; the command writes 0.00001 where Python writes 1e-05."""
    assert list(table.columns) == rows[0]
    assert np.array_equal(table.to_numpy(dtype=float), np.array(rows[1:], dtype=float))


def test_simulate_of_a_trial_walks_as_the_command(lemons, leaving, tmp_path):
    table = simulate(leaving, until=6.0)
    same(table, written(lemons, tmp_path, leaving, "--until", "6"))
    assert table["active"].dtype == np.int64 and table["id"].dtype == np.int64
    assert table["active"].iloc[:20].all() and not table["active"].iloc[-20:].all(), "some have left"
    # A Trial, a step and parameters of both FMUs.
    given = {"decision.agent[3].DesiredSpeed": 0.5, "agent[1].Mass": 60.0}
    named = ["--set", "decision.agent[3].DesiredSpeed=0.5", "--set", "agent[1].Mass=60"]
    table = simulate(Trial(leaving), None, given, 1.0, step=0.05)
    same(table, written(lemons, tmp_path, leaving, "--until", "1", "--step", "0.05", *named))


def test_another_plan_and_none(lemons, leaving, tmp_path):
    plan = tmp_path / "other.toml"
    plan.write_text("waypoints = [{ x = 1.0, y = 1.0 }]\n")
    same(simulate(leaving, until=0.5, plan=plan), written(lemons, tmp_path, leaving, "--until", "0.5", "--plan", plan))
    still = simulate(leaving, until=0.5, plan=False)
    same(still, written(lemons, tmp_path, leaving, "--until", "0.5", "--no-plan"))
    assert "active" not in still and (still["vx"] == 0.0).all()


def test_what_does_not_walk_is_refused(leaving, pack):
    fmu = pack(TRIAL_DOOR)
    with pytest.raises(ValueError, match="a packed crowd does not walk: give the Trial"):
        simulate(fmu, until=0.1, plan=TRIAL_DOOR / "decision.toml")
    with pytest.raises(TypeError, match="the drive of a Trial is None, False or a path, not ndarray"):
        simulate(leaving, np.zeros((20, 3)), until=0.1)
    for refusing in (lambda: sweep(leaving, {"Threads": [1]}, None, lambda run: {}, until=0.1), lambda: Crowd(leaving)):
        with pytest.raises(FmuError, match="leaving: is a Trial's directory, not an FMU: .*`lemons sweep`"):
            refusing()


@pytest.mark.parametrize("version", ["2", "3"])
def test_who_is_taken_out_does_not_move_until_back(pack, version):
    fmu = load(pack(Path(TRIAL_DOOR), options=["--fmi", version]))
    with Crowd(fmu) as crowd, Crowd(fmu) as other:
        drive = np.tile([200.0, 0.0, 0.0], (len(crowd), 1))
        for each in (crowd, other):
            each.set_drive(drive)
        assert len(crowd.active) == len(crowd) and np.asarray(crowd.active).all()
        crowd.active[3] = False
        assert crowd.active[3] is False and crowd["agent[3].Active"] is False and crowd["agent[4].Active"] is True
        before = crowd.poses()
        for each in (crowd, other):
            each.step(0.1)
        moved = (crowd.poses() != before).any(axis=1)
        assert not moved[3] and moved.sum() == len(crowd) - 1
        assert (other.poses() != before).any(axis=1).all()
        assert crowd.contacts()[3].tolist() == [0, 0, 0]
        # States hold it; several are set at once; who comes back moves on.
        state = crowd.save()
        crowd.active = True
        assert crowd.active[:].all()
        crowd.active[[1, 2]] = [False, True]
        assert np.flatnonzero(~crowd.active[:]).tolist() == [1]
        crowd.restore(state)
        assert np.flatnonzero(~crowd.active[:]).tolist() == [3]
        crowd.active[3] = True
        crowd.step(0.1)
        assert (crowd.poses()[3] != before[3]).any()
        with pytest.raises(ValueError, match="must be True or False, not 2"):
            crowd.active[0] = 2
        with pytest.raises(IndexError):
            crowd.active[len(crowd)] = False
    with Crowd(fmu, {"agent[3].Active": False}) as crowd:
        assert np.flatnonzero(~crowd.active[:]).tolist() == [3]
    with pytest.raises(FmuError, match="must be True or False, not 'no'"):
        Crowd(fmu, {"agent[3].Active": "no"})
