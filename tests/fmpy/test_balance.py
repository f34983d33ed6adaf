"""What feet hold and how hard people push, through the whole chain, beside closed forms and SciPy."""

import argparse
import math
import subprocess
from types import SimpleNamespace

import numpy as np
import pages
import pandas as pd
import pytest
from crowd import COLUMNS, REPOSITORY, write_trial
from lemons_fmu import Crowd, Drive
from lemons_fmu import run as run_in_python
from scipy.integrate import solve_ivp

# test_reference_toml.py compares this page with the reader.
((HEADER, CELLS),) = [(header, cells) for heading, header, cells in pages.tables("docs/reference/decision.md") if heading == "pendulum"]
DEFAULTS = {pages.plain(row[0]): pages.plain(row[HEADER.index("if missing")]) for row in CELLS}
NAMES = ("height_part", "support", "damping", "step_time", "step_length")
HEIGHT_PART, SUPPORT, DAMPING, STEP_TIME, STEP_LENGTH = (float(DEFAULTS[name]) for name in NAMES)
#: RATE is FloorDamping: legs give back what the floor takes.
HEIGHT, RATE = HEIGHT_PART * 1.75, 4.5
OMEGA = math.sqrt(9.81 / HEIGHT)
MASS = 80.0
ANKLES = OMEGA * SUPPORT  # m/s
#: The extrapolated centre of mass leaves the edge of the feet by exp(OMEGA t).
ONE_STEP = OMEGA * (SUPPORT + STEP_LENGTH * math.exp(-OMEGA * STEP_TIME))


def hit(directory, speeds, step=0.005, until=3.0, algorithm="gauss-seidel", side=0):
    """Everybody is hit at the start, far from others, from this side [degrees]. Returns ways along x (time, person), and the outputs at
    the end."""
    x, y = math.cos(math.radians(side)), math.sin(math.radians(side))
    people = [{"mass": MASS, "x": 2.0, "y": 9.0 * k, "vx": v * x, "vy": v * y, "rate": RATE} for k, v in enumerate(speeds)]
    trial = write_trial(directory / "trial", people, mechanical=1e-3)
    decision = directory / "decision.toml"
    decision.write_text('balance = "pendulum"\n[pendulum]\nreturn_after = 100.0\n')
    with Crowd(trial, decision=decision, algorithm=algorithm) as crowd:
        ways = []
        for _ in range(round(until / step)):
            crowd.step(step)
            ways.append(crowd.poses()[:, 0] - 2.0)
        ends = {name: [crowd[f"decision.agent[{k}].{name}"] for k in range(len(speeds))] for name in ("Steps", "Balanced", "Fallen", "Lean")}
    return np.array(ways), ends


@pytest.mark.parametrize("side", [0, 90, 180, 270])
def test_thresholds_are_those_of_the_pendulum(tmp_path, side):
    speeds = [0.97 * ANKLES, 1.03 * ANKLES, 0.97 * ONE_STEP, 1.03 * ONE_STEP]
    _, ends = hit(tmp_path, speeds, side=side)
    assert ends["Steps"][0] == 0 and min(ends["Steps"][1:]) >= 1
    assert ends["Fallen"] == [False, False, False, True]
    assert ends["Balanced"][:3] == [True] * 3 and max(ends["Lean"][:3]) < SUPPORT
    # Impulses from 10 to 300 N s: the ankles, one step, a fall.
    impulses = np.array([10, 62, 65, 120, 230, 240, 300])
    _, ends = hit(tmp_path / "impulses", impulses / MASS, side=side)
    assert ends["Steps"][:2] == [0, 0] and all(ends["Steps"][2:])
    assert ends["Fallen"] == [False] * 5 + [True] * 2


def standing(directory, speeds):
    """A Trial of people with legs who are hit at the start, far from each other."""
    people = [{"mass": MASS, "x": 2.0, "y": 9.0 * k, "vx": v, "rate": RATE} for k, v in enumerate(speeds)]
    trial = write_trial(directory / "trial", people, mechanical=1e-3)
    (trial / "decision.toml").write_text('balance = "pendulum"\n[pendulum]\nreturn_after = 100.0\n')
    return trial


