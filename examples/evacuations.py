"""Does everybody get out? Three rooms, four models of walking, 20 seeds each, by one `lemons sweep`.

    python examples/evacuations.py evacuations

makes the Trials in the directory `evacuations`, runs them until everybody has left, and prints how many runs emptied their
room, and when. People have a friction of 0.4 with each other, with which they can form arches in doors:

- door: the 30 people of `resources/Trial_door`, a door of 0.9 m;
- pillar: 30 people in 6 m by 5 m, a pillar in front of a door of 1 m;
- desks: 40 people in 8 m by 6 m, two rows of desks, two doors of 0.9 m;
- counterflow, only if it is named by --rooms: 60 people in 12 m by 4 m, a door of 1.2 m at each end. Each half leaves by the
  door of the other half.

If it is stopped, the same command goes on where it was. Needs the command `lemons` (or its path in the variable LEMONS)
and pandas.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd

LEMONS = os.environ.get("LEMONS", "lemons")
MODELS = ["straight", "collision-free-speed", "social-force", "rotational"]
TRIAL_DOOR = Path(__file__).resolve().parent.parent / "resources" / "Trial_door"
#: The exit lies behind the door. [m]
DECISION = """\
model = "{model}"
seed = {seed}
exits = [{{ name = "door", line = [[12, 1.5], [12, 3.5]] }}]
"""
#: The outer wall first, then what stands in the room: opposite corners [m]. Doors: x, y, width [m].
ROOMS = {
    "pillar": (30, [(0, 0, 6, 5), (4.6, 2.2, 5.2, 2.8)], ["6,2.5,1"]),
    "desks": (40, [(0, 0, 8, 6), (1.5, 1.2, 6, 1.8), (1.5, 3, 6, 3.6)], ["8,1,0.9", "8,5,0.9"]),
    "counterflow": (60, [(0, 0, 12, 4)], ["0,2,1.2", "12,2,1.2"]),
}
SWEEP = """\
trial = "{{room}}_{{model}}_{{seed}}"
until = "left"

[parameters]
room = {rooms}
model = {models}
seed = {{ from = 1, to = {seeds} }}

[measures]
# N: the greatest mean squeeze of a person over a second
squeeze = {{ squeeze = "largest_mean", over = 1, across = "max" }}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for Trials and results")
parser.add_argument("--rooms", nargs="+", choices=["door", *ROOMS], default=["door", "pillar", "desks"])
parser.add_argument("--models", nargs="+", choices=MODELS, default=MODELS)
parser.add_argument("--seeds", type=int, default=20, choices=range(2, 10001), metavar="N", help="crowds of each room and model, at least 2")
parser.add_argument("--threads", default="2", help="runs at a time")


def main() -> None:
    given = parser.parse_args()
    given.target.mkdir(exist_ok=True)
    for room in given.rooms:
        for model in given.models:
            for seed in range(1, given.seeds + 1):
                trial = given.target / f"{room}_{model}_{seed}"
                if not trial.exists():
                    make(trial, room, model, seed)
    names = {"rooms": given.rooms, "models": given.models, "seeds": given.seeds}
    (given.target / "sweep.toml").write_text(SWEEP.format(**names))
    sweep = [LEMONS, "sweep", "sweep.toml", "-o", "results.csv", "--threads", given.threads]
    subprocess.run(sweep, check=True, cwd=given.target)
    table = pd.read_csv(given.target / "results.csv", comment="#")
    tell(table)
    if not table["ended"].notna().all():
        sys.exit("in some runs somebody has not left (no number in the column ended)")


def make(trial: Path, room: str, model: str, seed: int) -> None:
    """Complete or not at all: a killed program must not leave half a Trial."""
    half = trial.with_name(f".{trial.name}")
    shutil.rmtree(half, ignore_errors=True)
    if room == "door":
        shutil.copytree(TRIAL_DOOR, half)
        # People of `lemons crowd` have this friction with each other.
        materials = half / "static" / "Materials.xml"
        text, changed = re.subn(r'KineticFriction="0.05"', 'KineticFriction="0.4"', materials.read_text())
        assert changed == 1, materials
        materials.write_text(text)
        (half / "decision.toml").write_text(DECISION.format(model=model, seed=seed))
    else:
        people, boxes, doors = ROOMS[room]
        walls = trial.with_name(f"{room}.xml")
        walls.write_text(geometry(boxes))
        crowd = [LEMONS, "crowd", "--number", str(people), "--geometry", walls, "--leave", "--model", model]
        crowd += [word for door in doors for word in ("--door", door)]
        subprocess.run([*crowd, "--seed", str(seed), "-o", half], check=True, capture_output=True)
    if room == "counterflow":
        middle = ROOMS[room][1][0][2] / 2
        places = re.findall(r'<Agent Id="(\w+)">\s*<Kinematics Position="([^,]+),', (half / "dynamic" / "AgentDynamics.xml").read_text())
        assert len(places) == people
        with open(half / "decision.toml", "a") as file:
            file.writelines(f'\n[agents.{person}]\nexit = "door {int(float(x) < middle)}"\n' for person, x in places)
    half.rename(trial)


def geometry(boxes: list[tuple[float, float, float, float]]) -> str:
    """Closed walls around these boxes [m], as in a Geometry.xml."""
    _, _, width, depth = boxes[0]
    lines = ["<Geometry>", f'  <Dimensions Lx="{width}" Ly="{depth}"/>']
    for k, (x0, y0, x1, y1) in enumerate(boxes):
        lines.append(f'  <Wall Id="{k}" MaterialId="concrete">')
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
        lines += [f'    <Corner Coordinates="{x},{y}"/>' for x, y in corners]
        lines.append("  </Wall>")
    return "\n".join([*lines, "</Geometry>", ""])


def tell(table: pd.DataFrame) -> None:
    of_each = table.groupby(["room", "model"], sort=False)
    print(
        of_each.agg(
            runs=("ended", "size"),
            emptied=("ended", "count"),
            first=("ended", "min"),
            median=("ended", "median"),
            last=("ended", "max"),
            squeeze=("squeeze", "median"),
        )
        .round(1)
        .to_string()
    )
    print(f"everybody got out in {table['ended'].count()} of {len(table)} runs (times in s, squeeze in N)")


if __name__ == "__main__":
    main()
