"""The notebooks run without Jupyter and keep what they claim; they are stored without outputs, as the writer writes them."""

import functools
import importlib.util
import os
import re
import subprocess
import sys

import limited
import nbformat
import notebooks
import pytest
from crowd import REPOSITORY

PLACE = REPOSITORY / "examples" / "notebooks"
NOTEBOOKS = sorted(PLACE.glob("*.ipynb"))
NAMES = [path.stem for path in NOTEBOOKS]
SCRIPT = REPOSITORY / "tests/fmpy/notebooks.py"
#: [s] Of a notebook that takes half a minute: for one that hangs.
LIMIT = 1200


# By notebook: a cell with a claim, and a change of a text with which it does not hold.
WRONG = {
    "1_collision": [
        ("compare-table", "beta = gamma / (2 * mu)", "beta = gamma / (2.01 * mu)"),
        ("steps", "(end - meet - duration)", "(end - meet - 1.0001 * duration)"),
    ],
    "2_push": [("floor", "rate = 4.5", "rate = 4.501")],
    "3_door": [("measure-room", "(5, 2 - WIDTH / 2,", "(5, 2,")],
    "4_sweep": [("sum-check", "(4.5 * table", "(4.501 * table")],
    "5_pedpy": [("n-of-t-plot", "[(5.0, 1.5), (5.0, 2.5)]", "[(4.95, 1.5), (4.95, 2.5)]")],
}


def run(lemons, path, directory, to, *options):
    """Runs a notebook in a process of its own: in a directory, with its pictures in another one."""
    if "pedpy" in path.name and importlib.util.find_spec("pedpy") is None:
        pytest.skip("PedPy has no wheel for this Python")
    temporary = to / "temporary"
    temporary.mkdir(parents=True)
    environment = {**os.environ, "LEMONS": str(lemons), "MPLBACKEND": "Agg", "TMPDIR": str(temporary)}
    command = [sys.executable, SCRIPT, "run", path, "--pictures", to / "pictures", *options]
    done = limited.run(command, LIMIT, cwd=directory, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    # Files only: empty directories are those of the package and of Dask, for the next process of this user.
    done.left = [str(each) for each in temporary.rglob("*") if each.is_file() and "dask" not in str(each)]
    done.pictures = {each.name: each.read_bytes() for each in (to / "pictures").glob("*")}
    return done


@pytest.fixture(scope="module")
def whole(lemons, tmp_path_factory):
    """A notebook as it is, then with its claims made wrong; once for all tests."""

    @functools.cache
    def whole(name):
        wrong = [word for claim in WRONG[name] for word in ("--wrong", *claim)]
        return run(lemons, PLACE / f"{name}.ipynb", PLACE, tmp_path_factory.mktemp(name), *wrong)

    return whole


def test_there_are_five():
    assert [name.split("_")[0] for name in NAMES] == ["1", "2", "3", "4", "5"]
    readme = (PLACE / "README.md").read_text()
    assert all(f"({path.name})" in readme for path in NOTEBOOKS)


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_it_runs_and_what_it_claims_can_be_wrong(whole, name):
    done = whole(name)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr, done.stderr
    assert re.findall("^-- (.*): fails with", done.stderr, flags=re.MULTILINE) == [cell for cell, *_ in WRONG[name]]
    pictures = [each for picture, each in done.pictures.items() if picture.endswith(".png")]
    assert len(pictures) >= 1 and all(len(each) > 10_000 for each in pictures)
    assert done.left == [], "temporary files are removed at the end"


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in NAMES if "resources" in (PLACE / f"{name}.ipynb").read_text()])
def test_it_runs_without_the_repository(lemons, tmp_path, name):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    done = run(lemons, PLACE / f"{name}.ipynb", elsewhere, tmp_path / "made")
    assert done.returncode == 0, done.stderr
    assert "a row of drawn people" in done.stdout
    assert list(elsewhere.iterdir()) == []


