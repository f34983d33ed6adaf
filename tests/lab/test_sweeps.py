"""Sweeps of the page beside `lemons run` and NumPy."""

import json
import math
import re
import urllib.parse
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from visit import Picture, download, example, fill, given, lemons, live, make, places, plan, rows, seconds, tab, wait


def room(page: Page) -> None:
    """Sixteen people who leave by a door."""
    tab(page, "Room")
    page.get_by_text("Doors (0)").click()
    page.get_by_role("button", name="Add a door by numbers").click()
    make(page, 16, 400, 300)
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="All walk to exits and goals")
    page.get_by_role("button", name="Put an exit beyond each door").click()
    wait(page, lambda: len(plan(page)["made"]["motion"]["decision"]["exits"]) == 1)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()


def of_table(table: Path) -> dict[str, float]:
    """Measures of a run that `lemons run` has written."""
    found = rows(table)
    count = len({row["id"] for row in found})
    squeeze = np.array([float(row["mean_normal_force"]) for row in found]).reshape(-1, count)
    there = np.array([row["active"] == "1" for row in found]).reshape(-1, count)
    times = np.array([float(row["t"]) for row in found]).reshape(-1, count)[:, 0]
    left = count - there.sum(axis=1)
    leavings = times[np.flatnonzero(np.diff(left) > 0) + 1]
    greatest = lambda last: max(np.max(squeeze[max(1, k - last + 1) : k + 1].mean(axis=0) * there[k]) for k in range(1, len(times)))
    return {
        "all_left [s]": times[np.argmax(left == count)],
        "left [people]": left[-1],
        "flow [1/s]": (left[-1] - 1) / (leavings[-1] - leavings[0]),
        "greatest_mean_of_1_s [N]": greatest(100),
        "greatest_mean_of_0.1_s [N]": greatest(10),
        "mean_squeeze [N]": np.mean([squeeze[k][there[k]].mean() for k in range(1, len(times)) if there[k].any()]),
    }


