"""Pushes agent 0 of a crowd for 0.6 s and plots the displacement of each person.

    python examples/push_fmpy.py crowd.fmu [plot.png]

`lemons pack resources/Trial_push -o crowd.fmu` makes such a crowd.fmu.
"""

import argparse
import shutil
from math import pi, sin

import matplotlib.pyplot as plt
from fmpy import extract, instantiate_fmu, read_model_description

PEAK, DURATION, STEP, END = 1200.0, 0.6, 0.02, 2.0  # N, s, s, s

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("crowd", metavar="crowd.fmu", help="made by `lemons pack`")
parser.add_argument("plot", metavar="plot.png", nargs="?", default="push.png", help="output file; default push.png")
arguments = parser.parse_args()

description = read_model_description(arguments.crowd)
reference = {variable.name: variable.valueReference for variable in description.modelVariables}
xs = [vr for name, vr in reference.items() if name.startswith("agent[") and name.endswith("].Position.x")]

directory = extract(arguments.crowd)
crowd = instantiate_fmu(directory, description)
crowd.setupExperiment(startTime=0.0)
crowd.enterInitializationMode()
crowd.exitInitializationMode()

times, positions = [0.0], [crowd.getReal(xs)]
for k in range(round(END / STEP)):
    t = k * STEP
    crowd.setReal([reference["agent[0].Fp.x"]], [PEAK * sin(pi * t / DURATION) if t < DURATION else 0.0])
    crowd.doStep(t, STEP)
    times.append(t + STEP)
    positions.append(crowd.getReal(xs))
crowd.terminate()
crowd.freeInstance()
shutil.rmtree(directory)

figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
axes.axvspan(0, DURATION, color="0.93")
axes.text(DURATION / 2, 0.98, f"push, ≤ {PEAK:.0f} N", ha="center", va="top", transform=axes.get_xaxis_transform())
for i, x in enumerate(zip(*positions)):
    name = f"agent {i}" if i < 16 else None
    axes.plot(times, [value - x[0] for value in x], color=plt.cm.viridis(0.92 * i / len(xs)), lw=2, label=name)
axes.set(xlabel="time [s]", ylabel="displacement x(t) − x(0) [m]", title="A push goes through a crowd", xlim=(0, END))
axes.grid(alpha=0.3)
axes.spines[["top", "right"]].set_visible(False)
figure.legend(loc="outside right center", frameon=False)
figure.savefig(arguments.plot, dpi=150)
