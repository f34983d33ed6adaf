"""What is drawn on the picture with the mouse, as the files of the Trial and the command have it."""

import math
import re
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from shapely import LineString, MultiLineString, Point, Polygon
from visit import Picture, becomes, download, fill, held, lemons, live, make, places, plan, play_until, rows, same_table, tab, wait

OUTLINE = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.5), (2.5, 4.0), (0.5, 3.5)]
BLOCK = [(1.0, 1.0), (1.5, 1.0), (1.5, 1.8), (1.0, 1.8)]
WEDGE = [(2.2, 2.0), (2.8, 2.0), (2.5, 2.6)]
#: The gap of a door 1 m wide.
DOOR = LineString([(4, 0.5), (4, 1.5)])


def walls(trial: Path) -> MultiLineString:
    corners = [
        [tuple(map(float, corner.attrib["Coordinates"].split(","))) for corner in wall]
        for wall in ElementTree.fromstring(held(trial)["Geometry.xml"]).iter("Wall")
    ]
    return MultiLineString(corners)


def test_a_room_is_drawn_with_the_mouse(page: Page, tmp_path: Path) -> None:
    tab(page, "Room")
    picture = Picture(page)
    button = lambda name: page.get_by_role("button", name=name, exact=True)

    def room() -> list[Any]:
        of = plan(page)["crowd"]["room"]
        return [[tuple(corner) for corner in of["outline"]], [[tuple(at) for at in ring] for ring in of["obstacles"]], of["doors"]]

    button("Outline").click()
    drawn = [*OUTLINE[:4], (0.0, 4.0)]
    for corner in drawn:
        picture.click(*corner)
    # Esc ends it without a change; the first corner closes it.
    page.keyboard.press("Escape")
    becomes(page, lambda: len(room()[0]), 4)
    button("Outline").click()
    for corner in [*drawn, drawn[0]]:
        picture.click(*corner)
    becomes(page, room, [drawn, [], []])
    picture.drag(drawn[4], OUTLINE[4])
    becomes(page, room, [OUTLINE, [], []])
    button("Door").click()
    picture.click(4.03, 1.6)
    becomes(page, lambda: room()[2], [{"at": [4, 1.6], "width": 1}])
    # It stays on its wall.
    picture.drag((4, 1.6), (4.2, 1))
    becomes(page, lambda: room()[2], [{"at": [4, 1], "width": 1}])
    button("Obstacle").click()
    picture.drag(BLOCK[0], BLOCK[2])
    button("Any shape").click()
    for corner in WEDGE[:2]:
        picture.click(*corner)

    def closed() -> bool:
        """If the machine is too slow for a double click, these are two corners: the key takes them back."""
        picture.click(*WEDGE[2])
        picture.click(*WEDGE[2])
        if len(plan(page)["crowd"]["room"]["obstacles"]) == 2:
            return True
        page.keyboard.press("Backspace")
        page.keyboard.press("Backspace")
        # The next click is not the second of these.
        page.wait_for_timeout(400)
        return False

    wait(page, closed)
    becomes(page, lambda: room()[:2], [OUTLINE, [BLOCK, WEDGE]])

    tab(page, "Crowd")
    fill(page, "People", 15)
    live(page)
    expect(page.get_by_text("15 people placed in")).to_be_visible()
    play_until(page, 0.5)
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    outline, *obstacles = map(Polygon, (OUTLINE, BLOCK, WEDGE))
    wanted = outline.exterior.difference(DOOR).union(obstacles[0].exterior).union(obstacles[1].exterior)
    assert walls(trial).symmetric_difference(wanted).length < 1e-9
    for x, y, _ in places(trial).values():
        at = Point(x, y)
        assert outline.contains(at) and not any(obstacle.contains(at) for obstacle in obstacles)
    assert "overlap" not in lemons("check", trial)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "0.5", "-o", table)
    same_table(shown, table)


