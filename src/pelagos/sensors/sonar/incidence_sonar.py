"""Sonar by incidence and impedance alone: HoloOcean's intensity, for comparison with work that was done in it.

The echo of a patch is R^2 cos(incidence), R the reflection coefficient of impedances; a cell holds the mean of its
patches. No spreading, absorption, beam pattern or interference. Noise as HoloOcean paints it.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.raycast.caster import Caster
from pelagos.sensors.idle_keys import Need, idle
from pelagos.sensors.noise import Key, lane_stream
from pelagos.sensors.ray_sensor import RaySensor
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_SOLID: Final = 10_000.0 * 10_000.0  # impedance of everything in HoloOcean 2.3: density times sound speed
_RAYS_ACROSS: Final = 4  # of a beam
_RAYS_UP: Final = 64  # over the elevation
_NEEDS: Final = (Need(("scale_noise",), "additive"), Need(("vertical_aperture_deg",), "cone", (False,)))


class IncidenceSonarConfig(SensorConfig):
    """A sector of beams about x, or a cone."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["incidence_sonar"] = "incidence_sonar"
    """The sensor's kind."""
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the sector; a `cone` is one."""
    bins: int = Field(default=512, ge=1, le=65536)
    """Range bins."""
    range_min_m: float = Field(default=0.1, ge=0)
    """Near edge of the first bin [m]."""
    range_max_m: float = Field(default=10.0, gt=0)
    """Far edge of the last bin [m]."""
    horizontal_aperture_deg: float = Field(default=120.0, gt=0, le=180)
    """Sector in the x-y plane [deg], or the whole angle of the cone."""
    vertical_aperture_deg: float = Field(default=20.0, gt=0, le=180)
    """Elevation about it [deg]."""
    cone: bool = False
    """One beam that is a cone about x."""
    density_kg_m3: float = Field(default=997.0, gt=0)
    """Of the water [kg/m^3]."""
    sound_speed_mps: float = Field(default=1480.0, gt=0)
    """In the water [m/s]."""
    gain: float = Field(default=1.0, gt=0)
    """Factor on the mean of a cell; 0.5 of HoloOcean's imaging and profiling sonars."""
    additive: float = Field(default=0.0, ge=0)
    """Scale of the Rayleigh noise of every cell."""
    multiplicative: float = Field(default=0.0, ge=0)
    """Standard deviation of the factor on every cell."""
    range_error_m: float = Field(default=0.0, ge=0)
    """Mean n of the exponential error of ranges; the echo falls by exp(-n / mean)."""
    scale_noise: bool = False
    """Additive noise grows with the square of range, and in the middle of the sector."""

    @model_validator(mode="after")
    def _ranges(self) -> IncidenceSonarConfig:
        if self.range_min_m >= self.range_max_m:
            raise ValueError(f"range_min_m {self.range_min_m:g} must be below range_max_m {self.range_max_m:g}")
        if self.cone and self.beams != 1:
            raise ValueError(f"a cone is one beam: give beams: 1 with cone: true, not {self.beams}")
        return self


