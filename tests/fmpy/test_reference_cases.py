"""The reference cases (reference/): each is complete, its solution is right, our FMU agrees, and an FMU with another law does not."""

import math
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from crowd import REPOSITORY

REFERENCE = REPOSITORY / "reference"
sys.path[:0] = [str(REFERENCE), str(REFERENCE / "adapters")]

import choices  # noqa: E402
import growth  # noqa: E402
import law  # noqa: E402
import run  # noqa: E402
import solve  # noqa: E402
import speed  # noqa: E402

CASES = {directory.name: directory for directory in solve.directories()}
SCENARIOS = sorted(path.name for path in (REPOSITORY / "tests/scenarios").iterdir())
OTHERS = [name for name in run.ENGINES if name != "lemons"]


@pytest.fixture
def ours(lemons, monkeypatch):
    """Measures our FMU on a case, with steps divided by `refined`."""
    monkeypatch.setenv("LEMONS", str(lemons))
    import lemons as adapter

    return lambda directory, *refined: run.measure(adapter, directory, refined or (1,))


def test_every_case_is_complete():
    assert len(CASES) >= 26
    names = [name[3:] for name in CASES]
    assert [name[:2] for name in CASES] == [f"{k + 1:02}" for k in range(len(CASES))]
    assert set(SCENARIOS) <= set(names)  # those of the paper
    for name, directory in CASES.items():
        case, page = law.description(directory), (directory / "README.md").read_text()
        assert case["kind"] in ("closed form", "converged", "measured"), name
        assert case["solution"] and set(case["rigid"]) <= set(case["solution"]), name
        assert {law.UNITS[quantity.rsplit(".", 1)[1]] for quantity in case["solution"]} == set(case["scale"]), name
        assert all(math.isfinite(value) for value in case["solution"].values()) and 0 < case["tolerance"] <= (0.2 if case["kind"] == "measured" else 0.01), name
        for heading in ("## Scene", "## Solution", "## Compared", "## Source"):
            assert heading in page, (name, heading)
        assert page.startswith(f"# {name[:2]}. {case['title']}\n"), name
        law.Scene(directory)


def test_the_cases_do_not_name_our_program():
    files = [path for directory in CASES.values() for path in directory.rglob("*") if path.suffix in (".md", ".py", ".toml", ".xml")]
    files += [REFERENCE / name for name in ("law.py", "forms.py", "solve.py")]
    for path in files:
        # LEMONS is the paper's name for the model.
        assert not re.search("lemons[-_ ]?fmu|lemons [a-z]|crowd-mechanics|crowd_mechanics", path.read_text()), path


@pytest.mark.parametrize("name", [name for name, directory in CASES.items() if law.description(directory)["kind"] == "closed form"])
def test_closed_forms_are_what_is_stored(name):
    directory = CASES[name]
    case = law.description(directory)
    assert law.distance(case, solve.module(directory).solution(), case["solution"]) < 1e-9


@pytest.mark.parametrize("name", ["03_slip_agent_agent", "18_two_bodies"])
def test_solutions_of_free_pairs_keep_both_momenta(name):
    """Linear and angular momentum: whatever the forces are, if they are opposite and act at one point."""
    scene, solution = law.Scene(CASES[name]), law.description(CASES[name])["solution"]
    end = np.array([[solution[f"{body}.{component}"] for component in law.COMPONENTS] for body in scene.ids])

    def momenta(state):
        x, y, _, vx, vy, omega = state.T
        return np.array([scene.mass @ vx, scene.mass @ vy, scene.mass @ (x * vy - y * vx) + scene.inertia @ omega])

    assert np.abs(end[:, 5]).min() > 0.1
    assert momenta(end) == pytest.approx(momenta(scene.start), rel=1e-8, abs=1e-7)


def test_the_measured_push_is_derived_from_its_record(shared):
    """To the last digit that is stored."""
    directory = CASES["26_measured_push"]
    script, case, scene = solve.module(directory), law.description(directory), law.Scene(directory)
    force, lasts, ways, at_rest = script.derived(shared / "data/push_wed")
    assert scene.fp[0] == pytest.approx(force, abs=5) and case["drive"][0]["from"] == pytest.approx(lasts, abs=5e-4)
    assert scene.mass[0] == script.MASS and tuple(scene.start[:, 0]) == script.START
    assert script.WAY == pytest.approx(ways, abs=5e-4) and max(at_rest) < 0.01
    assert script.solution() == case["solution"]


