"""What the points of a sweep simulate: one Trial or FMU, or one that parameters choose."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from dask.system import CPU_COUNT
from numpy.typing import NDArray

from .clock import steps_between
from .crowd import Crowd, Until
from .drive import DriveLike, identity, known
from .fmu import Fmu
from .leaving import LATEST
from .loaded import KEPT, Loaded, Source
from .made import Plan, made_of, model_of
from .model import ALGORITHMS, Algorithm, Model
from .results import Points, SweepError
from .work import Subject

#: More are taken for a mistake, as by `lemons sweep`: each is packed and checked before the first point is simulated.
MOST_MODELS = 10_000
#: So many are packed at once.
_AT_ONCE = min(CPU_COUNT, KEPT)
_NAME = re.compile(r"\{([^}]*)\}")


@dataclass(frozen=True)
class Given:
    """What a user has asked of every point."""

    what: Source | Fmu
    plan: Plan
    algorithm: Algorithm
    drive: DriveLike[Crowd]
    until: Until
    step: float | None


@dataclass(frozen=True)
class Study:
    """What the points simulate."""

    #: With the SHA-256 of their FMUs.
    subjects: list[Subject]
    #: Of each point the place of its subject; None if all have the first.
    places: NDArray[np.int64] | None
    #: The places of the parameters that are set.
    set: tuple[int, ...]
    #: The FMUs of a single subject.
    fmus: list[Loaded]
    #: What must be equal to continue a sweep.
    identity: dict[str, Any]
    #: If there are several subjects: what each is made of, and its plan.
    sources: list[tuple[Source | Fmu, Plan]]

    def place(self, point: int) -> int:
        """The place of a point's subject."""
        return 0 if self.places is None else int(self.places[point])

    def packed(self, place: int) -> Subject:
        """Packs a subject again, and returns it with the bytes of its FMUs, which workers do not have.

        Raises:
            CommandError, FmuError: it cannot be packed any more.
            SweepError: it has changed since the sweep began.
        """
        subject = self.subjects[place]
        fmu, plan = made_of(*self.sources[place]).data
        if (_sha256(fmu), _sha256(plan)) != (subject.fmu, subject.plan):
            changed = " or ".join(os.fspath(each) for each in self.sources[place] if isinstance(each, (str, os.PathLike)))
            raise SweepError(f"{changed} has changed since the sweep began; finished points are kept")
        return replace(subject, fmu=fmu, plan=plan)


class Packing:
    """Packs subjects shortly before they are sent, some at a time, and keeps none that is not needed next."""

    def __init__(self, study: Study) -> None:
        self._study = study
        self._pool = ThreadPoolExecutor(_AT_ONCE)
        self._packed: dict[int, Future[Subject]] = {}

    def subject(self, point: int, next_points: Iterable[int]) -> Subject:
        """What a point simulates, as it is sent to a worker. The subjects of the next points are packed meanwhile."""
        place = self._study.place(point)
        if self._study.places is None:
            return self._study.subjects[place]
        needed = dict.fromkeys([place, *map(self._study.place, islice(next_points, _AT_ONCE))])
        self._packed = {each: self._packed.get(each) or self._pool.submit(self._study.packed, each) for each in needed}
        return self._packed[place].result()

    def close(self) -> None:
        """Packs nothing more."""
        self._pool.shutdown(cancel_futures=True)


