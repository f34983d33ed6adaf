"""FMI 3.0: FMPy validates and drives a crowd of arrays; the bits are those of the FMI 2.0 FMU."""

import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from crowd import TRIAL_DOOR, TRIAL_PUSH
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

STEP = 0.05  # s
AGENTS = 5


@pytest.fixture
def push_fmu_3(pack):
    return pack(TRIAL_PUSH, TRIAL_DOOR, options=["--fmi", "3"])


def instance_of(fmu, directory, **options):
    """A slave, its description, and what it said."""
    description = read_model_description(fmu)
    said = []
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=extract(fmu, directory),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="crowd",
    )
    slave.instantiate(logMessage=lambda *words: said.append(words), **options)
    return slave, {variable.name: variable.valueReference for variable in description.modelVariables}, said


def test_valid(push_fmu_3, row):
    """FMPy checks the official XSD and much more; the terminals have an XSD of their own."""
    assert validate_fmu(push_fmu_3) == []
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    with zipfile.ZipFile(push_fmu_3) as archive:
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        names = archive.namelist()
    etree.XMLSchema(etree.parse(schema)).assertValid(terminals)
    members = [member.get("variableName") for member in terminals.iter("TerminalMemberVariable")]
    assert members == ["Fp", "Mp", "Active", "Position", "Theta", "Velocity", "Omega"]
    assert "terminalsAndIcons/icon.png" in names and "binaries/x86_64-linux/CrowdMechanics.so" in names
    row("fmpy", "FMI 3.0: validate, with the XSDs of FMI 3.0", "no problem")


@pytest.mark.parametrize("fmi", [2, 3])
def test_ssp(pack, lemons, tmp_path, fmi):
    """What `lemons connect` writes is valid: SSP 2.0 where arrays are connected, 1.0 otherwise."""
    crowd = pack(TRIAL_PUSH, options=["--fmi", str(fmi)])
    ssp = tmp_path / "coupled.ssp"
    controller = tmp_path / "controller.fmu"
    with zipfile.ZipFile(controller, "w") as archive:
        archive.write(Path(__file__).parents[1] / "coupling" / "modelDescription.xml", "modelDescription.xml")
    subprocess.run([lemons, "connect", controller, crowd, "-o", ssp], check=True, capture_output=True)
    with zipfile.ZipFile(ssp) as archive:
        structure = etree.fromstring(archive.read("SystemStructure.ssd"))
    assert structure.get("version") == ("1.0" if fmi == 2 else "2.0")
    pyssp_standard = pytest.importorskip("pyssp_standard")
    resources = Path(pyssp_standard.__file__).parent / "resources"
    schema = resources / ("" if fmi == 2 else "ssp2") / "SystemStructureDescription.xsd"
    etree.XMLSchema(etree.parse(schema)).assertValid(structure)


def test_same_bits(push_fmu, push_fmu_3, row):
    """Array inputs and outputs in `simulate_fmu`, beside scalars. FMPy 0.3.32 takes arrays of one shape only as inputs."""
    drive = np.zeros(2, dtype=[("time", "f8"), ("Fp", "f8", (AGENTS, 2))])
    drive["time"] = 0.0, 10.0
    drive["Fp"][:, 0] = 500.0, 20.0
    options = {"stop_time": 2.0, "step_size": STEP, "output_interval": STEP}
    ours = simulate_fmu(
        push_fmu_3, input=drive, output=["Position", "Theta", "Omega", "PeakNormalForce", "AgentContacts"], **options
    )
    names = [f"agent[{i}].{name}" for i in range(AGENTS) for name in ("Fp.x", "Fp.y")]
    scalars = np.zeros(2, dtype=[("time", "f8"), *[(name, "f8") for name in names]])
    scalars["time"] = 0.0, 10.0
    scalars["agent[0].Fp.x"], scalars["agent[0].Fp.y"] = 500.0, 20.0
    outputs = ["Position.x", "Position.y", "Theta", "Omega", "PeakNormalForce", "AgentContacts"]
    theirs = simulate_fmu(
        push_fmu, input=scalars, output=[f"agent[{i}].{name}" for i in range(AGENTS) for name in outputs], **options
    )
    assert len(ours) == len(theirs) == 41
    for i in range(AGENTS):
        for name in outputs:
            of_agent = ours[name.split(".")[0]][:, i]
            of_agent = of_agent[:, "xy".index(name[-1])] if "." in name else of_agent
            assert (of_agent == theirs[f"agent[{i}].{name}"]).all(), f"agent[{i}].{name}"
    assert ours["PeakNormalForce"].max() > 1000.0
    row("fmpy", "FMI 3.0: the push with array inputs, 40 steps", "the bits of the FMI 2.0 FMU")


def test_another_size(push_fmu_3, tmp_path, row):
    """Thirty people of another Trial, in Configuration Mode."""
    slave, references, said = instance_of(push_fmu_3, tmp_path / "extracted", loggingOn=True)
    slave.enterConfigurationMode()
    # The room is a wall of eleven straight pieces.
    slave.setUInt64([references["Agents"], references["WallSegments"]], [30, 11])
    slave.exitConfigurationMode()
    slave.setString([references["Trial"]], [TRIAL_DOOR.name])
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    ids = slave.getString([references["AgentId"]], nValues=30)
    assert len(set(ids)) == 30
    slave.doStep(0.0, STEP)
    before = slave.getFloat64([references["Position"]], nValues=60)
    state = slave.getFMUState()
    for k in range(1, 4):
        slave.doStep(k * STEP, STEP)
    after = slave.getFloat64([references["Position"]], nValues=60)
    slave.setFMUState(state)
    slave.freeFMUState(state)
    assert slave.getFloat64([references["Position"]], nValues=60) == before
    for k in range(1, 4):
        slave.doStep(k * STEP, STEP)
    assert slave.getFloat64([references["Position"]], nValues=60) == after
    slave.terminate()
    slave.freeInstance()
    assert not [words for words in said if b"error" in b" ".join(w for w in words if isinstance(w, bytes)).lower()]
    row("fmpy", "FMI 3.0: another Trial of another size by Configuration Mode; a state saved and restored", "done")


def test_thousand(pack, shared, tmp_path, row):
    """What grows with a crowd is start values only: names and types are the same for any."""
    fmu = pack(shared / "data/crowds/dense_1000", options=["--fmi", "3"])
    with zipfile.ZipFile(fmu) as archive:
        description = archive.read("modelDescription.xml")
    assert len(description) <= 200 * 1000
    slave, references, _ = instance_of(fmu, tmp_path / "extracted")
    assert len(references) == 46
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    slave.setFloat64([references["Fp"]], [10.0, 0.0] * 1000)
    slave.doStep(0.0, 0.001)
    contacts = slave.getInt32([references["AgentContacts"]], nValues=1000)
    total = slave.getInt32([references["TotalAgentContacts"]])
    assert sum(contacts) == 2 * total[0] > 1000
    slave.terminate()
    slave.freeInstance()
    row("fmpy", "FMI 3.0: 1000 people: read, extract, instantiate, step", "done")
