"""Compares people who walk with published measurements, test cases of a guideline and JuPedSim: docs/validation.md.

    cargo build --release
    pip install './python[examples]' jupedsim       # jupedsim: for the figure `peer` only
    python examples/validation.py bottleneck        # one figure: its table is printed, its picture is drawn
    python examples/validation.py --all             # all of them: ten minutes of one core
    python examples/validation.py --all --write     # ... and the tables are put into docs/validation.md

Each figure makes Trials with `lemons crowd`, writes their decision.toml, runs them with `lemons run` and measures them with
`lemons measure`. --quick takes fewer and smaller cases: to see that it works, not for numbers. --keep DIR keeps the Trials.
"""

import argparse
import functools
import inspect
import itertools
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "validation.md"
MODELS = ["rotational", "collision-free-speed", "social-force", "straight"]
COLOURS = {"rotational": "#CC79A7", "straight": "#D55E00", "collision-free-speed": "#0072B2", "social-force": "#009E73"}
SPEED, SPREAD = 1.34, 0.26  # m/s, desired speeds: mean and standard deviation (Weidmann 1993)
STEP = 0.02  # s, communication step
EVERY = 5  # of which every fifth is recorded
MOST = 150.0  # s: who is still there then is stuck


# ---- rooms, crowds, runs ----


def command():
    """The command `lemons`: that of LEMONS, of the clone, or on the PATH."""
    built = ROOT / "target" / "release" / "lemons"
    found = os.environ.get("LEMONS") or (str(built) if built.is_file() else shutil.which("lemons"))
    if not found:
        raise SystemExit("there is no command `lemons`: run `cargo build --release`, or name it in LEMONS")
    return found


