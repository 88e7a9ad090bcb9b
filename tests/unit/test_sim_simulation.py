"""The Python face: shapes, absent readings, commands, props, states, errors."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.errors import SimulationError
from pelagos.sim.run import _Loop, _with_dump

SCENARIO = {
    "world": {"type": "flat", "depth_m": 20.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "heading_deg": 90.0, "speed_mps": 1.0},
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 100},
                "gps": {"type": "gps", "rate_hz": 10},
                "altimeter": {"type": "altimeter", "rate_hz": 10},
            },
        }
    },
}


@pytest.fixture
def sim() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


def test_state_has_the_shapes_and_frames_of_the_design():
    sim = pl.Simulation.load(SCENARIO, n=3)
    state = sim.state["auv0"]
    assert state.position.shape == (3, 3)
    assert state.attitude.shape == (3, 4)
    assert state.velocity.shape == (3, 3)
    assert np.allclose(state.position, [0, 0, -5])
    assert np.allclose(state.velocity, [1, 0, 0])
    sim.run(1.0)
    assert (sim.state["auv0"].position[:, 1] < -0.5).all()  # east is -y


def test_readings_are_absent_when_not_due_and_when_there_is_none(sim):
    obs = sim.reset()
    assert set(obs["auv0"]) == {"imu", "altimeter"}  # under water there is no GPS
    assert set(sim.step()["auv0"]) == set()  # 100 Hz in ticks of 5 ms: every second one
    assert set(sim.step()["auv0"]) == {"imu"}
    assert sim.time_ns == 10_000_000
    reading = obs["auv0"]["imu"]
    assert reading.data.shape == (1, 6)
    assert reading.frame == "auv0/imu"
    assert reading.truth[0, 2] == pytest.approx(9.81, abs=0.1)


def test_altimeter_sees_a_prop_come_move_and_go(sim):
    def altitude() -> float:
        sim.set_state(
            "auv0", position=(0, 0, -5), attitude=(1, 0, 0, 0), velocity=(0, 0, 0), angular_velocity=(0, 0, 0)
        )
        while True:
            obs = sim.step()
            if "altimeter" in obs["auv0"]:
                return float(np.ravel(obs["auv0"]["altimeter"].truth)[0])

    empty = altitude()
    box = sim.spawn(pl.Prop("box", position=(0, 0, -10), size=(4, 4, 1), material="steel", label="debris"))
    assert altitude() == pytest.approx(empty - 10.5, abs=0.2)
    box.move(position=(0, 0, -12))
    assert altitude() == pytest.approx(empty - 8.5, abs=0.2)
    hits = sim.world.cast((0, 0, -6), (0, 0, -1))
    assert hits.t[0] == pytest.approx(5.5, abs=1e-4)
    box.remove()
    assert altitude() == pytest.approx(empty, abs=0.2)
    with pytest.raises(pl.InputError, match="removed"):
        box.move(position=(0, 0, 0))


def test_commands_are_held_until_the_next(sim):
    sim.set_mode("auv0", "actuators")
    sim.step({"auv0": (0.1, -0.05, 1000.0)})
    for _ in range(400):
        sim.step()
    actuators = sim.state["auv0"].actuators[0]
    assert actuators[0] == pytest.approx(0.1, abs=1e-3)
    assert actuators[2] > 800


@pytest.mark.parametrize(
    ("command", "says"),
    [
        ((1.0, 2.0), "shape"),
        ((np.nan, 0.0, 0.0), "not a finite number"),
        (("a", "b", "c"), "numbers"),
    ],
)
def test_bad_commands_are_refused(sim, command, says):
    with pytest.raises(pl.InputError, match=says):
        sim.step({"auv0": command})


def test_unknown_names_suggest_the_nearest(sim):
    with pytest.raises(pl.InputError, match="did you mean 'auv0'"):
        sim.step({"auv1": (0, 0, 0)})
    with pytest.raises(pl.InputError, match="did you mean 'actuators'"):
        sim.set_mode("auv0", "actuator")


def test_a_policy_is_asked_every_tick(sim):
    asked = []

    def policy(obs):
        asked.append(sorted(obs["auv0"]))
        return {"auv0": (6.0, 1.0, 900.0)} if sim.stepper.mode("auv0") == "depth_heading" else {}

    sim.run(0.1, policy=policy)
    assert len(asked) == 20


def test_starting_inside_the_seabed_is_refused():
    scenario = {
        **SCENARIO,
        "agents": {"auv0": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 25.0}}},
    }
    with pytest.raises(pl.ScenarioError, match="auv0"):
        pl.Simulation.load(scenario)


def test_two_agents_see_each_other_but_not_themselves():
    one = SCENARIO["agents"]["auv0"]
    other = {**one, "start": {**one["start"], "depth_m": 10.0}}
    sim = pl.Simulation.load({**SCENARIO, "agents": {"auv0": one, "below": other}})
    obs = sim.reset()
    assert np.ravel(obs["auv0"]["altimeter"].truth)[0] < 6.0
    assert np.ravel(obs["below"]["altimeter"].truth)[0] == pytest.approx(10.0, abs=0.5)


@pytest.mark.parametrize(("towards", "slip"), [(0.0, 1e-3), (-125.0, 0.41 * np.exp(-60 / 20))])
def test_current_carries_a_drifting_vehicle(towards, slip):
    """Bow to the east. Across the hull it is carried whole; along it drag catches up with 20 s of time constant."""
    scenario = {**SCENARIO, "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.5, "towards_deg": towards}]}}
    sim = pl.Simulation.load(scenario)
    sim.set_mode("auv0", "actuators")
    sim.set_state("auv0", velocity=(0, 0, 0))
    sim.run(60.0)
    before = sim.state["auv0"].position[0].copy()
    sim.run(2.0)
    way = (sim.state["auv0"].position[0] - before) / 2.0
    north, west = 0.5 * np.cos(np.radians(towards)), -0.5 * np.sin(np.radians(towards))
    assert way == pytest.approx([north, west, 0.0], abs=slip)


@pytest.mark.parametrize("speed", [1.5, -0.4])
def test_the_start_speed_is_over_the_ground(speed):
    """Heading 60 in a current to the south-west: in the first 10 ms drag changes 1.5 m/s by some mm/s."""
    start = {"position_m": [3.0, -4.0, -8.0], "heading_deg": 60.0, "speed_mps": speed}
    scenario = {
        "tick_rate_hz": 100,
        "world": {"type": "flat", "depth_m": 30},
        "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.7, "towards_deg": 225}]},
        "agents": {"a": {"vehicle": "remus100", "control": "actuators", "start": start}},
    }
    sim = pl.Simulation.load(scenario)
    assert sim.state["a"].velocity[0] == pytest.approx([speed, 0.0, 0.0], abs=1e-12)
    sim.step()
    ahead = 0.01 * speed * np.array([np.cos(np.radians(60)), -np.sin(np.radians(60)), 0.0])
    assert sim.state["a"].position[0] - [3.0, -4.0, -8.0] == pytest.approx(ahead, abs=1e-4)


@pytest.mark.parametrize(
    ("roll", "pitch", "heading"), [(10.0, 20.0, 30.0), (-25.0, 15.0, -120.0), (5.0, -35.0, 170.0), (0.0, 12.0, 0.0)]
)
def test_the_start_attitude_comes_back_as_it_was_written(roll, pitch, heading):
    """Scenario: starboard down, nose up, clockwise. FLU in NWU: pitch positive looks down, yaw counter-clockwise."""
    start = {"position_m": [0, 0, -8], "roll_deg": roll, "pitch_deg": pitch, "heading_deg": heading}
    data = {"world": {"type": "flat", "depth_m": 30}, "agents": {"a": {"vehicle": "remus100", "start": start}}}
    state = pl.Simulation.load(data).state["a"]
    assert np.degrees(state.euler[0]) == pytest.approx([roll, -pitch, -heading], abs=1e-9)
    w, x, y, z = state.attitude[0]
    nose_up = 2 * (x * z - w * y)  # world z of the body's forward axis, by the rotation matrix
    port_up = 2 * (y * z + w * x)  # of its left axis
    assert nose_up == pytest.approx(np.sin(np.radians(pitch)), abs=1e-12)
    assert port_up == pytest.approx(np.sin(np.radians(roll)) * np.cos(np.radians(pitch)), abs=1e-12)


class OnlyDlpack:
    """An array of some other library: nothing but DLPack."""

    def __init__(self, values: np.ndarray) -> None:
        self._values = values

    def __dlpack__(self, **keys: object) -> object:
        return self._values.__dlpack__(**keys)

    def __dlpack_device__(self) -> tuple[int, int]:
        return self._values.__dlpack_device__()


def test_commands_come_by_dlpack_too():
    sim = pl.Simulation.load(SCENARIO, n=2)
    sim.set_mode("auv0", "actuators")
    values = np.array([[0.1, -0.05, 900.0], [0.2, 0.05, 700.0]])
    sim.step({"auv0": OnlyDlpack(values)})
    assert np.array_equal(sim.held_command("auv0"), values)
    values[:] = 0.0  # the buffer is the caller's again
    assert sim.held_command("auv0")[1, 2] == 700.0
    with pytest.raises(pl.InputError, match="shape"):
        sim.step({"auv0": OnlyDlpack(values.T)})


def test_readings_are_tensors_on_request():
    sim = pl.Simulation.load(SCENARIO, n=3)
    reading = sim.reset()["auv0"]["imu"]
    assert reading.array.shape == (3, 6)
    assert np.array_equal(np.array(reading.array), reading.data)
    assert np.array_equal(np.from_dlpack(reading.array), reading.data)


@pytest.mark.parametrize(("duration", "ends"), [(1.2, 1.2), (3.0, 1.8)])
def test_a_run_ends_a_second_after_its_missions_or_with_its_duration(duration, ends):
    """The mission is over in the block that ends at 0.8 s."""
    agent = {
        "vehicle": "bluerov2_heavy",
        "start": {"position_m": [1, -2, -8]},
        "mission": [{"type": "station_keeping", "seconds": 0.7}],
    }
    world = {"type": "flat", "depth_m": 30}
    sim = pl.Simulation.load({"tick_rate_hz": 50, "duration_s": duration, "world": world, "agents": {"a": agent}})
    assert sim.run().ended == "missions"
    assert sim.time_ns == pytest.approx(ends * 1e9, abs=1)


@pytest.mark.parametrize("angles", [(20.0, -60.0, 130.0), (-35.0, 50.0, 250.0), (75.0, 10.0, -40.0)])
def test_a_start_is_refused_where_the_turned_hull_reaches_the_ground(angles):
    """Over flat ground: by the lowest of its probes' tips, turned as a whole; a centimetre above, it starts."""
    starts, vectors = pl.Vehicle.from_catalogue("remus100").probes
    roll, pitch, heading = angles
    body = (starts + vectors) * (1, -1, -1)  # FRD
    reach = Rotation.from_euler("ZYX", [heading, pitch, roll], degrees=True).apply(body)[:, 2].max()
    start = {"position_m": [3.0, -2.0], "roll_deg": roll, "pitch_deg": pitch, "heading_deg": heading}

    def load(clear_m: float) -> None:
        agent = {"vehicle": "remus100", "start": {**start, "depth_m": 20.0 - reach - clear_m}}
        pl.Simulation.load({"world": {"type": "flat", "depth_m": 20.0}, "agents": {"a": agent}})

    load(0.01)
    with pytest.raises(pl.InputError, match=r"a cannot start here: .* its hull would touch seabed"):
        load(-0.01)


