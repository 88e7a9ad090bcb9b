"""Description files: where their meshes are looked for, what a viewer shows of them, and what is said by default."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from pelagos.errors import WorldError
from pelagos.world.mesh import rotation
from pelagos.world.robots.mjcf import read_mjcf
from pelagos.world.robots.pose import compose, from_columns, from_euler, to_axis
from pelagos.world.robots.read import read_description
from pelagos.world.robots.shape import is_below, rod, tagged


def cube(path: Path, size: float) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((size, size, size)).export(path)
    return path


@pytest.mark.parametrize(("name", "order"), [
    ("package://robot/meshes/a.stl", ["urdf/robot/meshes/a.stl", "urdf/meshes/a.stl", "urdf/a.stl",
                                      "robot/meshes/a.stl", "meshes/a.stl",
                                      "../robot/meshes/a.stl"]),
    ("package://arm/meshes/a.stl", ["urdf/arm/meshes/a.stl", "urdf/meshes/a.stl", "urdf/a.stl", "arm/meshes/a.stl",
                                    "meshes/a.stl"]),
    ("../meshes/a.stl", ["meshes/a.stl", "urdf/meshes/a.stl", "urdf/a.stl"]),
    ("meshes/a.stl", ["urdf/meshes/a.stl", "urdf/a.stl", "../robot/urdf/../meshes/a.stl"]),
    ("model://robot/a.stl", ["urdf/robot/a.stl", "urdf/a.stl", "../robot/a.stl"]),
    ("a.stl", ["urdf/a.stl", "a.stl", "../a.stl"]),
])  # fmt: skip
def test_a_mesh_is_looked_for_beside_its_description_and_then_in_its_package(name, order, tmp_path):
    """In this order: each is found while it is there, and then the next."""
    robot = tmp_path / "robot"
    places = list(dict.fromkeys((robot / place).resolve() for place in order))
    for k, place in enumerate(places):
        cube(place, 1.0 + k)
    element = ElementTree.fromstring(f'<mesh filename="{name}" scale="1 2 3"/>')
    (robot / "urdf").mkdir(exist_ok=True)
    for k, place in enumerate(places):
        mesh = tagged(element, robot / "urdf")
        assert mesh is not None
        assert np.ptp(mesh.vertices, axis=0) == pytest.approx((1.0 + k) * np.array([1, 2, 3]))
        place.unlink()
    with pytest.raises(WorldError, match="was not found beside"):
        tagged(element, robot / "urdf")


def test_names_that_leave_their_folder_are_known():
    assert [is_below(n) for n in ("a/b.stl", "/a", "a/../b", "C:a", "a\\..\\b", "..a/b")] == [
        True, False, False, False, False, True
    ]  # fmt: skip


GEOMS = {
    "boxes": '<geom type="box" size="0.1 0.2 0.3" group="{a}" contype="{b}" conaffinity="{c}"/>'
    '<geom type="sphere" size="0.5" group="3" contype="0" conaffinity="0"/>',
}


@pytest.mark.parametrize(("a", "b", "c", "visual", "collision"), [
    (2, 1, 1, [0.2], [0.2]), (3, 0, 0, [0.2, 1.0], []), (0, 0, 1, [0.2], [0.2]), (3, 1, 0, [0.2, 1.0], [0.2]),
])  # fmt: skip
def test_shapes_that_are_shown_and_shapes_that_touch(a, b, c, visual, collision, tmp_path):
    """Groups 0 to 2 are shown, and all where there are none in these; what may touch in either way may touch."""
    root = lambda: ElementTree.fromstring(
        f"<mujoco><worldbody>{GEOMS['boxes'].format(a=a, b=b, c=c)}</worldbody></mujoco>"
    )
    wide = lambda which: [float(np.ptp(m.vertices[:, 0])) for m, _ in read_mjcf(root(), tmp_path, which)]
    assert wide("visual") == pytest.approx(visual, abs=0.02)
    assert wide("collision") == pytest.approx(collision)


def test_what_an_mjcf_file_leaves_out(tmp_path):
    """Angles in degrees, a sphere of 0.1 m, planes of 100 m where they have no size, meshes by their files' names."""
    cube(tmp_path / "parts" / "hull.stl", 2.0)
    text = """<mujoco><compiler assetdir="parts"/><asset><mesh file="hull.stl" scale="1 2 1"/></asset><worldbody>
    <geom pos="1 2 3"/><geom type="plane" size="0 3 1"/><geom mesh="hull" type="mesh" euler="0 0 90"/>
    <geom type="cylinder" size="0.2 0.7" axisangle="0 2 0 90"/><geom mesh="hull" pos="0 0 9"/></worldbody></mujoco>"""
    (tmp_path / "a.xml").write_text(text)
    found = list(read_mjcf(ElementTree.fromstring(text), tmp_path, "visual"))
    sizes = [np.ptp(m.vertices @ turn.T, axis=0) for m, (turn, _) in found]
    expected = [(0.2, 0.2, 0.2), (100, 6, 0), (4, 2, 2), (1.4, 0.4, 0.4), (2, 4, 2)]
    for size, wanted in zip(sizes, expected, strict=True):
        assert size == pytest.approx(wanted, abs=0.01)
    assert found[0][1][1].tolist() == [1, 2, 3]
    assert read_description(tmp_path / "a.xml").bounds[1, 2] == pytest.approx(10.0)
    asset = ElementTree.fromstring(text.replace('assetdir="parts"', 'assetdir="no" meshdir="parts"'))
    assert len(list(read_mjcf(asset, tmp_path, "visual"))) == 5