def lemons(*words):
    done = subprocess.run([command(), *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"lemons {' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout


def write_geometry(path, walls):
    """Writes walls: polylines [(x, y), ...] in m."""
    high = np.ceil(np.concatenate([[(1, 1)], *walls]).max(axis=0))
    lines = ['<?xml version="1.0" encoding="utf-8"?>', "<Geometry>", f'  <Dimensions Lx="{high[0]}" Ly="{high[1]}"/>']
    for k, wall in enumerate(walls):
        corners = "".join(f'<Corner Coordinates="{x:.6g},{y:.6g}"/>' for x, y in wall)
        lines.append(f'  <Wall Id="{k}" MaterialId="concrete">{corners}</Wall>')
    path.write_text("\n".join([*lines, "</Geometry>", ""]))


def speeds_of(count, seed, mean=SPEED, spread=SPREAD):
    """Desired speeds [m/s]: a normal distribution, cut at two standard deviations."""
    drawn = np.random.default_rng(seed).standard_normal(20 * count + 100)
    return mean + spread * drawn[np.abs(drawn) <= 2][:count]


def write_decision(trial, model, speeds, exits=(), waypoints=None, constants=""):
    """Writes decision.toml. Speeds: of all, or of each; waypoints: of each, [(x, y, radius), ...]."""
    speeds = np.atleast_1d(speeds)
    lines = [f'model = "{model}"', f"desired_speed = {speeds[0]:.4f}"]
    if exits:
        lines += ["exits = [", *(f"  {{ line = [[{a[0]}, {a[1]}], [{b[0]}, {b[1]}]] }}," for a, b in exits), "]"]
    lines += [constants] * bool(constants)
    for i in range(max(len(speeds), len(waypoints or []))):
        own = [f"desired_speed = {speeds[i]:.4f}"] if len(speeds) > 1 else []
        if waypoints:
            points = ", ".join(f"{{ x = {x:.4f}, y = {y:.4f}, radius = {r} }}" for x, y, r in waypoints[i])
            own.append(f"waypoints = [{points}]")
        if own:
            lines += [f"[agents.{i}]", *own]
    (trial / "decision.toml").write_text("\n".join([*lines, ""]))


def make(trial, walls, count, region=None, seed=1, **options):
    """Makes a Trial of people who stand in a region, drawn from the survey, without a decision.toml. Returns their poses.

    A region is a text for `lemons crowd` or its numbers. Several texts may have numbers of people of their own: then count is None.
    """
    trial.parent.mkdir(parents=True, exist_ok=True)
    words = ["crowd", "--seed", seed, "--time-step", STEP, "-o", trial, "--force"]
    if count is not None:
        words += ["--number", count]
    if walls:
        geometry = trial.with_name(trial.name + ".xml")
        write_geometry(geometry, walls)
        words += ["--geometry", geometry]
    if region and not isinstance(region, list):
        region = [region if isinstance(region, str) else ",".join(map(str, region))]
    for each in region or []:
        words += ["--region", each]
    for name, value in options.items():
        words += [f"--{name}", value]
    lemons(*words)
    return poses_of(trial)


def poses_of(trial):
    from xml.etree import ElementTree

    places = {}
    for agent in ElementTree.parse(trial / "dynamic" / "AgentDynamics.xml").getroot():
        kinematics = agent.find("Kinematics")
        places[int(agent.get("Id"))] = [*map(float, kinematics.get("Position").split(",")), float(kinematics.get("Theta"))]
    return np.array([places[i] for i in range(len(places))])


def shapes_of(trial):
    """The disks of each person: x, y, radius [m], the gaze along x."""
    from xml.etree import ElementTree

    shapes = {}
    for agent in ElementTree.parse(trial / "static" / "Agents.xml").getroot():
        disks = [[*map(float, disk.get("Position").split(",")), float(disk.get("Radius"))] for disk in agent.findall("Shape")]
        shapes[int(agent.get("Id"))] = np.array(disks)
    return [shapes[i] for i in range(len(shapes))]


def run(trial, until=MOST):
    """Runs a Trial, at most this long [s]. Returns the path of its table."""
    table = trial.with_name(trial.name + ".csv")
    lemons("run", trial, "--until", until, "--every", EVERY, "-o", table, "--force")
    return table


def frames_of(table):
    """The rows of those who have not left."""
    rows = pd.read_csv(table)
    return rows[rows["active"] == 1] if "active" in rows else rows


def measured(trial, table, *words):
    """Returns the summary of `lemons measure` and its tables."""
    directory = trial.with_name(trial.name + "_measures")
    lemons("measure", table, "--trial", trial, "-o", directory, "--force", *words)
    tables = {name: pd.read_csv(directory / f"{name}.csv") for name in ("flow", "gaps", "density")}
    return json.loads((directory / "summary.json").read_text()), tables


def line(name, a, b):
    return f"--line={name}={a[0]},{a[1]},{b[0]},{b[1]}"


def steady(times, share=(0.2, 0.8)):
    """Flow [1/s] between the passages of a fifth and of four fifths of the people."""
    times = np.sort(times)
    a, b = (round(part * (len(times) - 1)) for part in share)
    return (b - a) / (times[b] - times[a])


def mean_and_spread(values, digits=2):
    """Mean and standard deviation of the runs; NaN stands for a run in which people were stuck."""
    values = np.asarray(list(values), float)
    free = values[np.isfinite(values)]
    words = [f"{free.mean():.{digits}f}"] if len(free) else []
    if len(free) > 1:
        words.append(f"± {free.std(ddof=1):.{digits}f}")
    if len(free) < len(values):
        words.append(f"({len(values) - len(free)} of {len(values)} stuck)")
    return " ".join(words)


def bars(panel, x, runs, model, **look):
    """Draws means with standard deviations of runs that were not stuck."""
    free = [np.array(each)[np.isfinite(each)] for each in runs]
    places = [(at, each.mean(), each.std(ddof=1) if len(each) > 1 else 0.0) for at, each in zip(x, free) if len(each)]
    if places:
        panel.errorbar(*zip(*places), markersize=5, capsize=2, linewidth=0.8, color=COLOURS[model], label=model, **look)


def markdown(head, rows):
    return "\n".join(
        ["| " + " | ".join(map(str, head)) + " |", "|" + "---|" * len(head), *("| " + " | ".join(map(str, row)) + " |" for row in rows)]
    )


# ---- RiMEA ----


def walks_alone(trial, model, speed):
    """The time [s] in which one person walks 40 m in a corridor 2 m wide, from x = 0 to x = 40 m."""
    make(trial, [[(-2, 0), (44, 0)], [(-2, 2), (44, 2)]], 1, "-1.5,0.6,-0.5,1.4", orientation="fixed", fixed="49,25,1.75,70")
    write_decision(trial, model, speed, exits=[((42, 0), (42, 2))])
    summary, _ = measured(trial, run(trial), line("in", (0, 0), (0, 2)), line("out", (40, 0), (40, 2)))
    start, end = (each["directions"][0]["first"] for each in summary["lines"])
    return end - start


def rimea_1(work, quick=False):
    """Test 1: one person walks 40 m in a corridor 2 m wide. The test is the time from x = 0 to x = 40 m."""
    times = [(model, walks_alone(work / f"rimea_1_{model}", model, SPEED)) for model in MODELS]
    rows = [(model, f"{time:.3f}", f"{40 / time:.4f}") for model, time in times]
    return [markdown(["model", "time [s]", "speed [m/s]"], [("closed form, 40 m / 1.34 m/s", f"{40 / SPEED:.3f}", SPEED), *rows])], None


CORNER = [(0, 0), (12, 0), (12, 12), (10, 12), (10, 2), (0, 2)]  # m, closed


def inside(polygon, places):
    """Whether places are inside a closed polygon."""
    x, y = places[:, 0], places[:, 1]
    within = np.zeros(len(places), bool)
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
        crosses = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            within ^= crosses & (x < ax + (bx - ax) * (y - ay) / (by - ay))
    return within


def deepest_in_walls(rows, shapes, walls):
    """How deep a disk of a body is in a wall at most [m]; negative: the smallest gap."""
    deepest = -np.inf
    for i, own in rows.groupby("id"):
        cos, sin = np.cos(own["theta"].to_numpy()), np.sin(own["theta"].to_numpy())
        for dx, dy, radius in shapes[i]:
            at = np.column_stack([own["x"] + dx * cos - dy * sin, own["y"] + dx * sin + dy * cos])
            for wall in walls:
                for a, b in zip(np.asarray(wall, float), np.asarray(wall, float)[1:]):
                    along = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
                    away = np.linalg.norm(a + along[:, None] * (b - a) - at, axis=1)
                    deepest = max(deepest, radius - away.min())
    return deepest


CORNER_WALL = [(12, 12), (12, 0), (0, 0), (0, 2), (10, 2), (10, 12)]  # m


def around_corner(trial, model, seed):
    """Twenty people walk around a corner to the left. Returns the rows of the run, the number of places outside of the
    walls, and how deep somebody is in a wall [mm]."""
    make(trial, [CORNER_WALL], 20, "0,0,6,2", seed)
    write_decision(trial, model, speeds_of(20, seed), exits=[((10, 11.5), (12, 11.5))])
    frames = frames_of(run(trial))
    outside = int((~inside(CORNER, frames[["x", "y"]].to_numpy())).sum())
    return frames, outside, 1000 * deepest_in_walls(frames, shapes_of(trial), [CORNER_WALL])


def rimea_6(work, quick=False):
    """Test 6: twenty people walk around a corner to the left: nobody may go through a wall."""
    rows, paths = [], {}
    for model in MODELS:
        times, deepest, outside = [], [], 0
        for seed in range(1, 2 if quick else 6):
            frames, places, depth = around_corner(work / f"rimea_6_{model}_{seed}", model, seed)
            outside += places
            deepest.append(depth)
            times.append(frames["t"].max())
            paths.setdefault(model, frames)
        rows.append((model, outside, f"{max(deepest):.2f}", mean_and_spread(times, 1)))
    tables = [markdown(["model", "positions outside the walls", "deepest in a wall [mm]", "all have left [s]"], rows)]

    def draw(plt):
        figure, panels = plt.subplots(1, len(paths), figsize=(3 * len(paths), 3.3), sharey=True, layout="constrained")
        for panel, (model, frames) in zip(panels, paths.items()):
            panel.plot(*zip(*CORNER_WALL), color="black", linewidth=1.5)
            for _, own in frames.groupby("id"):
                panel.plot(own["x"], own["y"], linewidth=0.6, color=COLOURS[model])
            panel.set(title=model, xlabel="x / m", aspect="equal")
        panels[0].set_ylabel("y / m")
        return figure

    return tables, draw


def walls_with_doors(wide, high, doors):
    """A room with doors of 1 m in its lower and upper wall: x, y of the middle of each. Returns its walls."""
    walls = []
    for y in (0, high):
        ends = [0, *(x + side for x, at in sorted(doors) if at == y for side in (-0.5, 0.5)), wide]
        walls += [[(a, y), (b, y)] for a, b in zip(ends[::2], ends[1::2])]
    return [*walls, [(0, 0), (0, high)], [(wide, 0), (wide, high)]]


def rimea_9(work, quick=False):
    """Test 9: a room is left by four doors, then by two of them: the second takes about twice as long.

    250 people on 15 m x 10 m instead of 1000 on 30 m x 20 m: as dense.
    """
    count, (wide, high) = (60, (7.5, 5)) if quick else (250, (15, 10))
    rows, curves = [], {}
    xs = (wide / 4, 3 * wide / 4)
    for model in MODELS:
        ends = {}
        for doors in (4, 2):
            cut = [(x, y) for y in ((0, high) if doors == 4 else (0,)) for x in xs]
            trial = work / f"rimea_9_{model}_{doors}"
            make(trial, walls_with_doors(wide, high, cut), count, (0, 0, wide, high), 1)
            outer = [((x - 1.5, y - 1), (x + 1.5, y - 1)) if y == 0 else ((x - 1.5, y + 1), (x + 1.5, y + 1)) for x, y in cut]
            write_decision(trial, model, speeds_of(count, 1), exits=outer)
            frames = frames_of(run(trial))
            last = np.sort(frames.groupby("id")["t"].max().to_numpy())
            curves[model, doors] = last[last < MOST - 1]
            ends[doors] = last[-1] if len(curves[model, doors]) == count else math.nan
        flow = {doors: steady(curves[model, doors]) / doors if ends[doors] > 0 else math.nan for doors in ends}
        cells = [
            f"{ends[doors]:.0f}" if ends[doors] > 0 else f"{len(curves[model, doors])} of {count} left in {MOST:.0f} s" for doors in (4, 2)
        ]
        cells.append(f"{ends[2] / ends[4]:.2f}" if ends[2] / ends[4] > 0 else "–")
        rows.append((model, *cells, *(f"{flow[doors]:.2f}" if flow[doors] > 0 else "–" for doors in (4, 2))))
    head = ["model", "4 doors [s]", "2 doors [s]", "ratio", "flow per door, 4 doors [1/s]", "2 doors [1/s]"]

    def draw(plt):
        figure, panel = plt.subplots(figsize=(6.2, 3.4), layout="constrained")
        for (model, doors), last in curves.items():
            panel.plot(last, np.arange(1, len(last) + 1), "-" if doors == 4 else "--", color=COLOURS[model], label=f"{model}, {doors} doors")
        panel.set(xlabel="time / s", ylabel="people who have left", xlim=(0, None), ylim=(0, None))
        panel.legend(frameon=False, fontsize="small")
        return figure

    return [markdown(head, rows)], draw


def rimea_12(work, quick=False):
    """Test 12: two rooms, joined by a passage 1 m wide and 5 m long; the second has a door as wide. A jam is before the first only."""
    count = 50 if quick else 150
    lower = [(26, 4.5), (25, 4.5), (25, 0), (15, 0), (15, 4.5), (10, 4.5), (10, 0), (0, 0), (0, 10), (10, 10), (10, 5.5)]
    walls = [lower + [(15, 5.5), (15, 10), (25, 10), (25, 5.5), (26, 5.5)]]
    rows, curves = [], {}
    for model in MODELS:
        trial = work / f"rimea_12_{model}"
        make(trial, walls, count, (0, 0, 5, 10), 1)
        write_decision(trial, model, speeds_of(count, 1), exits=[((27.5, 4), (27.5, 6))])
        table = run(trial, 2 * MOST)
        areas = ["--area=first=8,4,10,6", "--area=second=23,4,25,6"]
        lines = [line("first", (10.5, 4.5), (10.5, 5.5)), line("second", (25.5, 4.5), (25.5, 5.5))]
        summary, tables = measured(trial, table, *lines, *areas)
        passed = {name: own.loc[own["direction"] == "right", "t"].to_numpy() for name, own in tables["gaps"].groupby("line")}
        density = tables["density"]
        curves[model] = density
        row = [model, f"{len(passed['second'])} of {count}"]
        a, b = (np.quantile(passed["first"], share) for share in (0.2, 0.8))
        for name in ("first", "second"):
            own = density[(density["area"] == name) & (density["t"].between(a, b))]
            row += [f"{own['voronoi_density'].mean():.2f}", f"{own['speed'].mean():.2f}", f"{steady(passed[name]):.2f}"]
        rows.append(row)
    head = ["model", "have left", "density before the first [1/m²]", "speed there [m/s]", "flow [1/s]", "density before the second", "speed there", "flow"]

    def draw(plt):
        figure, panels = plt.subplots(1, len(curves), figsize=(3 * len(curves), 2.8), sharey=True, layout="constrained")
        for panel, (model, density) in zip(panels, curves.items()):
            for name, style in (("first", "-"), ("second", "--")):
                own = density[density["area"] == name]
                smooth = own["voronoi_density"].rolling(20, center=True, min_periods=1).mean()
                panel.plot(own["t"], smooth, style, color=COLOURS[model], label=f"before the {name}")
            panel.set(title=model, xlabel="time / s")
            panel.legend(frameon=False, fontsize="small")
        panels[0].set_ylabel("density / m⁻²")
        return figure

    return [markdown(head, rows)], draw


# ---- fundamental diagrams ----


def circle(radius):
    """A closed wall around the origin."""
    corners = [(radius * math.cos(angle), radius * math.sin(angle)) for angle in 2 * math.pi / 72 * np.arange(72)]
    return [*corners, corners[0]]


def course(radius, start, length, points=24, near=0.4):
    """Way-points counter-clockwise on a circle about the origin from an angle, over a length [m] of way, and more."""
    count = int(1.2 * length / (2 * math.pi * radius) * points) + points
    angles = start + 2 * math.pi / points * np.arange(1, count + 1)
    return [(radius * math.cos(angle), radius * math.sin(angle), near) for angle in angles]


def move(trial, poses):
    """Puts people elsewhere: x, y, theta of each, standing."""
    from xml.etree import ElementTree

    path = trial / "dynamic" / "AgentDynamics.xml"
    tree = ElementTree.parse(path)
    for agent in tree.getroot():
        x, y, theta = poses[int(agent.get("Id"))]
        agent.find("Kinematics").attrib.update(Position=f"{x},{y}", Theta=f"{theta}", Velocity="0.0,0.0", Omega="0.0")
    tree.write(path, encoding="utf-8", xml_declaration=True)


def around(frames, window):
    """Mean speed along the circle [m/s] and radius [m] of each person in a window of time, and how often one went back."""
    own = frames[frames["t"].between(*window)]
    radius = np.hypot(own["x"], own["y"])
    tangential = (own["x"] * own["vy"] - own["y"] * own["vx"]) / radius
    return tangential.groupby(own["id"]).mean(), radius.groupby(own["id"]).mean()


SINGLE, NARROW = 17.3, 0.8  # m, length of the course in Seyfried et al. 2005, and its width


def seyfried(speed):
    return 0.36 + 1.06 * speed


def in_single_file(trial, model, count, until):
    """People walk behind each other on a closed circle, at the same desired speed. Returns the mean speed [m/s] and
    spacing [m] of the second half, along the circle on which they really walk."""
    radius = SINGLE / (2 * math.pi)
    # Without walls, people who turn aside do not stay in single file.
    narrow = model == "rotational" or (model == "collision-free-speed" and count > 28)
    walls = [circle(radius + NARROW / 2), circle(radius - NARROW / 2)] if narrow else []
    # Any place is good: they are put elsewhere.
    make(trial, [circle(20)], count, None, 1)
    write_geometry(trial / "static" / "Geometry.xml", walls)
    angles = 2 * math.pi * np.arange(count) / count
    poses = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), angles + math.pi / 2])
    move(trial, poses)
    write_decision(trial, model, SPEED, waypoints=[course(radius, angle, until * SPEED) for angle in angles])
    speed, real = around(frames_of(run(trial, until)), (until / 2, until))
    return speed.mean(), 2 * math.pi * real.mean() / count


