"""One crowd as an FMI 2.0 and as an FMI 3.0 FMU: what reading it and exchanging values costs.

    pip install fmpy
    cargo build --release
    python benches/fmi_versions.py [--agents 10000] [--only 3]

People stand on a grid, each with a mass, place and direction of its own, so that start values differ. Both FMUs are packed
from this Trial. Times are processor times: of `fmpy.read_model_description` without validation (the least of three), of
instantiation and initialization, of the C functions (the median of 200 calls, the library loaded by ctypes) that set Fp and
Mp and get positions, directions, velocities, angular velocities, mean squeeze and the three numbers of contacts of
everybody, and of a communication step of 1 ms. Memory is by how much the process grows: by the description that FMPy keeps,
and by the instance and its first step.
"""

import argparse
import ctypes
import multiprocessing
import os
import pathlib
import random
import re
import statistics
import subprocess
import tempfile
import time
import zipfile
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from fmpy import read_model_description

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


def resident():
    """[MB]"""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def step(version, instance, library):
    place, number = Pointer, ctypes.c_double
    if version == 2:
        return function(library, "fmi2DoStep", Pointer, number, number, ctypes.c_int)(instance, 0.0, 1e-3, 1)
    flags, time = (ctypes.c_bool * 3)(), ctypes.c_double()
    at = ctypes.addressof(flags)
    do = function(library, "fmi3DoStep", Pointer, number, number, ctypes.c_bool, place, place, place, place)
    return do(instance, 0.0, 1e-3, True, at, at + 1, at + 2, ctypes.addressof(time))


def measured(version, trial, directory, agents):
    fmu = directory / f"crowd{version}.fmu"
    options = ["--flat-names"] if version == 2 else []
    command = [LEMONS, "pack", trial, "--fmi", str(version), "-o", fmu, *options]
    subprocess.run(command, check=True, capture_output=True)
    with zipfile.ZipFile(fmu) as archive:
        size = archive.getinfo("modelDescription.xml").file_size
        start = archive.open("modelDescription.xml").read(4096).decode()
    token = re.search(r'(?:guid|instantiationToken)="([^"]*)"', start).group(1)
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(directory / f"crowd{version}")
    unpacked = directory / f"crowd{version}"
    library = ctypes.CDLL(str(next((unpacked / "binaries").glob("*/CrowdMechanics.*"))))
    # First, while the process is small.
    before, start = resident(), time.process_time()
    instance = (instance_2 if version == 2 else instance_3)(unpacked, library, token)
    making = time.process_time() - start
    assert instance, "an instance"
    start = time.process_time()
    assert step(version, instance, library) == 0
    stepping, of_instance = time.process_time() - start, resident() - before
    reading, before = [], resident()
    for _ in range(3):
        start = time.process_time()
        description = read_model_description(fmu, validate=False)
        reading.append(time.process_time() - start)
    of_description = resident() - before
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    values = exchange(version, instance, library, references, agents)
    return {
        "variables": len(references),
        "`modelDescription.xml` [MB]": f"{size / 1e6:.1f}",
        "FMPy reads it [s]": f"{min(reading):.2f}",
        "memory for it in FMPy [MB]": f"{of_description:.0f}",
        "instantiate and initialize [s]": f"{making:.2f}",
        "set 3 and get 10 quantities of everybody [ms]": f"{values * 1e3:.2f}",
        "a step of 1 ms [s]": f"{stepping:.2f}",
        "memory of the instance [MB]": f"{of_instance:.0f}",
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=10_000)
    parser.add_argument("--only", type=int, choices=[2, 3], help="one version of FMI")
    arguments = parser.parse_args()
    versions = [arguments.only] if arguments.only else [2, 3]
    with tempfile.TemporaryDirectory() as scratch:
        trial = pathlib.Path(scratch) / "Trial"
        trial.mkdir()
        write_trial(trial, arguments.agents)
        columns = []
        for version in versions:
            # Memory that one version has left is not to serve the other.
            with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
                done = process.submit(measured, version, trial, pathlib.Path(scratch), arguments.agents)
                columns.append(done.result())
    print(f"| {arguments.agents} people | " + " | ".join(f"FMI {version}.0" for version in versions) + " |")
    print("|---" * (1 + len(versions)) + "|")
    for name in columns[0]:
        print(f"| {name} | " + " | ".join(str(column[name]) for column in columns) + " |")


if __name__ == "__main__":
    main()
