"""What a world says about mesh files and surveys that are not what they seem."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.build import build_world, world_config
from pelagos.world.doubt import crossing_faces, doubts, missing_files
from pelagos.world.mesh import join

SWING = {"kind": "swing", "at_m": [0, 0, -5], "amplitude_deg": 5, "period_s": 4}


def notes(path):
    things = [{"shape": "file", "path": str(path)}]
    return build_world(world_config({"type": "built", "things": things})).notes


def test_faces_through_each_other_are_counted():
    ball = shapes.sphere(1.0)
    assert crossing_faces(ball) == 0
    assert crossing_faces(join([ball, ball.moved((3, 0, 0))])) == 0
    assert crossing_faces(join([ball, ball.moved((0.7, 0.1, 0.05))])) > 20
    assert "intersects itself" in doubts(join([ball, ball.moved((0.7, 0.1, 0.05))]), "two balls")[0]
    rod = join([shapes.box((1, 1, 1)), shapes.cylinder(0.2, 3.0)])
    assert crossing_faces(rod) == 4  # the two triangles of the lid, and the two of the floor


@pytest.mark.parametrize("offset", [(1, 0, 0), (1, 0.5, 0), (1, 0, -0.5), (1, 1, 1)])
def test_things_that_touch_do_not_intersect(offset):
    box = shapes.box((1, 1, 1))
    assert crossing_faces(join([box, box.moved(offset)])) == 0


def test_a_boat_of_a_kilometre_is_doubted_as_thing_and_as_mover(tmp_path):
    trimesh.creation.box((1000, 300, 200)).export(tmp_path / "boat.stl")
    assert any("1000 m across" in n and "0.001" in n for n in notes(tmp_path / "boat.stl"))
    mover = {"name": "boat", "body": "file", "file": str(tmp_path / "boat.stl"), "path": SWING}
    said = build_world(world_config({"type": "flat", "movers": [mover]})).notes
    assert any("mover boat is 1000 m across" in n for n in said)
    said = build_world(world_config({"type": "flat", "movers": [{**mover, "size_m": 0.01}]})).notes
    assert not said


def test_missing_libraries_and_textures_are_named(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "a.obj").write_text("mtllib none.mtl\n" + text)
    (tmp_path / "b.obj").write_text("mtllib b.mtl\n" + text)
    (tmp_path / "b.mtl").write_text("newmtl wood\nmap_Kd planks.png\n")
    assert any("none.mtl, which does not exist" in n for n in notes(tmp_path / "a.obj"))
    assert any("planks.png, which does not exist" in n for n in notes(tmp_path / "b.obj"))
    (tmp_path / "c.mtl").write_text("newmtl steel\nmap_Bump rivets.png\n")
    (tmp_path / "c.obj").write_text("mtllib b.mtl\nmtllib c.mtl\n" + text)
    assert [n.split()[2] for n in notes(tmp_path / "c.obj")] == ["planks.png,", "rivets.png,"]
    (tmp_path / "planks.png").touch()
    assert not notes(tmp_path / "b.obj")


@pytest.mark.parametrize("kind", ["stl", "glb", "ply"])
def test_meshes_that_were_cut_off_say_so(tmp_path, kind):
    raw = trimesh.creation.icosphere(2).export(file_type=kind)
    (tmp_path / f"cut.{kind}").write_bytes(raw[: len(raw) // 2])
    with pytest.raises(WorldError, match="cannot be read; it may be damaged or cut short"):
        notes(tmp_path / f"cut.{kind}")


def test_a_thing_larger_than_the_world_is_not_placed_and_one_outside_refused():
    world = {"type": "generated", "size_m": [60, 60]}
    said = build_world(world_config({**world, "objects": [{"kind": "boulder", "count": 2, "size_m": 200}]})).notes
    assert said == ("boulder: 0 of 2 were placed; no room was found for the rest",)
    with pytest.raises(WorldError, match=r"boulder: at_m \[100.0, 0.0\] lies outside x -30 .. 30"):
        build_world(world_config({**world, "objects": [{"kind": "boulder", "at_m": [[100, 0]]}]}))


@pytest.mark.parametrize(
    ("scale", "crs", "says"),
    [(1.0, None, "look like longitude and latitude: crs: EPSG:4326"), (1.0, "EPSG:32633", "look like degrees"),
     (1e4, None, "as crs: EPSG:32633"), (1e4, "EPSG:4326", "cannot be longitudes and latitudes"),
     (1e4, "EPSG:99999", "pyproj knows")],
)  # fmt: skip
def test_a_coordinate_system_that_cannot_be(tmp_path, scale, crs, says):
    pytest.importorskip("pyproj")
    x, y = np.meshgrid(12.3 + 0.01 * np.arange(9), 45.3 + 0.01 * np.arange(9))
    np.savetxt(tmp_path / "s.xyz", np.c_[scale * x.ravel(), scale * y.ravel(), np.full(81, -9.0)], fmt="%.4f")
    config = {"type": "bathymetry", "path": str(tmp_path / "s.xyz"), "resolution_m": 500} | (
        {"crs": crs} if crs else {}
    )
    with pytest.raises(WorldError, match=says):
        build_world(world_config(config))


def gltf(images):
    return {"asset": {"version": "2.0"}, "images": images}


@pytest.mark.parametrize("packed", [False, True])
def test_textures_of_gltf_that_are_missing_are_named_and_those_inside_are_not(packed, tmp_path):
    images = [{"uri": "hull.png"}, {"uri": "data:image/png;base64,AAAA"}, {"bufferView": 0}, {"uri": "deck.png"},
              {"uri": "hull.png"}]  # fmt: skip
    raw = json.dumps(gltf(images)).encode()
    path = tmp_path / ("a.glb" if packed else "a.gltf")
    if packed:
        raw += b" " * (-len(raw) % 4)
        data = struct.pack("<II", len(raw), 0x4E4F534A) + raw + struct.pack("<II", 4, 0x004E4942) + b"\0\0\0\0"
        raw = struct.pack("<III", 0x46546C67, 2, 12 + len(data)) + data
    path.write_bytes(raw)
    assert [n.split()[2] for n in missing_files(path)] == ["hull.png,", "deck.png,"]
    (tmp_path / "deck.png").touch()
    assert [n.split()[2] for n in missing_files(path)] == ["hull.png,"]
    (tmp_path / "a.stl").write_bytes(raw)
    assert missing_files(tmp_path / "a.stl") == []


@pytest.mark.parametrize(("size", "said"), [
    (499.0, ""), (501.0, "501 m across: are its coordinates millimetres"), (0.0051, ""), (0.0049, "4.90 mm across"),
])  # fmt: skip
def test_sizes_that_are_not_of_things_at_sea_are_doubted(size, said):
    found = doubts(shapes.box((size / 3, size, size / 2)), "it")
    assert [said in n for n in found] == ([True] if said else [])
