"""The tide's level: harmonic constituents."""

from __future__ import annotations

import math
from typing import Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.analytic_current import TideName, tide_omega


class TideConfig(Strict):
    """One constituent of the tide's level."""

    constituent: TideName | None = None
    """Name of the constituent, which gives the period; or give `period_h`."""
    period_h: float | None = Field(default=None, gt=0)
    """Period [h]; without a constituent."""
    amplitude_m: float = Field(gt=0, le=20)
    """Half of the range [m]."""
    phase_deg: float = 0.0
    """Phase lag: high water is this much of a turn after t = 0 [deg]."""

    @model_validator(mode="after")
    def _period(self) -> Self:
        tide_omega(self.constituent, self.period_h)
        return self


@jit.struct
class Tide:
    """Attributes: amplitude [m], omega [rad/s], phase [rad]: `Float64`, one entry a constituent."""

    amplitude: Array
    omega: Array
    phase: Array

    def level(self, t: Array) -> Array:
        """Height of the mean surface over its long-term mean [m] at time t [s], `Float64`."""
        level = jit.Float64(0.0)
        for i in range(dr.width(self.amplitude)):
            a, w, p = (dr.gather(jit.Float64, v, jit.UInt32(i)) for v in (self.amplitude, self.omega, self.phase))
            level = level + a * dr.cos(w * t - p)
        return level


def make_tide(constituents: tuple[TideConfig, ...], level_m: float | None = None) -> Tide | None:
    """The tide on the device, about a mean level [m]; None without constituents and level."""
    if not constituents and level_m is None:
        return None
    rows = [] if level_m is None else [(level_m, 0.0, 0.0)]
    rows += [(c.amplitude_m, tide_omega(c.constituent, c.period_h), math.radians(c.phase_deg)) for c in constituents]
    tide = Tide(*(jit.Float64(np.ascontiguousarray(column)) for column in np.array(rows, dtype=np.float64).T))
    jit.align(tide)
    return tide
