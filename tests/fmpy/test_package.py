"""lemons_fmu: a crowd and runs of it are what plain FMPy and `lemons run` see; the package is typed and installs."""

import dataclasses
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import limited
import numpy as np
import pandas as pd
import pytest
from crowd import COLUMNS, REPOSITORY, TRIAL_DOOR, TRIAL_PUSH, ids_of, push_drive
from lemons_fmu import CommandError, Crowd, Drive, SimulationError, State, plot, simulate
from lemons_fmu.push import Push

#: [s] What is interrupted ends long before.
LIMIT = 600
STEP, STEPS = 0.05, 8  # s; at the end agents 0 and 1 are in contact
FRICTION = "contact.human_naked.human_naked.KineticFriction"


@pytest.fixture
def drive():
    return Drive.read(TRIAL_PUSH / "drive.csv", ids_of(TRIAL_PUSH))


def as_arrays(look):
    """poses, velocities, squeeze and contacts of what the FMPy wrapper of these tests sees."""
    motion = np.array([agent[:6] for agent in look])
    poses, velocities = motion[:, [0, 1, 4]], motion[:, [2, 3, 5]]
    return poses, velocities, np.array([agent[9] for agent in look]), np.array([agent[6:9] for agent in look])


def test_a_crowd_shows_what_fmpy_shows_of_its_fmu(push):
    parameters = {"agent[1].Mass": 50.0, FRICTION: 0.2}
    for name, value in parameters.items():
        push[name] = value
    push.initialize()
    pushes = np.zeros((5, 3))
    with Crowd(TRIAL_PUSH, parameters) as crowd:
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


def test_values_have_the_types_of_their_variables():
    with Crowd(TRIAL_DOOR, {"agent[*].FloorDamping": 3.5, "agent[2].FloorDamping": np.float32(0.5), "Threads": np.int64(2)}) as crowd:
        values = [crowd[name] for name in ("agent[1].FloorDamping", "agent[2].FloorDamping", "Threads", "Trial", "decision.Arrived")]
        assert values == [3.5, 0.5, 2, "Trial_door", 0] and [type(value) for value in values] == [float, float, int, str, int]
        assert crowd["agent[3].Active"] is True and crowd["crowd.agent[1].FloorDamping"] == 3.5


def test_a_restored_crowd_runs_on_with_the_same_bits(drive):
    with Crowd(TRIAL_PUSH, {FRICTION: 0.3}) as crowd, Crowd(TRIAL_PUSH) as other:
        crowd.run(drive, until=0.4, step=STEP)
        assert crowd.contacts().sum() > 0
        state = crowd.save()
        wanted = crowd.run(drive, until=1.0, step=STEP)
        crowd.restore(state)
        assert crowd.time == 0.4
        again = crowd.run(drive, until=1.0, step=STEP)
        other.restore(pickle.loads(pickle.dumps(state)))
        elsewhere = other.run(drive, until=1.0, step=STEP)
        crowd.reset()
        assert crowd.time == 0.0 and crowd.run(drive, until=1.0).frame().equals(simulate(TRIAL_PUSH, until=1.0))
    for one in (again, elsewhere):
        assert one.numbers.tobytes() == wanted.numbers.tobytes()


def command_table(lemons, path, model, *options):
    """The table of `lemons run`, as `simulate` gives it."""
    subprocess.run([lemons, "run", model, *options, "-o", path, "--force"], check=True, capture_output=True)
    whole = [name for name, unit in COLUMNS.items() if unit is None]
    names = path.read_text().split("\n")[0].split(",")
    table = pd.read_csv(path, converters={name: int if name in whole else float for name in names})
    table.columns = [name.split(" [")[0] for name in table.columns]
    return table


@pytest.mark.parametrize("step, until", [(STEP, 1.0), (0.03, 0.5), (0.1, 0.3)])
def test_a_simulation_is_the_table_of_lemons_run(lemons, drive, push_fmu, tmp_path, step, until):
    """Bit by bit, of the Trial and of that in its FMU; its last step is shortened in the same way, and not where the time is a
    multiple but for rounding."""
    options = ["--step", repr(step), "--until", repr(until), "--set", f"{FRICTION}=0.25"]
    wanted = command_table(lemons, tmp_path / "run.csv", TRIAL_PUSH, *options)
    for what in (TRIAL_PUSH, push_fmu):
        pd.testing.assert_frame_equal(simulate(what, drive, {FRICTION: 0.25}, until, step=step), wanted, check_exact=True)
    assert until < 0.5 or wanted.normal_force.max() > 100.0


