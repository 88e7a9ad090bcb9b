"""A vessel in a calm sea, and then in a rough one: `pelagos holoocean waves.py`."""

import holoocean
import numpy as np

scenario = {
    "name": "waves", "world": "PierHarbor", "package_name": "Ocean", "ticks_per_sec": 30, "buoyancy": 1,
    "fft_waves": {"sea_state": 0},
    "agents": [{
        "agent_name": "sv0", "agent_type": "SurfaceVessel", "control_scheme": 0, "location": [0, -500, 0],
        "sensors": [{"sensor_type": "LocationSensor"}, {"sensor_type": "RotationSensor"}],
    }],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    for sea_state in (0, 3, 5):
        env.fftwaves.fft_sea_state(sea_state)
        rows = np.array([[s["LocationSensor"][2], *s["RotationSensor"][:2]] for s in (env.tick() for _ in range(600))])
        heave, roll, pitch = rows[150:].std(axis=0)
        print(f"sea state {sea_state}: heave {heave:.2f} m, roll {roll:.1f} deg, pitch {pitch:.1f} deg rms")
