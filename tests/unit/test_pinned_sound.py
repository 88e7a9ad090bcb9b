"""Rare branches and limits of acoustics and sensors, each by its own formula: arcs, layers, pulses, keys, protocols."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import i0e

from pelagos import jit
from pelagos.acoustics import beam_pattern, bottom_detection, layered_water, ray_arc, sea_surface, seabed
from pelagos.acoustics.absorption import LAYERS, LossColumn
from pelagos.acoustics.doppler import heard_water
from pelagos.acoustics.interference import Sent, _waveform
from pelagos.acoustics.layered_rays import _to_bottom
from pelagos.acoustics.modulation import _orthogonal, arrival_time_error
from pelagos.acoustics.specular import edge_factor
from pelagos.errors import ValidityWarning
from pelagos.sensors.camera.picture.camera_config import contradiction
from pelagos.sensors.comms.ais import Ais
from pelagos.sensors.comms.hydrophone import _silent
from pelagos.sensors.comms.lbl import Lbl
from pelagos.sensors.comms.link.carrier import Light
from pelagos.sensors.comms.link.station import Station, _give_up_or_again, _left, _slot
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sensors.comms.link.transponders import _first_loud
from pelagos.sensors.lidar.scan.scanner import Scanner
from pelagos.sensors.noise import digitise
from pelagos.sensors.sonar.keys import conflicts
from pelagos.sensors.sonar.ping.arrivals import _loudest
from pelagos.sensors.sonar.ping.medium import highest, lowest
from pelagos.sensors.sonar.ping.pulse_pairs import PulsePairs
from pelagos.sensors.sonar.ping.sea_surface import _folded
from pelagos.sensors.sonar.ping.surface_scattering import _by_angle
from pelagos.sensors.sonar.ping.target_sighting import _sphere_energy
from pelagos.sensors.sonar.ping.vehicle_noise import _Here
from pelagos.sensors.sonar.synthetic_aperture_sonar import warn_of_sparse_pings


def f64(*values: float) -> Any:
    return jit.Float64(list(values))


def u32(*values: int) -> Any:
    return jit.UInt32(list(values))


def fake(**values: Any) -> Any:
    return SimpleNamespace(**values)


# sound


def test_side_lobes_of_whichever_beam_is_nearest_end_the_water_of_all() -> None:
    """Reach 9 m, tilt of cosine 0.8: 11.25 m of any beam; and each beam's own end."""
    rows = np.array([np.roll([11.0, 30.0, 40.0, 50.0], k) for k in range(4)] + [[12, 30, 40, 50], [9, 80, 80, 80]])
    heard = heard_water([jit.Float(c) for c in rows.T], jit.Float(9.0), 0.8)
    assert np.array(heard).T.tolist() == [[False] * 4] * 4 + [[True] * 4, [False] * 4]
    upright = heard_water([f64(9.0), f64(9.5), f64(20.0), f64(30.0)], f64(9.0), 1.2)
    assert [bool(h[0]) for h in upright] == [False, True, True, True]


