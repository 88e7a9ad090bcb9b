"""Refusals of a loaded simulation, each with the words that say where, what was given and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.errors import CommandError, InputError
from pelagos.sim.bearable import check_current
from pelagos.sim.bodies import rows
from pelagos.sim.initial import _touched
from pelagos.sim.order import Order, apply
from pelagos.sim.simulation import Simulation
from pelagos.world.body import Prop

LAMP = {"position_m": [0.3, 0, 0], "orientation_deg": [0, 90, 0], "flux_lm": 1000}
CAMERA = {"type": "camera", "rate_hz": 1, "width_px": 16, "height_px": 16}
WEIGHT = {"type": "releasable", "mass_kg": 3.0, "position_m": [0.0, 0.0, 0.1], "volume_m3": 3.8e-4}
SLOW = {"type": "modem", "bit_rate_bps": 50.0}


def agent(y: float, vehicle: Any = "remus100", **more: Any) -> dict[str, Any]:
    return {"vehicle": vehicle, "start": {"position_m": [0.0, y, -5.0]}, **more}


@pytest.fixture(scope="module")
def sim() -> Simulation:
    return Simulation.load(
        {
            "world": {"type": "flat", "depth_m": 20.0},
            "agents": {
                "auv": agent(0, {"type": "remus100", "actuators": {"weight": WEIGHT}}, sensors={
                    "depth": {"type": "depth"}, "hit": {"type": "collision"}, "eye": {**CAMERA, "lamps": [LAMP]},
                    "modem": {"type": "modem"}}),
                "auv2": agent(9, sensors={"eye": {**CAMERA, "lamps": [{**LAMP, "flux_lm": 70}]}, "modem": SLOW}),
                "rov": agent(18, "bluerov2", control="wrench", sensors={"eye": CAMERA}),
                "fleet": {"vehicle": "remus100", "count": 2, "sensors": {"depth": {"type": "depth"}},
                          "start": {"position_m": [0.0, 30.0, -5.0], "spacing_m": 8.0}},
                "glider": agent(-20, "glider"),
            },
        },
        n=2,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda s: s.set("fleet[0].depth", rate_hz=2), "fleet[0] is a member of a group; what it carries is set in"),
        (lambda s: s.set("auv.dept", rate_hz=2), "unknown sensor 'auv.dept' (did you mean 'auv.depth'?); known: auv.d"),
        (lambda s: s.set("auv", rate_hz=2), "unknown sensor 'auv'"),
        (lambda s: s.set("auv.depth"), "what is to be set of auv.depth? Give keys of its configuration"),
        (lambda s: s.set("auv.lamp", on=1), "of auv.lamp, on=True or on=False can be set; given {'on': 1}"),
        (lambda s: s.set("auv.lamp", on=True, flux_lm=3), "on=True or on=False can be set; given {'on': True, 'flux_l"),
        (lambda s: s.set("auv.lamp"), "on=True or on=False can be set; given {}"),
        (lambda s: s.set("rov.lamp", on=True), "rov has no camera with lamps"),
        (lambda s: s.load_world(overrides={"agents.auv.control": "depth"}), "agents.auv.control stays when the world"),
        (lambda s: s.load_world(overrides={"world.depth_m": 9.0, "seed": 4}), "seed stays when the world changes; key"),
        (lambda s: s.ocean.set(agent="auv"), "what is to be set of the ocean? Give current, turbidity, level_m or key"),
        (lambda s: s.ocean.set(agent="auv", current=None), "with an agent, give its current"),
        (lambda s: s.ocean.set(keys={"weathr.cloud": 0.2}), "unknown key of the ocean that can be set 'weathr.cloud'"),
        (lambda s: s.ocean.set(level_m=np.nan), "level_m is a finite number, not nan"),
        (lambda s: s.ocean.set(level_m=-np.inf), "level_m is a finite number, not -inf"),
        (lambda s: s.spawn(Prop("box", position=["a", 1, 2])), "position is 3 numbers, or 2 rows of them; given ['a',"),
        (lambda s: s.send("aux", "modem", b"1", to="auv2.modem"), "unknown agent 'aux' (did you mean 'auv'?)"),
        (lambda s: s.send("auv", "modem", b"1", to="auv2.modem"), "auv2.modem does not understand auv.modem: another"),
        (lambda s: s.send("auv", "modem", b"1", where=[0, 2]), "copies of this fleet are 0 to 1; given [0, 2]"),
        (lambda s: s.send("auv", "modem", b"1", where=[-1]), "copies of this fleet are 0 to 1; given [-1]"),
        (lambda s: s.observe("auv", (0, 0, -4), sensors=["hit"]), "auv.hit says what happened in a run; at a pose alo"),
        (lambda s: s.observe("auv", (0, 0, -4), sensors=["depth"], episode=-1), "an episode is a whole number from 0"),
        (lambda s: s.observe("auv", (0, 0, -4), copy=2), "copy is one of 0 to 1, not 2"),
        (lambda s: s.step(ticks=0), "ticks is a whole number from 1 on; given 0"),
        (lambda s: s.step(ticks=True), "ticks is a whole number from 1 on; given True"),
        (lambda s: s.step(ticks=2.0), "ticks is a whole number from 1 on; given 2.0"),
        (lambda s: s.run(0), "a run lasts a positive number of seconds, not 0"),
        (lambda s: s.run(-1.5), "a run lasts a positive number of seconds, not -1.5"),
        (lambda s: s.run(np.inf), "a run lasts a positive number of seconds, not inf"),
        (lambda s: s.run(1.0, realtime=-1.0), "realtime is true, false, or how many times as fast as the clock; not -"),
    ],
)  # fmt: skip
def test_a_request_is_refused_in_words(sim: Simulation, ask: Callable[[Simulation], Any], told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)):
        ask(sim)


@pytest.mark.parametrize(
    ("order", "told"),
    [
        (Order("setpoint", "auv", {"depth": 3.0, "colour": 1.0}), "auv: no control mode takes depth, colour; modes: "),
        (
            Order("waypoint", "glider", {"values": [1.0, 2.0, 3.0]}),
            "glider: no control mode goes to a waypoint; modes: ",
        ),
        (Order("wrench", "rov", {"values": [1.0] * 5}), "rov: a wrench order has six numbers, not 5"),
        (Order("velocity", "rov", {"values": [0.1] * 7}), "rov: a velocity order has six numbers, not 7"),
    ],
)
def test_an_order_is_refused_in_words(sim: Simulation, order: Order, told: str) -> None:
    with pytest.raises(CommandError, match=re.escape(told)):
        apply(order, sim)


def test_an_order_in_its_modes_own_set_points_leaves_what_is_carried(sim: Simulation) -> None:
    """A released weight stays released: three numbers of four, in the same mode and into another one."""
    apply(Order("setpoint", "auv", {"weight": 1.0}), sim)
    apply(Order("command", "auv", {"values": [7.0, 0.3, 1.2]}), sim)
    assert sim.held_command("auv").tolist() == [[7.0, 0.3, 1.2, 1.0]] * 2
    apply(Order("command", "auv", {"values": [6.0, -0.4, 900.0], "mode": "depth_heading"}), sim)
    assert sim.held_command("auv").tolist() == [[6.0, -0.4, 900.0, 1.0]] * 2


def test_the_lamps_of_one_agent_are_switched(sim: Simulation) -> None:
    """Each time as the scenario has them; another agent's stay, though its name begins alike."""
    given = {name: a.sensors["eye"].lamps for name, a in sim.scenario.agents.items() if "eye" in a.sensors}
    lit = lambda: {name: a.sensors["eye"].lamps for name, a in sim.scenario.agents.items() if "eye" in a.sensors}
    for _ in range(2):
        sim.set("auv.lamp", on=False)
        assert lit() == {**given, "auv": type(given["auv"])()}
        sim.set("auv.lamp", on=True)
        assert lit() == given


