"""Thrust in a flow through the disc, in jets and in a tunnel, against momentum balances and published forms."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest
from scipy.optimize import brentq

from pelagos import jit
from pelagos.errors import ScenarioError
from pelagos.hydro import momentum_disc, wash
from pelagos.hydro.b_series import thrust_polynomial, torque_polynomial
from pelagos.manoeuvres import run_manoeuvre
from pelagos.vehicles.vehicle import Vehicle

RHO = 1000.0
BASE = {
    "type": "custom", "density_kg_m3": RHO, "length_m": 4.0, "beam_m": 4.0, "height_m": 4.0,
    "mass": {"type": "explicit", "mass_kg": 30, "inertia_kg_m2": [4, 5, 6]},
    "added_mass": {"type": "diagonal", "diagonal": [0, 0, 0, 0, 0, 0]}, "coriolis": {"rigid": "none"},
    "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
}  # fmt: skip
DISC = {"type": "disc", "wake_fraction": 0.2, "thrust_deduction": 0.1}
FORCE = {
    "type": "force_thruster", "position_m": [-0.3, 0.5, 0.2], "direction": [2, 1, -0.5], "low_n": -50, "high_n": 60,
    "torque_m": 0.02, "time_constant_s": 0.1, "diameter_m": 0.12,
}  # fmt: skip
SHAFT = {
    "type": "thruster", "position_m": [-0.3, 0.5, 0.2], "direction": [2, 1, -0.5], "forward": 2.1e-3, "reverse": 1.5e-3,
    "low": -400, "high": 400, "torque_m": 0.02, "time_constant_s": 0.1, "diameter_m": 0.12,
}  # fmt: skip


T200 = {"type": "t200", "position_m": [-0.3, 0.5, 0.2], "direction": [2, 1, -0.5], "time_constant_s": 0.1}
BATTERY = {"battery": {"open_circuit_v": 16.0, "resistance_ohm": 0.1}}
ORIGIN = ([1, 0, 0], [0, 0, 0])
CURVE = {
    "type": "curve_thruster", "position_m": [0, 0, 0], "direction": [1, 0, 0], "commands": [-1, 1],
    "thrusts_n": [-8, 10], "time_constant_s": 0.1, "diameter_m": 0.12,
}  # fmt: skip


def vehicle(*parts, **more):
    return Vehicle.from_dict({**BASE, "actuators": {f"a{i}": p for i, p in enumerate(parts)}, **more})


def wrench(v, states, nu=(0.0,) * 6):
    """Sum of all forces, from the acceleration times mass."""
    states = np.atleast_2d(states)
    nu_dot, _ = v.accelerations(np.zeros((1, 6)), np.array([nu]), states, states)
    return v.config.body.mass_matrix @ nu_dot[0]


def open_balance(thrust, ahead, diameter):
    """T of T = 2 rho A (V + v) v at the power T0 sqrt(T0/(2 rho A)), by bisection."""
    area = math.pi / 4 * diameter**2
    power = thrust * math.sqrt(thrust / (2 * RHO * area))
    v = brentq(lambda v: 2 * RHO * area * (ahead + v) ** 2 * v - power, 0, 100, xtol=1e-14)
    return 2 * RHO * area * (ahead + v) * v


def duct_balance(thrust, ahead, diameter):
    """T of T = rho A Ve (Ve - V) at the power rho A Ve0^3/2, by bisection."""
    area = math.pi / 4 * diameter**2
    power = 0.5 * RHO * area * math.sqrt(thrust / (RHO * area)) ** 3
    e = brentq(lambda e: 0.5 * RHO * area * e * (e * e - ahead**2) - power, ahead, 100, xtol=1e-14)
    return RHO * area * e * (e - ahead)


@pytest.mark.parametrize("ahead", [0.0, 0.03, 0.7, 2.5, 9.0])
@pytest.mark.parametrize(
    ("share", "balance"), [(momentum_disc.open_share, open_balance), (momentum_disc.duct_share, duct_balance)]
)
def test_disc_keeps_its_power(share, balance, ahead):
    """Closed forms against the balance, bisected to 1e-14 m/s."""
    still = float(momentum_disc.flow_at_rest(jit.Float64(-37.0), RHO, 0.12)[0])
    left = float(share(jit.Float64(ahead / still))[0])
    assert 37 * left == pytest.approx(balance(37.0, ahead, 0.12), rel=1e-10)


def test_shares_and_flows_are_inverse():
    for t in (0.05, 0.4, 0.9, 1.0):
        assert float(momentum_disc.open_share(jit.Float64(momentum_disc.open_inflow(t)))[0]) == pytest.approx(
            t, rel=1e-12
        )
        assert float(momentum_disc.duct_share(jit.Float64(momentum_disc.duct_inflow(t)))[0]) == pytest.approx(
            t, rel=1e-12
        )


def test_far_limits_of_a_disc():
    """t -> 1 - u/3 and 1 - s at small flows, P/V at large ones; a thruster that gives nothing is not NaN."""
    u = 1e-4
    assert float(momentum_disc.open_share(jit.Float64(u))[0]) == pytest.approx(1 - u / 3, abs=u * u)
    assert float(momentum_disc.duct_share(jit.Float64(u))[0]) == pytest.approx(1 - u / math.sqrt(2), abs=u * u)
    assert float(momentum_disc.open_share(jit.Float64(1e4))[0]) == pytest.approx(1e-4, rel=1e-9)
    assert float(momentum_disc.duct_share(jit.Float64(1e4))[0]) == pytest.approx(1e-4 / math.sqrt(2), rel=1e-9)
    assert wrench(vehicle({**FORCE, "inflow": DISC}), [0.0], (1, 2, 3, 0, 0, 0)) == pytest.approx(0, abs=1e-12)


def test_flow_from_behind_keeps_the_thrust_within_15_percent():
    """Leishman 2006 (2.96): v/vh = 1 - 1.125 x - 1.372 x^2 - 1.718 x^3 - 0.655 x^4; T^(3/2) (x + v/vh) = P is kept."""
    x = np.linspace(-1, 0, 50)
    with_flow = (x + 1 - 1.125 * x - 1.372 * x**2 - 1.718 * x**3 - 0.655 * x**4) ** (-2 / 3)
    u = x * np.sqrt(with_flow)  # x is in units of the flow that the thrust in the flow would draw
    kept = np.array(momentum_disc.open_share(jit.Float64(u)))
    assert u.min() < -1
    assert np.abs(kept / with_flow - 1).max() < 0.15


@pytest.mark.parametrize("thrust", [40.0, -25.0])
@pytest.mark.parametrize("ducted", [False, True])
@pytest.mark.parametrize("nu", [(0.9, -0.4, 0.3, 0.2, -0.6, 0.7), (-0.8, 0.2, -0.5, 0.5, 0.3, -0.9)])
def test_a_thruster_in_its_own_flow(thrust, ducted, nu):
    """(1 - t) of the momentum balance at (1 - w) a . (v + omega x r), ahead of the push; torque with thrust."""
    got = wrench(vehicle({**FORCE, "inflow": {**DISC, "ducted": ducted}}), [thrust], nu)
    axis, r = np.array([2, 1, -0.5]) / np.linalg.norm([2, 1, -0.5]), np.array(FORCE["position_m"])
    ahead = 0.8 * np.sign(thrust) * axis @ (nu[:3] + np.cross(nu[3:], r))
    left = np.sign(thrust) * (duct_balance if ducted else open_balance)(abs(thrust), max(ahead, 0), 0.12)
    assert got[:3] == pytest.approx(0.9 * left * axis, rel=1e-9)
    assert got[3:] == pytest.approx(0.9 * np.cross(r, left * axis) + 0.02 * left * axis, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("speed", [130.0, -110.0])
@pytest.mark.parametrize("way", [1.3, -0.7, 9.0])
def test_a_propeller_of_the_b_series(speed, way):
    """T = k n|n| KT(J)/KT(0), Q likewise with KQ, J = (1 - w) a . v/(n D) between 0 and that of zero thrust."""
    series = {"type": "b_series", "pitch_ratio": 0.9, "area_ratio": 0.6, "blades": 4, "wake_fraction": 0.15}
    got = wrench(vehicle({**SHAFT, "inflow": series}), [speed], (way, 0, 0, 0, 0, 0))
    axis, r = np.array([2, 1, -0.5]) / np.linalg.norm([2, 1, -0.5]), np.array(SHAFT["position_m"])
    bollard = (2.1e-3 if speed > 0 else 1.5e-3) * speed * abs(speed)
    kt, kq = thrust_polynomial(0.9, 0.6, 4), torque_polynomial(0.9, 0.6, 4)
    zero = min(x.real for x in np.roots(kt[::-1]) if abs(x.imag) < 1e-9 and x.real > 0)
    j = np.clip(np.sign(speed) * 0.85 * axis[0] * way / (abs(speed) / (2 * np.pi) * 0.12), 0, zero)
    thrust, torque = (bollard * np.polynomial.polynomial.polyval(j, c) / c[0] for c in (kt, kq))
    assert got[:3] == pytest.approx(thrust * axis, rel=1e-9, abs=1e-9)
    assert got[3:] == pytest.approx(np.cross(r, thrust * axis) + 0.02 * torque * axis, rel=1e-9, abs=1e-9)


def test_the_torque_of_a_disc_falls_nearly_as_that_of_a_propeller():
    """A disc's torque falls as its thrust; KQ/KT of a B4-70, P/D 1, rises by less than a tenth up to J = 0.5."""
    kt, kq = thrust_polynomial(1.0, 0.7, 4), torque_polynomial(1.0, 0.7, 4)
    ratio = [np.polynomial.polynomial.polyval(j, kq) / np.polynomial.polynomial.polyval(j, kt) for j in (0.0, 0.5)]
    assert 1 < ratio[1] / ratio[0] < 1.1


