"""The controller examples/controllers/cautious.py, made an FMU by pythonfmu, drives the crowd's FMU."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from math import hypot
from pathlib import Path

import numpy as np
import pytest
from crowd import CONTACTS, INPUTS, MOTION, REPOSITORY, TRIAL_PUSH, bits
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from masters import Job, run

AGENTS = TRIAL_PUSH / "static" / "Agents.xml"
SPEED = 1.2  # m/s: the start value of WalkingSpeed
TOLERATED = 200.0  # N: the start value of ToleratedForce
STEPS = 96  # 6 s
WATCHED = [*MOTION, *CONTACTS, "MeanNormalForce"]


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    directory = tmp_path_factory.mktemp("controller")
    script = REPOSITORY / "examples" / "controllers" / "cautious.py"
    command = [Path(sys.executable).with_name("pythonfmu"), "build", "-f", script, AGENTS]
    subprocess.run(command, check=True, cwd=directory, capture_output=True)
    return directory / "Cautious.fmu"


@pytest.fixture
def job(push_fmu, controller):
    """The two FMUs, connected by names: each output with the other's input of the same name."""
    fmus = {"crowd": str(push_fmu), "controller": str(controller)}
    names = {
        (instance, causality): [v.name for v in read_model_description(path).modelVariables if v.causality == causality]
        for instance, path in fmus.items()
        for causality in ["input", "output"]
    }
    connections = [
        [[source, name], [sink, name]]
        for source, sink in [("crowd", "controller"), ("controller", "crowd")]
        for name in names[source, "output"]
        if name in names[sink, "input"]
    ]
    inputs = sorted(names["crowd", "input"]) + sorted(names["controller", "input"])
    assert len(inputs) == 5 * (4 + 4)
    # Nobody leaves by this controller.
    driven = sorted(name for name in inputs if not name.endswith(".Active"))
    assert sorted(sink[1] for _, sink in connections) == driven, "every other input is connected"
    watch = [["crowd", f"agent[{i}].{name}"] for i in range(5) for name in WATCHED]
    watch += [["controller", f"agent[{i}].{name}"] for i in range(5) for name in INPUTS]
    return Job(fmus=fmus, steps=STEPS, watch=watch, connections=connections)


def parts(seen):
    """Of each step: the crowd's outputs and the controller's, agent by agent."""
    for numbers in seen:
        crowd, drive = numbers[:50], numbers[50:]
        yield [(crowd[10 * i : 10 * i + 10], drive[3 * i : 3 * i + 3]) for i in range(5)]


def test_built(controller, row):
    assert validate_fmu(str(controller)) == []
    row("pythonfmu", "`pythonfmu build` of `cautious.py`", "an FMU in which FMPy finds no problem")


def test_who_is_squeezed_walks_more_slowly(job, row):
    seen, said = run("fmpy", job)
    assert said == ""
    # The force at which somebody walks freely: Fp = m * FloorDamping * v.
    free = [float(a.get("Mass")) * float(a.get("FloorDamping")) * SPEED for a in ElementTree.parse(AGENTS).getroot()]
    steps = list(parts(seen))
    squeezed = 0
    for now, after in zip(steps, steps[1:]):
        for i, ((state, _), (_, drive)) in enumerate(zip(now, after)):
            # With 1 m/s per metre from the target at (1.4, 0).
            distance = hypot(1.4 - state[0], state[1])
            force, limit = hypot(*drive[:2]), free[i] * min(1.0, distance / SPEED)
            assert force <= limit * (1 + 1e-12)
            if state[-1] == 0.0:
                assert force == pytest.approx(limit, rel=1e-12)
            elif state[-1] > TOLERATED:
                assert force < limit / 2
                squeezed += 1
    assert squeezed > 50
    row("pythonfmu", "`cautious.py` and the crowd, connected by names, under FMPy", "who is squeezed pushes less")


def test_caution_lessens_the_squeeze(job):
    job.steps = 2 * STEPS
    forces = []
    for tolerated in [20.0, 1e9]:
        job.parameters = [[["controller", "ToleratedForce"], tolerated]]
        forces.append(squeeze(run("fmpy", job)[0]))
    assert forces[0] < 0.7 * forces[1], forces


def squeeze(seen):
    """[N] mean over people and the second half of the time."""
    forces = [state[-1] for step in list(parts(seen))[len(seen) // 2 :] for state, _ in step]
    return sum(forces) / len(forces)


@pytest.mark.parametrize("tool", ["libcosimpy", "ecospy"])
def test_other_masters(job, row, tool):
    if tool == "libcosimpy" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    job.parameters = [[["controller", "ToleratedForce"], 150.0]]
    seen, said = run(tool.removesuffix("py"), job)
    assert said == ""
    assert max(state[-1] for step in parts(seen) for state, _ in step) > TOLERATED
    assert bits(seen) == bits(run("fmpy", job)[0])
    row(tool, "`cautious.py` (pythonfmu) and the crowd, connected", "same bits as FMPy with the same algorithm")
