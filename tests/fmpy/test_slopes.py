"""Slopes, stairs and links: speeds by their sources, loads by closed forms, and floors that are one."""

import csv
import json
import math
import shutil
import subprocess

import pytest

#: m/s; and Fruin's factors uphill at 10 degrees, and of stairs of 0.17 m by 0.29 m, up and down.
SPEED = 1.34
UP_10 = 0.885 + (0.75 - 0.885) * (math.tan(math.radians(10)) - 0.1) / 0.1
STEP = math.atan2(0.17, 0.29)


def stairs(steep, flat):
    """The horizontal speed between Fruin's two stairs, of 7 by 11.25 and 6 by 12 inches."""
    return flat + (steep - flat) * (STEP - 0.4636) / (0.5567 - 0.4636)


SQUARE = "corners = [[-50, -5], [50, -5], [50, 5], [-50, 5]]"
ALONE = """\
number = 1
regions = [{{ corners = [[0.4, 0.4], [1.6, 0.4], [1.6, 1.6], [0.4, 1.6]] }}]
box = [40.0, 2.0]
time_step = 0.02
grounds = [{ground}]
[decision]
model = "{model}"
desired_speed = 1.34
waypoints = [{{ x = 35.0, y = 1.0 }}]
"""


def run(lemons, directory, scenario, *options):
    (directory / "scenario.toml").write_text(scenario, encoding="utf-8")
    for words in (["crowd", "--scenario", "scenario.toml", "-o", "T"], ["run", "T", "-o", "run.csv", *options]):
        done = subprocess.run([str(lemons), *map(str, words)], cwd=directory, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    with (directory / "run.csv").open() as table:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(table)]


@pytest.mark.parametrize("model", ["straight", "rotational"])
@pytest.mark.parametrize(
    ("ground", "speed"),
    [
        ("downhill = 180, angle = 10", SPEED * UP_10),
        ("downhill = 0, angle = 10, held = 0.2", SPEED),
        ("downhill = 90, angle = 10", SPEED),
        ("downhill = 180, angle = 2.5", SPEED),
        ("downhill = 180, riser = 0.17, tread = 0.29", stairs(0.51, 0.57)),
        ("downhill = 0, riser = 0.17, tread = 0.29", stairs(0.67, 0.77)),
        ("downhill = 180, riser = 0.17, tread = 0.29, speed_up = 0.4", 0.4 * SPEED),
    ],
)
def test_who_walks_alone_has_the_speed_of_the_source(lemons, tmp_path, model, ground, speed):
    """Held or not by the ground, a walker's feet hold what pulls."""
    rows = run(lemons, tmp_path, ALONE.format(model=model, ground=f"{{ {SQUARE}, {ground} }}"), "--until", 16)
    rows = [row for row in rows if row["t"] >= 6]
    seen = (rows[-1]["x"] - rows[0]["x"]) / (rows[-1]["t"] - rows[0]["t"])
    assert seen == pytest.approx(speed, rel=2e-3 if model == "straight" else 1e-2)
    # Nobody is carried to the side.
    assert max(abs(row["y"] - 1.0) for row in rows) < 0.5


