"""How hard does a crowd press on a barrier? Columns of 1 to 20 people, two terraces, a narrow alley, and an FMU.

    python examples/barriers.py barriers
    python examples/barriers.py barriers columns --seeds 20

Everybody presses towards the barrier with one stated force, as docs/walking.md says ("Queues that push"). docs/barriers.md has
the tables, their sources and what they mean. The cases, each of which can be named:

- `columns`: n people in a lane of 0.7 to 2.4 m, on the flat: what the barrier gets of n times the push.
- `terrace`: the two columns of the Green Guide, table 11.2: 4.3 m deep on 10°, 3.1 m on 25°, 4.7 people per m².
- `alley`: a stretch of 8 m, 3.2 m wide, on 10°, where nobody gets on. One run shows what a force per person and a force per
  metre are of the same crowd.
- `passage`: 4 m by 45 m on 10°, open at both ends: how many get through in a minute, 1000 one way and 200 to 800 both ways.
- `fmu`: the terrace on 10° as an FMU with the results of a run, and its digest.

`--seeds 100` for terrace and alley is what the page shows: twenty minutes of one core. Needs the command `lemons` (or its path
in the variable LEMONS), numpy and pandas.
"""

import argparse
import hashlib
import math
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
#: m/s²
GRAVITY = 9.81
#: What feet hold is m g s/l (docs/balance.md): s in m, and l as a part of the stature.
SUPPORT, HEIGHT_PART = 0.25, 0.56
#: Guide to Safety at Sports Grounds, table 11.2: loads in kN/m, and the distances of barriers for them in m, by the angle in °.
LOADS = [5.0, 4.0, 3.4, 3.0, 2.0]
DISTANCES = {10: [4.3, 3.4, 2.9, 2.6, 1.7], 15: [3.8, 3.0, 2.6, 2.3, 1.5], 20: [3.4, 2.7, 2.3, 2.0, 1.3], 25: [3.1, 2.5, 2.1, 1.8, 1.2]}
#: 1/m²
TERRACE_DENSITY = 4.7
#: m; the barrier of a terrace.
BARRIER = 4.0
#: N, and the share of the ground's pull that feet hold: what fits table 11.2 as a whole, with the survey's 75 kg.
PUSH, HELD = 180, 0.45
#: m, °, 1/m²
ALLEY_WIDTH, ALLEY_ANGLE, ALLEY_DENSITY = 3.2, 10, 8.75
#: m; what Park (2022) simulated.
PASSAGE = 45.0, 4.0
#: s; between them a pressed stretch is measured.
SINCE, UNTIL = 3.0, 4.0

