"""A boat and an AUV in a rising sea, seen live in the browser: open the printed address. Ctrl-C ends it.

python examples/live_view.py         # 60 simulated seconds
python examples/live_view.py 600
"""

from __future__ import annotations

import sys
from typing import Any

import pelagos as pl

SCENARIO: dict[str, Any] = {
    "name": "rising sea",
    "seed": 4,
    "world": {"type": "flat", "depth_m": 18},
    "ocean": {
        "waves": [{"type": "jonswap", "significant_height_m": 0.4, "peak_period_s": 5, "towards_deg": 60}],
        "temperature_c": {"depth_m": [0, 6, 18], "value": [19, 17, 9]},
    },
    "agents": {
        "boat": {
            "vehicle": "wamv",
            "start": {"position_m": [0, 6], "heading_deg": 20},
            "sensors": {"imu": {"type": "imu", "rate_hz": 50}},
        },
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0, 0], "depth_m": 5, "speed_mps": 1.5},
            "mission": [
                {"type": "waypoints", "points": [[60, 0], [60, -50], [0, -50]], "depth_m": 6, "speed_mps": 1.5}
            ],
            "sensors": {
                "depth": {"type": "depth", "rate_hz": 10},
                "imaging": {"type": "imaging_sonar", "rate_hz": 2, "beams": 64, "bins": 128, "range_max_m": 20},
            },
        },
    },
}
RISES_S, RISES_M = 15.0, 0.6


def main(seconds: float = 60.0) -> list[float]:
    """Run it with a view; gives the boat's heave before each rise of the sea, from trough to crest [m]."""
    sim = pl.Simulation.load(SCENARIO)
    heaves: list[float] = []
    heights: list[float] = []
    with (
        sim.on_tick(lambda s: heights.append(float(s.state["boat"].position[0, 2])), rate_hz=10),
        sim.view() as view,
    ):
        print(view.url)
        sea = sim.scenario.ocean.waves[0].model_dump()
        while sim.time_ns < seconds * 1e9:
            heights.clear()
            sim.run(RISES_S, realtime=__name__ == "__main__")
            heaves.append(max(heights) - min(heights))
            sea["significant_height_m"] += RISES_M
            sea["peak_period_s"] += 0.5
            sim.ocean.set(keys={"waves": [sea]})
    return heaves


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
