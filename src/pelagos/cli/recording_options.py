"""`pelagos recover` and `pelagos replay`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def enter(app: typer.Typer) -> None:
    """Put both commands into the program."""
    app.command(
        epilog="Examples:\n\n    pelagos recover results/harbour_survey-1/mission.mcap\n\n"
        "    pelagos recover mission.mcap --out whole.mcap\n\n    pelagos recover mission.mcap --in-place"
    )(recover)
    app.command(
        epilog="Examples:\n\n    pelagos replay mission.mcap --ros2 --rate 2\n\n"
        "    pelagos replay mission.mcap --ros2 --wait 60 --loop\n\n    pelagos replay mission.mcap --rosbag bag"
    )(replay)


def recover(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A recording that was cut off or damaged.", show_default=False)
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="The new file; otherwise NAME.recovered.mcap beside the old one.", show_default=False
        ),
    ] = None,
    in_place: Annotated[
        bool, typer.Option("--in-place", help="Give the new file the old one's name; the old one becomes NAME.backup.")
    ] = False,
) -> None:
    """Write what can be read of a recording into a new one with an index; the old one stays as it is.

    Exit code 1 where a part of it is damaged: what is lost is listed.
    """
    from pelagos.cli.recover import recover_file

    raise typer.Exit(recover_file(file, out, in_place=in_place))


def replay(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording, or a rosbag2 folder.", show_default=False)],
    ros2: Annotated[bool, typer.Option("--ros2", help="Play it to ROS 2.")] = False,
    foxglove: Annotated[bool, typer.Option("--foxglove", help="Play it to Foxglove.")] = False,
    rosbag: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write it as a rosbag2 folder, for `ros2 bag`.", show_default=False),
    ] = None,
    rate: Annotated[float, typer.Option(help="Times as fast as the clock; 0 as fast as it goes.")] = 1.0,
    start: Annotated[float, typer.Option("--from", metavar="S", help="Begin at this simulation time.")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", metavar="S", help="End at this simulation time.", show_default=False)
    ] = None,
    topic: Annotated[
        list[str] | None,
        typer.Option(metavar="TOPIC", help="Only topics that begin so; may be given again.", show_default=False),
    ] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Begin again at the end.")] = False,
    port: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, max=65535, help="Port of --foxglove; otherwise 8765.", show_default=False),
    ] = None,
    wait: Annotated[
        float,
        typer.Option(metavar="S", help="Begin when somebody listens, or after this wall-clock time; 0: at once."),
    ] = 2.0,
) -> None:
    """Play a recording out again, or write it as a rosbag2 folder."""
    from pelagos.cli.replay import ReplayOptions
    from pelagos.cli.replay import replay as play

    options = ReplayOptions(
        ros2=ros2, foxglove=foxglove, rosbag=rosbag, rate=rate, start_s=start,
        end_s=float("inf") if end is None else end, topics=tuple(topic or ()), loop=loop,
        wait_s=wait, port=port,
    )  # fmt: skip
    play(file, options)
