"""Currents, tracers and water masses against their formulas; drifting bodies against analytic paths."""

import gsw
import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.ocean.config import OceanConfig, build_ocean


def ocean(**config):
    return build_ocean(OceanConfig.model_validate(config))


def points(*rows):
    return jit.Array3f64(np.ascontiguousarray(np.array(rows, dtype=float).T))


def current(sea, *rows, t=0.0) -> np.ndarray:
    return np.broadcast_to(np.array(sea.current(points(*rows), jit.Float64(t))).T, (len(rows), 3))


def gradient(sea, place, t=0.0, d=1e-3) -> np.ndarray:
    at = [np.array(place) + d * s * np.eye(3)[i] for i in range(3) for s in (1, -1)]
    v = current(sea, *at, t=t).reshape(3, 2, 3)
    return (v[:, 0] - v[:, 1]) / (2 * d)


def test_still_water() -> None:
    assert current(ocean(), (1, 2, -3)) == pytest.approx(np.zeros((1, 3)))


@pytest.mark.parametrize(("towards", "expected"), [(0, (1, 0)), (90, (0, -1)), (180, (-1, 0)), (-90, (0, 1))])
def test_uniform_goes_where_the_compass_says(towards, expected) -> None:
    sea = ocean(currents={"type": "uniform", "speed_mps": 1.0, "towards_deg": towards, "up_mps": 0.1})
    assert current(sea, (5, 6, -7))[0] == pytest.approx([*expected, 0.1], abs=1e-12)


def test_profile_is_exact_at_its_rows_and_linear_between() -> None:
    depth, speed, towards = [0, 10, 35], [1.0, 0.4, 0.2], [0, 0, 90]
    sea = ocean(currents={"type": "profile", "depth_m": depth, "speed_mps": speed, "towards_deg": towards})
    found = current(sea, (0, 0, 3), (0, 0, 0), (9, 9, -10), (0, 0, -5), (0, 0, -35), (0, 0, -900))
    assert found[:, 0] == pytest.approx([1, 1, 0.4, 0.7, 0, 0], abs=1e-15)
    assert found[:, 1] == pytest.approx([0, 0, 0, 0, -0.2, -0.2], abs=1e-15)


def test_sum_of_components() -> None:
    a = {"type": "uniform", "speed_mps": 0.3, "towards_deg": 40}
    b = {"type": "shear", "speed_mps": 0.5, "per_m": -0.01, "towards_deg": 120}
    rows = [(1, 2, -3), (0, 0, -50)]
    both = current(ocean(currents=[a, b]), *rows)
    assert both == pytest.approx(current(ocean(currents=[a]), *rows) + current(ocean(currents=[b]), *rows))
    assert np.linalg.norm(current(ocean(currents=[b]), (0, 0, -50))) == pytest.approx(0.0, abs=1e-12)


def test_tide_runs_around_its_ellipse() -> None:
    sea = ocean(currents={"type": "tidal", "constituent": "M2", "speed_mps": 1.0, "across_mps": 0.3, "towards_deg": 90})
    quarter = 12.4206012 * 3600 / 4
    path = [current(sea, (0, 0, 0), t=n * quarter)[0] for n in range(5)]
    assert path == pytest.approx(np.array([(0, -1, 0), (0.3, 0, 0), (0, 1, 0), (-0.3, 0, 0), (0, -1, 0)]), abs=1e-9)


def test_vortex() -> None:
    """Fastest at its radius, there as fast as asked; solid inside; circulation far away that of Lamb and Oseen."""
    sea = ocean(currents={"type": "vortex", "center_m": (10, -20), "radius_m": 50, "speed_mps": 0.8})
    radii = np.array([1e-3, 10, 49, 50, 51, 400])
    v = current(sea, *[(10 + r, -20, -5) for r in radii])
    assert np.abs(v[:, 0]).max() == pytest.approx(0, abs=1e-15)
    assert v[3, 1] == pytest.approx(0.8, rel=1e-9)
    assert v[3, 1] > max(v[2, 1], v[4, 1])
    assert v[5, 1] == pytest.approx(0.8 * 50 / 400 / (1 - np.exp(-1.25643)), rel=1e-4)
    assert v[0, 1] / 1e-3 == pytest.approx(0.8 / 50 * 1.25643 / (1 - np.exp(-1.25643)), rel=1e-4)