def test_the_drive_of_a_trial_pushes_in_command_and_python_alike(lemons, tmp_path):
    """With its drive.csv; with a given one; and with none."""
    given = tmp_path / "given.csv"
    given.write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1000,0,0\n0.4,0,1000,0,0\n")
    seen = set()
    for options, drive in ([], None), (["--drive", given], given), (["--drive", given], str(given)), (["--no-drive"], False):
        wanted = command_table(lemons, tmp_path / "run.csv", TRIAL_PUSH, "--until", "0.6", *options)
        pd.testing.assert_frame_equal(simulate(TRIAL_PUSH, drive, until=0.6), wanted, check_exact=True)
        seen.add(wanted.x.iloc[-5])
    assert len(seen) == 3  # the file by two kinds of path
    broken = shutil.copytree(TRIAL_PUSH, tmp_path / "broken")
    (broken / "drive.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1,1,much\n")
    with pytest.raises(CommandError, match='broken/drive.csv.*2.*Mp="much": not a finite number'):
        simulate(broken, until=0.1)


def test_what_is_no_trial_names_fmpy_where_it_is_an_fmu(decide, tmp_path):
    with pytest.raises(CommandError, match="contains no .*; any other FMU runs with FMPy|no Trial.*FMPy"):
        Crowd(decide())
    (tmp_path / "no.fmu").write_text("no zip")
    for what, words in (tmp_path / "no.fmu", "no.fmu"), (tmp_path / "absent", "absent"), (REPOSITORY / "README.md", "README.md"):
        with pytest.raises(CommandError, match=words):
            Crowd(what)
    with pytest.raises(ValueError, match="is coupled by lemons connect, or with FMPy"):
        Crowd(TRIAL_DOOR, decision="some.fmu")
    with pytest.raises(TypeError, match="give the path of a Trial"):
        Crowd(b"PK")


@pytest.mark.parametrize("what", [5, 0, True, [1, 2, 3], (), {0: 1.0}, b"drive.csv", 2.5, Drive, [[0.0] * 3] * 5], ids=repr)
def test_what_cannot_drive_a_crowd_is_refused_and_not_ignored(what):
    with pytest.raises(TypeError, match=r"the drive is .*; it must be None .*, False .*, the path of a CSV file, a Drive, an array"):
        simulate(TRIAL_PUSH, what, until=0.1)


def test_arrays_that_cannot_drive_a_crowd_are_refused():
    for array, kind in (np.zeros((3, 3)), ValueError), (np.zeros((5, 3), dtype=complex), TypeError), (np.full((5, 3), "1"), TypeError):
        for drive in array, lambda crowd, array=array: array:
            with pytest.raises(kind, match="the drive"):
                simulate(TRIAL_PUSH, drive, until=0.1)
    with pytest.raises(TypeError, match="the drive is None"):
        simulate(TRIAL_PUSH, lambda crowd: None, until=0.1)
    with pytest.raises(ValueError, match=r"agents \[5\], but there are 5"):
        simulate(TRIAL_PUSH, Drive({5: (np.zeros(1), np.zeros((1, 3)))}), until=0.1)
    with pytest.raises(FileNotFoundError, match="nothing.csv"):
        simulate(TRIAL_PUSH, "nothing.csv", until=0.1)


def test_a_drive_is_taken_by_names_and_never_by_halves():
    """Columns of a DataFrame were taken by their places, masked values were applied, and the Id "1" was an index."""
    pushed = pd.DataFrame({"Fp.x": [300.0, 0, 0, 0, 0], "Fp.y": 0.0, "Mp": 0.0})
    with Crowd(TRIAL_PUSH) as crowd:
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
    [(0.05, 1e300, "2.0000e301 communication steps of 0.05 s"), (1e-12, 5.0, "at most 1e9"), (0.0, 1.0, "must be greater than 0")],
)
def test_as_many_steps_as_lemons_run_makes(step, until, words):
    with pytest.raises(ValueError, match=words):
        simulate(TRIAL_PUSH, until=until, step=step)
    with Crowd(TRIAL_PUSH, start=1e17) as crowd, pytest.raises(ValueError, match="lost in rounding"):
        crowd.run(until=1e17 + 64, step=1.0)


