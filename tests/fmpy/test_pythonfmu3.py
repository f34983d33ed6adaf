"""The controller examples/controllers/cautious3.py, made an FMU of FMI 3.0 by pythonfmu3, drives the crowd's by whole arrays."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import numpy as np
import pytest
from arrays import Fmu
from crowd import REPOSITORY, TRIAL_PUSH
from fmpy import read_model_description
from fmpy.validation import validate_fmu

# pythonfmu3 0.3.4 calls numpy.reshape so.
pytestmark = pytest.mark.filterwarnings("ignore:`newshape`:DeprecationWarning")
AGENTS = TRIAL_PUSH / "static" / "Agents.xml"
STEP, STEPS = 0.05, 120  # s


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    directory = tmp_path_factory.mktemp("controller")
    script = REPOSITORY / "examples" / "controllers" / "cautious3.py"
    command = [Path(sys.executable).with_name("pythonfmu3"), "build", "-f", script, AGENTS]
    subprocess.run(command, check=True, cwd=directory, capture_output=True)
    return directory / "Cautious3.fmu"


def pairs(values):
    return np.reshape(values, (-1, 2))


def test_built(controller, row):
    assert validate_fmu(str(controller)) == []
    row("pythonfmu3", "`pythonfmu3 build` of `cautious3.py`", "an FMU of FMI 3.0 with arrays in which FMPy finds no problem")


def test_arrays_are_connected_whole(controller, pack, lemons, tmp_path, row):
    """Their size is `People` here and `Agents` there."""
    crowd = pack(TRIAL_PUSH, options=["--fmi", "3"])
    sizes = [{v.name for v in read_model_description(fmu).modelVariables if v.causality == "structuralParameter"} for fmu in (controller, crowd)]
    assert sizes[0] == {"People"} and "People" not in sizes[1]
    subprocess.run([lemons, "connect", controller, crowd, "-o", tmp_path / "coupled.ssp"], check=True, capture_output=True)
    with zipfile.ZipFile(tmp_path / "coupled.ssp") as archive:
        structure = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    assert structure.get("version") == "2.0"
    connections = [c.attrib for c in structure.iter() if c.tag.endswith("}Connection")]
    name = crowd.stem
    wanted = [("Cautious3", name, "Fp"), (name, "Cautious3", "Position"), (name, "Cautious3", "MeanNormalForce")]
    wanted = [dict(startElement=a, startConnector=of, endElement=b, endConnector=of) for a, b, of in wanted]
    assert sorted(map(sorted, map(dict.items, connections))) == sorted(map(sorted, map(dict.items, wanted)))
    row("pythonfmu3", "`lemons connect` of `cautious3.py` and the crowd of FMI 3.0", "SSP 2.0: three arrays, each connected whole")


def test_who_is_squeezed_walks_more_slowly(controller, pack, tmp_path, row):
    """A plain loop (Jacobi). Each force follows from what was told before the step, agent by agent."""
    fmus = {"controller": controller, "crowd": pack(TRIAL_PUSH, options=["--fmi", "3"])}
    fmus = {name: Fmu(path, tmp_path / name) for name, path in fmus.items()}
    crowd, cautious = fmus["crowd"], fmus["controller"]
    bodies = [float(a.get("Mass")) * float(a.get("FloorDamping")) for a in ElementTree.parse(AGENTS).getroot()]
    for fmu in fmus.values():
        fmu.slave.exitInitializationMode()
    squeezed = 0
    for k in range(STEPS):
        told = {name: crowd.get(name) for name in ("Position", "MeanNormalForce")}
        crowd.put("Fp", cautious.get("Fp"))
        for name, values in told.items():
            cautious.put(name, values)
        for fmu in fmus.values():
            fmu.slave.doStep(k * STEP, STEP)
        for body, (x, y), squeeze, force in zip(
            bodies, pairs(told["Position"]), told["MeanNormalForce"], pairs(cautious.get("Fp"))
        ):
            distance = np.hypot(1.4 - x, y)
            wanted = body * min(1.2, distance) / (1.0 + squeeze / 200.0)
            assert force == pytest.approx([wanted * (1.4 - x) / distance, -wanted * y / distance], rel=1e-12, abs=1e-12)
            squeezed += squeeze > 200.0
        assert (set(crowd.get("Fp")) == {0.0}) == (k == 0), "what the controller said before"
    assert squeezed > 50
    for fmu in fmus.values():
        fmu.free()
    row("pythonfmu3", "`cautious3.py` and the crowd, arrays handed whole, under FMPy", "who is squeezed pushes less")
