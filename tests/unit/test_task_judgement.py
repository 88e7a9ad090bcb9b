"""Observations and rewards of learners' tasks by hand, at attitudes and places that are unequal on all axes."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.envs.tasks.depth_heading import DepthHeading
from pelagos.envs.tasks.docking import Docking
from pelagos.envs.tasks.hover import Hover
from pelagos.envs.tasks.marinegym_hover import _GOAL_M, MarineGymHover
from pelagos.envs.tasks.obstacles import _GOAL_M as _NORTH_M
from pelagos.envs.tasks.obstacles import _HULL_M, _RADIUS_M, ObstacleAvoidance
from pelagos.envs.tasks.oceanscale_hover import _GOAL_M as _ASKED_M
from pelagos.envs.tasks.oceanscale_hover import OceanScaleHover
from pelagos.envs.tasks.pipeline import _ABOVE_M, _PATH, _SPEED_MPS, _TOP_M, PipelineFollowing
from pelagos.envs.tasks.station_keeping import StationKeeping
from pelagos.envs.tasks.terrain import _HEIGHT_M, TerrainFollowing
from pelagos.envs.tasks.wall_inspection import _STAND_OFF_M, WallInspection
from pelagos.envs.tasks.waypoint import Waypoint
from pelagos.envs.view import View
from pelagos.vehicles.vehicle import Vehicle

EULER = [(0.3, -0.2, 0.7), (-0.5, 0.4, -2.2)]
"""Roll, pitch, yaw, FLU to NWU, R = Rz Ry Rx [rad]."""
PLACE, VELOCITY, RATES = np.array([1.3, -0.8, 0.6]), np.array([0.4, -0.3, 0.2]), np.array([0.15, -0.25, 0.35])
ACCELERATION, TURNING = np.array([0.5, 0.7, -0.9]), np.array([-1.1, 0.8, 1.4])


def turned(euler: Any) -> np.ndarray:
    return Rotation.from_euler("ZYX", np.array(euler)[::-1]).as_matrix()


def view(euler: Any, position: Any, **memory: float) -> View:
    x, y, z, w = Rotation.from_matrix(turned(euler)).as_quat()
    lists = lambda values: [jit.Float64(float(v)) for v in values]
    made = object.__new__(View)
    made._position, made._attitude = jit.Array3f64(*lists(position)), jit.Array4f64(*lists((w, x, y, z)))
    made.position, made.attitude = lists(position), lists((w, x, y, z))
    made.velocity, made.angular_velocity = lists(VELOCITY), lists(RATES)
    made.acceleration, made.angular_acceleration = lists(ACCELERATION), lists(TURNING)
    made.memory = {key: jit.Float64(value) for key, value in memory.items()}
    made.actuators, made.t = lists((0.2, -0.1, 0.3)), jit.Float64(2.0)
    return made


def row(values: Any) -> np.ndarray:
    return np.array([float(np.array(v).ravel()[0]) for v in values])


def number(value: Any) -> float:
    return float(np.array(value).ravel()[0])


ACTION = [jit.Float64(0.5), jit.Float64(-0.3)]
EFFORT = (0.25 + 0.09) / 2


@pytest.mark.parametrize("euler", EULER)
def test_a_boat_sees_its_place_ahead_and_to_the_left(euler: Any) -> None:
    """Along the heading: the place lies at -position; wanted heading 1.9."""
    task, now = StationKeeping(), view(euler, PLACE, yaw=1.9)
    yaw = math.atan2(turned(euler)[1, 0], turned(euler)[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = np.array([[c, s], [-s, c]]) @ -PLACE[:2]
    seen = row(task.observe(now, None))
    turn = math.remainder(1.9 - yaw, 2 * math.pi)
    up = turned(euler).T @ [0.0, 0.0, 1.0]
    expected = [
        ahead,
        left,
        math.sin(turn),
        math.cos(turn),
        math.atan2(up[1], up[2]),
        euler[1],
        *VELOCITY[:2],
        RATES[2],
    ]
    assert seen[:9] == pytest.approx(expected, abs=1e-9)
    assert seen[9:] == pytest.approx([0.002, -0.001])
    distance = math.hypot(ahead, left)
    reward = math.exp(-0.5 * distance) * (0.7 + 0.3 * math.exp(-2 * abs(turn))) - 0.05 * EFFORT
    assert number(task.reward(now, ACTION).reward) == pytest.approx(reward, abs=1e-9)


@pytest.mark.parametrize("euler", EULER)
@pytest.mark.parametrize(("depth", "yaw"), [(17.0, 1.9), (24.0, -0.4)])
def test_a_torpedo_sees_how_deep_and_how_far_round_it_has_to_go(euler: Any, depth: float, yaw: float) -> None:
    task, now = DepthHeading(), view(euler, [3.0, 4.0, -20.5], depth=depth, yaw=yaw)
    turn = math.remainder(yaw - math.atan2(turned(euler)[1, 0], turned(euler)[0, 0]), 2 * math.pi)
    up = turned(euler).T @ [0.0, 0.0, 1.0]
    seen = row(task.observe(now, None))
    expected = [depth - 20.5, math.sin(turn), math.cos(turn), math.atan2(up[1], up[2]), euler[1], *VELOCITY, *RATES]
    assert seen[:11] == pytest.approx(expected, abs=1e-9)
    reward = 0.5 * math.exp(-abs(depth - 20.5)) + 0.5 * math.exp(-2 * abs(turn)) - 0.05 * 2 * EFFORT
    assert number(task.reward(now, ACTION).reward) == pytest.approx(reward, abs=1e-9)


@pytest.mark.parametrize("euler", EULER)
def test_a_hovering_vehicle_sees_its_goal_from_its_body(euler: Any) -> None:
    task = Hover()
    place = PLACE + np.array(task.goal)
    now, matrix = view(euler, place), turned(euler)
    yaw = math.atan2(matrix[1, 0], matrix[0, 0])
    expected = [*(matrix.T @ -PLACE), math.sin(yaw), math.cos(yaw), *matrix[2], *VELOCITY, *RATES]
    assert row(task.observe(now, None)) == pytest.approx(expected, abs=1e-9)
    far, still = np.linalg.norm(PLACE), np.linalg.norm(VELOCITY) + 0.5 * np.linalg.norm(RATES)
    pose = math.exp(-far) * (0.6 + 0.25 * math.exp(-4 * far) + 0.15 * math.exp(-2 * abs(yaw)))
    assert number(task.reward(now, ACTION).reward) == pytest.approx(pose - 0.05 * still - 0.05 * EFFORT, abs=1e-9)


@pytest.mark.parametrize("euler", EULER)
def test_a_way_point_is_seen_from_the_body_and_coming_nearer_is_the_reward(euler: Any) -> None:
    task, goal = Waypoint(), PLACE + np.array([2.0, -1.0, 0.5])
    now = view(euler, PLACE, before=2.9, **dict(zip(("goal_x", "goal_y", "goal_z"), goal, strict=True)))
    matrix, far = turned(euler), math.sqrt(4 + 1 + 0.25)
    expected = [*(matrix.T @ [2.0, -1.0, 0.5]), *matrix[2], *VELOCITY, *RATES]
    assert row(task.observe(now, None)) == pytest.approx(expected, abs=1e-9)
    assert number(task.reward(now, ACTION).reward) == pytest.approx(2.9 - far - 0.02 - 0.01 * EFFORT, abs=1e-9)


@pytest.mark.parametrize("euler", EULER)
def test_marinegyms_hover_rewards_pose_uprightness_and_stillness(euler: Any) -> None:
    task, matrix = MarineGymHover(), turned(euler)
    now = view(euler, PLACE + np.array([0.0, 0.0, _GOAL_M]), heading=1.1)
    off = [*-PLACE, *([math.cos(1.1), math.sin(1.1), 0.0] - matrix[:, 0])]
    pose = 0.5 / (1 + (1.2 * np.linalg.norm(off)) ** 2)
    upright = ((matrix[2, 2] + 1) / 2) ** 2
    spin = 1 / (1 + (matrix @ RATES)[2] ** 4)
    reward = pose + pose * (upright + spin) + 0.1 * math.exp(-0.8)
    assert number(task.reward(now, ACTION).reward) == pytest.approx(reward, abs=1e-9)


@pytest.mark.parametrize("euler", EULER)
def test_oceanscales_hover_sees_rewards_and_pushes_as_its_source_does(euler: Any) -> None:
    """The wrench is Newton's and Euler's law with 13.5 kg and 0.26, 0.23, 0.37 kg m^2 (von Benzon 2022, Table A1)."""
    task, before = OceanScaleHover(), np.array([0.5, -0.3, 0.2, 0.1, -0.6, 0.4])
    memory = {f"action_{i}": float(a) for i, a in enumerate(before)}
    now = view(euler, PLACE + np.array([0.0, 0.0, _ASKED_M]), **memory)
    x, y, z, w = Rotation.from_matrix(turned(euler)).as_quat()
    inertia = np.array([0.26, 0.23, 0.37])
    force = 13.5 * (ACCELERATION + np.cross(RATES, VELOCITY))
    moment = inertia * TURNING + np.cross(RATES, inertia * RATES)
    angles = [2 * math.atan2(z, w), 2 * math.asin(y * w - x * z)]
    expected = [*-PLACE, x, y, z, w, *VELOCITY, *RATES, -PLACE[2], *angles, *before, force[2], *moment]
    quiet = SimpleNamespace(normal=lambda mean, deviation: 0.0)
    assert row(task.observe(now, quiet)) == pytest.approx(expected, abs=1e-9)
    far, still = np.linalg.norm(PLACE), np.linalg.norm([*VELOCITY, *RATES])
    action = [jit.Float64(float(a)) for a in -before]
    outcome = task.reward(now, action)
    reward = 0.5 * math.exp(-far) + 0.3 * math.exp(-still / 0.5) + 0.2 * math.exp(-np.linalg.norm(before))
    assert number(outcome.reward) == pytest.approx(reward, abs=1e-9)
    assert row([outcome.memory[name] for name in memory]) == pytest.approx(-before)
    assert number(task.reward(view(euler, [4.1, 2.9, _ASKED_M], **memory), action).reward) == 0.0


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("sign", [0.3, -0.2])
def test_oceanscales_actions_are_shares_of_a_wrench(axis: int, sign: float) -> None:
    """Throttles squared, through the thrusters' places, give the action back, where none is cut; body FLU."""
    given = np.zeros(6)
    given[axis] = sign * (1.0 if axis < 3 else 0.5)
    throttle = row(OceanScaleHover().command([jit.Float64(float(a)) for a in given], None))
    assert np.abs(throttle).max() < 1.0
    actuators = Vehicle.from_catalogue("bluerov2_heavy").model.actuators.values()
    effect = np.array([a.effect for a in actuators]).T  # a wrench, FRD, of one newton each
    made = effect @ (np.sign(throttle) * throttle**2) * [1, -1, -1, 1, -1, -1]
    assert made == pytest.approx(given, abs=1e-6)


