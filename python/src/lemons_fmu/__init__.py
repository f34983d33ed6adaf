"""LEMONS-FMU from Python: make a crowd, pack it, step it, run it, measure it, draw and film it, export it, sweep its parameters.

    from lemons_fmu import Crowd, crowd, export, measure, movie, pack, plot, simulate, sweep

`crowd`, `person`, `pack`, `plot`, `movie`, `measure`, `export`, and `simulate` of a Trial call the command `lemons`, which wheels contain. The manual is python/README.md.
"""

from ._native import CommandError, SimulationError
from .crowd import Crowd, Finding, State
from .drive import Drive
from .export import export as export
from .measure import Measures
from .measure import measure as measure
from .picture import Picture, movie, plot
from .progress import Progress
from .record import Run
from .simulate import run as run
from .simulate import simulate as simulate
from .sweep import SweepError, local_cluster
from .sweep import sweep as sweep
from .trial import Trial, pack, person
from .trial import crowd as crowd

__all__ = [
    "CommandError",
    "Crowd",
    "Drive",
    "Finding",
    "Measures",
    "Picture",
    "Progress",
    "Run",
    "SimulationError",
    "State",
    "SweepError",
    "Trial",
    "crowd",
    "export",
    "local_cluster",
    "measure",
    "movie",
    "pack",
    "person",
    "plot",
    "run",
    "simulate",
    "sweep",
]
