"""Walking models beside measured trajectories: gate, exits, corridors, two directions, single file.

    pip install ./python pedpy jupedsim
    python examples/experiments.py --data DIR                        # all rows, ten seeds, the model of `lemons crowd --leave`
    python examples/experiments.py exits --model rotational --model jupedsim-v3 --peers 3
    python examples/experiments.py gate --constants '[collision-free-speed]
    time_gap = 0.5'
    python examples/experiments.py measured                          # the measured side alone

DIR (or LEMONS_WALK_DATA) has the trajectories as their authors published them, as text or compressed (.gz): `adrian/` (Adrian et
al. 2020, DOI 10.34735/ped.2018.1), `hermes_uo/` and `hermes_bi/` (HERMES 2009, DOI 10.34735/ped.2009.14), `single/` (CroMa 2021;
Seyfried et al. 2005). `experiments.sha256` has their names and hashes; files with other contents are named in a warning.
Without DIR nothing is compared, and the command ends well.

What is measured, by PedPy with the same functions for the experiment and for us, at the frame rate of the experiment:

- flow: between a fifth and four fifths of the passages of a line. Last: at the gate from the start on, at exits after the first.
- density and speed: Voronoi, twice a second; speeds over ±1 s. Upstream of exits: the middle 2 m of the corridor.
- v(density): the middle 4 m of the corridor, all frames, classes of 0.25 /m². J(density): density times speed, the middle 3 m.
- single file: the way along the ring is unrolled; speeds over ±0.4 s. Stopped: slower than 0.05 m/s. Overtaking: somebody whose
  predecessor on the ring falls behind.

Where people start. Gate: where the measured people were in the first frame. Corridors: the camera sees nobody before the entrance,
so all stand behind it, in the waiting area 5 m wide, on a hexagonal grid of 3 people per m², each up to 0.04 m off it, the nearest
0.4 m from the wall; the entrance is E wide (100, 145 and 180-300-300: two openings of E/2 with 0.6 m between, as the places of the
first passages show; 070: one), and the floor before the corridor 1.5 m wider on both sides. Two directions: such a waiting area
at both ends, as many people as measured in each; each leaves to the side to which the measured one left. Single file: a
circle 0.8 m wide whose length is N times the mean measured headway (1/density), people at equal distances, each up to a tenth of it off.
Who would overlap is moved apart. Bodies are drawn from the survey (`--body` makes all of them alike), desired speeds from
N(1.34, 0.26²) m/s, those of Seyfried et al. from N(1.24, 0.15²) m/s, cut at two standard deviations.

Tune on the runs of TUNE only. Those of JUDGE were named before anything was tuned; they are for judging.
"""

import argparse
import functools
import gzip
import hashlib
import math
import os
import sys
import tempfile
import time
import warnings
import zlib
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

FREE = (1.34, 0.26)  # m/s, desired speeds: mean and standard deviation (Weidmann 1993)
FREE_UX = (1.24, 0.15)  # m/s, of the people of Seyfried et al. 2005
FREE_HERMES = (1.55, 0.18)  # m/s, measured of the people of the corridors (Zhang et al. 2011)
OURS = ["rotational", "collision-free-speed", "social-force", "straight"]
PAGE = Path(__file__).resolve().parents[1] / "docs" / "validation.md"
THEIRS = {"v2": "CollisionFreeSpeedModelV2", "v3": "CollisionFreeSpeedModelV3", "avm": "AnticipationVelocityModel"}
GATE = "040_c_56_h-"
TUNE = [
    *(GATE, "uo-180-180-070", "uo-180-180-120", "uo-240-240-160", "uo-070-180-180", "uo-145-180-180"),
    *("bot-360-090-090", "boa-300-065-105", "bot-360-075-075", "croma-16", "croma-20", "croma-32", "croma-36", "ux-15", "ux-25"),
]
JUDGE = [
    *("uo-180-180-095", "uo-180-180-180", "uo-100-180-180", "uo-180-300-300", "uo-300-300-300"),
    *("bo-360-090-090", "bot-360-120-120", "croma-24", "ux-20", "ux-30"),
]
RUNS = TUNE + JUDGE
EXITS = ["uo-180-180-070", "uo-180-180-095", "uo-180-180-120", "uo-180-180-180", "uo-240-240-160"]
CORRIDORS = ["uo-070-180-180", "uo-145-180-180", "uo-100-180-180", "uo-180-300-300", "uo-300-300-300"]
STALL = 45.0  # s in which nobody leaves: then nobody does any more


@dataclass(frozen=True)
class Walk:
    """Who walks, and how: a model of ours or of JuPedSim, its constants (TOML), bodies (breadth, depth [m]; None: the survey's),
    and the friction between people (None: that of `lemons crowd`)."""

    model: str
    constants: str = ""
    body: tuple | None = None
    friction: float | None = None


@dataclass(frozen=True)
class Scene:
    """An experiment: frames per second, the walkable polygon, the line that counts, and what is drawn from the measured side."""

    fps: int
    area: object
    line: tuple = ()
    exits: dict = field(default_factory=dict)  # name: rectangle x, y, x, y
    start: object = None  # function of a random generator: places (N, 2), gazes (N,), names of exits
    recorded: object = None  # measured trajectories
    measure: object = None  # function of scene and trajectories
    most: float = 200.0  # s
    ring: float = 0.0  # m, length of the way around
    free: tuple = FREE  # m/s, mean and spread of desired speeds


# ---- experiments ----


