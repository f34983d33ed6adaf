"""Trajectories in HDF5, as the Pedestrian Dynamics Data Archive of Jülich has them, JuPedSim writes and PedPy reads them.

Commands read and write JuPedSim's database; here it becomes HDF5, and back. That needs h5py: `pip install 'lemons-fmu[hdf5]'`.
"""

from __future__ import annotations

import importlib
import os
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._native import CommandError
from .extra import needed

if TYPE_CHECKING:
    from .record import Run

#: Bytes that a file of HDF5 begins with.
BEGIN = b"\x89HDF\r\n\x1a\n"
#: As many as commands read.
MOST_ROWS = 20_000_000
#: [bytes] A row of more has not only numbers, and a chunk of more would not fit into small computers.
MOST_OF_ROW, MOST_OF_CHUNK = 4096, 2**28
#: Columns of the dataset, and those of the database.
COLUMNS = ("frame", "id", "x", "y")
ORIENTATION = ("ox", "oy")


def is_hdf5(path: str | os.PathLike[str]) -> bool:
    """Returns whether a file begins as HDF5."""
    with suppress(OSError):
        if os.path.isfile(path):
            with open(path, "rb") as file:
                return file.read(len(BEGIN)) == BEGIN
    return False


def _h5py() -> Any:
    with needed("hdf5", "HDF5"):
        return importlib.import_module("h5py")


@contextmanager
def source(what: str | os.PathLike[str] | Run) -> Iterator[tuple[str, Run | None]]:
    """Yields what commands read: a path, or what a run is called and the run. Of HDF5 it is a database that is there meanwhile.

    Raises:
        CommandError: the file holds no trajectories, or they are wrong.
        ImportError: there is no h5py.
    """
    if not isinstance(what, (str, os.PathLike)):
        yield repr(what), what
    elif not is_hdf5(what):
        yield os.fspath(what), None
    else:
        with tempfile.TemporaryDirectory(prefix="lemons-") as directory:
            database = Path(directory) / Path(what).name
            _to_database(Path(what), database)
            try:
                yield str(database), None
            except CommandError as error:
                raise CommandError(str(error).replace(str(database), os.fspath(what))) from error


def _to_database(path: Path, database: Path) -> None:
    h5py = _h5py()
    try:
        with h5py.File(path, "r") as file:
            rows = file.get("trajectory")
            if not isinstance(rows, h5py.Dataset):
                raise CommandError(f'{path}: is HDF5, but not of the data archive: there is no dataset "trajectory"')
            names = rows.dtype.names or ()
            missing = [name for name in COLUMNS if name not in names]
            if missing or rows.ndim != 1:
                raise CommandError(f"{path}: trajectory: {'there is no column ' + repr(missing[0]) if missing else 'has not one dimension'}")
            if rows.shape[0] > MOST_ROWS:
                raise CommandError(f"{path}: trajectory: has {rows.shape[0]} rows, more than {MOST_ROWS}")
            rate = rows.attrs.get("fps", file.attrs.get("fps"))
            if rate is None:
                raise CommandError(f'{path}: trajectory: there is no attribute "fps"')
            geometry = file.attrs.get("wkt_geometry")
            known = [name for name in ORIENTATION if name in names]
            wanted = (*COLUMNS, *(known if len(known) == 2 else ()))
            # Before anything is read: a cell that is an array can be of any size.
            for name in wanted:
                if rows.dtype[name].shape != () or rows.dtype[name].kind not in "iuf":
                    raise CommandError(f"{path}: trajectory: column {name}: holds {rows.dtype[name]}, not one number a row")
            chunk = (rows.chunks or (0,))[0] * rows.dtype.itemsize
            for what, size, most in (("row", rows.dtype.itemsize, MOST_OF_ROW), ("chunk", chunk, MOST_OF_CHUNK)):
                if size > most:
                    raise CommandError(f"{path}: trajectory: a {what} has {size} bytes, more than {most}")
            columns = {name: rows.fields(name)[:] for name in wanted}
    except (OSError, RuntimeError, ValueError, TypeError, KeyError) as error:
        raise CommandError(f"{path}: is no sound HDF5: {error}") from error
    for name in COLUMNS[:2]:
        columns[name] = _whole(path, name, columns[name])
    for name in COLUMNS[2:]:
        columns[name] = columns[name].astype(np.float64)
    nothing = np.zeros(len(columns["id"]))
    looks = [columns[name].astype(np.float64) if name in columns else nothing for name in ORIENTATION]
    # Not a number would be NULL: no direction.
    looks = [np.nan_to_num(each, nan=0.0, posinf=0.0, neginf=0.0) for each in looks]
    # `tolist` makes numbers of Python, which are all that sqlite3 takes.
    table = zip(*(each.tolist() for each in (*(columns[name] for name in COLUMNS), *looks)))
    with closing(sqlite3.connect(database)) as made, made:
        made.executescript(
            """
            PRAGMA journal_mode = OFF;
            CREATE TABLE trajectory_data (frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL, ori_x REAL, ori_y REAL);
            CREATE TABLE metadata (key TEXT PRIMARY KEY, value TEXT);
            CREATE TABLE geometry (hash INTEGER, wkt TEXT);
            INSERT INTO metadata VALUES ('version', '2');
            """
        )
        made.execute("INSERT INTO metadata VALUES ('fps', ?)", [_text(rate)])
        if geometry is not None:
            made.execute("INSERT INTO geometry VALUES (1, ?)", [_text(geometry)])
        made.executemany("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)", table)


def _text(value: Any) -> str:
    """Returns a text or a number that an attribute holds, as text; an array of one as this one."""
    held = np.asarray(value).reshape(-1).tolist()
    first = held[0] if len(held) == 1 else repr(held)
    return first.decode(errors="replace") if isinstance(first, bytes) else str(first)


def _whole(path: Path, name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    if values.dtype.kind == "f":
        wrong = ~((np.abs(values) < 2.0**53) & (values == np.round(values)))
    else:
        wrong = values > np.iinfo(np.int64).max
    if wrong.any():
        row = int(np.argmax(wrong))
        raise CommandError(f"{path}: trajectory: row {row + 1}: column {name}: {values[row]} is not a whole number")
    return values.astype(np.int64)


def write_hdf5(database: Path, output: Path) -> None:
    """Writes the trajectories of a database as HDF5, completely or not at all."""
    h5py = _h5py()
    with closing(sqlite3.connect(database)) as read:
        [[rate]] = read.execute("SELECT value FROM metadata WHERE key = 'fps'").fetchall()
        [[geometry]] = read.execute("SELECT wkt FROM geometry").fetchall()
        rows = read.execute("SELECT frame, id, pos_x, pos_y, 0.0, ori_x, ori_y FROM trajectory_data").fetchall()
    kinds = [("frame", "<i8"), ("id", "<i8"), *((name, "<f8") for name in ("x", "y", "z", *ORIENTATION))]
    table = np.array(rows, dtype=np.dtype(kinds))
    with tempfile.TemporaryDirectory(prefix=".lemons-", dir=output.resolve().parent) as directory:
        staged = Path(directory) / output.name
        with h5py.File(staged, "w") as file:
            made = file.create_dataset("trajectory", data=table, compression="gzip", shuffle=True)
            made.attrs["fps"] = float(rate)
            file.attrs["wkt_geometry"] = geometry
        os.replace(staged, output)
