"""Borders between materials cut triangles in their own plane: the same surface, no cracks, smooth lines."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.world.border import patchwork
from pelagos.world.mesh import Mesh
from pelagos.world.terrain import HeightField
from pelagos.world.world import MATERIALS, World

ROWS = np.array([0, 1, 2], dtype=np.uint32)


def ground(seed=0):
    z = np.random.default_rng(seed).normal(-10, 0.5, (31, 41))
    return HeightField(-15.0, -20.0, 1.0, z)


def made(fields, seed=0):
    field = ground(seed)
    return field, patchwork(field, np.asarray(fields, dtype=np.float32), ROWS, label=4, instance=1)


def random_fields(seed=0):
    return np.random.default_rng(seed).normal(size=(3, 31, 41))


def world_of(geometry):
    materials = tuple(MATERIALS[n] for n in ("sand", "mud", "gravel"))
    return World([geometry], materials)


@pytest.mark.parametrize("seed", range(4))
def test_the_surface_stays_and_has_no_cracks(seed):
    """Random fields cut nearly every triangle, many into six. Area in plan is kept, edges inside have two faces."""
    field, geometry = made(random_fields(seed), seed)
    corners = geometry.vertices[geometry.faces]
    a, b = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    area = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(30 * 40)
    edges = np.sort(geometry.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    assert (count == 1).sum() >= 2 * (30 + 40)  # the rim, some of it cut
    rim = geometry.vertices[np.unique(edges, axis=0)[count == 1]]
    on_rim = (np.abs(rim[..., 0]) == 15.0) | (np.abs(rim[..., 1]) == 20.0)
    assert on_rim.all()
    xy = np.random.default_rng(1).uniform([-14.9, -19.9], [14.9, 19.9], (4000, 2))
    hits = world_of(geometry).cast(np.column_stack([xy, np.zeros(4000)]), (0, 0, -1))
    assert hits.valid.all()
    assert np.abs(hits.position[:, 2] - field.surface(*xy.T)).max() < 2e-5
    assert np.allclose(np.linalg.norm(geometry.vertex_normals, axis=1), 1, atol=1e-5)


def test_a_straight_border_is_straight():
    """Fields that cross on a slanting line put every point on its right side of that line."""
    x, y = np.meshgrid(np.arange(31) - 15.0, np.arange(41) - 20.0, indexing="ij")
    _, geometry = made([np.zeros_like(x), 0.37 * x + y - 1.234, np.full_like(x, -99)])
    xy = np.random.default_rng(1).uniform([-14.9, -19.9], [14.9, 19.9], (4000, 2))
    hits = world_of(geometry).cast(np.column_stack([xy, np.zeros(4000)]), (0, 0, -1))
    side = 0.37 * xy[:, 0] + xy[:, 1] - 1.234
    clear = np.abs(side) > 0.05  # cuts keep 4 % of an edge away from nodes
    assert np.array_equal(hits.material[clear], (side[clear] > 0).astype(np.uint32))


def test_one_material_is_the_plain_mesh():
    field, geometry = made([np.ones((31, 41)), np.zeros((31, 41)), np.zeros((31, 41))])
    plain = field.geometry(material=0, label=4, instance=1)
    assert np.array_equal(geometry.faces, plain.faces)
    assert np.array_equal(geometry.vertices, plain.vertices)
    assert not geometry.face_materials.any()


def test_same_fields_same_bytes():
    one, two = made(random_fields())[1], made(random_fields())[1]
    assert one.vertices.tobytes() == two.vertices.tobytes()
    assert one.faces.tobytes() == two.faces.tobytes()
    assert Mesh(one.vertices, one.faces).bounds.shape == (2, 3)
