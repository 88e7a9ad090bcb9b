"""What any correct simulator must do, from closed forms; known mistakes elsewhere are excluded."""

from __future__ import annotations

import numpy as np
import pytest
from vehicle_flight import Shear, Still, fly, quaternion

import pelagos as pl
from pelagos import jit
from pelagos.hydro.crossflow import hoerner_drag_coefficient
from pelagos.vehicles.varied import varied
from pelagos.vehicles.vehicle import Vehicle

BALL = {
    "type": "custom",
    "density_kg_m3": 1025.0,
    "length_m": 0.2,
    "diameter_m": 0.2,
    "default_mode": "wrench",
    "modes": {"wrench": {"type": "wrench"}},
}


def ball(added, mass=2.0, **more):
    half = 1025 * 2 / 3 * np.pi * 1e-3
    data = {
        **BALL,
        "mass": {
            "type": "explicit",
            "mass_kg": mass,
            "inertia_kg_m2": [0.01] * 3,
            "volume_m3": 4 / 3 * np.pi * 1e-3,
        },
        "added_mass": {"type": "diagonal", "diagonal": [half, half, half, 0, 0, 0] if added is None else added},
        **more,
    }
    return Vehicle.from_dict(data)


def ideal(**more):
    """A neutral body in ideal fluid with full, coupled added mass and centre of gravity off the origin."""
    return Vehicle.from_dict({
        "type": "custom",
        "density_kg_m3": 1000.0,
        "length_m": 2.0,
        "diameter_m": 0.4,
        "mass": {
            "type": "explicit",
            "mass_kg": 100.0,
            "inertia_kg_m2": [3.0, 30.0, 31.0],
            "products_of_inertia_kg_m2": [0.1, -0.4, 0.2],
            "center_of_gravity_m": [0.05, 0.01, 0.03],
        },
        "added_mass": {
            "type": "matrix",
            "matrix": [
                [10, 0, 0, 0, 1, 0],
                [0, 90, 0, -1, 0, 4],
                [0, 0, 95, 0, -5, 0],
                [0, -1, 0, 0.5, 0, 0],
                [1, 0, -5, 0, 28, 0],
                [0, 4, 0, 0, 0, 27],
            ],
        },
        "modes": {"wrench": {"type": "wrench"}},
        "default_mode": "wrench",
        **more,
    })  # fmt: skip


def test_sphere_released_at_rest():
    """First acceleration g (rho V - m)/(m + rho V/2) = 5.4258 m/s^2 upwards, in the very first step."""
    vehicle = ball(None, terms={"restoring": {"type": "submerged"}})
    flight = fly(vehicle, 0.001, h=0.001)
    assert -flight.nu[1, 2] / 0.001 == pytest.approx(5.4258, abs=1e-4)


def test_added_mass_differs_by_axis_and_acts_in_the_first_step():
    """F/(m + m_a) on each axis (not: the mean of the axes, nor a force that lags by a step)."""
    vehicle = ball([1.0, 4.0, 9.0, 0, 0, 0])
    for axis, added in enumerate((1.0, 4.0, 9.0)):
        force = [0.0] * 6
        force[axis] = 5.0
        flight = fly(vehicle, 0.002, h=0.002, command=force)
        assert flight.nu[1, axis] / 0.002 == pytest.approx(5.0 / (2.0 + added), rel=1e-12)


def test_munk_moment_of_the_remus_hull():
    """-(M_A22 - M_A11) u v = -11.4395 N m in yaw with the full added-mass Coriolis matrix; none as published."""
    full = Vehicle.from_catalogue("remus100", coriolis={"without": []})
    for vehicle, moment in ((full, -11.4395), (Vehicle.from_catalogue("remus100"), 0.0)):
        from pelagos import jit
        from pelagos.vehicles.flow import make_flow

        nu = [jit.Float64(x) for x in (2.0, 0.2, 0, 0, 0, 0)]
        eye = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        load = vehicle.model.inertia.coriolis(make_flow([0.0] * 3, eye, nu, (0.0, 0.0, 0.0)))
        assert float(jit.Float64(load[5])[0]) == pytest.approx(moment, abs=1e-4)


