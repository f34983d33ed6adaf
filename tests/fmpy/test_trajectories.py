"""Trajectories of experiments and of JuPedSim, read by our commands, against PedPy on the same files."""

import gzip
import json
import os
import re
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from xml.etree import ElementTree

import limited
import numpy as np
import pandas as pd
import pytest
from crowd import TRIAL_DOOR

from lemons_fmu import CommandError, export, measure, movie, plot

pytestmark = [
    pytest.mark.skipif(sys.version_info < (3, 11), reason="PedPy and JuPedSim need Python 3.11"),
    pytest.mark.filterwarnings("ignore::UserWarning"),
]


@pytest.fixture(scope="module")
def pedpy():
    return pytest.importorskip("pedpy")


@pytest.fixture(autouse=True)
def command(lemons, tmp_path, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def corridor(tmp_path_factory):
    """People walk from JuPedSim's source through a corridor with a pillar and leave: its database, and its HDF5."""
    jps = pytest.importorskip("jupedsim")
    pytest.importorskip("h5py")
    directory = tmp_path_factory.mktemp("corridor")
    area = "POLYGON ((0 0, 12 0, 12 4, 0 4, 0 0), (5 1.5, 6 1.5, 6 2.5, 5 2.5, 5 1.5))"
    files = directory / "walk.sqlite", directory / "walk.h5"
    for path, kind in zip(files, (jps.SqliteTrajectoryWriter, jps.Hdf5TrajectoryWriter)):
        writer = kind(output_file=path, every_nth_frame=10)
        simulation = jps.Simulation(model=jps.CollisionFreeSpeedModel(), geometry=area, trajectory_writer=writer)
        out = simulation.add_exit_stage([(11, 0.1), (11.9, 0.1), (11.9, 3.9), (11, 3.9)])
        journey = simulation.add_journey(jps.JourneyDescription([out]))
        for step in range(1500):
            # One more each 0.8 s: people appear.
            if step % 80 == 0 and step < 1000:
                place = (0.5, 0.7 + step / 80 % 4 * 0.8)
                simulation.add_agent(jps.CollisionFreeSpeedModelAgentParameters(position=place, journey_id=journey, stage_id=out))
            simulation.iterate()
        writer.close()
    return files


def in_pedpy(pedpy, data, area, room, frame_step):
    """Number, density, Voronoi density and mean speed in an area, of each frame."""
    (x0, y0, x1, y1) = area
    measured = pedpy.MeasurementArea([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    cells = pedpy.compute_individual_voronoi_polygons(traj_data=data, walkable_area=room)
    voronoi, _ = pedpy.compute_voronoi_density(individual_voronoi_data=cells, measurement_area=measured)
    classic = pedpy.compute_classic_density(traj_data=data, measurement_area=measured)
    speeds = pedpy.compute_individual_speed(
        traj_data=data, frame_step=frame_step, speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED
    )
    speed = pedpy.compute_mean_speed_per_frame(traj_data=data, individual_speed=speeds, measurement_area=measured)
    return tuple(table.reset_index().set_index("frame")[name] for table, name in ((classic, "density"), (voronoi, "density"), (speed, "speed")))


def compare(pedpy, seen, data, area, room):
    own = seen.density.set_index((seen.density["t"] * data.frame_rate).round().astype(int))
    step = seen.summary["trajectories"]["frame_step"]
    classic, voronoi, speed = in_pedpy(pedpy, data, area, room, step)
    assert np.allclose(own["density"].reindex(classic.index), classic, rtol=1e-12) and classic.max() > 0
    # i_overlay has its corners on a fine grid.
    assert np.abs(own["voronoi_density"].reindex(voronoi.index) - voronoi).max() < 1e-5
    there = own[own["people"] > 0]
    assert len(there) > 50
    # Who was in fewer frames than one needs has no speed in PedPy.
    speed = speed.reindex(there.index)
    assert np.allclose(there["speed"], speed, rtol=1e-9, atol=1e-12)


def crossed(pedpy, data, line):
    _, frames = pedpy.compute_n_t(traj_data=data, measurement_line=pedpy.MeasurementLine([line[:2], line[2:]]))
    return frames.set_index("id")["frame"] / data.frame_rate


def test_a_run_of_jupedsim_is_measured_as_pedpy_does(pedpy, corridor):
    area, line = (6.5, 0.5, 9.5, 3.5), (8.0, 0.0, 8.0, 4.0)
    database, hdf5 = corridor
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=database)
    room = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=database)
    seen = measure(database, lines={"line": line}, areas={"area": area}, velocity_over=0.8)
    assert seen.summary["trajectories"] == {"frame_rate": 10.0, "velocity_over": 0.8, "frame_step": 4}
    compare(pedpy, seen, data, area, room)
    theirs = crossed(pedpy, data, line)
    own = seen.gaps.assign(id=seen.gaps["id"].astype(int)).set_index("id")["t"]
    assert len(own) == len(theirs) > 5 and ((theirs - own) > 0).all() and ((theirs - own) <= 0.1 + 1e-9).all()
    assert seen.summary["left"]["people"] == seen.summary["people"] - data.data[data.data.frame == data.data.frame.max()]["id"].nunique()
    # Forces are not there, and not zero.
    assert seen.summary["exposure"] is None and len(seen.people) == 0
    # Its HDF5 is the same run.
    again = measure(hdf5, lines={"line": line}, areas={"area": area}, velocity_over=0.8)
    assert again.summary.pop("source") == str(hdf5) and seen.summary.pop("source") == str(database)
    # (It names no frames before the first person.)
    assert again.summary == seen.summary
    pd.testing.assert_frame_equal(again.density, seen.density)


@pytest.mark.parametrize(
    ("name", "told", "area", "window"),
    [
        ("hermes_uo/uo-180-180-070.txt.gz", {"unit": "cm", "fps": 16.0}, (0.2, -2.5, 1.6, -1.5), (700, 800)),
        ("adrian/040_c_56_h-.txt.gz", {}, (-0.6, 0.5, 0.6, 1.3), (500, 600)),
    ],
)
def test_an_experiment_is_measured_as_pedpy_does(pedpy, shared, tmp_path, name, told, area, window):
    path = shared / "data" / "walk" / name
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    text = gzip.decompress(path.read_bytes()).decode()
    # Some seconds of it: PedPy needs a second for ten frames.
    rows = [row for row in text.splitlines() if row.startswith("#") or window[0] <= int(row.split()[1]) < window[1]]
    (tmp_path / "part.txt").write_text("\n".join(rows) + "\n")
    unit = {"default_unit": pedpy.TrajectoryUnit.CENTIMETER, "default_frame_rate": told["fps"]} if told else {}
    data = pedpy.load_trajectory_from_txt(trajectory_file=tmp_path / "part.txt", **unit)
    low, high = data.data[["x", "y"]].min() - 0.5, data.data[["x", "y"]].max() + 0.5
    corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)]
    walls = ", ".join(f"{float(x)!r} {float(y)!r}" for x, y in [*corners, corners[0]])
    (tmp_path / "box.wkt").write_text(f"POLYGON (({walls}))")
    for how in ({"geometry": "box.wkt"}, {"walkable": "box.wkt"}):
        seen = measure("part.txt", areas={"area": area}, **told, **how)
        compare(pedpy, seen, data, area, pedpy.WalkableArea(corners))
    # Out and in again, in each format.
    for to, file in ("jupedsim", "part.sqlite"), ("hdf5", "part.h5"), ("pedpy", "again.txt"):
        geometry = {} if to == "pedpy" else {"geometry": "box.wkt"}
        export("part.txt", file, to=to, **told, **geometry)
        again = measure(file, areas={"area": area}, walkable="box.wkt")
        pd.testing.assert_frame_equal(again.density, seen.density, check_exact=False, rtol=1e-12)
    theirs = pedpy.load_trajectory_from_ped_data_archive_hdf5(trajectory_file=tmp_path / "part.h5")
    assert theirs.frame_rate == data.frame_rate
    sort = ["id", "frame", "x", "y"]
    ours = theirs.data[sort].sort_values(sort[:2], ignore_index=True)
    pd.testing.assert_frame_equal(ours, data.data[sort].sort_values(sort[:2], ignore_index=True), check_dtype=False)
    assert pedpy.load_walkable_area_from_ped_data_archive_hdf5(trajectory_file=tmp_path / "part.h5").area == pytest.approx(
        (high.x - low.x) * (high.y - low.y)
    )


