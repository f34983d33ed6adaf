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
from xml.etree import ElementTree

import numpy as np

from . import files
from .command import CommandError, Option, call, options
from .drive import Floats
from .picture import Picture, plot

Path_ = Union[str, "os.PathLike[str]"]
Sex = Literal["male", "female"]


class Trial:
    """The people of a Trial, by its directory. `os.fspath` gives the directory, so a Trial can be given where a path can.

    What `crowd` and `person` make without `output` is in a temporary directory, which exists as long as the Trial does:
    `save` copies it.

    Raises:
        OSError: a file is missing or cannot be read.
        ValueError: a file is not what it should be. `lemons check` tells more.
    """

    def __init__(self, directory: Path_) -> None:
        #: Where its files are.
        self.directory = Path(directory)
        parameters = _root(self.directory / "Parameters.xml")
        places = parameters.find("Directories")
        if places is None:
            raise ValueError(f"{self.directory / 'Parameters.xml'}: there is no <Directories>")
        static, dynamic = (self.directory / places.get(name, "").strip() for name in ("Static", "Dynamic"))
        agents = _by_id(static / "Agents.xml")
        moving = _by_id(dynamic / "AgentDynamics.xml")
        for missing in agents.keys() ^ moving.keys():
            where = dynamic / "AgentDynamics.xml" if missing in agents else static / "Agents.xml"
            raise ValueError(f"{where}: there is no agent {missing!r}")
        #: Ids of the people.
        self.ids: list[str] = list(agents)
        #: Masses [kg], shape (N,).
        self.masses: Floats = np.array([agent.number("Mass") for agent in agents.values()])
        #: Moments of inertia about the vertical axis [kg.m2], shape (N,).
        self.inertias: Floats = np.array([agent.number("MomentOfInertia") for agent in agents.values()])
        #: Statures [m], shape (N,); NaN where the Trial does not say.
        self.statures: Floats = np.array([agent.number("Height", math.nan) for agent in agents.values()])
        #: The disks of each person: x, y [m] from the centre of mass, the gaze along x, and radius [m], shape (disks, 3).
        self.shapes: list[Floats] = [
            np.array([[*disk.pair("Position"), disk.number("Radius")] for disk in agent.children("Shape")]).reshape(-1, 3)
            for agent in agents.values()
        ]
        kinematics = [moving[i].child("Kinematics") for i in self.ids]
        poses = [[*each.pair("Position"), each.number("Theta")] for each in kinematics]
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
    seed: int = 1,
    output: Path_ | None = None,
    **others: Option,
) -> Trial:
    """Makes a crowd as `lemons crowd` does: people from body statistics, packed without overlap.

    `box` is the region with walls [m]; without it, and without `geometry`, people stand in the open. `density` [1/m2] can
    stand for the number. The same seed gives the same crowd on every machine. All other options of the command have the same
    names here: `speed=0.5`, `men=0.4`, `direction=90`, `packing="grid"`, `fixed=[49, 25, 1.75, 70]`. The Trial is written to
    `output`, by default to a temporary directory.

    Raises:
        CommandError: the command refuses something, or is missing; the message is its own.
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
        CommandError: the command refuses something, or is missing; the message is its own.
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
        CommandError: the command refuses something, or is missing; the message is its own.
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


def _root(path: Path) -> ElementTree.Element:
    text = files.read(path, files.LARGEST_TRIAL_FILE)
    # Other encodings could hide what is looked for below.
    if b"\0" in text:
        raise ValueError(f"{path}: is not a text in UTF-8")
    # Entities could make a small file a huge one; no file of a Trial has any.
    if b"<!DOCTYPE" in text:
        raise ValueError(f"{path}: contains a document type, which no file of a Trial does")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"{path}: {error}") from None


class _Element:
    """An element of an agent, whose errors name the file, the agent, the element and the attribute."""

    def __init__(self, path: Path, agent: str, element: ElementTree.Element) -> None:
        self.path, self.agent, self.element = path, agent, element

    def wrong(self, what: str) -> ValueError:
        return ValueError(f"{self.path}: agent {self.agent!r}: {what}")

    def text(self, attribute: str) -> str:
        text = self.element.get(attribute)
        if text is None:
            raise self.wrong(f"<{self.element.tag}>: {attribute} is missing")
        return text

    def number(self, attribute: str, default: float | None = None) -> float:
        if default is not None and self.element.get(attribute) is None:
            return default
        return self._finite(attribute, self.text(attribute))

    def pair(self, attribute: str) -> tuple[float, float]:
        text = self.text(attribute)
        words = text.split(",")
        if len(words) != 2:
            raise self.wrong(f"<{self.element.tag}>: {attribute}={text!r} is not two numbers")
        return self._finite(attribute, words[0]), self._finite(attribute, words[1])

    def _finite(self, attribute: str, text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise self.wrong(f"<{self.element.tag}>: {attribute}={text!r} is not a finite number")
        return number

    def children(self, tag: str) -> list[_Element]:
        return [_Element(self.path, self.agent, child) for child in self.element.findall(tag)]

    def child(self, tag: str) -> _Element:
        found = self.children(tag)
        if len(found) != 1:
            raise self.wrong(f"has {len(found)} elements <{tag}>, not one")
        return found[0]


def _by_id(path: Path) -> dict[str, _Element]:
    """The agents of a file, by their Ids."""
    agents: dict[str, _Element] = {}
    for place, element in enumerate(_root(path).findall("Agent")):
        agent = element.get("Id")
        if agent is None:
            raise ValueError(f"{path}: <Agent> number {place + 1}: Id is missing")
        if agent in agents:
            raise ValueError(f"{path}: duplicate Id {agent!r}")
        agents[agent] = _Element(path, agent, element)
    return agents
