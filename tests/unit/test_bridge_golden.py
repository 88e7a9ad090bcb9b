"""Every field of every sensor's messages, decoded by another package (mcap_ros2), against the sensor's own numbers.

All numbers differ from one another, from zero and from their negatives, so a swapped, negated or forgotten field is
seen. `EXPECTED` names every leaf of every message: a field that nobody expects fails too.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from mcap_ros2._dynamic import generate_dynamic

from pelagos.config import registry
from pelagos.math.so3 import rotate_np
from pelagos.messages.encoders import ENCODERS, encoder
from pelagos.messages.encoding import Site
from pelagos.messages.motion import TruthEncoder, static_message, static_transform
from pelagos.messages.store import schema
from pelagos.sensors.sensor import Reading

T_NS = 12_345_678_901
SITE = Site("auv0/here", 45.0, 12.5)
DISTORTION = (0.01, -0.02, 0.003, -0.004, 0.005)
CONFIG: dict[str, dict[str, Any]] = {
    "tracer": {"tracer": "dye"},
    "multibeam": {"beams": 5, "frequency_hz": 321e3},
    "imaging_sonar": {"beams": 4, "bins": 8, "range_min_m": 1.5, "range_max_m": 25.5, "iq": True},
    "profiling_sonar": {"beams": 4, "bins": 8, "range_min_m": 1.5, "range_max_m": 25.5},
    "sidescan": {"bins": 8, "range_min_m": 1.5, "range_max_m": 25.5, "iq": True, "depression_deg": 25},
    "singlebeam": {"bins": 8, "range_min_m": 1.5, "range_max_m": 25.5, "iq": True},
    "mechanical_scanning_sonar": {"bins": 8, "range_min_m": 1.5, "range_max_m": 25.5, "iq": True},
    **{
        kind: {"width_px": 22, "height_px": 16, "distortion": DISTORTION}
        for kind in ("camera", "depth_camera", "semantic_camera", "instance_camera", "normal_camera",
                     "optical_flow_camera", "thermal_camera", "event_camera")
    },
}  # fmt: skip


def numbers(*shape: int, seed: int = 0, lowest: float = 0.5, highest: float = 9.5) -> np.ndarray:
    """Different numbers of both signs."""
    rng = np.random.Generator(np.random.PCG64(seed + 7))
    sign = np.where(rng.uniform(size=shape) > 0.5, 1.0, -1.0)
    return sign * rng.uniform(lowest, highest, shape)


def unit_quaternion() -> np.ndarray:
    q = np.array([0.4, -0.2, 0.7, 0.5])
    return q / np.linalg.norm(q)


def reading_of(kind: str, config: Any) -> Reading:
    extras: dict[str, Any] = {}
    if kind == "pose":
        data: Any = np.concatenate([numbers(3), unit_quaternion()])[None]
    elif kind == "gps":
        data = np.array([[44.5, 12.25, -3.5]])
    elif kind in ("depth", "altimeter", "sound_velocity", "fluorometer", "oxygen", "turbidity", "tracer"):
        data = np.array([7.25])
    elif kind == "collision":
        data, extras = np.array([True]), {"force": numbers(1, 3, seed=1), "moment": numbers(1, 3, seed=2)}
    elif kind == "dvl":
        data = numbers(1, 3)
        extras = {
            "sigma": np.array([[0.001, 0.002, 0.003, 0.005]]), "beam_valid": np.array([[True, True, False, True]]),
            "altitude": np.array([11.5]), "ranges": np.array([[12.5, 13.25, 14.75, 15.5]]),
            "beam_velocity": numbers(1, 4, seed=3),
        }  # fmt: skip
    elif kind in ("ctd", "current_meter"):
        data = numbers(1, 3)
        extras = {"salinity": np.array([35.5]), "sound_speed": np.array([1501.5])}
    elif kind == "multibeam":
        data = np.array([[5.5, 6.25, np.nan, 8.75, 9.5]], dtype=np.float32)
        extras = {"backscatter": -numbers(1, 5, seed=4, lowest=10, highest=40).astype(np.float32)}
    elif kind in MODEMS:
        data, extras = numbers(1, 3), {"fates": ((Fate("usv0", 1.25, math.inf),),)}
    elif kind in ("imaging_sonar", "profiling_sonar"):
        data = (np.arange(32, dtype=np.float32).reshape(1, 4, 8) + 1) / 40
        extras = {"iq": (numbers(1, 4, 8, seed=5) + 1j * numbers(1, 4, 8, seed=6)).astype(np.complex64)}
    elif kind in TRACES:
        beams = TRACES[kind]
        data = (np.arange(16, dtype=np.float32).reshape(1, 2, 8)[:, :beams] + 1) / 20
        iq = (numbers(1, beams, 8, seed=5) + 1j * numbers(1, beams, 8, seed=6)).astype(np.complex64)
        extras = {"altitude": np.array([7.25]), "angle": np.array([-0.75]), "iq": iq}
        if beams == 1:
            data, extras["iq"] = data[:, 0], iq[:, 0]
    elif kind in ("lidar", "semantic_lidar"):
        data = numbers(1, 2, 3, 4).astype(np.float32)
        if kind == "semantic_lidar":
            extras = {"label": np.arange(6, dtype=np.uint8).reshape(1, 2, 3) + 3,
                      "instance": np.arange(6, dtype=np.uint32).reshape(1, 2, 3) + 900}  # fmt: skip
    elif kind in PIXELS:
        shape, dtype = PIXELS[kind]
        data = (numbers(1, 16, 22, *shape, lowest=1, highest=120)).astype(dtype)
    else:
        data = numbers(1, {"imu": 6}.get(kind, 3))
    return Reading(data, data, T_NS, "auv0/here", np.ones(1, bool), extras)


TRACES = {"sidescan": 2, "singlebeam": 1, "mechanical_scanning_sonar": 1}
"""Beams."""
PIXELS: dict[str, tuple[tuple[int, ...], str]] = {
    "camera": ((3,), "u1"), "depth_camera": ((), "f4"), "semantic_camera": ((), "u1"),
    "instance_camera": ((), "u4"), "normal_camera": ((3,), "f4"), "optical_flow_camera": ((2,), "f4"),
    "thermal_camera": ((), "f4"), "event_camera": ((), "i2"),
}  # fmt: skip
_DECODERS: dict[str, Callable[[bytes], Any]] = {}


def decode(type_name: str, raw: bytes) -> Any:
    """By mcap_ros2, which shares nothing with the encoder but the text of the definition."""
    if type_name not in _DECODERS:
        _DECODERS.update(generate_dynamic(type_name, schema(type_name).decode()))
    return _DECODERS[type_name](raw)


def leaves(value: Any, path: str = "") -> dict[str, Any]:
    if hasattr(value, "__slots__"):
        found: dict[str, Any] = {}
        for name in value.__slots__:
            if not name.isupper() and not name.startswith("_"):
                found |= leaves(getattr(value, name), f"{path}.{name}" if path else name)
        return found
    if isinstance(value, list | tuple) and value and hasattr(value[0], "__slots__"):
        found = {}
        for i, item in enumerate(value):
            found |= leaves(item, f"{path}[{i}]")
        return found
    return {path: value}


def stamped(frame: str) -> dict[str, Any]:
    return {"header.stamp.sec": 12, "header.stamp.nanosec": 345_678_901, "header.frame_id": frame}


def xyz(path: str, values: Any) -> dict[str, Any]:
    return {f"{path}.{axis}": float(v) for axis, v in zip("xyz", values, strict=True)}


def diagonal(*values: float) -> list[float]:
    return np.diag(values).ravel().tolist()


def east_north_up(v: Any) -> list[float]:
    """North, west, up -> east, north, up: east is minus west."""
    return [-v[1], v[0], v[2]]


def forward_right_down(v: Any) -> list[float]:
    return [v[0], -v[1], -v[2]]


def imu(c: Any, r: Reading) -> list[dict[str, Any]]:
    rate, force = r.data[0, 3:], r.data[0, :3]
    return [{
        **stamped("auv0/here"), **xyz("angular_velocity", rate), **xyz("linear_acceleration", force),
        "orientation.x": 0, "orientation.y": 0, "orientation.z": 0, "orientation.w": 1,
        "orientation_covariance": [-1.0, *[0.0] * 8],
        "angular_velocity_covariance": diagonal(*[c.gyroscope_noise_density**2 * c.rate_hz] * 3),
        "linear_acceleration_covariance": diagonal(*[c.accelerometer_noise_density**2 * c.rate_hz] * 3),
    }]  # fmt: skip


def magnetometer(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{
        **stamped("auv0/here"), **xyz("magnetic_field", r.data[0]),
        "magnetic_field_covariance": diagonal(*[c.noise_density**2 * c.rate_hz + c.bias_std_t**2] * 3),
    }]  # fmt: skip


def gps(c: Any, r: Reading) -> list[dict[str, Any]]:
    white = c.noise_density**2 * c.rate_hz
    return [{
        **stamped("auv0/here"), "status.status": 0, "status.service": 1, "latitude": 44.5, "longitude": 12.25,
        "altitude": -3.5, "position_covariance_type": 2,
        "position_covariance": diagonal(
            *[c.horizontal_std_m**2 + white] * 2, c.vertical_std_m**2 + 1.5**2 * white),
    }]  # fmt: skip


def depth(c: Any, r: Reading) -> list[dict[str, Any]]:
    variance = c.noise_density**2 * c.rate_hz + c.bias_std_m**2
    return [{
        **stamped("map"), **xyz("pose.pose.position", (0, 0, -7.25)), **xyz("pose.pose.orientation", (0, 0, 0)),
        "pose.pose.orientation.w": 1, "pose.covariance": diagonal(1e6, 1e6, variance, 1e6, 1e6, 1e6),
    }]  # fmt: skip


def attitude_of(w: float, x: float, y: float, z: float) -> np.ndarray:
    """The body's axes in the frame of the quaternion: columns forward, left, up."""
    return rotate_np(np.tile(np.array([w, x, y, z]), (3, 1)), np.eye(3)).T


