"""Raw signals of DVL and ADCP: what pulse pairs tell of speeds, and how surely."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import numpy as np
import pytest
from sonar_scenes import DT_NS, StillWater, context, plane

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.pulse import point_spread, range_resolution
from pelagos.acoustics.pulse_pair import BEAM_SPREAD, pair_deviation, pulse_correlation, speed_of_pair, speed_per_radian
from pelagos.acoustics.spreading import from_db
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.keys.echo_keys import echo_spec
from pelagos.sensors.sonar.ping.beam_echoes import beam_cones
from pelagos.sensors.sonar.ping.ping_spec import PingSpec, noise_power

DEEP, C, LAG, F = -200.0, 1500.0, 1e-4, 600e3
PAIR = {"frequency_hz": F, "sound_speed": C, "lag_s": LAG}
RADIAN = speed_per_radian(**PAIR)  # 1.99 m/s
PINGS, FEWER = 200, 120  # of the profiler, and of the log


def scatter(count: int) -> float:
    """Four standard deviations of an estimated standard deviation, in parts of it: 4/sqrt(2 n)."""
    return 4.0 / math.sqrt(2.0 * count)


@dataclass
class Sheared(StillWater):
    """A current that grows by 0.05 m/s a metre upwards and turns with depth; a Dr.Jit struct."""

    def current(self, position, t, copy=None):
        north, west, _ = flow(position[2])
        return jit.Array3f64(north, west, 0.0 * position[0])


def flow(z):
    """Current [m/s] at the height z [m]."""
    sine = dr.sin if dr.is_array_v(z) else np.sin
    return 0.6 + 0.05 * (z - DEEP), 0.3 * sine(0.3 * z), 0.0 * z


def sheared() -> Sheared:
    return Sheared(dr.opaque(jit.Float64, C))


def told(config: AdcpConfig | DvlConfig) -> PingSpec:
    """Pulse and levels of the raw echoes; bins and ranges are of no matter."""
    return echo_spec(config, context([plane()]), nearest=1.0, farthest=30.0)


def coherence_of(deviation: float, samples: float) -> float:
    """The coherence at which so many independent strong pairs have that deviation [m/s] (Zrnic 1977)."""
    return 1.0 / math.sqrt(1.0 + 2.0 * samples * (deviation / RADIAN) ** 2)


def test_rms_angle_of_a_gaussian_beam_both_ways():
    """Half the power at half the width W: exp(-4 ln 2 a^2/W^2) one way, its square both ways; the rms by quadrature."""
    width = 0.07
    angle = np.linspace(-3.0 * width, 3.0 * width, 20_001)
    both = np.exp(-4.0 * math.log(2.0) * (angle / width) ** 2) ** 2
    assert math.sqrt((both * angle**2).sum() / both.sum()) == pytest.approx(BEAM_SPREAD * width, rel=1e-6)


def test_deviation_of_pairs_by_many_of_them():
    """10 000 echoes drawn as Gaussian pairs with noise, the pulse over two bins; 4 standard deviations of both."""
    rng = np.random.Generator(np.random.PCG64(1))
    bins, count, coherence, noise, turn = 40, 10_000, 0.97, 0.05, 0.4
    power = np.linspace(0.3, 2.0, bins)
    pulse = point_spread(0.7, 1.0).astype(np.float64)
    z = (rng.normal(size=(2, count, bins)) + 1j * rng.normal(size=(2, count, bins))) * math.sqrt(0.5)
    later = np.exp(1j * turn) * (coherence * z[0] + math.sqrt(1 - coherence**2) * z[1])
    heard = [np.apply_along_axis(np.convolve, 1, e, pulse, mode="same") * np.sqrt(power) for e in (z[0], later)]
    hiss = (rng.normal(size=(2, count, bins)) + 1j * rng.normal(size=(2, count, bins))) * math.sqrt(0.5 * noise)
    iq = np.stack([heard[0] + hiss[0], heard[1] + hiss[1]], axis=1)
    found = speed_of_pair(iq, **PAIR)
    expected = pair_deviation(power, noise=noise, coherence=coherence, pulse=pulse, per_radian=RADIAN)
    assert found.mean() == pytest.approx(turn * RADIAN, abs=4 * expected / math.sqrt(count))
    # the first two and last two bins hear less of the pulse: 4 of 40, up to a half each
    assert found.std() == pytest.approx(expected, rel=scatter(count) + 0.03)


class TestAdcp:
    @pytest.fixture(scope="class")
    @staticmethod
    def profile():
        """A vehicle that moves and turns, in a sheared current, far above the bottom; speeds and their truth."""
        config = AdcpConfig(iq=True, water_column_bins=480)
        sonar = Adcp(config, context([plane(DEEP - 60.0)], ocean=sheared()))
        velocity = (1.2, 0.2, -0.1)
        motion = lanes(range(PINGS), dt_ns=DT_NS, position=(0, 0, DEEP), velocity=velocity)
        iq = sonar.sense(motion).extras["iq"]
        r = sonar.tables["water_column_range"].astype(np.float64)
        return config, iq, r, np.array(velocity)

    def cells(self, config, r):
        tilt = math.cos(math.radians(config.beam_tilt_deg))
        return tilt, [np.abs(r * tilt - depth) < 0.5 * config.cell_m for depth in config.depths]

    def test_pairs_tell_the_waters_velocity_by_cell_and_beam(self, profile):
        """In 30 cells and 4 beams at once: 4.5 standard deviations of the mean of 200 pings. Bins are weighted by
        power, which falls with the range; over a cell the current changes by at most 0.1 m/s, and the middle of power
        lies off that of the cell by less than 1/30 of it from the third cell on: 3 mm/s."""
        config, iq, r, velocity = profile
        assert iq.shape == (PINGS, 4, 2, 480)
        tilt, cells = self.cells(config, r)
        for k, cell in enumerate(cells[2:], start=2):
            found = speed_of_pair(iq[..., cell], **PAIR)
            water = np.stack(flow(DEEP - r[cell] * tilt), axis=-1) - velocity
            closing = -(water @ config.beams.T).mean(axis=0)
            assert found.mean(axis=0) == pytest.approx(closing, abs=4.5 * 0.1 / math.sqrt(PINGS) + 0.003), k

    @pytest.mark.parametrize("k", [3, 10, 20, 29])
    def test_their_deviation_is_the_sheets_and_the_noises(self, profile, k):
        """Coherence from `noise_mps` and from the beam's width; noise and the water's level by the sonar equation."""
        config, iq, r, _ = profile
        tilt, cells = self.cells(config, r)
        width = r[1] - r[0]
        pulse = point_spread(width, range_resolution(C, config.bandwidth_hz))
        samples = 1.0 / tilt / width / (pulse_correlation(pulse) ** 2).sum()
        spread = 1.2 * BEAM_SPREAD * math.radians(config.beamwidth_deg)
        coherence = coherence_of(config.noise_mps, samples) * math.exp(-0.5 * (spread / RADIAN) ** 2)
        psi = beam_cones(config.beams[:1], math.radians(config.beamwidth_deg), 512)["weight"].sum()
        loss = 0.1570  # [dB/m], Francois and Garrison at 600 kHz, 10 C, 35, 200 m
        power = from_db(-75.0) * psi * told(config).equivalent_m / r**2 * 10 ** (-0.2 * loss * r)
        beam = math.radians(config.beamwidth_deg)
        expected = pair_deviation(
            power[cells[k]],
            noise=noise_power(told(config), beam, beam),
            coherence=coherence,
            pulse=pulse,
            per_radian=RADIAN,
        )
        found = speed_of_pair(iq[..., cells[k]], **PAIR)
        assert (found - found.mean(axis=0)).std() == pytest.approx(expected, rel=scatter(4 * PINGS) + 0.03)

    def test_strong_echoes_are_as_sure_as_the_sheet_says(self, profile):
        """The cells 2 to 4 stand far above noise: `noise_mps` a cell of a metre; neighbouring cells share a pulse."""
        config, iq, r, _ = profile
        _, cells = self.cells(config, r)
        found = np.stack([speed_of_pair(iq[..., cell], **PAIR) for cell in cells[2:5]])
        deviation = (found - found.mean(axis=1, keepdims=True)).std()
        assert deviation == pytest.approx(config.noise_mps, rel=scatter(4 * 3 * PINGS) + 0.05)


class TestDvl:
    places = np.array([0, 0, DEEP]) + np.arange(FEWER)[:, None] * np.array([0.1, 0.03, 0])

    def speeds(self, config, motion, altitude=12.0):
        reading = Dvl(config, context([plane(DEEP - altitude)])).sense(
            lanes(range(FEWER), dt_ns=DT_NS, position=self.places, **motion)
        )
        return speed_of_pair(reading.extras["iq"], **PAIR), reading

    def spread(self, config, velocity):
        """Rms closing speed within a beam about its mean, by beam [m/s]."""
        rays = beam_cones(config.beams, math.radians(config.beamwidth_deg), 512)
        speed, weight = (v.reshape(4, 512) for v in (rays["direction"] @ np.array(velocity), rays["weight"]))
        mean = (speed * weight).sum(axis=1) / weight.sum(axis=1)
        return np.sqrt(((speed - mean[:, None]) ** 2 * weight).sum(axis=1) / weight.sum(axis=1))

    @pytest.mark.parametrize(
        "motion",
        [
            pytest.param({"velocity": (1.5, 0.3, -0.1)}, marks=pytest.mark.slow),
            {"velocity": (-2.0, 1.0, 0.4)},
            {"angular_velocity": (0, 0, 0.5)},
        ],
    )
    def test_pairs_tell_the_speed_along_each_beam(self, motion):
        """Means of 120 pings, 4 standard deviations of 1 cm/s, with a lever arm of 2 m. Steeper parts of a beam are
        nearer and louder, by which it reads up to 0.3 % of the speed less (terrain bias)."""
        config = DvlConfig(iq=True, noise_mps=0.0, noise_relative=0.0, range_max_m=30.0, position_m=(2.0, 0, 0))
        found, reading = self.speeds(config, motion)
        assert reading.extras["iq"].shape == (FEWER, 4, 2, 2048)
        truth = reading.extras["beam_velocity"][0]
        assert found.mean(axis=0) == pytest.approx(truth, abs=4 * 0.01 / math.sqrt(FEWER) + 0.003 * 2.0)

    @pytest.mark.parametrize("assumed", [None, 1400.0])
    def test_what_moves_under_it_turns_the_echoes_too(self, assumed):
        """A floor 40 m wide slides by at 1.5 m/s, 30 m north and 40 m east of its way in 50: its part along each beam
        is d.v; 4 standard deviations of 1 cm/s, and 0.3 % of terrain bias, see above. An assumed sound speed moves the
        echoes in range, where they turn as before, and scales what the log reads."""
        floor = {"name": "floor", "body": "box", "size_m": 40.0, "path": {
            "kind": "waypoints", "points_m": [[0, 0, -38], [30, -40, -38]], "speed_mps": 1.5}}  # fmt: skip
        dvl = {"type": "dvl", "rate_hz": 5, "iq": True, "noise_mps": 0.0, "noise_relative": 0.0}
        dvl |= {} if assumed is None else {"sound_speed_mps": assumed}
        sim = pl.Simulation.load({
            "world": {"type": "flat", "depth_m": 60, "movers": [floor]}, "tick_rate_hz": 20, "seed": 3,
            "agents": {"a": {"vehicle": "bluerov2_heavy", "start": {"depth_m": 5}, "sensors": {"dvl": dvl}}},
        })  # fmt: skip
        found = []
        while len(found) < 3:
            found += sim.step()["a"].values()
        measured = np.array([speed_of_pair(r.extras["iq"][0], **PAIR) for r in found])
        truth = np.array([r.extras["beam_velocity"][0] for r in found]) * (C / (assumed or C))
        rock = sim.state["a"].velocity[0]
        assert np.abs(rock).max() < 0.02  # nothing but the floor moves
        axes = DvlConfig().beams
        assert truth == pytest.approx(np.tile(axes @ [-0.9, 1.2, 0.0], (3, 1)), abs=0.05)
        assert measured == pytest.approx(truth, abs=4 * 0.01 + 0.003 * 1.5)

    @pytest.mark.parametrize("altitude", [3.0, 12.0, pytest.param(25.0, marks=pytest.mark.slow)])
    def test_at_rest_they_are_as_sure_as_the_sheet_and_the_published_speeds(self, altitude):
        """The echo is strong; at 3 m it is a handful of samples, for which the phase's variance is above its limit."""
        config = DvlConfig(iq=True)
        found, reading = self.speeds(config, {}, altitude)
        sigma = reading.extras["sigma"]
        assert sigma == pytest.approx(config.noise_mps, rel=0.01)
        slack = 0.25 if altitude < 5.0 else 0.05
        assert found.std() == pytest.approx(config.noise_mps, rel=scatter(4 * FEWER) + slack)

    @pytest.mark.parametrize("speed", [1.0, 3.0])
    def test_under_way_the_width_of_the_beams_adds_to_it(self, speed):
        """Doppler broadening: echoes from the beam's edges turn at other speeds, which takes from the coherence.

        The spread is that of the whole beam, within samples and between them; what neighbouring samples share of it is
        not quite what they share of the pulse: 10 %.
        """
        config = DvlConfig(iq=True, noise_mps=0.0, noise_relative=0.0, range_max_m=60.0)
        velocity = (speed, 0.0, 0.0)
        found, reading = self.speeds(config, {"velocity": velocity}, 20.0)
        r = Dvl(config, context([plane(DEEP - 20.0)])).tables["water_column_range"]
        iq = reading.extras["iq"]
        power = (np.abs(iq[:, :, 0]) ** 2).mean(axis=(0, 1)).astype(np.float64)
        pulse = point_spread(float(r[1] - r[0]), range_resolution(C, config.bandwidth_hz))
        expected = [
            pair_deviation(
                power, noise=0.0, coherence=1 / math.sqrt(1 + (s / RADIAN) ** 2), pulse=pulse, per_radian=RADIAN
            )
            for s in self.spread(config, velocity)
        ]
        deviation = (found - found.mean(axis=0)).std(axis=0)
        assert deviation == pytest.approx(np.array(expected), rel=scatter(FEWER) + 0.1)

    def test_noise_takes_from_far_echoes(self):
        """The echo's level as it is told by the truth, the noise by the sonar equation: 4 standard deviations."""
        config = DvlConfig(iq=True, noise_mps=0.0, noise_relative=0.0, source_level_db=200.0)
        found, reading = self.speeds(config, {}, 35.0)
        beam = math.radians(config.beamwidth_deg)
        noise = noise_power(told(config), beam, beam)
        r = Dvl(config, context([plane(DEEP - 35.0)])).tables["water_column_range"].astype(np.float64)
        width = r[1] - r[0]
        level = 10 ** (reading.extras["water_column_truth"].mean(axis=(0, 1)) / 10)
        power = level * beam * told(config).equivalent_m / (r**3 * 10 ** (0.2 * 0.1570 * r))
        pulse = point_spread(float(width), range_resolution(C, config.bandwidth_hz))
        expected = pair_deviation(power, noise=noise, coherence=1.0, pulse=pulse, per_radian=RADIAN)
        assert found.std() == pytest.approx(expected, rel=scatter(4 * FEWER) + 0.05)

    @pytest.mark.parametrize("altitude", [2.0, 20.0])
    def test_echoes_are_as_strong_as_their_truth_however_dense_the_rays(self, altitude):
        """Interference leaves the mean power: some 6 independent echoes a beam at 2 m, in 24 footprints."""
        _, reading = self.speeds(DvlConfig(iq=True), {}, altitude)
        truth, data = (10 ** (reading.extras[f"water_column{k}"] / 10) for k in ("_truth", ""))
        heard = truth.mean(axis=(0, 1)) > 1e-3 * truth.max()
        ratio = data[..., heard].sum() / truth[..., heard].sum()
        assert ratio == pytest.approx(1.0, abs=4 / math.sqrt(24 * 4 * 2))
