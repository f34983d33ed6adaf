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
#: [bytes] A row of more has not only numbers; a chunk of more, or an attribute, would not fit into small computers.
MOST_OF_ROW, MOST_OF_CHUNK, MOST_OF_ATTRIBUTE = 4096, 2**27, 2**24
#: Rows of more than so many bytes [bytes] may be packed at most so many times: measured positions are packed 3 to 10 times.
LARGE, MOST_PACKED = 2**27, 100
#: Links in a row that are followed.
MOST_LINKS = 8
#: Rows that are in memory at a time, but for a chunk of the file.
BLOCK = 100_000
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
def source(what: str | os.PathLike[str] | Run) -> Iterator[tuple[str, Run | Path | None]]:
    """Yields what commands read: a path, or what a run is called and the run. Of HDF5 it is the path, and that of a database which is
    there meanwhile.

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
            yield os.fspath(what), database


def _to_database(path: Path, database: Path) -> None:
    h5py = _h5py()
    try:
        # A chunk that is in the cache is unpacked once.
        with h5py.File(path, "r", rdcc_nbytes=MOST_OF_CHUNK) as file, closing(sqlite3.connect(database)) as made, made:
            _copy(path, h5py, file, made)
    except (OSError, RuntimeError, ValueError, TypeError, KeyError) as error:
        raise CommandError(f"{path}: is no sound HDF5: {error}") from error


def _within(h5py: Any, file: Any, name: str, links: int = MOST_LINKS) -> Any:
    """What has this name in the file itself; links to other files are not followed."""
    here = file
    for part in name.strip("/").split("/"):
        link = here.get(part, getlink=True) if isinstance(here, h5py.Group) else None
        if isinstance(link, h5py.SoftLink) and links > 0:
            here = _within(h5py, file, link.path if link.path.startswith("/") else f"{here.name}/{link.path}", links - 1)
        else:
            here = here[part] if isinstance(link, h5py.HardLink) else None
    return here


def _copy(path: Path, h5py: Any, file: Any, made: sqlite3.Connection) -> None:
    rows = _within(h5py, file, "trajectory")
    if not isinstance(rows, h5py.Dataset):
        raise CommandError(f'{path}: is HDF5, but not of the data archive: there is no dataset "trajectory"')
    names = rows.dtype.names or ()
    missing = [name for name in COLUMNS if name not in names]
    if missing or rows.ndim != 1:
        raise CommandError(f"{path}: trajectory: {'there is no column ' + repr(missing[0]) if missing else 'has not one dimension'}")
    count = rows.shape[0]
    if count > MOST_ROWS:
        raise CommandError(f"{path}: trajectory: has {count} rows, more than {MOST_ROWS}")
    known = [name for name in ORIENTATION if name in names]
    wanted = [*COLUMNS, *(known if len(known) == 2 else ())]
    # Before anything is read: a cell that is an array can be of any size, and rows that nobody wrote take no place in the file.
    for name in wanted:
        if rows.dtype[name].shape != () or rows.dtype[name].kind not in "iuf":
            raise CommandError(f"{path}: trajectory: column {name}: holds {rows.dtype[name]}, not one number a row")
    chunk = rows.chunks[0] if rows.chunks else 0
    for what, size, most in (
        ("row", rows.dtype.itemsize, MOST_OF_ROW),
        ("chunk", chunk * rows.dtype.itemsize, MOST_OF_CHUNK),
    ):
        if size > most:
            raise CommandError(f"{path}: trajectory: a {what} has {size} bytes, more than {most}")
    if rows.is_virtual or rows.external:
        raise CommandError(f"{path}: trajectory: its rows are in other files")
    stored = min(count, rows.id.get_num_chunks() * chunk) if chunk else rows.id.get_storage_size() // rows.dtype.itemsize
    if stored < count:
        raise CommandError(f"{path}: trajectory: has {count} rows, but only {stored} are in the file")
    size, packed = count * rows.dtype.itemsize, rows.id.get_storage_size()
    if size > max(LARGE, MOST_PACKED * packed):
        raise CommandError(f"{path}: trajectory: {packed} bytes unpack to {size}, more than {MOST_PACKED} times as many")
    rate = _attribute(path, rows, "fps") or _attribute(path, file, "fps")
    if rate is None:
        raise CommandError(f'{path}: trajectory: there is no attribute "fps"')
    geometry = _attribute(path, file, "wkt_geometry")
    made.executescript(
        """
        PRAGMA journal_mode = OFF;
        CREATE TABLE trajectory_data (frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL, ori_x REAL, ori_y REAL);
        CREATE TABLE metadata (key TEXT PRIMARY KEY, value TEXT);
        CREATE TABLE geometry (hash INTEGER, wkt TEXT);
        INSERT INTO metadata VALUES ('version', '2');
        """
    )
    made.execute("INSERT INTO metadata VALUES ('fps', ?)", [rate])
    if geometry is not None:
        made.execute("INSERT INTO geometry VALUES (1, ?)", [geometry])
    for first in range(0, count, BLOCK):
        block = rows.fields(wanted)[first : first + BLOCK]
        numbers = [_whole(path, first, name, block[name]) for name in COLUMNS[:2]]
        numbers += [block[name].astype(np.float64) for name in COLUMNS[2:]]
        looks = [block[name].astype(np.float64) if name in wanted else np.zeros(len(block)) for name in ORIENTATION]
        # Not a number would be NULL: no direction.
        numbers += [np.nan_to_num(each, nan=0.0, posinf=0.0, neginf=0.0) for each in looks]
        # `tolist` makes numbers of Python, which are all that sqlite3 takes.
        made.executemany("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)", zip(*(each.tolist() for each in numbers)))


def _attribute(path: Path, of: Any, name: str) -> str | None:
    """Returns a text or a number that an attribute holds, as text; an array of one as this one."""
    if name not in of.attrs:
        return None
    held = of.attrs.get_id(name)
    size = max(held.get_storage_size(), held.dtype.itemsize * int(np.prod(held.shape or (1,), dtype=float)))
    if size > MOST_OF_ATTRIBUTE or int(np.prod(held.shape, dtype=float)) > 100:
        raise CommandError(f"{path}: attribute {name}: holds {held.shape} values, {size} bytes: not one number or text")
    return _text(of.attrs[name])


def _text(value: Any) -> str:
    held = np.asarray(value).reshape(-1).tolist()
    first = held[0] if len(held) == 1 else repr(held)
    return first.decode(errors="replace") if isinstance(first, bytes) else str(first)


def _whole(path: Path, first: int, name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    if values.dtype.kind == "f":
        wrong = ~((np.abs(values) < 2.0**53) & (values == np.round(values)))
    else:
        wrong = values > np.iinfo(np.int64).max
    if wrong.any():
        row = int(np.argmax(wrong))
        raise CommandError(f"{path}: trajectory: row {first + row + 1}: column {name}: {values[row]} is not a whole number")
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
