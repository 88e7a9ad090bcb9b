"""Every sonar in one harbour, and two over a dam and a wreck, as pictures in the field's usual colours.

    python examples/sonar_gallery.py [--out FOLDER] [--quick]

Writes imaging.png, multibeam.png, sidescan.png, singlebeam.png, water.png, scanning.png, profiling.png, aperture.png,
doppler.png, dam.png and wreck.png.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from pelagos import jit
from pelagos.acoustics.pulse_pair import speed_of_pair
from pelagos.math.so3 import from_euler
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.altimeter import Altimeter, AltimeterConfig
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar, MechanicalScanningSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.fan_picture import fan_image
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sensors.sonar.profiling_sonar import ProfilingSonar, ProfilingSonarConfig
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig
from pelagos.world.classic import ClassicConfig
from pelagos.world.generate.harbour import HarbourConfig
from pelagos.world.world import World

DT_NS = 5_000_000
WRECK = (22.0, -8.5, -14.0)  # where the harbour's sunken boat lies


def place(world: World) -> Any:
    """What a sensor is built with, for a world."""
    return SensorContext(
        path="gallery.sonar", seed=1, dt_ns=DT_NS, scene=world.scene(), world=world, ocean=build_ocean(OceanConfig()),
        own_body=np.array([NO_BODY], np.uint32),
    )  # fmt: skip


def pose(position: Any, *, yaw: float = 0.0, ticks: Any = (0,), velocity: Any = (0.0, 0.0, 0.0)) -> Any:
    """Motion along given places, one a tick."""
    attitude = [float(a) for a in from_euler(0.0, 0.0, yaw)]
    return lanes(ticks, dt_ns=DT_NS, position=position, attitude=attitude, velocity=velocity)


def track(start: Any, stop: Any, count: int) -> Any:
    """`(count, 3)` places on a line."""
    return np.linspace(start, stop, count)


def imaging(context: Any, folder: Path, quick: bool) -> None:
    """Four looks of a 750 kHz imaging sonar."""
    config = ImagingSonarConfig(range_max_m=30.0, orientation_deg=(0, 12, 0), beams=512, bins=700)
    sonar = ImagingSonar(config, context)
    looks = [
        ("sunken boat", (8, -8, -11.5), 0.0),
        ("pier", (0, 32, -9), np.pi / 2),
        ("pipeline", (0, -22, -11.5), -np.pi / 2),
        ("boulders", (44, 12, -12), 0.4),
    ]
    figure, axes = plt.subplots(2, 2, figsize=(15, 9.4), facecolor="black")
    for ax, (name, position, yaw) in zip(axes.ravel(), looks, strict=True):
        _fan(ax, f"{name}, 30 m", sonar, pose(position, yaw=yaw))
    _save(figure, folder / "imaging.png")


def multibeam(context: Any, folder: Path, quick: bool) -> None:
    """Soundings, backscatter and water column of a pass over the wreck."""
    config = MultibeamConfig(range_max_m=20.0, water_column_bins=600)
    sonar = Multibeam(config.model_copy(update={"water_column_bins": 0}), context)
    count = 100 if quick else 400
    places = track((5, -8, -5), (38, -8, -5), count)
    reading = sonar.sense(pose(places, ticks=range(count), velocity=(1.5, 0, 0)))
    points = reading.extras["soundings"] + places[:, None, :]
    figure = plt.figure(figsize=(15, 11.5))
    grid = figure.add_gridspec(2, 2, height_ratios=(6, 5))
    axes = [figure.add_subplot(grid[0, k]) for k in (0, 1)]
    deep = np.clip(points[..., 2], -17, -10)
    shown = axes[0].scatter(points[..., 0], points[..., 1], c=deep, s=0.6, cmap="viridis")
    figure.colorbar(shown, ax=axes[0], label="z [m]")
    axes[0].set(title="soundings", xlabel="north [m]", ylabel="west [m]", aspect="equal")
    strength = reading.extras["backscatter"]
    shown = axes[1].scatter(points[..., 0], points[..., 1], c=strength, s=0.6, cmap="gray", vmin=-35, vmax=-5)
    figure.colorbar(shown, ax=axes[1], label="backscattering strength [dB]")
    axes[1].set(title="backscatter", xlabel="north [m]", aspect="equal")
    _water_column(figure.add_subplot(grid[1, :]), Multibeam(config, context))
    _save(figure, folder / "multibeam.png")


def _water_column(ax: Any, sonar: Multibeam) -> None:
    """One ping across the wreck, with its soundings."""
    reading = sonar.sense(pose((WRECK[0], WRECK[1], -5.0)))
    angle, reach = np.meshgrid(sonar.tables["angle"], sonar.tables["water_column_range"], indexing="ij")
    level = reading.extras["water_column"][0]
    side, up = -reach * np.sin(angle), -reach * np.cos(angle)
    ax.pcolormesh(side, up, level, vmin=-65, vmax=-5, cmap="inferno", shading="gouraud", rasterized=True)
    found = reading.extras["soundings"][0]
    by_phase = reading.extras["detection"][0] == 2
    for chosen, colour, name in ((by_phase, "cyan", "by phase"), (~by_phase, "lime", "by amplitude")):
        ax.plot(-found[chosen, 1], found[chosen, 2], ".", color=colour, markersize=2, label=name)
    ax.legend(loc="lower right", markerscale=5)
    ax.set(
        title="water column of one ping", xlabel="to starboard [m]", ylabel="up [m]", aspect="equal", ylim=(-12, 0.5)
    )
    ax.set_facecolor("black")


def sidescan(context: Any, folder: Path, quick: bool) -> None:
    """A waterfall past the wreck and over the pipeline."""
    sonar = Sidescan(SidescanConfig(range_max_m=40.0, bins=800), context)
    count = 150 if quick else 900
    places = track((-30, -18, -9.5), (75, -18, -9.5), count)
    image = np.concatenate([_traces(sonar, places[k : k + 50], k) for k in range(0, count, 50)])
    figure, ax = plt.subplots(figsize=(12, 9), facecolor="black")
    ax.imshow(
        np.concatenate([image[:, 0, ::-1], image[:, 1]], axis=1)[::-1], cmap="copper", aspect="auto", vmin=0, vmax=1
    )
    ax.axis("off")
    _save(figure, folder / "sidescan.png")


def _traces(sonar: Any, places: Any, first: int, speed: float = 1.5, yaw: float = 0.0) -> Any:
    return sonar.sense(pose(places, yaw=yaw, ticks=range(first, first + len(places)), velocity=(speed, 0, 0))).data


def singlebeam(context: Any, folder: Path, quick: bool) -> None:
    """An echogram over the wreck, with the bottom's second echo, by way of the surface."""
    config = SinglebeamConfig(
        range_max_m=34.0, bins=680, multipath="surface_and_bottom", multipath_order=2, tvg_db=20.0
    )
    sonar = Singlebeam(config, context)
    count = 100 if quick else 600
    image = _traces(sonar, track((-20, -8.5, -0.7), (60, -8.5, -0.7), count), 0)
    figure, ax = plt.subplots(figsize=(12, 5))
    ax.imshow(image.T, cmap="turbo", aspect="auto", vmin=0, vmax=1, extent=(-20, 60, 34, 0.5))
    ax.set(xlabel="north [m]", ylabel="range [m]", title="echogram, with the bottom's second echo")
    _save(figure, folder / "singlebeam.png")


