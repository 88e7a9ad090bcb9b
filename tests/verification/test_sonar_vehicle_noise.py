"""Noise of vehicles in sonars: source levels, spreading, absorption, beams, and what it costs an echo in decibels."""

from __future__ import annotations

import math
from dataclasses import replace

import drjit as dr
import numpy as np
import pytest
from sonar_scenes import StillWater, at, box, context, plane

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.radiated_noise import SHIP_SPEEDS_KN, propeller_level, ship_level
from pelagos.config.radiated_noise import ShipNoise, ThrusterNoise
from pelagos.errors import InputError, ValidityWarning
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.keys.radiated import noise_source
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar, MechanicalScanningSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.interference import Neighbours

DEEP = -200.0
KNOT = 1852 / 3600
SMALL = {"beams": 65, "horizontal_aperture_deg": 65.0, "beamwidth_deg": 1.0, "bins": 600, "range_max_m": 60.0,
         "rays_per_beam": 8, "source_level_db": 205.0, "iq": True}  # fmt: skip
SPEED = 0.8
PATTERN = {"level_db": 150.0, "frequency_hz": 8e3, "speed_mps": 1.6}


def loss(frequency: float) -> float:
    """Absorption in the scenes' water at 200 m [dB/m], from the formula."""
    return float(absorption(jit.Float64(frequency), 10.0, 35.0, 200.0)[0])


class TestSourceLevels:
    def test_a_ship_at_its_reference_is_its_class_s_spectrum(self):
        """At V = Vc and 300 ft: K - 20 log10(480/Vc) - 10 log10((1 - f/f1)^2 + 9), worked by hand for a tug: f1 =
        129.73 Hz; at 1297.3 Hz 191 - 42.26 - 10 log10(90) = 129.20."""
        assert ship_level(1297.3, 3.7 * KNOT, length=91.44, ship_class="tug") == pytest.approx(129.20, abs=0.01)
        cruise = ship_level(480 / 17.1, 17.1 * KNOT, length=91.44, ship_class="cruise")  # at f1: D = 4 alone
        assert cruise == pytest.approx(191 - 20 * math.log10(480 / 17.1) - 20 * math.log10(4.0), abs=1e-6)

    @pytest.mark.parametrize("ship_class", SHIP_SPEEDS_KN)
    def test_laws_of_speed_length_and_frequency(self, ship_class):
        of = lambda f, v, length: float(ship_level(f, v, length=length, ship_class=ship_class))
        assert of(2e5, 6.0, 50.0) - of(2e5, 3.0, 50.0) == pytest.approx(60 * math.log10(2), abs=1e-9)
        assert of(2e5, 6.0, 50.0) - of(2e5, 6.0, 10.0) == pytest.approx(20 * math.log10(5), abs=1e-9)
        assert of(2e4, 6.0, 50.0) - of(2e5, 6.0, 50.0) == pytest.approx(20.0, abs=0.2)  # -20 log f, but for 2 f1/f
        assert of(2e5, -6.0, 50.0) == of(2e5, 6.0, 50.0)

    def test_propellers_pass_through_what_is_known_of_them(self):
        known = {"level": 133.0, "at_frequency": 7e3, "at_speed": 1.3}
        assert propeller_level(7e3, 1.3, **known) == pytest.approx(133.0)
        assert propeller_level(70e3, -2.6, **known) == pytest.approx(133.0 - 20.0 + 18.06, abs=0.01)
        assert propeller_level(7e3, 0.0, **known) < 0.0

    def test_what_hums_at_rest_adds_to_what_turns(self):
        level = noise_source(ThrusterNoise(level_db=120.0, idle_db=120.0, frequency_hz=2e4, speed_mps=2.0)).level
        found = level(2e4, np.array([0.0, 2.0]))
        assert found == pytest.approx([120.0, 120.0 + 10 * math.log10(2)], abs=0.01)

    def test_the_schema_s_classes_are_the_model_s(self):
        for name in SHIP_SPEEDS_KN:
            assert noise_source(ShipNoise(ship_class=name, length_m=30.0)).hull_m == 15.0


