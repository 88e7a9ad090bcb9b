"""Readings as ROS 2 messages: bytes, frames, fields, and every registered sensor."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pelagos.config import registry
from pelagos.messages.encoders import ENCODERS, encoder
from pelagos.messages.encoding import DOWNWARD, OPTICAL, PROJECTED, Site
from pelagos.messages.fan import FanPreview
from pelagos.messages.motion import ODOMETRY, TruthEncoder
from pelagos.messages.soundings import POINT
from pelagos.messages.store import deserialize, make, schema, serialize, stamp, typestore
from pelagos.sensors.comms.link.packet import Reception
from pelagos.sensors.sensor import Measurement, Reading, SensorConfig
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording

SITE = Site("auv0/here", 45.0, 12.5)
T_NS = 12_345_678_901
RNG = np.random.Generator(np.random.PCG64(5))


_PIXELS: dict[str, tuple[tuple[int, ...], str]] = {
    "depth_camera": ((), "f4"), "semantic_camera": ((), "u1"), "instance_camera": ((), "u4"),
    "normal_camera": ((3,), "f4"), "optical_flow_camera": ((2,), "f4"), "thermal_camera": ((), "f4"),
    "event_camera": ((), "i2"),
}  # fmt: skip


_WATER = ("sound_velocity", "fluorometer", "oxygen", "turbidity", "tracer")


def config_of(kind: str, **keys: Any) -> Any:
    needed = {
        "tracer": {"tracer": "dye"},
        "lbl": {"transponders": {"a": {"position_m": (1.0, 2.0, -3.0)}}},
        "range_bearing": {"targets": {"a": {"position_m": (1.0, 2.0, -3.0)}}},
    }  # what has no default
    return registry.find("sensor", kind).config.model_validate({"type": kind, **needed.get(kind, {}), **keys})


def measurement(kind: str, config: Any, lanes: int) -> Measurement:
    """Numbers of the shapes that a sensor's docstring states."""
    uniform = RNG.uniform
    extras: dict[str, Any] = {}
    if kind in ("imu", "pose", "magnetometer", "gps", "velocity", "dvl"):
        data = uniform(-2, 2, (lanes, {"imu": 6, "pose": 7}.get(kind, 3)))
    elif kind in ("ctd", "current_meter"):
        data = uniform(1, 20, (lanes, 3))
        extras = {"salinity": uniform(30, 38, lanes), "sound_speed": uniform(1450, 1550, lanes)}
    elif kind in ("depth", "altimeter", *_WATER):
        data = uniform(1, 20, lanes)
    elif kind == "multibeam":
        data = uniform(5, 20, (lanes, config.beams)).astype(np.float32)
        data[:, 3] = np.nan
        extras["backscatter"] = uniform(-40, -10, data.shape).astype(np.float32)
    elif kind in ("imaging_sonar", "profiling_sonar"):
        data = uniform(0, 1, (lanes, config.beams, config.bins)).astype(np.float32)
    elif kind in ("sidescan", "singlebeam", "mechanical_scanning_sonar"):
        data = uniform(-60, 0, (lanes, *([2] if kind == "sidescan" else []), config.bins)).astype(np.float32)
        extras = {"altitude": uniform(5, 20, lanes), "angle": uniform(-3, 3, lanes)}
    elif kind == "camera":
        data = np.zeros((lanes, config.height_px, config.width_px, 3), dtype=np.uint8)
        data[:, :, : config.width_px // 2, 0] = 200
        data[:, : config.height_px // 4, :, 2] = 40 * np.arange(lanes)[:, None, None]
    elif kind in _PIXELS:
        shape, dtype = _PIXELS[kind]
        data = uniform(0, 9, (lanes, config.height_px, config.width_px, *shape)).astype(dtype)
    elif kind in ("lidar", "semantic_lidar"):
        data = uniform(-9, 9, (lanes, 4, 10, 4)).astype(np.float32)
        data[:, 0, 0] = np.nan
        if kind == "semantic_lidar":
            extras["instance"] = np.arange(lanes * 40, dtype=np.uint32).reshape(lanes, 4, 10)
            extras["label"] = extras["instance"].astype(np.uint8)
    elif kind == "collision":
        data = uniform(0, 1, (lanes, 1)) > 0.5
        extras = {"force": uniform(-9, 9, (lanes, 3)), "moment": uniform(-9, 9, (lanes, 3))}
    elif kind in ("modem", "usbl", "ais", "optical_modem", "radio"):
        data = uniform(0, 1, (lanes, 5))
        extras = {"fates": np.empty(lanes, dtype=object)}
        lost = Reception(7, "data", "b.modem", "*", "a.modem", 5, 9, 8, "collision", 120.5, -math.inf)
        extras["fates"][:] = [(replace(lost, number=7 + lane),) * (1 + lane % 2) for lane in range(lanes)]
    elif kind == "range_bearing":
        data = uniform(0, 1, (lanes, 2, 3))
    else:
        data = uniform(0, 1, (lanes, 4))
    if kind == "dvl":
        extras = {
            "sigma": uniform(0.001, 0.01, (lanes, 4)),
            "beam_valid": np.array([[True, True, False, True], [True, False, False, True]] * lanes)[:lanes],
            "altitude": uniform(5, 20, lanes), "ranges": uniform(5, 20, (lanes, 4)),
            "beam_velocity": uniform(-1, 1, (lanes, 4)),
        }  # fmt: skip
    return Measurement(data, data, None, extras)


def reading(found: Measurement, lane: int = 0) -> Reading:
    row = slice(lane, lane + 1)
    extras = {name: values[row] for name, values in found.extras.items()}
    return Reading(found.data[row], found.truth[row], T_NS, "auv0/here", np.ones(1, bool), extras)


def messages(kind: str, config: Any = None) -> tuple[Measurement, list[Any]]:
    config = config or config_of(kind)
    found = measurement(kind, config, 1)
    encoding = encoder(config, SITE)
    raw = encoding.encode(reading(found), 0)
    return found, [deserialize(t.type, bytes(b)) for t, b in zip(encoding.topics, raw, strict=True) if b is not None]


def test_bytes_are_those_that_ros_sends() -> None:
    assert serialize("std_msgs/msg/String", make("std_msgs/msg/String", data="abc")).hex() == "000100000400000061626300"
    clock = make("rosgraph_msgs/msg/Clock", clock=stamp(1_500_000_000))
    assert serialize("rosgraph_msgs/msg/Clock", clock).hex() == "00010000010000000065cd1d"


def test_the_type_of_an_imu_message_is_that_of_ros() -> None:
    """RIHS01 hash of sensor_msgs/msg/Imu as ROS 2 Jazzy states it (`ros2 topic info -v`)."""
    golden = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    assert typestore().hash_rihs01("sensor_msgs/msg/Imu") in (golden, golden.removeprefix("RIHS01_"))


@pytest.mark.parametrize("kind", sorted(registry.entries("sensor", plugins=False)))
def test_every_registered_sensor_is_encoded(kind: str) -> None:
    """Patched bytes equal what rosbags makes of the same message, and every stamp is the reading's time."""
    config = config_of(kind)
    encoding = encoder(config, SITE)
    raw = encoding.encode(reading(measurement(kind, config, 1)), 0)
    assert len(raw) == len(encoding.topics) > 0
    for topic, data in zip(encoding.topics, raw, strict=True):
        assert data is not None
        message = deserialize(topic.type, bytes(data))
        assert serialize(topic.type, message) == bytes(data)
        if hasattr(message, "header"):
            assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 345_678_901)
            assert message.header.frame_id.startswith(("auv0/here", "auv0/base_link", "map"))


def test_a_sensor_without_a_message_of_its_own_is_recorded_as_numbers() -> None:
    config = SensorConfig(type="novelty", rate_hz=1)
    values = np.arange(24.0).reshape(1, 2, 3, 4)
    found = encoder(config, SITE).encode(Reading(values, values, 0, "", np.ones(1, bool), {}), 0)[0]
    message = deserialize("std_msgs/msg/Float64MultiArray", bytes(found or b""))
    assert [(d.label, d.size, d.stride) for d in message.layout.dim] == [
        ("axis0", 2, 24),
        ("axis1", 3, 12),
        ("axis2", 4, 4),
    ]
    np.testing.assert_array_equal(message.data, np.arange(24.0))


def test_complex_numbers_have_an_axis_more() -> None:
    values = np.array([[1 + 2j, 3 - 4j]])
    config = SensorConfig(type="novelty", rate_hz=1)
    found = encoder(config, SITE).encode(Reading(values, values, 0, "", np.ones(1, bool), {}), 0)[0]
    message = deserialize("std_msgs/msg/Float64MultiArray", bytes(found or b""))
    assert [(d.label, d.size) for d in message.layout.dim] == [("axis0", 2), ("real, imaginary", 2)]
    assert message.data.tolist() == [1, 2, 3, -4]


@pytest.mark.parametrize("kind", sorted(ENCODERS))
def test_a_block_gives_the_messages_of_single_readings(kind: str, tmp_path: Path) -> None:
    config = config_of(kind)
    k, n = 3, 2
    found = measurement(kind, config, k * n)
    valid = np.array([True, True, True, False, True, True])
    found = Measurement(found.data, found.truth, valid, found.extras)
    t_ns = np.array([0, 200_000_000, 400_000_000])
    recordings = []
    for name in ("block", "single"):
        path = tmp_path / f"{name}.mcap"
        with Recorder(path, "", 0, {"a": {"s": config}}, None, (45.0, 12.5), 5_000_000, copies=n) as r:
            if name == "block":
                r.write_block("a", "s", t_ns, found, n=n)
            else:
                for i in range(k):
                    row = slice(i * n, (i + 1) * n)
                    extras = {key: values[row] for key, values in found.extras.items()}
                    r.write(
                        "a", "s", Reading(found.data[row], found.truth[row], int(t_ns[i]), "a/s", valid[row], extras)
                    )
        recordings.append([(m.topic, m.t_ns, m.raw) for m in Recording(path).messages()])
    assert recordings[0] == recordings[1]
    assert len([m for m in recordings[0] if m[0].startswith("/env1/")]) == 2 * len(encoder(config, SITE).topics)


@pytest.mark.parametrize("kind", sorted(ENCODERS))
def test_a_copy_of_a_fleet_says_what_it_says_alone(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = config_of(kind, **({"width_px": 32, "height_px": 24} if kind == "camera" or kind in _PIXELS else {}))
    k, n = 2, 3
    found, t_ns = measurement(kind, config, k * n), np.array([0, 200_000_000])
    said = []
    for copies in (range(n), *([copy] for copy in range(n))):
        lanes = (np.arange(k)[:, None] * n + np.array(copies)).ravel()
        own = Measurement(
            found.data[lanes], found.data[lanes], None, {name: v[lanes] for name, v in found.extras.items()}
        )
        places = lambda self, agent, copies=copies: [f"env{copy}/{agent}" for copy in copies]
        with monkeypatch.context() as patch:
            patch.setattr(Recorder, "places", places)
            with Recorder(tmp_path / "it.mcap", "", 0, {"a": {"s": config}}, None, (45.0, 12.5), 5_000_000,
                          copies=len(copies)) as r:  # fmt: skip
                r.write_block("a", "s", t_ns, own, n=len(copies))
        said.append([(m.topic, m.t_ns, m.raw) for m in Recording(tmp_path / "it.mcap").messages() if "/env" in m.topic])
    assert sorted(said[0]) == sorted(m for one in said[1:] for m in one)
    unnamed = [b"".join(raw.replace(f"env{copy}".encode(), b"") for *_, raw in said[1 + copy]) for copy in range(n)]
    assert len(set(unnamed)) == n  # else nobody would see them mixed


def test_an_imu_at_rest_feels_gravity_upwards() -> None:
    data = np.array([[0.0, 0.0, 9.81, 0.01, -0.02, 0.03]])
    raw = encoder(config_of("imu"), SITE).encode(Reading(data, data, T_NS, "", np.ones(1, bool), {}), 0)[0]
    message = deserialize("sensor_msgs/msg/Imu", bytes(raw or b""))
    assert (message.linear_acceleration.z, message.angular_velocity.y) == (9.81, -0.02)
    assert message.orientation_covariance[0] == -1.0
    config = config_of("imu")
    assert message.angular_velocity_covariance[4] == pytest.approx(config.gyroscope_noise_density**2 * config.rate_hz)


def test_heading_east_has_no_yaw_in_ros() -> None:
    """Heading east is yaw -90 degrees in NWU and 0 in ENU; body velocities stay as they are."""
    east = np.array([[math.sqrt(0.5), 0, 0, -math.sqrt(0.5)]])
    motion = (np.array([[10.0, 20.0, -5.0]]), east, np.array([[1.5, 0.1, 0.2]]), np.array([[0, 0, 0.3]]))
    encode = TruthEncoder("a/base_link")
    numbers = encode.numbers(*motion)
    rows, transforms = encode.odometry.rows(np.array([T_NS]), numbers), encode.transforms(np.array([T_NS]), numbers)
    assert encode.encode(T_NS, *(m[0] for m in motion)) == (rows[0].tobytes(), transforms[0].tobytes())
    message = deserialize(ODOMETRY, rows[0].tobytes())
    q, p = message.pose.pose.orientation, message.pose.pose.position
    assert [q.x, q.y, q.z, q.w] == pytest.approx([0, 0, 0, 1], abs=1e-15)
    assert (p.x, p.y, p.z) == (-20.0, 10.0, -5.0)
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (1.5, 0.3)


def test_dvl_speaks_both_frames() -> None:
    found, (twist, full) = messages("dvl")
    x, y, z = found.data[0]
    assert (twist.twist.twist.linear.x, twist.twist.twist.linear.y) == (x, y)
    assert (full.velocity.x, full.velocity.y, full.velocity.z) == (x, -y, -z)
    assert twist.header.frame_id + DOWNWARD.suffix == full.header.frame_id
    assert full.num_good_beams == 3
    assert all(b.z > 0 for b in full.beam_unit_vec)  # z along the pointing direction: down
    assert full.course_gnd == pytest.approx(math.atan2(-y, x))
    np.testing.assert_allclose(full.range, found.extras["ranges"][0])
    np.testing.assert_allclose(full.beam_velocity, found.extras["beam_velocity"][0], rtol=1e-6)


def test_multibeam_points_lie_along_its_beams() -> None:
    config = config_of("multibeam")
    found, (cloud, ranges) = messages("multibeam", config)
    points = np.frombuffer(bytes(cloud.data), dtype=POINT)
    good = np.isfinite(points["x"])
    assert good.sum() == config.beams - 1
    distance = np.sqrt(points["x"] ** 2 + points["y"] ** 2 + points["z"] ** 2)
    np.testing.assert_allclose(distance[good], found.data[0][good], rtol=1e-5)
    assert points["y"][0] > 0 > points["z"][0]  # the first beam looks down to port
    assert (ranges.flags[3].flag, ranges.flags[4].flag) == (1, 0)
    assert ranges.beam_unit_vec[0].y < 0 < ranges.beam_unit_vec[0].z  # y is starboard, z down
    np.testing.assert_array_equal(ranges.ranges, found.data[0])


def test_a_sidescan_without_a_bottom_says_that_it_is_out_of_range() -> None:
    config = config_of("sidescan")
    data = np.full((1, 2, config.bins), -200.0, dtype=np.float32)
    found = Measurement(data, data, None, {"altitude": np.array([np.nan])})
    raw = encoder(config, SITE).encode(reading(found), 0)
    assert deserialize("sensor_msgs/msg/Range", bytes(raw[-1] or b"")).range == math.inf


def test_a_target_to_port_has_positive_azimuth_and_negative_y() -> None:
    config = config_of("imaging_sonar")
    found, (image, _) = messages("imaging_sonar", config)
    assert image.beam_directions[0].y < 0 < image.beam_directions[0].z
    assert image.beam_directions[0].x == 0
    assert image.image.dtype == 0
    picture = np.asarray(image.image.data).reshape(config.bins, config.beams)  # range-major rows
    np.testing.assert_array_equal(picture, (found.data[0].T * 255 + 0.5).astype(np.uint8))
    assert image.ranges[0] > config.range_min_m
    assert image.ranges[-1] < config.range_max_m
    assert len(image.ping_info.tx_beamwidths) == 1


@pytest.mark.parametrize(("scale", "value"), [("db", -35.0), ("linear", 10**-3.5), ("unit", 0.4)])
def test_sonar_levels_do_not_depend_on_the_configured_scale(scale: str, value: float) -> None:
    """-35 dB with a floor of -55 and 50 dB of range is 102 of 255, however the sensor gives it."""
    known = {"type": "imaging_sonar", "scale": scale, "floor_db": -55.0, "dynamic_range_db": 50.0}
    config = registry.find("sensor", "imaging_sonar").config.model_validate(known)
    data = np.full((1, config.beams, config.bins), value, dtype=np.float32)
    raw = encoder(config, SITE).encode(Reading(data, data, 0, "", np.ones(1, bool), {}), 0)[0]
    image = deserialize("marine_acoustic_msgs/msg/ProjectedSonarImage", bytes(raw or b""))
    assert set(np.unique(image.image.data)) == {102}


def test_the_preview_shows_port_on_the_left() -> None:
    azimuth = np.radians(np.linspace(60, -60, 121))
    polar = np.zeros((121, 200), dtype=np.uint8)
    polar[20, 100] = 255  # 40 degrees to port, at 15 m of 30
    picture = FanPreview(azimuth, 0.0, 30.0, 200, height=300)(polar)
    row, column = np.unravel_index(int(picture.sum(axis=-1).argmax()), picture.shape[:2])
    middle = picture.shape[1] / 2
    assert (300 - row) / 10 == pytest.approx(15 * math.cos(math.radians(40)), abs=0.3)
    assert (middle - column) / 10 == pytest.approx(15 * math.sin(math.radians(40)), abs=0.3)
    assert picture[0, 0].sum() == 0


def test_camera_pictures_are_jpeg_with_the_lens_beside() -> None:
    config = config_of("camera")
    _, (image, info) = messages("camera", config)
    picture = np.asarray(Image.open(io.BytesIO(bytes(image.data))))
    assert picture.shape == (config.height_px, config.width_px, 3)
    assert picture[10, 10, 0] == pytest.approx(200, abs=4)
    assert image.format == "jpeg"
    assert image.header.frame_id == info.header.frame_id == "auv0/here" + OPTICAL.suffix
    assert info.k[0] == pytest.approx(0.5 * config.width_px / math.tan(math.radians(config.horizontal_fov_deg) / 2))


@pytest.mark.parametrize(
    ("keys", "topic", "encoding", "dtype"),
    [
        ({"bits": 12}, "image_color", "rgb16", np.uint16),
        ({"mosaic": "grbg"}, "image_raw", "bayer_grbg8", np.uint8),
        ({"mosaic": "rggb", "bits": 10}, "image_raw", "bayer_rggb16", np.uint16),
    ],
)
def test_raw_and_deep_pictures_are_not_compressed(keys: dict[str, Any], topic: str, encoding: str, dtype: Any) -> None:
    known = {"type": "camera", "width_px": 32, "height_px": 16, **keys}
    config = registry.find("sensor", "camera").config.model_validate(known)
    shape = (1, 16, 32) if "mosaic" in keys else (1, 16, 32, 3)
    data = RNG.integers(0, 200, shape).astype(dtype)
    made = encoder(config, SITE)
    raw = made.encode(Reading(data, data, 0, "", np.ones(1, bool), {}), 0)[0]
    image = deserialize("sensor_msgs/msg/Image", bytes(raw or b""))
    assert (made.topics[0].suffix, image.encoding) == (topic, encoding)
    np.testing.assert_array_equal(np.frombuffer(bytes(image.data), dtype), data.ravel())


def test_the_lens_of_a_fisheye_is_told_as_such() -> None:
    known = {"type": "camera", "lens": "fisheye", "horizontal_fov_deg": 180, "distortion": (0.02, -0.01, 0, 0, 0)}
    _, (_, info) = messages("camera", registry.find("sensor", "camera").config.model_validate(known))
    assert info.distortion_model == "equidistant"
    assert info.d.tolist() == [0.02, -0.01, 0, 0]
    angle = math.pi / 2  # at the edge of the picture
    assert info.k[0] * (angle + 0.02 * angle**3 - 0.01 * angle**5) == pytest.approx(320)


def test_a_depth_camera_with_a_picture_sends_both() -> None:
    known = {"type": "depth_camera", "image": True, "width_px": 32, "height_px": 16}
    config = registry.find("sensor", "depth_camera").config.model_validate(known)
    depth = np.full((1, 16, 32), 4.0, dtype=np.float32)
    picture = np.full((1, 16, 32, 3), 120, dtype=np.uint8)
    made = encoder(config, SITE)
    raw = made.encode(Reading(depth, depth, 0, "", np.ones(1, bool), {"image": picture}), 0)
    assert [t.suffix for t in made.topics] == ["depth/image", "camera_info", "image_color/compressed"]
    shown = deserialize("sensor_msgs/msg/CompressedImage", bytes(raw[2] or b""))
    assert np.asarray(Image.open(io.BytesIO(bytes(shown.data)))).shape == (16, 32, 3)


def test_extra_frames_turn_as_they_say() -> None:
    """Axes of the frames that message types want, seen from the sensor (x forward, y left, z up)."""

    def axes(q: tuple[float, float, float, float]) -> list[list[float]]:
        w, u = q[0], np.array(q[1:])
        eye = np.eye(3)
        return [np.round(v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v)), 12).tolist() for v in eye]

    assert axes(OPTICAL.attitude) == [[0, -1, 0], [0, 0, -1], [1, 0, 0]]  # right, down, forward
    assert axes(PROJECTED.attitude) == [[0, 0, 1], [0, -1, 0], [1, 0, 0]]  # up, right, forward
    assert axes(DOWNWARD.attitude) == [[1, 0, 0], [0, -1, 0], [0, 0, -1]]  # forward, right, down


