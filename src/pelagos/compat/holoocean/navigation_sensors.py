"""HoloOcean's navigation sensors: the true motion with its statistical noise keys, IMU and DVL on native sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pelagos.compat.holoocean.frames import degrees_of, quaternion_of
from pelagos.compat.holoocean.noise import Normals
from pelagos.compat.holoocean.sensor import Array, HoloOceanSensor
from pelagos.math.so3 import cross_np
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion


class _Vector(HoloOceanSensor):
    """Three numbers, with noise `Sigma` or `Cov`."""

    keys = frozenset({"Sigma", "Cov"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def setup(self) -> None:
        self._noise = self.noise("", 3)


class LocationSensor(_Vector):
    """Place of the sensor, world [m]."""

    sensor_type = "LocationSensor"

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return np.asarray(self.point(motion) + self._noise.draw(self.stream), dtype=np.float32)


class RotationSensor(HoloOceanSensor):
    """Roll, pitch, yaw of the sensor, world [deg]."""

    sensor_type = "RotationSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return degrees_of(self.axes(motion)).astype(np.float32)


class OrientationSensor(HoloOceanSensor):
    """The sensor's axes as columns, world."""

    sensor_type = "OrientationSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3, 3]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return self.axes(motion).astype(np.float32)


class PoseSensor(HoloOceanSensor):
    """Orientation and location of the sensor as one matrix."""

    sensor_type = "PoseSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [4, 4]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        pose = np.zeros((4, 4), dtype=np.float32)
        pose[3, 3] = 1.0
        pose[:3, :3], pose[:3, 3] = self.axes(motion), self.point(motion)
        return pose


class VelocitySensor(HoloOceanSensor):
    """Velocity of the sensor's place, world [m/s]."""

    sensor_type = "VelocitySensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return motion.velocity_at(self.offset).astype(np.float32)