def test_its_runs_have_the_numbers_of_the_command_and_the_quantiles_of_numpy(page: Page, tmp_path: Path) -> None:
    room(page)
    tab(page, "Motion")
    fill(page, "Seed", 5)
    wait(page, lambda: plan(page)["made"]["motion"]["decision"]["seed"] == 5)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_role("combobox", name="Parameter").select_option(label="Width of the door [m]")
    page.get_by_label("Values [m]").fill("0.9, 1.5")
    fill(page, "Seeds for each value", 3)
    expect(page.get_by_text("In the runs of each value, the crowd has the seeds 1 to 3; walking has the seeds 5 to 7; each run has the next one of both.")).to_be_visible()
    page.get_by_role("button", name="Begin the sweep").click()
    expect(page.get_by_text("6 of 6 runs until 120 s.")).to_be_visible()
    path = given(page, "Runs of the sweep (CSV)", tmp_path)
    assert path.name == "A crowd-sweep-width-of-the-door-runs-120s.csv"
    said = json.loads((tmp_path / f"{path.name}-metadata.json").read_text())
    assert urllib.parse.unquote(said["url"]) == path.name and " " not in said["url"] and said["dc:creator"].startswith("LEMONS lab ")
    (settings,) = said["notes"]
    assert settings["values"] == [0.9, 1.5] and settings["made"] == plan(page)["made"]
    runs = rows(path)
    assert [(row["Width of the door [m]"], row["crowd_seed"], row["walking_seed"]) for row in runs] == [(width, str(seed), str(seed + 4)) for width in ("0.9", "1.5") for seed in (1, 2, 3)]
    # What the table shows.
    page.get_by_role("combobox", name="Measure").select_option(label="Time until all have left [s]")
    for k, cells in enumerate(page.locator("table.sweep tbody tr").all()):
        times = [float(row["all_left [s]"]) for row in runs[3 * k : 3 * k + 3]]
        shown = [float(cell) for cell in cells.get_by_role("cell").all_inner_texts()]
        assert shown == pytest.approx([3, min(times), np.median(times), max(times)], rel=5e-3)
    # Of fewer than ten runs, outer quantiles would say more than is known.
    assert page.locator("table.sweep thead th").all_inner_texts()[1:] == ["runs", "least", "50 %", "greatest"]
    # The table of quantiles has all measures.
    quantiles = rows(given(page, "Quantiles of the sweep (CSV)", tmp_path))
    assert len(quantiles) == 2 * 7
    for row in quantiles:
        mine = [float(run[f"{row['measure']} [{row['unit']}]"]) for run in runs if run["Width of the door [m]"] == row["Width of the door [m]"]]
        assert (row["runs"], row["runs_with_a_number"]) == ("3", "3")
        assert [float(row[f"quantile_{share}"]) for share in (0.1, 0.5, 0.9)] == pytest.approx(np.quantile(mine, [0.1, 0.5, 0.9]))
    # The form is as it was after another tab.
    page.get_by_role("combobox", name="Measure").select_option(label="Mean flow [1/s]")
    tab(page, "Room")
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    expect(page.get_by_role("combobox", name="Measure")).to_have_value("flow")
    expect(page.get_by_role("spinbutton", name="Seeds for each value")).to_have_value("3")
    expect(page.get_by_label("Values [m]")).to_have_value("0.9, 1.5")
    page.get_by_role("combobox", name="Measure").select_option(label="Time until all have left [s]")
    expect(page.locator("svg.runs circle")).to_have_count(6)
    # The second run of the wider door, on the stage and with the command.
    page.locator("svg.runs circle").nth(4).dispatch_event("click")
    expect(page.get_by_label("Name of the scene")).to_have_value("A crowd, Width of the door 1.5, seed 2")
    wait(page, lambda: plan(page)["made"]["base"]["seed"] == 2)
    assert plan(page)["sweep"] == {"parameter": "Width of the door", "values": "0.9, 1.5", "seeds": 3, "until": None, "measure": "all_left"}
    trial = download(page, "Trial (zip)", tmp_path)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "left", "-o", table)
    wanted = of_table(table)
    assert {name: float(runs[4][name]) for name in wanted} == pytest.approx(wanted, rel=1e-5)
    # How deep people overlap, the stage says.
    expect(page.get_by_role("row", name="Have left 16 of 16", exact=True)).to_be_visible()
    words = page.get_by_role("row", name=re.compile("^Deepest overlap so far")).inner_text()
    assert float(runs[4]["deepest_overlap [mm]"]) == pytest.approx(float(words.split()[-2]), rel=0.06)


def test_a_long_run_of_many_people_keeps_few_frames(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    page.get_by_role("button", name="Pause").click()
    trial = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_label("Values [m]").fill("0.9")
    fill(page, "Seeds for each value", 1)
    fill(page, "Until all have left, at most", 300)
    # Frames lie in blocks of 4 MB.
    page.evaluate(
        """() => {
            window.blocks = [];
            window.Float32Array = new Proxy(Float32Array, {
                construct(type, given, target) {
                    const made = Reflect.construct(type, given, target);
                    if (given[0] > 9e5) window.blocks.push(new WeakRef(made));
                    return made;
                },
            });
        }"""
    )
    page.get_by_role("button", name="Begin the sweep").click()
    tools = page.context.new_cdp_session(page)
    most = 0
    while not page.get_by_text("1 of 1 runs").count():
        tools.send("HeapProfiler.collectGarbage")
        most = max(most, page.evaluate("window.blocks.filter(block => block.deref()).length"))
    count = page.evaluate("window.blocks.length")
    assert count >= 3 and most <= 2, (count, most)
    swept = given(page, "Runs of the sweep (CSV)", tmp_path)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "left", "-o", table)
    wanted = of_table(table)
    (found,) = rows(swept)
    assert {name: float(found[name]) for name in wanted} == pytest.approx(wanted, rel=1e-5)


