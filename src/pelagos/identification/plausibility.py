"""Units and directions of a record, judged by what no vehicle does and by what its columns say of each other."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from pelagos.errors import InputError
from pelagos.identification.coordinates import ANGLES, COORDINATES, PLAUSIBLE, RATES, UNITS
from pelagos.identification.plan import UNIT_SCALES, UNITS_OF, Plan
from pelagos.identification.table import Table

_TAU: Final = 2 * np.pi
_TILTS: Final = {"roll": np.pi + 0.05, "pitch": np.pi / 2 + 0.05}  # beyond, another angle says the same; some noise
_WAY_S: Final = 1.0  # time over which a course is taken from the way
_MANY: Final = 40.0
"""Range of a heading from which its unit is looked at: of degrees a ninth of a turn; of radians six turns, in which a
vehicle that is carried along no longer looks like it by chance."""
_ALIGNED, _ASTRAY = 0.8, 0.4  # R2 of a vehicle that goes where it looks, but for drift and current; of chance
_STEADY: Final = 0.05  # of the speed over ground: a velocity that says nothing of the heading
_FASTER: Final = 5.0  # than the speed over ground: in a unit that makes a heading of one that hardly turns
_LIKE: Final = 0.9  # correlation of a velocity and its pose's slope
_AS_UNIT: Final = 0.1  # of a factor between units; the nearest two of one kind are 1.8 apart
_DISTANT, _AS_DISTANT_UNIT = 10.0, 0.3  # a factor between units that no angle of attack explains, and its tolerance
_STEEP: Final = 1.0  # a pitch beyond which the way ahead says little of the descent [rad]
_ENOUGH: Final = 20  # rows
_FAULTS: Final = 0.02  # share of rows that may jump, as trackers do
_ABRUPT: Final = 20.0  # of the usual change from row to row, about there and anywhere
_AROUND: Final = 11  # rows
_HARDEST: Final = 10.0  # change of a velocity that a vehicle may have, of 1 g or so [m/s^2], [rad/s^2]
_SLIGHT: Final = 0.1  # beside a whole turn [rad]
_SHORT: Final = 5  # rows of a fault between two jumps


def jumps(name: str, values: NDArray[np.float64], time: NDArray[np.float64]) -> NDArray[np.int64]:
    """Rows after which a column jumps: alone among its neighbours, and harder than any vehicle is moved.

    Args:
        name: of the coordinate; values `(n,)` [SI]; time `(n,)` [s].
    """
    step, off = np.diff(time), np.diff(values)
    if name in ANGLES:
        rest = off - _TAU * np.round(off / _TAU)
        off = np.where(np.abs(rest) < _SLIGHT, rest, off)
    change = np.abs(off) / step
    if not (change > 0).any():
        return np.zeros(0, np.int64)
    usual = np.maximum(median_filter(change, _AROUND, mode="nearest"), np.median(change[change > 0]))
    hard = change / step if name in RATES else change
    return np.flatnonzero((change > _ABRUPT * usual) & (hard > _HARDEST))


def between_jumps(at: NDArray[np.int64], rows: int) -> NDArray[np.bool_]:
    """Rows of short faults: those between two jumps that are near to each other `(rows,)`."""
    found = np.zeros(rows, bool)
    for a, b in pairwise(at.tolist()):
        found[a + 1 : b + 1] |= b - a <= _SHORT
    return found


def dropped(values: NDArray[np.float64], at: NDArray[np.int64]) -> tuple[float, NDArray[np.int64]] | None:
    """A number that a column jumps to and from, 0 or more than once, and its rows; None where there is none.

    Args:
        values: as the file has them `(n,)`; at: see `jumps`.
    """
    for value in np.unique(values[at + 1]):
        same = values == value
        edges = np.flatnonzero(same[1:] != same[:-1])
        if (value == 0 or same.sum() > 1) and np.isin(edges, at).mean() > 0.5:
            return float(value), np.flatnonzero(same)
    return None


def plausible(name: str, values: NDArray[np.float64], label: str, unit: str, where: str) -> None:
    """Refuse values that are larger than any vehicle's."""
    most, limit = float(np.abs(values).max()), PLAUSIBLE[name]
    si = UNITS[COORDINATES.index(name)]
    hint = ""
    if name in _TILTS and most > _TILTS[name]:
        hint = f"{most:.4g} {si} is more than {_TILTS[name]:.3g}, the largest {name} there is: degrees? Give unit: deg"
    elif name in ANGLES and not unit and most > _TAU + 0.1:
        turns = np.abs(np.diff(values)).max()
        if turns > 6.6:
            hint = f"{most:.4g} {si} is more than a turn, and jumps by {turns:.4g}: degrees? Give unit: deg"
    elif name in ANGLES and unit == "deg" and most < np.radians(_TAU + 0.1):
        turn = np.degrees(np.abs(np.diff(values)).max())
        if abs(turn - _TAU) < 2 * _SLIGHT:
            hint = f"no number is beyond 2 pi, and they jump by {turn:.4g}: radians? Give unit: rad"
    elif most > limit:
        others = ", ".join(u for u in UNITS_OF[si] if UNIT_SCALES[u] < UNIT_SCALES[unit or si])
        cure = f"wrong unit? Give unit: {others}" if others else "a mark of lost rows? Name it in the plan (dropouts)"
        hint = f"{most:.4g} {si} is more than any vehicle has ({limit:g}); {cure}"
    if hint:
        raise InputError(f"{where}: column {label!r} as {name}: {hint}")


