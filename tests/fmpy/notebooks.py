"""Runs a notebook without Jupyter, or writes it as the repository has it.

    python tests/fmpy/notebooks.py run examples/notebooks/1_collision.ipynb [--pictures DIR] [--wrong CELL OLD NEW]
    python tests/fmpy/notebooks.py clean examples/notebooks/*.ipynb

`run` executes all code cells in order, as Python without IPython. With --pictures, what a cell shows is written to DIR: figures
and pictures as PNG or SVG, tables as text. With --wrong, once or more, the cells from the one with the text OLD up to CELL run once
more at the end, with NEW instead: an assertion of CELL must fail. `clean` removes outputs, execution counts and what editors add.
"""

import argparse
import ast
import io
import linecache
import re
import sys
import time
import traceback
import warnings
from pathlib import Path

import nbformat

METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def read(path):
    return nbformat.reads(Path(path).read_text(encoding="utf-8"), as_version=4)


def clean(path):
    """The text of the file as it should be."""
    notebook = read(path)
    notebook.metadata = nbformat.from_dict(METADATA)
    notebook.nbformat_minor = 5
    for cell in notebook.cells:
        cell.metadata = nbformat.from_dict({})
        cell.source = re.sub(r"[ \t]+$", "", cell.source, flags=re.MULTILINE).strip("\n")
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
        cell.pop("attachments", None)
    nbformat.validate(notebook)
    return nbformat.writes(notebook) + "\n"


class Shown:
    """What cells show, as files of a directory; nothing is kept without one."""

    def __init__(self, directory):
        self.directory = directory
        self.count = 0
        self.cell = ""

    def write(self, ending, data):
        if self.directory:
            self.count += 1
            (self.directory / f"{self.count:02}_{self.cell}.{ending}").write_bytes(data)

    def value(self, value):
        """As Jupyter shows the value of a cell's last line."""
        for ending in "svg", "png":
            draw = getattr(value, f"_repr_{ending}_", None)
            data = draw() if draw else None
            if data:
                self.write(ending, data.encode() if isinstance(data, str) else data)
                return
        if value is not None:
            self.write("txt", f"{value}\n".encode())

    def figures(self):
        """Instead of pyplot.show."""
        from matplotlib import pyplot as plt

        for number in plt.get_fignums():
            file = io.BytesIO()
            plt.figure(number).savefig(file, format="png", dpi=100)
            self.write("png", file.getvalue())
        plt.close("all")


def execute(source, name, names, shown):
    """Runs a cell, and shows what Jupyter shows of it."""
    # So that messages show the line.
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    tree = ast.parse(source, name)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, name, "exec"), names)
    value = eval(compile(ast.Expression(last.value), name, "eval"), names) if last else None
    # A semicolon at the end shows nothing, as in Jupyter.
    if not source.rstrip().endswith(";"):
        shown.value(value)
    shown.figures()


def run(path, pictures=None, wrong=()):
    warnings.simplefilter("error", SyntaxWarning)
    shown = Shown(pictures)
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    plt.show = lambda *_, **__: shown.figures()
    names = {"__name__": "__main__"}
    cells = {cell.id: cell.source for cell in read(path).cells if cell.cell_type == "code"}
    for cell, source in cells.items():
        shown.cell = cell
        name = f"{Path(path).name}, cell {cell}"
        begin = time.monotonic()
        try:
            execute(source, name, names, shown)
        except Exception:
            traceback.print_exc()
            sys.exit(f"{name}: failed")
        print(f"-- {cell}: {time.monotonic() - begin:.1f} s", file=sys.stderr)
    shown.directory = None
    for cell, old, new in wrong:
        failed = fails(Path(path).name, cells, dict(names), shown, old, new)
        if failed != cell:
            sys.exit(f"{Path(path).name}, cell {cell}: does not fail with {new!r}; what fails: {failed}")
        print(f"-- {cell}: fails with {new!r}", file=sys.stderr)


def fails(file, cells, names, shown, old, new):
    """The cell whose assertion fails if a text of one cell is another one."""
    changed, *others = (cell for cell, source in cells.items() if old in source)
    assert not others, f"{old!r} is in several cells"
    for cell in list(cells)[list(cells).index(changed) :]:
        try:
            execute(cells[cell].replace(old, new), f"{file}, cell {cell}", names, shown)
        except AssertionError:
            return cell
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    running = commands.add_parser("run")
    running.add_argument("notebook", type=Path)
    running.add_argument("--pictures", type=Path, metavar="DIR")
    running.add_argument("--wrong", nargs=3, action="append", default=[], metavar=("CELL", "OLD", "NEW"))
    cleaning = commands.add_parser("clean")
    cleaning.add_argument("notebooks", type=Path, nargs="+")
    given = parser.parse_args()
    if given.command == "clean":
        for path in given.notebooks:
            path.write_text(clean(path), encoding="utf-8")
    else:
        if given.pictures:
            given.pictures.mkdir(parents=True, exist_ok=True)
        run(given.notebook, given.pictures, given.wrong)


if __name__ == "__main__":
    main()
