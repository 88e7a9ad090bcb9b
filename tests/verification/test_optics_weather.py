"""Fog, rain, clouds and the sun's place against published numbers and what they must conserve."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta, timezone
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import trapezoid

from oceans import lit_ocean
from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.sky import SunConfig, WeatherConfig
from pelagos.optics.atmosphere import Weather, fog_extinction, rain_extinction, under_weather
from pelagos.optics.rain import drops_per_m3, fall_speed, median_diameter, streaks
from pelagos.optics.sun_position import sun_position
from pelagos.optics.sunlight import daylight, sky_radiance
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.lidar.lidar import Lidar, LidarConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables


def test_the_sun_stands_where_nrel_says():
    """The worked example of I. Reda and A. Andreas, NREL/TP-560-34302: zenith 50.11162, azimuth 194.34024 deg.

    Michalsky's approximation claims 0.01 deg; NREL's refraction is of 820 mbar, 0.003 deg less.
    """
    moment = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    elevation, azimuth = sun_position(moment, 39.742476, -105.1786)
    assert math.degrees(elevation) == pytest.approx(90 - 50.11162, abs=0.015)
    assert math.degrees(azimuth) == pytest.approx(194.34024, abs=0.015)


def test_the_sun_is_overhead_at_the_tropic_at_solstice():
    """2026-06-21, near local noon at 23.44 N: declination 23.436 deg."""
    highest = max(sun_position(datetime(2026, 6, 21, 12, m, tzinfo=UTC), 23.44, 0.0)[0] for m in range(10))
    assert math.degrees(highest) == pytest.approx(90.0, abs=0.3)  # the sun moves 0.25 deg a minute


def test_a_scenario_says_where_the_sun_stands_in_one_way():
    origin = GeoOrigin(latitude=45.0, longitude=13.0)
    noon = SunConfig(time="2026-06-21T11:10:00Z")
    assert math.degrees(noon.angles(origin)[0]) == pytest.approx(90 - 45 + 23.44, abs=0.1)
    with pytest.raises(ValidationError, match="either time"):
        SunConfig(time="2026-06-21T11:10:00Z", elevation_deg=40)
    with pytest.raises(ValidationError, match="time zone"):
        SunConfig(time="2026-06-21T11:10:00")


def test_visibility_is_the_way_that_leaves_a_twentieth():
    """WMO-No. 8: the meteorological optical range leaves 5 % of a beam."""
    for visibility in (50.0, 1000.0, 20_000.0):
        assert math.exp(-fog_extinction(visibility) * visibility) == pytest.approx(0.05, rel=1e-12)
    assert fog_extinction(math.inf) == 0.0


@pytest.mark.parametrize(("km", "db_per_km"), [(0.2, 65.05), (0.5, 26.02), (2.0, 4.683), (10.0, 0.681)])
def test_infrared_goes_through_haze_and_not_through_fog(km: float, db_per_km: float):
    """Kim's exponents at 905 nm: none below 500 m, 0.66 at 2 km, 1.3 at 10 km."""
    found = fog_extinction(1000 * km, 905.0) * 1000 * 10 / math.log(10)
    assert found == pytest.approx(db_per_km, rel=1e-3)


@pytest.mark.parametrize(("rate", "db_per_km"), [(0.0, 0.0), (2.5, 1.988), (12.5, 5.844), (25.0, 9.298)])
def test_rain_takes_what_itu_says(rate: float, db_per_km: float):
    """1.076 R^0.67 dB/km (ITU-R P.1814, 2007)."""
    assert rain_extinction(rate) * 1000 * 10 / math.log(10) == pytest.approx(db_per_km, rel=1e-3)


def test_weather_makes_no_light():
    clear = daylight(math.radians(40))
    height = clear.towards_sun[2]
    whole = [s * height + d for s, d in zip(clear.sun, clear.sky, strict=True)]
    for weather in (Weather(visibility=100.0), Weather(rain=50.0), Weather(visibility=2000.0, rain=5.0)):
        below = under_weather(clear, weather)
        for a, s, d, c in zip(whole, below.sun, below.sky, clear.sky, strict=True):
            assert s * height + d < a
            assert d > c
    assert under_weather(clear, Weather()) == clear


@pytest.mark.parametrize(("cloud", "height"), [(0.3, 20.0), (0.7, 50.0)])
def test_broken_clouds_leave_what_kasten_and_czeplak_say(cloud: float, height: float):
    """1 - 0.7 N^3.4 of all light on a level plane, and of the beam that part which 1 - N of the sky lets through."""
    clear, found = (daylight(math.radians(height), cloud=c) for c in (0.0, cloud))
    level, left = math.sin(math.radians(height)), 1 - 0.7 * cloud**3.4
    for sun, sky, beam, grey in zip(clear.sun, clear.sky, found.sun, found.sky, strict=True):
        assert beam == pytest.approx((1 - cloud) * left * sun)
        assert beam * level + grey == pytest.approx(left * (sun * level + sky))


