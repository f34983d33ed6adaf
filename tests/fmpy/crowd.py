"""An FMU instance by variable names, with all that its logger was told."""

import csv
import sys
import xml.etree.ElementTree as ElementTree
from contextlib import contextmanager
from ctypes import byref
from itertools import count
from pathlib import Path

import pytest
from fmpy import calloc, free, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Error,
)
from fmpy.logging import addLoggerProxy
from masters import Job

# What tests/lab uses, too.
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "common"))
from built import REPOSITORY  # noqa: E402

TRIAL_PUSH = REPOSITORY / "resources" / "Trial_push"
TRIAL_DOOR = REPOSITORY / "resources" / "Trial_door"

INPUTS = ["Fp.x", "Fp.y", "Mp"]
POSES = ["Position.x", "Position.y", "Theta"]
PEOPLE = 30  # of Trial_door
# The columns of the table of `lemons run`. Written by `COLUMNS_TABLE=write cargo test -p lemons-results --all-features --test record columns`.
with (REPOSITORY / "tests/columns.csv").open(newline="") as _file:
    TABLE = list(csv.DictReader(_file))
COLUMNS = {row["name"]: row["unit"] or None for row in TABLE}
# All but time and Id are outputs; those of an agent come after this.
AGENT = "agent[i]."
OUTPUTS = [row["variable"].removeprefix(AGENT) for row in TABLE[2:12]]
MOTION, CONTACTS = OUTPUTS[:6], OUTPUTS[6:9]
# FMUs of earlier versions have no mean and peak of a step.
OF_STEP = [row["name"] for row in TABLE[12:15]]

numbers = count()
messages = {}  # instance name -> what its logger was told


def log(_environment, instance, _status, _category, message):
    messages[instance.decode()].append(message.decode())


callbacks = fmi2CallbackFunctions()
logger = fmi2CallbackLoggerTYPE(log)
callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)


def listen():
    """FMPy's proxy knows one logger of the process: the last one that was given to it, which may be gone."""
    callbacks.logger = logger
    addLoggerProxy(byref(callbacks))


