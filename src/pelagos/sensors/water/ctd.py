"""CTD: conductivity, temperature and pressure, and the salinity that follows from them."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.ocean.ocean import Ocean
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class CtdConfig(SensorConfig):
    """A CTD; figures where not given: Sea-Bird SBE 49 FastCAT, its accuracies taken as three standard deviations."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["ctd"] = "ctd"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Samples per second [Hz]; must divide the tick rate."""
    conductivity_noise_density: float = Field(default=1e-5, ge=0)
    """White noise [S/m/sqrt(Hz)]."""
    conductivity_bias_std: float = Field(default=1e-4, ge=0)
    """Standard deviation of the constant offset, drawn once a run [S/m]."""
    temperature_noise_density: float = Field(default=3e-5, ge=0)
    """White noise [degC/sqrt(Hz)]."""
    temperature_bias_std: float = Field(default=0.0007, ge=0)
    """Standard deviation of the constant offset, drawn once a run [degC]."""
    pressure_noise_density: float = Field(default=0.002, ge=0)
    """White noise [dbar/sqrt(Hz)]."""
    pressure_bias_std: float = Field(default=0.12, ge=0)
    """Standard deviation of the constant offset, drawn once a run [dbar]; 0.1 % of 350 dbar is three of them."""


class Ctd:
    """Conductivity, temperature and pressure of the water at the mount; the cell follows at once, without thermal lag.

    Reading: `data` `(n, 3)`: conductivity [S/m], temperature in situ [degC], pressure without the atmosphere's [dbar].
    Extras: `salinity` `(n,)` practical, `sound_speed` `(n,)` [m/s], both computed from `data`. Nothing is read in the
    air.
    """

    Config: ClassVar[type[SensorConfig]] = CtdConfig
    TITLE: ClassVar[str] = "CTD: conductivity, temperature, pressure; salinity and sound speed from them (TEOS-10)"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = (
        "IOC, SCOR and IAPSO, The international thermodynamic equation of seawater - 2010, Manuals and Guides 56: "
        "Practical Salinity Scale 1978 and sound speed, through gsw",
        "Sea-Bird Scientific, SBE 49 FastCAT data sheet: default figures",
    )

    def __init__(self, config: CtdConfig, context: SensorContext) -> None:
        self._config = config
        self._ocean = context.ocean
        self._origin = context.world.origin
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        import gsw

        water = self._program(motion, self._ocean, self._key)
        temperature, salinity, pressure = water["temperature"], water["salinity"], water["pressure"]
        truth = np.stack([0.1 * gsw.C_from_SP(salinity, temperature, pressure), temperature, pressure], axis=-1)
        data = truth + water["error"]
        valid = water["wet"]
        data, truth = (np.where(valid[:, None], x, np.nan) for x in (data, truth))
        found = gsw.SP_from_C(10 * data[:, 0], data[:, 1], data[:, 2])
        absolute = gsw.SA_from_SP(found, data[:, 2], self._origin.longitude, self._origin.latitude)
        speed = gsw.sound_speed_t_exact(absolute, data[:, 1], data[:, 2])
        return Measurement(data=data, truth=truth, valid=valid, extras={"salinity": found, "sound_speed": speed})

    def _kernel(self, motion: Kinematics, ocean: Ocean, key: noise.Key) -> Results:
        c = self._config
        position, _ = sensor_pose(motion, c)
        t = jit.Float64(motion.t_ns) * 1e-9
        white, offset = noise.normals64(key, motion, 3), noise.constants64(key, motion, 3)
        density = (c.conductivity_noise_density, c.temperature_noise_density, c.pressure_noise_density)
        bias = (c.conductivity_bias_std, c.temperature_bias_std, c.pressure_bias_std)
        rate = math.sqrt(c.rate_hz)
        error = [w * (d * rate) + o * b for w, d, o, b in zip(white, density, offset, bias, strict=True)]
        wet = position[2] < ocean.elevation(position[0], position[1], t, motion.copy)
        dbar = 1e-4 * ocean.pressure(position, t, motion.copy)
        temperature, salinity = ocean.temperature(position, t), ocean.salinity(position, t)
        return {"temperature": temperature, "salinity": salinity, "pressure": dbar, "error": error, "wet": wet}
