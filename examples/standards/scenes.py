"""The scenes of the tests of guidelines and standards: each makes Trials, runs them, and returns numbers by name.

Each scene is a function of a directory and of what a row of tests.toml says after `with`. Walls and people are made, run and
measured by the functions of ../validation.py. A number may be a text or a list, which a row only shows. What begins with `_` is for
pictures. People are drawn from the survey with a seed of their own; where a test has no number for something, the comment says what
was chosen.
"""

import json
import math
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import validation  # noqa: E402
from validation import make, line  # noqa: E402

MODEL = "rotational"  # the default of `lemons crowd --leave`
SPEED = validation.SPEED
WORKERS = 2  # runs at the same time


def at_once(function, items):
    """The results of a function, for runs that do not depend on each other."""
    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(function, items))


def write_decision(trial, exits, agents=(), speed=SPEED, model=MODEL, **others):
    """Writes decision.toml. Exits: by name a line, and a text of other keys. Agents: a text of keys for each. Others: keys for
    everybody, as TOML."""
    lines = [f'model = "{model}"', f"desired_speed = {speed}", *(f"{key} = {value}" for key, value in others.items()), "exits = ["]
    for name, (a, b, *keys) in exits.items():
        lines.append(f'  {{ name = "{name}", line = [{list(a)}, {list(b)}]' + "".join(f", {key}" for key in keys) + " },")
    lines.append("]")
    for number, keys in enumerate(agents):
        lines += [f"[agents.{number}]", keys]
    (trial / "decision.toml").write_text("\n".join([*lines, ""]))


def each_speed(count, seed, mean=SPEED, spread=validation.SPREAD):
    """Keys of desired speeds: a normal distribution, cut at two standard deviations."""
    return [f"desired_speed = {speed:.4f}" for speed in validation.speeds_of(count, seed, mean, spread)]


def walk(trial, *words, until="left"):
    """Simulates and measures a Trial. Returns the summary and the tables of `lemons measure`."""
    directory = trial.with_name(trial.name + "_measures")
    validation.lemons("measure", trial, "--until", until, "-o", directory, "--force", *words)
    tables = {name: pd.read_csv(directory / f"{name}.csv") for name in ("gaps", "density", "people")}
    return json.loads((directory / "summary.json").read_text()), tables


def crossed(tables, name, direction="right"):
    """When each person crossed a line [s], by Id, in this order."""
    rows = tables["gaps"]
    rows = rows[(rows["line"] == name) & (rows["direction"] == direction)]
    return rows.drop_duplicates("id").set_index("id")["t"]


def steady_densities(tables, times):
    """Mean density of each area, between a fifth and four fifths of these passages."""
    a, b = times.quantile([0.2, 0.8])
    rows = tables["density"]
    return rows[rows["t"].between(a, b)].groupby("area")["density"].mean()


def drawn(trial, name):
    """What the program drew for each person: the start values of a parameter of the Decision FMU."""
    fmu = trial.with_name(trial.name + "_decision.fmu")
    validation.lemons("decide", trial, "-o", fmu, "--force")
    variables = ElementTree.fromstring(zipfile.ZipFile(fmu).read("modelDescription.xml")).iter("ScalarVariable")
    values = {each.get("name"): each.find("Real").get("start") for each in variables if each.get("name").endswith(f".{name}")}
    return np.array([float(values[f"agent[{i}].{name}"]) for i in range(len(values))])


def paths(frames, every=5):
    """The ways of people, for a picture: x and y [m] of each."""
    return [[own["x"].round(2).tolist()[::every], own["y"].round(2).tolist()[::every]] for _, own in frames.groupby("id")]


def room(wide, high, door, centre, length=0.0):
    """Walls of a room whose origin is the lower left corner, with one door in its right wall, before a passage of some length."""
    low, top, end = centre - door / 2, centre + door / 2, wide + length
    ends = [(end, low)] if length else []
    return [[*ends, (wide, low), (wide, 0), (0, 0), (0, high), (wide, high), (wide, top), *([(end, top)] if length else [])]]


# ---- one person, a few people ----


def corridor(work, speed):
    """The corridor of 40 m, with a speed."""
    time = validation.walks_alone(work / f"corridor_{speed}", MODEL, speed)
    return {"time": time, "speed": 40 / time, "deviation": abs(40 / time / speed - 1)}


