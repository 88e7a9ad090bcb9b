"""Groups of agents: members, their readings and commands together, noise that nobody else changes, collisions."""

from __future__ import annotations

import pickle
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import CommandError, LookupFailed, ScenarioError
from pelagos.sim.control import first_mode, steered_modes
from pelagos.sim.state import AgentState
from pelagos.vehicles.vehicle import Vehicle

SENSORS = {"imu": {"type": "imu", "rate_hz": 50}, "dvl": {"type": "dvl", "rate_hz": 5}}


def swarm(count: int | None, **keys: Any) -> dict[str, Any]:
    auv = {
        "count": count,
        "vehicle": "remus100",
        "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "speed_mps": 1.2, "spacing_m": [30.0, 25.0]},
        "control": "depth_heading",
        "command": [6.0, 0.4, 900.0],
        "sensors": SENSORS,
        "distributions": {"start.heading_deg": {"uniform": [-90.0, 90.0]}},
        **keys,
    }
    return {"seed": 9, "tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"auv": auv}}


def test_a_group_is_read_by_member_and_together():
    sim = pl.Simulation.load(swarm(5), n=3)
    assert list(sim.state) == [f"auv[{i}]" for i in range(5)]
    obs = sim.step(ticks=10)
    together = obs["auv"]["imu"]
    assert together.data.shape == (3, 5, 6)
    assert together.valid.all()
    assert together.frame == "auv/imu"
    for i in range(5):
        assert (together.data[:, i] == obs[f"auv[{i}]"]["imu"].data).all()
        assert (together.truth[:, i] == obs[f"auv[{i}]"]["imu"].truth).all()
        assert (sim.state["auv"].position[:, i] == sim.state[f"auv[{i}]"].position).all()
    assert sim.state["auv"].euler.shape == (3, 5, 3)
    assert obs["auv"]["dvl"].extras["ranges"].shape == (3, 5, 4)
    assert list(obs) == list(sim.state)
    with pytest.raises(LookupFailed, match="auv"):
        obs["auw"]


def test_a_group_together_is_its_members_stacked_and_zero_where_one_hears_nothing():
    """Members at drawn depths over a bottom at 40 m, which the altimeter hears within 20 m; an agent that is written
    before them is in their batch."""
    sensors = {
        "imu": {"type": "imu", "rate_hz": 20},
        "up": {"type": "altimeter", "rate_hz": 10, "range_max_m": 20.0},
        "sonar": {"type": "singlebeam", "rate_hz": 5, "bins": 16, "range_max_m": 12.0},
    }
    auv = {"vehicle": "remus100", "sensors": sensors}
    depths = {"start.depth_m": {"uniform": [2.5, 34.0]}}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 20,
            "seed": 6,
            "world": {"type": "flat", "depth_m": 40.0},
            "agents": {
                "scout": {**auv, "start": {"position_m": [-50.0, 8.0], "depth_m": 30.0}},
                "auv": {**auv, "count": 4, "distributions": depths,
                        "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "spacing_m": 15.0}},
            },
        },
        n=2,
    )  # fmt: skip
    for ticks in (4, 8):
        obs = sim.step(ticks=ticks)
        assert list(obs) == ["scout", *(f"auv[{i}]" for i in range(4))]
        assert "auv" in obs
        heard = 0
        for sensor, together in obs["auv"].items():
            newest = max(obs[f"auv[{i}]"][sensor].t_ns for i in range(4) if sensor in obs[f"auv[{i}]"])
            assert (together.t_ns, together.frame) == (newest, f"auv/{sensor}")
            for i in range(4):
                alone = obs[f"auv[{i}]"].get(sensor)
                if alone is None or alone.t_ns < newest:
                    assert not together.valid[:, i].any()
                    assert not together.data[:, i].any()
                    continue
                heard += sensor == "up"
                np.testing.assert_array_equal(together.data[:, i], alone.data)
                np.testing.assert_array_equal(together.truth[:, i], alone.truth)
                np.testing.assert_array_equal(together.valid[:, i], alone.valid)
                for name, values in alone.extras.items():
                    lanes = (
                        np.ndim(values)
                        and len(values) == len(alone.valid)
                        and np.ndim(together.extras[name]) > np.ndim(values)
                    )
                    np.testing.assert_array_equal(
                        together.extras[name][:, i] if lanes else together.extras[name], values
                    )
        assert set(obs["auv"]) == set(sensors)
        assert 0 < heard < 4


