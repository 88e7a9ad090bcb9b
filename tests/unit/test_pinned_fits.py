"""Fits and filters: Allan terms, beams of a log, residuals, shots, navigation; each against a formula of its own."""

from __future__ import annotations

import math
import warnings
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.errors import InputError, PelagosWarning
from pelagos.identification import beam_faults, noise
from pelagos.identification.allan_terms import _weighed, terms_of
from pelagos.identification.certainty import _memory
from pelagos.identification.clock import clock_of
from pelagos.identification.command_units import _SCALES, _units_like
from pelagos.identification.doubts import _surely_larger
from pelagos.identification.plan import UNIT_SCALES, UNITS_OF, ColumnConfig
from pelagos.identification.plausibility import _descent
from pelagos.identification.problem import Problem
from pelagos.identification.shots import Shots, _directions
from pelagos.navigation.error_state import Lanes
from pelagos.sensors.sensor import Measurement
from pelagos.sim.sampled import Sampled


def test_an_allan_curve_is_weighed_by_its_clusters():
    """A variance of k clusters is known to 1/sqrt(k) of itself: a constant is the mean weighed by clusters."""
    terms, clusters = np.ones((4, 1)), np.array([900.0, 90.0, 30.0, 9.0])
    deviation = np.array([1.0, 1.3, 0.8, 1.7])
    assert _weighed(terms, deviation, clusters) == pytest.approx((clusters @ deviation**2) / clusters.sum())


def test_terms_of_an_allan_curve_are_seen_from_a_quarter_of_the_variance():
    """And from twice what its clusters tell, sqrt(2/(k - 1)) (IEEE Std 952-1997, equation C.20)."""
    tau = np.geomspace(0.01, 100, 25)
    columns = np.stack([1 / tau, np.full(25, 0.44), tau / 3], axis=-1)
    many = np.geomspace(1e5, 10, 25)
    squares, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 1e-6]), many)
    assert seen.tolist() == [True, False, False]
    assert squares == pytest.approx([4.0, 0.0, 0.0], rel=1e-3)
    squares, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 0.09]), many)
    assert seen.tolist() == [True, False, True]
    assert squares == pytest.approx([4.0, 0.0, 0.09], rel=1e-9, abs=1e-9)
    for size, share in ((3e-4, 0.2), (5e-4, 0.29)):  # of the variance at 100 s, where 1e5 clusters know it
        assert 100 / 3 * size / (4 / 100 + 100 / 3 * size) == pytest.approx(share, abs=0.01)
        _, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, size]), np.full(25, 1e5))
        assert seen[2] == (share > 0.25)
    # visible to a quarter, but not beyond what nine clusters tell: 2 sqrt(2/8) = 1
    _, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 0.09]), np.full(25, 9.0))
    assert not seen[2]


def test_squares_are_weighed_by_their_own_expectation():
    """The square of normal noise scatters with sqrt(2) of its expectation: the mean of n squares with sqrt(2/n)."""
    off = np.array([0.2, 1.7, 0.4, 3.1, 0.9])
    squares, unsure = noise._reweighted(np.full((5, 1), 4.0), off)
    assert squares == pytest.approx(off.mean() / 4)
    assert unsure == pytest.approx(off.mean() / 4 * math.sqrt(2 / 5))
    speed = np.linspace(0, 3, 40) ** 2
    basis = np.stack([np.full(40, 4.0), speed], axis=-1)
    squares, unsure = noise._reweighted(basis, basis @ [0.3, 0.02])
    assert squares == pytest.approx([0.3, 0.02])
    whitened = basis / (basis @ [0.3, 0.02])[:, None]
    assert unsure == pytest.approx(np.sqrt(2 * np.diag(np.linalg.inv(whitened.T @ whitened))))


def test_the_most_of_a_term_is_bounded_by_every_point_of_the_curve():
    """nu s^2 / chi^2(nu), below which chi^2 lies with 1 %: of 4 and 1 degrees of freedom 0.29711 and 0.00015709."""
    terms = np.array([[2.0, 1.0, 0.5], [1.0, 1.0, 2.0]])
    freedoms, deviation = np.array([4.0, 1.0]), np.array([0.8, 0.5])
    highest = deviation**2 * freedoms / [0.2971095, 0.000157088]
    expected = [math.sqrt(min(highest[0] / terms[0, k], highest[1] / terms[1, k])) for k in range(3)]
    assert noise._most(terms, deviation, freedoms) == pytest.approx(expected, rel=1e-4)


