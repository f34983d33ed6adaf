"""The table of a run: of a packed crowd in this process, or of a Trial, whose people may walk, by `lemons run`."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from . import files
from .columns import ACTIVE, CONTACTS, ID, TOTALS
from .command import Option, call, options
from .crowd import Crowd
from .drive import DriveLike
from .fmu import Fmu, Source, Value

_COUNTS = {quantity.name for quantity in (*CONTACTS, ACTIVE, *TOTALS)}
_Path = (str, os.PathLike)


def simulate(
    what: Source | Fmu,
    drive: DriveLike[Crowd] = None,
    parameters: Mapping[str, Value] | None = None,
    until: float = 5.0,
    *,
    step: float | None = None,
    plan: str | os.PathLike[str] | Literal[False] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Simulates from the beginning of a Trial until a time [s], and returns the table that `lemons run` writes.

    `what` is a packed crowd, or a Trial: its directory, or its zip. The people of a Trial walk by its decision.toml, or by
    another file (`plan`); with `plan=False` nobody does. The command `lemons run` couples both FMUs then; the drive of a
    Trial is None, False or a path, and its progress is not shown.

    The default drive is the drive.csv of the Trial, as there; `False` means no drive (`--no-drive`). The columns
    are t, id, x, y, vx, vy, theta, omega, agent_contacts, wall_contacts, contacting_agents, normal_force (at that time),
    mean_normal_force, peak_normal_force, peak_overlap (within the step that ends then; FMUs of the first versions do not
    have these three), active (where people walk: 1, or 0 for who has left), and total_agent_contacts, total_wall_contacts of
    the crowd. Units are s, m, rad, N.

    Raises:
        FmuError: the FMU refuses something; the message is that of the FMU.
        CommandError: `lemons run` refuses something of a Trial, or is missing; the message is its own.
        TypeError: the drive is not a drive, or not one that a Trial can have.
        ValueError: drive, time or step are not valid, or there is a plan for a packed crowd.
        OSError: the drive's file cannot be read.
    """
    if isinstance(what, _Path) and (os.path.isdir(what) or os.fspath(what).lower().endswith(".zip")):
        return _of_trial(what, drive, parameters or {}, until, step, plan)
    if plan:
        raise ValueError(f"plan={os.fspath(plan)!r}: a packed crowd does not walk: give the Trial instead of its FMU")
    with Crowd(what, parameters) as crowd:
        return crowd.run(drive, until=until, step=step, progress=progress).frame()


def _of_trial(
    trial: str | os.PathLike[str],
    drive: DriveLike[Crowd],
    parameters: Mapping[str, Value],
    until: float,
    step: float | None,
    plan: str | os.PathLike[str] | Literal[False] | None,
) -> pd.DataFrame:
    if drive is not None and drive is not False and not isinstance(drive, _Path):
        raise TypeError(f"the drive of a Trial is None, False or a path, not {type(drive).__name__}; a packed crowd takes others")
    with tempfile.TemporaryDirectory(prefix="lemons-run-") as directory:
        table = Path(directory) / "run.csv"
        given: dict[str, Option] = {
            "until": float(until),
            "step": None if step is None else float(step),
            "drive": drive if isinstance(drive, _Path) else None,
            "no-drive": drive is False,
            "plan": None if plan is False else plan,
            "no-plan": plan is False,
            "set": {name: _text(value) for name, value in parameters.items()},
            "output": table,
            "outputs": Path(directory) / "outputs.csv",
        }
        call(["run", *options(given), "--", os.fspath(trial)], state=directory)
        return _read(table)


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, (bool, np.bool_)) else str(value)


def _read(path: Path) -> pd.DataFrame:
    # An Id may look like a number that it is not. Not all versions of pandas read numbers to the last bit.
    cells = pd.read_csv(io.BytesIO(files.read(path, files.LARGEST_BINARY)), dtype=str, keep_default_na=False)
    ids = cells[ID].unique()
    whole = all(each.isascii() and each.isdigit() and str(int(each)) == each for each in ids)
    for name in cells.columns:
        if name in _COUNTS or (name == ID and whole):
            cells[name] = cells[name].to_numpy().astype(np.int64)
        elif name != ID:
            cells[name] = cells[name].to_numpy().astype(np.float64)
    return cells