@pytest.mark.parametrize("ticks", [1, 4, 10])
def test_a_member_of_another_batch_keeps_its_column(ticks):
    """Member 3's log is another, so that it is in a batch of its own."""
    sim = pl.Simulation.load(swarm(5, overrides={3: {"sensors": {"dvl": {"rate_hz": 2}}}}), n=2)
    obs = sim.step(ticks=ticks)
    together = obs["auv"]["imu"]
    assert together.data.shape == (2, 5, 6)
    for i in range(5):
        np.testing.assert_array_equal(together.data[:, i], obs[f"auv[{i}]"]["imu"].data)
    copied = pickle.loads(pickle.dumps(obs))
    np.testing.assert_array_equal(copied["auv[3]"]["imu"].data, obs["auv[3]"]["imu"].data)
    assert obs.get("nobody", 7) == 7
    assert obs.get("auv")["imu"].data.shape == (2, 5, 6)


def test_members_begin_on_the_grid_and_as_drawn():
    sim = pl.Simulation.load(swarm(5, overrides={3: {"start": {"depth_m": 9.0}}}))
    position = sim.state["auv"].position[0]
    assert position[:, :2].tolist() == [[0, 0], [0, 25], [30, 25], [30, 0], [0, 50]]
    assert position[:, 2].tolist() == [-5, -5, -5, -9, -5]
    heading = sim.state["auv"].euler[0, :, 2]
    assert len(np.unique(heading)) == 5
    assert np.abs(heading).max() < np.pi / 2


def test_a_member_does_not_depend_on_how_many_follow_it():
    few, many = pl.Simulation.load(swarm(2), n=2), pl.Simulation.load(swarm(7), n=2)
    for _ in range(30):
        one, other = few.step(), many.step()
        for name in ("auv[0]", "auv[1]"):
            for sensor, reading in one[name].items():
                assert (reading.data == other[name][sensor].data).all()
                assert (reading.truth == other[name][sensor].truth).all()
    for name in ("auv[0]", "auv[1]"):
        assert (few.state[name].position == many.state[name].position).all()
    noise = other["auv"]["imu"].data - other["auv"]["imu"].truth
    assert len(np.unique(noise[..., 0])) == 14


def test_commands_of_a_group_and_of_its_members():
    sim, n, members = pl.Simulation.load(swarm(4), n=2), 2, 4
    everyone = np.arange(n * members * 3, dtype=float).reshape(n, members, 3)
    sim.step({"auv": everyone})
    for i in range(members):
        held = sim.stepper.runs["auv[0]"].command_values[i * n : (i + 1) * n]
        assert (held == everyone[:, i]).all()
    sim.step({"auv": everyone[1], "auv[2]": [7.0, 0.1, 300.0]})
    held = sim.stepper.runs["auv[0]"].command_values.reshape(members, n, 3)
    assert (held[[0, 1, 3]] == everyone[1, [0, 1, 3], None]).all()
    assert (held[2] == [7.0, 0.1, 300.0]).all()
    with pytest.raises(CommandError, match=r"\(4, k\)"):
        sim.step({"auv": np.zeros((3, 3))})


def test_members_in_different_control_modes_go_as_alone(monkeypatch):
    from pelagos.sim import model as sim_model

    def run() -> tuple[np.ndarray, str]:
        sim = pl.Simulation.load(swarm(3), n=2)
        sim.step(ticks=5)
        sim.set_mode("auv[1]", "actuators")
        sim.step({"auv[1]": [0.1, -0.1, 700.0]}, ticks=20)
        kept = sim.checkpoint()
        sim.step(ticks=5)
        after = sim.state["auv"].velocity
        sim.restore(kept)
        sim.step(ticks=5)
        assert (sim.state["auv"].velocity == after).all()
        return after, sim.stepper.mode("auv[1]") + sim.stepper.mode("auv[2]")

    names = pl.Vehicle.from_catalogue("remus100").command_names("actuators")
    assert len(names) == 3
    together, modes = run()
    assert modes == "actuatorsdepth_heading"
    monkeypatch.setattr(sim_model, "alike", lambda members, modes: [[name] for name in members])
    alone, _ = run()
    assert (together == alone).all()


