"""Absurd orders: refused with their reason, or at worst a new beginning; none ends the process or a run."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.journal import recorded_orders
from pelagos.cli.doors import MOST_RESTARTS, nothing_left, run_with_doors
from pelagos.cli.run import Options
from pelagos.errors import CommandError, InputError
from pelagos.sim.bearable import BEARABLE_MPS2, check_current
from pelagos.sim.not_finite import NotFinite
from pelagos.sim.order import Order, apply
from pelagos.sim.simulation import Simulation

START = {"position_m": [1, -2], "depth_m": 5}


@pytest.fixture(scope="module")
def sim() -> Simulation:
    agent = {"vehicle": "bluerov2", "start": START, "control": "pose"}
    return Simulation.load({"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 50.0}, "agents": {"rov": agent}})


@pytest.mark.parametrize(
    ("order", "text"),
    [
        (Order("wrench", "rov", {"values": [1e5, 0, 0, 0, 0, 0]}), "at most 100 m/s"),
        (Order("wrench", "rov", {"values": [0, 0, 0, 0, -300.0, 0]}), "rad/s"),
        (Order("command", "rov", {"values": [0, -1e4, 0, 0, 0, 0], "mode": "acceleration"}), "at most 100 m/s"),
        (Order("setpoint", "rov", {"yaw_moment": -1e4}), "rad/s"),
        (Order("state", "rov", {"velocity": [50.0, -50, 25]}), "through the water"),
        (Order("state", "rov", {"angular_velocity": [30.0, -30, 15]}), "rad/s"),
        (Order("ocean", "", {"current": [-20.0, 3, 0]}), "at most 15 m/s"),
        (Order("ocean", "", {"current": [4.0, -14, 0]}), "through the water"),
    ],
    ids=lambda v: v.kind if isinstance(v, Order) else "",
)
def test_what_no_vehicle_bears_is_refused_and_nothing_changes(sim, order, text) -> None:
    mode, state = sim.stepper.mode("rov"), sim.state["rov"].velocity.tobytes()
    with pytest.raises(CommandError, match=text):
        apply(order, sim)
    assert (sim.stepper.mode("rov"), sim.state["rov"].velocity.tobytes()) == (mode, state)


@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_just_allowed_leaves_a_finite_state(sim, sign) -> None:
    vehicle = sim.model.agents["rov"].vehicle
    turned = BEARABLE_MPS2 / vehicle.bounding_radius_m
    most = np.array([1, -sign, 1, -1, sign, 1]) * ([0.99 * BEARABLE_MPS2] * 3 + [0.99 * turned] * 3)
    apply(Order("command", "rov", {"values": (vehicle.config.body.mass_matrix @ most).tolist(), "mode": "wrench"}), sim)
    sim.run(1.0)
    assert np.isfinite(sim.state["rov"].position).all()
    sim.reset()


def test_a_state_that_is_lost_within_a_block_ends_the_run_in_order(sim, tmp_path, monkeypatch) -> None:
    """Tables of thrusters are looked up with numbers that are none, fifty ticks in one call."""
    monkeypatch.chdir(tmp_path)  # the last state goes there
    sim.set_state("rov", angular_velocity=[1e9, -1e9, 5e8])
    with pytest.raises(NotFinite, match="rov"):
        sim.run(1.0)
    sim.reset()


def test_the_thrusters_table_answers_what_is_no_number_with_the_same() -> None:
    from pelagos.vehicles.actuators.t200 import t200_tables, table_thrust

    values = jit.Float64(np.array([np.nan, 0.3, np.nan]))
    found = np.array(table_thrust(values, jit.Float64(np.array([16.0, 14.5, np.nan])), t200_tables(16.0)))
    assert np.isnan(found).tolist() == [True, False, True]


class Mad:
    """A door whose peer turns a vehicle faster and faster, within what it can bear at once."""

    def __init__(self) -> None:
        self.opened = 0

    def attach(self, exchange: Exchange) -> str:
        """Open it."""
        self.opened += 1
        inbox = exchange.inbox
        push = Order("command", "rov", {"values": [99.0, -99, 99, 320, -320, 320], "mode": "acceleration"}, "peer")
        exchange.sim.on_tick(lambda s: inbox.obey(push) if 0 < s.time_ns <= 20_000_000 else None)
        return "mad"


def test_a_peer_that_tears_a_vehicle_apart_makes_the_run_begin_anew(sim, tmp_path, capsys) -> None:
    door, file = Mad(), tmp_path / "mission.mcap"
    with pytest.raises(NotFinite):  # it never stops
        run_with_doors(sim, {"peer": door}, Options(duration_s=6.0), file, lambda t, d: None)
    assert "goes on in mission-2.mcap" in " ".join(capsys.readouterr().out.split())
    assert recorded_orders(tmp_path / "mission-2.mcap")[0][1].source == "peer"
    assert len(list(tmp_path.glob("mission*.mcap"))) == MOST_RESTARTS + 1
    sim.reset()
    with pytest.raises(NotFinite):  # the same again, with no door
        run_with_doors(
            sim, {"peer": door}, Options(duration_s=6.0, repeat=file), tmp_path / "again.mcap", lambda t, d: None
        )
    assert door.opened == 1
    assert "bridges stay closed: peer" in " ".join(capsys.readouterr().out.split())
    sim.reset()


def test_nobody_else_tells_a_repeated_run_anything(sim, tmp_path) -> None:
    options = Options(duration_s=1.0, repeat=tmp_path / "mission.mcap", bridges=("ros2",))
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "scenario.yaml").touch()
    file = tmp_path / "again" / "mission.mcap"
    with pytest.raises(InputError, match="leave out bridges"), nothing_left(file.parent, file):
        run_with_doors(sim, {}, options, file, lambda t, d: None)
    assert not file.parent.exists()


def test_water_is_unbearable_by_its_speed_past_the_hull() -> None:
    """6 m/s ahead and 1.2 m/s to the left at heading 120 deg: water that goes along does no harm."""
    start = {**START, "heading_deg": 120.0}
    agent = {"vehicle": "bluerov2", "start": start, "control": "pose"}
    sim = Simulation.load({"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 50.0}, "agents": {"rov": agent}})
    sim.set_state("rov", velocity=[6.0, 1.2, 0.0])
    c, s = np.cos(np.radians(120.0)), np.sin(np.radians(120.0))
    along = np.array([6.0 * c + 1.2 * s, -6.0 * s + 1.2 * c, 0.0])  # NWU: forward is (c, -s), left is (s, c)
    check_current(sim, along.tolist())
    with pytest.raises(CommandError, match=r"a velocity through the water of \(12, 2.4, 0\) m/s"):
        check_current(sim, (-along).tolist())


def test_water_is_unbearable_to_the_vehicle_of_any_copy() -> None:
    """That of the second goes with it; the others stand still, to them it is a stream of 12 m/s."""
    agent = {"vehicle": "bluerov2", "start": {**START, "heading_deg": 120.0}, "control": "pose"}
    scenario = {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 50.0}, "agents": {"rov": agent}}
    sim = Simulation.load(scenario, n=3)
    c, s = np.cos(np.radians(120.0)), np.sin(np.radians(120.0))
    for there in range(3):
        sim.set_state("rov", velocity=[[12.0 * (copy != there), 0.0, 0.0] for copy in range(3)])
        with pytest.raises(CommandError, match=r"a velocity through the water of \(-12, "):
            check_current(sim, [12.0 * c, -12.0 * s, 0.0])
    sim.set_state("rov", velocity=[12.0, 0.0, 0.0])
    check_current(sim, [12.0 * c, -12.0 * s, 0.0])
