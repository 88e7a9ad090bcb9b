"""A recording as a rosbag2 folder, for `ros2 bag`."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from pelagos.bridges.door import LABELS
from pelagos.bridges.part import Part
from pelagos.bridges.tap import STRING, text_message
from pelagos.errors import InputError


def write_rosbag(
    recording: str | Path, folder: str | Path, *, start_s: float = 0.0, end_s: float = float("inf"),
    only: Sequence[str] = (),
) -> int:  # fmt: skip
    """Write a recording as a rosbag2 folder (MCAP, metadata version 9); the number of messages.

    The table of labels becomes the latched topic /labels, as in a run with ROS 2.

    Args:
        recording: whole or cut off.
        folder: a new one.
        start_s, end_s, only: which part, as of `Part`.

    Raises:
        InputError: the folder exists, or the part cannot be.
        OSError: it cannot be written; nothing is left of it.
        RecordingError: there is no such recording.
    """
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
    from rosbags.rosbag2 import StoragePlugin, Writer

    from pelagos.messages.store import typestore

    if Path(folder).exists():
        raise InputError(f"{folder}: exists already; give another folder")
    part, count, never = Part(recording, start_s=start_s, end_s=end_s, only=only), 0, QosTime(0, 0)
    latched = Qos(
        QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, never, never,
        QosLiveliness.SYSTEM_DEFAULT, never, False,
    )  # fmt: skip
    with _new_folder(Path(folder)), Writer(Path(folder), version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        connections = {
            number: bag.add_connection(
                channel.topic,
                channel.type,
                typestore=typestore(),
                offered_qos_profiles=[latched] if channel.latched else [],
            )
            for number, channel in part.channels.items()
        }
        known = {channel.topic for channel in part.channels.values()}
        if part.legend and LABELS not in known and (not only or LABELS.startswith(tuple(only))):
            labels = bag.add_connection(LABELS, STRING, typestore=typestore(), offered_qos_profiles=[latched])
            bag.write(labels, part.first_ns, text_message(part.legend))
            count += 1
        for message in part.messages():
            bag.write(connections[message.channel], message.t_ns, bytes(message.data))
            count += 1
    return count


@contextmanager
def _new_folder(folder: Path) -> Iterator[None]:
    """Nothing of a folder is left after an error, which tells its name."""
    try:
        yield
    except BaseException as error:
        shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(folder)) from error
        raise
