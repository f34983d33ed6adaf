"""Squeeze before a door with stiff and with soft chests, and with longer mechanical steps, by `lemons sweep`.

    python examples/soft_chest.py soft_chest

makes the Trials in the directory `soft_chest` (80 people in a room of 8 m by 6 m with a door of 1 m, by `lemons crowd`
with both materials), runs `lemons sweep`, and prints the least, the median and the greatest number of all crowds. With
`--times` it measures the processor time of one crowd, too. Needs the command `lemons` (or its path in the variable LEMONS).
"""

import argparse
import csv
import os
import resource
import statistics
import subprocess
from pathlib import Path

LEMONS = os.environ.get("LEMONS", "lemons")
MATERIALS = ["human_naked", "human_soft"]
SWEEP = """\
# Each Trial is a room: its people have a material, and its crowd is that of a seed.
trial = "room_{{material}}_{{seed}}"
until = "left"

[parameters]
material = {materials}
TimeStepMechanical = {steps}
seed = {{ from = 1, to = {seeds} }}

[lines]
# Along the wall with the door: [m]
door = [8, 1, 8, 5]

[measures]
# s: until everybody is through the door
last = {{ line = "door", direction = "right", number = "evacuation_time" }}
# N: of the person who has most
peak = {{ squeeze = "peak", across = "max" }}
tenth = {{ squeeze = "largest_mean", over = 0.1, across = "max" }}
second = {{ squeeze = "largest_mean", over = 1, across = "max" }}
# N: of half of the people
half = {{ squeeze = "largest_mean", over = 1, across = "median" }}
# m: the deepest overlap
overlap = {{ of = "peak_overlap", take = "max" }}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for Trials and results")
parser.add_argument("--steps", type=float, nargs="+", default=[1e-4, 1e-3], help="mechanical steps, in s")
parser.add_argument("--seeds", type=int, default=20, help="crowds of each material")
parser.add_argument("--threads", default="2", help="runs at a time")
parser.add_argument("--times", action="store_true", help="measure the processor time, too")


def main() -> None:
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True)
    crowd = [LEMONS, "crowd", "--number", "80", "--box", "8x6", "--door", "8,3,1", "--leave"]
    for material in MATERIALS:
        for seed in range(1, given.seeds + 1):
            room = given.target / f"room_{material}_{seed}"
            if not room.exists():
                command = [*crowd, "--material", material, "--seed", str(seed), "-o", room]
                subprocess.run(command, check=True, capture_output=True)
    (given.target / "sweep.toml").write_text(SWEEP.format(materials=MATERIALS, steps=given.steps, seeds=given.seeds).replace("'", '"'))
    subprocess.run([LEMONS, "sweep", "sweep.toml", "-o", "results.csv", "--threads", given.threads], check=True, cwd=given.target)
    with (given.target / "results.csv").open() as file:
        runs = list(csv.DictReader(line for line in file if not line.startswith("#")))
    for material in MATERIALS:
        for step in given.steps:
            these = [run for run in runs if run["material"] == material and float(run["TimeStepMechanical"]) == step]
            print(f"{material} {step:g} s, {len(these)} crowds: least, median, greatest")
            for name in ("last", "peak", "tenth", "second", "half", "overlap"):
                values = [float(run[name]) for run in these]
                print(f"    {name:8}" + "".join(f"{of(values):10.4g}" for of in (min, statistics.median, max)))
    if given.times:
        times(given)


def times(given: argparse.Namespace) -> None:
    """Prints processor times [s] of the first crowd: medians of five runs, and of their ratios to the first case."""
    cases = [(material, step) for material in MATERIALS for step in given.steps]
    rounds = [[processor_time(given.target / f"room_{material}_1", step) for material, step in cases] for _ in range(5)]
    for k, (material, step) in enumerate(cases):
        spent = statistics.median(each[k] for each in rounds)
        ratio = statistics.median(each[k] / each[0] for each in rounds)
        print(f"{material} {step:g} s: processor time {spent:.2f} s, ratio {ratio:.2f}")


def processor_time(trial: Path, step: float) -> float:
    def spent() -> float:
        of = resource.getrusage(resource.RUSAGE_CHILDREN)
        return of.ru_utime + of.ru_stime

    before = spent()
    subprocess.run([LEMONS, "measure", trial, "--until", "left", "--set", f"TimeStepMechanical={step}"], check=True, capture_output=True)
    return spent() - before


if __name__ == "__main__":
    main()
