"""What workers of a sweep do: they get models and points, and return measures."""

from __future__ import annotations

import math
import pickle
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from . import _native
from .crowd import Algorithm, Crowd, Until, Value
from .drive import Known
from .record import Run

#: A function of a run that returns its measures: names and numbers (or texts).
Measure = Callable[[Run], Mapping[str, Any]]
#: A function of the Crowd after each step: whether its run ends.
Stop = Callable[[Crowd], bool]
#: A finished point: its number, its measures (None: it failed), the message of its failure.
Result = tuple[int, "dict[str, float | str] | None", "str | None"]

#: Columns of the table that are no parameters and no measures.
POINT, STATUS, ERROR = RESERVED = ("point", "status", "error")
#: The measure of sweeps whose points end by a condition: the time [s] when it was met; not a number where it was not.
ENDED = "ended"


class Subject(NamedTuple):
    """What points simulate."""

    model: _native.Model
    drive: Known[Crowd]
    step: float


@dataclass(frozen=True)
class Job:
    """Data shared by all points of a sweep."""

    key: str
    #: What all points simulate; None: it comes with each task.
    subject: Subject | None
    #: All parameters.
    names: tuple[str, ...]
    #: The places of those that are set; the others only choose the subject.
    set: tuple[int, ...]
    algorithm: Algorithm
    #: A drive that is a function (or None), the measure, and what ends a point: pickled by value.
    work: bytes
    until: Until


_jobs: dict[str, tuple[Job, tuple[Known[Crowd], Measure, Stop | None]]] = {}


def begin(job: Job) -> None:
    """Gets a worker ready for the points of a sweep."""
    # What cloudpickle has written is read by pickle.
    _jobs[job.key] = job, pickle.loads(job.work)


def end(job: Job) -> None:
    """Forgets a sweep."""
    _jobs.pop(job.key, None)


def simulate_points(key: str, subject: Subject | None, points: list[tuple[int, list[Value]]]) -> tuple[list[Result], float]:
    """Runs on a worker. Returns results, and the time that they took [s]."""
    start = time.perf_counter()
    subject = subject or _jobs[key][0].subject
    assert subject is not None
    results = [_simulate_point(key, subject, point, values) for point, values in points]
    return results, time.perf_counter() - start


def _simulate_point(key: str, subject: Subject, point: int, values: list[Value]) -> Result:
    job, (function, measure, stop) = _jobs[key]
    try:
        with Crowd(subject.model, {job.names[place]: values[place] for place in job.set}, algorithm=job.algorithm) as crowd:
            run = crowd.run(function or subject.drive, until=job.until, step=subject.step, stop=stop)
        return point, _measured(run, measure, job.names, job.until == "left" or stop is not None), None
    except _native.SimulationError as error:
        return point, None, _text(str(error))
    except KeyboardInterrupt:
        raise Interrupted from None
    except BaseException as error:  # a failed point (even by sys.exit) is a row of the table and does not end the sweep
        return point, None, _message(error)


class Interrupted(Exception):
    """A measure or a drive raised KeyboardInterrupt, which would end Dask's worker process."""


def _message(error: BaseException) -> str:
    kind = type(error).__name__
    try:
        return _text(f"{kind}: {error}")
    except BaseException as worse:
        return _text(f"{kind}, whose message raises {type(worse).__name__}")


def _text(text: str) -> str:
    """Returns the text in one line, without characters that UTF-8 cannot represent."""
    return " ".join(text.encode(errors="backslashreplace").decode().splitlines())


def _is_unicode(text: str) -> bool:
    """Returns whether a text can be written as UTF-8: Python's texts may contain halves of characters."""
    return text.encode(errors="ignore").decode() == text


def _measured(run: Run, measure: Measure, parameters: tuple[str, ...], ends: bool) -> dict[str, float | str]:
    measures = measure(run)
    if not hasattr(measures, "items"):
        raise TypeError(f"the measure returned {type(measures).__name__}, not names and numbers")
    out: dict[str, float | str] = {}
    for key, value in measures.items():
        name = str(key)
        if name in parameters or name in RESERVED or (ends and name == ENDED):
            raise ValueError(f"the measure has the name of another column: {name!r}")
        if not _is_unicode(name) or isinstance(value, str) and not _is_unicode(value):
            raise ValueError(f"the measure {name!r} is not Unicode text: {value!r}")
        out[name] = value if isinstance(value, str) else math.nan if value is None else float(value)
    if ends:
        out[ENDED] = math.nan if run.ended is None else run.ended
    return out
