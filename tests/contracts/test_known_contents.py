"""Where all stands in worlds that have names, how landforms rise, how movers are made, what previews show."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import numpy as np
import pytest
from PIL import Image

from known import DOUBLE, EXACT, check
from pelagos.raycast.geometry import Geometry
from pelagos.world.build import build_world, world_config
from pelagos.world.classic import CLASSICS
from pelagos.world.generate.generated import TerrainConfig
from pelagos.world.generate.objects import KINDS
from pelagos.world.label import LABELS, label_color
from pelagos.world.material import MATERIALS, Material
from pelagos.world.mover import _SHAPES, MoverConfig
from pelagos.world.preview import draw_map, look_down, render, statistics

NAMED: dict[str, dict[str, Any]] = {
    **{name: {"type": "classic", "name": name, "seed": 3} for name in CLASSICS},
    "harbour": {"type": "harbour", "seed": 6, "length_m": 230.0, "width_m": 150.0, "depth_m": 11.0},
    "harbour, another": {"type": "harbour", "seed": 2, "length_m": 310.0, "width_m": 170.0, "depth_m": 17.0},
}
LANDFORMS = get_args(TerrainConfig.model_fields["kind"].annotation)


def of_a_mesh(g: Geometry) -> list[float]:
    return of_meshes([g])[0]


def of_meshes(meshes: list[Geometry]) -> list[list[float]]:
    """Of each the centroid of its surface, second moments about the world's axes, area, volume, smoothness, materials.

    All are reckoned at once: thousands of things have some hundred faces each.
    """
    counts = [len(g.faces) for g in meshes]
    first = np.cumsum([0, *counts[:-1]])
    total = lambda values: np.add.reduceat(values, first, axis=0)
    corners = np.concatenate([np.asarray(g.vertices, dtype=np.float64)[g.faces] for g in meshes])
    materials = np.concatenate([np.broadcast_to(g.face_materials, len(g.faces)) for g in meshes])
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    area = np.maximum(total(twice) / 2, 1e-12)
    middle = total((a + b + c) / 3 * twice[:, None]) / (2 * area)[:, None]
    middles = np.repeat(middle, counts, axis=0)
    away = (a + b + c) / 3 - middles
    row, column = np.triu_indices(3)
    moments = total(twice[:, None] * away[:, row] * away[:, column]) / (2 * area)[:, None]
    volume = total(np.einsum("ij,ij->i", a - middles, np.cross(b - middles, c - middles))) / 6
    bend = [0.0 if g.vertex_normals is None else float((g.vertex_normals * [1.0, 2.0, 3.0]).sum()) for g in meshes]
    made = total(materials * twice) / (2 * area)
    return np.column_stack([middle, moments, area, volume, bend, made]).tolist()


def by_label(things: list[Geometry]) -> dict[str, Any]:
    return {str(n): of_meshes([g for g in things if g.label == n]) for n in sorted({g.label for g in things})}


@pytest.mark.parametrize("name", sorted(NAMED))
def test_contents_of_worlds_with_a_name(name: str) -> None:
    check("contents", name, by_label(list(build_world(world_config(NAMED[name])).geometries)), DOUBLE)


@pytest.mark.parametrize("kind", LANDFORMS)
def test_how_landforms_rise(kind: str) -> None:
    terrain = {"kind": kind, "relief_m": 5.3, "wavelength_m": 47.0, "heading_deg": -35.0, "roughness_m": 0.0}
    x, y = np.random.default_rng(8).uniform(-70.0, 90.0, (2, 300))
    made_up = {"type": "generated", "size_m": [200, 160], "grid_m": 2.0, "depth_m": 19.0, "terrain": terrain}
    made = [build_world(world_config({**made_up, "seed": seed})) for seed in (2, 3)]
    check("contents", f"landform {kind}", {"heights": [w.height(x, y) for w in made]}, DOUBLE)


@pytest.mark.parametrize("body", sorted({*_SHAPES, *KINDS} - {"file"}))
def test_how_movers_are_made(body: str) -> None:
    flat = build_world(world_config({"type": "flat", "size_m": [60, 60]}))
    path = {"kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, -2.0, -3.5]], "speed_mps": 0.5}
    mover = MoverConfig(name="it", body=body, size_m=2.3, seed=4, path=path)
    made = of_a_mesh(mover.standing(0.7, instance=flat.next_instance, world=flat))
    check("contents", f"mover {body}", {"where": made[:3], "spread": made[3:9], "rest": made[9:]}, DOUBLE)


PICTURES: dict[str, Callable[[Any, Path], Any]] = {
    "render": lambda world, path: render(
        world, path, eye=(-14.0, -9.0, 3.0), target=(2.0, 1.0, -5.0), size=(96, 64), samples=16, exaggeration=1.4
    ),
    "render whole": lambda world, path: render(world, path, size=(96, 64), samples=16),
    "map": lambda world, path: draw_map(world, path, pixels=120),
}


@pytest.mark.parametrize("kind", sorted(PICTURES))
def test_previews(kind: str, tmp_path: Path) -> None:
    world = build_world(world_config(
        {"type": "generated", "seed": 4, "size_m": [50, 40], "grid_m": 2.0, "depth_m": 9.0,
         "terrain": {"kind": "ridges", "relief_m": 2.3, "wavelength_m": 31.0, "heading_deg": -25.0},
         "things": [{"shape": "sphere", "at_m": [3.0, 2.0, -5.0], "size_m": [4, 4, 4], "label": 140}],
         "objects": [{"kind": "barrel", "at_m": [[-4.0, 3.0]]}, {"kind": "boulder", "count": 9, "size_m": 1.5}]}
    ))  # fmt: skip
    picture = np.asarray(Image.open(PICTURES[kind](world, tmp_path / "it.png")).convert("RGB"), dtype=float)
    blocks = picture[: len(picture) // 8 * 8, : picture.shape[1] // 8 * 8]
    blocks = blocks.reshape(len(blocks) // 8, 8, -1, 8, 3).mean(axis=(1, 3))
    z, labels = look_down(world, 40)
    counted = {k: v for k, v in statistics(world).items() if isinstance(v, int | float)}
    found = {"picture": blocks, "height": z, "labels": labels, "statistics": list(counted.values())}
    check("contents", kind, found, 0.02)


def test_the_list_of_landforms_is_that_of_the_config() -> None:
    assert get_origin(TerrainConfig.model_fields["kind"].annotation) is Literal
    assert len(LANDFORMS) > 5


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_kinds_may_be_small_and_large(kind: str) -> None:
    """At 1/20 and 10 times their usual size, in a puddle and on a shelf: finite, and a closed part has a volume."""
    usual = sum(KINDS[kind].size) / 2
    for share, depth in ((0.05, 0.5), (0.05, 60.0), (10.0, 0.5), (10.0, 60.0)):
        thing = KINDS[kind].build(share * usual, np.random.default_rng(5), depth)
        assert thing.parts
        for part in thing.parts:
            assert np.isfinite(part.mesh.vertices).all()
            assert len(part.mesh.faces) > 0


def test_tables_of_materials_and_labels() -> None:
    """Every number of every material that a scenario may name, and numbers, names and colours of all labels."""
    made = list(MATERIALS.values())
    found: dict[str, Any] = {
        f.name: [getattr(m, f.name) for m in made]
        for f in fields(Material)
        if f.name not in ("name", "texture", "source")
    }
    texts = {"names": list(MATERIALS), "textures": [m.texture for m in made], "labels": list(LABELS)}
    check("contents", "materials", found | {k: "\n".join(v) for k, v in texts.items()}, EXACT)
    labels = {"numbers": [v.number for v in LABELS.values()], "colours": [v.color for v in LABELS.values()],
              "of users": [label_color(n) for n in range(128, 255, 9)]}  # fmt: skip
    check("contents", "labels", labels, EXACT)


def test_lines_across_the_ground() -> None:
    """A pipeline and a cable, and the scour that the one has dug."""
    terrain = {"kind": "slope", "relief_m": 2.0, "wavelength_m": 90.0, "heading_deg": 35.0}
    lines = [{"kind": "pipeline", "size_m": 0.7}, {"kind": "cable", "size_m": 0.3, "min_distance_m": 1.0}]
    made_up = {"type": "generated", "seed": 5, "size_m": [110, 80], "grid_m": 2.0, "depth_m": 13.0}
    world = build_world(world_config({**made_up, "terrain": terrain, "objects": lines}))
    assert world.terrain is not None
    found = by_label([g for g in world.geometries if g.name != "seabed"]) | {"ground": world.terrain.z}
    check("contents", "lines", found, DOUBLE)
