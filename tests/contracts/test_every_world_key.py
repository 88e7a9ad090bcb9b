"""No number of a world is accepted that is then ignored, and every sign is heard.

Each kind of world is built small, with its keys away from 0 and from their defaults, things, a mover and objects in
it; then one number after another moves a little and far, and changes its sign where it may have one. What is built must
differ: a vertex, a material, a label, the place on Earth, or the way of a mover.
"""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from known import check, flat
from pelagos.config import registry
from pelagos.errors import PelagosError
from pelagos.world.build import build_world, world_config

THING = {
    "shape": "box", "at_m": [4.0, -7.0, -3.0], "orientation_deg": [11.0, -8.0, 25.0], "size_m": [2.0, 1.1, 0.7],
    "label": 140, "repeat": 2, "step_m": [1.3, -2.1, 0.4],
}  # fmt: skip
MOVER = {
    "name": "drum", "body": "cylinder", "size_m": 1.3,
    "path": {"kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, -2.0, -3.5]], "speed_mps": 0.5},
}  # fmt: skip
PLACE = {"latitude_deg": -33.0, "longitude_deg": 18.0}
COMMON = {**PLACE, "things": [THING], "movers": [MOVER]}
WORLDS: dict[str, dict[str, Any]] = {
    "flat": {"type": "flat", "depth_m": 12.0, "size_m": [60.0, 45.0], **COMMON},
    "built": {"type": "built", "depth_m": 12.0, "size_m": [60.0, 45.0], **COMMON},
    "generated": {
        "type": "generated", "seed": 4, "size_m": [64.0, 48.0], "grid_m": 2.0, "depth_m": 14.0, "patch_m": 21.0,
        "patches": ["gravel"],
        "terrain": {
            "kind": "ridges", "relief_m": 2.3, "wavelength_m": 31.0, "heading_deg": -25.0, "roughness_m": 0.2,
            "spectrum_slope": 2.7, "ripple_m": 0.1, "ripple_wavelength_m": 7.0,
        },
        "grades": [{"at_m": [9.0, -6.0], "radius_m": 8.0, "depth_m": 9.0, "relief": 0.3, "blend_m": 6.0}],
        "objects": [
            {"kind": "boulder", "count": 25, "size_m": 0.8, "cluster": 0.5, "cluster_radius_m": 6.0,
             "min_distance_m": 1.5, "max_slope_deg": 9.0, "heading_deg": -25.0},
        ],
        "exclude": [{"at_m": [-5.0, 7.0], "radius_m": 16.0}],
        **PLACE,
    },
    "large": {
        "type": "large", "size_m": [1200.0, 800.0], "resolution_m": 20.0,
        "ground": {
            "kind": "fractal", "seed": 3, "mean_depth_m": 60.0, "relief_m": 9.0, "longest_m": 500.0,
            "spectral_slope": 2.9, "gradient": [0.01, -0.02],
        },
        "insets": [{"centre_m": [40.0, -60.0], "size_m": [120.0, 90.0], "resolution_m": 5.0, "relief_m": 0.8,
                    "spectral_slope": 2.6, "blend_m": 17.0}],
    },
}  # fmt: skip
DEAF: dict[str, str] = {}
"""Numbers that nothing hears, and why."""


def built(config: dict[str, Any]) -> list[Any] | None:
    """Numbers of what was built; None if the configuration is refused."""
    try:
        world = build_world(world_config(config))
    except (PelagosError, ValidationError):
        return None
    found: list[Any] = [np.array([world.origin.latitude, world.origin.longitude, *world.bounds.ravel()])]
    for g in world.geometries:
        found += [g.vertices, g.face_materials, [g.label]]
    low, high = world.bounds[:, :2]
    x, y = np.random.default_rng(3).uniform(low, high, (200, 2)).T
    found.append(world.height(x, y))
    for mover in world.movers:
        for t in (0.7, 2.9):
            found.append(mover.standing(t, instance=world.next_instance, world=world).vertices)
    return found


def digest(found: list[Any] | None) -> bytes | None:
    """Of what was built, if it was."""
    if found is None:
        return None
    told = hashlib.blake2b(digest_size=8)
    for values in found:
        told.update(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return told.digest()


def moved(value: Any, at: str = "") -> Iterator[tuple[str, str, Any]]:
    """Each number of a nest with another in its place: `(path, "value", "double" or "sign", the whole nest)`."""
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            for path, what, other in moved(value[key], f"{at}.{key}" if at else str(key)):
                whole = copy.copy(value)
                whole[key] = other
                yield path, what, whole
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield at, "value", value + 1 if isinstance(value, int) else 1.13 * value
        yield at, "double", 2 * value
        yield at, "sign", -value


@pytest.mark.parametrize("kind", sorted(WORLDS))
def test_every_number_and_every_sign_of_a_world_is_heard_as_known(kind: str) -> None:
    made = built(WORLDS[kind])
    assert made is not None
    plain, numbers = digest(made), {"": flat(made)}
    heard: dict[str, bool] = {}
    for at, what, other in moved(WORLDS[kind]):
        name = f"{kind}.{at}"
        if what == "double" and heard[name]:
            continue
        made = built(other)
        found = digest(made)
        if what == "value" and made is not None:
            numbers[at] = flat(made)
        if what == "sign":
            heard[f"{name} (sign)"] = found != plain  # or refused
        else:
            heard[name] = heard.get(name, False) or found not in (None, plain)
    check("keys_of_worlds", kind, numbers)
    deaf = sorted(name for name, is_heard in heard.items() if not is_heard)
    assert deaf == sorted(name for name in DEAF if name.startswith(f"{kind}."))


@pytest.mark.parametrize("kind", sorted(WORLDS))
def test_every_number_of_a_world_is_tried(kind: str) -> None:
    """Keys with a number as their default that the worlds above leave as they are."""
    fields = registry.find("world", kind).config.model_fields
    left = {k for k, info in fields.items() if isinstance(info.default, int | float) and k not in WORLDS[kind]}
    assert left <= {"memory_mb"}
