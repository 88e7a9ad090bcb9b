"""The differences between record and simulation, weighted, and their normal equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.identification.coordinates import ANGLES, COORDINATES, START_SPREAD, normal_size, number
from pelagos.identification.parameters import Family
from pelagos.identification.plan import Plan
from pelagos.identification.record import Record
from pelagos.identification.shots import Shooter, Shots, turned

HUBER: Final = 1.345
"""Residuals beyond so many standard deviations count linearly: 95 % as efficient as squares where the noise is normal
(P. J. Huber, E. M. Ronchetti, "Robust Statistics", 2nd ed., Wiley 2009, Section 4.5)."""
_NAMES: Final = list(COORDINATES)
_LEAST: Final = 2  # steps of a shot
_FELT: Final = 1e-6
"""Change of what is fitted by a unit of an initial state, from which it counts: rounding is far below, noise above."""


@dataclass(frozen=True)
class Target:
    """Measurements that the shots are compared with.

    Attributes:
        names: coordinates that count.
        wanted: `(steps + 1, len(names), s)`; NaN where nothing is known.
    """

    names: tuple[str, ...]
    wanted: NDArray[np.float64]

    def once(self, joined: Sequence[bool]) -> Target:
        """Without the last row of a shot that another goes on from: it is that one's first, and counts once."""
        wanted = self.wanted.copy()
        wanted[-1, :, [k - 1 for k in range(1, len(joined)) if joined[k]]] = np.nan
        return Target(self.names, wanted)

    def differences(self, seen: NDArray[np.float64]) -> NDArray[np.float64]:
        """Simulated less recorded, angles the short way, of coordinates `(steps + 1, 12, s)`."""
        found = seen[:, [number(n) for n in self.names]] - self.wanted
        for k, name in enumerate(self.names):
            if name in ANGLES:
                found[:, k] = (found[:, k] + np.pi) % (2 * np.pi) - np.pi
        return found


@dataclass
class Normal:
    """Normal equations of the parameters (first) and every shot's initial state.

    Attributes:
        matrix: `(m, m)`; gradient: `(m,)`; by_shot: gradient of each shot's own part `(s, m)`; loss: half the sum.
        by_channel: what each fitted coordinate's differences add to the matrix `(c, m, m)`; counts: of them `(c,)`.
        own: what each shot adds to the parameters' part of the matrix `(s, p, p)`.
    """

    matrix: NDArray[np.float64]
    gradient: NDArray[np.float64]
    by_shot: NDArray[np.float64]
    loss: float
    by_channel: NDArray[np.float64]
    counts: NDArray[np.int64]
    own: NDArray[np.float64]


def free_coordinates(names: Sequence[str]) -> list[int]:
    """Coordinates of initial states that are found: poses that are fitted or must meet, velocities of them or that are
    fitted themselves.
    """
    return [k for k in range(12) if _NAMES[k] in names or (k >= 6 and _NAMES[k - 6] in names)]


def hidden_coordinates(record: Record, shooter: Shooter, family: Family, shots: Shots, wanted: Target) -> list[int]:
    """Coordinates of initial states that nothing was measured of, and that something measured depends on.

    Held where they are assumed they would bias the parameters: a hull that begins a shot rolled moves aside as it
    rights itself.
    """
    unknown = [k for k in range(12) if record.values(_NAMES[k]) is None]
    start = np.array([p.coordinate(p.prior) for p in family.parameters])
    _, slopes = shooter.play(shots, family.compiled(start), unknown, tangents=True)
    assert slopes is not None
    chosen = [number(n) for n in wanted.names]
    effect = np.abs(slopes[:, chosen][..., len(start) :]).max(axis=(0, 1, 2), initial=0.0)
    return [k for k, e in zip(unknown, effect, strict=True) if e > _FELT]


def cut_shots(record: Record, plan: Plan, preroll_s: float) -> tuple[Shots, list[bool]]:
    """Shots one after the other through every stretch, and whether each goes on where the one before it ends.

    Args:
        record, plan: what is cut, the length of shots, and from where the first have their actuators.
        preroll_s: see `preroll_of`.

    Raises:
        InputError: no stretch is as long as a shot, or the preroll is longer than the record.
    """
    _preroll_fits(record, plan)
    steps = round(plan.segment_s / record.step_s)
    if steps < _LEAST:
        raise InputError(
            f"plan: segment_s: {plan.segment_s:g} s is less than {_LEAST} steps of {record.step_s:.4g} s; a shot is to "
            "show what commands do"
        )
    before = round(preroll_s / record.step_s)
    first = before if plan.actuators_from == "unknown" else 0
    found: list[int] = []
    joined: list[bool] = []
    for a, b in record.runs:
        for k, at in enumerate(range(max(a, first), b - steps, steps)):
            found.append(at)
            joined.append(k > 0)
    if not found:
        longest = max(b - a for a, b in record.runs) * record.step_s
        waits = f" and the {preroll_s:.3g} s before it in which actuators settle" if first else ""
        cure = "; give actuators_from: rest or commands, or a shorter preroll_s" if first else ""
        raise InputError(
            f"the longest stretch without a hole is {longest:.3g} s, shorter than segment_s {plan.segment_s:g}"
            f"{waits}{cure}"
        )
    starts = np.array(found)
    idle = (starts <= before) & (plan.actuators_from == "rest")
    return shots_at(record, starts, steps, np.minimum(starts, before), idle), joined


