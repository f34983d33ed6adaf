"""What cargo has built, for the tests of Python. The variable LEMONS_PROFILE says in which profile."""

import os
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
# CARGO_TARGET_DIR may be relative to where cargo and the tests are started.
TARGET = Path(os.environ.get("CARGO_TARGET_DIR") or REPOSITORY / "target").resolve()
PROFILE = os.environ.get("LEMONS_PROFILE") or "release"
BUILT = TARGET / PROFILE
#: Path of the command: the environment's LEMONS, else that of the profile.
LEMONS = Path(os.environ.get("LEMONS") or BUILT / "lemons").resolve()


def missing(path):
    """What to do where a file is not there."""
    build = f"cargo build --profile {PROFILE} --workspace --all-features --lib --bins"
    return f"{path} is missing: ./check.sh builds it in the profile ci, `{build}` in this one"