#: The row of test_queue.py, on a slope.
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
grounds = [{{ corners = [[-1, -1], [50, -1], [50, 2], [-1, 2]], downhill = {downhill}, angle = {angle}, held = {held} }}]
[decision]
model = "straight"
desired_speed = 0.02
waypoints = [{{ x = 50.0, y = 0.31 }}]
queue = {{ push = 80 }}
"""


@pytest.mark.parametrize(("people", "angle", "held", "downhill"), [(1, 10, 0.5, 0), (6, 10, 0.5, 0), (6, 25, 0.5, 0), (6, 25, 1.0, 0), (6, 25, 0.5, 180), (6, 25, 0.5, 60)])
def test_who_leans_downhill_presses_with_the_weight_that_feet_do_not_hold(lemons, tmp_path, people, angle, held, downhill):
    """n F + (1 - held) m g sin(angle), summed over everybody; of who leans uphill, feet hold all."""
    length = 0.62 * people + 0.4
    (tmp_path / "row.toml").write_text(ROW.format(people=people, length=length, angle=angle, held=held, downhill=downhill))
    subprocess.run([lemons, "crowd", "--scenario", tmp_path / "row.toml", "-o", tmp_path / "row"], check=True, capture_output=True)
    measured = [lemons, "measure", tmp_path / "row", "--until", 40, "--from", 25, "--walls", "--summary", "-"]
    summary = json.loads(subprocess.run(list(map(str, measured)), check=True, capture_output=True, text=True).stdout)
    force = sum(panel["load_10"] * panel["length"] for panel in summary["panels"] if panel["x1"] == panel["x2"] == pytest.approx(length))
    agents = (tmp_path / "row" / "static" / "Agents.xml").read_text()
    mass = sum(float(part.split('"')[1]) for part in agents.split(" Mass=")[1:])
    # The part along the row; what pulls to the side, its walls hold.
    free = max(0.0, math.cos(math.radians(downhill)))
    pull = (1 - held) * mass * 9.81 * math.sin(math.radians(angle))
    # Of who leans askew, feet let go of the part that points downhill.
    assert force == pytest.approx(80 * people + pull * free * free, rel=2e-3)


@pytest.mark.parametrize("balance", ["pendulum", "two-level", "none"])
def test_who_stands_on_a_slope_stays_there(lemons, tmp_path, balance):
    """Feet hold: with legs, in plan an inverted pendulum on a slope is that of the level (Kajita et al. 2001)."""
    scenario = f"""\
number = 4
box = [4.0, 4.0]
time_step = 0.01
grounds = [{{ {SQUARE}, downhill = 30, angle = ANGLE, held = 0.3 }}]
[decision]
balance = "{balance}"
desired_speed = 0.0
goals = [{{ polygon = [[-9, -9], [9, -9], [9, 9], [-9, 9]] }}]
"""
    scenario = scenario.replace("[decision]", "pushes = [{ at = [2.0, 2.0], radius = 9.0, direction = 70.0, force = 250.0, start = 1.0, duration = 0.5 }]\n[decision]")
    ends = []
    for angle in ("0", "15"):
        rows = run(lemons, tmp_path, scenario.replace("ANGLE", angle), "--until", 5, "--force")
        assert max(row["vy"] for row in rows) > 0.1
        ends.append([(row["x"], row["y"]) for row in rows if row["t"] == 5])
        (tmp_path / "scenario.toml").unlink()
        shutil.rmtree(tmp_path / "T")
    assert max(math.dist(*places) for places in zip(*ends)) < 1e-9


#: Two rooms that are one corridor: of 16 m from the left wall to the exit, in plan.
FLOORS = """<?xml version="1.0"?>
<Geometry>
  <Wall Id="a" MaterialId="concrete"><Corner Coordinates="10.6,0"/><Corner Coordinates="0,0"/><Corner Coordinates="0,2"/>
    <Corner Coordinates="10.6,2"/><Corner Coordinates="10.6,0"/></Wall>
  <Wall Id="b" MaterialId="concrete"><Corner Coordinates="20,9"/><Corner Coordinates="20,-0.6"/><Corner Coordinates="22,-0.6"/>
    <Corner Coordinates="22,9"/></Wall>
  <Link Id="l"><Corner Coordinates="10,0"/><Corner Coordinates="10,2"/><Corner Coordinates="20,0"/><Corner Coordinates="22,0"/></Link>
