"""Sweeps of people who walk: over several Trials, with the measures of `lemons measure`; resumed, and refused when they changed."""

import json
import shutil
import subprocess
import sys

import cloudpickle
import numpy as np
import pandas as pd
import pytest
from distributed import Client
from lemons_fmu import CommandError, Crowd, SimulationError, SweepError, local_cluster, sweep

# Workers of a cluster need not have this file.
cloudpickle.register_pickle_by_value(sys.modules[__name__])

GRID = {"width": [0.9, 1.2], "seed": [1, 2]}
RUN = {"until": "left", "progress": False}
DOOR = (5.0, 1.0, 5.0, 3.0)


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


@pytest.fixture(scope="module")
def rooms(lemons, tmp_path_factory):
    """A directory with four Trials: ten people who leave a room by a door."""
    place = tmp_path_factory.mktemp("rooms")
    for width in GRID["width"]:
        for seed in GRID["seed"]:
            options = f"--number 10 --box 5x4 --door 5,2,{width} --leave --seed {seed}".split()
            subprocess.run([lemons, "crowd", *options, "-o", place / f"room_{width}_{seed}"], check=True, capture_output=True)
    return place


@pytest.fixture(scope="module")
def here():
    """A client with two threads of this process."""
    with local_cluster(1, threads=2, processes=False) as cluster, Client(cluster) as client:
        yield client


def measure(run):
    seen = run.measure(lines={"door": DOOR}, above=[300])
    right = seen.direction("door", "right")
    pressed = seen.people["largest_mean_1"].max()
    return {"flow": right["flow"], "evacuation": right["evacuation_time"], "pressed": pressed, "above": seen.people["time_above_300"].sum()}


def left(run):
    return {"left": (~run.active[-1]).sum()}


@pytest.fixture(scope="module")
def wanted(lemons, rooms):
    """Of each Trial what the command says: `lemons measure`, and when `lemons run --until left` ends."""
    rows = []
    for width in GRID["width"]:
        for seed in GRID["seed"]:
            room, out = rooms / f"room_{width}_{seed}", rooms / "out"
            line = f"door={','.join(map(str, DOOR))}"
            words = [lemons, "measure", room, "--until", "left", "--line", line, "--above", "300", "-o", out, "--force"]
            subprocess.run(words, check=True, capture_output=True)
            summary = json.loads((out / "summary.json").read_text())
            right = summary["lines"][0]["directions"][0]
            people = pd.read_csv(out / "people.csv", dtype=str)
            pressed, above = (people[name].map(float) for name in ("largest_mean_1", "time_above_300"))
            run = [lemons, "run", room, "--until", "left", "-o", rooms / "run.csv", "--outputs", rooms / "outputs.csv", "--force"]
            subprocess.run(run, check=True, capture_output=True)
            ended = float((rooms / "run.csv").read_text().splitlines()[-1].split(",")[0])
            rows.append((width, seed, right["flow"], right["evacuation_time"], pressed.max(), above.sum(), ended))
    names = [*GRID, "flow", "evacuation", "pressed", "above", "ended"]
    return pd.DataFrame(rows, columns=names)


def test_trials_are_measured_as_by_the_command(lemons, rooms, wanted, tmp_path):
    """On worker processes; and the table of `lemons sweep` of the same Trials."""
    with local_cluster(2) as cluster, Client(cluster) as client:
        table = sweep(rooms / "room_{width}_{seed}", GRID, None, measure, out=tmp_path / "out.csv", client=client, **RUN)
    assert table["status"].tolist() == ["ok"] * 4, table["error"].tolist()
    pd.testing.assert_frame_equal(table[list(wanted)], wanted, check_exact=True)
    assert list(table) == ["point", *wanted, "status", "error"]
    assert table["flow"].nunique() == 4 and (table["ended"] < 60).all() and (table["above"] > 0).any()
    (rooms / "study.toml").write_text(
        'trial = "room_{width}_{seed}"\nuntil = 600.0\nstop = { of = "decision.Arrived", at_least = 10 }\n'
        "[parameters]\nwidth = [0.9, 1.2]\nseed = [1, 2]\n"
        '[measures]\nlast = { of = "decision.Arrived", take = "first_at_least", level = 10 }\n'
    )
    subprocess.run([lemons, "sweep", "study.toml", "-o", tmp_path / "study.csv"], cwd=rooms, check=True, capture_output=True)
    theirs = pd.read_csv(tmp_path / "study.csv", comment="#")
    # With Jacobi's algorithm the crowd hears of it a step later.
    assert np.allclose(table["ended"] - theirs["last"], 0.01, rtol=1e-9)


