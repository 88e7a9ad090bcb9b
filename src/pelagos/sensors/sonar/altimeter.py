"""Acoustic altimeter: the first strong echo in a cone."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, line_np
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.sensors.noise import normals64
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.schedule import farthest_heard, warn_of_ambiguity
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.conflicts import check_order
from pelagos.sensors.sonar.keys.echo_keys import EchoesConfig, echo_spec, warn_of_idle
from pelagos.sensors.sonar.keys.ping_keys import mounting
from pelagos.sensors.sonar.ping.beam_echoes import BeamEchoes
from pelagos.sensors.sonar.ping.fan import Trace
from pelagos.sensors.sonar.ping.sea_state import wind_for
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters

_RINGS: Final = ((0.0, 1), (0.25, 6), (0.5, 10), (0.75, 15))  # radius [half-power widths], rays
_THRESHOLD: Final = 0.05  # of the strongest ray's echo: a detector's threshold of -13 dB


class AltimeterConfig(EchoesConfig):
    """A single-beam altimeter that looks along -z of its frame."""

    type: Literal["altimeter"] = "altimeter"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    beamwidth_deg: float = Field(default=8.0, gt=0, le=60)
    """Half-power width of the cone [deg]."""
    range_min_m: float = Field(default=0.3, ge=0)
    """Blanking distance [m]."""
    range_max_m: float = Field(default=100.0, gt=0, le=12000)
    """Farthest echo [m]; one that comes after the next ping, from beyond 750 m/`rate_hz`, is lost."""
    frequency_hz: float = Field(default=500e3, ge=200)
    """Frequency [Hz]."""
    noise_m: float = Field(default=0.01, ge=0)
    """Standard deviation of a range at short distance [m]."""
    noise_relative: float = Field(default=0.001, ge=0)
    """Standard deviation in parts of the range, added in quadrature."""
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns times into ranges [m/s]; absent: that of the water at the sonar."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""

    @model_validator(mode="after")
    def _ordered(self) -> AltimeterConfig:
        check_order(self)
        return self


def cone_rays(beamwidth: float) -> dict[str, NDArray[Any]]:
    """Rays in rings about -z out to 1.5 half-power widths across, 32 of them (see `Fan`); `beamwidth` [rad]."""
    angle = np.concatenate([np.full(n, r * beamwidth) for r, n in _RINGS])
    turn = np.concatenate([2 * np.pi * (np.arange(n) + 0.5 * (n % 2)) / n for _, n in _RINGS])
    count = np.concatenate([np.full(n, n) for _, n in _RINGS])
    step = 0.25 * beamwidth
    ring = np.cos(np.maximum(angle - step / 2, 0)) - np.cos(angle + step / 2)
    ca, sa, ct, st = np.cos(angle), np.sin(angle), np.cos(turn), np.sin(turn)
    return {
        "direction": np.stack([sa * ct, sa * st, -ca], axis=-1),
        "aside": np.zeros((len(angle), 3)),
        "along": np.stack([ca * ct, ca * st, sa], axis=-1),
        "lower": np.full(len(angle), -step / 2),
        "upper": np.full(len(angle), step / 2),
        "weight": 2 * np.pi * ring / count * line_np(sa, line_length(beamwidth)) ** 4,
        "beam": np.zeros(len(angle), dtype=np.uint32),
    }


class Altimeter:
    """A single-beam altimeter.

    data: `(m,)` float32, range of the first strong echo [m]; NaN (and not valid) without one.
    truth: `(m,)` float32, the same before noise.
    extras: `axis` `(m,)`, range along the axis [m], infinite without a hit; `label` and `instance` `(m,)`, of what lies
        on the axis. With `water_column_bins`, `iq` or `labels` the echo, `(m, bins)` each: `water_column` and
        `water_column_truth` [dB], `iq` complex64 before gain, `water_column_label` and `water_column_instance`.
    tables: `water_column_range` `(bins,)` [m].
    """

    TITLE: ClassVar[str] = "single-beam altimeter: range of the first strong echo below"
    KERNELS: ClassVar[int] = 10
    CASTS: ClassVar[int] = 1
    ERRS: ClassVar[bool] = True
    WAITS: ClassVar[bool] = True
    ALTITUDE: ClassVar[str] = ""
    Config: ClassVar[type[SensorConfig]] = AltimeterConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Section 8.1: single-beam sounders",
    )

    def __init__(self, config: AltimeterConfig, context: SensorContext) -> None:
        self.config = config
        warn_of_ambiguity(config, context.path, config.range_max_m)
        rays = cone_rays(math.radians(config.beamwidth_deg))
        warn_of_idle(config, context.path)
        wind = wind_for(config.wind_speed_mps, context.ocean, context.path)
        self._sounder = Sounder(mounting(config), context, rays, Waters(config.frequency_hz, config.ph, wind))
        self._reach = min(config.range_max_m, farthest_heard(config.rate_hz))  # [m]
        self._program = Program(self._kernel, self._sounder.compile)
        self._echoes: BeamEchoes | None = None
        self.tables: dict[str, NDArray[Any]] = {}
        if config.echo_bins > 0:
            spec = echo_spec(config, context, nearest=config.range_min_m, farthest=config.range_max_m)
            width = math.radians(config.beamwidth_deg)
            self._echoes = BeamEchoes(spec, context, np.array([[0.0, 0.0, -1.0]]), width=width)
            self.tables["water_column_range"] = self._echoes.ranges

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        found = self._program(motion)
        extras = {name: found[name] for name in ("axis", "label", "instance")}
        if self._echoes is not None:
            extras |= {name: values[:, 0] for name, values in self._echoes.extras(motion).items()}
        return Measurement(found["data"], found["truth"], np.isfinite(found["data"]), extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._kernel, motion)

    def _kernel(self, ping: Ping, *, trace: Trace = None) -> Results:
        config, lanes = self.config, ping.lanes
        view = ping.cast(max_range=self._reach, smooth=False)
        patches = ping.patches(view, longest=self._reach, trace=trace)
        rays = dr.width(ping.fan.beam)
        dr.eval(
            patches.distance, patches.energy, view.hits.t, view.hits.label, view.hits.instance
        )  # one cast for all that follows
        true = first_echo(patches.distance, patches.energy, rays, config.range_min_m)
        (noise,) = normals64(ping.key, ping.motion, 1)
        sigma = dr.sqrt(config.noise_m**2 + (config.noise_relative * true) ** 2)
        measured = true + sigma * jit.Float(noise)
        if config.sound_speed_mps is not None:
            measured *= config.sound_speed_mps / lanes.medium.sound_speed
        measured = dr.select(measured <= self._reach, measured, dr.nan)
        axis = dr.arange(jit.UInt32, dr.width(lanes.position)) * rays
        label, instance = (dr.gather(jit.UInt32, v, axis) for v in (view.hits.label, view.hits.instance))
        met = dr.gather(jit.Float, view.hits.t, axis)
        return {"data": measured, "truth": true, "axis": met, "label": label, "instance": instance}


def first_echo(distance: Array, energy: Array, rays: int, nearest: float) -> Array:
    """Range [m] of the first of each group of `rays` whose echo is within 13 dB of the strongest; NaN without any."""
    start = dr.arange(jit.UInt32, dr.width(distance) // rays) * rays
    reach = [dr.gather(jit.Float, distance, start + k) for k in range(rays)]
    heard = [dr.select(r >= nearest, dr.gather(jit.Float, energy, start + k), 0.0) for k, r in enumerate(reach)]
    strongest, first = jit.Float(0), jit.Float(dr.inf)
    for h in heard:
        strongest = dr.maximum(strongest, h)
    for r, h in zip(reach, heard, strict=True):
        first = dr.select((h > 0.0) & (h >= _THRESHOLD * strongest), dr.minimum(first, r), first)
    return dr.select(first < dr.inf, first, dr.nan)
