"""Queues that push: what the gate gets is what people give, by closed forms."""

import json
import os
import re
import subprocess
import sys

import pytest
from crowd import REPOSITORY

#: A row of round people who look along x, and a wall before them: the room's right side.
ROW = """\
box = [{length}, 0.62]
number = {people}
packing = "grid"
orientation = "fixed"
direction = 0.0
round = true
friction = 0.0
time_step = 0.01
panel_length = 0.25

[decision]
model = "straight"
desired_speed = 0.02
waypoints = [{{ x = 50.0, y = 0.31 }}]
queue = {{ push = {push} }}
"""


@pytest.mark.parametrize(("people", "push"), [(1, 120), (5, 80), (12, 80), (12, 0)])
def test_a_row_presses_with_the_sum_of_its_pushes(lemons, tmp_path, people, push):
    """Everybody in a straight row leans on the next one, and the first on the wall: n F. Without leaning, by eq. 4, each with m v0/t_transl."""
    (tmp_path / "row.toml").write_text(ROW.format(people=people, push=push, length=0.62 * people + 0.4))
    subprocess.run([lemons, "crowd", "--scenario", tmp_path / "row.toml", "-o", tmp_path / "row"], check=True, capture_output=True)
    places = [float(line.split('"')[1].split(",")[1]) for line in (tmp_path / "row" / "dynamic" / "AgentDynamics.xml").read_text().splitlines() if "Position" in line]
    assert places and max(abs(y - 0.31) for y in places) < 1e-12
    measured = [lemons, "measure", tmp_path / "row", "--until", 60, "--from", 45, "--walls", "--summary", "-"]
    summary = json.loads(subprocess.run(list(map(str, measured)), check=True, capture_output=True, text=True).stdout)
    force = sum(panel["load_10"] * panel["length"] for panel in summary["panels"] if panel["x1"] == panel["x2"] == pytest.approx(0.62 * people + 0.4))
    trial = (tmp_path / "row" / "static" / "Agents.xml").read_text()
    own = [float(part.split('"')[1]) * 0.02 for part in trial.split(" Mass=")[1:]]
    damping = float(trial.split("FloorDamping=")[1].split('"')[1])
    expected = people * push if push else sum(own) * damping
    assert force == pytest.approx(expected, rel=2e-3)


@pytest.mark.long
def test_a_gate_gets_more_the_harder_a_queue_pushes(lemons, tmp_path):
    """The study of docs/walking.md with fewer people: loads rise up to what feet hold, without a push they are those of today."""
    command = [sys.executable, REPOSITORY / "examples/shut_gate.py", tmp_path / "gate", "--seeds", "2", "--people", "40"]
    done = subprocess.run(command, env={**os.environ, "LEMONS": str(lemons)}, check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=900)
    loads = [float(row) for row in re.findall(r"^ +\d+ N +([\d.]+) ±", done.stdout, re.MULTILINE)]
    assert len(loads) == 6 and loads[0] < loads[1] < loads[2] < loads[3] and loads[0] < 0.3 * loads[3]
    near = [[float(number) for number in row] for row in re.findall(r"^ +\d+ N +(\d+) +(\d+) ", done.stdout, re.MULTILINE)]
    assert len(near) == 6 and all(first > second for first, second in near)
