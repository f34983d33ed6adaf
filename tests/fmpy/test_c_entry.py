"""The C entry point, called by a script of the same calls as the paper's (section 4.5) and by a C program."""

import ctypes
import shutil
import subprocess
import sys
import textwrap
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from crowd import MOTION
from crowd import REPOSITORY as ROOT

# The calls of the paper's script, in its order, with the library's path put in; a fixed force instead of a random one.
SCRIPT = """
    import ctypes, sys
    from pathlib import Path
    from shutil import copyfile
    import xml.etree.ElementTree as ET

    dt, Ndt = 0.05, 20
    outputPath, inputPath = Path("outputXML/"), Path("inputXML/")
    outputPath.mkdir(parents=True, exist_ok=True)
    inputPath.mkdir(parents=True, exist_ok=True)
    Clibrary = ctypes.CDLL(sys.argv[1])
    agentDynamicsFilename = "AgentDynamics.xml"
    files = [b"Parameters.xml", b"Materials.xml", b"Geometry.xml", b"Agents.xml", agentDynamicsFilename.encode("ascii")]
    nFiles = len(files)
    filesInput = (ctypes.c_char_p * nFiles)()
    filesInput[:] = files
    for t in range(Ndt):
        copyfile("dynamic/" + agentDynamicsFilename, str(inputPath) + rf"/AgentDynamics input t={t * dt:.2f}.xml")
        Clibrary.CrowdMechanics(filesInput)
        copyfile("dynamic/" + agentDynamicsFilename, str(outputPath) + rf"/AgentDynamics output t={(t + 1) * dt:.2f}.xml")
        try:
            copyfile("dynamic/AgentInteractions.xml", str(outputPath) + rf"/AgentInteractions t={(t + 1) * dt:.2f}.xml")
        except FileNotFoundError:
            pass
        XMLtree = ET.parse("dynamic/" + agentDynamicsFilename)
        agentsTree = XMLtree.getroot()
        for agent in agentsTree:
            dynamicsItem = ET.SubElement(agent, "Dynamics")
            pushed = agent.attrib["Id"] == "0" and t < 12
            dynamicsItem.attrib["Fp"] = "800.00,0.00" if pushed else "0.00,0.00"
            dynamicsItem.attrib["Mp"] = "0.00"
        XMLtree.write("dynamic/" + agentDynamicsFilename)
    print(f"Loop terminated at t={Ndt * dt:.1f}s!")
"""


@pytest.fixture
def trial(tmp_path):
    path = tmp_path / "Trial_1"
    shutil.copytree(ROOT / "resources" / "Trial_push", path)
    return path


@pytest.fixture
def library(lemons):
    return Path(lemons).with_name("libcrowd_mechanics.so")


def motions(path):
    """x, y, vx, vy, theta, omega of each agent."""
    kinematics = [agent.find("Kinematics").attrib for agent in ET.parse(path).getroot()]
    text = [",".join(k[name] for name in ["Position", "Velocity", "Theta", "Omega"]) for k in kinematics]
    return [[float(number) for number in line.split(",")] for line in text]


def call(library, *names):
    files = (ctypes.c_char_p * 5)(*[None if name is None else str(name).encode() for name in names])
    return ctypes.CDLL(str(library)).CrowdMechanics(files)


FILES = ["Materials.xml", "Geometry.xml", "Agents.xml", "AgentDynamics.xml"]


def test_the_papers_script_equals_the_fmu(trial, library, pack, instantiate):
    fmu = pack(trial)
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(SCRIPT), library], cwd=trial, capture_output=True, text=True
    )
    assert done.returncode == 0 and done.stderr == "", done.stderr
    crowd = instantiate(fmu).initialize()
    touching = 0
    for t in range(20):
        crowd["agent[0].Fp.x"] = 800.0 if 1 <= t <= 12 else 0.0
        crowd.fmu.doStep(t * 0.05, 0.05)  # the very TimeStep of the files
        output = trial / "outputXML" / f"AgentDynamics output t={(t + 1) * 0.05:.2f}.xml"
        assert "Dynamics Fp" not in output.read_text()
        for i, written in enumerate(motions(output)):
            for name, value in zip(MOTION, written):
                assert value == crowd[f"agent[{i}].{name}"], (t, i, name)
        interactions = trial / "outputXML" / f"AgentInteractions t={(t + 1) * 0.05:.2f}.xml"
        contacts = crowd["AgentContacts"] + crowd["WallContacts"]
        touching += contacts > 0
        assert interactions.exists() == (contacts > 0)
        if contacts:
            pairs = ET.parse(interactions).getroot().findall("Agent/Agent/Interaction")
            assert len(pairs) == crowd["AgentContacts"]
    assert 0 < touching < 20, "contacts begin and end"
    assert not (trial / "dynamic" / "AgentInteractions.xml").exists()


def test_static_files_are_read_again_and_directories_may_change(trial, library, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(trial, other)
    dynamics = other / "dynamic" / "AgentDynamics.xml"
    dynamics.write_text(dynamics.read_text().replace('Velocity="0.00,0.00"', 'Velocity="0.01,0.0"', 1))
    start = dynamics.read_text()
    assert call(library, trial / "Parameters.xml", *FILES) == 0
    assert call(library, other / "Parameters.xml", *FILES) == 0
    slow = motions(dynamics)[0][2]
    agents = other / "static" / "Agents.xml"
    agents.write_text(agents.read_text().replace('FloorDamping="4.50"', 'FloorDamping="0"', 1))
    dynamics.write_text(start)
    assert call(library, other / "Parameters.xml", *FILES) == 0
    assert motions(dynamics)[0][2] == 0.01 > slow


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("static/Agents.xml", '"89.0"', '"-1"', ["Agents.xml:3", "<Agent>", "Mass", "-1", "positive"]),
        ("static/Geometry.xml", "</Geometry>", "", ["Geometry.xml"]),
        ("dynamic/AgentDynamics.xml", 'Id="4"', 'Id="five"', ["AgentDynamics.xml", "five"]),
        ("Parameters.xml", "./static/", "./nowhere/", ["nowhere"]),
        ("Parameters.xml", '"0.05"', '"1e300"', ["too many steps"]),
    ],
)
def test_on_failure_every_file_is_as_it_was(trial, library, capfd, file, old, new, words):
    path = trial / file
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    before = {p: p.read_bytes() for p in trial.rglob("*") if p.is_file()}
    assert call(library, trial / "Parameters.xml", *FILES) == 1
    said = capfd.readouterr().err
    assert said.startswith("CrowdMechanics: ") and all(word in said for word in words), said
    assert {p: p.read_bytes() for p in trial.rglob("*") if p.is_file()} == before


def test_null_is_refused(library, capfd):
    assert ctypes.CDLL(str(library)).CrowdMechanics(None) == 1
    assert "files is NULL" in capfd.readouterr().err
    assert call(library, "Parameters.xml", None, *FILES[1:]) == 1
    assert "Materials" in capfd.readouterr().err


def test_the_c_example(trial, library, tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    program = tmp_path / "advance"
    source = [ROOT / "examples" / "c" / "advance.c", "-I", ROOT / "include", "-Wall", "-Werror"]
    link = ["-L", library.parent, "-lcrowd_mechanics", f"-Wl,-rpath,{library.parent}", "-o", program]
    subprocess.run(["cc", *source, *link], check=True)
    done = subprocess.run([program, trial / "Parameters.xml", "3"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "3 steps done\n")
    assert subprocess.run([program, "none.xml", "3"], capture_output=True).returncode == 1
