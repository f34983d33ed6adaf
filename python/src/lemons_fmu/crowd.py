"""A crowd to step, and runs of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .drive import Drive, DriveLike, Floats, forces, known
from .fmu import OF_STEP, REALS, Fmu, FmuError, Instance, Source, Value, load

Ints = NDArray[np.int32]


#: Communication steps of a run at most, as for `lemons run`.
MOST_STEPS = 1_000_000_000


def steps_between(start: float, until: float, step: float) -> int:
    """How many communication steps there are from one time to another [s]; the last may be a shorter one.

    Raises:
        ValueError: there is none, there are too many, or the step is lost in rounding.
    """
    if not (math.isfinite(until) and until > start and math.isfinite(step) and step > 0):
        raise ValueError(f"nothing to simulate: from {start} s to {until} s in steps of {step} s")
    steps = (until - start) / step
    if steps > MOST_STEPS:
        raise ValueError(f"from {start} s to {until} s there are {steps:.4e} steps of {step} s: at most {MOST_STEPS:.0e} are made")
    if start + step <= start or until - step >= until:
        raise ValueError(f"a communication step of {step} s is lost in rounding between {start} s and {until} s")
    return max(1, math.ceil(steps - 1e-9))


@dataclass(frozen=True, repr=False)
class State:
    """A saved crowd, springs and parameters included; it can be pickled, and restored in another process."""

    time: float
    data: bytes

    def __repr__(self) -> str:
        return f"<State at {self.time:g} s, {len(self.data)} bytes>"


class Crowd:
    """An instance of a packed crowd of N people, initialized and ready to step.

    `fmu` is a file, the bytes of one, or what `load` gave. `parameters` are set before initialization: parameters and
    start values by their names in the FMU, where `agent[*].Mass` stands for everybody's. Use it in a `with`, or `close`
    it: its instance then serves the next Crowd. One thread at a time may use it; make one for each thread.

    Raises:
        FmuError: the FMU's refusal, in its words.
    """

    def __init__(self, fmu: Source | Fmu, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        self.fmu = load(fmu)
        self._given: Instance | None = self.fmu.borrow()
        #: [s]
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
        """How many people there are."""
        return self.fmu.agents

    def __getitem__(self, name: str) -> Value:
        """The value of a variable."""
        return self._instance.get(name)

    def close(self) -> None:
        """Gives the instance back; the Crowd is of no more use."""
        instance, self._given = self._given, None
        if instance is not None:
            self.fmu.give_back(instance)

    def reset(self, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        """The Trial's beginning again, with these parameters and no others."""
        self._instance.reset()
        self.time = start
        self._instance.initialize(parameters or {}, start)

    @property
    def trial(self) -> str:
        """Name of the packed Trial that is simulated."""
        return str(self["Trial"]) if "Trial" in self.fmu.variables else self.fmu.trial

    @property
    def messages(self) -> list[str]:
        """What the FMU said, warnings that is."""
        return self._instance.messages

    def set_drive(self, drive: Floats) -> None:
        """Sets Fp.x, Fp.y [N] and Mp [N.m] of everybody, shape (N, 3), until they are set again."""
        self._instance.set_real(self.fmu.inputs, forces(drive, self.fmu.agents))

    def drive(self) -> Floats:
        """Fp.x, Fp.y [N] and Mp [N.m], shape (N, 3)."""
        return self._reals(self.fmu.inputs)

    def step(self, step: float | None = None) -> None:
        """Simulates a communication step [s]; by default the Trial's TimeStep."""
        self.step_to(self.time + (self.fmu.step_of(self.trial) if step is None else step))

    def step_to(self, time: float) -> None:
        """Simulates a communication step that ends at this time [s]."""
        self._instance.do_step(self.time, time - self.time)
        self.time = time

    def poses(self) -> Floats:
        """x, y [m] and theta [rad] of everybody, shape (N, 3)."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 0:3]))

    def velocities(self) -> Floats:
        """vx, vy [m/s] and omega [rad/s] of everybody, shape (N, 3)."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 3:6]))

    def squeeze(self) -> Floats:
        """How hard everybody is squeezed now, shape (N,): the sum of |F_n| over the contacts [N]. Collisions last
        milliseconds, so this hangs on the instant; `mean_squeeze` and `peak_squeeze` do not."""
        return self._reals(np.ascontiguousarray(self.fmu.reals[:, 6]))

    def mean_squeeze(self) -> Floats:
        """Mean of the squeeze over the last communication step [N], shape (N,): its impulse by the step.

        Raises:
            FmuError: the FMU is of a version that did not have it; neither did it have the two that follow.
        """
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 0)))

    def peak_squeeze(self) -> Floats:
        """Largest squeeze within the last communication step [N], shape (N,)."""
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 1)))

    def peak_overlap(self) -> Floats:
        """Deepest overlap of the contacts within the last communication step [m], shape (N,)."""
        return self._reals(np.ascontiguousarray(_of_step(self.fmu.reals, 2)))

    def contacts(self) -> Ints:
        """Contacts with people, contacts with walls, how many people touch, of everybody: shape (N, 3)."""
        values = np.empty(self.fmu.counts.shape, dtype=np.int32)
        self._instance.get_integer(self.fmu.counts, values)
        return values

    def masses(self) -> Floats:
        """[kg], shape (N,)"""
        return self._reals(self.fmu.references(("Mass",))[:, 0].copy())

    def save(self) -> State:
        """The state, in the middle of contacts too: restored and run on, results have the same bits."""
        with self._instance.calls() as slave:
            state = slave.getFMUstate()
            try:
                return State(self.time, bytes(slave.serializeFMUstate(state)))
            finally:
                slave.freeFMUstate(state)

    def restore(self, state: State) -> None:
        """Goes back to a state that was saved here, or from another Crowd of the same FMU."""
        with self._instance.calls() as slave:
            restored = slave.deSerializeFMUstate(state.data)
            try:
                slave.setFMUstate(restored)
            finally:
                slave.freeFMUstate(restored)
        self.time = state.time

    def run(self, drive: DriveLike = None, *, until: float, step: float | None = None) -> Run:
        """Steps on to a time [s] and keeps everything at all communication points, which are multiples of the step from
        here; the last step is shortened to end there. `step` is the Trial's TimeStep unless it is given.

        By default the drive.csv that is packed with the Trial drives people, as in `lemons run`; with `False` no drive is
        set, and what the Trial says or what was set before goes on. See `DriveLike` for the others.

        Raises:
            FmuError: the FMU's refusal, in its words.
            TypeError: the drive is nothing that can drive a crowd.
            ValueError: drive, time or step are of no use.
            OSError: the drive's file cannot be read.
        """
        step = self.fmu.step_of(self.trial) if step is None else step
        start = self.time
        steps = steps_between(start, until, step)
        times: Floats = start + np.arange(steps + 1, dtype=np.float64) * step
        # As `lemons run` ends: at a multiple of the step where it is one but for rounding.
        if abs(times[-1] - until) > 1e-9 * step:
            times[-1] = until
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
        for k in range(steps):
            if pushes is not None and driven is not None:
                instance.set_real(driven, pushes[k])
            elif callable(drive):
                self.set_drive(drive(self))
            self.step_to(float(times[k + 1]))
            instance.get_real(self.fmu.reals, reals[k + 1])
            instance.get_integer(self.fmu.counts, counts[k + 1])
        return Run(times, reals, counts, tuple(self.fmu.ids))

    def _pushes(self, drive: Drive, times: Floats) -> tuple[Floats, NDArray[np.uint32]]:
        """What tables drive, at each step, and the references of these inputs."""
        agents = list(drive.tables)
        moments = times[:-1] if drive.at == "start" else (times[:-1] + times[1:]) / 2
        masses = self.masses() if drive.per_mass else np.ones(self.fmu.agents)
        pushes = np.empty((len(moments), len(agents), 3))
        for place, agent in enumerate(agents):
            pushes[:, place] = masses[agent] * drive.sample(agent, moments)
        return pushes, self.fmu.references(("Fp.x", "Fp.y", "Mp"), agents)

    def _reals(self, references: NDArray[np.uint32]) -> Floats:
        values = np.empty(references.shape)
        self._instance.get_real(references, values)
        return values


