"""The sea surface as sonars meet it: where rays come through waves, what it scatters, and echoes by several bounces."""

from __future__ import annotations

import math
from dataclasses import replace

import drjit as dr
import numpy as np
import pytest
from sonar_scenes import PLAIN, at, context, plane, sphere

from pelagos import jit
from pelagos.acoustics.sea_surface import bubble_loss_db, surface_backscatter
from pelagos.errors import ValidityWarning
from pelagos.math.constants import GRAVITY
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.rays import NO_BODY, Hits, Rays
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.ping import multipath, sea_surface
from pelagos.sensors.sonar.ping.sea_surface import looks_up, sea_around, with_sea_surface
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.world.material import MATERIALS

QUIET = {"self_noise_db": -200.0, "source_level_db": 300.0, "wind_speed_mps": 0.0, "scale": "linear"}
HARD = replace(PLAIN, density_ratio=1e6, lambert_db=-300.0)
"""A perfect mirror that scatters nothing at oblique angles."""


@pytest.mark.parametrize(("wind", "loss"), [(15, 6.50), (10, 3.44), (5, 0.46)])
def test_bubble_loss_of_the_handbook(wind, loss):
    """20 kHz at 10 deg grazing."""
    assert bubble_loss_db(jit.Float64(math.sin(math.radians(10))), 20e3, wind)[0] == pytest.approx(loss, abs=0.006)


@pytest.mark.parametrize(
    ("khz", "wind", "degrees", "level"),
    [(15, 3.5, 10, -47), (15, 3.5, 30, -45), (70, 8, 30, -24), (18, 17, 15, -27), (18, 17, 40, -21)],
)
def test_surface_backscatter_of_the_handbooks_figures(khz, wind, degrees, level):
    """Read off to +-2 dB."""
    section = surface_backscatter(jit.Float64(math.radians(degrees)), khz * 1e3, wind)
    assert 10 * math.log10(section[0]) == pytest.approx(level, abs=2.0)


@pytest.mark.parametrize("wind", [3.0, 8.0, 15.0])
def test_surface_backscatter_at_normal_incidence(wind):
    """+3 to +8 dB in the handbook's figures, by facets."""
    assert 2.5 < 10 * math.log10(surface_backscatter(jit.Float64(math.pi / 2), 30e3, wind)[0]) < 8.0


def test_a_frequency_outside_of_the_handbook_gives_a_warning():
    with pytest.warns(ValidityWarning, match="TR 9407"):
        surface_backscatter(jit.Float64(0.5), 400e3, 5.0)


def waves(height=1.0, period=4.5, towards=0.0, **more):
    wave = {"type": "regular", "height_m": height, "period_s": period, "towards_deg": towards}
    return build_ocean(OceanConfig(waves=wave, **more))


def meet(ocean, position, directions, *, reach=60.0, t=0.0, rough=True):
    """Ways to the surface [m], infinite without, and normals there."""
    place = jit.Array3f64(*(jit.Float64([float(v)]) for v in position))
    sea = sea_around(ocean, place, jit.Float64(t), reach=reach, waves=rough)
    count = len(directions)
    d = jit.Array3f(np.ascontiguousarray(directions.T, dtype=np.float32))
    origin = jit.Array3f64(*(jit.Float64(np.full(count, float(v))) for v in position))
    none = jit.UInt32(np.full(count, NO_BODY, np.uint32))
    rays = Rays(origin, d, jit.Float(np.full(count, reach, np.float32)), jit.UInt32(0) & none, none)
    far, zero = dr.full(jit.Float, dr.inf, count), dr.zeros(jit.Array3f, count)
    word = dr.zeros(jit.UInt32, count)
    hits = Hits(far < 0, far, jit.Array3f64(zero), zero, zero, zero, word, word, word, zero)
    hits = with_sea_surface(hits, rays, jit.UInt32(0), sea, dr.zeros(jit.UInt32, count))
    return np.array(hits.t), np.array(hits.normal).T


