"""The factory of data sets: the same bytes however it is run, formats that their own readers read, labels that fit."""

from __future__ import annotations

import copy
import errno
import io
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_jobs import Killed
from PIL import Image

from pelagos.datasets import factory, shard
from pelagos.datasets.config import load_config
from pelagos.datasets.distribution import Distribution, stream
from pelagos.datasets.engine import Engine, checked
from pelagos.datasets.factory import make_dataset
from pelagos.datasets.formats.webdataset import WebDataset
from pelagos.datasets.maker import Maker
from pelagos.datasets.plan import Plan, plan_of
from pelagos.errors import InputError, RecordingError, SimulationError

VIEW = {"width_px": 48, "height_px": 36, "orientation_deg": [0, 25, 0], "position_m": [0.2, -0.1, 0.05]}
CONFIG: dict[str, Any] = {
    "seed": 5,
    "worlds": 3,
    "samples_per_world": 3,
    "samples_per_shard": 2,
    "batch": 2,
    "camera": "eye",
    "labels": ["depth", "instance"],
    "formats": ["webdataset", "parquet", "coco", "yolo", "kitti", "mcap"],
    "split": {"train": 0.67, "test": 0.33},
    "vary": {
        "ocean.temperature_c": {"uniform": [4, 18]},
        "agents.rov.sensors.eye.horizontal_fov_deg": {"choice": [60, 80]},
    },
    "poses": {"distance_m": [1.5, 3.0], "facing": 0.8, "off_axis_deg": 10, "pitch_deg": [-15, 5]},
    "scenario": {
        "world": {
            "type": "generated",
            "size_m": [40, 30],
            "depth_m": 12,
            "objects": [{"kind": "boulder", "count": 12}, {"kind": "tyre", "count": 8}],
        },
        "agents": {
            "rov": {
                "vehicle": "bluerov2_heavy",
                "sensors": {
                    "eye": {"type": "semantic_camera", "rate_hz": 2, **VIEW},
                    "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 32, "range_max_m": 12},
                    "depth": {"type": "depth", "rate_hz": 10},
                },
            }
        },
    },
}  # fmt: skip


def plan(**changes: Any) -> Plan:
    return plan_of(load_config({**CONFIG, **changes}))