</Geometry>
"""
ON_FLOORS = """\
geometry = "floors.xml"
number = {number}
regions = [{{ corners = [[0.4, 0.4], [{to}, 0.4], [{to}, 1.6], [0.4, 1.6]] }}]
leave = true
time_step = 0.02
[decision]
model = "{model}"
exits = [{{ name = "out", line = [[20, 6], [22, 6]] }}]
"""


def left(rows):
    return max(row["t"] for row in rows if row["active"] == 1)


def test_a_link_is_as_long_as_no_way(lemons, tmp_path):
    """The outside: who goes 16 m at 1.34 m/s. The second floor is turned by 90 degrees."""
    (tmp_path / "floors.xml").write_text(FLOORS)
    rows = run(lemons, tmp_path, ON_FLOORS.format(number=1, to=1.6, model="straight"), "--until", 20)
    start = rows[0]["x"]
    # Until the speed is reached, half a second of way is lost.
    relaxation = 1 / float((tmp_path / "T/static/Agents.xml").read_text().split('FloorDamping="')[1].split('"')[0])
    assert left(rows) == pytest.approx((10 - start + 6) / SPEED + relaxation, abs=0.15)
    # The gaze and the velocity turn with the floor.
    above = [row for row in rows if row["x"] > 15 and row["active"] == 1]
    assert min(math.hypot(row["vx"], row["vy"]) for row in above) > 1.2 and above[-1]["vy"] > 1.3 and abs(above[-1]["theta"] % (2 * math.pi) - math.pi / 2) < 0.2


def test_a_crowd_goes_over_a_link_one_after_the_other(lemons, tmp_path):
    """All arrive; nobody appears in somebody: no contact across it begins with an overlap."""
    (tmp_path / "floors.xml").write_text(FLOORS)
    rows = run(lemons, tmp_path, ON_FLOORS.format(number=14, to=7.0, model="rotational"), "--until", 60)
    assert left(rows) < 40
    by_person = {}
    for row in rows:
        by_person.setdefault(row["id"], []).append(row)
    overlaps = []
    for person in by_person.values():
        over = [after for before, after in zip(person, person[1:]) if math.dist((before["x"], before["y"]), (after["x"], after["y"])) > 5]
        assert len(over) == 1
        overlaps.append(over[0]["peak_overlap"])
    assert max(overlaps) < 2e-3
    # Whoever is counted on a line between both floors walked there: nobody did.
    counted = subprocess.run([str(lemons), "measure", "run.csv", "--trial", "T", "--line", "15,-5,15,9"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "nobody crossed it" in counted.stdout


@pytest.mark.parametrize(("change", "said"), [
    (('"10,0"/><Corner Coordinates="10,2"', '"10.4,0"/><Corner Coordinates="10.4,2"'), "a wall is in the strip of 0.5 m behind"),
    (('"20,0"/><Corner Coordinates="22,0"', '"22,0"/><Corner Coordinates="20,0"'), "are people to walk on its left"),
    (('"22,0"/></Link>', '"22,0.1"/></Link>'), "equally long"),
])
def test_a_link_the_wrong_way_is_told(lemons, tmp_path, change, said):
    assert change[0] in FLOORS
    (tmp_path / "floors.xml").write_text(FLOORS)
    run(lemons, tmp_path, ON_FLOORS.format(number=1, to=1.6, model="straight"), "--until", 1)
    (tmp_path / "T/static/Geometry.xml").write_text(FLOORS.replace(*change))
    done = subprocess.run([str(lemons), "check", "T"], cwd=tmp_path, capture_output=True, text=True)
    assert said in done.stdout + done.stderr and "Geometry.xml" in done.stdout + done.stderr

def test_the_fmus_do_what_the_trial_does(lemons, tmp_path):
    """Stairs, a link and a slope in packed FMUs give the same table as in memory."""
    ground = '  <Ground Id="s" Downhill="0" Riser="0.17" Tread="0.29"><Corner Coordinates="4,0"/><Corner Coordinates="8,0"/><Corner Coordinates="8,2"/><Corner Coordinates="4,2"/></Ground>\n'
    slope = '  <Ground Id="r" Downhill="1" Angle="0.1" Held="0.4"><Corner Coordinates="20,2"/><Corner Coordinates="22,2"/><Corner Coordinates="22,4"/></Ground>\n'
    (tmp_path / "floors.xml").write_text(FLOORS.replace("  <Link", ground + slope + "  <Link"))
    rows = run(lemons, tmp_path, ON_FLOORS.format(number=5, to=4.0, model="rotational"), "--until", 12)
    words = [["pack", "T", "-o", "crowd.fmu"], ["decide", "T", "-o", "decision.fmu"], ["connect", "crowd.fmu", "decision.fmu", "-o", "both.ssp"]]
    for call in [*words, ["run", "both.ssp", "--until", "12", "-o", "fmus.csv"]]:
        done = subprocess.run([str(lemons), *call], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    with (tmp_path / "fmus.csv").open() as table:
        other = [{key: float(value) for key, value in row.items() if value} for row in csv.DictReader(table)]
    kept = ("t", "id", "x", "y", "vx", "vy", "theta", "active")
    assert len(rows) == len(other) and all(repr(row[key]) == repr(same[key]) for row, same in zip(rows, other) for key in kept)
    assert max(row["x"] for row in rows) > 20


RAMP = '<Ground Id="r" Downhill="0" Angle="0.1" Held="0.5"><Corner Coordinates="1,0"/><Corner Coordinates="3,0"/><Corner Coordinates="3,2"/><Corner Coordinates="1,2"/></Ground>'


@pytest.mark.parametrize(("change", "said"), [
    (('Held="0.5"', 'Held="1.5"'), '<Ground> Held="1.5": must be from 0 to 1'),
    (('Held="0.5"', ""), "needs Angle and Held, of a slope, or Riser and Tread, of stairs"),
    (('Held="0.5"', 'Held="0.5" Riser="0.2"'), "needs Angle and Held, of a slope, or Riser and Tread, of stairs"),
    (('Angle="0.1"', 'Angle="1.2"'), 'ground "r": falls by an angle of 1.2 rad: must be from 0 to 1 rad'),
    (('Angle="0.1"', 'Angle="steep"'), '<Ground> Angle="steep": must be a finite decimal number'),
    (('Angle="0.1" Held="0.5"', 'Riser="0.2" Tread="0.001"'), 'ground "r": falls by an angle of'),
    (('Angle="0.1" Held="0.5"', 'Riser="-0.2" Tread="0.3"'), '<Ground> Riser="-0.2": must be positive'),
    (('Held="0.5"', 'Held="0.5" SpeedUp="1e300"'), "factors of speeds must be from 0.01 to 10"),
    (('"3,0"', '"1,2"'), 'ground "r": its rim meets itself, or it has no area'),
    (('"3,2"/><Corner Coordinates="1,2"', '"1,2"/><Corner Coordinates="3,2"'), 'ground "r": its rim meets itself'),
    (('<Corner Coordinates="3,2"/><Corner Coordinates="1,2"/>', ""), 'ground "r" has 2 corners: it needs three'),
    (('Held="0.5"', 'Held="0.25"'), ""),
    (('Coordinates="1,2"', 'Coordinates="1,nowhere"'), 'Coordinates="1,nowhere"'),
    (('<Corner Coordinates="22,0"/></Link>', '<Corner Coordinates="20,1e3"/></Link>'), "from 0.1 to 50 m long"),
    (("</Geometry>", RAMP + "</Geometry>"), "duplicate Id"),
    (('<Corner Coordinates="22,0"/></Link>', "</Link>"), 'link "l" has 3 corners: it needs four'),
])
def test_what_cannot_be_a_ground_or_a_link_is_refused(lemons, tmp_path, change, said):
    (tmp_path / "floors.xml").write_text(FLOORS)
    run(lemons, tmp_path, ON_FLOORS.format(number=1, to=1.6, model="straight"), "--until", 1)
    file = FLOORS.replace("<Link", RAMP + "\n<Link")
    assert change[0] in file
    (tmp_path / "T/static/Geometry.xml").write_text(file.replace(*change))
    done = subprocess.run([str(lemons), "check", "T"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode != 0) == bool(said) and said in done.stdout + done.stderr, done.stdout + done.stderr
    assert not said or "Geometry.xml:" in done.stdout + done.stderr


def test_who_is_not_behind_the_line_but_behind_a_wall_stays(lemons, tmp_path):
    """Another room may begin in the strip."""
    walls = FLOORS.replace('"10.6,', '"10.2,').replace("  <Link", '  <Wall Id="c" MaterialId="concrete"><Corner Coordinates="10.21,-1"/><Corner Coordinates="10.21,3"/><Corner Coordinates="14,3"/><Corner Coordinates="14,-1"/><Corner Coordinates="10.21,-1"/></Wall>\n  <Link')
    (tmp_path / "floors.xml").write_text(walls)
    scenario = 'geometry = "floors.xml"\nnumber = 1\nregions = [{ corners = [[10.22, 0.2], [10.72, 0.2], [10.72, 1.8], [10.22, 1.8]] }]\ntime_step = 0.02\n'
    rows = run(lemons, tmp_path, scenario, "--until", 0.2)
    assert rows[-1]["x"] == rows[0]["x"] and 10.22 < rows[0]["x"] < 10.5


@pytest.mark.parametrize("balance", ["pendulum", "two-level"])
def test_who_stands_keeps_the_balance_over_a_link(lemons, tmp_path, balance):
    """Legs come along: the outside is nobody's fall."""
    (tmp_path / "floors.xml").write_text(FLOORS)
    scenario = f'geometry = "floors.xml"\nnumber = 1\nregions = [{{ corners = [[10.05, 0.4], [10.55, 0.4], [10.55, 1.6], [10.05, 1.6]] }}]\n[decision]\nbalance = "{balance}"\n'
    scenario += "desired_speed = 0.0\ngoals = [{ polygon = [[-9, -9], [40, -9], [40, 20], [-9, 20]] }]\n"
    rows = run(lemons, tmp_path, scenario, "--until", 3)
    assert rows[0]["x"] < 10.6 and rows[-1]["x"] > 19.9
    assert max(math.hypot(row["vx"], row["vy"]) for row in rows) < 0.05 and rows[-1]["fallen"] == 0


