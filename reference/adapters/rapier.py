"""Rapier 2D, as ../rapier runs it (built by `cargo build --release --manifest-path reference/rapier/Cargo.toml`). Bodies of balls, walls of
segments, restitution and friction instead of springs.

The step: 1/60 s with its four solver iterations, its default. SIMD is always on. A floor is its linear and angular damping. It computes in single
precision.
"""

import json
import subprocess
from pathlib import Path

import numpy as np
from rigid import Hard

LABEL, RIGID = "Rapier", True
STEP = 1 / 60
PROGRAM = Path(__file__).parents[1] / "rapier/target/release/rapier-cases"

if not PROGRAM.exists():
    raise ImportError(f"{PROGRAM} is not built")


class Engine:
    def load(self, trial, refine=1):
        hard = Hard(trial)
        s = self.scene = hard.scene
        bodies = []
        for k in range(len(s.ids)):
            turn = np.exp(1j * s.start[k, 2])
            disks = [
                {"x": o.real, "y": o.imag, "radius": s.radius[i], "restitution": hard.restitution[i], "friction": hard.disk_friction**0.5}
                for i in np.flatnonzero(s.owner == k)
                for o in [complex(s.offset[i] * turn)]
            ]
            rates = {"along": s.along[k], "angular": s.angular[k]}
            bodies.append({"start": s.start[k].tolist(), "mass": s.mass[k], "inertia": s.inertia[k], "disks": disks} | rates)
        walls = [[a.real, a.imag, b.real, b.imag] for a, b, *_ in s.pieces]
        self.task = {"bodies": bodies, "walls": walls, "wall_friction": hard.ratio * hard.disk_friction**0.5}
        self.refine, self.now, self.phases = refine, 0.0, []

    def force(self, *drive):
        self.scene.force(*drive)

    def step(self, t):
        """All from the start again, with this phase of constant drives."""
        s, steps = self.scene, int(np.ceil((t - self.now) / STEP * self.refine - 1e-9))
        drives = [[f.real, f.imag, m] for f, m in zip(s.fp, s.mp)]
        self.phases.append({"steps": steps, "dt": (t - self.now) / steps, "drives": drives})
        self.now = t
        task = json.dumps(self.task | {"phases": self.phases})
        done = subprocess.run([PROGRAM], input=task, check=True, capture_output=True, text=True)
        self.found = json.loads(done.stdout)
        self.cost = self.found["cost"]

    def state(self):
        return dict(zip(self.scene.ids, self.found["bodies"]))

    def close(self):
        pass
