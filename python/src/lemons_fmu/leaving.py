"""When a run is over in which people leave. crates/results (leaving) has the same rule for the command."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

#: Who has not left until then [s] does not leave.
LATEST = 3600.0
#: If nobody leaves in this time [s], and nobody gets further than `REACH` [m], nobody leaves any more.
STANDSTILL = 300.0
REACH = 5.0
#: Times are sums of steps [s].
_ROUNDING = 1e-9


class Leaving:
    """A run that ends when people have left. It is given all communication points in the order of time."""

    def __init__(self, leave: int) -> None:
        """`leave`: how many are to leave."""
        self._leave = leave
        self._since = -np.inf
        self._places: NDArray[np.float64] = np.empty((0, 2))
        self._there: NDArray[np.bool_] = np.empty(0, dtype=np.bool_)

    def see(self, time: float, places: NDArray[np.float64], there: NDArray[np.bool_]) -> Literal["left", "standstill"] | None:
        """At a time [s], x and y of everybody [m], and whether they are there: returns why it is over, if it is."""
        if not np.array_equal(self._there, there) or self._further(places[there]):
            self._since, self._places, self._there = time, places.copy(), there.copy()
        if np.count_nonzero(~there) >= self._leave:
            return "left"
        return "standstill" if time - self._since >= STANDSTILL - _ROUNDING else None

    @property
    def stay(self) -> str:
        """How many have not left, of how many who are to leave."""
        return f"{self._leave - np.count_nonzero(~self._there)} of {self._leave}"

    @staticmethod
    def why(over: str | None) -> str:
        """Why a run ends in which people stay."""
        if over == "standstill":
            return f"in the last {STANDSTILL:g} s nobody has left or got further than {REACH:g} m"
        return "this is the latest end"

    def _further(self, places: NDArray[np.float64]) -> bool:
        moved = places - self._places[self._there]
        return not bool((np.hypot(moved[:, 0], moved[:, 1]) <= REACH).all())
