"""JuPedSim routes, our bodies move: visitors queue at a gate with two lanes, wait in a hall, and leave together.

    python examples/coupling/jupedsim_queue.py [--people N] [--seed N] [--plot PICTURE.png]

JuPedSim 1.4 has the journeys, the queues and the waiting set; each of its agents is the ghost of one of our bodies. In each
communication step the ghosts go to where the bodies are, JuPedSim decides, and the bodies walk to the targets of their ghosts.
Beside it the same scene runs in JuPedSim alone. docs/guide/other-simulators.md says how the ghosts are moved; its picture is that
of `--plot docs/guide/queue.png`.
"""

import argparse
import math
import tempfile
from dataclasses import dataclass, field

import jupedsim
import numpy as np
from lemons_fmu import Crowd
from shapely import Point, Polygon, box, unary_union
from shapely.ops import nearest_points
from walking import LENGTH, STEP, Bodies, Walkers, desired_speeds, write_trial

GATE, LANES, WIDTH = (9.0, 10.5), (2.4, 4.6), 0.9  # m: from x to x; middles of the lanes; their width
DOOR = (20.0, 3.5, 1.2)  # m: x, middle, width
AREA = unary_union(
    [
        box(0, 0, GATE[0], 7),
        *(box(GATE[0], y - WIDTH / 2, GATE[1], y + WIDTH / 2) for y in LANES),
        box(GATE[1], 0, DOOR[0], 7),
        box(DOOR[0], DOOR[1] - DOOR[2] / 2, DOOR[0] + 0.2, DOOR[1] + DOOR[2] / 2),
        box(DOOR[0] + 0.2, 1, DOOR[0] + 3, 6),
    ]
)
OUT = (DOOR[0] + 1.2, 1.0, DOOR[0] + 3, 6.0)  # m, exit area
SERVICE, RELEASE, END = 2.0, 80.0, 150.0  # s: one visitor of each lane; when the hall may leave; the end of a run
PRESS = 0.15  # m/s, of those who leave: about 50 N on who is ahead
WALL = 0.25  # m, ways keep off walls
GHOST = {"desired_speed": 0.0, "reaction_time": 1e9, "agent_scale": 0.0, "obstacle_scale": 0.0, "force_distance": 1.0, "radius": 0.01}


@dataclass
class Log:
    """What a run says, at each communication step."""

    times: list = field(default_factory=list)  # s
    poses: list = field(default_factory=list)  # (N, 3); NaN: has left
    squeeze: list = field(default_factory=list)  # (N,), mean over 1 s; empty in JuPedSim alone
    served: list = field(default_factory=list)  # persons, in the order in which their queue has let them go
    farthest: float = 0.0  # m, of a ghost from its body

    @property
    def places(self):
        return np.array(self.poses)[..., :2]

    def passed(self, x):
        """When each has passed this x first; inf: never."""
        beyond = np.nan_to_num(self.places[..., 0], nan=np.inf) > x
        return np.where(beyond.any(axis=0), np.array(self.times)[beyond.argmax(axis=0)], np.inf)

    def greatest(self, x0, x1):
        """The greatest squeeze of anybody between x0 and x1."""
        x = self.places[..., 0]
        return np.array(self.squeeze)[(x >= x0) & (x < x1)].max(initial=0.0)


class Routes:
    """The scene in JuPedSim: who stands in which queue, who waits, who leaves."""

    def __init__(self, model, step, places, agents):
        self.simulation = simulation = jupedsim.Simulation(model=model, geometry=AREA, dt=step)
        # Half of them stand in each lane: those who are nearer to it.
        lanes = (np.argsort(np.argsort(places[:, 1])) >= len(places) / 2).astype(int)
        fixed = jupedsim.Transition.create_fixed_transition
        queues = [simulation.add_queue_stage([(GATE[0] - 0.3 - 0.6 * k, y) for k in range(12)]) for y in LANES]
        # The places near the door first, so that nobody has to pass those who wait.
        rows = [(DOOR[0] - 1.2 - 0.8 * column, 0.7 + 0.8 * row) for column in range(9) for row in range(8)]
        waiting = simulation.add_waiting_set_stage(rows)
        out = simulation.add_exit_stage([(OUT[0], OUT[1]), (OUT[2], OUT[1]), (OUT[2], OUT[3]), (OUT[0], OUT[3])])
        journey = jupedsim.JourneyDescription([*queues, waiting, out])
        for queue in queues:
            journey.set_transition_for_stage(queue, fixed(waiting))
        journey.set_transition_for_stage(waiting, fixed(out))
        journey = simulation.add_journey(journey)
        self.persons = {simulation.add_agent(agent(journey, queues[lane])): i for i, (agent, lane) in enumerate(zip(agents, lanes))}
        self.queues = [simulation.get_stage(queue) for queue in queues]
        self.waiting, self.served = simulation.get_stage(waiting), []
        self.each, self.done = round(SERVICE / step), 0

    def step(self, release):
        """Serves and releases, and then one iteration of JuPedSim."""
        self.done += 1
        if self.done % self.each == 0:
            for queue in self.queues:
                self.served.extend(self.persons[agent] for agent in queue.enqueued()[:1])
                queue.pop(1)
        if release:
            self.waiting.state = jupedsim.stages.WaitingSetState.INACTIVE
        self.simulation.iterate()

    def agents(self):
        """(person, agent) of all who have not left."""
        return [(self.persons[agent.id], agent) for agent in self.simulation.agents()]