def _preroll_fits(record: Record, plan: Plan) -> None:
    """Refuse a preroll that no row of the record has before it."""
    length = max(b for _, b in record.runs) * record.step_s
    if plan.preroll_s is not None and plan.preroll_s > length:
        raise InputError(
            f"plan: preroll_s: {plan.preroll_s:g} s is longer than the record, {length:.4g} s; leave it out, or give "
            "some time constants of the slowest actuator"
        )


def shots_at(
    record: Record, starts: NDArray[np.int64], steps: int, preroll: NDArray[np.int64], idle: NDArray[np.bool_]
) -> Shots:
    """Shots that begin at these rows with what was measured there; see `Shots`."""
    there = {}
    for name in COORDINATES:
        values = record.values(name)
        there[name] = np.full(len(starts), record.assumed.get(name, 0.0)) if values is None else values[starts]
        there[name] = np.nan_to_num(there[name])
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(starts), 1))
    for axis, name in ((2, "heading"), (1, "pitch"), (0, "roll")):
        turn = np.zeros((len(starts), 3))
        turn[:, axis] = there[name]
        attitude = turned(attitude, turn)
    return Shots(
        starts=starts, steps=steps, preroll=preroll, position=np.stack([there[n] for n in COORDINATES[:3]], -1),
        attitude=attitude, nu=np.stack([there[n] for n in COORDINATES[6:]], -1), idle=idle,
    )  # fmt: skip


def target(record: Record, shots: Shots, names: tuple[str, ...]) -> Target:
    """Measurements of the record along the shots.

    Raises:
        InputError: a name was neither measured nor is the slope of something that was.
    """
    rows = shots.starts[None, :] + np.arange(shots.steps + 1)[:, None]
    parts = []
    for name in names:
        values = record.values(name)
        if values is None:
            raise InputError(f"plan: {name} is to be fitted, but it has no column and no pose whose slope it is")
        parts.append(values[rows])
    return Target(names, np.stack(parts, axis=1))


def moved(shots: Shots, free: list[int], by: NDArray[np.floating[Any]]) -> Shots:
    """Shots whose initial states are changed by `(s, f)` in their free coordinates."""
    full = np.zeros((len(shots), 12))
    full[:, free] = by
    return replace(
        shots, position=shots.position + full[:, :3], attitude=turned(shots.attitude, full[:, 3:6]),
        nu=shots.nu + full[:, 6:],
    )  # fmt: skip


