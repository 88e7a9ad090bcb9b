"""Axes that a mode with a neutral speed has to steer."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

import pelagos as pl
from pelagos.vehicles.control.velocity import VelocityConfig


@pytest.mark.parametrize("axes", [("surge", "yaw"), ("heave", "yaw"), ("surge", "heave", "pitch")])
def test_a_neutral_speed_is_of_modes_with_surge_and_heave_and_without_pitch(axes: tuple[str, ...]) -> None:
    modes = pl.Vehicle.from_catalogue("bluerov2").config.modes.values()
    given = next(m for m in modes if isinstance(m, VelocityConfig)).model_dump()
    kept = {"level": (), "neutral_speed_mps": 1.2}
    assert VelocityConfig.model_validate(given | kept | {"axes": ("surge", "heave", "yaw")})
    with pytest.raises(ValidationError, match="neutral_speed_mps is for axes with surge and heave, without pitch"):
        VelocityConfig.model_validate(given | kept | {"axes": axes})
