"""Samples, labels and plans of a small data set, in every format that they are written in; runs of a sweep."""

from __future__ import annotations

import csv
import io
import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import pelagos as pl
from known import DOUBLE, SINGLE, check
from pelagos.datasets.config import load_config
from pelagos.datasets.distribution import Distribution, stream
from pelagos.datasets.factory import make_dataset
from pelagos.datasets.maker import Maker, camera_pose
from pelagos.datasets.plan import Plan, plan_of
from pelagos.datasets.sweep import axis_of, rows_of, run_sweep, sweep_of
from shown import parts, reduced

VIEW = {"width_px": 40, "height_px": 30, "orientation_deg": [3, 25, -8], "position_m": [0.2, -0.1, 0.05]}
CONFIG: dict[str, Any] = {
    "seed": 5, "worlds": 2, "samples_per_world": 3, "samples_per_shard": 2, "batch": 2, "camera": "eye",
    "labels": ["depth", "instance"], "formats": ["webdataset", "parquet", "coco", "yolo", "kitti", "mcap"],
    "split": {"train": 0.5, "test": 0.5},
    "vary": {"ocean.temperature_c": {"uniform": [4, 18]}, "agents.rov.sensors.eye.horizontal_fov_deg": {"choice": [60,
    80]}},
    "poses": {"distance_m": [1.5, 3.0], "facing": 0.8, "off_axis_deg": 10, "pitch_deg": [-15, 5]},
    "scenario": {
        "world": {"type": "generated", "size_m": [40, 30], "depth_m": 12,
                  "objects": [{"kind": "boulder", "count": 12}, {"kind": "tyre", "count": 8}]},
        "agents": {"rov": {"vehicle": "bluerov2_heavy", "sensors": {
            "eye": {"type": "semantic_camera", "rate_hz": 2, **VIEW}, "depth": {"type": "depth", "rate_hz": 10},
        }}},
    },
}  # fmt: skip


def plan(**changes: Any) -> Plan:
    return plan_of(load_config({**CONFIG, **changes}))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("set") / "one"
    make_dataset(plan(), folder)
    return folder


def test_plans() -> None:
    found: dict[str, Any] = {}
    for name, changes in (
        ("plain", {}), ("many", {"worlds": 11, "samples_per_world": 7, "split": {"train": 0.62, "val": 0.21,
         "test": 0.17}}),
        ("whole", {"worlds": 5, "samples_per_shard": None, "samples_per_world": 4}),
    ):  # fmt: skip
        p = plan(**changes)
        shards = [p.shard(k) for k in range(p.shards)]
        found |= parts(name, [[s.index, s.world, s.split, s.first, s.count, s.name] for s in shards])
        found |= parts(f"{name} values", [p.values(w) for w in range(p.config.worlds)])
        found |= parts(f"{name} rig", [p.rig.sensors, p.rig.camera, p.rig.labels, p.rig.aim])
    kinds = {
        "uniform": (2, 5),
        "log_uniform": (0.1, 30),
        "integer": (-2, 4),
        "normal": (3, 0.5),
        "choice": ("a", "b", 3),
    }
    drawn = {k: [Distribution(**{k: v}).draw(stream(7, k, n)) for n in range(9)] for k, v in kinds.items()}  # type: ignore[arg-type]
    found |= parts("drawn", drawn) | parts("ends", [list(Distribution(**{k: v}).ends()) for k, v in kinds.items()])  # type: ignore[arg-type]
    check("sets", "plans", found, DOUBLE)


def numbers_of_file(path: Path) -> list[Any]:
    """Decoded content of a file, whatever its format."""
    match path.suffix:
        case ".tar":
            with tarfile.open(path) as tar:
                return [[n, decoded(n, tar.extractfile(n).read())] for n in tar.getnames()]  # type: ignore[union-attr]
        case ".parquet":
            from pyarrow.parquet import read_table

            rows = read_table(path).to_pylist()
            return [
                {
                    k: v if not isinstance(v, dict) or "bytes" not in v else decoded(".png", v["bytes"])
                    for k, v in r.items()
                }
                for r in rows
            ]
        case ".mcap":
            return []
        case _:
            return [decoded(path.name, path.read_bytes())]