def test_energy_and_momentum_in_ideal_fluid():
    """No drag, any added mass, 60 s: energy and world momentum keep to 1e-6 with Runge-Kutta 4."""
    vehicle = ideal(integrator="runge_kutta")
    body = vehicle.config.body
    flight = fly(vehicle, 60.0, h=0.02, nu=(1.0, 0.3, -0.2, 0.3, 0.2, -0.25))
    energy = 0.5 * np.einsum("ti,ij,tj->t", flight.nu, body.mass_matrix, flight.nu)
    assert np.abs(energy / energy[0] - 1).max() < 1e-6
    w, x, y, z = flight.attitude.T
    momentum = flight.nu @ body.mass_matrix[:3].T
    axis = np.stack([x, y, z], -1)
    turned = momentum + 2 * np.cross(axis, np.cross(axis, momentum) + w[:, None] * momentum)
    assert np.abs(turned - turned[0]).max() < 1e-6 * np.linalg.norm(turned[0])


@pytest.mark.parametrize("h", [0.005, 0.02, 0.05])
def test_energy_in_ideal_fluid_with_the_default_integrator(h):
    """Coriolis forces do no work in a step, whatever its length: energy keeps to rounding, 60 s of tumbling."""
    vehicle = ideal()
    flight = fly(vehicle, 60.0, h=h, nu=(1.0, 0.3, -0.2, 0.3, 0.2, -0.25))
    energy = 0.5 * np.einsum("ti,ij,tj->t", flight.nu, vehicle.config.body.mass_matrix, flight.nu)
    assert np.abs(energy / energy[0] - 1).max() < 1e-12
    assert np.ptp(flight.nu[:, 5]) > 0.1


@pytest.mark.parametrize("name", ["remus100", "otter", "hovering_auv"])
def test_energy_of_catalogue_vehicles_without_forces(name):
    """The same with the published forms of C: without the Munk moments, and without linear velocity."""
    bare = Vehicle.from_catalogue(name)
    terms = dict.fromkeys(bare.config.terms)
    vehicle = Vehicle.from_catalogue(name, terms=terms, integrator="conservative")
    flight = fly(vehicle, 60.0, h=0.02, mode="wrench", nu=(1.0, 0.3, -0.2, 0.2, 0.1, -0.15))
    energy = 0.5 * np.einsum("ti,ij,tj->t", flight.nu, vehicle.config.body.mass_matrix, flight.nu)
    assert np.abs(energy / energy[0] - 1).max() < 1e-6


def test_stable_while_tumbling_at_50_ms_with_five_times_the_mass():
    """Full, unequal added mass up to five times the mass, no drag at all, ten minutes: bounded by its energy."""
    vehicle = ball([10.0, 2.0, 6.0, 0.05, 0.01, 0.03])
    flight = fly(vehicle, 600.0, h=0.05, nu=(1.0, 0.5, 0.2, 2.0, 0.2, 0.1))
    energy = 0.5 * np.einsum("ti,ij,tj->t", flight.nu, vehicle.config.body.mass_matrix, flight.nu)
    assert np.abs(energy / energy[0] - 1).max() < 1e-11


@pytest.mark.parametrize("integrator", ["conservative", "semi_implicit", "runge_kutta"])
def test_stable_at_50_ms_with_five_times_the_mass(integrator):
    drag = {"drag": {"type": "quadratic_damping", "diagonal": [2, 2, 2, 0.02, 0.02, 0.02]}}
    vehicle = ball([10.0, 10.0, 10.0, 0.05, 0.05, 0.05], integrator=integrator, terms=drag)
    flight = fly(vehicle, 300.0, h=0.05, nu=(1.0, 0.5, 0.2, 0.5, 0.2, 0.1), command=(1.0, 0, 0, 0, 0, 0.001))
    assert np.isfinite(flight.nu).all()
    assert np.linalg.norm(flight.nu[:, :3], axis=1).max() < 1.2  # drag alone limits a push of 1 N to 0.71 m/s


