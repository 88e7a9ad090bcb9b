"""Levels of a picture step by step: converter, ringing, gain, scale, painted noise, bounces, surfaces, water."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.sea_surface import bubble_loss_db, surface_backscatter
from pelagos.acoustics.target_strength import corner, facets, lambert
from pelagos.sensors.sonar.ping.cells import Cells, Constants, cells_at
from pelagos.sensors.sonar.ping.levels import apply_spreading, quantise, ringing, to_scale
from pelagos.sensors.sonar.ping.medium import highest, lowest, medium_of
from pelagos.sensors.sonar.ping.multipath import _reflected
from pelagos.sensors.sonar.ping.painted_noise import paint, paint_streaks, speckled, streak_rows
from pelagos.sensors.sonar.ping.ping_spec import Display, Painting
from pelagos.sensors.sonar.ping.sea_surface import SEA_SURFACE_INSTANCE
from pelagos.sensors.sonar.ping.surface_scattering import (
    mirror_share,
    mirror_table,
    scattering,
    scattering_table,
    surfaces,
)
from pelagos.world.material import MATERIALS

DISTANCE = np.linspace(0.3, 40.0, 9)


def spec(**more: Any) -> Any:
    keys: dict[str, Any] = {
        "source_level_db": 206.0,
        "converter": (5, 150.0),
        "ringing": (160.0, 25.0),
        "display": Display(),
    }
    return SimpleNamespace(**(keys | more))


def cells(ping: int = 0) -> Any:
    return SimpleNamespace(distance=jit.Float(DISTANCE), ping=jit.Int32(np.full(9, ping)))


def test_a_converter_has_whole_steps_from_least_to_most() -> None:
    """Of 5 bits: -16 to 15 steps of 10^((150 - 206)/20)/15 before a gain."""
    step = 10.0 ** (-56 / 20) / 15
    part = np.array([0.4, 0.6, -1.7, 15.4, 40.0, -15.6, -90.0]) * step
    for gain in (1.0, 7.3):
        found = np.array(quantise(spec(), jit.Float(part * math.sqrt(gain)), jit.Float(gain)))
        assert found / (step * math.sqrt(gain)) == pytest.approx([0, 1, -2, 15, 15, -16, -16], abs=1e-3)


def test_ringing_fades_from_the_end_of_the_pulse_on() -> None:
    """160 dB less 25 dB a millisecond of 2 r/c, re 206 dB; in the second lane's water."""
    medium: Any = SimpleNamespace(sound_speed=jit.Float([1450.0, 1550.0]))
    for ping, c in enumerate((1450.0, 1550.0)):
        found = np.array(ringing(spec(), cells(ping), medium))
        assert found == pytest.approx(10 ** ((160.0 - 206.0 - 25.0 * 2e3 * DISTANCE / c) / 10), rel=2e-3, abs=1e-37)


@pytest.mark.parametrize("tvg", [20.0, 30.0, 40.0])
def test_another_spreading_of_the_gain_tilts_levels_by_range(tvg: float) -> None:
    found = np.array(apply_spreading(spec(display=Display(tvg_db=tvg)), jit.Float(np.full(9, 0.7)), cells()))
    assert 10 * np.log10(found) == pytest.approx(10 * math.log10(0.7) + (tvg - 30.0) * np.log10(DISTANCE), abs=1e-3)


def test_scales_are_of_one_level() -> None:
    """Of -60 to -15 dB between 0 and 1; nothing is -200 dB."""
    level = np.array([-75.0, -60.0, -33.0, -15.0, 4.0])
    power = jit.Float(10 ** (level / 10))
    of = lambda scale: np.array(to_scale(spec(display=Display(30.0, scale, -60.0, 45.0)), power))
    assert of("linear") == pytest.approx(10 ** (level / 10), rel=1e-5)
    assert of("db") == pytest.approx(level, abs=1e-3)
    assert of("unit") == pytest.approx([0.0, 0.0, 0.6, 1.0, 1.0], abs=1e-5)
    assert float(to_scale(spec(display=Display(scale="db")), jit.Float(0.0))[0]) == pytest.approx(-200.0, abs=1e-2)
    display = Display(30.0, "unit", -60.0, 45.0)
    assert display.decibels(np.array([0.6], np.float32)) == pytest.approx([-33.0])
    assert replace(display, scale="linear").decibels(np.array([1e-3, 0.0], np.float32)) == pytest.approx(
        [-30.0, -200.0]
    )


