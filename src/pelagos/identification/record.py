"""A record of a vehicle's motion: read, checked and put on an even grid of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from pelagos.errors import InputError, LookupFailed
from pelagos.identification.clock import Clock, clock_of
from pelagos.identification.coordinates import ANGLES, COORDINATES, RATES, UNITS
from pelagos.identification.plan import ColumnConfig, Plan
from pelagos.identification.plausibility import (
    along_its_descent,
    along_its_way,
    along_slopes,
    between_jumps,
    dropped,
    jumps,
    plausible,
    steady,
)
from pelagos.identification.run_steps import RunSteps, says_its_steps
from pelagos.identification.table import Table, numeric, read_table

_LONGEST_STEP_S: Final = 0.1
_FINEST: Final = 1e-3  # of the spacing of rows: a shorter step of the simulation is a slip of the unit
_NEAR: Final = 0.01  # of a step: moments as far apart are one
_FEWEST: Final = 11  # rows of a stretch that is used
_SHOWN: Final = 3  # places of a fault that a message names


@dataclass(frozen=True)
class Record:
    """Motion and commands on an even grid.

    Attributes:
        start_s: time of the first row [s].
        step_s: of the grid [s].
        measured: by coordinate `(n,)`, SI, angles unwrapped; NaN where nothing was measured.
        slopes: velocities from poses `(n,)`, for those coordinates that were not measured.
        commands: by actuator `(n,)`, held from one row to the next.
        runs: first and last row + 1 of stretches without a hole.
        assumed: coordinates that were not measured when a shot begins; absent: 0.
        doubts: columns that jump, in words.
        run: steps of the run that was recorded; None where it was no run, or they are not known.
    """

    start_s: float
    step_s: float
    measured: Mapping[str, NDArray[np.float64]]
    slopes: Mapping[str, NDArray[np.float64]]
    commands: Mapping[str, NDArray[np.float64]]
    runs: tuple[tuple[int, int], ...]
    assumed: Mapping[str, float] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    run: RunSteps | None = None

    def values(self, name: str) -> NDArray[np.float64] | None:
        """A coordinate, measured or from slopes; None where there is neither."""
        found = self.measured.get(name)
        return self.slopes.get(name) if found is None else found


def read_record(source: str | Path | Table, plan: Plan, actuators: tuple[str, ...] = ()) -> Record:
    """A record as `plan` describes it.

    Args:
        source: a CSV file (first line: names), a recording (`.mcap`), or columns by name.
        plan: which column is what.
        actuators: names that commands may have; empty: any.

    Raises:
        InputError: a column is missing; times are not in order or occur twice; a cell is not finite; rows are missing;
            a quantity is too large for its unit. Says where, and what to do.
    """
    table, where, origin, run = _read(source, plan)
    for name in plan.commands:
        if actuators and name not in actuators:
            raise LookupFailed("actuator", name, actuators, where="plan: commands")
    stamps = plan.time
    clock = clock_of(_column(table, stamps.column, where), stamps, where, origin)
    time = clock.t
    seen = _seen(table, plan, len(time), where)
    measured, asked = {}, {}
    doubts: list[str] = []
    for name, c in plan.columns.items():
        given = _column(table, c.column, where, len(time))
        raw = (given - c.zero) * c.factor
        _finite(raw, seen, clock, c.column, where)
        at = jumps(name, raw[seen], time[seen])
        _no_dropouts(given, at, seen, clock, f"column {c.column!r} as {name}", c.column, where)
        plausible(name, raw[seen][~between_jumps(at, int(seen.sum()))], c.column, c.unit, where)
        steady(name, raw[seen], time[seen], c.column, where)
        doubts += _jumps_told(name, raw[seen], at, np.flatnonzero(seen), clock)
        asked[name] = raw[seen]
        _within(c, f"columns.{name}", clock)
        measured[name] = (time[seen] - c.delay_s, _unwrapped(name, raw[seen]))
    along_its_way(asked, time[seen], plan, where)
    commands = {}
    for name, c in plan.commands.items():
        raw = (_column(table, c.column, where, len(time)) - c.zero) * c.factor
        _finite(raw, np.ones(len(time), bool), clock, c.column, where)
        _within(c, f"commands.{name}", clock)
        commands[name] = (time - c.delay_s, raw)
    return replace(_gridded(clock, time[seen], measured, commands, plan, where, run), doubts=tuple(doubts))


def _read(source: str | Path | Table, plan: Plan) -> tuple[Mapping[str, Any], str, float, RunSteps | None]:
    """Columns that a plan names, a name for messages, what stamps count from [s], and the steps of a run."""
    if not isinstance(source, (str, Path)):
        return _given(source), "data", 0.0, None
    wanted = [c.column for c in (plan.time, *plan.columns.values(), *plan.commands.values())]
    wanted += [name for out in plan.dropouts for name in out.columns]
    if Path(source).suffix != ".mcap":
        return read_table(source, wanted), str(source), 0.0, None
    from pelagos.identification.recording import read_run

    table, origin, run = read_run(Path(source), wanted, {c.column for c in plan.commands.values()})
    return table, str(source), origin if plan.time.column == "t" else 0.0, run


def _given(source: Any) -> dict[str, Any]:
    """Columns of a mapping, or of a data frame, which is like one."""
    if not hasattr(source, "keys"):
        raise InputError(f"give a file or columns by name, not {type(source).__name__}")
    found = {name: source[name] for name in source}
    if not found:
        raise InputError("data: there are no columns")
    return found


def _column(table: Mapping[str, Any], name: str, where: str, rows: int | None = None) -> NDArray[Any]:
    """A column of so many rows."""
    if name not in table:
        raise LookupFailed("column", name, table, where=where)
    values = numeric(table[name], f"{where}: column {name!r}")
    if rows is not None and len(values) != rows:
        raise InputError(f"{where}: column {name!r} has {len(values)} rows, and the time has {rows}")
    return values if rows is None else values.astype(np.float64)


def _seen(table: Mapping[str, Any], plan: Plan, rows: int, where: str) -> NDArray[np.bool_]:
    seen = np.ones(rows, bool)
    for out in plan.dropouts:
        lost = np.ones(rows, bool)
        for name in out.columns:
            lost &= _column(table, name, where, rows) == out.value
        seen &= ~lost
    if seen.sum() < 10:
        raise InputError(f"{where}: only {int(seen.sum())} rows are left outside the drop-outs of the plan")
    return seen


def _finite(values: NDArray[np.float64], used: NDArray[np.bool_], clock: Clock, name: str, where: str) -> None:
    bad = np.flatnonzero(~np.isfinite(values) & used)
    if len(bad):
        if len(bad) == len(values):
            raise InputError(f"{where}: column {name!r} is empty or not a number in every row; another column?")
        places = ", ".join(f"row {k + 1} ({clock.say(clock.t[k])} s)" for k in bad[:_SHOWN])
        raise InputError(
            f"{where}: column {name!r} has {_count(len(bad), 'cell')} empty or not a number, the first in {places}; "
            "leave these rows out of the file, or name them in the plan (dropouts: [{columns: [...], value: 0}])"
        )


def _no_dropouts(
    given: NDArray[np.float64], at: NDArray[np.int64], seen: NDArray[np.bool_], clock: Clock, what: str, name: str,
    where: str,
) -> None:  # fmt: skip
    """Refuse a column that holds one number where nothing was measured."""
    found = dropped(given[seen], at) if len(at) else None
    if found is None:
        return
    value, rows = found
    first = int(np.flatnonzero(seen)[rows[0]])
    raise InputError(
        f"{where}: {what} jumps to exactly {value:g} and back, in {len(rows)} rows, the first in row {first + 1} "
        f"({clock.say(clock.t[first])} s): drop-outs? Name them in the plan (dropouts: [{{columns: [{name}], value: "
        f"{value:g}}}], and gaps: split), or leave these rows out of the file"
    )


def _jumps_told(
    name: str, values: NDArray[np.float64], at: NDArray[np.int64], rows: NDArray[np.int64], clock: Clock
) -> list[str]:
    """Jumps of a column `(n,)`, in words; rows: of the record `(n,)`."""
    if not len(at):
        return []
    k = int(at[np.argmax(np.abs(values[at + 1] - values[at]))])
    a, b = int(rows[k]), int(rows[k + 1])
    more = f"the largest of {len(at)}, the first after row {rows[at[0]] + 1}" if len(at) > 1 else "the only one"
    unit = UNITS[COORDINATES.index(name)]
    return [
        f"{name} jumps from {values[k]:.4g} to {values[k + 1]:.4g} {unit} between rows {a + 1} and {b + 1} "
        f"({clock.say(clock.t[a])} and {clock.say(clock.t[b])} s), {more}: a fault, or a tracker that was set anew? "
        "Leave such rows out of the file, or give windows_s without them"
    ]


def _within(c: ColumnConfig, key: str, clock: Clock) -> None:
    """Refuse a delay that leaves nothing of the record."""
    length = float(clock.t[-1])
    if abs(c.delay_s) >= length:
        raise InputError(
            f"plan: {key}: delay_s {c.delay_s:g} reaches beyond the record, which is {length:.4g} s long; "
            "it is a time in seconds, such as 0.1"
        )


def _unwrapped(name: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.unwrap(values) if name in ANGLES else values


def _count(n: int, what: str) -> str:
    return f"1 {what} that is" if n == 1 else f"{n} {what}s that are"


def _gridded(
    clock: Clock,
    seen: NDArray[np.float64],
    measured: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
    commands: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
    plan: Plan,
    where: str,
    run: RunSteps | None,
) -> Record:
    time, step = clock.t, clock.step_s
    longest = plan.gap_s or 5 * step
    holes = np.flatnonzero(np.diff(seen) > longest)
    windows = _windows(clock, plan, where)
    if plan.gaps == "refuse":
        inside = [k for k in holes if any(a <= seen[k] < b for a, b in windows)]
        if inside:
            k = inside[0]
            raise InputError(
                f"{where}: nothing is measured between {clock.say(seen[k])} and {clock.say(seen[k + 1])} s, longer "
                f"than {longest:.3g} s ({len(inside)} such); give gaps: split, or a larger gap_s"
            )
    usual = step / np.ceil(step / _LONGEST_STEP_S - _NEAR)
    h = plan.step_s or (usual if run is None or says_its_steps(plan) else run.grid_s(step, usual))
    if h < _FINEST * step:
        raise InputError(
            f"plan: step_s: {h:g} s is too short for rows that are {step:.4g} s apart; "
            f"give {_FINEST * step:.4g} or more"
        )
    n = int(np.floor(time[-1] / h + _NEAR)) + 1
    grid = np.asarray(h * np.arange(n), dtype=np.float64)
    there = _covered(grid, h, [t for t, _ in measured.values()], holes)
    for t, _ in commands.values():
        there &= (grid >= t[0] - _NEAR * h) & (grid <= t[-1] + _NEAR * h)
    used = np.zeros(n, bool)
    for a, b in windows:
        used |= (grid >= a - _NEAR * h) & (grid <= b + _NEAR * h)
    found = {name: np.where(there, np.interp(grid, t, x), np.nan) for name, (t, x) in measured.items()}
    held = {
        name: x[np.clip(np.searchsorted(t, grid + _NEAR * h, side="right") - 1, 0, len(x) - 1)]
        for name, (t, x) in commands.items()
    }
    least = max(_FEWEST, _window(plan.smooth_s, h)) - 1
    runs = _runs(there & used, least)
    if not runs:
        delayed = any(c.delay_s for c in (*plan.columns.values(), *plan.commands.values()))
        raise InputError(
            f"{where}: no stretch of {f'the windows {plan.windows_s}' if plan.windows_s else 'the record'} is longer "
            f"than {least * h:.4g} s, {least} steps of {h:.4g} s{', less the delays of columns' if delayed else ''}; "
            f"time goes from {clock.say(0.0)} to {clock.say(time[-1])} s"
        )
    slopes = _slopes(found, runs, h, plan.smooth_s)
    along_slopes(found, slopes, _rows(runs, n), plan, where)
    if "depth" in found:
        along_its_descent(rate_of(found["depth"], runs, h, plan.smooth_s), found, slopes, plan, where)
    slopes = {name: x for name, x in slopes.items() if name not in found}
    return Record(clock.start_s, float(h), found, slopes, held, runs, plan.start, run=run)


def _windows(clock: Clock, plan: Plan, where: str) -> list[tuple[float, float]]:
    """Parts that are used, from and to, since the first row [s]."""
    end = float(clock.t[-1])
    found = [(a - clock.start_s, b - clock.start_s) for a, b in plan.windows_s] or [(0.0, end)]
    for a, b in found:
        if a > end or b < 0:
            raise InputError(
                f"{where}: windows_s: {clock.say(a)} to {clock.say(b)} s lies outside of the record; time goes from "
                f"{clock.say(0.0)} to {clock.say(end)} s"
            )
    return found


def _covered(
    grid: NDArray[np.float64], h: float, series: Sequence[NDArray[np.float64]], holes: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Moments at which every series of times has rows on both sides that are not apart by a hole."""
    found = np.ones(len(grid), bool)
    for t in series:
        there = np.zeros(len(grid), bool)
        for first, after in pairwise([0, *(int(k) + 1 for k in holes), len(t)]):
            there |= (grid >= t[first] - _NEAR * h) & (grid <= t[after - 1] + _NEAR * h)
        found &= there
    return found


