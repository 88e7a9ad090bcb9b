"""Fog and rain between the eye and what it sees, by hand; and what they leave of the sun."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.atmosphere import (
    Weather,
    airlight,
    fog_extinction,
    rain_extinction,
    through_air,
    under_weather,
    way_to_sky,
)
from pelagos.optics.sun_position import refraction
from pelagos.optics.sunlight import Daylight

NOON = Daylight(towards_sun=(0.3, -0.4, math.sqrt(0.75)), sun=(50e3, 60e3, 70e3), sky=(9e3, 12e3, 17e3), cover=0.2)


@pytest.mark.parametrize("height", [math.sqrt(0.75), 0.02, -0.1])
def test_weather_takes_from_the_beam_and_gives_to_the_sky(height: float) -> None:
    """Through 120 m of fog and 2 km of rain, not more aslant than 1 in 20; 80 % of what the beam loses arrives."""
    light = replace(NOON, towards_sun=(0.3, -0.4, height))
    found = under_weather(light, Weather(visibility=700.0, rain=4.0))
    depth = 120 * math.log(20) / 700 + 2000 * 1.076 * 4**0.67 * math.log(10) / 1e4
    kept = math.exp(-depth / max(height, 0.05))
    assert found.sun == pytest.approx([kept * s for s in light.sun], rel=1e-9)
    more = [0.8 * s * (1 - kept) * max(height, 0.0) for s in light.sun]
    assert found.sky == pytest.approx(np.add(light.sky, more), rel=1e-9)
    assert found.cover == pytest.approx(1 - 0.8 * math.exp(-depth), rel=1e-9)
    assert found.towards_sun == light.towards_sun


def test_fog_lies_lower_than_rain() -> None:
    """Optical thickness to the sky: 120 m of fog and 2 km of rain over the sine, at most 20 km of rain."""
    air = Weather(visibility=900.0, rain=6.0).air()
    fog, rain = fog_extinction(900.0), rain_extinction(6.0)
    rise = np.array([1.0, 0.5, 0.05, 1e-5, -0.3])
    expected = [fog * 120 / max(r, 1e-3) + rain * min(2000 / max(r, 1e-3), 20_000) for r in rise]
    assert np.array(way_to_sky(air, jit.Float(rise))) == pytest.approx(expected, rel=1e-5)
    assert np.array(air.drops)[0] == 6.0
    assert Weather(visibility=900.0).air().drops is None
    assert [Weather(*w).clear for w in ((0.5,), (0.0, 900.0), (0.0, math.inf, 0.1))] == [True, False, False]


def test_the_light_of_fog_takes_the_place_of_what_is_behind_it() -> None:
    """1/pi of what falls on level ground, of a sun that is up; e^-tau of the light behind is left."""
    sun, sky = jit.Array3f(*NOON.sun), jit.Array3f(*NOON.sky)
    for height in (0.6, -0.2):
        found = np.array(airlight(sun, sky, jit.Array3f(0.8, 0.0, height))).ravel()
        expected = (np.array(NOON.sun) * max(height, 0.0) + NOON.sky) / math.pi
        assert found == pytest.approx(expected, rel=1e-5)
    seen = through_air(jit.Array3f(7.0, 2.0, 1.0), jit.Float(1.3), jit.Array3f(3.0, 4.0, 5.0))
    left = math.exp(-1.3)
    assert np.array(seen).ravel() == pytest.approx([3 + 4 * left, 4 - 2 * left, 5 - 4 * left], rel=1e-5)


@pytest.mark.parametrize(("degrees", "minutes"), [(0.0, 33.8), (10.0, 5.3), (45.0, 0.98), (-0.5, 39.8), (-0.6, 0.0)])
def test_the_air_lifts_the_sun(degrees: float, minutes: float) -> None:
    """Bennett's 1 / tan(h + 7.31 / (h + 4.4)) minutes (J. Navigation 35:255, 1982), to 4 %, high up to a quarter;
    none of a sun that is down."""
    assert math.degrees(refraction(math.radians(degrees))) * 60 == pytest.approx(minutes, rel=0.04, abs=0.25)
