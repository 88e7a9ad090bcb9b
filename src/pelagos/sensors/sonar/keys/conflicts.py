"""Keys of sonars that contradict one another: which, whose each is, and what to do.

A key is the scenario's, the device's that it names, or a default; an error tells, so that nobody looks for a number
that he has not written.
"""

from __future__ import annotations

import math
from typing import Any, Final

from pelagos.sensors.schedule import SLOWEST, farthest_heard
from pelagos.sensors.sonar.keys.devices import device_keys

_SPARSE: Final = 0.2  # of the spacing: narrower beams leave four fifths of the sector unheard
_ROUNDING: Final = 0.999  # of the product of bandwidth and duration: both are written with few digits


def quote(config: Any, *keys: str) -> str:
    """Keys with their values and whose they are: "pulse_s 0.3 and rate_hz 20 (of the device oculus_m750d)"."""
    return " and ".join(f"{key} {_shown(getattr(config, key))}{_owner(config, key)}" for key in keys)


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _owner(config: Any, key: str) -> str:
    given = device_keys(config)
    if key in given and given[key] == getattr(config, key):
        return f" (of the device {config.device})"
    return "" if key in config.model_fields_set else " (by default)"


def _down(value: float) -> float:
    """A limit to four digits, not above it: what a message tells to give is taken."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f"{math.floor(value / step * (1.0 + 1e-12)) * step:.4g}")


def check_order(config: Any) -> None:
    """Raises ValueError where `range_min_m` is not below `range_max_m`."""
    if config.range_min_m >= config.range_max_m:
        raise ValueError(
            f"{quote(config, 'range_min_m')} must be below {quote(config, 'range_max_m')}: give both, or a range_max_m "
            f"beyond {config.range_min_m:g}"
        )


def check_burst(config: Any) -> None:
    """Raises ValueError where `bandwidth_hz` is more than `frequency_hz` allows, or not that of the tone burst that
    `pulse` asks for, or less than a chirp of `pulse_s` can have."""
    if config.bandwidth_hz >= 2 * config.frequency_hz:
        raise ValueError(
            f"{quote(config, 'bandwidth_hz')} must be below twice {quote(config, 'frequency_hz')}: give a bandwidth_hz "
            f"of less than {2 * config.frequency_hz:g}"
        )
    spread = config.bandwidth_hz * config.pulse_s
    if config.pulse == "cw" and abs(spread - 1.0) > 1e-3:
        raise ValueError(
            f"{quote(config, 'bandwidth_hz')} is not that of a tone burst (pulse: cw) with {quote(config, 'pulse_s')}, "
            f"{1.0 / config.pulse_s:g} Hz: give that, or leave it out"
        )
    if spread < _ROUNDING:
        raise ValueError(
            f"{quote(config, 'bandwidth_hz')} is less than a pulse with {quote(config, 'pulse_s')} has by its "
            f"shortness alone, {1.0 / config.pulse_s:g} Hz: give a pulse_s of {1.0 / config.bandwidth_hz:.3g} or more, "
            f"or pulse: cw"
        )


def check_pulse(config: Any) -> None:
    """Raises ValueError where `pulse_s` lasts longer than the time between two pings."""
    if config.pulse_s * config.rate_hz >= 1.0:
        raise ValueError(
            f"{quote(config, 'pulse_s')} is longer than the {1 / config.rate_hz:.3g} s between two pings at "
            f"{quote(config, 'rate_hz')}: give a shorter pulse_s, or less than {1 / config.pulse_s:.3g} Hz"
        )


def check_ambiguity(config: Any) -> None:
    """Raises ValueError where echoes from `range_max_m` come after the next ping, at 1400 m/s."""
    turn_around = 2 * config.range_max_m / SLOWEST
    if turn_around * config.rate_hz > 1.0:
        raise ValueError(
            f"{quote(config, 'range_max_m')} is ambiguous at {quote(config, 'rate_hz')} pings a second: the echo needs "
            f"{turn_around:.3g} s; give a range_max_m of at most {_down(farthest_heard(config.rate_hz, SLOWEST)):g}, "
            f"or a rate_hz of at most {_down(1 / turn_around):g}"
        )


def check_spacing(config: Any) -> None:
    """Raises ValueError where `beamwidth_deg` is much narrower than the beams' spacing, and not the default.

    A resolved scenario gives every key, so that having been given says nothing.
    """
    spacing = config.horizontal_aperture_deg / config.beams
    chosen = config.beamwidth_deg != type(config).model_fields["beamwidth_deg"].default
    if chosen and config.beamwidth_deg < _SPARSE * spacing:
        raise ValueError(
            f"{quote(config, 'beamwidth_deg')} is much narrower than the {spacing:.3g} deg between beams, of "
            f"{quote(config, 'horizontal_aperture_deg', 'beams')}: most directions would not be heard; give at least "
            f"{_SPARSE * spacing:.2g}, or {round(config.horizontal_aperture_deg / config.beamwidth_deg)} beams"
        )


def check_elements(config: Any) -> None:
    """Raises ValueError where signals of elements are asked for, or errors of their channels, beside other sonars'
    pulses, which only beams hear."""
    if not (config.elements or config.faulty):
        return
    without = "elements: false" if config.elements else "no errors of channels"
    if config.hears != "none":
        raise ValueError(f"elements hear no other sonars: give {without}, or hears: none")
    if config.interference is not None:
        raise ValueError(f"elements hear no other sonars: give {without}, or no interference")
