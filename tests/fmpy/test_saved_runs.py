"""The results of `lemons run` as others read them, and runs that were stopped and went on."""

import signal
import subprocess
import time

import pyarrow.parquet
import pytest
from crowd import COLUMNS, TRIAL_DOOR, TRIAL_PUSH, ids_of, read_table


def call(lemons, directory, *arguments, code=0):
    done = subprocess.run([lemons, "run", *map(str, arguments)], cwd=directory, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def interrupted(lemons, directory, *arguments):
    """Runs for very long; Ctrl-C as soon as some steps are written."""
    command = [lemons, "run", *map(str, arguments), "--until", "100000"]
    process = subprocess.Popen(command, cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    hidden = f".lemons-{process.pid}-*"
    while not any(path.stat().st_size > 32_000 for path in directory.glob(hidden)):
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130, out + err
    assert "stopped by Ctrl-C" in out


def as_csv(table):
    """A Parquet table as read by Arrow, in the form of `read_table`."""
    names = [name for name in COLUMNS if name not in ("t", "id")]
    seen = {}
    for row in table.to_pylist():
        seen.setdefault(row["t"], []).append([row[name] for name in names])
    return list(seen.items())


def test_parquet_holds_what_csv_holds(lemons, tmp_path):
    call(lemons, tmp_path, TRIAL_PUSH, "--until", 1)
    call(lemons, tmp_path, TRIAL_PUSH, "--until", 1, "--format", "parquet")
    file = pyarrow.parquet.ParquetFile(tmp_path / "trajectories.parquet")
    table = file.read()
    ids = ids_of(TRIAL_PUSH)
    assert table["id"].to_pylist() == ids * 21
    seen = [(t, [agent[:-2] for agent in agents]) for t, agents in as_csv(table)]
    assert seen == read_table((tmp_path / "trajectories.csv").read_text(), ids)
    assert table.schema.names == list(COLUMNS)
    for name, unit in COLUMNS.items():
        about = table.schema.field(name).metadata
        assert about.get(b"unit") == (unit and unit.encode())
        assert about[b"variable"] and about[b"description"]
    assert table.schema.field("x").metadata[b"variable"] == b"agent[i].Position.x"
    assert str(table.schema.field("x").type) == "double"
    assert str(table.schema.field("id").type).startswith("dictionary<values=string")
    about = file.metadata.metadata
    assert about[b"trial"] == b"Trial_push" and about[b"communication_step"] == b"0.05"
    assert about[b"guid"].startswith(b"{") and about[b"model_name"] and about[b"lemons_version"]


@pytest.mark.parametrize("end", ["csv", "parquet"])
def test_push_goes_on(lemons, tmp_path, end):
    interrupted(lemons, tmp_path, TRIAL_PUSH, "--state", "push.run")
    rows = (tmp_path / "trajectories.csv").read_text().splitlines()
    steps = (len(rows) - 1) // 5 + 20
    call(lemons, tmp_path, TRIAL_PUSH, "--resume", "push.run", "--until", repr(steps * 0.05))
    call(lemons, tmp_path, TRIAL_PUSH, "--until", repr(steps * 0.05), "-o", f"whole.{end}")
    if end == "csv":
        assert (tmp_path / "trajectories.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    else:
        whole = as_csv(pyarrow.parquet.read_table(tmp_path / "whole.parquet"))
        seen = read_table((tmp_path / "trajectories.csv").read_text(), ids_of(TRIAL_PUSH))
        assert [(t, [agent[:-2] for agent in agents]) for t, agents in whole] == seen


@pytest.fixture(scope="module")
def coupled(lemons, tmp_path_factory):
    directory = tmp_path_factory.mktemp("door")
    for command in [
        ["decide", TRIAL_DOOR, "-o", "decision.fmu"],
        ["pack", TRIAL_DOOR, "-o", "crowd.fmu"],
        ["connect", "decision.fmu", "crowd.fmu", "-o", "coupled.ssp"],
    ]:
        subprocess.run([lemons, *command], check=True, capture_output=True, cwd=directory)
    return directory / "coupled.ssp"


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_the_coupled_door_goes_on(lemons, coupled, tmp_path, algorithm):
    run = [coupled, "--algorithm", algorithm]
    interrupted(lemons, tmp_path, *run, "--state", "door.run")
    rows = (tmp_path / "trajectories.csv").read_text().splitlines()
    last, agents = float(rows[-1].split(",")[0]), len(ids_of(TRIAL_DOOR))
    step = last / ((len(rows) - 1) // agents - 1)
    until = repr(round(last + 20 * step, 6))
    call(lemons, tmp_path, *run, "--resume", "door.run", "--until", until)
    call(lemons, tmp_path, *run, "--until", until, "-o", "whole.csv", "--outputs", "outputs_whole.csv")
    for one, other in [("trajectories.csv", "whole.csv"), ("outputs.csv", "outputs_whole.csv")]:
        assert (tmp_path / one).read_bytes() == (tmp_path / other).read_bytes()
    other = "jacobi" if algorithm != "jacobi" else "gauss-seidel"
    call(lemons, tmp_path, coupled, "--algorithm", other, "--resume", "door.run", code=1)
    # The outputs of the Decision, as columns.
    call(lemons, tmp_path, *run, "--until", until, "--format", "parquet")
    outputs = pyarrow.parquet.read_table(tmp_path / "outputs.parquet")
    assert outputs.schema.field("decision.agent[0].Fp.x").metadata[b"unit"] == b"N"
    names = [head.split(" [")[0] for head in (tmp_path / "outputs.csv").read_text().splitlines()[0].split(",")]
    assert outputs.schema.names == names
    table = (tmp_path / "outputs.csv").read_text().splitlines()[1:]
    assert [[str(value) for value in row.values()] for row in outputs.to_pylist()] == [
        [str(float(cell)) if "." in cell or "e" in cell else cell for cell in line.split(",")] for line in table
    ]
