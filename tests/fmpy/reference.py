"""An independent reference for the engine: the same equations, another method, no shared code.

The engine steps through contacts with a fixed mechanical step. Here scipy's eighth-order Runge-Kutta (DOP853, tolerance 1e-12)
integrates the smooth pieces, and every instant at which the equations change is located by root finding:

- a contact begins or ends, or passes from a face of a wall to another or to a corner; where the faces turn by at most 20 degrees they
  are one line: of each connected run of its faces that a disk overlaps only the nearest acts, and the contact goes on with its spring
- at an inner corner that turns by 20 to 90 degrees the second face begins or ceases to act: while both do, h is the depth of the pair,
  in the spring and for the point of contact, but the damping is that of the velocity; the straight ends must be long enough for that
- sticking -> sliding: the test force F* = -k_t s - gamma_t v_t leaves the Coulomb cone |F*| <= mu |F_n|
- sliding -> sticking: F* comes back to the cone; without gamma_t: with s = -F_t/k_t let go (ds/dt = v_t), F* would enter it
- the normal force changes sign (it is not clamped), so |F_n| has a kink

An elongation is part of the ODE's state: while it sticks ds/dt = v_t, while it slides gamma_t ds/dt = -F_t - k_t s. Without gamma_t
a sliding contact's follows from the motion. Forces are continuous when a contact passes from sticking to sliding or back, so the
accelerations that the third test needs without gamma_t do not depend on its outcome.
The equations are those of the paper's appendix A; a Trial is read from its XML text by the standard library.

A case in cases.json and usual.json: `files`, the texts of its Trial; `times` [s], its communication points; `drive`, for each step ending
there and each agent Fp.x, Fp.y, Mp; `states`, at each of these times and for each agent x, y, theta, vx, vy, omega; `happens`, a count of
events; how the states answer to the start `moved` by 1e-9 (m, rad, m/s, rad/s) and to a `loose` tolerance of 1e-10. Both are small: grazing
contacts were left out when the cases were drawn at random, once, from their `seed` (commit af11d78 has the program). The materials of
usual.json are those of the default Trial.

    python tests/fmpy/reference.py tests/reference/cases.json     solves the cases again
"""

import cmath
import itertools
import json
import math
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

RTOL, ATOL = 1e-12, 1e-14
LINE = math.radians(20) + 1e-9  # [rad] faces that turn by at most this are one line
MAX_STEP = 1e-3  # [s] short against the shortest contact, so that none slips through between two looks
LOOKS = 4  # looks for events per integrator step
TINY = {"touch": 1e-13, "normal": 1e-8, "stick": 1e-8, "slide": 1e-8, "release": 1e-3}  # [m], [N], [N], [N], [N/s]: round-off of the event functions


# --- the scene ---------------------------------------------------------------------------------------------------


def _pair(text):
    return np.array([float(number) for number in text.split(",")])


class Law:
    """Coefficients of a contact between two materials."""

    def __init__(self, first, second, binary):
        (e1, g1), (e2, g2) = first, second
        self.kn = 1 / ((4 * g1 - e1) / (4 * g1 * g1) + (4 * g2 - e2) / (4 * g2 * g2))  # [N/m]
        self.kt = 1 / ((6 * g1 - e1) / (8 * g1 * g1) + (6 * g2 - e2) / (8 * g2 * g2))  # [N/m]
        self.gn, self.gt, self.mu = binary  # [kg/s], [kg/s], 1
        assert self.kn > 0 and self.kt > 0


