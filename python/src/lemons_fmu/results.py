"""The directory of a sweep: a manifest, part files while it runs, and one table at the end. python/README.md describes
it exactly."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import time
from collections.abc import Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from . import files, locks
from .instance import Value

FORMAT = 1
MANIFEST, TABLE, LOCK = "sweep.json", "table.parquet", "sweep.lock"
POINT, STATUS, ERROR = "point", "status", "error"
OK, FAILED = "ok", "failed"
RESERVED = (POINT, STATUS, ERROR)
#: A larger number of points is taken for a mistake; `lemons sweep` has the same limit.
MOST_POINTS = 10_000_000


class SweepError(Exception):
    """The sweep cannot continue: its directory belongs to another sweep, is in use or damaged, or the scheduler is gone."""


@dataclass(frozen=True)
class Points:
    """The points of a sweep: a row of parameter values for each."""

    names: tuple[str, ...]
    #: A column for each name: float64, int64 or text.
    columns: tuple[Any, ...]
    count: int

    @staticmethod
    def of(points: Mapping[str, Iterable[Value]] | pd.DataFrame) -> Points:
        """Makes points from a grid (name → values; the last name varies fastest) or a table (a row for each point)."""
        if isinstance(points, pd.DataFrame):
            _allowed(len(points))
            if len({str(name) for name in points.columns}) != len(points.columns):
                raise ValueError("two columns of the table have the same name")
            listed = {str(name): _column(str(name), points[name].tolist()) for name in points.columns}
            count = len(points)
        else:
            axes = _axes(points)
            count = math.prod(len(values) for values in axes.values())
            if count == 0:
                raise ValueError("there are no points")
            listed, repeat = {}, count
            for name, values in axes.items():
                repeat //= len(values)
                column, times = _column(name, values), count // (len(values) * repeat)
                if isinstance(column, list):
                    listed[name] = [value for value in column for _ in range(repeat)] * times
                else:
                    listed[name] = np.tile(np.repeat(column, repeat), times)
        if count == 0:
            raise ValueError("there are no points")
        for name in listed:
            if name in RESERVED:
                raise ValueError(f"{name!r} cannot be a parameter: the table already has a column with this name")
        return Points(tuple(listed), tuple(listed.values()), count)

    def values(self, point: int) -> tuple[Value, ...]:
        return tuple(column[point] if isinstance(column, list) else column[point].item() for column in self.columns)

    def sha256(self) -> str:
        """Returns the SHA-256 of the names and of all values row by row: numbers as 8 little-endian bytes, texts as length and
        UTF-8."""
        digest = hashlib.sha256(json.dumps(list(self.names), ensure_ascii=False, separators=(",", ":")).encode())
        if any(isinstance(column, list) for column in self.columns):
            for point in range(self.count):
                for value in self.values(point):
                    if isinstance(value, str):
                        digest.update(len(value.encode()).to_bytes(8, "little") + value.encode())
                    else:
                        digest.update(np.array(value, dtype="<i8" if isinstance(value, int) else "<f8").tobytes())
        else:
            raw = [column.astype(column.dtype.newbyteorder("<")).view("<u8") for column in self.columns]
            digest.update(np.column_stack(raw).tobytes() if raw else b"")
        return digest.hexdigest()


def _axes(grid: Mapping[str, Iterable[Value]]) -> dict[str, list[Value]]:
    """Returns the values of each parameter. It stops as soon as there are too many."""
    for name, values in grid.items():
        if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
            raise TypeError(f"parameter {name}: must be a list of values, not {values!r}")
    _allowed(math.prod(len(values) for values in grid.values() if isinstance(values, Sized)))
    axes: dict[str, list[Value]] = {}
    for name, values in grid.items():
        axes[str(name)] = list(itertools.islice(values, MOST_POINTS + 1))
        _allowed(math.prod(map(len, axes.values())))
    return axes


def _allowed(count: int) -> None:
    if count > MOST_POINTS:
        raise ValueError(f"there are more than {MOST_POINTS} points")


def unicode(text: str) -> bool:
    """Returns whether a text can be written as UTF-8: Python's texts may contain halves of characters."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _column(name: str, values: list[Any]) -> Any:
    if all(isinstance(value, str) for value in values):
        for value in values:
            if not unicode(value):
                raise ValueError(f"parameter {name}: {value!r} is not Unicode text")
        return values
    if all(isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.bool_)) for value in values):
        try:
            return np.array(values, dtype=np.int64)
        except OverflowError:
            raise ValueError(f"parameter {name}: an integer is too large") from None
    try:
        if any(isinstance(value, (str, bool, np.bool_)) for value in values):
            raise ValueError
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"parameter {name}: values must be all numbers or all texts") from None


