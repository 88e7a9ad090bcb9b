"""Oxygen optode."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig, tracer_of


class OxygenConfig(ProbeConfig):
    """An oxygen optode; figures where not given: Aanderaa 4330, accuracy 2 uM or 1.5 %, resolution 0.1 uM."""

    type: Literal["oxygen"] = "oxygen"
    """The sensor's kind."""
    noise_density: float = Field(default=0.2, ge=0)
    """White noise [umol/kg/sqrt(Hz)]."""
    bias_std: float = Field(default=1.0, ge=0)
    """Standard deviation of the constant offset, drawn once a run [umol/kg]."""
    resolution: float = Field(default=0.1, ge=0)
    """Step of the digital output [umol/kg]; 0 for none."""
    lowest: float | None = 0.0
    """Smallest reading [umol/kg]."""
    highest: float | None = 1000.0
    """Largest reading [umol/kg]."""


class Oxygen:
    """Dissolved oxygen: the tracer `oxygen` of the ocean. The optode answers at once; its response time is not
    modelled.

    Reading: `data` `(n,)` [umol/kg]; none in the air.
    """

    Config: ClassVar[type[SensorConfig]] = OxygenConfig
    TITLE: ClassVar[str] = "Oxygen optode: dissolved oxygen"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ("Aanderaa, Oxygen Optode 4330 data sheet D378: default figures",)

    def __init__(self, config: OxygenConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, tracer_of(context, "oxygen"))

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)
