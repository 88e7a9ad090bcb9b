"""Columns of a recording by topic and field."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError, LookupFailed
from pelagos.identification.run_steps import RunSteps, run_steps
from pelagos.math.so3 import euler_np
from pelagos.messages.numbers import names_in
from pelagos.sim.replay import Recording

_ANGLES: Final = ("roll", "pitch", "yaw")
"""Fields that a quaternion has besides its own: Euler angles zyx [rad], in the frames of the message."""
_HOLE: Final = 5.0  # median steps of a topic without a message, within which nothing is made up

Stamped = tuple[NDArray[np.int64], NDArray[np.float64]]
"""Stamps [ns] and values."""


def read_recording(
    path: Path, names: Sequence[str], held: Collection[str] = ()
) -> tuple[dict[str, NDArray[np.float64]], float]:
    """Columns of an MCAP recording, and the time of its first message [s]: see `read_run`."""
    return read_run(path, names, held)[:2]


def read_run(
    path: Path, names: Sequence[str], held: Collection[str] = ()
) -> tuple[dict[str, NDArray[np.float64]], float, RunSteps | None]:
    """Columns of an MCAP recording on the times of its most frequent topic, as far as all topics go.

    A name is a topic and the fields below its message: `/auv0/pose.pose.position.x`; below a quaternion `roll`, `pitch`
    and `yaw`; `t` is the time since the first message [s]. In longer holes of a topic, columns are NaN.

    Args:
        path: of the recording.
        names: of the columns.
        held: those whose value stays from one message to the next, such as commands; others are lines between them.

    Returns:
        the columns, the time of the first message [s], and the steps of the run that it is of.

    Raises:
        InputError: the recording has no such topic or field, or a topic's times are not in order.
    """
    wanted = [name for name in dict.fromkeys(names) if name != "t"]
    recording = Recording(path)
    topics = recording.topics()
    if not topics:
        raise InputError(f"{path}: holds no topic that can be read; was it cut short? Try pelagos recover")
    stamped = _all_series(recording, topics, wanted, path)
    if not stamped:
        raise InputError(f"{path}: the plan names no topic")
    origin = min(int(ns[0]) for ns, _ in stamped.values())
    series = {name: ((ns - origin).astype(np.float64) * 1e-9, x) for name, (ns, x) in stamped.items()}
    moving = [t for name, (t, _) in series.items() if name not in held] or [t for t, _ in series.values()]
    time = max(moving, key=len)
    first, last = max(float(t[0]) for t, _ in series.values()), min(float(t[-1]) for t in moving)
    time = time[(time >= first - 1e-9) & (time <= last + 1e-9)]
    if len(time) < 2:
        raise InputError(
            f"{path}: its topics have no time in common: one begins at {origin / 1e9 + first:.10g} s, "
            f"another ends at {origin / 1e9 + last:.10g} s"
        )
    columns = {"t": time, **{name: _on(time, name in held, *series[name]) for name in series}}
    return columns, origin * 1e-9, run_steps(recording, [name for name in wanted if name not in held])


def read_topic(path: Path, names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
    """Columns of one topic of a recording, message by message; `t` is the time since its first message [s].

    Raises:
        InputError: the recording has no such topic or field, or the names are of several topics.
    """
    recording = Recording(path)
    wanted = [name for name in names if name != "t"]
    stamped = _all_series(recording, recording.topics(), wanted, path)
    first = stamped[wanted[0]][0]
    for name, (stamps, _) in stamped.items():
        if not np.array_equal(stamps, first):
            raise InputError(f"{path}: {wanted[0]} and {name} are of topics with other times: name fields of one topic")
    return {"t": (first - first[0]).astype(np.float64) * 1e-9, **{name: x for name, (_, x) in stamped.items()}}


def _all_series(recording: Recording, topics: Collection[str], names: Sequence[str], path: Path) -> dict[str, Stamped]:
    """Series by name; the messages of a topic are decoded once for all names."""
    by_topic: dict[str, dict[str, list[str]]] = {}
    for name in names:
        topic = max((t for t in topics if name == t or name.startswith(f"{t}.")), key=len, default=None)
        if topic is None:
            raise LookupFailed(
                "topic", name, topics, where=f"{path}: a column is a topic and its fields, /topic.field.x"
            )
        fields = name[len(topic) + 1 :].split(".") if len(name) > len(topic) else []
        by_topic.setdefault(topic, {})[name] = fields
    found = {}
    for topic, wanted in by_topic.items():
        times, rows = [], []
        for recorded in recording.messages(topic):
            message = recorded.message
            times.append(recorded.t_ns)
            rows.append([_field(message, fields, name, path) for name, fields in wanted.items()])
        stamps = np.array(times, dtype=np.int64)
        for (name, fields), values in zip(wanted.items(), np.array(rows, dtype=np.float64).T, strict=True):
            found[name] = _series(stamps, values, topic, fields, path)
    return {name: found[name] for name in names}


def _series(t: NDArray[np.int64], x: NDArray[np.float64], topic: str, fields: Sequence[str], path: Path) -> Stamped:
    if (np.diff(t) <= 0).any():
        k = int(np.argmax(np.diff(t) <= 0))
        raise InputError(f"{path}: {topic} has a message of {t[k + 1] / 1e9:.10g} s after one of {t[k] / 1e9:.10g} s")
    if fields and fields[-1] in _ANGLES:
        x = np.unwrap(x)  # a line from 179 to -179 deg would turn the wrong way
    return t, x


def _on(time: NDArray[np.float64], held: bool, t: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    after = np.searchsorted(t, time + 1e-9, side="right")
    if held:
        return np.asarray(x[np.clip(after - 1, 0, len(t) - 1)])
    found = np.interp(time, t, x)
    if len(t) > 1:
        before = np.clip(after - 1, 0, len(t) - 2)
        inside = np.abs(time - t[before]) > 1e-9
        found[inside & (np.diff(t)[before] > _HOLE * np.median(np.diff(t)))] = np.nan
    return np.asarray(found)


def _labels(message: Any) -> tuple[str, ...]:
    """Names of the numbers of an array of one dimension whose label has them (`messages.numbers.LabelledRow`)."""
    layout = getattr(message, "layout", None)
    if layout is None or len(layout.dim) != 1 or " [" not in layout.dim[0].label:
        return ()
    return names_in(layout.dim[0].label)


def _field(message: Any, fields: Sequence[str], name: str, path: Path) -> float:
    value = message
    for key in fields:
        try:
            if (labels := _labels(value)) and not hasattr(value, key):
                if key not in labels:
                    raise LookupFailed("number", key, labels, where=f"{path}: {name}")
                value = value.data[labels.index(key)]
            elif key in _ANGLES and all(hasattr(value, c) for c in "wxyz"):
                turn = euler_np(np.array([[value.w, value.x, value.y, value.z]]))
                value = float(turn[0, _ANGLES.index(key)])
            else:
                value = (
                    value[int(key)] if key.isdigit() else value[key] if isinstance(value, dict) else getattr(value, key)
                )
        except (AttributeError, KeyError, IndexError, TypeError):
            raise InputError(f"{path}: {name}: the message has no field {key!r}") from None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{path}: {name} is not a number but {type(value).__name__}; name one of its fields") from None
