"""Tables of pages that tests fill, most of them of docs/fmi.md: `FMI_TABLES=write pytest tests/fmpy` writes them, else they
are compared."""

import os
from importlib.metadata import version

from crowd import REPOSITORY

PAGE = REPOSITORY / "docs" / "fmi.md"


def tool_version(package):
    """Of a Python package."""
    return version(package)


def table(header, rows):
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, ["---"] * len(header), *rows])


def around(name, text, page):
    """The text before, in and after the table of that name."""
    begin, end = f"<!-- {name}: written by tests -->\n", "\n<!-- end -->"
    assert text.count(begin) == 1, f"{page.name} has no place for the table {name}"
    before, after = text.split(begin)
    inside, after = after.split(end, 1)
    return before + begin, inside, end + after


def check(name, header, rows, whole=True, page=PAGE):
    """The table must hold the rows, and none beside them if they are the `whole`."""
    text = page.read_text(encoding="utf-8")
    before, inside, after = around(name, text, page)
    wanted = table(header, rows)
    if whole and os.environ.get("FMI_TABLES") == "write":
        page.write_text(before + wanted + after, encoding="utf-8")
    else:
        has, wants = inside.splitlines(), wanted.splitlines()
        wrong = [f"lacks {line}" for line in wants if line not in has]
        wrong += [f"has, but no test made {line}" for line in has if whole and line not in wants]
        if whole and not wrong and has != wants:
            wrong = ["has another order of lines"]
        assert not wrong, "\n".join([*(f"{page.name} {line}" for line in wrong), "FMI_TABLES=write pytest tests/fmpy writes it"])
