"""HoloOcean's sensors: what each is natively, and how its reading is given.

Sensors that report the true motion (pose, location, depth, ...) read it from the simulation's state; all that look,
listen or feel are native sensors. HoloOcean's statistical noise keys are drawn here, on the native truth.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException, HoloOceanException
from pelagos.compat.holoocean.frames import degrees_of, matrix_of
from pelagos.compat.holoocean.noise import Normal, stream
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment
    from pelagos.compat.holoocean.motion import Motion

Array = NDArray[Any]


class HoloOceanSensor:
    """One sensor of an agent.

    Attributes:
        name, agent_name, agent_type: as in the scenario.
        config: its configuration.
        sensor_data: the last value, zeros before the first.
        tick_every: ticks from one reading to the next.
        tick_count: ticks since the last reading.
        lcm_msg: its message, where it has a channel.
    """

    sensor_type: ClassVar[str] = ""
    keys: ClassVar[frozenset[str]] = frozenset()
    """What the configuration may hold."""
    always: ClassVar[bool] = False
    """In the state at every tick."""
    fastest_hz: float = math.inf
    """Rate at which the native sensor runs by itself at most; asked more often, it reads out of turn."""
    every_tick: ClassVar[bool] = False
    """Asked at every tick, whatever its `Hz`."""
    extra: ClassVar[tuple[float, float, float]] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw [deg] of the native sensor in HoloOcean's sensor frame."""

    def __init__(self, env: HoloOceanEnvironment, definition: SensorDefinition, agent_type: str) -> None:
        self.env, self.definition = env, definition
        self.name, self.agent_name, self.agent_type = definition.sensor_name, definition.agent_name, agent_type
        self.config = definition.config
        self.tick_every, self.tick_count = definition.tick_every or 1, 0
        self.lcm_msg: Any = None
        self.is_native = False
        place, turn = definition.mount
        self.offset, self.turned = np.array(place), matrix_of(turn)
        env.advice.unknown(f"{self.agent_name}.{self.name} ({self.sensor_type})", self.config, self.known_keys)
        self.stream = stream(env.seed, self.agent_name, self.name)
        self.setup()
        self.sensor_data: Any = self.zero()
        if definition.lcm_channel is not None:
            from pelagos.compat.holoocean.lcm import SensorData

            self.lcm_msg = SensorData(self.sensor_type, definition.lcm_channel)

    @property
    def known_keys(self) -> frozenset[str]:
        """Every key that is read."""
        return self.keys | {"TicksPerCapture"}

    @property
    def data_shape(self) -> Sequence[int]:
        """Of its value."""
        raise NotImplementedError

    @property
    def dtype(self) -> Any:
        """Of its value."""
        return np.float32

    def setup(self) -> None:
        """Read the configuration."""

    def zero(self) -> Any:
        """The value before the first reading."""
        return np.zeros(self.data_shape, dtype=self.dtype)

    def native(self) -> dict[str, Any] | None:
        """Keys of the native sensor, without place and rate; None where the state is enough."""
        return None

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        """The value at a tick at which it is due; None: absent."""
        raise NotImplementedError

    def idle(self) -> Any:
        """The value at other ticks of what is `always` there."""
        return self.sensor_data

    def rotate(self, rotation: Sequence[float]) -> None:
        """Turn the sensor in its socket from the next tick on: roll, pitch, yaw [deg] by the engine's left-handed
        signs, so that pitch and yaw are opposite to those of the key `rotation`."""
        self.env._rotate_sensor(self, rotation)

    def reset(self) -> None:
        """Forget what a run left behind."""

    def set_ticks_per_capture(self, ticks_per_capture: int) -> None:
        """Ticks from one reading to the next.

        Raises:
            HoloOceanConfigurationException: not a whole number from 1 on.
        """
        if isinstance(ticks_per_capture, bool) or not isinstance(ticks_per_capture, int) or ticks_per_capture < 1:
            raise HoloOceanConfigurationException(
                f"ticks_per_capture is a whole number from 1 on, not {ticks_per_capture!r}"
            )
        self.env._change_period(self, ticks_per_capture)

    def point(self, motion: Motion) -> Array:
        """`(3,)` where it is in the world [m]."""
        return np.asarray(motion.position + motion.rotation @ self.offset)

    def axes(self, motion: Motion) -> Array:
        """`(3, 3)` sensor to world."""
        return np.asarray(motion.rotation @ self.turned)

    def noise(self, name: str, size: int) -> Normal:
        """Noise by its keys."""
        return Normal(self.config, name, size, advice=self.env.advice)


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

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        return np.asarray(self.point(motion) + self._noise.draw(self.stream), dtype=np.float32)


class RotationSensor(HoloOceanSensor):
    """Roll, pitch, yaw of the sensor, world [deg]."""

    sensor_type = "RotationSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        return degrees_of(self.axes(motion)).astype(np.float32)


