"""What a data set, its poses, formats and workers refuse, in which words, and what they leave behind."""

from __future__ import annotations

import errno
import io
import json
import math
import multiprocessing
import os
import pickle
import re
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from fake_jobs import Failing
from PIL import Image
from test_datasets import CONFIG, plan
from test_sweeps import SPEED, sweep

from pelagos.config.loader import load_scenario
from pelagos.datasets import factory, ray_engine, shard
from pelagos.datasets import sweep as sweeps
from pelagos.datasets.card import _values
from pelagos.datasets.config import Poses, load_config
from pelagos.datasets.contact_sheet import strip
from pelagos.datasets.distribution import Distribution
from pelagos.datasets.engine import THREADS, Engine, quiet_ending, serve
from pelagos.datasets.factory import make_dataset
from pelagos.datasets.formats.kitti import _line, _truncated
from pelagos.datasets.maker import Maker
from pelagos.datasets.pose import PoseSource
from pelagos.datasets.rig import Rig, rig_of
from pelagos.datasets.sample import Thing, encoded
from pelagos.datasets.shard import put
from pelagos.errors import InputError, RecordingError, SimulationError
from pelagos.sensors.camera.picture.annotations import Box
from pelagos.world.built import BuiltConfig
from pelagos.world.label import label_color

MOUNT = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
DEPTH = {"depth": {"type": "depth"}}


def scenario(agent: dict[str, Any], **others: Any) -> dict[str, Any]:
    agents = {"rov": {"vehicle": "bluerov2_heavy", **agent}, **others}
    return {"world": {"type": "flat"}, "agents": agents}


EYE = {"eye": {"type": "camera", "width_px": 48, "height_px": 36}}
TWO = scenario({"sensors": EYE}, auv={"vehicle": "remus100", "sensors": DEPTH})
GROUP = {"count": 2, "start": {"spacing_m": 3, "depth_m": 5}, "sensors": EYE}


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"scenario": scenario({})}, "agent rov: it has no sensor that has nothing to say at a pose"),
        ({"scenario": scenario({"sensors": {"hit": {"type": "collision"}}})}, "agent rov: it has no sensor that has"),
        ({"scenario": scenario({"sensors": {"hit": {"type": "collision"}, **DEPTH}}), "sensors": ["depth", "hit"]},
         "agent rov: hit has nothing to say at a pose"),
        ({"scenario": scenario({"sensors": {**EYE, "eye_depth": EYE["eye"]}}), "labels": ["depth"]},
         "rov.eye_depth: this name is that of a picture of labels; rename the sensor"),
        ({"scenario": TWO}, "agent: the scenario has 2 agents; name one in 'agent'"),
        ({"scenario": scenario(GROUP)}, "agent rov is a group of vehicles; a data set is seen by one"),
        ({"scenario": TWO, "agent": "auv", "formats": ["coco", "yolo"], "labels": ["instance"]},
         "agent auv has no camera, which coco, yolo need"),
    ],
)  # fmt: skip
def test_an_agent_that_sees_no_data_set_is_refused(keys: dict[str, Any], told: str) -> None:
    config = load_config({"formats": ["webdataset"], "labels": [], **keys})
    with pytest.raises(InputError, match=re.escape(told)):
        rig_of(config, load_scenario(keys["scenario"]))


