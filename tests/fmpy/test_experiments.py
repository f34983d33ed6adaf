"""Trajectories of experiments: the measured side, and that the model of `lemons crowd --leave` gets through a gate as people did."""

import gzip
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
experiments = pytest.importorskip("experiments")
experiment_runs = pytest.importorskip("experiment.runs")
pytest.importorskip("pedpy")
DATA = experiments.directory()
pytestmark = pytest.mark.skipif(DATA is None, reason="there are no trajectories of experiments beside the project")


def test_other_files_than_those_that_were_compared_are_named(tmp_path):
    assert experiments.differing(DATA) == ([], [])
    walk = tmp_path / "walk"
    shutil.copytree(DATA, walk)
    name, gone = f"adrian/{experiments.GATE}.txt", "hermes_uo/uo-180-180-070.txt"
    text = experiment_runs.text_of(experiment_runs.file_of(walk, name))
    experiment_runs.file_of(walk, gone).unlink()
    compressed = walk / f"{name}.gz"
    good = gzip.compress(text)
    for kept in (good, gzip.compress(text + b"1 1 1 1 1\n"), good[:-100], b"none"):
        compressed.write_bytes(kept)
        assert experiments.differing(walk) == ([gone], [] if kept is good else [name])
    compressed.unlink()
    (walk / name).write_bytes(text)
    assert experiments.differing(walk) == ([gone], [])


def test_measured_numbers_are_those_that_others_found():
    """Flow, density, speed and last passage, measured with PedPy by somebody else."""
    for name in (experiments.GATE, "uo-180-180-120"):
        flow, density, speed, last = experiments.CHECKED[name]
        found = experiments.work((name, str(DATA), None, 0, None))
        assert found["specific"] == pytest.approx(flow, rel=0.015)
        assert found["density"] == pytest.approx(density, rel=0.015)
        assert found["speed"] == pytest.approx(speed, abs=0.015)
        assert found["last"] == pytest.approx(last, abs=0.5)


def test_people_get_through_a_gate_about_as_fast_as_people_did():
    rows = {row.what: row for row in experiments.gate("rotational", seeds=2, data=str(DATA))}
    slope = rows["slope of N(t) [1/s]"]
    assert slope.ours == pytest.approx(slope.measured, rel=0.3)
    assert rows["density 0.5 to 1.3 m ahead [1/m²]"].passed
    assert rows["nearest neighbour [m]"].passed


def test_nobody_overtakes_in_single_file_and_speeds_are_those_of_people():
    rows = experiments.single_file("rotational", seeds=1, quick=True, data=str(DATA))
    by = {row.what.split(": ")[1]: row for row in rows}
    assert by["speed [m/s]"].ours == pytest.approx(by["speed [m/s]"].measured, abs=0.1)
    assert by["people overtaken"].ours == 0