def test_a_tunnel_thruster_of_delphin2():
    """exp(-0.35 u^2) along and across the tunnel, its own axial loss besides; that of rotation too."""
    tunnel = {**FORCE, "direction": [0, 1, 0], "inflow": {"type": "disc", "tunnel_loss_s2_m2": 0.35}}
    nu = (0.8, 0.0, -0.3, 0.4, -0.5, 0.6)
    got = wrench(vehicle(tunnel), [20.0], nu)
    x, y, z = np.add(nu[:3], np.cross(nu[3:], FORCE["position_m"]))
    assert got[1] == pytest.approx(math.exp(-0.35 * (x * x + z * z)) * open_balance(20.0, max(y, 0), 0.12), rel=1e-9)
    assert got[4] == pytest.approx(
        0.02 * open_balance(20.0, max(y, 0), 0.12), rel=1e-9
    )  # of the shaft, not of the hull


# jets


@pytest.mark.parametrize(("x", "angle", "share"), [(3, 0, 0.3713), (8, 0, 0.5904), (8, 15, 0.9354), (4, 30, 0.9675)])
def test_formula_of_dang_and_laheij(x, angle, share):
    """t = 1 - 0.80^((x/D)^(2/3)), t + (1 - t) phi^3/(130/t^3 + phi^3): by hand, to four digits."""
    assert wash.steered_share(wash.tandem_share(x), angle) == pytest.approx(share, abs=6e-5)
    assert wash.tandem_share(8, wash.UNDER_HULL) == pytest.approx(1 - 0.75**4, abs=1e-12)


