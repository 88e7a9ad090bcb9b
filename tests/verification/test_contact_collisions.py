"""Collisions against closed forms: momentum, energy, restitution, friction, whatever the order of the bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.contact.impulse import Colliding, collide, restitution
from pelagos.contact.pairs import PairContacts
from pelagos.math.so3 import rotate_np

H = 0.005


def contacts(point: Any, normal: Any, *, k: float = 2e5, c: float = 300.0, mu: float = 0.4) -> PairContacts:
    """Of bodies 0 and 1, the normals from 1 towards 0."""
    point, normal = np.atleast_2d(point).astype(float), np.atleast_2d(normal).astype(float)
    full = [np.full(len(point), float(v)) for v in (0.0, k, c, mu)]
    zero = np.zeros(len(point), dtype=np.int64)
    return PairContacts(zero, zero + 1, point, normal, *full)


def balls(masses: tuple[float, float], radius: float, velocity: Any) -> Colliding:
    """Two balls that touch at the origin, along x; the first lies at positive x."""
    inverse = [np.diag([1 / m] * 3 + [1 / (0.4 * m * radius**2)] * 3) for m in masses]
    place = np.array([[radius, 0, 0], [-radius, 0, 0]])
    return Colliding(place, np.array(velocity, float), np.zeros((2, 3)), np.array(inverse))


def after(bodies: Colliding, impulses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    gained = np.einsum("bij,bj->bi", bodies.inverse_mass, impulses)
    return bodies.velocity + gained[:, :3], bodies.spin + gained[:, 3:]


@pytest.mark.parametrize("masses", [(8.0, 8.0), (3.0, 20.0)])
@pytest.mark.parametrize("damping", [50.0, 400.0, 1200.0])
def test_central_impact_bounces_as_a_spring_and_a_damper_between_two_masses(masses, damping):
    """v1' - v2' = -e (v1 - v2), e = exp(-pi z / sqrt(1 - z^2)), z = c / (2 sqrt(k m)), m = m1 m2 / (m1 + m2)."""
    bodies = balls(masses, 0.2, [[-1.1, 0, 0], [0.4, 0, 0]])
    velocity, _ = after(bodies, collide(contacts([0, 0, 0], [1, 0, 0], c=damping), bodies, H))
    mass = masses[0] * masses[1] / sum(masses)
    z = damping / (2 * math.sqrt(2e5 * mass))
    e = math.exp(-math.pi * z / math.sqrt(1 - z * z))
    assert e == pytest.approx(restitution(2e5, damping, mass), rel=1e-12)
    assert velocity[0, 0] - velocity[1, 0] == pytest.approx(e * 1.5, rel=1e-9)


def test_a_spring_and_a_damper_integrated_in_small_steps_bounce_likewise():
    """m x'' + c x' + k x = 0 from x = 0 until the bodies part again at x = 0: within 0.1 %."""
    m, k, c, x, v, dt = 5.0, 2e5, 300.0, 0.0, -1.0, 1e-6
    while x < 0.0 or v < 0.0:
        v -= (k * x + c * v) / m * dt
        x += v * dt
    assert v == pytest.approx(restitution(k, c, m), rel=1e-3)


@pytest.mark.parametrize(("mu", "sticks"), [(0.05, False), (0.8, True)])
def test_oblique_impact_slides_or_rolls(mu, sticks):
    """A ball that slides loses mu (1 + e) vn sideways; one that grips goes on with 5/7 of its speed, rolling."""
    radius, fast = 0.3, 0.9
    bodies = balls((4.0, 1.0), radius, [[-1.3, fast, 0], [0, 0, 0]])
    bodies.inverse_mass[1] = 0.0  # a wall
    e = restitution(2e5, 300.0, 4.0)
    velocity, spin = after(bodies, collide(contacts([0, 0, 0], [1, 0, 0], mu=mu), bodies, H))
    assert velocity[0, 0] == pytest.approx(1.3 * e, rel=1e-9)
    assert velocity[0, 1] == pytest.approx(fast * 5 / 7 if sticks else fast - mu * (1 + e) * 1.3, rel=0.01)
    slip = velocity[0, 1] - spin[0, 2] * radius
    assert (abs(slip) < 1e-9) == sticks


