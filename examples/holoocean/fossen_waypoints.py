"""A torpedo by Fossen's equations from waypoint to waypoint: `pelagos holoocean fossen_waypoints.py`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from holoocean.fossen_dynamics import FossenInterface

START = [0, 20, -280]
WAYPOINTS = [[140, 30, -280], [170, 10, -276], [175, -92, -266]]
NEAR_M = 6.0
scenario = {
    "name": "waypoints", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 30, "frames_per_sec": False,
    "agents": [{
        "agent_name": "auv0", "agent_type": "TorpedoAUV", "control_scheme": 1, "location": START,
        "fossen_model": "torpedo", "control_mode": "depthHeadingAutopilot",
        "sensors": [{"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}}],
    }],
}  # fmt: skip
env = holoocean.make(scenario_cfg=scenario)
fossen = FossenInterface(["auv0"], scenario)
for waypoint in WAYPOINTS:
    env.draw_point(waypoint, lifetime=0)
state, reached, track = env.tick(), 0, []
while reached < len(WAYPOINTS) and state["t"] < 400:
    place = state["DynamicsSensor"][6:9]
    x, y, _ = WAYPOINTS[reached] - place
    fossen.set_goal("auv0", depth=-WAYPOINTS[reached][2], heading=float(np.degrees(np.arctan2(y, x))), rpm=1300)
    state = env.step(fossen.update("auv0", state))
    track.append(place)
    if np.hypot(x, y) < NEAR_M:
        print(f"waypoint {reached} after {state['t']:.0f} s at {place.round(1).tolist()}")
        reached += 1

track, goals = np.array(track), np.array([START, *WAYPOINTS])
figure, (plan, profile) = plt.subplots(2, 1, figsize=(7, 8))
plan.plot(track[:, 0], track[:, 1])
plan.plot(goals[:, 0], goals[:, 1], "k.--", linewidth=0.5)
plan.set(xlabel="north [m]", ylabel="west [m]", aspect="equal")
profile.plot(np.arange(len(track)) / 30, track[:, 2])
profile.set(xlabel="time [s]", ylabel="height [m]")
figure.tight_layout()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "waypoints.png", dpi=90)
