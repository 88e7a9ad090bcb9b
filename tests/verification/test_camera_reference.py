"""The realtime view against path tracing, and path tracing against the tables."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.atmosphere import Weather
from pelagos.optics.phase import sample_henyey_greenstein
from pelagos.optics.water import water_optics
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera import Camera, CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables


def light(water: str, *, floor: float, height: float, renderer: str, material: str = "white", sun_deg: float = 45.0,
          pitch_deg: float = 90.0, samples: int = 256) -> Any:  # fmt: skip
    """Mean light `(3,)` [cd/m^2] of a small picture from `height` over a plate at depth `floor`."""
    z = -floor
    corners = np.array([[-300, -300, z], [300, -300, z], [300, 300, z], [-300, 300, z]], dtype=float)
    plate = Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)
    materials = [MATERIALS[material]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean: Any = SimpleNamespace(
        water=water_optics(water),
        sun_elevation=jit.Float(math.radians(sun_deg)),
        air=SimpleNamespace(blows=False),
        sun_azimuth=jit.Float(2.8),
        waves=None,
        tide=None,
        tracers={},
        weather=Weather(),
    )
    scene = Scene([plate], copies=1)
    context = SensorContext("auv0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))
    config = CameraConfig(
        width_px=32, height_px=32, horizontal_fov_deg=20, vignette=0.0, ripple=0.0, exposure="manual",
        max_range_m=400.0, renderer=renderer, samples=samples if renderer == "reference" else 1,
    )  # fmt: skip
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    half = math.radians(pitch_deg) / 2
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero + z + height),
        jit.Array4f64(zero + math.cos(half), zero, zero + math.sin(half), zero),
        none, none, none, none, jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    dr.eval(motion)
    found = {name: values for name, values, _ in Camera(config, context).explain(motion)}
    return found["light at the sensor"].mean(axis=1)


@pytest.mark.parametrize(("water", "tolerance"), [("I", 0.08), ("1C", 0.15)])
def test_path_tracing_finds_the_attenuation_of_the_tables(water: str, tolerance: float):
    """Kd between 2 and 6 m with the sun overhead: inherent properties alone give back Jerlov's apparent one.

    Kirk's equation, which links them, fits Monte Carlo to 5 %, and a tenth of the light is sky, whose way is 1.2.
    """
    shallow, deep = (
        light(water, floor=z, height=0.1, renderer="reference", material="black", sun_deg=89) for z in (2, 6)
    )
    kd = np.log(shallow / deep) / 4
    assert kd == pytest.approx(np.array(water_optics(water).downwelling), rel=tolerance, abs=0.003)


@pytest.mark.parametrize("height", [0.1, 3.0])
@pytest.mark.parametrize("water", ["I", "1C"])
def test_plates_are_as_bright_as_path_tracing_says(water: str, height: float):
    """12 %; light that goes back and forth between sand (albedo 0.2 to 0.36) and surface is left out."""
    here: dict[str, Any] = {"floor": 8.0, "height": height, "material": "sand"}
    reference, realtime = (light(water, renderer=r, **here) for r in ("reference", "realtime"))
    assert realtime == pytest.approx(reference, rel=0.12)


def test_open_water_is_as_bright_as_path_tracing_says():
    """15 % for a level view 6 m deep in coastal water; the noise of 1024 x 1024 paths is 3 %."""
    here: dict[str, Any] = {"floor": 100.0, "height": 94.0, "pitch_deg": 0.0}
    reference = light("1C", renderer="reference", samples=1024, **here)
    realtime = light("1C", renderer="realtime", **here)
    assert realtime[1:] == pytest.approx(reference[1:], rel=0.15)


def test_sampling_follows_the_phase_function():
    """The mean cosine of samples is g."""
    u = (np.arange(100_000) + 0.5) / 100_000
    assert np.array(sample_henyey_greenstein(jit.Float64(u), 0.924)).mean() == pytest.approx(0.924, abs=1e-4)
