"""A run with doors: what goes out, what comes in, and that the simulation is the same bytes with or without them."""

from __future__ import annotations

import gc
import hashlib
import threading
import time
import weakref
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.bridges.clerk import MOST, Clerk
from pelagos.bridges.door import TopicDoor
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.holoocean import listen_holoocean
from pelagos.bridges.inbox import LIMIT, Inbox
from pelagos.bridges.journal import TOPIC, Repeat, recorded_orders
from pelagos.bridges.outbox import Outbox
from pelagos.bridges.pace import SPIN_S, Pace
from pelagos.bridges.ros2 import Ros2Config
from pelagos.bridges.ros_commands import command_topics, listen
from pelagos.bridges.services import Services
from pelagos.bridges.transport import MemoryTransport
from pelagos.messages.store import deserialize, header, make, quaternion, serialize, vector3
from pelagos.sim.order import Order

SCENARIO: dict[str, Any] = {
    "seed": 3,
    "tick_rate_hz": 100,
    "world": {"type": "flat", "depth_m": 20.0},
    "agents": {
        "rov": {
            "vehicle": "bluerov2_heavy",
            "start": {"position_m": [3, -2], "depth_m": 5.0, "heading_deg": 20},
            "control": "velocity",
            "command": [0.2, 0.0, 0.0, 0.0],
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 100},
                "dvl": {"type": "dvl", "rate_hz": 10},
                "depth": {"type": "depth", "rate_hz": 50},
            },
        }
    },
}
SI = "simulation_interfaces/srv/"


class Peer:
    """A team's stack: a thread that speaks over a transport while the simulation runs."""

    def __init__(self, exchange: Exchange, transport: MemoryTransport) -> None:
        self.exchange, self.transport = exchange, transport
        self.failure: BaseException | None = None

    def reach(self, seconds: float) -> None:
        end = time.monotonic() + 60
        while self.exchange.sim.time_ns < seconds * 1e9:
            assert time.monotonic() < end
            time.sleep(0.002)

    def say(self, topic: str, type_name: str, **fields: Any) -> None:
        self.transport.say(topic, serialize(type_name, make(type_name, **fields)))

    def call(self, service: str, type_name: str, **fields: Any) -> Any:
        request = serialize(f"{type_name}_Request", make(f"{type_name}_Request", **fields))
        return deserialize(f"{type_name}_Response", self.transport.call(service, request))

    def talk(self, script: Callable[[Peer], None]) -> threading.Thread:
        def run() -> None:
            try:
                script(self)
            except BaseException as error:
                self.failure = error
                self.exchange.sim.resume()
                self.exchange.sim.stop()

        thread = threading.Thread(target=run)
        thread.start()
        return thread


def exchange_of(sim: pl.Simulation, **options: Any) -> tuple[Exchange, MemoryTransport]:
    exchange, transport = Exchange(sim, **options), MemoryTransport()
    exchange.add(TopicDoor(transport))
    listen(transport, sim, exchange.inbox)
    services = Services(exchange)
    assert services.offer(transport)
    services.listen(transport)
    return exchange, transport


def talk(exchange: Exchange, transport: MemoryTransport, script: Callable[[Peer], None], **run: Any) -> Any:
    peer = Peer(exchange, transport)
    thread = peer.talk(script)
    try:
        result = exchange.run(**run)
    finally:
        thread.join(timeout=60)
    if peer.failure is not None:
        raise peer.failure
    return result


def digest(path: Path) -> dict[str, str]:
    """Times and bytes of every topic's messages, without the orders (which know the clock on the wall)."""
    found: dict[str, Any] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            seen = found.setdefault(channel.topic, hashlib.blake2b(digest_size=8))
            seen.update(message.log_time.to_bytes(8, "little") + message.data)
    return {topic: h.hexdigest() for topic, h in found.items() if topic != TOPIC}


@pytest.fixture(scope="module")
def sim() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


def twist(*values: float) -> dict[str, Any]:
    return {"linear": vector3(*values[:3]), "angular": vector3(*values[3:])}


