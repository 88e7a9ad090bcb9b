"""Loss of a fit and its normal equations against sums that are written out, of a motion that no vehicle has."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.identification.certainty import NORMAL_95, _resampled
from pelagos.identification.coordinates import COORDINATES
from pelagos.identification.fit import score
from pelagos.identification.parameters import Parameter
from pelagos.identification.problem import (
    Problem,
    Target,
    free_coordinates,
    hidden_coordinates,
    moved,
    shots_at,
)
from pelagos.identification.shots import Shots, turned

STEPS, SHOTS = 4, 4
JOINED = [False, True, False, True]
AT = np.array([0.55, -0.35])
WIDTH = 0.8  # of Huber's loss, so that many differences are beyond it
SIGMA = np.array([0.4, 0.25, 0.6])
MEET = {"north": 0.3, "heading": 0.2}
HIDDEN = {4: (0.1, 0.1), 8: (0.0, 0.7)}  # pitch as its start says and as wide as usual, w as usual and as wide as told
TURN = 2 * np.pi


class Motion:
    """Plays shots: every coordinate depends on both parameters and on all that the shot began with."""

    def play(self, shots: Shots, at: np.ndarray, free: list[int], *, tangents: bool) -> tuple[np.ndarray, Any]:
        if not tangents:
            return self.seen(shots, at), None
        small, count = 1e-6, len(at)
        steps: list[Any] = []
        for j in range(count):
            steps.append(lambda s, j=j: (shots, at + s * small * np.eye(count)[j]))
        for j in range(len(free)):
            by = np.zeros((len(shots), len(free)))
            by[:, j] = small
            steps.append(lambda s, by=by: (moved(shots, free, s * by), at))
        return self.seen(shots, at), np.stack(
            [(self.seen(*step(1.0)) - self.seen(*step(-1.0))) / (2 * small) for step in steps], axis=-1
        )

    @staticmethod
    def seen(shots: Shots, at: np.ndarray) -> np.ndarray:
        begin = np.concatenate([shots.position, 2 * shots.attitude[:, 1:], shots.nu], axis=1).T  # (12, s)
        t, c = 0.3 * np.arange(STEPS + 1)[:, None, None], np.arange(12.0)[:, None]
        found = begin + t * (np.sin(at[0] + 0.4 * c + 0.7 * begin) + at[1] * begin[::-1]) + at[0] * at[1] * t**2
        found[:, 5] += TURN * np.arange(begin.shape[1])  # as a heading that counts on
        return found


def shots() -> Shots:
    random = np.random.default_rng(3)
    attitude = Rotation.from_rotvec(0.3 * random.normal(size=(SHOTS, 3))).as_quat(scalar_first=True)
    zero = np.zeros(SHOTS, dtype=np.int64)
    return Shots(
        STEPS * np.arange(SHOTS), STEPS, zero, random.normal(size=(SHOTS, 3)), attitude,
        0.5 * random.normal(size=(SHOTS, 6)), zero > 0,
    )  # fmt: skip


def problem(loss: str = "huber") -> tuple[Problem, Motion]:
    random, motion = np.random.default_rng(5), Motion()
    parameters = [
        Parameter(n, (n,), (1.0,), v, spread, -np.inf, np.inf, False)
        for n, v, spread in (("a", 0.4, 0.5), ("b", -0.6, 0.3))
    ]
    family: Any = SimpleNamespace(parameters=parameters, compiled=lambda at: at, compiled_values=lambda at: at)
    seen = Motion.seen(shots(), AT)[:, [0, 5, 6]]
    wanted = seen + random.normal(size=seen.shape) * SIGMA[:, None]
    wanted[:, 1] += TURN * random.integers(-2, 3, size=wanted[:, 1].shape)
    wanted[1, 0, 2] = wanted[3, 2, 1] = np.nan
    plan: Any = SimpleNamespace(
        loss=loss, continuity=MEET, start={"pitch": 0.1}, start_spread={"w": 0.7}, sigma={"u": 0.6}
    )
    made = Problem(family, motion, Target(("north", "heading", "u"), wanted), JOINED, plan, [0, 5, 6, 11], list(HIDDEN))  # type: ignore[arg-type]
    made.sigma, made.huber = SIGMA.copy(), WIDTH
    return made, motion


def short(angle: float) -> float:
    return float(np.arctan2(np.sin(angle), np.cos(angle)))


def rows(made: Problem, seen: np.ndarray) -> list[tuple[float, bool, int, tuple[Any, ...]]]:
    """Each term of the loss: residual in standard deviations, whether Huber's, its channel, what of `seen` it has."""
    found: list[tuple[float, bool, int, tuple[Any, ...]]] = []
    for c, (place, size) in enumerate(zip((0, 5, 6), SIGMA, strict=True)):
        for t in range(STEPS + 1):
            for k in range(SHOTS):
                off = seen[t, place, k] - made.wanted.wanted[t, c, k]
                if np.isfinite(off):
                    off = short(off) if place == 5 else off
                    found.append((off / size, True, c, ((1 / size, t, place, k),)))
    for place, (middle, spread) in HIDDEN.items():
        for k in range(SHOTS):
            found.append(((seen[0, place, k] - middle) / spread, False, -1, ((1 / spread, 0, place, k),)))
    for k in (1, 3):
        for place, size in ((0, MEET["north"]), (5, MEET["heading"])):
            gap = seen[-1, place, k - 1] - seen[0, place, k]
            gap = short(gap) if place == 5 else gap
            found.append((gap / size, False, -1, ((1 / size, -1, place, k - 1), (-1 / size, 0, place, k))))
    return found