def test_sensors_that_were_not_chosen_are_left_out() -> None:
    """Another one, and one that only a run could tell of; the agent is the one that is named."""
    built = scenario({"sensors": {**EYE, **DEPTH, "hit": {"type": "collision"}}}, auv={"vehicle": "remus100"})
    config = {"scenario": built, "formats": ["webdataset"], "labels": ["depth"], "agent": "rov"}
    every = rig_of(load_config(config), load_scenario(built))
    assert (every.agent, every.sensors, every.camera) == ("rov", ("eye", "depth", "eye_depth"), "eye")
    some = rig_of(load_config({**config, "sensors": ["eye"]}), load_scenario(built))
    assert list(some.scenario["agents"]["rov"]["sensors"]) == ["eye", "eye_depth"]


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"poses": {"altitude_m": [-0.1, 5]}}, "altitude_m lies between 0 and 100000, not [-0.1, 5.0]"),
        ({"poses": {"depth_m": [0, 12000.5]}}, "depth_m lies between 0 and 12000, not [0.0, 12000.5]"),
        ({"poses": {"distance_m": [0.04, 1]}}, "distance_m lies between 0.05 and 10000, not [0.04, 1.0]"),
        ({"poses": {"pitch_deg": [-91, 5]}}, "pitch_deg lies between -90 and 90, not [-91.0, 5.0]"),
        ({"poses": {"roll_deg": [0, 180.5]}}, "roll_deg lies between -180 and 180, not [0.0, 180.5]"),
        ({"poses": {"heading_deg": [-361, 0]}}, "heading_deg lies between -360 and 360, not [-361.0, 0.0]"),
        ({"vary": {"seed": {}}}, "give one of uniform, log_uniform, integer, normal, choice, not none"),
        ({"vary": {"seed": {"integer": [1, 2], "choice": [3]}}}, "not integer and choice"),
        ({"vary": {"seed": {"log_uniform": [0, 2]}}}, "log_uniform is for values above 0, not from 0"),
        ({"vary": {"seed": {"normal": [1, -0.5]}}}, "a standard deviation is 0 or positive, not -0.5"),
        ({"worlds": "3"}, "worlds"),
        ({"scenario": TWO, "batch": "2", "samples_per_shard": True}, "samples_per_shard"),
    ],
)
def test_values_beyond_their_range_are_refused(keys: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)):
        load_config({"scenario": TWO, **keys})


def test_limits_of_poses_and_draws_are_allowed(tmp_path: Path) -> None:
    poses = {"altitude_m": [0, 1e5], "depth_m": [0, 12000], "distance_m": [0.05, 1e4], "pitch_deg": [-90, 90],
             "roll_deg": [-180, 180], "heading_deg": [-360, 360]}  # fmt: skip
    config = load_config({"scenario": TWO, "poses": poses, "vary": {"seed": {"normal": [1, 0]}}})
    assert load_config(config) == config
    assert load_config(config, ("poses.facing=0.25", "worlds=4")).poses.facing == 0.25
    with pytest.raises(InputError, match=r"poses\.facing.*at most 1, not 1\.5"):
        load_config(config, ("poses.facing=1.5",))
    assert Distribution(log_uniform=(2.0, 2.0)).draw(np.random.default_rng(1)) == 2.0
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "set.yaml").write_text("scenario: ../mission.yaml\n")
    assert load_config(tmp_path / "sub" / "set.yaml").scenario == str(tmp_path / "mission.yaml")
    (tmp_path / "list.yaml").write_text("- scenario\n")
    with pytest.raises(InputError, match="a mapping of keys"):
        load_config(tmp_path / "list.yaml")


GROUND = BuiltConfig.model_validate({"depth_m": 20.0, "size_m": [60, 40]})
VOID = BuiltConfig.model_validate({"depth_m": None, "things": []})
CRATE = {"type": "box", "size_m": [1, 1, 1], "position_m": [5, 3, -10], "label": "crate"}


@pytest.mark.parametrize(
    ("world", "keys", "told"),
    [
        (GROUND, {"altitude_m": [20.01, 30]}, "300 x above the water"),
        (GROUND, {"altitude_m": [0.1, 0.39]}, "300 x too near to the seabed"),
        (GROUND, {"depth_m": [19.7, 25]}, "300 x too near to the seabed"),
        (VOID, {"area_m": [[0, 0], [9, 9]]}, "300 x no ground below"),
    ],
)
def test_poses_without_a_free_place_say_why(world: BuiltConfig, keys: dict[str, Any], told: str) -> None:
    source = PoseSource(Poses.model_validate({"facing": 0, **keys}), world.build(), MOUNT)
    told = f"none of 300 places was free ({told}); change area, heights or clearance_m"
    with pytest.raises(InputError, match=re.escape(told)):
        source.draw(np.random.default_rng(3))


def test_a_world_without_ground_needs_an_area() -> None:
    with pytest.raises(InputError, match=r"poses\.area_m: this world has no ground that would tell an area"):
        PoseSource(Poses(), VOID.build(), MOUNT)
    with pytest.raises(InputError, match=r"poses\.area_m"):
        PoseSource(Poses(area_m=((0, 3), (9, 3))), GROUND.build(), MOUNT)


