"""docs/reference/tables.md, exit-codes.md, glossary.md and README.md against the program."""

import csv
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import documented
import pages
import pyarrow.parquet as parquet
import pytest
from crowd import REPOSITORY, TABLE, TRIAL_DOOR, TRIAL_PUSH

PAGE = "docs/reference/tables.md"
EXAMPLES = REPOSITORY / "examples"


def table(heading, page=PAGE):
    """The rows of the only table below a heading, by the names of the columns."""
    (found,) = ((header, rows) for where, header, rows in pages.tables(page) if where == heading)
    header, rows = found
    return [dict(zip(header, map(pages.plain, row), strict=True)) for row in rows]


def first(heading):
    return [next(iter(row.values())) for row in table(heading)]


def call(lemons, directory, *words, code=0):
    done = subprocess.run([lemons, *words], cwd=directory, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stdout + done.stderr


def header(path):
    with open(path, newline="", encoding="utf-8") as file:
        return next(csv.reader(file))


def test_the_table_of_a_run(lemons, tmp_path):
    call(lemons, tmp_path, "run", TRIAL_PUSH, "--until", "0.05", "--format", "parquet", "-o", "run.parquet")
    schema = parquet.read_schema(tmp_path / "run.parquet")
    call(lemons, tmp_path, "run", TRIAL_PUSH, "--until", "0.05", "-o", "run.csv")
    assert header(tmp_path / "run.csv") == schema.names == [row["name"] for row in TABLE]
    rows = [
        [f"`{row['name']}`", str(schema.field(row["name"]).type), row["unit"], f"`{row['variable']}`", row["description"].replace("|", "\\|")]
        for row in TABLE
    ]
    documented.check("run", ["column", "type", "unit", "variable of the FMU", "meaning"], rows, page=REPOSITORY / PAGE)
    text = pages.text_of(PAGE)
    for key in ("columns", "communication_step", "every"):
        assert key.encode() in schema.metadata and f"`{key}`" in text


def test_the_table_of_the_other_fmus(lemons, tmp_path):
    call(lemons, tmp_path, "run", TRIAL_DOOR, "--until", "0.05", "-o", "run.csv", "--outputs", "outputs.csv")
    there = header(tmp_path / "outputs.csv")
    described = call(lemons, tmp_path, "describe", TRIAL_DOOR, "--decision", TRIAL_DOOR / "decision.toml")
    variables = ElementTree.fromstring(described).find("ModelVariables")
    outputs = [f"decision.{each.get('name')}" for each in variables if each.get("causality") == "output"]
    assert there == ["t", *outputs]
    assert "decision.agent[0].Fp.x" in there and "`decision.agent[0].Fp.x`" in pages.text_of(PAGE)


def changed(source, target, column, value=None):
    """A copy of a table whose column is missing, or has a value in its first row."""
    lines = [line for line in source.read_text().splitlines() if not line.startswith("#")]
    names, *rows = csv.reader(lines)
    place = names.index(column)
    if value is not None:
        rows[0][place] = value
    else:
        names, *rows = ([cell for k, cell in enumerate(row) if k != place] for row in (names, *rows))
    with target.open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    return target


@pytest.mark.parametrize(
    ("heading", "source", "command"),
    [
        ("drive.csv", TRIAL_PUSH / "drive.csv", ["run", TRIAL_PUSH, "--until", "0.05", "-o", "run.csv", "--force", "--drive"]),
        ("Measured trajectories", EXAMPLES / "measured_push.csv", ["plot", TRIAL_PUSH, "--at", "0", "-o", "a.png", "--force", "--measured"]),
        ("Measured people", EXAMPLES / "measured_men.csv", ["crowd", "--number", "3", "-o", "Trial", "--force", "--ansur-male"]),
        ("Measured people", EXAMPLES / "measured_women.csv", ["crowd", "--number", "3", "-o", "Trial", "--force", "--ansur-female"]),
    ],
)
def test_a_table_that_is_read(lemons, tmp_path, heading, source, command):
    """Each of its columns is needed, and no others."""
    columns = first(heading)
    call(lemons, tmp_path, *command, source)
    for column in columns:
        said = call(lemons, tmp_path, *command, changed(source, tmp_path / "without.csv", column), code=1)
        assert f'"{column}"' in said
    for column in set(header_of(source)) - set(columns):
        call(lemons, tmp_path, *command, changed(source, tmp_path / "without.csv", column))
    for row in table(heading):
        column = row["column"]
        if "least" in row:
            least, most = float(row["least"]), float(row["most"])
            for value, refused in ((least, False), (least - 1, True), (most, False), (most + 1, True)):
                other = changed(source, tmp_path / "other.csv", column, f"{value:g}")
                done = subprocess.run([lemons, *command, other], cwd=tmp_path, capture_output=True, text=True)
                # Within the range somebody may still be too odd for a body, which is said in other words.
                assert (done.returncode == 1 and re.search(f"{column} = .*: must be within", done.stderr) is not None) == refused, done.stderr
        elif row["unit"]:
            said = call(lemons, tmp_path, *command, changed(source, tmp_path / "other.csv", column, "fast"), code=1)
            assert column in said and "fast" in said


def header_of(source):
    return next(csv.reader(line for line in source.read_text().splitlines() if not line.startswith("#")))


def test_the_examples_say_that_they_are_made_up():
    for path in EXAMPLES.glob("measured*.csv"):
        text = path.read_text()
        lines = text.splitlines()
        assert lines[0].startswith("# Made up") or all(line.endswith(",made up") for line in lines[1:]), path


def test_the_people_of_a_crowd(lemons, tmp_path):
    call(lemons, tmp_path, "crowd", "--number", "3", "--population", "people.csv", "-o", "Trial")
    assert header(tmp_path / "people.csv") == first("The people of a crowd")


def test_the_results_of_a_sweep(lemons, tmp_path):
    text = f"trial = {str(TRIAL_PUSH)!r}\nuntil = 0.05\nstop = {{ of = 'x', at_least = 1e6 }}\nmeasures = {{ far = {{ of = 'x', take = 'max' }} }}\n"
    (tmp_path / "one.toml").write_text(text + "parameters = { TimeStepMechanical = [1e-4, -1.0] }\n")
    call(lemons, tmp_path, "sweep", "one.toml")
    with (tmp_path / "one.csv").open(newline="") as file:
        assert file.readline().startswith("# lemons sweep {")
        rows = list(csv.DictReader(file))
    shown = first("Points and results of a sweep")
    own = {"a parameter's name": "TimeStepMechanical", "a measure's name": "far"}
    assert [own.get(name, name) for name in shown] == list(rows[0])
    assert {row["status"] for row in rows} == set(re.findall(r"`(\w+)` or `(\w+)`", pages.text_of(PAGE).split("`status`", 1)[1])[0])


def test_exit_codes(lemons, tmp_path):
    rows = [row for _, head, rows in pages.tables("docs/reference/exit-codes.md") for row in rows if head[0] == "code"]
    codes = [int(row[0]) for row in rows]
    help = " ".join(subprocess.run([lemons, "--help"], capture_output=True, text=True, check=True).stdout.split())
    listed = re.search(r"Exit codes: (.*?)\.(?: |$)", help)[1]
    assert codes == [int(code) for code in re.findall(r"(?:^|; )(\d+) ", listed)]
    shutil.copytree(REPOSITORY / "resources", tmp_path / "resources")
    shutil.copytree(TRIAL_PUSH, tmp_path / "broken")
    agents = tmp_path / "broken/static/Agents.xml"
    agents.write_text(agents.read_text().replace('Mass="89.0"', 'Mass="-89.0"'))
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/lemons").symlink_to(lemons)
    environment = {**os.environ, "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    for code, _, example in rows:
        command = pages.plain(example).split()
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == int(code), f"{example}: {done.returncode}\n{done.stderr}"


def test_the_glossary_is_in_order_and_leads_to_what_it_names():
    rows = [row for _, _, rows in pages.tables("docs/reference/glossary.md") for row in rows]
    words = [row[0] for row in rows]
    assert words == sorted(words, key=lambda word: re.sub("[^a-z]", "", word.lower())) and len(set(words)) == len(words)
    for word, _, more in rows:
        (link,) = re.findall(r"\]\(([^()#]+)", more)
        text = pages.file_of("docs/reference/glossary.md", link).read_text(encoding="utf-8").lower()
        # In one of its forms.
        stems = [part[:-1] if len(part) > 4 else part for part in re.split(r"[ -]", word.lower())]
        assert all(stem in text for stem in stems), f"{link} does not say {word!r}"


def test_the_index_has_every_page():
    linked = {pages.file_of("docs/reference/README.md", link) for link in pages.links("docs/reference/README.md")}
    there = {path.resolve() for path in (REPOSITORY / "docs/reference").glob("*.md")}
    assert there - linked == {(REPOSITORY / "docs/reference/README.md").resolve()}
