"""Walls of an opened Trial, plans of other programs, and a picture under the room."""

import json
import math
import re
import struct
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from shapely import LineString, MultiLineString
from visit import ROOT, Picture, becomes, changed, download, fill, held, lemons, link, live, people, plan, tab, unpacked, wait

PLANS = ROOT / "examples/plans"
#: Of the wall around the row of people that is pushed.
LEFT, LOW, RIGHT, HIGH = -0.2, -0.57395, 1.752675, 0.54371


def corners(geometry: str) -> list[list[tuple[float, float]]]:
    """Of each wall, in m."""
    walls = ElementTree.fromstring(geometry).iter("Wall")
    place = lambda text: (float(text.split(",")[0]), float(text.split(",")[1]))
    return [[place(corner.attrib["Coordinates"]) for corner in wall] for wall in walls]


def png(width: int, height: int, rgb: tuple[int, int, int] = (255, 0, 0), rows: int | None = None) -> bytes:
    """Of one colour; its header may say more rows than there are."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    row = b"\0" + bytes(rgb) * width
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(row * (height if rows is None else rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def give(page: Page, name: str, content: bytes) -> None:
    """Opens a plan or a picture in the tab Room."""
    tab(page, "Room")
    field = page.get_by_label("Open a plan or a picture")
    field.set_input_files({"name": name, "mimeType": "application/octet-stream", "buffer": content})


def opened(page: Page, tmp_path: Path) -> dict[str, str]:
    """The push through a row, as a Trial of the visitor's own."""
    trial = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text(f'"{trial.name}": 5 people')).to_be_visible()
    return held(trial)


def edit(page: Page) -> Any:
    """The changed walls of the Trial; None if they are as they were."""
    edits = plan(page)["made"]["edits"]
    return edits[0]["room"] if edits else None


def test_the_walls_of_an_opened_trial_are_changed_with_the_mouse(page: Page, tmp_path: Path) -> None:
    before = opened(page, tmp_path)
    tab(page, "Room")
    expect(page.get_by_text("The walls are those of the Trial.")).to_be_visible()
    button = lambda name: page.get_by_role("button", name=name, exact=True)

    def around() -> Picture:
        """The stage with room around the walls."""
        for _ in range(3):
            button("Zoom out").click()
        return Picture(page)

    picture = around()
    # A click that changes nothing.
    picture.click(RIGHT, HIGH)
    assert edit(page) is None
    picture.drag((RIGHT, HIGH), (2.3, 0.93))
    becomes(page, lambda: (room := edit(page)) and room["walls"][0]["corners"][2], [2.3, 0.95])
    expect(page.get_by_text("The walls are changed.")).to_be_visible()
    moved = [(LEFT, LOW), (RIGHT, LOW), (2.3, 0.95), (LEFT, HIGH), (LEFT, LOW)]
    after = held(download(page, "Trial (zip)", tmp_path))
    assert corners(after["Geometry.xml"]) == [moved]
    # All others are the same text.
    assert {name: text for name, text in after.items() if name != "Geometry.xml"} == {name: text for name, text in before.items() if name != "Geometry.xml"}
    tab(page, "Room")
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(page.get_by_text("The walls are those of the Trial.")).to_be_visible()
    assert held(download(page, "Trial (zip)", tmp_path)) == before
    page.get_by_role("button", name="Redo", exact=True).click()
    becomes(page, lambda: (room := edit(page)) and room["walls"][0]["corners"][2], [2.3, 0.95])

    tab(page, "Room")
    picture = around()
    # The first corner of a closed wall is its last one. Keys move what is marked.
    picture.click(LEFT, LOW)
    page.keyboard.press("Shift+ArrowLeft")
    becomes(page, lambda: [edit(page)["walls"][0]["corners"][k] for k in (0, -1)], [[-0.25, LOW]] * 2)
    page.get_by_role("button", name="Undo", exact=True).click()
    becomes(page, lambda: edit(page)["walls"][0]["corners"][0], [LEFT, LOW])
    # A door of 0.8 m in the wall below, and a wall that begins at a corner.
    button("Door").click()
    picture.click(0.8, LOW + 0.01)
    becomes(page, lambda: [door["at"] for door in edit(page)["doors"]], [[0.8, -0.55]])
    fill(page, "Door 1, width", 80)
    button("Wall").click()
    picture.click(RIGHT + 0.02, LOW)
    picture.click(2.3, -0.4)
    page.keyboard.press("Enter")
    becomes(page, lambda: edit(page)["walls"][1:], [{"corners": [[RIGHT, LOW], [2.3, -0.4]], "of": None}])
    button("Obstacle").click()
    picture.drag((2.0, 0.1), (2.2, 0.3))
    becomes(page, lambda: len(edit(page)["walls"]), 3)
    ring, line, block = corners(held(download(page, "Trial (zip)", tmp_path))["Geometry.xml"])
    assert ring[0] == pytest.approx((1.2, LOW)) and ring[-1] == pytest.approx((0.4, LOW))
    assert ring[1:-1] == [(RIGHT, LOW), (2.3, 0.95), (LEFT, HIGH), (LEFT, LOW)]
    assert line == [(RIGHT, LOW), (2.3, -0.4)]
    assert block == [(2.0, 0.1), (2.2, 0.1), (2.2, 0.3), (2.0, 0.3), (2.0, 0.1)]
    # All of the obstacle goes.
    tab(page, "Room")
    picture = around()
    picture.click(2.2, 0.3)
    page.keyboard.press("Shift+Delete")
    becomes(page, lambda: len(edit(page)["walls"]), 2)
    # Also after a reload.
    page.reload()
    expect(page.get_by_text("The walls are changed.")).to_be_visible()
    button("Take the walls of the Trial again").click()
    expect(page.get_by_text("The walls are those of the Trial.")).to_be_visible()
    assert held(download(page, "Trial (zip)", tmp_path)) == before


