"""What the stage shows, against the table of the command."""

import math
import re
from pathlib import Path

import matplotlib
import pytest
from playwright.sync_api import Browser, Page, expect
from visit import Picture, becomes, download, example, fill, lemons, make, plan, play_until, rows, seconds, show_at, tab, wait

#: Frames in which everybody is looked at.
EARLY, LATE = 60, 140


def pixels(page: Page) -> str:
    """As a data URL."""
    return page.locator("canvas").first.evaluate("canvas => canvas.toDataURL()")


def scrub(page: Page, frame: int) -> None:
    page.get_by_role("slider", name="Time").fill(str(frame))
    expect(page.locator(".time")).to_have_text(f"{frame / 100:.2f} s")


def painted(picture: Picture, at: tuple[float, float]) -> list[int]:
    """Red, green and blue of a pixel."""
    read = "(canvas, at) => [...canvas.getContext('2d').getImageData(...at, 1, 1).data].slice(0, 3)"
    return picture.canvas.evaluate(read, [round(along) for along in at])


def wanted(page: Page, colour: str, value: float) -> list[float]:
    """As viridis has it, up to the end of the scale; squeeze as a warm grey and magma."""
    numbers = re.findall(r"[\d.,]+", page.locator(".scale").inner_text())
    low, high = (float(number.replace(",", "")) for number in numbers)
    # A whole number would be the place of a colour.
    share = min(1.0, max(0.0, (value - low) / (high - low)))
    if colour != "Squeeze":
        return [255 * part for part in matplotlib.colormaps["viridis"](share)[:3]]
    assert low == 200 and high >= 400
    magma = lambda place: [255 * part for part in matplotlib.colormaps["magma"](0.844 - 0.0531 * (place - 1))[:3]]
    if (place := 15 * share) >= 1:
        return magma(place)
    return [grey + place * (first - grey) for grey, first in zip((220, 214, 203), magma(1), strict=True)]


def test_scrubbing_shows_what_the_command_computes(page: Page, tmp_path: Path) -> None:
    make(page, 40, 400, 400)
    picture = Picture(page)
    play_until(page, LATE / 100)
    table = tmp_path / "run.csv"
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", LATE / 100, "-o", table)
    known = {(round(100 * float(row["t"])), row["id"]): row for row in rows(table)}
    contacts = lambda frame, name: sum(int(known[frame, name][f"{of}_contacts"]) for of in ("agent", "wall"))
    number = lambda frame, name, column: float(known[frame, name][column])
    squeeze = lambda frame, name: sum(number(k, name, "mean_normal_force") for k in range(frame - 9, frame + 1)) / 10
    speed = lambda frame, name: math.hypot(number(frame, name, "vx"), number(frame, name, "vy"))
    person = page.get_by_role("combobox", name="Person")
    fact = lambda name: page.get_by_role("region", name="Numbers").get_by_role("row", name=name).get_by_role("cell").inner_text()

    # Back and forth, for those who are pressed most.
    for frame in (LATE, EARLY, LATE):
        scrub(page, frame)
        pressed = sorted((name for k, name in known if k == frame), key=lambda name: -squeeze(frame, name))
        for name in pressed[:3]:
            person.select_option(label=name)
            x, y = (float(value) for value in re.findall(r"[-\d.]+", fact("Place")))
            assert (x, y) == pytest.approx((100 * number(frame, name, "x"), 100 * number(frame, name, "y")), abs=0.051)
            assert float(fact("Speed").split()[0]) == pytest.approx(speed(frame, name), abs=0.0051)
            assert float(fact("Squeeze, mean of 0.1 s").split()[0].replace(",", "")) == pytest.approx(squeeze(frame, name), abs=0.51)
            assert int(fact("Contacts")) == contacts(frame, name)
        # Those who are selected have a mark of their own.
        person.select_option(label="nobody")
        for colour, value in (
            ("Squeeze", squeeze(frame, pressed[0])),
            ("Speed", speed(frame, pressed[0])),
            ("Contacts", contacts(frame, pressed[0])),
        ):
            page.get_by_label("Colour").select_option(label=colour)
            # Behind the mark of where they look.
            x, y, turn = (number(frame, pressed[0], column) for column in ("x", "y", "theta"))
            at = picture.pixel(x - 0.05 * math.cos(turn), y - 0.05 * math.sin(turn))
            wait(page, lambda: painted(picture, at) == pytest.approx(wanted(page, colour, value), abs=14), 20)


