"""`pelagos fit-noise`: noise of a sensor from its record."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from rich.table import Table

from pelagos.cli.console import out as console
from pelagos.errors import InputError, LookupFailed


class TimeUnit(StrEnum):
    """Units of a column of times."""

    s = "s"
    ms = "ms"
    us = "us"
    ns = "ns"


_TERMS: Final = ("white", "bias_instability", "random_walk")


def enter(app: typer.Typer) -> None:
    """Add the command."""
    app.command(
        name="fit-noise",
        epilog="Examples:\n\n    pelagos fit-noise imu.csv --columns gyro_x,gyro_y,gyro_z --prefix gyroscope_\n\n"
        "    pelagos fit-noise dvl.csv --beams b1,b2,b3,b4",
    )(fit_noise)


def fit_noise(
    data: Annotated[Path, typer.Argument(metavar="DATA", help="A record: .csv or .csv.gz.", show_default=False)],
    columns: Annotated[str, typer.Option(metavar="A,B", help="Of a sensor at rest.", show_default=False)] = "",
    beams: Annotated[
        str, typer.Option(metavar="A,B,C,D", help="Of a velocity log, in order around.", show_default=False)
    ] = "",
    time: Annotated[
        str, typer.Option(metavar="NAME", help="Column of the time, with --columns.", show_default="t")
    ] = "",
    time_unit: Annotated[TimeUnit, typer.Option(help="Of that column.")] = TimeUnit.s,
    prefix: Annotated[
        str, typer.Option(metavar="TEXT", help="Of the keys, such as gyroscope_.", show_default=False)
    ] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Identify a sensor's noise: Allan deviation at rest, or beams of a velocity log on its way; as keys."""
    from pelagos.identification.noise import even_rate, keys_of
    from pelagos.identification.noise import fit_noise as fitted
    from pelagos.identification.plan import UNIT_SCALES
    from pelagos.identification.table import read_table

    if bool(columns) == bool(beams):
        raise InputError("give --columns of a sensor at rest, or --beams of a velocity log")
    if beams:
        if time or prefix or time_unit != TimeUnit.s:
            raise InputError("--time, --time-unit and --prefix belong to --columns: beams need no time")
        _show_beams(read_table(data, _names(beams)), _names(beams), data, as_json)
        return
    if prefix and not prefix.isidentifier():
        raise InputError(f"--prefix {prefix!r}: keys have letters, digits and _ alone, such as gyroscope_")
    names, time = _names(columns), time or "t"
    if time in names:
        raise InputError(f"{columns}: {time} is the time; name columns of the sensor")
    series = _chosen(read_table(data, [time, *names]), [time, *names], data)
    with _named(str(data)):
        rate = even_rate(series[0] * UNIT_SCALES[time_unit.value])
    found = {}
    for name, x in zip(names, series[1:], strict=True):
        with _named(f"{data}: column {name!r}"):
            found[name] = fitted(x, rate, label=f"{data}: column {name!r}: ")
    keys = keys_of(found, prefix)
    if as_json:
        axes = {n: {k: getattr(v, k).value for k in _TERMS} for n, v in found.items()}
        console.print_json(json.dumps({"rate_hz": rate, "axes": axes, "keys": keys}))
        return
    console.print(f"{len(series[0])} samples, {rate:.6g} a second: {len(series[0]) / rate:.4g} s", markup=False)
    shown = Table(box=None)
    for head in ("axis", "white [x/sqrt(Hz)]", "bias instability [x]", "random walk [x/sqrt(s)]", "mean [x]"):
        shown.add_column(head, justify="left" if head == "axis" else "right")
    for name, n in found.items():
        told = []
        for k, term in enumerate(getattr(n, t) for t in _TERMS):
            told.append(f"{term.value:.4g}" if term.visible else f"not seen, < {_bound(n, k):.2g}")
        shown.add_row(name, *told, f"{n.mean:.4g}")
    console.print(shown)
    _print_keys(keys)


def _bound(noise: Any, term: int) -> float:
    """The largest that a term could be without standing above the measured curve."""
    import numpy as np

    from pelagos.sensors.noise import FLOOR

    shape = (1 / noise.tau, np.full(len(noise.tau), FLOOR**2), noise.tau / 3)[term]
    return float((noise.allan / np.sqrt(shape)).min())


def _show_beams(table: Any, names: list[str], data: Path, as_json: bool) -> None:
    from pelagos.identification.noise import fit_beams

    with _named(str(data)):
        found = fit_beams(_chosen(table, names, data))
    keys = {"noise_mps": found.noise_mps, "noise_relative": found.noise_relative}
    if as_json:
        console.print_json(json.dumps({"keys": keys, "lost": found.lost, "pings": found.pings}))
        return
    lost = ", ".join(f"{n} {100 * x:.2g} %" for n, x in zip(names, found.lost, strict=True))
    console.print(f"{found.pings} pings with four beams; lost: {lost}", markup=False)
    _print_keys(keys)


def _print_keys(keys: dict[str, float]) -> None:
    console.print("\n".join(f"{k}: {v:.4g}" for k, v in keys.items()), markup=False)


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Put the place before complaints about numbers."""
    try:
        yield
    except LookupFailed:
        raise
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _names(text: str) -> list[str]:
    found = [name.strip() for name in text.split(",") if name.strip()]
    if text and not found:
        raise InputError(f"{text!r} names no column")
    twice = sorted({name for name in found if found.count(name) > 1})
    if twice:
        raise InputError(f"{text}: {', '.join(twice)} is named twice")
    return found


def _chosen(table: Any, names: list[str], data: Path) -> list[Any]:
    for name in names:
        if name not in table:
            raise LookupFailed("column", name, table, where=str(data))
    return [table[name] for name in names]
