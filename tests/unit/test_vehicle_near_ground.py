"""Ground and walls near a vehicle by geometry: depth and its slope, added mass by the depth, and how far from rest."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos import jit
from pelagos.hydro.images import Plane
from pelagos.vehicles.blame import blame
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.flow import FAR_M, Flow
from pelagos.vehicles.nearby import GroundMass, Walls, level_ground, planes_of
from pelagos.vehicles.wetness import Floating

TURN = Rotation.from_euler("ZYX", [1.9, -0.2, 0.3])  # FRD to NED
PLACE = np.array([40.0, -25.0, 1.5])
NU = np.array([2.0, -0.7, 0.3, 0.05, -0.04, 0.1])


def lanes(values: Any) -> list[Any]:
    return [jit.Float64(float(v)) for v in values]


def numbers(values: Any) -> np.ndarray:
    return np.array([float(np.array(v).ravel()[0]) for v in values])


def walls() -> Walls:
    """A slope that falls to the north east, a steeper one deeper down, and a quay wall 9 m away."""
    points = ([40.0, -25.0, 14.0], [40.0, -25.0, 30.0], [49.0, -25.0, 0.0])
    normals = ([0.2, 0.3, -1.0], [0.1, -0.7, -1.0], [-1.0, 0.0, 0.0])
    units = [np.array(n) / np.linalg.norm(n) for n in normals]
    return Walls([jit.Array3f64(*p) for p in points], [jit.Array3f64(*map(float, n)) for n in units])


def flow(place: np.ndarray = PLACE, turn: Rotation = TURN, **parts: Any) -> Flow:
    rotation = [lanes(row) for row in turn.as_matrix()]
    at = lanes(place)
    made = Flow(at, at[2] + 0.4, rotation, lanes(NU), lanes(NU + 0.1), lanes(np.zeros(6)), **parts)
    return replace(made, planes=planes_of(walls(), at, rotation))


def test_planes_are_seen_from_the_body() -> None:
    found = flow().planes
    for plane, point, normal in zip(found, walls().points, walls().normals, strict=True):
        out = numbers(normal)
        assert float(plane.distance[0]) == pytest.approx(out @ (PLACE - numbers(point)), rel=1e-12)
        assert numbers(plane.normal) == pytest.approx(TURN.inv().apply(out), rel=1e-12)


def test_the_depth_is_that_below_and_its_slope_that_of_the_way() -> None:
    """z of the nearer slope below the place, from the surface 0.4 m above the sea's mean; walls are no ground."""
    ground = lambda place: 14.0 + 0.2 * (place[0] - 40.0) + 0.3 * (place[1] + 25.0)  # n . (p - p0) = 0
    for place in (PLACE, PLACE + np.array([3.0, -8.0, 0.7])):
        assert float(flow(place).depth[0]) == pytest.approx(ground(place) + 0.4, rel=1e-12)
    small = 1e-3
    for way in ([small, 0.0, 0.0], [0.0, small, 0.0]):
        there, here = flow(PLACE + way), flow()
        change = float(there.depth[0] - here.depth[0])
        assert numbers(here.depth_gradient) @ TURN.inv().apply(way) == pytest.approx(change, rel=1e-6)
    assert numbers(flow().depth_gradient) @ TURN.inv().apply([0.0, 0.0, 1.0]) == pytest.approx(0, abs=1e-12)
    alone = replace(flow(), planes=[p for k, p in enumerate(flow().planes) if k == 2])
    assert float(jit.Float64(alone.depth)[0]) == FAR_M
    assert numbers(alone.depth_gradient) == pytest.approx([0, 0, 0])


def test_level_ground_is_far_where_it_is_out_of_reach() -> None:
    depths = np.array([12.0, 12.0, 12.0, 1.0])
    place = [jit.Float64(np.full(4, v)) for v in (3.0, -4.0)] + [jit.Float64([2.0, 3.0, 7.0, 1.5])]
    found = level_ground(place, jit.Float64(depths), jit.Float64(9.5))
    z = np.array(found.points[0])[2] - [2.0, 3.0, 7.0, 1.5]
    assert z == pytest.approx([FAR_M, 9.0, 5.0, FAR_M])  # 10 m below is too far; above the ground there is none
    assert np.array(found.normals[0]).ravel() == pytest.approx([0, 0, -1])


