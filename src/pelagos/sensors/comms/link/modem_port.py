"""A modem as the water and its fellows see it: figures of its transducer, its waveform, its protocol and its clock."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.modulation import Modulation
from pelagos.sensors.mount import Mounted

if TYPE_CHECKING:
    from pelagos.sensors.comms.link.carrier import Carrier

Mac = Literal["none", "aloha", "csma", "tdma", "maca"]

FIRST_MMSI: Final = 200_000_000
"""Of ships that are given none. ITU-R M.585: the first three digits are a country's; none has 200."""


@dataclass(frozen=True)
class ModemPort:
    """One modem; units as its configuration's, see `ModemConfig`.

    Attributes:
        path: "agent.sensor".
        mount: configuration with its place on the vehicle.
        period: ticks between two looks at its queue.
        array: elements `(k, 3)` in the sensor frame [m]; None without.
        bearing_noise_deg, alignment_std_deg, range_noise_m: of a device with an array, see `UsblConfig`.
        carrier, kind: light or radio, and which; None: sound.
        mmsi: number of a ship's transponder; None: it is none, 0: the next free one from `FIRST_MMSI`.
        report: of itself, a pose, a copy and a count, what it sends by itself, and how long until the next [s].
    """

    path: str
    mount: Mounted
    period: int
    address: int
    frequency_hz: float
    bandwidth_hz: float
    bit_rate_bps: float
    modulation: Modulation
    chirp_order: int
    source_level_db: float
    coding_gain_db: float
    multipath_window_s: float
    preamble_s: float
    packet_max_bytes: int
    detection_db: float
    noise_db: float
    queue: int
    mac: Mac
    slots: int
    slot_s: float
    guard_s: float
    retries: int
    acknowledge: bool
    timeout_s: float
    turnaround_s: float
    sound_speed_mps: float
    clock_offset_std_s: float
    clock_drift_std_ppm: float
    beacon_s: float | None
    beacon_to: str
    beacon_bytes: int
    array: NDArray[np.float64] | None = None
    bearing_noise_deg: float = 0.0
    alignment_std_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    range_noise_m: float = 0.0
    carrier: Carrier | None = None
    kind: str = "sound"
    report: Callable[[ModemPort, Any, int, int], tuple[bytes, float]] | None = None
    interrogate: tuple[str, ...] = ()
    interrogate_s: float = 1.0
    depth_max_m: float = math.inf
    mmsi: int | None = None

    @property
    def agent(self) -> str:
        """The vehicle that carries it."""
        return self.path.split(".")[0]

    def duration_s(self, payload: int, kind: str = "data") -> float:
        """Of a packet [s]: preamble, header of 4 bytes and payload; parts of protocols have a header only."""
        return self.preamble_s + 8.0 * (4 + (payload if kind in ("data", "response") else 0)) / self.bit_rate_bps

    def holds(self, payload: int, kind: str = "data") -> bool:
        """Whether a slot of its protocol is long enough for a packet."""
        return self.mac != "tdma" or self.duration_s(payload, kind) <= self.slot_s - self.guard_s

    def understands(self, other: ModemPort) -> bool:
        """Whether it can decode what the other sends."""
        mine = (self.frequency_hz, self.bandwidth_hz, self.bit_rate_bps, self.modulation)
        return self.kind == other.kind and mine == (
            other.frequency_hz,
            other.bandwidth_hz,
            other.bit_rate_bps,
            other.modulation,
        )
