"""`pelagos dataset`: options and help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Let the scenario run code (module:function) and read meshes from anywhere."),
]


def enter(app: typer.Typer) -> None:
    """Put the commands into the program."""
    app.command(
        epilog="Examples:\n\n    pelagos dataset examples/dataset_harbour.yaml harbour_set\n\n"
        "    pelagos dataset set.yaml out --workers 4 --set worlds=100\n\n"
        "    pelagos dataset set.yaml out --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
    )(dataset)


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
