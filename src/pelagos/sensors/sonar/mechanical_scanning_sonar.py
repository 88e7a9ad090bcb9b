"""Mechanically scanning sonar: one beam on a head that turns a step a ping."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, spread_over_beam
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.sensors.lazy import promised
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig, ping_spec
from pelagos.sensors.sonar.ping.aperture import Aperture, one_beam
from pelagos.sensors.sonar.ping.elevation_strata import strata
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.pinger import Pinger


class MechanicalScanningSonarConfig(PingConfig):
    """A mechanically scanning sonar. Defaults are of the Ping360 class."""

    type: Literal["mechanical_scanning_sonar"] = "mechanical_scanning_sonar"
    rate_hz: Rate = 10.0
    """Pings per second [Hz]."""
    range_max_m: float = Field(default=50.0, gt=0, le=12000)
    """Far edge of the last bin [m]."""
    beamwidth_deg: float = Field(default=2.0, gt=0, le=45)
    """Half-power width in the plane of the scan [deg], one way."""
    vertical_beamwidth_deg: float = Field(default=25.0, gt=0, le=90)
    """Half-power width across the plane of the scan [deg], one way."""
    sector_deg: float = Field(default=360.0, gt=0, le=360)
    """Sector that is scanned, centred ahead [deg]; 360 goes round and round, less goes to and fro."""
    step_deg: float = Field(default=1.8, gt=0, le=45)
    """Turn of the head from ping to ping [deg]."""
    vertical_side_lobes: int = Field(default=1, ge=0, le=8)
    """Side lobes above and below the main lobe that rays are cast into (-26.5 dB there and back)."""
    rays: int = Field(default=384, ge=16, le=65536)
    """Rays in the beam."""

    @model_validator(mode="after")
    def _step_fits(self) -> Self:
        if self.step_deg > self.sector_deg:
            raise ValueError(f"step_deg {self.step_deg:g} must be at most sector_deg {self.sector_deg:g}")
        return self

    def angles(self, ping: NDArray[np.integer[Any]]) -> NDArray[np.float64]:
        """Direction of the head at ping number `ping` [rad], positive to the left; it begins at the left edge."""
        if self.sector_deg >= 360.0:
            place = ping % round(self.sector_deg / self.step_deg)
        else:
            steps = int(self.sector_deg / self.step_deg * (1 + 1e-9))  # the last one stays in the sector
            place = ping % (2 * steps)
            place = np.where(place > steps, 2 * steps - place, place)
        return np.asarray(np.radians(self.sector_deg / 2 - place * self.step_deg))


def beam_rays(config: MechanicalScanningSonarConfig) -> dict[str, NDArray[Any]]:
    """Rays about +x: one in each stratum of elevation (see `strata`), spread over the beam's width to its nulls."""
    count = config.rays
    length = line_length(math.radians(config.vertical_beamwidth_deg))
    across = line_length(math.radians(config.beamwidth_deg))
    low, high, pattern = strata(length, config.vertical_side_lobes, count, np.arange(count), np.full(count, 0.5))
    elevation = 0.5 * (low + high)
    azimuth, sideways = spread_over_beam(across, (0.5 + 0.6180339887498949 * np.arange(count)) % 1.0)
    ce, se, ca, sa = np.cos(elevation), np.sin(elevation), np.cos(azimuth), np.sin(azimuth)
    direction = np.stack([ce * ca, ce * sa, se], axis=-1)
    return {
        "direction": direction,
        "along": np.stack([-se * ca, -se * sa, ce], axis=-1),
        "aside": np.stack([ce, 0 * ce, se], axis=-1) - direction,
        "lower": low - elevation,
        "upper": high - elevation,
        "across": np.full(count, math.sqrt(2.0) * sideways),  # even spread with as many close pairs as a bell's
        "weight": sideways * pattern,
        "beam": np.zeros(count, dtype=np.uint32),
    }


def aperture(config: MechanicalScanningSonarConfig) -> Aperture:
    """One transducer that looks along +x, both ways."""
    along, across = (line_length(math.radians(a)) for a in (config.beamwidth_deg, config.vertical_beamwidth_deg))
    return Aperture(*one_beam([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), along, across)


class MechanicalScanningSonar:
    """A mechanically scanning sonar.

    data: `(m, bins)` float32, echo level after time-varied gain, as `ImagingSonar` gives it.
    truth: the same without noise and without interference of echoes.
    extras: `angle` `(m,)`, direction of the head [rad], positive to the left; with `iq` and `labels` as `ImagingSonar`.
    tables: `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "mechanically scanning sonar: one beam on a head that turns a step a ping"
    KERNELS: ClassVar[int] = 23
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = MechanicalScanningSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Chapters 5 and 8",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
    )

    def __init__(self, config: MechanicalScanningSonarConfig, context: SensorContext) -> None:
        self.config = config
        self._period = period_ticks(config.rate_hz, context.dt_ns, where=context.path)
        width = math.radians(config.beamwidth_deg)
        shape = Layout(1, width, width, math.radians(config.vertical_beamwidth_deg), np.zeros(1), single_file=True,
                       aperture=aperture(config))  # fmt: skip
        head = lambda tick: config.angles(tick // self._period)
        self._pinger = Pinger(ping_spec(config, context), context, beam_rays(config), shape, head)
        self.tables = {"range": config.ranges}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane, with the head where its ping number says."""
        angle = self._angle(motion)
        data, truth, extras = self._pinger.ping(motion, _turn(angle))
        out = {k: v[:, 0] for k, v in extras.items()} | {"angle": angle.astype(np.float32)}
        return Measurement(data[:, 0], promised(lambda: truth()[:, 0]), None, out, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion, _turn(self._angle(motion)))

    def _angle(self, motion: Kinematics) -> NDArray[np.float64]:
        return self.config.angles(np.array(motion.tick).astype(np.int64) // self._period)


def _turn(angle: NDArray[np.float64]) -> Array:
    """Rotation about +z by lane, `Array4f64`."""
    zero = np.zeros_like(angle)
    turn = jit.Array4f64(*map(jit.padded, (np.cos(angle / 2), zero, zero, np.sin(angle / 2))))
    dr.make_opaque(turn)
    return turn
