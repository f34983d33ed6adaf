"""Where the FMU was extracted, and what is wrong there."""

import shutil
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


def fails(directory, *words, **options):
    """Instantiation fails, with a message that holds the words."""
    crowd = Crowd(directory, **options)
    try:
        with pytest.raises(Exception, match="Failed to instantiate"):
            crowd.instantiate()
        said = "\n".join(crowd.messages)
        assert all(word in said for word in words), said
    finally:
        crowd.free()


def test_wrong_guid(extracted):
    given = "{00000000-0000-0000-0000-000000000000}"
    fails(extracted, "GUID", given, guid=given)


def test_missing_resources(extracted):
    shutil.rmtree(extracted / "resources")
    fails(extracted, "resource", str(extracted))


@pytest.mark.parametrize(
    "file", ["Parameters.xml"] + [f"static/{name}.xml" for name in ["Agents", "Geometry", "Materials"]]
    + ["dynamic/AgentDynamics.xml"],
)  # fmt: skip
def test_missing_file(extracted, file):
    (extracted / "resources" / "Trial_push" / file).unlink()
    fails(extracted, file.split("/")[-1])


@pytest.mark.parametrize(
    "file, old, new, words",
    [
        ("static/Materials.xml", "</Materials>", "", []),
        ("static/Agents.xml", 'Mass="63.0"', 'Mass="many"', ["Mass", "many"]),
        ("static/Agents.xml", 'Mass="63.0"', 'Mass="-63.0"', ["Mass", "-63.0"]),
        ("static/Agents.xml", 'Radius="0.1125"', 'Radius="nan"', ["Radius", "nan"]),
        ("dynamic/AgentDynamics.xml", 'Agent Id="3"', 'Agent Id="x"', ["x"]),
        ("Parameters.xml", 'TimeStep="0.05"', "", ["TimeStep"]),
        ("static/Geometry.xml", 'MaterialId="concrete"', 'MaterialId="100 %s %n"', ["100 %s %n"]),
    ],
)
def test_broken_file(extracted, file, old, new, words):
    path = extracted / "resources" / "Trial_push" / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    fails(extracted, file.split("/")[-1], *words)


def test_a_new_number_in_the_resources_needs_no_new_description(extracted, instantiate, push):
    path = extracted / "resources" / "Trial_push" / "static" / "Agents.xml"
    path.write_text(path.read_text().replace('Mass="89.0"', 'Mass="80.0"'))
    crowd = instantiate(extracted).initialize()
    assert crowd["agent[0].Mass"] == 80.0
    crowd["agent[0].Fp.x"] = 100.0
    push.initialize()["agent[0].Fp.x"] = 100.0
    assert bits(crowd.run(1, 0.05)) != bits(push.run(1, 0.05))
