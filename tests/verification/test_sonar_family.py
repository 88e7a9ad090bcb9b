"""Single-beam, profiling, sidescan, mechanically scanning and synthetic aperture sonars, and the ADCP."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import trapezoid
from sonar_scenes import DT_NS, PLAIN, LayeredWater, StillWater, at, box, context, plane, sphere, still_water

from cases import slow
from pelagos import jit
from pelagos.acoustics.beam_pattern import shaded_length, weighted_line_np
from pelagos.errors import ValidityWarning
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar, MechanicalScanningSonarConfig
from pelagos.sensors.sonar.profiling_sonar import ProfilingSonar, ProfilingSonarConfig
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig
from pelagos.world.material import MATERIALS

QUIET = {"self_noise_db": -200.0, "source_level_db": 300.0, "wind_speed_mps": 0.0, "scale": "linear"}
DEEP = -200.0  # keeps the sea surface out of the picture


@dataclass
class SlantedWater(StillWater):
    """Water whose current changes linearly about a place, u + G (p - p0), and north by 3 m/s in a second; a Dr.Jit
    struct.
    """

    u: Any
    v: Any
    w: Any
    xx: Any
    xy: Any
    xz: Any
    yx: Any
    yy: Any
    yz: Any
    zx: Any
    zy: Any
    zz: Any
    x0: Any
    y0: Any
    z0: Any

    def current(self, position: Any, t: Any, copy: Any = None) -> Any:
        x, y, z = position.x - self.x0, position.y - self.y0, position.z - self.z0
        return jit.Array3f64(
            self.u + 3.0 * t + self.xx * x + self.xy * y + self.xz * z,
            self.v + self.yx * x + self.yy * y + self.yz * z,
            self.w + self.zx * x + self.zy * y + self.zz * z,
        )


@pytest.fixture(autouse=True)
def _plain_surfaces(monkeypatch):
    monkeypatch.setattr("pelagos.sensors.sonar.ping.patches.patch_factor", lambda *_: 1.0)


def below(height: float):
    return plane(DEEP - height)


def one_way(sine, width_deg: float, shading: str = "uniform"):
    """Power pattern of a line of a half-power width."""
    return weighted_line_np(sine, shaded_length(math.radians(width_deg), shading), shading) ** 2


class TestSinglebeam:
    def test_bottom_echo_begins_at_the_depth_and_ends_at_the_cones_edge(self):
        config = SinglebeamConfig(range_max_m=30, bins=600, bandwidth_hz=60e3, **QUIET)
        s = Singlebeam(config, context([below(12.0)]))
        reading = s.sense(at(0, 0, DEEP))
        assert reading.data.shape == (1, 600)
        heard = reading.tables["range"][reading.truth[0] > 1e-3 * reading.truth[0].max()]
        assert heard[0] == pytest.approx(12.0, abs=0.06)
        assert 12.0 / math.cos(math.radians(5)) < heard[-1] < 12.0 / math.cos(math.radians(10.5))

    def test_energy_is_that_of_the_lambert_law_at_normal_incidence(self):
        """Sum over the bins of sigma times pattern over the cone: the beam is narrow, so that sigma is mu."""
        levels = []
        for rays in (64, 256):
            s = Singlebeam(SinglebeamConfig(range_max_m=30, rays=rays, bins=300, **QUIET), context([below(12.0)]))
            r = s.tables["range"].astype(float)
            cell = math.radians(9.0) * s.config.bin_width_m
            levels.append((s.sense(at(0, 0, DEEP)).truth[0] / r**3 * cell).sum() * 12.0**2)
        assert levels[0] == pytest.approx(levels[1], rel=0.01)
        from pelagos.acoustics.beam_pattern import line_length, line_np

        a = np.linspace(0, math.radians(9) * 1.129, 4001)
        weight = 2 * np.pi * np.sin(a) * line_np(np.sin(a), line_length(math.radians(9))) ** 4
        solid = trapezoid(weight * np.cos(a) ** 3, a)  # sigma ~ cos^2, 1/sine ~ 1/cos, r^-2 ~ cos^2
        assert levels[1] == pytest.approx(10**-2.7 * solid, rel=0.02)

    def test_a_live_change_is_seen_by_the_next_ping(self):
        """A body that is spawned, moved and removed; nothing is cached."""
        c = context([below(20.0)])
        s = Singlebeam(SinglebeamConfig(range_max_m=30, bins=300, bandwidth_hz=60e3, **QUIET), c)
        first = lambda: s.tables["range"][np.argmax(s.sense(at(0, 0, DEEP)).truth[0] > 1e-6)]
        still = np.zeros((1, 3))
        level = np.array([[1.0, 0, 0, 0]])
        assert first() == pytest.approx(20.0, abs=0.11)
        c.scene.set_moving([(box((0, 0, 0), (4, 4, 1)), 0)])
        c.scene.move(np.array([[0, 0, DEEP - 10.5]]), level, still, still)
        assert first() == pytest.approx(10.0, abs=0.11)
        c.scene.move(np.array([[0, 0, DEEP - 5.5]]), level, still, still)
        assert first() == pytest.approx(5.0, abs=0.11)
        c.scene.set_moving([])
        assert first() == pytest.approx(20.0, abs=0.11)


class TestSidescan:
    def sonar(self, geometries, **options):
        return Sidescan(SidescanConfig(**({"range_max_m": 50.0, "bins": 1000} | QUIET | options)), context(geometries))

    def test_first_return_is_the_altitude_and_both_sides_agree_over_a_flat_bottom(self):
        s = self.sonar([below(8.0)])
        reading = s.sense(at(0, 0, DEEP))
        assert reading.extras["altitude"] == pytest.approx([8.0], abs=0.8)  # the null of the pattern is straight down
        assert (reading.truth[0, :, s.tables["range"] < 7.9] == 0).all()
        far = s.tables["range"] > 12
        assert reading.truth[0, 0, far] == pytest.approx(reading.truth[0, 1, far], rel=0.05)

    @pytest.mark.parametrize(("height", "distance"), [(0.5, 15.0), (1.0, 15.0), (1.0, 25.0)])
    def test_shadow_length_is_height_times_range_over_altitude(self, height, distance):
        altitude = 8.0
        wall = box((0, distance + 0.05, DEEP - altitude + height / 2), (4.0, 0.1, height))
        s = self.sonar([below(altitude), wall])
        reading = s.sense(at(0, 0, DEEP))
        trace, slant = reading.truth[0, 0], s.tables["range"]
        behind = slant > math.hypot(distance, altitude) + 0.3
        dark = slant[behind & (trace < 1e-3 * trace[slant > 12].mean())]
        reach = math.sqrt(dark[-1] ** 2 - altitude**2)
        expected = (distance + 0.1) * height / (altitude - height)
        # a stratum of 0.1 deg covers r^2/h d(angle) = 0.06 to 0.15 m of the bottom
        assert reach - (distance + 0.1) == pytest.approx(expected, abs=0.2)
        other = reading.truth[0, 1]
        assert (other[behind] > 0).all()

    def test_ground_range(self):
        reading = self.sonar([below(8.0)]).sense(at(0, 0, DEEP))
        h, r = reading.extras["altitude"][0], reading.tables["range"]
        seen = r >= h
        assert reading.extras["ground_range"][0][seen] == pytest.approx(np.sqrt(r[seen] ** 2 - h**2), rel=1e-5)
        assert np.isnan(reading.extras["ground_range"][0][~seen]).all()


class TestScanning:
    def test_head_turns_by_its_step_and_finds_a_target_where_it_is(self):
        config = MechanicalScanningSonarConfig(rate_hz=10.0, step_deg=6.0, range_max_m=40, **QUIET)
        s = MechanicalScanningSonar(config, context([sphere((0, 20, DEEP), 1.0)]))
        period = round(1e9 / DT_NS / 10)
        reading = s.sense(lanes(np.arange(60) * period, dt_ns=DT_NS, position=(0, 0, DEEP)))
        angle, level = reading.extras["angle"], reading.truth.sum(axis=1)
        assert np.diff(angle) == pytest.approx(np.full(59, -math.radians(6)), abs=1e-6)
        assert angle[np.argmax(level)] == pytest.approx(math.pi / 2, abs=math.radians(3.1))
        peak = reading.tables["range"][np.argmax(reading.truth[np.argmax(level)])]
        assert peak == pytest.approx(19.0, abs=0.2)

    def test_a_sector_is_swept_to_and_fro(self):
        config = MechanicalScanningSonarConfig(sector_deg=90, step_deg=30)
        degrees = np.degrees(config.angles(np.arange(8)))
        assert degrees == pytest.approx([45, 15, -15, -45, -15, 15, 45, 15])

    def test_the_head_stays_in_its_sector(self):
        config = MechanicalScanningSonarConfig(sector_deg=100, step_deg=30)
        assert np.degrees(config.angles(np.arange(5))) == pytest.approx([50, 20, -10, -40, -10])
        with pytest.raises(ValidationError, match="step_deg 40 must be at most sector_deg 30"):
            MechanicalScanningSonarConfig(sector_deg=30, step_deg=40)


class TestProfiling:
    def test_profile_of_a_flat_bottom(self):
        config = ProfilingSonarConfig(orientation_deg=(0, 90, 0), range_max_m=40, side_lobe_beams=0, **QUIET)
        s = ProfilingSonar(config, context([below(10.0)]))
        reading = s.sense(at(0, 0, DEEP))
        exact = 10.0 / np.cos(s.tables["azimuth"])
        found = reading.extras["profile_truth"][0]
        inner = np.abs(s.tables["azimuth"]) < math.radians(50)
        assert found[inner] == pytest.approx(exact[inner], rel=0.02)


class TestSyntheticAperture:
    def test_a_point_has_the_phase_history_of_its_distance(self, monkeypatch):
        monkeypatch.setattr("pelagos.acoustics.echo_sum.facet_place", lambda word: 0.5)
        """Phase -4 pi f r/c: its second difference along the track is that of the hyperbola."""
        config = SyntheticApertureSonarConfig(facet_m=4.0, rays=40000, roughness_seed=3, **QUIET)
        ball = sphere((2.0, 22.0, -198.0), 0.5)
        s = SyntheticApertureSonar(config, context([ball]))
        x = np.arange(-0.5, 0.5, 0.02)
        data = np.stack([s.sense(at(float(v), 0, -190.0)).data[0] for v in x])
        column = int(np.argmax(np.abs(data).sum(axis=0)))
        # all of the ball lies in one facet of the lattice, whose middle is at (2, 22, -198)
        r = np.sqrt((x - 2.0) ** 2 + 22.0**2 + 8.0**2)
        turned = data[:, column] * np.exp(4j * np.pi * config.frequency_hz * r / 1500.0)
        phase = np.unwrap(np.angle(turned))
        assert np.ptp(phase) < 0.3  # single precision: 0.05 rad

    def test_focusing_gains_resolution(self, monkeypatch):
        monkeypatch.setattr("pelagos.acoustics.echo_sum.facet_place", lambda word: 0.5)
        """Back-projection over 4 m of track brings a ball of 0.2 m to a peak of a quarter of a metre.

        Of 40 000 rays some twenty meet the ball, enough for the beam pattern to show in a single range along the track.
        """
        config = SyntheticApertureSonarConfig(
            facet_m=1.0, rays=40000, range_min_m=15, range_max_m=23, bins=320, **QUIET
        )
        s = SyntheticApertureSonar(config, context([sphere((0.5, 18.5, -191.5), 0.2)]))
        x = np.arange(-1.5, 2.5, 0.02)  # less than half an element: 0.886 wavelengths/15 deg/2
        track = np.stack([x, 0 * x, 0 * x - 190.0], axis=1)
        data = s.sense(lanes(range(len(x)), dt_ns=DT_NS, position=track)).data
        line = np.linspace(-1.5, 2.5, 801)
        ranges = s.tables["range"].astype(float)
        image = np.zeros(len(line), complex)
        for v, trace in zip(x, data, strict=True):
            r = np.sqrt((line - v) ** 2 + 18.5**2 + 1.5**2)
            k = np.clip(np.round((r - ranges[0]) / (ranges[1] - ranges[0])).astype(int), 0, len(ranges) - 1)
            image += trace[k] * np.exp(4j * np.pi * config.frequency_hz * r / 1500.0)
        level = np.abs(image) ** 2
        assert line[np.argmax(level)] == pytest.approx(0.5, abs=0.1)
        wide = line[level > 0.5 * level.max()]
        assert np.ptp(wide) < 0.25
        single = np.abs(data[:, int(np.argmax(np.abs(data).sum(axis=0)))]) ** 2
        assert np.ptp(x[single > 0.5 * single.max()]) > 4 * np.ptp(wide)


class TestAdcp:
    @pytest.mark.parametrize("height", [10.5, 10.0])
    def test_uniform_flow_is_measured_in_the_sensor_frame_down_to_the_bottom(self, height):
        s = Adcp(AdcpConfig(noise_mps=0.0), context([below(height)]))
        reading = s.sense(at(0, 0, DEEP, velocity=(1.5, -0.2, 0.13)))
        free = reading.extras["cell_valid"][0]
        assert reading.data[0][free] == pytest.approx(np.tile([-1.5, 0.2, -0.13], (free.sum(), 1)), abs=1e-6)
        # the side lobe's echo drowns the water beyond altitude cos(tilt): cells that end above height cos(20)
        edge = reading.tables["depth"] + 0.5
        np.testing.assert_array_equal(free, edge < height * math.cos(math.radians(20)))
        assert np.isnan(reading.data[0][~free]).all()

    def test_noise_is_that_of_the_beams(self):
        s = Adcp(AdcpConfig(noise_mps=0.02, cells=3), context([below(50.0)]))
        error = s.sense(lanes(range(4000), dt_ns=DT_NS, position=(0, 0, DEEP))).data
        expected = 0.02 / (math.sqrt(2) * math.sin(math.radians(20)))
        assert error[..., 0].std(axis=0) == pytest.approx(np.full(3, expected), rel=0.05)
        assert error[..., 2].std(axis=0) == pytest.approx(np.full(3, 0.01 / math.cos(math.radians(20))), rel=0.05)
        every = np.corrcoef(error.reshape(len(error), 9).T)  # of each cell and axis alone
        np.testing.assert_allclose(every, np.eye(9), atol=4.5 / math.sqrt(4000))

    @pytest.mark.parametrize("down", [1, -1])
    def test_each_beam_reads_the_water_at_its_own_place(self, down):
        """Of a current u + G r about the sonar, beams in opposite pairs tilted by a, at a depth h below it, read
        (u - h (Gxz + Gzx), v - h (Gyz + Gzy), w - h Gzz - h (Gxx + Gyy) tan^2(a) / 2), where the truth on the axis is
        u - h G z. Two sonars at once, turned and at places of their own; of those that look up h is negative.
        """
        tensor = np.array([[0.011, -0.007, 0.013], [0.004, 0.006, -0.009], [-0.008, 0.005, 0.002]])
        start, water = np.array([[3.0, -7.0, DEEP], [-11.0, 5.0, DEEP + 6.0]]), np.array([0.4, -0.3, 0.05])
        config = AdcpConfig(noise_mps=0.0, beam_tilt_deg=40.0, cells=4, cell_m=2.0, blank_m=1.0)
        yaws = np.array([0.6, -2.1])
        c, s, zero = np.cos(yaws / 2), np.sin(yaws / 2), 0 * yaws
        attitude = np.array([c, zero, zero, s] if down > 0 else [zero, c, s, zero]).T
        motion = lanes([4], dt_ns=DT_NS, environments=(0, 1), position=start, attitude=attitude, velocity=(0.2, 0.1, 0))
        ocean = SlantedWater(*(dr.opaque(jit.Float64, float(v)) for v in (1500, *water, *tensor.ravel(), *start[0])))
        reading = Adcp(config, context([below(90.0)], ocean=ocean, n=2)).sense(motion)
        h = np.array([2.0, 4.0, 6.0, 8.0])
        for lane, yaw in enumerate(yaws):
            c, s = math.cos(yaw), math.sin(yaw)
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.diag([1.0, down, down])  # from sensor
            u, v, w = here = turn.T @ (water + [0.06, 0.0, 0.0] + tensor @ (start[lane] - start[0])) - np.array(
                [0.2, 0.1, 0.0]
            )
            g = turn.T @ tensor @ turn
            beside = 0.5 * (g[0, 0] + g[1, 1]) * math.tan(math.radians(40)) ** 2
            read = [u - h * (g[0, 2] + g[2, 0]), v - h * (g[1, 2] + g[2, 1]), w - h * (g[2, 2] + beside)]
            np.testing.assert_allclose(reading.data[lane], np.array(read).T, atol=1e-6)
            np.testing.assert_allclose(reading.truth[lane], here - h[:, None] * g[:, 2], atol=1e-6)

    @pytest.mark.parametrize("beam", range(4))
    def test_what_one_beam_meets_drowns_the_water_beyond_for_all(self, beam):
        """The side lobes of the others hear it too: cells that end beyond its range times cos^2 of the tilt."""
        config = AdcpConfig(noise_mps=0.0)
        ball = sphere((np.array([0, 0, DEEP]) + 9.0 * config.beams[beam]).tolist(), 0.6)
        reading = Adcp(config, context([below(60.0), ball])).sense(at(0, 0, DEEP))
        ranges = reading.extras["ranges"][0]
        assert ranges.argmin() == beam
        assert ranges[beam] == pytest.approx(8.4, abs=0.01)
        edge = reading.tables["depth"] + 0.5
        np.testing.assert_array_equal(reading.extras["cell_valid"][0], edge < 8.4 * math.cos(math.radians(20)) ** 2)

    def test_the_bottom_drowns_cells_that_lie_farther_away_than_they_are_said_to(self):
        """Slow sound assumed, 1400 of 1560 m/s: the end of the last cell, 40.5 m, is at 45.1 m, the bottom at 45 or
        52 m, whose echo comes from 45 m cos(20 deg) and 52 m cos(20 deg) on: 42.3 and 48.9 m."""
        config = AdcpConfig(noise_mps=0.0, cells=40, sound_speed_mps=1400.0)
        for height, last in ((45.0, 42.3), (52.0, 48.9)):
            s = Adcp(config, context([below(height)], ocean=still_water(1560.0)))
            edge = (s.tables["depth"] + 0.5) * 1560 / 1400
            np.testing.assert_array_equal(s.sense(at(0, 0, DEEP)).extras["cell_valid"][0], edge < last)

    def test_it_measures_nothing_in_the_air(self):
        s = Adcp(AdcpConfig(noise_mps=0.0, cells=3), context([plane(-90.0)]))
        for height, wet in ((-0.5, True), (1.0, False)):
            reading = s.sense(at(0, 0, height))
            assert (reading.extras["cell_valid"] == wet).all()
            assert (np.isfinite(reading.data) == wet).all()

    def test_cells_end_before_the_next_ping_comes_along_the_beams(self):
        """100.5 m deep, 106.9 m along beams of 20 deg: 1400 m/s leave 100 m to 7 pings a second, 107.7 m to 6.5."""
        AdcpConfig(cells=10, cell_m=10.0, rate_hz=6.5)
        with pytest.raises(ValidationError, match=r"reach 106\.9 m along the beams.*7 pings a second: at most 100 m"):
            AdcpConfig(cells=10, cell_m=10.0, rate_hz=7)

    def test_beams_a_turn_apart_are_one(self):
        with pytest.raises(ValidationError, match="four different directions"):
            AdcpConfig(beam_azimuth_deg=(45.0, 135.0, -135.0, 405.0))

    def test_water_track_of_the_dvl(self):
        config = DvlConfig(water_layer_m=3.0, noise_mps=0.0, noise_relative=0.0)
        s = Dvl(config, context([below(10.0)]))
        found = s.sense(at(0, 0, DEEP, velocity=(1.0, 0.2, 0.1))).extras["water_velocity"]
        assert found[0] == pytest.approx([1.0, 0.2, 0.1], abs=1e-9)

    @pytest.mark.parametrize("assumed", [None, 1391.0, 1620.0])
    def test_the_layer_of_the_dvl_lies_where_its_time_says(self, assumed):
        """Of a current that changes with depth alone, at c'/c of the speed; the echo comes from 6 m times c/c'."""
        shear = np.array([[0, 0, 0.031], [0, 0, -0.017], [0, 0, 0]])
        ocean = SlantedWater(
            *(dr.opaque(jit.Float64, float(v)) for v in (1500, 0.3, -0.2, 0, *shear.ravel(), 0, 0, DEEP))
        )
        config = DvlConfig(water_layer_m=6.0, noise_mps=0.0, noise_relative=0.0, sound_speed_mps=assumed)
        found = Dvl(config, context([below(20.0)], ocean=ocean)).sense(at(0, 0, DEEP, velocity=(0.9, 0.4, 0.1)))
        ratio = (assumed or 1500.0) / 1500.0
        through = np.array([0.6, 0.6, 0.1]) + shear[:, 2] * 6.0 / ratio
        np.testing.assert_allclose(found.extras["water_velocity"][0], through * ratio, atol=1e-6)

    @pytest.mark.parametrize("ratio", [slow(1.0), slow(0.95), 1.06])
    def test_the_layer_of_the_dvl_ends_where_side_lobes_bring_the_bottom(self, ratio):
        """10 m above it, at 10 m cos(30 deg) = 8.66 m, by true sound speed."""
        edge = 10.0 * math.cos(math.radians(30)) * ratio
        for layer, heard in ((edge - 0.02, True), (edge + 0.02, False), (9.9, False), (14.0, False)):
            config = DvlConfig(water_layer_m=layer, sound_speed_mps=1500.0 * ratio)
            reading = Dvl(config, context([below(10.0)])).sense(at(0, 0, DEEP, velocity=(1, 0, 0)))
            assert reading.valid[0]
            assert (np.isfinite(reading.extras["water_velocity"][0]) == heard).all()

    def test_the_layer_of_the_dvl_is_lost_behind_what_a_beam_meets_and_after_the_next_ping(self):
        """9 m less 0.6 m along a beam: 8.4 m cos^2(30 deg) = 6.3 m. c/(2 rate) = 30 m along beams: 25.98 m."""
        config = DvlConfig()
        ball = sphere((np.array([0, 0, DEEP]) + 9.0 * config.beams[2]).tolist(), 0.6)
        for layer, scene, keys, heard in (
            (6.2, [below(60.0), ball], {}, True), (6.4, [below(60.0), ball], {}, False),
            (25.9, [below(70.0)], {"rate_hz": 25}, True), (26.1, [below(70.0)], {"rate_hz": 25}, False),
        ):  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ValidityWarning)  # 90 m are ambiguous at 25 Hz
                s = Dvl(DvlConfig(water_layer_m=layer, **keys), context(scene))
            assert (np.isfinite(s.sense(at(0, 0, DEEP)).extras["water_velocity"][0]) == heard).all()

    @pytest.mark.parametrize(
        ("keys", "message"),
        [
            (
                {"water_layer_m": 0.2},
                r"water_layer_m 0\.2 must be between range_min_m 0\.3 \(by default\) and range_max",
            ),
            ({"water_layer_m": 90.5}, r"water_layer_m 90\.5 must be .* range_max_m 90 \(by default\)"),
            ({"water_layer_m": 60, "device": "waterlinked_a50"}, r"range_max_m 50 \(of the device waterlinked_a50\)"),
        ],
    )
    def test_a_layer_that_the_dvl_cannot_hear_is_refused(self, keys, message):
        with pytest.raises(ValidationError, match=message):
            DvlConfig(**keys)


class TestTargets:
    @pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
    def test_rigid_sphere_has_its_target_strength(self, radius):
        """20 log10(a/2), and 20 log10(d/R) for the divergence of the wave: d to the highlight, R to the centre.

        By geometrical optics the reflection of a spherical wave has the amplitude a/(2 d R) at the source; specular
        facets of slope s return the same power, to O(s^2).
        """
        mirror = replace(PLAIN, density_ratio=1e6, sound_speed_ratio=1.0, lambert_db=-200.0)
        config = ImagingSonarConfig(
            beams=128, bins=400, range_min_m=20.0, range_max_m=30.0, horizontal_aperture_deg=12.0, rays_per_beam=1500,
            vertical_beamwidth_deg=40.0, beamwidth_deg=0.25, side_lobe_beams=0, **QUIET,
        )  # fmt: skip
        s = ImagingSonar(config, context([sphere((25.0, 0, DEEP), radius)], materials=(mirror,)))
        truth = s.sense(at(0, 0, DEEP)).truth[0]
        cell = math.radians(12.0) / 128 * config.bin_width_m
        section = (truth * s.tables["range"] * cell).sum()  # gain 30 log r taken to 40 log r
        expected = 20 * math.log10(radius / 2) + 20 * math.log10((25.0 - radius) / 25.0)
        assert 10 * math.log10(section) == pytest.approx(expected, abs=0.12)  # s^2 = 0.014: 0.06 dB

    def test_a_plate_square_on_is_brighter_than_one_that_is_turned(self):
        levels = []
        for yaw in (0.0, 0.3):
            mesh = box((25.0, 0, DEEP), (0.1, 2.0, 2.0))
            c, sn = math.cos(yaw), math.sin(yaw)
            turned = (mesh.vertices - [25, 0, DEEP]) @ np.array([[c, sn, 0], [-sn, c, 0], [0, 0, 1]]) + [25, 0, DEEP]
            steel = context([replace(mesh, vertices=turned)], materials=(MATERIALS["steel"],))
            s = ImagingSonar(ImagingSonarConfig(beams=65, bins=600, side_lobe_beams=0, **QUIET), steel)
            levels.append(s.sense(at(0, 0, DEEP)).truth[0].sum())
        assert 10 * math.log10(levels[0] / levels[1]) > 8.0


class TestEffects:
    def imaging(self, geometries, ocean=None, **options):
        config = ImagingSonarConfig(**({"beams": 33, "bins": 600, "range_max_m": 60.0} | QUIET | options))
        return ImagingSonar(config, context(geometries, ocean=ocean))

    def test_labels_are_of_the_strongest_echo(self):
        s = self.imaging([below(5.0), box((20, 0, DEEP), (1, 2, 12))], labels=True, orientation_deg=(0, 10, 0))
        reading = s.sense(at(0, 0, DEEP))
        label, r = reading.extras["label"][0, 16], s.tables["range"]
        assert label[np.abs(r - 19.6).argmin()] == 2
        assert label[np.abs(r - 12.0).argmin()] == 1
        assert label[r < 5].max() == 0

    def test_closing_moves_the_echo_nearer_by_v_over_c(self):
        wall = [box((40.5, 0, DEEP), (1, 300, 300))]
        options = {"bins": 4096, "range_min_m": 39.0, "range_max_m": 41.0, "bandwidth_hz": 1e6, "frequency_hz": 750e3,
                   "beams": 1, "horizontal_aperture_deg": 0.5, "vertical_beamwidth_deg": 1.0}  # fmt: skip
        s = self.imaging(wall, **options)
        edge = lambda v: float(
            s.tables["range"][np.argmax(s.sense(at(0, 0, DEEP, velocity=(v, 0, 0))).truth[0, 0] > 1e-6)]
        )
        shift = edge(0.0) - edge(3.0)
        assert shift == pytest.approx(40.0 * 3.0 / 1500.0, abs=0.003)

    def test_a_turning_sonar_hears_the_echo_where_it_points_later(self):
        """At 60 deg/s the echo from 45 m comes after 60 ms: 3.6 deg to the right of where the sound was sent."""
        post = [box((45.0, 0, DEEP), (0.2, 0.2, 10.0))]
        s = self.imaging(post, beams=261, side_lobe_beams=2, range_min_m=40.0, range_max_m=50.0)
        where = lambda w: math.degrees(
            s.tables["azimuth"][np.argmax(s.sense(at(0, 0, DEEP, angular_velocity=(0, 0, w))).truth[0].sum(axis=1))]
        )
        assert where(0.0) == pytest.approx(0.0, abs=0.3)
        assert where(math.radians(60)) == pytest.approx(-3.6, abs=0.5)

    def test_surface_bounce_arrives_at_the_image_delays(self):
        """A ball at the sonar's depth: straight 20 m, by the surface sqrt(20^2 + 8^2), and both mixed at the mean."""
        ball = [sphere((20.0, 0, -4.0), 0.3)]
        s = self.imaging(ball, multipath="surface", bins=3000, range_max_m=30.0, bandwidth_hz=300e3, rays_per_beam=1000,
                         vertical_beamwidth_deg=80.0, beams=9, horizontal_aperture_deg=3.0, surface_loss_db=0.0,
                         side_lobe_beams=0, labels=True)  # fmt: skip
        plain = s.sense(at(0, 0, -4.0)).truth[0]
        without = self.imaging(ball, bins=3000, range_max_m=30.0, bandwidth_hz=300e3, rays_per_beam=1000,
                               vertical_beamwidth_deg=80.0, beams=9, horizontal_aperture_deg=3.0,
                               side_lobe_beams=0).sense(at(0, 0, -4.0)).truth[0]  # fmt: skip
        extra = np.maximum(plain - without, 0).sum(axis=0)
        r = s.tables["range"]
        broken = math.hypot(20.0, 8.0)
        groups = r[extra > 0.02 * extra.max()]
        mixed = groups[groups < 20.5]
        both = groups[groups > 20.9]
        assert mixed.min() == pytest.approx(0.5 * (20.0 + broken) - 0.3, abs=0.1)
        assert both.min() == pytest.approx(broken - 0.3, abs=0.1)
        assert groups.min() > 19.7 + 0.02  # nothing before the direct echo

    def test_refraction_bends_the_beam_as_the_arc_says(self):
        """c = 1500 + g z: a ray that starts level has fallen or risen by x^2 g/(2 c) after x, first order."""

        water = LayeredWater(jit.Float64(1.0), jit.Float64(DEEP))
        deep = box((100.5, 0, DEEP), (1.0, 20.0, 2.0))  # a plate of 2 m at the sonar's depth, 100 m ahead
        drop = 100.0**2 * 1.0 / (2 * 1500.0)  # 3.3 m: the level ray passes below or above it
        options = {"vertical_beamwidth_deg": 1.0, "range_max_m": 110.0, "beams": 1, "horizontal_aperture_deg": 1.0,
                   "rate_hz": 5.0, "side_lobe_beams": 0, "rays_per_beam": 64, "vertical_side_lobes": 0}  # fmt: skip
        straight = self.imaging([deep], ocean=water, refraction=False, **options)
        bent = self.imaging([deep], ocean=water, refraction=True, **options)
        lower = self.imaging([box((100.5, 0, DEEP - drop), (1.0, 20.0, 2.0))], ocean=water, refraction=True, **options)
        assert straight.sense(at(0, 0, DEEP)).truth.max() > 1e-6
        assert bent.sense(at(0, 0, DEEP)).truth.max() < 1e-9
        assert lower.sense(at(0, 0, DEEP)).truth.max() > 1e-6

    def test_another_sonar_is_heard_once_in_its_period(self):
        options = {"interference": {"rate_hz": 5.0, "source_level_db": 330.0, "distance_m": 30.0, "pulse_s": 2e-4}}
        s = self.imaging([below(300.0)], **options)
        ping = s.sense(at(0, 0, DEEP, tick=0)).data[0, 16]
        assert s.tables["range"][np.argmax(ping)] == pytest.approx(15.0, abs=0.3)  # one way: half of the range

    def test_painted_errors_of_range_are_exponential(self):
        """A wall in one bin; its energy moves to later bins k with the share p (1 - p)^k of cells and exp(-n/range)."""
        wall = [box((20.5, 0, DEEP), (1, 100, 100))]
        options = {"beams": 65, "bins": 400, "horizontal_aperture_deg": 30.0, "vertical_beamwidth_deg": 2.0,
                   "side_lobe_beams": 0, "scale": "linear"}  # fmt: skip
        plain = self.imaging(wall, **options).sense(at(0, 0, DEEP)).data[0].sum(axis=0)
        s = self.imaging(wall, painted_noise={"range_m": 0.6}, **options)
        late = s.sense(lanes(range(40), dt_ns=DT_NS, position=(0, 0, DEEP))).data.mean(axis=0).sum(axis=0)
        r = s.tables["range"]
        assert late[r < r[plain.argmax()] - 0.5].max() < 1e-3 * plain.max()
        # shifts n of density exp(-n/a)/a, weighted with exp(-n/a): half of the energy stays, 0.3 m later in the mean
        assert late.sum() / plain.sum() == pytest.approx(0.5, rel=0.1)
        centre = lambda e: (e * r).sum() / e.sum()
        assert centre(late) - centre(plain) == pytest.approx(0.3, abs=0.06)

    def test_another_sonar_has_one_phase_in_all_beams_and_the_right_bearing(self):
        """Levels of beams are the pattern's, in every bin of every ping: none fades by itself."""
        other = {"rate_hz": 5.0, "source_level_db": 330.0, "distance_m": 30.0, "pulse_s": 2e-4, "azimuth_deg": -11.3}
        s = self.imaging([below(300.0)], beams=65, interference=other, iq=True)
        azimuth = np.degrees(s.tables["azimuth"])
        for tick in (0, 40):
            reading = s.sense(at(0, 0, DEEP, tick=tick))
            beam, bin_ = np.unravel_index(reading.data[0].argmax(), reading.data[0].shape)
            assert abs(azimuth[beam] + 11.3) <= 1.0
            heard = reading.extras["iq"][0, :, bin_]
            loud = np.abs(heard) > 0.2 * np.abs(heard).max()
            assert np.angle(heard[loud] / heard[beam]) == pytest.approx(np.zeros(loud.sum()), abs=0.01)

    @pytest.mark.parametrize(
        ("sonar", "options", "axis", "aside", "beam", "pattern"),
        [
            (Sidescan, {"beamwidth_deg": 9.0}, (90.0, -30.0), (84.0, -47.0), (0, 0),
             lambda x, y, z: one_way(x, 9.0) * one_way(0.5 * y + math.sqrt(0.75) * z, 50.0)),  # 30 deg below
            (ImagingSonar, {"beams": 33, "horizontal_aperture_deg": 66.0, "beamwidth_deg": 3.0}, (20.0, 0.0),
             (19.0, 6.0), (0, 6),
             lambda x, y, z: one_way(y - math.sin(math.radians(20.0)), 3.0, "light") * one_way(z, 20.0)),
            (Singlebeam, {"beamwidth_deg": 20.0}, (0.0, -90.0), (90.0, -83.0), (0,),
             lambda x, y, z: one_way(math.hypot(x, y), 20.0)),
        ],
    )  # fmt: skip
    def test_another_sonar_is_heard_by_the_pattern_of_beams(self, sonar, options, axis, aside, beam, pattern):
        """One way: products of line patterns. An axis is the mean of a beam's rays, 0.1 deg off at the most: on a slope
        of 0.16 dB a degree 0.4 %."""
        heard, expected = [], []
        for azimuth, elevation in (axis, aside):
            other = {"rate_hz": 5.0, "source_level_db": 330.0, "distance_m": 30.0, "pulse_s": 2e-4,
                     "azimuth_deg": azimuth, "elevation_deg": elevation}  # fmt: skip
            keys = QUIET | {"rate_hz": 5.0, "range_max_m": 60.0, "bins": 600} | options
            made = sonar(sonar.Config(**keys, interference=other), context([below(300.0)]))
            heard.append(made.sense(at(0, 0, DEEP)).data[beam].max())
            a, e = math.radians(azimuth), math.radians(elevation)
            expected.append(pattern(math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))
        assert expected[0] == pytest.approx(1.0)
        assert 0.1 < expected[1] < 0.9
        assert heard[1] / heard[0] == pytest.approx(expected[1], rel=0.005)

    def test_a_head_that_turns_hears_another_sonar_in_passing(self):
        other = {"rate_hz": 10.0, "source_level_db": 330.0, "distance_m": 30.0, "pulse_s": 2e-4, "azimuth_deg": 41.0}
        config = MechanicalScanningSonarConfig(**QUIET, sector_deg=90.0, step_deg=2.0, beamwidth_deg=5.0,
                                               interference=other)  # fmt: skip
        s = MechanicalScanningSonar(config, context([below(300.0)]))
        pings = [s.sense(at(0, 0, DEEP, tick=20 * k)) for k in range(46)]
        angle = np.degrees([p.extras["angle"][0] for p in pings])
        level = np.array([p.data[0].max() for p in pings])
        near = np.abs(angle - 41.0) < 5.0
        assert near.sum() == 5  # 45, 43, 41, 39 and 37
        expected = one_way(np.sin(np.radians(angle - 41.0)), 5.0)
        assert (level / level.max())[near] == pytest.approx(expected[near], abs=0.01)
        assert angle[level.argmax()] == pytest.approx(41.0)

    @pytest.mark.parametrize(
        ("kind", "curve"), [("dark", lambda x: x**2), ("bright", lambda x: 1 - (1 - x) ** 2), ("none", lambda x: x)]
    )
    def test_painted_streaks_are_in_beams_that_look_squarely_at_something(self, kind, curve):
        wall = [box((20.5, 0, DEEP), (1, 100, 100)), below(5.0)]
        options = {"beams": 33, "scale": "unit", "self_noise_db": 55.0, "source_level_db": 205.0, "floor_db": -60.0}
        plain = self.imaging(wall, painted_noise={}, **options).sense(at(0, 0, DEEP)).data[0]
        found = self.imaging(wall, painted_noise={"azimuth_streaks": kind}, **options).sense(at(0, 0, DEEP)).data[0]
        assert found[16] == pytest.approx(curve(plain[16]), abs=1e-6)  # straight ahead
        assert found[4] == pytest.approx(plain[4])  # 47 deg aside

    @pytest.mark.parametrize(
        ("noise", "told"),
        [({"additive_reference_db": -30.0}, "without 'additive'"),
         ({"additive_reference_db": -30.0, "additive": 0.1, "onto": "level"}, "without 'onto: intensity'")],
    )  # fmt: skip
    def test_keys_of_painted_noise_that_change_nothing_are_told(self, noise, told):
        with pytest.warns(ValidityWarning, match=f"painted_noise: 'additive_reference_db' changes nothing {told}"):
            self.imaging([below(300.0)], painted_noise=noise)

    def test_painted_noise_onto_levels_is_of_the_picture(self):
        """Rayleigh: mean sigma sqrt(pi / 2), variance (2 - pi / 2) sigma^2; a factor's spread grows with the level."""
        sigma, factor = 0.04, 0.1
        dark = self.imaging([below(300.0)], scale="unit", painted_noise={"onto": "level", "additive": sigma})
        plain = self.imaging([below(300.0)], scale="unit").sense(at(0, 0, DEEP)).data[0]
        noise = dark.sense(at(0, 0, DEEP)).data[0][plain == 0]
        few = noise.size**0.5
        assert noise.size > 1000
        assert abs(noise.mean() - sigma * np.sqrt(np.pi / 2)) < 5 * sigma * np.sqrt(2 - np.pi / 2) / few
        wall = [below(4.0)]
        shown = self.imaging(wall, scale="unit").sense(at(0, 0, DEEP)).data[0]
        found = self.imaging(wall, scale="unit", painted_noise={"onto": "level", "multiplicative": factor})
        bright = (shown > 0.05) & (shown < 0.6)
        assert bright.sum() > 100
        ratio = found.sense(at(0, 0, DEEP)).data[0][bright] / shown[bright]
        assert abs(ratio.std() - factor) < 5 * factor / np.sqrt(2 * ratio.size)

    def test_painted_levels_are_the_same_in_every_scale(self):
        """A level x of the picture is floor + x range in decibels, and ten to a tenth of that as an intensity."""
        floor_db = -62.0
        options = {"floor_db": floor_db, "dynamic_range_db": 37.0, "beams": 9, "bins": 200,
                   "painted_noise": {"onto": "level", "multiplicative": 0.1, "additive": 0.03}}  # fmt: skip
        unit, decibels, linear = (
            self.imaging([below(4.0)], scale=scale, **options).sense(at(0, 0, DEEP)).data[0].astype(float)
            for scale in ("unit", "db", "linear")
        )
        assert ((unit > 0.05) & (unit < 0.95)).sum() > 200
        assert decibels == pytest.approx(floor_db + 37.0 * unit, abs=1e-4)
        assert 10.0 * np.log10(linear) == pytest.approx(decibels, abs=1e-4)

    def test_painted_noise_adds_to_empty_water(self):
        s = self.imaging([below(300.0)], painted_noise={"additive": 0.1, "additive_reference_db": 0.0})
        data = s.sense(at(0, 0, DEEP)).data
        assert data.mean() == pytest.approx(0.1 * math.sqrt(math.pi / 2), rel=0.02)


