"""People walk to a target, more slowly when they are squeezed: an FMU that drives the crowd's FMU.

    pip install pythonfmu
    pythonfmu build -f examples/controllers/cautious.py resources/Trial_push/static/Agents.xml
    lemons pack resources/Trial_push -o crowd.fmu

This makes Cautious.fmu for the five people of that Agents.xml, which is packed with it. Its inputs have the names of the
crowd's outputs, and its outputs the names of the crowd's inputs: a master connects `crowd.NAME` with `controller.NAME`.

It uses the mean squeeze over the last communication step. The squeeze at the communication point, NormalForce, depends on
the instant, because collisions last milliseconds. (A crowd.fmu of the first versions has no
MeanNormalForce: pack its Trial again.)
"""

from math import atan2, hypot, pi, remainder
from pathlib import Path
from xml.etree import ElementTree

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

TURNING = 2.0  # 1/s: a person at an angle to the target turns with the angular velocity TURNING * angle
ARRIVING = 1.0  # 1/s: at a distance d the speed is at most ARRIVING * d, so that people do not run past the target

STATE = ["Position.x", "Position.y", "Theta", "MeanNormalForce"]  # m, m, rad, N
DRIVE = ["Fp.x", "Fp.y", "Mp"]  # N, N, N.m
BODY = ["Mass", "MomentOfInertia", "FloorDamping", "AngularDamping"]  # kg, kg.m2, 1/s, 1/s


class Cautious(Fmi2Slave):
    description = "walks people to a target, more slowly when they are squeezed"

    def __init__(self, **arguments):
        super().__init__(**arguments)
        # `self.resources` is the directory for the files named after the script, both when it builds and when it runs.
        agents = ElementTree.parse(Path(self.resources) / "Agents.xml").getroot()
        self.bodies = [{name: float(agent.get(name)) for name in BODY} for agent in agents]

        self.parameters = {"Target.x": 1.4, "Target.y": 0.0, "WalkingSpeed": 1.2, "ToleratedForce": 200.0}
        for name in self.parameters:  # m, m, m/s, N
            self.add(name, self.parameters, name, Fmi2Causality.parameter, variability=Fmi2Variability.tunable)

        # Nobody walks before the first step, because positions are not known earlier.
        self.people = [dict.fromkeys([*STATE, *DRIVE], 0.0) for _ in self.bodies]
        for i, person in enumerate(self.people):
            for name in STATE:
                self.add(f"agent[{i}].{name}", person, name, Fmi2Causality.input)
            for name in DRIVE:
                self.add(f"agent[{i}].{name}", person, name, Fmi2Causality.output, initial=Fmi2Initial.exact)

    def add(self, name, store, key, causality, **attributes):
        """Adds a variable whose value is `store[key]`."""

        def get():
            return store[key]

        def put(value):
            store[key] = value

        self.register_variable(Real(name, causality=causality, getter=get, setter=put, **attributes), nested=False)

    def do_step(self, time, step):
        """Computes from the state at `time` the drive from `time + step` on."""
        for body, person in zip(self.bodies, self.people):
            x = self.parameters["Target.x"] - person["Position.x"]
            y = self.parameters["Target.y"] - person["Position.y"]
            distance = hypot(x, y)
            if distance == 0.0:
                person.update(dict.fromkeys(DRIVE, 0.0))
                continue
            speed = min(self.parameters["WalkingSpeed"], ARRIVING * distance)
            # Half as fast at the tolerated force, a third as fast at twice the force.
            speed /= 1.0 + person["MeanNormalForce"] / self.parameters["ToleratedForce"]
            # Without contacts a person reaches the velocity Fp / (m * FloorDamping) and the angular velocity Mp / (I * AngularDamping).
            force = body["Mass"] * body["FloorDamping"] * speed
            person["Fp.x"], person["Fp.y"] = force * x / distance, force * y / distance
            angle = remainder(atan2(y, x) - person["Theta"], 2.0 * pi)
            person["Mp"] = body["MomentOfInertia"] * body["AngularDamping"] * TURNING * angle
        return True
