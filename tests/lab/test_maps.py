"""Maps of density and squeeze beside NumPy on the table of `lemons run`, and beside `lemons plot`."""

import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page, expect
from visit import Picture, download, fill, given, lemons, make, plan, rows, shot, show_at, tab, wait

#: [m] Standard deviation of a person in a map of the density, and side of a cell of a map of squeeze: docs/lab.md.
KERNEL, CELL = 0.3, 0.25
erf = np.vectorize(math.erf)


def show(page: Page, name: str, words: str) -> None:
    page.get_by_role("combobox", name="Map").select_option(label=name)
    expect(page.get_by_role("region", name="Map").get_by_text(words)).to_be_visible()


def table(page: Page, to: Path) -> dict[str, np.ndarray]:
    found = rows(given(page, "Map (CSV)", to))
    return {name.split(" ")[0]: np.array([float(row[name]) for row in found]) for name in found[0]}


def frames(table: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times; places (frame, agent, axis); squeeze (frame, agent)."""
    found = rows(table)
    count = len({row["id"] for row in found})
    number = lambda name: np.array([float(row[name]) for row in found]).reshape(-1, count)
    return number("t")[:, 0], np.stack([number("x"), number("y")], axis=2), number("mean_normal_force")


def test_the_density_is_that_of_the_command_and_of_a_formula(page: Page, tmp_path: Path) -> None:
    make(page, 14, 300, 250)
    show_at(page, 0.5)
    show(page, "Density", "51 frames from 0 to 0.5 s.")
    found = table(page, tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    lemons("run", trial, "--until", 0.5, "-o", tmp_path / "run.csv")
    _, places, _ = frames(tmp_path / "run.csv")
    x, y = np.unique(found["x"]), np.unique(found["y"])
    # Whole cells of a quarter of a metre, from 1 m below the walls to 1 m above.
    size = [x[1] - x[0], y[1] - y[0]]
    low, high = [x[0] - size[0] / 2, y[0] - size[1] / 2], [x[-1] + size[0] / 2, y[-1] + size[1] / 2]
    assert [*low, *high] == pytest.approx([-1, -1, 4, 3.5], abs=1e-6)
    shares = lambda axis, at, width: np.diff(0.5 * erf((np.append(axis - width / 2, axis[-1] + width / 2) - at) / (KERNEL * np.sqrt(2)))) / width
    # The walls of a rectangle hide what is beyond them, and nothing else.
    inside = np.outer((y > 0) & (y < 2.5), (x > 0) & (x < 3))
    wanted = np.zeros(inside.shape)
    for at in places.reshape(-1, 2):
        seen = inside * np.outer(shares(y, at[1], size[1]), shares(x, at[0], size[0]))
        wanted += seen / (seen.sum() * size[0] * size[1]) / len(places)
    density = found["density"].reshape(len(y), len(x))
    assert density == pytest.approx(wanted, abs=2e-5)
    assert density.sum() * size[0] * size[1] == pytest.approx(14)
    # The greatest density at the colours of `lemons plot`.
    view = ",".join(str(round(bound, 6)) for bound in [*low, *high])
    lemons("plot", trial, "--density", "--until", 0.5, f"--view={view}", "-o", tmp_path / "plot.svg")
    text = (tmp_path / "plot.svg").read_text()
    assert "the mean of 51 frames" in text
    assert f'aria-label="{density.max():.3g}"' in text


def test_the_squeeze_is_that_of_those_in_each_cell(page: Page, tmp_path: Path) -> None:
    # They walk against a wall.
    make(page, 20, 300, 250)
    show_at(page, 1.5)
    show(page, "Mean squeeze", "150 frames from 0.01 to 1.5 s.")
    fill(page, "Map from", 0.5)
    show(page, "Mean squeeze", "101 frames from 0.5 to 1.5 s. Squeeze: mean of 0.1 s.")
    found = table(page, tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    lemons("run", trial, "--until", 1.5, "-o", tmp_path / "run.csv")
    _, places, squeeze = frames(tmp_path / "run.csv")
    values: dict[tuple[int, int], list[float]] = {}
    for k in range(50, 151):
        for at, mean in zip(places[k], squeeze[k - 9 : k + 1].mean(axis=0), strict=True):
            values.setdefault((int(np.floor(at[0] / CELL)), int(np.floor(at[1] / CELL))), []).append(mean)
    cells = sorted(values, key=lambda cell: cell[::-1])
    assert found["x"] == pytest.approx([CELL * (x + 0.5) for x, _ in cells])
    assert found["y"] == pytest.approx([CELL * (y + 0.5) for _, y in cells])
    assert list(found["values"]) == [len(values[cell]) for cell in cells]
    assert found["mean_squeeze_of_means_of_0.1_s"] == pytest.approx([np.mean(values[cell]) for cell in cells], rel=1e-5, abs=1e-3)
    assert found["greatest_squeeze_of_means_of_0.1_s"] == pytest.approx([max(values[cell]) for cell in cells], rel=1e-5, abs=1e-3)
    assert max(found["greatest_squeeze_of_means_of_0.1_s"]) > 100
    # The mouse tells the number of a cell where nobody stands now.
    picture = Picture(page)
    away = lambda cell: np.min(np.hypot(*(places[0] - CELL * (np.array(cell) + 0.5)).T))
    at = max((cell for cell in values if away(cell) > 0.35), key=lambda cell: np.mean(values[cell]))
    page.get_by_role("button", name="To the start").click()
    picture.move(*(CELL * (np.array(at) + 0.5)))
    words = page.get_by_role("region", name="Map").locator("p.hidden")
    expect(words).to_have_text(re.compile(r"^Mean squeeze: [\d.]+ N$"))
    told = float(words.inner_text().split()[-2])
    assert told == pytest.approx(np.mean(values[at]), rel=6e-3, abs=0.01)
    # A ring of ink is around the cell with the greatest value.
    most = found["mean_squeeze_of_means_of_0.1_s"].argmax()
    x, y = picture.pixel(found["x"][most], found["y"][most])
    grey = np.asarray(Image.open(io.BytesIO(shot(picture.canvas))).convert("L")).astype(int)
    ring = [grey[round(y + 7 * math.sin(turn)), round(x + 7 * math.cos(turn))] for turn in np.arange(0.1, 2 * math.pi, 0.5)]
    assert np.median(ring) < 90, ring
    # Without a mouse: the number where the selected person stands.
    page.get_by_role("combobox", name="Person", exact=True).select_option(label="0")
    beside = page.get_by_role("region", name="Map").get_by_text("At the selected person:")
    expect(beside).to_have_text(re.compile(r"^At the selected person: Mean squeeze: [\d.]+ N$"))
    cell = tuple(int(number) for number in np.floor(places[0, 0] / CELL))
    assert float(beside.inner_text().split()[-2]) == pytest.approx(np.mean(values[cell]), rel=6e-3, abs=0.01)
    # Means of 1 s are other ones, and the greatest is another map.
    page.get_by_role("combobox", name="mean of").select_option(label="1 s")
    show(page, "Greatest squeeze", "Squeeze: mean of 1 s.")
    wait(page, lambda: max(table(page, tmp_path)["greatest_squeeze_of_means_of_1_s"]) < max(found["greatest_squeeze_of_means_of_0.1_s"]))


def test_a_map_goes_on_with_the_run_and_with_links(page: Page, tmp_path: Path) -> None:
    make(page, 20, 400, 300)
    page.get_by_role("combobox", name="Map").select_option(label="Density")
    region = page.get_by_role("region", name="Map")
    show_at(page, 1)
    expect(region.get_by_text("101 frames from 0 to 1 s")).to_be_visible()
    show_at(page, 2)
    expect(region.get_by_text("201 frames from 0 to 2 s")).to_be_visible()
    page.get_by_label("to what is computed").uncheck()
    fill(page, "Map to", 1.5)
    expect(region.get_by_text("151 frames from 0 to 1.5 s")).to_be_visible()
    assert plan(page)["map"] == "density" and plan(page)["span"] == [None, 1.5]
    # A time that is not computed has no map.
    fill(page, "Map to", 9)
    fill(page, "Map from", 8)
    expect(region.get_by_text("no frames in this time")).to_be_visible()
    expect(page.get_by_role("button", name="Map (CSV)")).to_be_disabled()
    fill(page, "Map from", 1)
    expect(region.get_by_text("101 frames from 1 to 2 s")).to_be_visible()
    # The picture has the map and its scale: density has the colours of viridis, which is nowhere else.
    pixels = lambda path: np.asarray(Image.open(path).convert("RGB")).astype(int)
    first = given(page, "Map (PNG)", tmp_path)
    assert first.name == "A crowd-density-1-2s.png"
    colours = pixels(first).reshape(-1, 3)
    assert np.sum(np.abs(colours - [0x44, 0x01, 0x54]).sum(axis=1) < 12) > 5000
    # It shows no people, who are of one moment: it is the same whatever moment the stage shows.
    (tmp_path / "later").mkdir()
    page.get_by_role("button", name="To the start", exact=True).click()
    assert (pixels(given(page, "Map (PNG)", tmp_path / "later")) == pixels(first)).all()
    # The table's name has the time, and the file beside it says what the map is of.
    csv = given(page, "Map (CSV)", tmp_path)
    assert csv.name == "A crowd-density-1-2s.csv"
    (settings,) = json.loads((tmp_path / f"{csv.name}-metadata.json").read_text())["notes"]
    assert [settings[key] for key in ("from_s", "to_s", "frames", "people")] == [1, 2, 101, 20]
    sizes = [np.diff(np.unique([float(row[f"{axis} [m]"]) for row in rows(csv)]))[0] for axis in "xy"]
    assert settings["cell_m"] == pytest.approx(sizes, rel=1e-5)
    expect(region.get_by_text("cells of {:.3g} m × {:.3g} m".format(*sizes))).to_be_visible()
    # Another scene begins without a map.
    tab(page, "Start")
    page.get_by_role("button", name="A dense square").click()
    expect(region).to_have_count(0)


def test_many_people_have_a_map_of_some_of_the_frames_and_the_page_is_heard(page: Page, tmp_path: Path) -> None:
    make(page, 600, 1600, 1600)
    show_at(page, 6)
    # 601 frames of 600 people are more than 200 000 places.
    words = "301 frames from 0 to 6 s, one of 2"
    # Counts how often the page is heard between the choice of the map and its end, however fast the machine is.
    page.evaluate(
        """words => {
            let begun = false;
            window.heard = 0;
            document.addEventListener("change", () => { begun = true; }, true);
            const clock = setInterval(() => {
                if (document.body.textContent.includes(words)) clearInterval(clock);
                else if (begun) window.heard += 1;
            }, 1);
        }""",
        words,
    )
    page.get_by_role("combobox", name="Map").select_option(label="Density")
    expect(page.get_by_role("region", name="Map").get_by_text(words)).to_be_visible()
    assert page.evaluate("window.heard") > 10
    found = table(page, tmp_path)
    area = np.diff(np.unique(found["x"]))[0] * np.diff(np.unique(found["y"]))[0]
    assert found["density"].sum() * area == pytest.approx(600, rel=1e-6)


def test_a_map_that_is_not_finished_and_another_one_do_not_mix(page: Page, tmp_path: Path) -> None:
    make(page, 600, 1600, 1600)
    show_at(page, 6)
    choice = page.get_by_role("combobox", name="Map")
    region = page.get_by_role("region", name="Map")
    choice.select_option(label="Density")
    # It has some of its frames, and asks for more.
    expect(region.get_by_text(re.compile(r"^\d+ frames? from 0 to \d"))).to_be_visible()
    choice.select_option(label="Mean squeeze")
    expect(region.get_by_text("600 frames from 0.01 to 6 s.")).to_be_visible()
    # Everybody counts once in each frame.
    assert table(page, tmp_path)["values"].sum() == 600 * 600
    choice.select_option(label="Density")
    expect(region.get_by_text("301 frames from 0 to 6 s, one of 2")).to_be_visible()
    found = table(page, tmp_path)
    area = np.diff(np.unique(found["x"]))[0] * np.diff(np.unique(found["y"]))[0]
    assert found["density"].sum() * area == pytest.approx(600, rel=1e-6)
    expect(region.get_by_role("alert")).to_have_count(0)


def test_a_ramp_has_one_meaning_at_a_time(page: Page) -> None:
    make(page, 14, 300, 250)
    show_at(page, 0.5)
    ramp = "of => of.map(ramp => [...ramp.querySelectorAll('stop')].map(stop => stop.getAttribute('stop-color')).join())"
    for colour in ("Squeeze", "Speed", "Contacts"):
        page.get_by_role("combobox", name="Colour").select_option(label=colour)
        for name in ("Density", "Mean squeeze", "Greatest squeeze"):
            page.get_by_role("combobox", name="Map").select_option(label=name)
            expect(page.locator(".ramp")).to_have_count(2)
            people, places = page.locator(".ramp").evaluate_all(ramp)
            assert people != places, (colour, name)