def test_vortex_drifts() -> None:
    config = {"type": "vortex", "radius_m": 50, "speed_mps": 0.8, "drift_mps": 0.5, "drift_towards_deg": 0}
    sea = ocean(currents=config)
    assert current(sea, (150, 0, 0), t=200.0) == pytest.approx(current(sea, (50, 0, 0)))


def test_jet() -> None:
    sea = ocean(currents={"type": "jet", "speed_mps": 1.2, "width_m": 30, "towards_deg": 0, "depth_m": 100})
    v = current(sea, (7, 0, 0), (7, 30, 0), (7, -30, 0), (7, 0, -100), (7, 1e5, 0))
    sech2 = 1 / np.cosh(1) ** 2
    assert v[:, 0] == pytest.approx([1.2, 1.2 * sech2, 1.2 * sech2, 1.2 / np.e, 0], abs=1e-12)


@pytest.mark.parametrize(
    "config",
    [
        {"type": "vortex", "radius_m": 20, "speed_mps": 1},
        {"type": "jet", "speed_mps": 1, "width_m": 30, "towards_deg": 33},
        {"type": "gyre", "radius_m": 100, "period_s": 600},
        {"type": "turbulence", "rms_mps": 0.2, "largest_m": 30, "smallest_m": 3},
    ],
)
def test_no_divergence(config) -> None:
    """Central differences over 2 mm: error k^2 d^2 / 6 of the gradient, 1e-6 of 1/s."""
    g = gradient(ocean(currents=config), (7.0, 11.0, -4.0), t=12.0)
    assert np.abs(g).max() > 1e-4
    assert np.trace(g) == pytest.approx(0, abs=2e-6)


def test_drifter_in_a_gyre_goes_round_in_its_period() -> None:
    """dx/dt = v(x): a circle of period 600 s. Runge-Kutta with 600 steps is exact to 1e-8."""
    sea = ocean(currents={"type": "gyre", "center_m": (5, 5), "radius_m": 100, "period_s": 600})
    step = jit.freeze(lambda o, p, t, h: _runge_kutta(o, p, t, h))
    p, h = points((45, 5, -3), (5, 25, -3)), jit.Float64(1.0)
    for n in range(150):
        p = step(sea, p, jit.Float64(float(n)), h)
    assert pytest.approx(np.array([(5, 45, -3), (-15, 5, -3)]), abs=1e-6) == np.array(p).T
    for n in range(150, 600):
        p = step(sea, p, jit.Float64(float(n)), h)
    assert pytest.approx(np.array([(45, 5, -3), (5, 25, -3)]), abs=1e-6) == np.array(p).T
    assert np.linalg.norm(current(sea, (205, 5, 0))) == pytest.approx(2 * np.pi / 600 * 100**2 / 200)


def _runge_kutta(sea, p, t, h):
    k1 = sea.current(p, t)
    k2 = sea.current(p + h / 2 * k1, t + h / 2)
    k3 = sea.current(p + h / 2 * k2, t + h / 2)
    k4 = sea.current(p + h * k3, t + h)
    return p + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def test_turbulence_has_its_strength_and_its_spectrum() -> None:
    """Mean over 40 000 places of a field of 256 modes: a mode's square is known to 10 %; five thirds law between the
    sizes.
    """
    sea = ocean(currents={"type": "turbulence", "rms_mps": 0.2, "largest_m": 40, "smallest_m": 2, "modes": 256})
    rng = np.random.default_rng(1)
    v = current(sea, *rng.uniform(-3000, 3000, (40_000, 3)))
    assert np.sqrt(np.mean(v**2, axis=0)) == pytest.approx([0.2] * 3, rel=0.1)
    assert np.abs(v.mean(axis=0)).max() < 0.01
    wide = ocean(currents={"type": "turbulence", "rms_mps": 0.2, "largest_m": 2000, "smallest_m": 1, "modes": 512})
    base = rng.uniform(-30_000, 30_000, (20_000, 3))
    here = current(wide, *base)
    structure = [np.mean((current(wide, *(base + np.array([r, 0, 0]))) - here)[:, 0] ** 2) for r in (8.0, 32.0)]
    assert np.log(structure[1] / structure[0]) / np.log(4) == pytest.approx(2 / 3, abs=0.15)


def test_python_function() -> None:
    sea = ocean(currents={"type": "python", "function": f"{__name__}:swirl"})
    assert current(sea, (1, 2, -3), t=2.0)[0] == pytest.approx([-2 * 2, 1 * 2, 0])
    for name, message in [
        ("nowhere:f", "imported"),
        (f"{__name__}:missing", "imported"),
        (f"{__name__}:broken", "failed"),
    ]:
        with pytest.raises(ScenarioError, match=message):
            ocean(currents={"type": "python", "function": name})
    with pytest.raises(ScenarioError, match="not finite"):
        ocean(currents={"type": "python", "function": f"{__name__}:infinite"})


