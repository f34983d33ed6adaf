"""Crowds that can be stepped."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic
from types import TracebackType
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from . import _native
from ._native import SimulationError
from .drive import Drive, DriveLike, Floats, forces, known
from .progress import Progress, ProgressLine
from .record import PLACE, Ints, Run

#: What is simulated: a Trial (its directory, or its zip), or the FMU of a crowd, by its path.
Source = Union[str, "os.PathLike[str]"]
#: The value of a parameter.
Value = Union[float, int, bool, str]
#: The end of a run: a time [s]; or "left": when everybody has left who has an exit, or nobody gets out any more.
Until = Union[float, Literal["left"]]
#: In which order crowd and Decision step: as `--algorithm` of `lemons run`.
Algorithm = Literal["jacobi", "gauss-seidel"]
#: Where people walk. None: by the decision.toml of the Trial, if it has one. False: nobody walks. Or such a file, by its path.
DecisionChoice = Union[None, Literal[False], str, "os.PathLike[str]"]

#: [s] For so long a run goes on before Python looks for Ctrl-C and shows the progress.
_PART = 0.1
_MOST_STEPS = 1_000_000_000
#: Names of parameters that are the propulsion of agents.
_PROPULSION = re.compile(r"(?:crowd\.)?agent\[(\d+|\*)\]\.(?:Fp\.[xy]|Mp)")


def model_of(what: Source | _native.Model, decision: DecisionChoice = None) -> _native.Model:
    """Reads what is simulated.

    Raises:
        CommandError: the Trial or the decision.toml has errors; or there is an FMU without a Trial.
        TypeError: `decision` is none, or `what` is not a path.
        ValueError: a decision.toml is given for an FMU.
    """
    if isinstance(what, _native.Model):
        return what
    if not (decision is None or decision is False or isinstance(decision, (str, os.PathLike))):
        raise TypeError(f"decision={decision!r}: must be None, False, or the path of a decision.toml")
    path = os.fspath(what)
    if not isinstance(path, str):
        raise TypeError(f"{type(what).__name__}: give the path of a Trial or of the FMU of a crowd; FMPy runs other FMUs")
    given = None if decision is None or decision is False else os.fspath(decision)
    if given is not None and given.lower().endswith(".fmu"):
        raise ValueError(f"decision={given!r}: give the decision.toml; an FMU that decides is coupled by lemons connect, or with FMPy")
    if given is not None and path.lower().endswith(".fmu"):
        raise ValueError(f"decision={given!r}: is for a Trial: give the Trial instead of its FMU")
    return _native.Model.read(path, given, decision is not False)


@dataclass(frozen=True, repr=False)
class State:
    """A saved crowd, including springs, parameters, and what its people have decided. It can be pickled, and restored in
    another process."""

    time: float
    data: bytes

    def __repr__(self) -> str:
        return f"<State at {self.time:g} s, {len(self.data)} bytes>"


class Finding(str):
    """What a rule has found: the line of `lemons run`, and its parts."""

    #: Id of the rule (docs/reference/rules.md); "error", "warning" or "note"; file, line, element and attribute; the rest.
    rule: str
    severity: str
    subject: str
    message: str

    @classmethod
    def of(cls, row: tuple[str, str, str, str, str]) -> Finding:
        found = cls(row[0])
        found.rule, found.severity, found.subject, found.message = row[1:]
        return found


class Crowd:
    """A crowd of N people, initialized and ready to step.

    `what` is a Trial (its directory, or a zip of it), or the FMU of a crowd: the first Trial in it is simulated by this
    package's own mechanics. The people of a Trial walk by its decision.toml, as in `lemons run`, and the results have the
    same bits. `decision` is another such file; with `decision=False` nobody walks. `algorithm` says in which order the crowd
    and who decides step ("jacobi", "gauss-seidel").

    `parameters` are set before initialization: parameters and start values by their names in the FMU; `agent[*].Mass` sets the
    mass of all agents, `decision.agent[3].DesiredSpeed` a parameter of Decision. Only one thread at a time may use a Crowd;
    make one for each thread.

    Raises:
        CommandError: the Trial or the decision.toml has errors; the message is that of `lemons run`.
        SimulationError: a parameter is unknown or refused.
        ValueError: a decision.toml is given for an FMU, or the algorithm is unknown.
    """

    def __init__(
        self,
        what: Source | _native.Model,
        parameters: Mapping[str, Value] | None = None,
        *,
        decision: DecisionChoice = None,
        algorithm: Algorithm = "jacobi",
        start: float = 0.0,
    ) -> None:
        #: What is simulated. It can be given instead of the Trial, and pickled.
        self.model = model_of(what, decision)
        #: Ids of the agents in Agents.xml.
        self.ids: tuple[str, ...] = tuple(self.model.ids)
        #: Warnings and notes so far, as those of `lemons run`; what a rule has found is a `Finding`.
        self.messages: list[str] = [Finding.of(row) for row in self.model.warnings]
        self._own: _native.Simulation | None = _native.Simulation(self.model, algorithm)
        self._begin(parameters, start)

    def _begin(self, parameters: Mapping[str, Value] | None, start: float) -> None:
        # `run` plays the drive of the Trial itself.
        self._held: set[int] = set()
        for name, value in {"PlayDrive": False, **(parameters or {})}.items():
            self._simulation.set(name, value)
            if held := _PROPULSION.fullmatch(name):
                self._held.update(range(len(self)) if held[1] == "*" else [int(held[1])])
        self._simulation.begin(start)
        self._start = start
        self._ends: list[str] = []
        self._hear()

    def _hear(self) -> None:
        self.messages += self._simulation.take_warnings()

    @property
    def _simulation(self) -> _native.Simulation:
        if self._own is None:
            raise SimulationError("the Crowd is closed")
        return self._own

    @property
    def decision(self) -> str | None:
        """The file by which people walk; None: nobody walks."""
        return None if self.model.decision is None else os.fspath(self.model.decision)

    @property
    def trial(self) -> str:
        """Name of the Trial that is simulated."""
        return self.model.trial

    @property
    def variables(self) -> list[str]:
        """Names of all variables, those of Decision as `decision.Arrived`."""
        return self._simulation.variables()

    @property
    def time(self) -> float:
        """The current time [s]."""
        return self._simulation.time

    def __enter__(self) -> Crowd:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._own is None:
            return "<Crowd, closed>"
        walk = "" if self.decision is None else " who walk"
        return f"<Crowd of {len(self)} people{walk}, Trial {self.trial!r}, at {self.time:g} s>"

    def __len__(self) -> int:
        """The number of people."""
        return len(self.ids)

    def __getitem__(self, name: str) -> Value:
        """Returns the value of a variable, of Decision as `decision.Arrived`."""
        return self._simulation.get(name)

    def close(self) -> None:
        """Frees the memory. The Crowd cannot be used any more."""
        self._own = None

    def reset(self, parameters: Mapping[str, Value] | None = None, *, start: float = 0.0) -> None:
        """Goes back to the beginning of the Trial, with these parameters only."""
        self._simulation.reset()
        self._begin(parameters, start)

    def set_drive(self, drive: Floats) -> None:
        """Sets Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3). They stay until they are set again. Of people who walk
        they are added to the forces with which they walk."""
        self._simulation.push(forces(drive, len(self)))

    def drive(self) -> Floats:
        """Returns Fp.x, Fp.y [N] and Mp [N.m] of all agents, shape (N, 3)."""
        return self._simulation.drive()

    @property
    def active(self) -> Presence:
        """Whether people are there, as an array that can be written: `crowd.active[3] = False` takes somebody out. From the
        next step on they touch nothing and do not move; with True they come back where they were. Where people walk, Decision
        says who is there: it can only be read."""
        return Presence(self)

    @active.setter
    def active(self, values: npt.ArrayLike) -> None:
        self.active[:] = values

    def set_open(self, name: str, is_open: bool) -> None:
        """Keeps a door or an exit shut, or lets it be open at its times, from the next step on: `door[0]` is the first of the
        walls that open, `exit[0]` the first exit of decision.toml."""
        self._simulation.set_open(name, is_open)

    @property
    def left(self) -> int:
        """How many people are not there: who have left, or were taken out."""
        return int((self._simulation.observe()[:, PLACE["active"]] == 0.0).sum())

    def step(self, step: float | None = None) -> None:
        """Simulates a communication step [s]; by default the Trial's TimeStep."""
        self.step_to(self.time + (self.model.step if step is None else step))

    def step_to(self, time: float) -> None:
        """Simulates a communication step that ends at this time [s]."""
        self._simulation.step_to(time)
        self._hear()

    def poses(self) -> Floats:
        """Returns x, y [m] and theta [rad] of all agents, shape (N, 3)."""
        return self._simulation.observe()[:, 0:3]

    def velocities(self) -> Floats:
        """Returns vx, vy [m/s] and omega [rad/s] of all agents, shape (N, 3)."""
        return self._simulation.observe()[:, 3:6]

    def squeeze(self) -> Floats:
        """Returns the present squeeze of all agents, shape (N,): the sum of |F_n| over the contacts [N]. Collisions last
        milliseconds, so it depends on the instant; `mean_squeeze` and `peak_squeeze` do not."""
        return self._simulation.observe()[:, PLACE["normal_force"]]

    def mean_squeeze(self) -> Floats:
        """Returns the mean squeeze over the last communication step [N], shape (N,): its impulse / the step."""
        return self._simulation.observe()[:, PLACE["mean_normal_force"]]

    def peak_squeeze(self) -> Floats:
        """Returns the largest squeeze within the last communication step [N], shape (N,)."""
        return self._simulation.observe()[:, PLACE["peak_normal_force"]]

    def peak_overlap(self) -> Floats:
        """Returns the deepest overlap of the contacts within the last communication step [m], shape (N,)."""
        return self._simulation.observe()[:, PLACE["peak_overlap"]]

    def mean_wall_squeeze(self) -> Floats:
        """Returns the part of the mean squeeze over the last communication step by walls [N], shape (N,)."""
        return self._simulation.observe()[:, PLACE["mean_wall_force"]]

    def contacts(self) -> Ints:
        """Returns for all agents the number of contacts with people, of contacts with walls, and of people that touch: shape
        (N, 3)."""
        return self._simulation.observe()[:, PLACE["agent_contacts"] : PLACE["contacting_agents"] + 1].astype(np.int32)

    def masses(self) -> Floats:
        """Returns the masses of all agents [kg], shape (N,)."""
        return self._simulation.masses()

    def save(self) -> State:
        """Returns the state, including contacts. After it is restored, results have the same bits."""
        return State(self.time, self._simulation.save())

    def restore(self, state: State) -> None:
        """Restores a state that was saved from this Crowd, or from another one of the same Trial.

        Raises:
            SimulationError: it is of another crowd, or damaged.
            TypeError: it is not a State.
        """
        if not isinstance(state, State):
            raise TypeError(f"the state is of type {type(state).__name__}; it must be a State, which Crowd.save returns")
        self._simulation.restore(state.data)

    def run(
        self,
        drive: DriveLike[Crowd] = None,
        *,
        until: Until,
        step: float | None = None,
        stop: Callable[[Crowd], bool] | None = None,
        progress: bool | Callable[[Progress], None] = False,
    ) -> Run:
        """Steps until a time [s], and returns poses, velocities, squeeze and contacts at all communication points. These are
        multiples of the step from the present time; the last step may be shorter. The default step is the Trial's TimeStep.

        With `until="left"` the run ends when everybody has left who has an exit; or, with a warning, when in 300 s nobody has
        left or got further than 5 m; at the latest at 3600 s. `stop` is a function of the Crowd that is called after each step:
        the run ends when it returns True. `Run.ended` says when all had left, or `stop` returned True.

        The default drive is the drive.csv of the Trial, as in `lemons run`; where people walk, a drive is added to the forces with
        which they walk. With `False` no drive is set: that of the Trial, or the one that was set before, continues. See
        `DriveLike` for other drives. `progress` shows the progress on standard error, or is a function that gets it. Ctrl-C
        ends the run between two steps.

        Raises:
            SimulationError: the simulation refuses something, or nobody can leave.
            TypeError: the drive is not a drive.
            ValueError: drive, time or step are not valid.
            OSError: the drive's file cannot be read.
        """
        drive = known(drive, self.ids)
        if drive is None:
            # An agent whose propulsion is set has no other.
            drive = Drive({agent: table for agent, table in self.model.drive().items() if agent not in self._held})
        if isinstance(until, str) and until != "left":
            raise ValueError(f"until={until!r}: must be a time [s], or 'left'")
        simulation, step = self._simulation, self.model.step if step is None else float(step)
        whole = simulation.time == self._start
        recording = _native.Recording(simulation, None if isinstance(until, str) else float(until), step, stop is None)
        if isinstance(drive, Drive) and drive.tables:
            agents, pushes = self._pushes(drive, recording.points())
            recording.push(agents, pushes)
        elif isinstance(drive, np.ndarray):
            self.set_drive(drive)
        report = progress if callable(progress) else ProgressLine("steps", failing=False) if progress else None
        begin, met = monotonic(), False
        # A function is called between any two steps.
        most = 1 if stop is not None or callable(drive) else _MOST_STEPS
        while not (recording.is_over or met):
            if callable(drive):
                self.set_drive(drive(self))
            recording.advance(simulation, most, _PART)
            self._hear()
            met = stop is not None and stop(self)
            if report is not None:
                steps, done = recording.steps
                report(Progress(done, 0, done if met or recording.is_over else steps, monotonic() - begin, 0, None))
        # Of several runs, what is found at the end of the last one.
        self.messages = [text for text in self.messages if text not in self._ends]
        self._ends = [Finding.of(row) for row in recording.findings(simulation, whole)]
        self.messages += self._ends
        why = None if met else recording.why_some_stay()
        if why is not None:
            warnings.warn(why, stacklevel=2)
        times, numbers = recording.finish()
        leaving = self.decision is not None or not bool(numbers[:, :, PLACE["active"]].all())
        ended = float(times[-1]) if met or recording.have_left else None
        return Run(times, numbers, self.ids, leaving, ended, self.model)

    def _pushes(self, drive: Drive, times: Floats) -> tuple[list[int], Floats]:
        """Returns the agents of tables, and their values at each step."""
        moments = times[:-1] if drive.at == "start" else (times[:-1] + times[1:]) / 2
        masses = self.masses() if drive.per_mass else np.ones(len(self))
        pushes = [masses[agent] * drive.sample(agent, moments) for agent in drive.tables]
        return list(drive.tables), np.ascontiguousarray(np.stack(pushes, axis=1))


class Presence:
    """Of each person of a Crowd, whether they are there. What is written goes into the Crowd at once."""

    def __init__(self, crowd: Crowd) -> None:
        self._crowd = crowd

    def _values(self) -> NDArray[np.bool_]:
        return self._crowd._simulation.observe()[:, PLACE["active"]].astype(bool)

    def __array__(self, dtype: npt.DTypeLike = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self._values(), dtype=dtype)

    def __len__(self) -> int:
        return len(self._crowd)

    def __repr__(self) -> str:
        return repr(self._values())

    def __getitem__(self, which: Any) -> Any:
        """Of one person True or False; of several an array."""
        found = self._values()[which]
        return bool(found) if isinstance(found, np.bool_) else found

    def __setitem__(self, which: Any, values: npt.ArrayLike) -> None:
        if self._crowd.decision is not None:
            raise SimulationError(f"agent[i].Active is set by {self._crowd.decision} in each step; with decision=False nobody walks")
        given = np.asarray(values)
        if not np.isin(given, (0, 1)).all():
            raise ValueError(f"whether people are there must be True or False, not {values!r}")
        all_of_them = self._values()
        all_of_them[which] = given
        self._crowd._simulation.set_active(all_of_them)
