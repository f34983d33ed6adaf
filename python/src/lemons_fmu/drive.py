"""Drives: propulsion forces and torques of people over time."""

from __future__ import annotations

import hashlib
import inspect
import io
import os
import pickle
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import CodeType, FunctionType, ModuleType
from typing import Any, Literal, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from . import _native

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Drive:
    """A table for each driven agent: linear between its rows, and zero before the first and after the last.

    `tables` maps the index of an agent in Agents.xml (from 0) to its times [s], shape (T,), and its values, shape
    (T, 3): Fp.x, Fp.y [N] and Mp [N.m]. The drive is constant over a communication step: its value at the `start` (as in
    `lemons run`) or in the `middle` of the step, which is better for a push that changes fast. With `per_mass` the
    values are per unit of mass [N/kg] (and [N.m/kg]), and are multiplied by the mass of the agent in the run.
    """

    tables: Mapping[int, tuple[Floats, Floats]]
    at: Literal["start", "middle"] = "start"
    per_mass: bool = False

    def __repr__(self) -> str:
        rows = sum(len(times) for times, _ in self.tables.values())
        per_mass = ", per mass" if self.per_mass else ""
        return f"<Drive of {len(self.tables)} agents, {rows} rows, as at the {self.at} of each step{per_mass}>"

    def __post_init__(self) -> None:
        if self.at not in ("start", "middle"):
            raise ValueError(f'at must be "start" or "middle", not {self.at!r}')
        checked = {}
        for agent, (times, values) in sorted(self.tables.items()):
            if not isinstance(agent, (int, np.integer)):
                raise TypeError(f"agent {agent!r}: must be an index in Agents.xml (a whole number from 0), not {type(agent).__name__}")
            times, values = _array(times).astype(float), _array(values).astype(float)
            if times.ndim != 1 or values.shape != (len(times), 3):
                raise ValueError(f"agent {agent}: shapes {times.shape} and {values.shape}, not (T,) and (T, 3)")
            if not (np.isfinite(times).all() and np.isfinite(values).all()):
                raise ValueError(f"agent {agent}: all numbers must be finite")
            if (np.diff(times) <= 0).any():
                raise ValueError(f"agent {agent}: times must increase from row to row")
            checked[int(agent)] = times, values
        object.__setattr__(self, "tables", checked)

    @staticmethod
    def read(path: str | os.PathLike[str], ids: Sequence[str]) -> Drive:
        """Reads a drive file of `lemons run`: columns t, agent (an Id from `ids`), Fp.x, Fp.y, Mp; # begins a comment.

        Raises:
            ValueError: the file is not valid; the message names file, line and column.
            OSError: the file cannot be read, is not a regular file, or is larger than 500 MB.
        """
        return Drive(_native.read_drive(os.fspath(path), list(ids)))

    def sample(self, agent: int, times: Floats) -> Floats:
        """Returns the values at these times [s], shape (len(times), 3)."""
        t, values = self.tables[agent]
        after = np.searchsorted(t, times, side="right")
        inside = (after > 0) & (after < len(t))
        before = np.where(inside, after - 1, 0)
        beyond = np.where(inside, after, 0)
        # The same formula as in `lemons run`, so that the bits are the same.
        with np.errstate(invalid="ignore", divide="ignore"):
            share = ((times - t[before]) / (t[beyond] - t[before]))[:, None]
            between = values[before] + share * (values[beyond] - values[before])
        out: Floats = np.where(inside[:, None], between, 0.0)
        if len(t):
            out[times == t[-1]] = values[-1]
        return out


#: The argument of a function that drives a crowd: the crowd.
Asked = TypeVar("Asked")

#: The drive of a crowd. None: the drive.csv of its Trial, if there is one. False: no new drive; that of the Trial
#: continues. Or the path of a drive file, a Drive, constants of shape (N, 3), or a function of the crowd that is called
#: before each step and returns an array of shape (N, 3).
DriveLike = Union[None, Literal[False], str, os.PathLike[str], Drive, Floats, Callable[[Asked], Floats]]
#: The same after files were read.
Known = Union[None, Literal[False], Drive, Floats, Callable[[Asked], Floats]]

#: What drives an agent [N], [N], [N.m]: columns of a drive file.
INPUTS = ("Fp.x", "Fp.y", "Mp")


def known(drive: DriveLike[Asked], ids: Sequence[str]) -> Known[Asked]:
    """Checks the drive for a crowd of these people, and reads it if it is a path.

    Raises:
        TypeError: it is not a drive.
        ValueError: it is for other agents, or its file is not valid.
        OSError: its file cannot be read.
    """
    if drive is None or drive is False:
        return drive
    if isinstance(drive, (str, os.PathLike)):
        return Drive.read(drive, ids)
    if isinstance(drive, Drive):
        agents = list(drive.tables)
        if agents and not (0 <= agents[0] and agents[-1] < len(ids)):
            raise ValueError(f"the drive is for agents {agents}, but there are {len(ids)} agents")
        return drive
    if isinstance(drive, np.ndarray):
        return forces(drive, len(ids))
    if callable(drive) and not isinstance(drive, type):
        return drive
    raise TypeError(
        f"the drive is {_short(drive)}; it must be None (the drive.csv of the Trial), False (no drive), the path of a CSV file, "
        f"a Drive, an array of shape ({len(ids)}, 3), or a function of the Crowd"
    )


