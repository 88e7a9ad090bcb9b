"""Foam in pictures: as much of the sea is white as the wind makes, and white is what a camera sees there."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.whitecaps import whitecap_share
from pelagos.optics.foam import foam_cover, foam_radiance
from pelagos.optics.swell import swell_around


@pytest.mark.parametrize("wind", [10.0, 14.0])
def test_pictures_are_as_white_as_the_sea(wind: float) -> None:
    """Monahan's share counts old foam too; lace and its age are drawn so that the mean is his within 50 %."""
    said = {"waves": {"type": "sea_state", "state": 6}, "wind": {"speed_mps": wind}}
    ocean, rng, n, k = build_ocean(OceanConfig.model_validate(said), seed=4), np.random.default_rng(1), 60, 1500
    p = rng.uniform(-3000, 3000, (2, n))
    place = jit.Array3f64(jit.Float64(p[0]), jit.Float64(p[1]), jit.Float64(np.zeros(n)))
    swell = swell_around(ocean.elevation, place, jit.Float64(np.full(n, 4.0)), n, ocean.waves.foam)
    lane = np.repeat(np.arange(n, dtype=np.uint32), k)
    x, y = (jit.Float((p[i][lane] + rng.uniform(-18, 18, n * k)).astype(np.float32)) for i in (0, 1))
    cover = np.array(foam_cover(swell, x, y, jit.UInt32(lane), jit.Float(0.01)))
    assert 0 <= cover.min() <= cover.max() <= 0.9
    assert cover.mean() == pytest.approx(whitecap_share(wind), rel=0.5)


def seen(**ocean: Any) -> np.ndarray:
    camera = {"type": "camera", "width_px": 160, "height_px": 120, "rate_hz": 1, "position_m": [0, 0, 4],
              "orientation_deg": [0, 25, 0]}  # fmt: skip
    start = {"position_m": [0.0, 0.0], "depth_m": 0.0}
    agent = {"vehicle": "wamv", "control": "actuators", "start": start, "sensors": {"eye": camera}}
    world = {"type": "flat", "depth_m": 60.0}
    sim = pl.Simulation.load({"seed": 4, "tick_rate_hz": 20, "world": world, "ocean": ocean, "agents": {"b": agent}})
    obs = sim.reset()
    return np.asarray(obs["b"]["eye"].data).reshape(120, 160, 3)[60:].astype(float)


def test_a_storm_is_white_and_a_light_air_is_not() -> None:
    waves = {"type": "sea_state", "state": 5}
    rough, calm = (seen(waves=waves, wind={"speed_mps": w}) for w in (22.0, 2.0))
    rough, calm = (picture[..., 0] for picture in (rough, calm))  # red: the sea has little of it
    assert np.mean(rough > 2.5 * np.median(rough)) > np.mean(calm > 2.5 * np.median(calm)) + 0.02


@pytest.mark.parametrize(("up", "lit"), [(0.6, 0.6), (-0.3, 0.0)])
def test_foam_sends_back_half_of_the_light_and_lets_a_quarter_through(up: float, lit: float) -> None:
    """A matt sheet of albedo A under E_sun cos + E_sky is A E / pi bright; Koepke's fresh foam has A = 0.5."""
    light: Any = SimpleNamespace(
        towards_sun=jit.Array3f(0.8, 0.0, up), sun=jit.Array3f(900.0, 700.0, 400.0), sky=jit.Array3f(90.0, 120.0, 150.0)
    )
    seen_from = np.array(foam_radiance(light, jit.Bool([False, True]))).T
    whole = lit * np.array([900.0, 700.0, 400.0]) + np.array([90.0, 120.0, 150.0])
    np.testing.assert_allclose(seen_from, [0.5 / math.pi * whole, 0.25 / math.pi * whole], rtol=1e-6)
