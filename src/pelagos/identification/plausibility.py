"""Units and directions of a record, judged by what no vehicle does and by what its columns say of each other."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

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
_ALIGNED, _ASTRAY = 0.8, 0.4  # length of the mean direction of heading less course: that of a ship, that of chance
_LIKE: Final = 0.9  # correlation of a velocity and its pose's slope
_AS_UNIT: Final = 0.1  # of a factor between units; the nearest two of one kind are 1.8 apart
_ENOUGH: Final = 20  # rows
_FAULTS: Final = 0.02  # share of rows that may jump, as trackers do


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
    elif most > limit:
        others = ", ".join(u for u in UNITS_OF[si] if u != (unit or si))
        hint = f"{most:.4g} {si} is more than any vehicle has ({limit:g}); wrong unit? Give unit: {others}"
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
        off = np.where(np.abs(off - _TAU * np.round(off / _TAU)) < 0.1, 0.0, off)
    speed, limit = np.abs(off) / np.diff(time), PLAUSIBLE[RATES[name]]
    if (speed > limit).mean() > _FAULTS:
        unit = UNITS[COORDINATES.index(RATES[name])]
        likely = "deg" if name in ANGLES else "mm or cm"
        raise InputError(
            f"{where}: column {label!r} as {name}: {100 * (speed > limit).mean():.0f} % of its rows change by more "
            f"than {limit:g} {unit}, which no vehicle does; wrong unit? Give unit: {likely}, or that of the time"
        )


def along_its_way(asked: Table, time: NDArray[np.float64], plan: Plan, where: str) -> None:
    """Refuse a heading that has to do with the way of the vehicle only in the other unit, of degrees and radians."""
    given = plan.columns.get("heading")
    if given is None or not {"north", "east"} <= asked.keys():
        return
    heading, north, east = asked["heading"], asked["north"], asked["east"]
    degrees = given.unit == "deg"
    if not degrees and (given.unit or np.ptp(heading) < _MANY):
        return
    rows = max(1, round(_WAY_S / float(np.median(np.diff(time)))))
    ahead, aside = north[rows:] - north[:-rows], east[rows:] - east[:-rows]
    far = np.hypot(ahead, aside)
    moving = far > 0.5 * np.percentile(far, 90)
    course, middle = np.arctan2(aside, ahead)[moving], heading[rows // 2 : rows // 2 + len(far)][moving]
    other = 180 / np.pi if degrees else np.pi / 180
    as_given, as_other = (abs(np.exp(1j * (k * middle - course)).mean()) for k in (1.0, other))
    if as_other > _ALIGNED and as_given < _ASTRAY:
        words = ("radians", "degrees") if degrees else ("degrees", "radians")
        raise InputError(
            f"{where}: column {given.column!r} as heading goes along with the vehicle's way if it is in {words[0]} "
            f"(alignment {as_other:.2f}), and not in {words[1]} ({as_given:.2f}): give unit: {words[0][:3]}"
        )


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
