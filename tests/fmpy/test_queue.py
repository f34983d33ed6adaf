"""Queues that push: what the gate gets is what people give, by closed forms."""

import json
import subprocess

import pytest

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
