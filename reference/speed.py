"""Compares the cost of engines for the same crowd, on one core and in turns.

    python reference/speed.py [--people 1000] [--rounds 5] [--engine NAME]...
    python reference/speed.py --people 10000 --threads 2       how many times real time: ours with one and two threads

The crowd: people of five disks, six per m2, made by `lemons crowd`, each of whom pushes with up to 500 N in a direction of its own for 1 s. It is
asked for every sixtieth of a second. The springs of LEMONS-FMU are those of a material; its step is the longest of some that keeps everybody right
to 1 mm, compared with a far shorter one. Hard bodies (Box2D, Rapier) have restitution and friction, and the step that their authors advise. Costs
are processor time of the steps alone: the median of the rounds, and the least. With --threads, ours (`human_soft`) is wall time, since threads share
the work; then nothing else should run on the machine.
"""

import argparse
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave

HERE = Path(__file__).resolve().parent
FRAMES, RIGHT = 60, 1e-3
#: [s] by material: steps that are tried, the exact one last.
STEPS = {"human_soft": [1 / 300, 1 / 360, 1 / 420, 1 / 480, 1e-3, 5e-4, 2e-5], "human_naked": [1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 1e-6]}


class Lemons:
    def __init__(self, trial, step, threads=1):
        self.name, self.step, self.threads = f"LEMONS-FMU, {trial.name}, {step:g} s", step, threads
        self.people = len(list(ElementTree.parse(trial / "static/Agents.xml").getroot()))
        fmu = trial.with_suffix(".fmu")
        if not fmu.exists():
            subprocess.run([os.environ.get("LEMONS", "lemons"), "pack", trial, "-o", fmu], check=True, capture_output=True)
        self.description = fmpy.read_model_description(str(fmu), validate=False)
        self.folder = fmpy.extract(str(fmu))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}

    def run(self):
        """Cost [s] of a second; its wall time stays in `wall`, and places in `places`."""
        identifier = self.description.coSimulation.modelIdentifier
        slave = FMU2Slave(guid=self.description.guid, unzipDirectory=self.folder, modelIdentifier=identifier, instanceName="crowd")
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.setReal([self.references["TimeStepMechanical"]], [self.step])
        slave.setInteger([self.references["Threads"]], [self.threads])
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        begun, clock = time.process_time(), time.perf_counter()
        for k in range(FRAMES):
            slave.doStep(currentCommunicationPoint=k / FRAMES, communicationStepSize=1 / FRAMES)
        cost, self.wall = time.process_time() - begun, time.perf_counter() - clock
        names = [f"agent[{k}].Position.{axis}" for k in range(self.people) for axis in "xy"]
        values = slave.getReal([self.references[name] for name in names])
        self.places = [complex(*pair) for pair in zip(values[::2], values[1::2])]
        slave.terminate()
        slave.freeInstance()
        return cost


class Hard:
    """An adapter of the reference cases; the contacts of all people are those of two of them."""

    def __init__(self, module, trial):
        self.module, self.trial, self.name = module, trial, f"{module.LABEL}, {trial.name}"

    def run(self):
        engine = self.module.Engine()
        engine.load(self.trial)
        engine.step(1.0)
        engine.state()
        engine.close()
        return engine.cost


def crowd(folder, material, people):
    side = math.sqrt(people / 6)
    trial = folder / material
    command = ["crowd", "-n", str(people), "--box", f"{side:.3f}x{side:.3f}", "--material", material, "--seed", "1", "-o", str(trial)]
    subprocess.run([os.environ.get("LEMONS", "lemons"), *command], check=True, capture_output=True)
    dynamics = trial / "dynamic/AgentDynamics.xml"
    tree, numbers = ElementTree.parse(dynamics), random.Random(1)
    for push in tree.getroot().iter("Dynamics"):
        force, angle = numbers.uniform(0, 500), numbers.uniform(0, 2 * math.pi)
        push.set("Fp", f"{force * math.cos(angle)!r},{force * math.sin(angle)!r}")
    tree.write(dynamics)
    return trial


def longest(trial):
    """The longest step that is right, else the shortest of them; its errors [m]: of nine of ten people, and the greatest."""
    *steps, exact = STEPS[trial.name]
    reference = Lemons(trial, exact)
    reference.run()
    for step in steps:
        engine = Lemons(trial, step)
        engine.run()
        errors = sorted(abs(a - b) for a, b in zip(engine.places, reference.places))
        if errors[-1] <= RIGHT:
            break
    return engine, errors[len(errors) * 9 // 10], errors[-1]


def real_time(trial, threads, rounds, hard):
    """Says how many times real time a crowd is: ours with the step that is right for a thousand people, hard bodies with one thread."""
    engines = [Lemons(trial, 1 / 420, count) for count in sorted({1, threads})] + hard
    found = [[] for _ in engines]
    for _ in range(rounds):
        for engine, costs in zip(engines, found):
            cost = engine.run()
            costs.append((1 / getattr(engine, "wall", cost), cost))
    print(f"{engines[0].people} people, {rounds} rounds: times real time, median and best, and processor time of all threads for a second [s]")
    for engine, costs in zip(engines, found):
        paces, cost = [pace for pace, _ in costs], statistics.median(cost for _, cost in costs)
        name = f"{engine.name}, {getattr(engine, 'threads', 1)} threads"
        print(f"{name:50} {statistics.median(paces):6.2f} {max(paces):6.2f} {cost:6.2f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--people", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--engine", action="append")
    parser.add_argument("--threads", type=int)
    arguments = parser.parse_args()
    sys.path[:0] = [str(HERE), str(HERE / "adapters")]
    import rigid
    from run import installed

    rigid.WITHIN = 0.05

    with tempfile.TemporaryDirectory() as folder:
        modules = installed(["box2d", "rapier"] if arguments.engine is None else arguments.engine)
        if arguments.threads:
            trial = crowd(Path(folder), "human_soft", arguments.people)
            real_time(trial, arguments.threads, arguments.rounds, [Hard(module, trial) for module in modules.values()])
            return
        trials = [crowd(Path(folder), material, arguments.people) for material in STEPS]
        engines = []
        for trial in trials:
            engine, most_of_them, greatest = longest(trial)
            right = "" if greatest <= RIGHT else ": no step of these is right"
            print(f"{engine.name}: error of nine of ten {1e3 * most_of_them:.3f} mm, greatest {1e3 * greatest:.3f} mm{right}", flush=True)
            engines.append(engine)
        engines += [Hard(module, trials[-1]) for module in modules.values()]
        costs = {engine.name: [] for engine in engines}
        for _ in range(arguments.rounds):
            for engine in engines:
                costs[engine.name].append(engine.run() * 1e6 / arguments.people / FRAMES)
        print(f"\n{arguments.people} people: processor time per person and 1/60 s [us], median and least of {arguments.rounds}")
        for name, found in costs.items():
            print(f"{name:40} {statistics.median(found):8.2f} {min(found):8.2f}")


if __name__ == "__main__":
    main()