def directory(given=None):
    """Where the data are, or None."""
    found = Path(given or os.environ.get("LEMONS_WALK_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data" / "walk")
    return found if (found / "hermes_uo").is_dir() else None


def file_of(data, name):
    """The file of a name, as text or compressed."""
    path = data / f"{name}.gz"
    return path if path.is_file() else data / name


def text_of(path):
    data = path.read_bytes()
    return gzip.decompress(data) if path.suffix == ".gz" else data


def differing(data):
    """Names of the files that are missing, and of those whose text is another than that which was compared for docs/validation.md."""
    missing, other = [], []
    for line in Path(__file__).with_suffix(".sha256").read_text().splitlines():
        digest, name = line.split("  ")
        path = file_of(data, name)
        if not path.is_file():
            missing.append(name)
            continue
        try:
            text = text_of(path)
        except (OSError, EOFError, zlib.error):
            text = b""
        if hashlib.sha256(text).hexdigest() != digest:
            other.append(name)
    return missing, other


def recorded(path, fps, scale=1.0):
    import pedpy

    table = pd.read_csv(path, sep=r"\s+", comment="#", header=None, names=["id", "frame", "x", "y", "z"])
    table[["x", "y"]] *= scale
    table["frame"] -= table["frame"].min()
    return pedpy.TrajectoryData(table[["id", "frame", "x", "y"]], frame_rate=fps)


@functools.cache
def scene_of(name, data):
    kind = name.split("-")[0]
    build = {"040_c_56_h": gate_scene, "uo": corridor_scene, "croma": ring_scene, "ux": ring_scene}.get(kind, counterflow_scene)
    return build(name, Path(data))


def gate_scene(name, data):
    from shapely import Polygon

    traces = recorded(file_of(data, f"adrian/{name}.txt"), 25)
    side = [(2.8, 6.7), (2.8, 0), (0.4, 0), (0.25, -0.15), (0.25, -1.1), (2.8, -1.1), (2.8, -4)]
    first = traces.data[traces.data["frame"] == 0][["x", "y"]].to_numpy()
    return Scene(
        fps=25,
        area=Polygon([*side, *((-x, y) for x, y in reversed(side))]),
        line=((-0.6, 0.0), (0.6, 0.0)),
        exits={"out": (-2.7, -3.9, 2.7, -2.5)},
        start=lambda random: (first, np.full(len(first), -math.pi / 2), ["out"] * len(first)),
        recorded=traces,
        measure=measure_gate,
    )


def waiting(number, middle, end, up, random):
    """Places of people who wait behind an entrance whose wall ends at y = `end`: 5 m wide, 3 per m²; the nearest come first."""
    pitch = math.sqrt(2 / (3 * math.sqrt(3)))
    rows, columns = int(number / 4) + 4, int(2.2 / pitch)
    places = [
        (middle + (i + 0.5 * (k % 2)) * pitch, end + 0.4 + k * pitch * math.sqrt(3) / 2) for k in range(rows) for i in range(-columns, columns + 1)
    ]
    places = np.array(sorted(places, key=lambda place: math.hypot(place[0] - middle, place[1] - end))[:number])
    places += random.uniform(-0.04, 0.04, places.shape)
    return places * (1, -1) if up else places


def entrance(middle, width, double, y0, y1):
    """Openings in a wall from y0 to y1."""
    from shapely import box

    centres = [(middle - width / 4 - 0.3, width / 4), (middle + width / 4 + 0.3, width / 4)] if double else [(middle, width / 2)]
    return [box(x - half, y0, x + half, y1) for x, half in centres]


def corridor_scene(name, data):
    from shapely import box, unary_union

    gap, wide, out = (int(word) / 100 for word in name.split("-")[1:])
    traces = recorded(file_of(data, f"hermes_uo/{name}.txt"), 16, 0.01)
    number, middle = traces.data["id"].nunique(), wide / 2
    parts = [box(0, -4, wide, 4), box(-1.5, 4, wide + 1.5, 8), box(middle - 2.5, 9, middle + 2.5, 10.5 + number / 12)]
    parts += [box(middle - out / 2, -4.1, middle + out / 2, -4), box(-1.5, -8, wide + 1.5, -4.1)]
    parts += entrance(middle, gap, name in ("uo-100-180-180", "uo-145-180-180", "uo-180-300-300"), 8, 9)
    return Scene(
        fps=16,
        area=unary_union(parts),
        line=((middle - out / 2, -4.0), (middle + out / 2, -4.0)),
        exits={"out": (-1.4, -7.9, wide + 1.4, -6.5)},
        start=lambda random: (waiting(number, middle, 9, False, random), np.full(number, -math.pi / 2), ["out"] * number),
        recorded=traces,
        measure=functools.partial(measure_corridor, wide=wide, out=out),
        most=300.0,
        free=FREE_HERMES,
    )


def counterflow_scene(name, data):
    from shapely import box, unary_union

    wide, upper, lower = (int(word) / 100 for word in name.split("-")[1:])
    traces = recorded(file_of(data, f"hermes_bi/{name}.txt"), 16, 0.01)
    ends = traces.data.sort_values("frame").groupby("id")[["x", "y"]].agg(["first", "last"])
    middle, up = wide / 2, (ends["y", "first"] < 0).to_numpy()
    side = np.where(ends["x", "last"] < middle, "left", "right")
    # As they came: the first to appear stands nearest to the entrance.
    order = np.argsort(traces.data.groupby("id")["frame"].min().to_numpy(), kind="stable")
    up, side = up[order], side[order]
    parts = [box(0, -4, wide, 4)]
    for sign, gap in ((1, upper), (-1, lower)):
        y = lambda a, b: sorted((sign * a, sign * b))  # noqa: E731
        for x0, (y0, y1), x1 in [(-3, y(4, 8), wide + 3), (middle - 2.5, y(9, 10.5 + len(up) / 24), middle + 2.5)]:
            parts.append(box(x0, y0, x1, y1))
        parts += entrance(middle, gap, False, *y(8, 9))
    exits = {}
    for end, y0, y1 in (("upper", 4.2, 7.8), ("lower", -7.8, -4.2)):
        exits |= {f"{end} left": (-2.9, y0, -2, y1), f"{end} right": (wide + 2, y0, wide + 2.9, y1)}

    def start(random):
        places = np.zeros((len(up), 2))
        for part, below in ((up, True), (~up, False)):
            places[part] = waiting(part.sum(), middle, 9, below, random)
        return places, np.where(up, math.pi / 2, -math.pi / 2), [f"{'upper' if a else 'lower'} {b}" for a, b in zip(up, side)]

    return Scene(
        fps=16,
        area=unary_union(parts),
        line=((0.0, 0.0), (wide, 0.0)),
        exits=exits,
        start=start,
        recorded=traces,
        measure=functools.partial(measure_counterflow, wide=wide),
        free=FREE_HERMES,
    )


def ring_scene(name, data):
    from shapely import Point

    series, number = name.split("-")[0], int(name.split("-")[1])
    pattern = f"croma_female_{number}_*" if series == "croma" else f"rho_v_UX_{number}_*"
    path = min((data / "single").glob(pattern))  # as text, if it is there both ways
    density, speed = np.loadtxt(path).T
    length = number * float(np.mean(1 / density))
    radius = length / (2 * math.pi)

    def start(random):
        angles = 2 * math.pi / number * (np.arange(number) + random.uniform(-0.1, 0.1, number))
        return radius * np.column_stack([np.cos(angles), np.sin(angles)]), angles + math.pi / 2, None

    return Scene(
        fps=25,
        area=Point(0, 0).buffer(radius + 0.4, 24).difference(Point(0, 0).buffer(radius - 0.4, 24)),
        start=start,
        recorded=(density, speed),
        measure=measure_ring,
        most=80.0,
        ring=length,
        free=FREE if series == "croma" else FREE_UX,
    )


# ---- runs ----


def speeds_of(scene, count, random):
    mean, spread = scene.free
    drawn = random.standard_normal(20 * count + 100)
    return mean + spread * drawn[np.abs(drawn) <= 2][:count]


def apart(places, gazes, shapes, area):
    """Moves people until their disks (x, y, radius; the gaze along x) do not overlap, and do not touch a wall."""
    from shapely import Point
    from shapely.ops import nearest_points

    owner = np.repeat(np.arange(len(shapes)), [len(shape) for shape in shapes])
    disks, places = np.concatenate(shapes), places.copy()
    cos, sin = np.cos(gazes)[owner], np.sin(gazes)[owner]
    offset = np.column_stack([disks[:, 0] * cos - disks[:, 1] * sin, disks[:, 0] * sin + disks[:, 1] * cos])
    reach = np.array([max(math.hypot(x, y) + r for x, y, r in shape) for shape in shapes])
    inner = area.buffer(-float(reach.max()) - 0.005)
    for _ in range(500):
        for i, place in enumerate(places):
            if not inner.contains(Point(place)):
                places[i] = np.array(nearest_points(inner, Point(place))[0].coords[0])
        at = places[owner] + offset
        away = at[:, None] - at
        distance = np.hypot(away[..., 0], away[..., 1])
        deep = disks[:, 2, None] + disks[:, 2] + 0.002 - distance
        deep[owner[:, None] == owner] = -1
        i, j = np.nonzero(deep > 0)
        if not len(i):
            return places
        normal = away[i, j] / np.maximum(distance[i, j], 1e-9)[:, None]
        np.add.at(places, owner[i], 0.3 * (deep[i, j] + 0.001)[:, None] * normal)
    return places


def course(scene, angle, points=24):
    """Way-points of somebody on the ring."""
    radius = scene.ring / (2 * math.pi)
    count = int(scene.most * (scene.free[0] + 2 * scene.free[1]) / scene.ring * points) + points
    return [(radius * math.cos(angle + 2 * math.pi / points * k), radius * math.sin(angle + 2 * math.pi / points * k)) for k in range(1, count)]


def write_trial(trial, scene, walk, seed):
    """Writes a Trial of people of the survey in an experiment. Their measures are those of `lemons crowd`."""
    import lemons_fmu

    random = np.random.default_rng(seed)
    places, gazes, exits = scene.start(random)
    fixed = {} if walk.body is None else {"fixed": [100 * walk.body[0], 100 * walk.body[1], 1.7, 70]}
    people = lemons_fmu.crowd(
        number=len(places), seed=seed, packing="grid", orientation="fixed", time_step=communication(scene)[0], output=trial, **fixed
    )
    places = apart(places, gazes, people.shapes, scene.area)
    rings = [scene.area.exterior, *scene.area.interiors]
    walls = ["".join(f'<Corner Coordinates="{x:.6f},{y:.6f}"/>' for x, y in ring.coords) for ring in rings]
    text = "".join(f'<Wall Id="{k}" MaterialId="concrete">{corners}</Wall>\n' for k, corners in enumerate(walls))
    (trial / "static" / "Geometry.xml").write_text(f"<Geometry>\n{text}</Geometry>\n")
    text = "".join(
        f'<Agent Id="{i}"><Kinematics Position="{x:.6f},{y:.6f}" Velocity="0,0" Theta="{gaze:.6f}" Omega="0"/><Dynamics Fp="0,0" Mp="0"/></Agent>\n'
        for i, ((x, y), gaze) in enumerate(zip(places, gazes))
    )
    (trial / "dynamic" / "AgentDynamics.xml").write_text(f"<Agents>\n{text}</Agents>\n")
    lines = [f'model = "{walk.model}"', f"seed = {seed}"]
    if scene.exits:
        areas = {name: [[a, b], [c, b], [c, d], [a, d]] for name, (a, b, c, d) in scene.exits.items()}
        lines += ["exits = [", *(f'  {{ name = "{name}", polygon = {area} }},' for name, area in areas.items()), "]"]
    lines.append(walk.constants)
    for i, (place, speed) in enumerate(zip(places, speeds_of(scene, len(places), random))):
        lines += [f"[agents.{i}]", f"desired_speed = {speed:.4f}"]
        if exits:
            lines.append(f'exit = "{exits[i]}"')
        else:
            points = course(scene, math.atan2(place[1], place[0]))
            lines.append("waypoints = [" + ", ".join(f"{{ x = {x:.4f}, y = {y:.4f}, radius = 0.4 }}" for x, y in points) + "]")
    (trial / "decision.toml").write_text("\n".join([*lines, ""]))


def communication(scene, about=0.02):
    """A communication step near 0.02 s, and how many of them are a frame."""
    count = round(1 / scene.fps / about)
    return 1 / scene.fps / count, count


def ours(scene, walk, seed):
    """Yields places and ids of who is there at each frame of a run with our mechanics."""
    import lemons_fmu

    step, count = communication(scene)
    friction = {} if walk.friction is None else {"contact.human_naked.human_naked.KineticFriction": walk.friction}
    with tempfile.TemporaryDirectory() as scratch:
        write_trial(Path(scratch) / "trial", scene, walk, seed)
        with lemons_fmu.Crowd(Path(scratch) / "trial", friction) as crowd:
            done, everybody = 0, np.arange(len(crowd))
            while True:
                there = np.asarray(crowd.active)
                yield everybody[there], crowd.poses()[there, :2]
                for _ in range(count):
                    done += 1
                    crowd.step_to(done * step)


def theirs(scene, walk, seed):
    """Yields places and ids of who is there at each frame of a run of JuPedSim."""
    import jupedsim

    kind = THEIRS[walk.model.removeprefix("jupedsim-")]
    random = np.random.default_rng(seed)
    constants = {"radius": 0.15}  # with their default of 0.2 m, they do not get through the gate, and 36 do not fit on the ring
    if walk.constants:
        import tomllib

        constants |= tomllib.loads(walk.constants)
    places, gazes, exits = scene.start(random)
    places = apart(places, gazes, [np.array([(0, 0, constants["radius"] + 0.005)])] * len(places), scene.area)
    step, count = communication(scene, 0.01)
    simulation = jupedsim.Simulation(model=getattr(jupedsim, kind)(), geometry=scene.area, dt=step)
    if scene.ring:
        radius, points = scene.ring / (2 * math.pi), 24
        stages = [simulation.add_waypoint_stage((radius * math.cos(a), radius * math.sin(a)), 0.4) for a in np.arange(points) * 2 * math.pi / points]
        journey = jupedsim.JourneyDescription(stages)
        for k, stage in enumerate(stages):
            journey.set_transition_for_stage(stage, jupedsim.Transition.create_fixed_transition(stages[(k + 1) % points]))
        journeys = [(simulation.add_journey(journey), stage) for stage in stages]
        chosen = [journeys[int(math.atan2(y, x) / (2 * math.pi) * points + 1.5) % points] for x, y in places]
    else:
        stages = {name: simulation.add_exit_stage([(a, b), (c, b), (c, d), (a, d)]) for name, (a, b, c, d) in scene.exits.items()}
        journeys = {name: (simulation.add_journey(jupedsim.JourneyDescription([stage])), stage) for name, stage in stages.items()}
        chosen = [journeys[name] for name in exits]
    person, ids = getattr(jupedsim, f"{kind}AgentParameters"), {}
    for i, (place, speed, (journey, stage)) in enumerate(zip(places, speeds_of(scene, len(places), random), chosen)):
        ids[simulation.add_agent(person(position=tuple(place), desired_speed=speed, journey_id=journey, stage_id=stage, **constants))] = i
    while True:
        agents = sorted((ids[agent.id], *agent.position) for agent in simulation.agents())
        yield np.array([i for i, *_ in agents], int), np.array([place for _, *place in agents]).reshape(-1, 2)
        simulation.iterate(count)


def simulated(scene, walk, seed, most=None):
    """Trajectories of a run: until all have left, nobody leaves for STALL, or at most this long."""
    import pedpy

    frames, fewest, since = [], math.inf, 0
    for frame, (ids, places) in enumerate((theirs if walk.model.startswith("jupedsim-") else ours)(scene, walk, seed)):
        frames.append(np.column_stack([ids, np.full(len(ids), frame), places]))
        if len(ids) < fewest:
            fewest, since = len(ids), frame
        stalled = scene.exits and frame - max(since, 15 * scene.fps) > STALL * scene.fps
        if not len(ids) or stalled or frame >= (most or scene.most) * scene.fps:
            break
    table = pd.DataFrame(np.concatenate(frames), columns=["id", "frame", "x", "y"]).astype({"id": int, "frame": int})
    return pedpy.TrajectoryData(table, frame_rate=scene.fps)


# ---- measures ----


def passages(traces, line):
    """When people crossed a line for the first time [s], sorted."""
    import pedpy

    _, crossings = pedpy.compute_n_t(traj_data=traces, measurement_line=pedpy.MeasurementLine(line))
    return np.sort(crossings["frame"].to_numpy()) / traces.frame_rate


def steady(times, number):
    """Flow [1/s] between a fifth and four fifths of the passages of so many people, and when that is [s]. Without them: 0."""
    a, b = (round(part * (number - 1)) for part in (0.2, 0.8))
    if len(times) <= b:
        return 0.0, (times[a] if len(times) > a else math.inf, times[-1] if len(times) else 0.0)
    return (b - a) / (times[b] - times[a]), (times[a], times[b])


def voronoi(traces, area, *parts):
    """Of each part (a rectangle, frames): density [1/m²] and speed [m/s] in those of the frames in which somebody is there. Cells are
    made of the people of the part's surroundings: who waits behind an entrance is not among them."""
    import pedpy

    wanted = sorted(set().union(*(frames for _, frames in parts)) & set(traces.data["frame"]))
    near = traces.data["y"].abs() < 6
    chosen = pedpy.TrajectoryData(traces.data[traces.data["frame"].isin(wanted) & near], frame_rate=traces.frame_rate)
    if not len(chosen.data):
        return [np.zeros((0, 2))] * len(parts)
    cells = pedpy.compute_individual_voronoi_polygons(traj_data=chosen, walkable_area=pedpy.WalkableArea(area))
    own, found = speeds_over(traces, 1.0), []
    for part, frames in parts:
        part = pedpy.MeasurementArea(part)
        density, cut = pedpy.compute_voronoi_density(individual_voronoi_data=cells, measurement_area=part)
        speed = pedpy.compute_voronoi_speed(traj_data=chosen, individual_voronoi_intersection=cut, individual_speed=own, measurement_area=part)
        tables = [table.reset_index().set_index("frame")[name] for table, name in ((density, "density"), (speed, "speed"))]
        both = pd.concat(tables, axis=1).reindex(sorted(set(frames) & set(wanted)))
        found.append(both[both["density"] > 0].to_numpy())
    return found


def speeds_over(traces, seconds):
    """Speeds of people over ± so many seconds."""
    import pedpy

    way = pedpy.SpeedCalculation.BORDER_SINGLE_SIDED
    return pedpy.compute_individual_speed(traj_data=traces, frame_step=round(seconds * traces.frame_rate), speed_calculation=way)


def mean(values):
    return float(np.nanmean(values)) if len(values) else math.nan


def every(traces, window=(0.0, math.inf)):
    """Frames twice a second, within a time."""
    last = min(window[1] * traces.frame_rate, traces.data["frame"].max())
    return range(int(min(window[0] * traces.frame_rate, last)), int(last) + 1, round(traces.frame_rate / 2))


def measure_gate(scene, traces):
    from shapely import box

    number, times = traces.data["id"].nunique(), passages(traces, scene.line)
    flow, window = steady(times, number)
    frames = every(traces, window)
    (ahead,) = voronoi(traces, scene.area, (box(-0.4, 0.5, 0.4, 1.3), frames))
    nearest = []
    for _, own in traces.data[traces.data["frame"].isin(frames)].groupby("frame"):
        places = own[["x", "y"]].to_numpy()
        distance = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) + np.diag(np.full(len(places), math.inf))
        before = (places[:, 1] > 0) & (np.hypot(*places.T) < 1.5)
        nearest += list(distance[before].min(axis=1)) if len(places) > 1 else []
    gaps = np.diff(times) if len(times) == number else np.array([math.inf])
    return {
        **{"flow": flow, "specific": flow / 0.5, "last": times[-1] if len(times) == number else math.inf, "density": mean(ahead[:, 0])},
        **{"speed": mean(ahead[:, 1]), "nearest": mean(nearest), "gap 95 %": np.quantile(gaps, 0.95, method="inverted_cdf"), "greatest gap": gaps.max(), "times": times},
    }


