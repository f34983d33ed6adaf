"""LEMONS-FMU from Python: make a crowd, pack it, step it, run it, draw it, sweep its parameters.

    from lemons_fmu import Crowd, crowd, pack, plot, simulate, sweep

`crowd`, `person`, `pack` and `plot` call the command `lemons`, which wheels contain. The manual is python/README.md.
"""

from .command import CommandError
from .crowd import Crowd, Run, State, simulate
from .drive import Drive
from .fmu import Fmu, FmuError, load
from .picture import Picture, plot
from .progress import Progress
from .results import SweepError
from .sweep import local_cluster, sweep
from .trial import Trial, pack, person
from .trial import crowd as crowd

__all__ = [
    "CommandError",
    "Crowd",
    "Drive",
    "Fmu",
    "FmuError",
    "Picture",
    "Progress",
    "Run",
    "State",
    "SweepError",
    "Trial",
    "crowd",
    "load",
    "local_cluster",
    "pack",
    "person",
    "plot",
    "simulate",
    "sweep",
]