def test_it_can_be_stopped_and_says_what_cannot_be_swept(page: Page) -> None:
    room(page)
    values = page.get_by_label("Values [m]")
    begin = page.get_by_role("button", name="Begin the sweep")
    for text, words in (("0.9, x", "x: 0.5 to 3"), ("", "At least one value"), ("7", "7: 0.5 to 3"), (",".join(str(0.5 + k / 100) for k in range(250)), "at most 1000")):
        values.fill(text)
        fill(page, "Seeds for each value", 5)
        expect(page.get_by_role("alert").filter(has_text=words)).to_be_visible()
        expect(begin).to_be_disabled()
    values.fill("0.9")
    fill(page, "Seeds for each value", 100)
    begin.click()
    # The page is heard meanwhile.
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_text(re.compile(r'^"A crowd": [1-9]\d* of 100 runs'))).to_be_visible()
    page.get_by_role("button", name="Stop the sweep").click()
    stopped = page.get_by_text(re.compile(r"of 100 runs until 120 s, stopped"))
    expect(stopped).to_be_visible()
    count = stopped.inner_text()
    page.wait_for_timeout(1500)
    assert stopped.inner_text() == count


def test_changes_by_hand_stay_in_each_run_where_they_fit(page: Page, tmp_path: Path) -> None:
    room(page)
    tab(page, "Crowd")
    picture = Picture(page)
    page.get_by_role("button", name="To the start").click()

    def with_seed(seed: int) -> dict[str, tuple[float, float, float]]:
        tab(page, "Crowd")
        fill(page, "Seed", seed)
        live(page)
        return places(download(page, "Trial (zip)", tmp_path))

    others = [with_seed(seed) for seed in (2, 3, 4)]
    people = with_seed(1)
    tab(page, "Crowd")
    away = lambda at: min(math.dist(at, pose[:2]) for pose in people.values())
    # One person to where nobody is in this crowd, but somebody else is in that of another seed; one away.
    free = max((pose[:2] for other in others for id, pose in other.items() if id not in ("3", "5")), key=away)
    assert away(free) > 0.5
    picture.drag(people["3"][:2], free)
    wait(page, lambda: [edit["do"] for edit in plan(page)["made"]["edits"]] == ["move"])
    picture.click(*people["5"][:2])
    page.get_by_role("button", name="Delete person").click()
    wait(page, lambda: len(plan(page)["made"]["edits"]) == 2)
    edits = plan(page)["made"]["edits"]
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_role("combobox", name="Parameter").select_option(label="Desired speed [m/s]")
    page.get_by_label("Values [m/s]").fill("1, 1.5")
    fill(page, "Seeds for each value", 4)
    page.get_by_role("button", name="Begin the sweep").click()
    expect(page.get_by_text("8 of 8 runs until 120 s.")).to_be_visible()
    runs = rows(given(page, "Runs of the sweep (CSV)", tmp_path))
    # All who are left go out: the deleted one is in no run.
    assert [row["left [people]"] for row in runs] == ["15"] * 8
    out = [int(row["changes_left_out"]) for row in runs]
    assert out[0] == out[4] == 0 and out[:4] == out[4:] and set(out) == {0, 1}
    # Where the place is free in the crowd of another seed: its own Trial says so.
    for k, count in enumerate(out):
        page.locator("svg.runs circle").nth(k).dispatch_event("click")
        wait(page, lambda k=k: plan(page)["made"]["base"]["seed"] == int(runs[k]["crowd_seed"]) and plan(page)["made"]["motion"]["decision"]["desired_speed"] == float(runs[k]["Desired speed [m/s]"]))
        made = plan(page)["made"]["edits"]
        assert made == (edits if count == 0 else edits[1:])
        poses = places(download(page, "Trial (zip)", tmp_path))
        assert "5" not in poses and (math.dist(poses["3"][:2], (edits[0]["x"], edits[0]["y"])) < 1e-9) == (count == 0)
        expect(page.get_by_text("overlap, by up to")).to_have_count(0)
        tab(page, "Start")
        if not page.locator("svg.runs").is_visible():
            page.get_by_text("A sweep: many values").click()
    listed = page.get_by_text(re.compile(r"^Not all changes by hand fit in \d of 8 runs$"))
    listed.click()
    expect(page.get_by_text(re.compile(r'seed \d: person "3" moved: person "3" would overlap'))).to_have_count(sum(out))


