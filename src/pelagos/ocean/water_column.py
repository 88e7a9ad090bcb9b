"""Temperature, salinity, density, sound speed and pressure against depth, after TEOS-10.

The host tabulates everything once with `gsw` on a grid of `STEP_M`; the device interpolates. Source: IOC, SCOR and
IAPSO, The international thermodynamic equation of seawater - 2010, Manuals and Guides 56; sound speed and density
from the 75-term polynomial of Roquet et al., Ocean Modelling 90:29 (2015), doi 10.1016/j.ocemod.2015.04.002.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.math.lookup import locate, sample
from pelagos.ocean.site import Site

STEP_M: Final = 0.5
DEEPEST_M: Final = 11_000.0


class ProfileConfig(Strict):
    """A quantity against depth: a table, linear between its rows, held beyond them."""

    depth_m: tuple[float, ...] = Field(min_length=2)
    """Depths of the rows, increasing, 0 at the surface [m]."""
    value: tuple[float, ...] = Field(min_length=2)
    """The quantity in each row."""

    @model_validator(mode="after")
    def _rows(self) -> Self:
        if len(self.depth_m) != len(self.value):
            raise ValueError(f"depth_m has {len(self.depth_m)} rows, value {len(self.value)}; they must be as many")
        if any(b <= a for a, b in zip(self.depth_m, self.depth_m[1:], strict=False)):
            raise ValueError(f"depth_m must increase from row to row, not {self.depth_m}")
        return self


@jit.struct
class WaterColumn:
    """Tables against depth, one entry every `STEP_M` from the surface down: a Dr.Jit struct of `Float64`.

    Attributes:
        temperatures: in situ [degC].
        salinities: practical salinity [1].
        densities: [kg/m^3].
        sound_speeds: [m/s].
        pressures: of the water above [Pa]; without the atmosphere's.
    """

    temperatures: Array
    salinities: Array
    densities: Array
    sound_speeds: Array
    pressures: Array

    def temperature(self, position: Array, t: Array) -> Array:
        """In situ [degC] at `position`, `Array3f64` NWU [m]; above the water the surface's."""
        return sample(self.temperatures, -position[2] * (1 / STEP_M))

    def salinity(self, position: Array, t: Array) -> Array:
        """Practical salinity [1]."""
        return sample(self.salinities, -position[2] * (1 / STEP_M))

    def density(self, position: Array, t: Array) -> Array:
        """[kg/m^3]."""
        return sample(self.densities, -position[2] * (1 / STEP_M))

    def sound_speed(self, position: Array, t: Array) -> Array:
        """[m/s]."""
        return sample(self.sound_speeds, -position[2] * (1 / STEP_M))

    def pressure(self, depth: Array) -> Array:
        """Of the water above [Pa] at `depth` [m]; 0 in the air."""
        return sample(self.pressures, depth * (1 / STEP_M))

    def depth_of(self, pressure: Array) -> Array:
        """Inverse of `pressure` [m]."""
        row, fraction = locate(self.pressures, pressure)
        return (jit.Float64(row) + fraction) * STEP_M


@dataclass(frozen=True)
class Profiles:
    """The same tables on the host, `(rows,)` each, with their depth [m]; units as in `WaterColumn`."""

    depth: NDArray[np.float64]
    temperature: NDArray[np.float64]
    salinity: NDArray[np.float64]
    density: NDArray[np.float64]
    sound_speed: NDArray[np.float64]
    pressure: NDArray[np.float64]

    def column(self) -> WaterColumn:
        """On the device."""
        arrays = (self.temperature, self.salinity, self.density, self.sound_speed, self.pressure)
        column = WaterColumn(*(jit.Float64(np.ascontiguousarray(a)) for a in arrays))
        jit.align(column)
        return column


def tabulate(temperature: float | ProfileConfig, salinity: float | ProfileConfig, site: Site) -> Profiles:
    """Tables down to `DEEPEST_M`.

    Args:
        temperature: in situ [degC].
        salinity: practical salinity [1].
        site: place on Earth, for gravity and for the composition of sea salt.
    """
    return _tabulated(temperature, salinity, site.origin.latitude, site.origin.longitude)


@lru_cache(maxsize=8)  # a reset with another seed builds the same water again
def _tabulated(
    temperature: float | ProfileConfig, salinity: float | ProfileConfig, latitude: float, longitude: float
) -> Profiles:
    import gsw

    depth = np.arange(0.0, DEEPEST_M + STEP_M, STEP_M)
    t, sp = _rows(temperature, depth), _rows(salinity, depth)
    dbar = np.asarray(gsw.p_from_z(-depth, latitude))  # within 0.3 % of the water's own; enough for density
    sa = gsw.SA_from_SP(sp, dbar, longitude, latitude)
    ct = gsw.CT_from_t(sa, t, dbar)
    density = np.asarray(gsw.rho(sa, ct, dbar))
    weight = density * np.asarray(gsw.grav(latitude, dbar))
    pressure = np.concatenate([[0.0], np.cumsum(0.5 * (weight[1:] + weight[:-1]) * np.diff(depth))])
    made = Profiles(depth, t, sp, density, np.asarray(gsw.sound_speed(sa, ct, dbar)), pressure)
    for table in vars(made).values():
        table.flags.writeable = False
    return made


def _rows(value: float | ProfileConfig, depth: NDArray[np.float64]) -> NDArray[np.float64]:
    if isinstance(value, ProfileConfig):
        return np.interp(depth, value.depth_m, value.value)
    return np.full_like(depth, value)
