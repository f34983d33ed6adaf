"""How far a sweep or a run is."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """The progress of a sweep: numbers of finished, of failed and of all points."""

    done: int
    failed: int
    total: int
    #: Time since this call [s].
    seconds: float
    #: Number of points that were finished before this call.
    before: int
    #: Number of threads of all workers, None if it is not known; 0: the sweep waits for a worker.
    threads: int | None


class ProgressLine:
    """A progress line on standard error: a terminal or a notebook shows it updated, elsewhere a new one is written every half
    minute. `what` is the noun of what is counted, `failing` whether they can fail."""

    def __init__(self, what: str = "points", failing: bool = True) -> None:
        self.what = what
        self.failing = failing
        # A notebook takes \r as a terminal does.
        self.terminal = sys.stderr.isatty() or "ipykernel" in sys.modules
        self.last = -math.inf

    def __call__(self, at: Progress) -> None:
        end = at.done == at.total
        if at.seconds - self.last < (0.2 if self.terminal else 30.0) and not end:
            return
        self.last = at.seconds
        new = at.done - at.before
        rest = f"{(at.total - at.done) * at.seconds / new:.0f} s left" if new and not end else f"{at.seconds:.0f} s"
        if at.threads == 0 and not end:
            rest = "waiting for workers"
        failed = f"{at.failed} failed, " if self.failing else ""
        line = f"{at.done} of {at.total} {self.what}, {failed}{rest}"
        print(f"\r{line:<60}" if self.terminal else line, end="" if self.terminal and not end else "\n", file=sys.stderr)
        sys.stderr.flush()
