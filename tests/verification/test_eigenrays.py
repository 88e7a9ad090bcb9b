"""Rays from a source to a receiver, against closed forms and published numbers.

Sources: F. B. Jensen et al., Computational Ocean Acoustics (2nd ed., 2011); the public tests of UnderwaterAcoustics.jl
(Pekeris) and of AcousticsToolbox.jl (Munk, computed with Bellhop).
"""

import math

import numpy as np
import pytest

from pelagos.acoustics.eigenrays import Arrivals, eigenrays
from pelagos.acoustics.image_sources import paths
from pelagos.acoustics.section import Section, mirrored
from pelagos.acoustics.transmission_loss import field, ray_paths

MUNK_DEPTH = np.arange(0, 5001, 200.0)
MUNK_SPEED = np.array(
    [1548.52, 1530.29, 1526.69, 1517.78, 1509.49, 1504.30, 1501.38, 1500.14, 1500.12, 1501.02, 1502.57, 1504.62,
     1507.02, 1509.69, 1512.55, 1515.56, 1518.67, 1521.85, 1525.10, 1528.38, 1531.70, 1535.04, 1538.39, 1541.76,
     1545.14, 1548.52]
)  # fmt: skip
MUNK = Section(
    MUNK_DEPTH, MUNK_SPEED, np.zeros(1), np.array([5000.0]), sound_speed_ratio=1600 / 1548.52, frequency=50.0
)


def rays_of(section: Section, source: float, receiver: float, distance: float, **options: int) -> Arrivals:
    return eigenrays([section], np.array([source]), np.array([receiver]), np.array([distance]), **options)


def flat(depth: float, speed: float = 1500.0, **bottom: float) -> Section:
    return Section(np.array([0.0, depth]), np.full(2, speed), np.zeros(1), np.array([depth]), **bottom)


@pytest.mark.parametrize("gradient", [0.05, -0.03])
@pytest.mark.parametrize("levels", [2, 9, 60])
def test_linear_profile_gives_circular_arcs(gradient: float, levels: int) -> None:
    """Centre of the circle at the depth where c = 0; chord, time and angles in closed form (Jensen, Eq. 3.60 on).

    cosh(g t) = 1 + g^2 (x^2 + dz^2)/(2 c1 c2), whatever the arc.
    """
    depth = np.linspace(0.0, 2000.0, levels)
    section = Section(depth, 1500.0 + gradient * depth, np.zeros(1), np.array([5000.0]))
    for zs, zr, x in ((1000.0, 1000.0, 3000.0), (700.0, 1100.0, 2500.0), (1300.0, 900.0, 400.0)):
        found = rays_of(section, zs, zr, x)
        direct = found.take((found.surface == 0) & (found.bottom == 0))
        c1, c2 = 1500 + gradient * zs, 1500 + gradient * zr
        time = math.acosh(1 + gradient**2 * (x * x + (zs - zr) ** 2) / (2 * c1 * c2)) / abs(gradient)
        assert len(direct) == 1
        assert direct.delay[0] == pytest.approx(time, rel=1e-9)
        centre = (x * x + (zr + 1500 / gradient) ** 2 - (zs + 1500 / gradient) ** 2) / (2 * x)
        angle = math.atan2(centre * np.sign(gradient), (zs + 1500 / gradient) * np.sign(gradient))
        assert direct.departure[0] == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize("distance", [0.0, 1e-3, 0.02, 0.7, 5.0])