@pytest.mark.parametrize(
    ("config", "options", "message"),
    [
        (ImagingSonarConfig, {"rate_hz": 20.0, "range_max_m": 60.0}, "ambiguous"),
        (SidescanConfig, {"range_min_m": 70.0}, "below range_max_m"),
        (SinglebeamConfig, {"bandwidth_hz": 500e3}, "bandwidth_hz"),
        (AdcpConfig, {"cells": 0}, "cells"),
    ],
)
def test_impossible_sonars_are_refused(config, options, message):
    with pytest.raises(ValidationError, match=message):
        config(**options)


@pytest.mark.parametrize(
    "kind", [Singlebeam, Sidescan, MechanicalScanningSonar, ProfilingSonar, SyntheticApertureSonar, Adcp]
)
def test_lanes_equal_singles_and_every_sonar_explains_itself(kind):
    extra = {} if kind is Adcp else {"bins": 128}
    if kind is SyntheticApertureSonar:
        extra |= {"rays": 1024, "range_max_m": 8.0, "rate_hz": 50.0}
    scene = [below(8.0), box((3, 4, DEEP - 7), (1, 1, 2))]
    one, two = (kind(kind.Config(**extra), context(scene, n=n, materials=(PLAIN,))) for n in (1, 2))
    motion = {"dt_ns": DT_NS, "velocity": (1.0, 0.1, 0.0)}
    pair = two.sense(lanes([40], environments=range(2), position=[[0, 0, DEEP], [1, 1, DEEP]], **motion))
    alone = one.sense(lanes([40], position=[[0, 0, DEEP]], **motion))
    alone = one.sense(lanes([40], position=[[0, 0, DEEP]], **motion))
    np.testing.assert_array_equal(pair.data[0], alone.data[0])
    told = one.explain(lanes([40], position=[[0, 0, DEEP]], **motion))
    assert len(told) >= 4


