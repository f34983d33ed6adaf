"""Trials: people as arrays, made from body statistics or read from the directory of a Trial; packed and drawn."""

from __future__ import annotations

import errno
import math
import os
import shutil
import tempfile
import weakref
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Literal, Union

import numpy as np

from . import _native
from ._native import CommandError
from .command import Option, call, options
from .drive import Floats
from .picture import Picture, plot

Path_ = Union[str, "os.PathLike[str]"]
Sex = Literal["male", "female"]


class Trial:
    """The people of a Trial, by its directory. `os.fspath` gives the directory, so a Trial can be given where a path can.

    What `crowd` and `person` make without `output` is in a temporary directory, which exists as long as the Trial does:
    `save` copies it.

    Raises:
        ValueError: a file is missing, or not what it should be. `lemons check` tells more.
    """

    def __init__(self, directory: Path_) -> None:
        #: Where its files are.
        self.directory = Path(directory)
        ids, masses, inertias, statures, shapes, poses = _native.read_people(os.fspath(directory))
        #: Ids of the people.
        self.ids: list[str] = ids
        #: Masses [kg], shape (N,).
        self.masses: Floats = np.array(masses)
        #: Moments of inertia about the vertical axis [kg.m2], shape (N,).
        self.inertias: Floats = np.array(inertias)
        #: Statures [m], shape (N,); NaN where the Trial does not say.
        self.statures: Floats = np.array(statures)
        #: The disks of each person: x, y [m] from the centre of mass, the gaze along x, and radius [m], shape (disks, 3).
        self.shapes: list[Floats] = [np.array(disks).reshape(-1, 3) for disks in shapes]
        #: x, y [m], theta [rad] at the start, shape (N, 3).
        self.poses: Floats = np.array(poses).reshape(-1, 3)

    def __fspath__(self) -> str:
        return os.fspath(self.directory)

    def __len__(self) -> int:
        """The number of people."""
        return len(self.ids)

    def __repr__(self) -> str:
        who = "1 person" if len(self) == 1 else f"{len(self)} people"
        return f"<Trial {self.directory.name!r}: {who}, {self.masses.sum():.0f} kg>"

    def _repr_svg_(self) -> str | None:
        # A picture that cannot be drawn must not hide the text.
        try:
            return self._picture._repr_svg_()
        except CommandError:
            return None

    @cached_property
    def _picture(self) -> Picture:
        return plot(self.directory)

    @property
    def disks(self) -> Floats:
        """All disks in the plane at the start: x, y [m], radius [m] and the place of the person, shape (disks, 4)."""
        rows = []
        for place, (shape, (x, y, theta)) in enumerate(zip(self.shapes, self.poses)):
            sine, cosine = math.sin(theta), math.cos(theta)
            for dx, dy, radius in shape:
                rows.append((x + cosine * dx - sine * dy, y + sine * dx + cosine * dy, radius, place))
        return np.array(rows).reshape(-1, 4)

    def save(self, output: Path_, *, force: bool = False) -> Trial:
        """Copies it to another directory, and returns it from there. With `force`, that directory may exist: it is replaced.

        Raises:
            OSError: it cannot be written, or it exists, or with `force` it is no Trial.
        """
        output = Path(output)
        if not force or not output.exists():
            shutil.copytree(self.directory, output)
            return Trial(output)
        if not (output / "Parameters.xml").is_file():
            raise FileExistsError(errno.EEXIST, "is no Trial, so it is not replaced", os.fspath(output))
        # What the other Trial has must not stay: its drive.csv would push these people.
        with tempfile.TemporaryDirectory(dir=output.absolute().parent, prefix=".lemons-save-") as beside:
            new, old = Path(beside) / "new", Path(beside) / "old"
            shutil.copytree(self.directory, new)
            output.rename(old)
            new.rename(output)
        return Trial(output)

    def pack(self, output: Path_, *, fmi: Literal[2, 3] = 2, platforms: Sequence[str] = (), **others: Option) -> Path:
        """Packs it: see `pack`."""
        return pack(self, output, fmi=fmi, platforms=platforms, **others)

    def plot(self, *, format: Literal["svg", "png"] = "svg", **others: Option) -> Picture:
        """Draws it, simulated as far as that is needed: see `plot`."""
        return plot(self, trial=None, format=format, **others)


