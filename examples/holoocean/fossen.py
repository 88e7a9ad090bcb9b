"""A torpedo by Fossen's equations, to a depth and a heading: `pelagos holoocean fossen.py`."""

import holoocean
from holoocean.fossen_dynamics import FossenInterface

scenario = {
    "name": "torpedo", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 30,
    "agents": [{
        "agent_name": "auv0", "agent_type": "TorpedoAUV", "control_scheme": 1, "location": [0, 0, -10],
        "fossen_model": "torpedo", "control_mode": "depthHeadingAutopilot",
        "sensors": [
            {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}},
            {"sensor_type": "RotationSensor"},
        ],
    }],
}  # fmt: skip
env = holoocean.make(scenario_cfg=scenario)
fossen = FossenInterface(["auv0"], scenario)
fossen.set_goal("auv0", depth=15, heading=50, rpm=1300)
state = env.tick()
for _ in range(800):
    state = env.step(fossen.update("auv0", state))
print(f"depth {-state['DynamicsSensor'][8]:.2f} m, heading {state['RotationSensor'][2]:.1f} deg")
