"""What people are driven by: propulsion forces and torques over time."""

from __future__ import annotations

import csv
import functools
import hashlib
import inspect
import math
import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .crowd import Crowd

Floats = NDArray[np.float64]


@dataclass(frozen=True)
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
            ValueError: names file, line and what is wrong with it.
        """
        names = ["t", "agent", "Fp.x", "Fp.y", "Mp"]
        rows: dict[int, list[list[float]]] = {}
        header = None
        with open(path, newline="", encoding="utf-8-sig") as file:
            for number, line in enumerate(file, 1):
                if not line.strip() or line.startswith("#"):
                    continue
                where = f"{os.fspath(path)}, line {number}"
                cells = [cell.strip() for cell in next(csv.reader([line]))]
                if header is None:
                    header = cells
                    missing = [name for name in names if name not in header]
                    if missing:
                        raise ValueError(f"{where}: there is no column {missing[0]!r} (expected {','.join(names)})")
                    continue
                if len(cells) != len(header):
                    raise ValueError(f"{where}: {len(cells)} cells, not {len(header)}")
                row = dict(zip(header, cells))
                if row["agent"] not in ids:
                    raise ValueError(f"{where}: there is no agent {row['agent']!r}")
                try:
                    rows.setdefault(ids.index(row["agent"]), []).append([_finite(row[n]) for n in names if n != "agent"])
                except ValueError as error:
                    raise ValueError(f"{where}: {error}") from None
        if header is None:
            raise ValueError(f"{os.fspath(path)}: empty")
        arrays = {agent: np.array(each) for agent, each in rows.items()}
        try:
            return Drive({agent: (each[:, 0], each[:, 1:]) for agent, each in arrays.items()})
        except ValueError as error:
            raise ValueError(f"{os.fspath(path)}: {error}") from None

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


#: What drives a crowd: nothing new (what the Trial says goes on), tables, constants of shape (N, 3), or a function that
#: is asked before each step and answers with an array of shape (N, 3).
DriveLike = Union[None, Drive, Floats, "Callable[[Crowd], Floats]"]


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text!r} is not finite")
    return number


def identity(drive: DriveLike) -> dict[str, Any]:
    """What says whether two drives are the same; see python/README.md."""
    if drive is None:
        return {"kind": "none"}
    if isinstance(drive, Drive):
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