def test_a_run_tells_its_own_part_of_the_time_and_means_of_calls():
    """From where it began; counts and newest readings are those that it kept."""
    timings = SimpleNamespace(seconds={"a.imu": 0.5, "physics": 3.0}, calls={"a.imu": 4, "physics": 100})
    told = []
    loop = SimpleNamespace(
        _stepper=SimpleNamespace(tick=170, timings=timings), _first=50, _sim=SimpleNamespace(dt_ns=20_000_000),
        _counts={"a.imu": 7}, _logs=[], _latest={"a": {}}, _realtime=0.0, _asked=3.5,
        _progress=lambda *now: told.append(now),
    )  # fmt: skip
    result = _Loop._result(loop, 0.6, "stopped")
    assert (result.simulated_s, result.wall_s, result.ended) == (pytest.approx(2.4), 0.6, "stopped")
    assert result.real_time_factor == pytest.approx(4.0)
    assert result.ms_per_call == {"a.imu": pytest.approx(125.0), "physics": pytest.approx(30.0)}
    assert result.seconds_by_part == timings.seconds
    assert result.seconds_by_part is not timings.seconds
    assert (result.counts, result.observations, result.recording) == ({"a.imu": 7}, {"a": {}}, None)
    _Loop._report(loop)
    assert told == [(pytest.approx(2.4), 3.5)]