def test_feet_are_drawn_where_they_are(page: Page, tmp_path: Path) -> None:
    make(page, 12, 300, 300)
    picture = Picture(page)
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="Some are pushed")
    page.get_by_role("button", name="Add a push by numbers").click()
    fill(page, "Push 1, radius", 60)
    fill(page, "Push 1, greatest force", 900)
    page.get_by_label("Balance of those who stand").select_option(label="Pendulum")
    # White, as no colour of this scale is.
    page.get_by_label("Colour").select_option(label="Speed")
    play_until(page, EARLY / 100)
    scrub(page, EARLY)
    table = tmp_path / "run.csv"
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", EARLY / 100, "-o", table)
    now = [{name: float(value) for name, value in row.items()} for row in rows(table) if round(100 * float(row["t"])) == EARLY]
    assert len(now) == 12 and max(math.hypot(row["x"] - row["legs_x"], row["y"] - row["legs_y"]) for row in now) > 0.15

    def light(row: dict[str, float], aside: float) -> int:
        x, y = row["legs_x"] - aside * math.sin(row["theta"]), row["legs_y"] + aside * math.cos(row["theta"])
        return min(painted(picture, picture.pixel(x, y)))

    # The line of who leans may be over one of two feet.
    wait(page, lambda: all(max(light(row, aside) for aside in (-0.09, 0.09)) > 170 for row in now), 20)


def test_trails_and_forces_are_drawn(page: Page) -> None:
    make(page, 40, 400, 400)
    page.get_by_label("Pace").select_option(label="2 ×")
    play_until(page, 1)
    # Frames that are still computed would stretch the scale.
    page.get_by_text("About this scale", exact=True).click()
    page.get_by_label("Fix this scale").check()
    page.get_by_text("About this scale", exact=True).click()
    scrub(page, 90)
    plain = pixels(page)
    note = page.get_by_text("The widest is")
    for layer in ("Trails", "Forces"):
        page.get_by_label(layer).check()
        wait(page, lambda: pixels(page) != plain, 20)
        expect(note).to_have_count(1 if layer == "Forces" else 0)
        page.get_by_label(layer).uncheck()
        wait(page, lambda: pixels(page) == plain, 20)
    # Where they begin nobody has left a trail.
    scrub(page, 0)
    start = pixels(page)
    page.get_by_label("Trails").check()
    page.get_by_role("button", name="Step", exact=True).click()
    wait(page, lambda: pixels(page) != start, 20)
    page.get_by_role("button", name="Step back").click()
    wait(page, lambda: pixels(page) == start, 20)


def test_the_pushed_are_seen_while_they_are_pushed(page: Page, tmp_path: Path) -> None:
    example(page, "A dense square", 180)
    picture = Picture(page)
    page.get_by_label("Colour").select_option(label="Speed")
    play_until(page, 0.6)
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", "0.5", "-o", tmp_path / "run.csv")
    scrub(page, 50)
    now = [{name: float(value) for name, value in row.items()} for row in rows(tmp_path / "run.csv") if float(row["t"]) == 0.5]
    # Within a circle, but not below its arrow.
    there = [row for row in now if math.hypot(row["x"] - 0.4, row["y"] - 2.5) < 0.6 and abs(row["y"] - 2.5) > 0.2]
    assert len(there) > 3

    def shown(row: dict[str, float]) -> bool:
        at = picture.pixel(row["x"] - 0.05 * math.cos(row["theta"]), row["y"] - 0.05 * math.sin(row["theta"]))
        # The circle takes away less than a tenth of a colour.
        return painted(picture, at) == pytest.approx(wanted(page, "Speed", math.hypot(row["vx"], row["vy"])), abs=36)

    wait(page, lambda: all(map(shown, there)), 20)


def test_obstacles_are_filled(page: Page) -> None:
    example(page, "Two exits", 60)
    picture = Picture(page)
    pillar, floor = (painted(picture, picture.pixel(*at)) for at in ((6.4, 3), (7.6, 5.8)))
    assert floor == [0, 0, 0] and pillar != floor


