"""Worlds that are written and read again, things out of files of other programs, and what sheets and views tell."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from test_known_contents import by_label, of_a_mesh

from known import DOUBLE, check
from pelagos.world import shapes
from pelagos.world.body import SHAPES, Prop
from pelagos.world.build import build_world, world_config
from pelagos.world.doubt import crossing_faces, doubts
from pelagos.world.export import export, load
from pelagos.world.files import read_mesh
from pelagos.world.mesh import join
from pelagos.world.path import CirclePath, SwingPath, WanderPath, WaypointPath
from pelagos.world.preview import statistics
from pelagos.world.robots.read import read_description
from pelagos.world.sheet import summary
from pelagos.world.viewpoint import unroofed, viewpoints
from pelagos.world.world import World

MOVERS = [
    {"name": "ship", "body": "ship", "size_m": 6.0, "path": {"kind": "waypoints", "points_m": [[-9, -7, 0], [4, 9, 0], [
     14, -3, 0]], "speed_mps": 1.2, "at_end": "loop"}},
    {"name": "boat", "body": "file", "file": "boat.stl", "size_m": 1.3, "path": {"kind": "swing", "at_m": [3.0, -2.0,
     -4.0], "amplitude_deg": 25.0, "period_s": 3.7, "towards_deg": 35.0, "phase_deg": 50.0}},
]  # fmt: skip
THINGS = [
    {"shape": "box", "at_m": [3.0, 2.0, 1.5], "on_ground": True, "size_m": [2, 4, 3], "label": 140, "orientation_deg": [
     10, -20, 35], "material": "steel", "repeat": 3, "step_m": [4.0, -3.0, 0.5]},
    {"shape": "file", "path": "boat.stl", "at_m": [-8.0, 3.0, -5.0], "scale": 1.4, "up": "y", "orientation_deg": [0, 30,
     -70]},
    {"shape": "corner_reflector", "at_m": [-3.0, -7.0, -4.0], "size_m": [2.1, 2.1, 2.1], "orientation_deg": [5, -40,
    20]},
    {"shape": "cylinder", "at_deg": [45.00006, 12.99991], "at_m": [0, 0, -5.0], "size_m": [1, 2, 3],
    "smooth_deg": None},
    {"shape": "file", "path": "arm.urdf", "at_m": [11.0, 6.0, -6.0]},
]  # fmt: skip
URDF = """<robot name="arm"><material name="m"/>
<link name="base"><visual><origin xyz="0.1 -0.2 0.3" rpy="0.2 -0.4 0.9"/><geometry><box size="1 0.6 0.4"/></geometry>
  </visual>
  <collision><geometry><sphere radius="0.7"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0.5 0.2 0.9" rpy="-0.3 0.6 0.1"/>
  <axis xyz="0 0 1"/></joint>
<link name="upper"><visual><origin xyz="0 0.1 0.4"/><geometry><cylinder radius="0.2" length="1.3"/></geometry>
  </visual></link>
<joint name="b" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0.1 -0.3 1.1" rpy="0.5 0.1 -0.7"/>
  </joint>
<link name="hand"><visual><origin rpy="0.1 0.2 0.3"/><geometry><mesh filename="boat.stl" scale="0.2 0.3 0.4"/>
  </geometry></visual>
  <collision><geometry><box size="0.3 0.2 0.1"/></geometry></collision></link></robot>"""
SDF = """<sdf version="1.7"><world name="w"><model name="m"><pose>1 -2 3 0.2 -0.3 0.4</pose>
<link name="l"><pose degrees="true">0.3 0.1 -0.2 10 20 -30</pose>
  <visual name="v"><pose rotation_format="quat_xyzw">0.1 0.2 0.3 0.1 -0.2 0.3 0.9</pose><geometry><capsule>
  <radius>0.3</radius>
  <length>1.1</length></capsule></geometry></visual>
  <visual name="u"><geometry><ellipsoid><radii>0.3 0.5 0.9</radii></ellipsoid></geometry></visual>
  <collision name="c"><geometry><cone><radius>0.4</radius><length>0.9</length></cone></geometry></collision></link>
<model name="inner"><pose>0.4 0.5 -0.6 0 0.2 0</pose><link name="k"><visual name="p"><geometry><plane><size>2 3</size>
  </plane>
  </geometry></visual></link></model></model>
