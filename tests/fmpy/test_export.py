"""What `lemons export` writes, read by those it is for: PedPy, JuPedSim, and the FMU itself."""

import os
import pty
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH, bits, ids_of, push_drive, read_table, write_trial
from lemons_fmu import CommandError, Crowd, crowd, export
from test_examples import run as run_example


@pytest.fixture
def pedpy():
    if sys.version_info < (3, 11):
        pytest.skip("PedPy needs Python 3.11")
    return __import__("pedpy")


@pytest.fixture
def jupedsim():
    if sys.version_info < (3, 11):
        pytest.skip("JuPedSim needs Shapely, which has no wheel for Python 3.10")
    return __import__("jupedsim")


@pytest.fixture
def call(lemons, tmp_path):
    def call(*arguments):
        command = [str(part) for part in [lemons, *arguments]]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stderr

    return call


def speeds_of(table, ids):
    """[frame][agent] m/s, from the FMU's velocities."""
    return np.array([[np.hypot(agent[2], agent[3]) for agent in agents] for _, agents in read_table(table, ids)])


def speeds_in(pedpy, path, step):
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=path)
    speeds = pedpy.compute_individual_speed(traj_data=data, frame_step=step)
    return data, speeds.pivot(index="frame", columns="id", values="speed")


@pytest.mark.parametrize("scene", ["push", "walk"])
def test_speed_in_pedpy(pedpy, call, tmp_path, scene):
    """PedPy's speed, from places, is the FMU's own to 1 %."""
    if scene == "push":
        trial, until, step = TRIAL_PUSH, 1.0, 0.001
    else:
        people = [{"mass": 70.0 + i, "x": i, "y": i, "fx": 60.0 + 40.0 * i, "rate": 2.0} for i in range(4)]
        trial, until, step = tmp_path / "walk", 3.0, 0.02
        write_trial(trial, people)
    call("run", trial, "--until", until, "--step", step)
    call("export", "trajectories.csv", "run.sqlite", "--to", "jupedsim", "--trial", trial)
    data, seen = speeds_in(pedpy, tmp_path / "run.sqlite", 1)
    ids = ids_of(trial)
    own = speeds_of((tmp_path / "trajectories.csv").read_text(), ids)
    assert data.frame_rate == 1 / step and data.number_pedestrians == len(ids) == own.shape[1]
    assert list(seen.columns) == [int(id) for id in ids]
    own = own[seen.index]
    assert own.max() > 0.5
    off = np.abs(seen.to_numpy() - own)
    # In a collision of some milliseconds PedPy's mean over two frames lags: there 1 % is that of the root mean square.
    assert np.sqrt(np.mean(off**2)) < 0.01 * np.sqrt(np.mean(own**2))
    if scene == "walk":
        assert (off < 0.01 * own).all()


def test_the_database_in_jupedsim(jupedsim, pedpy, call, tmp_path):
    """JuPedSim's own reader gives places and gazes to the bit, the area and the rate; the tables are those that its own
    writer makes."""
    call("run", TRIAL_PUSH, "--until", 0.5)
    call("export", "trajectories.csv", "run.sqlite", "--to", "jupedsim", "--trial", TRIAL_PUSH)
    recording = jupedsim.Recording(str(tmp_path / "run.sqlite"))
    ids = ids_of(TRIAL_PUSH)
    table = read_table((tmp_path / "trajectories.csv").read_text(), ids)
    assert recording.num_frames == len(table) and recording.fps == 20.0
    for k, (_, agents) in enumerate(table):
        seen = recording.frame(k).agents
        assert [agent.id for agent in seen] == sorted(map(int, ids))
        for agent in seen:
            x, y, _, _, theta, *_ = agents[ids.index(str(agent.id))]
            assert agent.position == (x, y)
            assert agent.orientation == pytest.approx((np.cos(theta), np.sin(theta)), abs=1e-15)
        assert recording.geometry_id_for_frame(k) == recording.geometry_id_for_frame(0)
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")
    assert recording.geometry().equals(area.polygon)
    box = recording.bounds()
    assert (box.xmin, box.ymin, box.xmax, box.ymax) == area.bounds

    writer = jupedsim.SqliteTrajectoryWriter(output_file=tmp_path / "theirs.sqlite", every_nth_frame=1)
    simulation = jupedsim.Simulation(model=jupedsim.CollisionFreeSpeedModel(), geometry=area.polygon, trajectory_writer=writer)
    simulation.iterate(2)
    writer.close()

    def tables(file):
        with closing(sqlite3.connect(tmp_path / file)) as database:
            names = database.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name").fetchall()
            columns = {name: database.execute(f"PRAGMA table_info({name})").fetchall() for (name,) in names}
            return columns, database.execute("SELECT value FROM metadata WHERE key = 'version'").fetchone()

    assert tables("run.sqlite") == tables("theirs.sqlite")