def test_a_drive_over_time_is_solved_as_our_fmu_does(ours):
    """The measured push: the ways that its page says, by law.py; ours is as far from the measured ones."""
    directory = CASES["26_measured_push"]
    case, script = law.description(directory), solve.module(directory)
    solved = law.solved(directory, list(case["solution"]), longest=5e-3, tolerance=1e-4)
    ways = [solved[f"{k}.x"] - start for k, start in enumerate(script.START)]
    said = re.search(r"law.py has the ways ([\d., and\n]+) m:", (directory / "README.md").read_text())[1]
    assert ways == pytest.approx([float(way) for way in re.findall(r"\d+\.\d+", said)], abs=1e-3)
    assert ours(directory)["error"] == pytest.approx(law.distance(case, solved, case["solution"]), abs=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_solutions_are_solved_twice(name):
    directory = CASES[name]
    case = law.description(directory)
    solution, closed, bar, order = solve.examined(directory, quick=True)
    assert law.distance(case, solution, case["solution"]) < 1e-8
    if not case["check_step"]:  # a law of conservation, not of contacts; or measured
        return
    # Two ways agree far better than the tolerance: closed form and integrator, or two integrators (and a part's closed form with them).
    assert bar < 1e-4 * case["tolerance"]
    assert closed < 1e-4 * case["tolerance"] or (math.isnan(closed) and case["kind"] == "converged")
    assert order > 2 or bar < 1e-8


@pytest.mark.long
def test_speed_is_said_of_the_longest_step_that_is_right(ours):
    command = [sys.executable, REFERENCE / "speed.py", "--people", "30", "--rounds", "1", "--engine", "none"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, timeout=600).stdout
    for material, step in (("human_soft", 1e-3), ("human_naked", 5e-6)):
        found, error = re.search(rf"{material}, (\S+) s: error of nine of ten \S+ mm, greatest (\S+) mm", said).groups()
        assert float(found) >= step and float(error) <= 1.0, said
        assert float(re.search(rf"{material}, {found} s +(\S+)", said)[1]) > 0


def test_a_crowd_on_two_threads_says_how_fast_it_is(ours, tmp_path, capsys):
    speed.real_time(speed.crowd(tmp_path, "human_soft", 30), 2, 1, [])
    said = capsys.readouterr().out
    assert said.startswith("30 people, 1 rounds: times real time")
    rows = re.findall(r"human_soft, [0-9.]+ s, (\d) threads +(\S+) +(\S+) +\S+$", said, re.MULTILINE)
    assert [threads for threads, *_ in rows] == ["1", "2"] and all(0 < float(pace) <= float(best) for _, pace, best in rows)


@pytest.mark.skipif(sys.platform != "linux", reason="it reads /proc")
def test_growth_repeats_a_crowd_without_overlaps(ours, tmp_path, monkeypatch):
    monkeypatch.setattr(growth, "TILE", 10)
    growth.tiled(speed.crowd(tmp_path, "human_soft", 10), tmp_path / "many", 6)
    scene = law.Scene(tmp_path / "many", 0.1)
    assert scene.ids == [str(k) for k in range(60)] and len(scene.owner) == 300
    assert scene.geometry(scene.start)[0].max() <= 0
    assert len(set(scene.fp)) == 10 and len({round(float(x), 9) for x in scene.start[:, 0]}) == 20  # two columns of three
    cost = growth.measure(tmp_path / "many", 60, 2, 1)
    assert all(number > 0 for number in cost), cost


def test_other_arms_are_another_law(monkeypatch):
    """The law of choices.py is that of the cases, and LAMMPS's arm at a wall is seen."""
    monkeypatch.setattr(choices, "STEP", 2e-5)
    directory = CASES["11_spinning_impact"]
    case = law.description(directory)
    for arms, least, most in ((False, 0, 6e-3), (True, 0.01, 0.02)):
        state = choices.simulated(directory, case["end"], False, arms)
        found = {name: state[name.rsplit(".", 1)[0]][name.rsplit(".", 1)[1]] for name in case["solution"]}
        assert least < law.distance(case, found, case["solution"]) < most


@pytest.mark.parametrize("name", CASES)
def test_our_fmu_agrees(ours, name):
    found = ours(CASES[name])
    assert "why" not in found and not found["part"], found
    assert found["agrees"], found


@pytest.mark.parametrize("name", ["01_push_agent_agent", "03_slip_agent_agent", "07_rolling_agent_agent", "10_oblique_impact", "18_two_bodies"])
def test_our_fmu_comes_nearer_with_shorter_steps(ours, name):
    assert ours(CASES[name], 1, 2, 4)["order"] > 1.5


#: Of each case an attribute that its solution depends on.
MUTATIONS = {
    "01": "GammaNormal",
    "02": "YoungModulus",
    "03": "KineticFriction",
    "04": "KineticFriction",
    "05": "FloorDamping",
    "06": "AngularDamping",
    "07": "GammaTangential",
    "08": "ShearModulus",
    "09": "GammaNormal",
    "10": "KineticFriction",
    "11": "GammaTangential",
    "12": "KineticFriction",
    "13": "KineticFriction",
    "14": "GammaNormal",
    "16": "GammaNormal",
    "17": "KineticFriction",
    "18": "ShearModulus",
    "19": "FloorDamping",
    "20": "YoungModulus",
    "21": "KineticFriction",
    "22": "AngularDamping",
    "23": "YoungModulus",
    "24": "FloorDampingAcross",
    "25": "LoadLength",
    "26": "FloorDamping",
}


@pytest.mark.parametrize("name", CASES)
def test_another_law_is_caught(ours, tmp_path, name):
    """By 10 % another coefficient; in the case of conservation a damper of 20 kg/s; in the measured one twice the rate of the floor."""
    changed = tmp_path / name
    shutil.copytree(CASES[name], changed)
    attribute, count = MUTATIONS.get(name[:2], "GammaNormal"), 0
    factor = 2 if law.description(changed)["kind"] == "measured" else 1.1
    for path in changed.rglob("*.xml"):
        text, found = re.subn(rf'\b{attribute}="([^"]+)"', lambda m: f'{attribute}="{factor * float(m[1]) or 20}"', path.read_text())
        path.write_text(text)
        count += found
    found = ours(changed)
    assert count and "why" not in found and not found["agrees"], (attribute, found)


def test_the_runner_prints_a_table(ours, capsys, monkeypatch, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("".join(f"<!-- {name} -->\nold\n<!-- end of {name} -->\n" for name in ("error", "order", "cost", "parts")))
    monkeypatch.setattr(sys, "argv", ["run.py", "--engine", "lemons", "--engine", "no_such_engine", "--case", "02", "--write", str(page)])
    ours(CASES["02_push_agent_wall"])
    run.main()
    said = capsys.readouterr()
    assert "without no_such_engine" in said.err
    assert re.search(r"(?m)^02_push_agent_wall +\S+e-0\d$", said.out)
    assert "old" not in page.read_text() and "| 02_push_agent_wall |" in page.read_text()
    assert all(len(line) <= 100 for line in said.out.splitlines())


@pytest.mark.parametrize("engine", OTHERS)
def test_other_engines_do_the_simplest_case(engine):
    """Those that are installed are as near as the page says: a disk at a wall; JuPedSim: a body that comes to rest."""
    module = run.installed([engine]).get(engine)
    if module is None:
        pytest.skip(f"{engine} is not installed")
    case = "05_translation" if engine == "jupedsim_social" else "02_push_agent_wall"
    found = run.measure(module, CASES[case], (1,))
    assert "why" not in found and found["error"] < 2 * on_the_page(case, module.LABEL), found


def on_the_page(case, label):
    """An error of the table in docs/reference-cases.md."""
    table = (REPOSITORY / "docs/reference-cases.md").read_text().split("<!-- error -->\n")[1].split("\n<!-- end")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return float(next(row for row in rows if row[0] == case)[rows[0].index(label)].rstrip("!"))


def test_the_table_says_what_is_wrong():
    """An engine that stands still is not within the tolerance, and one that knows nothing is not compared."""

    class Still:
        cost = 1.0

        def load(self, trial, refine=1):
            self.scene = law.Scene(trial)

        def step(self, t):
            pass

        def state(self):
            return {name: dict(zip(law.COMPONENTS, map(float, row))) | self.more for name, row in zip(self.scene.ids, self.scene.start)}

        def close(self):
            pass

        more = {}

    class Module:
        Engine = Still

    for directory in CASES.values():
        found = run.measure(Module, directory)
        assert not found.get("agrees"), found
    Still.more = {"vx": math.nan}
    assert run.measure(Module, CASES["02_push_agent_wall"])["error"] == math.inf
