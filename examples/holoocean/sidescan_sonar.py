"""A torpedo passes a sunken submarine in HoloOcean's OpenWater and draws its sidescan waterfall.

pelagos holoocean examples/holoocean/sidescan_sonar.py [PICTURE.png] [PINGS]
"""

import sys

import holoocean
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

out = sys.argv[1] if len(sys.argv) > 1 else "sidescan_sonar.png"
pings = int(sys.argv[2]) if len(sys.argv) > 2 else 200

scenario = holoocean.packagemanager.get_scenario("OpenWater-TorpedoSidescanSonar")
agent = scenario["agents"][0]
agent["location"] = [515, 236, -285]  # 40 m before the documented place, so that the wreck comes into the picture
agent["sensors"] = agent["sensors"][-1:]  # the sonar alone: nothing else needs 200 ticks a second
scenario["ticks_per_sec"] = 20
config = agent["sensors"][0]["configuration"]

rows = []
with holoocean.make(scenario_cfg=scenario, show_viewport=False) as env:
    while len(rows) < pings:
        state = env.step(np.array([0, 0, 0, 0, 60.0]))
        if "SidescanSonar" in state:
            rows.append(state["SidescanSonar"])

waterfall = np.array(rows)
side = config["RangeMax"]
fig, axes = plt.subplots(figsize=(9, 6), layout="tight")
axes.imshow(waterfall, aspect="auto", cmap="copper", extent=(side, -side, 0, pings), origin="lower",
            vmax=float(np.quantile(waterfall, 0.995)))  # fmt: skip
axes.set(xlabel="slant range, left to right [m]", ylabel="ping", title="SidescanSonar")
plt.savefig(out, dpi=110)
print(f"wrote {out}: {waterfall.shape[0]} pings of {waterfall.shape[1]} bins")
