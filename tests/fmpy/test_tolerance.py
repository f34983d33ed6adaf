"""Which tools define a tolerance, and what the crowd makes of it: its mechanical step."""

import sys

import numpy as np
import pytest
from crowd import TRIAL_PUSH, push_job
from fmpy import simulate_fmu
from masters import run

OWN = 2e-6  # s, of the Trial
NEEDED = 4.8e-5  # s, for a tolerance of 1e-4: tests/fmi/tolerance.rs says why
PUSHED = {2: ("agent[0].Velocity.x", 1.5), 3: ("Velocity", [1.5] + 9 * [0.0])}
PLACES = {2: [f"agent[{i}].Position.x" for i in range(5)], 3: ["Position"]}


@pytest.fixture(params=[2, 3])
def fmu(request, pack):
    """A version of FMI, and an FMU of it."""
    return request.param, pack(TRIAL_PUSH, options=["--fmi", str(request.param)])


def simulated(fmu, tolerance, **start):
    """The mechanical step that is used, and where agents are at the end: the first one runs into the others."""
    version, path = fmu
    name, value = PUSHED[version]
    seen = simulate_fmu(
        path,
        stop_time=0.6,
        output_interval=0.05,
        relative_tolerance=tolerance,
        start_values={name: value, **start},
        output=["TimeStepMechanical", *PLACES[version]],
    )
    (step,) = set(seen["TimeStepMechanical"])
    last = np.concatenate([np.ravel(seen[name][-1]) for name in PLACES[version]])
    return step, last


def test_fmpy(fmu, row):
    step, exact = simulated(fmu, None)
    assert step == OWN
    step, places = simulated(fmu, 1e-4)
    assert step == OWN
    assert (places == exact).all()
    step, places = simulated(fmu, 1e-4, TimeStepMechanical=1e-3)
    assert step == NEEDED
    assert 0 < abs(places - exact).max() < 1e-4
    row(
        "fmpy",
        f"FMI {fmu[0]}.0: `simulate_fmu` with and without `relative_tolerance`",
        "by default no tolerance is defined; 1e-4 shortens a mechanical step of 1e-3 s to 4.8e-5 s, and places differ "
        "by less than 0.1 mm; that of the Trial, 2e-6 s, is kept",
    )


@pytest.mark.parametrize("package, tool", [("ecospy", "ecos"), ("libcosimpy", "libcosim")])
def test_others(push_fmu, row, package, tool):
    if tool == "libcosim" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    job = push_job(push_fmu, 2)
    job.watch = [["crowd", "TimeStepMechanical"]]
    seen, said = run(tool, job)
    assert said == ""
    assert seen == [[OWN], [OWN]]
    row(package, "whether it defines a tolerance", "no: the mechanical step is the Trial's")