#: A finished point: its number, its measures, and the message if it failed.
Result = tuple[int, Mapping[str, "float | str"], "str | None"]


def part_of(points: Points, results: Sequence[Result]) -> pa.Table:
    """Returns finished points as a table, sorted by point."""
    results = sorted(results, key=lambda result: result[0])
    rows = np.array([result[0] for result in results], dtype=np.int64)
    columns: dict[str, Any] = {POINT: pa.array(rows)}
    for name, column in zip(points.names, points.columns):
        columns[name] = pa.array([column[row] for row in rows] if isinstance(column, list) else column[rows])
    measures = {name: None for _, measured, _ in results for name in measured}
    for name in measures:
        values = [measured.get(name) for _, measured, _ in results]
        kind = pa.string() if any(isinstance(value, str) for value in values) else pa.float64()
        try:
            columns[name] = pa.array(values, type=kind)
        except (pa.ArrowInvalid, pa.ArrowTypeError):
            raise SweepError(f"measure {name!r} is a number at some points and a text at others") from None
    columns[STATUS] = pa.array([OK if error is None else FAILED for *_, error in results], type=pa.string())
    columns[ERROR] = pa.array([error for *_, error in results], type=pa.string())
    return pa.table(columns)


def joined(points: Points, parts: Sequence[pa.Table]) -> pa.Table:
    """Joins tables into one, with each point once, sorted. If a point has several rows, one that is `ok` is used, else the
    last. Measures have the order of the first point that is `ok`; further ones follow by name."""
    if not parts:
        return part_of(points, [])
    fixed = [POINT, *points.names]
    try:
        table = pa.concat_tables([pa.table({n: part[n] for n in fixed + [STATUS, ERROR]}) for part in parts])
        whole = pa.concat_tables(parts, promote_options="default")
    except (pa.ArrowInvalid, pa.ArrowTypeError, KeyError) as error:
        raise SweepError(f"the parts of the table have different columns: {error}") from error
    numbers = table[POINT].to_numpy()
    good = (table[STATUS].combine_chunks().to_numpy(zero_copy_only=False) == OK).astype(np.int8)
    order = np.lexsort((np.arange(len(numbers)), good, numbers))
    last = np.append(numbers[order][1:] != numbers[order][:-1], True)
    chosen = order[last]
    first: list[str] = []
    if good[chosen].any():
        row = int(chosen[np.argmax(good[chosen])])
        for part in parts:
            if row < len(part):
                names = [n for n in part.column_names if n not in (*fixed, STATUS, ERROR)]
                first = [n for n in names if part[n][row].is_valid]
                break
            row -= len(part)
    others = sorted(set(whole.column_names) - {*fixed, *first, STATUS, ERROR})
    return whole.select([*fixed, *first, *others, STATUS, ERROR]).take(pa.array(chosen)).combine_chunks()