def test_walls_that_are_only_seen_are_not_lost_by_a_stroke(page: Page, tmp_path: Path) -> None:
    files = opened(page, tmp_path)
    tools = page.get_by_role("group", name="Draw", exact=True)
    expect(tools.get_by_role("button", name="Wall", exact=True)).to_be_visible()
    element = re.search(r"<Wall .*?</Wall>", files["Geometry.xml"], re.DOTALL)
    assert element
    many = re.sub(r'Id="[^"]*"', 'Id="far {x}"', element[0], count=1)
    many = re.sub(r'Coordinates="([^,"]*),([^"]*)"', lambda at: f'Coordinates="{float(at[1])},{float(at[2]) + 90}"', many)
    walls = "".join(many.replace("{x}", str(k)) for k in range(500))
    trial = changed(download(page, "Trial (zip)", tmp_path), tmp_path / "many.zip", lambda text: text.replace(element[0], element[0] + walls))
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text('"many.zip": 5 people')).to_be_visible()
    for name in ("Wall", "Obstacle", "Door"):
        expect(tools.get_by_role("button", name=name, exact=True)).to_have_count(0)
    expect(tools.get_by_role("button", name="Push", exact=True)).to_be_visible()
    tab(page, "Room")
    expect(page.get_by_text("These walls can be seen, but not be changed here: there are 501")).to_be_visible()
    assert len(corners(held(download(page, "Trial (zip)", tmp_path))["Geometry.xml"])) == 501


def test_an_opened_trial_has_its_own_steps_whatever_was_changed_before(page: Page, url: str, tmp_path: Path) -> None:
    trial = download(page, "Trial (zip)", tmp_path)
    mechanics = {"time_step": 0.1, "time_step_mechanical": None, "materials": [], "contacts": []}
    made = {"base": {"kind": "example", "name": "push"}, "edits": [], "motion": {"kind": "own"}, "mechanics": mechanics}
    page.goto(link(url, {"name": "changed", "made": made}))
    becomes(page, lambda: plan(page)["made"].get("mechanics"), mechanics)
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text(f'"{trial.name}": 5 people')).to_be_visible()
    assert "mechanics" not in plan(page)["made"]
    assert held(download(page, "Trial (zip)", tmp_path)) == held(trial)


