"""The caster against planes and boxes whose distances are known."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.objects import Objects
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.raycast.scene import Scene

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]], dtype=np.uint32)  # fmt: skip
LEVEL = np.array([[1.0, 0.0, 0.0, 0.0]])


def box(centre=(0.0, 0.0, 0.0), *, material=0, label=1, instance=1) -> Geometry:
    return Geometry(CORNERS + np.array(centre), FACES, material, label, instance)


def plane(z=-10.0, size=1000.0, smooth=False) -> Geometry:
    corners = np.array([[-size, -size, z], [size, -size, z], [size, size, z], [-size, size, z]])
    up = np.tile(np.array([0, 0, 1], np.float32), (4, 1)) if smooth else None
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), 5, 2, 9, vertex_normals=up)


def rays(origins, directions, *, reach=100.0, copy=None, own=None) -> Rays:
    origins, directions = np.atleast_2d(origins).astype(float), np.atleast_2d(directions).astype(np.float32)
    n = len(origins)
    return Rays(
        jit.Array3f64(np.ascontiguousarray(origins.T)),
        jit.Array3f(np.ascontiguousarray(directions.T)),
        dr.full(jit.Float, reach, n),
        jit.UInt32(np.zeros(n, np.uint32) if copy is None else np.asarray(copy, np.uint32)),
        jit.UInt32(np.full(n, NO_BODY, np.uint32) if own is None else np.asarray(own, np.uint32)),
    )


def shoot(scene: Scene, r: Rays, *, smooth=False):
    return scene.compile(lambda caster, r: caster.cast(r, smooth=smooth))(r)


def test_static_hit_tells_distance_normal_label_instance_and_material():
    scene = Scene([plane(smooth=True), box((5, 0, -9), material=3, label=7, instance=2)])
    h = shoot(scene, rays([[0, 0, 0], [5, 0, 0], [0, 0, 0]], [[0, 0, -1], [0, 0, -1], [0, 0, 1]]))
    assert np.allclose(np.array(h.t)[:2], [10, 8], atol=1e-5)
    assert np.isinf(np.array(h.t)[2])
    assert np.array(h.valid).tolist() == [True, True, False]
    assert np.array(h.label).tolist() == [2, 7, 0]
    assert np.array(h.instance).tolist() == [9, 2, 0]
    assert np.array(h.material).tolist() == [5, 3, 0]
    assert np.allclose(np.array(h.normal).T, [[0, 0, 1], [0, 0, 1], [0, 0, 0]])


@pytest.mark.parametrize("moves", [False, True])
def test_directions_a_rounding_off_an_axis_hit_as_those_along_it(moves):
    """Vehicles on both sides of a box that look around after a turn of 1e-24: a packet of rays of mixed signs."""
    scene = Scene([plane(-6.0)] if moves else [plane(-6.0), box()])
    if moves:
        scene.set_moving([(box(), 0)])
        scene.move(np.zeros((1, 3)), LEVEL, np.zeros((1, 3)), np.zeros((1, 3)))
    call = scene.compile(lambda caster, r: (caster.cast(r), caster.occluded(r, coherent=True)))
    for turn in (0.0, 1e-24, -1e-24, 5e-19, 2e-16):
        ahead = np.array([[1, -turn, 0], [1, turn, 0]])
        left = np.array([[turn, 1, 0], [-turn, 1, 0]])
        r = rays([[0.1, 3.5, 0.2], [0.1, -3, 0.2]] * 5, np.vstack([[[0, 0, -1]] * 2, ahead, left, -ahead, -left]))
        found, blocked = call(r)
        expected = [6.2, 6.2, np.inf, np.inf, np.inf, 2, np.inf, np.inf, 2.5, np.inf]
        assert np.allclose(found.t, expected, atol=1e-5), turn
        assert np.array_equal(np.array(blocked), np.isfinite(expected)), turn


def test_nothing_beyond_max_range():
    h = shoot(Scene([plane()]), rays([0, 0, 0], [0, 0, -1], reach=9.99))
    assert not np.array(h.valid)[0]


def test_far_from_the_origin_a_millimetre_is_kept():
    """Single precision alone has a spacing of 8 mm at 100 km; relative to the scene's origin nothing is lost."""
    far = np.array([123_456.0, -98_765.0, 0.0])
    h = shoot(Scene([box(far)]), rays(far + np.array([3.0005, 0.2, 0.1]), [-1, 0, 0]))
    assert np.array(h.t)[0] == pytest.approx(2.0005, abs=1e-4)
    assert np.allclose(np.array(h.position)[:, 0], far + np.array([1, 0.2, 0.1]), atol=1e-4)