def drawn(what):
    """Contacts of everybody over time; to a tenth of a pixel, as times are rounded otherwise."""
    text = plot(what, trial=TRIAL_DOOR, series="contacts").data.decode()
    return re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.1f}", text)


def test_our_own_runs_come_back(lemons):
    line, area = {"door": (5, 2.05, 5, 2.95)}, {"front": (3, 1, 5, 4)}
    subprocess.run([lemons, "run", TRIAL_DOOR, "--until", "6", "-o", "walk.csv", "--outputs", "drives.csv"], check=True, capture_output=True)
    own = measure("walk.csv", trial=TRIAL_DOOR, lines=line, areas=area)
    for to, file in ("jupedsim", "walk.sqlite"), ("hdf5", "walk.h5"):
        pytest.importorskip("h5py")
        export("walk.csv", file, to=to, trial=TRIAL_DOOR)
        back = measure(file, lines=line, areas=area)
        # A person leaves the files with the last row that has them there.
        assert (back.gaps["id"] == own.gaps["id"]).all() and np.allclose(back.gaps["t"], own.gaps["t"], atol=1e-9)
        for column in ("people", "density", "voronoi_density"):
            assert np.allclose(back.density[column], own.density[column], atol=1e-5), column
        speeds = back.density["speed"] - own.density["speed"]
        assert 0 < np.sqrt(np.nanmean(speeds**2)) < 0.1
        # With the bodies of the Trial, whose gazes come back, contacts are known again.
        assert drawn(file) == drawn("walk.csv") and drawn(file).count("simulated") == 30
    export("walk.csv", "walk.txt", to="pedpy")
    with pytest.raises(CommandError, match="does not say where people look, so bodies of --trial"):
        plot("walk.txt", trial=TRIAL_DOOR)
    assert b"<svg" in plot("walk.txt", geometry=TRIAL_DOOR).data
    with pytest.raises(CommandError, match="series and --to trial are for runs of a Trial"):
        export("walk.sqlite", "next", to="trial", trial=TRIAL_DOOR)


