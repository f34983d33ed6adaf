"""Kinds of people: the mix of the page is that of `lemons crowd --mix`; shares, links, colours, numbers, three dimensions."""

import io
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Locator, Page, expect
from test_languages import english, visit
from visit import ROOT, Picture, becomes, changed, download, fill, held, lemons, link, live, make, places, plan, rows, shot, tab, wait

FIRST = {"adult": 70, "child": 15, "elderly": 10, "wheelchair": 5}
#: Names on the page.
KINDS = re.findall(r'^ +\S+: "(.*)",$', (ROOT / "lab/src/kindwords.ts").read_text(), re.MULTILINE)


def mixed(page: Page, number: int = 40, width: float = 800, height: float = 600) -> None:
    """A crowd in a room, sizes in cm, of the kinds that the page begins with."""
    make(page, number, width, height)
    page.get_by_label("Children, elderly, luggage, wheelchairs").check()
    live(page)


def share(page: Page, kind: str, percent: float) -> None:
    field = page.get_by_role("spinbutton", name=f"{kind}, %", exact=True)
    field.fill(str(percent))
    field.press("Tab")


def shares(page: Page) -> dict[str, float]:
    return {kind: float(page.get_by_role("spinbutton", name=f"{kind}, %", exact=True).input_value()) for kind in KINDS}


def options(mix: dict[str, float]) -> list[str]:
    return ["--mix", ",".join(f"{kind}={part}" for kind, part in mix.items())]


def test_the_mix_of_the_page_is_that_of_the_command(page: Page, tmp_path: Path) -> None:
    mixed(page)
    becomes(page, lambda: plan(page)["made"]["base"]["mix"], FIRST)
    share(page, "With a suitcase", 20)
    live(page)
    mix = plan(page)["made"]["base"]["mix"]
    assert sum(mix.values()) == 100 and mix["suitcase"] == 20
    trial, people = download(page, "Trial (zip)", tmp_path), download(page, "People (CSV)", tmp_path)
    theirs, table = tmp_path / "theirs.zip", tmp_path / "theirs.csv"
    crowd = ["--number", 40, "--box", "8x6", "--seed", 1, "--direction", 0, *options(mix)]
    lemons("crowd", *crowd, "--speed", 1, "--zip", theirs, "--population", table)
    for name in ("Agents.xml", "Geometry.xml", "AgentDynamics.xml", "Materials.xml", "Parameters.xml"):
        assert held(trial)[name] == held(theirs)[name], name
    assert people.read_text() == table.read_text() and "desired_speed_m_per_s" in table.read_text()
    # They leave at the speeds of their kinds, as the command says it, and the run is the same.
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="All walk to exits and goals")
    page.get_by_role("button", name="Add an exit by numbers").click()
    wait(page, lambda: plan(page)["made"]["motion"]["kind"] == "go")
    expect(page.get_by_text("People of kinds have the desired speed of their kind")).to_be_visible()
    # The scene with the exit is there.
    expect(page.get_by_role("row", name="Have left 0 of 40")).to_be_visible()
    decision = tomllib.loads(held(download(page, "Trial (zip)", tmp_path))["decision.toml"])
    lemons("crowd", *crowd, "--door", "8,3,1", "--leave", "--zip", theirs, "--force")
    wanted = tomllib.loads(held(theirs)["decision.toml"])["agents"]
    assert len(wanted) == 40 and {id: own["desired_speed"] for id, own in decision["agents"].items()} == {id: own["desired_speed"] for id, own in wanted.items()}


def test_shares_stay_at_a_hundred_and_kinds_have_pictures(page: Page) -> None:
    mixed(page)
    expect(page.locator(".share svg circle").first).to_be_visible()
    assert all(picture.locator("circle").count() >= 10 for picture in page.locator(".share svg").all())
    assert {kind: part for kind, part in shares(page).items() if part} == {"Adult": 70, "Child": 15, "Elderly": 10, "Wheelchair": 5}
    share(page, "Wheelchair", 24)
    # The others keep their proportions: 76 % of 95 are 0.8 of each.
    becomes(page, lambda: {kind: part for kind, part in shares(page).items() if part}, {"Adult": 56, "Child": 12, "Elderly": 8, "Wheelchair": 24})
    page.get_by_role("slider", name="With a stroller, share").fill("33")
    becomes(page, lambda: sum(shares(page).values()), 100)
    assert shares(page)["With a stroller"] == 33
    for _ in range(3):
        page.get_by_role("slider", name="Child, share", exact=True).fill("7")
        page.get_by_role("slider", name="Adult, share", exact=True).fill("51")
        becomes(page, lambda: (sum(shares(page).values()), shares(page)["Adult"]), (100, 51))
    share(page, "Child", 100)
    becomes(page, lambda: plan(page)["crowd"]["mix"], {"child": 100})
    share(page, "Child", 40)
    becomes(page, lambda: plan(page)["crowd"]["mix"], {"adult": 60, "child": 40})
    # Round bodies are of adults with nothing.
    expect(page.get_by_label("Round bodies")).to_have_count(0)
    page.get_by_label("Children, elderly, luggage, wheelchairs").uncheck()
    becomes(page, lambda: plan(page)["crowd"]["mix"], {})
    expect(page.get_by_label("Round bodies")).to_be_visible()


