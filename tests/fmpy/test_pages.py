"""The pages for users: each code block is run as the page says, or says here why not; what it prints is what the page shows.

The commands of a page run one after the other in a copy of what a user has: a directory with `resources` and `examples`.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import limited
import pages
import pytest
from crowd import REPOSITORY

# ---- commands that are not run ----

NETWORK = "installs from the network or into this Python; test_the_package_installs and packaging/check.sh install it"
COMPILES = "compiles; the stage of check.sh does it"
MINUTES = "takes minutes"
# Beginnings of commands, on any page.
NOT_RUN_ANYWHERE = {
    "pip install": NETWORK,
    "cargo build": COMPILES,
}
# Beginnings of commands, on one page.
NOT_RUN = {
    ("README.md", "./check.sh"): "it runs this test",
    ("README.md", "lemons lab"): "opens a browser; tests/lab does it",
    ("docs/guide/rust.md", "cargo run --release --example engine_direct"): "compiles; the fixture engine_direct runs it",
    ("python/README.md", "cp target/release/liblemons_native.so"): "check.sh does it",
    ("docs/guide/other-simulators.md", "python examples/coupling/jupedsim_queue.py"): "needs JuPedSim; test_coupling_others.py runs fewer people",
    ("docs/guide/other-simulators.md", "python examples/coupling/sumo_platform.py"): "needs SUMO, and a minute; test_coupling_others.py runs a smaller day",
    ("docs/fmi.md", "component/build.sh"): COMPILES,
    ("docs/fmi.md", "lemons pack resources/Trial_push --fmi 3 --binary wasm32-wasip2"): "needs the component; test_component.py does it",
    ("docs/fmi.md", "python examples/component.py"): "needs the component; test_component.py does it",
    ("docs/lab.md", "lab/build.sh"): COMPILES,
    ("docs/lab.md", "packaging/release.sh"): "needs compilers for all platforms",
    ("docs/lab.md", "lemons lab"): "opens a browser; tests/lab does it",
    ("docs/guide/physics.md", "cargo run --release -p lemons-verify --features bench --example bench"): COMPILES,
    ("docs/step.md", "cargo run --release -p lemons-verify --features bench --example steps"): MINUTES,
    ("docs/balance.md", "python examples/legs.py"): "needs measured data, and minutes; test_balance.py has the models",
    ("docs/balance.md", "python examples/waves.py"): "takes a quarter of an hour; test_balance.py runs a small square",
    ("docs/calibration.md", "python examples/calibrate.py"): "needs measured data, and minutes; test_sweep.py runs its parts",
    ("docs/validation.md", "python examples/validation.py"): "takes minutes; test_walking_models.py runs its quick cases",
    ("docs/reference-cases.md", "python reference/run.py"): "needs engines of others, and minutes; test_reference_cases.py runs ours",
    ("docs/reference-cases.md", "python reference/speed.py"): "needs engines of others, and minutes; test_reference_cases.py runs ours",
    ("docs/reference-cases.md", "python reference/growth.py"): "needs minutes, and 18 GB of memory; test_reference_cases.py has fewer people",
    ("docs/standards.md", "python examples/standards/book.py"): "takes minutes; test_standards.py runs the quick scenes",
    ("docs/scenes.md", "python examples/scenes/scenes.py all"): "test_pictures.py draws them",
    ("docs/scenes.md", "python examples/scenes/scenes.py concert"): "test_pictures.py runs it, and compares what it prints",
    ("docs/scenes.md", "python examples/trains.py"): "takes half a minute; test_sources.py runs the first train",
    ("docs/walking.md", "python examples/door_width.py"): "takes minutes; test_pictures.py makes fewer rooms",
    ("docs/barriers.md", "python examples/barriers.py barriers columns"): "takes minutes; test_barriers.py has fewer seeds",
    ("docs/levels.md", "python examples/levels.py "): "takes minutes; test_levels.py has fewer seeds",
    ("docs/guide/squeeze.md", "cargo test --release -p lemons-people"): COMPILES,
    ("docs/guide/squeeze.md", "python examples/soft_chest.py"): "takes minutes; test_numbers.py makes fewer rooms",
    ("docs/guide/controller.md", "python examples/turnstile.py"): "takes minutes; test_turnstile.py makes one crowd",
    ("docs/walking.md", "python examples/experiments.py"): "needs measured data; docs/validation.md runs it without",
    ("docs/walking.md", "python examples/evacuations.py"): "takes minutes; test_leaving.py makes fewer rooms",
    ("docs/walking.md", "python examples/groups.py"): "takes minutes; test_leaving.py makes fewer crowds",
    ("docs/command.md", "cargo run -p lemons-cli --example reference"): "crates/cli/tests/cli/reference.rs does it",
    ("examples/notebooks/README.md", "jupyter lab"): "opens a browser; test_notebooks.py runs the notebooks",
    ("examples/sweep_cluster.md", "dask"): "starts servers; test_sweep.py starts them so",
    ("examples/sweep_cluster.md", "python examples/sweep_push.py"): "needs these servers; test_sweep.py does it",
}
# What a page takes for granted before a command, and how a user comes to it.
BEFORE = {
    # A room of the user's.
    ("docs/people.md", "lemons crowd --geometry Geometry.xml --region 0,0,8,6 "): "lemons crowd --number 1 --box 8x6 --door 8,3,1 -o empty && cp empty/static/Geometry.xml .",
}
# What a page runs with cargo is run with what cargo has built.
INSTEAD = {"cargo run --release -- ": "lemons "}

# ---- blocks that are no commands for a shell ----

# Blocks of a language that another test looks at.
ELSEWHERE = {
    ("python/README.md", "python"): "test_package.py::test_the_manual_runs",
    ("docs/trial.md", "text"): "test_pages.py::test_the_files_of_a_trial",
    ("docs/reference/trial.md", "xml"): "test_reference_trial.py::test_the_examples_are_of_the_trial",
    ("docs/reference/decision.md", "toml"): "test_reference_toml.py::test_the_example_is_taken",
    ("docs/reference/sweep.md", "toml"): "test_reference_toml.py::test_the_example_is_taken",
    # Equations, and numbers that Rust compares.
    ("docs/guide/physics.md", "text"): "crates/people/tests/physics.rs::the_page_shows_these_numbers",
    # Rust runs them.
    ("docs/guide/rust.md", "rust"): "src/lib.rs::docs/guide/rust.md",
    ("docs/guide/rust.md", "rust,no_run"): "src/lib.rs::docs/guide/rust.md",
}
# By the page and the first line. A block of TOML or XML is written into the file; the first command is run before, the
# second one after it. In the block, texts are replaced, so that less is computed.
ROOMS = "for width in 0.8 1.2; do for seed in 1 2; do lemons crowd --number 20 --box 8x6 --door 8,3,$width --leave --seed $seed -o room_${width}_$seed; done; done"
FILES = {
    ("docs/balance.md", 'balance = "pendulum"'): ("legs/decision.toml", "", "lemons check legs", {}),
    ("docs/people.md", "[mix]"): ("kinds.toml", "", "lemons crowd --number 20 --box 6x6 --custom kinds.toml", {}),
    ("docs/reference/scenario.md", "box = [10, 8]                                # [m]"): (
        "hall.toml",
        "",
        "lemons crowd --scenario hall.toml -o hall",
        {},
    ),
    ("docs/slopes.md", "box = [12, 3]                                # [m]"): ("slopes.toml", "", "lemons crowd --scenario slopes.toml -o slopes", {}),
    ("docs/guide/first-half-hour.md", '<?xml version="1.0" encoding="UTF-8"?>'): ("Geometry.xml", "", "", {}),
    ("docs/guide/sweeps.md", 'trial = "resources/Trial_push"'): ("sweep.toml", "", "", {}),
    ("docs/guide/sweeps.md", 'trial = "room_{width}_{seed}"'): ("rooms.toml", "", "lemons sweep rooms.toml", {}),
    ("docs/measure.md", 'trial = "room_{width}_{seed}"'): (
        "rooms.toml",
        ROOMS,
        "lemons sweep rooms.toml",
        {"[0.8, 1.0, 1.2]": "[0.8, 1.2]", "to = 20": "to = 2"},
    ),
    ("docs/walking.md", 'model = "rotational"               # "straight" is the default'): (
        "two_doors/decision.toml",
        "lemons crowd --number 20 --box 8x6 --door 8,3,1 --door 0,3,1 -o two_doors",
        "lemons check two_doors && lemons run two_doors --until 0.1 -o two_doors.csv",
        {},
    ),
    ("docs/walking.md", "exits = ["): ("times.toml", "", "lemons run two_doors --decision times.toml --until 0.1 -o times.csv", {}),
    ("docs/walking.md", "box = [12, 6]"): ("arrive.toml", "", "lemons crowd --scenario arrive.toml -o arrive", {}),
    ("docs/walking.md", "[queue]"): (
        "queue.toml",
        "",
        "lemons run two_doors --decision queue.toml --until 0.1 -o queue.csv",
        {"[queue]": "waypoints = [{ x = 1.0, y = 1.0 }]\n[queue]"},
    ),
    ("docs/walking.md", "ways = ["): ("stairs.toml", "", "lemons run two_doors --decision stairs.toml --until 0.1 -o stairs.csv", {}),
    ("docs/walking.md", 'groups = { members = [["0", "1"], ["4", "5", "6"]], share = 0.5 }'): (
        "families.toml",
        "",
        "lemons run two_doors --decision families.toml --until 0.1 -o families.csv",
        {"share = 0.5 }": "share = 0.5 }\nwaypoints = [{ x = 1.0, y = 1.0 }]"},
    ),
    ("docs/coupling.md", "desired_speed = 1.34                               # [m/s]; default 1.34"): (
        "ways.toml",
        "",
        "lemons run resources/Trial_door --decision ways.toml --until 0.1 -o ways.csv",
        {},
    ),
    ("docs/coupling.md", 'trial = "door_{width}_{seed}"     # a name in braces: the value of this parameter'): (
        "study.toml",
        "for width in 0.9 1.2; do cp -r resources/Trial_door door_${width}_1; done",
        "lemons sweep study.toml",
        {"[0.7, 0.8, 0.9, 1.0, 1.2]": "[0.9, 1.2]", "to = 20": "to = 1"},
    ),
}
# Blocks that are neither run nor printed, with the reason.
OTHERS = {
    ("docs/guide/rust.md", "[dependencies]"): "of another project",
    ("docs/guide/rust.md", "Agents.xml, Geometry.xml, …                          agent[3].Fp.x      agent[3].Position.x"): "a drawing",
    ("docs/scenes.md", "density before the stage  6.88 per m² at most"): "test_pictures.py compares it",
    ("docs/scenes.md", "until  came by   got out  left by       got in by door     still"): "of examples/trains.py; test_sources.py makes a part of it",
    ("docs/step.md", "error ≈ 5 m × (step / T)²         step = T × √(accuracy / 5 m)"): "an equation",
    ("docs/levels.md", "lemons crowd --number 300 --box 8x8 --direction 0 --orientation towards --speed 1.3 --levels N --seed 3 -o crowd_N"): "needs valgrind, for each N",
    ("docs/install.md", "platforms linux64"): "of a release; packaging/check.sh makes it",
    ("docs/command.md", ""): "generated from the help: a test of crates/cli gives its examples to the command",
}
#: All commands of a page may take so long [s].
LIMIT = 1200
# Numbers that differ from machine to machine, and from run to run.
MACHINE = re.compile(r"^(wall time|real-time factor) .*$")


def exception(page, command):
    """The entry by which a command is not run; None if it is."""
    for begin in NOT_RUN_ANYWHERE:
        if command.startswith(begin):
            return begin
    return next(((where, begin) for where, begin in NOT_RUN if where == page and command.startswith(begin)), None)


def commands(block):
    """The commands of a block, with the program that cargo has built instead of cargo."""
    for command in pages.commands(block.text):
        for begin, instead in INSTEAD.items():
            if command.startswith(begin):
                command = instead + command.removeprefix(begin)
        yield shorter(command)


def shorter(line):
    """A film lasts a second, so that less is computed: each of its frames is drawn in the same way."""
    film = re.search(r"(?:lemons |\.)movie\b.*speed[-_]up[ =]([\d.]+)", line)
    if not film:
        return line
    return re.sub(r'(until[ =])[^ ,]+', rf"\g<1>{film[1]}", line) if "until" in line else f"{line} --until {film[1]}"


class Shell:
    """A directory like that of a user, in which the commands of one page run."""

    def __init__(self, directory, lemons):
        self.directory = directory
        for name in ("resources", "examples", "include", "reference"):
            shutil.copytree(REPOSITORY / name, directory / name, ignore=shutil.ignore_patterns("__pycache__"))
        built = directory / "target/release"
        built.mkdir(parents=True)
        for file in (lemons, *lemons.parent.glob("libcrowd_mechanics.*")):
            (built / file.name).symlink_to(file)
        bin = directory / "bin"
        bin.mkdir()
        (bin / "lemons").symlink_to(lemons)
        (bin / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
        (bin / "python").chmod(0o755)
        # Of the same environment: pythonfmu, dask.
        path = [str(bin), str(Path(sys.executable).parent), os.environ["PATH"]]
        own = {"PATH": os.pathsep.join(path), "LEMONS": str(lemons), "MPLBACKEND": "agg"}
        self.environment = {**os.environ, **own}
        self.script = ["set -e -o pipefail", "trap 'echo \"@@ end\"' EXIT"]
        self.places = []

    def add(self, place, command):
        """What the command prints is told under its number, which is returned."""
        self.places.append((place, command))
        self.script += [f"echo; echo '@@ {len(self.places) - 1}'", command]
        return len(self.places) - 1

    def run(self, limit=LIMIT):
        """What each command printed. Variables that one sets hold for those after it. All together may take `limit` [s]."""
        script = ["bash", "-c", "\n".join(self.script)]
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        try:
            done = limited.run(script, limit, cwd=self.directory, env=self.environment, **streams)
            text, why = done.stdout, f"exit code {done.returncode}" if done.returncode else ""
        except limited.Overdue as overdue:
            # `trap` is not called.
            text, why = f"{overdue.said}\n@@ end\n", f"the page took longer than {limit} s, and was here"
        said = re.split(r"^@@ (?:\d+|end)\n", text, flags=re.MULTILINE)[1:]
        if why:
            place, command = self.places[min(len(said) - 2, len(self.places) - 1)]
            raise AssertionError(f"{place}: {why}: {command}\n{said[-2]}")
        return said


def shown_in(shown, said):
    """None if the lines of a page are those that were printed; `…` alone stands for lines that the page leaves out."""
    masked = [MACHINE.sub(r"\1", line.rstrip()) for line in said.splitlines()]
    parts = re.split(r"^\s*…\s*\n", shown, flags=re.MULTILINE)
    begin = 0
    for part in parts:
        wanted = [MACHINE.sub(r"\1", line.rstrip()) for line in part.strip("\n").splitlines()]
        places = range(begin, len(masked) - len(wanted) + 1)
        place = next((at for at in places if masked[at : at + len(wanted)] == wanted), None)
        if place is None:
            missing = [line for line in wanted if line not in masked] or wanted
            return "\n".join(missing)
        begin = place + len(wanted)
    return None


def session(text):
    """The commands of a block that shows them after `$`, each with what it prints."""
    parts = re.split(r"^\$ (.*)\n", text, flags=re.MULTILINE)
    return list(zip(parts[1::2], parts[2::2], strict=True))


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page in pages.PAGES if pages.blocks(page)])
def test_every_block_is_run_or_says_why_not(page, lemons, tmp_path):
    shell = Shell(tmp_path, lemons)
    compared = []  # the lines of the page, and the numbers of the commands that print them
    last = []
    for block in pages.blocks(page):
        if (page, block.language) in ELSEWHERE or (page, block.first) in OTHERS or (page, "") in OTHERS and block.language == "text":
            continue
        if block.language == "sh":
            numbers = []
            for command in commands(block):
                if exception(page, command) is None:
                    before = [own for (where, begin), own in BEFORE.items() if where == page and command.startswith(begin)]
                    for own in before:
                        shell.add(block.place, own)
                    numbers.append(shell.add(block.place, command))
            last = numbers
        elif block.language == "python":
            text = "".join(map(shorter, block.text.splitlines(keepends=True)))
            last = [shell.add(block.place, f"cat >block.py <<'END'\n{text}END\npython block.py")]
        elif block.language in ("toml", "xml"):
            file = FILES.get((page, block.first))
            assert file, f"{block.place}: nothing says in which file this is, and what reads it"
            name, before, after, replaced = file
            text = block.text
            for old, new in replaced.items():
                assert old in text
                text = text.replace(old, new)
            shell.add(block.place, before or ":")
            shell.add(block.place, f"cat >{name} <<'END'\n{text}END")
            last = [shell.add(block.place, after or ":")]
        elif block.language == "text":
            if block.text.startswith("$ "):
                for command, shown in session(block.text):
                    compared.append((block, shown, [shell.add(block.place, command)]))
            else:
                assert last, f"{block.place}: shows what no command of the page prints"
                compared.append((block, block.text, last))
        elif block.language == "c":
            command = f"cat >block.c <<'END'\n{block.text}END\ncc -Wall -Werror -Iinclude -c block.c"
            shell.add(block.place, command)
        else:
            raise AssertionError(f"{block.place}: what kind of block is {block.language!r}?")
    said = shell.run()
    wrong = []
    for block, shown, numbers in compared:
        missing = shown_in(shown, "".join(said[number] for number in numbers))
        if missing is not None:
            printed = "".join(said[number] for number in numbers)
            wrong.append(f"{block.place}: the page shows\n{missing}\nThe command prints\n{printed}")
    assert not wrong, "\n".join(wrong)


def test_the_files_of_a_trial():
    (listed,) = (block for block in pages.blocks("docs/trial.md") if block.first == "Parameters.xml")
    trial = REPOSITORY / "resources/Trial_push"
    there = {path.relative_to(trial).as_posix() for path in trial.rglob("*.xml")}
    assert set(listed.text.split()) == there


@pytest.mark.long
def test_a_page_that_hangs_says_where(lemons, tmp_path):
    shell = Shell(tmp_path, lemons)
    shell.add("page.md:1", "echo first")
    shell.add("page.md:2", "echo second; sleep 86400 | cat")
    told = r"^page.md:2: the page took longer than 10 s, and was here: echo second; sleep 86400 \| cat\nsecond\n"
    with pytest.raises(AssertionError, match=told):
        shell.run(limit=10)


@pytest.mark.parametrize("page", pages.PAGES)
def test_links_lead_somewhere(page):
    wrong = []
    for link in pages.links(page):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        file = pages.file_of(page, path)
        if not file.exists():
            wrong.append(f"{link}: there is no such file")
        elif anchor and anchor not in pages.anchors(file.relative_to(REPOSITORY.resolve()).as_posix()):
            wrong.append(f"{link}: the page has no such heading")
    assert not wrong, "\n".join([page, *wrong])


# The table of exit codes shows a wrong command line.
@pytest.mark.parametrize("page", [page for page in pages.PAGES if page != "docs/reference/exit-codes.md"])
def test_commands_have_the_options_that_are_named_with_them(page):
    """In a row or line: of `lemons COMMAND --this`, and of `--that` after it."""
    parts = [part.split("\n", 1) for part in pages.text_of("docs/command.md").split("\n## ")[1:]]
    known = {name: set(re.findall(r"--[a-z][a-z-]*", text)) | {"--help"} for name, text in parts}
    wrong = []
    for number, line in pages.prose(page):
        command = None
        for code in re.findall(r"`([^`]+)`", line):
            named = re.match(r"lemons [a-z]+", code)
            command = named[0] if named else command if code.startswith("--") else None
            options = re.findall(r"(?<![\w-])--[a-z][a-z-]*", code) if command in known else []
            wrong += [f"{page}:{number}: {command} has no {option}" for option in options if option not in known[command]]
    assert not wrong, "\n".join(wrong)


def test_links_of_the_wheel_lead_somewhere():
    """Its description is python/README.md, without the other pages of the repository."""
    spec = importlib.util.spec_from_file_location("wheels", REPOSITORY / "packaging/wheels.py")
    wheels = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(wheels)
    project = tomllib.loads((REPOSITORY / "python/pyproject.toml").read_text())["project"]
    text = wheels.metadata(project)
    own = pages.anchors("python/README.md")
    links = pages.LINK.findall(text)
    assert any(link.startswith("https://") for link in links) and "docs/install.md" in text and "../" not in text.split("```")[0]
    assert [link for link in links if not link.startswith("https://") and link.removeprefix("#") not in own] == []


def test_the_exceptions_are_needed():
    """Each is that of a block or a command which is still there."""
    blocks = [block for page in pages.PAGES for block in pages.blocks(page) if block.language == "sh"]
    shells = [(block.page, command) for block in blocks for command in commands(block)]
    entries = {exception(page, command) for page, command in shells}
    assert entries - {None} == {*NOT_RUN_ANYWHERE, *NOT_RUN}
    for page, begin in BEFORE:
        own = [command for where, command in shells if where == page and command.startswith(begin)]
        assert own and not any(exception(page, command) for command in own), f"{page} does not run {begin}"
    for (page, language), test in ELSEWHERE.items():
        file, name = test.split("::")
        of_python = file.startswith("test_")
        text = (Path(__file__).parent / file if of_python else REPOSITORY / file).read_text()
        assert (f"\ndef {name}(" if of_python else name) in text, test
        assert any(block.language == language for block in pages.blocks(page)), f"{page} has no block of {language}"
    for page, first in FILES:
        assert any((block.language, block.first) in (("toml", first), ("xml", first)) for block in pages.blocks(page)), f"{page}: {first}"
    for page, first in OTHERS:
        # Without a first line: all texts of the page.
        own = [block.first if first else "" for block in pages.blocks(page) if first or block.language == "text"]
        assert first in own, f"{page} has no block {first}"
