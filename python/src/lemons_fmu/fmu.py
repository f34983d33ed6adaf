"""A packed crowd, unpacked and loaded once per process, and its instances, used again and again."""

from __future__ import annotations

import atexit
import ctypes
import fcntl
import hashlib
import itertools
import os
import shutil
import tempfile
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Union
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from numpy.typing import NDArray

from .drive import Drive, read

Value = Union[float, int, str]
Source = Union[str, "os.PathLike[str]", bytes]

INPUTS = ("Fp.x", "Fp.y", "Mp")
REALS = ("Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega", "NormalForce")
#: Of the last communication step; FMUs of the first versions have no such outputs.
OF_STEP = ("MeanNormalForce", "PeakNormalForce", "PeakOverlap")
COUNTS = ("AgentContacts", "WallContacts", "ContactingAgents")
DRIVE_FILE = "drive.csv"
_STATUS = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")
_WARNING, _FATAL = 1, 4
# A message comes as printf wants it. The FMU always says "%s" and one text, which on 64-bit Linux is a sixth argument
# like any other. (fmpy's proxy for such loggers knows only one logger in a process.)
_Logger = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p
)


class FmuError(Exception):
    """What the FMU refused or could not do, in its own words, or what is wrong with the file."""


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU."""

    reference: int
    type: str  # Real, Integer or String
    causality: str


class Fmu:
    """A packed crowd that this process has loaded; `load` makes it. Threads may share it."""

    def __init__(self, data: bytes, sha256: str) -> None:
        directory = scratch() / sha256
        try:
            fmpy.extract(BytesIO(data), directory)
            description = fmpy.read_model_description(str(directory), validate=False)
        except Exception as error:  # fmpy and zipfile raise what they like
            shutil.rmtree(directory, ignore_errors=True)
            what = "cannot be unpacked" if isinstance(error, OSError) else "not a readable FMU"
            raise FmuError(f"{what}: {error}") from error
        if description.fmiVersion != "2.0" or description.coSimulation is None:
            raise FmuError("not an FMU for co-simulation of FMI 2.0")
        self.data = data
        self.sha256 = sha256
        self.directory = directory
        self.guid: str = description.guid
        self.model_name: str = description.modelName
        self.identifier: str = description.coSimulation.modelIdentifier
        self.variables = {
            v.name: Variable(int(v.valueReference), str(v.type), str(v.causality)) for v in description.modelVariables
        }
        experiment = description.defaultExperiment
        size = None if experiment is None else experiment.stepSize
        #: Communication step that the default Trial asks for [s].
        self.step: float = float(size) if size else 0.05
        #: The Trial that is simulated unless the parameter `Trial` names another.
        self.trial = str(next((v.start for v in description.modelVariables if v.name == "Trial"), ""))
        agents = 0
        while f"agent[{agents}].Mp" in self.variables:
            agents += 1
        if agents == 0:
            raise FmuError(f"{self.model_name!r} is no packed crowd: it has no variable agent[0].Mp")
        #: How many people there are.
        self.agents = agents
        words = {v.name: v.description or "" for v in description.modelVariables}
        #: Of each agent, the Id of Agents.xml.
        self.ids = [_id_in(words[f"agent[{i}].Mp"], i) for i in range(agents)]
        self.inputs = self.references(INPUTS)
        #: Whether mean and peak squeeze of a communication step are outputs.
        self.has_means = all(f"agent[0].{name}" in self.variables for name in OF_STEP)
        self.reals = self.references(REALS + OF_STEP if self.has_means else REALS)
        self.counts = self.references(COUNTS)
        self._idle: list[Instance] = []
        self._lock = threading.Lock()
        self._drives: dict[str, Drive | None] = {}
        self._steps: dict[str, float] = {}

    def __repr__(self) -> str:
        return f"<Fmu {self.model_name!r}, {self.agents} agents, {self.sha256[:12]}>"

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        """Pickled, it is its bytes; the process that reads them loads them, unless it has them."""
        return load, (self.data,)

    def _packed(self, trial: str, file: str) -> Path | None:
        """A file of a packed Trial, if it is there."""
        path = self.directory / "resources" / trial / file
        return path if trial and Path(trial).name == trial and path.is_file() else None

    def has(self, trial: str) -> bool:
        """Whether a Trial of that name is packed."""
        return self._packed(trial, "Parameters.xml") is not None

    def drive(self, trial: str) -> Drive | None:
        """What drives people by the drive.csv of a packed Trial; None if it has none.

        Raises:
            ValueError: what is wrong with the file.
        """
        with self._lock:
            if trial not in self._drives:
                path = self._packed(trial, DRIVE_FILE)
                # Where this process has unpacked the FMU says nothing to anybody.
                name = f"{trial}/{DRIVE_FILE} in the FMU"
                self._drives[trial] = None if path is None else read(path.read_bytes(), name, self.ids)
            return self._drives[trial]

    def step_of(self, trial: str) -> float:
        """Communication step that a packed Trial asks for [s]."""
        if trial == self.trial:
            return self.step
        with self._lock:
            if trial not in self._steps:
                path = self._packed(trial, "Parameters.xml")
                times = None if path is None else ElementTree.parse(path).getroot().find("Times")
                if times is None:
                    raise FmuError(f"the FMU has no Trial {trial!r}")
                self._steps[trial] = float(times.attrib["TimeStep"])
            return self._steps[trial]

    def references(self, names: Sequence[str], agents: Sequence[int] | None = None) -> NDArray[np.uint32]:
        """Value references of `agent[i].<name>`, as rows of an array: one for each agent."""
        chosen = range(self.agents) if agents is None else agents
        try:
            rows = [[self.variables[f"agent[{i}].{name}"].reference for name in names] for i in chosen]
        except KeyError as missing:
            raise FmuError(f"the FMU has no variable {missing}") from None
        return np.array(rows, dtype=np.uint32).reshape(len(rows), len(names))

    def expand(self, name: str) -> list[str]:
        """The variables that a name stands for: `agent[*].Mass` stands for the mass of everybody.

        Raises:
            FmuError: the FMU has no such variable, or it cannot be set.
        """
        names = [name.replace("agent[*]", f"agent[{i}]", 1) for i in range(self.agents)] if "agent[*]" in name else [name]
        for each in names:
            if each not in self.variables:
                raise FmuError(f"the FMU has no variable {each!r}; `lemons info` lists them")
        return names

    def borrow(self) -> Instance:
        """An instance in the state after instantiation; give it back."""
        with self._lock:
            if self._idle:
                return self._idle.pop()
        return Instance(self)

    def give_back(self, instance: Instance) -> None:
        """Resets an instance and keeps it for the next, or drops it if it cannot be reset."""
        try:
            instance.reset()
        except FmuError:
            instance.drop()
            return
        with self._lock:
            self._idle.append(instance)


class Instance:
    """An instance of the FMU, and what it said."""

    def __init__(self, fmu: Fmu) -> None:
        self.fmu = fmu
        self.fatal = False
        self._said: deque[tuple[int, str]] = deque(maxlen=100)  # status, message
        self._logger = _Logger(self._log)
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = ctypes.cast(self._logger, fmi2CallbackLoggerTYPE)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        with _loading:  # fmpy changes the working directory while it loads a library
            try:
                self.slave = FMU2Slave(
                    guid=fmu.guid,
                    unzipDirectory=str(fmu.directory),
                    modelIdentifier=fmu.identifier,
                    instanceName=f"crowd {next(_numbers)}",
                )
                self.slave.instantiate(callbacks=self._callbacks)
            except Exception as error:
                raise FmuError(self._why(str(error))) from error
        self._first = [text for _, text in self._said]
        self._said.clear()
        library = self.slave.dll
        self._component = ctypes.c_void_p(self.slave.component)
        self._set_real = _function(library, "fmi2SetReal")
        self._get_real = _function(library, "fmi2GetReal")
        self._get_integer = _function(library, "fmi2GetInteger")
        self._do_step = library["fmi2DoStep"]
        self._do_step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        self._do_step.restype = ctypes.c_int

    def _log(self, _environment: object, _name: bytes, status: int, _kind: bytes, form: bytes, text: int | None) -> None:
        message = ctypes.string_at(text) if form == b"%s" and text else form
        # Where this process has unpacked the FMU says nothing to anybody.
        self._said.append((status, message.decode("utf-8", "replace").replace(f"{self.fmu.directory}/", "")))

    def _why(self, otherwise: str) -> str:
        """What was said about errors since the last of them."""
        words = [text for status, text in self._said if status > _WARNING]
        self._said.clear()
        return "\n".join(words) or otherwise

    @property
    def messages(self) -> list[str]:
        """What it said since it was made, and since it was reset."""
        return self._first + [text for _, text in self._said]

    def _check(self, function: str, status: int) -> None:
        if status > _WARNING:
            self.fatal |= status == _FATAL
            raise FmuError(self._why(f"{function}: {_STATUS[status] if status < len(_STATUS) else status}"))

    @contextmanager
    def calls(self) -> Iterator[FMU2Slave]:
        """fmpy's instance; its refusals come out as `FmuError` in the words of the FMU."""
        try:
            yield self.slave
        except FMICallException as error:
            self._check(error.function, error.status)
            raise

    # The addresses of contiguous arrays go to C as they are: fmpy would make lists of them.

    def set_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        status = self._set_real(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2SetReal", status)

    def get_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        status = self._get_real(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2GetReal", status)

    def get_integer(self, references: NDArray[np.uint32], values: NDArray[np.int32]) -> None:
        status = self._get_integer(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2GetInteger", status)

    def do_step(self, time: float, step: float) -> None:
        self._check("fmi2DoStep", self._do_step(self._component, time, step, 1))

    def set(self, name: str, value: Value) -> None:
        """Sets a variable, or `agent[*].<name>` of everybody."""
        for each in self.fmu.expand(name):
            variable = self.fmu.variables[each]
            with self.calls() as slave:
                if variable.type == "Real":
                    slave.setReal([variable.reference], [_real(each, value)])
                elif variable.type == "Integer":
                    slave.setInteger([variable.reference], [_integer(each, value)])
                elif variable.type == "String":
                    if not isinstance(value, str):
                        raise FmuError(f"{each} is text, not {value!r}")
                    slave.setString([variable.reference], [value])
                else:
                    raise FmuError(f"{each} is a {variable.type}: not supported")

    def get(self, name: str) -> Value:
        variable = self.fmu.variables.get(name)
        if variable is None:
            raise FmuError(f"the FMU has no variable {name!r}; `lemons info` lists them")
        with self.calls() as slave:
            if variable.type == "Real":
                return float(slave.getReal([variable.reference])[0])
            if variable.type == "Integer":
                return int(slave.getInteger([variable.reference])[0])
            if variable.type == "String":
                text = slave.getString([variable.reference])[0]
                return text.decode() if isinstance(text, bytes) else str(text)
        raise FmuError(f"{name} is a {variable.type}: not supported")

    def initialize(self, parameters: Mapping[str, Value], start: float) -> None:
        """Sets the parameters and leaves initialization."""
        for name, value in parameters.items():
            self.set(name, value)
        with self.calls() as slave:
            slave.setupExperiment(startTime=start)
            slave.enterInitializationMode()
            slave.exitInitializationMode()

    def reset(self) -> None:
        if self.fatal:
            raise FmuError("the instance is lost")
        with self.calls() as slave:
            slave.reset()
        self._said.clear()

    def drop(self) -> None:
        """Frees it, unless FMI forbids that: after fmi2Fatal nothing may be called."""
        if not self.fatal:
            with _loading:
                self.slave.freeInstance()


def _function(library: ctypes.CDLL, name: str) -> Any:
    """A function of its own, so that fmpy's argument types stay as they are."""
    function = library[name]
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]
    function.restype = ctypes.c_int
    return function


def _real(name: str, value: Value) -> float:
    try:
        return float(value)
    except ValueError:
        raise FmuError(f"{name} is a number, not {value!r}") from None


def _integer(name: str, value: Value) -> int:
    if isinstance(value, str) or value != value or int(value) != value:
        raise FmuError(f"{name} is an integer, not {value!r}")
    return int(value)


def _id_in(description: str, place: int) -> str:
    """The Id in "agent Id 7: propulsion torque"; its place where the description does not say."""
    head, colon, _ = description.rpartition(": ")
    return head.removeprefix("agent Id ") if colon and head.startswith("agent Id ") else str(place)


_loading = threading.RLock()
_loaded: dict[str, Fmu] = {}  # by SHA-256
_numbers = itertools.count()
_own_scratch: list[Path] = []
_own_lock: list[int] = []


def load(fmu: Source | Fmu) -> Fmu:
    """A packed crowd, from a file or from its bytes. A process unpacks and loads the same bytes once.

    Raises:
        FmuError: it cannot be read, or is no packed crowd.
    """
    if isinstance(fmu, Fmu):
        return fmu
    if isinstance(fmu, bytes):
        data = fmu
    else:
        try:
            data = Path(fmu).read_bytes()
        except OSError as error:
            raise FmuError(f"{os.fspath(fmu)}: {error.strerror}") from error
    sha256 = hashlib.sha256(data).hexdigest()
    with _loading:
        if sha256 not in _loaded:
            try:
                _loaded[sha256] = Fmu(data, sha256)
            except FmuError as error:
                raise error if isinstance(fmu, bytes) else FmuError(f"{os.fspath(fmu)}: {error}") from None
        return _loaded[sha256]


def scratch() -> Path:
    """The directory of this process for what it unpacks, removed at exit; what processes that were killed have left
    is removed here. A lock on the file beside it says that its process lives."""
    if not _own_scratch:
        base = Path(tempfile.gettempdir()) / f"lemons-fmu-{os.getuid()}"
        base.mkdir(mode=0o700, exist_ok=True)
        if base.is_symlink() or base.stat().st_uid != os.getuid():
            raise FmuError(f"{base} is somebody else's")
        for lock in base.glob("*.lock"):
            _remove_if_dead(lock)
        while True:
            place = base / f"{os.getpid()}-{os.urandom(4).hex()}"
            path = place.with_suffix(".lock")
            descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            if path.exists():  # else another process took it for a dead one's before it was locked
                break
            os.close(descriptor)
        place.mkdir(mode=0o700)
        _own_scratch.append(place)
        _own_lock.append(descriptor)
        atexit.register(_remove, place, os.getpid())
    return _own_scratch[0]


def _remove_if_dead(lock: Path) -> None:
    try:
        descriptor = os.open(lock, os.O_RDWR)
    except OSError:
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        shutil.rmtree(lock.with_suffix(""), ignore_errors=True)
        lock.unlink(missing_ok=True)
    except OSError:
        pass  # its process lives
    finally:
        os.close(descriptor)


def _remove(place: Path, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(place, ignore_errors=True)
        place.with_suffix(".lock").unlink(missing_ok=True)


def _forget() -> None:
    """A forked child shares neither directory nor instances."""
    global _loading
    _loading = threading.RLock()
    _loaded.clear()
    _own_scratch.clear()
    for descriptor in _own_lock:
        os.close(descriptor)
    _own_lock.clear()


os.register_at_fork(after_in_child=_forget)
