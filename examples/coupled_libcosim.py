"""Thirty people leave a room, with libcosim as the master: Decision and CrowdMechanics, connected by names.

    pip install libcosimpy fmpy
    python examples/coupled_libcosim.py decision.fmu crowd.fmu

`lemons decide resources/Trial_door -o decision.fmu` and `lemons pack resources/Trial_door -o crowd.fmu` make the two FMUs.
Prints the time when each person has passed the door. Times differ by seconds from those of coupled_fmpy.py. libcosim passes
outputs on after each step, so the drives of Decision come one step late, and its steps are rounded to nanoseconds. These small
differences change who goes first through the door, and therefore everything after that.
"""

import argparse
import sys

from fmpy import read_model_description
from libcosimpy.CosimConstants import success
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

STEP, END, DOOR = 0.05, 60.0, 5.2  # s, s, m: the door's far side

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("decision", metavar="decision.fmu", help="drives of people, made by `lemons decide`")
parser.add_argument("crowd", metavar="crowd.fmu", help="motion of people, made by `lemons pack`")
fmus = vars(parser.parse_args())

log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_step_size(round(STEP * 1e9))  # in nanoseconds
variables = {fmu: read_model_description(path).modelVariables for fmu, path in fmus.items()}
index = {fmu: execution.add_local_slave(CosimLocalSlave(path, fmu)) for fmu, path in fmus.items()}


def named(fmu, causality):
    """Returns the value references of Reals by name."""
    return {v.name: v.valueReference for v in variables[fmu] if v.causality == causality and v.type == "Real"}


drives = named("decision", "output").keys() & named("crowd", "input").keys()
people = sum(name.endswith("].Fp.x") for name in drives)
if not people:
    sys.exit("{decision} drives nobody of {crowd}: no agent[…].Fp.x in common; decision.fmu first, then crowd.fmu".format(**fmus))
for source, sink in [("crowd", "decision"), ("decision", "crowd")]:
    outputs, inputs = named(source, "output"), named(sink, "input")
    for name in outputs.keys() & inputs.keys():
        answer = execution.connect_real_variables(index[source], outputs[name], index[sink], inputs[name])
        assert answer == success, name
observer = CosimObserver.create_last_value()
execution.add_observer(observer)

positions = named("crowd", "output")
places = [positions[f"agent[{i}].Position.x"] for i in range(people)]
left = {}
for k in range(round(END / STEP)):
    if not execution.step():
        sys.exit(f"libcosim: {execution.status()}")
    for i, x in enumerate(observer.last_real_values(index["crowd"], places)):
        if x > DOOR:
            left.setdefault(i, (k + 1) * STEP)
    if len(left) == people:
        break

print(f"{len(left)} of {people} people have passed the door")
print(" nth  agent  time [s]")
for n, (i, time) in enumerate(left.items(), start=1):
    print(f"{n:4}  {i:5}  {time:8.2f}")
