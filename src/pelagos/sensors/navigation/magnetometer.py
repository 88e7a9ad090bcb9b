"""Magnetometer: the Earth's field in the sensor frame, bent by the vehicle's own iron."""

from __future__ import annotations

import math
from typing import ClassVar, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.errors import ScenarioError
from pelagos.jit import Array
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.geomagnetism import earth_field
from pelagos.math.so3 import rotate_back
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import digitise
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class MagnetometerConfig(SensorConfig):
    """A three-axis magnetometer; figures where not given are those of a magneto-inductive sensor.

    Figures: PNI RM3100, datasheet 1017252: noise 15 nT at 200 cycles, range +-800 uT.
    """

    type: Literal["magnetometer"] = "magnetometer"
    """The sensor's kind."""
    rate_hz: Rate = 20.0
    """Samples per second [Hz]; must divide the tick rate."""
    intensity_t: float | None = Field(default=None, gt=0)
    """Strength of the Earth's field [T]; with declination and inclination in place of IGRF-14."""
    declination_deg: float | None = Field(default=None, ge=-180, le=180)
    """Angle of the horizontal field from true north, east positive [deg]."""
    inclination_deg: float | None = Field(default=None, ge=-90, le=90)
    """Angle of the field below the horizon [deg]."""
    noise_density: float = Field(default=1.2e-9, ge=0)
    """White noise of each axis [T/sqrt(Hz)]."""
    hard_iron_t: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Field of the vehicle's own magnets in the sensor frame [T]."""
    soft_iron: tuple[float, float, float, float, float, float, float, float, float] = (1, 0, 0, 0, 1, 0, 0, 0, 1)
    """Matrix that the Earth's field is multiplied with, row by row, sensor frame [1]."""
    bias_std_t: float = Field(default=50e-9, ge=0)
    """Standard deviation of the constant bias, drawn once a run and axis [T]."""
    range_t: float = Field(default=800e-6, gt=0)
    """Largest reading, either sign [T]."""
    resolution_t: float = Field(default=13e-9, ge=0)
    """Step of the digital output [T]; 0 for none."""

    @model_validator(mode="after")
    def _all_three(self) -> Self:
        given = [x is not None for x in (self.intensity_t, self.declination_deg, self.inclination_deg)]
        if any(given) and not all(given):
            raise ValueError("give all of intensity_t, declination_deg and inclination_deg, or none of them")
        return self


class Magnetometer:
    """Magnetic flux density in the sensor frame FLU: soft iron times the Earth's field, plus hard iron.

    Reading: `data` `(n, 3)` [T]; `truth` is the Earth's field alone.
    """

    Config: ClassVar[type[SensorConfig]] = MagnetometerConfig
    TITLE: ClassVar[str] = "Magnetometer: the Earth's field with hard and soft iron"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = (
        "IAGA Working Group V-MOD, International Geomagnetic Reference Field, 14th generation (2024), "
        "doi 10.5281/zenodo.14012302",
        "D. Gebre-Egziabher et al., Calibration of strapdown magnetometers in magnetic field domain, J. Aerosp. Eng. "
        "19:87 (2006), doi 10.1061/(ASCE)0893-1321(2006)19:2(87): hard and soft iron",
        "PNI, RM3100 datasheet 1017252: default figures",
    )

    def __init__(self, config: MagnetometerConfig, context: SensorContext) -> None:
        self._config = config
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._field = dr.opaque(jit.Array3f64, [float(b) for b in earth_field_of(config, context.world.origin)])
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        found = self._program(motion, self._field, self._key)
        return Measurement(found["data"], found["truth"])

    def _kernel(self, motion: Kinematics, field: Array, key: noise.Key) -> Results:
        c = self._config
        _, attitude = sensor_pose(motion, c)
        earth = rotate_back(attitude, field)
        white = noise.normals64(key, motion, 3)
        offset = noise.constants64(key, motion, 3)
        data = []
        for i in range(3):
            row = c.soft_iron[3 * i : 3 * i + 3]
            bent = sum(m * b for m, b in zip(row, earth, strict=True)) + c.hard_iron_t[i] + offset[i] * c.bias_std_t
            noisy = bent + white[i] * (c.noise_density * math.sqrt(c.rate_hz))
            data.append(digitise(noisy, resolution=c.resolution_t, lowest=-c.range_t, highest=c.range_t))
        return {"data": data, "truth": earth}


def earth_field_of(config: MagnetometerConfig, origin: GeoOrigin | None) -> NDArray[np.float64]:
    """The Earth's field `(3,)` NWU [T] that a magnetometer is in: its configuration's, or IGRF-14's at an origin.

    Raises:
        ScenarioError: there is neither.
    """
    if config.intensity_t is not None and config.declination_deg is not None and config.inclination_deg is not None:
        d, i = math.radians(config.declination_deg), math.radians(config.inclination_deg)
        return config.intensity_t * np.array([math.cos(i) * math.cos(d), -math.cos(i) * math.sin(d), -math.sin(i)])
    if origin is None:
        raise ScenarioError(
            "a magnetometer needs a world with a geographic origin, or the field: intensity_t and angles"
        )
    return earth_field(origin.latitude, origin.longitude)
