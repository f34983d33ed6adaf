"""What a visitor of the lab does."""

import base64
import csv
import json
import os
import subprocess
import sys
import time
import urllib.parse
import xml.etree.ElementTree as ElementTree
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Download, Error, FloatRect, Locator, Page, expect

# What tests/fmpy uses, too.
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "common"))
from built import LEMONS, missing  # noqa: E402
from built import REPOSITORY as ROOT  # noqa: E402

__all__ = ["LEMONS", "ROOT", "missing"]
#: [s] A machine may have much else to do; while one works on the page, failures should come soon.
PATIENCE = float(os.environ.get("LAB_PATIENCE", 180))


def tab(page: Page, name: str) -> None:
    page.get_by_role("navigation").get_by_role("button", name=name, exact=True).click()


def fill(page: Page, label: str, value: float) -> None:
    field = page.get_by_role("spinbutton", name=label)
    field.fill(str(value))
    field.press("Tab")


def live(page: Page) -> None:
    """A crowd in place of what is there; of a crowd, people are placed again by themselves."""
    if (button := page.get_by_role("button", name="Make this crowd")).count():
        button.click()
    wait(page, lambda: (kept := plan(page))["made"]["base"] == {"kind": "crowd", **kept["crowd"]})


def make(page: Page, number: int, width: float, height: float) -> None:
    """A crowd in a room, sizes in cm."""
    tab(page, "Room")
    fill(page, "Room width", width)
    fill(page, "Room height", height)
    tab(page, "Crowd")
    page.get_by_role("spinbutton", name="People").fill(str(number))
    page.get_by_role("spinbutton", name="People").press("Tab")
    live(page)
    expect(page.get_by_text(f"{number} people placed in")).to_be_visible(timeout=1000 * PATIENCE)


def example(page: Page, name: str, number: int) -> None:
    tab(page, "Start")
    page.get_by_role("button", name=name).click()
    expect(page.get_by_text(f"{number} people placed in")).to_be_visible(timeout=1000 * PATIENCE)


def people(page: Page, count: int) -> None:
    expect(page.get_by_role("row", name=f"People {count}", exact=True)).to_be_visible()


def download(page: Page, name: str, to: Path) -> Path:
    tab(page, "Take away")
    return given(page, name, to)


def given(page: Page, name: str, to: Path) -> Path:
    """What a button gives; a table comes with a file that says where it is from."""
    files: list[Download] = []

    def keep(file: Download) -> None:
        files.append(file)

    page.on("download", keep)
    page.get_by_role("button", name=name, exact=True).click()
    beside = "-metadata.json"

    def told() -> list[str]:
        return sorted((file.suggested_filename for file in files), key=lambda name: name.endswith(beside))

    # They come in any order.
    wait(page, lambda: told()[:1] != [] and not told()[0].endswith(beside) and len(files) == (2 if told()[0].endswith(".csv") else 1))
    page.remove_listener("download", keep)
    for file in files:
        file.save_as(to / file.suggested_filename)
    return to / told()[0]


def seconds(page: Page) -> float:
    return float(page.locator(".time").inner_text().split()[0].replace(",", "."))


def wait(page: Page, holds: Callable[[], bool], limit: float = PATIENCE) -> None:
    """Asks again and again. (The policy for contents allows no conditions as text in the page.)"""
    begun = time.monotonic()
    while not holds():
        assert time.monotonic() - begun < limit
        page.wait_for_timeout(50)


def shot(of: Locator, limit: float = PATIENCE) -> bytes:
    """A picture (PNG) of an element, also if the page puts another one in its place meanwhile."""
    begun = time.monotonic()
    while True:
        try:
            return of.screenshot()
        except Error:
            if time.monotonic() - begun > limit:
                raise


def becomes(page: Page, asked: Callable[[], object], wanted: object, limit: float = PATIENCE) -> None:
    """As `wait`, but a failure shows both."""
    begun = time.monotonic()
    while (found := asked()) != wanted and time.monotonic() - begun < limit:
        page.wait_for_timeout(50)
    assert found == wanted


def play_until(page: Page, end: float) -> None:
    if not page.get_by_role("button", name="Pause").count():
        page.get_by_role("button", name="Play").click()
    wait(page, lambda: seconds(page) >= end)
    page.get_by_role("button", name="Pause").click()
    # The time that is shown then stays.
    page.get_by_role("button", name="Play").wait_for()


def show_at(page: Page, end: float) -> None:
    """Shows a time [s] up to which the run is computed, and no further."""
    fill(page, "End of the timeline", end)
    page.get_by_role("slider", name="Time").press("End")
    wait(page, lambda: seconds(page) == end)


def plan(page: Page) -> dict[str, Any]:
    """The scene on the stage, as the page keeps it for its tab."""
    return json.loads(page.evaluate("sessionStorage.getItem('lemons-lab tab')"))


def link(url: str, plan: object) -> str:
    return f"{url}#{urllib.parse.quote(json.dumps(plan))}"