def test_ids_of_agents_are_those_of_the_trial(tmp_path):
    trial = Path(shutil.copytree(TRIAL_PUSH, tmp_path / "Trial"))
    for file in ("static/Agents.xml", "dynamic/AgentDynamics.xml"):
        text = (trial / file).read_text()
        (trial / file).write_text(text.replace('Id="3"', 'Id="c: x"'))
    # A row for each agent at two points.
    assert simulate(trial, False, until=0.05).id.tolist() == ["0", "1", "2", "c: x", "4"] * 2


def test_drives_of_all_kinds():
    constant = np.zeros((5, 3))
    constant[0, 0] = 700.0
    wanted = simulate(TRIAL_PUSH, constant, until=0.5)
    always = np.array([-1.0, 9.0])
    table = Drive({0: (always, np.array([[700.0, 0, 0]] * 2))})
    with Crowd(TRIAL_PUSH) as crowd:
        mass = float(crowd["agent[0].Mass"])
    per_mass = Drive({0: (always, np.array([[700.0 / mass, 0, 0]] * 2))}, per_mass=True)
    for drive in (table, lambda crowd: constant):
        pd.testing.assert_frame_equal(simulate(TRIAL_PUSH, drive, until=0.5), wanted, check_exact=True)
    pd.testing.assert_frame_equal(simulate(TRIAL_PUSH, per_mass, until=0.5), wanted, rtol=1e-6)
    assert simulate(TRIAL_PUSH, False, until=0.5).x.iloc[-5] == 0.0
    ramp = Drive({2: (np.array([0.0, 1.0]), np.array([[0.0, 0, 0], [10.0, 20.0, -1.0]]))})
    times = np.array([-0.1, 0.0, 0.25, 1.0, 1.1])
    assert ramp.sample(2, times).tolist() == [[0, 0, 0], [0, 0, 0], [2.5, 5, -0.25], [10, 20, -1], [0, 0, 0]]


HEAD = "t,agent,Fp.x,Fp.y,Mp\n"