def test_recordings_of_a_group_have_topics_by_member(tmp_path):
    path = tmp_path / "swarm.mcap"
    pl.Simulation.load(swarm(3)).run(0.5, record=path)
    found = pl.Recording(path)
    assert found.topics("/auv_1/truth")
    assert {t.split("/")[1] for t in found.topics() if "/imu" in t} == {"auv_0", "auv_1", "auv_2"}


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"start": {"position_m": [0, 0], "depth_m": 5.0}}, "spacing_m"),
        ({"overrides": {9: {}}}, "no member 9"),
        ({"overrides": {4: {}}}, "no member 4; members of this group are 0 to 3"),
        ({"overrides": {2: {}, -1: {}}}, "no member -1; members of this group are 0 to 3"),
        ({"overrides": {1: {"starts": {}}}}, r"auv\[1\]: starts: there is no such key"),
        ({"distributions": {"start.headin": {"uniform": [0, 1]}}}, "start.headin"),
        ({"distributions": {"vehicle.type": {"uniform": [0, 1]}}}, "names no number"),
        ({"distributions": {"start.heading_deg": {"uniform": [1, 0]}}}, "lowest to the highest"),
        ({"start": {"position_m": [0, 0], "spacing_m": 5.0, "grid": [1, 2]}}, "no room for 4"),
        ({"start": {"position_m": [0, 0], "spacing_m": 5.0, "grid": [3, 1]}}, "3 x 1 has no room for 4"),
        ({"overrides": {1: {"sensors": {"imu": {"rate_hz": 30}}}}}, "does not divide"),
    ],
)
def test_what_no_group_can_be_is_refused(keys, text):
    with pytest.raises(ScenarioError, match=text):
        pl.Simulation.load(swarm(4, **keys))


def test_a_group_may_fill_its_grid_and_change_its_first_and_last_member():
    """Four members in 2 x 2 places; those of 0 and 3 are their own."""
    start = {"position_m": [3, -8], "depth_m": 5.0, "spacing_m": [30, 25], "grid": [2, 2]}
    deep = {0: {"start": {"depth_m": 7.5}}, 3: {"start": {"depth_m": 9.0}}}
    sim = pl.Simulation.load(swarm(4, start=start, overrides=deep))
    assert sim.state["auv"].position[0, :, 2].tolist() == [-7.5, -5, -5, -9]
    assert len(np.unique(sim.state["auv"].position[0, :, :2], axis=0)) == 4


def test_keys_of_groups_are_refused_for_single_agents():
    with pytest.raises(ScenarioError, match="give 'count' too"):
        pl.Simulation.load(swarm(None))


def test_a_name_whose_topics_another_has_is_refused():
    scenario = swarm(2)
    scenario["agents"]["auv_1"] = {"vehicle": "remus100"}
    with pytest.raises(ScenarioError, match="auv_1"):
        pl.Simulation.load(scenario)


def test_a_group_is_placed_and_its_commands_are_read_as_one():
    sim = pl.Simulation.load(swarm(3), n=2)
    sim.command({"auv": [[6.0, 0.4, 900.0], [7.0, -0.3, 800.0], [5.0, 0.1, 700.0]]})
    held = sim.held_command("auv")
    assert held.shape == (2, 3, 3)
    assert (held[1, 1] == [7.0, -0.3, 800.0]).all()
    places = -np.arange(1.0, 19.0).reshape(2, 3, 3)
    before = sim.state["auv"]
    sim.set_state("auv", position=places, velocity=[[1.0, 0.2, -0.1], [0.5, -0.2, 0.1], [1.5, 0.0, 0.3]])
    now = sim.state["auv"]
    np.testing.assert_array_equal(now.position, places)
    np.testing.assert_array_equal(now.velocity[:, 2], [[1.5, 0.0, 0.3]] * 2)
    np.testing.assert_array_equal(now.attitude, before.attitude)
    one = pl.Simulation.load(swarm(3), n=2)
    one.command({f"auv[{i}]": held[:, i] for i in range(3)})
    for i in range(3):
        one.set_state(f"auv[{i}]", position=places[:, i], velocity=now.velocity[:, i])
    sim.set_state("auv", position=places[0] - 0.5, where=[1])
    for i in range(3):
        one.set_state(f"auv[{i}]", position=places[0, i] - 0.5, where=[1])
    assert (sim.step(ticks=20)["auv"]["imu"].data == one.step(ticks=20)["auv"]["imu"].data).all()
    np.testing.assert_array_equal(sim.state["auv"].position, one.state["auv"].position)
    sim.set_mode("auv[1]", "wrench")
    with pytest.raises(CommandError, match=r"auv\[0\] in 'depth_heading' and auv\[1\] in 'wrench'"):
        sim.held_command("auv")
    with pytest.raises(CommandError, match=r"auv: position of a group has shape .*\(2, 3, k\); given \(2, 3\)"):
        sim.set_state("auv", position=np.zeros((2, 3)))