def test_an_area_has_the_density_of_the_table(page: Page, tmp_path: Path) -> None:
    make(page, 30, 400, 400)
    picture = Picture(page)
    show_at(page, 1)
    # Two clicks are corners of an area; a drag would be a line.
    page.get_by_role("button", name="Measure here").click()
    picture.click(3.5, 3)
    picture.click(1, 0.5)
    wait(page, lambda: plan(page)["area"] is not None)
    (x1, y1), (x2, y2) = plan(page)["area"]
    assert (x1, y1, x2, y2) == pytest.approx((3.5, 3, 1, 0.5), abs=0.03)
    trial = download(page, "Trial (zip)", tmp_path)
    lemons("run", trial, "--until", "1", "-o", tmp_path / "run.csv")
    inside = lambda row: x2 <= float(row["x"]) <= x1 and y2 <= float(row["y"]) <= y1
    there = [row for row in rows(tmp_path / "run.csv") if float(row["t"]) == 1 and inside(row)]
    size, squeeze = (x1 - x2) * (y1 - y2), sum(float(row["mean_normal_force"]) for row in there) / len(there)
    note = page.get_by_text(re.compile(r"people on .* m², their mean squeeze"))
    found = [float(number) for number in re.findall(r"[\d.]+(?= people| m²| N )", note.inner_text())]
    assert found == pytest.approx([len(there), size, squeeze], rel=6e-3)
    # Its corners as numbers; it goes with the scene.
    fill(page, "Area A, x", 390)
    becomes(page, lambda: plan(page)["area"][0][0], 3.9)
    page.get_by_role("button", name="Remove the line and the area").click()
    expect(page.get_by_role("option", name="In the area")).to_have_count(0)


def test_one_tool_draws_at_a_time(page: Page) -> None:
    make(page, 3, 400, 300)
    area, door = (page.get_by_role("button", name=name, exact=True) for name in ("Measure here", "Door"))
    for one, other in ((area, door), (door, area), (area, door)):
        one.click()
        expect(one).to_have_attribute("aria-pressed", "true")
        expect(other).to_have_attribute("aria-pressed", "false")


def test_who_is_dragged_is_pushed_slowly_and_the_timeline_ends_with_it(browser: Browser, url: str) -> None:
    page = browser.new_context(first=True, viewport={"width": 1440, "height": 900}).new_page()
    page.goto(url)
    page.get_by_text("Other questions, and your scenes").click()
    page.get_by_role("button", name="What does a push do in a packed crowd?").click()
    expect(page.get_by_text("180 people placed in")).to_be_visible()
    pace = page.get_by_label("Pace").locator("option:checked")
    wait(page, lambda: seconds(page) > 0.25)
    expect(pace).to_have_text("0.1 × by itself")
    # Until the wave is over, not 30 s.
    time = page.get_by_role("slider", name="Time")
    end = lambda: float(time.get_attribute("max") or 0)
    wait(page, lambda: 0.9 < end() / float(time.input_value()) * seconds(page) < 2.5)
    # From the middle of the stage, upwards: somebody else, as hard as before.
    box = page.locator("canvas").first.bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def over_somebody() -> bool:
        nonlocal x
        x += 3
        page.mouse.move(x, y)
        page.wait_for_timeout(50)
        return page.locator("canvas.over-person").count() == 1

    wait(page, over_somebody)
    page.mouse.down()
    page.mouse.move(x, y - 80, steps=4)
    page.mouse.up()
    wait(page, lambda: len(plan(page)["made"]["motion"]["pushes"]) == 1)
    (push,) = plan(page)["made"]["motion"]["pushes"]
    assert (push["force"], push["direction"]) == (600, 90)
    expect(page.get_by_role("button", name="Fit")).to_have_count(0)
    assert abs(push["at"][0] - 2.5) < 0.5 and abs(push["at"][1] - 2.5) < 0.5
    # What is seen is all, as before. A click is none, and pauses nothing; Undo brings the pushes back.
    page.mouse.click(x, y + 60)
    assert plan(page)["made"]["motion"]["pushes"] == [push]
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    # By itself it stops where the wave is over; the chart of rows says how hard.
    page.get_by_role("region", name="Charts").get_by_role("combobox").select_option("rows")
    wait(page, lambda: page.get_by_role("button", name="Play").count() == 1)
    assert float(time.input_value()) == end() and 0.9 < seconds(page) < 2.5
    said = page.get_by_role("img", name=re.compile("Squeeze by row")).get_attribute("aria-label") or ""
    most, now = (float(found) for found in re.findall(r"([\d.]+) N", said))
    assert most > 300 and now < most / 2
    page.get_by_role("button", name="Undo").click()
    wait(page, lambda: len(plan(page)["made"]["motion"]["pushes"]) == 3)
    page.context.close()
