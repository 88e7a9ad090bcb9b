"""Lamps and lasers of a vehicle as its camera finds them, by image: places and axes turn with the hull."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.optics.lamp import Beam
from pelagos.optics.laser_beam import LaserBeam
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.surroundings import light_sources
from pelagos.sensors.sensor import Kinematics

HULLS = Rotation.from_euler("ZYX", [[40.0, -25.0, 15.0], [-110.0, 12.0, 70.0]], degrees=True)
CAMERA = np.array([0.31, -0.12, 0.27])
LAMP: dict[str, Any] = {
    "position_m": (0.9, 0.4, -0.2), "orientation_deg": (25.0, 33.0, -48.0), "flux_lm": 2100.0, "beam_angle_deg": 66.0,
    "color": (1.0, 0.8, 0.3),
}  # fmt: skip
LASER: dict[str, Any] = {
    "position_m": (-0.3, 0.2, 0.6), "orientation_deg": (-35.0, 10.0, 80.0), "flux_lm": 5.0, "fan_deg": 44.0,
    "aperture_mm": 6.0, "divergence_mrad": 14.0, "color": (0.2, 1.0, 0.1),
}  # fmt: skip
IMAGE = np.array([1, 0, 0, 1, 1])


def motion(lamps: list[float] | None = None) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 2), dr.zeros(jit.UInt32, 2)
    none = jit.Array3f64(zero, zero, zero)
    x, y, z, w = HULLS.as_quat().T
    made = Kinematics(
        jit.Array3f64(zero + 5.0, zero - 3.0, zero - 9.0), jit.Array4f64(*(jit.Float64(v) for v in (w, x, y, z))),
        none, none, none, none, jit.UInt64(u), u + 0, u + 0, dr.arange(jit.UInt32, 2),
    )  # fmt: skip
    return made if lamps is None else replace(made, lamps=jit.Float(lamps))


def turned(light: dict[str, Any], axis: list[float]) -> Any:
    """`(5, 3)` in the world; roll, pitch and yaw are about the axes of the turned frame, yaw first."""
    own = Rotation.from_euler("ZYX", light["orientation_deg"][::-1], degrees=True)
    return (HULLS * own).apply(axis)[IMAGE]


@pytest.mark.parametrize("share", [None, [0.25, 3.0]])
def test_lights_stand_and_point_as_the_hull_does(share: list[float] | None) -> None:
    config = CameraConfig(position_m=tuple(CAMERA), orientation_deg=(5.0, 6.0, 7.0), lamps=(LAMP,), lasers=(LASER,))
    lamp, laser = light_sources(config, motion(share), jit.UInt32(IMAGE))
    assert isinstance(lamp, Beam)
    assert isinstance(laser, LaserBeam)
    left = np.ones((5, 1)) if share is None else np.array(share)[IMAGE, None]

    def by_ray(values: Any) -> Any:
        return np.broadcast_to(np.array(values).T, (5, 3))

    for found, light in ((lamp, LAMP), (laser, LASER)):
        away = HULLS.apply(np.array(light["position_m"]) - CAMERA)[IMAGE]
        assert by_ray(found.position) == pytest.approx(away, abs=1e-6)
        assert by_ray(found.axis) == pytest.approx(turned(light, [1.0, 0.0, 0.0]), abs=1e-6)
    candela = 2100.0 / (2 * math.pi * (1 - math.cos(math.radians(33.0))) * 0.62)
    assert by_ray(lamp.intensity) == pytest.approx(candela * left * LAMP["color"], rel=1e-5)
    assert np.array(lamp.inner)[0] == pytest.approx(math.cos(math.radians(16.5)))
    assert np.array(lamp.outer)[0] == pytest.approx(math.cos(math.radians(33.0)))
    assert by_ray(laser.across) == pytest.approx(turned(LASER, [0.0, 0.0, 1.0]), abs=1e-6)
    assert by_ray(laser.flux) == pytest.approx(5.0 * left * LASER["color"], rel=1e-5)
    assert np.array(laser.waist)[0] == pytest.approx(3e-3)
    assert np.array(laser.spread)[0] == pytest.approx(7e-3)
    assert np.array(laser.fan)[0] == pytest.approx(math.radians(44.0))
    dot = light_sources(config.model_copy(update={"lasers": (replaced(fan_deg=0.0),)}), motion(), jit.UInt32(IMAGE))[1]
    assert isinstance(dot, LaserBeam)
    assert dot.fan is None


def replaced(**keys: Any) -> Any:
    return CameraConfig(lasers=(LASER | keys,)).lasers[0]
