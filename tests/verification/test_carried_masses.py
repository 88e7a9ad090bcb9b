"""Masses that are released, picked up, or flood in: closed forms, and vehicles that were built with them."""

from __future__ import annotations

import math
from dataclasses import replace

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.errors import CommandError, ScenarioError
from pelagos.hydro import flooding, rigid_body
from pelagos.hydro.liquid import box_liquid_center, box_liquid_level
from pelagos.vehicles.actuators.compartment import Around, CompartmentConfig
from pelagos.vehicles.flow import make_flow, rotation_from_euler
from pelagos.vehicles.varied import varied
from pelagos.vehicles.wetness import Wetness

RHO, G = 1026.0, 9.81
MASS, INERTIA, CG, CB, VOLUME = 31.0, (0.9, 2.1, 2.3), (0.03, -0.02, 0.04), (0.01, 0.005, -0.03), 0.032
ABOUT_CG = np.diag(INERTIA)
ADDED = (3.0, 14.0, 17.0, 0.2, 1.1, 1.3)


def body(mass=MASS, inertia=ABOUT_CG, cg=CG, cb=CB, volume=VOLUME, **changes):
    products = (-inertia[0, 1], -inertia[0, 2], -inertia[1, 2])
    return {
        "type": "custom", "length_m": 1.2, "beam_m": 0.5, "height_m": 0.5, "default_mode": "actuators",
        "mass": {
            "type": "explicit", "mass_kg": mass, "inertia_kg_m2": tuple(np.diag(inertia)),
            "products_of_inertia_kg_m2": products, "center_of_gravity_m": tuple(cg), "center_of_buoyancy_m": tuple(cb),
            "volume_m3": volume,
        },
        "added_mass": {"type": "diagonal", "diagonal": ADDED},
        "terms": {"restoring": {"type": "submerged", "free_surface": False}},
        "modes": {"actuators": {"type": "actuators"}}, **changes,
    }  # fmt: skip


def joined(*parts):
    """Mass, inertia about the common centre, and that centre, of parts (mass, inertia, centre)."""
    whole = sum(rigid_body.mass_matrix(m, i, r) for m, i, r in parts)
    mass = whole[0, 0]
    center = np.array([whole[5, 1], whole[3, 2], whole[4, 0]]) / mass
    s = rigid_body.skew(center)
    return mass, whole[3:, 3:] + mass * s @ s, center


def motions(n=40):
    rng = np.random.default_rng(4)
    eta = rng.normal(size=(n, 6)) * [3, 3, 3, 0.5, 0.5, 2.0] + [0, 0, 20, 0, 0, 0]
    return eta, rng.normal(size=(n, 6)) * [1.2, 0.7, 0.6, 0.5, 0.4, 0.6]


def accelerations(config, *, states=(), eta=None, nu=None):
    vehicle = pl.Vehicle.from_dict(config)
    if eta is None:
        eta, nu = motions()
    actuators = np.tile(np.array(states, dtype=float), (len(eta), 1))
    return vehicle.accelerations(eta, nu, actuators, actuators, current=(0.3, -0.2, 0.1))[0]


def test_shut_in_air_bears_an_outside_head_at_its_limit():
    """Boyle: p_0 V = (p_0 + h) (V - w); the limit is where the head of the air is h."""
    head, volume, atmosphere = (jit.Float64(v) for v in ([0.3, 4.0, 25.0], [0.02, 0.7, 3.0], [10.1, 9.7, 10.4]))
    water = flooding.boyle_limit(head, volume, atmosphere)
    np.testing.assert_allclose(flooding.boyle_head(water, volume, atmosphere)[0], head, rtol=1e-12)
    np.testing.assert_allclose((atmosphere + head) * (volume - water), atmosphere * volume, rtol=1e-12)


THING = {"type": "releasable", "mass_kg": 4.0, "position_m": (0.31, -0.12, 0.17), "inertia_kg_m2": (0.03, 0.05, 0.06)}


