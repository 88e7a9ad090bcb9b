"""Identification of a vehicle from a record of its motion."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.config.scenario import Scenario
from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.certainty import NORMAL_95, UNFELT, UNTOLD, Certainty, certainty
from pelagos.identification.command_units import in_own_units
from pelagos.identification.coordinates import COORDINATES, STILL
from pelagos.identification.doubts import doubts_before, doubts_of_fit
from pelagos.identification.exchange import exchanged
from pelagos.identification.excitation import refuse_unexcited
from pelagos.identification.parameters import OUTSIDE, Family, Parameter, changed, listed, parameters_of
from pelagos.identification.plan import Plan
from pelagos.identification.preroll import doubts_of_preroll, longer_preroll, preroll_of
from pelagos.identification.problem import (
    Problem,
    cut_shots,
    free_coordinates,
    hidden_coordinates,
    shots_at,
    target,
)
from pelagos.identification.record import Record
from pelagos.identification.run_shift import doubts_of_run
from pelagos.identification.run_steps import MOST, in_run_steps
from pelagos.identification.search import Found, search
from pelagos.identification.shots import Shooter, Shots, shooter_of
from pelagos.identification.steps import SHARE, finite_substeps, step_shift
from pelagos.identification.water import Water, depth_told, water_of
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.model import Model
from pelagos.vehicles.vehicle import Vehicle

_TURNS: Final = 3  # fits at most, for the preroll of lags that were found


@dataclass(frozen=True)
class Estimate:
    """One parameter after the fit.

    Attributes:
        parameter: with its prior; value: found; low, high: 95 % interval, the wider of the next two.
        fisher: 95 % interval by Fisher's information; resampled: by resampled shots, or None.
        identified: whether the data say more than the prior.
        told: share of the prior's spread that the data took away.
        bounded: whether it stands at a bound.
        step_shift: by how much the simulation's steps shift it, in its unit.
        felt: whether anything that was recorded depends on it.
    """

    parameter: Parameter
    value: float
    low: float
    high: float
    fisher: tuple[float, float]
    resampled: tuple[float, float] | None
    identified: bool
    told: float
    bounded: bool
    step_shift: float = 0.0
    felt: bool = True

    @property
    def said(self) -> str:
        """Verdict on its identification, in words."""
        if not self.felt:
            return "no: without influence"
        return "at its bound" if self.bounded else "yes" if self.identified else "no: mostly the prior"


@dataclass(frozen=True)
class Score:
    """Open loop against a record, by coordinate: R2 = 1 - sum of squares / variance about the mean, and rms.

    What does not change in the record has no R2. squares: by coordinate, sums of squared differences by shot `(s,)`.
    """

    r2: Mapping[str, float]
    rms: Mapping[str, float]
    shots: int
    seconds: float
    squares: Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Fit:
    """A fitted vehicle.

    Attributes:
        estimates: by parameter; certainty: joint; found: the search's end.
        vehicle: keys of the fitted vehicle, as a scenario has them.
        train, test: open loop from measured states; test is None where nothing was left for it.
        before: the same as `test` (or `train`) with the priors.
        record, plan: what it was made from.
        simulated: coordinates `(steps + 1, 12, s)` of all shots in open loop, and the shots.
        seconds: of the fit, on the wall.
        doubts: warnings that were issued, in words.
        substeps: steps of the simulation in one of the record's grid.
    """

    estimates: tuple[Estimate, ...]
    certainty: Certainty
    found: Found
    vehicle: dict[str, Any]
    train: Score
    test: Score | None
    before: Score
    record: Record
    plan: Plan
    simulated: tuple[NDArray[np.float64], Shots]
    seconds: float
    doubts: tuple[str, ...] = ()
    substeps: int = 1

    def value(self, name: str) -> float:
        """Of a parameter."""
        return next(e.value for e in self.estimates if e.parameter.name == name)


def vehicle_with_plan(vehicle: VehicleConfig | Mapping[str, Any], plan: Plan) -> dict[str, Any]:
    """Keys of a vehicle with the plan's changes and a mode for its actuators; in calm water."""
    from pelagos.vehicles.load import merged

    given = vehicle if isinstance(vehicle, VehicleConfig) else Vehicle.from_dict(vehicle).config
    data = merged(given.model_dump(mode="python"), plan.vehicle)
    config = Vehicle.from_dict(data, where="plan: vehicle").config
    found: dict[str, Any] = listed(config.model_dump(mode="python"))
    return found


