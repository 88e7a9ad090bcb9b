"""What orders of browsers do: what is commanded, where all goes, what the page is told; and the water of a view."""

from __future__ import annotations

import itertools
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import made_up
import pelagos as pl
from known import DOUBLE, check
from pelagos.viewer import pilot
from pelagos.viewer.currents import arrows
from pelagos.viewer.drive import Axes, drive
from pelagos.viewer.frame import ShownFrame
from pelagos.viewer.live import Live
from pelagos.viewer.orders import Orders
from pelagos.viewer.pilot import Pilot
from pelagos.viewer.section import Asked, curtain, sections
from pelagos.viewer.session import Watching, subject_of
from pelagos.viewer.soundings import Soundings
from pelagos.viewer.view import View
from shown import Ear, Nobody, parts, slow_clock

START = made_up.motion(1.0)[1][0]


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> None:
    slow_clock(monkeypatch)


@pytest.fixture(scope="module")
def sim() -> pl.Simulation:
    said, _ = made_up.scenario(())
    for agent in said["agents"].values():
        agent["sensors"] = {}
    said["agents"]["auv0"] |= {
        "control": "depth_heading_speed", "command": [5.0, 0.6, 1.5], "navigation": {"type": "truth"},
        "sensors": {"depth": {"type": "depth", "rate_hz": 10}},
    }  # fmt: skip
    said["agents"]["rov"]["mission"] = [{"type": "goto", "points": [[9.0, -2.0, -6.0], [1.0, 2.0, -5.0]]}]
    said["agents"]["usv"]["control"] = "heading_speed"
    return pl.Simulation.load(said | {"tick_rate_hz": 50})


def quick_clock(patch: pytest.MonkeyPatch) -> None:
    """Have the pilot's clock go on by 13 ms whenever it looks at it."""
    ticking = itertools.count(5.0, 0.013)
    patch.setattr(pilot, "time", SimpleNamespace(perf_counter=lambda: next(ticking)))


def motions(sim: pl.Simulation) -> list[Any]:
    return [np.concatenate([np.ravel(v) for v in (s.position, s.attitude, s.velocity)]) for s in sim.state.values()]


def test_water_of_a_view(sim: pl.Simulation) -> None:
    sim.reset()
    ocean, place = sim.ocean.fields, np.array([3.0, -7.0, -4.0])
    found: dict[str, Any] = {f"arrows at {d:g} m": arrows(ocean, sim.world, 31.0, d) for d in (4.0, 12.5)}
    for what in sections(ocean):
        for along in ("north", "east"):
            c = curtain(ocean, sim.world, Asked(what, along), place, 31.0)  # type: ignore[arg-type]
            name = f"{what} {along}"
            found |= {f"{name} colours": c.colours, f"{name} ends": [c.low, c.high]}
            found |= parts(f"{name} legend", [c.title, c.unit, c.shades])
            found |= {f"{along} places": c.vertices, f"{along} faces": c.faces}
    subject = subject_of(sim)
    found |= parts("water", subject.water.message()) | {f"plan of {n}": p for n, p in subject.plans.items()}
    x, y = np.random.default_rng(8).uniform(-30.0, 30.0, (2, 9))
    found["sea"] = subject.water.sea.elevation(x, y, 7.3)
    check("orders", "water of a view", found, DOUBLE)


