"""`lemons measure` against PedPy, numpy and what is known in closed form."""

import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pandas as pd
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, TRIAL_PUSH

import lemons_fmu
from lemons_fmu import CommandError, measure

#: From here, to the right is out of the room.
DOOR = (5.0, 2.05, 5.0, 2.95)
COLUMNS = ["t", "id", "x", "y", "vx", "vy", "theta", "omega"]
CONTACTS = ["agent_contacts", "wall_contacts", "contacting_agents", "normal_force"]
OF_STEP = ["mean_normal_force", "peak_normal_force", "peak_overlap"]


@pytest.fixture
def pedpy():
    if sys.version_info < (3, 11):
        pytest.skip("PedPy needs Python 3.11")
    return __import__("pedpy")


@pytest.fixture(autouse=True)
def command(lemons, tmp_path, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def walk(lemons, tmp_path_factory):
    """Thirty people leave a room: the table of a run."""
    directory = tmp_path_factory.mktemp("walk")
    words = [lemons, "run", TRIAL_DOOR, "--until", "8", "-o", directory / "walk.csv", "--outputs", directory / "outputs.csv"]
    subprocess.run(words, check=True, capture_output=True)
    return directory / "walk.csv"


def call(lemons, *words, code=0):
    done = subprocess.run([lemons, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


def in_pedpy(pedpy, table, rate=20.0):
    rows = pd.read_csv(table)
    frames = pd.DataFrame({"id": rows["id"], "frame": (rows["t"] * rate).round().astype(int), "x": rows["x"], "y": rows["y"]})
    return pedpy.TrajectoryData(frames, rate)


def write_table(path, frames, step=0.1, squeezes=None):
    """[frame][agent] (x, y); squeezes: [frame][agent] N."""
    rows = []
    for k, people in enumerate(frames):
        for who, (x, y) in enumerate(people):
            row = [k * step, who, x, y, 0.5, 0.0, 0.0, 0.0]
            if squeezes is not None:
                force = squeezes[k][who]
                row += [0, 0, 0, force, force, force, 0.0]
            rows.append(row)
    names = COLUMNS + (CONTACTS + OF_STEP if squeezes is not None else [])
    pd.DataFrame(rows, columns=names).to_csv(path, index=False)
    return path


def test_people_across_are_those_of_pedpy(pedpy, walk):
    seen = measure(walk, lines={"door": DOOR}, window=1.0)
    data, line = in_pedpy(pedpy, walk), pedpy.MeasurementLine([DOOR[:2], DOOR[2:]])
    n_t, crossed = pedpy.compute_n_t(traj_data=data, measurement_line=line)
    # PedPy names the frame after the crossing; here the time is interpolated between both frames.
    own = seen.gaps.assign(id=seen.gaps["id"].astype(int)).set_index("id")["t"]
    theirs = crossed.set_index("id")["frame"] / data.frame_rate
    assert len(own) == len(theirs) == 30
    early = theirs - own
    assert early.between(0, 0.05).all(), early[~early.between(0, 0.05)]
    passages = seen.passages("door", "right")
    counts = [(passages <= frame / data.frame_rate).sum() for frame in n_t["frame"]]
    assert (n_t["cumulative_pedestrians"] == counts).all()
    assert len(seen.passages("door", "left")) == 0
    with pytest.raises(KeyError):
        seen.passages("window", "left")

    # Their flow of one interval over all: N / Δt from the frame of the first to that after the last.
    speed = pedpy.compute_individual_speed(traj_data=data, frame_step=2)
    first, last = crossed["frame"].min(), crossed["frame"].max()
    delta = n_t["frame"].max() - 1 - first
    flow = pedpy.compute_flow(nt=n_t, crossing_frames=crossed, individual_speed=speed, delta_frame=int(delta), frame_rate=20.0)
    assert len(flow) == 1 and flow["flow"][0] == pytest.approx(30 / (last + 1 - first) * 20, rel=1e-12)
    [right] = [way for way in seen.summary["lines"][0]["directions"] if way["direction"] == "right"]
    # N − 1 gaps lie between N people; a frame more or less of the time.
    assert right["flow"] == pytest.approx(flow["flow"][0] * 29 / 30, rel=0.02)
    assert right["specific_flow"] == pytest.approx(right["flow"] / 0.9, rel=1e-12)


def test_flow_and_gaps_are_those_of_numpy(walk):
    seen = measure(walk, lines={"door": DOOR}, window=0.7, width=1.2, from_=1.0, until=6.5)
    passages = seen.passages("door", "right")
    gaps = np.diff(passages)
    rows = seen.gaps[seen.gaps["direction"] == "right"]
    assert np.isnan(rows["gap"].iloc[0]) and (rows["gap"].iloc[1:] == gaps).all()
    [right] = [way for way in seen.summary["lines"][0]["directions"] if way["direction"] == "right"]
    for name, part in ("gap_10", 0.1), ("gap_median", 0.5), ("gap_90", 0.9):
        assert right[name] == pytest.approx(np.quantile(gaps, part), rel=1e-12)
    assert right["flow"] == pytest.approx(1 / gaps.mean(), rel=1e-12)
    assert right["specific_flow"] == pytest.approx(right["flow"] / 1.2, rel=1e-12)
    flow = seen.flow[seen.flow["direction"] == "right"]
    edges = np.append(1.0 + 0.7 * np.arange(8), 6.5)
    counts, _ = np.histogram(passages, edges)
    assert (flow["people"] == counts).all() and flow["people"].sum() == len(passages)
    assert np.allclose(flow["flow"], counts / np.diff(edges), rtol=1e-12)
    assert np.allclose(flow["specific_flow"], flow["flow"] / 1.2, rtol=1e-12)


def test_densities_are_those_of_pedpy(pedpy, lemons, walk, tmp_path):
    areas = {"front": (3.0, 1.0, 5.0, 4.0), "wedge": (2.0, 2.5, 5.0, 1.0, 5.0, 4.0)}
    seen = measure(walk, trial=TRIAL_DOOR, areas=areas)
    call(lemons, "export", walk, "walk.sqlite", "--to", "jupedsim", "--trial", TRIAL_DOOR)
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=tmp_path / "walk.sqlite")
    room = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=tmp_path / "walk.sqlite")
    cells = pedpy.compute_individual_voronoi_polygons(traj_data=data, walkable_area=room)
    x0, y0, x1, y1 = areas["front"]
    corners = {"front": [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], "wedge": [(2.0, 2.5), (5.0, 1.0), (5.0, 4.0)]}
    for name, points in corners.items():
        area = pedpy.MeasurementArea(points)
        own = seen.density[seen.density["area"] == name].reset_index(drop=True)
        classic = pedpy.compute_classic_density(traj_data=data, measurement_area=area)["density"].to_numpy()
        assert len(own) == len(classic) == 161 and own["people"].max() >= 10
        assert np.allclose(own["density"], classic, rtol=1e-12)
        voronoi, _ = pedpy.compute_voronoi_density(individual_voronoi_data=cells, measurement_area=area)
        # i_overlay has its corners on a fine grid; the database has places to the last bit.
        assert np.abs(own["voronoi_density"] - voronoi["density"].to_numpy()).max() < 1e-5
        of = [one for one in seen.summary["areas"] if one["name"] == name][0]
        assert of["area"] == pytest.approx(area.area, rel=1e-12)
        assert of["voronoi_density"]["max"] == own["voronoi_density"].max()
        # Speeds are those of the table.
        rows = pd.read_csv(walk)
        rows["speed"] = np.hypot(rows["vx"], rows["vy"])
        inside = rows[rows["x"].between(3, 5) & rows["y"].between(1, 4)] if name == "front" else None
        if inside is not None:
            means = inside.groupby("t")["speed"].mean().to_numpy()
            assert np.allclose(own["speed"].dropna(), means, rtol=1e-12)
            assert own["speed"].isna().sum() == (own["people"] == 0).sum()


def test_a_walk_back_and_forth_and_a_stop_on_the_line(tmp_path):
    frames = [
        [(-1.0, 0.5), (-1.0, 0.5), (-1.0, 3.0)],
        [(1.0, 0.5), (0.0, 0.5), (1.0, 3.0)],
        [(-3.0, 0.5), (0.0, 0.5), (-1.0, 3.0)],
        [(1.0, 0.5), (2.0, 0.5), (1.0, 3.0)],
    ]
    seen = measure(write_table(tmp_path / "run.csv", frames), lines={"gate": (0, 0, 0, 1)})
    # The second one arrives on the line at 0.1 s and is counted once; the third one goes past its end.
    assert seen.passages("gate", "right") == pytest.approx([0.05, 0.1])
    assert seen.passages("gate", "left") == pytest.approx([0.125])
    right, left = seen.summary["lines"][0]["directions"]
    assert (right["people"], right["crossings"], right["across"], right["not_across"]) == (2, 3, 2, 1)
    assert (left["people"], left["crossings"], left["across"], left["evacuation_time"]) == (1, 1, 0, None)
    assert list(seen.gaps["id"]) == ["0", "1", "0"]
    # Without the third one all are across, when the first one is so for good.
    seen = measure(write_table(tmp_path / "two.csv", [people[:2] for people in frames]), lines={"gate": (0, 0, 0, 1)})
    assert seen.summary["lines"][0]["directions"][0]["evacuation_time"] == pytest.approx(0.275)


def test_exposure_is_that_of_a_pulse_and_a_ramp(tmp_path):
    times = np.arange(121) * 0.1
    pulse = np.where((times > 2.05) & (times < 2.55), 800.0, 0.0)
    ramp = np.maximum(times - 0.05, 0.0) * 100.0
    still = [[(0.0, 0.0), (2.0, 0.0)]] * len(times)
    table = write_table(tmp_path / "run.csv", still, squeezes=np.transpose([pulse, ramp]))
    seen = measure(table, above=[500, 799.5, 801])
    first, second = seen.people.to_dict("records")
    assert [first[f"time_above_{level}"] for level in ("500", "799.5", "801")] == pytest.approx([0.5, 0.5, 0.0])
    assert [first[f"largest_mean_{span}"] for span in ("0.1", "1", "10")] == pytest.approx([800.0, 400.0, 40.0])
    assert (first["impulse"], first["peak"], first["time"]) == pytest.approx((400.0, 800.0, 12.0))
    # A mean over a step is that of the ramp in its middle; so are those over more steps.
    assert second["time_above_500"] == pytest.approx(7.0)
    assert [second[f"largest_mean_{span}"] for span in ("0.1", "1", "10")] == pytest.approx([1195.0, 1150.0, 700.0])
    assert second["impulse"] == pytest.approx(50 * 12.0**2)
    assert seen.summary["exposure"]["impulse"]["max_id"] == "1"


def test_exposure_needs_no_row_of_each_step(lemons, tmp_path):
    """Rows of every fifth step have the squeeze of those between, so means over times of rows are the same."""
    run = ["run", TRIAL_DOOR, "--until", 5, "--step", 0.02, "-o"]
    for name, every in ("all", 1), ("few", 5):
        call(lemons, *run, f"{name}.csv", "--every", every, "--outputs", f"{name}_outputs.csv")
    every, few = (measure(f"{name}.csv", above=[100], over=1).people for name in ("all", "few"))
    assert (every["impulse"] > 0).sum() > 10
    for name in "time", "impulse", "peak":
        np.testing.assert_allclose(few[name], every[name], rtol=1e-9)
    # Within a row the squeeze counts as its mean.
    np.testing.assert_allclose(few["largest_mean_1"], every["largest_mean_1"], rtol=0.1)
    assert (few["largest_mean_1"] <= every["largest_mean_1"] * (1 + 1e-9)).all()


def test_a_trial_is_run_as_lemons_run_does(lemons, walk):
    seen = measure(TRIAL_DOOR, lines={"door": DOOR}, above=[1000], until=8)
    recorded = measure(walk, trial=TRIAL_DOOR, lines={"door": DOOR}, above=[1000])
    for name in ("flow", "gaps", "density", "people"):
        pd.testing.assert_frame_equal(getattr(seen, name), getattr(recorded, name), rtol=1e-9, check_exact=False)
    assert seen.summary["exposure"] is not None


def test_a_run_of_python_is_measured(lemons, pack):
    with lemons_fmu.Crowd(pack(TRIAL_PUSH)) as crowd:
        run = crowd.run(until=1.0)
    seen = measure(run, above=[500])
    steps = np.diff(run.times)[:, None]
    assert np.allclose(seen.people["impulse"], (run.mean_squeeze[1:] * steps).sum(axis=0), rtol=1e-9)
    assert np.allclose(seen.people["time_above_500"], ((run.mean_squeeze[1:] > 500) * steps).sum(axis=0))
    assert (seen.people["peak"] == run.peak_squeeze[1:].max(axis=0)).all()
    # 0.05 s between frames: a window of two steps.
    pairs = run.mean_squeeze[1:]
    assert np.allclose(seen.people["largest_mean_0.1"], ((pairs[1:] + pairs[:-1]) / 2).max(axis=0), rtol=1e-6)
    assert seen.people["largest_mean_10"].isna().all()
    by_walls = run.mean_wall_squeeze[1:]
    by_people = run.mean_squeeze[1:] - by_walls
    for part, name in (by_walls, "walls"), (by_people, "people"):
        assert np.allclose(seen.people[f"impulse_by_{name}"], (part * steps).sum(axis=0), rtol=1e-9)
        mean = ((part[1:] + part[:-1]) / 2).max(axis=0)
        assert np.allclose(seen.people[f"largest_mean_0.1_by_{name}"], mean, rtol=1e-6, atol=1e-9)
        assert seen.summary["exposure"][f"by_{name}"]["impulse"]["max"] == seen.people[f"impulse_by_{name}"].max()


def test_walls_get_what_they_give(lemons, pack, tmp_path):
    # One panel for each straight piece.
    whole = measure(TRIAL_DOOR, until=6, walls=True, panel_length=100)
    walls, panels, people = whole.walls, whole.panels, whole.people
    assert panels["impulse"].sum() == pytest.approx(people["impulse_by_walls"].sum(), rel=1e-12) and panels["impulse"].sum() > 100
    assert walls["impulse"].sum() == pytest.approx(panels["impulse"].sum(), rel=1e-12)
    assert np.allclose(people["impulse_by_people"] + people["impulse_by_walls"], people["impulse"], rtol=1e-12)
    assert (panels["load_1"] <= panels["load_step"]).all() and (panels["load_step"] <= panels["load_peak"]).all()
    corners = [[corner.get("Coordinates") for corner in wall] for wall in ET.parse(TRIAL_DOOR / "static/Geometry.xml").iter("Wall")]
    ends = [f"{a},{b}".split(",") for wall in corners for a, b in zip(wall, wall[1:], strict=False)]
    assert (panels[["x1", "y1", "x2", "y2"]].to_numpy() == np.array(ends, dtype=float)).all()
    assert panels["panel"].tolist() == list(range(len(ends)))
    # Half a metre: the same forces, where they are; each second with the greatest mean lies within the run.
    halves = measure(TRIAL_DOOR, until=6, walls=True).panels
    assert len(halves) == np.ceil(panels["length"] / 0.5 - 1e-9).sum() and halves["length"].max() <= 0.5 + 1e-9
    assert halves["impulse"].sum() == pytest.approx(panels["impulse"].sum(), rel=1e-12)
    touched = halves[halves["impulse"] > 0]
    assert len(touched) >= 4 and touched["load_1_at"].between(1, 6 + 1e-9).all()
    # From the outputs of FMUs of both versions, too: the bits are the same.
    pushed = {"until": 1, "walls": True, "set": "agent[4].Fp.x=800"}
    of_trial = measure(TRIAL_PUSH, **pushed, panel_length=100).panels
    assert of_trial["impulse"].max() > 1
    for fmi in "2", "3":
        assert measure(pack(TRIAL_PUSH, options=["--fmi", fmi]), **pushed).panels.equals(of_trial)
    # Where the walls of the packed Trial have panels, they are outputs: loads, so the last digits are others.
    halves = tmp_path / "halves"
    shutil.copytree(TRIAL_PUSH, halves)
    geometry = halves / "static/Geometry.xml"
    geometry.write_text(geometry.read_text().replace("MaterialId=", 'PanelLength="0.3" MaterialId='))
    of_trial = measure(halves, **pushed).panels
    assert len(of_trial) > 10 and of_trial["impulse"].max() > 1
    for fmi in "2", "3":
        of_fmu = measure(pack(halves, options=["--fmi", fmi]), **pushed).panels
        assert of_fmu["wall"].equals(of_trial["wall"])
        assert np.allclose(of_fmu.drop(columns="wall"), of_trial.drop(columns="wall"), rtol=1e-12, atol=0, equal_nan=True)


def test_what_is_wrong_is_said(lemons, walk, tmp_path):
    places = write_table(tmp_path / "places.csv", [[(0.0, 0.0)], [(1.0, 0.0)]])
    for words, code, said in [
        ([walk, "--line", "1,2,3"], 2, "two different points"),
        ([walk, "--line", "1,2,1,2"], 2, "two different points"),
        ([walk, "--line", "=1,2,3,4"], 2, "a name has"),
        ([walk, "--line", "1,2,3,nan"], 2, "two different points"),
        ([walk, "--line", "a=0,0,1,1", "--line", "a=0,0,2,2"], 2, 'two have the name "a"'),
        ([walk, "--line", "2=0,0,1,1", "--line", "0,0,2,2"], 2, 'two have the name "2"'),
        ([walk, "--line", "0,0,1,1", "--window", "1e-9"], 2, "more than a million windows"),
        ([walk, "--window", "0"], 2, "positive number"),
        ([walk, "--width", "1"], 2, "--line"),
        ([walk, "--area", "5,5,1,1"], 2, "the lower left and the upper right corner"),
        ([walk, "--area", "0,0,1,1,1,0,0,1"], 2, "does not cross itself"),
        ([walk, "--area", "0,0,1,1,1"], 2, "three corners"),
        ([walk, "--above", "200,100"], 2, "rising"),
        ([walk, "--above", "-3"], 2, "not below 0"),
        ([walk, "--from", "5", "--until", "2"], 2, "not before the end"),
        ([walk, "--from", "20"], 1, "no frame between --from and --until"),
        ([places, "--above", "100"], 1, "do not contain the mean squeeze"),
        ([walk, "--walls", "--trial", TRIAL_DOOR], 1, "do not contain the forces on walls"),
        ([walk, "--plot", "picture.txt"], 2, ".png, .svg or .pdf"),
        ([walk, "--summary", walk], 1, "reads it"),
        ([walk, "--area", "0,0,1,1", "--walkable", "none.wkt"], 1, "--walkable none.wkt"),
    ]:
        done = call(lemons, "measure", *words, code=code)
        assert said in done.stderr, (words, done.stderr)
    assert "the squeeze" not in call(lemons, "measure", places, "--line", "0.5,-1,0.5,1").stdout
    with pytest.raises(CommandError, match="two different points"):
        measure(walk, lines={"door": (0, 0, 0, 0)})


@pytest.mark.long
def test_the_room_of_the_readme_is_empty_in_two_commands(lemons, tmp_path):
    """The commands as README.md has them; against the table of `lemons run`, read here."""
    text = (REPOSITORY / "README.md").read_text()
    make, measured = (re.search(f"^lemons ({words})$", text, re.MULTILINE)[1] for words in ("crowd .* --leave -o room", "measure room .*"))
    for words in (make, measured + " --summary room.json"):
        subprocess.run([lemons, *words.split()], cwd=tmp_path, check=True, capture_output=True)
    assert "mean squeeze over 1 s" in (tmp_path / "room.svg").read_text()
    run = [lemons, "run", "room", "--until", "left", "-o", "room.csv"]
    subprocess.run(run, cwd=tmp_path, check=True, capture_output=True)
    table = pd.read_csv(tmp_path / "room.csv", dtype=str).astype(float)
    summary = json.loads((tmp_path / "room.json").read_text())
    assert summary["until"] == table["t"].iloc[-1]
    out = table[table["active"] == 0].groupby("id")["t"].min()
    assert len(out) == 80 and out.max() == summary["until"]
    # Everybody passed the door, at x = 8 m, before the line behind it.
    door = table[table["x"] > 8.0].groupby("id")["t"].min()
    (right,) = (way for way in summary["lines"][0]["directions"] if way["direction"] == "right")
    assert right["people"] == 80 and door.max() - 0.01 <= right["last"] <= door.max()
    # Who has left already cannot be measured until then.
    refused = [lemons, "measure", "room.csv", "--until", "left", "--line", "8,2.5,8,3.5"]
    done = subprocess.run(refused, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2 and "earlier results have an end" in done.stderr