@pytest.mark.parametrize("loss", ["huber", "squares"])
def test_a_loss_is_the_sum_of_its_terms(loss: str) -> None:
    made, motion = problem(loss)
    expected = 0.5 * (((AT[0] - 0.4) / 0.5) ** 2 + ((AT[1] + 0.6) / 0.3) ** 2)
    many = 0
    for off, robust, _, _ in rows(made, motion.seen(shots(), AT)):
        far = robust and loss == "huber" and abs(off) > WIDTH
        expected += WIDTH * (abs(off) - 0.5 * WIDTH) if far else 0.5 * off**2
        many += far
    assert many > 5 or loss == "squares"
    value, differences = made.loss(AT, shots())
    assert value == pytest.approx(expected, rel=1e-12)
    assert np.nanmax(np.abs(differences[:, 1])) <= np.pi


@pytest.mark.parametrize("loss", ["huber", "squares"])
def test_a_gradient_is_the_slope_of_the_loss(loss: str) -> None:
    """By parameters and by what each shot begins with, of which it has its own."""
    made, _ = problem(loss)
    normal, free, small = made.normal(AT, shots()), len(made.free), 1e-5
    assert made.free == [0, 4, 5, 6, 8, 11]
    slopes = []
    for j in range(2):
        step = small * np.eye(2)[j]
        slopes.append((made.loss(AT + step, shots())[0] - made.loss(AT - step, shots())[0]) / (2 * small))
    for j in range(SHOTS * free):
        by = np.zeros(SHOTS * free)
        by[j] = small
        above, below = (made.loss(AT, moved(shots(), made.free, s * by.reshape(SHOTS, free)))[0] for s in (1, -1))
        slopes.append((above - below) / (2 * small))
    assert normal.gradient == pytest.approx(np.array(slopes), rel=1e-6, abs=1e-6)
    by_prior = np.zeros(2 + SHOTS * free)
    by_prior[:2] = made.precision * (AT - [0.4, -0.6])
    assert normal.by_shot.sum(axis=0) + by_prior == pytest.approx(normal.gradient, abs=1e-12)