@pytest.mark.parametrize("name", ["remus100", "torpedo", "bluerov2_heavy", "hovering_auv", "lrauv"])
def test_a_neutral_vehicle_drifts_with_the_current(name):
    """1 m/s of uniform current: the drift reaches 1 m/s, and at the current's speed no force acts."""
    vehicle = Vehicle.from_catalogue(name)
    c = vehicle.config
    if name == "bluerov2_heavy":
        vehicle = Vehicle.from_catalogue(name, mass={"volume_m3": c.mass.mass_kg / c.density_kg_m3})
    ocean = Still((0.6, -0.8, 0.0))
    flight = fly(vehicle, 1200.0, h=0.05, mode="wrench", ocean=ocean)
    speed = np.diff(flight.position[-2:], axis=0)[0] / 0.05
    assert np.hypot(*speed[:2]) == pytest.approx(1.0, abs=0.02)
    carried = fly(vehicle, 5.0, h=0.05, mode="wrench", ocean=ocean, nu=(0.6, 0.8, 0, 0, 0, 0))
    assert np.abs(carried.nu[-1] - carried.nu[0]).max() < 1e-9


def test_a_sheared_current_turns_a_hull_as_strip_theory_says():
    """A sideways current that grows along the hull acts as a yaw rate of the opposite sign: the same cross-flow moment.

    At rest in shear s the first yaw acceleration is that of a hull turning at r = -s in still water, without the
    linear damping and Coriolis forces that a turning hull also has.
    """
    only = {"damping": None, "lift_drag": None, "restoring": None}
    vehicle = Vehicle.from_catalogue("remus100", terms=only)
    s = 0.2
    in_shear = fly(vehicle, 0.01, h=0.01, mode="wrench", ocean=Shear(s), position=(0, 0, 50))
    turning = fly(vehicle, 0.01, h=0.01, mode="wrench", nu=(0, 0, 0, 0, 0, s), position=(0, 0, 50))
    # Shear(s): the water's west velocity grows northwards, which in NED is an eastward velocity of -s x
    assert in_shear.nu[1, 5] == pytest.approx(turning.nu[1, 5] - s, rel=1e-9)
    assert in_shear.nu[1, 5] < 0


def test_terminal_speeds_of_both_bluerov2_sets():
    """50 N (10 N m) against linear and quadratic drag, d u + q u^2 = F, net buoyancy removed."""
    for variant, expected in ((None, (0.5489, 0.4800, 0.4334, 2.5820)), ("wu_2018", (1.5513, 1.3825, 1.0947, 2.5175))):
        vehicle = Vehicle.from_catalogue("bluerov2_heavy", **({"variant": variant} if variant else {}))
        net = vehicle.model.terms["restoring"].weight - vehicle.model.terms["restoring"].buoyancy
        for axis, speed in zip((0, 1, 2, 5), expected, strict=True):
            wrench = [0.0] * 6
            wrench[axis] = 10.0 if axis == 5 else 50.0
            flight = fly(vehicle, 40.0, h=0.05, mode="wrench", command=wrench, force=(0, 0, -net))
            assert flight.nu[-1, axis] == pytest.approx(speed, abs=1e-4)


def test_net_buoyancy_of_von_benzons_set():
    """-0.982 N in 1000 kg/m^3 (it sinks), +2.439 N in 1026."""
    for density, net in ((1000.0, -0.982), (1026.0, 2.439)):
        term = Vehicle.from_catalogue("bluerov2_heavy", density_kg_m3=density).model.terms["restoring"]
        assert term.buoyancy - term.weight == pytest.approx(net, abs=2e-3)


@pytest.mark.parametrize(("rpm", "speed"), [(1525, 2.5536), (800, 1.3383)])
def test_steady_speed_of_the_remus(rpm, speed):
    flight = fly(Vehicle.from_catalogue("remus100"), 200.0, h=0.05, mode="actuators", command=(0, 0, rpm))
    assert flight.nu[-1, 0] == pytest.approx(speed, abs=2e-4)


def test_speed_of_the_lrauv_in_four_headings():
    """300 rpm from rest: 1.0 +- 0.06 m/s, the same in four headings, attitude unchanged (osrf/lrauv)."""
    vehicle = Vehicle.from_catalogue("lrauv")
    for yaw in (0.0, 1.57, 3.14, -1.57):
        flight = fly(vehicle, 120.0, h=0.05, mode="actuators", command=(0, 0, 300, 0, 0), attitude=quaternion(yaw=yaw))
        assert flight.nu[-1, 0] == pytest.approx(1.0, abs=0.06)
        assert np.abs(flight.euler[-1] - (0, 0, yaw)).max() < 0.01


