"""One crowd as an FMI 2.0 and as an FMI 3.0 FMU: what reading it and exchanging values costs.

    pip install fmpy
    cargo build --release
    python benches/fmi_versions.py [--agents 10000]

People stand on a grid, each with a mass, place and direction of its own, so that start values differ. Both FMUs are packed
from this Trial. Times are processor times: of `fmpy.read_model_description` without validation (the least of three), and of
the C functions (the median of 200 calls, the library loaded by ctypes) that set Fp and Mp and get positions, directions,
velocities, angular velocities, mean squeeze and the three numbers of contacts of everybody.
"""

import argparse
import ctypes
import os
import pathlib
import random
import re
import statistics
import subprocess
import tempfile
import time
import zipfile

import numpy as np
from fmpy import extract, read_model_description

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target").resolve() / "release"
LEMONS = os.environ.get("LEMONS") or TARGET / "lemons"
Pointer = ctypes.c_void_p


def write_trial(directory, agents):
    """The bodies of resources/Trial_push, again and again, on a grid."""
    source = ROOT / "resources" / "Trial_push"
    for part in "Parameters.xml", "static/Geometry.xml", "static/Materials.xml":
        (directory / part).parent.mkdir(parents=True, exist_ok=True)
        (directory / part).write_text((source / part).read_text())
    bodies = re.findall(r"<Agent .*?</Agent>", (source / "static/Agents.xml").read_text(), re.DOTALL)
    draw, columns = random.Random(1), int(agents**0.5)
    fixed, moving = [], []
    for i in range(agents):
        body = re.sub(r'Id="[^"]*"', f'Id="{i}"', bodies[i % len(bodies)], count=1)
        fixed.append(re.sub(r'Mass="[^"]*"', f'Mass="{draw.uniform(60, 100)!r}"', body, count=1))
        x, y = (2 + 0.6 * k + draw.uniform(0, 0.1) for k in (i % columns, i // columns))
        moving.append(
            f'<Agent Id="{i}"><Kinematics Position="{x!r},{y!r}" Velocity="0.0,0.0" Theta="{draw.uniform(-3, 3)!r}" Omega="0.0"/>'
            '<Dynamics Fp="0.0,0.0" Mp="0.0"/></Agent>'
        )
    (directory / "dynamic").mkdir()
    (directory / "static/Agents.xml").write_text("<Agents>\n" + "\n".join(fixed) + "\n</Agents>\n")
    (directory / "dynamic/AgentDynamics.xml").write_text("<Agents>\n" + "\n".join(moving) + "\n</Agents>\n")


def function(library, name, *arguments, result=ctypes.c_int):
    found = library[name]
    found.argtypes, found.restype = arguments, result
    return found


def instance_2(directory, library, token):
    callbacks = (Pointer * 5)()  # fmi2CallbackFunctions: all may be NULL
    text = ctypes.c_char_p
    make = function(library, "fmi2Instantiate", text, ctypes.c_int, text, text, Pointer, *[ctypes.c_int] * 2, result=Pointer)
    uri = (directory / "resources").as_uri().encode()
    instance = make(b"crowd", 1, token.encode(), uri, ctypes.addressof(callbacks), 0, 0)
    times = Pointer, ctypes.c_int, ctypes.c_double, ctypes.c_double, ctypes.c_int, ctypes.c_double
    assert function(library, "fmi2SetupExperiment", *times)(instance, 0, 0.0, 0.0, 0, 0.0) == 0
    for name in "fmi2EnterInitializationMode", "fmi2ExitInitializationMode":
        assert function(library, name, Pointer)(instance) == 0
    return instance


def instance_3(directory, library, token):
    flag, text = ctypes.c_bool, ctypes.c_char_p
    rest = [Pointer, ctypes.c_size_t, Pointer, Pointer, Pointer]
    make = function(library, "fmi3InstantiateCoSimulation", text, text, text, *[flag] * 4, *rest, result=Pointer)
    path = str(directory / "resources").encode()
    instance = make(b"crowd", token.encode(), path, *[False] * 4, None, 0, None, None, None)
    times = Pointer, flag, ctypes.c_double, ctypes.c_double, flag, ctypes.c_double
    assert function(library, "fmi3EnterInitializationMode", *times)(instance, False, 0.0, 0.0, False, 0.0) == 0
    assert function(library, "fmi3ExitInitializationMode", Pointer)(instance) == 0
    return instance


SCALARS = {
    "Real in": ["Fp.x", "Fp.y", "Mp"],
    "Real out": ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega", "MeanNormalForce"],
    "Integer out": ["AgentContacts", "WallContacts", "ContactingAgents"],
}
ARRAYS = {
    "Real in": ["Fp", "Mp"],
    "Real out": ["Position", "Theta", "Velocity", "Omega", "MeanNormalForce"],
    "Integer out": ["AgentContacts", "WallContacts", "ContactingAgents"],
}


def exchange(version, instance, library, references, agents):
    """The median processor time [s] of all three calls together."""
    calls = []
    names = {"Real in": ("SetReal", "SetFloat64"), "Real out": ("GetReal", "GetFloat64"), "Integer out": ("GetInteger", "GetInt32")}
    for what, (second, third) in names.items():
        values = np.zeros(len(SCALARS[what]) * agents, dtype="i4" if "Integer" in what else "f8")
        if version == 2:
            wanted = [references[f"agent[{i}].{name}"] for i in range(agents) for name in SCALARS[what]]
            call = function(library, f"fmi2{second}", Pointer, Pointer, ctypes.c_size_t, Pointer)
            rest = ()
        else:
            wanted = [references[name] for name in ARRAYS[what]]
            call = function(library, f"fmi3{third}", Pointer, Pointer, ctypes.c_size_t, Pointer, ctypes.c_size_t)
            rest = (len(values),)
        wanted = np.array(wanted, dtype="u4")
        calls.append((call, wanted, values, rest))
    took = []
    for _ in range(200):
        start = time.process_time_ns()
        statuses = [call(instance, w.ctypes.data, len(w), v.ctypes.data, *rest) for call, w, v, rest in calls]
        took.append((time.process_time_ns() - start) * 1e-9)
        assert statuses == [0, 0, 0]
    return statistics.median(took)


def measured(version, trial, directory, agents):
    fmu = directory / f"crowd{version}.fmu"
    options = ["--flat-names"] if version == 2 else []
    command = [LEMONS, "pack", trial, "--fmi", str(version), "-o", fmu, *options]
    subprocess.run(command, check=True, capture_output=True)
    with zipfile.ZipFile(fmu) as archive:
        size = archive.getinfo("modelDescription.xml").file_size
    reading = []
    for _ in range(3):
        start = time.process_time()
        description = read_model_description(fmu, validate=False)
        reading.append(time.process_time() - start)
    unpacked = pathlib.Path(extract(fmu, directory / f"crowd{version}"))
    library = ctypes.CDLL(str(next((unpacked / "binaries").glob("*/CrowdMechanics.*"))))
    instance = (instance_2 if version == 2 else instance_3)(unpacked, library, description.guid)
    assert instance, "an instance"
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    values = exchange(version, instance, library, references, agents)
    return len(references), size, min(reading), values


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=10_000)
    agents = parser.parse_args().agents
    with tempfile.TemporaryDirectory() as scratch:
        trial = pathlib.Path(scratch) / "Trial"
        trial.mkdir()
        write_trial(trial, agents)
        columns = [measured(version, trial, pathlib.Path(scratch), agents) for version in (2, 3)]
    (count, size, reading, values), (count3, size3, reading3, values3) = columns
    print(f"| {agents} people | FMI 2.0 | FMI 3.0 |\n|---|---|---|")
    print(f"| variables | {count} | {count3} |")
    print(f"| `modelDescription.xml` [MB] | {size / 1e6:.1f} | {size3 / 1e6:.1f} |")
    print(f"| FMPy reads it [s] | {reading:.2f} | {reading3:.2f} |")
    print(f"| set 3 and get 10 quantities of everybody [ms] | {values * 1e3:.2f} | {values3 * 1e3:.2f} |")


if __name__ == "__main__":
    main()
