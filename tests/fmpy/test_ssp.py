"""`lemons connect` and `lemons run FILE.ssp` against the SSP readers and masters of others."""

import os
import shutil
import subprocess
import zipfile
from xml.etree import ElementTree

import pytest
from crowd import REPOSITORY, TRIAL_PUSH, bits, ids_of, read_table
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

SOURCES = REPOSITORY / "tests" / "coupling"
INPUTS = ["Position.x", "Position.y", "Theta"]
FORCES = ["Fp.x", "Fp.y", "Mp"]
# A power of two: sums of it are exact, as FMPy makes them.
STEP = 0.03125


@pytest.fixture(scope="module")
def coupled(lemons, push_fmu, tmp_path_factory):
    """The default crowd and a small controller, connected."""
    directory = tmp_path_factory.mktemp("coupled")
    compiler = shutil.which(os.environ.get("CC") or "cc")
    assert compiler, "a C compiler is needed"
    library = directory / "controller.so"
    options = ["-shared", "-fPIC", "-O1", "-ffp-contract=off"]
    subprocess.run([compiler, *options, "-o", library, SOURCES / "controller.c"], check=True)
    fmu = directory / "controller.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.write(SOURCES / "modelDescription.xml", "modelDescription.xml")
        archive.write(library, "binaries/linux64/controller.so")
    ssp = directory / "coupled.ssp"
    subprocess.run([lemons, "connect", fmu, push_fmu, "-o", ssp], check=True, capture_output=True)
    return ssp


def test_structure_is_valid_for_pyssp_standard(coupled, row):
    ssp_module = pytest.importorskip("pyssp_standard.ssp")
    with ssp_module.SSP(coupled, mode="r") as ssp:
        assert sorted(ssp.resources) == ["controller.fmu", "crowd.fmu"]
        with ssp.system_structure as structure:
            structure.__check_compliance__()
            assert structure.check_connections(unconnected_inputs=True, connector_not_in_system=True) == []
            pairs = {
                (c.start_element, c.start_connector, c.end_element, c.end_connector) for c in structure.connections()
            }
            connectors = {(component.name, c.name): c for component in structure.system.elements for c in component.connectors}
            experiment = structure.default_experiment
            assert (experiment.start_time, experiment.stop_time) == (0.0, 5.0)
    names = [f"agent[{i}].{name}" for i in range(5) for name in FORCES]
    poses = [f"agent[{i}].{name}" for i in range(5) for name in INPUTS]
    assert pairs == {("controller", name, "crowd", name) for name in names} | {
        ("crowd", name, "controller", name) for name in poses
    }
    assert connectors["crowd", "agent[3].Mp"].kind == "input"
    assert connectors["crowd", "agent[3].Mp"].type_.unit == "N.m"
    assert connectors["crowd", "agent[3].AgentContacts"].kind == "output"
    row("pyssp_standard", "the SSP of `lemons connect`: schema, connections", "compliant, all inputs connected")


def test_structure_is_valid_for_fmpy(coupled, row):
    structure = read_ssd(str(coupled), validate=True)
    assert [(c.name, c.source) for c in structure.system.elements] == [
        ("controller", "resources/controller.fmu"),
        ("crowd", "resources/crowd.fmu"),
    ]
    assert len(structure.system.connections) == 30
    newton = {unit.name: unit for unit in structure.units}["N"]
    assert (newton.kg, newton.m, newton.s, newton.rad) == (1, 1, -2, 0)
    row("fmpy", "`read_ssd` of the SSP of `lemons connect`, with validation", "no problem")


