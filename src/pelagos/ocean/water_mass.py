"""Water whose temperature or salinity varies in place and time, after TEOS-10.

Density and sound speed are tabulated once with `gsw` over salinity, temperature and depth; the device interpolates
linearly in all three: within 0.002 kg/m^3 and 0.02 m/s of TEOS-10 from 0 to 40 degC. Pressure is that of the column
at the world's origin at t = 0; water elsewhere changes it by less than 0.1 %.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.site import Site
from pelagos.ocean.tracer import FieldConfig, FieldsConfig, ScalarField, components_of, total
from pelagos.ocean.water_column import DEEPEST_M, ProfileConfig, WaterColumn, tabulate

_SALINITY: Final = np.linspace(0.0, 42.0, 43)
_TEMPERATURE: Final = np.linspace(-3.0, 45.0, 97)
_DEPTH: Final = np.linspace(0.0, DEEPEST_M, 56)


@jit.struct
class WaterMass:
    """Fields, and tables over (salinity, temperature, depth): a Dr.Jit struct; the same methods as `WaterColumn`.

    Attributes:
        temperatures, salinities: components, summed; in situ [degC], practical.
        densities, sound_speeds: `Float64` [kg/m^3], [m/s].
        reference: the column at the origin, for pressure.
    """

    temperatures: list[ScalarField]
    salinities: list[ScalarField]
    densities: Array
    sound_speeds: Array
    reference: WaterColumn

    def temperature(self, position: Array, t: Array) -> Array:
        """In situ [degC]."""
        return total(self.temperatures, position, t)

    def salinity(self, position: Array, t: Array) -> Array:
        """Practical salinity [1]."""
        return dr.maximum(total(self.salinities, position, t), 0.0)

    def density(self, position: Array, t: Array) -> Array:
        """[kg/m^3]; the surface's above it."""
        return self._look_up([self.densities], position, t)[0]

    def sound_speed(self, position: Array, t: Array) -> Array:
        """[m/s]; the surface's above it."""
        return self._look_up([self.sound_speeds], position, t)[0]

    def pressure(self, depth: Array) -> Array:
        """Of the water above [Pa] at `depth` [m]."""
        return self.reference.pressure(depth)

    def depth_of(self, pressure: Array) -> Array:
        """Inverse of `pressure` [m]."""
        return self.reference.depth_of(pressure)

    def _look_up(self, tables: list[Array], position: Array, t: Array) -> list[Array]:
        values = (self.salinity(position, t), self.temperature(position, t), -position[2])
        corners: list[tuple[Array, Array]] = [(jit.UInt32(0), jit.Float64(1.0))]
        for value, nodes in zip(values, (_SALINITY, _TEMPERATURE, _DEPTH), strict=True):
            last = len(nodes) - 1
            cell = dr.clip((value - float(nodes[0])) * float(1 / (nodes[1] - nodes[0])), 0.0, float(last))
            i = dr.minimum(jit.UInt32(cell), last - 1)
            fraction = cell - jit.Float64(i)
            corners = [
                (index * len(nodes) + i + step, share * part)
                for index, share in corners
                for step, part in ((0, 1 - fraction), (1, fraction))
            ]
        return [sum(share * dr.gather(jit.Float64, table, index) for index, share in corners) for table in tables]


def make_water(
    temperature: FieldsConfig, salinity: FieldsConfig, site: Site, build: Callable[[FieldConfig], ScalarField]
) -> WaterColumn | WaterMass:
    """The water on the device: a column where nothing but depth matters, else a mass of fields that `build` makes."""
    if not isinstance(temperature, tuple) and not isinstance(salinity, tuple):
        return tabulate(temperature, salinity, site).column()
    temperatures = [build(c) for c in components_of(temperature)]
    salinities = [build(c) for c in components_of(salinity)]
    densities, speeds = _tables(site)
    reference = tabulate(_profile(temperatures, -3, 45), _profile(salinities, 0, 42), site).column()
    mass = WaterMass(temperatures, salinities, jit.Float64(densities), jit.Float64(speeds), reference)
    jit.align(mass.densities, mass.sound_speeds)
    return mass


def _tables(site: Site) -> tuple[np.ndarray, np.ndarray]:
    import gsw

    sp, t, depth = np.meshgrid(_SALINITY, _TEMPERATURE, _DEPTH, indexing="ij")
    latitude = site.origin.latitude
    dbar = gsw.p_from_z(-depth, latitude)
    sa = gsw.SA_from_SP(sp, dbar, site.origin.longitude, latitude)
    ct = gsw.CT_from_t(sa, t, dbar)
    return np.asarray(gsw.rho(sa, ct, dbar)).ravel(), np.asarray(gsw.sound_speed(sa, ct, dbar)).ravel()


def _profile(fields: list[ScalarField], low: float, high: float) -> ProfileConfig:
    """The fields at the origin at t = 0, against depth."""
    depth = np.unique(np.concatenate([np.arange(0.0, 200.0, 2.0), np.geomspace(200.0, DEEPEST_M, 60)]))
    place = jit.Array3f64(dr.zeros(jit.Float64, len(depth)), 0.0, jit.Float64(-depth))
    values = np.broadcast_to(np.array(total(fields, place, jit.Float64(0.0))), depth.shape)
    held = np.clip(np.where(np.isfinite(values), values, np.nanmean(values)), low, high)
    return ProfileConfig(depth_m=tuple(depth.tolist()), value=tuple(held.tolist()))
