"""Reads regular files, up to the limits of the command `lemons`. Opening anything else could wait for ever: a pipe that nobody
writes to, a link to an endless device.
"""

from __future__ import annotations

import errno
import os
import stat
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
