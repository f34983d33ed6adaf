"""The lab in Chromium, as visitors use it. What it computes is compared with the command and with FMPy.

`check.sh lab` runs it: it needs Debian's Chromium, and the command, built after lab/build.sh.
"""

import csv
import http.client
import io
import os
import shutil
import signal
import subprocess
import time
import urllib.parse
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import fmpy
import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

ROOT = Path(__file__).parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
LEMONS = Path(os.environ.get("LEMONS", TARGET / "release/lemons"))
AXE = ROOT / "lab/node_modules/axe-core/axe.min.js"


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    command = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True)
    assert command.stdout
    line = command.stdout.readline()
    assert line.startswith("the lab is at http://127.0.0.1:"), line
    yield line.split()[4].rstrip(",")
    command.send_signal(signal.SIGINT)
    assert command.wait(5) == 0


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # Root may not use Chromium's sandbox.
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Browser, url: str) -> Iterator[Page]:
    """A new visitor. Nothing may be refused by the policy for contents, or fail in the background."""
    context = browser.new_context(viewport={"width": 1280, "height": 860}, accept_downloads=True)
    page = context.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(url)
    page.wait_for_selector("canvas")
    yield page
    context.close()
    assert not said


def tab(page: Page, name: str) -> None:
    page.get_by_role("navigation").get_by_role("button", name=name).click()


def make(page: Page, number: int, across: float, up: float) -> None:
    """A crowd in a room, sizes in cm."""
    tab(page, "Crowd")
    for label, value in [("People", number), ("Room, across", across), ("Room, up", up)]:
        field = page.get_by_role("spinbutton", name=label)
        field.fill(str(value))
        field.press("Tab")
    page.get_by_role("button", name="Make this crowd").click()
    expect(page.get_by_text(f"{number} people placed in")).to_be_visible(timeout=30_000)


def download(page: Page, name: str, to: Path) -> Path:
    tab(page, "Run")
    with page.expect_download() as waiting:
        page.get_by_role("button", name=name, exact=True).click()
    path = to / waiting.value.suggested_filename
    waiting.value.save_as(path)
    return path


def seconds(page: Page) -> float:
    return float(page.locator(".time").inner_text().split()[0])


def wait(page: Page, holds: Callable[[], bool], limit: float = 120) -> None:
    """Asks again and again. (The policy for contents allows no conditions as text in the page.)"""
    begun = time.monotonic()
    while not holds():
        assert time.monotonic() - begun < limit
        page.wait_for_timeout(50)


def play_until(page: Page, end: float) -> None:
    page.get_by_role("button", name="Play").click()
    wait(page, lambda: seconds(page) >= end)
    page.get_by_role("button", name="Pause").click()


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_the_first_example_moves_when_the_page_is_opened(page: Page, tmp_path: Path) -> None:
    wait(page, lambda: seconds(page) >= 1)
    poses = rows(download(page, "Poses (CSV)", tmp_path))
    first, last = poses[0], [row for row in poses if row["id"] == "0"][-1]
    assert float(last["x"]) - float(first["x"]) > 0.1