def command(lemons, directory, *words):
    done = subprocess.run([lemons, *map(str, words)], cwd=directory, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def test_a_table_has_the_legs_that_decision_says(lemons, tmp_path):
    """Value for value, in all formats, of a run that is continued, and in Python."""
    trial, run = standing(tmp_path, [0.2, 0.9, 3.2]), ("--step", "0.01", "--until")
    command(lemons, tmp_path, "run", trial, *run, 1, "-o", "run.csv", "--outputs", "out.csv")
    command(lemons, tmp_path, "run", trial, *run, 1, "-o", "run.parquet")
    command(lemons, tmp_path, "run", trial, *run, 0.2, "-o", "first.csv", "--state", "saved.run")
    command(lemons, tmp_path, "run", trial, *run, 1, "-o", "rest.csv", "--resume", "saved.run")
    table, out = (pd.read_csv(tmp_path / name, comment="#", dtype={"id": str}) for name in ("run.csv", "out.csv"))
    for k in range(3):
        own = table[table["id"] == str(k)].reset_index()
        for column, name in ("legs_x", "Legs.x"), ("legs_y", "Legs.y"), ("steps", "Steps"), ("balanced", "Balanced"), ("fallen", "Fallen"):
            assert (own[column] == out[f"decision.agent[{k}].{name}"].astype(own[column].dtype)).all(), (k, column)
    assert {"steps", "balanced", "fallen"} <= set(table.select_dtypes("int"))
    assert set(table["balanced"]) == set(table["fallen"]) == {0, 1} and table["steps"].max() >= 1
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "run.parquet"), table, check_dtype=False)
    # The continued run begins where the first one ends.
    parts = pd.concat([pd.read_csv(tmp_path / name, comment="#", dtype={"id": str}) for name in ("first.csv", "rest.csv")])
    assert parts.to_csv(index=False) == table.to_csv(index=False)
    here = run_in_python(trial, until=1.0, step=0.01)
    assert here.frame().astype({"id": str}).to_csv(index=False) == table.to_csv(index=False)
    assert here.legs.shape == (101, 3, 2) and here.steps.max() == table["steps"].max()
    # A Trial that goes on from there stands on its feet, and the command says so.
    assert "the state of legs is not taken along" in command(lemons, tmp_path, "export", "run.csv", "--to", "trial", "next", "--trial", trial).stderr
    (trial / "decision.toml").unlink()
    without = run_in_python(trial, until=0.1, step=0.01)
    assert list(without.frame()) == list(COLUMNS)
    with pytest.raises(ValueError, match="nobody has legs"):
        _ = without.legs


