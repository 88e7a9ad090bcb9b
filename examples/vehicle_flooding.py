"""A leak, a drop weight, and whether the vehicle comes up: three REMUS 100 at 25 m, one figure.

`python examples/vehicle_flooding.py FILE.png` opens a hole of 20 mm^2 in a dry bay of 4 litres of each after 10 s. The
air of the first is shut in: the whole pressure of the depth drives the water until Boyle's law stops it, its 1.3 kg of
reserve are gone, and it sinks to the bottom. The second is the same, and drops 5 kg of lead after 60 s: it rises, and
the air pushes the water out again. The air of the third leaves through a vent, so that only the 10 cm between hole and
vent drive the water: it reaches the surface long before its reserve is gone.
"""

from __future__ import annotations

import sys

import numpy as np

import pelagos as pl

SECONDS, DROP_S, RATE_HZ = 150, 60, 50


def vehicle(*, vented: bool) -> dict:
    """A REMUS 100 with 5 kg of lead, foam that carries it, and a bay that leaks."""
    bay = {
        "type": "compartment", "size_m": [0.4, 0.1, 0.1], "position_m": [0.2, 0.0, 0.0], "hole_m": [0.2, 0.0, 0.05],
        "orifice_m2": 2e-5, "opens_after_s": 10.0, **({"vent_m": [0.2, 0.0, -0.05]} if vented else {}),
    }  # fmt: skip
    lead = {"type": "releasable", "mass_kg": 5.0, "position_m": [0.2, 0.0, 0.06], "volume_m3": 4.4e-4}
    foam = {"type": "releasable", "mass_kg": 0.6, "position_m": [0.2, 0.0, -0.04], "volume_m3": 6.3e-3}
    return {"type": "remus100", "actuators": {"lead": lead, "foam": foam, "bay": bay}}


def main(picture: str | None = None) -> dict[str, np.ndarray]:
    """Depth [m] of each, second by second."""
    names = {
        "shut in": (False, False),
        "shut in, weight dropped": (False, True),
        "vented, weight dropped": (True, True),
    }
    agents = {
        f"auv{i}": {
            "vehicle": vehicle(vented=vented), "control": "actuators",
            "start": {"position_m": [0.0, 20.0 * i], "depth_m": 25.0},
        }
        for i, (vented, _) in enumerate(names.values())
    }  # fmt: skip
    sim = pl.Simulation.load({
        "world": {"type": "flat", "depth_m": 60.0}, "tick_rate_hz": RATE_HZ, "duration_s": SECONDS, "agents": agents,
    })  # fmt: skip
    depth, water = np.zeros((2, SECONDS + 1, len(names)))
    for second in range(SECONDS + 1):
        for i, (_, drops) in enumerate(names.values()):
            if drops and second == DROP_S:
                sim.command({f"auv{i}": {"lead": 1.0}})
            depth[second, i] = -sim.state[f"auv{i}"].position[0, 2]
            water[second, i] = sim.state[f"auv{i}"].actuators[0, -1] * 1000
        sim.step(ticks=RATE_HZ)
    for i, name in enumerate(names):
        print(f"{name}: {water[-1, i]:.2f} l of water, {depth[-1, i]:.1f} m deep after {SECONDS} s")
    if picture:
        _draw(picture, list(names), depth, water)
    return {name: depth[:, i] for i, name in enumerate(names)}


def _draw(path: str, names: list[str], depth: np.ndarray, water: np.ndarray) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5.5), sharex=True, layout="constrained")
    for i, name in enumerate(names):
        above.plot(depth[:, i], label=name)
        below.plot(water[:, i], linestyle=("-", "--", "-")[i])
    above.invert_yaxis()
    above.axvline(DROP_S, color="0.7", linewidth=1)
    above.set_ylabel("depth [m]")
    below.set_ylabel("water in the bay [l]")
    below.set_xlabel("time [s]")
    above.legend(frameon=False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:2])
