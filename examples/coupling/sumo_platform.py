"""SUMO runs the trains, our bodies fill the platform: when the squeeze passes a limit, the next train is held.

    python examples/coupling/sumo_platform.py [--limit N] [--seed N] [--plot PICTURE.png]

Local trains bring passengers to Central, where they change to an express. The express is late, so that the platform fills. The
passengers who get off are bodies: they walk to where they want to wait, and press when they are held up. When somebody's mean squeeze
over a second passes the limit, the next local train stays at West, the station before, until half of the people have gone. The script
runs the same day without and with that rule. docs/guide/other-simulators.md has the results; its
picture is that of `--plot docs/guide/platform.png`.
"""

import argparse
import math
import os
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from lemons_fmu import Crowd
from walking import STEP, Bodies, Walkers, desired_speeds, write_trial

SECOND = 0.5  # s, step of SUMO
LINE = [0, 200, 400, 560, 860]  # m, where the blocks of the line begin and end; a signal between each two
STOPS = {"west": "e0", "central": "e2"}  # the blocks where the trains stop, their heads at 140 m
LOCALS, PASSENGERS, HEADWAY = 4, 45, 60.0  # trains; passengers of each; s
EXPRESSES = [240.0, 420.0]  # s: when they come from a branch after West; the first one is late
DWELL, TRAVEL = 20.0, 40.0  # s: stops; from West to Central by the timetable
ALIGHT = 0.25  # s, from one passenger to the next, of all doors together
PLATFORM = (12.0, 3.0)  # m: x, y; the trains stand along y = 0
DOORS = [1.5, 4.5, 7.5, 10.5]  # m, of each train; between them the platform has doors, too, so that nobody falls
PRESS = 0.3  # m/s, of who is held up: about 100 N on who is ahead
NEAR, SETTLE = 0.7, 10.0  # m, s: who is so near to the chosen place, or has been here so long, stands and gives way
DOORWAY = 0.8  # m around a door, where nobody stands
LIMIT, END = 250.0, 600.0  # N; s, the end at the latest


def write_sumo(directory):
    """Writes the line, its stops, the trains and their passengers. A line this simple needs no tool of SUMO."""
    edges = range(len(LINE) - 1)
    network = ['<net version="1.20">', f'<location netOffset="0,0" convBoundary="0,0,{LINE[-1]},0" origBoundary="0,0,1,1" projParameter="!"/>']
    for k in edges:
        shape = f'length="{LINE[k + 1] - LINE[k]}" shape="{LINE[k]},0 {LINE[k + 1]},0"'
        network.append(f'<edge id="e{k}" from="j{k}" to="j{k + 1}"><lane id="e{k}_0" index="0" allow="rail" speed="20" {shape}/></edge>')
    for k, x in enumerate(LINE):
        signal = 0 < k < len(LINE) - 1
        kind, request = ("rail_signal", '<request index="0" response="0" foes="0" cont="0"/>') if signal else ("dead_end", "")
        incoming = f"e{k - 1}_0" if k else ""
        network.append(f'<junction id="j{k}" type="{kind}" x="{x}" y="0" incLanes="{incoming}" intLanes="" shape="{x},1 {x},-1">{request}</junction>')
    network += [f'<connection from="e{k - 1}" to="e{k}" fromLane="0" toLane="0" tl="j{k}" linkIndex="0" dir="s" state="o"/>' for k in edges[1:]]
    stops = [f'<busStop id="{name}" lane="{edge}_0" startPos="60" endPos="140"/>' for name, edge in STOPS.items()]
    routes = [
        f'<vType id="train" vClass="rail" length="40" accel="1" decel="1" sigma="0" personCapacity="1000" boardingDuration="{ALIGHT}"/>',
        f'<route id="line" edges="{" ".join(f"e{k}" for k in edges)}"/>',
    ]
    plan = f'<ride from="e0" busStop="central" lines="%s"/><stop busStop="central" duration="{END}"/><ride to="e3" lines="express"/>'
    for k in range(LOCALS):
        train, leaves = f"local{k}", k * HEADWAY + DWELL
        routes.append(f'<vehicle id="{train}" type="train" route="line" depart="{k * HEADWAY}" departPos="stop">')
        routes.append(f'<stop busStop="west" duration="{DWELL}" until="{leaves}"/>')
        routes.append(f'<stop busStop="central" duration="{DWELL}" until="{leaves + TRAVEL + DWELL}"/></vehicle>')
        routes += [f'<person id="{train}.{i}" depart="triggered">{plan % train}</person>' for i in range(PASSENGERS)]
    for k, comes in enumerate(EXPRESSES):
        stop = f'<route edges="e1 e2 e3"/><stop busStop="central" duration="{DWELL}"/>'
        routes.append(f'<vehicle id="express{k}" line="express" type="train" depart="{comes}">{stop}</vehicle>')
    for name, root, lines in [("network", None, [*network, "</net>"]), ("stops", "additional", stops), ("routes", "routes", routes)]:
        text = "\n".join([f"<{root}>", *lines, f"</{root}>"] if root else lines)
        Path(directory, f"{name}.xml").write_text(text + "\n")


