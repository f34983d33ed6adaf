"""The results of `lemons run` as others read them, and runs that were stopped and went on."""

import json
import signal
import subprocess
import time

import pandas
import pyarrow.parquet
import pytest
from crowd import COLUMNS, TRIAL_DOOR, TRIAL_PUSH, ids_of, read_table


def call(lemons, directory, *arguments, code=0):
    done = subprocess.run([lemons, "run", *map(str, arguments)], cwd=directory, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def interrupted(lemons, directory, *arguments):
    """Runs for very long; a signal, as of Ctrl-C, as soon as some steps are written."""
    command = [lemons, "run", *map(str, arguments), "--until", "100000"]
    process = subprocess.Popen(command, cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    hidden = f".lemons-{process.pid}-*"
    while not any(path.stat().st_size > 32_000 for path in directory.glob(hidden)):
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.001)
    # SIGINT stays ignored where these tests are started in the background of a shell.
    process.send_signal(signal.SIGTERM)
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
    seen = [(t, [agent[:10] for agent in agents]) for t, agents in as_csv(table)]
    assert seen == read_table((tmp_path / "trajectories.csv").read_text(), ids)
    assert table.schema.names == list(COLUMNS)
    about = file.metadata.metadata
    columns = json.loads(about[b"columns"])
    for name, unit in COLUMNS.items():
        assert columns[name].get("unit") == unit
        assert columns[name]["variable"] and columns[name]["description"]
    assert columns["x"]["variable"] == "agent[i].Position.x"
    assert str(table.schema.field("x").type) == "double"
    assert str(table.schema.field("id").type) == "string"
    assert about[b"trial"] == b"Trial_push" and about[b"communication_step"] == b"0.05"
    assert about[b"guid"].startswith(b"{") and about[b"model_name"] and about[b"lemons_version"]


def test_tables_of_other_programs_are_read(lemons, tmp_path):
    call(lemons, tmp_path, TRIAL_PUSH, "--until", 0.5, "--format", "parquet")
    ours = pandas.read_parquet(tmp_path / "trajectories.parquet")
    kinds = {"id": "int64", "agent_contacts": "uint32", "wall_contacts": "Int64", "contacting_agents": "int16"}
    theirs = ours.astype(kinds).assign(when=pandas.Timestamp("2026-01-01"), list=[[1, 2]] * len(ours))
    for name, options in [
        ("pandas", {}),
        ("pages", {"data_page_version": "2.0", "data_page_size": 256, "row_group_size": 7}),
        ("plain", {"compression": "none", "use_dictionary": False}),
        ("gzip", {"compression": "gzip"}),
        ("lz4", {"compression": "lz4"}),
    ]:
        theirs.sample(frac=1, axis="columns", random_state=1).to_parquet(tmp_path / f"{name}.parquet", **options)
    exported = []
    for name in ("trajectories", "pandas", "pages", "plain", "gzip", "lz4"):
        command = [lemons, "export", f"{name}.parquet", name, "--to", "series", "--trial", TRIAL_PUSH]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        exported.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert len(exported[0]) >= 11 and all(files == exported[0] for files in exported[1:])
    for column, values, message in [
        ("x", "a", "column x: holds no numbers"),
        ("t", pandas.Timestamp("2026-01-01"), "column t: holds no numbers"),
        ("omega", None, "column omega: "),
        ("wall_contacts", 0.5, "column wall_contacts: holds no whole numbers"),
    ]:
        theirs.assign(**{column: values}).to_parquet(tmp_path / "bad.parquet")
        command = [lemons, "export", "bad.parquet", "out", "--to", "pedpy"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1 and message in done.stderr, done.stderr


def joined(directory, *names):
    """The rows of tables of one run, in the order of time."""
    first, *others = ((directory / name).read_text() for name in names)
    return first + "".join(text.split("\n", 1)[1] for text in others)


@pytest.mark.parametrize("end", ["csv", "parquet"])
def test_push_goes_on(lemons, tmp_path, end):
    interrupted(lemons, tmp_path, TRIAL_PUSH, "--state", "push.run")
    rows = (tmp_path / "trajectories.csv").read_text().splitlines()
    steps = (len(rows) - 1) // 5 + 20
    call(lemons, tmp_path, TRIAL_PUSH, "--resume", "push.run", "--until", repr(steps * 0.05), "-o", "rest.csv")
    call(lemons, tmp_path, TRIAL_PUSH, "--until", repr(steps * 0.05), "-o", f"whole.{end}")
    if end == "csv":
        assert joined(tmp_path, "trajectories.csv", "rest.csv") == (tmp_path / "whole.csv").read_text()
    else:
        whole = as_csv(pyarrow.parquet.read_table(tmp_path / "whole.parquet"))
        seen = read_table(joined(tmp_path, "trajectories.csv", "rest.csv"), ids_of(TRIAL_PUSH))
        assert [(t, [agent[:10] for agent in agents]) for t, agents in whole] == seen


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
    interrupted(lemons, tmp_path, *run, "--state", "door.run", "--outputs", "outputs.csv")
    rows = (tmp_path / "trajectories.csv").read_text().splitlines()
    last, agents = float(rows[-1].split(",")[0]), len(ids_of(TRIAL_DOOR))
    step = last / ((len(rows) - 1) // agents - 1)
    until = repr(round(last + 20 * step, 6))
    rest = ["-o", "rest.csv", "--outputs", "outputs_rest.csv"]
    call(lemons, tmp_path, *run, "--resume", "door.run", "--until", until, *rest)
    call(lemons, tmp_path, *run, "--until", until, "-o", "whole.csv", "--outputs", "outputs_whole.csv")
    for parts, whole in [(("trajectories.csv", "rest.csv"), "whole.csv"), (("outputs.csv", "outputs_rest.csv"), "outputs_whole.csv")]:
        assert joined(tmp_path, *parts) == (tmp_path / whole).read_text()
    other = "jacobi" if algorithm != "jacobi" else "gauss-seidel"
    call(lemons, tmp_path, coupled, "--algorithm", other, "--resume", "door.run", code=1)
    # The outputs of the Decision, as columns.
    call(lemons, tmp_path, *run, "--until", until, "--format", "parquet", "--outputs", "outputs.parquet")
    outputs = pyarrow.parquet.read_table(tmp_path / "outputs.parquet")
    assert json.loads(outputs.schema.metadata[b"columns"])["decision.agent[0].Fp.x"]["unit"] == "N"
    names = [head.split(" [")[0] for head in (tmp_path / "outputs_whole.csv").read_text().splitlines()[0].split(",")]
    assert outputs.schema.names == names
    table = (tmp_path / "outputs_whole.csv").read_text().splitlines()[1:]
    assert [[str(value) for value in row.values()] for row in outputs.to_pylist()] == [
        [
            cell.title() if cell in ("true", "false") else str(float(cell)) if "." in cell or "e" in cell else cell
            for cell in line.split(",")
        ]
        for line in table
    ]
