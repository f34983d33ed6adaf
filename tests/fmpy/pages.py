"""The pages for users as tests see them: their code blocks, tables and links."""

import re
from dataclasses import dataclass
from pathlib import Path

from crowd import REPOSITORY

PAGES = sorted(
    path.relative_to(REPOSITORY).as_posix()
    for pattern in ("README.md", "docs/**/*.md", "python/README.md", "examples/**/*.md")
    for path in REPOSITORY.glob(pattern)
)
FENCE = re.compile(r"^( *)```(\S*) *$")
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)\)")


@dataclass(frozen=True)
class Block:
    """A fenced code block."""

    page: str
    #: Of the line after the fence, from 1.
    line: int
    language: str
    text: str

    @property
    def place(self):
        return f"{self.page}:{self.line}"

    @property
    def first(self):
        return self.text.split("\n", 1)[0].strip()


def text_of(page):
    return (REPOSITORY / page).read_text(encoding="utf-8")


def blocks(page):
    """The fenced blocks of a page, without the indentation of their fences."""
    found, begin = [], None
    for number, line in enumerate(text_of(page).splitlines(), 1):
        fence = FENCE.match(line)
        if begin is None and fence:
            begin, indent, language, lines = number, len(fence[1]), fence[2], []
        elif fence and not fence[2]:
            found.append(Block(page, begin + 1, language, "\n".join(lines) + "\n"))
            begin = None
        elif begin is not None:
            lines.append(line[indent:] if line[:indent].isspace() else line)
    assert begin is None, f"{page}:{begin}: the block does not end"
    return found


def prose(page):
    """The lines of a page that are in no block, with their numbers."""
    inside = False
    for number, line in enumerate(text_of(page).splitlines(), 1):
        if FENCE.match(line):
            inside = not inside
        elif not inside:
            yield number, line


def commands(text):
    """The commands of a block for a shell, each with its further lines."""
    found, open_quote = [], False
    for line in text.splitlines():
        if not open_quote and (not line.strip() or line.lstrip().startswith("#")):
            continue
        if found and (open_quote or found[-1].endswith("\\")):
            found[-1] += "\n" + line
        else:
            found.append(line.strip())
        open_quote = found[-1].count("'") % 2 == 1
    return found


def cells(line):
    """Of a row of a table; `\\|` is no border."""
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def tables(page):
    """The tables of a page: the heading they stand under, the cells of the header, and those of the rows."""
    found, heading, lines = [], "", []
    for _, line in [*prose(page), (0, "")]:
        if line.startswith("|"):
            lines.append(line)
            continue
        if lines:
            header, _, *rows = map(cells, lines)
            found.append((heading, header, rows))
            lines = []
        if line.startswith("#"):
            heading = line.lstrip("#").strip()
    return found


def plain(cell):
    """A cell without the marks of code."""
    return cell.replace("`", "").strip()


def anchors(page):
    """What `#…` may name in a page, as forges make it of headings."""
    found = set()
    for _, line in prose(page):
        if line.startswith("#"):
            words = re.sub(r"[^\w\- ]", "", line.lstrip("#").strip().lower().replace("`", ""))
            anchor, again = words.replace(" ", "-"), 0
            while anchor + (f"-{again}" if again else "") in found:
                again += 1
            found.add(anchor + (f"-{again}" if again else ""))
    return found


def links(page):
    """The links of a page with the number of their line."""
    # A link may be broken into two lines.
    text = "\n".join(line for _, line in prose(page))
    return [found[1] for found in LINK.finditer(text)]


def pictures(page):
    """The pictures that a page shows, as paths in the repository."""
    text = "\n".join(line for _, line in prose(page))
    shown = re.findall(r"!\[[^\]]*\]\(([^()\s]+)\)", text)
    return [((REPOSITORY / page).parent / name).resolve().relative_to(REPOSITORY.resolve()).as_posix() for name in shown]


def line_of(page, text):
    """Where a text begins, for messages."""
    return text_of(page).split(text, 1)[0].count("\n") + 1


def file_of(page, link):
    """The file that a relative link names."""
    return ((REPOSITORY / page).parent / link).resolve() if link else Path(REPOSITORY / page).resolve()
