"""What is simulated: the FMU of a crowd, alone or with the FMU that decides where its people walk."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import files
from .columns import ACTIVE
from .drive import Known
from .errors import FmuError
from .fmu import Fmu
from .instance import Value
from .loaded import Loaded

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: How coupled FMUs exchange values: as `--algorithm` of `lemons run`.
Algorithm = Literal["jacobi", "gauss-seidel"]
ALGORITHMS = {"jacobi": "Jacobi", "gauss-seidel": "Gauss-Seidel"}

#: Names of the components, in the order in which Gauss-Seidel steps them.
DECISION, CROWD = COMPONENTS = ("decision", "crowd")
#: In the resources of a Decision FMU: what everybody does.
PLAN_FILE = "decision.toml"
_TYPES = ("Real", "Integer", "Boolean")


class Wires(NamedTuple):
    """Outputs of one component and the inputs of the other one that they feed, all of one type."""

    type: str
    outputs: NDArray[np.uint32]
    inputs: NDArray[np.uint32]


@dataclass(frozen=True)
class Model:
    """FMUs that are simulated together, in any number of threads."""

    fmu: Fmu
    #: Who decides where people walk; None: nobody walks.
    decider: Loaded | None = None
    algorithm: Algorithm = "jacobi"
    #: In messages: what says where they walk.
    plan: str = ""

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            raise ValueError(f"the algorithm is {self.algorithm!r}; it must be one of {', '.join(ALGORITHMS)}")
        if self.decider is not None and not any(self.wires[0]):
            raise FmuError(f"{self.plan}: no output has the name of an input of the crowd: it decides nothing")

    @property
    def parts(self) -> tuple[Loaded, ...]:
        """The FMUs, the crowd last."""
        return (self.fmu,) if self.decider is None else (self.decider, self.fmu)

    @cached_property
    def wires(self) -> tuple[list[Wires], list[Wires]]:
        """From the decider to the crowd, and back: each output feeds the input of the same name, as `lemons connect` does.

        Raises:
            FmuError: two that have the same name differ in type or unit.
        """
        if self.decider is None:
            return [], []
        return _wires(self.decider, self.fmu), _wires(self.fmu, self.decider)

    @cached_property
    def fed(self) -> tuple[set[str], ...]:
        """Of each part the names of the inputs that the other one feeds."""
        if self.decider is None:
            return (set(),)
        return _fed(self.fmu, self.decider), _fed(self.decider, self.fmu)

    def find(self, name: str) -> tuple[int, str]:
        """Returns the place of the part, and the variable, that a name means; without a component, that of the crowd."""
        components = COMPONENTS[-len(self.parts) :]
        if len(self.parts) == 1 and name in self.fmu.variables:
            return 0, name
        for place, component in enumerate(components):
            if name.startswith(f"{component}."):
                return place, name[len(component) + 1 :]
        return len(self.parts) - 1, name

    def expand(self, name: str) -> tuple[int, list[str]]:
        """Returns the place of the part, and the variables, that a name stands for.

        Raises:
            FmuError: there are none.
        """
        place, own = self.find(name)
        try:
            return place, self.parts[place].expand(own)
        except FmuError:
            for component, part in zip(COMPONENTS[-len(self.parts) :], self.parts):
                if part is not self.parts[place] and _has(part, own):
                    raise FmuError(f"the FMU has no variable {own!r}; did you mean {f'{component}.{own}'!r}?") from None
            raise

    def set_by(self, name: str) -> list[int]:
        """Returns the places of the parts that a value with this name sets, as `Model::set_by` of crates/master: without a
        component, a parameter of people is set of all parts that have it."""
        main, own = self.find(name)
        shared = own == name and own.startswith("agent[")
        return [main] + [k for k, part in enumerate(self.parts) if shared and k != main and _has(part, own, parameter=True)]

    def check(self, name: str) -> None:
        """Checks that a value with this name can be set.

        Raises:
            FmuError: there is no such variable, or the other FMU feeds it.
        """
        place, names = self.expand(name)
        fed = next((each for each in names if each in self.fed[place]), None)
        if fed is not None:
            raise FmuError(f"{name}: would be overwritten: {COMPONENTS[1 - place]} feeds {fed} (plan=False: nobody walks)")

    def step_of(self, trial: str) -> float:
        """Returns the communication step of a packed Trial [s]: the smallest that an FMU asks for."""
        own = None if self.decider is None else self.decider.own_step
        return min(self.fmu.step_of(trial), own) if own and own > 0 else self.fmu.step_of(trial)

    def driven(self, drive: Known[Any], trial: str) -> Known[Any]:
        """Returns what drives people of a packed Trial, by what is given: `None` becomes the packed drive.csv.

        Raises:
            ValueError: there is a drive for people who walk, or the packed one is not valid.
        """
        if self.decider is None:
            return self.fmu.drive(trial) if drive is None else drive
        if drive is not None and drive is not False:
            raise ValueError(f"there is a drive, but people walk by {self.plan}: give no drive, or plan=False")
        return False

    @property
    def may_leave(self) -> bool:
        """Whether the decider says who is there."""
        return f"agent[0].{ACTIVE.variable}" in self.fed[-1]

    def leave(self) -> int:
        """Returns how many people have an exit. Of deciders that do not say it, all may leave.

        Raises:
            FmuError: nobody can leave.
        """
        nobody = "until='left': nobody can leave: people do not walk, or have no exits (give a time)"
        if self.decider is None or not self.may_leave:
            raise FmuError(nobody)
        with self.decider.unpacked() as directory:
            path = directory / "resources" / PLAN_FILE
            if not path.is_file():
                return self.fmu.agents
            plan = tomllib.loads(files.read_text(path, files.LARGEST_BINARY))
        leave = sum(_leaves(each.get("destination"), plan.get("targets", [])) for each in plan["agents"])
        if leave == 0:
            raise FmuError(nobody)
        return leave


def _leaves(destination: Any, targets: list[Any]) -> bool:
    if isinstance(destination, dict):
        return not targets[destination["target"]]["stay"]
    return bool(destination == "nearest-exit")


def _has(part: Loaded, name: str, *, parameter: bool = False) -> bool:
    try:
        names = part.expand(name)
    except FmuError:
        return False
    return not parameter or all(part.variables[each].causality == "parameter" for each in names)


def _fed(source: Loaded, target: Loaded) -> set[str]:
    outputs = {name for name, one in source.variables.items() if one.causality == "output"}
    return {name for name, one in target.variables.items() if one.causality == "input" and name in outputs}


def _wires(source: Loaded, target: Loaded) -> list[Wires]:
    pairs: dict[str, list[tuple[int, int]]] = {kind: [] for kind in _TYPES}
    fed = _fed(source, target)
    for name, taken in target.variables.items():
        if name not in fed:
            continue
        sent = source.variables[name]
        if sent.type != taken.type or taken.type not in pairs:
            raise FmuError(f"{name}: an output of type {sent.type} cannot feed an input of type {taken.type}")
        if sent.unit and taken.unit and sent.unit != taken.unit:
            raise FmuError(f"{name}: an output in {sent.unit} cannot feed an input in {taken.unit} here; lemons connect converts")
        pairs[taken.type].append((sent.reference, taken.reference))
    found = []
    for kind, both in pairs.items():
        if both:
            outputs, inputs = np.array(both, dtype=np.uint32).T
            found.append(Wires(kind, np.ascontiguousarray(outputs), np.ascontiguousarray(inputs)))
    return found


class System:
    """Instances of the FMUs of a model, which step together as in crates/master/src/system.rs, in the same order of calls:
    results have the same bits."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._instances = []
        try:
            for part in model.parts:
                self._instances.append(part.borrow())
        except BaseException:
            self.close()
            raise
        self.crowd = self._instances[-1]
        #: Of each part the newest values of its outputs; None: not read yet.
        self._newest: list[list[NDArray[Any]] | None] = [None] * len(self._instances)

    def close(self) -> None:
        """Gives the instances back."""
        for part, instance in zip(self.model.parts, self._instances):
            part.give_back(instance)
        self._instances = []

    def reset(self) -> None:
        """Goes back to the state after instantiation."""
        for k, instance in enumerate(self._instances):
            with self._told(k):
                instance.reset()
        self._newest = [None] * len(self._instances)

    def set(self, name: str, value: Value) -> None:
        """Sets a parameter or a start value.

        Raises:
            FmuError: there is no such variable, the other FMU feeds it, or its FMU refuses it.
        """
        self.model.check(name)
        _, own = self.model.find(name)
        for place in self.model.set_by(name):
            with self._told(place):
                self._instances[place].set(own, value)

    def get(self, name: str) -> Value:
        """Returns the value of a variable."""
        place, own = self.model.find(name)
        self.model.expand(name)
        return self._instances[place].get(own)

    @property
    def messages(self) -> list[str]:
        """The messages of the FMUs; if there are two, with their names."""
        if len(self._instances) == 1:
            return self.crowd.messages
        named = zip(COMPONENTS, self._instances)
        return [f"{name}: {message}" for name, instance in named for message in instance.messages]

    def initialize(self, parameters: Mapping[str, Value], start: float) -> None:
        """Sets the parameters and completes initialization at a time [s]. In between the first values are exchanged."""
        # This package sends the packed drive itself.
        own = {"PlayDrive": False} if "PlayDrive" in self.model.fmu.variables else {}
        for name, value in {**own, **parameters}.items():
            self.set(name, value)
        parts = range(len(self._instances))
        for k in parts:
            with self._told(k):
                self._instances[k].enter(start)
        for _ in parts:
            news = [self._read(k) for k in parts]
            if not any(news):
                break
            for k in parts:
                self._send(k)
        for k in parts:
            with self._told(k):
                self._instances[k].leave()
        for k in parts:
            self._read(k)

    def step(self, time: float, step: float) -> None:
        """A communication step from a time, both [s]."""
        parts = range(len(self._instances))
        if self.model.algorithm == "jacobi":
            for k in parts:
                self._send(k)
            for k in parts:
                self._advance(k, time, step)
            for k in parts:
                self._read(k)
        else:
            for k in parts:
                self._send(k)
                self._advance(k, time, step)
                self._read(k)

    def save(self) -> list[bytes]:
        """Returns the state of each part."""
        return [instance.save() for instance in self._instances]

    def restore(self, states: list[bytes]) -> None:
        """Restores states. The values that are exchanged are then those of the outputs."""
        if len(states) != len(self._instances):
            raise FmuError("the state is of people who walk, and these do not, or the other way round")
        for k, (instance, state) in enumerate(zip(self._instances, states)):
            with self._told(k):
                instance.restore(state)
        for k in range(len(self._instances)):
            self._read(k)

    def _advance(self, k: int, time: float, step: float) -> None:
        with self._told(k):
            self._instances[k].do_step(time, step)

    def _read(self, k: int) -> bool:
        """Reads the outputs of a part that feed the other one; whether one is new."""
        if len(self._instances) == 1:
            return False
        before, values = self._newest[k], []
        with self._told(k):
            for kind, outputs, _ in self.model.wires[k]:
                values.append(_get(self._instances[k], kind, outputs))
        self._newest[k] = values
        return before is None or not all(map(np.array_equal, before, values))

    def _send(self, k: int) -> None:
        """Sets the inputs of a part that the other one feeds."""
        if len(self._instances) == 1:
            return
        values = self._newest[1 - k] or []
        with self._told(k):
            for (kind, _, inputs), each in zip(self.model.wires[1 - k], values):
                _set(self._instances[k], kind, inputs, each)

    def _told(self, k: int) -> _Told:
        return _Told(COMPONENTS[k] if len(self._instances) > 1 else "")


class _Told:
    """Says in errors whose they are, if there are two FMUs."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: object, error: BaseException | None, _at: object) -> None:
        if self.name and isinstance(error, FmuError):
            raise FmuError(f"{self.name}: {error}") from error.__cause__


def _get(instance: Any, kind: str, references: NDArray[np.uint32]) -> NDArray[Any]:
    if kind == "Boolean":
        booleans: NDArray[Any] = instance.get_boolean(references)
        return booleans
    values = np.empty(references.shape, dtype=np.float64 if kind == "Real" else np.int32)
    (instance.get_real if kind == "Real" else instance.get_integer)(references, values)
    return values


def _set(instance: Any, kind: str, references: NDArray[np.uint32], values: NDArray[Any]) -> None:
    setter = {"Real": instance.set_real, "Integer": instance.set_integer, "Boolean": instance.set_boolean}[kind]
    setter(references, values)
