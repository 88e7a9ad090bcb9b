"""Worlds by hand, the classics, saved worlds: places, files, doubts, errors."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest
from pydantic import ValidationError

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.build import build_world, world_config
from pelagos.world.classic import CLASSICS, ClassicConfig
from pelagos.world.export import export, load
from pelagos.world.generate.generated import GeneratedConfig
from pelagos.world.label import LABELS
from pelagos.world.preview import draw_map, render, statistics
from pelagos.world.robots.read import read_description
from pelagos.world.viewpoint import unroofed, viewpoints


def built(**keys):
    return build_world(world_config({"type": "built", **keys}))


def write_obj(path, mesh):
    rows = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces]
    path.write_text("\n".join(rows))
    return path


def test_things_stand_where_they_are_put():
    world = built(
        depth_m=10.0, labels={"pot": 130},
        things=[
            {"at_m": [5, 0, 1], "size_m": [2, 2, 2], "on_ground": True, "label": "pot", "material": "wood"},
            {"shape": "cylinder", "at_m": [0, 5, -5], "size_m": [1, 1, 8], "orientation_deg": [0, 90, 0], "repeat": 3,
             "step_m": [0, 2, 0], "label": 200},
        ],
    )  # fmt: skip
    hits = world.cast([(0, 0, -9), (0, 3, -5), (3.9, 9, -2)], [(1, 0, 0), (0, 1, 0), (0, 0, -1)])
    assert np.allclose(hits.t, [4.0, 1.5, 2.5], atol=2e-3)  # 48 sides: the cylinder's faces lie up to 1.1 mm inside
    assert hits.label.tolist() == [130, 200, 200]
    assert world.names[4] == "cylinder"


def test_a_mesh_in_millimetres_is_doubted(tmp_path):
    write_obj(tmp_path / "boat.obj", shapes.box((1000, 300, 200)))
    things = [{"shape": "file", "path": str(tmp_path / "boat.obj")}]
    assert any("millimetres" in n for n in built(things=things).notes)
    assert not built(things=[things[0] | {"scale": 0.01}]).notes


def test_an_open_mesh_is_doubted(tmp_path):
    write_obj(tmp_path / "sheet.obj", shapes.plane((2, 2)))
    assert any("not closed" in n for n in built(things=[{"shape": "file", "path": str(tmp_path / "sheet.obj")}]).notes)


URDF = """<robot name="r">
  <link name="base"><visual><origin xyz="0 0 1"/><geometry><box size="2 2 2"/></geometry></visual></link>
  <link name="arm"><visual><geometry><sphere radius="0.5"/></geometry></visual>
    <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="3 0 0" rpy="0 0 1.5708"/></joint>
