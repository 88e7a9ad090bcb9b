"""Synthetic aperture: how far apart pings may lie, and what becomes of an image where they lie farther."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from sonar_scenes import DT_NS, at, box, context, plane

from pelagos.errors import ValidityWarning
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig

DEEP = -200.0
SMALL = {"rays": 1024, "range_max_m": 20.0, "bins": 800, "rate_hz": 10.0}


def sonar(**options):
    config = SyntheticApertureSonarConfig(**(SMALL | options))
    return config, SyntheticApertureSonar(config, context([plane(-10.0)], path="auv0.sas"))


def test_the_longest_step_is_half_an_element():
    """15 deg at 120 kHz: 0.8859 lambda/sin-width, as an unweighted line: 12.5 mm 0.8859/(2 sin 7.5 deg) = 42.4 mm."""
    element = 0.8859 * 1500.0 / 120e3 / (2 * math.sin(math.radians(7.5)))
    assert SyntheticApertureSonarConfig().step_m == pytest.approx(0.5 * element, rel=5e-3)


def test_the_fastest_track_is_not_warned_of():
    config, s = sonar()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        s.sense(at(0, 0, -3.0, velocity=(config.step_m * config.rate_hz, 0.3, 0.1)))  # only the way along it counts
        s.sense(at(0, 0, -3.0, velocity=(-config.step_m * config.rate_hz, 0, 0)))


def test_a_faster_one_is_once_and_told_what_would_do():
    config, s = sonar()
    with pytest.warns(ValidityWarning) as found:
        s.sense(at(0, 0, -3.0, velocity=(0.5, 0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        s.sense(at(0, 0, -3.0, tick=1, velocity=(0.5, 0, 0)))
    assert len(found) == 1
    message = str(found[0].message)
    assert message.startswith("auv0.sas: at 0.5 m/s and 10 Hz pings lie 0.05 m apart")
    assert f"go at {10 * config.step_m:.3g} m/s or slower or ping at {0.5 / config.step_m:.3g} Hz" in message


def test_no_rate_is_proposed_that_the_range_forbids():
    """20 m allow for 35 pings a second; at 1.5 m/s and 21 mm a ping 71 would be needed."""
    _, s = sonar()
    with pytest.warns(ValidityWarning, match=r"slower \(a range of 20 m allows for 35 Hz\), or take a longer element"):
        s.sense(at(0, 0, -3.0, velocity=(1.5, 0, 0)))


def test_turning_about_a_lever_arm_counts():
    """0.5 rad/s 1 m to the left: 0.5 m/s along the track."""
    _, s = sonar(position_m=(0.0, 1.0, 0.0))
    with pytest.warns(ValidityWarning, match=r"at 0.5 m/s"):
        s.sense(at(0, 0, -3.0, angular_velocity=(0, 0, 0.5)))


class TestGhosts:
    """Pings s apart show a point again at lambda R/(2 s) along the track, in the element's two-way pattern there."""

    RANGE, WAVE = 10.0, 1500.0 / 120e3

    @pytest.fixture(scope="class")
    @staticmethod
    def raw():
        """A box of 0.1 m 10 m to the side, passed in steps of a quarter of the element: places and pings."""
        config = SyntheticApertureSonarConfig(
            range_min_m=9.5, range_max_m=11.5, bins=160, rays=12800, rate_hz=20.0, depression_deg=0.0, doppler=False,
            vertical_beamwidth_deg=2.0, self_noise_db=-200.0,
        )  # fmt: skip
        s = SyntheticApertureSonar(config, context([box((0.0, 10.05, DEEP), (0.1, 0.1, 0.1))]))
        x = np.arange(-3.5, 3.5, config.step_m / 2)
        pings = [
            s.sense(lanes(range(len(part)), dt_ns=DT_NS, position=np.stack([part, 0 * part, 0 * part + DEEP], axis=-1)))
            for part in np.array_split(x, 60)
        ]
        return config, x, np.concatenate([p.data for p in pings]), s.tables["range"].astype(float)

    def focused(self, raw, every):
        """Amplitude along the track at the box's range, of every so-manieth ping, and the spacing of pings."""
        config, x, data, r = raw
        along = np.arange(-3.0, 3.0, 0.01)
        image = np.zeros(len(along), complex)
        for place, trace in zip(x[::every], data[::every], strict=True):
            way = np.hypot(self.RANGE, along - place)
            value = np.interp(way, r, trace.real) + 1j * np.interp(way, r, trace.imag)
            turned = value * np.exp(4j * np.pi * way / self.WAVE)
            image += np.where(np.abs(along - place) < 0.14 * self.RANGE, turned, 0.0)
        return along, np.abs(image), every * config.step_m / 2

    @pytest.mark.parametrize("every", [1, 2])
    def test_there_are_none_up_to_the_longest_step(self, raw, every):
        """25 dB down: there the pattern has its nulls, of the width of the box."""
        along, image, _ = self.focused(raw, every)
        top = image.argmax()
        assert along[top] == pytest.approx(0.0, abs=0.05)
        assert image[np.abs(along) > 0.3].max() < 10 ** (-25 / 20) * image[top]

    @pytest.mark.parametrize("every", [6, 8])
    def test_beyond_it_they_stand_where_they_should(self, raw, every):
        along, image, step = self.focused(raw, every)
        aside = np.abs(along) > 0.3
        assert image[aside].max() > 10 ** (-12 / 20) * image.max()
        place = np.abs(along[aside][image[aside].argmax()])
        assert place == pytest.approx(self.WAVE * self.RANGE / (2 * step), rel=0.03)  # the next order of a parabola
