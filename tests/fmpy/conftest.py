"""What the tests share: the command, FMUs made with it, instances of them, the engine without FMI."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from crowd import REPOSITORY, TARGET, TRIAL_PUSH, Crowd
from fmpy import extract

SHARED = REPOSITORY.parent / "shared"


@pytest.fixture(scope="session")
def lemons():
    """Path of the command: the environment's LEMONS, else the release build's."""
    path = Path(os.environ.get("LEMONS") or TARGET / "release" / "lemons").resolve()
    if not path.is_file():
        pytest.exit(f"{path} is missing: cargo build --release --workspace", returncode=1)
    return path


@pytest.fixture
def shared():
    """The directory with measured data, which is not in the repository."""
    if not SHARED.is_dir():
        pytest.skip("../shared is absent")
    return SHARED


def pack_into(lemons, path, trials, options):
    command = [lemons, "pack", *trials, "-o", path, *options]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return path


@pytest.fixture
def pack(lemons, tmp_path):
    """Packs Trial directories into an .fmu."""

    def pack(*trials, options=()):
        return pack_into(lemons, tmp_path / f"{trials[0].name}.fmu", trials, options)

    return pack


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
def push(instantiate, push_directory):
    """An instance of the default FMU."""
    return instantiate(push_directory)


@pytest.fixture(scope="session")
def engine_direct():
    """Runs a Trial on the engine without FMI; the trajectories as CSV text."""
    if not shutil.which("cargo"):
        pytest.skip("cargo is absent")
    # Not --release: `cargo test` has built it so, and examples have other dependencies than the command,
    # which a release build here would make build anew each time. The bits do not depend on the profile.
    command = ["cargo", "build", "--quiet", "--workspace", "--example", "engine_direct", "--target-dir", TARGET]
    subprocess.run(command, check=True, cwd=REPOSITORY)

    def engine_direct(trial, steps, *options):
        command = [TARGET / "debug" / "examples" / "engine_direct", trial, "--steps", str(steps), *options]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    return engine_direct
