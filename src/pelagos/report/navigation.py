"""Dead reckoning as a navigator aboard would do it, from the recorded sensors alone.

Attitude: gyroscopes integrated, levelled by the accelerometers and turned by the magnetometer's heading (a
complementary filter with constant gains: R. Mahony et al., IEEE Trans. Autom. Control 53:1203, 2008, without the bias
states). Position: DVL velocity turned into the world and summed up; depth from the depth sensor. GPS fixes give the
start only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.geomagnetism import earth_field
from pelagos.math.so3 import from_euler, rotate_np
from pelagos.messages.navigation import (
    DEPTH_FIELDS,
    FIX_FIELDS,
    IMU,
    IMU_FIELDS,
    MAGNETIC_FIELD,
    MAGNETIC_FIELDS,
    NAV_SAT_FIX,
    POSE_COVARIANCE,
)
from pelagos.messages.ranging import TWIST_COVARIANCE, TWIST_FIELDS
from pelagos.report.mission import Mission, RecordedMotion

STEP_S: Final = 0.05  # the gyroscopes are averaged over this
LEVEL_TIME_S: Final = 20.0
HEADING_TIME_S: Final = 30.0
QUIET_MPS2: Final = 0.5


@dataclass(frozen=True)
class DeadReckoning:
    """Motion that the navigator believes in.

    Attributes:
        motion: position NWU, attitude, velocity FLU over time.
        start: what the start position was taken from: "gps" or "truth".
        error: `(k,)` horizontal distance from the true position [m].
        drift: `(k,)` the same less the error of the start [m].
        distance: true way travelled until then `(k,)` [m].
    """

    motion: RecordedMotion
    start: str
    error: NDArray[np.float64]
    drift: NDArray[np.float64]
    distance: NDArray[np.float64]


def fixes(mission: Mission) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time [s] and position `(k, 3)` NWU [m] of the GPS fixes, as of the antenna."""
    found = mission.table("gps", NAV_SAT_FIX, FIX_FIELDS)
    if found is None:
        return np.zeros(0), np.zeros((0, 3))
    return found[0], origin(mission).to_nwu(found[1])


def origin(mission: Mission) -> GeoOrigin:
    """Origin of the world on Earth."""
    about = mission.recording.metadata
    return GeoOrigin(float(about.get("latitude_deg", 0.0)), float(about.get("longitude_deg", 0.0)))


@dataclass(frozen=True)
class Known:
    """Estimate that a mission went by: kind ("ekf", "external"), motion over time, horizontal error `(k,)` [m]."""

    kind: str
    motion: RecordedMotion
    error: NDArray[np.float64]


def known(mission: Mission) -> Known | None:
    """The solution of the vehicle's own navigation; None where it knew the truth."""
    topic = f"/{mission.agent}/navigation"
    channel = next((c for c in mission.recording.channels.values() if c.topic == topic), None)
    if channel is None or mission.recording.count(topic) < 2:
        return None
    motion = mission.odometry(topic)
    off = (motion.position - mission.motion.at(motion.t).position)[:, :2]
    return Known(str(channel.about.get("kind", "")), motion, np.hypot(*off.T))


def dead_reckoning(mission: Mission) -> DeadReckoning | None:
    """The navigator's track; None without an IMU or a DVL."""
    imu = mission.table("imu", IMU, IMU_FIELDS)
    dvl = mission.table("dvl", TWIST_COVARIANCE, TWIST_FIELDS)
    truth = mission.motion
    if imu is None or dvl is None or len(imu[0]) < 2 or len(dvl[0]) < 2 or len(truth.t) < 2:
        return None
    t, rate, force = _averaged(*imu, mission)
    velocity = _dvl_on(t, *dvl, rate, mission)
    attitude = _attitude(t, rate, force, velocity, _headings(mission, t), truth)
    world = rotate_np(attitude, velocity)
    start, source = _start(mission, truth, t)
    position = start + np.concatenate([np.zeros((1, 3)), np.cumsum(world[:-1] * np.diff(t)[:, None], axis=0)])
    depth = mission.table("depth", POSE_COVARIANCE, DEPTH_FIELDS)
    if depth is not None:
        position[:, 2] = np.interp(t, depth[0], depth[1][:, 0])
    true = truth.at(t)
    off = (position - true.position)[:, :2]
    error, drift = np.hypot(*off.T), np.hypot(*(off - off[0]).T)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(true.position[:, :2], axis=0), axis=1))])
    return DeadReckoning(RecordedMotion(t, position, attitude, velocity), source, error, drift, way)


