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
    wait_s: float = 2.0
    port: int | None = None


def replay(path: Path, options: ReplayOptions) -> None:
    """Play it.

    Raises:
        InputError: there is nowhere to play it to, or options do not go together.
    """
    from pelagos.bridges.part import Part
    from pelagos.bridges.playback import Playback
    from pelagos.bridges.rosbag import write_rosbag

    if options.rosbag is not None:
        playing = {"--ros2": options.ros2, "--foxglove": options.foxglove, "--loop": options.loop,
                   "--rate": options.rate != 1.0}  # fmt: skip
        if any(playing.values()):
            asked = ", ".join(name for name, given in playing.items() if given)
            raise InputError(f"--rosbag writes a folder, and plays nothing: leave out {asked}")
        count = write_rosbag(path, options.rosbag, start_s=options.start_s, end_s=options.end_s, only=options.topics)
        out.print(f"{count} messages written to {options.rosbag}", markup=False)
        return
    if not (options.ros2 or options.foxglove):
        raise InputError("replay where to? give --ros2, --foxglove or --rosbag DIR")
    if options.port is not None and not options.foxglove:
        raise InputError("--port is that of --foxglove; give both")
    if not 0 <= options.wait_s < float("inf"):
        raise InputError(f"--wait is a number of seconds, 0 or more, not {options.wait_s:g}")
    part = Part(path, start_s=options.start_s, end_s=options.end_s, only=options.topics)
    playback = Playback(part, rate=options.rate)
    try:
        if options.ros2:
            from pelagos.bridges.ros2 import Ros2Config, make_transport

            transport, why = make_transport(Ros2Config(type="ros2"))
            playback.add(transport)
            out.print(f"playing to ROS 2 by {transport.name} ({why}), {transport.reach}", markup=False)
        if options.foxglove:
            from pelagos.bridges.foxglove_transport import FoxgloveTransport

            server = FoxgloveTransport() if options.port is None else FoxgloveTransport(port=options.port)
            playback.add(server)
            out.print(f"playing to Foxglove at ws://127.0.0.1:{server.port}", markup=False)
        readers = playback.wait(options.wait_s)
        if options.wait_s and not readers:
            out.print(
                "nobody listens yet; who comes later gets what is latched, and the rest from then on", markup=False
            )
        while True:
            out.print(f"{playback.play()} messages of {len(playback.topics)} topics played", markup=False)
            if not options.loop:
                break
    finally:
        for reason, count in sorted(playback.close().items()):
            out.print(f"{count} x {reason}", markup=False)
