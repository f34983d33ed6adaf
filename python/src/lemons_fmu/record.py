"""What is read of a crowd at each communication point of a run."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .drive import Floats
from .fmu import Fmu
from .instance import Instance
from .run import Run

#: Frames for which there is room at first, where the end of a run is not known.
_FIRST = 1024


class Record:
    """The frames of a run under way, in arrays that grow."""

    def __init__(self, fmu: Fmu, instance: Instance, steps: int, whole: bool) -> None:
        """`whole`: all steps are made, unless the run fails."""
        self._fmu, self._instance, self._most = fmu, instance, steps + 1
        room = self._most if whole else min(self._most, _FIRST)
        self._times = np.empty(room)
        self._reals = np.empty((room, *fmu.reals.shape))
        self._counts = np.empty((room, *fmu.counts.shape), dtype=np.int32)
        self._active = np.ones((room, fmu.agents), dtype=np.bool_)
        self._frames = 0

    def look(self, time: float) -> None:
        """Adds what the crowd is at a time [s]."""
        k = self._frames
        if k == len(self._times):
            room = min(self._most, 2 * k)
            # The old arrays are gone before the next one grows.
            self._times = _grown(self._times, room)
            self._reals = _grown(self._reals, room)
            self._counts = _grown(self._counts, room)
            self._active = _grown(self._active, room)
        self._times[k] = time
        self._instance.get_real(self._fmu.reals, self._reals[k])
        self._instance.get_integer(self._fmu.counts, self._counts[k])
        if self._fmu.active is not None:
            self._active[k] = self._instance.get_boolean(self._fmu.active)
        self._frames = k + 1

    def standing(self) -> tuple[Floats, NDArray[np.bool_]]:
        """Where everybody is now, x and y [m], and whether they are there."""
        now = self._frames - 1
        return self._reals[now, :, 0:2], self._active[now]

    def finish(self, trial: str, ended: float | None, *, may_leave: bool) -> Run:
        """Returns the run."""
        seen: list[NDArray[Any]] = [self._times, self._reals, self._counts, self._active]
        if self._frames < len(self._times):
            seen = [values[: self._frames].copy() for values in seen]
        times, reals, counts, active = seen
        leaving = may_leave or not bool(active.all())
        return Run(times, reals, counts, tuple(self._fmu.ids), active, leaving, ended, self._fmu, trial)


def _grown(values: NDArray[Any], room: int) -> NDArray[Any]:
    grown = np.empty((room, *values.shape[1:]), dtype=values.dtype)
    grown[: len(values)] = values
    return grown
