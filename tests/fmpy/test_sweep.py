"""Sweeps: their table, on threads, processes and a cluster; nothing is lost when something is killed."""

import itertools
import json
import math
import os
import signal
import subprocess
import sys
import time
import tracemalloc

import cloudpickle
import numpy as np
import pandas as pd
import pytest
from crowd import REPOSITORY, TRIAL_PUSH, ids_of
from distributed import Client, LocalCluster
from lemons_fmu import Drive, SimulationError, SweepError, local_cluster, simulate, sweep

# Workers of a cluster need not have this file.
cloudpickle.register_pickle_by_value(sys.modules[__name__])

FRICTION = "contact.human_naked.human_naked.KineticFriction"
GRID = {"agent[*].Mass": [60.0, -1.0, 80.0], FRICTION: [0.0, 0.4]}
RUN = {"until": 0.5, "step": 0.05, "progress": False}


@pytest.fixture(scope="module")
def drive():
    return Drive.read(TRIAL_PUSH / "drive.csv", ids_of(TRIAL_PUSH))


@pytest.fixture(scope="module")
def here():
    """A client with two threads of this process."""
    with local_cluster(1, threads=2, processes=False) as cluster, Client(cluster) as client:
        yield client


@pytest.fixture(scope="module")
def one_process():
    """A client with one worker process, whose end is the fault of all points that it has: each is tried alone after that."""

    def forgive_nothing(dask_scheduler):
        dask_scheduler.allowed_failures = 0

    with local_cluster(1) as cluster, Client(cluster) as client:
        client.run_on_scheduler(forgive_nothing)
        yield client


def measure(run):
    return {"x": run.poses[-1, 0, 0], "squeeze": run.squeeze.max(), "contacts": run.contacts[-1, :, 0].sum()}


def stored(path):
    """A table as it is in its file."""
    table = pd.read_csv(path, comment="#")
    return table.astype({"error": object})


def test_the_table(drive, here, tmp_path):
    """The last name varies fastest; a point that fails says why; a point is what `simulate` gives."""
    out = tmp_path / "results" / "table.csv"
    table = sweep(TRIAL_PUSH, GRID, drive, measure, out=out, client=here, **RUN)
    assert list(table) == ["point", *GRID, "x", "squeeze", "contacts", "status", "error"]
    assert table.point.tolist() == list(range(6))
    assert list(zip(*(table[name] for name in GRID))) == list(itertools.product(*GRID.values()))
    assert table.status.tolist() == ["ok", "ok", "failed", "failed", "ok", "ok"]
    assert set(table.error[2:4]) == {"agent[0].Mass=-1.0: must be positive"}
    assert table.error[[0, 1, 4, 5]].isna().all() and table.x[2:4].isna().all()
    for point in (1, 4):
        masses = {f"agent[{i}].Mass": table["agent[*].Mass"][point] for i in range(5)}
        wanted = simulate(TRIAL_PUSH, drive, {**masses, FRICTION: table[FRICTION][point]}, RUN["until"])
        assert table.x[point] == wanted.x.iloc[-5]
        assert table["squeeze"][point] == wanted.normal_force.max()
    assert table["squeeze"].max() > 100.0
    assert [path.name for path in out.parent.iterdir()] == ["table.csv"]
    pd.testing.assert_frame_equal(stored(out), table, check_exact=True)
    as_table = pd.DataFrame(itertools.product(*GRID.values()), columns=list(GRID))
    again = sweep(TRIAL_PUSH, as_table, drive, measure, client=here, **RUN)
    pd.testing.assert_frame_equal(again, table, check_exact=True)


def test_a_finished_sweep_is_not_simulated_again(drive, here, tmp_path):
    def mark(run):
        with open(tmp_path / "marks", "a") as file:
            file.write("x")
        return measure(run)

    marks = tmp_path / "marks"
    first = sweep(TRIAL_PUSH, GRID, drive, mark, out=tmp_path / "out.csv", client=here, **RUN)
    assert marks.stat().st_size == 4
    calls = []
    options = {**RUN, "progress": calls.append}
    again = sweep(TRIAL_PUSH, GRID, drive, mark, out=tmp_path / "out.csv", client=here, **options)
    pd.testing.assert_frame_equal(again, first, check_exact=True)
    assert marks.stat().st_size == 4 and [call.done for call in calls] == [6]
    # Only those that failed, when that is asked for.
    again = sweep(TRIAL_PUSH, GRID, drive, mark, out=tmp_path / "out.csv", client=here, retry_failed=True, **options)
    pd.testing.assert_frame_equal(again, first, check_exact=True)
    assert marks.stat().st_size == 4 and (calls[1].done, calls[-1].done) == (4, 6)


