"""Sonars of one or two beams as ROS 2 messages: sidescan, single-beam echo sounder, mechanically scanning sonar.

A ping is a ProjectedSonarImage with as many beams as the sonar has transducers. Directions are those of an imaging
sonar's beams: `(0, -sin(a), cos(a))` in a frame whose y points to starboard, with `a` positive to port.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import DOWNWARD, PROJECTED, Encoding, Frame, Site, Topic, seconds_nanoseconds
from pelagos.messages.ranging import RANGE
from pelagos.messages.sonar_image import PROJECTED_IMAGE, RAW_IMAGE, eight_bits, projected_image, raw_image
from pelagos.messages.store import header, make
from pelagos.messages.template import STAMP, Buffer, Template, fields
from pelagos.sensors.sensor import Reading

ALTITUDE: Final = "altitude"
_NADIR: Final = np.zeros(1)


def sidescan(config: Any, site: Site) -> Encoding:
    """Data `(n, 2, bins)`, port and starboard; extras `altitude` [m], infinite where no bottom was found.

    The frame is that of a multibeam: beams lie across the track, and zero is straight down.
    """
    off_nadir = math.pi / 2 - math.radians(config.depression_deg)
    widths = (config.beamwidth_deg, config.vertical_beamwidth_deg)
    pings = _pings(config, site, DOWNWARD, np.array([off_nadir, -off_nadir]), widths)
    message = make(
        RANGE,
        header=header(site.frame),
        radiation_type=0,  # sound
        field_of_view=math.radians(config.vertical_beamwidth_deg),
        min_range=float(config.range_min_m),
        max_range=float(config.range_max_m),
        range=0.0,
        variance=((config.range_max_m - config.range_min_m) / config.bins) ** 2 / 12,  # of an even spread over a bin
    )
    altitude = Template(RANGE, message, [*STAMP, "range:float32"])

    def encode(reading: Reading, copy: int) -> tuple[Buffer | None, ...]:
        found = float(reading.extras[ALTITUDE][copy])
        time = seconds_nanoseconds(reading.t_ns)
        return (*pings.encode(reading, copy), altitude.encode(*time, found if math.isfinite(found) else math.inf))

    return Encoding((*pings.topics, Topic(ALTITUDE, RANGE)), encode, pings.frames)


def singlebeam(config: Any, site: Site) -> Encoding:
    """Data `(n, bins)` straight down, which is z of the frame."""
    return _pings(config, site, DOWNWARD, _NADIR, (config.beamwidth_deg, config.beamwidth_deg))


def mechanical_scanning_sonar(config: Any, site: Site) -> Encoding:
    """Data `(n, bins)` in the direction of the head, extras `angle` [rad], positive to port."""
    widths = (config.vertical_beamwidth_deg, config.beamwidth_deg)
    turning = fields("beam_directions[0]", "y z")
    return _pings(config, site, PROJECTED, _NADIR, widths, turning=turning)


def _pings(
    config: Any,
    site: Site,
    frame: Frame,
    azimuth: NDArray[np.float64],
    widths: tuple[float, float],
    *,
    turning: list[str] | None = None,
) -> Encoding:
    """The image of a ping, and the raw signal if any.

    Args:
        azimuth: `(beams,)` [rad].
        widths: across the plane of the beams, and in it [deg].
        turning: fields of the image's direction, where extras `angle` says it.
    """
    name = site.frame + frame.suffix
    varying = [*STAMP, *(turning or []), "image.data:bytes"]
    image = Template(PROJECTED_IMAGE, projected_image(config, azimuth, name, widths), varying)
    topics = [Topic("image", PROJECTED_IMAGE)]
    signal: Callable[[Reading, int], Buffer] | None = None
    if config.iq:
        signal = _signal(config, azimuth, name, widths, turns=turning is not None)
        topics.append(Topic("raw", RAW_IMAGE))

    def encode(reading: Reading, copy: int) -> tuple[Buffer, ...]:
        rows = np.atleast_2d(eight_bits(config, reading.data[copy]))
        direction: tuple[float, ...] = ()
        if turning is not None:
            angle = float(reading.extras["angle"][copy])
            direction = (-math.sin(angle), math.cos(angle))
        ping = image.encode(*seconds_nanoseconds(reading.t_ns), *direction, rows.T.tobytes())
        return (ping,) if signal is None else (ping, signal(reading, copy))

    return Encoding(tuple(topics), encode, (frame,))


def _signal(
    config: Any, azimuth: NDArray[np.float64], frame: str, widths: tuple[float, float], *, turns: bool
) -> Callable[[Reading, int], Buffer]:
    turning = ["rx_angles[0]:float32"] if turns else []
    raw = Template(RAW_IMAGE, raw_image(config, azimuth, frame, widths), [*STAMP, *turning, "image.data:bytes"])

    def encode(reading: Reading, copy: int) -> Buffer:
        angle = [-float(reading.extras["angle"][copy])] if turns else []
        iq = np.ascontiguousarray(reading.extras["iq"][copy], dtype=np.complex64)
        return raw.encode(*seconds_nanoseconds(reading.t_ns), *angle, iq.tobytes())

    return encode