def test_normal_equations_are_those_of_their_rows() -> None:
    """Gauss and Newton's sum of w j j^T, w = Huber's width over a larger residual, with what channels and shots add."""
    made, motion = problem()
    normal, p, f = made.normal(AT, shots()), 2, len(made.free)
    seen, slopes = motion.play(shots(), AT, made.free, tangents=True)
    size = p + SHOTS * f
    matrix = np.diag([0.5**-2, 0.3**-2, *[0.0] * (SHOTS * f)])
    channels, own, counts = np.zeros((3, size, size)), np.zeros((SHOTS, p, p)), np.zeros(3)
    for off, robust, channel, parts in rows(made, seen):
        row = np.zeros(size)
        for factor, t, place, k in parts:
            row[:p] += factor * slopes[t, place, k, :p]
            row[p + k * f : p + (k + 1) * f] += factor * slopes[t, place, k, p:]
        weight = min(1.0, WIDTH / abs(off)) if robust else 1.0
        matrix += weight * np.outer(row, row)
        if robust:
            channels[channel] += weight * np.outer(row, row)
            counts[channel] += 1
            own[parts[0][3]] += weight * np.outer(row[:p], row[:p])
    assert normal.matrix == pytest.approx(matrix, rel=1e-9, abs=1e-9)
    assert normal.by_channel == pytest.approx(channels, rel=1e-9, abs=1e-9)
    assert normal.own == pytest.approx(own, rel=1e-9)
    assert normal.counts == pytest.approx(counts)
    assert normal.loss == pytest.approx(made._rho(made.loss(AT, shots())[1] / SIGMA[:, None]))


def test_sizes_are_given_or_those_of_most_differences() -> None:
    """1.4826 of the median size, which few outliers do not change; at least a millionth."""
    made, _ = problem()
    off = np.random.default_rng(1).normal(size=(STEPS + 1, 3, 4000)) * np.array([0.3, 0.05, 9.0])[:, None]
    off[0, 0] *= 1e3 * (np.arange(4000) % 50 == 0) + (np.arange(4000) % 50 != 0)
    off[2, 1] = np.nan
    made.sized(off)
    assert made.sigma == pytest.approx([0.3, 0.05, 0.6], rel=0.03)
    made.sized(0 * off)
    assert made.sigma == pytest.approx([1e-6, 1e-6, 0.6])


def test_what_a_shot_begins_with_is_free_where_something_tells_of_it() -> None:
    """A pose that is fitted and its own rate, a velocity that is fitted alone; others where what is fitted changes."""
    assert free_coordinates(("north", "r")) == [0, 6, 11]
    assert free_coordinates(("heading",)) == [5, 11]
    assert free_coordinates(("w",)) == [8]
    asked: list[list[int]] = []

    def play(shots: Any, compiled: Any, free: list[int], *, tangents: bool) -> tuple[Any, np.ndarray]:
        asked.append(free)
        slopes = np.zeros((3, 12, 2, 1 + len(free)))
        slopes[..., 0] = 5.0  # of the parameter
        slopes[1, 6, 1, 1 + free.index(8)] = -2e-6  # u by w
        slopes[1, 6, 0, 1 + free.index(4)] = 0.5e-6  # rounding
        slopes[1, 7, 1, 1 + free.index(3)] = 1.0  # of v, which is not fitted
        return None, slopes

    record: Any = SimpleNamespace(values=lambda name: None if name in ("roll", "pitch", "w", "q") else np.zeros(9))
    family: Any = SimpleNamespace(parameters=[SimpleNamespace(coordinate=float, prior=2.0)], compiled=lambda at: at)
    wanted: Any = SimpleNamespace(names=("north", "u"))
    assert hidden_coordinates(record, SimpleNamespace(play=play), family, shots(), wanted) == [8]  # type: ignore[arg-type]
    assert asked == [[3, 4, 8, 10]]


def test_shots_begin_as_the_record_says() -> None:
    """Euler angles zyx as SciPy turns them; what has no column as assumed, and 0 without a word."""
    random = np.random.default_rng(6)
    values = {name: random.normal(size=30) for name in COORDINATES if name not in ("depth", "w")}
    record: Any = SimpleNamespace(values=values.get, assumed={"depth": 7.0})
    starts = np.array([3, 17, 11])
    found = shots_at(record, starts, STEPS, starts, starts > 5)
    np.testing.assert_array_equal(
        found.position, np.stack([values["north"][starts], values["east"][starts], [7.0] * 3], -1)
    )
    np.testing.assert_array_equal(found.nu[:, [0, 1, 3, 4, 5]], np.stack([values[n][starts] for n in "uvpqr"], -1))
    np.testing.assert_array_equal(found.nu[:, 2], 0.0)
    euler = np.stack([values[n][starts] for n in ("heading", "pitch", "roll")], -1)
    expected = Rotation.from_euler("ZYX", euler)
    assert (expected.inv() * Rotation.from_quat(found.attitude, scalar_first=True)).magnitude() == pytest.approx(
        0, abs=1e-7
    )
    by = random.normal(size=(3, 3))
    after = Rotation.from_quat(turned(found.attitude, by), scalar_first=True)
    assert ((expected * Rotation.from_rotvec(by)).inv() * after).magnitude() == pytest.approx(0, abs=1e-7)


