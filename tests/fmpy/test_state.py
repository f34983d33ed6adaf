"""Saved and restored states, reset."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from crowd import bits, push_drive

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


def test_reset_gives_the_same_bits_again(push, row):
    first = bits(push.initialize().run(STEPS, 0.05, push_drive()))
    push.fmu.reset()
    assert bits(push.initialize().run(STEPS, 0.05, push_drive())) == first
    row("fmpy", "reset", "same bits again")
