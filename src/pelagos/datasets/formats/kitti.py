"""KITTI: a picture, a calibration and a text file of objects for each sample.

Format: A. Geiger, P. Lenz and R. Urtasun 2012, doi 10.1109/CVPR.2012.6248074, and the object development kit's
`readme.txt`. Coordinates are the camera's: x right, y down, z forward; an object's place is the middle of its lower
face, its length lies along its own x axis, and `rotation_y` is the turn of that axis about y. The format knows boxes
that stand upright for the camera alone: where camera or object are tilted, `rotation_y` is that of the axis in the
camera's x-z plane, and the place is the middle of the box, moved by half its height along y.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.datasets.maker import camera_pose
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, Thing

OPTICAL: Final = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], dtype=np.float64)
"""Sensor frame (forward, left, up) to the camera's (right, down, forward)."""
UNKNOWN: Final = 3  # of occlusion


class Kitti:
    """`kitti/SPLIT/image_2/KEY.png`, `label_2/KEY.txt` and `calib/KEY.txt`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        parts = ("image_2", "label_2", "calib")
        self._pictures, self._labels, self._calib = (folder / "kitti" / shard.split / part for part in parts)
        for part in (self._pictures, self._labels, self._calib):
            part.mkdir(parents=True, exist_ok=True)
        assert plan.rig.camera is not None
        self._camera = plan.rig.camera

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        extension, data = sample.file(self._camera)
        (self._pictures / f"{sample.key}.{extension}").write_bytes(data)
        matrix = np.array(sample.about["calibration"][self._camera]["matrix"])
        (self._calib / f"{sample.key}.txt").write_text(_calibration(matrix))
        place, turn = camera_pose(sample, self._camera)
        height, width = sample.readings[self._camera].shape[:2]
        lines = [_line(thing, place, turn, matrix, (width, height)) for thing in sample.things]
        (self._labels / f"{sample.key}.txt").write_text("".join(lines))

    def close(self) -> None:
        """Every file is whole already."""


def _line(
    thing: Thing, place: NDArray[np.float64], turn: NDArray[np.float64], matrix: NDArray[np.float64],
    size: tuple[int, int],
) -> str:  # fmt: skip
    box = thing.box
    edges = box.column, box.row, box.column + box.width - 1, box.row + box.height - 1
    seen = " ".join(f"{edge:.2f}" for edge in edges)
    if thing.space is None:
        return f"{thing.name} -1 {UNKNOWN} -10 {seen} -1 -1 -1 -1000 -1000 -1000 -10\n"
    length, width, height = thing.space.size
    to_camera = OPTICAL @ turn.T
    centre = to_camera @ (thing.space.centre - place)
    axis = to_camera @ thing.space.turn[:, 0]
    about_y = math.atan2(-axis[2], axis[0])
    alpha = _wrapped(about_y - math.atan2(centre[0], centre[2]))
    x, y, z = centre[0], centre[1] + height / 2, centre[2]
    cut = _truncated(to_camera @ (thing.space.corners - place).T, matrix, size)
    return (
        f"{thing.name} {cut:.2f} {UNKNOWN} {alpha:.4f} {seen} {height:.3f} {width:.3f} {length:.3f} "
        f"{x:.3f} {y:.3f} {z:.3f} {about_y:.4f}\n"
    )


def _truncated(corners: NDArray[np.float64], matrix: NDArray[np.float64], size: tuple[int, int]) -> float:
    """Share of the projected box `(3, 8)` outside the picture; -1 where a corner lies behind the camera."""
    if (corners[2] <= 0).any():
        return -1.0
    pixels = (matrix @ (corners / corners[2]))[:2]
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    inside = np.maximum(np.minimum(high, size) - np.maximum(low, 0), 0)
    return float(1 - inside.prod() / max((high - low).prod(), 1e-9))


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi


def _calibration(matrix: NDArray[np.float64]) -> str:
    projection = np.hstack([matrix, np.zeros((3, 1))])
    rows = {f"P{k}": projection for k in range(4)}
    rows |= {"R0_rect": np.eye(3)}
    rows |= {name: np.hstack([OPTICAL, np.zeros((3, 1))]) for name in ("Tr_velo_to_cam", "Tr_imu_to_velo")}
    rows["Tr_imu_to_velo"] = np.eye(3, 4)
    return "".join(f"{name}: {' '.join(f'{v:.12e}' for v in values.ravel())}\n" for name, values in rows.items())


FORMAT = Kitti
