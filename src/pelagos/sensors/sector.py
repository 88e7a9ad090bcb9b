"""Sonars whose beams lie side by side in a sector: keys, rays and beams of imaging and profiling sonars."""

from __future__ import annotations

import math
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.acoustics.beam_pattern import line_length, line_np, steering_matrix
from pelagos.sensors.ping import PingConfig
from pelagos.sensors.reception import Layout

_HIGHEST: Final = math.radians(80.0)
_SIDE_LOBE_RAYS: Final = 0.12  # density of rays in side lobes, on the axis 1.35
_BLOCK: Final = 16  # beams: the width of a vector
_STEP: Final = 0.7548776662466927  # additive recurrence of the plastic number: evenly spread in two dimensions
_STEP2: Final = 0.5698402909980532


class SectorConfig(PingConfig):
    """Keys of sonars whose beams lie side by side in the x-y plane of the sensor frame."""

    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the sector."""
    horizontal_aperture_deg: float = Field(default=130.0, gt=0, le=170)
    """Sector [deg], from the first beam's outer edge to the last one's."""
    vertical_beamwidth_deg: float = Field(default=20.0, gt=0, le=90)
    """Half-power width of the fan in elevation [deg], one way."""
    beamwidth_deg: float = Field(default=1.0, gt=0, le=20)
    """Half-power width of a receive beam at broadside [deg]."""
    shading: Literal["uniform", "light", "hamming", "hann"] = "light"
    """Weights of the receive array: side lobes at -13, -21, -43 and -31 dB."""
    side_lobe_beams: int = Field(default=8, ge=0, le=256)
    """Neighbours on each side whose echoes leak into a beam."""
    vertical_side_lobes: int = Field(default=1, ge=0, le=8)
    """Side lobes of the fan above and below its main lobe that rays are cast into (-26.5 dB there and back)."""
    rays_per_beam: int = Field(default=96, ge=4, le=4096)
    """Rays a beam, stratified in elevation."""

    @property
    def azimuths(self) -> NDArray[np.float64]:
        """Beam directions `(beams,)` [rad], positive to the left, from left to right as an image's columns are."""
        sector = math.radians(self.horizontal_aperture_deg)
        return np.asarray(sector * (0.5 - (np.arange(self.beams) + 0.5) / self.beams))


def fan_rays(config: SectorConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame, `rays_per_beam` for each beam (see `Fan`).

    Elevation strata reach to the nulls of the vertical pattern beyond its chosen side lobes, and are thinner where the
    pattern is strong; each holds one ray. Neighbours in memory are neighbours in azimuth, whose patches are alike, by
    blocks of beams whose bins fit into a core's cache. Rays stand at low-discrepancy places in their strata and across
    the beam's sector.
    """
    beams, rays = config.beams, config.rays_per_beam
    length = line_length(math.radians(config.vertical_beamwidth_deg))
    limit = min(math.asin(min((1.0 + config.vertical_side_lobes) / length, 1.0)), _HIGHEST)
    grid = np.linspace(-limit, limit, 2001)
    main = np.abs(np.sin(grid)) * length < 1.0
    density = np.where(main, 0.35 + line_np(np.sin(grid), length) ** 2, _SIDE_LOBE_RAYS)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    edges = np.interp(np.linspace(0, share[-1], rays + 1), share, grid)
    k, j = (a.ravel() for a in np.meshgrid(np.arange(rays), np.arange(beams), indexing="ij"))
    order = np.lexsort((j, k, j // _BLOCK))
    k, j = k[order], j[order]
    place = (0.5 + _STEP * j + _STEP2 * k) % 1.0
    low, high = edges[k], edges[k + 1]
    elevation = low + place * (high - low)
    width = math.radians(config.horizontal_aperture_deg) / beams
    azimuth = config.azimuths[j] + ((0.5 + _STEP * k + _STEP2 * j) % 1.0 - 0.5) * width
    ce, se, ca, sa = np.cos(elevation), np.sin(elevation), np.cos(azimuth), np.sin(azimuth)
    direction = np.stack([ce * ca, ce * sa, se], axis=-1)
    middle = config.azimuths[j]
    return {
        "direction": direction,
        "aside": np.stack([ce * np.cos(middle), ce * np.sin(middle), se], axis=-1) - direction,
        "along": np.stack([-se * ca, -se * sa, ce], axis=-1),
        "lower": low - elevation,
        "upper": high - elevation,
        "weight": width * (np.sin(high) - np.sin(low)) * line_np(se, length) ** 4,
        "beam": j,
    }


def layout(config: SectorConfig) -> Layout:
    """Beams evenly spread over the sector, each with the side lobes of the receive array."""
    width = math.radians(config.beamwidth_deg)
    return Layout(
        beams=config.beams,
        sector=math.radians(config.horizontal_aperture_deg) / config.beams,
        horizontal_width=width,
        vertical_width=math.radians(config.vertical_beamwidth_deg),
        azimuths=config.azimuths,
        steering=steering_matrix(config.azimuths, width, config.shading, config.side_lobe_beams),
    )
