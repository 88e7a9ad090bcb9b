"""Copies of a model in the static scene: what rays see does not depend on whether they are instances."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.raycast import scene as scenes
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.world.mesh import rotation
from pelagos.world.shapes import box, sphere


def ground() -> Geometry:
    vertices = np.array([[-50.0, -50, -10], [50, -50, -10], [50, 50, -10], [-50, 50, -10]])
    return Geometry(vertices, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material=4, label=1, instance=1)


def copies(count: int) -> list[PlacedGeometry]:
    rng = np.random.default_rng(5)
    models = [
        sphere(1.0).geometry(material=0, label=0, instance=0, crease_deg=60.0),
        box((1.0, 0.6, 0.4)).geometry(material=0, label=0, instance=0),
    ]
    return [
        PlacedGeometry(
            models[k % 2],
            turn=rotation(*rng.uniform(-3, 3, 3)),
            scale=float(rng.uniform(0.5, 3.0)),
            offset=np.array([*rng.uniform(-40, 40, 2), -9.0]),
            material=k % 3,
            label=7,
            instance=2 + k,
            name="copy",
        )
        for k in range(count)
    ]


def seen(scene: scenes.Scene, smooth: bool) -> dict[str, np.ndarray]:
    x, y = np.meshgrid(np.linspace(-45, 45, 80), np.linspace(-45, 45, 80))
    n = x.size
    direction = np.tile(np.array([0.3, 0.1, -1.0]) / np.sqrt(1.1), (n, 1))
    shot = Rays(
        jit.Array3f64(np.stack([x.ravel(), y.ravel(), np.zeros(n)])),
        jit.Array3f(np.ascontiguousarray(direction.T, dtype=np.float32)),
        jit.Float(np.full(n, 100.0, np.float32)),
        jit.UInt32(np.zeros(n, np.uint32)),
        jit.UInt32(np.full(n, NO_BODY, np.uint32)),
    )

    hits = scene.compile(lambda caster, rays: caster.cast(rays, smooth=smooth))(shot)
    return {name: np.array(value) for name, value in vars(hits).items()}


@pytest.mark.parametrize("smooth", [False, True])
def test_instances_are_seen_as_the_same_meshes_one_by_one(monkeypatch: pytest.MonkeyPatch, smooth: bool) -> None:
    things = [ground(), *copies(60)]
    merged = seen(scenes.Scene(things), smooth)
    monkeypatch.setattr("pelagos.raycast.copies._MANY_COPIED", 0)
    scene = scenes.Scene(things)
    assert len(scene._copies.first) == 60
    instanced = seen(scene, smooth)
    same = merged["instance"] == instanced["instance"]
    assert same.mean() > 0.999  # a ray along a silhouette may go either way
    assert (np.isin(np.arange(2, 62), merged["instance"])).mean() > 0.8
    for name in ("label", "material", "valid"):
        assert (merged[name] == instanced[name])[same].all()
    near = same & (np.abs(merged["t"] - instanced["t"]) < 1e-4)
    assert near.mean() > 0.998
    for name in ("normal", "shading_normal"):
        assert np.abs(merged[name] - instanced[name])[:, near].max() < 2e-3
    curved = np.abs(merged["normal"] - merged["shading_normal"]).max(axis=0) > 1e-3
    assert curved.any() == smooth


def test_beside_many_instances_nothing_is_frozen_and_all_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    things = [ground(), *copies(20)]
    monkeypatch.setattr("pelagos.raycast.copies._MANY_COPIED", 0)
    frozen = seen(scenes.Scene(things), True)
    monkeypatch.setattr(scenes, "_MANY_COPIES", 10)
    plain = seen(scenes.Scene(things), True)
    for name, values in frozen.items():
        np.testing.assert_array_equal(values, plain[name])


def test_a_copy_holds_no_corners_and_gives_them_when_asked() -> None:
    copy = copies(1)[0]
    expected = copy.scale * copy.model.vertices @ copy.turn.T + copy.offset
    np.testing.assert_allclose(copy.vertices, expected, atol=1e-12)
    assert copy.faces is copy.model.faces
    assert copy.bytes_held < 200 < copy.model.bytes_held
    assert copy.vertex_normals is not None
    np.testing.assert_allclose(np.linalg.norm(copy.vertex_normals, axis=1), 1.0, atol=1e-5)