def water(context: Any, folder: Path, quick: bool) -> None:
    """What is neither bottom nor target: a scattering layer with a shoal in it, waves from below, another sonar."""
    figure, axes = plt.subplots(1, 3, figsize=(19, 4.6), facecolor="black", width_ratios=(1, 1, 1))
    shoal = {"type": "patch", "center_m": [0.0, -8.5, -11.0], "radius_m": 4.0, "height_m": 0.7, "value": 32.0}
    layer = {"type": "profile", "depth_m": [0, 5, 6, 8, 9.5, 20], "value": [-78, -78, -56, -54, -80, -80]}
    hazy = replace_ocean(context, tracers={"volume_scattering_db": [layer, shoal]})
    sonar = Singlebeam(SinglebeamConfig(range_max_m=16.0, bins=400, floor_db=-70.0, dynamic_range_db=65.0), hazy)
    image = _traces(sonar, track((-20, -8.5, -1.5), (60, -8.5, -1.5), 100 if quick else 600), 0)
    axes[0].imshow(image.T, cmap="turbo", aspect="auto", vmin=0, vmax=1, extent=(-20, 60, 16, 0.5))
    axes[0].set_title("echogram: scattering layer, shoal, wreck", color="white")
    axes[0].tick_params(colors="white")
    rough = replace_ocean(context, waves={"type": "jonswap", "significant_height_m": 0.8, "peak_period_s": 3.5})
    up = ImagingSonarConfig(range_max_m=40.0, orientation_deg=(0, -12, 0), bins=600, wind_speed_mps=8.0)
    _fan(axes[1], "waves from below, 40 m", ImagingSonar(up, rough), pose((0, -8, -6)))
    _fan(axes[2], "another vehicle's sonar is heard, 30 m", *_disturbed(context))
    _save(figure, folder / "water.png")


