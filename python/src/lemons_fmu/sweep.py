"""Many runs of a packed crowd with other parameters, on the cores of this machine or on a Dask cluster."""

from __future__ import annotations

import math
import os
import queue
import sys
import time
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Union

import cloudpickle
import numpy as np
import pandas as pd
from dask.system import CPU_COUNT
from distributed import Client, Future, KilledWorker, LocalCluster, Worker, WorkerPlugin

from .crowd import Crowd, Run
from .drive import DriveLike, function_identity, identity
from .fmu import Fmu, FmuError, Source, Value, load
from .results import FAILED, POINT, RESERVED, STATUS, Directory, Intervals, Points, Result, SweepError, joined, part_of

#: What is to be known of a run: names and numbers (or texts).
Measure = Callable[[Run], Mapping[str, Any]]
#: A grid (name → values, all combinations, the last name varies fastest) or a table (a row for each point).
Grid = Union[Mapping[str, Iterable[Value]], pd.DataFrame]


@dataclass(frozen=True)
class Progress:
    """How far a sweep is."""

    done: int
    failed: int
    total: int
    #: [s] since it was started.
    seconds: float
    #: Of those done, how many were so when it was started.
    before: int


@dataclass(frozen=True)
class _Job:
    """What all points of a sweep have in common."""

    key: str
    fmu: str  # SHA-256
    names: tuple[str, ...]
    work: bytes  # drive and measure, pickled by value
    until: float
    step: float


class _FmuOnWorker(WorkerPlugin):
    """Brings the FMU's bytes to every worker once, to those that come later too: no shared file system is needed."""

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
_jobs: dict[str, tuple[_Job, tuple[DriveLike, Measure]]] = {}
_sent: weakref.WeakKeyDictionary[Client, set[str]] = weakref.WeakKeyDictionary()


def _simulate_point(key: str, point: int, values: tuple[Value, ...]) -> Result:
    """On a worker."""
    job, (drive, measure) = _jobs[key]
    try:
        with Crowd(_fmus[job.fmu], dict(zip(job.names, values))) as crowd:
            run = crowd.run(drive, until=job.until, step=job.step)
        return point, _measured(measure(run), job.names), None
    except FmuError as error:
        return point, {}, str(error)
    except Exception as error:  # a point's failure is a row of the table, not the end
        return point, {}, f"{type(error).__name__}: {error}"


def _measured(measures: Mapping[str, Any], parameters: tuple[str, ...]) -> dict[str, float | str]:
    out: dict[str, float | str] = {}
    for name, value in measures.items():
        if name in parameters or name in RESERVED:
            raise ValueError(f"the measure has the name of another column: {name!r}")
        out[str(name)] = value if isinstance(value, str) else math.nan if value is None else float(value)
    return out


def sweep(
    fmu: Source | Fmu,
    points: Grid,
    drive: DriveLike,
    measure: Measure,
    *,
    until: float,
    step: float | None = None,
    out: str | os.PathLike[str] | None = None,
    client: Client | str | None = None,
    progress: bool | Callable[[Progress], None] = True,
    retry_failed: bool = False,
) -> pd.DataFrame:
    """Simulates every point until a time [s] and returns a table: `point`, the parameters, what `measure` gave of each
    run, `status` (`ok` or `failed`) and `error` (the message of a failed one), sorted by point.

    `points` is a grid or a table of parameters by their names in the FMU; `agent[*].Mass` sets everybody's. `drive` is
    as for `Crowd.run`. `measure` gets a `Run` and gives names and numbers (or texts).

    With `out`, results are written to that directory as they come, and a sweep that was killed goes on from there: the
    points that are finished are not simulated again (those that failed only with `retry_failed`).

    `client` is a Dask client or the address of a scheduler; without one, all cores of this machine are used. There
    workers are processes, so a script needs `if __name__ == "__main__":`. `progress` shows how far it is on standard
    error, or calls a function.

    Raises:
        FmuError: the FMU cannot be read, or has no variable of such a name.
        ValueError: points, drive or times are of no use.
        SweepError: the directory is of another sweep, or the scheduler is gone.
    """
    fmu = load(fmu)
    table = Points.of(points)
    for name in table.names:
        fmu.expand(name)
    step = fmu.step if step is None else float(step)
    if not (math.isfinite(until) and until > 0 and math.isfinite(step) and step > 0):
        raise ValueError(f"nothing to simulate: until {until} s in steps of {step} s")
    job = _Job(os.urandom(8).hex(), fmu.sha256, table.names, cloudpickle.dumps((drive, measure)), float(until), step)
    report = _report(progress)

    directory = None if out is None else Directory(out, _manifest(fmu, table, drive, measure, job), table)
    try:
        kept = [] if directory is None else [directory.read()]
        finished = np.zeros(table.count, dtype=bool)
        failed = 0
        for part in kept:
            bad = part[STATUS].to_numpy() == FAILED
            finished[part[POINT].to_numpy()[~bad if retry_failed else slice(None)]] = True
            failed = 0 if retry_failed else int(bad.sum())
        before = int(finished.sum())
        open_points = np.flatnonzero(~finished)
        start = time.monotonic()

        def tell(done: int) -> None:
            report(Progress(before + done, failed, table.count, time.monotonic() - start, before))

        tell(0)
        done = 0
        if len(open_points):
            pending: list[Result] = []
            intervals = Intervals()

            def write() -> None:
                if pending:
                    if directory is None:
                        kept.append(part_of(table, pending))
                    else:
                        directory.add(pending)
                    pending.clear()
                intervals.done()

            with client_of(client) as dask:
                try:
                    results = _run(dask, fmu, job, table, open_points, lambda: intervals.left() if pending else None)
                    for some in results:
                        pending += some
                        done += len(some)
                        failed += sum(error is not None for *_, error in some)
                        if not intervals.left():
                            write()
                        if some:
                            tell(done)
                finally:
                    write()
        whole = joined(table, kept) if directory is None else directory.read()
        if directory is not None and directory.parts():
            directory.finish(whole)
        frame: pd.DataFrame = whole.to_pandas()
        return frame
    finally:
        if directory is not None:
            directory.close()