def test_trim_of_the_lrauv_by_its_moving_mass():
    """tan(pitch) = -m x/(M z_g)."""
    flight = fly(Vehicle.from_catalogue("lrauv"), 600.0, h=0.05, mode="actuators", command=(0, 0, 0, 0.01, 0))
    assert np.tan(flight.euler[-1, 1]) == pytest.approx(-31.7307 * 0.01 / (147.8671 * 0.006794), rel=0.01)


def test_roll_period_of_the_remus():
    """w = sqrt(W BG / M44') of small, undamped roll; sway is free, which stiffens M44 by the coupling m z_g."""
    vehicle = Vehicle.from_catalogue("remus100", terms={"damping": None, "lift_drag": None, "cross_flow": None})
    flight = fly(vehicle, 10.0, h=0.002, mode="wrench", attitude=quaternion(roll=0.05))
    rolls = flight.euler[:, 0]
    crossings = flight.t[1:][(rolls[:-1] > 0) & (rolls[1:] <= 0)]
    m = vehicle.config.body.mass_matrix
    stiffened = m[3, 3] - m[1, 3] ** 2 / m[1, 1]
    period = 2 * np.pi / np.sqrt(vehicle.config.body.weight * 0.02 / stiffened)
    assert np.diff(crossings).mean() == pytest.approx(period, rel=5e-3)


def test_heave_period_of_the_wamv():
    vehicle = Vehicle.from_catalogue("wamv", terms={"linear_damping": {"diagonal": [51.3, 40, 0, 500, 1100, 400]}})
    flight = fly(vehicle, 10.0, h=0.001, mode="wrench", position=(0, 0, 0.02))
    z = flight.position[:, 2]
    crossings = flight.t[1:][(z[:-1] > 0) & (z[1:] <= 0)]
    m = vehicle.config.body.mass_matrix[2, 2]
    assert np.diff(crossings).mean() == pytest.approx(2 * np.pi * np.sqrt(m / 32000), rel=2e-3)


@pytest.mark.parametrize("name", ["otter", "wamv", "surface_vessel"])
def test_surface_craft_at_rest_stay_at_rest(name):
    """Ten minutes in calm water after a small tilt: yaw and place stay bounded."""
    flight = fly(
        Vehicle.from_catalogue(name),
        600.0,
        h=0.05,
        mode="wrench",
        position=(0, 0, 0.02),
        attitude=quaternion(0.02, 0.01, 0),
    )
    assert np.abs(flight.euler[:, 2]).max() < 0.05
    assert np.abs(flight.position[:, :2]).max() < 0.3


def test_a_buoyant_vehicle_floats_at_the_surface():
    """It rises, and rests where the wet part of its hull carries its weight."""
    vehicle = Vehicle.from_catalogue("bluerov2_heavy", density_kg_m3=1026.0)
    flight = fly(vehicle, 200.0, h=0.02, mode="wrench", position=(0, 0, 2))
    share = vehicle.model.terms["restoring"].weight / vehicle.model.terms["restoring"].buoyancy
    zeta = (flight.position[-1, 2] - 0.01) / (0.254 / 2)
    assert (2 + 3 * zeta - zeta**3) / 4 == pytest.approx(share, abs=2e-3)


def test_glider_flies_a_sawtooth():
    """Between 20 and 120 m at 25 deg; speed by lift and drag within 5 % of the steady glide's."""
    vehicle = Vehicle.from_catalogue("glider")
    flight = fly(vehicle, 1500.0, h=0.05, command=(20.0, 120.0, np.deg2rad(25), 0.5))
    late = flight.t > 400
    assert flight.position[late, 2].max() == pytest.approx(123, abs=4)
    assert flight.position[late, 2].min() == pytest.approx(17, abs=4)
    steady = late & (np.abs(flight.euler[:, 1] + np.deg2rad(25)) < 0.01) & (flight.actuators[:, 0] < -2.49e-4)
    u, w = flight.nu[steady, 0].mean(), flight.nu[steady, 2].mean()
    alpha, square = np.arctan2(w, u), u * u + w * w
    weight = 1025 * 9.81 * 0.00025
    drag, lift = (2.15 + 25 * alpha**2) * square, 132.5 * alpha * square
    glide = np.deg2rad(25) + alpha
    assert drag == pytest.approx(weight * np.sin(glide), rel=0.05)
    assert lift == pytest.approx(weight * np.cos(glide), rel=0.05)
    assert np.abs(np.angle(np.exp(1j * (flight.euler[late, 2] - 0.5)))).max() < 0.1


