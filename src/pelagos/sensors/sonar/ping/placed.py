"""Places and attitudes of sonars on the lanes of one that hears them, NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.sensors.sonar.ping.emitter import Emitter

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics


@dataclass(frozen=True)
class Pose:
    """Positions `(m, 3)` [m] and attitudes `(m, 4)` of a vehicle, or of several."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]

    @classmethod
    def of(cls, motion: Kinematics) -> Pose:
        """That of a motion."""
        dr.eval(motion.position, motion.attitude)
        return cls(jit.to_rows(motion.position), jit.to_rows(motion.attitude))

    def of_rows(self, rows: slice, lanes: ReceiverLanes) -> Pose:
        """That of some rows of every tick, on the lanes of a receiver."""
        ticks = lanes.count // lanes.rows
        mine = np.arange(len(self.position)).reshape(ticks, -1)[:, rows].ravel()
        return self.take(mine[lanes.same(len(mine))])

    def take(self, lanes: NDArray[np.int64]) -> Pose:
        """Some lanes."""
        return Pose(self.position[lanes], self.attitude[lanes])


@dataclass(frozen=True)
class ReceiverLanes:
    """Lanes of a receiver: tick by tick, vehicle by vehicle, copy by copy.

    Attributes:
        count: how many.
        carrier: `(m,)` number of the vehicle.
        copies: of the fleet; 0 where one vehicle carries it, which has lanes as any other.
        rows: lanes of a tick.
    """

    count: int
    carrier: NDArray[np.int64]
    copies: int
    rows: int

    @classmethod
    def of(cls, motion: Kinematics, carriers: int, copies: int) -> ReceiverLanes:
        """Those of a motion of so many vehicles."""
        count = dr.width(motion.position)
        if carriers == 1:
            return cls(count, np.zeros(count, np.int64), 0, count)
        return cls(count, np.array(motion.copy).astype(np.int64) // copies, copies, carriers * copies)

    def same(self, count: int) -> NDArray[np.int64]:
        """The lane of the same tick and copy among `count` lanes of another vehicle."""
        lane = np.arange(self.count)
        return lane if count == self.count else lane // self.rows * self.copies + lane % self.copies

    def pose(self, motion: Kinematics) -> Pose:
        """That of a motion, on these lanes."""
        pose = Pose.of(motion)
        return pose if len(pose.position) == self.count else pose.take(self.same(len(pose.position)))


@dataclass(frozen=True)
class Placed:
    """Places of sonars `(sources, m, 3)` [m], and their attitudes `(sources, m, 4)`."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]

    @classmethod
    def of(cls, emitters: Sequence[Emitter], poses: Sequence[Pose]) -> Placed:
        """Those of sonars on vehicles."""
        arm, turn = (
            np.array([getattr(e.mounting, name) for e in emitters], dtype=np.float64)[:, None]
            for name in ("position_m", "q_body_sensor")
        )
        body, q = (np.stack([getattr(pose, name) for pose in poses]) for name in ("position", "attitude"))
        w, v, w2, v2 = q[..., :1], q[..., 1:], turn[..., :1], turn[..., 1:]
        real = w * w2 - (v * v2).sum(axis=-1, keepdims=True)
        return cls(body + rotated(q, arm), np.concatenate([real, w * v2 + w2 * v + np.cross(v, v2)], axis=-1))


def rotated(q: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(q) v for `(..., 4)` and `(..., 3)`."""
    t = 2.0 * np.cross(q[..., 1:], vector)
    return np.asarray(vector + q[..., :1] * t + np.cross(q[..., 1:], t))