def scene(
    *geometries, distance=30.0, bearing=0.0, up=0.0, speed=SPEED, noise=None, maker="auv1", ocean=None, **options
):
    """A sonar that looks along x, and a vehicle that makes noise off its axis."""
    noises = {maker: noise_source(ThrusterNoise(**(PATTERN | (noise or {}))))}
    neighbours = Neighbours(("auv0.sonar",), noises=noises)
    x, y = distance * math.cos(bearing), distance * math.sin(bearing)
    neighbours.motion_of = lambda agent: at(x, y, DEEP + up, velocity=(-0.6 * speed, 0.0, 0.8 * speed))
    around = replace(context([plane(DEEP - 100.0), *geometries], ocean=ocean), neighbours=neighbours)
    return ImagingSonar(ImagingSonarConfig(**(SMALL | options)), around)


def noise_of(sonar, tick=0):
    """Mean intensity by beam: nothing else is there within range."""
    return (np.abs(sonar.sense(at(0.0, 0.0, DEEP, tick=tick)).extras["iq"][0]) ** 2).mean(axis=-1)


def expected(distance: float, frequency: float, speed: float, source_level: float, pulse_s: float) -> float:
    """Noise behind the filter of a beam that looks there, re the source level: level at f and V, less spreading, less
    absorption, over the pulse's duration, times 1.5 of the shaded replica."""
    level = 150.0 - 20 * math.log10(frequency / 8e3) + 60 * math.log10(speed / 1.6)
    received = level - 20 * math.log10(distance) - loss(frequency) * distance
    return 10 ** (0.1 * (received - 10 * math.log10(pulse_s) - source_level)) * 1.5


@pytest.mark.parametrize(
    ("distance", "frequency", "speed"), [(30.0, 750e3, 1.6), (90.0, 300e3, 0.8), (7.0, 450e3, 0.8)]
)
def test_level_in_the_beam_that_looks_there(distance, frequency, speed):
    """600 bins of complex Gaussian noise, of which three in a row share what the filter keeps, in three pings: a
    standard deviation of some 4 %."""
    sonar = scene(distance=distance, speed=speed, frequency_hz=frequency)
    quiet = scene(distance=distance, speed=speed, frequency_hz=frequency, noise={"level_db": -50.0})
    added = np.mean([noise_of(sonar, k)[32] - noise_of(quiet, k)[32] for k in range(3)])
    assert added == pytest.approx(expected(distance, frequency, speed, 205.0, 0.5e-3), rel=0.12)


def test_snr_falls_by_what_the_noise_rises():
    """The same draws with more noise: every sample's noise is larger by one factor, 1 + N'/N."""
    sonar, quiet = scene(bearing=0.2, noise={"level_db": 130.0}), scene(noise={"level_db": -50.0})
    beam = 32 - round(math.degrees(0.2))
    ratio = noise_of(sonar)[beam] / noise_of(quiet)[beam]
    own = 10 ** (
        0.1 * (10 * math.log10(10 ** (0.1 * quiet_density()) * 1.5 / 0.5e-3) - 205.0 - 33.15)
    )  # DI of 1 x 20 deg
    pattern = np.sin(0.2) - math.sin(math.radians(32.5 - beam - 0.5))
    heard = expected(30.0, 750e3, SPEED, 205.0, 0.5e-3) * 10**-2.0 * _line(pattern)
    assert ratio == pytest.approx(1 + heard / own, rel=0.03)


def quiet_density() -> float:
    """Own and thermal noise at 750 kHz without wind [dB re 1 uPa^2/Hz]: 55, and -15 + 20 log10 750 = 42.5."""
    return 10 * math.log10(10**5.5 + 10**4.25)


def _line(sine: float) -> float:
    from pelagos.acoustics.beam_pattern import HALF_POWER_LINE, weighted_line_np

    length = HALF_POWER_LINE * 1.1294 / (2 * math.sin(math.radians(0.5)))
    return float(weighted_line_np(np.array(sine), length, "light") ** 2)


def test_beams_that_look_elsewhere_hear_side_lobes():
    rise = noise_of(scene(bearing=-0.3)) / noise_of(scene(noise={"level_db": -50.0}))
    assert rise.argmax() == 32 + round(math.degrees(0.3))
    away = np.abs(np.arange(65) - rise.argmax()) > 4
    assert rise[away].max() < 0.02 * rise.max()


