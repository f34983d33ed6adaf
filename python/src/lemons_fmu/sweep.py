"""Many runs with different parameters, on the cores of this machine or on a Dask cluster."""

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
from typing import Any, Union

import cloudpickle
import dask
import numpy as np
import pandas as pd
from dask.system import CPU_COUNT
from distributed import Client, Future, KilledWorker, LocalCluster, SpecCluster, Status

from .crowd import Crowd, Until
from .drive import DriveLike, function_identity
from .fmu import Fmu
from .instance import Value
from .loaded import Loaded, Source
from .made import Plan
from .model import Algorithm
from .progress import Progress, ProgressLine
from .results import FAILED, POINT, STATUS, Directory, Intervals, Points, Result, SweepError, joined, part_of
from .scratch import scratch
from .study import Given, Packing, Study, study_of
from .work import FmuOnWorker, Interrupted, Job, JobOnWorker, Measure, Stop, simulate_points

#: A grid (name → values, all combinations, the last name varies fastest) or a table (a row for each point).
Grid = Union[Mapping[str, Iterable[Value]], pd.DataFrame]


#: [s] Duration of a task for a worker, which chooses its number of points: Dask needs about 10 ms for each task.
TASK = 0.5


#: [s] A sweep that can start its workers itself ends when it has had none for so long.
DESERTED = 600.0


#: The message of a point whose worker process ends several times, for example by os._exit, a signal or lack of memory.
DIED = "the worker process ended several times while it simulated this point"


_sent: weakref.WeakKeyDictionary[Client, set[str]] = weakref.WeakKeyDictionary()


def sweep(
    what: Source | Fmu,
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

    `what` is a Trial or a packed crowd, and people walk as in a `Crowd` (`plan`, `algorithm`). The path of `what` or `plan` may
    contain names of parameters in braces: `"room_{width}_{seed}"`. Such a parameter only chooses what is simulated.

    `points` is a grid or a table of parameters by their names in the FMU (`agent[*].Mass` sets the masses of all agents,
    `decision.agent[3].DesiredSpeed` a parameter of Decision). `drive` is as for `Crowd.run`: None is the drive.csv packed with
    the point's Trial, False is no drive; people who walk have none. `measure` is a function of a `Run` that returns names and
    numbers (or texts); None is a number that is not known. `Run.measure` gives it what `lemons measure` computes.

    `until="left"` and `stop` end points as they end `Crowd.run`. The table then has the measure `ended` [s]: when that was; not
    a number where it never was.

    With `out`, results are written to that directory as they come. A sweep that was killed continues from there: finished
    points are not simulated again (failed ones only with `retry_failed`).

    `client` is a Dask client or the address of a scheduler. Without one, all cores of this machine are used by worker
    processes, so a script needs `if __name__ == "__main__":`. `progress` shows the progress on standard error, or is a
    function that gets it.

    Raises:
        CommandError: the command `lemons` refuses a Trial or a plan, or is missing.
        FmuError: an FMU cannot be read or has no variable with such a name, two do not fit together, or nobody can leave.
        TypeError: the drive is not a drive, or the values of a parameter are not a list.
        ValueError: points, drive or times are not valid, or there is a drive for people who walk.
        OSError: the drive's file cannot be read.
        SweepError: the directory belongs to another sweep or cannot be written, or the scheduler is gone.
    """
    table = Points.of(points)
    study = study_of(Given(what, plan, algorithm, drive, until, step), table)
    work = cloudpickle.dumps((drive if callable(drive) else None, measure, stop))
    job = Job(os.urandom(8).hex(), table.names, study.set, algorithm, work, until if until == "left" else float(until))
    manifest = {**study.identity, **_asked(table, measure, stop, job)}
    return _sweep(study, table, job, manifest, out, client, _report(progress), retry_failed)


def _sweep(
    study: Study,
    table: Points,
    job: Job,
    manifest: Mapping[str, Any],
    out: str | os.PathLike[str] | None,
    client: Client | str | None,
    report: Callable[[Progress], None],
    retry_failed: bool,
) -> pd.DataFrame:
    directory = None if out is None else Directory(out, manifest, table)
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

            # By default a cluster gives up a worker that is not back after 15 s. A busy machine may need longer to start one,
            # which then meets another of its name.
            patient = dask.config.set({"distributed.deploy.lost-worker-timeout": DESERTED})
            with patient, client_of(client) as cluster:
                for fmu in study.fmus:
                    send_fmu(cluster, fmu)
                cluster.register_plugin(JobOnWorker(job))
                under_way = _Run(cluster, job, table, study, open_points.tolist())
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
                    under_way.packing.close()
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


def _asked(points: Points, measure: Measure, stop: Stop | None, job: Job) -> dict[str, Any]:
    """Returns the data that must be equal to continue a sweep, besides what is simulated; python/README.md explains them."""
    asked = {
        "points": {"parameters": list(points.names), "count": points.count, "sha256": points.sha256()},
        "measure": function_identity(measure),
        "until": job.until,
    }
    return asked if stop is None else {**asked, "stop": function_identity(stop)}


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


def send_fmu(client: Client, fmu: Loaded) -> None:
    """Sends an FMU to all workers, if this client has not done so before."""
    sent = _sent.setdefault(client, set())
    if fmu.sha256 not in sent:
        client.register_plugin(FmuOnWorker(fmu))
        sent.add(fmu.sha256)


class _Run:
    """Gives the points of a job to the workers and collects their results."""

    def __init__(self, client: Client, job: Job, points: Points, study: Study, open_points: list[int]) -> None:
        self.client = client
        self.job = job
        self.points = points
        self.study = study
        self.packing = Packing(study)
        # A task has points of one subject.
        self.left = deque(sorted(open_points, key=study.place))
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
        self.look()
        threads = max(1, self.threads)
        while self.left and len(self.under_way) < 2 * threads + 1:
            # Near the end tasks become smaller, so that no worker is idle.
            count = min(TASK / self.each, len(self.left) / (2 * threads))
            some = [self.left.popleft()]
            while self.left and len(some) < int(count) and self.study.place(self.left[0]) == self.study.place(some[0]):
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
        work = [(point, self.points.values(point)) for point in some]
        subject = self.packing.subject(some[0], self.left)
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
                    results.append((some[0], {}, DIED))
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


def _report(progress: bool | Callable[[Progress], None]) -> Callable[[Progress], None]:
    if not isinstance(progress, bool):
        return progress
    return ProgressLine() if progress else lambda _: None
