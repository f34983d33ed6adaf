"""JuPedSim (`pip install jupedsim`): its social force model. A body is one disk that does not turn, driven with m (v_0 e - v)/tau.

With tau = 1/FloorDamping and v_0 = |Fp|/(m FloorDamping) this is the paper's equation of motion of the velocity. Its contacts have a spring, no
damper, and a friction that grows with overlap and speed: no case has these. The step is its default, 0.01 s.
"""

import time

import jupedsim as jps
import numpy as np
from law import Scene
from run import CannotExpress

LABEL = "JuPedSim"
STEP, FAR = 0.01, 500.0


class Engine:
    def load(self, trial, refine=1):
        s = self.scene = Scene(trial)
        if len(s.i):
            raise CannotExpress("its contacts have no damper and no Coulomb friction")
        if (s.across != s.along).any():
            raise CannotExpress("our adapter has no floor that depends on the gaze")
        if not np.hypot(*s.start[:, 3:5].T).any() and not s.fp.any():
            raise CannotExpress("its bodies do not turn")
        box = [(-2 * FAR, -2 * FAR), (2 * FAR, -2 * FAR), (2 * FAR, 2 * FAR), (-2 * FAR, 2 * FAR)]
        self.simulation = jps.Simulation(model=jps.SocialForceModel(), geometry=box, dt=STEP / refine)
        self.agents = []
        for k in range(len(s.ids)):
            x, y, _, vx, vy, _ = map(float, s.start[k])
            speed = abs(s.fp[k]) / (s.mass[k] * s.along[k])
            to = s.fp[k] / abs(s.fp[k]) if speed else 1.0
            stage = self.simulation.add_waypoint_stage((x + FAR * to.real, y + FAR * to.imag), 1.0)
            journey = self.simulation.add_journey(jps.JourneyDescription([stage]))
            agent = jps.SocialForceModelAgentParameters(
                position=(x, y),
                velocity=(vx, vy),
                mass=float(s.mass[k]),
                desired_speed=float(speed),
                reaction_time=float(1 / s.along[k]),
                radius=float(max(s.radius[s.owner == k])),
                journey_id=journey,
                stage_id=stage,
            )
            self.agents.append(self.simulation.add_agent(agent))
        self.refine, self.cost, self.now = refine, 0.0, 0.0

    def step(self, t):
        before = time.process_time()
        self.simulation.iterate(round((t - self.now) / STEP * self.refine))
        self.cost += time.process_time() - before
        self.now = t

    def state(self):
        out = {}
        for name, agent in zip(self.scene.ids, map(self.simulation.agent, self.agents)):
            velocity = agent.model.velocity
            out[name] = {"x": agent.position[0], "y": agent.position[1], "vx": velocity[0], "vy": velocity[1]}
        return out

    def close(self):
        pass