def test_which_versions_of_the_database_are_read(jupedsim, pedpy, call, tmp_path):
    """Version 2 is written, as the newest releases write and read it. JuPedSim's development has a version 3, which is
    version 2 without the gaze; its reader takes version 2 too. Where this fails, releases read version 3: write it."""
    call("run", TRIAL_PUSH, "--until", 0.1)
    call("export", "trajectories.csv", "run.sqlite", "--to", "jupedsim", "--trial", TRIAL_PUSH)
    assert jupedsim.sqlite_serialization.DATABASE_VERSION == 2
    with closing(sqlite3.connect(tmp_path / "run.sqlite")) as database, database:
        assert database.execute("SELECT value FROM metadata WHERE key = 'version'").fetchone() == ("2",)
        database.execute("UPDATE metadata SET value = '3' WHERE key = 'version'")
    with pytest.raises(Exception, match="database supplied is version 3"):
        jupedsim.Recording(str(tmp_path / "run.sqlite"))
    with pytest.raises(pedpy.errors.LoadTrajectoryError, match="unsupported db version 3"):
        pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")


def test_walkable_area_in_pedpy(pedpy, call, tmp_path):
    call("run", TRIAL_PUSH, "--until", 0.5)
    said = call("export", "trajectories.csv", "run.sqlite", "--to", "jupedsim", "--trial", TRIAL_PUSH)
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")
    assert area.bounds == (-0.2, -0.57395, 1.752675, 0.54371)
    assert area.area == pytest.approx(1.952675 * 1.11766, rel=1e-12)
    assert 'inside of wall "0"' in said
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")
    assert pedpy.is_trajectory_valid(traj_data=data, walkable_area=area)

    room = [(0, 0), (10, 0), (10, 6), (0, 6), (0, 0)]
    pillar = [(4, 2), (5, 2), (5, 3), (4, 3), (4, 2)]
    write_trial(tmp_path / "room", [{"mass": 70, "x": 2, "y": 2}], walls=[room, pillar])
    call("run", "room", "--until", 0.5, "-o", "room.csv")
    call("export", "room.csv", "room.sqlite", "--to", "jupedsim", "--trial", "room")
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "room.sqlite")
    assert area.area == 59.0 and len(area.polygon.interiors) == 1