SPEEDS = [0.5]
factor = 2.0


def test_functions_that_read_from_outside_of_themselves_are_refused() -> None:
    """Recorded once, they would go on with the first value."""
    for name, reads in (("indirect", "SPEEDS, factor"), ("listed", "SPEEDS"), ("closed", "held"), ("lost", "not_here")):
        with pytest.raises(ScenarioError, match=f"reads {reads} from outside"):
            ocean(currents={"type": "python", "function": f"{__name__}:{name}"})
    with pytest.raises(ScenarioError, match="reads factor from outside"):
        ocean(tracers={"oxygen": [{"type": "python", "function": f"{__name__}:scaled"}]})
    assert current(ocean(currents={"type": "python", "function": f"{__name__}:pure"}), (1, 2, -3))[0, 0] == 2.5


def listed(position, t):
    return jit.Array3f64(sum(s for s in SPEEDS), 0.0, 0.0)


def lost(position, t, depth=0):
    return lost(position, t, 1) if depth else not_here * position  # noqa: F821


def scaled(position, t):
    return factor * t


def indirect(position, t):
    return listed(position, t) * scaled(position, jit.Float64(1.0))


def pure(position, t, speed=2.5):
    return jit.Array3f64(max(speed, np.float64(0.0)), 0.0, 0.0)


def _closed(held):
    return lambda position, t: jit.Array3f64(held, 0.0, 0.0)


closed = _closed(0.3)


def swirl(position, t):
    return jit.Array3f64(-position[1] * t, position[0] * t, 0.0)


def broken(position, t):
    raise KeyError("wrong")


def infinite(position, t):
    return position / 0.0


def test_tracers() -> None:
    config = {
        "oxygen": 250.0,
        "chlorophyll": {"depth_m": [0, 10, 50], "value": [1.0, 3.0, 0.1]},
        "mixed": [
            {"type": "uniform", "value": 1.0},
            {"type": "gradient", "per_m": 0.01, "towards_deg": 90, "per_m_down": 0.1},
            {"type": "oscillation", "amplitude": 2.0, "period_h": 1.0},
            {"type": "patch", "center_m": [0, 0, -10], "radius_m": 5, "height_m": 2, "value": 4.0},
            {"type": "front", "step": 3.0, "width_m": 10, "towards_deg": 0},
        ],
    }
    sea = ocean(tracers=config)
    place, t = points((3, -100, -10), (20, 0, -60)), jit.Float64(900.0)

    def value(name):
        return np.broadcast_to(np.array(sea.tracer(name, place, t)), 2)

    assert value("oxygen") == pytest.approx([250, 250])
    assert value("chlorophyll") == pytest.approx([3.0, 0.1])
    expected = [1 + 1 + 1 + 0 + 4 * np.exp(-0.5 * (9 + 1e4) / 25) + 1.5 * (1 + np.tanh(0.6)), 1 + 0 + 6 + 0 + 0 + 3]
    assert value("mixed") == pytest.approx(expected, abs=2e-3)
    with pytest.raises(LookupFailed, match="did you mean 'oxygen'"):
        sea.tracer("oxygn", place, t)


def test_steady_plume_carries_what_its_source_gives() -> None:
    """The flux u C through any plane across the stream is the rate; the half at the surface comes back from its
    image.
    """
    plume = {"type": "plume", "source_m": [0, 0, -8], "rate": 2.0, "speed_mps": 0.25, "towards_deg": 0,
             "spread_m2ps": 0.05, "spread_up_m2ps": 0.02}  # fmt: skip
    sea = ocean(tracers={"dye": [plume]})
    y, z = np.linspace(-40, 40, 161), np.linspace(-40, 0, 161)
    yy, zz = np.meshgrid(y, z, indexing="ij")
    for x in (20.0, 200.0):
        place = points(*np.stack([np.full(yy.size, x), yy.ravel(), zz.ravel()], -1))
        c = np.array(sea.tracer("dye", place, jit.Float64(0.0))).reshape(yy.shape)
        assert 0.25 * trapezoid(trapezoid(c, z, axis=1), y) == pytest.approx(2.0, rel=2e-3)
    assert np.array(sea.tracer("dye", points((-5, 0, -8)), jit.Float64(0.0)))[0] == 0


