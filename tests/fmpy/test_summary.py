"""The summary FMU: a crowd and its Decision in one, in a few plain scalars. The outside: tables of `lemons run` and of
`lemons measure` of the same Trial, and other masters."""

import csv
import json
import re
import subprocess
import sys
import zipfile

import documented
import pytest
from crowd import REPOSITORY, TRIAL_DOOR, Crowd, bits
from crowd import refused as refused_call
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import fmi2Discard
from fmpy.validation import validate_fmu
from masters import Job, run
from test_fmutool import check
from test_reference_variables import described, rows_of_2

STEP = 1 / 16  # s: exact in all masters
STEPS = 192
ROOM = ["-n", "30", "--box", "8x5", "--leave", "--seed", "1", "--door", "8,2.5,1.2", "--panel-length", "2", "--time-step", "0.0625"]
AREA = "front=5,0,8,5"
BOTH = pytest.mark.parametrize("fmi", ["2", "3"])


@pytest.fixture(scope="session")
def room(lemons, tmp_path_factory):
    """Thirty people who leave a room by its door."""
    path = tmp_path_factory.mktemp("summary") / "room"
    subprocess.run([lemons, "crowd", *ROOM, "-o", path], check=True, capture_output=True)
    return path


@pytest.fixture
def summary(pack, room):
    """Packs the summary of the room; two panels beside the door are in it."""
    options = ["--interface", "summary", "--area", AREA, "--area", "all=-2,-2,10,7", "--panel", "0", "--panel", "12"]
    return lambda fmi="2": pack(room, options=[*options, "--fmi", fmi])


def variables(fmu):
    return read_model_description(str(fmu), validate=False).modelVariables


def outputs(fmu):
    return [of.name for of in variables(fmu) if of.causality == "output"]


def job(fmu, inputs=()):
    names = outputs(fmu)
    return names, Job(fmus={"crowd": str(fmu)}, steps=STEPS, watch=[["crowd", name] for name in names], inputs=list(inputs))


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_same_bits_as_run_and_measure(lemons, room, summary, tmp_path, row):
    fmu = summary()
    names, of_room = job(fmu)
    seen, said = run("fmpy", of_room)
    assert said == ""
    for tool, package in [("ecos", "ecospy"), ("libcosim", "libcosimpy")]:
        if tool == "libcosim" and sys.version_info < (3, 11):
            continue  # it has no wheel for this Python
        others, said = run(tool, of_room)
        assert said == "" and bits(others) == bits(seen)
        row(package, "the summary FMU: 30 people leave a room", "same bits as FMPy, as `lemons run` and `lemons measure`")
    row("fmpy", "the summary FMU: 30 people leave a room", "same bits as `lemons run` and `lemons measure`")
    columns = dict(zip(names, zip(*seen, strict=True), strict=True))
    until = ["--until", str(STEPS * STEP), "--step", str(STEP), "--force"]
    # A run of the FMU, too.
    subprocess.run([lemons, "run", fmu, *until, "--outputs", tmp_path / "o.csv"], check=True, capture_output=True)
    for name, column in columns.items():
        own = [float(line[name]) for line in table(tmp_path / "o.csv")]
        assert own[1:] == list(column), name
    # `-o` is the same table, since nothing else is written.
    subprocess.run([lemons, "run", fmu, *until, "-o", tmp_path / "same.csv"], check=True, capture_output=True)
    assert (tmp_path / "same.csv").read_text() == (tmp_path / "o.csv").read_text()
    # Frames of the Trial, in table and measures.
    subprocess.run([lemons, "run", room, *until, "-o", tmp_path / "t.csv"], check=True, capture_output=True)
    there = {}
    for line in table(tmp_path / "t.csv"):
        there[float(line["t"])] = there.get(float(line["t"]), 0) + int(line["active"])
    there = list(there.values())[1:]
    assert list(columns["people_inside"]) == there
    assert list(columns["people_left"]) == list(columns["exit1_left"]) == [30 - here for here in there]
    assert there[-1] < 20
    measure = [lemons, "measure", room, *until, "--area", AREA, "--walls", "-o", tmp_path / "m"]
    subprocess.run(measure, check=True, capture_output=True)
    density = [float(line["density"]) for line in table(tmp_path / "m" / "density.csv")]
    assert density[1:] == list(columns["area1_density"])
    panels = {line["panel"]: float(line["load_step"]) for line in table(tmp_path / "m" / "panels.csv")}
    assert [panels["0"], panels["12"]] == [max(columns["barrier1_load"]), max(columns["barrier2_load"])]
    assert min(panels["0"], panels["12"]) > 0
    # Of means over a second that end at a communication point.
    greatest = max(float(line["largest_mean_1"]) for line in table(tmp_path / "m" / "people.csv"))
    assert max(columns["area2_squeeze_max"]) == greatest > 100
    assert json.loads((tmp_path / "m" / "summary.json").read_text())["left"]["people"] == columns["people_left"][-1]