def test_drive_files_are_read_as_by_lemons_run(lemons, tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text(HEAD + "0,0,1,nan,1\n0,7,1,1,1\n")
    with pytest.raises(ValueError, match='drive.csv.*Fp.y="nan": not a finite number'):
        Drive.read(path, ["0", "1"])
    path.write_text(HEAD + "0,7,1,1,1\n")
    with pytest.raises(ValueError, match='drive.csv.*there is no agent "7"'):
        Drive.read(path, ["0", "1"])
    path.unlink()
    path.symlink_to("/dev/zero")
    with pytest.raises(OSError, match="drive.csv: it is a device, not a regular file"):
        Drive.read(path, ["0"])
    path.unlink()
    path.write_text("\ufeff# push\r\n\r\n Mp ,Fp.y, Fp.x,note,agent,t\r\n1, 2 ,700,\"a, b\",\"0\",0\r\n#\r\n1,2,700,,0,1\r\n", newline="")
    wanted = command_table(lemons, tmp_path / "run.csv", TRIAL_PUSH, "--until", "0.6", "--drive", path)
    pd.testing.assert_frame_equal(simulate(TRIAL_PUSH, path, until=0.6), wanted, check_exact=True)


def test_what_is_printed_of_an_object_is_a_line(drive):
    with Crowd(TRIAL_PUSH) as crowd:
        seen = [repr(crowd), repr(crowd.run(drive, until=0.4)), repr(crowd.save())]
        assert seen[0] == "<Crowd of 5 people, Trial 'Trial_push', at 0 s>"
        assert seen[1] == "<Run of 5 people from 0 s to 0.4 s, 9 communication points>"
        seen += [repr(crowd), repr(drive)]
        assert seen[3] == "<Crowd of 5 people, Trial 'Trial_push', at 0.4 s>"
    assert repr(crowd) == "<Crowd, closed>"
    assert all(len(line) < 100 and "\n" not in line for line in seen)


def test_refusals_name_the_variable_and_the_value():
    cases = [
        ({"agent[1].Mass": -3.0}, "agent[1].Mass=-3.0: must be positive"),
        ({"agent[*].Mass": float("nan")}, "agent[0].Mass=NaN: must be finite"),
        ({"agent[5].Mass": 70.0}, "agent[5].Mass=70.0: there is no such variable"),
        ({"agent[1].Maß": 70.0}, 'did you mean "agent[1].Mass"?'),
        ({"Threads": 1.5}, "Threads=1.5: not a number"),
        ({"agent[3].Active": "no"}, "neither true nor false"),
        ({"Trial": "nowhere"}, "nowhere"),
        ({"AgentContacts": 1}, "AgentContacts=1: it is computed"),
    ]
    for parameters, words in cases:
        with pytest.raises(SimulationError) as refusal:
            Crowd(TRIAL_PUSH, parameters)
        assert words in str(refusal.value), refusal.value
    with pytest.raises(TypeError, match="neither a number"):
        Crowd(TRIAL_PUSH, {"agent[1].Mass": [1.0]})
    with Crowd(TRIAL_PUSH) as crowd:
        with pytest.raises(SimulationError, match="agent.0..Fp.x = NaN: must be finite"):
            crowd.set_drive(np.full((5, 3), np.nan))
        with pytest.raises(ValueError, match=r"\(3, 5\)"):
            crowd.set_drive(np.zeros((3, 5)))
        with pytest.raises(SimulationError, match="step"):
            crowd.step(-0.05)
        with pytest.raises(SimulationError, match="agent.9..Mass: there is no such variable"):
            crowd["agent[9].Mass"]
        crowd.step()
        assert crowd.time == STEP
    with pytest.raises(SimulationError, match="closed"):
        crowd.poses()


@pytest.mark.parametrize("time", [float("nan"), float("inf"), -float("inf")])
def test_times_that_are_no_numbers_are_refused(time):
    start = f"(?i)start time {time} s: must be finite"
    with pytest.raises(SimulationError, match=start):
        Crowd(TRIAL_PUSH, start=time)
    with Crowd(TRIAL_PUSH) as crowd:
        for step in (crowd.step, crowd.step_to):
            with pytest.raises(SimulationError, match=f"(?i)communication step to {time} s: must be finite, and after 0.0 s"):
                step(time)
        with pytest.raises(SimulationError, match=r"communication step to 0.0 s: must be finite, and after 0.0 s"):
            crowd.step_to(0.0)
        with pytest.raises(ValueError, match="not a finite number"):
            crowd.run(until=time)
        with pytest.raises(SimulationError, match=start):
            crowd.reset(start=time)


@pytest.mark.parametrize("lie", [np.asfortranarray, lambda array: array[..., ::-1].copy()[..., ::-1]], ids=["columns", "backwards"])
def test_the_extension_reads_arrays_however_they_lie_in_memory(lemons, lie):
    from lemons_fmu import _native

    model = _native.Model.read(os.fspath(TRIAL_PUSH))
    pushes = 100.0 + np.arange(15.0).reshape(5, 3)
    drives = []
    for array in (pushes, lie(pushes)):
        simulation = _native.Simulation(model, "jacobi")
        simulation.begin(0.0)
        simulation.push(array)
        drives.append(simulation.drive())
    assert (drives[0] == pushes).all() and (drives[1] == pushes).all()
    active = np.array([True, False, True, True, True])
    simulation.set_active(lie(active))
    simulation.step_to(0.05)
    assert (simulation.observe()[:, _native.NUMBERS.index("active")] == active).all()
    ends = []
    for order in (np.ascontiguousarray, lie):
        simulation = _native.Simulation(model, "jacobi")
        simulation.begin(0.0)
        recording = _native.Recording(simulation, 0.1, 0.05, True)
        recording.push([1, 4], order(np.arange(12.0).reshape(2, 2, 3)))
        recording.advance(simulation, 2, 600.0)
        ends.append(simulation.observe())
    assert (ends[0] == ends[1]).all()
    with Crowd(TRIAL_PUSH) as crowd:
        run = crowd.run(until=0.5)
    again = dataclasses.replace(run, times=lie(run.times), numbers=lie(run.numbers))
    assert plot(again, at=[0.5]).data == plot(run, at=[0.5]).data


def test_the_extension_refuses_what_has_another_shape(drive):
    """Nobody but the package calls it; a panic would end a host all the same."""
    from lemons_fmu import _native

    model = _native.Model.read(os.fspath(TRIAL_PUSH))
    simulation = _native.Simulation(model, "jacobi")
    for early in (simulation.observe, simulation.drive, lambda: simulation.step_to(1.0)):
        with pytest.raises(SimulationError, match="the simulation has not begun"):
            early()
    with pytest.raises(SimulationError, match="has not begun"):
        _native.Recording(simulation, 1.0, 0.05, True)
    simulation.begin(0.0)
    people = len(model.ids)
    for shape in (0, 3), (people + 1, 3), (people, 2), (people, 4), (people - 1, 3):
        with pytest.raises(ValueError, match=r"the array has the shape \[\d+, \d+\], not \[5, 3\]"):
            simulation.push(np.zeros(shape))
    for count in (0, people - 1, people + 1):
        with pytest.raises(ValueError, match=r"the array has the shape \[\d+\], not \[5\]"):
            simulation.set_active(np.ones(count, bool))
    recording = _native.Recording(simulation, 1.0, 0.05, True)
    for agents, shape in ([0], (20, 2, 3)), ([0], (19, 1, 3)), ([0], (20, 1, 2)), ([], (20, 1, 3)):
        with pytest.raises(ValueError, match="the array has the shape"):
            recording.push(agents, np.zeros(shape))
    with pytest.raises(IndexError, match="agent 5: there are 5 agents"):
        recording.push([5], np.zeros((20, 1, 3)))
    with pytest.raises(SimulationError, match=r"agent\[3\].Fp.y = NaN: must be finite"):
        recording.push([0, 3], np.where(np.arange(120) == 4, np.nan, 0.0).reshape(20, 2, 3))
    for seconds in (float("nan"), -1.0, float("inf")):
        with pytest.raises(ValueError, match="a duration of"):
            recording.advance(simulation, 1, seconds)
        with pytest.raises(ValueError, match="a duration of"):
            _native.Task(["info"]).wait(seconds)
    room = _native.Simulation(_native.Model.read(os.fspath(TRIAL_DOOR)), "jacobi")
    with pytest.raises(SimulationError, match="another simulation"):
        recording.advance(room, 1, 1.0)
    study = _native.Study([("agent[0].Mass", [60.0, 70.0])], True, os.fspath(TRIAL_PUSH), None, True)
    for wrong in (lambda: study.value(1, 0), lambda: study.value(0, 2), lambda: study.place(2)):
        with pytest.raises(IndexError):
            wrong()


def test_a_name_of_any_length_makes_a_short_message(lemons, tmp_path):
    decision = tmp_path / "decision.toml"
    decision.write_text(f"{'x' * 60_000} = 3\n")
    with pytest.raises(CommandError) as raised:
        Crowd(TRIAL_PUSH, decision=decision)
    done = subprocess.run([lemons, "run", TRIAL_PUSH, "--decision", decision], capture_output=True, text=True, cwd=tmp_path)
    for said in str(raised.value), done.stderr:
        assert "decision.toml" in said and "x… 598" in said and " characters …x" in said and len(said) < 1500, said


def test_threads_have_crowds_of_their_own(drive):
    frictions = [0.0, 0.2, 0.4, 0.8]
    alone = [simulate(TRIAL_PUSH, drive, {FRICTION: friction}, 1.0) for friction in frictions]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda friction: simulate(TRIAL_PUSH, drive, {FRICTION: friction}, 1.0), frictions * 3))
    for place, table in enumerate(together):
        assert table.equals(alone[place % 4])


