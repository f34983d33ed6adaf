"""lemons_fmu: a crowd and runs of it are what plain FMPy and `lemons run` see; the package is typed and installs."""

import gc
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from crowd import COLUMNS, REPOSITORY, TRIAL_DOOR, TRIAL_PUSH, push_drive
from lemons_fmu import Crowd, Drive, FmuError, State, load, simulate
from lemons_fmu import files
from lemons_fmu.push import Push
from lemons_fmu.scratch import scratch

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


def command_table(lemons, path, model, *options):
    """The table of `lemons run`, as `simulate` gives it."""
    subprocess.run([lemons, "run", model, *options, "-o", path, "--force"], check=True, capture_output=True)
    whole = [name for name, unit in COLUMNS.items() if unit is None]
    names = path.read_text().split("\n")[0].split(",")
    table = pd.read_csv(path, converters={name: int if name in whole else float for name in names})
    table.columns = [name.split(" [")[0] for name in table.columns]
    return table


@pytest.mark.parametrize("step, until", [(STEP, 1.0), (0.03, 0.5), (0.1, 0.3)])
def test_a_simulation_is_the_table_of_lemons_run(lemons, fmu, drive, tmp_path, step, until):
    """Bit by bit; its last step is shortened in the same way, and not where the time is a multiple but for rounding."""
    options = ["--step", repr(step), "--until", repr(until), "--set", f"{FRICTION}=0.25"]
    wanted = command_table(lemons, tmp_path / "run.csv", TRIAL_PUSH, *options)
    mine = simulate(fmu, drive, {FRICTION: 0.25}, until, step=step)
    pd.testing.assert_frame_equal(mine, wanted, check_exact=True)
    assert until < 0.5 or wanted.normal_force.max() > 100.0


