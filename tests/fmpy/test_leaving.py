"""Runs that end when people have left, or when nobody gets out any more."""

import os
import re
import subprocess
import sys
import zipfile

import limited
import lemons_fmu
import numpy as np
import pandas as pd
import pytest
from crowd import REPOSITORY
from test_measure import write_table

#: Two broad people, and a door that Decision takes for a way and nobody fits through.
SHUT = ["--box", "3x2", "--door", "3,1,0.31", "--fixed", "60,33,1.9,110", "--number", "2", "--leave"]
#: The examples may take so long [s].
LIMIT = 600


@pytest.fixture(autouse=True)
def the_command(lemons, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def test_a_run_in_which_nobody_gets_out_warns(lemons, tmp_path):
    trial = tmp_path / "shut"
    subprocess.run([lemons, "crowd", *SHUT, "-o", trial], check=True, capture_output=True)
    with lemons_fmu.Crowd(trial) as crowd, pytest.warns(UserWarning, match="2 of 2 people have not left: in the last 300 s .*; the run ends at t = 300.000 s"):
        run = crowd.run(until="left", step=0.1)
    assert run.ended is None and run.active.all()
    assert run.times[-1] == pytest.approx(300.0, abs=1e-9)
    table = tmp_path / "run.csv"
    command = [lemons, "run", trial, "--until", "left", "--step", "0.1", "--every", "100", "-o", table]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=tmp_path)
    assert "2 of 2 people have not left" in done.stderr and "t = 300.000 s" in done.stderr
    last = pd.read_csv(table)[-2:]
    # The same run, to the last bit.
    assert (last[["x", "y"]].to_numpy() == run.poses[-1, :, :2]).all()


def test_time_above_a_level_of_means_over_a_second(tmp_path):
    """800 N from 2 to 2.5 s: the mean over a second rises for half a second, stays at 400 N, and falls."""
    times = np.arange(121) * 0.1
    pulse = np.where((times > 2.05) & (times < 2.55), 800.0, 0.0)
    noise = np.random.default_rng(1).uniform(0, 900, len(times))
    still = [[(0.0, 0.0), (2.0, 0.0)]] * len(times)
    table = write_table(tmp_path / "run.csv", still, squeezes=np.transpose([pulse, noise]))
    levels = [0, 100, 300, 401, 450]
    first, second = lemons_fmu.measure(table, above=levels, over=1).people.to_dict("records")
    assert [first[f"time_above_{level}_over_1"] for level in levels] == pytest.approx([1.5, 1.25, 0.75, 0.0, 0.0])
    # The definition, on a grid of 0.1 ms: the moving mean, where it is known.
    fine = np.repeat(noise[1:], 1000)
    impulse = np.concatenate([[0.0], np.cumsum(fine)]) * 1e-4
    moving = impulse[10000:] - impulse[:-10000]
    expected = [np.count_nonzero(moving > level) * 1e-4 for level in levels]
    assert [second[f"time_above_{level}_over_1"] for level in levels] == pytest.approx(expected, abs=2e-3)
    assert 1.0 < expected[-1] < 10.0
    # Shorter than a step, or longer than the record: not known.
    for over_ in (0.05, 13):
        assert lemons_fmu.measure(table, above=[100], over=over_).people[f"time_above_100_over_{over_}"].isna().all()


