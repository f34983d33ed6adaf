"""Runs our FMUs through importers and checkers that no registry of packages has.

    importers.py [FMU…]

Without FMUs, the command (LEMONS, else target/release/lemons) makes four: a push and a Decision, each as FMI 2.0 and 3.0.
A program is found by its environment variable, else on PATH. Prints a row for each program and FMU: `ok`, what the program
said, or what is missing and who makes it. What a program simulates without inputs is compared with `lemons run`. The exit
status is 1 if a program that is here finds a fault, or shows other numbers.
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent
PUSH = ROOT / "resources/Trial_push"
#: [s] A power of two: all importers then have the same times.
STEP, STOP = 0.0625, 2.0
#: [m] Programs that write few digits differ by less.
SAME = 1e-6
#: [s] A program that takes longer is stopped.
LONGEST = 300


@dataclass
class Program:
    """`{fmu}`, `{table}` (its output), `{step}`, `{stop}` and `{intervals}` are filled into the words of each call."""

    name: str
    variable: str
    executables: list[str]
    source: str
    versions: str
    calls: list[str]
    #: Words that what it prints must contain, in each call.
    says: str = ""
    #: Pattern of the errors that it prints, where it ends with 0 in spite of them.
    errors: str | None = None
    launcher: list[str] = field(default_factory=list)

    def command(self) -> list[str] | None:
        found = os.environ.get(self.variable) or next(filter(None, map(shutil.which, self.executables)), None)
        return [*self.launcher, found] if found else None


SIMULATES = "--stop-time {stop} --output-interval {step} --output-file {table}"
PROGRAMS = [
    Program(
        "fmusim",
        "FMUSIM",
        ["fmusim"],
        "its newer form with sub-commands, of the authors of FMPy",
        "23",
        ["validate {fmu}", "simulate {fmu} --interface-type cs " + SIMULATES],
    ),
    Program(
        "fmi-sim",
        "FMI_SIM",
        ["fmi-sim"],
        "of the project rust-fmi: cargo install fmi-sim, which needs libclang",
        "2",  # docs/fmi.md says why
        ["--model {fmu} --output-file {table} co-simulation --step {step} --output-interval {step} -f {stop}"],
    ),
    Program(
        "FMUComplianceChecker",
        "FMUCHECK",
        ["fmuCheck.linux64", "fmuCheck.win64", "fmuCheck"],
        "of the project modelica-tools/FMUComplianceChecker; it contains the FMI Library",
        "2",
        ["-k cs -n 0 -h {step} -s {stop} -o {table} {fmu}"],
    ),
    Program(
        "VDMCheck2",
        "VDMCHECK2",
        [],
        "a jar of the project INTO-CPS-Association/FMI-VDM-Model, and Java",
        "2",
        ["{fmu}"],
        "No errors found",
        ["java", "-jar"],
    ),
    Program(
        "VDMCheck3",
        "VDMCHECK3",
        [],
        "a jar of the project INTO-CPS-Association/FMI-VDM-Model, and Java",
        "3",
        ["{fmu}"],
        "No errors found",
        ["java", "-jar"],
    ),
    Program(
        "OMSimulator",
        "OMSIMULATOR",
        ["OMSimulator"],
        "of the project OpenModelica/OMSimulator",
        "23",
        ["--mode=cs --stopTime={stop} --stepSize={step} --intervals={intervals} --resultFile={table} {fmu}"],
        # It ends with 0 all the same: of FMI 3.0 it reads no arrays, and each of them is an error.
        errors=r"(?m)^error:",
    ),
]


def made(lemons: Path, directory: Path) -> list[Path]:
    fmus = []
    door = ROOT / "resources/Trial_door"
    all_words = {"push": ["pack", PUSH], "decision": ["decide", door], "summary": ["pack", door, "--interface", "summary"]}
    for name, words in all_words.items():
        for version in "23":
            fmus.append(directory / f"{name}_fmi{version}.fmu")
            command = [lemons, *words, "--fmi", version, "-o", fmus[-1]]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return fmus


def version_of(fmu: Path) -> str:
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml")).get("fmiVersion")


def places_of_run(lemons: Path, directory: Path) -> list[float]:
    """x and y of each person at the end of the push, by `lemons run`."""
    table = directory / "run.csv"
    times = ["--step", str(STEP), "--until", str(STOP)]
    subprocess.run([lemons, "run", PUSH, *times, "-o", table], check=True, stdout=subprocess.DEVNULL)
    with table.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if float(row["t"]) == STOP]
    return [float(row[axis]) for row in rows for axis in "xy"]


def places_of_table(table: Path, people: int) -> list[float] | None:
    """The same from a program's table: elements of FMI 2.0, or arrays of FMI 3.0; `None` if it has neither."""
    with table.open(newline="") as file:
        header, *rows = [row for row in csv.reader(file) if row]
    last = dict(zip(map(str.strip, header), rows[-1]))
    if "Position" in last:
        return [float(number) for number in last["Position"].split()]
    elements = [f"agent[{i}].Position.{axis}" for i in range(people) for axis in "xy"]
    found = [next((last[name] for name in last if name.endswith(element)), None) for element in elements]
    return None if None in found else [float(number) for number in found]


