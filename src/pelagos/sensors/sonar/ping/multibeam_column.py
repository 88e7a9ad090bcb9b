"""The water column of a multibeam: what each beam hears from the transducer on, side lobes and all."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import steering_matrix
from pelagos.sensors.schedule import slower
from pelagos.sensors.sonar.ping.receiver import Layout
from pelagos.sensors.sonar.ping.thin_fan_rays import slice_rays
from pelagos.sensors.sonar.profiling_sonar import ProfilingSonarConfig

if TYPE_CHECKING:
    from pelagos.sensors.sonar.multibeam import MultibeamConfig
    from pelagos.sensors.sonar.ping.ping_config import PingConfig

_RAYS: Final = 24  # of a beam: strata across its sector
_SIDE_LOBES: Final = 16  # neighbours on each side whose echoes leak into a beam
_SHARED: Final = (
    "position_m", "orientation_deg", "beams", "range_max_m", "frequency_hz", "pulse", "bandwidth_hz", "pulse_s",
    "source_level_db", "self_noise_db", "wind_speed_mps", "ph", "refraction", "roughness_seed", "iq", "labels",
    "volume_scattering_db",
)  # fmt: skip


def column_config(config: MultibeamConfig) -> PingConfig:
    """The same sonar as one that gives levels by beam and range [dB]."""
    shared: dict[str, Any] = {key: getattr(config, key) for key in _SHARED}
    slow = slower(config.rate_hz, config.range_max_m)
    nearest = max(config.range_min_m, 0.1)
    return ProfilingSonarConfig(
        **shared, rate_hz=slow, range_min_m=nearest, bins=config.water_column_bins, scale="db", doppler=False
    )


def column_layout(config: MultibeamConfig) -> Layout:
    """The multibeam's beams, each with the side lobes of the receive array."""
    width = math.radians(config.beamwidth_across_deg)
    return Layout(
        beams=config.beams,
        sector=float(np.mean(_sectors(config))),
        horizontal_width=width,
        vertical_width=math.radians(config.beamwidth_along_deg),
        azimuths=config.angles,
        steering=steering_matrix(config.angles, width, "hamming", min(_SIDE_LOBES, config.beams - 1)),
    )


def column_rays(config: MultibeamConfig) -> dict[str, NDArray[Any]]:
    """Rays in the multibeam's frame: strata across each beam's sector, spread fore and aft over the transmit beam."""
    width = math.radians(config.beamwidth_along_deg)
    rays = slice_rays(config.angles, _sectors(config), rays=_RAYS, width=width, ways=1)
    for name in ("direction", "along", "aside"):
        ahead, left, fore = rays[name].T
        rays[name] = np.stack([fore, left, -ahead], axis=-1)
    return rays


def _sectors(config: MultibeamConfig) -> NDArray[np.float64]:
    """Angle that belongs to each beam [rad]: half of the way to either neighbour."""
    if config.beams == 1:
        return np.array([math.radians(config.swath_deg)])
    return np.abs(np.gradient(config.angles))
