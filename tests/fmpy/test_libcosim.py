"""libcosim, by its Python package."""

import sys

import pytest
from crowd import bits, push_job, two_pushes_job
from masters import run

if sys.version_info < (3, 11):
    pytest.skip("libcosimpy has no wheel for this Python", allow_module_level=True)


def test_push(push_fmu, pushed, row):
    job = push_job(push_fmu, 40)
    seen, said = run("libcosim", job)
    assert said == ""
    assert bits(seen) == bits(pushed(job.steps, job.step))
    row("libcosimpy", "inputs overridden at each step", "same bits as `lemons run`")


def test_steps_that_differ_by_rounding(push_fmu, row):
    """At 0.05 s libcosim's steps do, from call to call."""
    job = push_job(push_fmu, 50, step=0.05, nanoseconds=True)
    seen, said = run("libcosim", job)
    assert said == ""
    assert bits(seen) == bits(run("fmpy", job)[0])
    row("libcosimpy", "steps that differ by rounding", "same bits as FMPy with the same steps")


def test_two_instances(push_fmu, row):
    job = two_pushes_job(push_fmu, 40)
    seen, said = run("libcosim", job)
    assert said == ""
    assert bits(seen) == bits(run("fmpy", job)[0])
    assert all(numbers[:50] != numbers[50:] for numbers in seen[20:])
    row("libcosimpy", "two instances in one process, a parameter set in one", "same bits as FMPy")