class OrientationSensor(HoloOceanSensor):
    """The sensor's axes as columns, world."""

    sensor_type = "OrientationSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3, 3]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        return self.axes(motion).astype(np.float32)


class PoseSensor(HoloOceanSensor):
    """Orientation and location of the sensor as one matrix."""

    sensor_type = "PoseSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [4, 4]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        pose = np.eye(4, dtype=np.float32)
        pose[:3, :3], pose[:3, 3] = self.axes(motion), self.point(motion)
        return pose


class VelocitySensor(HoloOceanSensor):
    """Velocity of the sensor's place, world [m/s]."""

    sensor_type = "VelocitySensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
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

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        height = self.point(motion)[2:] - self.env.sea_level
        return np.asarray(height + self._noise.draw(self.stream), dtype=np.float32)


class GPSSensor(_Vector):
    """Place of the sensor, world [m], while it is less than `Depth` under water."""

    sensor_type = "GPSSensor"
    keys = frozenset({"Sigma", "Cov", "Depth", "DepthSigma", "DepthCov"})

    def setup(self) -> None:
        super().setup()
        self._depth, self._depth_noise = abs(float(self.config.get("Depth", 2.0))), self.noise("Depth", 1)

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        point = self.point(motion)
        gate, error = self._depth_noise.draw(self.stream), self._noise.draw(self.stream)
        if np.ravel(self.env.sea_level - point[2] + gate)[0] >= self._depth:
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

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        return np.asarray(self.axes(motion).T @ self._field + self._noise.draw(self.stream), dtype=np.float32)


