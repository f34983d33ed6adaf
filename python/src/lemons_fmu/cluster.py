"""The points of a sweep on the workers of a Dask cluster: of this machine, or of another one. Only this file uses Dask."""

from __future__ import annotations

import itertools
import logging
import math
import queue
import time
from asyncio import CancelledError
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import spawn
from typing import TYPE_CHECKING, Any

import cloudpickle
import dask
from dask.system import CPU_COUNT
from distributed import Client, Future, KilledWorker, LocalCluster, SpecCluster, Status, Worker, WorkerPlugin

from ._native import SweepError
from .progress import Progress
from .work import Interrupted, Job, Result, begin, end, simulate_points

if TYPE_CHECKING:
    import pandas as pd

    from .sweep import Results, Study

#: [s] Duration of a task for a worker, which chooses its number of points: Dask needs about 10 ms for each task.
TASK = 0.5

#: [s] A sweep that can start its workers itself ends when it has had none for so long.
DESERTED = 600.0

#: The message of a point whose worker process ends several times, for example by os._exit, a signal or lack of memory.
DIED = "the worker process ended several times while it simulated this point"


def pickled(work: object) -> bytes:
    """Returns functions and what they use by value, as workers get them."""
    return bytes(cloudpickle.dumps(work))


class JobOnWorker(WorkerPlugin):
    """Tells every worker what a sweep is, also those that join later. No shared file system is needed."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.name = f"lemons-sweep-{job.key}"

    def setup(self, worker: Worker) -> None:
        begin(self.job)

    def teardown(self, worker: Worker) -> None:
        end(self.job)


def simulate_all(
    study: Study, job: Job, results: Results, client: Client | str | None, report: Callable[[Progress], None]
) -> pd.DataFrame:
    """Simulates all points that are not finished, and returns the table."""
    count = study.native.count
    left = [point for point in range(count) if point not in results.finished]
    before, start = count - len(left), time.monotonic()
    done, failed, threads = before, sum(results.rows[point][2] is not None for point in results.finished), None

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
    """Starts workers on this machine."""
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

    def __init__(self, client: Client, job: Job, study: Study, open_points: list[int]) -> None:
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
