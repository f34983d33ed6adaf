"""People who walk and leave, from Python, against what the command writes."""

import csv
import json
import pickle
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest
from crowd import TRIAL_DOOR
from lemons_fmu import CommandError, Crowd, SimulationError, Trial, measure, simulate


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
    command = [lemons, "run", trial, *options, "-o", table, "--outputs", tmp_path / "outputs.csv", "--force"]
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


def test_another_decision_and_none(lemons, leaving, tmp_path):
    decision = tmp_path / "other.toml"
    decision.write_text("waypoints = [{ x = 1.0, y = 1.0 }]\n")
    same(simulate(leaving, until=0.5, decision=decision), written(lemons, tmp_path, leaving, "--until", "0.5", "--decision", decision))
    still = simulate(leaving, until=0.5, decision=False)
    same(still, written(lemons, tmp_path, leaving, "--until", "0.5", "--no-decision"))
    assert "active" not in still and (still["vx"] == 0.0).all()


def test_gauss_seidel_a_zip_and_the_end(lemons, leaving, tmp_path):
    """The other algorithm; a zip of the Trial; and a run that ends when everybody has left."""
    given = {"algorithm": "gauss-seidel", "until": 3.0}
    seidel = simulate(TRIAL_DOOR, **given)
    same(seidel, written(lemons, tmp_path, TRIAL_DOOR, "--until", "3", "--algorithm", "gauss-seidel"))
    assert not seidel.equals(simulate(TRIAL_DOOR, until=3.0))
    packed = shutil.make_archive(tmp_path / "packed", "zip", leaving.parent, leaving.name)
    table = simulate(packed, until="left")
    same(table, written(lemons, tmp_path, packed, "--until", "left"))
    last = table["t"].iloc[-1]
    assert 5 < last < 60 and not table["active"][table["t"] == last].any() and table["active"].iloc[-40:-20].any()


#: [s] Sums of it are exact: a run that goes on from its middle has the same times.
EXACT = 1 / 64


def test_a_crowd_that_walks_is_stepped_saved_and_reset(leaving):
    with Crowd(leaving) as crowd, Crowd(crowd.model) as other:
        assert repr(crowd) == "<Crowd of 20 people who walk, Trial 'leaving', at 0 s>"
        wanted = crowd.run(until=8.0, step=EXACT)
        # By hand, from a state in the middle, which another process could restore.
        middle = 256
        for _ in range(middle):
            other.step(EXACT)
        assert (other.poses() == wanted.poses[middle]).all() and other.time == 4.0
        assert other.left == (~wanted.active[middle]).sum() > 0
        state = pickle.loads(pickle.dumps(other.save()))
        crowd.reset()
        crowd.restore(state)
        on = crowd.run(until=8.0, step=EXACT)
        # What was seen within the step before is no part of a state.
        assert on.numbers[1:].tobytes() == wanted.numbers[middle + 1 :].tobytes()
        assert (on.poses[0] == wanted.poses[middle]).all() and (on.active == wanted.active[middle:]).all()
        assert crowd["decision.Arrived"] >= crowd.left > other.left
        crowd.reset({"decision.agent[*].DesiredSpeed": 0.4})
        assert crowd.run(until=1.0, step=EXACT).poses[-1].tobytes() != wanted.poses[64].tobytes()
        crowd.reset()
        assert crowd.run(until=8.0, step=EXACT).numbers.tobytes() == wanted.numbers.tobytes()
    with Crowd(leaving, decision=False) as still, pytest.raises(SimulationError, match="not a state of this Trial"):
        still.restore(state)


def test_a_run_ends_when_it_is_told_to(leaving):
    def half(crowd):
        return crowd.left >= 10

    with Crowd(leaving) as crowd:
        run = crowd.run(until=30.0, step=EXACT / 2, stop=half)
        assert run.ended == run.times[-1] == crowd.time < 30.0
        assert (~run.active[-1]).sum() >= 10 > (~run.active[-2]).sum()
        # To the last frame, as without an end; more frames than there was room for at first.
        whole = crowd.run(until="left", step=EXACT / 2)
        crowd.reset()
        at_once = crowd.run(until="left", step=EXACT / 2)
        assert at_once.ended == whole.ended == at_once.times[-1] and len(at_once.times) > 1024
        assert at_once.numbers.tobytes() == np.concatenate([run.numbers, whole.numbers[1:]]).tobytes()
        # All have left: no step more.
        again = crowd.run(until="left", step=EXACT / 2)
        assert len(again.times) == 1 and again.ended == at_once.ended
        crowd.reset()
        assert crowd.run(until=0.5, stop=lambda crowd: False).ended is None
        crowd.reset()
        assert crowd.run(until=0.5).ended is None
        with pytest.raises(ValueError, match="until='gone': must be a time"):
            crowd.run(until="gone")


def test_who_has_no_exit_does_not_keep_the_others(lemons, leaving, tmp_path):
    trial = shutil.copytree(leaving, tmp_path / "staying")
    decision = (trial / "decision.toml").read_text()
    stays = 'goals = [{ name = "stage", line = [[1.0, 1.0], [1.0, 2.0]] }]\n'
    (trial / "decision.toml").write_text(decision + stays + '[agents.3]\ngoal = "stage"\n')
    table = simulate(trial, until="left")
    same(table, written(lemons, tmp_path, trial, "--until", "left"))
    assert table["active"].iloc[-20:].sum() == 1
    (trial / "decision.toml").write_text("waypoints = [{ x = 1.0, y = 1.0 }]\n")
    for given in {}, {"decision": False}:
        with pytest.raises(SimulationError, match="until='left': nobody can leave"):
            simulate(trial, until="left", **given)