def measure_corridor(scene, traces, wide, out):
    from shapely import box

    number, times = traces.data["id"].nunique(), passages(traces, scene.line)
    flow, window = steady(times, number)
    upstream, points = voronoi(traces, scene.area, (box(0, -1, wide, 1), every(traces, window)), (box(0, -2, wide, 2), every(traces)))
    through = steady(passages(traces, ((0, 0), (wide, 0))), number)[0]
    return {
        **{"specific": flow / out, "last": times[-1] - times[0] if len(times) == number else math.inf, "times": times},
        **{"density": mean(upstream[:, 0]), "speed": mean(upstream[:, 1]), "capacity": through / wide, "points": points},
    }


def measure_counterflow(scene, traces, wide):
    from shapely import box

    (points,) = voronoi(traces, scene.area, (box(0, -1.5, wide, 1.5), every(traces)))
    # Not by passages of the middle: PedPy misses somebody who is on the line to within some micrometres in a frame.
    ends = traces.data.sort_values("frame").groupby("id")["y"].agg(["first", "last"])
    return {
        "points": points * np.column_stack([np.ones(len(points)), points[:, 0]]),
        "stuck": float((ends["first"] * ends["last"] > 0).any()),
    }


def measure_ring(scene, traces):
    """Of the measured people there are pairs of density and speed only."""
    import pedpy

    if isinstance(traces, tuple):
        density, speed = traces
        found = {"headway": float(np.mean(1 / density)), "overtakings": 0.0}
    else:
        radius, last = scene.ring / (2 * math.pi), traces.data["frame"].max()
        table = traces.data.sort_values(["id", "frame"])
        number = table["id"].nunique()
        angles = np.unwrap(np.arctan2(table["y"], table["x"]).to_numpy().reshape(number, -1), axis=1)
        order = np.argsort(angles[:, 0])
        ahead = np.roll(angles[order], -1, axis=0) - angles[order]
        ahead -= 2 * math.pi * np.floor(ahead[:, :1] / (2 * math.pi))
        flat = pd.DataFrame({"id": table["id"], "frame": table["frame"], "x": radius * angles.ravel(), "y": 0.0})
        own = speeds_over(pedpy.TrajectoryData(flat, frame_rate=scene.fps), 0.4)
        speed = own[own["frame"] > last / 4]["speed"].to_numpy()
        found = {"headway": scene.ring / number, "overtakings": float((ahead.min(axis=1) < 0).sum())}
    return {**found, "speed": float(speed.mean()), "spread": float(speed.std()), "stopped": float((speed < 0.05).mean())}


