"""Loaded again and again by one process, each time from files that were unzipped anew: nothing is left behind."""

import subprocess
import sys

import pytest
from crowd import REPOSITORY, TRIAL_DOOR

TIMES = 300  # how many of glibc's 1024 keys for thread-local data are left is counted

LIVES = """
import ctypes, os, shutil, sys, zipfile
from pathlib import Path
sys.path.insert(0, sys.argv[4])
from crowd import Crowd

fmu, place, times = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
libc = ctypes.CDLL(None)


def keys():
    # How many keys for thread-local data can still be made.
    made, key = [], ctypes.c_uint()
    while libc.pthread_key_create(ctypes.byref(key), None) == 0:
        made.append(key.value)
    for key in made:
        libc.pthread_key_delete(ctypes.c_uint(key))
    return len(made)


def resources():
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    files = len(os.listdir("/proc/self/fd"))
    mapped = Path("/proc/self/maps").read_text().count(str(place))
    return int(status["VmRSS"].split()[0]), int(status["Threads"]), keys(), files, mapped


for k in range(times):
    directory = place / str(k)
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(directory)
    crowd = Crowd(directory).instantiate()
    for name, value in [("TimeStepMechanical", 1e-4), ("agent[0].Fp.x", 700.0)]:
        if name in crowd.variables and crowd.variables[name].causality != "output":
            crowd[name] = value
    crowd.initialize().step(0.02)
    crowd.fmu.terminate()
    crowd.free()
    shutil.rmtree(directory)
    if k in (times // 3, times - 1):
        print(*resources())
"""


@pytest.mark.parametrize("which", ["crowd", "decision", "summary"])
def test_nothing_is_left_behind(push_fmu, pack, decide, tmp_path, which, row):
    fmu, times = push_fmu, TIMES
    if which == "summary":
        fmu, times = pack(TRIAL_DOOR, options=["--interface", "summary"]), TIMES // 3
    if which == "decision":
        fmu, times = decide(), TIMES // 5
    command = [sys.executable, "-c", LIVES, fmu, tmp_path / "lives", str(times), REPOSITORY / "tests" / "fmpy"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    before, after = ([int(number) for number in line.split()] for line in done.stdout.splitlines())
    assert after[1:] == before[1:], "threads, keys, open files, mapped files"
    assert after[4] == 0, "a library stays loaded"
    # A leaked instance in each life would be more than 20 kB each.
    lives = times * 2 // 3
    assert after[0] - before[0] < 10 * lives, f"{after[0] - before[0]} kB more after {lives} lives"
    tried = f"{which}: unzip, load, instantiate, step, free, unload: {times} times in one process"
    row("fmpy", tried, "no growth in memory, threads, keys or files")
