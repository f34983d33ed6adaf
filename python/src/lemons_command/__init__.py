"""The command `lemons` of a wheel, and the libraries that it packs, one directory for each of FMI's platforms.

This is a package of its own, because `lemons_fmu` imports NumPy, which each call of the command would wait for.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

_NAME = "lemons.exe" if os.name == "nt" else "lemons"


def program() -> str:
    """Returns the path of the command: what the variable LEMONS says, that of the wheel, else the one on the PATH.

    Raises:
        FileNotFoundError: it is in none of these places.
    """
    said = os.environ.get("LEMONS")
    if said:
        return said
    own = Path(__file__).with_name(_NAME)
    if own.is_file():
        return str(own)
    found = shutil.which("lemons")
    if found is None:
        raise FileNotFoundError(
            "the command lemons is missing: install the wheel of a release, or put the command on the PATH, or name it in the "
            "variable LEMONS"
        )
    return found


def main() -> int:
    """Runs the command with the arguments of this process: the entry point `lemons` of a wheel."""
    own = Path(__file__).with_name(_NAME)
    if not own.is_file():
        # Not the one on the PATH: that is this one.
        print(f"lemons: {own} is missing: install the wheel again", file=sys.stderr)
        return 1
    if os.name != "nt":
        os.execv(own, [str(own), *sys.argv[1:]])
    # Windows has no exec: this process waits. Ctrl-C goes to both; the command decides what it means.
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return subprocess.call([str(own), *sys.argv[1:]])