def single_file(work, quick=False):
    """Spacing against speed in single file, on a closed circle: all walk behind each other at the same desired speed."""
    rows, points = [], {model: [] for model in MODELS}
    for model in MODELS:
        for count in (16, 28) if quick else (12, 14, 16, 18, 20, 24, 28, 32, 36):
            v, d = in_single_file(work / f"single_{model}_{count}", model, count, 30 if quick else 60)
            points[model].append((v, d))
            rows.append((model, count, f"{d:.3f}", f"{v:.3f}", f"{seyfried(v):.3f}" if 0.1 <= v <= 1 else "–"))
    head = ["model", "people", "spacing d [m]", "speed v [m/s]", "0.36 m + 1.06 s · v [m]"]
    slope, start = np.polyfit(*np.array([(v, d) for v, d in points["collision-free-speed"] if v <= 1]).T, 1)
    fitted = f"A line through our points of collision-free-speed up to 1 m/s: d = {start:.2f} m + {slope:.2f} s · v."

    def draw(plt):
        figure, panel = plt.subplots(figsize=(5.4, 3.6), layout="constrained")
        speed = np.array([0.1, 1.0])
        panel.plot(speed, seyfried(speed), color="black", linewidth=2, label="Seyfried et al. 2005")
        for model, own in points.items():
            own = np.array(own)
            panel.plot(own[:, 0], own[:, 1], "o", markersize=5, color=COLOURS[model], label=model)
        panel.set(xlabel="speed / m/s", ylabel="spacing / m", xlim=(0, 1.5), ylim=(0, 1.6))
        panel.legend(frameon=False, fontsize="small")
        return figure

    return [markdown(head, rows), fitted], draw


