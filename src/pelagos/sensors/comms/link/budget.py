"""The link budget of packets: levels from arrivals, and the probability that all bits are right."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.bearing import angles_of, direction_from_phases, element_phases
from pelagos.acoustics.channel import delay_spread
from pelagos.acoustics.modulation import bit_error_rate, packet_success
from pelagos.sensors.comms.link.modem_port import ModemPort

NOTHING: Final = -math.inf
_FIRST_DB: Final = 10.0  # below the loudest path, down to which a receiver takes a path for the first


@dataclass(frozen=True)
class HeardSignal:
    """Signal of one transmission at one receiver.

    Attributes:
        delay_s: of the first loud path [s].
        level_db, echoes_db: within the receiver's window, and later [dB re 1 uPa].
        spread_s: of all paths [s].
        doppler: of the loudest path.
        lost: why nothing comes.
        direction: unit vector NWU towards where the loudest path comes from.
        waves: directions NWU from which paths come, `(a, 3)`, and their complex amplitudes, within 1/bandwidth; None
            where the receiver has no array.
    """

    delay_s: float
    level_db: float
    echoes_db: float
    spread_s: float
    doppler: float
    lost: str
    waves: tuple[NDArray[np.float64], NDArray[np.complex128]] | None


def sum_arrivals(
    port: ModemPort, source_level_db: float, delay: NDArray[np.float64], amplitude: NDArray[np.complex128],
    doppler: NDArray[np.float64], arrival: NDArray[np.float64], blocked: NDArray[np.bool_],
) -> HeardSignal:  # fmt: skip
    """Sum the arrivals of one pair as a receiver of this kind does."""
    if len(delay) == 0 or blocked.all():
        return HeardSignal(0.0, NOTHING, NOTHING, 0.0, 1.0, "blocked" if len(delay) else "no path", None)
    free = ~blocked
    delay, amplitude, doppler, arrival = delay[free], amplitude[free], doppler[free], arrival[free]
    level = 20.0 * np.log10(np.maximum(np.abs(amplitude), 1e-30)) + source_level_db
    loudest = int(np.argmax(level))
    first = float(delay[level >= level[loudest] - _FIRST_DB].min())
    within = (delay >= first - 1e-9) & (delay <= first + port.multipath_window_s)
    waves = None
    if port.array is not None:
        early = (delay >= first - 1e-9) & (delay <= first + 1.0 / port.bandwidth_hz)
        waves = -arrival[early], amplitude[early] * np.exp(-2j * math.pi * port.frequency_hz * (delay[early] - first))
    return HeardSignal(
        first, _sum_db(level[within]), _sum_db(level[~within]), delay_spread(delay, amplitude),
        float(doppler[loudest]), "", waves,
    )  # fmt: skip


def success(port: ModemPort, bits: int, level_db: float, noise_db: float, *others_db: float) -> float:
    """Probability that a packet is received in noise and other sound [dB re 1 uPa in the band]."""
    snr = level_db - _sum_db(np.array([noise_db, *others_db]))
    per_bit = snr + 10.0 * math.log10(port.bandwidth_hz / port.bit_rate_bps) + port.coding_gain_db
    rate = bit_error_rate(port.modulation, 10.0 ** (per_bit / 10.0), order=port.chirp_order)
    return float(packet_success(rate, bits))


def same_waveform_db(port: ModemPort) -> float:
    """Disturbance by another packet of the same waveform over that by noise [dB]: spreading gains nothing on it."""
    return max(10.0 * math.log10(port.bandwidth_hz / port.bit_rate_bps) + port.coding_gain_db, 0.0)


def measured_direction(
    port: ModemPort, waves: tuple[NDArray[np.float64], NDArray[np.complex128]], snr: float,
    normals: NDArray[np.float64],
) -> tuple[float, float]:  # fmt: skip
    """Azimuth and elevation [rad] in the sensor frame from the phases at the array's elements.

    Args:
        port: with an array.
        waves: directions `(a, 3)` in the sensor frame, and amplitudes.
        snr: behind the correlator, as a ratio.
        normals: `(2, elements)` standard normal numbers.
    """
    directions, amplitudes = waves
    elements = port.array
    assert elements is not None
    wavelength = port.sound_speed_mps / port.frequency_hz
    pressure = element_phases(elements, directions, amplitudes, wavelength)
    size = math.sqrt(float(np.mean(np.abs(pressure) ** 2)) / max(2.0 * snr, 1e-12))
    pressure = pressure + size * (normals[0] + 1j * normals[1])
    loudest = directions[int(np.argmax(np.abs(amplitudes)))]
    return angles_of(direction_from_phases(elements, pressure, wavelength, loudest))


def _sum_db(levels: NDArray[np.float64]) -> float:
    finite = levels[np.isfinite(levels)]
    return float(10.0 * np.log10(np.sum(10.0 ** (finite / 10.0)))) if len(finite) else NOTHING


def sum_db(*levels: float) -> float:
    """Of powers given in decibels; -inf for nothing."""
    return _sum_db(np.array(levels))
