"""The world's NumPy face: casts, clearance, free places, labels, materials, props."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pelagos.errors import CommandError, LookupFailed, WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.meshes import on_host
from pelagos.world import shapes
from pelagos.world.bathymetry.axes import check_axes
from pelagos.world.body import Prop
from pelagos.world.build import build_world, world_config, world_types
from pelagos.world.clearance import Clearance
from pelagos.world.export import save
from pelagos.world.label import HOLOOCEAN_LABELS, LABELS, label_color, label_name, label_number
from pelagos.world.material import MATERIALS, TEXTURES, material, material_tables
from pelagos.world.sediment import SEDIMENTS
from pelagos.world.site import Site
from pelagos.world.world import Hits, World, _halves


@pytest.fixture(scope="module")
def world():
    site = Site(user_labels={"beacon": 200})
    site.add(shapes.box((2, 2, 10)).moved((10, 0, -5)), "concrete", label="wall", name="pillar")
    site.add(shapes.sphere(1.0).moved((0, 10, -5)), "steel", label="beacon", name="ball", crease_deg=60)
    site.add(shapes.plane((60, 60)).moved((0, 0, -10)), "mud", label="landscape", name="floor")
    return site.world(name="t", description="", origin=GeoOrigin(1, 2))


def test_cast_says_what_where_and_how(world):
    hits = world.cast([(0, 0, -5), (0, 0, -5), (0, 0, -5)], [(1, 0, 0), (0, 3, 0), (0, -1, 0)], max_range=50)
    assert np.allclose(hits.t[:2], [9, 9], atol=1e-5)
    assert np.isinf(hits.t[2])
    assert hits.valid.tolist() == [True, True, False]
    assert np.allclose(hits.position[0], [9, 0, -5], atol=1e-5)
    assert np.allclose(hits.normal[0], [-1, 0, 0])
    assert hits.label.tolist() == [53, 200, 0]
    assert hits.instance.tolist() == [1, 2, 0]
    assert [world.materials[m].name for m in hits.material[:2]] == ["concrete", "steel"]
    assert not hits.velocity.any()
    assert not hits.position[2].any()


def test_cast_respects_its_range(world):
    assert not world.cast((0, 0, -5), (1, 0, 0), 8.9).valid.any()
    assert world.cast((0, 0, -5), (1, 0, 0), 9.1).valid.all()


@pytest.mark.parametrize(
    ("origin", "direction", "reach"),
    [((0, 0), (1, 0, 0), 1), ((0, 0, 0), (0, 0, 0), 1), ((0, 0, np.nan), (1, 0, 0), 1), ((0, 0, 0), (1, 0, 0), -1),
     (np.zeros((3, 3)), np.ones((2, 3)), 1)],
)  # fmt: skip
def test_bad_rays_are_refused(world, origin, direction, reach):
    with pytest.raises(CommandError, match="cast"):
        world.cast(origin, direction, reach)


def test_an_empty_world_is_hit_by_nothing():
    assert not World((), ()).cast((0, 0, 0), np.eye(3)).valid.any()
    assert not World((), ()).near(np.zeros((1, 3)), 5.0).any()


def test_cast_sees_what_moves_and_how_fast(world):
    scene = world.scene(1)
    scene.set_moving([(Prop("box", size=1).geometry(instance=world.next_instance, world=world), 0)])
    scene.move(np.array([[-5.0, 0, -5]]), np.array([[1.0, 0, 0, 0]]), np.array([[0, 2.0, 0]]), np.zeros((1, 3)))
    hits = world.cast((0, 0, -5), (-1, 0, 0))
    assert hits.t[0] == pytest.approx(4.5, abs=1e-5)
    assert hits.instance[0] == world.next_instance
    assert hits.velocity[0].tolist() == [0, 2, 0]
    world.scene(1)
    assert not world.cast((0, 0, -5), (-1, 0, 0)).valid.any()


def test_worlds_that_come_and_go_keep_their_meanings():
    """Identifiers of freed scenes are given out again in any order."""
    kept = []
    for k in range(12):
        site = Site()
        site.add(shapes.sphere(1.0).moved((5, 0, 0)), "steel", label="sphere", name="smooth", crease_deg=60)
        site.add(shapes.box((1, 1, 1)).moved((-5, 0, 0)), "wood", label="cube", name="flat")
        one = site.world(name="t", description="", origin=GeoOrigin(0, 0))
        scene = one.scene(1)
        scene.set_moving([(Prop("box", label=128 + j).geometry(instance=9 + j, world=one), 0) for j in range(3)])
        still = np.zeros((3, 3))
        scene.move(np.array([[0.0, 5, 0], [0, 10, 0], [0, -5, 0]]), np.tile([1.0, 0, 0, 0], (3, 1)), still, still)
        hits = one.cast((0, 0, 0), [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
        assert hits.label.tolist() == [2, 1, 128, 130]
        if k % 3:
            kept.append(one)


def test_places_inside_and_near_things_are_not_free(world):
    assert world.inside((10, 0, -5)) is not None
    assert "pillar" in world.inside((10, 0, -5))
    assert "pillar" in world.inside((8.5, 0, -5), 0.6)
    assert world.inside((8.5, 0, -5), 0.4) is None
    assert "ball" in world.inside([(0, 0, -5), (0, 10, -5)])
    assert "copy 1" in world.inside([(0, 0, -5), (0, 10, -5)])
    assert world.inside((0, 0, np.inf)) is not None


def test_clearance_never_calls_the_near_far(world):
    """Against the distance to the nearest vertex-sampled surface: whatever is within the margin must be reported."""
    rng = np.random.default_rng(0)
    at = rng.uniform([-25, -25, -9.9], [25, 25, 5], (400, 3))
    for margin in (0.3, 1.5, 7.0):
        told = world.near(at, margin)
        single = np.array([world.near(p[None], margin)[0] for p in at])
        assert (told | ~single).all()
        assert told.sum() <= 2 * single.sum()
        really = np.array([world.cast(p, _ball(200), margin).valid.any() for p in at])
        assert not (really & ~told).any()


def test_clearance_lets_open_water_pass(world):
    assert not world.near(np.array([[-20.0, -20, -5]]), 2.0).any()
    assert not world.near(np.array([[500.0, 0, -5], [0, 0, 50]]), 2.0).any()


def test_clearance_of_faces_of_any_size():
    rng = np.random.default_rng(4)
    site = Site()
    for _ in range(30):
        size = 10 ** rng.uniform(-0.5, 2.2, 3)
        site.add(shapes.box(size).moved(rng.uniform(-100, 100, 3)), "steel", label="cube", name="b")
    boxes = [(g.vertices.min(axis=0), g.vertices.max(axis=0)) for g in site.geometries]
    clearance = Clearance(site.geometries, cell=3.0)
    at = rng.uniform(-150, 150, (2000, 3))
    inside = np.any([((at >= low) & (at <= high)).all(axis=1) for low, high in boxes], axis=0)
    assert inside.sum() > 20
    assert clearance.near(at, 0.01)[inside].all()


def test_clearance_of_many_is_certain_where_it_says_free():
    """Nothing stands in the box of half the margin's edge around places that are called free; by brute force."""
    rng = np.random.default_rng(5)
    corners = rng.uniform(-60, 60, (50, 1, 3)) * [1, 1, 0.2] + rng.uniform(-4, 4, (50, 3, 3))
    faces = np.arange(150, dtype=np.uint32).reshape(-1, 3)
    clearance = Clearance([Geometry(corners.reshape(-1, 3), faces, 0, 0, 1)], cell=3.0)
    low, high = corners.min(axis=1), corners.max(axis=1)
    at = rng.uniform(-90, 90, (500, 3)) * [1, 1, 0.3]
    for margin in (0.4, 2.9, 3.1, 20.0, 1e3, rng.uniform(0.1, 100.0, 500)):
        reach = np.broadcast_to(margin, (500,))[:, None, None]
        over = (at[:, None] + reach > low) & (at[:, None] - reach < high)
        close = (over[..., :2].all(axis=2) & (high[None, :, 2] >= at[:, None, 2] - reach[..., 0])).any(axis=1)
        found = clearance.near(at, margin)
        assert (found | ~close).all()
        assert found.mean() < close.mean() + 0.2
    far = np.concatenate([at[:2], [[1e7, 0, 0], [np.nan, 0, 0], [0, np.inf, 0]]])
    assert clearance.near(far, np.array([1.0, 1e18, 5.0, 5.0, 5.0])).tolist()[1:] == [True, False, True, True]


