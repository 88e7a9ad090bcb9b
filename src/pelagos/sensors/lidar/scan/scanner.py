"""A scan of both LiDARs: fire the pulses, find their echoes, list the points.

The values of a point are what differs: functions of the echoes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.raycast.caster import Caster
from pelagos.sensors.camera.picture.camera_rays import Trace
from pelagos.sensors.camera.picture.sea_crossing import sea_crossing, uneven_sea
from pelagos.sensors.idle_keys import Need, idle
from pelagos.sensors.lidar.scan.laser import Echoes, LaserConfig, Scan, echoes, pulses, scan_struct
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_NEEDS: Final = (Need(("rotation_hz", "motion_distortion"), "pattern", ("rotating",)),)


@dataclass(frozen=True)
class Returns:
    """Returns of a sample's pulses, for the functions that work out a LiDAR's values.

    Attributes:
        echo: see `Echoes`.
        pulse: `UInt32`, number of the pulse in its sample, channel by channel.
        environment, tick: `UInt32`, of each pulse.
        lane: `UInt32`, sample of each pulse.
        place: `Array3f64` of the scanner by sample, world [m].
        t: `Float64` by sample [s].
        turbidity: `UInt32` by sample, see `Kinematics.turbidity`.
    """

    echo: Echoes
    pulse: Array
    environment: Array
    tick: Array
    lane: Array
    place: Array
    t: Array
    turbidity: Array | None = None


Values = Callable[[Returns, Any, Trace | None], tuple[Array, ...]]


class Scanner:
    """Samples of a LiDAR.

    Args:
        config: pattern of the pulses.
        context: see `SensorContext`.
        values: pure function of what came back, of `arguments` and of a trace: arrays by pulse, of any component count.
        arguments: arrays that `values` needs, opaque.
    """

    def __init__(self, config: LaserConfig, context: SensorContext, values: Values, arguments: Any = ()) -> None:
        if told := idle(config, _NEEDS):
            warnings.warn(f"{context.path}: {told}", ValidityWarning, stacklevel=4)
        self._config, self._context, self._values, self._extra = config, context, values, arguments
        self._scan = scan_struct(config)
        self._ocean = uneven_sea(context.ocean)
        self._own = jit.UInt32(context.own_body)
        dr.make_opaque(self._own)
        self._recorded = context.scene.compile(self._kernel)

    def samples(self, motion: Kinematics) -> tuple[NDArray[Any], ...]:
        """`(lanes, channels, steps)` or `(lanes, channels, steps, components)` of each of the values."""
        shape = (-1, self._config.channels, self._config.steps)
        found = (np.array(v) for v in self._recorded(*self._arguments(motion)))
        return tuple(
            v.reshape(shape) if v.ndim == 1 else np.ascontiguousarray(v.T).reshape(*shape, len(v)) for v in found
        )

    def angle(self, motion: Kinematics) -> NDArray[np.float64]:
        """`(lanes,)` how far the scanner has turned in its field at the end of the sample, clockwise [rad]."""
        config = self._config
        if config.pattern == "solid_state":
            return np.zeros(len(motion.tick))
        turns = np.array(motion.t_ns, dtype=np.float64) * 1e-9 * config.rotation_hz
        return np.asarray((turns % 1.0) * np.radians(config.horizontal_fov_deg))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        found: list[tuple[str, NDArray[Any], str]] = []

        def trace(name: str, values: Array, unit: str) -> None:
            found.append((name, np.array(values), unit))

        scene = self._context.scene
        self._kernel(scene.caster, *self._arguments(motion), trace=trace)
        return found

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return self._scan, motion, self._own, self._ocean, self._extra

    def _kernel(
        self,
        caster: Caster,
        scan: Scan,
        motion: Kinematics,
        own: Array,
        ocean: Ocean,
        extra: Any,
        *,
        trace: Trace | None = None,
    ) -> tuple[Array, ...]:
        config, values = self._config, self._values
        count = config.channels * config.steps
        ray = dr.arange(jit.UInt32, dr.width(motion.tick) * count)
        lane = ray // count
        pulse = ray - lane * count
        rays, direction = pulses(scan, lane, pulse, motion, own, config)
        position, _ = sensor_pose(motion, config)
        crossing = sea_crossing(rays, lane, ocean, position, motion.t_ns, motion.copy)
        echo = echoes(caster, rays, direction, crossing, config)
        if trace is not None:
            trace("range", echo.distance, "m")
        environment, tick = (dr.gather(jit.UInt32, v, lane) for v in (motion.environment, motion.tick))
        t = jit.Float64(motion.t_ns) * 1e-9
        return values(Returns(echo, pulse, environment, tick, lane, position, t, motion.turbidity), extra, trace)


def cloud(direction: Array, distance: Array, value: Array, kept: Array) -> Array:
    """`Array4f` x, y, z, value; NaN where not kept."""
    p = direction * distance
    return dr.select(kept, jit.Array4f(p.x, p.y, p.z, value), dr.nan)


def ring_of(image: NDArray[np.float32]) -> tuple[NDArray[np.bool_], NDArray[np.uint16]]:
    """Mask of the pulses `(channels, steps)` of one copy that gave a point, and the channel of each of those points."""
    there = np.isfinite(image[..., 0])
    return there, np.nonzero(there)[0].astype(np.uint16)
