"""Targets of known strength: small ones, smooth ones, and what tells where they are."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest
from scipy.special import fresnel as exact_fresnel
from sonar_scenes import at, box, context, plane, sphere

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.pulse import range_coupling
from pelagos.acoustics.specular import flat_side, fresnel, roughness_loss, round_side
from pelagos.acoustics.sphere_scattering import Filling, sphere_strength
from pelagos.raycast.geometry import Geometry
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.ping.solids import recognise_shape
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.world.material import MATERIALS
from pelagos.world.shapes import cylinder

pytestmark = pytest.mark.filterwarnings("ignore:.*finer than the pulse resolves")
STEEL = (MATERIALS["steel"],)
LOUD = {"range_max_m": 60.0, "iq": True, "scale": "linear", "source_level_db": 260.0}
REFLECTED_DB = 20 * math.log10((7.6585 * 3.9333 - 1) / (7.6585 * 3.9333 + 1))  # steel, squarely: -0.57 dB


def echo(things, distance, **options):
    """Apparent target strength [dB], azimuth [rad] and range [m] of the loudest cell."""
    config = ImagingSonarConfig(**(LOUD | options))
    s = ImagingSonar(config, context([plane(-1000.0), *things], materials=STEEL))
    power = np.abs(s.sense(at(0, 0, 0)).extras["iq"][0]) ** 2
    beam, k = np.unravel_index(power.argmax(), power.shape)
    loss = float(absorption(jit.Float64(config.frequency_hz), 10.0, 35.0, 0.0)[0])
    strength = 10 * math.log10(power.max()) + 40 * math.log10(distance) + 2 * loss * distance
    return strength, float(s.tables["azimuth"][beam]), float(s.tables["range"][k])


class TestSphereTheory:
    # J. M. Jech et al., J. Acoust. Soc. Am. 138, 3742 (2015), doi 10.1121/1.4937607: spheres of 10 mm radius in water
    # of 1026.8 kg/m^3 and 1477.4 m/s; gas of 1.24 kg/m^3 and 345 m/s
    F = np.array([12e3, 14e3, 16e3, 18e3])

    @pytest.mark.parametrize(
        ("filling", "soft", "published"),
        [
            (None, False, [-54.44, -52.20, -50.40, -48.96]),
            (None, True, [-42.29, -42.92, -43.52, -44.02]),
            (Filling(1.24 / 1026.8, 345.0 / 1477.4), False, [-42.34, -42.93, -43.52, -44.03]),
        ],
    )
    def test_rigid_soft_and_gas_are_the_benchmarks(self, filling, soft, published):
        found = sphere_strength(0.01, self.F, filling, sound_speed=1477.4, soft=soft)
        assert found == pytest.approx(published, abs=0.01)

    @pytest.mark.parametrize(
        ("diameter", "frequency", "filling", "published"),
        [
            (0.060, 38e3, Filling(8.947 / 1.026, 4760 / 1490, 2288.5 / 1490), -33.6),
            (0.023, 120e3, Filling(8.947 / 1.026, 4760 / 1490, 2288.5 / 1490), -40.4),
            (0.0381, 38e3, Filling(14.9 / 1.026, 6853 / 1490, 4171 / 1490), -42.4),
            (0.0381, 120e3, Filling(14.9 / 1.026, 6853 / 1490, 4171 / 1490), -39.5),
        ],
    )
    def test_elastic_spheres_are_the_standard_targets(self, diameter, frequency, filling, published):
        """Copper and tungsten carbide: Foote (1982), and the handbook of ICES Report 144; they round to 0.1 dB, and
        the sound speed moves them by 0.1 dB."""
        assert sphere_strength(diameter / 2, frequency, filling, sound_speed=1490.0) == pytest.approx(
            published, abs=0.2
        )

    def test_large_ka_is_half_the_radius(self):
        assert sphere_strength(0.1, 750e3, None, sound_speed=1500.0) == pytest.approx(-26.02, abs=0.05)


class TestKirchhoff:
    def test_fresnel_integrals(self):
        """Abramowitz and Stegun 7.3.32-33: within 2e-3 (2.2e-3 in fact)."""
        x = np.linspace(-6.0, 6.0, 301)
        c, s = fresnel(jit.Float(x))
        exact = exact_fresnel(x)
        assert np.array(s) == pytest.approx(exact[0], abs=2.5e-3)
        assert np.array(c) == pytest.approx(exact[1], abs=2.5e-3)

    @pytest.mark.parametrize("offset", [(0.0, 0.0), (0.3, 0.0), (0.25, -0.4)])
    def test_a_plate_is_the_integral_over_its_surface(self, offset):
        """1/lambda |sum cos exp(2ikr)/r^2 dA| over half a million points; near and off the mirror's direction."""
        half, height, wavelength = (0.15, 0.1), 3.0, 0.02
        u, v = np.meshgrid(*(np.linspace(-h, h, 700) * (1 - 1 / 700) for h in half), indexing="ij")
        r = np.sqrt((u - offset[0]) ** 2 + (v - offset[1]) ** 2 + height**2)
        area = 4 * half[0] * half[1] / u.size
        expected = abs((height / r * np.exp(4j * math.pi * r / wavelength) / r**2).sum() * area / wavelength)
        args = (tuple(jit.Float(h) for h in half), tuple(jit.Float(o) for o in offset))
        size, _, _ = flat_side(*args, jit.Float(height), jit.Float(wavelength))
        assert 20 * math.log10(size[0] / expected) == pytest.approx(0.0, abs=0.4)

    def test_limits_of_plates_and_cylinders(self):
        """Far away 20 log A/lambda and 10 log a L^2/(2 lambda) (Urick, Table 9.1); near by a mirror, 1/(2 r)."""
        far, wavelength = 400.0, jit.Float(0.015)
        one = lambda v: jit.Float(v)
        size, _, _ = flat_side((one(0.1), one(0.15)), (one(0.0), one(0.0)), one(far), wavelength)
        assert 20 * math.log10(size[0] * far**2) == pytest.approx(20 * math.log10(0.06 / 0.015), abs=0.05)
        size, _, _ = flat_side((one(5.0), one(7.0)), (one(0.3), one(-0.4)), one(10.0), wavelength)
        assert float(size[0]) == pytest.approx(1 / 20.0, rel=0.05)
        size, _, _ = round_side(one(0.2), one(0.5), one(0.0), one(far + 0.2), wavelength)
        assert 20 * math.log10(size[0] * far**2) == pytest.approx(10 * math.log10(0.2 / (2 * 0.015)), abs=0.1)

    def test_roughness(self):
        """exp(-(2 k s)^2): a Rayleigh parameter 2 k s of 1 leaves 1/e."""
        assert float(roughness_loss(jit.Float(0.01 / (4 * math.pi)), jit.Float(0.01))[0]) == pytest.approx(math.exp(-1))
        assert dr.width(roughness_loss(jit.Float([0.1, 0.2]), jit.Float(1.0))) == 2