def premovement(work, distribution, given=False, seeds=10):
    """Ten people with times of their own leave a room. The times are drawn by the program, or given for each person.

    Somebody has started whom Decision drives. People who still wait may be pushed by others, so that their places do
    not tell. A row of the run is written each 0.1 s.
    """
    from scipy import stats

    shape = {
        "uniform": (stats.uniform(10, 90), "{ min = 10, max = 100 }"),
        "normal": (stats.truncnorm(-2.5, 2.5, 60, 20), "{ mean = 60, sd = 20, min = 10, max = 110 }"),
        "lognormal": (stats.lognorm(0.967, scale=math.exp(4.586)), None),
    }
    continuous, text = shape[distribution]

    def once(seed):
        trial = work / f"premovement_{distribution}_{given}_{seed}"
        make(trial, room(8, 5, 1, 2.5), 10, (0, 0, 8, 5), seed)
        exits = {"door": ((9, 1), (9, 4))}
        if given:
            asked = continuous.rvs(10, random_state=seed).round(3)
            write_decision(trial, exits, [f"start = {time:.3f}" for time in asked])
        else:
            write_decision(trial, exits, start=text, seed=seed)
            asked = drawn(trial, "Start")
        table = trial.with_suffix(".csv")
        until = math.ceil(asked.max()) + 1
        validation.lemons("run", trial, "--until", until, "--every", 5, "-o", trial.with_suffix(".rows"), "--format", "csv", "--outputs", table, "--force")
        rows = pd.read_csv(table)
        force = [np.hypot(rows[f"decision.agent[{i}].Fp.x"], rows[f"decision.agent[{i}].Fp.y"]) for i in range(10)]
        return asked, np.array([rows["t"][(each > 0).to_numpy().argmax()] if (each > 0).any() else math.nan for each in force])

    asked, started = map(np.concatenate, zip(*at_once(once, range(1, seeds + 1))))
    late = started - asked
    return {
        "people": len(asked),
        "moved": int(np.isfinite(started).sum()),
        "first": started.min(),
        "last": started.max(),
        "earliest": round(np.nanmin(late), 6) + 0.0,
        "latest": np.nanmax(late),
        "p": stats.kstest(started, continuous.cdf).pvalue,
    }


def corner(work, seeds=3):
    """Twenty people around a corner, some crowds."""
    runs = at_once(lambda seed: validation.around_corner(work / f"corner_{seed}", MODEL, seed), range(1, seeds + 1))
    return {
        "outside": sum(places for _, places, _ in runs),
        "deepest": max(depth for *_, depth in runs),
        "left": min(frames.loc[frames["t"] > 0, "id"].nunique() for frames, *_ in runs),
        "last": max(frames["t"].max() for frames, *_ in runs),
        "_paths": paths(runs[0][0]),
    }


def speeds(work, people, seed=1, mean=None, sd=None, low=None, high=None):
    """People in a hall of 100 m x 100 m walk to its other side. Speeds are measured between 40 and 70 m, where all walk freely.

    The hall is that of ISO 20414; the other tests have none. People stand on the first 20 m.
    """
    from scipy import stats

    trial = work / f"speeds_{people}_{mean}_{low}"
    make(trial, [[(0, 0), (100, 0), (100, 100), (0, 100), (0, 0)]], people, (1, 1, 20, 99), seed)
    if mean is None:
        text, continuous = f"{{ min = {low}, max = {high} }}", stats.uniform(low, high - low)
    else:
        # Cut at three standard deviations: decision.toml needs bounds.
        text = f"{{ mean = {mean}, sd = {sd}, min = {mean - 3 * sd:.4f}, max = {mean + 3 * sd:.4f} }}"
        continuous = stats.truncnorm(-3, 3, mean, sd)
    write_decision(trial, {"other side": ((99, 0), (99, 100))}, speed=text, seed=seed)
    _, tables = walk(trial, line("in", (40, 0), (40, 100)), line("out", (70, 0), (70, 100)))
    start, end = crossed(tables, "in"), crossed(tables, "out")
    found = (30 / (end - start)).sort_index()
    off = np.abs(found - drawn(trial, "DesiredSpeed")[found.index])
    return {
        "people": len(found),
        "mean": found.mean(),
        "sd": found.std(),
        "lowest": found.min(),
        "highest": found.max(),
        "worst": off.max(),
        "p": stats.kstest(found, continuous.cdf).pvalue,
    }


# ---- flow and density ----

DENSITIES = (0.5, 1, 2, 3, 4, 5, 6)  # 1/m²


def ring(work, densities=DENSITIES):
    """The ring of docs/validation.md with the densities of RiMEA. Speeds are means of the last 20 of 40 s."""

    def once(density):
        count = round(density * validation.AREA)
        speed = validation.walk_around(work / f"ring_{density}", MODEL, count, 40)
        return count / validation.AREA, speed.mean()

    found = np.array(at_once(once, sorted(densities, reverse=True))[::-1])
    density, speed = found.T
    off = [abs(v - validation.weidmann(d)) for d, v in found if d < 5.4]
    flow = density * speed
    return {
        "densities": density,
        "speeds": speed,
        "flows": flow,
        "greatest_rise": np.diff(speed).max(),
        "worst": max(off),
        "greatest_flow": flow.max(),
        "at": density[flow.argmax()],
        "densest_flow": flow[-1],
        "ratio": flow[-1] / flow[:-1].max(),
    }


def corridor_of_60(work, counts=(60, 120, 240, 360, 480)):
    """A corridor of 60 m x 2 m full of people, who leave at its right end. Zone 2 is from x = 20 m to 40 m.

    Speeds are those of the people of the first zone between the lines A and B. Density: mean in zone 2 from the first to the last
    of them at B, of all who are there. All want to walk at 1 m/s. Both are means of different people: their product is not a flow
    that was counted.
    """

    def once(count):
        trial = work / f"corridor_60_{count}"
        make(trial, [[(61, 0), (0, 0), (0, 2), (61, 2)]], count, (0, 0, 60, 2), 1)
        write_decision(trial, {"end": ((60.5, 0), (60.5, 2))}, speed=1.0)
        summary, tables = walk(trial, line("A", (20, 0), (20, 2)), line("B", (40, 0), (40, 2)), "--area=zone2=20,0,40,2")
        a, b = crossed(tables, "A"), crossed(tables, "B")
        through = b[b.index.isin(a.index)]
        own = 20 / (through - a[through.index])
        zone = tables["density"]
        zone = zone[zone["t"].between(a.min(), through.max())]
        return zone["density"].mean(), own.mean(), own.max(), summary["left"]["people"]

    found = np.array(at_once(once, sorted(counts, reverse=True))[::-1])
    return {
        "counts": np.array(counts),
        "densities": found[:, 0],
        "speeds": found[:, 1],
        "products": found[:, 0] * found[:, 1],
        "greatest_rise": np.diff(found[:, 1]).max(),
        "fastest": found[:, 2].max(),
        "stay": int(sum(counts) - found[:, 3].sum()),
    }