def test_limits_are_allowed(sim: Simulation) -> None:
    """The other side of refusals."""
    assert sim.observe("auv", (0, 0, -4), sensors=["depth"], copy=1, episode=0)["depth"].truth[0] == pytest.approx(4.0)
    assert sim.send("auv", "modem", b"1", where=[0, 1]) >= 0
    assert rows([[1, 2, 3], [4, 5, 6]], 2, 3, "x").tolist() == [[1, 2, 3], [4, 5, 6]]
    with pytest.raises(CommandError, match=re.escape("x has shape (3,) or (2, 3); given (3, 2)")):
        rows([[1, 2], [3, 4], [5, 6]], 2, 3, "x")


def test_names_of_bodies_are_unique(sim: Simulation) -> None:
    first = sim.spawn(Prop("box", position=(5.0, 5.0, -3.0)), name="crate")
    with pytest.raises(CommandError, match="a body named 'crate' is there already; names are unique"):
        sim.spawn(Prop("sphere", position=(9.0, 5.0, -3.0)), name="crate")
    assert [b.name for b in sim.bodies.bodies] == ["crate"]
    first.remove()


def test_a_current_does_not_tear_at_what_flies() -> None:
    """15 m/s of water, at which a submarine would break, pass below a drone; beyond that no current is taken."""
    flying = Simulation.load({"world": {"type": "built"}, "agents": {"drone": {**FLY, "control": "actuators"}}})
    check_current(flying, [15.0, 0.0, 0.0])
    with pytest.raises(CommandError, match=re.escape("a current of 15.1 m/s; at most 15 m/s")):
        check_current(flying, [0.0, -15.1, 0.0])