def test_same_bits_with_inputs(summary):
    """A push and another speed, which change while it runs."""
    fmu = summary()
    values = [[("push", 60.0 if 30 <= k < 90 else 0.0), ("speed_factor", 1.0 if k < 60 else 1.4)] for k in range(STEPS)]
    _, of_room = job(fmu, [[[["crowd", name], value] for name, value in of_step] for of_step in values])
    seen, said = run("fmpy", of_room)
    assert said == "" and bits(seen) != bits(run("fmpy", job(fmu)[1])[0])
    for tool in ["ecos"] + ["libcosim"] * (sys.version_info >= (3, 11)):
        others, said = run(tool, of_room)
        assert said == "" and bits(others) == bits(seen)


@BOTH
def test_valid(summary, fmi, row):
    fmu = summary(fmi)
    assert validate_fmu(str(fmu)) == []
    names = [variable.name for variable in variables(fmu)]
    assert len(names) < 50 and all(re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name) for name in names)
    with zipfile.ZipFile(fmu) as archive:
        assert len(archive.read("modelDescription.xml")) < 30_000
    row("fmpy", f"FMI {fmi}.0: `validate_fmu`, the summary FMU", "no problem")
    code, said = check(fmu)
    assert code == 0 and "No semantic error" in said, said
    row("fmu-manipulation-toolbox", f"FMI {fmi}.0: `fmutool -check`, the summary FMU", "compliant, no semantic error")


def test_both_versions_show_the_same(summary, row):
    runs = [simulate_fmu(str(summary(fmi)), stop_time=8.0, output_interval=STEP) for fmi in "23"]
    assert runs[0].dtype.names == runs[1].dtype.names and (runs[0] == runs[1]).all()
    assert runs[0]["people_left"][-1] > 0
    row("fmpy", "FMI 3.0: `simulate_fmu` of the summary FMU", "the bits of the FMI 2.0 FMU")


def test_state(summary, instantiate, row):
    """With inputs in it: another instance stops at the same place, and goes on."""
    first = instantiate(summary()).initialize()
    first["speed_factor"] = 1.3
    for _ in range(40):
        first.step(STEP)
    first["stop"] = True
    first.step(STEP)
    state = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
    other = instantiate(first.directory)
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(state))
    other.time = first.time
    assert other["stop"] and other["speed_factor"] == 1.3
    names = [name for name, of in first.variables.items() if of.causality == "output"]
    seen = []
    for crowd in (first, other):
        for k in range(60):
            crowd["stop"] = k < 20
            crowd.step(STEP)
        seen.append([crowd[name] for name in names])
    assert seen[0] == seen[1]
    row("fmpy", "the summary FMU: the state as bytes to another instance", "same bits as without")


def test_a_state_has_the_tolerance_and_is_of_these_slots(pack, room, summary, instantiate):
    def squeezed(fmu):
        for k in range(32, 48):
            fmu.fmu.doStep(k * STEP, STEP)
        return fmu["area2_squeeze_max"]

    def begun(fmu, tolerance=None):
        fmu.fmu.setupExperiment(startTime=0.0, tolerance=tolerance)
        fmu.fmu.enterInitializationMode()
        at_start = fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())
        assert fmu["people_inside"] == 30
        # What was read does not count.
        fmu.fmu.setFMUstate(fmu.fmu.deSerializeFMUstate(at_start))
        assert fmu["people_inside"] == 30
        fmu.fmu.exitInitializationMode()
        for k in range(32):
            fmu.fmu.doStep(k * STEP, STEP)
        return fmu

    first, coarse, other = (instantiate(summary()) for _ in range(3))
    state = begun(first, 1e-7).fmu.serializeFMUstate(first.fmu.getFMUstate())
    wanted = squeezed(first)
    assert wanted != squeezed(begun(coarse))
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(state))
    assert squeezed(other) == wanted
    elsewhere = instantiate(pack(room, options=["--interface", "summary", "--area", "front=0,0,1,5", "--area", "all=-2,-2,10,7", "--panel", "0", "--panel", "12"]))
    with refused_call(elsewhere, "another summary"):
        elsewhere.fmu.setFMUstate(elsewhere.fmu.deSerializeFMUstate(state))


