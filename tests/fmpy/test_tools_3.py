"""FMI 3.0 in other tools than FMPy's functions: what each does, and what it cannot do, with its own words.

A row that says that a tool cannot do something fails when the tool has learned it.
"""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig

import pytest
from crowd import TRIAL_PUSH
from test_fmutool import check

STEP = 1 / 16  # s


@pytest.fixture
def push_fmu_3(pack):
    return pack(TRIAL_PUSH, options=["--fmi", "3"])


def script(text, *arguments):
    """Runs Python in a process of its own: a crash of a tool is not one of the tests, and ecos finds its libraries only so."""
    libraries = [os.path.join(sysconfig.get_path("data"), "lib"), os.environ.get("LD_LIBRARY_PATH")]
    environment = {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(filter(None, libraries))}
    command = [sys.executable, "-c", text, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment)


@pytest.mark.parametrize("name", ["crowd", "Decision"])
def test_fmutool(push_fmu_3, decide, row, name):
    code, said = check(push_fmu_3 if name == "crowd" else decide("--fmi", "3"))
    assert code == 0, said
    assert "seems to be compliant with FMI-3.0" in said and "No semantic error against the FMI-3 standard" in said
    assert "ERROR" not in said and "WARNING" not in said
    row("fmu-manipulation-toolbox", f"FMI 3.0: `fmutool -check`, {name}", "compliant, no semantic error")


def fmpy(*arguments):
    done = subprocess.run([sys.executable, "-m", "fmpy", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def table(path):
    with path.open() as file:
        return [{name: [float(n) for n in value.split()] for name, value in line.items()} for line in csv.DictReader(file)]


def test_command_of_fmpy(push_fmu, push_fmu_3, tmp_path, row):
    """Its table has sixteen digits of each number of an array, but all of a single one."""

    def written(number):
        return float(f"{number:.16g}")

    assert "No problems found" in fmpy("validate", push_fmu_3)
    assert "46" in next(line for line in fmpy("info", push_fmu_3).splitlines() if "Variables  " in line)
    for fmu, name in [(push_fmu, "two"), (push_fmu_3, "three")]:
        start = ["agent[0].Velocity.x", "1.5"] if name == "two" else ["Velocity", "1.5 0 0 0 0 0 0 0 0 0"]
        times = ["--stop-time", 1.0, "--step-size", STEP, "--output-interval", STEP]
        fmpy("simulate", fmu, *times, "--start-values", *start, "--output-file", tmp_path / f"{name}.csv")
    two, three = table(tmp_path / "two.csv"), table(tmp_path / "three.csv")
    assert len(two) == len(three) == 17
    for scalars, arrays in zip(two, three):
        for i in range(5):
            for axis, of in enumerate("xy"):
                assert arrays["Position"][2 * i + axis] == written(scalars[f"agent[{i}].Position.{of}"][0])
            assert arrays["PeakNormalForce"][i] == written(scalars[f"agent[{i}].PeakNormalForce"][0])
    assert three[-1]["Position"][0] > 0.1 and max(max(line["PeakNormalForce"]) for line in three) > 100.0
    row("fmpy", "FMI 3.0: `fmpy validate`, `fmpy info`, `fmpy simulate`", "no problem; the numbers of the FMI 2.0 FMU, to the 16 digits that it writes of arrays")


ECOS = """
import json, sys
from ecospy import EcosSimulation, EcosSimulationStructure
from ecospy.lib import EcosLib
EcosLib.set_log_level("debug")
path, step, steps, parameter, value, *names = sys.argv[1:]
with EcosSimulationStructure() as structure:
    structure.add_model("crowd", path)
    structure.add_parameter_set("job", {"crowd::" + parameter: float(value)})
    with EcosSimulation(structure=structure, step_size=float(step)) as simulation:
        simulation.init(parameter_set="job")
        seen = []
        for _ in range(int(steps)):
            simulation.step()
            seen.append([getattr(simulation, "get_" + kind)("crowd::" + name) for kind, name in json.loads(names[0])])
        simulation.terminate()
print(json.dumps(seen))
"""


def ecos(fmu, steps, parameter, value, names):
    done = script(ECOS, fmu, STEP, steps, parameter, value, json.dumps(names))
    assert done.returncode == 0, done.stderr
    *said, seen = done.stdout.splitlines()
    return json.loads(seen), "\n".join([*said, *done.stderr.splitlines()])


def test_ecos(pack, tmp_path, row):
    """Single values of both versions, while one person walks into the next: ecos cannot set the arrays of drives."""
    trial = shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_moving")
    dynamics = trial / "dynamic" / "AgentDynamics.xml"
    text, changed = re.subn('Velocity="[^"]*"', 'Velocity="1.5,0"', dynamics.read_text(), count=1)
    assert changed == 1
    dynamics.write_text(text)
    names = [["real", "LargestOverlap"], ["integer", "CoincidentContacts"]]
    options = [], ["--fmi", "3"]
    two, three = (ecos(pack(trial, options=o), 20, "TimeStepMechanical", 1e-5, names)[0] for o in options)
    assert two == three and len({overlap for overlap, _ in three}) > 2
    row("ecospy", "FMI 3.0: single values (`LargestOverlap`), a parameter set", "same bits as the FMI 2.0 FMU")


def test_ecos_and_arrays(push_fmu_3, row):
    seen, said = ecos(push_fmu_3, 1, "TimeStepMechanical", 1e-5, [["real", "Position"]])
    assert "fmi3GetFloat64: 1 values for variables of 10 elements together" in said and seen == [[0.0]], said
    row("ecospy", "FMI 3.0: arrays", "not read: it asks for one value of each variable, and shows 0")


COSIM = """
import sys
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimSlave import CosimLocalSlave
from libcosimpy._internal import get_last_error_message
log_output_level(CosimLogLevel.ERROR)
slave = CosimLocalSlave(sys.argv[1], "crowd")
print(bool(slave.ptr()), get_last_error_message())
"""


def test_libcosim(push_fmu, push_fmu_3, row):
    if sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    assert script(COSIM, push_fmu).stdout.startswith("True")
    done = script(COSIM, push_fmu_3)
    assert done.stdout.startswith("False Unsupported feature: Unsupported FMI version for FMU"), done
    row("libcosimpy", "FMI 3.0", "refused: `Unsupported FMI version`")