def test_measures_of_balance_are_those_of_a_pendulum(lemons, tmp_path):
    """Who is hit needs a step for as long as it takes, and leans most then, or where it lands."""
    speeds = np.array([0.97 * ANKLES, 1.03 * ANKLES, 1.0, 0.97 * ONE_STEP, 1.03 * ONE_STEP])
    trial, step = standing(tmp_path, speeds), 0.005
    seen = run_in_python(trial, until=3.0, step=step, algorithm="gauss-seidel").measure()
    people, summary = seen.people, seen.summary["balance"]
    assert people["fallen"].tolist() == [0, 0, 0, 0, 1] and people["steps"].tolist()[:4] == [0, 1, 1, 1]
    assert people["time_unbalanced"][:4].tolist() == pytest.approx([0, STEP_TIME, STEP_TIME, STEP_TIME], abs=1.5 * step)
    # Until the step a pendulum about the edge of the feet; then the feet are at the extrapolated centre of mass, or as far as they reach.
    grown, turned = math.cosh(OMEGA * STEP_TIME), math.sinh(OMEGA * STEP_TIME)
    lean = SUPPORT * (1 - grown) + speeds / OMEGA * turned
    landed = np.minimum(lean + speeds / OMEGA * grown - SUPPORT * turned, STEP_LENGTH) - lean
    assert people["lean"][1:4].tolist() == pytest.approx(np.maximum(lean, landed)[1:4].tolist(), rel=0.03)
    assert people["lean"][0] < SUPPORT
    assert (summary["fallen"], summary["steps"]) == (1, people["steps"].sum())
    for name in "time_unbalanced", "lean":
        spread = [people[name].quantile(0.5), people[name].quantile(0.9), people[name].max(), str(people[name].idxmax())]
        assert [summary[name][key] for key in ("median", "quantile_90", "max")] == pytest.approx(spread[:3], rel=1e-12)
        assert summary[name]["max_id"] == spread[3]
    # The same numbers in a sweep, and later: only steps since then.
    measures = {"unbalanced": ("time_unbalanced", "max"), "steps": ("steps", "mean"), "falls": ("falls", "mean"), "lean": ("lean", "median")}
    lines = [f'{name} = {{ balance = "{what}", across = "{across}" }}' for name, (what, across) in measures.items()]
    (tmp_path / "sweep.toml").write_text(
        f'trial = "trial"\nuntil = 3.0\nstep = {step}\nalgorithm = "gauss-seidel"\n[parameters]\nTimeStepMechanical = [1e-3]\n[measures]\n' + "\n".join(lines)
    )
    command(lemons, tmp_path, "sweep", "sweep.toml", "-o", "table.csv")
    (row,) = pd.read_csv(tmp_path / "table.csv", comment="#").to_dict("records")
    assert row["falls"] == 0.2 and row["steps"] == people["steps"].mean()
    assert row["unbalanced"] == people["time_unbalanced"].max() and row["lean"] == people["lean"].median()
    late = run_in_python(trial, until=3.0, step=step, algorithm="gauss-seidel").measure(**{"from": 2.0})
    assert late.people["steps"][:4].tolist() == [0] * 4 and late.people["fallen"][4] == 1


def test_balance_is_measured_without_a_squeeze(lemons, tmp_path):
    """Of a table that has legs, but no forces."""
    trial = standing(tmp_path, [0.2, 0.8, 2.0])
    command(lemons, tmp_path, "run", trial, "--until", 1, "--step", 0.01, "-o", "run.csv")
    run = pd.read_csv(tmp_path / "run.csv", comment="#")
    run.drop(columns=run.filter(like="normal_force")).to_csv(tmp_path / "places.csv", index=False)
    said = [command(lemons, tmp_path, "measure", f"{name}.csv", "-o", name).stderr for name in ("run", "places")]
    known, people = (pd.read_csv(tmp_path / name / "people.csv") for name in ("run", "places"))
    balance = ["id", "time_unbalanced", "steps", "fallen", "lean"]
    assert not said[0] and "squeeze is left out" in said[1] and list(people) == list(known)
    assert people[balance].equals(known[balance]) and people["steps"].max() > 0
    assert people.drop(columns=balance).isna().all(axis=None) and not known["impulse"].isna().any()


def test_until_the_step_the_way_is_that_of_a_pendulum_about_the_edge_of_the_feet(tmp_path):
    """SciPy integrates the pendulum, whose ankles bring the body above the feet as far as they can."""

    def motion(_, state):
        x, v = state
        middle = OMEGA**2 * x
        return [v, middle + np.clip(-DAMPING * v - (DAMPING / 2) ** 2 * x - middle, -(OMEGA**2) * SUPPORT, OMEGA**2 * SUPPORT)]

    speeds = [0.3 * ANKLES, ANKLES, 0.8, 1.5]
    until = STEP_TIME - 0.01
    ways, _ = hit(tmp_path, speeds, step=0.002, until=until)
    for way, speed in zip(ways[-1], speeds):
        x = solve_ivp(motion, (0, until), [0.0, speed], rtol=1e-9, atol=1e-12, max_step=1e-3).y[0, -1]
        assert way == pytest.approx(x, rel=0.01), speed


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
def test_ways_hardly_depend_on_the_communication_step(tmp_path, algorithm):
    """Also where a drive is a step late."""
    speeds = [0.2, 0.8, 1.2]
    fine, _ = hit(tmp_path / "fine", speeds, step=0.002)
    coarse, _ = hit(tmp_path / "coarse", speeds, step=0.02, algorithm=algorithm)
    assert np.abs(fine[-1] - coarse[-1]).max() < 0.022, (fine[-1], coarse[-1])