def test_what_cannot_be_meant_is_refused(leaving, pack, tmp_path):
    with pytest.raises(ValueError, match="is for a Trial: give the Trial instead of its FMU"):
        simulate(pack(leaving), until=0.1, decision=leaving / "decision.toml")
    with pytest.raises(TypeError, match="decision=5: must be None, False, or the path"):
        Crowd(leaving, decision=5)
    with pytest.raises(ValueError, match="the algorithm: unknown variant `euler`, expected `jacobi` or `gauss-seidel`"):
        Crowd(leaving, algorithm="euler")
    with pytest.raises(CommandError, match="nothing.toml"):
        Crowd(leaving, decision=tmp_path / "nothing.toml")
    for name in ("agent[3].Fp.x", "agent[*].Active", "decision.agent[3].Theta"):
        with pytest.raises(SimulationError, match="would be overwritten: (Decision|the crowd) feeds agent"):
            Crowd(leaving, {name: 0})
    with pytest.raises(SimulationError, match=r'did you mean "decision.agent\[3\].DesiredSpeed"'):
        Crowd(leaving, {"agent[3].DesiredSpeed": 1.0})
    with pytest.raises(SimulationError, match=".*agent.3..DesiredSpeed=-1.0"):
        Crowd(leaving, {"decision.agent[3].DesiredSpeed": -1.0})
    with Crowd(leaving) as crowd:
        with pytest.raises(SimulationError, match="Active is set by .*decision.toml"):
            crowd.active[3] = False
        assert crowd.active[:].all()
    # A dangling link is a decision.toml that cannot be read, and not none.
    trial = shutil.copytree(leaving, tmp_path / "dangling")
    (trial / "decision.toml").unlink()
    (trial / "decision.toml").symlink_to("nowhere")
    with pytest.raises(CommandError, match="decision.toml"):
        Crowd(trial)


def test_a_drive_is_added_to_how_people_walk(lemons, leaving, tmp_path):
    """That of the Trial, as in `lemons run`; and the same as a table, an array and a function, also step by step."""
    trial = shutil.copytree(leaving, tmp_path / "both")
    (trial / "drive.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,500,0,0\n1,0,500,0,0\n")
    pushed = simulate(trial, until=0.2)
    same(pushed, written(lemons, tmp_path, trial, "--until", "0.2"))
    alone = simulate(trial, False, until=0.2)
    same(alone, written(lemons, tmp_path, leaving, "--until", "0.2"))
    assert not pushed.equals(alone)
    constant = np.zeros((20, 3))
    constant[0, 0] = 500.0
    for drive in trial / "drive.csv", constant, lambda crowd: constant:
        assert simulate(leaving, drive, until=0.2).equals(pushed)
    with Crowd(leaving) as crowd:
        crowd.set_drive(constant)
        assert crowd.run(False, until=0.2).frame().equals(pushed)
    # Where nobody walks it is all that drives them.
    still = simulate(trial, until=0.2, decision=False)
    same(still, written(lemons, tmp_path, trial, "--until", "0.2", "--no-decision"))
    assert simulate(trial, constant, until=0.2, decision=False).equals(still) and (still["vx"] != 0).any()


def test_a_run_is_measured_as_by_the_command(lemons, leaving, tmp_path):
    """Without files, with the walls of its Trial: the numbers of `lemons measure TRIAL`, to the last bit."""
    asked = {"lines": {"door": (5, 1.5, 5, 2.5)}, "areas": {"front": (3, 1, 5, 3)}, "above": [500, 1000]}
    with Crowd(leaving) as crowd:
        run = crowd.run(until="left")
    seen = pickle.loads(pickle.dumps(run)).measure(**asked, window=2.0)
    words = ["--line", "door=5,1.5,5,2.5", "--area", "front=3,1,5,3", "--above", "500,1000", "--window", "2", "--until", "left"]
    subprocess.run([lemons, "measure", leaving, *words, "-o", tmp_path / "out"], check=True, capture_output=True)
    wanted = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert seen.summary.pop("source") == repr(run) and wanted.pop("source")
    assert seen.summary == wanted
    for name in ("flow", "gaps", "density", "people"):
        cells = pd.read_csv(tmp_path / "out" / f"{name}.csv", dtype=str, keep_default_na=False)
        mine = getattr(seen, name)
        assert list(mine) == list(cells) and len(mine) == len(cells) > 0
        for column in set(cells) - {"line", "direction", "area", "id"}:
            numbers = np.array([float(cell) if cell else np.nan for cell in cells[column]])
            assert np.array_equal(mine[column].to_numpy(dtype=float), numbers, equal_nan=True), (name, column)
    assert len(seen.passages("door", "right")) == 20 and seen.summary["exposure"] is not None
    # The walls matter, and are those of the Trial.
    front = seen.summary["areas"][0]["voronoi_density"]
    assert run.measure(areas=asked["areas"], trial=leaving).summary["areas"][0]["voronoi_density"] == front
    run.frame().to_csv(tmp_path / "run.csv", index=False)
    assert measure(tmp_path / "run.csv", areas=asked["areas"]).summary["areas"][0]["voronoi_density"] != front


def test_who_is_taken_out_does_not_move_until_back():
    with Crowd(TRIAL_DOOR, decision=False) as crowd, Crowd(TRIAL_DOOR, decision=False) as other:
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
    with Crowd(TRIAL_DOOR, {"agent[3].Active": False}, decision=False) as crowd:
        assert np.flatnonzero(~crowd.active[:]).tolist() == [3]
