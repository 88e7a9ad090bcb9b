"""A large world as one that stands still, for maps, pictures and mesh files: fine where things are, else coarse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.raycast.geometry import Geometry
from pelagos.world.large.ground import LargeGround
from pelagos.world.large.stream import Stream
from pelagos.world.world import World

_PLACES = 12  # with full resolution in a picture, at most


def pictured(world: World) -> World:
    """The world with the tiles that stand in a scene as its ground; other worlds as they are."""
    if world.ground is None:
        return world
    stream = Stream(world.ground)
    places = _places(world, world.ground)
    while len(places):
        try:
            stream.peek(places)
            break
        except WorldError:  # too far from each other for the triangles that there are
            places = places[: len(places) // 2]
    patch = stream.patch
    drawn = (patch.faces[:, 0] != patch.faces[:, 1]) | (patch.faces[:, 1] != patch.faces[:, 2])
    rows = np.array(world.ground.materials, dtype=np.uint32)
    ground = Geometry(
        vertices=patch.vertices + patch.origin,
        faces=patch.faces[drawn],
        material=rows[patch.face_materials[drawn]],
        label=world.ground.label,
        instance=world.ground.instance,
        vertex_normals=patch.normals,
        name="seabed",
    )
    others = [g for g in world.geometries if g.instance != world.ground.instance]
    return replace(world, geometries=(ground, *others), ground=None, _live={})


def _places(world: World, ground: LargeGround) -> NDArray[np.float64]:
    """Places at which the ground should be fine: in the insets, the finest first, and where things stand."""
    found = [[(a + b) / 2 for a, b in zip(n.low, n.high, strict=True)] for n in reversed(ground.insets)]
    for g in world.geometries:
        if g.instance != ground.instance and len(g.vertices):
            middle = (g.vertices.min(axis=0) + g.vertices.max(axis=0)) / 2
            if all(np.hypot(*(middle[:2] - f)) > 50 * ground.spacing for f in found):
                found.append([float(middle[0]), float(middle[1])])
    return np.array(found[:_PLACES] or np.empty((0, 2)))