class DynamicsSensor(HoloOceanSensor):
    """Acceleration, velocity, position, angular acceleration, angular velocity, attitude: all in the world's frame."""

    sensor_type = "DynamicsSensor"
    keys = frozenset({"UseCOM", "UseRPY"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [18 if self.config.get("UseRPY", True) else 19]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        at = np.zeros(3) if self.config.get("UseCOM", True) else self.offset
        axes = motion.rotation if self.config.get("UseCOM", True) else self.axes(motion)
        arm, turn, turning = motion.rotation @ at, motion.turn, motion.turn_acceleration
        acceleration = motion.acceleration + np.cross(turning, arm) + np.cross(turn, np.cross(turn, arm))
        parts = [acceleration, motion.velocity_at(at), motion.position + arm, turning, turn]
        return np.concatenate([*parts, self._attitude(axes)]).astype(np.float32)

    def _attitude(self, axes: Array) -> Array:
        """Roll, pitch, yaw [deg], or the quaternion x, y, z, w with HoloOcean's sign."""
        if self.config.get("UseRPY", True):
            return degrees_of(axes)
        from pelagos.compat.holoocean.frames import quaternion_of

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
        self._white = [self.noise(part, 3) for part in ("Accel", "AngVel")]
        self._walk = [self.noise(f"{part}Bias", 3) for part in ("Accel", "AngVel")]
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

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        assert reading is not None
        steps = max(self.env._total_ticks - self._walked, 1)  # a step of the walk at every tick, due or not
        self._walked = self.env._total_ticks
        for i, walk in enumerate(self._walk):
            self._bias[i] += walk.draw(self.stream) * np.sqrt(steps)
        data = reading.data[0].reshape(2, 3) + self._bias
        data += np.stack([np.broadcast_to(w.draw(self.stream), 3) for w in self._white])
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

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        velocity = self.axes(motion).T @ motion.velocity_at(self.offset)
        if self._beams.root is not None:
            n, sine, cosine = np.asarray(self._beams.draw(self.stream)), np.sin(self._tilt), np.cos(self._tilt)
            error = (n[0] - n[2]) / (2 * sine), (n[1] - n[3]) / (2 * sine), n.sum() / (4 * cosine)
            velocity = velocity + np.array(error)
        if reading is None:
            return velocity.astype(np.float32)
        ranges = np.where(np.isfinite(reading.data[0]), reading.data[0], self._reach) + self._ranges.draw(self.stream)
        return np.concatenate([velocity, ranges]).astype(np.float32)


class RangeFinderSensor(HoloOceanSensor):
    """Ranges of lasers around the sensor, counter-clockwise from its x axis; -1 without a hit."""

    sensor_type = "RangeFinderSensor"
    keys = frozenset({"LaserMaxDistance", "LaserCount", "LaserAngle", "LaserDebug"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [int(self.config.get("LaserCount", 1))]

    def native(self) -> dict[str, Any] | None:
        count = int(self.config.get("LaserCount", 1))
        return {
            "type": "range_finder",
            "range_max_m": float(self.config.get("LaserMaxDistance", 10)),
            "azimuth_deg": [360.0 * i / count for i in range(count)],
            "elevation_deg": [float(self.config.get("LaserAngle", 0))] * count,
        }

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        assert reading is not None
        return np.where(np.isfinite(reading.data[0]), reading.data[0], -1.0).astype(np.float32)


class CollisionSensor(HoloOceanSensor):
    """Whether the hull touched something in the last tick."""

    sensor_type = "CollisionSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    @property
    def dtype(self) -> Any:
        return np.bool_

    def native(self) -> dict[str, Any] | None:
        return {"type": "collision"}

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        return np.array([False]) if reading is None else np.array(reading.data[0], dtype=np.bool_)


class AbuseSensor(HoloOceanSensor):
    """1 where the agent was accelerated beyond `AccelerationLimit`, or lies on its back."""

    sensor_type = "AbuseSensor"
    keys = frozenset({"AccelerationLimit"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    @property
    def dtype(self) -> Any:
        return np.int8

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        limit = float(self.config.get("AccelerationLimit", self.env.agents[self.agent_name].kind.accel_limit))
        hard = limit >= 0 and float(np.linalg.norm(motion.acceleration)) > limit
        return np.array([hard or motion.rotation[2, 2] < 0], dtype=np.int8)


class WorldNumSensor(HoloOceanSensor):
    """A number that the world keeps by the name `Key`: 0 where nothing was set (`env.world_numbers`)."""

    sensor_type = "WorldNumSensor"
    keys = frozenset({"Key"})
    default: ClassVar[str] = ""

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    def value(self, motion: Motion, reading: Reading | None) -> Any:
        number = self.env.world_numbers.get(str(self.config.get("Key", self.default)), 0.0)
        return np.array([number], dtype=self.dtype)


class BallLocationSensor(WorldNumSensor):
    """The world's number "BallLocation"."""

    sensor_type = "BallLocationSensor"
    default = "BallLocation"

    @property
    def dtype(self) -> Any:
        return np.int8


HEAVY: Final = ("RGBCamera", "RaycastLidar", "RaycastSemanticLidar")


class SensorDefinition:
    """Definition of a sensor before it is built.

    Attributes:
        mount: place [m] and turn [deg] in the body's frame, socket included.
    """

    _sonar_sensors: ClassVar[list[str]] = ["ImagingSonar", "ProfilingSonar", "SidescanSonar", "SinglebeamSonar"]
    _heavy_sensors: ClassVar[list[str]] = [*_sonar_sensors, *HEAVY]
    _sensor_keys_: ClassVar[dict[str, type[HoloOceanSensor]]] = {}

    def __init__(
        self,
        agent_name: str,
        agent_type: str,
        sensor_name: str | None,
        sensor_type: str | type[HoloOceanSensor],
        socket: str = "",
        location: Sequence[float] = (0, 0, 0),
        rotation: Sequence[float] = (0, 0, 0),
        config: Mapping[str, Any] | None = None,
        existing: bool = False,
        lcm_channel: str | None = None,
        tick_every: int | None = None,
    ) -> None:
        self.agent_name, self.agent_type = agent_name, agent_type
        self.type = _sensor_type(sensor_type)
        self.sensor_name = sensor_name or self.type.sensor_type
        self.socket, self.location, self.rotation = socket or "", tuple(location), tuple(rotation)
        self.config = {} if config is None else dict(config)
        self.existing, self.lcm_channel, self.tick_every = existing, lcm_channel, tick_every
        self.twist: Sequence[float] | None = None

    @property
    def mount(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Place [m] and turn [deg], body axes."""
        from pelagos.compat.holoocean.agents import kind_of

        place, turn = kind_of(self.agent_type).sockets.get(self.socket, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        socket = matrix_of(turn)
        at = np.array(place) + socket @ np.asarray(self.location, dtype=np.float64)
        turned = socket @ matrix_of(self.rotation if self.twist is None else self.twist)
        return tuple(float(v) for v in at), tuple(float(v) for v in degrees_of(turned))  # type: ignore[return-value]


def _sensor_type(given: str | type[HoloOceanSensor]) -> type[HoloOceanSensor]:
    if isinstance(given, type):
        return given
    known = sensor_types()
    if given not in known:
        from pelagos.errors import did_you_mean

        raise HoloOceanException(f"there is no sensor type {given!r}{did_you_mean(str(given), known)}")
    return known[given]


def sensor_types() -> dict[str, type[HoloOceanSensor]]:
    """Every sensor type by its name."""
    if not SensorDefinition._sensor_keys_:
        from pelagos.compat.holoocean import cameras, comms_sensors, sonars, water_sensors

        found = [HoloOceanSensor]
        for one in found:
            found += one.__subclasses__()
        SensorDefinition._sensor_keys_ |= {c.sensor_type: c for c in found if c.sensor_type}
        globals().update({c.__name__: c for c in found})
        _ = cameras, comms_sensors, sonars, water_sensors
    return SensorDefinition._sensor_keys_


class SensorFactory:
    """Builds sensors from their definitions."""

    @staticmethod
    def build_sensor(client: Any, sensor_def: SensorDefinition) -> HoloOceanSensor:
        """The sensor."""
        return sensor_def.type(client, sensor_def, sensor_def.agent_type)
