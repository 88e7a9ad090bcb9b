"""Looks at given poses, and changes of sensors, ocean and world while a run stands."""

from __future__ import annotations

import copy
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos.ocean.config import OceanConfig, build_ocean

SCENARIO: dict[str, Any] = {
    "seed": 2,
    "tick_rate_hz": 100,
    "world": {"type": "flat", "depth_m": 20.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "control": "actuators",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "heading_deg": 30.0},
            "sensors": {
                "altimeter": {"type": "altimeter", "rate_hz": 10},
                "depth": {"type": "depth", "rate_hz": 10},
                "dvl": {"type": "dvl", "rate_hz": 10, "water_layer_m": 3.0},
                "meter": {"type": "current_meter", "rate_hz": 10},
            },
        }
    },
}
CAMERA: dict[str, Any] = {
    "type": "camera",
    "rate_hz": 10,
    "width_px": 32,
    "height_px": 24,
    "orientation_deg": [0, 90, 0],
    "lamps": [{"position_m": [0.3, 0, 0], "orientation_deg": [0, 90, 0], "flux_lm": 1000}],
    "exposure": "manual",
    "shutter_s": 0.03,
    "iso": 800,
}


@pytest.fixture(scope="module")
def loaded() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO, n=2)


def memory(sim: pl.Simulation) -> bytes:
    run = sim.stepper.memory()["runs"]["auv0"]
    return run["vehicle"].tobytes() + run["row"].tobytes()


def test_looks_at_poses_are_what_the_vehicle_would_read_there_and_change_nothing(loaded):
    """Altitude of a pitched altimeter over flat ground by trigonometry; depth; and the bytes of a run that goes on."""
    loaded.reset()
    loaded.step(ticks=3)
    kept = loaded.checkpoint()
    before = memory(loaded)
    places = np.array([(0.0, 0.0, -4.0), (10.0, -3.0, -12.5), (-20.0, 5.0, -18.0), (1.0, 1.0, -7.0)])
    pitch = np.array([0.0, 0.1, -0.2, 0.3])
    attitude = np.stack([np.cos(pitch / 2), 0 * pitch, np.sin(pitch / 2), 0 * pitch], axis=1)
    seen = loaded.observe("auv0", places, attitude, sensors=["altimeter", "depth"])
    assert set(seen) == {"altimeter", "depth"}
    assert seen["altimeter"].data.shape[0] == 4
    assert np.ravel(seen["altimeter"].truth) == pytest.approx((20.0 + places[:, 2]) / np.cos(pitch), rel=0.03)
    assert np.ravel(seen["depth"].truth) == pytest.approx(-places[:, 2], abs=0.02)
    assert seen["depth"].t_ns == 30_000_000
    assert len({row.tobytes() for row in seen["depth"].data - seen["depth"].truth}) == 4
    again = loaded.observe("auv0", places, attitude, sensors=["depth"])
    other = loaded.observe("auv0", places, attitude, sensors=["depth"], episode=1)
    assert again["depth"].data.tobytes() == seen["depth"].data.tobytes()
    assert not np.array_equal(other["depth"].data, seen["depth"].data)
    assert memory(loaded) == before
    loaded.step(ticks=5)
    after = memory(loaded)
    loaded.restore(kept)
    loaded.step(ticks=5)
    assert memory(loaded) == after


def test_looks_see_other_vehicles_and_props_where_they_are():
    scenario = copy.deepcopy(SCENARIO)
    scenario["agents"]["auv0"]["sensors"] = {"altimeter": {"type": "altimeter", "rate_hz": 10}}
    scenario["agents"]["rov"] = {"vehicle": "bluerov2", "start": {"position_m": [8.0, 0.0], "depth_m": 10.0}}
    sim = pl.Simulation.load(scenario)
    sim.spawn(pl.Prop("box", position=(-8, 0, -12), size=(3, 3, 2)))
    seen = sim.observe("auv0", [(8.0, 0.0, -5.0), (-8.0, 0.0, -5.0), (0.0, 0.0, -5.0), (0.0, 9.0, -5.0)])
    assert np.ravel(seen["altimeter"].truth) == pytest.approx([4.9, 6.0, 15.0, 15.0], abs=0.3)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("auv1", (0, 0, 0)), "did you mean 'auv0'"),
        (("auv0", (0, 0)), "shape"),
        (("auv0", [(0, 0, np.nan)]), "finite"),
        (("auv0", [(0, 0, -5)] * 3, [(1, 0, 0, 0)] * 2), "shape"),
    ],
)
def test_bad_looks_are_refused(loaded, arguments, says):
    with pytest.raises(pl.InputError, match=says):
        loaded.observe(*arguments)
    with pytest.raises(pl.InputError, match="did you mean 'depth'"):
        loaded.observe("auv0", (0, 0, -5), sensors=["dept"])
    with pytest.raises(pl.CommandError, match="copy"):
        loaded.observe("auv0", (0, 0, -5), copy=2)