@pytest.mark.parametrize("towards", [0.0, -35.0, 130.0])
def test_rays_meet_the_waves_where_they_are(towards):
    """A regular wave of 1 m height and 31.6 m length, met from 6 m below in all directions upwards.

    The grid of 2.45 m is linear between its nodes: a (k h)^2/8 = 1.5 cm of height, at most 1.5 cm/sin of way.
    """
    ocean, start = waves(towards=towards), np.array([33.0, -52.0, -6.0])
    rng = np.random.default_rng(2)
    turn, rise = rng.uniform(0, 2 * np.pi, 400), np.radians(rng.uniform(20, 90, 400))
    d = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=-1)
    way, normal = meet(ocean, start, d)
    assert np.isfinite(way).all()
    place = start + way[:, None] * d
    k = (2 * math.pi / 4.5) ** 2 / 9.80665
    north, west = math.cos(math.radians(towards)), -math.sin(math.radians(towards))  # that it travels
    along = north * place[:, 0] + west * place[:, 1]
    assert np.abs(place[:, 2] - 0.5 * np.cos(k * along)).max() < 0.02
    assert np.abs(way - 6.0 / np.sin(rise)).max() > 0.5  # which a plane would have missed by far
    slope = -0.5 * k * np.sin(k * along)
    over_a_cell = 0.5 * k * k * 2.45  # it changes by so much
    assert normal[:, 0] / -normal[:, 2] == pytest.approx(north * slope, abs=over_a_cell)
    assert normal[:, 1] / -normal[:, 2] == pytest.approx(west * slope, abs=over_a_cell if west else 1e-6)
    assert np.corrcoef(normal[:, 0] * north + normal[:, 1] * west, slope)[0, 1] > 0.95
    assert (normal[:, 2] < 0).all()


@pytest.mark.parametrize("tile", [(0, 0), (-1, 0), (0, 1), (2, -1), (1, 3)])
@pytest.mark.parametrize("lane", [0, 1])
def test_the_surface_goes_on_as_its_mirror_image(tile, lane):
    """Heights in a tile are those of the place that an odd number of mirrors leads to, along each axis for itself, and
    slopes differences of the heights: along one axis a bilinear cell is a straight line.

    In float32 of places up to 400 m, to 3e-5 m times the steepest slope of 1.6.
    """
    nodes, step = sea_surface._NODES, 2.0
    span, rng = (nodes - 1) * step, np.random.default_rng(6)
    grids = rng.uniform(-0.8, 0.8, (2, nodes, nodes))
    zero = jit.Float64([0.0, 0.0])
    sea = sea_surface.Sea(jit.Float(grids.ravel()), jit.Float(zero), jit.Float([0.8, 0.8]), zero, zero, step, True)

    def height(x, y):
        return [np.array(v) for v in sea_surface._elevation(sea, jit.UInt32(lane), jit.Float(x), jit.Float(y))]

    cell, share = rng.integers(0, nodes - 1, (2, 60)), rng.uniform(0.2, 0.7, (2, 60))
    (i, j), (a, b), grid = cell, share, grids[lane]
    inside = (1 - a) * ((1 - b) * grid[i, j] + b * grid[i, j + 1])
    inside += a * ((1 - b) * grid[i + 1, j] + b * grid[i + 1, j + 1])
    place = (cell + share) * step
    x, y = ((t + 1) * span - p if t % 2 else t * span + p for t, p in zip(tile, place, strict=True))
    z, slope_x, slope_y = height(x, y)
    assert z == pytest.approx(inside, abs=1e-4)
    d = 0.1 * step
    assert slope_x == pytest.approx((height(x + d, y)[0] - height(x - d, y)[0]) / (2 * d), abs=4e-4)
    assert slope_y == pytest.approx((height(x, y + d)[0] - height(x, y - d)[0]) / (2 * d), abs=4e-4)


@pytest.mark.parametrize("reach", [36.0, 500.0])
def test_every_sonar_has_the_sea_around_it_at_its_own_time(reach):
    """a cos(k s - w t) at nodes 2.5 m apart at most, as many each way, the middle one within half of that from it."""
    tide = [{"amplitude_m": 0.7, "period_h": 12.0, "phase_deg": 180.0}]
    ocean = waves(towards=-35.0, tide=tide)
    place, t = np.array([[33.0, 250.0, -9.0], [-52.0, 140.0, 8.0], [-6.0, -3.0, -9.0]]), np.array([0.0, 1.7, 40.0])
    sea = sea_around(ocean, jit.Array3f64(place), jit.Float64(t), reach=reach, waves=True)
    step = min(reach / 24, 2.5)
    assert sea.step == step
    corner = np.array([np.array(sea.corner_x), np.array(sea.corner_y)])
    assert np.abs(corner + 24 * step - place[:2]).max() <= 0.5 * step + 1e-9
    x, y = (corner[i][:, None] + np.arange(49) * step for i in (0, 1))
    along = math.cos(math.radians(35)) * x[:, :, None] + math.sin(math.radians(35)) * y[:, None, :]
    w = 2 * math.pi / 4.5
    expected = 0.5 * np.cos(w * w / GRAVITY * along - w * t[:, None, None])
    found = np.array(sea.elevation).reshape(3, 49, 49)
    assert found == pytest.approx(expected, abs=1e-6)
    assert np.array(sea.highest) == pytest.approx(np.abs(found).max(axis=(1, 2)))
    level = -0.7 * np.cos(2 * np.pi / 43200 * t)
    assert np.array(sea.level) == pytest.approx(level, abs=1e-6)
    flat = sea_around(ocean, jit.Array3f64(place), jit.Float64(t), reach=reach, waves=False)
    assert not flat.waves
    assert np.array(flat.level) == pytest.approx(level, abs=1e-6)


