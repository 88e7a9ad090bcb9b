"""ArduPilot's JSON interface against a stand-in with the real parser's rules."""

from __future__ import annotations

import json
import socket
import struct
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_sitl import FakeSitl, parse

import pelagos as pl
from pelagos.bridges.ardupilot import ArdupilotConfig
from pelagos.bridges.ardupilot_json import level, parse_servos, state_text
from pelagos.bridges.autopilot import OUTPUTS, VehicleMotion, motion_of, outputs_of
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.journal import Repeat
from pelagos.bridges.transport import BridgeError

REST = [1500] * 16
SUB = {  # roll, pitch, yaw, throttle, forward, lateral of each motor: ArduPilot, AP_Motors6DOF.cpp
    "bluerov2": [(0, 0, 1, 0, -1, 1), (0, 0, -1, 0, -1, -1), (0, 0, -1, 0, 1, 1), (0, 0, 1, 0, 1, -1),
                 (1, 0, 0, -1, 0, 0), (-1, 0, 0, -1, 0, 0)],
    "bluerov2_heavy": [(0, 0, 1, 0, -1, 1), (0, 0, -1, 0, -1, -1), (0, 0, -1, 0, 1, 1), (0, 0, 1, 0, 1, -1),
                       (1, -1, 0, -1, 0, 0), (-1, -1, 0, -1, 0, 0), (1, 1, 0, -1, 0, 0), (-1, 1, 0, -1, 0, 0)],
}  # fmt: skip


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def scenario(vehicle: str, **more: Any) -> dict[str, Any]:
    level_m = {"quadrotor": 5.0, "wamv": 0.0, "otter": 0.0}.get(vehicle, -5.0)
    agent = {"vehicle": vehicle, "start": {"position_m": [3, -2, level_m], "heading_deg": 30}, "control": "actuators"}
    return {"tick_rate_hz": 200, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"a": {**agent, **more}}}


def drive(
    sim: pl.Simulation, script: Callable[[FakeSitl], None], *, seconds: float = 60.0, record: Path | None = None,
    **config: Any,
) -> Any:  # fmt: skip
    """Run with a stand-in that follows a script, and ends the run with it."""
    port = free_port()
    exchange = Exchange(sim)
    ArdupilotConfig(type="ardupilot", port=port, **config).attach(exchange)
    failure: list[BaseException] = []
    sitl = FakeSitl(port)

    def run() -> None:
        try:
            script(sitl)
        except BaseException as error:
            failure.append(error)
        finally:
            sim.stop()
            sitl.close()

    thread = threading.Thread(target=run)
    thread.start()
    result = exchange.run(seconds, record=record)
    thread.join()
    report = exchange.close()
    if failure:
        raise failure[0]
    return result, report


def test_lock_step_is_one_step_for_each_frame() -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    times: list[float] = []

    def script(sitl: FakeSitl) -> None:
        for _ in range(50):
            times.append(sitl.exchange(REST)["timestamp"][0])
        before = sitl.again(REST)  # the answer was lost: no step, the same answer
        assert before["timestamp"][0] == times[-1]
        times.append(sitl.exchange(REST)["timestamp"][0])

    _, report = drive(sim, script)
    np.testing.assert_allclose(np.diff(times), 0.005, atol=1e-12)
    assert report["ArduPilot: frames sent again"] == 1


def test_a_level_vehicle_at_rest_feels_gravity_upwards() -> None:
    """North, east, down; forward, right, down: x 3 north, y -2 west is 2 east; specific force is -9.81 on z."""
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    seen: list[dict[str, list[float]]] = []
    drive(sim, lambda sitl: seen.append(sitl.exchange(REST)))
    np.testing.assert_allclose(seen[0]["position"], [3, 2, 5], atol=0.01)
    np.testing.assert_allclose(seen[0]["accel_body"], [0, 0, -9.81], atol=0.15)
    w, x, y, z = seen[0]["quaternion"]
    assert np.degrees(2 * np.arctan2(z, w)) == pytest.approx(30, abs=0.1)  # a compass heading of 30 turns to the right
    assert abs(x) + abs(y) < 0.01


