"""What the lab computes, compared with the command and with FMPy."""

import json
import math
import statistics
import urllib.request
import zipfile
from pathlib import Path

import fmpy
import pytest
from playwright.sync_api import Page, expect
from visit import LEMONS, Picture, download, example, fill, held, lemons, make, play_until, rows, same_table, seconds, show_at, tab, wait


def test_the_first_example_moves_when_the_page_is_opened(page: Page, tmp_path: Path) -> None:
    wait(page, lambda: seconds(page) >= 1)
    poses = rows(download(page, "Trajectories (CSV)", tmp_path))
    first, last = poses[0], [row for row in poses if row["id"] == "0"][-1]
    assert float(last["x"]) - float(first["x"]) > 0.1


def test_forty_people_in_a_room_with_a_door_move_as_the_command_moves_them(page: Page, tmp_path: Path) -> None:
    tab(page, "Room")
    page.get_by_text("Doors (0)").click()
    page.get_by_role("button", name="Add a door by numbers").click()
    fill(page, "Door 1, width", 90)
    make(page, 40, 400, 400)
    play_until(page, 2)
    expect(page.get_by_text("overlap, by up to")).to_have_count(0)
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    assert "overlap" not in lemons("check", trial)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "2", "-o", table)
    same_table(shown, table)
    poses = rows(table)
    assert len(poses) == 201 * 40
    # They walk to the right, press, and some leave by the door.
    assert max(float(row["mean_normal_force"]) for row in poses) > 100
    assert max(float(row["x"]) for row in poses) > 4
    # That very file runs in FMPy.
    fmu = download(page, "FMU, FMI 2.0", tmp_path)
    names = [f"agent[{i}].Position.x" for i in range(40)]
    result = fmpy.simulate_fmu(str(fmu), stop_time=0.5, output_interval=0.01, output=names)
    known = {(float(row["t"]), int(row["id"])): float(row["x"]) for row in poses}
    for k, row in enumerate(result):
        for i, name in enumerate(names):
            assert row[name] == known[k * 0.01, i]


def same_crowd(page: Page, tmp_path: Path, *options: object) -> list[dict[str, str]]:
    """As the command makes it with these options, to the last bit; its people."""
    trial = download(page, "Trial (zip)", tmp_path)
    people = download(page, "People (CSV)", tmp_path)
    theirs = tmp_path / "crowd" / "crowd.zip"
    theirs.parent.mkdir()
    table = tmp_path / "crowd" / "people.csv"
    room = "--number 40 --box 4x4 --seed 1 --direction 0 --speed 1".split()
    lemons("crowd", *room, *options, "--zip", theirs, "--population", table)
    for name in ("Agents.xml", "Geometry.xml", "AgentDynamics.xml"):
        assert held(trial)[name] == held(theirs)[name], name
    assert people.read_text() == table.read_text()
    return rows(table)


def test_the_crowd_of_the_page_is_that_of_the_command(page: Page, tmp_path: Path) -> None:
    make(page, 40, 400, 400)
    same_crowd(page, tmp_path)


def test_people_of_ones_own_statistics_are_those_of_the_command(page: Page, tmp_path: Path) -> None:
    tab(page, "Crowd")
    page.get_by_label("Who they are").select_option(label="From statistics of your own")
    fill(page, "Men [%]", 25)
    own = {
        "Men": {"bideltoid breadth": (55.5, 1.3, 50, 60), "mass": (103, 4, 90, 120)},
        "Women": {"chest depth": (21.2, 0.7, 18, 24), "stature": (151, 3, 145, 160)},
    }
    text = "men = 0.25\n"
    for who, measures in own.items():
        text += {"Men": "[male]\n", "Women": "[female]\n"}[who]
        for measure, values in measures.items():
            for name, value in zip(("mean", "SD", "least", "most"), values):
                cell = page.get_by_role("spinbutton", name=f"{who}, {measure}, {name}", exact=True)
                cell.fill(str(value))
                cell.press("Tab")
            text += "{} = {{ mean = {}, sd = {}, min = {}, max = {} }}\n".format(measure.split()[-1], *values)
    make(page, 40, 400, 400)
    file = tmp_path / "own.toml"
    file.write_text(text)
    people = same_crowd(page, tmp_path, "--custom", file)
    # Women come after men.
    statures = [100 * float(row["stature_m"]) for row in people if row["sex"] == "female"]
    tab(page, "Crowd")
    cells = page.get_by_role("region", name="Statistics").get_by_role("row", name="stature").last.get_by_role("cell")
    wanted = statistics.mean(statures), statistics.stdev(statures), min(statures), max(statures)
    assert [float(cell) for cell in cells.all_inner_texts()] == pytest.approx(wanted, abs=0.051)