@dataclass(frozen=True, repr=False)
class Run:
    """What a run of N people showed at its K communication points, the first of which is the beginning."""

    #: [s], shape (K,)
    times: Floats
    reals: Floats
    counts: Ints
    #: Of each agent, the Id of Agents.xml.
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
        its maximum hangs on the step; those of `mean_squeeze` and `peak_squeeze` tell what happened between the points."""
        return self.reals[:, :, 6]

    @property
    def mean_squeeze(self) -> Floats:
        """Mean of the squeeze over the step that ends at a communication point [N]: shape (K, N).

        Raises:
            FmuError: the FMU is of a version that did not have it; neither did it have the two that follow.
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
        """Contacts with people, contacts with walls, how many people touch: shape (K, N, 3)"""
        return self.counts

    def frame(self) -> pd.DataFrame:
        """The table that `lemons run` writes: a row for each agent at each communication point."""
        points, agents = self.squeeze.shape
        ids: list[int] | list[str] = list(self.ids)
        if all(each.isascii() and each.isdigit() and str(int(each)) == each for each in self.ids):
            ids = [int(each) for each in self.ids]
        columns: dict[str, object] = {"t": np.repeat(self.times, agents), "id": np.tile(np.array(ids), points)}
        names = ["x", "y", "theta", "vx", "vy", "omega", "normal_force", *OF_STEP_COLUMNS]
        for k, name in enumerate(names[: self.reals.shape[2]]):
            columns[name] = self.reals[:, :, k].ravel()
        for k, name in enumerate(("agent_contacts", "wall_contacts", "contacting_agents")):
            columns[name] = self.counts[:, :, k].ravel().astype(np.int64)
        totals = self.counts.sum(axis=1, dtype=np.int64)  # each contact of two people is one of both
        columns["total_agent_contacts"] = np.repeat(totals[:, 0] // 2, agents)
        columns["total_wall_contacts"] = np.repeat(totals[:, 1], agents)
        order = "t,id,x,y,vx,vy,theta,omega,agent_contacts,wall_contacts,contacting_agents,normal_force".split(",")
        order += [name for name in OF_STEP_COLUMNS if name in columns]
        order += ["total_agent_contacts", "total_wall_contacts"]
        return pd.DataFrame(columns)[order]


OF_STEP_COLUMNS = ("mean_normal_force", "peak_normal_force", "peak_overlap")


def _of_step(values: NDArray[Any], which: int) -> NDArray[Any]:
    """One of `fmu.OF_STEP`, of values whose last axis is REALS and these."""
    place = len(REALS) + which
    if values.shape[-1] <= place:
        raise FmuError(f"the FMU has no output agent[i].{OF_STEP[which]}: an earlier version packed it; pack its Trial again")
    return values[..., place]


def simulate(
    fmu: Source | Fmu,
    drive: DriveLike = None,
    parameters: Mapping[str, Value] | None = None,
    until: float = 5.0,
    *,
    step: float | None = None,
) -> pd.DataFrame:
    """A run from the Trial's beginning until a time [s], as the table that `lemons run` writes, driven as there: by the
    drive.csv that is packed with the Trial, unless `drive` is given, or `False` for none (`--no-drive`). Its columns are
    t, id, x, y, vx, vy, theta, omega, agent_contacts, wall_contacts, contacting_agents, normal_force (at that time),
    mean_normal_force, peak_normal_force, peak_overlap (of the step that ends then; FMUs of the first versions do not
    have these three) and the crowd's total_agent_contacts, total_wall_contacts; units are s, m, rad, N.

    Raises:
        FmuError: the FMU's refusal, in its words.
        TypeError: the drive is nothing that can drive a crowd.
        ValueError: drive, time or step are of no use.
        OSError: the drive's file cannot be read.
    """
    with Crowd(fmu, parameters) as crowd:
        return crowd.run(drive, until=until, step=step).frame()
