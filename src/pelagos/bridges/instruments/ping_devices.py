"""Blue Robotics' sonars, which answer requests: Ping1D and Ping360."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.bridges.instruments import ping
from pelagos.bridges.instruments.speaker import SOUND_MPS, Place

POINTS: Final = 200
"""Of a Ping1D's profile."""


@dataclass(frozen=True)
class Setting:
    """Value that a driver may set: the message that asks for it, its packing, and the packing that sets it."""

    told: int
    packing: str
    set_packing: str


SETTINGS: Final[Mapping[int, Setting]] = {
    ping.SET_DEVICE_ID: Setting(ping.DEVICE_ID, "<B", "<B"),
    ping.SET_RANGE: Setting(ping.RANGE, "<II", "<II"),
    ping.SET_SPEED_OF_SOUND: Setting(ping.SPEED_OF_SOUND, "<I", "<I"),
    ping.SET_MODE_AUTO: Setting(ping.MODE_AUTO, "<B", "<B"),
    ping.SET_PING_INTERVAL: Setting(ping.PING_INTERVAL, "<H", "<H"),
    ping.SET_GAIN: Setting(ping.GAIN, "<I", "<B"),
    ping.SET_PING_ENABLE: Setting(ping.PING_ENABLE, "<B", "<B"),
}
HIGHEST_GAIN: Final = 6