LAWS = [
    (FORCE, {"type": "disc"}), (FORCE, {"type": "disc", "ducted": True, "wake_fraction": 0.3}),
    (SHAFT, {"type": "b_series", "pitch_ratio": 1.1, "area_ratio": 0.5, "blades": 5}),
]  # fmt: skip


def tandem(part, inflow, distance, angle_deg, **more):
    """One thruster ahead, turned, and one straight along x behind it."""
    turn = math.radians(angle_deg)
    ahead = {**part, "position_m": [0.7, 0, 0], "direction": [math.cos(turn), math.sin(turn), 0], "inflow": inflow}
    behind = {**part, "position_m": [0.7 - distance * 0.12, 0, 0], "direction": [1, 0, 0], "inflow": inflow}
    return vehicle(ahead, behind, interaction={"thrusters": ["a0", "a1"], **more})


@pytest.mark.parametrize(("part", "inflow"), LAWS)
@pytest.mark.parametrize("distance", [2.0, 7.0])
@pytest.mark.parametrize(("angle", "sign"), [(0.0, 1), (-12.0, 1), (40.0, 1), (0.0, -1)])
def test_a_tandem_pair_loses_what_the_formula_says(part, inflow, distance, angle, sign):
    """Whatever law a thruster has, at equal commands: ahead the second of them, astern the first."""
    v = tandem(part, inflow, distance, angle)
    state = sign * (200.0 if part is SHAFT else 30.0)
    alone = [wrench(vehicle(v.config.actuators[n].model_dump()), [state]) for n in ("a0", "a1")]
    left = wash.steered_share(wash.tandem_share(distance), angle)
    shares = (1.0, left) if sign > 0 else (left, 1.0)
    expected = shares[0] * alone[0] + shares[1] * alone[1]
    if part is SHAFT:  # reaction torque falls by KQ instead
        expected[3] = wrench(v, [state, state])[3]
    assert wrench(v, [state, state]) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_jets_go_with_the_root_of_thrust_and_add_their_momentum():
    """A quarter of the thrust upstream: half the flow. Two alike jets: the flow of one of twice the thrust."""
    v = tandem(FORCE, {"type": "disc"}, 6.0, 0.0)
    u = momentum_disc.open_inflow(wash.tandem_share(6.0))
    for upstream in (30.0, 7.5):
        left = wrench(v, [upstream, 30.0])[0] - upstream
        assert left == pytest.approx(
            30 * float(momentum_disc.open_share(jit.Float64(u * math.sqrt(upstream / 30)))[0]), rel=1e-9
        )
    base = {**FORCE, "direction": [1, 0, 0], "inflow": {"type": "disc"}}
    places = [[0.7, 0.3, 0], [0.7, -0.3, 0], [-0.4, 0, 0]]
    three = vehicle(*({**base, "position_m": p} for p in places), interaction={"thrusters": ["a0", "a1", "a2"]})
    jets = {j.source: j.ahead for j in three.model.interaction.jets}
    assert jets["a0"] == pytest.approx(jets["a1"], rel=1e-12)
    both = wrench(three, [20.0, 20.0, 30.0])[0] - 40
    one = wrench(three, [40.0, 0.0, 30.0])[0] - 40
    assert both == pytest.approx(one, rel=1e-9)
    assert both < 29.5


