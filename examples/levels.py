"""What does a plan view of a crowd get wrong? People as in the plan, and in 2, 3 and 5 levels of height.

    python examples/levels.py levels
    python examples/levels.py levels pressed --seeds 10

docs/levels.md has the tables and what they mean. The cases, each of which can be named:

- `covered`: the paper's figure: ground covered at the heights of the shortest, the mean and the tallest torso, 6 people per m².
- `pressed`: a hall of 2 m by 6 m whose people press towards its end: density, squeeze, and compression of chests there.
- `doors`: flow of 50 people through a door of 0.9 m and of 1.2 m.
- `row`: a push on the last of a row of people who touch: what arrives at the end of the lane.

Each has people without children, with 20 and 50 % children, and `pressed` with 10 % wheelchairs. Needs the command `lemons` (or its path
in the variable LEMONS), and pandas.
"""

import argparse
import os
import subprocess
from pathlib import Path

import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
LEVELS = [1, 2, 3, 5]
MIXES = {
    "adults": "{ adult = 100 }",
    "20 % children": '{ adult = "rest", child = 20.0 }',
    "50 % children": '{ adult = "rest", child = 50.0 }',
    "10 % wheelchairs": '{ adult = "rest", wheelchair = 10.0 }',
}

#: Towards the end at x = 6 m, whose last metre is measured; people lean with 180 N as in docs/barriers.md.
PRESSED = """\
box = [6, 2]
density = 3.0
mix = {mix}
orientation = "towards"
direction = 0.0
time_step = 0.02

[decision]
model = "straight"
push = 20.0
waypoints = [{{ x = 1e5, y = 1.0 }}]
queue = {{ push = 180.0 }}
"""
PRESSED_SWEEP = """\
scenario = "{name}.toml"
until = 12.0

[parameters]
"population.levels" = {levels}
"population.seed" = {{ from = 1, to = {seeds} }}

[areas]
end = [5, 0, 6, 2]

[measures]
density = {{ area = "end", number = "density", take = "mean", from = 10.0 }}
squeeze_median = {{ squeeze = "largest_mean", over = 1, across = "median", from = 10.0 }}
squeeze_90 = {{ squeeze = "largest_mean", over = 1, across = "quantile_90", from = 10.0 }}
squeeze_max = {{ squeeze = "largest_mean", over = 1, across = "max", from = 10.0 }}
chest_median = {{ breathing = "front", across = "median", from = 7.0 }}
chest_90 = {{ breathing = "front", across = "quantile_90", from = 7.0 }}
"""
#: A room with a door of 0.9 m or 1.2 m.
DOORS = """\
box = [6, 6]
doors = [[6, 3, {width}]]
number = 50
mix = {mix}
time_step = 0.02
leave = true
"""
DOORS_SWEEP = """\
scenario = "{name}.toml"
until = "left"

[parameters]
"population.levels" = {levels}
"population.seed" = {{ from = 1, to = {seeds} }}

[lines]
door = [6, 4, 6, 2]

[measures]
flow = {{ line = "door", direction = "left", number = "flow" }}
squeeze_90 = {{ squeeze = "largest_mean", over = 1, across = "quantile_90" }}
"""
#: Wall 1 is the end of the lane.
LANE = """\
<?xml version="1.0" encoding="utf-8"?>
<Geometry>
    <Wall Id="0" MaterialId="concrete">
        <Corner Coordinates="8,0"/><Corner Coordinates="0,0"/><Corner Coordinates="0,0.8"/><Corner Coordinates="8,0.8"/>
    </Wall>
    <Wall Id="1" MaterialId="concrete"><Corner Coordinates="8,0.8"/><Corner Coordinates="8,0"/></Wall>
</Geometry>
"""
#: A lane of 0.8 m; the push is on who stands in the last 2.5 m. Everybody leans first, so that people touch.
ROW = """\
geometry = "lane.xml"
regions = [{{ corners = [[0, 0], [8, 0], [8, 0.8], [0, 0.8]] }}]
number = 12
mix = {mix}
orientation = "fixed"
direction = 0.0
time_step = 0.01
panel_length = 1.0

[[pushes]]
at = [0.5, 0.4]
radius = 2.0
direction = 0.0
force = 600.0
start = 8.0
duration = 0.5

[decision]
model = "straight"
push = 20.0
waypoints = [{{ x = 1e5, y = 0.4 }}]
queue = {{ push = 60.0 }}
"""
ROW_SWEEP = """\
scenario = "{name}.toml"
until = 9.5

[parameters]
"population.levels" = {levels}
"population.seed" = {{ from = 1, to = {seeds} }}

[measures]
before = {{ load = "load_step", wall = "1", whole = true, from = 7.0, until = 8.0 }}
arrives = {{ load = "load_step", wall = "1", whole = true, from = 8.0 }}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for scenarios and results")
parser.add_argument("cases", metavar="CASE", nargs="*", help="covered, pressed, doors, row (default: all)")
parser.add_argument("--seeds", type=int, default=5)
parser.add_argument("--levels", type=int, nargs="+", default=LEVELS)


def lemons(*words):
    """Runs the command, and returns what it prints."""
    done = subprocess.run([LEMONS, *map(str, words)], text=True, capture_output=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def sweep(target, name, scenario, settings, arguments):
    """Runs the scenario at all levels and seeds, and prints runs that failed. Returns the others."""
    (target / f"{name}.toml").write_text(scenario)
    (target / f"{name}_sweep.toml").write_text(settings.format(name=name, levels=arguments.levels, seeds=arguments.seeds))
    table = target / f"{name}.csv"
    lemons("sweep", target / f"{name}_sweep.toml", "-o", table, "--force")
    runs = pd.read_csv(table, comment="#")
    failed = runs[runs["status"] != "ok"]
    if len(failed):
        print(f"{name}: {len(failed)} runs failed: {failed['error'].iloc[0]}")
    return runs[runs["status"] == "ok"]


#: Student's t for 95 %, by the number of seeds from 2 on.
STUDENT = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26]


def half(values):
    """Returns half of the 95 % interval of a mean."""
    return STUDENT[min(len(values), 10) - 2] * values.std(ddof=1) / len(values) ** 0.5 if len(values) > 1 else float("nan")


def cell(own, plan):
    """Returns the mean of the plan with its interval; in levels the mean, and the difference from the plan of the same seeds."""
    if own.equals(plan):
        return f"{plan.mean():.3g} ± {half(plan):.2g}"
    difference = (own - plan).dropna()
    return f"{own.mean():.3g} ({difference.mean():+.2g} ± {half(difference):.2g})"


def cases(target, case, variants, settings, measures, arguments):
    """Prints a row for each mix and level."""
    print(f"{case}, {arguments.seeds} seeds\n{'':<30}" + "".join(f"{measure:>28}" for measure in measures))
    for variant, make in variants.items():
        for mix, shares in MIXES.items():
            if case != "pressed" and "wheelchair" in mix:
                # They jam in both doors, in levels and in the plan, and are nearly as wide as the lane.
                continue
            name = f"{case}_{variant}{mix}".replace(" ", "").replace("%", "")
            runs = sweep(target, name, make(shares), settings, arguments)
            of = {levels: runs[runs["population.levels"] == levels].set_index("population.seed") for levels in arguments.levels}
            plan = of[arguments.levels[0]]
            for levels, own in of.items():
                label = f"{variant}{mix}, {levels} level{'s' if levels > 1 else ' (plan)'}"
                print(f"{label:<30}" + "".join(f"{cell(own[measure], plan[measure]):>28}" for measure in measures), flush=True)


def covered(target, arguments):
    """Prints the covered parts of the ground."""
    print("covered ground, 6 adults per m²: what lemons crowd says of seed 1")
    print(lemons("crowd", "--number", 150, "--box", "5x5", "--sections", "torso", "--seed", 1, "-o", target / "covered", "--force"))


def pressed(target, arguments):
    """Prints densities and squeezes at the end of the hall."""
    measures = ["density", "squeeze_median", "squeeze_90", "squeeze_max", "chest_median", "chest_90"]
    cases(target, "pressed", {"": lambda mix: PRESSED.format(mix=mix)}, PRESSED_SWEEP, measures, arguments)


def doors(target, arguments):
    """Prints flows."""
    variants = {f"{width} m, ": lambda mix, width=width: DOORS.format(mix=mix, width=width) for width in (0.9, 1.2)}
    cases(target, "doors", variants, DOORS_SWEEP, ["flow", "squeeze_90"], arguments)


def row(target, arguments):
    """Prints what arrives of a push."""
    (target / "lane.xml").write_text(LANE)
    cases(target, "row", {"": lambda mix: ROW.format(mix=mix)}, ROW_SWEEP, ["before", "arrives"], arguments)


CASES = {"covered": covered, "pressed": pressed, "doors": doors, "row": row}


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
