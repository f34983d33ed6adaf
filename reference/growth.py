"""How time and memory of LEMONS-FMU grow with the crowd, on one core: a table, and a figure.

    python reference/growth.py [--people 1000 10000 100000 1000000] [--draw docs/reference_growth.svg]

The crowd is that of speed.py: people of five disks of `human_soft`, six per m2, each of whom pushes with up to 500 N in a direction of its own, in
steps of a seventh of a frame. `lemons crowd` makes a thousand in a box; a larger crowd is this box again and again, in one room, so it has the same gaps. Each size
is a process of its own, `lemons run`. What it needs before its first row is reading; the rest is the steps, and the writing of two rows. Memory is
its peak (VmHWM). All sizes have 13 frames of 1/60 s, since later ones have more contacts. Then each crowd is packed as an FMU. A million people need
18 GB of memory.
"""

import argparse
import itertools
import math
import os
import re
import select
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

from speed import crowd

TILE, STEP, FRAME = 1000, 1 / 420, 1 / 60  # [s]


def tiled(one, many, copies):
    """Writes the Trial `one` `copies` times side by side as `many`, person by person: a million are a gigabyte of XML."""
    columns = next(c for c in range(math.isqrt(copies), 0, -1) if copies % c == 0)
    shutil.copytree(one, many)
    walls = (one / "static/Geometry.xml").read_text()
    side = float(re.search(r'Lx="([^"]+)"', walls)[1])
    wide, high = side * columns, side * (copies // columns)
    for old, new in (f'Lx="{side}"', f'Lx="{wide}"'), (f'Ly="{side}"', f'Ly="{high}"'), (f'"{side},', f'"{wide},'), (f',{side}"', f',{high}"'):
        walls = walls.replace(old, new)
    (many / "static/Geometry.xml").write_text(walls)
    for name in "static/Agents.xml", "dynamic/AgentDynamics.xml":
        people = re.findall("<Agent .*?</Agent>", (one / name).read_text(), re.DOTALL)
        with (many / name).open("w") as file:
            file.write("<Agents>\n")
            for copy, (k, text) in itertools.product(range(copies), enumerate(people)):
                row, column = divmod(copy, columns)
                text = re.sub(r'\bId="[^"]+"', f'Id="{TILE * copy + k}"', text, count=1)
                if x := re.search(r'<Kinematics Position="([^,]+),([^"]+)"', text):
                    text = text.replace(x[0], f'<Kinematics Position="{float(x[1]) + column * side!r},{float(x[2]) + row * side!r}"')
                file.write(text + "\n")
            file.write("</Agents>\n")


def process(*command):
    """Processor time [s] until it writes its first row and of all, the peak of memory [byte], and its error."""
    begun, peak, done, command = [], 0, 0, [os.environ.get("LEMONS", "lemons"), *map(str, command)]
    with tempfile.TemporaryFile() as errors, subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors) as child:
        while not done:
            if select.select([child.stdout], [], [], 0.002)[0] and os.read(child.stdout.fileno(), 1 << 20):
                begun.append(begun[0] if begun else int(Path(f"/proc/{child.pid}/schedstat").read_text().split()[0]) / 1e9)
            # The kernel's ru_maxrss would count Python, which started it.
            found = re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{child.pid}/status").read_text())
            peak = 1024 * int(found[1]) if found else peak
            done, child.returncode, used = os.wait4(child.pid, os.WNOHANG)
        errors.seek(0)
        failed = errors.read().decode().strip().splitlines()[-1] if child.returncode else ""
    return (begun or [0])[0], used.ru_utime + used.ru_stime, peak, failed


def measure(trial, people, frames, rounds):
    """A row, per person: processor time [us] of reading and of a step, and memory [byte]."""
    command, rows = ["run", trial, "--step", repr(FRAME), "--set", f"TimeStepMechanical={STEP}", "--threads", 1, "--every", frames, "-o", "-"], []
    for _ in range(rounds):
        reading, total, peak, failed = process(*command, "--until", repr(frames * FRAME))
        if failed or not reading:
            raise SystemExit(f"{people} people: {failed or 'no output'}")
        rows.append([1e6 * reading / people, 1e6 * (total - reading) / (frames * FRAME / STEP) / people, peak / people])
    return [statistics.median(column) for column in zip(*rows)]


def draw(rows, path):
    import matplotlib
    import matplotlib.pyplot as plt

    matplotlib.rcParams |= {"svg.hashsalt": "lemons", "svg.fonttype": "none", "font.size": 9}
    figure, panels = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
    people, _, *columns = zip(*rows)
    for panel, values, words in zip(panels, columns, ("processor time per person and step [µs]", "peak of memory per person [byte]")):
        panel.loglog(people, values, "-o", color="#4477aa")
        panel.set(xlabel="people", ylabel=words, ylim=(10 ** math.floor(math.log10(min(values))), 10 ** math.ceil(math.log10(max(values)))))
        panel.grid(alpha=0.3)
    # The picture says what it was drawn from.
    table = "people,reading,step,memory\n" + "".join(",".join(f"{number:.4g}" for number in row) + "\n" for row in rows)
    figure.savefig(path, metadata={"Date": None, "Description": table})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--people", type=int, nargs="+", default=[1000, 10_000, 100_000, 1_000_000])
    parser.add_argument("--draw", type=Path)
    arguments, rows = parser.parse_args(), []
    if wrong := [people for people in arguments.people if people < TILE or people % TILE]:
        parser.error(f"--people {wrong[0]}: must be a multiple of {TILE}")
    print("people; per person: processor time [us] of reading and of a step, peak of memory [byte]; packed as FMU", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        one = crowd(Path(folder), "human_soft", TILE)
        for people in arguments.people:
            trial = Path(folder, str(people))
            tiled(one, trial, people // TILE)
            # A large crowd is its own mean, and takes minutes.
            rows.append([people, *measure(trial, people, 13, 5 if people <= 10_000 else 1)])
            print("{:8} {:8.1f} {:8.3f} {:8.0f}".format(*rows[-1]), flush=True)
            fmu = Path(folder, "crowd.fmu")
            for version in 2, 3:
                _, cost, peak, failed = process("pack", trial, "--fmi", version, "--force", "-o", fmu)
                print(f"         FMI {version}: {cost:.1f} s, {peak / 1e6:.0f} MB, {failed or f'{fmu.stat().st_size / 1e6:.0f} MB'}", flush=True)
    if arguments.draw:
        draw(rows, arguments.draw)


if __name__ == "__main__":
    main()
