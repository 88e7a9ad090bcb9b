"""Navigation sensors as ROS 2 messages: inertial, magnetic, satellite, depth, and the true pose and velocity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.frames import nwu_to_enu_np, quaternion_nwu_to_enu_np
from pelagos.messages.encoding import Encoding, Site, Table, Topic, Values, tabular
from pelagos.messages.motion import WORLD_FRAME
from pelagos.messages.store import diagonal, header, make, quaternion, vector3
from pelagos.messages.template import STAMP, Template, fields, joined

IMU: Final = "sensor_msgs/msg/Imu"
MAGNETIC_FIELD: Final = "sensor_msgs/msg/MagneticField"
NAV_SAT_FIX: Final = "sensor_msgs/msg/NavSatFix"
POSE_COVARIANCE: Final = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE: Final = "geometry_msgs/msg/PoseStamped"
TWIST: Final = "geometry_msgs/msg/TwistStamped"
WRENCH: Final = "geometry_msgs/msg/WrenchStamped"
UNKNOWN: Final = 1e6  # variance of what a sensor does not measure

IMU_FIELDS: Final = joined(STAMP, fields("angular_velocity", "x y z"), fields("linear_acceleration", "x y z"))
MAGNETIC_FIELDS: Final = joined(STAMP, fields("magnetic_field", "x y z"))
FIX_FIELDS: Final = joined(STAMP, [f"{name}:float64" for name in ("latitude", "longitude", "altitude")])
POSE_FIELDS: Final = joined(STAMP, fields("pose.position", "x y z"), fields("pose.orientation", "x y z w"))
TWIST_FIELDS: Final = joined(STAMP, fields("twist.linear", "x y z"))
WRENCH_FIELDS: Final = joined(STAMP, fields("wrench.force", "x y z"), fields("wrench.torque", "x y z"))
DEPTH_FIELDS: Final = joined(STAMP, fields("pose.pose.position", "z"))


def imu(config: Any, site: Site) -> Encoding:
    """sensor_msgs/Imu without an orientation; data `(n, 6)`: specific force, angular rate."""
    accelerometer = config.accelerometer_noise_density**2 * config.rate_hz
    gyroscope = config.gyroscope_noise_density**2 * config.rate_hz
    no_orientation = np.zeros(9)
    no_orientation[0] = -1.0
    message = make(
        IMU,
        header=header(site.frame),
        orientation=quaternion(),
        orientation_covariance=no_orientation,
        angular_velocity=vector3(),
        angular_velocity_covariance=diagonal(gyroscope, gyroscope, gyroscope),
        linear_acceleration=vector3(),
        linear_acceleration_covariance=diagonal(accelerometer, accelerometer, accelerometer),
    )
    rate_then_force = [3, 4, 5, 0, 1, 2]
    return _one("data_raw", Template(IMU, message, IMU_FIELDS), lambda data, extras: data[:, rate_then_force])


def magnetometer(config: Any, site: Site) -> Encoding:
    """sensor_msgs/MagneticField [T]; the variance is that of the noise and of the iron that no calibration found."""
    variance = config.noise_density**2 * config.rate_hz + config.bias_std_t**2
    message = make(
        MAGNETIC_FIELD,
        header=header(site.frame),
        magnetic_field=vector3(),
        magnetic_field_covariance=diagonal(variance, variance, variance),
    )
    return _one("mag", Template(MAGNETIC_FIELD, message, MAGNETIC_FIELDS), lambda data, extras: data)


def gps(config: Any, site: Site) -> Encoding:
    """sensor_msgs/NavSatFix; data `(n, 3)` latitude, longitude [deg], height [m]."""
    white = config.noise_density**2 * config.rate_hz
    horizontal = config.horizontal_std_m**2 + white
    vertical = config.vertical_std_m**2 + 2.25 * white
    message = make(
        NAV_SAT_FIX,
        header=header(site.frame),
        status=make("sensor_msgs/msg/NavSatStatus", status=0, service=1),
        latitude=0.0,
        longitude=0.0,
        altitude=0.0,
        position_covariance=diagonal(horizontal, horizontal, vertical),
        position_covariance_type=2,  # the diagonal is known
    )
    return _one("fix", Template(NAV_SAT_FIX, message, FIX_FIELDS), lambda data, extras: data)


def depth(config: Any, site: Site) -> Encoding:
    """geometry_msgs/PoseWithCovarianceStamped in the world frame, of which only z counts."""
    variance = config.noise_density**2 * config.rate_hz + config.bias_std_m**2
    message = make(
        POSE_COVARIANCE,
        header=header(WORLD_FRAME),
        pose=make(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=_pose(),
            covariance=diagonal(UNKNOWN, UNKNOWN, variance, UNKNOWN, UNKNOWN, UNKNOWN),
        ),
    )
    return _one("pose", Template(POSE_COVARIANCE, message, DEPTH_FIELDS), lambda data, extras: -data[:, None])


def pose(config: Any, site: Site) -> Encoding:
    """geometry_msgs/PoseStamped in the world frame; data `(n, 7)` NWU position [m], quaternion wxyz."""

    def values(data: NDArray[Any], extras: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        q = quaternion_nwu_to_enu_np(data[:, 3:])
        return np.concatenate([nwu_to_enu_np(data[:, :3]), q[:, 1:], q[:, :1]], axis=1)

    return _one("pose", Template(POSE, make(POSE, header=header(WORLD_FRAME), pose=_pose()), POSE_FIELDS), values)


def velocity(config: Any, site: Site) -> Encoding:
    """geometry_msgs/TwistStamped in the world frame; data `(n, 3)` NWU [m/s]."""
    message = make(
        TWIST,
        header=header(WORLD_FRAME),
        twist=make("geometry_msgs/msg/Twist", linear=vector3(), angular=vector3()),
    )
    return _one("twist", Template(TWIST, message, TWIST_FIELDS), lambda data, extras: nwu_to_enu_np(data))


def collision(config: Any, site: Site) -> Encoding:
    """geometry_msgs/WrenchStamped of the strongest contact [N], [N m], zero without one; in the body's frame."""
    message = make(
        WRENCH,
        header=header(f"{site.frame.rsplit('/', 1)[0]}/base_link"),
        wrench=make("geometry_msgs/msg/Wrench", force=vector3(), torque=vector3()),
    )

    def values(data: Any, extras: Mapping[str, Any]) -> Any:
        return np.concatenate([extras["force"], extras["moment"]], axis=-1)

    return _one("wrench", Template(WRENCH, message, WRENCH_FIELDS), values)


def _one(suffix: str, template: Template, values: Values) -> Encoding:
    return tabular(Table(Topic(suffix, template.name), template, values))


def _pose() -> Any:
    point = make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0)
    return make("geometry_msgs/msg/Pose", position=point, orientation=quaternion())
