"""Levels of sonars against theory: the table of docs/sonars.md. Prints it; takes half a minute."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.noise import ambient_level, directivity_index, rain_level
from pelagos.acoustics.sphere_scattering import Filling, sphere_strength
from pelagos.config.radiated_noise import ThrusterNoise
from pelagos.errors import ValidityWarning
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.keys.radiated import noise_source
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.world.material import MATERIALS
from pelagos.world.shapes import box, sphere

Row = tuple[str, str, float, float]
LOUD: dict[str, Any] = {"range_max_m": 60.0, "iq": True, "scale": "linear", "source_level_db": 260.0, "beams": 257}
STEEL_DB = 20 * math.log10((7.6585 * 3.9333 - 1) / (7.6585 * 3.9333 + 1))


def context_of(geometries: list[Geometry], *, ocean: Any = None) -> SensorContext:
    """Surroundings of a sonar: things of steel in deep water."""
    steel = (MATERIALS["steel"],)
    world: Any = SimpleNamespace(materials=steel, palette=steel, geometries=())
    return SensorContext(
        path="auv0.sonar", seed=0, dt_ns=5_000_000, scene=Scene(geometries), ocean=ocean or build_ocean(OceanConfig()),
        world=world, own_body=np.full(1, NO_BODY, np.uint32),
    )  # fmt: skip


def sonar(geometries: list[Geometry], **options: Any) -> ImagingSonar:
    """An imaging sonar at -300 m among things of steel."""
    return ImagingSonar(ImagingSonarConfig(**(LOUD | options)), context_of(geometries))


def placed(mesh: Any, x: float, instance: int = 1) -> Geometry:
    """A mesh whose middle is x metres ahead."""
    return Geometry(np.asarray(mesh.vertices) + np.array([x, 0.0, -300.0]), mesh.faces, 0, 1, instance)


def power(s: ImagingSonar, tick: int = 0, **motion: Any) -> Any:
    """Intensity of a ping re the source level at 1 m `(beams, bins)`."""
    heard = s.sense(lanes([tick], dt_ns=5_000_000, position=(0.0, 0.0, -300.0), **motion))
    return np.abs(heard.extras["iq"][0]) ** 2


def strength(s: ImagingSonar, distance: float) -> float:
    """Apparent target strength of the loudest cell [dB]."""
    return 10 * math.log10(power(s).max()) + 40 * math.log10(distance) + 2 * loss_at(s.config.frequency_hz) * distance


def rows() -> list[Row]:
    """(quantity, source, theory, measured), in dB but for the last."""
    found: list[Row] = []
    ts = lambda a, f, filling, c: float(sphere_strength(a, f, filling, sound_speed=c))
    found.append(
        ("rigid sphere, 10 mm, 12 kHz: target strength", "Jech et al. 2015", -54.44, ts(0.01, 12e3, None, 1477.4))
    )
    gas = Filling(1.24 / 1026.8, 345.0 / 1477.4)
    found.append(("gas sphere, 10 mm, 12 kHz", "Jech et al. 2015", -42.34, ts(0.01, 12e3, gas, 1477.4)))
    carbide = Filling(14.9 / 1.026, 6853 / 1490, 4171 / 1490)
    found.append(("tungsten carbide, 38.1 mm, 120 kHz", "ICES Report 144", -39.5, ts(0.01905, 120e3, carbide, 1490.0)))
    copper = Filling(8.947 / 1.026, 4760 / 1490, 2288.5 / 1490)
    found.append(("copper, 60 mm, 38 kHz", "Foote 1982", -33.6, ts(0.03, 38e3, copper, 1490.0)))
    ball = sphere(0.1, sides=192, rings=96)
    for distance in (15.0, 40.0):
        theory = 20 * math.log10(0.05 * (distance - 0.1) / distance) + STEEL_DB
        heard = strength(sonar([placed(ball, distance)]), distance - 0.1)
        found.append((f"steel sphere, 0.1 m, {distance:g} m away, loudest cell", "20 log a/2", theory, heard))
    theory = 20 * math.log10(0.15**2 / 0.015) + STEEL_DB
    heard = strength(sonar([placed(box((1.0, 0.15, 0.15)), 20.5)], frequency_hz=100e3), 20.0)
    found.append(("steel plate, 0.15 m square, 100 kHz, 20 m", "20 log A/lambda", theory, heard))
    density = 10 * math.log10(10 ** (ambient_level(750e3, 0.0) / 10) + 10**5.5)
    index = directivity_index(math.radians(1.0), math.radians(20.0))
    theory = density - 10 * math.log10(0.5e-3) + 10 * math.log10(1.5) - index - 260.0
    quiet = placed(ball, 5000.0)
    for options in ({}, {"beams": 514}, {"bins": 2048}):
        name = ", ".join(f"{k} {v}" for k, v in options.items()) or "defaults"
        heard = 10 * math.log10(power(sonar([quiet], **options)).mean())
        found.append((f"noise re the source level, {name}", "NL - 10 log T - DI + 1.8", theory, heard))
    found.append(("rain of 10 mm/h at 5 kHz", "Ma et al. 2005", 57.8, rain_level(5e3, 10.0)))
    fast = sonar([placed(ball, 15.1)], bins=8192, range_max_m=20.0)
    still, moving = (
        float(fast.tables["range"][power(fast, velocity=(v, 0.0, 0.0)).max(axis=0).argmax()]) for v in (0.0, 2.0)
    )
    found.append(("range taken for nearer at 2 m/s, 15 m [mm]", "f T v/B + r v/c", 25.0 + 20.0, 1e3 * (still - moving)))
    return [*found, vehicle_noise(), channel_errors(ball), few_scatterers(), front()]


def vehicle_noise() -> Row:
    """Noise of thrusters 30 m ahead in the beam that looks there, re the source level."""
    around = context_of([])
    noise = noise_source(ThrusterNoise(level_db=150.0, frequency_hz=10e3, speed_mps=1.0))
    neighbours = Neighbours(noises={"other": noise})
    neighbours.motion_of = lambda _: lanes([0], dt_ns=5_000_000, position=(30.0, 0.0, -300.0), velocity=(0.0, 1.0, 0.0))
    loud, still = (
        ImagingSonar(ImagingSonarConfig(**(LOUD | {"bins": 2000})), replace(around, neighbours=n))
        for n in (neighbours, None)
    )
    added = np.mean([power(loud, k)[128].mean() - power(still, k)[128].mean() for k in range(3)])
    received = 150.0 - 20 * math.log10(75.0) - 20 * math.log10(30.0) - loss_at(750e3) * 30.0
    theory = received - 10 * math.log10(0.5e-3) + 10 * math.log10(1.5) - 260.0
    return "noise of thrusters 30 m away in the beam that looks there", "SL - 20 log r - a r", theory, to_db(added)


def channel_errors(ball: Any) -> Row:
    """Floor of side lobes that 1.2 dB and 9 deg of error of each channel raise, re the lobe that looks there."""
    floors = []
    for seed in range(16):
        keys = {"channel_gain_db": 1.2, "channel_phase_deg": 9.0, "channel_seed": seed, "shading": "hann"}
        heard = power(sonar([placed(ball, 15.0)], beams=65, horizontal_aperture_deg=65.0, **keys))
        level = heard[:, heard.max(axis=0).argmax()]
        floors.append(level[np.abs(np.arange(65) - 32) > 12].mean() / level.max())
    gain, phase = 1.2 * math.log(10) / 20, math.radians(9.0)
    mean = math.exp(gain**2 / 2 - phase**2 / 2)
    theory = to_db((math.exp(2 * gain**2) / mean**2 - 1) * 1.5 / 166)  # 166 Hann-shaded elements
    return "side lobes by errors of channels, 1.2 dB and 9 deg", "Hsiao 1984", theory, to_db(np.mean(floors))


def few_scatterers() -> Row:
    """Second moment of intensities at 11 m over the square of their mean, of 300 scatterers a cubic metre."""
    keys = {"volume_scattering_db": -50.0, "volume_scatterers_per_m3": 300.0, "bins": 1200, "range_max_m": 32.0}
    s = sonar([], side_lobe_beams=0, horizontal_aperture_deg=60.0, **keys)
    r = s.tables["range"].astype(float)
    near = power(s)[:, np.abs(r / 11.0 - 1) < 0.02]
    near = near / near.mean(axis=0)
    width = (1 + 0.5 / 9) * math.radians(1.0) / (0.8859 * 1.1294) / math.cos(math.radians(15.0))
    nu = 300.0 * width * math.radians(20.0) * 1.5 * 1500.0 / 60e3 * 11.0**2
    theory, found = 2 * (1 + 1 / nu), float((near**2).mean())
    return "<I^2>/<I>^2 of 300 scatterers a cubic metre at 11 m [1]", "Abraham and Lyons 2002", theory, found


def front() -> Row:
    """Range of a wall 900 m away, of which 460 m are in warmer water."""
    warm = {"type": "front", "through_m": [440.0, 0.0], "towards_deg": 0.0, "step": 6.0, "width_m": 40.0}
    ocean = build_ocean(OceanConfig.model_validate({"temperature_c": [{"type": "uniform", "value": 8.0}, warm]}))
    keys = {"frequency_hz": 50e3, "bandwidth_hz": 3e3, "rate_hz": 0.5, "bins": 4096, "range_max_m": 1000.0}
    keys |= {"beams": 5, "horizontal_aperture_deg": 5.0, "vertical_beamwidth_deg": 2.0, "refraction": True}
    wall = placed(box((1.0, 400.0, 400.0)), 900.5)
    s = ImagingSonar(ImagingSonarConfig(**(LOUD | keys)), context_of([wall], ocean=ocean))
    measured = float(s.tables["range"][power(s)[2].argmax()])
    speed = [
        float(np.array(ocean.sound_speed(jit.Array3f64(float(x), 0.0, -300.0), jit.Float64(0.0)))[0])
        for x in np.arange(0.5, 900.0)
    ]
    return (
        "range of a wall 900 m away behind a front [m]",
        "c integral of dr/c",
        speed[0] * sum(1 / c for c in speed),
        measured,
    )


def loss_at(frequency: float) -> float:
    """Absorption at 300 m in the default ocean [dB/m]."""
    water = build_ocean(OceanConfig())
    place, t = jit.Array3f64(0.0, 0.0, -300.0), jit.Float64(0.0)
    return float(
        absorption(jit.Float64(frequency), water.temperature(place, t), water.salinity(place, t), 300.0, 8.1)[0]
    )


def to_db(ratio: float) -> float:
    """10 log10 of a ratio of powers."""
    return 10 * math.log10(ratio)


def table() -> list[str]:
    """The table's lines."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        made = rows()
    lines = ["| quantity | theory or source | expected | measured | deviation |", "|---|---|---|---|---|"]
    return lines + [f"| {name} | {source} | {t:.1f} | {m:.1f} | {m - t:+.1f} |" for name, source, t, m in made]


if __name__ == "__main__":
    print("\n".join(table()))