</robot>"""
SDF = """<sdf version="1.7"><model name="m"><pose>1 0 0 0 0 0</pose><link name="l"><pose>0 2 0 0 0 0</pose>
  <visual name="v"><geometry><box><size>2 2 2</size></box></geometry></visual></link></model></sdf>"""
MJCF = """<mujoco><compiler angle="radian"/><worldbody><body pos="1 0 0" euler="0 0 1.5707963">
  <geom type="box" size="1 0.5 0.25" pos="2 0 0"/><body pos="0 0 1"><geom type="capsule" size="0.1 0.5"/></body>
  </body></worldbody></mujoco>"""


def test_urdf(tmp_path):
    (tmp_path / "r.urdf").write_text(URDF)
    low, high = read_description(tmp_path / "r.urdf").bounds
    assert np.allclose(low, [-1, -1, -0.5], atol=1e-3)
    assert np.allclose(high, [3.5, 1, 2], atol=1e-3)
    assert read_description(tmp_path / "r.urdf", "collision").bounds[1, 2] == pytest.approx(1.0)


def test_sdf(tmp_path):
    (tmp_path / "m.sdf").write_text(SDF)
    assert read_description(tmp_path / "m.sdf").bounds.tolist() == [[0, 1, -1], [2, 3, 1]]


def test_mjcf(tmp_path):
    (tmp_path / "m.xml").write_text(MJCF)
    low, high = read_description(tmp_path / "m.xml").bounds
    assert np.allclose(low, [0.5, -0.1, -0.25], atol=1e-3)
    assert np.allclose(high, [1.5, 3, 1.6], atol=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [("<robot", "not XML"), ("<thing/>", "known: <robot>"), ("<robot/>", "no visual shapes"),
     ('<robot><link><visual><geometry><mesh filename="a.stl"/></geometry></visual></link></robot>', "not found beside"),
     ('<robot><link><visual><geometry><sphere/></geometry></visual></link></robot>', "missing or wrong")],
)  # fmt: skip
def test_bad_descriptions(tmp_path, text, message):
    (tmp_path / "r.urdf").write_text(text)
    with pytest.raises(WorldError, match=message):
        read_description(tmp_path / "r.urdf")


def test_contradictions_are_refused():
    with pytest.raises(ValidationError, match="path goes with shape"):
        world_config({"type": "built", "things": [{"shape": "file"}]})


LARGE = {"dam", "open_water", "pier_harbor"}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in LARGE else ()) for n in CLASSICS])
def test_classics_build_and_have_free_water_or_air(name):
    world = ClassicConfig(name=name, latitude_deg=-33.5, longitude_deg=18.25).build()
    assert (world.origin.latitude, world.origin.longitude) == (-33.5, 18.25)
    dry = {"rooms": (-3, 3, 1), "business_campus": (45, 30, 1.5), "example_level": (0, 0, 2)}
    start = {"open_water": (0, 0, -150), "tank": (0, 0, -2), **dry}.get(name, (-20, 10, -5))
    assert world.inside(start, 0.5) is None
    assert not [n for n in world.notes if "placed" in n]
    assert len(world.description) > 20


def test_the_campus_lies_as_it_is_drawn():
    """Three buildings: the floor as large as the walls about it, partitions from floor to ceiling at thirds of the
    length, away from the street; a court of gravel that lies lower than the walks."""
    world = ClassicConfig(name="business_campus").build()
    boxes = lambda name: [np.array([g.vertices.min(axis=0), g.vertices.max(axis=0)])
                          for g in world.geometries if g.name == name]  # fmt: skip
    floors = sorted(boxes("floor"), key=lambda b: b[0, 1])
    expected = [(45, -35, 30, 20), (45, 35, 36, 24), (-10, 60, 24, 18)]
    walls = sorted(boxes("partition"), key=lambda b: b[0, 1])
    assert len(floors) == len(walls) == 3
    for (x, y, length, width), floor, wall in zip(expected, floors, walls, strict=True):
        assert floor[:, :2] == pytest.approx(
            np.array([[x, y], [x, y]]) + np.array([[-1], [1]]) * [length / 2, width / 2]
        )
        assert floor[1, 2] == pytest.approx(0.2)
        middle = y + 0.15 * width * (1 if y > 0 else -1)
        low = [x - length / 6 - 0.075, middle - 0.3 * width, 0.2]
        high = [x + length / 6 + 0.075, middle + 0.3 * width, 3.6]
        assert wall == pytest.approx(np.array([low, high]))
    (court,) = boxes("court")
    assert court == pytest.approx(np.array([[-80.0, 40.0, 0.0], [-60.0, 60.0, 0.15]]))
    assert max(b[1, 2] for b in boxes("sidewalk")) == pytest.approx(0.2)


@pytest.mark.slow
def test_the_harbour_has_a_way_in_and_ships_at_its_piers():
    world = ClassicConfig(name="pier_harbor").build()
    for start in ((0, -500, -1), (0, -700, -3), (-20, 10, -10)):
        assert world.inside(start, 2.0) is None
    assert world.cast((0, -950, -3), (0, 1, 0), 900).t[0] > 850  # up the channel and between the moles
    ships = [g for g in world.geometries if g.name == "moored ship" and g.label == LABELS["container_boat"].number]
    assert len({g.instance for g in ships}) == 8
    yachts = [g for g in world.geometries if g.label == LABELS["yacht"].number]
    assert len({g.instance for g in yachts}) == 8  # one at each finger of the marina
    assert max(g.vertices[:, 2].max() for g in ships) > 8


def test_the_test_world_has_its_wall():
    world = ClassicConfig(name="test_world").build()
    assert world.cast((0.77, 0.7, 0.5), (1, 0, 0)).t[0] == pytest.approx(2.0, abs=1e-5)


@pytest.fixture(scope="module")
def small():
    return GeneratedConfig(
        size_m=(60, 60), depth_m=12, patches=("mud",),
        objects=({"kind": "boulder", "count": 5}, {"kind": "tyre", "count": 2}),
    ).build()  # fmt: skip


def test_saved_worlds_come_back_byte_for_byte(small, tmp_path):
    files = export(small, tmp_path)
    assert [f.name for f in files] == ["world.npz", "world.glb", "labels.json", "height.npz"]
    again = build_world(world_config({"type": "saved", "path": str(tmp_path / "world.npz")}))
    for a, b in zip(small.geometries, again.geometries, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()
        assert a.faces.tobytes() == b.faces.tobytes()
        assert a.face_materials.tobytes() == b.face_materials.tobytes()
        assert (a.label, a.instance, a.name) == (b.label, b.instance, b.name)
        assert (a.vertex_normals is None) == (b.vertex_normals is None)
    assert again.materials == small.materials
    assert again.terrain is not None
    assert again.terrain.z.tobytes() == small.terrain.z.tobytes()
    assert json.loads((tmp_path / "labels.json").read_text())["materials"] == [m.name for m in small.materials]


def test_gltf_holds_every_triangle(small, tmp_path):
    import trimesh

    export(small, tmp_path)
    scene = trimesh.load_scene(tmp_path / "world.glb")
    assert sum(len(g.faces) for g in scene.geometry.values()) == small.triangles
    low = scene.bounds[0]  # y up
    assert np.allclose([low[0], low[1]], [small.bounds[0, 0], small.bounds[0, 2]], atol=1e-4)


def test_damaged_saved_worlds(small, tmp_path):
    export(small, tmp_path)
    torn = tmp_path / "torn.npz"
    torn.write_bytes((tmp_path / "world.npz").read_bytes()[:5000])
    with pytest.raises(WorldError, match="damaged"):
        load(torn)
    with pytest.raises(WorldError, match="does not exist"):
        load(tmp_path / "none.npz")


def test_previews(small, tmp_path):
    about = statistics(small)
    assert about["objects"]["boulder"] == 5
    assert about["area_m2"] == pytest.approx(3600)
    draw_map(small, tmp_path / "map.png", pixels=60)
    render(small, tmp_path / "view.png", size=(64, 40), samples=2)
    from PIL import Image

    with Image.open(tmp_path / "view.png") as picture:
        assert picture.size == (64, 40)
        assert np.asarray(picture).std() > 5
    assert (tmp_path / "map.png").stat().st_size > 5000
    assert hashlib.sha256((tmp_path / "map.png").read_bytes()).digest()


@pytest.mark.parametrize("kind", ["flat", "harbour", "generated", "classic"])
def test_any_world_takes_things(kind):
    """A box stands where it was put, on whatever ground is there, with its label, material and an id of its own."""
    more = {"name": "tank"} if kind == "classic" else {}
    box = {"at_m": [3.0, -2.0, 0.5], "on_ground": True, "material": "gold", "label": "chest", "name": "chest"}
    world = build_world(world_config({"type": kind, **more, "things": [box], "labels": {"chest": 200}}))
    hit = world.cast([3.0, -2.0, float(world.height(3.0, -2.0)) + 1.5], (0.0, 0.0, -1.0), 5.0)
    assert hit.t[0] == pytest.approx(0.5, abs=1e-3)
    assert hit.label[0] == 200
    assert world.materials[hit.material[0]].name == "gold"
    assert world.names[int(hit.instance[0])] == "chest"
    assert len({g.instance for g in world.geometries if g.name == "chest"}) == 1


def test_generated_things_keep_off_what_was_placed_by_hand():
    wall = {"at_m": [0, 0, 1], "size_m": [50, 1, 2], "on_ground": True, "orientation_deg": [0, 0, 30], "name": "wall"}
    world = build_world(
        world_config(
            {"type": "generated", "size_m": [60, 60], "things": [wall],
             "objects": [{"kind": "manta_mine", "count": 150, "size_m": 1.0}]}
        )
    )  # fmt: skip
    along = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    for g in world.geometries:
        if g.name == "truncated cone mine":
            u, v = g.vertices[:, :2] @ along, g.vertices[:, :2] @ np.array([-along[1], along[0]])
            assert not ((np.abs(u) < 25) & (np.abs(v) < 0.5)).any()


def test_sdf_worlds_with_nested_and_included_models_and_poses_in_degrees(tmp_path):
    box = "<link name='l'><visual name='v'><geometry><box><size>4 1 1</size></box></geometry></visual></link>"
    (tmp_path / "rock").mkdir()
    (tmp_path / "rock" / "model.sdf").write_text(f"<sdf version='1.9'><model name='r'>{box}</model></sdf>")
    (tmp_path / "a.sdf").write_text(
        "<sdf version='1.9'><world name='w'><model name='m'><pose degrees='true'>10 0 0 0 0 90</pose>"
        f"<model name='n'><pose>5 0 0 0 0 0</pose>{box}</model></model>"
        "<include><uri>model://rock</uri>"
        "<pose rotation_format='quat_xyzw'>0 0 8 0 0.7071068 0 0.7071068</pose></include>"
        "</world></sdf>"
    )
    low, high = read_description(tmp_path / "a.sdf").bounds
    assert low == pytest.approx([-0.5, -0.5, -0.5], abs=1e-5)  # the included box stands upright about z = 8
    assert high == pytest.approx([10.5, 7.0, 10.0], abs=1e-5)  # the nested one, 5 m along y, lies along y
    (tmp_path / "a.sdf").write_text((tmp_path / "a.sdf").read_text().replace("model://rock", "model://reef"))
    with pytest.raises(WorldError, match="'model://reef' that is included was not found"):
        read_description(tmp_path / "a.sdf")


def test_xacro_is_named(tmp_path):
    (tmp_path / "r.urdf").write_text(URDF.replace("2 2 2", "${size} 2 2"))
    with pytest.raises(WorldError, match="written in xacro; expand it first"):
        read_description(tmp_path / "r.urdf")


def test_pictures_look_into_rooms_and_at_what_is_worth_it():
    """Roofs are off, most of the world is in the first view, and the largest thing, no rim or line, comes next."""
    rooms = build_world(world_config({"type": "classic", "name": "rooms"}))
    assert {g.name for g in rooms.geometries} - {g.name for g in unroofed(rooms).geometries} == {"ceiling"}
    assert viewpoints(unroofed(rooms))[0].name.startswith("the whole")
    dam = build_world(world_config({"type": "classic", "name": "dam"}))
    assert unroofed(dam) is dam
    assert [v.name for v in viewpoints(dam)][:2] == ["the whole, drained of its water", "dam"]
    tests = build_world(world_config({"type": "classic", "name": "test_world"}))
    assert viewpoints(tests)[0].name.startswith("the whole")