def test_poses_are_composed_and_axes_are_met():
    """Euler angles about turned axes in small letters, about fixed ones in capitals: the reverse order."""
    a, b, c = 0.4, -0.7, 1.1
    wanted = rotation(a, 0, 0) @ rotation(0, b, 0) @ rotation(0, 0, c)
    np.testing.assert_allclose(from_euler(np.array([a, b, c]), "xyz"), wanted, atol=1e-12)
    np.testing.assert_allclose(from_euler(np.array([c, b, a]), "ZYX"), wanted, atol=1e-12)
    turn = from_columns(np.array([0.0, 3.0, 4.0]), np.array([1.0, 1.0, 0.0]))
    assert turn[:, 0] == pytest.approx([0, 0.6, 0.8])
    assert turn.T @ turn == pytest.approx(np.eye(3))
    assert turn[:, 1] @ [1, 1, 0] > 0
    assert np.linalg.det(turn) == pytest.approx(1)
    for way in ((0.3, -0.5, 0.7), (0.0, 0.0, -2.0), (0.0, 0.0, 3.0), (-1.0, 0.0, 0.0)):
        found = to_axis(np.array(way))
        assert found @ [0, 0, 1] == pytest.approx(np.array(way) / np.linalg.norm(way))
        assert np.linalg.det(found) == pytest.approx(1)
    first, second = (turn, np.array([1.0, 2, 3])), (to_axis(np.array([1.0, 2, 2])), np.array([4.0, -5, 6]))
    point = np.array([0.5, -1.5, 2.5])
    both = compose(first, second)
    inner = second[0] @ point + second[1]
    assert both[0] @ point + both[1] == pytest.approx(first[0] @ inner + first[1])


def test_a_capsule_is_as_long_as_its_straight_part_and_two_radii():
    capsule = rod(0.3, 1.4, round_ends=True)
    assert capsule.bounds[:, 2] == pytest.approx([-1.0, 1.0])
    assert capsule.closed
    assert capsule.volume == pytest.approx(np.pi * 0.09 * 1.4 + 4 / 3 * np.pi * 0.027, rel=0.02)
    assert rod(0.3, 1.4, round_ends=False).bounds[:, 2] == pytest.approx([-0.7, 0.7])


@pytest.mark.parametrize("text", [
    '<robot><link name="a"><visual><geometry/></visual><visual/><visual><geometry><box size="1 2 3"/></geometry>'
    "</visual></link></robot>",
    "<sdf><model><link><visual><geometry/></visual><visual/><visual><geometry><box><size>1 2 3</size></box></geometry>"
    "</visual></link></model></sdf>",
], ids=["urdf", "sdf"])  # fmt: skip
def test_parts_without_a_shape_are_passed_over(text, tmp_path):
    (tmp_path / "a.urdf").write_text(text)
    assert np.ptp(read_description(tmp_path / "a.urdf").bounds, axis=0).tolist() == [1, 2, 3]
