"""Labels of the user's own, and boxes, through a whole simulation: cameras see what was spawned, and where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.sensors.camera.picture.annotations import boxes, coco
from pelagos.sensors.lidar.semantic_lidar import points

VIEW = {"rate_hz": 10, "width_px": 160, "height_px": 120, "horizontal_fov_deg": 80}


def scenario(**world: Any) -> dict[str, Any]:
    sensors = {
        "labels": {"type": "semantic_camera", **VIEW},
        "instances": {"type": "instance_camera", **VIEW},
        "depth": {"type": "depth_camera", "image": True, "bloom": 1.0, "white_balance": "grey_world", **VIEW},
        "lidar": {"type": "semantic_lidar", "channels": 8, "upper_fov_deg": 10, "lower_fov_deg": -10},
    }
    start = {"position_m": [0, 0, -8]}
    return {
        "world": {"type": "flat", "depth_m": 12.0, "labels": {"TestPanel": 200}, **world},
        "ocean": {"water_type": "IA"},
        "agents": {
            "rov": {"vehicle": "bluerov2", "start": start, "sensors": sensors},
            "other": {"vehicle": "remus100", "start": {"position_m": [6, 2.5, -8], "heading_deg": 60}},
        },
    }


@pytest.fixture(scope="module")
def seen() -> tuple[pl.Simulation, Any, Any]:
    sim = pl.Simulation.load(scenario())
    attitude = (np.cos(0.3), 0, 0, np.sin(0.3))
    body = sim.spawn(
        pl.Prop("box", position=(5, -1, -8), size=(0.4, 1.2, 0.8), attitude=attitude, material="white",
                label="TestPanel")
    )  # fmt: skip
    sim.set_state("rov", position=(0, 0, -8), attitude=(1, 0, 0, 0), velocity=(0, 0, 0), angular_velocity=(0, 0, 0))
    while "labels" not in (obs := sim.step()["rov"]):
        pass
    return sim, body, obs


def test_what_is_spawned_with_a_label_of_ones_own_shows_it(seen):
    _, body, obs = seen
    label, instance = obs["labels"].data[0], obs["instances"].data[0]
    assert body.geometry.label == 200
    assert (label == 200).sum() > 300
    assert np.array_equal(label == 200, instance == body.geometry.instance)
    made = coco([("a.png", instance, obs["instances"].extras["label"][0])], user_labels={"TestPanel": 200})
    assert "TestPanel" in [c["name"] for c in made["categories"]]
    assert "vehicle" in [c["name"] for c in made["categories"]]


def test_boxes_in_space_hold_what_the_picture_shows(seen):
    """Projected corners of a box enclose the object's box in the picture, to a pixel, and not by far."""
    sim, body, obs = seen
    instance = obs["instances"].data[0]
    config = sim.model.agents["rov"].sensors["instances"].config
    state = sim.state["rov"]
    space = sim.boxes_3d()
    assert space[body.geometry.instance].size == pytest.approx([0.4, 1.2, 0.8])
    assert space[body.geometry.instance].centre == pytest.approx([5, -1, -8])
    for flat in boxes(instance, obs["instances"].extras["label"][0], least_area=30):
        if flat.label not in (200, 64):
            continue
        corners = space[flat.instance].corners_seen(state.position[0], state.attitude[0], config)
        low, high = corners.min(axis=0), corners.max(axis=0)
        assert low[0] - 1 <= flat.column
        assert flat.column + flat.width - 1 <= high[0] + 1
        assert low[1] - 1 <= flat.row
        assert flat.row + flat.height - 1 <= high[1] + 1
        assert flat.width * flat.height > 0.3 * np.prod(high - low)


def test_the_lidar_lists_points_as_carla_does(seen):
    _, body, obs = seen
    reading = obs["lidar"]
    listed = points(reading.data[0], reading.extras["instance"][0], reading.extras["label"][0])
    assert listed.dtype.names == ("x", "y", "z", "CosAngle", "ObjIdx", "ObjTag", "ring")
    panel = listed[listed["ObjTag"] == 200]
    assert len(panel) > 10
    assert set(panel["ObjIdx"]) == {body.geometry.instance}
    assert (np.diff(listed["ring"].astype(int)) >= 0).all()
    assert (listed["CosAngle"] <= 1 + 1e-6).all()


def test_a_depth_camera_takes_a_picture_on_request(seen):
    _, _, obs = seen
    depth = obs["depth"]
    assert depth.extras["image"].shape == (1, 120, 160, 3)
    assert depth.extras["image"].dtype == np.uint8
    near = depth.data[0] < 6
    picture = depth.extras["image"][0].astype(float).mean(axis=-1)
    assert picture[near].mean() > picture[~near].mean() + 10  # a white panel in blue water


def test_a_depth_camera_without_a_picture_warns_of_keys_of_one():
    idle = scenario()
    idle["agents"]["rov"]["sensors"]["depth"]["image"] = False
    with pytest.warns(pl.ValidityWarning, match="image: true"):
        pl.Simulation.load(idle)


def test_labels_of_ones_own_have_free_numbers():
    with pytest.raises(pl.InputError, match=r"128 \.\. 254"):
        pl.Simulation.load(scenario(labels={"mine": 70}))


def test_things_of_a_generated_world_take_labels_too():
    world = {
        "type": "generated", "seed": 3, "size_m": [60, 60], "depth_m": 12, "labels": {"target": 140},
        "objects": [{"kind": "barrel", "count": 2, "label": "target"}, {"kind": "cable", "count": 1, "label": 150}],
    }  # fmt: skip
    sim = pl.Simulation.load({"world": world, "agents": {"a": {"vehicle": "remus100"}}})
    assert {140, 150} <= set(sim.world.labels)
    space = sim.boxes_3d()
    for geometry in sim.world.geometries:  # every corner of every thing lies in its box
        box = space[geometry.instance]
        inside = np.abs((geometry.vertices - box.centre) @ box.turn) - box.size / 2
        assert inside.max() < 1e-6
    barrel = next(b for b in space.values() if b.label == 140)
    assert max(barrel.size) < 1.5  # along its own axes, however it lies
    assert sim.world.labels[140] == "target"
