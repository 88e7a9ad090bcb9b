"""`pelagos dataset` and `pelagos sweep`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pelagos.cli.options import Trust

Ray = Annotated[
    str | None,
    typer.Option(
        "--ray",
        metavar="ADDRESS",
        help="Work on a Ray cluster: HOST:PORT, auto, or local for one on this machine (extra `ray`).",
        show_default=False,
    ),
]
Workers = Annotated[int, typer.Option(metavar="N", help="Processes (with --ray: workers of the cluster).")]


def enter(app: typer.Typer) -> None:
    """Put the commands into the program."""
    app.command(
        epilog="Examples:\n\n    pelagos dataset examples/dataset_harbour.yaml harbour_set\n\n"
        "    pelagos dataset set.yaml out --workers 4 --set worlds=100\n\n"
        "    pelagos dataset set.yaml out --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
    )(dataset)
    app.command(
        epilog="Examples:\n\n    pelagos sweep survey.yaml --vary ocean.turbidity=0.1,1,3 --duration 20\n\n"
        "    pelagos sweep survey.yaml --vary agents.auv0.start.heading_deg=0:90:4 --vary seed=1,2,3 --workers 2"
    )(sweep)


def dataset(
    config: Annotated[Path, typer.Argument(metavar="CONFIG", help="A configuration (YAML).", show_default=False)],
    out: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="Where the data set goes.", show_default=False)
    ] = None,
    workers: Workers = 1,
    ray: Ray = None,
    shard: Annotated[
        str | None,
        typer.Option(
            metavar="I[/N]",
            help="Make shard I only, or every N-th from the I-th on: for arrays of jobs.",
            show_default=False,
        ),
    ] = None,
    verify: Annotated[bool, typer.Option("--verify", help="Make anew what differs from its SHA-256.")] = False,
    plan_only: Annotated[bool, typer.Option("--plan", help="Check it and say what would be made.")] = False,
    change: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Change a key of the configuration; may be given again.",
            show_default=False,
        ),
    ] = None,
    trust: Trust = False,
) -> None:  # fmt: skip
    """Make a labelled data set: random worlds, waters and poses, in the formats that learners read.

    Run it again after whatever ended it: it goes on, with the same bytes.
    """
    from pelagos.cli.dataset import DatasetOptions, make

    options = DatasetOptions(
        workers=workers, ray=ray, shard=shard, verify=verify, plan_only=plan_only, trust=trust
    )  # fmt: skip
    make(config, out, change or [], options)


def sweep(
    scenario: Annotated[
        Path, typer.Argument(metavar="SCENARIO", help="A scenario file (YAML or JSON).", show_default=False)
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY.PATH=VALUES",
            help="Values of a key: V,V,... or LOWEST:HIGHEST:COUNT or a list in YAML; may be given again.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of results; otherwise results/SCENARIO-sweep.", show_default=False),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Simulated seconds of each run.", show_default=False)
    ] = None,
    record: Annotated[bool, typer.Option("--record", help="Record each run (MCAP).")] = False,
    workers: Workers = 1,
    ray: Ray = None,
    change: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY.PATH=VALUE", help="Change one value of the scenario; may be given again.",
            show_default=False,
        ),
    ] = None,
    trust: Trust = False,
) -> None:  # fmt: skip
    """Run a scenario for every combination of values; a table says how each run ended.

    Run it again after whatever ended it: it does the runs that are missing. Exit code 1 where a run failed.
    """
    from pelagos.cli.sweep import sweep as go
    from pelagos.datasets.engine import checked

    engine = checked(workers, ray)
    code = go(scenario, vary or [], out, change or [], duration=duration, engine=engine, record=record, trust=trust)
    raise typer.Exit(code)
