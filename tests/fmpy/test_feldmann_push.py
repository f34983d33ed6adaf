"""The experiment of a push through a row of five people; skipped where the measured data are not at hand."""

import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "push_wed"


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the measured push")
def test_the_push_is_as_near_to_the_measured_one_as_it_was(tmp_path):
    picture = tmp_path / "push.png"
    command = [sys.executable, ROOT / "examples" / "feldmann_push.py", DATA, "--plot", picture]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert len(re.findall(r"^  person \d", out, re.MULTILINE)) == 5
    plane, along = map(float, re.search(r"^  mean +([\d.]+) m +([\d.]+) m$", out, re.MULTILINE).groups())
    assert plane == pytest.approx(0.0566, abs=0.001)  # m; until 4 s
    assert along == pytest.approx(0.0436, abs=0.001)
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 20_000
