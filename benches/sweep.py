"""What a sweep adds to the engine: 1000 pushes through a row of five people by `lemons_fmu.sweep`.

    pip install './python[sweep]'
    cargo build --release --example engine_direct
    python benches/sweep.py [--points 1000]

Every point is the same: the paper's five people and the push of resources/Trial_push/drive.csv, 4.5 s at a mechanical step
of 1e-5 s and a communication step of 0.05 s. The engine alone is `examples/engine_direct.rs` on the same Trial, a process
for each run, one after another and two at a time: by so much the machine itself gains from its second core. Compared is
processor time (the machine may be busy); all are measured in turns in one go, and medians count. Two workers are compared
with one by the clock on the wall, which a busy machine spoils.
"""

import argparse
import contextlib
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from multiprocessing.pool import ThreadPool

import psutil
from distributed import Client
from lemons_fmu import Drive, Trial, local_cluster, sweep

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target").resolve() / "release"
UNTIL, STEP, MECHANICAL = 4.5, 0.05, 1e-5  # s
STEPS = round(UNTIL / MECHANICAL)


def measure(run):
    return {"reach": run.poses[-1, :, 0].max(), "squeeze": run.peak_squeeze.max()}


def engine(trial, at_once, runs):
    """Wall time and processor time of that many runs [s]."""
    command = [TARGET / "examples" / "engine_direct", trial, "--steps", str(round(UNTIL / STEP)), "--drive", trial / "drive.csv"]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with ThreadPool(at_once) as pool:
        pool.map(lambda _: subprocess.run(command, check=True, stdout=subprocess.DEVNULL), range(runs), chunksize=1)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def of_workers():
    """Of the process that this runs in: processor time [s], memory [bytes]."""
    process = psutil.Process()
    return sum(process.cpu_times()[:2]), process.memory_info().rss


def run(client, trial, drive, points):
    """Wall time, processor time of the workers [s], their memory before and after [bytes]."""
    table = {"TimeStepMechanical": [MECHANICAL] * points}
    before, start = client.run(of_workers), time.perf_counter()
    result = sweep(trial, table, drive, measure, until=UNTIL, step=STEP, client=client, progress=False)
    wall, after = time.perf_counter() - start, client.run(of_workers)
    assert (result.status == "ok").all() and result["squeeze"].nunique() == 1
    each = {process: (after[process], before[process]) for process in after}
    return wall, sum(a[0] - b[0] for a, b in each.values()), max(b[1] for _, b in each.values()), max(a[1] for a, _ in each.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=1000, metavar="N")
    parser.add_argument("--turns", type=int, default=5, metavar="N", help="so often in turns; default 5")
    arguments = parser.parse_args()
    if not (TARGET / "examples" / "engine_direct").exists():
        sys.exit(f"{TARGET}/examples/engine_direct is missing: see the beginning of {__file__}")
    points = max(1, arguments.points // arguments.turns)

    with tempfile.TemporaryDirectory() as scratch:
        trial = pathlib.Path(shutil.copytree(ROOT / "resources" / "Trial_push", pathlib.Path(scratch) / "Trial"))
        times = trial / "Parameters.xml"
        times.write_text(times.read_text().replace('"2e-6"', f'"{MECHANICAL!r}"'))
        drive = Drive.read(trial / "drive.csv", Trial(trial).ids)

        ways = {"1 process": (1, 1, True), "2 processes": (2, 1, True), "1 thread": (1, 1, False), "2 threads": (1, 2, False)}
        engines = {"engine alone": 1, "two at a time": 2}
        alone, seen = {name: [] for name in engines}, {name: [] for name in ways}
        with contextlib.ExitStack() as stack:
            clients = {}
            for name, (workers, threads, processes) in ways.items():
                cluster = stack.enter_context(local_cluster(workers, threads=threads, processes=processes))
                clients[name] = stack.enter_context(Client(cluster))
                run(clients[name], trial, drive, 4)  # loads all modules
            for _ in range(arguments.turns):
                for name, at_once in engines.items():
                    alone[name].append(engine(trial, at_once, points))
                for name, client in clients.items():
                    seen[name].append(run(client, trial, drive, points))

    bare = statistics.median(each[1] for each in alone["engine alone"]) / points
    print(f"{points * arguments.turns} pushes each, {STEPS} mechanical steps of 5 agents; medians of {arguments.turns} turns\n")
    print(f"{'':14} {'processor':>12} {'ns per agent':>13} {'of the':>8} {'wall':>9} {'x of one':>9}  memory of a process")
    print(f"{'':14} {'per push':>12} {'and step':>13} {'engine':>8} {'per push':>9} {'worker':>9}  first and last")
    for name, runs in (alone | seen).items():
        one = "engine alone" if name in alone else "1 process" if "process" in name else "1 thread"
        processor = statistics.median(each[1] for each in runs) / points
        wall = statistics.median(each[0] for each in runs) / points
        faster = statistics.median(a[0] / b[0] for a, b in zip((alone | seen)[one], runs))
        memory = f"{runs[0][2] / 1e6:.0f} and {runs[-1][3] / 1e6:.0f} MB" if name in seen else ""
        share = f"{100 * bare / processor:.0f} %"
        print(
            f"{name:14} {1e3 * processor:9.1f} ms {1e9 * processor / STEPS / 5:13.1f} {share:>8} {1e3 * wall:6.1f} ms {faster:9.2f}  {memory}"
        )


if __name__ == "__main__":
    main()