def janus():
    """Four beams at 30 degrees of a log that moves slowly in every way, for a minute."""
    t = np.linspace(0, 60, 1500)
    u, v, w = 1.1 * np.sin(0.31 * t), 0.9 * np.cos(0.43 * t), 0.7 * np.sin(0.57 * t + 1)
    s, c = 0.5, math.sqrt(0.75)
    return np.stack([u * s + w * c, v * s + w * c, -u * s + w * c, -v * s + w * c], -1)


@pytest.mark.parametrize("beam", range(4))
@pytest.mark.parametrize("factor", [-1.0, -0.4, 0.1, 0.7, 0.93, 1.04, 1.12, 1.32])
def test_the_factor_of_a_beam_is_what_it_reads_over_what_the_others_say(beam, factor):
    """Of opposite beams, b1 + b3 = b2 + b4 = 2 w cos(30 degrees): three say what the fourth should read."""
    beams = janus()
    beams[:, beam] *= factor
    opposite, others = (beam + 2) % 4, [(beam + 1) % 4, (beam + 3) % 4]
    due = beams[:, others].sum(axis=1) - beams[:, opposite]
    assert np.allclose(beams[:, beam], factor * due)
    left, said = beams[:, 0] - beams[:, 1] + beams[:, 2] - beams[:, 3], rf"beam {beam + 1} reads {factor:.3g} times"
    if abs(factor - 1) < 0.2:
        with pytest.warns(PelagosWarning, match=said):
            assert beam_faults.refuse_contradicted(beams, left)
    else:
        with pytest.raises(InputError, match=said):
            beam_faults.refuse_contradicted(beams, left)


def test_beams_that_agree_are_not_contradicted():
    """Noise alone is left of them; and of an offset at rest, which goes with no velocity."""
    random = np.random.default_rng(3)
    moving, still = janus() + 0.01 * random.normal(size=(1500, 4)), 0.01 * random.normal(size=(1500, 4))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for beams in (moving, still + np.array([0.06, 0.0, 0.0, 0.0])):
            assert not beam_faults.refuse_contradicted(beams, beams @ [1.0, -1.0, 1.0, -1.0])


@pytest.mark.parametrize("slope", [0.3, -0.002])
def test_the_drift_of_a_record_is_the_slope_of_its_means(slope):
    """A sample; its share is that of a straight line in the variance of 64 means, the square of their correlation."""
    values = slope * np.arange(1000.0) - 7.0
    assert noise._drift(values) == pytest.approx((slope, 1.0))
    bent = values[:960] + 40 * slope * np.sin(0.02 * np.arange(960))
    means = bent.reshape(64, 15).mean(axis=1)
    like = np.corrcoef(means, np.arange(64))[0, 1]
    assert noise._drift(bent) == pytest.approx((np.polyfit(np.arange(64), means, 1)[0] / 15, like**2))
    assert 0.5 < like**2 < 0.999
    assert noise._drift(np.full(640, 0.7)) == (0.0, 0.0)


def test_the_step_of_an_output_is_that_of_which_all_levels_are_multiples():
    """Where a level has four readings or more, and to 2 % of each difference; otherwise the record shows none."""
    random = np.random.default_rng(1)
    levels = np.round(random.normal(scale=3.0, size=4000))
    assert noise._step_of(0.05 * levels - 0.013) == pytest.approx(0.05)
    assert noise._step_of(0.061 * np.delete(levels, np.abs(levels - 1) < 0.5)) == pytest.approx(0.061)
    assert noise._step_of(random.normal(size=400)) == 0.0
    assert noise._step_of(np.repeat([0.0, 1.0, -1.5, 3.0], 60)) == 0.0
    for far in (60.0, -60.0):  # which does not make the others multiples of 1
        assert noise._step_of(np.repeat([0.0, 1.0, 2.5, far], 60)) == 0.0
    assert noise._step_of(np.repeat([0.0, 1.0, 3.03], 60)) == 1.0
    assert noise._step_of(np.repeat([0.0, 1.0, 3.05], 60)) == 0.0
    assert noise._step_of(np.repeat([0.0, 1.0, 2.0], [1, 5, 5])) == 0.0  # three levels in eleven readings
    assert noise._step_of(np.repeat([0.0, 1.0, 2.0], [2, 5, 5])) == 1.0


