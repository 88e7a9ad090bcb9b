"""Missions of every leg by every vehicle that can do it, and the page that tells how: `python scripts/legs.py`.

Each mission is flown in a current of 0.2 m/s and sea state 2, and judged by the true track: a row has the time that it
took, the largest error, and what is allowed, which is the tolerance that the mission itself works with.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import pelagos as pl
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import on_circle
from pelagos.sim.guidance.steering.choice import KEEPING
from pelagos.sim.guidance.vertical import LEVEL_TOLERANCE_M, SURFACED_DEPTH_M, TURN_TOLERANCE_M
from pelagos.vehicles.family import Family, mission_mode
from pelagos.vehicles.load import catalogue_names

Floats = NDArray[np.float64]

PAGE: Final = Path(__file__).parent.parent / "docs/missions_legs.md"
CURRENT_MPS: Final = 0.2
TOWARDS: Final = np.array([math.cos(math.radians(60)), -math.sin(math.radians(60))])  # NWU
OCEAN: Final[dict[str, Any]] = {
    "currents": [{"type": "uniform", "speed_mps": CURRENT_MPS, "towards_deg": 60}],
    "waves": [{"type": "sea_state", "state": 2}],
}
SAMPLE_S: Final = 0.5
SETTLED_S: Final = 30.0  # before a vehicle that keeps, follows or drifts is judged
ADRIFT_MPS: Final = 0.1  # mean motion against the current, of what drifts
COURSE_DEG: Final = 10.0  # of a held course
BOTTOM_M: Final = 30.0  # depth; DEEP_M for ships
DEEP_M: Final = 300.0
DECK_M: Final = 2.0  # height of the deck that carries what flies
MAST_M: Final = 0.4  # antenna above the origin
TIMEOUT_S: Final = 30.0  # for a fix
COASTING_S: Final = 400.0  # of a drift; its last part is judged: an AUV needs minutes to lose its way
HEAVY: Final = 3.0  # times as long, for those longer than LONG_M: slender bodies of tonnes
LONG_M: Final = 4.0
TIMED: Final = 90.0  # how long the legs that end by time take [s]


@dataclass(frozen=True)
class Ground:
    """The size of a family's missions: length of a line, level [m], duration of waiting [s], ticks a second [Hz]."""

    length_m: float
    level_m: float
    seconds: float
    rate_hz: float


def coasting(vehicle: pl.Vehicle) -> float:
    """Duration of a drift [s]."""
    return COASTING_S * (HEAVY if vehicle.config.length_m > LONG_M else 1.0)


def ground(vehicle: pl.Vehicle, family: Family) -> Ground:
    """The size of the missions of a vehicle."""
    radius = vehicle.config.envelope.turn_radius_m or 0.0
    if family.name == "hover":
        return Ground(12.0, 6.0, TIMED, 50.0)
    if family.name == "rotor":
        return Ground(45.0, 6.0, TIMED, 100.0)
    if family.name == "surface":
        return Ground(
            max(60.0, 6 * radius), 0.0, 2 * TIMED if radius == 0 else 20 * TIMED, 50.0 if radius == 0 else 10.0
        )
    if family.name == "ship":
        return Ground(5 * radius, 0.0, 20 * TIMED, 10.0)
    if family.name == "glider":
        return Ground(6 * radius, 6.0, 10 * TIMED, 20.0)
    return Ground(6 * radius, 60.0 if family.name == "airplane" else 6.0, 5 * TIMED, 50.0)


@dataclass(frozen=True)
class Flight:
    """A mission flown.

    Attributes:
        sim: at its end.
        task: `(k,)` number of the task at each sample.
        track: `(k, 3)` true places [m].
        heading: `(k,)` of the compass [rad].
        leader: `(k, 4)` place [m] and yaw [rad] of the agent that is followed.
        done: whether the mission ended.
    """

    sim: pl.Simulation
    task: NDArray[np.int64]
    track: Floats
    heading: Floats
    leader: Floats
    done: bool

    @property
    def seconds(self) -> float:
        """Duration [s]."""
        return self.sim.time_ns * 1e-9


