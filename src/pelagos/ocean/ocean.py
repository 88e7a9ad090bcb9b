"""The ocean: what moves, weighs, sounds and colours, at any place and time.

`Ocean` is a Dr.Jit struct. It is handed to frozen functions as an argument; what it is made of does not change in a
run. Positions are world NWU [m] (z up, 0 at the mean surface), times seconds of simulation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from functools import cache, cached_property
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.jit import Array
from pelagos.math.lookup import sample
from pelagos.ocean.current import Current
from pelagos.ocean.current import total as total_current
from pelagos.ocean.gridded import GridField
from pelagos.ocean.slender_waves import SlenderMotion, slender_waves
from pelagos.ocean.tide import Tide
from pelagos.ocean.tracer import ScalarField
from pelagos.ocean.tracer import total as total_field
from pelagos.ocean.water_column import STEP_M, WaterColumn
from pelagos.ocean.water_mass import WaterMass
from pelagos.ocean.waves import WaterMotion, Waves
from pelagos.ocean.wind import Wind
from pelagos.optics.atmosphere import Weather
from pelagos.optics.water import WaterOptics, water_optics


@jit.struct
class Ocean:
    """Currents, waves, water masses and light.

    Attributes:
        currents: components, summed.
        masses: temperature, salinity, density, sound speed, pressure.
        tracers: further scalar fields by name, each a list of components.
        waves: the components of the sea; None for a flat surface.
        tide: of the level; None where it stands still.
        air: the wind.
        sun_elevation, sun_azimuth: `Float` (1), above the horizon and of the compass [rad].
        water_type: Jerlov type.
        turbidity: factor on the particles of that type.
        cloud, visibility, rain: see `Weather`.
        ballast: density that vehicles are ballasted for, by depth as in `WaterColumn` [kg/m^3]; None where the water is
            the same everywhere.
        turbidities: factors on the particles that copies of a fleet may have, each one of them; none: `turbidity`.
        own: `Array3f64`, by copy of a fleet NWU [m/s], the current in place of `currents`; None: that is the same for
            all copies.
        own_waves: the sea of each copy, or of each place in turn, in place of `waves`; None: that is the same for all.
    """

    currents: list[Current]
    masses: WaterColumn | WaterMass
    tracers: dict[str, list[ScalarField]]
    waves: Waves | None
    tide: Tide | None
    air: Wind
    sun_elevation: Array
    sun_azimuth: Array
    water_type: str
    turbidity: float
    cloud: float = 0.0
    visibility: float = math.inf
    rain: float = 0.0
    ballast: Array | None = None
    turbidities: tuple[float, ...] = ()
    own: Array | None = None
    own_waves: Waves | None = None

    @cached_property
    def size_key(self) -> Any:
        """See `jit.struct`."""
        return jit.sizes(self)

    @property
    def weather(self) -> Weather:
        """Clouds, fog and rain."""
        return Weather(self.cloud, self.visibility, self.rain)

    def with_(self, **changes: Any) -> Ocean:
        """The same ocean with other values; sizes of arrays may be others."""
        kept = {f.name: getattr(self, f.name) for f in fields(Ocean)}
        return jit.without_constants(Ocean(**{**kept, **changes}))

    def current(self, position: Array, t: Array, copy: Array | None = None) -> Array:
        """Velocity of the water, without the waves' orbital motion, `Array3f64` NWU [m/s].

        `copy` says which copy of the fleet each position is in; without it they are those of all copies in turn.
        """
        if self.own is not None:
            copies = dr.width(self.own)
            if copy is None and dr.width(position) == copies:
                return jit.Array3f64(self.own)
            row = (
                dr.arange(jit.UInt32, dr.width(position)) if copy is None else copy
            )  # of several vehicles, each by copy
            return dr.gather(jit.Array3f64, self.own, row % copies)
        return total_current(self.currents, position, t)

    def sea(self, places: int, copy: Array | None = None) -> Waves | None:
        """The waves that so many places are in; None where there are none. `copy`: see `current`."""
        if self.own_waves is None:
            return self.waves
        if self.own_waves.changed is not None:
            return self.own_waves
        row = dr.arange(jit.UInt32, places) if copy is None else copy
        return self.own_waves.at(row % self.own_waves.copies)

    def temperature(self, position: Array, t: Array) -> Array:
        """In situ [degC]."""
        return self.masses.temperature(position, t)

    def salinity(self, position: Array, t: Array) -> Array:
        """Practical salinity [1]."""
        return self.masses.salinity(position, t)

    def density(self, position: Array, t: Array) -> Array:
        """Of the water [kg/m^3]; the surface's above it."""
        return self.masses.density(position, t)

    def heaviness(self, position: Array, t: Array) -> Array | None:
        """Density of the water over that which vehicles are ballasted for; None where it is 1 everywhere.

        They are neutral, or as light as they are meant to be, in the water at the surface of the world's origin at
        t = 0, and hulls give way to pressure as that water does: only temperature and salinity make a difference.
        """
        if self.ballast is None:
            return None
        depth = dr.maximum(-position[2], 0.0)
        return self.density(position, t) / sample(self.ballast, depth * (1 / STEP_M))

    def sound_speed(self, position: Array, t: Array) -> Array:
        """In the water [m/s]; the surface's above it."""
        return self.masses.sound_speed(position, t)

    def tracer(self, name: str, position: Array, t: Array) -> Array:
        """A scalar field by name, `Float64` in its own unit.

        Raises:
            LookupFailed: the ocean has no such tracer.
        """
        if name not in self.tracers:
            raise LookupFailed("tracer", name, self.tracers)
        return total_field(self.tracers[name], position, t)

    def elevation(self, x: Array, y: Array, t: Array, copy: Array | None = None) -> Array:
        """Height of the surface over the mean [m], tide and waves, `Float64`, at world x, y [m].

        `copy`: see `current`.
        """
        level = jit.Float64(0.0) if self.tide is None else self.tide.level(t)
        waves = self.sea(dr.width(x), copy)
        return level if waves is None else level + waves.elevation(x, y, t)

    def foam(self, x: Array, y: Array, t: Array, copy: Array | None = None) -> Array:
        """Whiteness of the surface, see `Waves.foam`; 0 without waves."""
        waves = self.sea(dr.width(x), copy)
        return 0 * (x + y + t) if waves is None else waves.foam(x, y, t)

    @property
    def breaks(self) -> bool:
        """Waves break somewhere."""
        waves = self.waves if self.own_waves is None else self.own_waves
        return waves is not None and waves.breaks

    def wave_motion(
        self, position: Array, t: Array, copy: Array | None = None, *, stretch: bool = True
    ) -> WaterMotion | None:
        """Orbital motion of the water under the waves; None where there are none. The tide lifts the waves with it.

        Without `stretch` (see `Waves.motion`) it costs half: enough for a vehicle below the troughs. `copy`: see
        `current`.
        """
        waves = self.sea(dr.width(position), copy)
        if waves is None:
            return None
        level = jit.Float64(0.0) if self.tide is None else self.tide.level(t)
        motion = waves.motion(jit.Array3f64(position[0], position[1], position[2] - level), t, stretch=stretch)
        motion.elevation = motion.elevation + level
        return motion

    def waves_along(
        self, position: tuple[Array, Array, Array], axis: tuple[Array, Array, Array], length: float, t: Array
    ) -> SlenderMotion | None:
        """Orbital motion along a slender body, see `slender_waves`; None where there are no waves."""
        waves = self.sea(dr.width(position[0]))
        if waves is None:
            return None
        level = jit.Float64(0.0) if self.tide is None else self.tide.level(t)
        motion = slender_waves(waves, (position[0], position[1], position[2] - level), axis, length, t)
        motion.elevation = motion.elevation + level
        return motion

    def flow(self, position: Array, t: Array, copy: Array | None = None) -> Array:
        """Velocity of the water, current and orbital motion together, `Array3f64` NWU [m/s]."""
        motion = self.wave_motion(position, t, copy)
        current = self.current(position, t, copy)
        return current if motion is None else current + motion.velocity

    def pressure(self, position: Array, t: Array, copy: Array | None = None) -> Array:
        """Of the water [Pa], without the atmosphere's: its weight and the waves' dynamic pressure; 0 in the air.

        Below the mean surface the weight of the still water and g rho times the waves' head; above it, up to the actual
        surface, the weight of the water above (hydrostatic). `copy`: see `current`.
        """
        depth = -position[2] if self.tide is None else self.tide.level(t) - position[2]
        waves = self.sea(dr.width(position), copy)
        if waves is None:
            return self.masses.pressure(dr.maximum(depth, 0.0))
        surface, head = waves.head(jit.Array3f64(position[0], position[1], -depth), t)
        return self.masses.pressure(dr.maximum(dr.select(depth > 0, depth + head, depth + surface), 0.0))

    def wind(self, position: Array, t: Array) -> Array:
        """Velocity of the air over ground [m/s] at `position`, `Array3f64` NWU."""
        return self.air.velocity(position[2], t)

    @property
    def grids(self) -> list[tuple[str, GridField]]:
        """Fields that come from files, and what they are fields of."""
        parts: list[tuple[str, Sequence[Any]]] = [
            ("current", self.currents),
            ("temperature", getattr(self.masses, "temperatures", [])),
            ("salinity", getattr(self.masses, "salinities", [])),
            *self.tracers.items(),
        ]
        fields = [(name, getattr(part, "field", None)) for name, components in parts for part in components]
        return [(name, grid) for name, grid in fields if isinstance(grid, GridField)]

    def uncovered(self, position: Array, t: Array) -> list[str]:
        """Fields that files must cover everywhere (outside: error) but do not hold at one position and time."""
        return [
            f"the {name} of {grid.source}"
            for name, grid in self.grids
            if grid.outside == "error" and bool(grid.beyond(position, t)[0])
        ]

    @property
    def water(self) -> WaterOptics:
        """Optical properties for the cameras' channels, plain numbers."""
        return _optics(self.water_type, self.turbidity)

    @property
    def waters(self) -> list[WaterOptics]:
        """The same of each of `turbidities`."""
        return [_optics(self.water_type, t) for t in self.turbidities]

    @property
    def sun_direction(self) -> Array:
        """Unit vector from the water towards the sun, `Array3f` NWU."""
        s, c = dr.sincos(self.sun_elevation)
        sa, ca = dr.sincos(self.sun_azimuth)
        return jit.Array3f(c * ca, -c * sa, s)


@cache
def _optics(water_type: str, turbidity: float) -> WaterOptics:
    return water_optics(water_type, turbidity=turbidity)
