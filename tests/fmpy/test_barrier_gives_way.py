"""The barrier of examples/controllers, an FMU of FMI 2.0 in C: closed forms; and coupled with a crowd, in several masters."""

import csv
import importlib.util
import subprocess
import sys

import numpy as np
import pytest
from crowd import REPOSITORY, Crowd
from fmpy import extract
from fmpy.validation import validate_fmu
from masters import Job, run

MASS, STIFFNESS, STRENGTH, TRAVEL = 20.0, 5e5, 3000.0, 0.05  # of a metre: kg, N/m, N; m
STEP = 1 / 64  # s
OUTPUTS = ["Deflection", "Plastic", "door[0].Open"]


@pytest.fixture(scope="module")
def example(lemons):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LEMONS", str(lemons))
        spec = importlib.util.spec_from_file_location("barrier_gives_way", REPOSITORY / "examples/barrier_gives_way.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def gate(example, tmp_path_factory):
    directory = tmp_path_factory.mktemp("gate")
    example.make(directory)
    return directory


@pytest.fixture
def barrier(gate, tmp_path):
    """Instances with these parameters, under a load [N/m] from 0 s on: Deflection, Plastic and Open at each step."""
    made = []

    def bent(load, until, **parameters):
        fmu = Crowd(extract(gate / "barrier.fmu", tmp_path / str(len(made)))).instantiate()
        made.append(fmu)
        for name, value in parameters.items():
            fmu[name] = value
        fmu.initialize()
        fmu["barrier[0].Load"] = load
        seen = []
        for _ in range(round(until / 1e-3)):
            fmu.step(1e-3)
            seen.append([fmu[name] for name in OUTPUTS])
        return np.array(seen, float).T

    yield bent
    for fmu in made:
        fmu.free()


def test_closed_forms(barrier, gate):
    """Of an undamped oscillator under a sudden load; of one that yields, by the work of the load; of one that is damped."""
    assert validate_fmu(str(gate / "barrier.fmu")) == []
    times = 1e-3 * np.arange(1, 101)
    elastic, plastic, is_open = barrier(1000.0, 0.1, Damping=0.0)
    wanted = 1000.0 / STIFFNESS * (1.0 - np.cos(np.sqrt(STIFFNESS / MASS) * times))
    # Symplectic Euler is of first order.
    assert abs(elastic - wanted).max() < 0.05 * wanted.max() and not plastic.any() and not is_open.any()
    for load in (1600.0, 2500.0, 2800.0):
        bent, stays, is_open = barrier(load, 0.5, Damping=0.0)
        most = STRENGTH**2 / (2.0 * STIFFNESS * (STRENGTH - load))
        assert bent.max() == pytest.approx(most, rel=0.05)
        assert stays[-1] == pytest.approx(most - STRENGTH / STIFFNESS, rel=0.2) and not is_open.any()
    # It comes to rest where the spring holds the load; or falls, since no spring does.
    bent, stays, _ = barrier(2000.0, 2.0, Damping=2000.0)
    assert bent[-1] == pytest.approx(2000.0 / STIFFNESS + stays[-1], abs=1e-9)
    bent, _, is_open = barrier(3100.0, 2.0)
    assert is_open[-1] and TRAVEL < bent[-1] < 1.1 * TRAVEL


@pytest.mark.parametrize("tool", ["libcosimpy", "ecospy"])
def test_masters_agree(example, gate, row, tool):
    if tool == "libcosimpy" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    steps = 960
    fmus = {name: str(gate / f"{name}.fmu") for name in ("decision", "barrier", "people")}
    watch = [["barrier", name] for name in OUTPUTS] + [["people", f"agent[{i}].Position.x"] for i in range(60)]
    job = Job(fmus=fmus, steps=steps, step=STEP, ssp=str(gate / "gate.ssp"), watch=watch)
    seen, said = run(tool.removesuffix("py"), job)
    assert said == ""
    rows = example.simulate(gate, "jacobi", steps * STEP, "--step", repr(STEP))
    ours = [[float(row["barrier.Deflection"]), float(row["barrier.Plastic"]), row["barrier.door[0].Open"] == "true"] for row in rows[1:]]
    assert [[*line[:2], bool(line[2])] for line in seen] == ours
    # It has fallen, and people have walked over it.
    assert ours[-1][2] and max(seen[-1][3:]) > 6.3
    row(tool, "the SSP of a crowd, Decision and `barrier.c`, until the barrier has fallen", "same bits as `lemons run`, Jacobi")


def test_a_run_says_how_pictures_show_its_door(gate, lemons, tmp_path):
    done = subprocess.run([lemons, "run", gate / "gate.ssp", "--until", "0.1", "-o", tmp_path / "t.csv"], capture_output=True, text=True)
    assert done.returncode == 0 and "people: door[0].Open connected" in done.stderr and "by the times" in done.stderr


@pytest.fixture(scope="module")
def thousand(example, gate, lemons, tmp_path_factory):
    """A thousand people in a summary FMU, and the barrier: two connections."""
    directory = tmp_path_factory.mktemp("thousand")

    def run_here(*words):
        subprocess.run([lemons, *words], check=True, capture_output=True, cwd=directory)

    scenario = example.SCENARIO
    for small, large in {"6.0": "20.0", "3.0": "13.0", "1.5": "6.5", "= 60": "= 1000", "10.0": "100.0"}.items():
        assert small in scenario
        scenario = scenario.replace(small, large)
    (directory / "hall.toml").write_text(scenario)
    run_here("crowd", "--scenario", "hall.toml", "-o", "hall")
    run_here("pack", "hall", "--interface", "summary", "--panel", "5", "-o", "hall.fmu")
    both = ["--connection", "hall.barrier1_load=barrier.barrier[0].Load", "--connection", "barrier.door[0].Open=hall.door1_open"]
    run_here("connect", "hall.fmu", gate / "barrier.fmu", *both, "-o", "hall.ssp")
    options = ["--step", repr(STEP), "--until", repr(THOUSAND_STEPS * STEP), "--algorithm", "jacobi"]
    run_here("run", "hall.ssp", *options, "--outputs", "outputs.csv")
    return directory


THOUSAND = [("barrier", name) for name in OUTPUTS] + [("hall", name) for name in ("barrier1_load", "exit1_queue", "people_left")]
THOUSAND_STEPS = 448


@pytest.mark.long
@pytest.mark.parametrize("tool", ["libcosimpy", "ecospy"])
def test_a_thousand_people(gate, thousand, row, tool):
    if tool == "libcosimpy" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    fmus = {"hall": str(thousand / "hall.fmu"), "barrier": str(gate / "barrier.fmu")}
    job = Job(fmus=fmus, steps=THOUSAND_STEPS, step=STEP, ssp=str(thousand / "hall.ssp"), watch=[list(of) for of in THOUSAND])
    seen, said = run(tool.removesuffix("py"), job)
    assert said == ""
    with (thousand / "outputs.csv").open() as file:
        table = list(csv.DictReader(file))[1:]
    is_open = {"false": 0.0, "true": 1.0}
    cells = [[line[".".join(of)] for of in THOUSAND] for line in table]
    ours = [[is_open[cell] if cell in is_open else float(cell) for cell in line] for line in cells]
    assert [[float(value) for value in line] for line in seen] == ours
    # Many lean on it until it falls, then people leave.
    assert max(line[3] for line in ours) > 3000.0 and ours[-1][2] and ours[-1][5] > 0
    row(tool, "the SSP of a summary FMU of 1000 people and `barrier.c`, until the barrier has fallen", "same bits as `lemons run`, Jacobi")
