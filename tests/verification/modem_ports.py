"""Ports of modems for tests of what carries their packets, without a simulation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from pelagos.sensors.comms.link.modem_port import ModemPort

MOUNT: Any = SimpleNamespace(position_m=(0.0, 0.0, 0.0), q_body_sensor=(1.0, 0.0, 0.0, 0.0))


def modem_port(path: str = "a.m", **keys: Any) -> ModemPort:
    """One of 1000 bit/s: a header of 4 bytes takes 0.032 s behind 0.1 s of preamble, a byte 8 ms."""
    usual: dict[str, Any] = {
        "mount": MOUNT, "period": 1, "address": 0, "frequency_hz": 25e3, "bandwidth_hz": 5e3, "bit_rate_bps": 1000.0,
        "modulation": "fsk", "chirp_order": 2, "source_level_db": 180.0, "coding_gain_db": 0.0,
        "multipath_window_s": 0.01, "preamble_s": 0.1, "packet_max_bytes": 64, "detection_db": -5.0, "noise_db": 40.0,
        "queue": 8, "mac": "none", "slots": 3, "slot_s": 0.5, "guard_s": 0.1, "retries": 2, "acknowledge": False,
        "timeout_s": 1.5, "turnaround_s": 0.04, "sound_speed_mps": 1480.0, "clock_offset_std_s": 0.0,
        "clock_drift_std_ppm": 0.0, "beacon_s": None, "beacon_to": "*", "beacon_bytes": 3,
    }  # fmt: skip
    return ModemPort(path=path, **(usual | keys))
