"""Daylight in several kinds of water under one sky, for places of which each is in one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.light_field import LightField, light_field
from pelagos.optics.light_tables import LEVELS, ROWS, SIDES, TERMS, UPS, solved
from pelagos.optics.sunlight import Daylight
from pelagos.optics.water import WaterArrays, WaterOptics, several

_LOOKED_UP = {"irradiance": ROWS * 3 * TERMS, "radiance": LEVELS * UPS * SIDES * 4}
_LOOKED_UP |= dict.fromkeys(("calm", "source"), _LOOKED_UP["radiance"])  # numbers of a table of one field
_RATES = ("loss", "fading", "decay")


class LightFields:
    """Fields of `LightField`, each solved when it is first asked for.

    Args:
        waters: the kinds of water.
        light: above all of them.

    Attributes:
        water: their optics, by kind.
    """

    def __init__(self, waters: Sequence[WaterOptics], light: Daylight) -> None:
        self._waters, self._light = waters, light
        self._tables = {name: np.zeros((len(waters), size), dtype=np.float32) for name, size in _LOOKED_UP.items()}
        self._rates = {name: np.ones((len(waters), 3)) for name in _RATES}
        self._solved: set[int] = set()
        self._field: LightField | None = None
        self.water = several(waters)

    def of(self, rows: NDArray[np.integer]) -> LightField:
        """The fields of all kinds, of which those of `rows` are solved; `LightField.row` is for who asks to set."""
        wanted = set(np.unique(rows).tolist()) - self._solved
        if wanted or self._field is None:
            for k in wanted:
                found = solved(self._waters[k], self._light)
                for name, table in self._tables.items():
                    table[k] = getattr(found, name).ravel()
                for name, rate in self._rates.items():
                    rate[k] = getattr(found, name)
            self._solved |= wanted
            some = self._waters[min(self._solved)]
            self._field = replace(
                light_field(some, self._light),
                **{name: jit.Float(table.ravel()) for name, table in self._tables.items()},
                **{name: _columns(rate) for name, rate in self._rates.items()},
                blur=jit.Float([0.25 * w.particle_scattering[1] for w in self._waters]),
            )
            jit.align(self._field)
        return self._field


def by_place(water: WaterArrays, field: LightField) -> tuple[WaterArrays, LightField]:
    """The water and the field of each place, of several kinds; what `field.row` says."""
    rates = {name: dr.gather(jit.Array3f, getattr(field, name), field.row) for name in _RATES}
    here = replace(field, **rates, blur=dr.gather(jit.Float, field.blur, field.row))
    return water.of(field.row), here


def _columns(values: NDArray[np.float64]) -> Array:
    """`(k, 3)` as `Array3f`."""
    array = jit.Array3f(np.ascontiguousarray(values.T, dtype=np.float32))
    jit.align(array)
    return array
