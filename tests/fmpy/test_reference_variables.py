"""The tables of docs/reference/variables.md are those of the FMUs' model descriptions: `FMI_TABLES=write pytest` writes them."""

import re
import subprocess
import xml.etree.ElementTree as ElementTree

import documented
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH

PAGE = REPOSITORY / "docs/reference/variables.md"
HEADER = ["name", "type", "unit", "causality", "variability", "start", "description"]
# Of what a name has for each agent, material, pair of them, and way-point.
SHORT = [
    (r"^agent\[\d+\]", "agent[i]"),
    (r"Waypoint\[\d+\]", "Waypoint[k]"),
    (r"^material\.(\w+|'[^']*')\.", "material.ID."),
    (r"^contact\.(\w+|'[^']*')\.(\w+|'[^']*')\.", "contact.ID1.ID2."),
]


def described(lemons, *words):
    """The variables, and the unit of each element that says a type."""
    done = subprocess.run([lemons, "describe", *words], check=True, capture_output=True, text=True)
    root = ElementTree.fromstring(done.stdout)
    types = {of.get("name"): of.get("unit") or of[0].get("unit") for of in root.find("TypeDefinitions")}
    return root.find("ModelVariables"), lambda typed: types.get(typed.get("declaredType"), typed.get("unit", ""))


def start(text):
    """An array's values are too many for a table."""
    first, *others = text.split()
    return f"`{first}`" + (" …" if others else "")


def rows_of_2(variables, unit):
    rows = {}
    for variable in variables:
        (kind,) = (child for child in variable if child.tag in ("Real", "Integer", "Boolean", "String"))
        value = kind.get("start")
        shown = "" if value is None else start(value) if value else "empty"
        name = variable.get("name")
        for pattern, short in SHORT:
            name = re.sub(pattern, short, name)
        description = re.sub(r"^agent Id [^:]+: ", "", variable.get("description"))
        cells = [kind.tag, unit(kind), variable.get("causality"), variable.get("variability"), shown]
        row = [f"`{name}`", *cells, description]
        # All agents, materials and way-points have the same; only the start differs.
        first = rows.setdefault(name, row)
        assert [*first[:5], first[6]] == [*row[:5], row[6]]
    return list(rows.values())


def rows_of_3(variables, unit):
    named = {variable.get("valueReference"): variable.get("name") for variable in variables}
    rows = []
    for variable in variables:
        sizes = [each.get("start") or named[each.get("valueReference")] for each in variable.findall("Dimension")]
        value = variable.get("start")
        if variable.find("Start") is not None:
            value = variable.find("Start").get("value")
        shown = "" if value is None else start(value) if value else "empty"
        name = f"`{variable.get('name')}`" + "".join(f" [{size}]" for size in sizes)
        cells = [variable.tag, unit(variable), variable.get("causality"), variable.get("variability"), shown]
        rows.append([name, *cells, variable.get("description")])
    return rows


@pytest.mark.parametrize(
    ("table", "words", "rows"),
    [
        ("crowd, FMI 2.0", [TRIAL_PUSH], rows_of_2),
        ("crowd, FMI 3.0", [TRIAL_PUSH, "--fmi", "3"], rows_of_3),
        ("Decision, FMI 2.0", [TRIAL_DOOR, "--decision", TRIAL_DOOR / "decision.toml"], rows_of_2),
        ("Decision, FMI 3.0", [TRIAL_DOOR, "--decision", TRIAL_DOOR / "decision.toml", "--fmi", "3"], rows_of_3),
    ],
)
def test_variables(lemons, table, words, rows):
    found = [[cell.replace("|", "\\|") for cell in row] for row in rows(*described(lemons, *words))]
    documented.check(table, HEADER, found, page=PAGE)
