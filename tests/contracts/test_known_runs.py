"""A run of three copies that all differ: of seas, currents, starts, masses, mounts and props; with resets of one copy,
checkpoints, forks, orders, callbacks and recordings in the middle of it.

One simulation serves all tests here; each begins with a reset.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from known import DOUBLE, check
from pelagos.errors import EndedWarning
from pelagos.messages.motion import ODOMETRY_FIELDS
from pelagos.sim.checkpoint import Checkpoint
from pelagos.sim.falling import Falling
from pelagos.sim.order import Order, apply
from pelagos.sim.replay import Recording
from pelagos.sim.resume import keep, last_checkpoint, resumed_recorder

ROV: dict[str, Any] = {
    "vehicle": "bluerov2_heavy", "control": "velocity",
    "start": {"position_m": [1.0, -3.0, -4.5], "pitch_deg": 4.0, "heading_deg": 35.0, "speed_mps": 0.2},
    "sensors": {
        "imu": {"type": "imu", "rate_hz": 25, "position_m": [0.1, -0.05, 0.02], "orientation_deg": [3, -4, 50]},
        "dvl": {"type": "dvl", "rate_hz": 5, "position_m": [-0.2, 0.1, -0.1], "orientation_deg": [0, 0, 45]},
        "depth": {"type": "depth", "rate_hz": 12.5, "position_m": [0.2, 0.1, -0.1]},
        "ranger": {"type": "range_finder", "rate_hz": 10, "range_max_m": 25.0, "azimuth_deg": [0.0, 25.0, -60.0],
                   "elevation_deg": [5.0, -30.0, -10.0], "position_m": [0.3, 0.0, 0.1]},
    },
}  # fmt: skip
AUV: dict[str, Any] = {
    "vehicle": "remus100", "count": 2, "mission_from": "start", "navigation": {"type": "ekf"},
    "start": {"position_m": [12.0, -20.0], "depth_m": 5.0, "heading_deg": -50.0, "speed_mps": 1.1,
    "spacing_m": [9.0, 14.0]},
    "mission": [{"type": "waypoints", "points": [[22.0, -9.0], [31.0, 12.0]], "depth_m": 7.0}],
    "sensors": {"imu": {"type": "imu", "rate_hz": 50}, "depth": {"type": "depth", "rate_hz": 10},
                "dvl": {"type": "dvl", "rate_hz": 5}},
    "distributions": {"start.depth_m": {"uniform": [3.0, 9.0]}},
}  # fmt: skip
SCENARIO: dict[str, Any] = {
    "seed": 6, "tick_rate_hz": 50, "record": {"state_rate_hz": 10, "groups": "together"},
    "origin": {"latitude_deg": 44.3, "longitude_deg": 9.2},
    "world": {
        "type": "flat", "depth_m": 13.0, "size_m": [200.0, 160.0],
        "things": [{"shape": "box", "at_m": [9.0, -6.0, -7.0], "size_m": [2.0, 5.0, 9.0], "orientation_deg": [5, 9,
        30]}],
        "movers": [{"name": "fish", "body": "sphere", "size_m": 1.4, "path": {"kind": "circle",
                    "centre_m": [5.0, -2.0, -4.0], "radius_m": 2.5, "speed_mps": 0.9, "clockwise": True,
                    "phase_deg": 40}}],
    },
    "ocean": {
        "currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 70.0}],
        "waves": [{"type": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.5, "towards_deg": 40.0,
                   "components_count": 12},
                  {"type": "regular", "height_m": 0.3, "period_s": 6.0, "towards_deg": -70.0}],
        "tide": {"period_h": 5.0, "amplitude_m": 0.8, "phase_deg": 40.0},
    },
    "props": {"crate": {"shape": "box", "position_m": [4.0, -4.0, -5.0], "size_m": [0.8, 1.3, 0.6], "orientation_deg":
                        [10, 20, 30]},
              "ball": {"shape": "sphere", "position_m": [-3.0, -6.0, -6.0], "size_m": 1.1, "material": "rock"}},
    "agents": {"rov": ROV, "auv": AUV},
    "vary": {
        "agents.rov.start.position_m.1": {"normal": [-3.0, 0.7]}, "agents.rov.start.heading_deg": {"uniform": [-30,
        60]},
        "agents.rov.start.roll_deg": {"uniform": [-9, 9]}, "agents.rov.start.speed_mps": {"uniform": [0.1, 0.5]},
        "agents.rov.factors.mass": {"uniform": [0.9, 1.1]}, "agents.rov.factors.thrust": {"choice": [0.8, 1.2]},
        "agents.rov.sensors.dvl.position_m.0": {"uniform": [-0.5, 0.5]},
        "agents.rov.sensors.dvl.orientation_deg.2": {"uniform": [30, 60]},
        "agents.rov.sensors.ranger.orientation_deg.1": {"uniform": [-20, 20]},
        "agents.rov.sensors.imu.error": {"uniform": [0.5, 3.0]}, "ocean.current_mps.0": {"uniform": [-0.3, 0.3]},
        "ocean.current_mps.2": {"uniform": [-0.1, 0.1]}, "props.crate.position_m.0": {"uniform": [3.0, 6.0]},
        "props.crate.orientation_deg.2": {"uniform": [-40, 40]},
        "ocean.waves.0.significant_height_m": {"uniform": [0.3, 1.0]},
        "ocean.waves.1.towards_deg": {"uniform": [-180, 180]},
    },
}  # fmt: skip
GIVEN = np.array([[0.4, -0.1, 0.05, 0.2], [0.1, 0.2, -0.1, -0.3], [-0.2, 0.0, 0.1, 0.1]])


@pytest.fixture(scope="module")
def loaded() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO, n=3)


@pytest.fixture
def sim(loaded: pl.Simulation) -> pl.Simulation:
    loaded.reset()
    return loaded


def held(case: str, found: dict[str, Any]) -> None:
    """Compare what was found; what comes from rays is of single precision."""
    cast = {name for name in found if any(word in name for word in ("ranger", "dvl", "looks"))}
    check("runs", case, {name: values for name, values in found.items() if name not in cast}, DOUBLE)
    if cast:
        check("runs", f"{case}, by rays", {name: found[name] for name in sorted(cast)})


def joined(found: dict[str, Any]) -> dict[str, Any]:
    """The same topic of all copies, one after another."""
    names = dict.fromkeys(re.sub(r"/env\d", "", name) for name in found)
    return {name: np.concatenate([np.ravel(v) for n, v in found.items() if re.sub(r"/env\d", "", n) == name])
            for name in names}  # fmt: skip


def state_of(sim: pl.Simulation, moment: str) -> dict[str, Any]:
    """Motion of everybody, and where bodies stand; places from the agents' middle."""
    found: dict[str, Any] = {}
    for name in ("rov", "auv"):
        state = sim.state[name]
        parts = ("position", "attitude", "velocity", "angular_velocity")
        found |= {f"{moment}, {name} {part}": np.array(getattr(state, part)) for part in parts}
    bodies = [v for b in sim.bodies.bodies for part in ("position", "attitude", "velocity", "angular_velocity")
              for v in np.ravel(getattr(b, part))]  # fmt: skip
    return found | {f"{moment}, bodies": bodies, f"{moment}, copies": [*sim.episode, *sim.ended, sim.time_ns * 1e-9]}


