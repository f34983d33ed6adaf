"""Runs the tests of guidelines and standards, and writes what came out: docs/standards.md.

    cargo build --release
    pip install './python[examples]' scipy
    python examples/standards/book.py                 # all tests, and the page: minutes on two cores
    python examples/standards/book.py corridor corner # these scenes only: the rows that they decide are printed
    python examples/standards/book.py --keep DIR      # keeps the numbers of each scene; the next call runs only what is missing

tests.toml has the rows: what is asked, what is expected, and how a scene (scenes.py) is judged, or why there is none.
"""

import argparse
import json
import re
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import scenes  # noqa: E402

HERE = Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs" / "standards.md"
TABLE = tomllib.loads((HERE / "tests.toml").read_text())
VERDICTS = ("passed", "failed", "in part", "measured", "cannot")


# ---- rows and what they are judged by ----


def rows():
    """All rows, with the standard of each."""
    return [{"standard": key, **row} for key in TABLE["standards"] for row in TABLE[key]]


def key(row):
    """The name of a scene with its arguments: rows of several standards share one run."""
    words = " ".join(f"{name}={value}" for name, value in sorted(row.get("with", {}).items()))
    return f"{row['scene']} {words}".strip()


def run(row, work):
    return scenes.SCENES[row["scene"]](work, **row.get("with", {}))


def rounded(value):
    """A number as it is written into --keep: what JSON can hold."""
    if isinstance(value, np.ndarray):
        return [rounded(each) for each in value]
    return value.item() if isinstance(value, np.generic) else value


def shown(text, numbers):
    """A text with the numbers of a scene in it. A list is shown with commas, each as its format says; a mean of nothing is "none"."""

    class Listed(list):
        def __format__(self, form):
            return ", ".join("none" if each != each else format(each, form) for each in self)

    return text.format(**{name: Listed(value) if isinstance(value, list) else value for name, value in numbers.items()})


def broken(row, numbers):
    """What a scene does not hold of the row's limits, in words."""
    words = []
    for limit in row.get("judge", []):
        value = numbers[limit["number"]]
        for side, within, sign in (("min", lambda v, w: v >= w, "at least"), ("max", lambda v, w: v <= w, "at most")):
            # What is not a number is not within.
            if side in limit and not within(value, limit[side]):
                unit = limit.get("unit", "")
                words.append(f"{limit['what']}: {value:.3g}{unit} instead of {sign} {limit[side]:g}{unit}")
    return words


def judged(row, numbers):
    """The verdict of a row that has a scene, and what it says beside it."""
    wrong = broken(row, numbers)
    if wrong:
        return "failed", "; ".join(wrong)
    return row.get("verdict", "passed"), ""


def outcome(row, results):
    """Ours and the verdict, as they are shown."""
    if "scene" not in row:
        return row["why"], f"**{row['verdict']}**"
    numbers = results[key(row)]
    verdict, words = judged(row, numbers)
    ours = shown(row.get("ours") or TABLE["scenes"][row["scene"]]["ours"], numbers)
    if row.get("why"):
        ours += " " + shown(row["why"], numbers)
    return ours, f"**{verdict}**" + (f": {words}" if words else "")


# ---- the page ----


def table(head, lines):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(line) + " |" for line in lines)])


def anchor(heading):
    """The anchor that a heading has on a page."""
    return re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-")


def row_of(row, results):
    ours, verdict = outcome(row, results)
    scene = f" [Scene](#{anchor(row['scene'].replace('_', ' '))})." if "scene" in row else ""
    return [f"{row['id']}: {row['title']}", row["asks"] + scene, row["expected"], ours, verdict]


def counts(results):
    found = {name: dict.fromkeys(VERDICTS, 0) for name in TABLE["standards"]}
    for row in rows():
        verdict = judged(row, results[key(row)])[0] if "scene" in row else row["verdict"]
        found[row["standard"]][verdict] += 1
    return found


def failed(results):
    """The scenes by which a row fails, in the order of the page's scenes. Each must say why."""
    wrong = {row["scene"] for row in rows() if "scene" in row and judged(row, results[key(row)])[0] == "failed"}
    return [scene for scene in TABLE["scenes"] if scene in wrong]