class Line:
    """The trains and their passengers in SUMO."""

    def __init__(self, directory):
        # Without its data SUMO's library warns that it has no home. It needs none here.
        os.environ.setdefault("SUMO_HOME", str(directory))
        import libsumo

        write_sumo(directory)
        self.sumo, self.waits = libsumo, libsumo.constants.STAGE_WAITING
        files = {"net-file": "network", "additional-files": "stops", "route-files": "routes", "tripinfo-output": "trips", "stop-output": "stood"}
        quiet = ["--xml-validation=never", "--no-step-log", "--duration-log.disable", "--time-to-teleport=-1"]
        options = [*(f"--{option}={directory}/{file}.xml" for option, file in files.items()), *quiet, f"--step-length={SECOND}"]
        libsumo.start(["sumo", *options])

    def step(self):
        self.sumo.simulationStep()

    def waiting(self):
        """Names of the passengers who have got off at Central, and have not been told to go on."""
        persons = self.sumo.busstop.getPersonIDs("central")
        return [person for person in persons if self.sumo.person.getStage(person).type == self.waits]

    def at(self, stop):
        """The train that stands at a stop, or None."""
        vehicle = self.sumo.vehicle
        return next((train for train in vehicle.getIDList() if vehicle.isStopped(train) and vehicle.getLaneID(train) == f"{STOPS[stop]}_0"), None)

    def keep(self, train, stop):
        """Lets the train, which stands there, stay at least until the next step. Returns whether it would have left."""
        # [s] `duration` is what is left of the stop.
        left, until = (getattr(self.sumo.vehicle.getStops(train, 1)[0], name) for name in ("duration", "until"))
        self.sumo.vehicle.setBusStop(train, stop, duration=max(left, 2 * SECOND), until=until)
        return left < 2 * SECOND

    def board(self, person):
        """Ends the waiting of a passenger, whose next stage is to ride in the express."""
        self.sumo.person.removeStage(person, 0)

    def is_over(self):
        return self.sumo.simulation.getMinExpectedNumber() == 0


@dataclass
class Log:
    """What a run says, at each step of SUMO."""

    times: list = field(default_factory=list)  # s
    squeeze: list = field(default_factory=list)  # N, the greatest of anybody, mean over 1 s
    people: list = field(default_factory=list)  # on the platform, with those who stand in the doors
    boarding: list = field(default_factory=list)  # whether the express is there
    held: dict = field(default_factory=dict)  # train: how long it was held at West [s]
    waited: dict = field(default_factory=dict)  # person: how long he or she was at Central [s]
    worst: tuple = ()  # time, poses (NaN: not there) and squeeze of all, when the squeeze of those who wait was greatest
    delays: dict = field(default_factory=dict)  # train: its delay at West, as SUMO writes it [s]

    def greatest(self, boarding):
        """The greatest squeeze while an express is there, or while none is."""
        return np.array(self.squeeze)[np.array(self.boarding) == boarding].max(initial=0.0)