def stepped(sim: pl.Simulation, ticks: int, moment: str) -> dict[str, Any]:
    found: dict[str, list[Any]] = {}
    for _ in range(ticks):
        for agent, readings in sim.step().items():
            for sensor, r in readings.items():
                for part, values in {"data": r.data, "truth": r.truth}.items():
                    found.setdefault(f"{moment}, {agent}.{sensor} {part}", []).append(
                        np.ravel(np.asarray(values, dtype=float))
                    )
                found[f"{moment}, {agent}.{sensor} data"].append([r.t_ns * 1e-9])
    return {name: np.concatenate(values) for name, values in found.items()}


def test_copies_that_begin_anew_one_by_one(sim: pl.Simulation, tmp_path: Path) -> None:
    found = {"drawn": [v for key in sorted(sim.drawn) for v in sim.drawn[key]]} | state_of(sim, "first")
    sim.command({"rov": GIVEN})
    found |= stepped(sim, 20, "at first") | state_of(sim, "then")
    sim.set_state("rov", position=[2.0, -3.5, -4.0], attitude=[0.9, 0.1, -0.2, 0.3], velocity=[0.3, -0.1, 0.2],
                  angular_velocity=[0.1, 0.2, -0.3], where=[0, 2])  # fmt: skip
    sim.set_state("auv", velocity=[[0.9, 0.1, 0.0], [1.3, -0.1, 0.1]], where=[1])
    spawned = sim.spawn(
        pl.Prop("cylinder", position=(3.0, -1.0, -4.0), size=(0.5, 0.7, 1.2), attitude=(0.9, 0.3, 0.1, 0.2))
    )
    spawned.move(position=np.array([[3.0, -1.0, -4.0], [4.0, -3.0, -5.0], [2.0, -5.0, -3.0]]), velocity=(0.2, -0.1,
        0.3),
                 angular_velocity=(0.3, 0.1, -0.2))  # fmt: skip
    sim.props["ball"].move(position=(-1.0, -4.0, -5.0), attitude=(0.8, 0.2, 0.5, -0.1))
    found |= stepped(sim, 10, "placed")
    kept = sim.checkpoint()
    kept.save(tmp_path / "kept.npz")
    sim.reset(where=[1])
    sim.command({"rov": GIVEN[::-1]})
    found |= {"drawn again": [v for key in sorted(sim.drawn) for v in sim.drawn[key]]} | stepped(sim, 20, "anew")
    found |= state_of(sim, "anew")
    found |= {"looks": np.concatenate([np.ravel(r.data) for copy in (0, 2) for r in sim.observe(
        "rov", [[1.0, -2.0, -5.0], [2.5, -6.0, -4.0]], (0.9, -0.1, 0.2, 0.4), velocity=(0.3, 0.1, -0.2), copy=copy,
        sensors=["ranger", "dvl"], episode=2).values()])}  # fmt: skip
    fork = sim.fork()
    fork.step({"rov": -GIVEN}, ticks=7)
    found |= state_of(fork, "forked")
    sim.restore(Checkpoint.load(tmp_path / "kept.npz"))
    sim.step(ticks=5)
    found |= state_of(sim, "restored")
    sim.reset(episode=2, environment=1, seed=8)
    found |= state_of(sim, "another")
    sim.reset(environment=0, seed=6)
    held("one by one", found)