def test_messages_of_a_crowd_are_its_own(shared):
    with Crowd(shared / "data/crowds/dense_100") as crowd, Crowd(TRIAL_PUSH) as quiet:
        assert any("overlap" in message for message in crowd.messages)
        assert quiet.messages == []


def test_arrays_are_writable_and_are_not_the_crowd():
    """They own their memory: who writes into them changes nothing else."""
    with Crowd(TRIAL_PUSH) as crowd:
        before = crowd.poses().copy()
        crowd.poses()[:] = 7.0
        assert (crowd.poses() == before).all()
        seen = crowd.run(until=0.2)
    assert seen.numbers.flags.c_contiguous and seen.poses.base is not None
    seen.poses[0] = 1.0
    assert (seen.numbers[0, :, :3] == 1.0).all()


def test_progress_is_told_to_a_function(monkeypatch):
    monkeypatch.setattr(sys.modules["lemons_fmu.crowd"], "_PART", 0.0)
    seen = []
    with Crowd(TRIAL_PUSH) as crowd:
        crowd.run(until=0.5, progress=seen.append)
    assert [each.done for each in seen] == list(range(1, 11)) and seen[-1].total == 10


INTERRUPTED = """
import os, signal, sys, threading, time
from lemons_fmu import Crowd, crowd

begun = threading.Event()

def interrupt():
    begun.wait()
    for _ in range(50):  # another thread, which runs meanwhile
        time.sleep(0.001)
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=interrupt, daemon=True).start()
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    if sys.argv[1] == "run":
        with Crowd(sys.argv[2]) as people:
            begun.set()
            people.run(until=1000.0, step=0.05)
    else:
        begun.set()
        crowd(number=40000, box=(80, 80), output=sys.argv[2])
    print("it was not stopped")
except KeyboardInterrupt:
    print("stopped")
"""


