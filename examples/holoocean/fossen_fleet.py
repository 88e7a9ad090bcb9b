"""A torpedo and an Otter by Fossen's equations in one world: `pelagos holoocean fossen_fleet.py`."""

import holoocean
import numpy as np
from holoocean.fossen_dynamics import FossenInterface


def agent(name, kind, model, scheme, location):
    """An agent that Fossen's equations move."""
    return {
        "agent_name": name,
        "agent_type": kind,
        "control_scheme": scheme,
        "location": location,
        "fossen_model": model,
        "control_mode": "manualControl",
        "sensors": [{"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}}],
    }


scenario = {
    "name": "fleet", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 50, "main_agent": "auv0",
    "agents": [agent("auv0", "TorpedoAUV", "torpedo", 1, [0, 0, -10]),
               agent("sv0", "SurfaceVessel", "otter", 2, [10, 10, 0])],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    fossen = FossenInterface(["auv0", "sv0"], scenario, multi_agent=True)
    fossen.set_control_mode("sv0", "manualControl")
    fossen.set_u_control("auv0", np.array([0.0, 0.0, 0.0, 0.0, 1000]))
    fossen.set_u_control("sv0", np.array([105.0, 80.0]))
    state = env.tick()
    for _ in range(500):
        for name in ("auv0", "sv0"):
            env.act(name, fossen.update(name, state))
        state = env.tick()
for name in ("auv0", "sv0"):
    x = state[name]["DynamicsSensor"]
    print(f"{name}: {np.linalg.norm(x[3:6]):.2f} m/s at {x[6:9].round(1)}")