def test_fmpy_simulates_the_same(coupled, lemons, tmp_path, row):
    """FMPy's `simulate_ssp` is a Jacobi master that starts with zero at every connector.

    A controller that waits for two steps gives it the initial forces that it assumes: from then on all bits are equal.
    """
    steps = 32
    parameters = {"controller.Delay": 2.5 * STEP, "controller.Stiffness": 900.0}

    class Parameters:
        parameters = []

    for name, value in parameters.items():
        parameter = type("Parameter", (), {"name": name, "value": value})
        Parameters.parameters.append(parameter)
    result = simulate_ssp(str(coupled), stop_time=steps * STEP, step_size=STEP, parameter_set=Parameters)
    settings = [option for name, value in parameters.items() for option in ("--set", f"{name}={value!r}")]
    command = [lemons, "run", coupled, "--until", repr(steps * STEP), *settings]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)
    seen = read_table((tmp_path / "trajectories.csv").read_text(), ids_of(TRIAL_PUSH))
    columns = ["Position.x", "Position.y", "Velocity.x", "Velocity.y", "Theta", "Omega"]
    columns += ["AgentContacts", "WallContacts", "ContactingAgents", "NormalForce"]
    # A row of FMPy has the time before a step and the outputs after it.
    theirs = [
        (
            float(row["time"]) + STEP,
            [[row[f"crowd.agent[{i}].{name}"].item() for name in columns] for i in range(5)],
        )
        for row in result
    ]
    assert len(theirs) == steps
    assert bits(theirs) == bits(seen[1:])
    assert max(agent[-1] for _, agents in theirs for agent in agents) > 100.0, "nobody was squeezed"
    gauss_seidel = [*command, "--algorithm", "gauss-seidel"]
    subprocess.run(gauss_seidel, check=True, capture_output=True, cwd=tmp_path)
    other = read_table((tmp_path / "trajectories.csv").read_text(), ids_of(TRIAL_PUSH))
    assert bits(other) != bits(seen)
    row("fmpy", "`simulate_ssp`: a controller FMU in C and the crowd", "same bits as `lemons run`, Jacobi")


TERMINALS = """<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>
  <Terminal name="people" matchingRule="bus" terminalKind="org.lemons-fmu.crowd">
    <TerminalMemberVariable variableName="push" memberName="Fp"/>
    <TerminalMemberVariable variableName="seen" memberName="Position"/>
  </Terminal>
</Terminals></fmiTerminalsAndIcons>"""
OF_OTHER_NAMES = """<fmiModelDescription fmiVersion="3.0" modelName="other" instantiationToken="other">
  <CoSimulation modelIdentifier="other"/>
  <UnitDefinitions><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent"/>
    <Float64 name="push" valueReference="1" causality="output" unit="N"><Dimension start="5"/><Dimension start="2"/></Float64>
    <Float64 name="seen" valueReference="2" causality="input" unit="m" start="0"><Dimension start="5"/><Dimension start="2"/></Float64>
  </ModelVariables>
</fmiModelDescription>"""


@pytest.mark.parametrize("terminals, said", [(TERMINALS, None), (TERMINALS.replace('matchingRule="bus"', ""), "matchingRule")])
def test_terminals_say_what_is_connected(pack, lemons, tmp_path, terminals, said):
    """Variables of other names, by members of the crowd's terminal; a broken file is named."""
    crowd, other, ssp = pack(TRIAL_PUSH, options=["--fmi", "3"]), tmp_path / "other.fmu", tmp_path / "both.ssp"
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("modelDescription.xml", OF_OTHER_NAMES)
        archive.writestr("terminalsAndIcons/terminalsAndIcons.xml", terminals)
    done = subprocess.run([lemons, "connect", other, crowd, "-o", ssp], capture_output=True, text=True)
    if said:
        assert done.returncode != 0 and not ssp.exists()
        assert f"{other}: terminalsAndIcons/terminalsAndIcons.xml:2: <Terminal>: " in done.stderr and said in done.stderr
        return
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(ssp) as archive:
        structure = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    assert structure.get("version") == "2.0"
    ends = ("startElement", "startConnector", "endElement", "endConnector")
    connections = [[of.get(end) for end in ends] for of in structure.iter() if of.tag.endswith("}Connection")]
    assert sorted(connections) == [["Trial_push", "Position", "other", "seen"], ["other", "push", "Trial_push", "Fp"]]
