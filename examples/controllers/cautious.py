"""People walk to one target, and the more slowly the harder they are squeezed: an FMU that drives the crowd's FMU.

    pip install pythonfmu
    pythonfmu build -f examples/controllers/cautious.py resources/Trial_push/static/Agents.xml
    lemons pack resources/Trial_push -o crowd.fmu

makes Cautious.fmu for the five people of that Agents.xml, which is packed with it. Its inputs are named like the
crowd's outputs and its outputs like the crowd's inputs: a master connects `crowd.NAME` with `controller.NAME`.

Squeeze is the mean over the last communication step. Its value at the communication point, NormalForce, hangs on which
instant of a collision, which lasts milliseconds, that happens to be. (A crowd.fmu of the first versions has no
MeanNormalForce: pack its Trial again.)
"""

from math import atan2, hypot, pi, remainder
from pathlib import Path
from xml.etree import ElementTree

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

TURNING = 2.0  # 1/s: somebody who faces away by an angle turns towards the target at TURNING * angle
ARRIVING = 1.0  # 1/s: at a distance d the speed is at most ARRIVING * d, so that nobody runs past the target

STATE = ["Position.x", "Position.y", "Theta", "MeanNormalForce"]  # m, m, rad, N
DRIVE = ["Fp.x", "Fp.y", "Mp"]  # N, N, N.m
BODY = ["Mass", "MomentOfInertia", "FloorDamping", "AngularDamping"]  # kg, kg.m2, 1/s, 1/s


class Cautious(Fmi2Slave):
    description = "walks people to a target, more slowly when they are squeezed"

    def __init__(self, **arguments):
        super().__init__(**arguments)
        # `self.resources` is where pythonfmu puts the files named after the script: when it builds and when it runs.
        agents = ElementTree.parse(Path(self.resources) / "Agents.xml").getroot()
        self.bodies = [{name: float(agent.get(name)) for name in BODY} for agent in agents]

        self.parameters = {"Target.x": 1.4, "Target.y": 0.0, "WalkingSpeed": 1.2, "ToleratedForce": 200.0}
        for name in self.parameters:  # m, m, m/s, N
            self.add(name, self.parameters, name, Fmi2Causality.parameter, variability=Fmi2Variability.tunable)

        # Nobody walks before the first step: only then it is known where people are.
        self.people = [dict.fromkeys([*STATE, *DRIVE], 0.0) for _ in self.bodies]
        for i, person in enumerate(self.people):
            for name in STATE:
                self.add(f"agent[{i}].{name}", person, name, Fmi2Causality.input)
            for name in DRIVE:
                self.add(f"agent[{i}].{name}", person, name, Fmi2Causality.output, initial=Fmi2Initial.exact)

    def add(self, name, store, key, causality, **attributes):
        """A variable whose value is `store[key]`."""

        def get():
            return store[key]

        def put(value):
            store[key] = value

        self.register_variable(Real(name, causality=causality, getter=get, setter=put, **attributes), nested=False)

    def do_step(self, time, step):
        """From the state at `time` the drive that is held from `time + step` on."""
        for body, person in zip(self.bodies, self.people):
            x = self.parameters["Target.x"] - person["Position.x"]
            y = self.parameters["Target.y"] - person["Position.y"]
            distance = hypot(x, y)
            if distance == 0.0:
                person.update(dict.fromkeys(DRIVE, 0.0))
                continue
            speed = min(self.parameters["WalkingSpeed"], ARRIVING * distance)
            # Half as fast at the tolerated force, a third at twice as much.
            speed /= 1.0 + person["MeanNormalForce"] / self.parameters["ToleratedForce"]
            # Alone somebody gets to the velocity Fp / (m * FloorDamping), and turns at Mp / (I * AngularDamping).
            force = body["Mass"] * body["FloorDamping"] * speed
            person["Fp.x"], person["Fp.y"] = force * x / distance, force * y / distance
            angle = remainder(atan2(y, x) - person["Theta"], 2.0 * pi)
            person["Mp"] = body["MomentOfInertia"] * body["AngularDamping"] * TURNING * angle
        return True
