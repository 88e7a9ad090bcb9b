"""Keys drive an agent in the Dam world: `pelagos holoocean manual_control.py [AGENT] [KEYS]`.

AGENT is HoveringAUV, TorpedoAUV, SurfaceVessel or HuskyVehicle; KEYS are held for half a second each.
"""

import sys

import holoocean
import numpy as np

kind = sys.argv[1] if len(sys.argv) > 1 else "HoveringAUV"
keys = sys.argv[2] if len(sys.argv) > 2 else "iiwwjj"
STARTS = {
    "HoveringAUV": ([0, 0, -10], 180), "TorpedoAUV": ([0, 0, -10], 180), "SurfaceVessel": ([0, 0, 0], 180),
    "HuskyVehicle": ([110, -166, 6], 135),
}  # fmt: skip


def command(key):
    """What a key means to each agent."""
    if kind == "HoveringAUV":
        made = np.zeros(8)
        made[0:4] += {"i": 20.0, "k": -20.0}.get(key, 0.0)
        turn = {"j": 20.0, "l": -20.0}.get(key, 0.0)
        made[[4, 7]] += turn
        made[[5, 6]] -= turn
        made[4:8] += {"w": 20.0, "s": -20.0}.get(key, 0.0)
        return made
    if kind == "TorpedoAUV":
        pitch, yaw = {"i": 20.0, "k": -20.0}.get(key, 0.0), {"j": 20.0, "l": -20.0}.get(key, 0.0)
        return np.array([-pitch, yaw, pitch, -yaw, 40.0])
    ahead = {"w": 800.0, "s": -800.0}.get(key, 0.0)
    turn = {"j": 300.0, "l": -300.0}.get(key, 0.0)
    pair = [ahead - turn, ahead + turn]
    return np.array(pair if kind == "SurfaceVessel" else [*pair, 0.0])


location, yaw = STARTS[kind]
scenario = {
    "name": "manual", "world": "Dam", "package_name": "Ocean", "main_agent": "auv0", "ticks_per_sec": 60,
    "agents": [{
        "agent_name": "auv0", "agent_type": kind, "control_scheme": 0, "location": location, "rotation": [0, 0, yaw],
        "sensors": [{"sensor_type": "PoseSensor"}, {"sensor_type": "RotationSensor"}],
    }],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    for key in keys:
        env.act("auv0", command(key))
        for _ in range(30):
            state = env.tick()
        print(key, state["PoseSensor"][:3, 3].round(2), state["RotationSensor"].round(1))
