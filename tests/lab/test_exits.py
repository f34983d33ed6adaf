"""Exits and goals that are drawn on the picture: who leaves, when, and that the Trial says the same."""

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect
from visit import ROOT, Picture, becomes, download, fill, held, lemons, link, make, plan, rows, same_table, shot, show_at, tab, wait


def room(page: Page, people: int) -> None:
    """4 m by 3 m, with a door of 1 m in the middle of the wall on the right."""
    tab(page, "Room")
    page.get_by_text("Doors (0)").click()
    page.get_by_role("button", name="Add a door by numbers").click()
    make(page, people, 400, 300)


def exits(page: Page) -> None:
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="All walk to exits and goals")


def decided(page: Page) -> dict[str, Any]:
    return plan(page)["made"]["motion"].get("decision", {"exits": [], "goals": []})


def lines(page: Page) -> list[Any]:
    return [exit["line"] for exit in decided(page)["exits"]]


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def rename(page: Page, which: str, name: str) -> None:
    field = page.get_by_role("textbox", name=f"{which}, name")
    field.fill(name)
    field.press("Tab")


def test_everybody_leaves_by_an_exit_that_is_drawn(page: Page, browser: Browser, url: str, tmp_path: Path) -> None:
    room(page, 12)
    exits(page)
    expect(page.get_by_text("There is no exit yet: nobody walks.")).to_be_visible()
    picture = Picture(page)
    button(page, "Exit")
    picture.click(5, 0.5)
    # The same place again is no second end.
    picture.click(5, 0.5)
    picture.click(4.8, 2.5)
    becomes(page, lambda: lines(page), [[[5, 0.5], [4.8, 2.5]]])
    expect(page.get_by_text("0 of 12 have left.")).to_be_visible()
    picture.drag((4.8, 2.5), (5, 3))
    becomes(page, lambda: lines(page), [[[5, 0.5], [5, 3]]])
    # All of it, by its name in its middle.
    picture.drag((5, 1.75), (5, 1.5))
    becomes(page, lambda: lines(page), [[[5, 0.25], [5, 2.75]]])
    page.get_by_role("button", name="Undo").click()
    becomes(page, lambda: lines(page), [[[5, 0.5], [5, 3]]])
    page.get_by_role("button", name="Redo").click()
    fill(page, "Exit 1, end 1, y", 0)
    rename(page, "Exit 1", "to the street")
    drawn = {"name": "to the street", "line": [[5, 0], [5, 2.75]], "polygon": None, "share": None, "open": None}
    becomes(page, lambda: decided(page)["exits"], [drawn])
    # Delete takes away what is marked, after Esc has ended what is being drawn.
    picture.canvas.focus()
    button(page, "Exit")
    picture.click(1, 1)
    page.keyboard.press("Escape")
    page.keyboard.press("Delete")
    becomes(page, lambda: plan(page)["made"]["motion"], {"kind": "none"})
    page.get_by_role("button", name="Undo").click()
    becomes(page, lambda: decided(page).get("exits"), [drawn])
    page.reload()
    expect(page.get_by_text("0 of 12 have left.")).to_be_visible()
    other = browser.new_context().new_page()
    other.goto(link(url, plan(page)))
    expect(other.get_by_text("0 of 12 have left.")).to_be_visible()
    assert decided(other) == decided(page)
    # Scenes of former pages have another key.
    former = plan(page)
    former["made"]["motion"]["wishes"] = former["made"]["motion"].pop("decision")
    other.goto("about:blank")
    other.goto(link(url, former))
    expect(other.get_by_text("0 of 12 have left.")).to_be_visible()
    assert decided(other) == decided(page) and "wishes" not in plan(other)["made"]["motion"]
    other.context.close()

    page.get_by_label("Pace").select_option(label="4 ×")
    button(page, "Play")
    # The run ends with them.
    told = page.get_by_text("All 12 have left after")
    expect(told).to_be_visible()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    found = re.fullmatch(r"All 12 have left after (\S+) s\.", told.inner_text())
    assert found
    end = float(found[1])
    expect(page.locator(".time")).to_have_text(f"{found[1]} s")
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    decision = tomllib.loads(held(trial)["decision.toml"])
    assert decision["model"] == "rotational" and "exit_choice" not in decision and decision["desired_speed"] == 1.34
    assert decision["exits"] == [{"name": "to the street", "line": [[5, 0], [5, 2.75]]}] and "goals" not in decision
    assert "no problem" in lemons("check", trial)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "left", "-o", table, "--outputs", tmp_path / "outputs.csv")
    same_table(shown, table)
    poses = rows(table)
    assert float(poses[-1]["t"]) == pytest.approx(end) and {row["active"] for row in poses if row["t"] == poses[-1]["t"]} == {"0"}
    assert {row["active"] for row in poses if float(row["t"]) < end - 0.015} == {"0", "1"}
    # When each has left, and what the charts show.
    first: dict[str, float] = {}
    for row in poses:
        if row["active"] == "0":
            first.setdefault(row["id"], float(row["t"]))
    leaving = rows(download(page, "Who left when (CSV)", tmp_path))
    assert {row["id"]: float(row["left [s]"]) for row in leaving} == pytest.approx(first) and len(leaving) == 12
    assert {row["exit"] for row in leaving} == {"to the street"}
    curves = rows(download(page, "Curves (CSV)", tmp_path))
    now = [row for row in poses if row["t"] == poses[len(poses) // 2]["t"] and row["active"] == "1"]
    shown = next(row for row in curves if math.isclose(float(row["t [s]"]), float(now[0]["t"])))
    speeds = [math.hypot(float(row["vx"]), float(row["vy"])) for row in now]
    assert float(shown["mean_speed [m/s]"]) == pytest.approx(sum(speeds) / len(now), rel=1e-5)
    greatest = max(float(row["mean_normal_force"]) for row in now)
    assert float(shown["greatest_squeeze [N]"]) == pytest.approx(greatest, rel=1e-5) and shown["left"] == str(12 - len(now))
    # Of those who are there, the greatest mean of the last ten steps.
    squeezes = np.array([float(row["mean_normal_force"]) for row in poses]).reshape(-1, 12)
    there = np.array([row["active"] == "1" for row in poses]).reshape(-1, 12)
    means = [np.max(squeezes[max(1, k - 9) : k + 1].mean(axis=0) * there[k]) for k in range(1, len(squeezes))]
    assert [float(row["greatest_mean_of_0.1_s [N]"]) for row in curves[1:]] == pytest.approx(means, rel=1e-5, abs=1e-3)


def test_exits_beyond_doors_goals_and_shares(page: Page, tmp_path: Path) -> None:
    room(page, 10)
    exits(page)
    # As `lemons crowd --leave` puts it.
    button(page, "Put an exit beyond each door")
    becomes(page, lambda: [sorted(line) for line in lines(page)], [[[5, 0], [5, 3]]])
    assert decided(page)["exits"][0]["name"] == "door 1"
    expect(page.get_by_role("button", name="Put an exit beyond each door")).to_be_disabled()
    picture = Picture(page)
    button(page, "Exit area")
    corners = [[3.2, 0.2], [3.8, 0.2], [3.8, 0.8], [3.2, 0.8]]
    for corner in corners:
        picture.click(*corner)
    picture.click(*corners[0])
    becomes(page, lambda: [exit["polygon"] for exit in decided(page)["exits"]], [None, corners])
    page.get_by_label("Each exit gets a share of the people").check()
    fill(page, "Exit 1, share", 3)
    fill(page, "Exit 2, share", 7)
    button(page, "Goal")
    picture.click(0.3, 0.5)
    picture.click(0.3, 2.5)
    becomes(page, lambda: [goal["line"] for goal in decided(page)["goals"]], [[[0.3, 0.5], [0.3, 2.5]]])
    rename(page, "Goal 1", "stage")
    page.get_by_label("Exit 1, open at times only").check()
    # At first to the end, also of a time that is added.
    end = lambda opening: page.get_by_role("spinbutton", name=f"Exit 1, opening {opening}, to")
    for opening in (1, 2):
        expect(end(opening)).to_have_value("")
        expect(end(opening)).to_have_attribute("placeholder", "the end")
        button(page, "Add a time")
    becomes(page, lambda: decided(page)["exits"][0]["open"], [[0, 60], [120, 180], [240, 100_000]])
    page.get_by_role("button", name="Delete exit 1, opening 3").click()
    fill(page, "Exit 1, opening 1, to", 20)
    fill(page, "Exit 1, opening 2, from", 20)
    expect(page.get_by_role("alert")).to_contain_text("opening 2, from: 20.01 to ")
    fill(page, "Exit 1, opening 2, from", 30)
    # Times are in order.
    fill(page, "Exit 1, opening 2, to", 29)
    expect(page.get_by_role("alert")).to_contain_text("opening 2, to: 30.01 to ")
    fill(page, "Exit 1, opening 2, to", 90)
    page.get_by_role("combobox", name="Person", exact=True).select_option(label="4")
    page.get_by_label("Person 4 goes to").select_option(label='goal "stage"')
    becomes(page, lambda: decided(page)["agents"], {"4": {"exit": None, "goal": "stage"}})
    rename(page, "Goal 1", "seat")
    page.get_by_label("How they walk among others").select_option(label="Straight on")
    fill(page, "Desired speed", 1)
    page.get_by_label("Some walk in groups, such as families").check()
    fill(page, "People in groups", 80)
    page.get_by_label("Not all start at once").check()
    fill(page, "Last start", 1)
    fill(page, "First start", 2)
    expect(page.get_by_role("alert")).to_contain_text("First start: 0 to 0.9")
    fill(page, "First start", 0.5)
    keys = ("model", "desired_speed", "groups", "start")
    becomes(page, lambda: [decided(page)[key] for key in keys], ["straight", 1, {"share": 0.8}, {"min": 0.5, "max": 1}])
    trial = download(page, "Trial (zip)", tmp_path)
    decision = tomllib.loads(held(trial)["decision.toml"])
    assert (decision["model"], decision["desired_speed"], decision["agents"]) == ("straight", 1, {"4": {"goal": "seat"}})
    assert decision["groups"] == {"share": 0.8} and decision["start"] == {"min": 0.5, "max": 1}
    assert [(exit["name"], exit["share"]) for exit in decision["exits"]] == [("door 1", 3), ("exit 1", 7)]
    assert decision["exits"][0]["open"] == [[0, 20], [30, 90]] and "open" not in decision["exits"][1]
    assert decision["exits"][1]["polygon"] == corners and decision["goals"] == [{"name": "seat", "line": [[0.3, 0.5], [0.3, 2.5]]}]
    # Nine have an exit; who stands in the area has left at once. The command counts the same.
    left = page.get_by_text(" of 9 have left.")
    expect(left).to_be_visible()
    table = tmp_path / "run.csv"
    assert "1 of 10 people have no exit" in lemons("run", trial, "--until", "left", "-o", table, "--outputs", tmp_path / "outputs.csv")
    gone = [row for row in rows(table) if float(row["t"]) == 0 and row["active"] == "0"]
    assert int(left.inner_text().split()[0]) == len(gone)


def test_places_that_cannot_be_are_named(page: Page) -> None:
    room(page, 3)
    exits(page)
    alert = page.get_by_role("alert")
    button(page, "Put an exit beyond each door")
    becomes(page, lambda: len(lines(page)), 1)
    rename(page, "Exit 1", "the street")
    picture = Picture(page)
    becomes(page, lambda: decided(page)["exits"][0]["name"], "the street")
    # Onto the wall below: it is refused, and stays where it was. Each number is taken before the next one is typed.
    line = lines(page)[0]
    for end, axis, to in ((0, 0, 1), (0, 1, 0), (1, 0, 3), (1, 1, 0)):
        line[end][axis] = to
        fill(page, f"Exit 1, end {end + 1}, {'xy'[axis]}", 100 * to)
        if (end, axis) != (1, 1):
            becomes(page, lambda: lines(page), [line])
    expect(alert).to_contain_text('exit "the street": lies on walls')
    assert lines(page) != [[[1, 0], [3, 0]]]
    button(page, "Exit")
    picture.click(1, 1)
    picture.click(2, 1)
    becomes(page, lambda: len(lines(page)), 2)
    expect(alert).to_have_count(0)
    rename(page, "Exit 2", "the street")
    expect(alert).to_contain_text('"the street" is that of another exit or goal')
    expect(page.get_by_role("textbox", name="Exit 2, name")).to_have_value("exit 1")
    # Without a door, nobody gets there. Each step begins when the page has done the one before.
    page.get_by_label("What moves them").select_option(label="Nobody moves by themselves")
    becomes(page, lambda: plan(page)["made"]["motion"], {"kind": "none"})
    tab(page, "Room")
    button(page, "Delete door 1")
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"], [])
    make(page, 3, 400, 300)
    exits(page)
    expect(page.get_by_role("button", name="Put an exit beyond each door")).to_be_disabled()


def test_who_waits_for_a_closed_exit_leaves_and_who_is_shut_out_is_stuck(page: Page, tmp_path: Path) -> None:
    room(page, 3)
    exits(page)
    button(page, "Put an exit beyond each door")
    page.get_by_label("Exit 1, open at times only").check()
    fill(page, "Exit 1, opening 1, from", 2)
    button(page, "Until all have left")
    page.get_by_role("slider", name="Time").press("End")
    told = page.get_by_text("All 3 have left after")
    expect(told).to_be_visible()
    end = float(told.inner_text().split()[-2])
    trial = download(page, "Trial (zip)", tmp_path)
    lemons("run", trial, "--until", "left", "-o", tmp_path / "run.csv")
    assert float(rows(tmp_path / "run.csv")[-1]["t"]) == pytest.approx(end) and end > 2
    expect(page.get_by_role("button", name="Until all have left")).to_be_disabled()
    # An exit that opens too late: it is computed up to a bound, unless it is stopped.
    tab(page, "Motion")
    fill(page, "Exit 1, opening 1, to", 800)
    fill(page, "Exit 1, opening 1, from", 700)
    button(page, "Until all have left")
    # Also beyond the end of the timeline.
    wait(page, lambda: float(page.locator(".status").inner_text().split()[1]) > 31)
    button(page, "Stop computing")
    expect(page.get_by_role("button", name="Until all have left")).to_be_enabled()
    expect(page.get_by_text("Not all have left")).to_have_count(0)
    button(page, "Until all have left")
    expect(page.get_by_text("Not all have left after 600.00 s: it ends there.")).to_be_visible()
    # Who waits for it is not stuck; who walks into a wall is.
    page.get_by_role("slider", name="Time").press("End")
    wait(page, lambda: page.locator(".time").inner_text() == "600.00 s")
    told = page.locator(".numbers .warning").filter(has_text="to get on, but moved by less than 25 cm in the last 10 s.")
    expect(told).to_have_count(0)
    page.get_by_label("What moves them").select_option(label="All walk along ways")
    button(page, "Add a way by numbers")
    fill(page, "Way 1, point 1, y", 800)
    show_at(page, 20)
    trial = download(page, "Trial (zip)", tmp_path / "shut")
    lemons("run", trial, "--until", 20, "-o", tmp_path / "shut.csv")
    found = rows(tmp_path / "shut.csv")
    at = np.array([[float(row["x"]), float(row["y"])] for row in found]).reshape(-1, 3, 2)
    moved = np.hypot(*(at[1000:] - at[2000]).transpose(2, 0, 1)).max(axis=0)
    stuck = [row["id"] for row, far in zip(found[:3], moved, strict=True) if far < 0.25]
    assert len(stuck) > 0
    words = "person wants" if len(stuck) == 1 else "people want"
    expect(told).to_contain_text(f"{len(stuck)} {words}")
    expect(told).to_contain_text(", ".join(stuck))
    # A ring of their own around each.
    before = shot(page.locator(".frame canvas").first)
    told.get_by_role("button", name="Mark them on the picture").click()
    wait(page, lambda: shot(page.locator(".frame canvas").first) != before)


def test_a_wall_closes_a_door_until_it_opens(page: Page, tmp_path: Path) -> None:
    room(page, 3)
    exits(page)
    button(page, "Put an exit beyond each door")
    becomes(page, lambda: len(lines(page)), 1)
    tab(page, "Room")
    page.get_by_label("Door 1, open at times only").check()
    fill(page, "Door 1, opening 1, from", 6)
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"][0].get("open"), [[6, 100_000]])
    # Unless it was computed ahead so far.
    if page.get_by_role("button", name="Until all have left").is_enabled():
        button(page, "Until all have left")
    page.get_by_role("slider", name="Time").press("End")
    told = page.get_by_text("All 3 have left after")
    expect(told).to_be_visible()
    end = float(told.inner_text().split()[-2])
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", "left", "-o", tmp_path / "run.csv")
    assert float(rows(tmp_path / "run.csv")[-1]["t"]) == pytest.approx(end) and end > 6
    # A run that is kept differs in it.
    tab(page, "Start")
    button(page, "Keep this run to compare")
    tab(page, "Room")
    fill(page, "Door 1, opening 1, from", 5)
    expect(page.get_by_text(re.compile(r"Kept: door .* m, open from 6 s on\."))).to_be_visible()
    tab(page, "Take away")
    button(page, "Report to print")
    expect(page.get_by_role("main", name="Report").get_by_role("row", name=re.compile(r"^Doors .*, open from 5 s on$"))).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_exits_and_goals_can_be_seen(page: Page, scheme: str) -> None:
    """WCAG 1.4.11 wants a contrast of 3 of what is drawn, 1.4.3 one of 4.5 of small text: these have both."""
    page.emulate_media(color_scheme="light" if scheme == "light" else "dark")
    room(page, 3)
    exits(page)
    button(page, "Put an exit beyond each door")
    button(page, "Add a goal by numbers")
    becomes(page, lambda: len(decided(page)["goals"]), 1)

    def colour(name: str) -> tuple[int, ...]:
        text = page.evaluate("name => getComputedStyle(document.documentElement).getPropertyValue(name)", name).strip()
        return tuple(int(text[k : k + 2], 16) for k in (1, 3, 5))

    def luminance(rgb: tuple[int, ...]) -> float:
        parts = [c / 255 / 12.92 if c <= 0.04045 * 255 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in rgb]
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]

    paper = luminance(colour("--paper"))
    for name in ("--exit", "--goal"):
        own = luminance(colour(name))
        assert (max(own, paper) + 0.05) / (min(own, paper) + 0.05) >= 4.5, name

    def drawn(rgb: tuple[int, ...]) -> int:
        return page.evaluate(
            """rgb => {
                const canvas = document.querySelector("canvas");
                const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
                let count = 0;
                for (let k = 0; k < data.length; k += 4) if (rgb.every((value, j) => data[k + j] === value)) count += 1;
                return count;
            }""",
            list(rgb),
        )

    for name in ("--exit", "--goal"):
        wait(page, lambda: drawn(colour(name)) > 50, 20)
    # On other tabs, too.
    tab(page, "Crowd")
    for name in ("--exit", "--goal"):
        wait(page, lambda: drawn(colour(name)) > 50, 20)


def test_who_comes_later_is_not_drawn_and_has_not_left(page: Page, tmp_path: Path) -> None:
    """Six people, and 17 of two sources: as the command says."""
    scenario = ROOT / "crates/scenario/tests/crowds/sources.toml"
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(scenario)
    expect(page.get_by_text("23 people").first).to_be_visible()
    tab(page, "Motion")
    expect(page.get_by_text("0 of 23 have left.")).to_be_visible()
    button(page, "Until all have left")
    page.get_by_role("slider", name="Time").press("End")
    told = page.get_by_text("All 23 have left after")
    expect(told).to_be_visible()
    lemons("crowd", "--scenario", scenario, "-o", tmp_path / "T")
    lemons("run", tmp_path / "T", "--until", "left", "-o", tmp_path / "run.csv")
    last = float(rows(tmp_path / "run.csv")[-1]["t"])
    assert float(told.inner_text().split()[-2]) == pytest.approx(last, abs=0.006) and last > 20
