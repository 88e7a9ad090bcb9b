"""A side scan mosaic: four lines over a harbour, each trace put where the vehicle was and looked when it pinged.

    python examples/sonar_mosaic.py [--out PICTURE] [--quick]

The vehicle rolls, yaws and drifts a little. Slant ranges become distances over ground by the altitude that the sonar
itself finds, `ground_range`; where lines overlap a cell keeps the mean of their levels, weighted by how obliquely each
looks. Takes ten seconds.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import from_euler
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig

DT_NS = 125_000_000  # a ping each tick
SPEED = 1.6  # [m/s]
LINES = (-34.0, -20.0, -6.0, 8.0)  # [m] west of the origin, north and south in turn
ENDS = (-30.0, 70.0)
Z = -8.0
CELL = 0.25  # [m], a little more than from ping to ping


def line(y: float, north: bool, spacing: float, seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places `(pings, 3)` and attitudes (roll, pitch, yaw) `(pings, 3)` [rad] of a line that is not quite straight."""
    rng = np.random.Generator(np.random.PCG64(seed))
    x = np.arange(*ENDS, spacing)
    x = x if north else x[::-1]
    waves = lambda size, length: size * np.sin(2 * np.pi * (np.abs(x - x[0]) / length + rng.random()))
    places = np.stack([x, y + waves(0.6, 45.0), Z + waves(0.15, 30.0)], axis=-1)
    yaw = (0.0 if north else np.pi) + waves(np.radians(2.0), 37.0)
    return places, np.stack([waves(np.radians(1.5), 11.0), waves(np.radians(1.0), 17.0), yaw], axis=-1)


def traces(sonar: Sidescan, places: Any, angles: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Levels `(pings, 2, bins)` [dB] and distances over ground `(pings, bins)` [m]."""
    attitude = np.array([from_euler(*a) for a in angles], dtype=float)
    levels, ground = [], []
    for k in range(0, len(places), 40):
        part = slice(k, min(k + 40, len(places)))
        ticks = range(part.start, part.stop)
        motion = lanes(ticks, dt_ns=DT_NS, position=places[part], attitude=attitude[part], velocity=(SPEED, 0, 0))
        reading = sonar.sense(motion)
        levels.append(reading.data)
        ground.append(reading.extras["ground_range"])
    return np.concatenate(levels), np.concatenate(ground)


class Mosaic:
    """Cells over the ground, x north by y west, with the weighted sum of the levels that fall into each."""

    def __init__(self, low: tuple[float, float], high: tuple[float, float]) -> None:
        self.low = np.array(low)
        self.shape = tuple(int(n) for n in np.ceil((np.array(high) - low) / CELL))
        self.total, self.weight = np.zeros(self.shape), np.zeros(self.shape)

    def add(self, levels: Any, ground: Any, places: Any, yaw: Any) -> None:
        """Put a line's traces on the ground: to both sides, square to where the vehicle heads."""
        for side, sign in ((0, 1.0), (1, -1.0)):
            there = np.isfinite(ground)
            across = np.where(there, ground, 0.0) * sign
            x = places[:, :1] - across * np.sin(yaw)[:, None]
            y = places[:, 1:2] + across * np.cos(yaw)[:, None]
            cell = np.floor((np.stack([x, y], axis=-1) - self.low) / CELL).astype(int)
            there &= ((cell >= 0) & (cell < self.shape)).all(axis=-1)
            weight = np.clip(np.abs(across) / 6.0, 0.05, 1.0) * np.clip((30.0 - np.abs(across)) / 10.0, 0.05, 1.0)
            index = tuple(cell[there].T)
            np.add.at(self.total, index, (weight * levels[:, side])[there])
            np.add.at(self.weight, index, weight[there])

    @property
    def level(self) -> NDArray[np.float64]:
        """Mean level [dB]; not a number where nothing fell."""
        with np.errstate(invalid="ignore"):
            return np.where(self.weight > 0, self.total / self.weight, np.nan)


def beam_correction(levels: NDArray[Any], ground: NDArray[Any]) -> NDArray[Any]:
    """Levels less the mean over all pings at the same distance over ground, which is what angle and beam make of it."""
    edges = np.arange(0.0, 41.0, 0.5)
    which = np.digitize(np.nan_to_num(ground), edges)
    out = levels.astype(float).copy()
    for side in (0, 1):
        sums = np.bincount(which.ravel(), levels[:, side].ravel(), len(edges) + 1)
        out[:, side] -= (sums / np.maximum(np.bincount(which.ravel(), minlength=len(edges) + 1), 1))[which]
    return out


def main() -> None:
    """Four lines, one picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("mosaic.png"))
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    spacing = 0.5 if options.quick else SPEED * DT_NS * 1e-9
    context = SensorContext.alone("auv0.sidescan", world={"type": "harbour"}, ocean={}, seed=2, dt_ns=DT_NS)
    sonar = Sidescan(SidescanConfig(range_max_m=32.0, bins=800, scale="db"), context)
    mosaic = Mosaic((ENDS[0] - 2, LINES[0] - 26), (ENDS[1] + 2, LINES[-1] + 26))
    pings = 0
    for k, y in enumerate(LINES):
        places, angles = line(y, k % 2 == 0, spacing, k)
        levels, ground = traces(sonar, places, angles)
        mosaic.add(beam_correction(levels, ground), ground, places, angles[:, 2])
        pings += len(places)
    level = mosaic.level
    print(f"{pings} pings on {len(LINES)} lines; {np.isfinite(level).mean():.0%} of the cells are covered")
    figure, ax = plt.subplots(figsize=(12, 9.4), constrained_layout=True)
    low, high = mosaic.low, mosaic.low + np.array(mosaic.shape) * CELL
    shown = ax.imshow(
        level[:, ::-1], extent=(-high[1], -low[1], low[0], high[0]), origin="lower", cmap="copper", vmin=-9, vmax=9
    )
    ax.set(xlabel="east [m]", ylabel="north [m]", title="mosaic of four side scan lines")
    figure.colorbar(shown, ax=ax, label="level over the mean at its distance [dB]", shrink=0.6)
    figure.savefig(options.out, dpi=80)


if __name__ == "__main__":
    main()
