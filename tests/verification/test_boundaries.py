"""Planes near a body in ideal fluid: Lamb's sphere, strips of slender bodies, energy and momentum of whole motions."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos import jit
from pelagos.errors import CommandError, PelagosError, ScenarioError
from pelagos.hydro.images import Plane, image_added_mass, image_energy_gradient, spheroid_dipoles
from pelagos.vehicles.nearby import Walls
from pelagos.vehicles.tables import Tables

RHO = 1000.0
A = 0.3
SPHERE_KG = 4 / 3 * math.pi * A**3 * RHO


def matrix(body, distance, normal, sign=1.0):
    return np.array(image_added_mass(body, Plane(float(distance), [float(x) for x in normal], sign)))


def sphere():
    return spheroid_dipoles([A] * 3, [0.0] * 3, [SPHERE_KG / 2] * 3, SPHERE_KG, RHO)


@pytest.mark.parametrize("distance", [0.5, 0.8, 2.0])
def test_sphere_has_lambs_added_mass(distance):
    """1 + 3/16 (a/d)^3 along and 1 + 3/8 (a/d)^3 across a plane, of half the mass of the water displaced."""
    ratio = (A / distance) ** 3
    for axis in range(3):
        normal = np.eye(3)[axis] * (-1) ** axis
        part = np.where(np.arange(3) == axis, 3 / 8, 3 / 16) * ratio
        assert np.allclose(matrix(sphere(), distance, normal)[:3, :3], np.diag(part) * SPHERE_KG / 2, rtol=1e-12)
        assert np.allclose(matrix(sphere(), distance, normal, -1.0)[:3, :3], -np.diag(part) * SPHERE_KG / 2, rtol=1e-12)


def test_long_hull_has_the_added_mass_of_its_strips():
    """Of a strip, two dipoles of strength 2 S a distance 2 d apart: rho S b^2/(2 d^2), each of its own b(x)."""
    half, b, d = 4.0, 0.04, 0.3
    mass = 4 / 3 * math.pi * half * b * b * RHO
    body = spheroid_dipoles([half, b, b], [0.0] * 3, [0.0, mass, mass], mass, RHO, count=48)
    strips = RHO * math.pi * b**4 / (2 * d * d) * half * 16 / 15  # the integral of (1 - x^2)^2
    found = matrix(body, d, [0, 0, -1.0])
    assert found[2, 2] == pytest.approx(strips, rel=0.06)  # (2 d/half)^2 ln(half/2 d) = 6 %: the ends
    assert found[1, 1] == pytest.approx(strips, rel=0.06)
    turning = RHO * math.pi * b**4 / (2 * d * d) * half**3 * (2 / 3 - 4 / 5 + 2 / 7)
    assert found[4, 4] == pytest.approx(turning, rel=0.1)


def test_row_of_dipoles_stands_for_a_continuous_one():
    """A hull of the REMUS's shape: suction ahead and abeam against 32 dipoles, from the nearest distance on."""
    half, mass = [0.8, 0.095, 0.095], 27.0
    row, fine = (spheroid_dipoles(half, [0.0] * 3, [0.03 * mass, mass, mass], mass, RHO, count=k) for k in (None, 32))
    assert row.nearest == pytest.approx(1.5 * 0.095, rel=0.05)
    for ratio, most in ((1.0, 0.1), (1.4, 5e-3), (3.0, 1e-6)):
        plane = Plane(ratio * row.nearest, [0.0, 0.0, -1.0])
        for nu in ([1.5, 0, 0, 0, 0, 0], [0, 0.5, 0, 0, 0, 0]):
            pulls = [image_energy_gradient(b, plane, nu)[0] for b in (row, fine)]
            assert pulls[0] == pytest.approx(pulls[1], rel=most)


