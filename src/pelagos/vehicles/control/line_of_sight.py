"""Following a straight line between two points, with integral action against currents.

Source: E. Borhaug, A. Pavlov, K. Y. Pettersen, "Integral LOS control for path following of underactuated marine surface
vessels in the presence of constant ocean currents", CDC 2008, doi 10.1109/CDC.2008.4739352; F21 Chapter 12.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import drjit as dr
from pydantic import Field

from pelagos.jit import Array
from pelagos.vehicles.control.controller import Controller, Demand
from pelagos.vehicles.control.depth_heading import DepthHeadingConfig
from pelagos.vehicles.control.heading_thrust import HeadingThrustConfig
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive


class LineOfSightConfig(PartConfig):
    """Set-points: from_x, from_y, to_x, to_y, world NWU [m], then those of the autopilot without its heading."""

    type: Literal["line_of_sight"]
    lookahead_m: Positive
    """[m]"""
    integral_m_s: NonNegative = 0.0
    """Gain of the integral of the cross-track error [m/s]; 0: none."""
    autopilot: Annotated[DepthHeadingConfig | HeadingThrustConfig, Field(discriminator="type")]
    """What steers the heading."""

    def build(self, plant: Plant) -> LineOfSight:
        """The control law."""
        return LineOfSight(self, self.autopilot.build(plant))

    @property
    def uses(self) -> list[str]:
        """Actuators that must exist."""
        return list(getattr(self.autopilot, "uses", ()))


@dataclass(frozen=True)
class LineOfSight:
    """See `LineOfSightConfig`."""

    config: LineOfSightConfig
    autopilot: Controller

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return ("from_x", "from_y", "to_x", "to_y", *(c for c in self.autopilot.commands if c != "heading"))

    @property
    def memory(self) -> int:
        """The autopilot's, and the integral of the cross-track error."""
        return self.autopilot.memory + 1

    def start(self, flow: Flow) -> list[Array]:
        """The autopilot's start."""
        return [*self.autopilot.start(flow), 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The autopilot's demand for the heading that leads onto the line."""
        heading, integral = line_heading(
            self.config.lookahead_m, self.config.integral_m_s, memory[-1], command[:4], flow.position, h
        )
        rest = iter(command[4:])
        setpoint = [heading if name == "heading" else next(rest) for name in self.autopilot.commands]
        demand, kept = self.autopilot.act(memory[:-1], flow, setpoint, h)
        return demand, [*kept, integral]


def line_heading(
    lookahead: Array, gain: Array, integral: Array, line: Sequence[Array], position: Sequence[Array], h: Array
) -> tuple[Array, Array]:
    """Compass heading [rad] that leads onto the line from (x0, y0) to (x1, y1) NWU, and the next integral [m].

    `position`: NED [m]. The cross-track error is positive to starboard of the line.
    """
    x0, y0, x1, y1 = line
    north, east = x1 - x0, -(y1 - y0)
    course = dr.atan2(east, north)
    sin, cos = dr.sincos(course)
    across = -(position[0] - x0) * sin + (position[1] + y0) * cos
    bent = across + gain * integral
    rate = lookahead * across / (bent * bent + lookahead * lookahead)
    return course - dr.atan(bent / lookahead), integral + h * rate