def start(number, seed):
    """Places of visitors before the gate, one per square of 0.75 m, and their desired speeds."""
    random = np.random.default_rng(seed)
    squares = np.array([(0.75 + 0.75 * i, 0.5 + 0.75 * j) for i in range(8) for j in range(9)])
    places = random.permutation(squares)[:number] + random.uniform(-0.05, 0.05, (number, 2))
    return places, desired_speeds(number, random)


class Ways:
    """Ways around walls, of JuPedSim's RoutingEngine. They keep off walls."""

    def __init__(self):
        self.area = AREA.buffer(-WALL, join_style="mitre")
        self.engine, self.within = jupedsim.RoutingEngine(self.area), self.area.buffer(-1e-6)

    def inside(self, place):
        return place if self.engine.is_routable(place) else nearest_points(self.within, Point(place))[0].coords[0]

    def next(self, place, target):
        """The next way-point, and how far it is to the target."""
        if math.dist(place, target) < 2 * LENGTH:
            return target, math.dist(place, target)
        points = self.engine.compute_waypoints(self.inside(place), self.inside(target))[1:]
        ahead = next((point for point in points if math.dist(place, point) > 0.2), target)
        return ahead, math.dist(place, target)


def coupled(number, seed, end=END):
    """The run in which JuPedSim routes and our bodies move."""
    places, speeds = start(number, seed)
    log, ways = Log(), Ways()
    agents = [
        lambda journey, stage, place=tuple(place): jupedsim.SocialForceModelAgentParameters(
            position=place, journey_id=journey, stage_id=stage, **GHOST
        )
        for place in places
    ]
    routes = Routes(jupedsim.SocialForceModel(body_force=0.0, friction=0.0), STEP, places, agents)
    with tempfile.TemporaryDirectory() as scratch:
        rings = [AREA.exterior, *AREA.interiors]
        trial = write_trial(f"{scratch}/trial", places, np.zeros(number), [list(ring.coords) for ring in rings], seed)
        with Crowd(trial, decision=False) as crowd:
            walkers = Walkers(crowd, speeds, trial.inertias, np.random.default_rng(seed + 1))
            while crowd.time < end and np.any(crowd.active):
                bodies = crowd.poses()[:, :2]
                for person, ghost in routes.agents():
                    (x, y), (to_x, to_y) = ghost.position, bodies[person]
                    # A social force model without forces: the ghost keeps this velocity for its step, and gets there.
                    ghost.model.velocity = ((to_x - x) / STEP, (to_y - y) / STEP)
                routes.step(release=crowd.time >= RELEASE)
                next_, rests, there = bodies.copy(), np.zeros(number), np.zeros(number, bool)
                for person, ghost in routes.agents():
                    there[person] = True
                    log.farthest = max(log.farthest, math.dist(ghost.position, bodies[person]))
                    next_[person], rests[person] = ways.next(tuple(bodies[person]), ghost.target)
                if (there != crowd.active).any():
                    crowd.active = there
                walkers.step(next_, rests, PRESS if crowd.time >= RELEASE else 0.0)
                log.times.append(crowd.time)
                log.poses.append(np.where(there[:, None], crowd.poses(), np.nan))
                log.squeeze.append(walkers.squeeze())
    log.served = routes.served
    return log, Bodies(trial.shapes)


