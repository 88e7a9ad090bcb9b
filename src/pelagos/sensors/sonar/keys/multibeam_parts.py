"""Parts of a multibeam that follow from its keys: how it points, what others hear, its water column, its noise."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.noise import ambient_level, band_level, directivity_index
from pelagos.acoustics.pulse import processing_gain_db, range_coupling
from pelagos.acoustics.spreading import from_db, to_db
from pelagos.errors import ValidityWarning
from pelagos.sensors.idle_keys import Need, idle
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.keys.devices import device_keys
from pelagos.sensors.sonar.keys.echo_keys import echo_spec
from pelagos.sensors.sonar.ping.emitter import Apertures, Emitter
from pelagos.sensors.sonar.ping.multibeam_column import Column
from pelagos.sensors.sonar.ping.ping_spec import PingSpec
from pelagos.sensors.sonar.ping.swath import Swath

if TYPE_CHECKING:
    from pelagos.sensors.sonar.multibeam import MultibeamConfig

_COLUMN_FROM_M: Final = 0.1  # where a water column begins: nearer is the near field of any array, assumed


_NEEDS: Final = (Need(("labels", "volume_scattering_db", "elements"), "water_column_bins"),)


def warn_of_idle(config: MultibeamConfig, path: str) -> None:
    """Warn of keys that were changed and change nothing."""
    told = idle(config, _NEEDS, device=device_keys(config))
    if config.sectors > 1 and not config.sector_spacing_hz and not {"pitch", "yaw"} & set(config.stabilised):
        told = "'sectors' changes nothing without 'sector_spacing_hz', or 'stabilised' pitch or yaw"
    if told:
        warnings.warn(f"{path}: {told}", ValidityWarning, stacklevel=4)


def emitter(config: MultibeamConfig, context: SensorContext, rays: dict[str, NDArray[Any]]) -> Emitter:
    """This sonar as others hear it."""
    across, along = math.radians(config.beamwidth_across_deg), math.radians(config.beamwidth_along_deg)
    return Emitter(
        context.path,
        config,
        Apertures.of_fan(rays, config.soundings, along, across),
        config.frequency_hz,
        config.bandwidth_hz,
        config.pulse_s,
        config.source_level_db,
        period_ticks(config.rate_hz, context.dt_ns, where=context.path) * context.dt_ns,
        pulse=config.pulse,
    )


def column_of(config: MultibeamConfig) -> Column:
    """The beams of the water column."""
    across, along = math.radians(config.beamwidth_across_deg), math.radians(config.beamwidth_along_deg)
    return Column(config.angles, math.radians(config.swath_deg), across, along, config.elements)


def column_spec(config: MultibeamConfig, context: SensorContext) -> PingSpec:
    """The same sonar as one that gives levels by beam and range [dB]."""
    nearest = max(config.range_min_m, _COLUMN_FROM_M)
    spec = echo_spec(config, context, nearest=nearest, farthest=config.range_max_m, bins=config.water_column_bins)
    return replace(spec, refraction=config.refraction, vehicle_noise=config.vehicle_noise, heard=False)


def swath_of(config: MultibeamConfig) -> Swath:
    """Directions of its beams."""
    return Swath(
        beams=config.soundings,
        rays=config.rays_per_beam,
        moves=config.doppler,
        held=config.stabilised,
        assumed_speed=config.sound_speed_mps,
        coupling_s=range_coupling(config.frequency_hz, config.bandwidth_hz, config.pulse_s, config.pulse),
    )


def noise_power(config: MultibeamConfig, wind: float, rain: float) -> float:
    """Noise intensity behind matched filter and beamformer re the source level at 1 m."""
    ambient = ambient_level(config.frequency_hz, wind, rain_mm_per_h=rain)
    spectral = float(to_db(from_db(ambient) + from_db(config.self_noise_db)))
    index = directivity_index(math.radians(config.beamwidth_across_deg), math.radians(60.0))
    return behind_filter(config, spectral, index)


def behind_filter(config: MultibeamConfig, spectral_db: float = 0.0, directivity_db: float = 0.0) -> float:
    """Intensity of noise of a spectral level behind matched filter and beamformer, see `ping_spec.behind_filter`."""
    gains = processing_gain_db(config.bandwidth_hz, config.pulse_s) + directivity_db
    return float(from_db(band_level(spectral_db, config.bandwidth_hz) - gains - config.source_level_db))


def sector_losses(config: MultibeamConfig, context: SensorContext) -> NDArray[np.float64]:
    """Absorption at each sector's frequency over that at `frequency_hz`, `(sectors,)`, in the water at the world's
    origin, at the surface."""
    steps = (np.arange(config.sectors) - 0.5 * (config.sectors - 1)) * config.sector_spacing_hz
    if not steps.any():
        return np.ones(config.sectors)
    place, t = dr.zeros(jit.Array3f64, 1), jit.Float64(0.0)
    water = context.ocean.temperature(place, t), context.ocean.salinity(place, t), jit.Float64(0.0), config.ph

    def loss(frequency: float) -> float:
        return float(np.array(absorption(jit.Float64(frequency), *water))[0])

    return np.array([loss(config.frequency_hz + step) for step in steps]) / loss(config.frequency_hz)
