"""Three scenes with kinds of people: a family concert, a platform with luggage, a stadium row with wheelchairs (docs/scenes.md).

    cargo build --release
    python examples/scenes/scenes.py concert out             # makes the Trial out/concert, runs it, prints what it measured
    python examples/scenes/scenes.py all out --pictures docs # all of them, and their pictures scene_NAME.png

The standard library and the command `lemons` are all it needs (the command of LEMONS, of the clone, or on the PATH).
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[2]


def lemons(*words):
    built = ROOT / "target" / "release" / "lemons"
    command = os.environ.get("LEMONS") or (str(built) if built.is_file() else shutil.which("lemons"))
    if not command:
        raise SystemExit("there is no command `lemons`: run `cargo build --release`, or name it in LEMONS")
    done = subprocess.run([command, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"lemons {' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout


def make(trial, *words):
    """Makes a Trial by `lemons crowd --leave`. Returns its decision.toml, in which each has the speed of its kind."""
    lemons("crowd", "--leave", "--time-step", 0.02, "-o", trial, "--force", *words)
    return tomllib.loads((trial / "decision.toml").read_text())


def write(trial, head, agents):
    """Writes another decision.toml: keys for everybody, and a table of keys for each."""
    parts = [f"[agents.{number}]\n" + "\n".join(f"{key} = {value}" for key, value in keys.items()) for number, keys in agents.items()]
    (trial / "decision.toml").write_text("\n".join([head, *parts, ""]))


def kinds(trial):
    """The kind of each person, by Id."""
    agents = re.findall(r"<Agent [^>]*>", (trial / "static" / "Agents.xml").read_text())
    found = [(re.search(r' Id="([^"]*)"', agent)[1], re.search(r' Kind="([^"]*)"', agent)) for agent in agents]
    return {number: kind[1] if kind else "adult" for number, kind in found}


def measure(trial, until, *words):
    """Simulates and measures. Returns the summary and the rows of people.csv and gaps.csv."""
    out = trial.with_name(trial.name + "_measures")
    lemons("measure", trial, "--until", until, "-o", out, "--force", *words)
    tables = [list(csv.DictReader((out / name).open())) for name in ("people.csv", "gaps.csv")]
    return json.loads((out / "summary.json").read_text()), *tables


def by_kind(trial, people, column="largest_mean_1"):
    """Lines: how hard each kind was squeezed: the greatest mean over 1 s, median and greatest of the people [N]."""
    of = kinds(trial)
    found = {}
    for row in people:
        found.setdefault(of[row["id"]], []).append(float(row[column]))
    for kind, values in sorted(found.items(), key=lambda item: -median(item[1])):
        yield f"{kind:12} {len(values):4} people {median(values):8.0f} {max(values):8.0f} N   (median, greatest)"


def picture(trial, file, *words):
    if file:
        lemons("plot", trial, "-o", file, "--force", *words)


def concert(out, pictures):
    """160 people before a stage of 8 m: adults, children, adults with a child at the hand. All want to get to the stage's front."""
    trial = out / "concert"
    decision = make(
        *(trial, "--box", "10x9", "--region", "0,0.5,8,8.5", "--number", 160, "--seed", 3),
        *("--mix", "adult=55,child=15,with-child=20,elderly=10", "--exit", "9.5,0.5,9.5,8.5"),
    )
    # The front is 1 m deep. People press with 50 N, some with more, some with less.
    head = 'model = "rotational"\npush = 50.0\npush_sd = 25.0\ngoals = [{ name = "stage", polygon = [[9, 0.5], [10, 0.5], [10, 8.5], [9, 8.5]] }]'
    write(trial, head, decision["agents"])
    summary, people, _ = measure(trial, 40, "--area", "front=8,0.5,10,8.5", "--walls", "--panel-length", "9")
    panels = list(csv.DictReader((out / "concert_measures" / "panels.csv").open()))
    stage = max(panels, key=lambda row: float(row["x1"]) + float(row["x2"]))
    yield f"density before the stage  {summary['areas'][0]['density']['max']:.2f} per m² at most"
    yield f"force on the stage's front {float(stage['load_1']):.0f} N per m (greatest mean over 1 s)"
    yield from by_kind(trial, people)
    picture(trial, pictures and pictures / "scene_concert.png", *("--at", "0,5,15,40", "--columns", 2, "--fill", "kind"))


