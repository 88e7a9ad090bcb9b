"""Signals of the receive array's elements: delay and sum over them gives the device's own beams."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import at, context, plane, sphere

from pelagos.acoustics.noise import ambient_level, directivity_index
from pelagos.errors import ValidityWarning
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.world.material import MATERIALS

pytestmark = pytest.mark.filterwarnings("ignore:.*finer than the pulse resolves")
SMALL = {
    "beams": 64, "bins": 200, "range_max_m": 30.0, "horizontal_aperture_deg": 60.0, "orientation_deg": (0, 15, 0),
    "rays_per_beam": 48, "iq": True, "elements": True, "scale": "linear", "source_level_db": 230.0,
    "shading": "hann",
}  # fmt: skip


def delay_and_sum(reading, s: ImagingSonar, azimuth: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Beams `(len(azimuth), bins)` by the equation alone: sum over w exp(-2 pi i f y sin(a)/c) e."""
    y = s.tables["element_position"][:, 1].astype(float)
    weights = s.tables["element_weights"] if weights is None else weights
    cycles = s.config.frequency_hz / float(reading.extras["steering_speed"][0]) * np.outer(np.sin(azimuth), y)
    return (np.exp(-2j * np.pi * cycles) * weights) @ reading.extras["elements"][0]


def departure(s: ImagingSonar, motion=None) -> tuple[float, np.ndarray, np.ndarray]:
    """Energy of the difference to the device's beams over theirs, and both; of beams whose main lobe is in the
    sector."""
    reading = s.sense(at(0.3, -0.2, 0.1, tick=3) if motion is None else motion)
    azimuth = s.tables["azimuth"].astype(float)
    formed, own = delay_and_sum(reading, s, azimuth)[4:-4], reading.extras["iq"][0][4:-4]
    return float((np.abs(formed - own) ** 2).sum() / (np.abs(own) ** 2).sum()), formed, own


SCENES = {
    "bottom": ([plane(-6.0)], {}),
    "steel sphere": ([plane(-1000.0), sphere((12.0, 3.0, -3.2), 0.2)], {}),
    "noise alone": ([plane(-1000.0)], {"source_level_db": 150.0}),
    "ringing": ([plane(-1000.0)], {"ringing_db": 180.0}),
    "water": ([plane(-1000.0)], {"volume_scattering_db": -40.0}),
}


@pytest.mark.parametrize("scene", SCENES)
def test_delay_and_sum_gives_the_device_s_own_beams(scene):
    """Within -40 dB of their energy: elements half a wavelength apart depart from a continuous line by (pi d s)^2/6,
    0.2 % at 8 beams' distance and less where the main lobe is, and rows of the device's beamformer have unit power."""
    things, options = SCENES[scene]
    s = ImagingSonar(ImagingSonarConfig(**(SMALL | options)), context(things, materials=(MATERIALS["steel"],)))
    off, _, own = departure(s)
    assert off < 1e-4
    assert np.abs(own).max() > 0


def test_an_array_that_turns_hears_where_it_looks_when_the_echo_comes():
    """At 2 rad/s about an axis pitched by 15 deg, from 27 m: by 2 w r/c, 3.9 deg, to the right. The device's own beams
    go on by whole sectors (0.94 deg), those of elements by angles."""
    config = ImagingSonarConfig(**SMALL)
    s = ImagingSonar(config, context([plane(-6.0)]))
    still, turning = (s.sense(at(0.0, 0.0, 0.0, tick=1, angular_velocity=(0.0, 0.0, rate))) for rate in (0.0, 2.0))
    sector = math.radians(config.horizontal_aperture_deg) / config.beams
    far = slice(178, 182)  # 27 m
    delay = 2.0 * float(s.tables["range"][far].mean()) / 1500.0
    fine = s.tables["azimuth"].astype(float)[8:-8]
    before = delay_and_sum(still, s, fine)[:, far]
    shifts = np.linspace(-6.0, 2.0, 161) * sector
    alike = [abs(np.vdot(before, delay_and_sum(turning, s, fine + shift)[:, far])) for shift in shifts]
    assert shifts[int(np.argmax(alike))] == pytest.approx(-2.0 * delay * math.cos(math.radians(15)), abs=0.1 * sector)