def test_the_raw_signal_is_recorded_where_it_is_asked_for() -> None:
    known = {"type": "imaging_sonar", "iq": True, "beams": 4, "bins": 8}
    config = registry.find("sensor", "imaging_sonar").config.model_validate(known)
    data = np.zeros((1, 4, 8), dtype=np.float32)
    iq = (RNG.standard_normal((1, 4, 8)) + 1j * RNG.standard_normal((1, 4, 8))).astype(np.complex64)
    raw = encoder(config, SITE).encode(Reading(data, data, 0, "", np.ones(1, bool), {"iq": iq}), 0)[2]
    message = deserialize("marine_acoustic_msgs/msg/RawSonarImage", bytes(raw or b""))
    np.testing.assert_array_equal(np.frombuffer(bytes(message.image.data), np.complex64).reshape(4, 8), iq[0])
    assert message.samples_per_beam == 8


def test_schemas_name_every_type_within() -> None:
    text = schema("marine_acoustic_msgs/msg/ProjectedSonarImage").decode()
    for inner in ("std_msgs/Header", "marine_acoustic_msgs/PingInfo", "geometry_msgs/Vector3"):
        assert f"MSG: {inner}" in text


@pytest.mark.parametrize(
    ("kind", "name", "step"),
    [
        ("depth_camera", "32FC1", 4),
        ("semantic_camera", "mono8", 1),
        ("instance_camera", "32SC1", 4),
        ("normal_camera", "32FC3", 12),
        ("thermal_camera", "32FC1", 4),
        ("event_camera", "16SC1", 2),
    ],
)
def test_pixels_come_back_as_they_were(kind: str, name: str, step: int) -> None:
    config = config_of(kind)
    found, (image, info) = messages(kind, config)
    assert (image.encoding, image.step, image.height) == (name, step * config.width_px, config.height_px)
    pixels = np.frombuffer(bytes(image.data), dtype=found.data.dtype)
    np.testing.assert_array_equal(pixels, found.data.ravel())
    assert info.width == config.width_px


def test_lidar_points_have_ring_label_and_instance() -> None:
    found, (cloud,) = messages("semantic_lidar")
    kinds = {4: "<u2", 6: "<u4", 7: "<f4"}
    points = np.frombuffer(bytes(cloud.data), dtype=[(f.name, kinds[f.datatype]) for f in cloud.fields])
    assert cloud.point_step == points.dtype.itemsize
    np.testing.assert_array_equal(points["y"].reshape(4, 10), found.data[0, ..., 1])
    assert points["ring"].reshape(4, 10)[:, 3].tolist() == [0, 1, 2, 3]
    assert points["instance"][37] == 37
    assert points.dtype.names == ("x", "y", "z", "cosine", "ring", "label", "instance")
    assert np.isnan(points["x"][0])
