"""Recordings of real sonars, read from their makers' and the trade's formats, and the statistics of their images.

Formats: Triton's XTF (R2Sonic's own packets in it), the Generic Sensor Format 3.08, and Blueprint's
SimplePingResult; each after its published description.
"""

from __future__ import annotations

import gzip
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter
from scipy.signal import savgol_filter

Array = NDArray[Any]

OCULUS, R2SONIC, GSF = (
    "oculus_one_ping_8bit.raw.gz",
    "R2Sonic_150708_0001.xtf.gz",
    "GSF3_08_test_file.gsf",
)
_QINSY_R2SONIC: Final = 65  # type of XTF packets
QUANTILES: Final = (0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)
LAGS: Final = 6


def _bytes(path: Path) -> bytes:
    data = path.read_bytes()
    return gzip.decompress(data) if path.suffix == ".gz" else data


def _packets(raw: bytes, kind: int) -> Iterator[bytes]:
    """XTF packets of a kind."""
    at = 1024
    while at + 14 <= len(raw):
        magic, found, _, _, _, _, size = struct.unpack_from("<HBBHHHI", raw, at)
        if magic != 0xFACE:
            at += 1
            continue
        if found == kind:
            yield raw[at : at + size]
        at += size


def oculus(folder: Path) -> tuple[Array, Array, float]:
    """An Oculus ping: levels `(rows, beams)` of 8 bits, bearings [deg], and the distance of rows [m]."""
    raw = _bytes(folder / OCULUS)
    (step,) = struct.unpack_from("<d", raw, 98)
    rows, beams, at, *_ = struct.unpack_from("<HHIII", raw, 106)
    bearing = np.frombuffer(raw, "<i2", beams, 122) / 100.0
    return np.frombuffer(raw, np.uint8, rows * beams, at).reshape(rows, beams).astype(float), bearing, step


def r2sonic(folder: Path) -> dict[str, Array]:
    """Soundings of an R2Sonic by ping and beam: `angle` from the array's middle [rad], `range` [m], `intensity` [uPa],
    `phase` (whether found by phase); and of the first ping's header `settings`."""
    found: dict[str, list[Array]] = {"angle": [], "range": [], "intensity": [], "phase": []}
    settings = np.empty(0)
    for packet in _packets(_bytes(folder / R2SONIC), _QINSY_R2SONIC):
        at = packet.find(b"BTH0") + 12
        parts: dict[bytes, bytes] = {}
        while at + 4 <= len(packet):
            name, size = struct.unpack_from(">2sH", packet, at)
            if size == 0 or name[:1] not in b"HRAIGQ":
                break
            parts[name] = packet[at + 4 : at + size]
            at += size
        head = struct.unpack(">12s12sIII9fHh7fIHH", parts[b"H0"][:112])
        count, speed = head[-1], head[6]
        settings = np.array(head[5:14]) if not len(settings) else settings
        (scale,) = struct.unpack_from(">f", parts[b"R0"])
        found["range"].append(np.frombuffer(parts[b"R0"], ">u2", count, 4) * scale * speed / 2)
        first, step = struct.unpack_from(">ff", parts[b"A2"])
        found["angle"].append(first + np.cumsum(np.frombuffer(parts[b"A2"], ">u2", count, 32).astype(float)) * step)
        (scale,) = struct.unpack_from(">f", parts[b"I1"])
        found["intensity"].append(np.frombuffer(parts[b"I1"], ">u2", count, 4) * scale)
        words = np.frombuffer(parts[b"Q0"], ">u4", -(-count // 8))
        flags = ((words[:, None] >> (28 - 4 * np.arange(8))) & 15).ravel()[:count]
        found["phase"].append((flags & 8) > 0)
    return {name: np.array(values) for name, values in found.items()} | {"settings": settings}


def gsf(folder: Path) -> tuple[dict[str, Array], Array]:
    """Soundings of a GSF file by ping and beam: `depth`, `across`, `along` [m], `time` [s], `angle` [deg]; and its
    sound-speed profile `(points, 2)`: depth [m], speed [m/s]."""
    raw, at = (folder / GSF).read_bytes(), 0
    names = {1: ("depth", ">u2"), 2: ("across", ">i2"), 3: ("along", ">i2"), 4: ("time", ">u2"), 5: ("angle", ">i2")}
    pings: dict[str, list[Array]] = {name: [] for name, _ in names.values()}
    scales: dict[int, tuple[int, int]] = {}
    profile = np.empty((0, 2))
    while at + 8 <= len(raw):
        size, word = struct.unpack_from(">II", raw, at)
        at += 12 if word >> 31 else 8
        record, at = raw[at : at + size], at + size
        if word & 0x3FFFFF == 3:
            (count,) = struct.unpack_from(">I", record, 24)
            profile = np.frombuffer(record, ">u4", 2 * count, 28).reshape(-1, 2) / 100.0
        if word & 0x3FFFFF != 2:
            continue
        part = 56
        while part + 4 <= len(record):
            (head,) = struct.unpack_from(">I", record, part)
            body, part = record[part + 4 : part + 4 + (head & 0xFFFFFF)], part + 4 + (head & 0xFFFFFF)
            if head >> 24 == 100:
                rows = struct.iter_unpack(">Iii", body[4:])
                scales = {code >> 24: (factor, offset) for code, factor, offset in rows}
            elif head >> 24 in names:
                name, kind = names[head >> 24]
                factor, offset = scales[head >> 24]
                pings[name].append(np.frombuffer(body, kind) / factor - offset)
    return {name: np.array(values) for name, values in pings.items()}, profile


def speckle(levels: Array, window: tuple[int, int]) -> dict[str, Array | float]:
    """Statistics of levels over their mean in a window about each: `contrast` (deviation over mean), `quantiles` at
    `QUANTILES`, `first` and `second`, the correlation at 0 to `LAGS` - 1 samples along either axis."""
    normal = (levels / uniform_filter(levels, window))[window[0] : -window[0], window[1] : -window[1]]
    normal = normal / normal.mean()
    return {
        "contrast": float(normal.std()),
        "quantiles": np.quantile(normal, QUANTILES),
        "first": correlation(normal, 0),
        "second": correlation(normal, 1),
    }


def correlation(values: Array, axis: int) -> Array:
    """Correlation of values with those 0 to `LAGS` - 1 samples further along an axis."""
    off = np.moveaxis(values - values.mean(), axis, 0)
    return np.array([(off[k:] * off[: len(off) - k]).mean() for k in range(LAGS)]) / (off**2).mean()


def off_the_bottom(depth: Array) -> Array:
    """Soundings' depths `(pings, beams)` less the parabola through 31 neighbours of a ping [m]."""
    return np.asarray(depth - savgol_filter(depth, 31, 2, axis=1))


def robust_deviation(values: Array) -> float:
    """Standard deviation by the median of deviations: false soundings do not count."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))