@pytest.mark.parametrize(
    ("ahead", "aside", "struck"),
    [
        (-0.8, 0.55, False),
        (-0.8, 0.65, True),
        (-1.2, 2.0, False),
        (0.1, 0.15, False),
        (0.1, 0.25, True),
        (0.3, 0.1, True),
    ],
)
def test_a_funnel_is_struck_outside_its_cone(ahead: float, aside: float, struck: bool) -> None:
    """0.2 m wide each way at its end, 0.7 m a metre before it; beyond 0.2 m behind the end all is struck."""
    task = Docking()
    now = view((0.0, 0.0, 0.5), [ahead, -0.6 * aside, 0.8 * aside - task.depth_m], before=3.0)
    assert bool(np.array(task.reward(now, ACTION).terminated).ravel()[0]) == struck


def judged(task: Any, position: Any, euler: Any, **world: Any) -> Any:
    """Verdict on one copy at a place and attitude, with the velocity and rates above."""
    x, y, z, w = Rotation.from_matrix(turned(euler)).as_quat()
    state = SimpleNamespace(
        position=np.array([position], dtype=float), attitude=np.array([[w, x, y, z]]), velocity=VELOCITY[None],
        angular_velocity=RATES[None], euler=np.array([euler]), depth=np.array([-position[2]]),
    )  # fmt: skip
    sim = SimpleNamespace(state={task.agent: state}, n=1, world=SimpleNamespace(**world))
    return task.judge(sim, np.array([[0.5, -0.3]]), np.zeros(1, dtype=bool))


