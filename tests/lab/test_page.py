"""How the page behaves: uploads, reloads, links, hands, what is accessible."""

import io
import re
import zipfile
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect
from visit import ROOT, SHOWN, Picture, becomes, download, example, fill, link, make, plan, play_until, seconds, tab, wait

AXE = ROOT / "lab/node_modules/axe-core/axe.min.js"


def broken(good: Path) -> bytes:
    bad = io.BytesIO()
    with zipfile.ZipFile(good) as source, zipfile.ZipFile(bad, "w") as target:
        for name in source.namelist():
            text = source.read(name).decode()
            if name.endswith("Agents.xml"):
                text = text.replace('Mass="', 'Mass="-', 1)
            target.writestr(name, text)
    return bad.getvalue()


def test_a_broken_trial_is_named_with_file_and_attribute(page: Page, tmp_path: Path) -> None:
    good = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    upload = page.get_by_label("Open a zip")
    upload.set_input_files({"name": "bad.zip", "mimeType": "application/zip", "buffer": broken(good)})
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("Agents.xml")
    expect(alert).to_contain_text("Mass")
    upload.set_input_files({"name": "no.zip", "mimeType": "application/zip", "buffer": b"no zip"})
    expect(alert).to_contain_text("no.zip: it is no zip")
    upload.set_input_files(good)
    expect(page.get_by_text('"push.zip": 5 people')).to_be_visible()
    expect(alert).to_have_count(0)
    # A reload keeps it, as it was opened.
    page.reload()
    expect(page.get_by_text('"push.zip": 5 people')).to_be_visible()


def test_a_folder_is_opened_too(page: Page) -> None:
    tab(page, "Start")
    page.get_by_label("Open a folder").set_input_files(ROOT / "resources/Trial_door")
    expect(page.get_by_text('"Trial_door": 30 people')).to_be_visible()


def test_a_reload_and_a_link_bring_all_back_and_undo_takes_it_away(page: Page, browser: Browser, url: str) -> None:
    make(page, 25, 350, 300)
    page.reload()
    expect(page.get_by_text("25 people placed in")).to_be_visible()
    expect(page.get_by_role("spinbutton", name="People")).to_have_value("25")
    other = browser.new_context().new_page()
    other.goto(link(url, plan(page)))
    expect(other.get_by_text("25 people placed in")).to_be_visible()
    # It is read once: what is made after it counts more.
    make(other, 20, 300, 300)
    other.reload()
    expect(other.get_by_text("20 people placed in")).to_be_visible()
    # What is no plan, or cannot be made, does no harm.
    for hostile in ({"crowd": {"number": "many"}, "made": 7}, {"made": {"base": {"kind": "upload"}}}, [[[]]], "x" * 100_000):
        other.goto("about:blank")
        other.goto(link(url, hostile))
        other.wait_for_selector("canvas")
    impossible = plan(page)
    impossible["made"]["base"]["room"]["outline"] = [[0, 0], [4, 4], [4, 0], [0, 3]]
    other.goto("about:blank")
    other.goto(link(url, impossible))
    expect(other.get_by_role("alert")).to_contain_text("cross")
    other.wait_for_selector("canvas")
    other.context.close()
    field = page.get_by_role("spinbutton", name="People")
    fill(page, "People", 30)
    page.get_by_role("button", name="Undo").click()
    expect(field).to_have_value("25")
    page.get_by_role("button", name="Redo").click()
    expect(field).to_have_value("30")


def test_a_crowd_that_does_not_fit_is_refused_and_a_placing_is_stopped(page: Page) -> None:
    tab(page, "Room")
    fill(page, "Room width", 1700)
    fill(page, "Room height", 1700)
    tab(page, "Crowd")
    # Nearly as many as fit: that takes some seconds.
    fill(page, "People", 2850)
    page.get_by_role("button", name="Make this crowd").click()
    page.get_by_role("button", name="Stop", exact=True).first.click(force=True)
    expect(page.get_by_role("button", name="Make this crowd")).to_be_visible()
    # What ran before is there again, whatever was changed since.
    def steps() -> bool:
        page.get_by_role("button", name="Step", exact=True).click()
        page.wait_for_timeout(200)
        return seconds(page) > 0

    wait(page, steps)
    expect(page.get_by_role("alert")).to_have_count(0)
    tab(page, "Room")
    fill(page, "Room height", 200)
    page.get_by_role("button", name="Make this crowd").click()
    expect(page.get_by_role("alert")).to_contain_text("without overlap")


