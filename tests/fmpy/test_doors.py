"""Walls that open and close."""

import csv
import re
import subprocess
import tomllib
import xml.etree.ElementTree as ElementTree

import lemons_fmu
import numpy as np
import pytest
from crowd import bits, write_trial

FORCE, MASS, RATE = 120.0, 80.0, 2.0
WALL = [(2.0, -1.0), (2.0, 1.0)]


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def with_door(trial, opening):
    """The first wall of a Trial opens."""
    path = trial / "static/Geometry.xml"
    path.write_text(path.read_text().replace('<Wall Id="0"', f'<Wall Id="0" Open="{opening}"'))
    return trial


def leaning(directory, opening, others=()):
    """A disk that leans on a door with a constant force, and others."""
    first = {"mass": MASS, "x": 1.79, "fx": FORCE, "rate": RATE}
    return with_door(write_trial(directory, [first, *others], [WALL], damping=5000.0), opening)


def test_who_leans_on_a_door_goes_when_it_opens(tmp_path):
    """The outside: the closed form of the motion from rest under a force and the floor."""
    with lemons_fmu.Crowd(leaning(tmp_path / "T", "4,1e9")) as crowd:
        run = crowd.run(until=7.0)
    x, times = run.poses[:, 0, 0], run.times
    rest = x[np.searchsorted(times, 3.95)]
    assert rest == pytest.approx(1.8, abs=1e-3) and run.squeeze[np.searchsorted(times, 3.95), 0] == pytest.approx(FORCE, rel=1e-6)
    after = times >= 4.0 - 1e-9
    t = times[after] - 4.0
    speed = FORCE / MASS / RATE
    assert x[after] == pytest.approx(rest + speed * (t - (1.0 - np.exp(-RATE * t)) / RATE), abs=1e-9)
    assert (run.squeeze[after][1:] == 0.0).all()


def test_somebody_in_a_door_keeps_it_open(tmp_path):
    """It closes at 2 s for the second one, who comes when the first one has passed, who stood in it."""
    slow = {"mass": MASS, "x": 2.15, "fx": 1.0, "rate": 0.5, "y": -0.4}
    late = {"mass": MASS, "x": -1.0, "fx": 100.0, "rate": RATE, "y": 0.4}
    trial = with_door(write_trial(tmp_path / "T", [slow, late], [WALL], damping=500.0), "0,2")
    with lemons_fmu.Crowd(trial) as crowd:
        run = crowd.run(until=12.0)
    x = run.poses[:, :, 0]
    at = {t: np.searchsorted(run.times, t - 1e-9) for t in (2.0, 2.5, 12.0)}
    # Still in it, and not touched by it; then the door is closed.
    assert x[at[2.0], 0] < 2.2 and (run.squeeze[:, 0] == 0.0).all()
    assert x[at[12.0], 0] > 2.3 and x[at[12.0], 1] < 1.81 and run.squeeze[at[12.0], 1] > 90.0
    # Nobody is in it: it closes in time.
    alone = with_door(write_trial(tmp_path / "alone", [{**late, "x": 0.5}], [WALL], damping=500.0), "0,2")
    with lemons_fmu.Crowd(alone) as crowd:
        assert crowd.run(until=12.0).poses[-1, 0, 0] < 1.81


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_fmu_has_the_bits_of_the_run(lemons, tmp_path, version):
    slow = {"mass": MASS, "x": 2.15, "fx": 1.0, "rate": 0.5, "y": -0.4}
    trial = leaning(tmp_path / "T", "0,1 3,4", [slow])
    fmu = tmp_path / "T.fmu"
    subprocess.run([lemons, "pack", trial, "--fmi", version, "-o", fmu], check=True, capture_output=True)
    with lemons_fmu.Crowd(trial) as crowd:
        run = crowd.run(until=5.0)
    tables = [tmp_path / f"{name}.csv" for name in ("trial", "fmu")]
    for given, table in zip((trial, fmu), tables, strict=True):
        subprocess.run([lemons, "run", given, "--until", "5", "-o", table], check=True, capture_output=True)
    assert tables[0].read_bytes() == tables[1].read_bytes()
    assert len(run.times) == 51 and run.poses[-1, 0, 0] > 2.5