def test_one_trial_many_parameters(rooms, here, tmp_path):
    """Parameters of both FMUs; other files like decision.toml by name; the point that is never over says so."""
    room = rooms / "room_1.2_1"
    grid = {"decision.agent[*].DesiredSpeed": [1.0, 1.4], "agent[*].Mass": [60.0, -1.0]}
    table = sweep(room, grid, None, left, client=here, out=tmp_path / "one.csv", **RUN)
    assert table["status"].tolist() == ["ok", "failed"] * 2 and "agent[0].Mass=-1.0: must be positive" in table["error"][1]
    for point in (0, 2):
        with Crowd(room, {name: table[name][point] for name in grid}) as crowd:
            assert crowd.run(until="left").ended == table["ended"][point]
    assert table["ended"][0] > table["ended"][2] and (table["left"][[0, 2]] == 10).all()
    told = json.loads((tmp_path / "one.csv").read_text().splitlines()[0].removeprefix("# lemons sweep "))
    assert len(told["decision"]) == 32 and told["algorithm"] == "Jacobi" and told["until"] == "left"

    away = 'exits = [{ name = "far", line = [[6.0, 0.5], [6.0, 3.5]] }]\n'
    for name, text in {"near": away, "slow": f"desired_speed = 0.5\n{away}"}.items():
        (tmp_path / f"{name}.toml").write_text(text)
    options = {**RUN, "until": 4.0, "stop": lambda crowd: crowd.left >= 3, "algorithm": "gauss-seidel"}
    table = sweep(room, {"case": ["near", "slow"]}, None, left, decision=tmp_path / "{case}.toml", client=here, **options)
    assert table["left"][0] >= 3 and table["ended"][0] < 4.0 and table["ended"].isna().tolist() == [False, True]
    with Crowd(room, decision=tmp_path / "near.toml", algorithm="gauss-seidel") as crowd:
        assert crowd.run(until=4.0, stop=lambda crowd: crowd.left >= 3).ended == table["ended"][0]


def test_a_sweep_of_other_trials_or_decisions_does_not_go_on(rooms, here, tmp_path):
    for width in GRID["width"]:
        shutil.copytree(rooms / f"room_{width}_1", tmp_path / f"room_{width}")
    several, one = tmp_path / "room_{width}", tmp_path / "room_0.9"
    options = {"client": here, **RUN, "until": 0.2}

    def both():
        grid = {"width": GRID["width"]}
        return (
            sweep(several, grid, None, left, out=tmp_path / "several.csv", **options),
            sweep(one, {"agent[*].Mass": [60.0]}, None, left, out=tmp_path / "one.csv", **options),
        )

    before = both()
    decision = one / "decision.toml"
    text = decision.read_text()
    decision.write_text("# Who wrote it, and when, makes no other decision.\n" + text)
    for table, again in zip(before, both()):
        pd.testing.assert_frame_equal(again, table, check_exact=True)
    decision.write_text(text.replace("1.34", "1.2"))
    for what, grid, out, differs in [
        (several, {"width": GRID["width"]}, "several", "models"),
        (one, {"agent[*].Mass": [60.0]}, "one", "decision"),
    ]:
        with pytest.raises(SweepError, match=f"table of another sweep: it differs in {differs};"):
            sweep(what, grid, None, left, out=tmp_path / f"{out}.csv", **options)
    decision.write_text(text)
    with pytest.raises(SweepError, match="differs in algorithm"):
        sweep(one, {"agent[*].Mass": [60.0]}, None, left, out=tmp_path / "one.csv", algorithm="gauss-seidel", **options)
    # Where nobody walks; and where points end by a condition.
    with pytest.raises(SweepError, match="differs in stop;"):
        sweep(one, {"agent[*].Mass": [60.0]}, None, left, out=tmp_path / "one.csv", stop=lambda crowd: True, **options)
    with pytest.raises(SweepError, match="differs in algorithm, decision"):
        sweep(one, {"agent[*].Mass": [60.0]}, None, left, out=tmp_path / "one.csv", decision=False, **options)


def test_trials_are_read_shortly_before_they_are_simulated(rooms, here, tmp_path):
    """One that changes meanwhile ends the sweep; finished points are kept."""
    count = 12
    for case in range(count):
        shutil.copytree(rooms / "room_1.2_1", tmp_path / f"room_{case}")

    def swept(out, told):
        what, grid = tmp_path / "room_{case}", {"case": range(count)}
        return sweep(what, grid, None, left, out=tmp_path / out, client=here, until=0.05, progress=told)

    assert swept("whole.csv", False)["status"].tolist() == ["ok"] * count
    changed = tmp_path / f"room_{count - 1}" / "decision.toml"
    text = changed.read_text()
    with pytest.raises(SweepError, match=f"room_{count - 1} has changed since the sweep began; finished points are kept"):
        swept("out.csv", lambda progress: changed.write_text(text.replace("1.34", "1.2")))
    changed.write_text(text)
    assert 2 < len((tmp_path / "out.csv").read_text().splitlines()) < count + 2
    swept("out.csv", False)
    assert (tmp_path / "out.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_what_cannot_be_swept_is_refused_at_once(rooms, here, tmp_path):
    def refused(error, words, what, grid, drive=None, **options):
        with pytest.raises(error, match=words):
            sweep(what, grid, drive, left, out=tmp_path / "out.csv", client=here, **{**RUN, **options})
        assert not (tmp_path / "out.csv").exists()

    room, mass = rooms / "room_0.9_1", {"agent[*].Mass": [60.0]}
    refused(ValueError, 'there is no parameter "wdith"', rooms / "room_{wdith}_1", {"width": [0.9]})
    refused(CommandError, "room_0.7_1", rooms / "room_{width}_1", {"width": [0.9, 0.7]})
    refused(SimulationError, "overwritten by the connection that feeds crowd.agent.3..Active", room, {"agent[3].Active": [0]})
    refused(SimulationError, 'did you mean "decision.agent', room, {"agent[3].DesiredSpeed": [1.0]})
    refused(SimulationError, "nobody can leave", room, mass, decision=False)
    refused(ValueError, "until='gone'", room, mass, until="gone")
    table = sweep(room, mass, None, lambda run: {"ended": 1.0}, client=here, **RUN)
    assert "the measure has the name of another column: 'ended'" in table["error"][0]
