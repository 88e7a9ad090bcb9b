"""Raw echoes of sonars that find ranges or speeds in a few narrow beams: level, complex signal and labels by range."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sensors.noise import part_path
from pelagos.sensors.sonar.ping.aperture import round_aperture
from pelagos.sensors.sonar.ping.cone_rays import cone_rays
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.ping_spec import PingSpec
from pelagos.sensors.sonar.ping.pinger import Pinger
from pelagos.sensors.sonar.ping.pulse_pairs import NarrowBeams, Pairs, PulsePairs

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics, SensorContext
    from pelagos.sensors.sonar.ping.interference import Neighbours

_RAYS: Final = 512  # of a beam
_FACET: Final = 2e-3  # [m], edge of the roughness lattice: two rays of a beam should meet two facets, however near
_LOOKS: Final = 128  # of them that tell how its echoes move from pulse to pulse


class BeamEchoes:
    """The echoes of a few beams, each a narrow cone.

    Args:
        ping: see `PingSpec`.
        context: the sonar's.
        axes: directions of the beams in the sensor frame `(beams, 3)`.
        width: half-power width of each [rad].
        pairs: of pulses; None: single ones.
    """

    def __init__(
        self, ping: PingSpec, context: SensorContext, axes: NDArray[np.float64], *, width: float,
        pairs: Pairs | None = None,
    ) -> None:  # fmt: skip
        layout = Layout(
            len(axes), width, width, width, np.zeros(len(axes)), facet=_FACET, aperture=round_aperture(axes, width)
        )
        self.ranges = ping.ranges
        rays, part = beam_cones(axes, width, _RAYS), part_of(context, "echoes")
        self._pairs: PulsePairs | None = None
        if pairs is not None:
            looks = beam_cones(axes, width, _LOOKS)
            self._pairs = PulsePairs(part, ping, NarrowBeams(layout, axes, rays, looks), pairs)
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


def part_of(context: SensorContext, name: str, *, neighbours: Neighbours | None = None) -> Any:
    """The context of a part of a sonar: a random stream of its own, and nobody hears it a second time."""
    changed: dict[str, Any] = {"path": part_path(context.path, name), "neighbours": neighbours}
    return SimpleNamespace(**{**vars(context), **changed})
