"""From readings of sensors to an instrument's own language, and from requests to answers."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final, Protocol

import numpy as np

from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.instruments import nmea, nortek, ping, teledyne, vectornav, waterlinked
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.math.constants import ATMOSPHERE_PA, GRAVITY
from pelagos.sim.simulation import Simulation

SOUND_MPS: Final = 1500.0
WATER_KG_M3: Final = 1025.0


@dataclass(frozen=True)
class Place:
    """Where an instrument is: the simulation, its agent, its configuration, and the date at simulation time 0."""

    sim: Simulation
    agent: str
    config: Any
    epoch: datetime


class Speaker(Protocol):
    """One instrument."""

    def hear(self, reading: Any) -> bytes:
        """What it says when its sensor has read."""
        ...

    def answer(self, raw: bytes) -> bytes:
        """What it says to a request."""
        ...


class _Silent:
    """An instrument that takes no requests."""

    def __init__(self, place: Place) -> None:
        self.place = place

    def answer(self, raw: bytes) -> bytes:
        """Nothing."""
        return b""


class NmeaGps(_Silent):
    """GGA, RMC, VTG and HDT of a satellite compass: its heading, course and speed are the true ones."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        at = nmea.clock(reading.t_ns, self.place.epoch)
        motion = motion_of(self.place.sim, self.place.agent)
        latitude, longitude, height = (float(v) for v in reading.data[0])
        north, east, _ = motion.velocity.tolist()
        speed, course = math.hypot(north, east), math.degrees(math.atan2(east, north))
        return (
            nmea.gga(at, latitude, longitude, height)
            + nmea.rmc(at, latitude, longitude, speed, course)
            + nmea.vtg(speed, course)
            + nmea.hdt(math.degrees(motion.euler[2]))
        )


class NmeaSounder(_Silent):
    """DBT of an altimeter."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return nmea.dbt(float(np.asarray(reading.data).ravel()[0]))


class NmeaPressure(_Silent):
    """XDR of a depth gauge: absolute pressure."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        depth = float(np.asarray(reading.data).ravel()[0])
        return nmea.xdr_pressure(ATMOSPHERE_PA + WATER_KG_M3 * GRAVITY * depth)


class _Dvl(_Silent):
    """What all Doppler logs share."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.before_ns = 0
        self.number = 0

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
        return teledyne.Attitude(yaw, pitch, roll, float(motion.position[2]))

    def down(self) -> tuple[float, ...]:
        """The downward part of each beam's direction."""
        return tuple(-float(b[2]) for b in self.place.config.beams)


class WaterLinkedJson(_Dvl):
    """See `waterlinked.report`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return waterlinked.report(dvl, self.before_ns)


class WaterLinkedSerial(_Dvl):
    """See `waterlinked.serial_report`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return waterlinked.serial_report(dvl, self.before_ns)

    def answer(self, raw: bytes) -> bytes:
        """The protocol's version, to `wcv`; anything else is an unknown command."""
        out = b""
        for line in raw.split(b"\n"):
            command = line.strip().partition(b"*")[0]
            if command == b"wcv":
                out += waterlinked.serial_sentence("wrv,2.5.0")
            elif command:
                out += waterlinked.serial_sentence("wr?")
        return out


class Pd0(_Dvl):
    """See `teledyne.pd0`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return teledyne.pd0(dvl, self.place.epoch, self.attitude(), SOUND_MPS, self.number, self.down())


class Pd6(_Dvl):
    """See `teledyne.pd6`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return teledyne.pd6(dvl, self.place.epoch, self.attitude(), SOUND_MPS)


class Nortek(_Dvl):
    """See `nortek.bottom_track`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `_Dvl`."""
        return nortek.bottom_track(dvl, self.place.epoch, self.down())


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


