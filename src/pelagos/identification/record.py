"""A record of a vehicle's motion: read, checked and put on an even grid of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from pelagos.errors import InputError, LookupFailed
from pelagos.identification.clock import Clock, clock_of
from pelagos.identification.coordinates import ANGLES, COORDINATES, PLAUSIBLE, RATES, UNITS
from pelagos.identification.plan import Plan, column
from pelagos.identification.table import Table, read_table

_TAU: Final = 2 * np.pi
_TILTS: Final = {"roll": np.pi + 0.05, "pitch": np.pi / 2 + 0.05}  # beyond, another angle says the same; some noise
_LONGEST_STEP_S: Final = 0.1
_NEAR: Final = 0.01  # of a step: moments as far apart are one
_WAY_S: Final = 1.0  # time over which a course is taken from the way
_MANY: Final = 40.0
"""Range of a heading from which its unit is looked at: of degrees a ninth of a turn; of radians six turns, in which a
vehicle that is carried along no longer looks like it by chance."""
_ALIGNED, _ASTRAY = 0.8, 0.4  # length of the mean direction of heading less course: that of a ship, that of chance
_SHOWN: Final = 3  # places of a fault that a message names
_FAULTS: Final = 0.02  # share of rows that may jump, as trackers do


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
    """

    start_s: float
    step_s: float
    measured: Mapping[str, NDArray[np.float64]]
    slopes: Mapping[str, NDArray[np.float64]]
    commands: Mapping[str, NDArray[np.float64]]
    runs: tuple[tuple[int, int], ...]
    assumed: Mapping[str, float] = field(default_factory=dict)

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
    table, where, origin = _read(source, plan)
    for name in plan.commands:
        if actuators and name not in actuators:
            raise LookupFailed("actuator", name, actuators, where="plan: commands")
    stamps = column(plan.time)
    _column(table, stamps.column, where)
    clock = clock_of(table[stamps.column], stamps, where, origin)
    time = clock.t
    seen = _seen(table, plan, len(time), where)
    measured, asked = {}, {}
    for name, given in plan.columns.items():
        c = column(given)
        raw = (_column(table, c.column, where) - c.zero) * c.factor
        _finite(raw, seen, clock, c.column, where)
        _plausible(name, raw[seen], c.column, c.unit, where)
        _steady(name, raw[seen], time[seen], c.column, where)
        asked[name] = raw[seen]
        measured[name] = (time[seen] - c.delay_s, _unwrapped(name, raw[seen]))
    _along_its_way(asked, time[seen], plan, where)
    commands = {}
    for name, given in plan.commands.items():
        c = column(given)
        raw = (_column(table, c.column, where) - c.zero) * c.factor
        _finite(raw, np.ones(len(time), bool), clock, c.column, where)
        commands[name] = (time - c.delay_s, raw)
    return _gridded(clock, time[seen], measured, commands, plan, where)


def _read(source: str | Path | Table, plan: Plan) -> tuple[Table, str, float]:
    """Columns that a plan names, a name for messages, and what stamps count from [s]."""
    if isinstance(source, Mapping):
        return dict(source), "data", 0.0
    wanted = [column(c).column for c in (plan.time, *plan.columns.values(), *plan.commands.values())]
    wanted += [name for out in plan.dropouts for name in out.columns]
    if Path(source).suffix != ".mcap":
        return read_table(source, wanted), str(source), 0.0
    from pelagos.identification.recording import read_recording

    table, origin = read_recording(Path(source), wanted, {column(c).column for c in plan.commands.values()})
    return table, str(source), origin if column(plan.time).column == "t" else 0.0


def _column(table: Table, name: str, where: str) -> NDArray[np.float64]:
    if name not in table:
        raise LookupFailed("column", name, table, where=where)
    values = np.asarray(table[name], dtype=np.float64)
    size = max(len(x) for x in table.values())
    if values.shape != (size,):
        raise InputError(f"{where}: column {name!r} has the shape {values.shape}, others have {size} rows")
    return values


def _seen(table: Table, plan: Plan, rows: int, where: str) -> NDArray[np.bool_]:
    seen = np.ones(rows, bool)
    for out in plan.dropouts:
        lost = np.ones(rows, bool)
        for name in out.columns:
            lost &= _column(table, name, where) == out.value
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


def _plausible(name: str, values: NDArray[np.float64], label: str, unit: str, where: str) -> None:
    most, limit = float(np.abs(values).max()), PLAUSIBLE[name]
    si = UNITS[COORDINATES.index(name)]
    hint = ""
    if name in _TILTS and most > _TILTS[name]:
        hint = f"{most:.4g} {si} is more than {_TILTS[name]:.3g}, the largest {name} there is: degrees? Give unit: deg"
    elif name in ANGLES and not unit and most > _TAU + 0.1:
        turns = np.abs(np.diff(values)).max()
        if turns > 6.6:
            hint = f"{most:.4g} {si} is more than a turn, and jumps by {turns:.4g}: degrees? Give unit: deg"
    elif most > limit:
        hint = f"{most:.4g} {si} is more than any vehicle has ({limit:g}); wrong unit? Give unit: mm/s, deg/s, ..."
    if hint:
        raise InputError(f"{where}: column {label!r} as {name}: {hint}")


