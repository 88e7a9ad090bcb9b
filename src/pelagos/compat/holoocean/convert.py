"""A HoloOcean scenario as a native one in YAML, with comments for what has no counterpart."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml

from pelagos.compat.holoocean.definitions import definitions
from pelagos.compat.holoocean.environments import HoloOceanEnvironment
from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.native_scenario import native_scenario, placed
from pelagos.compat.holoocean.settings import settings
from pelagos.config.loader import load_scenario
from pelagos.errors import InputError

_STATE: Final = {
    "LocationSensor": "pose", "RotationSensor": "pose", "OrientationSensor": "pose", "PoseSensor": "pose",
    "DynamicsSensor": "pose", "VelocitySensor": "velocity", "DepthSensor": "depth", "GPSSensor": "gps",
    "MagnetometerSensor": "magnetometer",
}  # fmt: skip
"""Native sensors of those that the interface reads from the true state."""


class _Unbuilt(HoloOceanEnvironment):
    """Agents and sensors of a scenario, without a simulation."""

    def _reset(self, *, read: bool) -> dict[str, Any]:
        wanted, _ = definitions(self)
        for one in wanted:
            self._enter(one)
        return {}


def converted(path: Path) -> str:
    """The native scenario of a file, as text.

    Raises:
        InputError: the file cannot be read, is no scenario, or one that cannot be.
    """
    try:
        scenario = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(scenario, dict):
            raise InputError(f"{path}: a scenario is a mapping, not a {type(scenario).__name__}")
        if "ticks_per_sec" not in scenario:
            scenario["ticks_per_sec"] = 30
        return _text(scenario, path.name)
    except (OSError, json.JSONDecodeError) as error:
        raise InputError(f"{path}: {error}") from error
    except KeyError as error:
        raise InputError(f"{path}: the key {error} is missing, or what it says is not there") from error
    except (HoloOceanException, ValueError) as error:
        raise InputError(f"{path}: {error}") from error


def _text(scenario: dict[str, Any], name: str) -> str:
    notes: list[str] = []
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        env = _Unbuilt(scenario=scenario, seed=settings().seed or 0)
        native = native_scenario(env, env.agents.values())
        for agent in env.agents.values():
            keys = native["agents"][env.native_name(agent.name)]
            keys["start"].pop("anywhere")
            for sensor in agent.sensors.values():
                notes += _complete(env, keys["sensors"], sensor)
        load_scenario(native)
    notes = [str(w.message) for w in said] + notes
    head = [f"# From HoloOcean's {name}, by `pelagos holoocean --convert`."]
    if notes:
        head += ["# Without a counterpart, or otherwise:", *(f"# * {note}" for note in dict.fromkeys(notes))]
    body: str = yaml.safe_dump(_plain(native), sort_keys=False, width=120)
    return "\n".join(head) + "\n" + body


def _complete(env: HoloOceanEnvironment, sensors: dict[str, Any], sensor: Any) -> list[str]:
    """Add the native sensor of one that is read from the state, and native noise; what is to be said about it."""
    where, name, config = f"{sensor.agent_name}.{sensor.name}", identifier(sensor.name), sensor.config
    rate = env._ticks_per_sec / sensor.tick_every
    notes = [f"{where}: {k} is not carried over" for k in config if k.endswith("Cov")]
    if name in sensors:
        notes += _noise(where, sensors[name], sensor, rate)
        return notes
    kind = _STATE.get(sensor.sensor_type)
    if kind is None:
        return [*notes, f"{where}: {sensor.sensor_type} has no native sensor of its kind"]
    sensors[name] = {"type": kind, **placed(sensor), "rate_hz": rate}
    sigma = float(np.max(config.get("Sigma", 0.0)))
    if kind == "gps":
        sensors[name] |= {"horizontal_std_m": 0.0, "vertical_std_m": 0.0, "noise_density": sigma / rate**0.5}
        notes.append(f"{where}: latitude and longitude instead of metres, and at the surface only")
    elif kind == "magnetometer":
        notes.append(f"{where}: the Earth's field instead of MagneticVector")
    elif kind == "depth":
        notes.append(f"{where}: depth by pressure, positive down, with its own noise instead of Sigma")
    elif sigma:
        notes.append(f"{where}: Sigma is not carried over; the native sensor is without noise")
    return notes


def _noise(where: str, keys: dict[str, Any], sensor: Any, rate: float) -> list[str]:
    """HoloOcean's standard deviations as native densities."""
    config, notes = sensor.config, []
    if keys["type"] == "imu":
        for name, triad in (("Accel", "accelerometer"), ("AngVel", "gyroscope")):
            keys[f"{triad}_noise_density"] = float(np.max(config.get(f"{name}Sigma", 0.0))) / rate**0.5
            walk = float(np.max(config.get(f"{name}BiasSigma", 0.0)))
            keys[f"{triad}_random_walk"] = walk * sensor.env._ticks_per_sec**0.5
    if keys["type"] == "range_finder" and sensor.sensor_type == "DVLSensor":
        turn = keys["orientation_deg"]
        beams = float(config.get("Elevation", 22.5))
        noise = float(np.max(config.get("VelSigma", 0.0)))
        keys.clear()
        keys |= {
            "type": "dvl", "rate_hz": rate, "position_m": [float(v) for v in sensor.offset], "orientation_deg": turn,
            "beam_tilt_deg": beams, "beam_azimuth_deg": [0.0, 90.0, 180.0, -90.0],
            "range_max_m": float(config.get("MaxRange", 20.0)) * float(np.cos(np.radians(beams))), "noise_mps": noise,
            "noise_relative": 0.0,
        }  # fmt: skip
        notes.append(f"{where}: a DVL that loses the bottom beyond its range")
    return notes


def _plain(value: Any) -> Any:
    """Without tuples and NumPy."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value
