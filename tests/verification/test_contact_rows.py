"""Rows, copies, frames and steps of what touches and is near, in simulations of several batches: no scene is cast."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Final

import drjit as dr
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.contact.pairs import PairContacts
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.sim import boundaries, collisions, touch
from pelagos.sim.collisions import Collisions
from pelagos.vehicles.state import StateSizes

Values = NDArray[np.float64]
FLIP: Final = np.array([1.0, -1.0, -1.0])
FLIP6: Final = np.concatenate([FLIP, FLIP])


def quaternions(turns: Rotation) -> Values:
    return np.asarray(turns.as_quat()[:, [3, 0, 1, 2]])


def block(low: list[float], high: list[float]) -> Geometry:
    corners = np.array([[(low, high)[k >> a & 1][a] for a in range(3)] for k in range(8)], dtype=np.float64)
    return Geometry(corners, np.array([[0, 2, 1], [4, 5, 6]], dtype=np.uint32), 0, 1, 1)


HULLS: Final = {"a": block([-0.5, -0.3, -0.2], [0.9, 0.4, 0.3]), "b": block([-2.0, -0.6, -0.5], [1.0, 0.5, 0.7])}
BODIES: Final = [block([-0.2, -0.2, -0.1], [0.3, 0.1, 0.2]), block([-1.0, -4.0, -0.5], [2.0, 3.0, 0.4])]


def radius_of(geometry: Geometry) -> float:
    return float(np.linalg.norm(geometry.vertices, axis=1).max())


def company(bodies: list[Any]) -> tuple[Collisions, dict[str, Values]]:
    """Two copies of two members of `a` and one of `b`; their mass matrices have no zeros."""
    rng = np.random.default_rng(5)
    roots = {name: rng.normal(size=(6, 6)) for name in HULLS}
    masses = {name: root @ root.T + np.diag([30.0, 40, 50, 3, 4, 5]) for name, root in roots.items()}
    batches = {
        name: SimpleNamespace(
            rows=rows, vehicle=SimpleNamespace(bounding_radius_m=radius_of(HULLS[name]),
                                               config=SimpleNamespace(body=SimpleNamespace(mass_matrix=masses[name]))),
        ) for name, rows in (("a", 4), ("b", 2))
    }  # fmt: skip
    model: Any = SimpleNamespace(batches=batches, n=2, clock=SimpleNamespace(dt_ns=40_000_000))
    held: Any = SimpleNamespace(bodies=bodies, any=True, hull_of=HULLS.__getitem__)
    return Collisions(model, held), masses


def standing(geometry: Geometry, places: Any, fastest: float | None = None) -> Any:
    turns = Rotation.from_rotvec([[0, 0, 0.3], [0, 0, -1.2]])
    return SimpleNamespace(
        geometry=geometry, position=np.array(places), attitude=quaternions(turns), fastest_mps=fastest,
        velocity=np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]), angular_velocity=np.full((2, 3), 0.7),
    )  # fmt: skip


def rows_of(places: list[Any], speeds: Any = 0.0) -> Values:
    """Motion of vehicles that look all ways."""
    row = np.zeros((len(places), 13))
    row[:, :3], row[:, 7:10] = places, speeds
    row[:, 3:7] = quaternions(Rotation.random(len(places), random_state=len(places)))
    row[:, 10:13] = np.linspace(-0.4, 0.5, 3 * len(places)).reshape(-1, 3)
    return row


def test_rows_are_agents_by_batch_member_and_copy_and_then_bodies() -> None:
    made, masses = company([standing(BODIES[0], np.zeros((2, 3))), standing(BODIES[1], np.zeros((2, 3)), 1.5)])
    known = made.look()
    assert (known.agents, dict(known.first), known.bodies) == (6, {"a": 0, "b": 4}, 2)
    kinds = [*[HULLS["a"]] * 4, *[HULLS["b"]] * 2, *[BODIES[0]] * 2, *[BODIES[1]] * 2]
    np.testing.assert_allclose(known.low, [g.vertices.min(axis=0) for g in kinds])
    np.testing.assert_allclose(known.high, [g.vertices.max(axis=0) for g in kinds])
    np.testing.assert_allclose(known.radius, [radius_of(g) for g in kinds])
    np.testing.assert_array_equal(known.copy, [0, 1] * 5)
    np.testing.assert_array_equal(known.fastest, [0.0, 0.0, 1.5, 1.5])
    assert made._shapes is not None
    np.testing.assert_allclose(known.offset, made._shapes.offset[[0, 0, 0, 0, 1, 1, 2, 2, 3, 3]])
    assert made.look() is known
    made._bodies.bodies.pop()
    assert made.look().bodies == 1
    made._bodies.bodies[0] = standing(BODIES[1], np.zeros((2, 3)))
    np.testing.assert_allclose(made.look().radius[6:], radius_of(BODIES[1]))
    used, turns = np.array([1, 3, 5, 6]), Rotation.random(10, random_state=1)
    found = made._inverse_mass(used, quaternions(turns))
    for row, inverse in zip(used, found, strict=True):
        turn = np.kron(np.eye(2), turns.as_matrix()[row])
        mass = masses["a" if row < 4 else "b"] * np.outer(FLIP6, FLIP6)  # forward-left-up
        expected = np.linalg.inv(turn @ mass @ turn.T) if row < 6 else np.zeros((6, 6))
        np.testing.assert_allclose(inverse, expected, rtol=1e-9, atol=1e-12)


def test_agents_are_close_to_others_of_their_copy_and_to_bodies_that_may_come() -> None:
    """Of two bodies alone nothing is asked; one on a script comes by its greatest speed within the time."""
    far = np.array([[50.0, 0, 0], [90.0, 0, 0]])
    bodies = [standing(BODIES[0], [[50.2, 0, 0], [9.0, 0, 0]]), standing(BODIES[1], far, 1.5)]
    made, _ = company(bodies)
    rows = {"a": rows_of([[0, 0, 0], [9.6, 0, 0], [3.0, 0, 0], [42, 0, 0]]), "b": rows_of([[3.9, 0, 0], [84.8, 0, 0]])}
    reach = {"a": np.array([0.5, 0.5, 0.5, 3.5]), "b": np.array([0.5, 0.6])}
    # member 0 of a in copy 1 and the small body; member 1 of a in copy 0 and b in copy 0
    np.testing.assert_array_equal(made.close(rows, reach), [[1, 7], [2, 4]])
    np.testing.assert_array_equal(made.close(rows, reach, moving_s=0.2), [[1, 7], [2, 4], [5, 9]])
    hulls = {name: made._radius(name, row, 0.04) for name, row in rows.items()}
    np.testing.assert_allclose(hulls["b"], radius_of(HULLS["b"]) + 0.05 + 0.08)
    assert made.meeting(rows, hulls) == {"a", "b"}
    rows["b"][:, 0] += 30.0
    assert made.meeting(rows, hulls) == {"a"}
    rows["a"][1, 0] -= 30.0
    assert made.meeting(rows, hulls) == set()
    rows["b"][1, 0] = 89.0
    assert made.meeting(rows, hulls) == {"b"}
    speeds = np.array([[1.0, -2.0, 0.5], [0.0, 0.0, -4.0]])
    np.testing.assert_allclose(
        made._radius("b", rows_of([[0] * 3] * 2, speeds), 0.04) - radius_of(HULLS["b"]) - 0.05, [0.22, 0.24]
    )


def test_impulses_become_wrenches_of_their_rows_in_body_axes(monkeypatch: pytest.MonkeyPatch) -> None:
    """J / h about the own origin, forward-right-down; of velocities after the tick, on the ground those it leaves."""
    h = 0.04
    made, masses = company([standing(BODIES[1], [[3.0, 0, 0], [3.5, 0, 0]])])
    rows = {"a": rows_of([[0, 0, 0], [0, 0.3, 0], [0.2, 0, 0], [9.0, 0, 0]], 0.2), "b": rows_of([[2, 0, 0]] * 2, -0.1)}
    rng = np.random.default_rng(3)
    after = np.zeros((16, 2))
    after[7:13] = rng.normal(size=(6, 2))
    ground = rng.normal(size=(4, 6)) * 100
    ends = np.array([[5, 1, 3], [7, 5, 1]])
    numbers = [np.arange(3.0) + k for k in range(4)]
    contacts = PairContacts(*ends, np.ones((3, 3)), np.ones((3, 3)), *numbers)
    seen: dict[str, Any] = {}

    def cast(self: Collisions, pairs: Values, moved: Any, step: float) -> PairContacts:
        seen.update(pairs=pairs, moved=moved)
        return contacts

    def collide(local: PairContacts, bodies: Any, step: float) -> Values:
        seen.update(local=local, bodies=bodies, step=step)
        return np.arange(1.0, 25.0).reshape(4, 6) * [[1], [0], [1], [1]]

    monkeypatch.setattr(Collisions, "_cast", cast)
    monkeypatch.setattr(collisions, "collide", collide)
    found = dict(made.wrenches(rows, {"b": jit.Float64(after.ravel())}, {"a": ground}))
    used = [1, 3, 5, 7]
    np.testing.assert_array_equal([seen["local"].first, seen["local"].second], [[2, 0, 1], [3, 2, 0]])
    np.testing.assert_array_equal([seen["local"].depth, seen["local"].friction], [numbers[0], numbers[3]])
    assert seen["step"] == pytest.approx(h)
    assert {0, 1, 2, 4, 5} <= set(seen["pairs"].ravel().tolist())
    turns = {name: Rotation.from_quat(row[:, [4, 5, 6, 3]]) for name, row in rows.items()}
    velocity = np.concatenate([rows["a"][:, 7:13], (after[7:13].T * FLIP6)])
    for k in range(4):
        inverse = np.linalg.inv(masses["a"] * np.outer(FLIP6, FLIP6))
        velocity[k] += h * inverse @ (ground[k] * FLIP6)
    turned = [
        np.concatenate([turns[name].apply(part[:, :3]), turns[name].apply(part[:, 3:])], axis=1)
        for name, part in (("a", velocity[:4]), ("b", velocity[4:]))
    ]
    body = np.array([[0.1, 0.2, 0.3, 0.7, 0.7, 0.7], [0.4, 0.5, 0.6, 0.7, 0.7, 0.7]])
    expected = np.concatenate([*turned, body])[used]
    np.testing.assert_allclose(np.concatenate([seen["bodies"].velocity, seen["bodies"].spin], axis=1), expected)
    np.testing.assert_allclose(seen["bodies"].position[:, 0], [0.0, 9.0, 2.0, 3.5])
    np.testing.assert_allclose(seen["bodies"].inverse_mass[3], 0.0)
    impulses = np.arange(1.0, 25.0).reshape(4, 6)
    whole = {"a": np.zeros((4, 6)), "b": np.zeros((2, 6))}
    for name, row, k in (("a", 1, 0), ("b", 1, 2)):
        back = turns[name][row].inv()
        whole[name][row] = np.concatenate([back.apply(impulses[k, :3]), back.apply(impulses[k, 3:])]) * FLIP6 / h
    assert set(found) == {"a", "b"}
    for name, wrench in found.items():
        np.testing.assert_allclose(wrench, whole[name], atol=1e-9)
    assert not dict(made.wrenches(rows, {}, {}))


def test_a_hull_touches_where_it_is_and_as_fast_as_it_would_be(monkeypatch: pytest.MonkeyPatch) -> None:
    """Place and attitude before the tick, velocities after it, to forward-left-up and back; what moves is not asked."""
    rng, sizes = np.random.default_rng(2), StateSizes(1, 0, 0)
    before, after = rng.normal(size=(2, 21, 3))
    now, free = jit.Float64(before.ravel()), jit.Float64(after.ravel())
    asked: dict[str, Any] = {}

    def wrench(caster: Any, materials: Any, probes: Any, **more: Any) -> Any:
        asked.update(more, caster=caster, materials=materials, probes=probes)
        return jit.Array3f64(force.T), jit.Array3f64(moment.T)

    monkeypatch.setattr(touch, "probe_wrench", wrench)
    monkeypatch.setattr(touch, "Caster", lambda *parts: parts)
    monkeypatch.setattr(touch, "hull_probes", lambda *parts: list(parts))
    monkeypatch.setattr(dr, "make_opaque", lambda *_: None)
    caster: Any = SimpleNamespace(static="still", moving="bodies", tables="faces")
    scene = SimpleNamespace(static=object(), compile=lambda f: lambda *a: f(caster, *a))
    mass, kept = rng.normal(size=(6, 6)), (np.ones((2, 3)), np.zeros((2, 3)))
    vehicle = SimpleNamespace(
        sizes=sizes, probes=kept, config=SimpleNamespace(hull_grip=0.3, body=SimpleNamespace(mass_matrix=mass))
    )
    model: Any = SimpleNamespace(scene=scene, world=SimpleNamespace(material_tables=lambda: "stuff"),
                                 clock=SimpleNamespace(dt_ns=25_000_000))  # fmt: skip
    made = touch.Touch(SimpleNamespace(rows=3, vehicle=vehicle), model)  # type: ignore[arg-type]
    force, moment = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    found = made.wrench(now, free)
    assert found is not None
    np.testing.assert_allclose([np.array(f).T for f in found], [force * FLIP, moment * FLIP])
    flip = FLIP[:, None]
    np.testing.assert_allclose(np.array(asked["position"]), before[0:3] * flip)
    np.testing.assert_allclose(np.array(asked["attitude"]), before[3:7] * [[1.0], [1.0], [-1.0], [-1.0]])
    np.testing.assert_allclose(np.array(asked["velocity"]), after[7:10] * flip)
    np.testing.assert_allclose(np.array(asked["angular_velocity"]), after[10:13] * flip)
    assert asked["caster"] == ("still", None, "faces")
    np.testing.assert_array_equal([asked["own"].numpy(), asked["copy"].numpy()], [[NO_BODY] * 3, [0, 1, 2]])
    assert float(asked["h"].numpy()[0]) == pytest.approx(0.025)
    starts, vectors, held, grip = asked["probes"]
    assert (starts is kept[0], vectors is kept[1], grip, asked["materials"]) == (True, True, 0.3, "stuff")
    np.testing.assert_allclose(held, mass * np.outer(FLIP6, FLIP6))
    force[:2] = 0.0
    assert made.wrench(now, free) is not None
    force[:] = 0.0
    assert made.wrench(now, free) is None
    scene.static = None
    assert made.wrench(now, free) is None


SIDES: Final = np.array([[-1.0, 0.2, 0.1], [0.3, -1.0, 0.0], [1.0, 0.1, -0.2], [-0.2, 1.0, 0.05], [0.2, 0.1, 1.0]])
SIDES /= np.linalg.norm(SIDES, axis=1, keepdims=True)
LEVELS: Final = np.array([-6.0, -9.0, -7.5, -8.0, -12.0])
"""Walls n x = c about the origin and, the last, the ground."""


class Room:
    """Stands for the caster of the static scene."""

    def __init__(self, static: Any, moving: Any, tables: Any) -> None:
        assert moving is None

    def cast(self, rays: Rays) -> Any:
        nearest, normal = jit.Float(np.inf), jit.Array3f(0.0, 0.0, 0.0)
        for n, level in zip(SIDES.tolist(), LEVELS.tolist(), strict=True):
            facing = dr.dot(jit.Array3f64(rays.direction), jit.Array3f64(n))
            t = jit.Float((level - dr.dot(rays.origin, jit.Array3f64(n))) / facing)
            seen = (facing < 0) & (t < nearest) & (t < rays.max_range)
            nearest, normal = dr.select(seen, t, nearest), dr.select(seen, jit.Array3f(n), normal)
        return SimpleNamespace(valid=dr.isfinite(nearest), t=nearest, normal=normal)


def near(position: Values, forward: Values, below: float, beside: float) -> list[tuple[float, Values]]:
    """Ground, the nearest wall of four, and that opposite: distance and normal, north-west-up."""
    flat = np.array([forward[0], forward[1], 0.0])
    ahead = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 1e-6 else np.array([1.0, 0.0, 0.0])
    port = np.array([-ahead[1], ahead[0], 0.0])
    found = []
    for ray, way in enumerate([np.array([0.0, 0.0, -1.0]), ahead, port, -ahead, -port]):
        hits = []
        for n, level in zip(SIDES, LEVELS, strict=True):
            t = (level - n @ position) / min(n @ way, -1e-9)
            if n @ way < 0 and t < (beside if ray else below):
                hits.append((t, n))
        t, n = min(hits, key=lambda hit: hit[0]) if hits else (np.inf, -way)
        right = hits and (abs(n[2]) < 0.5) == (ray > 0)
        found.append((t * abs(n @ way), n) if right else (1e6, -way))
    order = sorted(range(4), key=lambda k: found[1 + k][0])
    return [found[0], found[1 + order[0]], found[1 + (order[0] + 2) % 4]]


def test_planes_near_vehicles_are_those_of_the_rays_that_they_send(monkeypatch: pytest.MonkeyPatch) -> None:
    """Down, ahead, to port, astern and to starboard of five vehicles; one points up, one is out of reach of most."""
    monkeypatch.setattr(boundaries, "Caster", Room)
    places = np.array([[2.0, 1.0, -3.0], [-3.0, 2.5, -6.0], [0.5, -3.0, -11.6], [1.0, 4.0, -2.0], [-2.0, -4.0, 5.0]])
    turns = Rotation.from_euler("ZYX", [[0.4, 0.2, 0.1], [-1.9, -0.5, 0.7], [2.8, 0.3, -0.6], [0, -np.pi / 2, 0],
                                        [1.1, 0.1, 2.9]])  # fmt: skip
    caster: Any = SimpleNamespace(static=1, tables=2)
    position, attitude = jit.Array3f64(places.T), jit.Array4f64(quaternions(turns).T)
    for opposite in (True, False):
        look = boundaries._look(5, opposite=opposite)
        walls = look(caster, position, attitude, jit.Float(13.0), jit.Float(6.5))
        assert len(walls.points) == len(walls.normals) == 2 + opposite
        for k in range(5):
            expected = near(places[k], turns.apply([1.0, 0, 0])[k], 13.0, 6.5)
            for plane, (gap, normal) in enumerate(expected[: 2 + opposite]):
                point = np.array(walls.points[plane])[:, k] * FLIP
                np.testing.assert_allclose(np.array(walls.normals[plane])[:, k] * FLIP, normal, atol=1e-6)
                np.testing.assert_allclose(point, places[k] - gap * normal, rtol=1e-5, atol=1e-5)
