"""A tap on a recording: every message of a run, as the recording's own bytes, for doors to send on.

`Tap` stands where a recording's file stands (`sim/mcap_writer.py`), and hands everything on to the file, if any.
What was encoded once is thus written and sent; a run with doors gives the same recording as one without.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pelagos.bridges.transport import Buffer
from pelagos.messages.store import make, schema, serialize
from pelagos.sim.mcap_writer import McapWriter
from pelagos.sim.record import LATCHED_KEY

STRING = "std_msgs/msg/String"


@dataclass(frozen=True)
class Channel:
    """A topic of a run.

    Attributes:
        number: in messages.
        topic: "/auv0/imu/data_raw".
        type: "sensor_msgs/msg/Imu".
        about: agent, sensor, type and rate, where they apply.
        latched: late joiners want the last message.
    """

    number: int
    topic: str
    type: str
    about: Mapping[str, str]
    latched: bool


class Message(NamedTuple):
    """One message on its way out: simulation time [ns], channel, CDR bytes."""

    t_ns: int
    channel: int
    data: Buffer


class Tap:
    """See the module's docstring.

    Attributes:
        path: of the file; an empty path without one.
        channels: by number.
    """

    def __init__(self, file: McapWriter | None = None) -> None:
        self.path = Path() if file is None else file.path
        self.channels: dict[int, Channel] = {}
        self.attachments: dict[str, bytes] = {}
        self._file = file
        self._types: dict[int, str] = {}
        self._waiting: list[Message] = []

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """See `McapWriter`."""
        number = len(self._types) + 1 if self._file is None else self._file.add_schema(name, encoding, data)
        self._types[number] = name
        return number

    def add_channel(self, topic: str, schema_id: int, encoding: str, metadata: Mapping[str, str]) -> int:
        """See `McapWriter`."""
        if self._file is None:
            number = len(self.channels) + 1
        else:
            number = self._file.add_channel(topic, schema_id, encoding, metadata)
        latched = "transient_local" in metadata.get(LATCHED_KEY, "")
        self.channels[number] = Channel(number, topic, self._types[schema_id], dict(metadata), latched)
        return number

    def add_message(self, channel: int, t_ns: int, data: Buffer) -> None:
        """See `McapWriter`."""
        self._waiting.append(Message(t_ns, channel, data))
        if self._file is not None:
            self._file.add_message(channel, t_ns, data)

    def add_messages(self, channel: int, t_ns: NDArray[np.int64], rows: NDArray[np.uint8]) -> None:
        """See `McapWriter`."""
        self._waiting += [Message(t, channel, row.data) for t, row in zip(t_ns.tolist(), rows, strict=True)]
        if self._file is not None:
            self._file.add_messages(channel, t_ns, rows)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """See `McapWriter`."""
        if self._file is not None:
            self._file.add_metadata(name, values)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """See `McapWriter`."""
        self.attachments[name] = data
        if self._file is not None:
            self._file.add_attachment(name, media_type, data)

    def flush(self) -> None:
        """See `McapWriter`."""
        if self._file is not None:
            self._file.flush()

    def close(self) -> None:
        """See `McapWriter`."""
        if self._file is not None:
            self._file.close()

    def declare(self, topic: str, type_name: str, about: Mapping[str, str] | None = None) -> int:
        """A further topic, of the doors' own."""
        number = next((n for n, name in self._types.items() if name == type_name), None)
        if number is None:
            number = self.add_schema(type_name, "ros2msg", schema(type_name))
        return self.add_channel(topic, number, "cdr", about or {})

    def declare_live(self, topic: str, type_name: str, about: Mapping[str, str] | None = None) -> int:
        """A further topic that doors alone say: no recording has it."""
        number = -1 - len(self.channels)
        self.channels[number] = Channel(number, topic, type_name, dict(about or {}), latched=False)
        return number

    def say(self, channel: int, t_ns: int, data: Buffer) -> None:
        """A message of a topic that doors alone say."""
        self._waiting.append(Message(t_ns, channel, data))

    def take(self) -> list[Message]:
        """Readings since the last time, in order of time."""
        waiting, self._waiting = self._waiting, []
        waiting.sort(key=_time)
        return waiting


def _time(message: Message) -> int:
    return message.t_ns


def text_message(text: str) -> bytes:
    """CDR bytes of std_msgs/String."""
    return serialize(STRING, make(STRING, data=text))
