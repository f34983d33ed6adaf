"""The experiment of a push through a row of five people; skipped where the measured data are not at hand."""

import pathlib
import re
import subprocess
import sys

import numpy as np
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


@pytest.fixture
def legs(monkeypatch, lemons):
    monkeypatch.syspath_prepend(ROOT / "examples")
    monkeypatch.setenv("LEMONS", str(lemons))
    import legs

    return legs


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the measured push")
def test_legs_as_they_come_are_nearer_to_the_measured_push_than_no_legs(legs):
    """Heads, from the Trial's own start and from sixteen others; until 4 s, and until people have come back."""
    push, starts = legs.Push.read(DATA), legs.starts_of(DATA / "Trial", 17, 2)

    def difference(name, until):
        fit = legs.Fit(DATA, push, name)
        return np.mean(fit.differences([low for low, _ in fit.searched.values()], starts, until))

    none, pendulum, alone, two_level = (
        [difference(name, until) for until in (legs.UNTIL, push.end)]
        for name in ("none", "pendulum, head", "pendulum, head, literature", "two-level")
    )
    assert pendulum[0] < 0.05 < 0.055 < none[0] and pendulum[1] < 0.08 < 0.13 < none[1]
    assert alone[0] > 0.065 and alone[1] > pendulum[1]
    # These legs do not describe the push, but they carry nobody away.
    assert two_level[0] < 0.066 and two_level[1] < 0.15


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the measured push")
@pytest.mark.parametrize("balance", ["pendulum", "two-level"])
def test_legs_carry_people_about_as_far_as_was_measured(legs, tmp_path, balance):
    push, decision = legs.Push.read(DATA), tmp_path / "decision.toml"
    decision.write_text(f"balance = {balance!r}\n")
    with legs.Crowd(DATA / "Trial", decision=decision, algorithm="gauss-seidel") as crowd:
        crowd.reset({"crowd.TimeStepMechanical": legs.MECHANICAL})
        run = crowd.run(push.drive(), until=legs.UNTIL, step=legs.STEP)
    measured = [(rows[:, 1] - rows[0, 1]).max() for rows in push.heads.values()]
    moved = (run.poses[:, :, 0] - run.poses[0, :, 0]).max(axis=0)
    assert moved == pytest.approx(measured, abs=0.14)
