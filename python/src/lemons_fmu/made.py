"""From what a user gives to loaded FMUs: the command `lemons` makes those of a Trial."""

from __future__ import annotations

import os
import tempfile
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Union

from .command import call
from .fmu import DRIVE_FILE, Fmu, load
from .loaded import Loaded, Source, load_any, read
from .model import PLAN_FILE, Algorithm, Model

#: Where people walk. None: by the decision.toml of the Trial, if it has one. False: nobody walks. Or such a file, by its path;
#: or the FMU that decides it (as `lemons decide` makes it, or any other whose outputs have the names of the crowd's inputs): a
#: path that ends in .fmu, its bytes, or what `load_any` has loaded.
Plan = Union[None, Literal[False], Source, Loaded]


def is_trial(what: object) -> bool:
    """Whether this is the path of a Trial: its directory, or its zip."""
    return isinstance(what, (str, os.PathLike)) and (os.path.isdir(what) or os.fspath(what).lower().endswith(".zip"))


@dataclass(frozen=True)
class Made:
    """What is simulated, as FMUs that are not loaded yet."""

    crowd: Source | Fmu
    #: The FMU that decides; None: nobody walks.
    plan: Source | Loaded | None = None
    #: In messages: what says where people walk.
    shown: str = ""
    #: A drive that is not used, because people walk.
    unused: str = ""

    @property
    def data(self) -> tuple[bytes, bytes | None]:
        """The bytes of the FMUs.

        Raises:
            FmuError: one cannot be read.
        """
        return _bytes(self.crowd), None if self.plan is None else _bytes(self.plan)


def made_of(what: Source | Fmu, plan: Plan = None) -> Made:
    """Makes the FMUs of what is simulated: a Trial, by its path, or the FMU of a crowd.

    Raises:
        CommandError: the command `lemons` refuses the Trial or the plan, or is missing.
        TypeError: the plan is not a plan.
        ValueError: a file of way-points is given for an FMU: these need a Trial.
    """
    trial = os.fspath(what) if isinstance(what, (str, os.PathLike)) and is_trial(what) else None
    if not (plan is None or plan is False or isinstance(plan, (str, os.PathLike, bytes, Loaded))):
        raise TypeError(f"the plan is {plan!r}; it must be None, False, the path of a decision.toml, or an FMU that decides")
    crowd = what if trial is None else _written("pack", trial)
    if isinstance(plan, Loaded):
        return Made(crowd, plan, repr(plan.model_name))
    if isinstance(plan, bytes):
        return Made(crowd, plan, "the FMU that decides")
    if plan and os.fspath(plan).lower().endswith(".fmu"):
        return Made(crowd, plan, os.fspath(plan))
    if trial is None:
        if plan:
            raise ValueError(f"plan={plan!r}: is for a Trial: give the Trial instead of its FMU, or the FMU of `lemons decide`")
        return Made(crowd)
    if plan is False or (plan is None and not _has(trial, PLAN_FILE)):
        return Made(crowd)
    shown = os.path.join(trial, PLAN_FILE) if plan is None else os.fspath(plan)
    options = [] if plan is None else [f"--plan={shown}"]
    unused = f"{trial}: its {DRIVE_FILE}" if _has(trial, DRIVE_FILE) else ""
    return Made(crowd, _written("decide", trial, *options), shown, unused)


def model_of(what: Source | Fmu, plan: Plan = None, algorithm: Algorithm = "jacobi") -> Model:
    """Loads what is simulated: see `made_of`.

    Raises:
        CommandError, TypeError, ValueError: see `made_of`.
        FmuError: an FMU cannot be read, or two do not fit together.
    """
    made = made_of(what, plan)
    fmu, decider = load(made.crowd), made.plan
    if made.unused:
        warnings.warn(f"{made.unused} is not used: people walk by {made.shown}", stacklevel=3)
    if not (decider is None or isinstance(decider, Loaded)):
        decider = load_any(decider)
    return Model(fmu, decider, algorithm, made.shown)


def _bytes(part: Source | Loaded) -> bytes:
    return part.data if isinstance(part, Loaded) else read(part)


def _written(command: str, trial: str, *options: str) -> bytes:
    """What a command makes of a Trial."""
    with tempfile.TemporaryDirectory(prefix="lemons-made-") as directory:
        output = Path(directory) / f"{command}.fmu"
        call([command, f"--output={output}", *options, "--", trial])
        return output.read_bytes()


def _has(trial: str, file: str) -> bool:
    """Whether a Trial has such a file: a link that leads nowhere is one, which `lemons` refuses."""
    if os.path.isdir(trial):
        return os.path.lexists(os.path.join(trial, file))
    with zipfile.ZipFile(trial) as archive:
        names = [name.replace("\\", "/") for name in archive.namelist()]
    roots = [name.removesuffix("Parameters.xml") for name in names if name.split("/")[-1] == "Parameters.xml"]
    return any(root + file in names for root in roots)
