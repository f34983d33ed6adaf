"""People who come later, and exits that close after some people: command, FMUs, Python and saved runs."""

import os
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree

import lemons_fmu
import pages
import numpy as np
import pandas as pd
import pytest
from crowd import REPOSITORY
from fmpy import read_model_description

SCENARIO = REPOSITORY / "crates/scenario/tests/crowds/sources.toml"
#: People of it who are there at the start, and the times of those of the train.
THERE, TRAIN = 6, [4.0, 4.0, 4.0, 4.5, 20.0]
STEP = 0.01


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def call(lemons, directory, *arguments, code=0):
    done = subprocess.run([lemons, *map(str, arguments)], cwd=directory, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def table_of(path):
    seen = pd.read_csv(path, comment="#")
    return seen.pivot(index="t", columns="id")


def bodies(trial):
    """Mass, and disks when the gaze is along x, of each agent; poses and velocities at the start."""
    shapes = {}
    for agent in ElementTree.parse(trial / "static/Agents.xml").getroot():
        disks = [(float(shape.get("Radius")), *map(float, shape.get("Position").split(","))) for shape in agent.iter("Shape")]
        (_, xa, ya), (_, xb, yb) = disks[0], disks[-1]
        # The orientation that the shapes themselves define.
        turn = np.arctan2(yb - ya, xb - xa) + np.pi / 2 if len(disks) > 1 else 0.0
        rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        shapes[int(agent.get("Id"))] = [(radius, rotation @ np.array([x, y])) for radius, x, y in disks]
    return shapes


def test_people_come_at_their_time_at_a_walk_and_touch_nobody(lemons, tmp_path):
    """The outside: the times of the file; the desired speeds; a count of who is where; outlines, computed here."""
    call(lemons, tmp_path, "crowd", "--scenario", SCENARIO, "-o", "T")
    said = call(lemons, tmp_path, "check", "T")
    assert "no problem" in said and "overlap" not in said
    told = call(lemons, tmp_path, "run", "T", "--until", "left", "-o", "run.csv")
    assert "left                       23     (of 23 people" in told and "not come yet" not in told
    seen = table_of(tmp_path / "run.csv")
    active, times = seen["active"].to_numpy() == 1, seen.index.to_numpy()
    first = active.argmax(axis=0)
    assert (first[:THERE] == 0).all() and not active[0, THERE:].any() and active.any(axis=0).all()
    # Nobody comes twice, and who has left stays away: appeared = present + left at each time.
    appeared = np.maximum.accumulate(active, axis=0)
    gone = np.array([[not active[k:, i].any() for i in range(active.shape[1])] for k in range(len(active))])
    assert (appeared.sum(axis=1) == active.sum(axis=1) + (appeared & gone).sum(axis=1)).all()
    # The first row of somebody is at the end of the first step.
    came = np.sort(times[first[-5:]]) - STEP
    assert came == pytest.approx(TRAIN, abs=1e-9)
    decision = tomllib.loads((tmp_path / "T/decision.toml").read_text())
    starts = ElementTree.parse(tmp_path / "T/dynamic/AgentDynamics.xml").getroot()
    shapes = bodies(tmp_path / "T")
    x, y, theta = (seen[name].to_numpy() for name in ("x", "y", "theta"))
    for agent in starts:
        i = int(agent.get("Id"))
        assert (agent.get("Active") == "false") == (i >= THERE)
        if i < THERE:
            continue
        vx, vy = map(float, agent.find("Kinematics").get("Velocity").split(","))
        speed = decision["agents"].get(str(i), {}).get("desired_speed", decision["desired_speed"])
        assert np.hypot(vx, vy) == pytest.approx(speed, rel=1e-12)
        before = first[i] - 1
        # A step later it is where this velocity leads, up to what another one in front changes.
        way = np.hypot(x[first[i], i] - x[before, i], y[first[i], i] - y[before, i])
        assert way == pytest.approx(speed * STEP, rel=0.03)

        def placed(k, row):
            turn = np.array([[np.cos(theta[row, k]), -np.sin(theta[row, k])], [np.sin(theta[row, k]), np.cos(theta[row, k])]])
            return [(radius, np.array([x[row, k], y[row, k]]) + turn @ at) for radius, at in shapes[k]]

        others = [k for k in range(active.shape[1]) if k != i and active[before, k] and not gone[first[i], k]]
        others += [k for k in range(THERE, active.shape[1]) if first[k] == first[i] and k != i]
        for k in others:
            gap = min(np.hypot(*(a - b)) - r - s for r, a in placed(i, before) for s, b in placed(k, before))
            assert gap > 0.0, (i, k, times[before])
        assert seen["peak_overlap"].to_numpy()[first[i], i] < 1e-3


def test_command_fmus_python_and_a_saved_run_have_the_same_bits(lemons, tmp_path):
    call(lemons, tmp_path, "crowd", "--scenario", SCENARIO, "-o", "T")
    call(lemons, tmp_path, "run", "T", "--until", "12", "-o", "run.csv")
    rows = lambda name: [line for line in (tmp_path / name).read_text().splitlines() if not line.startswith("#")]
    call(lemons, tmp_path, "pack", "T", "-o", "crowd.fmu")
    call(lemons, tmp_path, "decide", "T", "-o", "decision.fmu")
    call(lemons, tmp_path, "connect", "decision.fmu", "crowd.fmu", "-o", "both.ssp")
    told = call(lemons, tmp_path, "run", "both.ssp", "--until", "12", "-o", "both.csv")
    assert rows("both.csv") == rows("run.csv") and "not come yet" in told
    # Saved while some are still outside.
    for model in ("T", "both.ssp"):
        call(lemons, tmp_path, "run", model, "--until", "5", "-o", "first.csv", "--state", "half.run", "--force")
        told = call(lemons, tmp_path, "run", model, "--resume", "half.run", "--until", "12", "-o", "second.csv", "--force")
        assert rows("first.csv") + rows("second.csv")[1:] == rows("run.csv"), model
        assert "not come yet" in told
    with lemons_fmu.Crowd(tmp_path / "T") as crowd:
        run = crowd.run(until=12.0)
    seen = table_of(tmp_path / "run.csv")
    assert (run.active == (seen["active"].to_numpy() == 1)).all()
    assert (run.poses[:, :, 0] == seen["x"].to_numpy()).all() and (run.poses[:, :, 1] == seen["y"].to_numpy()).all()
    # The crowd alone: those who come later are not there, and nothing overlaps.
    starts = {v.name: v.start for v in read_model_description(str(tmp_path / "crowd.fmu")).modelVariables if v.name.endswith(".Active")}
    assert [starts[f"agent[{i}].Active"] for i in range(23)] == ["true"] * THERE + ["false"] * 17
    told = call(lemons, tmp_path, "run", "crowd.fmu", "--until", "0.1", "-o", "alone.csv")
    assert "largest overlap         0.000 mm" in told


def test_a_trial_that_goes_on_has_those_who_come_later(lemons, tmp_path):
    call(lemons, tmp_path, "crowd", "--scenario", SCENARIO, "-o", "T")
    call(lemons, tmp_path, "run", "T", "--until", "5", "-o", "run.csv")
    seen = table_of(tmp_path / "run.csv")["active"].iloc[-1]
    call(lemons, tmp_path, "export", "run.csv", "later", "--to", "trial", "--trial", "T")
    later = tomllib.loads((tmp_path / "later/decision.toml").read_text())["sources"]
    outside = [agent.get("Id") for agent in ElementTree.parse(tmp_path / "later/dynamic/AgentDynamics.xml").getroot() if agent.get("Active")]
    assert sorted(id for source in later for id in source["people"]) == sorted(outside) and 1 < len(outside) < 17
    assert later[-1]["name"] == "train" and later[-1]["times"] == [15.0] and not seen[int(outside[-1])]
    told = call(lemons, tmp_path, "run", "later", "--until", "left", "-o", "later.csv")
    people = len(list(ElementTree.parse(tmp_path / "later/static/Agents.xml").getroot()))
    assert f"(of {people} people" in told and re.search(rf"left +{people} ", told)


def test_who_comes_later_has_not_left_also_where_the_trial_does_not_say_so(lemons, tmp_path):
    call(lemons, tmp_path, "crowd", "--scenario", SCENARIO, "-o", "T")
    dynamics = tmp_path / "T/dynamic/AgentDynamics.xml"
    assert ' Active="false"' in dynamics.read_text()
    dynamics.write_text(dynamics.read_text().replace(' Active="false"', ""))
    call(lemons, tmp_path, "run", "T", "--until", "5", "-o", "run.csv")
    active = table_of(tmp_path / "run.csv")["active"].to_numpy() == 1
    left = (active.any(axis=0) & ~active[-1]).sum()
    for measured in (["T", "--until", "5"], ["run.csv", "--trial", "T"]):
        assert re.search(rf"left +{left} of 23 people", call(lemons, tmp_path, "measure", *measured))


def test_who_finds_no_room_waits_outside_and_it_is_said(lemons, tmp_path):
    """Forty people are due in two seconds where three fit at once, in front of a door that shuts after 25."""
    (tmp_path / "s.toml").write_text(
        'box = [6.0, 4.0]\ndoors = [[6.0, 2.0, 1.0]]\nleave = true\ntime_step = 0.05\n'
        '[[sources]]\nname = "hall"\nline = [[1.0, 1.5], [1.0, 2.5]]\nevery = 0.05\nnumber = 40\n'
    )
    call(lemons, tmp_path, "crowd", "--scenario", "s.toml", "-o", "T")
    path = tmp_path / "T/decision.toml"
    text = path.read_text().replace('{ name = "door 0"', '{ most = 25, name = "door 0"')
    path.write_text(text)
    told = call(lemons, tmp_path, "run", "T", "--until", "60", "-o", "run.csv")
    assert 'source "hall": ' in told and "people found no room when they were due, and waited outside, for up to" in told
    assert "left                       25     (of 40 people" in told
    seen = table_of(tmp_path / "run.csv")
    active = seen["active"].to_numpy() == 1
    due = np.clip(np.floor(seen.index.to_numpy() / 0.05 + 1e-6) + 1, 0, 40)
    assert (np.maximum.accumulate(active, axis=0).sum(axis=1) <= due).all()
    # Never more than 25 have left; the others are there, before the exit.
    left = np.maximum.accumulate(active, axis=0).sum(axis=1) - active.sum(axis=1)
    assert left.max() == 25 and (np.diff(left) >= 0).all() and active[-1].sum() == 15
    # In a Trial that goes on, those who have left count.
    part = (left >= 10).argmax()
    then = left[part]
    call(lemons, tmp_path, "run", "T", "--until", seen.index[part], "-o", "part.csv")
    call(lemons, tmp_path, "export", "part.csv", "later", "--to", "trial", "--trial", "T")
    assert tomllib.loads((tmp_path / "later/decision.toml").read_text())["exits"][0]["most"] == 25 - then
    told = call(lemons, tmp_path, "run", "later", "--until", "60", "-o", "later.csv")
    assert re.search(rf"left +{25 - then} +\(of {40 - then} people", told)


def test_a_train_lets_out_and_in(lemons, tmp_path):
    """The first train of docs/scenes.md: the script checks that who has come is there or has left, and each door's limit."""
    command = [sys.executable, REPOSITORY / "examples/trains.py", tmp_path, "--seeds", "1", "--until", "170"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, "LEMONS": str(lemons)})
    shown = pages.text_of("docs/scenes.md").split("seed 1\n", 1)[1].splitlines()[0]
    assert shown in done.stdout.splitlines(), done.stdout
    assert re.fullmatch(r" *166 s +28 +36 +36 .*", shown)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("rate = 1e300", "source 0: rate = 1e300: must be from 1e-6 to 1000 people per s"),
        ("rate = 0.0", "source 0: rate = 0.0: must be"),
        ("rate = -1.0", "source 0: rate = -1.0: must be"),
        ("rate = nan", "source 0: rate = NaN: must be"),
        ("times = [3.0, 2.0, 4.0]", "source 0: times = [3.0, 2.0]: must be in order"),
        ("rate = 1\nnumber = 4000000000", "source 0: number"),
        ("rate = 1\nnumber = 0", "source 0: number"),
        ("rate = 1\nline = [[7, 7], [8, 7]]", "source 0: it has no place, inside a box of 6 m x 4 m and"),
        ("rate = 1\nline = [[0, 0], [6, 0]]", "source 0: it has no place"),
        ("rate = 1\npolygon = [[1, 1], [2, 1]]", "source 0: give a line of two points, or a polygon"),
        ("rate = 1\nmix = { dragon = 1 }", "dragon"),
        ("rate = 1\ngoal = \"stage\"", "there is no goal with this name"),
        ("rate = 1\nname = \"a\"\n[[sources]]\nname = \"a\"\nline = [[1, 1], [1, 2]]\nnumber = 1\nrate = 1", "the name \"a\" is that of another source"),
    ],
)
def test_what_cannot_be_is_told(lemons, tmp_path, source, said):
    line = "" if "line" in source.split("[[")[0] or "polygon" in source else "line = [[1.0, 1.5], [1.0, 2.5]]\n"
    number = "" if "number" in source.split("[[sources")[0] else "number = 3\n"
    text = f"box = [6.0, 4.0]\nnumber = 2\ndoors = [[6.0, 2.0, 1.0]]\nleave = true\n[[sources]]\n{line}{number}{source}\n"
    (tmp_path / "s.toml").write_text(text)
    told = call(lemons, tmp_path, "crowd", "--scenario", "s.toml", "-o", "T", code=1)
    assert said in told and not (tmp_path / "T").exists(), told


def test_a_state_between_coming_and_the_step_keeps_the_walk(lemons, tmp_path, pack, instantiate):
    """The outside: the same step without the state between. The last one comes at a walk, after a step outside."""
    call(lemons, tmp_path, "crowd", "--scenario", SCENARIO, "-o", "T")
    ended = []
    for saves in (False, True):
        fmu = instantiate(pack(tmp_path / "T")).initialize()
        last = len(bodies(tmp_path / "T")) - 1
        fmu.step(STEP)
        fmu[f"agent[{last}].Active"] = True
        if saves:
            data = fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())
            fmu = instantiate(pack(tmp_path / "T"))
            fmu.time = STEP
            fmu.fmu.setFMUstate(fmu.fmu.deSerializeFMUstate(data))
        fmu.step(STEP)
        ended.append((fmu[f"agent[{last}].Velocity.x"], fmu[f"agent[{last}].Velocity.y"]))
    assert ended[0] == ended[1] and np.hypot(*ended[0]) > 0.5