def test_moved_turned_and_removed_bodies_are_seen_at_the_next_cast():
    scene = Scene([plane()])
    down = rays([[0, 0, 0], [20, 0, 0]], [[0, 0, -1], [0, 0, -1]])

    call = scene.compile(lambda caster, r: caster.cast(r))
    zero = np.zeros((1, 3))
    assert np.allclose(call(down).t, [10, 10], atol=1e-5)
    scene.set_moving([(box(label=4, instance=11), 0)])
    for x, expected in ((0.0, [3, 10]), (20.0, [10, 3]), (100.0, [10, 10])):
        scene.move(np.array([[x, 0, -4.0]]), LEVEL, zero, zero)
        assert np.allclose(call(down).t, expected, atol=1e-5)
    quarter = np.array([[np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0]])  # 45 deg about y: an edge points up
    scene.move(np.array([[0, 0, -4.0]]), quarter, zero, zero)
    assert np.array(call(down).t)[0] == pytest.approx(4 - np.sqrt(2), abs=1e-5)
    scene.set_moving([])
    assert np.allclose(call(down).t, [10, 10], atol=1e-5)


def test_surface_velocity_is_v_plus_omega_cross_r():
    scene = Scene([])
    scene.set_moving([(box(), 0)])
    velocity, spin = np.array([[1.0, 2.0, 3.0]]), np.array([[0.0, 0.0, 0.5]])
    scene.move(np.array([[4.0, 0, 0]]), LEVEL, velocity, spin)
    h = shoot(scene, rays([0, 0.5, 0], [1, 0, 0]))
    assert np.allclose(np.array(h.velocity)[:, 0], velocity[0] + np.cross(spin[0], [-1, 0.5, 0]), atol=1e-5)


def test_a_ray_passes_its_own_hull_but_not_another():
    scene = Scene([plane()])
    scene.set_moving([(box(instance=3), 0), (box(instance=4), 0)])
    zero = np.zeros((2, 3))
    scene.move(np.array([[0, 0, -2.0], [0, 0, -6.0]]), np.repeat(LEVEL, 2, axis=0), zero, zero)
    h = shoot(scene, rays([[0, 0, 0]] * 3, [[0, 0, -1]] * 3, own=[NO_BODY, 0, 1]))
    assert np.array(h.instance).tolist() == [3, 4, 3]
    assert np.allclose(h.t, [1, 5, 1], atol=1e-4)


def test_copies_of_a_fleet_do_not_see_each_others_bodies():
    scene = Scene([plane()], copies=3)
    scene.set_moving([(box(), copy) for copy in range(3)])
    zero = np.zeros((3, 3))
    scene.move(np.array([[0, 0, -2.0], [0, 0, -4.0], [50, 0, -4.0]]), np.repeat(LEVEL, 3, axis=0), zero, zero)
    h = shoot(scene, rays([[0, 0, 0]] * 3, [[0, 0, -1]] * 3, copy=[0, 1, 2]))
    assert np.allclose(h.t, [1, 3, 10], atol=1e-3)
    assert np.allclose(np.array(h.position)[2], [-1, -3, -10], atol=1e-3)


def test_copies_do_not_see_each_other_from_afar_either():
    """A long ray of copy 0 meets its own box behind those of all others."""
    scene = Scene([], copies=8)
    scene.set_moving([(box(), copy) for copy in range(8)])
    zero, places = np.zeros((8, 3)), np.tile([100.0, 0, 0], (8, 1))
    places[0] = [1800.0, 0, 0]
    scene.move(places, np.repeat(LEVEL, 8, axis=0), zero, zero)
    r = rays([[0, 0, 0]] * 2, [[1, 0, 0]] * 2, copy=[0, 1], reach=3000.0)
    assert np.allclose(shoot(scene, r).t, [1799, 99], atol=1e-2)
    short = rays([[0, 0, 0]] * 2, [[1, 0, 0]] * 2, copy=[0, 1], reach=1000.0)
    blocked = scene.compile(lambda caster, r: caster.occluded(r))(short)
    assert np.array(blocked).tolist() == [False, True]