def test_too_many_wheelchairs_and_kinds_that_are_none_are_named(page: Page, url: str) -> None:
    mixed(page, 40, 400, 400)
    share(page, "Wheelchair", 100)
    alert = page.get_by_role("alert").filter(has_text="do not fit")
    expect(alert).to_contain_text(re.compile(r"40 people do not fit on 16\.00 m² without overlap; about (1\d|2\d) of them do"))
    # The people who could be placed stay.
    expect(page.get_by_text("The picture shows the people as they could be placed last")).to_be_visible()
    count = int(alert.inner_text().split("about ")[1].split()[0])
    fill(page, "People", count - 2)
    live(page)
    # What a link says may have any sum; kinds that there are not are named, and do no harm.
    kept = plan(page)
    kept["made"]["base"]["mix"] = {"adult": 3, "child": 1}
    kept["crowd"]["mix"] = {"adult": 3, "child": 1}
    page.goto("about:blank")
    page.goto(link(url, kept))
    tab(page, "Crowd")
    becomes(page, lambda: (shares(page)["Adult"], shares(page)["Child"]), (75, 25))
    for mix, said in (({"adult": 3, "elephant": 1}, 'there is no kind "elephant"'), ({"adult": 0}, "more than 0")):
        kept["made"]["base"]["mix"] = kept["crowd"]["mix"] = mix
        page.goto("about:blank")
        page.goto(link(url, kept))
        expect(page.get_by_role("alert")).to_contain_text(said)
    for mix in ({"adult": -1}, {"adult": "many"}, [1], "adult"):
        kept["made"]["base"]["mix"] = mix
        page.goto("about:blank")
        page.goto(link(url, kept))
        expect(page.get_by_text("Left out: the scene")).to_be_visible()
    page.wait_for_selector("canvas")


def test_kinds_have_colours_and_the_inspector_says_what_goes_along(page: Page, tmp_path: Path) -> None:
    mixed(page)
    page.get_by_role("combobox", name="Colour").select_option(label="Kind")
    people = rows(download(page, "People (CSV)", tmp_path))
    trial = download(page, "Trial (zip)", tmp_path)
    legend = page.locator(".legend")
    for kind, name in (("adult", "Adult"), ("child", "Child"), ("wheelchair", "Wheelchair")):
        count = sum(row["type"] == kind for row in people)
        expect(legend.get_by_role("listitem").filter(has_text=re.compile(rf"^{name} \({count}\)$"))).to_be_visible()
    expect(legend.get_by_text("Frames")).to_be_visible()
    assert "40 agents" in lemons("check", trial)
    # On the picture each has the colour of the legend: a wheelchair is grey, and who sits there is coloured.
    swatch = lambda name: hexadecimal(legend.get_by_role("listitem").filter(has_text=re.compile(rf"^{name}( \(|$)")).locator(".swatch"))
    grey_of_frames = swatch("Frames")
    colours = {kind: swatch(name) for kind, name in (("adult", "Adult"), ("child", "Child"), ("elderly", "Elderly"), ("wheelchair", "Wheelchair"))}
    assert len({*colours.values(), grey_of_frames}) == 5
    picture, poses = Picture(page), places(trial)
    for row in people:
        seen = around(page, picture, poses[row["id"]][:2], 0.4 if row["type"] == "wheelchair" else 0.1)
        assert seen.count(colours[row["type"]]) > len(seen) / 20, row
        assert (seen.count(grey_of_frames) > len(seen) / 50) == (row["type"] == "wheelchair"), row
    chair = next(row for row in people if row["type"] == "wheelchair")
    page.get_by_role("combobox", name="Person", exact=True).select_option(label=chair["id"])
    numbers = page.get_by_role("region", name="Numbers")
    for row in ("Kind Wheelchair", "With wheelchair (frame)", f"Mass {float(chair['mass_of_all_kg']):.3g} kg", f"Mass of the person {float(chair['mass_kg']):.3g} kg", f"Desired speed {float(chair['desired_speed_m_per_s']):.2f} m/s"):
        expect(numbers.get_by_role("row", name=row, exact=True)).to_be_visible()
    # The picture as a file has the same legend.
    svg = download(page, "Picture (SVG)", tmp_path).read_text()
    assert all(f'aria-label="{kind}"' in svg for kind in ("adult", "child", "elderly", "wheelchair"))
    # Colours of kinds are kept with the scene; where there are none, people have the usual colours.
    page.reload()
    expect(page.get_by_role("combobox", name="Colour")).to_have_value("kind")
    tab(page, "Crowd")
    page.get_by_label("Children, elderly, luggage, wheelchairs").uncheck()
    live(page)
    expect(page.get_by_role("combobox", name="Colour")).to_have_value("squeeze")


