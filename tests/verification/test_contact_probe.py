"""Hull-ray contact on a hull with known mass: rest, impact, slope, moving floor."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.contact.probe import _gram, hull_probes, probe_wrench
from pelagos.hydro.rigid_body import skew
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.world.material import MATERIALS, material_tables

MASS, RADIUS, H = 40.0, 0.1, 0.005
INERTIA = 0.4 * MASS * RADIUS**2
M = np.diag([MASS] * 3 + [INERTIA] * 3)


def floor(tilt=0.0) -> Geometry:
    s, c = np.sin(tilt), np.cos(tilt)
    corners = np.array([[-50 * c, -50, -50 * s], [50 * c, -50, 50 * s], [50 * c, 50, 50 * s], [-50 * c, 50, -50 * s]])
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), 0, 1, 1)


def sphere_probes(count=60, grip=1.0):
    k = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * k / count), np.pi * (1 + 5**0.5) * k
    along = np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=-1)
    along = np.concatenate([along, [[0, 0, -1.0]]])
    return hull_probes(np.zeros_like(along), RADIUS * along, M, grip)


class Ball:
    """A ball in a vacuum under `weight` [N], semi-implicit Euler, as the vehicles' default."""

    def __init__(self, geometry, material, *, position, velocity=(0, 0, 0), weight=20.0, body=None, grip=1.0):
        self.scene = Scene([] if body else [geometry])
        if body:
            self.scene.set_moving([(geometry, 0)])
            zero = np.zeros((1, 3))
            self.scene.move(zero, np.array([[1.0, 0, 0, 0]]), np.array([body]), zero)
        self.x, self.v, self.w = np.array(position, float), np.array(velocity, float), np.zeros(3)
        self.weight = np.array([0, 0, -weight])
        self.arguments = (material_tables([MATERIALS[material]]), sphere_probes(grip=grip))

        def run(caster, materials, probes, x, v, w, q, own, copy, h):
            return probe_wrench(
                caster, materials, probes,
                position=x, attitude=q, velocity=v, angular_velocity=w, own=own, copy=copy, h=h)  # fmt: skip

        self.call = self.scene.compile(run)
        self.fixed = (jit.Array4f64([1.0], [0.0], [0.0], [0.0]), jit.UInt32([NO_BODY]), dr.zeros(jit.UInt32, 1),
                      dr.opaque(jit.Float64, H))  # fmt: skip

    def step(self) -> np.ndarray:
        vectors = [jit.Array3f64(*[[float(c)] for c in a]) for a in (self.x, self.v, self.w)]
        force, moment = self.call(*self.arguments, *vectors, *self.fixed)
        force, moment = np.array(force)[:, 0], np.array(moment)[:, 0]
        self.v += H * (force + self.weight) / MASS
        self.w += H * moment / INERTIA
        self.x += H * self.v
        return force


def test_resting_force_equals_weight():
    ball = Ball(floor(), "concrete", position=(0, 0, RADIUS))
    forces = np.array([ball.step() for _ in range(2000)])
    assert np.allclose(forces[-200:].mean(axis=0), -ball.weight, atol=0.02 * 20)
    assert RADIUS - 0.01 < ball.x[2] <= RADIUS
    assert abs(ball.v).max() < 1e-3


@pytest.mark.parametrize("speed", [0.5, 1.5, 3.0])
def test_impact_impulse_is_mass_times_change_of_speed_and_loses_energy(speed):
    ball = Ball(floor(), "concrete", position=(0, 0, RADIUS + 0.2), velocity=(0, 0, -speed), weight=0.0)
    forces = np.array([ball.step() for _ in range(400)])
    assert forces[:, 2].sum() * H == pytest.approx(MASS * (ball.v[2] + speed), rel=0.02)
    assert 0 < ball.v[2] < speed
    assert (forces[:, 2] >= 0).all()


def test_nothing_passes_at_three_metres_per_second():
    ball = Ball(floor(), "mud", position=(0, 0, RADIUS + 0.2), velocity=(1.0, 0, -3.0))
    lowest = min(ball.step()[2] * 0 + ball.x[2] for _ in range(600))
    assert lowest > 0.0


@pytest.mark.parametrize("gap", [0.003, 0.05, 0.11])
def test_a_step_that_is_longer_than_a_hulls_probes_passes_through_nothing(gap):
    ball = Ball(floor(), "mud", position=(0, 0, RADIUS + gap), velocity=(0, 0, -60.0))  # 0.3 m a step, probes of 0.1 m
    lowest = min(ball.step()[2] * 0 + ball.x[2] for _ in range(100))
    assert lowest > 0.0


def test_a_push_beside_the_centre_turns_a_ball_that_grips():
    """A ball that is set down sliding ends up rolling, 5/7 of its speed: the moment of friction, every sign of it."""
    for heading in (0.4, 2.6):
        way = np.array([np.cos(heading), np.sin(heading), 0.0])
        ball = Ball(floor(), "concrete", position=(0, 0, RADIUS), velocity=0.5 * way)
        for _ in range(400):
            ball.step()
        assert ball.v @ way == pytest.approx(0.5 * 5 / 7, rel=0.05)  # the floor gives way by millimetres
        assert ball.w == pytest.approx(np.cross([0, 0, 1.0], ball.v) / RADIUS, abs=0.1 * 0.5 / RADIUS)


def test_a_damper_beside_the_centre_acts_on_six_axes_as_its_jacobian_says():
    """J^T J of J = (1, -[r]x): what the velocity at r does to force and moment; the lower triangle."""
    r = np.array([0.3, -0.7, 0.45])
    jacobian = np.hstack([np.eye(3), -skew(r)])
    found = np.zeros(21)
    for place, value in _gram(jit.Array3f64(*r.tolist())):
        found[place] += np.array(jit.Float64(value))[0]
    expected = jacobian.T @ jacobian
    pairs = [(i, j) for i in range(6) for j in range(i + 1)]
    assert found == pytest.approx(np.array([expected[i, j] for i, j in pairs]), abs=1e-12)


@pytest.mark.parametrize(("tilt", "grip", "slides"), [(0.2, 1.0, False), (0.9, 1.0, True), (0.2, 0.2, True)])
def test_coulomb_friction_holds_below_its_angle(tilt, grip, slides):
    """tan(tilt) against concrete's friction (0.5) times the hull's grip; spin is stopped: the ball cannot roll."""
    ball = Ball(floor(tilt), "concrete", position=(0, 0, RADIUS / np.cos(tilt)), grip=grip)
    for _ in range(1500):
        ball.step()
        ball.w[:] = 0
    speed = np.linalg.norm(ball.v)
    assert (speed > 0.1) == slides
    if slides:  # a = g (sin - mu cos)
        free = 20.0 / MASS * (np.sin(tilt) - 0.5 * grip * np.cos(tilt)) * 1500 * H
        assert speed == pytest.approx(free, rel=0.03)  # it spins up to the start's slip first: 2.2 % at the least slope
    if not slides:
        assert speed < 0.01  # regularised friction creeps at a part of CREEP


def test_a_moving_floor_carries_what_lies_on_it():
    ball = Ball(floor(), "concrete", position=(0, 0, RADIUS), body=(0.4, 0.0, 0.0))
    for _ in range(1500):
        ball.step()
        ball.w[:] = 0
    assert ball.v[0] == pytest.approx(0.4, abs=0.02)


def test_no_contact_no_force():
    ball = Ball(floor(), "concrete", position=(0, 0, RADIUS + 1e-3), weight=0.0)
    assert (ball.step() == 0).all()
