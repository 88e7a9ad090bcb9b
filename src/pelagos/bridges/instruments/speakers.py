"""From readings of sensors to an instrument's own language, and from requests to answers."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.instruments import mip, nmea, nortek, teledyne, vectornav, waterlinked
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.instruments.speaker import SOUND_MPS, WATER_KG_M3, Place, Speaker
from pelagos.math.constants import ATMOSPHERE_PA, GRAVITY


class _Silent:
    """An instrument that takes no requests."""

    tells_loss = False

    def __init__(self, place: Place) -> None:
        self.place = place

    def begin(self) -> None:
        """Nothing is kept."""

    def answer(self, raw: bytes) -> bytes:
        """Nothing."""
        return b""


class NmeaGps(_Silent):
    """GGA, RMC, VTG and HDT of a satellite compass: its heading, course and speed are the true ones."""

    tells_loss = True

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`; without a fix GGA and RMC say so, and are all there is."""
        at = nmea.clock(reading.t_ns, self.place.epoch)
        if not reading.valid[0]:
            return nmea.no_fix(at)
        motion = motion_of(self.place.sim, self.place.agent)
        latitude, longitude, height = (float(v) for v in reading.data[0])
        north, east, _ = motion.velocity
        speed, course = math.hypot(north, east), math.degrees(math.atan2(east, north))
        return (
            nmea.gga(at, latitude, longitude, height)
            + nmea.rmc(at, latitude, longitude, speed, course)
            + nmea.vtg(speed, course)
            + nmea.hdt(math.degrees(motion.euler[2]))
        )


class NmeaSounder(_Silent):
    """DBT of an altimeter; its fields are empty without an echo."""

    tells_loss = True

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return nmea.dbt(float(np.asarray(reading.data).ravel()[0]) if reading.valid[0] else None)


class NmeaPressure(_Silent):
    """XDR of a depth gauge: absolute pressure."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        depth = float(np.asarray(reading.data).ravel()[0])
        return nmea.xdr_pressure(ATMOSPHERE_PA + WATER_KG_M3 * GRAVITY * depth)


class _Dvl(_Silent):
    """Parts that all Doppler logs share; they go on without bottom lock, and say that they have none."""

    tells_loss = True

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.before_ns = 0
        self.number = 0

    def begin(self) -> None:
        """See `Speaker`."""
        self.before_ns = self.number = 0

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        self.number += 1
        dvl = DvlVelocity.of(reading, self.place.config.beams)
        raw = self.say(dvl)
        self.before_ns = dvl.t_ns
        return raw

    def say(self, dvl: DvlVelocity) -> bytes:
        """In this log's language."""
        raise NotImplementedError

    def attitude(self) -> teledyne.Attitude:
        """By the log's own compass and inclinometers."""
        motion = motion_of(self.place.sim, self.place.agent)
        roll, pitch, yaw = (math.degrees(a) for a in motion.euler)
        return teledyne.Attitude(yaw, pitch, roll, motion.position[2])

    def down(self) -> tuple[float, ...]:
        """The downward part of each beam's direction."""
        return tuple(-float(b[2]) for b in self.place.config.beams)


class WaterLinkedJson(_Dvl):
    """See `waterlinked.report`; it answers `get_config` and `set_config`, which switches its sound on and off.

    Attributes:
        bad: bytes that were no command.
    """

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._begun = b""  # a command whose end has not come yet
        self._acoustic = True
        self.bad = 0

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return waterlinked.report(dvl, self.before_ns) if self._acoustic else b""

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
            return waterlinked.response(command, result=self._config())
        if command != "set_config":
            return waterlinked.response(str(command), trouble="this command is not simulated")
        others = {key: value for key, value in wanted.items() if key != "acoustic_enabled"}
        here, acoustic = self._config(), wanted.get("acoustic_enabled", self._acoustic)
        refused = [key for key, value in others.items() if here.get(key) != value]
        if refused or not isinstance(acoustic, bool):
            return waterlinked.response(command, trouble=f"fixed by the scenario: {', '.join(refused) or acoustic!r}")
        self._acoustic = acoustic
        return waterlinked.response(command)

    def _config(self) -> dict[str, Any]:
        return {
            "speed_of_sound": SOUND_MPS, "acoustic_enabled": self._acoustic, "dark_mode_enabled": False,
            "mounting_rotation_offset": 0.0, "range_mode": "auto", "periodic_cycling_enabled": False,
        }  # fmt: skip


_LONGEST_COMMAND: Final = 512


class WaterLinkedSerial(_Dvl):
    """See `waterlinked.serial_report`."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._begun = b""  # a command whose end has not come yet

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return waterlinked.serial_report(dvl, self.before_ns)

    def answer(self, raw: bytes) -> bytes:
        """The protocol's version, to `wcv`; anything else is an unknown command, or has a wrong checksum."""
        out = b""
        *lines, begun = (self._begun + raw).replace(b"\r", b"\n").split(b"\n")
        self._begun = begun[-_LONGEST_COMMAND:]
        for line in lines:
            command, star, check = line.strip().partition(b"*")
            if star and check.lower() != b"%02x" % waterlinked.crc8(command):
                out += waterlinked.serial_sentence("wr!")
            elif command == b"wcv":
                out += waterlinked.serial_sentence("wrv,2,5,0")
            elif command:
                out += waterlinked.serial_sentence("wr?")
        return out


class Pd0(_Dvl):
    """See `teledyne.pd0`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return teledyne.pd0(dvl, self.place.epoch, self.attitude(), SOUND_MPS, self.number, self.down())


class Pd6(_Dvl):
    """See `teledyne.pd6`; it adds up the distance made good over ground."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._made_good = teledyne.MadeGood()

    def begin(self) -> None:
        """See `Speaker`: nothing has been made good yet."""
        super().begin()
        self._made_good = teledyne.MadeGood()

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        attitude = self.attitude()
        self._made_good = self._made_good.after(dvl, attitude)
        return teledyne.pd6(dvl, self.place.epoch, attitude, SOUND_MPS, self._made_good)


class Nortek(_Dvl):
    """See `nortek.bottom_track`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return nortek.bottom_track(dvl, self.place.epoch, self.down())


class Mip(_Silent):
    """See `mip.inertial`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return mip.inertial(reading.t_ns, *_force_and_rate(reading))


class VectorNavText(_Silent):
    """See `vectornav.text`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return vectornav.text(*_force_and_rate(reading))


class VectorNavBinary(_Silent):
    """See `vectornav.binary`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return vectornav.binary(reading.t_ns, *_force_and_rate(reading))


def _force_and_rate(reading: Any) -> tuple[list[float], list[float]]:
    """Forward, right, down."""
    x, y, z, p, q, r = (float(v) for v in reading.data[0])
    return [x, -y, -z], [p, -q, -r]


SPEAKERS: Final[Mapping[str, Mapping[str, Callable[[Place], Speaker]]]] = {
    "nmea": {"gps": NmeaGps, "altimeter": NmeaSounder, "depth": NmeaPressure},
    "waterlinked": {"dvl": WaterLinkedJson},
    "waterlinked_serial": {"dvl": WaterLinkedSerial},
    "nortek": {"dvl": Nortek},
    "pd0": {"dvl": Pd0},
    "pd6": {"dvl": Pd6},
    "mip": {"imu": Mip},
    "vectornav": {"imu": VectorNavText},
    "vectornav_binary": {"imu": VectorNavBinary},
    "ping1d": {"altimeter": Ping1d, "singlebeam": Ping1d},
    "ping360": {"mechanical_scanning_sonar": Ping360},
}
"""By protocol, and by the type of the sensor that speaks it."""