def unpacked(link: str) -> dict[str, Any]:
    """The scene that a link of the page holds."""
    return json.loads(zlib.decompress(base64.urlsafe_b64decode(link.split("#")[1] + "=="), -15))


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def lemons(*arguments: object) -> str:
    said = subprocess.run([LEMONS, *map(str, arguments)], capture_output=True, text=True)
    assert said.returncode == 0, said
    return said.stdout + said.stderr


def same_table(mine: Path, theirs: Path) -> None:
    """To the last bit, as far as both go."""
    texts = [path.read_text().splitlines() for path in (mine, theirs)]
    count = min(map(len, texts))
    assert count > 100 and texts[0][:count] == texts[1][:count]


def held(trial: Path) -> dict[str, str]:
    """The files of a zipped Trial, by their last name."""
    with zipfile.ZipFile(trial) as archive:
        return {name.split("/")[-1]: archive.read(name).decode() for name in archive.namelist()}


def changed(trial: Path, to: Path, text: Callable[[str], str]) -> Path:
    """A copy of a zipped Trial with other texts of its files."""
    with zipfile.ZipFile(trial) as archive, zipfile.ZipFile(to, "w") as copy:
        for name in archive.namelist():
            copy.writestr(name, text(archive.read(name).decode()))
    return to


def places(trial: Path) -> dict[str, tuple[float, float, float]]:
    """Where people are at the start: x and y in m, and where they look in rad."""
    found = {}
    for agent in ElementTree.fromstring(held(trial)["AgentDynamics.xml"]):
        pose = agent.find("Kinematics")
        assert pose is not None
        x, y = map(float, pose.attrib["Position"].split(","))
        found[agent.attrib["Id"]] = x, y, float(pose.attrib["Theta"])
    return found


#: Shows all tools, numbers and settings from the first visit on, at the pace of a clock.
MORE = "try { localStorage.getItem('lemons-lab page') ?? localStorage.setItem('lemons-lab page', '{\"more\": true, \"pace\": 1}'); } catch {}"


#: What a page shows as it is opened, also where one must scroll: controls and words; and the share of the window that the stage
#: has. Words of a choice are those of what is chosen.
SHOWN = """() => {
    const shown = (element) => element.checkVisibility() && !element.closest(".hidden, .skip, option, script, noscript");
    const controls = [...document.querySelectorAll("button, input, select, textarea, summary, a[href]")].filter(shown);
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const words = controls.flatMap(({ selectedOptions }) => [...(selectedOptions ?? [])].map(({ textContent }) => textContent));
    while (texts.nextNode()) if (shown(texts.currentNode.parentElement)) words.push(texts.currentNode.textContent);
    const { left, top, right, bottom } = document.querySelector("canvas").getBoundingClientRect();
    const inside = (from, to, end) => Math.max(0, Math.min(to, end) - Math.max(from, 0)) / end;
    return [controls.length, words.join(" ").split(/\\s+/).filter(Boolean).length, inside(left, right, innerWidth) * inside(top, bottom, innerHeight)];
}"""


class Picture:
    """The stage as a map. Its scale is read off the page's own line, whose ends the page tells in m. It holds until
    another scene is opened, or the picture is zoomed."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.canvas = page.locator("canvas").first
        page.get_by_role("button", name="Measure here").click()
        box = self.box()
        ends = [(round(share * box["width"]), round(share * box["height"])) for share in (0.2, 0.8)]
        self._drag(ends[0], ends[1])
        wait(page, lambda: plan(page)["line"] is not None)
        (left, top), (right, foot) = plan(page)["line"]
        page.get_by_role("button", name="Remove the line and the area").click()
        wait(page, lambda: plan(page)["line"] is None)
        self.scale = (ends[1][0] - ends[0][0]) / (right - left)
        self.origin = ends[0][0] - self.scale * left, ends[0][1] + self.scale * top
        assert abs(ends[1][1] - self.origin[1] + self.scale * foot) < 1

    def box(self) -> FloatRect:
        self.canvas.scroll_into_view_if_needed()
        box = self.canvas.bounding_box()
        assert box
        return box

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """On the canvas, of a place in m."""
        return self.origin[0] + self.scale * x, self.origin[1] - self.scale * y

    def move(self, x: float, y: float) -> None:
        self._move(self.pixel(x, y))

    def click(self, x: float, y: float) -> None:
        self.move(x, y)
        self.page.mouse.down()
        self.page.mouse.up()

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self._drag(self.pixel(*start), self.pixel(*end))

    def _move(self, at: tuple[float, float], steps: int = 1) -> None:
        box = self.box()
        assert 0 < at[0] < box["width"] and 0 < at[1] < box["height"], at
        self.page.mouse.move(box["x"] + at[0], box["y"] + at[1], steps=steps)

    def _drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self._move(start)
        self.page.mouse.down()
        self._move(end, steps=4)
        self.page.mouse.up()
