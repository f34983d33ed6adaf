"""How hard does a queue press on a shut gate, if everybody in it pushes?

    python examples/shut_gate.py gate

150 people stand in a hall of 12 m by 6 m and want to leave by a gate of 2 m, which stays shut. Who waits leans on who is in
front with a force of their own (docs/walking.md). One `lemons sweep` measures, for each push and seed, from 20 to 40 s:

- the load on the gate in all, and on its most loaded panel of 0.5 m (greatest means over 10 s and 1 s);
- the density in front of the gate (2 m broad, 1.5 m deep) and 2.5 to 4 m before it.

Then the squeeze by other people is printed against the distance from the gate, and what the load becomes with other constants
of the push. `--seeds 10` is the table of docs/walking.md (a quarter of an hour on two cores). Needs the command `lemons` (or
its path in the variable LEMONS), numpy and pandas.
"""

import argparse
import os
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
#: [N]
PUSHES = [0, 50, 100, 150, 200, 350]
GATE = """\
box = [12.0, 6.0]
doors = [[12.0, 3.0, 2.0, 900.0, 1000.0]]
number = {people}
leave = true
friction = 0.1
time_step = 0.02
decision = {{ model = "{model}", queue = {queue} }}
"""
#: Wall 1 is the gate.
SWEEP = """\
scenario = "{name}.toml"
until = 40.0

[parameters]
{parameters}
"population.seed" = {{ from = 1, to = {seeds} }}

[areas]
front = [10.5, 2, 12, 4]
middle = [8, 2, 9.5, 4]

[measures]
gate = {{ load = "load_10", wall = "1", whole = true, from = 20.0 }}
panel = {{ load = "load_1", wall = "1", from = 20.0 }}
front = {{ area = "front", number = "voronoi_density", take = "mean", from = 20.0 }}
middle = {{ area = "middle", number = "voronoi_density", take = "mean", from = 20.0 }}
"""
#: The same mean, but other constants.
OTHERS = {
    "everybody alike, 100 N": "{ push = 100.0 }",
    "sd 50 N, new in 20 s": "{ push = { mean = 100.0, sd = 50.0, min = 0.0, max = 200.0 } }",
    "sd 50 N, new in 5 s": "{ push = { mean = 100.0, sd = 50.0, min = 0.0, max = 200.0 }, push_time = 5.0 }",
    "sd 50 N, for ever": "{ push = { mean = 100.0, sd = 50.0, min = 0.0, max = 200.0 }, push_time = 1e6 }",
    "half of them 200 N": "{ push = { mean = 100.0, sd = 1e4, min = 0.0, max = 200.0 } }",
}

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for scenarios and results")
parser.add_argument("--seeds", type=int, default=3)
parser.add_argument("--people", type=int, default=150)


def lemons(*words):
    """Runs the command, and returns what it prints."""
    return subprocess.run([LEMONS, *map(str, words)], check=True, text=True, stdout=subprocess.PIPE).stdout


def sweep(target, name, scenario, parameters, seeds):
    """Runs a sweep, and returns means and half 95 % intervals over the seeds, in kN/m and people per m²."""
    (target / f"{name}.toml").write_text(scenario)
    (target / f"{name}_sweep.toml").write_text(SWEEP.format(name=name, parameters=parameters, seeds=seeds))
    table = target / f"{name}.csv"
    lemons("sweep", target / f"{name}_sweep.toml", "-o", table, "--summary", target / f"{name}_cases.csv", "--over", "population.seed")
    return pd.read_csv(target / f"{name}_cases.csv")


def cells(row):
    """Returns the numbers of a case as text."""
    of = {"gate": 1e-3, "panel": 1e-3, "front": 1, "middle": 1}
    return [f"{row[f'{name}_mean'] * by:.2f} ± {(row[f'{name}_high'] - row[f'{name}_mean']) * by:.2f}" for name, by in of.items()]


def profile(target, push, people):
    """Returns the mean squeeze by others [N] in each metre from the gate, from 20 to 40 s of the first seed."""
    (target / "one.toml").write_text(GATE.format(people=people, model="rotational", queue=f"{{ push = {push:.1f} }}"))
    lemons("crowd", "--scenario", target / "one.toml", "-o", target / "one", "--force")
    lemons("run", target / "one", "--until", 40, "--every", 50, "-o", target / "one.csv", "--force")
    rows = pd.read_csv(target / "one.csv").query("t >= 20")
    distance = np.hypot(12 - rows["x"], np.maximum(np.abs(rows["y"] - 3) - 1, 0))
    by_people = rows["mean_normal_force"] - rows["mean_wall_force"]
    return [by_people[(distance >= k) & (distance < k + 1)].mean() for k in range(5)]


def main():
    """Makes the tables."""
    arguments = parser.parse_args()
    target, seeds, people = arguments.target, arguments.seeds, arguments.people
    target.mkdir(parents=True, exist_ok=True)
    head = f"{'':<24}{'gate':>14}{'its worst panel':>18}{'front':>14}{'middle':>14}"
    print(f"{seeds} seeds: load on the gate (kN/m) and densities (per m²), with 95 % intervals\n{head}")
    scenario = GATE.format(people=people, model="rotational", queue="{ push = 0.0 }")
    table = sweep(target, "gate", scenario, f'"population.decision.queue.push" = {PUSHES}', seeds)
    for _, row in table.iterrows():
        print(f"{row['population.decision.queue.push']:>5.0f} N{'':<17}" + "".join(f"{cell:>15}" for cell in cells(row)))
    straight = sweep(target, "straight", GATE.format(people=people, model="straight", queue="{ push = 0.0 }"), "", seeds)
    print(f"{'straight, without':<23}" + "".join(f"{cell:>15}" for cell in cells(straight.iloc[0])))
    for k, (name, queue) in enumerate(OTHERS.items()):
        seen = sweep(target, f"other_{k}", GATE.format(people=people, model="rotational", queue=queue), "", seeds)
        print(f"{name:<23}" + "".join(f"{cell:>15}" for cell in cells(seen.iloc[0])))
    print("\nmean squeeze by others (N), by the distance from the gate (one seed)\n" + " " * 8 + "".join(f"{f'{k} to {k + 1} m':>10}" for k in range(5)))
    for push in PUSHES:
        print(f"{push:>5} N " + "".join(f"{value:>10.0f}" for value in profile(target, push, people)))


if __name__ == "__main__":
    main()
