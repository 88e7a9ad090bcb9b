"""Doubts about a fit that was made, about the commands of a record and about its water, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from pelagos.identification.coordinates import STILL, UNITS, normal_size, number
from pelagos.identification.record import Record
from pelagos.identification.steps import DOUBTED
from pelagos.identification.water import Water, doubts_of_vary
from pelagos.vehicles.model import Model
from pelagos.vehicles.terms.windage import Windage
from pelagos.vehicles.wetness import Floating

if TYPE_CHECKING:
    from pelagos.identification.fit import Fit, Score

_DIGITS = 3  # of R2, as printed
_LEVEL = ("depth", "roll", "pitch", "w", "p", "q")  # 0 of a vehicle of three degrees of freedom
_WORSE = 1.5  # times the squares before the fit: worse, however few the shots
_SURE = 0.95  # that the unseen part is predicted worse
_FAR = 3.0  # of the sizes of residuals, as `sigma` says and as they are
_MISSED = 3.0  # times what other shots are off, as models that are not perfect seldom do
_CAPSIZED = 0.6  # rad: more than trials in calm water have
_ROUNDING = 1e-6  # of a coordinate's own change: more than fits to a run without noise leave of it


def doubts_before(record: Record, model: Model, water: Water) -> tuple[str, ...]:
    """Doubts about what a fit is made from."""
    return (
        *doubts_of_record(record), *doubts_of_heel(record, model), *doubts_of_commands(record, model),
        *doubts_of_water(water, model), *doubts_of_vary(water),
    )  # fmt: skip


def doubts_of_record(record: Record) -> tuple[str, ...]:
    """Columns that jump, as the record says, and columns that do not change."""
    still = []
    for name, values in record.measured.items():
        used = np.concatenate([values[a:b] for a, b in record.runs])
        level = name in _LEVEL and not np.nan_to_num(used).any()
        if np.nanstd(used) < STILL and not level:
            still.append(f"{name} {np.nanmean(used):.4g} {UNITS[number(name)]}")
    if not still:
        return record.doubts
    told = f"{', '.join(still)}: the same in all rows that are used, so that nothing excites it and it has no R2"
    return (*record.doubts, f"{told}; leave out what was not measured")


def doubts_of_heel(record: Record, model: Model) -> tuple[str, ...]:
    """Tilts in which what floats would capsize: small angles in degrees that are taken for radians."""
    if not isinstance(model.wetting, Floating):
        return ()
    most = {
        name: max(float(np.abs(record.measured[name][a:b]).max()) for a, b in record.runs)
        for name in ("roll", "pitch") if name in record.measured
    }  # fmt: skip
    return tuple(
        f"{name} goes to {angle:.3g} rad, {np.degrees(angle):.3g} deg, in which what floats capsizes: is its column in "
        "degrees? Give it unit: deg"
        for name, angle in most.items() if angle > _CAPSIZED
    )  # fmt: skip


def doubts_of_commands(record: Record, model: Model) -> tuple[str, ...]:
    """Actuators that a record says nothing of, and commands that they do not follow."""
    silent = [name for name in model.actuators if name not in record.commands]
    found = []
    if silent:
        found.append(f"no commands of {', '.join(silent)}: taken for 0 throughout; name their columns under commands")
    for name, given in record.commands.items():
        lag = model.actuators[name].lag
        low, high = float(lag.low), float(lag.high)
        slack = 1e-9 * max(abs(low), abs(high))  # of a factor to SI
        used = np.concatenate([given[a:b] for a, b in record.runs])
        beyond = (used < low - slack) | (used > high + slack)
        if beyond.any():
            found.append(
                f"commands of {name} go from {used.min():.4g} to {used.max():.4g}, beyond its limits {low:.4g} .. "
                f"{high:.4g} in {100 * beyond.mean():.2g} % of the rows, where it stays at them; another unit, "
                "or other limits?"
            )
    return tuple(found)


def doubts_of_water(water: Water, model: Model) -> tuple[str, ...]:
    """Parts of the scenario that a run would have around this vehicle, and a fit has not."""
    windy = model.in_air or any(isinstance(term, Windage) for term in model.terms.values())
    deaf = {"ocean.wind": not windy, "ocean.tide": model.wetting is None}
    found = []
    left_out = [key for key in water.left_out if not deaf.get(key, False)]
    if left_out:
        found.append(f"{', '.join(left_out)}: left out, the fit has a flat surface, no wind, uniform currents")
    if water.ground and model.feels_planes:
        found.append(
            f"the vehicle feels ground and walls, and the world is of the type {water.ground}: they are taken to be far"
        )
    return tuple(found)


def doubts_of_fit(made: Fit) -> tuple[str, ...]:
    """Parameters without influence, a search that did not end, and an unseen part that is predicted badly."""
    found = []
    unfelt = [e.parameter.name for e in made.estimates if not e.felt]
    if unfelt:
        found.append(
            f"nothing that was recorded depends on {', '.join(unfelt)}: still at the prior; leave it out, or record a "
            "motion in which it acts"
        )
    if not made.found.settled:
        found.append(
            f"the search did not settle in {made.plan.iterations} steps: give more iterations or narrower priors"
        )
    shifted = [
        f"{e.parameter.name} by {e.step_shift:+.2g}"
        for e in made.estimates if abs(e.step_shift) > DOUBTED * 0.5 * (e.fisher[1] - e.fisher[0])
    ]  # fmt: skip
    if shifted:
        found.append(
            f"the steps of {1000 * made.record.step_s / made.substeps:.3g} ms shift {', '.join(shifted)}: "
            "give more substeps, or a shorter step_s"
        )
    found += _contradicted(made)
    found += _begun_otherwise(made)
    if made.test is not None:
        found += _unseen(made.test, made.before)
    return tuple(found)


def _contradicted(made: Fit) -> Iterator[str]:
    """A given `sigma` that is not the size of what the fit leaves."""
    given = made.plan.sigma
    for k, name in enumerate(made.plan.fitted if given else ()):
        off = made.found.differences[:, k]
        size = normal_size(off[np.isfinite(off)])
        if name in given and not 1 / _FAR < size / given[name] < _FAR:
            unit = UNITS[number(name)]
            what = "intervals are too narrow" if size > given[name] else "intervals are too wide"
            yield (
                f"sigma of {name} is {given[name]:.3g} {unit}, but what the fit leaves has {size:.3g} {unit}: {what}; "
                "leave sigma out, or mend it"
            )


def _begun_otherwise(made: Fit) -> Iterator[str]:
    """First shots that are missed, whose actuators are only known by `actuators_from`."""
    if made.plan.actuators_from == "unknown" or not made.found.settled:
        return
    shots, off = made.found.shots, made.found.differences  # (steps + 1, c, s)
    told = shots.starts < shots.preroll.max()
    if not told.any() or told.all():
        return
    size = np.array([
        max(normal_size(x[np.isfinite(x)]), _ROUNDING * _change(made.record, name), STILL)
        for name, x in zip(made.plan.fitted, off.swapaxes(0, 1), strict=True)
    ])  # fmt: skip
    missed = np.sqrt(np.nanmean((off / size[:, None]) ** 2, axis=(0, 1)))  # (s,)
    usual, most = float(np.median(missed[~told])), float(missed[told].max())
    if most > _MISSED * max(usual, 1.0) and most > missed[~told].max():
        stood = "0 (rest)" if made.plan.actuators_from == "rest" else "their commands (commands)"
        cure = "commands, or unknown" if made.plan.actuators_from == "rest" else "rest, or unknown"
        yield (
            f"the shot at the beginning of the record is missed by {most / usual:.2g} times the others: actuators are "
            f"taken to be at {stood} there; if they were not, give actuators_from: {cure}"
        )


def _change(record: Record, name: str) -> float:
    """Standard deviation of a coordinate [SI]."""
    values = record.values(name)
    return 0.0 if values is None else float(np.nanstd(values))


def _unseen(test: Score, before: Score) -> Iterator[str]:
    below = [f"{n} {r2:.{_DIGITS}f}" for n, r2 in test.r2.items() if round(r2, _DIGITS) < 0]
    if below:
        yield f"unseen part: R2 below 0, so that its mean would predict it better: {', '.join(below)}"
    worse = [
        f"{n} {r2:.{_DIGITS}f} (priors {before.r2[n]:.{_DIGITS}f})"
        for n, r2 in test.r2.items() if n in before.r2 and round(r2, _DIGITS) < round(before.r2[n], _DIGITS)
        and _surely_larger(test.squares[n], before.squares[n])
    ]  # fmt: skip
    if worse:
        yield f"unseen part: R2 is worse than before the fit: {', '.join(worse)}"


def _surely_larger(squares: NDArray[np.float64], before: NDArray[np.float64]) -> bool:
    """True if squared differences by shot `(s,)` have grown by more than chance, or by half.

    Noise of the states from which shots begin is in both alike, and may fall out for either, shot by shot: growth
    counts where it is larger than its own scatter over the shots, by Student's law (95 %, one-sided).
    """
    grown, shots = squares - before, len(squares)
    if shots == 1 or squares.sum() > _WORSE * before.sum():
        return True
    unsure = float(stdtrit(shots - 1, _SURE)) * grown.std(ddof=1) / np.sqrt(shots)
    return bool(grown.mean() > unsure)
