"""Many runs of a packed crowd with different parameters, on the cores of this machine or on a Dask cluster."""

from __future__ import annotations

import itertools
import logging
import math
import os
import queue
import time
import weakref
from asyncio import CancelledError
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Union

import cloudpickle
import dask
import numpy as np
import pandas as pd
from dask.system import CPU_COUNT
from distributed import Client, Future, KilledWorker, LocalCluster, Worker, WorkerPlugin

from .clock import steps_between
from .crowd import Crowd
from .drive import DriveLike, Known, function_identity, identity, known
from .errors import FmuError
from .fmu import Fmu, load
from .instance import Value
from .loaded import Source
from .run import Run
from .scratch import scratch
from .progress import Progress, ProgressLine
from .results import FAILED, POINT, RESERVED, STATUS, Directory, Intervals, Points, Result, SweepError, joined, part_of, unicode

#: A function of a run that returns its measures: names and numbers (or texts).
Measure = Callable[[Run], Mapping[str, Any]]
#: A grid (name → values, all combinations, the last name varies fastest) or a table (a row for each point).
Grid = Union[Mapping[str, Iterable[Value]], pd.DataFrame]


#: [s] Duration of a task for a worker, which chooses its number of points: Dask needs about 10 ms for each task.
TASK = 0.5


#: The message of a point whose worker process ends several times, for example by os._exit, a signal or lack of memory.
DIED = "the worker process ended several times while it simulated this point"


@dataclass(frozen=True)
class _Job:
    """Data shared by all points of a sweep."""

    key: str
    fmu: str  # SHA-256
    names: tuple[str, ...]
    work: bytes  # drive and measure, pickled by value
    until: float
    step: float


class _FmuOnWorker(WorkerPlugin):
    """Sends the FMU's bytes to every worker once, also to those that join later. No shared file system is needed."""

    def __init__(self, data: bytes, sha256: str) -> None:
        self.data = data
        self.name = f"lemons-fmu-{sha256}"

    def setup(self, worker: Worker) -> None:
        fmu = load(self.data)
        _fmus[fmu.sha256] = fmu


class _JobOnWorker(WorkerPlugin):
    def __init__(self, job: _Job) -> None:
        self.job = job
        self.name = f"lemons-sweep-{job.key}"

    def setup(self, worker: Worker) -> None:
        _jobs[self.job.key] = self.job, cloudpickle.loads(self.job.work)

    def teardown(self, worker: Worker) -> None:
        _jobs.pop(self.job.key, None)


_fmus: dict[str, Fmu] = {}
_jobs: dict[str, tuple[_Job, tuple[Known[Crowd], Measure]]] = {}
_sent: weakref.WeakKeyDictionary[Client, set[str]] = weakref.WeakKeyDictionary()


def _simulate_points(key: str, points: list[tuple[int, tuple[Value, ...]]]) -> tuple[list[Result], float]:
    """Runs on a worker. Returns results, and the time that they took [s]."""
    start = time.perf_counter()
    results = [_simulate_point(key, point, values) for point, values in points]
    return results, time.perf_counter() - start


def _simulate_point(key: str, point: int, values: tuple[Value, ...]) -> Result:
    job, (drive, measure) = _jobs[key]
    try:
        with Crowd(_fmus[job.fmu], dict(zip(job.names, values))) as crowd:
            run = crowd.run(drive, until=job.until, step=job.step)
        return point, _measured(measure(run), job.names), None
    except FmuError as error:
        return point, {}, _text(str(error))
    except KeyboardInterrupt:
        raise _Interrupted from None
    except BaseException as error:  # a failed point (even by sys.exit) is a row of the table and does not end the sweep
        return point, {}, _told(error)


class _Interrupted(Exception):
    """A measure or a drive raised KeyboardInterrupt, which would end Dask's worker process."""


def _told(error: BaseException) -> str:
    kind = type(error).__name__
    try:
        return _text(f"{kind}: {error}")
    except BaseException as worse:
        return _text(f"{kind}, whose message raises {type(worse).__name__}")


def _text(text: str) -> str:
    """Returns the text without characters that UTF-8 cannot represent."""
    return text.encode(errors="backslashreplace").decode()


def _measured(measures: Mapping[str, Any], parameters: tuple[str, ...]) -> dict[str, float | str]:
    if not hasattr(measures, "items"):
        raise TypeError(f"the measure returned {type(measures).__name__}, not names and numbers")
    out: dict[str, float | str] = {}
    for key, value in measures.items():
        name = str(key)
        if name in parameters or name in RESERVED:
            raise ValueError(f"the measure has the name of another column: {name!r}")
        if not unicode(name) or isinstance(value, str) and not unicode(value):
            raise ValueError(f"the measure {name!r} is not Unicode text: {value!r}")
        out[name] = value if isinstance(value, str) else math.nan if value is None else float(value)
    return out


