"""Many runs with different parameters, on the cores of this machine or on a Dask cluster."""

from __future__ import annotations

import itertools
import json
import logging
import math
import os
import queue
import time
from asyncio import CancelledError
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from contextlib import contextmanager
from multiprocessing import spawn
from typing import Any, Union

import cloudpickle
import dask
import pandas as pd
from dask.system import CPU_COUNT
from distributed import Client, Future, KilledWorker, LocalCluster, SpecCluster, Status

from . import _native
from ._native import SweepError as SweepError
from .crowd import Algorithm, Crowd, Plan, Source, Until, Value, model_of
from .drive import DriveLike, function_identity, identity, known
from .progress import Progress, ProgressLine
from .work import ERROR, POINT, RESERVED, STATUS, Interrupted, Job, JobOnWorker, Measure, Result, Stop, Subject, simulate_points

#: A grid (name → values, all combinations, the last name varies fastest) or a table (a row for each point).
Grid = Union[Mapping[str, Iterable[Value]], pd.DataFrame]

#: A larger number of points is taken for a mistake, as by `lemons sweep`.
MOST_POINTS = 10_000_000


#: [s] Duration of a task for a worker, which chooses its number of points: Dask needs about 10 ms for each task.
TASK = 0.5


#: [s] A sweep that can start its workers itself ends when it has had none for so long.
DESERTED = 600.0


#: The message of a point whose worker process ends several times, for example by os._exit, a signal or lack of memory.
DIED = "the worker process ended several times while it simulated this point"


def sweep(
    what: Source,
    points: Grid,
    drive: DriveLike[Crowd],
    measure: Measure,
    *,
    until: Until,
    step: float | None = None,
    plan: Plan = None,
    algorithm: Algorithm = "jacobi",
    stop: Stop | None = None,
    out: str | os.PathLike[str] | None = None,
    client: Client | str | None = None,
    progress: bool | Callable[[Progress], None] = True,
    retry_failed: bool = False,
) -> pd.DataFrame:
    """Simulates every point until a time [s]. Returns a table sorted by point: `point`, the parameters, the measures of each
    run, `status` (`ok` or `failed`) and `error` (the message of a failed point).

    `what` is a Trial or the FMU of a crowd, and people walk as in a `Crowd` (`plan`, `algorithm`). The path of `what` or `plan`
    may contain names of parameters in braces: `"room_{width}_{seed}"`. Such a parameter only chooses what is simulated.

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
        CommandError: a Trial or a plan has errors.
        SimulationError: there is no variable with such a name, or nobody can leave.
        TypeError: the drive is not a drive, or the values of a parameter are not a list.
        ValueError: points, drive or times are not valid.
        OSError: the drive's file cannot be read.
        SweepError: the table is that of another sweep or cannot be written, or the scheduler is gone.
    """
    study = _Study(points, what, plan, algorithm, drive, until, step)
    work = cloudpickle.dumps((drive if callable(drive) else None, measure, stop))
    subject = study.subject(0) if study.count == 1 else None
    job = Job(os.urandom(8).hex(), subject, tuple(study.native.names), tuple(study.native.set()), algorithm, work, until)
    asked = {**study.identity, "measure": function_identity(measure), "until": until if until == "left" else float(until)}
    if stop is not None:
        asked["stop"] = function_identity(stop)
    results = _Results(study.native, out, {"program": "lemons_fmu", **asked}, retry_failed)
    report = progress if callable(progress) else ProgressLine() if progress else lambda _: None
    try:
        return _sweep(study, job, results, client, report)
    finally:
        results.keep()


def _columns(points: Grid) -> list[tuple[str, list[Any]]]:
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
    return columns


class _Study:
    """What points simulate: one Trial or FMU, or those that parameters choose. All are read and checked at the beginning, and
    those of several again shortly before they are simulated, so that not all of them are in memory."""

    def __init__(
        self,
        points: Grid,
        what: Source,
        plan: Plan,
        algorithm: Algorithm,
        drive: DriveLike[Crowd],
        until: Until,
        step: float | None,
    ) -> None:
        if isinstance(until, str) and until != "left":
            raise ValueError(f"until={until!r}: must be a time [s], or 'left'")
        path = None if plan is None or plan is False else os.fspath(plan)
        grid = not isinstance(points, pd.DataFrame)
        self.native = _native.Study(_columns(points), grid, os.fspath(what), path, plan is not False)
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
        path, plan, walk = self._models[place]
        model = model_of(path, plan if walk else False)
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