def test_a_jet_from_behind_and_one_that_looks_away_take_nothing():
    v = tandem(FORCE, {"type": "disc"}, 6.0, 0.0)
    assert wrench(v, [30.0, -30.0])[0] == pytest.approx(0, abs=1e-9)  # the jet drives into the one that pushes astern
    assert wrench(v, [-30.0, 30.0])[0] == pytest.approx(0, abs=1e-9)


def test_under_a_hull_the_jet_costs_less_only_where_the_formula_says():
    open_water, hull = (tandem(FORCE, {"type": "disc"}, 8.0, 0.0, under_hull=x) for x in (False, True))
    assert wrench(open_water, [30, 30])[0] == pytest.approx(30 * (2 - 0.8**4), rel=1e-9)
    assert wrench(hull, [30, 30])[0] == pytest.approx(30 * (2 - 0.75**4), rel=1e-9)


# fleets, gradients, refusals


def test_a_fleet_is_its_vehicles():
    v = tandem(FORCE, {**DISC, "tunnel_loss_s2_m2": 0.2}, 3.0, 5.0)
    states = np.array([[40.0, 30], [-20, 25], [0, -50]])
    nu = np.array([[0.5, -0.2, 0.1, 0.3, 0.1, -0.2], [-1, 0.4, 0.2, -0.1, 0.2, 0.3], [2, 1, -1, 0.2, 0.5, 0.4]])
    whole, _ = v.accelerations(np.zeros((3, 6)), nu, states, states)
    for i in range(3):
        alone, _ = v.accelerations(np.zeros((1, 6)), nu[i : i + 1], states[i : i + 1], states[i : i + 1])
        assert (whole[i] == alone[0]).all()