def test_mariner_accelerations_equal_its_derivatives():
    """The published equations written out by hand at one state (deviations u, v, r, rudder d), non-dimensional."""
    vehicle = Vehicle.from_catalogue("mariner")
    length, u0, total = 160.93, 7.7175, np.hypot(7.0, -0.5)
    u, v, r, d = (7.0 - u0) / total, -0.5 / total, 0.01 * length / total, -0.3
    x = -184 * u - 110 * u**2 - 215 * u**3 - 899 * v**2 + 18 * r**2 + 798 * r * v - 95 * d**2 - 190 * u * d**2
    x += 93 * v * d + 93 * u * v * d
    y = -1160 * v - 499 * r - 8078 * v**3 + 15356 * v**2 * r - 1160 * v * u - 499 * r * u + 278 * d - 90 * d**3
    y += 556 * u * d + 278 * u**2 * d - 4 * v * d**2 + 1190 * v**2 * d - 4 - 8 * u - 4 * u**2
    n = -264 * v - 166 * r + 1636 * v**3 - 5483 * v**2 * r - 264 * v * u - 166 * r * u - 139 * d + 45 * d**3
    n += -278 * u * d - 139 * u**2 * d + 13 * v * d**2 - 489 * v**2 * d + 3 + 6 * u + 3 * u**2
    m = np.array([[798 + 748, -0.023 * 798 + 9.354], [-0.023 * 798 - 4.646, 39.2 + 43.8]])
    sway, yaw = np.linalg.solve(m, [y, n])
    nu_dot, _ = vehicle.accelerations([[0] * 6], [[7.0, -0.5, 0, 0, 0, 0.01]], [[0.3]], [[0.3]])
    scale = total**2 / length
    assert nu_dot[0, [0, 1, 5]] == pytest.approx([x / 840 * scale, sway * scale, yaw * scale / length], rel=1e-6)


def test_the_mariners_engine_works_from_rest_to_the_service_speed_and_stays_there():
    """Constant power: from rest, helm against the wheel's sway (Y0), to the service speed of 7.7175 m/s within 2 %.

    By hand: m u' = rho/2 L^2 U0^2 (Xu u' + Xuu u'^2 + Xuuu u'^3) has its only root at u' = 0, where its slope Xu < 0.
    """
    roots = np.roots([-0.00215, -0.0011, -0.00184, 0.0])
    assert np.isreal(roots).sum() == 1
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 10,
            "world": {"type": "flat", "depth_m": 200, "size_m": [40000, 40000]},
            "agents": {"it": {"vehicle": "mariner", "start": {"position_m": [0, 0]}}},
        }
    )
    speeds = []
    for _ in range(6):
        sim.step({"it": np.array([0.0])}, ticks=1500)
        speeds.append(float(sim.state["it"].velocity[0, 0]))
    assert (np.diff(speeds) > -0.02).all()
    assert speeds[0] > 3
    assert speeds[-1] == pytest.approx(7.7175, rel=0.02)


def test_mariner_turning_circle_within_imo():
    """35 deg of helm at 15 knots: advance below 4.5 L to both sides, tactical diameter below 5 L to starboard
    (IMO MSC.137(76)); to port the derivatives' own asymmetry (Y0, N0) makes it 5.2 L."""
    vehicle, length = Vehicle.from_catalogue("mariner"), 160.93
    for side, limit in ((1, 5.0), (-1, 5.25)):
        helm, nu = side * np.deg2rad(35), (7.7175, 0, 0, 0, 0, 0)
        flight = fly(vehicle, 600.0, h=0.1, mode="actuators", command=(helm,), nu=nu, position=(0, 0, 0))
        turned = side * np.unwrap(flight.euler[:, 2])
        quarter, half = np.argmax(turned >= np.pi / 2), np.argmax(turned >= np.pi)
        assert 3.0 < flight.position[quarter, 0] / length < 4.5
        assert 4.0 < side * flight.position[half, 1] / length < limit
        assert np.sign(flight.nu[-1, 5]) == side
        assert np.sign(flight.nu[-1, 1]) == -side  # drifts outwards


