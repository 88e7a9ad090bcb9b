"""Strips of surface that rays stand for: their span of ranges, their bins, and what of them lies in a bin."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.acoustics.beamforming import energy_weights, form_beams, spread_pulse, steer_widely
from pelagos.acoustics.echo import strip_span, widened
from pelagos.acoustics.echo_strips import BLEND, covered, strips_of
from pelagos.acoustics.echo_walk import pitch


def device(rows: np.ndarray) -> Any:
    return jit.Array3f(np.ascontiguousarray(np.asarray(rows).T, np.float32))


def scene(count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Rays that meet planes from before, at any slant but grazing: direction, along, normal, distance."""
    rng = np.random.default_rng(seed)
    way, along, normal = rng.normal(size=(3, count, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    along -= (along * way).sum(axis=1, keepdims=True) * way
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = -way + 0.5 * normal
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    keep = (normal * way).sum(axis=1) < -0.4
    return way[keep], along[keep], normal[keep], rng.uniform(5.0, 60.0, keep.sum())


def met(way: np.ndarray, normal: np.ndarray, distance: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Range at which another direction meets the plane of the first."""
    return distance * (normal * way).sum(axis=1) / (normal * other).sum(axis=1)


def test_a_strip_reaches_from_where_its_lower_edge_meets_the_plane_to_where_its_upper_does() -> None:
    """Rays at the middle of their beams; strips of 4 mrad to 0.2 rad, unequal to both sides; and points along them."""
    way, along, normal, distance = scene(60, 1)
    rng = np.random.default_rng(2)
    lower, upper = -rng.uniform(0.002, 0.1, len(way)), rng.uniform(0.002, 0.1, len(way))
    near, far, slide = strip_span(
        jit.Float(distance), device(way), device(normal), device(along), device(0 * way),
        jit.Float(lower), jit.Float(upper), jit.Float(1e3),
    )  # fmt: skip
    edges = [met(way, normal, distance, way * np.cos(a)[:, None] + along * np.sin(a)[:, None]) for a in (lower, upper)]
    assert np.array(near) == pytest.approx(np.minimum(*edges), rel=1e-4)
    assert np.array(far) == pytest.approx(np.maximum(*edges), rel=1e-4)
    tilt = (normal * along).sum(axis=1)
    slanted = np.abs(tilt) > 0.05
    moved = np.array(slide).T[slanted]
    assert np.abs((moved * normal[slanted]).sum(axis=1)) == pytest.approx(0.0, abs=2e-5)  # within the plane
    assert (moved * way[slanted]).sum(axis=1) == pytest.approx(1.0, abs=1e-5)  # a metre of range each


def test_no_strip_is_longer_than_it_may_be_and_rays_aside_are_moved_to_the_middle() -> None:
    way, along, normal, distance = scene(60, 3)
    aside = 0.002 * np.random.default_rng(4).normal(size=way.shape)
    aside -= (aside * way).sum(axis=1, keepdims=True) * way
    args = jit.Float(distance), device(way), device(normal), device(along)
    edges = jit.Float(-0.05), jit.Float(0.08)
    long = [np.array(v) for v in strip_span(*args, device(0 * way), *edges, jit.Float(1e3))[:2]]
    short = [np.array(v) for v in strip_span(*args, device(0 * way), *edges, jit.Float(0.5))[:2]]
    assert short[0] == pytest.approx(np.maximum(long[0], distance - 0.5), rel=1e-5)
    assert short[1] == pytest.approx(np.minimum(long[1], distance + 0.5), rel=1e-5)
    moved = [np.array(v) for v in strip_span(*args, device(aside), *edges, jit.Float(1e3))[:2]]
    shift = met(way, normal, distance, way + aside) - distance
    limit = 0.5 * (long[1] - long[0])
    for before, after in zip(long, moved, strict=True):
        assert after - before == pytest.approx(np.clip(shift, -limit, limit), abs=1e-3)
    thin = [
        np.array(v) for v in strip_span(*args, device(aside), jit.Float(-4e-4), jit.Float(6e-4), jit.Float(1e3))[:2]
    ]
    still = [
        np.array(v) for v in strip_span(*args, device(0 * way), jit.Float(-4e-4), jit.Float(6e-4), jit.Float(1e3))[:2]
    ]
    limit = 0.5 * (still[1] - still[0]) * 5.0  # of a stratum of 5 mrad
    assert thin[0] - still[0] == pytest.approx(np.clip(shift, -limit, limit), abs=1e-3)


def test_a_strip_is_wider_by_what_its_sides_see() -> None:
    """Ranges at half an angle to both sides, to first order; and no more than it may."""
    way, along, normal, distance = scene(60, 5)
    across, half = np.cross(way, along), 0.004
    args = device(way), device(normal), device(along), jit.Float(half)
    near, far = (
        np.array(v)
        for v in widened(jit.Float(distance), jit.Float(distance), jit.Float(distance), *args, jit.Float(1e3))
    )
    sides = [met(way, normal, distance, way + s * half * across) for s in (1, -1)]
    reach = 0.5 * np.abs(sides[0] - sides[1])
    assert far - distance == pytest.approx(reach, rel=0.02, abs=2e-5 * 60)
    assert distance - near == pytest.approx(far - distance, abs=2e-5)
    near, far = (
        np.array(v)
        for v in widened(jit.Float(distance - 1), jit.Float(distance + 2), jit.Float(distance), *args, jit.Float(0.05))
    )
    assert near == pytest.approx(distance - 1 - np.minimum(reach, 0.05), abs=2e-3)
    assert far == pytest.approx(distance + 2 + np.minimum(reach, 0.05), abs=2e-3)


def test_a_strips_energy_is_spread_evenly_over_its_bins() -> None:
    """Within a ramp of 4 % of its length at both ends; by bins of 0.2 m from 3 m on; per share near far."""
    near, far = np.array([3.5, 4.01, 2.0, 20.0, 10.0, 5.0]), np.array([9.5, 4.05, 3.1, 30.0, 22.0, 6.0])
    valid = np.array([True, True, True, True, True, False])
    energy = np.arange(6.0) + 0.5
    patches: Any = SimpleNamespace(
        near=jit.Float(near), far=jit.Float(far), energy=jit.Float(energy), valid=jit.Bool(valid)
    )
    strips = strips_of(patches, bins=60, first_range=3.0, bin_width=0.2)
    length, begin, share = (np.array(v) for v in (strips.length, strips.begin, strips.share))
    heard = valid & (near < 15.0)
    bins = (far - near) / 0.2
    assert length == pytest.approx(np.where(heard, bins, 0.0), rel=1e-3)
    low = (near - 3.0) / 0.2
    assert begin == pytest.approx(low - BLEND * bins, abs=1e-3)
    assert np.array(strips.end)[heard] == pytest.approx((low + (1 + BLEND) * bins)[heard], abs=1e-3)
    assert share == pytest.approx(np.where(valid, energy * near * far * 2 * BLEND, 0.0), rel=1e-3)
    x = np.linspace(-3.0, 40.0, 300)
    grid = np.linspace(-10.0, x, 4001)
    for k in (0, 2):
        blend = 2 * BLEND * bins[k]
        found = covered(jit.Float(x), jit.Float(begin[k]), jit.Float(1.0 / blend))
        rises = [np.clip((grid - edge) / blend + 0.5, 0.0, 1.0) for edge in (low[k], low[k] + bins[k])]
        expected = trapezoid(rises[0] - rises[1], grid, axis=0) / blend
        assert np.array(found) == pytest.approx(expected, abs=2e-2)


def cells(values: np.ndarray) -> Any:
    """`(rows, bins)` or with a last axis of 2, rows `pitch` apart; between them what nobody may read."""
    rows, bins = values.shape[:2]
    padded = np.full((rows, pitch(bins), *values.shape[2:]), 1e6)
    padded[:, :bins] = values
    return jit.Float(padded.ravel())


@pytest.mark.parametrize("channels", [1, 2])
def test_a_pulse_is_a_convolution_along_each_row(channels: int) -> None:
    rng = np.random.default_rng(1)
    values, pulse = rng.normal(size=(3, 20, channels)), np.array([0.2, 0.9, -0.3])
    echoes = cells(values[..., 0] if channels == 1 else values)
    found = np.array(spread_pulse(echoes, jit.Float(pulse), channels=channels, bins=20)).reshape(3, pitch(20), channels)
    padded = np.pad(values, ((0, 0), (1, 1), (0, 0)))
    expected = sum(pulse[k] * padded[:, k : k + 20] for k in range(3))
    assert found[:, :20] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("squared", [False, True])
def test_every_beam_of_a_whole_array_hears_every_sector(squared: bool) -> None:
    """Two pings of eleven beams: more than a lane's block of eight."""
    rng = np.random.default_rng(2)
    channels = 1 if squared else 2
    values = rng.uniform(-1, 1, size=(2, 11, 9, channels))
    steering = rng.normal(size=(11, 21))
    echoes = cells(values.reshape(22, 9, channels)[..., 0] if channels == 1 else values.reshape(22, 9, 2))
    found = steer_widely(echoes, jit.Float(steering.ravel()), channels=channels, beams=11, bins=9, squared=squared)
    heard = np.array(found).reshape(2, 11, pitch(9), channels)[:, :, :9]
    weight = np.array([[steering[b, 10 + s - b] for s in range(11)] for b in range(11)]) ** (2 if squared else 1)
    assert heard == pytest.approx(np.einsum("bs,psrc->pbrc", weight, values), abs=1e-4)


def test_beams_are_formed_of_their_neighbours_where_they_were_when_the_sound_went_out() -> None:
    """Sectors `shift` beams aside; none beyond the fan's ends, nor outside of the image."""
    rng = np.random.default_rng(3)
    values, weights = rng.normal(size=(2, 7, 10)), rng.normal(size=(2, 3))
    for ping, first, shift, bin_ in ((1, 2, 1, 4), (0, 0, 0, 9), (1, 5, -1, 0), (0, 3, 0, 10), (0, 3, 0, -1)):
        found = form_beams(
            cells(values.reshape(14, 10)), [[jit.Float(w) for w in row] for row in weights], jit.Int32(first),
            jit.Int32(shift), jit.Int32(ping * 7), jit.Int32(bin_), channels=1, beams=7, bins=10,
        )  # fmt: skip
        for i in range(2):
            expected = 0.0
            for k in range(3):
                sector = first + i + k - 1 - shift
                if 0 <= sector < 7 and 0 <= bin_ < 10:
                    expected += weights[i, k] * values[ping, sector, bin_]
            assert float(found[i][0][0]) == pytest.approx(expected, abs=1e-5)


def test_energies_of_neighbours_add_up_to_one() -> None:
    amplitudes = [[jit.Float(a) for a in (0.1, -0.4, 0.9, 0.3, 0.2)]]
    found = [float(w[0]) for w in energy_weights(amplitudes, 1)[0]]
    assert found == pytest.approx(np.array([0.16, 0.81, 0.09]) / 1.06)
    assert math.fsum(found) == pytest.approx(1.0)
