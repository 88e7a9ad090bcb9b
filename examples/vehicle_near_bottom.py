"""Suction of the bottom: a REMUS 100 that runs past it at 1.5 m/s, and what the distance does to its added mass.

`python examples/vehicle_near_bottom.py FILE.png` asks the model for the force of a plane bottom by distance, ahead and
across, and lets one vehicle with the term `boundary` and one without coast 0.25 m above a flat bottom.
"""

from __future__ import annotations

import sys

import numpy as np

import pelagos as pl

SPEED_MPS, BOTTOM_M, ABOVE_M, SECONDS, RATE_HZ = 1.5, 10.0, 0.25, 3, 50
NEAR = {"near": {"type": "boundary"}}


def suction(distances: np.ndarray, nu: list[float]) -> np.ndarray:
    """Force towards the bottom [N] on the vehicle held level at a velocity, at distances [m] of its axis."""
    vehicle = pl.Vehicle.from_catalogue("remus100", terms=NEAR)
    still = np.zeros((1, len(vehicle.actuator_names)))
    eta, far = [[0.0, 0.0, 5.0, 0.0, 0.0, 0.0]], []
    for distance in distances:
        walls = [[0.0, 0.0, -1.0, distance]]
        near = vehicle.accelerations(eta, [nu], still, still, walls=walls)[0]
        away = vehicle.accelerations(eta, [nu], still, still)[0]
        far.append((near - away)[0, 2] * vehicle.config.body.mass_matrix[2, 2])
    return np.array(far)


def main(picture: str | None = None) -> tuple[float, float]:
    """Distance [m] from the bottom at the end of the coast, with the term and without."""
    coasts = {}
    for name, terms in (("with the term", NEAR), ("without", {})):
        sim = pl.Simulation.load({
            "world": {"type": "flat", "depth_m": BOTTOM_M}, "tick_rate_hz": RATE_HZ, "duration_s": SECONDS,
            "agents": {"auv": {
                "vehicle": {"type": "remus100", "terms": terms}, "control": "actuators",
                "start": {"position_m": [0.0, 0.0], "depth_m": BOTTOM_M - ABOVE_M, "speed_mps": SPEED_MPS},
            }},
        })  # fmt: skip
        gaps = [ABOVE_M]
        for _ in range(SECONDS * RATE_HZ):
            sim.step()
            gaps.append(BOTTOM_M + sim.state["auv"].position[0, 2])
        coasts[name] = np.array(gaps)
    distances = np.linspace(0.13, 0.8, 25)
    pulls = {f"{SPEED_MPS} m/s ahead": suction(distances, [SPEED_MPS, 0, 0, 0, 0, 0]),
             "0.5 m/s abeam": suction(distances, [0, 0.5, 0, 0, 0, 0])}  # fmt: skip
    for name, gaps in coasts.items():
        print(f"{name}: {gaps[-1]:.3f} m above the bottom after {SECONDS} s")
    for name, pull in pulls.items():
        print(f"{name}: {pull[0]:.2f} N at {distances[0]:.2f} m")
    if picture:
        _draw(picture, coasts, distances, pulls)
    with_term, without = (gaps[-1] for gaps in coasts.values())
    return float(with_term), float(without)


def _draw(path: str, coasts: dict, distances: np.ndarray, pulls: dict) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for name, pull in pulls.items():
        left.semilogy(distances, pull, label=name)
    left.set_xlabel("axis above the bottom [m]")
    left.set_ylabel("suction [N]")
    for name, gaps in coasts.items():
        right.plot(np.arange(len(gaps)) / RATE_HZ, gaps, label=name)
    right.set_xlabel("time [s]")
    right.set_ylabel("axis above the bottom [m]")
    for axes in (left, right):
        axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:2])