@pytest.mark.parametrize(("distance", "bearing"), [(5.0, 0.0), (15.0, 0.13), (40.0, -0.3)])
@pytest.mark.parametrize("bins", [512, 4096])
def test_a_small_sphere_has_its_level_its_range_and_its_bearing(distance, bearing, bins):
    """Radius 0.1 m: 20 log10(a/2) and what steel reflects; between beams 0.5 deg apart it loses up to 0.75 dB."""
    place = (distance * math.cos(bearing), distance * math.sin(bearing), 0.0)
    near = distance - 0.1
    strength, azimuth, reach = echo([sphere(place, 0.1)], near, bins=bins)
    # near by the sphere curves the wave: 1/(r (r + a)) for 1/r^2
    expected = 20 * math.log10(0.05 * near / distance) + REFLECTED_DB
    assert expected - 1.2 < strength < expected + 0.5  # what is not coherent is 20 dB below
    assert azimuth == pytest.approx(bearing, abs=math.radians(0.3))
    assert reach == pytest.approx(near, abs=max(0.5 * 59.5 / bins, 0.01) + 0.01)


def test_bearings_follow_the_target_between_beams():
    """1 deg beams, 0.5 deg apart: the centre of the power over the beams moves with the target, without a staircase."""
    config = ImagingSonarConfig(**LOUD, shading="hamming")
    found, true = [], np.radians(np.linspace(3.0, 3.9, 4))
    for bearing in true:
        c = (20 * math.cos(bearing), 20 * math.sin(bearing), 0.0)
        s = ImagingSonar(config, context([plane(-1000.0), sphere(c, 0.1)], materials=STEEL))
        power = (np.abs(s.sense(at(0, 0, 0)).extras["iq"][0]) ** 2).max(axis=1)
        near = power > 0.01 * power.max()
        found.append((power * s.tables["azimuth"])[near].sum() / power[near].sum())
    assert np.degrees(np.array(found)) == pytest.approx(np.degrees(true), abs=0.05)


def test_a_faraway_sphere_is_never_missed():
    config = ImagingSonarConfig(range_max_m=60.0, scale="db")
    s = ImagingSonar(config, context([plane(-1000.0), sphere((40.0, 0, 0), 0.1)], materials=STEEL))
    r, azimuth = s.tables["range"], s.tables["azimuth"]
    cells = np.ix_(np.abs(azimuth) < 0.05, np.abs(r - 39.9) < 1.2)
    levels = [s.sense(at(0.02 * k - 1, 0.013 * k - 0.6, 0, tick=k)).data[0][cells].max() for k in range(50)]
    assert min(levels) > max(levels) - 6.0