def _steady(name: str, values: NDArray[np.float64], time: NDArray[np.float64], label: str, where: str) -> None:
    """Refuse a pose that goes faster from row to row than any vehicle does: degrees as radians, millimetres as metres.

    A few jumps are faults of a sensor, which the loss bears; whole turns of an angle are none.
    """
    if name not in RATES:
        return
    off = np.diff(values)
    if name in ANGLES:
        off = np.where(np.abs(off - _TAU * np.round(off / _TAU)) < 0.1, 0.0, off)
    speed, limit = np.abs(off) / np.diff(time), PLAUSIBLE[RATES[name]]
    if (speed > limit).mean() > _FAULTS:
        unit = UNITS[COORDINATES.index(RATES[name])]
        likely = "deg" if name in ANGLES else "mm or cm"
        raise InputError(
            f"{where}: column {label!r} as {name}: {100 * (speed > limit).mean():.0f} % of its rows change by more "
            f"than {limit:g} {unit}, which no vehicle does; wrong unit? Give unit: {likely}"
        )


def _along_its_way(asked: Table, time: NDArray[np.float64], plan: Plan, where: str) -> None:
    """Refuse a heading that has to do with the way of the vehicle only if it is taken for degrees."""
    given = plan.columns.get("heading")
    if given is None or column(given).unit or not {"north", "east"} <= asked.keys():
        return
    heading, north, east = asked["heading"], asked["north"], asked["east"]
    if np.ptp(heading) < _MANY:
        return
    rows = max(1, round(_WAY_S / float(np.median(np.diff(time)))))
    ahead, aside = north[rows:] - north[:-rows], east[rows:] - east[:-rows]
    far = np.hypot(ahead, aside)
    moving = far > 0.5 * np.percentile(far, 90)
    course, middle = np.arctan2(aside, ahead)[moving], heading[rows // 2 : rows // 2 + len(far)][moving]
    as_radians, as_degrees = (abs(np.exp(1j * (k * middle - course)).mean()) for k in (1.0, np.pi / 180))
    if as_degrees > _ALIGNED and as_radians < _ASTRAY:
        raise InputError(
            f"{where}: column {column(given).column!r} as heading goes along with the vehicle's way if it is in degrees"
            f" (alignment {as_degrees:.2f}), and not in radians ({as_radians:.2f}): give unit: deg"
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
) -> Record:
    time, step = clock.t, clock.step_s
    longest = plan.gap_s or 5 * step
    holes = np.flatnonzero(np.diff(seen) > longest)
    windows = [(a - clock.start_s, b - clock.start_s) for a, b in plan.windows_s] or [(0.0, float(time[-1]))]
    if plan.gaps == "refuse":
        inside = [k for k in holes if any(a <= seen[k] < b for a, b in windows)]
        if inside:
            k = inside[0]
            raise InputError(
                f"{where}: nothing is measured between {clock.say(seen[k])} and {clock.say(seen[k + 1])} s, longer "
                f"than {longest:.3g} s ({len(inside)} such); give gaps: split, or a larger gap_s"
            )
    h = plan.step_s or step / np.ceil(step / _LONGEST_STEP_S - _NEAR)
    n = int(np.floor(time[-1] / h + _NEAR)) + 1
    grid = h * np.arange(n)
    there = np.zeros(n, bool)
    parts = [0, *(int(k) + 1 for k in holes), len(seen)]
    for first, after in pairwise(parts):
        there |= (grid >= seen[first] - _NEAR * h) & (grid <= seen[after - 1] + _NEAR * h)
    used = np.zeros(n, bool)
    for a, b in windows:
        used |= (grid >= a - _NEAR * h) & (grid <= b + _NEAR * h)
    found = {name: np.where(there, np.interp(grid, t, x), np.nan) for name, (t, x) in measured.items()}
    held = {
        name: x[np.clip(np.searchsorted(t, grid + _NEAR * h, side="right") - 1, 0, len(x) - 1)]
        for name, (t, x) in commands.items()
    }
    runs = _runs(there & used, max(10, round(plan.smooth_s / h)))
    if not runs:
        raise InputError(
            f"{where}: no stretch of {f'the windows {plan.windows_s}' if plan.windows_s else 'the record'} is long "
            f"enough; time goes from {clock.say(0.0)} to {clock.say(time[-1])} s"
        )
    return Record(clock.start_s, float(h), found, _slopes(found, runs, h, plan.smooth_s), held, runs, plan.start)


def _runs(there: NDArray[np.bool_], least: int) -> tuple[tuple[int, int], ...]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(np.int8)))
    return tuple((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > least)


def _slopes(
    measured: Mapping[str, NDArray[np.float64]], runs: tuple[tuple[int, int], ...], h: float, smooth_s: float
) -> dict[str, NDArray[np.float64]]:
    """Velocities in body axes from slopes of the pose: parabolas through `smooth_s` of it (Savitzky and Golay 1964)."""
    window = max(5, 2 * round(smooth_s / h / 2) + 1)
    size = len(next(iter(measured.values())))
    rate: dict[str, NDArray[np.float64]] = {}
    for name in COORDINATES[:6]:
        if name in measured:
            rate[name] = np.full(size, np.nan)
            for a, b in runs:
                rate[name][a:b] = savgol_filter(measured[name][a:b], window, 2, deriv=1, delta=h)
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
    return {name: values for name, values in found.items() if name in kept and name not in measured}