@pytest.mark.parametrize("rigid", ["momentum", "angular"])
def test_carried_thing_accelerates_as_a_vehicle_built_with_it(rigid):
    form = {"coriolis": {"rigid": rigid}}
    volume = 0.0023
    mass, inertia, center = joined(
        (MASS, np.diag(INERTIA), CG), (4.0, np.diag(THING["inertia_kg_m2"]), THING["position_m"])
    )
    buoyant = (np.array(CB) * VOLUME + np.array(THING["position_m"]) * volume) / (VOLUME + volume)
    built = body(mass, inertia, center, buoyant, VOLUME + volume, **form)
    carried = body(**form, actuators={"thing": {**THING, "volume_m3": volume}})
    assert np.allclose(accelerations(carried, states=[0.0]), accelerations(built), rtol=1e-9, atol=1e-10)
    assert np.allclose(accelerations(carried, states=[1.0]), accelerations(body(**form)), rtol=1e-9, atol=1e-10)
    absent = body(**form, actuators={"thing": {**THING, "volume_m3": volume, "start": "absent"}})
    assert np.allclose(accelerations(absent, states=[1.0]), accelerations(built), rtol=1e-9, atol=1e-10)
    held = {**built, "actuators": {"thing": {**THING, "volume_m3": volume, "in_vehicle_mass": True}}}
    assert np.allclose(accelerations(held, states=[1.0]), accelerations(body(**form)), rtol=1e-9, atol=1e-10)
    assert np.allclose(accelerations(held, states=[0.0]), accelerations(built), rtol=1e-9, atol=1e-10)


THING_M3 = 0.0023
WATER = np.array([0.21, -0.34, 0.13])  # acceleration of the water [m/s^2]


def adrift_flow(share=None):
    """Flow past a vehicle that goes along with water of the acceleration `WATER`, level, to the north; `share` of its
    hull is wet, and neither rises nor falls."""
    eye = [[jit.Float64(x) for x in row] for row in np.eye(3)]
    flow = make_flow(lists([[0.0, 0.0, 5.0]]), eye, lists([[0.3, -0.2, 0.1, 0, 0, 0]]), lists([[0.3, -0.2, 0.1]]),
                     acceleration=[jit.Float64(x) for x in WATER])  # fmt: skip
    return flow if share is None else replace(flow, wet=Wetness(jit.Float64(share), jit.Float64(0.0)))


def adrift(vehicle, states, share=None):
    """Accelerations `(lanes, 6)` in `adrift_flow`, with actuators' states `(lanes, actuators)`."""
    found = vehicle.model.nu_dot(adrift_flow(share), lists(states))
    return np.array([np.broadcast_to(np.array(x), len(states)) for x in found]).T


def pushed(own, water, share, carried):
    """F = m a: (M_RB + c M_thing + s M_A) nu_dot = s (M_water + c M_thing's + M_A) (a, 0): without weight, of a vehicle
    that has the share `c` of `THING` aboard, `s` of it wet.
    """
    thing = rigid_body.mass_matrix(4.0, np.diag(THING["inertia_kg_m2"]), THING["position_m"])
    its_water = rigid_body.mass_matrix(RHO * THING_M3, np.zeros((3, 3)), THING["position_m"])
    load = share * (water + carried * its_water + np.diag(ADDED)) @ [*WATER, 0, 0, 0]
    return np.linalg.solve(own + carried * thing + share * np.diag(ADDED), load)


