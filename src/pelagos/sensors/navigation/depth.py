"""Depth from pressure."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import drjit as dr
import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.math.constants import ATMOSPHERE_PA
from pelagos.math.lookup import sample
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.water_column import DEEPEST_M
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class DepthConfig(SensorConfig):
    """A pressure gauge and what makes a depth of it; figures where not given are those of a quartz-grade gauge.

    Figures: Paroscientific Digiquartz 8000 series, 0.01 % of full scale total accuracy, here of 400 m.
    """

    type: Literal["depth"] = "depth"
    """The sensor's kind."""
    rate_hz: Rate = 50.0
    """Samples per second [Hz]; must divide the tick rate."""
    conversion: Literal["column", "teos10"] = "column"
    """From pressure to depth: by the water column as it is, or by TEOS-10's standard ocean (what most instruments
    do).
    """
    noise_density: float = Field(default=0.001, ge=0)
    """White noise [m/sqrt(Hz)]."""
    bias_std_m: float = Field(default=0.013, ge=0)
    """Standard deviation of the constant offset, drawn once a run [m]."""
    drift_m: float = Field(default=0.005, ge=0)
    """Standard deviation of a slow drift of the offset [m]."""
    drift_time_s: float = Field(default=1800.0, gt=0)
    """Correlation time of the drift [s]."""
    resolution_m: float = Field(default=0.001, ge=0)
    """Step of the digital output [m]; 0 for none."""


class Depth:
    """Depth of the mount below the surface, from the pressure of the water above it, waves included; 0 in the air.

    Reading: `data` `(n,)` depth, downwards positive [m]. Extras: `pressure_pa` `(n,)`, absolute, without noise [Pa].
    """

    Config: ClassVar[type[SensorConfig]] = DepthConfig
    TITLE: ClassVar[str] = "Depth from water pressure (TEOS-10)"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = (
        "IOC, SCOR and IAPSO, The international thermodynamic equation of seawater - 2010, Manuals and Guides 56, "
        "Section 3.32 (height and pressure)",
        "Paroscientific, Digiquartz depth sensors, series 8000 (default figures)",
    )

    def __init__(self, config: DepthConfig, context: SensorContext) -> None:
        self._config = config
        self._ocean = context.ocean
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._standard = _standard_ocean(context.world.origin.latitude) if config.conversion == "teos10" else None
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        found = self._program(motion, self._ocean, self._key, self._standard)
        return Measurement(found["data"], found["truth"], extras={"pressure_pa": found["pressure_pa"]})

    def _kernel(self, motion: Kinematics, ocean: Ocean, key: noise.Key, standard: Array) -> Results:
        c = self._config
        position, _ = sensor_pose(motion, c)
        pressure = ocean.pressure(position, jit.Float64(motion.t_ns) * 1e-9, motion.copy)
        if standard is None:
            depth = ocean.masses.depth_of(pressure)
        else:
            depth = sample(standard, pressure * (1e-4 / _STEP_DBAR))
        (white,) = noise.normals64(key, motion, 1)
        (offset,) = noise.constants64(key, motion, 1)
        (drift,) = noise.gauss_markov(key, motion, 1, correlation_time=c.drift_time_s)
        data = depth + white * (c.noise_density * math.sqrt(c.rate_hz)) + offset * c.bias_std_m + drift * c.drift_m
        if c.resolution_m > 0:
            data = dr.round(data * (1 / c.resolution_m)) * c.resolution_m
        return {"data": data, "truth": depth, "pressure_pa": pressure + ATMOSPHERE_PA}


_STEP_DBAR = 0.5


def _standard_ocean(latitude: float) -> Array:
    """Depth [m] at every `_STEP_DBAR` of sea pressure, for TEOS-10's standard ocean."""
    import gsw

    dbar = np.arange(0.0, 1.05 * DEEPEST_M, _STEP_DBAR)
    table = jit.Float64(np.ascontiguousarray(-np.asarray(gsw.z_from_p(dbar, latitude))))
    jit.align(table)
    return table
