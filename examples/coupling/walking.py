"""What the couplings of this directory share: a Trial of people at given places, how they walk to an aim, the squeeze over a second.

The walking is the collision-free speed model (Tordeux, Chraibi, Seyfried 2016) with one addition: who is held up presses on. It is no
model that was compared with experiments; those of decision.toml are (docs/walking.md), but their ways are fixed when a run begins.
"""

import math
from collections import deque
from pathlib import Path

import lemons_fmu
import numpy as np

STEP = 0.05  # s, communication step
LENGTH = 0.36  # m, diameter of a person for the walking rule, between chest depth and shoulder breadth
TIME_GAP = 0.5  # s, to who is ahead
STRENGTH, RANGE = 5.0, 0.08  # 1, m: how people turn aside from others
BACK = (0.05, 0.2)  # m/s: how fast people step back from others, who press and who do not
NEAR = 0.5  # m, from the aim: there people slow down
FREE = (1.34, 0.26)  # m/s, desired speeds: mean and standard deviation (Weidmann 1993)


def write_trial(directory, places, gazes, walls, seed):
    """Writes a Trial of people drawn from body statistics, at places (N, 2) [m] with gazes (N,) [rad], between walls (lists of corners)."""
    trial = lemons_fmu.crowd(number=len(places), seed=seed, packing="grid", orientation="fixed", time_step=STEP, output=directory)
    corners = ["".join(f'<Corner Coordinates="{x:.6f},{y:.6f}"/>' for x, y in wall) for wall in walls]
    text = "".join(f'<Wall Id="{k}" MaterialId="concrete">{each}</Wall>\n' for k, each in enumerate(corners))
    Path(directory, "static", "Geometry.xml").write_text(f"<Geometry>\n{text}</Geometry>\n")
    text = "".join(
        f'<Agent Id="{i}"><Kinematics Position="{x:.6f},{y:.6f}" Velocity="0,0" Theta="{gaze:.6f}" Omega="0"/>'
        f'<Dynamics Fp="0,0" Mp="0"/></Agent>\n'
        for i, ((x, y), gaze) in zip(trial.ids, zip(places, gazes))
    )
    Path(directory, "dynamic", "AgentDynamics.xml").write_text(f"<Agents>\n{text}</Agents>\n")
    return lemons_fmu.Trial(directory)


class Bodies:
    """The disks of the people of a Trial, wherever they are."""

    def __init__(self, shapes):
        self.owner = np.repeat(np.arange(len(shapes)), [len(shape) for shape in shapes])
        self.x, self.y, self.radius = np.concatenate(shapes).T

    def disks(self, poses):
        """Centres and radii [m] of all disks at poses (N, 3), shape (disks, 3)."""
        x, y, theta = poses[self.owner].T
        cos, sin = np.cos(theta), np.sin(theta)
        return np.column_stack([x + cos * self.x - sin * self.y, y + sin * self.x + cos * self.y, self.radius])

    def fits(self, person, poses, there):
        """Whether nobody who is there touches the person."""
        disks = self.disks(poses)
        own, others = disks[self.owner == person], disks[there[self.owner] & (self.owner != person)]
        between = np.hypot(own[:, None, 0] - others[:, 0], own[:, None, 1] - others[:, 1])
        return bool((between > own[:, None, 2] + others[:, 2]).all())

    def draw(self, axes, poses, squeeze, most):
        """Draws those who are there (poses are not NaN), coloured by squeeze [N]; returns what a colour bar needs."""
        from matplotlib.collections import EllipseCollection
        from matplotlib.colors import LinearSegmentedColormap

        colours = LinearSegmentedColormap.from_list("squeeze", ["#a9c3dd", "#f2b134", "#d1495b", "#5b0a2c"])
        disks = self.disks(poses)
        there = ~np.isnan(disks[:, 0])
        size, angles = 2 * disks[there, 2], np.zeros(there.sum())
        drawn = EllipseCollection(size, size, angles, units="xy", offsets=disks[there, :2], offset_transform=axes.transData, cmap=colours, zorder=2)
        drawn.set_array(np.asarray(squeeze)[self.owner][there])
        drawn.set_clim(0.0, most)
        return axes.add_collection(drawn)