def replace_ocean(context: Any, **options: Any) -> Any:
    """The same place in another ocean."""
    return replace(context, ocean=build_ocean(OceanConfig(**options)))


def _disturbed(context: Any) -> tuple[ImagingSonar, Any]:
    """A sonar before the boat, and the motion at which it hears a second one that looks its way."""
    place, other = (8.0, -8.0, -11.5), (26.0, -3.0, -10.5)
    neighbours = Neighbours(("gallery.sonar", "other.sonar"))
    here = replace(context, neighbours=neighbours)
    there = replace(here, path="other.sonar")
    config = ImagingSonarConfig(range_max_m=30.0, orientation_deg=(0, 12, 0), beams=512, bins=700)
    ImagingSonar(config.model_copy(update={"pulse_s": 1.5e-3, "bandwidth_hz": 20e3}), there)
    neighbours.motion_of = lambda agent: pose(other, yaw=np.pi + 0.27)
    return ImagingSonar(config.model_copy(update={"hears": "others"}), here), pose(place)


def scanning(context: Any, folder: Path, quick: bool) -> None:
    """One turn of a mechanically scanning sonar in front of the pier."""
    config = MechanicalScanningSonarConfig(range_max_m=45.0, step_deg=3.6 if quick else 0.9, rays=768)
    sonar = MechanicalScanningSonar(config, context)
    period = round(1e9 / DT_NS / config.rate_hz)
    count = round(360 / config.step_deg)
    position = np.tile([0.0, 33.0, -9.5], (count, 1))
    reading = sonar.sense(pose(position, ticks=np.arange(count) * period, yaw=np.pi / 2))
    size = 350
    x, y = (size - np.arange(2 * size))[:, None] / size * 45, (size - np.arange(2 * size))[None, :] / size * 45
    place = (np.pi - np.arctan2(y, x)) / (2 * np.pi) * count
    bins = (np.hypot(x, y) - config.range_min_m) / config.bin_width_m
    inside = (bins >= 0) & (bins < config.bins)
    image = reading.data[np.round(place).astype(int) % count, np.clip(bins, 0, config.bins - 1).astype(int)]
    figure, ax = plt.subplots(figsize=(8, 8), facecolor="black")
    ax.imshow(np.where(inside, image, np.nan), cmap="afmhot", vmin=0, vmax=1)
    ax.axis("off")
    _save(figure, folder / "scanning.png")


def profiling(context: Any, folder: Path, quick: bool) -> None:
    """Water column of a profiling sonar across the wreck."""
    sonar = ProfilingSonar(ProfilingSonarConfig(range_max_m=20.0, orientation_deg=(0, 90, 0)), context)
    reading = sonar.sense(pose((WRECK[0], WRECK[1], -4.0), yaw=np.pi / 2))
    fan = fan_image(reading.data[0], sonar.tables["azimuth"], sonar.tables["range"], height=500)
    figure, ax = plt.subplots(figsize=(11, 7))
    ax.imshow(fan[::-1], cmap="turbo", vmin=0, vmax=1)
    ax.axis("off")
    ax.set_title("water column, looking down")
    _save(figure, folder / "profiling.png")


def aperture(context: Any, folder: Path, quick: bool) -> None:
    """Raw pings of a synthetic aperture sonar, and the same focused by back-projection."""
    config = SyntheticApertureSonarConfig(
        range_min_m=6.0, range_max_m=26.0, bins=1600, rays=4096 if quick else 131072, facet_m=0.05, self_noise_db=30.0
    )
    sonar = SyntheticApertureSonar(config, context)
    count = 120 if quick else 800
    places = track((13.0, -22.0, -10.0), (13.0 + 0.02 * count, -22.0, -10.0), count)
    data = np.concatenate([_traces(sonar, places[k : k + 8], k, 0.2) for k in range(0, count, 8)])
    ranges = sonar.tables["range"].astype(float)
    along, across = np.arange(places[0, 0], places[-1, 0], 0.04), np.arange(6.5, 25.0, 0.04)
    there = jit.Array3f64(*places[0].tolist())
    speed = float(np.array(context.ocean.sound_speed(there, jit.Float64(0.0)))[0])
    focused = back_projection(data, places[:, 0], ranges, along, across, config.frequency_hz, speed)
    image = _looks(focused, 2)
    figure, axes = plt.subplots(1, 2, figsize=(14, 8), facecolor="black")
    raw = 20 * np.log10(np.abs(data) * ranges**1.5 + 1e-12)
    for ax, name, level in (
        (axes[0], "raw pings", raw),
        (axes[1], "focused, 2 x 2 looks", 20 * np.log10(image + 1e-12)),
    ):
        top = np.percentile(level, 99.7)
        ax.imshow(level, cmap="copper", aspect="auto", vmin=top - 45, vmax=top)
        ax.set_title(name, color="white")
        ax.axis("off")
    _save(figure, folder / "aperture.png")


