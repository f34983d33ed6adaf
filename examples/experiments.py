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

What is measured is told by `experiment/measures.py`, where people start by `experiment/runs.py`.

Tune on the runs of TUNE only. Those of JUDGE were named before anything was tuned; they are for judging.
"""

import argparse
import math
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from experiment.measures import mean
from experiment.runs import CORRIDORS, EXITS, GATE, RUNS, THEIRS, TUNE, Walk, differing, directory, scene_of, simulated

OURS = ["rotational", "collision-free-speed", "social-force", "straight"]
PAGE = Path(__file__).resolve().parents[1] / "docs" / "validation.md"


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


def setting(model, constants="", seeds=10, body=None, friction=None, material=None, data=None, quick=False, processes=2):
    """What all rows take: model and constants, seeds, bodies, friction, material; `quick` ends runs after 40 s and takes few of them."""
    return dict(walk=Walk(model, constants, body, friction, material), seeds=1 if quick else seeds, data=directory(data), most=40.0 if quick else None, processes=processes)


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
    parser.add_argument("--material", help="of people, as of lemons crowd")
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
            of_people = dict(body=body, friction=arguments.friction, material=arguments.material)
            rows += ROWS[name](model, constants, seeds, **of_people, data=data, quick=arguments.quick)
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
