"""References in FMUs, run by FMPy; and the folder of examples that is made of them (packaging/examples.py)."""

import csv
import json
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pages
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH
from fmpy.util import read_csv, read_ref_opt_file
from fmpy.validation import validate_fmu
from test_fmutool import check

DIRECTORY = "extra/org.fmi-standard.fmi-ls-ref"
LS = "{http://fmi-standard.org/fmi-ls-manifest}"
REFERENCE = ["--reference", "--until", "2"]


@pytest.fixture
def referenced(pack, decide):
    """An FMU with a reference: `push`, `door` or `decision`, of a version of FMI."""

    def referenced(name, fmi):
        options = [*REFERENCE, "--fmi", fmi]
        if name == "decision":
            return decide(*options)
        return pack(TRIAL_PUSH if name == "push" else TRIAL_DOOR, options=options)

    return referenced


# FMPy takes inputs of one shape only.
@pytest.mark.parametrize("name, fmi", [("push", "2"), ("push", "3"), ("door", "2"), ("decision", "2")])
def test_the_script_of_the_page_has_the_bits(referenced, tmp_path, name, fmi, row):
    (script,) = (block.text for block in pages.blocks("docs/fmu.md") if "experiments.exp" in block.text)
    assert '"push.fmu"' in script
    script = script.replace('"push.fmu"', repr(str(referenced(name, fmi))))

    def said():
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()[-1]

    assert said() == "largest difference: 0.0"
    # It can fail.
    script = script.replace("stop_time=stop,", "stop_time=stop, start_values={'TimeStepMechanical': 1e-3},")
    if name != "decision":
        assert said() != "largest difference: 0.0"
    version, of = "FMI 3.0: " if fmi == "3" else "", "Decision" if name == "decision" else f"the {name}"
    row("fmpy", f"{version}the reference in the FMU of {of}", "same bits as when it was packed")


def test_what_is_in_the_fmu(lemons, referenced):
    """By the standard's tables and schemas; and checkers accept it."""
    fmu = referenced("push", "2")
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read(f"{DIRECTORY}/fmi-ls-manifest.xml"))
        inside = {name.removeprefix(f"{DIRECTORY}/") for name in archive.namelist() if name.startswith(DIRECTORY)}
        experiments = ElementTree.fromstring(archive.read(f"{DIRECTORY}/experiments.exp"))
    assert root.tag == "fmiReferences"
    assert root.attrib == {
        f"{LS}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        f"{LS}fmi-ls-version": "1.0.0-beta.1",
        f"{LS}fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
    }
    assert {part.get("source") for part in root} == inside - {"fmi-ls-manifest.xml"}
    assert [part.get("role") for part in root] == ["experiment/smoke-test", "other", "result"]
    assert experiments.tag == "Experiments" and experiments.get("name")
    (experiment,) = experiments
    assert [part.tag for part in experiment] == ["TransientSimulation", "Stimuli", "References"]
    assert experiment[0].attrib == {"startTime": "0.0", "stopTime": "2.0", "stepSize": "0.05"}
    assert validate_fmu(str(fmu)) == []
    code, said = check(fmu)
    assert code == 0 and "ERROR" not in said, said


def test_the_same_trial_gives_the_same_bytes(referenced):
    first = referenced("door", "3").read_bytes()
    assert referenced("door", "3").read_bytes() == first


def columns(path):
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def test_the_folder_of_examples(lemons, tmp_path):
    url = "https://example.org/lemons"
    command = [sys.executable, REPOSITORY / "packaging/examples.py", tmp_path, "--url", url]
    subprocess.run(command, check=True, env={"LEMONS": str(lemons), "PATH": ""})
    names = sorted(path.name for path in tmp_path.iterdir() if path.is_dir())
    assert names == [f"{name}_fmi{fmi}" for name in ("decision", "door", "push", "summary") for fmi in "23"]
    for name in names:
        place = tmp_path / name
        assert {path.name for path in place.iterdir()} == {
            "Readme.txt",
            *(f"{name}{end}" for end in (".fmu", "_ref.csv", "_ref.opt")),
            *([] if name.startswith("summary") else [f"{name}_in.csv"]),
        }
        options = read_ref_opt_file(place / f"{name}_ref.opt")
        tables = {of: read_csv(place / f"{name}_{of}.csv") for of in ("ref", "in") if (place / f"{name}_{of}.csv").exists()}
        reference = tables["ref"]
        description = fmpy.read_model_description(place / f"{name}.fmu")
        kinds = {variable.name: variable.causality for variable in description.modelVariables}
        for file, table in tables.items():
            kind = {"ref": "output", "in": "input"}[file]
            path = place / f"{name}_{file}.csv"
            head = path.read_text().splitlines()[0]
            assert head == ",".join(f'"{column}"' for column in table.dtype.names)
            assert table.dtype.names[0] == "time" and np.all(np.diff(table["time"]) > 0)
            assert {kinds[column] for column in table.dtype.names[1:]} == {kind}
            assert path.stat().st_size <= 1_000_000
        assert 1 < len(reference.dtype) <= 11
        assert (reference["time"][0], reference["time"][-1]) == (options["StartTime"], options["StopTime"])
        if name in ("decision_fmi3", "door_fmi3"):
            continue  # FMPy takes inputs of one shape only
        result = fmpy.simulate_fmu(
            place / f"{name}.fmu",
            start_time=options["StartTime"],
            stop_time=options["StopTime"],
            output_interval=options["StepSize"],
            input=tables.get("in"),
            output=list(reference.dtype.names[1:]),
        )
        for column in reference.dtype.names:
            seen = result[column].astype(float).reshape(reference[column].shape)
            assert seen.tobytes() == reference[column].astype(float).tobytes(), column
            assert np.ptp(reference[column]) > 0 or column.startswith(("agent[4]", "people_", "exit")), column
    for name, quantity, axes in [("door", "Position", 2), ("door", "MeanNormalForce", 1), ("decision", "Fp", 2)]:
        singles, arrays = (columns(tmp_path / f"{name}_fmi{fmi}" / f"{name}_fmi{fmi}_ref.csv") for fmi in "23")
        for agent in range(5):
            own = singles[f"agent[{agent}].{quantity}" + (".x" if axes == 2 else "")]
            assert [row.split()[axes * agent] for row in arrays[quantity]] == own
    entry = json.loads((tmp_path / "tools.json").read_text())
    assert entry["examplesUrl"] == entry["url"] == url and not entry["description"].endswith(".")
    readme = (tmp_path / "README.md").read_text()
    assert f"- fmpy {fmpy.__version__}\n" in readme and "- libcosimpy" in readme and "- pythonfmu" not in readme