def test_the_current_of_each_copy_carries_it_and_its_sensors_feel_it(loaded):
    """A drifting hull takes the water's speed; a current meter at rest reads it; others' copies read theirs."""
    loaded.reset()
    current = np.array([[0.4, -0.1, 0.0], [-0.2, 0.3, 0.0]])
    loaded.ocean.set(current=current)
    obs = loaded.step(ticks=10)
    q = loaded.state["auv0"].attitude
    yaw = 2 * np.arctan2(q[:, 3], q[:, 0])
    ahead = current[:, 0] * np.cos(yaw) + current[:, 1] * np.sin(yaw)
    speed = loaded.state["auv0"].velocity[:, 0]
    assert obs["auv0"]["meter"].truth[:, 0] == pytest.approx(ahead - speed, abs=0.02)
    loaded.run(40.0)
    moved = loaded.state["auv0"].position[:, :2]
    assert (np.einsum("ij,ij->i", moved, current[:, :2]) > 0.5 * 40 * (current[:, :2] ** 2).sum(axis=1)).all()
    kept, before = loaded.checkpoint(), memory(loaded)
    twin = loaded.fork()
    twin.ocean.set(current=(0.0, 0.0, 0.0))
    twin.step(ticks=5)
    loaded.step(ticks=5)
    after = memory(loaded)
    assert memory(twin) != after
    loaded.ocean.set(current=None)
    loaded.restore(kept)
    assert memory(loaded) == before
    loaded.step(ticks=5)
    assert memory(loaded) == after
    loaded.ocean.set(current=None)
    with pytest.raises(pl.CommandError, match="shape"):
        loaded.ocean.set(current=(1.0, 2.0))
    with pytest.raises(pl.CommandError, match="what is to be set"):
        loaded.ocean.set()
    with pytest.raises(pl.CommandError, match="turbidity"):
        loaded.ocean.set(turbidity=-1.0)


def test_a_checkpoint_without_a_current_ends_that_which_was_set(loaded):
    """What was set after it was taken is gone: vehicles and sensors are in still water again."""
    loaded.reset()
    loaded.step(ticks=2)
    kept = loaded.checkpoint()
    loaded.step(ticks=8)
    after = memory(loaded)
    loaded.restore(kept)
    loaded.ocean.set(current=[(0.4, -0.2, 0.0), (0.1, 0.3, 0.0)])
    loaded.step(ticks=8)
    assert memory(loaded) != after
    loaded.restore(kept)
    assert loaded.model.ocean.own is None
    loaded.step(ticks=8)
    assert memory(loaded) == after


def test_sun_weather_and_water_that_are_set_are_those_of_a_scenario_that_has_them():
    """Each number alone, too: what is not named stays."""
    scenario = copy.deepcopy(SCENARIO)
    scenario["ocean"] = {"sun": {"elevation_deg": 50.0, "azimuth_deg": 20.0}, "weather": {"cloud": 0.2}}
    sim = pl.Simulation.load(scenario)
    keys = {
        "sun": {"elevation_deg": -12.0, "azimuth_deg": 250.0}, "water_type": "7C",
        "weather": {"cloud": 0.7, "visibility_m": 900.0, "rain_mm_per_h": 12.0},
    }  # fmt: skip
    names = ("sun_elevation", "sun_azimuth", "water_type", "cloud", "visibility", "rain")
    for key, value in keys.items():
        scenario["ocean"][key] = value
        sim.ocean.set(keys={key: value})
        wanted = build_ocean(OceanConfig.model_validate(scenario["ocean"]))
        for name in names:
            assert str(getattr(sim.model.ocean, name)) == str(getattr(wanted, name)), (key, name)
    assert float(np.array(wanted.rain).item()) > 0