def desired_speeds(number, random):
    mean, spread = FREE
    return mean + spread * np.clip(random.standard_normal(number), -2, 2)


class Walkers:
    """Drives of the people of a Crowd who walk to aims; and their squeeze, averaged over a second. `random` says who presses how
    much: each between nothing and twice as much, drawn again each second. So people do not hold each other in an arch for ever."""

    def __init__(self, crowd, speeds, inertias, random):
        self.crowd, self.speeds, self.random = crowd, speeds, random
        self.rates = np.array([[crowd[f"agent[{i}].{rate}"] for rate in ("FloorDamping", "AngularDamping")] for i in range(len(crowd))])
        self.weights, self.inertias = crowd.masses() * self.rates[:, 0], inertias
        self.last, self.steps = deque(maxlen=round(1 / STEP)), 0

    def step(self, ways, rests, press=0.0):
        """One communication step. `ways`: where each walks to next, (N, 2) [m]. `rests`: how far the whole way is, (N,) [m].
        `press`: the speed that who is held up still wants [m/s], of all or of each; who stands so presses with
        mass * FloorDamping * press."""
        there = np.asarray(self.crowd.active)
        if self.steps % self.last.maxlen == 0:
            self.eager = self.random.uniform(0.0, 2.0, len(there))
        self.steps += 1
        press = press * self.eager
        drive = np.zeros((len(there), 3))
        poses = self.crowd.poses()
        wanted = desired(poses[there, :2], ways[there], rests[there], self.speeds[there], press[there])
        drive[there, :2] = self.weights[there, None] * wanted
        # M_p = -I dtheta / t_rot^2, for who walks.
        turn = np.arctan2(wanted[:, 1], wanted[:, 0]) - poses[there, 2]
        turn = np.where(np.hypot(*wanted.T) > 0.1, (turn + math.pi) % (2 * math.pi) - math.pi, 0.0)
        drive[there, 2] = self.inertias[there] * self.rates[there, 1] ** 2 * turn
        self.crowd.set_drive(drive)
        self.crowd.step()
        self.last.append(self.crowd.mean_squeeze())

    def squeeze(self):
        """Mean squeeze of each person over the last second [N], shape (N,)."""
        return np.mean(self.last, axis=0) if len(self.last) == self.last.maxlen else np.zeros(len(self.crowd))


def desired(places, ways, rests, speeds, press):
    """Desired velocities [m/s], shape (N, 2)."""
    way = ways - places
    towards = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    between = places[None] - places[:, None]  # [i, j]: from i to j
    distance = np.linalg.norm(between, axis=2)
    np.fill_diagonal(distance, np.inf)
    away = -between / distance[..., None]
    course = towards + (STRENGTH * np.exp((LENGTH - distance) / RANGE)[..., None] * away).sum(axis=1)
    course /= np.maximum(np.linalg.norm(course, axis=1, keepdims=True), 1e-9)
    ahead = (between * course[:, None]).sum(axis=2)
    beside = np.abs(between[..., 0] * course[:, None, 1] - between[..., 1] * course[:, None, 0])
    gap = np.where((ahead > 0) & (beside < LENGTH), distance - LENGTH, np.inf).min(axis=1, initial=np.inf)
    free = speeds * np.minimum(rests / NEAR, 1.0)
    press = np.minimum(press, free)
    # Who would turn round to get away from others only steps back.
    turned = (course * towards).sum(axis=1) < 0
    speed = np.minimum(np.clip(gap / TIME_GAP, 0.0, free), np.where(turned, np.where(press > 0, *BACK), np.inf))
    return course * speed[:, None] + towards * np.maximum(press - speed, 0.0)[:, None]