def test_a_level_ray_close_below_the_surface_runs_into_the_next_trough():
    k = (2 * math.pi / 4.5) ** 2 / 9.80665
    way, _ = meet(waves(), (0.0, 0.0, -0.25), np.array([[1.0, 0.0, 0.0]]))
    assert way[0] == pytest.approx(math.acos(-0.5) / k, abs=0.15)  # 0.5 cos(k x) = -0.25


def test_rays_from_above_the_waves_or_downwards_meet_none():
    way, _ = meet(waves(), (0.0, 0.0, -6.0), np.array([[0.0, 0.0, -1.0], [0.8, 0.0, -0.6]]))
    assert np.isinf(way).all()
    way, _ = meet(waves(), (0.0, 0.0, 1.0), np.array([[0.0, 0.0, 1.0], [0.8, 0.0, 0.6]]))
    assert np.isinf(way).all()
    trough = math.pi / ((2 * math.pi / 4.5) ** 2 / 9.80665)  # where the surface is at -0.5 m
    way, _ = meet(waves(), (trough, 0.0, 0.2), np.array([[0.0, 0.0, 1.0], [0.8, 0.0, 0.6]]))
    assert np.isinf(way).all()


@pytest.mark.parametrize("height", [-4.0, 0.3, 1.0])
def test_rays_meet_a_flat_sea_at_its_tide_from_below_alone(height):
    """Of a tide of 0.7 m: (0.7 - z) / sin upwards, nothing from the air, level or downwards."""
    ocean = build_ocean(OceanConfig(tide=[{"amplitude_m": 0.7, "period_h": 12.0, "phase_deg": 0.0}]))
    rays = np.array([[0.0, 0.0, 1.0], [0.8, 0.0, 0.6], [0.6, 0.8, 0.0], [0.0, -0.6, -0.8]])
    way, normal = meet(ocean, (3.0, -2.0, height), rays, rough=False)
    free = [np.inf, np.inf]
    below = height < 0.7
    assert way == pytest.approx([0.7 - height, (0.7 - height) / 0.6, *free] if below else free + free, abs=1e-5)
    assert not below or normal[:2] == pytest.approx(np.array([[0, 0, -1.0]] * 2))


def test_only_what_looks_up_needs_the_waves():
    assert looks_up(np.array([[0.0, 0.0, -1.0], [0.95, 0.0, -0.3]]))
    assert not looks_up(np.array([[0.0, 0.0, -1.0], [0.8, 0.0, -0.6]]))


def sonar(geometries, *, materials=(PLAIN,), ocean=None, **options):
    config = {"beams": 9, "horizontal_aperture_deg": 3.0, "vertical_beamwidth_deg": 80.0, "bins": 3000,
              "range_max_m": 30.0, "bandwidth_hz": 300e3, "rays_per_beam": 1000, "side_lobe_beams": 0}  # fmt: skip
    return ImagingSonar(
        ImagingSonarConfig(**(config | QUIET | options)), context(geometries, materials=materials, ocean=ocean)
    )


def of_the_ball(ball, others=(), **options):
    """What a ball adds to the mean intensity by range, over all beams, and the ranges."""
    with_it, without = sonar([*ball, *others], **options), sonar([plane(-300.0), *others], **options)
    a, b = (s.sense(at(0, 0, -4.0)).truth[0].sum(axis=0).astype(float) for s in (with_it, without))
    return np.maximum(a - b, 0.0), with_it.tables["range"]


def test_the_tide_moves_the_images():
    """Bounces at the surface arrive by the image in the surface as high as it stands: 1.5 m over the mean."""
    ball = [sphere((20.0, 0, -4.0), 0.3)]
    tide = build_ocean(OceanConfig(tide={"period_h": 12.0, "amplitude_m": 1.5}))
    options = {"multipath": "surface", "surface_loss_db": 0.0}
    for ocean, surface, rise in ((None, "waves", 8.0), (tide, "waves", 11.0), (tide, "flat", 8.0)):
        more, r = of_the_ball(ball, ocean=ocean, sea_surface=surface, **options)
        broken = math.hypot(20.0, rise) - 0.3
        late = r > 0.5 * (20.0 + broken) + 0.2
        assert r[late & (more > 0.05 * more[late].max())].min() == pytest.approx(broken, abs=0.1)