def test_a_person_is_moved_by_hand_and_overlaps_are_marked(page: Page) -> None:
    make(page, 8, 400, 400)
    person = page.get_by_role("combobox", name="Person")
    person.select_option(label="3")
    place = [page.get_by_role("spinbutton", name=f"Person, {axis}").input_value() for axis in "xy"]
    person.select_option(label="5")
    for axis, value in zip("xy", place):
        fill(page, f"Person, {axis}", float(value))
    expect(page.get_by_text(re.compile(r"2 people overlap, by up to .* mm")).first).to_be_visible()
    page.get_by_role("button", name="Delete person").click()
    expect(page.get_by_text("overlap, by up to")).to_have_count(0)
    expect(page.get_by_role("row", name="People 7")).to_be_visible()
    for _ in range(3):
        page.get_by_role("button", name="Undo").click()
    expect(page.get_by_role("row", name="People 8")).to_be_visible()
    expect(page.get_by_text("overlap, by up to")).to_have_count(0)


def test_a_person_is_dragged_with_the_mouse(page: Page) -> None:
    make(page, 2, 400, 400)
    page.get_by_role("combobox", name="Person").select_option(label="0")
    picture = Picture(page)
    before = {axis: float(page.get_by_role("spinbutton", name=f"Person, {axis}").input_value()) for axis in "xy"}
    picture.drag((before["x"] / 100, before["y"] / 100), (2, 2))
    wait(page, lambda: len(plan(page)["made"]["edits"]) == 1)
    after = {axis: float(page.get_by_role("spinbutton", name=f"Person, {axis}").input_value()) for axis in "xy"}
    assert abs(after["x"] - 200) < 25 and abs(after["y"] - 200) < 25, (before, after)


