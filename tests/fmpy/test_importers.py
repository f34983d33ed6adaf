"""packaging/importers.py: what programs that no registry has do with our FMUs; those that are here, and stand-ins."""

import os
import subprocess
import sys

import pytest
from crowd import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "packaging"))
import importers

pytestmark = pytest.mark.long

SCRIPT = REPOSITORY / "packaging" / "importers.py"

#: A program with the words of fmusim that is FMPy.
FMPY = """
case "$1" in
validate) exec {python} -m fmpy validate "$2" ;;
simulate) exec {python} -m fmpy simulate "$2" --stop-time "$6" --step-size "$8" --output-interval "$8" --output-file "${{10}}" ;;
esac
"""
WRONG = FMPY.replace("exec {python} -m fmpy simulate", "{python} -m fmpy simulate").replace(
    ";;\nesac", "; sed -i 's/^2[.0]*,.*/2.0,{row}/' \"${{10}}\" ;;\nesac"
)


def run(lemons, fmus=(), **programs):
    """The script with these programs only; its exit status, and the rows of a program."""
    others = {program.variable: None for program in importers.PROGRAMS}
    environment = {name: value for name, value in os.environ.items() if name not in others}
    environment |= {"LEMONS": str(lemons), **{name: str(path) for name, path in programs.items()}}
    done = subprocess.run([sys.executable, SCRIPT, *fmus], capture_output=True, text=True, env=environment)
    assert done.stderr == "", done.stderr
    rows = [line.split(" | ") for line in done.stdout.splitlines()]
    return done.returncode, {(program, fmu): said for program, _, fmu, said in rows}


@pytest.fixture
def stand_in(tmp_path):
    def stand_in(text, **words):
        path = tmp_path / "stand in"
        path.write_text("#!/bin/sh\n" + text.format(python=sys.executable, **words))
        path.chmod(0o755)
        return path

    return stand_in


def test_a_program_that_shows_the_same(lemons, stand_in):
    """FMPy in the place of fmusim. Of arrays it writes 16 digits."""
    status, rows = run(lemons, FMUSIM=stand_in(FMPY))
    assert status == 0, rows
    assert rows["fmusim", "push_fmi2.fmu"] == "ok, same bits as lemons run"
    assert rows["fmusim", "push_fmi3.fmu"].endswith("e-17 m") or rows["fmusim", "push_fmi3.fmu"].endswith("e-16 m")
    assert rows["fmusim", "decision_fmi2.fmu"] == rows["fmusim", "decision_fmi3.fmu"] == "ok"


def test_a_program_that_finds_a_fault(lemons, stand_in, push_fmu):
    status, rows = run(lemons, [push_fmu], FMUSIM=stand_in("echo 'Error: no unit m' >&2; echo more; exit 3"))
    assert status == 1
    assert rows["fmusim", push_fmu.name] == "exit status 3: Error: no unit m"


@pytest.mark.parametrize(("row", "said"), [("nan," * 200, "differ"), ("x," * 200, "cannot be read"), ("", "lacks places")])
def test_a_program_that_shows_other_numbers_or_none(lemons, push_fmu, tmp_path, stand_in, row, said):
    wanted = importers.places_of_run(lemons, tmp_path)
    fmusim = importers.PROGRAMS[0]
    good, result = importers.run(fmusim, [str(stand_in(FMPY))], push_fmu, wanted)
    assert good, result
    good, result = importers.run(fmusim, [str(stand_in(WRONG, row=row))], push_fmu, wanted)
    assert not good and said in result


def test_programs_that_are_not_here(lemons, push_fmu):
    """Each says what it needs and who makes it; a jar is never on PATH."""
    status, rows = run(lemons, [push_fmu])
    said = rows["VDMCheck2", push_fmu.name]
    assert said.startswith("not here: needs VDMCHECK2") and "INTO-CPS-Association" in said
    assert ("VDMCheck3", push_fmu.name) not in rows, "that is for FMI 3.0"
    assert status in (0, 1)


def test_those_that_are_here(lemons):
    """What they found is in docs/fmi.md."""
    here = {program.name: program.command() for program in importers.PROGRAMS}
    if not any(here.values()):
        pytest.skip(f"none of these is here: {', '.join(here)}")
    programs = {program.variable: here[program.name][-1] for program in importers.PROGRAMS if here[program.name]}
    status, rows = run(lemons, **programs)
    assert status == 0, rows


#: OMSimulator's words for arrays that it does not read; it ends with 0.
ARRAYS = """
for k in 1 2 3; do echo "error:   [fmi3] Variable $k: arrays are not supported"; done
echo "info:    0 warnings"; echo "info:    3 errors"; exit 0
"""


def test_a_program_that_says_errors_and_ends_with_0(lemons, stand_in, push_fmu):
    status, rows = run(lemons, [push_fmu], OMSIMULATOR=stand_in(ARRAYS))
    [said] = [said for (program, _), said in rows.items() if program == "OMSimulator"]
    assert status == 1 and said.startswith("exit status 0, 3 errors: error:   [fmi3] Variable 1"), said
    fine = 'echo "info:    0 warnings"; echo "info:    0 errors"; exit 0\n'
    for writes, ends in [("", (1, "it wrote no table")), ('for word; do case $word in --resultFile=*) touch "${{word#*=}}";; esac; done\n', (0, "ok"))]:
        status, rows = run(lemons, [push_fmu], OMSIMULATOR=stand_in(writes + fine))
        [said] = [said for (program, _), said in rows.items() if program == "OMSimulator"]
        assert (status, said) == ends
