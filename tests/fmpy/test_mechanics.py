"""Collisions whose outcome is known, through the FMU."""

import pytest
from crowd import write_trial


def test_head_on_collision(pack, instantiate, tmp_path):
    """100 kg at 1 m/s meet 50 kg at rest: 1/3 and 4/3 m/s."""
    agents = [{"mass": 100.0, "x": 0.0, "vx": 1.0}, {"mass": 50.0, "x": 0.45}]
    crowd = instantiate(pack(write_trial(tmp_path / "Trial", agents, time_step=0.005))).initialize()
    touched = 0
    for _ in range(40):
        crowd.step(0.005)
        touched += crowd["AgentContacts"]
        momentum = 100.0 * crowd["agent[0].Velocity.x"] + 50.0 * crowd["agent[1].Velocity.x"]
        assert momentum == pytest.approx(100.0, rel=1e-12)
    assert touched and not crowd["AgentContacts"]
    assert crowd["agent[0].Velocity.x"] == pytest.approx(1 / 3, abs=1e-6)
    assert crowd["agent[1].Velocity.x"] == pytest.approx(4 / 3, abs=1e-6)
    assert crowd["agent[0].Omega"] == crowd["agent[0].Velocity.y"] == 0.0


@pytest.mark.parametrize("speed", [1.0, 20.0])
@pytest.mark.parametrize("half_length", [10.0, 100.0])
@pytest.mark.parametrize("time_step", [0.01, 0.1])
def test_nobody_walks_through_a_wall(pack, instantiate, tmp_path, speed, half_length, time_step):
    """80 kg that walk steadily along y = 5 at a wall at x = 2 (the published engine lets them through)."""
    walker = {"mass": 80.0, "x": 0.0, "y": 5.0, "vx": speed, "fx": 160.0 * speed, "rate": 2.0}
    wall = [(2.0, -half_length), (2.0, half_length)]
    trial = write_trial(tmp_path / "Trial", [walker], [wall], time_step, damping=2e4, friction=0.5)
    crowd = instantiate(pack(trial)).initialize()
    touched = 0
    for k in range(round(4.0 / time_step)):
        crowd.step_to((k + 1) * time_step)
        touched += crowd["WallContacts"]
        assert crowd["agent[0].Position.x"] < 2.0
    assert touched
    # At rest at last: the wall holds what pushes.
    assert crowd["agent[0].Position.x"] == pytest.approx(1.8, abs=0.005)
    assert crowd["agent[0].NormalForce"] == pytest.approx(160.0 * speed, rel=1e-3)
