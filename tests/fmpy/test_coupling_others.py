"""The couplings with JuPedSim and SUMO, each compared with what the other simulator says itself."""

import importlib
import importlib.util
import os
import math
import pickle
import subprocess
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from crowd import REPOSITORY

pytestmark = pytest.mark.long

COUPLING = REPOSITORY / "examples" / "coupling"


#: A smaller day: two trains with 40 passengers, and half of the platform. In a process of its own: SUMO's library and pyarrow,
#: which other tests use, bring different versions of the same library.
DAY = """
import pickle, sys
import sumo_platform as platform

platform.LOCALS, platform.PASSENGERS, platform.EXPRESSES = 2, 40, [110.0, 230.0]
platform.PLATFORM, platform.DOORS = (6.0, 2.2), [1.5, 4.5]
logs = [platform.run(directory, limit, 1)[0] for directory, limit in (("free", float("inf")), ("held", float(sys.argv[1])))]
platform.plot("platform.png", logs, platform.run("again", float(sys.argv[1]), 1)[1], float(sys.argv[1]))
pickle.dump(logs, open("logs", "wb"))
"""


def skip_without(package):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: pip install {package}")


@pytest.fixture
def example(lemons, monkeypatch):
    """Imports a script of examples/coupling."""

    def example(name):
        monkeypatch.syspath_prepend(str(COUPLING))
        monkeypatch.setenv("LEMONS", str(lemons))
        return importlib.import_module(name)

    return example


@pytest.mark.parametrize("script, needs", [("jupedsim_queue", "jupedsim"), ("sumo_platform", "libsumo")])
def test_help_helps_and_makes_nothing(tmp_path, script, needs):
    skip_without(needs)
    done = subprocess.run([sys.executable, COUPLING / f"{script}.py", "--help"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert (COUPLING / f"{script}.py").read_text().splitlines()[0].strip('"') in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_jupedsim_routes_our_bodies(example, tmp_path, monkeypatch):
    skip_without("jupedsim")
    queue = example("jupedsim_queue")
    number, seen = 20, []

    class Seen(queue.Routes):
        """What JuPedSim itself says after each of its iterations."""

        def step(self, release):
            super().step(release)
            enqueued = [[self.persons[agent] for agent in each.enqueued()] for each in self.queues]
            seen.append(({person: agent.position for person, agent in self.agents()}, enqueued, len(self.waiting.waiting())))

    monkeypatch.setattr(queue, "Routes", Seen)
    monkeypatch.setattr(queue, "RELEASE", 40.0)
    log, bodies = queue.coupled(number, 1, end=90.0)
    # Ghosts are where the bodies were at the begin of the step: the first row of poses is of the end of the first one.
    for poses, (ghosts, _, _) in zip(log.poses, seen[1:]):
        for person, place in ghosts.items():
            assert math.dist(place, poses[person, :2]) < 1e-9
    assert log.farthest < 1e-9
    # Each of our bodies is served once, before it passes the gate, and all leave.
    assert sorted(log.served) == list(range(number))
    gate, door = log.passed(queue.GATE[1]), log.passed(queue.DOOR[0])
    assert np.isfinite(door).all() and np.isnan(log.poses[-1]).all() and (gate < queue.RELEASE).all() and (door > queue.RELEASE).all()
    # The first is served, if somebody stands there, at the end of each service: not faster than two lanes allow.
    assert (np.sort(gate)[2:] - np.sort(gate)[:-2] > 0.5 * queue.SERVICE).all() and gate.max() <= number / 2 * queue.SERVICE + 15
    # First come, first served: nobody in a queue of JuPedSim gets in front of who stood there before.
    for (_, before, _), (_, after, _) in zip(seen, seen[1:]):
        for old, new in zip(before, after):
            assert [person for person in old if person in new] == [person for person in new if person in old]
    assert max(waiting for _, _, waiting in seen) == number
    # In JuPedSim alone the gate serves as fast: it is the queue that limits.
    alone = queue.alone(number, 1, end=90.0)
    assert abs(np.sort(alone.passed(queue.GATE[1]))[-1] - gate.max()) < 2 * queue.SERVICE
    assert max(np.max(squeeze) for squeeze in log.squeeze) > 0
    queue.plot(tmp_path / "queue.png", [log, alone], bodies)
    assert (tmp_path / "queue.png").read_bytes().startswith(b"\x89PNG")


def stops(directory, key):
    found = ET.parse(directory / "stood.xml").iter("stopinfo")
    return {stop.get("id"): {name: float(stop.get(name)) for name in ("started", "ended")} for stop in found if stop.get("busStop") == key}


def test_sumo_holds_the_next_train(example, tmp_path):
    skip_without("libsumo")
    platform, limit = example("sumo_platform"), 60.0
    for name in ("free", "held", "again"):
        (tmp_path / name).mkdir()
    path = os.pathsep.join([str(COUPLING), os.environ["PYTHONPATH"]])
    environment = {**os.environ, "PYTHONPATH": path, "MPLBACKEND": "agg", "SUMO_HOME": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", DAY, str(limit)], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    logs = dict(zip(("free", "held"), pickle.loads((tmp_path / "logs").read_bytes())))
    free, held = logs.values()
    assert free.held == {} and list(held.held) == ["local1"] and max(free.squeeze) > limit
    # SUMO's own files say the same as the script: how long the train stood at West longer than without the rule.
    stood = {name: stops(tmp_path / name, "west")["local1"] for name in logs}
    extra = (stood["held"]["ended"] - stood["held"]["started"]) - (stood["free"]["ended"] - stood["free"]["started"])
    assert extra == pytest.approx(held.held["local1"], abs=platform.SECOND) and extra > 10.0
    assert held.delays["local1"] - free.delays["local1"] == pytest.approx(extra, abs=1e-6)
    trips = {name: {trip.get("id"): trip for trip in ET.parse(tmp_path / name / "trips.xml").getroot()} for name in logs}
    stop_time = [float(trips[name]["local1"].get("stopTime")) for name in ("held", "free")]
    at_central = [stops(tmp_path / name, "central")["local1"] for name in ("held", "free")]
    dwell = [each["ended"] - each["started"] for each in at_central]
    assert stop_time[0] - stop_time[1] == pytest.approx(extra + dwell[0] - dwell[1], abs=1e-6)
    # Every passenger of SUMO was a body, for as long as SUMO says, and went on with the express.
    names = {f"local{k}.{i}" for k in range(2) for i in range(40)}
    for name, log in logs.items():
        assert log.waited.keys() == names
        for person in names:
            rides, stays = (trips[name][person].findall(kind) for kind in ("ride", "stop"))
            assert len(rides) == 2 and rides[1].get("vehicle").startswith("express")
            assert float(stays[0].get("duration")) == pytest.approx(log.waited[person], abs=platform.SECOND)
        assert log.people[-1] == 0
    # The rule halves what was on the platform; after it has acted, who waits is squeezed no more than by one train.
    assert max(free.people) == 80 and max(held.people) == 40
    first = stops(tmp_path / "free", "central")["local1"]["started"]
    one = max(squeeze for time, squeeze in zip(free.times, free.squeeze) if time <= first)
    assert held.greatest(boarding=False) <= 1.5 * one and free.greatest(boarding=False) > held.greatest(boarding=False)
    assert (tmp_path / "platform.png").read_bytes().startswith(b"\x89PNG")
    # The same seed is the same day.
    assert (tmp_path / "again/trips.xml").read_text().split("<tripinfos")[1] == (tmp_path / "held/trips.xml").read_text().split("<tripinfos")[1]
