"""The notebooks run without Jupyter and keep what they claim; they are stored without outputs, as the writer writes them."""

import importlib.util
import os
import re
import subprocess
import sys

import nbformat
import notebooks
import pytest
from crowd import REPOSITORY

PLACE = REPOSITORY / "examples" / "notebooks"
NOTEBOOKS = sorted(PLACE.glob("*.ipynb"))
NAMES = [path.stem for path in NOTEBOOKS]
SECONDS = 1800  # a notebook takes some seconds; a busy machine longer


@pytest.fixture
def run(lemons, tmp_path):
    """Runs a notebook in a process of its own; `changes` are (text, other text) of its code."""

    def run(name, *changes, directory=PLACE):
        if "pedpy" in name and importlib.util.find_spec("pedpy") is None:
            pytest.skip("PedPy has no wheel for this Python")
        notebook = notebooks.read(PLACE / f"{name}.ipynb")
        for old, new in changes:
            assert sum(old in cell.source for cell in notebook.cells if cell.cell_type == "code") == 1, old
            for cell in notebook.cells:
                if cell.cell_type == "code":
                    cell.source = cell.source.replace(old, new)
        path, temporary = tmp_path / f"{name}.ipynb", tmp_path / "temporary"
        path.write_text(nbformat.writes(notebook), encoding="utf-8")
        temporary.mkdir(exist_ok=True)
        environment = {
            **os.environ,
            "LEMONS": str(lemons),
            "MPLBACKEND": "Agg",
            "TMPDIR": str(temporary),
        }
        command = [sys.executable, REPOSITORY / "tests/fmpy/notebooks.py", "run", path, "--pictures", tmp_path / "pictures"]
        done = subprocess.run(command, cwd=directory, env=environment, capture_output=True, text=True, timeout=SECONDS)
        # Files only: empty directories are those of the package and of Dask, for the next process of this user.
        done.left = [str(each) for each in temporary.rglob("*") if each.is_file() and "dask" not in str(each)]
        return done

    return run


def test_there_are_five():
    assert [name.split("_")[0] for name in NAMES] == ["1", "2", "3", "4", "5"]
    readme = (PLACE / "README.md").read_text()
    assert all(f"({path.name})" in readme for path in NOTEBOOKS)


@pytest.mark.parametrize("name", NAMES)
def test_it_runs(run, tmp_path, name):
    done = run(name)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr, done.stderr
    pictures = list((tmp_path / "pictures").glob("*.png"))
    assert len(pictures) >= 1 and all(each.stat().st_size > 10_000 for each in pictures)
    assert done.left == [], "temporary files are removed at the end"


@pytest.mark.parametrize("name", [name for name in NAMES if "resources" in (PLACE / f"{name}.ipynb").read_text()])
def test_it_runs_without_the_repository(run, tmp_path, name):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    done = run(name, directory=elsewhere)
    assert done.returncode == 0, done.stderr
    assert "a row of drawn people" in done.stdout
    assert list(elsewhere.iterdir()) == []


def test_measured_heads_are_drawn(run, tmp_path):
    rows = [f"{k / 10},{person},{0.02 * k},{0.001 * k}" for k in range(30) for person in range(5)]
    heads = tmp_path / "heads.csv"
    heads.write_text("\n".join(["t,id,x,y", *rows, ""]))
    plain = run("2_push")
    assert plain.returncode == 0 and "no measured heads are drawn" in plain.stdout, plain.stderr
    without = {each.name: each.read_bytes() for each in (tmp_path / "pictures").iterdir()}
    drawn = run("2_push", ("HEADS = None", f"HEADS = {str(heads)!r}"), ("HEADS_BEGIN = 0.0", "HEADS_BEGIN = 0.5"))
    assert drawn.returncode == 0 and "no measured heads" not in drawn.stdout, drawn.stderr
    changed = {each.name[3:] for each in (tmp_path / "pictures").iterdir() if each.read_bytes() != without[each.name]}
    assert changed == {"moved.png", "scenes.png"}


@pytest.mark.parametrize(
    ("name", "cell", "change"),
    [
        ("1_collision", "compare-table", ("beta = gamma / (2 * mu)", "beta = gamma / (2.01 * mu)")),
        ("1_collision", "steps", ("(end - meet - duration)", "(end - meet - 1.0001 * duration)")),
        ("2_push", "floor", ("rate = 4.5", "rate = 4.501")),
        ("3_door", "measure-room", ("(5, 2 - WIDTH / 2,", "(5, 2,")),
        ("4_sweep", "sum-check", ("(4.5 * table", "(4.501 * table")),
        ("5_pedpy", "n-of-t-plot", ("[(5.0, 1.5), (5.0, 2.5)]", "[(4.95, 1.5), (4.95, 2.5)]")),
    ],
)
def test_what_it_claims_can_be_wrong(run, name, cell, change):
    done = run(name, change)
    assert done.returncode == 1 and "AssertionError" in done.stderr, done.stderr
    assert f"{name}.ipynb, cell {cell}: failed" in done.stderr


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
    script = REPOSITORY / "tests/fmpy/notebooks.py"
    subprocess.run([sys.executable, script, "clean", path], check=True)
    assert path.read_text(encoding="utf-8") == NOTEBOOKS[0].read_text(encoding="utf-8")
