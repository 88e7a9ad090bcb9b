"""Keys of sonars that find ranges or speeds in a few narrow beams, and can also give the echoes that they evaluate."""

from __future__ import annotations

import warnings
from typing import Any, ClassVar, Final, Self

from pydantic import Field, model_validator

from pelagos.errors import ValidityWarning
from pelagos.sensors.idle_keys import changed, named
from pelagos.sensors.schedule import slower
from pelagos.sensors.sensor import SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.conflicts import check_burst, check_pulse
from pelagos.sensors.sonar.keys.devices import device_keys
from pelagos.sensors.sonar.keys.ping_keys import ColumnBins, Pulse, mounting, with_burst
from pelagos.sensors.sonar.ping.ping_spec import Display, PingSpec
from pelagos.sensors.sonar.ping.sea_state import rain_over, wind_for
from pelagos.sensors.sonar.ping.surface_scattering import TEXTURE_DB

_NEAREST: Final = 0.05  # [m], of echoes
_OF_ECHOES: Final = (
    "pulse", "bandwidth_hz", "pulse_s", "source_level_db", "self_noise_db", "roughness_seed", "volume_scattering_db",
    "lag_s",
)  # fmt: skip


class EchoesConfig(SensorConfig):
    """Keys of sonars that can also give the echoes that they evaluate."""

    STANDS: ClassVar[str] = "keel"
    USUAL_BINS: ClassVar[int] = 512

    frequency_hz: float = Field(default=500e3, ge=200)
    """Frequency [Hz]."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    iq: bool = False
    """Also give the complex signal of each beam by range, before gain."""
    labels: bool = False
    """Also give label and instance of the strongest echo of each beam by range."""
    water_column_bins: ColumnBins = Field(default=0, ge=0, le=16384)
    """Range bins of the echoes of each beam, whose levels come with the reading then; 0: none (with `iq` or `labels`
    512, and 2048 of a DVL)."""
    pulse: Pulse = "chirp"
    """A chirp, compressed by the matched filter, or a tone burst (CW), whose bandwidth is 1/`pulse_s`."""
    bandwidth_hz: float = Field(default=20e3, gt=0)
    """Bandwidth of the pulse [Hz]."""
    pulse_s: float = Field(default=0.5e-3, gt=0)
    """Duration of the pulse [s]."""
    source_level_db: float = Field(default=200.0, ge=0, le=300)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=50.0, ge=-300, le=200)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    wind_speed_mps: float | None = Field(default=None, ge=0, le=60)
    """Wind for ambient noise and the sea surface [m/s]; absent: the scenario's, or that which would raise its waves."""
    roughness_seed: int = Field(default=0, ge=0, lt=2**32)
    """Which realisation of the roughness of all surfaces the sonar sees."""
    volume_scattering_db: float | None = Field(default=None, ge=-200, le=0)
    """Volume backscattering strength Sv of the water [dB re 1/m] in the echoes; absent: that of the ocean's tracer
    `volume_scattering_db`, and clear water where it has none."""

    @model_validator(mode="before")
    @classmethod
    def _burst(cls, values: Any) -> Any:
        return with_burst(values, cls)

    @model_validator(mode="after")
    def _of_burst(self) -> Self:
        check_burst(self)
        check_pulse(self)
        return self

    @property
    def echo_bins(self) -> int:
        """Range bins of the echoes; 0 where none are asked for."""
        return self.water_column_bins or (self.USUAL_BINS if self.iq or self.labels else 0)


def echo_spec(
    config: Any, context: SensorContext, *, nearest: float, farthest: float, bins: int | None = None
) -> PingSpec:
    """The ping whose echoes are given, between ranges along the beams [m]; in its `echo_bins` unless told otherwise."""
    return PingSpec(
        mounting=mounting(config),
        rate_hz=slower(config.rate_hz, farthest),
        bins=config.echo_bins if bins is None else bins,
        range_min_m=max(nearest, _NEAREST),
        range_max_m=farthest,
        frequency_hz=config.frequency_hz,
        bandwidth_hz=config.bandwidth_hz,
        pulse_s=config.pulse_s,
        pulse=config.pulse,
        source_level_db=config.source_level_db,
        self_noise_db=config.self_noise_db,
        wind_speed_mps=wind_for(config.wind_speed_mps, context.ocean, context.path),
        rain_mm_per_h=rain_over(context.ocean),
        ph=config.ph,
        sound_speed_mps=config.sound_speed_mps,
        texture_db=TEXTURE_DB,
        roughness_seed=config.roughness_seed,
        volume_scattering_db=config.volume_scattering_db,
        doppler=False,
        display=Display(scale="db"),
        iq=config.iq,
        labels=config.labels,
    )


def warn_of_idle(config: EchoesConfig, path: str, *more: str) -> None:
    """Warn where a scenario changes keys of the echoes, and `more` of this kind, and does not ask for echoes, or for
    the signal of the second of two pulses."""
    of_device = device_keys(config)
    own = (k for k in (*_OF_ECHOES, *more) if k in type(config).model_fields and k not in of_device)
    idle, without = changed(config, own), "'water_column_bins', 'iq' or 'labels'"
    if config.echo_bins > 0:
        idle, without = ([] if config.iq else [k for k in idle if k == "lag_s"]), "'iq'"
    if idle:
        warnings.warn(f"{path}: {named(idle)} changes nothing without {without}", ValidityWarning, stacklevel=4)
