"""Acoustic modems by their data sheets: figures that a device gives, each with where it is from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final


@dataclass(frozen=True)
class Device:
    """One modem.

    Attributes:
        title: maker and model.
        source: of the figures.
        keys: values of a modem's configuration.
        assumed: keys that no sheet gives.
    """

    title: str
    source: str
    keys: Mapping[str, Any]
    assumed: tuple[str, ...] = ()


def _device(title: str, source: str, assumed: str = "", **keys: Any) -> Device:
    return Device(title, source, MappingProxyType(keys), tuple(assumed.split()))


DEVICES: Final[Mapping[str, Device]] = MappingProxyType({
    "micromodem": _device(
        "WHOI Micromodem, FH-FSK 80 bit/s",
        "L. Freitag et al., The WHOI Micro-Modem, OCEANS 2005, doi 10.1109/OCEANS.2005.1639901: 25 kHz band of 4 kHz, "
        "80 bit/s frequency-hopped FSK with coding, packets of 32 bytes, source level 190 dB",
        "coding_gain_db multipath_window_s preamble_s",
        frequency_hz=25_000.0, bandwidth_hz=4_000.0, bit_rate_bps=80.0, modulation="fsk", source_level_db=190.0,
        packet_max_bytes=32, coding_gain_db=5.0, multipath_window_s=0.0125, preamble_s=0.2,
    ),
    "micromodem_psk": _device(
        "WHOI Micromodem 2, PSK 5 400 bit/s",
        "E. Gallimore et al., The WHOI Micromodem-2, OCEANS 2010, doi 10.1109/OCEANS.2010.5664354: rate 5, 25 kHz, "
        "5 kHz band, equaliser; frames of 256 bytes",
        "coding_gain_db multipath_window_s preamble_s",
        frequency_hz=25_000.0, bandwidth_hz=5_000.0, bit_rate_bps=5_400.0, modulation="qpsk", source_level_db=190.0,
        packet_max_bytes=2_048, coding_gain_db=3.0, multipath_window_s=0.01, preamble_s=0.1,
    ),
    "s2cr_18_34": _device(
        "EvoLogics S2C R 18/34, sweep-spread carrier, 13.9 kbit/s",
        "EvoLogics, S2C R 18/34 product information: 18 to 34 kHz, up to 13.9 kbit/s, range 3 500 m, depth 2 000 m",
        "bit_rate_bps source_level_db coding_gain_db multipath_window_s preamble_s packet_max_bytes",
        frequency_hz=26_000.0, bandwidth_hz=16_000.0, bit_rate_bps=6_900.0, modulation="qpsk", source_level_db=184.0,
        packet_max_bytes=1_024, coding_gain_db=6.0, multipath_window_s=0.008, preamble_s=0.05, depth_max_m=2_000.0,
    ),
    "m64": _device(
        "Water Linked M64, 64 bit/s net",
        "Water Linked, M64 acoustic modem data sheet: 31.25 to 250 kHz, 64 bit/s net, range 200 m, packets of 8 bytes",
        "source_level_db modulation coding_gain_db multipath_window_s preamble_s",
        frequency_hz=125_000.0, bandwidth_hz=60_000.0, bit_rate_bps=64.0, modulation="chirp", chirp_order=256,
        source_level_db=156.0, packet_max_bytes=8, coding_gain_db=3.0, multipath_window_s=0.02, preamble_s=0.1,
        depth_max_m=300.0,
    ),
    "popoto": _device(
        "Popoto S1000 / PMM, PSK 1 280 bit/s",
        "Popoto Modem, PMM5021/S1000 data sheet: 20 to 40 kHz, 80 bit/s FH-FSK to 10 240 bit/s PSK, to 8 km",
        "source_level_db coding_gain_db multipath_window_s preamble_s packet_max_bytes",
        frequency_hz=30_000.0, bandwidth_hz=10_000.0, bit_rate_bps=1_280.0, modulation="qpsk", source_level_db=186.0,
        packet_max_bytes=256, coding_gain_db=4.0, multipath_window_s=0.01, preamble_s=0.1,
    ),
    "atm_900": _device(
        "Teledyne Benthos ATM-900 series, MFSK 600 bit/s",
        "Teledyne Marine, Acoustic modems 900 series: 9 to 14 kHz (LF), 140 to 15 360 bit/s; MFSK with multipath "
        "guard; 2 to 6 km",
        "source_level_db coding_gain_db multipath_window_s preamble_s packet_max_bytes chirp_order",
        frequency_hz=11_500.0, bandwidth_hz=5_000.0, bit_rate_bps=600.0, modulation="mfsk", chirp_order=4,
        source_level_db=185.0, packet_max_bytes=1_024, coding_gain_db=4.0, multipath_window_s=0.0125, preamble_s=0.3,
    ),
    "nanomodem": _device(
        "Newcastle nanomodem v3, 640 bit/s",
        "Newcastle University, Nanomodem v3 data sheet: 24 to 32 kHz, 640 bit/s in chirps, 168 dB, 2 km, packets of 64 "
        "bytes",
        "coding_gain_db multipath_window_s preamble_s",
        frequency_hz=28_000.0, bandwidth_hz=8_000.0, bit_rate_bps=640.0, modulation="chirp", chirp_order=4,
        source_level_db=168.0, packet_max_bytes=64, coding_gain_db=4.0, multipath_window_s=0.01, preamble_s=0.05,
    ),
    "x150": _device(
        "Blueprint Subsea SeaTrac X150, 100 bit/s, with USBL array",
        "Blueprint Subsea, SeaTrac X100 series user guide: 24 to 32 kHz spread spectrum, 100 bit/s, 1 km, packets of "
        "31 bytes, source level 176 dB",
        "modulation coding_gain_db multipath_window_s preamble_s",
        frequency_hz=28_000.0, bandwidth_hz=8_000.0, bit_rate_bps=100.0, modulation="chirp", chirp_order=16,
        source_level_db=176.0, packet_max_bytes=31, coding_gain_db=3.0, multipath_window_s=0.02, preamble_s=0.1,
        depth_max_m=2_000.0,
    ),
})  # fmt: skip
"""By name."""
