"""Runs for other programs: `lemons export` writes them."""

from __future__ import annotations

import os
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Literal

from .command import Option, call, options
from .picture import Drawn
from .recorded import table_of

#: As `--to` of `lemons export`.
Format = Literal["jupedsim", "pedpy", "chaos", "series", "trial"]


def export(
    what: Drawn,
    output: str | os.PathLike[str],
    *,
    to: Format,
    trial: str | os.PathLike[str] | None = None,
    **others: Option,
) -> Path:
    """Converts a run, and returns where it is written: a file for "jupedsim" and "pedpy", a directory for the other formats.

    `what` is the table of an earlier run, an OutputDirectory, or a `Run`. `trial` is the Trial or FMU that was simulated; a Run
    knows its own. All other options of the command have the same names here: `every=5`, `area="room.wkt"`. What exists is
    replaced with `force=True`.

    Raises:
        CommandError: the command refuses something, or is missing; the message is its own.
    """
    with tempfile.TemporaryDirectory(prefix="lemons-export-") as directory, ExitStack() as kept:
        if not isinstance(what, (str, os.PathLike)):
            if trial is None:
                trial = kept.enter_context(what.walls())
            what = table_of(what, Path(directory))
        call(["export", f"--to={to}", *options({"trial": trial, **others}), "--", os.fspath(what), os.fspath(output)])
    return Path(output)
