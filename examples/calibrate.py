"""Fits the mechanics to a measured push, and estimates how well the push determines each parameter.

    cargo build --release
    pip install './python[examples]'
    python examples/calibrate.py [DATA_DIR] [--fmu FILE] [--plot FILE.png] [--out FILE.csv] [--scheduler ADDRESS] [--seed N]

DATA_DIR is as in examples/feldmann_push.py, and so is the difference between measured and simulated: the mean of the five
people's root-mean-square differences of the displacement in the plane, until 4 s. The fitted parameters are

    relaxation time   of translation and rotation, the same for all: 1/FloorDamping = 1/AngularDamping [s]
    stiffness         Young's modulus of the bodies [N/m]; the ratio of the shear modulus to it is that of the Trial, so that both
                      stiffnesses of a contact, normal and tangential, are proportional to it
    damping           gamma_n = gamma_t between people [kg/s]
    friction          between people

Contacts with the wall keep their own damping and friction. A fit to one run alone finds parameters for which random collisions
follow the measured curves; with starts changed by some millimetres, less than the error of the measurement, it fails. So the fit
minimizes a mean difference over several starts: that of the Trial has half of the weight, the others have all people moved by 5 mm
in x and y (normal distribution).

First a sweep over the whole range (scrambled Sobol points), then searches (Nelder and Mead, in the logarithms) from its best points.
Two intervals show how well a parameter is determined:

    profile           the parameter is fixed, the others are fitted again. The interval (95 %) ends where the difference has grown by
                      sqrt(1 + 3.84 / (n - 4)), as it would for n independent normal residuals; n, the effective number of residuals,
                      follows from their autocorrelation, because residuals at neighbouring times are correlated.
    people            the five people are drawn again with replacement, 2000 times; each time the best of all simulated parameters is
                      taken. The interval contains 95 % of them.

An interval that reaches the end of the searched range is marked with <= or >=: the push does not determine its end. The fit is
checked with 64 other starts, and without each of the five people in turn.
"""

import argparse
import math
import pathlib
import sys
import time

import numpy as np
import pandas as pd
from distributed import Client, as_completed
from feldmann_push import COLOURS, DATA
from lemons_fmu import CommandError, Crowd, SimulationError, SweepError, local_cluster, sweep
from lemons_fmu.push import STEP, UNTIL, Push
from lemons_fmu.progress import Progress, ProgressLine
from scipy.optimize import minimize
from scipy.stats import qmc

NAMES = ["relaxation time", "stiffness", "damping", "friction"]
UNITS = ["s", "N/m", "kg/s", ""]
LOW = np.log([0.08, 4e5, 20.0, 0.05])
HIGH = np.log([0.6, 4e7, 7000.0, 1.5])
FIRST_STEP = np.array([0.1, 0.5, 0.5, 0.3])  # first step of a search, in the logarithm
MECHANICAL = 1e-4  # s, mechanical step of the search; the fit is confirmed at 2e-6 s
MOVED = 0.005  # m, standard deviation of the starts
CONTACT = "contact.human_naked.human_naked."
MATERIAL = "material.human_naked."


def parameters(values, ratio, mechanical=MECHANICAL):
    """Returns the parameters of the FMU. `ratio` is shear modulus / Young's modulus."""
    relaxation, stiffness, damping, friction = values
    return {
        "TimeStepMechanical": mechanical,
        "agent[*].FloorDamping": 1 / relaxation,
        "agent[*].AngularDamping": 1 / relaxation,
        MATERIAL + "YoungModulus": stiffness,
        MATERIAL + "ShearModulus": stiffness * ratio,
        CONTACT + "GammaNormal": damping,
        CONTACT + "GammaTangential": damping,
        CONTACT + "KineticFriction": friction,
    }


class Compare:
    """The measure of the sweep: the difference of each person [m]."""

    def __init__(self, push):
        self.push = push

    def __call__(self, run):
        return {f"person {k}": plane for k, (plane, _) in self.push.differences(run).items()}


