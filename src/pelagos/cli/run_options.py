"""`pelagos run` and `pelagos check`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pelagos.cli.options import Changes, ScenarioFile, Trust

OptionalScenario = Annotated[
    Path | None,
    typer.Argument(metavar="SCENARIO", help="A scenario file (YAML or JSON).", show_default=False),
]
Duration = Annotated[
    float | None,
    typer.Option(metavar="S", help="Simulated seconds; otherwise until the missions end.", show_default=False),
]
Seed = Annotated[int | None, typer.Option(help="Seed of the noise; otherwise the scenario's.", show_default=False)]
Folder = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder of results; otherwise a new one in results/.", show_default=False),
]
Record = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Where to record; otherwise mission.mcap in the folder of results.", show_default=False
    ),
]
WallClock = Annotated[
    float | None,
    typer.Option(metavar="S", help="End the run in order after this wall-clock time.", show_default=False),
]
CheckpointEvery = Annotated[
    float | None,
    typer.Option(
        metavar="S", help="Keep a checkpoint every so many simulated seconds, to --resume from.", show_default=False
    ),
]
Resume = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Go on with the run in this folder of results, in one recording.", show_default=False
    ),
]
Bridges = Annotated[
    list[str] | None,
    typer.Option(
        metavar="TYPE",
        help="Open a door to other software (`list bridges`); may be given again.",
        show_default=False,
    ),
]
Rosbag = Annotated[bool, typer.Option("--rosbag", help="Also write the recording as a rosbag2 folder, for `ros2 bag`.")]
Repeat = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Obey the orders that a recorded run got from outside, at the same ticks.",
        show_default=False,
    ),
]
MemoryLimit = Annotated[
    str | None,
    typer.Option(
        metavar="SIZE",
        help="Refuse what needs more, such as 8G; otherwise 4/5 of what is free.",
        show_default=False,
    ),
]


def enter(app: typer.Typer) -> None:
    """Put both commands into the program."""
    app.command(
        epilog="Examples:\n\n"
        "    pelagos run examples/harbour_survey.yaml\n\n"
        "    pelagos run survey.yaml --duration 60 --seed 7 --out results/try\n\n"
        "    pelagos run survey.yaml --set agents.auv0.sensors.imaging.range_max_m=40\n\n"
        "    pelagos run survey.yaml --checkpoint-every 600 --out results/week --max-wall 86400\n\n"
        "    pelagos run --resume results/week"
    )(run)
    app.command(epilog="Example:\n\n    pelagos check survey.yaml --set tick_rate_hz=100")(check)


def run(
    scenario: OptionalScenario = None,
    duration: Duration = None,
    seed: Seed = None,
    copies: Annotated[int, typer.Option("--n", help="Independent copies of the scenario, with different noise.")] = 1,
    out: Folder = None,
    record: Record = None,
    realtime: Annotated[bool, typer.Option("--realtime", help="Run no faster than the clock on the wall.")] = False,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    max_wall: WallClock = None,
    checkpoint_every: CheckpointEvery = None,
    resume: Resume = None,
    ros2: Annotated[bool, typer.Option("--ros2", help="Speak ROS 2; the same as --bridge ros2.")] = False,
    bridge: Bridges = None,
    rosbag: Rosbag = False,
    repeat: Repeat = None,
    view: Annotated[bool, typer.Option("--view", help="Show the run in a page of the browser (see `view`).")] = False,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="With --view: open the page in a browser.")
    ] = True,
    memory_limit: MemoryLimit = None,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Run a scenario; record it and write a report.

    Ctrl-C, SIGTERM and SIGHUP end it in order, with recording, report and statistics until then.
    """
    from pelagos.cli.run import Options, run_scenario

    options = Options(
        duration_s=duration, seed=seed, copies=copies, out=out, record=record, realtime=realtime, report=report,
        max_wall_s=max_wall, checkpoint_every_s=checkpoint_every, resume=resume, trust=trust, memory_limit=memory_limit,
        bridges=(*(["ros2"] if ros2 else []), *(bridge or [])), repeat=repeat, rosbag=rosbag,
        view=view, browser=browser,
    )  # fmt: skip
    raise typer.Exit(run_scenario(scenario, change or [], options))


def check(
    scenario: ScenarioFile,
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the scenario with every default written out.")
    ] = False,
    build: Annotated[
        bool, typer.Option("--build/--no-build", help="Build world, sensors and starts once, as a run would.")
    ] = True,
    cost: Annotated[bool, typer.Option("--cost", help="Estimate memory and work by part; builds nothing.")] = False,
    copies: Annotated[int, typer.Option("--n", min=1, help="With --cost: copies of the scenario.")] = 1,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Check a scenario and say what it would simulate; refuses what `run` refuses, as far as there is a device."""
    from pelagos.cli.check import check_scenario
    from pelagos.cli.cost import show_cost

    if cost:
        show_cost(scenario, change or [], copies=copies, trust=trust)
        return
    check_scenario(scenario, change or [], resolved=resolved, trust=trust, build=build)