BODY = spheroid_dipoles([0.9, 0.2, 0.2], [0.05, 0.02, -0.03], [8.0, 70.0, 75.0], 150.0, RHO)
NU = np.array([1.1, -0.3, 0.4, 0.2, -0.5, 0.3])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_gradient_is_that_of_the_energy(sign):
    normal = np.array([0.2, 0.3, -0.93]) / np.linalg.norm([0.2, 0.3, -0.93])
    plane = Plane(jit.Float64(0.8), [jit.Float64(x) for x in normal], sign)
    slope, turned = image_energy_gradient(BODY, plane, [jit.Float64(v) for v in NU])
    turned, h = np.array([float(np.ravel(t)[0]) for t in turned]), 1e-5

    def energy(distance, toward):
        return 0.5 * NU @ matrix(BODY, distance, toward, sign) @ NU

    assert float(slope[0]) == pytest.approx((energy(0.8 + h, normal) - energy(0.8 - h, normal)) / (2 * h), rel=1e-7)
    for axis in np.eye(3):
        across = np.cross(axis, normal)
        ends = [energy(0.8, (normal + s * across) / np.linalg.norm(normal + s * across)) for s in (h, -h)]
        assert turned @ across == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-6, abs=1e-7)
    found = matrix(BODY, 0.8, normal, sign)
    assert np.allclose(found, found.T, rtol=0, atol=1e-12 * np.abs(found).max())


def drifting(added, half, mass, inertia, **changes):
    """A neutral body of no drag near a plane."""
    return {
        "type": "custom", "length_m": 2 * half[0], "beam_m": 2 * half[1], "height_m": 2 * half[2],
        "density_kg_m3": RHO, "gravity_m_s2": 0.0, "default_mode": "actuators",
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": inertia},
        "added_mass": {"type": "diagonal", "diagonal": added}, "terms": {"near": {"type": "boundary"}},
        "modes": {"actuators": {"type": "actuators"}}, **changes,
    }  # fmt: skip


def test_sphere_that_passes_a_wall_is_drawn_to_it():
    """The slope of Lamb's energy: 9/64 m U^2 a^3/d^4 towards the plane, over mass and added mass across it."""
    inertia = (0.4 * SPHERE_KG * A * A,) * 3
    vehicle = pl.Vehicle.from_dict(drifting((SPHERE_KG / 2,) * 3 + (0.0,) * 3, [A] * 3, SPHERE_KG, inertia))
    for d, u in ((0.6, 1.3), (1.1, -0.7)):
        for normal, eta in (((0, 0, -1.0), (0, 0, 5, 0, 0, 0)), ((0, -1.0, 0), (0, 0, 5, 0, 0.3, 0))):
            found = vehicle.accelerations([eta], [[u, 0, 0, 0, 0, 0]], [[]], [[]], walls=[[*normal, d]])[0][0]
            far = vehicle.accelerations([eta], [[u, 0, 0, 0, 0, 0]], [[]], [[]])[0][0]
            mass = SPHERE_KG * (1.5 + 0.5 * 3 / 8 * (A / d) ** 3)
            pull = 9 / 64 * SPHERE_KG * u * u * A**3 / d**4 / mass
            assert np.allclose(far, 0, atol=1e-12)
            assert found[1 if normal[1] else 2] == pytest.approx(pull, rel=1e-6)


@pytest.mark.parametrize("wall", [(0.6, -0.64, 0.48), (-0.28, 0.96, 0.0), (0.0, 0.0, -1.0)])
def test_walls_are_in_the_world_however_the_body_is_turned(wall):
    """A body that moves and turns alike in its own frame, beside a wall that is turned with it: alike in its frame.

    Single precision nowhere: 1e-9 of the pull. Without the wall it is another motion."""
    vehicle = pl.Vehicle.from_dict(drifting((90, 160, 240, 5, 9, 14), (0.9, 0.4, 0.3), 300, (20, 60, 70)))
    nu = [1.3, -0.4, 0.6, 0.2, -0.3, 0.5]
    level = vehicle.accelerations([[0, 0, 5, 0, 0, 0]], [nu], [[]], [[]], walls=[[*wall, 1.1]])[0][0]
    alone = vehicle.accelerations([[0, 0, 5, 0, 0, 0]], [nu], [[]], [[]])[0][0]
    assert np.abs(level - alone).max() > 1e-4
    for roll, pitch, yaw in ((0.3, -0.5, 1.9), (-0.7, 0.4, -2.6)):
        turned = Rotation.from_euler("ZYX", (yaw, pitch, roll)).apply(wall)
        eta = [2.0, -3.0, 5.0, roll, pitch, yaw]
        found = vehicle.accelerations([eta], [nu], [[]], [[]], walls=[[*turned, 1.1]])[0][0]
        assert found == pytest.approx(level, rel=1e-9, abs=1e-9 * np.abs(level - alone).max())


