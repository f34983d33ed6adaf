"""What is probably not meant is said alike by `lemons check`, `lemons run` and the package; docs/reference/rules.md has the rules."""

import json
import pickle
import re
import subprocess
from urllib.parse import unquote

import pytest
from crowd import REPOSITORY, TRIAL_PUSH
from lemons_fmu import Crowd

#: Rules of `lemons check` alone.
OF_CHECK = {"step-accuracy", "drive-rows-between"}
#: Crowds by the command, files that are written into the Trial, and what must be found there.
STREET = ["-n", "12", "--box", "6x2"]
BOTH_WAYS = "exits = [{ line = [[5.5, 0.5], [5.5, 1.5]], share = 1 }, { line = [[0.5, 0.5], [0.5, 1.5]], share = 1 }]"
WIDE = "waypoints = [{ x = 50, y = 1 }]"
SCENES = {
    "straight": (STREET, f"model = 'straight'\nseed = 3\n{BOTH_WAYS}\n[agents.3]\ndesired_speed = 5.0", {"straight-model-presses", "straight-model-counterflow", "too-fast"}),
    "speed": (STREET, f"model = 'collision-free-speed'\nseed = 3\n{BOTH_WAYS}", {"collision-free-speed-flow", "collision-free-speed-counterflow"}),
    "force": (STREET, f"model = 'social-force'\nseed = 3\n{BOTH_WAYS}", {"social-force-flow", "social-force-counterflow"}),
    "rotational": (STREET, f"model = 'rotational'\npush = 300\nseed = 3\n{BOTH_WAYS}", {"flat-push"}),
    "way": (STREET, f"{WIDE}", {"way-through-wall"}),
    "point": (STREET, "waypoints = [{ x = 3, y = 0.0, radius = 0.01 }]", {"way-point-out-of-reach"}),
    "exit": (STREET, "exits = [{ line = [[1, 1.9], [5, 1.9]] }]", {"exit-out-of-reach"}),
}


def found(lemons, trial):
    """Returns the ids of what `check` finds, and the lines that everybody says."""
    done = subprocess.run([lemons, "check", "--json", trial], capture_output=True, text=True, check=True)
    results = json.loads(done.stdout)["runs"][0]["results"]
    file = lambda result: unquote(result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]).removeprefix("file://")
    driver = json.loads(done.stdout)["runs"][0]["tool"]["driver"]
    strings = {rule["id"]: {**driver["globalMessageStrings"], **rule["messageStrings"]} for rule in driver["rules"]}
    for result in results:
        # The sentence with its values is what is said; before it may be an element with its attribute.
        message, sentence = result["message"], strings[result["ruleId"]][result["message"]["id"]]["text"]
        assert message["text"].endswith(sentence.format(*message["arguments"])), message
    lines = [f"{result['level']}: {file(result)}: {result['message']['text']}" for result in results if result["ruleId"] not in OF_CHECK]
    return {result["ruleId"] for result in results}, lines


def said_by_run(lemons, trial, until, at):
    done = subprocess.run([lemons, "run", trial, "--until", until, "-o", at / "run.csv", "--force"], capture_output=True, text=True, check=True)
    return [line for line in done.stderr.splitlines() if re.match("(warning|note): ", line)]


@pytest.mark.parametrize("name", SCENES)
def test_where_people_walk_is_examined_alike(lemons, tmp_path, name):
    crowd, decision, wanted = SCENES[name]
    trial = tmp_path / "a crowd"
    subprocess.run([lemons, "crowd", *crowd, "-o", trial], capture_output=True, check=True)
    (trial / "decision.toml").write_text(decision)
    ids, lines = found(lemons, trial)
    assert wanted <= ids, ids
    assert said_by_run(lemons, trial, "0.01", tmp_path) == lines
    with Crowd(trial) as made:
        assert made.messages == lines
        assert {found.rule for found in made.messages} == ids - OF_CHECK
        assert [f"{found.severity}: {found.subject}: {found.message}" for found in made.messages] == lines
        assert [pickle.loads(pickle.dumps(found)).rule for found in made.messages] == [found.rule for found in made.messages]


