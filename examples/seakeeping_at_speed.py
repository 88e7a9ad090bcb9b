"""Response of the Mariner in regular waves at three speeds, head, beam and following seas.

Run it with the name of a folder: it writes `seakeeping_at_speed.png` there and prints a table. The hull is held on its
course in small waves, as the simulator has them, and what pushes it is analysed at the frequency of encounter; its
motion is the solution of (C - w^2 (M + A) + i w B) x = F with strip theory's A and B at that speed.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

import pelagos as pl
from pelagos import jit
from pelagos.hydro.forward_speed import at_speed
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.integrate import Rigid
from pelagos.vehicles.vehicle import Vehicle

mpl.use("Agg")
import matplotlib.pyplot as plt

GRAVITY = 9.81
SPEEDS = {"0 kn": 0.0, "7.5 kn": 3.86, "15 kn": 7.72}
SEAS = {"head": 180.0, "beam": 90.0, "following": 0.0}
AMPLITUDE = 0.05  # m


def excitation(vehicle: Vehicle, omega: float, heading: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies of encounter `(k,)` [rad/s], and forces `(k, 6)` on the hull held on its course, over the amplitude.

    Args:
        vehicle: that floats, with diffraction at speed.
        omega: of the wave [rad/s].
        heading: directions that it travels towards, from the bow over starboard `(k,)` [rad].
        speed: ahead `(k,)` [m/s].
    """
    met = omega - omega**2 / GRAVITY * speed * np.cos(heading)
    wave = {"type": "regular", "height_m": 2 * AMPLITUDE, "period_s": 2 * np.pi / omega, "towards_deg": 0.0}
    ocean = build_ocean(OceanConfig.model_validate({"waves": [wave]}), seed=1)
    t = (np.arange(16) / 16 * 2 * np.pi / np.abs(met)[:, None]).ravel()
    course, ahead = np.repeat(-heading, 16), np.repeat(speed, 16)
    f64 = jit.Float64
    zero = f64(0 * t)
    attitude = jit.Array4f64(f64(np.cos(course / 2)), zero, zero, f64(np.sin(course / 2)))
    place = [f64(ahead * np.cos(course) * t), f64(ahead * np.sin(course) * t), zero]
    flow = vehicle.flow(Rigid(place, attitude, [f64(ahead), *[zero] * 5]), ocean, f64(t))
    load = np.array([np.array(x + zero) for x in flow.seaway.load]).reshape(6, len(met), 16)
    turn = np.exp(-1j * (np.abs(met)[:, None] * t.reshape(len(met), 16)))
    return np.abs(met), 2 * np.mean(load * turn, axis=2).T / AMPLITUDE


def response(vehicle: Vehicle, heading: float, speed: float, met: float, force: np.ndarray) -> np.ndarray:
    """Amplitudes (6) of motion [m], [rad] by a force (6) at a frequency of encounter [rad/s]."""
    found = vehicle.config.afloat.coefficients
    table = np.array(found.omega_radps)
    zero_speed = [
        np.array([[np.interp(met, table, np.array(m)[:, i, j]) for j in range(6)] for i in range(6)])
        for m in (found.added_mass, found.damping)
    ]
    density = vehicle.config.body.density
    added, damping = at_speed(density * zero_speed[0], density * zero_speed[1], met, speed)
    damping = damping + np.diag(vehicle.config.terms["damping"].diagonal)
    matrix = vehicle.model.sea.stiffness - met**2 * (vehicle.config.body.rigid + added) + 1j * met * damping
    free = [2, 4] if abs(np.sin(heading)) < 1e-6 else [1, 2, 3, 4, 5]
    motion = np.zeros(6, complex)
    motion[free] = np.linalg.solve(matrix[np.ix_(free, free)], force[free])
    return motion


def main(folder: Path, points: int = 36) -> dict[tuple[str, str], np.ndarray]:
    """The picture; returns heave [m/m], roll and pitch over the wave's slope `(points, 3)` by sea and speed."""
    vehicle = pl.Vehicle.from_dict({"type": "mariner", "variant": "strips"})
    length = vehicle.config.length_m
    over = np.geomspace(0.45, 6.0, points)  # wave lengths over that of the hull
    wavenumber = 2 * np.pi / (over * length)
    cases = [(sea, name) for sea in SEAS for name in SPEEDS]
    heading = np.radians([SEAS[sea] for sea, _ in cases])
    speed = np.array([SPEEDS[name] for _, name in cases])
    found = {case: np.zeros((points, 3)) for case in cases}
    for i, k in enumerate(wavenumber.tolist()):
        met, force = excitation(vehicle, float(np.sqrt(GRAVITY * k)), heading, speed)
        for j, case in enumerate(cases):
            size = np.abs(response(vehicle, float(heading[j]), float(speed[j]), float(met[j]), force[j]))
            found[case][i] = size[2], size[3] / k, size[4] / k
    figure, axes = plt.subplots(2, 3, figsize=(11, 6), sharex=True, layout="constrained")
    for column, sea in enumerate(SEAS):
        below = 1 if sea == "beam" else 2
        for name in SPEEDS:
            axes[0, column].plot(over, found[sea, name][:, 0], label=name)
            axes[1, column].plot(over, found[sea, name][:, below])
        axes[0, column].set_title(f"{sea} sea")
        axes[0, column].set_ylabel("heave over amplitude [-]")
        axes[1, column].set_ylabel(f"{'roll' if below == 1 else 'pitch'} over wave slope [-]")
        axes[1, column].set_xlabel("wave length over ship length [-]")
    for axis in axes.flat:
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    axes[0, 0].legend(title="speed")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "seakeeping_at_speed.png", dpi=110)
    plt.close(figure)
    for (sea, name), rows in found.items():
        i = int(np.argmin(np.abs(over - 1.5)))
        print(f"{sea:9s} {name:6s} waves of {over[i]:.2f} ship lengths: heave {rows[i, 0]:.2f}, pitch {rows[i, 2]:.2f}")
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