@pytest.mark.parametrize("spin", [5.0, -5.0])
def test_a_turning_body_strikes_across_a_gap_only_what_it_turns_towards(spin):
    """Its point at the contact moves by w x r: towards the other at 1.5 m/s it closes a gap of 2 mm within a step."""
    bodies = balls((4.0, 1.0), 0.3, [[0, 0, 0], [0, 0, 0]])
    bodies.position[0] = [0.0, 0.3, 0.0]  # beside the contact: w x r = (0, 0, w) x (0, -0.3, 0) = (0.3 w, 0, 0)
    bodies.spin[0, 2] = spin
    found = contacts([0, 0, 0], [1, 0, 0])
    found.depth[:] = -0.002
    impulses = collide(found, bodies, H)
    if spin > 0:
        assert not impulses.any()  # away along +x
    else:
        assert impulses[0, 0] > 0.1
        assert impulses[0, 5] == pytest.approx(0.3 * impulses[0, 0])  # r x J: against its turn
        assert impulses[0, :3] == pytest.approx(-impulses[1, :3])


def test_bodies_that_overlap_go_no_deeper():
    rov = {"vehicle": "bluerov2", "control": "actuators"}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 30.0},
            "agents": {
                "a": rov | {"start": {"position_m": [0.0, 0.0, -10.0]}},
                "b": rov | {"start": {"position_m": [2.0, 0.1, -10.02], "heading_deg": 30.0}},
            },
        }
    )
    sim.reset()
    turn = math.radians(30.0)
    sim.set_state("b", position=(0.4, 0.1, -10.02), velocity=(-0.3 * math.cos(turn), -0.3 * math.sin(turn), 0.0))
    sim.step(ticks=50)  # towards the other at 0.3 m/s, 5 cm inside it already: unhindered it would be 0.15 m deeper
    apart = sim.state["b"].position[0] - sim.state["a"].position[0]
    assert np.linalg.norm(apart) > np.linalg.norm([0.4, 0.1, 0.02]) - 0.005


def _random(rng: np.random.Generator) -> tuple[PairContacts, Colliding, np.ndarray]:
    """Two bodies of any mass matrix, and contacts that more or less face one way."""
    count = int(rng.integers(1, 7))
    root = rng.normal(size=(2, 6, 6))
    mass = root @ root.transpose(0, 2, 1) * 10 ** rng.uniform(-1, 3, size=(2, 1, 1)) + 0.5 * np.eye(6)
    normal = rng.normal(size=3) + 0.3 * rng.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    zero = np.zeros(count, dtype=np.int64)
    found = PairContacts(
        zero, zero + 1, rng.normal(size=(count, 3)), normal, rng.normal(0, 0.01, count), np.full(count, 2e5),
        rng.uniform(0, 900, count), rng.uniform(0, 1, count),
    )  # fmt: skip
    place = rng.normal(size=(2, 3)) + rng.uniform(-500, 500, size=3)
    bodies = Colliding(place, rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), np.linalg.inv(mass))
    found.point[:] += place.mean(axis=0)
    return found, bodies, mass


@pytest.mark.parametrize("trials", [400, pytest.param(10_000, marks=pytest.mark.slow)])
def test_random_collisions_keep_momentum_and_add_no_energy(trials):
    """Momentum and angular momentum about a point nearby to 1e-9 of the impulse; kinetic energy never grows."""
    rng, happened = np.random.default_rng(4), 0
    for _ in range(trials):
        found, bodies, mass = _random(rng)
        impulses = collide(found, bodies, H)
        about = bodies.position.mean(axis=0)
        size = np.abs(impulses).max() + 1e-300
        assert np.abs(impulses[:, :3].sum(axis=0)).max() <= 1e-9 * size
        turning = impulses[:, 3:] + np.cross(bodies.position - about, impulses[:, :3])
        assert np.abs(turning.sum(axis=0)).max() <= 1e-9 * size
        before = np.concatenate([bodies.velocity, bodies.spin], axis=1)
        now = np.concatenate(after(bodies, impulses), axis=1)
        energy = [0.5 * np.einsum("bi,bij,bj->", v, mass, v) for v in (before, now)]
        assert energy[1] <= energy[0] * (1 + 1e-12)
        happened += impulses.any()
    assert happened > 0.5 * trials


