"""Parameters, start values, the choice of the Trial, XML output."""

import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from math import inf, nan

import pytest
from crowd import TRIAL_PUSH, Crowd, bits, push_drive, refused, write_trial

HUMANS = "contact.human_naked.human_naked"
PARAMETERS = {
    "TimeStepMechanical": 5e-6,
    "material.human_naked.YoungModulus": 3e6,
    "material.human_naked.ShearModulus": 1.2e6,
    f"{HUMANS}.GammaNormal": 300.0,
    f"{HUMANS}.GammaTangential": 300.0,
    f"{HUMANS}.KineticFriction": 0.05,
    "agent[1].Mass": 80.0,
    "agent[1].MomentOfInertia": 2.0,
    "agent[1].FloorDamping": 1.0,
    "agent[1].AngularDamping": 1.0,
}
MUST_BE_POSITIVE = ["TimeStepMechanical", "agent[1].Mass", "agent[1].MomentOfInertia"] + [
    name for name in PARAMETERS if name.startswith("material.")
]
STEPS = 14  # to 0.7 s: the third agent has been hit


@pytest.fixture(scope="module")
def usual(push_directory):
    """The push with the Trial's own parameters."""
    crowd = Crowd(push_directory).instantiate()
    yield crowd.initialize().run(STEPS, 0.05, push_drive())
    crowd.free()


@pytest.mark.parametrize("name, value", PARAMETERS.items())
def test_parameter_changes_the_result(push, usual, name, value):
    push[name] = value
    push.initialize()
    assert push[name] == value
    assert bits(push.run(STEPS, 0.05, push_drive())) != bits(usual)


@pytest.mark.parametrize("name", PARAMETERS)
def test_start_value_is_the_trials(push, usual, name):
    push[name] = float(push.variables[name].start)
    assert bits(push.initialize().run(STEPS, 0.05, push_drive())) == bits(usual)


def test_threads_change_nothing(push, usual):
    push["Threads"] = 3
    assert bits(push.initialize().run(STEPS, 0.05, push_drive())) == bits(usual)


@pytest.mark.parametrize("name, value", [*PARAMETERS.items(), ("Threads", 2), ("Trial", "Trial_push")])
def test_parameter_is_refused_after_initialization(push, usual, name, value):
    push.initialize()
    before = push[name]
    with refused(push, name, "after initialization"):
        push[name] = value
    assert push[name] == before
    assert bits(push.run(STEPS, 0.05, push_drive())) == bits(usual)


@pytest.mark.parametrize(
    "name, value",
    [(name, value) for name in PARAMETERS for value in [-1.0, nan, inf]] + [(name, 0.0) for name in MUST_BE_POSITIVE],
)
def test_unphysical_parameter_is_refused(push, name, value):
    with refused(push, name, "must be"):
        push[name] = value
    push.initialize()
    assert push[name] == float(push.variables[name].start)


def test_other_refused_values(push):
    for value in [0, -1]:
        with refused(push, "Threads", "must be"):
            push["Threads"] = value
    for name in ["AgentContacts", "agent[0].NormalForce"]:
        with refused(push, name, "computed"):
            push[name] = 1
    push.initialize()
    for value in [nan, inf, -inf]:
        with refused(push, "agent[3].Fp.y", "finite"):
            push["agent[3].Fp.y"] = value
    assert push["agent[3].Fp.y"] == 0.0


def test_one_refused_value_refuses_the_call(push):
    names = ["agent[0].Mass", "agent[1].Mass"]
    references = [push.variables[name].valueReference for name in names]
    with refused(push, "agent[1].Mass"):
        push.fmu.setReal(references, [70.0, -1.0])
    push.initialize()
    assert push.fmu.getReal(references) == [89.0, 63.0]


def test_moduli_without_stiffness_are_refused(push):
    """k_n and k_t need YoungModulus below 4 and 6 times ShearModulus."""
    push["material.human_naked.YoungModulus"] = 1e9
    push.fmu.setupExperiment()
    push.fmu.enterInitializationMode()
    with refused(push, "human_naked"):
        push.fmu.exitInitializationMode()
    push["material.human_naked.YoungModulus"] = 4e6
    push.fmu.exitInitializationMode()


