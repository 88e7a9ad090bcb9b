"""Steps of a path that is followed backwards from its pixel: flights, the sea's surface, the sun's beam."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.sensors.camera.picture import path_tracing

ABSORPTION, SCATTERING = np.array([0.5, 0.11, 0.2]), np.array([0.15, 0.4, 0.33])
SIDE = 150
U, V = ((v.ravel() + 0.5) / SIDE for v in np.mgrid[0:SIDE, 0:SIDE])


def scenery(**keys: Any) -> Any:
    water = SimpleNamespace(
        attenuation=jit.Array3f((ABSORPTION + SCATTERING).tolist()), scattering=jit.Array3f(SCATTERING.tolist())
    )
    return SimpleNamespace(water=water, tide=None, **keys)


def path_of(height: float, direction: Any, n: int) -> Any:
    zero = dr.zeros(jit.Float64, n)
    d = np.asarray(direction) / np.linalg.norm(direction)
    return SimpleNamespace(
        origin=jit.Array3f64(zero + 4.0, zero - 7.0, zero + height),
        direction=jit.Array3f(np.tile(d[:, None], n).astype(np.float32)),
        alive=dr.full(jit.Bool, True, n), straight=jit.Bool(np.arange(n) % 2 == 0),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("direction", "hit", "way"),
    [
        ((0.6, 0.0, -0.8), 3.0, 3.0), ((0.0, 0.6, 0.8), math.inf, 2.5), ((0.0, 0.6, 0.8), 1.2, 1.2),
        ((0.0, 0.6, 0.8), 4.0, 2.5),
    ],
)  # fmt: skip
def test_a_flight_scatters_as_much_light_as_the_water_does(direction: Any, hit: float, way: float) -> None:
    """Mean over even draws, by channel: b/c (1 - e^-cL) is scattered on the way L from 2 m deep, e^-cL gets through."""
    n, c = SIDE * SIDE, ABSORPTION + SCATTERING
    path = path_of(-2.0, direction, n)
    hits: Any = SimpleNamespace(valid=dr.full(jit.Bool, math.isfinite(hit), n), t=dr.full(jit.Float, hit, n))
    found = path_tracing._flight(scenery(), path, hits, [jit.Float(U), jit.Float(V)])
    dr.eval(found)
    weight, scatters = np.array(found.weight), np.array(found.scatters)
    assert (weight * scatters).mean(axis=1) == pytest.approx(SCATTERING / c * (1 - np.exp(-c * way)), rel=0.01)
    assert (weight * ~scatters).mean(axis=1) == pytest.approx(np.exp(-c * way), rel=0.01)
    assert np.array_equal(np.array(found.solid), ~scatters & (hit <= way))
    assert np.array_equal(np.array(found.surface), ~scatters & (hit > way))
    flown = np.array(found.way)
    np.testing.assert_allclose(flown[~scatters], way, rtol=1e-4)
    assert (flown[scatters] < way).all()
    unit = np.asarray(direction) / np.linalg.norm(direction)
    start = np.array([4.0, -7.0, -2.0])
    np.testing.assert_allclose(np.array(found.place).T, start + flown[:, None] * unit, atol=1e-5)


def test_air_scatters_nothing() -> None:
    path = path_of(3.0, (0.0, 0.8, -0.6), 50)
    for hit, solid in ((4.0, True), (6.0, False)):
        hits: Any = SimpleNamespace(valid=dr.full(jit.Bool, True, 50), t=dr.full(jit.Float, hit, 50))
        found = path_tracing._flight(scenery(), path, hits, [jit.Float(U[:50]), jit.Float(V[:50])])
        assert np.array(found.weight) == pytest.approx(1.0)
        assert not np.array(found.scatters).any()
        assert np.array(found.solid).all() == solid
        assert np.array(found.surface).all() != solid
        assert np.array(found.way) == pytest.approx(min(hit, 5.0))
    hits = SimpleNamespace(valid=dr.full(jit.Bool, False, 50), t=dr.full(jit.Float, math.inf, 50))
    upwards = path_of(3.0, (0.0, 0.8, 0.6), 50)
    found = path_tracing._flight(scenery(), upwards, hits, [jit.Float(U[:50]), jit.Float(V[:50])])
    assert not (np.array(found.surface) | np.array(found.solid) | np.array(found.scatters)).any()  # it sees the sky


@pytest.mark.parametrize("tide", [None, 0.7])
@pytest.mark.parametrize(("depth", "rise"), [(2.0, 0.8), (2.0, 0.3), (-1.5, -0.35)])
def test_the_sea_mirrors_by_chance_what_fresnel_says(
    monkeypatch: pytest.MonkeyPatch, tide: float | None, depth: float, rise: float
) -> None:
    """Sines of the rays inside and outside are as 1 to n; radiance grows by n^2 from air to water. What goes on starts
    on its own side of the surface; of what leaves the water the sky is asked for, with the sun's glare if nothing but
    the sea turned the path."""
    n, index = 1000, REFRACTIVE_INDEX
    level = tide or 0.0
    across = math.sqrt(1 - rise * rise)
    path = path_of(level - depth, (0.6 * across, -0.8 * across, rise), n)
    flight: Any = SimpleNamespace(
        surface=dr.full(jit.Bool, True, n), scatters=dr.full(jit.Bool, False, n), solid=dr.full(jit.Bool, False, n),
        place=jit.Array3f64(dr.zeros(jit.Float64, n) + 9.0, 2.0, jit.Float64(level)),
    )  # fmt: skip
    monkeypatch.setattr(path_tracing, "sky_in_air", lambda _, d, glare: jit.Array3f(2.0 + d.x, 2.0 + d.z, 1.0 + glare))
    around = scenery()
    around.tide = None if tide is None else dr.full(jit.Float, tide, n)
    found = path_tracing._sea_surface(around, path, flight, jit.Float((np.arange(n) + 0.5) / n))
    dr.eval(found)
    wet = depth > 0
    eta = index if wet else 1 / index
    sine = across * eta
    if sine < 1:
        a, b = math.asin(across), math.asin(sine)
        s, p = math.sin(a - b) / math.sin(a + b), math.tan(a - b) / math.tan(a + b)
        share = 0.5 * (s * s + p * p)
        out = np.array([0.6 * sine, -0.8 * sine, math.copysign(math.sqrt(1 - sine * sine), rise)])
    else:
        share, out = 1.0, np.zeros(3)
    direction = np.array(found.direction)
    assert np.abs(direction[2] * rise < 0).mean() == pytest.approx(share, abs=2e-3)
    mirrored = direction[2] * rise < 0
    back = np.array([0.6 * across, -0.8 * across, -rise])
    assert direction[:, mirrored] == pytest.approx(np.tile(back[:, None], mirrored.sum()), abs=1e-5)
    assert direction[:, ~mirrored] == pytest.approx(np.tile(out[:, None], (~mirrored).sum()), abs=1e-5)
    goes_on, weight, light = (np.array(v) for v in (found.goes_on, found.weight, found.light))
    assert np.array_equal(goes_on, mirrored | (not wet))
    assert np.ravel(weight * np.ones(n)) == pytest.approx(np.where(mirrored | wet, 1.0, 1 / index**2))
    sky = np.stack([np.full(n, 2 + out[0]), np.full(n, 2 + out[2]), 1.0 + np.array(path.straight)])
    expected = np.where(~mirrored & wet, sky * index**2, 0.0)
    assert light == pytest.approx(expected, abs=2e-4)
    height = np.array(found.origin)[2]
    below = mirrored if wet else ~mirrored
    assert height == pytest.approx(level + np.where(below, -1e-4, 1e-4), abs=1e-6)


def test_what_meets_nothing_sees_the_sky_if_it_is_in_the_air(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(path_tracing, "sky_in_air", lambda _, d, glare: jit.Array3f(3.0, 4.0, 5.0 + glare))
    for height in (2.0, -2.0):
        path = path_of(height, (0.6, 0.0, 0.8), 4)
        no = dr.full(jit.Bool, False, 4)
        flight: Any = SimpleNamespace(surface=no, scatters=no, solid=no, place=jit.Array3f64(0.0, 0.0, 0.0))
        found = path_tracing._sea_surface(scenery(), path, flight, jit.Float([0.1, 0.4, 0.6, 0.9]))
        expected = [[3.0, 4.0, 6.0], [3.0, 4.0, 5.0]] * 2 if height > 0 else [[0.0] * 3] * 4
        assert pytest.approx(np.array(expected)) == np.array(found.light).T
        assert not np.array(found.goes_on).any()


def test_the_beam_is_refracted_and_lost_on_its_way_down(monkeypatch: pytest.MonkeyPatch) -> None:
    """Energy: irradiance across the beam, times its sine, is what the level surface lets through, times e^-c z / sine;
    in air it is the sun's own, and there is none of a sun that is down."""
    monkeypatch.setattr(path_tracing, "focusing", lambda waves, x, y, depth, below, lane: 1.0 + 0.01 * x)
    sun = np.array([9e4, 8e4, 7e4])
    for height in (0.8, -0.1):
        across = math.sqrt(1 - height * height)
        light = SimpleNamespace(
            sun=jit.Array3f(sun.tolist()), towards_sun=jit.Array3f(0.6 * across, -0.8 * across, height)
        )
        place = jit.Array3f64(jit.Float64([10.0, 30.0, -20.0]), 0.0, jit.Float64([-3.0, 2.0, -0.5]))
        towards, beam = path_tracing._sunbeam(scenery(light=light, waves=None), place, jit.UInt32([0, 0, 0]))
        if height < 0:
            assert not np.array(beam).any()
            continue
        sine = across / REFRACTIVE_INDEX
        below = math.sqrt(1 - sine * sine)
        a, b = math.asin(across), math.asin(sine)
        mirror = 0.5 * ((math.sin(a - b) / math.sin(a + b)) ** 2 + (math.tan(a - b) / math.tan(a + b)) ** 2)
        c = ABSORPTION + SCATTERING
        level = sun * (1 - mirror) * height / below
        expected = [level * np.exp(-c * z / below) * f for z, f in ((3.0, 1.1), (0.5, 0.8))]
        assert pytest.approx(np.array(expected), rel=1e-4) == np.array(beam)[:, [0, 2]].T
        assert np.array(beam)[:, 1] == pytest.approx(sun)
        assert np.array(towards)[:, 0] == pytest.approx([0.6 * sine, -0.8 * sine, below], abs=1e-5)
        assert np.array(towards)[:, 1] == pytest.approx([0.6 * across, -0.8 * across, height], abs=1e-5)
