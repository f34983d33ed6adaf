"""The command `lemons`, of which this package uses what makes crowds, packs, draws, measures and exports them."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from typing import Union, cast

import numpy as np

from lemons_command import program

#: The value of an option: True is the option alone; False and None leave it out; a sequence is joined with commas, and one of
#: sequences is given once for each; a mapping is given as NAME=VALUE, once for each.
Single = Union[int, float, str]
Option = Union[
    None, bool, Single, "os.PathLike[str]", Sequence[Single], Sequence[Sequence[Single]], Mapping[str, Single]
]


class CommandError(Exception):
    """The command `lemons` is missing, or it refuses something: the message is its own."""


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


def call(words: Iterable[str | os.PathLike[str]]) -> str:
    """Calls the command, and returns what it prints.

    Raises:
        CommandError: it is missing, or it fails.
    """
    try:
        command = [program(), *(os.fspath(word) for word in words)]
        # Ctrl-C reaches the command, too: it leaves nothing half-written. Python kills it if it takes longer than 0.25 s.
        done = subprocess.run(
            command,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            stdin=subprocess.DEVNULL,
        )
    except OSError as error:
        raise CommandError(str(error)) from None
    if done.returncode != 0:
        raise CommandError(done.stderr.strip() or f"lemons ended with {done.returncode}")
    return done.stdout


def _text(value: int | float | str | os.PathLike[str]) -> str:
    # Of numpy's numbers, too, as which `repr` would name their type.
    return os.fspath(value) if isinstance(value, (str, os.PathLike)) else f"{value}"
