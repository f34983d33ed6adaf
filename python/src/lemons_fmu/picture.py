"""Pictures of crowds and of runs, as notebooks show them."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from typing import Literal, Union

from . import files
from .command import Option, call, options
from .recorded import Recorded, table_of

#: What can be drawn: a Trial, an FMU or a table, by its path, or a Run.
Drawn = Union[str, "os.PathLike[str]", Recorded]


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
        CommandError: the command refuses something, or is missing; the message is its own.
        OSError: it cannot be written.
    """
    path = Path(output)
    with tempfile.TemporaryDirectory(prefix="lemons-movie-") as directory:
        film = Path(directory) / f"movie{path.suffix}"
        if not isinstance(what, (str, os.PathLike)):
            what = table_of(what, Path(directory))
        call(["movie", f"--output={film}", *options({"trial": trial, **others}), "--", os.fspath(what)])
        beside = path.with_name(f".{path.name}.tmp")
        shutil.copyfile(film, beside)
        os.replace(beside, path)
    return path


def plot(
    what: Drawn,
    *,
    trial: str | os.PathLike[str] | None = None,
    format: Literal["svg", "png"] = "svg",
    **others: Option,
) -> Picture:
    """Draws what `lemons plot` draws: scenes, time series, a map of density.

    `what` is a Trial or an FMU, which is simulated first as far as it is drawn; the table of an earlier run; or a `Run`. For
    the scenes of a table or a Run, `trial` is the Trial or FMU that was simulated, as there are no shapes and walls in it.
    All other options of the command have the same names here: `at=[0.5, 1.0]`, `fill="squeeze"`, `forces=True`,
    `series=["speed"]`, `density=True`, `set={"agent[1].Mass": 60.0}`.

    Raises:
        CommandError: the command refuses something, or is missing; the message is its own.
    """
    with tempfile.TemporaryDirectory(prefix="lemons-plot-") as directory:
        output = Path(directory) / f"picture.{format}"
        if not isinstance(what, (str, os.PathLike)):
            what = table_of(what, Path(directory))
        call(["plot", f"--output={output}", *options({"trial": trial, **others}), "--", os.fspath(what)])
        return Picture(files.read(output, files.LARGEST_BINARY), format)