def test_a_thing_before_a_small_one_hides_it():
    wall = box((10.0, 0.0, 0.0), (0.5, 6.0, 6.0))
    s = ImagingSonar(ImagingSonarConfig(**LOUD), context([sphere((20.0, 0, 0), 0.1), wall], materials=STEEL))
    truth, r = s.sense(at(0, 0, 0)).truth[0], s.tables["range"]
    assert truth[:, np.abs(r - 19.9) < 0.5].max() < 1e-8 * truth.max()


def test_smooth_plates_and_cylinders_are_mirrors_where_they_are_smooth():
    """0.3 x 0.3 m of steel at 100 kHz, 20 m away: nearly its far field; at 750 kHz a mirror of its own Fresnel zones,
    and turned by 10 deg next to nothing."""
    plate = box((20.5, 0.0, 0.0), (1.0, 0.3, 0.3))
    low, _, _ = echo([plate], 20.0, frequency_hz=100e3, beams=257)
    size, _, _ = flat_side(*[(jit.Float(v), jit.Float(v)) for v in (0.15, 0.0)], jit.Float(20.0), jit.Float(0.015))
    assert low == pytest.approx(20 * math.log10(size[0] * 400.0) + REFLECTED_DB, abs=0.7)
    assert low > 13.0
    mesh = cylinder(0.2, 1.0)
    pile = Geometry(np.asarray(mesh.vertices) + np.array([20.2, 0, 0]), mesh.faces, 0, 2, 2)
    found, _, _ = echo([pile], 20.0, frequency_hz=100e3, beams=257, vertical_beamwidth_deg=60.0)
    size, _, _ = round_side(jit.Float(0.2), jit.Float(0.5), jit.Float(0.0), jit.Float(20.2), jit.Float(0.015))
    assert found == pytest.approx(20 * math.log10(size[0] * 400.0) + REFLECTED_DB, abs=0.7)


def test_the_end_of_a_cylinder_echoes_as_its_area():
    """Far away A/lambda of the circle, 20 log 8.38 for a radius of 0.2 m at 100 kHz (Urick, Table 9.1)."""
    mesh = cylinder(0.2, 1.0)
    turned = np.asarray(mesh.vertices)[:, [2, 0, 1]]  # its axis along x
    pile = Geometry(turned + np.array([40.5, 0, 0]), mesh.faces, 0, 2, 2)
    found, _, _ = echo([pile], 40.0, frequency_hz=100e3, beams=257)
    assert found == pytest.approx(20 * math.log10(math.pi * 0.2**2 / 0.015) + REFLECTED_DB, abs=0.8)


def test_a_chirp_takes_closing_targets_for_nearer():
    """f T/B of 12.5 ms: 25 mm at 2 m/s, besides r v/c = 20 mm at 15 m; a burst only the latter."""
    assert range_coupling(750e3, 30e3, 0.5e-3, "chirp") == pytest.approx(12.5e-3)
    assert range_coupling(750e3, 30e3, 0.5e-3, "cw") == 0.0
    s = ImagingSonar(
        ImagingSonarConfig(**(LOUD | {"bins": 8192, "range_max_m": 20.0})),
        context([plane(-1000.0), sphere((15.1, 0, 0), 0.1)], materials=STEEL),
    )
    peak = []
    for speed in (0.0, 2.0):
        power = np.abs(s.sense(at(0, 0, 0, velocity=(speed, 0, 0))).extras["iq"][0]) ** 2
        peak.append(float(s.tables["range"][power.max(axis=0).argmax()]))
    assert peak[0] - peak[1] == pytest.approx(0.025 + 15.0 * 2 / 1500, abs=0.003)


def test_shapes_are_recognised_however_they_stand():
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    for shape, size in (
        ("sphere", 0.2),
        ("box", (1, 2, 3)),
        ("cylinder", (1, 1, 4)),
        ("cone", 1),
        ("corner_reflector", 1),
    ):
        vertices = pl.Prop(shape, size=size).mesh.vertices
        for placed in (vertices, vertices @ turn.T + np.array([3.0, -2.0, 5.0])):
            found = recognise_shape(placed)
            assert found.kind == (shape if shape in ("sphere", "box", "cylinder") else "other")
            assert np.linalg.norm(placed - found.centre, axis=1).max() <= found.radius * (1 + 1e-6)
    half = recognise_shape(pl.Prop("box", size=(1, 2, 3)).mesh.vertices @ turn.T).half
    assert np.sort(half) == pytest.approx([0.5, 1.0, 1.5], abs=1e-4)


