"""Certainty of a fit against what straight lines through points give in closed form."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pelagos.errors import InputError
from pelagos.identification import output
from pelagos.identification.certainty import _scores, _spent, certainty
from pelagos.identification.doubts import doubts_of_fit, doubts_of_heel
from pelagos.identification.fit import _estimate, _nothing_unseen
from pelagos.identification.parameters import Parameter
from pelagos.identification.problem import Normal, Target
from pelagos.identification.shots import Shots
from pelagos.identification.steps import finite_substeps
from pelagos.vehicles.vehicle import Vehicle


def regression(initial: int = 0) -> tuple[Normal, np.ndarray, np.ndarray]:
    """Least squares of two parameters, and `initial` numbers of each shot's own, by 5 shots of 7 points."""
    random = np.random.default_rng(4)
    p, s, rows = 2, 5, 7
    m = p + s * initial
    x = np.zeros((s, rows, m))
    x[..., :p] = random.normal(loc=[0.3, -0.8], size=(s, rows, p))
    for k in range(s):
        x[k, :, p + k * initial : p + (k + 1) * initial] = random.normal(size=(rows, initial)) + 1.0
    y = random.normal(size=(s, rows))
    flat, wanted = x.reshape(-1, m), y.ravel()
    best = np.linalg.lstsq(flat, wanted, rcond=None)[0]
    off = x @ best - y
    by_shot = np.einsum("krm,kr->km", x, off)
    own = np.einsum("krp,krq->kpq", x[..., :p], x[..., :p])
    matrix = flat.T @ flat
    normal = Normal(matrix, by_shot.sum(axis=0), by_shot, 0.5 * (off**2).sum(), matrix[None], np.array([s * rows]), own)
    return normal, x, y


def test_scores_are_those_of_fits_without_a_shot():
    """A Newton step by one shot's score is what leaving that shot out changes, exactly where all is linear."""
    for initial in (0, 1):
        normal, x, y = regression(initial)
        scores, whole = _scores(normal, 2)
        best = np.linalg.lstsq(x.reshape(-1, x.shape[2]), y.ravel(), rcond=None)[0][:2]
        for k in range(len(x)):
            rest = [i for i in range(len(x)) if i != k]
            without = np.linalg.lstsq(x[rest].reshape(-1, x.shape[2]), y[rest].ravel(), rcond=None)[0][:2]
            np.testing.assert_allclose(np.linalg.solve(whole, scores[k]), without - best, atol=1e-12)


def test_the_noise_is_estimated_with_the_degrees_of_freedom_left():
    """One channel: the variance is the residuals' over n - m, so that of n points m carry no information."""
    for initial in (0, 1):
        normal, x, _ = regression(initial)
        n, m = x.shape[0] * x.shape[1], x.shape[2]
        np.testing.assert_allclose(normal.matrix - _spent(normal), normal.matrix * (1 - m / n), rtol=1e-9)


def test_a_row_that_two_shots_share_counts_once():
    target = Target(("north",), np.arange(12.0).reshape(4, 1, 3))
    once = target.once([False, True, False]).wanted
    assert np.isnan(once[3, 0, 0])
    assert np.isfinite(once).sum() == 11
    assert np.isfinite(target.wanted).all()


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.85])
def test_residuals_that_remember_themselves_tell_less(rho: float):
    """AR(1) noise is worth (1 + rho)/(1 - rho) times fewer points; the prior's part of the information stays."""
    random, precision = np.random.default_rng(8), np.array([3.0, 0.5])
    normal, _, _ = regression()
    normal = replace(normal, matrix=normal.matrix + np.diag(precision), by_channel=0 * normal.by_channel)
    noise = np.zeros((40_000, 1, 1))
    for k in range(1, len(noise)):
        noise[k] = rho * noise[k - 1] + random.normal()
    found = SimpleNamespace(at=np.zeros(2), normal=normal, differences=noise)
    names = [SimpleNamespace(name="a"), SimpleNamespace(name="b")]
    problem = SimpleNamespace(precision=precision, family=SimpleNamespace(parameters=names))
    sure = certainty(problem, found, resamplings=0)
    longer = (1 + rho) / (1 - rho)
    assert sure.memory == pytest.approx(longer, rel=0.15)
    data = regression()[0].matrix
    expected = np.sqrt(np.diag(np.linalg.inv(data / sure.memory + np.diag(precision))))
    np.testing.assert_allclose(sure.fisher, expected, rtol=1e-9)
    np.testing.assert_allclose(sure.told, 1 - expected * np.sqrt(precision), rtol=1e-9)
    own = np.diag(normal.own.sum(axis=0))
    np.testing.assert_allclose(sure.influence, np.sqrt(own / precision), rtol=1e-12)