def study_of(given: Given, points: Points) -> Study:
    """Loads and checks everything that points simulate.

    Raises:
        CommandError, FmuError, TypeError, ValueError, OSError: see `sweep`.
    """
    templates = [text for text in map(_template, (given.what, given.plan)) if text is not None]
    chosen = list(dict.fromkeys(name for text in templates for name in _NAME.findall(text)))
    for name in chosen:
        if name not in points.names:
            raise ValueError(f"{', '.join(templates)}: there is no parameter {name!r}")
    columns = [points.names.index(name) for name in chosen]
    own = tuple(place for place in range(len(points.names)) if place not in columns)
    if not chosen:
        model = model_of(given.what, given.plan, given.algorithm)
        subject, told = _subject(model, given, points, own)
        fmus = [model.fmu, *([] if model.decider is None else [model.decider])]
        return Study([subject], None, own, fmus, told, [])

    known_values: dict[tuple[Any, ...], int] = {}
    places = np.empty(points.count, dtype=np.int64)
    for point in range(points.count):
        row = points.values(point)
        places[point] = known_values.setdefault(tuple(row[place] for place in columns), len(known_values))
        if len(known_values) > MOST_MODELS:
            raise ValueError(f"there are more than {MOST_MODELS} Trials, FMUs or plans")
    sources = [(_filled(given.what, chosen, row), _filled(given.plan, chosen, row)) for row in known_values]
    subjects, digest = [], hashlib.sha256()
    for model in _models(sources, given.algorithm):
        subject, told = _subject(model, given, points, own)
        subjects.append(subject)
        digest.update(json.dumps(told, sort_keys=True).encode())
    # Which point has which, and which parameters only choose.
    digest.update(places.astype("<i8").tobytes())
    digest.update(json.dumps(chosen).encode())
    return Study(subjects, places, own, [], {"models": {"count": len(subjects), "sha256": digest.hexdigest()}}, sources)


def _template(path: object) -> str | None:
    """Returns a path if there are names of parameters in it. What exists as it is written is no such path."""
    if not isinstance(path, (str, os.PathLike)) or os.path.lexists(path):
        return None
    text = str(os.fspath(path))
    return text if _NAME.search(text) else None


def _written(value: object) -> str:
    """As `lemons sweep` writes it: 1e-5, and not 1e-05."""
    if not isinstance(value, float):
        return str(value)
    return re.sub(r"e([-+])0*", lambda sign: "e-" if sign[1] == "-" else "e", repr(float(value)))


def _filled(text: Any, chosen: list[str], row: tuple[Any, ...]) -> Any:
    """A path with the values of parameters instead of their names; anything else as it is."""
    template = _template(text)
    return text if template is None else _NAME.sub(lambda found: _written(row[chosen.index(found[1])]), template)


def _models(sources: list[tuple[Source | Fmu, Plan]], algorithm: Algorithm) -> Iterator[Model]:
    """Packs some at a time."""
    rest = iter(sources)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        while some := list(islice(rest, KEPT)):
            yield from pool.map(lambda source: model_of(source[0], source[1], algorithm), some)


def _sha256(data: bytes | None) -> str | None:
    return None if data is None else hashlib.sha256(data).hexdigest()


def _subject(model: Model, given: Given, points: Points, own: tuple[int, ...]) -> tuple[Subject, dict[str, Any]]:
    """Checks all that is asked of a model, and returns it with what must be equal to continue a sweep."""
    for place in own:
        model.check(points.names[place])
    drive = known(given.drive, model.fmu.ids)
    trials = _trials(model.fmu, points)
    # They report invalid files before any point runs.
    driven = [model.driven(drive, trial) for trial in trials]
    packed = drive is None and model.decider is None and "Trial" in points.names  # each Trial has its own
    if given.until == "left":
        model.leave()
    elif isinstance(given.until, str):
        raise ValueError(f"until={given.until!r}: must be a time [s], or 'left'")
    step = given.step
    if step is None:
        step, *others = sorted({model.step_of(trial) for trial in trials})
        if others:
            raise ValueError(f"the Trials have steps of {step} s and {others[0]} s: give one for all (step)")
    step = float(step)
    steps_between(0.0, LATEST if given.until == "left" else given.until, step)
    told: dict[str, Any] = {"fmu": _told(model.fmu)}
    if model.decider is not None:
        told |= {"plan": _told(model.decider), "algorithm": ALGORITHMS[model.algorithm]}
    told |= {"drive": {"kind": "packed"} if packed else identity(driven[0]), "step": step}
    table = None if callable(drive) else drive
    plan = None if model.decider is None else model.decider.sha256
    return Subject(model.fmu.sha256, plan, model.plan, table, step), told


def _trials(fmu: Fmu, points: Points) -> list[str]:
    """Returns the packed Trials that points choose. Points with another name fail later."""
    if "Trial" not in points.names:
        return [fmu.trial]
    chosen = points.columns[points.names.index("Trial")]
    return [trial for trial in sorted(set(map(str, chosen))) if fmu.has(trial)] or [fmu.trial]


def _told(fmu: Loaded) -> dict[str, str]:
    return {"model": fmu.model_name, "guid": fmu.guid, "sha256": fmu.sha256}
