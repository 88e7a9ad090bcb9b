"""An optical modem: packets by light under water, along a line of sight, as far as the water is clear."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.sensors.comms.link.carrier import Light
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.reading import read_port
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_HERTZ: Final = 6.0e14  # of the light; only ends of one colour hear each other
_COLOURS: Final = ("red", "green", "blue")


class OpticalModemConfig(SensorConfig):
    """Lamp, receiver and packets; figures where not given are those of a blue LED modem of 50 m in clear water."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["optical_modem"] = "optical_modem"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Looks at the queue, and readings, per second [Hz]; must divide the tick rate."""
    address: int | None = Field(default=None, ge=0, le=65535)
    """Its address among all modems; the next free one where not given."""
    color: Literal["red", "green", "blue"] = "blue"
    """Of the light: which of the water's coefficients counts."""
    power_w: float = Field(default=1.0, gt=0)
    """Optical power of the lamp [W]."""
    half_angle_deg: float = Field(default=30.0, gt=0, lt=90)
    """Angle off the lamp's axis (the sensor's x) at which half the light is left [deg]."""
    field_of_view_deg: float = Field(default=60.0, gt=0, le=90)
    """Half angle of the receiver, whose axis is the sensor's x [deg]."""
    aperture_m2: float = Field(default=5e-4, gt=0)
    """Of the receiver [m^2]."""
    responsivity: float = Field(default=0.3, gt=0)
    """Of the photodiode [A/W]."""
    filter_share: float = Field(default=0.02, gt=0, le=1)
    """Part of daylight that the receiver's filter lets through."""
    bit_rate_bps: float = Field(default=1e6, gt=0)
    """Bits per second, on-off keyed [bit/s]."""
    packet_max_bytes: int = Field(default=1500, ge=1, le=65536)
    """Longest payload [bytes]."""
    queue: int = Field(default=64, ge=1, le=10_000)
    """Packets that may wait."""


class OpticalModem:
    """Packets by light: `sim.send("auv0", "optical", b"...", to=...)`, and `reading.packets`; see `Modem`.

    Reading: `data` `(n, 5)` and extras as of a modem; levels are of electrical power [dB re 1 A^2].
    """

    Config: ClassVar[type[SensorConfig]] = OpticalModemConfig
    TITLE: ClassVar[str] = "Optical modem: line of sight, beam, turbidity, daylight"
    KERNELS: ClassVar[int] = 6
    CASTS: ClassVar[int] = 0
    EVENTS: ClassVar[bool] = True
    ONE_VEHICLE: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "H. Kaushal and G. Kaddoum, IEEE Access 4, 1518 (2016), doi 10.1109/ACCESS.2016.2552538",
    )

    def __init__(self, config: OpticalModemConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        self._light = Light(
            world=context.world, ocean=context.ocean, power_w=config.power_w,
            half_angle=math.radians(config.half_angle_deg), field_of_view=math.radians(config.field_of_view_deg),
            area=config.aperture_m2, responsivity=config.responsivity, bandwidth=config.bit_rate_bps,
            channel=_COLOURS.index(config.color), filter_share=config.filter_share, own=context.own_body,
        )  # fmt: skip
        if context.medium is not None:
            context.medium.add(self._port(), context)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the modem on every lane of `motion`."""
        return read_port(self._context, len(motion.tick))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Noise in the dark: (name, values, unit)."""
        return [("noise", np.array([self._light.noise()]), "dB re 1 A^2")]

    def _port(self) -> ModemPort:
        c = self._config
        return ModemPort(
            path=self._context.path, mount=c, period=period_ticks(c.rate_hz, self._context.dt_ns),
            address=-1 if c.address is None else c.address, frequency_hz=_HERTZ + 1e13 * _COLOURS.index(c.color),
            bandwidth_hz=c.bit_rate_bps, bit_rate_bps=c.bit_rate_bps, modulation="bpsk", chirp_order=2,
            source_level_db=0.0, coding_gain_db=-3.0,  # on-off keying needs twice the mean power of PSK
            multipath_window_s=1.0, preamble_s=1e-5, packet_max_bytes=c.packet_max_bytes, detection_db=0.0,
            noise_db=0.0, queue=c.queue, mac="none", slots=1, slot_s=1.0, guard_s=0.0, retries=0, acknowledge=False,
            timeout_s=1.0, turnaround_s=0.0, sound_speed_mps=1500.0, clock_offset_std_s=0.0, clock_drift_std_ppm=0.0,
            beacon_s=None, beacon_to="*", beacon_bytes=0, carrier=self._light, kind="light",
        )  # fmt: skip
