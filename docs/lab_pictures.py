"""Makes the pictures of docs/lab.md again, in docs/ or in the directory that is given: lab_run.png, lab_3d.png, lab_room.png,
lab_person.png, lab_exits.png. docs/pictures.sh calls it where Playwright, Chromium and the lab are."""

import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent / "tests/lab"))

from visit import LEMONS, example, fill, play_until, tab  # noqa: E402


def main(to: Path) -> None:
    command = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True)
    assert command.stdout
    url = command.stdout.readline().split()[4].rstrip(",")
    with sync_playwright() as playwright:
        arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=arguments)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(url)
        page.wait_for_selector("canvas")
        shown = lambda name: page.screenshot(path=to / f"lab_{name}.png")

        example(page, "The door", 70)
        page.get_by_label("Forces").check()
        play_until(page, 5)
        page.wait_for_timeout(1000)
        shown("run")

        page.get_by_label("Forces").uncheck()
        example(page, "Two exits", 60)
        tab(page, "Motion")
        play_until(page, 5)
        page.wait_for_timeout(1000)
        shown("exits")

        example(page, "The door", 70)
        tab(page, "Crowd")
        play_until(page, 5)
        page.get_by_label("View").select_option(label="3D")
        page.wait_for_timeout(5000)
        shown("3d")
        page.get_by_label("View").select_option(label="From above")

        tab(page, "Start")
        example(page, "A stadium's vomitory", 130)
        play_until(page, 0.2)
        tab(page, "Room")
        page.wait_for_timeout(500)
        shown("room")

        tab(page, "Person")
        fill(page, "Bideltoid breadth", 48)
        page.get_by_label("Section of the body").check()
        page.wait_for_timeout(2000)
        # Without a graphics card, a body that turns is coarse.
        page.get_by_role("checkbox", name="Turn").uncheck()
        page.wait_for_timeout(1500)
        shown("person")
        browser.close()
    command.terminate()


main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS)
