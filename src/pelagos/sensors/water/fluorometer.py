"""Fluorometer: chlorophyll by its fluorescence."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig, tracer_of


class FluorometerConfig(ProbeConfig):
    """A chlorophyll fluorometer; figures where not given: WET Labs (Sea-Bird) ECO FLNTU, sensitivity 0.025 ug/l,
    range 50 ug/l.
    """

    type: Literal["fluorometer"] = "fluorometer"
    """The sensor's kind."""
    noise_density: float = Field(default=0.01, ge=0)
    """White noise [mg/m^3/sqrt(Hz)]."""
    resolution: float = Field(default=0.0125, ge=0)
    """Step of the digital output [mg/m^3]; 0 for none."""
    lowest: float | None = 0.0
    """Smallest reading [mg/m^3]."""
    highest: float | None = 50.0
    """Largest reading [mg/m^3]."""


class Fluorometer:
    """Chlorophyll concentration: the tracer `chlorophyll` of the ocean.

    Reading: `data` `(n,)` [mg/m^3]; none in the air.
    """

    Config: ClassVar[type[SensorConfig]] = FluorometerConfig
    TITLE: ClassVar[str] = "Fluorometer: chlorophyll concentration"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ("Sea-Bird Scientific, ECO FLNTU data sheet: default figures",)

    def __init__(self, config: FluorometerConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, tracer_of(context, "chlorophyll"))

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)