def test_noise_of_an_element_is_that_of_a_beam_over_its_gain():
    """A beam's by the sonar equation (see `test_sonar_levels`), an element's by the sum of squared weights over it."""
    config = ImagingSonarConfig(**(SMALL | {"source_level_db": 205.0}))
    s = ImagingSonar(config, context([plane(-1000.0)]))
    reading = s.sense(at(0, 0, 0))
    density = 10 * math.log10(10 ** (ambient_level(750e3, 5.0) / 10) + 10 ** (config.self_noise_db / 10))
    beam_db = density - 10 * math.log10(config.pulse_s) + 10 * math.log10(1.5)
    beam_db -= directivity_index(math.radians(1.0), math.radians(20.0)) + 205.0
    weights = s.tables["element_weights"]
    expected = beam_db - 10 * math.log10((weights**2).sum())
    measured = 10 * math.log10((np.abs(reading.extras["elements"]) ** 2).mean())
    assert measured == pytest.approx(expected, abs=4 * 4.34 / math.sqrt(reading.extras["elements"].size))


def test_a_sphere_s_phases_are_its_bearing():
    """Over the array they grow by 2 pi f y sin(a)/c: a steel sphere 12.4 m away, 14 deg to the left."""
    place = np.array([12.0, 3.0, 0.0])
    s = ImagingSonar(
        ImagingSonarConfig(**(SMALL | {"orientation_deg": (0, 0, 0), "source_level_db": 270.0})),
        context([plane(-1000.0), sphere(tuple(place), 0.15)], materials=(MATERIALS["steel"],)),
    )
    signal = s.sense(at(0, 0, 0)).extras["elements"][0]
    k = int((np.abs(signal) ** 2).sum(axis=0).argmax())
    y = s.tables["element_position"][:, 1].astype(float)
    slope = np.polyfit(y, np.unwrap(np.angle(signal[:, k])), 1)[0]
    bearing = math.asin(slope * 1500.0 / (2 * math.pi * 750e3))
    assert bearing == pytest.approx(math.atan2(3.0, 12.0), abs=math.radians(0.05))


def test_converters_of_elements_step_and_cut_off():
    """8 bits below 140 dB re 1 uPa: 255 steps, none beyond."""
    options = {"adc_bits": 8, "adc_full_scale_db": 140.0}
    s = ImagingSonar(ImagingSonarConfig(**(SMALL | options)), context([plane(-6.0)]))
    parts = s.sense(at(0, 0, 0)).extras["elements"].view(np.float32)
    step = 10 ** ((140.0 - 230.0) / 20) / 127
    assert parts / step == pytest.approx(np.round(parts / step), abs=1e-3)
    assert parts.min() / step == pytest.approx(-128, abs=1e-3)
    assert parts.max() / step == pytest.approx(127, abs=1e-3)


def test_elements_refuse_what_only_beams_hear():
    with pytest.raises(ValidationError, match="elements hear no other sonars"):
        ImagingSonarConfig(elements=True, hears="others")
    with pytest.raises(ValidationError, match="no interference"):
        ImagingSonarConfig(elements=True, interference={"rate_hz": 5})


def faulty(seed: int = 0, **options) -> ImagingSonar:
    """A steel sphere 12.4 m away, 14 deg to the left, before a sonar whose channels differ."""
    keys = SMALL | {"orientation_deg": (0, 0, 0), "source_level_db": 270.0, "channel_seed": seed, "elements": False}
    things = [plane(-1000.0), sphere((12.0, 3.0, 0.0), 0.15)]
    return ImagingSonar(ImagingSonarConfig(**(keys | options)), context(things, materials=(MATERIALS["steel"],)))


def test_errors_of_channels_raise_a_floor_of_side_lobes():
    """Variance v and mean m of a channel: v/m^2 times the sum of squared weights, over the lobe that looks there.

    By the moments of a log-normal gain and a normal phase: 1.2 dB and 9 deg of 166 Hann-shaded elements, -34 dB,
    where the design is below -60 dB. 24 devices by 30 beams, of which one in two is independent: 5 %.
    """
    gain, phase = 1.2 * math.log(10) / 20, math.radians(9.0)
    mean = math.exp(gain**2 / 2 - phase**2 / 2)
    variance = math.exp(2 * gain**2) - mean**2
    floors, designs = [], []
    for seed in range(24):
        s = faulty(seed, channel_gain_db=1.2, channel_phase_deg=9.0)
        heard = np.abs(s.sense(at(0, 0, 0)).extras["iq"][0]) ** 2
        level = heard[:, heard.max(axis=0).argmax()]
        away = np.abs(np.arange(64) - level.argmax()) > 12
        floors.append(level[away].mean() / level.max())
    whole = faulty(elements=True)
    picture = np.abs(delay_and_sum(whole.sense(at(0, 0, 0)), whole, whole.tables["azimuth"].astype(float))) ** 2
    level = picture[:, picture.max(axis=0).argmax()]
    designs.append(level[np.abs(np.arange(64) - level.argmax()) > 12].mean() / level.max())
    squares = float((whole.tables["element_weights"].astype(float) ** 2).sum())
    middle = 1.0 / float(_scallop(whole))
    assert np.mean(floors) == pytest.approx(variance / mean**2 * squares * middle, rel=0.15)
    assert designs[0] < 1e-2 * np.mean(floors)


