"""The FMU against the independent reference of reference.py, over a range of mechanical steps.

A contact begins somewhere within a mechanical step, ends within another, and jumps there, as its damping force does. The engine
takes these times into account, so it is second order, with a factor that depends on where the grid happens to meet each of them.
"""

import json
import pathlib
import shutil
import subprocess

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

import reference

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASES = json.loads((ROOT / "tests" / "reference" / "cases.json").read_text())
STEPS = [1e-4 / 4**k for k in range(6)]  # [s] down to 9.8e-8
MOTION = ("Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega")


def smooth(case):
    return case["name"].endswith("undamped, frictionless")


def run(case, directory, description, step):
    """States of the FMU at the communication points, as in case["states"]."""
    agents = range(case["agents"])
    references = {v.name: v.valueReference for v in description.modelVariables}
    inputs = [references[f"agent[{a}].{name}"] for a in agents for name in ("Fp.x", "Fp.y", "Mp")]
    outputs = [references[f"agent[{a}].{name}"] for a in agents for name in MOTION]
    slave = FMU2Slave(guid=description.guid, unzipDirectory=directory, modelIdentifier=description.coSimulation.modelIdentifier, instanceName=case["name"])
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.setReal([references["TimeStepMechanical"]], [step])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    now, states = 0.0, []
    for end, drive in zip(case["times"], case["drive"]):
        slave.setReal(inputs, [number for agent in drive for number in agent])
        slave.doStep(currentCommunicationPoint=now, communicationStepSize=end - now)
        now = end
        states.append(slave.getReal(outputs))
    slave.terminate()
    slave.freeInstance()
    return np.array(states).reshape(len(states), len(agents), 6)


@pytest.fixture(scope="module")
def differences(lemons, tmp_path_factory):
    """[case, mechanical step, pose or twist]: the largest difference from the reference (m and rad, m/s and rad/s)."""
    out = []
    for number, case in enumerate(CASES):
        scratch = tmp_path_factory.mktemp(f"case{number}")
        for name, text in case["files"].items():
            file = scratch / "trial" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        fmu = scratch / "case.fmu"
        subprocess.run([lemons, "pack", scratch / "trial", "-o", fmu], check=True, stdout=subprocess.DEVNULL)
        description = fmpy.read_model_description(str(fmu))
        directory = fmpy.extract(str(fmu))
        try:
            rows = [np.abs(run(case, directory, description, step) - case["states"]).max(axis=(0, 1)) for step in STEPS]
        finally:
            shutil.rmtree(directory, ignore_errors=True)
        out.append([[row[:3].max(), row[3:].max()] for row in rows])
    return np.array(out)


@pytest.mark.long
def test_the_stored_solutions_are_those_of_the_reference():
    for case in CASES:
        states, simulation = reference.solve(case)
        assert np.abs(np.array(states) - case["states"]).max() < 1e-8, case["name"]
        assert {what: n for what, n in simulation.counts.items() if n} == case["happens"], case["name"]


def test_the_cases_hold_what_they_should():
    happens = {what for case in CASES for what in case["happens"]}
    assert happens >= {"disk", "face", "corner", "passes on", "goes on straight", "goes on around a bend", "two faces"}
    assert happens >= {"ends", "pulls", "slides at once", "starts to slide", "sticks again"}
    assert {case["agents"] for case in CASES} == {1, 2, 3, 4, 5, 6}
    assert len(CASES) == 29 and all(case["moved"] <= 1e-7 and case["loose"] <= 1e-9 for case in CASES)


@pytest.mark.long
def test_the_fmu_tends_to_the_reference(differences, capsys):
    with capsys.disabled():
        print("\n\nlargest difference of the FMU from the reference: poses (m, rad) | twists (m/s, rad/s)")
        heads = " ".join(f"{1e6 * step:6.3g}" for step in STEPS)
        print(f"{'mechanical step [us]':41} agents contacts slides {heads} | {heads}")
        for case, rows in zip(CASES, differences):
            slides = sum(case["happens"].get(what, 0) for what in ("slides at once", "starts to slide"))
            numbers = [" ".join(f"{x:6.0e}" for x in rows[:, k]) for k in (0, 1)]
            print(f"{case['name']:41} {case['agents']:6} {case['happens']['contacts']:8} {slides:6} {numbers[0]} | {numbers[1]}")

    rough = differences[[not smooth(case) for case in CASES]]
    poses, twists = rough[:, -1].max(axis=0)
    assert poses < 1e-8 and twists < 1e-7
    for quantity in (0, 1):  # each doubling of the grid is a new throw of the dice: look at the typical and at the worst case
        typical = np.exp(np.log(rough[:, :, quantity]).mean(axis=0))
        worst = rough[:, :, quantity].max(axis=0)
        for coarse, fine in zip((0, 1, 2, 3), (2, 3, 4, 5)):
            assert typical[fine] < typical[coarse] / (64 if fine < 5 else 16), (coarse, typical)  # round-off at the finest
        assert worst[5] < worst[3] / 16 and worst[3] < worst[1] / 64 and (rough[:, 5, quantity] < rough[:, 0, quantity] / 1000).all()


@pytest.mark.long
def test_without_damping_and_friction_it_is_second_order(differences):
    fair = differences[[smooth(case) for case in CASES]]
    assert len(fair) >= 3
    poses, twists = fair[:, 4].max(axis=0)  # 3.9e-7 s; below it round-off grows
    assert poses < 2e-9 and twists < 1e-8
    typical = np.exp(np.log(fair).mean(axis=0))
    assert (typical[2] < typical[0] / 64).all() and (typical[3] < typical[1] / 64).all()