def test_labels():
    assert len(HOLOOCEAN_LABELS) == 56
    assert label_number("BaseShape") == label_number("base_shape") == label_number(3) == 3
    assert label_number("beacon", {"beacon": 200}) == 200
    assert label_name(22) == "pier"
    assert label_name(222) == "user_222"
    assert label_color(4) == (201, 162, 54)
    assert len({label.number for label in LABELS.values()}) == len(LABELS)
    assert max(label.number for label in LABELS.values()) == 255
    with pytest.raises(LookupFailed, match="did you mean 'pier'"):
        label_number("peer")
    with pytest.raises(CommandError, match="0 to 255"):
        label_number(256)


def test_materials_are_physical():
    for name, m in MATERIALS.items():
        assert m.name == name or name in SEDIMENTS
        assert all(0 <= c <= 1 for c in m.albedo)
        assert m.density_ratio > 0.4
        assert 0.9 < m.sound_speed_ratio < 5
        assert m.lambert_db < -4.97  # pi 10^(mu/10) <= 1: no more energy leaves than came
        assert m.stiffness > 0
        assert m.damping > 0
        assert m.texture in TEXTURES
    with pytest.raises(LookupFailed, match="did you mean 'concrete'"):
        material("concret")


def test_material_tables_keep_the_rows():
    tables = material_tables([MATERIALS["sand"], MATERIALS["steel"]])
    assert np.allclose(np.array(tables.density_ratio), [1.845, 7850 / 1025], atol=1e-4)
    assert np.array(tables.albedo).shape == (3, 2)


