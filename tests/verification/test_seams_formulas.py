"""Small formulas by their closed forms: interpolation, columns of absorption, crossed arrays, control laws, fields."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy import signal
from scipy.spatial.transform import Rotation
from sonar_scenes import at, box, context

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.absorption import LAYERS, loss_column
from pelagos.acoustics.mills_cross import aberration, crossing, turned
from pelagos.math.interpolate import bilinear, triangulated
from pelagos.ocean.site import Site
from pelagos.ocean.tracer import (
    FrontFieldConfig,
    GradientFieldConfig,
    OscillationFieldConfig,
    PatchFieldConfig,
    ProfileFieldConfig,
    total,
)
from pelagos.optics.directions import about, off_matt
from pelagos.sensors.sonar.incidence_sonar import IncidenceSonar, IncidenceSonarConfig
from pelagos.vehicles.control.depth import DepthGains, DepthMemory, stern_plane
from pelagos.vehicles.control.heading import HeadingGains, HeadingMemory, rudder
from pelagos.vehicles.control.place import PlaceConfig, PlaceControl
from pelagos.vehicles.control.reference import ReferenceModel

RNG = np.random.default_rng(31)


def number(value: Any) -> float:
    return float(np.array(value).ravel()[0])


# grids


def test_bilinear_interpolation_keeps_products() -> None:
    """a + b x + c y + d x y is its own bilinear interpolant."""
    of = lambda x, y: 1.5 - 0.7 * x + 0.3 * y + 0.11 * x * y
    grid = of(np.arange(5.0)[:, None], np.arange(7.0)[None, :])
    i, j = RNG.uniform(0, 4, 50), RNG.uniform(0, 6, 50)
    assert bilinear(grid, i, j) == pytest.approx(of(i, j), rel=1e-12)
    assert np.isnan(bilinear(grid, np.array([-0.01, 4.01, 2.0, 2.0]), np.array([1.0, 1.0, -0.01, 6.01]))).all()


def test_triangles_meet_on_the_cells_diagonal() -> None:
    """On two triangles of a cell x y becomes the smaller of both, and what is linear stays."""
    plane = lambda x, y: 1.5 - 0.7 * x + 0.3 * y
    x, y = np.arange(5.0)[:, None], np.arange(7.0)[None, :]
    i, j = RNG.uniform(0, 4, 50), RNG.uniform(0, 6, 50)
    assert triangulated(plane(x, y), i, j) == pytest.approx(plane(i, j), rel=1e-12)
    u, v = RNG.uniform(0, 1, 20), RNG.uniform(0, 1, 20)
    assert triangulated(x[:2] * y[:, :2], u, v) == pytest.approx(np.minimum(u, v), rel=1e-12)


# columns of absorption


@pytest.mark.parametrize(("start", "end"), [(3, 11), (-9, 6), (-2, -16), (5, 16), (5, 5)])
def test_mean_absorption_of_a_way_through_a_linear_column(start: int, end: int) -> None:
    """Of b + g z over heights z1 to z2: b + g (z1 + z2)/2; places at two depths, ends on edges of layers."""
    depth = np.array([20.0, 47.0])
    place = jit.Array3f64(jit.Float64([1.0, -4.0]), jit.Float64([2.0, 7.0]), jit.Float64(-depth))
    rise = 64.0  # above and below
    column = loss_column(
        lambda p, t: 0.05 + 2e-3 * p.y + 4e-4 * p.z + 1e-3 * t, place, jit.Float64([3.0, -2.0]),
        lambda z: 0.0 * z - rise, lambda z: 0.0 * z + rise,
    )  # fmt: skip
    layer = 2 * rise / LAYERS
    ways = [jit.Float([k * layer] * 2) for k in (start, end)]
    level = 0.5 * layer if start == end else 0.0  # a level way lies in one layer, and hears its middle
    found = np.array(column.mean(jit.UInt32([0, 1]), *ways))
    expected = 0.05 + 4e-4 * (-depth + 0.5 * (start + end) * layer) + 1e-3 * np.array([3.0, -2.0])
    expected += 2e-3 * np.array([2.0, 7.0])
    assert found == pytest.approx(expected, abs=4e-4 * level + 2e-6)


# crossed line arrays


def test_crossed_cones_meet_where_both_angles_are_as_steered() -> None:
    """d.s = sin a, d.r = sin b, |d| = 1, below: for arrays at 83 degrees to one another, steered to both sides."""
    s = np.array([0.98, 0.05, 0.19])
    r = np.array([-0.08, 0.99, -0.06])
    s, r = s / np.linalg.norm(s), r / np.linalg.norm(r)
    for sent, heard in ((0.12, -0.55), (-0.2, 0.7), (0.05, 0.1)):
        vectors = (jit.Array3f(*map(float, v)) for v in (s, r))
        d = np.array(crossing(*vectors, jit.Float(sent), jit.Float(heard))).ravel()
        assert (d @ s, d @ r, d @ d) == pytest.approx((sent, heard, 1.0), abs=2e-6)
        assert d[2] < 0


@pytest.mark.parametrize("rotation", [(0.4, -1.1, 0.7), (-2e-5, 3e-5, 1e-5)])
def test_a_vector_turns_as_rodrigues_says(rotation: tuple[float, float, float]) -> None:
    v = (0.3, -0.8, 1.4)
    found = np.array(turned(jit.Array3f(*v), jit.Array3f(*rotation))).ravel()
    assert found == pytest.approx(Rotation.from_rotvec(rotation).apply(v), abs=3e-7)


def test_a_receiver_that_has_moved_on_sees_its_target_aside() -> None:
    """After 2 R/c at velocity v the target, then at R d, lies at R d - 2 R v/c: its new direction's sine, to first
    order in v/c = 0.003."""
    v, d, c = np.array([3.0, 4.5, 2.0]), np.array([0.3, 0.55, -0.78]), 1480.0
    r = np.array([0.1, 0.96, 0.25])
    d, r = d / np.linalg.norm(d), r / np.linalg.norm(r)
    after = d - 2.0 * v / c
    expected = after @ r / np.linalg.norm(after) - d @ r
    vectors = (jit.Array3f(*map(float, x)) for x in (v, d, r))
    found = number(aberration(*vectors, jit.Float(c)))
    assert found == pytest.approx(expected, abs=4e-5)
    assert abs(expected) > 1e-3


# directions by chance


@pytest.mark.parametrize("axis", [(0.3, -0.5, 0.8), (-0.6, 0.2, -0.7)])
def test_directions_about_an_axis(axis: tuple[float, float, float]) -> None:
    """At the angle asked for from the axis, evenly all round: four quarters of a turn cancel across the axis."""
    n = np.array(axis) / np.linalg.norm(axis)
    u = (np.arange(400) + 0.5) / 400
    found = np.array(about(jit.Array3f(*map(float, n)), jit.Float(-0.35), jit.Float(u))).T
    assert found @ n == pytest.approx(np.full(400, -0.35), abs=1e-6)
    assert found.mean(axis=0) == pytest.approx(-0.35 * n, abs=1e-6)
    across = found + 0.35 * n
    turn = np.sum(across * np.roll(across, -100, axis=0), axis=1)
    assert turn == pytest.approx(0.0 * u, abs=1e-5)


def test_what_leaves_a_matt_surface_follows_the_cosine() -> None:
    """Density cos/pi: the mean of the cosine is 2/3, of its square 1/2; a net of 40 x 40."""
    n = np.array([0.48, -0.6, 0.64])
    u, v = (g.ravel() for g in np.meshgrid((np.arange(40) + 0.5) / 40, (np.arange(40) + 0.5) / 40))
    cosine = n @ np.array(off_matt(jit.Array3f(*map(float, n)), jit.Float(u), jit.Float(v)))
    assert (cosine.mean(), (cosine**2).mean()) == pytest.approx((2 / 3, 1 / 2), abs=1e-3)


# control laws

DEPTH = DepthGains(
    reference_rad_s=0.1, kp_depth=0.12, integral_s=40.0, kp_pitch=1.7, kd_pitch=2.3, ki_pitch=0.4, k_heave=0.9
)


@pytest.mark.parametrize(
    ("name", "slope"),
    [
        ("pitch", DEPTH.kp_pitch), ("q", DEPTH.kd_pitch), ("w", DEPTH.k_heave),
        ("depth", -DEPTH.kp_pitch * DEPTH.kp_depth),
        ("depth_integral", -DEPTH.kp_pitch * DEPTH.kp_depth / DEPTH.integral_s), ("pitch_integral", DEPTH.ki_pitch),
        ("reference", DEPTH.kp_pitch * DEPTH.kp_depth * math.exp(-0.1 * 0.5)),
        ("setpoint", DEPTH.kp_pitch * DEPTH.kp_depth * (1 - math.exp(-0.1 * 0.5))),
    ],
)  # fmt: skip
def test_a_stern_plane_answers_each_input_with_its_gain(name: str, slope: float) -> None:
    """delta = kp (theta - theta_d) + kd q + ki I_theta + k_w w with theta_d = kp_z (e + I_z/T), e = z - z_filtered."""
    plain = {
        "setpoint": 9.0, "depth": 8.2, "pitch": -0.05, "w": 0.03, "q": -0.02, "reference": 8.5, "depth_integral": 0.7,
        "pitch_integral": -0.2,
    }  # fmt: skip

    def plane(values: dict[str, float]) -> float:
        v = {key: jit.Float64(value) for key, value in values.items()}
        memory = DepthMemory(v["reference"], v["depth_integral"], v["pitch_integral"])
        found, _ = stern_plane(DEPTH, memory, v["setpoint"], v["depth"], v["pitch"], v["w"], v["q"], jit.Float64(0.5))
        return number(found)

    step = 1e-3
    up, down = (plane(plain | {name: plain[name] + s * step}) for s in (1, -1))
    assert (up - down) / (2 * step) == pytest.approx(slope, rel=1e-6)


def test_a_depth_loop_integrates_what_is_missing() -> None:
    memory = DepthMemory(jit.Float64(8.5), jit.Float64(0.7), jit.Float64(-0.2))
    numbers = [jit.Float64(x) for x in (9.0, 8.2, -0.05, 0.03, -0.02, 0.5)]
    _, kept = stern_plane(DEPTH, memory, *numbers)
    filtered = 8.5 * math.exp(-0.05) + 9.0 * (1 - math.exp(-0.05))
    wanted = DEPTH.kp_depth * (8.2 - filtered + 0.7 / 40.0)
    expected = (filtered, 0.7 + 0.5 * (8.2 - filtered), -0.2 + 0.5 * (-0.05 - wanted))
    found = (kept.reference, kept.depth_integral, kept.pitch_integral)
    assert [number(x) for x in found] == pytest.approx(expected, rel=1e-9)


def test_a_rudder_by_sliding_mode() -> None:
    """On the surface sigma = 0 a ship after Nomoto, T r' + r = K delta, turns as its virtual reference does; off it
    K_d sigma + K_s sat(sigma/phi) less is asked for. F21 Section 16.4.
    """
    gains = HeadingGains(
        nomoto_gain=0.4, nomoto_time_s=3.0, bandwidth=0.25, boundary=0.1, k_damping=0.6, k_switch=0.05,
        reference_rad_s=0.2, reference_damping=1.0, rate_limit_deg_s=8.0,
    )  # fmt: skip
    integral, error, rate, acceleration, k = 0.9, -0.17, 0.03, -0.004, gains.bandwidth
    memory = HeadingMemory(*(jit.Float64(x) for x in (integral, 1.1, rate, acceleration)))
    virtual = rate - 2 * k * error - k * k * integral
    for sigma in (0.0, 0.04, -0.3):
        r = virtual + sigma
        asked, _ = rudder(gains, memory, jit.Float64(1.3), jit.Float64(1.1 + error), jit.Float64(r), jit.Float64(0.1))
        change = acceleration - 2 * k * (r - rate) - k * k * error  # of the virtual rate, by differentiating it
        left = 0.6 * sigma + 0.05 * max(-1.0, min(1.0, sigma / 0.1))
        assert 0.4 * number(asked) == pytest.approx(3.0 * change + virtual - left, rel=1e-9)


@pytest.mark.parametrize("goal", [0.02, -0.03])
def test_a_reference_follows_its_third_order_filter(goal: float) -> None:
    """w^3/((s + w)(s^2 + 2 zeta w s + w^2)): its step response, Euler steps of 1 ms leave 1e-3 of it.

    F21 Chapter 12.
    """
    w, zeta, h = 0.8, 0.7, 1e-3
    model = ReferenceModel(w, zeta, 1.0, angle=False)
    x = v = a = 0.0
    state = [jit.Float64(s) for s in (x, v, a)]
    found = []
    for k in range(6000):
        state = list(model.step(*state, jit.Float64(goal), jit.Float64(h)))
        if k % 1000 == 999:
            dr.eval(state)
            found.append([number(s) for s in state])
        elif k % 50 == 0:
            dr.eval(state)
    t = np.arange(1, 7.0)
    poles = np.polymul([1, w], [1, 2 * zeta * w, w * w])
    for order, column in enumerate(np.array(found).T):
        numerator = np.polymul([w**3], [1] + [0] * order)
        _, expected = signal.step((numerator, poles), T=np.concatenate([[0.0], t]))
        assert column == pytest.approx(goal * expected[1:], abs=2e-3 * abs(goal))


@pytest.mark.parametrize(
    ("place", "yaw"), [((6.0, 3.0), 0.3), ((-5.0, 4.0), 2.6), ((4.0, -2.0), -0.9), ((-5.0, 4.0), -0.7)]
)
def test_a_boat_is_pulled_to_its_place(place: tuple[float, float], yaw: float) -> None:
    """Pull k d cos(bearing) less brake u; moment by the bearing less damping r; y of the set-point is west."""
    config = PlaceConfig(
        type="place", pull_n_m=5.0, brake_kg_s=20.0, pull_limit_n=500.0, turn_n_m=30.0, turn_damping=7.0,
        turn_limit_n_m=400.0,
    )  # fmt: skip
    law = PlaceControl(config, SimpleNamespace(commands=lambda wrench: dict(enumerate(wrench))))
    here, speed, turning = np.array([1.5, 0.7]), 0.3, -0.2
    flow: Any = SimpleNamespace(
        position=[jit.Float64(here[0]), jit.Float64(-here[1]), jit.Float64(0.0)], yaw=jit.Float64(-yaw),
        nu=[jit.Float64(x) for x in (speed, 0.0, 0.0, 0.0, 0.0, -turning)],
    )  # fmt: skip
    demand, _ = law.act([], flow, [jit.Float64(p) for p in place], jit.Float64(0.1))
    way = np.array(place) - here  # NWU, yaw counter-clockwise; the law works in NED
    bearing = (math.atan2(way[1], way[0]) - yaw + math.pi) % (2 * math.pi) - math.pi
    pull = 5.0 * np.linalg.norm(way) * max(math.cos(bearing), 0.0) - 20.0 * speed
    moment = 30.0 * bearing - 7.0 * turning
    found = [number(demand.actuators[k]) for k in (0, 5)]
    assert found == pytest.approx([pull, -moment], rel=1e-9)


def test_accelerations_of_the_world_have_their_own_limits() -> None:
    """0.8 m/s^2 on each axis of a step, 0.3 rad/s^2 of a turn, up and down; the body's axes are the world's here."""
    modes = {"world": {"type": "world_acceleration", "limit_m_s2": 0.8, "turn_limit_rad_s2": 0.3}}
    vehicle = {"type": "bluerov2", "modes": modes, "default_mode": "world"}
    agents = {"rov": {"vehicle": vehicle, "start": {"depth_m": 5.0}, "control": "world"}}
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 20.0}, "tick_rate_hz": 100, "agents": agents})
    sim.step({"rov": [2.0, -0.5, -3.0, 0.2, -0.9, 1.5]})
    state = sim.state["rov"]
    assert state.velocity[0] == pytest.approx([0.008, -0.005, -0.008], abs=1e-6)
    assert state.angular_velocity[0] == pytest.approx([0.002, -0.003, 0.003], abs=1e-6)  # body axes: turned by 1e-5


# fields of a tracer

PLACE, TIME = (3.0, -7.0, -4.0), 5000.0


def field(config: Any) -> float:
    made = config.build(Site(0, None))
    return number(made.value(jit.Array3f64(*PLACE), jit.Float64(TIME)))


def test_fields_of_a_tracer() -> None:
    """Each in closed form at one place, x north, y west, z up."""
    x, y, z = PLACE
    east_of_north = math.radians(70.0)
    ahead = x * math.cos(east_of_north) - y * math.sin(east_of_north)  # along the compass direction
    gradient = GradientFieldConfig(per_m=0.3, towards_deg=70.0, per_m_down=-0.2)
    assert field(gradient) == pytest.approx(0.3 * ahead - 0.2 * -z)
    tide = OscillationFieldConfig(amplitude=2.0, period_h=6.0, phase_deg=40.0)
    assert field(tide) == pytest.approx(2.0 * math.cos(2 * math.pi * TIME / 21600.0 - math.radians(40.0)))
    patch = PatchFieldConfig(center_m=(1.0, -3.0, -6.0), radius_m=5.0, height_m=3.0, value=-1.5)
    away = ((x - 1.0) ** 2 + (y + 3.0) ** 2) / 25.0 + (z + 6.0) ** 2 / 9.0
    assert field(patch) == pytest.approx(-1.5 * math.exp(-0.5 * away))
    front = FrontFieldConfig(through_m=(2.0, -9.0), towards_deg=70.0, step=3.0, width_m=12.0)
    across = (x - 2.0) * math.cos(east_of_north) - (y + 9.0) * math.sin(east_of_north)
    assert field(front) == pytest.approx(1.5 * (1.0 + math.tanh(2.0 * across / 12.0)))
    profile = ProfileFieldConfig(depth_m=(0.0, 3.0, 8.0, 20.0), value=(5.0, 2.0, 7.0, -1.0))
    assert field(profile) == pytest.approx(2.0 + (4.0 - 3.0) / (8.0 - 3.0) * (7.0 - 2.0))
    both = [c.build(Site(0, None)) for c in (profile, patch)]
    assert number(total(both, jit.Array3f64(*PLACE), jit.Float64(TIME))) == pytest.approx(field(profile) + field(patch))


# HoloOcean's sonar


def test_a_wall_by_incidence_and_impedance() -> None:
    """R^2 cos(incidence), R of water against 1e8 rayl, in the bins where the wall stands; the first beam looks left.

    A wall 5 m ahead, its face turned by nothing: a ray at azimuth a and elevation e meets it at 5/(cos a cos e), with
    cos a cos e as its cosine.
    """
    config = {"beams": 3, "bins": 40, "range_min_m": 1.0, "range_max_m": 9.0, "horizontal_aperture_deg": 90.0,
              "vertical_aperture_deg": 2.0, "gain": 0.5, "density_kg_m3": 1020.0,
              "sound_speed_mps": 1510.0}  # fmt: skip
    wall = box((6.0, 4.0, -20.0), (2.0, 8.0, 8.0))  # from straight ahead to the left
    below = box((6.0, -4.0, -24.0), (2.0, 8.0, 8.0))  # to the right, deeper than the sonar
    made = IncidenceSonar(IncidenceSonarConfig(**config), context([wall, below]))
    truth = made.sense(at(0, 0, -20.0)).truth[0]
    r = (1e8 - 1020.0 * 1510.0) / (1e8 + 1020.0 * 1510.0)
    azimuth = np.radians(90.0 * (0.5 - (np.arange(258) + 0.5) / 258))[:86]  # rays of the left beam
    distance = 5.0 / np.cos(azimuth)
    cell = ((distance - 1.0) / 0.2).astype(int)
    expected = np.zeros(40)
    for k in np.unique(cell):
        expected[k] = 0.5 * r * r * np.cos(azimuth[cell == k]).mean()
    assert truth[0] == pytest.approx(expected, abs=0.02)  # rays up and down, to one degree, change bins at edges
    assert expected.max() > 0.35
    assert truth[2] == pytest.approx(truth[0], abs=0.02)  # by half of the rays; a cell holds their mean


def test_a_cone_is_as_wide_as_the_sector() -> None:
    """Its outermost ray meets a wall square to it at 5/cos(30 deg) = 5.774 m: bins 22 to 26 of 0.2 m have an echo."""
    config = {"cone": True, "beams": 1, "bins": 50, "range_min_m": 0.5, "range_max_m": 10.5}
    wall = box((6.0, 0.0, -20.0), (2.0, 12.0, 12.0))
    made = IncidenceSonar(IncidenceSonarConfig(**config, horizontal_aperture_deg=60.0), context([wall]))
    truth = made.sense(at(0, 0, -20.0)).truth[0, 0]
    assert np.flatnonzero(truth).tolist() == [22, 23, 24, 25, 26]


def test_noise_as_holoocean_paints_it() -> None:
    """Rayleigh's mean sigma sqrt(pi/2), by the square of range, half as much again at the middle of 60 degrees.

    Of 400 pings the mean has 0.52/sqrt(400) = 2.6 % of scatter; four of these are allowed.
    """
    config = {"beams": 61, "bins": 3, "range_max_m": 5.0, "horizontal_aperture_deg": 60.0, "additive": 0.3}
    made = IncidenceSonar(IncidenceSonarConfig(**config, scale_noise=True), context([box((50.0, 0, -20), (1, 1, 1))]))
    mean = np.mean([made.sense(at(0, 0, -20.0, tick=k)).data[0] for k in range(400)], axis=0)
    azimuth = 60.0 * (0.5 - (np.arange(61) + 0.5) / 61)
    bell = 1 + 0.5 * np.exp(-(azimuth**2) / (60.0 / 64))
    expected = 0.3 * math.sqrt(math.pi / 2) * (np.arange(3) / 3)[None, :] ** 2 * bell[:, None]
    assert mean == pytest.approx(expected, rel=0.11)