@pytest.mark.parametrize(("prior", "logarithmic"), [(3.0, False), (-2.0, True)])
@pytest.mark.parametrize(("resampled", "wider"), [((-0.3, 0.2), False), ((-0.1, 0.45), True), ((-0.55, -0.02), True)])
def test_an_interval_is_the_wider_one(prior: float, logarithmic: bool, resampled: tuple[float, float], wider: bool):
    """Fisher's is +-1.96 standard deviations wide, 0.51 here in the coordinate of the search: x, or ln |x|."""
    parameter = Parameter("k", ("mass.k",), (1.0,), prior, 1.0, -np.inf, np.inf, logarithmic)
    sure = SimpleNamespace(
        fisher=np.array([9.0, 0.13]), bootstrap=np.array([[-7.0, 7.0], resampled]), told=np.array([0.1, 0.7]),
        influence=np.array([0.0, 3.0]),
    )  # fmt: skip
    found, shift = SimpleNamespace(at=np.array([-4.0, 0.8])), np.array([5.0, -0.04])
    made = _estimate(parameter, 1, found, sure, shift)
    value = lambda x: -np.exp(x) if logarithmic else x
    of = lambda below, above: pytest.approx(sorted([value(0.8 + below), value(0.8 + above)]), rel=1e-5)
    assert made.value == pytest.approx(value(0.8))
    assert list(made.fisher) == of(-0.13 * 1.959964, 0.13 * 1.959964)
    assert list(made.resampled or ()) == of(*resampled)
    assert [made.low, made.high] == list(made.resampled if wider and made.resampled else made.fisher)
    assert made.step_shift == pytest.approx(-0.04 * (value(0.8) if logarithmic else 1.0))
    assert (made.identified, made.felt) == (True, True)


@pytest.mark.parametrize(("train", "shots", "said"), [(0.7, 1, "one shot of 15 s: give a shorter segment_s"),
                                                      (1.0, 4, "train 1 of 4 shots leaves none")])  # fmt: skip
def test_a_fit_that_leaves_nothing_unseen_says_so(train: float, shots: int, said: str):
    made = SimpleNamespace(
        test=None, train=SimpleNamespace(shots=shots), plan=SimpleNamespace(train=train, segment_s=15)
    )
    (text,) = _nothing_unseen(made)
    assert said in text
    assert _nothing_unseen(SimpleNamespace(test=object())) == ()


def test_steps_are_not_shorter_than_a_millisecond():
    shooter = SimpleNamespace(grid_s=0.1)
    assert finite_substeps(shooter, None, None, 100) == 100
    with pytest.raises(InputError, match=r"substeps: 1000 in 0\.1 s are steps of 0\.1 ms, .* give at most 100"):
        finite_substeps(shooter, None, None, 1000)


def test_steps_that_shift_a_parameter_either_way_are_told():
    """From a quarter of half of its own interval by Fisher's information on, here 0.1 and 0.01 [unit of each]."""
    shifts = {"a": (0.11, 0.8), "b": (0.09, 0.8), "c": (-0.011, 0.08), "d": (-0.009, 0.08)}
    estimates = tuple(
        SimpleNamespace(parameter=SimpleNamespace(name=name), felt=True, step_shift=shift, fisher=(-2.0, -2.0 + width))
        for name, (shift, width) in shifts.items()
    )
    made = SimpleNamespace(
        estimates=estimates,
        found=SimpleNamespace(settled=True),
        record=SimpleNamespace(step_s=0.1),
        plan=SimpleNamespace(sigma={}, fit_to=("u",), actuators_from="unknown"),
        substeps=4,
        test=None,
    )
    assert doubts_of_fit(made) == (
        "the steps of 25 ms shift a by +0.11, c by -0.011: give more substeps, or a shorter step_s",
    )


@pytest.mark.parametrize(("times", "said"), [(0.2, "too wide"), (0.4, ""), (1.0, ""), (2.5, ""), (5.0, "too narrow")])
def test_a_sigma_that_the_residuals_contradict_is_told(times: float, said: str):
    """Normal residuals of `times` the given one of the heading; those of north have their own, as nobody said it."""
    off = np.random.default_rng(5).normal(size=(200, 2, 30)) * [[7.0], [times * 0.02]]
    off[3:9, 1] = np.nan
    off[20, 1] = 60.0  # faults are none of it
    made = SimpleNamespace(
        estimates=(), found=SimpleNamespace(settled=True, differences=off), test=None,
        plan=SimpleNamespace(sigma={"heading": 0.02}, fitted=("north", "heading"), actuators_from="unknown"),
    )  # fmt: skip
    found = doubts_of_fit(made)
    assert len(found) == bool(said)
    if said:
        assert said in found[0]
        size = float(found[0].split(" leaves has ")[1].split(" rad")[0])
        assert found[0].startswith("sigma of heading is 0.02 rad, but what the fit leaves has ")
        assert size == pytest.approx(times * 0.02, rel=0.05)


