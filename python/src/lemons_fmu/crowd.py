"""Crowds that can be stepped, and runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from numpy.typing import NDArray

from .columns import CONTACTS, ID, INPUTS, OF_STEP, REALS, TABLE, TIME, TOTALS
from .drive import Drive, DriveLike, Floats, forces, known
from .fmu import Fmu, FmuError, Instance, Source, Value, load
from .progress import Progress, ProgressLine

Ints = NDArray[np.int32]


#: Largest number of communication steps of a run, as in `lemons run`.
MOST_STEPS = 1_000_000_000


def steps_between(start: float, until: float, step: float) -> int:
    """Returns the number of communication steps between two times [s]; the last may be shorter.

    Raises:
        ValueError: there are no steps, there are too many, or rounding makes the step zero.
    """
    if not (math.isfinite(until) and until > start and math.isfinite(step) and step > 0):
        raise ValueError(f"nothing to simulate: from {start} s to {until} s in steps of {step} s")
    return _clock(start, until, step)[0]


def _clock(start: float, until: float, step: float) -> tuple[int, float]:
    """Returns the number of communication steps and the last point [s], as `Clock::new` of `lemons run`."""
    quotient = (until - start) / step
    if quotient > MOST_STEPS + 0.5:
        raise ValueError(f"from {start} s to {until} s there are {quotient:.4e} steps of {step} s: at most {MOST_STEPS:.0e} are made")
    if start + step <= start or until - step >= until:
        raise ValueError(f"a communication step of {step} s is lost in rounding between {start} s and {until} s")
    steps = max(1, math.floor(quotient + 0.5))
    # Both the quotient and the multiple are rounded: by less than a few of the smallest differences of such times.
    multiple, rounding = start + steps * step, 4.0 * max(math.ulp(until), math.ulp(start))
    if abs(multiple - until) <= max(rounding, 1e-9 * step):
        # If the end is a multiple of the step except for rounding, use that multiple.
        until = multiple
    else:
        steps = max(1, math.ceil(quotient))
    # No step has the length 0.
    while steps > 1 and start + (steps - 1) * step >= until:
        steps -= 1
    return steps, until


def points_between(start: float, until: float, step: float) -> Floats:
    """Returns the communication points between two times [s], including both; the same bits as in `lemons run`. They are
    multiples of the step, not sums; the last step may be shorter.

    Raises:
        ValueError: see `steps_between`.
    """
    steps = steps_between(start, until, step)
    times: Floats = start + np.arange(steps + 1, dtype=np.float64) * step
    times[-1] = _clock(start, until, step)[1]
    return times


@dataclass(frozen=True, repr=False)
class State:
    """A saved crowd, including springs and parameters. It can be pickled, and restored in another process."""

    time: float
    data: bytes

    def __repr__(self) -> str:
        return f"<State at {self.time:g} s, {len(self.data)} bytes>"


class Crowd:
    """An instance of a packed crowd of N people, initialized and ready to step.

    `fmu` is a file, the bytes of a file, or a result of `load`. `parameters` are set before initialization: parameters and
    start values by their names in the FMU; `agent[*].Mass` sets the mass of all agents. Use it in a `with`, or `close` it:
    the next Crowd then uses its instance again. Only one thread at a time may use it; make one for each thread.

    Raises:
        FmuError: the FMU refuses something; the message is that of the FMU.
    """

    def __init__(self, fmu: Source | Fmu, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        self.fmu = load(fmu)
        self._given: Instance | None = self.fmu.borrow()
        #: The current time [s].
        self.time = start
        try:
            self._instance.initialize(parameters or {}, start)
        except BaseException:
            self.close()
            raise

    @property
    def _instance(self) -> Instance:
        if self._given is None:
            raise FmuError("the Crowd is closed")
        return self._given

    def __enter__(self) -> Crowd:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_given", None) is not None:
            self.close()

    def __repr__(self) -> str:
        if self._given is None:
            return "<Crowd, closed>"
        return f"<Crowd of {self.fmu.agents} people, Trial {self.trial!r}, at {self.time:g} s>"

    def __len__(self) -> int:
        """The number of people."""
        return self.fmu.agents

    def __getitem__(self, name: str) -> Value:
        """Returns the value of a variable."""
        return self._instance.get(name)

    def close(self) -> None:
        """Gives the instance back. The Crowd cannot be used any more."""
        instance, self._given = self._given, None
        if instance is not None:
            self.fmu.give_back(instance)

    def reset(self, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        """Goes back to the beginning of the Trial, with these parameters only."""
        self._instance.reset()
        self.time = start
        self._instance.initialize(parameters or {}, start)

    @property
    def trial(self) -> str:
        """Name of the packed Trial that is simulated."""
        return str(self["Trial"]) if "Trial" in self.fmu.variables else self.fmu.trial

    @property
    def messages(self) -> list[str]:
        """The messages of the FMU, such as warnings."""
        return self._instance.messages

    def set_drive(self, drive: Floats) -> None:
        """Sets Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3). They stay until they are set again."""
        self._instance.set_real(self.fmu.inputs, forces(drive, self.fmu.agents))

    def drive(self) -> Floats:
        """Returns Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3)."""
        return self._reals(self.fmu.inputs)

    @property
    def active(self) -> Presence:
        """Whether people are there, as an array that can be written: `crowd.active[3] = False` takes somebody out. From the
        next step on they touch nothing and do not move; with True they come back where they were.

        Raises:
            FmuError: the FMU was packed by an early version, from whose crowd nobody can leave.
        """
        return Presence(self)

    @active.setter
    def active(self, values: npt.ArrayLike) -> None:
        self.active[:] = values

    def step(self, step: float | None = None) -> None:
        """Simulates a communication step [s]; by default the Trial's TimeStep."""
        self.step_to(self.time + (self.fmu.step_of(self.trial) if step is None else step))

    def step_to(self, time: float) -> None:
        """Simulates a communication step that ends at this time [s]."""
        self._instance.do_step(self.time, time - self.time)
        self.time = time

    def poses(self) -> Floats:
        """Returns x, y [m] and theta [rad] of all agents, shape (N, 3)."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 0:3]))

    def velocities(self) -> Floats:
        """Returns vx, vy [m/s] and omega [rad/s] of all agents, shape (N, 3)."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 3:6]))

    def squeeze(self) -> Floats:
        """Returns the present squeeze of all agents, shape (N,): the sum of |F_n| over the contacts [N]. Collisions last
        milliseconds, so it depends on the instant; `mean_squeeze` and `peak_squeeze` do not."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 6]))

    def mean_squeeze(self) -> Floats:
        """Returns the mean squeeze over the last communication step [N], shape (N,): its impulse / the step.

        Raises:
            FmuError: the FMU was packed by an early version, which does not have this output and the next two.
        """
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 0)))

    def peak_squeeze(self) -> Floats:
        """Returns the largest squeeze within the last communication step [N], shape (N,)."""
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 1)))

    def peak_overlap(self) -> Floats:
        """Returns the deepest overlap of the contacts within the last communication step [m], shape (N,)."""
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 2)))

    def contacts(self) -> Ints:
        """Returns for all agents the number of contacts with people, of contacts with walls, and of people that touch: shape
        (N, 3)."""
        values = np.empty(self.fmu.counts.shape, dtype=np.int32)
        self._instance.get_integer(self.fmu.counts, values)
        return values

    def masses(self) -> Floats:
        """Returns the masses of all agents [kg], shape (N,)."""
        return self._reals(self.fmu.references(("Mass",))[:, 0].copy())

    def save(self) -> State:
        """Returns the state, including contacts. After it is restored, results have the same bits."""
        return State(self.time, self._instance.save())

    def restore(self, state: State) -> None:
        """Restores a state that was saved from this Crowd, or from another one of the same FMU."""
        self._instance.restore(state.data)
        self.time = state.time

    def run(self, drive: DriveLike[Crowd] = None, *, until: float, step: float | None = None, progress: bool = False) -> Run:
        """Steps until a time [s], and returns poses, velocities, squeeze and contacts at all communication points. These are
        multiples of the step from the present time; the last step may be shorter. The default step is the Trial's TimeStep.

        The default drive is the drive.csv packed with the Trial, as in `lemons run FILE.fmu`. Nobody walks by a
        decision.toml: `simulate` of the Trial does that. With `False` no drive is set: that of
        the Trial, or the one that was set before, continues. See `DriveLike` for other drives. `progress` shows the progress
        on standard error.

        Raises:
            FmuError: the FMU refuses something; the message is that of the FMU.
            TypeError: the drive is not a drive.
            ValueError: drive, time or step are not valid.
            OSError: the drive's file cannot be read.
        """
        step = self.fmu.step_of(self.trial) if step is None else step
        start = self.time
        times = points_between(start, until, step)
        steps = len(times) - 1
        reals = np.empty((steps + 1, *self.fmu.reals.shape))
        counts = np.empty((steps + 1, *self.fmu.counts.shape), dtype=np.int32)
        instance = self._instance
        drive = self.fmu.drive(self.trial) if drive is None else known(drive, self.fmu.ids)
        pushes, driven = None, None
        if isinstance(drive, Drive) and drive.tables:
            pushes, driven = self._pushes(drive, times)
        elif isinstance(drive, np.ndarray):
            self.set_drive(drive)
        instance.get_real(self.fmu.reals, reals[0])
        instance.get_integer(self.fmu.counts, counts[0])
        line, begin = (ProgressLine("steps", failing=False) if progress else None), monotonic()
        for k in range(steps):
            if pushes is not None and driven is not None:
                instance.set_real(driven, pushes[k])
            elif callable(drive):
                self.set_drive(drive(self))
            self.step_to(float(times[k + 1]))
            instance.get_real(self.fmu.reals, reals[k + 1])
            instance.get_integer(self.fmu.counts, counts[k + 1])
            if line is not None:
                line(Progress(k + 1, 0, steps, monotonic() - begin, 0, None))
        return Run(times, reals, counts, tuple(self.fmu.ids))

    def _pushes(self, drive: Drive, times: Floats) -> tuple[Floats, NDArray[np.uint32]]:
        """Returns the values of tables at each step, and the references of these inputs."""
        agents = list(drive.tables)
        moments = times[:-1] if drive.at == "start" else (times[:-1] + times[1:]) / 2
        masses = self.masses() if drive.per_mass else np.ones(self.fmu.agents)
        pushes = np.empty((len(moments), len(agents), 3))
        for place, agent in enumerate(agents):
            pushes[:, place] = masses[agent] * drive.sample(agent, moments)
        return pushes, self.fmu.references(INPUTS, agents)

    def _reals(self, references: NDArray[np.uint32]) -> Floats:
        values = np.empty(references.shape)
        self._instance.get_real(references, values)
        return values


class Presence:
    """Of each person of a Crowd, whether they are there. What is written goes into the Crowd at once."""

    def __init__(self, crowd: Crowd) -> None:
        self._crowd = crowd
        references = crowd.fmu.active
        if references is None:
            raise FmuError("the FMU has no input agent[i].Active: an earlier version packed it; pack its Trial again")
        self._references = references

    def _values(self) -> NDArray[np.bool_]:
        return self._crowd._instance.get_boolean(self._references)

    def __array__(self, dtype: npt.DTypeLike = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self._values(), dtype=dtype)

    def __len__(self) -> int:
        return len(self._references)

    def __repr__(self) -> str:
        return repr(self._values())

    def __getitem__(self, which: Any) -> Any:
        """Of one person True or False; of several an array."""
        found = self._values()[which]
        return bool(found) if isinstance(found, np.bool_) else found

    def __setitem__(self, which: Any, values: npt.ArrayLike) -> None:
        given = np.asarray(values)
        if not np.isin(given, (0, 1)).all():
            raise ValueError(f"whether people are there must be True or False, not {values!r}")
        all_of_them = self._values()
        all_of_them[which] = given
        self._crowd._instance.set_boolean(self._references, all_of_them)


@dataclass(frozen=True, repr=False)
class Run:
    """The results of a run of N people at its K communication points; the first is the start."""

    #: Times [s], shape (K,).
    times: Floats
    reals: Floats
    counts: Ints
    #: Ids of the agents in Agents.xml.
    ids: tuple[str, ...]

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
        return _of_step(self.reals, 0)

    @property
    def peak_squeeze(self) -> Floats:
        """Largest squeeze within the step that ends at a communication point [N]: shape (K, N)"""
        return _of_step(self.reals, 1)

    @property
    def peak_overlap(self) -> Floats:
        """Deepest overlap of the contacts within the step that ends at a communication point [m]: shape (K, N)"""
        return _of_step(self.reals, 2)

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
        order = (TIME, ID, *(quantity.name for quantity in TABLE))
        return pd.DataFrame(columns)[[name for name in order if name in columns]]


def _of_step(values: NDArray[Any], which: int) -> NDArray[Any]:
    """Returns one of `OF_STEP`, from values whose last axis is REALS + OF_STEP."""
    place = len(REALS) + which
    if values.shape[-1] <= place:
        raise FmuError(f"the FMU has no output agent[i].{OF_STEP[which].variable}: an earlier version packed it; pack its Trial again")
    return values[..., place]