class _Results:
    """Finished points: in memory, and in a table if that is asked for."""

    def __init__(
        self, study: _native.Study, out: str | os.PathLike[str] | None, asked: Mapping[str, Any], retry_failed: bool
    ) -> None:
        self._study = study
        if out is not None:
            os.makedirs(os.path.dirname(os.path.abspath(out)), exist_ok=True)
        self._table = None if out is None else _native.Table(os.fspath(out), json.dumps(asked), study)
        self._names = None if self._table is None else self._table.measures
        self._rows: dict[int, Result] = {}
        #: Results that are not in the table yet.
        self._new: list[Result] = []
        self._begin = self._last = time.monotonic()
        for row in [] if self._table is None else self._table.rows():
            self._rows[row[0]] = row
        #: Whether a point has measures.
        self._named = any(measures is not None for _, measures, _ in self._rows.values())
        #: Points that are not simulated again.
        self.finished = {point for point, _, error in self._rows.values() if error is None or not retry_failed}

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
            self._rows[point] = added[-1]
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
        self.keep()
        if self._table is not None and len(self._rows) == self._study.count:
            self._table.finish()
        rows = [self._rows[point] for point in sorted(self._rows)]
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


def _sweep(
    study: _Study, job: Job, results: _Results, client: Client | str | None, report: Callable[[Progress], None]
) -> pd.DataFrame:
    count = study.native.count
    left = [point for point in range(count) if point not in results.finished]
    before, start = count - len(left), time.monotonic()
    done, failed, threads = before, sum(results._rows[point][2] is not None for point in results.finished), None

    def tell() -> None:
        report(Progress(done, failed, count, time.monotonic() - start, before, threads))

    tell()
    if not left:
        return results.frame()
    # By default a cluster gives up a worker that is not back after 15 s. A busy machine may need longer to start one, which
    # then meets another of its name.
    with dask.config.set({"distributed.deploy.lost-worker-timeout": DESERTED}), client_of(client) as cluster:
        cluster.register_plugin(JobOnWorker(job))
        under_way = _Run(cluster, job, study, left)
        try:
            for some in under_way.results():
                some = results.add(some)
                done += len(some)
                failed += sum(error is not None for *_, error in some)
                if some or under_way.threads != threads:
                    threads = under_way.threads
                    tell()
        finally:
            results.keep()
            _clean_up(cluster, job, [future for future, _ in under_way.under_way.values()])
    return results.frame()


@contextmanager
def client_of(client: Client | str | None) -> Iterator[Client]:
    """Gives a client for an address; for None one with a worker process for each core of this machine, closed at the end."""
    if isinstance(client, Client):
        if client.asynchronous:
            raise ValueError("an asynchronous client cannot be used here")
        yield client
    elif client is not None:
        with Client(client, timeout="20s") as remote:
            yield remote
    else:
        with _without_main(), local_cluster() as cluster, Client(cluster) as local:
            yield local


@contextmanager
def _without_main() -> Iterator[None]:
    """Keeps processes that are started meanwhile from importing the script, which would start a sweep in each. Functions of a
    script are sent by their content."""
    prepared = spawn.get_preparation_data
    spawn.get_preparation_data = lambda name: {
        key: value for key, value in prepared(name).items() if not key.startswith("init_main")
    }
    try:
        yield
    finally:
        spawn.get_preparation_data = prepared


