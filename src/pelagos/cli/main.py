"""The command `pelagos`: options and help. The work of a command is in the module of its name, imported when called."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pelagos.cli import dataset_options, fit_noise, learn_options, recording_options, run_options, view_options
from pelagos.cli.options import Changes, ScenarioFile, Trust
from pelagos.cli.signals import SIGNAL_CODE, leave_at_once

app = typer.Typer(
    name="pelagos",
    help="Simulate underwater and surface vehicles with their sonars, cameras and navigation sensors.",
    epilog="Begin with: [bold]pelagos run examples/harbour_survey.yaml[/bold]",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class What(StrEnum):
    """Things that there are lists of."""

    vehicles = "vehicles"
    sensors = "sensors"
    worlds = "worlds"
    bridges = "bridges"
    devices = "devices"
    tasks = "tasks"


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"pelagos {version('pelagos')}")
        raise typer.Exit


@app.callback()
def _top(
    debug: Annotated[bool, typer.Option("--debug", help="Show where in the program an error arose.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


run_options.enter(app)
view_options.enter(app)


@app.command(
    epilog="Examples:\n\n    pelagos channel examples/harbour_survey.yaml auv0 60,20,-5 --out channel.png\n\n"
    "    pelagos channel swarm.yaml auv0.modem usv0.modem --frequency 10000 --at 120"
)
def channel(
    scenario: ScenarioFile,
    a: Annotated[str, typer.Argument(metavar="A", help="Transmitter: an agent, AGENT.SENSOR, or a place x,y,z [m].")],
    b: Annotated[str, typer.Argument(metavar="B", help="Receiver: likewise.")],
    frequency: Annotated[float, typer.Option(metavar="HZ", help="Frequency of the sound.")] = 25_000.0,
    at: Annotated[float, typer.Option(metavar="S", help="Simulated time at which it is asked.")] = 0.0,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A picture, .png: rays, arrivals, loss.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the arrivals as JSON.")] = False,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Trace sound between two places of a scenario: rays, arrivals, transmission loss."""
    from pelagos.cli.channel import show_channel

    show_channel(scenario, change or [], (a, b), frequency_hz=frequency, at_s=at, out=out, as_json=as_json, trust=trust)


@app.command("list", epilog="Examples:\n\n    pelagos list sensors\n\n    pelagos list sensors camera")
def list_(
    what: Annotated[What, typer.Argument(help="Of what.", show_default=False)],
    name: Annotated[str, typer.Argument(help="One sensor or world, to list its keys.", show_default=False)] = "",
) -> None:
    """List the vehicles, sensors, worlds and devices (sonars by data sheet) of scenarios, or tasks to learn."""
    from pelagos.cli.listing import print_keys, print_list

    if name:
        print_keys(what.value, name)
    else:
        print_list(what.value)