class Crowd:
    """An instance of an extracted FMU; `free` it at the end (the fixture `instantiate` does)."""

    def __init__(self, directory, guid=None):
        self.directory = Path(directory)
        self.description = read_model_description(str(directory), validate=False)
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.agents = sum(name.endswith("].Mp") for name in self.variables)
        name = f"crowd {next(numbers)}"
        self.messages = messages[name] = []
        self.fmu = FMU2Slave(
            guid=guid or self.description.guid,
            unzipDirectory=str(directory),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.time = 0.0

    def instantiate(self):
        listen()
        self.fmu.instantiate(callbacks=callbacks, loggingOn=True)
        return self

    def free(self):
        if self.fmu.component is None:
            self.fmu.freeLibrary()
        else:
            self.fmu.freeInstance()

    def __getitem__(self, name):
        variable = self.variables[name]
        value = getattr(self.fmu, "get" + variable.type)([variable.valueReference])[0]
        return value.decode() if variable.type == "String" else value

    def __setitem__(self, name, value):
        variable = self.variables[name]
        getattr(self.fmu, "set" + variable.type)([variable.valueReference], [value])

    def references(self, names):
        return [self.variables[f"agent[{i}].{name}"].valueReference for i in range(self.agents) for name in names]

    def initialize(self, start=0.0):
        self.fmu.setupExperiment(startTime=start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = start
        return self

    def step(self, step):
        self.step_to(self.time + step)

    def step_to(self, end):
        self.fmu.doStep(self.time, end - self.time)
        self.time = end

    def look(self):
        """Of each agent: motion, contacts, squeeze."""
        motion = self.fmu.getReal(self.references(MOTION))
        contacts = self.fmu.getInteger(self.references(CONTACTS))
        squeeze = self.fmu.getReal(self.references(["NormalForce"]))
        return [motion[6 * i : 6 * i + 6] + contacts[3 * i : 3 * i + 3] + [squeeze[i]] for i in range(self.agents)]

    def run(self, steps, step, drive=None, first=0):
        """What is seen at the communication points after the step `first`: multiples of `step`."""
        seen = []
        for k in range(first, steps):
            for i, push in (drive.at(self.time) if drive else {}).items():
                references = [self.variables[f"agent[{i}].{name}"].valueReference for name in INPUTS]
                self.fmu.setReal(references, push)
                assert self.fmu.getReal(references) == push
            self.step_to((k + 1) * step)
            seen.append((self.time, self.look()))
        return seen


@contextmanager
def refused(crowd, *words, status=fmi2Error):
    """The call inside fails with this status (a value out of its range is discarded), and a message that holds the words."""
    before = len(crowd.messages)
    with pytest.raises(FMICallException) as refusal:
        yield
    assert refusal.value.status == status
    said = "\n".join(crowd.messages[before:])
    assert all(word in said for word in words), said


class Drive:
    """A drive file, sampled as `lemons run` does: linear between its rows, zero outside."""

    def __init__(self, path, ids):
        lines = (line for line in Path(path).read_text().splitlines() if not line.startswith("#"))
        self.rows = {}
        for row in csv.DictReader(lines):
            push = [float(row[name]) for name in INPUTS]
            self.rows.setdefault(ids.index(row["agent"]), []).append((float(row["t"]), push))

    def at(self, time):
        return {i: self.sample(rows, time) for i, rows in self.rows.items()}

    @staticmethod
    def sample(rows, time):
        for (t0, a), (t1, b) in zip(rows, rows[1:]):
            if t0 <= time < t1:
                share = (time - t0) / (t1 - t0)
                return [x + share * (y - x) for x, y in zip(a, b)]
        return rows[-1][1] if time == rows[-1][0] else [0.0, 0.0, 0.0]


def push_drive():
    return Drive(TRIAL_PUSH / "drive.csv", ids_of(TRIAL_PUSH))


def push_job(fmu, steps, **options):
    """The push through the default FMU, as a job for any of the masters; all outputs of all agents are watched."""
    job = Job(fmus={"crowd": str(fmu)}, steps=steps, watch=[["crowd", name] for name in outputs(5)], **options)
    drive = push_drive()
    job.inputs = [
        [
            [["crowd", f"agent[{i}].{name}"], value]
            for i, push in drive.at(k * job.step).items()
            for name, value in zip(INPUTS, push)
        ]
        for k in range(steps)
    ]
    return job


def two_pushes_job(fmu, steps):
    """Two instances of the default FMU; in the second one agent 1 is lighter."""
    job = push_job(fmu, steps)
    job.fmus["second"] = str(fmu)
    job.inputs = [pairs + [[["second", name], value] for (_, name), value in pairs] for pairs in job.inputs]
    job.watch = job.watch + [["second", name] for _, name in job.watch]
    job.parameters = [[["second", "agent[1].Mass"], 40.0]]
    return job


def room_job(fmus, steps):
    """Decision and crowd of Trial_door, connected; x, y, theta and squeeze of each are seen."""
    connections = [
        [[source, f"agent[{i}].{name}"], [sink, f"agent[{i}].{name}"]]
        for source, sink, names in [("crowd", "decision", POSES), ("decision", "crowd", INPUTS)]
        for i in range(PEOPLE)
        for name in names
    ]
    watch = [["crowd", f"agent[{i}].{name}"] for i in range(PEOPLE) for name in [*POSES, "NormalForce"]]
    return Job(fmus=fmus, steps=steps, watch=watch, connections=connections)


def outputs(agents):
    return [f"agent[{i}].{name}" for i in range(agents) for name in OUTPUTS]


def ids_of(trial):
    agents = ElementTree.parse(Path(trial) / "static" / "Agents.xml").getroot()
    return [agent.get("Id") for agent in agents]


def bits(seen):
    """Numbers to the last bit, readable when they differ."""
    if isinstance(seen, (list, tuple)):
        return [bits(part) for part in seen]
    return seen.hex() if isinstance(seen, float) else seen


def read_table(text, ids):
    """trajectories.csv as `Crowd.run` returns it, with the start. Tables of earlier versions have units in their header."""
    rows = list(csv.reader(text.splitlines()))
    header = [name.split(" [")[0] for name in rows.pop(0)]
    walking = [*list(COLUMNS)[:-2], "active", *list(COLUMNS)[-2:]]
    assert header in (list(COLUMNS), walking, [name for name in COLUMNS if name not in OF_STEP])
    places = {name: place for place, name in enumerate(header)}
    whole = {name for name, unit in COLUMNS.items() if unit is None}
    wanted = list(COLUMNS)[2:12]
    seen = []
    for k in range(0, len(rows), len(ids)):
        block = rows[k : k + len(ids)]
        assert [row[places["id"]] for row in block] == ids
        assert len({row[places["t"]] for row in block}) == 1
        touching, walls = (sum(int(row[places[name]]) for row in block) for name in ("agent_contacts", "wall_contacts"))
        totals = places["total_agent_contacts"], places["total_wall_contacts"]
        assert all([int(row[place]) for place in totals] == [touching / 2, walls] for row in block), "totals"
        numbers = [[(int if name in whole else float)(row[places[name]]) for name in wanted] for row in block]
        seen.append((float(block[0][places["t"]]), numbers))
    return seen


def write_trial(directory, agents, walls=(), time_step=0.1, mechanical=1e-5, damping=0.0, friction=0.0):
    """A Trial of one-disk agents of radius 0.2 m: dictionaries with mass, x, y, vx, vy, fx, rate."""
    material = 'YoungModulus="4e6" ShearModulus="1.38e6"'
    contact = f'Id1="flesh" Id2="flesh" GammaNormal="{damping}" GammaTangential="{damping}"'
    files = {
        "Parameters.xml": '<Parameters><Directories Static="./static/" Dynamic="./dynamic/"/>'
        f'<Times TimeStep="{time_step}" TimeStepMechanical="{mechanical}"/></Parameters>',
        "static/Materials.xml": f'<Materials><Intrinsic><Material Id="flesh" {material}/></Intrinsic>'
        f'<Binary><Contact {contact} KineticFriction="{friction}"/></Binary></Materials>',
        "static/Geometry.xml": '<Geometry><Dimensions Lx="20" Ly="20"/>'
        + "".join(
            f'<Wall Id="{i}" MaterialId="flesh">'
            + "".join(f'<Corner Coordinates="{x},{y}"/>' for x, y in wall)
            + "</Wall>"
            for i, wall in enumerate(walls)
        )
        + "</Geometry>",
        "static/Agents.xml": "<Agents>"
        + "".join(
            f'<Agent Type="pedestrian" Id="{i}" Mass="{a["mass"]}" MomentOfInertia="1.5" '
            f'FloorDamping="{a.get("rate", 0.0)}" AngularDamping="{a.get("rate", 0.0)}">'
            '<Shape Type="disk" Radius="0.2" MaterialId="flesh" Position="0,0"/></Agent>'
            for i, a in enumerate(agents)
        )
        + "</Agents>",
        "dynamic/AgentDynamics.xml": "<Agents>"
        + "".join(
            f'<Agent Id="{i}"><Kinematics Position="{a["x"]},{a.get("y", 0.0)}" Velocity="{a.get("vx", 0.0)},{a.get("vy", 0.0)}" '
            f'Theta="0" Omega="0"/><Dynamics Fp="{a.get("fx", 0.0)},0" Mp="0"/></Agent>'
            for i, a in enumerate(agents)
        )
        + "</Agents>",
    }
    for name, text in files.items():
        path = Path(directory) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n', encoding="utf-8")
    return Path(directory)
