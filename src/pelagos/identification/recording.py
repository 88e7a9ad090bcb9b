"""Columns of a recording by topic and field."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError, LookupFailed
from pelagos.sim.replay import Recording


def read_recording(path: Path, names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
    """Columns of an MCAP recording on the times of the first one.

    A name is a topic and the fields below its message: `/auv0/pose.pose.position.x`; `t` is the time [s].

    Raises:
        InputError: the recording has no such topic or field.
    """
    wanted = [name for name in dict.fromkeys(names) if name != "t"]
    series = {}
    recording = Recording(path)
    topics = recording.topics()
    for name in wanted:
        topic = max((t for t in topics if name == t or name.startswith(f"{t}.")), key=len, default=None)
        if topic is None:
            raise LookupFailed("topic", name, topics, where=str(path))
        fields = name[len(topic) + 1 :].split(".") if len(name) > len(topic) else []
        times, values = [], []
        for message in recording.messages(topic):
            times.append(message.t_ns * 1e-9)
            values.append(_field(message.message, fields, name, path))
        series[name] = (np.array(times), np.array(values, dtype=np.float64))
    if not series:
        raise InputError(f"{path}: the plan names no topic")
    time = max((t for t, _ in series.values()), key=len)
    return {"t": time, **{name: np.interp(time, t, x) for name, (t, x) in series.items()}}


def _field(message: Any, fields: Sequence[str], name: str, path: Path) -> float:
    value = message
    for key in fields:
        try:
            value = value[int(key)] if key.isdigit() else value[key] if isinstance(value, dict) else getattr(value, key)
        except (AttributeError, KeyError, IndexError, TypeError):
            raise InputError(f"{path}: {name}: the message has no field {key!r}") from None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{path}: {name} is not a number but {type(value).__name__}; name one of its fields") from None