def tree(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("set") / "one"
    result = make_dataset(plan(), folder)
    assert (result.made, result.kept, result.left, result.samples) == (6, 0, 0, 9)
    return folder


@pytest.mark.parametrize("workers", [0, -2])
def test_a_number_of_workers_that_cannot_be(workers: int) -> None:
    with pytest.raises(InputError, match=f"--workers is a number from 1 on, not {workers}"):
        checked(workers, None)
    assert checked(1, None) == Engine(1)


def test_what_is_missing_or_cut_is_made_again_and_nothing_else(made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    shutil.copytree(made, folder)
    (folder / "shards/shard-000001.json").unlink()
    tar = folder / "webdataset" / plan().shard(4).split / "shard-000004.tar"
    tar.write_bytes(tar.read_bytes()[:1000])
    flipped = bytearray((folder / "plan.json").read_bytes())
    result = make_dataset(plan(), folder)
    assert (result.made, result.kept) == (2, 4)
    assert tree(folder) == tree(made)
    assert bytes(flipped) == (made / "plan.json").read_bytes()


def test_verify_finds_a_changed_byte_that_sizes_hide(made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    shutil.copytree(made, folder)
    picture = folder / "yolo/images" / plan().shard(2).split / "000000003.png"
    data = bytearray(picture.read_bytes())
    data[60] ^= 1
    picture.write_bytes(data)
    assert make_dataset(plan(), folder).made == 0
    assert make_dataset(plan(), folder, verify=True).made == 1
    assert tree(folder) == tree(made)


def test_several_calls_and_workers_in_any_order_write_the_same_bytes(made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    first = make_dataset(plan(), folder, only=range(1, 6, 2))
    assert (first.made, first.left, first.digest) == (3, 3, "")
    assert not (folder / "manifest.json").exists()
    second = make_dataset(plan(), folder, engine=Engine(workers=2))
    assert (second.made, second.kept) == (3, 3)
    assert tree(folder) == tree(made)


def test_another_plan_is_refused_and_says_what_differs(made: Path) -> None:
    with pytest.raises(InputError, match=r"another plan \(config.seed was 5, is 6; .*scenario.seed"):
        make_dataset(plan(seed=6), made)


def test_a_folder_of_other_things_is_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(InputError, match="something else"):
        make_dataset(plan(), tmp_path)


def test_a_full_disk_leaves_nothing_of_the_shard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add, count = WebDataset.add, 0

    def full(self: WebDataset, sample: Any) -> None:
        nonlocal count
        count += 1
        if count == 4:
            raise OSError(errno.ENOSPC, "No space left on device")
        add(self, sample)

    monkeypatch.setattr(WebDataset, "add", full)
    with pytest.raises(RecordingError, match="no room for shard-000002"):
        make_dataset(plan(formats=["webdataset"]), tmp_path / "set")
    files = tree(tmp_path / "set")
    assert not [name for name in files if "000002" in name or "staging" in name]
    assert {"shards/shard-000000.json", "shards/shard-000001.json"} <= set(files)


@pytest.mark.slow  # its library imports torch
@pytest.mark.filterwarnings("ignore")  # the library's own
def test_webdataset_reads_it(made: Path) -> None:
    webdataset = pytest.importorskip("webdataset")
    found = {}
    for path in sorted((made / "webdataset").rglob("*.tar")):
        for sample in webdataset.WebDataset(str(path), shardshuffle=False, empty_check=False).decode("rgb8"):
            found[sample["__key__"]] = sample
    assert sorted(found) == [f"{k:09d}" for k in range(9)]
    one = found["000000004"]
    assert one["sonar.npy"].shape == (16, 32)
    assert one["eye_depth.npy"].dtype == np.float32
    assert one["json"]["split"] == plan().splits[1]
    assert one["depth.npy"] == pytest.approx(-one["json"]["position_m"][2], abs=0.3)


def test_parquet_reads_it(made: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = [r for p in sorted((made / "parquet").rglob("*.parquet")) for r in parquet.read_table(p).to_pylist()]
    assert sorted(r["index"] for r in rows) == list(range(9))
    assert {len(r["sonar"]) for r in rows} == {16 * 32}
    metas = {m["index"]: m for m in samples(made)}
    for row in rows:
        assert row["position_m"] == metas[row["index"]]["position_m"]
        assert [o["bbox_px"] for o in row["objects"]] == [o["bbox_px"] for o in metas[row["index"]]["objects"]]
        assert Image.open(io.BytesIO(row["eye"]["bytes"])).size == (48, 36)


@pytest.mark.filterwarnings("ignore")  # the library's own
def test_pycocotools_reads_masks_and_boxes(made: Path) -> None:
    coco = pytest.importorskip("pycocotools.coco")
    seen = 0
    for split in ("train", "test"):
        api = coco.COCO(str(made / f"coco/annotations/instances_{split}.json"))
        for annotation in api.loadAnns(api.getAnnIds()):
            mask = api.annToMask(annotation)
            rows, columns = np.nonzero(mask)
            x, y, width, height = annotation["bbox"]
            assert (columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1) == (x, y, width, height)
            assert mask.sum() == annotation["area"] >= 12
            seen += 1
    assert seen == sum(len(m["objects"]) for m in samples(made)) > 5


def test_yolo_boxes_are_those_of_the_samples(made: Path) -> None:
    for meta in samples(made):
        text = (made / f"yolo/labels/{meta['split']}/{meta['key']}.txt").read_text()
        boxes = [[float(v) for v in line.split()] for line in text.splitlines()]
        assert len(boxes) == len(meta["objects"])
        for (number, x, y, width, height), told in zip(boxes, meta["objects"], strict=True):
            column, row, w, h = told["bbox_px"]
            assert number == told["class_number"]
            assert (x * 48 - w / 2, y * 36 - h / 2) == pytest.approx((column, row), abs=1e-3)
            assert (width * 48, height * 36) == pytest.approx((w, h), abs=1e-3)


def test_kitti_places_project_into_their_boxes(made: Path) -> None:
    """P (x, y - h/2, z) of a label's line, the middle of an object in space, lies within the object's box in the
    picture, where all of the object is in it; half a pixel of rounding at each edge."""
    checked = 0
    for meta in samples(made):
        folder = made / "kitti" / meta["split"]
        rows = dict(r.split(": ") for r in (folder / f"calib/{meta['key']}.txt").read_text().splitlines())
        projection = np.array([float(v) for v in rows["P2"].split()]).reshape(3, 4)
        for line in (folder / f"label_2/{meta['key']}.txt").read_text().splitlines():
            _, cut, _, _, *numbers = line.split()
            left, top, right, bottom, height, _, _, x, y, z, _ = (float(v) for v in numbers)
            assert z > 0
            if float(cut) == 0:
                u, v, w = projection @ (x, y - height / 2, z, 1)
                assert left - 1 <= u / w <= right + 1
                assert top - 1 <= v / w <= bottom + 1
                checked += 1
    assert checked >= 3


def test_faced_objects_are_in_the_picture(made: Path) -> None:
    """An object within 3 m and 10 deg of the axis of a lens of 60 deg or more; others may stand before one or two."""
    faced = [m for m in samples(made) if m["facing_instance"] is not None]
    seen = [m for m in faced if m["facing_instance"] in {o["instance"] for o in m["objects"]}]
    assert len(faced) >= 5
    assert len(seen) >= len(faced) - 2


def test_a_recording_has_every_sample(made: Path) -> None:
    import pelagos as pl

    for number in range(6):
        own = plan().shard(number)
        recording = pl.Recording(made / "mcap" / own.split / f"{own.name}.mcap")
        assert recording.damage == []
        assert recording.times("/rov/truth").tolist() == [k * 10**9 for k in range(own.count)]
        for topic in recording.topics():
            if topic.startswith(("/rov/sonar", "/rov/eye")):
                assert recording.count(topic) == own.count
        told = json.loads(recording.attachments["samples.json"])
        assert [m["index"] for m in told] == [own.first + k for k in range(own.count)]


def test_view_keys_that_vary_reach_the_cameras_of_labels(made: Path) -> None:
    for meta in samples(made):
        one, other = (meta["calibration"][name]["matrix"] for name in ("eye", "eye_instance"))
        assert one == other
    assert len({m["calibration"]["eye"]["matrix"][0][0] for m in samples(made)}) == len(
        {m["drawn"]["agents.rov.sensors.eye.horizontal_fov_deg"] for m in samples(made)}
    )


def test_the_card_counts_what_there_is(made: Path) -> None:
    card, metas = (made / "README.md").read_text(), samples(made)
    for split in ("train", "test"):
        own = [m for m in metas if m["split"] == split]
        worlds, objects = len({m["world"] for m in own}), sum(len(m["objects"]) for m in own)
        assert f"| {split} | {worlds} | {len(own)} | {objects} |" in card
    assert "license: cc-by-4.0" in card
    with Image.open(made / "contact_sheet.png") as sheet:
        assert sheet.size[0] > 100
    manifest = json.loads((made / "manifest.json").read_text())
    assert {name: shard.digest_of(made / name) for name in manifest["files"]} == {
        name: told["sha256"] for name, told in manifest["files"].items()
    }


def samples(folder: Path) -> list[dict[str, Any]]:
    import tarfile

    found = []
    for path in (folder / "webdataset").rglob("*.tar"):
        with tarfile.open(path) as tar:
            found += [json.loads(tar.extractfile(n).read()) for n in tar.getnames() if n.endswith(".json")]  # type: ignore[union-attr]
    return sorted(found, key=lambda meta: meta["index"])


def test_a_killed_worker_loses_and_doubles_nothing(tmp_path: Path) -> None:
    records = list(Engine(workers=2).run(Killed(tmp_path, 1), range(4)))
    assert sorted(r["index"] for r in records) == [0, 1, 2, 3]
    assert len(list(tmp_path.iterdir())) == 2


def test_work_that_kills_every_worker_ends(tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match="piece 2: 3 workers were killed"):
        list(Engine(workers=2).run(Killed(tmp_path, 99), [2, 3]))


def test_samples_of_a_batch_are_each_of_their_own_pose() -> None:
    """Arrays, validity and extras of each are those of its lane where all lanes stand there; one hears no bottom."""
    scenario = copy.deepcopy(CONFIG["scenario"])
    scenario["agents"]["rov"]["sensors"]["dvl"] = {"type": "dvl", "rate_hz": 5, "range_max_m": 3.0}
    wanted = plan(scenario=scenario, batch=3, samples_per_shard=3)
    maker, locks, seen = Maker(wanted), [], []
    for k, sample in enumerate(maker.samples(wanted.shard(0))):
        last, place = maker.last_readings(), np.tile(sample.pose.position, (3, 1))
        here = maker.simulation.observe(
            "rov", place, np.tile(sample.pose.attitude, (3, 1)), sensors=wanted.rig.sensors, episode=0
        )
        for name, reading in here.items():
            assert sample.readings[name].tobytes() == last[name].data.tobytes() == reading.data[k].tobytes()
            assert sample.about["valid"][name] == last[name].valid[0] == reading.valid[k]
        assert last["dvl"].extras["ranges"].tobytes() == here["dvl"].extras["ranges"][k].tobytes()
        assert last["dvl"].truth.tobytes() == here["dvl"].truth[k].tobytes()
        locks.append(sample.about["valid"]["dvl"])
        seen.append(sample.readings["sonar"].tobytes())
    assert len(set(seen)) == 3
    assert locks == [False, True, True]


def test_worlds_are_split_whole_and_by_share() -> None:
    big = plan(worlds=50, split={"train": 0.8, "val": 0.1, "test": 0.1})
    assert [big.splits.count(s) for s in ("train", "val", "test")] == [40, 5, 5]
    assert all(big.shard(i).split == big.splits[big.shard(i).world] for i in range(big.shards))
    assert [(big.shard(i).first, big.shard(i).count) for i in range(3)] == [(0, 2), (2, 1), (3, 2)]
    assert big.values(2) == plan().values(2)
    assert len({big.values(w)["world.seed"] for w in range(50)}) == 50


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sampels_per_world": 3}, "unknown key 'sampels_per_world' .did you mean 'samples_per_world'"),
        ({"formats": ["webdatset"]}, "'webdatset' is not allowed .did you mean 'webdataset'"),
        ({"formats": ["lerobot"]}, "format of episodes with actions: pelagos evaluate TASK --lerobot"),
        ({"formats": ["yolo", "yolo"]}, "yolo is given twice"),
        ({"split": {"train": 0.8}}, "add up to 1"),
        ({"labels": ["depth"]}, "coco and yolo and kitti hold boxes"),
        ({"sensors": ["eye", "sonnar"]}, "unknown sensor 'sonnar' .did you mean 'sonar'"),
        ({"camera": "sonar"}, "unknown camera 'sonar'"),
        ({"agent": "rof"}, "unknown agent 'rof' .did you mean 'rov'"),
        ({"classes": ["bolder"]}, "unknown label 'bolder'"),
        ({"vary": {"tick_rate_hz": {"uniform": [1, 2]}}}, "vary.tick_rate_hz: keys of 'world', 'ocean'"),
        ({"vary": {"ocean.turbidity": {"uniform": [-1, 2]}}}, "vary.ocean.turbidity.*at least 0"),
        ({"vary": {"ocean.turbidty": {"uniform": [0, 2]}}}, "unknown key 'turbidty' .did you mean 'turbidity'"),
        ({"vary": {"ocean.turbidity": {"uniform": [2, 1]}}}, "from the lowest to the highest"),
        ({"poses": {"altitude_m": [5, 1]}}, "from the lowest to the highest"),
        ({"scenario": {**CONFIG["scenario"], "world": {"type": "flat"}}}, "has no seed"),
    ],
)  # fmt: skip
def test_wrong_configurations_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        plan(**changes)


def test_a_shard_that_there_is_not(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="shards 0 to 5, not 7"):
        make_dataset(plan(), tmp_path / "set", only=range(7, 8))
    assert factory.PLAN == "plan.json"


def test_draws_are_named_and_log_uniform_has_its_median() -> None:
    """The median of log-uniform values from a to b is sqrt(a b); that of 4001 draws has a relative standard error of
    ln(b / a) / (2 sqrt(4001)) = 3.6 %."""
    one = Distribution(log_uniform=(0.1, 10.0))
    values = [one.draw(stream(3, "x", k)) for k in range(4001)]
    assert np.median(values) == pytest.approx(1.0, rel=4 * 0.036)
    assert one.draw(stream(3, "x", 7)) == values[7]
    assert Distribution(integer=(2, 2)).draw(stream(0)) == 2
