"""The simulated sea: its statistics, and the motion of the water below it, against linear theory."""

from itertools import pairwise

import drjit as dr
import numpy as np
import pytest
from scipy import stats

from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.site import Site
from pelagos.ocean.spectrum import cos2s, jonswap
from pelagos.ocean.wave_system import (
    JonswapWavesConfig,
    OchiHubbleWavesConfig,
    PiersonMoskowitzWavesConfig,
    RegularWavesConfig,
    SeaStateWavesConfig,
    TableWavesConfig,
    TmaWavesConfig,
    TorsethaugenWavesConfig,
)
from pelagos.ocean.waves import Waves, make_waves, patch

SITE = Site(GeoOrigin(45, 13), seed=5)
G = 9.81


def sea(*systems, depth=None, seed=5) -> Waves:
    waves = make_waves(systems, Site(GeoOrigin(45, 13), seed=seed), depth=depth)
    assert waves is not None
    return waves


def table(waves: Waves) -> np.ndarray:
    return np.array(waves.table).reshape(-1, 8)


def elevation(waves: Waves, x, y, t) -> np.ndarray:
    x, y, t = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, y, t)))
    columns = [jit.Float64(np.ascontiguousarray(v).ravel()) for v in (x, y, t)]
    return np.array(jit.freeze(lambda w, a, b, c: w.elevation(a, b, c))(waves, *columns)).reshape(x.shape)


def motion(waves: Waves, position, t: float, *, stretch: bool = False) -> dict[str, np.ndarray]:
    p = jit.Array3f64(np.ascontiguousarray(np.atleast_2d(position).T, dtype=float))
    found = waves.motion(p, jit.Float64(t), stretch=stretch)
    names = ("elevation", "velocity", "acceleration", "head")
    return {name: np.array(getattr(found, name)).T for name in names}


SYSTEMS = {
    "jonswap": JonswapWavesConfig(significant_height_m=2.0, peak_period_s=8.0),
    "pierson_moskowitz": PiersonMoskowitzWavesConfig(wind_mps=12.0),
    "tma": TmaWavesConfig(significant_height_m=1.0, peak_period_s=8.0),
    "ochi_hubble": OchiHubbleWavesConfig(significant_height_m=2.0, peak_period_s=12.0),
    "torsethaugen": TorsethaugenWavesConfig(significant_height_m=3.0, peak_period_s=9.0),
    "sea_state": SeaStateWavesConfig(state=4),
    "table": TableWavesConfig(frequency_hz=(0.05, 0.1, 0.2, 0.5), density_m2phz=(0, 4.0, 1.0, 0.1)),
}
HEIGHT = {"jonswap": 2.0, "pierson_moskowitz": 0.02133 * 144, "tma": 1.0, "ochi_hubble": 2.0, "torsethaugen": 3.0,
          "sea_state": 1.88, "table": 4 * np.sqrt(0.1 + 0.25 + 0.165)}  # fmt: skip


@pytest.mark.parametrize("name", SYSTEMS)
def test_height_and_peak_of_the_components(name: str) -> None:
    """Sum of a^2 / 2 is the energy within 0.1 % (the band that is left out); the strongest band lies at the peak."""
    waves = sea(SYSTEMS[name], depth=20.0 if name == "tma" else None)
    t = table(waves)
    assert 4 * np.sqrt(np.sum(t[:, 4] ** 2) / 2) == pytest.approx(HEIGHT[name], rel=2e-3)
    f = t[:200, 2]
    density = t[:200, 4] ** 2 / f  # bands grow with f
    smooth = np.convolve(density, np.ones(5) / 5, "same")
    assert 1 / f[np.argmax(smooth)] == pytest.approx(SYSTEMS[name].peak, rel=0.05)