def test_a_door_that_is_shut_at_the_start(lemons, tmp_path, pack, instantiate):
    """The outside: `lemons run` with the same input. People lean on it from the start."""
    options = ["-n", "12", "--box", "3x2", "--leave", "--seed", "1", "--door", "3,1,1.2,0,1e6", "--region", "2,0,3,2", "--allow-overlap", "--time-step", "0.0625"]
    subprocess.run([lemons, "crowd", *options, "-o", "T"], check=True, capture_output=True, cwd=tmp_path)
    run_of = [lemons, "run", "T", "--set", "door[0].Open=false", "--until", "4", "--step", repr(STEP), "-o", "t.csv"]
    subprocess.run(run_of, check=True, capture_output=True, cwd=tmp_path)
    fmu = instantiate(pack(tmp_path / "T", options=["--interface", "summary"]))
    fmu.fmu.setupExperiment(startTime=0.0)
    fmu.fmu.enterInitializationMode()
    fmu["door1_open"] = False
    fmu.fmu.exitInitializationMode()
    for k in range(64):
        fmu.fmu.doStep(k * STEP, STEP)
    left = sum(row["active"] == "0" for row in table(tmp_path / "t.csv")[-12:])
    assert fmu["exit1_left"] == left == 0


def test_the_table_of_the_page(lemons, tmp_path):
    """Of a Trial that has one of each."""
    trial = tmp_path / "each"
    subprocess.run(["cp", "-r", TRIAL_DOOR, trial], check=True)
    geometry = trial / "static" / "Geometry.xml"
    gate = '<Wall Id="gate" MaterialId="concrete" Open="0,1e9"><Corner Coordinates="5,2.1"/><Corner Coordinates="5,2.9"/></Wall>'
    text = geometry.read_text().replace('<Wall Id="0"', '<Wall Id="0" PanelLength="100"')
    geometry.write_text(text.replace("</Geometry>", gate + "</Geometry>"))
    exits = 'exits = [{ name = "end", line = [[13.0, 1.5], [13.0, 3.5]] }]'
    (trial / "decision.toml").write_text(f'balance = "pendulum"\n{exits}\n[[sources]]\npeople = ["29"]\nrate = 0.5\n')
    options = ["--interface", "summary", "--area", AREA, "--panel", "0"]
    rows = []
    for name, *cells, description in rows_of_2(*described(lemons, trial, *options)):
        kind, unit, causality, _, start = cells
        description = re.sub(r'^(exit|door|area|panel)[^"]*"[^"]*"[^:"]*: ', "", description)
        rows.append([re.sub(r"^`(exit|door|area|barrier)1_", r"`\1k_", name), kind, unit, causality, start, description])
    assert len(rows) == 18, "one of each"
    header = ["name", "type", "unit", "causality", "start", "meaning"]
    documented.check("summary", header, rows, page=REPOSITORY / "docs" / "summary.md")


def refused(lemons, *words):
    done = subprocess.run([lemons, "pack", *words], capture_output=True, text=True)
    assert done.returncode != 0
    return done.stderr