def test_bodies_may_be_of_any_material(world):
    row = world.material_row("gold")
    tables = world.material_tables()
    assert np.array(tables.albedo)[:, row].tolist() == pytest.approx(list(MATERIALS["gold"].albedo))


@pytest.mark.parametrize("shape", ["box", "sphere", "cylinder", "cone"])
def test_props_have_the_size_asked_for(shape, world):
    made = Prop(shape, size=(1, 2, 3), material="gold", label="debris").geometry(instance=9, world=world)
    assert np.allclose(np.ptp(made.vertices, axis=0), [1, 2, 3], rtol=0.01)
    assert made.instance == 9
    assert made.label == label_number("debris")


def test_a_prop_from_a_file(tmp_path, world):
    mesh = shapes.box((1, 1, 1))
    path = tmp_path / "box.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces]
    path.write_text("\n".join(lines))
    assert Prop("mesh", path=path, size=2).mesh.volume == pytest.approx(8)
    with pytest.raises(WorldError, match=r"did you mean 'box\.obj'"):
        Prop("mesh", path=tmp_path / "bax.obj").geometry(instance=1, world=world)
    (tmp_path / "torn.stl").write_bytes(b"solid")
    with pytest.raises(WorldError):
        Prop("mesh", path=tmp_path / "torn.stl").geometry(instance=1, world=world)


def test_bad_props_are_refused(world):
    with pytest.raises(LookupFailed, match="box"):
        Prop("cube")
    with pytest.raises(CommandError, match="size"):
        Prop("box", size=-1)
    with pytest.raises(CommandError, match="size"):
        Prop("box", size=(1, 2))
    with pytest.raises(LookupFailed, match="gold"):
        Prop("box", material="golf").geometry(instance=1, world=world)


def test_every_type_of_world_has_a_title():
    assert {"flat", "harbour", "bathymetry"} <= set(world_types())
    assert all(len(title) > 20 for title in world_types().values())


def test_flat():
    flat = build_world(world_config({"type": "flat", "depth_m": 12.0, "size_m": [300, 100], "material": "mud"}))
    assert flat.bounds.tolist() == [[-150, -50, -12], [150, 50, -12]]
    assert flat.cast((140, 40, 0), (0, 0, -1)).t[0] == pytest.approx(12)
    with pytest.raises(LookupFailed, match="did you mean 'flat'"):
        world_config({"type": "falt"})


def _ball(count):
    v = np.random.default_rng(5).normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def test_a_large_ground_is_held_once(monkeypatch):
    """World and scene share the arrays of faces and normals: the same values, at the same place in memory."""
    monkeypatch.setattr("pelagos.raycast.meshes._MANY_FACES", 100)
    world = build_world(world_config({"type": "flat", "depth_m": 10.0, "size_m": [40, 40]}))
    before = [g.faces.copy() for g in world.geometries], [g.vertex_normals.copy() for g in world.geometries]
    scene = world.scene()
    ground = world.geometries[0]
    assert len(ground.faces) > 100
    assert np.array_equal(ground.faces, before[0][0])
    assert np.array_equal(ground.vertex_normals, before[1][0])
    if on_host():
        assert np.shares_memory(ground.faces, scene.tables.static.corner.numpy())
    assert world.cast([0.0, 0.0, 0.0], (0, 0, -1)).t[0] == pytest.approx(10.0)
    assert np.array_equal(world.scene().tables.static.corner.numpy(), before[0][0].ravel())


