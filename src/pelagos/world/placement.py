"""Test of free places, for start positions and spawned bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pelagos.world.world import World

_REACH = 1.0e4  # [m], how far a ray looks for the far side of a solid that might surround a place


def why_not_free(world: World, position: NDArray[np.float64], radius: float) -> str | None:
    """One sentence about the first of positions `(n, 3)` whose sphere is not free of static things, or None."""
    if not np.isfinite(position).all():
        return "a position is not finite"
    for index, place in enumerate(position):
        at = f"({place[0]:.2f}, {place[1]:.2f}, {place[2]:.2f}) m"
        which = at if len(position) == 1 else f"copy {index} at {at}"
        why = _below_ground(world, place, radius) or _in_solid(world, place, radius)
        if why:
            return f"{which} {why}"
    return None


def _below_ground(world: World, place: NDArray[np.float64], radius: float) -> str | None:
    ground = float(world.height(place[0], place[1]))
    if np.isnan(ground) or place[2] - radius > ground:
        return None
    if place[2] < ground:
        return f"lies inside the seabed, which is at z = {ground:.2f} m there"
    return f"is nearer than {radius:.2f} m to the seabed, which is at z = {ground:.2f} m there"


def _in_solid(world: World, place: NDArray[np.float64], radius: float) -> str | None:
    """Rays to all sides: a face seen from behind means inside, one nearer than the radius means touching."""
    directions = _sphere(64)
    if radius > 0:
        hits = world.cast(place, directions, radius)
        if hits.valid.any():
            nearest = int(np.argmin(hits.t))
            name = world.names.get(int(hits.instance[nearest]), "something")
            return f"is nearer than {radius:.2f} m to {name} ({hits.t[nearest]:.2f} m away)"
    # upwards only: the seabed runs through the foundations of walls, and hides their inside from rays that go down;
    # a ray may slip through a seam, but a solid around the place shows its inside to many, even where two share a face
    behind, instance = _seen_from_behind(world, place, directions[directions[:, 2] > 0.1])
    if behind.mean() > 0.25:
        values, counts = np.unique(instance[behind], return_counts=True)
        return f"lies inside {world.names.get(int(values[np.argmax(counts)]), 'something')}"
    return None


def _seen_from_behind(
    world: World, place: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.uint32]]:
    """`(m,)` whether the first static face along each ray looks away, and its instance id."""
    import drjit as dr

    from pelagos import jit
    from pelagos.raycast.caster import first_static

    scene = world._scene()
    if scene.static is None:
        return np.zeros(len(directions), dtype=bool), np.zeros(len(directions), dtype=np.uint32)
    scene.peek(place[None])
    local = jit.Array3f(*(float(c) for c in place - scene.origin))
    along = jit.Array3f(np.ascontiguousarray(directions.T, dtype=np.float32))
    t, normal, _, _ = first_static(scene.static, scene.tables, local, along, jit.Float(_REACH), smooth=False)
    behind = (t < dr.inf) & (dr.dot(normal, along) > 0)
    return behind.numpy(), world.cast(place, directions, _REACH).instance


def _sphere(count: int) -> NDArray[np.float64]:
    """`(count, 3)` unit vectors spread evenly: a Fibonacci lattice."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1)