@pytest.mark.parametrize("vehicle", sorted(SUB))
@pytest.mark.parametrize(
    ("axis", "what"), [(0, "roll"), (1, "pitch"), (2, "yaw"), (3, "up"), (4, "forward"), (5, "right")]
)
def test_each_axis_of_the_pilot_moves_the_vehicle_that_way(vehicle: str, axis: int, what: str) -> None:
    """Outputs are those of ArduSub's own mixing; roll right, pitch up, yaw right are positive."""
    if (vehicle, what) == ("bluerov2", "pitch"):
        return  # six thrusters cannot
    sim = pl.Simulation.load(scenario(vehicle))
    pwm = [1500 + round(150 * factors[axis]) for factors in SUB[vehicle]]
    last: list[dict[str, list[float]]] = []

    def script(sitl: FakeSitl) -> None:
        for _ in range(60):
            last.append(sitl.exchange(pwm))

    drive(sim, script)
    end = last[-1]
    q = np.array(end["quaternion"])
    north_east = np.array(end["velocity"][:2])
    heading = 2 * np.arctan2(q[3], q[0])
    along = [np.cos(heading) * north_east[0] + np.sin(heading) * north_east[1],
             -np.sin(heading) * north_east[0] + np.cos(heading) * north_east[1]]  # fmt: skip
    moved = {"roll": end["gyro"][0], "pitch": end["gyro"][1], "yaw": end["gyro"][2], "up": -end["velocity"][2],
             "forward": along[0], "right": along[1]}  # fmt: skip
    assert moved[what] > 0.03
    others = {name: abs(v) for name, v in moved.items() if name != what and name in ("up", "forward", "right", "yaw")}
    assert max(others.values()) < 0.7 * moved[what]


@pytest.mark.parametrize("vehicle", ["wamv", "otter"])
def test_a_boat_turns_by_its_two_thrusters(vehicle: str) -> None:
    sim = pl.Simulation.load(scenario(vehicle))
    last: list[dict[str, list[float]]] = []

    def script(sitl: FakeSitl) -> None:
        for _ in range(150):
            last.append(sitl.exchange([1900, 0, 1500]))  # left ahead: turns to the right

    drive(sim, script)
    assert last[-1]["gyro"][2] > 0.02
    assert np.hypot(*last[-1]["velocity"][:2]) > 0.05


def test_a_quadrotor_climbs_and_yaws_as_arducopter_means_it() -> None:
    """Motors 1 and 2 turn counter-clockwise: faster, they turn the vehicle to the right."""
    sim = pl.Simulation.load(scenario("quadrotor"))
    last: list[dict[str, list[float]]] = []

    def script(sitl: FakeSitl) -> None:
        for _ in range(100):
            last.append(sitl.exchange([1850, 1850, 1800, 1800]))

    drive(sim, script)
    assert last[-1]["velocity"][2] < -0.1
    assert last[-1]["gyro"][2] > 0.01


def test_an_autopilot_that_answers_late_is_waited_for_asleep() -> None:
    """One that answers soon is looked for first, which takes the time of being woken up off every frame."""
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    exchange = Exchange(sim)
    ArdupilotConfig(type="ardupilot", port=free_port()).attach(exchange)
    link: Any = exchange._drivers[0]
    link._socket.close()
    looks: list[int] = []

    class Late:
        """Nothing is there at a look; it comes to who sleeps."""

        def recvfrom(self, size: int, flags: int = 0) -> tuple[bytes, str]:
            looks.append(flags)
            if flags:
                raise BlockingIOError
            return b"late", "peer"

        def close(self) -> None:
            looks.append(-1)

    link._socket, link._soon, link._spins = Late(), True, True
    sim.step()
    exchange.inbox.steer("a", [0.0] * 8, "ardupilot")
    assert link._receive() == (b"late", "peer")
    assert looks.count(0) == 1
    assert len(looks) > 1
    assert not exchange.inbox._unwritten  # meanwhile
    exchange.close()


