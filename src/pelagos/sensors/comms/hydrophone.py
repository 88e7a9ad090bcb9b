"""Hydrophones: the pressure at one element or several, with pingers through the simulated water and the sea's noise."""

from __future__ import annotations

import hashlib
import math
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.channel import ambient_density, noise_of
from pelagos.config.rate import Rate
from pelagos.config.strict import Strict
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.ocean.surface_wind import surface_wind
from pelagos.sensors.comms.link.place import check_in_water
from pelagos.sensors.comms.link.water_paths import WaterPaths, doppler
from pelagos.sensors.mount import sensor_pose, sensor_velocity
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_PASCAL = 1e-6  # [Pa/uPa]
_TAPER = 0.1  # of a pulse, at each end
_MARGIN_S = 1e-6  # far above the rounding of times, far below a pulse
_QUIET_DB = 60.0  # below the loudest, from which paths are left out

Place = tuple[float, float, float]


class PingerConfig(Strict):
    """A pinger at a fixed place. RoboSub's and VRX's send 25 to 40 kHz, 4 ms, once in 2 s."""

    position_m: Place
    """World x (north), y (west), z (up) [m]."""
    frequency_hz: float = Field(default=30_000.0, gt=0)
    """Of its tone [Hz]."""
    source_level_db: float = Field(default=160.0, ge=50, le=230)
    """[dB re 1 uPa at 1 m]."""
    pulse_s: float = Field(default=0.004, gt=0)
    """Length of a pulse [s]."""
    period_s: float = Field(default=2.0, gt=0)
    """From pulse to pulse [s]."""
    first_s: float = Field(default=0.0, ge=0)
    """When the first one begins [s]."""


class HydrophoneConfig(SensorConfig):
    """Elements, sampling and sources."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["hydrophone"] = "hydrophone"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Readings per second [Hz], each with the samples since the one before; must divide the tick rate."""
    sample_rate_hz: float = Field(default=96_000.0, gt=0)
    """Samples per second [Hz]; a multiple of rate_hz."""
    elements_m: Annotated[tuple[Place, ...], Field(min_length=1, max_length=256)] = ((0.0, 0.0, 0.0),)
    """Elements in the sensor frame [m]."""
    pingers: dict[str, PingerConfig] = Field(default_factory=dict)
    """Sources by name."""
    shipping: float = Field(default=0.5, ge=0, le=1)
    """Ships far away, for the noise: 0 none to 1 heavy."""
    self_noise_db: float = Field(default=30.0, ge=-50, le=150)
    """White noise of each element and its amplifier [dB re 1 uPa^2/Hz]."""

    @model_validator(mode="after")
    def _samples(self) -> HydrophoneConfig:
        samples = self.sample_rate_hz / self.rate_hz
        if samples < 1 - 1e-9 or abs(samples - round(samples)) > 1e-6:
            raise ValueError(f"sample_rate_hz {self.sample_rate_hz:g} is no multiple of rate_hz {self.rate_hz:g}")
        for name, pinger in self.pingers.items():
            if pinger.frequency_hz >= 0.5 * self.sample_rate_hz:
                raise ValueError(f"pinger {name!r}: {pinger.frequency_hz:g} Hz is above half the sample rate")
            if pinger.pulse_s > pinger.period_s:
                raise ValueError(
                    f"pinger {name!r}: pulse_s {pinger.pulse_s:g} is longer than period_s {pinger.period_s:g}"
                )
        return self