def single_file(work, counts=(12, 16, 20, 24, 28, 32, 36)):
    """The circle of docs/validation.md: people behind each other. Beside it the line of Seyfried et al. 2005."""
    found = at_once(lambda count: validation.in_single_file(work / f"single_file_{count}", MODEL, count, 60), sorted(counts, reverse=True))
    speed, spacing = np.array(found[::-1]).T
    off = [abs(d - validation.seyfried(v)) for v, d in zip(speed, spacing) if 0.1 <= v <= 1]
    return {"densities": 1 / spacing, "speeds": speed, "greatest_rise": np.diff(speed).max(), "worst": max(off)}


def exit_flow(work, seeds=3, model=MODEL):
    """100 people leave a room of 8 m x 5 m by an exit of 1 m in the middle of a wall of 5 m. The flow is that over the whole time."""

    def once(seed):
        trial = work / f"exit_flow_{model}_{seed}"
        make(trial, room(8, 5, 1, 2.5), 100, (0, 0, 8, 5), seed)
        write_decision(trial, {"door": ((9, 1), (9, 4))}, each_speed(100, seed), model=model)
        times = crossed(walk(trial, line("door", (8, 2), (8, 3)))[1], "door")
        return len(times), len(times) / times.max()

    found = at_once(once, range(1, seeds + 1))
    return {"left": min(count for count, _ in found), "flow": np.mean([flow for _, flow in found]), "greatest": max(flow for _, flow in found)}


def congestion(work, people=100, seed=1):
    """People go from a room of 8 m x 5 m through an opening of 2 m into a corridor as wide, 12 m long. No stairs follow.

    The length of the corridor is ours. Densities are those of 2 m x 2 m before the opening and of 2 m x 4 m in the corridor.
    """
    trial = work / f"congestion_{people}"
    make(trial, room(8, 5, 2, 2.5, 12), people, (0, 0, 8, 5), seed)
    write_decision(trial, {"end": ((19, 1.5), (19, 3.5))}, each_speed(people, seed))
    lines = line("in", (8, 1.5), (8, 3.5)), line("end", (18, 1.5), (18, 3.5))
    summary, tables = walk(trial, *lines, "--area=before=6,1.5,8,3.5", "--area=corridor=12,1.5,16,3.5")
    inside = crossed(tables, "in")
    density = steady_densities(tables, inside)
    return {
        "left": summary["left"]["people"],
        "before": density["before"],
        "corridor": density["corridor"],
        "ratio": density["before"] / density["corridor"],
        "flow_in": validation.steady(inside),
        "flow_out": validation.steady(crossed(tables, "end")),
    }


# ---- two directions, wheelchairs ----


def counterflow(work, oncoming=(0, 10, 50, 100), seeds=2):
    """Two rooms of 10 m x 10 m, between them a corridor of 10 m x 2 m. 100 people go to the right, some to the left.

    Those to the right stand on the left 3 m of their room: 3.3 per m². Speeds are uniform from 0.97 to 1.62 m/s: IMO's men
    from 30 to 50 years. The time is that at which the last one to the right enters the room on the right.
    """
    walls = [[(10, 4), (10, 0), (0, 0), (0, 10), (10, 10), (10, 6), (20, 6), (20, 10), (30, 10), (30, 0), (20, 0), (20, 4), (10, 4)]]

    def once(case):
        against, seed = case
        trial = work / f"counterflow_{against}_{seed}"
        regions = ["0,0,3,10; number=100", *([f"20,0,30,10; number={against}"] if against else [])]
        make(trial, walls, None, regions, seed)
        x = validation.poses_of(trial)[:, 0]
        exits = {"right": ((29.5, 0), (29.5, 10)), "left": ((0.5, 0), (0.5, 10))}
        write_decision(trial, exits, [f'exit = "{"right" if place < 10 else "left"}"' for place in x], speed="{ min = 0.97, max = 1.62 }", seed=seed)
        summary, tables = walk(trial, line("room2", (20, 4), (20, 6)), until=600)
        times = crossed(tables, "room2")
        return times.max() if len(times) == 100 else math.nan

    cases = [(against, seed) for against in sorted(oncoming, reverse=True) for seed in range(1, seeds + 1)]
    by = pd.Series(at_once(once, cases), index=pd.MultiIndex.from_tuples(cases))
    # Of the runs of which none is stuck.
    means = np.array([by[against].mean(skipna=False) for against in oncoming])
    finite = means[np.isfinite(means)]
    growth = np.diff(finite).min() if len(finite) > 1 else math.nan
    stuck = np.array([by[against].isna().sum() for against in oncoming])
    return {"oncoming": np.array(oncoming), "times": means, "stuck_of_each": stuck, "stuck": int(stuck.sum()), "least_growth": growth}