#: How often it was asked.
COUNT = itertools.count()


def test_failures_of_measure_and_drive_are_rows(here):
    def push(crowd):
        drive = np.zeros((5, 3))
        drive[0, 0] = math.nan if crowd.time > 0.2 and crowd["agent[1].Mass"] > 70 else 500.0
        return drive

    def weigh(run):
        if run.poses[-1, 0, 0] > 0 and len(run.times) > 3:
            return {"x": run.poses[-1, 0, 0], "nothing": None, "word": "far"}
        raise LookupError("nobody moved")

    table = sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0, 80.0]}, push, weigh, client=here, **RUN)
    assert table.error[1] == "agent[0].Fp.x = NaN: must be finite"
    assert table.word[0] == "far" and math.isnan(table.nothing[0])
    table = sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, False, weigh, client=here, **RUN)
    assert table.error.tolist() == ["LookupError: nobody moved"]
    table = sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, False, lambda run: {"status": 1}, client=here, **RUN)
    assert "name of another column: 'status'" in table.error[0]
    # A column that other points do not have cannot be added to a table.
    grid = {"agent[1].Mass": [60.0, 80.0]}
    table = sweep(TRIAL_PUSH, grid, False, lambda run: {"a" if run.model else "b": 1.0, **({"c": 2.0} if next(COUNT) else {})}, client=here, **RUN)
    assert sorted(table.status) == ["failed", "ok"] and "and not" in table.error.dropna().iloc[0]


class Unspeakable(Exception):
    def __str__(self):
        sys.exit("no words")


def leave(run):
    sys.exit("enough")


def unspeakable(run):
    raise Unspeakable


def half_a_character(run):
    raise ValueError("\ud800")


@pytest.mark.parametrize(
    "measure, words",
    [
        (leave, "SystemExit: enough"),
        (half_a_character, "ValueError: \\ud800"),
        (unspeakable, "Unspeakable, whose message raises SystemExit"),
        (lambda run: {"x": "\ud800"}, "ValueError: the measure 'x' is not Unicode text: '\\ud800'"),
        (lambda run: {"\ud800": 1.0}, "ValueError: the measure '\\ud800' is not Unicode text: 1.0"),
        (lambda run: None, "TypeError: the measure returned NoneType, not names and numbers"),
        (lambda run: {"x": 10**400}, "OverflowError: int too large to convert to float"),
    ],
    ids=["sys.exit", "message", "no message", "text", "name", "None", "number"],
)
def test_what_a_measure_does_ends_its_point_and_not_the_sweep(here, tmp_path, measure, words):
    def of_one(run):
        return measure(run) if run.poses[0, 1, 0] == 0.2802 else {"x": 1.0}

    grid = {"agent[1].Position.x": [0.279, 0.2801, 0.2802, 0.281]}
    table = sweep(TRIAL_PUSH, grid, False, of_one, client=here, out=tmp_path / "out.csv", **{**RUN, "until": 0.1})
    assert table.status.tolist() == ["ok", "ok", "failed", "ok"]
    assert table.error[2] == words


def test_a_measure_that_interrupts_ends_the_sweep(here):
    def interrupt(run):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0, 70.0]}, False, interrupt, client=here, **{**RUN, "until": 0.1})
    # The workers are still there.
    assert len(sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, False, measure, client=here, **{**RUN, "until": 0.1})) == 1