@pytest.mark.parametrize(
    ("gradient", "deepest", "ends"), [(0.05, 100.0, (3.0, 30.0)), (-0.04, 4000.0, (3900.0, 250.0))]
)
def test_ends_above_one_another(distance: float, gradient: float, deepest: float, ends: tuple[float, float]) -> None:
    """Straight up and down, as between a ship and what lies below it, every image is there: 2 n + 1 of up to n bounces.

    The direct time is that of `test_linear_profile_gives_circular_arcs`, written with asinh, which keeps its digits;
    upright it is log(c2/c1)/g, and so are the legs of a bounce. Less than 1 mm aside counts as 1 mm.
    """
    depth = np.array([0.0, deepest])
    section = Section(depth, 1500.0 + gradient * depth, np.zeros(1), np.array([deepest]), sound_speed_ratio=2.0)
    found = rays_of(section, *ends, distance, bounces=3)
    kinds = set(zip(found.surface.tolist(), found.bottom.tolist(), (found.departure > 0).tolist(), strict=True))
    assert len(found) == len(kinds) == 7
    c1, c2 = 1500.0 + gradient * np.array(ends)
    reach = max(distance, 1e-3)
    way2 = reach**2 + (ends[0] - ends[1]) ** 2
    direct = found.take((found.surface == 0) & (found.bottom == 0))
    time = 2.0 / abs(gradient) * math.asinh(abs(gradient) * math.sqrt(way2 / (4.0 * c1 * c2)))
    assert direct.delay[0] == pytest.approx(time, abs=1e-8)  # 15 um: the last digit of an angle near 90 degrees
    assert direct.loss_db[0] == pytest.approx(20.0 * math.log10(math.sqrt(way2)), abs=0.02)
    c0, cb = 1500.0, 1500.0 + gradient * deepest
    up, down = (found.take((found.surface == s) & (found.bottom == 1 - s)) for s in (1, 0))
    for bounced, turn in ((up, c0), (down, cb)):  # log(c/c') is exact upright, the rest of second order in the distance
        legs = (abs(math.log(turn / c1)) + abs(math.log(turn / c2))) / abs(gradient)
        assert bounced.delay[0] == pytest.approx(legs, abs=reach**2 / (sum(ends) * 1400.0) + 1e-8)


def test_ray_of_ten_degrees_in_a_linear_gradient() -> None:
    """c 1500 m/s, g 0.05 1/s, 10 deg down: back at its depth after 10 579.619 m and 7.017033 s, deepest 462.798 m."""
    section = Section(np.array([0.0, 2000.0]), np.array([1450.0, 1550.0]), np.zeros(1), np.array([5000.0]))
    found = rays_of(section, 1000.0, 1000.0, 10579.619)
    refracted = found.take((found.surface == 0) & (found.bottom == 0))
    k = int(np.argmin(np.abs(refracted.departure - math.radians(10))))
    assert refracted.departure[k] == pytest.approx(math.radians(10), abs=1e-6)
    assert refracted.delay[k] == pytest.approx(7.017033, abs=1e-6)
    path = ray_paths(section, 1000.0, refracted.departure[k : k + 1], 10579.619, stations=1000)
    assert np.nanmax(path.depth) == pytest.approx(1462.798, abs=1e-3)


@pytest.mark.parametrize(("degrees", "radius"), [(0, 88235.29), (5, 88572.34), (10, 89596.47)])
def test_radius_of_a_ray(degrees: float, radius: float) -> None:
    """c/(g cos theta) in 0.017 1/s, from 1500 m/s: the circle through three places of the ray."""
    section = Section(np.array([0.0, 2000.0]), np.array([1483.0, 1517.0]), np.zeros(1), np.array([5000.0]))
    path = ray_paths(section, 1000.0, np.array([math.radians(degrees)]), 4000.0, stations=2)
    a, b = np.array([path.x[0], path.depth[0, 0] - 1000.0]), np.array([path.x[1], path.depth[0, 1] - 1000.0])
    cross = a[0] * b[1] - a[1] * b[0]
    made = np.linalg.norm(a) * np.linalg.norm(b) * np.linalg.norm(a - b) / (2.0 * abs(cross))
    assert made == pytest.approx(radius, abs=0.01)


