"""lemons_fmu: a crowd and runs of it are what plain FMPy and `lemons run` see; the package is typed and installs."""

import gc
import os
import pickle
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH, push_drive
from lemons_fmu import Crowd, Drive, FmuError, load, simulate
from lemons_fmu.push import Push

STEP, STEPS = 0.05, 8  # s; at the end agents 0 and 1 are in contact
FRICTION = "contact.human_naked.human_naked.KineticFriction"


@pytest.fixture
def fmu(push_fmu):
    return load(push_fmu)


@pytest.fixture
def drive(fmu):
    return Drive.read(TRIAL_PUSH / "drive.csv", fmu.ids)


def as_arrays(look):
    """poses, velocities, squeeze and contacts of what the FMPy wrapper of these tests sees."""
    motion = np.array([agent[:6] for agent in look])
    poses, velocities = motion[:, [0, 1, 4]], motion[:, [2, 3, 5]]
    return poses, velocities, np.array([agent[9] for agent in look]), np.array([agent[6:9] for agent in look])


def test_a_crowd_shows_what_fmpy_shows(fmu, push):
    parameters = {"agent[1].Mass": 50.0, FRICTION: 0.2}
    for name, value in parameters.items():
        push[name] = value
    push.initialize()
    pushes = np.zeros((5, 3))
    with Crowd(fmu, parameters) as crowd:
        assert len(crowd) == 5 and crowd["agent[1].Mass"] == 50.0
        for k in range(STEPS):
            pushes[0] = push_drive().at(k * STEP)[0]
            crowd.set_drive(pushes)
            assert (crowd.drive() == pushes).all()
            crowd.step_to((k + 1) * STEP)
        seen = push.run(STEPS, STEP, push_drive())[-1][1]
        mine = crowd.poses(), crowd.velocities(), crowd.squeeze(), crowd.contacts()
        for one, other, shape in zip(mine, as_arrays(seen), [(5, 3), (5, 3), (5,), (5, 3)]):
            assert one.shape == other.shape == shape
            assert (one == other).all()
        assert crowd.contacts().sum() > 0 and crowd.squeeze().max() > 100.0


def test_a_restored_crowd_runs_on_with_the_same_bits(fmu, drive):
    with Crowd(fmu, {FRICTION: 0.3}) as crowd, Crowd(fmu) as other:
        crowd.run(drive, until=0.4, step=STEP)
        assert crowd.contacts().sum() > 0
        state = crowd.save()
        wanted = crowd.run(drive, until=1.0, step=STEP)
        crowd.restore(state)
        assert crowd.time == 0.4
        again = crowd.run(drive, until=1.0, step=STEP)
        other.restore(pickle.loads(pickle.dumps(state)))
        elsewhere = other.run(drive, until=1.0, step=STEP)
    for run in (again, elsewhere):
        assert run.reals.tobytes() == wanted.reals.tobytes()
        assert run.counts.tobytes() == wanted.counts.tobytes()


@pytest.mark.parametrize("step, until", [(STEP, 1.0), (0.03, 0.5)])
def test_a_simulation_is_the_table_of_lemons_run(lemons, fmu, drive, tmp_path, step, until):
    """Bit by bit, and its last step is shortened in the same way."""
    table = tmp_path / "run.csv"
    options = ["--step", repr(step), "--until", repr(until), "--set", f"{FRICTION}=0.25", "-o", table]
    subprocess.run([lemons, "run", TRIAL_PUSH, *options], check=True, capture_output=True)
    whole = ("id", "agent_contacts", "wall_contacts", "contacting_agents", "total_agent_contacts", "total_wall_contacts")
    names = table.read_text().split("\n")[0].split(",")
    wanted = pd.read_csv(table, converters={name: int if name in whole else float for name in names})
    wanted.columns = [name.split(" [")[0] for name in wanted.columns]
    mine = simulate(fmu, drive, {FRICTION: 0.25}, until, step=step)
    pd.testing.assert_frame_equal(mine, wanted, check_exact=True)
    assert wanted.normal_force.max() > 100.0


def test_ids_of_agents_are_those_of_the_trial(pack, tmp_path):
    trial = Path(shutil.copytree(TRIAL_PUSH, tmp_path / "Trial"))
    for file in ("static/Agents.xml", "dynamic/AgentDynamics.xml"):
        text = (trial / file).read_text()
        (trial / file).write_text(text.replace('Id="3"', 'Id="c: x"'))
    fmu = load(pack(trial))
    assert fmu.ids == ["0", "1", "2", "c: x", "4"]
    assert simulate(fmu, until=0.05).id.tolist() == fmu.ids * 2


