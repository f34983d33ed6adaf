"""What workers of a sweep do: they get FMUs and points, and return measures."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Union

import cloudpickle
from distributed import Worker, WorkerPlugin

from .crowd import Crowd, Until
from .drive import Drive, Floats, Known
from .errors import FmuError
from .fmu import Fmu, load
from .instance import Value
from .loaded import Loaded, load_any
from .model import Algorithm, Model
from .results import RESERVED, Result, unicode
from .run import Run

#: A function of a run that returns its measures: names and numbers (or texts).
Measure = Callable[[Run], Mapping[str, Any]]
#: A function of the Crowd after each step: whether its run ends.
Stop = Callable[[Crowd], bool]

#: The measure of sweeps whose points end by a condition: the time [s] when it was met; not a number where it was not.
ENDED = "ended"


@dataclass(frozen=True)
class Subject:
    """What points simulate. FMUs are those that a plugin has sent, by their SHA-256; or their bytes."""

    fmu: str | bytes
    plan: str | bytes | None
    #: In messages: what says where people walk.
    shown: str
    drive: Union[None, Literal[False], Drive, Floats]
    step: float


@dataclass(frozen=True)
class Job:
    """Data shared by all points of a sweep."""

    key: str
    #: All parameters.
    names: tuple[str, ...]
    #: The places of those that are set; the others only choose the subject.
    set: tuple[int, ...]
    algorithm: Algorithm
    #: A drive that is a function (or None), the measure, and what ends a point: pickled by value.
    work: bytes
    until: Until


class FmuOnWorker(WorkerPlugin):
    """Sends an FMU's bytes to every worker once, also to those that join later. No shared file system is needed."""

    def __init__(self, fmu: Loaded) -> None:
        self.data = fmu.data
        self.crowd = isinstance(fmu, Fmu)
        self.name = f"lemons-fmu-{fmu.sha256}"

    def setup(self, worker: Worker) -> None:
        fmu = load(self.data) if self.crowd else load_any(self.data)
        _fmus[fmu.sha256] = fmu.data


class JobOnWorker(WorkerPlugin):
    """Tells every worker what a sweep is."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.name = f"lemons-sweep-{job.key}"

    def setup(self, worker: Worker) -> None:
        _jobs[self.job.key] = self.job, cloudpickle.loads(self.job.work)

    def teardown(self, worker: Worker) -> None:
        _jobs.pop(self.job.key, None)


_fmus: dict[str, bytes] = {}
_jobs: dict[str, tuple[Job, tuple[Known[Crowd], Measure, Stop | None]]] = {}


def simulate_points(key: str, subject: Subject, points: list[tuple[int, tuple[Value, ...]]]) -> tuple[list[Result], float]:
    """Runs on a worker. Returns results, and the time that they took [s]."""
    start = time.perf_counter()
    model = _model(subject, _jobs[key][0].algorithm)
    results = [_simulate_point(key, model, subject, point, values) for point, values in points]
    return results, time.perf_counter() - start


def _model(subject: Subject, algorithm: Algorithm) -> Model:
    def data(fmu: str | bytes) -> bytes:
        return _fmus[fmu] if isinstance(fmu, str) else fmu

    decider = None if subject.plan is None else load_any(data(subject.plan))
    return Model(load(data(subject.fmu)), decider, algorithm, subject.shown)


def _simulate_point(key: str, model: Model, subject: Subject, point: int, values: tuple[Value, ...]) -> Result:
    job, (function, measure, stop) = _jobs[key]
    try:
        with Crowd(model, {job.names[place]: values[place] for place in job.set}) as crowd:
            run = crowd.run(function or subject.drive, until=job.until, step=subject.step, stop=stop)
        return point, _measured(run, measure, job.names, job.until == "left" or stop is not None), None
    except FmuError as error:
        return point, {}, _text(str(error))
    except KeyboardInterrupt:
        raise Interrupted from None
    except BaseException as error:  # a failed point (even by sys.exit) is a row of the table and does not end the sweep
        return point, {}, _told(error)


class Interrupted(Exception):
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


def _measured(run: Run, measure: Measure, parameters: tuple[str, ...], ends: bool) -> dict[str, float | str]:
    measures = measure(run)
    if not hasattr(measures, "items"):
        raise TypeError(f"the measure returned {type(measures).__name__}, not names and numbers")
    out: dict[str, float | str] = {}
    for key, value in measures.items():
        name = str(key)
        if name in parameters or name in RESERVED or (ends and name == ENDED):
            raise ValueError(f"the measure has the name of another column: {name!r}")
        if not unicode(name) or isinstance(value, str) and not unicode(value):
            raise ValueError(f"the measure {name!r} is not Unicode text: {value!r}")
        out[name] = value if isinstance(value, str) else math.nan if value is None else float(value)
    if ends:
        out[ENDED] = math.nan if run.ended is None else run.ended
    return out