@pytest.mark.parametrize(
    ("degrees", "cycle", "seconds"), [(5, 50185.52, 33.45288), (10, 56696.66, 37.74834), (13, 62670.48, 41.64608)]
)
def test_cycles_of_munks_profile(degrees: float, cycle: float, seconds: float) -> None:
    """Back at its depth, by quadrature of the smooth profile: 60 straight layers miss it by 1e-5 of the time."""
    depth = np.linspace(0.0, 5000.0, 5001)
    scaled = 2 * (depth - 1300) / 1300
    section = Section(depth, 1500 * (1 + 0.00737 * (scaled - 1 + np.exp(-scaled))), np.zeros(1), np.array([5000.0]))
    found = rays_of(section, 1000.0, 1000.0, cycle)
    refracted = found.take((found.surface == 0) & (found.bottom == 0))
    k = int(np.argmin(np.abs(refracted.departure - math.radians(degrees))))
    assert refracted.departure[k] == pytest.approx(math.radians(degrees), abs=2e-3)
    assert refracted.delay[k] == pytest.approx(seconds, rel=1e-5)


def test_arrivals_of_a_pekeris_waveguide() -> None:
    """Images in 20 m of water at 1538.9236 m/s: times within 1 us, bounces exact, angles to 0.001 deg."""
    found = rays_of(
        flat(20.0, 1538.9236, density_ratio=1.149, sound_speed_ratio=0.9873, loss=0.00386), 5.0, 10.0, 100.0
    )
    times = [65.061659, 65.707448, 66.980350, 68.845589, 71.256664, 74.160357, 77.501317]
    angles = [2.8624, 8.5308, 14.0362, 19.2900, 24.2277, 28.8108, 33.0239]
    np.testing.assert_allclose(found.delay[:7] * 1e3, times, atol=1e-3)
    assert list(zip(found.surface[:7], found.bottom[:7], strict=True)) == [
        (0, 0), (1, 0), (0, 1), (1, 1), (1, 1), (2, 1), (1, 2)
    ]  # fmt: skip
    np.testing.assert_allclose(np.degrees(np.abs(found.departure[:7])), angles, atol=1e-3)
    np.testing.assert_allclose(np.abs(found.arrival), np.abs(found.departure), atol=1e-9)
    assert found.amplitude[0] == pytest.approx(1 / 100.124922, rel=1e-6)
    assert found.amplitude[1] == pytest.approx(-1 / 101.118742, rel=1e-6)  # the surface turns the sign


def test_images_between_surface_and_rigid_bottom() -> None:
    """Every image up to eight bounces, with amplitude 1/length and the sign of its surface bounces."""
    rigid = flat(70.0, 1480.0, density_ratio=1e12)
    found = rays_of(rigid, 20.0, 45.0, 310.0, bounces=8)
    images = [p for p in paths(70.0, 20.0, 45.0, 310.0, count=40) if p.surface + p.bottom <= 8]
    assert len(found) == len(images)
    for k, image in enumerate(images):
        assert (found.surface[k], found.bottom[k]) == (image.surface, image.bottom)
        assert found.length[k] == pytest.approx(image.length, rel=1e-8)
        assert found.amplitude[k] == pytest.approx((-1) ** image.surface / image.length, rel=1e-6)


@pytest.mark.parametrize("distance", [0.5, 7.0, 60.0, 900.0, 7000.0])
def test_images_at_any_distance(distance: float) -> None:
    """From almost overhead to grazing: the six shortest paths are all there."""
    found = rays_of(flat(40.0, 1500.0, density_ratio=1e12), 12.0, 31.0, distance)
    images = paths(40.0, 12.0, 31.0, distance, count=6)
    np.testing.assert_allclose(found.length[:6], [p.length for p in images], rtol=1e-7)


def test_two_rays_cancel() -> None:
    """Source and receiver sqrt(1209)/4 m deep, 100 m apart, 1 kHz, no bottom echo: the paths differ by two waves."""
    depth = math.sqrt(1209.0) / 4.0
    found = rays_of(flat(20.0, frequency=1000.0), depth, depth, 100.0)
    pressure = np.sum(found.amplitude * np.exp(-2j * np.pi * 1000.0 * found.delay))
    assert abs(pressure) < 2e-4
    assert np.sqrt(np.sum(np.abs(found.amplitude) ** 2)) > 1 / 100.0


