"""Parameters and start values."""

import pytest
from crowd import Crowd, bits, push_drive, refused

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
