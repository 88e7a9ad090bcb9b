"""A message by sound over 100 m at 200 ticks a second: `pelagos holoocean acoustic_messages.py`."""

import holoocean


def agent(number, location):
    """A vehicle with a beacon."""
    return {"agent_name": f"auv{number}", "agent_type": "HoveringAUV", "control_scheme": 0, "location": location,
            "sensors": [{"sensor_type": "AcousticBeaconSensor", "location": [0, 0, 0],
                         "configuration": {"id": number}}]}  # fmt: skip


scenario = {
    "name": "sound", "world": "SimpleUnderwater", "package_name": "Ocean", "main_agent": "auv0", "ticks_per_sec": 200,
    "agents": [agent(0, [0, 0, -5]), agent(1, [0, 100, -5])],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    env.act("auv0", [0] * 8)
    env.send_acoustic_message(0, 1, "OWAY", "my data payload")
    for tick in range(40):
        state = env.tick()
        if "AcousticBeaconSensor" in state["auv1"]:
            print(f"tick {tick}: {state['auv1']['AcousticBeaconSensor']}, {env.beacons_status}")