def hexadecimal(swatch: Locator) -> str:
    red, green, blue = re.findall(r"\d+", swatch.evaluate("swatch => getComputedStyle(swatch).backgroundColor"))
    return f"{int(red):02x}{int(green):02x}{int(blue):02x}"


def around(page: Page, picture: Picture, at: tuple[float, float], reach: float) -> list[str]:
    """Colours of the stage in a square around a place."""
    (left, low), (right, high) = picture.pixel(at[0] - reach, at[1] - reach), picture.pixel(at[0] + reach, at[1] + reach)
    script = """([left, top, width, height]) => {
        const by = devicePixelRatio, canvas = document.querySelector('canvas');
        const { data } = canvas.getContext('2d').getImageData(left * by, top * by, width * by, height * by);
        const hex = k => [0, 1, 2].map(j => data[k + j].toString(16).padStart(2, '0')).join('');
        return Array.from({ length: data.length / 4 }, (_, k) => hex(4 * k));
    }"""
    seen: list[str] = page.evaluate(script, [left, high, right - left, low - high])
    return seen


def test_a_kind_comes_back_on_the_way_of_its_slider(page: Page) -> None:
    mixed(page)
    tab(page, "Start")
    becomes(page, lambda: plan(page)["made"]["base"]["mix"], FIRST)
    slider = lambda name: page.locator(".sliders").get_by_role("slider", name=re.compile(rf"^{name}:"))
    box = slider("Child").bounding_box()
    assert box
    # The middle of the handle does not reach the ends.
    at = lambda percent: (box["x"] + 8 + percent / 100 * (box["width"] - 16), box["y"] + box["height"] / 2)
    mix = lambda: plan(page)["crowd"]["mix"]
    page.mouse.move(*at(15))
    page.mouse.down()
    page.mouse.move(*at(150))
    becomes(page, mix, {"child": 100})
    expect(slider("Wheelchair")).to_be_visible()
    page.mouse.move(*at(-50))
    becomes(page, lambda: "child" in mix(), False)
    assert sum(mix().values()) == 100 and set(mix()) == {"adult", "elderly", "wheelchair"}
    page.mouse.move(*at(40))
    becomes(page, lambda: abs(mix().get("child", 0) - 40) <= 3, True)
    assert set(mix()) == set(FIRST)
    page.mouse.move(*at(-50))
    page.mouse.up()
    expect(slider("Child")).to_have_count(0)
    live(page)
    # All of it is one step of Undo, and what is changed next is another one.
    slider("Men").fill("20")
    becomes(page, lambda: plan(page)["crowd"]["men"], 0.2)
    live(page)
    page.get_by_role("button", name="Undo", exact=True).click()
    becomes(page, lambda: (plan(page)["crowd"]["men"], "child" in mix()), (0.5, False))
    page.get_by_role("button", name="Undo", exact=True).click()
    becomes(page, mix, FIRST)


def test_shares_of_a_link_are_percent_on_sliders_and_in_the_report(page: Page, url: str) -> None:
    mixed(page, 12)
    kept = plan(page)
    kept["made"]["base"]["mix"] = kept["crowd"]["mix"] = {"adult": 3, "child": 1}
    kept["made"]["motion"] = {"kind": "walk", "speed": 1.34, "ways": [[{"x": 7, "y": 3, "radius": 0.5}]]}
    page.goto("about:blank")
    page.goto(link(url, kept))
    tab(page, "Start")
    expect(page.locator(".sliders").get_by_text("Child: 25 %")).to_be_visible()
    page.get_by_role("button", name="Keep this run to compare").click()
    page.locator(".sliders").get_by_role("slider", name=re.compile("^Child:")).fill("50")
    live(page)
    expect(page.get_by_text("Kept: Adult: 75 %, Child: 25 %.")).to_be_visible()
    page.get_by_role("button", name="End the comparison").click()
    tab(page, "Take away")
    page.get_by_role("button", name="Report to print").click()
    report = page.get_by_role("main", name="Report")
    for row in ("Kinds Adult: 50 %, Child: 50 %", "They walk on 1 way, desired speeds by kind"):
        expect(report.get_by_role("row", name=row, exact=True)).to_be_visible()
    expect(report.get_by_role("row", name=re.compile("^Bodies disks by kind, human_naked"))).to_be_visible()