def test_with_coarse_frames_nobody_crosses_a_line_between_floors(lemons, tmp_path):
    (tmp_path / "floors.xml").write_text(FLOORS)
    run(lemons, tmp_path, ON_FLOORS.format(number=5, to=4.0, model="rotational"), "--until", 20, "--every", 100)
    counted = subprocess.run([str(lemons), "measure", "run.csv", "--trial", "T", "--line", "15,-5,15,9"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "nobody crossed it" in counted.stdout


@pytest.mark.parametrize("model", ["rotational", "social-force", "collision-free-speed"])
def test_nobody_evades_on_stairs(lemons, tmp_path, model):
    """Two ahead stand; who comes up behind them wants no speed to the side."""
    scenario = f"""\
box = [10.0, 4.0]
number = 6
regions = [{{ corners = [[2, 1], [4, 1], [4, 3], [2, 3]] }}]
grounds = [{{ {SQUARE}, downhill = 180, riser = 0.17, tread = 0.29 }}]
[decision]
model = "{model}"
waypoints = [{{ x = 60.0, y = 2.0 }}]
[decision.agents.0]
desired_speed = 0.2
[decision.agents.1]
desired_speed = 0.3
"""
    (tmp_path / "scenario.toml").write_text(scenario)
    for words in (["crowd", "--scenario", "scenario.toml", "-o", "T"], ["run", "T", "-o", "run.rows", "--format", "csv", "--outputs", "table.csv", "--until", "3"]):
        done = subprocess.run([str(lemons), *words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    with (tmp_path / "table.csv").open() as table:
        rows = [{key: float(value) for key, value in row.items() if key == "t" or ".Fp." in key} for row in csv.DictReader(table)]
    with (tmp_path / "run.rows").open() as table:
        places = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(table)]
    for i in range(6):
        at = {row["t"]: (row["x"], row["y"]) for row in places if row["id"] == i}
        for row in rows[1:]:
            x, y = at[row["t"]]
            way = math.atan2(2.0 - y, 60.0 - x)
            fx, fy = row[f"decision.agent[{i}].Fp.x"], row[f"decision.agent[{i}].Fp.y"]
            across = fy * math.cos(way) - fx * math.sin(way)
            assert abs(across) < 1e-4 * (1 + math.hypot(fx, fy)) and fx > -1e-9


@pytest.mark.parametrize("low", [-0.03, -0.23])
def test_who_finds_no_room_beyond_a_link_waits_before_it(lemons, tmp_path, low):
    """Somebody stands where the first one would arrive, or between there and the line: the outside is the strip of 0.5 m behind
    the line at x = 10 m."""
    (tmp_path / "floors.xml").write_text(FLOORS)
    scenario = f"""\
geometry = "floors.xml"
regions = [
  {{ corners = [[5.0, 0.7], [5.7, 0.7], [5.7, 1.3], [5.0, 1.3]], number = 1 }},
  {{ corners = [[20.66, {low}], [21.0, {low}], [21.0, {low + 0.6}], [20.66, {low + 0.6}]], number = 1 }},
]
leave = true
orientation = "fixed"
direction = 0.0
time_step = 0.02
[decision]
model = "straight"
exits = [{{ name = "out", line = [[20, 6], [22, 6]] }}]
[decision.agents.1]
desired_speed = 0.0
"""
    rows = run(lemons, tmp_path, scenario, "--until", 12)
    waits = [row for row in rows if row["id"] == 0 and row["t"] > 8]
    assert waits and all(10.0 < row["x"] < 10.6 for row in waits)
    assert max(row["agent_contacts"] for row in rows if row["id"] == 1) == 0
