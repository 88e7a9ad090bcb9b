"""Raw echoes of sonars that find ranges or speeds in a few narrow beams: level, complex signal and labels by range."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.sensors.schedule import slower
from pelagos.sensors.sensor import Kinematics, SensorConfig, SensorContext
from pelagos.sensors.sonar.ping.ping_config import ColumnBins, Pulse, check_burst, with_burst
from pelagos.sensors.sonar.ping.pinger import Pinger
from pelagos.sensors.sonar.ping.pulse_pairs import PulsePairs
from pelagos.sensors.sonar.ping.receiver import Layout
from pelagos.sensors.sonar.singlebeam import SinglebeamConfig, cone_rays

_RAYS: Final = 512  # of a beam
_FACET: Final = 2e-3  # [m], edge of the roughness lattice: two rays of a beam should meet two facets, however near
_LOOKS: Final = 128  # of them that tell how its echoes move from pulse to pulse


class EchoesConfig(SensorConfig):
    """Keys of sonars that can also give the echoes that they evaluate."""

    USUAL_BINS: ClassVar[int] = 512

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
    source_level_db: float = Field(default=200.0)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=50.0)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    wind_speed_mps: float = Field(default=5.0, ge=0)
    """Wind for ambient noise and the sea surface [m/s]."""
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
        return self

    @property
    def echo_bins(self) -> int:
        """Range bins of the echoes; 0 where none are asked for."""
        return self.water_column_bins or (self.USUAL_BINS if self.iq or self.labels else 0)


class BeamEchoes:
    """The echoes of a few beams, each a narrow cone.

    Args:
        config: the sonar's; has `frequency_hz` and `ph` besides the keys of `EchoesConfig`.
        context: the sonar's.
        axes: directions of the beams in the sensor frame `(beams, 3)`.
        width: half-power width of each [rad].
        nearest, farthest: of the ranges along the beams [m].
        lag_s: time between the two pulses of a pair [s]; 0 for single pulses.
        **pair: what else `PulsePairs` wants to know of pairs.
    """

    def __init__(
        self, config: Any, context: SensorContext, axes: NDArray[np.float64], *, width: float, nearest: float,
        farthest: float, lag_s: float = 0.0, **pair: Any,
    ) -> None:  # fmt: skip
        nearest = max(nearest, 0.05)
        ping = SinglebeamConfig(
            rate_hz=slower(config.rate_hz, farthest),
            bins=config.echo_bins, range_min_m=nearest, range_max_m=farthest, scale="db", doppler=False,
            **{k: getattr(config, k) for k in _SHARED},
        )  # fmt: skip
        layout = Layout(len(axes), width, width, width, np.zeros(len(axes)), facet=_FACET)
        self.ranges = ping.ranges
        rays, part = beam_cones(axes, width, _RAYS), part_of(context, "echoes")
        self._pairs: PulsePairs | None = None
        if lag_s > 0:
            looks = beam_cones(axes, width, _LOOKS)
            self._pairs = PulsePairs(config, part, ping, layout, axes, rays, looks, lag_s=lag_s, **pair)
        else:
            self._pinger = Pinger(ping, part, rays, layout)

    def extras(self, motion: Kinematics) -> dict[str, NDArray[Any]]:
        """`water_column`, `water_column_truth` [dB], and what `iq` and `labels` ask for, `(m, beams, bins)` each.

        Where pulses come in pairs `iq` is `(m, beams, 2, bins)`.
        """
        if self._pairs is not None:
            return self._pairs.extras(motion)
        data, truth, more = self._pinger.ping(motion)
        found = {"water_column": data, "water_column_truth": truth()}
        if "iq" in more:
            found["iq"] = more["iq"]
        return found | {f"water_column_{k}": more[k] for k in ("label", "instance") if k in more}


_SHARED: Final = (
    "position_m", "orientation_deg", "frequency_hz", "pulse", "bandwidth_hz", "pulse_s", "source_level_db",
    "self_noise_db", "wind_speed_mps", "ph", "roughness_seed", "iq", "labels", "volume_scattering_db",
)  # fmt: skip


def beam_cones(axes: NDArray[np.float64], width: float, count: int) -> dict[str, NDArray[Any]]:
    """`cone_rays` about each of `axes` `(beams, 3)`."""
    cone = cone_rays(width, count)
    rays: dict[str, NDArray[Any]] = {name: np.concatenate([values] * len(axes)) for name, values in cone.items()}
    frames = []
    for axis in axes:
        aside = np.cross([1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0], axis)
        aside /= np.linalg.norm(aside)
        frames.append(np.stack([np.cross(aside, -axis), aside, -axis]))  # the cone's x, y and z
    for name in ("direction", "along"):
        rays[name] = np.concatenate([cone[name] @ frame for frame in frames])
    rays["beam"] = np.repeat(np.arange(len(axes)), count)
    return rays


def part_of(context: SensorContext, name: str) -> Any:
    """The context of a part of a sonar: a random stream of its own, and nobody hears it a second time."""
    changed: dict[str, Any] = {"path": f"{context.path}.{name}", "neighbours": None}
    return SimpleNamespace(**{**vars(context), **changed})