@pytest.mark.parametrize(("part", "inflow"), LAWS)
def test_gradients_by_speed_and_command(part, inflow):
    """Against central differences of 1e-5: their error is of the order of 1e-9 of the force."""
    v = tandem(part, {**inflow, "tunnel_loss_s2_m2": 0.1}, 4.0, 6.0)
    first = 200.0 if part is SHAFT else 30.0

    def push(x):
        from pelagos.vehicles.flow import make_flow

        eye = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        flow = make_flow([0.0, 0.0, 5.0], eye, [0.3 + x, 0.2 - x, 0.1, 0.1, 0.2, x], [0.0, 0.0, 0.0])
        found = v.model.wrenches(flow, [first + 3 * x, jit.Float64(0.9 * first) + 5 * x])
        return found["a0"][0] + found["a1"][0] + found["a1"][5]

    x = jit.Float64(0.0)
    dr.enable_grad(x)
    dr.backward(push(x))
    slope = float(dr.grad(x)[0])
    h = 1e-5
    assert slope == pytest.approx(
        (float(push(jit.Float64(h))[0]) - float(push(jit.Float64(-h))[0])) / (2 * h), rel=1e-6
    )


@pytest.mark.parametrize("at", [0.0, 1e-3])
def test_gradients_at_rest_are_finite(at):
    x = jit.Float64(at)
    dr.make_opaque(x)
    dr.enable_grad(x)
    dr.backward(momentum_disc.open_share(x) + momentum_disc.duct_share(x) + momentum_disc.flow_at_rest(x, RHO, 0.1))
    assert np.isfinite(dr.grad(x)[0])