ORDERS = [
    Order("setpoint", "rov", {"surge_speed": 0.3}), Order("velocity", "rov", {"values": [0.2, -0.1, 0.1, 0.0, 0.0,
    0.2]}),
    Order("wrench", "rov", {"values": [20.0, -9.0, 7.0, 0.4, -0.6, 1.1]}),
    Order("pose", "rov", {"values": [3.0, -2.0, -5.0, 0.0, 0.1, 0.8]}),
    Order("waypoint", "rov", {"values": [5.0, 1.0, -6.0]}), Order("mode", "rov", {"mode": "velocity"}),
    Order("command", "rov", {"values": [0.3, 0.1, 0.05, -0.2]}),
    Order("velocity", "auv[0]", {"values": [1.2, 0.0, 0.0, 0.0, 0.0, 0.3], "since_s": 0.1}),
    Order("velocity", "auv[0]", {"values": [1.4, 0.0, 0.0, 0.0, 0.0, -0.5], "since_s": 0.4}),
    Order("waypoint", "auv[1]", {"values": [40.0, -33.0, -8.0], "speed": 1.3}),
    Order("setpoint", "auv[1]", {"heading": 0.6}),
    Order("state", "auv[1]", {"position": [14.0, 3.0, -6.0], "velocity": [0.8, 0.1, 0.0]}),
    Order("spawn", "buoy", {"shape": "cone", "position": [6.0, 3.0, -5.0], "size": [0.5, 0.6, 0.9]}),
    Order("remove", "buoy"), Order("ocean", "", {"current": [0.15, -0.25, 0.02]}),
]  # fmt: skip


def test_orders_and_callbacks(sim: pl.Simulation) -> None:
    found: dict[str, Any] = {}
    heard: list[float] = []
    with (
        sim.on_tick(lambda s: heard.append(s.time_ns * 1e-9), rate_hz=7.0),
        sim.subscribe("rov.depth", lambda r: heard.extend([r.t_ns * 1e-9, *np.ravel(r.data)])),
        sim.subscribe("auv[1].dvl", lambda r: heard.append(float(np.ravel(r.data)[0])), invalid=True),
    ):
        for k, order in enumerate(ORDERS):
            apply(order, sim)
            for agent in ("rov", "auv[0]", "auv[1]"):
                found[f"{k} {agent}"] = sim.held_command(agent)
            sim.step(ticks=3)
    found |= state_of(sim, "ordered") | {"heard": heard}
    boxes = sim.boxes_3d(copy=2)
    found["boxes"] = [v for key in sorted(boxes) for part in vars(boxes[key]).values() if not isinstance(part, str)
                      for v in np.ravel(np.asarray(part, dtype=float))]  # fmt: skip
    sim.reset()
    sim.ocean.set(current=None)
    held("orders", found)


