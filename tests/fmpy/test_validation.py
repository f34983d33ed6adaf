"""fmpy's validation finds no problem in any FMU that the command packs. What it does not look at: terminals, icons, types
and annotations."""

import shutil
import zipfile
from pathlib import Path

import fmpy
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
BOTH = pytest.mark.parametrize("fmi", ["2", "3"])


@pytest.fixture
def fmus(pack, decide):
    """A crowd and a Decision of the same people."""
    return lambda fmi: (pack(TRIAL_DOOR, options=["--fmi", fmi]), decide("--fmi", fmi))


def xml(fmu, name):
    with zipfile.ZipFile(fmu) as archive:
        return etree.fromstring(archive.read(name))


def test_default(push_fmu, row):
    assert validate_fmu(str(push_fmu)) == []
    row("fmpy", "`validate_fmu`, structured names, 5 people", "no problem")


@pytest.mark.parametrize("trial", ["data/crowds/dense_100", "data/push_wed/Trial"])
def test_shared(pack, shared, trial):
    assert validate_fmu(str(pack(shared / trial))) == []


@pytest.mark.parametrize("options", [[], ["--flat-names"]])
def test_two_trials(pack, tmp_path, options, row):
    other = shutil.copytree(TRIAL_PUSH, tmp_path / "Trial_other")
    assert validate_fmu(str(pack(TRIAL_PUSH, other, options=options))) == []
    naming = "flat" if options else "structured"
    row("fmpy", f"`validate_fmu`, two Trials in one FMU, {naming} names", "no problem")


def test_flat_names(pack, row):
    assert validate_fmu(str(pack(TRIAL_PUSH, options=["--flat-names"]))) == []
    row("fmpy", "`validate_fmu`, flat names, 5 people", "no problem")


@BOTH
def test_terminals_and_icons(fmus, fmi, row):
    """FMPy has the XSD, but does not look into the file. FMI 2.0.4 takes them from FMI 3.0, with the XSD. A member is a variable; those of Decision fit those of the crowd."""
    members = []
    for fmu in fmus(fmi):
        terminals = xml(fmu, "terminalsAndIcons/terminalsAndIcons.xml")
        etree.XMLSchema(etree.parse(SCHEMA)).assertValid(terminals)
        members.append({m.get("memberName"): m.get("variableName") for m in terminals.iter("TerminalMemberVariable")})
        variables = xml(fmu, "modelDescription.xml").find("ModelVariables")
        causality = {v.get("name"): v.get("causality") for v in variables}
        assert {causality[name] for name in members[-1].values()} == {"input", "output"}
        with zipfile.ZipFile(fmu) as archive:
            names = archive.namelist()
            png = archive.read("terminalsAndIcons/icon.png")
            icon = etree.fromstring(archive.read("terminalsAndIcons/icon.svg"))
        assert len(names) == len(set(names)) and ("model.png" in names) == (fmi == "2")
        assert png[16:20] == png[20:24] and icon.get("width") == icon.get("height"), "squares"
    crowd, decision = members
    assert decision.keys() < crowd.keys()
    assert len(crowd) == (7 if fmi == "3" else 10 * 30) and len(decision) == (6 if fmi == "3" else 9 * 30)
    row("fmpy", f"FMI {fmi}.0: `terminalsAndIcons.xml` of crowd and Decision, with its XSD", "valid; FMPy itself does not read it")


@BOTH
def test_diagram(fmus, fmi):
    """FMI 3.0 wants a PNG wherever there is an SVG. The page shows it."""
    for fmu in fmus(fmi):
        assert validate_fmu(str(fmu)) == []
        with zipfile.ZipFile(fmu) as archive:
            png = archive.read("documentation/diagram.png")
            diagram = etree.fromstring(archive.read("documentation/diagram.svg"))
            assert b'src="diagram.svg"' in archive.read("documentation/index.html")
        width, height = (int.from_bytes(png[place : place + 4], "big") for place in (16, 20))
        assert (width, height) == (int(diagram.get("width")), int(diagram.get("height"))) == (760, 400)
        words = {word.get("aria-label") for word in diagram.iter("{*}path")} - {None}
        variables = {v.name.split("].")[-1].split(".")[0] for v in read_model_description(fmu).modelVariables}
        named = {word for word in words if word[0].isupper()}
        assert {"Fp", "Mp", "Position", "Theta", "Velocity"} <= named <= variables


@BOTH
def test_types(fmus, fmi):
    """Every Real has a type, and no unit of its own. The names of types are no names of variables."""
    tag = "Float64" if fmi == "3" else "Real"
    for fmu in fmus(fmi):
        root = xml(fmu, "modelDescription.xml")
        types = {of.get("name"): of if fmi == "3" else of[0] for of in root.find("TypeDefinitions")}
        assert not types.keys() & {v.get("name") for v in root.find("ModelVariables")}
        units = {unit.get("name"): {shown.get("name") for shown in unit.iter("DisplayUnit")} for unit in root.iter("Unit")}
        for of in types.values():
            assert of.get("quantity") and float(of.get("nominal")) > 0
            assert of.get("displayUnit") in {None, *units[of.get("unit")]}
        reals = [real for real in root.find("ModelVariables").iter(tag) if real.get("name") != "time"]
        assert {real.get("declaredType") for real in reals} == types.keys()
        assert not any(real.get(name) for real in reals for name in ("unit", "quantity", "displayUnit", "nominal"))


@BOTH
def test_who_made_it_of_what(fmus, pack, tmp_path, fmi):
    """Names, licence, and the content's fingerprint, which changes with the content only."""

    def contents(fmu):
        return [(content.get("name"), content.get("fingerprint")) for content in xml(fmu, "modelDescription.xml").iter("Content")]

    for fmu, name in zip(fmus(fmi), (TRIAL_DOOR.name, "decision.toml")):
        root = xml(fmu, "modelDescription.xml")
        assert root.get("author") and root.get("license") == "MIT OR Apache-2.0"
        assert root.get("copyright") in (REPOSITORY / "LICENSE-MIT").read_text().splitlines()
        assert root.find(".//Packed").get("version") == root.get("version")
        ((found, fingerprint),) = contents(fmu)
        assert found == name and len(fingerprint) == 32
    other = shutil.copytree(TRIAL_PUSH, tmp_path / "other")
    options = ["--fmi", fmi]
    same = contents(pack(TRIAL_PUSH, other, options=options))
    assert [name for name, _ in same] == [TRIAL_PUSH.name, "other"] and same[0][1] == same[1][1]
    with open(other / "drive.csv", "a") as drive:
        drive.write("\n")
    changed = contents(pack(TRIAL_PUSH, other, options=options))
    assert changed[0] == same[0] and changed[1][1] != same[1][1]


def test_outputs_keep_the_min_of_their_types(push_fmu):
    """They have no domain of their own; they inherit that of the type."""
    variables = {v.name: v for v in read_model_description(push_fmu).modelVariables if v.causality == "output"}
    least = {name: float(v.declaredType.min) for name, v in variables.items() if v.declaredType and v.declaredType.min}
    assert {"LargestOverlap", "agent[0].MeanPeopleForce", "wall[0].PeakNormalForce"} <= least.keys()
    seen = simulate_fmu(push_fmu, stop_time=1.0, output_interval=0.05, output=list(least))
    assert seen["agent[1].MeanPeopleForce"].max() > 100.0
    assert not [name for name in least if seen[name].min() < least[name]]