@dataclass(frozen=True)
class Trial:
    """A mission of one leg, by one vehicle: error `(flight) -> value` and its limit, in a unit."""

    legs: list[dict[str, Any]]
    error: Callable[[Flight], float]
    limit: float
    unit: str = "m"
    aground: bool = False  # over a deck that carries what flies
    leader: dict[str, Any] | None = None


# errors


def off_lines(flight: Flight) -> float:
    """Largest distance from the ends of the lines, and from the second half of those that have a beginning [m]."""
    worst = 0.0
    for k, step in enumerate(flight.sim.model.agents["a"].tasks):
        line = step.task
        if not isinstance(line, Line):
            continue
        at = np.flatnonzero(flight.task == k)
        here = flight.track[at[0] : at[-1] + 2, :2] if len(at) else flight.track[-1:, :2]
        end = np.array(line.end)
        worst = max(worst, float(np.hypot(*(here - end).T).min()))
        if line.start is not None:
            along = end - line.start
            length = float(np.hypot(*along))
            run = (here - line.start) @ along / length
            across = (here - line.start) @ np.array([-along[1], along[0]]) / length
            late = (run > 0.5 * length) & (run < length)
            worst = max(worst, float(np.abs(across[late]).max(initial=0.0)))
    return worst


def _last(flight: Flight) -> int:
    """Number of the last task."""
    return len(flight.sim.model.agents["a"].tasks) - 1


def late(flight: Flight, seconds: float = SETTLED_S) -> slice:
    """Samples from so long after the beginning of the last task on [s]."""
    begun = int(np.flatnonzero(flight.task == _last(flight))[0])
    return slice(min(begun + round(seconds / SAMPLE_S), len(flight.track) - 2), -1)


def from_circle(center: tuple[float, float], radius: float, settled: float = SETTLED_S) -> Callable[[Flight], float]:
    """Largest distance from a circle, once it is settled; radius 0: from a point [m]."""

    def error(flight: Flight) -> float:
        out = flight.track[late(flight, settled), :2] - center
        return float(np.abs(np.hypot(out[:, 0], out[:, 1]) - radius).max())

    return error


def from_level(z: float) -> Callable[[Flight], float]:
    """Vertical distance at the end [m]."""
    return lambda flight: abs(float(flight.track[-1, 2]) - z)


def from_end(point: tuple[float, ...]) -> Callable[[Flight], float]:
    """Least distance from a point over the last five seconds [m]."""
    size = len(point)
    return lambda flight: float(np.linalg.norm(flight.track[-10:, :size] - np.array(point), axis=1).min())


def off_course(flight: Flight) -> float:
    """Mean deviation from the first heading [deg]."""
    turned = np.angle(np.exp(1j * (flight.heading[late(flight, 10.0)] - flight.heading[0])))
    return abs(math.degrees(float(turned.mean())))


def not_adrift(seconds: float) -> Callable[[Flight], float]:
    """Mean horizontal velocity against the current at the end of a drift [m/s]."""

    def error(flight: Flight) -> float:
        way = flight.track[late(flight, seconds - SETTLED_S), :2]
        return float(np.hypot(*((way[-1] - way[0]) / (SAMPLE_S * (len(way) - 1)) - CURRENT_MPS * TOWARDS)))

    return error


def turning_depths(upper: float, lower: float) -> Callable[[Flight], float]:
    """Distance by which a profile misses its turning depths [m]."""

    def error(flight: Flight) -> float:
        depth = -flight.track[:, 2]
        bottom = int(np.argmax(depth))
        return max(lower - float(depth.max()), float(depth[bottom:].min()) - upper, 0.0)

    return error


def beside(offset: tuple[float, float, float], *, across: bool) -> Callable[[Flight], float]:
    """Largest distance from the place beside the leader, or, across, to its side only, once settled [m]."""

    def error(flight: Flight) -> float:
        part = slice(round(0.6 * len(flight.track)), -1)
        yaw = flight.leader[part, 3]
        ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=-1)
        left = np.stack([-np.sin(yaw), np.cos(yaw)], axis=-1)
        off = flight.track[part, :2] - flight.leader[part, :2] - offset[0] * ahead - offset[1] * left
        return float(np.abs((off * left).sum(axis=1)).max() if across else np.hypot(off[:, 0], off[:, 1]).max())

    return error