def local_cluster(workers: int | None = None, *, threads: int = 1, processes: bool = True) -> LocalCluster:
    """Starts workers on this machine, by default one for each core."""
    # Nobody looks at the profile that workers take of themselves a hundred times a second, nor at the delays of the event
    # loops, measured fifty times a second. Without them: 4 % of a core less in this process, 2 % in each worker.
    quiet = {"distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "500ms"}
    with dask.config.set(quiet):
        return LocalCluster(
            n_workers=workers or CPU_COUNT,
            threads_per_worker=threads,
            processes=processes,
            dashboard_address="127.0.0.1:0",  # any free port
            memory_limit=0,
            silence_logs=logging.CRITICAL,  # a heartbeat interrupted at the end would be an ERROR
        )


class _Run:
    """Gives the points of a job to the workers and collects their results."""

    def __init__(self, client: Client, job: Job, study: _Study, open_points: list[int]) -> None:
        self.client = client
        self.job = job
        self.study = study
        # A task has points of one model.
        self.left = deque(sorted(open_points, key=study.native.place))
        #: Points whose worker process ended several times. Dask blames all tasks of that worker. So these points are simulated
        #: at the end, one at a time, to find the one that causes it.
        self.suspects: deque[int] = deque()
        self.alone = False
        self.under_way: dict[str, tuple[Future[Any], list[int]]] = {}
        self.arrived: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self.tasks = itertools.count()
        self.threads, self.looked = 0, -math.inf
        #: [s] Since when there has been no worker.
        self.deserted: float | None = None
        self.each = math.inf  # duration of a point [s]

    def results(self) -> Iterator[list[Result]]:
        """Yields results as they come; an empty list each second without."""
        self.fill()
        while self.under_way:
            batch: list[Future[Any]] = []
            try:
                batch.append(self.arrived.get(timeout=1.0))
                while True:
                    batch.append(self.arrived.get_nowait())
            except queue.Empty:
                pass
            yield self.collect(batch)
            self.fill()

    def fill(self) -> None:
        """Submits just enough tasks to keep all workers busy."""
        self.look()
        threads = max(1, self.threads)
        while self.left and len(self.under_way) < 2 * threads + 1:
            # Near the end tasks become smaller, so that no worker is idle.
            count = min(TASK / self.each, len(self.left) / (2 * threads))
            some = [self.left.popleft()]
            while self.left and len(some) < int(count) and self.study.native.place(self.left[0]) == self.study.native.place(some[0]):
                some.append(self.left.popleft())
            self.submit(some)
        if self.suspects and not self.under_way:
            self.alone = True
            self.submit([self.suspects.popleft()])

    def look(self) -> None:
        """Counts the threads of the workers, which come and go. If there are none, starts those of this machine again that Dask
        does not: whose start failed, for example.

        Raises:
            SweepError: nobody has worked for long.
        """
        now = time.monotonic()
        if now - self.looked < 2.0:
            return
        self.threads, self.looked = sum(self.client.nthreads().values()), now
        if self.threads:
            self.deserted = None
            return
        if self.deserted is None:
            self.deserted = now
        cluster = self.client.cluster
        if not isinstance(cluster, SpecCluster):
            return  # who started that cluster adds workers
        if now - self.deserted > DESERTED:
            points = sorted([*self.left, *self.suspects, *(point for _, some in self.under_way.values() for point in some)])
            first = ", ".join(map(str, points[:10])) + (", …" if len(points) > 10 else "")
            raise SweepError(f"there has been no worker for {DESERTED:g} s; {len(points)} points are open: {first}")
        for name, worker in list(cluster.workers.items()):
            if worker.status in (Status.failed, Status.closed):
                cluster.workers.pop(name, None)
        cluster.scale(len(cluster.worker_spec))  # opens those that are missing

    def submit(self, some: list[int]) -> None:
        key = f"lemons-{self.job.key}-{next(self.tasks)}"
        native = self.study.native
        work = [(point, [native.value(place, point) for place in range(len(native.names))]) for point in some]
        subject = self.study.again(some[0])
        future = self.client.submit(simulate_points, self.job.key, subject, work, key=key, pure=False)
        self.under_way[key] = future, some
        future.add_done_callback(self.arrived.put)

    def collect(self, batch: list[Future[Any]]) -> list[Result]:
        results: list[Result] = []
        for future in batch:
            key = str(future.key)
            if future.status in ("pending", "lost"):  # its worker ended before it returned the result: Dask repeats the task
                future.add_done_callback(self.arrived.put)
                continue
            some = self.under_way[key][1]
            try:
                got, seconds = future.result()
            except KilledWorker:
                if not self.alone:
                    self.suspects += some
                else:
                    results.append((some[0], None, DIED))
            except Interrupted:
                raise KeyboardInterrupt from None
            except CancelledError:
                raise SweepError("the scheduler is gone, or has cancelled the sweep; finished points are kept") from None
            except Exception as error:  # not an error of a point: those are rows
                raise SweepError(f"the workers cannot simulate: {type(error).__name__}: {error}") from error
            else:
                results += got
                each = max(seconds / len(got), 1e-6)
                self.each = each if math.isinf(self.each) else 0.8 * self.each + 0.2 * each
            del self.under_way[key]
        return results


def _clean_up(client: Client, job: Job, futures: list[Future[Any]]) -> None:
    try:
        if client.status == "running":
            if futures:
                client.cancel(futures)
            client.unregister_worker_plugin(f"lemons-sweep-{job.key}")
    except (OSError, TimeoutError, ValueError):
        pass  # the error that happened before is reported
