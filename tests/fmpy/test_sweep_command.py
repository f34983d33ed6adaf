"""`lemons sweep` beside the package's sweep: the same points, the same numbers, the same table."""

import subprocess

import pandas as pd
import pytest
from crowd import TRIAL_PUSH
from lemons_fmu import local_cluster, sweep
from distributed import Client

SPEC = """
fmu = "push.fmu"
until = 0.7
[parameters]
"contact.human_naked.human_naked.KineticFriction" = [0.0, 0.4]
"agent[*].Mass" = [60.0, 90.0]
[measures]
moved = { of = "x", take = "change", agents = ["4"] }
squeeze = { of = "squeeze", take = "max" }
mean = { of = "mean_squeeze", take = "max" }
peak = { of = "peak_squeeze", take = "max" }
overlap = { of = "peak_overlap", take = "max" }
"""


def measure(run):
    squeeze = {"squeeze": run.squeeze.max(), "mean": run.mean_squeeze.max(), "peak": run.peak_squeeze.max()}
    return {"moved": run.poses[-1, 4, 0] - run.poses[0, 4, 0], **squeeze, "overlap": run.peak_overlap.max()}


@pytest.fixture(scope="module")
def here():
    """A client with a thread of this process."""
    with local_cluster(1, threads=1, processes=False) as cluster, Client(cluster) as client:
        yield client


@pytest.mark.parametrize("choice, drive", [("", None), ("drive = 'given.csv'", "given.csv"), ("drive = false", False)], ids=str)
def test_both_give_one_table(lemons, here, tmp_path, choice, drive):
    """With the drive.csv that is packed, with a given one, and with none."""
    (tmp_path / "given.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1000,0,0\n0.6,0,800,0,1\n")
    (tmp_path / "push.toml").write_text(choice + SPEC)
    subprocess.run([lemons, "pack", TRIAL_PUSH, "-o", tmp_path / "push.fmu"], check=True, capture_output=True)
    subprocess.run([lemons, "sweep", "push.toml"], cwd=tmp_path, check=True, capture_output=True)
    fmu = tmp_path / "push.fmu"
    drive = tmp_path / drive if drive else drive
    grid = {"contact.human_naked.human_naked.KineticFriction": [0.0, 0.4], "agent[*].Mass": [60.0, 90.0]}
    there = sweep(fmu, grid, drive, measure, until=0.7, client=here, out=tmp_path / "there.csv", progress=False)
    own = pd.read_csv(tmp_path / "push.csv", comment="#", float_precision="round_trip")
    numbers = [name for name in there if name not in ("status", "error")]
    pd.testing.assert_frame_equal(own[numbers], there[numbers], check_exact=True)
    assert list(own) == list(there) and set(own["status"]) == {"ok"}
    assert (own["peak"].max() > 100.0) == (drive is not False)