def test_drives_of_all_kinds(fmu):
    constant = np.zeros((5, 3))
    constant[0, 0] = 700.0
    wanted = simulate(fmu, constant, until=0.5)
    always = np.array([-1.0, 9.0])
    table = Drive({0: (always, np.array([[700.0, 0, 0]] * 2))})
    with Crowd(fmu) as crowd:
        mass = float(crowd["agent[0].Mass"])
    per_mass = Drive({0: (always, np.array([[700.0 / mass, 0, 0]] * 2))}, per_mass=True)
    for drive in (table, lambda crowd: constant):
        pd.testing.assert_frame_equal(simulate(fmu, drive, until=0.5), wanted, check_exact=True)
    pd.testing.assert_frame_equal(simulate(fmu, per_mass, until=0.5), wanted, rtol=1e-6)
    assert simulate(fmu, None, until=0.5).x.iloc[-5] == 0.0
    ramp = Drive({2: (np.array([0.0, 1.0]), np.array([[0.0, 0, 0], [10.0, 20.0, -1.0]]))})
    times = np.array([-0.1, 0.0, 0.25, 1.0, 1.1])
    assert ramp.sample(2, times).tolist() == [[0, 0, 0], [0, 0, 0], [2.5, 5, -0.25], [10, 20, -1], [0, 0, 0]]


@pytest.mark.parametrize(
    "text, words",
    [
        ("t,agent,Fp.x,Fp.y\n0,0,1,1\n", ["line 1", "no column 'Mp'"]),
        ("# push\nt,agent,Fp.x,Fp.y,Mp\n0,7,1,1,1\n", ["line 3", "no agent '7'"]),
        ("t,agent,Fp.x,Fp.y,Mp\n0,0,1,nan,1\n", ["line 2", "'nan' is not finite"]),
        ("t,agent,Fp.x,Fp.y,Mp\n0,0,1,1\n", ["line 2", "4 cells"]),
        ("t,agent,Fp.x,Fp.y,Mp\n1,0,0,0,0\n1,0,1,1,1\n", ["must rise"]),
        ("", ["empty"]),
    ],
)
def test_a_bad_drive_file_is_refused(tmp_path, text, words):
    path = tmp_path / "drive.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as refusal:
        Drive.read(path, ["0", "1"])
    assert all(word in str(refusal.value) for word in ["drive.csv", *words]), refusal.value


def test_refusals_are_in_the_words_of_the_fmu(fmu):
    cases = [
        ({"agent[1].Mass": -3.0}, "agent[1].Mass = -3.0: must be positive"),
        ({"agent[*].Mass": float("nan")}, "agent[0].Mass = NaN: must be finite"),
        ({"agent[5].Mass": 70.0}, "no variable 'agent[5].Mass'"),
        ({"Threads": 1.5}, "Threads is an integer"),
        ({"Trial": "nowhere"}, "nowhere"),
        ({"AgentContacts": 1}, "AgentContacts"),
    ]
    for parameters, words in cases:
        with pytest.raises(FmuError) as refusal:
            Crowd(fmu, parameters)
        assert words in str(refusal.value)
    with Crowd(fmu) as crowd:
        with pytest.raises(FmuError, match="Fp.x = NaN: must be finite"):
            crowd.set_drive(np.full((5, 3), np.nan))
        with pytest.raises(ValueError, match=r"\(3, 5\)"):
            crowd.set_drive(np.zeros((3, 5)))
        with pytest.raises(FmuError, match="step"):
            crowd.step(-0.05)
        crowd.step()
        assert crowd.time == STEP
    with pytest.raises(FmuError, match="closed"):
        crowd.poses()


@pytest.mark.parametrize("what", ["absent", "no zip", "no crowd"])
def test_files_that_are_no_crowds(decide, tmp_path, what):
    path = tmp_path / "some.fmu"
    if what == "no zip":
        path.write_text("no zip")
    elif what == "no crowd":
        path = decide()
    with pytest.raises(FmuError, match=path.name):
        load(path)