def test_what_falls(sim: pl.Simulation) -> None:
    """Onto the ground, onto a box that stands askew, and onto a vehicle, which it pushes aside."""
    falls = []
    sim.set_state("rov", position=[[1.1, -3.1, -12.4], [1.0, -3.7, -12.5], [1.3, -3.5, -12.3]])
    for place, size in (((20.0, 11.0, -11.0), 0.6), ((9.2, -5.0, -1.0), 0.5), ((1.0, -3.4, -11.8), 0.7)):
        body = sim.spawn(pl.Prop("box", position=place, size=(size, 1.3 * size, 0.8)))
        falls.append(Falling(body, 0.4, radius=0.5))
    for _ in range(45):
        for falling in falls:
            falling.step(sim, 0.02)
    places = {str(k): [*np.ravel(f.body.position), *np.ravel(f.body.velocity), f.rests] for k, f in enumerate(falls)}
    held("what falls", places | state_of(sim, "fallen"))


def test_what_touches(sim: pl.Simulation) -> None:
    """Two hulls that meet askew, and a third that is driven against a box, in every copy in another way."""
    nose, tail = [30.0, 20.0, -6.0], [30.9, 20.1, -6.05]
    sim.set_state(
        "auv", position=[nose, tail], attitude=[[0.95, 0.05, -0.1, 0.3], [0.9, -0.1, 0.1, -0.4]],
        velocity=[[[1.2, 0.3, -0.1], [-0.6, 0.2, 0.1]], [[0.9, -0.4, 0.2], [0.2, 0.5, 0.0]], [[1.5, 0.1, 0.0],
            [-1.1, 0.0, 0.2]]],
        angular_velocity=[[0.2, -0.3, 0.4], [0.5, 0.1, -0.6]],
    )  # fmt: skip
    sim.set_state("rov", position=[[7.4, -5.6, -6.0], [9.1, -3.0, -7.0], [9.0, -6.0, -2.2]], attitude=[0.9, 0.1,
        0.2, -0.3],
                  velocity=[[0.9, -0.3, 0.1], [-0.5, -0.8, 0.0], [0.2, 0.3, -1.0]])  # fmt: skip
    sim.command({"rov": GIVEN})
    found = {}
    for moment in ("met", "parted"):
        sim.step(ticks=12)
        found |= state_of(sim, moment)
    check("runs", "what touches", found)  # the rays that find where hulls meet are of single precision


def test_a_copy_that_ends_alone(sim: pl.Simulation) -> None:
    sim.step(ticks=4)
    sim.set_state("rov", velocity=[1e170, 0.0, 0.0], where=[1])
    with pytest.warns(EndedWarning):
        sim.step(ticks=6)
    found = state_of(sim, "ended")
    sim.reset(where=[1])
    sim.step(ticks=5)
    held("an end", found | state_of(sim, "anew"))


def told_by(recording: Recording) -> dict[str, Any]:
    """Times and numbers of every topic: of motions all fields, of the others how large they are and how they add up."""
    found: dict[str, Any] = {}
    for topic in recording.channels:
        t = recording.times(topic) * 1e-9
        if recording.channels[topic].type == "nav_msgs/msg/Odometry" and len(t):
            found[topic] = recording.table(topic, [f for f in ODOMETRY_FIELDS if "stamp" not in f])[1]
        found[f"{topic} times"] = t
        found[f"{topic} sizes"] = [len(m.raw) for m in recording.messages(topic)]
    return found


def test_recordings_are_read_back(sim: pl.Simulation, tmp_path: Path) -> None:
    """A run that is recorded, killed, and goes on from a checkpoint in the same file."""
    path = tmp_path / "run.mcap"
    with sim.recording(path) as recorder:
        sim.command({"rov": GIVEN})
        sim.step(ticks=20)
        sim.props["crate"].move(position=(2.0, -5.0, -6.0), velocity=(0.1, 0.2, -0.1), angular_velocity=(0.2, 0.0, 0.3))
        sim.step(ticks=12)
        keep(sim, recorder, tmp_path)
        sim.step(ticks=8)
    whole = told_by(Recording(path))
    sim.restore(last_checkpoint(tmp_path))
    with resumed_recorder(path, sim) as recorder:
        sim.run(0.24, record=recorder)
    resumed = Recording(path)
    found = {f"{topic} resumed": values for topic, values in told_by(resumed).items() if topic in whole}
    groups = {topic: resumed.together(topic) for topic in resumed.groups if not topic.endswith("/plan")}
    for topic, table in groups.items():
        found |= {f"{topic} {key}": v for key, v in vars(table).items() if key in ("t_s", "values")}
    found["kept"] = [len(resumed.channels), len(resumed.attachments), resumed.complete, float(resumed.metadata["seed"])]
    held("recordings", joined(whole | found))
