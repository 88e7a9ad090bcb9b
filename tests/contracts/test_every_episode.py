"""Partial resets: the copies that begin anew, those that go on, and those that end by themselves."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from test_every_checkpoint import AFLOAT, IN_AIR, SCENARIO, catalogue_names

import pelagos as pl
from pelagos.errors import EndedWarning
from pelagos.sim.episodes import stream_of

QUICK: dict[str, Any] = {
    "seed": 4,
    "tick_rate_hz": 100,
    "world": {"type": "flat", "depth_m": 40.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "speed_mps": 1.0},
            "control": "depth_heading",
            "command": [6.0, 0.4, 900.0],
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50},
                "dvl": {"type": "dvl", "rate_hz": 10},
                "depth": {"type": "depth", "rate_hz": 10},
            },
        }
    },
}


def lane(sim: pl.Simulation, obs: Any, k: int) -> list[Any]:
    """Everything of one copy: readings and states, as bytes."""
    found: list[Any] = []
    for agent, readings in obs.items():
        for name, r in readings.items():
            parts = [r.data[k], r.truth[k], r.valid[k]]
            parts += [v[k] for v in r.extras.values() if len(v) == sim.n and v.ndim > 1]
            found.append((agent, name, r.t_ns, *(np.ascontiguousarray(p).tobytes() for p in parts)))
    for agent, state in sim.state.items():
        found.append((agent, *(np.asarray(v[k]).tobytes() for v in vars(state).values())))
        found.append(sim.stepper.contact(agent)[k].tobytes())
    return found


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.filterwarnings("ignore::pelagos.errors.MountWarning")
@pytest.mark.parametrize("which", ["some", pytest.param("every", marks=pytest.mark.slow)])
def test_a_copy_that_begins_anew_leaves_the_others_and_equals_a_fleet_of_one(which):
    """Sensors of the registry, with another vehicle, a mover and a mission; the second reset at an odd moment."""
    scenario = copy.deepcopy(SCENARIO)
    if which == "some":
        sensors = scenario["agents"]["auv0"]["sensors"]
        kept = ("imu", "dvl", "depth", "altimeter", "depth_camera", "collision", "oxygen", "imaging_sonar")
        scenario["agents"]["auv0"]["sensors"] = {name: sensors[name] for name in kept}
    fleet, still = pl.Simulation.load(scenario, n=3), pl.Simulation.load(scenario, n=3)
    alone = pl.Simulation.load(scenario, environment=1)
    there = {"rov": {"position": (3.2, 1.1, -7.6), "velocity": (0.1, -0.2, 0.0)}}
    for ticks in (20, 13, 9):
        for _ in range(ticks):
            obs, other, single = (s.step() for s in (fleet, still, alone))
            assert [lane(fleet, obs, k) for k in (0, 2)] == [lane(still, other, k) for k in (0, 2)]
            assert lane(fleet, obs, 1) == lane(alone, single, 0)
        first = fleet.reset(where=[1], state=there)
        assert lane(fleet, first, 1) == lane(alone, alone.reset(where=[True], state=there), 0)
        assert set(first["auv0"]) >= {"imu", "depth_camera", "dvl"}
    assert fleet.episode.tolist() == [0, 3, 0]
    assert fleet.time_ns == still.time_ns


def test_an_episode_has_streams_of_its_own_that_can_be_seen_again():
    """The same noise, whenever it begins at a multiple of the sensors' periods; other noise than before and beside."""
    sim = pl.Simulation.load(QUICK, n=2)

    def noise(sim: pl.Simulation, obs: Any, k: int) -> list[bytes]:
        found = []
        for _ in range(31):
            found += [(r.data[k] - r.truth[k]).round(9).tobytes() for r in obs["auv0"].values()]
            obs = sim.step()
        return found

    seen = [noise(sim, sim.reset(), 1)]
    sim.step(ticks=9)
    sim.reset(where=np.array([False, True]))
    seen.append(noise(sim, sim.reset(where=[1]), 1))
    assert sim.episode.tolist() == [0, 2]
    alone = pl.Simulation.load(QUICK, environment=1)
    assert noise(alone, alone.reset(episode=2), 0) == seen[1]
    alone.step(ticks=9)
    assert noise(alone, alone.reset(), 0) == seen[0]
    assert len({*seen[0]} & {*seen[1]}) <= 1  # a DVL that lost its track
    again = pl.Simulation.load(QUICK)
    assert noise(again, again.reset(environment=1, episode=2), 0) == seen[1]


