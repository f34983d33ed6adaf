"""The person under the mouse or selected: numbers, place in the survey, menu; a person of one's own in the crowd."""

import re
import tomllib
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from visit import Picture, becomes, download, example, fill, held, lemons, make, places, plan, rows, show_at, tab, wait


def table(page: Page, tmp_path: Path, end: float) -> list[dict[str, str]]:
    """What `lemons run` computes of the scene."""
    trial = download(page, "Trial (zip)", tmp_path)
    lemons("run", trial, "--until", end, "-o", tmp_path / "run.csv")
    return rows(tmp_path / "run.csv")


def test_the_person_under_the_mouse_has_the_numbers_of_the_command(page: Page, tmp_path: Path) -> None:
    make(page, 5, 400, 300)
    wanted = [row for row in table(page, tmp_path, 0.5) if row["t"] == "0.5"]
    tab(page, "Start")
    picture = Picture(page)
    show_at(page, 0.5)
    # Who is selected in the other column has the same numbers, and a place in the survey.
    for row in wanted[:2]:
        picture.move(float(row["x"]), float(row["y"]))
        expect(page.locator("canvas.over-person")).to_have_count(1)
        picture.click(float(row["x"]), float(row["y"]))
        numbers = page.get_by_role("region", name="Numbers")
        expect(numbers.get_by_role("row", name=re.compile(rf"^Id {row['id']}$"))).to_be_visible()
        speed = (float(row["vx"]) ** 2 + float(row["vy"]) ** 2) ** 0.5
        expect(numbers.get_by_role("row", name=f"Speed {speed:.2f} m/s")).to_be_visible()
    people = rows(download(page, "People (CSV)", tmp_path))
    mine = people[int(wanted[1]["id"])]
    expect(page.get_by_role("row", name=re.compile("^Stature more than \\d+ % of the (men|women)"))).to_be_visible()
    page.get_by_role("button", name="Show in the tab Person").click()
    shown = float(page.get_by_role("spinbutton", name="Stature").input_value())
    assert shown == pytest.approx(100 * float(mine["stature_m"]), abs=0.051)


def test_a_person_of_ones_own_joins_the_crowd(page: Page, tmp_path: Path) -> None:
    make(page, 5, 400, 300)
    tab(page, "Person")
    page.get_by_label("Who").select_option(label="Man")
    fill(page, "Mass", 120)
    page.get_by_role("button", name="Put into the crowd").click()
    becomes(page, lambda: [edit["do"] for edit in plan(page)["made"]["edits"]], ["put"])
    expect(page.get_by_role("row", name="People 6", exact=True)).to_be_visible()
    expect(page.get_by_role("row", name="Mass 120 kg")).to_be_visible()
    trial = download(page, "Trial (zip)", tmp_path)
    assert 'Mass="120' in held(trial)["Agents.xml"] and len(places(trial)) == 6
    # In a room with so few people, where most room is nobody is touched.
    assert "no problem" in lemons("check", trial)
    people = rows(download(page, "People (CSV)", tmp_path))
    assert float(people[5]["mass_kg"]) == 120
    # Undo takes it away.
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_role("row", name="People 5", exact=True)).to_be_visible()


def test_the_menu_of_a_person_and_of_the_floor(page: Page, tmp_path: Path) -> None:
    example(page, "Two exits", 60)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="To the start").click()
    at = places(download(page, "Trial (zip)", tmp_path))
    tab(page, "Start")
    picture = Picture(page)
    name, (x, y, _) = next(iter(at.items()))
    left, top = picture.pixel(x, y)
    picture.canvas.click(button="right", position={"x": left, "y": top})
    menu = page.get_by_role("menu", name=f"Person {name}")
    expect(menu).to_be_visible()
    words = menu.get_by_role("menuitem").all_inner_texts()
    assert words == ["Copy", "Delete", 'Send to "right"', 'Send to "below"']
    # By keys, from the first item on.
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    wait(page, lambda: plan(page)["made"]["motion"]["decision"]["agents"] == {name: {"exit": "right", "goal": None}})
    expect(menu).to_have_count(0)
    decision = held(download(page, "Trial (zip)", tmp_path / "sent"))["decision.toml"]
    assert tomllib.loads(decision)["agents"] == {name: {"exit": "right"}}
    # The key of the keyboard opens the one of who is selected.
    picture.canvas.focus()
    page.keyboard.press("ContextMenu")
    expect(menu).to_be_visible()
    page.keyboard.press("Escape")
    expect(menu).to_have_count(0)
    # On the floor.
    picture.canvas.click(button="right", position=dict(zip("xy", picture.pixel(7.5, 0.5))))
    page.get_by_role("menuitem", name="Put the person of the tab Person here").click()
    becomes(page, lambda: len(plan(page)["made"]["edits"]), 1)
    edit = plan(page)["made"]["edits"][0]
    assert (edit["x"], edit["y"]) == pytest.approx((7.5, 0.5), abs=0.05)
