"""Ships in shallow water: slender-body theory, exact blockage, published factors, and trials of a tanker."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import CommandError, ScenarioError
from pelagos.hydro.bis_ship import sway_in_shallow_water
from pelagos.hydro.shallow_water import deep_speed_ratio, depth_factors, speed_loss
from pelagos.hydro.squat import squat
from pelagos.manoeuvres.measures import turning_measures
from pelagos.vehicles.varied import varied

G = 9.81
GROUND = [[0.0, 0.0, -1.0, 31.2]]  # NED: level, 31.2 m below the origin
NU = [6.5, 0.4, -0.1, 0.002, -0.001, -0.004]


def accelerations(vehicle, eta, nu, walls=()):
    vehicle = pl.Vehicle.from_dict(vehicle)
    still = np.full((1, len(vehicle.actuator_names)), 0.3)
    return vehicle.accelerations([eta], [nu], still, still, walls=walls)[0][0]


def force(vehicle, eta, nu, walls):
    """What planes change (6) [N], [N m]; for vehicles whose mass does not change with them."""
    change = accelerations(vehicle, eta, nu, walls) - accelerations(vehicle, eta, nu)
    return pl.Vehicle.from_dict(vehicle).config.body.mass_matrix @ change


def test_parabolic_hull_sinks_as_tucks_integrals_say():
    """Tuck 1966: the surface falls by U^2/(2 pi g h sqrt(1 - F^2)) times the principal value of the integral of
    S'(xi)/(x - xi), the hull by the mean over its waterplane; S and B parabolic give 9/(2 pi), 2 % below Hooft's."""
    length, beam, area, speed, depth = 200.0, 30.0, 250.0, 7.0, 15.0
    edges = -0.5 * length * np.cos(np.linspace(0, np.pi, 2001))
    x, widths = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    slope = -8 * area * x / length**2
    integral = np.array([np.sum(slope * np.log(np.abs((at - edges[:-1]) / (edges[1:] - at)))) for at in x])
    froude = speed / math.sqrt(G * depth)
    fall = speed**2 / (2 * np.pi * G * depth * math.sqrt(1 - froude**2)) * integral
    waterplane = beam * (1 - (2 * x / length) ** 2)
    expected = np.sum(waterplane * fall * widths) / np.sum(waterplane * widths)
    volume = area * length * 2 / 3
    assert squat((9 / (2 * np.pi), 0.0), volume, length, speed, depth, G)[0] == pytest.approx(expected, rel=1e-3)
    assert pytest.approx(9 / (2 * np.pi), rel=0.025) == 1.46


def test_bow_sinks_by_hoofts_number():
    """PIANC 2014: 1.96 volume/L^2 F^2/sqrt(1 - F^2) at the bow, up to F = 0.7, from which on it stays."""
    volume, length, depth = 312600.0, 320.0, 31.2
    for speed in (3.0, -7.0, 12.0):
        square = speed**2 / (G * depth)
        sinkage, trim = squat((1.46, 1.0), volume, length, speed, depth, G)
        assert sinkage + 0.5 * length * trim == pytest.approx(
            1.96 * volume / length**2 * square / math.sqrt(1 - square), rel=1e-12
        )
    fast, faster = (squat((1.46, 1.0), volume, length, u, depth, G)[0] for u in (0.7 * math.sqrt(G * depth), 40.0))
    assert faster == pytest.approx(fast, rel=1e-12)


@pytest.mark.parametrize("heave", [0.7, -0.4])
def test_force_sinks_the_hydrostatics_by_the_formula(heave):
    """At a heave the water is as deep as before: the distance of the ground and the heave add up. Without ground it is
    1000 km deep."""
    ship = {"type": "kvlcc2", "terms": {"squat": {"type": "squat", "sinkage": 1.3, "trim": -0.6}}}
    sinkage, trim = np.subtract(
        *(squat((1.3, -0.6), 312600.0, 320.0, NU[0], h, G) for h in (31.2 + heave, 1e6 + heave))
    )
    found = force(ship, [3.0, -2.0, heave, 0, 0, 0.4], NU, GROUND)
    assert found == pytest.approx([0, 0, 1.68e8 * sinkage, 0, -1.26e12 * trim, 0], rel=1e-9, abs=1e-3)
    astern = force(ship, [3.0, -2.0, heave, 0, 0, 0.4], [-NU[0], *NU[1:]], GROUND)
    assert astern == pytest.approx(found, rel=1e-9, abs=1e-3)


def test_hull_trims_about_its_centre_of_flotation():
    """Where the formula puts it, with the waterplane's centre 9 m aft, the hydrostatics balance the squat."""
    floating = {"hydrostatics": {"center_of_flotation_m": [-9.0, 0, 0]}}
    plain = {"type": "kvlcc2", "terms": floating}
    ship = {"type": "kvlcc2", "terms": {**floating, "squat": {"type": "squat"}}}
    sinkage, trim = squat((1.46, 1.0), 312600.0, 320.0, NU[0], 31.2, G)
    heave = sinkage + 9.0 * trim  # of the origin, which lies ahead of the centre: bow down
    balanced = [0, 0, heave, 0, -trim, 0]
    mass = pl.Vehicle.from_dict(plain).config.body.mass_matrix
    drawn = mass @ (
        accelerations(ship, balanced, NU, [[0, 0, -1.0, 31.2 - heave]]) - accelerations(plain, balanced, NU)
    )
    risen = mass @ (accelerations(plain, balanced, NU) - accelerations(plain, [0] * 6, NU))
    assert drawn[2] == pytest.approx(-risen[2], rel=1e-5)  # the trim's cosine, squared
    assert drawn[4] == pytest.approx(-risen[4], rel=2e-4)