def test_measured_people_are_drawn_from_their_tables(page: Page, tmp_path: Path) -> None:
    # As in the survey: mm, and tenths of a kg.
    tables = {
        "Male": ["520,255,1810,871", "498,240,1722,702", "545,281,1903,1120"],
        "FEMALE": ["441,231,1622,599", "470,262,1533,803"],
    }
    files = []
    for sex, lines in tables.items():
        files.append(tmp_path / f"Team_{sex}.csv")
        files[-1].write_text("\n".join(["bideltoidbreadth,chestdepth,stature,weightkg", *lines]) + "\n")
    tab(page, "Crowd")
    page.get_by_label("Who they are").select_option(label="From tables of measured people")
    page.get_by_label("Choose tables").set_input_files(files)
    expect(page.get_by_text('They are drawn from "Team_Male.csv" and "Team_FEMALE.csv"')).to_be_visible()
    make(page, 40, 400, 400)
    people = same_crowd(page, tmp_path, "--ansur-male", files[0], "--ansur-female", files[1])
    # They are there after a reload, too.
    page.reload()
    expect(page.get_by_text("40 people placed in")).to_be_visible()
    assert rows(download(page, "People (CSV)", tmp_path)) == people
    # One that holds something else is named, with line and column.
    wrong = b"bideltoidbreadth,chestdepth,stature,weightkg\n520,255,tall,871\n"
    tab(page, "Crowd")
    page.get_by_label("Choose tables").set_input_files({"name": "male.csv", "mimeType": "text/csv", "buffer": wrong})
    expect(page.get_by_text('They are drawn from "male.csv"')).to_be_visible()
    expect(page.get_by_role("alert")).to_contain_text("male.csv:2: stature")


