"""`pelagos fit-noise`: noise of a sensor from its record."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import out as console
from pelagos.errors import InputError, LookupFailed, PelagosWarning
from pelagos.math.constants import GRAVITY

if TYPE_CHECKING:
    from pelagos.identification.noise import SensorNoise
    from pelagos.identification.noise_keys import KeyLine, NoisyQuantity

_FELT: Final = 0.05 * GRAVITY  # [m/s^2]; less is of records that had gravity taken off
_ASTRAY: Final = 0.05  # of gravity: more than offsets and the latitude make


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
    data: Annotated[Path, typer.Argument(metavar="DATA", help="A record: .csv, .csv.gz or .mcap.", show_default=False)],
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
    sensor: Annotated[
        str, typer.Option(metavar="TYPE", help="Whose keys, where they have no prefix.", show_default=False)
    ] = "",
    unit: Annotated[
        str, typer.Option(metavar="UNIT", help="Of the columns, such as deg/s or g; else that of the keys.")
    ] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Identify a sensor's noise: Allan deviation at rest, or beams of a velocity log on its way; as keys."""
    if bool(columns) == bool(beams):
        raise InputError("give --columns of a sensor at rest, or --beams of a velocity log")
    if beams:
        if time or prefix or sensor or unit or time_unit != TimeUnit.s:
            raise InputError(
                "--time, --time-unit, --prefix, --sensor and --unit belong to --columns: beams are in m/s, need no "
                "time, and have the keys of a dvl"
            )
        _show_beams(data, _names(beams), as_json)
        return
    names, time = _names(columns), time or "t"
    if time in names:
        raise InputError(f"{columns}: {time} is the time; name columns of the sensor")
    reading = _reading(prefix, sensor, unit)
    factor = reading.factor(unit) if reading else 1.0
    rate, found = _fitted(data, names, time, time_unit, factor)
    if reading and reading.prefix == "accelerometer_":
        _warn_of_gravity(list(found.values()), data)
    if as_json:
        console.print_json(json.dumps(_as_data(rate, found, reading)))
    else:
        _show(rate, found, reading)


def _show(rate: float, found: dict[str, SensorNoise], reading: NoisyQuantity | None) -> None:
    samples = next(iter(found.values())).samples
    console.print(f"{samples} samples, {rate:.6g} a second: {samples / rate:.4g} s", markup=False)
    x = reading.unit if reading else "x"
    shown = Table(box=None)
    for head in (
        "axis",
        f"white [{x}/sqrt(Hz)]",
        f"bias instability [{x}]",
        f"random walk [{x}/sqrt(s)]",
        f"mean [{x}]",
    ):
        shown.add_column(escape(head), justify="left" if head == "axis" else "right", overflow="fold")
    for name, n in found.items():
        terms = [getattr(n, t) for t in _TERMS]
        told = [f"{t.value:.4g}" if t.visible else f"not seen, < {t.most:.2g}" for t in terms]
        shown.add_row(escape(name), *told, f"{n.mean:.4g}")
    console.print(shown)
    _print_keys(found, reading)


def _reading(prefix: str, sensor: str, unit: str) -> NoisyQuantity | None:
    """Whose keys are asked for; None where nothing says it."""
    from pelagos.identification.noise_keys import reading_of

    if not (prefix or sensor):
        if unit:
            raise InputError(f"--unit {unit}: say of what, with --prefix gyroscope_, accelerometer_, or --sensor TYPE")
        return None
    with _named("--prefix" if prefix and not sensor else "--sensor"):
        return reading_of(prefix, sensor)


def _fitted(
    data: Path, names: list[str], time: str, time_unit: TimeUnit, factor: float
) -> tuple[float, dict[str, SensorNoise]]:
    """Rate [Hz] and noise of columns, in units of `factor`."""
    from pelagos.identification.noise import even_rate
    from pelagos.identification.noise import fit_noise as fitted
    from pelagos.identification.plan import UNIT_SCALES

    series = _chosen(_table(data, [time, *names]), [time, *names], data)
    with _named(str(data)):
        rate = even_rate(series[0] * UNIT_SCALES[time_unit.value])
    found = {}
    for name, x in zip(names, series[1:], strict=True):
        with _named(f"{data}: column {name!r}"):
            found[name] = fitted(x * factor, rate, label=f"{data}: column {name!r}: ")
    return rate, found


