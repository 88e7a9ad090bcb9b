"""Envelopes of vehicles, a table of every vehicle and control mode in six places: `python scripts/envelopes.py`.

Each mode holds its idle command (stay here, actuators at rest). A cell has the largest tilt [deg] and the largest speed
[m/s] of the run, sampled ten times a second; a run that is not finite, or faster than 30 m/s, is told by name.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

import pelagos as pl
from pelagos.errors import PelagosError
from pelagos.vehicles.load import catalogue_names

PAGE: Final = Path(__file__).parent.parent / "docs/vehicles_envelopes.md"
BOTTOM_M: Final = 30.0
PLACES: Final = ("calm", "sea state 4", "current 0.5 m/s", "near bottom", "surface", "air")
OCEANS: Final[dict[str, dict[str, Any]]] = {
    "sea state 4": {"waves": [{"type": "sea_state", "state": 4}]},
    "current 0.5 m/s": {"currents": [{"type": "uniform", "speed_mps": 0.5, "towards_deg": 60}]},
}
FASTEST: Final = 30.0  # [m/s]: what goes faster has exploded


def heights(vehicle: pl.Vehicle) -> dict[str, float]:
    """Where a vehicle begins, by place [m] up from the mean surface."""
    afloat = bool({getattr(t, "type", "") for t in vehicle.config.terms.values()} & {"hydrostatic", "twin_hull"})
    usual = 10.0 if vehicle.config.medium == "air" else 0.0 if afloat else -8.0
    near = -BOTTOM_M + vehicle.bounding_radius_m + 0.5
    return {"calm": usual, "sea state 4": usual, "current 0.5 m/s": usual, "near bottom": near, "surface": 0, "air": 5}


def run(vehicle: pl.Vehicle, mode: str, places: tuple[str, ...], seconds: float, rate: float) -> dict[str, str]:
    """Cells of places that share an ocean, one copy each."""
    scenario = {
        "tick_rate_hz": rate,
        "world": {"type": "flat", "depth_m": BOTTOM_M},
        "ocean": OCEANS.get(places[0], {}),
        "agents": {"it": {"vehicle": vehicle.name, "control": mode}},
    }
    z = heights(vehicle)
    found = {}
    try:
        sim = pl.Simulation.load(scenario, n=len(places))
        sim.reset(state={"it": {"position": [[0.0, 0.0, z[p]] for p in places]}})
        tilt, speed = np.zeros(len(places)), np.zeros(len(places))
        for _ in range(round(10 * seconds)):
            sim.run(0.1)
            state = sim.state["it"]
            x, y = state.attitude[:, 1], state.attitude[:, 2]
            tilt = np.maximum(tilt, np.degrees(np.arccos(np.clip(1 - 2 * (x * x + y * y), -1, 1))))
            speed = np.maximum(speed, np.linalg.norm(state.velocity, axis=1))
        for place, lean, fast in zip(places, tilt, speed, strict=True):
            bad = "" if np.isfinite(fast) and fast < FASTEST else "**explodes** "
            found[place] = f"{bad}{lean:.0f}, {fast:.1f}"
    except PelagosError as error:
        found = {place: f"**{type(error).__name__}**" for place in places}
    return found


def lines(names: list[str], seconds: float, rate: float) -> Iterator[str]:
    """Rows of the table."""
    for name in names:
        vehicle = pl.Vehicle.from_catalogue(name)
        for mode in vehicle.modes:
            cells = run(vehicle, mode, ("calm", "near bottom", "surface", "air"), seconds, rate)
            for place in OCEANS:
                cells |= run(vehicle, mode, (place,), seconds, rate)
            yield f"| {name} | `{mode}` | " + " | ".join(cells[place] for place in PLACES) + " |"


def head(seconds: float, rate: float) -> list[str]:
    """The page down to the table."""
    return [
        "# Envelopes of vehicles\n",
        f"Every vehicle and control mode, {seconds:g} s at {rate:g} ticks a second over a bottom at {BOTTOM_M:g} m, "
        "with the idle command held: largest tilt [deg], largest speed [m/s]. Vehicles under water begin at 8 m, those "
        "of the air 10 m up, boats at the mean surface; `surface` is with the origin at it, `air` from 5 m up, without "
        "speed, `near bottom` 0.5 m clear of it (boats shoot up from there and aeroplanes lie in the water). Without "
        "speed an aeroplane stalls. Mode `acceleration` holds accelerations of 0: gravity is no part of it. Made by "
        "`python scripts/envelopes.py --seconds "
        f"{seconds:g}`.\n",
        "| vehicle | mode | " + " | ".join(PLACES) + " |",
        "|---" * (2 + len(PLACES)) + "|",
    ]


def main() -> None:
    """Write the page, or the rows of some vehicles to the terminal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vehicles", nargs="*", help="of the catalogue; all, and the page is written, without")
    parser.add_argument("--seconds", type=float, default=600.0, help="of each run [s]")
    parser.add_argument("--rate", type=float, default=50.0, help="ticks a second [Hz]")
    given = parser.parse_args()
    rows = []
    for row in lines(given.vehicles or list(catalogue_names()), given.seconds, given.rate):
        print(row, flush=True)
        rows.append(row)
    if not given.vehicles:
        PAGE.write_text("\n".join([*head(given.seconds, given.rate), *rows]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