class Scene:
    """What the XML of a Trial says. `files`: name within the Trial -> text."""

    def __init__(self, files):
        materials = ElementTree.fromstring(files["static/Materials.xml"])
        moduli = {m.get("Id"): (float(m.get("YoungModulus")), float(m.get("ShearModulus"))) for m in materials.iter("Material")}
        laws = {}
        for c in materials.iter("Contact"):
            a, b = c.get("Id1"), c.get("Id2")
            numbers = [float(c.get(name)) for name in ("GammaNormal", "GammaTangential", "KineticFriction")]
            laws[a, b] = laws[b, a] = Law(moduli[a], moduli[b], numbers)

        self.mass, self.inertia, self.floor, self.angular = [], [], [], []
        self.owner, self.radius, self.offset, stuff = [], [], [], []
        for number, agent in enumerate(ElementTree.fromstring(files["static/Agents.xml"]).iter("Agent")):
            self.mass.append(float(agent.get("Mass")))
            self.inertia.append(float(agent.get("MomentOfInertia")))
            self.floor.append(float(agent.get("FloorDamping")))
            self.angular.append(float(agent.get("AngularDamping")))
            shapes = list(agent.iter("Shape"))
            across = _pair(shapes[-1].get("Position")) - _pair(shapes[0].get("Position"))
            drawn = math.atan2(across[0], -across[1]) if across.any() else 0.0  # the orientation that the shapes show
            for shape in shapes:
                x, y = _pair(shape.get("Position"))
                self.owner.append(number)
                self.radius.append(float(shape.get("Radius")))
                self.offset.append(complex(x, y) * complex(math.cos(drawn), -math.sin(drawn)))  # as seen at theta = 0
                stuff.append(shape.get("MaterialId"))
        self.agents, disks = len(self.mass), len(self.owner)

        start, self.drive = [], []
        for agent in ElementTree.fromstring(files["dynamic/AgentDynamics.xml"]).iter("Agent"):
            k, d = agent.find("Kinematics"), agent.find("Dynamics")
            start += [*_pair(k.get("Position")), float(k.get("Theta")), *_pair(k.get("Velocity")), float(k.get("Omega"))]
            self.drive.append([*_pair(d.get("Fp")), float(d.get("Mp"))])
        self.start = np.array(start)  # per agent x, y, theta, vx, vy, omega

        # Everything that may touch: ("disk", i, j), ("face", i, face), ("corner", i, corner), each with its law.
        self.touch = []
        for i in range(disks):
            for j in range(i + 1, disks):
                if self.owner[i] != self.owner[j]:
                    self.touch.append(("disk", i, j, laws[stuff[i], stuff[j]]))
        # Ends of walls at one place join like corners of one wall; the same face twice is one face, of the wall that comes first.
        self.faces, meeting = {}, {}  # ends as they are written, in any order -> (end, end, material); point -> its faces
        for wall in ElementTree.fromstring(files["static/Geometry.xml"]).iter("Wall"):
            points = [tuple(_pair(c.get("Coordinates"))) for c in wall.iter("Corner")]
            for a, b in zip(points, points[1:]):
                if frozenset((a, b)) not in self.faces:
                    meeting.setdefault(a, []).append((len(self.faces), False))  # whether it is that face's second end
                    meeting.setdefault(b, []).append((len(self.faces), True))
                    self.faces[frozenset((a, b))] = (np.array(a), np.array(b), wall.get("MaterialId"))
        self.faces = list(self.faces.values())
        self.corners = [(np.array(point), ends) for point, ends in meeting.items()]
        self.touch += [("face", i, f, laws[stuff[i], face[2]]) for f, face in enumerate(self.faces) for i in range(disks)]
        for number, (_, ends) in enumerate(self.corners):
            self.touch += [("corner", i, number, laws[stuff[i], self.faces[ends[0][0]][2]]) for i in range(disks)]

        self.line = list(range(len(self.faces)))  # of each face its line
        self.line_at = [None] * len(self.corners)  # of a corner within a line one of its faces
        self.joined, self.pairs = set(), {}  # (face, face) of one line; see `_pair_at`
        for number, (_, ends) in enumerate(self.corners):
            for one, other in itertools.combinations(ends, 2):
                bend = self._bend(one, other)
                if bend <= LINE:
                    self.joined |= {(one[0], other[0]), (other[0], one[0])}
                    self.line_at[number] = one[0]
                    kept, gone = sorted((self.line[one[0]], self.line[other[0]]))
                    self.line = [kept if line == gone else line for line in self.line]
                elif bend < math.pi / 2 - 1e-9:
                    self._pair_at(ends, one, other, bend)
        lines = [[f for f, of in enumerate(self.line) if of == line] for line in sorted(set(self.line))]
        self.bent = [line for line in lines if len(line) > 1]

        self._owner, self._radius, self._offset = np.array(self.owner), np.array(self.radius), np.array(self.offset)
        pairs = [(i, j) for kind, i, j, _ in self.touch if kind == "disk"]
        self._i, self._j = (np.array(pairs, int).T if pairs else (np.array([], int), np.array([], int)))
        self._pairs = len(pairs)

    def _bend(self, first, second):
        """The angle [rad] by which the wall turns where two faces meet; each as (face, whether it ends there)."""
        return abs(cmath.phase(self._away(first) / -self._away(second)))

    def _away(self, end):
        """The direction of a face away from its end."""
        a, b, _ = self.faces[end[0]]
        return complex(*(a - b if end[1] else b - a))

    def _normal(self, face):
        a, b, _ = self.faces[face]
        along = complex(*(b - a))
        return 1j * along / abs(along)

    def _pair_at(self, ends, one, other, bend):
        """An inner corner where both faces act: (face, other face) -> the normals into the corner, the cosine of the turn."""
        f, g = self._away(one), self._away(other)
        between = lambda u: 0 < cmath.phase(u / f) / cmath.phase(g / f) < 1
        if any(between(self._away(end)) for end in ends if end not in (one, other)):
            return
        reach = max(self.radius) * (math.tan(bend / 2) + math.tan(LINE / 2))
        assert min(abs(f), abs(g)) > reach, "a face at an inner corner is too short: more than two faces act together"
        inwards = [math.copysign(1, _dot(n, across)) * n for n, across in ((self._normal(one[0]), g), (self._normal(other[0]), f))]
        self.pairs[one[0], other[0]] = (*inwards, math.cos(bend))
        self.pairs[other[0], one[0]] = (*inwards[::-1], math.cos(bend))

    def line_of(self, n):
        """The disk and the line that `touch[n]` is a contact of; None if it is none with a line."""
        kind, i, j, _ = self.touch[n]
        face = j if kind == "face" else self.line_at[j] if kind == "corner" else None
        return None if face is None else (i, self.line[face])

    def centres(self, y):
        """Disk centres as complex numbers."""
        y = y[: 6 * self.agents].reshape(-1, 6)
        return (y[:, 0] + 1j * y[:, 1])[self._owner] + self._offset * np.exp(1j * y[:, 2])[self._owner]

    def touching(self, y):
        """For each of `touch` a continuous function of the state [m]: positive where they touch."""
        p = self.centres(y)
        out = np.empty(len(self.touch))
        out[: self._pairs] = self._radius[self._i] + self._radius[self._j] - np.abs(p[self._i] - p[self._j])
        before, after, on_face = [], [], []  # how far each disk is before and after the ends of each face, and its overlap with it
        depth, near = [], []  # below the face's line; whether the disk overlaps the face with its ends
        for a, b, _ in self.faces:
            length = math.hypot(*(b - a))
            along = (p - complex(*a)) * complex(*(b - a)).conjugate() / length
            before.append(-along.real)
            after.append(along.real - length)
            depth.append(self._radius - np.abs(along.imag))
            on_face.append(np.minimum(depth[-1], np.minimum(along.real, length - along.real)))
            near.append(self._radius > np.hypot(along.imag, np.maximum(0, np.maximum(before[-1], after[-1]))))
        at_corner, corner_depth = [], []
        for point, ends in self.corners:
            value = self._radius - np.abs(p - complex(*point))
            corner_depth.append(value)
            for face, second in ends:  # the corner must be the nearest point of every face that meets there
                value = np.minimum(value, after[face] if second else before[face])
            at_corner.append(value)
        for line in self.bent:
            for i in np.flatnonzero(np.sum([near[f] for f in line], axis=0) > 1):
                for run in self._runs([f for f in line if near[f][i]]):
                    parts = [(on_face[f], depth[f][i]) for f in run]
                    parts += [(at_corner[c], corner_depth[c][i]) for c, (_, ends) in enumerate(self.corners) if any(f in run for f, _ in ends)]
                    parts = [part for part in parts if part[0][i] > 0]
                    for k, (value, h) in enumerate(parts):  # only the nearest acts
                        value[i] = min([value[i], *(h - other for m, (_, other) in enumerate(parts) if m != k)])
        for (f, g), (inwards, others, cosine) in self.pairs.items():
            first, second = (self._radius - _dot(p - complex(*self.faces[k][0]), n) for k, n in ((f, inwards), (g, others)))
            inside = (first < self._radius) & (second < self._radius)
            on_face[f] = np.where(inside, np.minimum(on_face[f], first - second * cosine), on_face[f])
        for n, (kind, i, j, _) in enumerate(self.touch[self._pairs :], self._pairs):
            out[n] = on_face[j][i] if kind == "face" else at_corner[j][i]
        return out

    def _runs(self, faces):
        """The connected runs of some faces of a line."""
        runs = []
        for face in faces:
            meets = [run for run in runs if any((face, other) in self.joined for other in run)]
            runs = [run for run in runs if run not in meets] + [sum(meets, [face])]
        return runs


