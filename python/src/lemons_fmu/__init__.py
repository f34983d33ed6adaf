"""LEMONS-FMU from Python: a crowd to step, runs of it, sweeps of its parameters.

    from lemons_fmu import Crowd, simulate, sweep

The package works on FMUs that `lemons pack` and `lemons crowd --fmu` make; python/README.md is its manual.
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