def test_cells_have_the_gain_of_their_range_over_what_a_sample_hears() -> None:
    """30 log r + 2 a r of each ping's water over the cell's size times its beam's share."""
    medium: Any = SimpleNamespace(absorption=jit.Float([0.05, 0.2]))
    some: Any = dict.fromkeys(("steering", "pulse", "noise", "seed", "order", "facing", "boost"))
    constants = Constants(**some, cell=jit.Float(0.004), heard=jit.Float([0.8, 1.5, 2.0]))
    made: Any = SimpleNamespace(range_min_m=2.0, bin_width_m=0.25)
    bin_, beam, ping = np.array([0, 7, 90]), np.array([2, 0, 9]), np.array([0, 1, 1])
    found: Cells = cells_at(made, medium, constants, jit.Int32(ping), jit.Int32(beam), jit.Int32(bin_))
    r = 2.0 + (bin_ + 0.5) * 0.25
    raised = r**3 * 10 ** (2 * np.array([0.05, 0.2, 0.2]) * r / 10)
    assert np.array(found.distance) == pytest.approx(r)
    assert np.array(found.raised) == pytest.approx(raised, rel=1e-4)
    heard = np.array([2.0, 0.8, 2.0])  # beams beyond the last are worth nothing, and read the last one's
    assert np.array(found.heard) == pytest.approx(heard)
    assert np.array(found.gain) == pytest.approx(raised / (0.004 * heard), rel=1e-4)


def painting(**more: Any) -> Painting:
    keys: dict[str, Any] = {"additive": 0.3, "additive_reference_db": -20.0, "multiplicative": 0.25, "range_m": 0.0,
                            "azimuth_streaks": "none"}  # fmt: skip
    return Painting(**(keys | more))


def words(count: int, seed: int) -> Any:
    drawn = np.random.default_rng(seed).integers(0, 2**32, (4, count), dtype=np.uint32)
    return tuple(jit.UInt32(w) for w in drawn)


def test_painted_noise_multiplies_and_adds_rayleigh_s() -> None:
    """Mean and spread of 40 000 draws: 1 + N(0, m), and a sqrt(pi/2), a sqrt((4 - pi)/2); a is 20 dB down of 0.3."""
    some = words(40_000, 1)
    image = jit.Float(np.full(40_000, 0.5))
    scaled = np.array(speckled(painting(), image, some, 0.0))
    assert scaled.mean() == pytest.approx(0.5, abs=4 * 0.125 / 200)
    assert scaled.std() == pytest.approx(0.125, rel=0.02)
    added = np.array(paint(painting(multiplicative=0.0), image, some, bin_=jit.Int32(0), bin_width=0.1)) - 0.5
    assert added.mean() == pytest.approx(0.003 * math.sqrt(math.pi / 2), rel=0.02)
    assert added.std() == pytest.approx(0.003 * math.sqrt((4 - math.pi) / 2), rel=0.02)
    wild = np.array(speckled(painting(multiplicative=2.0), image, some, 0.0))
    assert wild.min() == 0.0
    assert (wild == 0.0).mean() == pytest.approx(0.3085, abs=0.01)  # of 1 + 2 N below 0
    still = paint(painting(onto="level"), image, some, bin_=jit.Int32(0), bin_width=0.1)
    assert np.array(still) == pytest.approx(0.5)