def test_who_crosses_a_line_is_counted(page: Page) -> None:
    example(page, "A bottleneck", 60)
    page.get_by_role("button", name="Measure here").click()
    canvas = page.locator("canvas").first
    box = canvas.bounding_box()
    assert box
    # In the middle of those who walk, across all of the picture.
    x = box["x"] + 0.3 * box["width"]
    page.mouse.move(x, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(x, box["y"] + box["height"] - 10, steps=4)
    page.mouse.up()
    wait(page, lambda: plan(page)["line"] is not None)
    page.get_by_label("Pace").select_option(label="4 ×")
    play_until(page, 2)
    charts = page.get_by_role("region", name="Charts")
    expect(charts).to_contain_text(re.compile("[Ll]ine"))
    wait(page, lambda: bool(re.search(r"[1-9]\d* ", charts.inner_text().split("line")[-1])))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_each_part_is_accessible(page: Page, scheme: str) -> None:
    page.emulate_media(color_scheme="light" if scheme == "light" else "dark")
    make(page, 6, 400, 400)
    for more in (True, False):
        for name in ("Start", "Room", "Crowd", "Motion", "Person", "Take away"):
            tab(page, name)
            page.wait_for_timeout(300)
            # The policy allows no script of another place: this one is run as a tool of the browser.
            page.evaluate(AXE.read_text())
            found = page.evaluate("axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'] })")
            problems = [(problem["id"], [node["html"] for node in problem["nodes"]]) for problem in found["violations"]]
            assert not problems, (name, more)
        page.get_by_role("button", name="More", exact=True).click()


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
    # The body turns beside it.
    expect(page.get_by_role("application", name="The body in three dimensions")).to_be_visible()


def test_bodies_and_sections_are_shown(page: Page) -> None:
    make(page, 5, 300, 300)
    page.get_by_label("View").select_option(label="Sections")
    expect(page.get_by_text("cuts 5 of 5 bodies")).to_be_visible()
    page.get_by_label("View").select_option(label="3D")
    wait(page, lambda: page.locator("canvas").count() >= 1)
    expect(page.get_by_role("application", name=re.compile("three dimensions|3D"))).to_be_visible()


def test_a_phone_shows_and_runs(browser: Browser, url: str) -> None:
    context = browser.new_context(viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True)
    phone = context.new_page()
    phone.goto(url)
    phone.wait_for_selector("canvas")
    wait(phone, lambda: seconds(phone) > 0.3)
    assert phone.evaluate("document.documentElement.scrollWidth") <= 360
    expect(phone.get_by_role("heading", level=1)).to_have_text("LEMONS lab")
    canvas = phone.locator("canvas").first.bounding_box()
    pause = phone.get_by_role("button", name="Pause").bounding_box()
    assert canvas and pause and pause["y"] + pause["height"] <= 740, (canvas, pause)
    context.close()


def test_files_are_what_they_are_called(page: Page, tmp_path: Path) -> None:
    make(page, 3, 300, 300)
    play_until(page, 0.3)
    begins = {
        "Picture (SVG)": b"<svg",
        "Picture (PNG)": b"\x89PNG",
        "Movie (WebM)": b"\x1aE\xdf\xa3",
        "Bodies (OBJ)": b"# metres",
        "Bodies (STL)": b"body mesh",
        "People (CSV)": b"id,",
    }
    for name, begin in begins.items():
        content = download(page, name, tmp_path).read_bytes()
        assert content.startswith(begin), (name, content[:40])


@pytest.mark.parametrize("locale", ["en", "de", "fr"])
def test_the_first_screen_has_what_is_needed_first(browser: Browser, url: str, locale: str) -> None:
    context = browser.new_context(first=True, viewport={"width": 1440, "height": 900}, locale=locale)
    page = context.new_page()
    page.goto(url)
    page.wait_for_selector("canvas")
    wait(page, lambda: seconds(page) > 0.3)
    controls, words, stage = page.evaluate(SHOWN)
    assert controls <= 30 and words <= 200 and stage >= 0.55, (controls, words, stage)
    # All else is one click away, and comes back with the visitor.
    page.locator(".tools button[aria-pressed]").click()
    assert page.evaluate(SHOWN)[0] > 60
    page.reload()
    page.wait_for_selector("canvas")
    expect(page.locator(".tools button[aria-pressed=true]")).to_have_count(1)
    context.close()


def test_a_window_that_is_zoomed_to_200_percent_shows_the_stage(browser: Browser, url: str) -> None:
    context = browser.new_context(first=True, viewport={"width": 720, "height": 450}, device_scale_factor=2)
    page = context.new_page()
    page.goto(url)
    page.wait_for_selector("canvas")
    wait(page, lambda: seconds(page) > 0.3)
    assert page.evaluate(SHOWN)[2] > 0.3
    assert page.locator(".time").evaluate("time => time.getBoundingClientRect().bottom") < 450
    context.close()


def test_keys_of_undo_are_those_of_a_field_while_it_is_typed_in(page: Page) -> None:
    make(page, 25, 350, 300)
    tab(page, "Crowd")
    field = page.get_by_role("spinbutton", name="People")
    fill(page, "People", 30)
    field.focus()
    field.press("Control+z")
    expect(field).to_have_value("25")
    field.press("Control+y")
    expect(field).to_have_value("30")
    # What is typed and not taken yet is the browser's.
    field.press("Control+a")
    field.press_sequentially("41")
    field.press("Control+z")
    becomes(page, lambda: plan(page)["crowd"]["number"], 30)
    page.get_by_role("button", name="Undo").click()
    becomes(page, lambda: plan(page)["crowd"]["number"], 25)


def test_the_keyboard_comes_to_the_stage_at_once_and_names_are_whole(page: Page) -> None:
    page.locator("body").press("Tab")
    skip = page.get_by_role("button", name="To the stage")
    expect(skip).to_be_focused()
    skip.press("Enter")
    expect(page.locator("canvas").first).to_be_focused()
    name = page.get_by_label("Name of the scene")
    for width in (1440, 1280):
        page.set_viewport_size({"width": width, "height": 900})
        assert name.evaluate("name => name.scrollWidth <= name.clientWidth")
