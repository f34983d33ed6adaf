"""Sixty people press on a barrier that bends, yields and falls: the barrier is an FMU in C, coupled both ways.

    python examples/barrier_gives_way.py DIRECTORY [--plot FILE.png]

The directory gets the Trial, the three FMUs, gate.ssp and the tables of the run. Prints what happened.
"""

import argparse
import csv
import os
import subprocess
import sys
from pathlib import Path

LEMONS = os.environ.get("LEMONS", "lemons")
CONTROLLERS = Path(__file__).resolve().parent / "controllers"
# A door of 2 m that may always be open: the barrier says when it is. Its panel is number 5.
SCENARIO = """\
box = [6.0, 3.0]
doors = [[6.0, 1.5, 2.0, 0.0, 1e9]]
number = 60
regions = [{ corners = [[1.0, 0.0], [6.0, 0.0], [6.0, 3.0], [1.0, 3.0]] }]
seed = 1
leave = true
panel_length = 10.0
[decision.queue]
push = 180.0
"""


def run(target: Path, *words: object) -> str:
    done = subprocess.run([str(word) for word in words], cwd=target, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def make(target: Path) -> None:
    """Makes gate.ssp."""
    (target / "gate.toml").write_text(SCENARIO, encoding="utf-8")
    run(target, LEMONS, "crowd", "--scenario", "gate.toml", "-o", "gate", "--force")
    run(target, sys.executable, CONTROLLERS / "pack_controller.py", "barrier", "-o", "barrier.fmu")
    run(target, LEMONS, "decide", "gate", "-o", "decision.fmu", "--force")
    run(target, LEMONS, "pack", "gate", "-o", "people.fmu", "--force")
    load = ["--connection", "people.barrier[5].Load=barrier.barrier[0].Load"]
    run(target, LEMONS, "connect", "decision.fmu", "barrier.fmu", "people.fmu", *load, "-o", "gate.ssp", "--force")


def simulate(target: Path, algorithm: str = "gauss-seidel", until: float = 15.0, *options: str) -> list[dict[str, str]]:
    """Returns the outputs of the barrier at each step."""
    tables = ["-o", "gate.csv", "--outputs", "outputs.csv", "--force"]
    run(target, LEMONS, "run", "gate.ssp", "--until", until, "--algorithm", algorithm, *tables, *options)
    with (target / "outputs.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def plot(file: Path, rows: list[dict[str, str]], falls: float | None) -> None:
    import matplotlib.pyplot as plt

    figure, (force, bent) = plt.subplots(2, sharex=True, figsize=(7.5, 3.6), layout="constrained")
    times = [float(row["t"]) for row in rows if falls is None or float(row["t"]) <= falls]
    shown = rows[: len(times)]
    force.plot(times, [float(row["barrier.Force"]) / 1000 for row in shown], color="#4c72b0", lw=1)
    force.axhline(3, color="0.3", ls="--", lw=1)
    force.set(ylabel="force of the\nspring [kN/m]", ylim=0)
    for name, colour in [("Deflection", "#4c72b0"), ("Plastic", "#c44e52")]:
        bent.plot(times, [1000 * float(row[f"barrier.{name}"]) for row in shown], color=colour, lw=1, label=name)
    bent.set(xlabel="time [s]", ylabel="bent by [mm]", xlim=0)
    bent.legend(frameon=False)
    for axes in (force, bent):
        axes.spines[["top", "right"]].set_visible(False)
        if falls is not None:
            axes.axvline(falls, color="0.3", lw=1)
    figure.savefig(file, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("target", type=Path)
    parser.add_argument("--plot", type=Path, help="a picture of force and deflection over time")
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True, parents=True)
    make(given.target)
    rows = simulate(given.target)
    yields = next((float(row["t"]) for row in rows if float(row["barrier.Plastic"]) != 0.0), None)
    falls = next((float(row["t"]) for row in rows if row["barrier.door[0].Open"] == "true"), None)
    print(f"yields first at {yields} s, falls at {falls} s")
    if given.plot:
        plot(given.plot, rows, falls)


if __name__ == "__main__":
    main()
