"""Keys of a simulated sensor's configuration that figures of noise go to, and their units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pydantic import BaseModel

from pelagos.config.described import descriptions
from pelagos.config.registry import entries, find
from pelagos.config.unit import UNITS as SUFFIXES
from pelagos.errors import InputError, LookupFailed
from pelagos.identification.noise import BeamNoise, SensorNoise, keys_of
from pelagos.math.constants import STANDARD_GRAVITY
from pelagos.math.units import LENGTHS, SPEEDS

_DEGREE: Final = math.pi / 180
COLUMN_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": _DEGREE, "deg/h": _DEGREE / 3600},
    "m/s^2": {"m/s^2": 1.0, "m/s2": 1.0, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY},
    "T": {"T": 1.0, "mT": 1e-3, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7},
    "m": {unit: LENGTHS[unit] for unit in ("m", "cm", "mm")},
    "m/s": {unit: SPEEDS[unit] for unit in ("m/s", "cm/s", "mm/s", "kn")},
    "S/m": {"S/m": 1.0, "mS/cm": 0.1, "uS/cm": 1e-4},
    "dbar": {"dbar": 1.0, "bar": 10.0, "mbar": 1e-2, "kPa": 0.1, "Pa": 1e-4},
}
"""Factors from units that columns may have, by the unit of the configuration."""
_DENSITY: Final = "noise_density"
_PER: Final = {_DENSITY: "/sqrt(Hz)", "bias_instability": "", "random_walk": "/sqrt(s)", "resolution": ""}


@dataclass(frozen=True)
class NoisyQuantity:
    """A reading of a sensor: type of the sensor, prefix of its keys, its unit, and the keys by term."""

    sensor: str
    prefix: str
    unit: str
    keys: Mapping[str, str]

    def factor(self, unit: str) -> float:
        """From a column's unit; empty: the configuration's own.

        Raises:
            LookupFailed: a reading of this kind has no such unit.
        """
        known = COLUMN_UNITS.get(self.unit, {self.unit: 1.0})
        if unit and unit not in known:
            raise LookupFailed("unit", unit, known, where=f"{self.sensor} in {self.unit}")
        return known[unit] if unit else 1.0


def reading_of(prefix: str, sensor: str = "") -> NoisyQuantity:
    """The reading whose noise has keys with a prefix, such as `gyroscope_` of the `imu`.

    Args:
        prefix: of the keys; sensor: type of the sensor; left out, the prefix tells it.

    Raises:
        LookupFailed: no sensor has such keys, or this one has not; or there is no such sensor.
        InputError: this sensor has no such noise.
    """
    if sensor:
        found = _readings(sensor, find("sensor", sensor).config)
        if not found:
            raise InputError(f"sensor {sensor}: its configuration has no key for a noise density")
        if not prefix and len(found) == 1:
            return next(iter(found.values()))
        if not prefix:
            raise InputError(f"sensor {sensor} has several readings: say --prefix {' or '.join(found)}")
    else:
        each = (_readings(name, entry.config) for name, entry in entries("sensor", plugins=False).items())
        found = {prefix: reading for readings in each for prefix, reading in readings.items() if prefix}
    if prefix not in found:
        raise LookupFailed("prefix", prefix, found, where=f"sensor {sensor}" if sensor else "")
    return found[prefix]


def _readings(sensor: str, config: type[BaseModel]) -> dict[str, NoisyQuantity]:
    """Readings of a sensor by the prefix of their keys."""
    found = {}
    for name in config.model_fields:
        if not name.endswith(_DENSITY):
            continue
        prefix, told = name.removesuffix(_DENSITY), descriptions(config).get(name, "")
        of = re.search(r"\[(.*)/sqrt\(Hz\)\]", told)
        keys = {term: key for term in _PER if (key := _key(config, prefix + term))}
        found[prefix] = NoisyQuantity(sensor, prefix, of[1] if of else "", keys)
    return found


def _key(config: type[BaseModel], name: str) -> str:
    """A key with its unit at the end, such as `resolution_t`, or without; empty where there is none."""
    for key in config.model_fields:
        if key == name or (key.startswith(f"{name}_") and key.removeprefix(f"{name}_") in SUFFIXES):
            return key
    return ""


@dataclass(frozen=True)
class KeyLine:
    """A figure with the key that it goes to and its unit; `note` says what is to be known besides.

    Attributes:
        key: of the sensor's configuration; empty: it has none.
        value: None: the record does not tell.
        unit: "1" of a ratio.
    """

    key: str
    value: float | None
    unit: str
    note: str = ""

    @property
    def line(self) -> str:
        """A line of YAML; a comment where there is no value for it."""
        if self.value is None or not self.key:
            return f"# {self.key + ': ' if self.key else ''}{self.note}"
        return f"{self.key}: {self.value:.4g}  # [{self.unit}]" + (f" {self.note}" if self.note else "")


def keys_at_rest(found: Mapping[str, SensorNoise], reading: NoisyQuantity) -> list[KeyLine]:
    """Keys of a sensor at rest, by its axes: root mean squares, 0 for what no axis shows."""
    made = []
    for term, value in keys_of(found, "").items():
        unit = reading.unit + _PER[term]
        key = reading.keys.get(term, "")
        if key:
            made.append(KeyLine(key, value, unit, "" if value else "not seen" if term != "resolution" else "none seen"))
        elif value:
            told = f"{term.replace('_', ' ')} {value:.4g} [{unit}]: {reading.sensor} has no key for it"
            made.append(KeyLine("", None, unit, told))
    return made


def keys_of_beams(found: BeamNoise) -> list[KeyLine]:
    """Keys of a `dvl`; without a value where the record does not tell one."""
    made = []
    for key, value, most, unit in (
        ("noise_mps", found.noise_mps, found.most_mps, "m/s"),
        ("noise_relative", found.noise_relative, found.most_relative, "1"),
    ):
        note = f"not seen at {found.speed_mps:.2g} m/s along the beams, below {most:.2g} [{unit}]"
        made.append(KeyLine(key, value or None, unit, "" if value else note))
    return made