def _manifest(fmu: Fmu, points: Points, drive: DriveLike, measure: Measure, job: _Job) -> dict[str, Any]:
    """What must be the same for a sweep to go on; python/README.md explains it."""
    return {
        "fmu": {"model": fmu.model_name, "guid": fmu.guid, "sha256": fmu.sha256},
        "points": {"parameters": list(points.names), "count": points.count, "sha256": points.sha256()},
        "drive": identity(drive),
        "measure": function_identity(measure),
        "until": job.until,
        "step": job.step,
    }


@contextmanager
def client_of(client: Client | str | None) -> Iterator[Client]:
    """A client for an address; for None one with a worker process for each core of this machine, closed at the end."""
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


def local_cluster(workers: int | None = None, *, processes: bool = True) -> LocalCluster:
    """Workers of one thread each on this machine, by default as many as it has cores."""
    return LocalCluster(
        n_workers=workers or CPU_COUNT, threads_per_worker=1, processes=processes, dashboard_address=None, memory_limit=0
    )


def send_fmu(client: Client, fmu: Fmu) -> None:
    """Brings an FMU to all workers, if this client has not done so before."""
    sent = _sent.setdefault(client, set())
    if fmu.sha256 not in sent:
        client.register_plugin(_FmuOnWorker(fmu.data, fmu.sha256))
        sent.add(fmu.sha256)


def _run(
    client: Client,
    fmu: Fmu,
    job: _Job,
    points: Points,
    open_points: Any,
    patience: Callable[[], float | None],
) -> Iterator[list[Result]]:
    """Results as they come; nothing when patience is at its end. No more points are under way than keep all workers busy."""
    send_fmu(client, fmu)
    client.register_plugin(_JobOnWorker(job))
    arrived: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
    under_way: dict[str, tuple[Future[Any], int]] = {}
    left = iter(open_points.tolist())
    window, looked = 0, -math.inf

    def fill() -> None:
        nonlocal window, looked
        if time.monotonic() - looked > 2.0:  # workers come and go
            window, looked = 8 + 3 * sum(client.nthreads().values()), time.monotonic()
        while len(under_way) < window:
            point = next(left, None)
            if point is None:
                return
            key = f"lemons-{job.key}-{point}"
            future = client.submit(_simulate_point, job.key, point, points.values(point), key=key, pure=False)
            under_way[key] = future, point
            future.add_done_callback(arrived.put)

    try:
        fill()
        while under_way:
            batch: list[Future[Any]] = []
            try:
                # Not longer than some seconds: a new worker is to get its share.
                batch.append(arrived.get(timeout=min(2.0, patience() or 2.0)))
                while True:
                    batch.append(arrived.get_nowait())
            except queue.Empty:
                pass
            yield _collect(client, batch, under_way)
            fill()
    finally:
        _clean_up(client, job, [future for future, _ in under_way.values()])


def _collect(client: Client, batch: list[Future[Any]], under_way: dict[str, tuple[Future[Any], int]]) -> list[Result]:
    results: list[Result] = []
    good = [future for future in batch if future.status == "finished"]
    for future in batch:
        if future.status == "error":
            error = future.exception()
            point = under_way[str(future.key)][1]
            if isinstance(error, KilledWorker):
                results.append((point, {}, "the worker died again and again while it simulated this point"))
            else:
                results.append((point, {}, f"{type(error).__name__}: {error}"))
        elif future.status != "finished":
            raise SweepError("the scheduler is gone, or has cancelled the sweep; what was finished is kept")
    results += client.gather(good)
    for future in batch:
        del under_way[str(future.key)]
    return results


def _clean_up(client: Client, job: _Job, futures: list[Future[Any]]) -> None:
    try:
        if client.status == "running":
            if futures:
                client.cancel(futures)
            client.unregister_worker_plugin(f"lemons-sweep-{job.key}")
    except (OSError, TimeoutError, ValueError):
        pass  # what went wrong before this is what is told


def _report(progress: bool | Callable[[Progress], None]) -> Callable[[Progress], None]:
    if not isinstance(progress, bool):
        return progress
    return _Line() if progress else lambda _: None


class _Line:
    """A line on standard error, which a terminal shows again and again; elsewhere one every half minute."""

    def __init__(self) -> None:
        self.terminal = sys.stderr.isatty()
        self.last = -math.inf

    def __call__(self, at: Progress) -> None:
        end = at.done == at.total
        if at.seconds - self.last < (0.2 if self.terminal else 30.0) and not end:
            return
        self.last = at.seconds
        new = at.done - at.before
        rest = f"{(at.total - at.done) * at.seconds / new:.0f} s left" if new and not end else f"{at.seconds:.0f} s"
        line = f"{at.done} of {at.total} points, {at.failed} failed, {rest}"
        print(f"\r{line:<60}" if self.terminal else line, end="" if self.terminal and not end else "\n", file=sys.stderr)
        sys.stderr.flush()