def test_a_mean_absorption_is_that_of_the_layers_between_two_heights() -> None:
    """Two places; ways up, down, within a layer, level, and beyond both ends, where the outermost layer goes on."""
    rng = np.random.default_rng(1)
    lowest_m, step, here = np.array([-40.0, -25.0]), np.array([1.5, 2.5]), np.array([0.03, 0.05])
    layer = rng.uniform(0.01, 0.09, (2, LAYERS))
    whole = np.concatenate([np.zeros((2, 1)), np.cumsum((layer - here[:, None]) * step[:, None], axis=1)], axis=1)
    column = LossColumn(*(jit.Float(v.astype(np.float32).ravel()) for v in (whole, lowest_m, step, here)))
    ways = [(-10.3, 4.9), (5.2, -31.0), (3.21, 3.31), (2.2, 2.2), (-22.0, 40.0), (-60.0, -50.0), (60.0, 80.0)]
    row = np.repeat([0, 1], len(ways))
    start, end = np.array(ways * 2).T
    found = np.array(column.mean(jit.UInt32(row.astype(np.uint32)), jit.Float(start), jit.Float(end)))

    for k, a, b, mean in zip(row, start, end, found, strict=True):
        places = np.linspace(a, b, 20_001) if a != b else np.array([a])
        of = np.clip((places - lowest_m[k]) // step[k], 0, LAYERS - 1).astype(int)
        # single precision of sums of 1 dB over ways of 0.04 m, and samples beside some 30 edges
        assert mean == pytest.approx(layer[k, of].mean(), abs=2e-5)


def test_arcs_of_circles() -> None:
    """Radius, chord, turn and rise of circles by plane geometry; both senses, short and long."""
    turn, length = np.array([0.9, -0.6, 0.01, -0.003]), np.array([40.0, 70.0, 30.0, 55.0])
    radius = length / np.abs(turn)
    chord = 2 * radius * np.sin(np.abs(turn) / 2)
    assert np.array(ray_arc.chord_of(f64(*length), f64(*turn))) == pytest.approx(chord, rel=3e-5)
    assert np.array(ray_arc.length_of(f64(*chord), f64(*(turn / length)))) == pytest.approx(length, rel=1e-9)
    before, after = np.array([0.2, 0.5, -0.4]), np.array([0.35, 0.42, -0.55])
    slowness, middle = 1 / 1470.0, np.sin(0.5 * (before + after))
    change = (np.cos(after) - np.cos(before)) / slowness
    found = ray_arc.turn_between(f64(slowness), f64(*change), f64(*middle))
    assert np.array(found) == pytest.approx(after - before, rel=3e-6)  # (turn/2)^4 3/40
    curve = np.array([2e-3, -3e-3, 4e-3])
    way = (np.sin(after) - np.sin(before)) / curve
    sines, cosines = (tuple(f64(*g(a)) for a in (before, after)) for g in (np.sin, np.cos))
    assert np.array(ray_arc.cosine_after(sines, cosines[0], f64(*curve), f64(*way))) == pytest.approx(np.cos(after))
    rise = (np.cos(before) - np.cos(after)) / curve
    assert np.array(ray_arc.rise_over(f64(*way), sines, cosines)) == pytest.approx(rise, rel=1e-9)
    u = np.array([0.005, -0.4, 0.7, 0.0099])
    assert np.array(ray_arc._atanh_ratio(f64(*u))) == pytest.approx(np.arctanh(u) / u, rel=1e-12)
    assert ray_arc._atanh_ratio(f64(0.0))[0] == 1.0


def test_a_ray_meets_a_slope_where_its_circle_first_cuts_it() -> None:
    """Bent up, down and not at all; slopes of both signs; from level and from above; one turns before."""
    cases = [  # bend, sine, slope, height
        (2e-4, 0.3, 0.02, 90.0),
        (-3e-4, 0.15, -0.05, 60.0),
        (0.0, 0.25, 0.08, 40.0),
        (0.0, 0.1, -0.2, 25.0),
        (4e-4, 0.2, 0.0, 90.0),
        (-5e-4, -0.1, 0.03, 30.0),
        (3e-4, -0.1, -0.06, 20.0),
        (0.0, 0.1, 0.3, 20.0),
    ]
    bend, sine, slope, height = np.array(cases).T
    depth0 = 17.0
    found = _to_bottom(
        fake(z=f64(*np.full(8, depth0)), sine=f64(*sine)), f64(*bend), f64(*np.sqrt(1 - sine**2)), f64(*slope),
        f64(*(depth0 + height)),
    )  # fmt: skip
    for b, s, m, h, way in zip(bend, sine, slope, height, np.array(found), strict=True):

        def over(x: float, b: float = b, s: float = s, m: float = m, h: float = h) -> float:
            c = math.sqrt(1 - s * s)
            fallen = x * s / c if b == 0.0 else (math.sqrt(1 - (s - b * x) ** 2) - c) / b
            return h + m * x - fallen

        reach = 5e3 if b == 0.0 else (1 + s * math.copysign(1, b)) / abs(b) * 0.999999
        x = np.linspace(0.0, reach, 4001)
        below = np.flatnonzero(np.array([over(v) for v in x]) < 0.0)
        if below.size:
            assert way == pytest.approx(brentq(over, x[below[0] - 1], x[below[0]]), rel=1e-9)
        else:
            assert way == math.inf


def test_levels_and_columns_of_layered_water() -> None:
    """Two paths of other levels: above, at, between and below them; the last column has none behind it."""
    levels = np.array([7.0 * np.arange(layered_water.LEVELS), 3.0 * np.arange(layered_water.LEVELS)])
    water = fake(depth=f64(*levels.ravel()), columns=u32(2, 2), begins=f64(0, 100, 0, 250))
    row = u32(0, 0, 0, 1, 1, 1, 1)
    z = f64(35.0, 34.999, 7.0 * 70, 35.0, 36.0, -1.0, 3.0 * 62 - 0.1)
    assert np.array(layered_water.layer_at(water, row, z)).tolist() == [5, 4, 62, 11, 12, 0, 61]
    found = layered_water.next_column(water, u32(0, 0, 1, 1), u32(0, 1, 0, 1))
    assert np.array(found).tolist() == [100.0, math.inf, 250.0, math.inf]
    assert np.array(layered_water.first_level(water, u32(1), u32(1), u32(9)))[0] == 3 * layered_water.LEVELS + 9


def test_an_edge_factor_is_the_integral_of_the_way_over_the_side() -> None:
    """Over the side by quadrature: wide within 2 x 2e-3 of Fresnel's integrals, narrow within a plane wave's."""
    for low, high, slope, r, wave in [
        (-0.3, 0.5, 0.1, 7.0, 0.05),
        (0.1, 0.9, -0.2, 4.0, 0.1),
        (0.31, 0.36, 0.15, 7.0, 0.1),
    ]:
        bend = 1 - slope**2
        scale, shift = 2 * math.sqrt(bend / (wave * r)), slope * r / bend
        u = scale * (np.linspace(low, high, 40_001) + shift)
        turn = np.exp(0.5j * math.pi * u * u)
        exact = (0.5 * (turn[1:] + turn[:-1])).sum() * (u[1] - u[0]) / math.sqrt(2)
        real, imaginary = edge_factor(f64(low), f64(high), f64(slope), f64(r), f64(wave))
        width = scale * (high - low)
        tolerance = 0.01 * width if width < 0.25 else 4e-3
        assert abs(complex(real[0], imaginary[0]) - exact) < tolerance
        way = (4 * math.pi / wave) * (slope * low + bend * low * low / (2 * r) + 0.5 * bend * shift**2 / r)
        assert np.exp(1j * way) == pytest.approx(turn[0])  # out and home


def test_a_pulse_at_baseband() -> None:
    """A chirp's phase is the integral of its frequency; the sample at its end counts by its share."""
    rate, count, sent, offset = 20e3, 512, Sent(60e3, 2e3, 0.01013), 300.0
    wave = _waveform(sent, count, rate, offset)
    k = np.fft.ifftshift(np.arange(count) - count // 2)
    t = k / rate
    size = np.where(np.abs(k) <= 100, 1.0, np.where(np.abs(k) == 101, 0.8, 0.0))
    phase = 2 * math.pi * (offset * t + 0.5 * 2e3 / 0.01013 * t * t)
    np.testing.assert_allclose(wave, size * np.exp(1j * phase), atol=1e-9)
    tone = _waveform(Sent(60e3, 2e3, 0.01013, "cw"), count, rate, offset)
    np.testing.assert_allclose(tone, size * np.exp(2j * math.pi * offset * t), atol=1e-9)


def test_errors_of_orthogonal_signals_and_of_arrival_times() -> None:
    """1 - P = 1 - the integral of (1 - exp(-r^2/2))^(M-1) over Rice's density (Proakis 4.5-43), times M/2/(M-1)."""
    for order, per_bit, rel in [(2, 1.7, 1e-6), (8, 1.3, 1e-6), (16, 1.1, 1e-6), (64, 1.2, 0.1)]:
        s = per_bit * math.log2(order)

        def density(r: float, m: int = order, nu: float = math.sqrt(2 * s)) -> float:
            return (1 - math.exp(-r * r / 2)) ** (m - 1) * r * math.exp(-0.5 * (r - nu) ** 2) * float(i0e(r * nu))

        right = quad(density, 0, 14)
        expected = (1 - right[0]) * order / 2 / (order - 1)
        assert float(_orthogonal(np.array(per_bit), order)) == pytest.approx(expected, rel=rel)
    # 2 pi B_rms sqrt(2 E/N0), B_rms^2 the mean square of even frequencies in -B/2 .. B/2
    rms = math.sqrt(np.mean(np.linspace(-2000, 2000, 200_001) ** 2))
    error = 1 / (2 * math.pi * rms * math.sqrt(2 * 3.0 * 4000 * 0.02))
    assert arrival_time_error(3.0, 4000.0, 0.02) == pytest.approx(error, rel=1e-4)
    lbl = fake(_config=fake(bandwidth_hz=4000.0, pulse_s=0.02))
    assert Lbl._error(lbl, 10 * math.log10(3.0 * 80)) == pytest.approx(error, rel=1e-4)
    assert Lbl._error(lbl, -math.inf) == 0.0


def test_facets_at_the_angle_where_bubbles_take_over_are_15_db_down() -> None:
    for wind in (3.0, 8.0, 14.0):
        angle = math.radians(sea_surface._facet_angle_deg(wind))
        fallen = sea_surface.surface_facets(f64(math.sin(angle), 1.0), wind)
        assert fallen[0] / fallen[1] == pytest.approx(10**-1.5, rel=1e-9)
        assert angle > math.radians(45.0)
    assert sea_surface._facet_angle_deg(0.2) == sea_surface._facet_angle_deg(1.0)
    # over bubbles of density D: D s/(4 pi d) (1 + 8 b e^-2b - e^-4b)/(2 b), b = D/sin, winds of 11 m/s break more
    density = 10 ** (-5.2577 + 0.4701 * 11.0) * (30 / 25) ** 0.85 * (16 / 11) ** 3.5
    b = density / 0.9
    paths = (1 + 8 * b * math.exp(-2 * b) - math.exp(-4 * b)) / (2 * b)
    expected = density * 0.0136 / (4 * math.pi * 0.0255 * 30 ** (1 / 3)) * paths
    assert sea_surface.bubble_backscatter(f64(0.9), 3e4, 16.0)[0] == pytest.approx(expected, rel=1e-9)
    sine = f64(0.3)
    steep = f64(1e-6)  # so that paths past bubbles are few: then the echo goes with the sine alone
    calm, fresh, storm = (float(sea_surface.bubble_backscatter(steep, 3e4, w)[0]) for w in (7.0, 11.0, 16.0))
    assert calm == pytest.approx(fresh, rel=1e-3)
    assert storm == pytest.approx(fresh, rel=1e-3)
    thin = [float(sea_surface.bubble_backscatter(sine, 3e4, w)[0]) for w in (2.0, 4.0)]
    assert thin[1] / thin[0] == pytest.approx(10 ** (0.4701 * 2.0), rel=0.01)  # six paths of each, where few are met


def test_relief_shades_itself_and_models_join() -> None:
    """Wagner's shadowing at t = tan/slope; all is seen where t > 2; beyond a half-width of 40 nothing of the other."""
    slope = 0.2
    grazing = np.arctan(slope * np.array([0.4, 1.1, 1.999, 2.001, 40.0]))
    t = np.tan(grazing) / slope
    q = (np.exp(-t * t) / math.sqrt(math.pi) - t * np.array([math.erfc(v) for v in t])) / (4 * t)
    expected = np.where(t > 2, 1.0, (1 - np.exp(-2 * q)) / (2 * np.maximum(q, 1e-12)))
    found = np.array(seabed._shadowing(f64(*grazing), f64(slope)))
    assert found == pytest.approx(expected, abs=1e-6)
    mixed = np.array(seabed._join(f64(-50.0, -1.0, 0.0, 2.0, 50.0), f64(3.0), f64(8.0)))
    weight = 1 / (1 + np.exp(-np.array([-50.0, -1.0, 0.0, 2.0, 50.0])))
    assert mixed == pytest.approx(3.0 + 5.0 * weight, rel=1e-12)
    # of slopes s: mean of 1, of the sine's square for small angles theta^2 + s^2/... by the rule's own moments
    mean = seabed._over_slopes(lambda sine: sine * sine, f64(0.7), f64(0.05))
    gauss = sum(
        w * math.sin(0.7 + n * 0.05) ** 2
        for w, n in zip((0.166667, 0.666667, 0.166667), (-1.224745, 0, 1.224745), strict=True)
    )
    assert mean[0] == pytest.approx(gauss, rel=2e-5)
    # s^2 = (2 pi w2)^(1/a)/(2 (1 - a)) (k^2/a)^((1-a)/a), a = 0.625
    s2 = (2 * math.pi * 0.004) ** 1.6 / 0.75 * (1.3**2 / 0.625) ** 0.6
    assert seabed.rms_slope(f64(0.004), 1.3)[0] == pytest.approx(math.sqrt(s2), rel=1e-12)


def test_rock_and_slow_mud_scatter_as_printed() -> None:
    """TR 9407, Section IV: angles in degrees, of slow bottoms a critical angle of 2.5613 deg."""
    for nu, rho, grazing, slope in [(1.8, 2.5, 0.3, 0.25), (0.98, 1.2, 1.2, 0.15), (1.0005, 1.3, 0.0005, 0.2)]:
        theta = max(math.degrees(grazing), 0.1)
        critical = 2.5613 if nu < 1.001 else math.degrees(math.acos(1 / nu))
        s = math.degrees(slope)
        c = 1 + 0.81 * (critical / theta) ** 2
        side = 0.04682 * slope**1.25 * nu**3.25 * (1 + (1 - 2 / rho) / nu**2) ** 2 / (1 + 3.54 * s / critical)
        facets = 0.0260 * 0.2 / (slope**2 * c) * (1 + (90 - theta) ** 2 / (2.6 * s * s)) ** -1.9
        expected = side * math.sin(math.pi / c) ** (0.7263 / slope ** (1 / 3)) + facets
        bottom = seabed.Bottom(f64(rho), f64(nu), f64(0.01), f64(0.002), f64(0.01))
        found = seabed._large_roughness(f64(grazing), f64(slope), bottom, f64(0.2))
        assert found[0] == pytest.approx(expected, rel=1e-9)


def test_shares_of_a_beam() -> None:
    """By quadrature of the patterns; of rows by hand."""
    for length, ways in [(9.0, 2), (4.0, 1), (0.6, 2)]:
        edge = math.asin(min(1 / length, 1.0))
        power = lambda a, n=length, w=ways: float(np.sinc(n * math.sin(a))) ** (2 * w)
        angles, whole = beam_pattern.spread_over_beam(length, np.array([0.1, 0.5, 0.8]), ways=ways)
        total = quad(power, -edge, edge)[0]
        assert whole == pytest.approx(total, rel=1e-5)
        assert [quad(power, -edge, a)[0] / total for a in angles] == pytest.approx([0.1, 0.5, 0.8], abs=1e-3)
    rows = np.sqrt(np.array([[0.01, 0.2, 0.58, 0.2, 0.01], [0.0, 0.01, 0.98, 0.01, 0.0]]), dtype=np.float32)
    assert [beam_pattern.energy_reach(rows, lost=part) for part in (0.5, 0.03, 0.01)] == [0, 1, 2]
    x = np.linspace(-0.5, 0.5, 20_001)
    for shading in ("light", "hamming", "hann"):
        weight = beam_pattern.line_weights(x, shading)
        sine = np.array([0.07, -0.21, 0.33])
        pattern = [np.trapezoid(weight * np.cos(2 * math.pi * 6.0 * s * x), x) / np.trapezoid(weight, x) for s in sine]
        assert beam_pattern.weighted_line_np(sine, 6.0, shading) == pytest.approx(pattern, abs=1e-6)
        assert np.array(beam_pattern.shaded_line(f64(*sine), 6.0, shading)) == pytest.approx(pattern, abs=1e-6)


def test_phases_between_half_beams_cross_zero_where_a_line_through_them_does() -> None:
    """By NumPy's weighted fit, twice: ramps of both signs, phases that wrap, samples below the gate; too few."""
    samples, spacing, resolution = 60, 0.05, 0.08
    rng = np.random.default_rng(4)
    start, crossing, slope = np.array([20.0, 31.0, 9.0]), np.array([27.3, 33.8, 30.0]), np.array([0.09, -0.13, 0.1])
    k = np.arange(samples) + 0.5
    phase = slope[:, None] * (k - crossing[:, None]) + rng.normal(0.0, 0.15, (3, samples))
    size = rng.uniform(0.7, 1.5, (3, samples))
    size[:, ::7] = 0.05
    size[2, np.abs(k - 30) > 1.6] = 0.05  # three samples alone
    half = 0.5 * size * np.exp(0.5j * phase)
    parts = np.stack([half.real, half.imag, half.real, -half.imag], axis=-1)
    series = bottom_detection.Series(*(jit.Float(v.astype(np.float32).ravel()) for v in (
        parts, start, np.full(3, spacing), np.full(3, resolution))))  # fmt: skip
    row = u32(0, samples, 2 * samples)
    middle = start + 29.0 * spacing
    found, error = bottom_detection._zero_crossing(series, row, samples, jit.Float(0.04), jit.Float(middle))
    heard = np.abs(2 * half.real) ** 2  # of the sum of both halves
    wrapped = np.angle(half**2)
    for i in (0, 1):
        line = None
        for _ in range(2):
            expected = None if line is None else np.polyval(line, k)
            used = (
                np.abs(wrapped[i]) < 2.0
                if line is None
                else (np.abs(expected) < 1.2) & (np.abs(wrapped[i] - expected) < 2.0)
            )
            used &= heard[i] > 0.04
            g = np.sqrt(heard[i][used])
            line = np.polyfit(k[used], wrapped[i][used], 1, w=np.sqrt(g))
        at, x = -line[1] / line[0], k[used]
        mean, var = np.average(x, weights=g), np.average((x - np.average(x, weights=g)) ** 2, weights=g)
        residual = np.average((wrapped[i][used] - np.polyval(line, x)) ** 2, weights=g)
        looks = max(g.sum() ** 2 / (g * g).sum() * spacing / resolution, 1.0)
        deviation = math.sqrt(residual * (1 + (at - mean) ** 2 / var) / looks) / abs(line[0]) * spacing
        assert found[i] == pytest.approx(start[i] + at * spacing, abs=2e-5)
        assert error[i] == pytest.approx(deviation, rel=1e-3)
    assert error[2] == math.inf
    centre, spread, level, count = bottom_detection._weighted_mean_time(series, row, samples, jit.Float(0.04))
    for i in (0, 1):
        w = np.where(heard[i] > 0.04, heard[i], 0.0)
        mean = np.average(k, weights=w)
        width2 = np.average((k - mean) ** 2, weights=w) * spacing**2 - resolution**2 / 12
        assert count[i] == (w > 0).sum()
        assert level[i] == pytest.approx(w.sum() / (w > 0).sum(), rel=1e-5)
        assert centre[i] == pytest.approx(start[i] + mean * spacing, abs=2e-5)
        assert spread[i] == pytest.approx(math.sqrt(width2), rel=1e-4)


# pings


def test_places_are_folded_at_both_ends_and_tables_read_between_angles() -> None:
    place, way = _folded(f64(10.5, -5.0, 50.0, 100.0, -60.0))
    assert np.array(place) == pytest.approx([10.5, 5.0, 46.0, 4.0, 36.0], abs=1e-9)
    assert np.array(way).tolist() == [1, -1, -1, 1, 1]
    table = np.concatenate([2.0 * np.arange(181), 1000.0 + np.arange(181) ** 2])
    angle = np.radians([10.2, 45.25, 90.0, 0.0])
    found = np.array(_by_angle(jit.Float(table), u32(0, 1, 1, 1), jit.Float(np.sin(angle))))
    at = 1000.0 + 0.5 * (90**2 + 91**2)
    assert found == pytest.approx([2 * 20.4, at, 1000.0 + 180**2, 1000.0], rel=1e-5)


def test_the_loudest_known_sample_and_the_rough_part_of_a_sphere() -> None:
    signal = jit.Float([9, 9, 1, 2, -3, 1, 0.5, -3.1, 8, 8])  # of five pairs, those from 1 on and three of them
    taps = [jit.Int32([k, k - 3]) for k in (-1, 0, 1, 2, 3)]
    real, imaginary = _loudest(signal, u32(1, 1), u32(3, 3), taps)
    assert np.array(real).tolist() == [-3, 1]
    assert np.array(imaginary).tolist() == [1, 2]
    place = fake(form=jit.Float(0.3), lambert=jit.Float(0.02), radius=jit.Float(0.7))
    expected = 0.75 * (0.09 + 2 / 3 * math.pi * 0.49 * 0.02)
    assert _sphere_energy(place, jit.Float(0.25))[0] == pytest.approx(expected, rel=1e-6)
    # pairs of pulses of coherence r: n of them have the phase's variance (1 - r^2)/(2 n r^2)
    loss = PulsePairs._loss(fake(_deviation=(0.02, 0.1)), f64(7.0), f64(-0.3), f64(4.0))[0]
    assert loss / (2 * 7.0 * (1 - loss)) == pytest.approx((0.02**2 + 0.03**2) * 16.0, rel=1e-12)


def test_water_reaches_to_its_surface_and_to_the_ground() -> None:
    z = f64(-12.0, 2.0, -80.0)
    assert np.array(highest(z, 30.0)).tolist() == [13.0, 1.0, 30.0]
    assert np.array(lowest(z, 30.0, -85.0)).tolist() == [-30.0, -30.0, -6.0]
    assert np.array(lowest(f64(-90.0), 30.0, -85.0)).tolist() == [-1.0]


def test_lanes_of_another_vehicle_are_those_of_the_same_tick_and_copy() -> None:
    """Two ticks of three carriers of two copies beside one vehicle of as many ticks and copies."""
    copy = np.tile([0, 1, 2, 3, 4, 5], 2)
    zero = np.zeros((12, 3))
    here = _Here(zero, zero, copy, np.zeros(12, int), np.zeros(12, int))
    assert here.lanes_of(4, 2, 3).tolist() == [0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3]
    assert here.lanes_of(12, 2, 3).tolist() == list(range(12))


def test_keys_at_their_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conflicts, "quote", lambda config, *keys: " ".join(keys))
    assert [conflicts._down(v) for v in (123_456.0, 0.0999987, 250.0, 3.9999)] == [123_400.0, 0.09999, 250.0, 3.999]
    conflicts.check_ambiguity(fake(range_max_m=70.0, rate_hz=10.0))
    with pytest.raises(ValueError, match=r"range_max_m of at most 63\.63, or a rate_hz of at most 9\.333$"):
        conflicts.check_ambiguity(fake(range_max_m=75.0, rate_hz=11.0))
    conflicts.check_pulse(fake(pulse_s=0.049, rate_hz=20.0))
    with pytest.raises(ValueError, match="less than 20 Hz"):
        conflicts.check_pulse(fake(pulse_s=0.05, rate_hz=20.0))
    burst = {"frequency_hz": 1e4, "bandwidth_hz": 1000.0, "pulse_s": 0.001}
    conflicts.check_burst(fake(**burst, pulse="cw"))
    conflicts.check_burst(fake(**burst | {"pulse_s": 0.0009995}, pulse="chirp"))
    for wrong, told in [({"pulse_s": 0.002, "pulse": "cw"}, "500 Hz: give that"),
                        ({"pulse_s": 0.0005, "pulse": "cw"}, "2000 Hz: give that"),
                        ({"pulse_s": 0.0008, "pulse": "chirp"}, "pulse_s of 0.001 or more"),
                        ({"bandwidth_hz": 2e4, "pulse": "chirp"}, "less than 20000")]:  # fmt: skip
        with pytest.raises(ValueError, match=told):
            conflicts.check_burst(fake(**burst | wrong))


def test_pings_that_lie_too_far_apart_for_an_aperture() -> None:
    """Pings 0.05 m apart at most; a range of 50 m allows for 14 Hz."""
    config = fake(rate_hz=10.0, step_m=0.05, range_max_m=50.0)
    assert not warn_of_sparse_pings(config, "sas", 0.5)
    with pytest.warns(ValidityWarning, match=r"lie 0.06 m apart.* 0.5 m/s or slower or ping at 12 Hz .* for 14 Hz"):
        assert warn_of_sparse_pings(config, "sas", 0.6)
    with pytest.warns(ValidityWarning, match=r"0.5 m/s or slower \(a range"):
        assert warn_of_sparse_pings(config, "sas", 0.8)


# other sensors


def test_protocols_give_up_after_their_retries_and_wait_longer_each_time() -> None:
    """Of 1.5 s packets 2^tries, at most 32, times a number by chance; a request that nobody answered counts too."""
    for tries, retries, awaits, mac, kept, waits in [
        (2, 2, "ack", "csma", True, 0.25 * 4 * 1.5), (3, 2, "ack", "csma", False, 0.25 * 8 * 1.5),
        (2, 2, "cts", "maca", False, 0.25 * 8 * 1.5), (1, 2, "cts", "maca", True, 0.25 * 4 * 1.5),
        (7, 9, "ack", "aloha", True, 0.25 * 32 * 1.5), (1, 2, "ack", "none", True, 0.0),
    ]:  # fmt: skip
        lost, other = fake(tries=tries, payload="abc", kind="data"), object()
        station = Station(queue=[other], pending=lost, awaits=awaits)
        port = fake(retries=retries, mac=mac, duration_s=lambda length, kind: 0.5 * length)
        _give_up_or_again(station, port, 5_000_000_000, 0.25)
        assert station.queue == ([lost, other] if kept else [other])
        assert station.pending is None
        assert station.wait_ns == (5_000_000_000 + round(waits * 1e9) if waits else 0)
        assert station.draws == (mac != "none")
    port = fake(slot_s=0.5, slots=3, address=7)
    assert [_slot(port, round(t * 1e9)) for t in (0.499999999, 0.5, 0.9, 1.0, 2.2)] == [None, 1, 1, None, 4]
    assert _left(port, 700_000_000) == 300_000_000
    assert _left(port, 1_000_000_000) == 500_000_000


def test_a_modem_hears_what_is_loud_while_it_lasts() -> None:
    def hears(now: int, **changed: Any) -> bool:
        signal = {"receiver": 1, "start_ns": 10, "end_ns": 20, "level_db": 61.0, "noise_db": 50.0} | changed
        packet = fake(**signal, transmission=fake(copy=signal.pop("copy", 2)))
        ports = [fake(detection_db=3.0), fake(detection_db=10.0)]
        return Traffic._hears(fake(_ports=ports, _incoming=[packet]), 1, 2, now)

    assert [hears(t) for t in (9, 10, 19, 20)] == [False, True, True, False]
    assert not hears(15, level_db=60.0)
    assert not hears(15, noise_db=52.0)
    assert not hears(15, receiver=0)
    assert not hears(15, copy=1)


def test_pulses_of_a_pinger_that_fall_into_a_reading() -> None:
    """Every 2 s one of 0.1 s, from 0 on."""
    pinger = fake(period_s=2.0, pulse_s=0.1)
    spans = [(-1, -0.5), (-0.5, 0.0), (0.05, 1), (0.11, 1.9), (0.11, 2.0), (4.09, 4.5), (4.11, 5.0), (0.2, 9.0)]
    silent = [_silent(pinger, np.array(s)) for s in spans]
    assert silent == [True, False, False, True, False, False, True, False]


def test_the_first_path_that_is_not_far_below_the_loudest() -> None:
    """Ten decibels below it counts, eleven doesn't, nor does what is blocked."""
    path, loss = np.array([0, 0, 0, 2, 2, 2]), np.array([70.0, 60.0, 61.0, 71.0, 60.0, 40.0])
    arrivals = fake(path=path, loss_db=loss, delay=np.array([1.0, 3.0, 2.0, 1.0, 2.0, 0.5]))
    found = fake(arrivals=arrivals, blocked=np.array([False] * 5 + [True]))
    assert _first_loud(found, 3).tolist() == [0, -1, 4]


def test_an_odd_hull_around_its_receiver() -> None:
    for ais_class, count in (("A", 1), ("B", 2)):
        config = fake(length_m=33, beam_m=9, ais_class=ais_class, name="sea", ship_type=70)
        said = Ais._static(fake(_config=config))
        size = [said[-1][k] for k in ("to_bow", "to_stern", "to_port", "to_starboard")]
        assert size == [16, 17, 4, 5]
        assert len(said) == count
        assert said[0]["shipname"] == "SEA"


def test_daylight_falls_with_the_sun_and_the_depth() -> None:
    def current(sun: float, depth: float, channel: int = 1) -> float:
        ocean = fake(sun_elevation=f64(sun), water=fake(downwelling=[0.4, 0.07, 0.05]))
        light = fake(ocean=ocean, channel=channel, area=0.01, field_of_view=0.5, filter_share=0.1, responsivity=0.3)
        return Light._daylight(light, depth)

    assert current(0.5, 4.0) / current(0.5, 10.0) == pytest.approx(math.exp(0.42), rel=1e-9)
    assert current(0.5, 10.0, 0) / current(0.5, 4.0, 0) == pytest.approx(math.exp(-2.4), rel=1e-9)
    assert current(1.1, 4.0) / current(0.5, 4.0) == pytest.approx(math.sin(1.1) / math.sin(0.5), rel=1e-9)
    assert current(0.5, -3.0) == current(0.5, 0.0) > 0.0 == current(-0.2, 1.0)


def test_contradictions_of_an_exposure_begin_beyond_their_limits() -> None:
    fits = {"rate_hz": 25.0, "shutter_s": 0.04, "rolling_shutter_s": 0.04, "exposure": "manual", "iso": 800.0,
            "iso_max": 800.0, "model_fields_set": {"iso_max"}, "meter_min_cd_m2": 2.0, "meter_max_cd_m2": 2.0,
            "aperture": 2.8, "aperture_widest": 2.8}  # fmt: skip
    for fine in ({}, {"exposure": "auto"}, {"shutter_s": 0.1, "exposure": "auto"}, {"aperture_widest": None},
                 {"exposure": "auto", "iso": 900.0, "model_fields_set": set()}, {"iso": 900.0}):  # fmt: skip
        assert contradiction(fake(**fits | fine)) is None
    for wrong, named in [({"shutter_s": 0.041}, "shutter_s"), ({"rolling_shutter_s": 0.041}, "rolling_shutter_s"),
                         ({"exposure": "auto", "iso": 801.0}, "iso"), ({"meter_min_cd_m2": 2.1}, "meter_min_cd_m2"),
                         ({"aperture": 2.7}, "aperture")]:  # fmt: skip
        assert (contradiction(fake(**fits | wrong)) or "").startswith(f"'{named}'")


def test_digits_and_turns() -> None:
    value = f64(0.37, -0.38, 5.0, -1.3)
    found = np.array(digitise(value, resolution=0.25, lowest=-1.1, highest=2.0))
    assert found.tolist() == [0.25, -0.5, 2.0, -1.1]
    assert np.array(digitise(value, resolution=0.0, lowest=-1.1, highest=2.0)).tolist() == [0.37, -0.38, 2.0, -1.1]
    motion = fake(t_ns=np.array([500_000_000, 40_000_000]), tick=np.zeros(2))
    config = fake(pattern="spinning", rotation_hz=7.5, horizontal_fov_deg=120.0)
    turned = Scanner.angle(fake(_config=config), motion)
    assert turned == pytest.approx(np.radians([0.75 * 120.0, 0.3 * 120.0]), rel=1e-9)
    config.pattern = "solid_state"
    assert Scanner.angle(fake(_config=config), motion).tolist() == [0.0, 0.0]
