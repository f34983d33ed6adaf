"""Saved and restored states, step sizes, reset."""

import json
import subprocess
import sys
from math import inf, nan, nextafter
from pathlib import Path

import pytest
from crowd import bits, push_drive, refused

SAVED, STEPS = 8, 23  # 0.4 s: agents 0 and 1 are in contact


@pytest.fixture
def touching(push):
    """The push in the middle of a contact."""
    push.initialize().run(SAVED, 0.05, push_drive())
    assert push["AgentContacts"] > 0
    return push


def run_on(crowd):
    crowd.time = SAVED * 0.05
    return bits(crowd.run(STEPS, 0.05, push_drive(), first=SAVED))


def test_state_is_restored(touching, row):
    before = bits(touching.look())
    state = touching.fmu.getFMUstate()
    wanted = run_on(touching)
    touching.fmu.setFMUstate(state)
    assert bits(touching.look()) == before
    assert run_on(touching) == wanted
    touching.fmu.terminate()
    touching.fmu.setFMUstate(state)
    assert run_on(touching) == wanted
    touching.fmu.freeFMUstate(state)
    row("fmpy", "get and set the state in the middle of a contact", "same bits as without")


def test_state_goes_to_another_instance_as_bytes(touching, instantiate, push_directory, row):
    state = touching.fmu.getFMUstate()
    data = touching.fmu.serializeFMUstate(state)
    touching.fmu.freeFMUstate(state)
    wanted = run_on(touching)
    other = instantiate(push_directory)
    state = other.fmu.deSerializeFMUstate(data)
    other.fmu.setFMUstate(state)
    assert other.fmu.serializeFMUstate(state) == data
    other.fmu.freeFMUstate(state)
    assert run_on(other) == wanted
    row("fmpy", "the state as bytes to another instance", "same bits as without")


ELSEWHERE = """
import json, sys
sys.path.insert(0, sys.argv[3])
from pathlib import Path
from crowd import Crowd
from test_state import run_on

crowd = Crowd(sys.argv[1]).instantiate()
crowd.fmu.setFMUstate(crowd.fmu.deSerializeFMUstate(Path(sys.argv[2]).read_bytes()))
print(json.dumps(run_on(crowd)))
crowd.free()
"""


def test_state_goes_to_another_process(touching, push_directory, tmp_path, row):
    data = tmp_path / "state"
    data.write_bytes(touching.fmu.serializeFMUstate(touching.fmu.getFMUstate()))
    wanted = run_on(touching)
    command = [sys.executable, "-c", ELSEWHERE, push_directory, data, Path(__file__).parent]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert json.loads(done.stdout) == json.loads(json.dumps(wanted))
    row("fmpy", "the state as bytes to another process", "same bits as without")


def test_state_of_a_dense_crowd(pack, instantiate, shared):
    fmu = pack(shared / "data/crowds/dense_100")
    crowd, other = instantiate(fmu).initialize(), instantiate(fmu)
    crowd.run(10, 0.001)
    assert crowd["AgentContacts"] > 50
    data = crowd.fmu.serializeFMUstate(crowd.fmu.getFMUstate())
    wanted = bits(crowd.run(20, 0.001, first=10))
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(data))
    other.time = 10 * 0.001
    assert bits(other.run(20, 0.001, first=10)) == wanted


def test_parameters_are_part_of_the_state(instantiate, push_directory):
    light, usual = instantiate(push_directory), instantiate(push_directory)
    light["agent[1].Mass"] = 40.0
    light.initialize().run(SAVED, 0.05, push_drive())
    data = light.fmu.serializeFMUstate(light.fmu.getFMUstate())
    usual.initialize()
    usual.fmu.setFMUstate(usual.fmu.deSerializeFMUstate(data))
    assert usual["agent[1].Mass"] == 40.0
    assert run_on(usual) == run_on(light)


