"""The contact law of the paper, integrated twice: what the converged cases are solved with.

    python reference/law.py reference/18_two_bodies     solves a case and says how well

Written from the paper's text (O. Dufour, M. Stapelle, A. Nicolas, "LEMONS", section 2.2 and appendix A) and from nothing else, in the public
domain (LICENSE). README.md says which choices it makes where the paper leaves one open. The state is x, y, theta, vx, vy, omega of each body
and the elongation s of each pair that may touch. With t = i n, the tangent,

    F_n = k_n h - gamma_n v_n            F* = -k_t s - gamma_t v_t
    F_t = F* cut to +-mu |F_n|           gamma_t ds/dt = -F_t - k_t s

so ds/dt = v_t while it sticks. Without the instants of touch and parting, where the damper's force jumps, the right side is continuous.
Both integrators find these instants, each in its own way. At its kinks (sticking, sliding, a pull) it is continuous:

- `Adaptive`: Dormand and Prince's method of order 8, step by its own error, instants from its dense output; kinks by its error alone
- `Fixed`: the classical method of Runge and Kutta with equal steps, instants and kinks by shorter steps; its halved steps show an order
"""

import math
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq
from scipy.spatial import cKDTree

COMPONENTS = ("x", "y", "theta", "vx", "vy", "omega")
UNITS = {"x": "m", "y": "m", "theta": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s", "speed": "m/s", "wall": "N"}


def point(text):
    x, y = text.split(",")
    return complex(float(x), float(y))


def number(element, name, otherwise=None):
    return float(element.get(name, otherwise))


class Law:
    """Stiffness, damping and friction of two materials; `share` of them where only a part of the heights meets."""

    def __init__(self, trial):
        root = ElementTree.parse(Path(trial, "static/Materials.xml")).getroot()
        self.moduli = {m.get("Id"): (number(m, "YoungModulus"), number(m, "ShearModulus")) for m in root.iter("Material")}
        self.binary = {frozenset((c.get("Id1"), c.get("Id2"))): c for c in root.iter("Contact")}
        self.load_length = number(root.find("Intrinsic"), "LoadLength", 0.1)

    def of(self, one, other, share=1.0):
        """k_n, k_t [N/m], gamma_n, gamma_t [kg/s], mu."""
        both = [self.moduli[one], self.moduli[other]]
        kn = 1 / sum((4 * g - e) / (4 * g * g) for e, g in both)
        kt = 1 / sum((6 * g - e) / (8 * g * g) for e, g in both)
        c = self.binary[frozenset((one, other))]
        return share * kn, share * kt, share * number(c, "GammaNormal"), share * number(c, "GammaTangential"), number(c, "KineticFriction")


class Scene:
    """What a Trial says: bodies of disks, walls, and all pairs that may touch, or those of disks within a distance [m] at the start."""

    def __init__(self, trial, within=math.inf):
        law = Law(trial)
        agents = list(ElementTree.parse(Path(trial, "static/Agents.xml")).getroot().iter("Agent"))
        self.ids = [a.get("Id") for a in agents]
        self.mass, self.inertia, self.along, self.angular = (
            np.array([number(a, name) for a in agents]) for name in ("Mass", "MomentOfInertia", "FloorDamping", "AngularDamping")
        )
        self.across = np.array([number(a, "FloorDampingAcross", a.get("FloorDamping")) for a in agents])
        owner, radius, offset, kind, heights = [], [], [], [], []
        for k, agent in enumerate(agents):
            shapes = list(agent.iter("Shape"))
            line = point(shapes[-1].get("Position")) - point(shapes[0].get("Position"))
            drawn = math.atan2(line.real, -line.imag) if line else 0.0
            for s in shapes:
                owner.append(k)
                radius.append(number(s, "Radius"))
                offset.append(point(s.get("Position")) * complex(math.cos(drawn), -math.sin(drawn)))
                kind.append(s.get("MaterialId"))
                heights.append((number(s, "Bottom", 0), number(s, "Top", math.inf)))
        self.owner, self.radius, self.offset = np.array(owner), np.array(radius), np.array(offset)
        self.faces, self.pieces = self._faces(trial)
        numbered = [(f, end) for f, face in enumerate(self.faces) for end in face[:2]]
        self.shared = [(f, g, end) for f, end in numbered for g, other in numbered if f != g and end == other]

        def share(one, other):
            common = min(one[1], other[1]) - max(one[0], other[0])
            return 1.0 if math.isinf(common) else max(common, 0.0) / law.load_length

        self.start, self.fp, self.mp = self._start(trial)
        disks = range(len(owner))
        pairs = ((i, j) for i in disks for j in disks if i < j)
        if within < math.inf:
            centres = (self.start[:, 0] + 1j * self.start[:, 1])[self.owner] + self.offset * np.exp(1j * self.start[:, 2])[self.owner]
            pairs = sorted(cKDTree(np.c_[centres.real, centres.imag]).query_pairs(2 * self.radius.max() + within))
        found = [(i, j, -1, share(heights[i], heights[j]), kind[j]) for i, j in pairs if owner[i] != owner[j]]
        found += [(i, -1, f, share(heights[i], face[3]), face[2]) for f, face in enumerate(self.faces) for i in disks]
        found = [pair for pair in found if pair[3] > 0]
        self.i, self.j, self.face = (np.array([pair[k] for pair in found], int) for k in range(3))
        laws = np.array([law.of(kind[i], other, part) for i, _, _, part, other in found]).reshape(-1, 5)
        self.kn, self.kt, self.gn, self.gt, self.mu = laws.T
        if (self.mu[self.gt == 0] > 0).any():
            raise ValueError("friction without a tangential damper: the slider's elongation has no equation here")
        self.slack = np.where(self.gt > 0, self.gt, 1.0)

    @staticmethod
    def _faces(trial):
        """Faces (end, end, material, heights) and the pieces as drawn (end, end, material, face). A wall is a set of points: pieces that go on
        straight are one face here. Programs get the pieces."""
        faces, pieces = [], []
        for wall in ElementTree.parse(Path(trial, "static/Geometry.xml")).getroot().iter("Wall"):
            corners = [point(c.get("Coordinates")) for c in wall.iter("Corner")]
            kept, material = corners[:1], wall.get("MaterialId")
            for before, here, after in zip(corners, corners[1:], [*corners[2:], None]):
                pieces.append((before, here, material, len(faces) + len(kept) - 1))
                if after is None or abs(((after - here) / (here - before)).imag) > 1e-9 * abs((after - here) / (here - before)):
                    kept.append(here)
            heights = (number(wall, "Bottom", 0), number(wall, "Top", math.inf))
            faces += [(a, b, material, heights) for a, b in zip(kept, kept[1:])]
        return faces, pieces

    def shortest(self):
        """The shortest contact [s], without damping: pi sqrt(m/k_n), of two bodies with half of the lighter one; 0.01 s where nothing may touch."""
        m, other = self.mass[self.owner[self.i]], self.mass[self.owner[self.j]]
        reduced = np.where(self.j >= 0, np.minimum(m, other) / 2, m)
        return math.pi * math.sqrt(np.min(reduced / self.kn)) if len(self.i) else 0.01

    def _start(self, trial):
        root = ElementTree.parse(Path(trial, "dynamic/AgentDynamics.xml")).getroot()
        by_id = {a.get("Id"): a for a in root.iter("Agent")}
        rows, fp, mp = [], [], []
        for name in self.ids:
            k, d = by_id[name].find("Kinematics"), by_id[name].find("Dynamics")
            r, v = point(k.get("Position")), point(k.get("Velocity"))
            rows.append([r.real, r.imag, number(k, "Theta"), v.real, v.imag, number(k, "Omega")])
            fp.append(0j if d is None else point(d.get("Fp")))
            mp.append(0.0 if d is None else number(d, "Mp"))
        return np.array(rows), np.array(fp), np.array(mp)

    def force(self, body, fp, mp):
        """The drive of a body [N], [N m] from now on."""
        k = self.ids.index(body)
        self.fp[k], self.mp[k] = complex(*fp), mp

    def geometry(self, y):
        """Of each pair the overlap h, the normal towards disk i, and the arm from i's centre of mass to the point of contact C."""
        arms = self.offset * np.exp(1j * y[:, 2])[self.owner]
        p = (y[:, 0] + 1j * y[:, 1])[self.owner] + arms
        other = p[self.j] if len(p) else p
        reach = self.radius[self.i] + np.where(self.j >= 0, self.radius[self.j], 0.0)
        if self.faces:
            feet = np.array([self._foot(p, f) for f in range(len(self.faces))])
            at_wall = self.face >= 0
            other = np.where(at_wall, feet[self.face, self.i], other)
            # An end that faces share acts only where it is the nearest point of all of them, and once.
            for f, g, end in self.shared:
                idle = (feet[f] == end) & ((feet[g] != end) | (g < f))
                reach = np.where(at_wall & (self.face == f) & idle[self.i], -1.0, reach)
        e = p[self.i] - other
        distance = np.abs(e)
        n = e / distance
        h = reach - distance
        return h, n, arms[self.i] - (self.radius[self.i] - h / 2) * n, p

    def _foot(self, p, f):
        a, b = self.faces[f][:2]
        along = (np.conj(b - a) * (p - a)).real / abs(b - a) ** 2
        return np.where(along <= 0, a, np.where(along >= 1, b, a + np.clip(along, 0, 1) * (b - a)))

    def rates(self, whole, active):
        y = whole[: 6 * len(self.ids)].reshape(-1, 6)
        s = whole[6 * len(self.ids) :]
        v, w = y[:, 3] + 1j * y[:, 4], y[:, 5]
        h, n, arm, p = self.geometry(y)
        i = self.owner[self.i]
        body = self.j >= 0
        j = self.owner[self.j]
        c = (y[:, 0] + 1j * y[:, 1])[i] + arm
        arm_j = c - (y[:, 0] + 1j * y[:, 1])[j]
        rel = v[i] + 1j * w[i] * arm - np.where(body, v[j] + 1j * w[j] * arm_j, 0)
        vn, vt = (rel * np.conj(n)).real, (rel * np.conj(1j * n)).real
        fn = self.kn * h - self.gn * vn
        limit = self.mu * np.abs(fn)
        ft = np.clip(-self.kt * s - self.gt * vt, -limit, limit)
        f = np.where(active, fn * n + ft * 1j * n, 0)
        count = len(self.ids)
        gaze = np.exp(1j * y[:, 2])
        seen = v * np.conj(gaze)
        force = self.fp - self.mass * gaze * (self.along * seen.real + 1j * self.across * seen.imag)
        torque = self.mp - self.inertia * self.angular * w
        for sign, body_of, lever, only in ((1, i, arm, None), (-1, j, arm_j, body)):
            part = f if only is None else np.where(only, f, 0)
            force = force + sign * (np.bincount(body_of, part.real, count) + 1j * np.bincount(body_of, part.imag, count))
            torque = torque + sign * np.bincount(body_of, lever.real * part.imag - lever.imag * part.real, count)
        out = np.empty_like(whole)
        accelerations = [v.real, v.imag, w, force.real / self.mass, force.imag / self.mass, torque / self.inertia]
        out[: 6 * count] = np.column_stack(accelerations).ravel()
        out[6 * count :] = np.where(active & (self.gt > 0), -(ft + self.kt * s) / self.slack, 0)
        self.normal = np.where(active, fn, 0)
        self.excess = np.where(active, np.abs(self.kt * s + self.gt * vt) - limit, -1)  # of the test force over the slider's [N]
        self.overlap = h
        return out

    def overlaps(self, whole):
        return self.geometry(whole[: 6 * len(self.ids)].reshape(-1, 6))[0]

    def wall_loads(self, whole, active):
        """The sum of the normal forces of walls on each body [N]."""
        self.rates(whole, active)
        return np.bincount(self.owner[self.i], np.where(self.face >= 0, self.normal, 0), len(self.ids))


class _March:
    """A state that goes on from touch to touch; the subclass takes the steps."""

    def __init__(self, scene):
        self.scene, self.t = scene, 0.0
        self.whole = np.concatenate([scene.start.ravel(), np.zeros(len(scene.i))])
        self.active = scene.overlaps(self.whole) > 0
        self.touches = int(self.active.sum())

    def rates(self, whole):
        return self.scene.rates(whole, self.active)

    def changed(self, whole):
        return np.flatnonzero((self.scene.overlaps(whole) > 0) != self.active)

    def flip(self, n):
        self.active[n] = not self.active[n]
        self.touches += bool(self.active[n])
        self.whole[6 * len(self.scene.ids) + n] = 0.0

    def first(self, changed, at, left, right):
        """The first of the pairs that changed, and when; `at(t)` is the state."""
        found = []
        for n in changed:
            gap = lambda t, n=n: self.scene.overlaps(at(t))[n]  # noqa: E731
            a, b = gap(left), gap(right)
            found.append((left if a * b >= 0 else brentq(gap, left, right, xtol=1e-16, rtol=1e-14), n))
        return min(found)


class Adaptive(_March):
    def __init__(self, scene, tolerance=1e-11, longest=5e-4):
        super().__init__(scene)
        self.tolerance, self.longest = tolerance, longest

    def _solver(self, end):
        options = {"rtol": self.tolerance, "atol": self.tolerance * 1e-2, "max_step": self.longest}
        return DOP853(lambda _, whole: self.rates(whole), self.t, self.whole, end, **options)

    def advance(self, end):
        while self.t < end:
            solver = self._solver(end)
            while solver.status == "running":
                if solver.step() or solver.status == "failed":
                    raise ArithmeticError("the step became too small")
                dense, left, hit = solver.dense_output(), solver.t_old, None
                for right in np.linspace(solver.t_old, solver.t, 4)[1:]:
                    changed = self.changed(dense(right))
                    if len(changed):
                        hit = self.first(changed, dense, left, right)
                        break
                    left = right
                if hit:
                    self.t, self.whole = hit[0], dense(hit[0])
                    self.flip(hit[1])
                    break
                self.t, self.whole = solver.t, solver.y
        return self


class Fixed(_March):
    def __init__(self, scene, step):
        super().__init__(scene)
        self.step = step
        self.signs = self.functions(self.whole) > 0

    def _after(self, tau):
        w, f = self.whole, self.rates
        a = f(w)
        b = f(w + tau / 2 * a)
        c = f(w + tau / 2 * b)
        return w + tau / 6 * (a + 2 * b + 2 * c + f(w + tau * c))

    def functions(self, whole):
        """What changes its sign where the right side jumps (overlap) or has a kink (slider, normal force)."""
        self.rates(whole)
        return np.array([self.scene.overlap, self.scene.excess, self.scene.normal])

    def _change(self, tau, after):
        """The first change of a sign within tau: when, of which function, of which pair."""
        found = []
        for row, n in zip(*np.nonzero((self.functions(after) > 0) != self.signs)):
            value = lambda t, row=row, n=n: self.functions(self._after(t))[row, n]  # noqa: E731
            left, right = value(0.0), value(tau)
            found.append((0.0 if left * right >= 0 else brentq(value, 0.0, tau, xtol=1e-15, rtol=1e-14), row, n))
        return min(found, default=None)

    def advance(self, end):
        start, steps = self.t, math.ceil((end - self.t) / self.step - 1e-9)
        for k in range(1, steps + 1):
            here = start + (end - start) * k / steps
            while self.t < here:
                after = self._after(here - self.t)
                change = self._change(here - self.t, after)
                if not change:
                    self.whole, self.t = after, here
                else:
                    tau, row, n = change
                    self.whole, self.t = self._after(tau), self.t + tau
                    if row == 0:
                        self.flip(n)
                        self.signs[:, n] = self.functions(self.whole)[:, n] > 0
                    self.signs[row, n] = self.active[n] if row == 0 else not self.signs[row, n]
        return self


def named(scene, march, names):
    """Values of quantities, by their names: `ID.component`, with the units of UNITS."""
    y = march.whole[: 6 * len(scene.ids)].reshape(-1, 6)
    loads = scene.wall_loads(march.whole, march.active)
    out = {}
    for name in names:
        k, component = scene.ids.index(name.rsplit(".", 1)[0]), name.rsplit(".", 1)[1]
        special = {"speed": math.hypot(y[k, 3], y[k, 4]), "wall": loads[k]}
        out[name] = float(special[component] if component in special else y[k, COMPONENTS.index(component)])
    return out


def description(directory):
    return tomllib.loads(Path(directory, "case.toml").read_text())


def distance(case, one, other):
    """The largest difference of two results over the scales of a case."""
    return max((abs(one[name] - other[name]) / case["scale"][UNITS[name.rsplit(".", 1)[1]]] for name in one), default=math.nan)


def driven(case, go, force):
    """Goes to the end of a case, with the changes of its drive on the way: `go(t)`, `force(body, Fp, Mp)`."""
    for change in case.get("drive", []):
        go(change["from"])
        force(change["id"], change["Fp"], change["Mp"])
    go(case["end"])


def solved(directory, names, longest=5e-4, tolerance=1e-11):
    """The quantities by the adaptive integrator."""
    scene = Scene(directory)
    march = Adaptive(scene, tolerance, longest)
    driven(description(directory), march.advance, scene.force)
    return named(scene, march, names)


def certificate(directory, names, step, best=None):
    """Both integrators: the adaptive one's values (`best`, if known), the order that three halved steps of the other show, the distance of both."""
    case = description(directory)
    best = best or solved(directory, names)

    def fixed(step):
        scene = Scene(directory)
        march = Fixed(scene, step)
        driven(case, march.advance, scene.force)
        return named(scene, march, names)

    halved = [fixed(step / 2**k) for k in range(3)]
    first, second = (distance(case, halved[k], halved[k + 1]) for k in range(2))
    order = math.log2(first / second) if first > 1e-9 else math.inf  # else only rounding is left
    return best, order, distance(case, best, halved[2])


def main(directory):
    case = description(directory)
    values, order, bar = certificate(directory, list(case["solution"]), case.get("check_step", 1e-4))
    for name, value in values.items():
        print(f"{name:12} {value: .12e} {UNITS[name.rsplit('.', 1)[1]]:6} stored {case['solution'][name]: .12e}")
    print(f"order {order:.2f} with steps of {case.get('check_step', 1e-4):g} s, halved twice; both integrators differ by {bar:.1e} of the scales")


if __name__ == "__main__":
    main(sys.argv[1])