def work(task):
    """What is measured of a run: (name, data, walk or None for the experiment, seed, most)."""
    name, data, walk, seed, most = task
    warnings.filterwarnings("ignore")
    scene = scene_of(name, data)
    return scene.measure(scene, scene.recorded if walk is None else simulated(scene, walk, seed, most))


KEPT = {}


def collect(names, walk, seeds, data, most=None, processes=2):
    """Measures of experiments (key: name) and of our runs (key: name, a list of one for each seed)."""
    tasks = [(name, str(data), None, 0, None) for name in names] + [(name, str(data), walk, seed, most) for name in names for seed in range(1, seeds + 1)]
    new = [task for task in tasks if task not in KEPT]
    # Long ones first.
    new.sort(key=lambda task: (task[2] is None, task[0] not in CORRIDORS[-1:]))
    if processes > 1 and len(new) > 1:
        with ProcessPoolExecutor(processes) as pool:
            KEPT.update(zip(new, pool.map(work, new)))
    else:
        KEPT.update((task, work(task)) for task in new)
    return {task[0]: KEPT[task] for task in tasks if task[2] is None}, {name: [KEPT[task] for task in tasks if task[0] == name and task[2]] for name in names}


# ---- rows ----


@dataclass(frozen=True)
class Row:
    """A number, measured and ours: the median of the seeds, and between which values 80 % of them are."""

    row: str
    what: str
    set: str
    measured: float
    ours: float
    low: float
    high: float
    limit: str
    passed: bool

    def cells(self):
        say = lambda value: "–" if math.isnan(value) else "never" if math.isinf(value) else f"{value:.3g}"  # noqa: E731
        between = f"{say(self.low)} to {say(self.high)}"
        return [self.row, self.what, self.set, say(self.measured), say(self.ours), between, self.limit, "pass" if self.passed else "**fails**"]


