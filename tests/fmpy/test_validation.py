"""fmpy's validation finds no problem in any FMU that the command packs."""

import shutil

import pytest
from crowd import TRIAL_PUSH
from fmpy.validation import validate_fmu


def test_default(push_fmu, row):
    assert validate_fmu(str(push_fmu)) == []
    row("fmpy", "`validate_fmu`, structured names, 5 people", "no problem")


@pytest.mark.parametrize("trial", ["data/crowds/dense_100", "data/push_wed/Trial"])
def test_shared(pack, shared, trial):
    assert validate_fmu(str(pack(shared / trial))) == []


@pytest.mark.parametrize("options", [[], ["--flat-names"]])
def test_two_trials(pack, tmp_path, options, row):
    other = shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_other")
    assert validate_fmu(str(pack(TRIAL_PUSH, other, options=options))) == []
    naming = "flat" if options else "structured"
    row("fmpy", f"`validate_fmu`, two Trials in one FMU, {naming} names", "no problem")


def test_flat_names(pack, row):
    assert validate_fmu(str(pack(TRIAL_PUSH, options=["--flat-names"]))) == []
    row("fmpy", "`validate_fmu`, flat names, 5 people", "no problem")
