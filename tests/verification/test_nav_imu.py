"""The inertial unit against closed forms of rigid-body kinematics and against its own noise figures."""

from types import SimpleNamespace

import numpy as np
import pytest

from pelagos.sensors.example_motion import lanes
from pelagos.sensors.mount import GRAVITY, sensor_pose, sensor_velocity
from pelagos.sensors.navigation.imu import Imu, ImuConfig
from pelagos.sensors.navigation.pose import Pose, PoseConfig
from pelagos.sensors.navigation.velocity import Velocity, VelocityConfig
from pelagos.sensors.sensor import SensorContext

DT = 5_000_000
PERFECT = {
    name: 0.0
    for name in ImuConfig.model_fields
    if name.endswith(("_density", "_instability", "_random_walk", "_std", "_resolution"))
}


def imu(**changes) -> Imu:
    context = SensorContext("auv0.imu", 4, DT, None, SimpleNamespace(origin=None), None, np.zeros(1, np.uint32))
    return Imu(ImuConfig(**changes), context)


def read(sensor: Imu, **motion) -> np.ndarray:
    return sensor.sense(lanes([7], dt_ns=DT, **motion)).data[0]


def quaternion(axis, angle: float) -> np.ndarray:
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis, dtype=float))])


def test_rest_and_level_feels_gravity_upwards() -> None:
    assert read(imu(**PERFECT)) == pytest.approx([0, 0, GRAVITY, 0, 0, 0], abs=1e-12)


@pytest.mark.parametrize(
    ("axis", "angle", "force"),
    [
        ((0, 1, 0), np.pi / 2, (-GRAVITY, 0, 0)),  # nose down: up lies behind
        ((0, 1, 0), np.radians(-10), (GRAVITY * np.sin(np.radians(10)), 0, GRAVITY * np.cos(np.radians(10)))),
        ((1, 0, 0), np.pi / 2, (0, GRAVITY, 0)),  # starboard side down: up lies to port
        ((0, 0, 1), 1.0, (0, 0, GRAVITY)),
        ((1, 0, 0), np.pi, (0, 0, -GRAVITY)),
    ],
)
def test_rest_and_tilted(axis, angle, force) -> None:
    assert read(imu(**PERFECT), attitude=quaternion(axis, angle))[:3] == pytest.approx(force, abs=1e-12)


def test_mounting_turns_the_axes() -> None:
    """Turned 90 deg to port it reads the body's x on its -y; pitched 90 deg down it reads up on its -x."""
    turned = imu(**PERFECT, orientation_deg=(0, 0, 90))
    reading = read(turned, acceleration=(2.0, 0, 0), angular_velocity=(0.3, 0, 0))
    assert reading == pytest.approx([0, -2, GRAVITY, 0, -0.3, 0], abs=1e-12)
    pitched = imu(**PERFECT, orientation_deg=(0, 90, 0))
    assert read(pitched)[:3] == pytest.approx([-GRAVITY, 0, 0], abs=1e-12)


def test_lever_arm_of_steady_turn_and_of_spin_up() -> None:
    """w x (w x r) = -w^2 r towards the axis, and w' x r across it."""
    reading = read(
        imu(**PERFECT, position_m=(0.5, 0, 0.2)), angular_velocity=(0, 0, 2.0), angular_acceleration=(0, 0, 3.0)
    )
    assert reading == pytest.approx([-(2.0**2) * 0.5, 3.0 * 0.5, GRAVITY, 0, 0, 2.0], abs=1e-12)


def test_lever_arm_against_differentiated_motion() -> None:
    """A mount on a body that tumbles with constant body rates: the second difference of its path, h^2 = 1e-6 of a
    radian.
    """
    rate, arm, h = np.array([0.3, -0.5, 0.8]), (0.4, -0.7, 0.3), 1e-3
    times = np.array([-h, 0.0, h]) + 1.3
    speed = np.linalg.norm(rate)
    attitudes = np.array([quaternion(rate / speed, speed * t) for t in times])
    motion = lanes(range(3), dt_ns=DT, attitude=attitudes, angular_velocity=rate)
    config = ImuConfig(**PERFECT, position_m=arm)
    path = np.array(sensor_pose(motion, config)[0]).T
    acceleration = (path[0] - 2 * path[1] + path[2]) / h**2
    w, x, y, z = attitudes[1]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    expected = rotation.T @ (acceleration + np.array([0, 0, GRAVITY]))
    found = imu(**PERFECT, position_m=arm).sense(motion).truth[1, :3]
    assert found == pytest.approx(expected, abs=2e-6)