def test_bins_wider_than_the_pulse_resolves_give_a_warning_where_the_signal_is_to_be_focused():
    with pytest.warns(ValidityWarning, match="undersample the pulse"):
        SyntheticApertureSonar(SyntheticApertureSonarConfig(bins=256, rays=256), context([below(10.0)]))


def test_a_tone_burst_has_the_bandwidth_of_its_duration_and_the_echo_of_a_triangle():
    """A plate: the echo rises and falls over +- c T/2, amplitude a triangle; half of the power within 0.29 of it."""
    config = SinglebeamConfig(pulse="cw", pulse_s=1e-3, bins=1500, range_max_m=30.0, rays=64, **QUIET)
    assert config.bandwidth_hz == pytest.approx(1000.0)
    assert SinglebeamConfig(**config.model_dump()) == config
    with pytest.warns(ValidityWarning, match="finer than the pulse"):
        s = Singlebeam(config, context([box((0, 0, DEEP - 20.05), (0.3, 0.3, 0.1))]))
    truth, r = s.sense(at(0, 0, DEEP)).truth[0], s.tables["range"]
    half = 1500.0 * 1e-3 / 2
    assert r[truth > 1e-6 * truth.max()].min() == pytest.approx(20.0 - half, abs=0.05)
    assert r[truth > 1e-6 * truth.max()].max() == pytest.approx(20.0 + half, abs=0.08)
    width = np.ptp(r[truth > 0.5 * truth.max()])
    assert width == pytest.approx(2 * (1 - math.sqrt(0.5)) * half, abs=0.06)


