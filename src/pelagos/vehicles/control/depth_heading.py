"""Autopilot of torpedo-shaped vehicles: depth, heading, and shaft speed or speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from pelagos.jit import Array
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.depth import DepthGains, DepthMemory, stern_plane
from pelagos.vehicles.control.heading import HeadingGains, HeadingMemory, rudder
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.control.speed import SpeedGains, shaft_speed
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import PartConfig


class DepthHeadingConfig(PartConfig):
    """Set-points: depth [m, down], compass heading [rad], and the propeller's speed [rpm] or, with `speed`, [m/s]."""

    type: Literal["depth_heading"]
    depth: DepthGains
    """The depth loop."""
    heading: HeadingGains
    """The heading loop."""
    vertical: Literal["depth", "altitude"] = "depth"
    """What the first set-point is: depth, or altitude above the seabed, with the measured altitude as a further one."""
    speed: SpeedGains | None = None
    """The speed loop; left out: the third set-point is the shaft speed."""
    rudder: dict[str, float]
    """Actuators that steer, and their share of the rudder's deflection (1 or -1 by their side)."""
    stern_plane: dict[str, float]
    """Actuators that pitch, and their share of the stern plane's deflection; one that steers too, as on an X tail,
    gets both."""
    propeller: str
    """The actuator that drives."""

    def build(self, plant: Plant) -> DepthHeading:
        """The control law."""
        return DepthHeading(self)

    @property
    def uses(self) -> list[str]:
        """Actuators that must exist."""
        return [*self.rudder, *self.stern_plane, self.propeller]


@dataclass(frozen=True)
class DepthHeading:
    """See `DepthHeadingConfig`."""

    config: DepthHeadingConfig

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        third = "rpm" if self.config.speed is None else "speed"
        if self.config.vertical == "depth":
            return ("depth", "heading", third)
        return ("altitude", "heading", third, "measured_altitude")

    @property
    def memory(self) -> int:
        """Three numbers for depth, four for heading, one for speed."""
        return 8

    def start(self, flow: Flow) -> list[Array]:
        """References at the present depth and heading."""
        return [flow.position[2], 0.0, 0.0, 0.0, flow.yaw, 0.0, 0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Plane, rudder and shaft speed."""
        c, nu = self.config, flow.nu
        wanted = command[0]
        if c.vertical == "altitude":
            wanted = flow.position[2] + command[3] - command[0]
        plane, depth = stern_plane(
            c.depth, DepthMemory(*memory[:3]), wanted, flow.position[2], flow.pitch, nu[2], nu[4], h
        )
        steer, heading = rudder(c.heading, HeadingMemory(*memory[3:7]), command[1], flow.yaw, nu[5], h)
        shaft, integral = command[2], memory[7]
        if c.speed is not None:
            shaft, integral = shaft_speed(c.speed, integral, command[2], flow.nu_r[0], h)
        demand: dict[str, Array] = {name: share * steer for name, share in c.rudder.items()}
        for name, share in c.stern_plane.items():
            demand[name] = demand[name] + share * plane if name in demand else share * plane
        demand[c.propeller] = shaft
        kept = [depth.reference, depth.depth_integral, depth.pitch_integral]
        kept += [heading.integral, heading.heading, heading.rate, heading.acceleration, integral]
        return Demand(demand), kept
