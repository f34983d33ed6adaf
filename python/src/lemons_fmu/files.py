"""Reads files that may be anything: a pipe that nobody writes to, a link to an endless device, a file of a terabyte.

A file that is found by its name must be a regular file. A file that the user names may also be a pipe or a device. Both are
read up to the same limit as in the command `lemons`.
"""

from __future__ import annotations

import errno
import os
import select
import stat
import sys
from typing import BinaryIO

#: The largest settings file [byte].
LARGEST_SETTINGS = 64_000_000
#: The largest file of a Trial [byte].
LARGEST_TRIAL_FILE = 1_000_000_000
#: The largest drive file or table of measurements [byte].
LARGEST_DRIVE = 500_000_000
#: The largest FMU that is read into memory, and its largest size when it is unpacked [byte].
LARGEST_BINARY = 4_000_000_000
LARGEST_UNPACKED = 4_000_000_000

# The systems differ in what there is. Without O_BINARY, Windows replaces ends of lines.
_FLAGS = os.O_RDONLY
for _flag in ("O_NONBLOCK", "O_NOCTTY", "O_BINARY"):
    _FLAGS |= getattr(os, _flag, 0)

#: Time to wait for the writer of a pipe [s].
PATIENCE = 30.0


def found(path: str | os.PathLike[str], largest: int | None = None) -> BinaryIO:
    """Opens a regular file without waiting, and refuses anything else.

    Raises:
        OSError: the file cannot be opened, is not a regular file, or is larger than `largest` bytes.
    """
    # Opening a device can have side effects.
    _regular(os.stat(path), path)
    descriptor = os.open(path, _FLAGS)
    try:
        there = os.fstat(descriptor)
        _regular(there, path)
        if largest is not None and there.st_size > largest:
            raise too_large(path, largest)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read(path: str | os.PathLike[str], largest: int) -> bytes:
    """Returns the content of a regular file of at most `largest` bytes.

    Raises:
        OSError: the file cannot be read, is not a regular file or is larger.
    """
    with found(path, largest) as file:
        return _whole(file, path, largest)


def read_text(path: str | os.PathLike[str], largest: int) -> str:
    """Returns the UTF-8 text of a file; else as `read`.

    Raises:
        OSError: see `read`.
        ValueError: the file is not UTF-8 text.
    """
    try:
        return read(path, largest).decode()
    except UnicodeDecodeError as error:
        raise ValueError(f"{os.fspath(path)}: it is not UTF-8 text (byte {error.start})") from None


def read_given(path: str | os.PathLike[str], largest: int) -> bytes:
    """Returns the content of a file that the user names, of at most `largest` bytes. It may be a pipe or a device.

    Raises:
        OSError: the file cannot be read, is larger, or is a pipe that nobody writes to.
    """
    with open(path, "rb", opener=_open_given) as file:
        return _whole(file, path, largest)


def _whole(file: BinaryIO, path: str | os.PathLike[str], largest: int) -> bytes:
    # It may have grown: one more byte distinguishes a file that is too large from one that just fits.
    data = file.read(largest + 1)
    if len(data) > largest:
        raise too_large(path, largest)
    return data


def too_large(path: str | os.PathLike[str], largest: int) -> OSError:
    """The error for a file that is too large."""
    return OSError(errno.EFBIG, f"it is larger than {largest / 1e6:g} MB, the limit", os.fspath(path))


def _regular(there: os.stat_result, path: str | os.PathLike[str]) -> None:
    mode = there.st_mode
    if stat.S_ISREG(mode):
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    what = "a pipe" if stat.S_ISFIFO(mode) else "a socket" if stat.S_ISSOCK(mode) else "a device"
    raise OSError(errno.EINVAL, f"it is {what}, not a regular file", os.fspath(path))


def _open_given(path: str, flags: int) -> int:
    """Opens a file. For a pipe that nobody writes to it raises an error, where `open` would wait for ever."""
    if sys.platform == "win32":
        return os.open(path, flags)
    descriptor = os.open(path, flags | os.O_NONBLOCK)
    try:
        if stat.S_ISFIFO(os.fstat(descriptor).st_mode):
            if not select.select([descriptor], [], [], PATIENCE)[0]:
                raise TimeoutError(errno.ETIMEDOUT, f"nobody wrote to this pipe for {PATIENCE:g} s", path)
            os.set_blocking(descriptor, True)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor
