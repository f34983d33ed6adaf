"""People who walk in the lab, in headless Chromium, beside `lemons run` with the same Trial.

    pip install playwright && playwright install chromium
    lab/build.sh && cargo build --release -p lemons-cli
    python benches/lab.py [--people 500,1000,2000,5000] [--seconds 10]

Of each number of people it prints: pictures per second; how much time of the run was shown and was computed in a second;
what a communication step of 0.01 s costs in the page, and in `lemons run`, which writes its table, too.
"""

import argparse
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/lab"))
from visit import LEMONS, MORE, download, lemons, link, plan, seconds

#: [s]
STEP = 0.01
#: [1/m²] People in the room, whose door is 3 m wide.
DENSITY = 2.0

PICTURES = """seconds => new Promise(done => {
    const begun = performance.now();
    let count = 0;
    requestAnimationFrame(function next(now) {
        if (now - begun >= 1000 * seconds) done(count / (now - begun) * 1000);
        count += 1;
        requestAnimationFrame(next);
    });
})"""


def scene(people: int) -> dict[str, object]:
    """They leave a square room by a door."""
    side = round((people / DENSITY) ** 0.5, 1)
    crowd = {
        "number": people, "density": None, "seed": 1, "region": None, "people": {"kind": "survey"}, "men": 0.5, "direction": None, "speed": 0,
        "material": "human_naked", "friction": None, "round": False,
        "room": {"outline": [[0, 0], [side, 0], [side, side], [0, side]], "obstacles": [], "doors": [{"at": [side, side / 2], "width": 3}]},
    }  # fmt: skip
    exit_ = {"name": "door", "line": [[side + 1, side / 2 - 2.5], [side + 1, side / 2 + 2.5]], "polygon": None, "share": None}
    decision: dict[str, object] = {"model": "rotational", "rotational": None, "balance": "none", "push": None, "desired_speed": 1.34, "seed": 1, "exits": [exit_], "goals": [], "agents": {}}
    made = {"base": {"kind": "crowd", **crowd}, "edits": [], "motion": {"kind": "go", "decision": decision}}
    return {"name": f"{people} people", "made": made, "crowd": crowd}


def computed(page: Page) -> float:
    return float(page.locator(".status").inner_text().split()[1])


def measured(page: Page, url: str, people: int, length: float, to: Path) -> str:
    page.goto(link(url, scene(people)))
    page.wait_for_selector("canvas")
    page.get_by_role("row", name=f"People {people}", exact=True).wait_for(timeout=600_000)
    assert len(plan(page)["made"]["motion"]["decision"]["exits"]) == 1
    page.get_by_role("button", name="Play").click()
    # The first steps compile.
    page.wait_for_timeout(2000)
    begun, shown, done = time.monotonic(), seconds(page), computed(page)
    pictures = page.evaluate(PICTURES, length)
    real = time.monotonic() - begun
    shown, done = (seconds(page) - shown) / real, (computed(page) - done) / real
    page.get_by_text("Steps and cost").click()
    cost = page.get_by_role("row", name="Time to compute a step").inner_text().split()[-2]
    page.get_by_role("button", name="Pause").click()
    trial = download(page, "Trial (zip)", to)
    begun = time.monotonic()
    lemons("run", trial, "--until", length, "-o", to / "run.csv")
    run = 1000 * (time.monotonic() - begun) * STEP / length
    return f"{people:6} {pictures:11.1f} {shown:9.2f} {done:9.2f} {cost:>12} {run:15.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", default="500,1000,2000,5000")
    parser.add_argument("--seconds", type=float, default=10.0)
    arguments = parser.parse_args()
    server = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True)
    assert server.stdout
    url = server.stdout.readline().split()[4].rstrip(",")
    try:
        with sync_playwright() as playwright, tempfile.TemporaryDirectory() as to:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            print("people  pictures/s  shown/s  computed/s  step in page [ms]  lemons run [ms]")
            for people in map(int, arguments.people.split(",")):
                page = browser.new_page(viewport={"width": 1280, "height": 860})
                page.add_init_script(MORE)
                print(measured(page, url, people, arguments.seconds, Path(to)), flush=True)
                page.close()
    finally:
        server.send_signal(signal.SIGTERM)
        server.wait()


if __name__ == "__main__":
    main()
