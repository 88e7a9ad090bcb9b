"""Daylight looked up in the water's tables: by depth, direction and kind of water, against NumPy, of uneven numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from pelagos import jit
from pelagos.optics.light_field import (
    Fall,
    LightField,
    Local,
    beam_at,
    calm_radiance,
    diffuse_irradiance,
    diffuse_radiance,
    diffuse_source,
    pattern_left,
    surface_radiance,
)
from pelagos.optics.light_tables import LEVELS, ROWS, SIDES, TERMS, UPS

RNG = np.random.default_rng(31)
N, KINDS = 40, 3
DEPTH = np.concatenate([[-1.0, 0.0, 500.0], RNG.uniform(0.05, 30.0, N - 3)])
D = RNG.normal(size=(N, 3))
D /= np.linalg.norm(D, axis=1, keepdims=True)
D[3], D[4] = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
SUN = np.array([0.3, -0.5, math.sqrt(0.66)])
BELOW = math.sqrt(1 - 0.34 / 1.34**2)
ROW = RNG.integers(0, KINDS, N)
RATE = {k: RNG.uniform(0.05, 0.4, (3, N)) for k in ("loss", "fading", "decay")}
EXCESS, CLEAR = RNG.uniform(-0.5, 1.5, (3, 3, N)), RNG.uniform(0.02, 0.06, (3, 3, N))
GAIN = RNG.uniform(0.5, 2.0, (3, 3, N))
BEAM, BLUR = np.array([7e4, 8e4, 9e4]), 0.13
RADIANCE, CALM, SOURCE = RNG.uniform(1, 5, (3, KINDS, LEVELS, UPS, SIDES, 4))
IRRADIANCE = RNG.uniform(-1, 3, (KINDS, ROWS, 3, TERMS))
IRRADIANCE[..., 0] += 9.0


def three(values: NDArray[np.float64]) -> Any:
    return jit.Array3f(np.ascontiguousarray(values, dtype=np.float32))


def field(*, local: bool, kinds: bool) -> LightField:
    falls = [Fall(three(e), three(c)) for e, c in zip(EXCESS, CLEAR, strict=True)]
    flat = (jit.Float(t.ravel().astype(np.float32)) for t in (IRRADIANCE, RADIANCE, CALM, SOURCE))
    return LightField(
        jit.Array3f(SUN.tolist()), jit.Array3f(*(SUN[:2] / 1.34).tolist(), BELOW), jit.Array3f(BEAM.tolist()),
        *(three(RATE[k]) for k in ("loss", "fading", "decay")), *flat, jit.Float(BLUR),
        local=Local(*falls, *(three(g) for g in GAIN)) if local else None,
        row=jit.UInt32(ROW.astype(np.uint32)) if kinds else None,
    )  # fmt: skip


def taken(k: int, name: str, *, local: bool) -> NDArray[np.float64]:
    """Optical depth: of a column that is clearer than the place, but nowhere than the clearest water."""
    plain = RATE[name] * DEPTH
    return np.maximum(plain - EXCESS[k], CLEAR[k] * DEPTH) if local else plain


def step(count: int) -> NDArray[np.float64]:
    """Levels lie at 0.1 (e^(B i) - 1) m, the last at 400 m."""
    return np.log1p(np.maximum(DEPTH, 0) / 0.1) / math.log1p(4000) * (count - 1)


@pytest.mark.parametrize(("local", "kinds"), [(False, False), (True, False), (False, True)])
def test_radiance_is_interpolated_by_depth_height_and_side(local: bool, kinds: bool) -> None:
    made, depth, d = field(local=local, kinds=kinds), jit.Float(DEPTH), three(D.T)
    side = np.arctan2(np.abs(D[:, 0] * SUN[1] - D[:, 1] * SUN[0]), D[:, 0] * SUN[0] + D[:, 1] * SUN[1]) / math.pi
    side[3:5] = 0.5  # straight up and down
    row = ROW if kinds else np.zeros(N, int)
    kept = np.exp(-taken(0, "decay", local=local))

    def seen(table: NDArray[np.float64], level: NDArray[np.float64]) -> NDArray[np.float64]:
        at = np.stack([np.minimum(level, LEVELS - 1), (D[:, 2] + 1) / 2 * (UPS - 1), side * (SIDES - 1)])
        return np.array([
            [map_coordinates(table[row[k], ..., c], at[:, k : k + 1], order=1, mode="nearest")[0] for k in range(N)]
            for c in range(3)
        ])  # fmt: skip

    gain = GAIN if local else np.ones((3, 3, N))  # of irradiance, source, radiance
    level = step(LEVELS)
    for found, expected in (
        (diffuse_radiance(made, depth, d), seen(RADIANCE, level) * kept * gain[2]),
        (calm_radiance(made, depth, d), seen(CALM, level) * kept * gain[2]),
        (diffuse_source(made, depth, d), seen(SOURCE, level) * kept * gain[1]),
    ):
        np.testing.assert_allclose(
            np.array(found), expected, rtol=6e-3, atol=1e-25
        )  # single precision of the angle, 400 m
    surface = seen(RADIANCE, 0 * level)
    if local:
        surface = surface * np.exp(-np.maximum(-EXCESS[0], 0)) * gain[2]
    np.testing.assert_allclose(np.array(surface_radiance(made, d)), surface, rtol=6e-3, atol=1e-25)


@pytest.mark.parametrize(("local", "kinds"), [(False, False), (True, False), (False, True)])
def test_irradiance_is_a_polynomial_of_the_normal(local: bool, kinds: bool) -> None:
    """1, x, z, x^2, z^2, x z and z^4, x towards the sun, of the nearest row; nowhere less than none."""
    made, depth = field(local=local, kinds=kinds), jit.Float(DEPTH)
    x, z = D[:, :2] @ SUN[:2] / math.hypot(*SUN[:2]), D[:, 2]
    terms = np.stack([np.ones(N), x, z, x * x, z * z, x * z, z**4], axis=-1)
    row = np.minimum(np.floor(step(ROWS) + 0.5), ROWS - 1).astype(int)
    table = IRRADIANCE[ROW if kinds else 0, row][..., :7]
    light = np.maximum((table * terms[:, None]).sum(axis=-1), 0).T
    expected = light * np.exp(-taken(0, "decay", local=local)) * (GAIN[0] if local else 1)
    np.testing.assert_allclose(np.array(diffuse_irradiance(made, depth, three(D.T))), expected, rtol=1e-3, atol=1e-25)


@pytest.mark.parametrize("local", [False, True])
def test_the_beam_goes_aslant(local: bool) -> None:
    made, depth = field(local=local, kinds=False), jit.Float(DEPTH)
    expected = BEAM[:, None] * np.exp(-taken(1, "loss", local=local) / BELOW)
    np.testing.assert_allclose(np.array(beam_at(made, depth)), expected, rtol=1e-4, atol=1e-25)
    np.testing.assert_allclose(np.array(pattern_left(made, depth)), np.exp(-BLUR * DEPTH), rtol=1e-4, atol=1e-25)
