"""Doppler velocity logs and altimeters as ROS 2 messages."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pelagos.math.frames import flip_yz_np
from pelagos.messages.encoding import DOWNWARD, Buffer, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.store import diagonal, header, make, vector3
from pelagos.messages.template import STAMP, Template, elements, fields, joined
from pelagos.sensors.sensor import Reading

DVL: Final = "marine_acoustic_msgs/msg/Dvl"
TWIST_COVARIANCE: Final = "geometry_msgs/msg/TwistWithCovarianceStamped"
RANGE: Final = "sensor_msgs/msg/Range"
_UNKNOWN: Final = 1e6  # variance of what is not measured
_BOTTOM: Final = 1  # Dvl.DVL_MODE_BOTTOM

TWIST_FIELDS: Final = joined(
    STAMP, fields("twist.twist.linear", "x y z"), [f"twist.covariance[{i}]:float64" for i in (0, 7, 14)]
)
DVL_FIELDS: Final = joined(
    STAMP, fields("velocity", "x y z"), [f"velocity_covar[{i}]:float64" for i in (0, 4, 8)],
    [f"{name}:float64" for name in ("altitude", "course_gnd", "speed_gnd")], ["num_good_beams:uint8"],
    elements("range", 4, "float64"), elements("beam_quality", 4, "float32"), elements("beam_velocity", 4, "float32"),
    elements("beam_velocity_covar", 4, "float32"),
)  # fmt: skip
RANGE_FIELDS: Final = joined(STAMP, ["range:float32", "variance:float32"])


def dvl(config: Any, site: Site) -> Encoding:
    """Twist in the sensor frame FLU, and Dvl in the frame with z down; data `(n, 3)` velocity over ground [m/s]."""
    beams = np.asarray(config.beams, dtype=np.float64)
    dilution = np.diag(np.linalg.inv(beams.T @ beams))  # variance of the velocity for unit variance along the beams
    twist = Template(TWIST_COVARIANCE, _twist(site.frame), TWIST_FIELDS)
    full = Template(DVL, _dvl(config, site.frame + DOWNWARD.suffix), DVL_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        time = seconds_nanoseconds(reading.t_ns)
        x, y, z = reading.data[copy].tolist()
        extras = reading.extras
        sigma2 = np.asarray(extras["sigma"][copy], dtype=np.float64) ** 2
        good = np.asarray(extras["beam_valid"][copy], dtype=bool)
        vx, vy, vz = (float(sigma2.mean()) * dilution).tolist()
        return (
            twist.encode(*time, x, y, z, vx, vy, vz),
            full.encode(
                *time, x, -y, -z, vx, vy, vz,
                float(extras["altitude"][copy]), math.atan2(-y, x), math.hypot(x, y), int(good.sum()),
                *extras["ranges"][copy].tolist(), *good.astype(float).tolist(),
                *extras["beam_velocity"][copy].tolist(), *sigma2.tolist(),
            ),
        )  # fmt: skip

    return Encoding((Topic("twist", TWIST_COVARIANCE), Topic("dvl", DVL)), encode, (DOWNWARD,))


def altimeter(config: Any, site: Site) -> Encoding:
    """sensor_msgs/Range; data `(n,)` [m]."""
    message = make(
        RANGE,
        header=header(site.frame),
        radiation_type=0,  # sound
        field_of_view=math.radians(config.beamwidth_deg),
        min_range=float(config.range_min_m),
        max_range=float(config.range_max_m),
        range=0.0,
        variance=0.0,
    )
    template = Template(RANGE, message, RANGE_FIELDS)

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        distance = float(reading.data[copy])
        variance = config.noise_m**2 + (config.noise_relative * distance) ** 2
        return (template.encode(*seconds_nanoseconds(reading.t_ns), distance, variance),)

    return Encoding((Topic("range", RANGE),), encode)


def _twist(frame: str) -> Any:
    return make(
        TWIST_COVARIANCE,
        header=header(frame),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=make("geometry_msgs/msg/Twist", linear=vector3(), angular=vector3()),
            covariance=diagonal(0.0, 0.0, 0.0, _UNKNOWN, _UNKNOWN, _UNKNOWN),
        ),
    )


def _dvl(config: Any, frame: str) -> Any:
    unit = [vector3(*b) for b in flip_yz_np(np.asarray(config.beams, dtype=np.float64)).tolist()]
    return make(
        DVL,
        header=header(frame),
        velocity_mode=_BOTTOM,
        dvl_type=0,
        velocity=vector3(),
        velocity_covar=np.zeros(9),
        altitude=0.0,
        course_gnd=0.0,
        speed_gnd=0.0,
        num_good_beams=4,
        sound_speed=float(config.sound_speed_mps or 0.0),
        beam_ranges_valid=True,
        beam_velocities_valid=True,
        beam_unit_vec=unit,
        range=np.zeros(4),
        range_covar=np.full(4, -1.0, dtype=np.float32),
        beam_quality=np.zeros(4, dtype=np.float32),
        beam_velocity=np.zeros(4, dtype=np.float32),
        beam_velocity_covar=np.zeros(4, dtype=np.float32),
    )
