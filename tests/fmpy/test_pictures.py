"""The pictures of the pages: each has a command that makes it, and is what this command draws today.

What is cheap is drawn again. Of the others, a part of the numbers is computed again, or the picture says of what it was
drawn. docs/development.md, "Pictures", says how to make each again.
"""

import csv
import hashlib
import importlib.util
import io
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import limited
import pages
import pytest
from conftest import SHARED
from crowd import REPOSITORY, TRIAL_PUSH
from drawn import differing, pixels
from test_pages import shown_in

DOCS = REPOSITORY / "docs"
DIGESTS = DOCS / "pictures.digests"
#: Each command may take so long [s].
LIMIT = 600
GUIDE = ["push", "hall", "flow"]
PHYSICS = ["collision", "speed"]
# Drawings without numbers of a run: they are edited, not made.
BY_HAND = {f"docs/guide/physics_{name}.svg" for name in ("body", "contact", "law", "step", "shortlist")}
VALIDATION = ["rimea_6", "rimea_9", "rimea_12", "single_file", "corridor", "bottleneck", "faster", "peer"]
SCENES = ["concert", "platform", "stadium"]
STANDARDS = ["corner", "ring", "counterflow", "routes", "large_corner"]
# By picture: the file that makes it, and what this file says of it.
MADE_BY = {
    **{f"docs/{name}.png": ("docs/pictures.sh", f'"$to/{name}.png"') for name in ("push", "balance", "crowd", "people_kinds", "room", "measured", "flow", "turnstile", "barrier")},
    **{f"docs/scene_{name}.png": ("docs/pictures.sh", f'"$to/scene_{name}.png"') for name in SCENES},
    "docs/scene_trains.png": ("docs/pictures.sh", '"$to/scene_trains.png"'),
    **{f"docs/standards_{name}.svg": ("examples/standards/book.py", f"def draw_{name}(") for name in STANDARDS},
    **{f"docs/guide/{name}.png": ("docs/pictures.sh", f'"$to/guide/{name}.png"') for name in GUIDE},
    # crates/people/tests/physics.rs compares them.
    **{f"docs/guide/physics_{name}.svg": ("crates/people/tests/physics.rs", f'"physics_{name}.svg"') for name in PHYSICS},
    **{f"docs/lab_{name}.png": ("docs/lab_pictures.py", f'"{name}": ') for name in ("run", "3d", "kinds", "room", "person", "exits", "compare", "sweep")},
    **{f"docs/validation_{name}.svg": ("examples/validation.py", f'"{name}": {name}') for name in VALIDATION},
    **{f"docs/validation_{name}.svg": ("examples/experiments.py", f'"validation_{name}.svg"') for name in ("experiments", "lanes")},
    "docs/reference_growth.svg": ("reference/growth.py", "reference_growth.svg"),
    "docs/door_width.svg": ("examples/door_width.py", '"door_width.svg"'),
    "docs/calibration.png": ("examples/calibrate.py", '"calibration.png"'),
    "docs/waves.png": ("examples/waves.py", '"waves.png"'),
    "docs/guide/queue.png": ("examples/coupling/jupedsim_queue.py", "`--plot docs/guide/queue.png`"),
    "docs/guide/platform.png": ("examples/coupling/sumo_platform.py", "`--plot docs/guide/platform.png`"),
}


def test_every_picture_has_a_command_and_a_page():
    shown = {picture for page in pages.PAGES for picture in pages.pictures(page)}
    there = {path.relative_to(REPOSITORY).as_posix() for kind in ("png", "svg", "gif") for path in DOCS.rglob(f"*.{kind}")}
    assert shown <= there, f"there is no {shown - there}"
    assert shown >= there, f"no page shows {there - shown}"
    assert set(MADE_BY) == there - BY_HAND, f"without a command, or a command without a picture: {set(MADE_BY) ^ there}"
    for picture, (file, words) in MADE_BY.items():
        assert words in (REPOSITORY / file).read_text(), f"{file} does not make {picture}"


