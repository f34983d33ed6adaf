"""Speed and reach of a push through a row of five people, as functions of stiffness, friction and mass.

    pip install './python[sweep]' matplotlib
    python examples/sweep_push.py resources/Trial_push [--plot sweep_push.png] [--out DIR] [--scheduler ADDRESS]

Person 0 is pushed by half a sine of 0.6 s with a peak of 900, 1200 or 1500 N. One parameter at a time is
changed from its value in the Trial: the stiffness of all bodies (Young's and shear modulus times the same factor), their friction, or
the mass of all people (with the moment of inertia). The results of each run are

    speed   of the front [m/s]: a person is reached when the velocity along the push first exceeds 0.05 m/s; the speed is the
            slope of a least-squares line through the start positions as a function of these times, for all people who were
            reached; missing if fewer than two were (it jumps when the number of people who were reached changes)
    reach   number of people whom the push displaced by 0.05 m or more along x at any time
    last    largest displacement of the last person of the row [m]; the wall is 0.16 m away
    mean    the largest mean squeeze of a person over a communication step, 0.01 s [N]
    peak    the largest squeeze of a person at any time [N]: it is larger than the mean, because collisions last milliseconds

With --out, the results are kept in a directory, a table for each push, and a second call continues where the first was stopped. With --scheduler (see
examples/sweep_cluster.md) a cluster does the runs.
"""

import argparse
import contextlib
import os

import numpy as np
import pandas as pd
from distributed import Client
from lemons_fmu import CommandError, Crowd, Drive, SweepError, local_cluster, sweep

PEAKS = [900.0, 1200.0, 1500.0]  # N
DURATION, UNTIL, STEP = 0.6, 3.0, 0.01  # s
MECHANICAL = 1e-5  # s; with 2e-6 s the speeds differ by less than 0.1 %, the displacements by less than 0.3 mm
MEASURES = ["speed", "reach", "last", "mean", "peak"]
REACHED, DISPLACED = 0.05, 0.05  # m/s, m
COLOURS = ["#0072B2", "#E69F00", "#D55E00"]  # Okabe and Ito


def half_sine(peak):
    times = np.linspace(0, DURATION, 61)
    zero = np.zeros_like(times)
    return Drive({0: (times, np.column_stack([peak * np.sin(np.pi * times / DURATION), zero, zero]))}, at="middle")


def front(run):
    start, velocity = run.poses[0, :, 0], run.velocities[:, :, 0]
    moved = (run.poses[:, :, 0] - start).max(axis=0)
    places, times = [], []
    for person in range(velocity.shape[1]):
        k = int(np.argmax(velocity[:, person] > REACHED))
        if k > 0:
            share = (REACHED - velocity[k - 1, person]) / (velocity[k, person] - velocity[k - 1, person])
            places.append(start[person])
            times.append(run.times[k - 1] + share * (run.times[k] - run.times[k - 1]))
    speed = np.polyfit(times, places, 1)[0] if len(places) > 1 and np.ptp(times) > 0 else np.nan
    squeeze = {"mean": run.mean_squeeze.max(), "peak": run.peak_squeeze.max()}
    return {"speed": speed, "reach": (moved >= DISPLACED).sum(), "last": moved[-1], **squeeze}


def table(trial, count):
    """Returns a row for each run: the changed parameter, its factor or value, and the parameters of the FMU."""
    with Crowd(trial) as crowd:
        usual = {name: crowd[name] for name in crowd.variables}
    bodies = sorted({name.split(".")[1] for name in usual if name.startswith("material.")} - {"concrete"})
    friction = [n for n in usual if n.endswith(".KineticFriction") and "concrete" not in n]
    moduli = [n for n in usual if n.split(".")[0] == "material" and n.split(".")[1] in bodies]
    inertia = [n for n in usual if n.endswith((".Mass", ".MomentOfInertia"))]
    rows = []
    values = {
        "stiffness": np.geomspace(0.25, 4, count),
        "friction": np.linspace(0, 0.8, count),
        "mass": np.linspace(0.6, 1.6, count),
    }
    for changed, each in values.items():
        for value in each:
            row = {name: usual[name] for name in moduli + friction + inertia}
            for name in {"stiffness": moduli, "friction": friction, "mass": inertia}[changed]:
                row[name] = value if changed == "friction" else value * usual[name]
            rows.append({"changed": changed, "value": value, "TimeStepMechanical": MECHANICAL, **row})
    usual_friction = usual["contact.human_naked.human_naked.KineticFriction"]
    return pd.DataFrame(rows), {"stiffness": 1.0, "friction": usual_friction, "mass": 1.0}