def test_drifting_plume_follows_the_current_and_conserves_its_content() -> None:
    """In a uniform stream the cloud is the steady plume behind its front; in all it holds rate x time."""
    stream = {"type": "uniform", "speed_mps": 0.5, "towards_deg": 0}
    source = {"source_m": [0, 0, -20], "rate": 3.0, "spread_m2ps": 0.1, "spread_up_m2ps": 0.02}
    drifting = {"type": "drifting_plume", "duration_s": 600, "puffs": 300, **source}
    steady = {"type": "plume", "speed_mps": 0.5, "towards_deg": 0, **source}
    sea = ocean(currents=[stream], tracers={"drifting": [drifting], "steady": [steady]})
    place = points((60, 0, -20), (100, 5, -18), (150, -4, -20))
    a, b = (np.array(sea.tracer(name, place, jit.Float64(600.0))) for name in ("drifting", "steady"))
    assert a == pytest.approx(b, rel=0.03)
    x, y, z = np.linspace(-20, 220, 121), np.linspace(-50, 50, 41), np.linspace(-60, 0, 41)
    grid = np.stack([g.ravel() for g in np.meshgrid(x, y, z, indexing="ij")], -1)
    c = np.array(sea.tracer("drifting", points(*grid), jit.Float64(300.0))).reshape(121, 41, 41)
    content = trapezoid(trapezoid(trapezoid(c, z, axis=2), y, axis=1), x)
    assert content == pytest.approx(3.0 * 300, rel=0.02)
    assert np.array(sea.tracer("drifting", points((250, 0, -20)), jit.Float64(300.0)))[0] < 1e-6


def test_currents_carry_a_plume_of_warm_or_fresh_water_as_any_other() -> None:
    """On top of an even field, 3 units of a tracer a second are 3 m^3/s that are 1 degC warmer, or 1 saltier."""
    stream = {"type": "uniform", "speed_mps": 0.5, "towards_deg": 0}
    plume = {"type": "drifting_plume", "duration_s": 600, "puffs": 60, "source_m": [0, 0, -20], "rate": 3.0,
             "spread_m2ps": 0.1, "spread_up_m2ps": 0.02}  # fmt: skip
    even = lambda value: {"type": "uniform", "value": value}
    sea = ocean(
        currents=[stream], tracers={"dye": [plume]}, temperature_c=[even(10), plume], salinity=[even(35), plume]
    )
    place, t = points((60, 0, -20), (100, 5, -18), (-20, 0, -20)), jit.Float64(600.0)
    dye = np.array(sea.tracer("dye", place, t))
    assert dye[0] > 0.05
    assert dye[2] < 1e-3
    assert np.array(sea.temperature(place, t)) - 10 == pytest.approx(dye, abs=1e-9)
    assert np.array(sea.salinity(place, t)) - 35 == pytest.approx(dye, abs=1e-9)


@pytest.mark.parametrize("depth", [None, 12.0])
def test_drifting_plume_goes_with_the_stokes_drift_of_waves(depth: float | None) -> None:
    """Its middle moves at the current and sum a^2 omega k cosh 2k(z + h)/(2 sinh^2 kh) together (Stokes 1847).

    A cloud released at once moves as its source's depth does; the sheared spread of 0.1 m moves the mean by 1 %.
    """
    waves = [{"type": "regular", "height_m": 1.2, "period_s": 5.0, "towards_deg": 30},
             {"type": "regular", "height_m": 0.8, "period_s": 7.0, "towards_deg": -70}]  # fmt: skip
    stream = {"type": "uniform", "speed_mps": 0.02, "towards_deg": 200}
    source = {"source_m": [3, -2, -3], "rate": 3.0, "spread_m2ps": 0.01, "spread_up_m2ps": 1e-6, "initial_m": 0.5}
    plume = {"type": "drifting_plume", "duration_s": 400, "puffs": 1000, **source}
    sea = ocean(currents=[stream], waves=waves, waves_depth_m=depth, tracers={"dye": [plume]})
    expected = np.array([0.02 * np.cos(np.deg2rad(200)), -0.02 * np.sin(np.deg2rad(200))])
    for wave in waves:
        a, omega, towards = wave["height_m"] / 2, 2 * np.pi / wave["period_s"], np.deg2rad(wave["towards_deg"])
        k = omega**2 / 9.80665
        for _ in range(200 if depth else 0):
            k = 0.5 * (k + omega**2 / 9.80665 / np.tanh(k * depth))
        profile = np.exp(-6 * k) if depth is None else np.cosh(2 * k * (depth - 3)) / (2 * np.sinh(k * depth) ** 2)
        expected += a * a * omega * k * profile * np.array([np.cos(towards), -np.sin(towards)])
    x = np.linspace(-20, 60, 161)
    grid = np.stack([g.ravel() for g in np.meshgrid(x, x, [-3.0], indexing="ij")], -1)
    c = np.array(sea.tracer("dye", points(*grid), jit.Float64(400.0)))
    middle = (c[:, None] * grid[:, :2]).sum(axis=0) / c.sum()  # of puffs of all ages, evenly
    assert (middle - (3, -2)) / 200 == pytest.approx(expected, rel=0.02, abs=2e-4)