def test_painted_errors_of_range_come_later_and_fainter() -> None:
    """A bin reads the one that is so much nearer as its draw is late, times exp(-late/mean); none before its beam."""
    some, rows, bins = words(4000, 2), 20, 200
    image = np.random.default_rng(3).uniform(0.5, 1.5, rows * bins).astype(np.float32)
    keys = painting(range_m=0.35, multiplicative=0.0, additive=0.0)
    bin_ = np.tile(np.arange(bins), rows)
    found = np.array(paint(keys, jit.Float(image), some, bin_=jit.Int32(bin_), bin_width=0.1)).reshape(rows, bins)
    uniform = (np.array(some[3], np.float64) + 0.5) * 2.0**-32
    late = -0.35 * np.log(uniform).reshape(rows, bins)
    shift = np.round(late / 0.1).astype(int)
    sure = np.abs(late / 0.1 % 1 - 0.5) > 1e-3
    source = np.arange(bins) - shift
    picked = np.take_along_axis(image.reshape(rows, bins), np.maximum(source, 0), axis=1)
    expected = np.where(source >= 0, picked * np.exp(-late / 0.35), 0.0)
    assert found[sure] == pytest.approx(expected[sure], abs=1e-4)


def test_streaks_are_where_more_than_a_part_of_the_rays_meet_squarely() -> None:
    """Of 50 rays a row more than 4 within 8 deg of square; rays that meet nothing do not count."""
    square, slant = math.cos(math.radians(7.0)), math.cos(math.radians(9.0))
    sine = np.full((3, 50), slant)
    sine[0, :5], sine[1, 10:14], sine[2, :9] = square, square, square
    heard = np.ones((3, 50), bool)
    heard[2, :5] = False
    row = np.repeat(np.arange(3), 50)
    found = streak_rows(jit.Float(sine.ravel()), jit.Bool(heard.ravel()), jit.UInt32(row), 3)
    assert np.array(found).tolist() == [True, False, False]
    level, streak = jit.Float([0.3, 0.3]), jit.Bool([True, False])
    assert np.array(paint_streaks(painting(azimuth_streaks="dark"), level, streak)) == pytest.approx([0.09, 0.3])
    assert np.array(paint_streaks(painting(azimuth_streaks="bright"), level, streak)) == pytest.approx([0.51, 0.3])


PALETTE = [MATERIALS["sand"], MATERIALS["steel"], replace(MATERIALS["steel"], corner_m=0.3)]
ANGLE = np.linspace(0.0, math.pi / 2, 181)


def test_tables_of_surfaces_hold_their_closed_forms() -> None:
    """Sediments and the sea as at the nearer end of 10 to 100 kHz; solids whatever the frequency; a corner by its
    target strength over the 1.5 d^2 of its inside, and what is diffuse."""
    low, high = (scattering_table(PALETTE, f, wind_speed=6.0) for f in (3e3, 3e5))
    assert low[0] == pytest.approx(scattering_table(PALETTE, 1e4, wind_speed=6.0)[0])
    assert high[0] == pytest.approx(scattering_table(PALETTE, 1e5, wind_speed=6.0)[0])
    assert (np.abs(low[0] / high[0] - 1.0) > 0.05).any()
    sine, steel = np.sin(ANGLE), MATERIALS["steel"]
    impedance = steel.density_ratio * steel.sound_speed_ratio
    mirror = ((impedance - 1) / (impedance + 1)) ** 2
    diffuse = np.array(lambert(jit.Float64(sine), jit.Float64(steel.lambert_db)))
    solid = diffuse + np.array(facets(jit.Float64(sine), jit.Float64(mirror), 0.12))
    assert low[1] == pytest.approx(solid, rel=2e-3)
    assert high[1] == pytest.approx(solid, rel=2e-3)
    for table, frequency in ((low, 3e3), (high, 3e5)):
        strength = float(np.array(corner(jit.Float64(0.3), jit.Float64(1500.0 / frequency)))[0])
        assert table[2][-1] == pytest.approx(10 ** (strength / 10) / (1.5 * 0.09) + diffuse[-1], rel=1e-3)
    sea = np.array(surface_backscatter(jit.Float64(ANGLE), 1e5, 6.0))
    assert high[3] == pytest.approx(sea, rel=1e-4)
    bounced = mirror_table(PALETTE, 3e5, wind_speed=12.0)
    assert bounced[1][-1] == pytest.approx(mirror, rel=1e-3)
    loss = np.array(bubble_loss_db(jit.Float64(sine), 1e5, 12.0))
    assert bounced[3] == pytest.approx(10 ** (-loss / 10), rel=1e-4)
    assert bounced[3][90] < 0.99


