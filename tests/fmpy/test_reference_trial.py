"""docs/reference/trial.md against the reader of a Trial, as `lemons check` uses it: each attribute is left out, misspelt,
of another type, and out of its range. That the page has all attributes is a test of crates/core."""

import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import pages
import pytest
from crowd import TRIAL_PUSH

PAGE = "docs/reference/trial.md"
FILES = {
    "Parameters.xml": "Parameters.xml",
    "Materials.xml": "static/Materials.xml",
    "Geometry.xml": "static/Geometry.xml",
    "Agents.xml": "static/Agents.xml",
    "AgentDynamics.xml": "dynamic/AgentDynamics.xml",
    "AgentInteractions.xml": "dynamic/AgentInteractions.xml",
}
# By the heading, where the element is not the first of its name in the Trial: the file, and the way from its root.
WAYS = {
    "Directories": ("Parameters.xml", "Directories"),
    "Times": ("Parameters.xml", "Times"),
    "Material": ("Materials.xml", "Intrinsic/Material"),
    "Contact": ("Materials.xml", "Binary/Contact"),
    "Dimensions": ("Geometry.xml", "Dimensions"),
    "Wall": ("Geometry.xml", "Wall"),
    "Corner": ("Geometry.xml", "Wall/Corner"),
    "Agent": ("Agents.xml", "Agent"),
    "Shape": ("Agents.xml", "Agent/Shape"),
    "Agent of AgentDynamics.xml": ("AgentDynamics.xml", "Agent"),
    "Kinematics": ("AgentDynamics.xml", "Agent/Kinematics"),
    "Dynamics": ("AgentDynamics.xml", "Agent/Dynamics"),
    "Agent of Interactions": ("AgentInteractions.xml", "Agent"),
    "Agent in Agent of Interactions": ("AgentInteractions.xml", "Agent/Agent"),
    "Interaction": ("AgentInteractions.xml", "Agent/Agent/Interaction"),
    "Wall of Interactions": ("AgentInteractions.xml", "Agent/Wall"),
}
# Values that a type does not have.
OTHER = {
    "number": ["", "fast", "nan", "inf", "0x10", "1,5"],
    "point": ["", "1", "1 2", "1,2,3", "nan,0", "1.1e9,0", "0,-1.1e9"],
    "vector": ["", "1", "1 2", "1,2,3", "0,inf"],
    "text": ["", "  "],
    "Id": ["", " 7", "7 "],
    "place": ["", "-1", "1.5", "1000"],
}
# Values that a type has.
SOME = {"number": ["-1.5", "1e9"], "point": ["1e9,-1e9"], "vector": ["-1e12,0"], "text": [], "Id": ["seven, é"], "place": ["1"]}


def attributes():
    """Each row of the tables of attributes: the heading, and the cells by the names of the columns."""
    return [
        (heading, dict(zip(header, map(pages.plain, row), strict=True)))
        for heading, header, rows in pages.tables(PAGE)
        if header[0] == "attribute"
        for row in rows
    ]


def elements():
    """Each row of the tables of elements: the file, the way from its root to what it stands in, its tag, how often."""
    found = []
    for heading, header, rows in pages.tables(PAGE):
        if header[0] == "element":
            for name, parent, often in rows:
                way = re.findall(r"<(\w+)>", parent)[::-1]
                root = {"Parameters", "Materials", "Geometry", "Agents", "Interactions"}
                found.append((heading.rsplit("/", 1)[-1], "/".join(tag for tag in way if tag not in root), name.strip("`<>"), often))
    return found


def examples():
    return [block for block in pages.blocks(PAGE) if block.language == "xml"]


class Scene:
    """Trial_push with the contacts of the page, of which one file at a time is changed."""

    def __init__(self, directory, lemons):
        self.lemons = lemons
        self.trial = directory / "Trial"
        shutil.copytree(TRIAL_PUSH, self.trial)
        (self.trial / FILES["AgentInteractions.xml"]).write_text(examples()[-1].text, encoding="utf-8")
        self.texts = {name: (self.trial / path).read_text(encoding="utf-8") for name, path in FILES.items()}

    def check(self, name, tree):
        """What `lemons check` says of the Trial with another file: whether it has errors, and the text."""
        path = self.trial / FILES[name]
        path.write_bytes(ElementTree.tostring(tree.getroot(), encoding="utf-8"))
        done = subprocess.run([self.lemons, "check", self.trial], capture_output=True, text=True)
        path.write_text(self.texts[name], encoding="utf-8")
        assert done.returncode in (0, 3), done.stderr
        return done.returncode == 3, done.stdout + done.stderr

    def tree(self, name):
        return ElementTree.ElementTree(ElementTree.fromstring(self.texts[name]))


