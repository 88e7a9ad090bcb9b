"""Signs, factors and axes of forces and control laws of vehicles: closed forms, inputs of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro.added_mass import spheroid
from pelagos.hydro.crossflow import crossflow
from pelagos.math.constants import GRAVITY
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sim.collisions import Collisions
from pelagos.sim.guidance.guidance import shifted
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.initial import _position, _surface
from pelagos.vehicles.actuators.fin import FinConfig
from pelagos.vehicles.actuators.flap import FlapConfig
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.actuators.ship import ShipRudderConfig
from pelagos.vehicles.actuators.t200 import PULSES, VOLTAGES, T200Config, measured
from pelagos.vehicles.actuators.thruster import QuadraticCurve
from pelagos.vehicles.control.heading_thrust import HeadingThrust
from pelagos.vehicles.control.multirotor import MultirotorConfig
from pelagos.vehicles.control.pose import world_pose
from pelagos.vehicles.control.sawtooth import SawtoothConfig
from pelagos.vehicles.drift import Drift
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.heading_table import HeadingTable
from pelagos.vehicles.terms.air import Wing

BODY = SimpleNamespace(density=1000.0, length=100.0)


def numbers(values) -> np.ndarray:
    return np.array([float(np.array(v).ravel()[0]) for v in values])


def flow(nu=(0.0,) * 6, position=(0.0, 0.0, 0.0), euler=(0.0, 0.0, 0.0)) -> Flow:
    """Through still water, at an attitude roll, pitch, yaw [rad] of NED."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(euler), np.sin(euler)
    rotation = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    speeds = [jit.Float64(float(v)) for v in nu]
    place = [jit.Float64(float(v)) for v in position]
    turned = [[jit.Float64(float(c)) for c in row] for row in rotation]
    return Flow(place, place[2], turned, speeds, speeds, [jit.Float64(0.0)] * 6)


@pytest.mark.parametrize(("a", "b"), [(0.7, 0.5), (2.0, 0.3)])
def test_a_spheroid_that_pitches_has_lambs_inertia(a: float, b: float) -> None:
    """H. Lamb, Hydrodynamics (1932), Articles 114 and 115: k' of the displaced water's (a^2 + b^2)/5."""
    e = math.sqrt(1 - (b / a) ** 2)
    log = math.log((1 + e) / (1 - e))
    alpha, beta = 2 * (1 - e * e) / e**3 * (log / 2 - e), 1 / e**2 - (1 - e * e) / (2 * e**3) * log
    rotary = e**4 * (beta - alpha) / ((2 - e * e) * (2 * e * e - (2 - e * e) * (beta - alpha)))
    expected = rotary * 4 / 15 * math.pi * 1000 * a * b * b * (a * a + b * b)
    assert spheroid(1000.0, a, b)[4, 4] == pytest.approx(expected, rel=1e-9)
    assert spheroid(1000.0, a, b)[5, 5] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("rate", [0.6, -0.35])
