"""A sensor of any tracer of the ocean."""

from __future__ import annotations

from typing import ClassVar, Literal

from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig, tracer_of


class TracerConfig(ProbeConfig):
    """A sensor of one tracer, without errors unless they are given."""

    type: Literal["tracer"] = "tracer"
    """The sensor's kind."""
    tracer: str
    """Name of the tracer among those of the ocean."""


class Tracer:
    """Any tracer of the ocean, by name.

    Reading: `data` `(n,)` in the tracer's unit; none in the air.
    """

    Config: ClassVar[type[SensorConfig]] = TracerConfig
    TITLE: ClassVar[str] = "Sensor of any tracer of the ocean"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: TracerConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, tracer_of(context, config.tracer))

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)
