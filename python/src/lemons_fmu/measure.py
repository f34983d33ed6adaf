"""Measures of a run: flow over lines, density in areas, exposure to squeeze. `lemons measure` computes them all."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from .command import Option, call, options
from .extra import needed
from .hdf5 import source
from .picture import Drawn

if TYPE_CHECKING:
    import pandas as pd

#: Columns that are names, also where they look like numbers.
NAMES = ("line", "direction", "area", "id", "wall")
COUNTS = ("n", "people", "panel", "steps", "fallen")


@dataclass(frozen=True)
class Measures:
    """What was measured. docs/measure.md defines each number; all are in SI units."""

    #: All that does not depend on time: what `lemons measure --summary` writes; None: not known.
    summary: dict[str, Any]
    #: For each line, direction and window: from, until [s], people, flow [1/s], specific_flow [1/(m s)].
    flow: pd.DataFrame
    #: For each first passage of a person: line, direction, n, t [s], id, gap since the one before [s].
    gaps: pd.DataFrame
    #: For each area and frame: t [s], people, density and voronoi_density [1/m2], speed [m/s].
    density: pd.DataFrame
    #: For each person: id, time [s], time_above_… [s], longest_above_… [s], largest_mean_… [N], peak [N], impulse [N s], and largest_mean_…_by_people,
    #: impulse_by_walls and so on; no rows if not known.
    people: pd.DataFrame
    #: With `walls=True`, for each wall: wall (its Id), length [m], load_step, load_1, load_10, load_peak [N/m], when the means over 1 and 10 s
    #: and the peak were (load_1_at, load_10_at, load_peak_at [s]), impulse [N s].
    walls: pd.DataFrame
    #: The same for each panel, after panel, wall, x1, y1, x2, y2 [m].
    panels: pd.DataFrame
    #: With `breathing=True`, for each person: id, front, side, least [N], dose, critical_at [s], critical_x, critical_y [m], critical_part,
    #: above_623, above_1112, above_6227 [s].
    breathing: pd.DataFrame

    def passages(self, line: str, direction: Literal["right", "left"]) -> npt.NDArray[np.float64]:
        """Returns when people crossed a line for the first time in a direction [s], ascending: N(t) is their number up to t.

        Raises:
            KeyError: there is no such line.
        """
        self.direction(line, direction)
        rows = self.gaps[(self.gaps["line"] == line) & (self.gaps["direction"] == direction)]
        return rows["t"].to_numpy(dtype=np.float64)

    def direction(self, line: str, direction: Literal["right", "left"]) -> dict[str, Any]:
        """Returns the numbers of a line in a direction, as in the summary: people, flow [1/s], specific_flow [1/(m s)],
        evacuation_time [s] and so on; None: not known.

        Raises:
            KeyError: there is no such line or direction.
        """
        for known in self.summary["lines"]:
            for way in known["directions"]:
                if (known["name"], way["direction"]) == (line, direction):
                    return dict(way)
        raise KeyError((line, direction))


def measure(
    what: Drawn,
    *,
    trial: str | os.PathLike[str] | None = None,
    lines: Mapping[str, Sequence[float]] | None = None,
    areas: Mapping[str, Sequence[float]] | None = None,
    above: Iterable[float] = (),
    **others: Option,
) -> Measures:
    """Measures a run.

    `what` is a Trial or an FMU, which is simulated first; the table of an earlier run; a `Run`; or trajectories of an experiment or of
    another simulator: JuPedSim's SQLite, PedPy's text, HDF5 of the data archive (`pip install 'lemons-fmu[hdf5]'`). `trial` is the Trial or
    FMU of a table: its walls bound Voronoi cells; a Run knows its own. `lines` are names and x1, y1, x2, y2 [m]; for who stands at the
    first point and looks at the second one, people cross to the right or to the left. `areas` are names and the lower left and the upper
    right corner of a rectangle, or three and more corners of a polygon [m]. `above` are squeezes [N]. All other
    options of the command have the same names here: `window=0.5`, `width=0.9`, `walkable="room.wkt"`, `from_=2.0`, `until=8.0`,
    `output="measures"` (a directory for the tables).

    Raises:
        CommandError: something is refused; the message is that of the command.
        ImportError: there is no pandas: `pip install 'lemons-fmu[tables]'`.
    """
    # Before a run.
    with needed("tables", "a table"):
        import pandas
    given = [("--line", lines), ("--area", areas)]
    words = [f"{option}={name}={_joined(each)}" for option, all in given for name, each in (all or {}).items()]
    known: dict[str, Option] = {"trial": trial, "above": list(above) or None, **others}
    with source(what) as (path, run):
        made = call(["measure", *words, *options(known), "--", path], run)
    return Measures(json.loads(made.summary), *(_table(text) for _, text in made.tables))


def _joined(numbers: Sequence[float]) -> str:
    return ",".join(repr(float(number)) for number in numbers)


def _table(text: str) -> pd.DataFrame:
    import pandas as pd

    # A person may be called NA. Not all versions of pandas read numbers to the last bit.
    table = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
    for name in table.columns:
        if name in COUNTS:
            table[name] = np.array([int(cell) for cell in table[name]], dtype=np.int64)
        elif name not in NAMES:
            table[name] = np.array([float(cell) if cell else np.nan for cell in table[name]], dtype=np.float64)
    return table