def test_ground_is_what_lies_below():
    """Of two floors the nearer counts, and on a slope the water straight below; a quay wall is refused."""
    ship = {"type": "kvlcc2", "terms": {"squat": {"type": "squat"}}}
    quay, deep = [0, 1.0, 0, 40.0], [0, 0, -1.0, 60.0]
    with pytest.raises(CommandError, match="row 1 is no ground below the ship: banks and quay walls are for ships"):
        accelerations(ship, [0] * 6, NU, [deep, quay])
    both = force(ship, [0] * 6, NU, [deep, *GROUND])
    assert both == pytest.approx(force(ship, [0] * 6, NU, GROUND), rel=1e-12, abs=1e-6)
    slope = math.radians(20)
    slant = [0, math.sin(slope), -math.cos(slope), 31.2 * math.cos(slope)]
    assert force(ship, [0] * 6, NU, [slant])[2] == pytest.approx(both[2], rel=1e-9)


def test_flat_plate_has_its_exact_blockage():
    """A plate across a channel, conformal: -8 h^2/(pi^2 T^2) ln cos(pi T/2 h) of its mass in deep water. Clarke's fit
    in powers of 1/(h/T - 1) is 13 % from it at most."""
    for ratio in (1.25, 1.5, 2.0, 3.0, 6.0):
        exact = -8 * ratio**2 / math.pi**2 * math.log(math.cos(math.pi / (2 * ratio)))
        assert depth_factors(ratio, 1e-9).sway_mass == pytest.approx(exact, rel=0.13)


@pytest.mark.parametrize("ratio", [1.3, 1.9])
def test_weights_are_those_of_parabolic_sections(ratio):
    """Sections add up: evenly in sway, by x^2 in yaw; the rate's moment by |x|, and the drift's force amidships."""
    x = (np.arange(2000) + 0.5) / 2000
    beams = 2.6 * (1 - x * x)
    sections = np.array([depth_factors(ratio, float(b)).yv for b in beams])
    found = depth_factors(ratio, 2.6)
    for value, weight in ((found.sway_mass, 1 + 0 * x), (found.yaw_mass, x * x), (found.nr, x)):
        assert value == pytest.approx(np.sum(weight * sections) / np.sum(weight), rel=1e-6)
    assert found.yr == found.nv == found.sway_mass
    assert found.yv == pytest.approx(sections[0], rel=1e-6)
    assert depth_factors(0.5, 2.6) == depth_factors(1.2, 2.6)