def test_depths_are_drawn_within_an_area() -> None:
    """Corners in any order; of 200 uniform numbers, the extremes are within 4 % of the ends but for one in 3000."""
    source = PoseSource(Poses(area_m=((7, -2), (-3, 9)), depth_m=(2.0, 6.0), facing=0), VOID.build(), MOUNT)
    random = np.random.default_rng(5)
    drawn = np.array([source.draw(random).position for _ in range(200)])
    assert drawn.min(axis=0) == pytest.approx([-3, -2, -6], abs=0.45)
    assert drawn.max(axis=0) == pytest.approx([7, 9, -2], abs=0.45)
    assert ((drawn >= [-3, -2, -6]) & (drawn <= [7, 9, -2])).all()


@pytest.mark.parametrize(("values", "text"), [
    ([3, 1, 2.5], "1 to 3"), ([True, False, True], "False (1), True (2)"), ([1, "a"], "1 (1), a (1)"),
])  # fmt: skip
def test_drawn_values_are_a_range_or_counts(values: list[Any], text: str) -> None:
    assert _values(values) == text


def test_a_strip_shows_each_kind_of_picture() -> None:
    """Colours with boxes, labels in their colours, echo levels over 50 dB with range upwards; numbers and ids not."""
    labels = {"semantic": "eye_semantic", "instance": "eye_instance"}
    rig = Rig({}, "rov", ("eye", "rear", "echo", "depth"), "eye", labels)
    box = Box(label=4, instance=9, column=1, row=2, width=4, height=3, area=12)
    black = np.zeros((8, 8, 3), np.uint8)
    echo = 10.0 ** (np.array([[0.0, -25.0], [-50.0, -80.0]]) / 10)  # (beams, bins) [dB]
    readings = {
        "eye": black, "rear": black + np.uint8(9), "eye_semantic": np.full((8, 8), 4, np.uint8), "depth": np.ones(1),
        "eye_instance": np.full((8, 8), 9, np.uint32), "echo": np.kron(2.0 * echo, np.ones((4, 4))),
    }  # fmt: skip
    sample: Any = SimpleNamespace(readings=readings, things=[Thing(box, 0, "tyre", None)])
    made: Any = strip(SimpleNamespace(rig=rig), sample, 8)
    eye, rear, semantic, levels = np.split(made, 4, axis=1)
    edge = np.zeros((8, 8), bool)
    edge[2:5, 1:5] = True
    edge[3, 2:4] = False
    assert ((eye == (255, 220, 0)).all(axis=2) == edge).all()
    assert (eye[~edge] == 0).all()
    assert (rear == 9).all()
    assert (semantic == label_color(4)).all()
    assert levels[[7, 0, 7, 0], [0, 0, 7, 7], 0].tolist() == [255, 127, 0, 0]
    assert strip(SimpleNamespace(rig=rig), SimpleNamespace(readings={"depth": np.ones(1)}), 8) is None


def test_pictures_of_too_many_objects_and_jpeg() -> None:
    ids = np.array([[0, 65535]], np.uint32)
    assert np.array(Image.open(io.BytesIO(encoded(ids, "png", "a")[1]))).tolist() == [[0, 65535]]
    with pytest.raises(InputError, match="eye_instance: instance ids up to 65536 do not fit into a 16-bit picture"):
        encoded(ids + np.uint32(1), "png", "eye_instance")
    grey = np.full((16, 24, 3), (90, 100, 110), np.uint8)
    end, data = encoded(grey, "jpeg", "eye")
    with Image.open(io.BytesIO(data)) as picture:
        assert (end, picture.format, picture.size) == ("jpg", "JPEG", (24, 16))
        assert np.abs(np.array(picture).astype(int) - grey).max() <= 2
    assert encoded(np.full((4, 4), 3, np.uint8), "jpeg", "a")[0] == "png"  # labels stay exact