def test_a_push_is_drawn_with_the_mouse(page: Page, tmp_path: Path) -> None:
    make(page, 12, 300, 300)
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="Some are pushed")
    picture = Picture(page)
    page.get_by_role("button", name="Push", exact=True).click()
    picture.drag((1.2, 1.5), (2.2, 1.5))

    def push() -> list[float]:
        pushes = plan(page)["made"]["motion"].get("pushes", [])
        return [number for push in pushes for number in (*push["at"], push["radius"], push["direction"], push["force"])]

    # 1 m of the arrow is 500 N; a pixel is about 4 N, and half a degree.
    turned = lambda degrees: pytest.approx(degrees, abs=2)
    newtons = lambda force: pytest.approx(force, abs=10)
    becomes(page, push, [1.2, 1.5, 0.5, turned(0), newtons(500)])
    picture.drag((1.2, 2), (1.2, 2.4))
    wide = pytest.approx(0.9, abs=0.03)
    becomes(page, push, [1.2, 1.5, wide, turned(0), newtons(500)])
    picture.drag((1.2, 1.5), (1, 1))
    becomes(page, push, [1, 1, wide, turned(0), newtons(500)])
    picture.drag((1 + push()[4] / 500, 1), (1, 2.2))
    becomes(page, push, [1, 1, wide, turned(90), newtons(600)])
    x, y, radius, direction, force = push()
    expect(page.get_by_role("spinbutton", name="Push 1, greatest force")).to_have_value(str(force))

    trial = download(page, "Trial (zip)", tmp_path)
    (tmp_path / "drive.csv").write_text(held(trial)["drive.csv"])
    drive = rows(tmp_path / "drive.csv")
    near = {name for name, pose in places(trial).items() if math.dist(pose[:2], (x, y)) <= radius}
    assert {row["agent"] for row in drive} == near and 1 < len(near) < 12
    # Besides their own drive: half a sine, from 0.2 s to 0.5 s.
    own = {
        agent.attrib["Id"]: float(dynamics.attrib["Fp"].split(",")[0])
        for agent in ElementTree.fromstring(held(trial)["AgentDynamics.xml"])
        for dynamics in agent.iter("Dynamics")
    }
    turn = math.radians(direction)
    for row in drive:
        time = float(row["t"])
        size = force * math.sin(math.pi * (time - 0.2) / 0.3) if 0.2 < time < 0.5 else 0
        assert float(row["Fp.x"]) == pytest.approx(own[row["agent"]] + size * math.cos(turn), abs=1e-6)
        assert float(row["Fp.y"]) == pytest.approx(size * math.sin(turn), abs=1e-6)
    assert max(float(row["Fp.y"]) for row in drive) == pytest.approx(force * math.sin(turn), rel=0.01)


def test_a_way_is_drawn_with_the_mouse(page: Page, tmp_path: Path) -> None:
    make(page, 5, 400, 400)
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="All walk along ways")
    picture = Picture(page)
    ways = lambda: [[(point["x"], point["y"]) for point in way] for way in plan(page)["made"]["motion"].get("ways", [])]
    page.get_by_role("button", name="Way", exact=True).click()
    for at in ((1, 1), (2, 1.5), (3.5, 3.5), (0.5, 0.5)):
        picture.click(*at)
    page.keyboard.press("Backspace")
    page.keyboard.press("Enter")
    becomes(page, ways, [[(1, 1), (2, 1.5), (3.5, 3.5)]])
    picture.drag((2, 1.5), (3, 0.5))
    page.get_by_role("button", name="Way", exact=True).click()
    for at in ((1, 3), (2.5, 3)):
        picture.click(*at)
    page.keyboard.press("Enter")
    first, second = [(1, 1), (3, 0.5), (3.5, 3.5)], [(1, 3), (2.5, 3)]
    becomes(page, ways, [first, second])

    expect(page.get_by_role("row", name="Arrived or left")).to_contain_text("of 5")
    trial = download(page, "Trial (zip)", tmp_path)
    decision = tomllib.loads(held(trial)["decision.toml"])
    whole = lambda way: [{"x": x, "y": y, "radius": 0.5} for x, y in way]
    assert decision["desired_speed"] == 1.3
    # Everybody takes the way whose first point is nearest.
    for name, pose in places(trial).items():
        nearest = min((first, second), key=lambda way: math.dist(way[0], pose[:2]))
        assert decision.get("agents", {}).get(name, decision)["waypoints"] == whole(nearest), name
    lemons("check", trial)
    outputs = ("-o", tmp_path / "run.csv", "--outputs", tmp_path / "decision.csv")
    assert lemons("run", trial, "--until", "0.1", *outputs).startswith("people walk ")
    # Ways with shares; a way that is taken away takes its share with it.
    tab(page, "Motion")
    page.get_by_label("Each way gets a share of the people").check()
    fill(page, "Way 1, share", 3)
    fill(page, "Way 2, share", 7)
    fill(page, "Seed", 5)
    decision = tomllib.loads(held(download(page, "Trial (zip)", tmp_path / "shared"))["decision.toml"])
    assert decision["ways"] == [{"waypoints": whole(first), "share": 3}, {"waypoints": whole(second), "share": 7}] and decision["seed"] == 5
    tab(page, "Motion")
    page.get_by_role("button", name="Delete way 1", exact=True).click()
    becomes(page, lambda: plan(page)["made"]["motion"].get("shares"), [7])