def test_the_step_of_a_beam_is_that_of_which_all_readings_are_multiples():
    """Of the readings themselves, not of their differences: a log at rest then reads exactly 0."""
    readings = 0.02 * np.array([-7.0, -5.0, -4.0, 0.0, 3.0, 40.0])
    assert beam_faults._step_of(readings) == pytest.approx(0.02)
    assert beam_faults._step_of(readings + 0.004) == 0.0
    assert beam_faults._step_of(0.02 * np.array([-1.0, 0.0, 1.0, 2.1])) == 0.0
    assert beam_faults._step_of(np.array([0.3])) == 0.0


def test_units_of_fits_are_their_definitions():
    """A nautical mile is 1852 m, a foot 0.3048 m, a turn 2 pi rad or 360 degrees (SI brochure; ISO 31)."""
    turn = 2 * math.pi
    expected = {
        "m": {"m": 1, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "nmi": 1852, "ft": 0.3048},
        "rad": {"rad": 1, "deg": turn / 360},
        "m/s": {"m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1000 / 3600, "kn": 1852 / 3600},
        "rad/s": {"rad/s": 1, "deg/s": turn / 360, "deg/min": turn / 360 / 60, "rpm": turn / 60, "Hz": turn},
        "s": {"s": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60, "h": 3600},
    }
    assert {kind: set(units) for kind, units in UNITS_OF.items()} == {k: set(units) for k, units in expected.items()}
    known = {unit: factor for units in expected.values() for unit, factor in units.items()} | {"N": 1, "kN": 1000}
    assert pytest.approx({"": 1.0, **known}, rel=1e-12) == UNIT_SCALES
    for unit, factor in known.items():
        assert ColumnConfig(column="a", unit=unit, scale=-2.5).factor == pytest.approx(-2.5 * factor, rel=1e-12)


@pytest.mark.parametrize(("unit", "scale", "share"), [("ms", 1.0, 1e-3), ("s", 0.05, 0.05), ("min", 1e-3, 0.06)])
def test_times_count_from_the_zero_of_their_column(unit, scale, share):
    """value = scale x unit x (column - zero), from what the stamps count from."""
    stamps = 1700 + 25 * np.arange(12)
    clock = clock_of(stamps, ColumnConfig(column="t", unit=unit, scale=scale, zero=1400.0), "here", 12.5)
    assert clock.start_s == pytest.approx(12.5 + 300 * share, rel=1e-12)
    assert clock.t == pytest.approx(25 * share * np.arange(12), rel=1e-12)


def test_commands_of_an_actuator_may_have_any_unit_of_its_kind():
    """Turns are said in rad/s, rpm or 1/s by actuators; a plan says them in any unit of a rate of turn."""
    turns = ("rad/s", "deg/s", "deg/min", "rpm", "Hz")
    assert [_units_like(own) for own in ("rpm", "1/s", "rad/s")] == [turns] * 3
    assert [_units_like(own) for own in ("N", "rad", "", "V")] == [("N", "kN"), ("rad", "deg"), (), ()]
    assert _SCALES["1/s"] == pytest.approx(2 * math.pi)
    assert _SCALES["rpm"] == pytest.approx(2 * math.pi / 60)


def test_pings_stand_out_against_those_of_about_the_same_speed():
    """By ten standard deviations: 0.05 beside noise of 0.001 at low speed, not 0.4 beside 0.1 at a high one."""
    random = np.random.default_rng(5)
    speed = random.permutation(np.concatenate([np.linspace(0.1, 0.2, 300), np.linspace(4, 5, 300)]))
    left = np.where(speed > 1, 0.1, 0.001) * np.tile([1.0, -1.0, 0.5, -0.5], 150)
    whole = np.stack([-1.1 * speed, np.full(600, 0.01), speed, np.full(600, -0.01)], axis=-1)
    slow, fast = np.flatnonzero(speed < 1)[7], np.flatnonzero(speed > 1)[7]
    left[slow], left[fast] = -0.05, 0.4
    whole[slow, 0] = 60.0  # one wrong beam makes no fast ping
    assert np.flatnonzero(beam_faults.standing_out(whole, left)).tolist() == [slow]


def test_a_descent_without_the_depth_is_taken_from_what_there_is():
    """Of R = Rz(heading) Ry(pitch) Rx(roll), from the body (forward, right, down) to north, east, down."""
    pitch, roll, heading = np.array([0.3, -0.4]), np.array([-0.5, 0.7]), np.array([1.1, -2.0])
    u, v, w = np.array([1.2, -0.7]), np.array([0.5, 0.4]), np.array([-0.3, 0.6])
    nu = np.stack([u, v, w], -1)
    turn = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], -1))  # body FRD to NED
    down = turn.apply(nu)[:, 2]
    measured = {"pitch": pitch, "roll": roll, "u": u, "v": v, "w": w}
    assert np.allclose(_descent(measured, {}), down)
    unrolled = Rotation.from_euler("ZYX", np.stack([heading, pitch, 0 * roll], -1)).apply(nu * [1, 0, 1])[:, 2]
    assert np.allclose(_descent({"pitch": pitch, "u": u, "w": w}, {}), unrolled)
    assert np.allclose(_descent({"w": w}, {}), w)
    assert _descent({"w": w, "u": u}, {}) is None
    assert np.allclose(_descent({"pitch": pitch, "u": u}, {}), -u * np.sin(pitch))
    assert _descent({"pitch": pitch + 0.8, "u": u}, {}) is None  # steep
    # by a way that has no rate of depth, of a vehicle that goes ahead along its pitch
    flat = turn.apply(np.stack([u, 0 * u, 0 * u], -1)) * [1, 1, 0]
    slopes = dict(zip("uvw", turn.inv().apply(flat).T, strict=True))
    place = {"north": u, "east": u, "heading": heading}
    assert np.allclose(_descent({"pitch": pitch, "roll": roll, **place}, slopes), -u * np.sin(pitch))


