"""Six fixed views of the harbour: the realtime camera's mean colour against path tracing's."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.math.so3 import from_euler
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.exposure import saturation_luminance
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.harbour import HarbourConfig

# Mean light, red green blue [cd/m^2], of `renderer: reference` in type 1C, sun 45 deg high, 480 x 320 pixels of 512
# paths each: python examples/camera_against_reference.py 1C 512. Its standard error is about 1 %.
VIEWS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]] = {
    "seabed": ((0, 30, -11.8), (0, 90, 0), (35.0, 398.3, 207.6)),
    "wreck": ((18, -14, -12.5), (0, 10, 50), (22.57, 258.2, 175.1)),
    "piles": ((40, 50, -12), (0, -5, 45), (22.43, 232.6, 194.8)),
    "wall": ((0, 55, -6), (0, 0, 90), (47.4, 199.5, 206.1)),
    "chain": ((-98, -36, -6), (0, 0, 10), (122.7, 646.7, 602.2)),
    "upward": ((-30, 52, -6), (0, -55, 60), (1209.8, 3360.5, 3489.4)),
}


@pytest.fixture(scope="module")
def context() -> SensorContext:
    world = build_world(HarbourConfig(type="harbour"))
    ocean = build_ocean(OceanConfig(water_type="1C", sun={"elevation_deg": 45}), world)
    return SensorContext("auv0.camera", 1, 5_000_000, world.scene(1), world, ocean, np.full(1, NO_BODY, np.uint32))


@pytest.mark.parametrize("name", VIEWS)
def test_mean_colour_is_that_of_path_tracing(context: SensorContext, name: str):
    """5 % in each channel."""
    position, angles, expected = VIEWS[name]
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    q = from_euler(*(math.radians(a) for a in angles))
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(*(zero + float(c) for c in position)), jit.Array4f64(*(zero + float(c) for c in q)),
        none, none, none, none, jit.UInt64(u) + 3_000_000_000, u, u + 0, u + 0,
    )  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    config = CameraConfig(
        width_px=480, height_px=320, ripple=0.0, vignette=0.0, tone="linear", bits=16, compensation_ev=-4.0, samples=1
    )
    taken = Camera(config, context).sense(motion)
    full = saturation_luminance(config.aperture, taken.extras["exposure_s"][0], taken.extras["iso"][0])
    mean = taken.truth[0].mean(axis=(0, 1)) * (float(full) / 65535)
    assert mean == pytest.approx(np.array(expected), rel=0.05)
