"""No copy of a fleet says anything of another: what three unlike copies say by any way is what each says alone.

Starts, hulls, mounts, errors, lamps, seas, currents and props are drawn apart; commands, places, pushes and packets
differ. The copy that is alone also lacks the twins of its sensors, which stand before them, and moves, asks and records
the members of its group one by one: no second sensor of a kind and no second member may be taken for the first.
"""

from __future__ import annotations

import copy as copies_of
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.machinery import Machinery
from pelagos.bridges.tap import Tap
from pelagos.config.swarm import topic_name
from pelagos.messages.store import deserialize
from pelagos.sim import model as sim_model
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording
from pelagos.viewer.live import Live

Said = dict[str, list[Any]]
TWINS = {
    "first_imu": {"type": "imu", "rate_hz": 20, "position_m": [-0.2, 0.1, 0.0], "orientation_deg": [90, 0, 10]},
    "first_depth": {"type": "depth", "rate_hz": 10, "position_m": [0.0, 0.0, 0.4]},
    "first_dvl": {"type": "dvl", "rate_hz": 5, "position_m": [0.3, 0.0, 0.0]},
    "first_ranger": {"type": "range_finder", "rate_hz": 10, "azimuth_deg": [100.0, 5.0], "elevation_deg": [-70.0, 3.0]},
}  # fmt: skip
ECHO = {"type": "singlebeam", "rate_hz": 5, "bins": 24, "rays": 16, "hears": "others", "orientation_deg": [4, -9, 0]}
MODEM = {"type": "modem", "rate_hz": 10, "bit_rate_bps": 2000.0, "preamble_s": 0.02, "position_m": [0.1, 0.0, 0.2]}
LOUD = {"type": "thrusters", "level_db": 165.0}
ROV: dict[str, Any] = {
    "vehicle": "bluerov2_heavy", "control": "velocity", "radiated_noise": LOUD,
    "start": {"position_m": [1.0, -3.0, -4.5], "pitch_deg": 4.0, "heading_deg": 35.0, "speed_mps": 0.2},
    "sensors": {
        **TWINS,
        "imu": {"type": "imu", "rate_hz": 10, "position_m": [0.1, -0.05, 0.02], "orientation_deg": [3, -4, 50]},
        "depth": {"type": "depth", "rate_hz": 20, "position_m": [0.2, 0.1, -0.1]},
        "dvl": {"type": "dvl", "rate_hz": 5, "position_m": [-0.2, 0.1, -0.1], "orientation_deg": [0, 0, 45]},
        "ranger": {"type": "range_finder", "rate_hz": 10, "range_max_m": 25.0, "azimuth_deg": [0.0, 25.0],
                   "elevation_deg": [-40.0, -10.0], "position_m": [0.3, 0.0, 0.1]},
        "camera": {"type": "camera", "rate_hz": 2, "width_px": 16, "height_px": 16, "orientation_deg": [0, 60, 0],
                   "lamps": [{"position_m": [0.3, 0.1, 0.2], "flux_lm": 900.0}]},
        "flow": {"type": "current_meter", "rate_hz": 5}, "echo": ECHO, "modem": MODEM,
    },
}  # fmt: skip
AUV: dict[str, Any] = {
    "vehicle": "remus100", "count": 2, "navigation": {"type": "ekf"}, "radiated_noise": LOUD,
    "start": {"position_m": [12.0, -20.0], "depth_m": 5.0, "heading_deg": -50.0, "speed_mps": 1.1,
              "spacing_m": [9.0, 14.0]},
    "mission": [{"type": "waypoints", "points": [[50.0, -21.0]], "depth_m": 7.0,
                 "until": {"sensor": "depth", "above": 5.5}},
                {"type": "waypoints", "points": [[31.0, 12.0]], "depth_m": 3.0}],
    "sensors": {"imu": {"type": "imu", "rate_hz": 20}, "depth": {"type": "depth", "rate_hz": 10},
                "dvl": {"type": "dvl", "rate_hz": 5}, "touch": {"type": "collision", "rate_hz": 10}, "modem": MODEM,
                "echo": ECHO},
    "distributions": {"start.depth_m": {"uniform": [3.0, 8.0]}},
}  # fmt: skip
SCENARIO: dict[str, Any] = {
    "seed": 6, "tick_rate_hz": 20, "record": {"state_rate_hz": 10, "groups": "together", "commands": True},
    "world": {
        "type": "flat", "depth_m": 13.0, "size_m": [200.0, 160.0],
        "movers": [{"name": "fish", "body": "sphere", "size_m": 1.4, "path": {"kind": "circle", "centre_m": [5, -2, -4],
                    "radius_m": 2.5, "speed_mps": 0.9}}],
    },
    "ocean": {"waves": {"type": "regular", "height_m": 0.4, "period_s": 4.0, "towards_deg": 30.0},
              "sun": {"elevation_deg": 20}},
    "props": {"crate": {"shape": "box", "position_m": [4.0, -4.0, -5.0], "size_m": [0.8, 1.3, 0.6]},
              "ball": {"shape": "sphere", "position_m": [15.0, -15.0, -9.0], "size_m": 0.3, "material": "steel"}},
    "agents": {"rov": ROV, "auv": AUV},
    "vary": {
        "agents.rov.start.position_m.1": {"normal": [-3.0, 0.7]},
        "agents.rov.start.heading_deg": {"uniform": [-30, 60]},
        "agents.rov.factors.mass": {"uniform": [0.9, 1.1]}, "agents.rov.factors.thrust": {"uniform": [0.8, 1.2]},
        "agents.rov.sensors.dvl.position_m.0": {"uniform": [-0.5, 0.5]},
        "agents.rov.sensors.ranger.orientation_deg.1": {"uniform": [-20, 20]},
        "agents.rov.sensors.imu.error": {"uniform": [0.5, 3.0]},
        "agents.rov.sensors.camera.lamps": {"uniform": [0.5, 2.0]},
        "ocean.current_mps.0": {"uniform": [-0.3, 0.3]}, "ocean.waves.0.height_m": {"uniform": [0.2, 0.8]},
        "props.crate.position_m.0": {"uniform": [3.0, 6.0]}, "props.crate.orientation_deg.2": {"uniform": [-40, 40]},
    },
}  # fmt: skip
N = 3
GIVEN = np.array([[0.4, -0.1, 0.05, 0.2], [0.1, 0.2, -0.1, -0.3], [-0.2, 0.0, 0.1, 0.1]])
PLACES = np.array([  # in the last copy one meets the other
    [[12.0, -20.0, -5.0], [21.0, -6.0, -6.0]], [[13.7, -20.8, -6.0], [20.0, -7.0, -4.0]],
    [[11.0, -18.0, -4.5], [11.3, -17.8, -4.4]],
])  # fmt: skip
BELOW = np.array([[0.5, 0.4, -2.8], [0.4, 0.3, -2.2], [0.5, 0.5, -3.1]])  # what a second member's echo sounder meets
SPEEDS = np.array([[0.4, -0.1, 0.1], [-0.3, 0.2, 0.0], [0.1, 0.4, -0.2]])
CRATES = np.array([[3.0, -2.0, -5.0], [2.5, -4.5, -4.0], [4.0, -1.0, -6.0]])
CURRENTS = np.array([[0.1, -0.2, 0.0], [-0.2, 0.1, 0.05], [0.0, 0.3, -0.05]])
LOOKING = ("imu", "depth", "dvl", "ranger", "camera", "flow", "echo")
LOOKS = np.array([[1.0, -2.0, -5.0], [2.5, -6.0, -4.0], [3.0, 1.0, -3.0], [0.0, 0.0, -8.0]])