@app.command(
    epilog="Examples:\n\n    pelagos explain survey.yaml auv0.multibeam\n\n"
    "    pelagos explain survey.yaml auv0.multibeam --at 120"
)
def explain(
    scenario: ScenarioFile,
    sensor: Annotated[str, typer.Argument(metavar="AGENT.SENSOR", help="Such as auv0.multibeam.", show_default=False)],
    at: Annotated[float, typer.Option(metavar="S", help="Simulated time at which to read the sensor.")] = 0.0,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Follow one sensor from its line in the scenario to its numbers, in five stops."""
    from pelagos.cli.explain import explain_sensor

    explain_sensor(scenario, change or [], sensor, at_s=at, trust=trust)


@app.command(
    epilog="Examples:\n\n    pelagos schema > scenario.schema.json\n\n    pelagos schema --check\n\n"
    "An editor that reads JSON Schema then completes and checks scenario files."
)
def schema(
    write: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write to a file instead of printing.", show_default=False)
    ] = None,
    compare: Annotated[
        Path | None,
        typer.Option(
            "--check", metavar="FILE", help="Compare with a file; exit code 1 if it differs.", show_default=False
        ),
    ] = None,
) -> None:
    """Print the JSON schema of scenario files."""
    from pelagos.cli.schema import compare_schema, schema_text

    if compare is not None:
        raise typer.Exit(compare_schema(compare))
    if write is None:
        typer.echo(schema_text(), nl=False)
    else:
        write.write_text(schema_text(), encoding="utf-8")


@app.command(epilog="Examples:\n\n    pelagos bench\n\n    pelagos bench cast_256_ms nav_rtf --json")
def bench(
    cases: Annotated[
        list[str] | None, typer.Argument(metavar="[CASE]...", help="Which; otherwise all.", show_default=False)
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    write: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the table as Markdown.", show_default=False)
    ] = None,
) -> None:
    """Measure speed, beside a published figure or a limit of this machine."""
    from pelagos.cli.bench import run_bench

    raise typer.Exit(run_bench(cases or [], as_json=json, write=write))


recording_options.enter(app)
fit_noise.enter(app)


@app.command(
    epilog="Examples:\n\n    pelagos fit examples/fit_usv.yaml run.csv --plan examples/fit_usv_plan.yaml\n\n"
    "    pelagos fit usv.yaml mission.mcap --plan plan.yaml --out results/usv"
)
def fit(
    scenario: ScenarioFile,
    data: Annotated[Path, typer.Argument(metavar="DATA", help="A record: .csv, .csv.gz or .mcap.", show_default=False)],
    plan: Annotated[
        Path, typer.Option(metavar="FILE", help="Columns and parameters (YAML), see docs/fit.md.", show_default=False)
    ],
    agent: Annotated[str, typer.Option(help="Whose vehicle, where there are several.", show_default=False)] = "",
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of results; otherwise results/fit-DATA.", show_default=False),
    ] = None,
    change: Changes = None,
    trust: Trust = False,
) -> None:
    """Identify a vehicle's parameters from a record of its motion, and say how sure they are."""
    from pelagos.cli.fit import fit_vehicle

    fit_vehicle(scenario, data, change or [], plan=plan, agent=agent, folder=out, trust=trust)


class Manoeuvre(StrEnum):
    """Standard manoeuvres."""

    turning = "turning"
    zigzag = "zigzag"
    stop = "stop"
    spiral = "spiral"
    decay = "decay"
    bollard = "bollard"


@app.command(
    epilog="Examples:\n\n    pelagos manoeuvre mariner turning --out turning.png\n\n"
    "    pelagos manoeuvre mariner zigzag --rudder 20 --angle 20\n\n"
    "    pelagos manoeuvre kvlcc2 zigzag --variant drift_tests\n\n"
    "    pelagos manoeuvre kvlcc2 turning --variant shallow --depth 31.2"
)
def manoeuvre(
    vehicle: Annotated[
        str, typer.Argument(metavar="VEHICLE", help="Of the catalogue, or a file of a vehicle.", show_default=False)
    ],
    which: Annotated[Manoeuvre, typer.Argument(metavar="MANOEUVRE", help="Which.", show_default=False)],
    rudder: Annotated[float | None, typer.Option(metavar="DEG", help="Helm.", show_default=False)] = None,
    angle: Annotated[
        float | None, typer.Option(metavar="DEG", help="Of zig-zag or first heel.", show_default=False)
    ] = None,
    speed: Annotated[float | None, typer.Option(metavar="M/S", help="Before.", show_default=False)] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Longest run.", show_default=False)] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="A picture, .png.", show_default=False)] = None,
    depth: Annotated[
        float | None, typer.Option(metavar="M", help="Of the water, for ships that feel it.", show_default=False)
    ] = None,
    variant: Annotated[
        str | None, typer.Option(metavar="NAME", help="Another parameter set of the vehicle.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers as JSON.")] = False,
    trust: Trust = False,
) -> None:
    """Run a standard manoeuvre in calm water: its numbers beside the limits of IMO MSC.137(76), and a picture."""
    from pelagos.cli.manoeuvre import show_manoeuvre
    from pelagos.manoeuvres.orders import Orders

    orders = Orders(rudder, angle, speed, seconds, depth)
    show_manoeuvre(vehicle, which.value, orders, out=out, as_json=as_json, variant=variant, trust=trust)


@app.command(epilog="Example:\n\n    pelagos cite examples/harbour_survey.yaml")
def cite(
    scenario: Annotated[
        Path | None, typer.Argument(metavar="[SCENARIO]", help="Only what this scenario uses.", show_default=False)
    ] = None,
    trust: Trust = False,
) -> None:
    """Print the sources of the models, to cite them."""
    from pelagos.cli.cite import print_sources

    print_sources(scenario, trust=trust)


learn_options.enter(app)
dataset_options.enter(app)


@app.command(
    epilog="Examples:\n\n"
    "    pelagos holoocean survey.py --my-own-option\n\n"
    "    pelagos holoocean --legacy-dynamics -m pytest tests/\n\n"
    "    pelagos holoocean --convert Dam-Hovering.json dam.yaml"
)
def holoocean(
    program: Annotated[
        list[str] | None,
        typer.Argument(metavar="SCRIPT.py [ARGS]...", help="A script, and what it is given.", show_default=False),
    ] = None,
    module: Annotated[
        str | None,
        typer.Option("-m", metavar="MODULE", help="Run a module instead, such as pytest.", show_default=False),
    ] = None,
    legacy_dynamics: Annotated[
        bool, typer.Option("--legacy-dynamics", help="Move HoloOcean's agents by HoloOcean's own force model.")
    ] = False,
    seed: Annotated[int | None, typer.Option(help="Seed of every environment.", show_default=False)] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse keys that HoloOcean would ignore.")] = False,
    convert: Annotated[
        Path | None,
        typer.Option(
            metavar="SCENARIO.json", help="Write a HoloOcean scenario as a native one to OUT.yaml.", show_default=False
        ),
    ] = None,
) -> None:
    """Run a program in which `import holoocean` is Pelagos."""
    from pelagos.cli import holoocean as command

    if convert is not None:
        command.convert(convert, program or [])
        return
    command.run_program(program or [], module=module, legacy_dynamics=legacy_dynamics, seed=seed, strict=strict)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and leave the program: 0 done, 2 wrong input, 1 anything else, 130 stopped by Ctrl-C.

    Without `arguments` the process is the command's own, and a signal ends it without the interpreter's own tidying up:
    an import or a compilation that was cut short can make that crash.
    """
    command = next((word for word in sys.argv[1:] if not word.startswith("-")), "")
    if arguments is None and command in ("run", "view"):
        leave_at_once()
    try:
        _main(arguments)
    except SystemExit as end:
        if arguments is None and isinstance(end.code, int) and end.code > SIGNAL_CODE:
            with contextlib.suppress(OSError, ValueError):  # whoever reads may be gone
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(end.code)
        raise


def _main(arguments: Sequence[str] | None) -> None:
    given = list(sys.argv[1:] if arguments is None else arguments)
    from pelagos.cli.console import show_warning
    from pelagos.errors import InputError, PelagosError

    try:
        with warnings.catch_warnings():
            if "--debug" not in given:
                warnings.showwarning = show_warning
            app(_program_apart(given), prog_name="pelagos")
    except KeyboardInterrupt:
        sys.exit(SIGNAL_CODE + signal.SIGINT)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)
    except PelagosError as error:
        if "--debug" in given:
            raise
        from pelagos.cli.console import show_error

        show_error("wrong input" if isinstance(error, InputError) else "error", str(error))
        sys.exit(2 if isinstance(error, InputError) else 1)
    except Exception as error:
        from pelagos.cli.signals import interrupted

        if "--debug" in given:
            raise
        if interrupted(error):
            sys.exit(SIGNAL_CODE + signal.SIGINT)
        if not isinstance(error, OSError):
            raise
        from pelagos.cli.console import show_error

        show_error("error", f"{error.filename or ''}: {error.strerror or error}".removeprefix(": "))
        sys.exit(1)


def _program_apart(given: list[str]) -> list[str]:
    """Arguments with `--` before what belongs to a program that `pelagos holoocean` runs."""
    if not given or given[0] != "holoocean" or "--" in given:
        return given
    at = 1
    while at < len(given) and given[at].startswith("-"):
        at += 2 if given[at] in ("-m", "--seed", "--convert") else 1
        if given[at - 2] == "-m":
            break
    return [*given[:at], "--", *given[at:]]