def fly(config, nu, seconds, h, plane_z):
    """Energy, momentum along the plane and least distance over a flight above a bottom at a depth."""
    vehicle = pl.Vehicle.from_dict(config)
    state = vehicle.initial_state(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.array([nu[:3]]), np.array([nu[3:]]))
    walls = Walls([jit.Array3f64(0.0, 0.0, plane_z)], [jit.Array3f64(0.0, 0.0, -1.0)])
    dr.make_opaque(walls)
    none = (dr.zeros(jit.Array3f64, 1), dr.zeros(jit.Array3f64, 1))
    body = vehicle.config.body
    dipoles = vehicle.model.terms["near"].dipoles
    out = []

    @jit.freeze
    def go(state, walls, none, h):
        return vehicle.step(state, [], None, jit.Float64(0.0), none, h, "actuators", Tables(None, None, walls))

    step = dr.opaque(jit.Float64, h)
    for k in range(round(seconds / h) + 1):
        if k % 50 == 0:
            w, x, y, z = np.array(state.attitude).ravel()
            turn = Rotation.from_quat([x, y, z, w])
            v = np.concatenate([np.array(state.velocity).ravel(), np.array(state.angular_velocity).ravel()])
            gap = plane_z - float(state.position[2][0])
            m = body.mass_matrix + matrix(dipoles, gap, turn.inv().apply([0, 0, -1.0]))
            out.append([0.5 * v @ m @ v, *turn.apply((m @ v)[:3])[:2], gap])
        state = go(state, walls, none, step)
    return np.array(out).T


def test_flight_past_the_bottom_keeps_energy_and_momentum():
    """No drag, no weight: the energy of body and water stays, and the impulse along the bottom, while the hull swings
    and is drawn down: what the added mass, its change, suction and Coriolis forces do belongs together. With
    Runge-Kutta all is kept to rounding of the differences in time (1e-4 s); in steps of order 1, to their size.
    """
    half = [0.8, 0.15, 0.15]
    mass = 4 / 3 * math.pi * half[0] * half[1] * half[2] * RHO
    config = drifting(
        (0.05 * mass, 0.9 * mass, 0.9 * mass, 0.0, 6.0, 6.0),
        half,
        mass,
        (0.4 * mass * 0.15**2, *(0.2 * mass * (0.8**2 + 0.15**2),) * 2),
    )
    nu = [1.5, 0.1, -0.05, 0.2, -0.1, 0.15]
    at_rest = 0.5 * np.array(nu) @ pl.Vehicle.from_dict(config).config.body.mass_matrix @ nu
    for integrator, most in (("runge_kutta", 1e-9), ("conservative", 5e-4)):
        energy, north, east, gap = fly({**config, "integrator": integrator}, nu, 0.6, 0.002, 0.4)
        assert energy[0] > 1.004 * at_rest  # there is something to lose
        assert gap.min() > 0.35
        assert [np.ptp(part) for part in (energy, north, east)] == pytest.approx([0.0] * 3, abs=most * energy[0])


def test_walls_that_cannot_be_are_refused():
    inertia = (0.4 * SPHERE_KG * A * A,) * 3
    config = drifting((SPHERE_KG / 2,) * 3 + (0.0,) * 3, [A] * 3, SPHERE_KG, inertia)
    vehicle = pl.Vehicle.from_dict(config)
    at = [[0, 0, 5, 0, 0, 0]], [[0] * 6], [[]], [[]]
    with pytest.raises(CommandError, match="length"):
        vehicle.accelerations(*at, walls=[[0, 0, -2.0, 1.0]])
    for distance in (0.0, -0.5):
        with pytest.raises(CommandError, match="a distance is"):
            vehicle.accelerations(*at, walls=[[0, 0, -1.0, 1.0], [0, 1.0, 0, distance]])
    with pytest.raises(PelagosError, match="a and b are both of type boundary"):
        pl.Vehicle.from_dict({**config, "terms": {k: {"type": "boundary"} for k in "ab"}})
    with pytest.raises(CommandError, match="boundary"):
        pl.Vehicle.from_dict({**config, "terms": {}}).accelerations(*at, walls=[[0, 0, -1.0, 1.0]])
    with pytest.raises(ScenarioError, match="floats"):
        pl.Vehicle.from_catalogue("otter", terms={"near": {"type": "boundary"}})
