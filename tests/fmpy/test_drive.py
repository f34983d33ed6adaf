"""A packed drive.csv is played by the FMU itself: importers that know nothing of it show the push, with the bits of `lemons run`."""

import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from crowd import TRIAL_DOOR, TRIAL_PUSH, bits, ids_of, outputs, push_job, read_table
from fmpy import simulate_fmu
from lemons_fmu import Crowd, simulate
from masters import run

@pytest.mark.parametrize("start", [False, True], ids=["as it is", "all start values set"])
def test_fmpy_shows_the_push(push_fmu, pushed, row, start):
    """No input, no parameter; also if FMPy sets all start values of the model description again."""
    result = simulate_fmu(push_fmu, stop_time=2.0, output=outputs(5), apply_default_start_values=start)
    seen = [[result[name][k].item() for name in outputs(5)] for k in range(1, len(result))]
    assert bits(seen) == bits(pushed(40, 0.05))
    assert seen[-1][0] > 0.2, "it was pushed"
    row("fmpy", "`simulate_fmu` of a packed push, without inputs", "same bits as `lemons run`")


def test_fmpy_shows_the_push_in_fmi_3(pack, pushed, row):
    fmu = pack(TRIAL_PUSH, options=["--fmi", "3"])
    names = ["Position", "Velocity", "Theta", "Omega", "AgentContacts", "WallContacts", "ContactingAgents", "NormalForce"]
    result = simulate_fmu(fmu, stop_time=2.0, output=names)
    columns = np.concatenate([result[name].reshape(len(result), 5, -1).astype(float) for name in names], axis=2)
    seen = columns[1:].reshape(len(result) - 1, -1).tolist()
    assert bits(seen) == bits([[float(number) for number in numbers] for numbers in pushed(40, 0.05)])
    row("fmpy", "FMI 3.0: `simulate_fmu` of a packed push, without inputs", "same bits as `lemons run`")


@pytest.mark.parametrize("tool, package", [("libcosim", "libcosimpy"), ("ecos", "ecospy")])
def test_other_tools_show_the_push(push_fmu, pushed, row, tool, package):
    if tool == "libcosim" and sys.version_info < (3, 11):
        pytest.skip("libcosimpy has no wheel for this Python")
    job = replace(push_job(push_fmu, 40), inputs=[])
    seen, said = run(tool, job)
    assert said == ""
    assert bits(seen) == bits(pushed(job.steps, job.step))
    row(package, "a packed push, without inputs", "same bits as `lemons run`")


def test_commands_do_not_push_twice(lemons, push_fmu, tmp_path):
    """The Trial, its FMU, the same drive given as a file, and the package: one table. Without the drive: another."""

    def table(*arguments):
        output = tmp_path / "table.csv"
        subprocess.run(
            [lemons, "run", *arguments, "--until", "1", "-o", output, "--force"], check=True, capture_output=True
        )
        return output.read_text()

    file = TRIAL_PUSH / "drive.csv"
    pushed = table(TRIAL_PUSH)
    assert read_table(pushed, ids_of(TRIAL_PUSH))[-1][1][0][0] > 0.2
    assert pushed == table(push_fmu) == table(push_fmu, "--drive", file) == table(TRIAL_PUSH, "--drive", file)
    still = table(push_fmu, "--no-drive")
    assert still == table(push_fmu, "--set", "PlayDrive=false") != pushed
    # A file for one agent leaves nobody else to the packed drive.
    other = tmp_path / "other.csv"
    other.write_text("t,agent,Fp.x,Fp.y,Mp\n0,3,0,0,0\n5,3,0,0,0\n")
    assert table(push_fmu, "--drive", other) == still
    # An agent whose propulsion is set has no other.
    held = table(push_fmu, "--set", "agent[0].Fp.x=500")
    assert held == table(push_fmu, "--no-drive", "--set", "agent[0].Fp.x=500") != pushed
    with Crowd(push_fmu) as crowd:
        assert crowd.run(False, until=1.0).frame().equals(simulate(push_fmu, False, until=1.0))
        assert np.all(crowd.velocities() == 0.0)


def test_who_decides_drives_alone(lemons, decide, pack, tmp_path):
    """Decision sets what drives everybody in each step, so a packed drive moves nobody; and where nobody decides, it does."""
    trial = tmp_path / "driven"
    shutil.copytree(TRIAL_DOOR, trial)
    (trial / "drive.csv").write_text("t,agent,Fp.x,Fp.y,Mp\n0,0,900,0,0\n5,0,900,0,0\n")
    decision = decide()

    def table(crowd, *options):
        ssp, output = tmp_path / "coupled.ssp", tmp_path / "table.csv"
        for command in (
            ["connect", decision, crowd, "-o", ssp],
            ["run", ssp, "--until", "0.5", "-o", output, "--outputs", tmp_path / "outputs.csv", *options],
        ):
            subprocess.run([lemons, *command, "--force"], check=True, capture_output=True)
        return output.read_text()

    driven, still = pack(trial), pack(TRIAL_DOOR)
    assert table(driven) == table(driven, "--no-drive") == table(still)
    x = ["agent[0].Position.x"]
    moved = [simulate_fmu(crowd, stop_time=0.5, output=x)[x[0]] for crowd in (driven, still)]
    assert moved[0][-1] - moved[1][-1] > 0.05


def test_the_package_leaves_agents_whose_propulsion_is_set(push_fmu):
    parameters = {"agent[0].Fp.x": 500.0}
    assert simulate(push_fmu, None, parameters, until=1.0).equals(simulate(push_fmu, False, parameters, until=1.0))
