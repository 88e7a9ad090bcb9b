"""One reading as people see it: a picture, a line of a waterfall, points in space, numbers.

The same for a reading of a simulation and for a message of a recording (`viewer/recorded.py`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import HEAT, INTENSITY, painted
from pelagos.messages.fan import FanPreview, copper
from pelagos.messages.sonar_image import eight_bits
from pelagos.sensors.sensor import Reading, SensorConfig
from pelagos.world.label import label_color

FAN_PIXELS: Final = 320
WATERFALL_PIXELS: Final = 480
"""Width of a line of a waterfall: more bins than that are joined."""
FANS: Final = ("imaging_sonar", "profiling_sonar")
WATERFALLS: Final = ("sidescan", "singlebeam", "synthetic_aperture_sonar")
CAMERAS: Final = (
    "camera", "depth_camera", "semantic_camera", "instance_camera", "normal_camera", "optical_flow_camera",
    "thermal_camera", "event_camera",
)  # fmt: skip
CLOUDS: Final = ("multibeam", "lidar", "semantic_lidar")
_MOST_PIXELS: Final = 480  # of a picture's longer side in a panel
_HUE: Final = 6.0


DRAWN: Final = ("angle", "soundings", "label", "ranges", "altitude")
"""Extras of readings that are drawn."""


@dataclass(frozen=True)
class Sample:
    """A reading as people see it; what a sensor does not have is None.

    Attributes:
        name: "auv0.imaging".
        kind: the sensor's type.
        t_ns: [ns].
        picture: `(h, w, 3)` uint8, or a JPEG as it was recorded.
        polar: `(beams, bins)` uint8, levels of an imaging sonar.
        line: `(w, 3)` uint8, the newest line of a waterfall.
        swath: `(w,)` how deep below a multibeam each beam met the bottom [m], port first; NaN where it did not.
        sector: colours of one direction `(bins, 3)` uint8 and that direction [rad], of a scanning sonar.
        points: `(m, 3)` in the sensor's frame FLU [m].
        colours: `(m, 3)` uint8, of the points; None: by depth.
        beams: `(b, 3)` from the sensor to what each beam met, in the sensor's frame [m].
        numbers: by name with unit, as they are shown.
        truth: the same before noise.
    """

    name: str
    kind: str
    t_ns: int
    picture: NDArray[np.uint8] | bytes | None = None
    polar: NDArray[np.uint8] | None = None
    line: NDArray[np.uint8] | None = None
    swath: NDArray[np.float32] | None = None
    sector: tuple[NDArray[np.uint8], float] | None = None
    points: NDArray[np.float32] | None = None
    colours: NDArray[np.uint8] | None = None
    beams: NDArray[np.float64] | None = None
    numbers: Mapping[str, float] = field(default_factory=dict)
    truth: Mapping[str, float] = field(default_factory=dict)


def sample_of(config: SensorConfig, reading: Reading, *, copy: int = 0, truth: bool = False) -> Sample:
    """A reading of a simulation.

    Args:
        config: of the sensor.
        reading: its reading.
        copy: of the fleet.
        truth: whether the numbers before noise are wanted, where they are cheap.
    """
    name, kind = reading.frame.replace("/", "."), config.type
    data = reading.data[copy]
    found: dict[str, Any] = {"name": name, "kind": kind, "t_ns": reading.t_ns}
    if kind in FANS:
        found["polar"] = eight_bits(config, data)
    elif kind == "mechanical_scanning_sonar":
        found["sector"] = copper()[eight_bits(config, data)], float(reading.extras["angle"][copy])
    elif kind in WATERFALLS:
        found["line"] = waterfall_line(eight_bits(config, np.atleast_2d(data)))
    elif kind in CAMERAS:
        found["picture"] = photograph(kind, data)
    elif kind == "multibeam":
        found["points"] = kept(np.asarray(reading.extras["soundings"][copy], dtype=np.float32))
        found["swath"] = swath_of(config, data)
    elif kind in CLOUDS:
        labels = reading.extras["label"][copy] if kind == "semantic_lidar" else None
        found |= cloud(data, labels)
    elif kind == "dvl":
        ranges = np.asarray(reading.extras["ranges"][copy], dtype=np.float64)
        found["beams"] = np.asarray(config.beams) * ranges[:, None]  # type: ignore[attr-defined]
    found["numbers"] = numbers_of(kind, data, reading.extras, copy)
    if truth and kind in _NUMBERS:
        found["truth"] = numbers_of(kind, reading.truth[copy], {}, copy)
    return Sample(**found)


def fan(config: Any, polar: NDArray[np.uint8], *, height: int = FAN_PIXELS) -> NDArray[np.uint8]:
    """A polar picture `(beams, bins)` of a sonar in its fan."""
    azimuth = np.asarray(config.azimuths, dtype=np.float64)
    key = (len(azimuth), float(azimuth[0]), float(azimuth[-1]), config.range_min_m, config.range_max_m, config.bins)
    return _fan(*key, height)(polar)


@cache
def _fan(beams: int, first: float, last: float, near_m: float, far_m: float, bins: int, height: int) -> FanPreview:
    return FanPreview(np.linspace(first, last, beams), near_m, far_m, bins, height=height)


def waterfall_line(levels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A line `(w, 3)` of levels `(sides, bins)`: port runs outwards to the left, starboard to the right."""
    sides = [levels[0][::-1], levels[1]] if len(levels) == 2 else [levels[0]]
    line = np.concatenate(sides)
    step = -(-len(line) // WATERFALL_PIXELS)
    whole = len(line) // step * step
    return np.asarray(copper()[line[:whole].reshape(-1, step).max(axis=1)], dtype=np.uint8)


def swath_of(config: Any, ranges: NDArray[np.floating]) -> NDArray[np.float32]:
    """`(w,)` how deep below a multibeam `(beams,)` ranges [m] met the bottom [m]; some beams where they are many."""
    depth = np.asarray(ranges * np.cos(np.asarray(config.angles)), dtype=np.float32)
    return depth[:: -(-len(depth) // WATERFALL_PIXELS)]


def photograph(kind: str, data: NDArray[Any]) -> NDArray[np.uint8]:
    """A picture `(h, w, 3)` of what a camera of any kind measured, not larger than a panel needs."""
    step = max(1, -(-max(data.shape[:2]) // _MOST_PIXELS))
    small = data[::step, ::step]
    return np.ascontiguousarray(_PHOTOGRAPHS[kind](small))


def _colour(data: NDArray[Any]) -> NDArray[np.uint8]:
    grey = data if data.ndim == 3 else np.repeat(data[..., None], 3, axis=-1)
    if grey.shape[-1] == 1:
        grey = np.repeat(grey, 3, axis=-1)
    if grey.dtype == np.uint8:
        return np.asarray(grey, dtype=np.uint8)
    if grey.dtype == np.uint16:
        return np.asarray(grey >> 8, dtype=np.uint8)
    return np.asarray(np.clip(grey, 0, 1) ** (1 / 2.2) * 255 + 0.5, dtype=np.uint8)


def _depth(data: NDArray[Any]) -> NDArray[np.uint8]:
    finite = data[np.isfinite(data)]
    high = float(np.percentile(finite, 99)) if len(finite) else 1.0
    return painted(-data, -high, 0.0, INTENSITY)


def _labels(data: NDArray[Any]) -> NDArray[np.uint8]:
    numbers, places = np.unique(data, return_inverse=True)
    table = np.array([label_color(int(n)) for n in numbers], dtype=np.uint8)
    return np.asarray(table[places.reshape(data.shape)], dtype=np.uint8)


def _instances(data: NDArray[Any]) -> NDArray[np.uint8]:
    mixed = (data.astype(np.uint64) * np.uint64(2654435761)) & np.uint64(0xFFFFFFFF)
    parts = np.stack([mixed >> np.uint64(24), mixed >> np.uint64(16), mixed >> np.uint64(8)], axis=-1) & np.uint64(0xFF)
    return np.where((data == 0)[..., None], 0, 48 + parts.astype(np.int64) * 200 // 255).astype(np.uint8)


def _normals(data: NDArray[Any]) -> NDArray[np.uint8]:
    return np.asarray(np.nan_to_num(0.5 + 0.5 * data) * 255, dtype=np.uint8)


def _flow(data: NDArray[Any]) -> NDArray[np.uint8]:
    """Direction as hue, speed as brightness."""
    x, y = np.nan_to_num(data[..., 0]), np.nan_to_num(data[..., 1])
    speed = np.hypot(x, y)
    value = np.clip(speed / max(float(np.percentile(speed, 99)), 1e-6), 0, 1)
    hue = (np.arctan2(y, x) / (2 * math.pi)) % 1.0 * _HUE
    wheel = np.stack([np.abs(hue - 3) - 1, 2 - np.abs(hue - 2), 2 - np.abs(hue - 4)], axis=-1)
    return np.asarray(np.clip(wheel, 0, 1) * value[..., None] * 255, dtype=np.uint8)


def _thermal(data: NDArray[Any]) -> NDArray[np.uint8]:
    finite = data[np.isfinite(data)]
    low, high = np.percentile(finite, [1, 99]) if len(finite) else (0.0, 1.0)
    return painted(data, float(low), float(high), HEAT)


def _events(data: NDArray[Any]) -> NDArray[np.uint8]:
    out = np.full((*data.shape[:2], 3), 24, dtype=np.uint8)
    counts = data if data.ndim == 2 else data[..., 0]
    out[counts > 0] = (240, 228, 66)
    out[counts < 0] = (0, 158, 200)
    return out


_PHOTOGRAPHS: Final[Mapping[str, Callable[[NDArray[Any]], NDArray[np.uint8]]]] = {
    "camera": _colour, "depth_camera": _depth, "semantic_camera": _labels, "instance_camera": _instances,
    "normal_camera": _normals, "optical_flow_camera": _flow, "thermal_camera": _thermal, "event_camera": _events,
}  # fmt: skip


def kept(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Those of `(..., 3)` points that are finite, `(m, 3)`."""
    flat = points.reshape(-1, 3)
    return flat[np.isfinite(flat).all(axis=1)]


def cloud(data: NDArray[Any], labels: NDArray[Any] | None) -> dict[str, Any]:
    """Points and colours of a LiDAR, `(..., 4)`: by label, else by intensity."""
    flat = data.reshape(-1, data.shape[-1])
    good = np.isfinite(flat[:, :3]).all(axis=1)
    if labels is not None:
        colours = _labels(labels.reshape(-1)[good])
    else:
        level = flat[good, 3]
        high = float(np.percentile(level, 98)) if len(level) else 1.0
        colours = painted(level, 0.0, high)
    return {"points": flat[good, :3].astype(np.float32), "colours": colours}


_NUMBERS: Final[Mapping[str, Sequence[str]]] = {
    "imu": (
        "acceleration x [m/s²]", "acceleration y [m/s²]", "acceleration z [m/s²]", "rate x [rad/s]", "rate y [rad/s]",
        "rate z [rad/s]",
    ),
    "depth": ("depth [m]",),
    "altimeter": ("range [m]",),
    "dvl": ("velocity x [m/s]", "velocity y [m/s]", "velocity z [m/s]"),
    "gps": ("latitude [deg]", "longitude [deg]", "height [m]"),
    "magnetometer": ("field x [µT]", "field y [µT]", "field z [µT]"),
    "velocity": ("velocity north [m/s]", "velocity west [m/s]", "velocity up [m/s]"),
    "pose": ("north [m]", "west [m]", "up [m]", "q w", "q x", "q y", "q z"),
    "collision": ("contact",),
    "ctd": ("conductivity [S/m]", "temperature [°C]", "pressure [dbar]"),
    "sound_velocity": ("speed of sound [m/s]",),
    "fluorometer": ("chlorophyll [mg/m³]",),
    "oxygen": ("oxygen [µmol/kg]",),
    "turbidity": ("turbidity [NTU]",),
    "current_meter": ("flow x [m/s]", "flow y [m/s]", "flow z [m/s]"),
}  # fmt: skip
_FACTOR: Final = {"magnetometer": 1e6}


def numbers_of(kind: str, data: NDArray[Any], extras: Mapping[str, Any], copy: int = 0) -> dict[str, float]:
    """Numbers that a panel writes: every number of a small reading, with its name and unit where that is known."""
    flat = np.asarray(data, dtype=np.float64).ravel() if np.size(data) <= 16 else np.zeros(0)
    names = _NUMBERS.get(kind, ())
    if len(names) != len(flat):
        names = [f"{kind} {i}" if len(flat) > 1 else kind for i in range(len(flat))]
    found = {n: float(v) * _FACTOR.get(kind, 1.0) for n, v in zip(names, flat, strict=True)}
    if kind == "dvl" and "altitude" in extras:
        found["altitude [m]"] = float(extras["altitude"][copy])
    return found
