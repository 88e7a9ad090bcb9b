"""Two AUVs find their own places by one-way travel times from a USV, in a stratified sea: the sound speed matters."""

from __future__ import annotations

import numpy as np

import pelagos as pl

MODEM = {"type": "modem", "device": "micromodem", "clock_offset_std_s": 1e-4, "sound_speed_mps": 1500.0}
SCENARIO = {
    "seed": 2,
    "tick_rate_hz": 20,
    "world": {"type": "flat", "depth_m": 120.0},
    "ocean": {"temperature_c": {"depth_m": [0, 20, 40, 120], "value": [20, 19, 11, 9]}},
    "agents": {
        "usv": {
            "vehicle": "otter",
            "start": {"position_m": [0, 0]},
            "sensors": {"modem": MODEM | {"beacon_s": 5.0, "position_m": [0.0, 0.0, -1.0]}},
        },
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [400, 150], "depth_m": 60},
            "sensors": {"modem": MODEM},
        },
        "auv1": {
            "vehicle": "remus100",
            "start": {"position_m": [-200, 500], "depth_m": 30},
            "sensors": {"modem": MODEM},
        },
    },
}


def main(seconds: float = 40.0) -> dict[str, float]:
    """Error of the mean range by the constant speed of 1500 m/s and by the water's own mean speed [m]."""
    sim = pl.Simulation.load(SCENARIO)
    errors: dict[str, list[tuple[float, float]]] = {"auv0": [], "auv1": []}
    for _ in range(round(seconds * 20)):
        for name, readings in sim.step().items():
            for packet in readings["modem"].packets if "modem" in readings and name in errors else []:
                distance = float(np.linalg.norm(sim.state[name].position[0] - sim.state["usv"].position[0]))
                first = pl.channel(sim, "usv.modem", name).arrivals()
                speed = distance / float(first.delay[0])
                errors[name].append((1500.0 * packet.travel_time_s - distance, speed * packet.travel_time_s - distance))
    found = {}
    for name, pairs in errors.items():
        constant, own = np.mean(pairs, axis=0)
        print(f"{name}: {len(pairs)} packets; by 1500 m/s {constant:+.2f} m off, by the water's own speed {own:+.2f} m")
        found[name] = float(own)
    return found


if __name__ == "__main__":
    main()