def starts_of(trial, count, seed):
    """Returns start values: those of the Trial, then others with all people moved."""
    with Crowd(trial) as crowd:
        places = crowd.poses()[:, :2]
    moves = np.random.default_rng(seed).normal(scale=MOVED, size=(count, *places.shape))
    moves[0] = 0
    return [
        {f"agent[{i}].Position.{axis}": place[i, k] for i in range(len(place)) for k, axis in enumerate("xy")}
        for place in places + moves
    ]


def weights_of(starts):
    """Returns the weights of the starts: half for that of the Trial."""
    others = len(starts) - 1
    return np.array([0.5] + [0.5 / others] * others) if others else np.ones(1)


def search(task, model, push, ratio, starts, evaluations):
    """Searches (Nelder and Mead) from a point, with one parameter or none fixed. Returns all simulations: rows (parameters, differences)."""
    begin, held = task
    free = [k for k in range(len(begin)) if k != held]
    seen = []
    drive, compare = push.drive(), Compare(push)
    with Crowd(model) as crowd:

        def difference(x):
            point = begin.copy()
            point[free] = np.clip(x, LOW[free], HIGH[free])
            each = []
            for start in starts:
                crowd.reset({**parameters(np.exp(point), ratio), **start})
                each.append(list(compare(crowd.run(drive, until=UNTIL, step=STEP)).values()))
            each = weights_of(starts) @ np.array(each)
            seen.append([*point, *each])
            return each.mean()

        x = begin[free]
        # The first steps go away from the nearer end of the range.
        steps = np.where(x < (LOW + HIGH)[free] / 2, 1, -1) * FIRST_STEP[free]
        simplex = np.vstack([x, x + np.diag(steps)])
        options = {"initial_simplex": simplex, "xatol": 0.01, "fatol": 1e-5, "maxfev": evaluations * len(free)}
        minimize(difference, x, method="Nelder-Mead", options=options)
    return np.array(seen)


def best_of(cloud):
    return cloud[np.argmin(cloud[:, 4:].mean(axis=1))]


def effective_number(residuals):
    """Returns the number of independent residuals: for each series its length / twice its correlation time (until the first zero)."""
    count = 0.0
    for series in residuals:
        series = series - series.mean()
        full = np.correlate(series, series, "full")[len(series) - 1 :]
        correlation = full / full[0]
        end = np.argmax(correlation <= 0) if (correlation <= 0).any() else len(correlation)
        count += len(series) / (1 + 2 * correlation[1:end].sum())
    return count


def around(middle, low, high, count):
    """Returns values from low to high, closer to each other near the middle."""
    return low + (high - low) * np.interp(
        np.linspace(0, 1, count),
        [0, 0.15, 0.35, 0.5, 0.65, 0.85, 1],
        (np.array([low, *np.clip(middle + (high - low) * np.array([-0.2, -0.05, 0, 0.05, 0.2]), low, high), high]) - low)
        / (high - low),
    )


def interval(values, difference, level):
    """Returns the interval in which a profile is below the level, with < or > if it reaches the end of the range."""
    below = np.flatnonzero(difference <= level)
    ends = []
    for inner, outer, sign in ((below[0], below[0] - 1, "<"), (below[-1], below[-1] + 1, ">")):
        if 0 <= outer < len(values):
            share = (level - difference[inner]) / (difference[outer] - difference[inner])
            ends.append(("", math.exp(values[inner] + share * (values[outer] - values[inner]))))
        else:
            ends.append((sign, math.exp(values[inner])))
    return ends


def bootstrap(cloud, rng, draws=2000):
    """Returns the best parameters for people drawn with replacement: rows of logarithms."""
    people = cloud.shape[1] - 4
    weights = np.array([np.bincount(rng.integers(people, size=people), minlength=people) for _ in range(draws)])
    chosen = [np.argmin(block @ cloud[:, 4:].T, axis=1) for block in np.array_split(weights, 50)]
    return cloud[np.concatenate(chosen), :4]


def ends_of(sample, low, high):
    """Returns the interval with 95 % of a sample, with < or > at the ends of the range."""
    a, b = np.quantile(sample, [0.025, 0.975])
    return [("<" if a < low + 0.05 else "", math.exp(a)), (">" if b > high - 0.05 else "", math.exp(b))]


