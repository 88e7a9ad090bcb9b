"""How often MAVLink's doors speak, and what they say of a vehicle; outputs that are told once. No run, no peer."""

from __future__ import annotations

import socket
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.bridges.ardupilot import ArdupilotConfig, ArdupilotLink
from pelagos.bridges.ardupilot_json import ServoFrame
from pelagos.bridges.mavlink import MavlinkConfig, MavlinkDoor
from pelagos.bridges.px4 import Px4Config, Px4Link
from pelagos.bridges.tap import Tap
from pelagos.math.geodesy import GeoOrigin
from pelagos.vehicles.vehicle import Vehicle

mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
MS = 1_000_000
ROW = np.array([[12.0, -7.0, -0.25, 1.0, 0, 0, 0, 0.4, -0.2, 0.1, 0.1, -0.2, 0.3, 0.5, -0.6, 0.7]])


class Kept:
    """An inbox that keeps what it is told."""

    def __init__(self) -> None:
        self.orders: list[Any] = []

    def obey(self, order: Any) -> None:
        self.orders.append((order.kind, order.data))

    def steer(self, agent: str, values: Any, source: str) -> None:
        self.orders.append(("steer", list(values)))

    def put(self, order: Any) -> None:
        self.orders.append((order.kind, order.data["values"]))

    def refuse(self, reason: str) -> None:
        self.orders.append(("refused", reason.partition(":")[0]))

    def write_down(self) -> None:
        """Nothing."""


def exchange_of(vehicle: str) -> Any:
    """Of a simulation that stands still: an agent "a" near the surface."""
    made = Vehicle.from_catalogue(vehicle)
    agent = SimpleNamespace(vehicle=made, config=SimpleNamespace(vehicle=SimpleNamespace(type=vehicle)), sensors={})
    sim = SimpleNamespace(
        time_ns=0, dt_ns=4 * MS, model=SimpleNamespace(agents={"a": agent}), gate=SimpleNamespace(stopped=False),
        stepper=SimpleNamespace(row=lambda name: ROW.copy()), world=SimpleNamespace(origin=GeoOrigin(-33.25, 151.5)),
    )  # fmt: skip
    return SimpleNamespace(sim=sim, inbox=Kept(), at_least=lambda rate_hz: None)


@pytest.fixture
def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


