"""A surface vessel from waypoint to waypoint by its own controller: `pelagos holoocean vessel_waypoints.py`."""

import holoocean
import numpy as np

WAYPOINTS = np.array([[25, 25], [-25, 25], [-25, -25], [25, -25]])
scenario = {
    "name": "waypoints", "world": "SimpleUnderwater", "package_name": "Ocean", "main_agent": "sv0",
    "ticks_per_sec": 50,
    "agents": [{
        "agent_name": "sv0", "agent_type": "SurfaceVessel", "control_scheme": 1, "location": [0, 0, 2],
        "sensors": [{"sensor_type": "GPSSensor"}],
    }],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    for waypoint in WAYPOINTS:
        env.draw_point([float(waypoint[0]), float(waypoint[1]), 0.0], lifetime=0)
    state, reached = env.tick(), 0
    for _ in range(20_000):
        state = env.step(WAYPOINTS[reached])
        if "GPSSensor" in state and np.linalg.norm(state["GPSSensor"][:2] - WAYPOINTS[reached]) < 3:
            print(f"waypoint {reached} after {state['t']:.1f} s")
            reached += 1
            if reached == len(WAYPOINTS):
                break