@pytest.mark.parametrize("recorded", [False, True])
def test_the_last_state_is_kept_beside_the_recording(recorded, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    error = SimulationError("auv0 (copy 2) has no finite state")
    vars(error).update(agent="auv0", state=np.arange(19.0), command=np.array([0.3, -0.2]), t_s=4.5, copy=2)
    recorder = SimpleNamespace(path=tmp_path / "out" / "run.mcap") if recorded else None
    path = (tmp_path / "out" if recorded else tmp_path) / "auv0_last_state.npz"
    told = _with_dump(error, recorder)
    assert str(told) == f"auv0 (copy 2) has no finite state. The state is in {path}"
    kept = np.load(path)
    assert {name: kept[name].tolist() for name in kept.files} == {
        "state": list(range(19)), "command": [0.3, -0.2], "t_s": 4.5, "copy": 2
    }  # fmt: skip


def test_spawned_bodies_are_numbered_anew_after_a_reset(sim):
    """By name and by instance, as in a simulation that has just begun."""

    def two() -> list[tuple[str, int]]:
        made = [sim.spawn(pl.Prop(shape, position=(9.0, 5.0, -4.0))) for shape in ("box", "sphere")]
        return [(body.name, body.geometry.instance) for body in made]

    first = two()
    assert [name for name, _ in first] == ["box1", "sphere2"]
    assert two() == [(f"{name[:-1]}{k}", 2 + number) for (name, number), k in zip(first, (3, 4), strict=True)]
    kept = sim.checkpoint()
    sim.reset()
    assert two() == first
    sim.restore(kept)
    assert [name for name, _ in two()] == ["box5", "sphere6"]
