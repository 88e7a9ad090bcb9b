"""Common parts of instruments that sample the water: errors of a reading, and none in the air."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import ClassVar, TypeAlias

import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.errors import LookupFailed
from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import digitise
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

Sample: TypeAlias = Callable[[Ocean, Kinematics, Array, Array], Sequence[Array]]
"""(ocean, motion, position of the mount, time) -> what is there, `Float64` each."""


class ProbeConfig(SensorConfig):
    """Errors of an instrument that samples the water; each in the unit of its reading."""

    STANDS: ClassVar[str] = "keel"
    rate_hz: Rate = 1.0
    """Samples per second [Hz]; must divide the tick rate."""
    noise_density: float = Field(default=0.0, ge=0)
    """White noise [unit/sqrt(Hz)]."""
    bias_std: float = Field(default=0.0, ge=0)
    """Standard deviation of the constant offset, drawn once a run."""
    drift_std: float = Field(default=0.0, ge=0)
    """Standard deviation of a slow drift."""
    drift_time_s: float = Field(default=3600.0, gt=0)
    """Correlation time of the drift [s]."""
    resolution: float = Field(default=0.0, ge=0)
    """Step of the digital output; 0 for none."""
    lowest: float | None = None
    """Smallest reading; null for no limit."""
    highest: float | None = None
    """Largest reading; null for no limit."""


class Probe:
    """Samples `count` quantities at the mount and adds the errors of `config` to each; nothing is read in the air."""

    def __init__(self, config: ProbeConfig, context: SensorContext, sample: Sample, *, count: int = 1) -> None:
        self._config = config
        self._ocean = context.ocean
        self._sample = sample
        self._count = count
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Data and truth `(m,)`, or `(m, count)`; not a number where the mount is in the air."""
        found = self._program(motion, self._ocean, self._key)
        valid = found["wet"]
        data, truth = (np.where(valid[:, None], found[name], np.nan) for name in ("data", "truth"))
        if self._count == 1:
            data, truth = data[:, 0], truth[:, 0]
        return Measurement(data=data, truth=truth, valid=valid)

    def _kernel(self, motion: Kinematics, ocean: Ocean, key: noise.Key) -> Results:
        c = self._config
        position, _ = sensor_pose(motion, c)
        t = jit.Float64(motion.t_ns) * 1e-9
        truth = [jit.Float64(v) + 0 * position[2] for v in self._sample(ocean, motion, position, t)]
        white = noise.normals64(key, motion, self._count)
        offset = noise.constants64(key, motion, self._count)
        data = [v + w * (c.noise_density * math.sqrt(c.rate_hz)) + o * c.bias_std for v, w, o in
                zip(truth, white, offset, strict=True)]  # fmt: skip
        if c.drift_std > 0:
            drift = noise.gauss_markov(key, motion, self._count, correlation_time=c.drift_time_s)
            data = [d + s * c.drift_std for d, s in zip(data, drift, strict=True)]
        lowest = -math.inf if c.lowest is None else c.lowest
        highest = math.inf if c.highest is None else c.highest
        data = [digitise(d, resolution=c.resolution, lowest=lowest, highest=highest) for d in data]
        wet = position[2] < ocean.elevation(position[0], position[1], t, motion.copy)
        return {"data": data, "truth": truth, "wet": wet}


def tracer_of(context: SensorContext, name: str) -> Sample:
    """Samples a tracer of the ocean.

    Raises:
        LookupFailed: the scenario's ocean has no such tracer.
    """
    if name not in context.ocean.tracers:
        where = f"{context.path} measures {name!r}, which the ocean's 'tracers' must hold"
        raise LookupFailed("tracer", name, context.ocean.tracers, where=where)
    return lambda ocean, motion, position, t: [ocean.tracer(name, position, t)]