@pytest.mark.parametrize("what", ["run", "crowd"])
def test_ctrl_c_ends_what_takes_long(tmp_path, what):
    """In the middle of a run; other threads run meanwhile. Nothing is left of a crowd that is not complete."""
    given = TRIAL_DOOR if what == "run" else tmp_path / "out"
    done = limited.run([sys.executable, "-c", INTERRUPTED, what, given], LIMIT, stdout=subprocess.PIPE)
    assert done.stdout == "stopped\n" and done.returncode == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "heads, words",
    [("t,id,x\n0,0,0\n", "columns"), ("t,id,x,y\n0,0,0,zero\n", "line 2"), ("t,id,x,y\n", "no trajectories")],
)
def test_a_bad_measurement_is_refused(tmp_path, heads, words):
    (tmp_path / "external_force_per_mass.txt").write_text("TimeS ForcePerMassNperM\n0 0\n1 2\n")
    (tmp_path / "measured_head_trajectories.csv").write_text(heads)
    with pytest.raises(ValueError, match=words):
        Push.read(tmp_path)


def test_what_is_found_by_its_name_is_a_regular_file_of_a_bounded_size(tmp_path):
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
        with pytest.raises(OSError, match=f"{name}: it is a pipe, not a regular file"):
            Push.read(tmp_path)
        path.unlink()
        path.symlink_to("/dev/zero")
        with pytest.raises(OSError, match=f"{name}: it is a device, not a regular file"):
            Push.read(tmp_path)
        path.unlink()
        with open(path, "wb") as file:
            file.truncate(500_000_001)  # no byte of it is on the disk
        with pytest.raises(OSError, match=f"{name}: it is larger than 500 MB, the limit"):
            Push.read(tmp_path)
        path.write_bytes(b"t,id,x,y\n\xff\n")
        with pytest.raises(ValueError, match=f"{name}: it is not UTF-8 text"):
            Push.read(tmp_path)
        path.write_text(text)