<include><uri>model://other</uri><pose>-3 1 0.5 0 0 0.7</pose></include></world></sdf>"""
OTHER = """<sdf version="1.7"><model name="o"><pose>0.2 0 0 0.1 0 0</pose><link name="l"><visual name="v"><geometry>
  <box>
<size>0.5 0.7 0.9</size></box></geometry></visual></link></model></sdf>"""
MJCF = """<mujoco><compiler angle="{angle}" eulerseq="{order}" meshdir="."/>
<default><geom size="0.2 0.3 0.4"/><default class="thin"><geom type="capsule" size="0.1 0.6"/></default></default>
<asset><mesh name="boat" file="boat.stl" scale="0.3 0.4 0.2" refpos="0.1 0.2 -0.1" refquat="0.9 0.1 0.3 -0.2"/></asset>
<worldbody><geom type="box" pos="1 2 -1" euler="{turn}"/>
<body pos="0.5 -0.4 0.3" quat="0.8 0.2 -0.3 0.4" childclass="thin"><geom fromto="0 0.1 0.2 0.9 -0.4 0.7"/>
  <geom pos="0.2 0.3 0.1" axisangle="0.2 0.5 -0.8 {axis}"/>
  <body pos="0 0.3 0.8" xyaxes="1 0.3 0.1 -0.2 1 0.4"><geom type="ellipsoid" zaxis="0.3 -0.5 0.7" size="0.4 0.6 0.2"/>
  <geom type="mesh" mesh="boat" pos="1 0 0"/></body></body>
<frame pos="-1 0.3 0.6" euler="{turn}"><geom type="cylinder" size="0.3 0.5" group="3" contype="0" conaffinity="0"/>
  <geom type="sphere" contype="0" conaffinity="0" pos="0.4 0.1 0"/></frame>
<include file="more.xml"/></worldbody></mujoco>"""
MORE = """<mujocoinclude><body pos="2 -1 0.5"><geom type="plane" size="1.2 0.7 0.1" euler="0.3 0.2 0.1"/></body>
  </mujocoinclude>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Files of a boat that is symmetric in nothing, and of robots with it."""
    hull = trimesh.Trimesh([[0, 0, 0], [2.1, 0.2, 0.1], [0.3, 1.2, -0.2], [0.4, 0.3, 0.9], [1.1, 0.8, 0.7]],
                           [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]],
                           process=False)  # fmt: skip
    for kind in ("stl", "ply", "obj", "off", "glb"):
        hull.export(tmp_path / f"boat.{kind}")
    scene = trimesh.Scene()
    for k in range(3):
        pose = trimesh.transformations.euler_matrix(0.2 * k, -0.3, 0.5 * k)
        pose[:3, 3] = [1.5 * k, -0.7 * k, 0.3]
        scene.add_geometry(hull, node_name=f"n{k}", geom_name="hull", transform=pose)
    scene.export(tmp_path / "fleet.glb")
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "scene.sdf").write_text(SDF)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "model.sdf").write_text(OTHER)
    (tmp_path / "more.xml").write_text(MORE)
    turns = {"angle": "degree", "order": "xyz", "turn": "20 -35 50", "axis": "70"}
    (tmp_path / "moving.xml").write_text(MJCF.format(**turns))
    (tmp_path / "fixed.xml").write_text(MJCF.format(angle="radian", order="ZYX", turn="0.3 -0.6 0.9", axis="1.2"))
    return tmp_path


def of_mesh(mesh: Any) -> list[float]:
    return of_a_mesh(mesh.geometry(material=3, label=1, instance=1, name="it", crease_deg=35.0))


@pytest.mark.parametrize("kind", ["boat.stl", "boat.ply", "boat.obj", "boat.off", "boat.glb", "fleet.glb"])
def test_meshes(kind: str, folder: Path) -> None:
    check("files", kind, {"mesh": of_mesh(read_mesh(folder / kind))}, DOUBLE)


@pytest.mark.parametrize("kind", ["arm.urdf", "scene.sdf", "moving.xml", "fixed.xml"])
@pytest.mark.parametrize("which", ["visual", "collision"])
def test_descriptions(kind: str, which: str, folder: Path) -> None:
    mesh = read_description(folder / kind, which)
    check("files", f"{kind} {which}", {"mesh": of_mesh(mesh), "corners": mesh.vertices}, DOUBLE)


def built(folder: Path) -> World:
    things = [{**t, "path": str(folder / t["path"])} if "path" in t else t for t in THINGS]
    movers = [{**m, "file": str(folder / m["file"])} if "file" in m else m for m in MOVERS]
    keys = {"type": "generated", "seed": 4, "size_m": [56, 40], "grid_m": 2.0, "depth_m": 9.0, "latitude_deg": 45.0,
            "longitude_deg": 13.0, "labels": {"wonder": 131}, "terrain": {"kind": "ridges", "relief_m": 2.3,
            "wavelength_m": 31.0, "heading_deg": -25.0},
            "objects": [{"kind": "boulder", "count": 7, "size_m": 1.5}, {"kind": "barrel", "count": 5}]}  # fmt: skip
    return build_world(world_config({**keys, "things": things, "movers": movers}))