def weidmann(density):
    return 1.34 * (1 - np.exp(-1.913 * (1 / density - 1 / 5.4)))


RING = (5.0, 7.0)  # m, walls of the closed corridor


AREA = math.pi * (RING[1] ** 2 - RING[0] ** 2)  # m2


def walk_around(trial, model, count, until, **options):
    """People walk around in the ring, each in the lane of the start. Returns the mean speed of each in the second half [m/s]."""
    poses = make(trial, [circle(RING[1]), circle(RING[0])], count, None, 1, **options)
    lanes = np.clip(np.hypot(poses[:, 0], poses[:, 1]), RING[0] + 0.3, RING[1] - 0.3)
    angles = np.arctan2(poses[:, 1], poses[:, 0])
    ways = [course(lane, angle, until * 1.6, near=1.0) for lane, angle in zip(lanes, angles)]
    write_decision(trial, model, speeds_of(count, 1), waypoints=ways)
    return around(frames_of(run(trial, until)), (until / 2, until))[0]


def corridor(work, quick=False):
    """RiMEA test 4, speed against density in a corridor: here a ring 2 m wide with a fixed number of people."""
    rows, points = [], {model: [] for model in MODELS}
    for model in MODELS:
        for wanted in (1, 3) if quick else (0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4):
            count = round(wanted * AREA)
            speed = walk_around(work / f"corridor_{model}_{wanted}", model, count, 20 if quick else 40)
            back, density = int((speed < -0.05).sum()), count / AREA
            points[model].append((density, speed.mean(), back))
            rows.append((model, count, f"{density:.2f}", f"{speed.mean():.2f}", f"{weidmann(density):.2f}", back))
    head = ["model", "people", "density [1/m²]", "mean speed [m/s]", "Weidmann [m/s]", "walk back"]

    def draw(plt):
        figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
        density = np.linspace(0.05, 5.4, 200)
        for k, panel in enumerate(panels):
            factor = density if k else 1
            panel.plot(density, factor * weidmann(density), color="black", linewidth=2, label="Weidmann 1993")
            for model, own in points.items():
                own = np.array(own)
                panel.plot(own[:, 0], own[:, 1] * (own[:, 0] if k else 1), "o-", linewidth=0.8, markersize=4, color=COLOURS[model], label=model)
            panel.set(xlabel="density / m⁻²", ylabel="specific flow / (m s)⁻¹" if k else "speed / m/s", xlim=(0, 5.5), ylim=(0, None))
        panels[0].legend(frameon=False, fontsize="small")
        return figure

    return [markdown(head, rows)], draw


