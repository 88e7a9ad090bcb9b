"""The common part of HoloOcean's sensors: name, place, rate, configuration, and the value of a tick."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.compat.holoocean.frames import matrix_of
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.noise import Normal, stream
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment
    from pelagos.compat.holoocean.motion import AgentMotion
    from pelagos.compat.holoocean.sensors import SensorDefinition

Array = NDArray[Any]


class HoloOceanSensor(ABC):
    """One sensor of an agent.

    Attributes:
        name, agent_name, agent_type: as in the scenario.
        config: its configuration.
        sensor_data: the last value, zeros before the first.
        tick_every: ticks from one reading to the next.
        tick_count: ticks since the last reading.
        lcm_msg: its message, where it has a channel.
        is_native, native_name: whether there is a native sensor, and what it is called in `env.pelagos`.
    """

    sensor_type: ClassVar[str] = ""
    keys: ClassVar[frozenset[str]] = frozenset()
    """Keys that the configuration may hold."""
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
        self.is_native, self.native_name = False, identifier(self.name)
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
    @abstractmethod
    def data_shape(self) -> Sequence[int]:
        """Of its value."""

    @property
    def dtype(self) -> Any:
        """Of its value."""
        return np.float32

    def setup(self) -> None:  # noqa: B027  (most have no more to read)
        """Read the configuration."""

    def zero(self) -> Any:
        """The value before the first reading."""
        return np.zeros(self.data_shape, dtype=self.dtype)

    def native(self) -> dict[str, Any] | None:
        """Keys of the native sensor, without place and rate; None where the state is enough."""
        return None

    @abstractmethod
    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        """The value at a tick at which it is due; None: absent."""

    def idle(self) -> Any:
        """The value at other ticks of what is `always` there."""
        return self.sensor_data

    def rotate(self, rotation: Sequence[float]) -> None:
        """Turn the sensor in its socket from the next tick on: roll, pitch, yaw [deg] by the engine's left-handed
        signs, so that pitch and yaw are opposite to those of the key `rotation`."""
        self.env._rotate_sensor(self, rotation)

    def reset(self) -> None:  # noqa: B027  (most keep nothing)
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

    def point(self, motion: AgentMotion) -> Array:
        """`(3,)` where it is in the world [m]."""
        return np.asarray(motion.position + motion.rotation @ self.offset)

    def axes(self, motion: AgentMotion) -> Array:
        """`(3, 3)` sensor to world."""
        return np.asarray(motion.rotation @ self.turned)

    def noise(self, name: str, size: int) -> Normal:
        """Noise by its keys."""
        try:
            return Normal(self.config, name, size, advice=self.env.advice)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{self.agent_name}.{self.name}: {error}") from error
