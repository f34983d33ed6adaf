"""What the tests share: the command, FMUs made with it, instances of them, the engine without FMI."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import documented
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH, Crowd, ids_of, read_table
from documented import tool_version
from fmpy import extract

import built

SHARED = REPOSITORY.parent / "shared"


@pytest.fixture
def row(request):
    """`row(package, tried, result)` at the end of a test makes a row of docs/fmi.md: what a tool did with our FMUs.

    The words must stay the same from run to run.
    """

    def row(package, tried, result):
        test = f"{request.path.name}::{request.node.originalname}"
        line = [f"{package} {tool_version(package)}", tried, result, f"`{test}`"]
        request.node.user_properties.append(("row", line))

    return row


class Rows:
    """The table of tools in docs/fmi.md, of all tests: the reports bring their rows, also from other processes."""

    def __init__(self, config):
        self.lines = []
        self.files = set()
        self.without = set()  # tests that make rows and made none: skipped or failed
        named = any("::" in str(argument) for argument in config.args)
        self.selected = named or bool(config.option.keyword or config.option.markexpr or config.option.lf)

    def pytest_runtest_logreport(self, report):
        self.files.add(report.nodeid.split("::")[0].rsplit("/", 1)[-1])
        if report.when == "teardown":
            names = [name for name, _ in report.user_properties]
            if "makes rows" in names and "row" not in names:
                self.without.add(report.nodeid)
            self.lines += [tuple(line) for name, line in report.user_properties if name == "row"]

    def pytest_sessionfinish(self, session):
        if session.config.option.collectonly:
            return
        files = {path.name for path in Path(__file__).parent.glob("test_*.py")}
        whole = not self.selected and not self.without and self.files >= files
        # In any order of tests.
        lines = sorted(set(self.lines), key=lambda line: (line[0].lower(), line[3], line[1:]))
        try:
            documented.check("tools", ["tool", "tried", "result", "test in `tests/fmpy`"], lines, whole)
        except AssertionError as error:
            self.error = error
            session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED

    error = None

    def pytest_terminal_summary(self, terminalreporter):
        if self.error:
            terminalreporter.write_line(str(self.error), red=True)


# The package of this clone, for the tests and for all that they start.
PACKAGE = str(REPOSITORY / "python" / "src")
sys.path.insert(0, PACKAGE)
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [PACKAGE, os.environ.get("PYTHONPATH")]))


def pytest_configure(config):
    # With `-n` only the process that starts the others sees all reports.
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Rows(config))


def pytest_runtest_setup(item):
    if "row" in item.fixturenames:
        item.user_properties.append(("makes rows", True))


@pytest.fixture(scope="session")
def lemons():
    """Path of the command."""
    if not built.LEMONS.is_file():
        pytest.exit(built.missing(built.LEMONS), returncode=1)
    return built.LEMONS


@pytest.fixture
def shared():
    """The directory with measured data, which is not in the repository."""
    if not SHARED.is_dir():
        pytest.skip("../shared is absent")
    return SHARED


def pack_into(lemons, path, trials, options):
    command = [lemons, "pack", *trials, "-o", path, "--force", *options]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return path


@pytest.fixture
def pack(lemons, tmp_path):
    """Packs Trial directories into an .fmu."""

    def pack(*trials, options=()):
        return pack_into(lemons, tmp_path / f"{trials[0].name}.fmu", trials, options)

    return pack


@pytest.fixture
def decide(lemons, tmp_path):
    """Makes a Decision FMU."""

    def decide(*options, trial=TRIAL_DOOR):
        path = tmp_path / f"decision {len(list(tmp_path.iterdir()))}.fmu"
        subprocess.run([lemons, "decide", trial, "-o", path, *options], check=True, capture_output=True, text=True)
        return path

    return decide


@pytest.fixture(scope="session")
def push_fmu(lemons, tmp_path_factory):
    """The default FMU."""
    return pack_into(lemons, tmp_path_factory.mktemp("push") / "crowd.fmu", [TRIAL_PUSH], [])


@pytest.fixture(scope="session")
def push_directory(push_fmu):
    """The default FMU, extracted; not to be changed."""
    return extract(push_fmu, push_fmu.parent / "extracted")


@pytest.fixture
def instantiate(tmp_path):
    """Instantiates an .fmu or an extracted one; frees the instances at the end of the test."""
    crowds = []

    def instantiate(fmu, **options):
        if Path(fmu).is_file():
            fmu = extract(fmu, tmp_path / f"extracted {len(crowds)}")
        crowds.append(Crowd(fmu, **options))
        return crowds[-1].instantiate()

    yield instantiate
    for crowd in crowds:
        crowd.free()


@pytest.fixture
def pushed(lemons, tmp_path):
    """What `lemons run` sees after each step of the push, as `masters.run` returns it."""

    def pushed(steps, step):
        table = tmp_path / "pushed.csv"
        command = [lemons, "run", TRIAL_PUSH, "--step", repr(step), "--until", repr(steps * step), "-o", table]
        subprocess.run(command, check=True, capture_output=True)
        seen = read_table(table.read_text(), ids_of(TRIAL_PUSH))
        assert len(seen) == steps + 1
        return [[number for agent in agents for number in agent] for _, agents in seen[1:]]

    return pushed


@pytest.fixture
def push(instantiate, push_directory):
    """An instance of the default FMU."""
    return instantiate(push_directory)


@pytest.fixture(scope="session")
def engine_direct():
    """Runs a Trial on the engine without FMI; the trajectories as CSV text."""
    if not shutil.which("cargo"):
        pytest.skip("cargo is absent")
    # Not --release: `cargo test` has built it in another profile, and examples have other dependencies than the command,
    # which a release build here would make build anew each time. The bits do not depend on the profile.
    profile, directory = ("dev", "debug") if built.PROFILE == "release" else (built.PROFILE, built.PROFILE)
    command = ["cargo", "build", "--quiet", "--workspace", "--all-features", "--example", "engine_direct"]
    subprocess.run([*command, "--profile", profile, "--target-dir", built.TARGET], check=True, cwd=REPOSITORY)

    def engine_direct(trial, steps, *options):
        command = [built.TARGET / directory / "examples" / "engine_direct", trial, "--steps", str(steps), *options]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    return engine_direct