def back_projection(
    data: Any, x: Any, ranges: Any, along: Any, across: Any, frequency: float, sound_speed: float
) -> Any:
    """Focus pings `(pings, bins)` taken at `x` [m] on a slant-range grid `(along, across)`: sum at the right phase."""
    image = np.zeros((len(along), len(across)), complex)
    step = ranges[1] - ranges[0]
    for place, trace in zip(x, data * ranges**1.5, strict=True):
        near = np.abs(along - place) < 0.13 * across[-1]
        r = np.hypot(across[None, :], (along[near] - place)[:, None])
        bin_ = (r - ranges[0]) / step
        low = np.clip(bin_.astype(int), 0, len(ranges) - 2)
        share = np.clip(bin_ - low, 0, 1)
        value = (trace[low] * (1 - share) + trace[low + 1] * share) * np.exp(4j * np.pi * frequency * r / sound_speed)
        inside = np.abs(along[near] - place)[:, None] < 0.13 * across[None, :]
        image[near] += np.where(inside, value, 0)
    return image


def _looks(image: Any, count: int) -> Any:
    """Root mean square of blocks of `count` x `count` pixels, which takes from the speckle."""
    rows, columns = (n // count * count for n in image.shape)
    power = np.abs(image[:rows, :columns]) ** 2
    return np.sqrt(power.reshape(rows // count, count, columns // count, count).mean(axis=(1, 3)))


def doppler(context: Any, folder: Path, quick: bool) -> None:
    """What altimeter and DVL hear along a pass over the wreck, and the current that an ADCP finds below a ship."""
    sheared = {
        "type": "profile",
        "depth_m": [0, 4, 8, 12],
        "speed_mps": [0.9, 0.7, 0.2, 0.1],
        "towards_deg": [90.0] * 4,
    }
    there = replace_ocean(context, currents=[sheared], tracers={"volume_scattering_db": -65.0})
    count = 80 if quick else 400
    north = np.linspace(-20, 60, count)
    motion = pose(track((-20, -8.5, -1.5), (60, -8.5, -1.5), count), ticks=range(count), velocity=(1.0, 0, 0))
    figure, grid = plt.subplots(2, 2, figsize=(15, 8.6))
    axes = grid.ravel()
    altimeter = Altimeter(AltimeterConfig(water_column_bins=300, range_max_m=18.0, range_min_m=0.5), there)
    reading = altimeter.sense(motion)
    axes[0].imshow(reading.extras["water_column"].T, cmap="turbo", aspect="auto", vmin=-75, vmax=-5,
                   extent=(-20, 60, 18, 0.5))  # fmt: skip
    axes[0].plot(north, reading.data, "w", linewidth=0.8)
    axes[0].set(title="altimeter: echo, and the range that it reads", xlabel="north [m]", ylabel="range [m]")
    dvl = Dvl(DvlConfig(water_column_bins=300, range_max_m=16.0, range_min_m=0.5), there)
    reading = dvl.sense(motion)
    axes[1].imshow(reading.extras["water_column"][:, 0].T, cmap="turbo", aspect="auto", vmin=-75, vmax=-5,
                   extent=(-20, 60, *dvl.tables["water_column_range"][[-1, 0]]))  # fmt: skip
    axes[1].plot(north, reading.extras["ranges"][:, 0], "w", linewidth=0.8)
    axes[1].set(title="DVL: the beam to port ahead", xlabel="north [m]", ylabel="slant range [m]")
    adcp = Adcp(AdcpConfig(cells=28, cell_m=0.5, iq=True), there)
    reading = adcp.sense(motion)
    free = reading.extras["cell_valid"]
    found = {
        "as it reports it": reading.data,
        "from its raw pairs of pulses": np.where(free[..., None], _pairs(adcp, reading), np.nan),
    }
    for ax, (name, velocity) in zip(axes[2:], found.items(), strict=True):
        east = -velocity[..., 1]  # of the water; the ship does not drift
        mesh = ax.pcolormesh(north, -1.5 - adcp.tables["depth"], east.T, cmap="viridis", vmin=0, vmax=1)
        figure.colorbar(mesh, ax=ax, label="current to the east [m/s]")
        ax.set(title=f"ADCP: current by depth, {name}", xlabel="north [m]", ylabel="z [m]")
    _save(figure, folder / "doppler.png")


def _pairs(adcp: Adcp, reading: Any) -> Any:
    """Velocity of the water `(m, cells, 3)` [m/s], from the phases between the two pulses of each beam."""
    config, r = adcp.config, adcp.tables["water_column_range"]
    depth = r * np.cos(np.radians(config.beam_tilt_deg))
    speeds = [
        speed_of_pair(
            reading.extras["iq"][..., np.abs(depth - middle) < 0.5 * config.cell_m],
            frequency_hz=config.frequency_hz, sound_speed=1500.0, lag_s=config.lag_s,
        )
        for middle in config.depths
    ]  # fmt: skip
    return np.stack(speeds, axis=1) @ np.linalg.pinv(-config.beams).T  # they close as the water comes


def dam(context: Any, folder: Path, quick: bool) -> None:
    """An imaging sonar before the face of a dam, whose mirror-like echo all beams hear: side-lobe arcs."""
    there = place(ClassicConfig(name="dam").build())
    figure, axes = plt.subplots(1, 2, figsize=(15, 5.6), facecolor="black")
    looks = [("dam face, 60 m", (245, 0, -22), 0.0, 10.0, 60.0), ("gates, 40 m", (262, 60, -24), 0.5, 12.0, 40.0)]
    for ax, (name, position, yaw, pitch, reach) in zip(axes, looks, strict=True):
        config = ImagingSonarConfig(
            range_max_m=reach, orientation_deg=(0, pitch, 0), beams=512, bins=800, side_lobe_beams=8 if quick else 128
        )
        _fan(ax, name, ImagingSonar(config, there), pose(position, yaw=yaw))
    _save(figure, folder / "dam.png")


def wreck(context: Any, folder: Path, quick: bool) -> None:
    """A sunken submarine, by imaging sonar and by sidescan."""
    world = ClassicConfig(name="open_water").build()
    there = place(world)
    floor = float(world.height(np.array([35.0]), np.array([-60.0]))[0])
    figure, axes = plt.subplots(1, 2, figsize=(15, 5.6), facecolor="black")
    config = ImagingSonarConfig(
        range_max_m=60.0, orientation_deg=(0, 12, 0), beams=512, bins=900, rays_per_beam=96 if quick else 384
    )
    _fan(axes[0], "submarine, 60 m", ImagingSonar(config, there), pose((-5, -60, floor + 8)))
    sonar = Sidescan(SidescanConfig(range_max_m=60.0, bins=800, rays_per_side=4096), there)
    count = 100 if quick else 500
    yaw, half = np.radians(72.0), 60.0  # past its side, not quite along it
    ahead, aside = np.array([np.cos(yaw), np.sin(yaw), 0]), np.array([-np.sin(yaw), np.cos(yaw), 0])
    middle = np.array([35.0, -60.0, floor + 14]) - 28.0 * aside
    places = track(middle - half * ahead, middle + half * ahead, count)
    image = np.concatenate([_traces(sonar, places[k : k + 50], k, yaw=yaw) for k in range(0, count, 50)])
    both = np.concatenate([image[:, 0, ::-1], image[:, 1]], axis=1)[::-1]
    axes[1].imshow(both, cmap="copper", aspect="auto", vmin=0, vmax=1)
    axes[1].set_title("submarine, sidescan, 60 m each side", color="white")
    axes[1].axis("off")
    _save(figure, folder / "wreck.png")


def _fan(ax: Any, name: str, sonar: ImagingSonar, motion: Any) -> None:
    reading = sonar.sense(motion)
    fan = fan_image(reading.data[0], sonar.tables["azimuth"], sonar.tables["range"], height=620)
    ax.imshow(fan, cmap="copper", vmin=0, vmax=1)
    ax.set_title(name, color="white")
    ax.axis("off")


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=80, facecolor=figure.get_facecolor())
    plt.close(figure)
    print(path)


def main() -> None:
    """Draw everything."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--out", type=Path, default=Path("sonar_gallery"), help="folder of the pictures")
    options.add_argument("--quick", action="store_true", help="fewer pings")
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    context = place(HarbourConfig().build())
    pictures: list[Callable[[Any, Path, bool], None]] = [
        imaging, multibeam, sidescan, singlebeam, water, scanning, profiling, aperture, doppler, dam, wreck,
    ]  # fmt: skip
    for picture in pictures:
        picture(context, given.out, given.quick)


if __name__ == "__main__":
    main()