def platform(out, pictures):
    """63 people on a platform of 24 m x 5 m: 42 board a train by three doors of 1.3 m, every third one waits for another train."""
    trial = out / "platform"
    doors = [word for x in (4, 12, 20) for word in ("--door", f"{x},0,1.3")]
    decision = make(trial, "--box", "24x5", "--number", 63, "--seed", 5, "--mix", "adult=45,suitcase=25,backpack=20,stroller=10", *doors)
    exits = ",\n".join(f"  {{ line = [[{x - 1.5}, -1], [{x + 1.5}, -1]] }}" for x in (4, 12, 20))
    agents = decision["agents"]
    for number in range(0, 63, 3):
        agents[str(number)]["start"] = 3600.0
    write(trial, f'model = "rotational"\nexit_choice = "time"\nexits = [\n{exits},\n]', agents)
    lines = [word for x in (4, 12, 20) for word in ("--line", f"{x}={x + 0.65},0,{x - 0.65},0")]
    summary, people, gaps = measure(trial, 60, *lines)
    of = kinds(trial)
    gone = set()
    for line in summary["lines"]:
        own = max(line["directions"], key=lambda each: each["people"])
        # Who is pushed back has a row in the other direction, too.
        out = [row["id"] for row in gaps if (row["line"], row["direction"]) == (line["name"], own["direction"])]
        bags = sum(of[person] not in ("adult", "backpack") for person in out)
        gone |= set(map(int, out))
        yield f"door at {line['name']:>2} m  {own['people']} people, {bags} of them with a suitcase or a stroller; the last after {own['last']:.1f} s"
    yield f"boarded        {sum(number % 3 > 0 for number in gone)} of 42, and {sum(number % 3 == 0 for number in gone)} who waited was pushed through a door"
    yield from by_kind(trial, people)
    picture(trial, pictures and pictures / "scene_platform.png", *("--at", "0,4,8,16", "--columns", 1, "--fill", "kind", "--view", "-0.2,-1.3,24.2,5.2"))


def stadium(out, pictures):
    """A row of 16 m with places for wheelchairs, a gangway behind it, and one door of 1.5 m; then the same with adults only."""
    words = ("--box", "16x3.4", "--number", 20, "--region", "0.3,0.2,15.7,1.7", "--door", "16,2.5,1.5", "--orientation", "fixed", "--direction", -90)
    for name, mix in (("stadium", "wheelchair=40,adult=50,elderly=10"), ("stadium_adults", "adult=90,elderly=10")):
        trial = out / name
        make(trial, *words, "--seed", 4, "--mix", mix)
        summary, people, gaps = measure(trial, "left", "--line", "door=16,1.75,16,3.25")
        count = list(kinds(trial).values())
        yield f"{name:15} {count.count('wheelchair')} wheelchairs of {len(count)}: the last has left after {summary['left']['last']:.1f} s ({summary['left']['people']} have left)"
        yield from by_kind(trial, people)
        if name == "stadium":
            picture(trial, pictures and pictures / "scene_stadium.png", *("--at", "0,5,10,20", "--columns", 1, "--fill", "kind"))


SCENES = {function.__name__: function for function in (concert, platform, stadium)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=[*SCENES, "all"])
    parser.add_argument("output", type=Path, help="a directory for the Trials and their measures")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="draw scene_NAME.png in this directory")
    arguments = parser.parse_args()
    for name, scene in SCENES.items():
        if arguments.scene in (name, "all"):
            print(f"{name}: {scene.__doc__}")
            for line in scene(arguments.output, arguments.pictures):
                print(f"  {line}", flush=True)


if __name__ == "__main__":
    main()
