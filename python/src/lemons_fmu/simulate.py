"""Runs of a Trial, whose people may walk."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from . import _native
from .crowd import Algorithm, Crowd, DecisionChoice, Source, Until, Value
from .drive import DriveLike
from .extra import needed
from .record import Run

if TYPE_CHECKING:
    import pandas as pd


def run(
    what: Source,
    drive: DriveLike[Crowd] = None,
    parameters: Mapping[str, Value] | None = None,
    until: Until = 5.0,
    *,
    step: float | None = None,
    decision: DecisionChoice = None,
    algorithm: Algorithm = "jacobi",
    stop: Callable[[Crowd], bool] | None = None,
    progress: bool = False,
) -> Run:
    """Simulates from the beginning of a Trial until a time [s], or until everybody has left ("left").

    `what` is a Trial (its directory, or its zip), or the FMU of a crowd, whose Trial is simulated. People walk as in a `Crowd`:
    by the Trial's decision.toml or by another file (`decision`); with `decision=False` nobody does. The default drive is the
    drive.csv of the Trial; `False` means no drive (`--no-drive`). `stop` is that of `Crowd.run`.

    Raises:
        CommandError: the Trial or the decision.toml has errors; the message is that of `lemons run`.
        SimulationError: the simulation refuses something.
        TypeError: the drive is not a drive.
        ValueError: drive, time or step are not valid, or a decision.toml is given for an FMU.
        OSError: the drive's file cannot be read.
    """
    with Crowd(what, parameters, decision=decision, algorithm=algorithm) as crowd:
        return crowd.run(drive, until=until, step=step, stop=stop, progress=progress)


def simulate(
    what: Source,
    drive: DriveLike[Crowd] = None,
    parameters: Mapping[str, Value] | None = None,
    until: Until = 5.0,
    *,
    step: float | None = None,
    decision: DecisionChoice = None,
    algorithm: Algorithm = "jacobi",
    stop: Callable[[Crowd], bool] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Simulates as `run`, and returns the table that `lemons run` writes, to the last bit.

    The columns are COLUMNS. Contacts and `normal_force` are of that time, means and peaks within the step that ends then.
    `active` is there where people may leave (1, or 0 for who has left), `legs_x` to `fallen` where people have legs. Units are
    s, m, rad, N.

    Raises:
        ImportError: there is no pandas: `pip install 'lemons-fmu[tables]'`. Other errors are those of `run`.
    """
    # Before the run.
    with needed("tables", "a table"):
        import pandas
    return run(what, drive, parameters, until, step=step, decision=decision, algorithm=algorithm, stop=stop, progress=progress).frame()


# With `python -OO` there is none.
if simulate.__doc__:
    simulate.__doc__ = simulate.__doc__.replace("COLUMNS", ", ".join(_native.TABLE))