def test_a_state_in_which_a_door_waits_gives_the_same_bits(tmp_path, pack, instantiate):
    slow = {"mass": MASS, "x": 2.15, "fx": 1.0, "rate": 0.5, "y": -0.4}
    trial = leaning(tmp_path / "T", "0,1 3,4", [slow])
    with lemons_fmu.Crowd(trial) as crowd:
        run = crowd.run(until=5.0)
    # The door waits for the second one. A state of another instance, which never saw it open.
    fmu = instantiate(pack(trial)).initialize()
    fmu.run(15, 0.1)
    data = fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())
    wanted = bits(fmu.run(50, 0.1, first=15))
    other = instantiate(pack(trial))
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(data))
    other.time = fmu.time - 3.5
    assert bits(other.run(50, 0.1, first=15))[-1][1] == wanted[-1][1]
    assert [agent[:2] for agent in fmu.look()] == run.poses[-1, :, :2].tolist()
    with lemons_fmu.Crowd(trial) as crowd:
        begun = crowd.run(until=1.5)
        state = crowd.save()
        first = crowd.run(until=5.0)
        crowd.restore(state)
        again = crowd.run(until=5.0)
    assert begun.poses[-1, 1, 0] < 2.2
    assert (first.poses == again.poses).all()
    assert (again.poses[-1] == run.poses[-1]).all()


def table(lemons, trial, *options):
    """Rows of a run of one, by their times."""
    out = trial.with_suffix(".csv")
    subprocess.run([lemons, "run", trial, "-o", out, "--force", *options], check=True, capture_output=True)
    return [{name.split(" [")[0]: value for name, value in row.items()} for row in csv.DictReader(out.open())]


def test_nobody_was_exposed_to_a_door_that_is_open_at_the_start(lemons, tmp_path):
    trial = with_door(write_trial(tmp_path / "T", [{"mass": MASS, "x": 1.85}], [WALL]), "0,2")
    first = table(lemons, trial, "--until", "0.1")[0]
    for name in ("normal_force", "mean_normal_force", "peak_normal_force", "peak_overlap", "mean_wall_force"):
        assert float(first[name]) == 0.0, name


def test_pictures_have_the_forces_of_the_walls_that_were_there(lemons, tmp_path):
    """Somebody is in the door for all of the run; then it opens for somebody who leans on it, from 1 s on."""
    inside = with_door(write_trial(tmp_path / "in", [{"mass": MASS, "x": 2.05}], [WALL]), "0,1")
    before = leaning(tmp_path / "before", "1,2")

    def forces(trial, time):
        picture = trial.with_suffix(".svg")
        command = [lemons, "plot", trial, "--until", "3", "--at", str(time), "--forces", "-o", picture, "--force"]
        subprocess.run(command, check=True, capture_output=True)
        group = re.search(r'<g class="forces"[^>]*>(.*?)</g>', picture.read_text(), re.DOTALL)
        return len(re.findall(r"<(?:line|path)", group[1])) if group else 0

    assert [forces(inside, time) for time in (0, 0.5, 1, 2, 3)] == [0] * 5
    # Of several times, each has its own walls.
    for times, dashes in (("0.5,1.5", 1), ("1.5,0.5", 1), ("1.2,1.5", 2)):
        picture = before.with_suffix(".svg")
        subprocess.run([lemons, "plot", before, "--until", "3", "--at", times, "-o", picture, "--force"], check=True, capture_output=True)
        assert picture.read_text().count("<path stroke-dasharray") == dashes
    # What was seen at 1 s is the end of the step before.
    assert [forces(before, time) > 0 for time in (0.5, 1, 1.1, 1.5)] == [True, True, False, False]


def test_a_trial_at_the_end_of_a_run_has_what_is_still_to_come(lemons, tmp_path):
    trial = leaning(tmp_path / "T", "1,2 4,9")
    exits = "exits = [{ name = 'a', line = [[5, -9], [5, 9]], open = [[0, 2], [8, 9]] }, { name = 'b', line = [[-5, -9], [-5, 9]], open = [[0, 1]] }]"
    (trial / "decision.toml").write_text(f"{exits}\nstart = 7\n")
    run = tmp_path / "run.csv"
    subprocess.run([lemons, "run", trial, "--until", "5", "-o", run], check=True, capture_output=True)
    subprocess.run([lemons, "export", run, tmp_path / "next", "--to", "trial", "--trial", trial], check=True, capture_output=True)
    [wall] = ElementTree.parse(tmp_path / "next/static/Geometry.xml").findall("Wall")
    assert wall.get("Open") == "0.0,4.0"
    decision = tomllib.loads((tmp_path / "next/decision.toml").read_text())
    assert [exit["open"] for exit in decision["exits"]] == [[[3, 4]], [[1e9 - 1, 1e9]]]
    assert decision["agents"] == {"0": {"start": 2}} and "start" not in decision


