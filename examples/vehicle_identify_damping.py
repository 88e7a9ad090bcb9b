"""Identify the damping of a BlueROV2 Heavy from a recorded motion, by gradient descent through the simulator.

A "recording" is made with the published coefficients: a wrench that changes every second, 12 s, velocities with noise.
Starting from half of every coefficient, gradient steps (Adam) through all 240 simulated steps find them again.
Run: python examples/vehicle_identify_damping.py
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pelagos import jit
from pelagos.vehicles.gradient import pull_back, rollout
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.terms.damping import LinearDamping, QuadraticDamping
from pelagos.vehicles.vehicle import Vehicle

H, STEPS = 0.05, 240
LINEAR = [13.7, 33.0, 0.8]  # surge, heave, pitch: the axes that have it
QUADRATIC = [141.0, 217.0, 190.0, 1.19, 0.47, 1.5]
TRUE = np.array(LINEAR + QUADRATIC)
NAMES = ["X_u", "Z_w", "M_q", "X_uu", "Y_vv", "Z_ww", "K_pp", "M_qq", "N_rr"]
ROV = Vehicle.from_catalogue("bluerov2_heavy").published  # drag by axis alone


def step(x: list, coefficients: list, wrench: list) -> list:
    """One step of the vehicle whose damping coefficients are data."""
    d = [[0.0] * 6 for _ in range(6)]
    d[0][0], d[2][2], d[4][4] = coefficients[:3]
    terms = {
        **ROV.model.terms,
        "linear_damping": LinearDamping(d, 0.0),
        "quadratic_damping": QuadraticDamping(coefficients[3:]),
    }
    vehicle = ROV.with_model(replace(ROV.model, terms=terms, actuators={}, battery=None))
    still = jit.Array3f64(0.0)
    state = VehicleState(
        position=jit.Array3f64(*x[0:3]),
        attitude=jit.Array4f64(*x[3:7]),
        velocity=jit.Array3f64(*x[7:10]),
        angular_velocity=jit.Array3f64(*x[10:13]),
        acceleration=still,
        angular_acceleration=still,
        actuators=[],
        actuator_memory=[],
        radiation=[],
        mode=jit.Float64(0.0),
        controller=[jit.Float64(0.0)] * 20,
    )
    new = vehicle.step(state, wrench, None, jit.Float64(0.0), (still, still), H, "wrench")
    return [*new.position, *new.attitude, *new.velocity, *new.angular_velocity]


def main(iterations: int = 150) -> np.ndarray:
    """The identified coefficients (9)."""
    random = np.random.default_rng(7)
    size = np.array([60, 60, 60, 3, 3, 6])
    held = random.uniform(-1, 1, (STEPS // 20, 6)) * size
    wrenches = [[jit.Float64(float(v)) for v in held[k // 20]] for k in range(STEPS)]
    start = [jit.Float64(v) for v in [0.0, 0.0, 50.0, 1.0] + [0.0] * 9]
    recording = _velocities(rollout(step, start, [jit.Float64(float(c)) for c in TRUE], wrenches))
    recording += random.normal(0, 0.002, recording.shape)

    scale = np.log(TRUE * 0.5)
    momentum, spread = np.zeros(9), np.zeros(9)
    for k in range(iterations):
        coefficients = [jit.Float64(float(c)) for c in np.exp(scale)]
        states = rollout(step, start, coefficients, wrenches)
        error = _velocities(states) - recording
        cotangents = [[jit.Float64(0.0)] * 7 + [jit.Float64(float(e)) for e in row] for row in error]
        _, gradients, _ = pull_back(step, states, coefficients, wrenches, cotangents)
        slope = np.array([float(g[0]) for g in gradients]) * np.exp(
            scale
        )  # by the logarithm: coefficients stay positive
        momentum = 0.8 * momentum + 0.2 * slope
        spread = 0.95 * spread + 0.05 * slope**2
        rate = 0.12 * (1 - k / iterations) + 0.005
        scale -= rate * momentum / (1 - 0.8 ** (k + 1)) / (np.sqrt(spread / (1 - 0.95 ** (k + 1))) + 1e-12)
        if k % 10 == 9:
            print(f"iteration {k + 1:3d}  rms error {np.sqrt((error**2).mean()):.5f}")
    found = np.exp(scale)
    for name, value, true in zip(NAMES, found, TRUE, strict=True):
        print(f"{name:5s} identified {value:8.3f}   published {true:8.3f}   {100 * (value / true - 1):+6.2f} %")
    return found


def _velocities(states: list) -> np.ndarray:
    return np.array([[float(c[0]) for c in s[7:13]] for s in states])


if __name__ == "__main__":
    main()
