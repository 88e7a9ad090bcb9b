"""Errors of real devices: assumed sound speeds, converters, ringing, the surface's line; and keys that are refused."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import StillWater, at, context, plane, sphere, still_water

from cases import slow
from pelagos import jit
from pelagos.acoustics import beamforming
from pelagos.acoustics.echo_walk import pitch
from pelagos.acoustics.pulse import point_spread
from pelagos.errors import ValidityWarning
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.altimeter import Altimeter
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.incidence_sonar import IncidenceSonar, IncidenceSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonarConfig
from pelagos.world.material import MATERIALS

pytestmark = pytest.mark.filterwarnings("ignore:.*finer than the pulse resolves")
WATER, ASSUMED = 1450.0, 1530.0


class TestAssumedSoundSpeed:
    def test_ranges_and_angles_of_an_array(self):
        """r c'/c, and sin a c'/c: a ball at 30 deg and 20 m in water of 1450 m/s, taken for 1530 m/s."""
        bearing = math.radians(30.0)
        ball = sphere((20 * math.cos(bearing), 20 * math.sin(bearing), 0.0), 0.1)
        found = []
        for assumed in (None, ASSUMED):
            config = ImagingSonarConfig(range_max_m=30.0, bins=3000, sound_speed_mps=assumed, scale="linear")
            scene = context([plane(-1000.0), ball], materials=(MATERIALS["steel"],), ocean=still_water(WATER))
            s = ImagingSonar(config, scene)
            truth = s.sense(at(0, 0, 0)).truth[0]
            beam, k = np.unravel_index(truth.argmax(), truth.shape)
            found.append((float(s.tables["azimuth"][beam]), float(s.tables["range"][k])))
        assert found[0] == pytest.approx((bearing, 19.9), abs=0.02)
        apparent = math.asin(math.sin(bearing) * ASSUMED / WATER)  # 31.8 deg
        assert found[1] == pytest.approx((apparent, 19.9 * ASSUMED / WATER), abs=0.02)

    def test_surfaces_move_as_targets_do(self):
        config = SinglebeamConfig(range_max_m=30.0, bins=600, sound_speed_mps=ASSUMED, scale="linear")
        s = Singlebeam(config, context([plane(-20.0)], ocean=still_water(WATER)))
        truth, r = s.sense(at(0, 0, 0)).truth[0], s.tables["range"]
        first = r[(truth > 0.3 * truth.max()).argmax()]
        assert first == pytest.approx(20.0 * ASSUMED / WATER, abs=0.1)

    def test_beams_of_a_multibeam_look_elsewhere(self):
        """A beam of the nominal angle a looks to asin(sin a c/c'): its range over a flat bottom is h/cos of that."""
        config = MultibeamConfig(beams=3, swath_deg=100.0, sound_speed_mps=ASSUMED, range_max_m=60.0)
        s = Multibeam(config, context([plane(-20.0)], ocean=still_water(WATER)))
        truth = s.sense(at(0, 0, 0)).truth[0]
        looks = math.asin(math.sin(math.radians(50.0)) * WATER / ASSUMED)
        assert truth[0] == pytest.approx(20.0 / math.cos(looks), rel=1e-3)
        assert truth[1] == pytest.approx(20.0, rel=1e-3)

    def test_dvl_and_adcp_scale_all_that_they_tell(self):
        """Ground and water track, ranges and altitude by c'/c."""
        motion = {"velocity": (1.0, 0.4, 0.0)}
        exact = {"noise_mps": 0.0, "noise_relative": 0.0, "range_noise_relative": 0.0, "water_layer_m": 5.0}
        readings = []
        for assumed in (None, ASSUMED):
            s = Dvl(DvlConfig(sound_speed_mps=assumed, **exact), context([plane(-20.0)], ocean=still_water(WATER)))
            readings.append(s.sense(at(0, 0, 0, **motion)))
        for name in ("ranges", "altitude", "water_velocity"):
            expected = readings[0].extras[name] * ASSUMED / WATER
            assert readings[1].extras[name] == pytest.approx(expected, rel=1e-5), name
        assert readings[1].data == pytest.approx(readings[0].data * ASSUMED / WATER, rel=1e-5)
        cells = [
            Adcp(
                AdcpConfig(cells=4, noise_mps=0.0, sound_speed_mps=a), context([plane(-5.3)], ocean=still_water(WATER))
            ).sense(at(0, 0, 0, **motion))
            for a in (None, ASSUMED)
        ]
        assert cells[1].data == pytest.approx(cells[0].data * ASSUMED / WATER, rel=1e-5)
        assert np.isfinite(cells[0].extras["ranges"]).all()
        assert cells[1].extras["ranges"] == pytest.approx(cells[0].extras["ranges"] * ASSUMED / WATER, rel=1e-5)

    @pytest.mark.parametrize("assumed", [slow(1400.0), ASSUMED])
    @pytest.mark.parametrize(("sensor", "tilt"), [(Altimeter, 0.0), (Dvl, 30.0), (Adcp, 20.0)])
    def test_echoes_lie_at_the_ranges_that_are_read(self, sensor, tilt, assumed):
        """A flat bottom at h: its echo at h/cos(tilt) c'/c. The middle of power shifts as a whole, to half a bin."""
        keys = {"range_max_m": 60.0} if sensor is not Adcp else {}
        middles = []
        for c in (None, assumed):
            config = sensor.Config(water_column_bins=600, volume_scattering_db=-200.0, sound_speed_mps=c, **keys)
            s = sensor(config, context([plane(-20.0)], ocean=still_water(WATER)))
            extras, r = s.sense(at(0, 0, 0)).extras, s.tables["water_column_range"].astype(float)
            power = 10.0 ** (0.1 * np.atleast_2d(extras["water_column_truth"][0]).astype(float))
            middles.append((power * r).sum(axis=-1) / power.sum(axis=-1))
        assert middles[0] == pytest.approx(20.0 / math.cos(math.radians(tilt)), abs=0.2)
        assert middles[1] == pytest.approx(middles[0] * assumed / WATER, abs=0.5 * (r[1] - r[0]))

    @pytest.mark.parametrize("assumed", [1400.0, ASSUMED])
    def test_a_layer_that_an_adcp_hears_lies_there_too(self, assumed):
        """Sv steps up by 20 dB at 10 m below: the step is at 10/cos(tilt) c'/c along the beams, to two bins: the
        resolution is c/2B = 37 mm, a bin 55 mm."""
        config = AdcpConfig(water_column_bins=600, sound_speed_mps=assumed)
        s = Adcp(config, context([plane(-500.0)], ocean=Layered(dr.opaque(jit.Float64, WATER))))
        level, r = s.sense(at(0, 0, 0)).extras["water_column_truth"][0], s.tables["water_column_range"]
        slant = 10.0 / math.cos(math.radians(20.0)) * assumed / WATER
        for beam in level:
            assert r[np.diff(beam).argmax()] == pytest.approx(slant, abs=2.0 * float(r[1] - r[0]))

    @pytest.mark.parametrize("assumed", [1400.0, ASSUMED])
    def test_an_adcps_water_ends_where_the_bottoms_echo_begins(self, assumed):
        """A flat bottom at h: its echo at h/cos(tilt) c'/c, spread by 1.1 of the beam's widths of 1.5 deg either way:
        0.3 m; 0.2 m more of pulse and bins."""
        config = AdcpConfig(water_column_bins=600, volume_scattering_db=-60.0, sound_speed_mps=assumed)
        s = Adcp(config, context([plane(-28.0)], ocean=still_water(WATER)))
        level, r = s.sense(at(0, 0, 0)).extras["water_column_truth"][0], s.tables["water_column_range"]
        slant = 28.0 / math.cos(math.radians(20.0)) * assumed / WATER
        assert level[:, (r > 5.0) & (r < slant - 0.5)].min() > -80.0
        assert level[:, r > slant + 0.5].max() < -100.0

    @pytest.mark.parametrize("assumed", [1400.0, ASSUMED])
    def test_cells_of_an_adcp_are_of_the_water_that_they_hear(self, assumed):
        """A current of 0.01 z^2: the cell said to be at d holds the water of d c/c', its speed times c'/c; one that the
        bottom's echo reaches by its own range is lost."""
        config = AdcpConfig(cells=20, noise_mps=0.0, sound_speed_mps=assumed)
        s = Adcp(config, context([plane(-15.0)], ocean=Sheared(dr.opaque(jit.Float64, WATER))))
        reading = s.sense(at(0, 0, 0))
        seen, depths = reading.extras["cell_valid"][0] > 0, config.depths
        edge = 15.0 * math.cos(math.radians(20.0)) * assumed / WATER
        assert (seen == (depths + 0.5 * config.cell_m < edge)).all()
        expected = 0.01 * (depths * WATER / assumed) ** 2 * assumed / WATER
        assert reading.data[0, seen, 0] == pytest.approx(expected[seen], rel=1e-5)


@dataclass
class Layered(StillWater):
    """Water that scatters 20 dB more below 10 m; a Dr.Jit struct."""

    tracers: ClassVar[Mapping[str, Any]] = {"volume_scattering_db": None}

    def tracer(self, name, position, t):
        return dr.select(position[2] < -10.0, -60.0, -80.0)


@dataclass
class Sheared(StillWater):
    """A current to the north that grows with the square of the depth; a Dr.Jit struct."""

    def current(self, position, t, copy=None):
        return jit.Array3f64(0.01 * position[2] * position[2], 0.0 * position[0], 0.0 * position[0])


class TestRangeSteps:
    STEP, TILT = 0.05, math.radians(30.0)

    def readings(self, step: float, noise: float, pings: int = 1, **motion):
        """Ranges `(pings, 4)` and altitudes `(pings,)` over a flat bottom, 20 m below a DVL that leans."""
        config = DvlConfig(range_resolution_m=step, range_noise_relative=noise)
        s = Dvl(config, context([plane(-20.0)], ocean=still_water(WATER)))
        found = [s.sense(at(0, 0, 0, tick=k, **motion)).extras for k in range(pings)]
        return np.concatenate([f["ranges"] for f in found]), np.concatenate([f["altitude"] for f in found])

    def test_ranges_are_whole_steps_and_the_altitude_is_their_mean(self):
        """Four different ranges, none more than half a step off; 0 leaves every byte."""
        leaning = {"attitude": (0.9884, 0.1106, -0.0912, 0.05)}
        smooth, _ = self.readings(0.0, 0.0, **leaning)
        ranges, altitude = self.readings(self.STEP, 0.0, **leaning)
        assert len(set(smooth[0].round(2))) == 4
        steps = ranges / self.STEP
        assert steps == pytest.approx(np.round(steps), abs=1e-9)
        assert np.abs(ranges - smooth).max() <= self.STEP / 2 + 1e-9
        assert not np.array_equal(ranges, smooth)
        assert altitude == pytest.approx(ranges.mean(axis=1) * math.cos(self.TILT), rel=1e-12)

    def test_steps_add_a_twelfth_of_their_square_to_the_noise(self):
        """Sheppard's correction, r^2 n^2 + q^2/12: noise of 2.3 cm under steps of 5 cm, 400 pings of four beams.

        Within 4 standard errors of a deviation; the same draws without steps tell the noise itself.
        """
        noise, pings = 1e-3, 400
        smooth, _ = self.readings(0.0, noise, pings)
        ranges, _ = self.readings(self.STEP, noise, pings)
        r = 20.0 / math.cos(self.TILT)
        error = 4 / math.sqrt(2 * 4 * pings)
        assert (smooth - smooth.mean(axis=0)).std() == pytest.approx(r * noise, rel=error)
        assert (ranges - ranges.mean(axis=0)).std() == pytest.approx(
            math.hypot(r * noise, self.STEP / 12**0.5), rel=error
        )
        assert (ranges - smooth).std() == pytest.approx(self.STEP / 12**0.5, rel=error)

    def test_a_pathfinder_tells_its_ranges_in_centimetres_downwards(self):
        """Pathfinder DVL Guide (2018), Table 40: 1 cm of range times the cosine of the beams' tilt."""
        s = Dvl(DvlConfig(device="pathfinder_600"), context([plane(-20.0)], ocean=still_water(WATER)))
        downwards = s.sense(at(0, 0, 0)).extras["ranges"][0] * math.cos(self.TILT) * 100.0
        assert downwards == pytest.approx(np.round(downwards), abs=1e-6)


def test_a_converter_has_steps_and_a_top():
    """6 bits: steps of 1/31 of the top, and nothing louder than it."""
    config = SinglebeamConfig(
        range_max_m=30.0, bins=400, iq=True, adc_bits=6, adc_full_scale_db=115.0, source_level_db=205.0
    )
    iq = Singlebeam(config, context([plane(-12.0)])).sense(at(0, 0, 0)).extras["iq"][0]
    top = 10 ** ((115.0 - 205.0) / 20)
    parts = np.concatenate([iq.real, iq.imag]) / (top / 31)
    assert np.abs(parts - np.round(parts)).max() < 0.01
    assert np.abs(parts).max() <= 32.01
    assert np.abs(parts).max() >= 31.0  # the bottom is louder than the top


def test_the_transducer_rings_until_it_does_not():
    """150 dB at the end of the pulse, 20 dB/ms less from then on: level at 1 m (1.33 ms) and 2 m, before gain."""
    config = SinglebeamConfig(
        range_max_m=10.0, bins=400, iq=True, ringing_db=150.0, ringing_db_per_ms=20.0, self_noise_db=-100.0,
    )  # fmt: skip
    s = Singlebeam(config, context([plane(-500.0)], n=1))
    power = np.mean([np.abs(s.sense(at(0, 0, 0, tick=k)).extras["iq"][0]) ** 2 for k in range(40)], axis=0)
    r = s.tables["range"]
    for reach in (1.0, 2.0):
        near = np.abs(r - reach) < 0.15
        level = 10 * math.log10(np.mean(power[near] * 10 ** (2.0 * (2 * r[near] / 1.5))))
        assert level == pytest.approx(150.0 - config.source_level_db, abs=0.8)


def test_a_sidescan_hears_the_surface_above_it():
    """5 m below a flat surface and 15 m above the bottom: a line at 5 m, before the bottom's at 15 m."""
    s = Sidescan(SidescanConfig(range_max_m=40.0, bins=800, scale="db"), context([plane(-20.0)]))
    truth, r = s.sense(at(0, 0, -5.0)).truth[0], s.tables["range"]
    line = truth[:, np.abs(r - 5.0) < 0.3].max()
    assert line > truth[:, (r > 1.0) & (r < 4.5)].max() + 20.0
    deep = Sidescan(SidescanConfig(range_max_m=40.0, bins=800, scale="db"), context([plane(-120.0)]))
    assert deep.sense(at(0, 0, -60.0)).truth[0][:, r < 35.0].max() < line - 20.0


@pytest.mark.parametrize("resolution", [60.0, 150.0])
def test_long_pulses_are_spread_as_short_ones(resolution):
    """Against the plain sum: within 2.5 % of the peak, for a strong echo in noise."""
    rng = np.random.Generator(np.random.PCG64(1))
    bins, pulse = 1000, point_spread(1.0, resolution)
    row = pitch(bins)
    field = rng.normal(size=(2, row, 2)).astype(np.float32)
    field[:, bins:] = 0.0
    field[:, 403] += 30.0
    assert len(pulse) > beamforming._LONG
    found = beamforming.spread_pulse(jit.Float(field.ravel()), jit.Float(pulse), channels=2, bins=bins)
    found = np.array(found).reshape(2, row, 2)[:, :bins]
    expected = np.stack(
        [[np.convolve(field[i, :bins, c], pulse, mode="same") for c in range(2)] for i in range(2)]
    ).transpose(0, 2, 1)
    assert np.abs(found - expected).max() < 0.025 * np.abs(expected).max()


class TestRefused:
    @pytest.mark.parametrize(
        ("config", "keys", "match"),
        [
            (ImagingSonarConfig, {"pulse_s": 0.3}, "pulse_s 0.3 is longer than the 0.2 s between two pings"),
            (MultibeamConfig, {"pulse_s": 0.3}, "longer than"),
            (ImagingSonarConfig, {"source_level_db": 400.0}, "less than or equal to 300"),
            (MultibeamConfig, {"frequency_hz": 10.0}, "greater than or equal to 200"),
            (DvlConfig, {"beam_tilt_deg": 1.5}, "deg between two beams"),
            (DvlConfig, {"beam_azimuth_deg": (0.0, 1.0, 2.0, 3.0)}, "they would measure the same"),
            (ImagingSonarConfig, {"bandwidth_hz": 100.0}, "by its shortness alone, 2000 Hz: give a pulse_s of 0.01 or"),
            (
                AdcpConfig,
                {"pulse_s": 2e-5},
                r"bandwidth_hz 20000 \(by default\) is less than a pulse with pulse_s 2e-05",
            ),
            (ImagingSonarConfig, {"self_noise_db": 400.0}, "less than or equal to 200"),
            (ImagingSonarConfig, {"floor_db": math.nan}, "finite number"),
            (DvlConfig, {"frequency_hz": math.inf}, "finite number"),
            (
                ImagingSonarConfig,
                {"beamwidth_deg": 0.05},
                r"0.508 deg between beams, .* give at least 0.1, or 2600 beams",
            ),
        ],
    )
    def test_nonsense(self, config, keys, match):
        with pytest.raises(ValidationError, match=match):
            config(**keys)

    @pytest.mark.parametrize(
        ("config", "keys", "match"),
        [
            (ImagingSonarConfig, {"device": "oculus_m750d", "rate_hz": 20.0},
             r"range_max_m 120 \(of the device oculus_m750d\) is ambiguous at rate_hz 20 pings a second: .* give a "
             r"range_max_m of at most 35, or a rate_hz of at most 5.83"),
            (ImagingSonarConfig, {"device": "oculus_m750d", "range_min_m": 150.0},
             r"range_min_m 150 must be below range_max_m 120 \(of the device oculus_m750d\): give both"),
            (ImagingSonarConfig, {"device": "oculus_m750d_high", "pulse": "cw", "bandwidth_hz": 60e3},
             r"is not that of a tone burst .* with pulse_s 0.0005 \(by default\), 2000 Hz: give that, or leave it out"),
            (ImagingSonarConfig, {"device": "gemini_720is", "frequency_hz": 30e3},
             r"bandwidth_hz 90000 \(of the device gemini_720is\) must be below twice frequency_hz 30000: give a band"),
            (ImagingSonarConfig, {"device": "oculus_m750d_high", "beams": 20},
             r"beamwidth_deg 0.6 \(of the device oculus_m750d_high\) is much narrower than the 3.5 deg between beams"),
            (MultibeamConfig, {"device": "seabat_7160", "rate_hz": 250.0},
             r"pulse_s 0.005 \(of the device seabat_7160\) is longer than the 0.004 s between two pings"),
            (DvlConfig, {"device": "pathfinder_600", "range_min_m": 100.0},
             r"must be below range_max_m 89 \(of the device pathfinder_600\)"),
            (DvlConfig, {"device": "pathfinder_600", "beamwidth_deg": 18.0, "beam_tilt_deg": 10.0},
             "of beamwidth_deg 18: they would measure the same"),
        ],
    )  # fmt: skip
    def test_conflicts_tell_whose_keys_they_are_and_what_to_do(self, config, keys, match):
        with pytest.raises(ValidationError, match=match):
            config(**keys)

    @pytest.mark.parametrize(("range_max_m", "rate_hz"), [(60.0, 11.7), (120.0, 20.0), (75.3, 31.7), (700.0, 2.0)])
    def test_limits_that_a_message_tells_are_taken(self, range_max_m, rate_hz):
        """The largest of four digits: not less than by one in the last."""
        with pytest.raises(ValidationError, match="is ambiguous") as told:
            ImagingSonarConfig(range_max_m=range_max_m, rate_hz=rate_hz)
        farthest, fastest = (
            float(re.search(f"{key} of at most ([0-9]+(?:[.][0-9]+)?)", str(told.value))[1])
            for key in ("range_max_m", "rate_hz")
        )
        ImagingSonarConfig(range_max_m=farthest, rate_hz=rate_hz)
        ImagingSonarConfig(range_max_m=range_max_m, rate_hz=fastest)
        assert farthest == pytest.approx(700.0 / rate_hz, rel=1e-3)
        assert fastest == pytest.approx(700.0 / range_max_m, rel=1e-3)

    def test_a_devices_keys_do_not_stand_in_the_way(self):
        """A tone burst has its own bandwidth, whatever the device's chirp had."""
        config = ImagingSonarConfig(device="oculus_m750d_high", pulse="cw", pulse_s=1e-4)
        assert config.bandwidth_hz == pytest.approx(1e4)


@pytest.mark.parametrize(
    ("sensor", "keys", "idle"),
    [
        (Altimeter, {"source_level_db": 190.0}, "'source_level_db'"),
        (Adcp, {"lag_s": 2e-4, "self_noise_db": 40.0}, "'self_noise_db', 'lag_s'"),
        (Adcp, {"frequency_hz": 3e5, "beamwidth_deg": 3.0}, "'frequency_hz', 'beamwidth_deg'"),
        (Dvl, {"device": "waterlinked_a50", "pulse_s": 2e-3}, "'pulse_s'"),
    ],
)
def test_keys_of_echoes_that_nobody_asks_for_are_told(sensor, keys, idle):
    build = lambda **more: sensor(sensor.Config(**keys, **more), context([plane(-9.0)]))
    with pytest.warns(ValidityWarning, match=f"{idle} changes nothing without 'water_column_bins', 'iq' or 'labels'"):
        build()
    with warnings.catch_warnings():
        warnings.simplefilter("error", ValidityWarning)
        build(water_column_bins=64, iq=True)


@pytest.mark.parametrize(
    ("sensor", "keys", "message"),
    [
        (Singlebeam, {"ringing_db_per_ms": 20.0}, "'ringing_db_per_ms' changes nothing without 'ringing_db'"),
        (Singlebeam, {"adc_full_scale_db": 120.0}, "'adc_full_scale_db' changes nothing without 'adc_bits'"),
        (Sidescan, {"multipath_order": 2}, "'multipath_order' .* without 'multipath: surface or surface_and_bottom'"),
        (Singlebeam, {"multipath": "surface", "bottom_loss_db": 3.0}, "without 'multipath: surface_and_bottom'"),
        (Multibeam, {"labels": True}, "'labels' changes nothing without 'water_column_bins'"),
        (
            Multibeam,
            {"sectors": 3, "stabilised": ("roll",)},
            "'sectors' .* without 'sector_spacing_hz', or 'stabilised'",
        ),
        (IncidenceSonar, {"scale_noise": True}, "'scale_noise' changes nothing without 'additive'"),
        (IncidenceSonar, {"cone": True, "beams": 1, "vertical_aperture_deg": 30.0}, "nothing without 'cone: False'"),
        (Dvl, {"roughness_seed": 3}, "'roughness_seed' changes nothing without 'water_column_bins', 'iq' or 'labels'"),
        (Adcp, {"lag_s": 2e-4, "water_column_bins": 64}, "'lag_s' changes nothing without 'iq'"),
        (Dvl, {"lag_s": 2e-4, "labels": True}, "'lag_s' changes nothing without 'iq'"),
    ],
)
def test_keys_that_change_nothing_are_told(sensor, keys, message):
    with pytest.warns(ValidityWarning, match=message):
        sensor(sensor.Config(**keys), context([plane(-9.0)]))


@pytest.mark.parametrize(
    ("sensor", "keys"),
    [
        (Singlebeam, {"ringing_db": 150.0, "ringing_db_per_ms": 20.0, "adc_bits": 9, "adc_full_scale_db": 120.0}),
        (Singlebeam, {"multipath": "surface_and_bottom", "multipath_order": 2, "bottom_loss_db": 3.0}),
        (Multibeam, {"sectors": 3, "stabilised": ("roll", "yaw")}),
        (IncidenceSonar, {"scale_noise": True, "additive": 0.1, "vertical_aperture_deg": 30.0}),
        (Multibeam, {"sectors": 3, "sector_spacing_hz": 2e3, "labels": True, "water_column_bins": 64}),
    ],
)
def test_keys_that_change_something_are_not_told(sensor, keys):
    with warnings.catch_warnings():
        warnings.simplefilter("error", ValidityWarning)
        sensor(sensor.Config(**keys), context([plane(-9.0)]))


@pytest.mark.parametrize(
    ("config", "keys", "message"),
    [
        (IncidenceSonarConfig, {"cone": True}, "a cone is one beam: give beams: 1 with cone: true, not 256"),
        (SyntheticApertureSonarConfig, {"iq": False}, "iq: false leaves nothing of a sonar"),
        (SyntheticApertureSonarConfig, {"painted_noise": {"multiplicative": 0.1}}, "painted on levels"),
    ],
)
def test_keys_without_effect_are_refused(config, keys, message):
    with pytest.raises(ValidationError, match=message):
        config(**keys)
