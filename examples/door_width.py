"""Evacuation time, flow and squeeze against the width of a door: 5 widths, 20 crowds each, by `lemons sweep`.

    python examples/door_width.py door_width

makes the Trials in the directory `door_width` (rooms of 8 m by 6 m with 80 people, made by `lemons crowd`), writes
sweep.toml there, runs `lemons sweep`, and draws `door_width.svg`. If it is stopped, the same command goes on where it was.
Needs the command `lemons` (or its path in the variable LEMONS), pandas and matplotlib.
"""

import argparse
import os
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
SWEEP = """\
# Each Trial is a room: its door is `width` m wide, its crowd is that of a seed.
trial = "room_{{width}}_{{seed}}_{people}_{model}"
until = "left"

[parameters]
width = {widths}
seed = {{ from = 1, to = {seeds} }}

[lines]
# Along the wall with the door: [m]
door = [8, 1, 8, 5]

[measures]
# s: until everybody is through the door
last = {{ line = "door", direction = "right", number = "evacuation_time" }}
# 1/(m s)
flow = {{ line = "door", direction = "right", number = "specific_flow", width = "width" }}
# N: the greatest mean squeeze of a person over a second
squeeze = {{ squeeze = "largest_mean", over = 1, across = "max" }}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for Trials and results")
parser.add_argument("--widths", type=float, nargs="+", default=[0.8, 1.0, 1.2, 1.4, 1.6], help="of the door, in m")
parser.add_argument("--seeds", type=int, default=20, help="crowds of each width")
parser.add_argument("--people", type=int, default=80)
parser.add_argument("--model", default="rotational", help="how people walk")
parser.add_argument("--threads", default="2", help="runs at a time")


def main() -> None:
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True)
    for width in given.widths:
        for seed in range(1, given.seeds + 1):
            room = given.target / f"room_{width}_{seed}_{given.people}_{given.model}"
            if not room.exists():
                crowd = [LEMONS, "crowd", "--number", str(given.people), "--box", "8x6", "--door", f"8,3,{width}"]
                crowd += ["--leave", "--model", given.model, "--seed", str(seed), "-o", room]
                subprocess.run(crowd, check=True, capture_output=True)
    text = SWEEP.format(widths=given.widths, seeds=given.seeds, people=given.people, model=given.model)
    (given.target / "sweep.toml").write_text(text)
    sweep = [LEMONS, "sweep", "sweep.toml", "-o", "results.csv", "--threads", given.threads]
    subprocess.run(sweep, check=True, cwd=given.target)
    draw(given)


def draw(given: argparse.Namespace) -> None:
    table = pd.read_csv(given.target / "results.csv", comment="#")
    wanted = [
        ("last", "everybody is out after [s]"),
        ("flow", "specific flow [1/(m s)]"),
        ("squeeze", "greatest mean squeeze over 1 s [N]"),
    ]
    spread = table.groupby("width")[[name for name, _ in wanted]].quantile([0.0, 0.5, 1.0]).unstack()
    print(spread.round(3).to_string())
    figure, panels = plt.subplots(1, len(wanted), figsize=(9.5, 3.2), layout="constrained")
    for panel, (name, words) in zip(panels, wanted, strict=True):
        panel.plot(table["width"], table[name], ".", color="#4477aa", alpha=0.5, label="a run")
        middle = table.groupby("width")[name].median()
        panel.plot(middle.index, middle, "-o", color="#cc3311", label="median")
        panel.set(xlabel="width of the door [m]", ylabel=words, ylim=(0, None))
        panel.grid(alpha=0.3)
    panels[0].legend()
    # The picture says what it was drawn from: a test computes some of it again.
    runs = table[["width", "seed", "last", "flow", "squeeze"]].to_csv(index=False)
    figure.savefig(given.target / "door_width.svg", metadata={"Date": None, "Description": runs})


if __name__ == "__main__":
    main()
