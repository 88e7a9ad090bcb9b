"""Turbidity meter."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig, tracer_of


class TurbidityConfig(ProbeConfig):
    """A turbidity meter; figures where not given: WET Labs (Sea-Bird) ECO FLNTU, sensitivity 0.01 NTU, range 25 NTU."""

    type: Literal["turbidity"] = "turbidity"
    """The sensor's kind."""
    noise_density: float = Field(default=0.005, ge=0)
    """White noise [NTU/sqrt(Hz)]."""
    resolution: float = Field(default=0.0061, ge=0)
    """Step of the digital output [NTU]; 0 for none."""
    lowest: float | None = 0.0
    """Smallest reading [NTU]."""
    highest: float | None = 25.0
    """Largest reading [NTU]."""


class Turbidity:
    """Turbidity: the tracer `turbidity` of the ocean (which does not change what cameras see; that is the water type).

    Reading: `data` `(n,)` [NTU]; none in the air.
    """

    Config: ClassVar[type[SensorConfig]] = TurbidityConfig
    TITLE: ClassVar[str] = "Turbidity meter"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ("Sea-Bird Scientific, ECO FLNTU data sheet: default figures",)

    def __init__(self, config: TurbidityConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, tracer_of(context, "turbidity"))

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)
