"""FMPy loads an FMU of a thousand people; `pytest -s` prints how much processor time that takes.

0.4 s were measured on an idle machine, 0.6 to 1.2 s on busy ones. A test cannot hold a time, so it holds what the time goes
with: the bytes and the elements of modelDescription.xml.
"""

from pathlib import Path
from time import process_time

import pytest
from fmpy import extract, instantiate_fmu, read_model_description
from fmpy.fmi2 import fmi2Warning


@pytest.fixture
def timed():
    def timed(what, function, *arguments, **options):
        start = process_time()
        result = function(*arguments, **options)
        print(f"{process_time() - start:6.2f} s  {what}")
        return result

    return timed


@pytest.mark.parametrize("naming", ["structured", "flat"])
def test_load(pack, shared, tmp_path, timed, row, naming):
    fmu = pack(shared / "data/crowds/dense_1000", options=["--flat-names"] if naming == "flat" else [])
    said = []
    description = timed(f"read_model_description, {naming} names", read_model_description, fmu, validate=False)
    directory = timed("extract", extract, fmu, tmp_path / "extracted")
    options = {"debug_logging": True, "logger": lambda *words: said.append(words)}
    crowd = timed("instantiate_fmu", instantiate_fmu, directory, description, **options)
    xml = (Path(directory) / "modelDescription.xml").read_bytes()
    print(f"{len(xml)} bytes, {xml.count(b'</')} + {xml.count(b'/>')} elements")
    assert len(xml) <= 310 * len(description.modelVariables)
    # Each variable has an element of its type within; an output is named twice in the structure.
    assert xml.count(b"</") + xml.count(b"/>") <= 4 * len(description.modelVariables)
    assert description.variableNamingConvention == naming
    names = [variable.name for variable in description.modelVariables]
    assert sum(name.endswith("].Mp") for name in names) == 1000
    assert len(names) > 16000
    crowd.setupExperiment(startTime=0.0)
    crowd.enterInitializationMode()
    crowd.exitInitializationMode()
    timed("doStep of 1 ms", crowd.doStep, 0.0, 0.001)
    total = next(variable for variable in description.modelVariables if variable.name == "AgentContacts")
    assert crowd.getInteger([total.valueReference])[0] > 500
    crowd.terminate()
    crowd.freeInstance()
    # Nothing but advice: people of this crowd overlap when it starts, and walls too.
    assert [status for _, _, status, _, _ in said] == [fmi2Warning] * 2
    assert all(b"overlap at the start" in message for *_, message in said), said
    row("fmpy", f"1000 people, {naming} names: read, extract, instantiate", "done")


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_load_summary(pack, shared, tmp_path, timed, row, fmi):
    """Its description does not grow with the people."""
    options = ["--interface", "summary", "--area", "all=-50,-50,50,50", "--fmi", fmi]
    fmu = pack(shared / "data/crowds/dense_1000", options=options)
    description = timed(f"read_model_description, FMI {fmi}.0, summary", read_model_description, fmu)
    directory = timed("extract", extract, fmu, tmp_path / "extracted")
    crowd = timed("instantiate_fmu", instantiate_fmu, directory, description)
    assert (Path(directory) / "modelDescription.xml").stat().st_size < 30_000
    crowd.freeInstance()
    row("fmpy", f"FMI {fmi}.0: the summary FMU of 1000 people: read, extract, instantiate", "done")


def test_validate(pack, shared, timed, row):
    """With flat names: of structured ones FMPy parses every name, which takes most of a minute."""
    fmu = pack(shared / "data/crowds/dense_1000", options=["--flat-names"])
    checks = {"validate_variable_names": True, "validate_model_structure": True}
    timed("the same, validated, flat names", read_model_description, fmu, validate=True, **checks)
    row("fmpy", "1000 people, flat names: read with all validation", "no problem")