HEAD = ["row", "number", "set", "measured", "ours", "10 % to 90 %", "limit", ""]


def compare(row, what, of, measured, values, share=None, amount=None, at_most=None, at_least=None, factor=None, least=0.0):
    """Compares the median of values: within a share, an amount or a factor of what was measured, or at most (at least) a value."""
    values = np.sort(np.asarray([math.nan if value is None else value for value in values], float))
    median, low, high = (np.quantile(values, part, method="inverted_cdf") for part in (0.5, 0.1, 0.9))
    if share is not None:
        limit, passed = f"±{100 * share:.0f} %", abs(median - measured) <= share * abs(measured)
    elif amount is not None:
        limit, passed = f"±{amount:g}", abs(median - measured) <= amount
    elif factor is not None:
        a, b = max(median, least), max(measured, least)
        limit, passed = f"factor {factor:g}", b / factor <= a <= b * factor
    elif at_least is not None:
        limit, passed = f"≥ {at_least:.3g}", median >= at_least
    else:
        limit, passed = f"≤ {at_most:.3g}", median <= at_most
    return Row(row, what, of, measured, float(median), float(low), float(high), limit, bool(passed))


def set_of(name):
    return "tune" if name in TUNE else "judge"


def setting(model, constants="", seeds=10, body=None, friction=None, data=None, quick=False, processes=2):
    """What all rows take: model and constants, seeds, bodies, friction; `quick` ends runs after 40 s and takes few of them."""
    return dict(walk=Walk(model, constants, body, friction), seeds=1 if quick else seeds, data=directory(data), most=40.0 if quick else None, processes=processes)


