"""Scenes to start from: a question, sliders that act while it runs, and a run that is kept beside another one."""

from pathlib import Path

from playwright.sync_api import Browser, Page, expect
from visit import becomes, download, example, held, lemons, places, plan, rows, seconds, show_at, tab, wait


def slide(page: Page, name: str, value: float) -> None:
    page.get_by_role("slider", name=name).fill(str(value))


def test_a_new_visitor_sees_people_leave_by_a_door(browser: Browser, url: str) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 860}, reduced_motion="no-preference")
    page = context.new_page()
    page.goto(url)
    expect(page.get_by_text("70 people placed in")).to_be_visible()
    assert page.get_by_label("Name of the scene").input_value() == "The door"
    expect(page.get_by_role("heading", name="How long do 70 people need to leave?")).to_be_visible()
    wait(page, lambda: seconds(page) > 0.5)
    # Nothing of it is kept before it is changed.
    assert page.get_by_role("list", name="Your scenes").get_by_role("listitem").count() == 0
    context.close()


def test_a_slider_changes_the_room_while_it_runs_and_the_exit_follows(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    wait(page, lambda: seconds(page) > 0.3)
    slide(page, "Width of the door", 1.5)
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"], [{"at": [8, 3], "width": 1.5}])
    # The line 1 m beyond the door is 2 m longer than it is wide.
    becomes(page, lambda: sorted(plan(page)["made"]["motion"]["wishes"]["exits"][0]["line"]), [[9, 1.25], [9, 4.75]])
    # It runs again by itself.
    wait(page, lambda: seconds(page) > 0.3)
    slide(page, "Desired speed", 0.8)
    slide(page, "People", 30)
    expect(page.get_by_text("30 people placed in")).to_be_visible()
    page.get_by_role("button", name="Pause").click()
    trial = download(page, "Trial (zip)", tmp_path)
    assert len(places(trial)) == 30 and "desired_speed = 0.8" in held(trial)["decision.toml"]
    assert "no problem" in lemons("check", trial)


def test_two_widths_side_by_side_have_the_numbers_of_the_command(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    page.get_by_role("button", name="Pause").click()
    show_at(page, 6)
    first = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    page.get_by_role("button", name="Keep this run to compare").click()
    slide(page, "Width of the door", 1.2)
    expect(page.get_by_text("Kept: The door, 70 people, door 0.9 m")).to_be_visible()
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"][0]["width"], 1.2)
    becomes(page, lambda: sorted(plan(page)["made"]["motion"]["wishes"]["exits"][0]["line"]), [[9, 1.4], [9, 4.6]])
    show_at(page, 6)
    second = download(page, "Trial (zip)", tmp_path / "second")
    left = []
    for name, trial in (("one", first), ("two", second)):
        table = tmp_path / f"{name}.csv"
        lemons("run", trial, "--until", "6", "-o", table)
        left.append(sum(row["active"] == "0" for row in rows(table)[-70:]))
    # A wider door lets more out.
    assert 0 < left[0] < left[1]
    for count in left:
        expect(page.get_by_text(f"{count} of 70 have left. Greatest squeeze")).to_be_visible()
    expect(page.get_by_role("img", name="The run that is kept")).to_be_visible()
    tab(page, "Start")
    page.get_by_role("button", name="End the comparison").click()
    expect(page.get_by_text("Kept:")).to_have_count(0)
