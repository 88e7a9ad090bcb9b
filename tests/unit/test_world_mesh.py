"""Meshes and shapes: closed, facing outwards, with the volume of the books."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.mesh import Mesh, difference, intersection, join, rotation, smooth, union

RNG = np.random.default_rng(0)
CLOSED = {
    "box": shapes.box((1, 2, 3)),
    "cylinder": shapes.cylinder(1, 2),
    "cone": shapes.cone(1, 2),
    "frustum": shapes.cone(1, 2, top_radius=0.5),
    "sphere": shapes.sphere(1),
    "torus": shapes.torus(2, 0.5),
    "tube": shapes.tube([(0, 0, 0), (1, 0, 0), (2, 1, 1)], 0.1),
    "straight tube up": shapes.beam((0, 0, 0), (0, 0, 5), 0.1),
    "extrusion": shapes.extrude([(0, 0), (2, 0), (2, 1), (1, 0.5), (0, 1)], 2),
    "stone": shapes.noisy(shapes.sphere(1), 0.3, RNG),
    "chain": shapes.chain([(0, 0, 0), (0, 0, 3)], 0.2, 0.02),
    "loft": shapes.loft([[(x, 1, -1), (x, 1, 1), (x, -1, 1), (x, -1, -1)] for x in (0, 1, 2)]),
}


@pytest.mark.parametrize("name", CLOSED)
def test_shapes_are_closed_and_face_outwards(name):
    assert CLOSED[name].closed
    assert CLOSED[name].volume > 0


@pytest.mark.parametrize(
    ("name", "volume", "loss"),
    [
        ("box", 6.0, 1e-12),
        ("cylinder", 2 * np.pi, 0.012),  # a 24-sided prism holds sin(2 pi/24)/(2 pi/24) of a cylinder: 1.14 % less
        ("cone", 2 * np.pi / 3, 0.012),
        ("sphere", 4 * np.pi / 3, 0.04),
        ("torus", 2 * np.pi**2 * 2 * 0.25, 0.06),
        ("extrusion", 3.0, 1e-12),
    ],
)
def test_volumes(name, volume, loss):
    assert volume * (1 - loss) <= CLOSED[name].volume <= volume * (1 + 1e-9)


def test_an_open_mesh_is_not_closed():
    assert not shapes.plane((1, 1)).closed
    with pytest.raises(WorldError, match="not a closed solid"):
        union([shapes.plane((1, 1)), shapes.box((1, 1, 1))])


def test_booleans():
    a, b = shapes.box((1, 1, 1)), shapes.box((1, 1, 1)).moved((0.5, 0, 0))
    assert union([a, b]).volume == pytest.approx(1.5)
    assert difference(a, [b]).volume == pytest.approx(0.5)
    assert intersection(a, b).volume == pytest.approx(0.5)


def test_mirroring_keeps_faces_outwards():
    assert CLOSED["extrusion"].scaled((1, 1, -1)).volume == pytest.approx(3.0)


def test_turning_is_that_of_the_scenario_file():
    """R = Rz Ry Rx: positive yaw turns x towards y, positive pitch turns x down."""
    assert np.allclose(rotation(0, 0, np.pi / 2) @ [1, 0, 0], [0, 1, 0])
    assert np.allclose(rotation(0, np.pi / 2, 0) @ [1, 0, 0], [0, 0, -1])
    assert np.allclose(rotation(np.pi / 2, 0, 0) @ [0, 1, 0], [0, 0, 1])


def test_smooth_normals_of_a_sphere_point_outwards():
    vertices, _, normals = smooth(shapes.sphere(1, sides=60, rings=30), 30)
    assert np.einsum("ij,ij->i", vertices, normals).min() > 0.99


def test_creases_stay_sharp():
    vertices, faces, normals = smooth(shapes.box((1, 1, 1)), 30)
    assert len(vertices) == 24
    assert len(faces) == 12
    assert np.allclose(np.abs(normals).max(axis=1), 1)


def test_joining_keeps_every_face():
    both = join([CLOSED["box"], CLOSED["cone"].moved((5, 0, 0))])
    assert both.volume == pytest.approx(CLOSED["box"].volume + CLOSED["cone"].volume)
    assert both.closed


def test_merging_makes_one_vertex_of_several():
    split = Mesh(CLOSED["box"].triangles.reshape(-1, 3), np.arange(36, dtype=np.uint32).reshape(-1, 3))
    assert len(split.merged().vertices) == 8
    assert split.closed


def test_a_pose_that_mirrors_turns_faces_round():
    pose = np.diag([1.0, -2.0, 1.0, 1.0])
    pose[:3, 3] = 5.0
    posed = shapes.box((1, 2, 3)).posed(pose)
    assert posed.volume == pytest.approx(12.0)
    assert posed.bounds.mean(axis=0) == pytest.approx([5.0, 5.0, 5.0])


def test_a_mesh_is_welded_once():
    """It stays so where it is moved and turned, and not where it shrinks: vertices may meet then."""
    welded = shapes.box((1, 1, 1)).merged()
    assert welded.merged() is welded
    assert welded.moved((1, 2, 3)).turned(yaw=0.3).welded
    assert not welded.scaled(1e-9).welded


def test_normals_of_a_fine_sphere_need_no_vertex_twice():
    sphere = shapes.sphere(1, sides=60, rings=30).merged()
    vertices, faces, normals = smooth(sphere, 40)
    assert len(vertices) == len(sphere.vertices)
    assert np.array_equal(faces, sphere.faces)
    assert np.einsum("ij,ij->i", vertices, normals).min() > 0.99
