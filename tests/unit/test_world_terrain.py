"""Height fields: node values, interpolation, and rays that hit what the queries say."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField


@pytest.fixture(scope="module")
def field():
    return HeightField(-30.0, 12.5, 0.7, np.random.default_rng(3).normal(-20, 1, (40, 30)))


def test_nodes_are_reproduced_exactly(field):
    for each in (field, HeightField(-30.0, 12.5, 0.7, field.z.T)):
        x, y = np.meshgrid(each.x, each.y, indexing="ij")
        assert np.array_equal(each.height(x, y), each.z)
        assert np.array_equal(each.surface(x, y), each.z)


def test_bilinear_is_exact_for_bilinear_ground():
    x, y = np.arange(6) * 2.0 + 1, np.arange(5) * 2.0 - 3
    plane = HeightField(1.0, -3.0, 2.0, 0.3 * x[:, None] - 0.2 * y + 0.05 * x[:, None] * y)
    at = np.random.default_rng(0).uniform(0, 1, (2, 100)) * [[10], [8]] + [[1], [-3]]
    assert np.allclose(plane.height(*at), 0.3 * at[0] - 0.2 * at[1] + 0.05 * at[0] * at[1], atol=1e-12)


def test_outside_is_nan(field):
    assert np.isnan(field.height([-30.01, 0], [20, 11.0])).all()


def test_a_surface_lies_within_a_quarter_of_the_twist(field):
    z = field.z
    twist = np.abs(z[:-1, :-1] + z[1:, 1:] - z[1:, :-1] - z[:-1, 1:]).max()
    at = np.random.default_rng(1).uniform(0, 1, (2, 500)) * [[27], [20]] + [[-30], [12.5]]
    assert np.abs(field.height(*at) - field.surface(*at)).max() <= twist / 4 + 1e-12


def test_rays_hit_the_surface(field):
    """Single precision about an origin 40 m away: 1e-5 m."""
    site = Site()
    site.ground(field, "sand")
    world = site.world(name="t", description="", origin=GeoOrigin(0, 0))
    at = np.random.default_rng(2).uniform(0.01, 0.99, (300, 2)) * [27.3, 20.3] + [-30, 12.5]
    hits = world.cast(np.column_stack([at, np.zeros(300)]), (0, 0, -1))
    assert hits.valid.all()
    assert np.abs(hits.position[:, 2] - world.height(at[:, 0], at[:, 1])).max() < 2e-5
    assert (hits.normal[:, 2] > 0).all()


def test_faces_look_up_and_normals_too(field):
    corners = field.vertices()[field.faces()]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()
    assert field.normals()[..., 2].min() > 0


@pytest.mark.parametrize("z", [np.zeros((1, 5)), np.full((3, 3), np.nan)])
def test_impossible_fields_are_refused(z):
    with pytest.raises(WorldError):
        HeightField(0, 0, 1, z)