def test_kitti_without_a_box_in_space_and_with_one_behind_the_camera() -> None:
    """As the object development kit has unknown values: -1, -10 and -1000."""
    box = Box(label=4, instance=9, column=3, row=5, width=10, height=6, area=40)
    line = _line(Thing(box, 0, "tyre", None), np.zeros(3), np.eye(3), np.eye(3), (48, 36))
    assert line == "tyre -1 3 -10 3.00 5.00 12.00 10.00 -1 -1 -1 -1000 -1000 -1000 -10\n"
    corners = np.array([[0, 10, 0, 10.0], [0, 0, 10, 10.0], [1, 1, 1, 1.0]])
    assert _truncated(corners, np.eye(3), (5, 10)) == pytest.approx(0.5)
    assert _truncated(corners - [[0], [0], [1]], np.eye(3), (5, 10)) == -1.0


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (InputError("no such thing"), "no such thing"),
        (ZeroDivisionError("by 0"), "a worker failed: ZeroDivisionError: by 0"),
    ],
)
def test_an_error_of_a_worker_is_the_callers(error: Exception, told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, "3")
    ours, theirs = multiprocessing.Pipe()
    ours.send(0)
    ours.send(1)
    serve(pickle.dumps(Failing(error)), theirs, "2")
    assert os.environ[THREADS] == "2"
    assert ours.recv() == {"index": 0}
    answer = ours.recv()
    assert isinstance(answer, InputError if isinstance(error, InputError) else SimulationError)
    assert str(answer) == told
    ours.close()
    serve(pickle.dumps(Failing(error)), theirs, "2")  # ends with the pipe
    with pytest.raises(type(answer), match=re.escape(told)):
        list(Engine(workers=2).run(Failing(error), range(4)))
    assert not multiprocessing.active_children()


def test_an_interrupt_of_a_worker_is_the_drivers_to_answer() -> None:
    with quiet_ending():
        raise KeyboardInterrupt


@pytest.mark.parametrize("address", ["nowhere", "host:", ":6379", "host:port", "ray://host", "host:²"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    told = f"--ray {address!r}: give local, auto, HOST:PORT or ray://HOST:PORT"
    with pytest.raises(InputError, match=re.escape(told)):
        ray_engine._answers(address)


@pytest.mark.parametrize("address", ["127.0.0.1:9", "ray://127.0.0.1:9", "[::1]:9", "127.0.0.1:99999999999"])
def test_an_address_where_nobody_listens_is_refused(address: str) -> None:
    with pytest.raises(InputError, match=re.escape(f"--ray {address}: nothing answers there (")):
        ray_engine._answers(address)


def test_ray_joins_what_it_is_told_to() -> None:
    """A cluster of its own is small; another's is as it is. What it says of a failure is one line."""
    asked: list[dict[str, Any]] = []
    ray = SimpleNamespace(init=lambda **keys: asked.append(keys))
    for address in ("local", "auto"):
        ray_engine._connect(ray, address, 3)
    assert [a["address"] for a in asked] == ["local", "auto"]
    assert (asked[0]["num_cpus"], asked[0]["include_dashboard"]) == (3, False)
    assert not {"num_cpus", "include_dashboard", "object_store_memory"} & set(asked[1])
    for error, told in ((ConnectionError("not\nthere"), "not"), (RuntimeError(), "RuntimeError")):
        ray.init = lambda error=error, **_: (_ for _ in ()).throw(error)
        with pytest.raises(InputError, match=f"--ray auto: no Ray cluster could be joined: {told}$"):
            ray_engine._connect(ray, "auto", 1)


def test_a_piece_for_ray_answers_with_errors_of_the_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, "5")
    piece = ray_engine.Piece(pickle.dumps(Failing(InputError("odd"))), "1")
    assert os.environ[THREADS] == "1"
    assert piece.make(0) == {"index": 0}
    assert str(piece.make(1)) == "odd"


def test_a_file_that_cannot_be_put_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(tmp_path / "a" / "b.json", b"1")

    def refuse(*_: Any) -> None:
        raise OSError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(shard, "give_name", refuse)
    with pytest.raises(OSError, match="Permission denied"):
        put(tmp_path / "a" / "b.json", b"2")
    assert {p.name: p.read_bytes() for p in (tmp_path / "a").iterdir()} == {"b.json": b"1"}
    one: Any = SimpleNamespace(name="shard-000001")
    assert str(shard._no_file(OSError(13, "Denied"), one)) == "shard-000001: cannot be written: Denied"
    assert "no room for shard-000001" in str(shard._no_file(OSError(errno.EFBIG, "Too large"), one))


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    """Below a file; with a plan that is none, or damaged."""
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match=r"file/set: cannot be written: Not a directory"):
        make_dataset(plan(), tmp_path / "file" / "set")
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / factory.PLAN).write_text("# not JSON")
    with pytest.raises(InputError, match=r"plan\.json: not the plan of a data set; give another folder"):
        make_dataset(plan(), tmp_path / "set")


