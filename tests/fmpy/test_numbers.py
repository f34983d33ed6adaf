"""Numbers that pages state without showing the command that prints them: those that are ours are what it gives today."""

import csv
import io
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from statistics import median

import pages
import pytest
from crowd import REPOSITORY, TRIAL_PUSH
from test_pictures import DOCS, description


def table(page, column):
    """The rows of the table that has this column, as they are written."""
    (rows,) = (rows for _, header, rows in pages.tables(page) if column in header)
    return rows


def test_the_study_of_doors_is_that_of_its_picture():
    """docs/walking.md; the picture holds the numbers of its runs."""
    page = "docs/walking.md"
    runs = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(io.StringIO(description(DOCS / "door_width.svg")))]
    widths = sorted({run["width"] for run in runs})

    def of(name, width):
        return [run[name] for run in runs if run["width"] == width]

    wanted = []
    for width in widths:
        last, flow = of("last", width), of("flow", width)
        wanted.append(
            [
                f"{width} m",
                f"{median(last):.1f} s ({min(last):.1f} to {max(last):.1f})",
                f"{median(flow):.2f} ({min(flow):.2f} to {max(flow):.2f})",
            ]
        )
    wanted[0][2] += " per m and s"
    assert table(page, "width") == wanted
    first, end = (median(of("squeeze", widths[place])) for place in (0, -1))
    greatest = max(run["squeeze"] for run in runs)
    text = " ".join(pages.text_of(page).split())
    assert f"Its median falls from {first:.0f} N to {end:.0f} N as the door gets wider, and single runs reach {greatest:.0f} N." in text
    assert f"with 80 people (friction 0.4), {len(of('last', widths[0]))} crowds for each of five widths" in text and len(widths) == 5
    assert f"The {len(runs)} runs take" in text


@pytest.mark.long
def test_what_a_softer_body_changes(lemons, tmp_path):
    """docs/guide/squeeze.md: the table is of the commands above it."""
    page = "docs/guide/squeeze.md"
    block = next(block for block in pages.blocks(page) if block.language == "sh")
    (tmp_path / "resources").symlink_to(REPOSITORY / "resources")
    (tmp_path / "lemons").symlink_to(lemons)
    seen = []
    for command in pages.commands(block.text):
        subprocess.run(["bash", "-c", f"./{command}"], cwd=tmp_path, check=True, capture_output=True)
        exposure = json.loads((tmp_path / command.split()[-1]).read_text())["exposure"]
        means = {mean["over"]: mean["mean"] for mean in exposure["largest_mean"]}
        seen.append([each["max"] for each in (exposure["peak"], means[0.1], means[1.0])])
    shown = [[int(re.sub(r"\D", "", cell)) for cell in row[1:]] for row in table(page, "as shipped")]
    assert shown == [[round(each) for each in row] for row in zip(*seen, strict=True)]


@pytest.mark.long
def test_soft_chests_at_a_door(lemons, tmp_path):
    """docs/guide/squeeze.md: the first of its crowds has a peak and a time to leave within the ranges of the table."""
    command = [sys.executable, REPOSITORY / "examples/soft_chest.py", "few", "--seeds", "1", "--steps", "1e-4"]
    subprocess.run(command, cwd=tmp_path, env={**os.environ, "LEMONS": str(lemons)}, check=True, capture_output=True)
    lines = (tmp_path / "few/results.csv").read_text().splitlines()
    runs = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [run["material"] for run in runs] == ["human_naked", "human_soft"]
    shown = {"last": "everybody is out after [s]", "peak": "peak of anybody [N]"}
    rows = {row[0]: row[1:] for _, _, rows in pages.tables("docs/guide/squeeze.md") for row in rows}
    for name, words in shown.items():
        for run, cell in zip(runs, rows[words], strict=True):
            least, greatest = (float(each.replace(" ", "")) for each in re.search(r"\((.*) to (.*)\)", cell).groups())
            assert 0.99 * least <= float(run[name]) <= 1.01 * greatest


def test_the_stiffness_and_the_drive_that_squeeze_names():
    """docs/guide/squeeze.md: the formulas of the paper for the shipped material, and for somebody who leans on others."""
    text = " ".join(pages.text_of("docs/guide/squeeze.md").split())
    material = ElementTree.parse(TRIAL_PUSH / "static/Materials.xml").find(".//Material[@Id='human_naked']")
    young, shear = (float(material.get(name)) for name in ("YoungModulus", "ShearModulus"))
    stiffness = 1 / (2 * (4 * shear - young) / (4 * shear**2))
    words = f"(E = {young / 1e6:.0f} MPa and G = {shear / 1e6:.2f} MPa in the paper's example: {stiffness / 1e6:.1f}e6 N/m)"
    assert words in text
    mass, speed, rate = map(float, re.search(r"N for (\d+) kg, ([\d.]+) m/s and ([\d.]+) /s", text).groups())
    assert f"m v\\*/t_transl: {mass * speed * rate:.0f} N for" in text
