"""The turnstile of examples/controllers, an FMU of FMI 3.0 in C: what it does is computed again with NumPy."""

import csv
import ctypes
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pages
import pytest
from arrays import Fmu
from crowd import REPOSITORY, bits
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

STEP = 1 / 64  # s: sums of it are exact, so that all have the same times
LINE, LIMIT, DISTANCE = 9.0, 150.0, 1.0  # m, N, m: a low limit, so that it closes early
SETTINGS = {"Line": LINE, "Limit": LIMIT, "Distance": DISTANCE}
STEPS = 576
ORDER = ["decision", "turnstile", "crowd"]
# From, name, to, name.
CONNECTIONS = [
    *(("crowd", name, "decision", name) for name in ("Position", "Theta", "Velocity")),
    *(("crowd", name, "turnstile", name) for name in ("Position", "MeanNormalForce")),
    ("decision", "Fp", "turnstile", "Wanted"),
    ("turnstile", "Fp", "crowd", "Fp"),
    *(("decision", name, "crowd", name) for name in ("Mp", "Active")),
]


@pytest.fixture(scope="module")
def hall(lemons, tmp_path_factory):
    """The first crowd of examples/turnstile.py: its directory, and the number of people."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LEMONS", str(lemons))
        spec = importlib.util.spec_from_file_location("scene", REPOSITORY / "examples" / "turnstile.py")
        scene = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(scene)
    directory = tmp_path_factory.mktemp("hall")
    scene.make(directory, 1)
    return directory, scene.PEOPLE


def of_agents(rows, component, name, agents):
    """Of a table, the values of each row and agent."""
    return np.array([[float(row[f"{component}.agent[{i}].{name}"]) for i in range(agents)] for row in rows])


def gate(times, x, force, line, limit, hysteresis):
    """Squeeze and Open at the end of each step, from x [m] and the mean force [N] of everybody at its beginning.

    The low pass is written as what it means: the convolution of a force that is constant in each step with exp(-t/1 s).
    """
    seen, is_open = [], True
    for k in range(len(x)):
        ends = times[k + 1] - times[: k + 2]
        weights = np.exp(-ends[1:]) - np.exp(-ends[:-1])
        beyond = (weights @ force[: k + 1])[x[k] > line]
        squeeze = beyond.max() if len(beyond) else 0.0
        is_open = False if squeeze > limit else True if squeeze < (1.0 - hysteresis) * limit else is_open
        seen.append((squeeze, is_open))
    return map(np.array, zip(*seen))


def test_valid(hall, tmp_path, row):
    """The description, its start values, and all functions of FMI 3.0."""
    fmu = hall[0] / "turnstile.fmu"
    assert validate_fmu(str(fmu)) == []
    turnstile = Fmu(fmu, tmp_path / "turnstile")
    for name, variable in turnstile.variables.items():
        if variable.start is not None and variable.type == "Float64":
            assert set(turnstile.get(name)) == {float(variable.start)}, name
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h").read_text()
    functions = re.findall(r"^FMI3_Export \w+TYPE +(fmi3\w+);", header, re.MULTILINE)
    library = ctypes.CDLL(next((tmp_path / "turnstile" / "binaries").glob("*/turnstile.*")))
    assert len(functions) == 75 and [name for name in functions if not hasattr(library, name)] == []
    turnstile.free()
    row("fmpy", "FMI 3.0: validate `turnstile.c`, a controller of arrays", "no problem")


def test_what_is_wrong_is_refused(hall, tmp_path):
    turnstile = Fmu(hall[0] / "turnstile.fmu", tmp_path / "turnstile", sizes={"Agents": 3})
    for name, values in [("Fp", [0.0] * 6), ("Wanted", [0.0] * 5), ("Wanted", [0.0] * 7), ("Limit", [float("nan")])]:
        with pytest.raises(FMICallException):
            turnstile.put(name, values)
    with pytest.raises(FMICallException):
        turnstile.slave.setUInt64([turnstile.variables["Agents"].valueReference], [0])
    turnstile.put("Wanted", range(6))
    turnstile.put("Limit", [7.0])
    turnstile.slave.doStep(0.0, 1.0)
    assert turnstile.get("Fp") == list(range(6))
    turnstile.slave.reset()
    assert turnstile.get("Limit") == [500.0] and turnstile.get("Fp") == turnstile.get("Wanted") == [0.0] * 6
    turnstile.free()


@pytest.mark.parametrize("agents", [1, 7])
def test_of_any_people(hall, tmp_path, agents):
    """Random people and unequal steps, another number of people by Configuration Mode."""
    random = np.random.default_rng(agents)
    settings = {"Line": 1.0, "Limit": 300.0, "Hysteresis": 0.4, "Distance": 0.8}
    turnstile = Fmu(hall[0] / "turnstile.fmu", tmp_path / "turnstile", sizes={"Agents": agents}, settings=settings)
    turnstile.slave.exitInitializationMode()
    times = np.concatenate([[0.0], np.cumsum(random.uniform(0.01, 0.3, 400))])
    x = random.uniform(-1.0, 3.0, (400, agents))
    force = random.uniform(0.0, 700.0, (400, agents)) * (1.0 + np.sin(times[:-1, None] / 3.0)) / 2.0
    wanted = random.uniform(-500.0, 500.0, (400, agents, 2))
    squeezes, opens = gate(times, x, force, 1.0, 300.0, 0.4)
    assert 20 < opens.sum() < 380
    for k in range(400):
        turnstile.put("Position", np.stack([x[k], np.zeros(agents)], axis=1).ravel())
        turnstile.put("MeanNormalForce", force[k])
        turnstile.put("Wanted", wanted[k].ravel())
        turnstile.slave.doStep(times[k], times[k + 1] - times[k])
        assert turnstile.get("Squeeze") == pytest.approx([squeezes[k]], rel=1e-9)
        assert turnstile.get("Open") == [opens[k]]
        expected = wanted[k].copy()
        held = ~opens[k] & (x[k] >= 1.0 - 0.8) & (x[k] <= 1.0)
        expected[held, 0] = np.minimum(expected[held, 0], 0.0)
        assert turnstile.get("Fp") == expected.ravel().tolist()
    turnstile.free()


@pytest.fixture(scope="module")
def run_by_lemons(lemons, hall):
    """The rows of the crowd's table by time, and those of the other FMUs."""

    def run(algorithm, limit=LIMIT, name="run"):
        directory, agents = hall
        settings = [word for key, value in {**SETTINGS, "Limit": limit}.items() for word in ("--set", f"turnstile.{key}={value}")]
        tables = ["-o", f"{name}.csv", "--outputs", f"outputs_{name}.csv", "--force"]
        command = [lemons, "run", "hall_1.ssp", "--algorithm", algorithm, "--step", str(STEP), "--until", str(STEPS * STEP), *settings, *tables]
        subprocess.run(command, check=True, capture_output=True, cwd=directory)
        with (directory / f"{name}.csv").open() as crowd, (directory / f"outputs_{name}.csv").open() as others:
            crowd, others = list(csv.DictReader(crowd)), list(csv.DictReader(others))
        assert len(others) == STEPS + 1 and len(crowd) == agents * (STEPS + 1)
        return crowd, others

    return run


