"""Boxes in space around objects and bodies, and COCO's annotations of several pictures, worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.sensors.camera.picture.annotations import boxes, coco
from pelagos.sensors.camera.picture.boxes_3d import box_of_body, boxes_3d
from pelagos.world.mesh import rotation


def wedge(instance: int, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Geometry:
    corners = np.array([[0.2, 0.1, -0.4], [1.7, 0.1, -0.4], [0.2, 0.9, -0.4], [0.2, 0.1, 2.6]]) + shift
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], np.uint32)
    return Geometry(corners, faces, 0, 17, instance)


def copy_of(model: Geometry, turn: np.ndarray, scale: float, offset: list[float], instance: int) -> PlacedGeometry:
    return PlacedGeometry(
        model, turn=turn, scale=scale, offset=np.array(offset), material=1, label=23, instance=instance
    )


def test_a_box_lies_along_its_models_axes_and_holds_all_parts() -> None:
    """In its own axes the corners of both parts reach from the box's one end to the other."""
    turn = rotation(0.5, -0.8, 2.1)
    both = [copy_of(wedge(9), turn, 2.5, [30.0, -7.0, -4.0], 6), copy_of(wedge(9), turn, 0.5, [33.0, -9.0, -2.0], 6)]
    plain = wedge(3, (4.0, -2.0, 1.0))
    empty = Geometry(np.zeros((0, 3)), np.zeros((0, 3), np.uint32), 0, 1, 8)
    made = boxes_3d([both[0], plain, empty, both[1]])
    assert list(made) == [6, 3]
    for instance, parts, own, label in ((6, both, turn, 23), (3, [plain], np.eye(3), 17)):
        box = made[instance]
        corners = np.concatenate([p.vertices for p in parts]) @ own
        assert (box.instance, box.label) == (instance, label)
        assert box.turn == pytest.approx(own)
        assert box.size == pytest.approx(np.ptp(corners, axis=0))
        assert box.centre @ own == pytest.approx((corners.min(axis=0) + corners.max(axis=0)) / 2)
        assert box.corners @ own == pytest.approx(
            np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * box.size + corners.min(axis=0)
        )
    mixed = boxes_3d([both[0], wedge(6)])[6]  # no common axes but the world's
    corners = np.concatenate([both[0].vertices, wedge(6).vertices])
    assert mixed.turn.tolist() == np.eye(3).tolist()
    assert mixed.corners.min(axis=0) == pytest.approx(corners.min(axis=0), abs=3.0)
    assert (mixed.corners.min(axis=0) <= corners.min(axis=0) + 1e-9).all()
    assert (mixed.corners.max(axis=0) >= corners.max(axis=0) - 1e-9).all()


def test_a_bodys_box_goes_where_it_goes() -> None:
    half = 0.5 * 1.1
    axis = np.array([2.0, -1.0, 2.0]) / 3
    attitude = np.array([np.cos(half), *(np.sin(half) * axis)])
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + np.sin(1.1) * skew + (1 - np.cos(1.1)) * skew @ skew  # Rodrigues
    position = np.array([5.0, -8.0, -3.0])
    box = box_of_body(wedge(4), position, attitude)
    assert box.turn == pytest.approx(turn)
    own = np.array([[x, y, z] for x in (0.2, 1.7) for y in (0.1, 0.9) for z in (-0.4, 2.6)])
    assert box.corners == pytest.approx(position + own @ turn.T)


def test_annotations_of_several_pictures_are_numbered_through() -> None:
    """COCO's boxes are column, row, width, height; categories are those in use, and one's own have their names."""
    first, second = np.zeros((6, 9), np.uint32), np.zeros((5, 7), np.uint32)
    first[1:3, 4:8], first[5, 0] = 12, 70_000
    second[0:4, 2], second[4, 5:7] = 70_000, 3
    labels = [np.where(p == 12, 22, np.where(p == 3, 201, np.where(p > 0, 23, 0))).astype(np.uint8)
              for p in (first, second)]  # fmt: skip
    made = coco(
        [("a.png", first, labels[0]), ("b.png", second, labels[1])], user_labels={"crate": 201}, masks=False,
        least_area=2,
    )  # fmt: skip
    keys = ("id", "image_id", "category_id", "bbox", "area", "iscrowd", "instance_id")
    assert [[a[k] for k in keys] for a in made["annotations"]] == [
        [1, 1, 22, [4, 1, 4, 2], 8, 0, 12], [2, 2, 201, [5, 4, 2, 1], 2, 0, 3], [3, 2, 23, [2, 0, 1, 4], 4, 0, 70_000],
    ]  # fmt: skip
    assert all(set(a) == set(keys) for a in made["annotations"])
    assert [(i["id"], i["file_name"], i["width"], i["height"]) for i in made["images"]] == [
        (1, "a.png", 9, 6), (2, "b.png", 7, 5),
    ]  # fmt: skip
    assert [(c["id"], c["name"], c["supercategory"]) for c in made["categories"]] == [
        (22, "pier", "marine"), (23, "buoy", "marine"), (201, "crate", "marine"),
    ]  # fmt: skip
    assert boxes(first * 0, labels[0]) == []