def test_a_drive_is_read_and_checked_before_any_point_runs(drive, here, tmp_path):
    """By path as by table, in what identifies a sweep, too; what cannot drive a crowd is refused, and nothing is written."""
    grid = {"agent[1].Mass": [60.0, 80.0]}
    wanted = sweep(TRIAL_PUSH, grid, drive, measure, client=here, out=tmp_path / "table.csv", **RUN)
    assert wanted["squeeze"].min() > 100.0
    for name, given in ("path", TRIAL_PUSH / "drive.csv"), ("text", str(TRIAL_PUSH / "drive.csv")):
        table = sweep(TRIAL_PUSH, grid, given, measure, client=here, out=tmp_path / f"{name}.csv", **RUN)
        pd.testing.assert_frame_equal(table, wanted, check_exact=True)
        assert (tmp_path / f"{name}.csv").read_bytes() == (tmp_path / "table.csv").read_bytes()
    pd.testing.assert_frame_equal(sweep(TRIAL_PUSH, grid, None, measure, client=here, **RUN), wanted, check_exact=True)
    assert sweep(TRIAL_PUSH, grid, False, measure, client=here, **RUN)["squeeze"].max() == 0.0
    bad = tmp_path / "bad.csv"
    bad.write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1,1,drive\n")
    other = Drive({9: (np.zeros(1), np.zeros((1, 3)))})
    for given, error in (5, TypeError), ([1, 2, 3], TypeError), (bad, ValueError), (other, ValueError), (np.zeros((4, 3)), ValueError):
        with pytest.raises(error, match="drive"):
            sweep(TRIAL_PUSH, grid, given, measure, client=here, out=tmp_path / "refused.csv", **RUN)
    assert not (tmp_path / "refused.csv").exists()


def test_more_points_than_anybody_waits_for_are_refused_before_they_are_made():
    """They took 24 GB before anything was said."""
    tracemalloc.start()
    try:
        for grid in (
            {"agent[1].Mass": range(10**9)},
            {"agent[1].Mass": np.ones(10**4), "agent[2].Mass": np.ones(10**4)},
            {"agent[1].Mass": [60.0, 70.0], "agent[2].Mass": range(10**7)},
            {f"agent[{k}].Mass": range(10**7) for k in range(3)},  # more than a 64-bit integer holds
        ):
            with pytest.raises(ValueError, match="more than 10000000 points"):
                sweep(TRIAL_PUSH, grid, False, measure, **RUN)
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
    with pytest.raises(ValueError, match="more than 10000000 points"):
        sweep(TRIAL_PUSH, {"agent[1].Mass": itertools.count(60.0)}, False, measure, **RUN)


def test_what_cannot_be_swept_is_refused_at_once(here, tmp_path):
    def refused(error, words, grid, out=None, **options):
        with pytest.raises(error, match=words):
            sweep(TRIAL_PUSH, grid, False, measure, out=out, client=here, **{**RUN, **options})

    refused(SimulationError, "agent.5..Mass: there is no such variable", {"agent[5].Mass": [1.0]})
    refused(SimulationError, "another parameter sets the same", {"agent[1].Mass": [1.0], "crowd.agent[1].Mass": [1.0]})
    refused(SimulationError, "Trials are chosen by their paths", {"Trial": ["Trial_push"]})
    refused(ValueError, "no values", {"agent[1].Mass": []})
    refused(ValueError, "nothing to simulate", {"agent[1].Mass": [60.0]}, until=-1.0)
    refused(ValueError, "agent.1..Mass: values must be all numbers", {"agent[1].Mass": [60.0, "heavy"]})
    refused(TypeError, "agent.1..Mass: must be a list of values, not 60.0", {"agent[1].Mass": 60.0})
    refused(ValueError, "surrogates not allowed", {"OutputDirectory": ["\ud800"]})
    assert not os.path.exists("\ufffd" * 3), "it was simulated with another text"
    refused(ValueError, "'status' cannot be a parameter", {"status": [60.0]})
    out = tmp_path / "out.csv"
    sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, False, measure, out=out, client=here, **RUN)
    refused(SweepError, "table of another sweep: it differs in points", {"agent[1].Mass": [61.0]}, out)
    refused(SweepError, "table of another sweep: it differs in until", {"agent[1].Mass": [60.0]}, out, until=0.6)
    with pytest.raises(SweepError, match="table of another sweep: it differs in drive, measure"):
        sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, np.zeros((5, 3)), lambda run: {}, out=out, client=here, **RUN)
    out.write_text(out.read_text().replace("0,60.0", "0,61.0"))
    refused(SweepError, "out.csv: cannot be used; .*row 1: column agent.1..Mass", {"agent[1].Mass": [60.0]}, out)
    out.write_text("mine\n")
    refused(SweepError, "is not the table of a sweep", {"agent[1].Mass": [60.0]}, out)
    assert out.read_text() == "mine\n"
    out.unlink()
    os.mkfifo(out)
    refused(SweepError, "out.csv: is not a file", {"agent[1].Mass": [60.0]}, out)
    refused(SweepError, "is not a file", {"agent[1].Mass": [60.0]}, tmp_path)