def test_who_is_in_a_wall_is_told_and_a_wall_on_an_exit_is_refused(page: Page, tmp_path: Path) -> None:
    tab(page, "Room")
    page.get_by_label("What is changed").select_option(label="The walls of this Trial")
    picture = Picture(page)
    page.get_by_role("button", name="Wall", exact=True).click()
    picture.click(0.6, -0.5)
    picture.click(0.6, 0.5)
    page.keyboard.press("Enter")
    notes = page.get_by_role("list", name="Notes")
    expect(notes).to_contain_text("disks and walls overlap at the start")
    people(page, 5)
    page.get_by_role("button", name="Undo", exact=True).click()
    becomes(page, lambda: edit(page), None)
    expect(notes).to_have_count(0)

    trial = tmp_path / "leaving.zip"
    lemons("crowd", "-n", 5, "--box", "5x4", "--door", "5,2,1", "--leave", "--zip", trial)
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text('"leaving.zip": 5 people')).to_be_visible()
    tab(page, "Room")
    picture = Picture(page)
    page.get_by_role("button", name="Wall", exact=True).click()
    picture.click(5, 1.5)
    picture.click(5, 2.5)
    page.keyboard.press("Enter")
    # Their way out is closed.
    expect(page.get_by_role("alert")).to_contain_text("no way leads to")
    becomes(page, lambda: edit(page), None)
    people(page, 5)


def test_plans_become_rooms_as_the_command_reads_them(page: Page, tmp_path: Path) -> None:
    understood = page.get_by_role("table", name="What was understood")

    def made(name: str, *options: str, door: list[tuple[float, float]] | None = None) -> dict[str, str]:
        """The Trial of the page, after its walls were compared with those of the command, in which the page cuts a door."""
        stem = name.split(".")[0]
        page.get_by_role("button", name="Make this room", exact=True).click()
        expect(page.get_by_text("people placed in")).to_be_visible()
        expect(page.get_by_role("textbox", name="Name of the scene")).to_have_value(stem)
        expect(understood).to_have_count(0)
        mine = held(download(page, "Trial (zip)", tmp_path))
        theirs = tmp_path / f"{stem}.xml"
        said = lemons("room", PLANS / name, *options, "-o", theirs)
        walls = [MultiLineString(corners(text)) for text in (mine["Geometry.xml"], theirs.read_text())]
        cut = LineString(door) if door else LineString()
        assert walls[1].difference(walls[0]).symmetric_difference(cut).length < 1e-9, said
        assert walls[0].difference(walls[1]).length < 1e-9 and walls[0].length > 10, said
        return mine

    # Exits before closed walls are told, and the preview has a line for each.
    inner = (PLANS / "hall.dxf").read_bytes()
    for old, new in ((b"15250.0", b"12250.0"), (b"16250.0", b"13250.0")):
        inner = inner.replace(old, new)
    give(page, "inner.dxf", inner)
    expect(understood.get_by_role("row", name=re.compile('^warning exit "north" lies inside closed walls'))).to_be_visible()
    expect(understood.get_by_role("row", name="warning")).to_have_count(1)
    expect(page.locator(".plan .way-out")).to_have_attribute("d", re.compile("^M[^M]*ZM[^M]*$"))

    give(page, "hall.dxf", (PLANS / "hall.dxf").read_bytes())
    expect(understood.get_by_role("row", name="warning")).to_have_count(0)
    for line in lemons("room", PLANS / "hall.dxf").splitlines():
        what, how = line[:18].strip(), line[19:].removesuffix(": lemons crowd cuts it")
        if what not in ("drawing", "nothing was writte"):
            expect(understood.get_by_role("row", name=f"{what} {how}", exact=True).first).to_be_visible()
    decision = made("hall.dxf", door=[(14, 3), (16, 3)])["decision.toml"]
    assert plan(page)["drawn"] == "hall.dxf"
    assert "north" in decision and "south" in decision and plan(page)["crowd"]["region"] is not None

    give(page, "office.dxf", (PLANS / "office.dxf").read_bytes())
    expect(page.get_by_role("alert")).to_contain_text("it does not say what its unit is")
    expect(page.get_by_role("alert")).to_contain_text("mm: 9.00 m x 8.00 m")
    page.get_by_label("Unit of the plan").select_option(label="mm")
    expect(understood).to_contain_text("2, of at most 10 cm, between ends of lines")
    fill(page, "Close gaps up to", 5)
    expect(understood).to_contain_text("2, the largest 30.0 mm")
    page.get_by_label("Lower left corner at 0, 0").check()
    made("office.dxf", "--unit", "mm", "--close", "5cm", "--origin")
    assert len(plan(page)["crowd"]["room"]["walls"]) == 1

    give(page, "platform.svg", (PLANS / "platform.svg").read_bytes())
    page.get_by_label("Unit of the plan").select_option(label="cm")
    expect(page.get_by_role("button", name="Lay it under the room as a picture")).to_be_visible()
    made("platform.svg", "--scale", "0.01", door=[(2, 7), (2, 9)])


