"""Compares measured with simulated head displacements: a push goes through a row of five people.

    pip install ./python matplotlib
    python examples/feldmann_push.py [DATA_DIR] [--fmu FILE] [--plot FILE.png] [--until T]

The experiment is that of Feldmann, Adrian and Boltes (2024), as in the paper's practical case (section 4.5). DATA_DIR contains
    Trial/                          the Trial (unless --fmu gives its FMU)
    external_force_per_mass.txt     TimeS ForcePerMassNperM: the recorded push on agent 0 per unit of mass [s], [N/kg]
    measured_head_trajectories.csv  t,id,x,y: displacement of each head from its start, x along the push [s], [m]
To get the data: the paper's public data (LEMONS, data/tutorial_mechanical_layer/push_Feldmann/Wed_03…) contain the push under
the same name; write the head trajectories as such a table.

The script compares displacements from the start in the plane (x and y), at the measured times until --until. For each person it
prints the root-mean-square distance between measured and simulated, then the mean of the five; also for the direction of the push
alone (x). By 4 s the push is over and its record ends. Afterwards the people walk back to their places, which is not simulated. The
result depends on this window: over the whole 6 s the mean is 0.142 m.
"""

import argparse
import pathlib

import matplotlib
import numpy as np
from lemons_fmu import CommandError, Crowd, SimulationError
from lemons_fmu.push import STEP, UNTIL, Push

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data" / "push_wed"
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"]  # Okabe and Ito: distinguishable for colour-blind people


def plot(path, experiment, run, rms, until):
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.lines import Line2D

    times, moved = run.times, run.poses - run.poses[0]
    figure, (top, axes) = plt.subplots(2, 1, figsize=(8.5, 6.4), sharex=True, height_ratios=[1, 4.5], layout="constrained")
    top.fill_between(*experiment.push, color="0.6", linewidth=0)
    top.set_ylabel("push / mass\n/ N kg$^{-1}$")
    top.set_ylim(bottom=0)
    for k, (person, rows) in enumerate(experiment.heads.items()):
        colour = COLOURS[k % len(COLOURS)]
        axes.plot(rows[:, 0], rows[:, 1] - rows[0, 1], "--", color=colour, linewidth=1.4)
        axes.plot(times, moved[:, person, 0], "-", color=colour, linewidth=1.8)
    if until < times[-1]:
        axes.axvspan(until, times[-1], color="0.93", zorder=0, linewidth=0)
        axes.text((until + times[-1]) / 2 + 0.15, 0.73, "people walk back\n(not modelled, not compared)", transform=axes.get_xaxis_transform(), ha="center", color="0.35")
    axes.set_xlabel("time / s")
    axes.set_ylabel("displacement along the push / m")
    axes.set_xlim(0, times[-1])
    people = [Line2D([], [], color=COLOURS[k % len(COLOURS)], linewidth=3, label=f"person {p}: {100 * rms[p][0]:.1f} cm") for k, p in enumerate(experiment.heads)]
    first = axes.legend(handles=people, loc="upper left", frameon=False, title="rms difference in the plane", alignment="left")
    axes.add_artist(first)
    kinds = [Line2D([], [], color="0.3", linestyle="--", label="measured (head)"), Line2D([], [], color="0.3", label="simulated (centre of mass)")]
    axes.legend(handles=kinds, loc="center left", bbox_to_anchor=(0, 0.5), frameon=False)
    for each in (top, axes):
        each.spines[["top", "right"]].set_visible(False)
        each.grid(alpha=0.25)
    figure.suptitle("A push on person 0 goes through a row of five people")
    figure.align_ylabels()
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="?", type=pathlib.Path, default=DATA, metavar="DATA_DIR", help="the experiment; default ../shared/data/push_wed")
    parser.add_argument("--fmu", metavar="FILE", help="the FMU of a crowd, whose Trial is simulated; default: the Trial in DATA_DIR")
    parser.add_argument("--until", type=float, default=UNTIL, metavar="T", help="end of the comparison [s]; default 4")
    parser.add_argument("--plot", default="feldmann_push.png", metavar="FILE.png", help="output file; default feldmann_push.png")
    arguments = parser.parse_args()
    if not arguments.data.is_dir():
        raise SystemExit(f"{arguments.data}: no such directory; give the directory of the data as first argument (see --help)")

    try:
        experiment = Push.read(arguments.data)
        with Crowd(arguments.fmu or arguments.data / "Trial") as crowd:
            run = crowd.run(experiment.drive(), until=experiment.end, step=STEP)
    except (CommandError, SimulationError, ValueError, OSError) as error:
        raise SystemExit(str(error))

    rms = experiment.differences(run, arguments.until)
    print(f"root-mean-square difference of the displacement from the start, at the measured times up to {arguments.until:g} s")
    print("            in the plane   along the push")
    for person, (plane, along) in rms.items():
        print(f"  person {person}    {plane:.4f} m        {along:.4f} m")
    plane, along = np.mean(list(rms.values()), axis=0)
    print(f"  mean        {plane:.4f} m        {along:.4f} m")
    plot(arguments.plot, experiment, run, rms, arguments.until)
    print(f"{arguments.plot} written")


if __name__ == "__main__":
    main()
