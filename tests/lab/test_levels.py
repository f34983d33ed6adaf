"""People in levels: the load on chests and at levels, against the table of the command; pictures at a height."""

import statistics
from pathlib import Path

from playwright.sync_api import Page, expect
from visit import becomes, download, fill, lemons, live, make, plan, rows, shot, show_at, wait

PEOPLE, END = 14, 1.0
#: Of the colour and of the chart.
OFFERED = ("Load on the chest", "Chest, front–back", "Squeeze by level", "Load on a chest [N]")


def number(text: str) -> float:
    return float(text.removesuffix(" N").replace(",", ""))


def test_the_load_on_chests_and_levels_is_shown_where_there_are_levels(page: Page, tmp_path: Path) -> None:
    make(page, PEOPLE, 200, 200)
    option = lambda name: page.get_by_role("option", name=name, exact=True)
    view, colour = (page.get_by_role("combobox", name=name) for name in ("View", "Colour"))
    for name in (*OFFERED, "At a height"):
        expect(option(name)).to_have_count(0)
    page.get_by_label("Levels").select_option("3")
    live(page)
    for name in (*OFFERED, "At a height"):
        expect(option(name)).to_have_count(1)
    expect(option("Sections")).to_have_count(0)
    show_at(page, END)

    # The numbers of who is pressed most are those of the command, as means over 0.1 s.
    table = tmp_path / "run.csv"
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", END, "-o", table)
    of = lambda name: [row for row in rows(table) if row["id"] == name and float(row["t"]) > END - 0.095]
    mean = lambda name, column: statistics.fmean(float(row[column]) for row in of(name))
    most = max((row["id"] for row in rows(table)), key=lambda name: mean(name, "chest_force"))
    page.get_by_role("combobox", name="Person").select_option(label=most)
    fact = lambda name: page.get_by_role("region", name="Numbers").get_by_role("row", name=name).get_by_role("cell").inner_text()
    chest = {"Load on the chest": "force", "Chest, front–back": "front", "Chest, side–side": "side", "Chest, from all sides": "least"}
    wait(page, lambda: all(abs(number(fact(name)) - mean(most, f"chest_{column}")) < 0.51 for name, column in chest.items()), 20)
    levels = [number(part) for part in fact("Squeeze by level").removesuffix(" N").split(" · ")]
    assert len(levels) == 3 and abs(sum(levels) - mean(most, "normal_force")) < 1.6 and mean(most, "chest_force") > 50

    # Each colour has a scale, which explains itself. In 3D, levels of a body have different ones.
    canvas = page.locator("canvas").first
    view.select_option(label="3D")
    expect(page.get_by_text("Bodies are made")).to_have_count(0)
    seen = {}
    for name, words in (("Load on the chest", "people and walls"), ("Chest, front–back", "Opposing forces"), ("Squeeze by level", "grey is in none")):
        before = shot(canvas)
        colour.select_option(label=name)
        wait(page, lambda: shot(canvas) != before)
        seen[name] = shot(canvas)
        page.get_by_text("About this scale", exact=True).click()
        expect(page.get_by_text(words)).to_be_visible()
        page.get_by_text("About this scale", exact=True).click()
    expect(page.get_by_text("in no level")).to_be_visible()

    # At a height there are other disks, with the colours of their level; pictures show it.
    view.select_option(label="At a height")
    pixels = lambda: canvas.evaluate("canvas => canvas.toDataURL()")
    shown, pictures = {}, {}
    for height, cut, level in ((70, PEOPLE, "50 cm to 90 cm"), (110, PEOPLE, "90 cm to 130 cm"), (175, 0, None)):
        fill(page, "Altitude", height)
        expect(page.get_by_text(f"{cut} of {PEOPLE} people have disks at this height")).to_be_visible()
        expect(page.get_by_text(f"The level is from {level}." if level else "There is no level.")).to_be_visible()
        becomes(page, lambda: round(100 * plan(page)["altitude"]), height)
        shown[height] = pixels()
        for kind in ("PNG", "SVG"):
            pictures[height, kind] = download(page, f"Picture ({kind})", tmp_path).read_bytes()
    assert len(set(shown.values())) == 3 and len(set(pictures.values())) == 6
    people = [pictures[height, "SVG"].count(b"<title>") - 1 for height in shown]
    assert people == [PEOPLE, PEOPLE, 0], people
