"""Agents and sensors that HoloOcean has from Holodeck: the quadrotor's targets, the point that goes, tasks."""

import numpy as np
import pytest
from holoocean_env import agent, opened

import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean.agents import AgentDefinition
from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
LOCATION, ROTATION = {"sensor_type": "LocationSensor"}, {"sensor_type": "RotationSensor"}


def task(kind, **configuration):
    return {"sensor_type": kind, "configuration": configuration}


def test_a_quadrotor_holds_roll_pitch_rate_and_height():
    imu = {"sensor_type": "IMUSensor"}
    with opened(agent("UavAgent", [LOCATION, ROTATION, imu], scheme=1, location=(0, 0, 8))) as env:
        state = env.step([0.1, -0.2, 0.0, 9.0], ticks=600)
        np.testing.assert_allclose(state["RotationSensor"][:2], np.degrees([0.1, -0.2]), atol=0.5)
        assert state["LocationSensor"][2] == pytest.approx(9.0, abs=0.1)
        assert state["LocationSensor"][0] < -1  # nose up: astern
        state = env.step([0.0, 0.0, 0.5, 9.0], ticks=120)
        assert state["IMUSensor"][1, 2] == pytest.approx(0.5, abs=0.02)


def test_a_point_goes_half_a_metre_a_tick_and_faces_its_goal():
    with opened(agent("NavAgent", [LOCATION, ROTATION], location=(0, 0, 60))) as env:
        np.testing.assert_allclose(env.tick()["LocationSensor"], [0, 0, 60], atol=1e-6)
        np.testing.assert_allclose(env.agents["auv0"].action_space.get_high(), [0.5] * 3)
        state = env.step([-3, 4, 60])
        np.testing.assert_allclose(state["LocationSensor"], [-0.3, 0.4, 60], atol=1e-5)
        assert state["RotationSensor"][2] == pytest.approx(np.degrees(np.arctan2(4, -3)), abs=1e-3)
        np.testing.assert_allclose(env.tick(20)["LocationSensor"], [-3, 4, 60], atol=1e-5)


def test_a_wall_stops_a_point():
    with opened(agent("NavAgent", [LOCATION], location=(1.0, 0.7, 0.5))) as env:
        x = env.step([10, 0.7, 0.5], ticks=20)["LocationSensor"][0]
        assert 2.0 < x < 2.77  # the wall's face


def test_a_distance_task_rewards_every_interval_and_ends_at_the_goal():
    sensor = task("DistanceTask", GoalLocation=[-3, 0, 60], Interval=1, GoalDistance=0.6)
    with opened(agent("NavAgent", [sensor, LOCATION], location=(1, 0, 60))) as env:
        assert env.tick()["DistanceTask"].tolist() == [0, 0]
        seen = [tuple(env.step([-3, 0, 60])["DistanceTask"]) for _ in range(8)]
        assert [reward for reward, _ in seen] == [0, 1] * 4
        assert [end for _, end in seen] == [0] * 6 + [1, 1]
        assert env.get_reward_terminal() == (1.0, True)


def test_a_distance_task_may_reward_going_away_from_the_start():
    sensor = task("DistanceTask", MaximizeDistance=True, Interval=1, GoalDistance=1.7)
    with opened(agent("NavAgent", [sensor], location=(1, 0, 60))) as env:
        env.tick()
        assert [tuple(env.step([9, 0, 60])["DistanceTask"]) for _ in range(4)] == [(0, 0), (1, 0), (0, 0), (1, 1)]


def test_a_location_task_rewards_being_there():
    near = dict(task("LocationTask", GoalActor="a1", GoalDistance=3, HasTerminal=True), sensor_name="near")
    bad = dict(task("LocationTask", GoalLocation=[0, 0, 60], GoalDistance=2, NegativeReward=True), sensor_name="bad")
    one = agent("SphereAgent", [near, bad], name="a0", location=(0, 0, 61))
    with opened(one, agent("SphereAgent", name="a1", location=(0, -4, 61))) as env:
        state = env.tick()["a0"]
        assert state["near"].tolist() == [0, 0]
        assert state["bad"].tolist() == [-1, 0]
        env.agents["a1"].teleport([0, -2, 61])
        assert env.tick()["a0"]["near"].tolist() == [1, 1]


@pytest.mark.parametrize(("yaw", "follow", "avoid"), [(0, 75, 25), (180, 0, 25)])
def test_following_needs_sight_and_avoiding_flees_it(yaw, follow, avoid):
    chase = task("FollowTask", ToFollow="a1", OnlyWithinSight=True, FOVRadians=1.0, MinDistance=20)
    flee = task("AvoidTask", ToAvoid="a0", MinDistance=20)
    one = agent("SphereAgent", [chase], name="a0", location=(0, 0, 60), rotation=[0, 0, yaw])
    with opened(one, agent("SphereAgent", [flee], name="a1", location=(5, 0, 60))) as env:
        state = env.tick()
        assert state["a0"]["FollowTask"].tolist() == pytest.approx([follow, 0])
        assert state["a1"]["AvoidTask"].tolist() == pytest.approx([avoid, 0])


def test_who_is_not_seen_is_safe():
    flee = task("AvoidTask", ToAvoid="a0", OnlyWithinSight=True, FOVRadians=0.5, MinDistance=20)
    one = agent("SphereAgent", [], name="a0", location=(0, 0, 60), rotation=[0, 0, 90])
    with opened(one, agent("SphereAgent", [flee], name="a1", location=(5, 0, 60))) as env:
        assert env.tick()["a1"]["AvoidTask"][0] == 100


def test_what_is_not_marine_is_refused_with_words():
    for name in ("AndroidAgent", "HandAgent"):
        kind = getattr(holoocean.agents, name)
        for given in (name, kind):
            with pytest.raises(KeyError, match="walks or grasps"):
                AgentDefinition("a", given)
    for kind in ("CupGameTask", "CleanUpTask"):
        with pytest.raises(HoloOceanConfigurationException, match="a level with cups or trash"):
            opened(agent("SphereAgent", [task(kind)]))
    with pytest.raises(HoloOceanConfigurationException, match="needs ToFollow"):
        opened(agent("SphereAgent", [task("FollowTask")]))
    lost = pytest.raises(HoloOceanConfigurationException, match="no agent 'auv1'")
    with opened(agent("SphereAgent", [task("FollowTask", ToFollow="auv1")])) as env, lost:
        env.tick()
