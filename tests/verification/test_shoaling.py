"""Added mass that changes with the depth on a ship's way: energy and momentum stay."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos import jit
from pelagos.errors import ScenarioError
from pelagos.hydro.shallow_water import depth_factors
from pelagos.vehicles.nearby import Walls
from pelagos.vehicles.tables import Tables

MASS, DRAUGHT = 9.0e6, 6.0
ADDED = [4e5, 8e6, 9e6, 1e7, 3e9, 3.5e9]
GROWTH = [3e5, 4e6, 0.0, 0.0, 0.0, 6e8]


def body(**more: Any) -> dict[str, Any]:
    """A ship without drag or weight, whose added mass grows with 6 m over the water under the keel."""
    return {
        "type": "custom", "length_m": 90.0, "beam_m": 14.0, "height_m": 9.0, "gravity_m_s2": 0.0,
        "mass": {"type": "explicit", "mass_kg": MASS, "inertia_kg_m2": [2e8, 4e9, 4e9]},
        "added_mass": {
            "type": "shallow", "diagonal": ADDED, "growth": GROWTH, "draught_m": DRAUGHT, "water_depth_m": "world",
            "momentum": True, **more,
        },
        "integrator": "runge_kutta", "default_mode": "actuators", "modes": {"actuators": {"type": "actuators"}},
    }  # fmt: skip


def plane(depth: float, north: float, east: float) -> list[float]:
    """Ground NED that is `depth` below the origin and falls by slopes towards north and east."""
    normal = np.array([north, east, -1.0]) / math.sqrt(1 + north**2 + east**2)
    return [*normal, -normal[2] * depth]


def mass_at(depth: float) -> np.ndarray:
    return np.diag([MASS, MASS, MASS, 2e8, 4e9, 4e9] + np.array(ADDED) + DRAUGHT / (depth - DRAUGHT) * np.array(GROWTH))


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.1])
def test_the_change_of_depth_takes_what_lagrange_says(yaw):
    """Beside the same ship without it: -dh/dt M' nu, and 1/2 nu' M' nu along the slope; h' by its way over ground."""
    nu, depth, slopes = np.array([4.0, -0.6, 0, 0, 0, 0.02]), 11.0, np.array([-0.03, 0.02])
    eta = [[0, 0, 0, 0, 0, yaw]]
    wall = [plane(depth, *slopes)]
    found, without = (
        mass_at(depth) @ pl.Vehicle.from_dict(body(momentum=on)).accelerations(eta, [nu], [[]], [[]], walls=wall)[0][0]
        for on in (True, False)
    )
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    gradient = turn.T @ slopes
    slope = -DRAUGHT / (depth - DRAUGHT) ** 2 * np.array(GROWTH)
    expected = -(gradient @ nu[:2]) * slope * nu
    expected[:2] += 0.5 * (nu @ (slope * nu)) * gradient
    assert found - without == pytest.approx(expected, rel=1e-9, abs=1e-6 * np.abs(expected).max())
    assert np.abs(expected[[0, 1, 5]]).min() > 100


def sail(vehicle: dict[str, Any], nu: list[float], seconds: float, h: float, slope: float) -> np.ndarray:
    """North, east, down of the origin and nu FRD at every half second over ground 12 m deep that rises northwards."""
    ship = pl.Vehicle.from_dict(vehicle)
    fleet = [np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.array([nu[:3]]), np.array([nu[3:]])]
    state = ship.initial_state(*fleet)
    normal = np.array([-slope, 0.0, -1.0]) / math.hypot(1, slope)
    walls = Walls([jit.Array3f64(0.0, 0.0, 12.0)], [jit.Array3f64(*map(float, normal))])
    none = (dr.zeros(jit.Array3f64, 1), dr.zeros(jit.Array3f64, 1))
    dr.make_opaque(walls)

    @jit.freeze
    def go(state, walls, none, h):
        return ship.step(state, [], None, jit.Float64(0.0), none, h, "actuators", Tables(None, None, walls))

    step, rows = dr.opaque(jit.Float64, h), []
    for k in range(round(seconds / h) + 1):
        if k % round(0.5 / h) == 0:
            w, x, y, z = np.array(state.attitude).ravel()
            yaw = Rotation.from_quat([x, y, z, w]).as_euler("ZYX")[0]
            v, spin = np.array(state.velocity).ravel(), np.array(state.angular_velocity).ravel()
            rows.append([*np.array(state.position).ravel(), yaw, *v, *spin])
        state = go(state, walls, none, step)
    return np.array(rows)


def test_a_drifting_ship_over_a_shoal_keeps_energy_and_momentum_along_it():
    """No drag: the energy of ship and water, and their momentum along the lines of equal depth, stay to rounding of
    Runge-Kutta's steps while the ship turns over 3.6 m of rise; without the key they change by parts in a hundred."""
    drift = {}
    for on in (True, False):
        track = sail(body(momentum=on), [5.0, -0.8, 0.0, 0.0, 0.0, 0.03], 18.0, 0.05, 0.04)
        depth = 12.0 - 0.04 * track[:, 0]
        assert depth.min() < 9.5
        energy, along = [], []
        for h, row in zip(depth, track, strict=True):
            nu, p = row[4:], mass_at(h) @ row[4:]
            energy.append(0.5 * nu @ p)
            along.append(p[0] * math.sin(row[3]) + p[1] * math.cos(row[3]))
        drift[on] = np.ptp(energy) / energy[0], np.ptp(along) / np.abs(along).max()
    assert max(drift[True]) < 1e-7
    assert min(drift[False]) > 0.01


