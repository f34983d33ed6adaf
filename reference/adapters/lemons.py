"""LEMONS-FMU: the FMU of the Trial, by FMPy. Needs the command `lemons` (or its path in the variable LEMONS) and `pip install fmpy`.

The step: what `lemons crowd` writes, 1e-4 s.
"""

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from law import Scene

LABEL = "LEMONS"
STEP = 1e-4  # [s]
OUTPUTS = {"x": "Position.x", "y": "Position.y", "theta": "Theta", "vx": "Velocity.x", "vy": "Velocity.y", "omega": "Omega", "wall": "MeanWallForce"}


class Engine:
    def load(self, trial, refine=1):
        self.folder = tempfile.mkdtemp()
        fmu = Path(self.folder, "case.fmu")
        command = [os.environ.get("LEMONS", "lemons"), "pack", trial, "-o", fmu]
        subprocess.run(command, check=True, capture_output=True, text=True)
        description = fmpy.read_model_description(str(fmu), validate=False)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.ids = Scene(trial).ids
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(fmu), str(Path(self.folder, "fmu"))),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="case",
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.setReal([self.references["TimeStepMechanical"]], [STEP / refine])
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.now = self.cost = 0.0

    def force(self, name, fp, mp):
        body = f"agent[{self.ids.index(name)}]"
        self.slave.setReal([self.references[f"{body}.{what}"] for what in ("Fp.x", "Fp.y", "Mp")], [*fp, mp])

    def step(self, t):
        steps, rest = max(1, round((t - self.now) / 0.01)), t - self.now
        before = time.process_time()
        for k in range(steps):
            self.slave.doStep(currentCommunicationPoint=self.now + k * rest / steps, communicationStepSize=rest / steps)
        self.cost += time.process_time() - before
        self.now = t

    def state(self):
        names = [f"agent[{k}].{output}" for k in range(len(self.ids)) for output in OUTPUTS.values()]
        values = self.slave.getReal([self.references[name] for name in names])
        rows = zip(*[iter(values)] * len(OUTPUTS))
        return {name: dict(zip(OUTPUTS, row)) for name, row in zip(self.ids, rows)}

    def close(self):
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)