def test_the_area_of_a_room_with_an_opening_ends_at_its_walls(pedpy, call, tmp_path):
    """Somebody who left by the corridor does not make the bounding box the area: what lies behind walls is not in it."""
    from shapely import Point

    call("run", TRIAL_DOOR, "--until", 0.2, "--step", 0.05)
    lines = (tmp_path / "trajectories.csv").read_text().splitlines()
    # The first agent walks on beyond the end of the corridor, x = 14 m.
    first = lines[1].split(",")[1]
    moved = [lines[0]]
    for line in lines[1:]:
        cells = line.split(",")
        if cells[1] == first and float(cells[0]) > 0.1:
            cells[2:4] = ["14.8", "2.4"]
        moved.append(",".join(cells))
    for name, table in ("in", lines), ("out", moved):
        (tmp_path / f"{name}.csv").write_text("\n".join(table) + "\n")
        said = call("export", f"{name}.csv", f"{name}.sqlite", "--to", "jupedsim", "--trial", TRIAL_DOOR)
        assert "its opening of 2 m closed by a straight line" in said
        assert ("beyond the opening" in said) == (name == "out")
        area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / f"{name}.sqlite")
        data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=tmp_path / f"{name}.sqlite")
        assert pedpy.is_trajectory_valid(traj_data=data, walkable_area=area)
        for x, y, inside in [(1, 1, True), (5.1, 2.5, True), (10, 2, True), (10, 1, False), (10, 4, False), (-0.1, 2, False)]:
            assert area.polygon.contains(Point(x, y)) == inside, (name, x, y)
        room, corridor = 25.0, 0.2 * 0.9 + 8.8 * 2.0
        assert area.area == pytest.approx(room + corridor, rel=0.08 if name == "out" else 1e-12)
        cells = pedpy.compute_individual_voronoi_polygons(traj_data=data, walkable_area=area)
        assert cells.polygon.map(lambda cell: cell.area).groupby(cells.frame).sum().max() <= area.area * (1 + 1e-9)
    (tmp_path / "own.wkt").write_text("POLYGON ((0 0, 20 0, 20 5, 0 5, 0 0))\n")
    said = call("export", "out.csv", "own.sqlite", "--to", "jupedsim", "--trial", TRIAL_DOOR, "--area", "own.wkt")
    assert "the polygon given" in said
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "own.sqlite")
    assert area.area == 100.0


def test_text_and_chaos(pedpy, call, tmp_path):
    call("run", TRIAL_PUSH, "--until", 0.5)
    call("export", "trajectories.csv", "run.txt", "--to", "pedpy", "--every", 2)
    call("export", "trajectories.csv", "chaos", "--to", "chaos")
    seen = read_table((tmp_path / "trajectories.csv").read_text(), ids_of(TRIAL_PUSH))
    data = pedpy.load_trajectory(trajectory_file=tmp_path / "run.txt")
    assert data.frame_rate == 10.0
    places = data.data.sort_values(["frame", "id"])[["x", "y"]].to_numpy().tolist()
    assert places == [agent[:2] for _, agents in seen[::2] for agent in agents]
    for i in range(5):
        lines = (tmp_path / f"chaos/traj{i:03}.csv").read_text().splitlines()
        wanted = [[t, *agents[i][:2], 0.0] for t, agents in seen]
        assert [list(map(float, line.split(","))) for line in lines] == wanted


def test_a_run_goes_on_from_its_series(call, pack, instantiate, push_directory, tmp_path):
    """Trial -> run -> XML series -> Trial: the new FMU starts with the doubles of the old one, and stays with it."""
    crowd = instantiate(push_directory)
    crowd["OutputDirectory"] = str(tmp_path / "series")
    crowd.initialize()
    crowd.run(8, 0.05, push_drive())
    was = crowd.look()
    assert crowd["AgentContacts"] > 0
    call("export", "series", "end", "--to", "trial", "--trial", TRIAL_PUSH)
    again = instantiate(pack(tmp_path / "end")).initialize(crowd.time)
    assert bits(again.look()) == bits(was)
    # Springs are no outputs of the FMU, but what follows hangs on them to the last bit.
    drive = push_drive()
    for k in range(8, 16):
        for i, push in drive.at(k * 0.05).items():
            for one in (crowd, again):
                for name, value in zip(["Fp.x", "Fp.y", "Mp"], push):
                    one[f"agent[{i}].{name}"] = value
        for one in (crowd, again):
            one.step_to((k + 1) * 0.05)
        assert bits(again.look()) == bits(crowd.look())