def gate(model, constants="", seeds=10, **others):
    """The gate of 0.5 m: N(t), density, distances, stalls."""
    measured, ours = collect([GATE], **setting(model, constants, seeds, **others))
    measured, ours = measured[GATE], ours[GATE]
    one = lambda what, name, **limit: compare("gate", what, "tune", measured[name], [each[name] for each in ours], **limit)  # noqa: E731
    return [
        one("slope of N(t) [1/s]", "flow", share=0.15),
        one("last [s]", "last", share=0.15),
        one("density 0.5 to 1.3 m ahead [1/m²]", "density", share=0.15),
        one("nearest neighbour [m]", "nearest", amount=0.04),
        one("time gap, 95 % [s]", "gap 95 %", at_most=2 * measured["gap 95 %"]),
        one("greatest time gap [s]", "greatest gap", at_most=2 * measured["greatest gap"]),
    ]


def exits(model, constants="", seeds=10, quick=False, **others):
    """Exits of corridors: specific flow, density upstream."""
    names = EXITS[:1] if quick else EXITS
    measured, ours = collect(names, **setting(model, constants, seeds, quick=quick, **others))
    rows, bias = [], {}
    for name in names:
        flows = [each["specific"] for each in ours[name]]
        rows.append(compare("exits", f"{name}: J/b [1/(m s)]", set_of(name), measured[name]["specific"], flows, share=0.15))
        rows.append(compare("exits", f"{name}: density [1/m²]", set_of(name), measured[name]["density"], [each["density"] for each in ours[name]], share=0.2))
        for part in (set_of(name), "both"):
            bias.setdefault(part, []).append(np.array(flows) / measured[name]["specific"])
    return rows + [compare("exits", "mean of J/b, ours to measured", part, 1.0, np.mean(of, axis=0), share=0.07) for part, of in bias.items()]


def classes(points, width, least):
    """Means of the second column in classes of the first one, of those with so many points: {lower end: mean}."""
    of = np.floor(points[:, 0] / width) * width
    return {float(low): float(points[of == low, 1].mean()) for low in np.unique(of) if (of == low).sum() >= least}


def pooled(found, names, seed=None):
    return np.concatenate([(found[name] if seed is None else found[name][seed])["points"] for name in names])


def corridor(model, constants="", seeds=10, quick=False, **others):
    """Corridors in one direction: speed against density, and the most that gets through."""
    sets = {"tune": CORRIDORS[:1]} if quick else {part: [name for name in CORRIDORS if set_of(name) == part] for part in ("tune", "judge")}
    names = [*sum(sets.values(), []), *([] if quick else ["uo-180-180-180"])]
    measured, ours = collect(names, **setting(model, constants, seeds, quick=quick, **others))
    rows = []
    for part, own in sets.items():
        real = classes(pooled(measured, own), 0.25, 6)
        off, reached = [], []
        for seed in range(len(ours[own[0]])):
            model_s = classes(pooled(ours, own, seed), 0.25, 6)
            both = real.keys() & model_s.keys()
            reached.append(len(both) / len(real))
            off.append(math.sqrt(mean([(model_s[low] - real[low]) ** 2 for low in both])) if both else math.inf)
        rows.append(compare("corridor", "v(density), RMS [m/s]", part, 0.0, off, at_most=0.12))
        rows.append(compare("corridor", f"part of the {len(real)} classes of density reached", part, 1.0, reached, at_least=0.5))
    for name in names[-1:] * (not quick):
        flows = [each["capacity"] for each in ours[name]]
        rows.append(compare("corridor", f"capacity, {name} [1/(m s)]", set_of(name), measured[name]["capacity"], flows, amount=0.15))
    return rows


