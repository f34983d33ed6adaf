"""A visitor of the lab: `lemons lab`, and a new page in Chromium."""

import functools
import http.server
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright
from visit import LEMONS, PATIENCE, link, missing

# In ms.
expect.set_options(timeout=1000 * PATIENCE)


@pytest.fixture(scope="session")
def url() -> Iterator[str]:
    """The address of the page: of `lemons lab`, or of the files in the folder LAB_DIST while one works on the page."""
    if folder := os.environ.get("LAB_DIST"):
        handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder)
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        return
    if not LEMONS.is_file():
        pytest.exit(missing(LEMONS), returncode=1)
    command = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True)
    assert command.stdout
    line = command.stdout.readline()
    assert line.startswith("the lab is at http://127.0.0.1:"), line
    yield line.split()[4].rstrip(",")
    # Not SIGINT: it stays ignored where these tests are started in the background of a shell.
    command.send_signal(signal.SIGTERM)
    assert command.wait(180) == 0


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # Root may not use Chromium's sandbox. 3D is drawn without a GPU.
        arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=arguments)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Browser, url: str) -> Iterator[Page]:
    """A visitor who follows a link to the push through a row. Nothing may be refused by the policy for contents, or fail in the background."""
    context = browser.new_context(viewport={"width": 1280, "height": 860}, accept_downloads=True)
    page = context.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(link(url, {"name": "A push through a row"}))
    page.wait_for_selector("canvas")
    yield page
    context.close()
    assert not said
