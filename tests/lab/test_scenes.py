"""What a visitor has made is not lost: names, tabs, links, reloads, a full storage, no network."""

import json
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect
from visit import ROOT, becomes, example, fill, link, make, people, plan, tab, wait


@pytest.fixture
def context(browser: Browser) -> Any:
    context = browser.new_context(viewport={"width": 1280, "height": 860}, accept_downloads=True)
    yield context
    context.close()


def visit(context: BrowserContext, url: str) -> Page:
    page = context.new_page()
    page.goto(url)
    page.wait_for_selector("canvas")
    return page


def names(page: Page) -> list[str]:
    """Of the scenes that are kept, the latest first."""
    tab(page, "Start")
    return page.get_by_role("list", name="Your scenes").locator("strong").all_inner_texts()


def rename(page: Page, name: str) -> None:
    field = page.get_by_label("Name of the scene")
    field.fill(name)
    field.press("Enter")


def test_examples_and_links_write_nothing_over(context: BrowserContext, url: str) -> None:
    page = visit(context, url)
    assert names(page) == []
    make(page, 12, 400, 400)
    rename(page, "Twelve")
    expect(page.get_by_text("saved", exact=True)).to_be_visible()
    mine = plan(page)
    example(page, "The door", 70)
    expect(page.get_by_text("not saved yet", exact=True)).to_be_visible()
    assert names(page) == ["Twelve"]
    # It is kept when it is changed.
    tab(page, "Crowd")
    fill(page, "People", 20)
    becomes(page, lambda: names(page), ["The door", "Twelve"])
    # A link is a copy, too, and does not bring the tab of who sent it.
    other = visit(context, link(url, {**mine, "name": "Sent", "tab": "take"}))
    people(other, 12)
    expect(other.get_by_role("navigation").get_by_role("button", name="Start")).to_have_attribute("aria-current", "page")
    assert names(other) == ["The door", "Twelve"] and other.get_by_label("Name of the scene").input_value() == "Sent"
    page.get_by_role("list", name="Your scenes").get_by_role("button", name="Twelve").first.click()
    people(page, 12)


def test_undo_survives_a_reload(context: BrowserContext, url: str) -> None:
    page = visit(context, url)
    make(page, 5, 400, 400)
    for count in (6, 7, 8):
        fill(page, "People", count)
        people(page, count)
    page.reload()
    people(page, 8)
    for count in (7, 6, 5):
        page.get_by_role("button", name="Undo").click()
        people(page, count)
    page.reload()
    page.get_by_role("button", name="Redo").click()
    people(page, 6)
    # A damaged step is left out, and nothing else.
    page.evaluate("() => { const kept = JSON.parse(sessionStorage['lemons-lab tab']); kept.past.push('{'); sessionStorage['lemons-lab tab'] = JSON.stringify(kept); }")
    page.reload()
    people(page, 6)
    page.get_by_role("button", name="Undo").click()
    people(page, 6)
    page.get_by_role("button", name="Undo").click()
    people(page, 5)


def test_two_tabs_know_of_each_other(context: BrowserContext, url: str) -> None:
    one = visit(context, url)
    make(one, 9, 400, 400)
    rename(one, "Nine")
    other = visit(context, url)
    people(other, 9)
    # The first tab keeps the scene, the second one has a copy.
    expect(other.get_by_text('"Nine" is open in another tab. Here it is a copy')).to_be_visible()
    assert names(other) == ["Nine"] and names(one) == ["Nine"]
    tab(other, "Crowd")
    fill(other, "People", 10)
    people(other, 10)
    becomes(one, lambda: names(one), ["Nine (copy)", "Nine"])
    tab(one, "Crowd")
    fill(one, "People", 11)
    people(one, 11)
    people(other, 10)
    assert names(one) == names(other) and one.get_by_label("Name of the scene").input_value() == "Nine"
    # A tab that is loaded again is the first one as before, also in a browser that does not know which tab has what.
    one.reload()
    people(one, 11)
    one.wait_for_timeout(1500)
    assert one.get_by_label("Name of the scene").input_value() == "Nine"
    one.add_init_script("Object.defineProperty(Navigator.prototype, 'locks', { value: undefined })")
    one.reload()
    people(one, 11)
    kept = "Object.keys(localStorage).find((key) => JSON.parse(localStorage[key]).name === 'Nine')"
    other.evaluate(f"() => {{ const key = {kept}; localStorage[key] = localStorage[key].replace('Nine', 'Ten'); }}")
    expect(one.get_by_text('"Nine" was changed in another tab.')).to_be_visible()


