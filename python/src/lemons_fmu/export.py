"""Runs for other programs, as `lemons export` writes them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from .command import Option, call, operand, options
from .picture import Drawn

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
        CommandError: something is refused; the message is that of the command.
    """
    source, run = operand(what)
    call(["export", f"--to={to}", *options({"trial": trial, **others}), "--", source, output], run)
    return Path(output)