def test_a_score_is_of_open_loop_from_what_was_measured() -> None:
    """R2 = 1 - sum of squares of differences / about the record's own mean; rms of the same rows."""
    random = np.random.default_rng(9)
    values = {name: random.normal(size=40) for name in ("north", "heading", "u")}
    values["heading"] += TURN * np.arange(40)
    values["u"][[6, 21]] = np.nan
    values["depth"] = np.full(40, 3.0)
    record: Any = SimpleNamespace(values=values.get, assumed={}, step_s=0.25)
    none = np.zeros(2, np.int64)
    given = Shots(np.array([2, 20]), STEPS, none, np.full((2, 3), 99.0), np.ones((2, 4)), np.ones((2, 6)),
                  np.zeros(2, bool))  # fmt: skip
    family: Any = SimpleNamespace(compiled_values=lambda at: at)
    made = score(Motion(), family, AT, record, given)  # type: ignore[arg-type]
    seen = Motion.seen(shots_at(record, given.starts, STEPS, given.preroll, given.idle), AT)
    rows_of = given.starts + np.arange(STEPS + 1)[:, None]
    for name, place in (("north", 0), ("heading", 5), ("u", 6)):
        wanted = values[name][rows_of]
        off = seen[:, place] - wanted
        off = np.arctan2(np.sin(off), np.cos(off)) if name == "heading" else off
        known = np.isfinite(off)
        about = wanted[known] - wanted[known].mean()
        assert made.rms[name] == pytest.approx(np.sqrt((off[known] ** 2).mean()), rel=1e-9)
        assert made.r2[name] == pytest.approx(1 - (off[known] ** 2).sum() / (about**2).sum(), rel=1e-9)
    assert set(made.r2) == {"north", "heading", "u"}
    assert set(made.rms) == {"north", "heading", "u", "depth"}
    assert (made.shots, made.seconds) == (2, 2.0)


def test_resampled_shots_scatter_as_their_scores_do() -> None:
    """A step -H^-1 sum (w - 1) s: s of n shots has the variance sum (s - mean)^2, widened as Student's law for n - 1.

    Of 12 shots 2.201/1.96 wider; 20 000 resamplings know percentiles to 1.5 %, and 12 scores are nearly normal.
    """
    random = np.random.default_rng(2)
    scores = random.normal(size=(12, 2)) * [3.0, 0.5]
    hessian = np.array([[4.0, 0.3], [0.3, 0.2]])
    found = _resampled(hessian, scores, 20_000, 0)
    assert found is not None
    steps = np.linalg.solve(hessian, (scores - scores.mean(axis=0)).T)
    spread = np.sqrt((steps**2).sum(axis=1) * 12 / 11)
    assert found[:, 1] - found[:, 0] == pytest.approx(2 * 2.201 * spread, rel=0.05)
    assert (found[:, 0] < 0).all()
    one = _resampled(hessian, np.array([[9.0, 0.0]] + 11 * [[-9 / 11, 0.0]]), 20_000, 0)
    assert one is not None
    assert -one[0, 0] > 1.2 * one[0, 1]  # against the score of the one that may come many times
    assert pytest.approx(1.95996, abs=1e-5) == NORMAL_95
    assert _resampled(hessian, scores[:4], 1000, 0) is None
    assert _resampled(hessian, scores[:5], 1000, 0) is not None
    assert _resampled(hessian, scores, 0, 0) is None
