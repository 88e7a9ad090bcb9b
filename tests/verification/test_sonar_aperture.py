"""Synthetic aperture: how far apart pings may lie."""

from __future__ import annotations

import math
import warnings

import pytest
from sonar_scenes import at, context, plane

from pelagos.errors import ValidityWarning
from pelagos.sensors.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig

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