@pytest.mark.parametrize("euler", EULER)
@pytest.mark.parametrize("piece", [0, 1])
def test_a_pipeline_is_followed_along_its_own_direction(euler: Any, piece: int) -> None:
    """0.7 m to the left of the middle of a piece, 0.4 m too high."""
    a, b = _PATH[piece], _PATH[piece + 1]
    ahead = (b - a) / np.linalg.norm(b - a)
    left = np.array([-ahead[1], ahead[0]])
    found = judged(PipelineFollowing(), [*((a + b) / 2 + 0.7 * left), _TOP_M + _ABOVE_M + 0.4], euler)
    speed = (turned(euler) @ VELOCITY)[:2] @ ahead
    turn = abs(math.remainder(euler[2] - math.atan2(ahead[1], ahead[0]), 2 * math.pi))
    along = 1 - min(abs(speed - _SPEED_MPS) / _SPEED_MPS, 2.0)
    assert found.metrics["speed_mps"][0] == pytest.approx(speed)
    assert found.reward[0] == pytest.approx(along - 0.35 - 0.2 - 0.5 * turn)


@pytest.mark.parametrize("euler", EULER)
@pytest.mark.parametrize("gap", [0.3, -0.1])
def test_a_pillar_is_struck_where_its_side_meets_the_hull(euler: Any, gap: float) -> None:
    task = ObstacleAvoidance()
    first = task.pillars[np.argmin(task.pillars[:, 0])]
    found = judged(task, [first[0] - _RADIUS_M - _HULL_M - gap, first[1], -3.0], euler)
    assert found.metrics["clearance_m"][0] == pytest.approx(_HULL_M + gap)
    assert bool(found.metrics["collided"][0]) == (gap < 0)
    north = (turned(euler) @ VELOCITY)[0]
    assert found.reward[0] == pytest.approx(north / task.rate_hz - 10.0 * (gap < 0))
    assert first[0] < _NORTH_M


