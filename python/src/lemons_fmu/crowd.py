"""Crowds that can be stepped."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic
from types import TracebackType
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from .clock import clock_of, points_between
from .columns import ACTIVE, INPUTS
from .drive import Drive, DriveLike, Floats, forces, known
from .errors import FmuError
from .fmu import Fmu
from .instance import Instance, Value
from .leaving import LATEST, Leaving
from .loaded import Loaded, Source
from .made import Plan, model_of
from .model import Algorithm, Model, System
from .progress import Progress, ProgressLine
from .record import Record
from .run import Ints, Run, of_step

#: The end of a run: a time [s]; or "left": when everybody has left who has an exit, or nobody gets out any more (`leaving`).
Until = Union[float, Literal["left"]]


@dataclass(frozen=True, repr=False)
class State:
    """A saved crowd, including springs and parameters. It can be pickled, and restored in another process."""

    time: float
    data: bytes
    #: Of who decides where people walk.
    decision: bytes | None = None

    def __repr__(self) -> str:
        return f"<State at {self.time:g} s, {len(self.data) + len(self.decision or b'')} bytes>"


class Crowd:
    """A crowd of N people, initialized and ready to step.

    `what` is a Trial (its directory, or a zip of it), or a packed crowd: a file, the bytes of a file, or a result of `load`. The
    people of a Trial walk by its decision.toml, as in `lemons run`: the Decision FMU is coupled with the crowd's, and the
    results have the same bits. `plan` is another such file, or the FMU that decides (the way to walk with a packed crowd);
    with `plan=False` nobody walks. `algorithm` says how both exchange values ("jacobi", "gauss-seidel").

    `parameters` are set before initialization: parameters and start values by their names in the FMU; `agent[*].Mass` sets the
    mass of all agents, `decision.agent[3].DesiredSpeed` a parameter of Decision. Use it in a `with`, or `close` it: the next
    Crowd of the same FMU then uses its instance again. Only one thread at a time may use it; make one for each thread.

    Raises:
        FmuError: an FMU refuses something (the message is that of the FMU), or two do not fit together.
        CommandError: the command `lemons` refuses the Trial or the plan, or is missing; the message is its own.
        ValueError: the plan is for a Trial, and there is an FMU.
    """

    def __init__(
        self,
        what: Source | Fmu | Model,
        parameters: Mapping[str, Value] | None = None,
        *,
        plan: Plan = None,
        algorithm: Algorithm = "jacobi",
        start: float = 0.0,
    ) -> None:
        self._model = what if isinstance(what, Model) else model_of(what, plan, algorithm)
        #: The FMU of the crowd.
        self.fmu = self._model.fmu
        self._given: System | None = System(self._model)
        #: The current time [s].
        self.time = start
        try:
            self._system.initialize(parameters or {}, start)
        except BaseException:
            self.close()
            raise

    @property
    def plan(self) -> Loaded | None:
        """The FMU that decides where people walk; None: nobody walks. It can be the `plan` of another Crowd."""
        return self._model.decider

    @property
    def _system(self) -> System:
        if self._given is None:
            raise FmuError("the Crowd is closed")
        return self._given

    @property
    def _instance(self) -> Instance:
        return self._system.crowd

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
        walk = "" if self.plan is None else " who walk"
        return f"<Crowd of {self.fmu.agents} people{walk}, Trial {self.trial!r}, at {self.time:g} s>"

    def __len__(self) -> int:
        """The number of people."""
        return self.fmu.agents

    def __getitem__(self, name: str) -> Value:
        """Returns the value of a variable, of Decision as `decision.Arrived`."""
        return self._system.get(name)

    def close(self) -> None:
        """Gives the instance back. The Crowd cannot be used any more."""
        system, self._given = self._given, None
        if system is not None:
            system.close()

    def reset(self, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        """Goes back to the beginning of the Trial, with these parameters only."""
        self._system.reset()
        self.time = start
        self._system.initialize(parameters or {}, start)

    @property
    def trial(self) -> str:
        """Name of the packed Trial that is simulated."""
        return str(self._instance.get("Trial")) if "Trial" in self.fmu.variables else self.fmu.trial

    @property
    def messages(self) -> list[str]:
        """The messages of the FMUs, such as warnings."""
        return self._system.messages

    def set_drive(self, drive: Floats) -> None:
        """Sets Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3). They stay until they are set again.

        Raises:
            FmuError: people walk: Decision sets them in each step.
        """
        self._undecided("Fp.x")
        self._instance.set_real(self.fmu.inputs, forces(drive, self.fmu.agents))

    def drive(self) -> Floats:
        """Returns Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3)."""
        return self._reals(self.fmu.inputs)

    @property
    def active(self) -> Presence:
        """Whether people are there, as an array that can be written: `crowd.active[3] = False` takes somebody out. From the
        next step on they touch nothing and do not move; with True they come back where they were. Where people walk, Decision
        says who is there: it can only be read.

        Raises:
            FmuError: the FMU was packed by an early version, from whose crowd nobody can leave.
        """
        return Presence(self)

    @active.setter
    def active(self, values: npt.ArrayLike) -> None:
        self.active[:] = values

    @property
    def left(self) -> int:
        """How many people are not there: who have left, or were taken out."""
        return 0 if self.fmu.active is None else int((~self._instance.get_boolean(self.fmu.active)).sum())

    def _undecided(self, variable: str) -> None:
        """Checks that nobody else sets a variable of agents."""
        if f"agent[0].{variable}" in self._model.fed[-1]:
            raise FmuError(f"agent[i].{variable} is set by {self._model.plan} in each step; with plan=False nobody walks")

    def step(self, step: float | None = None) -> None:
        """Simulates a communication step [s]; by default the Trial's TimeStep."""
        self.step_to(self.time + (self._model.step_of(self.trial) if step is None else step))

    def step_to(self, time: float) -> None:
        """Simulates a communication step that ends at this time [s]."""
        self._system.step(self.time, time - self.time)
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
        return self._reals(np.ascontiguousarray(of_step(self.fmu.reals, 0)))

    def peak_squeeze(self) -> Floats:
        """Returns the largest squeeze within the last communication step [N], shape (N,)."""
        return self._reals(np.ascontiguousarray(of_step(self.fmu.reals, 1)))

    def peak_overlap(self) -> Floats:
        """Returns the deepest overlap of the contacts within the last communication step [m], shape (N,)."""
        return self._reals(np.ascontiguousarray(of_step(self.fmu.reals, 2)))

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
        *decision, crowd = self._system.save()
        return State(self.time, crowd, *decision)

    def restore(self, state: State) -> None:
        """Restores a state that was saved from this Crowd, or from another one of the same FMUs.

        Raises:
            FmuError: an FMU refuses it: it is of another crowd, or damaged.
            TypeError: it is not a State.
        """
        if not isinstance(state, State):
            raise TypeError(f"the state is of type {type(state).__name__}; it must be a State, which Crowd.save returns")
        self._system.restore([state.data] if state.decision is None else [state.decision, state.data])
        self.time = state.time

    def run(
        self,
        drive: DriveLike[Crowd] = None,
        *,
        until: Until,
        step: float | None = None,
        stop: Callable[[Crowd], bool] | None = None,
        progress: bool = False,
    ) -> Run:
        """Steps until a time [s], and returns poses, velocities, squeeze and contacts at all communication points. These are
        multiples of the step from the present time; the last step may be shorter. The default step is the Trial's TimeStep.

        With `until="left"` the run ends when everybody has left who has an exit; or, with a warning, when in 300 s nobody has
        left or got further than 5 m; at the latest at 3600 s. `stop` is a function of the Crowd that is called after each step:
        the run ends when it returns True. `Run.ended` says when all had left, or `stop` returned True.

        The default drive is the drive.csv packed with the Trial, as in `lemons run`; nothing where people walk. With `False` no
        drive is set: that of the Trial, or the one that was set before, continues. See `DriveLike` for other drives.
        `progress` shows the progress on standard error.

        Raises:
            FmuError: an FMU refuses something (the message is that of the FMU), or nobody can leave.
            TypeError: the drive is not a drive.
            ValueError: drive, time or step are not valid, or there is a drive for people who walk.
            OSError: the drive's file cannot be read.
        """
        drive = self._model.driven(known(drive, self.fmu.ids), self.trial)
        leaving = None
        if until == "left":
            leave, until = self._model.leave(), LATEST
            leaving = Leaving(leave)
        elif isinstance(until, str):
            raise ValueError(f"until={until!r}: must be a time [s], or 'left'")
        start, step = self.time, self._model.step_of(self.trial) if step is None else step
        steps, last = clock_of(start, until, step)
        pushes, driven = None, None
        if isinstance(drive, Drive) and drive.tables:
            pushes, driven = self._pushes(drive, points_between(start, until, step))
        elif isinstance(drive, np.ndarray):
            self.set_drive(drive)
        record = Record(self.fmu, self._instance, steps, leaving is None and stop is None)
        record.look(start)
        over = None if leaving is None else leaving.see(start, *record.standing())
        line, begin = (ProgressLine("steps", failing=False) if progress else None), monotonic()
        ended = start if over == "left" else None
        for k in range(1, steps + 1):
            if over is not None:
                break
            if pushes is not None and driven is not None:
                self._instance.set_real(driven, pushes[k - 1])
            elif callable(drive):
                self.set_drive(drive(self))
            self.step_to(last if k == steps else start + k * step)
            record.look(self.time)
            if line is not None:
                line(Progress(k, 0, steps, monotonic() - begin, 0, None))
            over = None if leaving is None else leaving.see(self.time, *record.standing())
            if over == "left" or (stop is not None and stop(self)):
                ended = self.time
            if ended is not None or over is not None:
                if line is not None:
                    line(Progress(k, 0, k, monotonic() - begin, 0, None))
                break
        if leaving is not None and ended is None:
            why = leaving.why(over)
            warnings.warn(f"{leaving.stay} people have not left: {why}; the run ends at t = {self.time:g} s", stacklevel=2)
        return record.finish(self.trial, ended, may_leave=self._model.may_leave)

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
        self._crowd._undecided(ACTIVE.variable)
        given = np.asarray(values)
        if not np.isin(given, (0, 1)).all():
            raise ValueError(f"whether people are there must be True or False, not {values!r}")
        all_of_them = self._values()
        all_of_them[which] = given
        self._crowd._instance.set_boolean(self._references, all_of_them)