@pytest.fixture
def scene(tmp_path, lemons):
    return Scene(tmp_path, lemons)


def test_the_scene_has_no_error(scene):
    for name in FILES:
        wrong, said = scene.check(name, scene.tree(name))
        assert not wrong and "is not read" not in said, said


@pytest.mark.parametrize(("heading", "row"), attributes(), ids=[f"{heading} {row['attribute']}" for heading, row in attributes()])
def test_an_attribute_is_what_its_row_says(scene, heading, row):
    name, way = WAYS[heading]
    attribute, kind, bounds = row["attribute"], row["type"], row["range"]

    def wrong(value):
        tree = scene.tree(name)
        element = tree.getroot().find(way)
        if value is None:
            del element.attrib[attribute]
        else:
            element.set(attribute, value)
        refused, said = scene.check(name, tree)
        # The message is about this attribute.
        assert not refused or attribute in said, said
        return refused

    own = scene.tree(name).getroot().find(way).get(attribute)
    assert row["example"] == own, "the example is not that of resources/Trial_push"
    assert wrong(None) == (row["if missing"] == "an error")
    if kind not in OTHER and not kind.startswith("Id of"):
        assert not wrong(kind) and wrong("something else"), f"the only value is {kind!r}"
        if row["if missing"] != "an error":
            assert row["if missing"] == kind
        return
    if kind.startswith("Id of"):
        assert wrong("nobody has this Id") and wrong("")
        return
    for value in OTHER[kind]:
        assert wrong(value), f"{attribute}={value!r} is taken, and is no {kind}"
    if bounds == "any":
        # Another Id is not that which others name: only one that nobody names can be changed.
        for value in SOME[kind] if kind != "Id" else []:
            assert not wrong(value), f"{attribute}={value!r} is refused"
        return
    assert "≤" in bounds or not wrong("1e9"), f"{attribute}=1e9 is refused"
    for bound in bounds.split(", "):
        if bound == "> 0":
            assert wrong("0") and wrong("-1e-9") and not wrong(own)
        elif bound == "≥ 0":
            assert not wrong("0") and wrong("-1e-9") and not wrong("1e-9")
        else:
            other = re.fullmatch(r"≤ (\w+)", bound)[1]
            limit = float(scene.tree(name).getroot().find(way).get(other))
            assert not wrong(repr(limit)) and wrong(repr(limit * 1.001))


@pytest.mark.parametrize("heading", WAYS)
def test_what_is_not_on_the_page_is_not_read(scene, heading):
    name, way = WAYS[heading]
    tree = scene.tree(name)
    tree.getroot().find(way).set("Colour", "red")
    ElementTree.SubElement(tree.getroot().find(way), "Hat")
    refused, said = scene.check(name, tree)
    assert not refused
    tag = way.rsplit("/", 1)[-1]
    assert re.search(f"<{tag}> Colour.*is not read", said) and re.search(f"<Hat>.*is not read in <{tag}>", said), said


@pytest.mark.parametrize(("name", "way", "tag", "often"), elements(), ids=lambda cell: cell.split(",")[0])
def test_an_element_is_there_as_often_as_its_row_says(scene, name, way, tag, often):
    agents = len(scene.tree("Agents.xml").findall("Agent"))
    least = agents if often.startswith("1 for each agent") else int(re.match(r"\d+", often)[0])

    def said(change):
        """What is said of this element, and not of those who name it."""
        tree = scene.tree(name)
        parent = tree.getroot().find(way) if way else tree.getroot()
        change(parent, parent.findall(tag))
        _, text = scene.check(name, tree)
        own = "\n".join(line for line in text.splitlines() if FILES[name] in line)
        return re.findall(f"has no <{tag}>|<{tag}>: duplicate element|it needs two", own)

    def leave(count):
        return lambda parent, children: [parent.remove(child) for child in children[count:]]

    assert not said(leave(least))
    assert least == 0 or said(leave(least - 1))
    more = said(lambda parent, children: parent.append(children[0]))
    assert bool(more) == (often in ("1", "0 or 1"))


def test_the_examples_are_of_the_trial(scene):
    """Each line of an example is one of the file."""
    for block, name in zip(examples(), FILES, strict=True):
        lines = [line.strip() for line in scene.texts[name].splitlines()]
        missing = [line for line in block.text.splitlines() if line.strip() not in lines]
        assert not missing, f"{block.place}: {name} of resources/Trial_push has no line {missing[0]}"