def test_those_who_walk_do_as_the_coupled_fmus(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    play_until(page, 1)
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    with zipfile.ZipFile(trial) as archive:
        archive.extractall(tmp_path)
    directory = tmp_path / trial.stem
    crowd, decision, coupled = (tmp_path / name for name in ("crowd.fmu", "decision.fmu", "coupled.ssp"))
    lemons("pack", directory, "-o", crowd)
    lemons("decide", directory, "-o", decision)
    lemons("connect", decision, crowd, "-o", coupled)
    table = tmp_path / "coupled.csv"
    lemons("run", coupled, "--until", "1", "-o", table, "--outputs", tmp_path / "outputs.csv")
    same_table(shown, table)


def test_those_who_leave_by_a_door_are_gone(page: Page, tmp_path: Path) -> None:
    """A Trial of the command with exits: the same table, and who has left is neither picked nor drawn."""
    trial = tmp_path / "room.zip"
    lemons("crowd", "-n", 20, "--box", "5x4", "--door", "5,2,1", "--leave", "--zip", trial)
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text('"room.zip": 20 people')).to_be_visible()
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "15", "-o", table, "--outputs", tmp_path / "outputs.csv")
    whole = rows(table)

    def away(row: dict[str, str], other: dict[str, str]) -> float:
        return math.hypot(float(row["x"]) - float(other["x"]), float(row["y"]) - float(other["y"]))

    def lonely(of: list[dict[str, str]], others: list[dict[str, str]]) -> dict[str, str] | None:
        """Somebody whose place nobody else covers."""
        return next((row for row in of if all(away(row, other) > 0.4 for other in others if other is not row)), None)

    # Where somebody was last, others walk: a moment is looked for at which nobody does.
    now, there, alone, left = [], [], None, None
    for moment in range(60, 100, 3):
        show_at(page, moment / 10)
        now = [row for row in whole if abs(float(row["t"]) - moment / 10) < 1e-6]
        there = [row for row in now if row["active"] == "1"]
        alone, left = lonely(there, there), lonely([row for row in now if row["active"] == "0"], there)
        if alone and left:
            break
    assert len(now) == 20 and alone and left
    shown = download(page, "Trajectories (CSV)", tmp_path)
    same_table(shown, table)
    known = rows(shown)
    assert float(known[-1]["t"]) >= 6 and len(known) % 20 == 0
    person = page.get_by_role("combobox", name="Person")
    picture = Picture(page)
    # Where somebody was last, nobody is picked any more; who is there is.
    picture.click(float(alone["x"]), float(alone["y"]))
    expect(person).to_have_value(str([row["id"] for row in now].index(alone["id"])))
    picture.click(float(left["x"]), float(left["y"]))
    expect(person).to_have_value("")
    # Chosen by its Id, it has no place.
    person.select_option(label=left["id"])
    expect(page.get_by_role("row", name="Place")).to_contain_text("has left")
    gone = sum(row["active"] == "0" for row in now)
    expect(page.get_by_role("row", name="Have left")).to_contain_text(f"{gone} of 20")
    for view in ("3D", "Sections"):
        page.get_by_label("View").select_option(label=view)
        page.wait_for_timeout(1000)
        expect(page.get_by_role("alert")).to_have_count(0)
    picture_of = download(page, "Picture (SVG)", tmp_path).read_text()
    assert picture_of.count("<title>") == 1 + len(there)


def test_those_who_are_pushed_do_as_in_the_command(page: Page, tmp_path: Path) -> None:
    make(page, 12, 300, 300)
    tab(page, "Motion")
    page.get_by_label("What moves them").select_option(label="Some are pushed")
    page.get_by_role("button", name="Add a push by numbers").click()
    fill(page, "Push 1, radius", 60)
    fill(page, "Push 1, greatest force", 900)
    fill(page, "Push 1, duration", 0.333)
    play_until(page, 1)
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    table = tmp_path / "run.csv"
    lemons("run", trial, "--until", "1", "-o", table)
    same_table(shown, table)
    assert max(float(row["normal_force"]) for row in rows(table)) > 0


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_fmu_of_the_page_runs_in_fmpy(page: Page, url: str, tmp_path: Path, version: str) -> None:
    fmu = download(page, f"FMU, FMI {version}", tmp_path)
    assert fmpy.read_model_description(fmu, validate=True).fmiVersion == version
    assert not fmpy.validation.validate_fmu(str(fmu))
    result = fmpy.simulate_fmu(str(fmu), stop_time=0.5, output_interval=0.05)
    assert len(result) == 11
    # It holds the libraries that the page was given, and their licences, if there were some.
    ask = lambda place: urllib.request.urlopen(url + place).read()
    given = {name: ask(place) for name, place in json.loads(ask("binaries.json")).items()}
    licences = given.pop("THIRD-PARTY.txt", None)
    with zipfile.ZipFile(fmu) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    assert held.get("documentation/licenses/THIRD-PARTY.txt") == licences
    libraries = [content for name, content in held.items() if name.startswith("binaries/")]
    assert given and sorted(libraries) == sorted(given.values())


def test_150_people_are_placed_and_run_without_waiting(page: Page) -> None:
    """How long it takes is told, not tested: machines differ."""
    make(page, 150, 500, 500)
    play_until(page, 0.3)
    said = page.get_by_role("status").all_inner_texts() + [page.get_by_role("region", name="Numbers").inner_text()]
    print(LEMONS, said)