def test_a_ship_that_goes_straight_up_a_slope_slows_by_the_root_of_its_mass():
    """1/2 (m + m_a(h)) u^2 stays: u = u_0 sqrt((m + m_a(h_0))/(m + m_a(h)))."""
    track = sail(body(), [5.0, 0, 0, 0, 0, 0], 20.0, 0.05, 0.04)
    depth = 12.0 - 0.04 * track[:, 0]
    mass = MASS + ADDED[0] + GROWTH[0] * DRAUGHT / (depth - DRAUGHT)
    assert mass[-1] / mass[0] > 1.03
    assert track[:, 4] == pytest.approx(5.0 * np.sqrt(mass[0] / mass), rel=1e-9)


def test_mmg_ships_lose_the_momentum_of_clarkes_factors():
    """KVLCC2 over ground that rises by 1 in 30 ahead: dM/dh of the factors by differences of another width."""
    nu, depth = np.array([6.5, 0.4, 0, 0, 0, -0.004]), 31.2
    found = []
    for on in (True, False):
        ship = {"type": "kvlcc2", "actuators": {"rudder": {"shallow_water": {"midship": 0.998, "momentum": on}}}}
        vehicle = pl.Vehicle.from_dict(ship)
        found.append(vehicle.accelerations([[0] * 6], [nu], [[0]], [[0]], walls=[plane(depth, -1 / 30, 0.0)])[0][0])
    body = pl.Vehicle.from_dict({"type": "kvlcc2"}).config.body
    here, (after, before) = (
        depth_factors(depth / 20.8, 58 / 20.8),
        (depth_factors((depth + d) / 20.8, 58 / 20.8) for d in (0.01, -0.01)),
    )
    m, slope = body.mass_matrix.copy(), np.zeros(6)
    for axis, name in ((1, "sway_mass"), (5, "yaw_mass")):
        m[axis, axis] += body.added[axis, axis] * (getattr(here, name) - 1)
        slope[axis] = body.added[axis, axis] * (getattr(after, name) - getattr(before, name)) / 0.02
    expected = 6.5 / 30 * slope * nu
    expected[0] -= 0.5 * (nu @ (slope * nu)) / 30
    assert m @ (found[0] - found[1]) == pytest.approx(expected, rel=1e-5, abs=1.0)
    assert expected[1] < -1e5


def test_less_water_than_is_known_keeps_its_mass():
    """Held at 1.2 draughts: no slope there, and no force."""
    nu = [[4.0, -0.6, 0, 0, 0, 0.02]]
    with_it, without = (
        pl.Vehicle.from_dict(body(momentum=on)).accelerations(
            [[0] * 6], nu, [[]], [[]], walls=[plane(1.1 * DRAUGHT, 0.05, 0.0)]
        )[0]
        for on in (True, False)
    )
    assert (with_it == without).all()


def test_momentum_without_the_worlds_depth_is_refused():
    with pytest.raises(ScenarioError, match="water_depth_m: world goes with it"):
        pl.Vehicle.from_dict(body(water_depth_m=20.0))