def test_changes_by_hand_fit_the_walls_of_each_width_of_a_door(page: Page, tmp_path: Path) -> None:
    room(page)
    tab(page, "Crowd")
    assert plan(page)["crowd"]["room"]["doors"] == [{"at": [4, 1.5], "width": 1}]
    # Somebody stands in the door, near its end, away from others: a narrower door has a wall there.
    at = (4.05, 1.3)
    picture = Picture(page)
    page.get_by_role("button", name="To the start").click()
    people = places(download(page, "Trial (zip)", tmp_path))
    tab(page, "Crowd")
    picture.drag(people["3"][:2], at)
    wait(page, lambda: [edit["do"] for edit in plan(page)["made"]["edits"]] == ["move"])
    edit = plan(page)["made"]["edits"][0]
    assert math.dist((edit["x"], edit["y"]), at) < 0.1
    expect(page.get_by_text("It overlaps")).to_have_count(0)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_role("combobox", name="Parameter").select_option(label="Width of the door [m]")
    page.get_by_label("Values [m]").fill("0.5, 1.5")
    fill(page, "Seeds for each value", 1)
    page.get_by_role("button", name="Begin the sweep").click()
    expect(page.get_by_text("2 of 2 runs until 120 s.")).to_be_visible()
    page.get_by_text("Not all changes by hand fit in 1 of 2 runs").click()
    expect(page.get_by_text('Width of the door: 0.5, seed 1: person "3" moved: person "3" would overlap a wall or somebody')).to_be_visible()


def test_the_report_says_what_a_sweep_was_made_of(page: Page) -> None:
    room(page)
    page.get_by_role("combobox", name="Parameter").select_option(label="Width of the door [m]")
    page.get_by_label("Values [m]").fill("0.9")
    fill(page, "Seeds for each value", 2)
    page.get_by_role("button", name="Begin the sweep").click()
    expect(page.get_by_text("2 of 2 runs until 120 s.")).to_be_visible()
    changed = page.get_by_text("The scene was changed since: what was assumed in the sweep is below.")
    report = page.get_by_role("main", name="Report")
    for people, differs in ((16, False), (12, True)):
        if differs:
            make(page, people, 400, 300)
        tab(page, "Take away")
        page.get_by_role("button", name="Report to print").click()
        expect(report.get_by_text(re.compile(r"^Made with the LEMONS lab \d+\.\d+\.\d+"))).to_be_visible()
        expect(report.get_by_role("row", name="Parameter Width of the door: 0.9 m", exact=True)).to_be_visible()
        expect(report.get_by_role("row", name="Seeds 1; 2", exact=True)).to_be_visible()
        # Of the run, and of the sweep.
        of_people = report.get_by_role("row", name=re.compile(r"^People \d+$"))
        expect(of_people).to_have_count(2)
        assert of_people.all_inner_texts() == [f"People\t{people}", "People\t16"]
        expect(changed).to_have_count(1 if differs else 0)
        page.get_by_role("button", name="Back to the lab").click()


def test_runs_of_people_in_levels_have_the_numbers_of_the_command(page: Page, tmp_path: Path) -> None:
    room(page)
    tab(page, "Crowd")
    page.get_by_label("Levels").select_option("2")
    live(page)
    tab(page, "Start")
    page.get_by_text("A sweep: many values").click()
    page.get_by_role("combobox", name="Parameter").select_option(label="Width of the door [m]")
    page.get_by_label("Values [m]").fill("1.5")
    fill(page, "Seeds for each value", 1)
    page.get_by_role("button", name="Begin the sweep").click()
    expect(page.get_by_text("1 of 1 runs until 120 s.")).to_be_visible()
    (run,) = rows(given(page, "Runs of the sweep (CSV)", tmp_path))
    page.locator("svg.runs circle").first.dispatch_event("click")
    expect(page.get_by_label("Name of the scene")).to_have_value("A crowd, Width of the door 1.5, seed 1")
    # It is another run, which begins anew.
    wait(page, lambda: seconds(page) < 1.5)
    wait(page, lambda: seconds(page) > 3)
    table = tmp_path / "run.csv"
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", "left", "-o", table)
    wanted = of_table(table)
    assert {name: float(run[name]) for name in wanted} == pytest.approx(wanted, rel=1e-5)