def test_what_does_not_fit_is_refused(lemons, room, tmp_path):
    fmu = ["-o", tmp_path / "no.fmu"]
    said = refused(lemons, room, "--interface", "summary", *fmu)
    assert re.search(r"there are \d+ panels of walls, and a summary has room for 4: choose with --panel NUMBER", said)
    assert re.search(r'  panel 1, of the wall "0" from \(8.0, 5.0\) to \(6.0, 5.0\) m\n', said)
    exits = ", ".join(f'{{ name = "e{k}", line = [[5.0, {2 + 0.2 * k}], [5.0, {2.15 + 0.2 * k}]] }}' for k in range(5))
    trial = tmp_path / "five"
    subprocess.run(["cp", "-r", TRIAL_DOOR, trial], check=True)
    (trial / "decision.toml").write_text(f"exits = [{exits}]\n")
    said = refused(lemons, trial, "--interface", "summary", *fmu)
    assert "there are 5 exits, and a summary has room for 4: choose with --exit NAME" in said
    assert "--interface summary" in refused(lemons, trial, "--exit", "e1", *fmu)
    assert "is not there (there are e0, e1, e2, e3, e4)" in refused(
        lemons, trial, "--interface", "summary", "--exit", "door", *fmu
    )
    subprocess.run([lemons, "pack", trial, "--interface", "summary", "--exit", "e3", "--exit", "e1", *fmu], check=True)
    described = {of.name: of.description for of in variables(tmp_path / "no.fmu")}
    assert described["exit1_left"].startswith('exit "e3":') and described["exit2_left"].startswith('exit "e1":')
    assert "exit3_left" not in described


@BOTH
def test_inputs_have_bounds(summary, instantiate, fmi):
    """A description says them, and a refusal."""
    fmu = summary(fmi)
    of = {variable.name: variable for variable in variables(fmu)}
    assert (float(of["push"].declaredType.min), float(of["push"].max), of["push"].declaredType.nominal) == (0.0, 2000.0, "100.0")
    assert of["push"].declaredType.displayUnit is None and float(of["speed_factor"].max) == 10.0
    if fmi == "3":
        return
    crowd = instantiate(fmu)
    for name, value, told in (("push", 2001.0, "from 0 to 2000"), ("speed_factor", -0.5, "from 0 to 10"), ("push", float("nan"), "from 0 to 2000")):
        with refused_call(crowd, f"{name} = {value}: must be {told}".replace("nan", "NaN"), status=fmi2Discard):
            crowd[name] = value
    crowd["push"] = 2000.0


def test_what_a_newcomer_is_told(lemons, room, tmp_path):
    options = ["--interface", "summary", "--panel", "0", "--area", "far=60,0,70,5"]
    for command in (["describe", room], ["pack", room, "-o", tmp_path / "far.fmu"]):
        done = subprocess.run([lemons, *command, *options], capture_output=True, text=True)
        assert done.returncode == 0 and 'note: the area "far" is outside of the walls around people' in done.stderr
    listed = subprocess.run([lemons, "info", tmp_path / "far.fmu"], capture_output=True, text=True, check=True).stdout
    assert re.search(r"^people_inside +output Integer +people who are there$", listed, re.MULTILINE)
    left = subprocess.run([lemons, "run", tmp_path / "far.fmu", "--until", "left"], capture_output=True, text=True)
    assert left.returncode != 0 and "no variables of each person" in left.stderr


def test_who_leaves_waits_for_the_exit(summary, tmp_path):
    """As a newcomer drives it: the script of docs/summary.md is of this kind."""
    crowd = Crowd(extract(str(summary()), str(tmp_path / "fmu"))).instantiate().initialize()
    crowd["exit1_open"] = False
    for _ in range(100):
        crowd.step(STEP)
    assert crowd["people_left"] == 0 and crowd["exit1_queue"] > 10
    crowd["exit1_open"] = True
    for _ in range(100):
        crowd.step(STEP)
    assert crowd["exit1_flow"] > 0.3
    crowd.free()


def test_the_example_of_the_page(lemons, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (REPOSITORY / "docs/summary.md").read_text()
    commands, script, printed = (re.search(rf"```{kind}\n(.*?)```", page, re.DOTALL)[1] for kind in ("sh", "python", "text"))
    for command in commands.splitlines():
        subprocess.run([lemons, *command.split()[1:]], check=True, capture_output=True)
    capsys.readouterr()
    exec(script, {})
    assert capsys.readouterr().out == printed
    least, most = map(float, re.search(r"all leave the hall above after (\d+) to (\d+) s", page).groups())
    for step in (0.05, 0.5):
        result = simulate_fmu("summary.fmu", stop_time=30.0, output_interval=step, output=["people_inside"])
        assert least <= result["time"][result["people_inside"] == 0][0] <= most