def test_names_of_streams():
    """Of a first episode the environment itself; of others words that look drawn: no two alike among 2^13."""
    environment, episode = (v.ravel() for v in np.meshgrid(np.arange(128), np.arange(64)))
    words = stream_of(environment, episode)
    assert words[episode == 0].tolist() == list(range(128))
    assert len(np.unique(words)) == len(words)
    bits = (words[episode > 0][:, None] >> np.arange(32, dtype=np.uint32)) & 1
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 5 * 0.5 / np.sqrt(len(bits))


@pytest.mark.parametrize("name", sorted(catalogue_names()))
def test_every_vehicle_begins_anew_in_one_copy(name):
    """Actuators, controllers and radiated waves of that copy are those of the start; the others' are untouched."""
    depth = 0.0 if name in AFLOAT | IN_AIR else 5.0
    start = {"position_m": [0.0, 0.0], "depth_m": depth}
    sim = pl.Simulation.load(
        {"world": {"type": "flat", "depth_m": 60.0}, "agents": {"it": {"vehicle": name, "start": start}}}, n=3
    )
    names = sim.model.agents["it"].vehicle.command_names(sim.stepper.mode("it"))
    begin = sim.stepper.memory()["runs"]["it"]["vehicle"].reshape(-1, 3)
    sim.step({"it": np.linspace(0.05, 0.4, 3 * len(names)).reshape(3, -1)}, ticks=30)
    before = sim.stepper.memory()["runs"]["it"]["vehicle"].reshape(-1, 3)
    assert (before[:, 1] != begin[:, 1]).sum() > 6
    sim.reset(where=[1])
    after = sim.stepper.memory()["runs"]["it"]["vehicle"].reshape(-1, 3)
    assert after[:, 1].tobytes() == begin[:, 1].tobytes()
    assert after[:, [0, 2]].tobytes() == before[:, [0, 2]].tobytes()


def test_set_state_of_some_copies_leaves_the_controllers_of_the_others():
    sim, still = (pl.Simulation.load(QUICK, n=3) for _ in range(2))
    for s in (sim, still):
        s.step(ticks=50)
    sim.set_state("auv0", position=(1.0, 2.0, -9.0), where=[False, True, False])
    assert sim.state["auv0"].position[1].tolist() == [1.0, 2.0, -9.0]
    for _ in range(30):
        obs, other = sim.step(), still.step()
        assert [lane(sim, obs, k) for k in (0, 2)] == [lane(still, other, k) for k in (0, 2)]


def test_readings_of_a_reset_are_computed_when_looked_at_even_later():
    sim = pl.Simulation.load(QUICK)
    eager = sim.reset()["auv0"]["imu"].data.tobytes()
    first = sim.reset()
    sim.step(ticks=7)
    at = sim.state["auv0"].position.tobytes()
    assert first["auv0"]["imu"].data.tobytes() == eager
    assert first["auv0"]["imu"].t_ns == 0
    assert sim.state["auv0"].position.tobytes() == at
    assert sim.time_ns == 70_000_000


@pytest.mark.parametrize("speed", [1e6, 1e200])
def test_a_copy_that_is_not_finite_ends_alone(speed):
    """It is said once, with its name; the others' bytes are as if nothing had happened; a reset makes it live again."""
    sim, still = (pl.Simulation.load(QUICK, n=3) for _ in range(2))
    for s in (sim, still):
        s.step(ticks=5)
    sim.set_state("auv0", velocity=(speed, 0.0, 0.0), where=[2])
    with pytest.warns(EndedWarning, match=r"copy 2\) has no finite state at t = 0\.0[67]"):
        obs = sim.step(ticks=10)
    other = still.step(ticks=10)
    assert sim.ended.tolist() == [False, False, True]
    assert [lane(sim, obs, k) for k in (0, 1)] == [lane(still, other, k) for k in (0, 1)]
    assert obs["auv0"]["imu"].valid.tolist() == [True, True, False]
    assert np.allclose(sim.state["auv0"].position[2], [0, 0, -5])
    sim.run(0.5)
    still.run(0.5)
    assert sim.state["auv0"].position[1].tobytes() == still.state["auv0"].position[1].tobytes()
    assert np.allclose(sim.state["auv0"].position[2], [0, 0, -5])
    sim.reset(where=sim.ended)
    assert not sim.ended.any()
    assert sim.step(ticks=10)["auv0"]["imu"].valid.all()
    assert sim.state["auv0"].position[2, 0] > 0.05