def _scallop(s: ImagingSonar) -> float:
    """Power pattern of the beam that is nearest to the sphere in its direction."""
    y = s.tables["element_position"][:, 1].astype(float) * 750e3 / 1500.0
    sine = math.sin(math.atan2(3.0, 12.0))
    nearest = np.sin(s.tables["azimuth"].astype(float))
    offset = np.abs(nearest - sine).min()
    return abs((s.tables["element_weights"] * np.exp(2j * np.pi * y * offset)).sum()) ** 2


def test_a_picture_of_faulty_channels_is_their_delay_and_sum():
    """Beams, signal and noise are of the elements that are given, converters and silent ones included."""
    options = {"channel_gain_db": 2.0, "channel_phase_deg": 20.0, "dead_elements": 0.1, "adc_bits": 16}
    options["adc_full_scale_db"] = 120.0
    s = ImagingSonar(ImagingSonarConfig(**(SMALL | options)), context([plane(-6.0)]))
    reading = s.sense(at(0.3, -0.2, 0.1, tick=3))
    formed = delay_and_sum(reading, s, s.tables["azimuth"].astype(float))
    assert reading.extras["iq"][0] == pytest.approx(formed, abs=1e-3 * np.abs(formed).max())
    silent = ~reading.extras["elements"][0].any(axis=-1)
    assert silent.sum() == round(0.1 * len(silent))


def test_channels_without_errors_to_speak_of_give_the_usual_picture():
    tiny, plain = (
        ImagingSonar(ImagingSonarConfig(**(SMALL | more)), context([plane(-6.0)]))
        for more in ({"channel_phase_deg": 1e-4, "elements": False}, {})
    )
    a, b = (s.sense(at(0.3, -0.2, 0.1, tick=3)).extras["iq"][0][4:-4] for s in (tiny, plain))
    assert (np.abs(a - b) ** 2).sum() < 1e-4 * (np.abs(b) ** 2).sum()
    assert "elements" not in tiny.sense(at(0, 0, 0)).extras


def test_another_seed_is_another_device():
    pictures = [faulty(seed, channel_gain_db=1.0).sense(at(0, 0, 0)).data for seed in (1, 1, 2)]
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


@pytest.mark.parametrize("scene", ["bottom", "water"])
def test_a_multibeam_s_water_column_is_the_delay_and_sum_of_its_elements(scene):
    """Beams of the whole array, Hamming-shaded, over a bottom and in hazy water: within -37 dB of their energy."""
    config = MultibeamConfig(
        beams=64, swath_deg=90.0, range_max_m=30.0, water_column_bins=240, iq=True, elements=True, bandwidth_hz=8e3,
        beamwidth_across_deg=2.0, volume_scattering_db=-40.0 if scene == "water" else None, source_level_db=230.0,
    )  # fmt: skip
    s = Multibeam(config, context([plane(-1000.0 if scene == "water" else -14.0, slope=0.1)]))
    reading = s.sense(at(0.0, 0.0, 0.0, tick=2))
    y = s.tables["element_position"][:, 1].astype(float)
    speed = float(reading.extras["water_column_steering_speed"][0])
    cycles = config.frequency_hz / speed * np.outer(np.sin(s.tables["angle"].astype(float)), y)
    formed = (np.exp(-2j * np.pi * cycles) * s.tables["element_weights"]) @ reading.extras["water_column_elements"][0]
    own = reading.extras["water_column_iq"][0]
    middle = slice(6, -6)
    assert (np.abs(formed - own)[middle] ** 2).sum() < 2e-4 * (np.abs(own)[middle] ** 2).sum()


def test_elements_of_a_multibeam_need_its_water_column():
    with pytest.warns(ValidityWarning, match="'elements' changes nothing without 'water_column_bins'"):
        Multibeam(MultibeamConfig(elements=True, beams=16), context([plane(-10.0)]))