def test_what_stands_between_keeps_it_off():
    wall = box((10.0, 0.0, DEEP), (0.5, 40.0, 40.0))
    far = {"range_max_m": 8.0, "range_min_m": 1.0}
    assert noise_of(scene(wall, **far)) == pytest.approx(noise_of(scene(wall, noise={"level_db": -50.0}, **far)))
    beside = box((10.0, 30.0, DEEP), (0.5, 40.0, 40.0))
    assert noise_of(scene(beside, **far))[32] > 100 * noise_of(scene(wall, **far))[32]


class Stream(StillWater):
    """Water that flows as the vehicle of `scene` moves at 0.4 of its speed."""

    def current(self, position, t, copy=None):
        still = 0.0 * position[0]
        return jit.Array3f64(still - 0.6 * 0.4 * SPEED, still, still + 0.8 * 0.4 * SPEED)


def test_speed_counts_through_the_water():
    """With 0.4 of its speed for a current the vehicle has 0.6 of it through the water: 60 log10(0.6) dB less."""
    still, carried = scene(), scene(ocean=Stream(dr.opaque(jit.Float64, 1500.0)))
    ratio = noise_of(carried)[32] / noise_of(still)[32]
    assert ratio == pytest.approx(0.6**6, rel=0.02)


def test_a_vehicle_in_the_air_is_not_heard():
    above, quiet = scene(up=-DEEP + 2.5), scene(up=-DEEP + 2.5, noise={"level_db": -50.0})
    assert np.array_equal(noise_of(above), noise_of(quiet))


@pytest.mark.parametrize(("key", "own", "other"), [("all", 1, 1), ("others", 0, 1), ("own", 1, 0), ("none", 0, 0)])
def test_the_key_says_whose_noise(key, own, other):
    def heard(maker):
        with pytest.warns(ValidityWarning, match="leaves out") if not {"auv0": own, "auv1": other}[maker] else _still():
            sonar = scene(maker=maker, vehicle_noise=key)
        return noise_of(sonar)[32] > 3 * noise_of(scene(noise={"level_db": -50.0}))[32]

    assert (heard("auv0"), heard("auv1")) == (bool(own), bool(other))


def _still():
    from contextlib import nullcontext

    return nullcontext()


@pytest.mark.parametrize("keys", [{"elements": True}, {"channel_gain_db": 1.5}])
def test_elements_refuse_it_and_say_what_forms_them(keys):
    with pytest.raises(InputError, match=r"elements hear no noise of vehicles.*no errors of channels"):
        scene(**keys)


def test_a_multibeam_s_snr_falls_where_it_looks_at_a_noisy_hull():
    """By 1 + N'/N of the closed form in the beam that looks there, and by next to nothing far from it."""
    neighbours = Neighbours((), noises={"auv1": noise_source(ThrusterNoise(**(PATTERN | {"level_db": 118.0})))})
    neighbours.motion_of = lambda agent: at(0.0, 11.0, DEEP - 10.0, velocity=(0.0, 0.0, -SPEED))
    config = MultibeamConfig(beams=121, range_max_m=60.0, water_column_bins=200, bandwidth_hz=10e3, range_min_m=1.0)
    noisy, still = (Multibeam(config, replace(context([plane(DEEP - 20.0)]), neighbours=n)) for n in (neighbours, None))
    a, b = (s.sense(at(0.0, 0.0, DEEP)) for s in (noisy, still))
    fall = b.extras["snr"][0] - a.extras["snr"][0]
    direction = noisy.tables["direction"].astype(float)
    hull = np.array([0.0, 11.0, -10.0]) / math.sqrt(221.0)
    looks = int(np.argmax(direction @ hull))
    assert np.argmax(fall) == looks
    off = math.acos(direction[looks] @ hull)
    pattern = _uniform(off) ** 2
    level = 118.0 - 20 * math.log10(400e3 / 8e3) + 60 * math.log10(SPEED / 1.6)
    received = level - 10 * math.log10(221.0) - loss(400e3) * math.sqrt(221.0)
    own = 10 * math.log10(10**4.5 + 10**3.704) - 10 * math.log10(4 * math.pi / math.radians(1.0) / math.radians(60.0))
    assert fall[looks] == pytest.approx(10 * math.log10(1 + pattern * 10 ** (0.1 * (received - own))), abs=0.4)
    assert np.abs(np.delete(fall, range(max(looks - 30, 0), looks + 31))).max() < 0.3
    rise = (a.extras["water_column"] - b.extras["water_column"])[0, :, :40].mean(axis=1)
    assert abs(int(rise.argmax()) - looks) <= 1
    assert rise.max() > 3.0