def sweep(
    fmu: Source | Fmu,
    points: Grid,
    drive: DriveLike[Crowd],
    measure: Measure,
    *,
    until: float,
    step: float | None = None,
    out: str | os.PathLike[str] | None = None,
    client: Client | str | None = None,
    progress: bool | Callable[[Progress], None] = True,
    retry_failed: bool = False,
) -> pd.DataFrame:
    """Simulates every point until a time [s]. Returns a table sorted by point: `point`, the parameters, the measures of each
    run, `status` (`ok` or `failed`) and `error` (the message of a failed point).

    `points` is a grid or a table of parameters by their names in the FMU; `agent[*].Mass` sets the masses of all agents.
    `drive` is as for `Crowd.run`: None is the drive.csv packed with the point's Trial, False is no drive. Nobody walks by a
    decision.toml: the command `lemons sweep` does that. `measure` is a function of a `Run` that returns names and numbers
    (or texts).

    With `out`, results are written to that directory as they come. A sweep that was killed continues from there: finished
    points are not simulated again (failed ones only with `retry_failed`).

    `client` is a Dask client or the address of a scheduler. Without one, all cores of this machine are used by worker
    processes, so a script needs `if __name__ == "__main__":`. `progress` shows the progress on standard error, or is a
    function that gets it.

    Raises:
        FmuError: the FMU cannot be read, or has no variable with such a name.
        TypeError: the drive is not a drive, or the values of a parameter are not a list.
        ValueError: points, drive or times are not valid.
        OSError: the drive's file cannot be read.
        SweepError: the directory belongs to another sweep or cannot be written, or the scheduler is gone.
    """
    fmu = load(fmu)
    table = Points.of(points)
    for name in table.names:
        fmu.expand(name)
    drive = known(drive, fmu.ids)
    trials = _trials(fmu, table)
    if drive is None:
        for trial in trials:
            fmu.drive(trial)  # reports an invalid file before any point runs
    if step is None:
        step, *others = sorted({fmu.step_of(trial) for trial in trials})
        if others:
            raise ValueError(f"the Trials have steps of {step} s and {others[0]} s: give one for all (step)")
    step = float(step)
    steps_between(0.0, until, step)
    job = _Job(os.urandom(8).hex(), fmu.sha256, table.names, cloudpickle.dumps((drive, measure)), float(until), step)
    report = _report(progress)

    directory = None if out is None else Directory(out, _manifest(fmu, table, drive, measure, job), table)
    try:
        kept = [] if directory is None else [directory.read()]
        threads: int | None
        finished = np.zeros(table.count, dtype=bool)
        failed = 0
        for part in kept:
            bad = part[STATUS].to_numpy() == FAILED
            finished[part[POINT].to_numpy()[~bad if retry_failed else slice(None)]] = True
            failed = 0 if retry_failed else int(bad.sum())
        before = int(finished.sum())
        open_points = np.flatnonzero(~finished)
        start = time.monotonic()

        def tell() -> None:
            report(Progress(before + done, failed, table.count, time.monotonic() - start, before, threads))

        done, threads = 0, None
        tell()
        if len(open_points):
            pending: list[Result] = []
            intervals = Intervals()

            def write() -> None:
                if pending:
                    try:
                        if directory is None:
                            kept.append(part_of(table, pending))
                        else:
                            directory.add(pending)
                    except SweepError:
                        pending.clear()  # try to write them only once
                        raise
                    pending.clear()
                intervals.done()

            with client_of(client) as cluster:
                send_fmu(cluster, fmu)
                cluster.register_plugin(_JobOnWorker(job))
                under_way = _Run(cluster, job, table, open_points.tolist())
                try:
                    for some in under_way.results(lambda: intervals.left() if pending else None):
                        pending += some
                        done += len(some)
                        failed += sum(error is not None for *_, error in some)
                        if not intervals.left():
                            write()
                        if some or under_way.threads != threads:
                            threads = under_way.threads
                            tell()
                finally:
                    write()
                    _clean_up(cluster, job, [future for future, _ in under_way.under_way.values()])
        whole = joined(table, kept) if directory is None else directory.read()
        if directory is not None and directory.parts():
            directory.finish(whole)
        frame: pd.DataFrame = whole.to_pandas()
        return frame
    finally:
        if directory is not None:
            directory.close()


def _trials(fmu: Fmu, points: Points) -> list[str]:
    """Returns the packed Trials that points choose. Points with another name fail later."""
    if "Trial" not in points.names:
        return [fmu.trial]
    chosen = points.columns[points.names.index("Trial")]
    return [trial for trial in sorted(set(map(str, chosen))) if fmu.has(trial)] or [fmu.trial]


