"""The examples run, write their plots, and say what is wrong with their arguments."""

import os
import subprocess
import sys

import pytest
from crowd import REPOSITORY, TRIAL_DOOR


def run(script, directory, *arguments):
    command = [sys.executable, REPOSITORY / "examples" / script, *arguments]
    environment = {**os.environ, "MPLBACKEND": "Agg", "TMPDIR": str(directory)}
    return subprocess.run(command, cwd=directory, env=environment, capture_output=True, text=True)


def needs(script):
    if "libcosim" in script and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")


def test_push_fmpy(push_fmu, tmp_path):
    done = run("push_fmpy.py", tmp_path, push_fmu, "plot.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["plot.png"]


@pytest.mark.parametrize("script", ["push_fmpy.py", "coupled_fmpy.py", "coupled_libcosim.py"])
def test_no_arguments(tmp_path, script):
    needs(script)
    done = run(script, tmp_path)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith(f"usage: {script} ") and "Traceback" not in done.stderr


@pytest.mark.parametrize("script", ["coupled_fmpy.py", "coupled_libcosim.py"])
def test_fmus_in_the_wrong_order(decide, pack, tmp_path, script):
    needs(script)
    decision, crowd = decide(), pack(TRIAL_DOOR)
    before = sorted(tmp_path.iterdir())
    for first, second in [(crowd, decision), (crowd, crowd), (decision, decision)]:
        done = run(script, tmp_path, first, second)
        assert done.returncode == 1 and done.stdout == ""
        assert "decision.fmu first, then crowd.fmu" in done.stderr and "Traceback" not in done.stderr
        assert sorted(tmp_path.iterdir()) == before


def test_nobody_leaves(decide, pack, tmp_path):
    plan = tmp_path / "stay.toml"
    plan.write_text("desired_speed = 0\nwaypoints = [{ x = 9, y = 2.5 }]")
    done = run("coupled_fmpy.py", tmp_path, decide("--plan", plan), pack(TRIAL_DOOR), "flow.png")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0 of 30 people")
    assert (tmp_path / "flow.png").read_bytes().startswith(b"\x89PNG")
