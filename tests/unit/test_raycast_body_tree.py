"""Bodies that move, found by a tree of boxes: the same hits as if each stood still in a mesh of its own."""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.math.so3 import rotate_np
from pelagos.raycast.body_tree import _AXIS_BITS, _along_curve, nodes_of
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.raycast.scene import Scene
from pelagos.world.shapes import box, sphere

MIDDLE = (300.0, -200.0, -40.0)
KINDS = [
    sphere(0.7).geometry(material=2, label=3, instance=0, crease_deg=60.0),
    box((1.2, 0.5, 0.3)).geometry(material=1, label=4, instance=0),
]


def body(kind: int, instance: int) -> Geometry:
    """Shares its mesh with all others of its kind."""
    g = KINDS[kind]
    return Geometry(g.vertices, g.faces, g.material, g.label, instance, g.vertex_normals)


def poses(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(count, 4))
    return np.array(MIDDLE) + rng.uniform(-12, 12, (count, 3)), q / np.linalg.norm(q, axis=1, keepdims=True)


def fan(count: int, at: np.ndarray, *, copy: int = 0, own: int = NO_BODY, reach: float = 60.0) -> Rays:
    """From anywhere among the bodies past some of them; the first six along the axes, with components of 0."""
    rng = np.random.default_rng(4)
    aim = at[rng.integers(0, len(at), count)] + rng.normal(0.0, 0.6, (count, 3))
    start = np.array(MIDDLE) + rng.uniform(-14, 14, (count, 3))
    d = aim - start
    d[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    start[:6] = aim[:6] - 5.0 * d[:6]
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return Rays(
        jit.Array3f64(np.ascontiguousarray(start.T)),
        jit.Array3f(np.ascontiguousarray(d.T, dtype=np.float32)),
        jit.Float(np.full(count, reach, np.float32)),
        jit.UInt32(np.full(count, copy, np.uint32)),
        jit.UInt32(np.full(count, own, np.uint32)),
    )


def still(bodies: list[Geometry], place: np.ndarray, q: np.ndarray) -> Scene:
    """The same bodies as static meshes."""
    made = []
    for g, p, turn in zip(bodies, place, q, strict=True):
        vertices = rotate_np(np.tile(turn, (len(g.vertices), 1)), g.vertices.astype(float)) + p
        made.append(Geometry(vertices, g.faces, g.material, g.label, g.instance))
    return Scene(made)


@pytest.mark.parametrize("count", [1, 2, 37])
@pytest.mark.parametrize("own", [NO_BODY, 0])
def test_hits_are_those_of_the_same_meshes_standing_still(count, own):
    bodies = [body(k % 2, 10 + k) for k in range(count)]
    place, q = poses(count, seed=count)
    scene = Scene([])
    scene.set_moving([(g, 0) for g in bodies])
    zero = np.zeros((count, 3))
    scene.move(place, q, zero, zero)
    rest = slice(0, None) if own == NO_BODY else slice(1, None)
    shot = fan(4000, place, own=own)
    found = scene.compile(lambda caster, r: caster.cast(r))(shot)
    blocked = np.array(scene.compile(lambda caster, r: caster.occluded(r, past_own=True))(shot))
    assert (blocked == np.array(found.valid)).all()
    if not bodies[rest]:
        assert not blocked.any()
        return
    other = still(bodies[rest], place[rest], q[rest]).caster.cast(fan(4000, place))
    same = np.array(found.instance) == np.array(other.instance)
    assert same.mean() > 0.999  # all but those that graze an edge
    hit = same & np.array(other.valid)
    assert hit.sum() > 200
    assert np.array(found.t)[hit] == pytest.approx(np.array(other.t)[hit], abs=3e-4)
    turned = np.abs(np.array(found.normal) - np.array(other.normal))[:, hit].max(axis=0)
    assert (turned < 1e-4).mean() > 0.999
    assert (np.array(found.material)[hit] == np.array(other.material)[hit]).all()


def test_hits_depend_neither_on_other_bodies_nor_on_the_copy():
    """The bytes of all rays that meet the first three bodies, whichever others stand further on, in each copy."""
    place, q = poses(40, seed=7)
    place[3:] += [500.0, 0, 0]
    known = None
    for count, copies in ((3, 1), (40, 1), (40, 3)):
        scene = Scene([], copies=copies)
        scene.set_moving([(body(k % 2, 10 + k), c) for k in range(count) for c in range(copies)])
        zero = np.zeros((count * copies, 3))
        where, turn = np.repeat(place[:count], copies, axis=0), np.repeat(q[:count], copies, axis=0)
        scene.move(where, turn, zero, zero)
        for copy in range(copies):
            r = fan(2000, place[:3], copy=copy)
            hits = scene.compile(lambda caster, r: caster.cast(r))(r)
            now = [np.array(getattr(hits, name)).tobytes() for name in ("t", "position", "normal", "instance", "place")]
            known = known or now
            assert now == known
            assert np.array(hits.valid).sum() > 200


def test_equal_meshes_round_alike_whoever_made_them():
    """The bytes of hits on bodies that share the arrays of their kind, and on bodies of arrays of their own.

    The third kind is the second mirrored: of the same radius, so that only the digest puts one before the other.
    """
    mirrored = KINDS[1].vertices * (-1.0, 1.0, 1.0) + (0.0, 0.0, 0.0)
    third = Geometry(mirrored, KINDS[1].faces[:, ::-1].copy(), 0, 4, 0)
    kinds = [*KINDS, third]
    place, q = poses(9, seed=8)

    def own(g: Geometry) -> Geometry:
        normals = None if g.vertex_normals is None else g.vertex_normals.copy()
        return Geometry(g.vertices.copy(), g.faces.copy(), g.face_materials.copy(), g.label, g.instance, normals)

    def seen(order: list[int], *, shared: bool) -> list[bytes]:
        bodies = [replace(kinds[k % 3], instance=10 + k) for k in order]
        scene = Scene([])
        scene.set_moving([(g if shared else own(g), 0) for g in bodies])
        zero = np.zeros((9, 3))
        scene.move(place[order], q[order], zero, zero)
        hits = scene.compile(lambda caster, r: caster.cast(r))(fan(3000, place))
        assert np.array(hits.valid).sum() > 500
        return [
            np.array(getattr(hits, name)).tobytes()
            for name in ("t", "position", "normal", "instance", "material", "place")
        ]

    forward, backward = list(range(9)), list(range(8, -1, -1))
    known = seen(forward, shared=True)
    for order, shared in ((forward, False), (backward, True), (backward, False)):
        assert seen(order, shared=shared) == known


def test_bodies_of_one_form_and_several_materials_keep_theirs():
    g = KINDS[1]
    scene, place, q = Scene([]), *poses(3, seed=9)
    scene.set_moving([(replace(g, material=m, instance=20 + m, vertices=g.vertices.copy()), 0) for m in (0, 1, 2)])
    scene.move(place, q, np.zeros((3, 3)), np.zeros((3, 3)))
    hits = scene.compile(lambda caster, r: caster.cast(r))(fan(2000, place))
    hit = np.array(hits.valid)
    assert (np.array(hits.material)[hit] == np.array(hits.instance)[hit] - 20).all()
    assert set(np.array(hits.material)[hit].tolist()) == {0, 1, 2}


@pytest.mark.parametrize("count", [1, 2, 3, 8, 37])
def test_every_body_is_in_one_leaf_and_every_box_holds_those_below(count):
    rng = np.random.default_rng(count)
    low = rng.uniform(-1e4, 1e4, (2 * count, 3))
    high = low + rng.uniform(0, 9, (2 * count, 3))
    boxes, rows = nodes_of(low, high, copies=2)
    leaves = rows.shape[1]
    for copy in range(2):
        used = rows[copy] != NO_BODY
        assert sorted(rows[copy][used]) == list(range(copy, 2 * count, 2))
        assert (boxes[copy, leaves:][used, 0:3] < low[rows[copy][used]]).all()
        assert (boxes[copy, leaves:][used, 4:7] > high[rows[copy][used]]).all()
        for node in range(2, leaves + int(used.sum())):
            assert (boxes[copy, node // 2, 0:3] <= boxes[copy, node, 0:3]).all()
            if boxes[copy, node, 4] < 1e30:
                assert (boxes[copy, node // 2, 4:7] >= boxes[copy, node, 4:7]).all()


def test_bodies_are_ordered_along_mortons_curve_of_their_own_box():
    """Eighths of the box come one after the other, x first, then y, then z; an even scale for a flat box too."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    place = np.stack([corners * [80, 80, 80] - [7, 900, 3], corners * [3, 40, 9] + [1e4, -2, 5]])
    along = _along_curve(place)
    assert (np.diff(along[0]) > 0).all()
    top = 3 * (_AXIS_BITS - 1)
    assert (along[0] >> top).tolist() == list(range(8))
    assert (along[1] >> top).tolist() == [0, 0, 2, 2, 0, 0, 2, 2]  # by the longest of its sides, y


def test_a_kernel_that_sees_both_scenes_is_compiled_once():
    """Dr.Jit merges what two scenes hold alike after some calls, and a kernel of before would be another."""
    scene = Scene([body(0, 3)])
    cast = scene.compile(lambda caster, r: caster.cast(r))
    for count in (2, 3):  # the moving scene is replaced
        place, q = poses(count, seed=count)
        scene.set_moving([(body(1, 10 + k), 0) for k in range(count)])
        scene.move(place, q, np.zeros((count, 3)), np.zeros((count, 3)))
        shot = fan(90, place)
        dr.eval(shot)
        found = set()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            for _ in range(5):
                dr.kernel_history_clear()
                dr.eval(cast(shot))
                found.add(tuple(str(k["hash"]) for k in dr.kernel_history([dr.KernelType.JIT])))
        assert len(found) == 1


def test_a_drift_is_a_move_of_the_bodies_that_a_ray_meets():
    """Hits of rays with a drift d: those of the same rays where all bodies stand by d farther."""
    bodies = [body(k % 2, 10 + k) for k in range(9)]
    place, q = poses(9, seed=3)
    speed, spin = np.random.default_rng(5).normal(size=(2, 9, 3))
    drift = np.array([0.31, -0.22, 0.17])
    scene = Scene([])
    scene.set_moving([(g, 0) for g in bodies])
    cast = scene.compile(lambda caster, r: caster.cast(r))
    shadow = scene.compile(lambda caster, r: caster.occluded(r))
    plain = fan(4000, place)
    scene.move(place, q, speed, spin)
    drifting = replace(plain, drift=jit.Array3f(*(jit.Float(np.full(4000, d, np.float32)) for d in drift)))
    found, blocked = cast(drifting), np.array(shadow(drifting))
    scene.move(place + drift, q, speed, spin)
    moved, covered = cast(plain), np.array(shadow(plain))
    same = np.array(found.instance) == np.array(moved.instance)
    assert same.mean() > 0.999  # all but those that graze an edge
    assert (blocked == covered).mean() > 0.999
    hit = same & np.array(moved.valid)
    assert hit.sum() > 400
    for name, error in (("t", 3e-4), ("position", 3e-4), ("place", 3e-4), ("normal", 1e-3), ("velocity", 1e-3)):
        own, other = (np.array(getattr(hits, name))[..., hit] for hits in (found, moved))
        assert np.quantile(np.abs(own - other), 0.99) < error, name
