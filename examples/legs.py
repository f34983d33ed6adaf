"""Fits legs to a measured push, and compares bodies without legs, a pendulum, and the two-level model.

    cargo build --release
    pip install './python[examples]'
    python examples/legs.py [DATA_DIR] [--models NAME ...] [--generations N] [--seed N]

DATA_DIR and the difference of measured and simulated displacements are those of examples/feldmann_push.py; docs/balance.md has the
models and a table of results. Measured are heads. Two observers are compared with them:

    centre   the centre of mass, as in the paper
    head     the body leans as a rod about its feet: the head is as much further from them than the centre of mass as it is
             higher, HEAD times. The lean follows within a relaxation time, LEAN: a body does not turn at once when a foot lands.

The fit (differential evolution) minimizes the mean difference over six starts: that of the Trial has half of the weight, the others
have all people moved by 5 mm. It is checked with 64 other starts, also until the end of the record, when people have come back; and without each of the five people in turn: of all parameters
that were tried, those that are best for the other four. The search was for all five, so this is a little too good.
"""

import argparse
import pathlib
import tempfile

import numpy as np
from calibrate import MECHANICAL, starts_of, weights_of
from feldmann_push import DATA
from lemons_fmu import CommandError, Crowd, SimulationError
from lemons_fmu.push import STEP, UNTIL, Push
from scipy.optimize import differential_evolution

#: Height of the head by that of the centre of mass: 1/0.56 (Winter, Biomechanics and Motor Control of Human Movement).
HEAD = 1 / 0.56
#: [s] Relaxation time of the head's lean.
LEAN = 0.28
#: 1/s, the paper's.
RELAXATION = 1 / 0.22

#: Of each model: parameters with the range of the search; what is not named is as it comes. `floor` is FloorDamping, `lean` the
#: relaxation time of the head's lean.
LEGS = {"support": (0.05, 0.35), "step_time": (0.0, 0.4), "return_after": (0.0, 1.5), "return_speed": (0.02, 0.8)}
TWO_LEVEL = {"speed": (0.05, 1.5), "legs_speed": (0.05, 2.0), "legs_rate": (1.0, 30.0)}
FLOOR, DAMPING, TURNS, BRACING = {"floor": (2.0, 25.0)}, {"damping": (2.0, 25.0)}, {"lean": (0.02, 0.5)}, {"bracing": (0.0, 0.95)}
AS_IT_COMES = {"lean": (LEAN, LEAN)}
#: What is measured of feet and reactions of people who stand alone.
LITERATURE = {"support": (0.12, 0.12), "step_time": (0.25, 0.25), "return_after": (0.6, 0.6), "damping": (4.5, 4.5)}
NO_BRACING, FEET_APART = {"bracing": (0.0, 0.0)}, {"feet_distance": (0.1, 0.1)}
MODELS = {
    "none": (None, {}),
    "none, fitted": (None, FLOOR),
    "pendulum": ("pendulum", {}),
    "pendulum, head": ("pendulum", AS_IT_COMES),
    "pendulum, head, literature": ("pendulum", AS_IT_COMES | LITERATURE),
    "pendulum, fitted": ("pendulum", LEGS | DAMPING),
    "pendulum, head, fitted": ("pendulum", LEGS | TURNS),
    "pendulum, head, bracing fitted": ("pendulum", LEGS | TURNS | BRACING),
    "pendulum, head, no bracing": ("pendulum", LEGS | TURNS | NO_BRACING),
    "pendulum, head, feet apart": ("pendulum", LEGS | TURNS | FEET_APART),
    "pendulum, head, damping fitted": ("pendulum", LEGS | TURNS | DAMPING),
    "two-level": ("two-level", {}),
    "two-level, fitted": ("two-level", TWO_LEVEL | FLOOR),
    "two-level, head, fitted": ("two-level", TWO_LEVEL | TURNS),
}


class Heads:
    """Where the heads are that are compared."""

    def __init__(self, run, legs, relaxation):
        lean = run.poses[:, :, :2] - legs
        follows = 1 - np.exp((run.times[0] - run.times[1]) / relaxation)
        for before, now in zip(lean, lean[1:]):
            now += (before - now) * (1 - follows)
        self.times, self.poses = run.times, run.poses[:, :, :2] + (HEAD - 1) * lean