ALIKE = {"rov contact"} | {f"auv[{i}] is at {what}" for i in (0, 1) for what in ("since_s", "memory", "begun")}
"""What is the same in all copies: nothing touches the ROV, and missions begin together."""


def alone() -> pl.Simulation:
    made = copies_of.deepcopy(SCENARIO)
    for name in TWINS:
        del made["agents"]["rov"]["sensors"][name]
    made["record"]["groups"] = "by_member"
    return pl.Simulation.load(made)


def part(values: Any, k: int, n: int) -> Any:
    """Of one copy, where they are by copy; bytes, or words where they are objects."""
    array = np.asarray(values)
    own = array[k] if array.ndim and len(array) == n else array
    return repr(own) if array.dtype == object else np.ascontiguousarray(own).tobytes()


def flown(sim: pl.Simulation, copies: list[int], path: Path) -> list[Said]:
    """Everything that is said of each of some copies in a run with recordings, orders, views and looks."""
    n, found = sim.n, [defaultdict[str, list[Any]](list) for _ in copies]

    def keep(name: str, values: Any) -> None:
        for k, said in enumerate(found):
            said[name].append(part(values, k, n))

    def reading(name: str, r: pl.Reading) -> None:
        for k, said in enumerate(found):
            if r.valid[k]:
                said[name] += [r.t_ns, *(part(values, k, n) for values in (r.data, r.truth, *r.extras.values()))]

    live = [Live(sim, copy=k) for k in range(n)]
    with ExitStack() as stack:
        stack.enter_context(sim.recording(path))
        for one in live:
            stack.enter_context(sim.watch(one.heard))
        sim.command({"rov": GIVEN[copies]})
        sim.set_state("auv", position=PLACES[copies])
        sim.props["ball"].move(position=PLACES[copies, 1] + BELOW[copies])
        for name in ("auv[0].touch", "auv[1].dvl"):
            stack.enter_context(sim.subscribe(name, lambda r, name=name: reading(f"{name}, subscribed", r)))
        sim.run(0.6)
        sim.ocean.set(current=CURRENTS[copies])
        sim.props["crate"].move(position=CRATES[copies], velocity=SPEEDS[copies])
        sim.set_state("rov", velocity=SPEEDS[copies])
        for agent, but in (("rov", 1), ("auv[1]", 0)):
            some = [k for k, c in enumerate(copies) if c != but]
            if some:
                assert sim.send(agent, "modem", b"of " + agent.encode(), where=some) == len(some)
        for tick in range(16):
            if tick == 5:
                sim.checkpoint()  # between two ticks of guidance: every member's navigation has its own part
            for agent, readings in sim.step().items():
                for name, r in readings.items():
                    reading(f"{agent}.{name}", r)
    for agent in ("rov", "auv", "auv[1]"):
        for name, values in vars(sim.state[agent]).items():
            keep(f"{agent} {name}", values)
        keep(f"{agent} held", sim.held_command(agent))
    for agent in sim.model.agents:
        keep(f"{agent} contact", sim.stepper.contact(agent))
    missions = sim.stepper.missions
    for agent, solutions in missions.solutions.items():
        for name in ("position", "attitude", "velocity", "rate"):
            keep(f"{agent} knows its {name}", getattr(solutions[-1], name))
    for agent, guidance in missions.guidance.items():
        for name, values in {**vars(guidance.progress), "begun": guidance.begun, "ended": guidance.ended}.items():
            keep(f"{agent} is at {name}", values)
    for key, values in sim.drawn.items():
        keep(f"drawn {key}", values)
    tap = Tap()
    Machinery(sim, tap).say(sim)
    machines = [(tap.channels[m.channel], m.data) for m in tap.take()]
    for k, said in enumerate(found):
        own = [(c.type, data) for c, data in machines if n == 1 or c.topic.startswith(f"/env{copies[k]}/")]
        told = [vars(deserialize(kind, bytes(data))) for kind, data in own]
        said["machinery"] = [repr({name: v for name, v in one.items() if name != "header"}) for one in told]
        said["boxes"] = [repr(box) for _, box in sorted(sim.boxes_3d(copy=k).items())]
        hits = sim.world.cast(CRATES - [2.0, 0.0, 0.0], np.tile([1.0, 0.0, 0.0], (N, 1)), 9.0, copy=k)
        said["rays"] = [np.asarray(values).tobytes() for values in vars(hits).values()]
        looks = sim.observe("rov", LOOKS, (0.9, -0.1, 0.2, 0.4), copy=k, sensors=LOOKING)
        said["looks"] = [r.truth.tobytes() for r in looks.values()]
        stream = copies[k] - sim.model.first_environment  # the lane whose noise is that of this copy
        there = np.tile(sim.state["auv[1]"].position[k] + [0.0, 0.1, 0.3], (N, 1))
        looks = sim.observe("auv[1]", there, copy=k, sensors=["imu", "depth", "dvl", "echo"])
        said["looks of a member"] = [np.ascontiguousarray(r.data[stream]).tobytes() for r in looks.values()]
        arrivals = pl.channel(sim, "rov.modem", "auv[1].modem", copy=k).arrivals()
        said["channel"] = [np.asarray(values).tobytes() for values in vars(arrivals).values()]
        live[k].show()
        said["view"] = shown(live[k])
    return [dict(said) for said in found]