def plot(path, results, usual):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    names = {"stiffness": "stiffness / that of the paper", "friction": "friction between people", "mass": "mass / that of the Trial"}
    units = {"last": 100, "peak": 1e-3}
    rows = {"speed": "speed of the front\n/ m s$^{-1}$", "reach": "people displaced\nby 5 cm or more", "last": "displacement of\nthe last / cm", "peak": "peak squeeze\n/ kN"}
    figure, panels = plt.subplots(4, 3, figsize=(9.5, 9), sharex="col", sharey="row", layout="constrained")
    for column, (changed, label) in enumerate(names.items()):
        for row, (measure, axis) in enumerate(rows.items()):
            panel = panels[row, column]
            panel.axvline(usual[changed], color="0.8", zorder=0)
            for shift, (colour, peak) in enumerate(zip(COLOURS, PEAKS)):
                some = results[(results.changed == changed) & (results.push == peak)]
                values = some[measure] * units.get(measure, 1)
                # Draw equal counts beside each other.
                values = values + (0.05 * (shift - 1) if measure == "reach" else 0)
                panel.plot(some.value, values, "o-", color=colour, markersize=4, linewidth=1.5, label=f"{peak:.0f} N")
            if changed == "stiffness":
                panel.set_xscale("log", base=2)
                panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
            if column == 0:
                panel.set_ylabel(axis)
            if row == 3:
                panel.set_xlabel(label)
            panel.grid(alpha=0.25)
            panel.spines[["top", "right"]].set_visible(False)
    for row in (0, 2, 3):
        panels[row, 0].set_ylim(bottom=0)
    panels[1, 0].set_ylim(0, 5.4)
    panels[1, 0].set_yticks(range(6))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, title="peak of the push", loc="outside right upper", frameon=False)
    figure.suptitle("A push through a row of five people")
    figure.align_ylabels()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trial", metavar="TRIAL", help="resources/Trial_push, or one like it")
    parser.add_argument("--plot", default="sweep_push.png", metavar="FILE.png", help="output file; default sweep_push.png")
    parser.add_argument("--out", metavar="DIR", help="keep the results in this directory as they come")
    parser.add_argument("--values", type=int, default=11, metavar="N", help="number of values of each of the three parameters; default 11")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="address of a Dask scheduler; default: use the cores of this machine")
    arguments = parser.parse_args()
    if arguments.values < 1:
        parser.error("--values: must be at least 1")
    try:
        points, usual = table(arguments.trial, arguments.values)
    except (CommandError, KeyError) as error:
        raise SystemExit(f"{arguments.trial}: {error}; the Trial must be like resources/Trial_push")

    parameters = points.drop(columns=["changed", "value"])
    parts = []
    with contextlib.ExitStack() as stack:
        # The three sweeps share the workers.
        client = stack.enter_context(Client(arguments.scheduler or stack.enter_context(local_cluster())))
        for peak in PEAKS:
            out = arguments.out and os.path.join(arguments.out, f"peak_{peak:.0f}.csv")
            try:
                result = sweep(arguments.trial, parameters, half_sine(peak), front, until=UNTIL, step=STEP, out=out, client=client)
            except (SweepError, OSError) as error:
                raise SystemExit(str(error))
            for message in result.error.dropna().unique():
                print(f"failed: {message}")
            parts.append(points[["changed", "value"]].join(result[MEASURES]).assign(push=peak))
    results = pd.concat(parts, ignore_index=True)
    for changed in ("stiffness", "friction", "mass"):
        some = results[results.changed == changed].pivot(index="value", columns="push", values=MEASURES)
        print(f"\n{changed}\n{some.to_string(float_format='{:.3g}'.format)}")
    plot(arguments.plot, results, usual)
    print(f"\n{arguments.plot} written")


if __name__ == "__main__":
    main()
