"""People that are made from Python are those that the command makes; packed and drawn they are what it packs and draws."""

import re
import subprocess
import tomllib
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from crowd import TRIAL_DOOR, TRIAL_PUSH

import lemons_fmu
from lemons_fmu import CommandError, Crowd, Trial, pack, person, plot, simulate
from lemons_fmu import crowd as make


@pytest.fixture(autouse=True)
def command(lemons, tmp_path, monkeypatch):
    monkeypatch.setenv("LEMONS", str(lemons))


def test_a_crowd_is_that_of_the_command(lemons, tmp_path):
    there = tmp_path / "there"
    words = ["crowd", "--number", "12", "--box", "2.5x1.75", "--seed", "7", "--speed", "0.5", "-o", there]
    subprocess.run([lemons, *words], check=True, capture_output=True)
    made = make(number=12, box=(2.5, 1.75), seed=7, speed=0.5)
    for file in ("static/Agents.xml", "static/Geometry.xml", "dynamic/AgentDynamics.xml"):
        assert (made.directory / file).read_bytes() == (there / file).read_bytes()
    saved = made.save(tmp_path / "saved")
    temporary = made.directory
    assert repr(made) == f"<Trial 'crowd': 12 people, {made.masses.sum():.0f} kg>"
    del made
    assert not temporary.exists() and len(saved) == len(Trial(there)) == 12


def test_a_mix_has_kinds_with_masses_and_speeds_of_their_own(tmp_path):
    made = make(number=60, box=(10, 8), door=(10, 4, 1.5), leave=True, mix={"adult": 50, "child": 30, "wheelchair": 20}, output=tmp_path / "mix")
    agents = ElementTree.parse(made.directory / "static/Agents.xml").getroot()
    kinds = [agent.get("Kind") for agent in agents]
    assert set(kinds) == {"adult", "child", "wheelchair"}
    speeds = tomllib.loads((made.directory / "decision.toml").read_text())["agents"]
    for k, (kind, mass) in enumerate(zip(kinds, made.masses, strict=True)):
        speed = speeds[str(k)]["desired_speed"]
        # Boyce and others 1999; a child of 2 years walks as it has the stature of one.
        low, high = {"adult": (0.56, 2.12), "child": (0.35, 2.12), "wheelchair": (0.13, 1.35)}[kind]
        assert low <= speed <= high
        assert mass > 50 if kind == "wheelchair" else mass > 9
    assert {shape.get("MaterialId") for agent in agents if agent.get("Kind") == "wheelchair" for shape in agent} == {"frame"}
    with pytest.raises(CommandError, match='there is no kind "unicycle" .did you mean "bicycle".*; kinds are adult, backpack, bicycle, child'):
        make(number=2, box=(3, 3), mix={"unicycle": 1})


def test_arrays_are_people_who_do_not_overlap(tmp_path):
    made = make(number=30, box=(3, 3), output=tmp_path / "crowd")
    assert made.poses.shape == (30, 3) and made.disks.shape == (150, 4)
    x, y, radius, who = made.disks.T
    inside = (radius <= x) & (x <= 3 - radius) & (radius <= y) & (y <= 3 - radius)
    assert inside.all()
    gaps = np.hypot(x[:, None] - x, y[:, None] - y) - radius[:, None] - radius
    assert gaps[who[:, None] != who].min() > -1e-9
    # The same poses and masses as the engine has, of the Trial in its FMU.
    with Crowd(made.pack(tmp_path / "crowd.fmu")) as packed:
        assert (packed.poses() == made.poses).all() and (packed.masses() == made.masses).all()


def test_one_person_has_the_shape_that_the_command_prints(lemons):
    measures = ["--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"]
    said = subprocess.run([lemons, "person", *measures], check=True, capture_output=True, text=True).stdout
    rows = [[float(word) for word in line.split()] for line in said.splitlines()[1:6]]
    one = person(breadth=0.49, depth=0.25, stature=1.75, mass=70)
    assert len(one) == 1 and one.masses[0] == 70 and one.statures[0] == 1.75 and one.poses[0, 2] == 0
    printed = np.array(rows)[:, [2, 3, 1]] / 100
    assert np.abs(one.shapes[0] - printed).max() < 1e-6
    # The breadth over the outermost disks.
    assert np.ptp([one.shapes[0][:, 1] + one.shapes[0][:, 2], one.shapes[0][:, 1] - one.shapes[0][:, 2]]) == pytest.approx(0.49)


def test_a_packed_trial_has_the_platforms_that_are_asked_for(tmp_path):
    file = pack(TRIAL_PUSH, tmp_path / "push.fmu", fmi=3, platforms=["linux64"])
    names = zipfile.ZipFile(file).namelist()
    assert [name for name in names if name.startswith("binaries/")] == ["binaries/x86_64-linux/CrowdMechanics.so"]
    with pytest.raises(CommandError, match="invalid value 'amiga' for '--platform"):
        pack(TRIAL_PUSH, tmp_path / "other.fmu", platforms=["amiga"])
    assert len(simulate(file, until=0.1)) == 15


def test_pictures_are_what_notebooks_show(tmp_path):
    trial = Trial(TRIAL_DOOR)
    svg = trial._repr_svg_()
    assert ElementTree.fromstring(svg).tag.endswith("svg")
    picture = trial.plot(fill="speed", format="png")
    assert picture._repr_png_().startswith(b"\x89PNG") and picture._repr_svg_() is None
    assert picture.save(tmp_path / "a.png").read_bytes() == picture.data
    with pytest.raises(ValueError, match="the picture is PNG"):
        picture.save(tmp_path / "a.svg")
    with pytest.raises(CommandError, match="invalid value 'colour'"):
        trial.plot(fill="colour")