def test_statistics_of_a_record() -> None:
    """Hs within 1 %, Tz, skewness and kurtosis of Gauss, wave heights of Rayleigh; long-crested so that it is the
    theory's.

    40 points far apart for 1 h: some 18 000 waves. Standard deviations, from that number: Hs 0.5 %, skewness 0.02,
    kurtosis 0.05 (the record is correlated over a few waves). Heights lie 4 to 8 % below Rayleigh for the finite
    width of JONSWAP (G. Z. Forristall, J. Geophys. Res. 83:2353, 1978: 0.942).
    """
    waves = sea(JonswapWavesConfig(significant_height_m=2.0, peak_period_s=8.0, spreading=None))
    t = np.arange(0, 3600, 0.25)
    record = elevation(waves, 700.0 * np.arange(40)[:, None], 0.0, t[None, :])
    assert 4 * record.std() == pytest.approx(2.0, rel=0.01)
    crossing = (record[:, :-1] < 0) & (record[:, 1:] >= 0)
    t = table(waves)
    tz = np.sqrt(np.sum(t[:, 4] ** 2) / np.sum((t[:, 4] * t[:, 2]) ** 2))  # of the band, up to six times the peak
    assert tz == pytest.approx(0.77744 * 8, rel=0.02)
    assert 40 * 3600 / crossing.sum() == pytest.approx(tz, rel=0.01)
    values = record[:, ::8].ravel()
    assert stats.skew(values) == pytest.approx(0, abs=0.06)
    assert stats.kurtosis(values) == pytest.approx(0, abs=0.15)
    heights = []
    for row, up in zip(record, crossing, strict=True):
        at = np.nonzero(up)[0]
        heights += [row[a:b].max() - row[a:b].min() for a, b in pairwise(at)]
    h = np.sort(heights)[::-1] / 2.0
    assert h[: len(h) // 3].mean() == pytest.approx(1.0011 * 0.942, rel=0.03)
    assert h[: len(h) // 10].mean() == pytest.approx(1.2727 * 0.942, rel=0.04)
    assert np.sqrt(np.mean(h**2)) == pytest.approx(0.7071 * 0.942, rel=0.04)


def test_spectrum_of_a_record_is_the_spectrum() -> None:
    """Welch's estimate, 80 points with 30 segments each, in bands of 0.02 Hz: 4 % (one sigma)."""
    from scipy.signal import welch

    waves = sea(JonswapWavesConfig(significant_height_m=2.0, peak_period_s=8.0, components_count=400))
    x = 900.0 * np.arange(80)[:, None]
    record = elevation(waves, x, -0.7 * x, np.arange(0, 1800, 0.5)[None, :])
    f, s = welch(record, fs=2.0, nperseg=512)
    s = s.mean(axis=0)
    for low in np.arange(0.08, 0.3, 0.02):
        band = (f >= low) & (f < low + 0.02)
        expected = np.mean(jonswap(np.linspace(low, low + 0.02, 50), 2.0, 8.0))
        assert s[band].mean() == pytest.approx(expected, rel=0.2)
    band = f > 0.1
    assert 1 / f[band][np.argmax(np.convolve(s[band], np.ones(3) / 3, "same"))] == pytest.approx(8.0, rel=0.05)


def test_directions_are_those_of_the_spreading() -> None:
    waves = sea(JonswapWavesConfig(significant_height_m=2, peak_period_s=8, towards_deg=30, components_count=1000))
    t = table(waves)
    angle = (np.arctan2(t[:, 1], t[:, 0]) + np.radians(30) + np.pi) % (2 * np.pi) - np.pi
    grid = np.linspace(-np.pi, np.pi, 4001)
    cumulative = np.cumsum(cos2s(grid, 10)) * (grid[1] - grid[0])
    assert stats.kstest(angle, lambda a: np.interp(a, grid, cumulative)).statistic < 2e-3
    assert np.average(np.cos(angle), weights=t[:, 4] ** 2) == pytest.approx(10 / 11, abs=0.03)  # s / (s + 1)


def test_same_seed_same_sea_and_another_seed_another() -> None:
    system = SYSTEMS["jonswap"]
    assert np.array_equal(table(sea(system)), table(sea(system)))
    assert not np.isclose(table(sea(system, seed=6))[:, 3], table(sea(system))[:, 3]).any()


def test_frequencies_have_no_common_period() -> None:
    """At no time in a day does the sea at the origin return to what it was at t = 0 (all 200 phases)."""
    f = table(sea(SYSTEMS["jonswap"]))[:, 2]
    times = np.arange(60, 86_400, 0.5)
    alike = np.zeros(len(times))
    for x in f:
        alike += np.cos(2 * np.pi * x * times)
    assert alike.max() / len(f) < 0.5


def test_regular_wave_travels_where_it_should() -> None:
    """Towards east: y falls eastwards. The crest of t = 0 stands c t further east at t."""
    waves = sea(RegularWavesConfig(height_m=2, period_s=10, towards_deg=90))
    c = 15.6131
    assert elevation(waves, 3.0, -c * 2.0, 2.0) == pytest.approx(1.0, abs=1e-7)
    assert elevation(waves, 3.0, -c * 2.0 + 78.0655, 2.0) == pytest.approx(-1.0, abs=1e-7)
    assert elevation(waves, 0.0, 0.0, 2.5) == pytest.approx(0.0, abs=1e-9)


def test_elevation_against_numpy_far_away() -> None:
    """200 components, 100 km from the origin after a day: phases of 1e5 turns keep 1e-9 m."""
    waves = sea(SYSTEMS["jonswap"])
    t = table(waves)
    x, y, time = np.array([1e5, -3e4, 12.3]), np.array([-2e4, 9e4, 4.5]), 86_400.25
    turns = t[:, 0] * x[:, None] + t[:, 1] * y[:, None] - t[:, 2] * time + t[:, 3]
    expected = np.sum(t[:, 4] * np.cos(2 * np.pi * (turns % 1.0)), axis=1)
    assert elevation(waves, x, y, time) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("depth", [None, 12.0])
def test_motion_is_that_of_airy_waves(depth) -> None:
    """One wave: orbits of radius a e^{kz} (deep) or a cosh/sinh and a sinh/sinh (finite depth), and the pressure's
    head.
    """
    waves = sea(RegularWavesConfig(height_m=0.4, period_s=6, towards_deg=0), depth=depth)
    t = table(waves)[0]
    k, w, a = 2 * np.pi * t[0], 2 * np.pi / 6, 0.2
    h = depth or 1e4
    for z in (0.0, -1.0, -5.0, -11.9):
        m = motion(waves, (3.0, 1.0, z), 0.7)
        phase = k * 3.0 - w * 0.7
        if depth is None:
            across = up = head = np.exp(k * z)
        else:
            across, up = np.cosh(k * (z + h)) / np.sinh(k * h), np.sinh(k * (z + h)) / np.sinh(k * h)
            head = np.cosh(k * (z + h)) / np.cosh(k * h)
        assert m["velocity"][0] == pytest.approx(
            [a * w * across * np.cos(phase), 0, a * w * up * np.sin(phase)], abs=1e-12
        )
        assert m["acceleration"][0] == pytest.approx(
            [a * w * w * across * np.sin(phase), 0, -a * w * w * up * np.cos(phase)], abs=1e-12
        )
        assert m["head"] == pytest.approx(a * head * np.cos(phase), abs=1e-12)


@pytest.mark.parametrize("depth", [None, 15.0])
def test_flow_has_no_divergence_and_no_curl_and_accelerates_by_the_pressure(depth) -> None:
    """Differences over 1 cm, 200 components: curvature k^2 (1 cm)^2 is 1e-5 of rates of 1/s: 1e-6 asked for."""
    waves = sea(SYSTEMS["jonswap"], depth=depth)
    d, place, t = 0.01, np.array([20.0, -30.0, -2.0]), 33.0
    at = [place + d * s * np.eye(3)[i] for i in range(3) for s in (1, -1)]
    m = motion(waves, at, t)
    v = m["velocity"].reshape(3, 2, 3)
    gradient = (v[:, 0] - v[:, 1]) / (2 * d)  # (derivative along, component)
    assert np.trace(gradient) == pytest.approx(0, abs=1e-6)
    assert gradient - gradient.T == pytest.approx(np.zeros((3, 3)), abs=1e-6)
    push = m["head"].reshape(3, 2)
    here = motion(waves, place, t)
    assert here["acceleration"][0] == pytest.approx(-G * (push[:, 0] - push[:, 1]) / (2 * d), abs=2e-5)
    later, before = (motion(waves, place, t + s * 1e-3)["velocity"][0] for s in (1, -1))
    assert here["acceleration"][0] == pytest.approx((later - before) / 2e-3, abs=1e-5)


def test_surface_moves_with_its_water() -> None:
    """At z = 0 the vertical velocity is the rate of the elevation."""
    waves = sea(SYSTEMS["jonswap"])
    x, y, t, d = 5.0, 6.0, 70.0, 1e-3
    rate = (elevation(waves, x, y, t + d) - elevation(waves, x, y, t - d)) / (2 * d)
    assert motion(waves, (x, y, 0.0), t)["velocity"][0, 2] == pytest.approx(float(rate), abs=1e-5)


def test_wheeler_stretching_carries_the_surface_values_to_the_crest() -> None:
    waves = sea(RegularWavesConfig(height_m=2, period_s=8))
    w, k = 2 * np.pi / 8, (2 * np.pi / 8) ** 2 / G
    stretched = motion(waves, [(0, 0, 1.0), (0, 0, 0.0), (0, 0, 5.0)], 0.0, stretch=True)["velocity"][:, 0]
    assert stretched == pytest.approx([w, w * np.exp(-k), w], rel=1e-12)
    shallow = sea(RegularWavesConfig(height_m=2, period_s=8), depth=10.0)
    m = motion(shallow, [(0, 0, -10.0), (0, 0, 1.0)], 0.0, stretch=True)["velocity"]
    plain = motion(shallow, [(0, 0, -10.0), (0, 0, 0.0)], 0.0)["velocity"]
    assert m == pytest.approx(plain, abs=1e-12)


def test_head_in_one_pass_is_the_same() -> None:
    waves = sea(SYSTEMS["jonswap"], depth=30.0)
    p = np.array([(1.0, 2, -3), (40, -7, -0.1), (3, 3, -29.0)])
    height, head = waves.head(jit.Array3f64(np.ascontiguousarray(p.T)), jit.Float64(9.0))
    m = motion(waves, p, 9.0)
    assert np.array(height) == pytest.approx(m["elevation"], abs=1e-12)
    assert np.array(head) == pytest.approx(m["head"], abs=1e-12)


def test_deep_down_it_is_quiet() -> None:
    """At half a wave length the orbit is e^{-pi} = 4.3 % of the surface's."""
    waves = sea(RegularWavesConfig(height_m=2, period_s=8))
    length = G * 64 / (2 * np.pi)
    m = motion(waves, [(0, 0, 0.0), (0, 0, -length / 2)], 0.0)["velocity"]
    assert m[1, 0] / m[0, 0] == pytest.approx(np.exp(-np.pi), rel=1e-9)


def test_free_particle_drifts_as_stokes_says() -> None:
    """u = a^2 omega k e^{2kz} (G. G. Stokes 1847), for a small wave; corrections are of order (ka)^2 = 0.06 % here.

    Runge-Kutta, 100 steps a period, 20 periods; linear theory without stretching.
    """
    waves = sea(RegularWavesConfig(height_m=0.2, period_s=4, towards_deg=0))
    k, w, a = (2 * np.pi / 4) ** 2 / G, 2 * np.pi / 4, 0.1
    velocity = jit.freeze(lambda wv, p, t: wv.motion(p, t, stretch=False).velocity)
    h, p, t = 0.04, jit.Array3f64(0.0, 0.0, [-1.0, -2.0]), 0.0

    def u(q, time):
        return velocity(waves, q, jit.Float64(time))

    for _ in range(2000):
        k1 = u(p, t)
        k2 = u(p + h / 2 * k1, t + h / 2)
        k3 = u(p + h / 2 * k2, t + h / 2)
        k4 = u(p + h * k3, t + h)
        p, t = p + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), t + h
    for start, x in zip((-1.0, -2.0), np.array(p)[0], strict=True):
        middle = start - a * np.exp(k * start)  # it starts under a crest, at the top of its orbit
        drift = x + a * np.exp(k * middle) * np.sin(k * x)  # the crest has moved on less than 20 waves past it
        assert drift / t == pytest.approx(a * a * w * k * np.exp(2 * k * middle), rel=0.005)


@pytest.mark.parametrize("depth", [None, 9.0])
def test_stretching_leaves_the_stokes_drift_of_water_below_it(depth) -> None:
    """`Ocean.flow`'s motion carries water at 3 m, in waves of 1 m, with Stokes: a^2 w k cosh 2k(z + h) / 2 sinh^2 kh.

    Corrections of order (ka)^2 = 1 %, the middle of its way 1 %. Stretched at all depths it goes against the waves.
    """
    waves = sea(RegularWavesConfig(height_m=1.0, period_s=5, towards_deg=0), depth=depth)
    w, a = 2 * np.pi / 5, 0.5
    k = float(np.array(waves.table).reshape(-1, 8)[0, 5])
    velocity = jit.freeze(lambda wv, p, t: wv.motion(p, t).velocity)
    h, p = 0.05, jit.Array3f64(0.0, 0.0, -3.0)
    places = []
    for i in range(1000):
        t = i * h
        k1 = velocity(waves, p, jit.Float64(t))
        p = p + h * velocity(waves, p + h / 2 * k1, jit.Float64(t + h / 2))
        dr.eval(p)
        places.append(np.array(p).ravel())
    x, z = np.array(places)[:, 0], np.array(places)[:, 2].mean()
    drift = (x[-100:].mean() - x[:100].mean()) / (h * 900)
    if depth is None:
        stokes = a * a * w * k * np.exp(2 * k * z)
    else:
        stokes = a * a * w * k * np.cosh(2 * k * (z + depth)) / (2 * np.sinh(k * depth) ** 2)
    assert drift == pytest.approx(stokes, rel=0.05)


def test_slope_is_the_derivative() -> None:
    waves = sea(SYSTEMS["jonswap"])
    sx, sy = waves.slope(jit.Float64(3.0), jit.Float64(4.0), jit.Float64(5.0))
    d = 1e-4
    dx = (elevation(waves, 3 + d, 4, 5) - elevation(waves, 3 - d, 4, 5)) / (2 * d)
    dy = (elevation(waves, 3, 4 + d, 5) - elevation(waves, 3, 4 - d, 5)) / (2 * d)
    assert np.array(sx)[0] == pytest.approx(float(dx), abs=1e-7)
    assert np.array(sy)[0] == pytest.approx(float(dy), abs=1e-7)


def test_choppy_surface() -> None:
    """Gerstner's wave: points move on circles, crests are sharper than troughs, and the normal is that of the
    surface.
    """
    waves = sea(RegularWavesConfig(height_m=3, period_s=8))
    x = np.linspace(-50, 50, 2001)
    zero = jit.Float64(np.zeros(2001))
    p = waves.surface_point(jit.Float64(x), zero, jit.Float64(0.0))
    d, normal = np.array(p.displacement), np.array(p.normal)
    k = (2 * np.pi / 8) ** 2 / G
    assert d[0] == pytest.approx(-1.5 * np.sin(k * x), abs=1e-9)
    assert d[2] == pytest.approx(1.5 * np.cos(k * x), abs=1e-9)
    along = np.gradient(np.stack([x + d[0], d[2]]), x, axis=1)
    assert normal[0, 1:-1] * along[0, 1:-1] + normal[2, 1:-1] * along[1, 1:-1] == pytest.approx(0, abs=1e-6)
    assert np.array(p.fold) == pytest.approx(1 - 1.5 * k * np.cos(k * x), abs=1e-9)
    flat = waves.surface_point(jit.Float64(x), zero, jit.Float64(0.0), choppiness=0.0)
    assert np.abs(np.array(flat.displacement)[:2]).max() == 0
    assert np.array(flat.fold) == pytest.approx(1)


def test_patch_is_the_direct_sum() -> None:
    waves = sea(SYSTEMS["jonswap"])
    x, y = np.linspace(-60, 60, 33), np.linspace(10, 90, 17)
    assert patch(table(waves), x, y, 55.5) == pytest.approx(elevation(waves, x[:, None], y[None, :], 55.5), abs=1e-9)


def test_energy_of_the_sum_is_conserved() -> None:
    """Mean of eta^2 over a large area does not change with time: 400 x 400 points over 4 km, 60 waves across: 3 %."""
    waves = sea(SYSTEMS["jonswap"])
    line = np.linspace(0, 4000, 400)
    energy = [np.mean(patch(table(waves), line, line, t) ** 2) for t in (0.0, 100.0, 5000.0)]
    assert energy == pytest.approx([0.25] * 3, rel=0.05)


def test_calm_and_bad_seas() -> None:
    assert make_waves((SeaStateWavesConfig(state=0),), SITE, depth=None) is None
    assert make_waves((), SITE, depth=None) is None
    with pytest.raises(ValueError, match="somewhere positive"):
        TableWavesConfig(frequency_hz=(0.1, 0.2), density_m2phz=(0, 0))
    with pytest.raises(ValueError, match="increase"):
        TableWavesConfig(frequency_hz=(0.2, 0.1), density_m2phz=(1, 1))
    with pytest.raises(ValueError, match="greater than 0"):
        JonswapWavesConfig(significant_height_m=0, peak_period_s=8)


def test_a_spectrum_without_energy_is_no_sea() -> None:
    class Flat(JonswapWavesConfig):
        def density(self, f: np.ndarray, depth: float | None) -> np.ndarray:
            return np.zeros_like(f)

    spectrum = Flat(significant_height_m=1.3, peak_period_s=7.0)
    with pytest.raises(ValueError, match=r"no energy between 0\.\d+ and \d\.\d+ Hz"):
        spectrum.components(np.random.default_rng(3), 40.0)
