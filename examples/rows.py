"""Pushes rows of people who stand: how fast and how far the push goes, and what each person gets and passes on.

    cargo build --release
    pip install './python[examples]'
    python examples/rows.py [--models NAME ...] [--people N ...] [--gaps M ...] [--impulses NS ...]

Everybody is the same person (49 cm broad, 25 cm deep, 1.75 m, 70 kg) and looks along the row, which ends in the open. The last one
is pushed for PUSH seconds (half a sine). The force between two neighbours follows from the motions, from the front person backwards:
its impulse in a step is m dv + m dx/t_transl - Fp dt, and that of the neighbour ahead.

    speed      of the push: distance over time until people are faster than MOVING, a straight line through all of them
    reached    how many people are moved by more than FAR
    passed on  impulse on the second person by that on the first
    way        of the first person, at most, by the impulse
    fastest    greatest speed of a centre of mass; of a head (examples/legs.py)
    phases     mean times of those in the middle: receiving only, receiving and passing on, passing on only (more than 20 N)
    steps      of all people, and the longest of the first one

Beside measured numbers in docs/balance.md.
"""

import argparse
import pathlib
import tempfile

import numpy as np
from legs import LEAN, Heads
from lemons_fmu import CommandError, Crowd, Drive, SimulationError
from validation import lemons

PUSH = 0.3  # s
STEP = 0.005  # s, communication step
UNTIL = 4.0  # s
MOVING = 0.1  # m/s
FAR = 0.05  # m
DEPTH, MASS = 0.25, 70.0
PHASE = 20.0  # N
#: What is measured of feet and reactions of people who stand alone (docs/balance.md).
LITERATURE = "support = 0.12\nstep_time = 0.25\nreturn_after = 0.6\ndamping = 4.5\n"
MODELS = {
    "none": "",
    "pendulum": 'balance = "pendulum"\n',
    "pendulum, alone": f'balance = "pendulum"\n[pendulum]\n{LITERATURE}',
    "two-level": 'balance = "two-level"\n',
}


def row(place, model, count):
    """Writes a Trial with a row, and a decision.toml. Returns what makes a Crowd."""
    trial, decision = place / f"row{count}", False
    if not trial.exists():
        lemons("crowd", "-n", count, "--fixed", f"49,{100 * DEPTH:g},1.75,{MASS:g}", "--packing", "grid", "-o", trial)
    if MODELS[model]:
        decision = place / "legs.toml"
        decision.write_text(MODELS[model])
    return {"what": trial, "decision": decision, "algorithm": "gauss-seidel"}


def push(made, count, gap, impulse):
    """Returns a run, the middle of everybody's feet, and the impulses of the drives of legs [N s] (step, person)."""
    owner = "crowd." if made["decision"] else ""
    start = {f"{owner}agent[*].Theta": 0.0, f"{owner}agent[*].Position.y": 0.0}
    start |= {f"{owner}agent[{k}].Position.x": k * (DEPTH + gap) for k in range(count)}
    times = np.arange(0, PUSH + STEP, STEP)
    force = impulse * np.pi / (2 * PUSH) * np.sin(np.pi * np.clip(times / PUSH, 0, 1))
    drive = Drive({0: (times, np.outer(force, [1, 0, 0]))}, at="middle")
    feet, drives, steps = [], [], []
    with Crowd(**made) as crowd:
        crowd.reset(start)

        def look(crowd):
            if made["decision"]:
                agents = [f"decision.agent[{k}]." for k in range(count)]
                feet.append([[crowd[agent + "Legs.x"], crowd[agent + "Legs.y"]] for agent in agents])
                drives.append([crowd[agent + "Fp.x"] for agent in agents])
                steps[:] = [crowd[agent + "Steps"] for agent in agents]
            return False

        run = crowd.run(drive, until=UNTIL, step=STEP, stop=look)
        damping = crowd[owner + "agent[0].FloorDamping"]
    if not feet:
        feet, drives, steps = run.poses[1:, :, :2], np.zeros((len(run.times) - 1, count)), [0] * count
    return run, np.array([run.poses[0, :, :2], *feet]), np.array(drives), damping, steps


