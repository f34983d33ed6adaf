"""What feet hold and how hard people push, through the whole chain, beside closed forms and SciPy."""

import math

import numpy as np
import pytest
from crowd import write_trial
from lemons_fmu import Crowd
from scipy.integrate import solve_ivp

HEIGHT, SUPPORT, STEP_TIME, STEP_LENGTH, RATE = 0.56 * 1.75, 0.12, 0.25, 0.9, 4.5
OMEGA = math.sqrt(9.81 / HEIGHT)
MASS = 80.0
ANKLES = OMEGA * SUPPORT  # m/s
#: The extrapolated centre of mass leaves the edge of the feet by exp(OMEGA t).
ONE_STEP = OMEGA * (SUPPORT + STEP_LENGTH * math.exp(-OMEGA * STEP_TIME))


def hit(directory, speeds, step=0.005, until=3.0, algorithm="gauss-seidel", side=0):
    """Everybody is hit at the start, far from others, from this side [degrees]. Returns ways along x (time, person), and the outputs at
    the end."""
    x, y = math.cos(math.radians(side)), math.sin(math.radians(side))
    people = [{"mass": MASS, "x": 2.0, "y": 9.0 * k, "vx": v * x, "vy": v * y, "rate": RATE} for k, v in enumerate(speeds)]
    trial = write_trial(directory / "trial", people, mechanical=1e-3)
    plan = directory / "plan.toml"
    plan.write_text('balance = "pendulum"\n[pendulum]\nreturn_after = 100.0\n')
    with Crowd(trial, plan=plan, algorithm=algorithm) as crowd:
        ways = []
        for _ in range(round(until / step)):
            crowd.step(step)
            ways.append(crowd.poses()[:, 0] - 2.0)
        ends = {name: [crowd[f"decision.agent[{k}].{name}"] for k in range(len(speeds))] for name in ("Steps", "Balanced", "Fallen", "Lean")}
    return np.array(ways), ends


@pytest.mark.parametrize("side", [0, 90, 180, 270])
def test_thresholds_are_those_of_the_pendulum(tmp_path, side):
    speeds = [0.97 * ANKLES, 1.03 * ANKLES, 0.97 * ONE_STEP, 1.03 * ONE_STEP]
    _, ends = hit(tmp_path, speeds, side=side)
    assert ends["Steps"][0] == 0 and min(ends["Steps"][1:]) >= 1
    assert ends["Fallen"] == [False, False, False, True]
    assert ends["Balanced"][:3] == [True] * 3 and max(ends["Lean"][:3]) < SUPPORT
    # Impulses from 10 to 200 N s: the ankles, one step, a fall.
    impulses = np.array([10, 30, 32, 60, 130, 140, 200])
    _, ends = hit(tmp_path / "impulses", impulses / MASS, side=side)
    assert ends["Steps"][:2] == [0, 0] and all(ends["Steps"][2:])
    assert ends["Fallen"] == [False] * 5 + [True] * 2


def test_longer_steps_save_from_leans_that_are_larger_by_as_much_as_was_measured():
    """Young women who are released from a lean and may take one step of 15, 25 or 35 % of their stature: the greatest lean grows by 36 %
    and 23 % (Hsiao-Wecksler and Robinovitch, Clin. Biomech. 22 (2007) 574)."""
    leans = [SUPPORT + part * 1.64 * math.exp(-OMEGA * STEP_TIME) for part in (0.15, 0.25, 0.35)]
    assert leans[1] / leans[0] == pytest.approx(1.36, abs=0.06) and leans[2] / leans[1] == pytest.approx(1.23, abs=0.06)


def test_until_the_step_the_way_is_that_of_a_pendulum_about_the_edge_of_the_feet(tmp_path):
    """SciPy integrates the pendulum, whose ankles bring the body above the feet as far as they can."""

    def motion(_, state):
        x, v = state
        middle = OMEGA**2 * x
        return [v, middle + np.clip(-RATE * v - (RATE / 2) ** 2 * x - middle, -(OMEGA**2) * SUPPORT, OMEGA**2 * SUPPORT)]

    speeds = [0.3 * ANKLES, ANKLES, 0.8, 1.5]
    until = STEP_TIME - 0.01
    ways, _ = hit(tmp_path, speeds, step=0.002, until=until)
    for way, speed in zip(ways[-1], speeds):
        x = solve_ivp(motion, (0, until), [0.0, speed], rtol=1e-9, atol=1e-12, max_step=1e-3).y[0, -1]
        assert way == pytest.approx(x, rel=0.01), speed


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
def test_ways_hardly_depend_on_the_communication_step(tmp_path, algorithm):
    """Also where a drive is a step late."""
    speeds = [0.2, 0.8, 1.2]
    fine, _ = hit(tmp_path / "fine", speeds, step=0.002)
    coarse, _ = hit(tmp_path / "coarse", speeds, step=0.02, algorithm=algorithm)
    assert np.abs(fine[-1] - coarse[-1]).max() < 0.02, (fine[-1], coarse[-1])


@pytest.mark.parametrize("limit", ["push = 100", "[agents]\n0 = { push = 100 }\n1 = { push = 100 }\n2 = { push = 100 }", "motivation = [{ time = 0.5, push = 100 }]"])
def test_a_row_presses_on_a_wall_with_the_sum_of_its_pushes(tmp_path, limit):
    people = [{"mass": MASS, "x": 2.0 + 0.41 * k, "y": 2.0, "rate": RATE} for k in range(3)]
    wall = [(3.1, 0.0), (3.1, 4.0)]
    trial = write_trial(tmp_path / "trial", people, walls=[wall], mechanical=1e-4, damping=500.0)
    plan = tmp_path / "plan.toml"
    plan.write_text(f"waypoints = [{{ x = 30, y = 2 }}]\n{limit}\n")
    with Crowd(trial, plan=plan) as crowd:
        for _ in range(400):
            crowd.step(0.02)
        # Of each person: what those behind press, and what presses back ahead.
        assert crowd.squeeze() == pytest.approx([100, 300, 500], rel=1e-3)
