"""Packed crowds, unpacked and loaded once per process, and their instances, which are used again."""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import itertools
import os
import shutil
import tempfile
import threading
import zipfile
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
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
from fmpy.fmi3 import FMU3Slave
from numpy.typing import NDArray

from . import columns, files, locks
from .arrays import AGENTS, Array, Plan, names, of_materials, plan
from .columns import INPUTS
from .drive import Drive, read

Value = Union[float, int, str]
Source = Union[str, "os.PathLike[str]", bytes]

DRIVE_FILE = "drive.csv"
_STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
_WARNING, _FATAL = 1, 4
# Of FMI 3.0, and what they are here.
_TYPES = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String"}
# Messages come as arguments of printf. The FMU always gives "%s" and one text, which on 64-bit Linux and Windows is an
# ordinary sixth argument. (fmpy's proxy for such loggers supports only one logger in a process.)
_Logger = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p
)


class FmuError(Exception):
    """The FMU refused a call or failed (the message is that of the FMU), or its file is not valid."""


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU."""

    reference: int
    type: str  # Real, Integer, Boolean or String
    causality: str


class Fmu:
    """A packed crowd that this process has loaded, returned by `load`. Threads may share it."""

    def __init__(self, data: bytes, sha256: str) -> None:
        directory = scratch() / sha256
        try:
            _check_unpacked(data)
            fmpy.extract(BytesIO(data), directory)
            description = fmpy.read_model_description(str(directory), validate=False)
        except Exception as error:  # fmpy and zipfile raise any exception
            shutil.rmtree(directory, ignore_errors=True)
            what = "cannot be unpacked" if isinstance(error, OSError) else "is not a readable FMU"
            raise FmuError(f"{what}: {error}") from error
        if description.fmiVersion[:2] not in ("2.", "3.") or description.coSimulation is None:
            raise FmuError("is not a co-simulation FMU of FMI 2.0 or 3.0")
        self.data = data
        self.sha256 = sha256
        self.directory = directory
        self.guid: str = description.guid
        self.model_name: str = description.modelName
        self.identifier: str = description.coSimulation.modelIdentifier
        #: The variables of FMI 3.0, of which arrays are read and set whole; empty for FMI 2.0.
        self.arrays = _arrays(description) if description.fmiVersion.startswith("3.") else []
        #: Single values by name. In FMI 3.0 a reference is the place among the values of all variables.
        self.variables = {
            v.name: Variable(int(v.valueReference), str(v.type), str(v.causality)) for v in description.modelVariables
        }
        if self.arrays:
            self.variables = _singles(description, self.arrays)
        self._plans: dict[bytes, Plan] = {}
        experiment = description.defaultExperiment
        size = None if experiment is None else experiment.stepSize
        #: Communication step of the default Trial [s].
        self.step: float = float(size) if size else 0.05
        #: Name of the default Trial, which is simulated unless the parameter `Trial` names another.
        self.trial = str(next((v.start for v in description.modelVariables if v.name == "Trial"), ""))
        agents = 0
        while f"agent[{agents}].Mp" in self.variables:
            agents += 1
        if agents == 0:
            raise FmuError(f"{self.model_name!r} is not a packed crowd: it has no variable agent[0].Mp")
        #: Number of people.
        self.agents = agents
        self._idle: list[Instance] = []
        self._lock = threading.Lock()
        self._of_materials: dict[str, list[str]] = {}
        #: Ids of the agents in Agents.xml.
        self.ids: list[str]
        if self.arrays:
            self.ids, materials = self._read_ids()
            self._of_materials = of_materials(self.arrays, materials)
        else:
            words = {v.name: v.description or "" for v in description.modelVariables}
            self.ids = [_id_in(words[f"agent[{i}].Mp"], i) for i in range(agents)]
        self.inputs = self.references(INPUTS)
        of_step = [quantity.variable for quantity in columns.OF_STEP]
        #: Whether the FMU has the outputs `columns.OF_STEP`.
        self.has_means = all(f"agent[0].{name}" in self.variables for name in of_step)
        reals = [quantity.variable for quantity in columns.REALS]
        self.reals = self.references(reals + of_step if self.has_means else reals)
        self.counts = self.references([quantity.variable for quantity in columns.CONTACTS])
        present = columns.ACTIVE.variable
        #: The inputs that say who is there; None in FMUs of earlier versions.
        self.active = self.references([present])[:, 0].copy() if f"agent[0].{present}" in self.variables else None
        self._drives: dict[str, Drive | None] = {}
        self._steps: dict[str, float] = {}

    def __repr__(self) -> str:
        return f"<Fmu {self.model_name!r}, {self.agents} agents, {self.sha256[:12]}>"

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        """It is pickled as its bytes. The process that reads them loads them, if it has not done so before."""
        return load, (self.data,)

    def _packed(self, trial: str, file: str) -> Path | None:
        """Returns the path of a file of a packed Trial, if it exists."""
        path = self.directory / "resources" / trial / file
        return path if trial and Path(trial).name == trial and path.is_file() else None

    def has(self, trial: str) -> bool:
        """Returns whether a Trial with this name is packed."""
        return self._packed(trial, "Parameters.xml") is not None

    def drive(self, trial: str) -> Drive | None:
        """Returns the drive in the drive.csv of a packed Trial; None if it has none.

        Raises:
            ValueError: the file is not valid.
        """
        with self._lock:
            if trial not in self._drives:
                path = self._packed(trial, DRIVE_FILE)
                # The temporary path of the unpacked FMU would be of no use in messages.
                name = f"{trial}/{DRIVE_FILE} in the FMU"
                self._drives[trial] = None if path is None else read(path.read_bytes(), name, self.ids)
            return self._drives[trial]

    def step_of(self, trial: str) -> float:
        """Returns the communication step of a packed Trial [s]."""
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
        """Returns the value references of `agent[i].<name>`, as an array with one row for each agent."""
        chosen = range(self.agents) if agents is None else agents
        try:
            rows = [[self.variables[f"agent[{i}].{name}"].reference for name in names] for i in chosen]
        except KeyError as missing:
            raise FmuError(f"the FMU has no variable {missing}") from None
        return np.array(rows, dtype=np.uint32).reshape(len(rows), len(names))

    def expand(self, name: str) -> list[str]:
        """Returns the names of the variables that a name stands for: `agent[*].Mass` stands for the masses of all agents.

        Raises:
            FmuError: the FMU has no such variable.
        """
        names = [name.replace("agent[*]", f"agent[{i}]", 1) for i in range(self.agents)] if "agent[*]" in name else [name]
        names = self._of_materials.get(name, names)
        for each in names:
            if each not in self.variables:
                raise FmuError(f"the FMU has no variable {each!r}; `lemons info` lists them")
        return names

    def borrow(self) -> Instance:
        """Returns an instance in the state after instantiation; call `give_back` later."""
        with self._lock:
            if self._idle:
                return self._idle.pop()
        return (ArrayInstance if self.arrays else Instance)(self)

    def plan(self, keys: NDArray[np.uint32]) -> Plan:
        """Returns how values of FMI 3.0 are read by one call; it is found out once for the same values."""
        known = keys.tobytes()
        found = self._plans.get(known)
        if found is None:
            found = self._plans[known] = plan(keys, self.arrays)
        return found

    def _read_ids(self) -> tuple[list[str], list[str]]:
        """Returns the Ids of agents and of materials, which an instance of FMI 3.0 tells."""
        instance = self.borrow()
        with instance.calls() as slave:
            slave.enterInitializationMode()
            ids = [
                [str(text) for text in slave.getString([array.reference], array.size)]
                for name in ("AgentId", "MaterialId")
                for array in self.arrays
                if array.name == name
            ]
        self.give_back(instance)
        if len(ids) != 2 or len(ids[0]) != self.agents:
            raise FmuError(f"{self.model_name!r} is not a packed crowd: it has no Ids of its agents and materials")
        return ids[0], ids[1]

    def give_back(self, instance: Instance) -> None:
        """Resets an instance and keeps it for later, or drops it if it cannot be reset."""
        try:
            instance.reset()
        except FmuError:
            instance.drop()
            return
        with self._lock:
            self._idle.append(instance)


class Instance:
    """An instance of the FMU, and its messages."""

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
                self.slave.instantiate(callbacks=self._callbacks, loggingOn=True)
            except Exception as error:
                raise FmuError(self._why(str(error))) from error
        self._first = [text for _, text in self._said]
        self._said.clear()
        library = self.slave.dll
        self._component = ctypes.c_void_p(self.slave.component)
        self._set_real = _function(library, "fmi2SetReal")
        self._get_real = _function(library, "fmi2GetReal")
        self._get_integer = _function(library, "fmi2GetInteger")
        self._get_boolean = _function(library, "fmi2GetBoolean")
        self._set_boolean = _function(library, "fmi2SetBoolean")
        self._do_step = library["fmi2DoStep"]
        self._do_step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        self._do_step.restype = ctypes.c_int

    def _log(self, _environment: object, _name: bytes, status: int, _kind: bytes, form: bytes, text: int | None) -> None:
        message = ctypes.string_at(text) if form == b"%s" and text else form
        # The temporary path of the unpacked FMU would be of no use in messages.
        # A number sign in a message is doubled (FMI 2.0.5, section 2.1.5).
        said = message.decode("utf-8", "replace").replace("##", "#")
        self._said.append((status, said.replace(f"{self.fmu.directory}/", "")))

    def _why(self, otherwise: str) -> str:
        """Returns the error messages since the last error."""
        words = [text for status, text in self._said if status > _WARNING]
        self._said.clear()
        return "\n".join(words) or otherwise

    @property
    def messages(self) -> list[str]:
        """Its messages while it was made, and since the last reset."""
        return self._first + [text for _, text in self._said]

    def _check(self, function: str, status: int) -> None:
        if status > _WARNING:
            self.fatal |= status == _FATAL
            said = f"{function[:4]}{_STATUS[status]}" if status < len(_STATUS) else str(status)
            raise FmuError(self._why(f"{function}: {said}"))

    @contextmanager
    def calls(self) -> Iterator[Any]:
        """Gives fmpy's instance. Refused calls raise `FmuError` with the message of the FMU."""
        try:
            yield self.slave
        except FMICallException as error:
            self._check(error.function, error.status)
            raise

    # The addresses of contiguous arrays are passed to C directly; fmpy would make lists of them.

    def set_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        status = self._set_real(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2SetReal", status)

    def get_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        status = self._get_real(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2GetReal", status)

    def get_integer(self, references: NDArray[np.uint32], values: NDArray[np.int32]) -> None:
        status = self._get_integer(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2GetInteger", status)

    def get_boolean(self, references: NDArray[np.uint32]) -> NDArray[np.bool_]:
        values = np.empty(references.shape, dtype=np.int32)
        status = self._get_boolean(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2GetBoolean", status)
        read: NDArray[np.bool_] = values != 0
        return read

    def set_boolean(self, references: NDArray[np.uint32], values: NDArray[np.bool_]) -> None:
        numbers = values.astype(np.int32)
        status = self._set_boolean(self._component, references.ctypes.data, references.size, numbers.ctypes.data)
        self._check("fmi2SetBoolean", status)

    def do_step(self, time: float, step: float) -> None:
        self._check("fmi2DoStep", self._do_step(self._component, time, step, 1))

    def set(self, name: str, value: Value) -> None:
        """Sets a variable, or `agent[*].<name>` of all agents."""
        for each in self.fmu.expand(name):
            variable = self.fmu.variables[each]
            with self.calls() as slave:
                if variable.type == "Real":
                    slave.setReal([variable.reference], [_real(each, value)])
                elif variable.type == "Integer":
                    slave.setInteger([variable.reference], [_integer(each, value)])
                elif variable.type == "Boolean":
                    slave.setBoolean([variable.reference], [_boolean(each, value)])
                elif variable.type == "String":
                    if not isinstance(value, str):
                        raise FmuError(f"{each} must be a text, not {value!r}")
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
            if variable.type == "Boolean":
                return bool(slave.getBoolean([variable.reference])[0])
            if variable.type == "String":
                text = slave.getString([variable.reference])[0]
                return text.decode() if isinstance(text, bytes) else str(text)
        raise FmuError(f"{name} is a {variable.type}: not supported")

    def initialize(self, parameters: Mapping[str, Value], start: float) -> None:
        """Sets the parameters and completes initialization."""
        for name, value in parameters.items():
            self.set(name, value)
        with self.calls() as slave:
            slave.setupExperiment(startTime=start)
            slave.enterInitializationMode()
            slave.exitInitializationMode()

    def save(self) -> bytes:
        """Returns the state as bytes."""
        with self.calls() as slave:
            state = slave.getFMUstate()
            try:
                return bytes(slave.serializeFMUstate(state))
            finally:
                slave.freeFMUstate(state)

    def restore(self, data: bytes) -> None:
        """Restores a state."""
        with self.calls() as slave:
            restored = slave.deSerializeFMUstate(data)
            try:
                slave.setFMUstate(restored)
            finally:
                slave.freeFMUstate(restored)

    def reset(self) -> None:
        if self.fatal:
            raise FmuError("the instance cannot be used after a fatal error")
        with self.calls() as slave:
            slave.reset()
        self._said.clear()

    def drop(self) -> None:
        """Frees it, except after a fatal error: FMI then forbids all calls."""
        if not self.fatal:
            with _loading:
                self.slave.freeInstance()


class ArrayInstance(Instance):
    """An instance of an FMI 3.0 FMU. Arrays are read and set whole: where some of their elements are set, the others keep the
    values that they have."""

    def __init__(self, fmu: Fmu) -> None:
        self.fmu = fmu
        self.fatal = False
        self._said = deque(maxlen=100)
        with _loading:
            try:
                self.slave = FMU3Slave(
                    guid=fmu.guid,
                    unzipDirectory=str(fmu.directory),
                    modelIdentifier=fmu.identifier,
                    instanceName=f"crowd {next(_numbers)}",
                )
                self.slave.instantiate(logMessage=self._hear, loggingOn=True)
            except Exception as error:
                raise FmuError(self._why(str(error))) from error
        self._first = [text for _, text in self._said]
        self._said.clear()
        library = self.slave.dll
        self._component = ctypes.c_void_p(self.slave.component)
        self._set_float64 = _function(library, "fmi3SetFloat64", counted=True)
        self._get_float64 = _function(library, "fmi3GetFloat64", counted=True)
        self._get_int32 = _function(library, "fmi3GetInt32", counted=True)
        self._get_bool = _function(library, "fmi3GetBoolean", counted=True)
        self._set_bool = _function(library, "fmi3SetBoolean", counted=True)
        self._step = library["fmi3DoStep"]
        flags = [ctypes.c_void_p] * 4
        self._step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *flags]
        self._step.restype = ctypes.c_int
        #: What a step tells: three Booleans and a time [s].
        self._flags = [ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()]
        self._reached = ctypes.c_double()
        self._initialized = False
        self._later: list[tuple[list[str], Value]] = []

    def _hear(self, _environment: object, status: int, _kind: bytes, text: bytes) -> None:
        self._said.append((status, text.decode("utf-8", "replace").replace(f"{self.fmu.directory}/", "")))

    def _call(self, name: str, function: Any, found: Plan, values: NDArray[Any]) -> None:
        references = found.references
        status = function(self._component, references.ctypes.data, references.size, values.ctypes.data, values.size)
        self._check(name, status)

    def _get(self, name: str, function: Any, keys: NDArray[np.uint32], values: NDArray[Any]) -> None:
        found = self.fmu.plan(keys)
        if found.places is None:
            self._call(name, function, found, values)
            return
        read = np.empty(found.size, dtype=values.dtype)
        self._call(name, function, found, read)
        values[...] = read[found.places].reshape(values.shape)

    def _set(self, kind: str, get: Any, set: Any, keys: NDArray[np.uint32], values: NDArray[Any]) -> None:
        found = self.fmu.plan(keys)
        if found.places is not None:
            read = np.empty(found.size, dtype=values.dtype)
            if not found.whole:
                self._call(f"fmi3Get{kind}", get, found, read)
            read[found.places] = values.ravel()
            values = read
        self._call(f"fmi3Set{kind}", set, found, values)

    def set_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        self._set("Float64", self._get_float64, self._set_float64, references, values)

    def get_real(self, references: NDArray[np.uint32], values: NDArray[np.float64]) -> None:
        self._get("fmi3GetFloat64", self._get_float64, references, values)

    def get_integer(self, references: NDArray[np.uint32], values: NDArray[np.int32]) -> None:
        self._get("fmi3GetInt32", self._get_int32, references, values)

    def get_boolean(self, references: NDArray[np.uint32]) -> NDArray[np.bool_]:
        values = np.empty(references.shape, dtype=np.bool_)
        self._get("fmi3GetBoolean", self._get_bool, references, values)
        return values

    def set_boolean(self, references: NDArray[np.uint32], values: NDArray[np.bool_]) -> None:
        self._set("Boolean", self._get_bool, self._set_bool, references, np.ascontiguousarray(values))

    def do_step(self, time: float, step: float) -> None:
        flags = [ctypes.byref(flag) for flag in self._flags]
        status = self._step(self._component, time, step, True, *flags, ctypes.byref(self._reached))
        self._check("fmi3DoStep", status)
        if any(flag.value for flag in self._flags):
            raise FmuError(f"fmi3DoStep: the FMU ended the step at {self._reached.value:g} s")

    def set(self, name: str, value: Value) -> None:
        names = self.fmu.expand(name)
        variables = [self.fmu.variables[each] for each in names]
        kind, reference = variables[0].type, variables[0].reference
        array = next(one for one in reversed(self.fmu.arrays) if one.begin <= reference)
        if array.shape and not self._initialized:
            # The other elements of the array cannot be read before.
            self._later.append((names, value))
        elif kind in ("Real", "Boolean"):
            self._set_all(names, value)
        elif array.shape:
            raise FmuError(f"{names[0]} is an element of an array of type {kind}: not supported")
        else:
            with self.calls() as slave:
                if kind == "Integer":
                    slave.setInt32([array.reference], [_integer(names[0], value)])
                elif kind == "String":
                    if not isinstance(value, str):
                        raise FmuError(f"{names[0]} must be a text, not {value!r}")
                    slave.setString([array.reference], [value])
                else:
                    raise FmuError(f"{names[0]} is a {kind}: not supported")

    def get(self, name: str) -> Value:
        name = self.fmu.expand(name)[0]
        variable = self.fmu.variables[name]
        keys = np.array([variable.reference], dtype=np.uint32)
        if variable.type == "Real":
            real = np.empty(1)
            self.get_real(keys, real)
            return float(real[0])
        if variable.type == "Integer":
            integer = np.empty(1, dtype=np.int32)
            self.get_integer(keys, integer)
            return int(integer[0])
        if variable.type == "Boolean":
            return bool(self.get_boolean(keys)[0])
        if variable.type == "String":
            found = self.fmu.plan(keys)
            with self.calls() as slave:
                texts = slave.getString([int(found.references[0])], found.size)
            return str(texts[0 if found.places is None else int(found.places[0])])
        raise FmuError(f"{name} is a {variable.type}: not supported")

    def _set_all(self, names: Sequence[str], value: Value) -> None:
        """Sets Reals or Booleans, all of them to one value."""
        keys = np.array([self.fmu.variables[each].reference for each in names], dtype=np.uint32)
        if self.fmu.variables[names[0]].type == "Boolean":
            self.set_boolean(keys, np.full(len(names), _boolean(names[0], value)))
        else:
            self.set_real(keys, np.full(len(names), _real(names[0], value)))

    def initialize(self, parameters: Mapping[str, Value], start: float) -> None:
        for name, value in parameters.items():
            self.set(name, value)
        with self.calls() as slave:
            slave.enterInitializationMode(startTime=start)
            self._initialized = True
            later, self._later = self._later, []
            for names, value in later:
                if self.fmu.variables[names[0]].type not in ("Real", "Boolean"):
                    raise FmuError(f"{names[0]} is an element of an array of neither Reals nor Booleans: not supported")
                self._set_all(names, value)
            slave.exitInitializationMode()

    def save(self) -> bytes:
        with self.calls() as slave:
            state = slave.getFMUState()
            try:
                return bytes(slave.serializeFMUState(state))
            finally:
                slave.freeFMUState(state)

    def restore(self, data: bytes) -> None:
        with self.calls() as slave:
            restored = slave.deserializeFMUState(data)
            try:
                slave.setFMUState(restored)
            finally:
                slave.freeFMUState(restored)

    def reset(self) -> None:
        super().reset()
        self._initialized = False
        self._later.clear()


def _arrays(description: Any) -> list[Array]:
    """Returns the variables of FMI 3.0 that have values here: Reals of 64 bits, Integers of 32 bits, Booleans, texts."""
    variables = description.modelVariables
    counts = [variable.valueReference for variable in variables if variable.name == AGENTS]
    found, begin = [], 0
    for variable in variables:
        if variable.type not in _TYPES:
            continue
        first = variable.dimensions[0].valueReference if variable.dimensions else None
        of_agents = first is not None and first in counts
        array = Array(variable.name, int(variable.valueReference), tuple(variable.shape or ()), of_agents, begin)
        found.append(array)
        begin += array.size
    return found


def _singles(description: Any, arrays: Sequence[Array]) -> dict[str, Variable]:
    """Returns the values of FMI 3.0 by their names."""
    own = {variable.name: variable for variable in description.modelVariables}
    by_name = {array.name: array for array in arrays}
    singles = {}
    for array in arrays:
        kind, causality = _TYPES[own[array.name].type], str(own[array.name].causality)
        for place, name in enumerate(names(array, by_name)):
            singles[name] = Variable(array.begin + place, kind, causality)
    return singles


def _function(library: ctypes.CDLL, name: str, counted: bool = False) -> Any:
    """Returns a new function object, so that the argument types of fmpy's do not change; in FMI 3.0 values are counted."""
    function = library[name]
    count = [ctypes.c_size_t] if counted else []
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, *count]
    function.restype = ctypes.c_int
    return function


def _real(name: str, value: Value) -> float:
    try:
        return float(value)
    except ValueError:
        raise FmuError(f"{name} must be a number, not {value!r}") from None


def _integer(name: str, value: Value) -> int:
    if isinstance(value, str) or value != value or int(value) != value:
        raise FmuError(f"{name} must be an integer, not {value!r}")
    return int(value)


def _boolean(name: str, value: Value) -> bool:
    if isinstance(value, str) or value not in (0, 1):
        raise FmuError(f"{name} must be True or False, not {value!r}")
    return bool(value)


def _id_in(description: str, place: int) -> str:
    """Returns the Id in "agent Id 7: propulsion torque", or the index if the description has none."""
    head, colon, _ = description.rpartition(": ")
    return head.removeprefix("agent Id ") if colon and head.startswith("agent Id ") else str(place)


_loading = threading.RLock()
_loaded: dict[str, Fmu] = {}  # by SHA-256
_numbers = itertools.count()
_own_scratch: list[Path] = []
_own_lock: list[int] = []


def load(fmu: Source | Fmu) -> Fmu:
    """Loads a packed crowd from a file or from its bytes. A process unpacks and loads the same bytes only once.

    Raises:
        FmuError: the file cannot be read, or is not a packed crowd.
    """
    if isinstance(fmu, Fmu):
        return fmu
    if isinstance(fmu, bytes):
        data = fmu
    else:
        if os.path.isdir(fmu):
            raise FmuError(
                f"{os.fspath(fmu)}: is a Trial's directory, not an FMU: pack it (lemons_fmu.pack). Nobody walks in the FMU of a "
                "Trial alone: where people walk, use simulate, or the command `lemons sweep`"
            )
        try:
            data = files.read(fmu, files.LARGEST_BINARY)
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


def _check_unpacked(data: bytes) -> None:
    """Checks that an archive does not unpack to too many bytes. `zipfile` unpacks no more of an entry than its header says."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > files.LARGEST_UNPACKED:
        raise ValueError(f"it unpacks to {unpacked / 1e6:.0f} MB; at most {files.LARGEST_UNPACKED / 1e6:g} MB are allowed")


def scratch() -> Path:
    """Returns the temporary directory of this process, which is removed at exit. It also removes the directories of killed
    processes: a lock on the file beside a directory shows that its process lives."""
    if not _own_scratch:
        # On Windows each user has a temporary directory.
        user = os.getuid() if hasattr(os, "getuid") else 0
        base = Path(tempfile.gettempdir()) / f"lemons-fmu-{user}"
        base.mkdir(mode=0o700, exist_ok=True)
        if base.is_symlink() or base.stat().st_uid != user:
            raise FmuError(f"{base} belongs to another user")
        for lock in base.glob("*.lock"):
            _remove_if_dead(lock)
        while True:
            place = base / f"{os.getpid()}-{os.urandom(4).hex()}"
            path = place.with_suffix(".lock")
            descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600)
            try:
                locks.lock(descriptor)
                if path.exists():
                    break
            except OSError:
                pass  # another process took it for that of a dead one: it removes it, or has already
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
        locks.lock(descriptor)
    except OSError:
        os.close(descriptor)  # its process lives
        return
    shutil.rmtree(lock.with_suffix(""), ignore_errors=True)
    _unlink(lock, descriptor)


def _unlink(lock: Path, descriptor: int) -> None:
    """Removes a locked file. Windows does not remove what is open; elsewhere it must be locked until it is gone."""
    if os.name == "nt":
        os.close(descriptor)
    with suppress(OSError):
        lock.unlink(missing_ok=True)
    if os.name != "nt":
        os.close(descriptor)


def _remove(place: Path, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(place, ignore_errors=True)
        # Windows keeps the files of loaded libraries: the next process removes them, by the lock that stays.
        if not place.exists() and _own_lock:
            _unlink(place.with_suffix(".lock"), _own_lock.pop())


def _forget() -> None:
    """Lets a forked child share neither directory nor instances."""
    global _loading
    _loading = threading.RLock()
    _loaded.clear()
    _own_scratch.clear()
    for descriptor in _own_lock:
        os.close(descriptor)
    _own_lock.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