@pytest.mark.long
def test_measured_heads_are_drawn(lemons, whole, tmp_path):
    rows = [f"{k / 10},{person},{0.02 * k},{0.001 * k}" for k in range(30) for person in range(5)]
    heads = tmp_path / "heads.csv"
    heads.write_text("\n".join(["t,id,x,y", *rows, ""]))
    plain = whole("2_push")
    assert "no measured heads are drawn" in plain.stdout, plain.stderr
    text = (PLACE / "2_push.ipynb").read_text(encoding="utf-8")
    for old, new in ("HEADS = None", f"HEADS = '{heads}'"), ("HEADS_BEGIN = 0.0", "HEADS_BEGIN = 0.5"):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (tmp_path / "2_push.ipynb").write_text(text, encoding="utf-8")
    drawn = run(lemons, tmp_path / "2_push.ipynb", PLACE, tmp_path / "made")
    assert drawn.returncode == 0 and "no measured heads" not in drawn.stdout, drawn.stderr
    assert {name[3:] for name, each in drawn.pictures.items() if each != plain.pictures[name]} == {"moved.png", "scenes.png"}


def test_a_claim_that_cannot_fail_is_found(tmp_path):
    """Of a notebook whose second cell follows from the first one."""
    cells = [nbformat.v4.new_code_cell(source, id=name) for name, source in (("a", "x = 1"), ("b", "assert x == 1"), ("c", "assert x > -9"))]
    path = tmp_path / "two.ipynb"
    path.write_text(nbformat.writes(nbformat.v4.new_notebook(cells=cells)), encoding="utf-8")
    for cell, new, code, said in (
        ("b", "x = 2", 0, "-- b: fails with 'x = 2'"),
        ("b", "x  = 1", 1, "cell b: does not fail with 'x  = 1'; what fails: None"),
        ("c", "x = 2", 1, "cell c: does not fail with 'x = 2'; what fails: b"),
    ):
        done = subprocess.run([sys.executable, SCRIPT, "run", path, "--wrong", cell, "x = 1", new], capture_output=True, text=True)
        assert done.returncode == code and said in done.stderr, done.stderr


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_it_is_stored_clean(path):
    """`python tests/fmpy/notebooks.py clean FILE` writes it so."""
    text = path.read_text(encoding="utf-8")
    assert text == notebooks.clean(path)
    notebook = notebooks.read(path)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    ids = [cell.id for cell in notebook.cells]
    assert len(set(ids)) == len(ids)
    for cell in notebook.cells:
        # An editor makes up others, which say nothing and change when a cell is copied.
        assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", cell.id) and not re.fullmatch(r"[0-9a-f-]{8,}", cell.id), cell.id
        if cell.cell_type == "code":
            assert cell.outputs == [] and cell.execution_count is None
            assert not re.search(r"^\s*[%!]|get_ipython", cell.source, flags=re.MULTILINE), "needs IPython"
            assert max(map(len, cell.source.splitlines())) <= 118, "JupyterLab cuts it off"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_it_asks_explains_and_gives_exercises(path):
    cells = notebooks.read(path).cells
    assert cells[0].cell_type == "markdown" and "**Question.**" in cells[0].source
    assert cells[-1].cell_type == "markdown"
    exercises = cells[-1].source.split("## Exercises")[1]
    assert re.findall(r"^(\d)\. ", exercises, flags=re.MULTILINE) == ["1", "2"]
    code = [cell.source for cell in cells if cell.cell_type == "code"]
    assert sum("assert " in source for source in code) >= 2
    assert len(cells) - len(code) >= 0.7 * len(code), "words between the cells"
    # Documents that are named exist.
    for word in re.findall(r"(?:docs|examples|resources)/[\w./]*\w", "\n".join(cell.source for cell in cells)):
        assert (REPOSITORY / word).exists(), word


def test_clean_removes_what_an_editor_adds(tmp_path):
    path = tmp_path / "one.ipynb"
    notebook = notebooks.read(NOTEBOOKS[0])
    for count, cell in enumerate(notebook.cells):
        cell.metadata["collapsed"] = True
        if cell.cell_type == "code":
            cell.execution_count = count
            cell.outputs = [nbformat.v4.new_output("stream", text="0\n")]
    notebook.metadata["kernelspec"]["name"] = "mine"
    path.write_text(nbformat.writes(notebook, indent=4), encoding="utf-8")
    subprocess.run([sys.executable, SCRIPT, "clean", path], check=True)
    assert path.read_text(encoding="utf-8") == NOTEBOOKS[0].read_text(encoding="utf-8")
