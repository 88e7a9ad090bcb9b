"""`pelagos train` and `pelagos evaluate`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

TaskName = Annotated[
    str, typer.Argument(metavar="TASK", help="A task, such as Hover-v0 (`pelagos list tasks`).", show_default=False)
]
Options = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="OPTION=VALUE",
        help="Change one of the task's options; may be given again.",
        show_default=False,
    ),
]


def enter(app: typer.Typer) -> None:
    """Put both commands into the program."""
    app.command(
        epilog="Examples:\n\n    pelagos train Hover-v0\n\n"
        "    pelagos train Waypoint-v0 --steps 6000000 --seed 1 --out runs/waypoint\n\n"
        "    pelagos train Hover-v0 --until distance_m=0.3 --set current_mps=0.4"
    )(train)
    app.command(
        epilog="Examples:\n\n    pelagos evaluate Hover-v0 --policy script\n\n"
        "    pelagos evaluate Hover-v0 --policy runs/Hover-v0/policy.npz --film hover.png\n\n"
        "    pelagos evaluate Docking-v0 --episodes 128 --minari pelagos/docking/script-v0"
    )(evaluate)


def train(
    task: TaskName,
    steps: Annotated[float, typer.Option(metavar="N", help="Decisions of all copies together, at most.")] = 2e6,
    seed: Annotated[int, typer.Option(help="Of episodes, first weights and exploration.")] = 0,
    copies: Annotated[int, typer.Option("--n", help="Copies that learn side by side.")] = 512,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of results; otherwise runs/TASK.", show_default=False),
    ] = None,
    until: Annotated[
        str | None,
        typer.Option(
            metavar="METRIC=VALUE",
            help="Stop where a metric at the ends of episodes is at most this.",
            show_default=False,
        ),
    ] = None,
    max_s: Annotated[float | None, typer.Option(metavar="S", help="Stop after so long.", show_default=False)] = None,
    discount: Annotated[
        float,
        typer.Option(help="What a reward counts a decision later; nearer to 1 for tasks of many decisions a second."),
    ] = 0.98,
    options: Options = None,
) -> None:
    """Learn a policy by PPO: policy.npz, curve.csv and curve.png in a folder (extra `learn`)."""
    from pelagos.cli.learn import Lesson, learn

    lesson = Lesson(steps=int(steps), seed=seed, copies=copies, out=out, until=until, max_s=max_s, discount=discount)
    learn(task, lesson, options or [])


def evaluate(
    task: TaskName,
    policy: Annotated[str, typer.Option(metavar="POLICY", help="random, zero, script, or a policy.npz.")] = "script",
    episodes: Annotated[int, typer.Option(help="At least so many, the same number of every copy.")] = 256,
    seed: Annotated[int, typer.Option(help="Of the episodes.")] = 0,
    film: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the first copy's way (PNG).", show_default=False)
    ] = None,
    minari: Annotated[
        str | None,
        typer.Option(
            metavar="ID",
            help="Keep the episodes as a Minari data set, such as pelagos/hover/script-v0 (extra `minari`).",
            show_default=False,
        ),
    ] = None,
    lerobot: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Keep the episodes as a LeRobot data set in a new folder (extra `datasets`).",
            show_default=False,
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    options: Options = None,
) -> None:
    """Score a policy: the mean return and the task's metrics at the ends of episodes."""
    from pelagos.cli.learn import keep, score

    if minari is not None or lerobot is not None:
        keep(task, policy, minari=minari, lerobot=lerobot, episodes=episodes, seed=seed, options=options or [])
    score(task, policy, episodes=episodes, seed=seed, film=film, as_json=json, options=options or [])
