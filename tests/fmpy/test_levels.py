"""People in levels, and what presses on a chest: crowds and FMUs beside closed forms."""

import csv
import json
import os
import re
import subprocess
import sys

import pytest
from crowd import REPOSITORY

#: Heights of the slabs of `levels = 3` [m].
SLABS = [(0.5, 0.9), (0.9, 1.3), (1.3, 1.7)]


@pytest.fixture
def run(lemons):
    """Runs the command; returns what it prints, or, where it must fail, what it says."""

    def call(*words, code=0):
        done = subprocess.run([lemons, *map(str, words)], text=True, capture_output=True)
        assert done.returncode == code, done.stderr
        return done.stderr if code else done.stdout

    return call


def made(run, directory, *words):
    """A Trial of two adults."""
    run("crowd", "--number", 2, "--box", "3x3", "--seed", 4, "-o", directory, *words)
    return (directory / "static/Agents.xml").read_text()


def numbers(text, name):
    return [float(value) for value in re.findall(rf'\b{name}="([^"]+)"', text)]


def squeezed(run, directory, *words):
    """A person between two walls 1 mm inside of its depth, where the disks of the plan end; the table of a second."""
    agents = made(run, directory, *words)
    first = re.search(r"(?s)<Agents>\s*(<Agent .*?</Agent>)", agents)[1]
    (directory / "static/Agents.xml").write_text(f"<Agents>{first}</Agents>")
    dynamics = (directory / "dynamic/AgentDynamics.xml").read_text()
    one = re.search(r'(?s)<Agents>\s*(<Agent Id="0">.*?</Agent>)', dynamics)[1]
    one = re.sub(r'Position="[^"]*"', 'Position="0,0"', re.sub(r'Theta="[^"]*"', 'Theta="0"', one))
    (directory / "dynamic/AgentDynamics.xml").write_text(f"<Agents>{one}</Agents>")
    places = [tuple(map(float, place.split(","))) for place in re.findall(r'Position="([^"]+)"', first)]
    rims = [(x - radius, x + radius) for (x, _), radius in zip(places, numbers(first, "Radius"))]
    low, high = min(rim[0] for rim in rims) + 5e-4, max(rim[1] for rim in rims) - 5e-4
    wall = '<Wall Id="{}" MaterialId="concrete"><Corner Coordinates="{x},-1"/><Corner Coordinates="{x},1"/></Wall>'
    walls = wall.format(0, x=low) + wall.format(1, x=high)
    (directory / "static/Geometry.xml").write_text(f"<Geometry>{walls}</Geometry>")
    run("run", directory, "--until", 1, "--every", 100, "-o", directory / "run.csv")
    with open(directory / "run.csv", newline="") as table:
        return list(csv.DictReader(table))


def test_without_levels_nothing_is_written(run, tmp_path):
    plan = made(run, tmp_path / "plan")
    assert not any(name in plan for name in ("Bottom", "Top", "ChestHeight"))
    assert "LoadLength" not in (tmp_path / "plan/static/Materials.xml").read_text()
    one = made(run, tmp_path / "one", "--levels", 1)
    assert re.sub(r' ChestHeight="[^"]*"', "", one) == plan and one != plan


def test_slabs_are_those_that_were_asked_for(run, tmp_path):
    agents = made(run, tmp_path / "three", "--levels", 3)
    statures = numbers(agents, "Height")
    tops = {min(top, stature) for _, top in SLABS for stature in statures}
    assert set(numbers(agents, "Bottom")) == {bottom for bottom, _ in SLABS}
    assert all(any(abs(top - wanted) < 1e-3 for wanted in tops) for top in numbers(agents, "Top"))
    assert numbers((tmp_path / "three/static/Materials.xml").read_text(), "LoadLength") == [pytest.approx(1.2)]
    # The height of the nipples is 0.69 to 0.76 of the stature in ANSUR II.
    assert all(0.68 < chest / stature < 0.77 for chest, stature in zip(numbers(agents, "ChestHeight"), statures))