@pytest.mark.parametrize("euler", EULER)
@pytest.mark.parametrize("off", [0.6, -0.9])
def test_height_over_the_ground_is_what_terrain_following_keeps(euler: Any, off: float) -> None:
    ground = lambda x, y: -30.0 + 0.1 * x - 0.2 * y
    place = [*PLACE[:2], ground(*PLACE[:2]) + _HEIGHT_M + off]
    found = judged(TerrainFollowing(), place, euler, height=ground)
    reward = math.exp(-0.5 * abs(off)) - 0.3 * abs(euler[2]) - 0.02 * 2 * EFFORT
    assert found.reward[0] == pytest.approx(reward)


@pytest.mark.parametrize(
    ("height", "out"), [(0.99, True), (1.01, False), (11.99, False), (12.01, True), (math.nan, True)]
)
def test_terrain_is_left_below_above_and_beyond_its_edge(height: float, out: bool) -> None:
    """Beyond the edge there is no ground: its height is not a number. Leaving costs 10."""
    found = judged(TerrainFollowing(), PLACE, EULER[0], height=lambda x, y: 0 * x + PLACE[2] - height)
    assert bool(found.terminated[0]) == out
    error = abs((12.0 if math.isnan(height) else height) - _HEIGHT_M)
    kept = math.exp(-0.5 * error) - 0.3 * abs(EULER[0][2]) - 0.02 * 2 * EFFORT
    assert found.reward[0] == pytest.approx(kept - 10.0 * out)


@pytest.mark.parametrize("euler", EULER)
def test_a_wall_is_inspected_westwards_at_a_distance(euler: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    task = WallInspection()
    monkeypatch.setattr(task, "_wall", lambda sim: (np.array([_STAND_OFF_M + 0.7]), np.array([-0.3])))
    found = judged(task, [1.0, -2.0, -5.0], euler)
    west = (turned(euler) @ VELOCITY)[1]
    along = 1 - min(abs(west - 0.3) / 0.3, 2.0)
    assert found.metrics["west_mps"][0] == pytest.approx(west)
    assert found.reward[0] == pytest.approx(along - 0.35 - 0.15)


@pytest.mark.parametrize("beam", [20, 27])
def test_the_baseline_goes_round_an_echo_on_the_side_where_it_is_not(beam: int) -> None:
    """Beams run from port to starboard; a turn to port is positive. With nothing ahead: north, at full speed."""
    task = ObstacleAvoidance()
    picture = np.zeros((2, task.beams, task.bins), np.float32)
    picture[0, beam, 14] = 1.0
    picture[1, beam, -1] = 1.0  # far
    acts = task.script({"sonar": picture, "state": np.tile([0.0, 1.0, 0.0, 0.0, 0.0], (2, 1))})
    assert np.sign(acts[0, 1]) == (-1.0 if beam < task.beams / 2 else 1.0)
    assert abs(acts[0, 1]) > math.radians(5.0)
    assert acts[1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
