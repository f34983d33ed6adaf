"""Many runs with different parameters, on the cores of this machine or on a Dask cluster."""

from __future__ import annotations

import itertools
import json
import math
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sized
from typing import TYPE_CHECKING, Any, Union

from . import _native
from ._native import SweepError as SweepError
from .crowd import Algorithm, Crowd, DecisionChoice, Source, Until, Value, model_of
from .drive import DriveLike, function_identity, identity, known
from .extra import needed
from .progress import Progress, ProgressLine
from .work import ERROR, POINT, RESERVED, STATUS, Job, Measure, Result, Stop, Subject

if TYPE_CHECKING:
    import pandas as pd
    from distributed import Client, LocalCluster

#: A grid (name → values, all combinations, the last name varies fastest) or a table (a row for each point).
Grid = Union[Mapping[str, Iterable[Value]], "pd.DataFrame"]

#: A larger number of points is taken for a mistake, as by `lemons sweep`.
MOST_POINTS = 10_000_000


def sweep(
    what: Source,
    points: Grid,
    drive: DriveLike[Crowd],
    measure: Measure,
    *,
    until: Until,
    step: float | None = None,
    decision: DecisionChoice = None,
    algorithm: Algorithm = "jacobi",
    stop: Stop | None = None,
    out: str | os.PathLike[str] | None = None,
    client: Client | str | None = None,
    progress: bool | Callable[[Progress], None] = True,
    retry_failed: bool = False,
) -> pd.DataFrame:
    """Simulates every point until a time [s]. Returns a table sorted by point: `point`, the parameters, the measures of each
    run, `status` (`ok` or `failed`) and `error` (the message of a failed point).

    `what` is a Trial or the FMU of a crowd, and people walk as in a `Crowd` (`decision`, `algorithm`). The path of `what` or
    `decision` may contain names of parameters in braces: `"room_{width}_{seed}"`. Such a parameter only chooses what is
    simulated.

    `points` is a grid or a table of parameters by their names in the FMU (`agent[*].Mass` sets the masses of all agents,
    `decision.agent[3].DesiredSpeed` a parameter of Decision). `drive` is as for `Crowd.run`: None is the drive.csv of the point's
    Trial, False is no drive. `measure` is a function of a `Run` that returns names and numbers (or texts), the same names at all
    points; None is a number that is not known. `Run.measure` gives it what `lemons measure` computes.

    `until="left"` and `stop` end points as they end `Crowd.run`. The table then has the measure `ended` [s]: when that was; not
    a number where it never was.

    With `out`, the name of a file, results are appended to this table as they come: CSV, as that of `lemons sweep`. A sweep that
    was killed continues from there: finished points are not simulated again (failed ones only with `retry_failed`).

    `client` is a Dask client or the address of a scheduler. Without one, all cores of this machine are used by worker
    processes. `progress` shows the progress on standard error, or is a function that gets it.

    Raises:
        CommandError: a Trial or a decision.toml has errors.
        SimulationError: there is no variable with such a name, or nobody can leave.
        TypeError: the drive is not a drive, or the values of a parameter are not a list.
        ValueError: points, drive or times are not valid.
        OSError: the drive's file cannot be read.
        SweepError: the table is that of another sweep or cannot be written, or the scheduler is gone.
        ImportError: there is no Dask, cloudpickle or pandas: `pip install 'lemons-fmu[sweep]'`.
    """
    with needed("sweep", "a sweep"):
        import pandas  # noqa: F401 - for points and results

        from . import cluster
    study = Study(points, what, decision, algorithm, drive, until, step)
    work = cluster.pickled((drive if callable(drive) else None, measure, stop))
    subject = study.subject(0) if study.count == 1 else None
    job = Job(os.urandom(8).hex(), subject, tuple(study.native.names), tuple(study.native.set()), algorithm, work, until)
    asked = {**study.identity, "measure": function_identity(measure), "until": until if until == "left" else float(until)}
    if stop is not None:
        asked["stop"] = function_identity(stop)
    results = Results(study.native, out, {"program": "lemons_fmu", **asked}, retry_failed)
    report = progress if callable(progress) else ProgressLine() if progress else lambda _: None
    try:
        return cluster.simulate_all(study, job, results, client, report)
    finally:
        results.keep()


def local_cluster(workers: int | None = None, *, threads: int = 1, processes: bool = True) -> LocalCluster:
    """Starts workers on this machine, by default one for each core.

    Raises:
        ImportError: there is no Dask: `pip install 'lemons-fmu[sweep]'`.
    """
    with needed("sweep", "a cluster"):
        from . import cluster
    return cluster.local_cluster(workers, threads=threads, processes=processes)


def _columns(points: Grid) -> tuple[list[tuple[str, list[Any]]], bool]:
    """Returns the parameters with their values, and whether all combinations of these are points."""
    import pandas as pd

    columns: list[tuple[str, list[Any]]]
    if isinstance(points, pd.DataFrame):
        columns = [(str(name), points[name].tolist()) for name in dict.fromkeys(points.columns)]
        if len(columns) != len(points.columns):
            raise ValueError("two columns of the table have the same name")
    else:
        for name, values in points.items():
            if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
                raise TypeError(f"parameter {name}: must be a list of values, not {values!r}")
        # Before they are made: they would take all memory.
        count = math.prod(len(values) for values in points.values() if isinstance(values, Sized))
        columns = []
        for name, values in points.items():
            listed = list(itertools.islice(values, 0 if count > MOST_POINTS else MOST_POINTS + 1))
            if max(count, len(listed)) > MOST_POINTS:
                raise ValueError(f"there are more than {MOST_POINTS} points")
            columns.append((str(name), [each.item() if hasattr(each, "item") else each for each in listed]))
    for name, _ in columns:
        if name in RESERVED:
            raise ValueError(f"{name!r} cannot be a parameter: the table already has a column with this name")
    return columns, not isinstance(points, pd.DataFrame)


