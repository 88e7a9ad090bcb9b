"""Rewards and commands of learners' tasks, by hand: unequal in all axes, of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.compat.holoocean.contact_sensors import RangeFinderSensor
from pelagos.compat.holoocean.navigation_sensors import DVLSensor, DynamicsSensor
from pelagos.envs.tasks.docking import Docking
from pelagos.envs.tasks.gyre import GyreTransect
from pelagos.envs.tasks.path import PathInCurrent
from pelagos.envs.view import View
from pelagos.sensors.comms.ais import Ais


def number(value) -> float:
    return float(np.array(value).ravel()[0])


def numbers(values) -> list[jit.Float64]:
    return [jit.Float64(float(v)) for v in values]


def now(memory: dict[str, float], position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), yaw: float = 0.0):
    kept = {k: jit.Float64(v) for k, v in memory.items()}
    return SimpleNamespace(
        memory=kept, position=numbers(position), velocity=numbers(velocity), yaw=jit.Float64(yaw), t=jit.Float64(1.0)
    )


@pytest.mark.parametrize("angles", [(0.4, -0.3, 1.2), (-2.0, 0.6, 0.2)])
def test_a_view_knows_ahead_and_up(angles) -> None:
    turn = Rotation.from_euler("ZYX", angles)
    view = object.__new__(View)
    view.attitude = numbers(np.roll(turn.as_quat(), 1))
    assert [number(v) for v in view.forward] == pytest.approx(turn.as_matrix()[:, 0], abs=1e-12)
    assert [number(v) for v in view.up] == pytest.approx(turn.as_matrix()[:, 2], abs=1e-12)


@pytest.mark.parametrize("west", [0.7, -0.4])
def test_a_gyres_course_is_a_compass_heading_and_energy_goes_with_the_cube(west: float) -> None:
    task, action = GyreTransect(), numbers([0.5, west, 0.4])
    depth, course, speed = task.command(action, None)
    assert (depth, number(course), number(speed)) == pytest.approx((20.0, -math.atan2(west, 0.5), 1.48))
    seen = now({"goal_x": 300.0, "goal_y": -400.0, "before": 512.0, "energy": 3.0}, (0.0, 0.0, -20.0))
    found, took = task.reward(seen, action), (25.0 * 1.48**3 + 10.0) * 10 * 1e-3
    assert number(found.reward) == pytest.approx(0.12 - 0.1 * took)
    assert number(found.memory["energy"]) == pytest.approx(3.0 + took)


@pytest.mark.parametrize("amplitude", [12.0, -9.0])
def test_a_paths_direction_is_its_slope_and_way_is_counted_along_it(amplitude: float) -> None:
    k, x = 2 * math.pi / 100, 30.0
    seen = now({"amplitude": amplitude, "wave_number": k, "before": 29.0}, (x, 4.0, -10.0))
    line = lambda at: amplitude * math.sin(k * at)
    along = math.atan((line(x + 1e-4) - line(x - 1e-4)) / 2e-4)
    task = PathInCurrent()
    off, found = task._line(seen)
    assert number(found) == pytest.approx(along, abs=1e-6)
    assert number(off) == pytest.approx((4.0 - line(x)) * math.cos(along), abs=1e-5)
    reward = number(task.reward(seen, []).reward)
    assert reward == pytest.approx(1.0 / math.cos(along) - 0.2 * abs(number(off)), rel=1e-5)


@pytest.mark.parametrize(("turn_deg", "docked"), [(8.0, True), (-8.0, True), (15.0, False), (-30.0, False)])
def test_docked_is_near_slow_and_within_ten_degrees(turn_deg: float, docked: bool) -> None:
    task = Docking()
    place, cost = (0.05, -0.03, 0.02 - task.depth_m), math.sqrt(0.05**2 + 4 * (0.03**2 + 0.02**2))
    seen = now({"before": 0.4}, place, (0.1, 0.05, -0.02), math.radians(turn_deg))
    found = task.reward(seen, numbers([0.5, -0.5]))
    expected = 0.4 - cost - 0.02 - 0.01 * 0.25 - 0.02 * abs(math.radians(turn_deg)) + 10.0 * docked
    assert number(found.reward) == pytest.approx(expected, abs=1e-9)
    assert bool(np.array(found.terminated).ravel()[0]) == docked


@pytest.mark.parametrize(
    ("velocity", "course"), [((2.0, 1.0, 0.0), 333.4), ((-0.5, -1.5, 0.1), 108.4), ((3.0, 0.002, 0.0), 0.0)]
)  # 3600 tenths: not available
def test_ais_tells_the_course_clockwise_from_north(velocity, course: float) -> None:
    made = object.__new__(Ais)
    origin = SimpleNamespace(to_geodetic=lambda p: np.array([[45.1, 13.2, 0.0]]))
    made._context = SimpleNamespace(world=SimpleNamespace(origin=origin))
    made._config, made._bow = SimpleNamespace(ais_class="A"), np.array([[1.0, 0.0, 0.0]])
    half = math.sqrt(0.5)
    pose = SimpleNamespace(
        position=np.zeros((1, 3)), velocity=np.array([velocity]), attitude=np.array([[half, 0, 0, half]])
    )
    found = made._position(pose, 0, 2.0)
    assert found["course"] == pytest.approx(course, abs=1e-3)
    assert found["heading"] == 270  # bow to the left of north


def test_holooceans_dynamics_at_a_point_off_the_centre() -> None:
    """a + w' x r + w x (w x r): of a point 2 m to the left of a vehicle that spins up about up, r = (0, 2, 0)."""
    sensor = object.__new__(DynamicsSensor)
    sensor.config = {"UseCOM": False, "UseRPY": True}
    motion = SimpleNamespace(
        rotation=np.eye(3), turn=np.array([0.0, 0.0, 1.5]), turn_acceleration=np.array([0.0, 0.0, 0.4]),
        acceleration=np.array([0.1, -0.2, 0.3]), position=np.array([5.0, 6.0, -7.0]),
        velocity_at=lambda at: np.array([1.0, 2.0, 3.0]),
    )  # fmt: skip
    sensor.offset, sensor.axes = np.array([0.0, 2.0, 0.0]), lambda m: np.eye(3)
    found = sensor.value(motion, None)
    assert found[:3] == pytest.approx([0.1 - 0.8, -0.2 - 4.5, 0.3], abs=1e-6)
    assert found[6:9] == pytest.approx([5.0, 8.0, -7.0])