def test_shadow_rays_agree_with_hits():
    scene = Scene([plane(), box((5, 0, -5))])
    scene.set_moving([(box(), 0)])
    zero = np.zeros((1, 3))
    scene.move(np.array([[-5, 0, -5.0]]), LEVEL, zero, zero)
    generator = np.random.default_rng(1)
    directions = generator.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    r = rays(np.zeros((200, 3)) - [0, 0, 3], directions, reach=8.0)

    blocked = np.array(scene.compile(lambda caster, r: caster.occluded(r))(r))
    assert (blocked == np.array(shoot(scene, r).valid)).all()
    assert 10 < blocked.sum() < 190


def test_frozen_and_plain_casts_give_the_same_bytes():
    scene = Scene([plane(), box((5, 0, -5))])
    generator = np.random.default_rng(2)
    directions = generator.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    r = rays(np.zeros((500, 3)), directions)
    frozen, plain = shoot(scene, r), scene.caster.cast(r)
    for name in ("t", "position", "normal", "label", "instance"):
        assert np.array(getattr(frozen, name)).tobytes() == np.array(getattr(plain, name)).tobytes()


def test_rays_that_meet_a_vertex_or_an_edge_exactly_do_not_slip_through():
    """Rough ground, rays straight down on every inner node, on the middles of edges, and on the diagonals."""
    n = 60
    x, y = np.meshgrid(np.arange(n) * 1.25 - 37.0, np.arange(n) * 1.25 - 37.0, indexing="ij")
    z = np.random.default_rng(3).normal(-20, 2, (n, n))
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)]).astype(np.uint32)
    scene = Scene([Geometry(np.stack([x, y, z], -1).reshape(-1, 3), faces, 0, 1, 1)])
    inner = np.stack([x[1:-1, 1:-1], y[1:-1, 1:-1], 0 * x[1:-1, 1:-1]], -1).reshape(-1, 3)
    for shift in ((0, 0), (0.625, 0), (0, 0.625), (0.625, 0.625)):
        start = inner + np.array([*shift, 0.0]) * (inner < 35).all(axis=1, keepdims=True)
        hits = scene.caster.cast(rays(start, np.tile([0, 0, -1.0], (len(start), 1))))
        assert hits.valid.numpy().all()


def test_place_on_a_body_moves_along_with_it():
    """The same spot of a box, wherever it goes and however it turns; of static ground its world position."""
    scene = Scene([plane()])
    scene.set_moving([(box(), 0)])
    zero = np.zeros((1, 3))
    found = []
    for x, q in ((0.0, LEVEL), (7.0, np.array([[np.sqrt(0.5), 0, 0, np.sqrt(0.5)]]))):
        scene.move(np.array([[x, 0.0, -4.0]]), q, zero, zero)
        offset = (0.25, 0.5) if x == 0 else (7.0 - 0.5, 0.25)  # a quarter turn left of the same spot
        h = shoot(scene, rays([[*offset, 0.0]], [[0, 0, -1]]))
        found.append(np.array(h.place).ravel())
    assert found[0] == pytest.approx([0.25, 0.5, 1.0], abs=1e-5)
    assert found[1] == pytest.approx(found[0], abs=1e-5)
    ground = shoot(scene, rays([[20.0, 3.0, 0.0]], [[0, 0, -1]]))
    assert np.array(ground.place).ravel() == pytest.approx([20, 3, -10], abs=1e-5)


@pytest.mark.parametrize("count", [3, 255, 256, 300, 70_000])
def test_each_of_many_objects_has_a_row_of_its_own(count: int):
    """One triangle each, of its own label, instance and material; then one thing of three materials."""
    objects = Objects()
    triangle, face = CORNERS[:3], FACES[:1] * 0 + np.arange(3, dtype=np.uint32)
    one = Geometry(triangle, face, 4, 7, 9)
    objects.label, objects.instance, objects.material = ([k] * (count - 1) for k in (1, 2, 3))
    assert objects.rows(one).tolist() == [count - 1]
    mixed = Geometry(triangle, np.repeat(face, 4, axis=0), np.array([6, 2, 6, 5]), 8, 11)
    rows = objects.rows(mixed)
    assert rows.tolist() == [count + 2, count, count + 2, count + 1]
    assert [objects.material[row] for row in rows] == [6, 2, 6, 5]
    assert {(objects.label[row], objects.instance[row]) for row in rows} == {(8, 11)}
    assert rows.dtype == np.min_scalar_type(count + 3)
    assert objects.add(5, 12, [3, 1]).tolist() == [count + 3, count + 4]