def test_doors_change_no_byte(sim: pl.Simulation, tmp_path: Path) -> None:
    sim.reset()
    sim.run(1.0, record=tmp_path / "alone.mcap")
    sim.reset()
    exchange, transport = exchange_of(sim)
    exchange.run(1.0, record=tmp_path / "doors.mcap")
    exchange.close()
    assert transport.closed
    alone, with_doors = digest(tmp_path / "alone.mcap"), digest(tmp_path / "doors.mcap")
    assert alone == with_doors
    assert len(transport.written["/rov/imu/data_raw"]) == 101


def test_the_clock_goes_ahead_of_what_was_measured_and_never_back(sim: pl.Simulation) -> None:
    sim.reset()
    exchange, transport = exchange_of(sim)
    exchange.run(1.2)
    clock = 0
    for t_ns, topic in transport.order:
        if topic in ("/labels", "/tf_static"):
            continue
        if topic == "/clock":
            assert t_ns >= clock
            clock = t_ns
        else:
            assert t_ns - 10_000_000 < clock <= t_ns + 10_000_000, topic
    said = [deserialize("rosgraph_msgs/msg/Clock", raw).clock for _, raw in transport.written["/clock"]]
    seconds = [c.sec + c.nanosec * 1e-9 for c in said]
    assert seconds[0] == 0.0
    assert seconds[-1] == pytest.approx(1.2)
    assert max(np.diff(seconds)) <= 0.01 + 1e-9  # at least 100 Hz