# A sweep whose runs are noted, and wait after 30 of them for a file: on threads of its own process, so that one SIGKILL ends all.
SLOW = """
import os, sys, time
from distributed import Client
from lemons_fmu import local_cluster, sweep

NAME = "contact.human_naked.human_naked.KineticFriction"

def measure(run):
    with open(sys.argv[3], "a") as file:
        file.write("x\\n")
    while os.path.getsize(sys.argv[3]) > 60 and not os.path.exists(sys.argv[5]):
        time.sleep(0.01)
    return {"x": run.poses[-1, 0, 0], "y": run.poses[-1, 1, 1]}

if __name__ == "__main__":
    points = {NAME: [k / 100 for k in range(60)], "agent[1].Mass": [70.0]}
    with local_cluster(1, processes=False) as cluster, Client(cluster) as client:
        table = sweep(sys.argv[1], points, False, measure, until=0.1, out=sys.argv[2], client=client, progress=False)
    table.to_pickle(sys.argv[4])
"""


@pytest.mark.long
def test_a_killed_sweep_goes_on_and_gives_the_same_table(tmp_path):
    script = tmp_path / "slow.py"
    script.write_text(SLOW)

    def start(name, out="out.csv"):
        files = [tmp_path / each for each in (out, name, f"{name}.pickle", "go on")]
        return subprocess.Popen([sys.executable, script, TRIAL_PUSH, *files])

    def finished():
        return max(0, len(out.read_text().splitlines()) - 2) if out.exists() else 0

    out = tmp_path / "out.csv"
    killed = start("first")
    while finished() < 2:
        assert killed.poll() is None
        time.sleep(0.02)
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    kept = finished()
    assert 0 < kept < 60
    (tmp_path / "go on").touch()
    assert start("second").wait() == 0
    assert len((tmp_path / "second").read_text().split()) == 60 - kept, "a finished point was simulated again"
    assert start("third", "whole.csv").wait() == 0
    table, wanted = (pd.read_pickle(tmp_path / f"{name}.pickle") for name in ("second", "third"))
    pd.testing.assert_frame_equal(table, wanted, check_exact=True)
    assert (table.status == "ok").all() and len(table) == 60 and table.x.notna().all()
    assert out.read_bytes() == (tmp_path / "whole.csv").read_bytes()


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two workers as examples/sweep_cluster.md starts them, without a nanny that would start them again."""
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    file = tmp_path / "scheduler.json"
    command = [sys.executable, "-m", "dask"]
    loopback = ["--host", "127.0.0.1", "--no-dashboard"]
    started = [subprocess.Popen([*command, "scheduler", *loopback, "--port", "0", "--scheduler-file", file], env=environment)]
    worker = [*command, "worker", "--host", "127.0.0.1", "--no-dashboard", "--no-nanny", "--nthreads", "1", "--scheduler-file", file]
    started += [subprocess.Popen([*worker, "--local-directory", tmp_path], env=environment) for _ in range(2)]
    try:
        while not file.exists():
            assert started[0].poll() is None
            time.sleep(0.05)
        with Client(scheduler_file=str(file), timeout="1200s") as client:
            client.wait_for_workers(2, timeout=1200)
            yield json.loads(file.read_text())["address"], [process.pid for process in started[1:]]
    finally:
        for process in started:
            process.kill()
            process.wait()


@pytest.mark.long
def test_a_killed_worker_loses_no_point(drive, here, cluster, tmp_path):
    address, workers = cluster
    begun = tmp_path / "begun"
    begun.mkdir()

    def slow(run):
        # Not before both of them have points.
        (begun / str(os.getpid())).touch()
        while len(list(begun.iterdir())) < 2:
            time.sleep(0.01)
        return {**measure(run), "process": str(os.getpid())}

    seen = []

    def kill(progress):
        seen.append(progress.done)
        if progress.done >= 20 and len(workers) == 2:
            os.kill(workers.pop(), signal.SIGKILL)

    grid = {FRICTION: np.linspace(0, 1, 40), "agent[1].Mass": [50.0, -1.0]}
    table = sweep(TRIAL_PUSH, grid, drive, slow, client=address, **{**RUN, "progress": kill})
    assert seen[-1] == 80 and len(workers) == 1, "no worker was killed"
    wanted = sweep(TRIAL_PUSH, grid, drive, measure, client=here, **RUN)
    pd.testing.assert_frame_equal(table.drop(columns="process"), wanted, check_exact=True)
    assert str(workers[0]) in set(table.process)


@pytest.mark.long
@pytest.mark.parametrize("end", [lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: os._exit(3)], ids=["kill", "_exit"])
def test_a_point_that_kills_its_worker_is_a_row(one_process, end):
    def deadly(run):
        if run.poses[0, 1, 0] > 0.28:
            end()
        return {"x": run.poses[-1, 0, 0]}

    places = np.full(8, 0.279)
    places[5] = 0.2801
    table = sweep(TRIAL_PUSH, {"agent[1].Position.x": places}, False, deadly, client=one_process, **{**RUN, "until": 0.1})
    assert table.status.tolist() == ["ok"] * 5 + ["failed"] + ["ok"] * 2
    assert table.error[5] == "the worker process ended several times while it simulated this point"


@pytest.mark.long
def test_workers_that_are_gone_are_started_again(one_process):
    """Dask does not: the sweep waited for ever."""
    closed, workers = [], one_process.cluster

    def close(progress):
        if progress.done >= 3 and not closed:
            (worker,) = workers.workers.values()
            workers.sync(worker.close)
            closed.append(worker)

    grid = {"agent[1].Mass": np.linspace(60, 80, 40)}
    table = sweep(TRIAL_PUSH, grid, False, measure, client=one_process, **{**RUN, "progress": close})
    assert closed and list(workers.workers.values()) != closed
    assert (table.status == "ok").all() and len(table) == 40


def test_a_sweep_that_nobody_works_for_ends(monkeypatch):
    monkeypatch.setattr(sys.modules["lemons_fmu.cluster"], "DESERTED", 1.0)
    with LocalCluster(n_workers=0, processes=False, dashboard_address=None) as nobody, Client(nobody) as client:
        with pytest.raises(SweepError, match="no worker for 1 s; 12 points are open: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, …"):
            sweep(TRIAL_PUSH, {"agent[1].Mass": np.linspace(60, 80, 12)}, False, measure, client=client, **RUN)


LIMIT = 1.0


def scaled(value, by=1.0):
    return value * by


def within(run):
    return {"x": scaled(run.poses[-1, 0, 0]) * LIMIT}


def test_whatever_a_measure_computes_with_belongs_to_the_sweep(here, tmp_path, monkeypatch):
    """Only its own text did: the table of before was returned."""

    def around(factor, by=1.0):
        def inside(run, by=by):
            return {"x": run.poses[-1, 0, 0] * factor * by}

        return inside

    def swept(given, drive=False):
        options = {"out": tmp_path / "out.csv", "client": here, **RUN}
        return sweep(TRIAL_PUSH, {"agent[1].Mass": [60.0]}, drive, given, **options)["x"][0]

    def refused(given, drive=False, what="measure"):
        with pytest.raises(SweepError, match=f"it differs in {what}"):
            swept(given, drive)
        (tmp_path / "out.csv").unlink()

    own = swept(around(1.0))
    assert swept(around(1.0)) == own
    refused(around(2.0))
    swept(around(1.0))
    refused(around(1.0, 2.0))
    assert swept(within) == swept(within) == own
    this = sys.modules[__name__]
    for owner, name, value in (this, "LIMIT", 2.0), (scaled, "__defaults__", (3.0,)), (this, "scaled", lambda value: 4.0 * value):
        with monkeypatch.context() as changed:
            changed.setattr(owner, name, value)
            refused(within)
        swept(within)
    (tmp_path / "out.csv").unlink()

    def pushed(force):
        return lambda crowd: np.full((5, 3), force)

    swept(within, pushed(0.0))
    assert swept(within, pushed(0.0)) == own
    refused(within, pushed(1.0), "drive")


NAMED = """
from lemons_fmu.drive import function_identity

