"""Scenarios in Python: the bytes of the command."""

import subprocess

import pytest
from crowd import REPOSITORY

lemons_fmu = pytest.importorskip("lemons_fmu")

CROWDS = sorted((REPOSITORY / "crates/scenario/tests/crowds").glob("*.toml"))


def files(trial):
    return {path.relative_to(trial): path.read_bytes() for path in trial.rglob("*") if path.is_file()}


def test_python_makes_the_files_of_the_command(lemons, tmp_path):
    assert len(CROWDS) >= 20
    for scenario in CROWDS:
        python, command = tmp_path / "python" / scenario.stem, tmp_path / "command" / scenario.stem
        lemons_fmu.crowd(scenario=scenario, output=python)
        subprocess.run([lemons, "crowd", "--scenario", scenario, "-o", command], check=True, capture_output=True)
        assert files(python) == files(command) != {}, scenario.stem
