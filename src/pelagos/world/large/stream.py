"""The part of a large ground that stands in a scene, and how it follows the vehicles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.raycast.streamed import Patch
from pelagos.world.large.ground import LargeGround
from pelagos.world.large.mesh import TileHeights, face_materials, faces, tile_heights, vertices
from pelagos.world.large.quadtree import CELLS, TRIANGLES, Tiles, leaves, reaches

DETAILS: Final = (8.0, 6.0, 5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.0)  # tried from the first on, until the tiles fit
_SNAP: Final = 0.5  # places are rounded to this part of the radius of full resolution ...
_STAY: Final = 0.4  # ... and stay while a vehicle is nearer than this part: 0.6 of the radius is always there
_SPARE: Final = 1.15  # room for more tiles than at first: how many there are depends on where the places are
_MOST: Final = 64  # places with full resolution at the same time
_ORIGIN_M: Final = 16.0  # the scene's origin is rounded to this


@dataclass(frozen=True)
class Choice:
    """Places with full resolution around them.

    Attributes:
        places: `(f, 2)` [m], no two the same, ordered.
        detail: how far full resolution goes, see `quadtree.reaches`.
        tiles: what stands in the scene.
    """

    places: NDArray[np.float64]
    detail: float
    tiles: Tiles


class Stream:
    """Follows vehicles with the tiles of a ground. A function of simulated places alone, never of time on the wall.

    Attributes:
        ground: what is streamed.
        view: what stands in the scene.
    """

    def __init__(self, ground: LargeGround) -> None:
        self.ground = ground
        self.capacity = ground.triangles // TRIANGLES
        self._details = details(ground)
        self._room = 0
        first = ground.insets[-1] if ground.insets else None
        middle = [(ground.x0 + ground.x1) / 2, (ground.y0 + ground.y1) / 2]
        if first is not None:
            middle = [(a + b) / 2 for a, b in zip(first.low, first.high, strict=True)]
        self._heights: dict[tuple[int, int, int], int] = {}
        self._stored = TileHeights(np.empty((0, CELLS + 1, CELLS + 1)), np.empty((0, 0, 0, 3), dtype=np.float32))
        self.view = self._viewed(np.array([middle]))
        self._followed: Choice | None = None
        self._patch: Patch | None = None

    @property
    def bounds(self) -> NDArray[np.float64]:
        """`(2, 2)` lowest and highest x and y [m]."""
        g = self.ground
        return np.array([[g.x0, g.y0], [g.x1, g.y1]])

    @property
    def identity(self) -> tuple[int, int, tuple[int, ...]]:
        """See `StreamedGround`."""
        return self.ground.label, self.ground.instance, self.ground.materials

    def follow(self, places: NDArray[np.float64]) -> bool:
        """Bring full resolution to vehicles at `(k, 2)` [m]; whether the patch is a new one.

        Raises:
            WorldError: there are too many places, too far from each other.
        """
        wanted = self._followed
        if wanted is None or not self._covers(wanted, places, _STAY):
            self._followed = wanted = self._viewed(places)
        return self._show(wanted)

    def peek(self, places: NDArray[np.float64]) -> bool:
        """The same for rays that somebody casts: the next `follow` is as if this had not been."""
        if self._covers(self.view, places, 2 * _STAY):
            return False
        return self._show(self._viewed(places))

    def memory(self) -> object:
        """The places that are followed, and how finely."""
        return None if self._followed is None else (self._followed.places.copy(), self._followed.detail)

    def recall(self, memory: Any) -> None:
        """Follow those places again."""
        if memory is None:
            self._followed = None
            return
        places, detail = memory
        self._followed = Choice(places, detail, leaves(self.ground, places, reaches(self.ground, detail)))

    def forget(self) -> None:
        """A run begins anew: where vehicles were before has no effect."""
        self._followed = None

    @property
    def patch(self) -> Patch:
        """The mesh of the tiles now."""
        if self._patch is None:
            self._patch = self._built()
        return self._patch

    def _show(self, wanted: Choice) -> bool:
        if wanted is self.view or (wanted.detail == self.view.detail and _same(wanted.places, self.view.places)):
            self.view = wanted
            return False
        self.view, self._patch = wanted, None
        return True

    def _radius(self, places: NDArray[np.float64], detail: float) -> NDArray[np.float64]:
        """`(k,)` how far from each place the resolution of that place goes [m]."""
        level = np.zeros(len(places), dtype=np.int64)
        for inset in self.ground.insets:
            around = 2 * detail * CELLS * self.ground.spacing_at(inset.level)
            low, high = np.array(inset.low) - around, np.array(inset.high) + around
            near = ((places >= low) & (places <= high)).all(axis=1)
            level = np.where(near, np.minimum(level, inset.level), level)
        return np.asarray(2 * detail * CELLS * self.ground.spacing * 2.0**level)

    def _covers(self, view: Choice, places: NDArray[np.float64], share: float) -> bool:
        limit = share * self._radius(places, view.detail)
        away = np.abs(places[:, None, :] - view.places[None, :, :]).max(axis=2).min(axis=1)
        return bool((away <= limit).all())

    def _viewed(self, places: NDArray[np.float64]) -> Choice:
        if not np.isfinite(places).all():
            raise WorldError("a large ground cannot follow a place that is not finite")
        inside = np.clip(places, *self.bounds)
        for detail in self._details:
            step = (_SNAP * self._radius(inside, detail))[:, None]
            snapped = np.unique(np.round(inside / step) * step, axis=0)
            if len(snapped) > _MOST:
                continue
            tiles = leaves(self.ground, snapped, reaches(self.ground, detail))
            if len(tiles) <= self.capacity:
                return Choice(snapped, detail, tiles)
        spread = np.ptp(places, axis=0)
        raise WorldError(
            f"{len(snapped)} places spread over {spread[0]:.0f} m x {spread[1]:.0f} m need more ground at full "
            f"resolution than the {self.capacity * TRIANGLES} triangles that memory_mb allows (and at most {_MOST} "
            "places can have it); raise memory_mb, or keep the agents together"
        )

    def _built(self) -> Patch:
        ground, tiles = self.ground, self.view.tiles
        heights = self._cached(tiles)
        middle = self.view.places.mean(axis=0)
        z = float(ground.surface(middle[0], middle[1]))
        origin = np.round(np.array([middle[0], middle[1], 0.0 if np.isnan(z) else z]) / _ORIGIN_M) * _ORIGIN_M
        at = vertices(ground, tiles, heights.z) - origin
        if len(tiles) > self._room:
            self._room = min(int(_SPARE * len(tiles)), self.capacity)
        spare = self._room - len(tiles)
        per = (CELLS + 1) ** 2
        return Patch(
            origin=origin,
            vertices=np.concatenate([at.astype(np.float32), np.zeros((spare * per, 3), dtype=np.float32)]),
            faces=np.concatenate([faces(tiles), np.zeros((spare * TRIANGLES, 3), dtype=np.uint32)]),
            normals=np.concatenate([heights.normals.reshape(-1, 3), np.zeros((spare * per, 3), dtype=np.float32)]),
            face_materials=np.concatenate(
                [face_materials(ground, tiles), np.zeros(spare * TRIANGLES, dtype=np.uint32)]
            ),
        )

    def _cached(self, tiles: Tiles) -> TileHeights:
        """Heights of tiles: of those that stood in the last patch they are known."""
        keys = list(zip(tiles.level.tolist(), tiles.i.tolist(), tiles.j.tolist(), strict=True))
        known = np.array([self._heights.get(key, -1) for key in keys])
        new = known < 0
        made = tile_heights(self.ground, Tiles(tiles.level[new], tiles.i[new], tiles.j[new]))
        z = np.empty((len(tiles), CELLS + 1, CELLS + 1))
        normals = np.empty((*z.shape, 3), dtype=np.float32)
        z[new], normals[new] = made.z, made.normals
        if not new.all():
            z[~new], normals[~new] = self._stored.z[known[~new]], self._stored.normals[known[~new]]
        self._heights = {key: row for row, key in enumerate(keys)}
        self._stored = TileHeights(z, normals)
        return self._stored


def details(ground: LargeGround) -> tuple[float, ...]:
    """Choice of `DETAILS` to try: none that goes farther than the least of them that reaches as far as asked."""
    far = [d for d in DETAILS if reached(ground, d) >= ground.reach]
    return DETAILS[len(far) - 1 :] if far else DETAILS


def reached(ground: LargeGround, detail: float) -> float:
    """Least reach of full resolution around a vehicle, beside insets [m]."""
    return (1 - _STAY) * 2 * detail * CELLS * ground.spacing


def _same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return a.shape == b.shape and bool((a == b).all())