def grey(page: Page) -> float:
    """Share of pixels of the canvas that have the hue of frames, in any light."""
    red, green, blue = np.asarray(Image.open(io.BytesIO(shot(page.locator("canvas").first))).convert("RGB")).astype(float).transpose(2, 0, 1)
    like = (abs(red / np.maximum(blue, 1) - 125 / 148) < 0.05) & (abs(green / np.maximum(blue, 1) - 135 / 148) < 0.05) & (blue > 60) & (blue < 200)
    return float(like.mean())


def test_wheelchairs_are_there_in_three_dimensions_also_of_an_opened_trial(page: Page, tmp_path: Path) -> None:
    make(page, 12, 500, 500)
    tab(page, "Crowd")
    page.get_by_label("View").select_option(label="3D")
    page.wait_for_timeout(1500)
    before = grey(page)
    page.get_by_label("Children, elderly, luggage, wheelchairs").check()
    share(page, "Wheelchair", 50)
    live(page)
    wait(page, lambda: grey(page) > before + 0.005)
    mesh = download(page, "Bodies (OBJ)", tmp_path).read_text()
    assert "_wheelchair_0\n" in mesh and "_trunk\n" in mesh
    trial = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    page.set_input_files("input[type=file]", trial)
    page.wait_for_timeout(1000)
    wait(page, lambda: grey(page) > before + 0.005)


@pytest.mark.parametrize(("locale", "chair"), [("de-AT", "Rollstuhl"), ("fr-CA", "Fauteuil roulant")])
def test_kinds_have_names_in_the_language_of_the_page(browser, url: str, locale: str, chair: str) -> None:  # type: ignore[no-untyped-def]
    page = visit(browser, url, locale)
    page.locator("header nav button").nth(2).click()
    page.locator(".mix input[type=checkbox]").check()
    becomes(page, lambda: plan(page)["made"]["base"].get("mix"), FIRST)
    expect(page.locator(".share .name", has_text=re.compile(rf"^{chair}$"))).to_be_visible()
    page.locator(".legend select").first.select_option("kind")
    expect(page.locator(".legend li", has_text=chair)).to_be_visible()
    page.locator(".numbers select").first.select_option("0")
    page.locator("header nav button").nth(3).click()
    page.wait_for_timeout(500)
    # Materials have their Ids.
    assert english(page, {"English", "frame", "concrete – frame", "human_naked – frame"}) == {}
    page.context.close()


def test_a_kind_of_somebody_s_own_may_have_any_name(page: Page, tmp_path: Path) -> None:
    kind = lambda text: re.sub(r'<Agent (?=[^>]*Type=)', '<Agent Kind="constructor" ', text, count=1)
    trial = changed(download(page, "Trial (zip)", tmp_path), tmp_path / "own.zip", kind)
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text('"own.zip": 5 people')).to_be_visible()
    page.get_by_role("combobox", name="Person", exact=True).select_option(index=1)
    expect(page.get_by_role("region", name="Numbers").get_by_role("row", name="Kind constructor", exact=True)).to_be_visible()
    page.get_by_role("combobox", name="Colour").select_option(label="Kind")
    expect(page.locator(".legend").get_by_text("constructor (1)")).to_be_visible()


def test_pictures_of_kinds_come_also_after_a_stop(page: Page) -> None:
    tab(page, "Room")
    fill(page, "Room width", 1700)
    fill(page, "Room height", 1700)
    tab(page, "Crowd")
    # That takes some seconds, and the pictures wait for it.
    fill(page, "People", 2850)
    page.get_by_role("button", name="Make this crowd").click()
    page.get_by_label("Children, elderly, luggage, wheelchairs").check()
    page.get_by_role("button", name="Stop", exact=True).first.click(force=True)
    expect(page.get_by_text("Stopped.").first).to_be_visible()
    expect(page.locator(".share svg circle").first).to_be_visible()