@pytest.mark.parametrize(
    ("vehicle", "kind"),
    [("wamv", "SURFACE_BOAT"), ("otter", "SURFACE_BOAT"), ("surface_vessel", "SURFACE_BOAT"),
     ("quadrotor", "QUADROTOR"), ("remus100", "SUBMARINE")],
)  # fmt: skip
def test_a_heartbeat_a_second_says_what_it_is_and_states_come_at_their_rate(vehicle: str, kind: str) -> None:
    """As MAVLink's heartbeat protocol has it; after a reset at once again."""
    exchange = exchange_of(vehicle)
    door = MavlinkDoor(exchange, MavlinkConfig(type="mavlink", system=7, rate_hz=4.0))
    said: list[Any] = []
    reader = mavlink.MAVLink(None)
    door._say = lambda raw: said.extend((exchange.sim.time_ns // MS, m) for m in reader.parse_buffer(raw))  # type: ignore[method-assign]
    for _ in range(2):
        door.open(exchange.sim, Tap())
        for exchange.sim.time_ns in range(0, 2200 * MS, 40 * MS):
            door.send(exchange.sim, ())
    door.close()
    times: dict[str, list[int]] = {}
    for t_ms, message in said:
        times.setdefault(message.get_type(), []).append(t_ms)
    assert times["HEARTBEAT"] == times["SYS_STATUS"] == [0, 1000, 2000] * 2
    states = [0, 280, 520, 760, 1000, 1280, 1520, 1760, 2000] * 2  # the first boundary from each 250 ms on
    for name in ("ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "VFR_HUD"):
        assert times[name] == states
    assert {message.get_srcSystem() for _, message in said} == {7}
    beat = said[0][1]
    assert (beat.type, beat.autopilot) == (getattr(mavlink, f"MAV_TYPE_{kind}"), mavlink.MAV_AUTOPILOT_GENERIC)
    assert beat.base_mode == mavlink.MAV_MODE_FLAG_SAFETY_ARMED | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
    assert beat.system_status == mavlink.MAV_STATE_ACTIVE


def test_a_target_is_a_place_on_the_map_or_a_velocity_of_the_body(free_port: int) -> None:
    """By the bits of what is to be ignored: 7 of the place, 56 of the velocity, 2048 of the rate of yaw."""
    exchange = exchange_of("remus100")
    door = MavlinkDoor(exchange, MavlinkConfig(type="mavlink", port=free_port))
    peer = mavlink.MAVLink(None, srcSystem=250, srcComponent=190)
    for mask, frame in ((0o70, 1), (0o70, 8), (0o7, 8), (0o7, 1), (0, 1), (0o7 | 2048, 8), (0o17, 8), (0o71, 1)):
        target = (0, 1, 1, frame, mask, 4.0, -5.0, 6.0, 0.5, -0.25, 0.125, 0, 0, 0, 0, -0.75)
        door.take(mavlink.MAVLink_set_position_target_local_ned_message(*target).pack(peer))
    door.close()
    place, no = ("waypoint", [4.0, 5.0, -6.0]), ("refused", "SET_POSITION_TARGET_LOCAL_NED")
    turning, straight = (("velocity", [0.5, 0.25, -0.125, 0.0, 0.0, rate]) for rate in (0.75, 0.0))
    assert exchange.inbox.orders == [place, no, turning, no, place, straight, no, no]


@pytest.mark.parametrize(("begun", "waited", "told"), [(True, 1.25, 1), (False, 0.25, 0)])
def test_px4_is_waited_for_once_it_has_begun(
    begun: bool, waited: float, told: int, free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock on which a look for an answer takes 50 ms; while it boots, for the time between two messages."""
    exchange, now = exchange_of("wamv"), [70.0]
    link: Any = Px4Link(exchange, Px4Config(type="px4", port=free_port, rate_hz=4.0, answer_s=1.25))
    link._peer, link._begun = SimpleNamespace(close=lambda: None), begun

    def look() -> bool:
        now[0] += 0.05
        return now[0] > 80.0

    link._receive = look
    monkeypatch.setattr("pelagos.bridges.px4.time", SimpleNamespace(monotonic=lambda: now[0]))
    link.wait(exchange.sim)
    assert now[0] - 70.0 == pytest.approx(waited, abs=0.051)
    assert link.troubles["sensor messages without an answer"] == told
    now[0] = 80.0
    link.wait(exchange.sim)  # answered at the first look
    assert (now[0], link.answered) == (pytest.approx(80.05), 1)
    link.close()


def test_px4_gets_sensors_each_time_and_a_position_ten_times_a_second(free_port: int) -> None:
    exchange, raw = exchange_of("wamv"), list[tuple[int, bytes]]()
    link = Px4Link(exchange, Px4Config(type="px4", port=free_port))
    sim = exchange.sim
    link._peer = SimpleNamespace(sendall=lambda data: raw.append((sim.time_ns // MS, data)), close=lambda: None)  # type: ignore[assignment]
    for sim.time_ns in range(0, 350 * MS, 20 * MS):
        link.answer(sim)
    reader, times = mavlink.MAVLink(None), dict[str, list[int]]()
    for t_ms, data in raw:
        for message in reader.parse_buffer(data):
            times.setdefault(message.get_type(), []).append(t_ms)
            assert getattr(message, "time_usec", t_ms * 1000) == t_ms * 1000
    assert times == {
        "HIL_SENSOR": list(range(0, 350, 20)), "HIL_GPS": [0, 100, 200, 300], "HIL_STATE_QUATERNION": [0, 100, 200, 300]
    }  # fmt: skip
    assert link.steps == 18
    sim.stepper.row = lambda name: ROW * np.nan
    link.answer(sim)
    assert (link.steps, len(raw), dict(link.troubles)) == (18, 18, {"states that were not finite": 1})
    link.close()


def test_px4s_outputs_are_told_when_they_change(free_port: int) -> None:
    exchange = exchange_of("wamv")
    link = Px4Link(exchange, Px4Config(type="px4", port=free_port))
    peer = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def told(left: float, right: float, *, armed: bool = True) -> bool:
        controls = [left, 0.9, right, *[0.0] * 13]
        return link.take(mavlink.MAVLink_hil_actuator_controls_message(4000, controls, 128 * armed, 1).pack(peer))

    assert not link.take(mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3).pack(peer))
    assert not link._begun
    assert [told(0.5, -0.25), told(0.5, -0.25), told(0.5, 0.25), told(0.5, 0.25, armed=False)] == [True] * 4
    assert link._begun
    link.close()
    actuators = exchange_of("wamv").sim.model.agents["a"].vehicle.model.actuators.values()
    ends = [(a.lag.low, a.lag.high) for a in actuators]
    (low, high), _ = ends
    expected = [[0.5 * high, 0.25 * low], [0.5 * high, 0.25 * high], [0.0, 0.0]]
    assert [data["values"] for _, data in exchange.inbox.orders] == [pytest.approx(v) for v in expected]
    assert {data["mode"] for _, data in exchange.inbox.orders} == {"actuators"}


@pytest.mark.parametrize(
    ("vehicle", "keys", "ends"),
    [("wamv", {}, (1100, 1900)), ("wamv", {"low_us": 1000.0, "high_us": 1800.0}, (1000, 1800)),
     ("quadrotor", {}, (1000, 2000)), ("quadrotor", {"low_us": 1200.0}, (1200, 1900)),
     ("quadrotor", {"high_us": 1950.0}, (1100, 1950))],
)  # fmt: skip
def test_pulses_of_a_copter_go_from_1000_to_2000_unless_it_is_told(
    vehicle: str, keys: dict[str, float], ends: tuple[int, int], free_port: int
) -> None:
    """ArduCopter's MOT_PWM_MIN and MOT_PWM_MAX; a quarter of the way is half astern, or a quarter of the speed."""
    link = ArdupilotLink(exchange_of(vehicle), ArdupilotConfig(type="ardupilot", port=free_port, **keys))  # type: ignore[arg-type]
    low, high = ends
    quarter = round(low + 0.25 * (high - low))
    values = [link._values([pulse] * 16)[0] for pulse in (low, quarter, high, 0)]
    link.close()
    lag: Any = next(iter(exchange_of(vehicle).sim.model.agents["a"].vehicle.model.actuators.values())).lag
    if vehicle == "wamv":
        assert values == pytest.approx([lag.low, 0.5 * lag.low, lag.high, 0.0])
    else:
        share = (quarter - low) / (high - low)
        assert values == pytest.approx([lag.low, lag.low + share * (lag.high - lag.low), lag.high, lag.low])


def test_a_frame_is_one_sent_again_if_the_same_autopilot_counts_it_so(free_port: int) -> None:
    """Another autopilot's frame of that number is taken; one that counts from the beginning finds the vehicle there."""
    exchange = exchange_of("wamv")
    link: Any = ArdupilotLink(exchange, ArdupilotConfig(type="ardupilot", port=free_port))
    pulses = {5: (1300, 0, 1700, *[0] * 13), 6: (1400, 0, 1600, *[0] * 13), 2: (1400, 0, 1600, *[0] * 13)}
    packets = iter([(5, "one"), (5, "one"), (5, "other"), (6, "other"), (2, "other")])
    link._receive = lambda: next(packets)
    link._send = lambda: exchange.inbox.orders.append(("again", None))
    import pelagos.bridges.ardupilot as module

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "parse_servos", lambda count: ServoFrame(400, count, pulses[count]))
        for peer in ("one", "other", "other", "other"):
            link.wait(exchange.sim)
            assert link._peer == peer
    link.close()
    kinds = [kind for kind, _ in exchange.inbox.orders]
    assert kinds == ["steer", "again", "steer", "state", "steer"]  # what is the same is told once, but after a restart
    assert (link.steps, dict(link.troubles)) == (4, {"frames sent again": 1, "restarts of the autopilot": 1})
    assert exchange.inbox.orders[3][1]["position"] == [12.0, -7.0, -0.25]
