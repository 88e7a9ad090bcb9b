"""Altimeter, DVL and multibeam over planes whose ranges are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import DT_NS, PLAIN, at, box, context, plane, still_water

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length
from pelagos.acoustics.doppler import janus_beams, velocity_from_beams
from pelagos.math.so3 import from_euler
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.adcp import AdcpConfig
from pelagos.sensors.sonar.altimeter import Altimeter, AltimeterConfig
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.world.material import MATERIALS

SAND = (MATERIALS["sand"],)


def attitude(roll=0.0, pitch=0.0, yaw=0.0):
    return np.array([float(a) for a in from_euler(roll, pitch, yaw)])


class TestAltimeter:
    def test_reads_the_altitude_over_a_flat_bottom(self):
        s = Altimeter(AltimeterConfig(noise_m=0, noise_relative=0), context([plane(-20.0)]))
        reading = s.sense(at(0, 0, -12.5))
        assert reading.data == pytest.approx([7.5], abs=1e-5)
        assert reading.truth == pytest.approx([7.5], abs=1e-5)
        assert reading.extras["axis"] == pytest.approx([7.5], abs=1e-5)

    def test_hears_the_nearest_loud_part_of_a_tilted_bottom(self):
        s = Altimeter(AltimeterConfig(noise_m=0, noise_relative=0), context([plane(-20.0, slope=0.5)]))
        reading = s.sense(at(0, 0, -10.0))
        axis, square = 10.0, 10.0 / math.hypot(1, 0.5)
        assert reading.extras["axis"] == pytest.approx([axis], abs=1e-4)
        assert square < reading.truth[0] < axis

    def test_noise_has_its_size(self):
        s = Altimeter(AltimeterConfig(noise_m=0.01, noise_relative=0.002), context([plane(-20.0)]))
        motion = lanes(range(4000), dt_ns=DT_NS, position=(0, 0, -10.0))
        error = s.sense(motion).data - 10.0
        sigma = math.hypot(0.01, 0.02)
        assert error.std() == pytest.approx(sigma, rel=4 / math.sqrt(2 * 4000))
        assert abs(error.mean()) < 4 * sigma / math.sqrt(4000)

    def test_is_silent_out_of_range(self):
        s = Altimeter(AltimeterConfig(range_max_m=30.0), context([plane(-100.0)]))
        reading = s.sense(at(0, 0, -10.0))
        assert not reading.valid[0]
        assert np.isnan(reading.data[0])

    def test_a_wrong_sound_speed_scales_the_range(self):
        config = AltimeterConfig(noise_m=0, noise_relative=0, sound_speed_mps=1500.0)
        s = Altimeter(config, context([plane(-20.0)], ocean=still_water(1450.0)))
        assert s.sense(at(0, 0, -10.0)).data == pytest.approx([10.0 * 1500 / 1450], rel=1e-5)


EXACT = {"noise_mps": 0.0, "noise_relative": 0.0, "range_noise_relative": 0.0}


class TestDvl:
    def test_velocity_is_that_of_the_sensor_with_its_lever_arm(self):
        s = Dvl(DvlConfig(position_m=(0.5, 0.0, 0.2), **EXACT), context([plane(-20.0)], materials=SAND))
        reading = s.sense(at(0, 0, -10, velocity=(1.5, 0.2, -0.1), angular_velocity=(0, 0, 0.5)))
        expected = [1.5, 0.2 + 0.25, -0.1]  # w x r = (0, 0.25, 0)
        assert reading.truth[0] == pytest.approx(expected, abs=1e-12)
        assert reading.data[0] == pytest.approx(expected, abs=1e-6)
        assert reading.valid[0]

    def test_velocity_is_in_the_sensor_frame(self):
        turned = Dvl(DvlConfig(orientation_deg=(0, 0, 90), **EXACT), context([plane(-20.0)], materials=SAND))
        reading = turned.sense(at(0, 0, -10, velocity=(1.0, 0.0, 0.0)))
        assert reading.data[0] == pytest.approx([0.0, -1.0, 0.0], abs=1e-6)

    def test_ranges_and_altitude_over_a_flat_bottom(self):
        s = Dvl(DvlConfig(**EXACT), context([plane(-20.0)], materials=SAND))
        reading = s.sense(at(0, 0, -10))
        # five rays a beam: their mean range exceeds the axis' by less than the curvature over half a beam width
        assert reading.extras["ranges"][0] == pytest.approx(np.full(4, 10 / math.cos(math.radians(30))), rel=1e-3)
        assert reading.extras["altitude"][0] == pytest.approx(10.0, rel=1e-3)

    def test_ranges_under_roll_and_pitch(self):
        s = Dvl(DvlConfig(**EXACT), context([plane(-20.0)], materials=SAND))
        q = attitude(roll=0.1, pitch=-0.15)
        reading = s.sense(at(0, 0, -10, attitude=q))
        w, v = q[0], q[1:]
        beams = reading.tables["direction"]
        world = beams + 2 * np.cross(v, np.cross(v, beams) + w * beams)
        assert reading.extras["ranges"][0] == pytest.approx(10 / -world[:, 2], rel=2e-3)

    def test_three_beams_still_solve_and_two_do_not(self):
        beams = janus_beams(math.radians(30), tuple(math.radians(a) for a in (45, 135, -135, -45)))
        v = np.array([1.2, -0.3, 0.2])
        speeds = [jit.Float64(float(b @ v)) for b in beams]
        for lost in ((), (0,), (3,)):
            valid = [jit.Bool(i not in lost) for i in range(4)]
            found, solved = velocity_from_beams(speeds, valid, beams)
            assert np.array(solved).all()
            assert np.array(found).ravel() == pytest.approx(v, abs=1e-12)
        for lost in ((0, 1), (0, 2), (0, 1, 2, 3)):
            _, solved = velocity_from_beams(speeds, [jit.Bool(i not in lost) for i in range(4)], beams)
            assert not np.array(solved).any()

    def test_noise_of_the_velocity_is_that_of_the_beams(self):
        """Least squares over four beams, 45 deg off the axes: sigma/(sqrt(2) sin 30) sideways, sigma/(2 cos 30) up."""
        count = 4000
        config = DvlConfig(noise_mps=0.004, noise_relative=0.0)
        s = Dvl(config, context([plane(-20.0)], materials=SAND))
        error = s.sense(lanes(range(count), dt_ns=DT_NS, position=(0, 0, -15.0))).data
        tilt = math.radians(30)
        expected = 0.004 / (math.sqrt(2) * math.sin(tilt)), 0.004 / (2 * math.cos(tilt))
        assert error[:, 0].std() == pytest.approx(expected[0], rel=0.05)
        assert error[:, 1].std() == pytest.approx(expected[0], rel=0.05)
        assert error[:, 2].std() == pytest.approx(expected[1], rel=0.05)
        assert np.abs(error.mean(axis=0)).max() < 4 * expected[0] / math.sqrt(count)

    def test_scale_error_is_a_bias(self):
        s = Dvl(DvlConfig(scale_error=0.01, **EXACT), context([plane(-20.0)], materials=SAND))
        assert s.sense(at(0, 0, -10, velocity=(2.0, 0, 0))).data[0, 0] == pytest.approx(2.02, abs=1e-5)

    def test_beams_are_lost_with_height_and_noise_grows(self):
        s = Dvl(DvlConfig(range_max_m=80.0), context([plane(-200.0)], materials=SAND))
        share, sigma = [], []
        for altitude in (10.0, 60.0, 80.0, 100.0):
            found = s.sense(lanes(range(500), dt_ns=DT_NS, position=(0, 0, -200.0 + altitude))).extras
            share.append(found["beam_valid"].mean())
            sigma.append(found["sigma"].mean())
        assert share[0] == share[1] == 1.0
        assert share[3] < 0.01
        assert 0.02 < share[2] < 0.98
        assert (np.diff(sigma) > 0).all()

    def test_an_edge_takes_beams_away_and_bottom_lock_with_them(self):
        shelf = box((0, -50.0, -20.0), (200.0, 100.0, 10.0))  # bottom only to the right
        s = Dvl(DvlConfig(), context([shelf], materials=SAND))
        assert s.sense(at(0, -40, -10)).valid[0]
        half = s.sense(at(0, 0.5, -10))
        assert half.extras["beam_valid"][0].sum() == 2
        assert not half.valid[0]
        assert np.isnan(half.data[0]).all()

    def test_four_directions_are_needed(self):
        with pytest.raises(ValidationError, match="four different"):
            DvlConfig(beam_azimuth_deg=(0.0, 0.0, 90.0, 180.0))
        with pytest.raises(ValidationError, match="four different"):
            AdcpConfig(beam_azimuth_deg=(0.0, 360.0, 90.0, 180.0))


def track(count: int):
    """Pings along a line, each over another piece of the bottom: a sonar at rest hears the same speckle again."""
    x = np.linspace(-60.0, 60.0, count)
    return lanes(range(count), dt_ns=DT_NS, position=np.stack([x, 0 * x, 0 * x - 10.0], axis=1))


class TestMultibeam:
    def sonar(self, geometries, **options):
        return Multibeam(MultibeamConfig(**({"beams": 128} | options)), context(geometries, materials=SAND))

    def test_flat_bottom(self):
        s = self.sonar([plane(-30.0)])
        reading = s.sense(at(0, 0, -10))
        angle = s.config.angles
        exact = 20.0 / np.cos(angle)
        assert reading.truth[0] == pytest.approx(exact, rel=1e-5)
        assert np.isfinite(reading.data).all()
        error = (reading.data[0] - exact) * np.cos(angle)
        # 0.3 % of the depth and two centimetres: IHO Special Order over 20 m allows 0.29 m
        assert np.sqrt(np.mean(error**2)) < 0.02
        assert np.abs(error).max() < 0.08
        assert reading.extras["soundings"][0, :, 2] == pytest.approx(np.full(128, -20.0), abs=0.1)
        assert reading.extras["soundings"][0, 0, 1] > 0  # the first beam looks to port

    def test_tilted_plane(self):
        s = self.sonar([plane(-30.0, slope=0.2)])
        reading = s.sense(at(0, 0, -10, attitude=attitude(yaw=math.pi / 2)))
        d = s.tables["direction"].astype(float)
        # yaw of 90 deg turns the sensor's (x, y) into the world's (-y, x): the slope runs across the track
        exact = 20.0 / -(d[:, 2] + 0.2 * d[:, 1])
        assert reading.truth[0] == pytest.approx(exact, rel=1e-4)
        assert np.nanmax(np.abs(reading.data[0] / reading.truth[0] - 1)) < 0.02

    def test_errors_do_not_depend_on_the_ray_count_in_the_mean(self):
        few, many = (self.sonar([plane(-30.0)], rays_along=k) for k in (3, 9))
        a, b = (s.sense(track(64)).data for s in (few, many))
        assert np.abs((a - b).mean(axis=0)).max() < 0.03

    def test_backscatter_is_the_bottoms(self):
        s = self.sonar([plane(-30.0)])
        mean = np.nanmean(s.sense(track(400)).extras["backscatter"], axis=0)
        from pelagos.sensors.sonar.ping.surface_scattering import scattering_table

        table = 10 * np.log10(scattering_table(SAND, s.config.frequency_hz, wind_speed=5.0)[0])
        grazing = np.degrees(np.pi / 2 - np.abs(s.config.angles))
        expected = np.interp(grazing, np.linspace(0, 90, 181), table)
        outer = np.abs(s.config.angles) > math.radians(20)
        assert mean[outer] == pytest.approx(expected[outer], abs=3.5)  # texture of the bottom: 1.5 dB rms

    def test_nadir_is_found_by_amplitude_and_oblique_beams_by_phase(self):
        """Lurton 2010, Section 8.3: amplitude near nadir, phase beyond the first ten or twenty degrees."""
        s = self.sonar([plane(-30.0)])
        kind = s.sense(track(100)).extras["detection"]
        by_phase = (kind == 2).mean(axis=0)
        angle = np.abs(s.config.angles)
        assert (by_phase[angle < math.radians(4)] < 0.05).all()
        assert (by_phase[angle > math.radians(25)] > 0.95).all()
        assert (kind > 0).all()

    def test_bias_and_spread_over_a_flat_bottom(self):
        """The bias is that of a line through a curved ramp; the spread is what the sounder itself estimates.

        Range h/cos a over the phase pi L (sin a - sin a0) departs from its tangent by
        c = h u^2 (1 + 3 tan^2 a)/(2 cos^3 a) where the phase is 1.2, at u = 1.2/(pi L); a line fitted over both sides
        crosses zero c/3 later. The footprint's ends along the track lie up to r (w/2)^2/2 farther than its middle, w
        being the beam width.
        """
        s = self.sonar([plane(-30.0)], beams=61)
        reading = s.sense(track(300))
        error = reading.data - reading.truth
        angle, length = np.abs(s.config.angles), line_length(math.radians(1.0))
        u = 1.2 / (math.pi * length)
        bend = 20.0 * u**2 * (1 + 3 * np.tan(angle) ** 2) / (2 * np.cos(angle) ** 3) / 3
        bias, ends = np.median(error, axis=0), 0.5 * reading.truth[0] * math.radians(0.5) ** 2
        noise = 4 * error.std(axis=0) / math.sqrt(300)
        assert (np.abs(bias) < 1.4 * bend + ends + noise + 0.019 / 10).all()  # a tenth of the resolution
        assert (bias > 0.8 * bend - noise)[angle > 0.3].all()
        kind, told = reading.extras["detection"], reading.extras["uncertainty"]
        for beam in (30, 45, 54):  # nadir, 30 and 48 deg
            way = 1 if beam == 30 else 2
            same = kind[:, beam] == way
            # what is told is on the safe side, by a factor of 1.7 to 2; 300 pings know it to 4 %
            assert 0.42 < error[same, beam].std() / np.median(told[same, beam]) < 0.70
        assert error[:, 45].std() < 0.002  # a tenth of the pulse's resolution, a 1/300 of the beam's footprint

    def test_amplitude_detection_of_oblique_beams_errs_as_published(self):
        """Centre of gravity of N independent samples: w/sqrt(N) of `amplitude_error`; speckle's weights are
        among what it counts."""
        s = self.sonar([plane(-30.0)], beams=61)
        told = {name: values.reshape(200, 61) for name, values, _ in s.explain(track(200)) if values.size == 200 * 61}
        exact = 20.0 / math.cos(s.config.angles[45])
        found, expected = told["range by amplitude"][:, 45], told["estimated error by amplitude"][:, 45]
        assert (found - exact).std() / np.median(expected) == pytest.approx(1.0, abs=0.2)  # 200 pings: 5 %
        assert (told["range by phase"][:, 45] - exact).std() < 0.2 * (found - exact).std()

    def test_fewer_samples_than_the_echo_holds_are_a_longer_pulse(self):
        coarse, fine = (self.sonar([plane(-30.0)], beams=61, samples=k) for k in (24, 96))
        a, b = (s.sense(track(200)) for s in (coarse, fine))
        spread = lambda r: (r.data - r.truth)[:, 54].std()
        assert spread(a) > 1.5 * spread(b)
        assert abs((a.data - a.truth)[:, 54].mean()) < 0.02

    def test_raw_series_hold_the_echo_and_its_phase(self):
        """What the sounder detected can be found again: zero phase at the range that it gives."""
        s = self.sonar([plane(-30.0)], beams=61, iq=True)
        reading = s.sense(at(0, 0, -10))
        iq, reach = reading.extras["iq"][0, 45], reading.extras["iq_range"][0, 45]
        assert iq.shape == (2, 64)
        assert reading.extras["detection"][0, 45] == 2
        cross, strong = iq[0] * iq[1].conj(), np.abs(iq.sum(axis=0)) ** 2
        use = (np.abs(np.angle(cross)) < 1.2) & (strong > 0.1 * strong.max())
        slope, offset = np.polyfit(reach[use] - 20.0, np.angle(cross[use]), 1, w=np.sqrt(np.abs(cross[use])))
        assert 20.0 - offset / slope == pytest.approx(reading.data[0, 45], abs=0.02)

    def test_nothing_in_range_is_nan(self):
        reading = self.sonar([plane(-500.0)]).sense(at(0, 0, -10))
        assert np.isnan(reading.data).all()
        assert np.isnan(reading.truth).all()
        assert (reading.extras["quality"] == 0).all()

    def test_labels_are_those_on_the_axes(self):
        s = self.sonar([plane(-30.0), box((0, 0, -28), (4.0, 4.0, 4.0))])
        label = s.sense(at(0, 0, -10)).extras["label"][0]
        assert label[64] == 2
        assert label[0] == 1

    def test_an_even_number_of_rays_along_is_refused(self):
        with pytest.raises(ValidationError, match="odd"):
            MultibeamConfig(rays_along=4)

    def test_a_band_and_a_water_column_that_cannot_be_are_refused(self):
        with pytest.raises(ValidationError, match="below twice frequency_hz"):
            MultibeamConfig(bandwidth_hz=1e6)
        for kind in (MultibeamConfig, AltimeterConfig):
            with pytest.raises(ValidationError, match=r"0 \(none\) or at least 8"):
                kind(water_column_bins=5)


@pytest.mark.parametrize("kind", [Altimeter, Dvl, Multibeam])
def test_frozen_lanes_equal_singles(kind):
    scene, places = [plane(-20.0, slope=0.1)], np.array([[0, 0, -10.0], [3, 1, -9.0], [5, 2, -4.0]])
    three = kind(kind.Config(), context(scene, n=3, materials=SAND))
    one = kind(kind.Config(), context(scene, materials=SAND))
    motion = {"dt_ns": DT_NS, "velocity": (1.0, 0.1, 0.0)}
    together = three.sense(lanes([8], environments=range(3), position=places, **motion))
    for k in range(2):  # the second time the recording plays
        alone = one.sense(lanes([8], position=places[:1], **motion))
        np.testing.assert_array_equal(together.data[0], alone.data[0])
        assert k in (0, 1)
    blocks = one.sense(lanes([7, 8], position=np.stack([places[1], places[0]]), **motion))
    np.testing.assert_array_equal(blocks.data[1], alone.data[0])


@pytest.mark.parametrize("kind", [Altimeter, Dvl, Multibeam])
def test_explain_tells_names_values_and_units(kind):
    s = kind(kind.Config(), context([plane(-20.0)], materials=(PLAIN,)))
    told = s.explain(at(0, 0, -10))
    assert len(told) >= 4
    for name, values, unit in told:
        assert name
        assert unit
        assert np.isfinite(values[np.isfinite(values)]).any()


class TestRefraction:
    """A thermocline of 10 deg C in 10 m between a multibeam and the bottom 100 m below."""

    def sonar(self, **options):
        water = {"depth_m": [0, 20, 30, 200], "value": [22.0, 21.0, 12.0, 8.0]}
        ocean = build_ocean(OceanConfig(temperature_c=water))
        config = MultibeamConfig(beams=61, range_max_m=400.0, rate_hz=1.0, **options)
        return Multibeam(config, context([plane(-110.0)], materials=SAND, ocean=ocean))

    def test_it_is_switched_on_where_it_matters(self):
        told = lambda s: np.array({n: v for n, v, _ in s.explain(at(0, 0, -10))}["slant range"])
        auto, on, off = (told(self.sonar(refraction=r)) for r in ("auto", True, False))
        np.testing.assert_array_equal(auto, on)
        assert np.abs(on - off).max() > 1.0

    def test_soundings_follow_the_bent_rays_and_straight_ones_miss_the_bottom(self):
        s = self.sonar()
        reading = s.sense(track(100))
        depth = np.median(reading.extras["soundings"][..., 2], axis=0)[10:-10]  # 40 deg: beyond, echoes are faint
        assert depth == pytest.approx(np.full(41, -100.0), abs=0.05)
        straight = (reading.truth * s.tables["direction"][:, 2])[0]
        assert straight[30] < -101.5  # the water below is slower than that at the sonar
        assert straight[0] - straight[30] > 4.0  # and the outer beams are bent down: the smile of a wrong profile


class TestWaterColumn:
    """Levels by beam and range from the transducer to beyond the bottom."""

    @pytest.mark.parametrize("spacing", ["equiangular", "equidistant"])
    def test_the_bottom_lies_where_the_soundings_are(self, spacing):
        config = MultibeamConfig(beams=61, water_column_bins=600, range_max_m=60.0, spacing=spacing)
        s = Multibeam(config, context([plane(-30.0)], materials=SAND))
        reading = s.sense(at(0, 0, -10))
        column, mean = reading.extras["water_column"][0], reading.extras["water_column_truth"][0]
        r = s.tables["water_column_range"]
        assert column.shape == mean.shape == (61, 600)
        inner = np.abs(config.angles) < math.radians(50)
        # a beam of 1 deg hears the bottom over r tan(a) w/cos(a) of range: 1 m at 50 deg
        assert r[mean.argmax(axis=1)][inner] == pytest.approx(reading.truth[0][inner], abs=0.8)
        assert (mean[:, r < 19.0].max(axis=1) < mean.max(axis=1) - 60.0).all()

    def test_something_in_midwater_is_seen_above_the_bottom(self):
        ball = box((0.0, 0.0, -18.0), (0.4, 0.4, 0.4))
        s = Multibeam(
            MultibeamConfig(beams=61, water_column_bins=600, range_max_m=60.0),
            context([plane(-30.0), ball], materials=SAND),
        )
        mean, r = s.sense(at(0, 0, -10)).extras["water_column_truth"][0], s.tables["water_column_range"]
        assert r[mean[30, r < 15.0].argmax()] == pytest.approx(7.8, abs=0.15)

    def test_without_it_nothing_is_computed(self):
        reading = Multibeam(MultibeamConfig(beams=31), context([plane(-30.0)], materials=SAND)).sense(at(0, 0, -10))
        assert "water_column" not in reading.extras