def test_the_memory_of_residuals_is_their_integrated_correlation():
    """1 + 2 sum of correlations, while they exceed 2/sqrt(n); sums over three have 1 + 2 (2/3 + 1/3).

    A first-order process of 0.6 has (1 + 0.6)/(1 - 0.6) = 4, less what is too little to count.
    """
    random = np.random.default_rng(11)
    white, slow = random.normal(size=(402, 2)), np.zeros(402)
    for k in range(1, 402):
        slow[k] = 0.6 * slow[k - 1] + white[k, 1]
    off = np.stack([white[2:, 0] + white[1:-1, 0] + white[:-2, 0], slow[2:]], -1)
    off[7, 0] = np.nan
    totals = []
    for x in np.nan_to_num(off).T:
        sums = np.correlate(x, x, "full")[399:]
        rho = sums / (400 - np.arange(400)) / (sums[0] / 400)
        few = int(np.argmax(rho[1:] < 2 / math.sqrt(400)))
        totals.append(1 + 2 * rho[1 : 1 + few].sum())
    assert 0 < rho[1 + few] < 0.1  # there, and may be chance
    assert totals[0] == pytest.approx(3.0, abs=0.4)
    assert totals[1] == pytest.approx(3.7, abs=0.4)
    assert _memory(off) == pytest.approx(np.mean(totals))
    assert _memory(np.zeros((30, 1))) == 1.0


def test_squares_have_grown_beyond_chance_or_not():
    """By Student's law over the shots, or by more than half in all, or there is one shot alone."""
    before, spread = np.full(5, 1.0), 0.01 * np.array([-2.0, 1.0, 0.0, -1.0, 2.0])
    # Student's t(4) of 95 %: 2.1318, of a mean over five with the deviation 0.015811
    edge = 2.1318 * 0.0158114 / math.sqrt(5)
    assert _surely_larger(before + spread + 1.01 * edge, before)
    assert not _surely_larger(before + spread + 0.99 * edge, before)
    assert not _surely_larger(before - 0.3, before)
    few = np.array([3.0, 0.0, 0.0, 0.0, 0.0])
    assert not _surely_larger(before + 0.8 * few, before)
    assert _surely_larger(before + 0.9 * few, before)  # by more than half in all
    assert _surely_larger(np.array([0.5]), np.array([1.0]))


def test_gaps_between_shots_go_the_short_way_round():
    """End of a shot less the beginning of the next, in tolerances; angles (roll, pitch, heading) by the short way."""
    seen = np.zeros((3, 12, 3))
    seen[-1, [0, 3, 5], 0], seen[0, [0, 3, 5], 1] = (2.0, 3.0, -3.0), (0.5, -2.9, 3.1)
    seen[-1, [0, 3, 5], 1], seen[0, [0, 3, 5], 2] = (-4.0, 0.2, 0.7), (2.5, 0.5, -0.5)
    seen[-1, :, 2] = 9.0
    meet = Stub(meet=[(0, 0.5), (5, 0.1), (3, 0.2)])
    found = Problem._mismatch(meet, seen, 1)
    assert found == pytest.approx([3.0, (2 * math.pi - 6.1) / 0.1, (5.9 - 2 * math.pi) / 0.2])
    assert Problem._mismatch(meet, seen, 2) == pytest.approx([-13.0, 12.0, -1.5])