def _array(values: Any) -> NDArray[Any]:
    """Returns an array of what may be a DataFrame, whose columns are found by their names, or a masked array.

    Raises:
        ValueError: there are other columns, or values are masked.
    """
    if hasattr(values, "columns"):
        if sorted(map(str, values.columns)) != sorted(INPUTS):
            raise ValueError(f"the drive has the columns {', '.join(map(str, values.columns))}, not {', '.join(INPUTS)}")
        values = values[list(INPUTS)]
    if np.ma.is_masked(values):
        raise ValueError("the drive has masked values: give numbers (0: no force)")
    return np.asarray(values)


def forces(drive: Any, agents: int) -> Floats:
    """Returns Fp.x, Fp.y, Mp of all agents as a C array."""
    index = getattr(drive, "index", None) if hasattr(drive, "columns") else None
    if index is not None and list(index) != list(range(agents)):
        raise ValueError(f"the rows of the drive's DataFrame must be named 0 to {agents - 1}, in this order, as the agents in Agents.xml")
    values = _array(drive)
    if values.dtype.kind not in "fiu":
        raise TypeError(f"the drive is {_short(drive)}, not an array of real numbers")
    if values.shape != (agents, 3):
        raise ValueError(f"the drive has the shape {values.shape}, not {(agents, 3)}")
    return np.ascontiguousarray(values, dtype=np.float64)


def _short(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}"
    text = repr(value)
    return f"{text if len(text) <= 60 else text[:57] + '...'} ({type(value).__name__})"


def identity(drive: Known[Any]) -> dict[str, Any]:
    """Returns a dictionary that is equal for equal drives; see python/README.md."""
    if drive is None or drive is False:
        return {"kind": "none"}
    if isinstance(drive, Drive):
        if not drive.tables:
            return {"kind": "none"}
        digest = hashlib.sha256()
        for agent, (times, values) in drive.tables.items():
            digest.update(np.array([agent, len(times)], dtype="<i8").tobytes())
            digest.update(np.column_stack([times, values]).astype("<f8").tobytes())
        return {"kind": "table", "at": drive.at, "per_mass": drive.per_mass, "sha256": digest.hexdigest()}
    if isinstance(drive, np.ndarray):
        return {"kind": "constant", "sha256": hashlib.sha256(drive.astype("<f8").tobytes()).hexdigest()}
    return {"kind": "function", **function_identity(drive)}


def function_identity(function: Callable[..., Any]) -> dict[str, str]:
    """Returns the name of a function or a callable object, and the hash of all that it computes with."""
    named: Any = function if hasattr(function, "__qualname__") else type(function)
    written = io.BytesIO()
    try:
        _Content(written).dump(function)
    except Exception:  # pickle and what it calls raise any
        written.write(os.urandom(16))  # what cannot be compared is not the same as before
    name = f"{named.__module__}.{named.__qualname__}".removeprefix("__main__.")
    return {"name": name, "sha256": hashlib.sha256(written.getvalue()).hexdigest()}


#: Where packages are installed: of what is there only the name counts.
_INSTALLED = (os.path.dirname(__file__), *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")))


class _Content(pickle.Pickler):
    """Writes functions as their source texts, their defaults, the variables around them and the globals that they name:
    so with the helpers that they call. Nobody reads it."""

    def persistent_id(self, value: Any) -> Any:
        if isinstance(value, (set, frozenset)):  # their order differs between processes
            return sorted(map(repr, value))
        if isinstance(value, ModuleType):
            return value.__name__, inspect.getsource(value) if _is_own(value.__name__) else ""
        return None

    def reducer_override(self, value: Any) -> Any:
        if not isinstance(value, (type, FunctionType)) or not _is_own(value.__module__):
            return NotImplemented
        if isinstance(value, type):
            return str, (inspect.getsource(value),)
        codes = list(_codes(value.__code__))
        try:
            text: Any = inspect.getsource(value)
        except OSError:  # defined at a prompt
            text = [(code.co_code, [each for each in code.co_consts if not isinstance(each, CodeType)]) for code in codes]
        names = sorted({name for code in codes for name in code.co_names} & value.__globals__.keys())
        around = [cell.cell_contents for cell in value.__closure__ or ()]
        state = text, value.__defaults__, value.__kwdefaults__, around, [(name, value.__globals__[name]) for name in names]
        return object, (), state  # the state is written after the function is known: a function may name itself


def _is_own(module: str) -> bool:
    """Whether a module is the user's own, and not of an installed package."""
    file = getattr(sys.modules.get(module), "__file__", None)
    return module == "__main__" or (file is not None and not file.startswith(_INSTALLED))


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)