def test_a_trial_at_the_end_of_a_run_waits_for_who_is_in_a_door(lemons, tmp_path):
    """It has closed for ever, but the wall is not there yet."""
    trial = with_door(write_trial(tmp_path / "T", [{"mass": MASS, "x": 2.05, "fx": 1.0, "rate": 0.5}], [WALL]), "0,1")
    run = tmp_path / "run.csv"
    subprocess.run([lemons, "run", trial, "--until", "2", "-o", run], check=True, capture_output=True)
    subprocess.run([lemons, "export", run, tmp_path / "next", "--to", "trial", "--trial", trial], check=True, capture_output=True)
    rows = table(lemons, tmp_path / "next", "--until", "1")
    assert 1.9 < float(rows[0]["x"]) < 2.2 and {float(row["peak_normal_force"]) for row in rows} == {0.0}


def test_a_trial_at_the_end_of_a_run_has_the_groups_and_the_motivation_of_the_run(lemons, tmp_path):
    people = [{"mass": MASS, "x": 1.5 * k, "y": 0.0} for k in range(6)]
    trial = write_trial(tmp_path / "T", people)
    motivation = "motivation = [{ time = 1, desired_speed = 0.5 }, { time = 5, desired_speed = 2 }]"
    exits = "exits = [{ line = [[50, -9], [50, 9]] }]\ngroups = { share = 1 }\nseed = 4\nstart = { min = 0, max = 9 }"
    (trial / "decision.toml").write_text(f"{exits}\n{motivation}\n")
    run = tmp_path / "run.csv"
    subprocess.run([lemons, "run", trial, "--until", "3", "-o", run], check=True, capture_output=True)
    subprocess.run([lemons, "export", run, tmp_path / "next", "--to", "trial", "--trial", trial], check=True, capture_output=True)
    decision = tomllib.loads((tmp_path / "next/decision.toml").read_text())
    groups = decision["groups"]["members"]
    # Who finds nobody walks alone.
    assert len(groups) > 0 and all(len(group) > 1 for group in groups) and "share" not in decision["groups"]
    agents = decision["agents"]
    assert all(len({agents[one]["start"] for one in group}) == 1 for group in groups)
    assert {agent["desired_speed"] for agent in agents.values()} == {0.5}
    assert decision["motivation"] == [{"time": 2, "desired_speed": 2}]
    # Who moves when is as if the run had gone on.
    whole = [table(lemons, trial, "--until", "9")[k::6] for k in range(6)]
    rest = [table(lemons, tmp_path / "next", "--until", "6")[k::6] for k in range(6)]

    def begins(rows, after):
        moving = [float(row["t"]) for row in rows if float(row["t"]) > after + 0.25 and abs(float(row["vx"])) > 0.2]
        return min(moving, default=np.inf) - after

    for one, other in zip(whole, rest, strict=True):
        was, now = begins(one, 3.0), begins(other, 0.0)
        assert was == now or was == pytest.approx(now, abs=0.35)


def test_times_are_those_of_a_simulation_that_starts_later(tmp_path, pack, instantiate, decide):
    """The door of 6 s opens 1 s after the start, and who starts at 6 s walks then."""
    trial = leaning(tmp_path / "T", "6,1e9")
    fmu = instantiate(pack(trial)).initialize(5.0)
    x = []
    for k in range(20):
        fmu.step_to(5.0 + (k + 1) * 0.1)
        x.append(fmu.look()[0][0])
    assert max(x[:10]) < 1.81 and x[-1] > 2.2
    (tmp_path / "later.toml").write_text("waypoints = [{ x = 9, y = 0 }]\nstart = 6\n")
    decision = instantiate(decide("--decision", tmp_path / "later.toml", trial=trial)).initialize(5.0)
    pushes = []
    for k in range(20):
        pushes.append(decision["agent[0].Fp.x"])
        decision.step_to(5.0 + (k + 1) * 0.1)
    assert pushes[:10] == [0.0] * 10 and min(pushes[10:]) > 100.0


def test_a_door_that_can_never_open_is_doubted(lemons, tmp_path):
    for opening, doubted in (("0.05,0.08", True), ("0,0.1", False), ("0,1e-10", True)):
        done = subprocess.run([lemons, "check", leaning(tmp_path / opening, opening)], check=True, capture_output=True, text=True)
        assert ("it may never be open" in " ".join((done.stdout + done.stderr).split())) == doubted, opening