@pytest.fixture
def two_trials(pack, tmp_path):
    """An FMU of two Trials: the second has another push and a TimeStep of its own."""
    other = Path(shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_other"))
    parameters = (other / "Parameters.xml").read_text()
    assert 'TimeStep="0.05"' in parameters
    (other / "Parameters.xml").write_text(parameters.replace('TimeStep="0.05"', 'TimeStep="0.02"'))
    (other / "drive.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,900,0,0\n0.5,0,300,0,1\n")
    return pack(TRIAL_PUSH, other)


def test_the_packed_drive_pushes_in_command_and_python_alike(lemons, two_trials, tmp_path):
    """With the drive.csv that is packed, of the Trial that is chosen; with a given one; and with none."""
    given = tmp_path / "given.csv"
    given.write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1000,0,0\n0.4,0,1000,0,0\n")
    seen = []
    for trial in ("Trial_push", "Trial_other"):
        chosen, parameters = ["--until", "0.6", "--set", f"Trial={trial}"], {"Trial": trial}
        for options, drive in ([], None), (["--drive", given], given), (["--drive", given], str(given)), (["--no-drive"], False):
            wanted = command_table(lemons, tmp_path / "run.csv", two_trials, *chosen, *options)
            mine = simulate(two_trials, drive, parameters, 0.6)
            pd.testing.assert_frame_equal(mine, wanted, check_exact=True)
            seen.append((len(wanted), wanted.x.iloc[-5]))
    assert len(set(seen)) == 6  # two Trials, three drives; the file by two kinds of path
    assert [count // 5 for count, _ in seen] == [13] * 4 + [31] * 4
    assert min(x for _, x in seen) == 0.0 and sorted(x for _, x in seen)[2] > 0.05


def test_a_packed_drive_that_is_broken_is_told_without_the_place_where_it_lies(pack, tmp_path):
    trial = Path(shutil.copytree(TRIAL_PUSH, tmp_path / "Trial"))
    broken = tmp_path / "broken.fmu"
    # `lemons pack` refuses such a Trial.
    with zipfile.ZipFile(pack(trial)) as good, zipfile.ZipFile(broken, "w") as archive:
        for name in good.namelist():
            drive = name.endswith("drive.csv")
            archive.writestr(name, "t,agent,Fp.x,Fp.y,Mp\n0,0,1,1,much\n" if drive else good.read(name))
    fmu = load(broken)
    with pytest.raises(ValueError) as refusal:
        simulate(fmu, until=0.1)
    assert str(refusal.value) == "drive file Trial/drive.csv in the FMU: line 2: Mp='much': not a finite number"
    assert len(simulate(fmu, False, until=0.1)) == 15


@pytest.mark.parametrize("what", [5, 0, True, [1, 2, 3], (), {0: 1.0}, b"drive.csv", 2.5, Drive, [[0.0] * 3] * 5], ids=repr)
def test_what_cannot_drive_a_crowd_is_refused_and_not_ignored(fmu, what):
    with pytest.raises(TypeError, match=r"the drive is .*; it must be None .*, False .*, the path of a CSV file, a Drive, an array"):
        simulate(fmu, what, until=0.1)


def test_arrays_that_cannot_drive_a_crowd_are_refused(fmu):
    for array, kind in (np.zeros((3, 3)), ValueError), (np.zeros((5, 3), dtype=complex), TypeError), (np.full((5, 3), "1"), TypeError):
        for drive in array, lambda crowd, array=array: array:
            with pytest.raises(kind, match="the drive"):
                simulate(fmu, drive, until=0.1)
    with pytest.raises(TypeError, match="the drive is None"):
        simulate(fmu, lambda crowd: None, until=0.1)
    with pytest.raises(ValueError, match=r"agents \[5\], but there are 5"):
        simulate(fmu, Drive({5: (np.zeros(1), np.zeros((1, 3)))}), until=0.1)
    with pytest.raises(FileNotFoundError, match="nothing.csv"):
        simulate(fmu, "nothing.csv", until=0.1)


def test_a_drive_is_taken_by_names_and_never_by_halves(fmu):
    """Columns of a DataFrame were taken by their places, masked values were applied, and the Id "1" was an index."""
    pushed = pd.DataFrame({"Fp.x": [300.0, 0, 0, 0, 0], "Fp.y": 0.0, "Mp": 0.0})
    with Crowd(fmu) as crowd:
        wanted = crowd.run(lambda _: pushed.to_numpy(), until=0.5).poses
        crowd.reset()
        assert (crowd.run(lambda _: pushed[["Mp", "Fp.y", "Fp.x"]], until=0.5).poses == wanted).all()
        assert wanted[-1, 0, 0] > wanted[0, 0, 0]
        for drive, words in (
            (pushed.rename(columns={"Mp": "torque"}), "the drive has the columns Fp.x, Fp.y, torque, not Fp.x, Fp.y, Mp"),
            (pushed[::-1], "must be named 0 to 4, in this order"),
            (np.ma.masked_less(pushed.to_numpy(), 1), "masked values"),
        ):
            crowd.reset()
            with pytest.raises(ValueError, match=words):
                crowd.run(lambda _: drive, until=0.1)
    times, values = np.array([0.0, 1.0]), pd.DataFrame({"Mp": [0.0, 0.0], "Fp.x": [1.0, 2.0], "Fp.y": [3.0, 4.0]})
    assert (Drive({1: (times, values)}).tables[1][1] == [[1, 3, 0], [2, 4, 0]]).all()
    with pytest.raises(ValueError, match="masked"):
        Drive({1: (times, np.ma.masked_equal(values.to_numpy(), 4))})
    for key in "1", 1.0, None:
        with pytest.raises(TypeError, match="must be an index in Agents.xml"):
            Drive({key: (times, values)})


@pytest.mark.parametrize(
    "step, until, words",
    [(0.05, 1e300, "2.0000e[+]301 steps of 0.05 s"), (1e-12, 5.0, "at most 1e[+]09"), (0.0, 1.0, "nothing to")],
)
def test_as_many_steps_as_lemons_run_makes(lemons, fmu, tmp_path, step, until, words):
    with pytest.raises(ValueError, match=words):
        simulate(fmu, until=until, step=step)
    command = [lemons, "run", TRIAL_PUSH, "--step", repr(step), "--until", repr(until), "-o", tmp_path / "run.csv"]
    assert subprocess.run(command, capture_output=True).returncode in (1, 2)
    with Crowd(fmu, start=1e17) as crowd, pytest.raises(ValueError, match="lost in rounding"):
        crowd.run(until=1e17 + 64, step=1.0)


def test_mean_and_peak_squeeze_do_not_hang_on_the_step(fmu):
    """The mean over a step is that of its parts; the peak is one of theirs. The sample hangs on the instant."""
    push = np.zeros((5, 3))
    push[0, 0] = 800.0

    def run_in(step):
        with Crowd(fmu) as crowd:
            run = crowd.run(push, until=1.0, step=step)
            seen = np.column_stack([crowd.mean_squeeze(), crowd.peak_squeeze(), crowd.peak_overlap()])
            assert (seen == run.reals[-1, :, 7:]).all() and crowd["LargestOverlap"] == seen[:, 2].max()
        return run

    fine, coarse = run_in(0.01), run_in(0.05)
    means = fine.mean_squeeze[1:].reshape(-1, 5, 5).mean(axis=1)
    assert np.allclose(means, coarse.mean_squeeze[1:], rtol=1e-6, atol=1e-6 * means.max()) and means.max() > 100.0
    for one, other in (fine.peak_squeeze, coarse.peak_squeeze), (fine.peak_overlap, coarse.peak_overlap):
        assert np.allclose(one[1:].reshape(-1, 5, 5).max(axis=1), other[1:], rtol=1e-6) and one.max() > 0
    assert (coarse.mean_squeeze <= coarse.peak_squeeze).all() and (coarse.squeeze <= coarse.peak_squeeze).all()
    assert (coarse.squeeze[-1] < 0.5 * coarse.peak_squeeze[-1]).all(), "else this shows nothing"


def test_an_fmu_without_mean_and_peak_goes_on_and_says_so(fmu, push_fmu, drive, tmp_path):
    """As one that an earlier version packed."""
    old = tmp_path / "old.fmu"
    with zipfile.ZipFile(push_fmu) as archive, zipfile.ZipFile(old, "w") as written:
        for name in archive.namelist():
            content = archive.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb"\.(Mean|Peak)(NormalForce|Overlap)\b", rb".Without\1\2", content)
            written.writestr(name, content)
    with Crowd(old) as crowd:
        run = crowd.run(drive, until=0.4)
        for ask in crowd.mean_squeeze, crowd.peak_squeeze, crowd.peak_overlap, lambda: run.mean_squeeze, lambda: run.peak_overlap:
            with pytest.raises(FmuError, match=r"no output agent\[i\].*: an earlier version packed it; pack its Trial again"):
                ask()
    wanted = simulate(fmu, drive, until=0.4)
    three = ["mean_normal_force", "peak_normal_force", "peak_overlap"]
    pd.testing.assert_frame_equal(run.frame(), wanted.drop(columns=three), check_exact=True)


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
    assert simulate(fmu, False, until=0.5).x.iloc[-5] == 0.0
    ramp = Drive({2: (np.array([0.0, 1.0]), np.array([[0.0, 0, 0], [10.0, 20.0, -1.0]]))})
    times = np.array([-0.1, 0.0, 0.25, 1.0, 1.1])
    assert ramp.sample(2, times).tolist() == [[0, 0, 0], [0, 0, 0], [2.5, 5, -0.25], [10, 20, -1], [0, 0, 0]]


HEAD = "t,agent,Fp.x,Fp.y,Mp\n"


@pytest.mark.parametrize(
    "text, words",
    [
        ("t,agent,Fp.x,Fp.y\n0,0,1,1\n", ["line 1", "no column 'Mp'"]),
        ("t,agent,Fp.x,Fp.y,Mp,Fp.x\n0,0,1,1,1,2\n", ["line 1", "two columns 'Fp.x'"]),
        ("# push\n" + HEAD + "0,7,1,1,1\n", ["line 3", "agent='7'", "no agent"]),
        (HEAD + "0,0,1,nan,1\n", ["line 2", "Fp.y='nan': not a finite number"]),
        (HEAD + "0,0,1,1,1e999\n", ["line 2", "Mp='1e999': not a finite number"]),
        (HEAD + "0,0,1_000,1,1\n", ["line 2", "Fp.x='1_000': not a finite number"]),
        (HEAD + "0,0,,1,1\n", ["line 2", "Fp.x='': not a finite number"]),
        (HEAD + "0,0,0x10,1,1\n", ["line 2", "Fp.x='0x10': not a finite number"]),
        (HEAD + "0,0,\u0661,1,1\n", ["line 2", "Fp.x='\u0661': not a finite number"]),
        (HEAD + "0,0,1,1\n", ["line 2", "4 cells"]),
        (HEAD + "   \n0,0,1,1,1\n", ["line 2", "1 cells"]),
        (HEAD + "\n0,0,1,1,1,1\n", ["line 3", "6 cells"]),
        (HEAD + "1,0,0,0,0\n1,0,1,1,1\n", ["line 3", "t=1 is not after t=1.0"]),
        (b"t,agent,Fp.x,Fp.y,Mp\n0,0,1,1,\xff\n", ["line 2", "utf-8"]),
        ("", ["no column 't'"]),
    ],
    ids=repr,
)
def test_a_bad_drive_file_is_refused_as_by_lemons_run(lemons, tmp_path, text, words):
    path = tmp_path / "drive.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ValueError) as refusal:
        Drive.read(path, ["0", "1"])
    assert all(word in str(refusal.value) for word in [str(path), *words]), refusal.value
    command = [lemons, "run", TRIAL_PUSH, "--until", "0.05", "--drive", path, "-o", tmp_path / "run.csv"]
    assert subprocess.run(command, capture_output=True).returncode == 1


def test_a_drive_that_is_no_regular_file_is_refused(tmp_path):
    endless = tmp_path / "endless.csv"
    endless.symlink_to("/dev/zero")
    with pytest.raises(OSError, match=f"it is a device, not a regular file: {re.escape(repr(str(endless)))}"):
        Drive.read(endless, ["0"])
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="it is a pipe, not a regular file: .*pipe.csv"):
        Drive.read(pipe, ["0"])


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "0,0,+1.,.5,1E2\n0.5,0,-0,1e-400,2\n",
        "\ufeff# push\r\n\r\n Mp ,Fp.y, Fp.x,note,agent,t\r\n1, 2 ,700,\"a, b\",\"0\",0\r\n#\r\n1,2,700,,0,1\r\n",
        HEAD + "-1,0,800,0,0\n9,0,800,0,0",
        HEAD,
    ],
    ids=repr,
)
def test_a_good_drive_file_is_read_as_by_lemons_run(lemons, fmu, tmp_path, text):
    path = tmp_path / "drive.csv"
    path.write_text(text, newline="")
    wanted = command_table(lemons, tmp_path / "run.csv", TRIAL_PUSH, "--until", "0.6", "--drive", path)
    pd.testing.assert_frame_equal(simulate(fmu, path, until=0.6), wanted, check_exact=True)


