"""Tiles as one mesh without cracks.

Nodes of two tiles at the same place have the same coordinates to the last bit, because heights are a function of place
alone. On a side that borders a coarser tile, every odd node of the edge is moved onto the even one before it: the
triangles on that side then have the coarser tile's edges, and those that lost their width have no area.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pelagos.world.large.ground import LargeGround
from pelagos.world.large.quadtree import CELLS, TRIANGLES, Tiles, coarser_sides
from pelagos.world.terrain import HeightField

NODES = CELLS + 1


@dataclass(frozen=True)
class TileHeights:
    """Heights computed of each tile.

    Attributes:
        z: `(t, NODES, NODES)` float64 [m].
        normals: `(t, NODES, NODES, 3)` float32, unit.
    """

    z: NDArray[np.float64]
    normals: NDArray[np.float32]


def tile_heights(ground: LargeGround, tiles: Tiles) -> TileHeights:
    """Heights and normals of tiles, level by level."""
    z = np.empty((len(tiles), NODES, NODES))
    normals = np.empty((len(tiles), NODES, NODES, 3), dtype=np.float32)
    around = np.arange(-1, NODES + 1)
    for level in np.unique(tiles.level).tolist():
        rows = np.flatnonzero(tiles.level == level)
        i = tiles.i[rows, None, None] * CELLS + around[:, None]
        j = tiles.j[rows, None, None] * CELLS + around[None, :]
        i, j = np.broadcast_arrays(i, j)
        wide = ground.nodes(level, i, j)
        z[rows] = wide[:, 1:-1, 1:-1]
        step = 2 * ground.spacing_at(level)
        n = np.ones((*z[rows].shape, 3))
        n[..., 0] = (wide[:, :-2, 1:-1] - wide[:, 2:, 1:-1]) / step
        n[..., 1] = (wide[:, 1:-1, :-2] - wide[:, 1:-1, 2:]) / step
        normals[rows] = n / np.sqrt((n * n).sum(axis=-1, keepdims=True))
    return TileHeights(z, normals)


def vertices(ground: LargeGround, tiles: Tiles, z: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(t NODES NODES, 3)` places of the nodes, world [m]."""
    out = np.empty((*z.shape, 3))
    step = (ground.spacing * 2.0**tiles.level)[:, None]
    along = np.arange(NODES)
    out[..., 0] = np.clip(ground.x0 + (tiles.i[:, None] * CELLS + along) * step, ground.x0, ground.x1)[:, :, None]
    out[..., 1] = np.clip(ground.y0 + (tiles.j[:, None] * CELLS + along) * step, ground.y0, ground.y1)[:, None, :]
    out[..., 2] = z
    return out.reshape(-1, 3)


def faces(tiles: Tiles) -> NDArray[np.uint32]:
    """`(t TRIANGLES, 3)` faces of the nodes; two for each cell, split as `HeightField` does."""
    first = np.arange(len(tiles), dtype=np.uint32)[:, None, None] * np.uint32(NODES * NODES)
    return (_patterns()[coarser_sides(tiles)] + first).reshape(-1, 3)


def face_materials(ground: LargeGround, tiles: Tiles) -> NDArray[np.uint32]:
    """`(t TRIANGLES,)` rows of the ground's materials: an inset's where the middle of the cell lies in it."""
    rows = np.zeros((len(tiles), CELLS, CELLS), dtype=np.uint32)
    if len(ground.materials) > 1:
        step = (ground.spacing * 2.0**tiles.level)[:, None]
        middle = np.arange(CELLS) + 0.5
        x = (ground.x0 + (tiles.i[:, None] * CELLS + middle) * step)[:, :, None]
        y = (ground.y0 + (tiles.j[:, None] * CELLS + middle) * step)[:, None, :]
        for inset in ground.insets:
            rows[inset.holds(x, y)] = inset.material
    return np.repeat(rows.reshape(-1), TRIANGLES // CELLS**2)


@cache
def _patterns() -> NDArray[np.uint32]:
    """`(16, TRIANGLES, 3)` faces of a tile, by the sides that border coarser tiles."""
    plain = HeightField(0.0, 0.0, 1.0, np.zeros((NODES, NODES))).faces()
    node = np.arange(NODES * NODES, dtype=np.uint32).reshape(NODES, NODES)
    found = []
    for bits in range(16):
        moved = node.copy()
        for bit, edge in enumerate((moved[0, :], moved[-1, :], moved[:, 0], moved[:, -1])):
            if bits >> bit & 1:
                edge[1::2] = edge[0:-1:2]
        found.append(moved.reshape(-1)[plain])
    return np.stack(found)
