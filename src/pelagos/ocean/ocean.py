"""The ocean: what moves, weighs, sounds and colours, at any place and time.

`Ocean` is a Dr.Jit struct. It is handed to frozen functions as an argument; what it is made of does not change in a
run. Positions are world NWU [m] (z up, 0 at the mean surface), times seconds of simulation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.current import Current, total
from pelagos.ocean.water_column import WaterColumn
from pelagos.ocean.waves import Waves
from pelagos.optics.water import WaterOptics, water_optics


@dataclass
class Ocean:
    """Currents, waves, water masses and light.

    Attributes:
        currents: components, summed.
        column: temperature, salinity, density, sound speed, pressure against depth.
        waves: the components of the sea; None for a flat surface.
        sun_elevation, sun_azimuth: `Float` (1), above the horizon and of the compass [rad].
        wind: `Array3f64` (1), velocity of the air over ground, NWU [m/s].
        water_type: Jerlov type.
        turbidity: factor on the particles of that type.
    """

    currents: list[Current]
    column: WaterColumn
    waves: Waves | None
    sun_elevation: Array
    sun_azimuth: Array
    wind: Array
    water_type: str
    turbidity: float

    def current(self, position: Array, t: Array) -> Array:
        """Velocity of the water, without the waves' orbital motion, `Array3f64` NWU [m/s]."""
        return total(self.currents, position, t)

    def temperature(self, position: Array, t: Array) -> Array:
        """In situ [degC]."""
        return self.column.at(self.column.temperature, -position[2])

    def salinity(self, position: Array, t: Array) -> Array:
        """Practical salinity [1]."""
        return self.column.at(self.column.salinity, -position[2])

    def density(self, position: Array, t: Array) -> Array:
        """Of the water [kg/m^3]; the surface's above it."""
        return self.column.at(self.column.density, -position[2])

    def sound_speed(self, position: Array, t: Array) -> Array:
        """In the water [m/s]; the surface's above it."""
        return self.column.at(self.column.sound_speed, -position[2])

    def elevation(self, x: Array, y: Array, t: Array) -> Array:
        """Height of the surface over the mean [m], `Float64`, at world x, y [m]."""
        if self.waves is None:
            return jit.Float64(0.0)
        return self.waves.elevation(x, y, t)

    def pressure(self, position: Array, t: Array) -> Array:
        """Of the water above [Pa], without the atmosphere's; 0 in the air."""
        surface = self.elevation(position[0], position[1], t)
        return self.column.at(self.column.pressure, dr.maximum(surface - position[2], 0.0))

    @property
    def water(self) -> WaterOptics:
        """Optical properties for the cameras' channels, plain numbers."""
        return _optics(self.water_type, self.turbidity)

    @property
    def sun_direction(self) -> Array:
        """Unit vector from the water towards the sun, `Array3f` NWU."""
        s, c = dr.sincos(self.sun_elevation)
        sa, ca = dr.sincos(self.sun_azimuth)
        return jit.Array3f(c * ca, -c * sa, s)


@cache
def _optics(water_type: str, turbidity: float) -> WaterOptics:
    return water_optics(water_type, turbidity=turbidity)