def test_what_long_dead_attempts_left_is_removed(tmp_path: Path) -> None:
    for name, age in (("old", factory.STALE_S + 60), ("new", factory.STALE_S - 60)):
        (tmp_path / factory.STAGING / name).mkdir(parents=True)
        os.utime(tmp_path / factory.STAGING / name, (0, time.time() - age))
    factory._sweep(tmp_path)
    assert [p.name for p in (tmp_path / factory.STAGING).iterdir()] == ["new"]


def test_progress_and_the_end_of_a_data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples done of all, first those that stand; a shard that goes in between, and a disk that is full at the end."""

    class Done:
        def run(self, job: Any, missing: list[int]) -> Any:
            return ({"count": job.plan.shard(i).count} for i in missing)

    seen: list[tuple[int, int]] = []
    monkeypatch.setattr(factory, "_stands", lambda folder, one, verify: one.index in (1, 4))
    with pytest.raises(RecordingError, match="set: shard-000000 was removed meanwhile; run it again"):
        make_dataset(plan(), tmp_path / "set", engine=Done(), progress=lambda *now: seen.append(now))
    assert seen == [(3, 9), (5, 9), (7, 9), (8, 9), (9, 9)]  # shards have two and one by turns

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(factory, "read_record", lambda folder, one: {"files": {}})
    monkeypatch.setattr(factory, "write_common", full)
    with pytest.raises(RecordingError, match="set: cannot be written: No space left on device; run it again to go on"):
        make_dataset(plan(), tmp_path / "set", engine=Done())


def test_a_world_without_a_free_place_is_named() -> None:
    maker = Maker(plan(poses={"altitude_m": [50, 60], "facing": 0}, labels=[], camera=None, formats=["webdataset"]))
    with pytest.raises(InputError, match=r"world 0 \(seed \d+\): poses: none of .* places was free .*above the water"):
        list(maker.samples(maker.plan.shard(0)))
    assert maker._things({}) == []


def test_a_sweep_of_too_many_or_into_something_else_is_refused(tmp_path: Path) -> None:
    many = math.isqrt(sweeps.MOST) + 1
    axes = (f"{SPEED}=0:1:{many}", f"ocean.turbidity=0:1:{many}")
    with pytest.raises(InputError, match=f"{many * many} combinations are more than {sweeps.MOST}; give fewer values"):
        sweep(tmp_path, *axes)
    (tmp_path / "note.txt").touch()
    for folder in (tmp_path, tmp_path / "note.txt"):
        with pytest.raises(InputError, match="it holds something else; give a new folder, or one of this sweep"):
            sweeps._claim(sweep(folder, f"{SPEED}=0.1"))
    (tmp_path / "s").mkdir()
    for text in ("{}", "not JSON"):
        (tmp_path / "s" / "sweep.json").write_text(text)
        with pytest.raises(RecordingError, match=r"s: cannot be used: "):
            sweeps._claim(sweep(tmp_path / "s", f"{SPEED}=0.1"))


def test_a_run_of_a_sweep_is_recorded_under_its_number_or_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = replace(sweep(tmp_path / "s", f"{SPEED}=0.1,0.2", seconds=0.05), record=True)
    made._run(1)
    assert sorted(p.name for p in (tmp_path / "s/runs").iterdir()) == ["run-00001.json", "run-00001.mcap"]
    assert json.loads(made.path(1).read_text())["values"] == {SPEED: 0.2}

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(sweeps, "put", full)
    with pytest.raises(RecordingError, match=r"run-00000\.json: cannot be written: No space left on device"):
        made._run(0)

    def cut(*_: Any, **__: Any) -> None:
        raise RecordingError("the recording was cut")

    monkeypatch.setattr("pelagos.sim.simulation.Simulation.run", cut)
    with pytest.raises(RecordingError, match="the recording was cut"):
        made._run(0)


def test_the_configuration_of_a_set_is_what_its_plan_says() -> None:
    assert load_config(load_config(CONFIG)) == load_config(CONFIG)
