"""A glider that sinks through a thermocline out of a ship's hearing: where the direct ray ends, and what is left."""

from __future__ import annotations

import numpy as np

import pelagos as pl

SCENARIO = {
    "seed": 1,
    "tick_rate_hz": 20,
    "world": {"type": "flat", "depth_m": 400.0, "size_m": [6000.0, 6000.0]},
    "ocean": {"temperature_c": {"depth_m": [0, 10, 60, 400], "value": [22, 22, 11, 8]}},
    "agents": {"glider": {"vehicle": "glider", "start": {"position_m": [1200, 0], "depth_m": 5}}},
}


def main() -> list[tuple[float, float, int]]:
    """Depth [m], loss [dB] and number of direct rays from a transducer 5 m deep to a glider 1.2 km away."""
    sim = pl.Simulation.load(SCENARIO)
    found = []
    for depth in (5.0, 10.0, 20.0, 40.0, 80.0, 160.0):
        sim.set_state("glider", position=(1200.0, 0.0, -depth))
        made = pl.channel(sim, (0.0, 0.0, -5.0), "glider", frequency_hz=12_000.0)
        a = made.arrivals()
        direct = int(np.sum((a.surface == 0) & (a.bottom == 0)))
        found.append((depth, made.transmission_loss(), direct))
        print(f"{depth:5.0f} m deep: {made.transmission_loss():5.1f} dB lost, {direct} direct rays, {len(a)} in all")
    return found


if __name__ == "__main__":
    main()