def test_wrong_names_are_told_and_mappings_answer_as_mappings():
    sim = pl.Simulation.load(swarm(3, sensors={**SENSORS, "gps": {"type": "gps", "rate_hz": 1}}), n=2)
    obs = sim.step(ticks=10)
    for ask, match in (
        (lambda: obs[0], "unknown agent 0; known: auv, "),
        (lambda: obs[["auv"]], r"unknown agent \['auv'\]"),
        (lambda: obs["auw"], r"unknown agent 'auw' \(did you mean 'auv'"),
        (lambda: sim.state["auw"], r"unknown agent 'auw' \(did you mean 'auv'"),
        (lambda: obs["auv"]["imv"], r"^auv: unknown sensor 'imv' \(did you mean 'imu'\?\); known: dvl, gps, imu$"),
        (lambda: obs["auv[1]"]["imv"], r"^auv\[1\]: unknown sensor 'imv'"),
        (lambda: obs["auv"]["gps"], "auv.gps has no reading in this step; those with one: imu, dvl"),
        (lambda: obs["auv[2]"]["gps"], r"auv\[2\].gps has no reading in this step"),
    ):
        with pytest.raises(KeyError) as told:
            ask()
        assert isinstance(told.value, pl.errors.InputError)
        assert re.search(match, str(told.value)), str(told.value)
        assert str(pickle.loads(pickle.dumps(told.value))) == str(told.value)
    for mapping in (obs, sim.state, obs["auv"], obs["auv[1]"]):
        assert "auw" not in mapping
        assert mapping.get("auw", 7) == 7
    assert "gps" not in obs["auv"]
    for wrong in ("a", [[1.0, 2.0], [3.0]], {}):
        with pytest.raises(CommandError, match=r"auv: a command of a group"):
            sim.step({"auv": wrong})
    for act in (
        lambda: sim.navigate("auv", position=[0, 0, 0], heading_rad=0.0),
        lambda: sim.ocean.set(current=[1.0, 0.0, 0.0], agent="auv"),
    ):
        with pytest.raises(CommandError, match=r"auv is a group of 3: name one member, auv\[0\] to auv\[2\]"):
            act()


def test_depths_are_of_every_member() -> None:
    """The third coordinate with its sign reversed, of one vehicle `(n,)` and of a group `(n, members)`."""
    zero = [np.zeros((4, k)) for k in (4, 3, 3, 3, 3, 2)]
    places = [np.random.default_rng(k).uniform(-9.0, 3.0, (4, 3)) for k in range(5)]
    states = [AgentState(place, *zero) for place in places]
    assert states[1].depth.tolist() == (-places[1][:, 2]).tolist()
    together = AgentState.together(states)
    assert together.depth.tolist() == [[-place[n, 2] for place in places] for n in range(4)]
    assert together.depth.min() < 0 < together.depth.max()


@pytest.mark.parametrize("asked", [None, "depth_heading", "actuators"])
def test_a_mission_steers_by_the_mode_that_was_asked_for(asked: str | None) -> None:
    vehicle: Any = SimpleNamespace(
        modes=("actuators", "course", "depth_heading"), default_mode="actuators",
        set_points=lambda mode: set_points[mode], command_names=lambda mode: (),
    )  # fmt: skip
    real = Vehicle.from_catalogue("remus100")
    steered = steered_modes(real)
    set_points = {"actuators": (), "course": real.set_points(steered[0]), "depth_heading": real.set_points(steered[0])}
    agent = SimpleNamespace(control=asked, mission=[object()], command=None, vehicle=SimpleNamespace(type="remus100"))
    scenario: Any = SimpleNamespace(members={"auv": agent}, where=lambda *keys: ".".join(keys))
    usual, other = steered_modes(vehicle)
    if asked == "actuators":
        with pytest.raises(ScenarioError, match=f"'actuators' cannot be used here.*allowed: {usual}, {other}"):
            first_mode(scenario, "auv", vehicle)
    else:
        assert first_mode(scenario, "auv", vehicle) == (asked or usual)
    assert {usual, other} == {"course", "depth_heading"}