def steady(name: str, values: NDArray[np.float64], time: NDArray[np.float64], label: str, where: str) -> None:
    """Refuse a pose that goes faster from row to row than any vehicle does: degrees as radians, millimetres as metres.

    A few jumps are faults of a sensor, which the loss bears; whole turns of an angle are none.
    """
    if name not in RATES:
        return
    off = np.diff(values)
    if name in ANGLES:
        off = np.where(np.abs(off - _TAU * np.round(off / _TAU)) < _SLIGHT, 0.0, off)
    speed, limit = np.abs(off) / np.diff(time), PLAUSIBLE[RATES[name]]
    fast = np.flatnonzero(speed > limit)
    if len(fast) > _FAULTS * len(speed):
        if np.isin(fast, jumps(name, values, time)).mean() > 0.5:
            raise InputError(
                f"{where}: column {label!r} as {name} jumps in {100 * len(fast) / len(speed):.0f} % of its rows, too "
                "many for faults that a fit bears: leave these rows out of the file, or smooth it"
            )
        unit = UNITS[COORDINATES.index(RATES[name])]
        likely = "deg" if name in ANGLES else "mm or cm"
        raise InputError(
            f"{where}: column {label!r} as {name}: {100 * len(fast) / len(speed):.0f} % of its rows change by more "
            f"than {limit:g} {unit}, which no vehicle does; wrong unit? Give unit: {likely}, or that of the time"
        )