def test_instances_are_used_again_and_forget(fmu, push_fmu, drive):
    assert load(push_fmu) is fmu and load(push_fmu.read_bytes()) is fmu
    assert pickle.loads(pickle.dumps(fmu)) is fmu
    wanted = simulate(fmu, drive, until=1.0)
    gc.collect()
    with Crowd(fmu, {"agent[1].Mass": 40.0}) as crowd:
        instance = crowd._given
        assert not crowd.run(drive, until=1.0).frame().equals(wanted)
    with Crowd(fmu) as crowd:
        assert crowd._given is instance
        assert crowd.run(drive, until=1.0).frame().equals(wanted)
        crowd.reset({"agent[1].Mass": 40.0})
        assert not crowd.run(drive, until=1.0).frame().equals(wanted)
        crowd.reset()
        assert crowd.run(drive, until=1.0).frame().equals(wanted)


def test_threads_have_instances_of_their_own(fmu, drive):
    frictions = [0.0, 0.2, 0.4, 0.8]
    alone = [simulate(fmu, drive, {FRICTION: friction}, 1.0) for friction in frictions]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda friction: simulate(fmu, drive, {FRICTION: friction}, 1.0), frictions * 3))
    for place, table in enumerate(together):
        assert table.equals(alone[place % 4])


def test_messages_of_a_crowd_are_its_own(pack, shared, fmu):
    dense = load(pack(shared / "data/crowds/dense_100"))
    with Crowd(dense) as crowd, Crowd(fmu) as quiet:
        assert any("overlap" in message for message in crowd.messages)
        assert not any(str(dense.directory) in message for message in crowd.messages)
        assert quiet.messages == []


UNPACKED = """
import os, signal, sys
from lemons_fmu import load
print(load(sys.argv[1]).directory, flush=True)
if sys.argv[2:]:
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_is_unpacked_is_removed(push_fmu, tmp_path):
    """At exit; what a killed process has left, by the next one."""
    environment = {**os.environ, "TMPDIR": str(tmp_path)}

    def unpack(*how):
        command = [sys.executable, "-c", UNPACKED, push_fmu, *how]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        return done.returncode, Path(done.stdout.strip())

    code, left = unpack("kill")
    assert code == -signal.SIGKILL and (left / "modelDescription.xml").exists()
    code, place = unpack()
    assert code == 0 and place.is_relative_to(tmp_path) and not place.exists()
    assert not left.parent.exists()
    assert list((tmp_path / f"lemons-fmu-{os.getuid()}").iterdir()) == []


def test_a_large_crowd(pack):
    """Thirty people, a drive for each."""
    fmu = load(pack(TRIAL_DOOR))
    with Crowd(fmu) as crowd:
        crowd.set_drive(np.tile([80.0, 0.0, 0.0], (30, 1)))
        crowd.step(0.1)
        assert crowd.poses().shape == (30, 3)
        assert (crowd.velocities()[:, 0] > 0).all()


@pytest.mark.parametrize(
    "heads, words",
    [("t,id,x\n0,0,0\n", "columns"), ("t,id,x,y\n0,0,0,zero\n", "line 2"), ("t,id,x,y\n", "nobody")],
)
def test_a_bad_measurement_is_refused(tmp_path, heads, words):
    (tmp_path / "external_force_per_mass.txt").write_text("TimeS ForcePerMassNperM\n0 0\n1 2\n")
    (tmp_path / "measured_head_trajectories.csv").write_text(heads)
    with pytest.raises(ValueError, match=words):
        Push.read(tmp_path)


def test_types():
    pytest.importorskip("mypy", reason="mypy is not installed for this Python")
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--cache-dir", REPOSITORY / ".mypy_cache"]
    done = subprocess.run([*command, "src"], cwd=REPOSITORY / "python", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_package_installs(push_fmu, tmp_path):
    """From a copy, without network; setuptools builds beside its source."""
    copy = shutil.copytree(REPOSITORY / "python", tmp_path / "python", ignore=shutil.ignore_patterns("__pycache__"))
    place = tmp_path / "site"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--target", place, copy], check=True, capture_output=True)
    assert (place / "lemons_fmu" / "py.typed").exists()
    code = "import sys, lemons_fmu as l; print(l.__file__); print(len(l.simulate(sys.argv[1], until=0.1)))"
    environment = {**os.environ, "PYTHONPATH": str(place)}
    done = subprocess.run([sys.executable, "-c", code, push_fmu], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.splitlines() == [str(place / "lemons_fmu" / "__init__.py"), "15"], done.stderr