@pytest.mark.slow  # cameras are built four times
def test_lamps_turbidity_and_keys_of_sensors_are_set_while_the_run_goes_on():
    scenario = copy.deepcopy(SCENARIO)
    scenario["agents"]["auv0"]["start"] |= {"depth_m": 17.0}
    scenario["ocean"] = {"sun": {"elevation_deg": -50.0}}
    sensors = scenario["agents"]["auv0"]["sensors"]
    scenario["agents"]["auv0"]["sensors"] = {"camera": CAMERA, "depth": sensors["depth"]}
    sim = pl.Simulation.load(scenario)

    def picture() -> float:
        return float(np.mean(sim.step(ticks=10)["auv0"]["camera"].data))

    lit = picture()
    sim.set("auv0.lamp", on=False)
    assert picture() < 0.2 * lit
    assert sim.time_ns == 200_000_000
    sim.set("auv0.lamp", on=True)
    assert picture() == pytest.approx(lit, rel=0.2)
    sim.ocean.set(turbidity=6.0)
    assert picture() != pytest.approx(lit, rel=0.05)
    sim.set("auv0.depth", rate_hz=50)
    assert sim.scenario.agents["auv0"].sensors["depth"].rate_hz == 50
    assert len({sim.step(ticks=2)["auv0"]["depth"].t_ns for _ in range(5)}) == 5
    for bad, keys, says in (
        ("auv0.dept", {"rate_hz": 5}, "did you mean"),
        ("auv0.depth", {"rate": 5}, "did you mean 'rate_hz'"),
        ("auv0.depth", {"rate_hz": 7}, "divide"),
        ("auv0.depth", {}, "keys"),
        ("auv0.lamp", {"on": 1}, "on=True"),
        ("auv1.lamp", {"on": True}, "did you mean"),
    ):
        before = memory(sim)
        with pytest.raises(pl.InputError, match=says):
            sim.set(bad, **keys)
        assert memory(sim) == before


def test_another_world_of_the_same_kind():
    world = {"type": "generated", "seed": 1, "size_m": [60.0, 60.0]}
    scenario = {**copy.deepcopy(SCENARIO), "world": world}
    sensors = scenario["agents"]["auv0"]["sensors"]
    scenario["agents"]["auv0"]["sensors"] = {"altimeter": sensors["altimeter"]}
    scenario["agents"]["auv0"]["start"] = {"position_m": [0.0, 0.0], "depth_m": 1.0}
    sim = pl.Simulation.load(scenario)
    first = sim.reset()["auv0"]["altimeter"].truth.tobytes()
    sim.step(ticks=5)
    obs = sim.load_world(seed=7)
    assert sim.time_ns == 0
    fresh = pl.Simulation.load({**scenario, "world": {**world, "seed": 7}})
    assert obs["auv0"]["altimeter"].truth.tobytes() == fresh.reset()["auv0"]["altimeter"].truth.tobytes() != first
    sim.run(0.5)
    fresh.run(0.5)
    assert memory(sim) == memory(fresh)
    with pytest.raises(pl.InputError, match="did you mean"):
        sim.load_world(sed=3)
    with pytest.raises(pl.CommandError, match="which other world"):
        sim.load_world()


def test_other_seeds_and_currents_record_no_vehicle_again(monkeypatch):
    """Oceans of the same shape are the same to a recording; one that is made at every reset would fill the memory."""
    made, freeze = [], dr.freeze

    def noted(function: Any, **options: Any) -> Any:
        made.append(freeze(function, **options))
        return made[-1]

    monkeypatch.setattr(dr, "freeze", noted)
    scenario = copy.deepcopy(SCENARIO)
    scenario["agents"]["auv0"]["sensors"] = {}
    sim = pl.Simulation.load(scenario, n=2)
    for seed in (4, 5, 6):
        sim.reset(seed=seed)
        sim.step(ticks=3)
    for speed in (0.2, -0.1, 0.3):
        sim.ocean.set(current=np.full((2, 3), speed))
        sim.step(ticks=3)
    assert max(frozen.n_recordings for frozen in made) <= 2  # without and with a current of each copy's own