def test_an_overcast_sky_is_brightest_overhead():
    """CIE standard: three times the horizon's radiance; all of the irradiance stays."""
    light = daylight(math.radians(40), cloud=1.0)
    assert max(light.sun) == 0.0
    up = jit.Float([0.0, 1.0])
    seen = np.array(sky_radiance(light.arrays(), jit.Array3f(dr.sqrt(1 - up * up), 0, up)))
    assert seen[:, 1] / seen[:, 0] == pytest.approx([3, 3, 3], rel=1e-5)
    u = (np.arange(2000) + 0.5) / 2000
    d = jit.Array3f(jit.Float(np.sqrt(1 - u * u)), 0, jit.Float(u))
    whole = 2 * math.pi * (np.array(sky_radiance(light.arrays(), d)) * u).mean(axis=1)
    assert whole == pytest.approx(light.sky, rel=1e-3)


def test_drops_carry_the_rain():
    """pi/6 times the integral of N D^3 v over all drops is the rate of rainfall: Marshall and Palmer's spectrum with
    the drops' speeds gives it back within 20 % from 2 to 50 mm/h (too many small drops in light rain, as is known)."""
    for rate in (2.0, 10.0, 50.0):
        slope = 4.1 * rate**-0.21
        d = np.linspace(0.01, 10, 4000)  # [mm]
        speed = np.array(fall_speed(jit.Float64(d * 1e-3)))
        flux = trapezoid(8000 * np.exp(-slope * d) * math.pi / 6 * (d * 1e-3) ** 3 * speed, d)  # [m/s]
        assert flux * 3.6e6 == pytest.approx(rate, rel=0.2)
        inside = np.cumsum(d**3 * np.exp(-slope * d))
        median = np.interp(0.5, inside / inside[-1], d)
        assert float(median_diameter(jit.Float64(rate))[0]) * 1e3 == pytest.approx(median, rel=0.01)


def test_near_drops_cover_what_they_should():
    """Mean over many rays: n dr D^2 for each shell (area n L D of a share D / L each), where drops are wider than
    pixels. 20 %: the mean of some 4000 streaks of one shell each varies by 2 %, edges are soft."""
    rate, exposure, angle = jit.Float(20.0), jit.Float(0.004), 2e-4
    rng = np.random.default_rng(1)
    a, e = rng.uniform(-3.1, 3.1, 400_000), rng.uniform(-0.6, 0.6, 400_000)
    d = jit.Array3f(jit.Float(np.cos(e) * np.cos(a)), jit.Float(np.cos(e) * np.sin(a)), jit.Float(np.sin(e)))
    cover = np.array(streaks(d, jit.Float(0.9), rate, jit.UInt32(7), exposure, angle)).mean()
    diameter = float(median_diameter(rate)[0])
    shells = (0.5, 0.75)  # [m], half as thick as far
    expected = sum(float(drops_per_m3(rate)[0]) * 0.5 * r * diameter**2 for r in shells)
    assert cover == pytest.approx(expected, rel=0.2)


def wall(distance: float, material: str = "black") -> Geometry:
    corners = np.array([[distance, 500, -50], [distance, -500, -50], [distance, -500, 500], [distance, 500, 500]])
    return Geometry(corners.astype(float), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)


def context(geometries: list[Geometry], weather: Weather, material: str = "black") -> SensorContext:
    materials = [MATERIALS[material]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("II", 0.7, 2.8, weather)
    return SensorContext(
        "usv0.camera", 1, 5_000_000, Scene(geometries, copies=1), world, ocean, np.full(1, NO_BODY, np.uint32)
    )


def still(height: float, t: float = 1.0) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero + height), jit.Array4f64(zero + 1, zero, zero, zero), none, none, none, none,
        jit.UInt64(u) + round(t * 1e9), u, u + 0, u + 0,
    )  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def seen(geometries: list[Geometry], weather: Weather, **camera: Any) -> Any:
    """Mean light `(3,)` [cd/m^2] of a narrow view ahead from 3 m above the water, a little upwards."""
    config = CameraConfig(
        width_px=32, height_px=32, horizontal_fov_deg=1.2, vignette=0.0, exposure="manual", max_range_m=5000.0,
        orientation_deg=(0.0, -0.6, 0.0), **camera,
    )  # fmt: skip
    found = {n: v for n, v, _ in Camera(config, context(geometries, weather)).explain(still(3.0))}
    return found["light at the sensor"].mean(axis=1)


@pytest.mark.parametrize("renderer", ["realtime", "reference"])
def test_a_black_wall_at_the_visibility_has_a_contrast_of_a_twentieth(renderer: str):
    """Koschmieder: against the fog at the horizon, 1 - e^{-3 d / V}; the path tracer's likewise."""
    fog = Weather(visibility=300.0)
    horizon = seen([wall(4900.0)], fog)
    for distance in (100.0, 300.0):
        light = seen([wall(distance)], fog, renderer=renderer, samples=16 if renderer == "reference" else 1)
        contrast = 1 - light / horizon
        assert contrast == pytest.approx(np.full(3, 0.05 ** (distance / 300.0)), abs=0.02)