def column(rows, name, agents):
    return np.reshape([float(row[name]) for row in rows], (-1, agents))


def test_in_the_hall(hall, run_by_lemons):
    """Gauss-Seidel: at t, Decision, turnstile and crowd step one after the other; the row of t + H has what they said."""
    agents = hall[1]
    crowd, others = run_by_lemons("gauss-seidel")
    x, force = (column(crowd, name, agents)[:-1] for name in ("x", "mean_normal_force"))
    times = np.arange(STEPS + 1) * STEP
    squeezes, opens = gate(times, x, force, LINE, LIMIT, 0.2)
    assert [float(row["turnstile.Squeeze"]) for row in others[1:]] == pytest.approx(squeezes, rel=1e-9)
    assert [row["turnstile.Open"] == "true" for row in others[1:]] == opens.tolist()
    assert 100 < opens.sum() < STEPS - 100
    before = (x >= LINE - DISTANCE) & (x <= LINE)
    held = before & ~opens[:, None]
    wanted, given = ([of_agents(others[1:], name, f"Fp.{axis}", agents) for axis in "xy"] for name in ("decision", "turnstile"))
    assert (given[0][held] <= 0.0).all() and (wanted[0][held] > 0.0).sum() > 100, "nobody is driven to the line"
    assert (given[0] == np.where(held, np.minimum(wanted[0], 0.0), wanted[0])).all() and (given[1] == wanted[1]).all()