def test_the_mixed_way_is_heard_in_both_directions_at_once():
    """Over the mirror out and straight home, and the other way round, in phase: four times the power of either.

    Against the echo over the mirror both ways, L long: 4 (L/S)^2 by spreading, one loss of the mirror less, and one
    way by the axis instead of the line's pattern in the mirror's direction: X. Lurton, An Introduction to Underwater
    Acoustics (2nd ed., 2010), Section 2.4.
    """
    loss, width = 1.5, 60.0
    more, r = of_the_ball([sphere((20.0, 0, -4.0), 0.3)], multipath="surface", surface_loss_db=loss,
                          frequency_hz=200e3, tvg_db=0.0, vertical_beamwidth_deg=width)  # fmt: skip
    straight, broken = 20.0 - 0.3, math.hypot(20.0, 8.0) - 0.3
    mixed, both = (more[(r > d - 0.1) & (r < d + 0.5)].sum() for d in (0.5 * (straight + broken), broken))
    sine, half = 8.0 / math.hypot(20.0, 8.0), math.sin(math.radians(width / 2))
    pattern = np.sinc(0.442946 * sine / half) ** 2  # half power at half of the width
    expected = 4.0 * (broken / straight) ** 2 * 10 ** (0.1 * loss) / pattern
    assert mixed / both == pytest.approx(expected, rel=0.05)  # 1 % with 1 000 rays a beam and with 3 000


def test_second_order_arrives_by_the_images_images():
    """Surface and bottom one after the other: images of images, Jensen et al. (2011), Section 2.4.4.

    In 12 m of water, 4 m deep, the rise is 24 m both for surface first and for bottom first (4 + 12 + 8 m).
    """
    ball, floor = [sphere((20.0, 0, -4.0), 0.3)], [plane(-12.0, material=1)]
    options = {"materials": (PLAIN, HARD), "multipath": "surface_and_bottom", "surface_loss_db": 0.0,
               "bottom_loss_db": 0.0, "range_max_m": 32.0, "vertical_beamwidth_deg": 90.0,
               "rays_per_beam": 2000}  # fmt: skip
    (one, r), (two, _) = (of_the_ball(ball, floor, multipath_order=k, **options) for k in (1, 2))
    broken = math.hypot(20.0, 24.0) - 0.3
    assert two[(r > broken - 0.1) & (r < broken + 0.4)].sum() > 20 * one[(r > broken - 0.1) & (r < broken + 0.4)].sum()
    assert two[(r > broken - 0.6) & (r < broken - 0.1)].max() < 0.05 * two[r > broken - 0.1].max()  # not before
    mixed = 0.5 * (20.0 + math.hypot(20.0, 24.0)) - 0.3
    near = (r > mixed - 0.1) & (r < mixed + 0.4)
    assert two[near].sum() > 1.5 * one[near].sum()


def test_waves_blur_the_surface_bounce():
    """Over a ball at 20 m, waves tilt the mirror: the bounce arrives spread, at other times than a plane's."""
    ball = [sphere((20.0, 0, -4.0), 0.3)]
    options = {"multipath": "surface", "surface_loss_db": 0.0}
    rough = sonar(ball, ocean=waves(0.8, 3.0), **options)
    plain = sonar(ball, ocean=waves(0.8, 3.0), sea_surface="flat", **options)
    a, b = (s.sense(at(0, 0, -4.0)).truth[0].sum(axis=0) for s in (rough, plain))
    r = rough.tables["range"]
    by_bounce = (r > 20.0) & (r < 24.0)
    assert np.corrcoef(a[by_bounce], b[by_bounce])[0, 1] < 0.9


def test_what_comes_straight_home_from_behind_meets_the_baffle():
    """A sounder 3 m below the surface and 12 m above the bottom: the surface by way of the bottom, straight home from
    above, at (12 + 15 + 3)/2 = 15 m, is 30 dB below what it would be without the array's back; the second echo at 27 m
    comes from below, and is as strong as ever."""
    levels = []
    for behind in (1.0, multipath.BEHIND):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(multipath, "BEHIND", behind)
            config = SinglebeamConfig(
                bins=300, range_max_m=30.0, multipath="surface_and_bottom", multipath_order=2, scale="linear",
                bottom_loss_db=0.0,
            )  # fmt: skip
            s = Singlebeam(config, context([plane(-15.0)], materials=(MATERIALS["sand"],)))
            truth, r = s.sense(at(0, 0, -3.0)).truth[0], s.tables["range"]
        levels.append([10 * np.log10(truth[np.abs(r - m) < 0.6].max()) for m in (12.0, 15.0, 27.0)])
    bare, baffled = levels
    assert baffled[0] == pytest.approx(bare[0], abs=0.01)
    assert baffled[1] == pytest.approx(bare[1] - 30.0, abs=1.0)
    assert baffled[2] == pytest.approx(bare[2], abs=0.01)
