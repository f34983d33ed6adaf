"""Doors and exits that an importer shuts."""

import subprocess

import lemons_fmu
import numpy as np
import pytest
from test_doors import MASS, RATE, leaning

#: [s]
SHUTS, STEP = 1.5, 0.1
HALL = ["-n", "30", "--box", "8x5", "--leave", "--seed", "1", "--door", "8,2.5,1.2", "--door", "0,2.5,1.2"]


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def run_with(crowd, operated, until):
    """Poses and who is there at each step; `operated` are times, names and whether it is open then."""
    seen = []
    for k in range(round(until / STEP)):
        for time, name, is_open in operated:
            if abs(time - k * STEP) < STEP / 2:
                crowd.set_open(name, is_open)
        crowd.step_to((k + 1) * STEP)
        seen.append((crowd.poses(), np.array(crowd.active)))
    return seen


def same(one, other):
    return all((a[0] == b[0]).all() and (a[1] == b[1]).all() for a, b in zip(one, other, strict=True))


def test_a_door_that_is_shut_is_one_that_closes(lemons, tmp_path, pack, instantiate):
    """The outside: the same door with times. Somebody stands in it, and keeps it open for a while."""
    others = [{"mass": MASS, "x": 1.85, "fx": 20.0, "rate": 0.5, "y": -0.5}, {"mass": MASS, "x": -0.5, "fx": 150.0, "rate": RATE, "y": 0.5}]
    with lemons_fmu.Crowd(leaning(tmp_path / "closes", f"0,{SHUTS} 4,1e9", others)) as crowd:
        wanted = run_with(crowd, [], 6.0)
    always = leaning(tmp_path / "always", "0,1e9", others)
    with lemons_fmu.Crowd(always) as crowd:
        assert same(run_with(crowd, [(SHUTS, "door[0]", False), (4.0, "door[0]", True)], 6.0), wanted)
        with pytest.raises(lemons_fmu.SimulationError, match=r"door\[1\]"):
            crowd.set_open("door[1]", False)
        crowd.reset()
        assert not same(run_with(crowd, [], 6.0), wanted)
    fmu = instantiate(pack(always)).initialize()
    assert fmu["door[0].Open"]
    fmu.run(15, STEP)
    fmu["door[0].Open"] = False
    fmu.run(35, STEP, first=15)
    # Another instance that has never seen it open: it is shut, and waits for somebody.
    other = instantiate(fmu.directory)
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())))
    other.time = fmu.time
    assert not other["door[0].Open"]
    other.run(40, STEP, first=35)
    other["door[0].Open"] = True
    other.run(60, STEP, first=40)
    assert [agent[:2] for agent in other.look()] == wanted[-1][0][:, :2].tolist()


def test_who_finds_an_exit_shut_takes_another_one(lemons, tmp_path):
    """The outside: where they leave, and that they wait if all are shut."""
    subprocess.run([lemons, "crowd", *HALL, "-o", "T"], check=True, capture_output=True, cwd=tmp_path)

    def leave(operated, until):
        """How many are there after each step, and x of those who left after 2 s where they did."""
        with lemons_fmu.Crowd(tmp_path / "T") as crowd:
            seen = run_with(crowd, operated, until)
        poses, active = seen[-1]
        assert not active.any()
        return [there.sum() for _, there in seen], poses[seen[19][1], 0]

    _, free = leave([], 20.0)
    assert (free > 7.5).sum() > 5 and (free < 0.5).sum() > 5
    _, left = leave([(2.0, "exit[0]", False)], 40.0)
    _, right = leave([(2.0, "exit[1]", False)], 40.0)
    assert len(left) == len(right) == len(free) > 10
    assert {(left < 0.5).all(), (right < 0.5).all()} == {(left > 7.5).all(), (right > 7.5).all()} == {True, False}
    counts, _ = leave([(2.0, "exit[0]", False), (2.0, "exit[1]", False), (15.0, "exit[0]", True)], 45.0)
    assert counts[19] == counts[149] > 10


def test_what_is_opened_again_before_a_step_was_never_shut(lemons, tmp_path, decide, instantiate):
    """All of the state is the same."""
    subprocess.run([lemons, "crowd", *HALL, "-o", "T"], check=True, capture_output=True, cwd=tmp_path)
    path = decide(trial=tmp_path / "T")
    states = []
    for toggles in (False, True):
        decision = instantiate(path).initialize()
        for _ in range(10):
            decision["agent[0].Velocity.x"] = 0.1
            for is_open in (False, True) * toggles:
                decision["exit[0].Open"] = is_open
                assert np.isfinite(decision["agent[0].Fp.x"])
            decision.step(STEP)
        states.append(bytes(decision.fmu.serializeFMUstate(decision.fmu.getFMUstate())))
    assert states[0] == states[1]


def test_a_state_knows_what_is_shut(lemons, tmp_path):
    subprocess.run([lemons, "crowd", *HALL, "-o", "T"], check=True, capture_output=True, cwd=tmp_path)
    with lemons_fmu.Crowd(tmp_path / "T") as crowd:
        run_with(crowd, [(1.0, "exit[0]", False)], 2.0)
        crowd.set_open("exit[1]", False)
        state = crowd.save()
        crowd.step_to(4.0)
        wanted = crowd.poses()
    with lemons_fmu.Crowd(tmp_path / "T") as other:
        other.restore(state)
        other.step_to(4.0)
        assert (other.poses() == wanted).all()
        other.reset()
        other.step_to(2.0)
        again = other.poses()
    with lemons_fmu.Crowd(tmp_path / "T") as fresh:
        fresh.step_to(2.0)
        assert (fresh.poses() == again).all()


def test_pictures_show_a_door_that_an_input_keeps_shut(lemons, tmp_path):
    always = leaning(tmp_path / "T", "0,1e9")
    shut = ["--set", "door[0].Open=false"]
    subprocess.run([lemons, "run", always, *shut, "--until", "1", "-o", tmp_path / "t.csv"], check=True, capture_output=True)
    made, table = [always, "--until", "1"], [tmp_path / "t.csv", "--trial", always]
    for source, dashes in ((made, 1), ([*made, *shut], 0), (table, 1), ([*table, *shut], 0)):
        picture = tmp_path / "p.svg"
        subprocess.run([lemons, "plot", *source, "--at", "1", "-o", picture, "--force"], check=True, capture_output=True)
        assert picture.read_text().count("<path stroke-dasharray") == dashes
