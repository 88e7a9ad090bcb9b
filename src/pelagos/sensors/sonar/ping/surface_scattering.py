"""Backscatter of surfaces, as a table by material and grazing angle that is made once for a sonar's frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.complex_pair import Pair
from pelagos.acoustics.reflection import fluid_reflection
from pelagos.acoustics.sea_surface import bubble_loss_db, surface_backscatter
from pelagos.acoustics.seabed import FREQUENCY_RANGE_HZ, Bottom, backscatter
from pelagos.acoustics.speckle import patchiness
from pelagos.acoustics.spreading import from_db
from pelagos.acoustics.target_strength import corner, corner_lobe, facets, lambert
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.raycast.rays import Hits

if TYPE_CHECKING:
    from pelagos.world.material import Material

_ANGLES: Final = 181  # columns of the scattering table: half a degree each
_SOLID_SLOPE: Final = 0.12  # rms slope of facets of man-made and encrusted surfaces; assumed
TEXTURE_DB: Final = 1.5  # [dB], rms variation of real sea beds over decimetres to metres; assumed
_FIELD_RMS: Final = 0.3  # of `patchiness`
_PATCH_SCALE: Final = 1.6  # [m]


@jit.struct
class Surfaces:
    """Scattering of all surfaces at one frequency: a Dr.Jit struct.

    Attributes:
        section: `Float` `(materials + 1) x 181`, see `scattering_table`.
        sea_row: `UInt32` (1), row of the sea surface.
        mirror: `Float` of the same shape, see `mirror_table`.
        texture: `Float` (materials + 1), rms variation of cross sections from place to place [dB].
    """

    section: Array
    mirror: Array
    sea_row: Array
    texture: Array


def surfaces(
    materials: Sequence[Material], frequency_hz: float, *, wind_speed: float, texture_db: float = TEXTURE_DB
) -> Surfaces:
    """`scattering_table` on the device."""
    table = scattering_table(materials, frequency_hz, wind_speed=wind_speed)
    mirror = mirror_table(materials, frequency_hz, wind_speed=wind_speed)
    rows = jit.UInt32(len(table) - 1)
    varies = np.array([0.0 if m.corner_m > 0.0 else texture_db for m in materials] + [texture_db], dtype=np.float32)
    made = Surfaces(jit.Float(table.ravel()), jit.Float(mirror.ravel()), rows, jit.Float(varies))
    jit.align(made)
    return made


def scattering_table(materials: Sequence[Material], frequency_hz: float, *, wind_speed: float) -> NDArray[np.float32]:
    """Cross section per unit area [1] by material and grazing angle, `(materials + 1, 181)`, 0 to 90 deg.

    Sediments follow TR 9407, evaluated at the nearer end of its 10-100 kHz where the sonar works outside of it; solids
    are Lambert scatterers with specular facets; the inside of a corner reflector answers by the angle from its axis,
    for which its interpolated normal stands; the last row is the sea surface (`surface_backscatter`).
    """
    return _scattering_table(tuple(materials), frequency_hz, wind_speed)


@lru_cache(maxsize=64)  # of every sonar at a frequency, and again after a reset
def _scattering_table(materials: tuple[Material, ...], frequency_hz: float, wind_speed: float) -> NDArray[np.float32]:
    valid_hz = min(max(frequency_hz, FREQUENCY_RANGE_HZ[0]), FREQUENCY_RANGE_HZ[1])
    table = np.zeros((len(materials) + 1, _ANGLES), dtype=np.float32)
    kinds = np.array(["corner" if m.corner_m > 0.0 else "sediment" if m.sediment else "solid" for m in materials])
    for kind in set(kinds):
        rows = np.flatnonzero(kinds == kind)
        some = [m for m, its in zip(materials, kinds, strict=True) if its == kind]
        if kind == "sediment":
            table[rows] = _sediments(some, valid_hz)
        else:
            table[rows] = _solids(some) if kind == "solid" else _corners(some, frequency_hz)
    table[-1] = surface_backscatter(_angles(1), valid_hz, wind_speed).numpy()
    table.flags.writeable = False
    return table


def _sediments(materials: Sequence[Material], frequency_hz: float) -> NDArray[np.float64]:
    parameters = ("density_ratio", "sound_speed_ratio", "loss", "volume_scatter", "spectral_strength")
    bottom = Bottom(*(_by_row(materials, name) for name in parameters))
    return _table(backscatter(_angles(len(materials)), frequency_hz, bottom))


def _solids(materials: Sequence[Material]) -> NDArray[np.float64]:
    sine = dr.sin(_angles(len(materials)))
    real, imaginary = _reflection(sine * 0.0 + 1.0, materials)
    mirror = real**2 + imaginary**2
    return _table(lambert(sine, _by_row(materials, "lambert_db")) + facets(sine, mirror, _SOLID_SLOPE))


def _corners(materials: Sequence[Material], frequency_hz: float) -> NDArray[np.float64]:
    lobes = []
    for m in materials:
        inside = 1.5 * m.corner_m**2  # all of which is seen from wherever the corner answers
        strength = corner(m.corner_m, NOMINAL_SOUND_SPEED / frequency_hz)
        lobes.append(_corner_lobe() * (10.0 ** (strength / 10.0) / inside))
    diffuse = lambert(dr.sin(_angles(len(materials))), _by_row(materials, "lambert_db"))
    return np.array(lobes) + _table(diffuse)


@cache
def _corner_lobe() -> NDArray[np.float64]:
    return corner_lobe(0.5 * math.pi - np.linspace(0.0, math.pi / 2, _ANGLES))


def _reflection(sine: Array, materials: Sequence[Material]) -> Pair:
    contrast = (_by_row(materials, name) for name in ("density_ratio", "sound_speed_ratio", "loss"))
    return fluid_reflection(sine, *contrast)


def _angles(rows: int) -> Array:
    """Grazing angles [rad] of the columns, for each of some rows."""
    return jit.from_numpy(jit.Float64, np.tile(np.linspace(0.0, math.pi / 2, _ANGLES), rows))


def _by_row(materials: Sequence[Material], name: str) -> Array:
    """A parameter of each material, for all columns: an array, so that one kernel serves all materials."""
    return jit.from_numpy(jit.Float64, np.repeat([float(getattr(m, name)) for m in materials], _ANGLES))


def _table(values: Array) -> NDArray[np.float64]:
    table: NDArray[np.float64] = values.numpy().reshape(-1, _ANGLES)
    return table


def mirror_table(materials: Sequence[Material], frequency_hz: float, *, wind_speed: float) -> NDArray[np.float32]:
    """Part of a wave's energy that a smooth surface reflects [1], of the shape of `scattering_table`.

    Materials by their contrast to the water (`fluid_reflection`); the sea surface all but what bubbles take
    (`bubble_loss_db`, evaluated at the nearer end of 10-100 kHz).
    """
    return _mirror_table(tuple(materials), frequency_hz, wind_speed)


@lru_cache(maxsize=64)
def _mirror_table(materials: tuple[Material, ...], frequency_hz: float, wind_speed: float) -> NDArray[np.float32]:
    valid_hz = min(max(frequency_hz, FREQUENCY_RANGE_HZ[0]), FREQUENCY_RANGE_HZ[1])
    table = np.zeros((len(materials) + 1, _ANGLES), dtype=np.float32)
    if materials:
        real, imaginary = _reflection(dr.sin(_angles(len(materials))), materials)
        table[:-1] = _table(real**2 + imaginary**2)
    table[-1] = from_db(-bubble_loss_db(dr.sin(_angles(1)), valid_hz, wind_speed)).numpy()
    table.flags.writeable = False
    return table


def scattering(surfaces: Surfaces, row: Array, sine: Array) -> Array:
    """Cross section per unit area [1] of `row` at a grazing angle, by linear interpolation in the angle."""
    return _by_angle(surfaces.section, row, sine)


def mirror_share(surfaces: Surfaces, row: Array, sine: Array) -> Array:
    """Part of the energy [1] that a smooth surface of `row` reflects at a grazing angle, likewise."""
    return _by_angle(surfaces.mirror, row, sine)


def _by_angle(table: Array, row: Array, sine: Array) -> Array:
    place = dr.asin(dr.clip(sine, 0.0, 1.0)) * ((_ANGLES - 1) / (math.pi / 2))
    column = dr.minimum(jit.UInt32(place), _ANGLES - 2)
    index = row * _ANGLES + column
    low = dr.gather(jit.Float, table, index)
    return dr.lerp(low, dr.gather(jit.Float, table, index + 1), place - jit.Float(column))


def patch_factor(hits: Hits, surfaces: Surfaces) -> Array:
    """Factor on the cross section: surfaces vary over decimetres to metres, all but corner reflectors."""
    x, y, z = (jit.Float(p) for p in hits.position)
    field = patchiness(x + 0.7 * z, y - 0.7 * z, seed=hits.instance, scale=_PATCH_SCALE)
    return from_db(dr.gather(jit.Float, surfaces.texture, hits.material) * (1.0 / _FIELD_RMS) * field)
