"""Navigation sensors as ROS 2 messages: inertial, magnetic, satellite, depth, and the true pose and velocity."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.math.frames import nwu_to_enu_np, quaternion_nwu_to_enu_np
from pelagos.messages.encoding import Buffer, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.motion import WORLD_FRAME
from pelagos.messages.store import diagonal, header, make, quaternion, vector3
from pelagos.messages.template import STAMP, Template, fields, joined
from pelagos.sensors.sensor import Reading

IMU: Final = "sensor_msgs/msg/Imu"
MAGNETIC_FIELD: Final = "sensor_msgs/msg/MagneticField"
NAV_SAT_FIX: Final = "sensor_msgs/msg/NavSatFix"
POSE_COVARIANCE: Final = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE: Final = "geometry_msgs/msg/PoseStamped"
TWIST: Final = "geometry_msgs/msg/TwistStamped"
UNKNOWN: Final = 1e6  # variance of what a sensor does not measure

IMU_FIELDS: Final = joined(STAMP, fields("angular_velocity", "x y z"), fields("linear_acceleration", "x y z"))
MAGNETIC_FIELDS: Final = joined(STAMP, fields("magnetic_field", "x y z"))
FIX_FIELDS: Final = joined(STAMP, [f"{name}:float64" for name in ("latitude", "longitude", "altitude")])
POSE_FIELDS: Final = joined(STAMP, fields("pose.position", "x y z"), fields("pose.orientation", "x y z w"))
TWIST_FIELDS: Final = joined(STAMP, fields("twist.linear", "x y z"))
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
    template = Template(IMU, message, IMU_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        fx, fy, fz, wx, wy, wz = reading.data[copy].tolist()
        return (template.encode(*seconds_nanoseconds(reading.t_ns), wx, wy, wz, fx, fy, fz),)

    return Encoding((Topic("data_raw", IMU),), encode)


def magnetometer(config: Any, site: Site) -> Encoding:
    """sensor_msgs/MagneticField [T]."""
    variance = config.noise_density**2 * config.rate_hz
    message = make(
        MAGNETIC_FIELD,
        header=header(site.frame),
        magnetic_field=vector3(),
        magnetic_field_covariance=diagonal(variance, variance, variance),
    )
    return Encoding((Topic("mag", MAGNETIC_FIELD),), _rows(Template(MAGNETIC_FIELD, message, MAGNETIC_FIELDS)))


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
    return Encoding((Topic("fix", NAV_SAT_FIX),), _rows(Template(NAV_SAT_FIX, message, FIX_FIELDS)))


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
    template = Template(POSE_COVARIANCE, message, DEPTH_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        return (template.encode(*seconds_nanoseconds(reading.t_ns), -float(reading.data[copy])),)

    return Encoding((Topic("pose", POSE_COVARIANCE),), encode)


def pose(config: Any, site: Site) -> Encoding:
    """geometry_msgs/PoseStamped in the world frame; data `(n, 7)` NWU position [m], quaternion wxyz."""
    template = Template(POSE, make(POSE, header=header(WORLD_FRAME), pose=_pose()), POSE_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        row = reading.data[copy]
        w, x, y, z = quaternion_nwu_to_enu_np(row[3:]).tolist()
        return (template.encode(*seconds_nanoseconds(reading.t_ns), *nwu_to_enu_np(row[:3]).tolist(), x, y, z, w),)

    return Encoding((Topic("pose", POSE),), encode)


def velocity(config: Any, site: Site) -> Encoding:
    """geometry_msgs/TwistStamped in the world frame; data `(n, 3)` NWU [m/s]."""
    message = make(
        TWIST,
        header=header(WORLD_FRAME),
        twist=make("geometry_msgs/msg/Twist", linear=vector3(), angular=vector3()),
    )
    template = Template(TWIST, message, TWIST_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        enu = nwu_to_enu_np(reading.data[copy]).tolist()
        return (template.encode(*seconds_nanoseconds(reading.t_ns), *enu),)

    return Encoding((Topic("twist", TWIST),), encode)


def _rows(template: Template) -> Any:
    """An encoder of a template whose values are the reading's own."""

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        return (template.encode(*seconds_nanoseconds(reading.t_ns), *reading.data[copy].tolist()),)

    return encode


def _pose() -> Any:
    point = make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0)
    return make("geometry_msgs/msg/Pose", position=point, orientation=quaternion())
