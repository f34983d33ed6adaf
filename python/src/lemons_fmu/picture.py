"""Pictures of crowds and of runs, as notebooks show them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Union

from .command import Option, call, options
from .hdf5 import source

if TYPE_CHECKING:
    from .record import Run

#: What can be drawn: a Trial, an FMU, a table or trajectories, by its path, or a Run.
Drawn = Union[str, "os.PathLike[str]", "Run"]


class Picture:
    """A picture in SVG or PNG. A notebook shows it; `save` writes it."""

    def __init__(self, data: bytes, format: Literal["svg", "png"]) -> None:
        self.data = data
        self.format = format

    def __repr__(self) -> str:
        return f"<Picture, {self.format.upper()}, {len(self.data) / 1000:.0f} kB>"

    def _repr_svg_(self) -> str | None:
        return self.data.decode() if self.format == "svg" else None

    def _repr_png_(self) -> bytes | None:
        return self.data if self.format == "png" else None

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes it, whatever is there. The end of the name must be that of its format.

        Raises:
            ValueError: it is of another format.
            OSError: it cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() != f".{self.format}":
            raise ValueError(f"{path}: the picture is {self.format.upper()}: plot(…, format={path.suffix[1:]!r}) draws another")
        path.write_bytes(self.data)
        return path


def movie(
    what: Drawn,
    output: str | os.PathLike[str],
    *,
    trial: str | os.PathLike[str] | None = None,
    **others: Option,
) -> Path:
    """Films what `lemons movie` films, writes it, whatever is there, and returns the path: MP4 (needs the program ffmpeg), GIF or
    animated PNG, by the end of its name.

    `what` and `trial` are as for `plot`. All other options of the command have the same names here: `until="left"`,
    `speed_up=4`, `fill="squeeze"`, `over=1`.

    Raises:
        CommandError: something is refused; the message is that of the command.
        OSError: it cannot be written.
    """
    with source(what) as (path, run):
        call(["movie", "--force", f"--output={os.fspath(output)}", *options({"trial": trial, **others}), "--", path], run)
    return Path(output)


def plot(
    what: Drawn,
    *,
    trial: str | os.PathLike[str] | None = None,
    format: Literal["svg", "png"] = "svg",
    **others: Option,
) -> Picture:
    """Draws what `lemons plot` draws: scenes, time series, a map of density.

    `what` is a Trial or an FMU, which is simulated first as far as it is drawn; the table of an earlier run; a `Run`; or trajectories, as for
    `measure`. For
    the scenes of a table, `trial` is the Trial or FMU that was simulated, as there are no shapes and walls in it; a Run knows
    its own.
    All other options of the command have the same names here: `at=[0.5, 1.0]`, `fill="squeeze"`, `forces=True`,
    `series=["speed"]`, `density=True`, `set={"agent[1].Mass": 60.0}`.

    Raises:
        CommandError: something is refused; the message is that of the command.
    """
    with source(what) as (path, run):
        words = ["plot", f"--output=picture.{format}", *options({"trial": trial, **others}), "--", path]
        return Picture(call(words, run).picture, format)