# Imports the package where nothing is installed but what it requires.
BARE = """
import importlib.abc, json, sys

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        there = name.startswith("_sysconfigdata") or name.split(".")[0] in sys.stdlib_module_names
        if not there and name.split(".")[0] not in ("lemons_fmu", "lemons_command", *sys.argv[2].split()):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
import lemons_fmu as l

with l.Crowd(sys.argv[1]) as people:
    run = people.run(until=0.1)
said = [repr(run), len(l.person(breadth=0.49, depth=0.25, stature=1.75, mass=70).disks), l.plot(run).data[:1].decode()]
table = lambda: [][run.poses.size]  # an IndexError, not an ImportError: nothing is simulated before
tables = {
    "frame": run.frame,
    "simulate": lambda: l.simulate(sys.argv[1], lambda crowd: table()),
    "measure": run.measure,
    "sweep": lambda: l.sweep(sys.argv[1], {"agent[1].Mass": [60.0]}, False, len, until=0.1),
    "cluster": l.local_cluster,
    "hdf5": lambda: run.export("run.h5", to="hdf5"),
}
for name, make in tables.items():
    try:
        make()
    except ImportError as error:
        said.append(f"{name}: {error}")
print(json.dumps(said))
"""


def project():
    return tomllib.loads((REPOSITORY / "python" / "pyproject.toml").read_text())["project"]


def test_extras_are_named_where_they_are_missing(tmp_path):
    """A crowd is stepped and drawn without them."""
    required = " ".join(re.match(r"[\w-]+", each)[0] for each in project()["dependencies"])
    assert required == "numpy"
    done = subprocess.run([sys.executable, "-c", BARE, TRIAL_PUSH, required], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [
        "<Run of 5 people from 0 s to 0.1 s, 3 communication points>",
        5,
        "<",
        "frame: a table needs pandas: pip install 'lemons-fmu[tables]'",
        "simulate: a table needs pandas: pip install 'lemons-fmu[tables]'",
        "measure: a table needs pandas: pip install 'lemons-fmu[tables]'",
        "sweep: a sweep needs pandas: pip install 'lemons-fmu[sweep]'",
        "cluster: a cluster needs cloudpickle: pip install 'lemons-fmu[sweep]'",
        "hdf5: HDF5 needs h5py: pip install 'lemons-fmu[hdf5]'",
    ]
    # What is named brings what is missing.
    extras = {name: {re.match(r"[\w-]+(\[\w+\])?", each)[0] for each in brought} for name, brought in project()["optional-dependencies"].items()}
    assert extras["tables"] == {"pandas"} and extras["hdf5"] == {"h5py"}
    assert extras["sweep"] == {"cloudpickle", "dask", "distributed", "lemons-fmu[tables]"}


@pytest.mark.parametrize("platform", ["linux", pytest.param("win32", marks=pytest.mark.long)])
def test_types(platform):
    pytest.importorskip("mypy", reason="mypy is not installed for this Python")
    # What is cached of one platform does not hold for the other.
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--cache-dir", REPOSITORY / ".mypy_cache" / platform]
    done = subprocess.run([*command, "--platform", platform, "src"], cwd=REPOSITORY / "python", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.long
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
    assert (tmp_path / "results.csv").is_file()


def test_the_package_installs(tmp_path):
    """From a copy, without network, with the extension that is beside its source."""
    copy = shutil.copytree(REPOSITORY / "python", tmp_path / "python", ignore=shutil.ignore_patterns("__pycache__"))
    place = tmp_path / "site"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--target", place, copy], check=True, capture_output=True)
    assert (place / "lemons_fmu" / "py.typed").exists()
    code = "import sys, lemons_fmu as l; print(l.__file__); print(len(l.simulate(sys.argv[1], until=0.1)))"
    environment = {**os.environ, "PYTHONPATH": str(place)}
    done = subprocess.run([sys.executable, "-c", code, TRIAL_PUSH], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.splitlines() == [str(place / "lemons_fmu" / "__init__.py"), "15"], done.stderr


@pytest.mark.parametrize("state", [b"abc", None, "state"])
def test_only_a_state_is_restored(state):
    with Crowd(TRIAL_PUSH) as crowd, Crowd(TRIAL_DOOR) as other:
        before = crowd.poses()
        with pytest.raises(TypeError, match=rf"of type {type(state).__name__}; it must be a State"):
            crowd.restore(state)
        for bad in (State(0.0, b"abc"), other.save()):
            with pytest.raises(SimulationError, match="the state is damaged or is not a state of this Trial"):
                crowd.restore(bad)
        assert (crowd.poses() == before).all()