def test_forty_people_move_as_the_command_moves_them_to_the_last_bit(page: Page, tmp_path: Path) -> None:
    make(page, 40, 400, 400)
    play_until(page, 2)
    shown = rows(download(page, "Poses (CSV)", tmp_path))
    trial = download(page, "Trial (zip)", tmp_path)
    checked = subprocess.run([LEMONS, "check", trial], capture_output=True, text=True, check=True)
    assert "overlap" not in checked.stdout + checked.stderr, checked
    # The command makes the same crowd.
    same = tmp_path / "crowd" / "crowd.zip"
    same.parent.mkdir()
    options = "--number 40 --box 4x4 --seed 1 --direction 0 --speed 1".split()
    subprocess.run([LEMONS, "crowd", *options, "--zip", same], check=True, capture_output=True)
    with zipfile.ZipFile(trial) as mine, zipfile.ZipFile(same) as theirs:
        for name in ("static/Agents.xml", "static/Geometry.xml", "dynamic/AgentDynamics.xml"):
            texts = [archive.read(next(n for n in archive.namelist() if n.endswith(name))) for archive in (mine, theirs)]
            assert texts[0] == texts[1], name
    table = tmp_path / "run.csv"
    subprocess.run([LEMONS, "run", trial, "--until", "2", "-o", table], check=True, capture_output=True)
    known = rows(table)
    assert len(known) == 201 * 40 and len(shown) >= len(known)
    for mine, theirs in zip(shown, known):
        assert mine["id"] == theirs["id"]
        for column in ("t", "x", "y", "theta", "mean_normal_force"):
            assert float(mine[column]) == float(theirs[column]), (mine, theirs)
    # They walk to the right, and press.
    assert max(float(row["mean_normal_force"]) for row in shown) > 100


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_fmu_of_the_page_runs_in_fmpy(page: Page, tmp_path: Path, version: str) -> None:
    fmu = download(page, f"FMU, FMI {version}", tmp_path)
    assert fmpy.read_model_description(fmu, validate=True).fmiVersion == version
    assert not fmpy.validation.validate_fmu(str(fmu))
    result = fmpy.simulate_fmu(str(fmu), stop_time=0.5, output_interval=0.05)
    assert len(result) == 11


def test_a_broken_trial_is_named_with_file_and_attribute(page: Page, tmp_path: Path) -> None:
    good = download(page, "Trial (zip)", tmp_path)
    bad = io.BytesIO()
    with zipfile.ZipFile(good) as source, zipfile.ZipFile(bad, "w") as target:
        for name in source.namelist():
            text = source.read(name).decode()
            if name.endswith("Agents.xml"):
                text = text.replace('Mass="', 'Mass="-', 1)
            target.writestr(name, text)
    upload = page.get_by_label("Open your Trial")
    upload.set_input_files({"name": "bad.zip", "mimeType": "application/zip", "buffer": bad.getvalue()})
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("Agents.xml")
    expect(alert).to_contain_text("Mass")
    upload.set_input_files({"name": "no.zip", "mimeType": "application/zip", "buffer": b"no zip"})
    expect(alert).to_contain_text("no.zip: invalid Zip archive")
    upload.set_input_files(good)
    expect(page.get_by_text("push.zip: 5 people")).to_be_visible()
    expect(alert).to_have_count(0)


def test_a_reload_and_a_link_bring_all_back_and_undo_takes_it_away(page: Page, browser: Browser, url: str) -> None:
    make(page, 25, 350, 300)
    page.reload()
    expect(page.get_by_text("25 people placed in")).to_be_visible()
    assert page.get_by_role("spinbutton", name="People").input_value() == "25"
    link = page.evaluate("location.href.split('#')[0] + '#' + encodeURIComponent(localStorage.getItem('lemons-lab plan 1'))")
    other = browser.new_context().new_page()
    other.goto(link)
    expect(other.get_by_text("25 people placed in")).to_be_visible()
    # It is read once: what is made after it counts more.
    make(other, 20, 300, 300)
    other.reload()
    expect(other.get_by_text("20 people placed in")).to_be_visible()
    # What is no plan, or cannot be made, does no harm.
    other.goto("about:blank")
    other.goto(f"{url}#%7B%22crowd%22:%7B%22number%22:%22many%22%7D,%22source%22:7%7D")
    other.wait_for_selector("canvas")
    other.goto("about:blank")
    impossible = '{"source":{"kind":"crowd","made":{"number":40,"seed":1,"room":[-1,4],"men":0.5,"direction":0,"speed":1}}}'
    other.goto(f"{url}#{urllib.parse.quote(impossible)}")
    expect(other.get_by_role("alert")).to_contain_text("a side of the room [m] = -1: must be 0.1 to 1000")
    other.wait_for_selector("canvas")
    other.context.close()
    field = page.get_by_role("spinbutton", name="People")
    field.fill("30")
    field.press("Tab")
    page.get_by_role("button", name="Undo").click()
    assert field.input_value() == "25"
    page.get_by_role("button", name="Redo").click()
    assert field.input_value() == "30"


