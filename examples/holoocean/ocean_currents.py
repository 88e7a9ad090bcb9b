"""Vehicles in a vortex, each with the current of its place: `pelagos holoocean ocean_currents.py`."""

import holoocean
import numpy as np


def vortex(location):
    """A turning current, as fast as the distance from the middle up to 1 m/s."""
    x, y, _ = location
    radius = max(np.hypot(x, y), 1e-6)
    return list(min(radius / 10, 1.0) / radius * np.array([-y, x, 0.0]))


def agent(number, location):
    """A vehicle without thrust."""
    return {"agent_name": f"auv{number}", "agent_type": "HoveringAUV", "control_scheme": 0, "location": location,
            "sensors": [{"sensor_type": "LocationSensor"}]}  # fmt: skip


scenario = {
    "name": "currents", "world": "SimpleUnderwater", "package_name": "Ocean", "main_agent": "auv0",
    "ticks_per_sec": 30, "frames_per_sec": False, "current": {"vehicle_debugging": True},
    "agents": [agent(0, [8, 0, -5]), agent(1, [0, -15, -5])],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario, start_world=False) as env:
    env.draw_debug_vector_field(vortex, location=[0, 0, 0], vector_field_dimensions=[40, 40, 20], spacing=10,
                                arrow_thickness=5, arrow_size=1)  # fmt: skip
    state = env.tick()
    for _ in range(900):
        for name in ("auv0", "auv1"):
            env.set_ocean_currents(name, vortex(state[name]["LocationSensor"]))
        state = env.tick()
for name in ("auv0", "auv1"):
    x, y, _ = state[name]["LocationSensor"]
    print(f"{name}: {np.hypot(x, y):.1f} m from the middle, at {np.degrees(np.arctan2(y, x)):.0f} deg")