def test_damaged_bytes_are_refused(touching):
    state = touching.fmu.getFMUstate()
    data = touching.fmu.serializeFMUstate(state)
    wanted = run_on(touching)
    touching.fmu.setFMUstate(state)
    for place in [0, 8, 12, 28, 35, *range(36, len(data), 97), len(data) - 1]:
        with refused(touching, "state"):
            touching.fmu.deSerializeFMUstate(data[:place] + bytes([data[place] ^ 0x40]) + data[place + 1 :])
    for length in [0, 1, 35, 36, len(data) // 2, len(data) - 1]:
        with refused(touching, "state"):
            touching.fmu.deSerializeFMUstate(data[:length])
    assert run_on(touching) == wanted


def test_state_of_another_model_is_refused(touching, pack, instantiate, shared):
    state = touching.fmu.getFMUstate()
    data = touching.fmu.serializeFMUstate(state)
    other = instantiate(pack(shared / "data/crowds/dense_100")).initialize()
    with refused(other, "another"):
        other.fmu.deSerializeFMUstate(data)


def test_reset_gives_the_same_bits_again(push, row):
    first = bits(push.initialize().run(STEPS, 0.05, push_drive()))
    push.fmu.reset()
    assert bits(push.initialize().run(STEPS, 0.05, push_drive())) == first
    row("fmpy", "reset", "same bits again")


def test_reset_forgets_what_was_set(push):
    usual = bits(push.initialize().run(STEPS, 0.05, push_drive()))
    push.fmu.reset()
    push["agent[1].Mass"] = 40.0
    push["agent[0].Position.y"] = 0.01
    assert bits(push.initialize().run(3, 0.05, push_drive())) != usual[:3]
    push.fmu.reset()
    assert bits(push.initialize().run(STEPS, 0.05, push_drive())) == usual


def displacement(crowd, steps):
    """Of all agents, pushed by a constant force for the given steps."""
    crowd.fmu.reset()
    crowd.initialize()
    crowd["agent[0].Fp.x"] = 400.0
    for step in steps:
        crowd.step(step)
    assert crowd.time == pytest.approx(0.6, abs=1e-12)
    return [number for agent in crowd.look() for number in agent[:6]]


def test_step_sizes_that_differ_by_rounding(push):
    exact = displacement(push, [0.1] * 6)
    shorter, longer = 0.09999999999999998, 0.10000000000000003
    assert displacement(push, [shorter, longer] * 3) == pytest.approx(exact, abs=1e-9)
    ulps = [0.1, nextafter(0.1, 1), nextafter(0.1, 0), 0.1, longer, shorter]
    assert displacement(push, ulps) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("steps", [[0.05] * 12, [0.6], [0.013] * 46 + [0.002], [0.25, 0.35], [1e-7, 0.6 - 1e-7]])
def test_other_step_sizes(push, steps):
    """The integrator's step is H/n: not quite the same, and neither are the results."""
    assert displacement(push, steps) == pytest.approx(displacement(push, [0.1] * 6), abs=1e-4)


def test_wrong_step_is_refused_and_changes_nothing(push):
    drive = push_drive()
    wanted = bits(push.initialize().run(STEPS, 0.05, drive))
    push.fmu.reset()
    push.initialize().run(SAVED, 0.05, drive)
    for step in [0.0, -0.05, nan, inf]:
        with refused(push, "step"):
            push.fmu.doStep(push.time, step)
    for point in [0.0, push.time + 0.05, push.time - 0.001, nan]:
        with refused(push, "communication point"):
            push.fmu.doStep(point, 0.05)
    assert bits(push.run(STEPS, 0.05, drive, first=SAVED)) == wanted[SAVED:]


def test_start_time(push):
    push.initialize(start=7.5)
    with refused(push, "7.5"):
        push.fmu.doStep(0.0, 0.05)
    push.step(0.05)


def test_no_step_beyond_the_stop_time(push):
    push.fmu.setupExperiment(startTime=0.0, stopTime=0.1)
    push.fmu.enterInitializationMode()
    push.fmu.exitInitializationMode()
    push.step(0.05)
    push.step(0.05)
    with refused(push, "stop time"):
        push.step(0.05)