def breadth(work, quick=False):
    """The corridor with bodies of different breadth: what counts as in front of somebody in the collision-free speed model."""
    rows = []
    for wanted in (1,) if quick else (0.5, 1, 2, 3):
        count = round(wanted * AREA)
        row = [f"{count / AREA:.2f}"]
        for cm in (30, 38, 49):
            speed = walk_around(work / f"breadth_{cm}_{wanted}", "collision-free-speed", count, 20 if quick else 40, fixed=f"{cm},25,1.75,70")
            row.append(f"{speed.mean():.2f}")
        rows.append([*row, f"{weidmann(count / AREA):.2f}"])
    return [markdown(["density [1/m²]", "0.30 m broad [m/s]", "0.38 m", "0.49 m", "Weidmann"], rows)], None


# ---- a room with one way out ----

ROOM = (8.0, 6.0)  # m
PASSAGE = 0.4  # m, its length


def room(width):
    low, high = ROOM[1] / 2 - width / 2, ROOM[1] / 2 + width / 2
    x, end = ROOM[0], ROOM[0] + PASSAGE
    return [[(end, high), (x, high), (x, ROOM[1]), (0, ROOM[1]), (0, 0), (x, 0), (x, low), (end, low)]]


@functools.cache
def leave(work, model, width, count, seed, speed=SPEED, spread=SPREAD, constants="", body=None, damping=None):
    """A crowd leaves the room. Returns when each crossed the middle of the passage [s]: fewer than all if some are stuck.

    Body: the same for all, as for `lemons crowd --fixed`. Damping: of the floor [1/s], else that of the survey's people.
    """
    other = "_other" if constants or body or damping else ""
    trial = work / f"room_{model}_{width}_{count}_{seed}_{speed}{other}"
    x, y = ROOM[0], ROOM[1] / 2
    make(trial, room(width), count, (2, 0, *ROOM), seed, **({"fixed": body} if body else {}))
    if damping:
        agents = trial / "static" / "Agents.xml"
        agents.write_text(re.sub(r'(Floor|Angular)Damping="[^"]*"', rf'\1Damping="{damping}"', agents.read_text()))
    exits = [((x + PASSAGE + 1.5, y - 1.5), (x + PASSAGE + 1.5, y + 1.5))]
    write_decision(trial, model, speeds_of(count, seed, speed, spread), exits=exits, constants=constants)
    across = line("passage", (x + PASSAGE / 2, y - width / 2), (x + PASSAGE / 2, y + width / 2))
    _, tables = measured(trial, run(trial), across)
    gaps = tables["gaps"]
    return np.sort(gaps.loc[gaps["direction"] == "right", "t"].to_numpy())