def compared(table: Path, wanted: list[float]) -> tuple[bool, str]:
    try:
        places = places_of_table(table, len(wanted) // 2)
    except (OSError, ValueError, IndexError) as error:
        return False, f"its table cannot be read: {error}"
    if places is None or len(places) != len(wanted):
        return False, f"its table lacks places of {len(wanted) // 2} people"
    apart = [abs(ours - theirs) for ours, theirs in zip(wanted, places)]
    if not any(apart):
        return True, "ok, same bits as lemons run"
    # Also true of what is not a number.
    wrong = [distance for distance in apart if not distance <= SAME]
    return not wrong, f"places differ from lemons run by {max(wrong or apart):.1e} m"


def run(program: Program, command: list[str], fmu: Path, wanted: list[float] | None) -> tuple[bool, str]:
    """Whether the program finds no fault, and what it says."""
    with tempfile.TemporaryDirectory() as scratch:
        table = Path(scratch) / "table.csv"
        values = {"fmu": fmu, "table": table, "step": STEP, "stop": STOP, "intervals": round(STOP / STEP)}
        for call in program.calls:
            words = [word.format(**values) for word in call.split()]
            try:
                done = subprocess.run([*command, *words], capture_output=True, text=True, errors="replace", cwd=scratch, timeout=LONGEST)
            except (OSError, subprocess.TimeoutExpired) as error:
                return False, str(error)
            said = f"{done.stdout}\n{done.stderr}"
            errors = len(re.findall(program.errors, said)) if program.errors else 0
            if done.returncode or errors or program.says not in said:
                lines = [line for line in said.splitlines() if line.strip()]
                telling = [line for line in lines if re.search("error|fail|fatal|panic", line, re.IGNORECASE)] or lines[-3:]
                counted = f", {errors} errors" if errors else ""
                return False, f"exit status {done.returncode}{counted}: " + " / ".join(telling[:5])
        if "{table}" in program.calls[-1]:
            if not table.is_file():
                return False, "it wrote no table"
            if wanted:
                return compared(table, wanted)
    return True, "ok"


def main() -> int:
    lemons = Path(os.environ.get("LEMONS") or ROOT / "target/release/lemons").resolve()
    faults = 0
    with tempfile.TemporaryDirectory() as scratch:
        directory = Path(scratch)
        given = [Path(fmu).resolve() for fmu in sys.argv[1:]]
        fmus = given or made(lemons, directory)
        wanted = None if given else places_of_run(lemons, directory)
        for program in PROGRAMS:
            command = program.command()
            for fmu in fmus:
                version = version_of(fmu)
                if version[0] not in program.versions:
                    continue
                result = f"not here: needs {program.variable}, or it on PATH ({program.source})"
                if command:
                    good, result = run(program, command, fmu, wanted if fmu.name.startswith("push") else None)
                    faults += not good
                print(f"{program.name} | FMI {version} | {fmu.name} | {result}", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
