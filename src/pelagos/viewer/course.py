"""Motion that a recording tells, at any time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.math.frames import enu_to_nwu_np, quaternion_enu_to_nwu_np
from pelagos.messages.motion import ODOMETRY_FIELDS
from pelagos.sim.replay import Recording
from pelagos.viewer.frame import ShownPose, between


@dataclass(frozen=True)
class Course:
    """Motion over time: `t_ns` `(k,)`, position `(k, 3)` NWU [m], attitude `(k, 4)`, velocity `(k, 3)` FLU [m/s]."""

    t_ns: NDArray[np.int64]
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]

    def at(self, t_ns: int) -> ShownPose:
        """The pose at a time; the first before it, the last behind it."""
        k = int(np.clip(np.searchsorted(self.t_ns, t_ns), 1, max(len(self.t_ns) - 1, 1)))
        if len(self.t_ns) == 1:
            return self._pose(0)
        return between((int(self.t_ns[k - 1]), self._pose(k - 1)), (int(self.t_ns[k]), self._pose(k)), t_ns)

    def _pose(self, k: int) -> ShownPose:
        return ShownPose(self.position[k], self.attitude[k], self.velocity[k])


def course(recording: Recording, topic: str) -> Course:
    """The motion that a topic of odometry tells."""
    _, v = recording.table(topic, ODOMETRY_FIELDS)
    attitude = quaternion_enu_to_nwu_np(v[:, [8, 5, 6, 7]])
    return Course(recording.times(topic), enu_to_nwu_np(v[:, 2:5]), attitude, v[:, 9:12])
