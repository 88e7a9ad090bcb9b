"""`pelagos world`, `pelagos view` and `pelagos video`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pelagos.cli.options import Changes, ScenarioFile, Trust


def enter(app: typer.Typer) -> None:
    """Put the commands into the program."""
    app.command(
        epilog="Examples:\n\n    pelagos world examples/harbour_survey.yaml --out preview.png\n\n"
        "    pelagos world survey.yaml --out world.glb --out report.html\n\n"
        "    pelagos world survey.yaml --out exported_world --set world.seed=3"
    )(world)
    app.command(
        epilog="Examples:\n\n    pelagos view examples/harbour_survey.yaml\n\n"
        "    pelagos view results/harbour_survey-1/mission.mcap\n\n"
        "    pelagos view --world examples/harbour_survey.yaml"
    )(view)
    app.command(
        epilog="Examples:\n\n    pelagos video mission.mcap out.mp4\n\n"
        "    pelagos video mission.mcap chase.mp4 --chase --speed 4\n\n"
        "    pelagos video mission.mcap sonar.mp4 --sonar imaging"
    )(video)


def world(
    scenario: ScenarioFile,
    out: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="What to write, by its suffix: .png (map, views, numbers), .html (the same as a page), .glb (mesh), "
            ".npz (everything, for the world type 'saved'), .json (statistics); without a suffix a folder of mesh, "
            "labels and height map. May be given again.",
            show_default=False,
        ),
    ] = None,
    samples: Annotated[int, typer.Option(min=1, max=1024, help="Rays for each pixel of the views.")] = 24,
    at: Annotated[float, typer.Option(metavar="S", help="Simulated time at which movers are shown.")] = 0.0,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Build the world of a scenario: statistics, pictures, files for other programs."""
    from pelagos.cli.world import show_world

    show_world(scenario, change or [], out or [], samples=samples, at_s=at, trust=trust)


def view(
    file: Annotated[
        Path, typer.Argument(metavar="SCENARIO|RECORDING", help="A scenario, or a recording.", show_default=False)
    ],
    world: Annotated[bool, typer.Option("--world", help="The world of the scenario alone, with its labels.")] = False,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Listen at another address than this machine's own.")
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(metavar="N", help="8080, or a free one where that is taken; 0: a free one.", show_default=False),
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the noise; otherwise the scenario's.", show_default=False)
    ] = None,
    speed: Annotated[float, typer.Option(help="Times the clock; 0 as fast as it goes.")] = 1.0,
    paused: Annotated[bool, typer.Option("--paused", help="Wait for `Run` on the page.")] = False,
    seconds: Annotated[
        float | None, typer.Option("--for", metavar="S", help="End after this wall-clock time.", show_default=False)
    ] = None,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """See a scenario run, a recording play, or a world, in a page of the browser; Ctrl-C ends it.

    The page is served from this machine alone, and needs nothing from the network.
    """
    from pelagos.cli.view import ViewOptions, show

    options = ViewOptions(
        world=world, host=host, port=port, browser=browser, seed=seed, speed=speed, paused=paused, for_s=seconds,
        trust=trust,
    )  # fmt: skip
    raise typer.Exit(show(file, change or [], options))


def video(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="A recording.", show_default=False)],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The film: .mp4, .mkv or .mov.", show_default=False)],
    chase: Annotated[bool, typer.Option("--chase", help="From behind the vehicle.")] = False,
    camera: Annotated[
        str | None, typer.Option(metavar="NAME", help="One camera alone, such as auv0.camera.", show_default=False)
    ] = None,
    sonar: Annotated[
        str | None, typer.Option(metavar="NAME", help="One sonar alone, such as imaging.", show_default=False)
    ] = None,
    panels: Annotated[bool, typer.Option("--panels", help="Map, depth and sensors side by side; the default.")] = False,
    speed: Annotated[float, typer.Option(help="Times the clock.")] = 1.0,
    rate: Annotated[int, typer.Option(metavar="HZ", help="Pictures in a second of the film.")] = 20,
) -> None:
    """Make a film of a recording."""
    from pelagos.cli.video import VideoOptions
    from pelagos.cli.video import video as make

    make(recording, out, VideoOptions(chase, camera, sonar, panels, speed, rate))