def pose(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{
        **stamped("map"), **xyz("pose.position", east_north_up(r.data[0, :3])), "pose.orientation": r.data[0, 3:],
    }]  # fmt: skip


def velocity(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{**stamped("map"), **xyz("twist.linear", east_north_up(r.data[0])), **xyz("twist.angular", (0, 0, 0))}]


def collision(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{
        **stamped("auv0/base_link"), **xyz("wrench.force", r.extras["force"][0]),
        **xyz("wrench.torque", r.extras["moment"][0]),
    }]  # fmt: skip


def dvl(c: Any, r: Reading) -> list[dict[str, Any]]:
    beams, e = np.array(c.beams), r.extras
    variance = np.diag(np.linalg.inv(beams.T @ beams)) * (e["sigma"][0] ** 2).mean()
    v = forward_right_down(r.data[0])
    full: dict[str, Any] = {
        **stamped("auv0/here_frd"), "velocity_mode": 1, "dvl_type": 0, **xyz("velocity", v),
        "velocity_covar": diagonal(*variance), "altitude": 11.5, "course_gnd": math.atan2(v[1], v[0]),
        "speed_gnd": math.hypot(v[0], v[1]), "num_good_beams": 3, "sound_speed": float(c.sound_speed_mps or 0),
        "beam_ranges_valid": True, "beam_velocities_valid": True, "range": e["ranges"][0],
        "range_covar": [-1.0] * 4, "beam_quality": [1, 1, 0, 1], "beam_velocity": e["beam_velocity"][0],
        "beam_velocity_covar": e["sigma"][0] ** 2,
    }  # fmt: skip
    for i, beam in enumerate(beams):
        full |= xyz(f"beam_unit_vec[{i}]", forward_right_down(beam))
    return [{
        **stamped("auv0/here"), **xyz("twist.twist.linear", r.data[0]), **xyz("twist.twist.angular", (0, 0, 0)),
        "twist.covariance": diagonal(*variance, 1e6, 1e6, 1e6),
    }, full]  # fmt: skip