def test_what_is_not_known_is_not_drawn(corridor, tmp_path):
    database, hdf5 = corridor
    told = {"fill": "squeeze"}, {"forces": True}, {"series": "contacts"}, {"fill": "lean"}
    for options in told:
        with pytest.raises(CommandError, match="positions only|people have no legs"):
            plot(database, **options)
    picture = plot(hdf5, at=[5.0], fill="speed", trails=2).data.decode()
    assert "speed (m/s)" in picture and picture.count("<title>") > 3
    assert plot(database, at=[5.0], radius=0.3).data != plot(database, at=[5.0]).data
    plot(database, density=True)
    movie(database, "walk.gif", from_=2.0, until=3.0, frame_rate=10.0)
    assert (tmp_path / "walk.gif").read_bytes().startswith(b"GIF8")
    for refused, match in (
        ({"trial": None, "above": [100]}, "do not contain the mean squeeze"),
        ({"walls": True}, "do not contain the forces on walls"),
        ({"fps": 25.0}, "says 10.0 frames per second, not 25.0"),
        ({"unit": "cm"}, "a database is in m"),
        ({"geometry": "none.dxf"}, "--geometry none.dxf"),
        ({"set": {"TimeStepMechanical": 1e-5}}, "have no parameters"),
    ):
        with pytest.raises(CommandError, match=match):
            measure(database, **refused)
    for option in ({"fps": 25.0}, {"velocity_over": 1.0}, {"radius": 0.3}, {"geometry": "box.wkt"}):
        with pytest.raises(CommandError, match="holds no trajectories"):
            measure(TRIAL_DOOR, **option)


def test_what_comes_of_hdf5_names_the_users_file(corridor, tmp_path):
    _, hdf5 = corridor
    with pytest.warns(UserWarning, match=re.escape(f"{hdf5}: trajectories without forces")) as told:
        picture = plot(hdf5, at=[5.0]).data.decode()
        measure(hdf5, output="measured")
    texts = [*(str(each.message) for each in told), picture, Path("measured/summary.json").read_text()]
    assert not any("/lemons-" in text for text in texts)


