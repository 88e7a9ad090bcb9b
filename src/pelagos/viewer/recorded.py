"""Messages of a recording as samples: the reverse of what the recorder's encoders do, as far as eyes need it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.sample import CAMERAS, Sample, cloud, numbers_of, photograph, swath_of, waterfall_line
from pelagos.math.frames import enu_to_nwu_np, quaternion_enu_to_nwu_np
from pelagos.math.so3 import matrix_np
from pelagos.messages.fan import copper
from pelagos.messages.sonar_image import eight_bits
from pelagos.sensors.sensor import SensorConfig
from pelagos.sim.replay import Recorded
from pelagos.viewer.frame import ShownPose
from pelagos.world.world import World

_PIXELS: Final = {"32F": np.float32, "8U": np.uint8, "16U": np.uint16, "16S": np.int16, "32S": np.int32}
_NAMED: Final = {"mono8": (np.uint8, 1), "mono16": (np.uint16, 1), "rgb8": (np.uint8, 3), "rgb16": (np.uint16, 3)}

WANTED: Final[Mapping[str, tuple[str, ...]]] = {
    "imaging_sonar": ("/image",), "profiling_sonar": ("/image",), "sidescan": ("/image",), "singlebeam": ("/image",),
    "mechanical_scanning_sonar": ("/image",), "camera": ("/compressed", "/image_color"),
    "depth_camera": ("/depth/image",), "semantic_camera": ("/labels",), "instance_camera": ("/instances",),
    "normal_camera": ("/normals",), "optical_flow_camera": ("/flow",), "thermal_camera": ("/temperature",),
    "event_camera": ("/events",), "multibeam": ("/points",), "lidar": ("/points",), "semantic_lidar": ("/points",),
    "dvl": ("/dvl",), "imu": ("/data_raw",), "altimeter": ("/range",),
    "ctd": ("/ctd",),
}  # fmt: skip
"""Ends of the topics that are looked at, by sensor type; of others the first topic."""


def sample_from(config: SensorConfig, name: str, recorded: Recorded) -> Sample | None:
    """A message as people see it; None where there is nothing to see in it."""
    read = _READERS.get(recorded.type.rsplit("/", 1)[-1])
    if read is None:
        return None
    found = read(config, recorded.message)
    return None if found is None else Sample(name, config.type, recorded.t_ns, **found)


def truth_at(config: Any, pose: ShownPose, world: World) -> dict[str, float]:
    """Noiseless numbers of a depth sensor or an altimeter at a pose, with the names of `Sample.numbers`.

    The range is along the altimeter's axis, not that of the first echo in its cone; movers are not met.
    """
    if config.type == "depth":
        return {"depth [m]": -float(pose.to_world(np.asarray(config.position_m))[2])}
    if config.type != "altimeter":
        return {}
    down = matrix_np(np.asarray(config.q_body_sensor))[:, 2]
    eye, axis = pose.to_world(np.stack([config.position_m, config.position_m - down]))
    hits = world.cast(eye[None], (axis - eye)[None], config.range_max_m)
    return {"range [m]": float(hits.t[0])} if hits.valid[0] else {}


def _projected(config: Any, m: Any) -> dict[str, Any]:
    levels = np.asarray(m.image.data, dtype=np.uint8).reshape(-1, m.image.beam_count).T
    if config.type in ("sidescan", "singlebeam"):
        return {"line": waterfall_line(levels)}
    if config.type == "mechanical_scanning_sonar":
        (ahead,) = m.beam_directions  # its y is to starboard, angles are positive to port
        return {"sector": (copper()[levels[0]], math.atan2(-ahead.y, ahead.z))}
    return {"polar": levels}


def _compressed(config: Any, m: Any) -> dict[str, Any]:
    return {"picture": np.asarray(m.data, dtype=np.uint8).tobytes()}


def _image(config: Any, m: Any) -> dict[str, Any] | None:
    kind: Any
    kind, channels = _NAMED.get(m.encoding, (None, 1))
    if kind is None:
        stem, _, count = m.encoding.partition("C")
        kind, channels = _PIXELS.get(stem), int(count or 1)
    if kind is None or config.type not in CAMERAS:
        return None
    pixels = np.asarray(m.data, dtype=np.uint8).view(kind).reshape(m.height, m.width, -1)
    return {"picture": photograph(config.type, pixels if channels > 1 else pixels[..., 0])}


def _points(config: Any, m: Any) -> dict[str, Any]:
    kinds = {2: "u1", 4: "<u2", 6: "<u4", 7: "<f4", 8: "<f8"}
    layout = np.dtype({
        "names": [f.name for f in m.fields], "formats": [kinds[f.datatype] for f in m.fields],
        "offsets": [f.offset for f in m.fields], "itemsize": m.point_step,
    })  # fmt: skip
    points = np.asarray(m.data, dtype=np.uint8).view(layout)
    places = np.stack([points["x"], points["y"], points["z"]], axis=-1)
    if config.type == "multibeam":
        ranges = np.linalg.norm(places, axis=-1)
        return {"points": places[np.isfinite(ranges)], "swath": swath_of(config, ranges)}
    fourth = points[m.fields[3].name]
    labels = points["label"] if "label" in (layout.names or ()) else None
    return cloud(np.concatenate([places, fourth[:, None]], axis=-1), labels)


def _dvl(config: Any, m: Any) -> dict[str, Any]:
    velocity = np.array([m.velocity.x, -m.velocity.y, -m.velocity.z])  # the message's z is down
    found = {"numbers": {**numbers_of("dvl", velocity, {}), "altitude [m]": float(m.altitude)}}
    ranges = np.asarray(m.range, dtype=np.float64)
    return {**found, "beams": np.asarray(config.beams) * ranges[:, None]}


def _imu(config: Any, m: Any) -> dict[str, Any]:
    w, a = m.angular_velocity, m.linear_acceleration
    return _small("imu", a.x, a.y, a.z, w.x, w.y, w.z)


def _range(config: Any, m: Any) -> dict[str, Any]:
    return _small("altimeter", m.range)


def _depth(config: Any, m: Any) -> dict[str, Any] | None:
    return _small("depth", -m.pose.pose.position.z) if config.type == "depth" else None


def _pose(config: Any, m: Any) -> dict[str, Any]:
    p, q = m.pose.position, m.pose.orientation
    attitude = quaternion_enu_to_nwu_np(np.array([q.w, q.x, q.y, q.z]))
    return _small(config.type, *enu_to_nwu_np(np.array([p.x, p.y, p.z])), *attitude)


def _velocity(config: Any, m: Any) -> dict[str, Any]:
    v = m.twist.linear
    return _small(config.type, *enu_to_nwu_np(np.array([v.x, v.y, v.z])))


def _flow(config: Any, m: Any) -> dict[str, Any]:
    v = m.twist.twist.linear
    return _small(config.type, v.x, v.y, v.z)


def _magnetic(config: Any, m: Any) -> dict[str, Any]:
    return _small(config.type, m.magnetic_field.x, m.magnetic_field.y, m.magnetic_field.z)


def _contact(config: Any, m: Any) -> dict[str, Any]:
    f = m.wrench.force
    return _small(config.type, math.hypot(f.x, f.y, f.z) > config.least_force_n)


def _ctd(config: Any, m: Any) -> dict[str, Any]:
    return _small(config.type, m.conductivity, m.temperature, m.pressure)


def _property(config: Any, m: Any) -> dict[str, Any]:
    return _small(config.type, m.value)


def _small(kind: str, *values: float) -> dict[str, Any]:
    return {"numbers": numbers_of(kind, np.array(values), {})}


def _fix(config: Any, m: Any) -> dict[str, Any]:
    return _small("gps", m.latitude, m.longitude, m.altitude)


def _numbers(config: Any, m: Any) -> dict[str, Any]:
    """Sensors without a message of their own: what they are is in the configuration."""
    shape = [d.size for d in m.layout.dim]
    values: NDArray[np.float64] = np.asarray(m.data, dtype=np.float64).reshape(shape)
    if hasattr(config, "floor_db") and hasattr(config, "bins"):
        if config.type == "synthetic_aperture_sonar":
            return {"line": waterfall_line(eight_bits(config, np.atleast_2d(values)))}
        return {}
    return {"numbers": numbers_of(config.type, values, {})}


_READERS: Final[Mapping[str, Callable[[Any, Any], dict[str, Any] | None]]] = {
    "ProjectedSonarImage": _projected, "CompressedImage": _compressed, "Image": _image, "PointCloud2": _points,
    "Dvl": _dvl, "Imu": _imu, "Range": _range, "PoseWithCovarianceStamped": _depth, "PoseStamped": _pose,
    "NavSatFix": _fix, "MagneticField": _magnetic, "TwistStamped": _velocity, "TwistWithCovarianceStamped": _flow,
    "WrenchStamped": _contact, "Ctd": _ctd, "WaterProperty": _property, "Float64MultiArray": _numbers,
}  # fmt: skip