class Fit:
    """The measured push, and a model that is compared with it."""

    def __init__(self, data, push, name):
        self.data, self.push = data, push
        self.balance, self.searched = MODELS[name]
        self.tried = []

    def differences(self, values, starts, until=UNTIL):
        """Returns the difference of each person [m] from each start."""
        values = dict(zip(self.searched, map(float, values)))
        floor, lean = values.pop("floor", RELAXATION), values.pop("lean", None)
        agents = {"agent[*].FloorDamping": floor}
        if self.balance is None:
            with Crowd(self.data / "Trial") as crowd:
                return np.array([self.one(crowd, {**agents, "TimeStepMechanical": MECHANICAL, **start}, None, until) for start in starts])
        with tempfile.TemporaryDirectory() as place:
            decision = pathlib.Path(place) / "decision.toml"
            constants = "".join(f"{name} = {value!r}\n" for name, value in values.items())
            decision.write_text(f'balance = "{self.balance}"\n[{self.balance}]\n{constants}')
            with Crowd(self.data / "Trial", decision=decision, algorithm="gauss-seidel") as crowd:
                both = {f"{fmu}.{name}": value for fmu in ("crowd", "decision") for name, value in agents.items()}
                settings = [{"TimeStepMechanical": MECHANICAL, **start} for start in starts]
                settings = [{f"crowd.{name}": value for name, value in one.items()} for one in settings]
                return np.array([self.one(crowd, {**both, **one}, lean, until) for one in settings])

    def one(self, crowd, parameters, lean, until):
        crowd.reset(parameters)
        legs = []

        def look(crowd):
            legs.append([[crowd[f"decision.agent[{k}].Legs.{axis}"] for axis in "xy"] for k in range(len(crowd))])
            return False

        run = crowd.run(self.push.drive(), until=until, step=STEP, stop=look if lean else None)
        if lean:
            run = Heads(run, np.array([run.poses[0, :, :2], *legs]), lean)
        return [plane for plane, _ in self.push.differences(run, until).values()]

    def search(self, starts, generations, seed):
        """Returns the best parameters."""
        weights = weights_of(starts)

        def difference(values):
            each = weights @ self.differences(values, starts)
            self.tried.append([*values, *each])
            return each.mean()

        ranges = list(self.searched.values())
        if all(low == high for low, high in ranges):
            difference(fixed := [low for low, _ in ranges])
            return fixed
        return differential_evolution(difference, ranges, maxiter=generations, popsize=8, tol=1e-6, seed=seed, polish=False).x

    def left_out(self):
        """Returns the mean difference of people with the parameters that are best for the other four [m]."""
        each = np.array(self.tried)[:, len(self.searched) :]
        people = range(each.shape[1])
        return np.mean([each[np.argmin(np.delete(each, k, axis=1).mean(axis=1)), k] for k in people])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="?", type=pathlib.Path, default=DATA, metavar="DATA_DIR", help="the experiment; default ../shared/data/push_wed")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS), metavar="NAME", help=f"default all: {'; '.join(MODELS)}")
    parser.add_argument("--generations", type=int, default=40, metavar="N", help="of the search; default 40")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of all random numbers; default 1")
    arguments = parser.parse_args()
    if not arguments.data.is_dir():
        raise SystemExit(f"{arguments.data}: no such directory; give the directory of the data as first argument (see --help)")
    try:
        push, trial = Push.read(arguments.data), arguments.data / "Trial"
        starts = starts_of(trial, 6, arguments.seed)
        fresh = starts_of(trial, 65, arguments.seed + 1)[1:]
        print(f"{'difference [m]':30} {'own start':>9} {'64 others':>9} {'sd':>7} {'left out':>8} {f'to {push.end:g} s':>8}  parameters")
        for name in arguments.models:
            fit = Fit(arguments.data, push, name)
            best = fit.search(starts, arguments.generations, arguments.seed)
            own, others = fit.differences(best, starts[:1]).mean(), fit.differences(best, fresh).mean(axis=1)
            whole = fit.differences(best, fresh[:16], push.end).mean()
            text = ", ".join(f"{key} {value:.3g}" for key, value in zip(fit.searched, best))
            print(f"{name:30} {own:9.4f} {others.mean():9.4f} {others.std():7.4f} {fit.left_out():8.4f} {whole:8.4f}  {text}", flush=True)
    except (CommandError, SimulationError, ValueError, OSError) as error:
        raise SystemExit(str(error))


if __name__ == "__main__":
    main()
