"""What came of a run of a crowd."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import _native
from .command import Option
from .drive import Floats
from .export import Format, export
from .extra import needed
from .measure import Measures, measure

if TYPE_CHECKING:
    import pandas as pd

Ints = NDArray[np.int32]

#: Places of the numbers of an agent, by the names of their columns.
PLACE = {name: place for place, name in enumerate(_native.NUMBERS)}


@dataclass(frozen=True, repr=False)
class Run:
    """The results of a run of N people at its K communication points; the first is the start."""

    #: Times [s], shape (K,).
    times: Floats
    #: What poses, velocities, squeezes, contacts and `active` show, shape (K, N, 15); where people have legs, also what `legs`,
    #: `steps`, `balanced` and `fallen` show, shape (K, N, 20); where the load on chests is found, also what `chest_squeeze`
    #: and the others show, shape (K, N, 25), with NaN for legs that nobody has.
    numbers: Floats
    #: Ids of the agents in Agents.xml.
    ids: tuple[str, ...]
    #: Whether people may leave: then the table has a column `active`.
    leaving: bool
    #: Time [s] at which the condition was met that ends the run (`until="left"`, `stop`); None if there is none, or if it was
    #: not met until the last time.
    ended: float | None
    #: The Trial that was simulated, with its walls.
    model: _native.Model

    def __repr__(self) -> str:
        first, last = self.times[[0, -1]]
        return f"<Run of {len(self.ids)} people from {first:g} s to {last:g} s, {len(self.times)} communication points>"

    @property
    def trial(self) -> str:
        """Name of the Trial."""
        return self.model.trial

    @property
    def poses(self) -> Floats:
        """x, y [m], theta [rad]: shape (K, N, 3)"""
        return self.numbers[:, :, 0:3]

    @property
    def velocities(self) -> Floats:
        """vx, vy [m/s], omega [rad/s]: shape (K, N, 3)"""
        return self.numbers[:, :, 3:6]

    @property
    def squeeze(self) -> Floats:
        """Sum of |F_n| over the contacts [N] at the communication points: shape (K, N). Collisions last milliseconds, so
        its maximum depends on the step; `mean_squeeze` and `peak_squeeze` include the time between the points."""
        return self.numbers[:, :, PLACE["normal_force"]]

    @property
    def mean_squeeze(self) -> Floats:
        """Mean of the squeeze over the step that ends at a communication point [N]: shape (K, N)"""
        return self.numbers[:, :, PLACE["mean_normal_force"]]

    @property
    def peak_squeeze(self) -> Floats:
        """Largest squeeze within the step that ends at a communication point [N]: shape (K, N)"""
        return self.numbers[:, :, PLACE["peak_normal_force"]]

    @property
    def peak_overlap(self) -> Floats:
        """Deepest overlap of the contacts within the step that ends at a communication point [m]: shape (K, N)"""
        return self.numbers[:, :, PLACE["peak_overlap"]]

    @property
    def mean_wall_squeeze(self) -> Floats:
        """The part of `mean_squeeze` by walls [N]: shape (K, N). The rest is by other people."""
        return self.numbers[:, :, PLACE["mean_wall_force"]]

    @property
    def contacts(self) -> Ints:
        """Number of contacts with people, of contacts with walls, and of people that touch: shape (K, N, 3)"""
        return self.numbers[:, :, PLACE["agent_contacts"] : PLACE["contacting_agents"] + 1].astype(np.int32)

    @property
    def active(self) -> NDArray[np.bool_]:
        """Whether people are there, shape (K, N). With Jacobi's algorithm it follows Decision one step later."""
        return self.numbers[:, :, PLACE["active"]].astype(bool)

    @property
    def has_legs(self) -> bool:
        """Whether people have legs (`balance` in decision.toml). Else there are no `legs`, `steps`, `balanced` and `fallen`."""
        place = PLACE["legs_x"]
        return bool(self.numbers.shape[2] > place and not np.isnan(self.numbers[0, 0, place]))

    def _of_legs(self, name: str, count: int = 1) -> Floats:
        if not self.has_legs:
            raise ValueError("nobody has legs in this run: balance in decision.toml gives them (docs/balance.md)")
        return self.numbers[:, :, PLACE[name] : PLACE[name] + count]

    @property
    def legs(self) -> Floats:
        """x and y of the middle of the feet [m]: shape (K, N, 2)"""
        return self._of_legs("legs_x", 2)

    @property
    def steps(self) -> Ints:
        """How many steps people took to keep the balance: shape (K, N)"""
        return self._of_legs("steps")[:, :, 0].astype(np.int32)

    @property
    def balanced(self) -> NDArray[np.bool_]:
        """Whether people need no step: shape (K, N)"""
        return self._of_legs("balanced")[:, :, 0].astype(bool)

    @property
    def fallen(self) -> NDArray[np.bool_]:
        """Whether they could not be saved from a fall, at some time: shape (K, N)"""
        return self._of_legs("fallen")[:, :, 0].astype(bool)

    @property
    def has_chests(self) -> bool:
        """Whether the load on chests is found (`ChestHeight` in Agents.xml; a crowd with `levels` has it)."""
        return bool(self.numbers.shape[2] > PLACE["chest_force"])

    def _of_chest(self, name: str, count: int = 1) -> Floats:
        if not self.has_chests:
            raise ValueError("the load on chests is not found in this run: ChestHeight in Agents.xml asks for it (docs/levels.md)")
        return self.numbers[:, :, PLACE[name] : PLACE[name] + count]

    @property
    def chest_squeeze(self) -> Floats:
        """Mean of the sum of |F_n| over the contacts of the chest, over the step that ends at a communication point [N]:
        shape (K, N)"""
        return self._of_chest("chest_force")[:, :, 0]

    @property
    def chest_wall_squeeze(self) -> Floats:
        """The part of `chest_squeeze` by walls [N]: shape (K, N)"""
        return self._of_chest("chest_wall_force")[:, :, 0]

    @property
    def chest_compression(self) -> Floats:
        """Mean forces that press the chest together, over the same step [N]: front–back, side–side, and the smaller principal
        part of both: shape (K, N, 3)"""
        return self._of_chest("chest_front", 3)

    def frame(self) -> pd.DataFrame:
        """Returns the table that `lemons run` writes: a row for each agent at each communication point.

        Raises:
            ImportError: there is no pandas: `pip install 'lemons-fmu[tables]'`.
        """
        with needed("tables", "a table"):
            import pandas as pd
        points, agents = self.squeeze.shape
        ids: list[int] | list[str] = list(self.ids)
        if all(each.isascii() and each.isdigit() and str(int(each)) == each for each in self.ids):
            ids = [int(each) for each in self.ids]
        values = {"t": np.repeat(self.times, agents), "id": np.tile(np.array(ids), points)}
        for place, name in enumerate(_native.NUMBERS[: self.numbers.shape[2]]):
            if PLACE["legs_x"] <= place < PLACE["chest_force"] and not self.has_legs:
                continue
            own = self.numbers[:, :, place]
            # A contact of two people counts for both.
            if name in ("agent_contacts", "wall_contacts"):
                total = own.sum(axis=1) / (2 if name == "agent_contacts" else 1)
                values[f"total_{name}"] = np.repeat(total.astype(np.int64), agents)
            values[name] = own.ravel() if place < PLACE["agent_contacts"] or name.startswith(("legs_", "chest_")) else own.ravel().astype(np.int64)
        return pd.DataFrame({name: values[name] for name in _native.TABLE if name in values and (self.leaving or name != "active")})

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
        `trial` or `walkable` is given. Arguments, results and errors are those of `lemons_fmu.measure`."""
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