def wheelchair(work, seeds=5):
    """24 people stand behind one, who is in a wheelchair or not, in a room of 4 m x 5 m. All go through a corridor of
    12 m x 1.5 m into a room as large, and leave it. The corridor is flat: there are no ramps.

    The 24 want to walk at 1.25 m/s, the one at 0.8 m/s. The chair is the kind `wheelchair`.
    """
    low, high = 1.75, 3.25
    around = [(20, 1), (20, 0), (16, 0), (16, low), (4, low), (4, 0), (0, 0), (0, 5), (4, 5), (4, high), (16, high), (16, 5), (20, 5), (20, 4)]

    def once(case):
        chair, seed = case
        kinds = "wheelchair=1" if chair else "adult=1"
        own, trial = work / f"one_{chair}_{seed}", work / f"wheelchair_{chair}_{seed}"
        make(own, [around], 1, "2.6,1.8,4,3.2", seed, orientation="fixed", mix=kinds)
        make(trial, [around], 24, "0,0,2.5,5", seed)
        add(trial, own)
        write_decision(trial, {"out": ((20.5, 0.5), (20.5, 4.5))}, ["desired_speed = 1.25"] * 24 + [f"desired_speed = {0.8 if chair else 1.25}"])
        _, tables = walk(trial, line("out", (20, 1), (20, 4)))
        times = crossed(tables, "out")
        return times[times.index != 24].max() if len(times) == 25 else math.nan

    cases = [(chair, seed) for chair in (True, False) for seed in range(1, seeds + 1)]
    times = np.array(at_once(once, cases)).reshape(2, seeds)
    return {
        "with": times[0].mean(),
        "without": times[1].mean(),
        "longer": times[0].mean() - times[1].mean(),
        "least": (times[0] - times[1]).min(),
        "stuck": int(np.isnan(times).sum()),
    }


def add(trial, other):
    """Adds the people of another Trial, of the same walls, as the last ones."""
    for path in ("static/Agents.xml", "dynamic/AgentDynamics.xml"):
        tree, more = ElementTree.parse(trial / path), ElementTree.parse(other / path)
        count = len(tree.getroot())
        for number, element in enumerate(more.getroot()):
            element.set("Id", str(count + number))
            tree.getroot().append(element)
        tree.write(trial / path, encoding="utf-8", xml_declaration=True)
    # The materials and the shorter mechanical step of a frame.
    for path in ("static/Materials.xml", "Parameters.xml"):
        (trial / path).write_bytes((other / path).read_bytes())


# ---- exits ----


