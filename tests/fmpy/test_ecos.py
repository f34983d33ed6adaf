"""ecos, by its Python package."""

from crowd import bits, push_job, two_pushes_job
from masters import run


def test_push(push_fmu, pushed, row):
    job = push_job(push_fmu, 40)
    seen, said = run("ecos", job)
    assert said == ""
    assert bits(seen) == bits(pushed(job.steps, job.step))
    row("ecospy", "inputs set at each step", "same bits as `lemons run`")


def test_two_instances(push_fmu, row):
    job = two_pushes_job(push_fmu, 40)
    seen, said = run("ecos", job)
    assert said == ""
    assert bits(seen) == bits(run("fmpy", job)[0])
    assert all(numbers[:50] != numbers[50:] for numbers in seen[20:])
    row("ecospy", "two instances in one process, a parameter set in one", "same bits as FMPy")


def test_reset(push_fmu, pushed, row):
    job = push_job(push_fmu, 40, resets=1)
    seen, said = run("ecos", job)
    assert said == ""
    assert bits(seen) == 2 * bits(pushed(job.steps, job.step))
    row("ecospy", "reset, and all again", "same bits again")
