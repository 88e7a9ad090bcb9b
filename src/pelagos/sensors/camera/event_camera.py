"""An event camera: where and when brightness changed, between the last sample and this one.

Data `(m, height, width)` int16: how many events each pixel sent since the last sample, positive for brighter; truth
is the same from pixels without mismatch and spurious events. Extras, float32 `(m, height, width)`: `log_change`, the
change of the logarithm of luminance, and `phase`, how far each pixel already was towards its first event. `events`
makes a list, with times.

Between two samples the logarithm is taken to change evenly; the earlier picture is what the vehicle saw if it and
everything around moved evenly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.optics.exposure import luminance
from pelagos.raycast.caster import Caster
from pelagos.sensors.camera.picture.camera_rays import Frame, Imager, Lens, Trace, pixel_angle
from pelagos.sensors.camera.picture.develop import pixel_light
from pelagos.sensors.camera.picture.pixel_blur import velocity_around
from pelagos.sensors.camera.picture.pixel_order import image_rows, pixels
from pelagos.sensors.camera.picture.radiance import radiance_along
from pelagos.sensors.camera.picture.surroundings import Lit, LitViewConfig, Surroundings, light_sources, scenery_of
from pelagos.sensors.camera.picture.turbid_sight import sight_lines
from pelagos.sensors.mount import pose_after
from pelagos.sensors.noise import Key, opaque_key, stream_key, words32
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class EventCameraConfig(LitViewConfig):
    """An event camera; defaults are of the DAVIS346 class."""

    type: Literal["event_camera"] = "event_camera"
    """The sensor's kind."""
    rate_hz: Rate = 30.0
    """Samples per second [Hz]: each reports the events since the last."""
    width_px: int = Field(default=346, ge=16, le=8192)
    """Width [px]."""
    height_px: int = Field(default=260, ge=16, le=8192)
    """Height [px]."""
    threshold: float = Field(default=0.2, gt=0, le=5)
    """Change of log luminance that makes an event."""
    threshold_mismatch: float = Field(default=0.03, ge=0, le=1)
    """Standard deviation of the pixels' own thresholds, in units of log luminance."""
    background_hz: float = Field(default=0.1, ge=0)
    """Rate of spurious events of a pixel, of brightening [Hz]."""
    refractory_s: float = Field(default=1e-4, ge=0)
    """Time that a pixel rests after an event [s]."""
    darkest_cd_m2: float = Field(default=0.01, gt=0)
    """Luminance below which the logarithm flattens out [cd/m^2]."""


class EventCamera:
    """See `EventCameraConfig`."""

    TITLE: ClassVar[str] = "event camera: changes of brightness by pixel, with times"
    KERNELS: ClassVar[int] = 93
    CASTS: ClassVar[int] = 6
    Config: ClassVar[type[SensorConfig]] = EventCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Pixel model: Y. Hu, S.-C. Liu, T. Delbruck, v2e, CVPR Workshops 2021, doi 10.1109/CVPRW53098.2021.00144",
    )

    def __init__(self, config: EventCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = Imager(config, context)
        self._surroundings = Surroundings(context)
        self._keys = tuple(opaque_key(stream_key(context.seed, context.path, k)) for k in ("mismatch", "events"))
        self._recorded = context.scene.compile(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Events of every lane since the last sample."""
        data, truth, change, phase = self._recorded(*self._arguments(motion))
        images = self._view.images
        return Measurement(
            data=images(data, np.int16),
            truth=images(truth, np.int16),
            extras={"log_change": images(change, np.float32), "phase": images(phase, np.float32)},
        )

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        return self._view.explain(self._kernel, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return *self._view.arguments(motion), self._surroundings.arguments(motion, self.config), self._keys

    def _kernel(
        self,
        caster: Caster,
        lens: Lens,
        motion: Kinematics,
        own: Array,
        light: Lit,
        keys: tuple[Key, ...],
        *,
        trace: Trace | None = None,
    ) -> tuple[Array, ...]:
        config, tiling = self.config, self._view.tiling
        ripples = self._surroundings.ripple(config)
        period = 1 / config.rate_hz
        images = dr.width(motion.tick)
        where = pixels(tiling, images)
        logs: list[Array] = []
        drift = None
        for delay, moment in ((0.0, motion), (-period, pose_after(motion, -period))):
            scenery = scenery_of(caster.tables, light, ripples, moment, config, delay)
            frame = Frame(lens, moment, own, config, tiling)
            rays = replace(frame.rays(where, scenery.level), drift=drift)
            lamps = light_sources(config, moment, where.image)
            lines = sight_lines(scenery, frame, where)
            seen, hits = radiance_along(caster, scenery, rays, where.image, lamps, pixel_angle(config), lines=lines)
            bright = luminance(pixel_light(seen, where, tiling, pixel_angle(config)))
            logs.append(dr.log(bright + config.darkest_cd_m2))
            if caster.moving is not None and delay == 0:  # where bodies were, for the earlier picture
                moves = hits.valid & (dr.squared_norm(hits.velocity) > 0) & where.active
                drift = -period * velocity_around(hits.velocity, moves, where, tiling, images)
                dr.eval(drift, logs)
        change = logs[0] - logs[1]
        index = where.row * tiling.width + where.column
        environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
        own_words = words32(keys[0], index, environment, dr.zeros(jit.UInt32, dr.width(index)))
        words = words32(keys[1], index, environment, tick)
        phase = uniform32(words[0])
        threshold = config.threshold + config.threshold_mismatch * normal_pair32(own_words[0], own_words[1])[0]
        threshold = dr.maximum(threshold, 0.1 * config.threshold)
        truth = event_count(change, phase, config.threshold, config)
        spurious = dr.select(uniform32(words[1]) < config.background_hz * period, 1, 0)
        data = event_count(change, phase, threshold, config) + spurious
        if trace is not None:
            trace("change of log luminance", change, "1")
            trace("threshold", threshold, "1")
            trace("events", data, "")
        return tuple(image_rows(v, tiling, where, images) for v in (data, truth, change, phase))


def event_count(change: Array, phase: Array, threshold: Array, config: EventCameraConfig) -> Array:
    """Whole thresholds crossed, `Int32` with sign, from a state `phase` of a threshold away from the first."""
    most = 1 / (config.rate_hz * config.refractory_s) if config.refractory_s > 0 else 32767.0
    count = dr.floor(dr.minimum(dr.floor(dr.abs(change) / threshold + phase), min(most, 32767.0)))
    return jit.Int32(dr.select(change < 0, -count, count))


def events(measured: Measurement, lane: int, config: EventCameraConfig) -> NDArray[np.float64]:
    """Events of one lane in order of time, `(k, 4)`: column, row [px], time from the sample [s] (<= 0), polarity."""
    count = measured.data[lane].astype(np.int64)
    change = np.abs(measured.extras["log_change"][lane].astype(np.float64))
    phase = measured.extras["phase"][lane].astype(np.float64)
    rows, columns = np.nonzero(count)
    number = np.abs(count[rows, columns])
    which = np.repeat(np.arange(len(rows)), number)
    order = np.arange(len(which)) - np.repeat(np.cumsum(number) - number, number)
    share = (
        (order + 1 - phase[rows, columns][which]) * config.threshold / np.maximum(change[rows, columns][which], 1e-9)
    )
    time = (np.clip(share, 0, 1) - 1) / config.rate_hz
    found = np.stack([columns[which], rows[which], time, np.sign(count[rows, columns])[which]], axis=-1)
    return np.asarray(found[np.argsort(time, kind="stable")], dtype=np.float64)