def bottleneck(work, quick=False):
    """Specific flow through a passage against its width."""
    widths, seeds, count = ([0.9, 1.2], [1], 40) if quick else ([0.8, 0.9, 1.0, 1.2, 1.4, 1.6], range(1, 5), 80)
    flows = {(model, width): [] for model in MODELS for width in widths}
    for (model, width), seed in itertools.product(flows, seeds):
        times = leave(work, model, width, count, seed)
        flows[model, width].append(steady(times) / width if len(times) == count else math.nan)
    rows = [(f"{width}", *(mean_and_spread(flows[model, width]) for model in MODELS)) for width in widths]

    def draw(plt):
        figure, panel = plt.subplots(figsize=(5.8, 3.8), layout="constrained")
        panel.axhspan(1.2, 1.3, color="0.75", linewidth=0, label="Weidmann 1993, SFPE")
        panel.axhspan(1.6, 2.4, color="0.9", linewidth=0, label="experiments: 1.6 to 2.4")
        for k, model in enumerate(MODELS):
            own = [flows[model, width] for width in widths]
            x = np.array(widths) + 0.012 * (k - (len(MODELS) - 1) / 2)
            bars(panel, x, own, model, fmt="o")
        panel.set(xlabel="width / m", ylabel="specific flow / (m s)⁻¹", ylim=(0, None))
        panel.legend(frameon=False, fontsize="small")
        return figure

    return [markdown(["width [m]", *(f"{model} [1/(m s)]" for model in MODELS)], rows)], draw