def test_a_person_is_turned_copied_and_deleted_by_hand(page: Page, tmp_path: Path) -> None:
    make(page, 3, 400, 400)
    first = places(download(page, "Trial (zip)", tmp_path))
    tab(page, "Crowd")
    picture = Picture(page)
    person = page.get_by_role("combobox", name="Person")
    value = lambda name: float(page.get_by_role("spinbutton", name=f"Person, {name}").input_value())
    people = lambda count: expect(page.get_by_role("row", name=f"People {count}")).to_be_visible()
    warning = page.get_by_text("overlap, by up to")
    person.select_option(label="1")
    fill(page, "Person, x", 200)
    fill(page, "Person, y", 200)
    fill(page, "Person, faces", 0)
    # The handle is half a metre before the person. Shift turns by steps of 15 degrees.
    picture.drag((2.5, 2), (2.05, 2.6))
    becomes(page, lambda: value("faces"), pytest.approx(85, abs=3))
    page.keyboard.down("Shift")
    turn = math.radians(value("faces"))
    picture.drag((2 + 0.5 * math.cos(turn), 2 + 0.5 * math.sin(turn)), (1.45, 2.65))
    page.keyboard.up("Shift")
    becomes(page, lambda: value("faces"), 135)

    page.get_by_role("button", name="Copy person").click()
    people(4)
    expect(person.locator("option:checked")).to_have_text("3")
    at = 2 + 0.6 * math.sin(math.radians(135)), 2 - 0.6 * math.cos(math.radians(135))
    becomes(page, lambda: [value(name) for name in ("x", "y", "faces")], pytest.approx([100 * at[0], 100 * at[1], 135], abs=0.1))
    # The keys are the picture's. 5 cm at a time, it comes near to whom it was copied from.
    picture.canvas.focus()
    for key in ("ArrowLeft", "ArrowDown"):
        for _ in range(5):
            page.keyboard.press(f"Shift+{key}")
    expect(page.get_by_role("row", name="Place x 217.4 cm, y 217.4 cm")).to_be_visible()
    trial = download(page, "Trial (zip)", tmp_path)
    found = places(trial)
    assert found.keys() == {"0", "1", "2", "3"}
    assert found["3"] == pytest.approx((at[0] - 0.25, at[1] - 0.25, math.radians(135)), abs=1e-3)
    assert found["1"] == pytest.approx((2, 2, math.radians(135)), abs=1e-3)
    # The command finds the same two, and the same depth.
    deepest = re.search(r'the deepest by (.*) mm \(agents "1" and "3"\)', lemons("check", trial))
    assert deepest
    expect(warning).to_have_text(f"At the start 2 people overlap, by up to {float(deepest[1]):.0f} mm. They are hatched.")

    tab(page, "Crowd")
    picture.canvas.focus()
    page.keyboard.press("Delete")
    people(3)
    expect(warning).to_have_count(0)
    assert found.keys() - places(download(page, "Trial (zip)", tmp_path)).keys() == {"3"}
    page.keyboard.press("Control+z")
    people(4)
    assert places(download(page, "Trial (zip)", tmp_path)) == found
    tab(page, "Crowd")
    page.get_by_role("button", name="Take all back").click()
    people(3)
    assert places(download(page, "Trial (zip)", tmp_path)) == first
