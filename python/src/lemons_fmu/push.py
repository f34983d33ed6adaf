"""A measured push through a row of people, and its difference from a simulated one.

The experiment is that of Feldmann, Adrian and Boltes (2024), as in the practical case of the LEMONS paper (section 4.5): a
push on the person at the end of a row of five, and the trajectories of their heads.
"""

from __future__ import annotations

import csv
import io
import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import _native
from .drive import Drive, Floats
from .record import Run

#: Communication step [s]: the push is recorded every 0.029 s, and interpolated.
STEP = 0.01
#: [s] End of the comparison: the push is over and its record ends. Afterwards people walk back to their places, which the
#: mechanics does not simulate.
UNTIL = 4.0


@dataclass(frozen=True, repr=False)
class Push:
    """The measured data."""

    #: Times [s] and push on agent 0 per unit of its mass, along x [N/kg].
    push: tuple[Floats, Floats]
    #: For each person (index in the row) the columns t [s], x, y [m] of the head, x along the push.
    heads: dict[int, Floats]

    def __repr__(self) -> str:
        return f"<Push of {len(self.heads)} people, {self.end:g} s>"

    @staticmethod
    def read(directory: str | os.PathLike[str]) -> Push:
        """Reads `external_force_per_mass.txt` (a heading, then time and push in each line) and
        `measured_head_trajectories.csv` (columns t, id, x, y).

        Raises:
            ValueError: a file is not valid; the message names file and line.
            OSError: a file cannot be read, is not a regular file, or is larger than 500 MB.
        """
        place = Path(directory)
        rows = []
        path = place / "external_force_per_mass.txt"
        for number, line in enumerate(_native.read_text(os.fspath(path)).splitlines(), 1):
            if number > 1 and line.strip():
                rows.append(_numbers(path, number, line.split(), 2))
        heads: dict[int, list[list[float]]] = {}
        path = place / "measured_head_trajectories.csv"
        reader = csv.DictReader(io.StringIO(_native.read_text(os.fspath(path)), newline=""))
        try:
            if not {"t", "id", "x", "y"} <= set(reader.fieldnames or ()):
                raise ValueError(f"{path}: the columns must be t, id, x, y, not {reader.fieldnames}")
            for row in reader:
                person, *numbers = _numbers(path, reader.line_num, [row[name] for name in ("id", "t", "x", "y")], 4)
                heads.setdefault(int(person), []).append(numbers)
        except csv.Error as error:
            raise ValueError(f"{path}, line {reader.line_num}: {error}") from None
        if len(rows) < 2 or not heads:
            raise ValueError(f"{directory}: no push or no trajectories")
        times, values = np.array(rows).T
        return Push((times, values), {person: np.array(each) for person, each in sorted(heads.items())})

    @property
    def people(self) -> list[int]:
        """Indices of the people who were measured."""
        return list(self.heads)

    @property
    def end(self) -> float:
        """Time at which the trajectories of the heads end [s]."""
        return float(max(rows[-1, 0] for rows in self.heads.values()))

    def drive(self) -> Drive:
        """Returns the push on agent 0, with its value in the middle of each communication step."""
        times, values = self.push
        zero = np.zeros_like(values)
        return Drive({0: (times, np.column_stack([values, zero, zero]))}, at="middle", per_mass=True)

    def residuals(self, run: Run, until: float = UNTIL) -> dict[int, Floats]:
        """Returns for each person the simulated minus the measured displacement from the start, at the measured times: columns
        x, y [m]."""
        out = {}
        for person, rows in self.heads.items():
            rows = rows[rows[:, 0] <= until + 1e-9]
            moved = run.poses[:, person, :2] - run.poses[0, person, :2]
            there = np.column_stack([np.interp(rows[:, 0], run.times, moved[:, axis]) for axis in (0, 1)])
            out[person] = there - (rows[:, 1:] - rows[0, 1:])
        return out

    def differences(self, run: Run, until: float = UNTIL) -> dict[int, tuple[float, float]]:
        """Returns for each person the root-mean-square difference of the displacement: (in the plane, along the push) [m].

        With the paper's engine, their mean is 0.050 m.
        """
        out = {}
        for person, difference in self.residuals(run, until).items():
            squares = (difference**2).mean(axis=0)
            out[person] = (float(np.sqrt(squares.sum())), float(np.sqrt(squares[0])))
        return out


def _numbers(path: Path, line: int, cells: list[str], count: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ValueError(f"{path}, line {line}: must be {count} finite numbers, not {' '.join(map(str, cells))!r}")
    return numbers
