"""A sonar as others hear it: its pulse, and how its beams send."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, line_np, weighted_line_np
from pelagos.acoustics.interference import Sent
from pelagos.jit import Array
from pelagos.sensors.mount import Mounted
from pelagos.sensors.sonar.ping.aperture import BEHIND, Aperture

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics

_LEAK: Final = 1e-4  # of the power on axis, beside all lobes; assumed
_FEW_BEAMS: Final = 8


@dataclass(frozen=True, eq=False)
class Apertures:
    """Beams that hear or send, as rectangular apertures: arrays `(beams, 3)` of unit vectors in the sensor frame.

    Attributes:
        axis: where each beam looks.
        side, up: along the edges of its aperture.
        side_length, up_length: of the edges [wavelengths].
        shading: of the array along `side`.
        steered: one array along `side` makes all beams: they differ by the sine of their angle to it.
    """

    axis: NDArray[np.float64]
    side: NDArray[np.float64]
    up: NDArray[np.float64]
    side_length: float
    up_length: float
    shading: str = "uniform"
    steered: bool = False

    @classmethod
    def of_array(cls, aperture: Aperture) -> Apertures:
        """The beams of a steered array."""
        side, up = (np.broadcast_to(v, aperture.axis.shape) for v in (aperture.side, aperture.up))
        lengths = aperture.side_length, aperture.up_length
        return cls(aperture.axis, side, up, *lengths, aperture.shading, aperture.steered)

    @classmethod
    def of_fan(cls, rays: dict[str, NDArray[Any]], beams: int, across: float, along: float) -> Apertures:
        """Beams of a ray pattern: half-power widths `along` the thin direction of its strata and `across` it [rad]."""
        order = np.argsort(rays["beam"], kind="stable").reshape(beams, -1)
        weight = rays["weight"][order][..., None]
        middle = rays["direction"] + rays["aside"]  # rays stand at places across their beams
        axis = _unit((middle[order] * weight).sum(axis=1))
        thin = (rays["along"][order] * weight).sum(axis=1) / weight.sum(axis=1)
        round_ = np.linalg.norm(thin, axis=-1, keepdims=True) < 0.3  # a cone: any direction square to its axis
        thin = np.where(round_, np.eye(3)[np.abs(axis).argmin(axis=-1)], thin)
        up = _unit(thin - (thin * axis).sum(axis=-1, keepdims=True) * axis)
        return cls(axis, np.cross(up, axis), up, line_length(across), line_length(along))

    def power(self, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """One-way power pattern `(..., beams)` in directions `(..., 3)`, 1 on axis."""
        side, up, ahead = (_dots(direction[..., None, :], v) for v in (self.side, self.up, self.axis))
        if self.steered:
            side = side - self._sines
        across = weighted_line_np(side, self.side_length, self.shading)
        pattern = (across * line_np(up, self.up_length)) ** 2
        return np.asarray(np.maximum(pattern, _LEAK) * np.where(ahead > 0.0, 1.0, BEHIND))

    def loudest(self, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """`power` of whichever beam hears best in directions `(m, 3)`: `(m,)`."""
        if not self.steered or len(self.axis) < _FEW_BEAMS:
            return np.asarray(self.power(direction).max(axis=-1))
        towards = _dots(direction, self.side[0])
        nearest = np.abs(self._sines[None, :] - towards[:, None]).argmin(axis=-1)
        across = weighted_line_np(towards - self._sines[nearest], self.side_length, self.shading)
        pattern = (across * line_np(_dots(direction, self.up[0]), self.up_length)) ** 2
        ahead = _dots(direction, self.axis[nearest])
        return np.asarray(np.maximum(pattern, _LEAK) * np.where(ahead > 0.0, 1.0, BEHIND))

    def same(self, other: Apertures) -> bool:
        """True where both have the same patterns."""
        numbers = ("side_length", "up_length", "shading", "steered")
        return all(getattr(self, name) == getattr(other, name) for name in numbers) and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in ("axis", "side", "up")
        )

    @cached_property
    def _sines(self) -> NDArray[np.float64]:
        return np.asarray((self.axis * self.side).sum(axis=-1))


@dataclass(frozen=True)
class Emitter:
    """A sonar as others hear it.

    Attributes:
        path: "agent.sensor".
        mounting: where it sits on its vehicle.
        apertures: its beams.
        frequency_hz, bandwidth_hz, pulse_s, source_level_db: of its pulse.
        period_ns: between two pings; the first is at t = 0.
        angle: for heads that turn, their direction about z [rad] at ticks `(m,)`.
        pulse: "chirp" or "cw".
        faintest_db: level of a pulse that nobody would notice in its own noise [dB re 1 uPa].
    """

    path: str
    mounting: Mounted
    apertures: Apertures
    frequency_hz: float
    bandwidth_hz: float
    pulse_s: float
    source_level_db: float
    period_ns: int
    angle: Callable[[NDArray[np.int64]], NDArray[np.float64]] | None = None
    pulse: str = "chirp"
    faintest_db: float = -math.inf

    @property
    def sent(self) -> Sent:
        """Its pulse."""
        return Sent(self.frequency_hz, self.bandwidth_hz, self.pulse_s, self.pulse)

    def hears_from(self, direction: Sequence[float], motion: Kinematics) -> Array:
        """One-way power pattern of its beams in a direction of the sensor frame, lanes by beams: of a head that turns,
        as the head stands."""
        towards, lanes = np.asarray([direction], dtype=np.float64), dr.width(motion.position)
        if self.angle is None:
            power = np.tile(self.apertures.power(towards), (lanes, 1))
        else:
            angle = self.angle(np.array(motion.tick).astype(np.int64))
            power = self.apertures.power(headed(np.tile(towards, (lanes, 1)), angle))
        pattern = jit.Float(jit.padded(power.astype(np.float32)))
        dr.make_opaque(pattern)
        return pattern

    @property
    def agent(self) -> str:
        """The vehicle that carries it."""
        return self.path.split(".")[0]


def headed(local: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Directions `(m, 3)` in the frame of a head that has turned by angles `(m,)` about z [rad]."""
    c, s, (x, y, z) = np.cos(angle), np.sin(angle), local.T
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)


def _dots(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Products of vectors, term by term: their bytes do not depend on how many there are, as those of `@` may."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
