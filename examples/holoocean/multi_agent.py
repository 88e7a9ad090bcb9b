"""Two agents in one world, each with its own state: `pelagos holoocean multi_agent.py`."""

import holoocean
import numpy as np


def agent(name, kind, scheme, location):
    """An agent that knows where it is."""
    return {"agent_name": name, "agent_type": kind, "control_scheme": scheme, "location": location,
            "sensors": [{"sensor_type": "PoseSensor"}, {"sensor_type": "RangeFinderSensor"}]}  # fmt: skip


scenario = {
    "name": "two", "world": "SimpleUnderwater", "package_name": "Ocean", "main_agent": "auv0", "ticks_per_sec": 30,
    "agents": [agent("auv0", "HoveringAUV", 1, [5, -5, -15]), agent("auv1", "TorpedoAUV", 0, [-5, -5, -15])],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    env.act("auv0", np.array([5, 0, -12, 0, 0, 90]))
    env.act("auv1", np.array([0, 0, 0, 0, 50]))
    for _ in range(300):
        state = env.tick()
for name in ("auv0", "auv1"):
    print(name, state[name]["PoseSensor"][:3, 3].round(2))