def altimeter(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{
        **stamped("auv0/here"), "radiation_type": 0, "field_of_view": math.radians(c.beamwidth_deg),
        "min_range": c.range_min_m, "max_range": c.range_max_m, "range": 7.25,
        "variance": c.noise_m**2 + (c.noise_relative * 7.25) ** 2,
    }]  # fmt: skip


def info(c: Any) -> dict[str, Any]:
    """Pixel centres are whole numbers, as for OpenCV: the axis of 22 columns meets 10.5."""
    width, height = 22, 16
    focal = 0.5 * width / math.tan(math.radians(c.horizontal_fov_deg) / 2)
    return {
        **stamped("auv0/here_optical"), "height": height, "width": width, "distortion_model": "plumb_bob",
        "d": DISTORTION,
        "k": [focal, 0, (width - 1) / 2, 0, focal, (height - 1) / 2, 0, 0, 1], "r": np.eye(3).ravel(),
        "p": [focal, 0, (width - 1) / 2, 0, 0, focal, (height - 1) / 2, 0, 0, 0, 1, 0], "binning_x": 0, "binning_y": 0,
        "roi.x_offset": 0, "roi.y_offset": 0, "roi.height": 0, "roi.width": 0, "roi.do_rectify": False,
    }  # fmt: skip