class Study:
    """What points simulate: one Trial or FMU, or those that parameters choose. All are read and checked at the beginning, and
    those of several again shortly before they are simulated, so that not all of them are in memory."""

    def __init__(
        self,
        points: Grid,
        what: Source,
        decision: DecisionChoice,
        algorithm: Algorithm,
        drive: DriveLike[Crowd],
        until: Until,
        step: float | None,
    ) -> None:
        if isinstance(until, str) and until != "left":
            raise ValueError(f"until={until!r}: must be a time [s], or 'left'")
        path = None if decision is None or decision is False else os.fspath(decision)
        columns, grid = _columns(points)
        self.native = _native.Study(columns, grid, os.fspath(what), path, decision is not False)
        self._models, self._drive, self._step = self.native.models(), drive, step
        self._algorithm, self._until = algorithm, None if isinstance(until, str) else float(until)
        self.count = len(self._models)
        self._identities: list[str] = []
        for place in range(self.count):
            subject = self.subject(place)
            told = self._told(subject)
            if drive is not None:
                told["drive"] = identity(drive if callable(drive) else subject.drive)
            self._identities.append(json.dumps(told, sort_keys=True))
        of_all = json.loads(self.native.identity_of_all(self._identities))
        #: What must be equal to continue a sweep.
        self.identity: dict[str, Any] = {**json.loads(self._identities[0]), **of_all} if self.count == 1 else of_all

    def subject(self, place: int) -> Subject:
        """Reads what the points of a model simulate.

        Raises:
            CommandError, TypeError, ValueError, OSError: see `sweep`.
        """
        path, decision, walk = self._models[place]
        model = model_of(path, decision if walk else False)
        drive = known(self._drive, model.ids)
        step = model.step if self._step is None else float(self._step)
        # Functions are sent with the job.
        return Subject(model, None if callable(drive) else drive, step)

    def _told(self, subject: Subject) -> dict[str, Any]:
        told: dict[str, Any] = json.loads(self.native.identity(subject.model, self._algorithm, self._until, subject.step))
        return told

    def again(self, point: int) -> Subject | None:
        """Reads what a point simulates if there are several models.

        Raises:
            SweepError: it has changed since the sweep began.
        """
        if self.count == 1:
            return None
        place = self.native.place(point)
        subject = self.subject(place)
        told = self._told(subject)
        kept = json.loads(self._identities[place])
        if {**told, "drive": None} != {**kept, "drive": None}:
            raise SweepError(f"{self._models[place][0]} has changed since the sweep began; finished points are kept")
        return subject


class Results:
    """Finished points: in memory, and in a table if that is asked for."""

    def __init__(
        self, study: _native.Study, out: str | os.PathLike[str] | None, asked: Mapping[str, Any], retry_failed: bool
    ) -> None:
        self._study = study
        if out is not None:
            os.makedirs(os.path.dirname(os.path.abspath(out)), exist_ok=True)
        self._table = None if out is None else _native.Table(os.fspath(out), json.dumps(asked), study)
        self._names = None if self._table is None else self._table.measures
        self.rows: dict[int, Result] = {}
        #: Results that are not in the table yet.
        self._new: list[Result] = []
        self._begin = self._last = time.monotonic()
        for row in [] if self._table is None else self._table.rows():
            self.rows[row[0]] = row
        #: Whether a point has measures.
        self._named = any(measures is not None for _, measures, _ in self.rows.values())
        #: Points that are not simulated again.
        self.finished = {point for point, _, error in self.rows.values() if error is None or not retry_failed}

    def add(self, results: list[Result]) -> list[Result]:
        """Adds finished points, and returns them as they are in the table."""
        added = []
        for point, measures, error in results:
            if measures is not None and not self._named:
                self._names, self._named = list(measures), True
            if measures is not None and set(measures) != set(self._names or ()):
                # A column that other points do not have cannot be added to a table.
                error = f"ValueError: the measures are {', '.join(measures) or 'none'}, and not {', '.join(self._names or ())} as before"
                measures = None
            added.append((point, measures, error))
            self.rows[point] = added[-1]
        self._new += added
        if time.monotonic() - self._last > max(1.0, 0.01 * (time.monotonic() - self._begin)):
            self.keep()
        return added

    def keep(self) -> None:
        """Appends what is new to the table."""
        new, self._new = self._new, []
        self._last = time.monotonic()
        if self._table is not None and new:
            self._table.add(self._names or [], sorted(new, key=lambda row: row[0]))

    def frame(self) -> pd.DataFrame:
        """Returns all finished points, and sorts the table if there are all of them."""
        import pandas as pd

        self.keep()
        if self._table is not None and len(self.rows) == self._study.count:
            self._table.finish()
        rows = [self.rows[point] for point in sorted(self.rows)]
        points = [point for point, _, _ in rows]
        columns: dict[str, Any] = {POINT: points}
        for place, name in enumerate(self._study.names):
            columns[name] = [self._study.value(place, point) for point in points]
        for name in self._names or []:
            values = [math.nan if measures is None else measures[name] for _, measures, _ in rows]
            texts = any(isinstance(value, str) for value in values)
            columns[name] = [None if texts and not isinstance(value, str) else value for value in values]
        columns[STATUS] = ["ok" if error is None else "failed" for _, _, error in rows]
        return pd.DataFrame({**columns, ERROR: pd.Series([error for _, _, error in rows], dtype=object)})


