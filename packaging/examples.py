"""Makes the folder of example FMUs for the tools page of fmi-standard.org, as its CONTRIBUTING.md asks for it.

    examples.py DIRECTORY [--url URL] [FMU…]

writes DIRECTORY/NAME/NAME.fmu, NAME_in.csv (if it has inputs), NAME_ref.csv, NAME_ref.opt and Readme.txt of each FMU with
a reference (`lemons pack --reference`), and DIRECTORY/README.md and tools.json: the entry of the page. Without FMUs, the
command (LEMONS, else target/release/lemons) packs those of a release. The importers are those of docs/fmi.md. URL is where
this project and the folder are published.
"""

import argparse
import csv
import io
import json
import os
import re
import subprocess
import tempfile
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = "extra/org.fmi-standard.fmi-ls-ref/"
#: The page wants at most ten important variables, and files of at most 1 MB.
SHOWN, MOST, LARGEST = {"Position", "Position.x", "MeanNormalForce", "Fp", "Fp.x", "Fp.y"}, 10, 1_000_000
#: Of the summary.
SHOWN |= {"area1_density", "area1_squeeze_mean", "area1_squeeze_max", "area1_above", "people_inside"}
#: The FMUs of a release: NAME, the words of `lemons` without those of the version.
RELEASED = {
    "summary": ["pack", "resources/Trial_door", "--interface", "summary", "--area", "door=3,1,5,4", "--until", "5"],
    "push": ["pack", "resources/Trial_push"],
    "door": ["pack", "resources/Trial_door"],
    "decision": ["decide", "resources/Trial_door", "--until", "5"],
}
WHAT = {
    "summary": "Thirty people who leave a room by a door, in a few plain scalars: density and squeeze at the door, speed, a stop.",
    "push": "Five people in a row; the one at the end is pushed, and the push goes through the row.",
    "door": "Thirty people who press through a door into a corridor; forces and torques drive them.",
    "decision": "Where thirty people want to walk: from where they are to the forces that drive them.",
}
FEATURES = """It tests inputs that change at each communication point, files in resources, several instances in a process, reset,
and the state of an FMU (get, set, serialize)."""
#: Tools of docs/fmi.md that check, or make FMUs of their own.
NO_IMPORTERS = ("fmu-manipulation-toolbox", "pyssp_standard", "pythonfmu")


def packed(lemons: Path, directory: Path) -> list[Path]:
    """Packs the FMUs of a release."""
    fmus = []
    for name, words in RELEASED.items():
        for version in ("2", "3"):
            fmus.append(directory / f"{name}_fmi{version}.fmu")
            command = [lemons, *words, "--fmi", version, "--reference", "-o", fmus[-1]]
            subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return fmus


def tools() -> list[str]:
    """The tools of docs/fmi.md, with their versions."""
    page = (ROOT / "docs/fmi.md").read_text()
    rows = re.search("<!-- tools.*?<!-- end -->", page, re.DOTALL)[0].splitlines()
    found = {row.split("|")[1].strip() for row in rows if "`test_" in row}
    return sorted(found | set(re.findall(r"fmi-rs [\d.]+\d", page)), key=str.lower)


def few(table: str) -> str:
    """The time and the important variables of a table of outputs."""
    rows = list(csv.reader(io.StringIO(table)))
    kept = [k for k, name in enumerate(rows[0]) if name.split("].")[-1] in SHOWN][:MOST]
    lines = [[f'"{rows[0][k]}"' for k in (0, *kept)], *([row[k] for k in (0, *kept)] for row in rows[1:])]
    return "".join(",".join(line) + "\n" for line in lines)


def example(fmu: Path, directory: Path) -> None:
    name = fmu.stem
    with zipfile.ZipFile(fmu) as archive:
        read = lambda inside: archive.read(REFERENCE + inside).decode()
        experiment = ElementTree.fromstring(read("experiments.exp")).find("Experiment")
        times = experiment.find("TransientSimulation").attrib
        stimuli, results = experiment.find("Stimuli"), experiment.find("References")
        files = {f"{name}_ref.csv": few(read(results.get("source")))}
        if stimuli is not None:
            files[f"{name}_in.csv"] = read(stimuli.get("source"))
    options = {
        "StartTime": times["startTime"],
        "StopTime": times["stopTime"],
        "StepSize": times["stepSize"],
        # To compare with. As a tolerance for the FMU it would not shorten its mechanical step.
        "RelTol": "1e-4",
    }
    files[f"{name}_ref.opt"] = "".join(f"{key}, {value}\n" for key, value in options.items())
    files["Readme.txt"] = f"""{name}: an FMU for co-simulation, FMI {name[-1]}.0.

{WHAT[name.split("_")[0]]}

{FEATURES}

To run it, set the inputs of {name}_in.csv before each step, from StartTime to StopTime with steps of StepSize.
{name}_ref.csv has the bits of importers that define no tolerance for the FMU (fmi2SetupExperiment, fmi3EnterInitializationMode).
A tolerance can shorten its mechanical step; 1e-4 does not. The FMU contains all of its outputs, by FMI-LS-REF ({REFERENCE}).
"""
    (directory / name).mkdir(parents=True, exist_ok=True)
    (directory / name / f"{name}.fmu").write_bytes(fmu.read_bytes())
    for file, text in files.items():
        assert len(text) <= LARGEST, f"{file}: {len(text)} bytes"
        (directory / name / file).write_text(text, newline="\n")


def entry(url: str | None) -> dict:
    """The entry of tools.json, in the order of its columns."""
    return {
        "name": "LEMONS-FMU",
        "license": "osi",
        **({"url": url} if url else {}),
        "vendor": "LEMONS-FMU developers",
        **({"vendorURL": url, "examplesUrl": url} if url else {}),
        "description": "Contact mechanics of people in dense crowds: makes, runs, couples and draws crowds",
        "features": [],
        "platforms": ["Linux", "Windows"],
        "interfaces": ["GUI", "CLI", "library"],
        "fmiVersions": ["2.0", "3.0"],
        "fmuExport": ["CS"],
        "fmuImport": ["CS"],
    }


def readme(names: list[str], version: str) -> str:
    importers = "".join(f"- {tool}\n" for tool in tools() if not tool.startswith(NO_IMPORTERS))
    checkers = " and ".join(tool for tool in tools() if tool.startswith(("fmpy", "fmu-manipulation-toolbox")))
    return f"""# Example FMUs of LEMONS-FMU {version}

Made by LEMONS-FMU. Each directory has an FMU, its inputs (`_in.csv`), results (`_ref.csv`), the options of the run
(`_ref.opt`) and a Readme: {", ".join(names)}.

## Importers that were tested

What each of them did is in docs/fmi.md of the project.

{importers}
## Checkers

{checkers} (`fmpy validate`, `fmutool -check`) find no problem.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", type=Path)
    parser.add_argument("--url")
    parser.add_argument("fmus", nargs="*", type=Path)
    given = parser.parse_args()
    lemons = Path(os.environ.get("LEMONS", ROOT / "target/release/lemons")).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        fmus = given.fmus or packed(lemons, Path(scratch))
        for fmu in fmus:
            example(fmu, given.directory)
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    (given.directory / "README.md").write_text(readme([fmu.stem for fmu in fmus], version))
    (given.directory / "tools.json").write_text(json.dumps(entry(given.url), indent=4) + "\n")
    if not given.url:
        print("tools.json has no url, vendorURL and examplesUrl: --url URL")


if __name__ == "__main__":
    main()