def test_one_that_never_closes_changes_nothing(hall, run_by_lemons, lemons):
    directory, _ = hall
    run_by_lemons("gauss-seidel", limit=1e9, name="open")
    command = [lemons, "run", "hall_1", "--step", str(STEP), "--until", str(STEPS * STEP), "-o", "none.csv"]
    command += ["--algorithm", "gauss-seidel", "--force"]
    subprocess.run(command, check=True, capture_output=True, cwd=directory)
    assert (directory / "open.csv").read_bytes() == (directory / "none.csv").read_bytes()


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_fmpy_gives_the_same_bits(hall, run_by_lemons, tmp_path, algorithm, row):
    directory, agents = hall
    crowd, others = run_by_lemons(algorithm)
    fmus = {name: Fmu(directory / f"{name}.fmu", tmp_path / name, settings=SETTINGS if name == "turnstile" else {}) for name in ORDER}

    def pass_on(to=ORDER):
        values = [fmus[source].get(name) for source, name, sink, _ in CONNECTIONS if sink in to]
        for (_, _, sink, name), given in zip([c for c in CONNECTIONS if c[2] in to], values):
            fmus[sink].put(name, given)

    for _ in ORDER:
        pass_on()
    for fmu in fmus.values():
        fmu.slave.exitInitializationMode()
    seen = []
    for k in range(STEPS):
        if algorithm == "jacobi":
            pass_on()
        for name in ORDER:
            if algorithm == "gauss-seidel":
                pass_on([name])
            fmus[name].slave.doStep(k * STEP, STEP)
        seen.append((fmus["crowd"].get("Position"), fmus["turnstile"].get("Squeeze")[0], fmus["turnstile"].get("Open")[0]))
    for fmu in fmus.values():
        fmu.free()
    places = np.stack([column(crowd, name, agents)[1:] for name in "xy"], axis=2).reshape(STEPS, -1).tolist()
    theirs = [(p, float(r["turnstile.Squeeze"]), r["turnstile.Open"] == "true") for p, r in zip(places, others[1:])]
    assert any(not is_open for *_, is_open in theirs)
    assert bits(seen) == bits(theirs)
    row("fmpy", "FMI 3.0: Decision, `turnstile.c` and the crowd, connected by whole arrays", "same bits as `lemons run`, both algorithms")


@pytest.mark.long
def test_the_page(lemons, tmp_path):
    """docs/guide/controller.md: the first crowd is as it says, and in the ranges of its table."""
    page = "docs/guide/controller.md"
    command = [sys.executable, REPOSITORY / "examples/turnstile.py", tmp_path / "scene", "--seeds", "1"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, "LEMONS": str(lemons)})
    lines = [line.split() for line in done.stdout.splitlines()[1:3]]
    assert [line[:2] for line in lines] == [["1", "without"], ["1", "with"]]
    (rows,) = (rows for _, header, rows in pages.tables(page) if "with a turnstile" in header)
    for numbers in zip(rows, *(line[2:6] for line in lines), strict=True):
        for cell, number in zip(numbers[0][1:], numbers[1:], strict=True):
            least, greatest = map(float, re.search(r"\(([\d.]+) to ([\d.]+)\)", cell).groups())
            assert least <= float(number) <= greatest, numbers
    text = " ".join(pages.text_of(page).split())
    assert f"the greatest mean over 1 s of anybody falls from {lines[0][2]} N to {lines[1][2]} N." in text