def test_places_and_beams_of_holooceans_sensors() -> None:
    """A place is that of the mount; errors of a DVL's beams ahead and astern count against each other; lasers go round
    to the left.
    """
    motion = SimpleNamespace(
        rotation=Rotation.from_euler("z", 90, degrees=True).as_matrix(), position=np.array([5.0, 6.0, -7.0]),
        velocity_at=lambda at: np.zeros(3),
    )  # fmt: skip
    place = object.__new__(DynamicsSensor)
    place.offset = np.array([2.0, 0.5, 0.1])
    assert place.point(motion) == pytest.approx([4.5, 8.0, -6.9])
    dvl = object.__new__(DVLSensor)
    errors = np.array([0.3, 0.1, -0.2, 0.5])
    dvl._beams, dvl.stream = SimpleNamespace(root=1, draw=lambda stream: errors), None
    dvl._tilt, dvl.offset, dvl.axes = math.radians(22.5), np.zeros(3), lambda m: np.eye(3)
    sine, cosine = math.sin(dvl._tilt), math.cos(dvl._tilt)
    expected = [0.5 / (2 * sine), -0.4 / (2 * sine), 0.7 / (4 * cosine)]
    assert dvl.value(motion, None) == pytest.approx(expected, rel=1e-6)
    lasers = object.__new__(RangeFinderSensor)
    lasers.config = {"LaserCount": 4}
    assert lasers.native()["azimuth_deg"] == [0.0, 90.0, 180.0, 270.0]