# mmgdynamics (nikpau, `_shallow_water_hdm`, after Taimuri et al. 2020): KVLCC2, X_rr and X_vr, whose beam is
# C_B B (1 + B/L)^2, and Y_v by the regression of Kijima and Nakiri, another method.
MMGDYNAMICS = {
    25.0: (2.8215902391965555, 2.546635197776181, 4.178756149798875),
    31.2: (1.565760920986095, 1.4715621988805438, 2.0314498643780814),
    45.0: (1.1335682358542603, 1.105791917616983, 1.2891963939760662),
}


@pytest.mark.parametrize("depth", MMGDYNAMICS)
def test_factors_are_those_of_another_program(depth):
    nr, yaw, kijima = MMGDYNAMICS[depth]
    found = depth_factors(depth / 20.8, 0.81 * 58 * (1 + 58 / 320) ** 2 / 20.8)
    assert (found.nr, found.yaw_mass) == pytest.approx((nr, yaw), rel=1e-12)
    assert depth_factors(depth / 20.8, 58 / 20.8).yv == pytest.approx(kijima, rel=0.06)


def test_lackenbys_loss_of_speed():
    """0.1242 (A/h^2 - 0.05) + 1 - sqrt(tanh(g h/V^2)), worked by hand; and the speed in deep water that loses it."""
    assert speed_loss(1000.0, 20.0, 3.0, G) == pytest.approx(0.1242 * 2.45, rel=1e-9)
    assert speed_loss(1000.0, 20.0, -12.0, G) == pytest.approx(
        0.1242 * 2.45 + 1 - math.sqrt(math.tanh(G * 20 / 144)), rel=1e-12
    )
    assert speed_loss(1000.0, 200.0, 3.0, G) == pytest.approx(0.0, abs=1e-15)  # A/h^2 < 0.05
    for speed in (2.0, -8.0):
        deep = speed * deep_speed_ratio(1100.0, 26.0, speed, G)
        assert deep * (1 - speed_loss(1100.0, 26.0, deep, G)) == pytest.approx(speed, rel=1e-3)


def test_no_ship_outruns_its_waves():
    """V (1 - loss(V)) = U has a root V up to sqrt(g h), the speed of the longest waves; from U = sqrt(g h)
    (1 - loss(sqrt(g h))) on the ratio stays: resistance grows with the square of the speed, without a pole. Where a
    third is lost, 12 steps of the fixed point leave 3e-3 of the root that bisection finds."""
    area, depth = 0.998 * 58 * 20.8, 25.0
    fastest = math.sqrt(G * depth)
    most = 0.1242 * (area / depth**2 - 0.05) + 1 - math.sqrt(math.tanh(1.0))
    for speed in (10.4, -13.0, 15.0, 15.3, 16.0, -22.0):
        assert deep_speed_ratio(area, depth, speed, G) == pytest.approx(
            1 / (1 - most), rel=2e-2 if speed < 11 else 1e-9
        )

    def slower(deep):
        return deep * (math.sqrt(math.tanh(G * depth / deep**2)) - 0.1242 * (area / depth**2 - 0.05))

    for speed in (9.6, -9.6):
        low, high = 5.0, fastest
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if slower(middle) < abs(speed) else (low, middle)
        assert 1 - abs(speed) / low == pytest.approx(1 / 3, abs=0.03)
        assert deep_speed_ratio(area, depth, speed, G) == pytest.approx(low / abs(speed), rel=3e-3)