@pytest.mark.parametrize("kind", [SinglebeamConfig, DvlConfig, ImagingSonarConfig])
def test_a_tone_burst_of_another_bandwidth_is_refused(kind):
    with pytest.raises(ValidationError, match="leave it out"):
        kind(pulse="cw", pulse_s=1e-3, bandwidth_hz=5e3)


def test_bins_finer_than_the_pulse_give_a_warning():
    with pytest.warns(ValidityWarning, match="finer than the pulse"):
        Singlebeam(SinglebeamConfig(range_max_m=5.0, bins=4096, bandwidth_hz=5e3), context([below(3.0)]))


def test_a_frequency_outside_of_the_absorptions_fit_gives_a_warning():
    with pytest.warns(ValidityWarning, match=r"auv0\.sonar: absorption at.*Francois"):
        Singlebeam(SinglebeamConfig(frequency_hz=3e6), context([below(3.0)]))


class TestVolumeReverberation:
    """Urick (1983), Section 8.2: intensity sv psi c tau/2 10^(-2 a r/10)/r^2, psi the two-way pattern's solid angle."""

    def sonar(self, *geometries, ocean=None, **options):
        config = SinglebeamConfig(range_max_m=60.0, bins=400, **(QUIET | options))
        return Singlebeam(config, context([*geometries, below(500.0)], ocean=ocean))

    def beam(self):
        """The cone's equivalent solid angle."""
        width = math.radians(9)
        a = np.linspace(0, width * 1.129, 4001)
        from pelagos.acoustics.beam_pattern import line_length, line_np

        return trapezoid(2 * np.pi * np.sin(a) * line_np(np.sin(a), line_length(width)) ** 4, a)

    def test_level_is_uricks(self):
        s = self.sonar(volume_scattering_db=-70.0)
        reading = s.sense(at(0, 0, DEEP))
        r = s.tables["range"].astype(float)
        # in the unit of the readings, gain 30 log r + 2 a r over the cell's angle and depth: sv psi r/angle
        expected = 1e-7 * self.beam() * r / math.radians(9.0)
        assert reading.truth[0] == pytest.approx(expected, rel=0.01)
        assert reading.data[0].mean() == pytest.approx(reading.truth[0].mean(), rel=4 / math.sqrt(400))

    def test_it_is_exponential_noise_new_in_each_ping(self):
        s = self.sonar(volume_scattering_db=-60.0)
        a = s.sense(lanes(range(50), dt_ns=DT_NS, position=(0, 0, DEEP)))
        ratio = (a.data / a.truth).ravel()
        assert ratio.std() == pytest.approx(1.0, rel=0.05)
        assert abs(np.corrcoef(ratio.reshape(50, 400)[0], ratio.reshape(50, 400)[1])[0, 1]) < 0.25

    def test_there_is_no_water_behind_a_bottom(self):
        s = self.sonar(plane(DEEP - 20.0), volume_scattering_db=-40.0)
        truth, r = s.sense(at(0, 0, DEEP)).truth[0], s.tables["range"]
        assert (truth[r < 19.0] > 0).all()
        assert (truth[r > 22.5] == 0).all()

    def test_a_layer_of_the_ocean_is_seen_where_it_is(self):
        """Sv as a tracer against depth: 30 dB more between 215 and 225 m than elsewhere."""
        field = {"depth_m": [0, 214, 216, 224, 226, 900], "value": [-90, -90, -60, -60, -90, -90]}
        ocean = build_ocean(OceanConfig(tracers={"volume_scattering_db": field}))
        s = self.sonar(ocean=ocean)
        truth, r = s.sense(at(0, 0, DEEP)).truth[0].astype(float), s.tables["range"]
        level = 10 * np.log10(truth / r)
        assert level[np.abs(r - 20) < 3].mean() - level[np.abs(r - 8) < 3].mean() == pytest.approx(30.0, abs=0.3)
        assert level[np.abs(r - 35) < 3].mean() == pytest.approx(level[np.abs(r - 8) < 3].mean(), abs=0.3)

    def test_clear_water_is_silent_and_bytes_repeat(self):
        assert (self.sonar().sense(at(0, 0, DEEP)).truth[0] == 0).all()
        s = self.sonar(volume_scattering_db=-60.0)
        np.testing.assert_array_equal(s.sense(at(0, 0, DEEP)).data, s.sense(at(0, 0, DEEP)).data)

    @pytest.mark.parametrize("kind", [ImagingSonar, Sidescan, slow(MechanicalScanningSonar), slow(ProfilingSonar)])
    def test_every_sonar_with_a_water_column_shows_it(self, kind):
        config = kind.Config(bins=128, volume_scattering_db=-60.0, range_max_m=30.0, **QUIET)
        truth = kind(config, context([below(300.0)])).sense(at(0, 0, DEEP)).truth
        assert (truth.reshape(-1, 128) > 0).all()