def shown(live: Live) -> list[Any]:
    frame = live.take()
    assert frame is not None
    with np.printoptions(threshold=100_000, floatmode="unique"):
        samples = [
            (repr(s.sample), repr((s.pose.position, s.pose.attitude, s.pose.velocity)))  # actuators: of a block's end
            for s in sorted(frame.samples, key=lambda s: s.sample.name)
            if ".first_" not in s.sample.name
        ]
        return [repr(frame.agents), repr(frame.navigation), repr(frame.movers), *samples]


def recorded(path: Path, own: Callable[[str], bool]) -> Iterator[tuple[str, int, bytes]]:
    for m in Recording(path).messages():
        if own(m.topic) and "/first_" not in m.topic and not m.topic.startswith("/tf"):
            yield m.topic, m.t_ns, m.raw


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.filterwarnings("ignore::pelagos.errors.MountWarning")
def test_what_each_of_three_copies_says_is_what_it_says_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = flown(pl.Simulation.load(SCENARIO, n=N), [0, 1, 2], tmp_path / "fleet.mcap")
    names = {name for said in fleet for name in said}
    alike = {name for name in names if fleet[0].get(name) == fleet[1].get(name) == fleet[2].get(name)}
    assert alike == ALIKE
    monkeypatch.setattr(sim_model, "alike", lambda members, modes: [[name] for name in members])  # one by one
    one = alone()
    for k, said in enumerate(fleet[1:], start=1):
        one.ocean.set(current=None)
        one.reset(environment=k)
        path = tmp_path / f"{k}.mcap"
        with monkeypatch.context() as patch:  # names as in a fleet, so that messages are the same bytes
            patch.setattr(Recorder, "places", lambda self, agent, k=k: [f"env{k}/{topic_name(agent)}"])
            own = flown(one, [k], path)[0]
        wrong = [name for name, values in own.items() if values != said.get(name)]
        assert not wrong, f"copy {k}: {wrong}"
        mine, whole = (
            list(recorded(p, lambda topic, k=k: topic.startswith(f"/env{k}/"))) for p in (path, tmp_path / "fleet.mcap")
        )
        assert len({topic for topic, _, _ in mine}) > 25
        assert [m[:2] for m in mine] == [m[:2] for m in whole]
        assert not {a[0] for a, b in zip(mine, whole, strict=True) if a != b}