def test_a_new_room_is_empty_but_for_one(page: Page) -> None:
    page.get_by_role("button", name="New empty room").click()
    expect(page.get_by_text("1 person placed in")).to_be_visible()
    expect(page.get_by_role("textbox", name="Name of the scene")).to_have_value("A new room")
    expect(page.get_by_role("spinbutton", name="Room width")).to_have_value("1000")
    assert plan(page)["crowd"]["room"]["doors"] == [] and plan(page)["drawn"] is None


def test_people_leave_a_dropped_plan_by_its_exit(page: Page, tmp_path: Path) -> None:
    outline = [[0, 0], [6, 0], [6, 5], [0, 5], [0, 0]]
    feature = lambda layer, kind, places: {"type": "Feature", "properties": {"layer": layer}, "geometry": {"type": kind, "coordinates": places}}
    features = [feature("walkablearea", "Polygon", [outline]), feature("exits-street", "LineString", [[6, 2], [6, 3]])]
    text = json.dumps({"type": "FeatureCollection", "features": features})
    script = "text => { const data = new DataTransfer(); data.items.add(new File([text], 'room.json')); return data; }"
    page.dispatch_event("canvas", "drop", {"dataTransfer": page.evaluate_handle(script, text)})
    understood = page.get_by_role("table", name="What was understood")
    expect(understood).to_contain_text('1 m wide where exit "street" lies on a closed wall')
    page.get_by_role("button", name="Make this room", exact=True).click()
    expect(page.get_by_text("30 people placed in")).to_be_visible()
    kept = plan(page)
    assert kept["crowd"]["room"]["doors"] == [{"at": [6, 2.5], "width": 1}]
    (street,) = kept["made"]["motion"]["decision"]["exits"]
    # 1 m behind the door, and 2 m longer.
    assert (street["name"], sorted(street["line"])) == ("street", [[7, 1], [7, 4]])
    page.get_by_role("button", name="Play").click()
    # What is computed ahead may have told already when all had.
    wait(page, lambda: page.get_by_text(re.compile(r"\b[1-9]\d* of 30 have left|All 30 have left after")).count() > 0)
    # The exit goes along with its door, as with a room that was drawn.
    tab(page, "Room")
    fill(page, "Door 1, width", 140)
    becomes(page, lambda: sorted(plan(page)["made"]["motion"]["decision"]["exits"][0]["line"]), [[7, 0.8], [7, 4.2]])


def test_layers_are_chosen_and_exits_left_out(page: Page) -> None:
    tab(page, "Room")
    square = lambda layer, size: f'<g id="{layer}"><path d="M 0 0 H {size} V {size} H 0 Z"/></g>'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{square("paper", 9)}{square("A-WALL", 6)}<path id="exits-a" d="M 7 1 V 5"/></svg>'
    give(page, "two.svg", text.encode())
    page.get_by_label("Unit of the plan").select_option(label="m")
    understood = page.get_by_role("table", name="What was understood")
    expect(understood).to_contain_text("9.000 m x 9.000 m")
    page.get_by_label("paper").uncheck()
    expect(understood).to_contain_text("6.000 m x 6.000 m")
    expect(understood).to_contain_text("(layer not asked for)")
    page.get_by_label("Take its exits (1)").uncheck()
    page.get_by_role("button", name="Make this room", exact=True).click()
    expect(page.get_by_text("36 people placed in")).to_be_visible()
    kept = plan(page)
    assert kept["made"]["motion"] == {"kind": "none"}
    assert kept["crowd"]["room"] == {"outline": [[0, 9], [6, 9], [6, 3], [0, 3]], "obstacles": [], "doors": []}