def test_outputs_that_are_off_rest() -> None:
    """A pulse of 0 means off; read as a number it would be full astern."""
    assert level(0, 0.0) == 0.0
    assert (level(1100, 0.0), level(1500, 0.0), level(1900, 0.0)) == (-1, 0, 1)
    sim = pl.Simulation.load(scenario("wamv"))
    left, right = outputs_of(sim, "a", {}, "")
    assert (left.channel, right.channel) == (0, 2)
    assert [left.value(v) for v in (-1, -0.5, 0, 0.5, 1, 7)] == [-100, -50, 0, 125, 250, 250]
    quad = pl.Simulation.load(scenario("quadrotor"))
    rotor = outputs_of(quad, "a", {}, "")[0]
    assert [rotor.value(v) for v in (-1, 0, 1)] == [0, 450, 900]
    assert level(0, rotor.rests_at) == -1


def test_a_rebooted_autopilot_finds_the_vehicle_at_its_start() -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    seen: list[list[float]] = []

    def script(sitl: FakeSitl) -> None:
        pwm = [1500 + round(400 * f[4]) for f in SUB["bluerov2_heavy"]]
        for _ in range(200):
            seen.append(sitl.exchange(pwm)["position"])
        sitl.count = -1
        seen.append(sitl.exchange(REST)["position"])

    _, report = drive(sim, script)
    assert np.linalg.norm(np.subtract(seen[-2], seen[0])) > 0.05
    np.testing.assert_allclose(seen[-1], seen[0], atol=0.01)
    assert report["ArduPilot: restarts of the autopilot"] == 1


def test_a_driven_run_is_repeated_bit_for_bit(tmp_path: Path) -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy", sensors={"imu": {"type": "imu", "rate_hz": 200}}))
    rng = np.random.Generator(np.random.PCG64(1))

    def script(sitl: FakeSitl) -> None:
        for _ in range(100):
            sitl.exchange(rng.integers(1200, 1800, 8).tolist())

    drive(sim, script, record=tmp_path / "a.mcap")
    end, ticks = sim.state["a"].position, sim.time_ns // sim.dt_ns
    again = pl.Simulation.load(scenario("bluerov2_heavy", sensors={"imu": {"type": "imu", "rate_hz": 200}}))
    Repeat(again, tmp_path / "a.mcap")
    again.run(ticks * sim.dt_ns * 1e-9)
    assert (again.state["a"].position == end).all()


def test_malformed_packets_are_counted_and_dropped() -> None:
    rng = np.random.Generator(np.random.PCG64(2))
    sitl, wide = FakeSitl(1), FakeSitl(1, channels=32)
    good, long = sitl.packet([1500] * 8), wide.packet(list(range(1000, 1032)))
    sitl.close()
    wide.close()
    assert parse_servos(good) is not None
    for _ in range(20_000):
        raw = rng.bytes(int(rng.integers(0, 80)))
        assert parse_servos(raw) is None or raw[:2] in (struct.pack("<H", 18458), struct.pack("<H", 29569))
    assert parse_servos(good[:-1]) is None
    assert parse_servos(good + b"x") is None
    frame = parse_servos(long)
    assert frame is not None
    assert frame.pwm == tuple(range(1000, 1032))
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))

    def script(sitl: FakeSitl) -> None:
        sitl.exchange(REST)
        for raw in (b"", b"x" * 40, good[:20]):
            sitl.socket.sendto(raw, sitl.address)
        sitl.exchange(REST)

    _, report = drive(sim, script)
    assert report["ArduPilot: malformed packets"] == 3


