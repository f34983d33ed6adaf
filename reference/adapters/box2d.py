"""Box2D 3 (`pip install pyb2d3`): bodies of circles, walls of segments, restitution and friction instead of springs.

The step: 1/60 s in four sub-steps, as its manual advises. Its threshold of restitution (1 m/s) is set to zero, since these impacts are at about
1 m/s, and nobody sleeps. A floor is its linear and angular damping. It computes in single precision.
"""

import time

import numpy as np
import pyb2d3
from rigid import Hard

LABEL, RIGID = "Box2D", True
STEP, SUBSTEPS = 1 / 60, 4


class Engine:
    def load(self, trial, refine=1):
        hard = Hard(trial)
        s = self.scene = hard.scene
        self.world = pyb2d3.World(gravity=(0, 0), restitution_threshold=0.0)
        self.world.sleeping_enabled = False
        still = self.world.create_static_body(position=(0, 0))
        # Friction of two: the root of the product. It is that of the disks among themselves, and that of the walls at walls.
        for a, b, *_ in s.pieces:
            material = pyb2d3.surface_material(friction=hard.ratio**2 * hard.disk_friction, restitution=0.0)
            still.create_shape(pyb2d3.shape_def(material=material), pyb2d3.segment((a.real, a.imag), (b.real, b.imag)))
        self.bodies = []
        for k in range(len(s.ids)):
            x, y, theta, vx, vy, w = map(float, s.start[k])
            # Its angle counts from the Trial's start; velocities first, masses after the shapes.
            body = self.world.create_dynamic_body(
                position=(x, y), linear_velocity=(vx, vy), angular_velocity=w, linear_damping=float(s.along[k]), angular_damping=float(s.angular[k])
            )
            turn = np.exp(1j * theta)
            for i in np.flatnonzero(s.owner == k):
                offset = complex(s.offset[i] * turn)
                material = pyb2d3.surface_material(friction=hard.disk_friction, restitution=hard.restitution[i])
                circle = pyb2d3.circle(center=(offset.real, offset.imag), radius=float(s.radius[i]))
                body.create_shape(pyb2d3.shape_def(density=1.0, material=material, enable_contact_events=False), circle)
            data = pyb2d3.MassData()
            data.mass, data.center, data.rotational_inertia = float(s.mass[k]), (0, 0), float(s.inertia[k])
            body.mass_data = data
            body.linear_velocity, body.angular_velocity = (vx, vy), w
            self.bodies.append(body)
        self.refine, self.now, self.cost = refine, 0.0, 0.0
        self.turned = np.zeros(len(s.ids))

    def force(self, *drive):
        self.scene.force(*drive)

    def step(self, t):
        s = self.scene
        steps = int(np.ceil((t - self.now) / STEP * self.refine - 1e-9))
        dt = (t - self.now) / steps
        before = time.process_time()
        for _ in range(steps):
            old = np.array([body.angle for body in self.bodies])
            for k, body in enumerate(self.bodies):
                if s.fp[k] or s.mp[k]:
                    body.apply_force_to_center((s.fp[k].real, s.fp[k].imag), True)
                    body.apply_torque(float(s.mp[k]), True)
            self.world.step(dt, SUBSTEPS)
            self.turned += np.angle(np.exp(1j * (np.array([body.angle for body in self.bodies]) - old)))
        self.cost += time.process_time() - before
        self.now = t

    def state(self):
        out = {}
        for k, body in enumerate(self.bodies):
            (x, y), (vx, vy) = body.position, body.linear_velocity
            out[self.scene.ids[k]] = {"x": x, "y": y, "theta": self.scene.start[k, 2] + self.turned[k], "vx": vx, "vy": vy, "omega": body.angular_velocity}
        return out

    def close(self):
        self.world.destroy()
