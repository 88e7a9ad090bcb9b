"""A radio link above the water, of the Wi-Fi kind: fast, and gone when an antenna is submerged."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.sensors.comms.link.carrier import Radio
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.reading import read_port
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_THERMAL_DBM_HZ = -174.0


class RadioConfig(SensorConfig):
    """Antenna, transmitter and packets; figures where not given are those of 2.4 GHz Wi-Fi with 100 mW."""

    STANDS: ClassVar[str] = "antenna"
    type: Literal["radio"] = "radio"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Looks at the queue, and readings, per second [Hz]; must divide the tick rate."""
    address: int | None = Field(default=None, ge=0, le=65535)
    """Its address among all modems; the next free one where not given."""
    carrier_hz: float = Field(default=2.44e9, gt=0)
    """[Hz]."""
    power_dbm: float = Field(default=22.0, ge=-50, le=70)
    """Sent, with the antenna's gain [dB re 1 mW]."""
    noise_figure_db: float = Field(default=8.0, ge=0, le=50)
    """Of the receiver, with what its surroundings add [dB]."""
    bit_rate_bps: float = Field(default=6e6, gt=0)
    """Bits per second [bit/s]."""
    packet_max_bytes: int = Field(default=1500, ge=1, le=65536)
    """Longest payload [bytes]."""
    queue: int = Field(default=256, ge=1, le=10_000)
    """Packets that may wait."""


class RadioLink:
    """Packets by radio: `sim.send("usv0", "radio", b"...", to=...)`, and `reading.packets`; see `Modem`.

    Reading: `data` `(n, 5)` and extras as of a modem; levels [dB re 1 mW]. Antennas under a wave hear nothing.
    """

    Config: ClassVar[type[SensorConfig]] = RadioConfig
    TITLE: ClassVar[str] = "Radio link above the water, of the Wi-Fi kind"
    KERNELS: ClassVar[int] = 6
    CASTS: ClassVar[int] = 0
    EVENTS: ClassVar[bool] = True
    ONE_VEHICLE: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "T. S. Rappaport, Wireless Communications, 2nd ed., 2002, Sections 4.2 and 4.6 (two rays)",
    )

    def __init__(self, config: RadioConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        noise = _THERMAL_DBM_HZ + config.noise_figure_db + 10.0 * math.log10(config.bit_rate_bps)
        self._radio = Radio(context.world, context.ocean, config.carrier_hz, config.power_dbm, noise, context.own_body)
        if context.medium is not None:
            context.medium.add(
                radio_port(self._context, config, self._radio, config.packet_max_bytes, config.queue), context
            )

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the link on every lane of `motion`."""
        return read_port(self._context, len(motion.tick))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Noise of the receiver: (name, values, unit)."""
        return [("noise", np.array([self._radio.noise()]), "dB re 1 mW")]


def radio_port(context: SensorContext, config: Any, radio: Radio, longest: int, queue: int) -> ModemPort:
    """A radio as its fellows see it."""
    return ModemPort(
        path=context.path, mount=config, period=period_ticks(config.rate_hz, context.dt_ns),
        address=-1 if config.address is None else config.address, frequency_hz=config.carrier_hz,
        bandwidth_hz=config.bit_rate_bps, bit_rate_bps=config.bit_rate_bps, modulation="qpsk", chirp_order=2,
        source_level_db=0.0, coding_gain_db=3.0, multipath_window_s=1.0, preamble_s=1e-4, packet_max_bytes=longest,
        detection_db=0.0, noise_db=0.0, queue=queue, mac="none", slots=1, slot_s=1.0, guard_s=0.0, retries=0,
        acknowledge=False, timeout_s=1.0, turnaround_s=0.0, sound_speed_mps=1500.0, clock_offset_std_s=0.0,
        clock_drift_std_ppm=0.0, beacon_s=None, beacon_to="*", beacon_bytes=0, carrier=radio, kind="radio",
    )  # fmt: skip
