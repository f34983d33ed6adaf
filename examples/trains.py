"""In and out on a platform for ten minutes: who comes by stairs, and who gets out of trains and in.

    python examples/trains.py platform --seeds 3

People come down the stairs at the left at random, each to wait at one of three doors. A train comes every three minutes. From
each door 12 people get out, one every 1.2 s if there is room, and leave by the stairs. Then those who wait get in: at most 15 by
each door, for 30 s. The others wait for the next train. At each row of the run, who has come is there or has left: checked. A
table says what became of everybody, and `--picture FILE` shows the first train. Needs the command `lemons` (or its path in the
variable LEMONS) and pandas.
"""

import argparse
import json
import os
import subprocess
from pathlib import Path

import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
#: [s] When trains open, and when those who wait may get in: from and to, after that.
TRAINS, BOARDING, END = [120.0, 300.0, 480.0], (15.0, 45.0), 600.0
#: [m] Middles of the doors, on the upper side of the platform.
DOORS = [10.0, 20.0, 30.0]
#: People who come to each door by the stairs, how many in a second; who get out, one each so many seconds; who may get in.
WAIT, RATE, OUT, EVERY, MOST = 44, 0.08, 12, 1.2, 15
STAIRS = {"down": [[0.4, 3.4], [2.6, 3.4], [2.6, 5.6], [0.4, 5.6]], "up": [[0.5, 0.4], [0.5, 2.8]]}


def scenario(seed):
    exits, sources = [{"name": "stairs", "line": STAIRS["up"]}], []
    for k, x in enumerate(DOORS):
        # People wait beside the door, and those who get out come through its middle.
        opens = [[train + BOARDING[0], train + BOARDING[1]] for train in TRAINS]
        exits.append({"name": f"door {k}", "line": [[x - 3.2, 5.5], [x - 1.8, 5.5]], "open": opens, "most": MOST})
        times = [round(train + EVERY * n, 3) for train in TRAINS for n in range(OUT)]
        sources.append({"name": f"to door {k}", "polygon": STAIRS["down"], "rate": RATE, "number": WAIT, "exit": f"door {k}"})
        sources.append({"name": f"out of door {k}", "line": [[x - 0.5, 5.1], [x + 0.5, 5.1]], "times": times, "exit": "stairs"})
    return {
        "box": [36.0, 6.0], "seed": seed, "time_step": 0.05, "mix": {"adult": "rest", "suitcase": 20},
        "decision": {"model": "rotational", "exits": exits}, "sources": sources,
    }


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(each)}" for key, each in value.items()) + " }"
    return "[" + ", ".join(map(toml, value)) + "]" if isinstance(value, list) else json.dumps(value)


def call(*words, stdout=False):
    done = subprocess.run([LEMONS, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"lemons {' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout if stdout else done.stderr


def run(out, seed, until):
    """Runs one seed. Returns who is where over time: counts that have come, are there, have left; and what was said."""
    trial, given = out / f"seed_{seed}", out / f"seed_{seed}.toml"
    given.write_text("".join(f"{key} = {toml(value)}\n" for key, value in scenario(seed).items()))
    call("crowd", "--scenario", given, "-o", trial, "--force")
    said = call("run", trial, "--until", until, "--every", 10, "-o", out / f"seed_{seed}.csv", "--force")
    rows = pd.read_csv(out / f"seed_{seed}.csv", usecols=["t", "id", "x", "y", "active"])
    there = rows.pivot(index="t", columns="id", values="active") == 1
    come = there.cummax()
    left = come & ~there
    # Nobody comes back: who is there now and was not before comes for the first time.
    back = there & ~there.shift(fill_value=False) & come.shift(fill_value=False)
    assert not back.to_numpy().any()
    # Who has left by the table is who has left by the measures, which look at the exits.
    summary = json.loads(call("measure", out / f"seed_{seed}.csv", "--trial", trial, "--summary", "-", stdout=True))
    assert summary["left"]["people"] == int(left.iloc[-1].sum())
    return rows, there, come, left, said


def table(rows, there, come, left, said):
    """A line for each train: how many came before, got out, left by the stairs, got in by each door, and stay."""
    last = rows[rows["t"] == rows["t"].max()].set_index("id")
    waits = {k: range(k * (WAIT + OUT * len(TRAINS)), k * (WAIT + OUT * len(TRAINS)) + WAIT) for k in range(len(DOORS))}
    of = lambda seen, ids: int(seen[list(ids)].sum())
    lines, before = [], come.iloc[0]
    ends = [train + BOARDING[1] + 1.0 for train in TRAINS if train + BOARDING[1] < last["t"].iloc[0]] + [last["t"].iloc[0]]
    gone = {k: 0 for k in waits}
    for end in ends:
        now = there.index[there.index <= end + 1e-9][-1]
        inside = {k: of(left.loc[now], ids) for k, ids in waits.items()}
        all_waiting = [i for ids in waits.values() for i in ids]
        out = come.loc[now].sum() - of(come.loc[now], all_waiting)
        up = left.loc[now].sum() - sum(inside.values())
        got_in = " + ".join(f"{inside[k] - gone[k]:2}" for k in waits)
        lines.append(f"{end:6.0f} s {of(come.loc[now], all_waiting):8} {out:8} {up:8}    {got_in} {of(there.loc[now], all_waiting):8}")
        assert all(inside[k] - gone[k] <= MOST for k in waits)
        gone = inside
    return lines


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("--seeds", type=int, default=3)
    arguments.add_argument("--until", type=float, default=END, help="[s]")
    arguments.add_argument("--picture", type=Path, help="of the first seed, about the first train")
    given = arguments.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    print("  until  came by   got out  left by       got in by door     still\n           stairs            stairs      0    1    2        wait")
    for seed in range(1, given.seeds + 1):
        rows, *counts, said = run(given.out, seed, given.until)
        print(f"seed {seed}", *table(rows, *counts, said), sep="\n")
        print(*(line.strip() for line in said.splitlines() if "source" in line), sep="\n")
    if given.picture:
        first = given.out / "seed_1"
        at = ",".join(str(TRAINS[0] + after) for after in (-1, 10, 20, 40))
        call("plot", first.with_suffix(".csv"), "--trial", first, "--at", at, "--columns", 1, "-o", given.picture, "--force")


if __name__ == "__main__":
    main()