@pytest.mark.parametrize("levels", ["1", "3"])
def test_who_is_pressed_by_two_walls_has_their_force(run, tmp_path, levels):
    """The sum of both is the squeeze; in the plan the chest has all of it, and is pressed by one of them."""
    rows = squeezed(run, tmp_path / "trial", "--levels", levels)
    last = {name: float(value) for name, value in rows[-1].items()}
    assert last["mean_normal_force"] == pytest.approx(last["mean_wall_force"]) and last["mean_wall_force"] > 100
    assert last["chest_force"] == pytest.approx(last["chest_wall_force"])
    if levels == "1":
        assert last["chest_force"] == pytest.approx(last["mean_wall_force"])
        # The contacts are within 1 mm of the ends of the body.
        assert last["chest_front"] == pytest.approx(0.5 * last["mean_wall_force"], rel=0.01)
    else:
        assert 0 <= last["chest_force"] <= (1 + 1e-9) * last["mean_wall_force"]
    assert abs(last["chest_side"]) < 1e-6 * last["chest_force"]


def test_both_versions_of_fmi_give_the_numbers_of_the_run(run, tmp_path):
    trial = tmp_path / "trial"
    rows = squeezed(run, trial, "--levels", 3)
    for version in (2, 3):
        fmu = tmp_path / f"{version}.fmu"
        run("pack", trial, "--fmi", version, "-o", fmu)
        run("run", fmu, "--until", 1, "--every", 100, "-o", tmp_path / f"{version}.csv")
        with open(tmp_path / f"{version}.csv", newline="") as table:
            again = list(csv.DictReader(table))
        names = [name for name in rows[0] if name.startswith("chest_")]
        assert len(names) == 5
        assert [[row[name] for name in names] for row in again] == [[row[name] for name in names] for row in rows]
        said = run("info", fmu)
        assert re.search(r"\bagent\[0\]\.Compression\.front +output +N\b" if version == 2 else r"\bCompression\.front\b", said)


def test_breathing_needs_chests_and_has_its_dose(run, tmp_path):
    """A constant load F > 392 N on the trunk: after t seconds, without the first breath of 5 s, (t − 5)/120 of the dose."""
    trial = tmp_path / "trial"
    squeezed(run, trial, "--levels", 1)
    run("measure", trial, "--until", 11, "--step", 0.5, "--breathing", "-o", tmp_path / "out", "--summary", tmp_path / "summary.json")
    summary = json.loads((tmp_path / "summary.json").read_text())["breathing"]
    with open(tmp_path / "out/breathing.csv", newline="") as table:
        (row,) = list(csv.DictReader(table))
    assert float(row["front"]) > 392.3 and row["critical_at"] == "" and summary["critical"] == 0
    # The first mean over a breath is known when it is over, and counts for its step.
    assert float(row["dose"]) == pytest.approx(6.5 / 120, rel=1e-6)
    assert summary["dose"]["max"] == float(row["dose"])
    plain = tmp_path / "plain"
    made(run, plain)
    said = run("measure", plain, "--until", 1, "--breathing", code=1)
    assert "ChestHeight" in said


def test_a_sweep_has_the_numbers_of_the_measurement(run, tmp_path):
    trial = tmp_path / "trial"
    squeezed(run, trial, "--levels", 1)
    run("measure", trial, "--until", 6, "--breathing", "-o", tmp_path / "out")
    with open(tmp_path / "out/breathing.csv", newline="") as table:
        (row,) = list(csv.DictReader(table))
    measures = "".join(f'{name} = {{ breathing = "{name}", across = "max" }}\n' for name in ("front", "dose", "critical_part", "above_623"))
    (tmp_path / "sweep.toml").write_text(f'trial = "trial"\nuntil = 6.0\n[parameters]\nMostMechanicalSteps = [1e9]\n[measures]\n{measures}')
    run("sweep", tmp_path / "sweep.toml", "-o", tmp_path / "sweep.csv")
    lines = [line for line in (tmp_path / "sweep.csv").read_text().splitlines() if not line.startswith("#")]
    (point,) = list(csv.DictReader(lines))
    assert float(row["dose"]) > 0 and all(float(point[name]) == float(row[name]) for name in ("front", "dose", "critical_part", "above_623"))


@pytest.mark.long
def test_the_example_prints_its_tables(lemons, tmp_path):
    command = [sys.executable, REPOSITORY / "examples/levels.py", tmp_path, "covered", "row", "--seeds", "2", "--levels", "1", "2"]
    done = subprocess.run(command, env={**os.environ, "LEMONS": str(lemons)}, text=True, capture_output=True, timeout=900)
    assert done.returncode == 0, done.stderr
    assert "of the ground" in done.stdout and done.stdout.count("2 levels") == 3 and "failed" not in done.stdout
