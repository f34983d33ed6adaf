"""The FMU, the engine called directly and `lemons run` give the same bits."""

import subprocess
from concurrent.futures import ThreadPoolExecutor
from math import isfinite

import numpy as np
from crowd import CONTACTS, MOTION, TRIAL_PUSH, bits, ids_of, push_drive, read_table
from fmpy import simulate_fmu


def all_finite(seen):
    return all(isfinite(number) for _, agents in seen for agent in agents for number in agent)


def command_run(lemons, trial, until, output):
    command = [lemons, "run", trial, "--until", repr(until), "-o", output]
    subprocess.run(command, check=True, capture_output=True)
    return read_table(output.read_text(), ids_of(trial))


def test_push(push, engine_direct, lemons, tmp_path, row):
    start = (0.0, push.initialize().look())
    seen = [start, *push.run(20, 0.05, push_drive())]
    assert all_finite(seen)
    assert max(agent[-1] for _, agents in seen for agent in agents) > 100.0, "nobody was squeezed"
    direct = read_table(engine_direct(TRIAL_PUSH, 20, "--drive", TRIAL_PUSH / "drive.csv"), ids_of(TRIAL_PUSH))
    assert bits(seen) == bits(direct)
    assert bits(seen) == bits(command_run(lemons, TRIAL_PUSH, 20 * 0.05, tmp_path / "t.csv"))
    row("fmpy", "set inputs, do steps, get outputs", "same bits as the engine without FMI")


def test_dense_crowd(pack, instantiate, shared, engine_direct, lemons, tmp_path):
    trial = shared / "data/crowds/dense_100"
    crowd = instantiate(pack(trial)).initialize()
    seen = [(0.0, crowd.look()), *crowd.run(20, 0.001)]
    assert crowd.agents == 100
    assert all_finite(seen)
    assert crowd["AgentContacts"] > 0
    assert sum(agent[6] for agent in seen[-1][1]) == 2 * crowd["AgentContacts"]
    assert bits(seen) == bits(read_table(engine_direct(trial, 20), ids_of(trial)))
    assert bits(seen) == bits(command_run(lemons, trial, 20 * 0.001, tmp_path / "t.csv"))


def test_simulate_fmu(push_fmu, engine_direct, row):
    """fmpy's own master; it interpolates its input signals, exactly at their rows."""
    drive = push_drive()
    names = [f"agent[{i}].{name}" for i in range(5) for name in ["Fp.x", "Fp.y", "Mp"]]
    points = [k * 0.05 for k in range(21)]
    pushes = [drive.at(t)[0] + [0.0] * 12 for t in points]
    signals = np.array(
        [(t, *push) for t, push in zip(points, pushes)], dtype=[(name, float) for name in ["time", *names]]
    )
    outputs = [f"agent[{i}].{name}" for i in range(5) for name in [*MOTION, *CONTACTS, "NormalForce"]]
    result = simulate_fmu(str(push_fmu), stop_time=1.0, input=signals, output=outputs)
    seen = [
        (float(row["time"]), [[row[name].item() for name in outputs[10 * i : 10 * i + 10]] for i in range(5)])
        for row in result
    ]
    direct = read_table(engine_direct(TRIAL_PUSH, 20, "--drive", TRIAL_PUSH / "drive.csv"), ids_of(TRIAL_PUSH))
    assert bits(seen) == bits(direct)
    row("fmpy", "`simulate_fmu` with input signals", "same bits as the engine without FMI")


def test_instances_in_threads(instantiate, push_directory, row):
    """Each instance moves between threads too: fmpy lets go of Python's lock during a call."""
    crowds = [instantiate(push_directory).initialize() for _ in range(4)]
    with ThreadPoolExecutor(4) as pool:
        early = list(pool.map(lambda crowd: crowd.run(8, 0.05, push_drive()), crowds))
        late = list(pool.map(lambda crowd: crowd.run(16, 0.05, push_drive(), first=8), reversed(crowds)))
    alone = instantiate(push_directory).initialize().run(16, 0.05, push_drive())
    for seen in map(list.__add__, early, reversed(late)):
        assert bits(seen) == bits(alone)
    row("fmpy", "four instances, moved between threads", "same bits as one alone")
