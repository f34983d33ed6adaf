"""YADE (Debian's package `yade`): ViscElMat and Law2_ScGeom_ViscElPhys_Basic on spheres that move in a plane; yade_scene.py runs in it.

- Stiffness of a pair is that of two springs behind each other, as in the paper, so materials have 4G^2/(4G - E) and 8G^2/(6G - E).
- The normal force is cut where it would pull. While it slides there is no tangential damper, and the spring is cut to the friction.
- A wall is a row of thin boxes, one for each piece as drawn; bodies are clumps. The floor is a LinearDragEngine, on single spheres only.

The step is our choice: a fiftieth of the shortest contact. (YADE's example clump-inbox-viscoelastic.py has a twentieth.)
"""

import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from law import Law, Scene
from run import CannotExpress
from scipy.optimize import nnls

LABEL = "YADE"
SCRIPT = Path(__file__).with_name("yade_scene.py")

try:
    subprocess.run(["yade", "--version"], check=True, capture_output=True)
except (OSError, subprocess.CalledProcessError) as why:
    raise ImportError("the command yade is missing") from why


class Engine:
    def load(self, trial, refine=1):
        s = self.scene = Scene(trial)
        if (s.across != s.along).any():
            raise CannotExpress("our adapter has no floor that depends on the gaze")
        if trial.name[:2] == "25":
            raise CannotExpress("our adapter has no heights")
        bodies = [np.flatnonzero(s.owner == k) for k in range(len(s.ids))]
        if any(len(members) > 1 for members in bodies) and s.along.any():
            raise CannotExpress("our adapter has no friction of the floor on clumps")
        law = Law(trial)
        spring = {name: (4 * g * g / (4 * g - e), 8 * g * g / (6 * g - e)) for name, (e, g) in law.moduli.items()}
        # A damper of a pair is half of the material's where both are the same; the wall's is as large as it needs to be.
        kinds = self._kinds(trial)
        pair = {(kinds[i], kinds[j]): n for n, (i, j) in enumerate(zip(s.i, s.j)) if j >= 0}
        wall = {kinds[i]: n for n, (i, j) in enumerate(zip(s.i, s.j)) if j < 0}
        materials = {}
        for kind in set(kinds):
            n = pair.get((kind, kind))
            m = wall.get(kind)
            damp = (2 * s.gn[n], 2 * s.gt[n], s.mu[n]) if n is not None else (s.gn[m], s.gt[m], s.mu[m]) if m is not None else (0, 0, 0)
            if m is not None:  # the smaller friction counts, and the wall has its own
                damp = (damp[0], damp[1], max(damp[2], s.mu[m]))
            materials[kind] = [*spring[kind], *map(float, damp)]
        self.task = {"materials": materials, "walls": [], "bodies": []}
        for a, b, name, f in s.pieces:
            n = next(n for n in range(len(s.i)) if s.face[n] == f)
            kind = materials[kinds[s.i[n]]]
            damp = [self._other(float(want), have) for want, have in ((s.gn[n], kind[2]), (s.gt[n], kind[3]))]
            self.task["walls"].append({"ends": [a.real, a.imag, b.real, b.imag], "material": [*spring[name], *damp, float(s.mu[n])]})
        for k, members in enumerate(bodies):
            turn = np.exp(1j * s.start[k, 2])
            # Masses of the spheres that put the clump's centre of mass at G.
            shares, missing = nnls(np.array([np.ones(len(members)), s.offset[members].real, s.offset[members].imag]), np.array([1.0, 0.0, 0.0]))
            if missing > 1e-12:
                raise CannotExpress("our adapter has no clump with this centre of mass")
            disks = [[*self._xy(s.offset[i] * turn), float(s.radius[i]), kinds[i], float(share)] for i, share in zip(members, shares)]
            rates = {"along": float(s.along[k]), "force": self._xy(s.fp[k]), "torque": float(s.mp[k])}
            self.task["bodies"].append({"start": s.start[k].tolist(), "mass": float(s.mass[k]), "inertia": float(s.inertia[k]), "disks": disks} | rates)
        if s.angular.any() and not len(s.i):
            raise CannotExpress("our adapter has no angular friction of the floor")
        self.dt = s.shortest() / 50 / refine

    @staticmethod
    def _xy(z):
        return [float(z.real), float(z.imag)]

    @staticmethod
    def _kinds(trial):
        import xml.etree.ElementTree as ElementTree

        return [shape.get("MaterialId") for shape in ElementTree.parse(Path(trial, "static/Agents.xml")).getroot().iter("Shape")]

    @staticmethod
    def _other(pair, one):
        """The damper that makes `pair` behind the damper `one`."""
        if pair == one == 0:
            return 0.0
        if pair == 0:
            return 1e-9  # [kg/s] zero would mean that there is none here, and the other counts
        if pair > one * (1 + 1e-9):
            raise CannotExpress("our adapter has no dampers of walls above those of the body")
        return 0.0 if math.isclose(pair, one, rel_tol=1e-9) else 1 / (1 / pair - 1 / one)

    def step(self, t):
        with tempfile.TemporaryDirectory() as folder:
            task, found = Path(folder, "task.json"), Path(folder, "found.json")
            steps = math.ceil(t / self.dt - 1e-9)
            task.write_text(json.dumps(self.task | {"steps": steps, "dt": t / steps, "found": str(found)}))
            # In its own Python, which must not see the packages of this one.
            clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL", "LD_LIBRARY"))}
            done = subprocess.run(["yade", "-n", "-x", SCRIPT, task], capture_output=True, text=True, env=clean | {"OMP_NUM_THREADS": "1"})
            if not found.is_file():
                raise RuntimeError(done.stderr[-1500:])
            self.found = json.loads(found.read_text())
        self.cost = self.found["cost"]

    def state(self):
        return dict(zip(self.scene.ids, self.found["bodies"]))

    def close(self):
        pass