@pytest.mark.parametrize("limit", ["push = 100", "[agents]\n0 = { push = 100 }\n1 = { push = 100 }\n2 = { push = 100 }", "motivation = [{ time = 0.5, push = 100 }]"])
def test_a_row_presses_on_a_wall_with_the_sum_of_its_pushes(tmp_path, limit):
    people = [{"mass": MASS, "x": 2.0 + 0.41 * k, "y": 2.0, "rate": RATE} for k in range(3)]
    wall = [(3.1, 0.0), (3.1, 4.0)]
    trial = write_trial(tmp_path / "trial", people, walls=[wall], mechanical=1e-4, damping=500.0)
    decision = tmp_path / "decision.toml"
    decision.write_text(f"waypoints = [{{ x = 30, y = 2 }}]\n{limit}\n")
    with Crowd(trial, decision=decision) as crowd:
        for _ in range(400):
            crowd.step(0.02)
        # Of each person: what those behind press, and what presses back ahead.
        assert crowd.squeeze() == pytest.approx([100, 300, 500], rel=1e-3)


def test_who_walks_has_the_feet_under_the_body(tmp_path):
    trial = write_trial(tmp_path / "trial", [{"mass": MASS, "x": 2.0, "y": 2.0, "rate": RATE}], mechanical=1e-3)
    decision = tmp_path / "decision.toml"
    decision.write_text('balance = "pendulum"\nwaypoints = [{ x = 30, y = 2 }]\n')
    with Crowd(trial, decision=decision) as crowd:
        run = crowd.run(until=3.0, step=0.05)
    assert run.velocities[-1, 0, 0] > 1 and np.array_equal(run.legs, run.poses[:, :, :2])


@pytest.fixture
def examples(monkeypatch, lemons):
    monkeypatch.syspath_prepend(REPOSITORY / "examples")
    monkeypatch.setenv("LEMONS", str(lemons))


@pytest.mark.parametrize(("alike", "order"), [(True, 9.0), (False, 1.0)])
def test_waves_are_measured_as_they_are_made(examples, alike, order):
    """Circles of 4 s, of all alike, or each with a phase of its own."""
    import waves

    times = np.arange(0, 100, 0.02)
    places = 0.3 + 0.6 * np.stack(np.meshgrid(np.arange(9), np.arange(9)), axis=-1).reshape(-1, 2)
    phase = np.zeros(81) if alike else np.random.default_rng(1).uniform(0, 2 * np.pi, 81)
    turn = np.exp(1j * (2 * np.pi * times[:, None] / 4 + phase))
    run = SimpleNamespace(
        times=times, velocities=np.stack([turn.real, turn.imag], axis=-1), poses=np.broadcast_to(places, (len(times), 81, 2))
    )
    (found, least, period, chirality, correlation), _, _ = waves.measures(run, 5.4)
    # Of 81 random phases, the order of nine cells is 1 within two standard errors.
    assert found == pytest.approx(order, abs=1e-9 if alike else 0.7)
    assert (least, period, chirality) == (pytest.approx(-1, abs=0.01), pytest.approx(4, abs=0.05), pytest.approx(1, abs=0.05))
    assert correlation == pytest.approx((found - 1) / 8)


def test_a_small_square_is_agitated_and_measured(examples, tmp_path):
    import waves

    arguments = argparse.Namespace(number=30, until=30.0, seed=1, material=None)
    run, side = waves.simulate("two-level", 4.0, arguments, tmp_path)
    numbers, lags, all = waves.measures(run, side)
    assert 0.3 < numbers[0] < 8 and all[0] == 1 and len(lags) == len(all) and run.has_legs
    waves.plot(tmp_path / "waves.png", [("two-level", 4.0, numbers, lags, all)])
    assert (tmp_path / "waves.png").stat().st_size > 1000


