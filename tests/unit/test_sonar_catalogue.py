"""Devices by data sheet: every one builds its sensor's configuration."""

from __future__ import annotations

import importlib

import pytest
from pydantic import ValidationError

from pelagos.config.registry import BUILT_IN
from pelagos.sensors.sonar.dvl import DvlConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonarConfig
from pelagos.sensors.sonar.keys.devices import DEVICES


@pytest.mark.parametrize(("kind", "name"), [(k, n) for k, devices in DEVICES.items() for n in devices])
def test_every_device_is_a_valid_configuration_with_a_source(kind, name):
    module, cls = BUILT_IN["sensor"][kind].split(":")
    config_class = getattr(importlib.import_module(module), cls).Config
    config = config_class(device=name)
    found = DEVICES[kind][name]
    assert found.source
    assert set(found.assumed) <= set(found.keys)
    for key, value in found.keys.items():
        assert getattr(config, key) == value
    assert config_class.model_validate(config.model_dump()) == config
    assert (200.0 / config.rate_hz).is_integer()  # it can be used at the default tick rate as it is


def test_keys_of_the_scenario_win():
    config = ImagingSonarConfig(device="gemini_720is", range_max_m=20.0)
    assert config.range_max_m == 20.0
    assert config.frequency_hz == 720e3


def test_an_unknown_device_is_refused_with_the_nearest():
    with pytest.raises(ValidationError, match="did you mean 'waterlinked_a50'"):
        DvlConfig(device="water_linked_a50")
