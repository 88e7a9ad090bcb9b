"""Encoders by sensor type."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from pelagos.messages import (
    camera,
    communication,
    images,
    lidar,
    navigation,
    ranging,
    sonar_image,
    soundings,
    trace,
    water,
)
from pelagos.messages.encoding import Encoding, Site
from pelagos.messages.numbers import numbers

ENCODERS: Final[Mapping[str, Callable[[Any, Site], Encoding]]] = {
    "imu": navigation.imu,
    "magnetometer": navigation.magnetometer,
    "gps": navigation.gps,
    "depth": navigation.depth,
    "pose": navigation.pose,
    "velocity": navigation.velocity,
    "collision": navigation.collision,
    "dvl": ranging.dvl,
    "altimeter": ranging.altimeter,
    "camera": camera.camera,
    "depth_camera": images.depth,
    "semantic_camera": images.pixels,
    "instance_camera": images.pixels,
    "normal_camera": images.pixels,
    "optical_flow_camera": images.pixels,
    "thermal_camera": images.pixels,
    "event_camera": images.pixels,
    "lidar": lidar.lidar,
    "semantic_lidar": lidar.lidar,
    "imaging_sonar": sonar_image.imaging_sonar,
    "profiling_sonar": sonar_image.imaging_sonar,
    "sidescan": trace.sidescan,
    "singlebeam": trace.singlebeam,
    "mechanical_scanning_sonar": trace.mechanical_scanning_sonar,
    "multibeam": soundings.multibeam,
    "ctd": water.ctd,
    "sound_velocity": water.water_property,
    "fluorometer": water.water_property,
    "oxygen": water.water_property,
    "turbidity": water.water_property,
    "tracer": water.water_property,
    "current_meter": water.current_meter,
    "modem": communication.modem,
    "usbl": communication.modem,
    "ais": communication.modem,
    "optical_modem": communication.modem,
    "radio": communication.modem,
}


def encoder(config: Any, site: Site) -> Encoding:
    """The encoding of a sensor with this configuration; plain numbers where its type has no message of its own."""
    return ENCODERS.get(config.type, numbers)(config, site)