# --- contacts ----------------------------------------------------------------------------------------------------


class Contact:
    """A contact that lasts. `side` is 0 while it sticks, else the sign of the tangential force with which it slides."""

    def __init__(self, scene, n):
        self.n = n
        self.kind, self.i, j, self.law = scene.touch[n]
        self.a, self.ri = scene.owner[self.i], scene.radius[self.i]
        self.j = self.b = self.point = self.face = None
        if self.kind == "disk":
            self.j, self.b, self.rj = j, scene.owner[j], scene.radius[j]
        elif self.kind == "corner":
            self.point = complex(*scene.corners[j][0])
        else:
            self.point, self.face, self.number = complex(*scene.faces[j][0]), scene._normal(j), j
        self.pair = None  # of a face that acts with another at an inner corner: a point and the normal of the other, cosine
        self.s, self.side, self.sign = 0.0, 0, 1.0  # elongation along t [m]; see above; sign of the normal force

    def motion(self, y, scene, acceleration=None):
        """n, t, overlap h, closing speed u, v_t, arms, dh/dt; with accelerations h, dh/dt, du/dt, v_t, dv_t/dt.

        With e the vector to i's centre from j's (or from the nearest point of the wall), e = (R_i + R_j - h) n and n' = f t:
        u = h' = -e'.n, v_t = e'.t - w_i (R_i - h/2) - w_j (R_j - h/2); the second derivatives follow by the product rule.
        Of two faces at an inner corner, h is the depth of the pair and h' its rate; u stays -e'.n.
        """
        k = 6 * self.a
        w = y[k + 5]
        di = scene.offset[self.i] * complex(math.cos(y[k + 2]), math.sin(y[k + 2]))
        e = complex(y[k], y[k + 1]) + di
        e1 = complex(y[k + 3], y[k + 4]) + 1j * w * di
        dj, wj = 0j, 0.0
        if self.b is not None:
            m = 6 * self.b
            wj = y[m + 5]
            dj = scene.offset[self.j] * complex(math.cos(y[m + 2]), math.sin(y[m + 2]))
            e -= complex(y[m], y[m + 1]) + dj
            e1 -= complex(y[m + 3], y[m + 4]) + 1j * wj * dj
        else:
            e -= self.point
        if self.kind == "face":
            n = self.face if _dot(e, self.face) > 0 else -self.face
            distance, turning = _dot(e, n), 0.0
        else:
            distance = abs(e)
            n = e / distance
            turning = _dot(e1, 1j * n) / distance
        t = 1j * n
        h = self.ri - distance + (self.rj if self.b is not None else 0.0)
        h1 = u = -_dot(e1, n)
        if self.pair:
            point, other, cosine = self.pair
            h = (h - (self.ri - _dot(e + self.point - point, other)) * cosine) / (1 - cosine**2)
            h1 = (u + _dot(e1, other) * cosine) / (1 - cosine**2)
        assert h <= 0.5 * self.ri, "very deep overlap"
        arm_i, arm_j = self.ri - h / 2, (self.rj - h / 2 if self.b is not None else 0.0)
        vt = _dot(e1, t) - w * arm_i - wj * arm_j
        if acceleration is None:
            return n, t, h, u, vt, di, dj, arm_i, arm_j, h1
        e2 = complex(*acceleration[k : k + 2]) + (1j * acceleration[k + 2] - w * w) * di
        w1, wj1 = acceleration[k + 2], 0.0
        if self.b is not None:
            e2 -= complex(*acceleration[m : m + 2]) + (1j * acceleration[m + 2] - wj * wj) * dj
            wj1 = acceleration[m + 2]
        u1 = -_dot(e2, n) - turning * _dot(e1, t)
        vt1 = _dot(e2, t) + turning * u - w1 * arm_i - wj1 * arm_j + (w + wj) * h1 / 2
        return h, h1, u1, vt, vt1

    def normal_force(self, h, u):
        return self.law.kn * h + self.law.gn * u

    @property
    def stateful(self):
        """Whether the elongation has a differential equation now."""
        return not self.side or self.law.gt > 0

    def tangential_force(self, normal, vt, s):
        if self.side:
            return self.side * self.law.mu * self.sign * normal
        return -self.law.kt * s - self.law.gt * vt


