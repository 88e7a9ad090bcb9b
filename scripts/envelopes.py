"""Envelopes of vehicles, a table of every vehicle and control mode in six places: `python scripts/envelopes.py`.

Modes with a speed go ahead at cruising speed, 40 degrees off the first heading; the others hold their idle command
(stay here, actuators at rest). A cell has the largest tilt [deg] and the largest speed [m/s] of the run, sampled once
a second, ten times as often at first; a run that is not finite, or faster than 60 m/s, explodes, and what lies beyond
the stated limits is bold.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import pelagos as pl
from pelagos.errors import PelagosError
from pelagos.vehicles.load import catalogue_names

Floats = NDArray[np.float64]

PAGE: Final = Path(__file__).parent.parent / "docs/vehicles_envelopes.md"
BOTTOM_M: Final = 200.0
PLACES: Final = ("calm", "sea state 4", "current 0.5 m/s", "near bottom", "surface", "air")
TOGETHER: Final = ("calm", "surface", "air")  # in one simulation; each tick near the ground is dear
OCEANS: Final[dict[str, dict[str, Any]]] = {
    "sea state 4": {"waves": [{"type": "sea_state", "state": 4}]},
    "current 0.5 m/s": {"currents": [{"type": "uniform", "speed_mps": 0.5, "towards_deg": 60}]},
}
FASTEST: Final = 60.0  # [m/s]: what goes faster has exploded
SAMPLE_S: Final = 1.0  # after ten seconds, until then ten times as often
PILOT_PER_S: Final = 0.3  # a pilot who has only speeds keeps the height so
CLEAR_M: Final = 0.5  # between the hull and the bottom, `near bottom`
STEEPEST_DEG: Final = 60.0  # tilt that is stated for all
RISING_MPS: Final = 0.6  # speed at which what is light rises, or what is heavy sinks, with no thrust


def afloat(vehicle: pl.Vehicle) -> bool:
    """Whether it is at home at the surface."""
    return bool({getattr(t, "type", "") for t in vehicle.config.terms.values()} & {"hydrostatic", "twin_hull"})


def draught(vehicle: pl.Vehicle) -> float:
    """Lowest point of a hull below its origin [m]."""
    return -float(np.asarray(vehicle.hull.vertices)[:, 2].min())


def heights(vehicle: pl.Vehicle) -> dict[str, float]:
    """Height at which a vehicle begins, by place [m] up from the mean surface."""
    flies = vehicle.config.medium == "air"
    usual = (100.0 if airplane(vehicle) else 10.0) if flies else 0.0 if afloat(vehicle) else -8.0
    near = 0.0 if afloat(vehicle) else -BOTTOM_M + draught(vehicle) + CLEAR_M
    return {"calm": usual, "sea state 4": usual, "current 0.5 m/s": usual, "near bottom": near, "surface": 0, "air": 5}


def airplane(vehicle: pl.Vehicle) -> bool:
    """Whether it flies by its speed."""
    return any("airspeed" in vehicle.command_names(mode) for mode in vehicle.modes)


def command(vehicle: pl.Vehicle, mode: str, held: Floats, first: Floats, z: Floats) -> Floats:
    """Set-points `(n, k)` of a run, from the idle ones, the first and the present heights `(n,)` [m]."""
    cruise, names = vehicle.config.envelope.cruise_mps, tuple(vehicle.command_names(mode))
    below = np.maximum(-first, 0.0)
    asked: dict[str, Any] = {
        "speed": cruise, "surge_speed": cruise, "yaw_rate": 0.1, "heave_speed": PILOT_PER_S * (first - z),
        "heading": math.radians(40), "to_x": 1e4, "to_y": -8e3, "drive": 1.0,
        "altitude": np.clip(first, 1 - BOTTOM_M, -2) + BOTTOM_M, "measured_altitude": z + BOTTOM_M,
    }  # fmt: skip
    if "glide_pitch" in names:
        asked |= {"upper_depth": 3.0, "depth": np.where(below > 0, below, 8.0), "glide_pitch": math.radians(25)}
    made = held.copy()
    for k, name in enumerate(names):
        if name in asked:
            made[:, k] = asked[name]
    return made


def limits(vehicle: pl.Vehicle, mode: str, place: str) -> tuple[float, float]:
    """Stated envelope of a run: largest tilt [deg] and speed [m/s], with what the water adds and what it falls."""
    envelope = vehicle.config.envelope
    own = max(envelope.top_mps or envelope.cruise_mps, RISING_MPS)
    added = {"sea state 4": 2.0, "current 0.5 m/s": 0.5}.get(place, 0.0)
    fallen = math.sqrt(2 * 9.81 * heights(vehicle)[place]) if heights(vehicle)[place] > 0 else 0.0
    lies = place in ("surface", "near bottom")  # in the water, where it floats as it likes
    left = vehicle.config.medium == "air" and (lies or mode in ("actuators", "wrench"))
    return (180.0 if left or place == "air" else STEEPEST_DEG), own + added + fallen


def run(vehicle: pl.Vehicle, mode: str, places: tuple[str, ...], seconds: float, rate: float) -> dict[str, str]:
    """Cells of places that share an ocean and a bottom, one copy each."""
    shallow = places == ("near bottom",) and afloat(vehicle)
    scenario = {
        "tick_rate_hz": rate,
        "world": {"type": "flat", "depth_m": draught(vehicle) + CLEAR_M if shallow else BOTTOM_M},
        "ocean": OCEANS.get(places[0], {}),
        "agents": {"it": {"vehicle": vehicle.name, "control": mode}},
    }
    z = heights(vehicle)
    try:
        sim = pl.Simulation.load(scenario, n=len(places))
        begin: dict[str, Any] = {"position": [[0.0, 0.0, z[p]] for p in places]}
        if airplane(vehicle):
            begin["velocity"] = [[vehicle.config.envelope.cruise_mps * (z[p] == z["calm"]), 0.0, 0.0] for p in places]
        sim.reset(state={"it": begin})
        held, first = sim.held_command("it"), np.array([z[p] for p in places])
        height = first
        tilt, speed = np.zeros(len(places)), np.zeros(len(places))
        steered = {"measured_altitude", "heave_speed"} & set(vehicle.command_names(mode))
        for step_s in [0.1] * 100 + [SAMPLE_S] * round((seconds - 10.0) / SAMPLE_S):
            if held.size and (sim.time_ns == 0 or steered):
                sim.command({"it": command(vehicle, mode, held, first, height)})
            sim.run(step_s)
            state = sim.state["it"]
            height = state.position[:, 2]
            x, y = state.attitude[:, 1], state.attitude[:, 2]
            tilt = np.maximum(tilt, np.degrees(np.arccos(np.clip(1 - 2 * (x * x + y * y), -1, 1))))
            speed = np.maximum(speed, np.linalg.norm(state.velocity, axis=1))
    except PelagosError as error:
        return {place: f"**{type(error).__name__}**" for place in places}
    return {
        p: cell(float(lean), float(fast), limits(vehicle, mode, p))
        for p, lean, fast in zip(places, tilt, speed, strict=True)
    }


def cell(lean: float, fast: float, limit: tuple[float, float]) -> str:
    """Tilt [deg] and speed [m/s], bold beyond the limits."""
    if not fast < FASTEST:
        return "**explodes**"
    text = f"{lean:.0f}, {fast:.1f}"
    return text if lean <= limit[0] and fast <= limit[1] else f"**{text}**"


def lines(names: list[str], seconds: float, near_s: float, rate: float) -> Iterator[str]:
    """Rows of the table."""
    for name in names:
        vehicle = pl.Vehicle.from_catalogue(name)
        for mode in vehicle.modes:
            cells = run(vehicle, mode, TOGETHER, seconds, rate)
            for place in OCEANS:
                cells |= run(vehicle, mode, (place,), seconds, rate)
            cells |= run(vehicle, mode, ("near bottom",), near_s, rate)
            yield f"| {name} | `{mode}` | " + " | ".join(cells[place] for place in PLACES) + " |"


def head(seconds: float, near_s: float, rate: float) -> list[str]:
    """The page down to the table."""
    return [
        "# Envelopes of vehicles\n",
        f"Every vehicle and control mode, {seconds:g} s at {rate:g} ticks a second over a bottom at {BOTTOM_M:g} m: "
        "largest tilt [deg], largest speed [m/s]. Modes with a speed go ahead at cruising speed, 40 degrees off the "
        "first heading (with `velocity` a pilot turns and keeps the depth); the others hold their idle command (stay "
        "here, actuators at rest).\n",
        "Vehicles under water begin at 8 m, aeroplanes 100 m up with their cruising speed, rotorcraft 10 m up, boats "
        f"at the mean surface. `near bottom` is {CLEAR_M:g} m clear of it, for {near_s:g} s: boats float over a bottom "
        "that is so near, and what flies lies there in the water and floats up. `surface` is with the origin at it, "
        "`air` from 5 m up, without speed.\n",
        f"What must hold: a tilt of at most {STEEPEST_DEG:g} degrees, and a speed of at most the vehicle's top speed "
        f"(at least {RISING_MPS:g} m/s: what is light rises), 2 m/s more in sea state 4, that of the current, and that "
        "of a fall from its height. Tilt has no limit where a vehicle falls from the air, flies without its autopilot, "
        "or floats though it is made to fly. A cell beyond is bold. The BlueROV2 of six thrusters leans most under a "
        "pilot in waves, because nothing pitches it ([more](vehicles.md)). Mode `acceleration` holds accelerations "
        "of 0: gravity is no part of it. "
        f"Made by `python scripts/envelopes.py --seconds {seconds:g} --near-seconds {near_s:g}`.\n",
        "| vehicle | mode | " + " | ".join(PLACES) + " |",
        "|---" * (2 + len(PLACES)) + "|",
    ]


def main() -> None:
    """Write the page, or the rows of some vehicles to the terminal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vehicles", nargs="*", help="of the catalogue; all, and the page is written, without")
    parser.add_argument("--seconds", type=float, default=600.0, help="of each run [s]")
    parser.add_argument("--near-seconds", type=float, default=600.0, help="of each run near the bottom [s]")
    parser.add_argument("--rate", type=float, default=50.0, help="ticks a second [Hz]")
    given = parser.parse_args()
    rows = []
    for row in lines(given.vehicles or list(catalogue_names()), given.seconds, given.near_seconds, given.rate):
        print(row, flush=True)
        rows.append(row)
    if not given.vehicles:
        PAGE.write_text(
            "\n".join([*head(given.seconds, given.near_seconds, given.rate), *rows]) + "\n", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