@pytest.mark.long
def test_everybody_gets_out(lemons, tmp_path):
    """A few runs of docs/walking.md."""
    environment = {**os.environ, "LEMONS": str(lemons)}
    command = [sys.executable, REPOSITORY / "examples/evacuations.py", "few", "--seeds", "2"]
    done = limited.run(command, LIMIT, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    assert "everybody got out in 24 of 24 runs" in (done.stdout if isinstance(done.stdout, str) else done.stdout.decode())
    table = pd.read_csv(tmp_path / "few/results.csv", comment="#")
    assert len(table) == 24 and (table["ended"] < 120).all() and table["squeeze"].nunique() > 12


def test_people_stand_until_their_start(lemons, tmp_path):
    """As RiMEA test 5 asks for: starts between two times, and nobody moves before."""
    subprocess.run([lemons, "crowd", "-n", "10", "--box", "8x5", "--door", "8,2.5,1.2", "--leave", "-o", "T"], check=True, capture_output=True, cwd=tmp_path)
    decision = tmp_path / "T/decision.toml"
    decision.write_text("start = { min = 1, max = 10 }\n" + decision.read_text() + "[agents.3]\nstart = 4\n")
    subprocess.run([lemons, "run", "T", "--until", "11", "--every", "10", "-o", "T.csv"], check=True, capture_output=True, cwd=tmp_path)
    table = pd.read_csv(tmp_path / "T.csv")
    began = {}
    for agent, rows in table.groupby("id"):
        way = np.hypot(rows["x"] - rows["x"].iloc[0], rows["y"] - rows["y"].iloc[0])
        began[agent] = rows["t"][way > 0.02].min()
    times = np.array(sorted(began.values()))
    # Of those whom nobody has pushed before: a walk of 2 cm takes 0.2 s at a relaxation time of 0.22 s.
    assert 3.9 < began[3] < 4.5 and times[0] > 1 and times[-1] < 10.8
    assert len(set(times)) > 7 and times[-1] - times[0] > 4


def test_an_exit_lets_people_go_while_it_is_open(lemons, tmp_path):
    """In the mechanics, with a run that is stopped and goes on."""

    def call(*words):
        return subprocess.run([lemons, *words], check=True, capture_output=True, text=True, cwd=tmp_path)

    call("crowd", "-n", "12", "--box", "6x5", "--door", "6,2.5,1.2", "--leave", "-o", "T")
    decision = tmp_path / "T/decision.toml"
    decision.write_text(decision.read_text().replace("]] },", "]], open = [[8, 10], [20, 99]] },"))
    assert "open" in decision.read_text()
    call("run", "T", "--until", "left", "-o", "whole.csv", "--outputs", "whole_outputs.csv")
    table = pd.read_csv(tmp_path / "whole.csv", comment="#")
    leave = np.sort(table[table["active"] == 1].groupby("id")["t"].max().to_numpy())
    first, second = leave[leave < 15], leave[leave > 15]
    assert len(first) > 1 and len(second) > 1 and len(leave) == 12
    assert first.min() > 7.9 and first.max() < 10.1 and second.min() > 19.9
    # Saved while it is closed, with people in front of it.
    call("run", "T", "--until", "15", "--state", "half.run", "-o", "half.csv")
    call("run", "T", "--until", "left", "--resume", "half.run", "-o", "rest.csv")
    rest = pd.read_csv(tmp_path / "rest.csv", comment="#")
    rest, same = (each[each["t"] > 15.01].reset_index(drop=True) for each in (rest, table))
    assert rest[["t", "id", "x", "y", "active"]].equals(same[["t", "id", "x", "y", "active"]])


@pytest.mark.long
def test_groups_of_the_example(lemons, tmp_path):
    """docs/walking.md: a few of its crowds."""
    command = [sys.executable, REPOSITORY / "examples/groups.py", "few", "--seeds", "1", "--sizes", "1", "2", "--parts", "0", "0.5"]
    environment = {**os.environ, "LEMONS": str(lemons)}
    said = subprocess.run(command, check=True, capture_output=True, text=True, cwd=tmp_path, env=environment).stdout
    rows = {row[0]: [float(each) for each in row[1:]] for row in map(str.split, said.splitlines()) if row and row[0] in ("1", "2", "0.0", "0.5")}
    # Slower than alone, and much nearer to each other than the same people without groups.
    _, speed, together, without = rows["2"][:4]
    assert speed < rows["1"][1] and together < 1.6 < without
    # A crowd in front of a door is not slower by more than a tenth.
    assert 0.9 < rows["0.5"][0] / rows["0.0"][0] < 1.1


def test_several_crowds_all_leave(lemons, tmp_path):
    """Two rooms in one SSP: the run ends as the last one of both has left."""

    def call(*words):
        return subprocess.run([lemons, *words], check=True, capture_output=True, text=True, cwd=tmp_path)

    ends = {}
    for name, people, size, door in (("A", 8, "4x3", "4,1.5,1"), ("B", 4, "6x3", "6,1.5,1")):
        call("crowd", "--number", str(people), "--box", size, "--door", door, "--leave", "-o", name)
        call("run", name, "--until", "left", "-o", f"{name}.csv")
        ends[name] = pd.read_csv(tmp_path / f"{name}.csv")["t"].max()
        call("decide", name, "-o", f"{name}D.fmu")
        call("pack", name, "-o", f"{name}C.fmu")
        call("connect", f"{name}D.fmu", f"{name}C.fmu", "-o", f"{name}.ssp")
    structures = {}
    with zipfile.ZipFile(tmp_path / "both.ssp", "w") as both:
        for name in "AB":
            with zipfile.ZipFile(tmp_path / f"{name}.ssp") as one:
                structures[name] = one.read("SystemStructure.ssd").decode()
                for part in one.namelist():
                    if part != "SystemStructure.ssd" and part not in both.namelist():
                        both.writestr(part, one.read(part))
        whole = structures["A"]
        for kind in ("Elements", "Connections"):
            more = re.search(rf"<ssd:{kind}>(.*?)</ssd:{kind}>", structures["B"], re.DOTALL)[1]
            whole = whole.replace(f"</ssd:{kind}>", more + f"</ssd:{kind}>", 1)
        both.writestr("SystemStructure.ssd", whole)
    done = call("run", "both.ssp", "--until", "left", "-o", "both.csv")
    tables = {name: pd.read_csv(tmp_path / f"both_{name}C.csv") for name in "AB"}
    assert all(table["t"].max() == max(ends.values()) for table in tables.values()) and ends["A"] != ends["B"]
    assert all((table[table["t"] == table["t"].max()]["active"] == 0).all() for table in tables.values())
    assert "have not left" not in done.stderr
