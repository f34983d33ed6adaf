"""The results of `lemons run` as others read them, and runs that were stopped and went on."""

import subprocess

import pandas
import pyarrow.parquet
from crowd import COLUMNS, TRIAL_PUSH, ids_of, read_table


def call(lemons, directory, *arguments, code=0):
    done = subprocess.run([lemons, "run", *map(str, arguments)], cwd=directory, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


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
    about = file.metadata.metadata
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


