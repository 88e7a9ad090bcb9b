"""Legend of the numbers in readings: labels, instance ids and materials of a world, for people and other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pelagos.raycast.geometry import Geometry
from pelagos.world.label import label_color, label_name
from pelagos.world.world import World


def legend(world: World, moving: Sequence[Geometry] = ()) -> dict[str, Any]:
    """Names and colours of labels, names of instances, names of materials, and the origin, as JSON data.

    Args:
        world: whose static things are named.
        moving: what stands in the moving scene, with instance ids of its own; it may be of any material.
    """
    user: Mapping[str, int] = dict(world.user_labels)
    things = [*world.geometries, *moving]
    labels = sorted({g.label for g in things} | set(user.values()))
    still = {id(g) for g in world.still}
    return {
        "labels": {str(n): {"name": label_name(n, dict(user)), "color": label_color(n)} for n in labels},
        "instances": {str(g.instance): {"name": g.name, "label": g.label, "moves": id(g) not in still} for g in things},
        "materials": [m.name for m in (world.palette if moving else world.materials)],
        "origin": {"latitude_deg": world.origin.latitude, "longitude_deg": world.origin.longitude},
    }