@pytest.mark.parametrize(("algorithm", "step", "way"), [("gauss-seidel", 0.002, 0.065), ("gauss-seidel", 0.02, 0.065), ("jacobi", 0.01, 0.065)])
def test_a_row_hardly_depends_on_the_communication_step(examples, monkeypatch, tmp_path, algorithm, step, way):
    """As docs/balance.md says."""
    import rows

    monkeypatch.setattr(rows, "STEP", step)
    run = rows.push(rows.row(tmp_path, "pendulum", 5) | {"algorithm": algorithm}, 5, 0.02, 120.0)[0]
    assert run.poses[:, 0, 0].max() - run.poses[0, 0, 0] == pytest.approx(way, abs=0.0015)


@pytest.mark.parametrize("model", ["none", "pendulum", "two-level"])
def test_forces_in_a_row_follow_from_its_motions(examples, tmp_path, model):
    """The force on the first one from behind is the push, alone and in a row."""
    import rows

    for count in (1, 4):
        run, _, drives, damping, _ = rows.push(rows.row(tmp_path, model, count), count, 0.05, 100.0)
        behind = rows.forces(run, drives, damping)
        middle = (run.times[1:] + run.times[:-1]) / 2
        push = 100 * np.pi / (2 * rows.PUSH) * np.sin(np.pi * np.clip(middle / rows.PUSH, 0, 1))
        assert np.abs(behind[:, 0] - push).max() < 1.0, count
    passed = behind[:, 1].sum() * rows.STEP / 100
    assert passed > 0.5 and rows.measures(model, 4, 0.05, 100.0, tmp_path)[2] == pytest.approx(passed)


@pytest.mark.parametrize("bracing", [0.0, 0.8])
def test_a_lasting_push_is_held_up_to_the_limit_of_ankles(tmp_path, bracing):
    """A push that grows slowly: the ground's force is at the edge of the feet at m w0^2 s/(1 + 4 (1 - bracing) (w0/rate)^2)."""
    most = MASS * OMEGA**2 * SUPPORT / (1 + 4 * (1 - bracing) * (OMEGA / DAMPING) ** 2)
    parts, times = np.array([0.97, 1.03]), np.array([0.0, 80.0, 100.0])
    trial = standing(tmp_path, [0.0, 0.0])
    decision = tmp_path / "decision.toml"
    decision.write_text(f'balance = "pendulum"\n[pendulum]\nbracing = {bracing}\nreturn_after = 1000.0\n')
    push = {k: (times, np.outer([0, 1, 1], [part * most, 0, 0])) for k, part in enumerate(parts)}
    with Crowd(trial, decision=decision, algorithm="gauss-seidel") as crowd:
        run = crowd.run(Drive(push), until=100.0, step=0.01)
        steps = [crowd[f"decision.agent[{k}].Steps"] for k in range(2)]
        lean = crowd["decision.agent[0].Lean"]
    assert steps[0] == 0 and steps[1] > 0
    assert lean == pytest.approx(4 * (1 - bracing) * parts[0] * most / MASS / DAMPING**2, rel=0.03)
    assert np.abs(run.velocities[-1, 0, 0]) < 1e-3


def test_two_people_who_are_pushed_together_let_go(tmp_path):
    """Who braces does not press on for ever."""
    people = [{"mass": MASS, "x": 2.0 + 0.41 * k, "y": 2.0, "rate": RATE} for k in range(2)]
    trial = write_trial(tmp_path / "trial", people, mechanical=1e-4)
    decision = tmp_path / "decision.toml"
    decision.write_text('balance = "pendulum"\n')
    times = np.array([0.0, 3.0, 3.01, 20.0])
    push = {k: (times, np.outer([60, 60, 0, 0], [1 - 2 * k, 0, 0])) for k in range(2)}
    with Crowd(trial, decision=decision, algorithm="gauss-seidel") as crowd:
        crowd.run(Drive(push), until=3.0, step=0.01)
        pressed = crowd.squeeze()
        crowd.run(Drive(push), until=20.0, step=0.01)
        assert pressed.min() > 20 and crowd.squeeze().max() < 1, (pressed, crowd.squeeze())
