"""An instance of an FMU of FMI 3.0, whose values are arrays."""

from __future__ import annotations

import ctypes
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from fmpy.fmi3 import FMU3Slave
from numpy.typing import NDArray

from .arrays import AGENTS, Array, Plan, names
from .errors import FmuError
from .instance import Described, Instance, Value, Variable, boolean, function, integer, loading, numbers, real

# Of FMI 3.0, and what they are here.
_TYPES = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String"}


class ArrayInstance(Instance):
    """An instance of an FMI 3.0 FMU. Arrays are read and set whole: where some of their elements are set, the others keep the
    values that they have."""

    def __init__(self, fmu: Described) -> None:
        self.fmu = fmu
        self.fatal = False
        self._said = deque(maxlen=100)
        with loading():
            try:
                self.slave = FMU3Slave(
                    guid=fmu.guid,
                    unzipDirectory=str(fmu.directory),
                    modelIdentifier=fmu.identifier,
                    instanceName=f"{fmu.identifier} {next(numbers)}",
                )
                self.slave.instantiate(logMessage=self._hear, loggingOn=True)
            except Exception as error:
                raise FmuError(self._why(str(error))) from error
        self._first = [text for _, text in self._said]
        self._said.clear()
        library = self.slave.dll
        self._component = ctypes.c_void_p(self.slave.component)
        self._set_float64 = function(library, "fmi3SetFloat64", counted=True)
        self._get_float64 = function(library, "fmi3GetFloat64", counted=True)
        self._get_int32 = function(library, "fmi3GetInt32", counted=True)
        self._set_int32 = function(library, "fmi3SetInt32", counted=True)
        self._get_bool = function(library, "fmi3GetBoolean", counted=True)
        self._set_bool = function(library, "fmi3SetBoolean", counted=True)
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

    def set_integer(self, references: NDArray[np.uint32], values: NDArray[np.int32]) -> None:
        self._set("Int32", self._get_int32, self._set_int32, references, np.ascontiguousarray(values))

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
                    slave.setInt32([array.reference], [integer(names[0], value)])
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
            number = np.empty(1)
            self.get_real(keys, number)
            return float(number[0])
        if variable.type == "Integer":
            count = np.empty(1, dtype=np.int32)
            self.get_integer(keys, count)
            return int(count[0])
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
            self.set_boolean(keys, np.full(len(names), boolean(names[0], value)))
        else:
            self.set_real(keys, np.full(len(names), real(names[0], value)))

    def enter(self, start: float) -> None:
        with self.calls() as slave:
            slave.enterInitializationMode(startTime=start)
            self._initialized = True
            later, self._later = self._later, []
            for names, value in later:
                if self.fmu.variables[names[0]].type not in ("Real", "Boolean"):
                    raise FmuError(f"{names[0]} is an element of an array of neither Reals nor Booleans: not supported")
                self._set_all(names, value)

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


def arrays_of(description: Any) -> list[Array]:
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


def singles_of(description: Any, arrays: Sequence[Array]) -> dict[str, Variable]:
    """Returns the values of FMI 3.0 by their names."""
    own = {variable.name: variable for variable in description.modelVariables}
    by_name = {array.name: array for array in arrays}
    singles = {}
    for array in arrays:
        kind, causality = _TYPES[own[array.name].type], str(own[array.name].causality)
        for place, name in enumerate(names(array, by_name)):
            singles[name] = Variable(array.begin + place, kind, causality, own[array.name].unit)
    return singles