def camera(c: Any, r: Reading) -> list[dict[str, Any]]:
    return [{**stamped("auv0/here_optical"), "format": "jpeg", "data": ANY}, info(c)]


def image(encoding: str) -> Callable[[Any, Reading], list[dict[str, Any]]]:
    def expected(c: Any, r: Reading) -> list[dict[str, Any]]:
        picture = r.data[0]
        return [{
            **stamped("auv0/here_optical"), "height": 16, "width": 22, "encoding": encoding, "is_bigendian": 0,
            "step": picture[0].nbytes, "data": picture.tobytes(),
        }, info(c)]  # fmt: skip

    return expected


def cloud(frame: str, columns: Mapping[str, tuple[int, Any]], size: int) -> dict[str, Any]:
    """PointCloud2 with fields one behind the other; datatypes of sensor_msgs/PointField."""
    sizes = {4: 2, 6: 4, 7: 4}
    found: dict[str, Any] = {
        **stamped(frame), "height": 1, "is_bigendian": False, "is_dense": False, "point_step": size,
    }  # fmt: skip
    offset = 0
    for i, (name, (kind, values)) in enumerate(columns.items()):
        found |= {f"fields[{i}].name": name, f"fields[{i}].offset": offset, f"fields[{i}].datatype": kind,
                  f"fields[{i}].count": 1}  # fmt: skip
        offset += sizes[kind]
        found["width"], found["row_step"] = len(values), size * len(values)
    return found | {"data": ("points", columns)}


def lidar(c: Any, r: Reading) -> list[dict[str, Any]]:
    points = r.data[0].reshape(-1, 4)
    fourth = "cosine" if "label" in r.extras else "intensity"
    columns: dict[str, tuple[int, Any]] = {name: (7, points[:, i]) for i, name in enumerate(("x", "y", "z", fourth))}
    columns["ring"] = (4, [0, 0, 0, 1, 1, 1])
    for name in ("label", "instance"):
        if name in r.extras:
            columns[name] = (6, r.extras[name].ravel())
    return [cloud("auv0/here", columns, 18 + 4 * (len(columns) - 5))]


def multibeam(c: Any, r: Reading) -> list[dict[str, Any]]:
    distance, angle = r.data[0].astype(float), np.array(c.angles)
    y, z = distance * np.sin(angle), -distance * np.cos(angle)  # port is positive, down is negative
    strength = r.extras["backscatter"][0]
    columns = {"x": (7, 0 * distance), "y": (7, y), "z": (7, z), "intensity": (7, strength)}
    ranges: dict[str, Any] = {
        **stamped("auv0/here_frd"), "ping_info.frequency": 321e3, "ping_info.sound_speed": c.sound_speed_mps or 0,
        "ping_info.tx_beamwidths": [math.radians(c.beamwidth_along_deg)],
        "ping_info.rx_beamwidths": [math.radians(c.beamwidth_across_deg)],
        "transmit_delays": [0] * 5, "intensities": strength, "ranges": distance,
    }  # fmt: skip
    for i, a in enumerate(angle):
        ranges |= {f"flags[{i}].flag": int(i == 2), **xyz(f"beam_unit_vec[{i}]", (0, -math.sin(a), math.cos(a)))}
    return [cloud("auv0/here", columns, 16), ranges]