class Hydrophone:
    """Pressure against time.

    Reading: `data` `(n, elements, samples)` float32 [Pa], the samples of the period that ends at the reading's time;
    `truth` the pingers without noise. Tables: `time` `(samples,)` before the reading's time [s].
    """

    Config: ClassVar[type[SensorConfig]] = HydrophoneConfig
    TITLE: ClassVar[str] = "Hydrophones: time series of pressure, pingers and the sea's noise"
    KERNELS: ClassVar[int] = 120
    CASTS: ClassVar[int] = 10
    ONE_VEHICLE: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "R. Coates, Underwater Acoustic Systems, 1990, Section 6.3, after G. M. Wenz, doi 10.1121/1.1909155 (noise)",
        "F. B. Jensen et al., Computational Ocean Acoustics, 2nd ed., 2011, doi 10.1007/978-1-4419-8678-8 (paths)",
    )

    def __init__(self, config: HydrophoneConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        self._count = round(config.sample_rate_hz / config.rate_hz)
        self._elements = np.array(config.elements_m)
        for name, pinger in config.pingers.items():
            check_in_water(context, name, pinger.position_m)
        self._pingers = list(config.pingers.values())
        sea = ambient_density(
            self._count, config.sample_rate_hz, wind_speed=surface_wind(context.ocean)[0], shipping=config.shipping
        )
        self._density = sea + 10.0 ** (config.self_noise_db / 10.0)  # [uPa^2/Hz]
        self._time = (np.arange(self._count) - self._count) / config.sample_rate_hz
        self._paths = {
            f: WaterPaths(context.scene, context.world, context.ocean, frequency=f, rays=256, bounces=6)
            for f in {p.frequency_hz for p in self._pingers}
        }

    def sense(self, motion: Kinematics) -> Measurement:
        """Listen on every lane of `motion`."""
        position, attitude = (np.array(v).T for v in sensor_pose(motion, self._config))
        velocity = rotate_np(attitude, np.array(sensor_velocity(motion, self._config)).T)
        t = np.array(motion.t_ns).astype(np.float64) * 1e-9
        copy = np.array(motion.copy).astype(np.int64)
        clean = np.zeros((len(t), len(self._elements), self._count))
        for pinger in self._pingers:
            for moment in np.unique(t):
                rows = np.flatnonzero(t == moment)
                self._add(clean, rows, pinger, float(moment), position, attitude, velocity, copy)
        noisy = np.stack([c + self._noise(motion, lane) for lane, c in enumerate(clean)])
        return Measurement(noisy.astype(np.float32), clean.astype(np.float32), tables={"time": self._time})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One reading: (name, values, unit)."""
        found = self.sense(motion)
        return [("pressure without noise", found.truth, "Pa"), ("pressure", found.data, "Pa")]

    def _add(
        self, clean: NDArray[np.float64], rows: NDArray[np.intp], pinger: PingerConfig, t: float,
        position: NDArray[np.float64], attitude: NDArray[np.float64], velocity: NDArray[np.float64],
        copy: NDArray[np.int64],
    ) -> None:  # fmt: skip
        """One pinger's pulses, by every path, at all elements."""
        f = pinger.frequency_hz
        source = np.tile(np.array(pinger.position_m), (len(rows), 1))
        found = self._paths[f].trace(source, position[rows], t, copy[rows])
        a = found.arrivals
        ratio = doppler(found, np.zeros((len(rows), 3)), velocity[rows])
        size = 10.0 ** (pinger.source_level_db / 20.0) * _PASCAL * math.sqrt(2.0)  # peak of a tone of this level
        for k in np.flatnonzero(~found.blocked):
            row, own = rows[a.path[k]], a.path == a.path[k]
            if a.loss_db[k] > a.loss_db[own].min() + _QUIET_DB:
                continue
            ahead = rotate_back_np(attitude[row : row + 1], found.arrival[k : k + 1])[0]
            late = self._elements @ ahead / found.speed[a.path[k], 1]  # (elements,)
            began = t - a.delay[k] - pinger.first_s
            if _silent(pinger, ratio[k] * self._time[[0, -1]] + began - [late.max(), late.min()]):
                continue
            # at time t + s the path takes delay - (D - 1) s
            local = ratio[k] * self._time[None] + t - a.delay[k] - late[:, None] - pinger.first_s
            number = np.floor(local / pinger.period_s)
            since = local - number * pinger.period_s
            on = (number >= 0) & (since < pinger.pulse_s)
            if not on.any():
                continue
            edge = np.clip(np.minimum(since, pinger.pulse_s - since) / (_TAPER * pinger.pulse_s), 0.0, 1.0)
            wave = np.abs(a.amplitude[k]) * np.cos(2.0 * math.pi * f * since + np.angle(a.amplitude[k]))
            clean[row] += np.where(on, size * np.sin(0.5 * math.pi * edge) ** 2 * wave, 0.0)

    def _noise(self, motion: Kinematics, lane: int) -> NDArray[np.float64]:
        c = self._config
        names = (self._context.seed, self._context.path, "noise", int(motion.environment[lane]), int(motion.tick[lane]))
        text = "\x1f".join(str(n) for n in names).encode()
        key = int.from_bytes(hashlib.blake2b(text, digest_size=16, person=b"pelagos").digest(), "little")
        rng = np.random.Generator(np.random.Philox(key=key))
        return _PASCAL * noise_of(self._density, self._count, c.sample_rate_hz, rng=rng, elements=len(self._elements))


def _silent(pinger: PingerConfig, span: NDArray[np.float64]) -> bool:
    """No pulse lies between two times since the first one began [s]."""
    latest = math.floor((span[1] + _MARGIN_S) / pinger.period_s)
    return bool(latest < 0 or latest * pinger.period_s + pinger.pulse_s < span[0] - _MARGIN_S)