def test_the_order_of_bodies_and_contacts_changes_no_byte():
    rng = np.random.default_rng(8)
    for _ in range(50):
        found, bodies, _ = _random(rng)
        turned = Colliding(*(values[::-1].copy() for values in vars(bodies).values()))
        other = PairContacts(1 - found.first, 1 - found.second, *list(vars(found).values())[2:])
        assert (collide(found, bodies, H) == collide(other, turned, H)[::-1]).all()


def _meeting(names: tuple[str, str]) -> pl.Simulation:
    """Two vehicles, of unlike kinds, on their way into one another."""
    starts = {
        "remus100": {"position_m": [0.0, 0.0], "depth_m": 10.0, "speed_mps": 1.6},
        "bluerov2": {"position_m": [1.6, 0.05], "depth_m": 10.02, "heading_deg": 150.0, "speed_mps": 0.6},
    }
    agents = {
        name: {"vehicle": kind, "start": starts[kind], "sensors": {"bump": {"type": "collision", "rate_hz": 100}}}
        for name, kind in zip(names, starts, strict=True)
    }
    order = dict(sorted(agents.items()))
    return pl.Simulation.load({"tick_rate_hz": 200, "world": {"type": "flat", "depth_m": 40.0}, "agents": order})


def _world_wrench(sim: pl.Simulation, agent: str, attitude: np.ndarray) -> np.ndarray:
    from pelagos.math.so3 import rotate_np

    return rotate_np(attitude, sim.stepper.contact(agent)[:, :3])[0]


def test_vehicles_get_equal_and_opposite_impulses_whatever_their_names():
    """Of one solution at the same states: forces in the world frame cancel to rounding, at every tick."""
    runs = []
    for names in (("a", "b"), ("z", "b")):
        sim, struck, track = _meeting(names), 0, []
        for _ in range(140):
            before = {name: state.attitude for name, state in sim.state.items()}
            sim.step()
            force = [_world_wrench(sim, name, before[name]) for name in names]
            assert np.abs(force[0] + force[1]).max() <= 1e-9 * (1.0 + np.abs(force[0]).max())
            struck += np.abs(force[0]).max() > 1.0
            track.append(np.concatenate([sim.state[name].position[0] for name in names]))
        assert struck > 0
        runs.append(np.array(track))
    assert (runs[0] == runs[1]).all()


def test_depth_is_that_of_the_surface_and_not_of_the_ray():
    """Probes of a tilted hull in a turned plate: for each end beyond the face, (c - n.x) along the face's normal."""
    turn, thick = math.radians(35.0), 4.0
    plate = {"shape": "box", "position_m": [3.0, 2.0, -9.0], "size_m": [thick, 30.0, 30.0],
             "orientation_deg": [0.0, 0.0, 35.0]}  # fmt: skip
    agent = {"vehicle": "bluerov2", "start": {"depth_m": 9.0}}
    sim = pl.Simulation.load(
        {"world": {"type": "flat", "depth_m": 40.0}, "props": {"plate": plate}, "agents": {"it": agent}}
    )
    normal = -np.array([math.cos(turn), math.sin(turn), 0.0])  # of the face that looks towards the origin
    level = normal @ [3.0, 2.0, -9.0] + thick / 2
    heart = np.array([1.15, 1.0, -9.0])
    sim.set_state("it", position=heart, attitude=(0.9, 0.2, -0.3, 0.25))
    collisions = sim.stepper.contacts._collisions
    collisions.look()
    name = next(iter(sim.stepper.runs))
    moved = collisions._free(sim.stepper._motions(), {}, {}, H)
    found = collisions._cast(np.array([[0, 1]]), moved, H)
    starts, vectors = sim.model.batches[name].vehicle.probes
    tips = rotate_np(np.tile(moved.attitude[:1], (len(starts), 1)), starts + vectors) + heart
    depth = level - tips @ normal
    assert len(found.depth) > 5
    assert np.ptp(found.depth) > 0.02
    nearest = np.abs(depth[None] - found.depth[:, None]).min(axis=1)
    np.testing.assert_allclose(nearest, 0.0, atol=2e-5)
    np.testing.assert_allclose(found.normal, np.broadcast_to(normal, found.normal.shape), atol=1e-5)
    np.testing.assert_allclose(found.point @ normal, level, atol=2e-5)
