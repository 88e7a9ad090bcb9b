"""Pure functions of `hydro` against closed forms and linear algebra."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.hydro import added_mass, crossflow, restoring, rigid_body, thruster
from pelagos.hydro.algebra import matmul, matvec, solve_symmetric
from pelagos.hydro.coriolis import coriolis_force, coriolis_matrix


def f64(values):
    return [jit.Float64(float(v)) for v in values]


def numbers(values):
    return np.array([float(jit.Float64(v)[0]) for v in values])


# H. Lamb, Hydrodynamics, Sections 114 and 115; six decimals
@pytest.mark.parametrize(
    ("ratio", "axial", "lateral", "rotary"),
    [
        (1.5, 0.303749, 0.622084, 0.095124),
        (2, 0.210015, 0.704210, 0.239424),
        (4, 0.081557, 0.859761, 0.607938),
        (8, 0.029253, 0.944728, 0.839395),
        (10, 0.020706, 0.960235, 0.883538),
    ],
)
def test_lamb_factors_of_prolate_spheroids(ratio, axial, lateral, rotary):
    k = added_mass.lamb_factors(ratio, 1.0)
    assert (k.axial, k.lateral, k.rotary) == pytest.approx((axial, lateral, rotary), abs=6e-7)


def test_lamb_factors_run_into_the_needle():
    """Along it nothing, across it the fluid that it displaces: to (b / a)^2 ln(a / b)."""
    thin, needle = added_mass.lamb_factors(1.0, 1e-7), added_mass.lamb_factors(1.0, 1e-9)
    for k in (thin, needle):
        assert (k.axial, k.lateral, k.rotary) == pytest.approx((0.0, 1.0, 1.0), abs=1e-12)
    assert thin.axial > needle.axial


def test_lamb_factors_run_into_the_sphere():
    """Both branches agree where they meet, and the sphere has half its displaced mass."""
    near, nearer = added_mass.lamb_factors(1.0003, 1.0), added_mass.lamb_factors(1.0001, 1.0)
    assert near.axial == pytest.approx(nearer.axial, abs=2e-4)
    sphere = added_mass.lamb_factors(1.0, 1.0)
    assert (sphere.axial, sphere.lateral, sphere.rotary) == pytest.approx((0.5, 0.5, 0.0))
    assert np.diag(added_mass.sphere(1000.0, 0.1))[:3] == pytest.approx(1000 * 2 / 3 * np.pi * 1e-3)


def test_added_mass_of_a_cylinder_is_rho_pi_r2_a_metre():
    a = np.diag(added_mass.cylinder(1025.0, 0.2, 3.0))
    assert a[1] == pytest.approx(1025 * np.pi * 0.04 * 3)
    assert a[5] == pytest.approx(1025 * np.pi * 0.04 * 27 / 12)


def spd(seed):
    a = np.random.default_rng(seed).normal(size=(6, 6))
    return a @ a.T + 6 * np.eye(6)


@pytest.mark.parametrize("seed", range(5))
def test_coriolis_matrix_is_skew_symmetric_and_power_free(seed):
    m, nu = spd(seed), np.random.default_rng(seed + 100).normal(size=6)
    c = np.array([numbers(row) for row in coriolis_matrix(m.tolist(), f64(nu))])
    assert np.abs(c + c.T).max() < 1e-12
    assert numbers(coriolis_force(m.tolist(), f64(nu))) == pytest.approx(c @ nu, rel=1e-12)
    assert abs(nu @ c @ nu) < 1e-10


@pytest.mark.parametrize("seed", range(3))
def test_solver_equals_lapack(seed):
    m, b = spd(seed), np.random.default_rng(seed).normal(size=6)
    x = solve_symmetric([f64(row) for row in m], f64(b))
    assert numbers(x) == pytest.approx(np.linalg.solve(m, b), rel=1e-11)


def test_known_zeros_cost_nothing():
    x = f64(range(6))
    assert matvec([[0.0] * 6, [1.0, 0, 0, 0, 0, 0]], x) == [0.0, x[0]]
    assert matmul([[0.0, 2.0]], [[3.0], [4.0]]) == [[8.0]]


def test_moving_the_origin_keeps_energy():
    r, nu = np.array([0.3, -0.1, 0.2]), np.array([1.0, 0.2, -0.3, 0.1, 0.4, -0.2])
    at_cg = np.diag([10.0, 10, 10, 0.4, 0.9, 1.1])
    about_origin = rigid_body.mass_matrix(10.0, at_cg[3:, 3:], r)
    v_cg = rigid_body.transport(r) @ nu
    assert nu @ about_origin @ nu == pytest.approx(v_cg @ at_cg @ v_cg)


def test_cross_flow_of_pure_sway_and_pure_yaw():
    """Sway: rho/2 T Cd L v^2. Yaw: rho/2 T Cd r^2 L^4/32, twice the integral of x^3 to half the length."""
    length, n = 1.6, 400
    places, width = crossflow.strips(length, n, closed=False)
    factor = 0.5 * 1026 * 0.19 * 1.2 * width
    force, moment = crossflow.strip_drag(factor, places, jit.Float64(0.5), jit.Float64(0.0))
    assert float(force[0]) == pytest.approx(-0.5 * 1026 * 0.19 * 1.2 * length * 0.25, rel=1e-12)
    assert abs(float(moment[0])) < 1e-12
    _, moment = crossflow.strip_drag(factor, places, jit.Float64(0.0), jit.Float64(0.7))
    assert float(moment[0]) == pytest.approx(-0.5 * 1026 * 0.19 * 1.2 * 0.49 * length**4 / 32, rel=1e-4)


def test_hoerner_table_is_held_at_its_ends():
    assert crossflow.hoerner_drag_coefficient(0.001, 1.0) == 1.9661
    assert crossflow.hoerner_drag_coefficient(100.0, 1.0) == 0.5593
    assert crossflow.hoerner_drag_coefficient(1.0, 1.0) == pytest.approx(1.2108 - 0.0067 / 0.0652 * 0.1272)


@pytest.mark.parametrize(("depth", "share"), [(-1.0, 0.0), (0.0, 0.5), (1.0, 1.0)])
def test_buoyancy_of_an_ellipsoid_at_the_surface(depth, share):
    axes = [0.8, 0.1, 0.2]
    down = f64([0.0, 0.0, 1.0])
    wet = restoring.submerged(0.0, 100.0, [0.0] * 3, [0.0] * 3, down)
    lost = restoring.emerged_ellipsoid(100.0, axes, [0.0] * 3, down, jit.Float64(depth))
    assert (numbers(wet) + numbers(lost))[2] == pytest.approx(-100 * share, abs=1e-12)


def test_buoyancy_of_a_tilted_ellipsoid_equals_counting_points():
    """200 000 points in the ellipsoid: the share and first moment of those under water, to the noise of the count."""
    axes, depth = np.array([0.8, 0.15, 0.2]), 0.05
    down = np.array([0.3, -0.4, 0.866])
    down /= np.linalg.norm(down)
    random = np.random.default_rng(1)
    y = random.normal(size=(200_000, 3))
    y *= (random.uniform(size=len(y)) ** (1 / 3) / np.linalg.norm(y, axis=1))[:, None]
    x = y * axes
    under = x[(x @ down + depth) > 0]
    force = -100 * len(under) / len(x) * down
    moment = np.cross(under.sum(axis=0) / len(x), -100 * down)
    d = f64(down)
    got = numbers(restoring.submerged(0.0, 100.0, [0.0] * 3, [0.0] * 3, d)) + numbers(
        restoring.emerged_ellipsoid(100.0, axes.tolist(), [0.0] * 3, d, jit.Float64(depth))
    )
    assert got[:3] == pytest.approx(force, abs=0.4)
    assert got[3:] == pytest.approx(moment, abs=0.15)


def test_open_water_load_of_the_remus_propeller():
    """KT 0.4566 at rest and 0.1798 at J = 0.6632 (Allen et al. 2000): T = rho n^2 D^4 KT at both points."""
    rho, d, n = 1026.0, 0.14, 20.0
    c = thruster.open_water(rho, d, 0.4566, 0.1798, 0.6632, torque=False)
    for j, kt in ((0.0, 0.4566), (0.6632, 0.1798)):
        load = thruster.open_water_load(c, jit.Float64(n), jit.Float64(j * n * d))
        assert float(load[0]) == pytest.approx(rho * n**2 * d**4 * kt, rel=1e-12)
