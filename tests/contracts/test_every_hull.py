"""No hull, actuator or control law knows north, or port from starboard: turned about the vertical with all that flows,
a hull feels and is pushed by the same wrench; mirrored, by the mirrored one, and a law asks for the mirrored push.

And control laws remember by time, not by calls: a step of no length changes nothing of what they keep in mind, and a
short one changes half of what one twice as long does.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import numpy as np
import pytest
from mirror_image import HELMS, ONE_HAND, ONE_HAND_ROLLS, SLANTED, image, slanted
from sample_parts import parts, samples

import pelagos as pl
from pelagos import jit
from pelagos.hydro.algebra import add
from pelagos.vehicles.actuators.t200 import t200_tables
from pelagos.vehicles.cargo import Carrier
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow, Supply
from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.wetness import Wetness

NAMES = sorted(catalogue_names())
LANES = 8
MIRROR3, MIRROR6 = np.array([1.0, -1.0, 1.0]), np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
HANDED = {
    "actuators": "passes commands on, which are each actuator's own",
    "engine_forces": "names its thrusters by number: tests of HoloOcean's agents hold them",
}
"""Kinds of control mode whose set-points have no mirror image by name, and why."""
DEAR = ("bluerov2", "bluerov2_heavy")  # curves of T200 thrusters take long to compile
JUMPS = {
    "acceleration": "keeps the drift's part in body axes, which turn",
    "sawtooth": "keeps which way it goes, up or down",
}
"""Kinds of control mode whose memory changes in a step of no length, and why."""


class Scene:
    """Motions of both signs, unequal in all components; world NED."""

    def __init__(self, fast: float, seed: int = 11) -> None:
        rng = np.random.default_rng(seed)
        self.place = rng.uniform(-1, 1, (LANES, 3)) * [9.0, 7.0, 0.3] + [0.0, 0.0, 0.4]
        self.place[::2, 2] += 20.0
        self.euler = rng.uniform(-1, 1, (LANES, 3)) * [0.5, 0.4, 3.0]
        self.nu = rng.uniform(-1, 1, (LANES, 6)) * [fast, 0.4 * fast, 0.3 * fast, 0.5, 0.4, 0.6]
        self.water = rng.uniform(-0.3, 0.3, (LANES, 6)) * [1.0, 1.0, 1.0, 0.02, 0.03, 0.01]
        self.air = rng.uniform(-9.0, 9.0, (LANES, 3))
        self.surface = 0.1 * rng.normal(size=(LANES, 2))
        self.wet = rng.uniform(0.2, 0.9, (LANES, 2))

    def flow(self, turn: float = 0.0, *, mirrored: bool = False) -> Flow:
        side3, side6 = (MIRROR3, MIRROR6) if mirrored else (np.ones(3), np.ones(6))
        angles = self.euler * ([-1.0, 1.0, -1.0] if mirrored else 1.0) + [0.0, 0.0, turn]
        (cr, cp, cy), (sr, sp, sy) = np.cos(angles.T), np.sin(angles.T)
        rotation = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        north, east, down = (self.place * side3).T
        place = [np.cos(turn) * north - np.sin(turn) * east, np.sin(turn) * north + np.cos(turn) * east, down]
        lanes = lambda rows: [jit.Float64(np.ascontiguousarray(r)) for r in rows]
        nu, water = self.nu * side6, self.water * side6
        air, wet = lanes((self.air * side3).T), self.wet
        return Flow(
            position=lanes(place), immersion=jit.Float64(place[2].copy()), rotation=[lanes(row) for row in rotation],
            nu=lanes(nu.T), nu_r=lanes((nu - water).T), current_rate=lanes(0.1 * water.T),
            surface=lanes((self.surface * ([-1.0, 1.0] if mirrored else 1.0)).T), air=lambda height: air,
            step=jit.Float64(0.05), water_acceleration=lanes(0.1 * water.T), wet=Wetness(*lanes(wet.T)),
        )  # fmt: skip


def forces(vehicle: pl.Vehicle, flow: Flow) -> dict[str, list[Any]]:
    return {name: list(term.wrench(flow)) for name, term in vehicle.model.terms.items()}


def rows(load: list[Any]) -> np.ndarray:
    """`(lanes, 6)`."""
    return np.stack([np.broadcast_to(np.array(v, dtype=np.float64), LANES) for v in load], axis=-1)


@pytest.mark.parametrize("name", NAMES)
def test_a_hull_feels_the_same_at_every_heading_and_the_mirror_image_in_the_mirror(name: str) -> None:
    vehicle = pl.Vehicle.from_catalogue(name)
    scene = Scene(max(vehicle.config.length_m**0.5, 1.0) * (8.0 if vehicle.config.medium == "air" else 1.0))
    found = [forces(vehicle, f) for f in (scene.flow(), scene.flow(2.1), scene.flow(mirrored=True))]
    dr.eval(*[load for part in found for load in part.values()])
    for term, load in found[0].items():
        here, turned, image = rows(load), rows(found[1][term]), rows(found[2][term])
        size = 1e-9 * np.abs(here).max() + 1e-12
        assert turned == pytest.approx(here, abs=size), term
        assert image == pytest.approx(here * MIRROR6, abs=size), term


@pytest.mark.parametrize("name", NAMES)
def test_an_actuator_pushes_the_same_at_every_heading_and_the_mirror_image_in_the_mirror(name: str) -> None:
    """Each of a vehicle and each sample for it: its state goes after the mirrored command as the image's does."""
    vehicle = pl.Vehicle.from_catalogue(name)
    fast = max(vehicle.config.length_m**0.5, 1.0)
    own: dict[str, Any] = {n: part for n, part in vehicle.config.actuators.items() if part is not None}
    rng, body = np.random.default_rng(6), vehicle.config.body
    laws = {n: part.build(body).lag for n, part in own.items()}
    states = {n: rng.uniform(-1, 1, LANES) * (law.high if law.low < 0 else 0.5 * law.high) for n, law in laws.items()}
    scenes = [Scene(fast).flow(), Scene(fast).flow(2.1), Scene(fast).flow(mirrored=True)]
    for flow, mirrored in zip(scenes, (False, False, True), strict=True):
        flow.actuators = {n: jit.Float64((image(part)[1] if mirrored else 1.0) * states[n]) for n, part in own.items()}
        if vehicle.config.battery is not None:
            tables = t200_tables(vehicle.config.battery.open_circuit_v)
            flow.supply = Supply(jit.Float64(np.linspace(12.3, 16.1, LANES)), tables)
    tried = own | {f"sample {k}": part for k, part in enumerate(samples("actuators", name))}
    found = {at: [pushed(part, body, flow) for flow in scenes[:2]] for at, part in tried.items()}
    for at, part in tried.items():
        other, sign = image(part)
        found[at].append(pushed(other, body, scenes[2], sign))
    dr.eval(found)
    for at, part in tried.items():
        (here, goes), (turned, went), (mirrored, after) = ((rows(w), rows(g)) for w, g in found[at])
        size = 1e-9 * np.abs(here).max() + 1e-12
        flips = MIRROR6 if part.type not in ONE_HAND else np.where(ONE_HAND_ROLLS, 1.0, MIRROR6)
        assert turned == pytest.approx(here, abs=size), at
        assert mirrored == pytest.approx(here * flips, abs=size), at
        assert went == pytest.approx(goes, rel=1e-12), at
        assert image(part)[1] * after[:, :1] == pytest.approx(goes[:, :1], rel=1e-9, abs=1e-12), at


