"""Thrust that is left of a thruster's bollard thrust in a flow, and of a thruster's in another's jet.

python examples/vehicle_thruster_losses.py [PICTURE.png]
"""

from __future__ import annotations

import math
import sys
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

import pelagos as pl

Floats = NDArray[np.float64]

THRUST_N = 30.0
DIAMETER_M = 0.12
FORWARD = 1.86e-3  # [N s^2]: rho D^4 KT(0)/(2 pi)^2, KT(0) = 0.345 of a B4-55 of P/D 0.8
SHAFT_RAD_S = math.sqrt(THRUST_N / FORWARD)
FORCE = {
    "type": "force_thruster", "low_n": -60, "high_n": 60, "direction": [1, 0, 0], "position_m": [0, 0, 0],
    "time_constant_s": 0.05, "diameter_m": DIAMETER_M,
}  # fmt: skip
PROPELLER = {
    "type": "thruster", "forward": FORWARD, "reverse": FORWARD, "low": -400,
    "high": 400, "direction": [1, 0, 0], "position_m": [0, 0, 0], "time_constant_s": 0.05, "diameter_m": DIAMETER_M,
}  # fmt: skip
B_SERIES = {"type": "b_series", "pitch_ratio": 0.8, "area_ratio": 0.55, "blades": 4}
LAWS = {
    "open disc": (FORCE, {"type": "disc"}, THRUST_N),
    "ducted disc": (FORCE, {"type": "disc", "ducted": True}, THRUST_N),
    "B4-55, P/D 0.8": (PROPELLER, B_SERIES, SHAFT_RAD_S),
}


def craft(thrusters: dict[str, Any], **more: Any) -> pl.Vehicle:
    """A body without drag, so that all that accelerates it is thrust."""
    return pl.Vehicle.from_dict({
        "type": "custom", "length_m": 2, "beam_m": 1, "height_m": 1,
        "mass": {"type": "explicit", "mass_kg": 1, "inertia_kg_m2": [1, 1, 1]},
        "added_mass": {"type": "diagonal", "diagonal": [0] * 6}, "coriolis": {"rigid": "none"},
        "actuators": thrusters, "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators", **more,
    })  # fmt: skip


def thrust(vehicle: pl.Vehicle, states: list[float], speeds: Floats) -> Floats:
    """Force along x `(n,)` at speeds ahead `(n,)`."""
    n, still = len(speeds), np.zeros((len(speeds), 6))
    nu = still.copy()
    nu[:, 0] = speeds
    held = np.tile(states, (n, 1))
    return vehicle.accelerations(still, nu, held, held)[0][:, 0]


def in_flow(speeds: Floats) -> dict[str, Floats]:
    """Share of the bollard thrust left, by law."""
    found = {}
    for name, (part, inflow, state) in LAWS.items():
        force = thrust(craft({"it": {**part, "inflow": inflow}}), [state], speeds)
        found[name] = force / THRUST_N
    return found


def in_jet(distance: float, angle_deg: float) -> float:
    """Share of the thrust left to a thruster behind an equal one that is turned away."""
    turn = math.radians(angle_deg)
    pair = {
        "front": {**FORCE, "direction": [math.cos(turn), math.sin(turn), 0], "inflow": {"type": "disc"}},
        "rear": {**FORCE, "position_m": [-distance * DIAMETER_M, 0, 0], "inflow": {"type": "disc"}},
    }
    vehicle = craft(pair, interaction={"thrusters": ["front", "rear"]})
    alone = thrust(vehicle, [THRUST_N, 0.0], np.zeros(1))
    return float((thrust(vehicle, [THRUST_N, THRUST_N], np.zeros(1)) - alone)[0]) / THRUST_N


def main() -> None:
    speeds, distances, angles = np.linspace(0, 4, 41), np.linspace(1, 16, 31), (0, 5, 10, 20, 30)
    flow = in_flow(speeds)
    jets = {angle: [in_jet(x, angle) for x in distances] for angle in angles}
    print("share left at 2 m/s:", {name: round(float(np.interp(2.0, speeds, s)), 2) for name, s in flow.items()})
    print(
        "share left 4 D behind:", {f"{a} deg": round(float(np.interp(4.0, distances, s)), 2) for a, s in jets.items()}
    )
    if len(sys.argv) > 1:
        draw(sys.argv[1], speeds, flow, distances, jets)


def draw(path: str, speeds: Floats, flow: dict[str, Floats], distances: Floats, jets: dict[int, list[float]]) -> None:
    """The two sides by side."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
    for name, share in flow.items():
        left.plot(speeds, share, label=name)
    left.set(xlabel="speed ahead [m/s]", ylabel="thrust over bollard thrust", title=f"{THRUST_N:g} N, {DIAMETER_M:g} m")
    for angle, share in jets.items():
        right.plot(distances, share, label=f"{angle} deg")
    right.set(xlabel="distance in diameters", title="behind another, by its angle", ylim=(0, 1.05))
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