def test_the_loss_of_huber_grows_with_the_square_and_then_straight():
    """x^2/2 up to 1.5, then 1.5 (|x| - 0.75)."""
    off = np.array([0.5, -2.0, np.nan, 3.0])
    assert Problem._rho(Stub(plan=Stub(loss="huber"), huber=1.5), off) == pytest.approx(0.125 + 1.875 + 3.375)
    assert Problem._rho(Stub(plan=Stub(loss="squares")), off) == pytest.approx(0.5 * 13.25)


def test_tangents_of_initial_states():
    """Of places and velocities ones; of a turn about a body axis, half of the quaternion's product with (0, axis)."""
    q = np.array([[0.5, -0.1, 0.7, 0.5], [0.2, 0.6, -0.3, 0.71]])
    shots = Shots(np.arange(2), 4, np.zeros(2, int), np.zeros((2, 3)), q, np.zeros((2, 6)), np.zeros(2, bool))
    found = _directions(shots, 2, [1, 3, 4, 5, 7, 11], 3, 10)
    expected = np.zeros((21, 2, 10))
    expected[1, :, 3] = expected[8, :, 7] = expected[12, :, 8] = 1.0
    for k, axis in enumerate(np.eye(3)):
        expected[3, :, 4 + k] = -0.5 * q[:, 1:] @ axis
        expected[4:7, :, 4 + k] = 0.5 * (q[:, :1] * axis + np.cross(q[:, 1:], axis)).T
    assert np.allclose(found, expected)


def test_errors_of_the_filter_go_into_the_state():
    """The attitude turns by a rotation vector in the body, its covariance by I - [vector x]/2.

    Source: J. Sola, arXiv 1711.02508, Section 6.3.
    """
    q = np.array([[0.5, -0.1, 0.7, 0.5]])
    std = np.linspace(0.1, 2.2, 22)
    lanes = Lanes.at(np.array([[1.0, -2, 3]]), np.array([[0.1, 0.2, -0.3]]), q, std)
    lanes.covariance += 0.01 * np.outer(std, std[::-1]) + 0.01 * np.outer(std[::-1], std)
    before, error = lanes.covariance[0].copy(), np.linspace(-0.3, 0.54, 22)
    lanes._inject(error[None])
    turned = Rotation.from_quat(np.roll(q, -1)) * Rotation.from_rotvec(error[None, 6:9])
    assert abs((np.roll(turned.as_quat(), 1) @ lanes.attitude.T)[0, 0]) == pytest.approx(1.0, abs=1e-12)
    assert np.allclose(lanes.position, np.array([1.0, -2, 3]) + error[:3])
    assert np.allclose(lanes.velocity, np.array([0.1, 0.2, -0.3]) + error[3:6])
    assert np.allclose([lanes.gyroscope[0], lanes.accelerometer[0]], [error[9:12], error[12:15]])
    assert np.allclose(lanes.slow, error[15:])
    x, y, z = error[6:9]
    g = np.eye(22)
    g[6:9, 6:9] -= 0.5 * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    assert np.allclose(lanes.covariance[0], g @ before @ g.T)


def test_readings_of_some_members_are_cut_out_of_every_tick():
    """Rows go tick by tick, within by member, within by copy."""
    data = np.arange(12.0)[:, None]  # two ticks of three members of two copies
    whole = Measurement(data=data, truth=-data, valid=np.arange(12) % 5 > 0, extras={"no": np.arange(12)})
    some = Sampled(("a", "b", "c"), Stub(), range(7, 9), whole).some([2, 0], 2)
    assert some.members == ("c", "a")
    assert some.measurement.data.ravel().tolist() == [4, 5, 0, 1, 10, 11, 6, 7]
    assert some.measurement.extras["no"].tolist() == [4, 5, 0, 1, 10, 11, 6, 7]
    assert some.measurement.valid.tolist() == [True, False, False, True, False, True, True, True]
    assert some.measurement.truth.ravel().tolist() == [-4, -5, 0, -1, -10, -11, -6, -7]
    middle = Sampled(("a", "b", "c"), Stub(), range(7, 9), whole).of(1, 2)
    assert middle.measurement.data.ravel().tolist() == [2, 3, 8, 9]
