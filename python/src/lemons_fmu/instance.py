"""An instance of an FMU of FMI 2.0, and what all instances share."""

from __future__ import annotations

import ctypes
import itertools
import os
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, Union

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

from .arrays import Array, Plan
from .errors import FmuError

Value = Union[float, int, str]

_STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
_WARNING, _FATAL = 1, 4
# Messages come as arguments of printf. The FMU always gives "%s" and one text, which on 64-bit Linux and Windows is an
# ordinary sixth argument. (fmpy's proxy for such loggers supports only one logger in a process.)
_Logger = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p
)


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU."""

    reference: int
    type: str  # Real, Integer, Boolean or String
    causality: str
    unit: str | None


class Described(Protocol):
    """What an instance must know of its FMU."""

    guid: str
    identifier: str
    #: Where it is unpacked.
    directory: Path
    variables: dict[str, Variable]
    arrays: list[Array]

    def expand(self, name: str) -> list[str]: ...

    def plan(self, keys: NDArray[np.uint32]) -> Plan: ...


_loading = [threading.RLock()]
#: For the names of instances.
numbers = itertools.count()


@contextmanager
def loading() -> Iterator[None]:
    """Lets nobody else load a library. fmpy changes the working directory meanwhile, and stays there if it fails."""
    with _loading[0]:
        here = os.getcwd()
        try:
            yield
        finally:
            os.chdir(here)


def _forget() -> None:
    """Nobody holds the lock in a forked child."""
    _loading[0] = threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


class Instance:
    """An instance of the FMU, and its messages."""

    def __init__(self, fmu: Described) -> None:
        self.fmu = fmu
        self.fatal = False
        self._said: deque[tuple[int, str]] = deque(maxlen=100)  # status, message
        self._logger = _Logger(self._log)
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = ctypes.cast(self._logger, fmi2CallbackLoggerTYPE)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        with loading():
            try:
                self.slave = FMU2Slave(
                    guid=fmu.guid,
                    unzipDirectory=str(fmu.directory),
                    modelIdentifier=fmu.identifier,
                    instanceName=f"{fmu.identifier} {next(numbers)}",
                )
                self.slave.instantiate(callbacks=self._callbacks, loggingOn=True)
            except Exception as error:
                raise FmuError(self._why(str(error))) from error
        self._first = [text for _, text in self._said]
        self._said.clear()
        library = self.slave.dll
        self._component = ctypes.c_void_p(self.slave.component)
        self._set_real = function(library, "fmi2SetReal")
        self._get_real = function(library, "fmi2GetReal")
        self._get_integer = function(library, "fmi2GetInteger")
        self._set_integer = function(library, "fmi2SetInteger")
        self._get_boolean = function(library, "fmi2GetBoolean")
        self._set_boolean = function(library, "fmi2SetBoolean")
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

    def set_integer(self, references: NDArray[np.uint32], values: NDArray[np.int32]) -> None:
        status = self._set_integer(self._component, references.ctypes.data, references.size, values.ctypes.data)
        self._check("fmi2SetInteger", status)

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
                    slave.setReal([variable.reference], [real(each, value)])
                elif variable.type == "Integer":
                    slave.setInteger([variable.reference], [integer(each, value)])
                elif variable.type == "Boolean":
                    slave.setBoolean([variable.reference], [boolean(each, value)])
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

    def enter(self, start: float) -> None:
        """Enters initialization mode at a time [s]."""
        with self.calls() as slave:
            slave.setupExperiment(startTime=start)
            slave.enterInitializationMode()

    def leave(self) -> None:
        """Completes initialization."""
        with self.calls() as slave:
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
            with loading():
                self.slave.freeInstance()


def function(library: ctypes.CDLL, name: str, counted: bool = False) -> Any:
    """Returns a new function object, so that the argument types of fmpy's do not change; in FMI 3.0 values are counted."""
    function = library[name]
    count = [ctypes.c_size_t] if counted else []
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, *count]
    function.restype = ctypes.c_int
    return function


def real(name: str, value: Value) -> float:
    try:
        return float(value)
    except ValueError:
        raise FmuError(f"{name} must be a number, not {value!r}") from None


def integer(name: str, value: Value) -> int:
    if isinstance(value, str) or value != value or int(value) != value:
        raise FmuError(f"{name} must be an integer, not {value!r}")
    return int(value)


def boolean(name: str, value: Value) -> bool:
    if isinstance(value, str) or value not in (0, 1):
        raise FmuError(f"{name} must be True or False, not {value!r}")
    return bool(value)
