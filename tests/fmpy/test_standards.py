"""docs/standards.md is what examples/standards/book.py makes: its rows are those of tests.toml, and the verdicts are those of today."""

import importlib.util

import pages
import pytest
from crowd import REPOSITORY

pytest.importorskip("scipy")
SPEC = importlib.util.spec_from_file_location("book", REPOSITORY / "examples" / "standards" / "book.py")
book = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(book)
#: Scenes of a few seconds. The others take up to minutes.
QUICK = ["corridor", "corner", "speeds", "routes", "wheelchair", "closing_exit", "groups"]


def section(standard):
    """The rows of a standard in the page: cells."""
    name = book.TABLE["standards"][standard]["name"]
    text = pages.text_of("docs/standards.md").split(f"## {name}\n")[1].split("\n## ")[0]
    return [line for line in text.splitlines() if line.startswith("| ") and not line.startswith("| test |")]


def test_every_row_is_in_the_page_with_a_verdict():
    for standard in book.TABLE["standards"]:
        rows = [row for row in book.rows() if row["standard"] == standard]
        lines = section(standard)
        assert len(lines) == len(rows)
        for row, line in zip(rows, lines):
            cells = pages.cells(line)
            assert cells[0] == f"{row['id']}: {row['title']}"
            assert cells[-1].split("**")[1] in book.VERDICTS
            if "scene" not in row:
                assert cells[3:] == [row["why"], f"**{row['verdict']}**"]


def test_every_test_that_we_know_is_there():
    """What is asked for is answered, in words if not by a run."""
    ids = {name: [row["id"] for row in book.rows() if row["standard"] == name] for name in book.TABLE["standards"]}
    assert set(ids["rimea"]) == {*map(str, range(1, 17))} - {"12"} | {"12a", "12b", "12c", "12d"}
    assert set(ids["iso"]) == set(map(str, range(1, 20)))
    assert set(ids["imo"]) == set(map(str, range(1, 13)))
    parts = {1: 1, 2: 10, 3: 3, 4: 1, 5: 2}
    assert set(ids["nist"]) == {f"Verif.{part}.{k}" for part, count in parts.items() for k in range(1, count + 1)}


def test_each_row_says_how_it_is_judged():
    for row in book.rows():
        if "scene" in row:
            assert row["scene"] in book.scenes.SCENES and row["judge"], row
            assert all({"min", "max"} & limit.keys() for limit in row["judge"]), row
        else:
            assert row["verdict"] == "cannot" and row["why"], row
    shown = set(book.TABLE["scenes"])
    assert shown == {row["scene"] for row in book.rows() if "scene" in row} == set(book.scenes.SCENES)


@pytest.mark.parametrize("value, verdict", [(39.0, "failed"), (40.0, "passed"), (41.0, "failed"), (float("nan"), "failed")])
def test_a_number_outside_of_the_limits_fails(value, verdict):
    (row,) = (row for row in book.rows() if row["standard"] == "imo" and row["id"] == "1")
    assert book.judged(row, {"time": value})[0] == verdict


@pytest.mark.long
@pytest.mark.parametrize("scene", QUICK)
def test_a_quick_scene_gives_what_the_page_says(lemons, tmp_path, monkeypatch, scene):
    monkeypatch.setenv("LEMONS", str(lemons))
    results, compared = {}, 0
    for row in book.rows():
        if row.get("scene") == scene:
            if book.key(row) not in results:
                results[book.key(row)] = {name: book.rounded(value) for name, value in book.run(row, tmp_path).items()}
            line = "| " + " | ".join(book.row_of(row, results)) + " |"
            assert line in section(row["standard"]), f"docs/standards.md is old: python examples/standards/book.py. Today:\n{line}"
            compared += 1
    assert compared