def why(work, quick=False):
    """What the flow of the collision-free speed model depends on: bodies, how fast they follow their wish, the time gap."""
    widths, seeds, count = ([1.2], [1], 30) if quick else ([1.0, 1.2], range(1, 5), 80)
    circles, quickly = {"body": "40,40,1.75,70"}, {"damping": 50}
    cases = {
        "as it is: bodies of the survey, relaxation time 0.22 s, T = 1 s": {},
        "round bodies, 0.4 m": circles,
        "relaxation time 0.02 s": quickly,
        "round bodies, 0.4 m, and relaxation time 0.02 s": {**circles, **quickly},
        "T = 0.7 s": {"constants": "[collision-free-speed]\ntime_gap = 0.7"},
        "T = 0.5 s": {"constants": "[collision-free-speed]\ntime_gap = 0.5"},
    }
    rows = []
    for name, options in cases.items():
        row = [name]
        for width in widths:
            runs = [leave(work, "collision-free-speed", width, count, seed, **options) for seed in seeds]
            row.append(mean_and_spread(steady(times) / width if len(times) == count else math.nan for times in runs))
        rows.append(row)
    return [markdown(["", *(f"{width} m [1/(m s)]" for width in widths)], rows)], None


def faster(work, quick=False):
    """Evacuation time of a room with one door against desired speed."""
    speeds, seeds, count = ([1.0, 3.0], [1], 30) if quick else ([0.8, 1.2, 1.6, 2.0, 3.0, 4.0], range(1, 5), 80)
    times = {(model, speed): [] for model in MODELS for speed in speeds}
    for (model, speed), seed in itertools.product(times, seeds):
        crossed = leave(work, model, 1.0, count, seed, speed, 0.1 * speed)
        times[model, speed].append(crossed[-1] if len(crossed) == count else math.nan)
    rows = [(speed, *(mean_and_spread(times[model, speed], 1) for model in MODELS)) for speed in speeds]

    def draw(plt):
        figure, panel = plt.subplots(figsize=(5.8, 3.6), layout="constrained")
        for model in MODELS:
            bars(panel, speeds, [times[model, speed] for speed in speeds], model, fmt="o-")
        panel.set(xlabel="desired speed / m/s", ylabel="last of all has crossed / s", xlim=(0, None), ylim=(0, None))
        panel.legend(frameon=False, fontsize="small")
        return figure

    return [markdown(["desired speed [m/s]", *(f"{model} [s]" for model in MODELS)], rows)], draw


# ---- JuPedSim ----


def jupedsim_leave(model, width, count, seed, speed=SPEED, spread=SPREAD, most=MOST):
    """The same room in JuPedSim. Returns when each crossed the middle of the passage [s]."""
    try:
        import jupedsim as jps
        from shapely import Polygon
    except ImportError as error:
        raise SystemExit(f"the figure `peer` needs JuPedSim: pip install jupedsim ({error})") from error

    x, y, end = ROOM[0], ROOM[1] / 2, ROOM[0] + PASSAGE
    low, high = y - width / 2, y + width / 2
    area = [(0, 0), (x, 0), (x, low), (end, low), (end, y - 2), (end + 2, y - 2), (end + 2, y + 2), (end, y + 2), (end, high), (x, high), (x, ROOM[1]), (0, ROOM[1])]
    social = model == "social-force"
    step = 0.01
    simulation = jps.Simulation(model=jps.SocialForceModel() if social else jps.CollisionFreeSpeedModel(), geometry=area, dt=step)
    out = simulation.add_exit_stage([(end + 1.5, y - 2), (end + 2, y - 2), (end + 2, y + 2), (end + 1.5, y + 2)])
    journey = simulation.add_journey(jps.JourneyDescription([out]))
    # Circles of 0.2 m need more room than bodies: here over the whole room.
    places = jps.distributions.distribute_by_number(
        polygon=Polygon([(0, 0), (x, 0), (x, ROOM[1]), (0, ROOM[1])]), number_of_agents=count, distance_to_agents=0.42, distance_to_polygon=0.22, seed=seed
    )
    for place, own in zip(places, speeds_of(count, seed, speed, spread)):
        common = dict(position=place, desired_speed=own, radius=0.2, journey_id=journey, stage_id=out)
        simulation.add_agent(
            jps.SocialForceModelAgentParameters(**common, orientation=(1.0, 0.0)) if social else jps.CollisionFreeSpeedModelAgentParameters(**common)
        )
    crossed, middle = {}, x + PASSAGE / 2
    while simulation.agent_count() > 0 and simulation.elapsed_time() < most:
        simulation.iterate()
        for agent in simulation.agents():
            if agent.id not in crossed and agent.position[0] >= middle:
                crossed[agent.id] = simulation.elapsed_time()
    return np.sort(np.array(list(crossed.values())))