def counterflow(model, constants="", seeds=10, quick=False, **others):
    """Two directions in a corridor: flow against density, and whether everybody gets through."""
    every_one = [name for name in RUNS if name.startswith("bo")]
    sets = {"tune": ["bot-360-075-075"]} if quick else {part: [name for name in every_one if set_of(name) == part] for part in ("tune", "judge")}
    measured, ours = collect(sum(sets.values(), []), **setting(model, constants, seeds, quick=quick, **others))
    rows = []
    for part, own in sets.items():
        runs = [classes(pooled(ours, own, seed), 0.5, 10) for seed in range(len(ours[own[0]]))]
        for low, flow in classes(pooled(measured, own), 0.5, 10).items():
            flows = [run[low] for run in runs if low in run] or [math.nan]
            if low >= 0.5:
                rows.append(compare("counterflow", f"J at {low:.1f} to {low + 0.5:.1f} /m² [1/(m s)]", part, flow, flows, share=0.2))
        stuck = [each["stuck"] for name in own for each in ours[name]]
        total = Row("counterflow", "part of the runs that get stuck", part, 0.0, mean(stuck), math.nan, math.nan, "none", not sum(stuck))
        rows.append(total)
    return rows


def single_file(model, constants="", seeds=10, quick=False, **others):
    """Single file on a ring: speed at the measured headway, its spread, how many stand, and who overtakes."""
    names = ["croma-20"] if quick else [name for name in RUNS if name.startswith(("croma", "ux"))]
    measured, ours = collect(names, **setting(model, constants, seeds, quick=quick, **others))
    rows = []
    for name in names:
        title, of = f"{name}, headway {measured[name]['headway']:.2f} m: ", set_of(name)

        def one(what, key, title=title, of=of, real=measured[name], own=ours[name], **limit):
            rows.append(compare("single file", title + what, of, real[key], [each[key] for each in own], **limit))

        one("speed [m/s]", "speed", amount=0.08)
        # Those of the older experiment are means over 2 m of way.
        if name.startswith("croma"):
            one("SD of speed [m/s]", "spread", factor=2)
            one("part that stands", "stopped", factor=2, least=0.02)
        one("people overtaken", "overtakings", at_most=0.0)
    return rows


#: Specific flow, density, speed, last: measured with PedPy by somebody else.
CHECKED = {
    GATE: (2.32, 7.2, 0.11, 65),
    "uo-180-180-070": (2.31, 3.06, 0.30, 92),
    "uo-180-180-095": (1.84, 2.49, 0.40, 90),
    "uo-180-180-120": (1.91, 2.11, 0.62, 74),
    "uo-180-180-180": (1.58, 1.66, 0.97, 82),
    "uo-240-240-160": (1.95, 2.18, 0.60, 90),
}


def measured_side(data=None, processes=2):
    """The measured side alone: a table for each kind of experiment."""
    found = collect(RUNS, Walk("straight"), 0, directory(data), processes=processes)[0]
    exits_ = pd.DataFrame(
        [
            {"run": name, **{key: value for key, number in zip(("specific", "density", "speed", "last"), numbers) for key, value in ((key, found[name][key]), (f"{key}, by others", number))}}
            for name, numbers in CHECKED.items()
        ]
    )
    gate_ = pd.DataFrame([{key: found[GATE][key] for key in ("flow", "nearest", "gap 95 %", "greatest gap")}])
    speeds = pd.DataFrame({name: classes(found[name]["points"], 0.25, 6) for name in CORRIDORS}).sort_index()
    flows = pd.DataFrame({name: classes(found[name]["points"], 0.5, 10) for name in RUNS if name.startswith("bo")}).sort_index()
    files = pd.DataFrame({name: found[name] for name in RUNS if name.startswith(("croma", "ux"))}).T
    return {"gate and exits": exits_, "gate": gate_, "v(density) [m/s]": speeds, "J(density) [1/(m s)]": flows, "single file": files}


ROWS = {"gate": gate, "exits": exits, "corridor": corridor, "counterflow": counterflow, "single_file": single_file}


def beside(found):
    """Rows of a table: of each number the measured one, the limit, and the medians of models; bold: outside of the limit."""
    models = list(found)
    say = lambda value: "–" if math.isnan(value) else "never" if math.isinf(value) else f"{value:.3g}"  # noqa: E731
    table = []
    for rows in zip(*found.values()):
        first = rows[0]
        cells = [say(row.ours) if row.passed else f"**{say(row.ours)}**" for row in rows]
        if models[0] in OURS and not math.isnan(first.low):
            cells[0] += f" ({say(first.low)} to {say(first.high)})"
        table.append([first.row.replace("_", " "), first.what, first.set, say(first.measured), first.limit, *cells])
    passed = [f"{sum(row.passed for row in rows)} of {len(rows)}" for rows in found.values()]
    table.sort(key=lambda cells: not cells[5].startswith("**"))
    return [*table, ["all", "within the limit", "", "", "", *passed]]