def _rows(runs: tuple[tuple[int, int], ...], n: int) -> NDArray[np.bool_]:
    found = np.zeros(n, bool)
    for a, b in runs:
        found[a:b] = True
    return found


def _runs(there: NDArray[np.bool_], least: int) -> tuple[tuple[int, int], ...]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(np.int8)))
    return tuple((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > least)


def _window(smooth_s: float, h: float) -> int:
    """Rows of a parabola: the odd number nearest to its length in steps, five or more."""
    return max(5, 2 * int(smooth_s / h / 2 + _NEAR) + 1)


def rate_of(
    values: NDArray[np.float64], runs: tuple[tuple[int, int], ...], h: float, smooth_s: float
) -> NDArray[np.float64]:
    """Slopes of parabolas through `smooth_s` of a coordinate `(n,)`, with steps of h; NaN between stretches."""
    found = np.full(len(values), np.nan)
    for a, b in runs:
        found[a:b] = savgol_filter(values[a:b], _window(smooth_s, h), 2, deriv=1, delta=h)
    return found


def _slopes(
    measured: Mapping[str, NDArray[np.float64]], runs: tuple[tuple[int, int], ...], h: float, smooth_s: float
) -> dict[str, NDArray[np.float64]]:
    """Velocities in body axes from slopes of the pose: parabolas through `smooth_s` of it (Savitzky and Golay 1964)."""
    size = len(next(iter(measured.values())))
    rate = {name: rate_of(measured[name], runs, h, smooth_s) for name in COORDINATES[:6] if name in measured}
    found: dict[str, NDArray[np.float64]] = {}
    zero = np.zeros(size)
    roll, pitch = measured.get("roll", zero), measured.get("pitch", zero)
    if "heading" in measured and "north" in rate and "east" in rate:
        psi, down = measured["heading"], rate.get("depth", zero)
        level = rate["north"] * np.cos(psi) + rate["east"] * np.sin(psi)
        across = -rate["north"] * np.sin(psi) + rate["east"] * np.cos(psi)
        found["u"] = level * np.cos(pitch) - down * np.sin(pitch)
        below = level * np.sin(pitch) + down * np.cos(pitch)
        found["v"] = across * np.cos(roll) + below * np.sin(roll)
        found["w"] = below * np.cos(roll) - across * np.sin(roll)
    elif "depth" in rate:
        found["w"] = rate["depth"]
    turn, lift, lean = (rate.get(k, zero) for k in ("heading", "pitch", "roll"))
    found["p"] = lean - turn * np.sin(pitch)
    found["q"] = lift * np.cos(roll) + turn * np.cos(pitch) * np.sin(roll)
    found["r"] = turn * np.cos(pitch) * np.cos(roll) - lift * np.sin(roll)
    kept = {RATES[name] for name in rate}
    return {name: values for name, values in found.items() if name in kept}