def peer(work, quick=False):
    """The rooms of the figure `bottleneck` in JuPedSim: flow and evacuation time beside ours."""
    widths, seeds, count = ([1.2], [1], 30) if quick else ([0.8, 1.0, 1.2, 1.6], range(1, 5), 80)
    kinds = [("collision-free-speed", False), ("collision-free-speed", True), ("social-force", False), ("social-force", True)]
    found = {}
    for (model, theirs), width, seed in itertools.product(kinds, widths, seeds):
        if theirs:
            times = jupedsim_leave(model, width, count, seed)
        else:
            times = leave(work, model, width, count, seed)
        found.setdefault((model, theirs, width), []).append(times)
    rows = []
    for model, theirs in kinds:
        for width in widths:
            own = found[model, theirs, width]
            flow = [steady(times) / width if len(times) == count else math.nan for times in own]
            last = [times[-1] if len(times) == count else math.nan for times in own]
            rows.append((model, "JuPedSim" if theirs else "ours", width, mean_and_spread(flow), mean_and_spread(last, 1)))
    head = ["model", "by", "width [m]", "specific flow [1/(m s)]", "last has crossed [s]"]

    def draw(plt):
        figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True, layout="constrained")
        for panel, width in zip(panels, (widths[len(widths) // 3], widths[-1])):
            for model, theirs in kinds:
                times = found[model, theirs, width][0]
                panel.plot(times, np.arange(1, len(times) + 1), "--" if theirs else "-", color=COLOURS[model], label=f"{model}, {'JuPedSim' if theirs else 'ours'}")
            panel.set(title=f"passage of {width} m", xlabel="time / s", xlim=(0, None), ylim=(0, None))
        panels[0].set_ylabel("people who have crossed")
        panels[0].legend(frameon=False, fontsize="small")
        return figure

    return [markdown(head, rows)], draw


FIGURES = {
    "rimea_1": rimea_1,
    "rimea_6": rimea_6,
    "rimea_9": rimea_9,
    "rimea_12": rimea_12,
    "single_file": single_file,
    "corridor": corridor,
    "breadth": breadth,
    "bottleneck": bottleneck,
    "why": why,
    "faster": faster,
    "peer": peer,
}


def put_into_page(name, tables):
    """Replaces what is between the two marks of a figure in docs/validation.md."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, _, rest = PAGE.read_text().partition(begin)
    _, _, after = rest.partition(end)
    if not after:
        raise SystemExit(f"{PAGE}: there is no {begin} … {end}")
    PAGE.write_text(f"{before}{begin}\n\n" + "\n\n".join(tables) + f"\n\n{end}{after}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figure", nargs="*", metavar="FIGURE", help=f"one or more of: {', '.join(FIGURES)}")
    parser.add_argument("--all", action="store_true", help="all figures")
    parser.add_argument("--quick", action="store_true", help="fewer and smaller cases")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/validation.md, and the pictures beside it")
    parser.add_argument("--pictures", type=Path, default=Path(), metavar="DIR", help="where pictures go: validation_FIGURE.svg; default: here")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep Trials and runs in this directory")
    arguments = parser.parse_args()
    names = list(FIGURES) if arguments.all else arguments.figure
    if not names:
        parser.error("name a figure, or give --all")
    for unknown in set(names) - FIGURES.keys():
        parser.error(f"there is no figure {unknown!r}; there are {', '.join(FIGURES)}")
    if arguments.write and arguments.quick:
        parser.error("--quick gives no numbers for the page")
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "validation", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    from matplotlib import pyplot as plt

    with tempfile.TemporaryDirectory() as scratch:
        work = arguments.keep or Path(scratch)
        for name in names:
            began = time.monotonic()
            tables, draw = FIGURES[name](work, arguments.quick)
            print(f"{name}: {inspect.getdoc(FIGURES[name])}\n")
            print("\n\n".join(tables), "\n", flush=True)
            if arguments.write:
                put_into_page(name, tables)
            if draw:
                figure = draw(plt)
                path = (PAGE.parent if arguments.write else arguments.pictures) / f"validation_{name}.svg"
                figure.savefig(path, metadata={"Date": None})
                plt.close(figure)
                print(path)
            print(f"{time.monotonic() - began:.0f} s\n", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