def test_lloyds_mirror() -> None:
    """|p| = |exp(-ikR1)/R1 - exp(-ikR2)/R2|: the eigenrays' sum exactly, the field of beams within 0.5 dB rms.

    Beams are at least pi wavelengths wide; the pattern has to be wider.
    """
    section, k = flat(400.0, frequency=1000.0), 2 * np.pi * 1000.0 / 1500.0
    made = field(section, 8.0, reach=1500.0, columns=30, depths=np.array([60.0, 95.0, 150.0]), widest=1.0, beams=4000)
    near, far = (np.hypot(made.x[:, None], made.depth - s) for s in (8.0, -8.0))
    exact = np.exp(-1j * k * near) / near - np.exp(-1j * k * far) / far
    x, z = np.repeat(made.x, 3), np.tile(made.depth, 30)
    found = eigenrays([section] * 90, np.full(90, 8.0), z, x, rays=256, bounces=1)
    found = found.take(found.bottom == 0)
    summed = np.zeros(90, complex)
    np.add.at(summed, found.path, found.amplitude * np.exp(-2j * np.pi * 1000.0 * found.delay))
    np.testing.assert_allclose(summed.reshape(30, 3), exact, atol=1e-6 * np.abs(exact).max())
    error = (made.loss_db + 20 * np.log10(np.abs(exact)))[10:]
    assert np.sqrt(np.mean(error**2)) < 0.5


def test_munk_profile_over_100_km() -> None:
    """Ten arrivals of Bellhop: within 2 ms and 0.5 dB, bounces exact, phases within a degree and a half."""
    table = [
        (66641.04, 92.8, 180.0, 0, 0), (66648.70, 89.7, -90.0, 0, 0), (66825.35, 105.2, 120.3, 1, 2),
        (67017.36, 104.0, -85.9, 2, 2), (67083.31, 103.7, -91.1, 2, 2), (67291.82, 103.1, 63.6, 3, 2),
        (68371.07, 102.0, -140.2, 2, 3), (68652.33, 101.9, -9.2, 3, 3), (68736.42, 101.8, -21.9, 3, 3),
        (69036.50, 101.8, 85.6, 4, 3),
    ]  # fmt: skip
    found = rays_of(MUNK, 1000.0, 800.0, 1e5)
    for k, (time, loss, phase, surface, bottom) in enumerate(table):
        assert (found.surface[k], found.bottom[k]) == (surface, bottom)
        assert found.delay[k] * 1e3 == pytest.approx(time, abs=2.0)
        assert found.loss_db[k] == pytest.approx(loss, abs=0.5)
        turn = np.angle(found.amplitude[k] * np.exp(-1j * math.radians(phase)), deg=True)
        assert abs(turn) < 1.5


def test_spread_of_a_ray_is_the_slope_of_a_fan() -> None:
    """q from dynamic ray tracing against differences of neighbouring rays, over a sloping bottom in a gradient."""
    from pelagos.acoustics.eigenrays import _Hunt
    from pelagos.acoustics.section import on_device

    section = Section(
        np.array([0.0, 30.0, 80.0, 300.0]), np.array([1510.0, 1502.0, 1490.0, 1496.0]), np.array([0.0, 2000.0, 5000.0]),
        np.array([200.0, 150.0, 230.0]), density_ratio=1.8, sound_speed_ratio=1.1,
    )  # fmt: skip
    hunt = _Hunt(*on_device([section]), np.array([60.0]), np.array([70.0]), np.array([4100.0]), 40)
    angle = np.linspace(-0.3, 0.3, 101)
    step = 1e-7
    low, at, high = (hunt.trace(np.zeros(101, np.int64), angle + d) for d in (-step, 0.0, step))
    same = at.alive & low.alive & high.alive & (low.surface == high.surface) & (low.bottom == high.bottom)
    slope = (high.z - low.z) / (2 * step)
    assert same.sum() > 80
    assert at.bottom[same].max() >= 3
    error = np.abs(slope - at.slope)[same] / np.abs(slope[same])
    assert np.median(error) < 1e-5
    assert np.quantile(error, 0.9) < 1e-3