def test_a_run_driven_from_outside_is_repeated_bit_for_bit(sim: pl.Simulation, tmp_path: Path) -> None:
    """Commands, set-points, a mode, a box in the DVL's way: told at moments that no one can foresee."""

    def script(peer: Peer) -> None:
        peer.reach(0.2)
        peer.say("/rov/cmd_vel", "geometry_msgs/msg/Twist", **twist(0.5, -0.1, 0.2, 0, 0, 0.3))
        peer.reach(0.5)
        peer.say("/rov/setpoint/heave_speed", "std_msgs/msg/Float64", data=-0.25)
        pose = make(
            "geometry_msgs/msg/Pose",
            position=make("geometry_msgs/msg/Point", x=2.2, y=3.1, z=-8.0),
            orientation=quaternion(),
        )
        stamped = make("geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose)
        box = make("simulation_interfaces/msg/Resource", uri="", resource_string='{"shape": "box", "size": 3.0}')
        made = peer.call(
            "/pelagos/spawn_entity", SI + "SpawnEntity", name="box", allow_renaming=False, entity_resource=box,
            entity_namespace="", initial_pose=stamped,
        )  # fmt: skip
        assert (made.result.result, made.entity_name) == (1, "box")
        peer.reach(0.8)
        wrench = make("geometry_msgs/msg/Wrench", force=vector3(20, -10, 5), torque=vector3(1, 2, -3))
        peer.say("/rov/cmd_wrench", "geometry_msgs/msg/WrenchStamped", header=header("rov/base_link"), wrench=wrench)
        assert peer.call("/pelagos/delete_entity", SI + "DeleteEntity", entity="box").result.result == 1

    sim.reset()
    exchange, transport = exchange_of(sim, realtime=1.0)
    talk(exchange, transport, script, seconds=1.2, record=tmp_path / "driven.mcap")
    end = sim.state["rov"].position
    orders = recorded_orders(tmp_path / "driven.mcap")
    assert [order.kind for _, order in orders] == ["velocity", "setpoint", "spawn", "wrench", "remove"]
    sim.reset()
    again = Exchange(sim)
    Repeat(sim, tmp_path / "driven.mcap", note=again.note)
    again.run(1.2, record=tmp_path / "again.mcap")
    assert recorded_orders(tmp_path / "again.mcap") == orders  # so that it can be repeated too
    assert (sim.state["rov"].position == end).all()
    assert digest(tmp_path / "driven.mcap") == digest(tmp_path / "again.mcap")


def test_commands_mean_what_ros_says(sim: pl.Simulation) -> None:
    """Forward-left-up and east-north-up go in, and the vehicle does that."""
    sim.reset()
    topics = command_topics(sim, "rov")

    def order(suffix: str, **fields: Any) -> Order:
        type_name, made = topics[suffix]
        return made(deserialize(type_name, serialize(type_name, make(type_name, **fields))))

    velocity = order("cmd_vel", **twist(1.5, -2.5, 3.5, 0.25, -0.5, 0.75))
    assert velocity.data["values"] == [1.5, -2.5, 3.5, 0.25, -0.5, 0.75]
    north = make("geometry_msgs/msg/Pose", position=make("geometry_msgs/msg/Point", x=4.0, y=7.0, z=-6.0),
                 orientation=quaternion(np.sqrt(0.5), 0, 0, np.sqrt(0.5)))  # fmt: skip
    pose = order("cmd_pose", header=header("map"), pose=north)
    # 4 m east is -4 m west; a yaw of 90 degrees in ENU looks north, which is 0 in NWU
    np.testing.assert_allclose(pose.data["values"], [7.0, -4.0, -6.0, 0, 0, 0], atol=1e-12)
    point = order("cmd_waypoint", header=header("map"), point=make("geometry_msgs/msg/Point", x=4.0, y=7.0, z=-6.0))
    assert point.data["values"] == [7.0, -4.0, -6.0]
    assert order("setpoint/yaw", data=0.5).data == {"yaw": 0.5}
    layout = make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
    eight = order("cmd_actuators", layout=layout, data=np.arange(8.0))
    assert eight.data == {"values": list(range(8)), "mode": "actuators"}


def test_a_twist_moves_the_vehicle_its_way(sim: pl.Simulation) -> None:
    sim.reset()
    exchange, transport = exchange_of(sim)
    peer = Peer(exchange, transport)
    peer.say("/rov/cmd_vel", "geometry_msgs/msg/Twist", **twist(0.3, 0.2, -0.15, 0, 0, 0.2))
    exchange.run(4.0)
    np.testing.assert_allclose(sim.state["rov"].velocity[0], [0.3, 0.2, -0.15], atol=0.05)
    assert sim.state["rov"].angular_velocity[0, 2] == pytest.approx(0.2, abs=0.05)


def test_a_wrench_to_port_pushes_to_port(sim: pl.Simulation) -> None:
    sim.reset()
    exchange, transport = exchange_of(sim)
    wrench = make("geometry_msgs/msg/Wrench", force=vector3(0, 30, 0), torque=vector3(0, 0, 2.0))
    Peer(exchange, transport).say(
        "/rov/cmd_wrench", "geometry_msgs/msg/WrenchStamped", header=header("rov/base_link"), wrench=wrench
    )
    exchange.run(0.5)
    assert sim.state["rov"].velocity[0, 1] > 0.05
    assert sim.state["rov"].angular_velocity[0, 2] > 0.05


def test_a_waypoint_is_reached(sim: pl.Simulation) -> None:
    sim.reset()
    exchange, transport = exchange_of(sim)
    goal = make("geometry_msgs/msg/Point", x=3.0, y=4.5, z=-6.0)  # 1 m east and 1.5 m north of the start, 1 m deeper
    Peer(exchange, transport).say(
        "/rov/cmd_waypoint", "geometry_msgs/msg/PointStamped", header=header("map"), point=goal
    )
    exchange.run(25.0)
    np.testing.assert_allclose(sim.state["rov"].position[0], [4.5, -3.0, -6.0], atol=0.25)


def test_bad_commands_are_refused_counted_and_said_once(sim: pl.Simulation) -> None:
    sim.reset()
    said: list[str] = []
    exchange, transport = exchange_of(sim, say=said.append)
    before = sim.held_command("rov")
    peer = Peer(exchange, transport)
    for _ in range(3):
        transport.say("/rov/cmd_vel", b"\0\1\0\0garbage")
        peer.say("/rov/cmd_vel", "geometry_msgs/msg/Twist", **twist(float("nan"), 0, 0, 0, 0, 0))
        exchange.inbox.drain()
    peer.say("/rov/cmd_mode", "std_msgs/msg/String", data="velocty")
    layout = make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
    peer.say("/rov/cmd_actuators", "std_msgs/msg/Float64MultiArray", layout=layout, data=np.ones(5))
    pose = make("geometry_msgs/msg/Pose", position=make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=-5.0),
                orientation=quaternion(0, 0, 0, 0))  # fmt: skip
    peer.say("/rov/cmd_pose", "geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose)
    exchange.run(0.1)
    refused = exchange.close()
    assert (sim.held_command("rov") == 0).all() or (sim.held_command("rov") == before).all()
    counts = dict(refused.items())
    assert sum(k for reason, k in counts.items() if "malformed" in reason) == 4
    assert sum(k for reason, k in counts.items() if "not a finite number" in reason) == 3
    assert any("did you mean 'velocity'" in reason for reason in counts)
    assert len(said) == len(set(said)) == len(counts)


@pytest.mark.parametrize(
    ("order", "told"),
    [(Order("spawn", "crate", {"shape": "box", "position": [1e300, 0.0, 0.0]}), "position of a spawn order is 1e+300"),
     (Order("spawn", "crate", {"shape": "box", "position": [0, -(10**400), 0]}), "at most 2.1e"),
     (Order("spawn", "crate", {"shape": "box", "sise": [1, 1, 1]}), "did you mean 'size'"),
     (Order("spawn", "crate", {"size": 1.0}), "a prop needs a shape: box"),
     (Order("state", "rov", {"position": [0.0, 3e7, -5.0]}), "at most 2.1e"),
     (Order("velocity", "rov", {"values": [0.0, 0.0, -2e9, 0.0, 0.0, 0.0]}), "at most 1e")],
)  # fmt: skip
def test_what_cannot_be_reckoned_with_is_refused(sim: pl.Simulation, order: Order, told: str) -> None:
    """A place as far as 1e300 m would have ended the run."""
    inbox = Inbox(sim)
    ticket = inbox.put(order)
    inbox.drain()
    assert told in ticket.wait()
    assert not sim.bodies.bodies


def test_an_order_that_is_not_reached_in_time_is_withdrawn(sim: pl.Simulation) -> None:
    """Its sender has been told that it failed: it must not be done later."""
    inbox = Inbox(sim)
    ticket = inbox.put(Order("mode", "rov", {"mode": "pose"}))
    assert "withdrawn" in ticket.wait(0.01)
    inbox.drain()
    assert inbox.obeyed["mode"] == 0
    done = inbox.put(Order("mode", "rov", {"mode": "pose"}))
    inbox.drain()
    assert done.wait(0.01) == ""
    assert inbox.obeyed["mode"] == 1


def test_a_flood_of_commands_leaves_the_newest(sim: pl.Simulation) -> None:
    sim.reset()
    inbox = Inbox(sim)
    for i in range(5000):
        inbox.put(Order("velocity", "rov", {"values": [i * 1e-4, 0, 0, 0, 0, 0]}))
    tickets = [inbox.put(Order("mode", "rov", {"mode": "velocity"})) for _ in range(LIMIT + 5)]
    assert [bool(t.refusal) for t in tickets].count(True) == 6  # one place is the twist's
    inbox.drain()
    assert inbox.obeyed["velocity"] == 1
    assert inbox.obeyed["mode"] == LIMIT - 1


def test_names_of_bodies_are_one_each_and_can_be_printed(sim: pl.Simulation) -> None:
    def script(peer: Peer) -> None:
        box = make("simulation_interfaces/msg/Resource", uri="", resource_string='{"shape": "box", "size": 0.5}')
        place = make("geometry_msgs/msg/Point", x=2.2, y=30.1, z=-8.0)
        pose = make("geometry_msgs/msg/Pose", position=place, orientation=quaternion())
        stamped = make("geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose)
        said = {"entity_resource": box, "entity_namespace": "", "initial_pose": stamped}

        def spawn(name: str, renaming: bool = False) -> tuple[int, str]:
            made = peer.call(
                "/pelagos/spawn_entity", SI + "SpawnEntity", name=name, allow_renaming=renaming, **said
            )  # fmt: skip
            return made.result.result, made.entity_name

        peer.reach(0.05)
        assert spawn("rov") == (101, "")  # NAME_NOT_UNIQUE: the vehicle's
        assert spawn("rov", renaming=True) == (1, "rov_1")
        assert spawn("rov", renaming=True) == (1, "rov_2")
        assert spawn("rov_1") == (101, "")
        assert spawn("\x1b[2J") == (102, "")  # NAME_INVALID: it would clear the terminal that tells of it
        assert spawn("") == (1, "body1")
        assert peer.call("/pelagos/delete_entity", SI + "DeleteEntity", entity="body1").result.result == 1
        assert spawn("") == (1, "body1")
        found = peer.call("/pelagos/get_entities", SI + "GetEntities", filters=make(
            "simulation_interfaces/msg/EntityFilters", filter="", categories=[], tags=make(
                "simulation_interfaces/msg/TagsFilter", tags=[], filter_mode=0),
            bounds=make("simulation_interfaces/msg/Bounds", type=0, points=[])))  # fmt: skip
        assert found.entities == ["rov", "rov_1", "rov_2", "body1"]
        peer.exchange.sim.stop()

    sim.reset()
    exchange, transport = exchange_of(sim, realtime=1.0)
    talk(exchange, transport, script, seconds=60.0)
    sim.reset()


def test_pose_and_twist_of_a_state_are_in_the_frame_of_its_header(sim: pl.Simulation) -> None:
    """EntityState.msg: "Frame and timestamp for pose and twist"; in `map`, which is east-north-up."""
    sim.reset()
    to_enu = Rotation.from_euler("z", 90, degrees=True)  # of components along north, west, up
    turn = Rotation.from_euler("ZYX", [70.0, -20.0, 35.0], degrees=True)
    x, y, z, w = turn.as_quat()
    drum = sim.spawn(pl.Prop("cylinder", position=(4.0, -3.0, -2.0), attitude=(w, x, y, z)), name="drum")
    velocity, spin = np.array([0.4, -0.7, 0.2]), np.array([0.1, 0.3, -0.5])
    drum.move(velocity=velocity, angular_velocity=spin)
    sim.set_state("rov", attitude=(w, x, y, z), velocity=velocity, angular_velocity=spin)  # in its own axes
    exchange, transport = exchange_of(sim)
    exchange.do = lambda action: action() or True  # type: ignore[method-assign]
    peer = Peer(exchange, transport)
    for entity, world in (("drum", [velocity, spin]), ("rov", turn.apply([velocity, spin]))):
        state = peer.call("/pelagos/get_entity_state", SI + "GetEntityState", entity=entity).state
        told = [[getattr(v, c) for c in "xyz"] for v in (state.twist.linear, state.twist.angular)]
        assert state.header.frame_id == "map"
        np.testing.assert_allclose(told, to_enu.apply(world), atol=1e-12)
    drum.remove()


@pytest.mark.parametrize(("frame", "pose"), [("map", False), ("", True), ("rov/base_link", False)])
def test_a_twist_is_set_in_the_frame_of_its_header(
    sim: pl.Simulation, monkeypatch: pytest.MonkeyPatch, frame: str, pose: bool
) -> None:
    sim.reset()
    turn = Rotation.from_euler("ZYX", [70.0, -20.0, 35.0], degrees=True)
    x, y, z, w = turn.as_quat()
    if not pose:
        sim.set_state("rov", attitude=(w, x, y, z))
    exchange, transport = exchange_of(sim)
    exchange.do = lambda action: action() or True  # type: ignore[method-assign]
    kept: list[Any] = []

    class Told:
        def wait(self) -> str:
            return ""

    monkeypatch.setattr(exchange.inbox, "put", lambda order: kept.append(order) or Told())
    to_enu = Rotation.from_euler("z", 90, degrees=True)
    linear, angular = np.array([0.5, 0.25, -0.1]), np.array([-0.2, 0.1, 0.3])
    a, b, c, d = (to_enu * turn).as_quat()
    state = make(
        "simulation_interfaces/msg/EntityState", header=header(frame),
        pose=make("geometry_msgs/msg/Pose", position=make("geometry_msgs/msg/Point", x=1.0, y=2.0, z=-5.0),
                  orientation=make("geometry_msgs/msg/Quaternion", x=a, y=b, z=c, w=d)),
        twist=make("geometry_msgs/msg/Twist", linear=vector3(*linear), angular=vector3(*angular)),
        acceleration=make("geometry_msgs/msg/Accel", linear=vector3(), angular=vector3()),
    )  # fmt: skip
    peer = Peer(exchange, transport)
    asked = {"entity": "rov", "set_pose": pose, "set_twist": True, "set_acceleration": False}
    assert peer.call("/pelagos/set_entity_state", SI + "SetEntityState", state=state, **asked).result.result == 1
    own = frame == "rov/base_link"
    for key, told in (("velocity", linear), ("angular_velocity", angular)):
        expected = told if own else (to_enu * turn).inv().apply(told)
        np.testing.assert_allclose(kept[-1].data[key], expected, atol=1e-12)
    state.header.frame_id = "odom"
    refused = peer.call("/pelagos/set_entity_state", SI + "SetEntityState", state=state, **asked).result
    assert (refused.result, "'odom'" in refused.error_message) == (0, True)


def test_a_state_that_is_not_reached_in_time_is_no_missing_entity(
    sim: pl.Simulation, monkeypatch: pytest.MonkeyPatch
) -> None:
    exchange, transport = exchange_of(sim)
    monkeypatch.setattr(exchange, "do", lambda action: False)  # as in a run that is being built anew
    state = Peer(exchange, transport).call("/pelagos/get_entity_state", SI + "GetEntityState", entity="rov")
    assert (state.result.result, "boundary of steps" in state.result.error_message) == (4, True)


def test_reasons_that_peers_choose_do_not_fill_memory(sim: pl.Simulation) -> None:
    inbox = Inbox(sim)
    for number in range(3000):
        inbox.refuse(f"unknown body {number!r}")
    assert len(inbox.refused) <= 1001
    assert inbox.refused.total() == 3000


def test_services_pause_step_and_reset(sim: pl.Simulation, tmp_path: Path) -> None:
    def script(peer: Peer) -> None:
        peer.reach(0.1)
        state = peer.call("/pelagos/get_simulation_state", SI + "GetSimulationState",
                          structure_needs_at_least_one_member=0)  # fmt: skip
        assert (state.state.state, state.result.result) == (1, 1)
        assert peer.call("/pelagos/step_simulation", SI + "StepSimulation", steps=5).result.result == 3  # not paused
        assert peer.call("/pelagos/set_paused", "std_srvs/srv/SetBool", data=True).success
        time.sleep(0.2)
        before = peer.exchange.sim.time_ns
        assert peer.call("/pelagos/step_simulation", SI + "StepSimulation", steps=7).result.result == 1
        many = peer.call("/pelagos/step_simulation", SI + "StepSimulation", steps=1 << 40).result
        assert (many.result, "1 to 1e9" in many.error_message) == (4, True)
        time.sleep(0.1)
        assert peer.exchange.sim.time_ns - before == 7 * peer.exchange.sim.dt_ns
        found = peer.call("/pelagos/get_entity_state", SI + "GetEntityState", entity="rov")
        p = found.state.pose.position
        np.testing.assert_allclose([p.x, p.y, p.z], [2.0, 3.0, -5.0], atol=0.2)  # x 3 north, y -2 west
        o = found.state.pose.orientation
        yaw = np.degrees(2 * np.arctan2(o.z, o.w))
        assert yaw == pytest.approx(90 - 20, abs=1)  # a compass heading of 20 is 70 degrees from east
        assert peer.call("/pelagos/get_entity_state", SI + "GetEntityState", entity="rva").result.result == 2
        playing = make("simulation_interfaces/msg/SimulationState", state=1)
        again = peer.call("/pelagos/set_simulation_state", SI + "SetSimulationState", state=playing)
        assert again.result.result == 1
        told = peer.call("/pelagos/set_control_mode", "pelagos_msgs/srv/SetControlMode", agent="rov", mode="pose")
        assert told.success
        moved = make(
            "simulation_interfaces/msg/EntityState", header=header("map"), pose=found.state.pose,
            twist=make("geometry_msgs/msg/Twist", linear=vector3(0.5, 0.25, -0.1), angular=vector3()),
            acceleration=make("geometry_msgs/msg/Accel", linear=vector3(), angular=vector3()),
        )  # fmt: skip
        placed = peer.call("/pelagos/set_entity_state", SI + "SetEntityState", entity="rov", state=moved,
                           set_pose=True, set_twist=True, set_acceleration=False)  # fmt: skip
        assert placed.result.result == 1
        peer.say("/sim/reset", "std_msgs/msg/Empty", structure_needs_at_least_one_member=0)

    sim.reset()
    exchange, transport = exchange_of(sim, realtime=1.0)
    result = talk(exchange, transport, script, seconds=30.0, record=tmp_path / "one.mcap")
    assert (result.ended, exchange.reset_asked) == ("stopped", True)
    assert result.simulated_s < 10
    sim.reset()
    transport.written["/clock"].clear()
    exchange.run(0.1)
    assert transport.written["/clock"][0][0] == 0  # time began anew
    exchange.close()


def test_the_water_is_set_while_a_run_goes_on(tmp_path: Path) -> None:
    """`values` are east, north, up; the run repeats bit for bit."""
    agents = {"a": {"vehicle": "bluerov2", "start": {"position_m": [1, -2], "depth_m": 5.0}}}
    scenario = {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 20.0}, "agents": agents}
    sim = pl.Simulation.load(scenario)
    told: list[Any] = []

    def script(peer: Peer) -> None:
        peer.reach(0.1)
        for name, values in (("current", [0.3, 0.5, 0.1]), ("curent", [1.0]), ("current", [1.0, 2.0]),
                             ("turbidity", [2.5]), ("current", [0.25, -0.5, 0.0])):  # fmt: skip
            told.append(
                peer.call("/pelagos/set_ocean", "pelagos_msgs/srv/SetOcean", name=name, values=np.array(values))
            )
            if len(told) == 1:
                told.append(np.array(sim.stepper.own_current).ravel().tolist())
        peer.reach(sim.time_ns * 1e-9 + 1.0)
        sim.stop()

    exchange, transport = exchange_of(sim, realtime=1.0)
    talk(exchange, transport, script, seconds=15.0, record=tmp_path / "one.mcap")
    exchange.close()
    first, current, unknown, short, turbid, second = told
    assert (first.success, turbid.success, second.success) == (True, True, True)
    assert current == [0.5, -0.3, 0.1]
    assert "did you mean 'current'" in unknown.message
    assert "given (2,)" in short.message
    end, ticks = sim.state["a"].position, sim.time_ns // sim.dt_ns
    again = pl.Simulation.load(scenario)
    Repeat(again, tmp_path / "one.mcap")
    again.run(ticks / 50)
    assert (again.state["a"].position == end).all()


def test_holooceans_nodes_drive_a_torpedo() -> None:
    """HoloOcean's heading is in degrees, counter-clockwise from north."""
    scenario = {"world": {"type": "flat", "depth_m": 50.0}, "agents": {"auv0": {
        "vehicle": "torpedo", "start": {"position_m": [0, 0], "depth_m": 5.0}}}}  # fmt: skip
    sim = pl.Simulation.load(scenario)
    exchange, transport = Exchange(sim), MemoryTransport()
    listen_holoocean(transport, sim, exchange.inbox)
    services = Services(exchange)
    services.offer_holoocean(transport)
    peer = Peer(exchange, transport)
    desired = "holoocean_interfaces/msg/DesiredCommand"
    for name, value in (("depth", 7.0), ("heading", 40.0), ("speed", 900.0)):
        peer.say(f"/holoocean/{name}", desired, header=header("auv0"), data=value)
    exchange.inbox.drain()
    assert sim.stepper.mode("auv0") == "depth_heading"
    np.testing.assert_allclose(sim.held_command("auv0")[0], [7.0, -np.radians(40.0), 900.0])
    mode = "holoocean_interfaces/srv/SetControlMode"
    thread = threading.Thread(target=lambda: (time.sleep(0.1), exchange.inbox.drain()))
    thread.start()
    assert peer.call("/holoocean/control_mode", mode, vehicle_name="auv0", mode=0).success
    thread.join()
    assert sim.stepper.mode("auv0") == "actuators"
    peer.say("/holoocean/command/agent", "holoocean_interfaces/msg/AgentCommand", header=header("auv0"),
             command=np.array([0.1, 0.1, -0.1, -0.1, 500.0]))  # fmt: skip
    exchange.inbox.drain()
    np.testing.assert_allclose(sim.held_command("auv0")[0], [0.1, 0.1, -0.1, -0.1, 500.0])


class Ring:
    """Garbage that only a collection finds."""

    def __init__(self, gone: Callable[[], None]) -> None:
        self.me = self
        weakref.finalize(self, gone)


def test_the_thread_that_steps_alone_collects_garbage(sim: pl.Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    """A peer's thread that let go of an array of the device would wait for ever for its lock."""
    monkeypatch.setattr("pelagos.sim.garbage.EVERY_S", 0.0)
    where: list[int] = []
    sim.reset()
    exchange, _ = exchange_of(sim, rate_hz=100.0)

    def chatter() -> None:
        for _ in range(3000):  # four times as many objects as Python's own threshold
            Ring(lambda: where.append(threading.get_ident()))

    def chat(sim: pl.Simulation) -> None:
        assert not gc.isenabled()
        if sim.time_ns == 10 * sim.dt_ns:
            thread = threading.Thread(target=chatter)
            thread.start()
            thread.join()
            assert not where

    with sim.on_tick(chat):
        exchange.run(0.2)
    assert len(where) == 3000
    assert set(where) == {threading.get_ident()}
    exchange.close()
    assert gc.isenabled()


def test_a_long_answer_holds_up_no_other() -> None:
    """Each service has a clerk of its own, which the first request starts."""
    troubles: Counter[str] = Counter()
    slow, quick = Clerk("/slow", troubles), Clerk("/quick", troubles)
    gate, done = threading.Event(), threading.Event()

    def spoilt() -> None:
        raise ValueError("no message")

    slow.ask(gate.wait)
    slow.ask(spoilt)
    quick.ask(done.set)
    assert done.wait(30)
    for _ in range(MOST + 5):
        slow.ask(gate.wait)
    assert troubles["/slow: more than 100 requests wait"] >= 5
    again = threading.Event()
    gate.set()
    while not again.is_set():
        slow.ask(again.set)
        again.wait(0.05)
    assert troubles["requests without an answer (ValueError)"] == 1
    for clerk in (slow, quick):
        clerk.close()


def test_a_queue_that_nobody_empties_drops_its_oldest() -> None:
    outbox, gate, written = Outbox("test"), threading.Event(), []

    def slow(raw: Any, t_ns: int) -> None:
        gate.wait()
        written.append(t_ns)

    put = outbox.lane("/a", slow, 3)
    for i in range(100):  # every one returns, though nothing is written before the gate opens
        put(b"x", i)
    assert not written
    gate.set()
    outbox.close(5.0)
    assert written[-3:] == [97, 98, 99]
    assert outbox.dropped["/a"] == 100 - len(written)


def test_a_transport_that_fails_is_counted() -> None:
    outbox = Outbox("test")

    def broken(raw: Any, t_ns: int) -> None:
        raise OSError("no route")

    outbox.lane("/a", broken, 3)(b"x", 0)
    outbox.close(5.0)
    assert list(outbox.failed) == ["/a: OSError: no route"]


def test_the_pace_waits_and_gives_up_what_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a clock of the test's own, of which every look takes a millisecond."""
    now, slept = [50.0], []

    def look() -> float:
        now[0] += 0.001
        return now[0]

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    monkeypatch.setattr("pelagos.bridges.pace.time.perf_counter", look)
    monkeypatch.setattr("pelagos.bridges.pace.time.sleep", sleep)
    pace = Pace(2.0)
    pace.restart(0)
    pace.keep(200_000_000)
    assert slept == pytest.approx([0.1 - 0.001 - SPIN_S])
    assert pace.late[-1] < 0.01
    now[0] += 0.4
    pace.keep(210_000_000)  # 0.4 s late, less the 5 ms that 10 ms take at twice the speed: counted, not made up for
    assert pace.lost_s == pytest.approx(0.395, abs=0.01)
    pace.keep(310_000_000)
    assert sum(slept[1:]) == pytest.approx(0.05, abs=0.005)


@pytest.mark.parametrize("bad", [{"node": "no spaces"}, {"domain_id": 500}, {"transport": "tcp"}, {"tf": True}])
def test_a_wrong_configuration_is_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(pl.PelagosError):
        pl.Simulation.load({**SCENARIO, "bridges": {"ros": {"type": "ros2", **bad}}})


def test_frames_may_be_left_to_an_estimator(sim: pl.Simulation) -> None:
    sim.reset()
    transport = MemoryTransport()
    exchange = Exchange(sim)
    exchange.add(TopicDoor(transport, clock=False, only=("/tf", "/rov/imu"), skip=("/tf",)))
    exchange.run(0.1)
    assert set(transport.written) == {"/tf_static", "/rov/imu/data_raw"}
    assert Ros2Config(type="ros2", tf="mounts").tf == "mounts"
