"""Compartments that flood through a hole, and are pumped empty: leaks, free-flooding bays, ballast tanks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal, Self

import drjit as dr
from pydantic import Field, model_validator

from pelagos.errors import CommandError
from pelagos.hydro.algebra import Vector, add, dot, total
from pelagos.hydro.flooding import ATMOSPHERE_PA, boyle_head, boyle_limit, through_orifice
from pelagos.hydro.liquid import box_liquid_center, box_liquid_level
from pelagos.jit import Array
from pelagos.vehicles.cargo import Cargo
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive, Three
from pelagos.vehicles.wetness import ALWAYS, Place

_INSIDE: Final = 1e-9  # of a side: rounding


class CompartmentConfig(PartConfig):
    """A box that floods through a hole by Torricelli's law. State: water in it [m^3]. Command: water that the pump
    leaves in it [m^3], which begins as 0, so that a pump, where there is one, empties it; with a `valve` it floods up
    to the command, and not beyond. Without pump and valve the command has nothing to move.

    The liquid lies level: its centre moves with heel and trim (free-surface effect), and with it the centre of gravity,
    the mass matrix and the Coriolis forces. Water that enters was at rest in the water outside, and takes its share of
    the vehicle's momentum; water that leaves takes its own along. The jet's thrust is left out, and so is sloshing:
    about its own centre it turns as the level layer does that it is while the vehicle is upright.
    The hull keeps its displaced volume and its added mass.
    """

    type: Literal["compartment"]
    size_m: tuple[Positive, Positive, Positive]
    """Length, breadth and height of the box [m]."""
    position_m: Three
    """Its middle, FRD from the origin [m]."""
    permeability: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Share of the box that water can fill: the rest is equipment, spread evenly [-]."""
    hole_m: Three
    """Hole in the box, FRD from the origin [m]."""
    orifice_m2: Positive
    """Area of the hole [m^2]."""
    discharge_coefficient: Annotated[float, Field(gt=0, le=1)] = 0.6
    """Of the hole [-]; 0.6 for a sharp edge."""
    valve: bool = False
    """The hole is a valve, open while the command is above the water in the compartment; otherwise always open."""
    opens_after_s: NonNegative = 0.0
    """The hole is there from so long after the start of the episode on [s]."""
    vent_m: Three | None = None
    """Vent in the box, FRD from the origin, through which the air goes in and out [m]; left out: it is shut in, and
    compressed by Boyle's law from the atmosphere's pressure when the compartment is empty."""
    pump_m3_s: NonNegative = 0.0
    """Rate at which a pump empties it, at any depth [m^3/s]."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, point in (("hole_m", self.hole_m), ("vent_m", self.vent_m)):
            for axis, size, middle, at in zip("xyz", self.size_m, self.position_m, point or (), strict=False):
                if abs(at - middle) > size * (0.5 + _INSIDE):
                    raise ValueError(
                        f"{key}: {at:g} m along {axis} lies outside the compartment, which reaches from "
                        f"{middle - size / 2:g} to {middle + size / 2:g} m"
                    )
        return self

    def build(self, body: Body) -> Compartment:
        """The actuator."""
        x, y, z = self.size_m
        law = Flooding(
            half_sides=[x / 2, y / 2, z / 2],
            high=x * y * z * self.permeability,
            hole=[a - b for a, b in zip(self.hole_m, self.position_m, strict=True)],
            area=self.orifice_m2 * self.discharge_coefficient,
            valve=self.valve,
            opens_s=self.opens_after_s,
            pump=self.pump_m3_s,
            atmosphere=ATMOSPHERE_PA / (body.density * body.gravity),
            gravity=body.gravity,
        )
        vent = None if self.vent_m is None else list(self.vent_m)
        return Compartment(body.density, body.gravity, list(self.position_m), list(self.hole_m), vent, law)


@dataclass(frozen=True)
class Around:
    """Water around a compartment: depth of its hole, and of its vent (None: the air is shut in) [m]; down: the
    direction of gravity, body axes (3).
    """

    hole: Array
    vent: Array | None
    down: Vector


@dataclass(frozen=True)
class Flooding:
    """Law of the water in a compartment; all volumes [m^3].

    Attributes:
        half_sides: of the box (3) [m].
        high: water that fills it.
        hole: from the middle of the box (3) [m].
        area: of the hole, times its coefficient of discharge [m^2].
        valve: see the configuration.
        opens_s: time at which the hole is there [s]; after 0, the time is kept beside the state.
        pump: rate of emptying [m^3/s].
        atmosphere: its pressure as a head of water [m].
        gravity: [m/s^2].
        around: the water outside; None where it is not known.
    """

    half_sides: Vector
    high: float
    hole: Vector
    area: float
    valve: bool
    opens_s: float
    pump: float
    atmosphere: float
    gravity: float
    around: Around | None = None
    low: float = 0.0
    time_constant: float = 0.0

    @property
    def memory(self) -> int:
        """See `Follower`."""
        return 1 if self.opens_s > 0 else 0

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        return dr.clip(state, 0.0, self.high)

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """Time derivatives: those at this moment, of a step too short for anything to end in it."""
        state = self.limited(state)
        head, _ = self._head(state)
        flow = self._open(state, kept, command) * through_orifice(head, 0.0, self.area, 1.0, self.gravity)
        pumped = dr.select(state > self.limited(command), self.pump, 0.0)
        return [flow - pumped, *(0 * k + 1.0 for k in kept)]

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """Water after h [s] of a constant command: through the hole, and then through the pump."""
        state, wanted = self.limited(state), self.limited(command)
        head, slope = self._head(state)
        flow = self._open(state, kept, command) * through_orifice(head, slope, self.area, h, self.gravity)
        most: Array = self.high
        if self.around is not None and self.around.vent is None:
            most = dr.maximum(boyle_limit(dr.maximum(self.around.hole, 0.0), self.high, self.atmosphere), state)
        if self.valve:
            most = dr.minimum(most, dr.maximum(wanted, state))
        water = dr.clip(state + flow, 0.0, most)
        pumped = dr.maximum(water - self.pump * h, dr.minimum(water, wanted))
        return [pumped, *(k + h for k in kept)]

    def _open(self, state: Array, kept: list[Array], command: Array) -> Array:
        """1 where the hole is open, 0 where it is not."""
        is_open: Array = 1.0
        if self.valve:
            is_open = dr.select(self.limited(command) > state, is_open, 0.0)
        return dr.select(kept[0] >= self.opens_s, is_open, 0.0) if kept else is_open

    def _head(self, state: Array) -> tuple[Array, Array]:
        """Head that drives water in [m], 0 where none can flow, and its fall by volume [1/m^2]."""
        if self.around is None:
            raise CommandError("how a compartment floods depends on its depth, which is not known here")
        level, rise = box_liquid_level(state / self.high, self.half_sides, self.around.down)
        cover = total(dot(self.hole, self.around.down), -level)  # of the hole by the water inside
        inside = dr.maximum(cover, 0.0)
        outside = dr.maximum(self.around.hole, 0.0)
        slope = dr.select(cover > 0, rise / self.high, 0.0)
        if self.around.vent is None:
            air, stiffer = boyle_head(state, self.high, self.atmosphere)
            slope = slope + stiffer
        else:
            air = dr.maximum(self.around.vent, 0.0)
        head = outside - air - inside
        flows = dr.select(head > 0, self.around.hole > 0, (cover > 0) & (state > 0))
        return dr.select(flows, head, 0.0), slope


@dataclass(frozen=True)
class Compartment:
    """density: of the water [kg/m^3]; gravity [m/s^2]; center, hole, vent: from the origin (3) [m]; see the
    configuration.
    """

    density: Array
    gravity: float
    center: Vector
    hole: Vector
    vent: Vector | None
    lag: Flooding
    unit: str = "m^3"
    site: Place = ALWAYS

    def cargo(self, state: Array, flow: Flow) -> Cargo:
        """The water aboard, frozen: with the inertia that it has while the vehicle is upright."""
        return self._water(state, state / self.lag.high, flow)

    def taken(self, now: Array, after: Array, flow: Flow) -> Cargo:
        """See `Carrier`: it enters, and comes to rest, where the water is."""
        now, after = self.lag.limited(now), self.lag.limited(after)
        return self._water(dr.maximum(after - now, 0.0), now / self.lag.high, flow)

    def follower(self, flow: Flow) -> Flooding:
        """See `Carrier`."""
        depths = [
            None if point is None else total(flow.immersion, dot(point, flow.down)) for point in (self.hole, self.vent)
        ]
        return replace(self.lag, around=Around(depths[0], depths[1], flow.down))

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Weight of the water aboard (6)."""
        return self.cargo(state, flow).wrench(self.gravity, flow)

    def _water(self, volume: Array, fill: Array, flow: Flow) -> Cargo:
        moved = box_liquid_center(fill, self.lag.half_sides, flow.down)
        mass = self.density * volume
        a, b, c = (side * side / 3 for side in self.lag.half_sides)
        c = c * fill * fill
        sums = (b + c, a + c, a + b)
        inertia = [[mass * sums[i] if i == j else 0.0 for j in range(3)] for i in range(3)]
        return Cargo(mass, 0.0, add(self.center, moved), inertia)
