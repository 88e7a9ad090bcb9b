"""Frames: poses, readings and the state of a run at one moment. The view draws frames, wherever they come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.sample import Sample
from pelagos.math.so3 import euler_np, matrix_np

_LOST_S: Final = 1.0  # a sensor that says nothing for longer than this, and than so many of its intervals, is lost
_INTERVALS: Final = 3


def old_after_s(rate_hz: float) -> float:
    """Time after which what a sensor said last is no longer true [s]; the page has the same."""
    return max(_INTERVALS / rate_hz, _LOST_S)


@dataclass(frozen=True)
class ShownPose:
    """Of a body.

    Attributes:
        position: `(3,)` world NWU [m].
        attitude: `(4,)` (w, x, y, z), body FLU to world.
        velocity: `(3,)` body FLU [m/s].
        actuators: `(k,)` states, in the vehicle's own units.
    """

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    actuators: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def to_world(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Points `(m, 3)` of the body's frame in the world [m]."""
        return np.asarray(points, dtype=np.float64) @ matrix_np(self.attitude).T + self.position

    @property
    def euler(self) -> tuple[float, float, float]:
        """Roll, pitch and heading of the compass [deg]; pitch positive up."""
        roll, pitch, yaw = np.degrees(euler_np(self.attitude)).tolist()
        return roll, -pitch, -yaw % 360


@dataclass(frozen=True)
class Placed:
    """A sample, and the pose of its vehicle when it was taken."""

    sample: Sample
    pose: ShownPose


@dataclass(frozen=True)
class ShownFrame:
    """A moment.

    Attributes:
        t_ns: simulation time [ns].
        agents: true poses by agent.
        navigation: what vehicles think of where they are, by agent, where that is not the truth.
        movers: poses of bodies on scripted paths and of spawned props, by name.
        samples: readings since the last frame.
        status: of the run: JSON types, see `Pilot.status`.
        jump: time did not go on from the last frame: a reset, or a step back in a recording.
    """

    t_ns: int
    agents: Mapping[str, ShownPose]
    navigation: Mapping[str, ShownPose] = field(default_factory=dict)
    movers: Mapping[str, ShownPose] = field(default_factory=dict)
    samples: Sequence[Placed] = ()
    status: Mapping[str, Any] = field(default_factory=dict)
    jump: bool = False


def between(before: tuple[int, ShownPose], after: tuple[int, ShownPose], t_ns: int) -> ShownPose:
    """The pose at a time between two others; attitude by normalised linear interpolation."""
    (t0, a), (t1, b) = before, after
    if t1 <= t0:
        return b
    part = min(max((t_ns - t0) / (t1 - t0), 0.0), 1.0)
    q = b.attitude if float(a.attitude @ b.attitude) >= 0 else -b.attitude
    turned = (1 - part) * a.attitude + part * q
    return ShownPose(
        (1 - part) * a.position + part * b.position, turned / np.linalg.norm(turned),
        (1 - part) * a.velocity + part * b.velocity, b.actuators,
    )  # fmt: skip
