"""Random poses in a world: at an altitude or depth, or with an object in view, where nothing is in the way."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.datasets.config import Poses
from pelagos.errors import InputError, LookupFailed
from pelagos.math.frames import flip_quaternion_np
from pelagos.math.so3 import from_euler, rotate_np
from pelagos.sensors.camera.picture.boxes_3d import Box3d, boxes_3d
from pelagos.world.label import label_name
from pelagos.world.world import World

TRIES: Final = 300  # candidates of one pose
INNER: Final = 0.3  # a faced point lies within this share of the object's size from its middle, along each axis
GROUND: Final = frozenset(
    ("none", "landscape", "ground", "ground_grass", "ground_rock", "ground_path", "water_plane", "unlabeled", "any")
)
"""Labels of what is no object."""


@dataclass(frozen=True)
class SampledPose:
    """Pose of the vehicle.

    Attributes:
        position: `(3,)` world NWU [m].
        attitude: `(4,)` (w, x, y, z), body FLU to world NWU.
        facing: instance id of the object that it faces; None where it faces none.
    """

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    facing: int | None


class PoseSource:
    """Poses in one world.

    Args:
        keys: how they are distributed.
        world: built.
        mount: of the sensor that faces objects: place in the body FLU [m] and (w, x, y, z), sensor to body.
    """

    def __init__(self, keys: Poses, world: World, mount: tuple[Sequence[float], Sequence[float]]) -> None:
        self._keys, self._world = keys, world
        self._mount = np.array(mount[0], dtype=np.float64), np.array(mount[1], dtype=np.float64)
        corners = world.bounds[:, :2] if keys.area_m is None else np.array(keys.area_m)
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)
        if not (self._high > self._low).all():
            raise InputError("poses.area_m: this world has no ground that would tell an area; give two corners")
        self._objects = self._candidates()

    def _candidates(self) -> list[Box3d]:
        known = dict(self._world.user_labels)
        asked = set(self._keys.facing_labels)
        there = {label_name(g.label, known) for g in self._world.geometries}
        found = []
        for box in boxes_3d(self._world.geometries).values():
            name = label_name(box.label, known)
            if (name in asked) if asked else (name not in GROUND):
                found.append(box)
        if asked and not found and self._keys.facing > 0:
            raise LookupFailed("object to face", ", ".join(sorted(asked)), there - GROUND, where="poses.facing_labels")
        return sorted(found, key=lambda box: box.instance)

    def draw(self, random: np.random.Generator) -> SampledPose:
        """The pose that follows from a stream's numbers.

        Raises:
            InputError: no free place was found.
        """
        whys: Counter[str] = Counter()
        facing = bool(self._objects) and random.random() < self._keys.facing
        for _ in range(TRIES):
            attitude = self._attitude(random)
            found = self._faced(random, attitude) if facing else SampledPose(self._place(random), attitude, None)
            why = self._refused(found.position)
            if why is None:
                return found
            whys[why] += 1
        reasons = "; ".join(f"{count} x {why}" for why, count in whys.most_common(3))
        raise InputError(f"poses: none of {TRIES} places was free ({reasons}); change area, heights or clearance_m")

    def _attitude(self, random: np.random.Generator) -> NDArray[np.float64]:
        keys = self._keys
        angles = [math.radians(random.uniform(*a)) for a in (keys.roll_deg, keys.pitch_deg, keys.heading_deg)]
        return flip_quaternion_np(np.array([float(c) for c in from_euler(*angles)]))

    def _place(self, random: np.random.Generator) -> NDArray[np.float64]:
        x, y = random.uniform(self._low, self._high)
        if self._keys.depth_m is not None:
            return np.array([x, y, -random.uniform(*self._keys.depth_m)])
        return np.array([x, y, float(np.ravel(self._world.height(x, y))[0]) + random.uniform(*self._keys.altitude_m)])

    def _faced(self, random: np.random.Generator, attitude: NDArray[np.float64]) -> SampledPose:
        box = self._objects[int(random.integers(len(self._objects)))]
        point = box.centre + box.turn @ (box.size * INNER * random.uniform(-1, 1, 3))
        aside, up = np.tan(np.radians(random.uniform(-1, 1, 2) * self._keys.off_axis_deg))
        axis = np.array([1.0, aside, up])
        place, turn = self._mount
        along = _turned(attitude, _turned(turn, axis / np.linalg.norm(axis)))
        distance = random.uniform(*self._keys.distance_m)
        return SampledPose(point - distance * along - _turned(attitude, place), attitude, box.instance)

    def _refused(self, place: NDArray[np.float64]) -> str | None:
        """Reason for which nothing can be there, in a few words."""
        if not np.isfinite(place).all():
            return "no ground below"
        if place[2] > 0:
            return "above the water"
        if (place[:2] < self._low).any() or (place[:2] > self._high).any():
            return "outside the area"
        ground = float(np.ravel(self._world.height(place[0], place[1]))[0])
        if place[2] - self._keys.clearance_m < ground:  # False without a ground
            return "too near to the seabed"
        return None if self._world.inside(place, self._keys.clearance_m) is None else "too near to something"


def _turned(q: Any, v: NDArray[np.float64]) -> NDArray[np.float64]:
    turned: NDArray[np.float64] = rotate_np(np.asarray(q, dtype=np.float64)[None], v[None])[0]
    return turned