class DepthSensor(HoloOceanSensor):
    """Height of the sensor over the level of the sea, negative below it [m]."""

    sensor_type = "DepthSensor"
    keys = frozenset({"Sigma", "Cov"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    def setup(self) -> None:
        self._noise = self.noise("", 1)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        height = self.point(motion)[2:] - self.env.sea_level
        return np.asarray(height + self._noise.draw(self.stream), dtype=np.float32)


class GPSSensor(_Vector):
    """Place of the sensor, world [m], while it is less than `Depth` under water."""

    sensor_type = "GPSSensor"
    keys = frozenset({"Sigma", "Cov", "Depth", "DepthSigma", "DepthCov"})

    def setup(self) -> None:
        super().setup()
        self._depth, self._depth_noise = abs(float(self.config.get("Depth", 2.0))), self.noise("Depth", 1)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        point = self.point(motion)
        gate, error = self._depth_noise.draw(self.stream), self._noise.draw(self.stream)
        if float(np.asarray(gate).item()) + self.env.sea_level - float(point[2]) >= self._depth:
            return None
        return np.asarray(point + error, dtype=np.float32)


class MagnetometerSensor(_Vector):
    """A constant field `MagneticVector` of the world, in the sensor's frame."""

    sensor_type = "MagnetometerSensor"
    keys = frozenset({"Sigma", "Cov", "MagneticVector", "MagnetixVector"})

    def setup(self) -> None:
        super().setup()
        if "MagnetixVector" in self.config:
            self.env.advice.once("MagnetixVector, as one of HoloOcean's pages spells it, is taken as MagneticVector")
        given = self.config.get("MagneticVector", self.config.get("MagnetixVector", [1, 0, 0]))
        self._field = np.asarray(given, dtype=np.float64)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return np.asarray(self.axes(motion).T @ self._field + self._noise.draw(self.stream), dtype=np.float32)


class DynamicsSensor(HoloOceanSensor):
    """Acceleration, velocity, position, angular acceleration, angular velocity, attitude: all in the world's frame."""

    sensor_type = "DynamicsSensor"
    keys = frozenset({"UseCOM", "UseRPY"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [18 if self.config.get("UseRPY", True) else 19]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        at = np.zeros(3) if self.config.get("UseCOM", True) else self.offset
        axes = motion.rotation if self.config.get("UseCOM", True) else self.axes(motion)
        arm, turn, turning = motion.rotation @ at, motion.turn, motion.turn_acceleration
        acceleration = motion.acceleration + cross_np(turning, arm) + cross_np(turn, cross_np(turn, arm))
        parts = [acceleration, motion.velocity_at(at), motion.position + arm, turning, turn]
        return np.concatenate([*parts, self._attitude(axes)]).astype(np.float32)

    def _attitude(self, axes: Array) -> Array:
        """Roll, pitch, yaw [deg], or the quaternion x, y, z, w with HoloOcean's sign."""
        if self.config.get("UseRPY", True):
            return degrees_of(axes)

        w, x, y, z = quaternion_of(degrees_of(axes))
        return -np.array([x, y, z, w]) * (1.0 if w >= 0 else -1.0)


class IMUSensor(HoloOceanSensor):
    """Specific force and angular rate in the sensor's frame, with the biases behind where asked for."""

    sensor_type = "IMUSensor"
    keys = frozenset(
        f"{part}{kind}" for part in ("Accel", "AngVel", "AccelBias", "AngVelBias") for kind in ("Sigma", "Cov")
    ) | {"ReturnBias"}

    @property
    def data_shape(self) -> Sequence[int]:
        return [4, 3] if self.config.get("ReturnBias", False) else [2, 3]

    def setup(self) -> None:
        self._noise = Normals([self.noise(part, 3) for part in ("AccelBias", "AngVelBias", "Accel", "AngVel")])
        self._bias = np.zeros((2, 3))
        self._walked = 0

    def native(self) -> dict[str, Any] | None:
        quiet = {
            f"{triad}_{key}": 0.0
            for triad in ("accelerometer", "gyroscope")
            for key in ("noise_density", "bias_instability", "bias_std", "scale_std", "resolution")
        }
        ranges = {"accelerometer_range": 1e6, "gyroscope_range": 1e6}
        return {"type": "imu", **quiet, **ranges, "misalignment_std": 0.0}

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        steps = max(self.env._total_ticks - self._walked, 1)  # a step of the walk at every tick, due or not
        self._walked = self.env._total_ticks
        walk, white = self._noise.draw(self.stream).reshape(2, 2, 3)
        self._bias += walk * math.sqrt(steps)
        data = reading.data[0].reshape(2, 3) + self._bias + white
        if self.config.get("ReturnBias", False):
            data = np.concatenate([data, self._bias])
        return data.astype(np.float32)


class DVLSensor(HoloOceanSensor):
    """Velocity over ground in the sensor's frame, and the ranges of four beams: ahead, left, back, right."""

    sensor_type = "DVLSensor"
    keys = frozenset(
        {"Elevation", "DebugLines", "VelSigma", "VelCov", "ReturnRange", "MaxRange", "RangeSigma", "RangeCov"}
    )

    @property
    def data_shape(self) -> Sequence[int]:
        return [7] if self.config.get("ReturnRange", True) else [3]

    def setup(self) -> None:
        self._beams, self._ranges = self.noise("Vel", 4), self.noise("Range", 4)
        self._tilt = np.radians(float(self.config.get("Elevation", 22.5)))
        self._reach = float(self.config.get("MaxRange", 20.0))

    def native(self) -> dict[str, Any] | None:
        if not self.config.get("ReturnRange", True):
            return None
        return {
            "type": "range_finder",
            "range_max_m": self._reach,
            "azimuth_deg": [0.0, 90.0, 180.0, -90.0],
            "elevation_deg": [float(np.degrees(self._tilt)) - 90.0] * 4,
        }

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        velocity = self.axes(motion).T @ motion.velocity_at(self.offset)
        if self._beams.root is not None:
            n, sine, cosine = np.asarray(self._beams.draw(self.stream)), np.sin(self._tilt), np.cos(self._tilt)
            error = (n[0] - n[2]) / (2 * sine), (n[1] - n[3]) / (2 * sine), n.sum() / (4 * cosine)
            velocity = velocity + np.array(error)
        if reading is None:
            return velocity.astype(np.float32)
        ranges = np.where(np.isfinite(reading.data[0]), reading.data[0], self._reach) + self._ranges.draw(self.stream)
        return np.concatenate([velocity, ranges]).astype(np.float32)
