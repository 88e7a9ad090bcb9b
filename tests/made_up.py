"""Readings and a mission that nobody measured, uneven in every number, for tests of what is made of recordings.

No kernel is compiled for them: shapes and extras are those that sensors promise, values are drawn by NumPy's PCG64.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import NDArray

from pelagos.config import registry
from pelagos.math.geomagnetism import earth_field
from pelagos.math.so3 import rotate_np
from pelagos.sensors.sensor import Measurement, Reading, SensorConfig
from pelagos.sim.record import Recorder

DT_NS: Final = 50_000_000
SECONDS: Final = 36.0
ORIGIN: Final = (45.0, 12.5)
_MOUNT: Final = {"position_m": [0.31, -0.12, 0.07], "orientation_deg": [4.0, -7.0, 11.0]}
_PICTURE: Final = {"width_px": 40, "height_px": 24, "rate_hz": 1, **_MOUNT}
_PING: Final = {"range_min_m": 0.7, "range_max_m": 21.0, **_MOUNT}
KEYS: Final[dict[str, dict[str, Any]]] = {
    "imu": {"rate_hz": 20}, "dvl": {"rate_hz": 5, "position_m": [-0.2, 0.06, -0.1], "orientation_deg": [0, 0, 35]},
    "depth": {"rate_hz": 10, "position_m": [0.5, 0.1, -0.2]}, "gps": {"rate_hz": 2}, "magnetometer": {"rate_hz": 5},
    "altimeter": {"rate_hz": 5, "position_m": [0.2, -0.05, -0.15], "orientation_deg": [2, -3, 0]},
    "multibeam": {"rate_hz": 5, "beams": 24, "position_m": [0.3, 0.1, -0.2], "orientation_deg": [2.0, -3.0, 4.0]},
    "imaging_sonar": {"rate_hz": 2, "beams": 24, "bins": 40, **_PING},
    "profiling_sonar": {"rate_hz": 1, "beams": 30, "bins": 44, **_PING},
    "sidescan": {"rate_hz": 2, "bins": 70, **_PING},
    "singlebeam": {"rate_hz": 2, "bins": 60, **_PING},
    "mechanical_scanning_sonar": {"rate_hz": 5, "bins": 50, "step_deg": 3.0, **_PING},
    "synthetic_aperture_sonar": {"rate_hz": 2, "bins": 64, **_MOUNT},
    "camera": _PICTURE, "depth_camera": _PICTURE, "semantic_camera": _PICTURE, "instance_camera": _PICTURE,
    "normal_camera": _PICTURE, "optical_flow_camera": _PICTURE, "thermal_camera": _PICTURE, "event_camera": _PICTURE,
    "lidar": {"rate_hz": 1, **_MOUNT}, "semantic_lidar": {"rate_hz": 1, **_MOUNT},
    "collision": {"rate_hz": 10}, "ctd": {"rate_hz": 2}, "pose": {"rate_hz": 5}, "velocity": {"rate_hz": 5},
    "current_meter": {"rate_hz": 2}, "turbidity": {"rate_hz": 2}, "oxygen": {"rate_hz": 2},
    "fluorometer": {"rate_hz": 2}, "sound_velocity": {"rate_hz": 2},
    "range_finder": {"rate_hz": 2, "azimuth_deg": [0, 35, -50], "elevation_deg": [10, -20, 35]},
}  # fmt: skip
SCENARIO: Final[dict[str, Any]] = {
    "name": "made-up mission", "description": "Nobody sailed it: 3 vehicles, 1 mover.", "seed": 7,
    "origin": {"latitude_deg": ORIGIN[0], "longitude_deg": ORIGIN[1]},
    "world": {
        "type": "generated", "size_m": [70, 52], "grid_m": 2.0, "depth_m": 14.0, "seed": 3,
        "terrain": {"kind": "ridges", "relief_m": 3.3, "wavelength_m": 31.0, "heading_deg": -35.0},
        "objects": [{"kind": "boulder", "at_m": [[6.0, -9.0], [-13.0, 8.0]]}, {"kind": "tyre", "at_m": [[3.0, 5.0]]},
                    {"kind": "anchor", "at_m": [[11.0, 3.0]]}],
        "movers": [{"name": "seal one", "body": "fish", "size_m": 1.4,
                    "path": {"kind": "waypoints", "points_m": [[9, -6, -3], [1, 12, -5]], "speed_mps": 0.8}}],
    },
    "ocean": {
        "currents": [{"type": "tidal", "speed_mps": 0.3, "towards_deg": 70.0, "period_h": 0.04},
                     {"type": "profile", "depth_m": [0, 9], "speed_mps": [0.4, 0.1], "towards_deg": [20, 120]}],
        "temperature_c": [{"type": "profile", "depth_m": [0.0, 5.0, 14.0], "value": [18.0, 13.0, 9.0]}],
        "salinity": [{"type": "profile", "depth_m": [0.0, 14.0], "value": [31.0, 35.0]}],
        "tracers": {"dye": [{"type": "profile", "depth_m": [0.0, 9.0], "value": [2.0, 0.5]}]},
        "waves": {"type": "regular", "height_m": 0.7, "period_s": 3.1, "towards_deg": 115.0, "phase_deg": 40.0},
    },
    "props": {"crate": {"shape": "box", "position_m": [4.0, -3.0, -6.0], "size_m": [1.0, 2.0, 0.5],
                        "orientation_deg": [0.0, 10.0, 30.0]}},
    "agents": {
        "auv0": {"vehicle": "remus100", "start": {"depth_m": 3.0}, "sensors": {},
                 "navigation": {"type": "ekf"}},
        "rov": {"vehicle": "bluerov2_heavy", "start": {"position_m": [7.0, -5.0], "depth_m": 5.0}, "sensors": {}},
        "usv": {"vehicle": "otter", "start": {"position_m": [-9.0, 4.0]}, "sensors": {}},
    },
}  # fmt: skip
OWNERS: Final = {"rov": ("camera", "depth", "sidescan", "collision"), "usv": ("gps", "lidar")}


def configs(kinds: tuple[str, ...] = tuple(KEYS)) -> dict[str, SensorConfig]:
    """Configurations by type."""
    made = ((kind, registry.find("sensor", kind).config) for kind in kinds)
    return {kind: model.model_validate({"type": kind, **KEYS[kind]}) for kind, model in made}


def motion(seconds: float, *, apart: float = 0.0) -> tuple[NDArray[Any], ...]:
    """Times [ns], position NWU, attitude, velocity FLU, rates FLU of a vehicle that turns, rolls, dives and slows."""
    k = np.arange(0, round(seconds * 1e9), DT_NS)
    t = k * 1e-9
    yaw = 0.4 + apart + 0.6 * np.sin(t / 7.0) + 0.03 * t
    roll, pitch = 0.11 * np.sin(t / 2.3 + apart), 0.2 * np.sin(t / 5.0) + 0.04
    half = [np.stack([np.cos(a / 2), *(np.sin(a / 2) * e for e in axis)], axis=-1)
            for a, axis in ((yaw, (0, 0, 1)), (pitch, (0, 1, 0)), (roll, (1, 0, 0)))]  # fmt: skip
    attitude = _product(_product(half[0], half[1]), half[2])
    velocity = np.stack([1.1 + 0.3 * np.cos(t / 6.0), 0.07 * np.sin(t / 3.0), 0.05 * np.cos(t / 4.0)], axis=-1)
    step = rotate_np(attitude, velocity) * DT_NS * 1e-9
    position = np.array([-11.0 + 3.0 * apart, 4.0 - 5.0 * apart, -3.0 - apart]) + np.cumsum(step, axis=0)
    position[:, 2] = np.clip(position[:, 2], -9.0, -0.4)
    rates = np.stack([np.gradient(a, t) for a in (roll, pitch, yaw)], axis=-1)
    return k, position, attitude, velocity, rates


def _product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    aw, av, bw, bv = a[:, :1], a[:, 1:], b[:, :1], b[:, 1:]
    return np.concatenate(
        [aw * bw - (av * bv).sum(axis=1, keepdims=True), aw * bv + bw * av + np.cross(av, bv)], axis=1
    )


def measured(kind: str, config: Any, moved: tuple[NDArray[Any], ...], *, seed: int = 5) -> Measurement:
    """What a sensor reads at every row of a motion."""
    t_ns, p, q, v, w = moved
    n, rng = len(t_ns), np.random.Generator(np.random.PCG64([seed, len(kind), ord(kind[1])]))
    t, extras = t_ns * 1e-9, dict[str, Any]()
    inverse = q * np.array([1.0, -1.0, -1.0, -1.0])
    data: NDArray[Any]
    match kind:
        case "imu":
            up = rotate_np(inverse, np.broadcast_to([0.0, 0.0, 9.81], (n, 3)))
            data = np.concatenate([up + np.cross(w, v) + 0.02 * rng.standard_normal((n, 3)), w], axis=1)
        case "dvl":
            data = v + 0.01 * rng.standard_normal((n, 3))
            ranges = (14.0 + p[:, 2])[:, None] * np.array([1.1, 1.2, 1.3, 1.15])
            ranges[n // 3 : n // 3 + 2, 1] = np.nan
            extras = {"sigma": np.full((n, 4), 0.01), "beam_valid": np.isfinite(ranges), "ranges": ranges,
                      "altitude": 14.0 + p[:, 2], "beam_velocity": rng.normal(0, 0.3, (n, 4))}  # fmt: skip
        case "depth":
            data = -p[:, 2] + 0.03 + 0.02 * rng.standard_normal(n)
        case "gps":
            data = np.stack([ORIGIN[0] + p[:, 0] / 111e3, ORIGIN[1] - p[:, 1] / 78.6e3, p[:, 2]], axis=-1)
        case "magnetometer":
            data = rotate_np(inverse, np.broadcast_to(earth_field(*ORIGIN), (n, 3)))
        case "altimeter":
            data = 14.0 + p[:, 2] + 0.05 * rng.standard_normal(n)
        case "multibeam":
            angle = np.asarray(config.angles)
            data = (13.0 + p[:, 2] + 0.4 * np.sin(p[:, 0]))[:, None] / np.cos(angle) + 0.02 * rng.random(
                (n, len(angle))
            )
            data[:, 3] = np.where(t % 2 < 0.6, np.nan, data[:, 3])
            extras = {"backscatter": (-20.0 - 9 * rng.random(data.shape)).astype(np.float32),
                      "soundings": data[..., None] * np.stack([0 * angle, np.sin(angle), -np.cos(angle)],
                      axis=-1)}  # fmt: skip
        case "imaging_sonar" | "profiling_sonar":
            data = 0.1 + 0.2 * rng.random((n, len(config.azimuths), config.bins))
            for i in range(n):
                data[i, (3 * i) % 17 : (3 * i) % 17 + 6, 5 + i % 19 : 15 + i % 19] += 0.5
            data = data.astype(np.float32)
        case "sidescan" | "synthetic_aperture_sonar":
            data = (rng.random((n, 2, config.bins)) ** 2 * np.linspace(1.0, 0.3, config.bins)).astype(np.float32)
            extras = {"altitude": 14.0 + p[:, 2]}
        case "singlebeam" | "mechanical_scanning_sonar":
            data = (rng.random((n, config.bins)) ** 2 * np.linspace(1.0, 0.2, config.bins)).astype(np.float32)
            extras = {"angle": np.radians(-40.0 + 9.0 * np.arange(n))}
        case "lidar" | "semantic_lidar":
            data = rng.uniform(-6.0, 9.0, (n, 4, 30, 4)) * [1.0, 0.7, 0.4, 0.1]
            data[:, 1, 5:9, :3] = np.nan
            data = data.astype(np.float32)
            if kind == "semantic_lidar":
                extras = {name: rng.integers(0, 6, (n, 4, 30)).astype(np.uint32) for name in ("label", "instance")}
        case "collision":
            force = np.where((t % 11.0 > 10.0)[:, None], [30.0, -12.0, 5.0], 0.0)
            data = np.linalg.norm(force, axis=1) > 1.0
            extras = {"force": force, "moment": np.where((t % 9.0 > 8.0)[:, None], [12.0, 7.0, -20.0], 0.0)}
        case "ctd":
            data = np.stack([3.4 + 0.01 * t, 15.0 + p[:, 2], -1.01 * p[:, 2]], axis=-1)
            extras = {"salinity": 33.0 - 0.1 * p[:, 2], "sound_speed": 1490.0 + 0.3 * p[:, 2]}
        case "pose":
            data = np.concatenate([p, q], axis=1)
        case "velocity":
            data = rotate_np(q, v)
        case "current_meter":
            data = 0.2 * v + rng.normal(0, 0.02, (n, 3))
        case "range_finder":
            data = 5.0 + rng.random((n, 3))
        case _ if kind.endswith("camera"):
            data = _pictures(kind, n, rng)
        case _:
            data = 4.0 + 0.1 * p[:, 2] + 0.01 * rng.random(n)
    truth = data if data.dtype.kind in "bu" else data * 0.99
    return Measurement(data, truth, None, extras)


def _pictures(kind: str, n: int, rng: np.random.Generator) -> NDArray[Any]:
    h, w = _PICTURE["height_px"], _PICTURE["width_px"]
    y, x = np.mgrid[0:h, 0:w]
    base = (x / w + 0.3 * y / h)[None] + 0.02 * np.arange(n)[:, None, None]
    match kind:
        case "camera":
            colour = np.stack([base, 0.6 * base, 1.2 - base], axis=-1) * 120.0
            colour[:, 5:11, 20:33] += 70.0 * (1 + np.arange(n)[:, None, None, None] % 5) / 5
            return np.clip(colour, 0, 255).astype(np.uint8)
        case "semantic_camera" | "instance_camera":
            made = (6 * base).astype(np.int64) % 7
            return made.astype(np.uint8 if kind == "semantic_camera" else np.uint32)
        case "normal_camera" | "optical_flow_camera":
            parts = np.stack([np.cos(5 * base), np.sin(3 * base), 0.3 - base], axis=-1)
            return (parts if kind == "normal_camera" else 4 * parts[..., :2]).astype(np.float32)
        case "event_camera":
            return rng.integers(-2, 3, (n, h, w)).astype(np.int16)
        case _:
            return (9.0 * base + rng.random((n, h, w))).astype(np.float32)


def readings(kind: str, config: Any, count: int = 3) -> list[Reading]:
    """Some readings of a sensor, 10 s apart from the beginning on."""
    moved = tuple(v[:: round(10e9 / DT_NS)][:count] for v in motion(10.0 * count, apart=0.3))
    m = measured(kind, config, moved)
    one = np.ones(1, bool)
    tables = {"azimuth": np.asarray(config.azimuths)} if kind == "imaging_sonar" else {}
    if kind == "imaging_sonar":
        edges = np.linspace(config.range_min_m, config.range_max_m, config.bins + 1)
        tables["range"] = 0.5 * (edges[1:] + edges[:-1])
    if kind == "multibeam":
        tables["angle"] = np.asarray(config.angles)
    m = Measurement(m.data, m.truth, None, m.extras, tables)
    return [m.reading(slice(i, i + 1), one, int(moved[0][i]), f"auv0/{kind}", kind) for i in range(count)]


def scenario(kinds: tuple[str, ...] = tuple(KEYS)) -> tuple[dict[str, Any], dict[str, dict[str, SensorConfig]]]:
    """A scenario of three vehicles and its sensors by agent: all kinds on the first, a few on the others."""
    every = configs()
    sensors = {"auv0": {k: every[k] for k in kinds}} | {a: {k: every[k] for k in own} for a, own in OWNERS.items()}
    said = {**SCENARIO, "agents": {name: {**agent} for name, agent in SCENARIO["agents"].items()}}
    for agent, own in sensors.items():
        said["agents"][agent]["sensors"] = {k: c.model_dump(mode="json") for k, c in own.items()}
    return said, sensors


def record(file: Path, kinds: tuple[str, ...] = tuple(KEYS)) -> Path:
    """Write the mission as a recording: three vehicles, a mover, what navigation knows, a plan."""
    said, sensors = scenario(kinds)
    agents = list(sensors)
    with Recorder(file, yaml.safe_dump(said), 7, sensors, None, ORIGIN, DT_NS) as r:
        r.add_navigation("auv0", "ekf")
        moved = {agent: motion(SECONDS, apart=0.9 * i) for i, agent in enumerate(agents)}
        r.add_plan("auv0", moved["auv0"][1][[0, 200, 420, -1]])
        r.add_mover("seal one", {"mover": "seal one", "body": "fish", "label": "animal", "label_number": "9"})
        r.begin()
        for agent, own in sensors.items():
            for kind, config in own.items():
                due = moved[agent][0] % round(1e9 / config.rate_hz) == 0
                if kind == "gps":
                    due &= (moved[agent][0] < 3e9) | (moved[agent][0] > 31e9)
                if kind == "dvl":
                    due &= (moved[agent][0] < 11e9) | (moved[agent][0] > 15e9)
                rows = tuple(v[due] for v in moved[agent])
                r.write_block(agent, kind, rows[0], measured(kind, config, rows), n=1)
            t_ns, *rest = moved[agent]
            r.write_truth_block(agent, t_ns[::2], *(v[::2, None] for v in rest))
        t_ns, p, q, v, w = moved["auv0"]
        off = p + np.stack([0.02 * t_ns * 1e-9, -0.5 + 0 * t_ns, 0.1 * np.sin(t_ns * 1e-9)], axis=-1)
        r.write_navigation_block("auv0", t_ns[::4], *(a[::4, None] for a in (off, q, v, w)))
        r.write_mover_block("seal one", t_ns[::4], *(a[::4] for a in (p[::-1] + np.array([2.0, 5.0, -1.0]), q, v, w)))
    return file