def forces(run, drives, damping):
    """Returns the force on each person from behind [N], (step, person): the push is not that of a neighbour."""
    velocity, place = run.velocities[:, :, 0], run.poses[:, :, 0]
    net = MASS * (np.diff(velocity, axis=0) + damping * np.diff(place, axis=0)) / STEP - drives
    return np.cumsum(net[:, ::-1], axis=1)[:, ::-1]


def measures(model, count, gap, impulse, place):
    run, feet, drives, damping, steps = push(row(place, model, count), count, gap, impulse)
    behind = forces(run, drives, damping)
    moved = run.poses[:, :, 0] - run.poses[0, :, 0]
    speeds = run.velocities[:, :, 0]
    there = [k for k in range(count) if speeds[:, k].max() > MOVING]
    arrived = [run.times[np.argmax(speeds[:, k] > MOVING)] for k in there]
    slope = np.polyfit(arrived, [k * (DEPTH + gap) for k in there], 1)[0] if len(there) > 2 else np.nan
    smooth = np.ones(10) / 10
    loads = np.abs(np.apply_along_axis(np.convolve, 0, behind, smooth, "same")) > PHASE
    middle = list(range(1, min(count, len(there)) - 1))
    gets, passes = loads[:, middle], loads[:, [k + 1 for k in middle]]
    phases = [STEP * each.sum() / max(1, len(middle)) for each in (gets & ~passes, gets & passes, passes & ~gets)]
    heads = Heads(run, feet, LEAN) if model != "none" else None
    head = np.diff(heads.poses[:, :, 0], axis=0).max() / STEP if heads else np.nan
    longest = np.abs(np.diff(feet[:, 0, 0])).max() if model != "none" else 0
    return [
        slope,
        int((moved.max(axis=0) > FAR).sum()),
        behind[:, 1].sum() * STEP / impulse if count > 1 else np.nan,
        moved[:, 0].max() / impulse,
        speeds.max(),
        head,
        *(phases if middle else [np.nan] * 3),
        sum(steps),
        longest,
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS), metavar="NAME", help=f"default all: {'; '.join(MODELS)}")
    parser.add_argument("--people", nargs="+", type=int, default=[1, 5, 10, 20, 40], metavar="N", help="in a row; default 1 5 10 20 40")
    parser.add_argument("--gaps", nargs="+", type=float, default=[0.02, 0.1], metavar="M", help="between chest and back; default 0.02 0.1")
    parser.add_argument("--impulses", nargs="+", type=float, default=[60, 120], metavar="NS", help="of the push; default 60 120")
    arguments = parser.parse_args()
    if min(arguments.people) < 1 or min(arguments.gaps) < 0 or min(arguments.impulses) <= 0:
        parser.error("--people must be at least 1, --gaps at least 0, --impulses above 0")
    print(f"{'model':17} {'people':>6} {'gap':>5} {'N s':>4} {'speed':>6} {'reached':>7} {'passed':>6} {'m/(N s)':>7} {'centre':>6} {'head':>6} {'phases / s':>15} {'steps':>5} {'longest':>7}")
    with tempfile.TemporaryDirectory() as place:
        try:
            for model in arguments.models:
                for count in arguments.people:
                    for gap in arguments.gaps if count > 1 else [0.0]:
                        for impulse in arguments.impulses:
                            found = measures(model, count, gap, impulse, pathlib.Path(place))
                            slope, reached, passed, way, centre, head, one, two, three, steps, longest = found
                            phases = f"{one:.2f} {two:.2f} {three:.2f}"
                            print(f"{model:17} {count:6} {gap:5.2f} {impulse:4.0f} {slope:6.2f} {reached:7} {passed:6.2f} {way:7.4f} {centre:6.2f} {head:6.2f} {phases:>15} {steps:5} {longest:7.2f}", flush=True)
        except (CommandError, SimulationError, ValueError, OSError) as error:
            raise SystemExit(str(error))


if __name__ == "__main__":
    main()
