"""One sample: readings at a pose, with labels and calibration, and how each reading is encoded in files."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.datasets.pose import SampledPose
from pelagos.drawing.png import png
from pelagos.errors import InputError
from pelagos.sensors.camera.picture.annotations import Box
from pelagos.sensors.camera.picture.boxes_3d import Box3d

QUALITY: Final = 92  # of JPEG


@dataclass(frozen=True)
class Thing:
    """One object in a camera's picture.

    Attributes:
        box: in the picture.
        number: of its class, from 0.
        name: of its class.
        space: its box in space; None for what has none.
    """

    box: Box
    number: int
    name: str
    space: Box3d | None


@dataclass(frozen=True)
class Sample:
    """Readings at one pose.

    Attributes:
        index: number in the data set, from 0.
        world, split: of its shard.
        pose: of the vehicle.
        readings: arrays by sensor, as the sensors report them.
        things: objects in the camera's picture.
        about: what else is known of it, as JSON data: drawn values, calibration, validity.
        picture_format: "png" or "jpeg", of colour pictures.
    """

    index: int
    world: int
    split: str
    pose: SampledPose
    readings: Mapping[str, NDArray[Any]]
    things: Sequence[Thing]
    about: Mapping[str, Any]
    picture_format: str = "png"
    _files: dict[str, tuple[str, bytes]] = field(default_factory=dict, repr=False, compare=False)

    @property
    def key(self) -> str:
        """Its name in all formats; sorts as the index does."""
        return f"{self.index:09d}"

    def file(self, sensor: str) -> tuple[str, bytes]:
        """Extension and content of the file of a reading; encoded once for all formats."""
        if sensor not in self._files:
            self._files[sensor] = encoded(self.readings[sensor], self.picture_format, sensor)
        return self._files[sensor]

    @property
    def meta(self) -> dict[str, Any]:
        """Pose, objects and the rest as JSON data."""
        return {
            "key": self.key,
            "index": self.index,
            "world": self.world,
            "split": self.split,
            "position_m": [float(c) for c in self.pose.position],
            "attitude_wxyz": [float(c) for c in self.pose.attitude],
            "facing_instance": self.pose.facing,
            "objects": [_told(thing) for thing in self.things],
            **self.about,
        }


def encoded(values: NDArray[Any], picture_format: str, what: str) -> tuple[str, bytes]:
    """Extension and bytes: pictures of colours as PNG or JPEG, of whole numbers as PNG, everything else as NPY."""
    pixels = values.ndim == 3 and values.shape[-1] == 3
    if pixels and values.dtype == np.uint8:
        return ("jpg", _jpeg(values)) if picture_format == "jpeg" else ("png", png(values))
    if values.ndim == 2 and values.dtype == np.uint8:
        return "png", png(values)
    if values.ndim == 2 and values.dtype == np.uint32:
        if values.size and int(values.max()) > 0xFFFF:
            raise InputError(f"{what}: instance ids up to {values.max()} do not fit into a 16-bit picture")
        return "png", png(values.astype(np.uint16))
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(values), allow_pickle=False)
    return "npy", buffer.getvalue()


def _jpeg(values: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(values)).save(buffer, "JPEG", quality=QUALITY)
    return buffer.getvalue()


def as_json(data: Any) -> bytes:
    """Compact JSON in UTF-8, keys in order; numbers that are not finite are refused."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def _told(thing: Thing) -> dict[str, Any]:
    box, space = thing.box, thing.space
    told: dict[str, Any] = {
        "instance": box.instance, "class": thing.name, "class_number": thing.number, "label": box.label,
        "bbox_px": [box.column, box.row, box.width, box.height], "area_px": box.area,
    }  # fmt: skip
    if space is not None:
        told["box_3d"] = {
            "centre_m": space.centre.tolist(),
            "size_m": space.size.tolist(),
            "rotation": space.turn.tolist(),
        }
    return told