def _dot(a, b):
    return a.real * b.real + a.imag * b.imag


def _cross(a, b):
    return a.real * b.imag - a.imag * b.real


class Simulation:
    """State at one time; `advance` moves it."""

    def __init__(self, files, perturbation=None, tolerance=RTOL):
        self.scene = Scene(files)
        self.t, self.tolerance = 0.0, tolerance
        self.y = self.scene.start + (0 if perturbation is None else perturbation)
        self.drive = self.scene.drive
        self.contacts = {}  # place in scene.touch -> Contact
        self.counts = Counter()
        assert (self.scene.touching(self.y) < 0).all(), "overlap at the start"

    # The smooth piece: state, then the elongations.

    def _springs(self):
        return [c for c in self.contacts.values() if c.stateful]

    def _whole(self):
        return np.concatenate([self.y, [c.s for c in self._springs()]])

    def _derivative(self, _, whole):
        y, scene = whole.tolist(), self.scene
        out = [0.0] * len(y)
        for a in range(scene.agents):
            k, (fx, fy, torque) = 6 * a, self.drive[a]
            m, inertia = scene.mass[a], scene.inertia[a]
            out[k : k + 3] = y[k + 3 : k + 6]
            out[k + 3] = fx / m - scene.floor[a] * y[k + 3]
            out[k + 4] = fy / m - scene.floor[a] * y[k + 4]
            out[k + 5] = torque / inertia - scene.angular[a] * y[k + 5]
        spring = 6 * scene.agents
        for c in self.contacts.values():
            n, t, h, u, vt, di, dj, arm_i, arm_j, _ = c.motion(y, scene)
            s = y[spring] if c.stateful else 0.0
            normal = c.normal_force(h, u)
            tangential = c.tangential_force(normal, vt, s)
            if c.stateful:
                out[spring] = -(tangential + c.law.kt * s) / c.law.gt if c.side else vt
                spring += 1
            force = normal * n + tangential * t
            k, m = 6 * c.a, scene.mass[c.a]
            out[k + 3] += force.real / m
            out[k + 4] += force.imag / m
            out[k + 5] += (_cross(di, force) - arm_i * tangential) / scene.inertia[c.a]
            if c.b is not None:
                k, m = 6 * c.b, scene.mass[c.b]
                out[k + 3] -= force.real / m
                out[k + 4] -= force.imag / m
                out[k + 5] -= (_cross(dj, force) + arm_j * tangential) / scene.inertia[c.b]
        return np.array(out)

    # Events: a list of functions of the state, all positive as long as the equations stay as they are.

    def _watched(self):
        out = [("touch", n) for n in range(len(self.scene.touch))]
        for n, c in self.contacts.items():
            out += [("stick" if not c.side else "slide" if c.stateful else "release", n), ("normal", n)]
        return out

    def _margins(self, whole):
        now = np.array([1.0 if n in self.contacts else -1.0 for n in range(len(self.scene.touch))])
        out = list(now * self.scene.touching(whole))
        y = whole.tolist()
        acceleration = None
        spring = 6 * self.scene.agents
        for c in self.contacts.values():
            _, _, h, u, vt, *_ = c.motion(y, self.scene)
            normal = c.normal_force(h, u)
            if not c.stateful:
                if acceleration is None:
                    acceleration = self._acceleration(whole)
                _, h1, u1, vt, _ = c.motion(y, self.scene, acceleration)
                out.append(self._hold(c, h1, u1, vt))
            else:
                test = -c.law.kt * y[spring] - c.law.gt * vt
                out.append(c.side * test - c.law.mu * c.sign * normal if c.side else c.law.mu * abs(normal) - abs(test))
                spring += 1
            out.append(c.sign * normal if c.law.gn else 1.0)  # undamped it never pulls
        return np.array(out)

    def _acceleration(self, whole):
        """Shifted so that agent a's stand at 6 a, as in the state."""
        d = self._derivative(0.0, whole)
        out = [0.0] * (6 * self.scene.agents)
        for a in range(self.scene.agents):
            out[6 * a : 6 * a + 3] = d[6 * a + 3 : 6 * a + 6]
        return out

    @staticmethod
    def _hold(c, h1, u1, vt):
        """Rate at which F*, let go from the cone, would leave it [N/s], without gamma_t: positive while it slides on."""
        law = c.law
        return c.side * -law.kt * vt - law.mu * c.sign * (law.kn * h1 + law.gn * u1)

    # Changes of the equations.

    def _begin(self, c):
        _, _, h, u, vt, *_, h1 = c.motion(self.y.tolist(), self.scene)
        normal = c.normal_force(h, u)
        c.sign = math.copysign(1.0, normal)
        test = -c.law.gt * vt
        limit = c.law.mu * abs(normal)
        if c.law.gn == c.law.gt == 0 and h < 1e-11:  # undamped, both start at zero: whichever grows faster decides
            test, limit = -c.law.kt * vt, c.law.mu * c.law.kn * h1
            c.sign = 1.0
        if abs(test) > limit:
            c.side = int(math.copysign(1, test))
            self.counts["slides at once"] += 1
        self.counts["contacts"] += 1
        self.counts[c.kind] += 1

    def _go_on(self, c, before):
        """A contact passes on along a line. Where the normal or the material jumps, it may now stick or slide."""
        self.counts["contacts"] += 1
        self.counts[c.kind] += 1
        y = self.y.tolist()
        n, _, h, u, vt, *_ = c.motion(y, self.scene)
        was = before.motion(y, self.scene)
        c.s, c.side, c.sign = before.s, before.side, before.sign
        if abs(n - was[0]) < 1e-6 and c.law is before.law:
            self.counts["goes on straight"] += 1
            return
        self.counts["goes on around a bend"] += 1
        if not before.stateful:
            c.s = -before.tangential_force(before.normal_force(was[2], was[3]), 0.0, 0.0) / before.law.kt
        normal, test = c.normal_force(h, u), -c.law.kt * c.s - c.law.gt * vt
        c.sign = math.copysign(1.0, normal)
        c.side = int(math.copysign(1, test)) if abs(test) > c.law.mu * abs(normal) else 0

    def _pair_up(self):
        """Which faces act together at an inner corner now."""
        faces = [c for c in self.contacts.values() if c.kind == "face"]
        for c in faces:
            others = [o for o in faces if o.i == c.i and (c.number, o.number) in self.scene.pairs]
            assert len(others) <= 1, "three faces act together"
            before, c.pair = c.pair, None
            for o in others:
                _, normal, cosine = self.scene.pairs[c.number, o.number]
                c.pair = (o.point, normal, cosine)
                self.counts["two faces"] += before is None

    def _let_go(self, c):
        """Sliding -> sticking: the elongation goes on from where sliding left it."""
        if not c.stateful:
            _, _, h, u, *_ = c.motion(self.y.tolist(), self.scene)
            c.s = -c.tangential_force(c.normal_force(h, u), 0.0, 0.0) / c.law.kt
        c.side = 0
        self.counts["sticks again"] += 1

    def _settle(self):
        """A jump of the accelerations (a contact began or ended, the drive changed) may end sliding without gamma_t."""
        for c in self.contacts.values():
            if not c.stateful:
                _, h1, u1, vt, _ = c.motion(self.y.tolist(), self.scene, self._acceleration(self._whole()))
                if self._hold(c, h1, u1, vt) < -TINY["release"]:
                    self._let_go(c)

    def _happen(self, kind, n):
        c = self.contacts.get(n)
        if kind == "touch":
            # A face and a corner take over from each other at the same instant: all at their limit go where they are heading.
            whole = self._whole()
            ahead = self.scene.touching(whole + 1e-9 * self._derivative(0.0, whole))
            at_limit = set(np.flatnonzero(np.abs(self.scene.touching(whole)) < 1e-11)) | {n}
            ending = [m for m in at_limit if m in self.contacts and ahead[m] < 0]
            beginning = [m for m in at_limit if m not in self.contacts and ahead[m] > 0]
            assert ending or beginning, "a touch without depth"
            if ending and beginning:
                self.counts["passes on"] += 1
            gone = {}
            for m in ending:
                gone[self.scene.line_of(m)] = self.contacts.pop(m)
                self.counts["ends"] += 1
            gone.pop(None, None)
            for m in beginning:
                self.contacts[m] = Contact(self.scene, m)
            self._pair_up()
            for m in beginning:
                before = gone.get(self.scene.line_of(m))
                self._go_on(self.contacts[m], before) if before else self._begin(self.contacts[m])
        elif kind == "stick":
            _, _, h, u, vt, *_ = c.motion(self.y.tolist(), self.scene)
            c.side = int(math.copysign(1, -c.law.kt * c.s - c.law.gt * vt))
            c.sign = math.copysign(1.0, c.normal_force(h, u))
            self.counts["starts to slide"] += 1
        elif kind in ("slide", "release"):
            self._let_go(c)
        else:
            c.sign = -c.sign
            self.counts["pulls" if c.sign < 0 else "pushes again"] += 1
            if c.law.gt:
                return
            # Without gamma_t the test force passes through zero with the normal force: whichever grows faster decides.
            _, h1, u1, vt, _ = c.motion(self.y.tolist(), self.scene, self._acceleration(self._whole()))
            growth = -c.law.kt * vt
            if abs(growth) > c.law.mu * abs(c.law.kn * h1 + c.law.gn * u1):
                if growth * c.side < 0:
                    self.counts["slides the other way"] += 1
                c.side = int(math.copysign(1, growth))
            else:
                self._let_go(c)

    def advance(self, end, drive=None):
        if drive is not None:
            self.drive = drive
        while self.t < end:
            self._settle()
            event = self._piece(end)
            if event:
                self.counts["events"] += 1
                assert self.counts["events"] <= 3000, "too many events"
                self._happen(*event)
        return self.y.reshape(-1, 6)

    def _commit(self, t, whole):
        self.t, self.y = t, whole[: 6 * self.scene.agents].copy()
        for c, s in zip(self._springs(), whole[6 * self.scene.agents :]):
            c.s = s

    def _piece(self, end):
        """Integrates until the equations change; returns the event, or None at `end`."""
        watched = self._watched()
        slack = np.array([TINY[kind] for kind, _ in watched])
        last_t, last_y = self.t, self._whole()
        if end - last_t < 1e-14:
            self.t = end
            return None
        solver = DOP853(self._derivative, last_t, last_y, end, max_step=MAX_STEP, rtol=self.tolerance, atol=ATOL * self.tolerance / RTOL)
        before = self._margins(last_y)
        while solver.status == "running":
            message = solver.step()
            assert solver.status != "failed", message
            dense, left = solver.dense_output(), last_t
            for right in np.linspace(last_t, solver.t, LOOKS + 1)[1:]:
                after = self._margins(dense(right))
                broken = np.flatnonzero(after < -slack)
                if broken.size:
                    first = min(self._first(watched, dense, k, left, right, before, slack) for k in broken)
                    self._land(last_t, last_y, first[0])
                    return watched[first[1]]
                left, before = right, after
            last_t, last_y = solver.t, solver.y
        self._commit(end, last_y)
        return None

    def _first(self, watched, dense, k, left, right, before, slack):
        """When event k happens, and which it is. Sticking contacts slide before their normal force is zero: the cone has no width there.
        Right after, they may stick again, so that no look would see it."""
        at = self._root(dense, k, left, right, before[k], slack[k])
        if watched[k][0] == "normal" and watched[k - 1][0] == "stick" and self._margins(dense(at))[k - 1] < -slack[k - 1]:
            k -= 1
            at = self._root(dense, k, left, at, before[k], slack[k])
        return at, k

    def _root(self, dense, k, left, right, before, slack):
        shift = 0.0 if before > 0 else slack  # just begun: zero but for round-off
        assert before + shift > 0, "an event right after another"
        return brentq(lambda t: self._margins(dense(t))[k] + shift, left, right, xtol=1e-16, rtol=1e-15)

    def _land(self, t, whole, at):
        """Integrates to the event itself: the dense output is for finding it only."""
        if at > t:
            solver = DOP853(self._derivative, t, whole, at, first_step=at - t, rtol=self.tolerance, atol=ATOL * self.tolerance / RTOL)
            while solver.status == "running":
                solver.step()
            whole = solver.y
        self._commit(at, whole)


def solve(case, perturbation=None, tolerance=RTOL):
    """Poses and twists (x, y, theta, vx, vy, omega of each agent) at the case's communication points, and the simulation."""
    simulation = Simulation(case["files"], perturbation, tolerance)
    states = [simulation.advance(t, drive).tolist() for t, drive in zip(case["times"], case["drive"])]
    return states, simulation


# --- the cases ---------------------------------------------------------------------------------------------------


def solved(case):
    """The case with its solution, and how well conditioned that is."""
    states, simulation = solve(case)
    shift = 1e-9 * np.random.default_rng(case["seed"]).uniform(-1, 1, len(simulation.y))
    case["states"] = np.round(states, 13).tolist()
    case["happens"] = {what: n for what, n in sorted(simulation.counts.items()) if n}
    for name, arguments in (("moved", (shift,)), ("loose", (None, 1e-10))):
        case[name] = float(f"{np.abs(np.array(solve(case, *arguments)[0]) - states).max():.1e}")
    return case


if __name__ == "__main__":
    path = Path(sys.argv[1])
    solutions = [json.dumps(solved(case), separators=(",", ":")) for case in json.loads(path.read_text())]
    path.write_text("[\n" + ",\n".join(solutions) + "\n]\n")
