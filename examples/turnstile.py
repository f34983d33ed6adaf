"""People who hurry to a narrow door, with and without a turnstile that closes while they are squeezed.

    python examples/turnstile.py turnstile

makes in the directory `turnstile` the Trials of ten crowds (80 people in a hall, which leave through a passage of 2 m, a
room 2.5 m deep and a door of 0.8 m) and the turnstile of examples/controllers/turnstile.c. It connects Decision, turnstile
and crowd, three FMUs of FMI 3.0, in an SSP, runs it twice, and prints for each crowd

- the greatest mean squeeze over a second, of anybody and of half of the people [N],
- the greatest low-passed squeeze beyond the turnstile [N],
- when everybody has left [s], and for how much of this time the turnstile was closed.

Without turnstile means with one that never closes. Needs a C compiler, the command `lemons` (or its path in the variable
LEMONS), and Matplotlib for `--plot`.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

LEMONS = os.environ.get("LEMONS", "lemons")
CONTROLLERS = Path(__file__).resolve().parent / "controllers"
PEOPLE = 80
LINE, DOOR = 9.0, 11.5  # m: x of the turnstile, in the passage, and of the door
LIMIT = 200.0  # N
HALL = f"""\
<?xml version="1.0" encoding="UTF-8"?>
<Geometry>
  <Dimensions Lx="{DOOR}" Ly="6"/>
  <Wall Id="0" MaterialId="concrete">
    <Corner Coordinates="{DOOR},2.6"/><Corner Coordinates="{DOOR},0"/><Corner Coordinates="0,0"/>
    <Corner Coordinates="0,6"/><Corner Coordinates="{DOOR},6"/><Corner Coordinates="{DOOR},3.4"/>
  </Wall>
  <Wall Id="1" MaterialId="concrete"><Corner Coordinates="{LINE},0"/><Corner Coordinates="{LINE},2"/></Wall>
  <Wall Id="2" MaterialId="concrete"><Corner Coordinates="{LINE},6"/><Corner Coordinates="{LINE},4"/></Wall>
</Geometry>
"""
# People in a hurry: a third of the usual time gap, and nobody leaves a gap when standing.
HURRY = "\n[rotational]\ntime_gap = 0.3\nstandstill_gap = 0.0\n"
SETTINGS = [f"turnstile.Line={LINE}", "turnstile.Distance=2", "turnstile.Hysteresis=0.5"]
LIMITS = {"without": "turnstile.Limit=1e9", "with": f"turnstile.Limit={LIMIT}"}

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for Trials, FMUs and results")
parser.add_argument("--seeds", type=int, default=10, help="crowds")
parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the squeeze over time of the first crowd")


def run(target: Path, *words: object) -> str:
    done = subprocess.run(list(map(str, words)), cwd=target, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def make(target: Path, seed: int) -> None:
    """Makes the Trial hall_SEED and hall_SEED.ssp."""
    (target / "hall.xml").write_text(HALL, encoding="utf-8")
    places = ["--geometry", "hall.xml", "--region", "0,0.2,7.5,5.8", "--number", PEOPLE, "--seed", seed]
    leaving = ["--leave", "--exit", f"{DOOR + 1},1,{DOOR + 1},5"]
    run(target, LEMONS, "crowd", *places, *leaving, "-o", f"hall_{seed}", "--force")
    with (target / f"hall_{seed}/decision.toml").open("a", encoding="utf-8") as file:
        file.write(HURRY)
    run(target, sys.executable, CONTROLLERS / "pack_controller.py", "turnstile", "--agents", PEOPLE, "-o", "turnstile.fmu")
    run(target, LEMONS, "decide", f"hall_{seed}", "--fmi", 3, "-o", "decision.fmu", "--force")
    run(target, LEMONS, "pack", f"hall_{seed}", "--fmi", 3, "-o", "crowd.fmu", "--force")
    connections = ["--connection", "decision.Fp=turnstile.Wanted", "--connection", "turnstile.Fp=crowd.Fp"]
    fmus = ["decision.fmu", "turnstile.fmu", "crowd.fmu"]
    run(target, LEMONS, "connect", *fmus, *connections, "-o", f"hall_{seed}.ssp", "--force")


def simulate(target: Path, seed: int, case: str) -> dict[str, list[float]]:
    """Returns times, Squeeze and Open of the turnstile. Tables of the run are in the directory."""
    settings = [word for setting in [*SETTINGS, LIMITS[case]] for word in ("--set", setting)]
    tables = ["-o", f"{case}_{seed}.csv", "--outputs", f"outputs_{case}_{seed}.csv"]
    options = ["--until", "left", "--algorithm", "gauss-seidel", "--every", 5]
    run(target, LEMONS, "run", f"hall_{seed}.ssp", *options, *settings, *tables, "--force")
    with (target / f"outputs_{case}_{seed}.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = {name: [float(row[name]) for row in rows] for name in ("t", "turnstile.Squeeze")}
    return {**columns, "turnstile.Open": [float(row["turnstile.Open"] == "true") for row in rows]}


def measured(target: Path, seed: int, case: str, outputs: dict[str, list[float]]) -> list[float]:
    """Returns the numbers of a row."""
    summary = json.loads(run(target, LEMONS, "measure", f"{case}_{seed}.csv", "--trial", f"hall_{seed}", "--summary", "-"))
    (second,) = (each["mean"] for each in summary["exposure"]["largest_mean"] if each["over"] == 1.0)
    closed = 1.0 - statistics.mean(outputs["turnstile.Open"])
    return [second["max"], second["median"], max(outputs["turnstile.Squeeze"]), summary["left"]["evacuation_time"], closed]


def plot(file: Path, runs: dict[str, dict[str, list[float]]]) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.5, 3.2), layout="constrained")
    for case, colour in [("without", "#c44e52"), ("with", "#4c72b0")]:
        axes.plot(runs[case]["t"], runs[case]["turnstile.Squeeze"], color=colour, lw=1.5, label=f"{case} turnstile")
    opens = runs["with"]["turnstile.Open"]
    axes.fill_between(runs["with"]["t"], 0, 1, where=[o == 0 for o in opens], transform=axes.get_xaxis_transform(),
                      color="#4c72b0", alpha=0.12, lw=0, label="closed")  # fmt: skip
    axes.axhline(LIMIT, color="0.3", ls="--", lw=1, label="limit")
    axes.set(xlabel="time [s]", ylabel="greatest mean squeeze\nbeyond the line [N]", xlim=0, ylim=0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, ncols=2)
    figure.savefig(file, dpi=110)


def main() -> None:
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True)
    print("crowd turnstile   1 s mean: anybody, half [N]   beyond [N]   all left [s]   closed")
    results: dict[str, list[list[float]]] = {case: [] for case in LIMITS}
    for seed in range(1, given.seeds + 1):
        make(given.target, seed)
        runs = {case: simulate(given.target, seed, case) for case in LIMITS}
        for case, outputs in runs.items():
            numbers = measured(given.target, seed, case, outputs)
            results[case].append(numbers)
            show(seed, case, numbers)
        if seed == 1 and given.plot:
            plot(given.plot, runs)
    for name, of in [("least", min), ("median", statistics.median), ("most", max)]:
        for case, rows in results.items():
            show(name, case, [of(column) for column in zip(*rows)])


def show(name: object, case: str, numbers: list[float]) -> None:
    anybody, half, beyond, left, closed = numbers
    print(f"{name!s:6}{case:10}{anybody:18.0f}{half:12.0f}{beyond:13.0f}{left:15.1f}{closed:9.0%}", flush=True)


if __name__ == "__main__":
    main()