def architects_plan(thickness: float) -> bytes:
    """A room of 10 m by 8 m whose walls are two lines, with a gap of 1 m at (10, 4) and a swing in it, and a table of 2 m².
    Without a thickness, walls are single lines without a swing."""
    t = thickness
    inner = [[10, 4.5], [10, 8], [0, 8], [0, 0], [10, 0], [10, 3.5]]
    outer = [[10 + t, 3.5], [10 + t, -t], [-t, -t], [-t, 8 + t], [10 + t, 8 + t], [10 + t, 4.5]]
    walls = [[*inner, *outer, inner[0]]] if t else [inner]
    arc = [[10 + t + math.sin(k * math.pi / 12), 3.5 + math.cos(k * math.pi / 12)] for k in range(7)]
    swing = [("Türen", arc), ("Türen", [[10 + t, 3.5], [11 + t, 3.5]])] if t else []
    lines = [("Wände", line) for line in walls] + swing
    lines += [("Möbel", [[3, 3], [5, 3], [5, 4], [3, 4], [3, 3]]), ("Achsen", [[5, -3], [5, 11]])]
    feature = lambda layer, places: {"type": "Feature", "properties": {"layer": layer}, "geometry": {"type": "LineString", "coordinates": places}}
    return json.dumps({"type": "FeatureCollection", "features": [feature(*line) for line in lines]}).encode()


@pytest.mark.parametrize("thickness", [0.24, 0.0])
def test_where_the_outline_is_in_doubt_the_page_asks(page: Page, thickness: float) -> None:
    before = plan(page)["crowd"]
    make = page.get_by_role("button", name="Make this room", exact=True)
    understood = page.get_by_role("table", name="What was understood")
    give(page, "plan.geojson", architects_plan(thickness))
    expect(page.get_by_role("group", name="Proposals")).to_contain_text("the outline, wall")
    expect(make).to_be_disabled()
    expect(page.get_by_label('Layer "Wände"')).to_have_value("walls")
    expect(page.get_by_label('Layer "Möbel"')).to_have_value("obstacles")
    expect(page.get_by_label('Layer "Achsen"')).to_have_value("")
    door = page.get_by_role("checkbox", name="door: 1 m wide at 10,4,")
    expect(door).to_be_checked()
    assert plan(page)["crowd"] == before
    # What is left is not taken.
    page.get_by_label('Layer "Möbel"').select_option("")
    page.get_by_role("button", name="Take what is chosen").click()
    expect(understood).to_contain_text("80.000 m² within the outline")
    page.get_by_label('Layer "Möbel"').select_option("obstacles")
    page.get_by_role("button", name="Take what is chosen").click()
    expect(understood).to_contain_text("78.000 m² within the outline")
    door.uncheck()
    expect(page.get_by_text("Take its exits")).to_have_count(0)
    door.check()
    expect(page.get_by_text("Take its exits (1)")).to_be_visible()
    make.click()
    expect(page.get_by_text("people placed in")).to_be_visible()
    kept = plan(page)
    room, (way_out,) = kept["crowd"]["room"], kept["made"]["motion"]["decision"]["exits"]
    assert sorted(room["outline"]) == [[0, 0], [0, 8], [10, 0], [10, 8]] and len(room["obstacles"]) == 1
    assert room["doors"] == [{"at": [10, 4], "width": 1}] and {x for x, _ in way_out["line"]} == {11}


def test_a_plan_in_doubt_is_taken_as_it_is_drawn_if_somebody_says_so(page: Page) -> None:
    make = page.get_by_role("button", name="Make this room", exact=True)
    give(page, "plan.geojson", architects_plan(0.24))
    expect(make).to_be_disabled()
    page.get_by_role("button", name="Take it as it is drawn").click()
    expect(make).to_be_enabled()


