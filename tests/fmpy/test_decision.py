"""The Decision FMU: the paper's eq. 4 and its way-points, and what FMI asks of every FMU."""

import math

import numpy as np
import pytest
from crowd import TRIAL_DOOR, refused
from fmpy import read_model_description
from fmpy.fmi2 import fmi2Discard
from fmpy.validation import validate_fmu

DRIVE = ["Fp.x", "Fp.y", "Mp"]


@pytest.fixture
def decision(decide, instantiate):
    return instantiate(decide())


def eq4(crowd, i, x, y, theta):
    """Written anew from the paper: F_p = m v0 e / t_transl, tau_p = -I dtheta / t_rot**2, to the first way-point."""
    parameter = {name: crowd[f"agent[{i}].{name}"] for name in ["Mass", "MomentOfInertia", "DesiredSpeed"]}
    t_transl, t_rot = 1 / crowd[f"agent[{i}].FloorDamping"], 1 / crowd[f"agent[{i}].AngularDamping"]
    target = complex(crowd[f"agent[{i}].Waypoint[0].x"] - x, crowd[f"agent[{i}].Waypoint[0].y"] - y)
    direction = target / abs(target)
    force = parameter["Mass"] * parameter["DesiredSpeed"] * direction / t_transl
    mismatch = math.remainder(theta - np.angle(direction), 2 * math.pi)
    return [force.real, force.imag, -parameter["MomentOfInertia"] * mismatch / t_rot**2]


@pytest.mark.parametrize("options", [[], ["--flat-names"]])
def test_validation(decide, options, row):
    assert validate_fmu(str(decide(*options))) == []
    row("fmpy", f"`validate_fmu`, Decision, {'flat' if options else 'structured'} names", "no problem")


def test_it_is_the_papers_equation(decision):
    decision.initialize()
    generator = np.random.default_rng(4)
    for i in range(30):
        for x, y, theta in generator.uniform([-9, -9, -9], [4.6, 9, 9], (10, 3)):
            for name, value in zip(["Position.x", "Position.y", "Theta"], [x, y, theta]):
                decision[f"agent[{i}].{name}"] = value
            found = [decision[f"agent[{i}].{name}"] for name in DRIVE]
            assert found == pytest.approx(eq4(decision, i, x, y, theta), rel=1e-12, abs=1e-9)


def test_starts_are_the_trials(decision):
    """Without any input: where the Trial's people stand."""
    decision.initialize()
    crowd = {name: decision[f"agent[7].{name}"] for name in ["Position.x", "Position.y", "Theta"]}
    dynamics = (TRIAL_DOOR / "dynamic" / "AgentDynamics.xml").read_text()
    assert f'{crowd["Position.x"]:.4f},{crowd["Position.y"]:.4f}' in dynamics
    assert [decision[f"agent[7].{n}"] for n in DRIVE] == pytest.approx(eq4(decision, 7, *crowd.values()), rel=1e-12)


def walk(decision, x, y):
    decision["agent[3].Position.x"], decision["agent[3].Position.y"] = x, y


def test_waypoints_one_after_the_other(decision):
    decision["agent[3].Waypoint[1].x"], decision["agent[3].Waypoint[1].y"] = 5.1, 9.0
    decision.initialize()
    walk(decision, 4.0, 2.5)
    assert decision["agent[3].NextWaypoint"] == 0 and decision["agent[3].Fp.x"] > 0
    walk(decision, 4.8, 2.5)  # within the radius of the first: the outputs follow at once
    assert decision["agent[3].NextWaypoint"] == 1 and decision["agent[3].Fp.y"] > decision["agent[3].Fp.x"] > 0
    walk(decision, 4.0, 2.5)  # without a step in between it was never there
    assert decision["agent[3].NextWaypoint"] == 0
    walk(decision, 4.8, 2.5)
    decision.step(0.05)
    walk(decision, 4.0, 2.5)  # now it was
    assert decision["agent[3].NextWaypoint"] == 1
    assert decision["Arrived"] == 0
    walk(decision, 5.1, 8.8)
    assert decision["Arrived"] == 1 and decision["agent[3].NextWaypoint"] == 2
    assert [decision[f"agent[3].{name}"] for name in DRIVE] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", ["Mass", "MomentOfInertia", "FloorDamping", "AngularDamping"])
def test_parameters(decision, name):
    with refused(decision, f"agent[3].{name}", "-1", status=fmi2Discard):
        decision[f"agent[3].{name}"] = -1.0
    decision[f"agent[3].{name}"] = 2.0
    decision.initialize()
    pose = [decision[f"agent[3].{quantity}"] for quantity in ["Position.x", "Position.y", "Theta"]]
    found = [decision[f"agent[3].{quantity}"] for quantity in DRIVE]
    assert decision[f"agent[3].{name}"] == 2.0
    assert found == pytest.approx(eq4(decision, 3, *pose), rel=1e-12)
    with refused(decision, f"agent[3].{name}", "after initialization"):
        decision[f"agent[3].{name}"] = 3.0


def test_outputs_say_what_they_depend_on(decide):
    description = read_model_description(str(decide()))
    unknowns = {unknown.variable.name: [v.name for v in unknown.dependencies] for unknown in description.outputs}
    assert unknowns["agent[3].Fp.x"] == [f"agent[3].{name}.{axis}" for name in ("Position", "Velocity") for axis in "xy"]
    assert unknowns["agent[3].Mp"] == ["agent[3].Position.x", "agent[3].Position.y", "agent[3].Theta"]
    initial = {unknown.variable.name: [v.name for v in unknown.dependencies] for unknown in description.initialUnknowns}
    assert "agent[3].DesiredSpeed" in initial["agent[3].Fp.x"] and "agent[3].Theta" not in initial["agent[3].Fp.x"]
