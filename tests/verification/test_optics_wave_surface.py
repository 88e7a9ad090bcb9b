"""The sea surface that cameras see is that of the forces: rays end on `Ocean.elevation`."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.swell import REACH, Swell, swell_around, swell_slope
from pelagos.optics.wave_surface import way_to_surface

T = 4.0


def sea(**waves: object) -> object:
    return build_ocean(OceanConfig.model_validate({"waves": waves}), seed=4)


def grid(ocean: object, place: np.ndarray) -> Swell:
    position = jit.Array3f64(*(jit.Float64([float(v)]) for v in place))
    return swell_around(ocean.elevation, position, jit.Float64([T]), 1)  # type: ignore[attr-defined]


def ways(swell: Swell, place: np.ndarray, directions: np.ndarray) -> np.ndarray:
    n = len(directions)
    origin = jit.Array3f64(*(jit.Float64(np.full(n, v)) for v in place))
    d = jit.Array3f(*(jit.Float(np.ascontiguousarray(c, dtype=np.float32)) for c in directions.T))
    lane = dr.zeros(jit.UInt32, n)
    found = jit.freeze(lambda s, o, v, k: way_to_surface(s, o, v, k))(swell, origin, d, lane)
    return np.array(found)


def fan(rng: np.random.Generator, count: int, low_deg: float, high_deg: float) -> np.ndarray:
    azimuth, slope = rng.uniform(0, 2 * np.pi, count), np.radians(rng.uniform(low_deg, high_deg, count))
    return np.stack([np.cos(slope) * np.cos(azimuth), np.cos(slope) * np.sin(azimuth), np.sin(slope)], axis=-1)


@pytest.mark.parametrize(("state", "within"), [(2, 0.02), (4, 0.06), (6, 0.06)])
@pytest.mark.parametrize("height", [3.0, -2.0])
def test_rays_end_on_the_surface_of_the_forces(state: int, within: float, height: float) -> None:
    """Linear between nodes 1.5 m apart: a k^2 h^2 / 8 summed over the components, a few centimetres."""
    ocean = sea(type="sea_state", state=state, towards_deg=60)
    x, y = 30.0, -12.0
    level = float(np.array(ocean.elevation(jit.Float64(x), jit.Float64(y), jit.Float64(T)))[0])  # type: ignore[attr-defined]
    place = np.array([x, y, level + height])
    directions = fan(np.random.default_rng(1), 400, -60.0, -12.0) * [1, 1, np.sign(height)]
    t = ways(grid(ocean, place), place, directions)
    ends = place + t[:, None] * directions
    near = np.hypot(*(ends - place)[:, :2].T) < 19.0
    assert near.sum() > 300
    surface = np.array(ocean.elevation(jit.Float64(ends[near, 0]), jit.Float64(ends[near, 1]), jit.Float64(T)))  # type: ignore[attr-defined]
    assert np.abs(ends[near, 2] - surface).max() < within


def test_the_first_crest_hides_what_is_behind() -> None:
    """Every ray is above the surface all the way to its end."""
    ocean = sea(type="regular", height_m=2.0, period_s=3.5)
    place = np.array([0.0, 0.0, 2.0])
    directions = fan(np.random.default_rng(2), 200, -15.0, -4.0)
    t = ways(grid(ocean, place), place, directions)
    inside = t < 20.0
    for share in np.linspace(0.02, 0.97, 40):
        at = place + (share * t[:, None] * directions)[inside]
        surface = np.array(ocean.elevation(jit.Float64(at[:, 0]), jit.Float64(at[:, 1]), jit.Float64(T)))  # type: ignore[attr-defined]
        assert (at[:, 2] - surface).min() > -0.06


def test_far_away_there_is_the_level_sea_and_the_sky_has_none() -> None:
    ocean = sea(type="sea_state", state=4)
    place = np.array([0.0, 0.0, 40.0])
    swell = grid(ocean, place)
    down, up = np.array([[np.cos(0.06), 0.0, -np.sin(0.06)]]), np.array([[np.cos(0.1), 0.0, np.sin(0.1)]])
    mean = float(np.array(swell.mean)[0])
    assert ways(swell, place, down)[0] == pytest.approx((40.0 - mean) / np.sin(0.06), rel=1e-3)
    assert ways(swell, place, down)[0] > REACH
    assert ways(swell, place, up)[0] >= 1e4


def test_swell_is_seen_far_out_and_its_slope_is_the_seas() -> None:
    """150 m long waves: linear between nodes 24 m apart, a (k h)^2 / 8 = 0.13 a at most; slopes a k (k h) / 2 off."""
    ocean = sea(type="regular", height_m=4.0, period_s=9.8)
    place = np.array([0.0, 0.0, 25.0])
    swell = grid(ocean, place)
    directions = fan(np.random.default_rng(5), 300, -14.0, -5.0)
    t = ways(swell, place, directions)
    ends = place + t[:, None] * directions
    assert np.hypot(*ends[:, :2].T).max() > 200
    surface = np.array(ocean.elevation(jit.Float64(ends[:, 0]), jit.Float64(ends[:, 1]), jit.Float64(T)))  # type: ignore[attr-defined]
    assert np.abs(ends[:, 2] - surface).max() < 0.15 * 2.0
    x, y = (jit.Float(np.ascontiguousarray(ends[:, i], dtype=np.float32)) for i in (0, 1))
    found = np.array(swell_slope(swell, x, y, dr.zeros(jit.UInt32, 300))).T
    true = np.array(ocean.waves.slope(jit.Float64(ends[:, 0]), jit.Float64(ends[:, 1]), jit.Float64(T)))  # type: ignore[attr-defined]
    k = (2 * np.pi / 9.8) ** 2 / 9.81
    assert np.abs(found - np.squeeze(true).T).max() < 2.0 * k * (0.5 * k * 24 + 0.1)


def test_a_flat_sea_is_a_plane() -> None:
    ocean = sea(type="regular", height_m=1e-6, period_s=6.0)
    place = np.array([5.0, 5.0, 3.0])
    directions = fan(np.random.default_rng(3), 100, -80.0, -5.0)
    assert ways(grid(ocean, place), place, directions) == pytest.approx(-3.0 / directions[:, 2], rel=1e-4)