def _averaged(
    t: NDArray[np.float64], values: NDArray[np.float64], mission: Mission
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Time, angular rate and specific force in the body frame, averaged over `STEP_S`."""
    width = max(1, round(STEP_S / float(np.median(np.diff(t)))))
    count = len(t) // width
    blocks = values[: count * width].reshape(count, width, -1).mean(axis=1)
    times = t[: count * width].reshape(count, width)[:, 0]
    q = mission.mount("imu")[1]
    return times, rotate_np(q, blocks[:, :3]), rotate_np(q, blocks[:, 3:6])


def _dvl_on(
    t: NDArray[np.float64], times: NDArray[np.float64], values: NDArray[np.float64], rate: NDArray[np.float64],
    mission: Mission,
) -> NDArray[np.float64]:  # fmt: skip
    """`(k, 3)` velocity of the body's origin FLU [m/s]: the DVL's, turned by its mount, less its lever arm."""
    lever, q = mission.mount("dvl")
    body = rotate_np(q, values[:, :3])
    at_steps = np.stack([np.interp(t, times, column) for column in body.T], axis=-1)
    return at_steps - np.cross(rate, lever)


def _headings(mission: Mission, t: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """`(k, 4)` magnetic field in the body frame and its declination [rad]; None without a magnetometer."""
    found = mission.table("magnetometer", MAGNETIC_FIELD, MAGNETIC_FIELDS)
    if found is None or len(found[0]) < 2:
        return None
    body = rotate_np(mission.mount("magnetometer")[1], found[1])
    columns = [np.interp(t, found[0], column) for column in body.T]
    return np.stack([*columns, np.full(len(t), declination(mission))], axis=-1)


def _attitude(
    t: NDArray[np.float64], rate: NDArray[np.float64], force: NDArray[np.float64], velocity: NDArray[np.float64],
    field: NDArray[np.float64] | None, truth: RecordedMotion,
) -> NDArray[np.float64]:  # fmt: skip
    """`(k, 4)` the filter; it starts level with gravity and along the magnetic heading (or the true one without)."""
    up = force - np.cross(rate, velocity)  # less the centripetal acceleration, gravity alone is left
    roll = math.atan2(up[0, 1], up[0, 2])
    pitch = math.atan2(-up[0, 0], math.hypot(up[0, 1], up[0, 2]))
    q = from_euler(roll, pitch, 0.0)
    if field is None:
        yaw = float(truth.euler[0, 2])
    else:
        x, y, _ = rotate_np(np.array(q), field[0, :3]).tolist()
        yaw = field[0, 3] - math.atan2(y, x)
    q = from_euler(roll, pitch, yaw)
    out = np.empty((len(t), 4))
    ups, rates = up.tolist(), rate.tolist()
    fields = field.tolist() if field is not None else None
    steps = np.append(np.diff(t), 0.0).tolist()
    for k, h in enumerate(steps):
        out[k] = q
        q = _turned(q, rates[k], ups[k], fields[k] if fields is not None else None, h)
    return out


def _turned(
    q: tuple[float, float, float, float], rate: list[float], up: list[float], field: list[float] | None, h: float
) -> tuple[float, float, float, float]:
    """One step of the filter."""
    w, x, y, z = q
    ux, uy, uz = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)  # world up, seen from the body
    norm = math.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2) or 1.0
    ax, ay, az = up[0] / norm, up[1] / norm, up[2] / norm
    gain = 1.0 / LEVEL_TIME_S if abs(norm - GRAVITY) < QUIET_MPS2 else 0.0  # not while something pushes
    p = rate[0] + gain * (ay * uz - az * uy)
    r = rate[1] + gain * (az * ux - ax * uz)
    s = rate[2] + gain * (ax * uy - ay * ux)
    if field is not None:
        north = (1 - 2 * (y * y + z * z)) * field[0] + 2 * (x * y - w * z) * field[1] + 2 * (x * z + w * y) * field[2]
        west = 2 * (x * y + w * z) * field[0] + (1 - 2 * (x * x + z * z)) * field[1] + 2 * (y * z - w * x) * field[2]
        turn = math.remainder(field[3] - math.atan2(west, north), 2 * math.pi) / HEADING_TIME_S
        p, r, s = p + turn * ux, r + turn * uy, s + turn * uz
    p, r, s = 0.5 * h * p, 0.5 * h * r, 0.5 * h * s
    w, x, y, z = (
        w - x * p - y * r - z * s, x + w * p + y * s - z * r, y + w * r + z * p - x * s, z + w * s + x * r - y * p,
    )  # fmt: skip
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm


def _start(mission: Mission, truth: RecordedMotion, t: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
    """The position at the first step: of the first fix, where one came within two seconds."""
    times, positions = fixes(mission)
    if len(times) and times[0] - t[0] <= 2.0:
        first = truth.at(times[:1])
        antenna = rotate_np(first.attitude, mission.mount("gps")[0][None])
        moved = first.position - truth.at(t[:1]).position
        return (positions[:1] - antenna - moved)[0], "gps"
    return truth.at(t[:1]).position[0], "truth"


def declination(mission: Mission) -> float:
    """Angle of the magnetic field from true north, counter-clockwise from above [rad], of the sensor's own model."""
    name = next((c.about["sensor"] for c in mission.channels("magnetometer", MAGNETIC_FIELD)), "")
    given = mission.config(name).get("declination_deg")
    if given is not None:
        return -math.radians(float(given))
    where = origin(mission)
    north, west, _ = earth_field(where.latitude, where.longitude).tolist()
    return math.atan2(west, north)