@pytest.mark.parametrize("form", ["column", "mass"])
def test_water_is_that_of_teos10(form: str) -> None:
    """gsw itself at the same place (its pressure from depth is that of the standard ocean: 1e-6 of density)."""
    depth, t, s = [0, 30, 200, 4000], [20.0, 14.0, 8.0, 2.0], [36.0, 36.5, 35.5, 34.7]
    temperature, salinity = {"depth_m": depth, "value": t}, {"depth_m": depth, "value": s}
    if form == "mass":
        temperature, salinity = [{"type": "profile", **temperature}], [{"type": "profile", **salinity}]
    sea = ocean(temperature_c=temperature, salinity=salinity)
    z = -np.array([0.0, 12.3, 30.0, 777.7, 3333.3])
    place, time = points(*np.stack([0 * z, 0 * z, z], -1)), jit.Float64(0.0)
    p = gsw.p_from_z(z, 45.0)
    sp, ts = np.interp(-z, depth, s), np.interp(-z, depth, t)
    sa = gsw.SA_from_SP(sp, p, -30.0, 45.0)
    ct = gsw.CT_from_t(sa, ts, p)
    loose = form == "mass"
    assert np.array(sea.temperature(place, time)) == pytest.approx(ts, abs=2e-3)
    assert np.array(sea.salinity(place, time)) == pytest.approx(sp, abs=2e-4)
    assert np.array(sea.density(place, time)) == pytest.approx(gsw.rho(sa, ct, p), abs=3e-3 if loose else 1e-3)
    assert np.array(sea.sound_speed(place, time)) == pytest.approx(
        gsw.sound_speed(sa, ct, p), abs=0.03 if loose else 0.01
    )


def test_density_of_a_front_varies_across_it() -> None:
    fresh = [{"type": "uniform", "value": 30.0}, {"type": "front", "step": 8.0, "width_m": 20, "towards_deg": 0}]
    sea = ocean(salinity=fresh, temperature_c=15.0)
    rho = np.array(sea.density(points((-100, 0, -1), (0, 0, -1), (100, 0, -1)), jit.Float64(0.0)))
    assert rho == pytest.approx([1022.1, 1025.2, 1028.3], abs=0.15)


def test_pressure_under_a_wave_and_in_the_air() -> None:
    sea = ocean(
        waves={"type": "regular", "height_m": 2.0, "period_s": 8.0}, tide={"constituent": "M2", "amplitude_m": 0.5}
    )
    k = (2 * np.pi / 8) ** 2 / 9.81
    found = np.array(sea.pressure(points((0, 0, 1.4), (0, 0, 1.6), (0, 0, -4.5)), jit.Float64(0.0)))
    weight = 1026.59 * 9.8066
    assert found == pytest.approx(np.array([0.1, 0.0, 5 + np.exp(-5 * k)]) * weight, rel=5e-4, abs=1)
    assert np.array(sea.elevation(jit.Float64(0.0), jit.Float64(0.0), jit.Float64(0.0)))[0] == pytest.approx(1.5)


