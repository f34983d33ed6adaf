"""One table of columns: what the command writes and what examples name is what tests/columns.csv
says, which a test of crates/results compares with `columns.rs`."""

import ast
import json
import re
import subprocess
import xml.etree.ElementTree as ElementTree

import pyarrow.parquet as pq
import pytest
from crowd import AGENT, COLUMNS, INPUTS, REPOSITORY, TABLE, TRIAL_PUSH
from lemons_fmu import simulate

NAMES = list(COLUMNS)
VARIABLES = {row["variable"].removeprefix(AGENT) for row in TABLE[2:]}


def test_tables_of_the_command_have_them(lemons, tmp_path):
    for name in ("run.csv", "run.parquet"):
        command = [lemons, "run", TRIAL_PUSH, "--until", "0.1", "-o", name]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "run.csv").read_text().split("\n")[0] == ",".join(NAMES)
    table = pq.read_table(tmp_path / "run.parquet")
    assert table.schema.names == NAMES
    about = json.loads(table.schema.metadata[b"columns"])
    for row in TABLE:
        wanted = {key: row[key] for key in ("unit", "variable", "description") if row[key]}
        assert about[row["name"]] == wanted


def test_variables_of_the_fmu_have_their_names_and_units():
    root = ElementTree.parse(REPOSITORY / "fmu/modelDescription.xml")
    variables = {v.get("name"): v for v in root.iter("ScalarVariable")}
    units = {of.get("name"): of[0].get("unit") for of in root.iter("SimpleType")}
    for row in TABLE[2:]:
        variable = variables[row["variable"].replace("[i]", "[0]")]
        assert variable.get("causality") == "output"
        kind = variable[0]
        assert (kind.tag, units.get(kind.get("declaredType"))) == (("Real", row["unit"]) if row["unit"] else ("Integer", None)), row
    assert [units[variables[f"agent[0].{name}"][0].get("declaredType")] for name in INPUTS] == ["N", "N", "N.m"]


def test_the_manual_of_simulate_has_them_in_their_order():
    words = re.findall(r"\w+", re.split(r"columns\s+are", simulate.__doc__, maxsplit=1)[1])
    named = [word for word in words if word in COLUMNS]
    assert list(dict.fromkeys(named)) == NAMES


def lists(source):
    """Tuples, lists and sets of texts in a script, and texts that are lists with commas: their items and lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
            items = [item.value for item in node.elts if isinstance(item, ast.Constant) and isinstance(item.value, str)]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and re.fullmatch(r"[\w.]+(,[\w.]+)+", node.value):
            items = node.value.split(",")
        else:
            continue
        yield node.lineno, items


@pytest.mark.parametrize("path", sorted((REPOSITORY / "examples").rglob("*.py")), ids=lambda path: path.name)
def test_examples_name_what_there_is(path):
    """Variables of agents are those of the FMU; a list with one of the table or an input in it has no other names."""
    known = VARIABLES.union(INPUTS)
    for line, items in lists(path.read_text()):
        if known.intersection(items):
            assert known.issuperset(items), f"{path.name}:{line}: {set(items) - known}"
    description = (REPOSITORY / "fmu/modelDescription.xml").read_text()
    for variable in re.findall(r"agent\[[^\]]*\]\.(\w+(?:\.[xy])?)(?![\w.])", path.read_text()):
        assert f'name="agent[0].{variable}"' in description, f"{path.name}: {variable}"
