"""Water Linked DVL A50 as drivers see it: velocities, dead reckoning, and the commands of its two protocols."""

from __future__ import annotations

import json
import math
from abc import abstractmethod
from dataclasses import replace
from typing import Any, Final

from drjit.scalar import Array4f64

from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.instruments import waterlinked
from pelagos.bridges.instruments.doppler_log import DopplerLog
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.reckoning import Reckoning
from pelagos.bridges.instruments.speaker import SOUND_MPS, Place
from pelagos.math.so3 import multiply

REPORT_NS: Final = 200_000_000
"""Interval of dead-reckoning reports [ns]: 5 Hz, by the protocol's description."""
_LONGEST_COMMAND: Final = 512


class _A50(DopplerLog):
    """Parts of both protocols."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._begun = b""  # a command whose end has not come yet
        self._acoustic = True
        self._way = Reckoning()
        self._told_ns = -REPORT_NS

    def begin(self) -> None:
        """See `Speaker`: reckoning begins where the instrument is."""
        super().begin()
        self._way, self._told_ns = Reckoning(), -REPORT_NS

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `DopplerLog`; an A50 whose sound is off has no velocity to tell, and reckons with its last one."""
        out = self.velocity(dvl) if self._acoustic else b""
        self._way = self._way.after(dvl if self._acoustic else replace(dvl, velocity=None), self.turn())
        if dvl.t_ns - self._told_ns >= REPORT_NS:
            self._told_ns = dvl.t_ns
            out += self.position(self._way)
        return out

    @abstractmethod
    def velocity(self, dvl: DvlVelocity) -> bytes:
        """Reports of a ping."""

    @abstractmethod
    def position(self, way: Reckoning) -> bytes:
        """Report of dead reckoning."""

    def turn(self) -> list[float]:
        """Attitude of the instrument, forward-right-down to north-east-down, (w, x, y, z)."""
        w, x, y, z = self.place.config.q_body_sensor
        turned = multiply(Array4f64(*motion_of(self.place.sim, self.place.agent).attitude), Array4f64(w, x, -y, -z))
        return [float(c) for c in turned]

    def reset_reckoning(self) -> None:
        """Begin to reckon anew, at the next ping."""
        self._way = Reckoning()

    def config(self) -> dict[str, Any]:
        """Its settings, in the order of the protocol."""
        return {
            "speed_of_sound": SOUND_MPS, "mounting_rotation_offset": 0.0, "acoustic_enabled": self._acoustic,
            "dark_mode_enabled": False, "range_mode": "auto", "periodic_cycling_enabled": False,
        }  # fmt: skip

    def set_config(self, wanted: dict[str, Any]) -> str:
        """Change settings, all or none; the trouble, empty where there is none."""
        here, acoustic = self.config(), wanted.get("acoustic_enabled", self._acoustic)
        refused = [key for key, value in wanted.items() if key != "acoustic_enabled" and here.get(key) != value]
        if refused or not isinstance(acoustic, bool):
            return f"fixed by the scenario: {', '.join(refused) or repr(acoustic)}"
        self._acoustic = acoustic
        return ""


class WaterLinkedJson(_A50):
    """See `waterlinked.report` and `waterlinked.position`; answers commands in JSON.

    Attributes:
        bad: bytes that were no command.
    """

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.bad = 0

    def velocity(self, dvl: DvlVelocity) -> bytes:
        """See `_A50`."""
        return waterlinked.report(dvl, self.before_ns)

    def position(self, way: Reckoning) -> bytes:
        """See `_A50`."""
        return waterlinked.position(way)

    def answer(self, raw: bytes) -> bytes:
        """Answers to commands, JSON objects on lines of their own or one after the other."""
        texts, begun = waterlinked.objects(self._begun + raw)
        self._begun = begun[-_LONGEST_COMMAND:]
        self.bad += len(begun) - len(self._begun)
        return b"".join(self._obey(text) for text in texts)

    def _obey(self, text: bytes) -> bytes:
        try:
            said = json.loads(text)
            command, wanted = said["command"], dict(said.get("parameters") or {})
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
            self.bad += len(text)
            return waterlinked.response("", trouble="no command was understood")
        if command == "get_config":
            return waterlinked.response(command, result=self.config())
        if command == "set_config":
            return waterlinked.response(command, trouble=self.set_config(wanted))
        if command == "reset_dead_reckoning":
            self.reset_reckoning()
        elif command != "calibrate_gyro":  # its gyroscopes have no error
            return waterlinked.response(str(command), trouble="this command is not simulated")
        return waterlinked.response(command)


class WaterLinkedSerial(_A50):
    """See `waterlinked.serial_report` and `waterlinked.serial_position`; answers `wc` sentences."""

    def velocity(self, dvl: DvlVelocity) -> bytes:
        """See `_A50`."""
        return waterlinked.serial_report(dvl, self.before_ns) + waterlinked.serial_transducers(dvl)

    def position(self, way: Reckoning) -> bytes:
        """See `_A50`."""
        return waterlinked.serial_position(way)

    def answer(self, raw: bytes) -> bytes:
        """Answers to sentences; `wr?` to what is none of the protocol, `wr!` to a wrong checksum."""
        out = b""
        *lines, begun = (self._begun + raw).replace(b"\r", b"\n").split(b"\n")
        self._begun = begun[-_LONGEST_COMMAND:]
        for line in lines:
            command, star, check = line.strip().partition(b"*")
            if star and check.lower() != b"%02x" % waterlinked.crc8(command):
                out += waterlinked.serial_sentence("wr!")
            elif command:
                out += waterlinked.serial_sentence(self._obey(command.decode("ascii", "replace")))
        return out

    def _obey(self, command: str) -> str:
        if command in ("wcr", "wcg"):  # its gyroscopes have no error
            if command == "wcr":
                self.reset_reckoning()
            return "wra"
        if command == "wcx" or command.startswith("wcp,"):  # a ping is the scenario's; so is the language,
            return "wra" if command == "wcp,3" else "wrn"  # the newest of this protocol
        if command.startswith("wcs,"):
            return self._set(command.split(",")[1:])
        found = self.config()
        told = [
            ("n", "y")[value] if isinstance(value, bool) else f"{value:.2f}" if isinstance(value, float) else str(value)
            for value in found.values()
        ]
        known = {"wcv": "wrv,2,5,0", "wcw": "wrw,dvl-a50,2.5.2,0x0", "wcc": ",".join(["wrc", *told])}
        return known.get(command, "wr?")

    def _set(self, fields: list[str]) -> str:
        """Settings in the order of `config`; empty ones stay, and the last two may be left out."""
        keys = list(self.config())
        if not len(keys) - 2 <= len(fields) <= len(keys):
            return "wr?"
        wanted: dict[str, Any] = {}
        for key, field in zip(keys, fields, strict=False):
            try:
                if field:
                    wanted[key] = _READ[key](field)
            except (ValueError, KeyError):
                return "wr?"
        return "wrn" if self.set_config(wanted) else "wra"


def _number(field: str) -> float:
    value = float(field)
    if not math.isfinite(value):
        raise ValueError(field)
    return value


def _switch(field: str) -> bool:
    return {"y": True, "n": False}[field]


_READ: Final[dict[str, Any]] = {
    "speed_of_sound": _number, "mounting_rotation_offset": _number, "acoustic_enabled": _switch,
    "dark_mode_enabled": _switch, "range_mode": str, "periodic_cycling_enabled": _switch,
}  # fmt: skip