def test_the_sky_at_the_horizon_is_the_fog():
    """No edge between far hills and sky: both are what thick fog looks like, to 1 %."""
    fog = Weather(visibility=300.0)
    assert seen([], fog) == pytest.approx(seen([wall(4900.0)], fog), rel=0.01)


@pytest.mark.parametrize("tilt_deg", [0.0, 35.0, -25.0])
def test_a_wall_above_the_water_is_lit_by_its_share_of_the_sky(tilt_deg: float):
    """Overcast, nothing else in view: albedo E_sky (up + 0.06 (1 - up)) / pi, as if the sky were even; 1 %.

    up = (1 + sin(tilt)) / 2 of a wall that leans away by the tilt: half for an upright one.
    """
    weather = Weather(cloud=1.0)
    light = under_weather(daylight(0.7, -2.8, cloud=1.0), weather)
    config = CameraConfig(width_px=128, height_px=128, horizontal_fov_deg=20, vignette=0.0, exposure="manual")
    tilt, side = math.radians(tilt_deg), np.array([[8.0, -8.0], [-8.0, -8.0], [-8.0, 8.0], [8.0, 8.0]])
    y, z = side.T
    corners = np.stack([20.0 + z * math.sin(tilt), y, 20.0 + z * math.cos(tilt)], axis=1)
    plate = Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)
    camera = Camera(config, context([plate], weather, "white"))
    got = {n: v for n, v, _ in camera.explain(still(20.0))}["light at the sensor"].mean(axis=1)
    up = 0.5 + 0.5 * math.sin(tilt)
    expected = np.array(MATERIALS["white"].albedo) * np.array(light.sky) * (up + 0.06 * (1 - up)) / math.pi
    assert got == pytest.approx(expected, rel=0.01)


def test_rain_is_drawn_before_near_walls_and_repeats():
    config = CameraConfig(width_px=64, height_px=64, exposure="manual", shutter_s=0.001, horizontal_fov_deg=40)
    camera = Camera(config, context([wall(20.0)], Weather(cloud=1.0, rain=50.0)))
    one, two, again = (camera.sense(still(3.0, t)).truth[0].astype(int) for t in (1.0, 1.1, 1.0))
    assert np.array_equal(one, again)
    brighter = one.max(axis=-1) > np.median(one.max(axis=-1)) + 5
    assert 0.001 < brighter.mean() < 0.9
    assert (one != two).any()


def test_a_lidar_sees_less_far_in_fog():
    """exp(-(r + 2 c) d), with c of 905 nm in 100 m visibility the same as that of light."""
    config = LidarConfig(channels=4, points_per_second=4000, range_m=100.0, dropoff_general_rate=0.0, upper_fov_deg=1,
                         lower_fov_deg=0, dropoff_zero_intensity=0.0)  # fmt: skip
    fog, clear = (
        Lidar(config, context([wall(30.0)], weather)).sense(still(3.0)).truth[0].reshape(-1, 4)
        for weather in (Weather(visibility=100.0), Weather())
    )
    there = np.isfinite(clear[:, 0])
    assert there.any()
    d = np.linalg.norm(clear[there, :3], axis=1)
    assert fog[there, 3] / clear[there, 3] == pytest.approx(np.exp(2 * math.log(0.05) / 100 * d), rel=1e-4)


def test_a_flat_port_out_of_the_water_bends_nothing():
    """A parallel plate between air and air shifts rays, and leaves their directions: the picture is the bare lens's."""
    port = {"type": "flat", "distance_m": 0.02, "thickness_m": 0.01}
    options: dict[str, Any] = {
        "width_px": 64,
        "height_px": 48,
        "exposure": "manual",
        "vignette": 0.0,
        "max_range_m": 60.0,
    }
    behind, bare = (
        Camera(CameraConfig(**options, **extra), context([wall(20.0)], Weather())) for extra in ({"port": port}, {})
    )
    a, b = (np.asarray({n: v for n, v, _ in c.explain(still(3.0))}["slant range"], dtype=float) for c in (behind, bare))
    hit = np.isfinite(a) & np.isfinite(b)
    assert hit.any()
    assert a[hit] == pytest.approx(b[hit], abs=0.08)  # starts are up to 3 cm in front and aside


def test_the_waterline_runs_across_a_port():
    """Half in the water: rays of the dome's lower half see water, those of its upper half the sky."""
    config = CameraConfig(
        width_px=64, height_px=64, vignette=0.0, exposure="manual", port={"type": "dome", "radius_m": 0.1}
    )
    found = {n: v for n, v, _ in Camera(config, context([], Weather())).explain(still(0.0))}
    veil = np.asarray(found["veiling light"]).sum(axis=0)
    assert np.isfinite(veil).all()
    assert (veil > 0).mean() == pytest.approx(0.5, abs=0.02)


def test_bad_weather_is_refused():
    for wrong in ({"cloud": 1.5}, {"visibility_m": 1.0}, {"rain_mm_per_h": -1}, {"rain_mm_per_h": math.nan}):
        with pytest.raises(ValidationError):
            WeatherConfig(**wrong)