def test_a_shadow_zone_has_no_direct_ray() -> None:
    """Sound speed that falls with depth bends rays down: the last direct ray grazes the surface (Jensen, Eq. 3.70).

    A source 30 m deep reaches 10 m depth until x = sqrt(2 R 30) + sqrt(2 R 10), R = c/g.
    """
    gradient, deep = -0.2, Section(np.array([0.0, 4000.0]), np.array([1500.0, 700.0]))
    radius = 1500.0 / 0.2
    edge = math.sqrt(2 * radius * 30.0) + math.sqrt(2 * radius * 10.0)
    assert gradient < 0
    for share, rays in ((0.97, True), (1.03, False)):
        found = rays_of(deep, 30.0, 10.0, share * edge)
        assert bool(len(found.take(found.surface == 0))) is rays


@pytest.mark.parametrize("ends", [(110.0, 110.0), (120.0, 160.0)])
def test_reciprocity(ends: tuple[float, float]) -> None:
    """Source and receiver exchanged: the same times; and the same losses where the bottom is level.

    Over a slope the bottom is taken as a cone about the source, as in Bellhop: losses differ a little then.
    """
    x, z = np.array([0.0, 1500.0, 3000.0]), np.array([ends[0], 90.0 if ends[0] != ends[1] else 110.0, ends[1]])
    depth, speed = np.array([0.0, 40.0, 60.0, 200.0]), np.array([1515.0, 1512.0, 1495.0, 1497.0])
    kind = {"density_ratio": 1.9, "sound_speed_ratio": 1.15, "loss": 0.01}
    there = rays_of(Section(depth, speed, x, z, **kind), 20.0, 70.0, 3000.0, bounces=4)
    back = rays_of(Section(depth, speed, x, z[::-1].copy(), **kind), 70.0, 20.0, 3000.0, bounces=4)
    assert len(there) == len(back) > 4
    np.testing.assert_allclose(there.delay, back.delay, atol=1e-8)
    np.testing.assert_allclose(there.loss_db, back.loss_db, atol=1e-3 if ends[0] == ends[1] else 0.1)


def test_many_paths_at_once_equal_one_after_the_other() -> None:
    """Rows of one call are independent."""
    rng = np.random.default_rng(3)
    sections = [
        flat(float(d), 1500.0 + k, density_ratio=1.5, sound_speed_ratio=1.05) for k, d in enumerate((25, 60, 90))
    ]
    zs, zr, x = rng.uniform(3, 20, 3), rng.uniform(3, 20, 3), rng.uniform(50, 2000, 3)
    together = eigenrays(sections, zs, zr, x, rays=512)
    for k in range(3):
        alone = eigenrays(sections[k : k + 1], zs[k : k + 1], zr[k : k + 1], x[k : k + 1], rays=512)
        assert (together.of(k).delay == alone.delay).all()
        assert (together.of(k).amplitude == alone.amplitude).all()


def test_munk_field() -> None:
    """501 x 201 points of AcousticsToolbox.jl (Bellhop, Gaussian beams) beyond 40 km: incoherent 77.9 and 43.8 dB.

    The coherent minimum is one point of an interference pattern: 73.8 there, 73.60 with Bellhop itself and a linear
    profile, 73.49 here with as many beams.
    """
    made = field(
        MUNK, 1000.0, reach=1e5, columns=500, depths=np.arange(0, 5001, 25.0), widest=math.radians(20.3), beams=1000
    )
    coherent, incoherent = made.loss_db[200:], made.incoherent_loss_db[200:]
    assert incoherent.min() == pytest.approx(77.9, abs=0.3)
    assert coherent.min() == pytest.approx(73.8, abs=0.32)
    mean = -10 * np.log10(np.mean(10 ** (-incoherent / 20)))
    assert mean == pytest.approx(43.8, abs=0.1)
    assert -10 * np.log10(np.mean(10 ** (-coherent / 20))) == pytest.approx(44.5, abs=0.2)