def test_mariner_zig_zag_within_imo():
    """10/10 zig-zag at 15 knots, L/V = 20.9 s: first overshoot below (5 + L/V/2) = 15.4 deg (IMO MSC.137(76))."""
    vehicle = Vehicle.from_catalogue("mariner")
    helm, nu, position = np.deg2rad(10), (7.7175, 0, 0, 0, 0, 0), (0, 0, 0)
    state = {"attitude": quaternion(), "actuators": (0.0,)}
    overshoots = []
    for _ in range(3):
        flight = fly(vehicle, 200.0, h=0.1, mode="actuators", command=(helm,), nu=nu, position=position, **state)
        yaw = np.unwrap(flight.euler[:, 2])
        at = int(np.argmax(np.sign(helm) * yaw >= np.deg2rad(10)))
        assert at > 0
        nu, position = flight.nu[at], flight.position[at]
        state = {"attitude": flight.attitude[at], "actuators": flight.actuators[at]}
        back = fly(vehicle, 60.0, h=0.1, mode="actuators", command=(-helm,), nu=nu, position=position, **state)
        overshoots.append(np.rad2deg((np.sign(helm) * np.unwrap(back.euler[:, 2])).max()) - 10)
        helm = -helm
    assert 0 < overshoots[0] < 15.4
    assert 0 < overshoots[1] < 15.4 + 15


@pytest.mark.parametrize(("height", "beam"), [(0.3, 0.9), (0.8, 0.35)])
def test_sections_meet_the_flow_with_hoerner_s_drag(height, beam):
    """rho/2 L T C(B/2T) v|v| from the side, rho/2 L B C(T/2B) w|w| from below: a section turned by a right angle."""
    shape = {"length_m": 2.0, "beam_m": beam, "height_m": height, "density_kg_m3": 1000.0}
    mass = {"type": "explicit", "mass_kg": 100.0, "inertia_kg_m2": [3.0, 30.0, 31.0]}
    wrench = {"modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench"}
    terms = {"terms": {"drag": {"type": "cross_flow"}}, "added_mass": {"type": "diagonal", "diagonal": [0.0] * 6}}
    vehicle = Vehicle.from_dict({"type": "custom", **shape, "mass": mass, **wrench, **terms})
    for axis, along, across, v in ((1, height, beam, -0.7), (2, beam, height, 0.9)):
        nu = np.zeros(6)
        nu[axis] = v
        slowed = fly(vehicle, 1e-4, h=1e-4, nu=nu).nu[1, axis] - v
        force = 500.0 * 2.0 * along * hoerner_drag_coefficient(across, along) * v * abs(v)
        assert slowed / 1e-4 == pytest.approx(-force / 100.0, rel=1e-3)  # it slows down within the step


@pytest.mark.parametrize("integrator", ["conservative", "semi_implicit", "runge_kutta"])
def test_a_heavier_copy_accelerates_as_a_heavier_vehicle(integrator):
    """A factor of 1.7 on the mass is a mass and an inertia of 1.7 times that, the added mass as it was."""
    more = {"integrator": integrator, "added_mass": {"type": "diagonal", "diagonal": [1.1, 2.3, 2.9, 0.01, 0.02, 0.03]}}
    light, heavy = ({"type": "explicit", "mass_kg": m, "inertia_kg_m2": [m / 80, m / 50, m / 40]} for m in (2.0, 3.4))
    push = {"force": (3.0, -2.0, 1.0), "moment": (0.2, -0.1, 0.3), "h": 0.01}
    expected = fly(Vehicle.from_dict({**BALL, **more, "mass": heavy}), 0.1, **push)
    copy = varied(Vehicle.from_dict({**BALL, **more, "mass": light}), {"mass": jit.Float64(1.7)})
    assert fly(copy, 0.1, **push).nu == pytest.approx(expected.nu, abs=1e-12)
    assert np.abs(expected.nu[-1]).min() > 0.01
