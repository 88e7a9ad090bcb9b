"""Speed through the water by the propeller: feed-forward and PI."""

from __future__ import annotations

from typing import Self

import drjit as dr
from pydantic import model_validator

from pelagos.jit import Array
from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive, check_limits


class SpeedGains(PartConfig):
    """Gains and limits of the speed loop."""

    feed_forward_rpm_s_m: NonNegative
    """Shaft speed by wanted speed [rpm/(m/s)]."""
    kp_rpm_s_m: NonNegative
    """Shaft speed by speed error [rpm/(m/s)]."""
    ki_rpm_m: NonNegative
    """Shaft speed by the integral of the speed error [rpm/m]."""
    low_rpm: Number = 0.0
    """Least shaft speed [rpm]."""
    high_rpm: Positive
    """Largest shaft speed [rpm]."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_limits(self, "low_rpm", "high_rpm")
        return self


def shaft_speed(gains: SpeedGains, integral: Array, setpoint: Array, speed: Array, h: Array) -> tuple[Array, Array]:
    """Shaft speed [rpm] for a speed through the water [m/s], and the integral of the error [m]; no wind-up."""
    error = setpoint - speed
    asked = gains.feed_forward_rpm_s_m * setpoint + gains.kp_rpm_s_m * error + gains.ki_rpm_m * integral
    given = dr.clip(asked, gains.low_rpm, gains.high_rpm)
    held = dr.select((asked == given) | ((asked - given) * error < 0), integral + h * error, integral)
    return given, held