class IncidenceSonar(RaySensor):
    """See `IncidenceSonarConfig`.

    data, truth: `(m, beams, bins)` float32, from the left-most beam; truth without noise.
    """

    TITLE: ClassVar[str] = "Sonar by incidence and impedance alone, as HoloOcean's"
    Config: ClassVar[type[SensorConfig]] = IncidenceSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = ("HoloOcean documentation, Sonar sensors (BYU FRoSt Lab, MIT licence)",)

    def __init__(self, config: IncidenceSonarConfig, context: SensorContext) -> None:
        if told := idle(config, _NEEDS):
            warnings.warn(f"{context.path}: {told}", ValidityWarning, stacklevel=3)
        self._rays, self._beam = _rays(config)
        super().__init__(config, context)
        self._streams = Program(_streams)
        water = config.density_kg_m3 * config.sound_speed_mps
        self._strength = ((_SOLID - water) / (_SOLID + water)) ** 2

    def pattern(self, config: Any) -> NDArray[np.float64]:
        """Directions of the rays in the sensor frame, `(r, 3)`."""
        return self._rays

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Arrays of one ping's hits: (name, values, unit)."""
        distance, cosine = self._met(motion)
        return [("distance", distance, "m"), ("cosine of the incidence", cosine, "1")]

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        c, rays = self.config, len(self._beam)
        distances, cosines = self._met(motion)
        clean, noisy = [], []
        words = self._streams(motion, self._key)["words"]
        for distance, cosine, seed in zip(distances, cosines, words, strict=True):
            stream = np.random.default_rng(seed)
            echo = self._strength * cosine
            clean.append(self._image(distance, echo) * c.gain)
            if c.range_error_m:
                late = stream.exponential(c.range_error_m, rays)
                distance, echo = distance + late, echo * np.exp(-late / c.range_error_m)
            noisy.append(self._noise(self._image(distance, echo), stream))
        return Measurement(np.stack(noisy).astype(np.float32), np.stack(clean).astype(np.float32))

    def _kernel(
        self, caster: Caster, motion: Kinematics, ocean: Ocean, directions: Array, own: Array, key: Key
    ) -> Results:
        shot, hits = self._shot(caster, motion, directions, own)
        cosine = dr.abs(dr.dot(hits.normal, shot.direction))
        return {"distance": dr.select(hits.valid, hits.t, dr.inf), "cosine": dr.select(hits.valid, cosine, 0.0)}

    def _met(self, motion: Kinematics) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """`(m, rays)` distance [m] and cosine of incidence of what the rays met."""
        found = self._program(motion, self._ocean, self._directions, self._own, self._key)
        shape = (-1, len(self._beam))
        return found["distance"].reshape(shape).astype(np.float64), found["cosine"].reshape(shape).astype(np.float64)

    def _image(self, distance: NDArray[np.float64], echo: NDArray[np.float64]) -> NDArray[np.float64]:
        """`(beams, bins)` mean of the echoes of each cell."""
        c = self.config
        at = (distance - c.range_min_m) / (c.range_max_m - c.range_min_m) * c.bins
        there = (at >= 0) & (at < c.bins)
        cell = self._beam[there] * c.bins + at[there].astype(np.int64)
        size = c.beams * c.bins
        total, count = np.bincount(cell, echo[there], size), np.bincount(cell, minlength=size)
        return np.asarray((total / np.maximum(count, 1)).reshape(c.beams, c.bins))

    def _noise(self, image: NDArray[np.float64], stream: np.random.Generator) -> NDArray[np.float64]:
        """The image with noise."""
        c = self.config
        found: NDArray[np.float64] = image * (c.gain + c.multiplicative * stream.standard_normal(image.shape))
        if c.additive:
            rain = stream.rayleigh(c.additive, image.shape)
            if c.scale_noise:
                share = np.arange(c.bins) / c.bins
                azimuth = c.horizontal_aperture_deg * (0.5 - (np.arange(c.beams) + 0.5) / c.beams)
                bell = 1 + 0.5 * np.exp(-(azimuth**2) / (c.horizontal_aperture_deg / 64))
                rain *= share[None, :] ** 2 * bell[:, None]
            found += rain
        return found


def _streams(motion: Kinematics, key: Key) -> Results:
    """Four words for each lane's random stream: of the sensor, of its copy of the fleet, of the tick."""
    (first, second), environment = lane_stream(key, motion.environment)
    lanes = dr.width(motion.tick)
    return {"words": [w + dr.zeros(jit.UInt32, lanes) for w in (first, second, environment, jit.UInt32(motion.tick))]}


def _rays(config: IncidenceSonarConfig) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Directions in the sensor frame `(r, 3)`, and the beam of each."""
    if config.cone:
        turn = np.arange(_RAYS_UP * _RAYS_ACROSS * 4)
        off = np.radians(config.horizontal_aperture_deg) / 2 * np.sqrt((turn + 0.5) / len(turn))
        round_ = turn * np.pi * (3 - np.sqrt(5.0))
        axes = [np.cos(off), np.sin(off) * np.cos(round_), np.sin(off) * np.sin(round_)]
        return np.stack(axes, axis=-1), np.zeros(len(turn), dtype=np.int64)
    across = config.beams * max(_RAYS_ACROSS, -(-256 // config.beams))
    azimuth = np.radians(config.horizontal_aperture_deg) * (0.5 - (np.arange(across) + 0.5) / across)
    up = np.radians(config.vertical_aperture_deg) / 2 * (2 * (np.arange(_RAYS_UP) + 0.5) / _RAYS_UP - 1)
    a, e = (x.ravel() for x in np.meshgrid(azimuth, up, indexing="ij"))
    beam = np.repeat(np.arange(across) * config.beams // across, _RAYS_UP)
    return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1), beam