ORDERS: list[dict[str, Any]] = [
    {"do": "speed", "speed": 2.5}, {"do": "mode", "agent": "usv", "mode": "heading_speed"},
    {"do": "drive", "agent": "auv0", "surge": 0.4, "heave": -0.7, "yaw": 0.5},
    {"do": "drive", "agent": "auv0", "surge": 0.4, "heave": 0.3, "yaw": -3.0},
    {"do": "drive", "agent": "rov", "surge": 0.4, "sway": -0.2, "heave": 0.6, "yaw": 0.5},
    {"do": "drive", "agent": "usv", "surge": 0.9, "yaw": -0.5},
    {"do": "command", "agent": "usv", "values": [0.7, 0.9]},
    {"do": "goal", "agent": "auv0", "x": 9.0, "y": -4.0}, {"do": "goal", "agent": "auv0", "x": 1.0, "y": 9.0,
     "depth": 60.0},
    {"do": "goal_seen", "agent": "rov", "eye": [3.0, -2.0, -1.0], "way": [0.2, -0.4, -1.0]},
    {"do": "clear_goals", "agent": "rov"},
    {"do": "section", "what": "temperature", "along": "east"},
    {"do": "spawn", "shape": "cone", "x": 4.0, "y": -6.0, "size": 0.7}, {"do": "spawn", "x": 4.0, "y": 7.0,
     "depth": 5.0},
    {"do": "spawn_seen", "shape": "sphere", "eye": [3.0, -2.0, -1.0], "way": [-0.3, 0.5, -1.0], "size": 0.6},
    {"do": "move", "name": "crate", "x": -8.0, "y": 3.0},
    {"do": "move_seen", "name": "crate", "eye": [-9.0, 2.0, -1.0], "way": [0.1, 0.12, -1.0]},
    {"do": "record", "on": True}, {"do": "tick"}, {"do": "pause"}, {"do": "pause", "paused": False},
    {"do": "record"},
]  # fmt: skip
WATER: list[dict[str, Any]] = [
    {"do": "current", "speed": 0.4, "towards_deg": 70.0},
    {"do": "waves", "height": 1.2, "period": 6.5, "towards_deg": 200.0},
    {"do": "sun", "elevation_deg": 35.0, "azimuth_deg": 110.0}, {"do": "turbidity", "turbidity": 3.0},
]  # fmt: skip
WRONG: list[dict[str, Any]] = [
    {"do": "speed", "speed": 101}, {"do": "speed", "speed": True}, {"do": "reset", "seed": -1}, {"do": "current",
     "speed": 11, "towards_deg": 0},
    {"do": "waves", "height": 16, "period": 5, "towards_deg": 0}, {"do": "waves", "height": 3, "period": 3.0,
     "towards_deg": 0},
    {"do": "command", "agent": "usv", "values": 3}, {"do": "spawn", "shape": "torus", "x": 0, "y": 0},
    {"do": "move", "name": "nothing", "x": 0, "y": 0}, {"do": "drive", "agent": "auv9"}, {"do": "drive",
     "agent": "auv0", "yaw": "x"},
    {"do": "goal_seen", "agent": "rov", "eye": [0.0, 0.0, -1.0], "way": [0, 0, 1.0]},
    {"do": "goal_seen", "agent": "rov", "eye": [0, 0], "way": [0, 0, 1.0]},
    {"do": "goal_seen", "agent": "rov", "eye": [0.0, 0.0, -1.0], "way": [0, 0, 0.0]},
]  # fmt: skip