def pushed(part: Any, body: Any, flow: Flow, sign: float = 1.0) -> tuple[list[Any], list[Any]]:
    """Wrench at a state of either sign, and where the state goes in a step; `sign`: of both, see `image`."""
    made = part.build(body)
    law = made.follower(flow) if isinstance(made, Carrier) else made.lag
    rng = np.random.default_rng(3)
    low, high = (float(getattr(law, end, sign)) for end in ("low", "high"))
    low, high = (low, high) if sign > 0 else (-high, -low)
    state, command = (jit.Float64(sign * rng.uniform(1.2 * low, 1.2 * high, LANES)) for _ in range(2))
    kept = [jit.Float64(rng.uniform(0, 1, LANES)) for _ in range(law.memory)]
    return list(made.wrench(law.limited(state), flow)), law.after(state, kept, command, jit.Float64(0.05))[:1]


def test_what_is_slanted_is_so_by_the_constants_that_say_so() -> None:
    """Derivatives that tell port from starboard: some publications have them, no other vehicle has any."""
    found = {}
    for name in NAMES:
        for part in pl.Vehicle.from_catalogue(name).config.actuators.values():
            vertical = getattr(part, "type", "") == "plane" and image(part)[1] > 0
            if odd := slanted(getattr(part, "derivatives", {}), vertical=vertical):
                found.setdefault(name, set()).update(odd)
    assert found == SLANTED


