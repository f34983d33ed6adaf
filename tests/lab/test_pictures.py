"""The pictures of docs/lab.md are of today's page."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from visit import LEMONS, ROOT

NAMES = ["run", "exits", "3d", "room", "person"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    to = tmp_path_factory.mktemp("pictures")
    environment = {**os.environ, "LEMONS": str(LEMONS)}
    subprocess.run([sys.executable, ROOT / "docs/lab_pictures.py", to], env=environment, check=True)
    return to


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_is_of_this_page(made: Path, name: str) -> None:
    one, other = (np.asarray(Image.open(path / f"lab_{name}.png").convert("RGB")).astype(int) for path in (made, ROOT / "docs"))
    assert one.shape == other.shape
    # Letters differ from machine to machine; a body that turns is not caught at the same angle.
    part = float((np.abs(one - other).max(axis=2) > 32).mean())
    assert part < 0.04, f"docs/lab_{name}.png is old ({part:.1%} of its pixels differ): docs/pictures.sh docs lab"
