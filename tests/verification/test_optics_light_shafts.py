"""Shafts of light against the integral that they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.caustics import focusing, ripple, waves_at
from pelagos.optics.light_field import light_field, pattern_left
from pelagos.optics.light_shafts import shaft_gain, shafts
from pelagos.optics.sunlight import daylight
from pelagos.optics.water import water_optics

MARKS = [0.12 * (1.08**k - 1) / 0.08 for k in (8, 16, 24, 32)]  # [m], sums of the steps
LIGHT = daylight(math.radians(60), 0.4)


def found(directions: np.ndarray, depth: float = 4.0, slope: float = 0.004) -> np.ndarray:
    """`(4, lines)` for lines of sight in `(lines, 3)`."""
    field = light_field(water_optics("IB"), LIGHT)
    waves = waves_at(ripple(slope), jit.Float64(2.0), jit.Array3f(*LIGHT.towards_sun), 1)
    n = len(directions)
    d = jit.Array3f(np.ascontiguousarray(directions.T))
    place = jit.Array2f(jit.Float(np.zeros(n)), jit.Float(np.zeros(n)))
    jitter = jit.Float((np.arange(n) % 9 + 0.5) / 9)
    return np.array(shafts(waves, field, place, jit.Float(np.full(n, depth)), d, jit.UInt32(np.zeros(n)), jitter))


def cone(angle_deg: float, count: int) -> np.ndarray:
    """Directions at an angle around the refracted sun, `(count, 3)`."""
    sun = np.array(light_field(water_optics("IB"), LIGHT).below).ravel()
    side = np.cross(sun, [0, 0, 1])
    side /= np.linalg.norm(side)
    other = np.cross(sun, side)
    turn = np.linspace(0, 2 * math.pi, count, endpoint=False)
    around = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other
    return math.cos(math.radians(angle_deg)) * sun + math.sin(math.radians(angle_deg)) * around


def test_shafts_are_the_integral_of_the_pattern_along_the_line():
    """Nine neighbours' mean against a fine sum of interpolated maps: cells of 6 cm and planes that are not interpolated
    are off by some hundredths where the pattern itself varies by a third; correlation 0.9."""
    lines = np.repeat(cone(10.0, 40), 9, axis=0)
    got = found(lines).reshape(4, 40, 9).mean(axis=2)
    field = light_field(water_optics("IB"), LIGHT)
    sun = np.array(field.below).ravel()
    waves = waves_at(ripple(0.004), jit.Float64(2.0), jit.Array3f(*LIGHT.towards_sun), 1)
    s = (np.arange(1600) + 0.5) * 0.01
    loss = float(np.array(field.loss).ravel()[1])
    for m in (1, 2):
        here = s[s < MARKS[m]]
        expected = []
        for d in cone(10.0, 40):
            depth = 4.0 - d[2] * here
            weight = np.where(depth > 0, np.exp(-loss * (1 - d[2] / sun[2]) * here), 0)
            below = jit.Float(np.maximum(depth, 0))
            focus = np.array(
                focusing(waves, jit.Float(d[0] * here), jit.Float(d[1] * here), below, field.below,
                         jit.UInt32(np.zeros(len(here))))
            )  # fmt: skip
            kept = np.array(pattern_left(field, below))
            expected.append((weight * kept * (focus - 1)).sum() / weight.sum())
        assert np.corrcoef(got[m], expected)[0, 1] > 0.9
        assert got[m].std() == pytest.approx(np.std(expected), rel=0.3)


def test_shafts_are_bright_towards_the_sun_and_average_out_across_its_rays():
    """Contrast falls with the angle from the sun: the line crosses more and more of the pattern."""
    near, aside, across = (found(cone(a, 400))[3].std() for a in (6.0, 20.0, 50.0))
    assert near > 1.2 * aside > 1.2 * 1.2 * across
    assert abs(found(cone(20.0, 400))[3].mean()) < 0.05


def test_a_calm_sea_has_none():
    assert np.abs(found(cone(10.0, 40), slope=0.0)).max() < 0.02


def test_gain_between_the_distances():
    kept = jit.Array4f(0.4, 0.2, -0.1, -2.0)
    assert np.array(shaft_gain(kept, jit.Float(0.0)))[0] == pytest.approx(1.4)
    for mark, value in zip(MARKS, (1.4, 1.2, 0.9, 0.0), strict=True):
        assert np.array(shaft_gain(kept, jit.Float(mark)))[0] == pytest.approx(value, abs=1e-4)
    assert np.array(shaft_gain(kept, jit.Float(1e4)))[0] == 0.0
