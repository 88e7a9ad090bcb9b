"""The first steps in HoloOcean: `pelagos holoocean getting_started.py`."""

import holoocean
import numpy as np

command = np.array([10, 10, 10, 10, 0, 0, 0, 0])
with holoocean.make("PierHarbor-Hovering") as env:
    for _ in range(180):
        state = env.step(command)
print(f"after {state['t']:.2f} s at {state['PoseSensor'][:3, 3].round(2)}: {sorted(state)}")
