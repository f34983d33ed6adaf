"""Parameters that are set between steps."""

import numpy as np
import pytest
from crowd import bits, refused, write_trial
from fmpy.fmi2 import fmi2Error

FORCE, MASS, RATE = 200.0, 80.0, 2.0
WALL = [(1.0, -2.0), (1.0, 2.0)]
#: [N/m] of the material of write_trial; k is proportional to both together.
YOUNG, SHEAR = 4e6, 1.38e6
STEP = 0.01


def test_a_softer_spring_swings_about_its_new_rest(tmp_path, pack, instantiate):
    """The outside: closed forms. Who leans on a wall is in by F/k. With a quarter of k, and no damping, it swings by 3 F/k about 4 F/k:
    the energy that the change puts in is that of the spring, (k' - k) d²/2 = -(3/8) F²/k."""
    agent = {"mass": MASS, "x": 0.8, "fx": FORCE}
    fmu = instantiate(pack(write_trial(tmp_path / "T", [agent], [WALL], time_step=STEP, damping=4000.0)))
    fmu.initialize()
    fmu.run(300, STEP)
    deep = fmu.look()[0][0] - 0.8
    assert fmu.look()[0][9] == pytest.approx(FORCE, rel=1e-6)
    k = FORCE / deep
    fmu["contact.flesh.flesh.GammaNormal"] = 0.0
    fmu["material.flesh.YoungModulus"] = YOUNG / 4
    fmu["material.flesh.ShearModulus"] = SHEAR / 4
    # They act from the next step on.
    assert fmu.look()[0][9] == pytest.approx(FORCE, rel=1e-6)
    other = instantiate(fmu.directory)
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())))
    other.time = fmu.time
    omega = np.sqrt(k / 4 / MASS)
    for n in range(1, 41):
        fmu.run(300 + n, STEP, first=299 + n)
        wanted = 4 * deep - 3 * deep * np.cos(omega * n * STEP)
        assert fmu.look()[0][0] - 0.8 == pytest.approx(wanted, rel=1e-5)
        assert fmu.look()[0][9] == pytest.approx(k / 4 * wanted, rel=1e-5)
    other.run(340, STEP, first=300)
    assert bits(other.look()) == bits(fmu.look())
    assert fmu["material.flesh.YoungModulus"] == YOUNG / 4
    # What no law can be made of is refused by the step; nothing has moved, and it goes on with a law.
    before = fmu.look()
    fmu["material.flesh.YoungModulus"] = 4.1 * fmu["material.flesh.ShearModulus"]
    with refused(fmu, "flesh", "E < 4 G"):
        fmu.step(STEP)
    fmu.time = 3.4
    assert fmu.look() == before
    fmu["material.flesh.YoungModulus"] = YOUNG / 4
    fmu.step(STEP)
    fmu.fmu.reset()
    fmu.initialize()
    assert fmu["material.flesh.YoungModulus"] == YOUNG


def test_friction_can_go(tmp_path, pack, instantiate):
    """The outside: closed forms. A disk that is pressed to a wall and pushed along it sticks; without friction it slides as one that is
    free."""
    wall = [(-5.0, 0.0), (50.0, 0.0)]
    agent = {"mass": MASS, "x": 0.0, "y": 0.199, "fx": 50.0, "rate": 0.0}
    trial = write_trial(tmp_path / "T", [agent], [wall], time_step=STEP, damping=4000.0, friction=2.0)
    fmu = instantiate(pack(trial)).initialize()
    fmu["agent[0].Fp.y"] = -400.0
    # It rolls: there is no torque against it but friction.
    fmu.run(100, STEP)
    vx = fmu.look()[0][2]
    rolling = 50.0 / (MASS + 1.5 / 0.2**2)
    assert vx == pytest.approx(rolling, rel=0.02)
    fmu["contact.flesh.flesh.KineticFriction"] = 0.0
    fmu.run(200, STEP, first=100)
    assert fmu.look()[0][2] - vx == pytest.approx(50.0 / MASS, rel=1e-3)


def test_a_new_speed_is_taken_on_by_and_by(tmp_path, decide, pack, instantiate):
    """The outside: the closed form of the paper's rule, v' = (v0 - v) rate."""
    trial = write_trial(tmp_path / "T", [{"mass": MASS, "x": 0.0, "rate": RATE}], time_step=STEP)
    (tmp_path / "ahead.toml").write_text("waypoints = [{ x = 19, y = 0 }]\ndesired_speed = 1.0\n")
    walk = instantiate(decide("--decision", tmp_path / "ahead.toml", trial=trial)).initialize()
    pushes = [walk["agent[0].Fp.x"]]
    walk["agent[0].DesiredSpeed"] = 0.4
    pushes.append(walk["agent[0].Fp.x"])
    walk["agent[0].Push"] = 30.0
    pushes.append(walk["agent[0].Fp.x"])
    assert pushes == pytest.approx([MASS * RATE, 0.4 * MASS * RATE, 30.0])
    for name in ("Mass", "FloorDamping", "Start"):
        with refused(walk, f"agent[0].{name}", "after initialization", status=fmi2Error):
            walk[f"agent[0].{name}"] = 1.0