def laws() -> dict[str, list[Any]]:
    """By vehicle, modes of kinds, or with set-points, that no vehicle before it has; samples too."""
    tried: set[tuple[str, ...]] = set()
    chosen: dict[str, list[Any]] = {}
    for vehicle, modes in sorted(parts("modes"), key=lambda found: found[0].config.battery is not None):
        plant = Plant(vehicle.model, vehicle.config.body)
        for mode in modes:
            law: Any = mode
            key = (law.type, *(law.build(plant).commands if law.type != "actuators" else ()))
            if key not in tried:
                chosen.setdefault(vehicle.name, []).append(law)
                tried.add(key)
    return chosen


LAWS = laws()


@pytest.mark.parametrize("name", sorted(LAWS))
def test_a_control_law_remembers_by_time_and_not_by_calls(name: str) -> None:
    vehicle = pl.Vehicle.from_catalogue(name)
    plant = Plant(vehicle.model, vehicle.config.body)
    fast = max(vehicle.config.length_m**0.5, 1.0)
    first, flow = Scene(fast).flow(), Scene(fast, seed=12).flow()
    rng, kept = np.random.default_rng(3), {}
    for k, mode in enumerate(LAWS[name]):
        law = mode.build(plant)
        before = list(law.start(first))
        command = [jit.Float64(0.3 * rng.uniform(-1, 1, LANES)) for _ in law.commands]
        after = [law.act(before, flow, command, jit.Float64(h))[1] for h in (1e-9, 1e-4, 2e-4)]
        kept[k] = before, *after
    dr.eval(*[part for parts in kept.values() for part in parts])
    for k, told in kept.items():
        kind = LAWS[name][k].type
        if kind in JUMPS or not told[0]:
            continue
        before, none, one, two = (rows(p) for p in told)
        assert none == pytest.approx(before, abs=1e-6), kind
        assert two - before == pytest.approx(2.0 * (one - before), abs=1e-3 * np.abs(two - before).max() + 1e-9), kind


ODD_WORDS = ("y", "roll", "yaw", "sway", "heading")
"""First words of set-points that change their sign in the mirror; of turns about the world's axes, x and z do."""


def changes_sign(command: str) -> bool:
    """Whether a set-point's image is its negative."""
    if command.endswith("_turn"):
        return command[0] in "xz"
    return command.removeprefix("from_").removeprefix("to_").removeprefix("current_").split("_")[0] in ODD_WORDS


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in DEAR else n for n in sorted(LAWS)])
def test_a_control_law_asks_in_the_mirror_for_the_mirrored_push(name: str) -> None:
    """Twice on end, with what it keeps in mind: wrench, acceleration, thrusters across, and the push of the rest."""
    vehicle = evenhanded(pl.Vehicle.from_catalogue(name))
    plant, fast = Plant(vehicle.model, vehicle.config.body), max(vehicle.config.length_m**0.5, 1.0)
    own: dict[str, Any] = {n: part for n, part in vehicle.config.actuators.items() if part is not None}
    across = partners(own)
    found: dict[int, list[list[Any]]] = {}
    tried = {k: mode for k, mode in enumerate(LAWS[name]) if mode.type not in HANDED}
    for k, mode in tried.items():
        law = mode.build(plant)
        for mirrored in (False, True):
            rng = np.random.default_rng(3)
            flows = [supplied(Scene(fast, seed=s).flow(mirrored=mirrored), vehicle, mirrored) for s in (11, 12)]
            memory, asked = law.start(flows[0]), []
            for flow, size in zip(flows, (0.5, 3.0), strict=True):
                values = [size * rng.uniform(-1, 1, LANES) for _ in law.commands]
                signs = [-1.0 if mirrored and changes_sign(c) else 1.0 for c in law.commands]
                command = [jit.Float64(s * v) for s, v in zip(signs, values, strict=True)]
                demand, memory = law.act(memory, flow, command, jit.Float64(0.02))
                side = MIRROR6 if mirrored else np.ones(6)
                for load in (demand.wrench, demand.acceleration, together(demand.actuators, own, vehicle, flow)):
                    asked += [s * jit.Float64(x) for s, x in zip(side, load or (), strict=False)]
                for n in demand.actuators:
                    at, sign = across[n] if mirrored and n in across else (n, 1.0)
                    sign = image(own[n])[1] if mirrored and own[n].type in HELMS else sign
                    if n in across or own[n].type in (*HELMS, "ship_engine"):
                        asked.append(sign * jit.Float64(demand.actuators[at]))
            found.setdefault(k, []).append(asked)
    dr.eval(found)
    for k, (here, mirrored_) in found.items():
        one, other = rows(here), rows(mirrored_)
        assert np.abs(one).max() > 0, LAWS[name][k].type
        assert other == pytest.approx(one, rel=1e-9, abs=1e-9 * np.abs(one).max()), LAWS[name][k].type


