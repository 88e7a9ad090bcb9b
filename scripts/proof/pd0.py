"""Ensembles of Teledyne RDI's output format PD0 (WorkHorse Commands and Output Data Format, P/N 957-6156)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NONE: Final = -32768  # a velocity that is not known
LEADER, VARIABLE, VELOCITY, TRACK, NMEA = 0x0000, 0x0080, 0x0100, 0x0600, 0x2022
_GGA, _VTG = 104, 105  # kinds of NMEA records, after WinRiver II


@dataclass(frozen=True)
class Ensemble:
    """One ensemble.

    Attributes:
        raw: its bytes, without the checksum; places: where each data type begins, by its number, in order.
    """

    raw: bytes
    places: tuple[tuple[int, int], ...]

    def take(self, layout: str, kind: int, offset: int) -> tuple[Any, ...]:
        """Values of a layout, as `struct` writes it, at an offset in the first data type of a kind."""
        return struct.unpack_from("<" + layout, self.raw, dict(reversed(self.places))[kind] + offset)


def ensembles(raw: bytes) -> Iterator[Ensemble]:
    """Ensembles with a right checksum."""
    at = raw.find(b"\x7f\x7f")
    while at >= 0:
        size = struct.unpack_from("<H", raw, at + 2)[0] if at + 4 <= len(raw) else 0
        whole = size and at + size + 2 <= len(raw)
        if whole and struct.unpack_from("<H", raw, at + size)[0] == sum(raw[at : at + size]) & 0xFFFF:
            e = raw[at : at + size]
            places = [(struct.unpack_from("<H", e, o)[0], o) for o in struct.unpack_from(f"<{e[5]}H", e, 6)]
            yield Ensemble(e, tuple(places))
            at += size
        at = raw.find(b"\x7f\x7f", at + 2)


def velocities(values: Any) -> Array:
    """Recorded velocities [mm/s] in m/s, NaN where not known."""
    found = np.asarray(values, dtype=np.float64)
    return np.where(found == NONE, np.nan, found / 1000)


def water(ensemble: Ensemble, cells: int) -> Array:
    """`(cells, 4)` velocities of the water, the fourth the error velocity [m/s]."""
    return velocities(ensemble.take(f"{4 * cells}h", VELOCITY, 2)).reshape(cells, 4)


def fixes(ensemble: Ensemble) -> Iterator[tuple[float, float, float]]:
    """Age at the ensemble's time [s], latitude and longitude [deg] of each GGA record."""
    for age, body in _records(ensemble, _GGA):
        (latitude,), (longitude,) = struct.unpack_from("<d", body, 17), struct.unpack_from("<d", body, 26)
        yield age, latitude if body[25:26] == b"N" else -latitude, longitude if body[34:35] == b"E" else -longitude


def ways(ensemble: Ensemble) -> Iterator[tuple[float, float, float, float]]:
    """Age [s], true and magnetic track [deg] and speed over ground [m/s] of each VTG record."""
    for age, body in _records(ensemble, _VTG):
        true, magnetic, speed = (struct.unpack_from("<f", body, at)[0] for at in (7, 12, 22))
        yield age, true, magnetic, speed / 3.6


def _records(ensemble: Ensemble, kind: int) -> Iterator[tuple[float, bytes]]:
    for number, at in ensemble.places:
        if number == NMEA:
            found, size, age = struct.unpack_from("<HHd", ensemble.raw, at + 2)
            if found == kind:
                yield age, ensemble.raw[at + 14 : at + 14 + size]
