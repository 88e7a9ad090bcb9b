"""Runs with doors open: what `pelagos run` does where the scenario or the command line names bridges."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pelagos.cli.console import err, out
from pelagos.config import registry
from pelagos.errors import InputError

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange
    from pelagos.cli.run import Options
    from pelagos.config.scenario import Scenario
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation


def doors_of(scenario: Scenario, asked: Sequence[str]) -> dict[str, Any]:
    """The bridges of a scenario, and those that the command line asks for by type, with their defaults.

    Raises:
        LookupFailed: there is no such type.
    """
    found = dict(scenario.bridges)
    for kind in asked:
        if not any(config.type == kind for config in found.values()):
            found[kind] = registry.find("bridge", kind).config.model_validate({"type": kind})
    return found


def check_doors(sim: Simulation, doors: Mapping[str, Any]) -> None:
    """Refuse bridges that do not fit a scenario, without opening any.

    Raises:
        BridgeMismatch: names the bridge.
    """
    for name, config in doors.items():
        with _naming(name):
            config.check(sim)


@contextmanager
def _naming(name: str) -> Iterator[None]:
    """Errors name the bridge."""
    from pelagos.bridges.transport import BridgeError

    try:
        yield
    except BridgeError as error:
        raise type(error)(f"bridges.{name}: {error}") from error


def _opened(name: str, config: Any, exchange: Exchange) -> str:
    """Open a door, and say what it is; an error names it."""
    with _naming(name):
        return str(config.attach(exchange))


@contextmanager
def nothing_left(folder: Path, recording: Path) -> Iterator[None]:
    """Take a fresh folder of results away where no door opened, so that the same command may be given again."""
    from pelagos.bridges.transport import BridgeError

    try:
        yield
    except BridgeError:
        if not recording.exists():
            (folder / "scenario.yaml").unlink(missing_ok=True)
            with suppress(OSError):
                folder.rmdir()
        raise


def run_with_doors(
    sim: Simulation,
    doors: Mapping[str, Any],
    options: Options,
    recording: Path,
    progress: Callable[[float, float], None],
) -> RunResult:
    """Run with every door open; a reset from outside begins another run with another recording.

    Raises:
        InputError: options that do not go together.
    """
    from pelagos.bridges.exchange import Exchange
    from pelagos.bridges.journal import Repeat

    if sim.n != 1:
        raise InputError(f"bridges and --repeat are for one copy of a scenario, not for {sim.n}; leave out --n")
    if options.checkpoint_every_s is not None:
        raise InputError(
            "--checkpoint-every cannot keep what other programs know; leave it out with bridges or --repeat"
        )
    seconds, realtime, repeat = options.duration_s, float(options.realtime), options.repeat
    exchange = Exchange(sim, realtime=realtime, say=lambda text: err.print(f"refused: {text}", markup=False))
    try:
        for name, config in doors.items():
            out.print(f"{name}: {_opened(name, config, exchange)}", markup=False)
        if repeat is not None:
            Repeat(sim, repeat)
        result = exchange.run(seconds, record=recording, progress=progress)
        number = 1
        while exchange.reset_asked:
            number += 1
            sim.reset()
            file = recording.with_name(f"{recording.stem}-{number}{recording.suffix}")
            out.print(f"reset from outside at {result.simulated_s:.2f} s; goes on in {file.name}", markup=False)
            result = exchange.run(seconds, record=file, progress=progress)
    finally:
        troubles = exchange.close()
        for reason, count in sorted(troubles.items()):
            out.print(f"{count} x {reason}", markup=False)
    if realtime:
        p50, p99, worst = exchange.pace.jitter_ms()
        late = f", {exchange.pace.lost_s:.2f} s lost" if exchange.pace.lost_s else ""
        out.print(f"steps late by {p50:.2f} ms (median), {p99:.2f} (99 %), {worst:.2f} (worst){late}")
    return result
