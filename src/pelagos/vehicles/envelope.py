"""Envelope of a vehicle: speeds, turning circle, depth. Missions keep within it."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from pelagos.vehicles.part import PartConfig, Positive


class EnvelopeConfig(PartConfig):
    """Limits of what missions ask for, and what they ask for where a leg says nothing."""

    cruise_mps: Positive = 1.5
    """Speed where a leg gives none [m/s]."""
    slow_mps: Positive | None = None
    """Least speed at which it steers; none for those that hover [m/s]."""
    top_mps: Positive | None = None
    """Largest speed that a leg may ask for [m/s]; None: not stated."""
    turn_radius_m: Positive | None = None
    """Smallest circle that a leg may ask for, and the one about a place where it cannot stop [m]; None: not stated, or
    it turns on the spot."""
    turn_speed_mps: Positive | None = None
    """Speed of that circle where it grows with the square of the speed, as for what banks [m/s]; None: it does not."""
    tolerance_m: Positive = 5.0
    """A place counts as reached within this distance, where a leg does not say [m]."""
    depth_m: Positive | None = None
    """Largest depth that a leg may ask for [m]; None: not stated."""

    def smallest_circle_m(self, speed_mps: float) -> float:
        """Radius of the smallest circle at a speed [m]; 0: not stated.

        A rudder's circle is much the same at any speed; a banked one is V^2 / (g tan(bank)).
        """
        radius = self.turn_radius_m or 0.0
        return radius if self.turn_speed_mps is None else radius * (speed_mps / self.turn_speed_mps) ** 2

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.top_mps is not None and self.cruise_mps > self.top_mps:
            raise ValueError(f"cruise_mps {self.cruise_mps:g} must not be above top_mps {self.top_mps:g}")
        return self
