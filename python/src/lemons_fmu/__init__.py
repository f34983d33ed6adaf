"""LEMONS-FMU from Python: make a crowd, pack it, step it, run it, measure it, draw and film it, export it, sweep its parameters.

    from lemons_fmu import Crowd, crowd, export, measure, movie, pack, plot, simulate, sweep

`crowd`, `person`, `pack`, `plot`, `movie`, `measure`, `export`, and `simulate` of a Trial call the command `lemons`, which wheels contain. The manual is python/README.md.
"""

from .command import CommandError
from .crowd import Crowd, State
from .drive import Drive
from .errors import FmuError
from .export import export as export
from .fmu import Fmu, load
from .measure import Measures
from .measure import measure as measure
from .picture import Picture, movie, plot
from .progress import Progress
from .results import SweepError
from .run import Run
from .simulate import simulate as simulate
from .sweep import local_cluster, sweep
from .trial import Trial, pack, person
from .trial import crowd as crowd

__all__ = [
    "CommandError",
    "Crowd",
    "Drive",
    "Fmu",
    "FmuError",
    "Measures",
    "Picture",
    "Progress",
    "Run",
    "State",
    "SweepError",
    "Trial",
    "crowd",
    "export",
    "load",
    "local_cluster",
    "measure",
    "movie",
    "pack",
    "person",
    "plot",
    "simulate",
    "sweep",
]
