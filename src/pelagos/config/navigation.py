"""Source of a mission's navigation: the truth, an estimator's solution, or somebody outside."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from pelagos.config.strict import Strict


class TruthNavigation(Strict):
    """The true motion, without error."""

    type: Literal["truth"] = "truth"
    """The kind of navigation."""


class ExternalNavigation(Strict):
    """A solution that a program outside gives (`Simulation.navigate`); the start until the first one."""

    type: Literal["external"] = "external"
    """The kind of navigation."""


class EkfNavigation(Strict):
    """An error-state extended Kalman filter of the sensors aboard; its figures are those of their configurations.

    It needs an `imu`; it uses every `dvl`, `depth`, `gps`, `magnetometer` and `lbl` that the agent carries, and a
    `usbl` for the `beacons` whose places are known.
    """

    type: Literal["ekf"] = "ekf"
    """The kind of navigation."""
    start_position_std_m: float = Field(default=0.5, ge=0)
    """Standard deviation of the known start position, in each axis [m]."""
    start_velocity_std_mps: float = Field(default=0.05, ge=0)
    """Standard deviation of the known start velocity, in each axis [m/s]."""
    start_level_std_deg: float = Field(default=0.2, ge=0)
    """Standard deviation of roll and pitch at the start [deg]."""
    start_heading_std_deg: float = Field(default=1.0, ge=0)
    """Standard deviation of the heading at the start [deg]."""
    surface_std_m: float = Field(default=0.02, ge=0)
    """Standard deviation of what waves and tide add to measured depths [m]."""
    range_std_m: float = Field(default=0.2, gt=0)
    """Standard deviation of ranges by sound beside the turn-around's: bent rays, the speed of sound [m]."""
    beacons: dict[str, tuple[float, float, float]] = Field(default_factory=dict)
    """Known places of modems that answer the `usbl` aboard, world NWU [m], by "agent.modem" or by an agent with one."""
    bearing_std_deg: float = Field(default=1.0, gt=0)
    """Standard deviation of a `usbl`'s bearing across the way to a beacon, in each of both directions [deg]."""
    gate: float = Field(default=25.0, gt=0)
    """Measurements are refused whose normalised innovation squared is beyond this many times its dimension."""


def _named(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


Navigation = Annotated[
    Annotated[TruthNavigation | ExternalNavigation | EkfNavigation, Field(discriminator="type")],
    BeforeValidator(_named),
]
