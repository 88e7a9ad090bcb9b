"""Imaging sonars as ROS 2 messages: ProjectedSonarImage, a picture of the fan, the raw signal if any."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.messages.encoding import PROJECTED, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.fan import FanPreview
from pelagos.messages.pictures import COMPRESSED_IMAGE, compressed_image, jpeg
from pelagos.messages.store import header, make, vector3
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Reading

PROJECTED_IMAGE: Final = "marine_acoustic_msgs/msg/ProjectedSonarImage"
RAW_IMAGE: Final = "marine_acoustic_msgs/msg/RawSonarImage"
PREVIEW_QUALITY: Final = 80
_UINT8, _FLOAT32 = 0, 8  # SonarImageData.dtype


def imaging_sonar(config: Any, site: Site) -> Encoding:
    """Data `(n, beams, bins)` as 8 bits over the configured dynamic range, with range-major rows."""
    azimuth = np.asarray(config.azimuths, dtype=np.float64)
    frame = site.frame + PROJECTED.suffix
    widths = (config.vertical_beamwidth_deg, config.beamwidth_deg)
    image = Template(PROJECTED_IMAGE, projected_image(config, azimuth, frame, widths), [*STAMP, "image.data:bytes"])
    preview = FanPreview(azimuth, config.range_min_m, config.range_max_m, config.bins)
    topics = [Topic("image", PROJECTED_IMAGE), Topic("preview/compressed", COMPRESSED_IMAGE)]
    raw: Template | None = None
    if config.iq:
        raw = Template(RAW_IMAGE, raw_image(config, azimuth, frame, widths), [*STAMP, "image.data:bytes"])
        topics.append(Topic("raw", RAW_IMAGE))

    def encode(reading: Reading, copy: int) -> tuple[Buffer, ...]:
        polar = eight_bits(config, reading.data[copy])
        time = seconds_nanoseconds(reading.t_ns)
        out: list[Buffer] = [
            image.encode(*time, polar.T.tobytes()),
            compressed_image(site.frame, reading.t_ns, jpeg(preview(polar), quality=PREVIEW_QUALITY)),
        ]
        if raw is not None:
            signal = np.ascontiguousarray(reading.extras["iq"][copy], dtype=np.complex64)
            out.append(raw.encode(*time, signal.tobytes()))
        return tuple(out)

    return Encoding(tuple(topics), encode, (PROJECTED,))


def eight_bits(config: Any, image: NDArray[Any]) -> NDArray[np.uint8]:
    """Levels 0 .. 255 over the configured dynamic range, whatever the configured scale."""
    if config.scale == "unit":
        level = image
    else:
        decibels = image if config.scale == "db" else 10.0 * np.log10(np.maximum(image, 1e-20))
        level = np.clip((decibels - config.floor_db) / config.dynamic_range_db, 0.0, 1.0)
    return np.asarray(level * 255.0 + 0.5, dtype=np.float32).astype(np.uint8)


def ranges_of(config: Any) -> NDArray[np.float32]:
    """`(bins,)` middle of each range bin [m]."""
    edges = np.linspace(config.range_min_m, config.range_max_m, config.bins + 1)
    return np.asarray(0.5 * (edges[1:] + edges[:-1]), dtype=np.float32)


def projected_image(config: Any, azimuth: NDArray[np.float64], frame: str, widths: tuple[float, float]) -> Any:
    """Beams lie in the y-z plane of a frame with y to starboard; azimuth `(beams,)` [rad] from z, positive to port.

    Args:
        config: of the sonar.
        azimuth: direction of each beam.
        frame: its id.
        widths: half-power widths across the plane of the beams, and in it [deg].
    """
    directions = [vector3(0.0, -math.sin(a), math.cos(a)) for a in azimuth]
    return make(
        PROJECTED_IMAGE,
        header=header(frame),
        ping_info=_ping_info(config, widths),
        beam_directions=directions,
        ranges=ranges_of(config),
        image=_data(len(azimuth), _UINT8, len(azimuth) * config.bins),
    )


def raw_image(config: Any, azimuth: NDArray[np.float64], frame: str, widths: tuple[float, float]) -> Any:
    """In-phase and quadrature as pairs of float32, beam after beam; arguments as of `projected_image`."""
    beams = len(azimuth)
    zeros = np.zeros(beams, dtype=np.float32)
    bin_width = (config.range_max_m - config.range_min_m) / config.bins
    return make(
        RAW_IMAGE,
        header=header(frame),
        ping_info=_ping_info(config, widths),
        sample_rate=NOMINAL_SOUND_SPEED / (2 * bin_width),
        samples_per_beam=config.bins,
        sample0=round(config.range_min_m / bin_width),
        tx_delays=zeros,
        tx_angles=zeros,
        rx_angles=np.asarray(-azimuth, dtype=np.float32),
        image=_data(beams, _FLOAT32, beams * config.bins * 8),
    )


def _ping_info(config: Any, widths: tuple[float, float]) -> Any:
    across, within = (np.array([math.radians(w)], dtype=np.float32) for w in widths)
    return make(
        "marine_acoustic_msgs/msg/PingInfo",
        frequency=float(config.frequency_hz),
        sound_speed=0.0,  # not reported
        tx_beamwidths=across,
        rx_beamwidths=within,
    )


def _data(beams: int, dtype: int, size: int) -> Any:
    return make(
        "marine_acoustic_msgs/msg/SonarImageData",
        is_bigendian=False,
        dtype=dtype,
        beam_count=beams,
        data=np.zeros(size, dtype=np.uint8),
    )