def written(number):
    return f"{number:.2e}" if number >= 1e5 else f"{number:.3g}"


def between(ends):
    return " … ".join(f"{'≤ ' if sign == '<' else '≥ ' if sign == '>' else ''}{written(value)}" for sign, value in ends)


def from_starts(trial, push, ratio, values, starts, client):
    """Returns the mean differences with these starts [m]."""
    table = pd.DataFrame([{**parameters(values, ratio), **start} for start in starts])
    result = sweep(trial, table, push.drive(), Compare(push), until=UNTIL, step=STEP, client=client)
    return result[[f"person {k}" for k in push.people]].mean(axis=1).to_numpy()


def plot(path, push, usual, fitted, profiles, level, paper, fit, people):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.lines import Line2D

    figure = plt.figure(figsize=(10, 7.6), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[1.35, 1])
    axes = upper.subplots()
    for colour, (person, rows) in zip(COLOURS, push.heads.items()):
        axes.plot(rows[:, 0], rows[:, 1] - rows[0, 1], "--", color=colour, linewidth=1.4)
        for run, style in ((usual, dict(linewidth=0.9, alpha=0.6)), (fitted, dict(linewidth=2))):
            axes.plot(run.times, run.poses[:, person, 0] - run.poses[0, person, 0], "-", color=colour, **style)
    axes.axvspan(UNTIL, push.end, color="0.93", zorder=0, linewidth=0)
    axes.text((UNTIL + push.end) / 2, 0.02, "not compared: people walk back", transform=axes.get_xaxis_transform(), ha="center", color="0.35")
    axes.set(xlim=(0, push.end), xlabel="time / s", ylabel="displacement along the push / m")
    kinds = [
        Line2D([], [], color="0.3", linestyle="--", label="measured (head)"),
        Line2D([], [], color="0.3", linewidth=0.9, alpha=0.6, label="simulated, the paper's parameters"),
        Line2D([], [], color="0.3", linewidth=2, label="simulated, fitted"),
        *(Line2D([], [], color=colour, linewidth=3, label=f"person {person}") for colour, person in zip(COLOURS, push.people)),
    ]
    axes.legend(handles=kinds, loc="upper left", frameon=False, fontsize="small")
    panels = lower.subplots(1, 4, sharey=True)
    top = 100 * (5 * level - 4 * min(each.min() for _, each in profiles))
    for k, (panel, (values, difference)) in enumerate(zip(panels, profiles)):
        panel.axvline(paper[k], color="#D55E00", linewidth=1.2)
        panel.axhline(100 * level, color="0.5", linestyle=":", linewidth=1)
        panel.plot(np.exp(values), 100 * difference, "o-", color="#0072B2", markersize=3.5, linewidth=1.5)
        panel.plot(np.exp(fit[k]), 100 * fit[4:].mean(), "D", color="black", markersize=5)
        bottom = 100 * fit[4:].mean() - 0.16 * (top - 100 * fit[4:].mean())
        panel.plot([people[k][0][1], people[k][1][1]], [bottom, bottom], color="black", linewidth=3, solid_capstyle="butt")
        panel.set_xscale("log")
        panel.set_xlim(math.exp(LOW[k]), math.exp(HIGH[k]))
        panel.set_xlabel(NAMES[k] + (f" / {UNITS[k]}" if UNITS[k] else ""))
    panels[0].set_ylim(100 * fit[4:].mean() - 0.25 * (top - 100 * fit[4:].mean()), top)
    panels[0].set_ylabel("mean rms difference / cm, of all\nstarts; the others fitted again")
    panels[0].set_xticks([0.1, 0.2, 0.4], ["0.1", "0.2", "0.4"])
    panels[0].minorticks_off()
    marks = [
        Line2D([], [], color="#D55E00", linewidth=1.2, label="paper"),
        Line2D([], [], color="black", marker="D", linestyle="", markersize=5, label="fit"),
        Line2D([], [], color="0.5", linestyle=":", linewidth=1, label="end of the profile's interval"),
        Line2D([], [], color="black", linewidth=3, label="interval of drawn people"),
    ]
    lower.legend(handles=marks, loc="outside upper center", ncols=4, frameon=False, fontsize="small")
    for each in (axes, *panels):
        each.spines[["top", "right"]].set_visible(False)
        each.grid(alpha=0.25)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="?", type=pathlib.Path, default=DATA, metavar="DATA_DIR", help="the experiment; default ../shared/data/push_wed")
    parser.add_argument("--fmu", metavar="FILE", help="the FMU of a crowd, whose Trial is simulated; default: the Trial in DATA_DIR")
    parser.add_argument("--plot", default="calibration.png", metavar="FILE.png", help="output file; default calibration.png")
    parser.add_argument("--out", metavar="FILE.csv", help="keep the sweep in this table; continue one that is there")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="address of a Dask scheduler; default: use the cores of this machine")
    parser.add_argument("--points", type=int, default=256, metavar="N", help="number of points of the sweep; default 256")
    parser.add_argument("--starts", type=int, default=6, metavar="N", help="number of starts, including that of the Trial; default 6")
    parser.add_argument("--searches", type=int, default=6, metavar="N", help="number of searches from the best points; default 6")
    parser.add_argument("--profile", type=int, default=9, metavar="N", help="number of values of each parameter in its profile; default 9")
    parser.add_argument("--evaluations", type=int, default=40, metavar="N", help="largest number of simulations of a search, per parameter; default 40")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of all random numbers; default 1")
    arguments = parser.parse_args()
    if min(arguments.points, arguments.starts, arguments.searches, arguments.evaluations) < 1 or arguments.profile < 5:
        parser.error("all numbers must be at least 1, and --profile at least 5")
    if not arguments.data.is_dir():
        raise SystemExit(f"{arguments.data}: no such directory; give the directory of the data as first argument (see --help)")
    try:
        push = Push.read(arguments.data)
        trial = arguments.fmu or arguments.data / "Trial"
        if arguments.scheduler:
            with Client(arguments.scheduler, timeout="20s") as client:
                calibrate(arguments, push, trial, client)
        else:
            with local_cluster() as cluster, Client(cluster) as client:
                calibrate(arguments, push, trial, client)
    except (CommandError, SimulationError, SweepError, ValueError, OSError) as error:
        raise SystemExit(str(error))