def supplied(flow: Flow, vehicle: pl.Vehicle, mirrored: bool) -> Flow:
    """With actuators in some state, and a full battery."""
    states = np.random.default_rng(6).uniform(0.1, 0.4, (len(vehicle.model.actuators), LANES))
    for (name, actuator), state in zip(vehicle.model.actuators.items(), states, strict=True):
        sign = image(vehicle.config.actuators[name])[1] if mirrored else 1.0
        flow.actuators = {**flow.actuators, name: jit.Float64(sign * state * float(actuator.lag.high))}
    if vehicle.config.battery is not None:
        tables = t200_tables(vehicle.config.battery.open_circuit_v)
        flow.supply = Supply(jit.Float64(np.linspace(12.3, 16.1, LANES)), tables)
    return flow


def evenhanded(vehicle: pl.Vehicle) -> pl.Vehicle:
    """Without the torques of T200 propellers, whose hands are no mirror images of one another."""
    t200 = [n for n, part in vehicle.config.actuators.items() if getattr(part, "type", "") == "t200"]
    return pl.Vehicle.from_catalogue(vehicle.name, actuators={n: {"torque_m": 0.0} for n in t200}) if t200 else vehicle


def partners(own: dict[str, Any]) -> dict[str, tuple[str, float]]:
    """Of each thruster, the one across and the sign of its command; some are their own."""
    found = {}
    for name, part in own.items():
        if hasattr(part, "direction"):
            other = image(part)[0]
            for candidate, there in own.items():
                if hasattr(there, "direction") and np.allclose(there.position_m, other.position_m):
                    found[name] = candidate, float(np.sign(np.dot(there.direction, other.direction)))
    return found


def together(asked: Any, own: dict[str, Any], vehicle: pl.Vehicle, flow: Flow) -> list[Any]:
    """Wrench (6) of all fins, screws and masses that do as they are asked, without the torque of a single screw."""
    load: list[Any] = [0.0] * 6
    for name, command in asked.items():
        if own[name].type not in HELMS and not hasattr(own[name], "direction"):
            made = vehicle.model.actuators[name]
            load = add(load, made.wrench(made.lag.limited(command), flow))
            if own[name].type in ONE_HAND:
                load[3] = 0.0 * load[3]
    return load


SWELL = {"waves": {"type": "regular", "height_m": 0.4, "period_s": 4.0, "towards_deg": 40.0, "phase_deg": 70.0}}


def floats(name: str, level: float, waves: bool) -> np.ndarray:
    """Height over the water, attitude and velocities after 1.5 s of a vehicle let go 6 cm below a steady level."""
    tide = {"period_h": 1e5, "amplitude_m": abs(level), "phase_deg": 0.0 if level > 0 else 180.0}
    start = {"position_m": [0.0, 0.0, level - 0.06], "pitch_deg": 8.0, "roll_deg": -5.0}
    sim = pl.Simulation.load({
        "tick_rate_hz": 50,
        "world": {"type": "flat", "depth_m": 60.0},
        "ocean": {"tide": tide, **(SWELL if waves else {})},
        "agents": {"it": {"vehicle": name, "start": start, "control": "actuators"}},
    })  # fmt: skip
    sim.run(1.5)
    state = sim.state["it"]
    return np.concatenate([state.position[0, 2:] - level, state.euler[0], state.velocity[0], state.angular_velocity[0]])


@pytest.mark.parametrize(("name", "waves"), [("remus100", True), ("otter", False), ("otter", True), ("mariner", True)])
def test_a_vehicle_at_the_surface_knows_the_tides_level_alone(name: str, waves: bool) -> None:
    """Where its water stands 0.8 m higher or 1.1 m lower, all of it is there."""
    high, low = floats(name, 0.8, waves), floats(name, -1.1, waves)
    assert np.abs(high[4:]).max() > 1e-2  # it moves
    assert low == pytest.approx(high, abs=5e-5)  # the column of water is denser by 1e-5 where it stands 1.9 m deeper
