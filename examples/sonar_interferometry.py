"""Two synthetic apertures one above the other: focusing by back-projection, motion errors, and heights by phase.

    python examples/sonar_interferometry.py [--out PICTURE] [--quick]

A vehicle that sways by centimetres carries two synthetic aperture sonars 6 cm apart past a box and a mound. Focused as
if the track were straight the picture is blurred; focused along the track that the navigation knows it is sharp. The
phase between both pictures is the height of the ground over the plane that they are focused on. Takes ten seconds.
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

from pelagos import jit
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig

DT_NS = 5_000_000
BOTTOM = -12.0
TRACK_Z = -5.0
BASELINE = 0.06  # [m], of both sonars, upwards
STEP = 0.02  # [m] from ping to ping
WORLD = {
    "type": "flat",
    "depth_m": -BOTTOM,
    "things": [
        {"shape": "box", "at_m": [3.2, 13.0, BOTTOM + 0.2], "size_m": [2.0, 1.5, 0.4], "material": "concrete"},
        {"shape": "sphere", "at_m": [6.4, 15.0, BOTTOM - 1.4], "size_m": [3.6, 3.6, 3.6], "material": "sand"},
    ],
}


def sway(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """The vehicle's way from its line, to port and up `(pings, 2)` [m]: slow against an aperture of 3 m."""
    return np.stack([0.015 * np.sin(2 * np.pi * x / 3.1), 0.01 * np.sin(2 * np.pi * x / 4.3 + 1.0)], axis=-1)


def survey(pings: int, rays: int) -> tuple[list[NDArray[np.complex64]], NDArray[np.float64], Any]:
    """Raw pings of both sonars `(pings, bins)`, the vehicle's places `(pings, 3)`, and the lower sonar."""
    context = SensorContext.alone("auv0.lower", world=WORLD, ocean={}, seed=4)
    x = np.arange(pings) * STEP
    places = np.concatenate([x[:, None], np.stack([np.zeros(pings), np.full(pings, TRACK_Z)], axis=-1) + sway(x)], 1)
    found, first = [], None
    for height in (0.0, BASELINE):
        config = SyntheticApertureSonarConfig(
            position_m=(0.0, 0.0, height), range_min_m=9.0, range_max_m=21.0, bins=960, rays=rays, facet_m=0.04,
            self_noise_db=30.0, bandwidth_hz=40e3,
        )  # fmt: skip
        sonar = SyntheticApertureSonar(config, context)
        blocks = [
            sonar.sense(lanes(range(k, min(k + 8, pings)), dt_ns=DT_NS, position=places[k : k + 8])).data
            for k in range(0, pings, 8)
        ]
        found.append(np.concatenate(blocks))
        first = first or sonar
    return found, places, first


def back_projection(
    data: NDArray[np.complex64], places: NDArray[np.float64], grid: tuple[Any, Any], sonar: Any, speed: float
) -> NDArray[np.complex128]:
    """Pings from `places` `(pings, 3)` on a plane of x by y: each pixel sums what comes from its range, in phase."""
    ranges, config = sonar.tables["range"].astype(float), sonar.config
    x, y = np.meshgrid(*grid, indexing="ij")
    image = np.zeros(x.shape, complex)
    half = np.tan(np.radians(0.5 * config.beamwidth_deg))
    for (px, py, pz), trace in zip(places, data * ranges**1.5, strict=True):
        near = np.abs(grid[0] - px) < half * ranges[-1]
        r = np.sqrt((x[near] - px) ** 2 + (y[near] - py) ** 2 + (BOTTOM - pz) ** 2)
        place = (r - ranges[0]) / (ranges[1] - ranges[0])
        low = np.clip(place.astype(int), 0, len(ranges) - 2)
        share = np.clip(place - low, 0.0, 1.0)
        value = trace[low] * (1 - share) + trace[low + 1] * share
        heard = np.abs(x[near] - px) < half * r
        image[near] += np.where(heard, value * np.exp(4j * np.pi * config.frequency_hz * r / speed), 0.0)
    return image


