"""Streamed ground: no cracks, the source's heights where it is seen from, the same bytes wherever one came from."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.world.build import build_world, world_config
from pelagos.world.large.mesh import faces, tile_heights, vertices
from pelagos.world.large.quadtree import CELLS, coarser_sides, leaves, reaches
from pelagos.world.large.stream import Stream

CONFIG = {
    "type": "large",
    "size_m": [30_000, 20_000],
    "ground": {"kind": "fractal", "seed": 4, "mean_depth_m": 150, "relief_m": 30, "longest_m": 8000},
    "insets": [
        {"centre_m": [3000, 2000], "size_m": [400, 300], "resolution_m": 0.1, "material": "rock"},
        {"centre_m": [-4000, 1000], "size_m": [1000, 1000], "resolution_m": 2.5},
    ],
    "memory_mb": 540,
}
# in the finest inset; on its corner; on open ground; in the corner of the world; three agents apart
PLACES = {
    "inset": [[3010.0, 1990.0]],
    "rim": [[2801.0, 1850.0]],
    "ground": [[-9003.0, -777.0]],
    "corner": [[-14_990.0, 9_990.0]],
    "apart": [[3010.0, 1990.0], [-4000.0, 1300.0], [12_000.0, -8000.0]],
}


@pytest.fixture(scope="module")
def world():
    return build_world(world_config(CONFIG))


@pytest.fixture(
    params=[p if p in ("inset", "rim") else pytest.param(p, marks=pytest.mark.slow) for p in sorted(PLACES)]
)
def places(request):
    return np.array(PLACES[request.param])


def _solid(world, places):
    """Vertices welded where they are equal to the last bit, and faces that have an area."""
    stream = Stream(world.ground)
    stream.follow(places)
    tiles = stream.view.tiles
    at = vertices(world.ground, tiles, tile_heights(world.ground, tiles).z)
    points, name = np.unique(at, axis=0, return_inverse=True)
    f = name.reshape(-1)[faces(tiles)]
    keep = (f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])
    return points, f[keep], tiles


def test_the_mesh_has_no_crack_every_edge_has_two_faces_but_on_the_rim_of_the_world(world, places):
    points, solid, _ = _solid(world, places)
    a, b, c = (points[solid[:, k], :2] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    solid, area = solid[area != 0], area[area != 0]
    assert (area > 0).all()  # nothing is folded over
    g = world.ground
    assert area.sum() / 2 == pytest.approx((g.x1 - g.x0) * (g.y1 - g.y0), rel=1e-12)  # and nothing is left out
    edges = np.sort(np.concatenate([solid[:, [0, 1]], solid[:, [1, 2]], solid[:, [2, 0]]]), axis=1)
    known, counts = np.unique(edges, axis=0, return_counts=True)
    assert counts.max() == 2
    open_edges = points[known[counts == 1]]  # (e, 2, 3)
    on_rim = np.zeros(len(open_edges), dtype=bool)
    for axis, ends in enumerate(((g.x0, g.x1), (g.y0, g.y1))):
        for end in ends:
            on_rim |= (open_edges[:, :, axis] == end).all(axis=1)
    assert on_rim.all()


def test_tiles_that_touch_differ_by_one_level(world, places):
    g = world.ground
    for detail in (1.0, 3.0, 8.0):
        tiles = leaves(g, places, reaches(g, detail))
        edge = g.spacing * 2.0**tiles.level * CELLS
        low = np.stack([tiles.i * edge, tiles.j * edge])
        for k in range(len(tiles)):
            near = (low <= (low[:, k] + edge[k])[:, None]).all(axis=0) & (low + edge >= low[:, k][:, None]).all(axis=0)
            assert np.abs(tiles.level[near] - tiles.level[k]).max() <= 1
        assert coarser_sides(tiles).any()


def test_no_ray_slips_through_along_the_borders_of_tiles(world, places):
    """Vertical and grazing rays through corners, nodes and middles of the borders of all tiles near."""
    scene = world.scene()
    scene.peek(places)
    tiles = scene._ground.view.tiles
    g = world.ground
    generator = np.random.default_rng(1)
    rows = generator.choice(len(tiles), 400)
    edge = (g.spacing * 2.0 ** tiles.level[rows]) * CELLS
    along = generator.integers(0, 2 * CELLS + 1, 400) / (2 * CELLS)  # nodes and middles of cells' edges
    across = generator.integers(0, 2, 400)
    swap = generator.integers(0, 2, 400).astype(bool)
    u, v = np.where(swap, along, across), np.where(swap, across, along)
    x, y = g.x0 + (tiles.i[rows] + u) * edge, g.y0 + (tiles.j[rows] + v) * edge
    inside = (x > g.x0) & (x < g.x1) & (y > g.y0) & (y < g.y1)
    target = np.column_stack([x, y, g.nodes(g.finest, *_index(g, x, y))])[inside]
    size = edge[inside]
    aim = np.concatenate([np.tile([0.0, 0.0, -1.0], (len(target), 1)), _grazing(len(target), generator)])
    target, size = np.tile(target, (2, 1)), np.tile(size, 2)
    start = target - aim * np.maximum(size, 50.0)[:, None]
    start[:, 2] = np.maximum(start[:, 2], 20.0)  # above all ground
    away = target - start
    hits = _cast(scene, start, away, 1e5)
    assert np.isfinite(hits).all()


def _index(g, x, y):
    step = g.spacing_at(g.finest)
    return np.rint((x - g.x0) / step).astype(np.int64), np.rint((y - g.y0) / step).astype(np.int64)


def _grazing(count, generator):
    turn = generator.uniform(0, 2 * np.pi, count)
    turn[::4] = np.round(turn[::4] / (np.pi / 2)) * (np.pi / 2)  # along borders
    down = np.deg2rad(3.0)
    return np.column_stack([np.cos(turn) * np.cos(down), np.sin(turn) * np.cos(down), np.full(count, -np.sin(down))])


def _cast(scene, start, away, reach):
    """Distances without moving the ground: `World.cast` would bring detail to every origin."""
    from pelagos import jit

    local = jit.Array3f(np.ascontiguousarray((start - scene.origin).T, dtype=np.float32))
    unit = away / np.linalg.norm(away, axis=1, keepdims=True)
    ray = jit.mi.Ray3f(local, jit.Array3f(np.ascontiguousarray(unit.T, dtype=np.float32)), reach, 0.0, [])
    return scene.static.ray_intersect(ray, jit.mi.RayFlags.Minimal, True).t.numpy()


def test_near_a_vehicle_rays_hit_the_source_at_full_resolution(world):
    generator = np.random.default_rng(2)
    # 0.6 of the radius of full resolution is promised
    for place, around in (([3010.0, 1990.0], 4.0), ([14_000.0, -9_500.0], 400.0)):
        scene = world.scene()
        scene.follow(np.array([[*place, 0.0]]))
        xy = np.array(place) + generator.uniform(-around, around, (2000, 2))
        z = world.height(*xy.T)
        start = np.column_stack([xy, z + 30.0])
        t = _cast(scene, start, np.tile([0.0, 0.0, -1.0], (2000, 1)), 100.0)
        # the origin is within 2 km: float32 has 6e-5 m there, times the slope, and as much along the ray
        assert np.abs(t - 30.0).max() < 5e-4


def test_far_from_a_vehicle_the_ground_is_coarse_but_within_its_roughness(world):
    scene = world.scene()
    scene.follow(np.array([[-9003.0, -777.0, 0.0]]))
    xy = np.random.default_rng(3).uniform([5000, -9000], [14_000, 9000], (2000, 2))
    z = world.height(*xy.T)
    t = _cast(scene, np.column_stack([xy, np.full(2000, 50.0)]), np.tile([0.0, 0.0, -1.0], (2000, 1)), 1000.0)
    error = 50.0 - t - z
    assert np.isfinite(t).all()
    assert 0.01 < np.sqrt((error**2).mean()) < 15.0  # relief 30 m root mean square


def test_an_inset_has_detail_of_its_own_and_its_material(world):
    line = np.arange(2950, 3050, 0.1)
    inside = world.height(line, np.full_like(line, 2000.0))
    outside = world.height(line + 5000, np.full_like(line, 2000.0))
    bend = [np.abs(np.diff(z, 2)) for z in (inside, outside)]
    assert np.median(bend[0]) > 1e-4
    assert np.median(bend[1]) < 1e-9  # straight between nodes that are 10 m apart
    hits = world.cast([[3000.0, 2000.0, 0.0], [3900.0, 2000.0, 0.0]], (0, 0, -1), 500.0)
    assert [world.materials[m].name for m in hits.material] == ["rock", "sand"]
    assert hits.label.tolist() == [4, 4]  # landscape


def test_same_places_same_bytes_whatever_was_before(world):
    near, far = np.array([[3010.0, 1990.0]]), np.array([[-9003.0, -777.0]])
    first = Stream(world.ground)
    first.follow(near)
    second = Stream(world.ground)
    for place in (far, far + 3000, near + 900, near - 55):
        second.follow(place)
    second.forget()
    second.peek(near + 20)
    second.follow(near)
    a, b = first.patch, second.patch
    used = len(first.view.tiles) * (CELLS + 1) ** 2
    assert len(first.view.tiles) == len(second.view.tiles)
    assert a.vertices[:used].tobytes() == b.vertices[:used].tobytes()
    assert a.normals[:used].tobytes() == b.normals[:used].tobytes()
    assert a.origin.tobytes() == b.origin.tobytes()


def test_a_look_elsewhere_does_not_change_what_is_followed(world):
    stream = Stream(world.ground)
    place = np.array([[-9003.0, -777.0]])
    stream.follow(place)
    before = stream.view
    assert stream.peek(np.array([[9000.0, 9000.0]]))
    assert stream.view is not before
    assert stream.follow(place + 30.0)
    assert stream.view is before


def test_frozen_functions_see_the_ground_move_on_without_recording_anew(world, monkeypatch):
    import drjit as dr

    from pelagos import jit

    gc.collect()  # scenes of other tests that were freed in the middle would count as a change
    made = []
    freeze = dr.freeze
    monkeypatch.setattr(dr, "freeze", lambda *a, **k: made.append(freeze(*a, **k)) or made[-1])
    scene = world.scene()

    def shoot(caster, x, y):
        origin = jit.Array3f(jit.Array3f64(x, y, jit.Float64(60.0)) - caster.tables.origin)
        ray = jit.mi.Ray3f(origin, jit.Array3f(0, 0, -1), 1e4, 0.0, [])
        return caster.static.ray_intersect(ray, jit.mi.RayFlags.ShadingFrame, True).t

    frozen = scene.compile(shoot)
    moved = 0
    for x in np.linspace(-14_000.0, 14_000.0, 6):
        moved += scene.follow(np.array([[x, 500.0, 0.0]]))
        t = frozen(dr.opaque(jit.Float64, float(x), 3), dr.opaque(jit.Float64, 500.0, 3)).numpy()
        np.testing.assert_allclose(60.0 - t, world.height(x, 500.0), atol=2e-3)
    assert moved > 4
    assert sum(f.n_recordings for f in made) == len(made) <= 2  # once for each size of the mesh


@pytest.mark.slow  # 6 s
def test_memory_is_bounded_however_far_they_travel():
    world = build_world(world_config({"type": "large", "memory_mb": 600}))
    scene = world.scene()
    sizes, seen = [], []
    for x in np.linspace(-48_000, 48_000, 26):
        scene.follow(np.array([[x, 0.3 * x, 0.0]]))
        sizes.append(_resident_mb())
        seen.append(len(scene._ground.patch.faces))
    assert max(seen) <= world.ground.triangles
    # after the first few exchanges every buffer has its size: no more than the allocator's slack
    assert max(sizes[10:]) - max(sizes[:10]) < 30.0


def _resident_mb():
    pages = int(Path("/proc/self/statm").read_text().split()[1]) if Path("/proc/self/statm").exists() else 0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_clearance_is_never_wrong_when_it_says_that_nothing_is_near(world):
    generator = np.random.default_rng(5)
    for x, y in ((3000.0, 2000.0), (-9000.0, -700.0), (-14_999.0, 0.0)):
        xy = np.array([x, y]) + generator.uniform(-300, 300, (300, 2))
        xy = np.clip(xy, -14_999.0, 14_999.0)
        up = generator.uniform(0.0, 30.0, 300)
        position = np.column_stack([xy, world.height(*xy.T) + up])
        near = world.near(position, 3.0)
        assert near[up < 3.0].all()
        assert not near[up > 25.0].all()


def test_agents_too_far_apart_are_refused_with_words():
    world = build_world(world_config({"type": "large", "memory_mb": 480}))
    spread = np.random.default_rng(0).uniform(-45_000, 45_000, (40, 2))
    with pytest.raises(WorldError, match="raise memory_mb, or keep the agents together"):
        Stream(world.ground).follow(spread)
    # rays that somebody casts there are cast some after the others
    hits = world.cast(np.column_stack([spread[:6], np.zeros(6)]), (0, 0, -1), 1000.0)
    np.testing.assert_allclose(-hits.t, world.height(*spread[:6].T), atol=1e-2)


def test_normals_are_those_of_the_heights(world):
    """Central differences at nodes: with the heights of both neighbours the normal makes right angles."""
    stream = Stream(world.ground)
    stream.follow(np.array(PLACES["inset"]))
    tiles = stream.view.tiles
    found = tile_heights(world.ground, tiles)
    fine = tiles.level == tiles.level.min()
    step = 2 * world.ground.spacing_at(int(tiles.level.min()))
    z, n = found.z[fine], found.normals[fine][:, 1:-1, 1:-1]
    up = (z[:, 2:, 1:-1] - z[:, :-2, 1:-1], z[:, 1:-1, 2:] - z[:, 1:-1, :-2])
    for axis, rise in enumerate(up):
        assert np.abs(n[..., axis] * step + n[..., 2] * rise).max() < 1e-5 * step
        assert np.abs(rise).max() > 0.05 * step
    assert np.linalg.norm(n, axis=-1) == pytest.approx(np.ones(n.shape[:-1]), abs=1e-6)
