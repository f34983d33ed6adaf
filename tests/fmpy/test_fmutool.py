"""fmu-manipulation-toolbox's `fmutool -check`."""

import re
import subprocess
import sys
import zipfile
from io import StringIO
from pathlib import Path

import pytest
from crowd import TRIAL_DOOR, TRIAL_PUSH
from fmu_manipulation_toolbox.terminals import Terminals

FMUTOOL = Path(sys.executable).with_name("fmutool")


def check(fmu):
    done = subprocess.run([FMUTOOL, "-input", fmu, "-check"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.returncode, done.stdout


@pytest.mark.parametrize("naming", ["structured", "flat"])
def test_check(pack, row, naming):
    code, said = check(pack(TRIAL_PUSH, options=["--flat-names"] if naming == "flat" else []))
    assert code == 0, said
    assert "seems to be compliant with FMI-2.0" in said
    assert "No semantic error" in said
    assert "ERROR" not in said and "WARNING" not in said
    row("fmu-manipulation-toolbox", f"`fmutool -check`, {naming} names", "compliant, no semantic error")


def test_check_of_decision(decide, row):
    code, said = check(decide())
    assert code == 0 and "No semantic error" in said, said
    row("fmu-manipulation-toolbox", "`fmutool -check`, Decision", "compliant, no semantic error")


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_terminals(pack, decide, tmp_path, row, fmi):
    """It takes the first element of the file for the terminals; by the XSD, `GraphicalRepresentation` comes before them."""
    seen = []
    for fmu in (pack(TRIAL_DOOR, options=["--fmi", fmi]), decide("--fmi", fmi)):
        with zipfile.ZipFile(fmu) as archive:
            text = archive.read("terminalsAndIcons/terminalsAndIcons.xml").decode()
        assert not list(Terminals.from_xml_source(StringIO(text)))
        without, removed = re.subn("<GraphicalRepresentation>.*</GraphicalRepresentation>", "", text, flags=re.DOTALL)
        assert removed == 1
        seen.append(Terminals.from_xml_source(StringIO(without))["crowd"])
    crowd, decision = seen
    assert decision == crowd
    links = decision.connect(crowd)
    assert len(links) == len(decision.members) == (6 if fmi == "3" else 9 * 30)
    assert all(one == other for one, other in links)
    words = "does not see them behind `GraphicalRepresentation`, which the XSD puts first; without it, Decision fits the crowd"
    row("fmu-manipulation-toolbox", f"FMI {fmi}.0: its reader of terminals", words)


def test_check_would_see_an_error(push_fmu, tmp_path):
    """An input with `initial`, which FMI 2.0 forbids."""
    damaged = tmp_path / "damaged.fmu"
    with zipfile.ZipFile(push_fmu) as good, zipfile.ZipFile(damaged, "w") as bad:
        for name in good.namelist():
            content = good.read(name)
            if name == "modelDescription.xml":
                assert b'causality="input"' in content
                content = content.replace(b'causality="input"', b'causality="input" initial="exact"', 1)
            bad.writestr(name, content)
    code, said = check(damaged)
    assert code != 0
    assert "agent[0].Fp.x" in said
