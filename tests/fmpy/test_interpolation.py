"""Inputs that vary linearly within a communication step: fmi2SetRealInputDerivatives as FMPy calls it."""

from math import expm1

import numpy as np
import pytest
from crowd import INPUTS
from fmpy import simulate_fmu

RATE, END = 900.0, 0.4  # N/s, s


def simulate(fmu, interval, agent, derivatives):
    # FMPy 0.3.32 serves derivatives of exactly nine inputs, and none at the first sample: it lies before the start.
    names = [f"agent[{i}].{name}" for i in [0, 1, 4] for name in INPUTS]
    end = [RATE * END if name == f"agent[{agent}].Fp.x" else 0.0 for name in names]
    ramp = np.array([(-END, *np.negative(end)), (END, *end)], dtype=[(name, "f8") for name in ["time", *names]])
    return simulate_fmu(
        str(fmu),
        stop_time=END,
        output_interval=interval,
        input=ramp,
        output=[f"agent[{agent}].Velocity.x"],
        start_values={"TimeStepMechanical": 1e-5},
        set_input_derivatives=derivatives,
    )[f"agent[{agent}].Velocity.x"]


def closed_form(mass, rate, t):
    """[m/s] m dv/dt = RATE t - m rate v from rest."""
    return RATE / (mass * rate) * (t + expm1(-rate * t) / rate)


def test_a_ramp_in_one_step(push_fmu, row):
    """Agent 4 is the last of the row: nothing touches it."""
    (*_, found) = simulate(push_fmu, END, 4, derivatives=True)
    assert found == pytest.approx(closed_form(78.0, 4.5, END), abs=1e-12)
    (*_, held) = simulate(push_fmu, END, 4, derivatives=False)
    assert held == 0.0, "without derivatives the first value is held"
    row("fmpy", "`simulate_fmu` with derivatives of the inputs", "the closed form of a force that rises within a step")