def test_orders(sim: pl.Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each order between two blocks: what is commanded, where all is, what the page is told."""
    sim.reset()
    live = Live(sim)
    driver = Pilot(sim, live)
    said: list[str] = []
    driver.say = lambda text, kind: said.append(text) if kind == "error" else None
    monkeypatch.chdir(tmp_path)
    orders = Orders(driver, Path("it"))
    view = View(subject_of(sim), live, orders, server=Nobody())  # type: ignore[arg-type]
    orders.soundings = Soundings(sim, view)
    view.show_bodies_of(sim.bodies)
    ear = view.hub
    assert isinstance(ear, Ear)
    live.status = driver.status
    quick_clock(monkeypatch)
    monkeypatch.setattr(driver._wake, "wait", lambda seconds: None)
    ear.told()
    found: dict[str, Any] = {}
    with sim.watch(live.heard):
        for number, order in enumerate(ORDERS):
            assert orders.obey(order)
            driver._obey()
            orders.soundings.look()
            driver._advance(5.0)
            name = f"{number} {order['do']}"
            found[name] = np.concatenate([*motions(sim), *(np.ravel(sim.held_command(a)) for a in sim.state)])
            if order["do"] in ("goal", "goal_seen", "drive", "pause", "tick"):
                found |= parts(f"{name} status", driver.status())
            if order["do"] in ("spawn", "spawn_seen", "move", "move_seen"):
                found[f"{name} bodies"] = np.concatenate([np.ravel(b.position) for b in sim.bodies.bodies])
            if number % 6 == 5:
                frame = live.take(0.0)
                assert frame is not None
                view._draw(frame)
                told = ear.told()
                found |= {f"{name} {k}": told[k] for k in ("state", "poses", "section", "water") if k in told}
    for _ in range(20):
        driver._follow_goals()
        sim.step(ticks=20)
    driver._follow_goals()
    found |= parts("goals", driver.goals)
    for order in WATER:  # another step would have kernels of its own
        orders.obey(order)
        driver._obey()
        orders.soundings.look()
        view._draw(ShownFrame(0, {}))
        found |= {f"{order['do']} {k}": v for k, v in ear.told().items() if k in ("water", "section", "part /currents")}
    assert not said, said
    for order in WRONG:
        orders.obey(order)
        driver._obey()
    found["refused"] = "\n".join(said)
    recorded = pl.Recording(Path("it") / "view-1.mcap")
    found["recorded"] = np.concatenate([recorded.times(topic) * 1e-9 for topic in recorded.topics("/truth")])
    orders.obey({"do": "reset", "seed": 5})
    driver._obey()
    found["after a reset"] = [*np.concatenate(motions(sim)), sim.seed, *driver.goals]
    check("orders", "orders", found, DOUBLE)


def test_a_pilot_alone(sim: pl.Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    """Times that blocks end at: as fast as it goes, by the clock, tick by tick, and after a reset."""
    quick_clock(monkeypatch)
    driver, times = Pilot(sim, Live(sim), speed=0.0), list[float]()
    monkeypatch.setattr(driver._wake, "wait", lambda seconds: None)
    orders = {3: lambda: setattr(driver, "speed", 2.0), 6: driver.single, 9: lambda: setattr(driver, "paused", False),
              11: driver.reset, 14: driver.stop_soon}  # fmt: skip

    def heard(block: Any) -> None:
        times.append(sim.time_ns * 1e-9)
        if len(times) in orders:
            driver.post(orders[len(times)])
        if len(times) == 7:
            driver.post(driver.single)
            driver.post(driver.single)

    with sim.watch(heard):
        driver.run()
    check("orders", "a pilot alone", {"times": times, "rate": [driver.status()["rate"]]}, DOUBLE)


def test_sticks_of_other_vehicles() -> None:
    """Depth, height and speed that a stick grows, in a mode of each kind, of no real vehicle."""
    given: list[Any] = []

    def vehicle(mode: str, names: tuple[str, ...], top: float | None) -> Any:
        envelope = SimpleNamespace(envelope=SimpleNamespace(top_mps=top))
        return SimpleNamespace(name="it", modes=(mode,), command_names=lambda m: names, config=envelope)

    state = SimpleNamespace(
        velocity=np.array([[1.3, 0.2, 0.1]]), euler=np.array([[0.1, 0.2, 0.7]]), depth=np.array([-31.0])
    )
    cases: list[tuple[str, tuple[str, ...], float | None]] = [
        ("height_heading_speed", ("height", "heading", "airspeed"), None), ("heading_speed", ("heading", "speed"),
         1.35),
        ("depth_heading_speed", ("depth", "heading", "speed"), 4.0),
    ]  # fmt: skip
    for mode, names, top in cases:
        there = itertools.chain((False, False), itertools.repeat(True))  # it is in the mode from the second stick on
        held = np.array([[4.0, 3.0, 1.0][: len(names)]])
        stub: Any = SimpleNamespace(
            model=SimpleNamespace(agents={"it": SimpleNamespace(vehicle=vehicle(mode, names, top))}),
            state={"it": state},
            stepper=SimpleNamespace(mode=lambda a, mode=mode, there=there: mode if next(there) else "x"),
            held_command=lambda a, held=held: held,
            set_mode=lambda a, m: given.append(m),
            command=given.append,
        )
        drive(stub, "it", Axes(0.5, 0.3, 0.4, -0.6), 0.2)
        drive(stub, "it", Axes.of({"surge": -0.5, "heave": -0.4, "yaw": 0.6}), 3.0)
    check("orders", "sticks", parts("given", given), DOUBLE)


def test_orders_of_a_run_that_somebody_else_steps() -> None:
    told: list[Any] = []
    sim: Any = SimpleNamespace(paused=False, pause=lambda: told.append("pause"), resume=lambda: told.append("resume"))
    watching = Watching(sim)
    found = [watching.obey(m) for m in ({"do": "pause"}, {"do": "pause", "paused": False}, {"do": "fly"})]
    assert (found, told) == ([True, True, False], ["pause", "resume"])
    assert watching.known == ("pause", "section")