def test_a_crowd_that_does_not_fit_is_refused_and_a_placing_is_stopped(page: Page) -> None:
    tab(page, "Crowd")
    for label, value in [("People", 2000), ("Room, across", 1700), ("Room, up", 1700)]:
        field = page.get_by_role("spinbutton", name=label)
        field.fill(str(value))
        field.press("Tab")
    page.get_by_role("button", name="Make this crowd").click()
    page.get_by_role("button", name="Stop", exact=True).click(force=True)
    expect(page.get_by_role("button", name="Make this crowd")).to_be_visible()
    # What ran before is there again, whatever was changed since.
    page.get_by_role("button", name="Step", exact=True).click()
    wait(page, lambda: seconds(page) > 0)
    expect(page.get_by_role("alert")).to_have_count(0)
    page.get_by_role("spinbutton", name="Room, up").fill("200")
    page.get_by_role("spinbutton", name="Room, up").press("Tab")
    page.get_by_role("button", name="Make this crowd").click()
    expect(page.get_by_role("alert")).to_contain_text("without overlap")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_each_part_is_accessible(page: Page, scheme: str) -> None:
    page.emulate_media(color_scheme="light" if scheme == "light" else "dark")
    for name in ("Run", "Crowd", "Person"):
        tab(page, name)
        page.wait_for_timeout(300)
        # The policy allows no script of another place: this one is run as a tool of the browser.
        page.evaluate(AXE.read_text())
        found = page.evaluate("axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'] })")
        assert not [(problem["id"], [node["html"] for node in problem["nodes"]]) for problem in found["violations"]]


def test_a_number_out_of_range_stays_and_is_not_taken(page: Page) -> None:
    tab(page, "Crowd")
    field = page.get_by_role("spinbutton", name="People")
    field.fill("7000")
    field.press("Enter")
    expect(page.get_by_role("alert")).to_have_text("People: a whole number, 1 to 5000")
    expect(field).to_have_value("7000")
    expect(page.get_by_text("people placed in")).to_have_count(0)
    field.fill("12")
    field.press("Enter")
    expect(page.get_by_text("12 people placed in")).to_be_visible()


def test_a_person_is_drawn_as_asked_for(page: Page) -> None:
    tab(page, "Person")
    breadth = page.get_by_role("spinbutton", name="Bideltoid breadth")
    expect(breadth).to_have_value("45")
    breadth.fill("50")
    breadth.press("Tab")
    circles = page.locator("svg circle")
    left = "all => Math.min(...all.map(circle => circle.cx.baseVal.value - circle.r.baseVal.value))"
    wait(page, lambda: abs(circles.evaluate_all(left) + 0.25) < 1e-6)


def test_only_this_machine_is_answered_and_only_with_files_of_the_lab(url: str) -> None:
    host = url.removeprefix("http://").rstrip("/")

    def ask(path: str, method: str = "GET", named: str | None = None) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection(host)
        connection.request(method, path, headers={"Host": named or host})
        response = connection.getresponse()
        response.read()
        return response

    page = ask("/?x=1")
    assert page.status == 200 and page.headers["Content-Type"].startswith("text/html")
    assert "frame-ancestors 'none'" in page.headers["Content-Security-Policy"]
    assert ask("/lemons_lab.wasm").headers["Content-Type"] == "application/wasm"
    assert ask("/", named=host.replace("127.0.0.1", "localhost")).status == 200
    for named in ("example.org", "127.0.0.1", "localhost:1"):
        assert ask("/", named=named).status == 403
    assert ask("/", method="POST").status == 405
    for path in ("/../Cargo.toml", "/binaries/linux64/../../lemons", "//etc/passwd", "/%2e%2e/lemons", "/nothing"):
        assert ask(path).status == 404, path