def routes(work, seed=1):
    """A corridor of 18 m x 1 m with six rooms of 3 m x 5 m on each side. 23 people: two in each room, one in the last.

    Rooms 1 to 6 are above the corridor, 7 to 12 below it, from the left. The main exit is the left end of the corridor, the secondary
    exit its right end. Doors of 0.9 m are in the middle of the rooms; the standard's drawing was not at hand.
    """
    walls = [[(-1, 5), (0, 5), (0, 0), (18, 0), (18, 5), (19, 5)], [(-1, 6), (0, 6), (0, 11), (18, 11), (18, 6), (19, 6)]]
    regions = []
    for k in range(12):
        x, above = 3 * (k % 6), k < 6
        y = 6 if above else 5
        walls.append([(x, y), (x + 1.05, y)])
        walls.append([(x + 1.95, y), (x + 3, y)])
        if k % 6:
            walls.append([(x, 6), (x, 11)] if above else [(x, 0), (x, 5)])
        low = 6.3 if above else 0.3
        regions.append(f"{x + 0.3},{low},{x + 2.7},{low + 4.4}; number={1 if k == 11 else 2}")
    trial = work / "routes"
    make(trial, walls, None, regions, seed)
    poses = validation.poses_of(trial)
    rooms = (poses[:, 0] // 3).astype(int) + np.where(poses[:, 1] > 5.5, 1, 7)
    asked = np.where(np.isin(rooms, [5, 6, 11, 12]), "secondary", "main")
    write_decision(trial, {"main": ((-0.8, 5), (-0.8, 6)), "secondary": ((18.8, 5), (18.8, 6))}, [f'exit = "{name}"' for name in asked])
    table = validation.run(trial, 120)
    _, tables = validation.measured(trial, table, line("main", (0, 5), (0, 6)), line("secondary", (18, 5), (18, 6)))
    used = {name: set(crossed(tables, name, direction).index) for name, direction in (("main", "left"), ("secondary", "right"))}
    right = sum(number in used[name] for number, name in enumerate(asked))
    wrong = sum(number in used[name] for number, own in enumerate(asked) for name in used if name != own)
    main = (asked == "main").tolist()
    return {"people": len(asked), "right": right, "wrong": wrong, "_paths": paths(validation.frames_of(table)), "_main": main, "_walls": walls}


def doors(work, wide, high, xs, people=1000, seed=1):
    """A room with two doors of 1 m in each of two opposite walls; then with the doors of one wall only."""

    def once(four):
        trial = work / f"doors_{wide}_{four}"
        cut = [(x, y) for y in ((0, high) if four else (0,)) for x in xs]
        make(trial, validation.walls_with_doors(wide, high, cut), people, (0, 0, wide, high), seed)
        out = {f"{x}, {y}": ((x - 1.5, y - 1), (x + 1.5, y - 1)) if y == 0 else ((x - 1.5, y + 1), (x + 1.5, y + 1)) for x, y in cut}
        write_decision(trial, out, each_speed(people, seed))
        summary, _ = walk(trial)
        return summary["left"]["people"], summary["left"]["last"]

    (left4, four), (left2, two) = at_once(once, (True, False))
    return {"stay": 2 * people - left4 - left2, "four": four, "two": two, "ratio": two / four}


def choice(work, wide, high, xs, people=1000, seed=1):
    """A room whose left third is full of people, as dense as 5 per m² at first. Two exits of 1 m are in its upper wall."""
    trial = work / "choice"
    # Each exit has walls around it, so that no way leads through the other door.
    around = [[(x - 1.2, high), (x - 1.2, high + 1.6), (x + 1.2, high + 1.6), (x + 1.2, high)] for x in xs]
    walls = validation.walls_with_doors(wide, high, [(x, high) for x in xs]) + around
    make(trial, walls, people, (0, 0, wide / 3, high), seed)
    exits = {name: ((x - 1.1, high + 1), (x + 1.1, high + 1)) for name, x in zip(("near", "far"), xs)}
    write_decision(trial, exits, each_speed(people, seed), exit_choice='"time"')
    lines = [line(name, (x + 0.5, high), (x - 0.5, high)) for name, x in zip(exits, xs)]
    areas = [f"--area={name}={x - 2},{high - 3},{x + 2},{high}" for name, x in zip(exits, xs)]
    summary, tables = walk(trial, *lines, *areas)
    used = {name: len(crossed(tables, name)) for name in exits}
    density = {each["name"]: each["density"]["max"] for each in summary["areas"]}
    return {**used, "lead": used["near"] - used["far"], "stay": people - sum(used.values()), "density": density["near"], "last": summary["left"]["last"]}


def familiar(work, people=100, seed=1):
    """A room of 15 m x 10 m with exits of 1 m at both ends of a wall, as far from the middle. People choose by the expected time. First
    both exits are alike, then that of the second one counts half (`time_factor`)."""

    def once(factor):
        trial = work / f"familiar_{factor}"
        cut = [(2.5, 10), (12.5, 10)]
        make(trial, validation.walls_with_doors(15, 10, cut), people, (6, 1, 9, 6), seed)
        factors = zip("AB", cut, (1.0, factor))
        exits = {name: ((x - 1.5, 11), (x + 1.5, 11), f"time_factor = {own}") for name, (x, _), own in factors}
        write_decision(trial, exits, each_speed(people, seed), seed=seed, exit_choice='"time"')
        _, tables = walk(trial, *(line(name, (x + 0.5, 10), (x - 0.5, 10)) for name, (x, _) in zip("AB", cut)))
        return [len(crossed(tables, name)) for name in "AB"]

    same, more = at_once(once, (1.0, 0.5))
    stay = 2 * people - sum(same) - sum(more)
    return {"a": same[0], "b": same[1], "a2": more[0], "b2": more[1], "growth": more[1] - same[1], "stay": stay}


def closing_exit(work, seed=1):
    """A room of 10 m x 15 m with an exit of 1 m at the end of each long wall. One person stands at the short wall far from them, 0.1 m
    nearer to the first exit. This one closes after 1 s."""
    trial = work / "closing_exit"
    walls = [[(0, 13.5), (0, 0), (10, 0), (10, 13.5)], [(0, 14.5), (0, 15), (10, 15), (10, 14.5)]]
    make(trial, walls, 1, "4.6,0.3,5.3,1.2", seed, orientation="fixed", fixed="49,25,1.75,70")
    pose = validation.poses_of(trial)
    validation.move(trial, np.array([[4.9, 0.6, pose[0, 2]]]))
    write_decision(trial, {"first": ((-1, 13), (-1, 15), "open = [[0, 1]]"), "second": ((11, 13), (11, 15))})
    table = validation.run(trial, 40)
    frames = validation.frames_of(table)
    _, tables = validation.measured(trial, table, line("first", (0, 13.5), (0, 14.5)), line("second", (10, 14.5), (10, 13.5)))
    used = {name: sum(len(crossed(tables, name, side)) for side in ("left", "right")) for name in ("first", "second")}
    early = frames[frames["t"] <= 1.0]
    return {**used, "aside": 4.9 - early["x"].iloc[-1], "time": frames["t"].max()}


def groups(work, fast, slow, others, seed=1):
    """A room of 15 m x 20 m with an exit of 1 m in the middle of a short wall. Five people at the other end are a group: four are
    fast, one is slow. Ten others are half way to the exit. Then the five are no group."""
    walls = [[(8, 0), (15, 0), (15, 20), (0, 20), (0, 0), (7, 0)]]

    def once(together):
        trial = work / f"groups_{fast}_{together}"
        make(trial, walls, None, ["5,16,10,19.5; number=5", "2,8,13,12; number=10"], seed)
        speeds = [fast] * 4 + [slow] + [others] * 10
        more = {"groups": '{ members = [["0", "1", "2", "3", "4"]] }'} if together else {}
        write_decision(trial, {"door": ((5, -1), (10, -1))}, [f"desired_speed = {speed}" for speed in speeds], seed=seed, **more)
        times = crossed(walk(trial, line("door", (7, 0), (8, 0)))[1], "door")
        own = times[times.index < 5]
        return (own.max() - own.min() if len(own) == 5 else math.nan), own.max()

    (spread, last), (alone, _) = at_once(once, (True, False))
    return {"spread": spread, "alone": alone, "last": last}


# ---- bottlenecks, a large corner ----


def rooms_in_a_row(trial, seed, width=1.0, length=0.2, goal=10.0, second=False, people=150):
    """150 people on the left half of a room of 10 m x 10 m go through a bottleneck into a second one, and to a line in it.

    With a second bottleneck as the first one, they go on to a third room 5 m deep. Returns the summary and the tables.
    """
    low, high = 5 - width / 2, 5 + width / 2
    x = 10 + length
    near = [(10, low), (10, 0), (0, 0), (0, 10), (10, 10), (10, high)]
    if second:
        y = x + 10 + length
        lower = [(y + 5, 0), (y, 0), (y, low), (y - length, low), (y - length, 0), (x, 0), (x, low), (10, low)]
        walls = [[*lower, *near[1:], (x, high), (x, 10), (y - length, 10), (y - length, high), (y, high), (y, 10), (y + 5, 10), (y + 5, 0)]]
        goal = y + 4.5
    else:
        walls = [[(x, low), *near, (x, high), (x, 10), (x + 11, 10), (x + 11, 0), (x, 0), (x, low)]]
        goal = x + goal
    make(trial, walls, people, (0, 0, 5, 10), seed)
    at_neck = goal <= x + 0.01
    write_decision(trial, {"goal": ((goal, low if at_neck else 0), (goal, high if at_neck else 10))}, each_speed(people, seed))
    words = [line("first", (10 + length / 2, low), (10 + length / 2, high))]
    if second:
        words += [line("second", (y - length / 2, low), (y - length / 2, high))]
        words += ["--area=first=8,4,10,6", f"--area=second={y - length - 2},4,{y - length},6"]
    return walk(trial, *words)


def goal_distance(work, distances=(0, 2.5, 5, 7.5, 10), seeds=3):
    """The distance of the goal from the bottleneck."""
    cases = [(distance, seed) for distance in distances for seed in range(1, seeds + 1)]
    last = at_once(lambda case: rooms_in_a_row(work / "goal_{}_{}".format(*case), case[1], goal=case[0])[0]["left"]["last"], cases)
    times = np.array(last).reshape(len(distances), seeds).mean(axis=1)
    return {"distances": np.array(distances), "times": times, "growth": times[-1] - times[0], "least_growth": np.diff(times).min()}


def neck_length(work, lengths=(0.2, 5.0), seeds=2):
    """The length of the bottleneck."""
    cases = [(length, seed) for length in lengths for seed in range(1, seeds + 1)]
    last = at_once(lambda case: rooms_in_a_row(work / "neck_{}_{}".format(*case), case[1], length=case[0])[0]["left"]["last"], cases)
    times = np.array(last).reshape(len(lengths), seeds)
    return {"short": times[0].mean(), "long": times[1].mean(), "growth": times[1].mean() - times[0].mean()}


def two_necks(work, seed=1):
    """Two bottlenecks in a row: density before each, between the passages of a fifth and of four fifths through the first."""
    summary, tables = rooms_in_a_row(work / "two_necks", seed, second=True)
    first = crossed(tables, "first")
    means = steady_densities(tables, first)
    return {
        "left": summary["left"]["people"],
        "first": means["first"],
        "second": means["second"],
        "ratio": means["second"] / means["first"],
        "flow_first": validation.steady(first),
        "flow_second": validation.steady(crossed(tables, "second")),
    }


def neck_width(work, widths=(0.8, 1.0, 1.2), seeds=2):
    """The width of a bottleneck of 5 m."""

    def once(case):
        width, seed = case
        return validation.steady(crossed(rooms_in_a_row(work / f"width_{width}_{seed}", seed, width, 5.0)[1], "first"))

    cases = [(width, seed) for width in widths for seed in range(1, seeds + 1)]
    flows = np.array(at_once(once, cases)).reshape(len(widths), seeds).mean(axis=1)
    return {"widths": np.array(widths), "flows": flows, "least_growth": np.diff(flows).min()}


def large_corner(work, people=500, seed=1):
    """500 people walk around a corner in a corridor 20 m wide, and along straight ones as long as its inner side (44 m) and
    as its inner side and a quarter of a circle of 20 m (75.4 m). They stand on 6 m before the start: 4.2 per m²."""

    def once(length):
        trial = work / f"large_corner_{length}"
        if length:
            walls = [[(0, -6), (0, length + 2)], [(20, -6), (20, length + 2)], [(0, -6), (20, -6)]]
            end, words = ((0, length + 1), (20, length + 1)), line("end", (20, length), (0, length))
        else:
            walls = [[(50, 34), (0, 34), (0, -6), (20, -6), (20, 14), (52, 14)], [(50, 34), (52, 34)]]
            end, words = ((51, 14), (51, 34)), line("end", (50, 14), (50, 34))
        make(trial, walls, people, (0, -6, 20, 0), seed)
        write_decision(trial, {"end": end}, each_speed(people, seed))
        table = trial.with_suffix(".csv")
        validation.lemons("run", trial, "--until", "left", "--every", 25, "-o", table, "--force")
        times = crossed(validation.measured(trial, table, words)[1], "end")
        return times.max() if len(times) == people else math.nan, None if length else paths(validation.frames_of(table), 2)

    (long, _), (turn, ways), (short, _) = at_once(once, (75.4, None, 44))
    return {"short": short, "corner": turn, "long": long, "above": turn - short, "below": long - turn, "_paths": ways}


# ---- stairs, floors, smoke ----

RISER, TREAD = 0.17, 0.29  # m
ANGLE = math.atan2(RISER, TREAD)


def add(trial, *elements):
    """Adds elements to the Geometry.xml of a Trial: a name, attributes, and corners."""
    path = trial / "static" / "Geometry.xml"
    text = ""
    for k, (name, attributes, corners) in enumerate(elements):
        words = "".join(f' {key}="{value!r}"' for key, value in attributes.items())
        places = "".join(f'<Corner Coordinates="{x!r},{y!r}"/>' for x, y in corners)
        text += f'<{name} Id="{k}"{words}>{places}</{name}>\n'
    path.write_text(path.read_text().replace("</Geometry>", text + "</Geometry>"))


def flight(x, length, low, high, up, speed=None):
    """Stairs for `add` from x [m] on, up or down along x. A factor of the speed of who goes that way may be given."""
    own = {} if speed is None else {"SpeedUp" if up else "SpeedDown": speed}
    corners = [(x, low), (x + length, low), (x + length, high), (x, high)]
    return "Ground", {"Downhill": math.pi if up else 0.0, "Riser": RISER, "Tread": TREAD, **own}, corners


def stairs(work, up, length, speed=None):
    """One person on stairs 2 m wide, so long [m] along the incline. The speed along the incline [m/s] is set, or follows from the
    stairs. They begin 2 m before the line from which on the time counts: the person then walks steadily."""
    trial = work / f"stairs_{up}_{length}_{speed}"
    plan = length * math.cos(ANGLE)
    make(trial, [[(-6, 0), (plan + 4, 0)], [(-6, 2), (plan + 4, 2)]], 1, "-5.5,0.6,-4.5,1.4", orientation="fixed", fixed="49,25,1.75,70")
    add(trial, flight(-2.0, plan + 2.5, -1.0, 3.0, up, speed and speed * math.cos(ANGLE) / SPEED))
    write_decision(trial, {"end": ((plan + 3, 0), (plan + 3, 2))})
    summary, tables = walk(trial, line("in", (0, 0), (0, 2)), line("out", (plan, 0), (plan, 2)))
    time = float((crossed(tables, "out") - crossed(tables, "in")).iloc[0])
    found = length / time
    return {"time": time, "speed": found, "horizontal": plan / time, "deviation": abs(found / speed - 1) if speed else 0.0, "length": length}


#: Speeds of the slow and the fast lane on stairs against the density, with their spreads: the fit of Corbetta with which JuPedSim's
#: web community compares its test 13 of RiMEA; in m/s and 1/m².
BANDS = {
    True: (lambda d: 0.48 + 0.01 * d - (0.10 - 0.02 * d), lambda d: 0.18 * d**2 - 0.55 * d + 1.02 + 0.35 - 0.14 * d),
    False: (lambda d: 0.67 - 0.08 * d - (0.14 - 0.06 * d), lambda d: 0.33 * d**2 - 1.02 * d + 1.39 + 0.29 - 0.11 * d),
}


def stairs_diagram(work, people=100, seed=1):
    """100 people go from a room of 10 m x 10 m into a corridor of 9 m x 2 m with stairs 5 m long, in plan, up or down. Speeds
    are those over the stairs, densities those on them between the passages of a fifth and of four fifths."""

    def once(up):
        trial = work / f"stairs_diagram_{up}"
        make(trial, room(10, 10, 2, 5, 9), people, (0, 0, 10, 10), seed)
        add(trial, flight(12.0, 5.0, 3.5, 6.5, up))
        write_decision(trial, {"end": ((18.5, 4), (18.5, 6))}, each_speed(people, seed))
        _, tables = walk(trial, line("in", (12, 4), (12, 6)), line("out", (17, 4), (17, 6)), "--area=stairs=12,4,17,6")
        begin, end = crossed(tables, "in"), crossed(tables, "out")
        own = 5 / (end - begin[end.index])
        density = steady_densities(tables, begin)["stairs"]
        low, high = (band(density) for band in BANDS[up])
        return density, own.mean(), low, high, people - len(end)

    (up_density, up, up_low, up_high, stay), (down_density, down, down_low, down_high, others) = at_once(once, (True, False))
    return {
        **{"up": up, "down": down, "up_density": up_density, "down_density": down_density},
        **{"up_low": up_low, "up_high": up_high, "down_low": down_low, "down_high": down_high},
        "off": max(0.0, up_low - up, up - up_high, down_low - down, down - down_high),
        # Nelson and Mowrer along the incline, k = 1.08, in plan; the same up and down.
        "sfpe": [1.08 * (1 - 0.266 * density) * math.cos(ANGLE) for density in (up_density, down_density)],
        "faster": down - up,
        "stay": stay + others,
    }


def stairs_width(work, widths=(1.0, 1.4, 1.8), people=100, seed=1):
    """100 people go from a room of 8 m x 5 m up stairs 4 m long, of several widths, which begin 1 m behind its opening."""

    def once(width):
        trial = work / f"stairs_width_{width}"
        make(trial, room(8, 5, width, 2.5, 7), people, (0, 0, 8, 5), seed)
        add(trial, flight(9.0, 4.0, 1.0, 4.0, True))
        low, high = 2.5 - width / 2, 2.5 + width / 2
        write_decision(trial, {"end": ((14.5, low), (14.5, high))}, each_speed(people, seed))
        return validation.steady(crossed(walk(trial, line("top", (13, low), (13, high)))[1], "top"))

    flows = np.array(at_once(once, widths))
    return {"widths": np.array(widths), "flows": flows, "specific": flows / np.array(widths), "least_growth": np.diff(flows).min()}


def floors_of(count, length, wide):
    """Walls of floors beside each other, and the links that join the right end of each to the left end of the next. Behind each
    line of a link there is 0.6 m."""
    step = length + 5.0
    walls, links = [], []
    for k in range(count):
        x = k * step
        closed = [(x + length, 0.0), (x, 0.0), (x, wide), (x + length, wide)]
        walls.append([*closed, closed[0]] if k < count - 1 else closed)
        if k:
            links.append(("Link", {}, [(x - 5.6, 0.0), (x - 5.6, wide), (x + 0.6, wide), (x + 0.6, 0.0)]))
    return walls, links, step


def building(work, speeds=(0.8, 1.2, 1.6), floors=3, each=20, seed=1):
    """Three floors of 16 m x 2.4 m, each with 20 people in its left half, whose right end is stairs of 4 m down to the next floor.
    All leave by the end of the last one. The desired speed is varied."""
    walls, links, step = floors_of(floors, 16.0, 2.4)
    flights = [flight(k * step + 10.0, 4.0, 0.0, 2.4, False) for k in range(floors - 1)]

    def once(speed):
        trial = work / f"building_{speed}"
        regions = [f"{k * step + 1},0.2,{k * step + 9},2.2; number={each}" for k in range(floors)]
        make(trial, walls, None, regions, seed)
        add(trial, *flights, *links)
        end = (floors - 1) * step + 15.5
        write_decision(trial, {"street": ((end, 0.0), (end, 2.4))}, speed=speed)
        left = walk(trial)[0]["left"]
        return left["last"], left["people"]

    found = at_once(once, speeds)
    times = np.array([last for last, _ in found])
    return {"speeds": np.array(speeds), "times": times, "least_fall": -np.diff(times).max(), "stay": floors * each * len(speeds) - sum(count for _, count in found)}


def stairs_or_around(work, people=30, seed=1):
    """A room of 24 m x 6 m with a wall in its middle. To get to the goal on the other side of the wall, people go straight on over stairs to
    another floor, 6 m long, and over a link beside the goal; or, on the level, around the far end of the wall."""
    trial = work / "stairs_or_around"
    # Over the line at x = 5.4 m to the other floor, over its stairs, and back over a line beside the goal.
    walls = [[(0, 0), (24, 0), (24, 6), (0, 6), (0, 0)], [(0, 3), (22, 3)], [(29.4, 0), (38, 0), (38, 1.4), (29.4, 1.4), (29.4, 0)]]
    walls += [[(5, 1.4), (6, 1.4), (6, 0)], [(5, 4.6), (6, 4.6), (6, 6)]]
    links = [("Link", {}, [(5.4, 0.0), (5.4, 1.4), (30.0, 1.4), (30.0, 0.0)]), ("Link", {}, [(37.4, 0.0), (37.4, 1.4), (5.4, 4.6), (5.4, 6.0)])]
    make(trial, walls, people, "0.3,0.3,4,2.7", seed)
    add(trial, flight(31.0, 5.0, 0.0, 1.4, True), *links)
    write_decision(trial, {"goal": ((0.5, 3), (0.5, 6))}, each_speed(people, seed))
    summary, tables = walk(trial, line("stairs", (31, 0), (31, 1.4)), line("around", (22, 1.5), (24, 1.5)))
    used = {name: sum(len(crossed(tables, name, side)) for side in ("left", "right")) for name in ("stairs", "around")}
    return {**used, "stay": people - summary["left"]["people"], "last": summary["left"]["last"]}


def smoke(work, extinction=1.0, length=100.0, clear=1.25):
    """One person walks through 100 m of even smoke, as a level ground with a factor of the speed: 1 - 0.057/0.706 K, the law of Frantzich
    and Nilsson (2003) for an extinction coefficient K [1/m]."""
    trial = work / "smoke"
    factor = 1 - 0.057 / 0.706 * extinction
    make(trial, [[(-6, 0), (length + 4, 0)], [(-6, 2), (length + 4, 2)]], 1, "-5.5,0.6,-4.5,1.4", orientation="fixed", fixed="49,25,1.75,70")
    corners = [(0.0, -1.0), (length, -1.0), (length, 3.0), (0.0, 3.0)]
    add(trial, ("Ground", {"Downhill": 0.0, "Angle": 0.0, "Held": 1.0, "SpeedDown": factor, "SpeedUp": factor}, corners))
    write_decision(trial, {"end": ((length + 3, 0), (length + 3, 2))}, speed=clear)
    _, tables = walk(trial, line("in", (0, 0), (0, 2)), line("out", (length, 0), (length, 2)))
    time = float((crossed(tables, "out") - crossed(tables, "in")).iloc[0])
    return {"time": time, "factor": factor, "deviation": abs(time * clear * factor / length - 1)}


SCENES = {
    function.__name__: function
    for function in (
        *(corridor, premovement, corner, speeds, ring, corridor_of_60, single_file, exit_flow, congestion, counterflow, wheelchair),
        *(routes, doors, choice, familiar, closing_exit, groups, goal_distance, neck_length, two_necks, neck_width, large_corner),
        *(stairs, stairs_diagram, stairs_width, building, stairs_or_around, smoke),
    )
}
