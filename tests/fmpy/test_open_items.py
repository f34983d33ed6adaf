"""What must hold and does not yet. Each test is expected to fail; whoever mends an item removes its mark.

The numbers are those of the list of what users missed."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

import lemons_fmu
import pandas as pd
import pytest
from crowd import TRIAL_DOOR, TRIAL_PUSH

LINE = {"door": (5, 2, 5, 3)}


def open_item(number, what):
    return pytest.mark.xfail(strict=True, reason=f"item {number}: {what}")


@pytest.fixture(autouse=True)
def there(lemons, tmp_path, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


def called(lemons, *words):
    return subprocess.run([lemons, *map(str, words)], check=True, capture_output=True, text=True)


def test_measures_are_kept_in_a_directory():
    kept = lemons_fmu.measure(TRIAL_DOOR, lines=LINE, until=1, output="kept")
    assert json.loads(Path("kept/summary.json").read_text())["lines"] == kept.summary["lines"]
    assert len(pd.read_csv("kept/people.csv")) == len(kept.people) == 30


@pytest.mark.parametrize("door", [(4, 2, 0.4), (4, 2.9, 1.0)], ids=["narrow", "round a corner"])
def test_notes_of_the_command_are_warnings(lemons, door):
    words = ["crowd", "--number", 5, "--box", "4x3", "--door", ",".join(map(str, door)), "--leave", "-o", "said"]
    said = called(lemons, *words).stderr.strip()
    assert said, "the command says nothing: the test is empty"
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        lemons_fmu.crowd(number=5, box=(4, 3), door=door, leave=True, output="told")
    assert [str(each.message).replace("told", "said") for each in seen] == said.splitlines()


UNGUARDED = """
import sys
from lemons_fmu import sweep

sweep(sys.argv[1], {"agent[1].Mass": [60.0]}, False, lambda run: {"x": 1.0}, until=0.1, progress=False)
"""


@pytest.mark.long
def test_a_sweep_in_an_unguarded_script_is_one_sweep(push_fmu):
    Path("unguarded.py").write_text(UNGUARDED)
    done = subprocess.run([sys.executable, "unguarded.py", push_fmu], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "distributed" not in done.stderr and "multiprocessing" not in done.stderr


def test_run_is_a_function():
    run = lemons_fmu.run(TRIAL_PUSH, until=0.1)
    assert (run.frame()["t"].to_numpy() == lemons_fmu.simulate(TRIAL_PUSH, until=0.1)["t"].to_numpy()).all()


@open_item(16, "one name in all places: the mean squeeze is a method of a Crowd and a property of a Run, and has two more names in tables and FMUs")
def test_the_mean_squeeze_has_one_name():
    with lemons_fmu.Crowd(TRIAL_PUSH) as crowd:
        run = crowd.run(until=0.1)
        here, there = crowd.mean_squeeze, run.mean_squeeze
        assert callable(here) == callable(there)
    assert "mean_squeeze" in run.frame() and "mean_normal_force" not in run.frame()
    people = lemons_fmu.measure(run, until=0.1).people
    assert not [name for name in people if name.startswith("largest_mean")]


@open_item(16, "one unit: breadth and depth are given in metres in the command, in Python and in tables; the command wants cm")
def test_breadths_are_in_metres_everywhere(lemons):
    called(lemons, "person", "--breadth", 0.49, "--depth", 0.25, "--stature", 1.75, "--mass", 70)
    called(lemons, "crowd", "-n", 1, "--box", "2x2", "--fixed", "0.49,0.25,1.75,70", "--population", "p.csv", "-o", "one")
    lemons_fmu.crowd(number=1, box=(2, 2), fixed=[0.49, 0.25, 1.75, 70], population="q.csv", output="two")
    assert Path("p.csv").read_text() == Path("q.csv").read_text() and "0.49" in Path("p.csv").read_text()


def test_a_sweep_is_summed_up_over_seeds(lemons):
    for seed in range(1, 7):
        words = ["--number", 8, "--box", "4x3", "--door", "4,1.5,1", "--leave", "--seed", seed]
        called(lemons, "crowd", *words, "-o", f"crowd_{seed}")
    text = 'trial = "crowd_{seed}"\nuntil = "left"\n[parameters]\nseed = { from = 1, to = 6 }\n"agent[*].FloorDamping" = [3.0, 4.5]\n'
    Path("sweep.toml").write_text(text + '[measures]\nfelt = { squeeze = "largest_mean", over = 1, across = "quantile_90" }\n')
    called(lemons, "sweep", "sweep.toml", "-o", "table.csv", "--summary", "summary.csv", "--over", "seed")
    table, summary = pd.read_csv("table.csv", comment="#"), pd.read_csv("summary.csv")
    cases = table.groupby("agent[*].FloorDamping")["felt"]
    assert list(summary["runs"]) == [6, 6] and (summary["stuck"] == table.groupby("agent[*].FloorDamping")["ended"].apply(lambda x: x.isna().sum()).to_numpy()).all()
    assert summary["felt_mean"].to_numpy() == pytest.approx(cases.mean().to_numpy())
    half = 2.570582 * cases.std().to_numpy() / 6**0.5  # Student's t, 5 degrees of freedom, 97.5 %
    assert summary["felt_low"].to_numpy() == pytest.approx((cases.mean() - half).to_numpy(), rel=1e-6)
    assert summary["felt_high"].to_numpy() == pytest.approx((cases.mean() + half).to_numpy(), rel=1e-6)
    assert summary["felt_median"].to_numpy() == pytest.approx(cases.median().to_numpy())


def test_a_walk_writes_no_table_that_nobody_asked_for(lemons):
    called(lemons, "run", TRIAL_DOOR, "--until", 0.1, "-o", "walk.csv")
    assert [path.name for path in Path().iterdir()] == ["walk.csv"]


def test_a_long_run_says_that_its_table_is_large(lemons):
    done = called(lemons, "run", TRIAL_DOOR, "--no-decision", "--until", 60, "--step", 0.02)
    (table,) = (path for path in Path().iterdir() if path.name.startswith("trajectories"))
    assert table.suffix == ".parquet" or "parquet" in done.stdout + done.stderr
