"""Decision and crowd, connected by names: thirty people leave a room, under every master the same."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from crowd import PEOPLE, REPOSITORY, TRIAL_DOOR, bits, ids_of, read_table, room_job
from fmpy.ssp.simulation import simulate_ssp
from masters import run

@pytest.fixture(scope="module")
def fmus(lemons, tmp_path_factory):
    """Paths of the two FMUs; the decider first, as in the SSP that `lemons connect` makes of them."""
    directory = tmp_path_factory.mktemp("room")
    for command, name in [("decide", "decision"), ("pack", "crowd")]:
        subprocess.run([lemons, command, TRIAL_DOOR, "-o", directory / f"{name}.fmu"], check=True, capture_output=True)
    return {name: str(directory / f"{name}.fmu") for name in ["decision", "crowd"]}


@pytest.mark.parametrize("tool", ["libcosimpy", "ecospy"])
def test_other_masters(fmus, row, tool):
    if tool == "libcosimpy" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    room = room_job(fmus, 64)  # 4 s: people press through the door
    seen, said = run(tool.removesuffix("py"), room)
    assert said == ""
    assert max(seen[-1][4 * i] for i in range(PEOPLE)) > 5.2, "somebody is out"
    assert max(step[4 * i + 3] for step in seen for i in range(PEOPLE)) > 100.0, "and some are squeezed"
    assert bits(seen) == bits(run("fmpy", room)[0])
    row(tool, "Decision and crowd, connected: 30 people and a door", "same bits as FMPy with the same algorithm")


@pytest.fixture(scope="module")
def coupled(lemons, fmus):
    """What `lemons connect` makes of the two."""
    path = Path(fmus["crowd"]).with_name("coupled.ssp")
    command = [lemons, "connect", fmus["decision"], fmus["crowd"], "-o", path]
    subprocess.run(command, check=True, capture_output=True)
    return path


@pytest.fixture(scope="module")
def run_by_lemons(lemons, coupled, tmp_path_factory):
    def run(steps, *options):
        directory = tmp_path_factory.mktemp("run")
        command = [lemons, "run", coupled, "--step", "0.0625", "--until", str(steps / 16), *options]
        subprocess.run(command, check=True, capture_output=True, cwd=directory)
        seen = read_table((directory / "trajectories.csv").read_text(), ids_of(TRIAL_DOOR))
        # x, y, theta, squeeze
        return [[number for agent in agents for number in [*agent[:2], agent[4], agent[9]]] for _, agents in seen[1:]]

    return run


@pytest.mark.parametrize("tool", ["libcosimpy", "ecospy"])
def test_the_ssp_in_other_masters(fmus, coupled, run_by_lemons, row, tool):
    if tool == "libcosimpy" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    room = room_job(fmus, 64)
    room.connections, room.ssp = [], str(coupled)
    seen, said = run(tool.removesuffix("py"), room)
    assert said == ""
    assert bits(seen) == bits(run_by_lemons(64, "--algorithm", "jacobi"))
    row(tool, "the SSP of `lemons connect`: 30 people and a door", "same bits as `lemons run`, Jacobi")


def test_the_ssp_in_fmpy(fmus, coupled, run_by_lemons, row):
    """`simulate_ssp` is Jacobi's algorithm too, but zero is the first value at every connector: Decision first sees everybody
    at the origin. The loop of `masters.by_fmpy` that starts so gives its bits; the same loop, started from the true poses,
    gives those of `lemons run`. So the first values are the one difference.
    """
    room = room_job(fmus, 64)
    result = simulate_ssp(str(coupled), stop_time=room.steps * room.step, step_size=room.step)
    theirs = [[seen[".".join(variable)].item() for variable in room.watch] for seen in result]
    assert len(theirs) == room.steps
    assert max(theirs[-1][4 * i] for i in range(PEOPLE)) > 5.2, "somebody is out"
    assert max(step[4 * i + 3] for step in theirs for i in range(PEOPLE)) > 100.0, "and some are squeezed"
    by_lemons = run_by_lemons(64, "--algorithm", "jacobi")
    assert bits(run("fmpy", room)[0]) == bits(by_lemons) != bits(theirs)
    room.zeros = True
    assert bits(run("fmpy", room)[0]) == bits(theirs)
    row("fmpy", "`simulate_ssp` of the SSP of `lemons connect`: 30 people and a door", "same bits as FMPy's loop that starts with zeros")


def test_the_two_algorithms(run_by_lemons, fmus):
    """Gauss–Seidel, the decider first, is the loop of examples/coupled_fmpy.py: drives from the poses of the same instant."""
    jacobi, seidel = (run_by_lemons(32, "--algorithm", name) for name in ["jacobi", "gauss-seidel"])
    assert bits(jacobi) != bits(seidel)
    room = room_job(fmus, 32)
    assert bits(jacobi) == bits(run("fmpy", room)[0])
    room.sequential = True
    assert bits(seidel) == bits(run("fmpy", room)[0])


def printed(script, *arguments):
    command = [sys.executable, REPOSITORY / "examples" / script, *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    title, _, *table = done.stdout.splitlines()
    return title, [line.split() for line in table]


def test_example_in_fmpy(fmus, tmp_path, row):
    picture = tmp_path / "flow.png"
    title, table = printed("coupled_fmpy.py", fmus["decision"], fmus["crowd"], picture)
    assert title == "30 of 30 people have passed the door"
    assert sorted(int(agent) for _, agent, _ in table) == list(range(PEOPLE))
    times = [float(time) for *_, time in table]
    assert times == sorted(times) and 0.5 < times[0] < times[-1] < 20
    assert picture.read_bytes().startswith(b"\x89PNG")
    row("fmpy", "`examples/coupled_fmpy.py`: 30 people leave a room by a door", "all leave")


def test_example_as_an_ssp(lemons, tmp_path):
    script = REPOSITORY / "examples" / "coupled.sh"
    environment = {**os.environ, "LEMONS": str(lemons)}
    done = subprocess.run([script, tmp_path], check=True, capture_output=True, text=True, env=environment)
    assert "Gauss-Seidel algorithm, 270 connections" in done.stdout
    seen = read_table((tmp_path / "trajectories.csv").read_text(), ids_of(TRIAL_DOOR))
    assert all(agent[0] > 5.2 for agent in seen[-1][1]), "all have left"


def test_example_in_libcosim(fmus, row):
    if sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    title, table = printed("coupled_libcosim.py", fmus["decision"], fmus["crowd"])
    assert title == "30 of 30 people have passed the door"
    assert sorted(int(agent) for _, agent, _ in table) == list(range(PEOPLE))
    row("libcosimpy", "`examples/coupled_libcosim.py`: 30 people leave a room by a door", "all leave")
