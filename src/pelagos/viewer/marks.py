"""Marks of a recording's time line: contacts, lost bottom track, GPS fixes, legs of the mission."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.frames import enu_to_nwu_np
from pelagos.messages.motion import PATH
from pelagos.messages.navigation import WRENCH_FIELDS
from pelagos.sensors.sensor import SensorConfig
from pelagos.sim.replay import Recording
from pelagos.viewer.course import Course
from pelagos.viewer.frame import old_after_s

_MARKS: Final = 60
_REACHED_M: Final = 5.0  # from a corner of the plan, or this share of the leg that leads to it
_SHARE: Final = 0.2


def marks(
    recording: Recording, topics: Mapping[str, str], sensors: Mapping[str, SensorConfig], span: tuple[int, int],
    others: Sequence[Mapping[str, Any]] = (),
) -> list[dict[str, Any]]:  # fmt: skip
    """Events, `t` [s] and `text`: contacts, lost DVLs, GPS fixes, and `others`; topics and configurations by sensor."""
    found = [dict(m) for m in others]
    for name, topic in topics.items():
        kind = sensors[name].type
        if kind == "dvl":
            at = recording.times(topic)
            silent = np.diff(at, append=span[1]) > old_after_s(sensors[name].rate_hz) * 1e9
            found += [{"t": float(t) * 1e-9, "text": f"{name} lost"} for t in at[silent]]
        elif kind == "collision":
            found += _contacts(recording, name, topic, sensors[name])
        elif kind == "gps" and recording.count(topic):
            at = recording.times(topic)
            first = np.flatnonzero(np.diff(at, prepend=at[0] - 10**10) > 5 * 10**9)
            found += [{"t": float(at[i]) * 1e-9, "text": "GPS fix"} for i in first]
    inside = [m for m in found if span[0] <= m["t"] * 1e9 <= span[1]]
    return sorted(inside, key=lambda m: float(m["t"]))[:_MARKS]


def _contacts(recording: Recording, name: str, topic: str, config: Any) -> list[dict[str, Any]]:
    """Times at which the vehicle began to touch something."""
    t, values = recording.table(topic, WRENCH_FIELDS)
    touching = np.linalg.norm(values[:, 2:5], axis=1) > config.least_force_n  # behind the two numbers of the stamp
    begins = touching & ~np.concatenate([[False], touching[:-1]])
    return [{"t": float(when), "text": f"{name.partition('.')[0]} touches"} for when in t[begins]]


def planned(recording: Recording) -> dict[str, NDArray[np.float64]]:
    """Corners of the planned ways `(k, 3)` NWU [m] by agent, the start first, as the recording says them."""
    found = {}
    for topic in recording.topics("/plan", type=PATH):
        if not recording.of_first(topic):
            continue
        places = [p.pose.position for p in recording.message(topic, 0).message.poses]
        if len(places) > 1:
            found[topic.split("/")[-2]] = enu_to_nwu_np(np.array([[p.x, p.y, p.z] for p in places]))
    return found


def legs(plans: Mapping[str, NDArray[np.float64]], courses: Mapping[str, Course]) -> list[dict[str, Any]]:
    """Passages of the corners of vehicles' plans: `t` [s] and `text`; none for those that nobody came near."""
    found = []
    for agent, corners in plans.items():
        track = courses.get(agent)
        if track is None:
            continue
        last = len(corners) - 1
        for k, i in enumerate(_passed(corners[:, :2], track.position[:, :2]), start=1):
            if i is not None:
                text = f"{agent}: end of the plan" if k == last else f"{agent}: leg {k + 1} of {last}"
                found.append({"t": float(track.t_ns[i]) * 1e-9, "text": text})
    return found


def _passed(corners: NDArray[np.float64], track: NDArray[np.float64]) -> list[int | None]:
    """Rows of a track `(m, 2)` at which it is nearest to each corner `(k, 2)` but the first, in their order."""
    rows: list[int | None] = []
    begin = 0
    for before, corner in itertools.pairwise(corners):
        near = max(_REACHED_M, _SHARE * float(np.linalg.norm(corner - before)))
        away = np.linalg.norm(track[begin:] - corner, axis=1)
        inside = away < near
        if not inside.any():
            rows.append(None)
            continue
        first = int(np.argmax(inside))
        left = np.flatnonzero(~inside[first:])
        end = first + int(left[0]) if len(left) else len(away)
        begin += first + int(np.argmin(away[first:end]))
        rows.append(begin)
    return rows