def decoded(name: str, data: bytes) -> Any:
    if name.endswith((".png", ".jpg")):
        return np.asarray(Image.open(io.BytesIO(data)))
    if name.endswith(".npy"):
        return np.load(io.BytesIO(data))
    return json.loads(data) if name.endswith("json") else data.decode()


@pytest.mark.parametrize("kind", ["webdataset", "parquet", "coco", "yolo", "kitti"])
def test_formats(kind: str, made: Path) -> None:
    found: dict[str, Any] = {}
    for path in sorted(p for p in (made / kind).rglob("*") if p.is_file()):
        found |= parts(path.relative_to(made / kind).as_posix(), numbers_of_file(path))
    check("sets", kind, found, SINGLE)


def test_recordings_and_card(made: Path) -> None:
    found: dict[str, Any] = {}
    for path in sorted((made / "mcap").rglob("*.mcap")):
        recording = pl.Recording(path)
        for topic in recording.topics():
            if recording.count(topic) and not topic.startswith("/tf"):
                raw = [np.frombuffer(recording.message(topic, k).raw, np.uint8) for k in range(recording.count(topic))]
                found[f"{path.stem} {topic}"] = [len(r) for r in raw]
        for topic in ("/rov/truth", "/rov/depth/pose"):
            messages = [recording.message(topic, k).message for k in range(recording.count(topic))]
            places = [m.pose.pose.position for m in messages]
            found[f"{path.stem} places of {topic}"] = [[p.x, p.y, p.z] for p in places]
        found |= parts(f"{path.stem} samples", json.loads(recording.attachments["samples.json"]))
    card = (made / "README.md").read_text()
    found |= parts("card", card[: card.index("pelagos ")] if "pelagos " in card else card)
    with Image.open(made / "contact_sheet.png") as sheet:
        found["sheet"] = reduced(sheet.convert("RGB"))
    check("sets", "recordings and card", found, SINGLE)


def test_samples(made: Path) -> None:
    """Sample by sample, and the readings that each came from: those of its own lane."""
    maker = Maker(plan())
    found: dict[str, Any] = {}
    for shard in (plan().shard(1), plan().shard(2)):
        for sample in maker.samples(shard):
            name = f"sample {sample.index}"
            last = maker.last_readings()
            assert all(np.array_equal(last[k].data[0], v, equal_nan=True) for k, v in sample.readings.items())
            found |= {f"{name} {k}": v for k, v in sample.readings.items()}
            at, turn = camera_pose(sample, "eye")
            found[f"{name} pose"] = [*sample.pose.position, *sample.pose.attitude, *at, *turn.ravel()]
            found |= parts(f"{name} things", [[t.number, t.name, t.box.label, t.box.instance] for t in sample.things])
            found |= parts(f"{name} about", sample.about)
    check("sets", "samples", found, SINGLE)


def test_sweeps(tmp_path: Path) -> None:
    axes = [axis_of(text) for text in ("ocean.currents.0.speed_mps=0.2,0.7", "agents.auv.start.heading_deg=10:50:2")]
    told = [axis_of(text).values for text in ("a.b=0:1:5", "a.b=[x, y]", "a.b=1,false,none_of_it", "a=2")]
    scenario = {
        "tick_rate_hz": 20, "duration_s": 3, "world": {"type": "flat", "depth_m": 30},
        "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.0, "towards_deg": 30}]},
        "agents": {"auv": {"vehicle": "bluerov2_heavy", "start": {"position_m": [1.0, -2.0], "depth_m": 5}}},
    }  # fmt: skip
    made = sweep_of(pl.load_scenario(scenario), axes, tmp_path / "s", seconds=0.5)
    records = run_sweep(made)
    for r in records:
        r.pop("state_sha256"), r.pop("sweep")
    head, rows = rows_of(records, made.axes)
    with (tmp_path / "s" / "results.csv").open() as file:
        table = [{k: v for k, v in row.items() if k != "state_sha256"} for row in csv.DictReader(file)]
    found = parts("records", records) | parts("rows", [head, rows]) | parts("table", table) | parts("axes", told)
    check("sets", "a sweep", found | parts("values", [made.values(k) for k in range(made.count)]), SINGLE)
