"""The page of a world: its map, its views, what it is made of."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pelagos.report.page import Section, Tile, image, page, photographs, table, two_columns
from pelagos.world.label import label_color
from pelagos.world.sheet import summary
from pelagos.world.world import World


def world_page(
    world: World, stats: Mapping[str, Any], map_png: Path, views: Sequence[tuple[str, Path]], *, title: str
) -> str:
    """The whole document.

    Args:
        world: the world.
        stats: of `preview.statistics`, with `generation_s` and `peak_memory_mb` where they were measured.
        map_png: the map.
        views: caption and picture of each.
        title: of the page.
    """
    objects = [[name, str(count)] for name, count in stats["objects"].items()]
    labels = [[str(number), name, "#{:02x}{:02x}{:02x}".format(*label_color(number))]
              for name, number in stats["labels"].items()]  # fmt: skip
    kinds = two_columns(
        table(["object", "count"], objects, numbers=(1,)),
        table(["label", "meaning", "colour"], labels, numbers=(0,), code=(2,)),
    )
    sections = [Section("Map", "Heights and labels, from above.", image(_inline(map_png), "map of the world"))]
    if views:
        photos = photographs([(_inline(file), caption) for caption, file in views])
        sections.append(Section("Views", "In air and daylight, as if the water were drained.", photos))
    sections.append(Section("What it is made of", "", kinds))
    sections.append(Section("Numbers", "", table(["what", ""], [list(row) for row in summary(stats)])))
    if world.notes:
        sections.append(Section("Notes of its builder", "", table(["note"], [[n] for n in world.notes])))
    return page(
        title=title[:1].upper() + title[1:],
        kind="world",
        text=world.description or world.name,
        tiles=_tiles(stats),
        sections=sections,
        foot="Made by pelagos world.",
    )


def _tiles(stats: Mapping[str, Any]) -> list[Tile]:
    ground = stats["ground_z_m"]
    tiles = [
        Tile(f"{stats['area_m2'] / 1e4:.4g}", "ha", "area"),
        Tile(f"{-ground[2]:.1f} .. {-ground[0]:.1f}", "m", "depth"),
        Tile(f"{sum(stats['objects'].values()):,}", "", "objects"),
        Tile(f"{stats['triangles']:,}", "", "triangles"),
        Tile(f"{stats['mesh_mb']:.0f}", "MB", "meshes"),
    ]
    if "generation_s" in stats:
        tiles.append(Tile(f"{stats['generation_s']:.1f}", "s", "generated in"))
    return tiles


def _inline(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")
