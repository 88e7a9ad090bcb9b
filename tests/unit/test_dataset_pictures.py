"""Pictures and boxes of data sets against a reader that nobody here wrote, and against the definition."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from pelagos.drawing.png import png
from pelagos.sensors.camera.picture.annotations import boxes
from pelagos.sensors.camera.picture.camera_rays import ViewConfig, lens_tables


@pytest.mark.parametrize(
    ("kind", "shape"),
    [(np.uint8, (7, 5)), (np.uint8, (5, 1)), (np.uint16, (6, 9)), (np.uint8, (11, 13, 3)), (np.uint8, (1, 1, 3))],
)
def test_pillow_reads_the_same_pixels(kind: type, shape: tuple[int, ...]) -> None:
    picture = np.random.default_rng(3).integers(0, np.iinfo(kind).max, shape, endpoint=True).astype(kind)
    with Image.open(io.BytesIO(png(picture))) as read:
        read.load()  # checks the sums of all parts
        assert read.format == "PNG"
        assert (np.array(read) == picture).all()
    turned = np.asfortranarray(picture)
    assert png(turned) == png(picture)


def test_a_noisy_picture_is_smaller_than_by_a_general_encoder() -> None:
    ramp = np.linspace(20, 200, 320)[None, :, None] + np.zeros((240, 1, 3))
    picture = (ramp + np.random.default_rng(5).normal(0, 4, ramp.shape)).clip(0, 255).astype(np.uint8)
    usual = io.BytesIO()
    Image.fromarray(picture).save(usual, "PNG", compress_level=1)
    assert len(png(picture)) < len(usual.getvalue())


def test_boxes_are_those_of_each_object_by_itself() -> None:
    random = np.random.default_rng(11)
    ids = np.zeros((40, 56), dtype=np.uint32)
    for number in (9, 2, 70_001, 5, 3):  # some behind others
        row, column = random.integers(0, 30), random.integers(0, 40)
        ids[row : row + random.integers(1, 20), column : column + random.integers(1, 20)] = number
    ids[0, 55] = 8  # one pixel, too few
    labels = (ids % 251).astype(np.uint8)
    found = {box.instance: box for box in boxes(ids, labels, least_area=2)}
    assert list(found) == sorted(i for i in np.unique(ids) if i and (ids == i).sum() >= 2)
    for number, box in found.items():
        rows, columns = np.nonzero(ids == number)
        assert (box.row, box.column) == (rows.min(), columns.min())
        assert (box.height, box.width) == (np.ptp(rows) + 1, np.ptp(columns) + 1)
        assert (box.area, box.label) == (len(rows), number % 251)
    assert boxes(np.zeros((4, 3), dtype=np.uint32), np.zeros((4, 3), dtype=np.uint8)) == []


def test_cameras_that_look_alike_share_their_tables() -> None:
    view = ViewConfig(type="", width_px=48, height_px=32, position_m=(1, 0, 0))
    kept = lens_tables(view)
    assert lens_tables(view.model_copy(update={"rate_hz": 5.0, "position_m": (0.0, 2.0, 0.0)})) is kept
    wider = lens_tables(view.model_copy(update={"horizontal_fov_deg": 80.0}))
    assert np.abs(np.array(wider.lens.direction) - np.array(kept.lens.direction)).max() > 0.01
    assert np.array(kept.vignette(view, 1.0)).min() < np.array(kept.vignette(view, 0.5)).min() < 1