def write_page(found):
    """Puts the table and the pictures into docs/validation.md."""
    head = ["row", "number", "set", "measured", "limit", *(name.replace("jupedsim-", "JuPedSim ") for name in found)]
    lines = ["| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head), *beside(found)]]
    begin, end = "<!-- experiments -->", "<!-- /experiments -->"
    before, _, rest = PAGE.read_text().partition(begin)
    after = rest.partition(end)[2]
    if not after:
        raise SystemExit(f"{PAGE}: there is no {begin} … {end}")
    PAGE.write_text(f"{before}{begin}\n\n" + "\n".join(lines) + f"\n\n{end}{after}")


def pictures(models, data):
    """Draws N(t) at the gate, flow against width, speed against density, and flow of two directions; then lanes."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "lemons", "svg.fonttype": "none", "font.size": 9}
    import matplotlib.pyplot as plt

    colours = dict(zip(models, ["#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00"]))
    of = lambda name, model: [found for task, found in KEPT.items() if task[0] == name and task[2] and task[2].model == model]  # noqa: E731
    real = {task[0]: found for task, found in KEPT.items() if task[2] is None}
    figure, ((gate_, doors), (one, two)) = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
    corridors = [name for name in CORRIDORS if name in real]
    both = [name for name in real if name.startswith("bo")]

    def steps(found, **look):
        gate_.step([0, *found["times"]], range(len(found["times"]) + 1), where="post", **look)

    for model in models:
        look = dict(color=colours[model])
        for found in of(GATE, model)[:3]:
            steps(found, linewidth=0.8, **look)
        middle = [np.median([found["specific"] for found in of(name, model)]) for name in EXITS]
        widths = [int(name.split("-")[3]) / 100 for name in EXITS]
        order = np.argsort(widths)
        doors.plot(np.array(widths)[order], np.array(middle)[order], "o-", markersize=4, label=model.replace("jupedsim-", "JuPedSim "), **look)
        for panel, names, width, least in ((one, corridors, 0.25, 6), (two, both, 0.5, 10)):
            points = [found["points"] for name in names for found in of(name, model)[:1]]
            if points:
                curve = classes(np.concatenate(points), width, least)
                panel.plot([low + width / 2 for low in curve], list(curve.values()), "o-", markersize=3, linewidth=0.8, **look)
    steps(real[GATE], color="black", linewidth=2)
    widths = [int(name.split("-")[3]) / 100 for name in EXITS]
    doors.plot(widths, [real[name]["specific"] for name in EXITS], "ks", label="measured")
    for panel, names, width, least in ((one, corridors, 0.25, 6), (two, both, 0.5, 10)):
        curve = classes(pooled(real, names), width, least)
        panel.plot([low + width / 2 for low in curve], list(curve.values()), "ks", markersize=5)
    gate_.set(title="Gate of 0.5 m, 75 people (three seeds)", xlabel="time [s]", ylabel="people through the gate", xlim=(0, 160))
    doors.set(title="Exits of corridors", xlabel="width of the exit [m]", ylabel="flow [1/(m s)]", ylim=(0, None))
    one.set(title="Corridors, one direction", xlabel="density [1/m²]", ylabel="speed [m/s]", ylim=(0, None))
    two.set(title="Corridors, two directions", xlabel="density [1/m²]", ylabel="flow [1/(m s)]", ylim=(0, None))
    doors.legend(fontsize=8)
    figure.savefig(PAGE.parent / "validation_experiments.svg", metadata={"Date": None})
    # Lanes: ways of ten seconds in the middle of a run.
    name = "bot-360-090-090"
    scene = scene_of(name, str(data))
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), layout="constrained")
    for panel, (title, traces) in zip(panels, [("measured", scene.recorded), (models[0], simulated(scene, Walk(models[0]), 1, 60.0))]):
        table = traces.data[(traces.data["y"].abs() < 4) & traces.data["frame"].between(30 * scene.fps, 40 * scene.fps)]
        for _, way in table.groupby("id"):
            up = way["y"].iloc[-1] > way["y"].iloc[0]
            way = way.iloc[::4]
            panel.plot(way["y"], way["x"], color="#D55E00" if up else "#0072B2", linewidth=0.8)
        panel.set(title=f"{title}: ways from 30 to 40 s", xlim=(-4, 4), ylim=(0, 3.6), xlabel="along the corridor [m]", ylabel="across [m]", aspect="equal")
    figure.savefig(PAGE.parent / "validation_lanes.svg", metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("row", nargs="*", help=f"of {', '.join(ROWS)}, or measured; default: all rows")
    parser.add_argument("--model", action="append", help=f"one of {', '.join(OURS)}, {', '.join(f'jupedsim-{name}' for name in THEIRS)}")
    parser.add_argument("--seeds", type=int, default=10, help="of the first model; others: at most --peers")
    parser.add_argument("--peers", type=int, default=10, help="most seeds of models after the first one")
    parser.add_argument("--constants", default="", metavar="TOML", help="put into decision.toml; of JuPedSim: parameters of its agents")
    parser.add_argument("--constants-of", nargs=2, action="append", default=[], metavar=("ROW", "TOML"), help="those of one row, instead of --constants")
    parser.add_argument("--body", metavar="BxD", help="all people have this breadth and depth [m], for example 0.38x0.22; default: drawn from the survey")
    parser.add_argument("--friction", type=float, help="between people; default: that of lemons crowd")
    parser.add_argument("--quick", action="store_true", help="one seed, 40 s, few experiments: to see that it works")
    parser.add_argument("--data", help="the directory with the trajectories")
    parser.add_argument("--write", action="store_true", help="put the table of all models, and pictures, into docs/validation.md")
    arguments = parser.parse_args()
    data = directory(arguments.data)
    if data is None:
        print("experiments: there are no trajectories (--data DIR, or LEMONS_WALK_DATA): nothing is compared")
        return
    for names, what in zip(differing(data), ("is missing", "is another file than the one that was compared for docs/validation.md")):
        for name in names:
            print(f"warning: {data / name} {what}", file=sys.stderr)
    if "measured" in arguments.row:
        for title, table in measured_side(data).items():
            print(f"{title}\n\n{table.round(3).to_string()}\n")
        return
    body = tuple(map(float, arguments.body.split("x"))) if arguments.body else None
    models = arguments.model or ["rotational"]
    found = {}
    for model in models:
        began, rows = time.monotonic(), []
        seeds = arguments.seeds if model == models[0] else min(arguments.seeds, arguments.peers)
        for name in arguments.row or ROWS:
            constants = dict(arguments.constants_of).get(name, arguments.constants)
            rows += ROWS[name](model, constants, seeds, body=body, friction=arguments.friction, data=data, quick=arguments.quick)
        found[model] = rows
        print(f"{model}: {sum(row.passed for row in rows)} of {len(rows)} pass ({time.monotonic() - began:.0f} s)\n")
        show([row.cells() for row in rows], HEAD)
    if arguments.write:
        write_page(found)
        pictures(models, data)


def show(rows, head):
    widths = [max(len(cells[k]) for cells in [head, *rows]) for k in range(len(head))]
    print("\n".join("  ".join(cell.ljust(width) for cell, width in zip(cells, widths)).rstrip() for cells in [head, *rows]))
    print(flush=True)


if __name__ == "__main__":
    main()