@pytest.mark.parametrize(
    ("parts", "more", "said"),
    [
        ([{k: v for k, v in FORCE.items() if k != "diameter_m"} | {"inflow": DISC}], {}, "give diameter_m"),
        ([{**FORCE, "inflow": {**DISC, "wake_fraction": -0.1}}], {}, "wake_fraction"),
        ([{**FORCE, "inflow": {**DISC, "thrust_deduction": 1.0}}], {}, "thrust_deduction"),
        ([{**FORCE, "inflow": {**DISC, "tunnel_loss_s2_m2": -1}}], {}, "tunnel_loss_s2_m2"),
        ([{**FORCE, "inflow": LAWS[2][1]}], {}, "inflow.*b_series needs the speed of the shaft, which only a thruster"),
        ([{**T200, "inflow": LAWS[2][1]}], BATTERY, "b_series needs the speed of the shaft, which only a thruster"),
        ([{**CURVE, "inflow": LAWS[2][1]}], {}, "b_series needs the speed of the shaft, which only a thruster"),
        *(
            ([{**part, "direction": direction}], BATTERY, said)
            for part in (FORCE, SHAFT, T200, CURVE)
            for direction, said in (
                ([0, 0, 0], "direction must not be 0, 0, 0"), ([0, 1e-200, 0], "length"), ([1e200, 0, -1e200], "length")
            )
        ),
        ([{**FORCE, "inflow": DISC}], {"medium": "air", "density_kg_m3": None}, "inflow of 'a0' in the air needs its"),
        ([{**SHAFT, "unit": "share", "inflow": LAWS[2][1]}], {}, "needs the speed of the shaft"),
        ([{**SHAFT, "inflow": {**LAWS[2][1], "blades": 9}}], {}, "blades"),
        ([{**SHAFT, "unit": "rpm", "inflow": LAWS[2][1]}], {}, "thrust coefficient of 36"),
        ([{**FORCE, "inflow": DISC}], {"interaction": {"thrusters": ["a0"]}}, "two thrusters at least"),
        ([{**FORCE, "inflow": DISC}], {"interaction": {"thrusters": ["a0", "b"]}}, "'b', which this vehicle"),
        ([{**FORCE, "inflow": DISC}, FORCE], {"interaction": {"thrusters": ["a0", "a1"]}}, "give it an inflow"),
        (
            [{**FORCE, "inflow": DISC}, {"type": "channel", "low": 0, "high": 1}],
            {"interaction": {"thrusters": ["a0", "a1"]}}, "no jet can change",
        ),
        (
            [{**FORCE, "inflow": DISC, "position_m": p} for p in ([0, 0, 0], [0.1, 0, 0])],
            {"interaction": {"thrusters": ["a0", "a1"]}}, "nearer than anything was measured",
        ),
        *(
            (
                [{**FORCE, "inflow": DISC, "direction": d, "position_m": p} for d, p in (ORIGIN, second)],
                {"interaction": {"thrusters": ["a0", "a1"]}}, "reaches '.*nearer than anything was measured",
            )
            for second in (
                ([1, 0, 0], [0, 0, 0]), ([0, 1, 0], [0, 0, 0]), ([-1, 0, 0], [0, 0, 0]), ([1, 0, 0], [1.2e-7, 0, 0]),
                ([1, 0, 0], [-1e-11, 0, 0]),
            )
        ),
        *(
            (
                [
                    {**FORCE, "inflow": DISC, "direction": [1, 0, 0], "position_m": [x, 0, 0], "diameter_m": size}
                    for x, size in ((0.7, front), (0.3, rear))
                ],
                {"interaction": {"thrusters": ["a0", "a1"]}}, "measured on equal thrusters.*ratio up to 1.1",
            )
            for front, rear in ((0.1, 0.3), (0.3, 0.1), (0.1, 0.111))
        ),
        (
            [  # the small one looks away
                {**FORCE, "inflow": DISC, "direction": [1, 0, 0], "position_m": [0.7, 0, 0], "diameter_m": 0.3},
                {**FORCE, "inflow": DISC, "direction": [0.17, 0.98, 0], "position_m": [-0.2, 0, 0], "diameter_m": 0.1},
            ],
            {"interaction": {"thrusters": ["a0", "a1"]}}, "the jet of 'a0', diameter 0.3 m, reaches 'a1', 0.1 m",
        ),
        (
            [{**FORCE, "inflow": DISC, "direction": [1, 0, 0], "position_m": [x, 0, 0], "diameter_m": size}
             for x, size in ((0.5, 0.1), (0.3, 0.25))],
            {"interaction": {"thrusters": ["a0", "a1"]}}, "at 0.8 diameters, nearer",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(parts, more, said):
    whole = {**BASE, "actuators": {f"a{i}": p for i, p in enumerate(parts)}, **more}
    with pytest.raises(ScenarioError, match=said) as caught:
        Vehicle.from_dict({k: v for k, v in whole.items() if v is not None})
    assert "Extra inputs" not in str(caught.value)


def test_thrusters_side_by_side_or_across_do_not_meet_whatever_their_size():
    """Half a diameter apart with axes alike, and a large one across the axis of a jet: nothing is lost or refused."""
    places = (([1, 0, 0], [0, 0, 0], 0.12), ([1, 0, 0], [0, 0.06, 0], 0.3), ([0, 0, 1], [-0.9, 0, 0], 0.4))
    parts = [{**FORCE, "inflow": DISC, "direction": d, "position_m": p, "diameter_m": size} for d, p, size in places]
    assert not vehicle(*parts, interaction={"thrusters": ["a0", "a1", "a2"]}).model.interaction.jets


def test_a_tenth_of_the_diameter_moves_the_share_by_less_than_stated():
    """Largest difference of t by x/D and by 1.1 x/D: 2/(3 e) ln 1.1 = 0.0234 to first order."""
    x = np.geomspace(1, 40, 400)
    for base in (wash.OPEN_WATER, wash.UNDER_HULL):
        moved = [wash.tandem_share(wash.LARGEST_RATIO * d, base) - wash.tandem_share(d, base) for d in x]
        assert 0.022 < max(moved) < 0.024
    pair = [
        {**FORCE, "inflow": DISC, "direction": [1, 0, 0], "position_m": [x, 0, 0], "diameter_m": size}
        for x, size in ((0.7, 0.1), (0.3, 0.109))
    ]
    assert vehicle(*pair, interaction={"thrusters": ["a0", "a1"]}).model.interaction.jets


def test_of_three_in_a_row_every_jet_is_that_of_the_thrust_at_rest():
    """The third stands in the jets of both as if the second had lost nothing: V^2 = v1^2 + v2^2."""
    base = {**FORCE, "direction": [1, 0, 0], "inflow": {"type": "disc"}}
    row = [{**base, "position_m": [x, 0, 0]} for x in (0.7, 0.1, -0.8)]
    v = vehicle(*row, interaction={"thrusters": ["a0", "a1", "a2"]})
    behind = [momentum_disc.open_inflow(wash.tandem_share(d / 0.12)) for d in (0.9, 1.5)]
    second = wash.tandem_share(5.0)
    third = float(momentum_disc.open_share(jit.Float64(math.hypot(*behind)))[0])
    assert wrench(v, [30.0, 30.0, 30.0])[0] == pytest.approx(30 * (1 + second + third), rel=1e-9)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"actuators": {"front_starboard": None}}, "'front_starboard', which is null: leave it out of interaction too"),
        ({"interaction": {"thrusters": ["front_port", "rear_prt"]}}, "does not have .did you mean 'rear_port'"),
        (
            {"interaction": {"thrusters": ["front_port", "rear_prt"]}, "actuators": {"rear_port": None}},
            "does not have .did you mean '(front_port|rear_starboard|top_rear_port)'",
        ),
    ],
)
def test_hints_name_thrusters_that_are_there(more, said):
    with pytest.raises(ScenarioError, match=said):
        Vehicle.from_dict({"type": "bluerov2_heavy", "variant": "thruster_losses", **more})