def _table(data: Path, names: list[str]) -> Any:
    """Columns of a file by name; of a recording those of one topic, in its own messages."""
    if data.suffix == ".mcap":
        from pelagos.identification.recording import read_topic

        return read_topic(data, names)
    from pelagos.identification.table import read_table

    return read_table(data, names)


def _warn_of_gravity(axes: list[SensorNoise], data: Path) -> None:
    """Warn of three accelerometers at rest that do not feel gravity as it is."""
    if len(axes) != 3:
        return
    felt = sum(n.mean**2 for n in axes) ** 0.5
    if felt > _FELT and abs(felt / GRAVITY - 1) > _ASTRAY:
        warnings.warn(
            f"{data}: the means of three accelerometers make {felt:.4g} m/s^2 together, and gravity is {GRAVITY:g}: "
            "say --unit g or mg, if that is theirs",
            PelagosWarning,
            stacklevel=2,
        )


def _as_data(rate: float, found: dict[str, SensorNoise], reading: NoisyQuantity | None) -> dict[str, Any]:
    terms = {n: {k: getattr(v, k) for k in _TERMS} for n, v in found.items()}
    axes = {n: {k: t.value if t.visible else None for k, t in named.items()} for n, named in terms.items()}
    most = {n: {k: t.most for k, t in named.items() if not t.visible} for n, named in terms.items()}
    made: dict[str, Any] = {"rate_hz": rate, "axes": axes, "most": most}
    if reading is None:
        from pelagos.identification.noise import keys_of

        return {**made, "keys": keys_of(found, "")}
    from pelagos.identification.noise_keys import keys_at_rest

    return {**made, "sensor": reading.sensor, **_keys_as_data(keys_at_rest(found, reading))}


def _keys_as_data(keys: list[KeyLine]) -> dict[str, Any]:
    told = [k for k in keys if k.key and k.value is not None]
    return {"keys": {k.key: k.value for k in told}, "units": {k.key: k.unit for k in told}}


def _print_keys(found: dict[str, SensorNoise], reading: NoisyQuantity | None) -> None:
    if reading is None:
        console.print(
            "x: the unit of the columns. For keys of a simulated sensor say --prefix gyroscope_ or accelerometer_, or "
            "--sensor depth, magnetometer and the like",
            markup=False,
        )
        return
    from pelagos.identification.noise_keys import keys_at_rest

    _print_yaml(reading.sensor, keys_at_rest(found, reading))
    console.print("# a mean has no key: *bias_std is its spread from run to run", markup=False)


def _print_yaml(sensor: str, keys: list[KeyLine]) -> None:
    """Lines to put under a sensor of a scenario."""
    console.print(f"# of a sensor with type: {sensor}", *(k.line for k in keys), sep="\n", markup=False)


def _show_beams(data: Path, names: list[str], as_json: bool) -> None:
    from pelagos.identification.noise import fit_beams
    from pelagos.identification.noise_keys import keys_of_beams

    with _named(str(data)):
        found = fit_beams(_chosen(_table(data, names), names, data))
    keys = keys_of_beams(found)
    if as_json:
        shown = {"lost": found.lost, "pings": found.pings, "speed_mps": found.speed_mps}
        most = {"noise_mps": found.most_mps, "noise_relative": found.most_relative}
        console.print_json(json.dumps({**_keys_as_data(keys), "most": most, "sensor": "dvl", **shown}))
        return
    lost = ", ".join(f"{n} {100 * x:.2g} %" for n, x in zip(names, found.lost, strict=True))
    console.print(f"{found.pings} pings with four beams; lost: {lost}", markup=False)
    _print_yaml("dvl", keys)
    if any(found.lost):
        console.print("# lost beams have no key: a dvl loses them by its range_max_m, tilt and bottom", markup=False)


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Put the place before complaints about numbers."""
    try:
        yield
    except LookupFailed as error:
        if error.where:
            raise
        raise LookupFailed(error.kind, error.given, error.known, where=where) from None
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
