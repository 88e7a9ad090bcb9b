"""Acoustic modems by their data sheets: figures that a device gives, each with where it is from.

What no public sheet states is marked `# assumed`, and named in `Device.assumed`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
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
        array: keys that a `usbl` has besides: accuracy of its bearings and ranges.
    """

    title: str
    source: str
    keys: Mapping[str, Any]
    assumed: tuple[str, ...] = ()
    array: Mapping[str, Any] = field(default_factory=dict)


_ARRAY: Final[tuple[str, ...]] = ("bearing_noise_deg", "range_noise_m")


def _device(title: str, source: str, assumed: str = "", **keys: Any) -> Device:
    array = {name: keys.pop(name) for name in _ARRAY if name in keys}
    return Device(title, source, MappingProxyType(keys), tuple(assumed.split()), MappingProxyType(array))


DEVICES: Final[Mapping[str, Device]] = MappingProxyType({
    "micromodem": _device(
        "WHOI Micromodem, FH-FSK 80 bit/s",
        "WHOI, acomms.whoi.edu/micro-modem: FSK at 80 bit/s in 4 kHz; L. Freitag et al., The WHOI Micro-Modem, OCEANS "
        "2005, doi 10.1109/OCEANS.2005.1639901: bands from 3 to 30 kHz, packets of 32 bytes",
        "source_level_db coding_gain_db multipath_window_s preamble_s",
        frequency_hz=25_000.0, bandwidth_hz=4_000.0, bit_rate_bps=80.0, modulation="fsk", packet_max_bytes=32,
        source_level_db=190.0, coding_gain_db=5.0, multipath_window_s=0.0125, preamble_s=0.2,  # assumed
    ),
    "micromodem_psk": _device(
        "WHOI Micromodem 2, PSK 5 400 bit/s",
        "WHOI, acomms.whoi.edu/micro-modem: up to 5 400 bit/s of PSK in 5 kHz; E. Gallimore et al., The WHOI "
        "Micromodem-2, OCEANS 2010, doi 10.1109/OCEANS.2010.5664354: rate 5, eight frames of 256 bytes, equaliser",
        "source_level_db coding_gain_db multipath_window_s preamble_s",
        frequency_hz=25_000.0, bandwidth_hz=5_000.0, bit_rate_bps=5_400.0, modulation="qpsk", packet_max_bytes=2_048,
        source_level_db=190.0, coding_gain_db=3.0, multipath_window_s=0.01, preamble_s=0.1,  # assumed
    ),
    "s2cr_18_34": _device(
        "EvoLogics S2C R 18/34, sweep-spread carrier, 13.9 kbit/s",
        "EvoLogics, S2C R 18/34: the band is its name, up to 13.9 kbit/s; half of that where paths are several",
        "bit_rate_bps modulation source_level_db coding_gain_db multipath_window_s preamble_s packet_max_bytes "
        "depth_max_m bearing_noise_deg range_noise_m",
        frequency_hz=26_000.0, bandwidth_hz=16_000.0,
        bit_rate_bps=6_900.0, modulation="qpsk", source_level_db=184.0, packet_max_bytes=1_024,  # assumed
        coding_gain_db=6.0, multipath_window_s=0.008, preamble_s=0.05, depth_max_m=2_000.0,  # assumed
        bearing_noise_deg=0.1, range_noise_m=0.01,  # recalled of the sheet of S2C R 18/34 USBL, taken for 1 sigma
    ),
    "m64": _device(
        "Water Linked M64, 64 bit/s net, channel 4",
        "Water Linked, Modem M64: seven channels from 31.25 to 250 kHz, the fourth from 125 to 156 kHz, 64 bit/s; "
        "waterlinked.github.io/modem/modem-m64-protocol: packets of 8 bytes",
        "source_level_db modulation chirp_order coding_gain_db multipath_window_s preamble_s depth_max_m",
        frequency_hz=140_500.0, bandwidth_hz=31_000.0, bit_rate_bps=64.0, packet_max_bytes=8,
        source_level_db=156.0, modulation="chirp", chirp_order=256, coding_gain_db=3.0,  # assumed
        multipath_window_s=0.02, preamble_s=0.1, depth_max_m=300.0,  # assumed
    ),
    "popoto": _device(
        "Popoto S1000 / PMM, PSK 1 280 bit/s",
        "Popoto Modem, commands of the modem (setRate80, 640, 1280, 2560, 5120, 10240), as in Goby's driver",
        "frequency_hz bandwidth_hz modulation source_level_db coding_gain_db multipath_window_s preamble_s "
        "packet_max_bytes",
        bit_rate_bps=1_280.0,
        frequency_hz=30_000.0, bandwidth_hz=10_000.0, modulation="qpsk", source_level_db=186.0,  # assumed
        coding_gain_db=4.0, multipath_window_s=0.01, preamble_s=0.1, packet_max_bytes=256,  # assumed
    ),
    "atm_900": _device(
        "Teledyne Benthos ATM-900 series, MFSK 600 bit/s",
        "Teledyne Benthos, ATM-900 Series User's Manual, P/N M-270-26: convolutional coding and multipath guard period",
        "frequency_hz bandwidth_hz bit_rate_bps modulation chirp_order source_level_db coding_gain_db "
        "multipath_window_s preamble_s packet_max_bytes",
        frequency_hz=11_500.0, bandwidth_hz=5_000.0, bit_rate_bps=600.0, modulation="mfsk", chirp_order=4,  # assumed
        source_level_db=185.0, coding_gain_db=4.0, multipath_window_s=0.0125, preamble_s=0.3,  # assumed
        packet_max_bytes=1_024,  # assumed
    ),
    "nanomodem": _device(
        "Newcastle nanomodem v3, 640 bit/s",
        "Newcastle University, USMART, V3 modems (October 2018): 24 to 32 kHz, 640 bit/s by orthogonal codes with "
        "error correction, 168 dB, over 2 km, packets of 64 bytes; J. A. Neasham et al., Electronics 11, 1446 (2022), "
        "doi 10.3390/electronics11091446",
        "chirp_order coding_gain_db multipath_window_s preamble_s",
        frequency_hz=28_000.0, bandwidth_hz=8_000.0, bit_rate_bps=640.0, modulation="chirp", source_level_db=168.0,
        packet_max_bytes=64,
        chirp_order=4, coding_gain_db=4.0, multipath_window_s=0.01, preamble_s=0.05,  # assumed
    ),
    "x150": _device(
        "Blueprint Subsea SeaTrac X150, 100 bit/s, with USBL array",
        "Blueprint Subsea, SeaTrac technology: spread spectrum, range 1 km; Serial Command Interface Reference, "
        "UM-140-D00221: packets of 31 bytes",
        "frequency_hz bandwidth_hz bit_rate_bps source_level_db modulation chirp_order coding_gain_db "
        "multipath_window_s preamble_s depth_max_m bearing_noise_deg range_noise_m",
        packet_max_bytes=31,
        frequency_hz=28_000.0, bandwidth_hz=8_000.0, bit_rate_bps=100.0, source_level_db=176.0,  # assumed
        modulation="chirp", chirp_order=16, coding_gain_db=3.0, multipath_window_s=0.02,  # assumed
        preamble_s=0.1, depth_max_m=2_000.0,  # assumed
        bearing_noise_deg=1.0, range_noise_m=0.05,  # +-1 deg and +-50 mm recalled of the sheet, taken for 1 sigma
    ),
})  # fmt: skip
"""By name."""
