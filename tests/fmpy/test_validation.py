"""fmpy's validation finds no problem in any FMU that the command packs."""

import shutil

import pytest
from crowd import TRIAL_PUSH
from fmpy.validation import validate_fmu


def test_default(push_fmu):
    assert validate_fmu(str(push_fmu)) == []


@pytest.mark.parametrize("trial", ["data/crowds/dense_100", "data/push_wed/Trial"])
def test_shared(pack, shared, trial):
    assert validate_fmu(str(pack(shared / trial))) == []


def test_two_trials(pack, tmp_path):
    other = shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_other")
    assert validate_fmu(str(pack(TRIAL_PUSH, other))) == []


def test_flat_names(pack):
    assert validate_fmu(str(pack(TRIAL_PUSH, options=["--flat-names"]))) == []