@pytest.mark.parametrize("neutral", [False, True])
@pytest.mark.parametrize("share", [1.0, 0.4])
def test_accelerating_water_pushes_what_is_carried_by_its_volume(neutral, share):
    weightless = {"gravity_m_s2": 0.0, "terms": {}, "actuators": {"thing": {**THING, "volume_m3": THING_M3}}}
    center, volume = (CG, MASS / RHO) if neutral else (CB, VOLUME)  # neutral: nothing is left over without the thing
    vehicle = pl.Vehicle.from_dict(body(**weightless, cb=center, volume=volume))
    assert (vehicle.model.inertia.excess is None) == neutral
    own = rigid_body.mass_matrix(MASS, ABOUT_CG, CG)
    water = rigid_body.mass_matrix(RHO * volume, RHO * volume / MASS * ABOUT_CG, center)
    states, heavier = np.array([[0.0], [0.7], [1.0]]), np.array([1.0, 1.3, 0.8])
    expected = [pushed(own, water, share, 1 - s) for s in states[:, 0]]
    wet = None if share == 1.0 else share
    for state, want in zip(states, expected, strict=True):
        np.testing.assert_allclose(adrift(vehicle, [state], wet)[0], want, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(adrift(vehicle, states, wet), expected, rtol=1e-9, atol=1e-12)
    fleet = varied(vehicle, {"mass": jit.Float64(heavier)})
    expected = [pushed(m * own, water, share, 1 - s) for m, s in zip(heavier, states[:, 0], strict=True)]
    np.testing.assert_allclose(adrift(fleet, states, wet), expected, rtol=1e-9, atol=1e-12)


def test_slope_of_the_push_by_what_is_carried():
    """d nu_dot/d state by central differences of `pushed`, as backpropagated."""
    vehicle = pl.Vehicle.from_dict(
        body(gravity_m_s2=0.0, terms={}, actuators={"thing": {**THING, "volume_m3": THING_M3}})
    )
    state = jit.Float64(0.3)
    dr.enable_grad(state)
    found = vehicle.model.nu_dot(adrift_flow(), [state])
    dr.backward(found[0] - 2.0 * found[4])
    own = rigid_body.mass_matrix(MASS, ABOUT_CG, CG)
    water = rigid_body.mass_matrix(RHO * VOLUME, RHO * VOLUME / MASS * ABOUT_CG, CB)
    high, low = (pushed(own, water, 1.0, 0.7 - h) @ [1, 0, 0, 0, -2, 0] for h in (1e-5, -1e-5))
    assert float(dr.grad(state)[0]) == pytest.approx((high - low) / 2e-5, rel=1e-6)


def test_half_of_shot_ballast_is_half_the_weight():
    half = body(actuators={"shot": {**THING, "duration_s": 8.0}})
    built = body(actuators={"shot": {**THING, "mass_kg": 2.0, "inertia_kg_m2": (0.015, 0.025, 0.03)}})
    assert np.allclose(accelerations(half, states=[0.5]), accelerations(built, states=[0.0]), rtol=1e-9, atol=1e-10)


def test_full_compartment_accelerates_as_a_vehicle_built_with_its_water():
    size, middle = np.array([0.4, 0.2, 0.16]), (0.2, 0.06, -0.05)
    tank = {"type": "compartment", "size_m": tuple(size), "position_m": middle, "hole_m": middle, "orifice_m2": 1e-4,
            "permeability": 0.8}  # fmt: skip
    water = RHO * 0.8 * size.prod()
    s = size**2 / 12 * water
    mass, inertia, center = joined((MASS, np.diag(INERTIA), CG),
                                   (water, np.diag([s[1] + s[2], s[0] + s[2], s[0] + s[1]]), middle))  # fmt: skip
    full = 0.8 * size.prod()
    for valve in (False, True):
        found = accelerations(body(actuators={"tank": {**tank, "valve": valve}}), states=[full])
        assert np.allclose(found, accelerations(body(mass, inertia, center)), rtol=1e-9, atol=1e-10)


def free(**changes):
    """A body in nothing: no water that goes along, no weight."""
    return body(added_mass={"type": "none"}, terms={}, gravity_m_s2=0.0, volume_m3=0.0, **changes)


def run(config, state, commands, h, ticks, current=None):
    """States of a vehicle, step after step."""
    vehicle = pl.Vehicle.from_dict(config)
    position, velocity, spin = (np.array([v], dtype=float) for v in state)
    now = vehicle.initial_state(position, np.array([[1.0, 0, 0, 0]]), velocity, spin)
    none = (dr.zeros(jit.Array3f64, 1), dr.zeros(jit.Array3f64, 1))
    dr.make_opaque(none)

    @jit.freeze
    def go(state, command, t, none, h):
        return vehicle.step(state, command, None, t, none, h, "actuators")

    out, step = [now], dr.opaque(jit.Float64, h)
    for k in range(ticks):
        command = [dr.opaque(jit.Float64, c) for c in commands(k * h)]
        now = go(now, command, dr.opaque(jit.Float64, k * h), none, step)
        out.append(now)
    return out


def momenta(state, parts):
    """Linear and angular momentum in the world, about its origin, of parts (mass, inertia, centre)."""
    from scipy.spatial.transform import Rotation

    w, x, y, z = np.array(state.attitude).ravel()
    turn = Rotation.from_quat([x, y, z, w])
    nu = np.concatenate([np.array(state.velocity).ravel(), np.array(state.angular_velocity).ravel()])
    p = sum(rigid_body.mass_matrix(m, i, r) for m, i, r in parts) @ nu
    linear = turn.apply(p[:3])
    return linear, turn.apply(p[3:]) + np.cross(np.array(state.position).ravel(), linear)


BODY = (MASS, np.diag(INERTIA), CG)
PART = (4.0, np.diag(THING["inertia_kg_m2"]), THING["position_m"])


def test_release_keeps_velocity_and_momentum():
    """No force acts: body and thing keep what they have together; the released thing takes its own along."""
    config = {k: v for k, v in free(actuators={"thing": THING}).items() if k != "volume_m3"}
    h, at = 0.001, 200
    states = run(config, ([0, 0, 0], [0.9, -0.4, 0.3], [0.5, -0.7, 0.6]), lambda t: [1.0 if t > 0.2 - 1e-9 else 0.0],
                 h, 400)  # fmt: skip
    start, before, after, end = states[0], states[at], states[at + 2], states[-1]
    assert float(states[at + 1].actuators[0][0]) == 1.0
    jump = np.array(after.velocity) - np.array(before.velocity)
    assert np.abs(jump).max() < 2 * h * 1.5  # no more than two steps of turning axes
    for one, other, parts in ((start, before, (BODY, PART)), (states[at + 1], end, (BODY,))):
        for a, b in zip(momenta(one, parts), momenta(other, parts), strict=True):
            assert np.allclose(a, b, atol=2e-4 * np.abs(momenta(start, (BODY, PART))[0]).max())


def test_what_is_picked_up_takes_its_share_of_momentum():
    """An inelastic blow: the momentum that the vehicle had alone is that of both."""
    config = {k: v for k, v in free(actuators={"thing": {**THING, "start": "absent"}}).items() if k != "volume_m3"}
    h = 1e-6
    states = run(config, ([0, 0, 0], [0.9, -0.4, 0.3], [0.5, -0.7, 0.6]), lambda t: [1.0], h, 1)
    for a, b in zip(momenta(states[0], (BODY,)), momenta(states[1], (BODY, PART)), strict=True):
        assert np.allclose(a, b, rtol=1e-5, atol=1e-5)


def test_things_that_go_for_good_and_by_themselves():
    states = run(body(actuators={"w": THING, "loose": {**THING, "for_good": False}, "link": {**THING,
                 "release_after_s": 0.5}, "shot": {**THING, "duration_s": 2.0}}), ([0, 0, -20], [0, 0, 0], [0, 0, 0]),
                 lambda t: [1.0, 1.0, 0.0, 0.4] if t < 0.95 else [0.0] * 4, 0.1, 20)  # fmt: skip
    found = np.array([[float(a[0]) for a in s.actuators] for s in states])
    assert found[-1] == pytest.approx([1.0, 0.0, 1.0, 0.4])
    assert found[10] == pytest.approx([1.0, 1.0, 1.0, 0.4])
    assert found[5, 2] == 0.0
    assert found[6, 2] == 1.0
    assert found[4, 3] == pytest.approx(0.2)  # 0.4 s of 2


# the liquid in a box


def lists(values):
    return [jit.Float64(np.ascontiguousarray(c)) for c in np.asarray(values).T]


def test_liquid_center_is_that_of_the_wall_sided_box():
    """Box 0.8 x 0.5 x 0.3 m, half full or so: dy = i/V tan, dz = i/(2 V) tan^2, exactly while walls alone are cut."""
    size = np.array([0.8, 0.5, 0.3])
    heel, trim = np.array([0.2, -0.3, 0.0, 0.1, -0.15]), np.array([0.0, 0.0, 0.25, -0.1, -0.05])
    fill = np.array([0.5, 0.4, 0.45, 0.6, 0.35])
    slope = np.array([-np.tan(trim), np.tan(heel)]).T  # of down: x, y over z
    down = np.column_stack([slope, np.ones(5)])
    down /= np.linalg.norm(down, axis=1)[:, None]
    found = np.array([np.array(c) for c in box_liquid_center(jit.Float64(fill), (size / 2).tolist(), lists(down))]).T
    arm = size[:2] ** 2 / 12 / (size[2] * fill[:, None])  # i/V
    expected = np.column_stack([arm * slope, size[2] / 2 * (1 - fill) - (arm * slope**2).sum(axis=1) / 2])
    assert np.allclose(found, expected, rtol=0, atol=1e-9)  # no side is flatter than 1e-9 of another
    level, rise = box_liquid_level(jit.Float64(fill), (size / 2).tolist(), lists(down))
    assert np.allclose(np.array(level), size[2] * (0.5 - fill) * down[:, 2], atol=1e-12)
    assert np.allclose(np.array(rise), size[2] * down[:, 2], rtol=1e-9)


def test_liquid_center_at_any_attitude():
    """Against the mean of 60^3 points, sorted by depth; a cell's share of an error is size/120."""
    size, n = np.array([0.8, 0.5, 0.3]), 40
    rng = np.random.default_rng(2)
    down, fill = rng.normal(size=(n, 3)), rng.uniform(0.03, 0.97, n)
    down[:6] = [[1, 0, 0], [0, -1, 0], [0, 0, -1], [-1, 1, 0], [0, 1, -1], [1, 1, 1]]
    down[:6] += rng.normal(size=(6, 3)) * 0.1  # so that few points are equally deep
    down /= np.linalg.norm(down, axis=1)[:, None]
    found = np.array([np.array(c) for c in box_liquid_center(jit.Float64(fill), (size / 2).tolist(), lists(down))]).T
    grid = (np.arange(60) + 0.5) / 60 - 0.5
    points = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3) * size
    for one, d, share in zip(found, down, fill, strict=True):
        wet = np.argsort(points @ d)[-round(share * len(points)) :]
        assert np.allclose(one, points[wet].mean(axis=0), atol=2.5e-3 * size.max())