WORDS = {"left", "right", "front", "back"}

def helper(value):
    return measure if value is None else [word for word in WORDS]

class Counted:
    def __init__(self, known):
        self.known = known
    def __call__(self, run):
        return helper(self.known)

def measure(run):
    return {"x": helper(run), "y": Counted({"a", "b", "c"})(run)}

print(function_identity(measure), function_identity(Counted({"a", "b", "c"})), function_identity(lambda run: measure(run)))
"""


def test_the_identity_of_a_function_is_the_same_in_every_process(tmp_path):
    """Functions that call each other, classes, and sets, whose order differs between processes."""
    (tmp_path / "named.py").write_text(NAMED)
    run = [sys.executable, tmp_path / "named.py"]
    seen = {subprocess.run(run, check=True, capture_output=True, env={**os.environ, "PYTHONHASHSEED": seed}).stdout for seed in "123"}
    assert len(seen) == 1 and seen.pop().count(b"sha256") == 3


def example(script, directory, *arguments):
    command = [sys.executable, REPOSITORY / "examples" / script, *arguments]
    return subprocess.run(command, cwd=directory, capture_output=True, text=True, env={**os.environ, "TMPDIR": str(directory)})


@pytest.mark.long
def test_sweep_push(tmp_path):
    done = example("sweep_push.py", tmp_path, TRIAL_PUSH, "--out", "results", "--values", "3")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "sweep_push.png").stat().st_size > 20_000
    table = stored(tmp_path / "results" / "peak_1200.csv")
    assert (table.status == "ok").all() and table.reach.between(1, 5).all() and table.speed.between(0.5, 6).all()
    left = sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith("dask"))
    assert left == ["results", "sweep_push.png"]


@pytest.mark.long
def test_calibrate(lemons, shared, tmp_path):
    """A small one: it is no worse than what it starts from, and says what it does not know."""
    few = ["--points", "32", "--starts", "1", "--searches", "1", "--profile", "5", "--evaluations", "1"]
    done = example("calibrate.py", tmp_path, shared / "data" / "push_wed", *few)
    assert done.returncode == 0, done.stderr
    for said in ("0 of 32 points", "1 of 1 searches", "20 of 20 searches", "64 of 64 points"):  # it was silent for minutes
        assert said in done.stderr
    rows = {line[:22].strip(): line[22:].split() for line in done.stdout.splitlines()}
    paper, fit = map(float, rows["mean"][:2])
    assert paper == pytest.approx(0.0566, abs=0.001) and fit < paper
    assert float(rows["relaxation time [s]"][0]) == pytest.approx(0.222, abs=0.001)
    assert (tmp_path / "calibration.png").stat().st_size > 20_000


def test_intervals_of_a_profile(monkeypatch):
    monkeypatch.syspath_prepend(REPOSITORY / "examples")
    from calibrate import effective_number, interval

    values = np.linspace(-1, 1, 21)
    (_, low), (_, high) = interval(values, values**2, 0.25)
    assert [math.log(low), math.log(high)] == pytest.approx([-0.5, 0.5], abs=0.01)
    assert [sign for sign, _ in interval(values, np.maximum(values, 0), 0.25)] == ["<", ""]
    # Of an autoregressive series with coefficient a, (1 - a) / (1 + a) of the numbers are effective.
    noise = np.random.default_rng(1).normal(size=(20, 2000))
    series = np.zeros_like(noise)
    for k in range(1, 2000):
        series[:, k] = 0.9 * series[:, k - 1] + noise[:, k]
    assert effective_number(series) == pytest.approx(20 * 2000 / 19, rel=0.25)