def test_what_is_added_to_a_reopened_world_is_nothing_elses(world):
    """Several geometries of one thing share an instance, and some instances are of nothing: counting is no way."""
    one, *_, last = world.geometries
    kept = replace(world, geometries=(replace(one, instance=2), replace(last, instance=9), replace(last, instance=2)))
    site = Site.reopened(kept)
    site.add(shapes.sphere(0.5), "steel", label="beacon", name="new")
    made = site.world(name="t", description="", origin=GeoOrigin(1, 2))
    assert [g.instance for g in made.geometries] == [2, 9, 2, 10]
    assert made.geometries[-1].label == 200
    assert made.names[10] == "new"


def test_labels_of_the_scenario_win_over_those_of_a_saved_world(tmp_path, world):
    save(world, tmp_path / "kept.npz")
    keys = {"type": "saved", "path": str(tmp_path / "kept.npz")}
    assert build_world(world_config(keys)).user_labels == {"beacon": 200}
    made = build_world(world_config({**keys, "labels": {"beacon": 210, "cage": 207}}))
    assert made.user_labels == {"beacon": 210, "cage": 207}


@pytest.mark.parametrize("wrong", [[3.0, 5.0, 4.0, 7.0], [3.0, 3.0, 5.0], [7.0, 4.0, 4.5], [1.0], [1.0, np.nan, 3.0]])
@pytest.mark.parametrize("which", [0, 1])
def test_axes_of_a_survey_rise_or_fall_all_the_way(which, wrong):
    rising, falling = np.array([-3.0, 1.0, 2.5, 7.0]), np.array([4.0, 2.0, -1.0])
    check_axes(Path("z.nc"), rising, falling, ("north", "east"), latlon=False)
    check_axes(Path("z.nc"), falling, rising, ("north", "east"), latlon=False)
    axes = [rising, falling]
    axes[which] = np.array(wrong)
    with pytest.raises(WorldError, match=f"the axis '{('north', 'east')[which]}' has fewer than 2 values, or they nei"):
        check_axes(Path("z.nc"), *axes, ("north", "east"), latlon=False)


def test_rays_in_two_halves_come_back_in_their_own_order():
    """Each half lies on its side along the longer extent; every number of every ray is its own."""
    rng = np.random.default_rng(3)
    start = rng.uniform(-1, 1, (11, 3)) * [20, 90, 200]
    along, reach = rng.normal(size=(11, 3)).astype(np.float32), rng.uniform(1, 9, 11).astype(np.float32)
    copy, own = rng.permutation(11).astype(np.uint32), rng.permutation(11).astype(np.uint32)
    asked = []

    def call(start, along, reach, copy, own):
        asked.append(start[:, 1])
        return Hits(reach, start * 2, along, copy, own, copy + 2 * own, along * reach[:, None])

    found, whole = (f(start, along, reach, copy, own) for f in (lambda *a: _halves(call, *a), call))
    assert [len(a) for a in asked] == [5, 6, 11]
    assert asked[0].max() < asked[1].min()
    for name in Hits.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name), err_msg=name)


def test_movers_that_stand_still_are_made_of_their_own_materials():
    """One of the world's own, the first that is not, and others, one of them twice: each comes into the table once."""
    plain = build_world(world_config({"type": "flat", "depth_m": 30.0, "size_m": [90, 90], "material": "mud"}))
    assert plain.at_time(3.0) is plain
    other = plain.palette[len(plain.materials)].name
    movers = [
        {"name": f"m{k}", "body": "box", "size_m": 2.0, "material": what, "label": 140 + k,
         "path": {"kind": "waypoints", "points_m": [[8 * k, -5, -9], [8 * k, 25, -9]], "speed_mps": 1.5}}
        for k, what in enumerate(("gold", "mud", other, "wood", "gold"))
    ]  # fmt: skip
    world = build_world(world_config({"type": "flat", "depth_m": 30.0, "size_m": [90, 90], "material": "mud",
                                      "movers": movers, "labels": {"raft": 142}}))  # fmt: skip
    assert {n: world.labels[n] for n in (140, 142)} == {140: "user_140", 142: "raft"}
    still = world.at_time(4.0)
    assert sorted(m.name for m in still.materials) == sorted({"mud", "gold", other, "wood"})
    assert still.materials[: len(world.materials)] == world.materials
    boxes = still.geometries[len(world.geometries) :]
    for k, (box, what) in enumerate(zip(boxes, ("gold", "mud", other, "wood", "gold"), strict=True)):
        assert {still.materials[m].name for m in box.face_materials} == {what}
        assert box.extent.mean(axis=0) == pytest.approx([8.0 * k, 1.0, -9.0])
        assert (box.label, box.instance, box.name) == (140 + k, world.next_instance + k, f"m{k}")
    assert [m.name for m in still.paused] == ["m0", "m1", "m2", "m3", "m4"]
    assert len(still.still) == len(world.geometries)