def test_liquid_in_a_corner_is_a_tetrahedron():
    """With edges h/|d_k|, h its height, and volume h^3/(6 d d d); its centre lies a quarter of each from the corner."""
    half = np.array([0.5, 0.31, 0.83])
    down = np.array([[0.5, 0.6, 0.62], [1.0, -1.0, 1.0], [-0.2, 0.9, -0.4], [-0.7, -0.1, 0.3], [-0.5, -0.55, -0.7]])
    down /= np.linalg.norm(down, axis=1)[:, None]
    longest = (2 * half * np.abs(down)).min(axis=1)  # height at which an edge reaches the next corner
    for part in (0.2, 0.4, 0.999):
        h = part * longest
        fill = h**3 / (6 * np.abs(down).prod(axis=1)) / (8 * half.prod())
        found = np.array([np.array(c) for c in box_liquid_center(jit.Float64(fill), half.tolist(), lists(down))]).T
        expected = np.sign(down) * (half - h[:, None] / np.abs(down) / 4)
        assert np.allclose(found, expected, rtol=0, atol=1e-9)  # rounding: a share of 1e-6 is a difference of ones
        level, rise = box_liquid_level(jit.Float64(fill), half.tolist(), lists(down))
        assert np.allclose(np.array(level), np.abs(down) @ half - h, rtol=0, atol=1e-10)
        assert np.allclose(np.array(rise), h / (3 * fill), rtol=1e-6)


