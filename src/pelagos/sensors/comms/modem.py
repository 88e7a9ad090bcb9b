"""An acoustic modem: packets through the simulated water, with a protocol, and ranges from their travel times."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.modulation import Modulation
from pelagos.config.rate import Rate
from pelagos.errors import LookupFailed, ValidityWarning
from pelagos.sensors.comms.link.budget import success
from pelagos.sensors.comms.link.devices import DEVICES, Device
from pelagos.sensors.comms.link.modem_port import Mac, ModemPort
from pelagos.sensors.comms.link.reading import read_port
from pelagos.sensors.idle_keys import Need, idle
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_DEFAULT: Final = "micromodem_psk"
_NEEDS: Final = (
    Need(("chirp_order",), "modulation", ("mfsk", "chirp")),
    Need(("slots", "slot_s", "guard_s"), "mac", ("tdma",)),
    Need(("beacon_to", "beacon_bytes"), "beacon_s"),
)


class ModemConfig(SensorConfig):
    """A modem; figures where not given are those of its `device`."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["modem"] = "modem"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Looks at the queue, and readings, per second [Hz]; must divide the tick rate."""
    device: str = _DEFAULT
    """A modem by its data sheet: micromodem, micromodem_psk, s2cr_18_34, m64, popoto, atm_900, nanomodem, x150; keys
    given beside it change its figures."""
    address: int | None = Field(default=None, ge=0, le=65535)
    """Its address among all modems; the next free one where not given."""
    frequency_hz: float = Field(default=25_000.0, gt=0)
    """Centre of the band [Hz]."""
    bandwidth_hz: float = Field(default=4_000.0, gt=0)
    """Width of the band [Hz]."""
    bit_rate_bps: float = Field(default=80.0, gt=0)
    """Bits of payload and header per second [bit/s]."""
    modulation: Modulation = "fsk"
    """bpsk, qpsk, dpsk, fsk, mfsk, ofdm or chirp."""
    chirp_order: int = Field(default=2, ge=2, le=65536)
    """Number of signals of `mfsk` and `chirp`."""
    source_level_db: float = Field(default=185.0, ge=100, le=230)
    """Level at 1 m [dB re 1 uPa]."""
    coding_gain_db: float = Field(default=3.0, ge=0, le=20)
    """What error-correcting codes gain in Eb/N0 [dB]."""
    multipath_window_s: float = Field(default=0.01, gt=0)
    """Guard time, equaliser or cyclic prefix: echoes that come later disturb [s]."""
    preamble_s: float = Field(default=0.1, ge=0)
    """Preamble before each packet [s]."""
    packet_max_bytes: int = Field(default=64, ge=1, le=65536)
    """Longest payload [bytes]."""
    depth_max_m: float = Field(default=6000.0, gt=0)
    """Depth that the housing stands [m]."""
    detection_db: float = Field(default=-5.0, ge=-40, le=40)
    """Level over the noise in the band from which a packet is noticed [dB]."""
    noise_db: float = Field(default=40.0, ge=-50, le=150)
    """Noise of the own vehicle and of the receiver [dB re 1 uPa^2/Hz], besides that of the sea."""
    queue: int = Field(default=16, ge=1, le=10_000)
    """Packets that may wait."""
    mac: Mac = "none"
    """Who may send when: none, aloha, csma, tdma or maca."""
    slots: int = Field(default=8, ge=1, le=10_000)
    """Slots of a TDMA frame; a modem's is its address modulo this number."""
    slot_s: float = Field(default=1.0, gt=0)
    """Length of a TDMA slot [s]."""
    guard_s: float = Field(default=0.2, ge=0)
    """Time at the end of a slot in which nothing is sent [s]."""
    acknowledge: bool = False
    """Packets to one receiver are acknowledged, and sent again where no acknowledgement comes."""
    retries: int = Field(default=3, ge=0, le=100)
    """How often a packet is sent again."""
    timeout_s: float = Field(default=4.0, gt=0)
    """How long an answer is waited for [s]."""
    turnaround_s: float = Field(default=0.1, ge=0)
    """From the end of a request to its answer, known to both sides [s]."""
    sound_speed_mps: float = Field(default=1500.0, ge=1300, le=1700)
    """By which the modem makes ranges of times [m/s]."""
    clock_offset_std_s: float = Field(default=0.0, ge=0)
    """Standard deviation of the clock's offset, drawn once a run [s]."""
    clock_drift_std_ppm: float = Field(default=0.0, ge=0)
    """Standard deviation of the clock's drift, drawn once a run [1e-6]; 0.02 is a chip-scale atomic clock, 1 a TCXO."""
    beacon_s: float | None = Field(default=None, gt=0)
    """A packet of `beacon_bytes` every so many seconds [s]; None: only what is sent by hand."""
    beacon_to: str = "*"
    """To whom: "agent.modem", an agent with one modem, an address, or "*" for all."""
    beacon_bytes: int = Field(default=8, ge=0)
    """Payload of a beacon [bytes]."""

    @model_validator(mode="before")
    @classmethod
    def _by_device(cls, data: Any) -> Any:
        """Figures of the device where the scenario gives none."""
        if not isinstance(data, Mapping):
            return data
        name = data.get("device", cls.model_fields["device"].default)
        if not isinstance(name, str) or name not in DEVICES:
            raise ValueError(str(LookupFailed("modem device", str(name), DEVICES)))
        return {**cls._keys_of(DEVICES[name]), **data}

    @classmethod
    def _keys_of(cls, device: Device) -> Mapping[str, Any]:
        """Keys of this configuration that a device sets."""
        return device.keys

    @model_validator(mode="after")
    def _fits(self) -> ModemConfig:
        if self.chirp_order & (self.chirp_order - 1):
            raise ValueError(f"chirp_order {self.chirp_order} is no power of two: a signal stands for whole bits")
        if self.beacon_bytes > self.packet_max_bytes:
            raise ValueError(f"beacon_bytes {self.beacon_bytes} is more than packet_max_bytes {self.packet_max_bytes}")
        if self.bandwidth_hz >= 2.0 * self.frequency_hz:
            raise ValueError(
                f"bandwidth_hz {self.bandwidth_hz:g} does not fit around frequency_hz {self.frequency_hz:g}"
            )
        if self.mac == "tdma" and self.slot_s <= self.guard_s + self.preamble_s + 32.0 / self.bit_rate_bps:
            raise ValueError(f"slot_s {self.slot_s:g} has no room for a header and guard_s {self.guard_s:g}")
        longest = self.preamble_s + (32.0 + 8.0 * self.beacon_bytes) / self.bit_rate_bps
        if self.mac == "tdma" and self.beacon_s is not None and longest > self.slot_s - self.guard_s:
            raise ValueError(
                f"a beacon of {self.beacon_bytes} bytes takes {longest:.3g} s; slot_s {self.slot_s:g} less guard_s "
                f"{self.guard_s:g} does not hold it"
            )
        return self


