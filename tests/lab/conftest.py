"""A visitor of the lab: `lemons lab`, and a new page in Chromium."""

import functools
import http.server
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright
from visit import LEMONS, MORE, PATIENCE, link, missing

#: The tests of the short tier: the page shows what the command computes, gives what FMPy runs, opens what it is given, and
#: keeps it. All others are `long`.
SHORT = {
    "test_only_this_machine_is_answered_and_only_with_files_of_the_lab",
    "test_files_come_compressed_where_the_browser_takes_that",
    "test_a_link_is_short_and_opens_a_view_that_leads_into_the_lab",
    "test_the_first_example_moves_when_the_page_is_opened",
    "test_forty_people_in_a_room_with_a_door_move_as_the_command_moves_them",
    "test_the_crowd_of_the_page_is_that_of_the_command",
    "test_those_who_are_pushed_do_as_in_the_command",
    "test_the_fmu_of_the_page_runs_in_fmpy",
    "test_scrubbing_shows_what_the_command_computes",
    "test_the_density_is_that_of_the_command_and_of_a_formula",
    "test_a_broken_trial_is_named_with_file_and_attribute",
    "test_a_reload_and_a_link_bring_all_back_and_undo_takes_it_away",
    "test_a_number_out_of_range_stays_and_is_not_taken",
    "test_what_the_engine_refuses_is_in_the_language",
    "test_the_catalogs_have_the_texts_of_the_page_and_their_places",
    "test_words_of_the_engine_are_not_english",
}


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    named = {item.name.split("[")[0] for item in items}
    # Where all are collected, each name is that of a test.
    if not SHORT <= named and not any("::" in part or part.endswith(".py") for part in config.args):
        raise pytest.UsageError(f"SHORT names no tests: {SHORT - named}")
    for item in items:
        if item.name.split("[")[0] not in SHORT:
            item.add_marker("long")


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
        plain = chromium.new_context

        def context(*, first: bool = False, **options: Any) -> BrowserContext:
            """Of a visitor who wants all that the page has, unless it is the first visit."""
            made = plain(**options)
            if not first:
                made.add_init_script(MORE)
            return made

        chromium.new_context = context  # type: ignore[method-assign]
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