def _uniform(off: float) -> float:
    """A line of 1 deg half-power width, off its axis."""
    x = math.pi * 0.4429 / math.sin(math.radians(0.5)) * math.sin(off)
    return math.sin(x) / x


def fleet(*, count: int, copies: int, radiated: bool = True) -> list[np.ndarray]:
    """Noise that each of some alike vehicles hears of itself and of a ship."""
    sonar = {"type": "singlebeam", "rate_hz": 10, "bins": 64, "range_max_m": 30.0, "iq": True}
    loud = {"radiated_noise": {"type": "thrusters", "level_db": 150.0, "speed_mps": 1.0}} if radiated else {}
    scenario = {
        "seed": 5,
        "tick_rate_hz": 20,
        "world": {"type": "flat", "depth_m": 90.0},
        "agents": {
            **{
                f"auv{k}": {
                    "vehicle": "remus100",
                    "start": {"position_m": [7.0 * k, -3.0 * k], "depth_m": 20.0 + 2 * k, "speed_mps": 1.0 + 0.3 * k},
                    "sensors": {"it": sonar},
                    **(loud if k != 1 else {}),
                }
                for k in range(count)
            },
            "ship": {
                "vehicle": "remus100",
                "start": {"position_m": [3.0, 9.0], "depth_m": 1.0, "speed_mps": 2.0},
                **({"radiated_noise": {"type": "ship", "length_m": 60.0, "ship_class": "tug"}} if radiated else {}),
            },
        },
    }
    sim = pl.Simulation.load(scenario, n=copies)
    for _ in range(4):
        obs = sim.step()
    return [obs[f"auv{k}"]["it"].extras["iq"] for k in range(count)]


def test_alike_vehicles_and_copies_hear_what_one_alone_does():
    """Vehicles that are read in one call hear each its own, the ship and one another, in every copy."""
    one, many = fleet(count=3, copies=1), fleet(count=3, copies=2)
    silent = fleet(count=3, copies=1, radiated=False)
    for k in range(3):
        assert np.array_equal(one[k][0], many[k][0])
        assert (np.abs(one[k]) ** 2).mean() > 2.0 * (np.abs(silent[k]) ** 2).mean()
    assert np.abs(one[0]).mean() != np.abs(one[1]).mean()


def test_a_head_that_turns_hears_it_where_it_looks():
    """A step of 6 deg a ping, all around: the loudest ping is the one whose beam looks at the vehicle, to starboard."""
    neighbours = Neighbours((), noises={"auv1": noise_source(ThrusterNoise(**PATTERN))})
    bearing = math.radians(-71.0)
    neighbours.motion_of = lambda agent: at(
        20.0 * math.cos(bearing), 20.0 * math.sin(bearing), DEEP, velocity=(0.0, -SPEED, 0.0)
    )
    config = MechanicalScanningSonarConfig(step_deg=6.0, bins=128, range_max_m=20.0, rays=64, iq=True, rate_hz=10.0)
    sonar = MechanicalScanningSonar(config, replace(context([plane(DEEP - 100.0)]), neighbours=neighbours))
    readings = [sonar.sense(at(0.0, 0.0, DEEP, tick=20 * k)) for k in range(60)]
    loudest = max(readings, key=lambda r: (np.abs(r.extras["iq"][0]) ** 2).mean())
    off = float(loudest.extras["angle"][0]) - bearing
    assert abs(math.degrees(math.remainder(off, 2 * math.pi))) < 3.1