def imaging(c: Any, r: Reading) -> list[dict[str, Any]]:
    azimuth = np.array(c.azimuths)
    ping = {
        "ping_info.frequency": c.frequency_hz, "ping_info.sound_speed": 0,
        "ping_info.tx_beamwidths": [math.radians(c.vertical_beamwidth_deg)],
        "ping_info.rx_beamwidths": [math.radians(c.beamwidth_deg)],
    }  # fmt: skip
    level = np.floor(r.data[0] * 255 + 0.5).astype(np.uint8) if c.scale == "unit" else None
    rows = ANY if level is None else bytes(level[b, k] for k in range(8) for b in range(4))
    projected: dict[str, Any] = {
        **stamped("auv0/here_projected"), **ping, "ranges": 1.5 + 3.0 * (np.arange(8) + 0.5),
        "image.is_bigendian": False, "image.dtype": 0, "image.beam_count": 4, "image.data": rows,
    }  # fmt: skip
    for i, a in enumerate(azimuth):  # z ahead, x up, y to starboard; azimuths are positive to port
        projected |= xyz(f"beam_directions[{i}]", (0, -math.sin(a), math.cos(a)))
    found = [projected, {**stamped("auv0/here"), "format": "jpeg", "data": ANY}]
    if c.iq:
        found.append({
            **stamped("auv0/here_projected"), **ping, "sample_rate": 1500 / (2 * 3.0), "samples_per_beam": 8,
            "sample0": round(1.5 / 3), "tx_delays": [0] * 4, "tx_angles": [0] * 4, "rx_angles": -azimuth,
            "image.is_bigendian": False, "image.dtype": 8, "image.beam_count": 4,
            "image.data": r.extras["iq"][0].tobytes(),
        })  # fmt: skip
    return found


def trace(frame: str, beam: list[list[float]], starboard: list[float], widths: tuple[str, str]) -> Any:
    """A ping: directions of its beams in `frame`, angles to starboard, keys of the widths across and in their plane."""

    def expected(c: Any, r: Reading) -> list[dict[str, Any]]:
        count = len(beam)
        level = np.floor(r.data[0].reshape(count, 8) * 255 + 0.5).astype(np.uint8)
        ping = {
            **stamped(f"auv0/here_{frame}"), "ping_info.frequency": c.frequency_hz, "ping_info.sound_speed": 0,
            "ping_info.tx_beamwidths": [math.radians(getattr(c, widths[0]))],
            "ping_info.rx_beamwidths": [math.radians(getattr(c, widths[1]))],
            "image.is_bigendian": False, "image.beam_count": count,
        }  # fmt: skip
        image: dict[str, Any] = {
            **ping, "ranges": 1.5 + 3.0 * (np.arange(8) + 0.5), "image.dtype": 0,
            "image.data": bytes(level[b, k] for k in range(8) for b in range(count)),
        }  # fmt: skip
        for i, direction in enumerate(beam):
            image |= xyz(f"beam_directions[{i}]", direction)
        raw = {
            **ping, "sample_rate": 1500 / (2 * 3.0), "samples_per_beam": 8, "sample0": round(1.5 / 3),
            "tx_delays": [0] * count, "tx_angles": [0] * count, "rx_angles": starboard, "image.dtype": 8,
            "image.data": r.extras["iq"][0].tobytes(),
        }  # fmt: skip
        found = [image, raw]
        if count == 2:
            found.append({
                **stamped("auv0/here"), "radiation_type": 0, "field_of_view": math.radians(c.vertical_beamwidth_deg),
                "min_range": 1.5, "max_range": 25.5, "range": 7.25, "variance": 3.0**2 / 12,
            })  # fmt: skip
        return found

    return expected


