"""LEMONS-FMU from Python: step a crowd, run it, sweep its parameters.

    from lemons_fmu import Crowd, simulate, sweep

The package uses FMUs that `lemons pack` and `lemons crowd --fmu` make; its manual is python/README.md.
"""

from .crowd import Crowd, Run, State, simulate
from .drive import Drive
from .fmu import Fmu, FmuError, load
from .results import SweepError
from .sweep import Progress, local_cluster, sweep

__all__ = [
    "Crowd",
    "Drive",
    "Fmu",
    "FmuError",
    "Progress",
    "Run",
    "State",
    "SweepError",
    "load",
    "local_cluster",
    "simulate",
    "sweep",
]