def _calm(data: Mapping[str, Any], plan: Plan) -> dict[str, Any]:
    asked = plan.integrator or plan.vehicle.get("integrator", "runge_kutta")
    return {
        **data, "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators", "seakeeping": "slope",
        "integrator": data["integrator"] if asked == "vehicle" else asked,
    }  # fmt: skip


def fit(
    vehicle: VehicleConfig | Mapping[str, Any],
    record: Record,
    plan: Plan,
    *,
    scenario: Scenario | Mapping[str, Any] | str | Path | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Fit:
    """Identify `plan.parameters` of a vehicle.

    Args:
        vehicle: as a scenario has it; its numbers are the priors.
        record: from `read_record` with the same plan.
        plan: parameters and the way of fitting.
        scenario: whose water it was, at rest, and whose ground, if that is flat; None: open sea, deep.
        tell: hears of progress.

    Raises:
        InputError: a parameter does not exist, or the record excites too little to identify anything.
        SimulationError: the motion with the priors is not finite.

    Warns:
        PelagosWarning: commands are missing or beyond limits, the search did not settle, or the unseen part is
            predicted badly.
    """
    began = time.perf_counter()
    if not plan.parameters:
        raise InputError("plan: parameters: name at least one, such as terms.damping.diagonal.0: {}")
    plan = in_run_steps(plan, record.run, record.step_s)
    data, water = vehicle_with_plan(vehicle, plan), water_of(scenario)
    known = water.outside(in_air=data["medium"] == "air")
    parameters = parameters_of(plan.parameters, data, known)
    family = Family(_calm(data, plan), parameters, known)
    given, record = record, in_own_units(record, plan, family.model)
    depth_told(record, family.model)
    doubtful = _doubted_before(record, family.model, water)
    shooter = shooter_of(family, record, water)
    end = _solved(family, shooter, record, plan, tell)
    problem, found, shots, rest = end.problem, end.found, end.shots, end.rest
    estimates = tuple(_estimate(p, k, found, end.sure, end.shift) for k, p in enumerate(parameters))
    _narrowed(estimates)
    train = score(shooter, family, found.at, record, shots)
    all_shots, _ = cut_shots(record, plan, end.preroll_s)
    test = score(shooter, family, found.at, record, rest) if len(rest) else None
    before = score(shooter, family, problem.prior, record, rest if len(rest) else shots)
    seen, _ = shooter.play(all_shots, family.compiled_values(found.at), [], tangents=False)
    made = Fit(
        estimates, end.sure, found, changed(data, parameters, family.values(found.at)), train, test, before, given,
        plan, (seen, all_shots), time.perf_counter() - began, substeps=shooter.substeps,
    )  # fmt: skip
    slow = doubts_of_preroll(plan, end.preroll_s, family.model_at(found.at))
    other_steps = doubts_of_run(problem, found, end.sure, record, water)
    return _doubted(made, doubtful, (*slow, *end.doubts, *other_steps))


@dataclass(frozen=True)
class _Solved:
    """End of a search, its certainty and shift by the steps `(p,)`, and the problem: its shots, and those for the test,
    which begin after so long a preroll; doubts of it, in words.
    """

    found: Found
    sure: Certainty
    shift: NDArray[np.float64]
    problem: Problem
    shots: Shots
    rest: Shots
    preroll_s: float
    doubts: tuple[str, ...]


def _solved(family: Family, shooter: Shooter, record: Record, plan: Plan, tell: Callable[[str], None]) -> _Solved:
    """A fit, made again where actuators turn out too slow for the preroll that their priors asked for."""
    preroll_s = preroll_of(plan, family.model)
    length_s = max(b for _, b in record.runs) * record.step_s
    all_shots, _ = cut_shots(record, plan, preroll_s)
    shooter.divide(finite_substeps(shooter, family, all_shots, plan.substeps))
    at, run = None, record.run
    own = run is not None and run.are(family.data["integrator"], shooter.grid_s / shooter.substeps)
    for turn in range(_TURNS):
        problem, shots, rest = _posed(family, shooter, record, plan, preroll_s)
        found, sure, shift = _searched(problem, shots, tell, at, own=own)
        longer = longer_preroll(plan, preroll_s, family.model_at(found.at), length_s)
        if longer is None or turn == _TURNS - 1:
            break
        preroll_s, at = longer, found.at
        tell(f"again, with {preroll_s:.3g} s before each shot")
    return _Solved(found, sure, shift, problem, shots, rest, preroll_s, exchanged(problem, found, tell))


def _posed(
    family: Family, shooter: Shooter, record: Record, plan: Plan, preroll_s: float
) -> tuple[Problem, Shots, Shots]:
    """The problem of a fit, and the shots that are fitted and those that are left for the test."""
    all_shots, joined = cut_shots(record, plan, preroll_s)
    count = max(1, round(plan.train * len(all_shots)))
    free = free_coordinates([*plan.fitted, *plan.continuity])
    shots = _some(all_shots, slice(0, count))
    refuse_unexcited(record, plan, all_shots)
    wanted = target(record, shots, plan.fitted).once(joined[:count])
    hidden = hidden_coordinates(record, shooter, family, shots, wanted)
    problem = Problem(family, shooter, wanted, joined[:count], plan, free, hidden)
    return problem, shots, _some(all_shots, slice(count, None))


def _searched(
    problem: Problem, shots: Shots, tell: Callable[[str], None], at: NDArray[np.float64] | None = None, *,
    own: bool = False,
) -> tuple[Found, Certainty, NDArray[np.float64]]:  # fmt: skip
    """End of the search with as many substeps as it takes, its certainty, and what the steps still shift `(p,)`.

    `at`: see `search`; `own`: its steps are those of the motion itself, as `integrator: vehicle` says with substeps.
    """
    plan, shooter = problem.plan, problem.shooter
    found = search(problem, shots, iterations=plan.iterations, tell=tell, at=at)
    while True:
        sure = certainty(problem, found, resamplings=plan.bootstrap)
        if plan.substeps is not None and (own or plan.integrator == "vehicle"):
            return found, sure, np.zeros(len(found.at))
        shift = step_shift(problem, found, problem.family.data["integrator"])
        large = (np.abs(shift) > SHARE * NORMAL_95 * sure.fisher).any()
        if plan.substeps is not None or shooter.substeps >= MOST or not large:
            return found, sure, shift
        shooter.divide(2 * shooter.substeps)
        tell(f"{shooter.substeps} substeps")
        found = search(problem, found.shots, iterations=plan.iterations, tell=tell, at=found.at)


def _narrowed(estimates: tuple[Estimate, ...]) -> None:
    """Refuse a fit that says nothing."""
    if not any(e.identified for e in estimates):
        told = ", ".join(
            f"{e.parameter.name} {100 * e.told:.0f} %{'' if e.felt else ', without influence'}" for e in estimates
        )
        raise InputError(
            "too little excitation: the record narrows no parameter's prior to half of its spread "
            f"({told}); record a motion in which these matter, or give narrower questions"
        )


def _doubted_before(record: Record, model: Model, water: Water) -> tuple[str, ...]:
    found = doubts_before(record, model, water)
    for text in found:
        warnings.warn(text, PelagosWarning, stacklevel=3)
    return found


def _doubted(made: Fit, doubtful: tuple[str, ...], solved: tuple[str, ...]) -> Fit:
    ends = (*solved, *doubts_of_fit(made), *_nothing_unseen(made))
    for text in ends:
        warnings.warn(text, PelagosWarning, stacklevel=3)
    return replace(made, doubts=doubtful + ends)


def _nothing_unseen(made: Fit) -> tuple[str, ...]:
    """Fits without a part for the test."""
    if made.test is not None:
        return ()
    shots = made.train.shots
    one = f"the record makes one shot of {made.plan.segment_s:g} s: give a shorter segment_s"
    all_of_them = f"train {made.plan.train:g} of {shots} shots leaves none: give less, or look at another run"
    cure = one if shots == 1 else all_of_them
    return (f"nothing is left unseen that would say how well the vehicle predicts: {cure}",)


def open_loop(
    vehicle: VehicleConfig | Mapping[str, Any],
    record: Record,
    plan: Plan,
    outside: Mapping[str, float] | None = None,
    *,
    scenario: Scenario | Mapping[str, Any] | str | Path | None = None,
) -> tuple[Score, NDArray[np.float64], Shots]:
    """A vehicle as it is, against a record: every shot from its measured state, with the recorded commands only.

    Args:
        vehicle: such as `Fit.vehicle`.
        record: another run.
        plan: its columns and the length of shots.
        outside: current and offsets by name, as in a plan's paths.
        scenario: see `fit`.
    """
    plan = in_run_steps(plan, record.run, record.step_s)
    data, water = vehicle_with_plan(vehicle, plan), water_of(scenario)
    given = [Parameter(n, (n,), (1.0,), v, 1.0, -np.inf, np.inf, False) for n, v in (outside or {}).items()]
    for parameter in given:
        if parameter.name not in OUTSIDE:
            raise InputError(f"outside: {parameter.name} is none of {', '.join(OUTSIDE)}")
    family = Family(_calm(data, plan), given, water.outside(in_air=data["medium"] == "air"))
    record = in_own_units(record, plan, family.model)
    depth_told(record, family.model)
    shooter = shooter_of(family, record, water)
    shots, _ = cut_shots(record, plan, preroll_of(plan, family.model))
    shooter.divide(finite_substeps(shooter, family, shots, plan.substeps))
    at = np.array([p.prior for p in given])
    seen, _ = shooter.play(shots, family.compiled_values(at), [], tangents=False)
    return score(shooter, family, at, record, shots), seen, shots


def score(shooter: Shooter, family: Family, at: NDArray[np.float64], record: Record, shots: Shots) -> Score:
    """Open loop from measured states."""
    fresh = shots_at(record, shots.starts, shots.steps, shots.preroll, shots.idle)
    seen, _ = shooter.play(fresh, family.compiled_values(at), [], tangents=False)
    names = tuple(n for n in COORDINATES if record.values(n) is not None)
    wanted = target(record, fresh, names)
    off = wanted.differences(seen)
    r2, rms, squares = {}, {}, {}
    for k, name in enumerate(names):
        known = np.isfinite(off[:, k])
        spread = float(((wanted.wanted[:, k] - wanted.wanted[:, k][known].mean())[known] ** 2).sum())
        if spread > known.sum() * STILL**2:
            r2[name] = 1 - float((off[:, k][known] ** 2).sum()) / spread
        rms[name] = float(np.sqrt((off[:, k][known] ** 2).mean()))
        squares[name] = np.where(known, off[:, k] ** 2, 0.0).sum(axis=0)
    return Score(r2, rms, len(shots), len(shots) * shots.steps * record.step_s, squares)


def _some(shots: Shots, which: slice) -> Shots:
    return replace(
        shots, starts=shots.starts[which], preroll=shots.preroll[which], position=shots.position[which],
        attitude=shots.attitude[which], nu=shots.nu[which], idle=shots.idle[which],
    )  # fmt: skip


def _estimate(parameter: Parameter, k: int, found: Found, sure: Certainty, shift: NDArray[np.float64]) -> Estimate:
    at, spread = float(found.at[k]), NORMAL_95 * float(sure.fisher[k])
    value = parameter.value(at)
    fisher = _between(parameter, at - spread, at + spread)
    resampled, wider = None, fisher
    if sure.bootstrap is not None:
        below, above = (float(x) for x in sure.bootstrap[k])
        resampled = _between(parameter, at + below, at + above)
        wider = resampled if above - below > 2 * spread else fisher
    bounded = value in (parameter.low, parameter.high)
    identified = float(sure.told[k]) > UNTOLD and not bounded
    felt = float(sure.influence[k]) > UNFELT
    moved = float(shift[k]) * parameter.slope(at)
    return Estimate(parameter, value, *wider, fisher, resampled, identified, float(sure.told[k]), bounded, moved, felt)


def _between(parameter: Parameter, start: float, end: float) -> tuple[float, float]:
    low, high = sorted((parameter.value(start), parameter.value(end)))
    return low, high