@pytest.mark.parametrize("n", [0, -1, True, 2.0, "2"])
def test_a_number_of_copies_is_a_whole_number(n: Any) -> None:
    with pytest.raises(
        CommandError, match=re.escape(f"n is the number of copies, a whole number from 1 on; given {n!r}")
    ):
        Simulation.load({}, n=n)


FLY = agent(0, "quadrotor", start={"position_m": [0, 0, 9.0]})
SHIP = agent(0, "otter", start={"position_m": [0.0, 0.0]})


def legs(base: dict[str, Any], **leg: Any) -> dict[str, Any]:
    return {**base, "mission": [{"type": "waypoints", "points": [[30.0, 0.0]], **leg}]}


@pytest.mark.parametrize(
    ("a", "told"),
    [
        (legs(FLY, depth_m=3.0), "quadrotor flies: give height_m, not depth_m"),
        (legs(SHIP, depth_m=3.0), "otter stays at the surface: leave out its depth or altitude"),
        (legs(SHIP, altitude_m=3.0), "otter stays at the surface: leave out its depth or altitude"),
        (legs(agent(0), height_m=3.0), "remus100 does not fly: leave out height_m"),
        (
            {
                **agent(0),
                "mission": [{"type": "follow", "wall": "sied", "distance_m": 5, "seconds": 9, "depth_m": 4}],
                "sensors": {"side": {"type": "altimeter"}},
            },
            "mission.0.wall: unknown sensor of a 'sied' (did you mean 'side'?)",
        ),
        ({**agent(0), "start": {"position_m": [9.0, -2.5], "altitude_m": 3.0}}, "no seabed below x 9, y -2.5 m"),
    ],
)
def test_an_agent_is_refused_at_load(a: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)):
        Simulation.load({"world": {"type": "built", "depth_m": None}, "agents": {"a": a}})


def test_a_hull_is_probed_as_it_is_turned() -> None:
    turn, position = Rotation.from_euler("ZYX", [130, -20, 35], degrees=True), np.array([4.0, -3.0, -6.0])
    starts, vectors = np.random.default_rng(2).normal(size=(2, 5, 3))
    asked: list[Any] = []

    def cast(*given: Any) -> Any:
        asked.extend(given)
        return SimpleNamespace(valid=np.array([True, True]), t=np.array([2.0, 1.0]), instance=np.array([4, 7]))

    world = SimpleNamespace(cast=cast, names={4: "quay", 7: "boat"})
    x, y, z, w = turn.as_quat()
    agent = SimpleNamespace(vehicle=SimpleNamespace(probes=(starts, vectors)))
    found = _touched(agent, world, position, np.array([w, x, y, z]))  # type: ignore[arg-type]
    assert found == "at (4.00, -3.00, -6.00) m its hull would touch boat"
    np.testing.assert_allclose(asked[0], position + turn.apply(starts), atol=1e-12)
    np.testing.assert_allclose(asked[1], turn.apply(vectors), atol=1e-12)
    np.testing.assert_allclose(asked[2], np.linalg.norm(vectors, axis=1))