class Modem:
    """Sends and receives packets: `sim.send("auv0", "modem", b"hello", to="usv0")`, and `reading.packets`.

    Reading: `data` `(n, 5)`: packets that wait, whether it transmits, packets received and sent since the reading
    before, noise in its band [dB re 1 uPa]. `reading.packets` are those received, see `Packet`. Extras:
    `packets` and `fates` `(n,)` of objects: tuples of packets, and of what became of each that came near (`Reception`).
    """

    Config: ClassVar[type[SensorConfig]] = ModemConfig
    TITLE: ClassVar[str] = "Acoustic modem with protocols, through the simulated water"
    KERNELS: ClassVar[int] = 6
    """Without packets on their way; a link that is traced takes about forty."""
    CASTS: ClassVar[int] = 0
    NEEDS: ClassVar[tuple[Need, ...]] = _NEEDS
    """Keys that show only where another has its value."""
    EVENTS: ClassVar[bool] = True
    ASKS_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = (
        "J. G. Proakis and M. Salehi, Digital Communications, 5th ed., 2008, Sections 4.3 to 4.5 (bit errors)",
        "M. Stojanovic and J. Preisig, IEEE Commun. Mag. 47(1), 84 (2009), doi 10.1109/MCOM.2009.4752682 (channels)",
        "P. Karn, MACA, ARRL/CRRL Computer Networking Conference 9, 134 (1990); N. Abramson, AFIPS 37, 281 (1970)",
    )

    def __init__(self, config: ModemConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        if told := idle(config, self.NEEDS, device=type(config)._keys_of(DEVICES[config.device])):
            warnings.warn(f"{context.path}: {told}", ValidityWarning, stacklevel=3)
        if context.medium is not None:
            context.medium.add(self._port(), context)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the modem on every lane of `motion`."""
        return read_port(self._context, len(motion.tick))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """The link budget of a packet of full length: (name, values, unit)."""
        snr = np.arange(-10.0, 21.0, 5.0)
        port = self._port()
        bits = 8 * (4 + port.packet_max_bytes)
        chance = np.array([success(port, bits, level, 0.0) for level in snr])
        longest = np.array([port.duration_s(port.packet_max_bytes)])
        return [("snr", snr, "dB"), ("probability of a full packet", chance, "1"), ("its duration", longest, "s")]

    def _port(self) -> ModemPort:
        c = self._config
        own = {name: getattr(c, name) for name in ModemPort.__dataclass_fields__ if name in type(c).model_fields}
        period = period_ticks(c.rate_hz, self._context.dt_ns)
        own["address"] = -1 if c.address is None else c.address
        return ModemPort(**own, path=self._context.path, mount=c, period=period, array=self._array())

    def _array(self) -> NDArray[np.float64] | None:
        """Elements in the sensor frame [m]; a plain modem has one."""
        return None