class Directory:
    """The directory with the results. Only one process at a time may write to it."""

    def __init__(self, path: str | os.PathLike[str], manifest: Mapping[str, Any], points: Points) -> None:
        self.path = Path(path)
        self.points = points
        self.path.mkdir(parents=True, exist_ok=True)
        self._lock = os.open(self.path / LOCK, os.O_CREAT | os.O_RDWR, 0o644)
        try:
            try:
                locks.lock(self._lock)
            except OSError:
                raise SweepError(f"{self.path}: another process writes its results here") from None
            # Other programs may write here, too: remove only what a killed sweep leaves.
            for name in (MANIFEST, TABLE, "part-*.parquet"):
                for left in self.path.glob(_temporary(name)):
                    left.unlink()
            self._begin({"format": FORMAT, **manifest})
        except BaseException:
            self.close()
            raise

    def _begin(self, manifest: Mapping[str, Any]) -> None:
        path = self.path / MANIFEST
        if path.exists():
            try:
                before = json.loads(files.read(path, files.LARGEST_SETTINGS))
            except ValueError as error:
                raise SweepError(f"{path}: {error}") from None
            except OSError as error:
                raise SweepError(f"{path}: {error.strerror or error}") from None
            # What only the other one has makes it another sweep, too, such as a condition that ends points.
            known = before if isinstance(before, dict) else {}
            other = [key for key in {**manifest, **known} if known.get(key) != manifest.get(key)]
            if other:
                raise SweepError(
                    f"{self.path} contains another sweep: its {MANIFEST} differs in {', '.join(other)}; "
                    "give another directory, or remove this one"
                )
        elif any(self.path.glob("*.parquet")):
            raise SweepError(f"{self.path} contains tables, but no {MANIFEST}")
        else:
            text = json.dumps(manifest, indent=2, ensure_ascii=False) + "\n"
            self._write(MANIFEST, lambda file: file.write(text.encode()))

    def close(self) -> None:
        os.close(self._lock)

    def parts(self) -> list[Path]:
        return sorted(self.path.glob("part-*.parquet"))

    def read(self) -> pa.Table:
        """Returns all finished points."""
        parts = []
        for path in [self.path / TABLE, *self.parts()]:
            if path.exists():
                try:
                    with files.found(path) as file:
                        part = pq.read_table(file)
                    self._check(part)
                except (OSError, pa.ArrowException, ValueError, KeyError) as error:
                    raise SweepError(f"{path} cannot be used: {error}; if you remove it, its points are simulated again") from None
                parts.append(part)
        return joined(self.points, parts)

    def _check(self, part: pa.Table) -> None:
        """Checks that both the numbers and the values of points are those of this sweep."""
        numbers = part[POINT].to_numpy()
        if len(numbers) and not (0 <= numbers.min() and numbers.max() < self.points.count):
            raise ValueError("it contains points that are not in the sweep")
        wanted = part_of(self.points, [(int(number), {}, None) for number in np.sort(numbers)])
        mine = part.select([POINT, *self.points.names]).sort_by(POINT)
        if not mine.equals(wanted.select(mine.column_names)) and not _same(mine, wanted):
            raise ValueError("the values of its points are not those of the sweep")

    def add(self, results: Sequence[Result]) -> None:
        """Adds a part file."""
        number = max((int(path.stem.removeprefix("part-")) for path in self.parts()), default=0) + 1
        table = part_of(self.points, results)
        self._write(f"part-{number:06}.parquet", lambda file: pq.write_table(table, file))

    def finish(self, table: pa.Table) -> None:
        """Writes the whole table and removes the parts."""
        self._write(TABLE, lambda file: pq.write_table(table, file))
        for path in self.parts():
            path.unlink()

    def _write(self, name: str, write: Any) -> None:
        """Writes a file completely or not at all, even if the power fails."""
        temporary = self.path / _temporary(name)
        try:
            with open(temporary, "wb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, self.path / name)
        except BaseException as error:
            temporary.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise SweepError(f"cannot write {self.path / name}: {error.strerror or error}") from error
            raise


def _temporary(name: str) -> str:
    """Returns the name under which a file is written, until it is complete; `lemons sweep` uses the same."""
    return f".{name}.tmp"


def _same(one: pa.Table, other: pa.Table) -> bool:
    """Like `equals`, but NaN is equal to NaN."""
    pairs = ((one[n].to_numpy(), other[n].to_numpy()) for n in one.column_names)
    return all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in pairs)


class Intervals:
    """The times at which results are written: a second after the last time, or a hundredth of the time since the beginning.
    This keeps the number of parts of a long sweep small."""

    def __init__(self) -> None:
        self.start = self.last = time.monotonic()

    def left(self) -> float:
        now = time.monotonic()
        return max(0.0, self.last + max(1.0, 0.01 * (now - self.start)) - now)

    def done(self) -> None:
        self.last = time.monotonic()
