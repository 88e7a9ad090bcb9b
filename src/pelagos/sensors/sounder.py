"""What every sonar is built of: its water, the surfaces at its frequency, its random stream, its frozen ping."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.scene import Tables
from pelagos.sensors.echo import Fan, Lanes, Medium, Trace, fan_struct, medium_of
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import opaque_key, stream_key
from pelagos.sensors.scattering import TEXTURE_DB, Surfaces, surfaces
from pelagos.sensors.sensor import Kinematics, SensorConfig, SensorContext


class Sounder:
    """The parts that a sonar keeps from ping to ping; none of them changes.

    Args:
        config: mount.
        context: see `SensorContext`.
        rays: the ray pattern, see `fan_struct`.
        frequency_hz: of the water's absorption and of the surfaces' scattering.
        ph: acidity of the water.
        wind_speed: roughens the sea surface [m/s].
        texture_db: rms variation of surfaces' cross sections from place to place [dB].

    Attributes:
        fan: rays on the device.
        surfaces: what materials scatter.
        key: random stream of the sonar's noise.
    """

    def __init__(
        self,
        config: SensorConfig,
        context: SensorContext,
        rays: dict[str, NDArray[Any]],
        *,
        frequency_hz: float,
        ph: float,
        wind_speed: float = 5.0,
        texture_db: float = TEXTURE_DB,
    ) -> None:
        self._config = config
        self._context = context
        self._medium = medium_of(frequency_hz, ph)
        self._frozen_medium = jit.freeze(self._medium)
        self._own = jit.UInt32(context.own_body)
        dr.make_opaque(self._own)
        self.fan: Fan = fan_struct(rays)
        self.surfaces: Surfaces = surfaces(
            context.world.palette, frequency_hz, wind_speed=wind_speed, texture_db=texture_db
        )
        self.key = opaque_key(stream_key(context.seed, context.path, "noise"))

    def arguments(self, motion: Kinematics) -> tuple[Tables, Lanes, Fan, Surfaces, Any]:
        """What every ping is called with: the scene's tables, where the sonar is, its rays, surfaces, random stream."""
        lanes = self._lanes(motion, self._context.ocean, self._own, self._frozen_medium)
        return self._context.scene.tables, lanes, self.fan, self.surfaces, self.key

    def compile(self, make: Callable[[Any, Any], Callable[..., Any]]) -> Callable[..., Any]:
        """Freeze all that a ping takes, from the body's motion on: a function (motion, *more) of arrays.

        `make(static, moving)` makes the ping, a function (tables, lanes, fan, surfaces, key, motion, *more). Lanes that
        are found outside of the frozen ping take longer than a ping of few rays: 0.3 to 0.6 ms.
        """
        scene = self._context.scene

        def whole(static: Any, moving: Any) -> Callable[..., Any]:
            def read(
                tables: Tables, motion: Kinematics, ocean: Any, own: Array, fan: Fan, surfaces: Surfaces, key: Any,
                *more: Any,
            ) -> Any:  # fmt: skip
                lanes = self._lanes(motion, ocean, own, self._medium)
                dr.eval(lanes)  # in one kernel: rays gather from each of its arrays
                return make(static, moving)(tables, lanes, fan, surfaces, key, motion, *more)

            return read

        frozen = scene.compile(whole)

        def ping(motion: Kinematics, *more: Any) -> Any:
            return frozen(
                scene.tables, motion, self._context.ocean, self._own, self.fan, self.surfaces, self.key, *more
            )

        return ping

    def _lanes(self, motion: Kinematics, ocean: Any, own: Array, medium: Callable[..., Medium]) -> Lanes:
        position, attitude = sensor_pose(motion, self._config)
        water = medium(ocean, position, jit.Float64(motion.t_ns) * 1e-9)
        own_row = dr.gather(jit.UInt32, own, motion.copy)
        return Lanes(position, attitude, motion.copy, own_row, motion.environment, motion.tick, water)

    def trace(self, make: Callable[..., Any], *arguments: Any) -> list[tuple[str, NDArray[Any], str]]:
        """Run a ping that is not frozen, and keep its intermediate arrays: (name, values, unit).

        `make(static, moving, trace)` is the sonar's maker of pings, `arguments` what its ping is called with.
        """
        found: list[tuple[str, NDArray[Any], str]] = []
        keep: Trace = lambda name, values, unit: found.append((name, np.array(values), unit))
        scene = self._context.scene
        make(scene.static, scene.moving, keep)(*arguments)
        return found