_DOWN, _OUT = math.sin(math.radians(25)), math.cos(math.radians(25))  # 25 degrees below the horizon
sidescan = trace(
    "frd", [[0, -_OUT, _DOWN], [0, _OUT, _DOWN]], [-math.radians(65), math.radians(65)],
    ("beamwidth_deg", "vertical_beamwidth_deg"),
)  # fmt: skip
singlebeam = trace("frd", [[0, 0, 1]], [0], ("beamwidth_deg", "beamwidth_deg"))
scanning = trace(  # the head looks 0.75 rad to starboard: y of the frame
    "projected", [[0, math.sin(0.75), math.cos(0.75)]], [0.75], ("vertical_beamwidth_deg", "beamwidth_deg")
)


def variance_of(c: Any, density: str, bias: str) -> float:
    return float(getattr(c, density) ** 2 * c.rate_hz + getattr(c, bias) ** 2)


def ctd(c: Any, r: Reading) -> list[dict[str, Any]]:
    conductivity, temperature, pressure = r.data[0]
    frame = stamped("auv0/here")
    return [
        {**frame, "conductivity": conductivity, "temperature": temperature, "pressure": pressure, "salinity": 35.5,
         "sound_speed": 1501.5},
        {**frame, "temperature": temperature,
         "variance": variance_of(c, "temperature_noise_density", "temperature_bias_std")},
        {**frame, "fluid_pressure": 101_325 + 1e4 * pressure,
         "variance": 1e8 * variance_of(c, "pressure_noise_density", "pressure_bias_std")},
    ]  # fmt: skip


def water(quantity: str, unit: str) -> Callable[[Any, Reading], list[dict[str, Any]]]:
    def expected(c: Any, r: Reading) -> list[dict[str, Any]]:
        variance = variance_of(c, "noise_density", "bias_std") + c.drift_std**2
        return [
            {**stamped("auv0/here"), "quantity": quantity, "unit": unit, "value": 7.25, "variance": variance}
        ]  # fmt: skip

    return expected


def current_meter(c: Any, r: Reading) -> list[dict[str, Any]]:
    v = variance_of(c, "noise_density", "bias_std") + c.drift_std**2
    return [{
        **stamped("auv0/here"), **xyz("twist.twist.linear", r.data[0]), **xyz("twist.twist.angular", (0, 0, 0)),
        "twist.covariance": diagonal(v, v, v, 1e6, 1e6, 1e6),
    }]  # fmt: skip


@dataclass(frozen=True)
class Fate:
    """A packet as a modem's reading tells of it."""

    source: str
    delay_s: float
    range_m: float


MODEMS = ("modem", "usbl", "optical_modem", "radio", "ais")


def modem(c: Any, r: Reading) -> list[dict[str, Any]]:
    said = json.dumps([{"source": "usv0", "delay_s": 1.25, "range_m": None}])
    return [
        {"layout.dim[0].label": "axis0", "layout.dim[0].size": 3, "layout.dim[0].stride": 3, "layout.data_offset": 0,
         "data": r.data[0]},
        {"data": said},
    ]  # fmt: skip


ANY = object()
EXPECTED: dict[str, Callable[[Any, Reading], list[dict[str, Any]]]] = {
    "imu": imu, "magnetometer": magnetometer, "gps": gps, "depth": depth, "pose": pose, "velocity": velocity,
    "collision": collision, "dvl": dvl, "altimeter": altimeter, "camera": camera, "depth_camera": image("32FC1"),
    "semantic_camera": image("mono8"), "instance_camera": image("32SC1"), "normal_camera": image("32FC3"),
    "optical_flow_camera": image("32FC2"), "thermal_camera": image("32FC1"), "event_camera": image("16SC1"),
    "lidar": lidar, "semantic_lidar": lidar, "multibeam": multibeam, "imaging_sonar": imaging,
    "profiling_sonar": imaging, "sidescan": sidescan, "singlebeam": singlebeam, "mechanical_scanning_sonar": scanning,
    "ctd": ctd, "current_meter": current_meter,
    "sound_velocity": water("sound_speed", "m/s"), "fluorometer": water("chlorophyll", "mg/m^3"),
    "oxygen": water("oxygen", "umol/kg"), "turbidity": water("turbidity", "NTU"), "tracer": water("dye", ""),
    **dict.fromkeys(MODEMS, modem),
}  # fmt: skip


