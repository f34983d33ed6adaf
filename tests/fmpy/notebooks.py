"""Runs a notebook without Jupyter, or writes it as the repository has it.

    python tests/fmpy/notebooks.py run examples/notebooks/1_collision.ipynb [--pictures DIR]
    python tests/fmpy/notebooks.py clean examples/notebooks/*.ipynb

`run` executes all code cells in order, as Python without IPython. With --pictures, what a cell shows is written to DIR: figures
and pictures as PNG or SVG, tables as text. `clean` removes outputs, execution counts and what editors add.
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


def run(path, pictures=None):
    warnings.simplefilter("error", SyntaxWarning)
    shown = Shown(pictures)
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    plt.show = lambda *_, **__: shown.figures()
    names = {"__name__": "__main__"}
    for cell in read(path).cells:
        if cell.cell_type != "code":
            continue
        shown.cell = cell.id
        name = f"{Path(path).name}, cell {cell.id}"
        # So that messages show the line.
        linecache.cache[name] = (len(cell.source), None, cell.source.splitlines(keepends=True), name)
        begin = time.monotonic()
        try:
            tree = ast.parse(cell.source, name)
            last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, name, "exec"), names)
            # A semicolon at the end shows nothing, as in Jupyter.
            if last and not cell.source.rstrip().endswith(";"):
                shown.value(eval(compile(ast.Expression(last.value), name, "eval"), names))
            elif last:
                eval(compile(ast.Expression(last.value), name, "eval"), names)
            shown.figures()
        except Exception:
            traceback.print_exc()
            sys.exit(f"{name}: failed")
        print(f"-- {cell.id}: {time.monotonic() - begin:.1f} s", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    running = commands.add_parser("run")
    running.add_argument("notebook", type=Path)
    running.add_argument("--pictures", type=Path, metavar="DIR")
    cleaning = commands.add_parser("clean")
    cleaning.add_argument("notebooks", type=Path, nargs="+")
    given = parser.parse_args()
    if given.command == "clean":
        for path in given.notebooks:
            path.write_text(clean(path), encoding="utf-8")
    else:
        if given.pictures:
            given.pictures.mkdir(parents=True, exist_ok=True)
        run(given.notebook, given.pictures)


if __name__ == "__main__":
    main()
