"""Scenes to start from: a question, sliders that act while it runs, and a run that is kept beside another one."""

import functools
import http.server
import io
import json
import re
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, expect
from visit import becomes, download, example, fill, held, lemons, link, people, places, plan, play_until, rows, seconds, shot, show_at, tab, wait


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
    scenes = page.get_by_role("list", name="Your scenes")
    expect(scenes).to_have_count(1)
    assert scenes.get_by_role("listitem").count() == 0
    slide(page, "People", 30)
    expect(scenes.get_by_role("listitem")).to_have_count(1)
    context.close()


def test_a_slider_changes_the_room_while_it_runs_and_the_exit_follows(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    wait(page, lambda: seconds(page) > 0.3)
    slide(page, "Width of the door", 1.5)
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"], [{"at": [8, 3], "width": 1.5}])
    # The line 1 m beyond the door is 2 m longer than it is wide.
    becomes(page, lambda: sorted(plan(page)["made"]["motion"]["decision"]["exits"][0]["line"]), [[9, 1.25], [9, 4.75]])
    # It runs again by itself.
    wait(page, lambda: seconds(page) > 0.3)
    slide(page, "Desired speed", 0.8)
    slide(page, "People", 30)
    expect(page.get_by_text("30 people placed in")).to_be_visible()
    page.get_by_role("button", name="Pause").click()
    trial = download(page, "Trial (zip)", tmp_path)
    assert len(places(trial)) == 30 and "desired_speed = 0.8" in held(trial)["decision.toml"]
    assert "no problem" in lemons("check", trial)


def test_a_slider_comes_back_to_where_it_was_and_the_run_begins_whatever_was_before(page: Page) -> None:
    example(page, "The door", 70)
    slider = page.get_by_role("slider", name="Desired speed")
    for key, value in (("ArrowRight", 1.35), ("ArrowLeft", 1.34), ("ArrowRight", 1.35)):
        slider.press(key)
        becomes(page, lambda: plan(page)["made"]["motion"]["decision"]["desired_speed"], value)
    wait(page, lambda: seconds(page) > 0.1)
    page.get_by_role("button", name="Undo").click()
    becomes(page, lambda: plan(page)["made"]["motion"]["decision"]["desired_speed"], 1.34)
    page.get_by_role("button", name="Play").wait_for()
    slider.press("ArrowRight")
    wait(page, lambda: seconds(page) > 0.1)


def test_the_answer_is_that_of_the_command_before_it_is_played_so_far(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    slide(page, "People", 12)
    expect(page.get_by_text("12 people placed in")).to_be_visible()
    answer = page.locator(".answer")
    expect(page.get_by_role("combobox", name="Chart")).to_have_value("left")
    page.get_by_role("button", name="Pause").click()
    # Few people may be computed to the end by now.
    if (rest := page.get_by_role("button", name="Until all have left")).is_enabled():
        rest.click()
    expect(answer).to_contain_text(re.compile(r"All 12 have left after [\d.]+ s\.$"))
    end = float(answer.inner_text().split()[-2])
    assert seconds(page) < end
    answer.get_by_role("button").click()
    becomes(page, lambda: seconds(page), end)
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", "left", "-o", tmp_path / "run.csv")
    assert float(rows(tmp_path / "run.csv")[-1]["t"]) == pytest.approx(end)


def test_the_greatest_squeeze_of_a_second_is_that_of_the_command(page: Page, tmp_path: Path) -> None:
    example(page, "A dense square", 180)
    play_until(page, 2)
    end = round(100 * seconds(page))
    expect(page.get_by_role("combobox", name="Chart")).to_have_value("greatest")
    words = page.locator(".answer").inner_text()
    found = re.fullmatch(r"Greatest squeeze, mean of 1 s: (\d+) N \((\d+), at ([\d.]+) s\)", words)
    assert found
    expect(page.get_by_role("row", name=words.replace(":", ""))).to_be_visible()
    lemons("run", download(page, "Trial (zip)", tmp_path), "--until", end / 100, "-o", tmp_path / "run.csv")
    table = rows(tmp_path / "run.csv")
    people = len({row["id"] for row in table})
    squeeze = np.array([float(row["mean_normal_force"]) for row in table]).reshape(-1, people)
    # Of the first frame there is no step.
    means = np.lib.stride_tricks.sliding_window_view(squeeze[1:], 100, axis=0).mean(axis=2)
    k, who = np.unravel_index(means.argmax(), means.shape)
    assert (int(found[1]), found[2], float(found[3])) == (round(means.max()), table[who]["id"], pytest.approx((k + 100) / 100))
    # A click shows who it is, in the middle of it.
    page.locator(".answer button").click()
    expect(page.get_by_role("combobox", name="Person")).to_have_value(str(who))
    becomes(page, lambda: round(100 * seconds(page)), int(k + 1 + squeeze[k + 1 : k + 101, who].argmax()))


def test_the_answer_names_the_exits_where_they_are_asked_for(page: Page) -> None:
    example(page, "Two exits", 60)
    if (rest := page.get_by_role("button", name="Until all have left")).is_enabled():
        rest.click()
    answer = page.locator(".answer")
    expect(answer).to_contain_text("All 60 have left")
    counts = [int(count) for count in re.findall(r'": (\d+)', answer.inner_text())]
    assert len(counts) == 2 and sum(counts) == 60


def test_a_slider_that_is_dragged_is_one_step_of_undo(page: Page) -> None:
    example(page, "The door", 70)
    box = page.get_by_role("slider", name="People").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    for k in range(10):
        page.mouse.move(box["x"] + (0.4 - 0.02 * k) * box["width"], box["y"] + box["height"] / 2)
        # One of the values on the way is placed.
        if k == 5:
            wait(page, lambda: plan(page)["made"]["base"]["number"] != 70)
    page.mouse.up()
    wait(page, lambda: plan(page)["made"]["base"]["number"] == plan(page)["crowd"]["number"] != 70)
    assert len(plan(page)["past"]) == 1
    # The question is asked of those who are there.
    expect(page.get_by_role("heading", name=f"How long do {plan(page)['crowd']['number']} people need to leave?")).to_be_visible()
    slide(page, "Desired speed", 0.8)
    assert len(plan(page)["past"]) == 2
    for _ in range(2):
        page.get_by_role("button", name="Undo", exact=True).click()
    expect(page.get_by_role("row", name="People 70", exact=True)).to_be_visible()


def test_an_exit_does_not_follow_a_door_that_could_not_be_made(page: Page, url: str) -> None:
    example(page, "The door", 70)
    page.get_by_role("button", name="Pause").click()
    before = plan(page)
    tab(page, "Crowd")
    fill(page, "People", 4000)
    expect(page.get_by_role("alert")).to_contain_text("without overlap")
    # Another scene, with an exit of this name elsewhere.
    other = {**before, "name": "Elsewhere"}
    (far,) = other["made"]["motion"]["decision"]["exits"]
    assert far["name"] == "door 1"
    far["line"] = [[x + 1, y] for x, y in far["line"]]
    page.evaluate("address => { location.href = address; }", link(url, other))
    expect(page.get_by_label("Name of the scene")).to_have_value("Elsewhere")
    expect(page.get_by_role("row", name="People 70", exact=True)).to_be_visible()
    tab(page, "Motion")
    fill(page, "Desired speed", 1)
    becomes(page, lambda: plan(page)["made"]["motion"]["decision"]["desired_speed"], 1)
    page.wait_for_timeout(500)
    assert plan(page)["made"]["motion"]["decision"]["exits"] == [far]


def test_two_widths_side_by_side_have_the_numbers_of_the_command(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    # Neither run is seen beyond 6 s, however slow the machine is: it is slow, and then paused.
    page.get_by_label("Pace").select_option(label="0.1 ×")
    page.get_by_role("button", name="Pause").click()
    show_at(page, 6)
    first = download(page, "Trial (zip)", tmp_path)
    tab(page, "Start")
    page.get_by_role("button", name="Keep this run to compare").click()
    slide(page, "Width of the door", 1.2)
    expect(page.get_by_text("Kept: door 0.9 m.")).to_be_visible()
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"][0]["width"], 1.2)
    becomes(page, lambda: sorted(plan(page)["made"]["motion"]["decision"]["exits"][0]["line"]), [[9, 1.4], [9, 4.6]])
    page.get_by_role("button", name="Pause").click()
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
    beside = page.locator(".beside").get_by_role("img", name="The run that is kept")
    expect(beside).to_be_visible()
    # Both show the same part of the room, also after a zoom of one of them.
    page.get_by_role("combobox", name="Map").select_option(label="Density")
    expect(page.get_by_role("region", name="Map").get_by_text("601 frames")).to_be_visible()
    main = page.locator(".frame > canvas")
    dense = lambda of: np.sum(np.abs(np.asarray(Image.open(io.BytesIO(shot(of))).convert("RGB")).astype(int) - [0x44, 0x01, 0x54]).sum(axis=2) < 12, axis=(0, 1))
    # Words lie over other parts of the one than of the other.
    wait(page, lambda: abs(dense(beside) / max(1, dense(main)) - 1) < 0.25)
    wide = dense(main)
    box = beside.bounding_box()
    assert box
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.wheel(0, 400)
    wait(page, lambda: dense(main) < 0.8 * wide and abs(dense(beside) / max(1, dense(main)) - 1) < 0.3)
    # The report has both.
    tab(page, "Take away")
    page.get_by_role("button", name="Report to print").click()
    report = page.get_by_role("main", name="Report")
    expect(report.get_by_role("row", name=f"People who have left {left[1]} {left[0]}", exact=True)).to_be_visible()
    expect(report.get_by_role("row", name="What is different door 1.2 m door 0.9 m", exact=True)).to_be_visible()
    page.get_by_role("button", name="Back to the lab").click()
    tab(page, "Start")
    page.get_by_role("button", name="End the comparison").click()
    expect(page.get_by_text("Kept:")).to_have_count(0)


def test_both_runs_go_on_to_the_later_end(page: Page) -> None:
    example(page, "The door", 70)
    slide(page, "People", 5)
    people(page, 5)
    page.get_by_label("Pace").select_option("4")
    page.get_by_role("combobox", name="Chart").select_option("greatest")
    expect(page.get_by_text("All 5 have left after")).to_be_visible()
    # It plays up to there, and stops.
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    end = seconds(page)
    page.get_by_role("button", name="Keep this run to compare").click()
    # A run that has ended plays again with another value.
    slide(page, "Desired speed", 2.5)
    expect(page.get_by_text(re.compile(rf"^Kept: 1.34 m/s. All 5 have left after {end:.2f} s. Greatest squeeze so far: \d+ N"))).to_be_visible()
    expect(page.get_by_text(re.compile(r"^2.5 m/s. All 5 have left after [\d.]+ s. Greatest squeeze so far: \d+ N"))).to_be_visible()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    assert seconds(page) == end
    # Nobody is squeezed any more, in none of both.
    expect(page.locator(".chart .number")).to_have_text(["–", "–"])


def test_the_run_that_is_kept_is_computed_to_its_end(page: Page) -> None:
    """Also where it was kept before that; its curve lies beside the other one, and the report has both."""
    example(page, "The door", 70)
    slide(page, "People", 12)
    people(page, 12)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("combobox", name="Chart").select_option("left")
    show_at(page, 0.5)
    page.get_by_role("button", name="Keep this run to compare").click()
    slide(page, "Width of the door", 2)
    # The other run is on the stage.
    expect(page.get_by_text("Kept: door 0.9 m.")).to_be_visible()
    show_at(page, 40)
    expect(page.get_by_text(re.compile(r"^Kept: door 0.9 m. All 12 have left after [\d.]+ s"))).to_be_visible()
    expect(page.locator(".chart .line")).to_have_text([re.compile("People 12"), re.compile("The run that is kept (12|–)")])
    tab(page, "Take away")
    page.get_by_role("button", name="Report to print").click()
    report = page.get_by_role("main", name="Report")
    expect(report.get_by_role("row", name="People who have left 12 12", exact=True)).to_be_visible()
    own, other = report.locator("figcaption"), report.locator("figcaption", has_text="The run that is kept: ")
    assert 2 * other.count() == own.count() > 0


def test_who_is_put_into_the_crowd_stays_there(page: Page) -> None:
    example(page, "The door", 70)
    tab(page, "Person")
    page.get_by_label("Who").select_option(label="Child")
    expect(page.get_by_role("spinbutton", name="Stature")).to_have_value("120")
    page.get_by_role("button", name="Put into the crowd").click()
    people(page, 71)
    tab(page, "Start")
    slide(page, "Width of the door", 1.2)
    slide(page, "Friction", 0.3)
    becomes(page, lambda: [plan(page)["made"]["base"]["room"]["doors"][0]["width"], plan(page)["made"]["base"]["friction"]], [1.2, 0.3])
    people(page, 71)
    assert [edit["do"] for edit in plan(page)["made"]["edits"]] == ["put"]
    # Other people stand elsewhere.
    slide(page, "People", 60)
    people(page, 60)
    expect(page.get_by_text("Not there any more: changes by hand.")).to_be_visible()


def test_another_page_shows_the_stage_alone(browser: Browser, url: str, tmp_path: Path) -> None:
    here = url.replace("127.0.0.1", "localhost")
    context = browser.new_context(permissions=["clipboard-read", "clipboard-write"])
    other = context.new_page()
    other.goto(here)
    expect(other.get_by_text("70 people placed in")).to_be_visible()
    tab(other, "Take away")
    other.get_by_role("button", name="Copy code to embed").click()
    expect(other.get_by_text("The code is copied.")).to_be_visible()
    code = other.evaluate("() => navigator.clipboard.readText()")
    address = re.search(r'src="([^"]*)"', code)
    assert address and code.startswith("<iframe ") and address[1].startswith(f"{here}?embed#")
    kept = other.evaluate("() => JSON.stringify(localStorage)")
    # A page of another server holds the code.
    (tmp_path / "index.html").write_text(f"<!doctype html><title>Talk</title>{code}")
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(http.server.SimpleHTTPRequestHandler, directory=tmp_path))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    other.goto(f"http://localhost:{server.server_port}/")
    frame = other.frame_locator("iframe")
    expect(frame.get_by_role("heading", name="The door")).to_be_visible()
    # It plays by itself.
    wait(other, lambda: float(frame.locator(".time").inner_text().split()[0]) > 0.5)
    assert frame.get_by_role("navigation").count() == 0 and frame.get_by_role("spinbutton", name="People").count() == 0
    expect(frame.get_by_role("link", name="Open in the lab")).to_have_attribute("href", re.compile("^" + re.escape(here) + r"\?lab#"))
    other.goto(here)
    assert other.evaluate("() => JSON.stringify(localStorage)") == kept
    context.close()
    server.shutdown()


def test_the_stage_is_presented_alone(page: Page) -> None:
    page.locator("canvas").first.press("f")
    expect(page.get_by_role("button", name="End the presentation")).to_be_visible()
    assert page.get_by_role("navigation").count() == 0
    page.get_by_role("button", name="End the presentation").click()
    expect(page.get_by_role("navigation")).to_be_visible()
    page.get_by_role("button", name="Present", exact=True).click()
    wait(page, lambda: page.evaluate("document.fullscreenElement !== null"))
    page.keyboard.press("Escape")
    expect(page.get_by_role("navigation")).to_be_visible()


def test_round_bodies_and_friction_are_in_the_files(page: Page, tmp_path: Path) -> None:
    example(page, "Round and real bodies", 40)
    page.get_by_role("button", name="Pause").click()
    slide(page, "Friction", 0.05)
    page.get_by_label("Round bodies").first.check()
    becomes(page, lambda: [plan(page)["made"]["base"][key] for key in ("friction", "round")], [0.05, True])
    files = held(download(page, "Trial (zip)", tmp_path))
    assert files["Agents.xml"].count("<Shape ") == 40
    assert {"0.05"} == set(re.findall(r'<Contact [^>]*human_naked[^>]*KineticFriction="([^"]*)"', files["Materials.xml"]))


def test_the_report_has_the_numbers_of_the_run(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    # Much more is computed than was shown.
    computed = page.get_by_text(re.compile(r"^computed: [\d.]+ s$"))
    wait(page, lambda: float(computed.inner_text().split()[1]) > 12)
    play_until(page, 4)
    end = seconds(page)
    assert end < 10
    fill(page, "Limit [N]", 120)
    fill(page, "Limit, mean over", 0.5)
    trial = download(page, "Trial (zip)", tmp_path)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", end, "-o", table)
    found = rows(table)
    # Of each, the mean of the last 50 steps, when there are so many.
    squeezes = np.array([float(row["mean_normal_force"]) for row in found]).reshape(-1, 70)
    there = np.array([row["active"] == "1" for row in found]).reshape(-1, 70)
    means = np.array([squeezes[k - 49 : k + 1].mean(axis=0) if k >= 50 else np.zeros(70) for k in range(len(squeezes))])
    summary = tmp_path / "summary.json"
    lemons("measure", table, "--above", 120, "--over", 0.5, "--output", tmp_path / "measured", "--summary", summary)
    level = json.loads(summary.read_text())["exposure"]["time_above"][0]
    assert level["people"] > 0
    times = [float(row["time_above_120_over_0.5"]) for row in rows(tmp_path / "measured/people.csv")]
    left = sum(row["active"] == "0" for row in found[-70:])
    assert left > 1 and len(rows(download(page, "Who left when (CSV)", tmp_path))) == left
    expect(page.get_by_text(f'Up to the last frame that was shown or asked for: "door 1": {left} people')).to_be_visible()
    page.get_by_role("button", name="Report to print").click()
    report = page.get_by_role("main", name="Report")
    row = lambda name: report.get_by_role("row").filter(has=page.get_by_role("rowheader", name=name, exact=True)).last.inner_text().split("\t")
    assert row("People who have left")[1] == row('Exit "door 1": people')[1] == str(left)
    expect(report.get_by_role("row", name="Doors 90 cm", exact=True)).to_be_visible()
    assert page.evaluate("Math.min(...[...document.querySelectorAll('.report img')].map((of) => of.naturalWidth))") > 300
    # The report says that it is of one run.
    expect(report.get_by_text("One run: it is one sample.").first).to_be_visible()
    # The mean over the reader's time is there; that over 0.1 s is said to be an impact.
    squeeze = row("Greatest squeeze of anybody, mean of 0.5 s")
    row("Greatest squeeze of anybody, mean of 0.1 s: it may be an impact")
    assert float(squeeze[1]) == pytest.approx((means * there).max(), rel=6e-3)
    assert row("People ever above 120 N, mean of 0.5 s")[1:4] == [str(level["people"]), "", f"at {level['first']:.2f} s"]
    assert float(row("Longest time of anybody above it, without a break")[1]) == pytest.approx(level["longest"]["max"], abs=0.0051)
    assert float(row("Time above it, summed over people")[1]) == pytest.approx(sum(times), abs=0.051)
    expect(report.get_by_role("row", name='Exit "door 1" line from (9.00, 1.55) to (9.00, 4.45) m', exact=True)).to_be_visible()
    report.get_by_label("Author").fill("A. Mason")
    report.get_by_label("Author").press("Tab")
    becomes(page, lambda: plan(page)["author"], "A. Mason")
    time = squeeze[3].split()[-2]
    expect(report.get_by_text(f"People at the moment of the greatest squeeze: at {time} s.")).to_be_visible()
    expect(report.get_by_role("heading", name="What these numbers do not say")).to_be_visible()
    pdf = page.pdf()
    assert pdf.startswith(b"%PDF") and len(pdf) > 20_000
    page.get_by_role("button", name="Back to the lab").click()
    expect(report).to_have_count(0)
    page.get_by_role("button", name="Report to print").click()
    tab(page, "Crowd")
    expect(report).to_have_count(0)


def test_the_tour_has_four_steps(page: Page) -> None:
    page.get_by_role("button", name="Tour in four steps").click()
    tour = page.get_by_role("dialog", name="Tour")
    for k, part in enumerate((".frame", ".transport", ".sliders", "header nav")):
        expect(tour.get_by_role("heading")).to_contain_text(f"{k + 1} of 4")
        expect(page.locator(f"{part}.toured")).to_have_count(1)
        page.keyboard.press("Enter")
    expect(tour).to_have_count(0)
    expect(page.locator(".toured")).to_have_count(0)
