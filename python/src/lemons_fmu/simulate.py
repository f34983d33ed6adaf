"""The table of a run: of a Trial, whose people may walk, or of a packed crowd."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pandas as pd

from .crowd import Crowd, Until
from .drive import DriveLike
from .fmu import Fmu
from .instance import Value
from .loaded import Source
from .made import Plan
from .model import Algorithm


def simulate(
    what: Source | Fmu,
    drive: DriveLike[Crowd] = None,
    parameters: Mapping[str, Value] | None = None,
    until: Until = 5.0,
    *,
    step: float | None = None,
    plan: Plan = None,
    algorithm: Algorithm = "jacobi",
    stop: Callable[[Crowd], bool] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Simulates from the beginning of a Trial until a time [s], or until everybody has left ("left"), and returns the table
    that `lemons run` writes, to the last bit.

    `what` is a Trial (its directory, or its zip) or a packed crowd. People walk as in a `Crowd`: those of a Trial by its
    decision.toml or by another file (`plan`); with `plan=False` nobody does. `stop` is that of `Crowd.run`.

    The default drive is the drive.csv of the Trial, as there; `False` means no drive (`--no-drive`). The columns
    are t, id, x, y, vx, vy, theta, omega, agent_contacts, wall_contacts, contacting_agents, normal_force (at that time),
    mean_normal_force, peak_normal_force, peak_overlap (within the step that ends then; FMUs of the first versions do not
    have these three), active (where people may leave: 1, or 0 for who has left), and total_agent_contacts,
    total_wall_contacts of the crowd. Units are s, m, rad, N.

    Raises:
        FmuError: an FMU refuses something; the message is that of the FMU.
        CommandError: `lemons` refuses the Trial or the plan, or is missing; the message is its own.
        TypeError: the drive is not a drive.
        ValueError: drive, time or step are not valid, there is a drive for people who walk, or a plan for a packed crowd.
        OSError: the drive's file cannot be read.
    """
    with Crowd(what, parameters, plan=plan, algorithm=algorithm) as crowd:
        return crowd.run(drive, until=until, step=step, stop=stop, progress=progress).frame()
