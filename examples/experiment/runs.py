"""Experiments of `experiments.py`, and their runs: places and geometry, our side and JuPedSim's.

Where people start. Gate: where the measured people were in the first frame. Corridors: the camera sees nobody before the entrance,
so all stand behind it, in the waiting area 5 m wide, on a hexagonal grid of 3 people per m², each up to 0.04 m off it, the nearest
0.4 m from the wall; the entrance is E wide (100, 145 and 180-300-300: two openings of E/2 with 0.6 m between, as the places of the
first passages show; 070: one), and the floor before the corridor 1.5 m wider on both sides. Two directions: such a waiting area
at both ends, as many people as measured in each; each leaves to the side to which the measured one left. Single file: a
circle 0.8 m wide whose length is N times the mean measured headway (1/density), people at equal distances, each up to a tenth of it off.
Who would overlap is moved apart. Bodies are drawn from the survey (`--body` makes all of them alike), desired speeds from
N(1.34, 0.26²) m/s, those of Seyfried et al. from N(1.24, 0.15²) m/s, cut at two standard deviations.
"""

import functools
import gzip
import hashlib
import math
import os
import tempfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from .measures import measure_corridor, measure_counterflow, measure_gate, measure_ring

FREE = (1.34, 0.26)  # m/s, desired speeds: mean and standard deviation (Weidmann 1993)
FREE_UX = (1.24, 0.15)  # m/s, of the people of Seyfried et al. 2005
FREE_HERMES = (1.55, 0.18)  # m/s, measured of the people of the corridors (Zhang et al. 2011)
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
    the friction between people and their material (None: that of `lemons crowd`)."""

    model: str
    constants: str = ""
    body: tuple | None = None
    friction: float | None = None
    material: str | None = None


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
    found = Path(given or os.environ.get("LEMONS_WALK_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data" / "walk")
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
    for line in Path(__file__).parents[1].joinpath("experiments.sha256").read_text().splitlines():
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
    fixed |= {} if walk.material is None else {"material": walk.material}
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
