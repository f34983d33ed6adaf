"""A push goes through a row of five people: measured head displacements against simulated ones.

    python examples/feldmann_push.py [DATA_DIR] [--fmu FILE] [--plot FILE.png] [--until T]

The experiment is that of Feldmann, Adrian and Boltes (2024), as in the paper's practical case (section 4.5). DATA_DIR holds
    Trial/                          the Trial (packed with `lemons pack`, unless --fmu gives its FMU)
    external_force_per_mass.txt     TimeS ForcePerMassNperM: the recorded push on agent 0 per unit of mass [s], [N/kg]
    measured_head_trajectories.csv  t,id,x,y: displacement of each head from its start, x along the push [s], [m]
Your own copy: the paper's public data (LEMONS, data/tutorial_mechanical_layer/push_Feldmann/Wed_03…) holds the push under the
same name; write the head trajectories as that table.

Compared is the displacement in the plane (x and y), each from its own start, at the measured times: for each person the root of the
mean squared distance between measured and simulated, until --until; then the mean of the five. Along the push alone (x) is printed too.
By 4 s the push is over and its record ends; then the people walk back to their places, and nothing here models that. The number depends
on this window: over the whole 6 s the mean is 0.142 m.
"""

import argparse
import csv
import os
import pathlib
import shutil
import subprocess
import tempfile

import fmpy
import matplotlib
import numpy as np
from fmpy.fmi2 import FMU2Slave

ROOT = pathlib.Path(__file__).resolve().parent.parent
STEP = 0.01  # [s] communication step: the push is given every 0.029 s and interpolated
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"]  # Okabe and Ito: distinct for the colour-blind too


def read_push(path):
    """Times [s] and push per unit of mass [N/kg]."""
    return np.loadtxt(path, skiprows=1, unpack=True)


def read_measured(path):
    """person -> columns t [s], x, y [m]"""
    people = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            people.setdefault(int(row["id"]), []).append([float(row[name]) for name in ("t", "x", "y")])
    return {person: np.array(rows) for person, rows in sorted(people.items())}


def pack(trial, fmu):
    command = os.environ.get("LEMONS") or ROOT / "target" / "release" / "lemons"
    if not pathlib.Path(command).exists():
        raise SystemExit(f"{command} is missing: cargo build --release, or give --fmu")
    subprocess.run([command, "pack", trial, "-o", fmu], check=True, stdout=subprocess.DEVNULL)


def simulate(fmu, push, people, until):
    """Times, and displacement (x, y) of each person from the start [m], as arrays [time] and [time, person, 2]."""
    description = fmpy.read_model_description(fmu)
    references = {v.name: v.valueReference for v in description.modelVariables}
    outputs = [references[f"agent[{k}].Position.{axis}"] for k in people for axis in "xy"]
    directory = fmpy.extract(fmu)
    slave = FMU2Slave(guid=description.guid, unzipDirectory=directory, modelIdentifier=description.coSimulation.modelIdentifier, instanceName="push")
    try:
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        mass = slave.getReal([references["agent[0].Mass"]])[0]
        times = np.arange(round(until / STEP) + 1) * STEP
        places = [slave.getReal(outputs)]
        for t in times[:-1]:
            middle = t + STEP / 2  # the push is held over the step: its value in the middle
            slave.setReal([references["agent[0].Fp.x"]], [mass * np.interp(middle, *push, left=0, right=0)])
            slave.doStep(currentCommunicationPoint=t, communicationStepSize=STEP)
            places.append(slave.getReal(outputs))
        slave.terminate()
        slave.freeInstance()
    finally:
        shutil.rmtree(directory, ignore_errors=True)
    places = np.array(places).reshape(len(times), len(people), 2)
    return times, places - places[0]


def differences(measured, times, moved, until):
    """Root-mean-square differences of the displacement, person by person: (in the plane, along the push) [m]."""
    out = {}
    for k, (person, rows) in enumerate(measured.items()):
        rows = rows[rows[:, 0] <= until + 1e-9]
        simulated = np.stack([np.interp(rows[:, 0], times, moved[:, k, axis]) for axis in (0, 1)], axis=1)
        squares = ((simulated - (rows[:, 1:] - rows[0, 1:])) ** 2).mean(axis=0)
        out[person] = (float(np.sqrt(squares.sum())), float(np.sqrt(squares[0])))
    return out


def plot(path, measured, times, moved, rms, push, until):
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.lines import Line2D

    figure, (top, axes) = plt.subplots(2, 1, figsize=(8.5, 6.4), sharex=True, height_ratios=[1, 4.5], layout="constrained")
    top.fill_between(*push, color="0.6", linewidth=0)
    top.set_ylabel("push / mass\n/ N kg$^{-1}$")
    top.set_ylim(bottom=0)
    for k, (person, rows) in enumerate(measured.items()):
        colour = COLOURS[k % len(COLOURS)]
        axes.plot(rows[:, 0], rows[:, 1] - rows[0, 1], "--", color=colour, linewidth=1.4)
        axes.plot(times, moved[:, k, 0], "-", color=colour, linewidth=1.8)
    if until < times[-1]:
        axes.axvspan(until, times[-1], color="0.93", zorder=0, linewidth=0)
        axes.text((until + times[-1]) / 2 + 0.15, 0.73, "people walk back\n(not modelled, not compared)", transform=axes.get_xaxis_transform(), ha="center", color="0.35")
    axes.set_xlabel("time / s")
    axes.set_ylabel("displacement along the push / m")
    axes.set_xlim(0, times[-1])
    people = [Line2D([], [], color=COLOURS[k % len(COLOURS)], linewidth=3, label=f"person {p}: {100 * rms[p][0]:.1f} cm") for k, p in enumerate(measured)]
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
    parser.add_argument("data", nargs="?", type=pathlib.Path, default=ROOT.parent / "shared" / "data" / "push_wed", metavar="DATA_DIR")
    parser.add_argument("--fmu", help="the packed Trial")
    parser.add_argument("--until", type=float, default=4.0, metavar="T", help="the differences are taken up to this time [s]; default 4")
    parser.add_argument("--plot", default="feldmann_push.png", metavar="FILE.png")
    arguments = parser.parse_args()
    if not arguments.data.is_dir():
        raise SystemExit(f"{arguments.data}: no such directory; give the directory of the data as first argument (see --help)")

    push = read_push(arguments.data / "external_force_per_mass.txt")
    measured = read_measured(arguments.data / "measured_head_trajectories.csv")
    end = max(rows[-1, 0] for rows in measured.values())
    with tempfile.TemporaryDirectory() as scratch:
        fmu = arguments.fmu
        if not fmu:
            fmu = os.path.join(scratch, "push.fmu")
            pack(arguments.data / "Trial", fmu)
        times, moved = simulate(fmu, push, list(measured), end)

    rms = differences(measured, times, moved, arguments.until)
    print(f"root-mean-square difference of the displacement from the start, at the measured times up to {arguments.until:g} s")
    print("            in the plane   along the push")
    for person, (plane, along) in rms.items():
        print(f"  person {person}    {plane:.4f} m        {along:.4f} m")
    plane, along = np.mean(list(rms.values()), axis=0)
    print(f"  mean        {plane:.4f} m        {along:.4f} m")
    plot(arguments.plot, measured, times, moved, rms, push, arguments.until)
    print(f"{arguments.plot} written")


if __name__ == "__main__":
    main()
