"""FMUs that a process has unpacked and loaded, and their instances, which are used again."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import shutil
import threading
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar, Union

import fmpy
import numpy as np
from numpy.typing import NDArray

from . import files
from .arrays import Plan, plan
from .errors import FmuError
from .instance import Instance, Variable
from .instance3 import ArrayInstance, arrays_of, singles_of
from .scratch import scratch

Source = Union[str, "os.PathLike[str]", bytes]

#: Of each kind, so many FMUs stay loaded; what was used longest ago is removed, and unpacked again when it is needed.
KEPT = 16
_places = itertools.count()
_OF_AGENT = re.compile(r"agent\[(\d+)\]\.")


class Loaded:
    """An FMU of FMI 2.0 or 3.0 that this process has loaded. Threads may share it."""

    def __init__(self, data: bytes, sha256: str) -> None:
        self.data = data
        self.sha256 = sha256
        #: Where it is unpacked, while it is.
        self.directory: Path = scratch() / f"{next(_places)}-{sha256[:16]}"
        self._lock = threading.RLock()
        self._idle: list[Instance] = []
        #: How many use its files now, and whether they stay when nobody does.
        self._users, self._kept = 0, True
        self._plans: dict[bytes, Plan] = {}
        self._unpack()
        try:
            self._take(self._read())
        except BaseException as error:
            self.forget()
            if isinstance(error, ValueError):
                raise FmuError(f"is not a readable FMU: {error}") from error
            raise

    def _read(self) -> Any:
        """Reads the description of what is unpacked."""
        try:
            description = fmpy.read_model_description(str(self.directory), validate=False)
        except Exception as error:  # fmpy raises any exception
            raise FmuError(f"is not a readable FMU: {error}") from error
        if description.fmiVersion[:2] not in ("2.", "3.") or description.coSimulation is None:
            raise FmuError("is not a co-simulation FMU of FMI 2.0 or 3.0")
        return description

    def _take(self, description: Any) -> None:
        """Takes from the description what is needed."""
        self.guid: str = description.guid
        self.model_name: str = description.modelName
        self.identifier: str = description.coSimulation.modelIdentifier
        #: The variables of FMI 3.0, of which arrays are read and set whole; empty for FMI 2.0.
        self.arrays = arrays_of(description) if description.fmiVersion.startswith("3.") else []
        #: Single values by name. In FMI 3.0 a reference is the place among the values of all variables.
        self.variables = {v.name: _variable(v) for v in description.modelVariables}
        if self.arrays:
            self.variables = singles_of(description, self.arrays)
        experiment = description.defaultExperiment
        size = None if experiment is None else experiment.stepSize
        #: The communication step that it asks for [s], if it asks for one.
        self.own_step = float(size) if size else None
        indices = (int(found[1]) for found in map(_OF_AGENT.match, self.variables) if found)
        #: How many agents its variables are of.
        self._indices = max(indices, default=-1) + 1

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        """It is pickled as its bytes. The process that reads them loads them, if it has not done so before."""
        return load_any, (self.data,)

    def expand(self, name: str) -> list[str]:
        """Returns the names of the variables that a name stands for: `agent[*].Mass` stands for the masses of all agents.

        Raises:
            FmuError: the FMU has no such variable.
        """
        several = range(max(1, self._indices)) if "agent[*]" in name else range(1)
        names = [name.replace("agent[*]", f"agent[{i}]", 1) for i in several]
        for each in names:
            if each not in self.variables:
                raise FmuError(f"the FMU has no variable {each!r}; `lemons info` lists them")
        return names

    def plan(self, keys: NDArray[np.uint32]) -> Plan:
        """Returns how values of FMI 3.0 are read by one call; it is found out once for the same values."""
        known = keys.tobytes()
        found = self._plans.get(known)
        if found is None:
            found = self._plans[known] = plan(keys, self.arrays)
        return found

    def borrow(self) -> Instance:
        """Returns an instance in the state after instantiation; call `give_back` later."""
        with self._lock:
            self._use()
            if self._idle:
                return self._idle.pop()
        try:
            return (ArrayInstance if self.arrays else Instance)(self)
        except BaseException:
            self._release(failed=True)
            raise

    def give_back(self, instance: Instance) -> None:
        """Resets an instance and keeps it for later, or drops it if it cannot be reset."""
        try:
            instance.reset()
        except FmuError:
            instance.drop()
        else:
            with self._lock:
                self._idle.append(instance)
        self._release()

    @contextmanager
    def unpacked(self) -> Iterator[Path]:
        """Gives the directory where it is unpacked, for as long as it is needed."""
        with self._lock:
            self._use()
        try:
            yield self.directory
        finally:
            self._release()

    def forget(self) -> None:
        """Removes its files and its instances as soon as nobody uses them. Who uses it later gets them anew."""
        with self._lock:
            self._kept = False
            self._clear()

    def _release(self, *, failed: bool = False) -> None:
        """`failed`: the files of an FMU that cannot be instantiated do not stay."""
        with self._lock:
            self._users -= 1
            if failed or not self._kept:
                self._clear()

    def _clear(self) -> None:
        if self._users == 0:
            idle, self._idle = self._idle, []
            for instance in idle:
                instance.drop()
            self._remove()

    def _use(self) -> None:
        if not self.directory.exists():
            self._unpack()
        self._users += 1

    def _unpack(self) -> None:
        try:
            _check_unpacked(self.data)
            fmpy.extract(BytesIO(self.data), self.directory)
        except BaseException as error:
            self._remove()
            if not isinstance(error, Exception):  # fmpy and zipfile raise any
                raise
            what = "cannot be unpacked" if isinstance(error, OSError) else "is not a readable FMU"
            raise FmuError(f"{what}: {error}") from error

    def _remove(self) -> None:
        shutil.rmtree(self.directory, ignore_errors=True)


def _variable(found: Any) -> Variable:
    unit = found.unit or (found.declaredType.unit if found.declaredType else None)
    return Variable(int(found.valueReference), str(found.type), str(found.causality), unit)


Kind = TypeVar("Kind", bound=Loaded)
_loading = [threading.RLock()]
_loaded: dict[type[Loaded], dict[str, Loaded]] = {}  # by SHA-256; what was used last is the last


def read(source: Source) -> bytes:
    """Returns the bytes of an FMU.

    Raises:
        FmuError: the file cannot be read.
    """
    if isinstance(source, bytes):
        return source
    try:
        return files.read(source, files.LARGEST_BINARY)
    except OSError as error:
        raise FmuError(f"{os.fspath(source)}: {error.strerror}") from error


def loaded(source: Source, kind: Callable[[bytes, str], Kind]) -> Kind:
    """Loads an FMU from a file or from its bytes. A process unpacks and loads the same bytes only once.

    Raises:
        FmuError: the file cannot be read, or is no such FMU.
    """
    data = read(source)
    sha256 = hashlib.sha256(data).hexdigest()
    with _loading[0]:
        known: dict[str, Any] = _loaded.setdefault(kind, {})  # type: ignore[arg-type]
        try:
            found: Kind = known.pop(sha256, None) or kind(data, sha256)
        except FmuError as error:
            raise error if isinstance(source, bytes) else FmuError(f"{os.fspath(source)}: {error}") from None
        known[sha256] = found
        for oldest in list(known)[:-KEPT]:
            known.pop(oldest).forget()
        return found


def load_any(source: Source) -> Loaded:
    """Loads an FMU that need not be a crowd's.

    Raises:
        FmuError: the file cannot be read, or is no FMU for co-simulation.
    """
    return loaded(source, Loaded)


def _forget() -> None:
    """Lets a forked child share no instances."""
    _loading[0] = threading.RLock()
    _loaded.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def _check_unpacked(data: bytes) -> None:
    """Checks that an archive does not unpack to too many bytes. `zipfile` unpacks no more of an entry than its header says."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > files.LARGEST_UNPACKED:
        raise ValueError(f"it unpacks to {unpacked / 1e6:.0f} MB; at most {files.LARGEST_UNPACKED / 1e6:g} MB are allowed")