@pytest.mark.filterwarnings("ignore::pelagos.errors.EndedWarning")
@pytest.mark.parametrize("motion", [{"angular_velocity": (0.0, 1000.0, 0.0)}, {"velocity": (1e6, 0.0, 0.0)}])
def test_a_copy_that_ends_within_a_block_says_until_then_what_it_says_tick_by_tick(motion, tmp_path):
    """Readings and true motion up to the last finite state, also those of another vehicle, which ends with it."""
    scenario = copy.deepcopy(QUICK)
    scenario["record"] = {"state_rate_hz": 100}
    auv = scenario["agents"]["auv0"] | {"sensors": {"pose": {"type": "pose", "rate_hz": 100}}}
    before = auv | {"start": {"position_m": [50.0, 9.0], "depth_m": 7.0}}
    if "angular_velocity" in motion:  # not moved together with the other
        before |= {"control": "depth_heading_speed", "command": [6.0, 0.1, 1.0]}
    scenario["agents"] = {"before": before, "auv0": auv}
    told = []
    for block in (1, 10):
        sim = pl.Simulation.load(scenario, n=2)
        sim.step(ticks=3)
        sim.set_state("auv0", **motion, where=[1])
        with sim.recording(tmp_path / f"{block}.mcap"):
            for _ in range(0, 10, block):
                sim.step(ticks=block)
        assert sim.ended.tolist() == [False, True]
        messages = pl.Recording(tmp_path / f"{block}.mcap").messages()
        told.append([(m.topic, m.t_ns, m.raw) for m in messages if m.topic.startswith("/env")])
    for agent in ("before", "auv0"):
        assert 0 < sum(topic.startswith(f"/env1/{agent}/pose") for topic, _, _ in told[0]) < 7
    assert told[0] == told[1]


def test_a_fleet_of_which_nothing_is_left_stops():
    sim = pl.Simulation.load(QUICK, n=2)
    sim.set_state("auv0", velocity=(1e300, 0.0, 0.0))
    with pytest.raises(pl.SimulationError, match="copy 0"):
        sim.step()
    alone = pl.Simulation.load(QUICK)
    alone.set_state("auv0", velocity=(1e300, 0.0, 0.0))
    with pytest.raises(pl.SimulationError, match="no finite state"):
        alone.step()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"where": [False, False]}, "no copy"),
        ({"where": [True]}, "shape"),
        ({"where": [5]}, "below 2"),
        ({"where": "all"}, "shape"),
        ({"where": [1], "seed": 3}, "leave out where"),
        ({"episode": -1}, "whole number"),
        ({"environment": 1.5}, "whole number"),
        ({"state": {"auv1": {}}}, "did you mean 'auv0'"),
        ({"state": {"auv0": {"positions": (0, 0, 0)}}}, "did you mean 'position'"),
        ({"state": {"auv0": {"position": (0, 0)}}}, "shape"),
        ({"where": [0], "state": {"auv0": {"position": [(0, 0, np.nan)]}}}, "finite"),
        ({"where": [0], "state": {"auv0": {"attitude": (0, 0, 0, 0)}}}, "must not be 0"),
    ],
)
def test_bad_resets_are_refused(arguments, says):
    sim = SHARED[0] if SHARED else SHARED.append(pl.Simulation.load(QUICK, n=2)) or SHARED[0]
    before = sim.stepper.memory()["runs"]["auv0"]["vehicle"].tobytes()
    with pytest.raises(pl.InputError, match=says):
        sim.reset(**arguments)
    assert sim.stepper.memory()["runs"]["auv0"]["vehicle"].tobytes() == before


SHARED: list[pl.Simulation] = []