def test_a_run_is_drawn_as_the_table_of_the_command(lemons, push_fmu, tmp_path):
    table, drawn = tmp_path / "run.csv", tmp_path / "drawn.svg"
    subprocess.run([lemons, "run", push_fmu, "--until", "0.5", "-o", table], check=True, capture_output=True)
    words = ["plot", table, "--trial", TRIAL_PUSH, "--at", "0.2,0.5", "-o", drawn]
    subprocess.run([lemons, *words], check=True, capture_output=True)
    with Crowd(push_fmu) as crowd:
        run = crowd.run(until=0.5)
    assert plot(run, trial=TRIAL_PUSH, at=[0.2, 0.5]).data == drawn.read_bytes()
    assert plot(run, at=[0.2, 0.5]).data == drawn.read_bytes(), "a run knows its Trial"


def test_a_run_shows_how_far_it_is(push_fmu, capsys):
    simulate(push_fmu, until=0.2, progress=True)
    said = capsys.readouterr().err.splitlines()
    assert said[-1].startswith("4 of 4 steps, ") and "failed" not in said[-1]
    simulate(push_fmu, until=0.2)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "file, old, new, said",
    [
        ("static/Agents.xml", ' Mass="', ' Mass="x', 'agent "0".*Mass="x.*not a number|Agents.xml.*Mass'),
        ("static/Agents.xml", "<Agents", "<!DOCTYPE a><Agents", "Agents.xml"),
        ("dynamic/AgentDynamics.xml", "<Kinematics", "<Cinematics", "AgentDynamics.xml.*inematics"),
        ("Parameters.xml", "<Directories", "<Where", "Parameters.xml.*Directories"),
    ],
)
def test_a_broken_trial_is_an_error_that_names_its_file(tmp_path, file, old, new, said):
    """The same messages as those of `lemons check`; tests of crates/core have them all."""
    trial = Trial(TRIAL_PUSH).save(tmp_path / "trial")
    path = trial.directory / file
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ValueError, match=said) as error:
        Trial(trial)
    assert str(path) in str(error.value)


def test_a_saved_trial_replaces_all_of_another_one(tmp_path):
    made = make(number=2)
    other = Trial(TRIAL_PUSH).save(tmp_path / "other")
    assert (other.directory / "drive.csv").exists()
    with pytest.raises(FileExistsError):
        made.save(tmp_path / "other")
    saved = made.save(tmp_path / "other", force=True)
    assert len(saved) == 2 and not (saved.directory / "drive.csv").exists()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("x")
    with pytest.raises(FileExistsError, match="is no Trial"):
        made.save(tmp_path / "mine", force=True)
    assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".")) == []


def test_numbers_of_numpy_are_numbers(tmp_path):
    assert len(make(number=np.int64(3), seed=np.uint8(2), allow_overlap=np.False_)) == 3
    # What nobody sees is not remembered.
    assert not (tmp_path / "state").exists()
    with pytest.raises(TypeError, match="give a list"):
        pack(TRIAL_PUSH, tmp_path / "x.fmu", platforms="linux64")


def test_without_the_command_only_fmus_are_not_packed(monkeypatch, tmp_path):
    """It has the libraries beside it; all else is in this process."""
    monkeypatch.setenv("LEMONS", str(tmp_path / "none"))
    assert len(make(number=2)) == 2
    with pytest.raises(CommandError, match="crowd_mechanics"):
        pack(TRIAL_PUSH, tmp_path / "x.fmu")


def test_all_that_is_exported_is_there():
    assert sorted(lemons_fmu.__all__) == sorted(set(lemons_fmu.__all__))
    assert all(hasattr(lemons_fmu, name) for name in lemons_fmu.__all__)


def test_several_doors_and_a_film(tmp_path):
    room = make(number=6, box=(5, 4), door=[[5, 2, 1], [0, 2.0, 1.2]], leave=True, seed=3)
    decision = (room.directory / "decision.toml").read_text()
    assert len(re.findall(r"line = ", decision)) == 2
    with pytest.raises(TypeError, match="not both"):
        make(number=6, box=(5, 4), door=[5, [0, 2, 1]])
    film = lemons_fmu.movie(room, tmp_path / "film.gif", until=1, fill="squeeze", over=0.5, width=200)
    with Image.open(film) as seen:
        assert seen.format == "GIF" and seen.n_frames > 10 and seen.size[0] == 200
    assert sorted(path.name for path in tmp_path.glob("*film*")) == ["film.gif"]
    with pytest.raises(lemons_fmu.CommandError, match="movies are"):
        lemons_fmu.movie(room, tmp_path / "film.avi")


def test_the_table_of_another_crowd_is_told(lemons, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in "12":
        subprocess.run([lemons, "crowd", "--number", "5", "--box", "3x3", "--seed", seed, "-o", f"room_{seed}"], check=True, capture_output=True)
    subprocess.run([lemons, "run", "room_1", "--until", "0.1", "-o", "run.csv"], check=True, capture_output=True)
    for words in (["plot", "run.csv", "-o", "a.png"], ["measure", "run.csv"], ["movie", "run.csv", "-o", "a.gif", "--until", "0.1"]):
        for seed, warned in (("1", False), ("2", True)):
            said = subprocess.run([lemons, *words, "--trial", f"room_{seed}", "--force"], capture_output=True, text=True, check=True).stderr
            assert ("5 of 5 people do not begin where they stand in the Trial" in said) is warned, said