def test_inflow_in_air_takes_the_density_of_air():
    """A flow of 9 m/s is a third of what 20 N draw in air, where it would be nearly all of it in water."""
    v = vehicle({**FORCE, "inflow": {"type": "disc"}, "direction": [1, 0, 0]}, medium="air", density_kg_m3=1.2)
    still = math.sqrt(20 / (2 * 1.2 * math.pi / 4 * 0.12**2))
    left = float(momentum_disc.open_share(jit.Float64(9.0 / still))[0])
    assert wrench(v, [20.0], (9.0, 0, 0, 0, 0, 0))[0] == pytest.approx(20 * left, rel=1e-9)
    assert left > 0.8


def test_a_curve_thruster_has_one_loss():
    curve = {**CURVE, "inflow": {"type": "disc"}}
    assert wrench(vehicle(curve), [1.0], (1.5, 0, 0, 0, 0, 0))[0] == pytest.approx(
        open_balance(10, 1.5, 0.12), rel=1e-9
    )
    with pytest.raises(ScenarioError, match="give one of them"):
        vehicle({**curve, "zero_thrust_m_s": 2.0})


def test_the_bollard_trial_says_what_jets_cost():
    """Both at their limits: 60 N behind 60 N loses 1 - t; of the pull the hull takes a tenth."""
    v = tandem(FORCE, DISC, 8.0, 0.0)
    found = {m.name: m.value for m in run_manoeuvre(v.config.model_dump(), "bollard").measures}
    assert found["a1, ahead"] == pytest.approx(54)
    assert found["a1 ahead, lost in the jet of a0 ahead"] == pytest.approx(100 * 0.8**4, rel=1e-9)
    assert found["a0 astern, lost in the jet of a1 astern"] == pytest.approx(100 * 0.8**4, rel=1e-9)
    assert not any("a0 ahead, lost" in name for name in found)


def test_the_variant_of_the_bluerov2_heavy():
    """Held, jets take 3 % at most; at 1.5 m/s four thrusters at 45 deg keep what a ducted disc does in 1.06 m/s."""
    states = [0.8, 0.8, 0.8, 0.8, 0, 0, 0, 0]
    plain, lossy = (Vehicle.from_catalogue("bluerov2_heavy", **c) for c in ({}, {"variant": "thruster_losses"}))
    pull = [wrench(v, states)[0] for v in (plain, lossy)]
    assert 0.97 < pull[1] / pull[0] <= 1
    drag = wrench(plain, [0.0] * 8, (1.5, 0, 0, 0, 0, 0))[0]
    under_way = [wrench(v, states, (1.5, 0, 0, 0, 0, 0))[0] - drag for v in (plain, lossy)]
    assert under_way[0] == pytest.approx(pull[0], rel=1e-9)
    each = pull[0] / 4 * math.sqrt(2)
    left = duct_balance(each, 1.5 / math.sqrt(2), 0.076) / each
    assert under_way[1] / under_way[0] == pytest.approx(left, rel=0.01)  # jets, from ahead and from behind
