"""Soundings: from the series of a multibeam's beams to ranges, strengths, errors and places."""

from __future__ import annotations

from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.bottom_detection import NOT_FOUND, Series, find_bottom
from pelagos.acoustics.refraction import path_end
from pelagos.acoustics.spreading import to_db
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.sensors.schedule import farthest_heard
from pelagos.sensors.sonar.ping.bottom_series import Window
from pelagos.sensors.sonar.ping.fan import Lanes, Trace, arcs_of


def detect(
    config: Any, window: Window, series: Series, lanes: Lanes, noise: Array, trace: Trace = None
) -> dict[str, Array]:
    """Of each beam, by name: range and truth [m], backscatter [dB], uncertainty [m], snr [dB], the kind of detection,
    label and instance."""
    found = find_bottom(series, config.samples, noise=noise)
    lane = dr.arange(jit.UInt32, dr.width(window.where)) // config.soundings
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    scale = 1.0 if config.sound_speed_mps is None else config.sound_speed_mps / speed
    measured, error = found.distance * scale, found.error * scale
    snr_db = to_db(dr.maximum(found.level / noise, 1e-12))
    heard = window.found & (found.kind != NOT_FOUND) & (snr_db > config.detection_snr_db)
    heard &= (measured >= config.range_min_m) & (measured <= config.range_max_m)
    heard &= found.distance <= farthest_heard(config.rate_hz, speed)
    echoes = dr.maximum(found.power - config.samples * noise, 0.1 * noise)
    strength = to_db(dr.maximum(window.section * echoes / dr.maximum(window.power, 1e-37), 1e-12))
    true = dr.select(window.axis <= config.range_max_m, window.axis, dr.nan)
    if trace is not None:
        for name, value, unit in (
            ("spacing of a beam's samples", series.spacing, "m"),
            ("intensity of a beam's samples", dr.norm(dr.unravel(jit.Array4f, series.halves)), "1"),
            ("signal-to-noise ratio", snr_db, "dB"),
            ("range by amplitude", found.by_amplitude, "m"),
            ("range by phase", found.by_phase, "m"),
            ("estimated error by amplitude", found.amplitude_error, "m"),
            ("estimated error by phase", found.phase_error, "m"),
            ("detected range", measured, "m"),
        ):
            trace(name, value, unit)
    return {
        "range": dr.select(heard, measured, dr.nan),
        "truth": true,
        "backscatter": dr.select(heard, strength, dr.nan),
        "uncertainty": dr.select(heard, error, dr.nan),
        "snr": snr_db,
        "detection": dr.select(heard, found.kind, NOT_FOUND),
        "label": window.label,
        "instance": window.instance,
    }


def sounding_places(config: Any, direction: Array, distance: Array, lanes: Lanes) -> Array:
    """Places of the soundings, `Array3f` in the sensor frame of the ping's transmission [m]: along the beams' axes, as
    rays bend; `direction` in the world."""
    lane = dr.arange(jit.UInt32, dr.width(distance)) // config.soundings
    q = dr.gather(jit.Array4f, jit.Array4f(lanes.attitude), lane)
    if lanes.profile is None or config.sound_speed_mps is not None:
        return rotate_back(q, direction) * distance
    return rotate_back(q, path_end(lanes.profile, lane, direction, distance, arcs=arcs_of(config.range_max_m)))


def snippets(series: Series, shape: tuple[int, int], samples: int) -> dict[str, NDArray[Any]]:
    """`iq` complex64 `(m, beams, 2, samples)`, of both halves of the array, and `iq_range` `(m, beams, samples)`."""
    parts = np.array(series.halves).reshape(*shape, samples, 2, 2)
    start, spacing = (np.array(v).reshape(*shape, 1) for v in (series.start, series.spacing))
    return {
        "iq": np.ascontiguousarray((parts[..., 0] + 1j * parts[..., 1]).swapaxes(-1, -2).astype(np.complex64)),
        "iq_range": (start + (np.arange(samples) + 0.5) * spacing).astype(np.float32),
    }


def quality(distance: NDArray[np.float32], error: NDArray[np.float32]) -> NDArray[np.float32]:
    """1/(1 + (error/(0.002 distance + 1 mm))^2), 0 where there is no sounding; all arrays of one shape, [m]."""
    with np.errstate(invalid="ignore"):
        good = 1.0 / (1.0 + (error / (0.002 * distance + 1e-3)) ** 2)
    return np.where(np.isfinite(distance), good, np.float32(0)).astype(np.float32)
