"""Light counts depth from the level of the tide: a scene under 3 m more water, and the same 3 m lower down."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.depth_camera import DepthCamera, DepthCameraConfig
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables

RISE = 3.0  # [m]


def plate(z: float, low: float, high: float) -> Geometry:
    corners = np.array([[low, -40, z], [high, -40, z], [high, 40, z], [low, 40, z]], dtype=float)
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)


def context(ground: float, tide: float) -> SensorContext:
    """A white floor at height `ground`, and a roof over the far half of it, at the level `tide` of the sea."""
    materials = [MATERIALS["white"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    scene = Scene([plate(ground, -60, 60), plate(ground + 4.0, 4, 60)], copies=1)
    ocean: dict[str, Any] = {"water_type": "1C", "sun": {"elevation_deg": 50, "azimuth_deg": 130}}
    if tide:
        ocean["tide"] = [{"constituent": "M2", "amplitude_m": tide}]  # high water at t = 0
    made = build_ocean(OceanConfig.model_validate(ocean))
    return SensorContext("auv0.camera", 1, 5_000_000, scene, world, made, np.full(1, NO_BODY, np.uint32))


def motion(z: float, pitch_deg: float) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    half = math.radians(pitch_deg) / 2
    none = jit.Array3f64(zero, zero, zero)
    made = Kinematics(
        jit.Array3f64(zero, zero, zero + z),
        jit.Array4f64(zero + math.cos(half), zero, zero + math.sin(half), zero),
        none, none, none, none, jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    dr.eval(made)
    return made


def light(ground: float, tide: float, above: float, pitch_deg: float, **camera: Any) -> Any:
    """`(3, pixels)` before exposure [cd/m^2], from `above` the ground."""
    config = CameraConfig(width_px=32, height_px=32, vignette=0.0, exposure="manual", **camera)
    found = Camera(config, context(ground, tide)).explain(motion(ground + above, pitch_deg))
    return next(values for name, values, _ in found if name == "light at the sensor")


POSES = {
    "floor": (2.0, 60.0),
    "level": (2.0, 0.0),
    "roof": (2.0, -60.0),
    "surface": (5.0, -80.0),
    "from the air": (10.0, 50.0),
}
QUICK = {("floor", "reference"), ("roof", "realtime"), ("from the air", "realtime")}


@pytest.mark.parametrize(
    ("above", "pitch_deg", "renderer"),
    [
        pytest.param(*pose, r, id=f"{name}-{r}", marks=[] if (name, r) in QUICK else [pytest.mark.slow])
        for r in ("realtime", "reference")
        for name, pose in POSES.items()
    ],
)
def test_high_water_is_as_dark_as_three_metres_more(renderer: str, above: float, pitch_deg: float):
    """The same rays and the same random numbers; single precision at another height, which now and then sends a path
    another way: half a percent of the mean. Ebb would be three times as bright in red (Kd 0.31 /m)."""
    lamp = {"flux_lm": 1000.0, "position_m": (0.0, 0.5, 0.0)}
    more = {"renderer": renderer, "lamps": (lamp,), "samples": 64 if renderer == "reference" else 1}
    high, deep, ebb = (
        light(ground, tide, above, pitch_deg, **more)
        for ground, tide in ((-5.0, RISE), (-5.0 - RISE, 0.0), (-5.0, 0.0))
    )
    assert high.mean(axis=1) == pytest.approx(deep.mean(axis=1), rel=0.005)
    assert np.abs(high - ebb).mean() > 20 * np.abs(high - deep).mean()
    if renderer == "realtime":
        assert np.median(np.abs(high / deep - 1)) < 1e-3


def test_realtime_and_reference_agree_at_high_water():
    """As without tide: 12 % on a plate, see `test_camera_reference`."""
    realtime, reference = (
        light(-5.0, RISE, 2.0, 60.0, renderer=r, samples=s, ripple=0.0).mean(axis=1)
        for r, s in (("realtime", 1), ("reference", 256))
    )
    assert realtime == pytest.approx(reference, rel=0.12)


@pytest.mark.parametrize(("tide", "index"), [(RISE, 1.34), (0.0, 1.0)])
def test_a_port_is_wet_up_to_the_tide(tide: float, index: float):
    """1 m over z = 0: at high water it refracts by Snell's law, else not. The farthest slant range over the nearest, of
    a level plate below, is 1 / cos of the corner pixel's angle."""
    config = DepthCameraConfig(
        width_px=64, height_px=64, horizontal_fov_deg=70, orientation_deg=(0, 90, 0),
        port={"type": "flat", "distance_m": 1e-3, "thickness_m": 0.0}, max_range_m=100,
    )  # fmt: skip
    traced = DepthCamera(config, context(-5.0, tide)).explain(motion(1.0, 0.0))
    slant = next(values for name, values, _ in traced if name == "slant range")
    corner = math.sqrt(2) * math.tan(math.radians(35)) * 63 / 64
    sine = math.sin(math.atan(corner)) / index
    floor = slant[np.isfinite(slant) & (slant > 5.5)]
    assert floor.max() / floor.min() == pytest.approx(1 / math.sqrt(1 - sine**2), rel=1e-3)