class Problem:
    """A fit's loss at parameters and initial states.

    Args:
        family: models by parameters.
        shooter: plays shots.
        shots, wanted: training shots and what they are compared with.
        joined: whether a shot goes on from the one before.
        plan: loss, tolerances of continuity.
        free: see `free_coordinates`; hidden: see `hidden_coordinates`.
    """

    def __init__(
        self, family: Family, shooter: Shooter, wanted: Target, joined: list[bool], plan: Plan, free: list[int],
        hidden: Sequence[int] = (),
    ) -> None:  # fmt: skip
        self.family, self.shooter, self.wanted, self.plan = family, shooter, wanted, plan
        self.free = sorted({*free, *hidden})
        spreads = {**START_SPREAD, **plan.start_spread}
        self.hidden = [(c, plan.start.get(_NAMES[c], 0.0), spreads[_NAMES[c]]) for c in hidden]
        self.joined = [k for k in range(1, len(joined)) if joined[k] and plan.continuity]
        self.meet = [(number(n), s) for n, s in plan.continuity.items()]
        self.sigma = np.ones(len(wanted.names))
        self.huber = HUBER
        self.prior = np.array([p.coordinate(p.prior) for p in family.parameters])
        self.precision = np.array([p.spread**-2 for p in family.parameters])

    def sized(self, differences: NDArray[np.float64]) -> None:
        """Set standard deviations: the plan's, or `normal_size` of the differences."""
        for k, name in enumerate(self.wanted.names):
            given = self.plan.sigma.get(name)
            off = differences[:, k]
            self.sigma[k] = given or max(normal_size(off[np.isfinite(off)]), 1e-6)

    def loss(self, at: NDArray[np.float64], shots: Shots) -> tuple[float, NDArray[np.float64]]:
        """Half the weighted sum, and the differences `(steps + 1, c, s)`."""
        seen, _ = self.shooter.play(shots, self.family.compiled_values(at), self.free, tangents=False)
        off = self.wanted.differences(seen)
        if not np.isfinite(seen).all():
            return np.inf, off
        total = self._rho(off / self.sigma[None, :, None]) + 0.5 * float(
            (self.precision * (at - self.prior) ** 2).sum()
        )
        for c, middle, spread in self.hidden:
            total += 0.5 * float((((seen[0, c] - middle) / spread) ** 2).sum())
        for k in self.joined:
            total += 0.5 * sum(float(x) ** 2 for x in self._mismatch(seen, k))
        return total, off

    def normal(self, at: NDArray[np.float64], shots: Shots) -> Normal:
        """Normal equations of Gauss and Newton, reweighted for Huber's loss."""
        seen, slopes = self.shooter.play(shots, self.family.compiled(at), self.free, tangents=True)
        assert slopes is not None
        p, f, s = len(at), len(self.free), len(shots)
        off = self.wanted.differences(seen) / self.sigma[None, :, None]
        chosen = [number(n) for n in self.wanted.names]
        known = np.isfinite(off)
        size = np.abs(np.where(known, off, 0.0))
        weight = np.where(known, 1.0, 0.0)
        if self.plan.loss == "huber":
            weight *= self.huber / np.maximum(size, self.huber)
        off = np.where(known, off, 0.0)
        m = p + s * f
        by_channel, by_shot = np.zeros((len(chosen), m, m)), np.zeros((s, m))
        matrix, shares = np.zeros((m, m)), np.zeros((s, p, p))
        for k in range(s):
            own = [*range(p), *range(p + k * f, p + (k + 1) * f)]
            for c, place in enumerate(chosen):
                j = slopes[:, place, k] / self.sigma[c]
                w, r = weight[:, c, k], off[:, c, k]
                part = (j * w[:, None]).T @ j
                by_channel[c][np.ix_(own, own)] += part
                shares[k] += part[:p, :p]
                by_shot[k, own] += j.T @ (w * r)
            for c, middle, spread in self.hidden:
                row = slopes[0, c, k] / spread
                matrix[np.ix_(own, own)] += np.outer(row, row)
                by_shot[k, own] += row * (seen[0, c, k] - middle) / spread
        for k in self.joined:
            self._meet(seen, slopes, k, matrix, by_shot)
        matrix += by_channel.sum(axis=0)
        gradient = by_shot.sum(axis=0)
        matrix[range(p), range(p)] += self.precision
        gradient[:p] += self.precision * (at - self.prior)
        return Normal(matrix, gradient, by_shot, self._rho(off), by_channel, known.sum(axis=(0, 2)), shares)

    def _rho(self, off: NDArray[np.float64]) -> float:
        size = np.abs(off[np.isfinite(off)])
        if self.plan.loss == "squares":
            return 0.5 * float((size**2).sum())
        near = np.minimum(size, self.huber)
        return float((near * (size - 0.5 * near)).sum())

    def _mismatch(self, seen: NDArray[np.float64], k: int) -> list[float]:
        found = []
        for c, tolerance in self.meet:
            gap = seen[-1, c, k - 1] - seen[0, c, k]
            if COORDINATES[c] in ANGLES:
                gap = (gap + np.pi) % (2 * np.pi) - np.pi
            found.append(gap / tolerance)
        return found

    def _meet(
        self, seen: NDArray[np.float64], slopes: NDArray[np.float64], k: int, matrix: NDArray[np.float64],
        by_shot: NDArray[np.float64],
    ) -> None:  # fmt: skip
        p, f = slopes.shape[3] - len(self.free), len(self.free)
        for (c, tolerance), gap in zip(self.meet, self._mismatch(seen, k), strict=True):
            row = np.zeros(len(matrix))
            row[:p] = slopes[-1, c, k - 1, :p] - slopes[0, c, k, :p]
            row[p + (k - 1) * f : p + k * f] = slopes[-1, c, k - 1, p:]
            row[p + k * f : p + (k + 1) * f] -= slopes[0, c, k, p:]
            row /= tolerance
            matrix += np.outer(row, row)
            by_shot[k - 1] += row * gap