def test_free_surface_takes_i_over_v_of_metacentric_height():
    """Moment of the liquid by heel beyond that of its weight frozen upright: rho g i phi, and by trim likewise."""
    size, fill, phi = (0.6, 0.4, 0.2), 0.5, 1e-4
    tank = {"type": "compartment", "size_m": size, "position_m": (0.0, 0.0, 0.0), "hole_m": (0.0, 0.0, 0.0),
            "orifice_m2": 1e-4}  # fmt: skip
    part = CompartmentConfig(**tank).build(pl.Vehicle.from_dict(body()).config.body)
    volume = fill * np.prod(size)
    frozen = size[2] * (1 - fill) / 2
    for axis, i in ((0, size[0] * size[1] ** 3 / 12), (1, size[1] * size[0] ** 3 / 12)):
        for angle in (phi, -phi):
            turn = rotation_from_euler(angle if axis == 0 else 0.0, angle if axis == 1 else 0.0, 0.0)
            flow = make_flow([0.0] * 3, [[jit.Float64(c) for c in row] for row in turn], [0.0] * 6, [0.0] * 3)
            moment = float(part.wrench(jit.Float64(volume), flow)[3 + axis][0])
            held = -RHO * G * volume * frozen * math.sin(angle)
            assert (moment - held) / (RHO * G * i * angle) == pytest.approx(1.0, rel=1e-6)


