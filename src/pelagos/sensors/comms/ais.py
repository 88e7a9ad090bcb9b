"""AIS: ships and buoys that tell by VHF where they are, as NMEA sentences."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from pelagos.config.rate import Rate
from pelagos.errors import ScenarioError
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.math.units import KNOT
from pelagos.sensors.comms.link.carrier import Radio
from pelagos.sensors.comms.link.medium import ModemPose
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.reading import read_port
from pelagos.sensors.comms.radio import radio_port
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_STATIC_S: Final = 360.0  # between two messages of static data
_NO_SECOND: Final = 60  # of the minute: a simulation has no calendar
_NO_TURN: Final = -128  # no turn indicator
_NOISE_DBM: Final = -119.0  # 25 kHz, noise figure 11 dB


class AisConfig(SensorConfig):
    """A transponder of class A or B."""

    STANDS: ClassVar[str] = "antenna"
    type: Literal["ais"] = "ais"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Looks at the clock, and readings, per second [Hz]; must divide the tick rate."""
    address: int | None = Field(default=None, ge=0, le=65535)
    """Its address among all modems; the next free one where not given."""
    mmsi: int | None = Field(default=None, ge=100_000_000, le=999_999_999)
    """Its number of nine digits; the next free one from 200000000 on, which no country has, where not given."""
    ais_class: Literal["A", "B"] = "A"
    """A: messages 1 and 5 with 12.5 W, B: messages 18 and 24 with 2 W."""
    name: str = Field(default="PELAGOS", min_length=1, max_length=20)
    """Of the ship; sent in upper case, in the 64 characters of AIS."""
    ship_type: int = Field(default=0, ge=0, le=99)
    """By ITU-R M.1371, Table 53."""
    length_m: int = Field(default=0, ge=0, le=511)
    """Of the ship [m]."""
    beam_m: int = Field(default=0, ge=0, le=63)
    """Of the ship [m]."""
    carrier_hz: float = Field(default=162.0e6, gt=0)
    """[Hz]."""
    bit_rate_bps: float = Field(default=9600.0, gt=0)
    """[bit/s]."""

    @field_validator("name")
    @classmethod
    def _six_bits(cls, name: str) -> str:
        """Only what six bits can say."""
        strange = sorted({c for c in name.upper() if not " " <= c <= "_"})
        if strange:
            raise ValueError(f"AIS has no character {' '.join(strange)}; it has A-Z, 0-9 and most of ASCII's signs")
        return name


class Ais:
    """Position reports and static data, sent by themselves at the intervals of ITU-R M.1371; those of others received.

    Reading: as of a radio; the payload of each packet is one NMEA sentence or several, one a line. Needs the package
    `pyais` (`pip install pelagos[communication]`).
    """

    Config: ClassVar[type[SensorConfig]] = AisConfig
    TITLE: ClassVar[str] = "AIS transponder: positions of ships as NMEA, by VHF"
    KERNELS: ClassVar[int] = 6
    CASTS: ClassVar[int] = 0
    EVENTS: ClassVar[bool] = True
    ONE_VEHICLE: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "ITU-R M.1371-5 (2014), Annex 1 (intervals), Annex 8 (messages)",
        "T. S. Rappaport, Wireless Communications, 2nd ed., 2002, Sections 4.2 and 4.6 (two rays)",
    )

    def __init__(self, config: AisConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        q = np.array([config.q_body_sensor])
        self._bow = rotate_back_np(q, np.array([[1.0, 0.0, 0.0]]))  # the ship's, in the antenna's frame
        try:
            import pyais
        except ImportError:
            raise ScenarioError("ais needs the package pyais; pip install 'pelagos[communication]'") from None
        self._encode = pyais.encode_dict
        power = 41.0 if config.ais_class == "A" else 33.0
        radio = Radio(context.world, context.ocean, config.carrier_hz, power, _NOISE_DBM, context.own_body)
        self._noise = radio.noise()
        if context.medium is not None:
            port = radio_port(context, config, radio, 1024, 16)
            context.medium.add(replace(port, report=self._report, mmsi=config.mmsi or 0), context)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the transponder on every lane of `motion`."""
        return read_port(self._context, len(motion.tick))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Noise of the receiver: (name, values, unit)."""
        return [("noise", np.array([self._noise]), "dB re 1 mW")]

    def _report(self, port: ModemPort, pose: ModemPose, copy: int, count: int) -> tuple[bytes, float]:
        """Next report, and the time until the one after [s]; static data first, and every six minutes."""
        speed = float(np.hypot(*pose.velocity[copy, :2])) / KNOT
        pause = reporting_interval(speed, self._config.ais_class)
        every = max(round(_STATIC_S / pause), 1)
        data = self._static() if count % every == 0 else [self._position(pose, copy, speed)]
        data = [{"mmsi": port.mmsi, **message} for message in data]
        channel, number = "AB"[count % 2], count % 10
        lines = [
            line for message in data
            for line in self._encode(
                message, talker_id="AI", sentence_type="VDM", radio_channel=channel, seq_id=number
            )
        ]  # fmt: skip
        return "\n".join(lines).encode(), pause

    def _position(self, pose: ModemPose, copy: int, speed: float) -> dict[str, Any]:
        """Message 1 or 18."""
        place = self._context.world.origin.to_geodetic(pose.position[copy : copy + 1])[0]
        velocity, ahead = pose.velocity[copy], rotate_np(pose.attitude[copy : copy + 1], self._bow)[0]
        return {
            "msg_type": 1 if self._config.ais_class == "A" else 18,
            "lat": float(place[0]),
            "lon": float(place[1]),
            "speed": min(round(speed, 1), 102.2),  # pyais cuts off
            "course": round(math.degrees(math.atan2(-velocity[1], velocity[0])), 1) % 360.0,  # 360 is none
            "heading": round(math.degrees(math.atan2(-ahead[1], ahead[0])) % 360.0) % 360,
            "accuracy": 1,
            "second": _NO_SECOND,
            **({"turn": _NO_TURN} if self._config.ais_class == "A" else {}),
        }

    def _static(self) -> list[dict[str, Any]]:
        """Message 5, or both parts of message 24."""
        c = self._config
        bow, port = c.length_m // 2, c.beam_m // 2
        size = {"to_bow": bow, "to_stern": c.length_m - bow, "to_port": port, "to_starboard": c.beam_m - port}
        if c.ais_class == "A":
            return [{"msg_type": 5, "shipname": c.name.upper(), "ship_type": c.ship_type, **size}]
        return [
            {"msg_type": 24, "partno": 0, "shipname": c.name.upper()},
            {"msg_type": 24, "partno": 1, "ship_type": c.ship_type, **size},
        ]


def reporting_interval(speed: float, ais_class: str) -> float:
    """Time between two position reports [s] at a speed over ground [kn], by ITU-R M.1371-5, Annex 1, Tables 1 and 2."""
    if ais_class == "A":
        return 10.0 if speed <= 14.0 else 6.0 if speed <= 23.0 else 2.0
    return 180.0 if speed <= 2.0 else 30.0