def test_a_run_of_python_in_pedpy(lemons, pedpy, call, tmp_path, monkeypatch):
    """Places and the walkable area, of people of whom some have left; what is in the database is what the command writes."""
    monkeypatch.setenv("LEMONS", str(lemons))
    room = crowd(number=10, box=(5, 4), door=[5, 2, 1], leave=True, output=tmp_path / "room")
    with Crowd(room) as people:
        run = people.run(until=20.0, stop=lambda people: people.left >= 2)
    assert run.export(tmp_path / "run.sqlite", to="jupedsim") == tmp_path / "run.sqlite"
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")
    frames, agents = np.nonzero(run.active)
    assert (~run.active[-1]).sum() > 0 and len(frames) == len(data.data)
    seen = data.data.sort_values(["frame", "id"])
    order = np.lexsort((np.array(run.ids, dtype=int)[agents], frames))
    assert np.array_equal(seen[["x", "y"]], run.poses[frames, agents, :2][order])
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "run.sqlite")
    assert pedpy.is_trajectory_valid(traj_data=data, walkable_area=area)

    call("run", room.directory, "--until", repr(run.times[-1].item()), "-o", "room.csv")
    call("export", "room.csv", "theirs.sqlite", "--to", "jupedsim", "--trial", room.directory)
    export(tmp_path / "room.csv", tmp_path / "again.sqlite", to="jupedsim", trial=room)

    def content(name):
        with closing(sqlite3.connect(tmp_path / name)) as database:
            return list(database.iterdump())

    assert content("run.sqlite") == content("again.sqlite") == content("theirs.sqlite")
    run.export(tmp_path / "run.txt", to="pedpy", every=2)
    assert pedpy.load_trajectory(trajectory_file=tmp_path / "run.txt").frame_rate == data.frame_rate / 2
    with pytest.raises(CommandError, match="--force replaces it"):
        run.export(tmp_path / "run.txt", to="pedpy")
    run.export(tmp_path / "run.txt", to="pedpy", force=True)
    assert pedpy.load_trajectory(trajectory_file=tmp_path / "run.txt").frame_rate == data.frame_rate


@pytest.mark.long
def test_analyse(pedpy, call, decide, pack, tmp_path):
    shutil.move(decide(), tmp_path / "decision.fmu")
    pack(TRIAL_DOOR)
    call("connect", "decision.fmu", "Trial_door.fmu", "-o", "door.ssp")
    call("run", "door.ssp", "--until", 4)
    call("export", "trajectories.csv", "door.sqlite", "--to", "jupedsim", "--trial", "Trial_door.fmu", "--every", 2)
    done = run_example("analyse.py", tmp_path, "door.sqlite", "maps.png", "--from", "1")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "maps.png").read_bytes().startswith(b"\x89PNG")
    assert done.stdout.startswith("maps.png: 30 people, 31 frames, 10 per second\n"), done.stdout
    densest, fastest = (float(line.split("at most ")[1].split()[0]) for line in done.stdout.splitlines()[1:])
    assert 2.0 < densest < 9.0 and 1.0 < fastest < 5.0

    # A terminal shows how far it is: it was silent for minutes.
    terminal, its_end = pty.openpty()
    command = [sys.executable, REPOSITORY / "examples/analyse.py", "door.sqlite", "again.png", "--from", "1"]
    subprocess.run(command, cwd=tmp_path, env={**os.environ, "MPLBACKEND": "Agg"}, check=True, stdout=subprocess.DEVNULL, stderr=its_end)
    assert b"31 of 31 frames" in os.read(terminal, 10_000)
    os.close(terminal)
    os.close(its_end)
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "maps.png").read_bytes()

    for arguments, words in [
        (["none.sqlite"], "none.sqlite"),
        (["trajectories.csv"], "trajectories.csv"),
        (["door.sqlite", "--from", "90"], "fewer than two frames"),
    ]:
        done = run_example("analyse.py", tmp_path, *arguments)
        assert done.returncode == 1 and words in done.stderr and "Traceback" not in done.stderr, done.stderr
    done = run_example("analyse.py", tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("usage: analyse.py ")
