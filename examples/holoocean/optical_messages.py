"""A message by light between two vehicles that face each other: `pelagos holoocean optical_messages.py`."""

import holoocean


def agent(number, location, yaw):
    """A vehicle with an optical modem in its sonar's socket."""
    return {"agent_name": f"auv{number}", "agent_type": "HoveringAUV", "control_scheme": 0, "location": location,
            "rotation": [0, 0, yaw],
            "sensors": [{"sensor_type": "OpticalModemSensor", "socket": "SonarSocket",
                         "configuration": {"id": number, "MaxDistance": 50, "LaserAngle": 60}}]}  # fmt: skip


scenario = {
    "name": "light", "world": "SimpleUnderwater", "package_name": "Ocean", "main_agent": "auv0", "ticks_per_sec": 30,
    "agents": [agent(0, [0, 0, -5], 0), agent(1, [20, 0, -5], 180)],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    env.send_optical_message(0, 1, "Message")
    state = env.tick()
    print(state["auv1"].get("OpticalModemSensor"))
    env.agents["auv1"].teleport(rotation=[0, 0, 0])
    env.tick()
    env.send_optical_message(0, 1, "Nobody looks")
    print(env.tick()["auv1"].get("OpticalModemSensor"))
