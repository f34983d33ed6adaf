"""`lemons report`: its numbers are those of other commands for the same runs, in a page and in a PDF that others read."""

import json
import re
import signal
import subprocess
import time
from pathlib import Path

import pandas as pd
import pytest
from lxml import etree

ROOM = """box = [6.0, 5.0]
doors = [[6.0, 2.5, 0.9], [3.0, 5.0, 0.8]]
number = 40
seed = 3
leave = true
"""
# Of Student's distribution, 95 % lie within it for one degree of freedom.
T_1 = 12.706204736


def command(lemons, *words, cwd, code=0):
    done = subprocess.run([lemons, *map(str, words)], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


def page(path):
    """The page as XML: it is well-formed, has no script, and asks for nothing else."""
    text = path.read_text(encoding="utf-8").replace("<!DOCTYPE html>", "")
    root = etree.fromstring(text.encode())
    assert not root.xpath("//script | //link | //iframe | //object | //@onload | //@onerror | //@href")
    assert all(address.startswith("data:image/svg+xml") for address in root.xpath("//@src"))
    return root


def text(element):
    return " ".join("".join(element.itertext()).split())


def section(root, heading):
    return root.xpath("//section[h2=$heading]", heading=heading)[0]


def rows(of):
    return [[text(cell) for cell in row.xpath("th | td")] for row in of.xpath(".//tr")]


@pytest.fixture(scope="module")
def made(lemons, tmp_path_factory):
    """A report of two runs, and the same runs measured one by one."""
    here = tmp_path_factory.mktemp("report")
    (here / "room.toml").write_text(ROOM)
    command(lemons, "report", "room.toml", "--seeds", 2, "-o", "room.html", cwd=here)
    command(lemons, "report", "room.toml", "--seeds", 2, "-o", "room.pdf", cwd=here)
    measured = []
    for seed in (3, 4):
        command(lemons, "crowd", "--scenario", "room.toml", "--seed", seed, "-o", f"T{seed}", cwd=here)
        limit = ["--above", 623, "--over", 1, "--walls", "-o", f"M{seed}"]
        command(lemons, "measure", f"T{seed}", "--until", "left", *limit, cwd=here)
        measured.append((json.loads((here / f"M{seed}/summary.json").read_text()), pd.read_csv(here / f"M{seed}/panels.csv"), pd.read_csv(here / f"M{seed}/people.csv")))
    return here, page(here / "room.html"), measured


def test_the_numbers_are_those_of_measured_runs(made):
    _, root, measured = made
    table = {row[0]: row[1:] for row in rows(section(root, "What came out"))}

    def holds(name, values, decimals):
        unit, mean, interval, least, most, _, runs = table[name]
        middle = sum(values) / 2
        half = T_1 * abs(values[0] - values[1]) / 2
        low, high = map(float, interval.split(" to "))
        near = 0.51 * 10**-decimals
        assert [float(least), float(most), float(mean)] == pytest.approx([min(values), max(values), middle], abs=near)
        assert [low, high] == pytest.approx([middle - half, middle + half], abs=near) and runs == "2"
        return unit

    whole = [summary for summary, _, _ in measured]
    assert holds("All have left after", [of["left"]["evacuation_time"] for of in whole], 1) == "s"
    holds("People who have left", [of["left"]["people"] for of in whole], 0)
    for k, name in ((1, "Greatest squeeze of anybody, mean of 1 s"), (2, "Greatest squeeze of anybody, mean of 10 s")):
        assert holds(name, [of["exposure"]["largest_mean"][k]["mean"]["max"] for of in whole], 0) == "N"
    holds("Squeeze that 90 % of people stay below, mean of 1 s", [of["exposure"]["largest_mean"][1]["mean"]["quantile_90"] for of in whole], 0)
    holds("People ever above 623 N, mean of 1 s", [of["exposure"]["time_above"][0]["people"] for of in whole], 0)
    holds("Time above it, summed over people", [people["time_above_623_over_1"].sum() for _, _, people in measured], 1)
    # Who was pressed most in each run, and by what.
    for seen, (of, _, people) in zip(rows(section(root, "Squeeze in each run"))[1:], measured):
        most = of["exposure"]["largest_mean"][1]["mean"]
        assert seen[4] == most["max_id"] and float(seen[5]) == pytest.approx(most["max"], abs=0.51)
        by_walls = people.set_index("id")["largest_mean_1_by_walls"][int(most["max_id"])]
        assert float(seen[6]) <= 100 * by_walls / most["max"] + 0.51


def test_loads_are_those_of_measured_runs(made):
    _, root, measured = made
    found = 0
    for name, *row in rows(section(root, "Loads on walls"))[1:]:
        wall, x, y, what = re.fullmatch(r"Wall (\S+) at \((\S+), (\S+)\) m, \S+ m: (.*)", name).groups()
        column = {"mean of 1 s": "load_1", "mean of 10 s": "load_10"}.get(what, "load_peak")
        loads = []
        for _, panels, _ in measured:
            middle = (panels["x1"] + panels["x2"]) / 2 - float(x), (panels["y1"] + panels["y2"]) / 2 - float(y)
            near = (panels["wall"] == int(wall)) & (middle[0].abs() < 0.006) & (middle[1].abs() < 0.006)
            loads.append(panels.loc[near, column].item() / 1e3)
        assert [float(cell) for cell in (row[3], row[4])] == pytest.approx([min(loads), max(loads)], abs=0.0051)
        found += 1
    assert found > 10
    assert "no design loads: they are of 2 runs" in text(section(root, "Loads on walls"))


def test_it_ends_as_a_sweep_does(made, lemons):
    here, root, _ = made
    (here / "s.toml").write_text(
        'scenario = "room.toml"\nuntil = "left"\n[parameters]\n"population.seed" = [3, 4]\n[measures]\n'
        'pressed = { squeeze = "largest_mean", over = 1, across = "max" }\n'
    )
    command(lemons, "sweep", "s.toml", cwd=here)
    table = pd.read_csv(here / "s.csv", comment="#")
    each = rows(section(root, "Squeeze in each run"))[1:]
    assert [float(row[1]) for row in each] == pytest.approx(list(table["ended"]), abs=0.051)
    assert [float(row[5]) for row in each] == pytest.approx(list(table["pressed"]), abs=0.51)
    # Each person left by one exit.
    by_exit = [row for row in rows(section(root, "Leaving")) if row[0].endswith(": people")]
    assert len(by_exit) == 2 and sum(float(row[2]) for row in by_exit) == pytest.approx(40, abs=1)


def test_the_pdf_has_the_rows_of_the_page_whole(made):
    here, root, _ = made
    reader = pytest.importorskip("pypdf").PdfReader(here / "room.pdf")
    pages = ["".join(part.extract_text().split()) for part in reader.pages]
    squashed = lambda words: "".join(words.split())
    assert reader.metadata.title == "room" and len(pages) > 2
    for heading in root.xpath("//h2"):
        assert any(squashed(text(heading)) in part for part in pages)
    for row in rows(root):
        # No row is on two pages.
        assert any(all(squashed(cell) in part for cell in row) for part in pages), row
    # Each picture is on a page, as curves.
    assert sum(part.get_contents().get_data().count(b" cm\n") for part in reader.pages) >= len(root.xpath("//img"))


def test_names_are_no_markup(lemons, tmp_path):
    evil = "<script>alert('1')</script>&\"%#{x}"
    (tmp_path / "a & <b>.toml").write_text(ROOM.replace("[[6.0, 2.5, 0.9], [3.0, 5.0, 0.8]]", "[[6.0, 2.5, 0.9]]") + f"[decision]\nexits = [{{ name = {json.dumps(evil)}, line = [[7, 1], [7, 4]] }}]\n")
    for output in ("report.html", "report.pdf"):
        command(lemons, "report", "a & <b>.toml", "--seeds", 1, "--until", 2, "-o", output, cwd=tmp_path)
    root = page(tmp_path / "report.html")
    assert text(root.xpath("//h1")[0]) == "a & <b>"
    assert evil.replace('"', '\\"') in text(section(root, "What was assumed"))


def test_what_was_stuck_is_said_at_the_top(lemons, tmp_path):
    (tmp_path / "room.toml").write_text(ROOM)
    done = command(lemons, "report", "room.toml", "--seeds", 2, "--until", 3, cwd=tmp_path)
    notices = [text(of) for of in page(tmp_path / "report.html").xpath("//p[@class='notice']")]
    for seed, notice in zip((3, 4), notices, strict=True):
        assert re.match(rf"Seed {seed}: \d+ of 40 people have not left after 3.00 s \(stopped: the time limit\): \d+, .*…$", notice)
        assert notice in done.stdout


@pytest.mark.parametrize("model", ["straight", "rotational"])
def test_runs_that_do_not_differ_are_no_sample(lemons, tmp_path, model):
    """The outside: tables of two seeds, compared as bytes."""
    (tmp_path / "room.toml").write_text(ROOM.replace("40", "3") + f'[decision]\nmodel = "{model}"\n')
    command(lemons, "crowd", "--scenario", "room.toml", "-o", "T", cwd=tmp_path)
    tables = []
    for seed in (1, 2):
        decision = (tmp_path / "T/decision.toml").read_text()
        (tmp_path / "own.toml").write_text(re.sub(r"(?m)^seed = .*\n", "", decision).replace("model =", f"seed = {seed}\nmodel =", 1))
        command(lemons, "run", "T", "--decision", "own.toml", "--until", 2, "-o", f"{seed}.csv", cwd=tmp_path)
        tables.append([line for line in (tmp_path / f"{seed}.csv").read_text().splitlines() if line[0] != "#"])
    command(lemons, "report", "T", "--seeds", 2, "--until", 2, cwd=tmp_path)
    notices = [text(of) for of in page(tmp_path / "report.html").xpath("//p[@class='notice']")]
    said = any(notice.startswith("All runs are the same: nothing in them depends on the seed.") for notice in notices)
    assert said == (tables[0] == tables[1]) == (model == "straight"), notices


def test_a_report_that_is_stopped_is_not_there(lemons, tmp_path):
    (tmp_path / "room.toml").write_text(ROOM.replace("number = 40", "number = 90"))
    begun = subprocess.Popen([lemons, "report", "room.toml", "--seeds", "1000"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    threads = lambda: [task.joinpath("comm").read_text().strip() for task in Path(f"/proc/{begun.pid}/task").iterdir()]
    # Runs have begun.
    while "sweep" not in threads():
        assert begun.poll() is None
        time.sleep(0.05)
    begun.send_signal(signal.SIGINT)
    try:
        told = begun.communicate(timeout=60)[1]
    finally:
        begun.kill()
    assert "interrupted: nothing was written" in told and begun.returncode == 130
    assert [path.name for path in tmp_path.iterdir()] == ["room.toml"]
