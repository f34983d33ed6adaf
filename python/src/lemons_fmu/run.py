"""What came of a run of a crowd."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .columns import ACTIVE, CONTACTS, ID, OF_STEP, REALS, TABLE, TIME, TOTALS
from .command import Option
from .drive import Floats
from .errors import FmuError
from .export import Format, export
from .fmu import Fmu
from .measure import Measures, measure

Ints = NDArray[np.int32]


@dataclass(frozen=True, repr=False)
class Run:
    """The results of a run of N people at its K communication points; the first is the start."""

    #: Times [s], shape (K,).
    times: Floats
    reals: Floats
    counts: Ints
    #: Ids of the agents in Agents.xml.
    ids: tuple[str, ...]
    #: Whether people are there, shape (K, N). It follows the input `agent[i].Active` of the crowd, so with Jacobi's algorithm
    #: one step after the Decision FMU says it.
    active: NDArray[np.bool_]
    #: Whether people may leave: then the table has a column `active`.
    leaving: bool
    #: Time [s] at which the condition was met that ends the run (`until="left"`, `stop`); None if there is none, or if it was
    #: not met until the last time.
    ended: float | None
    #: The FMU of the crowd, and the name of the Trial in it: its walls.
    fmu: Fmu
    trial: str

    def __repr__(self) -> str:
        first, last = self.times[[0, -1]]
        return f"<Run of {len(self.ids)} people from {first:g} s to {last:g} s, {len(self.times)} communication points>"

    @property
    def poses(self) -> Floats:
        """x, y [m], theta [rad]: shape (K, N, 3)"""
        return self.reals[:, :, 0:3]

    @property
    def velocities(self) -> Floats:
        """vx, vy [m/s], omega [rad/s]: shape (K, N, 3)"""
        return self.reals[:, :, 3:6]

    @property
    def squeeze(self) -> Floats:
        """Sum of |F_n| over the contacts [N] at the communication points: shape (K, N). Collisions last milliseconds, so
        its maximum depends on the step; `mean_squeeze` and `peak_squeeze` include the time between the points."""
        return self.reals[:, :, 6]

    @property
    def mean_squeeze(self) -> Floats:
        """Mean of the squeeze over the step that ends at a communication point [N]: shape (K, N).

        Raises:
            FmuError: the FMU was packed by an early version, which does not have this output and the next two.
        """
        return of_step(self.reals, 0)

    @property
    def peak_squeeze(self) -> Floats:
        """Largest squeeze within the step that ends at a communication point [N]: shape (K, N)"""
        return of_step(self.reals, 1)

    @property
    def peak_overlap(self) -> Floats:
        """Deepest overlap of the contacts within the step that ends at a communication point [m]: shape (K, N)"""
        return of_step(self.reals, 2)

    @property
    def contacts(self) -> Ints:
        """Number of contacts with people, of contacts with walls, and of people that touch: shape (K, N, 3)"""
        return self.counts

    def frame(self) -> pd.DataFrame:
        """Returns the table that `lemons run` writes: a row for each agent at each communication point."""
        points, agents = self.squeeze.shape
        ids: list[int] | list[str] = list(self.ids)
        if all(each.isascii() and each.isdigit() and str(int(each)) == each for each in self.ids):
            ids = [int(each) for each in self.ids]
        columns: dict[str, object] = {TIME: np.repeat(self.times, agents), ID: np.tile(np.array(ids), points)}
        for k, quantity in enumerate((*REALS, *OF_STEP)[: self.reals.shape[2]]):
            columns[quantity.name] = self.reals[:, :, k].ravel()
        for k, quantity in enumerate(CONTACTS):
            columns[quantity.name] = self.counts[:, :, k].ravel().astype(np.int64)
        of_agents, of_walls, _ = self.counts.sum(axis=1, dtype=np.int64).T
        # A contact of two people counts for both.
        for quantity, total in zip(TOTALS, (of_agents // 2, of_walls)):
            columns[quantity.name] = np.repeat(total, agents)
        if self.leaving:
            columns[ACTIVE.name] = self.active.ravel().astype(np.int64)
        order = [TIME, ID, *(quantity.name for quantity in TABLE)]
        order.insert(-len(TOTALS), ACTIVE.name)
        return pd.DataFrame(columns)[[name for name in order if name in columns]]

    def measure(
        self,
        *,
        lines: Mapping[str, Sequence[float]] | None = None,
        areas: Mapping[str, Sequence[float]] | None = None,
        above: Iterable[float] = (),
        trial: str | os.PathLike[str] | None = None,
        **others: Option,
    ) -> Measures:
        """Measures the run, with the numbers of `lemons measure` of the same run. The walls are those of its Trial, unless
        `trial` or `walkable` is given. Arguments, results and errors are those of `lemons_fmu.measure`.

        It calls the command `lemons`: some hundredths of a second, and more for long runs (python/README.md).
        """
        return measure(self, lines=lines, areas=areas, above=above, trial=trial, **others)

    def export(
        self,
        output: str | os.PathLike[str],
        *,
        to: Format,
        trial: str | os.PathLike[str] | None = None,
        **others: Option,
    ) -> Path:
        """Converts the run for another program, as `lemons export` does: `run.export("run.sqlite", to="jupedsim")`. The Trial is
        its own, unless `trial` is given. Arguments, results and errors are those of `lemons_fmu.export`."""
        return export(self, output, to=to, trial=trial, **others)

    @contextmanager
    def walls(self) -> Iterator[Path | None]:
        """Gives the directory of the Trial that was simulated, as it is packed; it must not be changed."""
        with self.fmu.unpacked():
            yield self.fmu.directory_of(self.trial) if self.fmu.has(self.trial) else None


def of_step(values: NDArray[Any], which: int) -> NDArray[Any]:
    """Returns one of `OF_STEP`, from values whose last axis is REALS + OF_STEP."""
    place = len(REALS) + which
    if values.shape[-1] <= place:
        raise FmuError(f"the FMU has no output agent[i].{OF_STEP[which].variable}: an earlier version packed it; pack its Trial again")
    return values[..., place]