def alone(number, seed, end=END, step=0.01):
    """The same scene in JuPedSim alone, with its collision-free speed model V2."""
    places, speeds = start(number, seed)
    log = Log()
    agents = [
        lambda journey, stage, place=tuple(place), speed=speed: jupedsim.CollisionFreeSpeedModelV2AgentParameters(
            position=place, journey_id=journey, stage_id=stage, desired_speed=speed, radius=0.15
        )
        for place, speed in zip(places, speeds)
    ]
    routes = Routes(jupedsim.CollisionFreeSpeedModelV2(), step, places, agents)
    while routes.done * step < end and routes.simulation.agent_count():
        routes.step(release=routes.done * step >= RELEASE)
        if routes.done % round(STEP / step) == 0:
            log.times.append(routes.done * step)
            log.poses.append(np.full((number, 3), np.nan))
            for person, agent in routes.agents():
                log.poses[-1][person, :2] = agent.position
    log.served = routes.served
    return log


def table(runs, number):
    """Rows of what happens when: the number of people, and the time in each run."""
    rows = []
    for name, x in [("through the gate", GATE[1]), ("through the door", DOOR[0])]:
        for count in [number // 4, number // 2, 3 * number // 4, number]:
            times = [np.sort(log.passed(x))[count - 1] for log in runs]
            rows.append((f"{count} people {name}", *(f"{time:.1f} s" if np.isfinite(time) else "never" for time in times)))
    for name, x0, x1 in [("before the gate", 0, GATE[0]), ("in the lanes", *GATE), ("in the hall and the door", GATE[1], DOOR[0] + 0.3)]:
        rows.append((f"greatest squeeze {name}", f"{runs[0].greatest(x0, x1):.0f} N", "no forces"))
    return rows


def plot(path, logs, bodies):
    import matplotlib.pyplot as plt

    ours, theirs = logs
    number = len(ours.squeeze[0])
    figure, axes = plt.subplots(3, figsize=(8, 10), height_ratios=[3.2, 5, 3.6], layout="constrained")
    most = np.max(ours.squeeze)
    for plan, moment, title in zip(axes, [20.0, RELEASE + 10.0], ["the queues are served", "the hall leaves"]):
        at = min(round(moment / STEP), len(ours.times)) - 1
        for ring in [AREA.exterior, *AREA.interiors]:
            plan.plot(*ring.xy, color="0.2", lw=1.5)
        x, y = theirs.places[min(at, len(theirs.places) - 1)].T
        plan.scatter(x, y, s=12, facecolor="none", edgecolor="0.1", lw=0.9, zorder=3, label="where they are in JuPedSim alone")
        drawn = bodies.draw(plan, ours.poses[at], ours.squeeze[at], most)
        plan.set(aspect="equal", xlim=(-0.2, DOOR[0] + 3.2), ylim=(-0.2, 7.2), ylabel="y [m]", title=f"{moment:.0f} s: {title}")
    axes[1].set(xlim=(13, DOOR[0] + 3.2), xlabel="x [m]")
    axes[1].legend(loc="lower left", fontsize=9)
    figure.colorbar(drawn, ax=axes[:2], label="mean squeeze over 1 s [N]", shrink=0.8)
    for log, style, name in [(ours, "-", "with bodies"), (theirs, "--", "JuPedSim alone")]:
        for x, colour, where in [(GATE[1], "tab:blue", "gate"), (DOOR[0], "tab:red", "door")]:
            times = np.sort(log.passed(x))
            times = times[np.isfinite(times)]
            axes[2].step([0, *times], range(len(times) + 1), style, where="post", color=colour, label=f"{where}, {name}")
    axes[2].axvline(RELEASE, color="0.7", lw=1, zorder=0)
    axes[2].annotate("release", (RELEASE, number), (-3, 0), textcoords="offset points", ha="right", va="top", color="0.4")
    axes[2].set(xlabel="time [s]", ylabel="people who have passed", xlim=0, ylim=(0, number + 2))
    axes[2].legend(frameon=False, loc="upper left", fontsize=9)
    for each in axes:
        each.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=85)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", metavar="N", type=int, default=60, help="visitors, 4 to 72; default 60")
    parser.add_argument("--seed", metavar="N", type=int, default=1, help="of places, bodies and speeds; default 1")
    parser.add_argument("--plot", metavar="PICTURE.png", help="draws the run")
    arguments = parser.parse_args()
    if not 4 <= arguments.people <= 72:
        parser.error("--people: must be 4 to 72")
    (log, bodies), beside = coupled(arguments.people, arguments.seed), alone(arguments.people, arguments.seed)
    logs = [log, beside]
    print(f"{'':40}  {'with bodies':>12}  {'JuPedSim alone':>14}")
    for name, ours, theirs in table(logs, arguments.people):
        print(f"{name:40}  {ours:>12}  {theirs:>14}")
    print(f"farthest ghost from its body: {logs[0].farthest:.1e} m")
    if arguments.plot:
        plot(arguments.plot, logs, bodies)


if __name__ == "__main__":
    main()