@pytest.mark.long
@pytest.mark.parametrize("name", ["push", "balance", "crowd", "people_kinds", "scenes", "trains", "room", "guide", "measured", "flow", "turnstile", "barrier"])
def test_a_picture_is_what_pictures_sh_draws(lemons, tmp_path, name):
    if name == "measured" and not (SHARED / "data/push_wed").is_dir():
        pytest.skip("../shared is absent")
    environment = {**os.environ, "LEMONS": str(lemons), "PYTHON": sys.executable}
    command = ["bash", DOCS / "pictures.sh", tmp_path, name]
    done = limited.run(command, LIMIT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    if name == "scenes":
        (concert,) = (block for block in pages.blocks("docs/scenes.md") if "density before the stage" in block.first)
        missing = shown_in(concert.text, done.stdout)
        assert missing is None, f"{concert.place}: the page shows\n{missing}\nThe script prints\n{done.stdout}"
    # Matplotlib draws letters with what a machine has; our own pictures do not.
    most = 0.01 if name in ("flow", "turnstile", "barrier") else 0.0005
    several = {"guide": [f"guide/{each}.png" for each in GUIDE], "scenes": [f"scene_{each}.png" for each in SCENES], "trains": ["scene_trains.png"]}
    for file in several.get(name, [f"{name}.png"]):
        part = differing(pixels(tmp_path / file), pixels(DOCS / file)).mean()
        assert part <= most, f"docs/{file} is old ({part:.2%} of its pixels differ): docs/pictures.sh docs {name}"


def description(picture):
    """What a picture in SVG says of its numbers."""
    found = ElementTree.parse(picture).find(".//{http://purl.org/dc/elements/1.1/}description")
    assert found is not None, f"{picture.name} does not say what it was drawn from: make it again"
    return found.text


@pytest.mark.long
def test_the_widths_of_a_door(lemons, tmp_path):
    """Some of the runs of the picture, made again."""
    runs = {(row["width"], row["seed"]): row for row in csv.DictReader(io.StringIO(description(DOCS / "door_width.svg")))}
    assert len(runs) == 100
    environment = {**os.environ, "LEMONS": str(lemons)}
    command = [sys.executable, REPOSITORY / "examples/door_width.py", "few", "--widths", "1.0", "1.6", "--seeds", "1"]
    done = limited.run(command, LIMIT, cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    again = list(csv.DictReader(io.StringIO(description(tmp_path / "few/door_width.svg"))))
    assert len(again) == 2
    old = [row for row in again if runs[row["width"], row["seed"]] != row]
    assert not old, f"docs/door_width.svg is old: today {old}"


def script(name):
    spec = importlib.util.spec_from_file_location(name, REPOSITORY / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def tables_of(name):
    """The tables of a figure in docs/validation.md, as text."""
    return re.search(rf"<!-- {name} -->\n\n(.*?)\n\n<!-- /{name} -->", pages.text_of("docs/validation.md"), re.DOTALL)[1]


@pytest.mark.long
def test_tables_of_the_validation_are_those_of_today(lemons, tmp_path, monkeypatch):
    """The cheapest one whole, of another one a cell."""
    monkeypatch.setenv("LEMONS", str(lemons))
    validation = script("validation")
    tables, _ = validation.rimea_1(tmp_path)
    assert "\n\n".join(tables) == tables_of("rimea_1"), "python examples/validation.py --all --write (rimea_1 is old)"
    crossed = [validation.leave(tmp_path, "collision-free-speed", 1.2, 80, seed) for seed in range(1, 5)]
    cell = validation.mean_and_spread(validation.steady(times) / 1.2 for times in crossed)
    head, _, *rows = map(pages.cells, tables_of("bottleneck").splitlines())
    (row,) = (row for row in rows if row[0] == "1.2")
    column = next(k for k, name in enumerate(head) if name.startswith("collision-free-speed"))
    assert row[column] == cell, "python examples/validation.py --all --write (bottleneck is old)"


def mechanics(lemons, directory):
    """Where a push brings five people, to a micrometre: the text differs if the mechanics does."""
    words = ["--until", "1", "--set", "TimeStepMechanical=1e-4", "-o", "-"]
    done = limited.run([lemons, "run", TRIAL_PUSH, *words], LIMIT, cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    poses = [[f"{float(row[name]):.6f}" for name in ("x", "y", "theta")] for row in csv.DictReader(io.StringIO(done.stdout))]
    assert len(poses) == 5 * 21
    return repr(poses)


def test_pictures_that_take_minutes_are_of_what_they_were_drawn_from(lemons, tmp_path):
    """A picture of the validation belongs to its tables, which the same command writes. That of the calibration needs
    measured data: it may be old if its script or the mechanics has changed; that of waves, if its script, legs or the mechanics have.
    Those of the couplings need what is not everywhere, and a minute: they may be old if their scripts or the mechanics have changed."""
    of = {f"validation_{name}.svg": tables_of(name) for name in VALIDATION}
    # A picture of the standards belongs to what the page says of its scene.
    told = pages.text_of("docs/standards.md").splitlines()
    of |= {f"standards_{name}.svg": "\n".join(line for line in told if f"(#{name.replace('_', '-')})" in line) for name in STANDARDS}
    of["calibration.png"] = (REPOSITORY / "examples/calibrate.py").read_text() + mechanics(lemons, tmp_path)
    legs = (REPOSITORY / "crates/decision/src").glob("balance*/*.rs")
    legs = [*legs, REPOSITORY / "crates/decision/src/balance.rs"]
    of["waves.png"] = "".join(path.read_text() for path in [REPOSITORY / "examples/waves.py", *sorted(legs)]) + mechanics(lemons, tmp_path)
    coupling = REPOSITORY / "examples" / "coupling"
    for picture, name in [("guide/queue.png", "jupedsim_queue"), ("guide/platform.png", "sumo_platform")]:
        of[picture] = "".join((coupling / f"{file}.py").read_text() for file in (name, "walking")) + mechanics(lemons, tmp_path)
    digests = {}
    for picture, text in of.items():
        digests[picture] = hashlib.sha256(text.encode() + (DOCS / picture).read_bytes()).hexdigest()
    if os.environ.get("PICTURES") == "made":
        DIGESTS.write_text("".join(f"{digest}  {picture}\n" for picture, digest in digests.items()))
    kept = dict(reversed(line.split()) for line in DIGESTS.read_text().splitlines())
    old = [picture for picture in of if kept.get(picture) != digests[picture]]
    assert not old and kept.keys() == of.keys(), f"may be old: {old}; docs/development.md, Pictures"
