"""Trajectories of experiments: the measured side, and that the model of `lemons crowd --leave` gets through a gate as people did."""

import gzip
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
experiments = pytest.importorskip("experiments")
pytest.importorskip("pedpy")
DATA = experiments.directory()
pytestmark = pytest.mark.skipif(DATA is None, reason="there are no trajectories of experiments beside the project")


def test_other_files_than_those_that_were_compared_are_named(tmp_path):
    assert experiments.differing(DATA) == ([], [])
    shutil.copytree(DATA, tmp_path / "walk")
    (name,) = (tmp_path / "walk" / "adrian").iterdir()
    text = gzip.decompress(name.read_bytes())
    name.with_suffix("").write_bytes(text)
    name.unlink()
    assert experiments.differing(tmp_path / "walk") == ([], [])
    name.with_suffix("").write_bytes(text + b"1 1 1 1 1\n")
    (tmp_path / "walk" / "hermes_uo" / "uo-180-180-070.txt.gz").unlink()
    assert experiments.differing(tmp_path / "walk") == (["hermes_uo/uo-180-180-070.txt"], [f"adrian/{name.stem}"])


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
