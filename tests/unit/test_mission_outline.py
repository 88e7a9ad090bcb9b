"""The way that a mission means to go, as points, and as nav_msgs/Path in a recording."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.rosbag import write_rosbag
from pelagos.messages.motion import path_message
from pelagos.messages.store import deserialize
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.outline import outline
from pelagos.sim.guidance.task import Common, Level, Task
from pelagos.sim.guidance.vertical import Dive, Profile
from pelagos.sim.guidance.wait import Hold, Station
from pelagos.sim.replay import Recording
from pelagos.sim.simulation import Simulation

START = (3.0, -2.0, -1.0)


def slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A seabed that falls northwards."""
    return -20.0 - 0.5 * x + 0.0 * y


def way(*tasks: Task) -> np.ndarray:
    return outline([Step(task, len(tasks)) for task in tasks], START, slope)


def at(depth: float | None = None, altitude: float | None = None) -> Common:
    return Common(level=Level(depth, altitude))


def test_lines_go_by_their_corners_at_their_depth() -> None:
    found = way(Line((10, 5), common=at(4)), Line((10, -7), (10, 5), common=at(4)), Line((12, -7), None, common=at()))
    np.testing.assert_array_equal(found, [START, (10, 5, -4), (10, -7, -4), (12, -7, -4)])


def test_an_altitude_follows_the_ground_below_each_corner() -> None:
    np.testing.assert_allclose(way(Line((10, 5), common=at(altitude=3))), [START, (10, 5, -20 - 5 + 3)])


def test_where_there_is_no_ground_an_altitude_changes_nothing() -> None:
    found = outline([Step(Line((10, 5), common=at(altitude=3)), 1)], START, lambda x, y: x * np.nan)
    np.testing.assert_array_equal(found, [START, (10, 5, -1)])


def test_a_dive_goes_straight_down_and_waiting_adds_nothing() -> None:
    found = way(Dive(common=at(6)), Hold(5.0, at()), Station(9.0, None, None, at(8)), Profile(2, 9, point=(7, 1)))
    np.testing.assert_array_equal(found, [START, (3, -2, -6), (3, -2, -8), (7, 1, -2)])


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_an_orbit_begins_where_the_vehicle_comes_to_it(turn: float) -> None:
    found = way(Orbit((3.0, 8.0), 4.0, 0.75, turn, common=at(2)))
    np.testing.assert_allclose(found[1], (3, 4, -2), atol=1e-12)  # the vehicle comes from the east
    np.testing.assert_allclose(np.hypot(found[1:, 0] - 3, found[1:, 1] - 8), 4.0)
    # clockwise from the east of it: south, west, north; y is west
    np.testing.assert_allclose(found[-1], (3 + turn * 4, 8, -2), atol=1e-12)


def test_poses_look_along_the_way_that_leads_to_them() -> None:
    message = deserialize("nav_msgs/msg/Path", path_message(np.array([[1.0, 2, -3], [1.0, 6, -3], [-5.0, 6, -4]])))
    assert message.header.frame_id == "map"
    assert [p.header.frame_id for p in message.poses] == ["map"] * 3
    places = [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in message.poses]
    assert places == [(-2, 1, -3), (-6, 1, -3), (-6, -5, -4)]  # east, north, up
    yaw = [2 * math.atan2(p.pose.orientation.z, p.pose.orientation.w) for p in message.poses]
    np.testing.assert_allclose(np.cos(yaw), [-1, -1, 0], atol=1e-12)  # west, west, south
    np.testing.assert_allclose(np.sin(yaw), [0, 0, -1], atol=1e-12)


@pytest.fixture(scope="module")
def sim() -> Simulation:
    legs = [{"type": "waypoints", "points": [[9, 4], [9, -4]], "depth_m": 5}]
    start = {"position_m": [1, 2], "depth_m": 3}
    return pl.Simulation.load({
        "world": {"type": "flat", "depth_m": 30.0},
        "agents": {"auv": {"vehicle": "remus100", "start": start, "mission": legs}},
    })  # fmt: skip


def test_a_recording_says_the_plan_once(sim: Simulation, tmp_path: Path) -> None:
    sim.run(0.3, record=tmp_path / "a.mcap")
    found = Recording(tmp_path / "a.mcap")
    assert found.count("/auv/plan") == 1
    said = found.message("/auv/plan", 0)
    assert said.t_ns == 0
    places = [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in said.message.poses]
    assert places == [(-2, 1, -3), (-4, 9, -5), (4, 9, -5)]
    write_rosbag(tmp_path / "a.mcap", tmp_path / "bag")
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    assert text.count("durability: transient_local") == 3  # of the plan, the mounts and the labels
