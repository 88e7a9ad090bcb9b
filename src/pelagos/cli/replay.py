"""`pelagos replay`: a recording, played out again to ROS 2 or a viewer."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pelagos.cli.console import out
from pelagos.errors import InputError


@dataclass(frozen=True)
class ReplayOptions:
    """Options of the command line; see `pelagos replay --help`."""

    ros2: bool = False
    foxglove: bool = False
    rosbag: Path | None = None
    rate: float = 1.0
    start_s: float = 0.0
    end_s: float = float("inf")
    topics: tuple[str, ...] = ()
    loop: bool = False


def replay(path: Path, options: ReplayOptions) -> None:
    """Play it.

    Raises:
        InputError: there is nowhere to play it to.
    """
    from pelagos.bridges.playback import Playback, write_rosbag

    if options.rosbag is not None:
        count = write_rosbag(path, options.rosbag)
        out.print(f"{count} messages written to {options.rosbag}", markup=False)
        return
    if not (options.ros2 or options.foxglove):
        raise InputError("replay where to? give --ros2, --foxglove or --rosbag DIR")
    playback = Playback(path, rate=options.rate, start_s=options.start_s, end_s=options.end_s, only=options.topics)
    try:
        if options.ros2:
            from pelagos.bridges.ros2 import Ros2Config, make_transport

            transport, why = make_transport(Ros2Config(type="ros2"))
            playback.add(transport)
            out.print(f"playing to ROS 2 by {transport.name} ({why})", markup=False)
        if options.foxglove:
            from pelagos.bridges.foxglove_transport import FoxgloveTransport

            server = FoxgloveTransport()
            playback.add(server, clock=False)
            out.print(f"playing to Foxglove at ws://127.0.0.1:{server.port}", markup=False)
        while True:
            out.print(f"{playback.play()} messages of {len(playback.topics)} topics played", markup=False)
            if not options.loop:
                break
    finally:
        for reason, count in sorted(playback.close().items()):
            out.print(f"{count} x {reason}", markup=False)