def calibrate(arguments, push, trial, client):
    def tell(text):
        print(text, file=sys.stderr, flush=True)

    with Crowd(trial) as crowd:
        model = crowd.model
        young, shear = crowd[MATERIAL + "YoungModulus"], crowd[MATERIAL + "ShearModulus"]
        usual = [1 / crowd["agent[0].FloorDamping"], young, crowd[CONTACT + "GammaNormal"], crowd[CONTACT + "KineticFriction"]]
        before = crowd.run(push.drive(), until=push.end, step=STEP)
    ratio = shear / young

    starts = starts_of(trial, arguments.starts, arguments.seed)
    tell(f"sweep of {arguments.points} points, each from {len(starts)} starts")
    grid = LOW + qmc.Sobol(4, seed=arguments.seed).random(arguments.points) * (HIGH - LOW)
    table = pd.DataFrame([{**parameters(np.exp(point), ratio), **start} for point in grid for start in starts])
    result = sweep(trial, table, push.drive(), Compare(push), until=UNTIL, step=STEP, out=arguments.out, client=client)
    if (result.status != "ok").any():
        raise SystemExit(f"a simulation failed: {result.error.dropna().iloc[0]}")
    each = result[[f"person {k}" for k in push.people]].to_numpy().reshape(len(grid), len(starts), -1)
    cloud = np.column_stack([grid, np.einsum("s,psk->pk", weights_of(starts), each)])

    models = client.scatter(model, broadcast=True)

    def search_all(tasks):
        fixed = {"model": models, "push": push, "ratio": ratio, "starts": starts, "evaluations": arguments.evaluations}
        futures = client.map(search, tasks, **fixed, pure=False)
        begin, line = time.monotonic(), ProgressLine("searches")

        def show(done):
            line(Progress(done, 0, len(tasks), time.monotonic() - begin, 0, None))

        show(0)
        for done, future in enumerate(as_completed(futures), 1):
            if future.status == "error":
                future.result()  # raises its error
            show(done)
        return client.gather(futures)

    tell(f"{arguments.searches} searches from the best of them")
    order = np.argsort(cloud[:, 4:].mean(axis=1))
    cloud = np.vstack([cloud, *search_all([(cloud[k, :4], None) for k in order[: arguments.searches]])])
    fit = best_of(cloud)

    tell(f"profiles: {arguments.profile} values of each parameter, the others fitted again")
    values = [around(fit[k], LOW[k], HIGH[k], arguments.profile) for k in range(4)]

    def holding(k, value):
        point = fit[:4].copy()
        point[k] = value
        return point

    tasks = [(holding(k, value), k) for k in range(4) for value in values[k]]
    paths = search_all(tasks)
    cloud = np.vstack([cloud, *paths])
    if best_of(cloud)[4:].mean() < fit[4:].mean():
        cloud = np.vstack([cloud, *search_all([(best_of(cloud)[:4], None)])])
        fit = best_of(cloud)
    profiles = []
    for k in range(4):
        least = [best_of(path)[4:].mean() for path, task in zip(paths, tasks) if task[1] == k]
        rows = sorted([*zip(values[k], least), (fit[k], fit[4:].mean())])
        profiles.append((np.array([row[0] for row in rows]), np.array([row[1] for row in rows])))

    tell("the fit, with a mechanical step of 2e-6 s")
    with Crowd(trial, parameters(np.exp(fit[:4]), ratio, 2e-6)) as crowd:
        after = crowd.run(push.drive(), until=push.end, step=STEP)
    residuals = [column for each in push.residuals(after).values() for column in each.T]
    count = effective_number(residuals)
    level = fit[4:].mean() * math.sqrt(1 + 3.84 / max(1.0, count - 4))
    drawn = bootstrap(cloud, np.random.default_rng(arguments.seed))
    people = [ends_of(drawn[:, k], LOW[k], HIGH[k]) for k in range(4)]

    old, new = push.differences(before), push.differences(after)
    print(f"{len(cloud)} parameters tried, each from {len(starts)} starts; {count:.0f} effective residuals\n")
    print(f"{'':22} {'paper':>9} {'fit':>9}   {'95 % by the profile':<24} 95 % over people")
    for k, name in enumerate(NAMES):
        label = f"{name} [{UNITS[k]}]" if UNITS[k] else name
        ends = between(interval(*profiles[k], level))
        print(f"{label:22} {written(usual[k]):>9} {written(math.exp(fit[k])):>9}   {ends:<24} {between(people[k])}")
    print(f"\n{'difference [m]':22} {'paper':>9} {'fit':>9}   fitted to the other four")
    left_out = []
    for place, person in enumerate(push.people):
        others = [4 + k for k in range(len(push.people)) if k != place]
        left_out.append(cloud[np.argmin(cloud[:, others].mean(axis=1)), 4 + place])
        print(f"{f'person {person}':22} {old[person][0]:9.4f} {new[person][0]:9.4f}   {left_out[-1]:.4f}")
    means = [np.mean([each[0] for each in one.values()]) for one in (old, new)]
    print(f"{'mean':22} {means[0]:9.4f} {means[1]:9.4f}   {np.mean(left_out):.4f}")
    tell("the paper's parameters and the fit from 64 other starts")
    fresh = starts_of(trial, 65, arguments.seed + 1)[1:]
    rounded = [float(written(math.exp(value))) for value in fit[:4]]
    spread = [from_starts(trial, push, ratio, values, fresh, client) for values in (usual, rounded)]
    print(f"{'from 64 other starts':22} {spread[0].mean():9.4f} {spread[1].mean():9.4f}   mean, parameters as printed")
    print(f"{'':22} {spread[0].std():9.4f} {spread[1].std():9.4f}   standard deviation")
    print(f"{'':22} {'':9} {(spread[1] < spread[0]).mean():9.0%}   of them the fit is nearer")
    plot(arguments.plot, push, before, after, profiles, level, usual, fit, people)
    print(f"\n{arguments.plot} written")


if __name__ == "__main__":
    main()
