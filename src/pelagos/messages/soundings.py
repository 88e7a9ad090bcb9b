"""Multibeam echo sounders as ROS 2 messages: a point cloud, and SonarRanges."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import DOWNWARD, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.point_cloud import POINT_CLOUD, point_cloud
from pelagos.messages.store import header, make, vector3
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Reading

SONAR_RANGES: Final = "marine_acoustic_msgs/msg/SonarRanges"
POINT: Final = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4")])
_BAD: Final = 1  # DetectionFlag.DETECT_BAD_SONAR


def multibeam(config: Any, site: Site) -> Encoding:
    """Data `(n, beams)` slant ranges [m]; extras `backscatter` [dB] becomes the intensity.

    The cloud has one point a beam in the sensor frame, NaN where no bottom was found.
    """
    angle = np.asarray(config.angles, dtype=np.float64)
    direction = np.stack([0 * angle, np.sin(angle), -np.cos(angle)]).astype(np.float32)  # (3, beams)
    cloud = Template(POINT_CLOUD, point_cloud(site.frame, POINT, len(angle)), [*STAMP, "data:bytes"])
    ranges = Template(
        SONAR_RANGES,
        _ranges(config, site.frame + DOWNWARD.suffix, angle),
        [*STAMP, "flags[].flag:bytes", "intensities:bytes", "ranges:bytes"],
    )

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        time = seconds_nanoseconds(reading.t_ns)
        distance = np.asarray(reading.data[copy], dtype=np.float32)
        strength = np.asarray(reading.extras["backscatter"][copy], dtype=np.float32)
        points = np.empty((len(distance), 4), dtype=np.float32)
        points[:, :3] = (direction * distance).T
        points[:, 3] = strength
        bad = np.where(np.isfinite(distance), 0, _BAD).astype(np.uint8)
        return (
            cloud.encode(*time, points.tobytes()),
            ranges.encode(*time, bad.tobytes(), strength.tobytes(), distance.tobytes()),
        )

    return Encoding((Topic("points", POINT_CLOUD), Topic("ranges", SONAR_RANGES)), encode, (DOWNWARD,))


def _ranges(config: Any, frame: str, angle: NDArray[np.float64]) -> Any:
    """Beams in the frame with z down and y to starboard."""
    zeros = np.zeros(len(angle), dtype=np.float32)
    ping = make(
        "marine_acoustic_msgs/msg/PingInfo",
        frequency=float(config.frequency_hz),
        sound_speed=float(config.sound_speed_mps or 0.0),  # 0: not reported
        tx_beamwidths=np.array([math.radians(config.beamwidth_along_deg)], dtype=np.float32),
        rx_beamwidths=np.array([math.radians(config.beamwidth_across_deg)], dtype=np.float32),
    )
    return make(
        SONAR_RANGES,
        header=header(frame),
        ping_info=ping,
        flags=[make("marine_acoustic_msgs/msg/DetectionFlag", flag=0) for _ in angle],
        transmit_delays=zeros,
        intensities=zeros,
        beam_unit_vec=[vector3(0.0, -math.sin(a), math.cos(a)) for a in angle],
        ranges=zeros,
    )
