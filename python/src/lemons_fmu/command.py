"""The commands of `lemons`, in this process: options are the same words."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple, Union, cast

import numpy as np

from lemons_command import program

from . import _native
from ._native import CommandError as CommandError

if TYPE_CHECKING:
    from pathlib import Path

    from .record import Run

#: The value of an option: True is the option alone; False and None leave it out; a sequence is joined with commas, and one of
#: sequences is given once for each; a mapping is given as NAME=VALUE, once for each.
Single = Union[int, float, str]
Option = Union[
    None, bool, Single, "os.PathLike[str]", Sequence[Single], Sequence[Sequence[Single]], Mapping[str, Single]
]


class Made(NamedTuple):
    """What came of a command: what it says, its warnings, a picture, a summary in JSON, tables in CSV by their names."""

    said: str
    notes: list[str]
    picture: bytes
    summary: str
    tables: list[tuple[str, str]]


def options(values: Mapping[str, Option]) -> list[str]:
    """Returns options as the command wants them: `speed_up=0.2` is `--speed-up=0.2`."""
    words = []
    for name, value in values.items():
        # `from_` and the like avoid the words of Python.
        option = "--" + name.rstrip("_").replace("_", "-")
        if isinstance(value, np.generic):
            value = value.item()
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
        elif isinstance(value, Mapping):
            words += [f"{option}={key}={_text(each)}" for key, each in value.items()]
        elif isinstance(value, (int, float, str, os.PathLike)):
            words.append(f"{option}={_text(value)}")
        else:
            words += [f"{option}={','.join(_text(each) for each in one)}" for one in _each(value)]
    return words


def _each(value: Sequence[Single] | Sequence[Sequence[Single]]) -> list[Sequence[Single]]:
    """Returns one sequence, or those that it consists of."""
    nested = [each for each in value if not isinstance(each, (int, float, str, np.generic, os.PathLike))]
    if not nested:
        return [cast("Sequence[Single]", value)]
    if len(nested) < len(value):
        raise TypeError(f"{value!r}: either numbers or sequences of them, not both")
    return nested


def call(words: Sequence[str | os.PathLike[str]], held: Run | Path | None = None) -> Made:
    """Calls a command; `held` is its operand, if that is a run in memory, or a database in the place of the file that is named.
    What it notes becomes warnings.

    Raises:
        CommandError: it fails.
    """
    # The libraries that it packs lie beside the program.
    with suppress(FileNotFoundError):
        _native.look_in(os.path.dirname(os.path.abspath(program())))
    task = _native.Task([os.fspath(word) for word in words], held)
    try:
        while (result := task.wait(0.1)) is None:
            pass
    except CommandError:
        raise
    except BaseException:
        # Ctrl-C: it removes what it has begun.
        task.stop()
        with suppress(CommandError):
            task.wait(600.0)
        raise
    made = Made(*result)
    for note in made.notes:
        warnings.warn(note, stacklevel=3)
    return made


def _text(value: int | float | str | os.PathLike[str]) -> str:
    # Of numpy's numbers, too, as which `repr` would name their type.
    return os.fspath(value) if isinstance(value, (str, os.PathLike)) else f"{value}"