def test_nobody_is_placed_across_a_door_within_a_room(lemons, tmp_path):
    outline = "".join(f'<Corner Coordinates="{x},{y}"/>' for x, y in [(0, 0), (6, 0), (6, 4), (0, 4), (0, 0)])
    door = '<Corner Coordinates="3,0"/><Corner Coordinates="3,4"/>'
    walls = f'<Wall Id="0" MaterialId="concrete">{outline}</Wall><Wall Id="1" MaterialId="concrete" Open="20,60">{door}</Wall>'
    (tmp_path / "room.xml").write_text(f'<?xml version="1.0"?><Geometry>{walls}</Geometry>')
    command = [lemons, "crowd", "--geometry", "room.xml", "-n", "60", "-o", "T", "--seed", "1"]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)
    done = subprocess.run([lemons, "check", "T"], check=True, capture_output=True, text=True, cwd=tmp_path)
    assert "overlap" not in done.stdout + done.stderr
    # Two doors in one place.
    command = [lemons, "crowd", "-n", "5", "--box", "8x5", "-o", "twice", "--door", "8,2,2", "--door", "8,3,2,20,60"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1 and "doors 0 and 1 overlap" in done.stderr
    assert subprocess.run([*command[:-2], "--door", "8,4,1.5,20,60"], capture_output=True, cwd=tmp_path).returncode == 0


def test_people_go_on_out_of_a_door_that_closes(lemons, tmp_path):
    """Nobody stands in it, and then nobody comes through."""
    command = [lemons, "crowd", "-n", "40", "--box", "8x5", "--leave", "--seed", "1", "--door", "8,2.5,1.2,0,6.5", "-o", "T"]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)
    with lemons_fmu.Crowd(tmp_path / "T") as crowd:
        run = crowd.run(until=20.0)
    x = np.where(run.active, run.poses[:, :, 0], np.inf)
    beyond = (x > 8.0).sum(axis=1)
    at = {t: np.searchsorted(run.times, t - 1e-9) for t in (6.5, 8.5, 20.0)}
    assert 5 < beyond[at[6.5]] < 35
    # Who was in it leaves it in two seconds; then it is closed.
    assert beyond[at[8.5]] == beyond[at[20.0]] <= beyond[at[6.5]] + 3
    assert (np.abs(x[at[8.5] :] - 8.0) > 0.1).all()


@pytest.mark.parametrize("opening", ["", "5", "5,4", "0,4 3,5", "-1,4", "0,2e9", "0,nan"])
def test_times_that_cannot_be_are_named(lemons, tmp_path, opening):
    trial = leaning(tmp_path / "T", opening)
    done = subprocess.run([lemons, "check", trial], capture_output=True, text=True)
    assert done.returncode != 0
    assert 'Geometry.xml' in done.stderr + done.stdout
    assert f'Open="{opening}"' in done.stderr + done.stdout or f"{opening!r}" in done.stderr + done.stdout, done.stderr + done.stdout
    assert "must be at most 1000 pairs of from and to in s, from 0 to 1e9" in done.stderr + done.stdout


def test_people_wait_in_front_of_a_door_and_leave_when_it_opens(lemons, tmp_path):
    """Also beside a room with the same door that is always open."""
    command = [lemons, "crowd", "-n", "40", "--box", "8x5", "--leave", "--seed", "1"]
    subprocess.run([*command, "--door", "8,2.5,1.2,10,1e9", "-o", "T"], check=True, capture_output=True, cwd=tmp_path)
    subprocess.run([*command, "--door", "8,2.5,1.2", "-o", "open"], check=True, capture_output=True, cwd=tmp_path)
    walls = ElementTree.parse(tmp_path / "T/static/Geometry.xml").findall("Wall")
    assert [wall.get("Open") for wall in walls] == [None, "10.0,1000000000.0"]
    corners = [list(map(float, corner.get("Coordinates").split(","))) for corner in walls[1]]
    assert np.array(corners) == pytest.approx(np.array([[8.0, 1.9], [8.0, 3.1]]))
    with lemons_fmu.Crowd(tmp_path / "T") as crowd:
        run = crowd.run(until="left", step=0.1)
    with lemons_fmu.Crowd(tmp_path / "open") as crowd:
        free = crowd.run(until="left", step=0.1)
    waits = run.times <= 10.0
    assert run.active[waits].all() and (run.poses[waits][:, :, 0] < 8.0).all()
    # The nearest ones stand before it, and nobody is squeezed.
    ends = np.searchsorted(run.times, 9.95)
    assert 7.2 < run.poses[ends, :, 0].max() < 7.9
    assert not run.active[-1].any() and not free.active[-1].any()
    # They have come closer meanwhile.
    assert free.times[-1] < run.times[-1] < free.times[-1] + 12.0
    # Open, it is dashed.
    for time, dashes in ((9.9, 0), (12, 1)):
        picture = subprocess.run([lemons, "plot", "T", "--until", str(time), "--at", str(time), "-o", "p.svg"], capture_output=True, text=True, cwd=tmp_path)
        assert picture.returncode == 0, picture.stderr
        assert (tmp_path / "p.svg").read_text().count("<path stroke-dasharray") == dashes
        (tmp_path / "p.svg").unlink()