def test_props_are_small_targets_too_with_their_label():
    """A ball that is spawned at 25 m: seen by the next ping, where it is, under its own instance; moved, and gone."""
    sonar = {"type": "imaging_sonar", "range_max_m": 40, "scale": "db", "rate_hz": 10, "labels": True}
    agent = {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 10}, "sensors": {"it": sonar}}
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 200}, "agents": {"auv0": agent}}, n=2)
    sim.reset()

    def ping():
        for _ in range(100):
            sim.set_state("auv0", position=[[0, 0, -10]] * 2, attitude=[[1, 0, 0, 0]] * 2, velocity=[[0, 0, 0]] * 2)
            obs = sim.step()
            if "it" in obs["auv0"]:
                return obs["auv0"]["it"]
        raise AssertionError("no reading")

    ball = sim.spawn(pl.Prop("sphere", position=(25, 0, -10), size=0.2))
    for place in (25.0, 18.0):
        ball.move(position=(place, 0, -10))
        reading = ping()
        for copy in range(2):
            beam, k = np.unravel_index(reading.truth[copy].argmax(), reading.truth[copy].shape)
            assert reading.extras["range"][k] == pytest.approx(place - 0.1, abs=0.1)
            assert reading.extras["instance"][copy, beam, k] == ball.geometry.instance
    strongest = reading.truth.max()
    ball.remove()
    assert ping().truth.max() < strongest - 30.0


def power_about(things, distance, materials=STEEL, *, bins=600):
    """Energy of an image within 0.6 m of a range, under a gain of 40 log r, and the range of its strongest cell [m]."""
    config = ImagingSonarConfig(range_max_m=40.0, bins=bins, scale="linear", source_level_db=260.0, tvg_db=40.0)
    s = ImagingSonar(config, context([plane(-1000.0), *things], materials=materials))
    truth, r = s.sense(at(0, 0, 0)).truth[0], s.tables["range"]
    return float(truth[:, np.abs(r - distance) < 0.6].sum()), float(r[truth.max(axis=0).argmax()])


def test_a_thing_half_behind_another_gives_half_its_echo():
    """A ball whose near side a plate hides up to its middle: energy 1/2, of 64 rays over its disc, 32 or nearly."""
    ball = sphere((20.0, 0.0, 0.0), 0.1)
    half = box((10.0, -1.0, 0.0), (0.2, 2.0, 6.0))  # to starboard
    free, hidden = (power_about(things, 19.9)[0] for things in ([ball], [ball, half]))
    assert hidden / free == pytest.approx(0.5, abs=0.08)


def test_a_small_rough_thing_is_as_strong_and_as_far_away_as_it_is():
    """A rough block 0.2 m wide: under the gain 40 log r its level is that of its size and surface, at 10 m as at 30."""
    rough, bins = (MATERIALS["rock"],), 97
    found = [power_about([box((d + 0.05, 0.0, 0.0), (0.1, 0.2, 0.2))], d, rough, bins=bins) for d in (10.0, 30.0)]
    for (_, reach), d in zip(found, (10.0, 30.0), strict=True):
        assert reach == pytest.approx(d, abs=0.5 * 39.5 / bins + 0.03)
    assert found[1][0] == pytest.approx(found[0][0], rel=0.05)


@pytest.mark.parametrize("speed", [4.0, -3.0])
def test_a_moving_bottom_and_a_moving_sonar_give_the_same_range(speed):
    """Closing at v from 20 m: nearer by r v/c and, for the chirp, by f T/B v, the whole echo, as wide as before."""
    config = SinglebeamConfig(beamwidth_deg=4.0, frequency_hz=200e3, bandwidth_hz=20e3, pulse_s=5e-3, bins=500,
                              range_min_m=15.0, range_max_m=25.0, scale="linear", hears="none")  # fmt: skip

    def echo_of(sonar, ground):
        scene = context([plane(-60.0)])
        scene.scene.set_moving([(plane(0.0, size=20.0, instance=7), 0)])
        zero = np.zeros((1, 3))
        scene.scene.move(
            np.array([[0.0, 0.0, -20.0]]), np.array([[1.0, 0, 0, 0]]), np.array([[0.0, 0.0, ground]]), zero
        )
        s = Singlebeam(config, scene)
        power, r = s.sense(at(0, 0, 0, velocity=(0.0, 0.0, sonar))).truth[0].astype(float), s.tables["range"]
        middle = (power * r).sum() / power.sum()
        return middle, math.sqrt((power * (r - middle) ** 2).sum() / power.sum())

    (rest, width), sonar, ground = echo_of(0.0, 0.0), echo_of(-speed, 0.0), echo_of(0.0, speed)
    expected = -20.0 * speed / 1500.0 - 200e3 * 5e-3 / 20e3 * speed
    assert abs(expected) > 0.15
    for middle, spread in (sonar, ground):
        assert middle - rest == pytest.approx(expected, abs=0.01)
        assert spread == pytest.approx(width, abs=0.01)  # half a bin