def test_damaged_hdf5_is_refused_in_words(corridor, tmp_path):
    h5py = pytest.importorskip("h5py")
    _, good = corridor
    whole = good.read_bytes()
    kinds = np.dtype([("id", "<i8"), ("frame", "<i8"), ("x", "<f8"), ("y", "<f8"), ("z", "<f8")])
    rows = np.array([(1, 0, 0.0, 0.0, 0.0), (1, 1, 0.5, 0.0, 0.0)], dtype=kinds)

    def refused(change, match):
        with h5py.File("bad.h5", "w") as file:
            change(file)
        with pytest.raises(CommandError, match=match) as raised:
            measure("bad.h5")
        assert str(raised.value).startswith("bad.h5: ")

    def put(file, data, fps=10.0):
        made = file.create_dataset("trajectory", data=data)
        if fps is not None:
            made.attrs["fps"] = fps

    refused(lambda file: None, "there is no dataset")
    refused(lambda file: file.create_group("trajectory"), "there is no dataset")
    refused(lambda file: put(file, rows, None), 'no attribute "fps"')
    refused(lambda file: put(file, rows, "fast"), "fps is \"fast\"")
    refused(lambda file: put(file, rows, -1.0), "must be from 1e-6")
    refused(lambda file: put(file, np.zeros(3)), "there is no column 'frame'")
    refused(lambda file: put(file, rows[["id", "frame", "x"]]), "there is no column 'y'")
    refused(lambda file: put(file, np.stack([rows, rows])), "has not one dimension")
    refused(lambda file: put(file, rows[:0]), "holds no row")
    refused(lambda file: put(file, np.concatenate([rows, rows])), "id 1 stands twice in frame 0")
    wrong = rows.copy()
    wrong["x"][1] = np.nan
    refused(lambda file: put(file, wrong), "row 2: column pos_x: NULL is not a number")
    real = np.array([(1, 0, 0, 0), (1, 1, 0.5, 0)], dtype=[("id", "<f8"), ("frame", "<f8"), ("x", "<f4"), ("y", "<f4")])
    real["frame"][1] = 0.5
    refused(lambda file: put(file, real), "row 2: column frame: 0.5 is not a whole number")

    def many(file, x, chunk=1000, more=()):
        # Chunks that were not written take no room in the file.
        shape, kind = (20_000_000,), [("id", "<i8"), ("frame", "<i8"), ("x", *x), ("y", "<f8"), *more]
        file.create_dataset("trajectory", shape, kind, chunks=(chunk,)).attrs["fps"] = 10.0

    refused(lambda file: many(file, ("<f8",), 10_000_000), "a chunk has 320000000 bytes, more than")
    refused(lambda file: many(file, ("<f8",)), "has 20000000 rows, but only 0 are in the file")

    def elsewhere(file):
        (tmp_path / "raw").write_bytes(rows.tobytes())
        file.create_dataset("trajectory", (2,), kinds, external=[("raw", 0, rows.nbytes)]).attrs["fps"] = 10.0

    refused(elsewhere, "its rows are in other files")
    refused(lambda file: file.__setitem__("trajectory", h5py.ExternalLink(str(good), "trajectory")), "there is no dataset")

    def linked(file, to):
        put(file, rows)
        file.move("trajectory", "data")
        file["other"] = h5py.ExternalLink(str(good), "trajectory")
        file["trajectory"] = h5py.SoftLink(to)

    for to in ("/other", "trajectory", "/none", "/data/none"):
        refused(lambda file, to=to: linked(file, to), "there is no dataset")
    with h5py.File("linked.h5", "w") as file:
        linked(file, "/data")
    with h5py.File("plain.h5", "w") as file:
        put(file, rows)
    one, other = ({**measure(name).summary, "source": None} for name in ("linked.h5", "plain.h5"))
    assert one == other and one["people"] == 1

    def text(file):
        put(file, rows)
        kind = h5py.string_dtype()
        file["trajectory"].attrs.create("fps", np.array(["9" * 60_000] * 1000, dtype=object), dtype=kind)

    refused(text, r"attribute fps: holds \(1000,\) values")
    refused(lambda file: many(file, ("<f8",), more=[("name", "S5000")]), "a row has 5032 bytes, more than 4096")
    refused(lambda file: many(file, ("<f8", (10_000,))), r"column x: holds \('<f8', \(10000,\)\), not one number a row")
    two = np.zeros(1, dtype=[*((name, "<i8") for name in ("id", "frame", "y")), ("x", "<f8", (2,))])
    refused(lambda file: put(file, two), "column x: holds .*, not one number a row")
    texts = np.array([(1, 0, b"a", 0.0)], dtype=[("id", "<i8"), ("frame", "<i8"), ("x", "S1"), ("y", "<f8")])
    refused(lambda file: put(file, texts), "column x: holds .*S1, not one number a row")
    for size in (8, 100, 1000, len(whole) // 2):
        (tmp_path / "bad.h5").write_bytes(whole[:size])
        with pytest.raises(CommandError, match="bad.h5: is no sound HDF5"):
            measure("bad.h5")


LITTLE_MEMORY = """
import resource, sys
import h5py, lemons_fmu  # with their threads
resource.setrlimit(resource.RLIMIT_DATA, (int(sys.argv[1]),) * 2)
try:
    lemons_fmu.measure("small.h5")
except lemons_fmu.CommandError as error:
    print(error)
"""


def test_a_small_file_of_hdf5_takes_little_memory(tmp_path):
    """Rows that nobody wrote, and rows that are packed a thousand times: 15 million would take some GB."""
    h5py = pytest.importorskip("h5py")
    kinds = np.dtype([("id", "<i8"), ("frame", "<i8"), ("x", "<f8"), ("y", "<f8"), ("z", "<f8")])
    words = {False: "has 15000000 rows, but only 0 are in the file", True: r"bytes unpack to 600000000, more than 100 times"}
    for written, expected in words.items():
        with h5py.File(tmp_path / "small.h5", "w") as file:
            made = file.create_dataset("trajectory", (15_000_000,), kinds, chunks=(1_000_000,), compression="gzip")
            made.attrs["fps"] = 10.0
            for first in range(0, 15_000_000, 1_000_000) if written else ():
                made[first : first + 1_000_000] = np.zeros(1_000_000, kinds)
        assert (tmp_path / "small.h5").stat().st_size < 1_000_000
        done = limited.run(
            [sys.executable, "-c", LITTLE_MEMORY, "600000000"], 300, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        assert re.search(expected, done.stdout), (done.stdout, done.stderr)


def test_hdf5_replaces_nothing_that_is_read(corridor, tmp_path):
    database, hdf5 = corridor
    copy = tmp_path / "copy.h5"
    copy.write_bytes(hdf5.read_bytes())
    for force in (False, True):
        with pytest.raises(CommandError, match="it is read, and is not replaced"):
            export(copy, copy, to="hdf5", force=force)
    with pytest.raises(CommandError, match="exists already"):
        export(database, copy, to="hdf5")
    assert copy.read_bytes() == hdf5.read_bytes()
    export(database, copy, to="hdf5", force=True)
    assert copy.read_bytes() != hdf5.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy.h5"]


def test_the_command_names_hdf5(lemons, corridor):
    done = subprocess.run([lemons, "measure", corridor[1]], capture_output=True, text=True)
    assert done.returncode == 1 and "is an HDF5 file, not a table" in done.stderr and "in Python" in done.stderr


def test_the_summary_says_how_velocities_are_calculated(lemons, corridor, tmp_path):
    done = subprocess.run([lemons, "measure", corridor[0], "--summary", "-"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["trajectories"] == {"frame_rate": 10.0, "velocity_over": 0.4, "frame_step": 2}
    assert "velocities: differences of positions 0.4 s apart" in done.stderr


def test_a_database_that_is_written_to_is_refused(corridor, tmp_path):
    path = tmp_path / "live.sqlite"
    path.write_bytes(corridor[0].read_bytes())
    with closing(sqlite3.connect(path, isolation_level=None)) as writer:
        writer.execute("PRAGMA journal_mode = WAL")
        writer.execute("DELETE FROM trajectory_data WHERE frame > 10")
        with pytest.raises(CommandError, match="a program writes to the database"):
            measure(path)


def in_common(pedpy, own, theirs):
    """Who is where in the frames that both have, and how many these are."""
    export(own, "own.txt", to="pedpy", force=True, **({"fps": theirs.frame_rate} if own.suffix == ".traj" else {}))
    ours = pedpy.load_trajectory(trajectory_file=Path("own.txt"))
    assert ours.frame_rate == theirs.frame_rate
    both = ours.data.merge(theirs.data, on=["id", "frame"], suffixes=("", "_theirs"))
    assert np.allclose(both[["x", "y"]], both[["x_theirs", "y_theirs"]], rtol=0.0, atol=1e-12)
    return len(both), len(ours.data), len(theirs.data)


def test_files_of_other_programs_are_those_of_pedpy(pedpy, tmp_path):
    times, walk = np.arange(8) / 4, np.random.default_rng(5).uniform(-9.0, 9.0, (8, 2))
    rows = [(t, x, y) for t, (x, y) in zip(times, walk)]
    viswalk, pathfinder, vadere = tmp_path / "w.pp", tmp_path / "p.csv", tmp_path / "postvis.traj"
    head = "$VISION\n* File: a\n$PEDESTRIAN:NO;SIMSEC;COORDCENTX;COORDCENTY\n"
    viswalk.write_text(head + "".join(f"{k};{t:.2f};{x + k:.4f};{y:.4f}\n" for t, x, y in rows for k in (3, 4)))
    head = '"t","id","name","active","x","y","z","v"\n"s","","","","m","m","m","m/s"\n'
    pathfinder.write_text(head + "".join(f'{t:f},{k},"0000{k}",1,{x + k:f},{y:f},0.0,1.0\n' for t, x, y in rows for k in (3, 4)))
    head = "#IDXCOL=2,DATACOL=6,SEP=' '\npedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1\n"
    steps = [f"1 {0.4 * a[0]} {0.4 * b[0]} {a[1]} {a[2]} {b[1]} {b[2]}\n" for a, b in zip(rows, rows[1:])]
    vadere.write_text(head + "".join(steps))
    load = pedpy.load_trajectory_from_viswalk(trajectory_file=viswalk)
    assert in_common(pedpy, viswalk, load) == (16, 16, 16)
    load = pedpy.load_trajectory_from_pathfinder_csv(trajectory_file=pathfinder)
    assert in_common(pedpy, pathfinder, load) == (16, 16, 16)
    # PedPy reads the begins of steps only: it does not see the end of the last one, at 0.7 s.
    load = pedpy.load_trajectory_from_vadere(trajectory_file=vadere, frame_rate=50.0)
    assert in_common(pedpy, vadere, load) == (31, 36, 31)


def test_fcd_that_sumo_writes_is_read(pedpy, tmp_path):
    pytest.importorskip("libsumo")
    lane = '<lane id="a_{0}" index="{0}" {1} speed="13" length="100" shape="0,-{2} 100,-{2}"/>'
    lanes = lane.format(0, 'allow="pedestrian"', 6) + lane.format(1, 'disallow="pedestrian"', 2)
    ends = ((0, "A", ""), (100, "B", "a_0 a_1"))
    ends = "".join(f'<junction id="{name}" type="dead_end" x="{x}" y="0" incLanes="{all}" intLanes="" shape="{x},0 {x},-8"/>' for x, name, all in ends)
    where = '<location netOffset="0,0" convBoundary="0,0,100,0" origBoundary="0,0,100,0" projParameter="!"/>'
    Path("net.xml").write_text(f'<net version="1.20">{where}<edge id="a" from="A" to="B">{lanes}</edge>{ends}</net>')
    person = '<person id="ped{0}" depart="{0}"><walk edges="a"/></person>'
    car = '<vehicle id="car" depart="1"><route edges="a"/></vehicle>'
    Path("routes.xml").write_text(f"<routes>{person.format(0)}{car}{person.format(3)}</routes>")
    script = """if True:
        import sys
        import libsumo
        libsumo.start(["sumo", "-n", "net.xml", "-r", "routes.xml", "--step-length", "0.5", "--fcd-output", sys.argv[1]])
        while libsumo.simulation.getTime() < 20:
            libsumo.simulationStep()
        libsumo.close()"""
    for path in (tmp_path / "fcd.xml", tmp_path / "fcd.csv"):
        environment = {**os.environ, "SUMO_HOME": str(tmp_path)}
        subprocess.run([sys.executable, "-c", script, path], check=True, env=environment, stdout=subprocess.DEVNULL)
        export(path, "own.txt", to="pedpy", force=True)
        own = pedpy.load_trajectory(trajectory_file=Path("own.txt"))
        ours = {(f"ped{3 * int(row.id)}", row.frame / 2): (row.x, row.y) for row in own.data.itertuples()}
        steps = ElementTree.parse(tmp_path / "fcd.xml").getroot()
        people = [(float(step.get("time")), person) for step in steps for person in step.findall("person")]
        assert ours == {(p.get("id"), time): (float(p.get("x")), float(p.get("y"))) for time, p in people}
        assert len(ours) > 60 and own.frame_rate == 2.0