def test_start_pose_can_be_set_until_initialization_ends(push):
    push["agent[1].Position.x"] = 0.3
    push["agent[1].Velocity.y"] = 0.25
    push.fmu.setupExperiment()
    push.fmu.enterInitializationMode()
    assert (push["agent[1].Position.x"], push["agent[1].Velocity.y"]) == (0.3, 0.25)
    push["agent[1].Theta"] = 1.5
    # Close behind agent 0: contacts at once.
    push["agent[1].Position.x"] = 0.2
    assert push["agent[0].AgentContacts"] > 0
    push.fmu.exitInitializationMode()
    assert (push["agent[1].Position.x"], push["agent[1].Theta"]) == (0.2, 1.5)
    assert push["agent[0].ContactingAgents"] == 1
    assert push["agent[0].NormalForce"] > 0.0
    for name in ["Position.x", "Theta", "Velocity.y", "Omega"]:
        with refused(push, f"agent[1].{name}", "after initialization"):
            push[f"agent[1].{name}"] = 0.0


def test_trial_chooses_a_packed_trial(pack, instantiate, tmp_path):
    other = shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_other")
    agents = other / "static" / "Agents.xml"
    agents.write_text(agents.read_text().replace('Mass="63.0"', 'Mass="40.0"'))
    both = pack(TRIAL_PUSH, other)
    wanted = instantiate(pack(other)).initialize().run(STEPS, 0.05, push_drive())

    crowd = instantiate(both)
    with refused(crowd, "Trial", "Trial_push, Trial_other"):
        crowd["Trial"] = "Trial_absent"
    crowd["Trial"] = "Trial_other"
    seen = crowd.initialize().run(STEPS, 0.05, push_drive())
    assert (crowd["Trial"], crowd["agent[1].Mass"]) == ("Trial_other", 40.0)
    assert bits(seen) == bits(wanted)

    crowd.fmu.reset()
    crowd.initialize()
    assert (crowd["Trial"], crowd["agent[1].Mass"]) == ("Trial_push", 63.0)


def test_trials_of_different_variables_are_not_packed_together(lemons, tmp_path):
    other = write_trial(tmp_path / "Trial_other", [{"mass": 80.0, "x": 0.0}])
    output = tmp_path / "both.fmu"
    done = subprocess.run([lemons, "pack", TRIAL_PUSH, other, "-o", output], capture_output=True, text=True)
    assert done.returncode != 0
    assert "Trial_other" in done.stderr
    assert not output.exists()


def test_output_directory(pack, instantiate, tmp_path):
    """A walker who comes to lean on a wall; files are named as in the paper's script."""
    walker = {"mass": 80.0, "x": 1.5, "vx": 1.0, "fx": 160.0, "rate": 2.0}
    wall = [(2.0, -1.0), (2.0, 1.0)]
    crowd = instantiate(pack(write_trial(tmp_path / "Trial", [walker], [wall], damping=2e4)))
    output = tmp_path / "output"
    output.mkdir()
    crowd["OutputDirectory"] = str(output)
    seen = crowd.initialize().run(12, 0.1)
    times = [f"{k / 10:.1f}" for k in range(1, 13)]
    touching = [t for t, (_, [walker]) in zip(times, seen) if walker[7]]
    assert touching and len(touching) < 11 and times[-1] in touching
    names = [f"AgentDynamics output t={t}.xml" for t in times] + [f"AgentInteractions t={t}.xml" for t in touching]
    assert sorted(path.name for path in output.iterdir()) == sorted(names)
    for t, (_, [walker]) in zip(times, seen):
        kinematics = ElementTree.parse(output / f"AgentDynamics output t={t}.xml").find("Agent/Kinematics")
        written = ",".join(kinematics.get(name) for name in ["Position", "Velocity", "Theta", "Omega"])
        assert bits([float(number) for number in written.split(",")]) == bits(walker[:6])
    interactions = (output / f"AgentInteractions t={times[-1]}.xml").read_text()
    assert "<Wall" in interactions and "TangentialRelativeDisplacement" in interactions


def test_output_directory_that_is_missing_is_made(push, tmp_path):
    push["OutputDirectory"] = str(tmp_path / "absent" / "one")
    push.initialize().step(0.05)
    assert (tmp_path / "absent" / "one" / "AgentDynamics output t=0.05.xml").exists()


def test_output_of_an_earlier_run_is_not_taken_for_this_ones(push, tmp_path):
    stale = tmp_path / "AgentInteractions t=0.05.xml"
    stale.write_text("<Interactions/>")
    push["OutputDirectory"] = str(tmp_path)
    push.initialize().step(0.05)
    assert push["AgentContacts"] == push["WallContacts"] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["AgentDynamics output t=0.05.xml"]


def test_parameters_that_may_be_a_mistake_are_warned_of(push):
    push["TimeStepMechanical"] = 0.05
    push["agent[1].Position.x"] = 0.1
    push.initialize()
    said = "\n".join(push.messages)
    assert "TimeStepMechanical" in said and "resolves all contacts" in said
    assert "overlap at the start" in said
