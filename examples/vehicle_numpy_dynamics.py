"""A vehicle whose dynamics are a NumPy function: a buoyant drifter on an elastic mooring, with one winch.

`python examples/vehicle_numpy_dynamics.py` lets it rise from 8 m, pays out the winch after 20 s, and prints its depth.
The function is called once a step for the whole fleet; the same in Dr.Jit (`arrays: drjit`) would run recorded.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import pelagos as pl
from pelagos.vehicles.terms.function import NumpyFlow

ANCHOR = np.array([0.0, 0.0, 10.0])  # north, east, down [m]


def moored_drifter(flow: NumpyFlow, parameters: Mapping[str, float]) -> np.ndarray:
    """Acceleration `(n, 6)`, forward-right-down: net buoyancy, drag, and a mooring that only pulls."""
    line = ANCHOR - flow.position
    length = np.linalg.norm(line, axis=1)
    tension = parameters["stiffness"] * np.maximum(length - flow.actuators["winch"], 0.0)
    force = tension[:, None] * line / length[:, None] - [0.0, 0.0, parameters["buoyancy"]]
    in_body = np.einsum("nji,nj->ni", flow.rotation, force)
    speed = np.linalg.norm(flow.nu_r[:, :3], axis=1, keepdims=True)
    linear = (in_body - parameters["drag"] * speed * flow.nu_r[:, :3]) / parameters["mass"]
    return np.hstack([linear, -flow.nu[:, 3:]])


SCENARIO = {
    "world": {"type": "flat", "depth_m": 10.0},
    "tick_rate_hz": 20,
    "agents": {
        "drifter": {
            "start": {"position_m": [0.0, 0.0], "depth_m": 8.0},
            "vehicle": {
                "type": "custom",
                "length_m": 0.3,
                "diameter_m": 0.3,
                "mass": {"type": "explicit", "mass_kg": 15.0, "inertia_kg_m2": [0.2, 0.2, 0.2]},
                "added_mass": {"type": "none"},
                "coriolis": {"rigid": "none"},
                "terms": {
                    "mine": {
                        "type": "function",
                        "target": f"{__name__}:moored_drifter",
                        "arrays": "numpy",
                        "gives": "acceleration",
                        "parameters": {"mass": 20.0, "buoyancy": 30.0, "drag": 40.0, "stiffness": 60.0},
                    }
                },
                "actuators": {"winch": {"type": "channel", "low": 1.0, "high": 9.0, "unit": "m"}},
                "modes": {"actuators": {"type": "actuators"}},
                "default_mode": "actuators",
            },
        }
    },
}


def main(seconds: float = 40.0) -> np.ndarray:
    """Depths (2) [m] before the winch pays out, and at the end."""
    sim = pl.Simulation.load(SCENARIO, trust=True)
    depths = []
    for winch in (3.0, 6.0):
        sim.command({"drifter": [winch]})
        sim.run(seconds / 2)
        depths.append(float(-sim.state["drifter"].position[0, 2]))
        print(f"{winch:.0f} m of line: {depths[-1]:.3f} m deep")
    return np.array(depths)


if __name__ == "__main__":
    main()