@pytest.mark.parametrize("nu", [NU, [7.1, -0.6, 0.2, 0.001, 0.002, 0.005]])
def test_tanker_of_mmg_moves_by_the_scaled_derivatives(nu):
    """The variant told of the ground is the ship whose linear derivatives, masses and resistance are multiplied."""
    by, share = depth_factors(1.5, 58 / 20.8), deep_speed_ratio(0.998 * 58 * 20.8, 31.2, nu[0], G)
    hull = {
        "R0": 0.022 * share**2,
        "Yv": -0.315 * by.yv,
        "Yr": 0.083 * by.yr,
        "Nv": -0.137 * by.nv,
        "Nr": -0.049 * by.nr,
    }
    masses = [2.4014e7, 2.4342e8 * by.sway_mass, 3.2e8, 3.0e10, 1.6e12, 1.22956e12 * by.yaw_mass]
    same = {"type": "kvlcc2", "added_mass": {"diagonal": masses}, "actuators": {"rudder": {"hull": hull}}}
    ship = {"type": "kvlcc2", "variant": "shallow", "terms": {"squat": None}}
    found = accelerations(ship, [0] * 6, nu, GROUND)
    assert found == pytest.approx(accelerations(same, [0] * 6, nu), rel=1e-9, abs=1e-15)
    deep = accelerations({"type": "kvlcc2"}, [0] * 6, nu)
    assert accelerations(ship, [0] * 6, nu) == pytest.approx(deep, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("depth", [22.5, 25.0, 30.0, 60.0])
def test_tanker_of_van_berlekom_and_goddard_reads_the_depth(depth):
    """Told of the ground it is the ship of that depth, whose derivatives are published (`test_vehicle_mss`)."""
    ship = {"type": "tanker", "variant": "shallow", "terms": {"squat": None}}
    fixed = {"type": "tanker", "added_mass": {"water_depth_m": depth}}
    found = accelerations(ship, [0, 0, 0.5, 0, 0, 0], NU, [[0, 0, -1.0, depth - 0.5]])
    assert found == pytest.approx(accelerations(fixed, [0, 0, 0.5, 0, 0, 0], NU), rel=1e-9, abs=1e-15)
    aground = accelerations(ship, [0] * 6, NU, [[0, 0, -1.0, 19.0]])
    assert aground == pytest.approx(accelerations(ship, [0] * 6, NU, [[0, 0, -1.0, 1.2 * 18.46]]), rel=1e-12)
    for shallow in (0.5, 0.8, 2.0):
        assert float(np.ravel(sway_in_shallow_water(np.float32(shallow)))[0]) == pytest.approx(
            sway_in_shallow_water(shallow), abs=1e-6
        )


def test_what_cannot_sink_is_refused():
    for kind, why in (
        ("remus100", "is under water, for which there is the term boundary"),
        ("quadrotor", "in the air"),
    ):
        with pytest.raises(ScenarioError, match=why):
            _ = pl.Vehicle.from_dict({"type": kind, "terms": {"s": {"type": "squat"}}}).model
    with pytest.raises(ScenarioError, match="floats, for which there are the terms bank and squat"):
        _ = pl.Vehicle.from_dict({"type": "kvlcc2", "terms": {"s": {"type": "boundary"}}}).model
    with pytest.raises(ScenarioError, match="a hull sinks once"):
        pl.Vehicle.from_dict({"type": "kvlcc2", "variant": "shallow", "terms": {"s": {"type": "squat"}}})
    shallow = {"draught_m": 10.0, "shallow_water": {"midship": 0.9}}
    with pytest.raises(ScenarioError, match=r"beam over draught is 5\.8; factors of depth are known up to 4"):
        _ = pl.Vehicle.from_dict({"type": "kvlcc2", "actuators": {"rudder": shallow}}).model
    with pytest.raises(CommandError, match=r"nor any of shallow water"):
        accelerations({"type": "kvlcc2"}, [0] * 6, NU, GROUND)


@pytest.mark.parametrize(("speed", "height"), [(0.0, 5.0), (0.3, 5.2), (-2.0, 9.0)])
def test_a_ship_that_has_fallen_dry_is_not_lifted(speed, height):
    """Ground 5 m below the origin and the surface as deep or deeper: no water, F at its largest, 0.7, or 0 at rest."""
    ship = {"type": "kvlcc2", "terms": {"squat": {"type": "squat"}}}
    nu = [speed, 0.2, -0.1, 0.001, -0.002, 0.003]
    found = force(ship, [0, 0, -height, 0, 0, 0.4], nu, [[0, 0, -1.0, 5.0]])
    square = 0.49 if speed else 0.0
    growth = 312600.0 / 320**2 * square / math.sqrt(1 - square)
    assert found[2] == pytest.approx(1.46 * growth * 1.68e8, rel=1e-6, abs=1.0)
    assert found[4] == pytest.approx(-growth / 320 * 1.26e12, rel=1e-6, abs=1e3)


def test_a_varied_squat_still_feels_the_ground():
    vehicle = pl.Vehicle.from_dict({"type": "kvlcc2", "terms": {"squat": {"type": "squat"}}})
    plain = pl.Vehicle.from_dict({"type": "kvlcc2"})
    assert varied(vehicle, {"squat": 1.2}).model.feels_planes
    assert not varied(plain, {"damping": 1.2}).model.feels_planes


def sail(ship, depth, seconds, helm_deg=0.0, *, speed, settle=0.0):
    """Track at 2 Hz: time, north, east, down, pitch, heading [deg], surge."""
    world = {"type": "flat", "depth_m": depth, "size_m": [30000, 30000]}
    start = {"position_m": [0, 0], "speed_mps": speed}
    scenario = {
        "tick_rate_hz": 2,
        "world": world,
        "agents": {"s": {"vehicle": ship, "control": "actuators", "start": start}},
    }
    sim = pl.Simulation.load(scenario)
    sim.reset(seed=0)
    rows = []
    for tick in range(round(2 * seconds)):
        sim.step({"s": [math.radians(helm_deg) if tick >= 2 * settle else 0.0]})
        state = sim.state["s"]
        _, pitch, yaw = state.euler[0]
        rows.append([sim.time_ns * 1e-9, *(state.position[0] * [1, -1, -1]), -pitch, -yaw, state.velocity[0, 0]])
    track = np.array(rows)
    track[:, 5] = np.degrees(np.unwrap(track[:, 5]))
    return track


def test_ship_under_way_sinks_by_the_formula():
    """The steady state in a world: a hull that is trimmed meets the water at an angle, which its heave damping
    (D u/K = 1.7 m/rad: 3 % of the sinkage) and its Munk moment (1 % of the trim) add to."""
    ship = {"type": "kvlcc2", "terms": {"squat": {"type": "squat"}}}
    end = sail(ship, 31.2, 240, speed=7.9)[-1]
    sinkage, trim = squat((1.46, 1.0), 312600.0, 320.0, end[6], 31.2, G)
    assert end[3] == pytest.approx(sinkage + 3.3e8 * end[6] * trim / 1.68e8, rel=5e-3)
    assert -end[4] == pytest.approx(trim, rel=0.02)
    assert end[3] > 0.9  # m


@pytest.mark.slow  # 8 s
def test_tanker_turns_wider_as_trials_found():
    """Helm 35 deg; of the Esso Osaka, a tanker of 325 m, in trials at depths of 4.2, 1.5 and 1.2 draughts, the tactical
    diameter grew by 18 and 74 %, the transfer by 19 and 88 % (C. L. Crane, Trans. SNAME 87:251, 1979)."""
    found = []
    for ratio, seconds in ((4.2, 900), (1.5, 1000), (1.2, 1400)):
        track = sail({"type": "kvlcc2", "variant": "shallow"}, 20.8 * ratio, seconds, 35.0, speed=7.0, settle=300)
        part = track[600:]
        measures = turning_measures(part[:, 0], part[:, 1], part[:, 2], part[:, 5], ordered_s=300.0, length_m=320.0)
        found.append([next(m.value for m in measures if m.name == name) for name in ("tactical diameter", "transfer")])
    growth = np.array(found)[1:] / found[0]
    assert growth[0] == pytest.approx([1.18, 1.19], abs=0.2)
    assert growth[1] == pytest.approx([1.74, 1.88], abs=0.25)
