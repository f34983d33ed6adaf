"""The examples run, write their plots, and say what is wrong with their arguments."""

import json
import os
import shutil
import subprocess
import sys

import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH

pytestmark = pytest.mark.long


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


SCRIPTS = sorted(path.name for path in (REPOSITORY / "examples").glob("*.py"))
# Asks scripts for help, one after another: what they import is imported once.
HELP = """
import contextlib, io, json, os, runpy, sys

seen = {}
for script in sys.argv[1:]:
    sys.argv = [script, "--help"]
    sys.path[0] = sys.argv[0].rpartition("/")[0]
    out, err, code = io.StringIO(), io.StringIO(), None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            runpy.run_path(script, run_name="__main__")
        except SystemExit as end:
            code = end.code
        except BaseException as error:
            code = repr(error)
    seen[script.rpartition("/")[2]] = code or 0, out.getvalue(), err.getvalue(), os.listdir()
print(json.dumps(seen))
"""


@pytest.fixture(scope="module")
def helped(tmp_path_factory):
    """What each example does if it is asked for help: code, standard output and error, files."""
    directory = tmp_path_factory.mktemp("help")
    scripts = [REPOSITORY / "examples" / script for script in SCRIPTS]
    environment = {**os.environ, "MPLBACKEND": "Agg", "TMPDIR": str(directory)}
    command = [sys.executable, "-c", HELP, *scripts]
    done = subprocess.run(command, cwd=directory, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("script", SCRIPTS)
def test_help_helps_and_makes_nothing(helped, script):
    """One of them made a directory called --help."""
    needs(script)
    if script == "analyse.py":
        pytest.importorskip("pedpy")
    code, out, err, files = helped[script]
    assert (code, err) == (0, "")
    assert out.startswith(f"usage: {script} ")
    first = (REPOSITORY / "examples" / script).read_text().splitlines()[0].strip('"')
    assert first in out, "what it does"
    assert files == []


def test_help_of_the_shell_script(tmp_path):
    for arguments, code in (["--help"], 0), (["a", "b"], 2):
        done = subprocess.run(["bash", REPOSITORY / "examples/coupled.sh", *arguments], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == code and done.stdout.startswith("Makes coupled.ssp") and done.stderr == ""
    assert list(tmp_path.iterdir()) == []


def test_room_with_door_writes_the_trial_of_the_repository(tmp_path):
    assert run("room_with_door.py", tmp_path, "room").returncode == 0
    written = {path.relative_to(tmp_path / "room"): path.read_bytes() for path in (tmp_path / "room").rglob("*") if path.is_file()}
    assert written == {path.relative_to(TRIAL_DOOR): path.read_bytes() for path in TRIAL_DOOR.rglob("*") if path.is_file()}
    assert run("room_with_door.py", tmp_path).returncode == 2


def test_feldmann_push_says_what_is_wrong_with_its_data(tmp_path):
    shutil.copytree(TRIAL_PUSH, tmp_path / "data" / "Trial")
    (tmp_path / "data" / "external_force_per_mass.txt").write_text("TimeS ForcePerMassNperM\n0 0\n0.1 2\n0.2 0\n")
    (tmp_path / "data" / "measured_head_trajectories.csv").write_text("t,id,x,y\n0,0,0,0\n0.2,0,0.01,0\n")
    assert run("feldmann_push.py", tmp_path, "data").returncode == 0
    (tmp_path / "data" / "Trial" / "Parameters.xml").unlink()
    broken = run("feldmann_push.py", tmp_path, "data")
    assert broken.returncode == 1 and "Parameters.xml" in broken.stderr and "Traceback" not in broken.stderr


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
    decision = tmp_path / "stay.toml"
    decision.write_text("desired_speed = 0\nwaypoints = [{ x = 9, y = 2.5 }]")
    done = run("coupled_fmpy.py", tmp_path, decide("--decision", decision), pack(TRIAL_DOOR), "flow.png")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0 of 30 people")
    assert (tmp_path / "flow.png").read_bytes().startswith(b"\x89PNG")