def test_added_mass_grows_by_the_water_under_the_keel_and_takes_its_momentum() -> None:
    """M = g T/(h - T): its slope by the depth, and along the way half of nu M' nu less M' nu dh/dt."""
    growth = [30.0, 200.0, 400.0, 1e3, 3e3, 2e3]
    part = GroundMass(4.0, growth, momentum=True)
    mass = lambda place: np.array([[float(jit.Float64(x)[0]) for x in row] for row in part.image_mass(flow(place))])
    depth = lambda place: float(flow(place).depth[0])
    assert mass(PLACE) == pytest.approx(np.diag(growth) * 4.0 / (depth(PLACE) - 4.0), rel=1e-12)
    way = np.array([1e-3, 0.0, 0.0])
    slope = (mass(PLACE + way) - mass(PLACE - way)) / (depth(PLACE + way) - depth(PLACE - way))
    relative = np.concatenate([NU[:3] + 0.1, NU[3:]])
    gradient = numbers(flow().depth_gradient)
    expected = -slope @ relative * (gradient @ NU[:3])
    expected[:3] += 0.5 * (relative @ slope @ relative) * gradient
    assert numbers(part.shoaling(flow())) == pytest.approx(expected, rel=1e-6)
    shoal = replace(part, draught=13.0)  # 1.2 draughts are more than the depth: held
    assert float(jit.Float64(shoal.shallow(flow()))[0]) == pytest.approx(1 / 0.2)
    assert numbers(shoal.shoaling(flow())) == pytest.approx(np.zeros(6))


@pytest.mark.parametrize(
    ("heave", "roll_deg", "pitch_deg", "share"),
    [(0.9, 5, 5, 0.0), (-1.3, 0, 0, 0.5), (1.3, 10, 0, 0.5), (-1.7, 0, 0, 1.0), (0.0, 14, 4, 0.0), (0.0, -20, 16, 1.0)],
)
def test_a_hull_is_far_from_rest_by_heave_or_tilt(
    heave: float, roll_deg: float, pitch_deg: float, share: float
) -> None:
    """From half to 0.8 of 2 m and from 15 to 25 degrees, smoothly: half of the way is a half; the larger one counts."""
    hull = Floating([3.0, 1.0, 1.0], [0.0, 0.0, 0.1], 0.5, 2.0)
    turn = Rotation.from_euler("ZYX", [0.7, *np.radians([pitch_deg, roll_deg])])
    at = replace(flow(turn=turn), immersion=jit.Float64(heave))
    assert float(hull.far(at)[0]) == pytest.approx(share, abs=1e-9)
    x = (np.cos(np.radians(15)) - np.cos(np.radians(18))) / (np.cos(np.radians(15)) - np.cos(np.radians(25)))
    at = replace(flow(turn=Rotation.from_euler("ZYX", [0.7, 0.0, np.radians(-18)])), immersion=jit.Float64(0.2))
    assert float(hull.far(at)[0]) == pytest.approx(x * x * (3 - 2 * x), rel=1e-9)


def test_a_banked_circle_grows_with_the_square_of_the_speed() -> None:
    banked = EnvelopeConfig(cruise_mps=20.0, turn_radius_m=60.0, turn_speed_mps=20.0)
    assert [banked.smallest_circle_m(v) for v in (10.0, 30.0)] == [15.0, 135.0]
    assert EnvelopeConfig(turn_radius_m=60.0).smallest_circle_m(30.0) == 60.0
    assert EnvelopeConfig().smallest_circle_m(30.0) == 0.0


def test_the_term_that_is_largest_is_blamed() -> None:
    """In air-borne numbers of the world: damping at speed, weight at rest; and what is no number is named first."""
    vehicle = pl.Vehicle.from_catalogue("remus100")
    at, level, still = np.array([0.0, 0.0, -20.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    loads = {}
    for name, velocity in (("slow", still), ("sideways", np.array([0.0, 9.0, 0.0]))):
        said = blame(vehicle, at, level, velocity, still)
        assert said.startswith("largest term: ")
        loads[name] = said.removeprefix("largest term: ").split(",")
    assert loads["slow"][0] != loads["sideways"][0]
    size = float(loads["sideways"][1].split()[0])
    assert size > 1000 * max(float(loads["slow"][1].split()[0]), 1e-3) or size > 500
    assert blame(vehicle, at, level, np.array([np.nan, 0.0, 0.0]), still).startswith("not finite: ")


def test_planes_that_nobody_has_are_none() -> None:
    assert planes_of(None, lanes(PLACE), []) == []
    assert isinstance(flow().planes[0], Plane)