def compare(found: Any, expected: dict[str, Any], where: str) -> None:
    got = leaves(found)
    turned = expected.pop("pose.orientation", None)
    if turned is not None:  # as directions of the body's axes: forward, left, up in east, north, up
        q = [got.pop(f"pose.orientation.{axis}") for axis in "wxyz"]
        before = attitude_of(*turned)
        np.testing.assert_allclose(attitude_of(*q), [-before[1], before[0], before[2]], atol=1e-12)
    assert set(got) == set(expected), f"{where}: {set(got) ^ set(expected)}"
    for path, value in expected.items():
        if value is ANY:
            continue
        if isinstance(value, tuple) and value[0] == "points":
            check_points(got[path], value[1])
        elif isinstance(value, str | bytes | bool):
            given = bytes(got[path]) if isinstance(value, bytes) else got[path]
            assert given == value, f"{where}: {path}"
        else:
            np.testing.assert_allclose(np.asarray(got[path], float), np.asarray(value, float), rtol=2e-6, atol=1e-9,
                                       err_msg=f"{where}: {path}")  # fmt: skip


def check_points(raw: bytes, columns: Mapping[str, tuple[int, Any]]) -> None:
    kinds = {4: "<u2", 6: "<u4", 7: "<f4"}
    points = np.frombuffer(bytes(raw), dtype=[(name, kinds[kind]) for name, (kind, _) in columns.items()])
    for name, (_, values) in columns.items():
        np.testing.assert_allclose(points[name], np.asarray(values), rtol=2e-6, atol=1e-6, err_msg=name)


def test_every_encoder_is_expected() -> None:
    assert set(EXPECTED) == set(ENCODERS)


@pytest.mark.parametrize("kind", sorted(EXPECTED))
def test_every_field_says_what_the_sensor_measured(kind: str) -> None:
    config = registry.find("sensor", kind).config.model_validate({"type": kind, "rate_hz": 5, **CONFIG.get(kind, {})})
    reading = reading_of(kind, config)
    encoding = encoder(config, SITE)
    raw = encoding.encode(reading, 0)
    expected = EXPECTED[kind](config, reading)
    assert len(raw) == len(expected)
    for topic, message, fields in zip(encoding.topics, raw, expected, strict=True):
        assert message is not None
        compare(decode(topic.type, bytes(message)), fields, f"{kind}: {topic.suffix}")


def test_every_field_of_the_true_motion() -> None:
    position, attitude, velocity, spin = numbers(3), unit_quaternion(), numbers(3, seed=1), numbers(3, seed=2)
    odometry, transform = TruthEncoder("auv0/base_link").encode(T_NS, position, attitude, velocity, spin)
    found = decode("nav_msgs/msg/Odometry", bytes(odometry))
    compare(found.pose, {**xyz("pose.position", east_north_up(position)), "pose.orientation": attitude,
                         "covariance": [0.0] * 36}, "pose")  # fmt: skip
    compare(found.twist, {**xyz("twist.linear", velocity), **xyz("twist.angular", spin), "covariance": [0.0] * 36},
            "twist")  # fmt: skip
    assert (found.header.frame_id, found.child_frame_id) == ("map", "auv0/base_link")
    (moved,) = decode("tf2_msgs/msg/TFMessage", bytes(transform)).transforms
    np.testing.assert_allclose(
        [getattr(moved.transform.translation, a) for a in "xyz"], east_north_up(position), rtol=1e-12
    )
    same = [getattr(found.pose.pose.orientation, a) for a in "xyzw"]
    assert [getattr(moved.transform.rotation, a) for a in "xyzw"] == same
    assert (moved.header.stamp.sec, moved.header.stamp.nanosec) == (12, 345_678_901)


def test_a_mount_is_written_as_it_is_given() -> None:
    w, x, y, z = unit_quaternion()
    raw = static_message([static_transform("a", "b", position=(1.5, -2.5, 3.5), attitude=(w, x, y, z))])
    (found,) = decode("tf2_msgs/msg/TFMessage", raw).transforms
    assert (found.header.frame_id, found.child_frame_id) == ("a", "b")
    assert [getattr(found.transform.translation, a) for a in "xyz"] == [1.5, -2.5, 3.5]
    assert [getattr(found.transform.rotation, a) for a in "wxyz"] == [w, x, y, z]
