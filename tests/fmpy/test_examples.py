"""The example runs and writes its plot."""

import os
import subprocess
import sys

from crowd import REPOSITORY


def test_push_fmpy(push_fmu, tmp_path):
    command = [sys.executable, REPOSITORY / "examples" / "push_fmpy.py", push_fmu, "plot.png"]
    environment = {**os.environ, "MPLBACKEND": "Agg", "TMPDIR": str(tmp_path)}
    subprocess.run(command, check=True, cwd=tmp_path, env=environment)
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["plot.png"]