def along_its_way(asked: Table, time: NDArray[np.float64], plan: Plan, where: str) -> None:
    """Refuse a heading that has to do with the way of the vehicle only in the other unit, of degrees and radians."""
    given = plan.columns.get("heading")
    if given is None or not {"north", "east"} <= asked.keys():
        return
    heading, north, east = asked["heading"], asked["north"], asked["east"]
    degrees = given.unit == "deg"
    if not degrees and np.ptp(heading) < _MANY:
        return
    rows = max(1, round(_WAY_S / float(np.median(np.diff(time)))))
    seconds = time[rows:] - time[:-rows]
    way = np.stack([north[rows:] - north[:-rows], east[rows:] - east[:-rows]], -1) / seconds[:, None]
    middle = heading[rows // 2 : rows // 2 + len(way)]
    other = 180 / np.pi if degrees else np.pi / 180
    as_given, as_other = (_explained(k * middle, way) for k in (1.0, other))
    if as_other > _ALIGNED and as_given < _ASTRAY:
        words = ("radians", "degrees") if degrees else ("degrees", "radians")
        raise InputError(
            f"{where}: column {given.column!r} as heading goes along with the vehicle's way if it is in {words[0]} "
            f"(R2 {as_other:.2f}), and not in {words[1]} ({as_given:.2f}): give unit: {words[0][:3]}"
        )


def _explained(heading: NDArray[np.float64], way: NDArray[np.float64]) -> float:
    """Share of the variance of a velocity over ground that a steady velocity ahead and aside, turned by the heading,
    and a steady current explain.

    Args:
        heading: `(n,)` [rad]; way: north, east `(n, 2)` [m/s].

    Returns:
        R2; 0 of a velocity that hardly changes, and where it would take a faster vehicle than any of its speed.
    """
    scatter, speed = float(way.var(axis=0).sum()), float(np.sqrt((way**2).sum(axis=1).mean()))
    if len(way) < _ENOUGH or scatter < (_STEADY * speed) ** 2:
        return 0.0
    c, s, one, zero = np.cos(heading), np.sin(heading), np.ones(len(way)), np.zeros(len(way))
    basis = np.concatenate([np.stack([c, -s, one, zero], -1), np.stack([s, c, zero, one], -1)])
    found = np.linalg.lstsq(basis, way.T.ravel(), rcond=None)[0]
    if np.hypot(*found[:2]) > _FASTER * speed:
        return 0.0
    return 1 - float(np.mean((basis @ found - way.T.ravel()) ** 2)) * 2 / scatter


def along_its_descent(sinking: NDArray[np.float64], measured: Table, slopes: Table, plan: Plan, where: str) -> None:
    """Refuse a depth that goes with the descent by w, or by the way and the pitch, in another unit or upwards.

    Args:
        sinking: rate of the depth `(n,)` [m/s].
        measured, slopes: by coordinate `(n,)`, of which slopes of a whole pose hold the depth's own rate.
        plan: has the columns; where: for messages.
    """
    descent = _descent(measured, slopes)
    if descent is None:
        return
    known = np.isfinite(sinking) & np.isfinite(descent)
    rate, way = sinking[known], descent[known]
    if known.sum() < _ENOUGH or rate.std() == 0 or way.std() == 0:
        return
    like, ratio = float(np.corrcoef(rate, way)[0, 1]), float(rate.std() / way.std())
    by = "w" if "w" in measured else "the way ahead and the pitch"
    label = f"{where}: column {plan.columns['depth'].column!r} as depth"
    complete = "w" in measured and "pitch" in measured  # a heave that was not measured may go against the rest
    if complete and like < -_LIKE and abs(ratio - 1) < _AS_DISTANT_UNIT:
        raise InputError(
            f"{label} falls where the vehicle descends by {by} (correlation {like:.2f}): a height, or the other sign "
            "of these? Give scale: -1"
        )
    own = plan.columns["depth"].unit or "m"
    for unit in UNITS_OF["m"]:
        other = UNIT_SCALES[own] / UNIT_SCALES[unit]
        near = _AS_UNIT if max(other, 1 / other) < _DISTANT else _AS_DISTANT_UNIT
        if like > _LIKE and unit != own and abs(ratio / other - 1) < near:
            raise InputError(
                f"{label} changes {ratio:.3g} times as fast as the vehicle descends by {by}, as if it were in {unit} "
                f"and not in {own}: give unit: {unit}, or mend the unit of the others or of the time"
            )


def _descent(measured: Table, slopes: Table) -> NDArray[np.float64] | None:
    """Velocity downwards without the depth [m/s], from body velocities or the way ahead; None where nothing says it."""
    pitch, roll = measured.get("pitch"), measured.get("roll", np.float64(0))
    if "w" in measured and pitch is not None:
        across = measured.get("v", np.float64(0)) * np.sin(roll) + measured["w"] * np.cos(roll)
        return across * np.cos(pitch) - measured.get("u", np.float64(0)) * np.sin(pitch)
    if "w" in measured and not {"u", "north", "east"} & measured.keys():  # a motion up and down alone
        return measured["w"]
    if pitch is None or np.abs(pitch[np.isfinite(pitch)]).max(initial=0) > _STEEP:
        return None
    if "u" in measured:
        return -measured["u"] * np.sin(pitch)
    if not {"north", "east", "heading"} <= measured.keys():
        return None
    below = slopes["v"] * np.sin(roll) + slopes["w"] * np.cos(roll)
    return -(slopes["u"] * np.cos(pitch) + below * np.sin(pitch)) * np.tan(pitch)


def along_slopes(measured: Table, slopes: Table, rows: NDArray[np.bool_], plan: Plan, where: str) -> None:
    """Refuse a velocity that goes along with the slope of the pose, but in another unit or with the other sign.

    Of sway and heave that is not asked: they are others at another place of the hull, which turns.

    Args:
        measured, slopes: by coordinate `(n,)`; rows: that are used `(n,)`.
        plan: has the columns; where: for messages.
    """
    for name in ("u", "p", "q", "r"):
        if name not in measured or name not in slopes:
            continue
        known = rows & np.isfinite(measured[name]) & np.isfinite(slopes[name])
        x, slope = measured[name][known], slopes[name][known]
        if known.sum() < _ENOUGH or x.std() == 0 or slope.std() == 0:
            continue
        like, ratio = float(np.corrcoef(x, slope)[0, 1]), float(slope.std() / x.std())
        label = f"{where}: column {plan.columns[name].column!r} as {name}"
        if like < -_LIKE:
            raise InputError(
                f"{label} goes against the slope of the pose (correlation {like:.2f}): give scale: -1, or mend the "
                "direction in which the pose counts"
            )
        kind, own = UNITS[COORDINATES.index(name)], plan.columns[name].unit
        for unit in UNITS_OF[kind]:
            other = UNIT_SCALES[unit] / UNIT_SCALES[own or kind]
            if like > _LIKE and unit != (own or kind) and abs(ratio / other - 1) < _AS_UNIT:
                raise InputError(
                    f"{label} is {1 / ratio:.3g} times the slope of the pose, as if it were in {unit} and not in "
                    f"{own or kind}: give unit: {unit}, or mend the unit of the pose or of the time"
                )
