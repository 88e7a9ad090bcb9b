"""Pictures and boxes of data sets against a reader that nobody here wrote, and against the definition."""

from __future__ import annotations

import io
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pelagos.datasets.contact_sheet import contact_sheet
from pelagos.datasets.formats.coco import merged, part_of
from pelagos.datasets.plan import Shard
from pelagos.datasets.pose import SampledPose
from pelagos.datasets.rig import Rig
from pelagos.datasets.sample import Sample, Thing
from pelagos.drawing.png import png
from pelagos.sensors.camera.picture.annotations import Box, boxes
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


@pytest.mark.parametrize("count", [3, 24, 31, 60])
def test_a_contact_sheet_shows_the_whole_set(count: int, tmp_path: Path) -> None:
    """24 pictures at most, from the first on, in order, and with gaps that differ by one at most."""
    paths = [tmp_path / f"{k}.png" for k in range(count)]
    for k, path in enumerate(paths):
        path.write_bytes(png(np.full((2, 3, 3), (4 * k, 255 - 3 * k, 7), dtype=np.uint8)))
    made = contact_sheet(paths)
    assert made is not None
    with Image.open(io.BytesIO(made)) as sheet:
        inside = np.array(sheet)[5::6, 5::7].reshape(-1, 3).astype(int)  # tiles of 2 by 3 pixels, 4 between them
    shown = inside[inside[:, 2] == 7]
    steps = np.diff([*shown[:, 0] // 4, count])
    assert len(shown) == min(count, 24)
    assert shown[0].tolist() == [0, 255, 7]
    assert set(steps) <= {count // len(shown), -(-count // len(shown))}
    assert contact_sheet([]) is None


def test_annotations_of_all_shards_have_numbers_of_their_own(tmp_path: Path) -> None:
    shards: list[Any] = [SimpleNamespace(name=f"shard-{k}") for k in (4, 2, 7, 9)]
    for shard, count in zip(shards, (2, 0, 3, 1), strict=True):
        part = {"images": [{"id": 10 + count}], "annotations": [{"image_id": 10 + count, "area": count}] * count}
        (tmp_path / part_of(shard)).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / part_of(shard)).write_text(json.dumps(part))
    told = json.loads(merged(tmp_path, shards, {40: (1, "tyre"), 13: (0, "boulder")}))
    assert [a["id"] for a in told["annotations"]] == [1, 2, 3, 4, 5, 6]
    assert [a["image_id"] for a in told["annotations"]] == [12, 12, 13, 13, 13, 11]
    assert [i["id"] for i in told["images"]] == [12, 10, 13, 11]
    assert [(c["id"], c["name"]) for c in told["categories"]] == [(1, "boulder"), (2, "tyre")]


def test_cameras_of_labels_follow_their_cameras_view_and_nothing_else() -> None:
    labels = {"depth": "eye_depth", "instance": "eye_instance"}
    rig = Rig({}, "rov", ("eye", "sonar", *labels.values()), "eye", labels)
    view = {"position_m.2": -0.3, "orientation_deg.0": 4.0, "horizontal_fov_deg": 75.0}
    own = {f"agents.rov.sensors.eye.{key}": value for key, value in view.items()}
    others: dict[str, Any] = {
        "agents.rov.sensors.eye.exposure_s": 0.02, "agents.rov.sensors.sonar.position_m.2": 0.1,
        "agents.rox.sensors.eye.position_m.2": 0.7, "agents.rov.sensors.eyes.width_px": 9, "ocean.turbidity": 3.0,
        "width_px": 5,
    }  # fmt: skip
    same = {f"agents.rov.sensors.{name}.{key}": value for name in labels.values() for key, value in view.items()}
    assert rig.follow({**own, **others}) == {**own, **others, **same}


@pytest.mark.parametrize(
    "changes",
    [
        {"width_px": 49},
        {"height_px": 33},
        {"horizontal_fov_deg": 71.0},
        {"lens": "fisheye"},
        {"distortion": (-0.1, 0.02, 0.001, -0.002, 0.0)},
        {"port": {"type": "flat", "distance_m": 0.04}},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_cameras_of_other_lenses_have_rays_of_their_own(changes: dict[str, Any]) -> None:
    view = ViewConfig(type="", width_px=48, height_px=32)
    kept, other = lens_tables(view), lens_tables(ViewConfig.model_validate({**view.model_dump(), **changes}))
    rows = [np.array(tables.lens.direction) for tables in (kept, other)]
    assert rows[0].shape != rows[1].shape or np.abs(rows[0] - rows[1]).max() > 1e-3


def test_rows_of_a_table_come_in_groups_and_each_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Five samples in groups of two; what is true or false is kept as whole numbers, a picture as its file."""
    pq = pytest.importorskip("pyarrow.parquet")
    from pelagos.datasets.formats import parquet

    monkeypatch.setattr(parquet, "ROWS", 2)
    rng = np.random.default_rng(3)
    plan: Any = SimpleNamespace(versions={"pelagos": "1"}, digest="d", config=SimpleNamespace(seed=9))
    shard = Shard(index=4, world=2, split="val", first=7, count=5)
    writer = parquet.Parquet(tmp_path, plan, shard, None)
    samples = []
    for k in range(5):
        box = Box(label=4, instance=9 + k, column=1, row=2, width=4 + k, height=3, area=12 - k)
        readings = {"hit": np.array([k % 2 == 1]), "range": rng.normal(size=3), "count": np.array(k + 0.5),
                    "eye": rng.integers(0, 256, (4, 5, 3), dtype=np.uint8)}  # fmt: skip
        pose = SampledPose(rng.normal(size=3), rng.normal(size=4), None)
        samples.append(Sample(7 + k, 2, "val", pose, readings, [Thing(box, k, "tyre", None)] * (k % 3), {"k": k}))
        writer.add(samples[-1])
    writer.close()
    file = pq.ParquetFile(tmp_path / "parquet" / "val" / "shard-000004.parquet")
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == [2, 2, 1]
    assert file.schema_arrow.metadata[b"pelagos.seed"] == b"9"
    found = file.read()
    assert str(found.schema.field("hit").type.value_type) == "uint8"
    assert found["index"].to_pylist() == [7, 8, 9, 10, 11]
    for row, sample in zip(found.to_pylist(), samples, strict=True):
        assert (row["key"], row["world"], row["split"]) == (f"{sample.index:09d}", 2, "val")
        assert row["position_m"] == sample.pose.position.tolist()
        assert row["attitude_wxyz"] == sample.pose.attitude.tolist()
        assert [row["hit"], row["count"]] == [[int(sample.readings["hit"][0])], [float(sample.readings["count"])]]
        assert row["range"] == sample.readings["range"].tolist()
        with Image.open(io.BytesIO(row["eye"]["bytes"])) as picture:
            np.testing.assert_array_equal(np.array(picture), sample.readings["eye"])
        assert row["eye"]["path"] == f"{sample.key}.png"
        k = sample.index - 7
        told = {"instance": 9 + k, "class": "tyre", "class_number": k, "area_px": 12 - k, "bbox_px": [1, 2, 4 + k, 3]}
        assert row["objects"] == [told] * (k % 3)
        assert json.loads(row["about"]) == {"k": k}
