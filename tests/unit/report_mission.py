"""A made-up mission for tests of the report: a vehicle that sails a rounded square over a known seabed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from pelagos.config import registry
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.geomagnetism import earth_field
from pelagos.math.so3 import euler_np, rotate_np
from pelagos.sensors.sensor import Measurement, SensorConfig
from pelagos.sim.record import Recorder

ORIGIN = GeoOrigin(45.0, 12.5)
DT_NS = 5_000_000
ALL = ("imu", "dvl", "depth", "gps", "magnetometer", "altimeter", "multibeam", "imaging_sonar", "camera")
_SMALL: dict[str, dict[str, Any]] = {
    "multibeam": {"beams": 32}, "imaging_sonar": {"beams": 32, "bins": 64}, "camera": {"width_px": 64, "height_px": 48},
}  # fmt: skip


@dataclass(frozen=True)
class Seabed:
    """Stands for a world: a slope with waves."""

    name: str = "slope"

    @property
    def bounds(self) -> NDArray[np.float64]:
        return np.array([[-200.0, -200.0, -30.0], [200.0, 200.0, -10.0]])

    def height(self, x: Any, y: Any) -> NDArray[np.float64]:
        return np.asarray(-15.0 + 0.02 * np.asarray(x) + np.sin(np.asarray(y) / 9.0))

    def cast(self, origins: Any, directions: Any, max_range: float = 100.0) -> Any:
        z = self.height(origins[:, 0], origins[:, 1])
        return SimpleNamespace(t=origins[:, 2] - z, position=np.stack([origins[:, 0], origins[:, 1], z], axis=-1))


def path(seconds: float) -> tuple[NDArray[np.float64], ...]:
    """Time at 200 Hz, position NWU, attitude, velocity FLU, rates FLU, acceleration in the body, exactly consistent."""
    t = np.arange(0, seconds, DT_NS * 1e-9)
    turn = 2 * np.pi / 80.0 * np.sin(2 * np.pi * t / 40.0) ** 2  # yaw rate [rad/s]
    yaw = np.concatenate([[0.0], np.cumsum(0.5 * (turn[1:] + turn[:-1]) * np.diff(t))])
    speed = np.full_like(t, 1.5)
    v = np.stack([speed * np.cos(yaw), speed * np.sin(yaw), -0.05 * np.cos(t / 20.0)], axis=-1)
    step = 0.5 * (v[1:] + v[:-1]) * np.diff(t)[:, None]
    position = np.array([0.0, 0.0, -3.0]) + np.concatenate([np.zeros((1, 3)), np.cumsum(step, axis=0)])
    zero = np.zeros_like(t)
    attitude = np.stack([np.cos(yaw / 2), zero, zero, np.sin(yaw / 2)], axis=-1)
    body = np.stack([speed, zero, v[:, 2]], axis=-1)
    rates = np.stack([zero, zero, turn], axis=-1)
    acceleration = np.stack([zero, speed * turn, 0.05 / 20.0 * np.sin(t / 20.0)], axis=-1)
    return t, position, attitude, body, rates, acceleration


def configs(kinds: tuple[str, ...]) -> dict[str, SensorConfig]:
    found = {}
    for kind in kinds:
        model = registry.find("sensor", kind).config
        found[kind] = model.model_validate({"type": kind, **_SMALL.get(kind, {})})
    return found


def record(file: Path, *, kinds: tuple[str, ...] = ALL, seconds: float = 60.0, noise: float = 0.0) -> Path:
    """Write the mission as a recording; `noise` scales errors of the navigation sensors and soundings."""
    t, position, attitude, velocity, rates, acceleration = path(seconds)
    sensors: dict[str, Any] = configs(kinds)
    scenario = {
        "name": "made-up mission", "description": "For tests.",
        "agents": {"auv0": {"sensors": {k: c.model_dump(mode="json") for k, c in sensors.items()}}},
    }  # fmt: skip
    rng = np.random.Generator(np.random.PCG64(1))
    with Recorder(file, yaml.safe_dump(scenario), 7, {"auv0": sensors}, None, (45.0, 12.5), DT_NS) as r:
        for kind, config in sensors.items():
            every = round(1e9 / DT_NS / config.rate_hz)
            due = np.arange(0, len(t), every)
            due = due[due < 400] if kind == "gps" else due  # dives after two seconds
            m = _sense(
                kind, config, position[due], attitude[due], velocity[due], rates[due], acceleration[due], rng, noise
            )
            r.write_block("auv0", kind, due * DT_NS, m, n=1)
        every = slice(None, None, 4)
        motion = (position, attitude, velocity, rates)
        r.write_truth_block("auv0", np.arange(len(t))[every] * DT_NS, *(a[every, None] for a in motion))
    return file


def _sense(
    kind: str, config: Any, p: NDArray[Any], q: NDArray[Any], v: NDArray[Any], w: NDArray[Any], a: NDArray[Any],
    rng: Any, noise: float,
) -> Measurement:  # fmt: skip
    k = len(p)
    world = Seabed()
    height = p[:, 2] - world.height(p[:, 0], p[:, 1])
    inverse = q * np.array([1.0, -1.0, -1.0, -1.0])
    extras: dict[str, Any] = {}
    if kind == "imu":
        gravity = rotate_np(inverse, np.broadcast_to([0.0, 0.0, 9.81], (k, 3)))
        data = np.concatenate([a + gravity, w], axis=1)
    elif kind == "dvl":
        data = v + noise * 0.01 * rng.standard_normal((k, 3))
        extras = {
            "sigma": np.full((k, 4), 0.01), "beam_valid": np.ones((k, 4), bool), "altitude": height,
            "ranges": np.repeat(height[:, None], 4, axis=1) / np.cos(np.radians(30)), "beam_velocity": np.zeros((k, 4)),
        }  # fmt: skip
    elif kind == "depth":
        data = -p[:, 2] + noise * 0.02 * rng.standard_normal(k)
    elif kind == "gps":
        data = ORIGIN.to_geodetic(p)
    elif kind == "magnetometer":
        data = rotate_np(inverse, np.broadcast_to(earth_field(45.0, 12.5), (k, 3)))
    elif kind == "altimeter":
        data = height
    elif kind == "multibeam":
        data = _ranges(config, p, q, world) + noise * 0.02 * rng.standard_normal((k, config.beams))
        extras["backscatter"] = np.full((k, config.beams), -20.0, dtype=np.float32)
    elif kind == "imaging_sonar":
        data = rng.uniform(0.2, 0.6, (k, config.beams, config.bins)).astype(np.float32)
    else:
        data = np.full((k, config.height_px, config.width_px, 3), 90, dtype=np.uint8)
        data[:, :20, :20] = 180
    return Measurement(data, data, None, extras)


def _ranges(config: Any, p: NDArray[Any], q: NDArray[Any], world: Seabed) -> NDArray[np.float64]:
    """Ranges of the beams to the seabed, by Newton's method on the height."""
    angle = np.asarray(config.angles)
    direction = np.stack([0 * angle, np.sin(angle), -np.cos(angle)], axis=-1)
    d = rotate_np(q[:, None, :], direction[None])
    t = np.full(d.shape[:2], 10.0)
    for _ in range(60):
        at = p[:, None, :] + t[..., None] * d
        t = t + 0.8 * (at[..., 2] - world.height(at[..., 0], at[..., 1])) / np.cos(angle)
    return t


def heading(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Yaw in NWU [rad]."""
    return euler_np(q)[..., 2]