def test_the_text_suits_the_parser_and_carries_no_nan() -> None:
    one, nan = (1.5, -2.5, 1e-7), float("nan")
    motion = VehicleMotion(one, (-1.5, 2.5, -1e-7), (0.5, -0.5, 0.5, -0.5), (3.0, -5.0, 2e-7), (4.5, -7.5, 3e-7))
    text = state_text(12.25, motion, {"rng_1": 7.5, "velocity_wind": [9, 9, 9]})
    assert text is not None
    assert json.loads(text)["quaternion"] == [0.5, -0.5, 0.5, -0.5]
    found = parse(text)
    assert found["velocity"] == [-1.5, 2.5, -1e-7]  # not what stands in velocity_wind
    assert found["rng_1"] == [7.5]
    assert parse(state_text(1.0, motion, {"rng_1": float("inf")}) or b"").get("rng_1") is None
    assert state_text(1.0, motion._replace(velocity=(1.0, nan, 2.0))) is None


def test_a_silent_autopilot_ends_the_run_in_order() -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    exchange = Exchange(sim)
    port = free_port()
    ArdupilotConfig(type="ardupilot", port=port, patience_s=0.2).attach(exchange)
    sitl = FakeSitl(port)
    thread = threading.Thread(target=lambda: sitl.exchange(REST))
    thread.start()
    result = exchange.run(30.0)
    thread.join()
    sitl.close()
    assert result.ended == "stopped"
    assert any("silent" in reason for reason in exchange.close())


def test_two_vehicles_each_with_an_autopilot() -> None:
    data = scenario("bluerov2_heavy")
    data["agents"]["b"] = {"vehicle": "otter", "start": {"position_m": [20, 0, 0]}, "control": "actuators"}
    sim = pl.Simulation.load(data)
    exchange = Exchange(sim)
    ports = [free_port(), free_port()]
    for agent, port in zip("ab", ports, strict=True):
        ArdupilotConfig(type="ardupilot", agent=agent, port=port).attach(exchange)
    seen: dict[int, list[float]] = {}

    def script(port: int) -> None:
        sitl = FakeSitl(port)
        for _ in range(30):
            seen[port] = sitl.exchange(REST)["timestamp"]
        sitl.close()

    threads = [threading.Thread(target=script, args=(port,)) for port in ports]
    for thread in threads:
        thread.start()
    ender = threading.Thread(target=lambda: [*(t.join() for t in threads), sim.stop()])
    ender.start()
    exchange.run(60.0)
    ender.join()
    exchange.close()
    assert seen[ports[0]] == seen[ports[1]] == [pytest.approx(0.15)]


def test_what_cannot_be_is_said() -> None:
    sim = pl.Simulation.load(scenario("remus100", control="actuators"))
    with pytest.raises(BridgeError, match="give `outputs`"):
        ArdupilotConfig(type="ardupilot", port=free_port()).attach(Exchange(sim))
    with pytest.raises(BridgeError, match="did you mean 'rudder'"):
        ArdupilotConfig(type="ardupilot", port=free_port(), outputs={"ruder": 1}).attach(Exchange(sim))
    with pytest.raises(BridgeError, match="no output moves"):
        ArdupilotConfig(type="ardupilot", port=free_port(), outputs={"rudder": 1}).attach(Exchange(sim))
    with pytest.raises(BridgeError, match="unknown agent"):
        ArdupilotConfig(type="ardupilot", agent="b", port=free_port()).attach(Exchange(sim))
    for vehicle, table in OUTPUTS.items():
        assert set(table) == set(pl.Vehicle.from_catalogue(vehicle).actuator_names)


def test_the_motion_is_that_of_the_state() -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy"))
    q = np.array([0.9, 0.1, -0.3, 0.2])
    q /= np.linalg.norm(q)
    sim.set_state("a", position=[1, 2, -3], attitude=q, velocity=[0.4, -0.5, 0.6], angular_velocity=[0.1, 0.2, -0.3])
    found = motion_of(sim, "a")
    np.testing.assert_allclose(found.position, [1, -2, 3])
    np.testing.assert_allclose(found.gyro, [0.1, -0.2, 0.3])
    w, x, y, z = found.attitude
    matrix = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    np.testing.assert_allclose(found.velocity, matrix @ [0.4, 0.5, -0.6], atol=1e-12)