def test_what_is_deleted_comes_back(context: BrowserContext, url: str) -> None:
    page = visit(context, url)
    make(page, 4, 400, 400)
    rename(page, "Four")
    tab(page, "Start")
    page.get_by_role("button", name='Copy "Four"').click()
    assert names(page) == ["Four (copy)", "Four"]
    page.get_by_role("button", name='Delete "Four"', exact=True).click()
    assert names(page) == ["Four (copy)"]
    people(page, 4)
    page.get_by_role("button", name="Bring it back").click()
    assert names(page) == ["Four (copy)", "Four"]


FULL = "Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); };"
FORBIDDEN = "Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('no', 'SecurityError'); } });"


@pytest.mark.parametrize(("script", "words"), [(FULL, "storage is full"), (FORBIDDEN, "allows no storage")])
def test_it_is_told_when_nothing_can_be_kept(context: BrowserContext, url: str, tmp_path: Path, script: str, words: str) -> None:
    page = context.new_page()
    page.add_init_script(script)
    page.goto(url)
    page.wait_for_selector("canvas")
    tab(page, "Crowd")
    fill(page, "People", 6)
    expect(page.get_by_text("6 people placed in")).to_be_visible()
    expect(page.get_by_text("not saved", exact=True)).to_be_visible()
    tab(page, "Start")
    # Without storage, each visit is the first one.
    if words == "allows no storage":
        page.get_by_text("Other questions, and your scenes").click()
    expect(page.get_by_text(words)).to_be_visible()
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Save the scene as a file").click()
    path = tmp_path / waiting.value.suggested_filename
    waiting.value.save_as(path)
    # Another browser opens it.
    other = visit(context, url)
    tab(other, "Start")
    other.get_by_label("Open a scene's file").set_input_files(path)
    people(other, 6)
    assert names(other) == ["The door"]
    bad = tmp_path / "bad.json"
    bad.write_text("[")
    other.get_by_label("Open a scene's file").set_input_files(bad)
    expect(other.get_by_role("alert")).to_contain_text("Bad.json cannot be read")
    people(other, 6)


def test_an_earlier_visit_is_taken_over(context: BrowserContext, url: str) -> None:
    page = visit(context, url)
    make(page, 7, 400, 400)
    kept = json.dumps(plan(page))
    page.evaluate("kept => { localStorage.clear(); sessionStorage.clear(); localStorage['lemons-lab plan 2'] = kept; }", kept)
    # What is hostile among the scenes does no harm.
    page.evaluate("() => { localStorage['lemons-lab scene x'] = '[[['; localStorage['lemons-lab scene y'] = '7'; localStorage['lemons-lab page'] = '{'; }")
    page.close()
    page = visit(context, url)
    # What was shown is not known any more.
    page.get_by_role("button", name="More", exact=True).click()
    people(page, 7)
    assert names(page) == ["Of an earlier visit"]
    assert page.evaluate("localStorage['lemons-lab plan 2'] === undefined")


def test_the_page_opens_without_a_network(context: BrowserContext, url: str) -> None:
    here = url.replace("127.0.0.1", "localhost")
    page = visit(context, here)
    page.evaluate("() => navigator.serviceWorker.ready")
    wait(page, lambda: page.evaluate("() => navigator.serviceWorker.controller !== null"))
    make(page, 8, 400, 400)
    context.set_offline(True)
    page.reload()
    people(page, 8)
    other = visit(context, here)
    people(other, 8)
    # Files carry their build.
    addresses = other.evaluate("() => [...document.scripts].map(script => script.src)")
    assert all("?" in address for address in addresses)
    context.set_offline(False)


def stored(page: Page) -> dict[str, str]:
    """The scenes in the browser, as text."""
    found: dict[str, str] = page.evaluate("({ ...localStorage })")
    return {key: text for key, text in found.items() if key.startswith("lemons-lab scene ")}