def _manifest(fmu: Fmu, points: Points, drive: Known[Crowd], measure: Measure, job: _Job) -> dict[str, Any]:
    """Returns the data that must be equal to continue a sweep; python/README.md explains them."""
    packed = drive is None and "Trial" in points.names  # each Trial has its own
    if drive is None and not packed:
        drive = fmu.drive(fmu.trial)
    return {
        "fmu": {"model": fmu.model_name, "guid": fmu.guid, "sha256": fmu.sha256},
        "points": {"parameters": list(points.names), "count": points.count, "sha256": points.sha256()},
        "drive": {"kind": "packed"} if packed else identity(drive),
        "measure": function_identity(measure),
        "until": job.until,
        "step": job.step,
    }


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
        with local_cluster() as cluster, Client(cluster) as local:
            yield local


def local_cluster(workers: int | None = None, *, threads: int = 1, processes: bool = True) -> LocalCluster:
    """Starts workers on this machine, by default one for each core."""
    own = str(scratch())
    # Nobody looks at the profile that workers take of themselves a hundred times a second, nor at the delays of the event
    # loops, measured fifty times a second. Without them: 4 % of a core less in this process, 2 % in each worker.
    quiet = {"distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "500ms"}
    with dask.config.set({**quiet, "temporary-directory": own}):
        return LocalCluster(
            n_workers=workers or CPU_COUNT,
            threads_per_worker=threads,
            processes=processes,
            dashboard_address="127.0.0.1:0",  # any free port
            local_directory=own,
            memory_limit=0,
            silence_logs=logging.CRITICAL,  # a heartbeat interrupted at the end would be an ERROR
        )


def send_fmu(client: Client, fmu: Fmu) -> None:
    """Sends an FMU to all workers, if this client has not done so before."""
    sent = _sent.setdefault(client, set())
    if fmu.sha256 not in sent:
        client.register_plugin(_FmuOnWorker(fmu.data, fmu.sha256))
        sent.add(fmu.sha256)


class _Run:
    """Gives the points of a job to the workers and collects their results."""

    def __init__(self, client: Client, job: _Job, points: Points, open_points: list[int]) -> None:
        self.client = client
        self.job = job
        self.points = points
        self.left = deque(open_points)
        #: Points whose worker process ended several times. Dask blames all tasks of that worker. So these points are simulated
        #: at the end, one at a time, to find the one that causes it.
        self.suspects: deque[int] = deque()
        self.alone = False
        self.under_way: dict[str, tuple[Future[Any], list[int]]] = {}
        self.arrived: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self.tasks = itertools.count()
        self.threads, self.looked = 0, -math.inf
        self.each = math.inf  # duration of a point [s]

    def results(self, patience: Callable[[], float | None]) -> Iterator[list[Result]]:
        """Yields results as they come; an empty list when the time `patience()` [s] is over."""
        self.fill()
        while self.under_way:
            batch: list[Future[Any]] = []
            try:
                batch.append(self.arrived.get(timeout=min(2.0, patience() or 2.0)))
                while True:
                    batch.append(self.arrived.get_nowait())
            except queue.Empty:
                pass
            yield self.collect(batch)
            self.fill()

    def fill(self) -> None:
        """Submits just enough tasks to keep all workers busy."""
        if time.monotonic() - self.looked > 2.0:  # workers come and go
            self.threads, self.looked = sum(self.client.nthreads().values()), time.monotonic()
        threads = max(1, self.threads)
        while self.left and len(self.under_way) < 2 * threads + 1:
            # Near the end tasks become smaller, so that no worker is idle.
            count = min(TASK / self.each, len(self.left) / (2 * threads))
            self.submit([self.left.popleft() for _ in range(max(1, int(count)))])
        if self.suspects and not self.under_way:
            self.alone = True
            self.submit([self.suspects.popleft()])

    def submit(self, some: list[int]) -> None:
        key = f"lemons-{self.job.key}-{next(self.tasks)}"
        work = [(point, self.points.values(point)) for point in some]
        future = self.client.submit(_simulate_points, self.job.key, work, key=key, pure=False)
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
                    results.append((some[0], {}, DIED))
            except _Interrupted:
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


def _clean_up(client: Client, job: _Job, futures: list[Future[Any]]) -> None:
    try:
        if client.status == "running":
            if futures:
                client.cancel(futures)
            client.unregister_worker_plugin(f"lemons-sweep-{job.key}")
    except (OSError, TimeoutError, ValueError):
        pass  # the error that happened before is reported


def _report(progress: bool | Callable[[Progress], None]) -> Callable[[Progress], None]:
    if not isinstance(progress, bool):
        return progress
    return ProgressLine() if progress else lambda _: None
