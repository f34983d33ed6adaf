"""Groups that stay together: how fast they walk, how near to each other, and how long a door takes them.

    python examples/groups.py groups

makes Trials in the directory `groups` and prints three things (model `rotational`):

- walk: 24 people in the first 12 m of a corridor of 60 m by 8 m, in groups of one size. The drawing leaves some people in
  smaller groups or alone: they are there, but only the members of full groups count. Desired speeds are drawn for each
  person. The speed is that between 25 m and 55 m; beside it are the measured ones of Moussaïd et al., PLoS ONE 5 (2010)
  e10047, figure 2: 1.26 - 0.04 N m/s at low density, 1.24 - 0.08 N m/s at moderate density.
- apart: the mean distance between the members of a group in these runs, and of the same people without groups.
- door: 80 people in 8 m by 6 m leave by a door of 1 m, with a part of them in groups: when all are out, and how long after
  the first one of a group the last one leaves; beside it, of the same people without groups.

Needs the command `lemons` (or its path in the variable LEMONS) and pandas.
"""

import argparse
import itertools
import os
import shutil
import subprocess
import tomllib
from pathlib import Path

import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
#: [m/s] Weidmann 1993, cut at three standard deviations.
SPEEDS = "{ mean = 1.34, sd = 0.26, min = 0.56, max = 2.12 }"
#: Rows are written each so many steps of 0.01 s.
EVERY = 20
#: [m] Where the speed is measured in the corridor.
FROM, TO = 25.0, 55.0

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for Trials and results")
parser.add_argument("--seeds", type=int, default=10, metavar="N", help="crowds of each kind")
parser.add_argument("--sizes", type=int, nargs="+", default=[1, 2, 3, 4])
parser.add_argument("--parts", type=float, nargs="+", default=[0.0, 0.5, 1.0], help="parts of the people in groups at the door")


def lemons(*words: object) -> str:
    return subprocess.run([LEMONS, *map(str, words)], check=True, capture_output=True, text=True).stdout


def write_decision(trial: Path, seed: int, name: str, more: str = "") -> Path:
    """The Trial's own decision.toml with other keys."""
    text = (trial / "decision.toml").read_text()
    kept = [line for line in text.splitlines() if not line.startswith("desired_speed")]
    path = trial.with_name(f"{trial.name}_{name}.toml")
    path.write_text("\n".join([f"desired_speed = {SPEEDS}\nseed = {seed}\n{more}", *kept]))
    return path


def members(trial: Path, decision: Path) -> list[list[int]]:
    """The groups that were drawn: a Trial that goes on from a run names them."""
    begun, later, table = (decision.with_suffix(end) for end in (".begun", ".later", ".begun.csv"))
    shutil.copytree(trial, begun, dirs_exist_ok=True)
    shutil.copy(decision, begun / "decision.toml")
    lemons("run", begun, "--until", 0.05, "-o", table, "--force")
    lemons("export", table, later, "--to", "trial", "--trial", begun, "--force")
    groups = tomllib.loads((later / "decision.toml").read_text()).get("groups", {})
    return [[int(id) for id in group] for group in groups.get("members", [])]


def run(trial: Path, decision: Path) -> pd.DataFrame:
    table = decision.with_suffix(".csv")
    lemons("run", trial, "--decision", decision, "--until", "left", "--every", EVERY, "-o", table, "--force")
    return pd.read_csv(table, comment="#").query("active == 1")


def speeds(walk: pd.DataFrame) -> pd.Series:
    """[m/s] Of each person."""
    first, last = (walk[walk["x"] >= x].groupby("id")[["t", "x"]].first() for x in (FROM, TO))
    return ((last["x"] - first["x"]) / (last["t"] - first["t"])).dropna()


def apart(walk: pd.DataFrame, groups: list[list[int]]) -> float:
    """[m] Mean distance of two members, while both are there."""
    pairs = [pair for group in groups for pair in itertools.combinations(group, 2)]
    of_each = {id: each.set_index("t")[["x", "y"]] for id, each in walk.groupby("id")}
    far = [((of_each[a] - of_each[b]) ** 2).sum(axis=1, min_count=2).pow(0.5).dropna() for a, b in pairs]
    return float(pd.concat(far).mean())


def spread(walk: pd.DataFrame, groups: list[list[int]]) -> float:
    """[s] Mean time from the first one of a group who leaves to the last one."""
    last = walk.groupby("id")["t"].max()
    return float(sum(last[group].max() - last[group].min() for group in groups) / len(groups))


def main() -> None:
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True)
    rows = []
    for seed in range(1, given.seeds + 1):
        trial = given.target / f"corridor_{seed}"
        where = ["--box", "60x8", "--region", "1,0.5,12,7.5", "--door", "60,4,7", "--leave"]
        lemons("crowd", "--number", 24, *where, "--seed", seed, "-o", trial, "--force")
        alone = run(trial, write_decision(trial, seed, "alone"))
        for size in given.sizes:
            sizes = [0] * (size - 2) + [1]
            decision = write_decision(trial, seed, f"groups_of_{size}", f"groups = {{ share = 1, sizes = {sizes} }}" if size > 1 else "")
            walk = run(trial, decision)
            groups = [group for group in members(trial, decision) if len(group) == size]
            counted = list(itertools.chain(*groups)) if size > 1 else sorted(walk["id"].unique())
            row = {"size": size, "seed": seed, "counted": len(counted), "speed": speeds(walk)[counted].mean()}
            if groups:
                row |= {"together": apart(walk, groups), "without": apart(alone, groups)}
            rows.append(row)
    walks = pd.DataFrame(rows).groupby("size").mean().drop(columns="seed")
    walks["measured, low density"] = [1.26 - 0.04 * size for size in walks.index]
    walks["measured, moderate"] = [1.24 - 0.08 * size for size in walks.index]
    print("speed [m/s], and distance of members [m]")
    print(walks.round(2).to_string())
    rows = []
    for seed in range(1, given.seeds + 1):
        trial = given.target / f"door_{seed}"
        lemons("crowd", "--number", 80, "--box", "8x6", "--door", "8,3,1", "--leave", "--seed", seed, "-o", trial, "--force")
        for part in given.parts:
            decision = write_decision(trial, seed, f"part_{part}", f"groups = {{ share = {part} }}")
            walk = run(trial, decision)
            groups = members(trial, decision)
            row = {"part": part, "last": walk["t"].max() + 0.01 * EVERY}
            if groups:
                row |= {"together": spread(walk, groups), "without": spread(run(trial, write_decision(trial, seed, "alone")), groups)}
            rows.append(row)
    doors = pd.DataFrame(rows)
    print("everybody is out after [s], and time from the first of a group to the last [s]")
    of_each = doors.groupby("part")
    print(pd.concat([of_each["last"].agg(["median", "min", "max"]), of_each[["together", "without"]].mean()], axis=1).round(2).to_string())


if __name__ == "__main__":
    main()
