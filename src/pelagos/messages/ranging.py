"""Doppler velocity logs and altimeters as ROS 2 messages."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.frames import flip_yz_np
from pelagos.messages.encoding import DOWNWARD, Encoding, Site, Table, Topic, tabular
from pelagos.messages.store import diagonal, header, make, vector3
from pelagos.messages.template import STAMP, Template, elements, fields, joined

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

    def variances(extras: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        return np.asarray((extras["sigma"] ** 2).mean(axis=1, keepdims=True) * dilution)

    def twist(data: NDArray[Any], extras: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        return np.concatenate([data, variances(extras)], axis=1)

    def full(data: NDArray[Any], extras: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        down = flip_yz_np(data)
        good = np.asarray(extras["beam_valid"], dtype=np.float64)
        course, speed = np.arctan2(down[:, 1], down[:, 0]), np.hypot(down[:, 0], down[:, 1])
        single = np.stack([np.asarray(extras["altitude"]), course, speed, good.sum(axis=1)], axis=1)
        beam = [extras["ranges"], good, extras["beam_velocity"], extras["sigma"] ** 2]
        return np.concatenate([down, variances(extras), single, *beam], axis=1)

    return tabular(
        Table(Topic("twist", TWIST_COVARIANCE), Template(TWIST_COVARIANCE, _twist(site.frame), TWIST_FIELDS), twist),
        Table(Topic("dvl", DVL), Template(DVL, _dvl(config, site.frame + DOWNWARD.suffix), DVL_FIELDS), full),
        frames=(DOWNWARD,),
    )


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

    def values(data: NDArray[Any], extras: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        distance = np.asarray(data, dtype=np.float64)
        return np.stack([distance, config.noise_m**2 + (config.noise_relative * distance) ** 2], axis=1)

    return tabular(Table(Topic("range", RANGE), Template(RANGE, message, RANGE_FIELDS), values))


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