class Platform:
    """The bodies of all passengers, in the order of their trains. Who has not come yet, or has boarded, is not there."""

    def __init__(self, directory, number, seed):
        random = np.random.default_rng(seed)
        length, depth = PLATFORM
        # Each body begins in its door. Many have the same door: only one of them is there at a time.
        doors = np.column_stack([np.resize(DOORS, number), np.full(number, 0.35)]) + random.uniform(-0.05, 0.05, (number, 2))
        walls = [[(0, 0), (length, 0), (length, depth), (0, depth), (0, 0)]]
        trial = write_trial(f"{directory}/trial", doors, np.full(number, math.pi / 2), walls, seed)
        self.bodies = Bodies(trial.shapes)
        self.spots = doors + random.uniform((-1.4, 0.85), (1.4, depth - 0.65), (number, 2))  # m, where each wants to wait
        self.since = np.full(number, math.inf)  # s, when each has come
        self.crowd = Crowd(trial, {f"agent[{i}].Active": False for i in range(number)}, decision=False)
        self.walkers = Walkers(self.crowd, desired_speeds(number, random), trial.inertias, random)

    def step(self, time, off, boarding):
        """A step of SUMO that ends at this time: `off` have got off, and come as soon as there is room in their doors."""
        for _ in range(round(SECOND / STEP)):
            there, poses = np.asarray(self.crowd.active), self.crowd.poses()
            places = poses[:, :2]
            for i in off:
                if math.isinf(self.since[i]) and self.bodies.fits(i, poses, there):
                    there[i], self.since[i] = True, time
            if boarding:
                nearest = np.abs(places[:, :1] - DOORS).argmin(axis=1)
                aims = np.column_stack([np.take(DOORS, nearest), np.zeros(len(places))])
                there &= np.linalg.norm(places - aims, axis=1) > 0.5
            else:
                clear = np.hypot(places[:, :1] - DOORS, places[:, 1:]).min(axis=1) > DOORWAY
                settled = clear & ((np.linalg.norm(places - self.spots, axis=1) < NEAR) | (time - self.since > SETTLE))
                aims = np.where(settled[:, None], places, self.spots)
            self.crowd.active = there
            self.walkers.step(aims, np.linalg.norm(places - aims, axis=1), PRESS)

    def there(self):
        return np.asarray(self.crowd.active)

    def poses(self):
        """x, y [m] and theta [rad] of all, NaN for who is not there."""
        return np.where(self.there()[:, None], self.crowd.poses(), np.nan)


def run(directory, limit, seed):
    """A run; with a limit of infinity no train is held. SUMO's files are left in the directory. Returns the log, and the bodies."""
    names = [f"local{k}.{i}" for k in range(LOCALS) for i in range(PASSENGERS)]
    person = {name: i for i, name in enumerate(names)}
    train_of = np.array([name.split(".")[0] for name in names])
    line, platform, log = Line(directory), Platform(directory, len(names), seed), Log()
    off, crowded = {}, 0  # when each has got off; how many people there were when the limit was passed last
    while not line.is_over() and len(log.times) < END / SECOND:
        line.step()
        time = (len(log.times) + 1) * SECOND
        for name in line.waiting():
            off.setdefault(person[name], time)
        standing = line.at("central") or ""
        boarding = standing.startswith("express")
        platform.step(time, off, boarding)
        come, there = np.isfinite(platform.since), platform.there()
        for i in np.flatnonzero(come & ~there):
            if names[i] not in log.waited:
                line.board(names[i])
                log.waited[names[i]] = time - off[i]
        squeeze, people = platform.walkers.squeeze(), len(off) - len(log.waited)
        if squeeze.max() > limit:
            crowded = people
        elif people < crowded / 2:
            crowded = 0
        if standing and (there.any() if boarding else not come[train_of == standing].all()):
            line.keep(standing, "central")
        held = line.at("west")
        if held and crowded and line.keep(held, "west"):
            log.held[held] = log.held.get(held, 0.0) + SECOND
        log.times.append(time)
        log.squeeze.append(squeeze.max())
        log.people.append(people)
        log.boarding.append(boarding)
        if not boarding and squeeze.max() >= log.greatest(boarding=False):
            log.worst = time, platform.poses(), squeeze
    line.sumo.close()
    platform.crowd.close()
    for stop in ET.parse(f"{directory}/stood.xml").iter("stopinfo"):
        if stop.get("busStop") == "west":
            log.delays[stop.get("id")] = float(stop.get("delay"))
    return log, platform.bodies


