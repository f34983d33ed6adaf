"""Makes the pictures of docs/lab.md again, in docs/ or in the directory that is given: lab_run.png, lab_3d.png, lab_kinds.png, lab_room.png,
lab_person.png, lab_exits.png, lab_compare.png, lab_sweep.png. docs/pictures.sh calls it where Playwright, Chromium and the lab are. Everything in them is the
same each time, but for how long the computer took: `--places` prints where that is, and where other things are."""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
from playwright.sync_api import Page, sync_playwright

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent / "tests/lab"))

from visit import LEMONS, MORE, example, fill, link, live, make, plan, show_at, tab, wait  # noqa: E402

# Letters of Matplotlib, which is on every machine that makes pictures.
FONTS = f"""<?xml version="1.0"?>
<fontconfig>
  <dir>{Path(matplotlib.get_data_path()) / "fonts/ttf"}</dir>
  <cachedir>{{cache}}</cachedir>
  <match><edit name="family" mode="prepend" binding="strong"><string>DejaVu Sans</string></edit></match>
  <match target="font">
    <edit name="antialias" mode="assign"><bool>true</bool></edit>
    <edit name="hinting" mode="assign"><bool>false</bool></edit>
    <edit name="rgba" mode="assign"><const>none</const></edit>
  </match>
</fontconfig>
"""
# What depends on the computer's speed.
CHANGING = "p:has-text('placed in')"
THINGS = "button, select, input, canvas, svg, h1, h2, h3, legend, th, td, p"


def run(page: Page) -> None:
    # As a first visitor has it.
    page.get_by_role("button", name="More", exact=True).click()
    page.get_by_text("Other questions, and your scenes").click()
    example(page, "The door", 70)
    page.get_by_text("Other questions, and your scenes").click()
    page.get_by_role("button", name="Until all have left").click()
    page.get_by_text("All 70 have left after").wait_for(timeout=600_000)
    page.get_by_role("slider", name="Time").fill("2100")


def exits(page: Page) -> None:
    example(page, "Two exits", 60)
    tab(page, "Motion")
    show_at(page, 5)


def space(page: Page) -> None:
    example(page, "The door", 70)
    tab(page, "Crowd")
    show_at(page, 5)
    page.get_by_label("View").select_option(label="3D")
    page.wait_for_timeout(5000)
    # It is coarse while it moves, on a slow machine.
    wait(page, lambda: page.locator("canvas").first.evaluate("it => it.width >= Math.floor(it.clientWidth * devicePixelRatio)"))


def kinds(page: Page) -> None:
    make(page, 30, 800, 600)
    page.get_by_label("Children, elderly, luggage, wheelchairs").check()
    live(page)
    page.get_by_role("combobox", name="Colour").select_option(label="Kind")
    page.get_by_label("View").select_option(label="3D")
    page.wait_for_timeout(5000)
    wait(page, lambda: page.locator("canvas").first.evaluate("it => it.width >= Math.floor(it.clientWidth * devicePixelRatio)"))


def room(page: Page) -> None:
    example(page, "A stadium's vomitory", 130)
    show_at(page, 0.2)
    tab(page, "Room")


def person(page: Page) -> None:
    tab(page, "Person")
    fill(page, "Bideltoid breadth", 48)
    page.get_by_label("Section of the body").check()
    page.wait_for_timeout(2000)


def compare(page: Page) -> None:
    example(page, "The door", 70)
    show_at(page, 10)
    tab(page, "Start")
    page.get_by_role("button", name="Keep this run to compare").click()
    page.get_by_role("slider", name="Width of the door").fill("1.2")
    wait(page, lambda: [[9, 1.4], [9, 4.6]] == sorted(plan(page)["made"]["motion"]["decision"]["exits"][0]["line"]))
    show_at(page, 10)


def sweep(page: Page) -> None:
    example(page, "The door", 70)
    show_at(page, 0.2)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_role("button", name="Begin the sweep").click()
    page.get_by_text("12 of 12 runs").wait_for(timeout=600_000)
    page.get_by_role("button", name="Runs of the sweep (CSV)").scroll_into_view_if_needed()


PICTURES = {"run": run, "exits": exits, "3d": space, "kinds": kinds, "room": room, "person": person, "compare": compare, "sweep": sweep}


def boxes(page: Page, selector: str) -> list[list[float]]:
    """Left, top, width and height of what is visible [pixel]."""
    seen = """it => {
        const { x, y, width, height } = it.getBoundingClientRect();
        const top = document.elementFromPoint(x + width / 2, y + height / 2);
        return top !== null && (it.contains(top) || top.contains(it));
    }"""
    found = [each.bounding_box() for each in page.locator(selector).all() if each.is_visible() and each.evaluate(seen)]
    return [[box["x"], box["y"], box["width"], box["height"]] for box in found if box]


def main(url: str, to: Path) -> dict[str, dict[str, list[list[float]]]]:
    """Returns, for each picture, where things are and where they change."""
    places = {}
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        fonts = Path(scratch) / "fonts.conf"
        fonts.write_text(FONTS.format(cache=scratch))
        arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        environment = {**os.environ, "FONTCONFIG_FILE": str(fonts)}
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=arguments, env=environment)
        for name, show in PICTURES.items():
            # Nothing moves unless it is asked to.
            page = browser.new_page(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
            page.add_init_script(MORE)
            page.goto(link(url, {"name": "A push through a row"}))
            page.wait_for_selector("canvas")
            show(page)
            page.mouse.move(0, 0)
            page.wait_for_timeout(1000)
            page.screenshot(path=to / f"lab_{name}.png")
            places[name] = {"changing": boxes(page, CHANGING), "things": boxes(page, THINGS)}
            page.close()
        browser.close()
    return places


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("to", metavar="DIR", type=Path, nargs="?", default=DOCS)
    parser.add_argument("--places", action="store_true", help="print places in pixels, as JSON")
    given = parser.parse_args()
    command = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True)
    assert command.stdout
    try:
        found = main(command.stdout.readline().split()[4].rstrip(","), given.to)
    finally:
        command.terminate()
    if given.places:
        print(json.dumps(found))
