"""The controller of cautious.py in FMI 3.0: people walk to a target, more slowly when they are squeezed.

    pip install pythonfmu3 numpy
    pythonfmu3 build -f examples/controllers/cautious3.py resources/Trial_push/static/Agents.xml
    lemons pack resources/Trial_push --fmi 3 -o crowd.fmu

This makes Cautious3.fmu for the five people of that Agents.xml. Its arrays have the names and the shapes of the crowd's, so
`lemons connect` connects them whole. How their size is called is of no importance: here People, in the crowd Agents.
"""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pythonfmu3 import Dimension, Fmi3Causality, Fmi3Initial, Fmi3Slave, Fmi3Variability, Float64, UInt64

TARGET = np.array([1.4, 0.0])  # m
SPEED = 1.2  # m/s, if nobody presses; in the last metres 1 m/s per metre from the target
TOLERATED = 200.0  # N: with this mean squeeze people walk half as fast


class Cautious3(Fmi3Slave):
    def __init__(self, **arguments):
        super().__init__(**arguments)
        agents = ElementTree.parse(Path(self.resources) / "Agents.xml").getroot()
        self.resistance = np.array([float(a.get("Mass")) * float(a.get("FloorDamping")) for a in agents])  # kg/s
        self.time = 0.0
        self.People = len(agents)
        self.Position = np.zeros((self.People, 2))  # m
        self.MeanNormalForce = np.zeros(self.People)  # N
        self.Fp = np.zeros((self.People, 2))  # N; nobody walks before the first step

        independent = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        self.register_variable(Float64("time", **independent))
        size = {"causality": Fmi3Causality.structuralParameter, "variability": Fmi3Variability.fixed}
        people = UInt64("People", **size, start=self.People)
        self.register_variable(people)
        each = Dimension(valueReference=str(people.value_reference))
        vector = [each, Dimension(start="2")]
        inputs = {"causality": Fmi3Causality.input, "variability": Fmi3Variability.continuous}
        outputs = {"causality": Fmi3Causality.output, "variability": Fmi3Variability.continuous, "initial": Fmi3Initial.exact}
        self.register_variable(Float64("Position", **inputs, dimensions=vector))
        self.register_variable(Float64("MeanNormalForce", **inputs, dimensions=[each]))
        self.register_variable(Float64("Fp", **outputs, dimensions=vector))

    def do_step(self, time, step):
        """Computes from the state at `time` the drive from `time + step` on."""
        way = TARGET - self.Position
        distance = np.linalg.norm(way, axis=1)
        speed = np.minimum(SPEED, distance) / (1.0 + self.MeanNormalForce / TOLERATED)
        self.Fp = way * (self.resistance * speed / np.maximum(distance, 1e-9))[:, None]
        return True