class Ping1d:
    """Blue Robotics Ping: answers requests, and speaks of itself when it was asked to (continuous).

    The speed of sound that a driver sets scales what it reads, the interval and the switch say when it measures. In
    manual mode the range cuts the profile, and an echo beyond it is none. The gain is kept and told; it changes nothing
    in a trace of 8 bits.
    """

    tells_loss = True

    def __init__(self, place: Place) -> None:
        self.place = place
        c = place.config
        self._frames = ping.Frames()
        self._number = 0
        self._distance_m, self._confidence = math.nan, 0
        self._echo = np.zeros(1)  # 0 .. 1, over the range of the scenario's sonar
        self._measured_ns: int | None = None
        self._streams: set[int] = set()
        self._widest = (round(1000 * c.range_min_m), round(1000 * (c.range_max_m - c.range_min_m)))
        self._kept: dict[int, tuple[int, ...]] = {
            ping.DEVICE_ID: (1,), ping.RANGE: self._widest, ping.SPEED_OF_SOUND: (round(1000 * SOUND_MPS),),
            ping.MODE_AUTO: (1,), ping.PING_INTERVAL: (_interval_ms(c.rate_hz),), ping.GAIN: (3,),
            ping.PING_ENABLE: (1,),
        }  # fmt: skip

    @property
    def bad(self) -> int:
        """Bytes that were no request."""
        return self._frames.bad

    def begin(self) -> None:
        """See `Speaker`: what a driver has set stays."""
        self._measured_ns, self._number = None, 0

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`; of an altimeter the distance, of a single-beam sounder the trace too."""
        due = self._measured_ns is None or (
            reading.t_ns - self._measured_ns >= 1_000_000 * self._kept[ping.PING_INTERVAL][0]
        )
        if not self._kept[ping.PING_ENABLE][0] or not due:
            return b""
        self._measured_ns = reading.t_ns
        self._number += 1
        data = np.asarray(reading.data[0], dtype=np.float64).ravel()
        if len(data) > 1:
            self._echo = np.clip(data, 0.0, 1.0)
            peak = int(np.argmax(self._echo))
            self._distance_m = float(self._ranges()[peak])
            self._confidence = round(100 * float(self._echo[peak]))
        else:
            self._distance_m = float(data[0])
            self._confidence = 100 if math.isfinite(self._distance_m) else 0
        return b"".join(self._message(number) for number in sorted(self._streams))

    def answer(self, raw: bytes) -> bytes:
        """See `Speaker`."""
        return b"".join(self._reply(number, payload) for number, payload in self._frames.feed(raw))

    def _ranges(self) -> NDArray[np.float64]:
        """Middle of each bin of the scenario's sonar [m]."""
        c = self.place.config
        step = (c.range_max_m - c.range_min_m) / len(self._echo)
        return np.asarray(c.range_min_m + (np.arange(len(self._echo)) + 0.5) * step)

    def _reply(self, number: int, payload: bytes) -> bytes:
        if number == ping.GENERAL_REQUEST and len(payload) >= 2:
            return self._message(int.from_bytes(payload[:2], "little"))
        if number in (ping.CONTINUOUS_START, ping.CONTINUOUS_STOP) and len(payload) >= 2:
            wanted = int.from_bytes(payload[:2], "little")
            if wanted not in (ping.DISTANCE_SIMPLE, ping.DISTANCE, ping.PROFILE):
                return ping.refuse(number, "no such stream")
            (self._streams.add if number == ping.CONTINUOUS_START else self._streams.discard)(wanted)
            return ping.acknowledge(number)
        if number in SETTINGS:
            return self._set(number, payload)
        return self._message(number) if not payload else ping.refuse(number, "unknown message")

    def _set(self, number: int, payload: bytes) -> bytes:
        setting = SETTINGS[number]
        if len(payload) != struct.calcsize(setting.set_packing):
            return ping.refuse(number, "wrong length")
        values = struct.unpack(setting.set_packing, payload)
        if number == ping.SET_GAIN and values[0] > HIGHEST_GAIN:
            return ping.refuse(number, "gain is 0 to 6")
        if number in (ping.SET_MODE_AUTO, ping.SET_PING_ENABLE) and values[0] > 1:
            return ping.refuse(number, "0 or 1")
        if number == ping.SET_SPEED_OF_SOUND and not 1e6 <= values[0] <= 2e6:
            return ping.refuse(number, "mm/s, 1e6 to 2e6")
        if number == ping.SET_RANGE and values[1] == 0:
            return ping.refuse(number, "a length above 0")
        self._kept[setting.told] = values
        return ping.acknowledge(number)

    def _seen(self) -> tuple[int, int, int, int, int]:
        """Distance [mm], confidence [%], number, start and length of the scan [mm], as the device would tell them."""
        scale = self._kept[ping.SPEED_OF_SOUND][0] / (1000 * SOUND_MPS)
        auto = bool(self._kept[ping.MODE_AUTO][0])
        start, length = self._widest if auto else self._kept[ping.RANGE]
        distance = 1000 * scale * self._distance_m
        heard = math.isfinite(distance) and (auto or start <= distance <= start + length)
        return round(distance) if heard else 0, self._confidence if heard else 0, self._number, start, length

    def _profile(self) -> bytes:
        """Levels 0 .. 255 at `POINTS` places of the scan."""
        *_, start, length = self._seen()
        scale = self._kept[ping.SPEED_OF_SOUND][0] / (1000 * SOUND_MPS)
        at = (start + (np.arange(POINTS) + 0.5) * length / POINTS) / (1000 * scale)
        level = np.interp(at, self._ranges(), self._echo, left=0.0, right=0.0)
        return bytes(np.round(255 * level).astype(np.uint8).tobytes())

    def _message(self, number: int) -> bytes:
        for setting in SETTINGS.values():
            if setting.told == number:
                return ping.frame(number, struct.pack(setting.packing, *self._kept[number]))
        seen = self._seen()
        gain = self._kept[ping.GAIN][0]
        general = (*_FIRMWARE, _MILLIVOLT, self._kept[ping.PING_INTERVAL][0], gain, self._kept[ping.MODE_AUTO][0])
        answers: dict[int, Callable[[], bytes]] = {
            ping.DEVICE_INFORMATION: lambda: ping.device_information(ping.PING1D),
            ping.PROTOCOL_VERSION: ping.protocol_version,
            ping.FIRMWARE_VERSION: lambda: ping.frame(number, struct.pack("<BBHH", ping.PING1D, 1, *_FIRMWARE)),
            ping.VOLTAGE_5: lambda: ping.frame(number, struct.pack("<H", _MILLIVOLT)),
            ping.PROCESSOR_TEMPERATURE: lambda: ping.frame(number, struct.pack("<H", _CENTIDEGREES)),
            ping.BOARD_TEMPERATURE: lambda: ping.frame(number, struct.pack("<H", _CENTIDEGREES)),
            ping.TRANSMIT_DURATION: lambda: ping.frame(number, struct.pack("<H", ping.PULSE_US)),
            ping.GENERAL_INFO: lambda: ping.frame(number, struct.pack("<HHHHBB", *general)),
            ping.DISTANCE_SIMPLE: lambda: ping.distance_simple(*seen[:2]),
            ping.DISTANCE: lambda: ping.distance(*seen, gain=gain),
            ping.PROFILE: lambda: ping.profile(*seen, self._profile(), gain=gain),
        }
        found = answers.get(number)
        return ping.refuse(number, "unknown message") if found is None else found()


_FIRMWARE: Final = (3, 29)
_MILLIVOLT: Final = 5000
_CENTIDEGREES: Final = 2500


def _interval_ms(rate_hz: float) -> int:
    """Time between two readings of the scenario's sonar, rounded down: a longer one would leave readings out."""
    return min(math.floor(1000 / rate_hz), 0xFFFF)


class Ping360:
    """Blue Robotics Ping360: the newest trace of the direction that is asked for, over the range that is asked for.

    The head of the sensor turns by its own configuration; a direction that it has not reached yet answers silence.
    Gain, pulse and frequency are those of the scenario's sonar: a request's own are told back.
    """

    tells_loss = False

    def __init__(self, place: Place) -> None:
        self.place = place
        self._frames = ping.Frames()
        self._traces: dict[int, NDArray[np.float64]] = {}
        self._last: tuple[int, ...] = (1, 0, 0, 11, 700, 750, 200, 1, 0)

    @property
    def bad(self) -> int:
        """Bytes that were no request."""
        return self._frames.bad

    def begin(self) -> None:
        """See `Speaker`: no direction has been reached yet."""
        self._traces.clear()

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
        if number == ping.MOTOR_OFF:
            return ping.acknowledge(number)
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