def table(logs):
    """Rows of a name and a value of each run."""
    rows = [
        ("greatest squeeze of those who wait", [f"{log.greatest(boarding=False):.0f} N" for log in logs]),
        ("greatest squeeze of those who board", [f"{log.greatest(boarding=True):.0f} N" for log in logs]),
        ("most people on the platform", [str(max(log.people)) for log in logs]),
    ]
    return rows + [(f"local{k} leaves West late by", [f"{log.delays[f'local{k}']:.1f} s" for log in logs]) for k in range(LOCALS)]


def plot(path, logs, bodies, limit):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(4, figsize=(8, 9), height_ratios=[2.6, 2.6, 2.6, 2.2], layout="constrained")
    most = max(log.greatest(boarding=False) for log in logs)
    names, colours = ["no train is held", "trains are held"], ["tab:red", "tab:blue"]
    for plan, log, name in zip(axes, logs, names):
        time, poses, squeeze = log.worst
        drawn = bodies.draw(plan, poses, squeeze, most)
        length, depth = PLATFORM
        plan.plot([0, 0, length, length], [0, depth, depth, 0], color="0.2", lw=2)
        plan.plot([0, length], [0, 0], color="0.2", lw=2, zorder=1)
        for door in DOORS:
            plan.plot([door - 0.65, door + 0.65], [0, 0], color="white", lw=3, zorder=1)
        people = int((~np.isnan(poses[:, 0])).sum())
        plan.set(aspect="equal", xlim=(-0.2, length + 0.2), ylim=(-0.2, depth + 0.2), yticks=[0, depth], ylabel="y [m]")
        plan.set_title(f"{name}: {people} people at {time:.0f} s, the greatest squeeze of those who wait", fontsize=10)
    axes[1].set_xlabel("x [m]; the trains stand below")
    figure.colorbar(drawn, ax=axes[:2], label="mean over 1 s [N]", shrink=0.8)
    for log, name, colour in zip(logs, names, colours):
        axes[2].plot(log.times, log.squeeze, color=colour, lw=1.2, label=name)
        axes[3].plot(log.times, log.people, color=colour, lw=1.5)
    axes[2].axhline(limit, color="0.4", lw=1, ls="--", label="limit")
    axes[2].set(ylabel="greatest mean\nsqueeze over 1 s [N]")
    axes[2].legend(frameon=False, fontsize=9)
    axes[3].set(xlabel="time [s]", ylabel="people on\nthe platform")
    for each in axes[2:]:
        each.set(xlim=(40, max(log.times[-1] for log in logs)), ylim=0)
        each.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=85)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", metavar="N", type=float, default=LIMIT, help=f"of the squeeze [N]; default {LIMIT:g}")
    parser.add_argument("--seed", metavar="N", type=int, default=1, help="of bodies, speeds and places; default 1")
    parser.add_argument("--plot", metavar="PICTURE.png", help="draws both runs")
    arguments = parser.parse_args()
    logs = []
    for limit in (math.inf, arguments.limit):
        with tempfile.TemporaryDirectory() as directory:
            log, bodies = run(directory, limit, arguments.seed)
            logs.append(log)
    print(f"{'':36}  {'no train is held':>16}  {'trains are held':>15}")
    for name, (free, held) in table(logs):
        print(f"{name:36}  {free:>16}  {held:>15}")
    if arguments.plot:
        plot(arguments.plot, logs, bodies, arguments.limit)


if __name__ == "__main__":
    main()