def test_liquid_of_a_box_on_its_sides():
    """Level with a side of length a it fills a slice: the centre lies a (1 - fill)/2 towards the deep side."""
    size, fill = np.array([0.8, 0.5, 0.3]), np.array([0.2, 0.4, 0.5, 0.6, 0.9, 1.0])
    down = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1], [-1, 0, 0], [0, 1, 0], [0.0, 0.6, 0.8]])
    found = np.array([np.array(c) for c in box_liquid_center(jit.Float64(fill), (size / 2).tolist(), lists(down))]).T
    assert np.allclose(found, down * size / 2 * (1 - fill)[:, None], rtol=0, atol=1e-9)


# water through a hole


def law(**changes):
    size = (0.5, 0.4, 0.6)
    tank = {"type": "compartment", "size_m": size, "position_m": (0.0, 0.0, 0.0), "hole_m": (0.0, 0.0, 0.3),
            "orifice_m2": 2e-4, **changes}  # fmt: skip
    return CompartmentConfig(**tank).build(pl.Vehicle.from_dict(body()).config.body).lag


def follow(flooding_law, around, water, seconds, h=0.5, command=0.0):
    here = replace(flooding_law, around=Around(*around, [0.0, 0.0, 1.0]))
    kept, state = [0.0] * here.memory, water
    for _ in range(round(seconds / h)):
        state, *kept = here.after(state, kept, command, h)
    return state


def test_box_drains_as_torricelli_says():
    """sqrt(h) falls by Cd a sqrt(g/2) / A a second; the box is empty after A/(Cd a) sqrt(2 h0/g)."""
    drains, area, hole = law(vent_m=(0.0, 0.0, -0.3)), 0.2, 0.6 * 2e-4
    full = 0.6
    empty_s = area / hole * math.sqrt(2 * full / G)
    for share in (0.25, 0.5, 0.9):
        left = area * full * (1 - share) ** 2
        found = follow(drains, (-1.0, -2.0), area * full, share * empty_s, h=share * empty_s / 200)
        assert found == pytest.approx(left, rel=1e-5)  # a box that is full counts as filled to 1 - 1e-6
    assert follow(drains, (-1.0, -2.0), area * full, 1.02 * empty_s, h=1.02 * empty_s / 200) == pytest.approx(
        0, abs=1e-9
    )


def test_vented_box_fills_to_the_level_outside():
    """Hole 0.45 m under the surface: until the level is reached the head falls as in draining; then nothing moves."""
    fills, area, hole, head = law(vent_m=(0.0, 0.0, -0.3)), 0.2, 0.6 * 2e-4, 0.45
    whole_s = area / hole * math.sqrt(2 * head / G)
    for share in (0.3, 0.7):
        level = head * (1 - (1 - share) ** 2)
        assert follow(fills, (head, head - 0.6), 0.0, share * whole_s, h=share * whole_s / 400) == pytest.approx(
            area * level,
            rel=2e-3,  # below the hole's edge the first step has no level to oppose
        )
    assert follow(fills, (head, head - 0.6), 0.0, 2 * whole_s, h=2.0) == pytest.approx(area * head, rel=1e-9)


