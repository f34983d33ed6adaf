"""Communication points, with the same bits as in `lemons run`."""

from __future__ import annotations

import math

import numpy as np

from .drive import Floats

#: Largest number of communication steps of a run, as in `lemons run`.
MOST_STEPS = 1_000_000_000


def steps_between(start: float, until: float, step: float) -> int:
    """Returns the number of communication steps between two times [s]; the last may be shorter.

    Raises:
        ValueError: there are no steps, there are too many, or rounding makes the step zero.
    """
    return clock_of(start, until, step)[0]


def clock_of(start: float, until: float, step: float) -> tuple[int, float]:
    """Returns the number of communication steps and the last point [s], as `Clock::new` of `lemons run`.

    Raises:
        ValueError: see `steps_between`.
    """
    if not (math.isfinite(until) and until > start and math.isfinite(step) and step > 0):
        raise ValueError(f"nothing to simulate: from {start} s to {until} s in steps of {step} s")
    quotient = (until - start) / step
    if quotient > MOST_STEPS + 0.5:
        raise ValueError(f"from {start} s to {until} s there are {quotient:.4e} steps of {step} s: at most {MOST_STEPS:.0e} are made")
    if start + step <= start or until - step >= until:
        raise ValueError(f"a communication step of {step} s is lost in rounding between {start} s and {until} s")
    steps = max(1, math.floor(quotient + 0.5))
    # Both the quotient and the multiple are rounded: by less than a few of the smallest differences of such times.
    multiple, rounding = start + steps * step, 4.0 * max(math.ulp(until), math.ulp(start))
    if abs(multiple - until) <= max(rounding, 1e-9 * step):
        # If the end is a multiple of the step except for rounding, use that multiple.
        until = multiple
    else:
        steps = max(1, math.ceil(quotient))
    # No step has the length 0.
    while steps > 1 and start + (steps - 1) * step >= until:
        steps -= 1
    return steps, until


def points_between(start: float, until: float, step: float) -> Floats:
    """Returns the communication points between two times [s], including both; the same bits as in `lemons run`. They are
    multiples of the step, not sums; the last step may be shorter.

    Raises:
        ValueError: see `steps_between`.
    """
    steps = steps_between(start, until, step)
    times: Floats = start + np.arange(steps + 1, dtype=np.float64) * step
    times[-1] = clock_of(start, until, step)[1]
    return times
