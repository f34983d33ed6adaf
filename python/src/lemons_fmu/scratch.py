"""The temporary directory of a process, where FMUs are unpacked."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

from . import locks
from .errors import FmuError

_own_scratch: list[Path] = []
_own_lock: list[int] = []


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
    """Lets a forked child have a directory of its own."""
    _own_scratch.clear()
    for descriptor in _own_lock:
        os.close(descriptor)
    _own_lock.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