@pytest.mark.parametrize("depth", [3.0, 40.0])
def test_shut_in_air_stops_the_water(depth):
    """p0 V0/(V0 - V) = p0 + rho g (depth - level), a quadratic equation."""
    shut, area, height = law(), 0.2, 0.6
    head = flooding.ATMOSPHERE_PA / (RHO * G)
    b = depth + height + head
    level = (b - math.sqrt(b * b - 4 * depth * height)) / 2  # of l^2 - b l + depth height = 0
    assert head * height / (height - level) == pytest.approx(head + depth - level)
    for h, seconds in ((2.0, 3000.0), (20.0, 6000.0), (500.0, 20000.0)):
        assert follow(shut, (depth, None), 0.0, seconds, h=h) == pytest.approx(area * level, rel=1e-6)


def test_pump_and_valve():
    pumped = law(vent_m=(0.0, 0.0, -0.3), pump_m3_s=1e-3, valve=True, orifice_m2=0.01)
    assert follow(pumped, (5.0, 4.4), 0.02, 10.0, command=0.02) == pytest.approx(0.02)
    assert follow(pumped, (5.0, 4.4), 0.02, 10.0, command=0.05) == pytest.approx(0.05)
    assert follow(pumped, (5.0, 4.4), 0.05, 10.0, command=0.01) == pytest.approx(0.04)
    assert follow(pumped, (5.0, 4.4), 0.05, 60.0, command=0.01) == pytest.approx(0.01)
    leak = law(vent_m=(0.0, 0.0, -0.3), pump_m3_s=1e-3)  # 0.6 x 2e-4 x sqrt(2 g 5): 1.19e-3 m^3/s at first
    net = 0.6 * 2e-4 * math.sqrt(2 * G * 5) - 1e-3
    assert follow(leak, (5.0, -0.1), 0.0, 10.0, h=0.01) == pytest.approx(10 * net, rel=0.02)
    late = law(vent_m=(0.0, 0.0, -0.3), opens_after_s=4.0)
    assert follow(late, (5.0, -0.1), 0.0, 4.0) == 0.0
    rate = 0.6 * 2e-4 * math.sqrt(2 * G)  # the level in 0.2 m^2 rises against it
    assert follow(late, (5.0, -0.1), 0.0, 4.5) == pytest.approx(
        rate * (math.sqrt(5) * 0.5 - rate / 0.2 * 0.5**2 / 4), rel=1e-6
    )


def test_flooding_without_depth_is_refused():
    with pytest.raises(CommandError, match="depth"):
        law().after(jit.Float64(0.1), [], jit.Float64(0.0), 0.1)


# whole vehicles


def test_damaged_hull_floats_deeper():
    """A box of 2 x 1 m on the water takes 0.1 m^3: 0.05 m deeper; 0.1 m ahead of its middle it trims by moment over
    stiffness, and the free surface takes i/V of both.
    """
    side, freeboard = (2.0, 1.0), 0.2
    k = RHO * G * side[0] * side[1]
    roll, pitch = 4000.0, 12000.0
    tank = {"type": "compartment", "size_m": (0.8, 0.5, 0.25), "position_m": (0.1, 0.0, 0.0),
            "hole_m": (0.1, 0.0, 0.125), "vent_m": (0.1, 0.0, -0.125), "orifice_m2": 5e-3, "valve": True}  # fmt: skip
    config = body(
        mass=400.0, inertia=np.diag([40.0, 140.0, 170.0]), cg=(0, 0, 0), cb=(0, 0, 0), volume=None,
        length_m=2.0, beam_m=1.0, height_m=0.4, actuators={"tank": tank},
        terms={
            "floats": {"type": "hydrostatic", "heave_n_m": k, "roll_n_m": roll, "pitch_n_m": pitch},
            "damping": {"type": "linear_damping", "diagonal": (50, 50, 4000, 400, 1500, 50)},
        },
    )  # fmt: skip
    states = run(config, ([0, 0, 0], [0, 0, 0], [0, 0, 0]), lambda t: [0.02], 0.02, 2000)
    end = states[-1]
    water = float(end.actuators[0][0])
    assert water == pytest.approx(0.02, rel=1e-9)
    assert float(end.position[2][0]) == pytest.approx(RHO * G * water / k, rel=2e-3)
    w, _, y, _ = (float(q[0]) for q in end.attitude)
    angle = 2 * math.atan2(y, w)
    fill, i = water / (0.8 * 0.5 * 0.25), 0.5 * 0.8**3 / 12
    above = 0.25 * (1 - fill) / 2  # the liquid's centre under the box's middle
    left = pitch - RHO * G * i + RHO * G * water * above
    assert -angle == pytest.approx(RHO * G * water * 0.1 / left, rel=5e-3)
    assert freeboard > 0