def height_map(
    lower: NDArray[np.complex128], upper: NDArray[np.complex128], grid: tuple[Any, Any], wavelength: float, looks: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Height over the plane [m] and coherence, in blocks of `looks` pixels each way.

    A scatterer h above the plane lies in the pixel of its range r, and is seen under a sine that is h/r less than that
    pixel's: to the upper sonar it is nearer by b h/r, twice, there and back. Heights repeat by half a wavelength r/b.
    """
    mean = lambda v: _blocks(v, looks)
    product = mean(np.conj(lower) * upper)
    coherence = np.abs(product) / np.sqrt(mean(np.abs(lower) ** 2) * mean(np.abs(upper) ** 2))
    z = TRACK_Z - BOTTOM
    r = np.hypot(mean(np.broadcast_to(grid[1], lower.shape)).real, z)
    per_metre = 4 * np.pi / wavelength * BASELINE / r
    return np.angle(product) / per_metre, coherence


def _blocks(values: Any, count: int) -> Any:
    """Means of blocks of `count` x `count` pixels."""
    rows, columns = (n // count * count for n in values.shape)
    return values[:rows, :columns].reshape(rows // count, count, columns // count, count).mean(axis=(1, 3))


def sharpness(image: NDArray[np.complex128]) -> float:
    """Contrast of intensities, their standard deviation over their mean: a blurred picture has less."""
    power = np.abs(image) ** 2
    return float(power.std() / power.mean())


def main() -> None:
    """Survey, focus, compare, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("interferometry.png"))
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    pings, rays = (240, 8192) if options.quick else (460, 65536)
    data, places, sonar = survey(pings, rays)
    ocean = SensorContext.alone(ocean={}).ocean
    speed = float(np.array(ocean.sound_speed(jit.Array3f64(0.0, 0.0, TRACK_Z), jit.Float64(0.0)))[0])
    pixel = 0.04 if options.quick else 0.03
    grid = np.arange(1.0, STEP * pings - 1.0, pixel), np.arange(9.0, 19.0, pixel)
    straight = np.stack([places[:, 0], np.zeros(pings), np.full(pings, TRACK_Z)], axis=-1)
    blurred = back_projection(data[0], straight, grid, sonar, speed)
    lower, upper = (
        back_projection(d, places + np.array([0.0, 0.0, h]), grid, sonar, speed)
        for d, h in zip(data, (0.0, BASELINE), strict=True)
    )
    wavelength = speed / sonar.config.frequency_hz
    height, coherence = height_map(lower, upper, grid, wavelength, 6)
    flat = height[:, -12:][coherence[:, -12:] > 0.5]
    top = np.abs(_blocks(np.broadcast_to(grid[0][:, None], lower.shape), 6) - 3.2) < 0.8
    top &= np.abs(_blocks(np.broadcast_to(grid[1], lower.shape), 6) - 12.8) < 0.5  # laid over by 0.2 m
    top &= coherence > 0.5
    print(f"contrast of the picture: {sharpness(blurred):.2f} as if straight, {sharpness(lower):.2f} along the track")
    print(f"coherence {np.median(coherence):.2f}; flat ground at {np.median(flat):+.3f} m, within {flat.std():.3f} m")
    print(f"top of the box, 0.40 m high, at {np.median(height[top]):+.2f} m")
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.6), constrained_layout=True)
    extent = (grid[1][0], grid[1][-1], grid[0][0], grid[0][-1])
    for ax, (title, image) in zip(axes, (("as if straight", blurred), ("along the track", lower)), strict=False):
        level = 10 * np.log10(_blocks(np.abs(image) ** 2, 2) + 1e-30)
        peak = np.percentile(level, 99.5)
        ax.imshow(level, extent=extent, origin="lower", cmap="copper", vmin=peak - 28, vmax=peak)
        ax.set(title=title, xlabel="to port [m]")
    axes[0].set_ylabel("along the track [m]")
    shown = axes[2].imshow(
        np.where(coherence > 0.4, height, np.nan), extent=extent, origin="lower", cmap="viridis", vmin=-0.3, vmax=0.6
    )
    axes[2].set(title="height by the phase between both", xlabel="to port [m]")
    figure.colorbar(shown, ax=axes[2], label="[m]", shrink=0.6)
    figure.savefig(options.out, dpi=80)


if __name__ == "__main__":
    main()
