"""The pictures of docs/lab.md are of today's page."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import limited
import numpy as np
import pytest
from drawn import differing, pixels
from visit import LEMONS, ROOT

NAMES = ["run", "exits", "3d", "kinds", "room", "person"]
#: [pixel] Side of the blocks that are compared, and how many pixels of one may differ.
BLOCK, MOST = 20, 12


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """Where the pictures are, and the places of things in them."""
    to = tmp_path_factory.mktemp("pictures")
    command = [sys.executable, ROOT / "docs/lab_pictures.py", to, "--places"]
    done = limited.run(command, 900, env={**os.environ, "LEMONS": str(LEMONS)}, stdout=subprocess.PIPE)
    assert done.returncode == 0
    return to, json.loads(done.stdout)


def within(box: list[float]) -> tuple[slice, slice]:
    """The rows and columns of a box."""
    left, top, width, height = box
    return slice(max(0, int(top)), int(top + height) + 1), slice(max(0, int(left)), int(left + width) + 1)


def unlike(one: Any, other: Any, changing: list[list[float]]) -> list[tuple[int, int]]:
    """Left and top of the blocks that differ, but for what depends on the computer's speed."""
    differ = differing(one, other)
    for box in changing:
        differ[within(box)] = False
    height, width = differ.shape
    blocks = differ[: height // BLOCK * BLOCK, : width // BLOCK * BLOCK].reshape(height // BLOCK, BLOCK, -1, BLOCK)
    rows, columns = np.nonzero(blocks.sum(axis=(1, 3)) > MOST)
    return [(int(column) * BLOCK, int(row) * BLOCK) for row, column in zip(rows, columns, strict=True)]


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_is_of_this_page(made: tuple[Path, Any], name: str) -> None:
    to, places = made
    new, old = (pixels(path / f"lab_{name}.png") for path in (to, ROOT / "docs"))
    assert new.shape == old.shape
    blocks = unlike(new, old, places[name]["changing"])
    assert not blocks, f"docs/lab_{name}.png is old, at {blocks[:9]}: docs/pictures.sh docs lab"


@pytest.mark.parametrize("name", NAMES)
def test_nothing_can_be_missing(made: tuple[Path, Any], name: str) -> None:
    """Each button, number, field and drawing of the page, painted over, is noticed."""
    to, places = made
    whole = pixels(to / f"lab_{name}.png")
    changing = places[name]["changing"]
    unnoticed, count = [], 0
    for box in places[name]["things"]:
        part = whole[within(box)]
        # What is scrolled away, or cut by the edge of the page.
        if box in changing or min(part.shape[:2]) < 10 or box[1] < 0 or box[1] + box[3] > len(whole):
            continue
        shades, counts = np.unique(part.reshape(-1, 3), axis=0, return_counts=True)
        painted = whole.copy()
        painted[within(box)] = shades[counts.argmax()]
        count += 1
        if not unlike(painted, whole, changing):
            unnoticed.append(box)
    assert count > 20 and not unnoticed