def waited(flight: Flight) -> float:
    """Duration of the last task [s]."""
    return float(SAMPLE_S * (flight.task == _last(flight)).sum())


# missions


@dataclass(frozen=True)
class Scene:
    """Numbers that a vehicle's missions are made of."""

    vehicle: pl.Vehicle
    family: Family

    @property
    def size(self) -> Ground:
        """Size of the missions."""
        return ground(self.vehicle, self.family)

    @property
    def near(self) -> float:
        """The vehicle's tolerance [m]."""
        return self.vehicle.config.envelope.tolerance_m

    @property
    def radius(self) -> float:
        """Turning circle of those that cannot stop; 0 of others [m]."""
        return 0.0 if self.family.stops else self.vehicle.config.envelope.turn_radius_m or 0.0

    @property
    def flies(self) -> bool:
        """Whether it is at home in the air."""
        return self.family.medium == "in the air"

    @property
    def z(self) -> float:
        """Height of the missions [m]."""
        return self.size.level_m if self.flies else -self.size.level_m

    def level(self, below: float = 0.0) -> dict[str, float]:
        """The keys of a level."""
        if self.family.medium == "at the surface":
            return {}
        return {"height_m" if self.flies else "depth_m": self.size.level_m + below}


def trials(vehicle: pl.Vehicle, family: Family) -> dict[str, Trial]:
    """A mission for every leg that a vehicle can do, by name."""
    scene = Scene(vehicle, family)
    made = lines(scene) | places(scene) | levels(scene) | waits(scene)
    return {name: made[name] for name in family.legs}


def lines(scene: Scene) -> dict[str, Trial]:
    """Legs along lines."""
    s, near, at = scene.size.length_m, scene.near, scene.level()
    gap = 2.4 * scene.radius or s / 3
    points = [[s, 0.0], [s, -s]]
    area = [[s, 0.0], [2 * s, 0.0], [2 * s, -2.2 * gap], [s, -2.2 * gap]]
    mowing = {"type": "lawnmower", "corner": points[0], "length_m": s, "width_m": gap, "spacing_m": gap, **at}
    square = {"type": "waypoints", "points": [*points, [0.0, -s]], **at}
    return {
        "waypoints": Trial([{"type": "waypoints", "points": points, **at}], off_lines, near),
        "lawnmower": Trial([mowing], off_lines, near),
        "survey": Trial([{"type": "survey", "area": area, "spacing_m": gap, **at}], off_lines, near),
        "goto": Trial([{"type": "goto", "points": points, **at}], off_lines, near),
        "repeat": Trial([square, {"type": "repeat", "times": 1}], off_lines, near),
    }


def places(scene: Scene) -> dict[str, Trial]:
    """Legs about a place or another vehicle."""
    s, at, radius, family = scene.size.length_m, scene.level(), scene.radius, scene.family
    cruise, waiting = scene.vehicle.config.envelope.cruise_mps, scene.size.seconds
    still, circle, kept = (s / 2, -s / 4), 1.5 * radius or s / 3, KEEPING * radius
    staying = {"type": "station_keeping", "point": list(still), "seconds": waiting, **at}
    circling = {"type": "orbit", "center": [s, 0.0], "radius_m": circle, "turns": 1.25, **at}
    dock = (s, -s / 2) if family.medium == "at the surface" else (s, -s / 2, scene.z)
    inside, way = (0.5, 8.0) if family.turns else (1.0, s / 2)
    docking = {"type": "dock", "point": list(dock), "heading_deg": 30, "approach_m": way, "tolerance_m": inside}
    offset = (-6.0, 3.0, 0.0) if family.turns else (-0.3 * s, 0.1 * s, 0.0)
    ship = family.name == "ship"
    speed = cruise * (1.0 if ship or family.name == "airplane" else 0.7)
    leader = {
        "vehicle": scene.vehicle.name,
        "mission": [{"type": "waypoints", "points": [[40 * s, 0.0]], **at, **({} if ship else {"speed_mps": speed})}],
        "start": {"position_m": [0.4 * s, 0.15 * s, scene.z], "speed_mps": speed if radius else 0.0},
    }
    following = {"type": "follow", "agent": "b", "offset_m": list(offset), "seconds": waiting}
    return {
        "station_keeping": Trial(
            [staying], from_circle(still, kept, waiting / 2), on_circle(kept) if radius else scene.near
        ),
        "orbit": Trial([circling], from_circle((s, 0.0), circle, 1.2 * s / cruise), on_circle(circle)),
        "dock": Trial([docking], from_end(dock), inside),
        "follow": Trial([following], beside(offset, across=ship), scene.near, leader=leader),
    }