@pytest.mark.parametrize(("volume", "sinks"), [(0.0004, False), (0.0030, True)])
def test_flooded_vehicle_sinks_when_the_reserve_is_gone(volume, sinks):
    """1 kg of reserve: 0.4 kg of water leave it rising, 3 kg sink it."""
    size = (0.3, 0.1, volume / 0.03)
    low = 0.05 + size[2] / 2
    tank = {"type": "compartment", "size_m": size, "position_m": (0.0, 0.0, 0.05), "hole_m": (0.0, 0.0, low),
            "vent_m": (0.0, 0.0, 0.05 - size[2] / 2), "orifice_m2": 1e-3}  # fmt: skip
    config = body(volume=(MASS + 1.0) / RHO, actuators={"tank": tank}, cg=(0, 0, 0.03), cb=(0, 0, -0.03))
    config["terms"]["damping"] = {"type": "linear_damping", "diagonal": (50, 50, 50, 9, 9, 9)}
    config["terms"]["restoring"]["free_surface"] = True
    states = run(config, ([0, 0, -10], [0, 0, 0], [0, 0, 0]), lambda t: [0.0], 0.02, 1000)
    depth = float(states[-1].position[2][0])
    assert (depth > 10.0) == sinks
    assert float(states[-1].actuators[0][0]) <= volume * (1 + 1e-9)


WRONG = [
    ({"type": "releasable", "mass_kg": -1.0, "position_m": (0, 0, 0)}, "mass_kg"),
    ({**THING, "in_vehicle_mass": True, "start": "absent"}, "absent"),
    ({**THING, "mass_kg": 31.0, "in_vehicle_mass": True}, "left of the vehicle"),
    ({**THING, "inertia_kg_m2": (0.01, 0.01, 0.5)}, "more than the sum"),
    ({**THING, "duration": 2.0}, "duration"),
    ({"type": "compartment", "size_m": (0.1, 0.1, 0.1), "position_m": (0, 0, 0), "hole_m": (0, 0, 0.2),
      "orifice_m2": 1e-4}, "outside the compartment"),
    ({"type": "compartment", "size_m": (0.1, 0.1, 0.1), "position_m": (0, 0, 0), "hole_m": (0, 0, 0.05),
      "orifice_m2": 0.0}, "orifice_m2"),
]  # fmt: skip


def test_a_compartment_needs_gravity():
    """Without it, no head drives water; it ended in a division by zero."""
    tank = {"type": "compartment", "size_m": (0.1, 0.1, 0.1), "position_m": (0, 0, 0), "hole_m": (0, 0, 0.05),
            "orifice_m2": 1e-4}  # fmt: skip
    with pytest.raises(ScenarioError, match="compartment 'it' needs a gravity_m_s2 above 0"):
        pl.Vehicle.from_dict(body(actuators={"it": tank}, gravity_m_s2=0.0))


@pytest.mark.parametrize(("part", "said"), WRONG)
def test_what_cannot_be_is_refused(part, said):
    with pytest.raises(ScenarioError, match=said):
        pl.Vehicle.from_dict(body(actuators={"it": part}))