#: Downhill is along x. Wall 1 is the barrier, wall 3 the other end; people stand between them.
GEOMETRY = """\
<?xml version="1.0" encoding="utf-8"?>
<Geometry>
    <Dimensions Lx="{length}" Ly="{width}"/>
{walls}{ground}</Geometry>
"""
WALL = """\
    <Wall Id="{id}" MaterialId="concrete">
        <Corner Coordinates="{x1},{y1}"/>
        <Corner Coordinates="{x2},{y2}"/>
    </Wall>
"""
GROUND = """\
    <Ground Id="0" Downhill="0.0" Angle="{angle}" Held="{held}">
        <Corner Coordinates="-1.0,-1.0"/>
        <Corner Coordinates="{length},-1.0"/>
        <Corner Coordinates="{length},{width}"/>
        <Corner Coordinates="-1.0,{width}"/>
    </Ground>
"""
#: In one file, centre behind centre.
ROUND = """\
round = true
packing = "grid"
orientation = "fixed"
direction = 0.0
"""
#: Walking does not press: 20 N at most. People queue up within 10 s, the last alone, and then lean.
SCENARIO = """\
geometry = "{name}.xml"
regions = [{regions}]
number = {people}
seed = 1
{extra}friction = {friction}
time_step = 0.02
panel_length = 0.5

[decision]
model = "straight"
push = 20.0
waypoints = [{{ x = 1e5, y = {middle} }}]
queue = {{ push = {push} }}
"""
OPEN = """\
geometry = "passage.xml"
regions = [{regions}]
number = {people}
seed = 1
time_step = 0.05

[decision]
model = "rotational"
exits = [{{ name = "down", line = [[{down}, 0], [{down}, {width}]] }}, {{ name = "up", line = [[-1, 0], [-1, {width}]] }}]
"""
SWEEP = """\
scenario = "{name}.toml"
until = {until}

[parameters]
"population.seed" = {{ from = 1, to = {seeds} }}

[areas]
foot = [{near}, 0, {length}, {width}]

[measures]
barrier = {{ load = "load_1", wall = "1", whole = true, from = {since} }}
sides = {{ load = "load_1", wall = "0", whole = true, from = {since} }}
felt = {{ squeeze = "impulse", across = "mean", from = {since} }}
most = {{ squeeze = "impulse", across = "quantile_90", from = {since} }}
density = {{ area = "foot", number = "voronoi_density", take = "mean", from = {since} }}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for scenarios and results")
parser.add_argument("cases", metavar="CASE", nargs="*", help="columns, terrace, alley, passage, fmu (default: all)")
parser.add_argument("--seeds", type=int, default=5)
parser.add_argument("--people", type=int, nargs="+", default=[1, 2, 3, 5, 7, 10, 15, 20], help="numbers of the columns")
parser.add_argument("--part", type=float, default=1.0, help="this part of the people of the passage")
parser.add_argument("--length", type=float, default=8.0, help="length of the alley in m")


def lemons(*words):
    """Runs the command, and returns what it prints. Its warnings (the way crosses the barrier) are known here."""
    done = subprocess.run([LEMONS, *map(str, words)], text=True, capture_output=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def regions(ends, width):
    """Returns regions of a scenario between these ends: the first Ids are in the first one."""
    return ", ".join(f"{{ corners = [[{a}, 0], [{b}, 0], [{b}, {width}], [{a}, {width}]] }}" for a, b in zip(ends, ends[1:]))


class Scene:
    """People before a barrier, in files that a user could have written."""

    def __init__(
        self, target, name, length, width, people, push, *, friction=0.1, round_bodies=False, overlap=False, angle=0.0, held=HELD, both_ways=False
    ):
        """Writes NAME.xml and NAME.toml. With `both_ways`, those in the lower half want up."""
        self.target, self.name, self.length, self.width, self.people = target, name, length, width, people
        self.push, self.pull = push, (1 - held) * GRAVITY * math.sin(math.radians(angle))
        corners = [(length, width), (0, width), (0, 0), (length, 0)]
        sides = {0: (0, 1), 3: (1, 2), 2: (2, 3), 1: (3, 0)}
        walls = [WALL.format(id=k, x1=corners[a][0], y1=corners[a][1], x2=corners[b][0], y2=corners[b][1]) for k, (a, b) in sides.items()]
        ground = GROUND.format(angle=math.radians(angle), held=held, length=length + 1, width=width + 1) if angle else ""
        (target / f"{name}.xml").write_text(GEOMETRY.format(length=length, width=width, walls="".join(walls), ground=ground))
        extra = (ROUND if round_bodies else "") + ("allow_overlap = true\n" if overlap else "")
        boxes = regions([0, length / 2, length] if both_ways else [0, length], width)
        rest = {"name": name, "friction": friction, "middle": width / 2, "push": float(push)}
        text = SCENARIO.format(regions=boxes, people=people, extra=extra, **rest)
        if both_ways:
            up = [f"{k} = {{ waypoints = [{{ x = -1e5, y = {width / 2} }}] }}\n" for k in range((people + 1) // 2, people)]
            text += "\n[decision.agents]\n" + "".join(up)
        (target / f"{name}.toml").write_text(text)

    def sweep(self, seeds, until=8.0, since=6.0):
        """Returns means and half 95 % intervals of what SWEEP measures: loads in kN/m, squeezes in kN, people per m²."""
        sweep, table, cases = (self.target / f"{self.name}{end}" for end in ("_sweep.toml", ".csv", "_cases.csv"))
        foot = {"near": max(0, self.length - 3), "length": self.length, "width": self.width}
        sweep.write_text(SWEEP.format(name=self.name, until=until, seeds=seeds, since=since, **foot))
        # A sweep goes on with the table that it finds.
        table.unlink(missing_ok=True)
        lemons("sweep", sweep, "-o", table, "--threads", 1, "--summary", cases, "--over", "population.seed", "--force")
        row = pd.read_csv(cases).iloc[0]
        per = {"barrier": 1e3, "sides": 1e3, "felt": 1e3 * (until - since), "most": 1e3 * (until - since), "density": 1}
        return {key: (row[f"{key}_mean"] / by, (row[f"{key}_high"] - row[f"{key}_mean"]) / by) for key, by in per.items()}

    def trial(self):
        """Makes the Trial of the first seed, and returns it with masses and statures."""
        trial = self.target / self.name
        lemons("crowd", "--scenario", self.target / f"{self.name}.toml", "-o", trial, "--force")
        agents = (trial / "static" / "Agents.xml").read_text()
        return trial, *(np.array(re.findall(rf' {key}="([^"]+)"', agents), float) for key in ("Mass", "Height"))

    def given(self):
        """Returns what all give together in N, of the first seed: each the push, or what feet hold, and the pull of the ground."""
        _, mass, stature = self.trial()
        feet = mass * GRAVITY * SUPPORT / (HEIGHT_PART * stature)
        return float(np.sum(np.minimum(self.push, feet) + mass * self.pull))


def cell(measured, by=1.0):
    """Returns a mean with half its interval as text."""
    mean, half = (by * value for value in measured)
    return f"{mean:.2f}" if math.isnan(half) else f"{mean:.2f} ± {half:.2f}"


def silo(people, width, friction, density=7.0, sideways=0.8):
    """Returns what friction of the sides leaves of n times the push (Janssen 1895), if they bear `sideways` of the load."""
    a = 2 * friction * sideways * people / (density * width**2)
    return -math.expm1(-a) / a if a else 1.0


def columns(target, arguments):
    """Prints the share of n times the push that the barrier gets."""
    push = 100
    lanes = {
        "one file, round, no friction": (0.62, 0.0, True),
        "0.7 m, no friction": (0.7, 0.0, False),
        "0.7 m, friction 0.1": (0.7, 0.1, False),
        "0.7 m, friction 0.5": (0.7, 0.5, False),
        "1.2 m, friction 0.1": (1.2, 0.1, False),
        "2.4 m, friction 0.1": (2.4, 0.1, False),
    }
    print(f"columns: what the barrier gets of n times {push} N (and what the sides leave by the silo's formula), {arguments.seeds} seeds")
    print(" " * 30 + "".join(f"{f'n = {n}':>19}" for n in arguments.people))
    for name, (width, friction, round_bodies) in lanes.items():
        row = []
        for n in arguments.people:
            length = round(0.62 * n + 0.2 if round_bodies else max(0.8, n / 4 / width), 3)
            scene = Scene(target, "column", length, width, n, push, friction=friction, round_bodies=round_bodies)
            seen = scene.sweep(arguments.seeds, 12.0, 10.0)["barrier"]
            row.append(f"{cell(seen, width * 1e3 / (n * push))} ({silo(n, width, friction):.2f})")
        print(f"{name:<30}" + "".join(f"{part:>19}" for part in row), flush=True)
    print("\nwhat feet hold: 20 people, 1.2 m, no friction; kN")
    for push in (50, 100, 150, 200, 300, 400):
        scene = Scene(target, "feet", 20 / 4 / 1.2, 1.2, 20, push, friction=0.0)
        print(f"{push:>5} N: {cell(scene.sweep(arguments.seeds, 12.0, 10.0)['barrier'], 1.2)}, and {scene.given() * 1e-3:.2f} if all lean")


def table_11_2():
    """Prints the force per person of all 20 distances, and the push and the share of the weight that fit them best."""
    rows = [(angle, load * 1e3 / distance / TERRACE_DENSITY) for angle, row in DISTANCES.items() for load, distance in zip(LOADS, row)]
    sines = np.array([math.sin(math.radians(angle)) for angle, _ in rows])
    force = np.array([force for _, force in rows])
    (push, weight), *_ = np.linalg.lstsq(np.stack([np.ones(len(rows)), sines], axis=1), force, rcond=None)
    misfit = (push + weight * sines) / force - 1
    print("table 11.2, N per person: " + ", ".join(f"{np.mean([f for a, f in rows if a == angle]):.0f} on {angle}°" for angle in DISTANCES))
    print(f"best: {push:.0f} N + {weight:.0f} N sin(angle), misfit {100 * np.sqrt(np.mean(misfit**2)):.1f} % (at most {100 * np.max(np.abs(misfit)):.1f} %)")


def terrace(target, arguments):
    """Prints loads on the barriers of both columns."""
    table_11_2()
    print(f"\nterrace: load on a barrier of {BARRIER} m in kN/m, wanted 5.0 on both; {arguments.seeds} seeds")
    few = min(arguments.seeds, 5)
    others = [(150, HELD, few), (PUSH, 0.5, few), (PUSH, 0.0, few), (120, 0.0, few), (PUSH, 1.0, few), (400, 1.0, few)]
    for push, held, seeds in [(PUSH, HELD, arguments.seeds), *others]:
        cells = []
        for angle in (10, 25):
            scene = column(target, f"terrace_{angle}", angle, push, held)
            cells.append(f"{angle}°: {cell(scene.sweep(seeds)['barrier'])} ({scene.given() * 1e-3 / BARRIER:.2f} if all lean)")
        print(f"push {push:>3} N, held {held}, {seeds:>3} seeds: " + "   ".join(cells))


def column(target, name, angle, push, held):
    """Returns a column of the Green Guide before a barrier for 5.0 kN/m."""
    depth = DISTANCES[angle][0]
    return Scene(target, name, depth, BARRIER, round(TERRACE_DENSITY * depth * BARRIER), push, angle=angle, held=held)


def alley(target, arguments):
    """Prints loads and squeezes of a stretch where nobody gets on, and what both are in one run."""
    few = min(arguments.seeds, 5)
    print(f"alley: {ALLEY_WIDTH} m on {ALLEY_ANGLE}°, {ALLEY_DENSITY} people per m² at the start, ends shut, from {SINCE:g} to {UNTIL:g} s")
    heads = {"barrier": "foot, kN/m", "sides": "sides, kN/m", "felt": "squeeze, kN", "most": "of one in ten", "density": "per m², lowest 3 m"}
    print(f"{'':<34}" + "".join(f"{head:>20}" for head in heads.values()))
    for push, both, length, seeds in (
        (50, False, arguments.length, arguments.seeds),
        (50, True, arguments.length, arguments.seeds),
        (20, False, arguments.length, few),
        (PUSH, False, arguments.length, few),
        (PUSH, True, arguments.length, few),
        (50, False, arguments.length / 2, few),
        (50, False, arguments.length * 2, few),
    ):
        seen = stretch(target, push, both, length).sweep(seeds, UNTIL, SINCE)
        name = f"{push} N, {'both ways' if both else 'one way'}, {length:g} m, {seeds} seeds"
        print(f"{name:<34}" + "".join(f"{cell(seen[key]):>20}" for key in heads), flush=True)
    one_run(target, stretch(target, 50, False, arguments.length))


def stretch(target, push, both, length):
    """Returns a stretch of the alley."""
    people = round(ALLEY_DENSITY * length * ALLEY_WIDTH)
    # With some seeds they stand closer than bodies allow, by 2 mm at most.
    return Scene(target, "alley", length, ALLEY_WIDTH, people, push, overlap=True, angle=ALLEY_ANGLE, both_ways=both)


def one_run(target, scene):
    """Prints, by the distance from the foot, forces on people and on the sides, of the first seed."""
    trial, *_ = scene.trial()
    lemons("measure", trial, "--until", UNTIL, "--from", SINCE, "--walls", "-o", target / "one", "--force")
    lemons("run", trial, "--until", UNTIL, "--every", 50, "-o", target / "one.csv", "--force")
    places = pd.read_csv(target / "one.csv").groupby("id")["x"].last()
    people = pd.read_csv(target / "one" / "people.csv").set_index("id")["impulse"] / (UNTIL - SINCE)
    panels = pd.read_csv(target / "one" / "panels.csv")
    print("\none run: the same crowd, by the distance from the foot. Plane: squeeze × √density / 4")
    print(f"{'':<10}{'people':>8}{'squeeze, N':>14}{'plane, N/m':>14}{'sides, N/m':>14}")
    side = panels[panels["wall"].astype(str).isin(["0", "2"])]
    middles = scene.length - (side["x1"] + side["x2"]) / 2
    away = scene.length - places
    whole = [0, 0, 0]
    for k in range(0, math.ceil(scene.length), 2):
        here = people[(away >= k) & (away < k + 2)]
        load = side[(middles >= k) & (middles < k + 2)]
        density = len(here) / (2 * scene.width)
        row = here.mean(), here.mean() * math.sqrt(density) / 4, load["impulse"].sum() / (UNTIL - SINCE) / load["length"].sum()
        whole = [total + len(here) * value for total, value in zip(whole, row)]
        print(f"{f'{k} to {k + 2} m':<10}{len(here):>8}{row[0]:>14.0f}{row[1]:>14.0f}{row[2]:>14.0f}")
    print(f"{'all':<10}{len(people):>8}" + "".join(f"{value / len(people):>14.0f}" for value in whole))
    foot = panels[panels["wall"].astype(str) == "1"]
    load = foot["impulse"].sum() / (UNTIL - SINCE) / foot["length"].sum()
    print(f"the foot: {load:.0f} N/m; what people and ground give: {scene.given() / scene.width:.0f} N/m")


def passage(target, arguments):
    """Prints how many get through an open alley in a minute, one way and both ways."""
    print(f"passage: {PASSAGE[0]:g} m × {PASSAGE[1]:g} m on {ALLEY_ANGLE}°, open at both ends, model rotational, one seed")
    length, width = PASSAGE
    for people, both in ((1000, False), (200, True), (400, True), (800, True)):
        people = math.ceil(people * arguments.part)
        walls = "".join(WALL.format(id=k, x1=-3, y1=y, x2=length + 3, y2=y) for k, y in enumerate((0, width)))
        ground = GROUND.format(angle=math.radians(ALLEY_ANGLE), held=HELD, length=length, width=width + 1)
        (target / "passage.xml").write_text(GEOMETRY.format(length=length, width=width, walls=walls, ground=ground))
        # Those above, with the lower Ids, want down; those below want up.
        exits = "".join(f'{k} = {{ exit = "{"up" if both and k >= (people + 1) // 2 else "down"}" }}\n' for k in range(people))
        text = OPEN.format(regions=regions([0, length / 2, length], width), people=people, down=length + 1, width=width)
        (target / "passage.toml").write_text(text + "\n[decision.agents]\n" + exits)
        lemons("crowd", "--scenario", target / "passage.toml", "-o", target / "passage", "--force")
        lemons("run", target / "passage", "--until", 60, "--every", 1200, "-o", target / "passage.csv", "--force")
        rows = pd.read_csv(target / "passage.csv")
        stay = rows[rows["t"] == rows["t"].max()]
        left = people - int(stay["active"].sum())
        print(f"{people:>5} people, {'both ways' if both else 'one way':<9}: {left:>4} are out after 60 s", flush=True)


def fmu(target, arguments):
    """Packs the terrace on 10° with the results of a run, and prints digests."""
    trial, *_ = column(target, "barrier", 10, PUSH, HELD).trial()
    packed = target / "barrier.fmu"
    lemons("pack", trial, "--fmi", 3, "--reference", "--until", 4, "-o", packed, "--force")
    print(f"fmu: {packed}, SHA-256 {hashlib.sha256(packed.read_bytes()).hexdigest()}")
    print(lemons("replay", packed).strip())


CASES = {"columns": columns, "terrace": terrace, "alley": alley, "passage": passage, "fmu": fmu}


def main():
    """Makes the tables."""
    arguments = parser.parse_args()
    if unknown := set(arguments.cases) - set(CASES):
        parser.error(f"there is no case {', '.join(sorted(unknown))}; the cases are {', '.join(CASES)}")
    arguments.target.mkdir(parents=True, exist_ok=True)
    for name in arguments.cases or CASES:
        CASES[name](arguments.target, arguments)
        print(f"({os.times().children_user:.0f} s of a processor until here)\n", flush=True)


if __name__ == "__main__":
    main()
