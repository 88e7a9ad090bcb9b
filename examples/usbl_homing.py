"""An AUV that homes in on a dock by USBL alone: it turns towards each fix of the dock's modem."""

from __future__ import annotations

import math

import numpy as np

import pelagos as pl

SCENARIO = {
    "seed": 6,
    "tick_rate_hz": 20,
    "world": {"type": "flat", "depth_m": 30.0},
    "agents": {
        "auv": {
            "vehicle": "remus100",
            "start": {"position_m": [0, 0], "depth_m": 12, "heading_deg": 70, "speed_mps": 1.2},
            "control": "depth_heading",
            "sensors": {"usbl": {"type": "usbl", "interrogate": ["dock"], "interrogate_s": 1.5}},
        },
        "dock": {
            "vehicle": "hovering_auv",
            "start": {"position_m": [140, 60], "depth_m": 14},
            "sensors": {"modem": {"type": "modem", "device": "x150"}},
        },
    },
}


def main(seconds: float = 150.0) -> float:
    """Nearest approach [m]."""
    sim = pl.Simulation.load(SCENARIO)
    names = sim.model.agents["auv"].vehicle.command_names("depth_heading")
    heading, nearest = math.radians(70.0), math.inf
    for _ in range(round(seconds * 20)):
        command = {"depth": 14.0, "heading": heading}
        reading = sim.step({"auv": [command.get(name, 900.0) for name in names]})["auv"].get("usbl")
        if reading is not None and np.isfinite(reading.extras["fix"]).all():
            ahead, left, _ = reading.extras["fix"][0]
            lead = 2.5 * math.atan2(left, ahead)  # more than the bearing: the autopilot turns slowly
            heading = -float(sim.state["auv"].euler[0, 2]) - max(-1.0, min(1.0, lead))
            print(f"{sim.time_ns * 1e-9:6.1f} s: dock {math.hypot(ahead, left):6.1f} m away")
        nearest = min(nearest, float(np.linalg.norm(sim.state["auv"].position[0] - sim.state["dock"].position[0])))
        if nearest < 2.0:
            break
    print(f"nearest approach {nearest:.1f} m")
    return nearest


if __name__ == "__main__":
    main()
