"""Plankton, salt and warmth along a dive: `pelagos holoocean biology.py [PICTURE.png]`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import numpy as np

clusters = [{"position": [10, 0, -30], "strength": 1.5, "falloff": 12}]
scenario = {
    "name": "biology", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 20,
    "agents": [{
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 1, "location": [0, 0, -5],
        "sensors": [{"sensor_type": "BSTSensor", "configuration": {"biomass_clusters": clusters}},
                    {"sensor_type": "LocationSensor"}],
    }],
}  # fmt: skip


def warm_above(location):
    """A temperature of one's own."""
    return 20.0 + 0.2 * float(np.ravel(location)[2])


with holoocean.make(scenario_cfg=scenario) as env:
    env.set_temperature_function("auv0", warm_above)
    rows = []
    for _ in range(600):
        state = env.step([10, 0, -40, 0, 0, 0])
        rows.append([*state["LocationSensor"], *state["BSTSensor"]])
    maps = env.initialize_bst_graphs(config=scenario, temperature_func=warm_above)
    maps.update_position(rows[-1][:3])
    maps.update_plots()
    maps._figure[0].savefig(sys.argv[1] if len(sys.argv) > 1 else "biology.png", dpi=80)
    maps.close()
for row in rows[::150]:
    print(np.round(row, 3))