@pytest.mark.parametrize(
    ("after", "told"),
    [
        ([2.6, 2.5, 4.4], False),  # larger by 0.17 +- 0.33 in the mean: one more shot might turn it
        ([2.4, 3.5, 4.6], True),  # by 0.5 +- 0.06, of which Student's law for 2 takes 2.92 times
        ([2.1, 3.2, 4.7], False),  # by 0.33 +- 0.19
        ([2.0, 3.0, 9.0], True),  # by more than half
    ],
)
def test_a_fit_is_worse_than_its_priors_by_more_than_the_scatter_of_shots(after: list[float], told: bool):
    before = SimpleNamespace(r2={"q": 0.5}, squares={"q": np.array([2.0, 3.0, 4.0])})
    made = SimpleNamespace(
        estimates=(), found=SimpleNamespace(settled=True), before=before,
        plan=SimpleNamespace(sigma={}, actuators_from="unknown"),
        test=SimpleNamespace(r2={"q": 0.49}, squares={"q": np.array(after)}),
    )  # fmt: skip
    assert doubts_of_fit(made) == ("unseen part: R2 is worse than before the fit: q 0.490 (priors 0.500)",) * told


def test_of_one_shot_any_growth_is_worse():
    before = SimpleNamespace(r2={"q": 0.5}, squares={"q": np.array([2.0])})
    test = SimpleNamespace(r2={"q": 0.49}, squares={"q": np.array([2.1])})
    made = SimpleNamespace(
        estimates=(), found=SimpleNamespace(settled=True), before=before, test=test,
        plan=SimpleNamespace(sigma={}, actuators_from="unknown"),
    )  # fmt: skip
    assert len(doubts_of_fit(made)) == 1


@pytest.mark.parametrize(("noise", "told"), [(2e-9, False), (2e-3, True)])
def test_rounding_of_a_first_shot_is_no_contradiction(noise: float, told: bool):
    """Twelve times as large as in the others: of runs without noise it is 1e-8 of the motion."""
    off = noise * np.random.default_rng(8).normal(size=(100, 1, 5)) * [12.0, 1.0, 1.0, 1.0, 1.0]
    motion = SimpleNamespace(values=lambda name: np.sin(np.arange(500.0)))
    shots = SimpleNamespace(starts=100 * np.arange(5), preroll=np.full(5, 30))
    made = SimpleNamespace(
        estimates=(), found=SimpleNamespace(settled=True, differences=off, shots=shots), test=None, record=motion,
        plan=SimpleNamespace(sigma={}, fitted=("roll",), actuators_from="rest"),
    )  # fmt: skip
    assert any("missed by 12 times the others" in text for text in doubts_of_fit(made)) == told


@pytest.mark.parametrize(("name", "told"), [("otter", True), ("remus100", False)])
def test_a_boat_that_would_capsize_rolls_in_degrees(name: str, told: bool):
    """What dives may loop; rows that are not used say nothing, and half a radian is a roll."""
    model = Vehicle.from_catalogue(name).model
    roll, pitch = np.array([9.0, 0.1, -2.5, 0.3]), np.array([-9.0, 0.58, -0.59, 0.2])
    record = SimpleNamespace(measured={"roll": roll, "pitch": pitch, "u": 9 * roll}, runs=((1, 2), (2, 4)))
    found = doubts_of_heel(record, model)
    assert [text[:28] for text in found] == (["roll goes to 2.5 rad, 143 de"] if told else [])


def test_a_picture_of_the_unseen_part_has_no_fitted_shots(monkeypatch: pytest.MonkeyPatch):
    """The last two of five shots of 10 s, at rows 0, 10, ...; a parameter over its prior, the tick at 1."""
    drawn = []
    monkeypatch.setattr(output.theme, "as_png", lambda figure: drawn.append(figure) or b"")
    shots = Shots(10 * np.arange(5), 10, *(np.zeros(5) for _ in range(5)))
    k_m = SimpleNamespace(parameter=SimpleNamespace(name="K_M", prior=-100.0), value=-80.0, low=-85.0, high=-70.0)
    made = SimpleNamespace(
        simulated=(np.zeros((11, 12, 5)), shots), test=SimpleNamespace(shots=2), plan=SimpleNamespace(fitted=("u",)),
        record=SimpleNamespace(step_s=0.5, start_s=3.0, values=lambda name: np.zeros(51) if name == "u" else None),
        estimates=(SimpleNamespace(**vars(k_m), identified=True),),
    )  # fmt: skip
    output.draw(made)
    speeds, parameters = drawn[0].axes
    times = np.concatenate([line.get_xdata() for line in speeds.lines if len(line.get_xdata()) > 2])
    assert [times.min(), times.max()] == [3.0 + 15.0, 3.0 + 25.0]
    assert [np.ravel(line.get_xdata()).tolist() for line in parameters.lines] == [[0.85, 0.7], [0.8], [1.0]]
