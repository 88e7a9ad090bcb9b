"""A recording as the report wants it: one agent's true motion and what its sensors said, as arrays in our frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from pelagos.math.frames import enu_to_nwu_np, quaternion_enu_to_nwu_np
from pelagos.math.so3 import euler_np
from pelagos.messages.motion import ODOMETRY_FIELDS
from pelagos.sim.replay import Channel, Recording


@dataclass(frozen=True)
class RecordedMotion:
    """Motion over time.

    Attributes:
        t: `(k,)` [s].
        position: `(k, 3)` NWU [m].
        attitude: `(k, 4)` wxyz, body FLU to world NWU.
        velocity: `(k, 3)` body FLU [m/s].
    """

    t: NDArray[np.float64]
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]

    def at(self, t: NDArray[np.float64]) -> RecordedMotion:
        """The motion at other times: attitudes of the nearest sample, the rest interpolated."""
        if len(self.t) == 0:
            return self
        nearest = np.clip(np.round(np.interp(t, self.t, np.arange(len(self.t)))).astype(int), 0, len(self.t) - 1)
        return RecordedMotion(
            t, _interpolated(t, self.t, self.position), self.attitude[nearest], _interpolated(t, self.t, self.velocity)
        )

    @property
    def euler(self) -> NDArray[np.float64]:
        """`(k, 3)` roll, pitch, yaw of the body FLU in NWU [rad]; positive pitch looks down."""
        return euler_np(self.attitude)


@dataclass(frozen=True)
class Mission:
    """One agent of a recording.

    Attributes:
        recording: the file.
        agent: name in topics, "auv0" or "env0/auv0".
    """

    recording: Recording
    agent: str
    _tables: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """Name in the scenario."""
        return self.agent.rsplit("/", 1)[-1]

    @cached_property
    def motion(self) -> RecordedMotion:
        """The true motion."""
        return self.odometry(f"/{self.agent}/truth")

    def odometry(self, topic: str) -> RecordedMotion:
        """The motion that a topic of odometry tells."""
        t, v = self.recording.table(topic, ODOMETRY_FIELDS)
        quaternion = v[:, [8, 5, 6, 7]]
        return RecordedMotion(t, enu_to_nwu_np(v[:, 2:5]), quaternion_enu_to_nwu_np(quaternion), v[:, 9:12])

    @cached_property
    def scenario(self) -> dict[str, Any]:
        """The resolved scenario, as data."""
        data = yaml.safe_load(self.recording.attachments.get("scenario.yaml", b"") or b"{}")
        return data if isinstance(data, dict) else {}

    def config(self, sensor: str) -> dict[str, Any]:
        """The resolved configuration of a sensor."""
        agents = self.scenario.get("agents", {})
        entry = agents.get(self.name, agents.get(self.name.rpartition("_")[0], {}))  # a member of a group: auv_3
        found: dict[str, Any] = entry.get("sensors", {}).get(sensor, {})
        return found

    def channels(self, sensor_type: str, message_type: str) -> list[Channel]:
        """Channels of sensors of one type whose messages are of one type, and that have messages."""
        return [
            c for c in self.recording.channels.values()
            if c.topic.startswith(f"/{self.agent}/") and c.about.get("type") == sensor_type
            and c.type == message_type and self.recording.count(c.topic)
        ]  # fmt: skip

    def table(
        self, sensor_type: str, message_type: str, fields: Sequence[str]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Time [s] and numbers (stamp left out) of the first sensor of a type; None where there is none."""
        key = f"{sensor_type} {message_type}"
        if key not in self._tables:
            found = self.channels(sensor_type, message_type)
            self._tables[key] = None
            if found:
                t, values = self.recording.table(found[0].topic, fields)
                self._tables[key] = t, values[:, 2:]
        result: tuple[NDArray[np.float64], NDArray[np.float64]] | None = self._tables[key]
        return result

    @cached_property
    def mounts(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Position [m] and quaternion wxyz of each sensor in the body, by sensor name."""
        found = {}
        base = f"{self.agent}/base_link"
        for recorded in self.recording.messages("/tf_static"):
            for t in recorded.message.transforms:
                if t.header.frame_id == base:
                    p, q = t.transform.translation, t.transform.rotation
                    found[t.child_frame_id.rsplit("/", 1)[-1]] = (
                        np.array([p.x, p.y, p.z]),
                        np.array([q.w, q.x, q.y, q.z]),
                    )
        return found

    def mount(self, sensor_type: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mount of the first sensor of a type; the body's own frame where there is none."""
        for channel in self.recording.channels.values():
            if channel.topic.startswith(f"/{self.agent}/") and channel.about.get("type") == sensor_type:
                return self.mounts.get(channel.about["sensor"], _IDENTITY)
        return _IDENTITY


_IDENTITY = (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def missions(recording: Recording) -> list[Mission]:
    """The agents of a recording: of the first copy, where a fleet was recorded."""
    return [Mission(recording, t[1 : -len("/truth")]) for t in recording.topics("/truth") if recording.of_first(t)]


def _interpolated(
    t: NDArray[np.float64], times: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.stack([np.interp(t, times, column) for column in values.T], axis=-1)
