"""Files that the page takes and gives: dropped zips, long tables, movies."""

import struct
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Page, expect
from visit import download, fill, held, make, play_until, rows, seconds, tab, wait

#: Elements of Matroska that hold others: EBML header, segment, information, tracks, track, video, cluster, group.
HOLDING = {0x1A45DFA3, 0x18538067, 0x1549A966, 0x1654AE6B, 0xAE, 0xE0, 0x1F43B675, 0xA0}
SEGMENT, CLUSTER, TIMESTAMP, SIMPLE_BLOCK, BLOCK = 0x18538067, 0x1F43B675, 0xE7, 0xA3, 0xA1
DOC_TYPE, TIMESTAMP_SCALE, CODEC, WIDTH, HEIGHT, DURATION = 0x4282, 0x2AD7B1, 0x86, 0xB0, 0xBA, 0x4489


def elements(data: bytes, start: int = 0, end: int | None = None) -> Iterator[tuple[int, bytes]]:
    """Those of an EBML document, one after the other, as RFC 8794 has them. What follows one of unknown size is
    read as if it were in it."""
    at, end = start, len(data) if end is None else end
    while at < end:
        long = 9 - data[at].bit_length()
        name = int.from_bytes(data[at : at + long], "big")
        at += long
        long = 9 - data[at].bit_length()
        size = int.from_bytes(data[at : at + long], "big") - (1 << 7 * long)
        at += long
        unknown = size == (1 << 7 * long) - 1
        assert unknown or at + size <= end, (hex(name), at, size, end)
        yield name, b"" if name in HOLDING else data[at : at + size]
        if name not in HOLDING:
            at += size
        elif not unknown:
            yield from elements(data, at, at + size)
            at += size


def test_a_movie_lasts_as_long_as_the_run(page: Page, tmp_path: Path) -> None:
    make(page, 3, 300, 300)
    play_until(page, 0.6)
    tab(page, "Take away")
    page.get_by_label("Pace").select_option(label="0.1 ×")
    page.get_by_role("button", name="Movie (WebM)").click()
    # At this pace it has six seconds; it can be stopped.
    page.get_by_label("Take away").get_by_role("button", name="Stop").click()
    expect(page.get_by_text("Stopped.")).to_be_visible()
    page.get_by_label("Pace").select_option(label="0.5 ×")
    scale, cluster, duration, times = 0, 0, 0.0, []
    kinds: dict[int, str] = {}
    sizes: dict[int, int] = {}
    for name, content in elements(download(page, "Movie (WebM)", tmp_path).read_bytes()):
        number = int.from_bytes(content, "big")
        if name in (DOC_TYPE, CODEC):
            kinds[name] = content.rstrip(b"\0").decode()
        elif name in (WIDTH, HEIGHT):
            sizes[name] = number
        elif name == TIMESTAMP_SCALE:
            scale = number
        elif name == DURATION:
            (duration,) = struct.unpack(">d", content)
        elif name == TIMESTAMP:
            cluster = number
        elif name in (SIMPLE_BLOCK, BLOCK):
            # After the number of its track; the picture follows it and the flags.
            assert content[0] == 0x81 and len(content) > 4
            times.append((cluster + int.from_bytes(content[1:3], "big", signed=True)) * scale / 1e9)
    assert kinds[DOC_TYPE] == "webm" and kinds[CODEC] in ("V_VP8", "V_VP9")
    box = page.locator("canvas").first.bounding_box()
    assert box and sizes[WIDTH] >= 0.9 * box["width"] and sizes[HEIGHT] >= 0.9 * box["height"], (sizes, box)
    # Thirty pictures a second, however slow the machine is; the last one stays.
    assert len(times) > 36 and all(abs(time - k / 30) < 1e-3 for k, time in enumerate(times[:-1])), times
    assert abs(duration * scale / 1e9 - times[-2] - 0.25) < 2e-3, (duration, scale, times)


def test_a_long_table_is_stopped_and_the_page_goes_on(page: Page, tmp_path: Path) -> None:
    make(page, 60, 400, 400)
    play_until(page, 0.2)
    tab(page, "Take away")
    table = page.get_by_role("button", name="Trajectories (CSV)")
    # While a run plays, this number follows it, but not while somebody writes there.
    page.get_by_role("button", name="Play").click()
    field = page.get_by_role("spinbutton", name="Until")
    field.press("Control+a")
    begun = seconds(page)
    wait(page, lambda: seconds(page) > begun + 0.3)
    page.keyboard.type("5000", delay=100)
    expect(field).to_have_value("5000")
    field.press("Enter")
    page.get_by_role("button", name="Pause").click()
    expect(field).to_have_value("5000")
    table.click()
    expect(page.get_by_role("alert")).to_contain_text("the table is too large")
    # Half a minute of work.
    fill(page, "Until", 300)
    table.click()
    expect(page.get_by_text("The run is computed again, step")).to_be_visible()
    expect(table).to_be_disabled()
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_text("Stopped. What was there before is shown from its start.")).to_be_visible()
    expect(page.locator(".time")).to_have_text("0.00 s")
    expect(table).to_be_enabled()
    expect(page.get_by_role("alert")).to_have_count(0)
    # The same people, and the worker is a new one: they run, and their table is made.
    play_until(page, 0.3)
    poses = rows(download(page, "Trajectories (CSV)", tmp_path))
    assert len({row["id"] for row in poses}) == 60 and 0.3 <= float(poses[-1]["t"]) < 10


def test_a_zip_is_opened_where_it_is_dropped(page: Page, tmp_path: Path) -> None:
    trial = download(page, "Trial (zip)", tmp_path)
    make(page, 3, 300, 300)

    def drop(name: str, content: bytes) -> None:
        files = page.evaluate_handle(
            """([name, content]) => {
                const data = new DataTransfer();
                data.items.add(new File([new Uint8Array(content)], name));
                return data;
            }""",
            [name, list(content)],
        )
        hint = page.get_by_text("Drop a zip or a folder")
        page.dispatch_event("canvas", "dragover", {"dataTransfer": files})
        expect(hint).to_be_visible()
        page.dispatch_event("canvas", "drop", {"dataTransfer": files})
        expect(hint).to_have_count(0)

    drop("holiday.zip", b"no zip")
    expect(page.get_by_role("alert")).to_contain_text("holiday.zip: it is no zip")
    expect(page.get_by_role("row", name="People 3")).to_be_visible()
    drop("mine.zip", trial.read_bytes())
    expect(page.get_by_text('"mine.zip": 5 people')).to_be_visible()
    expect(page.get_by_role("row", name="People 5")).to_be_visible()
    expect(page.get_by_role("alert")).to_have_count(0)
    # It is the same Trial, with its drive.
    before = held(trial)
    assert "drive.csv" in before and held(download(page, "Trial (zip)", tmp_path)) == before
    tab(page, "Start")
    page.get_by_role("list", name="Your scenes").get_by_role("button", name="A crowd").first.click()
    expect(page.get_by_role("row", name="People 3")).to_be_visible()
