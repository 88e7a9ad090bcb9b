"""Mean force of second order that pressure on a moving hull has in the simulator: `python scripts/drift.py wamv otter`.

After `scripts/bem.py`. Pressure on the wet hull as it moves is part of what pushes a hull along, but not all of it, and
the panel method's drift is all. So the part is measured, in regular waves on a hull that a soft spring holds, and
written into `<vehicle>.bem.json` beside the whole; the simulator adds the difference.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

import pelagos as pl

CATALOGUE = Path(__file__).parent.parent / "src/pelagos/vehicles/catalogue"
STEEPNESS = 0.02  # of the waves: amplitude times wave number
SPRING_S = 40.0  # period of the hull on its spring, or eight periods of the wave


def own_force(
    vehicle: Any, mass: float, inertia: float, omega: float, headings: list[float], rate: float
) -> np.ndarray:
    """Surge, sway and yaw `(headings, 3)` along the mean heading, FRD, over the water's density and the amplitude
    squared; the wave travels north, so that a hull that heads `-heading` sees it travel towards `heading`.
    """
    period = 2 * np.pi / omega
    amplitude = STEEPNESS * 9.81 / omega**2
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": rate,
            "world": {"type": "flat", "depth_m": 400.0, "size_m": [4000, 4000]},
            "ocean": {
                "temperature_c": 4.0,
                "salinity": 0.0,
                "waves": [{"type": "regular", "height_m": 2 * amplitude, "period_s": period, "towards_deg": 0.0}],
            },
            "agents": {"it": {"vehicle": vehicle, "control": "wrench", "start": {"position_m": [0, 0], "depth_m": 0}}},
        },
        n=len(headings),
    )
    yaw = np.radians(np.array(headings))  # NWU: to port
    sim.set_state("it", attitude=np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1))
    stiff = 2 * np.pi / max(SPRING_S, 8 * period)
    steps = max(round(period / 16 * rate), 1)
    settle, take = int(np.ceil(2.5 * max(SPRING_S, 8 * period) / period)), 24
    forces = []
    for k in range(16 * (settle + take)):
        state = sim.state["it"]
        turn = np.mod(state.euler[:, 2] - yaw + np.pi, 2 * np.pi) - np.pi
        rates = state.angular_velocity[:, 2]
        p, v = state.position[:, :2], state.velocity[:, :2]
        c, s = np.cos(-state.euler[:, 2]), np.sin(-state.euler[:, 2])
        x, y = c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]  # forward and to port
        push = -mass * stiff * np.stack([stiff * x + 2 * v[:, 0], stiff * y + 2 * v[:, 1]], axis=-1)
        twist = -inertia * stiff * (stiff * turn + 2 * rates)
        if k >= 16 * settle:
            forces.append(np.stack([-push[:, 0], push[:, 1], twist], axis=-1))  # FRD, and the wave's, not the spring's
        command = np.zeros((len(headings), 6))
        command[:, 0], command[:, 1], command[:, 5] = push[:, 0], -push[:, 1], -twist
        sim.command({"it": command})
        sim.run(steps / rate)
    return np.asarray(np.mean(forces, axis=0) / (density(sim) * amplitude**2))


def density(sim: Any) -> float:
    """Of the water [kg/m^3]."""
    from pelagos import jit

    return float(np.array(sim.model.ocean.density(jit.Array3f64(0.0, 0.0, 0.0), jit.Float64(0.0)))[0])


def main(name: str) -> None:
    """One vehicle of the catalogue."""
    file = CATALOGUE / f"{name}.bem.json"
    data = json.loads(file.read_text())
    drift = data["drift"]
    body = pl.Vehicle.from_catalogue(name).config.body
    mass, inertia = float(body.mass_matrix[0, 0]), float(body.mass_matrix[5, 5])
    whole = np.array(drift["force"])
    pushes = whole - np.array(drift["own"]) if drift.get("own") else whole  # what the vehicle's table adds as it is run
    own = []
    for omega, push in zip(drift["omega_radps"], pushes, strict=True):
        own.append(own_force(name, mass, inertia, omega, drift["heading_deg"], 50.0) - push)
        own[-1][[0, -1], 1:] = 0.0  # from ahead and astern, by symmetry
        print(f"{omega:.2f} rad/s", own[-1][[0, 6, 12]].round(3).tolist(), flush=True)
    drift["own"] = np.char.mod("%.5g", np.array(own)).astype(float).tolist()
    file.write_text(json.dumps(data) + "\n")


if __name__ == "__main__":
    for given in sys.argv[1:]:
        main(given)