def levels(scene: Scene) -> dict[str, Trial]:
    """Legs up and down."""
    change = 4.0
    yoyo = {"type": "profile", "upper_depth_m": 3, "lower_depth_m": 12, "cycles": 2}
    return {
        "dive": Trial(
            [{"type": "dive", **scene.level(change)}],
            from_level(scene.z + math.copysign(change, scene.z)), LEVEL_TOLERANCE_M,
        ),
        "surface": Trial([{"type": "surface"}], from_level(0.0), SURFACED_DEPTH_M),
        "profile": Trial([yoyo], turning_depths(3, 12), TURN_TOLERANCE_M),
        "land": Trial([{"type": "land"}], landed(scene), 0.1, aground=scene.flies),
    }  # fmt: skip


def waits(scene: Scene) -> dict[str, Trial]:
    """Legs that pass time."""
    drift = coasting(scene.vehicle)
    up = [{"type": "surface"}] if scene.family.medium == "under water" else []
    return {
        "hold": Trial([{"type": "hold", "seconds": scene.size.seconds}], off_course, COURSE_DEG, "deg"),
        "drift": Trial([{"type": "drift", "seconds": drift}], not_adrift(drift), ADRIFT_MPS, "m/s"),
        "gps_fix": Trial([*up, {"type": "gps_fix", "timeout_s": TIMEOUT_S}], waited, TIMEOUT_S - 1.0, "s"),
    }


def landed(scene: Scene) -> Callable[[Flight], float]:
    """Distance of the hull's lowest point from what is below at the end [m]."""
    lowest = float(np.asarray(scene.vehicle.hull.vertices)[:, 2].min())
    return lambda flight: abs(float(flight.track[-1, 2]) + lowest - (DECK_M if scene.flies else -BOTTOM_M))


def fly(vehicle: pl.Vehicle, family: Family, trial: Trial) -> Flight:
    """A mission flown, until it ends or takes too long."""
    size = ground(vehicle, family)
    z = size.level_m if family.medium == "in the air" else -size.level_m
    radius = vehicle.config.envelope.turn_radius_m
    mast = max(MAST_M, vehicle.config.height / 2 + MAST_M / 2)  # above the hull of what lies deep in the water
    start = {"position_m": [0.0, 0.0, z], "speed_mps": vehicle.config.envelope.cruise_mps if radius else 0.0}
    sensors = {"gps": {"type": "gps", "rate_hz": 1, "position_m": [0, 0, mast]}}
    agents: dict[str, Any] = {"a": {"vehicle": vehicle.name, "start": start, "mission": trial.legs, "sensors": sensors}}
    if trial.leader is not None:
        agents["b"] = trial.leader
    data = {
        "tick_rate_hz": size.rate_hz,
        "world": {"type": "flat", "depth_m": DEEP_M if family.name == "ship" else BOTTOM_M},
        "ocean": OCEAN,
        "agents": agents,
    }
    sim = pl.Simulation.load(data)
    if trial.aground:
        sim.spawn(pl.Prop("box", position=(0.0, 0.0, DECK_M - 0.5), size=(40.0, 40.0, 1.0)))
    return recorded(sim, longest(vehicle, size))


def longest(vehicle: pl.Vehicle, size: Ground) -> float:
    """Time after which a mission has failed [s]."""
    return 5 * size.seconds + 20 * size.length_m / vehicle.config.envelope.cruise_mps


