"""Contact of hulls by another way: the systems of its docstrings in NumPy, dense, for hulls turned and turning."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.contact.pairs import body_table, pair_contacts, read_contacts
from pelagos.contact.probe import hull_probes, probe_wrench
from pelagos.hydro.rigid_body import skew
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import Rays
from pelagos.raycast.shapes import Shapes

Values = NDArray[np.float64]
H: Final = 0.05
STIFFNESS: Final = np.array([3000.0, 12000.0, 800.0])
DAMPING: Final = np.array([150.0, 60.0, 220.0])
FRICTION: Final = np.array([0.45, 0.2, 0.9])
MATERIALS: Any = SimpleNamespace(
    stiffness=jit.Float(STIFFNESS), damping=jit.Float(DAMPING), friction=jit.Float(FRICTION)
)
NORMALS: Final = np.array([[0.1, -0.2, 1.0], [-1.0, 0.3, 0.2], [0.4, 1.0, -0.1]])
NORMALS[:] = np.float32(NORMALS / np.linalg.norm(NORMALS, axis=1, keepdims=True))  # hits are in single precision
LEVELS: Final = np.array([-0.4, -0.5, -0.45])
"""Three walls n x = c of three materials, which hulls are in front of."""
MOVING: Final = np.array([[0.3, -0.1, 0.2], [-0.2, 0.5, 0.1]])
"""Velocity of all walls, by the copy of the hull that asks."""
OWN: Final = 7
"""A hull of this body sees no more than the first wall."""


class Walls:
    """What `probe_wrench` asks of a caster."""

    def cast(self, rays: Rays) -> Any:
        nearest, normal, material = jit.Float(np.inf), jit.Array3f(0.0, 0.0, 0.0), jit.UInt32(0)
        for k, (n, level) in enumerate(zip(NORMALS.tolist(), LEVELS.tolist(), strict=True)):
            facing = dr.dot(jit.Array3f64(rays.direction), jit.Array3f64(n))
            t = jit.Float((level - dr.dot(rays.origin, jit.Array3f64(n))) / facing)
            seen = (facing < 0) & (t > 0) & (t < nearest) & (t < rays.max_range) & ((rays.own != OWN) | (k == 0))
            nearest = dr.select(seen, t, nearest)
            normal, material = dr.select(seen, jit.Array3f(n), normal), dr.select(seen, k, material)
        other = rays.copy == 1
        velocity = dr.select(other, jit.Array3f(MOVING[1].tolist()), jit.Array3f(MOVING[0].tolist()))
        return SimpleNamespace(
            valid=dr.isfinite(nearest), t=nearest, normal=normal, material=material, velocity=velocity
        )


def _solved(mass: Values, contacts: list[dict[str, Any]], guess: Values | None = None, friction: Any = None) -> Values:
    """(M + h sum G^T D G) a = sum G^T (n k depth - D slip), D = (h k + c) n n^T + d (1 - n n^T), G = (1, -r x)."""
    left, right = mass.copy(), np.zeros(6)
    for c in contacts:
        G = np.hstack([np.eye(3), -skew(c["r"])])
        along = np.outer(c["n"], c["n"])
        stiff = H * c["k"] + c["c"]
        D = stiff * along
        if guess is not None:
            after = c["slip"] + H * G @ guess
            limit = c["mu"] * max(c["k"] * c["depth"] - stiff * c["n"] @ after, 0.0)
            before, slid = (np.linalg.norm(v - along @ v) for v in (c["slip"], after))
            D = D + friction(limit, before, slid) * (np.eye(3) - along)
        left += H * G.T @ D @ G
        right += G.T @ (c["n"] * c["k"] * c["depth"] - D @ c["slip"])
    return np.linalg.solve(left, right)


def _expected(starts: Values, vectors: Values, mass: Values, grip: float, hull: dict[str, Any]) -> tuple[Values, int]:
    turn, v, w = hull["turn"], hull["v"], hull["w"]
    contacts = []
    for start, vector in zip(starts, vectors, strict=True):
        length = float(np.linalg.norm(vector))
        along = vector / length
        reach = length + 0.002 + 1.5 * H * (np.linalg.norm(v) + np.linalg.norm(w) * np.linalg.norm(start + vector))
        found = []
        for k in range(1 if hull["own"] == OWN else 3):
            facing = NORMALS[k] @ np.float32(turn @ along).astype(np.float64)
            t = float(np.float32((LEVELS[k] - NORMALS[k] @ (hull["x"] + turn @ start)) / facing))
            if facing < 0 and 0 < t < reach:
                found.append((t, k))
        if not found:
            continue
        t, k = min(found)
        n, r = turn.T @ NORMALS[k], start + t * along
        depth = (t - length) * along @ n
        slip = v + np.cross(w, r) - turn.T @ MOVING[hull["copy"]]
        squeeze = min(max(depth / length, 0.0), 1.0)
        closing = -slip @ n
        stiff = STIFFNESS[k] + mass[0, 0] / H**2 * squeeze**2
        damp = DAMPING[k] * min(max((depth + H * closing) / 0.002, 0.0), 1.0) + mass[0, 0] / H * squeeze
        if stiff * (depth + H * closing) + damp * closing > 0:
            contacts.append({"n": n, "r": r, "slip": slip, "depth": depth, "k": stiff, "c": damp,
                             "mu": grip * FRICTION[k]})  # fmt: skip
    hold = 1e5 * mass[0, 0] / H

    def first(limit: float, before: float, slid: float) -> float:
        force = hold * slid
        return hold if force <= limit else min(limit / max(before * (1 - limit / force), 1e-9), hold)

    def later(limit: float, before: float, slid: float) -> float:
        return min(limit / max(slid, 1e-9), hold)

    a = _solved(mass, contacts)
    for friction in (lambda *_: hold, first, later):
        a = _solved(mass, contacts, a, friction)
    return mass @ a, len(contacts)


def test_the_wrench_of_hulls_at_walls_is_that_of_the_dense_system() -> None:
    """Six hulls of a mass matrix without zeros, turned and turning, in two copies; one passes through its own walls."""
    rng = np.random.default_rng(11)
    starts, vectors = rng.uniform(-0.25, 0.25, (90, 3)), rng.normal(size=(90, 3))
    vectors *= rng.uniform(0.2, 0.5, (90, 1)) / np.linalg.norm(vectors, axis=1, keepdims=True)
    root = rng.normal(size=(6, 6))
    mass = root @ root.T + np.diag([20.0, 30.0, 40.0, 2.0, 3.0, 4.0])
    turns = Rotation.random(6, random_state=5)
    own = [3, OWN, 3, OWN, 3, 4]
    hulls = [
        {"x": rng.uniform(-0.15, 0.1, 3), "turn": turn, "v": rng.uniform(-1, 1, 3), "w": rng.uniform(-3, 3, 3),
         "copy": k % 2, "own": own[k]} for k, turn in enumerate(turns.as_matrix())
    ]  # fmt: skip
    hulls[2]["v"] *= 0.01  # it only turns
    hulls[4]["x"] = np.array([5.0, -5.0, 5.0])  # away from all walls
    lopsided = mass + np.triu(np.full((6, 6), 0.4), 1) - np.tril(np.full((6, 6), 0.4), -1)
    x, v, w = (jit.Array3f64(np.array([hull[key] for hull in hulls]).T) for key in "xvw")
    force, moment = probe_wrench(
        Walls(), MATERIALS, hull_probes(starts, vectors, lopsided, 0.7),  # type: ignore[arg-type]
        position=x, attitude=jit.Array4f64(turns.as_quat()[:, [3, 0, 1, 2]].T), velocity=v, angular_velocity=w,
        own=jit.UInt32(own), copy=jit.UInt32([hull["copy"] for hull in hulls]), h=jit.Float64(H),
    )  # fmt: skip
    found = np.concatenate([force.numpy(), moment.numpy()]).T
    for row, hull in zip(found, hulls, strict=True):
        expected, touching = _expected(starts, vectors, mass, 0.7, hull)
        assert (touching > 1) == (hull is not hulls[4]), touching
        np.testing.assert_allclose(row, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def _block(low: list[float], high: list[float], first: int) -> Geometry:
    """A box of its own material on each of six sides, `first` on the lowest x."""
    corners = np.array([[(low, high)[k >> a & 1][a] for a in range(3)] for k in range(8)], dtype=np.float64)
    quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    faces = np.array([[q[0], *pair] for q in quads for pair in (q[1:3], q[2:])], dtype=np.uint32)
    return Geometry(corners, faces, np.repeat((first + np.arange(6)) % 3, 2).astype(np.uint32), 1, 1)


def _met(geometry: Geometry, origin: Values, way: Values) -> tuple[float, int]:
    """Distance to the first face along a ray, and its number; T. Moeller, B. Trumbore (1997)."""
    best = (np.inf, -1)
    for k, face in enumerate(geometry.faces):
        a, b, c = geometry.vertices[face].astype(np.float64)
        t, u, v = np.linalg.solve(np.stack([-way, b - a, c - a], axis=1), origin - a)
        if t > 0 and min(u, v) >= 0 and u + v <= 1:
            best = min(best, (float(t), k))
    return best


def test_contacts_of_two_turned_bodies_are_those_of_their_triangles() -> None:
    """Probes of either body against the faces of the other, which both turn and go; a pair of equal rows is none."""
    rng = np.random.default_rng(2)
    shapes = [_block([-0.5, -0.3, -0.2], [0.6, 0.4, 0.3], 0), _block([-0.2, -0.7, -0.4], [0.3, 0.2, 0.6], 1)]
    made = Shapes(shapes)
    kinds = np.array([0, 1, 1, 0])
    position = np.array([[0.1, 0.0, -4.0], [0.7, 0.3, -3.8], [-0.5, 0.4, -4.3], [0.5, -0.9, -4.1]])
    turns = Rotation.random(4, random_state=9)
    velocity, spin = np.array([4.0, -3.0, 2.0]) + rng.uniform(-1, 1, (4, 3)), rng.uniform(-1, 1, (4, 3))
    radius = made.radius[kinds] + 0.01
    table = body_table(position, turns.as_quat()[:, [3, 0, 1, 2]], velocity, spin, made.offset[kinds], radius)
    starts, vectors = rng.uniform(-0.15, 0.25, (45, 3)), rng.normal(size=(45, 3))
    vectors *= rng.uniform(0.2, 0.6, (45, 1)) / np.linalg.norm(vectors, axis=1, keepdims=True)
    probes = hull_probes(starts, vectors, np.eye(6), 0.6)
    first, second = np.array([0, 1, 0, 2, 3, 2, 1]), np.array([1, 0, 2, 0, 0, 2, 1])
    step = jit.Float64(0.1)
    packed = pair_contacts(made.scene)(
        made.tables, MATERIALS, probes, table, jit.UInt32(first), jit.UInt32(second), step
    )
    found = read_contacts(packed, first, second)
    expected = []
    for a, b in zip(first[:5], second[:5], strict=True):
        mine, other = turns[a].as_matrix(), turns[b].as_matrix()
        solid = shapes[kinds[b]]
        for start, vector in zip(starts, vectors, strict=True):
            length = float(np.linalg.norm(vector))
            way = mine @ vector / length
            apart = position[a] - position[b] + mine @ start
            speed = np.linalg.norm(velocity[a] - velocity[b]) + np.linalg.norm(spin[a]) * (
                np.linalg.norm(start) + length
            )
            speed += np.linalg.norm(spin[b]) * (np.linalg.norm(apart) + length)
            t, face = _met(solid, other.T @ apart, other.T @ way)
            if t > length + 0.002 + 0.15 * speed:
                continue
            edges = np.diff(solid.vertices[solid.faces[face]], axis=0)
            normal = other @ np.cross(*edges) / np.linalg.norm(np.cross(*edges))
            if (facing := -normal @ way) > 0:  # not from within
                k = solid.face_materials[face]
                point = position[a] + mine @ start + t * way
                expected.append(
                    [a, b, *point, *normal, (length - t) * facing, STIFFNESS[k], DAMPING[k], 0.6 * FRICTION[k]]
                )
    rows = np.column_stack([np.asarray(values) for values in vars(found).values()])
    assert len(expected) > 20
    assert (found.depth < -0.05).any()
    assert (found.depth > 0.05).any()
    np.testing.assert_allclose(rows, np.array(expected), rtol=1e-5, atol=1e-5)