def page(results):
    """docs/standards.md."""
    parts = [TABLE["page"]["head"].strip()]
    found = counts(results)
    names = TABLE["standards"]
    lines = [[f"[{names[name]['name']}](#{anchor(names[name]['name'])})", *(str(found[name][verdict]) for verdict in VERDICTS)] for name in names]
    parts.append(table(["tests", *VERDICTS], lines))
    parts.append(TABLE["page"]["after"].strip())
    parts.append("\n".join(TABLE["scenes"][scene]["fails"].strip() for scene in failed(results)))
    for name, standard in names.items():
        parts.append(f"## {standard['name']}")
        parts.append(standard["about"].strip())
        own = [row_of(row, results) for row in rows() if row["standard"] == name]
        parts.append(table(["test", "what is asked", "expected", "ours", "verdict"], own))
    parts.append("## Scenes\n\n" + TABLE["page"]["scenes"].strip())
    for name, scene in TABLE["scenes"].items():
        parts.append(f"### {name.replace('_', ' ')}")
        parts.append(scene["about"].strip())
        if "picture" in scene:
            parts.append(f"![{scene['picture']}](standards_{name}.svg)")
    parts.append(TABLE["page"]["end"].strip())
    return "\n\n".join(parts) + "\n"


# ---- pictures ----


def draw_corner(panel, numbers, plt):
    panel.plot(*zip(*scenes.validation.CORNER_WALL), color="black", linewidth=1.5)
    for path in numbers["_paths"]:
        panel.plot(*path, linewidth=0.6, color="#CC79A7")
    panel.set(xlabel="x / m", ylabel="y / m", aspect="equal")


def draw_routes(panel, numbers, plt):
    for wall in numbers["_walls"]:
        panel.plot(*zip(*wall), color="black", linewidth=1.2)
    for path, main in zip(numbers["_paths"], numbers["_main"]):
        panel.plot(*path, linewidth=0.8, color="#0072B2" if main else "#D55E00")
    panel.set(xlabel="x / m", ylabel="y / m", aspect="equal")


def draw_ring(panel, numbers, plt):
    density = np.linspace(0.05, 5.4, 200)
    panel.plot(density, scenes.validation.weidmann(density), color="black", linewidth=2, label="Weidmann 1993")
    panel.plot(numbers["densities"], numbers["speeds"], "o-", color="#CC79A7", linewidth=0.8, label="ours")
    panel.set(xlabel="density / m⁻²", ylabel="speed / (m/s)", xlim=(0, None), ylim=(0, None))
    panel.legend(frameon=False)


def draw_counterflow(panel, numbers, plt):
    panel.plot(numbers["oncoming"], numbers["times"], "o-", color="#CC79A7", linewidth=0.8)
    for against, stuck in zip(numbers["oncoming"], numbers["stuck_of_each"]):
        if stuck:
            panel.text(against, 20, f"{stuck} of 2\nstuck", ha="center")
    panel.set(xlabel="people who come against", ylabel="the last of 100 is through / s", xlim=(-5, 108), ylim=(0, None))


def draw_large_corner(panel, numbers, plt):
    panel.plot([50, 0, 0, 20, 20, 52], [34, 34, -6, -6, 14, 14], color="black", linewidth=1.5)
    for path in numbers["_paths"][::5]:
        panel.plot(*path, linewidth=0.3, color="#CC79A7")
    panel.set(xlabel="x / m", ylabel="y / m", aspect="equal")


def draw(results, directory):
    """Draws what a picture says better, from the numbers of the scenes."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "standards", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    from matplotlib import pyplot as plt

    for name, scene in TABLE["scenes"].items():
        if "picture" in scene:
            figure, panel = plt.subplots(figsize=scene["size"], layout="constrained")
            globals()[f"draw_{name}"](panel, next(numbers for each, numbers in results.items() if each.split()[0] == name), plt)
            figure.savefig(directory / f"standards_{name}.svg", metadata={"Date": None})
            plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="*", metavar="SCENE", help=f"run and print only these: {', '.join(scenes.SCENES)}")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep the numbers of each scene here, and take those that are there")
    arguments = parser.parse_args()
    for unknown in set(arguments.scene) - scenes.SCENES.keys():
        parser.error(f"there is no scene {unknown!r}; there are {', '.join(scenes.SCENES)}")
    results = {}
    with tempfile.TemporaryDirectory() as scratch:
        for row in rows():
            if "scene" not in row or key(row) in results or arguments.scene and row["scene"] not in arguments.scene:
                continue
            kept = arguments.keep and arguments.keep / f"{key(row)}.json"
            if kept and kept.is_file():
                results[key(row)] = json.loads(kept.read_text())
                continue
            began = time.monotonic()
            results[key(row)] = {name: rounded(value) for name, value in run(row, Path(scratch)).items()}
            if kept:
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(results[key(row)]))
            print(f"{key(row)}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    if arguments.scene:
        for row in rows():
            if row.get("scene") in arguments.scene:
                print(f"{TABLE['standards'][row['standard']]['name']}, {row_of(row, results)[0]}", *outcome(row, results), sep="\n  ")
        return
    PAGE.write_text(page(results))
    draw(results, PAGE.parent)
    print(PAGE)


if __name__ == "__main__":
    main()