def test_an_area_with_too_many_corners_is_refused_before_the_scene_is_opened(page: Page) -> None:
    name = page.get_by_role("textbox", name="Name of the scene")
    before = name.input_value()
    feature = lambda layer, places: {"type": "Feature", "properties": {"layer": layer}, "geometry": {"type": "Polygon", "coordinates": [places]}}
    ring = [[3 + 2 * math.cos(2 * math.pi * k / 240), 3 + 2 * math.sin(2 * math.pi * k / 240)] for k in [*range(240), 0]]
    plan_of = {"type": "FeatureCollection", "features": [feature("walkablearea", [[0, 0], [6, 0], [6, 6], [0, 6], [0, 0]]), feature("distributions-round", ring)]}
    give(page, "round.geojson", json.dumps(plan_of).encode())
    page.get_by_role("button", name="Make this room", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text('"round.geojson": this page takes up to 200 corners of the area where people stand')
    assert name.input_value() == before
    page.get_by_label("People stand where the plan says").uncheck()
    page.get_by_role("button", name="Make this room", exact=True).click()
    expect(page.get_by_text("people placed in")).to_be_visible()
    made = plan(page)["made"]
    page.reload()
    people(page, made["base"]["number"])
    assert plan(page)["made"] == made and name.input_value() == "round"


def test_options_of_a_plan_are_changed_together_and_its_panel_goes_with_its_scene(page: Page) -> None:
    understood = page.get_by_role("table", name="What was understood")
    give(page, "office.dxf", (PLANS / "office.dxf").read_bytes())
    unit, origin = page.get_by_label("Unit of the plan"), page.get_by_label("Lower left corner at 0, 0")
    expect(unit).to_be_visible()
    # Both before an answer comes.
    script = "([unit, origin]) => { unit.value = '0.001'; unit.dispatchEvent(new Event('change', { bubbles: true })); origin.click(); }"
    page.evaluate(script, [unit.element_handle(), origin.element_handle()])
    expect(understood).to_contain_text("2, of at most 10 cm, between ends of lines")
    expect(unit).to_have_value("0.001")
    expect(origin).to_be_checked()
    tab(page, "Start")
    page.get_by_role("button", name="A dense square").click()
    expect(page.get_by_text("people placed in")).to_be_visible()
    tab(page, "Room")
    expect(page.get_by_label("Open a plan or a picture")).to_be_visible()
    expect(unit).to_have_count(0)


def test_a_crowd_stands_on_both_sides_of_an_open_wall(page: Page, tmp_path: Path) -> None:
    tab(page, "Room")
    picture = Picture(page)
    page.get_by_role("button", name="Wall", exact=True).click()
    picture.click(2, 0)
    picture.click(2, 3)
    page.keyboard.press("Enter")
    wall = {"corners": [[2, 0], [2, 3]], "of": None}
    becomes(page, lambda: plan(page)["crowd"]["room"].get("walls"), [wall])
    page.get_by_role("button", name="Door", exact=True).click()
    picture.click(2.02, 1.5)
    becomes(page, lambda: plan(page)["crowd"]["room"]["doors"], [{"at": [2, 1.5], "width": 1}])
    page.get_by_role("button", name="Make this crowd").click()
    expect(page.get_by_text("40 people placed in")).to_be_visible()
    walls = corners(held(download(page, "Trial (zip)", tmp_path))["Geometry.xml"])
    assert sorted(walls[1:]) == [[(2, 0), (2, 1)], [(2, 2), (2, 3)]] and len(walls) == 3
    # By number, and away.
    tab(page, "Room")
    page.get_by_text("Wall 1", exact=False).first.click()
    fill(page, "Wall 1, corner 2, y", 250)
    becomes(page, lambda: plan(page)["crowd"]["room"]["walls"][0]["corners"][1], [2, 2.5])
    page.get_by_role("button", name="Delete wall 1", exact=True).click()
    becomes(page, lambda: "walls" in plan(page)["crowd"]["room"], False)


def colour(page: Page, at: tuple[float, float]) -> list[int]:
    """Of the stage, at a place of the canvas."""
    script = "([x, y]) => [...document.querySelector('canvas').getContext('2d').getImageData(x * devicePixelRatio, y * devicePixelRatio, 1, 1).data]"
    return page.evaluate(script, list(at))


def test_a_picture_lies_under_the_room(page: Page, url: str, tmp_path: Path) -> None:
    give(page, "floor.png", png(40, 20))
    expect(page.get_by_text('"floor.png" lies under the room. Set its scale.')).to_be_visible()
    backdrop = lambda: plan(page)["backdrop"]
    # As wide as the room of the forms at first, and as high as its pixels say.
    becomes(page, lambda: [backdrop()[key] for key in ("at", "width", "aspect", "opacity")], [[0, 0], 4, 0.5, 0.5])
    picture = Picture(page)
    place = picture.pixel(2, 1.9)

    def red() -> bool:
        red, green, _, alpha = colour(page, place)
        return red > green + 40 and alpha > 100

    wait(page, red)
    # What is 1 m long on it is 2.5 m in truth.
    page.get_by_role("button", name="Set the scale by a known length").click()
    picture.click(0, 0)
    picture.click(1, 0)
    fill(page, "Real length of the line", 250)
    becomes(page, lambda: round(backdrop()["width"], 1), 10.0)
    fill(page, "Width of the picture", 400)
    picture = Picture(page)
    page.get_by_role("button", name="Move it with the mouse").click()
    picture.drag((1, 1), (1.5, 0.5))
    becomes(page, lambda: [round(at, 1) for at in backdrop()["at"]], [0.5, -0.5])
    page.get_by_label("How much of it is seen").fill("0.2")
    becomes(page, lambda: backdrop()["opacity"], 0.2)
    # Kept with the scene and in no link.
    page.reload()
    expect(page.get_by_role("spinbutton", name="Width of the picture")).to_have_value("400")
    expect(page.get_by_text("This picture is not kept in this browser")).to_have_count(0)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.get_by_role("button", name="Copy link").click()
    expect(page.get_by_text('It does not hold "floor.png"')).to_be_visible()
    held_by_link = unpacked(page.evaluate("navigator.clipboard.readText()"))
    assert held_by_link["name"] and "floor.png" not in json.dumps(held_by_link)
    page.get_by_role("button", name="Remove the picture").click()
    becomes(page, backdrop, None)
    page.get_by_role("button", name="Undo", exact=True).click()
    becomes(page, lambda: backdrop()["opacity"], 0.2)
    # Walls are drawn over it, and it is no wall: it is seen on both sides of the room's, which is the only one.
    tab(page, "Crowd")
    live(page)
    expect(page.get_by_text("40 people placed in")).to_be_visible()
    trial = held(download(page, "Trial (zip)", tmp_path))
    assert [sorted(set(wall)) for wall in corners(trial["Geometry.xml"])] == [[(0, 0), (0, 4), (4, 0), (4, 4)]]
    picture = Picture(page)
    is_red = lambda y: colour(page, picture.pixel(2, y))[0] > 200
    wait(page, lambda: is_red(-0.2))
    across = [is_red(y / 100) for y in range(-20, 9)]
    # One line of a few pixels, where the wall is.
    assert across[0] and across[-1] and False in across[17:24] and across.count(False) < 10
    tab(page, "Room")
    page.goto(link(url, {"name": "elsewhere", "backdrop": {**backdrop(), "key": "unknown"}}))
    page.reload()
    expect(page.get_by_text("This picture is not kept in this browser")).to_be_visible()


def test_the_scale_of_a_picture_needs_two_ends_and_its_tools_end_with_the_tab(page: Page) -> None:
    give(page, "floor.png", png(40, 20))
    becomes(page, lambda: (plan(page)["backdrop"] or {}).get("width"), 4)
    before = plan(page)["backdrop"]
    picture = Picture(page)
    page.get_by_role("button", name="Set the scale by a known length").click()
    length = page.get_by_role("spinbutton", name="Real length of the line")
    picture.click(0, 0)
    picture.click(0, 0)
    expect(page.get_by_text("Click the other end of the line.")).to_be_visible()
    expect(length).to_have_count(0)
    # A double click at the other end begins no other line.
    picture.click(1, 0)
    picture.click(1, 0)
    expect(length).to_be_visible()
    fill(page, "Real length of the line", 999_900)
    expect(page.get_by_role("alert")).to_contain_text("m wide: 0.1 to 10000 m are allowed.")
    assert plan(page)["backdrop"] == before
    fill(page, "Real length of the line", 200)
    becomes(page, lambda: round(plan(page)["backdrop"]["width"], 1), 8.0)
    # Whoever comes back from another tab moves the view, not the picture.
    move = page.get_by_role("button", name="Move it with the mouse")
    move.click()
    tab(page, "Crowd")
    before = plan(page)["backdrop"]
    picture.drag((1, 1), (1.5, 0.5))
    tab(page, "Room")
    expect(move).to_have_attribute("aria-pressed", "false")
    assert plan(page)["backdrop"] == before


def test_what_the_browser_takes_back_is_not_said_to_be_kept(page: Page) -> None:
    # As where there is no room: all requests are done, and their transaction fails.
    script = '''() => {
        const put = IDBObjectStore.prototype.put;
        IDBObjectStore.prototype.put = function (...given) {
            const request = put.apply(this, given);
            request.addEventListener("success", () => this.transaction.abort());
            return request;
        };
    }'''
    page.evaluate(script)
    give(page, "floor.png", png(40, 20))
    expect(page.get_by_text("This browser's storage has no room for it")).to_be_visible()


def test_plans_and_pictures_that_are_none_are_refused(page: Page) -> None:
    tab(page, "Room")
    alert = page.get_by_role("alert")
    for name, content, words in [
        ("broken.dxf", b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nnorth\n", "broken.dxf: line"),
        ("empty.wkt", b"", "empty.wkt: "),
        ("none.geojson", b'{"type": "Feature"', "none.geojson: "),
        ("open.wkt", b"LINESTRING (0 0, 1 0, 1 1)", "none of its 1 walls is closed"),
    ]:
        give(page, name, content)
        expect(alert).to_contain_text(words)
        page.get_by_role("button", name="Leave it").click()
    for name, content, words in [
        ("text.png", b"no picture", '"text.png" is no picture that this browser can show'),
        ("huge.png", png(12_000, 9_000, rows=1), "pixels: at most 100 million are allowed"),
        ("scene.json", b'{"made": 5', '"scene.json'),
    ]:
        give(page, name, content)
        expect(alert).to_contain_text(words) if name != "scene.json" else expect(alert).to_be_visible()
        page.get_by_role("button", name="Close this message").click()
    # 100 MB are not even read.
    files = page.evaluate_handle("() => { const data = new DataTransfer(); data.items.add(new File([new Uint8Array(100e6)], 'large.jpg')); return data; }")
    page.dispatch_event("canvas", "drop", {"dataTransfer": files})
    expect(alert).to_contain_text('"large.jpg" has more than 20 MB')
    assert plan(page)["backdrop"] is None


def test_a_picture_runs_nothing_and_asks_nobody(page: Page) -> None:
    tab(page, "Room")
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    text = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="40" height="20" onload="window.top.harm = 1">
        <script>window.top.harm = 1; fetch("http://127.0.0.1:9/harm")</script><image href="http://127.0.0.1:9/harm.png" width="9" height="9"/>
        <style>@import url("http://127.0.0.1:9/harm.css");</style><rect width="40" height="20" fill="red"/></svg>"""
    give(page, "harm.svg", text.encode())
    page.get_by_role("button", name="Lay it under the room as a picture").click()
    becomes(page, lambda: (plan(page)["backdrop"] or {}).get("aspect"), 0.5)
    picture = Picture(page)
    wait(page, lambda: colour(page, picture.pixel(2, 1.9))[0] > colour(page, picture.pixel(2, 1.9))[1] + 40)
    assert page.evaluate("window.harm") is None
    assert not [url for url in asked if "harm" in url]
