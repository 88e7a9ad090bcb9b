"""Messages of every sensor for numbers that all differ, of two copies, by several settings; true motion, plans, groups,
structures of LCM, forms in JSON, type hashes: as they were when somebody last looked at them."""

from __future__ import annotations

import io
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image
from test_bridge_golden import CONFIG, T_NS, numbers, reading_of
from test_bridge_wire import TYPES, filled

from known import EXACT, SINGLE, check, on_one_scale
from pelagos.bridges.dds_types import wire_type
from pelagos.bridges.rihs import type_hash
from pelagos.config import registry
from pelagos.math.geodesy import GeoOrigin
from pelagos.messages import lcm, motion
from pelagos.messages.encoders import ENCODERS, encoder
from pelagos.messages.encoding import Site
from pelagos.messages.group import GROUP, GroupTemplate, group_rows
from pelagos.messages.json_form import from_json, to_json
from pelagos.messages.store import deserialize, serialize
from pelagos.sensors.sensor import Reading

SITE = Site("auv0/here", -33.25, -151.5)
SMALL = {"width_px": 18, "height_px": 16}
NOISY = {"noise_density": 0.021, "bias_std": 0.37, "drift_std": 0.13, "rate_hz": 3.0}
RANGES = {"bins": 8, "range_min_m": 1.5, "range_max_m": 25.5, "rate_hz": 4.0}
OTHERWISE: dict[str, list[dict[str, Any]]] = {
    "imu": [{"accelerometer_noise_density": 0.031, "gyroscope_noise_density": 0.007, "rate_hz": 40.0}],
    "magnetometer": [{"noise_density": 2e-7, "rate_hz": 4.0}],
    "gps": [{"noise_density": 0.3, "horizontal_std_m": 1.7, "vertical_std_m": 2.9, "rate_hz": 4.0}],
    "depth": [{"noise_density": 0.03, "bias_std_m": 0.2, "rate_hz": 4.0}],
    "dvl": [{"beam_tilt_deg": 24.0, "sound_speed_mps": 1478.0}],
    "altimeter": [
        {"beamwidth_deg": 7.0, "range_min_m": 0.7, "range_max_m": 41.0, "noise_m": 0.03, "noise_relative": 0.02}
    ],
    "ctd": [
        {
            "temperature_noise_density": 0.02,
            "temperature_bias_std": 0.3,
            "pressure_noise_density": 0.05,
            "pressure_bias_std": 0.11,
            "rate_hz": 3.0,
        }
    ],
    **{kind: [NOISY] for kind in ("sound_velocity", "fluorometer", "oxygen", "turbidity", "current_meter")},
    "imaging_sonar": [
        {
            "beams": 4,
            **RANGES,
            "scale": "db",
            "floor_db": -25.0,
            "dynamic_range_db": 31.0,
            "beamwidth_deg": 2.3,
            "vertical_beamwidth_deg": 27.0,
            "frequency_hz": 321e3,
            "horizontal_aperture_deg": 7.0,
        },
        {"beams": 4, **RANGES, "scale": "linear", "floor_db": -9.0, "dynamic_range_db": 8.0},
    ],
    "sidescan": [{**RANGES, "scale": "db", "depression_deg": 35.0, "beamwidth_deg": 0.7}],
    "singlebeam": [{**RANGES, "scale": "linear", "beamwidth_deg": 11.0}],
    "mechanical_scanning_sonar": [{**RANGES, "scale": "unit", "beamwidth_deg": 3.3}],
    "multibeam": [
        {
            "beams": 5,
            "swath_deg": 97.0,
            "spacing": "equidistant",
            "sound_speed_mps": 1478.0,
            "beamwidth_across_deg": 2.1,
            "beamwidth_along_deg": 1.4,
        }
    ],
    "camera": [
        {**SMALL, "bits": 12},
        {**SMALL, "mosaic": "grbg"},
        {**SMALL, "mosaic": "rggb", "bits": 12},
        {**SMALL, "lens": "fisheye", "horizontal_fov_deg": 150.0, "distortion": [0.02, -0.01, 0.004, 0.003, 0.0]},
    ],
    "depth_camera": [{**SMALL, "image": True}],
}
CASES = [(kind, k) for kind in sorted(ENCODERS) for k in range(1 + len(OTHERWISE.get(kind, [])))]
_SHAPES = {"camera": {1: ((3,), "u2"), 2: ((), "u1"), 3: ((), "u2"), 4: ((3,), "u1")}, "depth_camera": {1: ((), "f4")}}


def config_of(kind: str, setting: int) -> Any:
    keys = {**CONFIG.get(kind, {})} if not setting else {**OTHERWISE[kind][setting - 1]}
    return registry.find("sensor", kind).config.model_validate({"type": kind, **keys})


def reading(kind: str, setting: int, config: Any) -> Reading:
    """As `test_bridge_golden` has it, or a picture of another kind; the second copy has other numbers."""
    one = reading_of(kind, config)
    if kind in _SHAPES and setting:
        shape, dtype = _SHAPES[kind][setting]
        most = 4000 if dtype == "u2" else 250
        picture = np.abs(numbers(1, 16, 18, *shape, lowest=1, highest=most)).astype(dtype)
        one = replace(one, data=picture, truth=picture)
        if kind == "depth_camera":
            one.data[0, 3, 4] = np.inf
            one.extras["image"] = np.abs(numbers(1, 16, 18, 3, lowest=1, highest=250)).astype("u1")
    if getattr(config, "scale", "") == "db":
        one = replace(one, data=one.data * -30.0)
    both = {
        name: np.concatenate([v, other(v)]) if isinstance(v, np.ndarray) else (*v, *v) for name, v in one.extras.items()
    }
    data = np.concatenate([one.data, other(one.data)])
    return Reading(data, data, one.t_ns, one.frame, np.array([True, True]), both)


