"""The Decision FMU of FMI 3.0: FMPy validates it, and connects it with the crowd's, arrays handed whole."""

import zipfile
from pathlib import Path

import fmpy
import numpy as np
from crowd import PEOPLE, TRIAL_DOOR, bits, room_job
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree
from masters import run

SHAPES = {"Position": 2, "Theta": 1, "Fp": 2, "Mp": 1, "NormalForce": 1}


def terminals(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))


def test_valid(decide, row):
    fmu = decide("--fmi", "3")
    assert validate_fmu(str(fmu)) == []
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(schema)).assertValid(terminals(fmu))
    row("fmpy", "FMI 3.0: validate Decision, with the XSDs of FMI 3.0", "no problem")


def test_one_line_connects_both(decide, pack):
    """By the rules of FMI 3.0 for terminals: the same name and kind, the rule `bus`, and members of equal names, of which
    one is an output and one an input, with the same shape and unit."""
    fmus = pack(TRIAL_DOOR, options=["--fmi", "3"]), decide("--fmi", "3")
    (crowd, decision) = (terminals(fmu).find("Terminals/Terminal") for fmu in fmus)
    for attribute, value in [("name", "crowd"), ("matchingRule", "bus"), ("terminalKind", "org.lemons-fmu.crowd")]:
        assert crowd.get(attribute) == decision.get(attribute) == value
    members = [{m.get("memberName"): m.get("variableName") for m in t.iter("TerminalMemberVariable")} for t in (crowd, decision)]
    variables = [{v.name: v for v in read_model_description(str(fmu)).modelVariables} for fmu in fmus]
    both = members[0].keys() & members[1].keys()
    assert both == members[1].keys() == {"Position", "Theta", "Velocity", "Fp", "Mp", "Active"}
    for name in both:
        of_crowd, of_decision = (all_of[of[name]] for all_of, of in zip(variables, members))
        assert {of_crowd.causality, of_decision.causality} == {"input", "output"}
        units = [of.declaredType and of.declaredType.unit for of in (of_crowd, of_decision)]
        assert units[0] == units[1]
        assert (of_crowd.type, of_crowd.shape) == (of_decision.type, of_decision.shape)


class Fmu:
    """An instance in Initialization Mode."""

    def __init__(self, path, directory):
        description = read_model_description(path)
        self.slave = FMU3Slave(
            guid=description.guid,
            unzipDirectory=extract(path, directory),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=directory.name,
        )
        self.slave.instantiate()
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.slave.enterInitializationMode(startTime=0.0)

    def get(self, name):
        return self.slave.getFloat64([self.references[name]], nValues=PEOPLE * SHAPES[name])

    def put(self, name, values):
        self.slave.setFloat64([self.references[name]], values)


def test_same_bits(decide, pack, tmp_path, row):
    """The algorithm of `masters.by_fmpy`, which does the same with the FMI 2.0 FMUs."""
    job = room_job({"decision": str(decide()), "crowd": str(pack(TRIAL_DOOR))}, 64)
    expected, _ = run("fmpy", job)
    assert max(step[4 * i + 3] for step in expected for i in range(PEOPLE)) > 100.0, "some are squeezed"

    options = ["--fmi", "3"]
    decision = Fmu(decide(*options), tmp_path / "decision")
    crowd = Fmu(pack(TRIAL_DOOR, options=options), tmp_path / "crowd")

    def pass_on():
        poses = {name: crowd.get(name) for name in ("Position", "Theta")}
        drives = {name: decision.get(name) for name in ("Fp", "Mp")}
        for fmu, arrays in [(decision, poses), (crowd, drives)]:
            for name, values in arrays.items():
                fmu.put(name, values)

    pass_on()
    for fmu in (decision, crowd):
        fmu.slave.exitInitializationMode()
    seen = []
    for k in range(job.steps):
        for fmu in (decision, crowd):
            fmu.slave.doStep(k * job.step, job.step)
        pass_on()
        columns = [np.reshape(crowd.get(name), (PEOPLE, -1)) for name in ("Position", "Theta", "NormalForce")]
        seen.append(np.hstack(columns).ravel().tolist())
    for fmu in (decision, crowd):
        fmu.slave.terminate()
        fmu.slave.freeInstance()
    assert bits(seen) == bits(expected)
    row("fmpy", "FMI 3.0: Decision and crowd, connected by whole arrays: 30 people and a door", "the bits of the FMI 2.0 FMUs")