class Ping1d:
    """Blue Robotics Ping: answers requests, and speaks of itself when it was asked to (continuous)."""

    def __init__(self, place: Place) -> None:
        self.place = place
        self._frames = ping.Frames()
        self._number = 0
        self._distance_mm, self._confidence = 0, 0
        self._trace = np.zeros(200, dtype=np.uint8)
        self._span_mm = (300, 50_000)
        self._streams: set[int] = set()
        self._kept: dict[int, bytes] = {
            ping.SPEED_OF_SOUND: struct.pack("<I", round(1000 * SOUND_MPS)),
            ping.RANGE: struct.pack("<II", 300, 49_700),
            ping.MODE_AUTO: b"\1", ping.PING_INTERVAL: struct.pack("<H", 100), ping.GAIN: struct.pack("<I", 3),
            ping.PING_ENABLE: b"\1",
        }  # fmt: skip

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`; of an altimeter the distance, of a single-beam sounder the trace too."""
        data = np.asarray(reading.data[0], dtype=np.float64).ravel()
        c = self.place.config
        self._span_mm = (round(1000 * c.range_min_m), round(1000 * (c.range_max_m - c.range_min_m)))
        self._number += 1
        if len(data) > 1:
            level = np.clip(data, 0.0, 1.0)
            at = np.linspace(0, len(level) - 1, len(self._trace))
            self._trace = np.round(255 * np.interp(at, np.arange(len(level)), level)).astype(np.uint8)
            peak = int(np.argmax(level))
            distance = c.range_min_m + (peak + 0.5) * (c.range_max_m - c.range_min_m) / len(level)
            self._confidence = round(100 * float(level[peak]))
        else:
            distance = float(data[0])
            self._confidence = 100 if math.isfinite(distance) else 0
        self._distance_mm = round(1000 * distance) if math.isfinite(distance) else 0
        return b"".join(self._message(number) for number in sorted(self._streams))

    def answer(self, raw: bytes) -> bytes:
        """See `Speaker`."""
        return b"".join(self._reply(number, payload) for number, payload in self._frames.feed(raw))

    def _reply(self, number: int, payload: bytes) -> bytes:
        known = {ping.DISTANCE_SIMPLE, ping.DISTANCE, ping.PROFILE}
        if number == ping.GENERAL_REQUEST and len(payload) >= 2:
            return self._message(int.from_bytes(payload[:2], "little"))
        if number in (ping.CONTINUOUS_START, ping.CONTINUOUS_STOP) and len(payload) >= 2:
            wanted = int.from_bytes(payload[:2], "little")
            if wanted not in known:
                return ping.refuse(number, "no such stream")
            (self._streams.add if number == ping.CONTINUOUS_START else self._streams.discard)(wanted)
            return ping.acknowledge(number)
        kept = _SETTINGS.get(number)
        if kept is not None and len(payload) == len(self._kept[kept]):
            self._kept[kept] = payload
            return ping.acknowledge(number)
        return self._message(number) if not payload else ping.refuse(number, "unknown message")

    def _message(self, number: int) -> bytes:
        start, length = self._span_mm
        what = (self._distance_mm, self._confidence, self._number, start, length)
        if number == ping.GENERAL_INFO:
            return ping.frame(number, struct.pack("<HHHHBB", 3, 29, 5000, 100, 3, 1))
        if number in self._kept:
            return ping.frame(number, self._kept[number])
        answers: dict[int, Callable[[], bytes]] = {
            ping.DEVICE_INFORMATION: lambda: ping.device_information(ping.PING1D),
            ping.PROTOCOL_VERSION: ping.protocol_version,
            ping.DISTANCE_SIMPLE: lambda: ping.distance_simple(self._distance_mm, self._confidence),
            ping.DISTANCE: lambda: ping.distance(*what),
            ping.PROFILE: lambda: ping.profile(*what, self._trace.tobytes()),
        }
        found = answers.get(number)
        return ping.refuse(number, "unknown message") if found is None else found()


_SETTINGS: Final[Mapping[int, int]] = {
    ping.SET_SPEED_OF_SOUND: ping.SPEED_OF_SOUND, ping.SET_RANGE: ping.RANGE, ping.SET_MODE_AUTO: ping.MODE_AUTO,
    ping.SET_PING_INTERVAL: ping.PING_INTERVAL, ping.SET_GAIN: ping.GAIN, ping.SET_PING_ENABLE: ping.PING_ENABLE,
}  # fmt: skip


class Ping360:
    """Blue Robotics Ping360: the newest trace of the direction that is asked for, over the range that is asked for.

    The head of the sensor turns by its own configuration; a direction that it has not reached yet answers silence.
    """

    def __init__(self, place: Place) -> None:
        self.place = place
        self._frames = ping.Frames()
        self._traces: dict[int, np.ndarray] = {}
        self._last: tuple[int, ...] = (1, 0, 0, 11, 700, 750, 200, 1, 0)

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        angle = float(np.asarray(reading.extras["angle"]).ravel()[0])
        gradian = round(200 - math.degrees(angle) / 0.9) % 400  # clockwise from above; 200 is ahead
        self._traces[gradian] = np.clip(np.asarray(reading.data[0], dtype=np.float64), 0.0, 1.0)
        return b""

    def answer(self, raw: bytes) -> bytes:
        """See `Speaker`."""
        return b"".join(self._reply(number, payload) for number, payload in self._frames.feed(raw))

    def _reply(self, number: int, payload: bytes) -> bytes:
        if number == ping.GENERAL_REQUEST and len(payload) >= 2:
            number, payload = int.from_bytes(payload[:2], "little"), b""
        if number == ping.DEVICE_INFORMATION:
            return ping.device_information(ping.PING360)
        if number == ping.PROTOCOL_VERSION:
            return ping.protocol_version()
        request = ping.transducer_request(payload) if number == ping.TRANSDUCER else None
        if number == ping.DEVICE_DATA:
            request = self._last
        if request is None or request[2] >= 400 or request[6] > 1200:
            return ping.refuse(number, "unknown message")
        self._last = request
        return ping.device_data(request, self._trace(request[2], request[4], request[6]))

    def _trace(self, gradian: int, period: int, samples: int) -> bytes:
        """Levels 0 .. 255 at the samples' distances; each direction shows the nearest one within two gradians."""
        near = [g for step in (0, 1, -1, 2, -2) if (g := (gradian + step) % 400) in self._traces]
        if not near:
            return bytes(samples)
        c, trace = self.place.config, self._traces[near[0]]
        distance = (np.arange(samples) + 0.5) * period * 25e-9 * SOUND_MPS / 2
        middles = c.range_min_m + (np.arange(len(trace)) + 0.5) * (c.range_max_m - c.range_min_m) / len(trace)
        level = np.interp(distance, middles, trace, left=0.0, right=0.0)
        return bytes(np.round(255 * level).astype(np.uint8).tobytes())


SPEAKERS: Final[Mapping[str, Mapping[str, Callable[[Place], Speaker]]]] = {
    "nmea": {"gps": NmeaGps, "altimeter": NmeaSounder, "depth": NmeaPressure},
    "waterlinked": {"dvl": WaterLinkedJson},
    "waterlinked_serial": {"dvl": WaterLinkedSerial},
    "nortek": {"dvl": Nortek},
    "pd0": {"dvl": Pd0},
    "pd6": {"dvl": Pd6},
    "vectornav": {"imu": VectorNavText},
    "vectornav_binary": {"imu": VectorNavBinary},
    "ping1d": {"altimeter": Ping1d, "singlebeam": Ping1d},
    "ping360": {"mechanical_scanning_sonar": Ping360},
}
"""By protocol, and by the type of the sensor that speaks it."""
