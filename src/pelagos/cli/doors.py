"""Runs with doors open: what `pelagos run` does where the scenario or the command line names bridges."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pelagos.cli.console import err, out
from pelagos.config import registry
from pelagos.errors import InputError

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange
    from pelagos.cli.run import Options
    from pelagos.config.scenario import Scenario
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation

MOST_RESTARTS: Final = 10
"""Times that a run begins anew because what it was told from outside left no finite state."""


def doors_of(scenario: Scenario, asked: Sequence[str]) -> dict[str, Any]:
    """The bridges of a scenario, and those that the command line asks for by type, with their defaults.

    Those are named by their type, or TYPE_2 and so on where the scenario has another door of that name.

    Raises:
        LookupFailed: there is no such type.
    """
    found = dict(scenario.bridges)
    for kind in asked:
        if not any(config.type == kind for config in found.values()):
            names = (kind, *(f"{kind}_{i}" for i in range(2, len(found) + 2)))  # one of them is free
            name = next(n for n in names if n not in found)
            found[name] = registry.find("bridge", kind).config.model_validate({"type": kind})
    return found


def check_doors(sim: Simulation, doors: Mapping[str, Any]) -> None:
    """Refuse bridges that do not fit a scenario, without opening any.

    Raises:
        BridgeMismatch: names the bridge.
    """
    from pelagos.bridges.transport import BridgeMismatch

    taken: dict[str, str] = {}
    for name, config in doors.items():
        with _naming(name):
            config.check(sim)
            place = config.listens()
            if place in taken:
                raise BridgeMismatch(f"{place} is taken by bridges.{taken[place]}; give another port")
            if place:
                taken[place] = name


def door_place(config: Any) -> str:
    """Address of a door in words; of a port that it listens at, whether another program has it now."""
    place = config.listens()
    if place:
        return f"listens at {place}" + (" (taken at present)" if _is_taken(place) else "")
    host, port = getattr(config, "host", None), getattr(config, "port", None)
    if host and port:
        return f"goes to {host}:{port}"
    if port == 0:
        return "listens at a free port"
    if isinstance(port, str):
        return f"speaks at {port}"
    domain = getattr(config, "domain", None)
    return str(getattr(config, "url", "")) if domain is None else f"ROS domain {domain}"


def _is_taken(place: str) -> bool:
    """True where a port ("tcp 127.0.0.1:9090") cannot be had at present; of serial ports that is not known."""
    kind, _, address = place.partition(" ")
    types = {"tcp": socket.SOCK_STREAM, "udp": socket.SOCK_DGRAM}
    if kind not in types:
        return False
    host, _, port = address.rpartition(":")
    try:
        with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, types[kind]) as probe:
            if kind == "tcp":
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as servers do: a closed one waits on
            probe.bind((host, int(port)))
    except OSError:
        return True
    return False


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
    except (BridgeError, InputError):
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

    So does a state that is not finite, where somebody outside commands: a peer ends no run. With `repeat` doors stay
    closed, so that nobody tells the run anything else.

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
    if options.repeat is not None and options.bridges:
        raise InputError("--repeat tells a run what another was told, and nobody else may: leave out bridges")
    realtime, repeat = float(options.realtime), options.repeat
    exchange = Exchange(sim, realtime=realtime, say=lambda text: err.print(f"refused: {text}", markup=False))
    try:
        if repeat is None:
            for name, config in doors.items():
                out.print(f"{name}: {_opened(name, config, exchange)}", markup=False)
        else:
            closed = f"; bridges stay closed: {', '.join(doors)}" if doors else ""
            out.print(f"repeats the orders of {repeat}{closed}", markup=False)
            Repeat(sim, repeat, note=exchange.note)
        result = _runs(exchange, options, recording, progress)
    finally:
        troubles = exchange.close()
        for reason, count in sorted(troubles.items()):
            out.print(f"{count} x {reason}", markup=False)
    if realtime:
        p50, p99, worst = exchange.pace.jitter_ms()
        late = f", {exchange.pace.lost_s:.2f} s lost" if exchange.pace.lost_s else ""
        out.print(f"steps late by {p50:.2f} ms (median), {p99:.2f} (99 %), {worst:.2f} (worst){late}")
    return result


def _runs(exchange: Exchange, options: Options, recording: Path, progress: Callable[[float, float], None]) -> RunResult:
    """One run, and another with another recording for as long as something makes it begin anew."""
    from pelagos.sim.not_finite import NotFinite

    number, lost, file = 1, 0, recording
    while True:
        told = exchange.inbox.obeyed.total()
        try:
            result = exchange.run(options.duration_s, record=file, progress=progress)
        except NotFinite as error:
            lost += 1
            if exchange.inbox.obeyed.total() == told or lost > MOST_RESTARTS:
                raise
            why = f"{error}. It was commanded from outside: the run begins anew"
        else:
            if not exchange.reset_asked:
                return result
            why = f"reset from outside at {result.simulated_s:.2f} s"
        number += 1
        file = recording.with_name(f"{recording.stem}-{number}{recording.suffix}")
        exchange.sim.reset()
        out.print(f"{why}; goes on in {file.name}", markup=False)