def test_a_surface_scatters_by_its_row_between_the_angles_of_its_table() -> None:
    """Linear in the angle; all but corners vary from place to place."""
    made = surfaces(PALETTE, 7e4, wind_speed=6.0, texture_db=1.2)
    table, bounced = (f(PALETTE, 7e4, wind_speed=6.0) for f in (scattering_table, mirror_table))
    angle, row = np.radians([0.0, 12.13, 47.9, 89.8, 90.0]), np.array([0, 3, 1, 2, 0])
    sine = jit.Float(np.sin(angle))
    for of, known in ((scattering, table), (mirror_share, bounced)):
        expected = [np.interp(a, ANGLE, known[r]) for a, r in zip(angle, row, strict=True)]
        assert np.array(of(made, jit.UInt32(row), sine)) == pytest.approx(expected, rel=2e-2, abs=1e-6)
    assert np.array(made.texture) == pytest.approx([1.2, 1.2, 0.0, 1.2])
    assert int(made.sea_row[0]) == 3


@pytest.mark.parametrize(("bottom", "own"), [(True, None), (False, None), (True, 2.5)])
def test_what_goes_on_from_a_bounce(bottom: bool, own: float | None) -> None:
    """At the sea by bubbles, or by a loss of one's own; elsewhere by the material and 4 dB; nothing from nothing."""
    made = surfaces(PALETTE, 7e4, wind_speed=9.0)
    mirrors: Any = SimpleNamespace(bottom=bottom, surface_loss_db=own, bottom_loss_db=4.0)
    hits: Any = SimpleNamespace(
        valid=jit.Bool([True, True, False, True]),
        instance=jit.UInt32([SEA_SURFACE_INSTANCE, 5, SEA_SURFACE_INSTANCE, 6]), material=jit.UInt32([3, 0, 3, 1]),
    )  # fmt: skip
    sine = np.array([0.4, 0.3, 0.4, 0.9])
    goes, part = _reflected(hits, jit.Float(sine), made, mirrors)
    assert np.array(goes).tolist() == ([True, True, False, True] if bottom else [True, False, False, False])
    table = mirror_table(PALETTE, 7e4, wind_speed=9.0)
    share = [np.interp(math.asin(s), ANGLE, table[r]) for s, r in zip(sine, (3, 0, 3, 1), strict=True)]
    sea = share[0] if own is None else 10 ** (-0.25)
    found = np.array(part)
    assert found[[0, 1, 3]] == pytest.approx([sea, share[1] * 10**-0.4, share[3] * 10**-0.4], rel=1e-3)


def test_water_at_a_sonar_is_that_of_its_place_depth_and_time() -> None:
    """Absorption by temperature, salinity and depth; of its own frequency and acidity."""
    ocean: Any = SimpleNamespace(
        temperature=lambda p, t: 14.0 + 0.1 * p[0] + 0.02 * t, salinity=lambda p, t: 30.0 + 0.05 * p[1],
        sound_speed=lambda p, t: 1500.0 + 0.3 * p[2],
    )  # fmt: skip
    place, t = np.array([[3.0, 20.0, -40.0], [-9.0, 4.0, 2.0]]), np.array([5.0, 90.0])
    found = medium_of(130e3, 7.7)(ocean, jit.Array3f64(np.ascontiguousarray(place.T)), jit.Float64(t))
    dr.eval(found)
    for k, (x, y, z) in enumerate(place):
        loss = absorption(130e3, float(14.0 + 0.1 * x + 0.02 * t[k]), float(30.0 + 0.05 * y), float(max(-z, 0.0)), 7.7)
        assert np.array(found.absorption)[k] == pytest.approx(float(loss), rel=1e-5)
        assert np.array(found.sound_speed)[k] == pytest.approx(1500.0 + 0.3 * z, abs=1e-3)
    assert found.column is None


def test_rays_end_a_metre_beyond_surface_and_ground() -> None:
    z = jit.Float64([-5.0, -90.0, 1.5])
    assert np.array(highest(z, 40.0)).tolist() == [6.0, 40.0, 1.0]
    assert np.array(lowest(z, 40.0, -100.0)).tolist() == [-40.0, -11.0, -40.0]
    assert np.array(lowest(z, 400.0, -3.0)).tolist() == [-1.0, -1.0, -5.5]