def test_worlds_written_and_read_again(folder: Path) -> None:
    world = built(folder)
    files = export(world, folder / "out", t=1.3)
    again = load(files[0])
    place = [again.origin.latitude, again.origin.longitude]
    x, y = np.random.default_rng(2).uniform(-17.0, 17.0, (2, 40))
    names = json.loads(files[2].read_text())
    field = np.load(files[3])
    found: dict[str, Any] = {
        f"again {label}": values for label, values in by_label(list(again.geometries)).items()
    } | {
        "origin": place, "height": again.height(x, y), "instances": [g.instance for g in again.geometries],
        "materials": [*(v for m in again.materials for v in (*m.albedo, m.density_kgpm3 if hasattr(m,
        "density_kgpm3") else 0.0))],
        "moving": np.concatenate([[*p.position, *p.attitude] for m in again.movers for t in (0.0,
        2.7) for p in [m.pose(t)]]),
        "legend": [float(k) for k in names["labels"]] + [len(names[k]) for k in sorted(names)],
        "field": field["z"], "axes": [*field["x"], *field["y"]],
    }  # fmt: skip
    scene = trimesh.load_scene(files[1], process=False)
    found["glb"] = [v for name in sorted(scene.graph.nodes_geometry) for v in np.ravel(scene.graph[name][0])[:12]]
    whole = scene.to_mesh()
    found["glb corners"] = [*whole.bounds.ravel(), whole.area, *whole.centroid]
    check("files", "written and read again", found, DOUBLE)


def test_what_sheets_and_views_tell(folder: Path) -> None:
    world = built(folder)
    stats = statistics(world) | {"generation_s": 1.25, "peak_memory_mb": 431.0}
    told = [float(v) for _, text in summary(stats) for v in re.findall(r"-?\d+\.?\d*", text.replace(",", ""))]
    views = [[*v.eye, *v.target, v.exaggeration] for v in viewpoints(world)]

    check("files", "sheets and views", {"told": told, "views": views, "open": [len(unroofed(world).geometries)]}, 1e-4)


PATHS = {
    "circle": CirclePath(centre_m=(3.0, -2.0, -5.0), radius_m=4.0, speed_mps=0.7, phase_deg=40.0),
    "clockwise": CirclePath(centre_m=(3.0, -2.0, -5.0), radius_m=4.0, speed_mps=0.7, phase_deg=40.0, clockwise=True),
    **{end: WaypointPath(points_m=((0, 1, -2), (4, -3, -4), (9, 2, -3), (5, 7, -1)), speed_mps=0.8, start_s=3.0,
                         at_end=end) for end in ("stop", "again", "loop")},
    "swing": SwingPath(at_m=(3.0, -2.0, -5.0), amplitude_deg=35.0, period_s=7.0, towards_deg=-55.0, phase_deg=25.0),
    "wander": WanderPath(at_m=(3.0, -2.0, -5.0), reach_m=(4.0, 7.0, 2.0), period_s=23.0, seed=5),
}  # fmt: skip


@pytest.mark.parametrize("name", PATHS)
def test_paths(name: str) -> None:
    path: Any = PATHS[name]
    poses = [path.pose(t) for t in np.linspace(-2.0, 61.0, 40)]
    parts = ("position", "attitude", "velocity", "angular_velocity")
    found = {part: [getattr(pose, part) for pose in poses] for part in parts}
    check("files", f"path {name}", found | {"fastest": [path.fastest_mps]}, DOUBLE)


@pytest.mark.parametrize("shape", SHAPES)
def test_props(shape: str, folder: Path) -> None:
    size: Any = 1.7 if shape == "corner_reflector" else (1.7, 0.6, 2.3)
    prop = Prop(shape, size=size, path=folder / "boat.stl" if shape == "mesh" else None, material="rock")
    world = build_world(world_config({"type": "flat", "size_m": [60, 60]}))
    made = prop.geometry(instance=7, world=world)
    check("files", f"prop {shape}", {"mesh": of_a_mesh(made), "radius": [prop.bounding_radius, made.label]}, DOUBLE)


def test_doubts() -> None:
    ball, rod = shapes.sphere(1.0), join([shapes.box((1, 2, 1)), shapes.cylinder(0.2, 3.0)])
    meshes = [
        ball, rod, join([ball, ball.moved((0.7, 0.1, 0.05))]), ball.scaled(900.0), ball.scaled(0.001),
            shapes.plane((2, 3)),
        join([shapes.box((1, 1, 1)), shapes.box((0.4, 3.0, 0.3)).rotated(np.eye(3)[[1, 2, 0]]).moved((0.1, 0.2, 0.1))]),
    ]  # fmt: skip
    found = [
        [crossing_faces(m), len(doubts(m, "it")), len(doubts(m, "it", parts=True)), m.volume, m.closed] for m in meshes
    ]
    check("files", "doubts", {"found": found}, DOUBLE)