def recorded(sim: pl.Simulation, seconds: float) -> Flight:
    """A simulation run until the mission of `a` ends."""
    rows: list[tuple[Any, ...]] = []
    progress = sim.stepper.missions.guidance["a"]
    other = "b" if "b" in sim.model.agents else "a"
    while True:
        state, done, lead = sim.state["a"], progress.done, sim.state[other]
        leader = np.append(lead.position[0], lead.euler[0, 2])
        rows.append((int(progress.progress.task[0]), state.position[0], -state.euler[0, 2], leader))
        if done or sim.time_ns > seconds * 1e9:
            break
        sim.run(SAMPLE_S)
    task, track, heading, leaders = (np.array(column) for column in zip(*rows, strict=True))
    return Flight(sim, task, track, heading, leaders, done)


@dataclass(frozen=True)
class Row:
    """The outcome of a mission."""

    vehicle: str
    leg: str
    seconds: float
    error: float
    limit: float
    unit: str
    reached: bool

    def __str__(self) -> str:
        error = f"{self.error:.2f} {self.unit}"
        shown = error if self.reached else f"**{error}**"
        return f"| {self.vehicle} | `{self.leg}` | {self.seconds:.0f} s | {shown} | {self.limit:g} {self.unit} |"


def rows(name: str, wanted: list[str] | None = None) -> Iterator[Row]:
    """Outcomes of a vehicle's missions."""
    vehicle = pl.Vehicle.from_catalogue(name)
    found = mission_mode({mode: tuple(vehicle.command_names(mode)) for mode in vehicle.modes})
    assert found is not None
    for leg, trial in trials(vehicle, found[1]).items():
        if wanted and leg not in wanted:
            continue
        flight = fly(vehicle, found[1], trial)
        error = trial.error(flight)
        yield Row(name, leg, flight.seconds, error, trial.limit, trial.unit, flight.done and error <= trial.limit)


def head(*, all_reached: bool) -> list[str]:
    """The page down to the table."""
    return [
        "# Every leg by every vehicle\n",
        f"A [mission](missions.md) of every leg, by every vehicle of the catalogue that can do it, in a current of "
        f"{CURRENT_MPS:g} m/s and sea state 2: its duration, its largest error by the true motion, and what is "
        "allowed, the tolerance that the mission itself works with. Made by `python scripts/legs.py`; `make test-all` "
        "flies them all.\n",
        "* Lines (`waypoints`, `lawnmower`, `survey`, `goto`, `repeat`): from the end of each line, and from the "
        "second half of each that has a beginning; within the vehicle's tolerance.\n"
        "* `station_keeping`: from the place, or for those that cannot stop from their circle. Circles, `orbit` too: "
        "within a quarter of the radius and 1 m, where an orbit counts a vehicle as on it.\n"
        "* `follow`: from the place beside another vehicle of the same type, which goes in a line; ships, whose engine "
        "no mission regulates, abeam of it only.\n"
        f"* `dive` (1 m), `surface`, `profile`: from the level; `dock` 0.5 m for those that turn on the spot, 1 m for "
        f"others. `land`: of the hull's lowest point from the seabed, or from a deck {DECK_M:g} m above the sea.\n"
        "* `gps_fix`: the time until it has three fixes, before the leg gives up. `hold`: mean deviation from the "
        "heading. `drift`: mean speed against the current, over the last part of 400 s.\n",
        "Bold would be what misses; nothing does.\n" if all_reached else "Bold is what misses.\n",
        "| vehicle | leg | took | error | allowed |",
        "|---|---|---|---|---|",
    ]


def main() -> None:
    """Write the page, or the rows of some vehicles to the terminal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vehicles", nargs="*", help="of the catalogue; all, and the page is written, without")
    parser.add_argument("--leg", action="append", help="only this leg; may be given again")
    given = parser.parse_args()
    made: list[Row] = []
    for name in given.vehicles or catalogue_names():
        for row in rows(name, given.leg):
            print(row, flush=True)
            made.append(row)
    if not given.vehicles and not given.leg:
        text = [*head(all_reached=all(row.reached for row in made)), *map(str, made)]
        PAGE.write_text("\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