def test_velocity_at_a_lever_arm() -> None:
    """w = (0, 0, 0.5) rad/s at r = (0.5, 0, 0.2) m adds (0, 0.25, 0) m/s."""
    config = VelocityConfig(position_m=(0.5, 0, 0.2))
    motion = lanes([0], dt_ns=DT, velocity=(1, 0, 0), angular_velocity=(0, 0, 0.5))
    assert np.array(sensor_velocity(motion, config)).T[0] == pytest.approx([1, 0.25, 0], abs=1e-15)
    turned = lanes(
        [0], dt_ns=DT, velocity=(1, 0, 0), angular_velocity=(0, 0, 0.5), attitude=quaternion((0, 0, 1), np.pi / 2)
    )
    context = SensorContext("a.v", 0, DT, None, None, None, np.zeros(1, np.uint32))
    assert Velocity(config, context).sense(turned).data[0] == pytest.approx([-0.25, 1, 0], abs=1e-15)


def test_pose_of_a_mount() -> None:
    config = PoseConfig(position_m=(1, 0, 0), orientation_deg=(0, 0, 90))
    context = SensorContext("a.p", 0, DT, None, None, None, np.zeros(1, np.uint32))
    motion = lanes([0], dt_ns=DT, position=(5, 6, -7), attitude=quaternion((0, 0, 1), np.pi / 2))
    expected = [5, 7, -7, *quaternion((0, 0, 1), np.pi)]
    assert Pose(config, context).sense(motion).data[0] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("rate", [50, 200])
def test_density_does_not_depend_on_the_rate(rate: int) -> None:
    """The standard deviation of a one-second mean is the density, at any rate: 2 000 s, 1.6 % (one sigma of a
    deviation).
    """
    dt = 1_000_000_000 // rate
    only = {**PERFECT, "accelerometer_noise_density": 1e-3, "gyroscope_noise_density": 4e-5}
    data = imu(**only, rate_hz=rate).sense(lanes(range(2000 * rate), dt_ns=dt)).data
    means = data.reshape(2000, rate, 6).mean(axis=1)
    assert means.std(axis=0) == pytest.approx([1e-3] * 3 + [4e-5] * 3, rel=0.065)


def test_range_and_resolution() -> None:
    sensor = imu(**{**PERFECT, "accelerometer_resolution": 0.5, "gyroscope_resolution": 0.1}, accelerometer_range=15.0)
    reading = read(sensor, acceleration=(99, -99, 0.3), angular_velocity=(0.34, -0.36, 99))
    assert reading == pytest.approx([15, -15, 10, 0.3, -0.4, np.radians(400)])


def test_constant_errors_have_their_spread() -> None:
    """Over 400 copies: standard deviations within 4 sigma (14 %) of what was asked."""
    only = {**PERFECT, "accelerometer_bias_std": 0.1, "gyroscope_bias_std": 0.01}
    moving = {"angular_velocity": (1.0, 2.0, 3.0), "environments": range(400)}
    data = imu(**only).sense(lanes([3], dt_ns=DT, **moving)).data
    assert data.std(axis=0) == pytest.approx([0.1] * 3 + [0.01] * 3, rel=0.14)
    data = imu(**{**PERFECT, "gyroscope_scale_std": 1e-3}).sense(lanes([3], dt_ns=DT, **moving)).data
    assert data[:, 3:].std(axis=0) == pytest.approx([1e-3, 2e-3, 3e-3], rel=0.14)
    data = imu(**{**PERFECT, "misalignment_std": 1e-3}).sense(lanes([3], dt_ns=DT, **moving)).data
    across = np.sqrt([13, 10, 5])  # of the two other components
    assert data[:, 3:].std(axis=0) == pytest.approx(1e-3 * across, rel=0.14)
    assert np.abs(np.corrcoef(data[:, 3:].T) - np.eye(3)).max() < 0.2


def test_truth_plus_bias_and_noise_is_data() -> None:
    only = {**PERFECT, "gyroscope_bias_std": 0.01, "gyroscope_random_walk": 0.1, "accelerometer_bias_instability": 0.1}
    m = imu(**only).sense(lanes(range(100_000, 100_050), dt_ns=DT, angular_velocity=(1, 2, 3)))
    assert m.data == pytest.approx(m.truth + m.extras["bias"], abs=1e-12)
    assert np.abs(m.extras["bias"]).min() > 0
