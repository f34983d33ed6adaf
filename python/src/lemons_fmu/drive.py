"""What people are driven by: propulsion forces and torques over time."""

from __future__ import annotations

import csv
import errno
import functools
import hashlib
import inspect
import math
import os
import pickle
import re
import select
import stat
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .crowd import Crowd

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Drive:
    """A table for each driven agent, linear between its rows and zero outside them.

    `tables` maps the place of an agent in Agents.xml (from 0) to its times [s], shape (T,), and its values, shape
    (T, 3): Fp.x, Fp.y [N] and Mp [N.m]. The values are held over a communication step; they are those at its
    beginning (as `lemons run` does) or in its `middle`, which is nearer to a push that changes fast. With `per_mass`
    they are forces per unit of mass [N/kg] (and [N.m/kg]), multiplied by the mass that the agent has in the run.
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
            raise ValueError(f'at is "start" or "middle", not {self.at!r}')
        checked = {}
        for agent, (times, values) in sorted(self.tables.items()):
            times, values = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
            if times.ndim != 1 or values.shape != (len(times), 3):
                raise ValueError(f"agent {agent}: times {times.shape} and values {values.shape}, not (T,) and (T, 3)")
            if not (np.isfinite(times).all() and np.isfinite(values).all()):
                raise ValueError(f"agent {agent}: not all numbers are finite")
            if (np.diff(times) <= 0).any():
                raise ValueError(f"agent {agent}: times must rise from row to row")
            checked[int(agent)] = times, values
        object.__setattr__(self, "tables", checked)

    @staticmethod
    def read(path: str | os.PathLike[str], ids: Sequence[str]) -> Drive:
        """A drive file of `lemons run`: columns t, agent (an Id, of those given), Fp.x, Fp.y, Mp; # begins a comment.

        Raises:
            ValueError: names file, line, column and what is wrong with it.
            OSError: the file cannot be read, or is a pipe that nobody writes.
        """
        with open(path, "rb", opener=_open) as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise ValueError(f"{os.fspath(path)}: it is larger than {LARGEST // 1_000_000} MB, the most that is read")
        return read(data, os.fspath(path), ids)

    def sample(self, agent: int, times: Floats) -> Floats:
        """Values at these times, shape (len(times), 3)."""
        t, values = self.tables[agent]
        after = np.searchsorted(t, times, side="right")
        inside = (after > 0) & (after < len(t))
        before = np.where(inside, after - 1, 0)
        beyond = np.where(inside, after, 0)
        # `lemons run` has the same formula, so that the bits are the same.
        with np.errstate(invalid="ignore", divide="ignore"):
            share = ((times - t[before]) / (t[beyond] - t[before]))[:, None]
            between = values[before] + share * (values[beyond] - values[before])
        out: Floats = np.where(inside[:, None], between, 0.0)
        if len(t):
            out[times == t[-1]] = values[-1]
        return out


#: What drives a crowd: by default the drive.csv packed with its Trial, if there is one; False: nothing new, what the Trial
#: says goes on; the path of such a file; tables; constants of shape (N, 3); or a function that is asked before each step
#: and answers with an array of shape (N, 3).
DriveLike = Union[None, Literal[False], str, "os.PathLike[str]", Drive, Floats, "Callable[[Crowd], Floats]"]
#: The same when files are read.
Known = Union[None, Literal[False], Drive, Floats, "Callable[[Crowd], Floats]"]

#: How long a pipe is waited for [s].
PATIENCE = 30.0
#: The largest drive file, that of `lemons run` too [byte].
LARGEST = 500_000_000

_COLUMNS = ("t", "agent", "Fp.x", "Fp.y", "Mp")
# As Rust reads numbers: no underscores, no digits of other scripts.
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def known(drive: DriveLike, ids: Sequence[str]) -> Known:
    """What drives a crowd of these people, read where it is a path.

    Raises:
        TypeError: it is nothing that can drive a crowd.
        ValueError: it is for others, or what is wrong with its file.
        OSError: its file cannot be read.
    """
    if drive is None or drive is False:
        return drive
    if isinstance(drive, (str, os.PathLike)):
        return Drive.read(drive, ids)
    if isinstance(drive, Drive):
        agents = list(drive.tables)
        if agents and not (0 <= agents[0] and agents[-1] < len(ids)):
            raise ValueError(f"the drive is for agents {agents}; there are {len(ids)}")
        return drive
    if isinstance(drive, np.ndarray):
        return forces(drive, len(ids))
    if callable(drive) and not isinstance(drive, type):
        return drive
    raise TypeError(
        f"the drive is {_short(drive)}; taken are None (the drive.csv of the Trial), False (no drive), the path of a CSV file, "
        f"a Drive, an array of shape ({len(ids)}, 3), or a function of the Crowd"
    )


def forces(drive: Any, agents: int) -> Floats:
    """Fp.x, Fp.y, Mp of everybody as C takes them."""
    values = np.asarray(drive)
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


def _open(path: str, flags: int) -> int:
    """Opens a file; of a pipe that nobody writes says so, where `open` would wait for ever."""
    if os.name != "posix":
        return os.open(path, flags)
    descriptor = os.open(path, flags | os.O_NONBLOCK)
    try:
        if stat.S_ISFIFO(os.fstat(descriptor).st_mode):
            if not select.select([descriptor], [], [], PATIENCE)[0]:
                raise TimeoutError(errno.ETIMEDOUT, f"a pipe into which nobody has written for {PATIENCE:g} s", path)
            os.set_blocking(descriptor, True)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def read(data: bytes, name: str, ids: Sequence[str]) -> Drive:
    """What a drive file of that name holds."""
    places = {each: place for place, each in enumerate(ids)}
    rows: dict[int, list[list[float]]] = {}
    header: list[str] | None = None
    # Only line feeds and carriage returns end a line: `str.splitlines` knows more.
    for number, raw in enumerate(data.removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        if not raw or raw.startswith(b"#"):
            continue
        where = f"drive file {name}: line {number}"
        try:
            cells = [cell.strip() for cell in next(csv.reader([raw.decode()], strict=True))]
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{where}: {error}") from None
        if header is None:
            header = cells
            for column in _COLUMNS:
                if header.count(column) != 1:
                    many = "are two columns" if column in header else "is no column"
                    raise ValueError(f"{where}: there {many} {column!r} (expected {','.join(_COLUMNS)})")
            continue
        if len(cells) != len(header):
            raise ValueError(f"{where}: {len(cells)} cells, not {len(header)}")
        row = dict(zip(header, cells))
        if row["agent"] not in places:
            raise ValueError(f"{where}: agent={row['agent']!r}: there is no agent of this Id")
        numbers = []
        for column in _COLUMNS:
            if column != "agent":
                value = float(row[column]) if _NUMBER.fullmatch(row[column]) else math.nan
                if not math.isfinite(value):
                    raise ValueError(f"{where}: {column}={row[column]!r}: not a finite number")
                numbers.append(value)
        before = rows.setdefault(places[row["agent"]], [])
        if before and before[-1][0] >= numbers[0]:
            raise ValueError(f"{where}: t={row['t']} does not come after t={before[-1][0]} of the same agent")
        before.append(numbers)
    if header is None:
        raise ValueError(f"drive file {name}: there is no column 't' (expected {','.join(_COLUMNS)})")
    arrays = {agent: np.array(each) for agent, each in rows.items()}
    return Drive({agent: (each[:, 0], each[:, 1:]) for agent, each in arrays.items()})


def identity(drive: Known) -> dict[str, Any]:
    """What says whether two drives are the same; see python/README.md."""
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
    """Name and, where Python has it, the hash of the source text of a function."""
    if isinstance(function, functools.partial):
        given = repr((function.args, sorted(function.keywords.items())))
        return function_identity(function.func) | {"arguments_sha256": hashlib.sha256(given.encode()).hexdigest()}
    named: Any = function if hasattr(function, "__qualname__") else type(function)
    identity = {"name": f"{named.__module__}.{named.__qualname__}".removeprefix("__main__.")}
    if named is not function:
        identity["object_sha256"] = hashlib.sha256(pickle.dumps(vars(function))).hexdigest()
    try:
        identity["source_sha256"] = hashlib.sha256(inspect.getsource(named).encode()).hexdigest()
    except (OSError, TypeError):
        pass  # typed in at a prompt, or not written in Python
    return identity