def test_a_slope_turns_sound_back() -> None:
    """A rigid slope of 80 deg sends a level beam back at 20 deg: 1/(x s) on its axis after a way s, x from the source.

    It is bent by no gradient, and spread over the ring of radius x.
    """
    x, z = np.array([0.0, 990.0, 1025.0]), np.array([200.0, 200.0, 1.5])
    section = Section(np.array([0.0, 210.0]), np.full(2, 1500.0), x, z, density_ratio=1e9, frequency=30e3)
    made = field(section, 100.0, reach=1025.0, columns=41, depths=np.arange(4.0, 160.0, 0.5), widest=0.03, beams=2000)
    met = 990.0 + 35.0 * 100.0 / 198.5
    rise = 2.0 * math.atan2(198.5, 35.0)
    for place in (850.0, 900.0):
        back = met - place
        depth, way = 100.0 - back * math.tan(math.pi - rise), met - back / math.cos(rise)
        column = made.incoherent_loss_db[round(place / 25.0) - 1]
        here = int(np.argmin(np.abs(made.depth - depth)))
        assert column[here] == pytest.approx(10.0 * math.log10(place * way), abs=0.1)

    narrow = field(section, 100.0, reach=1025.0, columns=41, depths=np.arange(4.0, 80.0, 0.5), widest=0.003, beams=200)
    for place in (850.0, 875.0, 925.0):
        depth = 100.0 - (met - place) * math.tan(math.pi - rise)
        heard = narrow.intensity[round(place / 25.0) - 1]
        assert heard @ narrow.depth / heard.sum() == pytest.approx(depth, abs=1.0)  # 9.3 m from column to column


def test_a_mirrored_section_is_the_same_from_the_other_end() -> None:
    section = Section(
        np.array([0.0, 40.0]), np.array([[1500.0, 1510.0], [1520.0, 1490.0], [1505.0, 1506.0]]),
        np.array([0.0, 300.0, 700.0, 1200.0]), np.array([90.0, 120.0, 60.0, 80.0]), density_ratio=[1.1, 1.2, 1.3, 1.4],
        begins=np.array([0.0, 400.0, 950.0]),
    )  # fmt: skip
    x, reach = np.array([10.0, 299.0, 420.0, 880.0]), 900.0
    seen = mirrored(section, reach)
    assert seen.bottom_at(reach - x) == pytest.approx(section.bottom_at(x), rel=1e-12)
    assert seen.speed_at(20.0, reach - x) == pytest.approx(section.speed_at(20.0, x), rel=1e-12)
    behind = np.searchsorted(seen.bottom_x, reach - x, side="right") - 1
    assert np.asarray(seen.density_ratio)[behind].tolist() == [1.1, 1.1, 1.2, 1.3]


def test_the_limit_of_rays() -> None:
    """10 Hz in 5000 m, 200 km away: modes give 93.12, 86.50, 86.45 dB at 200, 201, 202 km; rays are off by 0.8 dB."""
    section = flat(5000.0, 1500.0, density_ratio=2.0, sound_speed_ratio=2000 / 1500, frequency=10.0)
    losses = []
    for x in (200e3, 201e3, 202e3):
        found = rays_of(section, 500.0, 2500.0, x, bounces=80)
        losses.append(-20 * np.log10(abs(np.sum(found.amplitude * np.exp(-2j * np.pi * 10.0 * found.delay)))))
    error = np.abs(np.array(losses) - [93.12, 86.50, 86.45])
    assert error.max() < 1.0
    assert error.max() > 0.1  # they are not exact: each arrival is a plane wave at the bottom