def test_what_is_printed_of_an_object_is_a_line(fmu, drive):
    with Crowd(fmu) as crowd:
        seen = [repr(crowd), repr(crowd.run(drive, until=0.4)), repr(crowd.save())]
        assert seen[0] == "<Crowd of 5 people, Trial 'Trial_push', at 0 s>"
        assert seen[1] == "<Run of 5 people from 0 s to 0.4 s, 9 communication points>"
        seen += [repr(crowd), repr(drive), repr(fmu)]
        assert seen[3] == "<Crowd of 5 people, Trial 'Trial_push', at 0.4 s>"
    assert repr(crowd) == "<Crowd, closed>"
    assert all(len(line) < 100 and "\n" not in line for line in seen)


def test_refusals_are_in_the_words_of_the_fmu(fmu):
    cases = [
        ({"agent[1].Mass": -3.0}, "agent[1].Mass = -3.0: must be positive"),
        ({"agent[*].Mass": float("nan")}, "agent[0].Mass = NaN: must be finite"),
        ({"agent[5].Mass": 70.0}, "no variable 'agent[5].Mass'"),
        ({"Threads": 1.5}, "Threads must be an integer"),
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


LIBRARY, DESCRIPTION = "binaries/", "modelDescription.xml"


@pytest.mark.parametrize(
    ("fmi", "file", "old", "new"),
    [
        (2, DESCRIPTION, b"<fmiModelDescription", b"<fmiModel"),
        (2, DESCRIPTION, b".Mp", b".Nothing"),
        (2, LIBRARY, b"\x7fELF", b"none"),
        (3, DESCRIPTION, b"<Float64", b"<Float65"),
        (3, DESCRIPTION, b'stepSize="', b'stepSize="x'),
        # The value reference of AgentId, which is read from an instance.
        (3, DESCRIPTION, b'"37"', b'"9937"'),
        (3, LIBRARY, b"\x7fELF", b"none"),
    ],
)
def test_nothing_stays_of_an_fmu_that_cannot_be_used(pack, tmp_path, fmi, file, old, new):
    good, bad = pack(TRIAL_PUSH, options=[f"--fmi={fmi}"]), tmp_path / "bad.fmu"
    changed = 0
    with zipfile.ZipFile(good) as source, zipfile.ZipFile(bad, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name.startswith(file):
                assert old in data
                data, changed = data.replace(old, new), changed + 1
            target.writestr(name, data)
    assert changed == 1
    before, here = set(scratch().iterdir()), Path.cwd()
    with pytest.raises(FmuError):
        Crowd(bad)
    # fmpy leaves a process in the directory of a library that cannot be loaded.
    assert set(scratch().iterdir()) == before and Path.cwd() == here
    with Crowd(good):
        assert load(good).directory in scratch().iterdir()


def test_instances_are_used_again_and_forget(fmu, push_fmu, drive):
    assert load(push_fmu) is fmu and load(push_fmu.read_bytes()) is fmu
    assert pickle.loads(pickle.dumps(fmu)) is fmu
    wanted = simulate(fmu, drive, until=1.0)
    gc.collect()
    with Crowd(fmu, {"agent[1].Mass": 40.0}) as crowd:
        instance = crowd._given.crowd
        assert not crowd.run(drive, until=1.0).frame().equals(wanted)
    with Crowd(fmu) as crowd:
        assert crowd._given.crowd is instance
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
    [("t,id,x\n0,0,0\n", "columns"), ("t,id,x,y\n0,0,0,zero\n", "line 2"), ("t,id,x,y\n", "no trajectories")],
)
def test_a_bad_measurement_is_refused(tmp_path, heads, words):
    (tmp_path / "external_force_per_mass.txt").write_text("TimeS ForcePerMassNperM\n0 0\n1 2\n")
    (tmp_path / "measured_head_trajectories.csv").write_text(heads)
    with pytest.raises(ValueError, match=words):
        Push.read(tmp_path)


def test_what_is_found_by_its_name_is_a_regular_file_of_a_bounded_size(tmp_path, monkeypatch):
    """A pipe in the place of a measured file blocked for ever, a link to the endless device took all memory."""
    texts = {
        "external_force_per_mass.txt": "t push\n0 1\n1 2\n",
        "measured_head_trajectories.csv": "t,id,x,y\n0,1,0,0\n1,1,0.5,0\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert Push.read(tmp_path).people == [1]
    for name, text in texts.items():
        path = tmp_path / name
        path.unlink()
        os.mkfifo(path)
        with pytest.raises(OSError, match=f"it is a pipe, not a regular file: .*{name}"):
            Push.read(tmp_path)
        path.unlink()
        path.symlink_to("/dev/zero")
        with pytest.raises(OSError, match=f"it is a device, not a regular file: .*{name}"):
            Push.read(tmp_path)
        path.unlink()
        with open(path, "wb") as file:
            file.truncate(files.LARGEST_DRIVE + 1)  # no byte of it is on the disk
        with pytest.raises(OSError, match=f"it is larger than 500 MB, the limit: .*{name}"):
            Push.read(tmp_path)
        path.write_bytes(b"t,id,x,y\n\xff\n")
        with pytest.raises(ValueError, match=f"{name}: it is not UTF-8 text"):
            Push.read(tmp_path)
        path.write_text(text)
    pipe = tmp_path / "pipe.fmu"
    os.mkfifo(pipe)
    with pytest.raises(FmuError, match="pipe.fmu: it is a pipe, not a regular file"):
        load(pipe)
    large = tmp_path / "large.fmu"
    with open(large, "wb") as file:
        file.truncate(files.LARGEST_BINARY + 1)
    with pytest.raises(FmuError, match="large.fmu: it is larger than 4000 MB"):
        load(large)
    monkeypatch.setattr(files, "LARGEST_UNPACKED", 1_000_000)
    bomb = tmp_path / "bomb.fmu"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", bytes(2_000_000))
    with pytest.raises(FmuError, match="bomb.fmu: .*it unpacks to 2 MB; at most 1 MB are allowed"):
        load(bomb)


@pytest.mark.parametrize("platform", ["linux", "win32"])
def test_types(platform):
    pytest.importorskip("mypy", reason="mypy is not installed for this Python")
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--cache-dir", REPOSITORY / ".mypy_cache"]
    done = subprocess.run([*command, "--platform", platform, "src"], cwd=REPOSITORY / "python", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_manual_runs(lemons, push_fmu, tmp_path):
    """All Python of python/README.md as one script, beside push.fmu and the Trials."""
    text = (REPOSITORY / "python" / "README.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 3
    (tmp_path / "manual.py").write_text("\n".join(blocks) + "    print(table.to_csv())\n")
    (tmp_path / "push.fmu").symlink_to(push_fmu)
    (tmp_path / "resources").symlink_to(REPOSITORY / "resources")
    command = [sys.executable, "manual.py"]
    environment = {**os.environ, "TMPDIR": str(tmp_path), "LEMONS": str(lemons)}
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(",ok,") == 9
    assert (tmp_path / "results" / "table.parquet").is_file()


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


@pytest.mark.parametrize("state", [b"abc", None, "state"])
def test_only_a_state_is_restored(fmu, state):
    with Crowd(fmu) as crowd:
        before = crowd.poses()
        with pytest.raises(TypeError, match=rf"of type {type(state).__name__}; it must be a State"):
            crowd.restore(state)
        with pytest.raises(FmuError, match="does not begin like a state|cut off"):
            crowd.restore(State(0.0, b"abc"))
        assert (crowd.poses() == before).all()