def test_a_scene_that_cannot_be_shown_is_not_written_over(context: BrowserContext, url: str, tmp_path: Path) -> None:
    page = visit(context, url)
    make(page, 6, 400, 400)
    rename(page, "Six")
    expect(page.get_by_text("saved", exact=True)).to_be_visible()
    mine = plan(page)
    # So dense that placing takes seconds.
    crowd = {**mine["crowd"], "number": 5000, "region": None, "room": {"outline": [[0, 0], [22.5, 0], [22.5, 22.5], [0, 22.5]], "obstacles": [], "doors": []}}
    upload: dict[str, Any] = {"kind": "upload", "name": "gone.zip", "files": [["gone.zip", 9]], "key": "gone"}
    for key, name, base in (("large", "Large", {"kind": "crowd", **crowd}), ("gone", "Gone", upload)):
        made: dict[str, Any] = {"base": base, "edits": [], "motion": {"kind": "own"}}
        text = json.dumps({**mine, "name": name, "made": made, "crowd": crowd, "past": []})
        page.evaluate("([key, text]) => localStorage.setItem('lemons-lab scene ' + key, text)", [key, text])
    before = stored(page)
    page.reload()
    people(page, 6)
    undos = plan(page)["past"]
    assert len(before) == 3 and undos

    def back() -> None:
        people(page, 6)
        expect(page.get_by_label("Name of the scene")).to_have_value("Six")
        expect(page.get_by_text("saved", exact=True)).to_be_visible()
        assert plan(page)["past"] == undos and stored(page) == before

    tab(page, "Start")
    scenes = page.get_by_role("list", name="Your scenes")
    scenes.get_by_role("button", name="Large").first.click()
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_text("Stopped. What was there before")).to_be_visible()
    back()
    scenes.get_by_role("button", name="Gone").first.click()
    expect(page.get_by_role("alert")).to_contain_text('"gone.zip" is not kept in this browser')
    back()
    # A file that is no Trial becomes no scene.
    bad = tmp_path / "bad.zip"
    bad.write_bytes(b"PK\3\4")
    page.get_by_label("Open a zip").set_input_files(bad)
    expect(page.get_by_role("alert")).to_contain_text("bad.zip")
    back()
    # What this tab finds again when it is loaded is not written over, either.
    page.evaluate("() => { sessionStorage['lemons-lab tab'] = JSON.stringify({ ...JSON.parse(localStorage['lemons-lab scene gone']), id: 'gone' }); }")
    page.reload()
    expect(page.get_by_role("alert")).to_contain_text('"gone.zip" is not kept in this browser')
    people(page, 5)
    assert stored(page) == before


def test_what_is_said_about_saving_is_of_the_scene_on_the_stage(context: BrowserContext, url: str) -> None:
    page = visit(context, url)
    for count, name in ((4, "Four"), (5, "Five")):
        make(page, count, 400, 400)
        rename(page, name)
        example(page, "The door", 70)
    page.evaluate("() => { const own = Storage.prototype.setItem; window.mend = () => (Storage.prototype.setItem = own); Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); }; }")
    scenes = page.get_by_role("list", name="Your scenes")
    scenes.get_by_role("button", name="Five").first.click()
    people(page, 5)
    # A copy that cannot be made is none of the scene on the stage.
    page.get_by_role("button", name='Copy "Four"').click()
    expect(page.get_by_role("alert")).to_contain_text("storage is full")
    expect(page.get_by_text("saved", exact=True)).to_be_visible()
    page.get_by_role("button", name="Close this message").click()
    tab(page, "Crowd")
    fill(page, "People", 7)
    people(page, 7)
    expect(page.get_by_text("not saved", exact=True)).to_be_visible()
    # Where there is room again, it is kept without a further change.
    page.evaluate("() => window.mend()")
    tab(page, "Start")
    page.get_by_role("button", name='Delete "Four"', exact=True).click()
    expect(page.get_by_text("saved", exact=True)).to_be_visible()
    page.reload()
    people(page, 7)


def test_a_file_that_an_earlier_version_has_kept_is_found(context: BrowserContext, url: str) -> None:
    page = context.new_page()
    # Of this place, and no page of the lab yet.
    page.goto(f"{url}licences.txt")
    trial = ROOT / "resources/Trial_push"
    files = [(str(path.relative_to(trial)), list(path.read_bytes())) for path in sorted(trial.rglob("*.*"))]
    page.evaluate(
        """bytes => new Promise((done) => {
            const opening = indexedDB.open("lemons-lab", 1);
            opening.onupgradeneeded = () => opening.result.createObjectStore("files", { keyPath: "key" });
            opening.onsuccess = () => {
                const transaction = opening.result.transaction("files", "readwrite");
                transaction.objectStore("files").put({ key: "former", bytes: new Uint8Array(bytes) });
                transaction.oncomplete = () => (opening.result.close(), done());
            };
        })""",
        [byte for _, content in files for byte in content],
    )
    base = {"kind": "upload", "name": "kept", "files": [[f"kept/{name}", len(content)] for name, content in files], "key": "former"}
    page.goto(link(url, {"name": "Earlier", "made": {"base": base, "edits": [], "motion": {"kind": "own"}}}))
    expect(page.get_by_text('"kept": 5 people')).to_be_visible()
