"""Thirty people leave a room: Decision computes their drives, CrowdMechanics their motion.

    python examples/coupled_fmpy.py decision.fmu crowd.fmu [flow.png]

`lemons decide resources/Trial_door -o decision.fmu` and `lemons pack resources/Trial_door -o crowd.fmu` make the two FMUs.
Prints the time when each person has passed the door, and draws the flow.
"""

import argparse
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

STEP, END, DOOR = 0.05, 60.0, 5.2  # s, s, m: the door's far side

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("decision", metavar="decision.fmu", help="drives of people, made by `lemons decide`")
parser.add_argument("crowd", metavar="crowd.fmu", help="motion of people, made by `lemons pack`")
parser.add_argument("picture", metavar="flow.png", nargs="?", default="flow.png", help="output file; default flow.png")
arguments = parser.parse_args()


class Component:
    """An FMU and its instance, with value references by name."""

    def __init__(self, fmu):
        self.fmu = fmu
        self.description = read_model_description(fmu)
        self.reference = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.outputs = {v.name for v in self.description.modelVariables if v.causality == "output" and v.type == "Real"}
        self.inputs = {v.name for v in self.description.modelVariables if v.causality == "input"}

    def start(self):
        self.directory = extract(self.fmu)
        self.slave = instantiate_fmu(self.directory, self.description)
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def references(self, names):
        return [self.reference[name] for name in names]

    def free(self):
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.directory)


decision, crowd = Component(arguments.decision), Component(arguments.crowd)
names = sorted(crowd.outputs & decision.inputs), sorted(decision.outputs & crowd.inputs)
poses = crowd.references(names[0]), decision.references(names[0])
drives = decision.references(names[1]), crowd.references(names[1])
people = sum(name.endswith("].Fp.x") for name in names[1])
if not people:
    sys.exit(f"{decision.fmu} drives nobody of {crowd.fmu}: no agent[…].Fp.x in common; decision.fmu first, then crowd.fmu")
places = crowd.references(f"agent[{i}].Position.{axis}" for i in range(people) for axis in "xy")


def exchange():
    """Sets poses first: the drives follow from them immediately."""
    decision.slave.setReal(poses[1], crowd.slave.getReal(poses[0]))
    crowd.slave.setReal(drives[1], decision.slave.getReal(drives[0]))


decision.start()
crowd.start()
exchange()
decision.slave.exitInitializationMode()
crowd.slave.exitInitializationMode()

paths, left = [np.reshape(crowd.slave.getReal(places), (people, 2))], {}
for k in range(round(END / STEP)):
    exchange()
    for component in (decision, crowd):
        component.slave.doStep(k * STEP, STEP)
    paths.append(np.reshape(crowd.slave.getReal(places), (people, 2)))
    for i in np.flatnonzero(paths[-1][:, 0] > DOOR):
        left.setdefault(int(i), (k + 1) * STEP)
    if len(left) == people:
        break

print(f"{len(left)} of {people} people have passed the door")
print(" nth  agent  time [s]")
for n, (i, time) in enumerate(left.items(), start=1):
    print(f"{n:4}  {i:5}  {time:8.2f}")

last = max(left.values(), default=END)
figure, (plan, flow) = plt.subplots(2, figsize=(7.5, 6.4), height_ratios=[3, 2], layout="constrained")
geometry = next((Path(crowd.directory) / "resources").glob("*/static/Geometry.xml"))
for wall in ET.parse(geometry).iter("Wall"):
    plan.plot(*zip(*(map(float, corner.get("Coordinates").split(",")) for corner in wall)), color="0.2", lw=2)
for i, path in enumerate(np.transpose(paths, (1, 0, 2))):
    plan.plot(*path.T, color=plt.cm.viridis(left.get(i, END) / last), lw=0.9)
colours = plt.cm.ScalarMappable(plt.Normalize(0, last), "viridis")
figure.colorbar(colours, ax=plan, label="passes the door at [s]")
plan.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"{people} people leave a room", xlim=(-0.3, 9))
flow.step([0, *left.values()], range(len(left) + 1), where="post", color=plt.cm.viridis(0.3), lw=2)
flow.set(xlabel="time [s]", ylabel="have passed the door", xlim=0, ylim=0)
flow.grid(alpha=0.3)
for axes in plan, flow:
    axes.spines[["top", "right"]].set_visible(False)
figure.savefig(arguments.picture, dpi=150)
decision.free()
crowd.free()