def test_drives_and_legs_are_examined_alike(lemons, tmp_path):
    trial = tmp_path / "legs"
    subprocess.run(["cp", "-r", TRIAL_PUSH, trial], check=True)
    parameters = trial / "Parameters.xml"
    parameters.write_text(parameters.read_text().replace('TimeStep="0.05"', 'TimeStep="1.0"').replace('TimeStepMechanical="2e-6"', 'TimeStepMechanical="1e-4"'))
    (trial / "decision.toml").write_text("balance = 'two-level'")
    ids, lines = found(lemons, trial)
    assert ids >= {"drive-added", "legs-late", "drive-rows-missed"}, ids
    with Crowd(trial) as crowd:
        assert crowd.messages == lines
    # Here the drive may be another file.
    run = [line.replace("warning: drive: ", f"warning: {trial}/drive.csv: ").replace("warning: communication", f"warning: {trial}/decision.toml: communication") for line in said_by_run(lemons, trial, "1", tmp_path)]
    assert sorted(run) == sorted(lines)


def test_what_is_wrong_is_told_with_its_value_and_its_file(lemons, tmp_path):
    trial = tmp_path / "push"
    subprocess.run(["cp", "-r", TRIAL_PUSH, trial], check=True)
    agents = trial / "static/Agents.xml"
    agents.write_text(re.sub('Mass="[^"]*"', 'Mass="80000"', agents.read_text(), count=1))
    other = tmp_path / "other.csv"
    other.write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,1e6,0,0\n0.5,0,0,0,0\n")
    _, lines = found(lemons, trial)
    assert any('Mass="80000.0"' in line for line in lines), lines
    told = subprocess.run([lemons, "run", trial, "--drive", other, "--until", "0.05", "-o", tmp_path / "run.csv"], capture_output=True, text=True, check=True)
    assert f"warning: {other}: Fp=" in told.stderr and "Mass=\"80000.0\"" in told.stderr


def test_heights_that_are_hardly_meant_are_told(lemons, tmp_path):
    trial = tmp_path / "levels"
    subprocess.run([lemons, "crowd", *STREET, "--levels", "2", "-o", trial], capture_output=True, check=True)
    ids, _ = found(lemons, trial)
    assert not ids & {"chest-at-no-disk", "load-length"}, ids
    agents, materials = trial / "static/Agents.xml", trial / "static/Materials.xml"
    agents.write_text(re.sub('ChestHeight="[^"]*"', 'ChestHeight="3.0"', agents.read_text(), count=2))
    materials.write_text(re.sub('LoadLength="[^"]*"', 'LoadLength="0.3"', materials.read_text()))
    ids, lines = found(lemons, trial)
    assert ids >= {"chest-at-no-disk", "load-length"}, ids
    assert any("ChestHeight 3.0 m (2 agents in all)" in line for line in lines), lines
    # The two slabs are from 0.5 m to 1.7 m.
    assert any("4.0 times the stiffness of the plan view (12 agents in all): is LoadLength, 0.3 m, right?" in line for line in lines), lines


def test_the_end_of_a_run_is_told_alike(lemons, tmp_path):
    trial = tmp_path / "wall"
    subprocess.run([lemons, "crowd", "--box", "2x2", "--number", "12", "-o", trial], capture_output=True, check=True)
    (trial / "decision.toml").write_text(f"model = 'straight'\n{WIDE}")
    last = said_by_run(lemons, trial, "6", tmp_path)[-1]
    assert "press on and get no further" in last
    with Crowd(trial) as crowd:
        crowd.run(until=3.0)
        crowd.run(until=6.0)
        assert crowd.messages[-1] == last


def test_every_rule_is_on_the_page_with_its_level(lemons):
    done = subprocess.run([lemons, "check", "--json", TRIAL_PUSH], capture_output=True, text=True, check=True)
    rules = json.loads(done.stdout)["runs"][0]["tool"]["driver"]["rules"]
    page = (REPOSITORY / "docs/reference/rules.md").read_text()
    rows = re.findall(r"^\| `([a-z-]+)` \| (\w+) \| .* \| (.*) \| (.*) \|$", page, re.MULTILINE)
    assert rows == [(rule["id"], rule["defaultConfiguration"]["level"], rule["shortDescription"]["text"], rule["help"]["text"]) for rule in rules]
