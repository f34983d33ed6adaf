"""Uses an installed wheel as a user does: check.sh calls it in a fresh environment.

    wheel_test.py REPOSITORY PLATFORM…

Results are those of the command, whoever simulates: the package or FMPy. examples/push_fmpy.py and the Python of
python/README.md run.
"""

import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import distribution, version
from pathlib import Path

import fmpy
import lemons_fmu
import pandas as pd

repository, platforms = Path(sys.argv[1]), sys.argv[2:]
assert "site-packages" in lemons_fmu.__file__, lemons_fmu.__file__
command = shutil.which("lemons")
assert command and Path(command).parent.samefile(Path(sys.executable).parent), command


def lemons(*words: object) -> str:
    return subprocess.run(["lemons", *map(str, words)], check=True, stdout=subprocess.PIPE, text=True).stdout


assert lemons("--version").startswith(f"lemons {version('lemons-fmu')}")
# As the command is used.
lemons("pack", repository / "resources/Trial_push", "-o", "push.fmu", "--force")
said = lemons("info", "push.fmu", "--only", "no such")
found = re.findall(r"^(?:platforms| {9}) (\S+)", said, re.MULTILINE)
assert set(found) == set(platforms), said
lemons("run", "push.fmu", "--until", "1", "-o", "push.csv", "--force")
table = pd.read_csv("push.csv")

# Without the package: FMPy, beside the command with the same force.
lemons("run", "push.fmu", "--no-drive", "--set", "agent[0].Fp.x=500", "--until", "1", "-o", "held.csv", "--force")
held = pd.read_csv("held.csv")
result = fmpy.simulate_fmu(
    "push.fmu", stop_time=1.0, step_size=0.05, start_values={"agent[0].Fp.x": 500.0}, output=["agent[3].Position.x"]
)
reached = held[held["id"] == 3]["x"].to_numpy()
assert (result["agent[3].Position.x"] == reached).all() and reached[-1] > reached[0]

# With it.
assert (lemons_fmu.simulate("push.fmu", until=1.0).to_numpy() == table.to_numpy()).all()
crowd = lemons_fmu.crowd(number=150, box=(4.56, 4.56), seed=2)
assert len(crowd) == 150 and crowd.disks.shape == (750, 4)
with lemons_fmu.Crowd(crowd.pack("crowd.fmu", fmi=3, platforms=["linux64"])) as packed:
    run = packed.run(until=0.05)
assert lemons_fmu.plot(run).data.startswith(b"<")
run.export("run.sqlite", to="jupedsim")

# FMUs hold the licences of what is in their libraries, whoever has them packed.
licences = distribution("lemons-fmu").read_text("licenses/THIRD-PARTY.txt")
assert licences
lemons("decide", repository / "resources/Trial_door", "-o", "decision.fmu", "--force")
lemons("pack", repository / "resources/Trial_door", "--interface", "summary", "-o", "summary.fmu", "--force")
for name in ("push.fmu", "crowd.fmu", "decision.fmu", "summary.fmu"):
    with zipfile.ZipFile(name) as fmu:
        assert fmu.read("documentation/licenses/THIRD-PARTY.txt").decode() == licences, name

# As a user runs them.
subprocess.run([sys.executable, repository / "examples/push_fmpy.py", "push.fmu", "plot.png"], check=True)
assert Path("plot.png").read_bytes().startswith(b"\x89PNG")
text = (repository / "python/README.md").read_text(encoding="utf-8")
blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
assert len(blocks) >= 3
Path("manual.py").write_text("\n".join(blocks), encoding="utf-8")
Path("resources").symlink_to(repository / "resources")
subprocess.run([sys.executable, "manual.py"], check=True, stdout=subprocess.DEVNULL)
assert Path("results.csv").is_file()
print(f"wheel_test.py: {said.splitlines()[0]}, {', '.join(found)}; {crowd!r}, {run!r}")
