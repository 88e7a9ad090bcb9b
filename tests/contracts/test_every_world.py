"""What every kind of world must do, checked the day it is added."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.config import registry
from pelagos.config.described import descriptions
from pelagos.world.build import build_world, world_config, world_types
from pelagos.world.export import save
from pelagos.world.generate.objects import KINDS

NEEDS = {
    "bathymetry": {
        "path": "matplotlib:topobathy.npz",
        "centre_deg": [48.835, -122.95],
        "size_m": [4000, 4000],
        "resolution_m": 40.0,
    },
    "classic": {"name": "test_world"},
    "large": {"size_m": [9000, 7000]},
}
NAMES = sorted(registry.entries("world", plugins=False))


@pytest.fixture(scope="module", params=NAMES)
def made(request, tmp_path_factory):
    if request.param == "saved":
        small = build_world(world_config({"type": "flat", "size_m": [60, 60]}))
        NEEDS["saved"] = {"path": str(save(small, tmp_path_factory.mktemp("saved") / "world.npz"))}
    return request.param, build_world(world_config({"type": request.param, **NEEDS.get(request.param, {})}))


def test_it_says_what_it_is(made):
    name, _ = made
    assert world_types()[name]
    config = registry.find("world", name).config
    for field in config.model_fields:
        assert descriptions(config).get(field) or field == "type", f"{name}.{field} has no docstring"


def test_everything_in_it_has_a_label_a_material_and_an_id_of_its_own(made):
    _, world = made
    assert world.geometries
    for g in world.geometries:
        assert 0 <= g.label <= 255
        assert g.instance >= 1
        assert int(np.max(g.face_materials)) < len(world.palette)
        assert np.isfinite(g.vertices).all()
        assert g.faces.max() < len(g.vertices)
    assert world.next_instance > max(g.instance for g in world.geometries)


def test_the_same_configuration_makes_the_same_bytes(made):
    name, world = made
    again = build_world(world_config({"type": name, **NEEDS.get(name, {})}))
    for a, b in zip(world.geometries, again.geometries, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()
        assert a.faces.tobytes() == b.faces.tobytes()


def test_rays_hit_the_ground_where_the_height_says(made):
    _, world = made
    if world.terrain is None:
        return
    low, high = world.bounds
    centre = (low + high) / 2
    generator = np.random.default_rng(5)
    xy = centre[:2] + 0.3 * (high - low)[:2] * generator.uniform(-1, 1, (20, 2))
    height = world.height(xy[:, 0], xy[:, 1])
    free = np.isfinite(height)
    # from just above the ground: nothing that stands there is in the way
    start = np.column_stack([xy, height + 0.05])[free]
    hits = world.cast(start, (0.0, 0.0, -1.0), 1.0)
    extent = float(np.abs(high - low).max())
    assert hits.valid.mean() > 0.9
    assert np.abs(hits.t[hits.valid] - 0.05).max() < 1e-3 + 4e-7 * extent  # single precision about the scene's origin


def test_nothing_is_near_high_above(made):
    _, world = made
    top = world.bounds[1, 2]
    assert not world.near(np.array([[0.0, 0.0, top + 50.0]]), 1.0).any()
    x, y = world.bounds.mean(axis=0)[:2]
    bottom = float(np.ravel(world.height(x, y))[0])
    if np.isfinite(bottom):
        assert world.near(np.array([[x, y, bottom + 0.1]]), 1.0).all()


@pytest.mark.parametrize("name", sorted(KINDS))
def test_a_thing_whose_numbers_differ_in_their_last_digits_has_the_same_faces(name):
    """Sines of two processors differ in their last digit; depths, of ground in single precision, by a micrometre."""
    kind = KINDS[name]
    size, depth = 0.37 * kind.size[0] + 0.63 * kind.size[1], 13.0970204
    one, other, deeper = (
        kind.build(s, np.random.Generator(np.random.PCG64(5)), d).parts
        for s, d in ((size, depth), (np.nextafter(size, 2 * size), np.nextafter(depth, 0.0)), (size, depth + 1e-6))
    )
    for a, b, c in zip(one, other, deeper, strict=True):
        np.testing.assert_array_equal(a.model.faces, b.model.faces)
        np.testing.assert_allclose(a.model.vertices, b.model.vertices, rtol=0, atol=1e-13 * (size + depth))
        np.testing.assert_allclose(a.model.vertices, c.model.vertices, rtol=0, atol=3e-6)