def test_wind_profile_and_gusts() -> None:
    """NPD: 10 m/s at 10 m is 10 (1 + 0.0573 sqrt(2.5) ln 2) at 20 m; gusts have the spectrum's variance, about (1.5
    m/s)^2.
    """
    steady = ocean(wind={"speed_mps": 10, "from_deg": 270})
    v = np.array(steady.wind(points((0, 0, 10), (0, 0, 20), (0, 0, 0)), jit.Float64(0.0))).T
    assert v[0] == pytest.approx([0, -10, 0], abs=1e-12)
    assert v[1, 1] == pytest.approx(-10 * (1 + 0.0573 * np.sqrt(2.5) * np.log(2)))
    gusty = ocean(wind={"speed_mps": 10, "from_deg": 0, "gusts": 1.0})
    t = jit.Float64(np.arange(0, 20_000, 2.0))
    record = np.array(gusty.wind(jit.Array3f64(0.0, 0.0, 10.0), t))[0]
    f = np.geomspace(1 / 1800, 0.5, 4000)
    reduced = 172 * f
    variance = trapezoid(320 / (1 + reduced**0.468) ** (5 / (3 * 0.468)), f)
    assert record.mean() == pytest.approx(-10, abs=0.1)
    assert record.var() == pytest.approx(variance, rel=0.1)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"currents": {"type": "uniform", "speed_mps": -1}}, "greater than or equal to 0"),
        ({"currents": {"type": "unifrom", "speed_mps": 1}}, "uniform"),
        ({"currents": {"type": "gyre", "radius_m": 5, "period_s": 0}}, "cannot be 0"),
        ({"currents": {"type": "tidal", "speed_mps": 1}}, "constituent"),
        ({"currents": {"type": "tidal", "speed_mps": 1, "constituent": "M2", "period_h": 12.0}}, "give either"),
        (
            {"currents": {"type": "profile", "depth_m": [0, 5], "speed_mps": [1], "towards_deg": [0, 0]}},
            "(at least 2|rows)",
        ),
        (
            {"currents": {"type": "profile", "depth_m": [0, 5, 9], "speed_mps": [1, 2], "towards_deg": [0, 0, 0]}},
            "depth_m, speed_mps and towards_deg must have the same number of rows, not 3, 2 and 3",
        ),
        (
            {"currents": {"type": "profile", "depth_m": [0, 5], "speed_mps": [1, 2], "towards_deg": [0, 0, 0]}},
            "the same number of rows, not 2, 2 and 3",
        ),
        (
            {"temperature_c": {"depth_m": [0, 5, 9], "value": [9, 8]}},
            "depth_m has 3 rows, value 2; they must be as many",
        ),
        (
            {"waves": {"type": "table", "frequency_hz": [0.1, 0.2, 0.3], "density_m2phz": [1, 2]}},
            "frequency_hz and density_m2phz must have as many entries, not 3 and 2",
        ),
        ({"currents": {"type": "profile", "depth_m": [5, 0], "speed_mps": [1, 1], "towards_deg": [0, 0]}}, "increase"),
        ({"currents": {"type": "turbulence", "rms_mps": 1, "largest_m": 1, "smallest_m": 2}}, "larger"),
        ({"temperature_c": 200}, "between -3 and 45"),
        ({"temperature_c": float("nan")}, "finite|between"),
        ({"salinity": -1}, "between 0 and 42"),
        ({"water_type": "IX"}, "did you mean"),
        ({"waves": {"type": "tma", "significant_height_m": 1, "peak_period_s": 5}}, "waves_depth_m"),
        ({"waves": {"type": "jonswap", "significant_height_m": 1, "peak_period_s": 5}, "waves_depth_m": 0}, "greater"),
        ({"waves": {"type": "sea_state", "state": 12}}, "less than or equal to 9"),
        ({"wind": {"speed_mps": float("inf")}}, "finite|less than"),
        ({"tides": []}, "tides"),
    ],
)
def test_bad_oceans(config, message) -> None:
    with pytest.raises(ValueError, match=message):
        OceanConfig.model_validate(config)


def test_configuration_round_trips_and_frozen_equals_plain() -> None:
    config = OceanConfig.model_validate(
        {
            "currents": [{"type": "uniform", "speed_mps": 0.2}, {"type": "turbulence", "rms_mps": 0.1}],
            "waves": [{"type": "jonswap", "significant_height_m": 1, "peak_period_s": 6}],
            "temperature_c": {"depth_m": [0, 100], "value": [20, 10]},
            "tracers": {"dye": [{"type": "patch", "center_m": [0, 0, 0], "radius_m": 1, "height_m": 1, "value": 1}]},
        }
    )
    assert OceanConfig.model_validate_json(config.model_dump_json()) == config
    sea = build_ocean(config)

    def everything(o, p, t):
        return [*o.flow(p, t), o.density(p, t), o.pressure(p, t), o.tracer("dye", p, t), o.elevation(p[0], p[1], t)]

    place, t = points((1, 2, -3), (40, 50, -6), (0, 0, 0.2)), jit.Float64(12.5)
    frozen = jit.freeze(everything)
    frozen(sea, place, t)
    for a, b in zip(frozen(sea, place, t), everything(sea, place, t), strict=True):
        assert np.array_equal(np.array(a), np.array(b))
