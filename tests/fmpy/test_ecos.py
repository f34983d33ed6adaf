"""ecos, by its Python package."""

from crowd import bits, push_job
from masters import run


def test_push(push_fmu, pushed, row):
    job = push_job(push_fmu, 40)
    seen, said = run("ecos", job)
    assert said == ""
    assert bits(seen) == bits(pushed(job.steps, job.step))
    row("ecospy", "inputs set at each step", "same bits as `lemons run`")