def other(values: np.ndarray) -> np.ndarray:
    if values.dtype == bool:
        return ~values
    if values.ndim == 2 and values.shape[1] == 7:  # a pose
        return values[:, [1, 0, 2, 6, 3, 5, 4]]
    return (values / 2 if values.dtype.kind in "fc" else values // 2).astype(values.dtype)


def parts(type_name: str, raw: Any) -> tuple[dict[str, Any], Any]:
    """Fields of a message, and its picture's blocks where it is compressed."""
    message = deserialize(type_name, bytes(raw))
    if type_name == "sensor_msgs/msg/CompressedImage":
        picture = np.asarray(Image.open(io.BytesIO(bytes(message.data))), dtype=float)
        rows, columns = picture.shape[0] // 4, picture.shape[1] // 4
        blocks = picture[: 4 * rows, : 4 * columns].reshape(4, rows, 4, columns, -1).mean(axis=(1, 3))
        return {"header": message.header, "format": message.format, "shape": picture.shape}, blocks
    return message, None


@pytest.mark.parametrize(("kind", "setting"), CASES)
def test_messages_of_readings(kind: str, setting: int) -> None:
    config = config_of(kind, setting)
    encoding = encoder(config, SITE)
    said: dict[str, list[Any]] = {t.suffix: [t.type, encoding.frames] for t in encoding.topics}
    pictures: list[Any] = []
    for copy in (0, 1):
        raw = encoding.encode(reading(kind, setting, config), copy)
        for topic, data in zip(encoding.topics, raw, strict=True):
            if data is not None:
                message, picture = parts(topic.type, data)
                said[topic.suffix].append(message)
                pictures += [] if picture is None else [picture]
    case = f"{kind} {setting}" if setting else kind
    check("messages", case, {suffix: on_one_scale(parts) for suffix, parts in said.items()}, EXACT)
    if pictures:
        check("messages", f"{case}, pictures", {"blocks": pictures}, 10 * SINGLE)


def turned(w: float, x: float, y: float, z: float) -> np.ndarray:
    q = np.array([w, x, y, z])
    return q / np.linalg.norm(q)


def test_true_motion_plans_and_groups() -> None:
    places, ways = numbers(3, 3, highest=90.0), numbers(2, 3, 3, seed=4)
    attitudes = np.array([turned(0.4, -0.2, 0.7, 0.5), turned(-0.3, 0.6, 0.1, 0.8), turned(0.9, 0.1, -0.3, 0.2)])
    encode = motion.TruthEncoder("auv0/base_link")
    table = encode.numbers(places, attitudes, *ways)
    t_ns = T_NS + np.arange(3) * 333_000_000
    group = GroupTemplate("auv/imu", 3, ["angular_velocity.x:float64", "linear_acceleration.y:float64"])
    rows = group.rows(t_ns[:2], numbers(2, 3, 2, seed=9), np.array([[True, False, True], [False, True, True]]))
    back = group_rows([row.tobytes() for row in rows], 3)
    mount = motion.static_transform("auv0/base_link", "auv0/dvl", position=[0.3, -0.2, 0.1], attitude=attitudes[0])
    found = {
        "odometry": [deserialize(motion.ODOMETRY, row.tobytes()) for row in encode.odometry.rows(t_ns, table)],
        "transforms": [deserialize(motion.TF, row.tobytes()) for row in encode.transforms(t_ns, table)],
        "mount": deserialize(motion.TF, motion.static_message([mount])),
        "path": [
            deserialize(motion.PATH, motion.path_message(corners))
            for corners in (places, places[:1], np.array([[1.0, 2.0, -3.0], [1.0, 2.0, -5.0], [-4.0, 3.0, -5.0]]))
        ],
        "group": [deserialize(GROUP, row.tobytes()) for row in rows],
        "members": back,
    }
    check("messages", "motion", {name: on_one_scale(v) for name, v in found.items()}, EXACT)


def test_structures_of_lcm() -> None:
    lcm_transport = pytest.importorskip("pelagos.bridges.lcm_transport")
    origin = GeoOrigin(-33.25, -151.5)
    sim: Any = SimpleNamespace(world=SimpleNamespace(origin=origin))
    found: dict[str, Any] = {}
    for kind, made in sorted(lcm_transport.STRUCTURES.items()):
        config = config_of(kind, 0)
        name, fields = made(reading(kind, 0, config), config, sim)
        raw = lcm.encode(name, {"timestamp": 12_345, **fields})
        shown = b"" if kind in ("gps", "pose") else raw  # their last bits are the processor's
        found[kind] = on_one_scale([name, fields, shown, lcm.definition(name)])
    found["hashes"] = on_one_scale([str(lcm.fingerprint(n) % 1_000_003) for n in (*lcm.HOLOOCEAN, *lcm.OWN)])
    check("messages", "structures of LCM", found, EXACT)


def test_types_and_their_forms_in_json() -> None:
    found: dict[str, Any] = {}
    services = [
        f"pelagos_msgs/srv/{n}_{half}" for n in ("SetControlMode", "SetOcean") for half in ("Request", "Response")
    ]
    for name in (*TYPES, *services):
        told = to_json(filled(name))
        raw = serialize(name, from_json(name, told))
        hashed = type_hash(name).encode() if "/msg/" in name else b""
        found[name] = on_one_scale([told, raw, hashed, wire_type(name)])
    check("messages", "types", found, EXACT)