def test_crossflow_in_heave_and_pitch_is_that_in_sway_and_yaw_on_its_side(rate: float) -> None:
    """Rolled by 90 degrees sway becomes heave, and a turn to starboard one bow down: a strip at x moves by w - x q."""
    places = tuple(np.linspace(-0.9, 1.1, 9).tolist())
    nu = [jit.Float64(v) for v in (0.0, 0.3, 0.3, 0.0, -rate, rate)]
    x, y, z, k, m, n = numbers(crossflow((jit.Float64(-7.0), jit.Float64(-7.0)), places, nu, heave=True))
    assert abs(n) > 0.1
    assert (x, k) == (0.0, 0.0)
    assert (z, m) == pytest.approx((y, -n), rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_aeroplane_has_the_moments_of_its_published_derivatives(sign: float) -> None:
    """R. W. Beard, T. W. McLain, equations 4.5 and 4.14 to 4.16, about 22 m/s with sideslip and angle of attack."""
    wing = next(t for t in pl.Vehicle.from_catalogue("fixed_wing").model.terms.values() if isinstance(t, Wing))
    c, u, v, w, p, q, r = wing.config, 22.0, 1.7 * sign, 0.9 * sign, 0.3 * sign, -0.2 * sign, 0.4 * sign
    found = numbers(wing.wrench(flow((u, v, w, p, q, r))))
    speed = math.sqrt(u * u + v * v + w * w)
    alpha, beta = math.atan2(w, u), math.asin(v / speed)
    load = 0.5 * wing.density * speed**2 * c.area_m2
    b, chord = c.span_m / (2 * speed), c.chord_m / (2 * speed)
    assert found[1] == pytest.approx(load * c.C_Yb * beta, rel=1e-6)
    assert found[3] == pytest.approx(load * c.span_m * (c.C_lb * beta + c.C_lp * b * p + c.C_lr * b * r), rel=1e-6)
    assert found[4] == pytest.approx(load * c.chord_m * (c.C_m0 + c.C_ma * alpha + c.C_mq * chord * q), rel=1e-6)
    assert found[5] == pytest.approx(load * c.span_m * (c.C_nb * beta + c.C_np * b * p + c.C_nr * b * r), rel=1e-6)


@pytest.mark.parametrize(("angle", "place"), [(0.0, (0.2, 0.0)), (270.0, (0.0, -0.2)), (30.0, (0.17320508, 0.1))])
def test_a_fin_stands_where_its_axis_points(angle: float, place: tuple[float, float]) -> None:
    keys = {"area_m2": 0.01, "lift_coefficient": 3.0, "limit_deg": 20, "time_constant_s": 0.1}
    fin = FinConfig(type="fin", angle_deg=angle, x_m=-0.7, radius_m=0.2, **keys).build(BODY)
    assert numbers(fin.place) == pytest.approx([-0.7, *place], abs=1e-8)


def test_a_flap_lifts_upwards() -> None:
    """Effect of 1 rad over the dynamic pressure: lift is against z, which points down."""
    keys = {"area_m2": 0.5, "span_m": 3.0, "chord_m": 0.2, "limit_deg": 20, "time_constant_s": 0.1}
    flap = FlapConfig(type="flap", C_L=0.4, C_Y=-0.3, C_l=0.2, C_m=-1.1, C_n=0.05, **keys)
    effect = flap.build(SimpleNamespace(density=1.2)).effect
    assert numbers(effect) == pytest.approx(0.3 * np.array([0, -0.3, -0.4, 0.6, -0.22, 0.15]), rel=1e-12)


@pytest.mark.parametrize("helm", [0.3, -0.2])
def test_a_ships_rudder_by_its_derivatives(helm: float) -> None:
    """Force by rho/2 L^2 U^2, moment by rho/2 L^3 U^2; the rudder's angle is minus the helm; r' = r L/U."""
    derivatives = {"Yd": 0.27, "Nd": -0.13, "Nr": -0.05, "Xdd": -0.09, "Xu": -0.02}
    keys = {"limit_deg": 35, "rate_deg_s": 3, "time_constant_s": 1}
    ship = ShipRudderConfig(type="ship_rudder", service_speed_m_s=8.0, derivatives=derivatives, **keys).build(BODY)
    x, y, _, _, _, n = numbers(ship.wrench(jit.Float64(helm), flow((6.0, 0.4, 0, 0, 0, 0.02))))
    scale = 0.5 * 1000 * 100**2 * 8.0**2
    assert x == pytest.approx(scale * (-0.02 * (6 - 8) / 8 - 0.09 * helm**2), rel=1e-9)
    assert y == pytest.approx(scale * 0.27 * -helm, rel=1e-9)
    assert n == pytest.approx(scale * 100 * (-0.13 * -helm - 0.05 * 0.02 * 100 / 8), rel=1e-9)


@pytest.mark.parametrize("thrust", [0.8, -0.8, 6.0, -15.0, 30.0])
def test_a_t200_gives_the_thrust_that_it_is_asked_for(thrust: float) -> None:
    """By the maker's table at 16 V [kgf]; the fitted inverse is off by at most 0.4 N in 50 N."""
    unit = T200Config(type="t200", position_m=(0, 0, 0), direction=(1, 0, 0), time_constant_s=0.1).build(BODY)
    throttle = float(np.array(unit.command(jit.Float64(thrust)))[0])
    rows = measured()[VOLTAGES.index(16.0)]
    assert np.interp(throttle, np.linspace(-1, 1, PULSES), rows[:, 5] * GRAVITY) == pytest.approx(thrust, abs=0.4)


def test_speeds_and_thrusts_are_inverse_ahead_and_astern() -> None:
    curve = QuadraticCurve(jit.Float64(0.04), jit.Float64(0.013))
    for thrust in (3.0, -2.0):
        assert float(np.array(curve.thrust(curve.speed(jit.Float64(thrust))))[0]) == pytest.approx(thrust, rel=1e-12)


@pytest.mark.parametrize("command", [5.0, -5.0])
def test_a_slow_actuator_moves_by_its_rate_in_a_step(command: float) -> None:
    lag = Lag(0.1, -1.0, 1.0, rate_limit=0.4)
    moved = lag.advanced(jit.Float64(0.2), jit.Float64(command), jit.Float64(0.05))
    assert float(np.array(moved)[0]) == pytest.approx(0.2 + math.copysign(0.4 * 0.05, command), rel=1e-9)


def test_a_pose_in_the_world_is_mirrored_in_y_and_z() -> None:
    found = numbers(world_pose(flow(position=(3.0, -4.0, 5.0), euler=(0.1, -0.2, 0.7))))
    assert found == pytest.approx([3.0, 4.0, -5.0, 0.1, 0.2, -0.7], abs=1e-12)


@pytest.mark.parametrize("v", [(0.5, -0.3, 0.2), (-0.4, 0.6, -0.1)])
def test_a_multirotor_brakes_with_its_damping_ratio(v: tuple[float, float, float]) -> None:
    """x'' = w^2 e - 2 zeta w x': a speed v asks for what an error of -2 zeta v / w does."""
    config = MultirotorConfig(type="multirotor", frequency_rad_s=1.5, turn_frequency_rad_s=12.0, ratio=0.8)
    plain = pl.Vehicle.from_catalogue("quadrotor")
    body = plain.config.body
    law = config.build(SimpleNamespace(body=body, model=plain.model))
    still, instant = [jit.Float64(0.0)] * 3, jit.Float64(1e-9)
    goal = [jit.Float64(0.0)] * 4
    moving = law.act(still, flow((*v, 0, 0, 0)), goal, instant)[0]
    away = law.act(still, flow(position=tuple(2 * 0.8 * x / 1.5 for x in v)), goal, instant)[0]
    one, other = (numbers(d.actuators.values()) for d in (moving, away))
    assert np.ptp(one) > 0
    assert one == pytest.approx(other, rel=1e-6)


def test_shared_thrust_makes_the_wrench_that_is_asked_for() -> None:
    """Thrusters ahead of equal coefficient: surge force and yaw moment of all together, of both signs."""
    vehicle = pl.Vehicle.from_catalogue("otter", modes={"heading": {"allocation": "forward_coefficient"}})
    law = vehicle.controllers["heading"]
    assert isinstance(law, HeadingThrust)
    for surge, yaw in ((90.0, 12.0), (90.0, -12.0)):
        wrench = [jit.Float64(v) for v in (surge, 0.0, 0.0, 0.0, 0.0, yaw)]
        total = np.zeros(6)
        for name, speed in law._share(wrench).items():
            part = law.allocation.thrusters[name]
            total += numbers(part.effect) * numbers([part.curve.thrust(speed)])
        assert (total[0], total[5]) == pytest.approx((surge, yaw), rel=1e-6)


@pytest.mark.parametrize(("depth", "sign"), [(2.0, -1.0), (55.0, 1.0)])
def test_a_glider_takes_in_water_at_the_top_and_gives_it_off_at_the_bottom(depth: float, sign: float) -> None:
    names = {"buoyancy_engine": "b", "moving_mass": "m", "rudder": "r"}
    gains = {"kp_pitch_m": 0.1, "ki_pitch_m_s": 0.0, "mass_limit_m": 0.05, "kp_heading": 1, "kd_heading_s": 0}
    law = SawtoothConfig(type="sawtooth", volume_m3=0.001, rudder_limit_deg=20, **names, **gains).build(None)
    command = [jit.Float64(x) for x in (10.0, 50.0, 0.4, 0.0)]
    memory = [jit.Float64(sign), jit.Float64(0.0)]  # as it was: the other way
    demand, kept = law.act(memory, flow((0.3, 0, 0, 0, 0, 0), (0, 0, depth)), command, jit.Float64(0.1))
    assert numbers([demand.actuators["b"]])[0] == pytest.approx(sign * 0.001)
    assert numbers(kept)[0] == -sign


def test_a_glider_turns_its_trim_over_with_its_path() -> None:
    """What holds the pitch of a descent holds, mirrored, that of the ascent; a mass at its stop integrates nothing."""
    names = {"buoyancy_engine": "b", "moving_mass": "m", "rudder": "r"}
    gains = {"kp_pitch_m": 0.1, "ki_pitch_m_s": 0.02, "mass_limit_m": 0.05, "kp_heading": 1, "kd_heading_s": 0}
    law = SawtoothConfig(type="sawtooth", volume_m3=0.001, rudder_limit_deg=20, **names, **gains).build(None)
    command = [jit.Float64(x) for x in (10.0, 50.0, 0.4, 0.0)]

    def after(depth: float, sinking: float, integral: float) -> tuple[float, float]:
        memory = [jit.Float64(sinking), jit.Float64(integral)]
        demand, kept = law.act(memory, flow((0.3, 0, 0, 0, 0, 0), (0, 0, depth)), command, jit.Float64(0.1))
        return numbers([demand.actuators["m"]])[0], numbers(kept)[1]

    assert after(30.0, 1.0, 0.3) == pytest.approx((0.034, 0.3 - 0.1 * 0.4))  # level, bow to go down by 0.4 rad
    assert after(30.0, -1.0, 0.3) == pytest.approx((-0.046, 0.3 + 0.1 * 0.4))
    assert after(30.0, 1.0, -2.0) == pytest.approx((0.05, -2.0))
    assert after(55.0, 1.0, 0.3) == pytest.approx((-0.046, -0.3))
    assert after(5.0, -1.0, -0.7) == pytest.approx((0.05, 0.7))


def test_a_start_above_the_seabed() -> None:
    world = SimpleNamespace(height=lambda x, y: np.array([-30.0]) + 0.1 * x)
    start = SimpleNamespace(position_m=(20.0, -3.0), altitude_m=4.0, depth_m=None)
    assert _position(start, world, "") == pytest.approx([20.0, -3.0, -24.0])


def test_the_surface_under_a_hull_is_a_mean_along_it() -> None:
    """Of h = c x y over hulls heading psi: c sin cos (mean of beam places squared - that of length places), where c
    is of the hull's own copy.
    """
    agent = SimpleNamespace(vehicle=SimpleNamespace(config=SimpleNamespace(length_m=10.0, beam=3.0)))
    psi, copies = np.radians([30.0, -75.0, 110.0]), np.array([2, 0, 1], np.uint32)
    ocean = SimpleNamespace(
        elevation=lambda x, y, t, copy: (1 + jit.Float64(copy)) * x * y, wave_motion=lambda p, t, copy: None
    )
    height, velocity = _surface(agent, ocean, np.zeros((3, 3)), psi, copies)
    along, across = (np.mean((np.linspace(-0.4, 0.4, k) * size) ** 2) for k, size in ((9, 10.0), (3, 3.0)))
    assert height == pytest.approx((1 + copies) * np.sin(psi) * np.cos(psi) * (across - along), rel=1e-9)
    assert velocity.shape == (3, 3)
    assert (velocity == 0).all()


def test_set_points_move_with_the_estimates_error() -> None:
    """What a law sees as missing of the truth is what is missing of the estimate, in every channel."""
    truth = SimpleNamespace(own=SimpleNamespace(position=np.array([[3.0, -2.0, -9.0]]), heading=np.array([0.5])))
    known = SimpleNamespace(own=SimpleNamespace(position=np.array([[2.5, -1.2, -9.7]]), heading=np.array([0.8])))
    asked = {k: np.array([v]) for k, v in (("x", 9.0), ("y", 4.0), ("z", -5.0), ("depth", 12.0), ("upper_depth", 3.0))}
    asked |= {"height": np.array([6.0]), "heading": np.array([-1.0]), "yaw": np.array([1.0]), "speed": np.array([1.5])}

    def state(aboard) -> dict[str, float]:
        (x, y, z), heading = aboard.own.position[0], aboard.own.heading[0]
        return {
            "x": x,
            "y": y,
            "z": z,
            "depth": -z,
            "upper_depth": -z,
            "height": z,
            "heading": heading,
            "yaw": -heading,
        }

    got, true, seen = shifted(asked, known, truth), state(truth), state(known)
    for name in true:
        assert got[name][0] - true[name] == pytest.approx(asked[name][0] - seen[name], abs=1e-12), name
    assert got["speed"][0] == 1.5


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_turns_of_an_orbit_are_counted_the_way_it_goes(turn: float) -> None:
    """A compass bearing that grows is a clockwise turn: after 1.5 turns of two it goes on, after two it is done."""
    orbit = Orbit((10.0, -5.0), 20.0, 2.0, turn)
    progress = SimpleNamespace(memory=np.zeros((1, 3)))
    done = []
    for bearing in turn * np.radians(np.arange(0, 735, 5)):
        place = np.array([[10.0 + 20 * math.cos(bearing), -5.0 - 20 * math.sin(bearing)]])
        done.append(int(orbit.moves(SimpleNamespace(xy=place), progress)[0]))
    assert (done[108], done[-1]) == (0, 1)
    assert progress.memory[0, 2] == pytest.approx(math.radians(730), rel=1e-6)


def test_the_seabed_pushes_a_body_by_force_over_inertia() -> None:
    """Velocity after a tick on the ground: h M^-1 w, turned from forward-right-down to the world."""
    inverse = np.diag([0.5, 0.25, 0.2, 2.0, 1.0, 4.0])
    made = object.__new__(Collisions)
    made._inverse, made._bodies = {"a": inverse}, SimpleNamespace(bodies=[])
    row = np.array([[1.0, 2.0, -3.0, 1.0, 0, 0, 0, 0.1, -0.2, 0.3, 0.01, 0.02, -0.03]])
    wrench = np.array([[4.0, -8.0, 10.0, 1.0, -2.0, 0.5]])
    after = made._free({"a": row}, {}, {"a": wrench}, 0.05)
    found = np.concatenate([np.asarray(getattr(after, n))[0] for n in list(after.__dataclass_fields__)[2:4]])
    gained = 0.05 * np.diag(inverse) * [4.0, 8.0, -10.0, 1.0, 2.0, -0.5]
    assert found == pytest.approx(row[0, 7:13] + gained, abs=1e-12)


@pytest.mark.parametrize("aside", [35.0, 140.0])
def test_drift_forces_of_waves_from_port_mirror_those_from_starboard(aside: float) -> None:
    """Surge is the same, sway and yaw are opposite; the rows are what a wave of 1 m from starboard does."""
    rows = np.random.default_rng(3).uniform(0.5, 1.5, (6, 7, 3))
    drift, found = Drift(HeadingTable(rows, 0.4)), []
    heading = math.radians(25.0)
    for side in (1.0, -1.0):
        wave = {"type": "regular", "height_m": 2.0, "period_s": 5.0, "towards_deg": 25.0 + side * aside}
        waves = build_ocean(OceanConfig(waves=[wave], waves_depth_m=500.0)).waves
        x, y, t, cos, sin = (jit.Float64(v) for v in (3.0, -4.0, 2.5, math.cos(heading), math.sin(heading)))
        found.append(numbers(drift.push(waves, drift.rows.on_device(), x, y, (cos, sin), t)))
    assert (np.abs(found[0]) > 0.1).all()
    assert found[1] == pytest.approx(found[0] * [1, -1, -1], rel=1e-6)