def crowd(
    number: int | None = None,
    *,
    box: tuple[float, float] | None = None,
    density: float | None = None,
    seed: int | None = None,
    output: Path_ | None = None,
    **others: Option,
) -> Trial:
    """Makes a crowd as `lemons crowd` does: people from body statistics, packed without overlap.

    `box` is the region with walls [m]; without it, and without `geometry`, people stand in the open. `density` [1/m2] can
    stand for the number. The same seed (default 1) gives the same crowd on every machine; so does the same `scenario`, a file
    that the command has saved. All other options of the command have the same
    names here: `speed=0.5`, `men=0.4`, `direction=90`, `packing="grid"`, `fixed=[49, 25, 1.75, 70]`. The Trial is written to
    `output`, by default to a temporary directory.

    Raises:
        CommandError: something is refused; the message is that of the command.
    """
    region = None if box is None else "x".join(_number(side) for side in box)
    return _made(output, {"number": number, "density": density, "box": region, "seed": seed, **others})


def person(
    *,
    breadth: float,
    depth: float,
    stature: float,
    mass: float,
    sex: Sex = "male",
    output: Path_ | None = None,
    **others: Option,
) -> Trial:
    """Makes one person, alone in the open, who faces along x: the shape that `lemons person` prints, as a Trial.

    `breadth` is that of the shoulders (bideltoid) [m], `depth` that of the chest [m]; stature [m], mass [kg]. Other options
    are those of `crowd`.

    Raises:
        CommandError: something is refused; the message is that of the command.
    """
    measures: Sequence[str] = [*(_number(each) for each in (100.0 * breadth, 100.0 * depth, stature, mass)), sex]
    return _made(output, {"number": 1, "orientation": "fixed", "fixed": measures, **others})


def pack(
    trials: Path_ | Trial | Sequence[Path_ | Trial],
    output: Path_,
    *,
    fmi: Literal[2, 3] = 2,
    platforms: Sequence[str] = (),
    **others: Option,
) -> Path:
    """Packs a Trial, or several with the same people, as `lemons pack` does, and returns the FMU's path.

    `platforms` are those of which the library gets into it (`"linux64"`, `"win64"`, `"aarch64-linux"`, `"darwin64"`), by
    default all that were installed with this package.

    Raises:
        CommandError: something is refused; the message is that of the command.
    """
    if isinstance(platforms, str):
        raise TypeError(f"platforms={platforms!r}: is one text; give a list, such as [{platforms!r}]")
    several = [trials] if isinstance(trials, (str, os.PathLike, Trial)) else list(trials)
    chosen = [f"--platform={platform}" for platform in platforms]
    given = [os.fspath(trial) for trial in several]
    call(["pack", f"--output={os.fspath(output)}", f"--fmi={fmi}", *chosen, *options(others), "--", *given])
    return Path(output)


def _made(output: Path_ | None, given: dict[str, Option]) -> Trial:
    if output is not None:
        call(["crowd", f"--output={os.fspath(output)}", *options(given)])
        return Trial(output)
    temporary = tempfile.mkdtemp(prefix="lemons-crowd-")
    try:
        directory = os.path.join(temporary, "crowd")
        call(["crowd", f"--output={directory}", *options(given)])
        made = Trial(directory)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    weakref.finalize(made, shutil.rmtree, temporary, ignore_errors=True)
    return made


def _number(value: float) -> str:
    """A decimal number; what 100 x 0.49 m has behind its twelfth digit is no part of it."""
    return f"{value:.12g}"
