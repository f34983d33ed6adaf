"""Where the FMU was extracted, and what is wrong there."""

from ctypes import byref, c_char_p

import pytest
from crowd import Crowd, bits, callbacks
from fmpy import extract

DIRECTORIES = ["two words", "hundred%20percent", "50%", "Zürich ü", "a+b&c#d?e"]


@pytest.mark.parametrize("name", DIRECTORIES)
def test_directory_names(instantiate, push_fmu, tmp_path, name):
    (tmp_path / "hundred percent").mkdir()
    crowd = instantiate(extract(push_fmu, tmp_path / name)).initialize()
    crowd.step(0.05)
    assert crowd["agent[1].Mass"] == 63.0


@pytest.mark.parametrize(
    "uri",
    ["file://{}/resources/", "file:{}/resources", "file:///{}/resources", "file://localhost{}/resources"]
    + ["{}/resources", "file://{}", "file://{}/"],
)
@pytest.mark.parametrize("name", ["two words", "hundred%20percent", "Zürich"])
def test_uris_that_are_not_encoded(push_fmu, tmp_path, uri, name):
    crowd = Crowd(extract(push_fmu, tmp_path / name))
    try:
        location = uri.format(tmp_path / name).encode()
        guid = crowd.description.guid.encode()
        kind = 1  # fmi2CoSimulation
        name = crowd.fmu.instanceName.encode()
        component = crowd.fmu.fmi2Instantiate(name, kind, guid, c_char_p(location), byref(callbacks), 0, 0)
        assert component, crowd.messages
        crowd.fmu.component = component
        crowd.initialize()
    finally:
        crowd.free()


@pytest.fixture
def extracted(push_fmu, tmp_path):
    """The default FMU, to be damaged."""
    return extract(push_fmu, tmp_path / "extracted")


def test_a_new_number_in_the_resources_needs_no_new_description(extracted, instantiate, push):
    path = extracted / "resources" / "Trial_push" / "static" / "Agents.xml"
    path.write_text(path.read_text().replace('Mass="89.0"', 'Mass="80.0"'))
    crowd = instantiate(extracted).initialize()
    assert crowd["agent[0].Mass"] == 80.0
    crowd["agent[0].Fp.x"] = 100.0
    push.initialize()["agent[0].Fp.x"] = 100.0
    assert bits(crowd.run(1, 0.05)) != bits(push.run(1, 0.05))
