"""Runs for other programs, as `lemons export` writes them."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Literal

from ._native import CommandError
from .command import Option, call, options
from .hdf5 import source, write_hdf5
from .picture import Drawn

#: As `--to` of `lemons export`, and HDF5 of the data archive, which PedPy reads and JuPedSim writes.
Format = Literal["jupedsim", "pedpy", "hdf5", "chaos", "series", "trial"]


def export(
    what: Drawn,
    output: str | os.PathLike[str],
    *,
    to: Format,
    trial: str | os.PathLike[str] | None = None,
    **others: Option,
) -> Path:
    """Converts a run, and returns where it is written: a file for "jupedsim", "pedpy" and "hdf5", a directory for the
    other formats.

    `what` is the table of an earlier run, an OutputDirectory, a `Run`, or trajectories, as for `measure`. "hdf5" takes the options of
    "jupedsim", and needs h5py: `pip install 'lemons-fmu[hdf5]'`. `trial` is the Trial or FMU that was simulated; a Run
    knows its own. All other options of the command have the same names here: `every=5`, `area="room.wkt"`. What exists is
    replaced with `force=True`.

    Raises:
        CommandError: something is refused; the message is that of the command.
    """
    known: dict[str, Option] = {"trial": trial, **others}
    with source(what) as (path, run):
        if to != "hdf5":
            call(["export", f"--to={to}", *options(known), "--", path, output], run)
            return Path(output)
        force = known.pop("force", False)
        if os.path.exists(output):
            for each in (what, *known.values()):
                if isinstance(each, (str, os.PathLike)) and os.path.exists(each) and os.path.samefile(each, output):
                    raise CommandError(f"{output}: it is read, and is not replaced")
            if not force:
                raise CommandError(f"{output}: exists already (force=True replaces it)")
        with tempfile.TemporaryDirectory(prefix="lemons-") as directory:
            database = Path(directory) / "run.sqlite"
            call(["export", "--to=jupedsim", *options(known), "--", path, database], run)
            write_hdf5(database, Path(output))
    return Path(output)
