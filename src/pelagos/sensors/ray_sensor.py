"""A sensor of one's own from two functions: a pattern of rays, and what a reading makes of their hits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.errors import KernelError
from pelagos.jit import Array
from pelagos.math.so3 import rotate
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean


@jit.struct
class Medium:
    """The water at the mount, a Dr.Jit struct of `Float64`, one entry a lane.

    Attributes:
        sound_speed: [m/s].
        temperature: in situ [degC].
        salinity: practical.
        depth: of the mount below the mean surface [m], negative in the air.
    """

    sound_speed: Array
    temperature: Array
    salinity: Array
    depth: Array


class RaySensor:
    """Base of sensors that cast a fixed pattern of rays; subclasses give `Config`, `pattern` and `read`.

    All else is done here: the mount, the vehicle's own hull, one cast whose hits are evaluated before they are read,
    the recording, and one transfer of all results.
    """

    Config: ClassVar[type[SensorConfig]]
    TITLE: ClassVar[str] = ""
    SOURCES: ClassVar[tuple[str, ...]] = ()
    KERNELS: ClassVar[int] = 8
    CASTS: ClassVar[int] = 1

    def __init__(self, config: Any, context: SensorContext) -> None:
        self.config = config
        directions = self._unit_directions(self.pattern(config))
        self._ocean = context.ocean
        self._directions = jit.Array3f(np.ascontiguousarray(directions.T))
        self._own = jit.UInt32(context.own_body)
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        jit.align(self._directions, self._own)
        self._program = Program(self._kernel, context.scene.compile)

    def _unit_directions(self, pattern: ArrayLike) -> NDArray[np.float64]:
        """Unit vectors `(r, 3)` of a pattern, which is checked."""
        directions = np.asarray(pattern, dtype=np.float64)
        if directions.ndim != 2 or directions.shape[1] != 3 or not len(directions):
            raise KernelError(f"{type(self).__name__}.pattern gives directions of shape (r, 3), not {directions.shape}")
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        bad = np.flatnonzero(~(np.isfinite(length[:, 0]) & (length[:, 0] > 0)))
        if bad.size:
            raise KernelError(
                f"{type(self).__name__}.pattern: direction {bad[0]} is {directions[bad[0]].tolist()}, which points "
                "nowhere"
            )
        directions /= length
        return directions

    def pattern(self, config: Any) -> ArrayLike:
        """Directions of the rays in the sensor frame FLU, `(r, 3)`."""
        raise NotImplementedError(f"{type(self).__name__} needs pattern(self, config): directions (r, 3) of its rays")

    def reach(self, config: Any) -> float:
        """Reach of rays [m]: the configuration's `range_max_m`."""
        if "range_max_m" not in type(config).model_fields:
            raise KernelError(
                f"{type(config).__name__} has no key range_max_m: give it one, or {type(self).__name__} a method "
                "reach(self, config) -> metres"
            )
        return float(config.range_max_m)

    def read(self, hits: Hits, medium: Medium, draw: Callable[[int], list[Array]], rays: int) -> Results:
        """Results by name, at least `data` and `truth`; `valid` (a mask) says which lanes have a reading.

        Args:
            hits: of all rays, those of a lane side by side; evaluated.
                `dr.block_reduce(dr.ReduceOp.Min, hits.t, rays)` is one value a lane.
            medium: the water at the mount.
            draw: `draw(k)` gives k standard normal numbers a lane, `Float64` each.
            rays: of a lane.
        """
        raise NotImplementedError(
            f"{type(self).__name__} needs read(self, hits, medium, draw, rays): results by name, 'data' and 'truth'"
        )

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        found: dict[str, NDArray[Any]] = self._program(motion, self._ocean, self._directions, self._own, self._key)
        data, truth, valid = found.pop("data"), found.pop("truth"), found.pop("valid", None)
        return Measurement(data, truth, valid, found)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """The results of one reading by name: (name, values, unit)."""
        found = self._program(motion, self._ocean, self._directions, self._own, self._key)
        return [(name, values, "") for name, values in found.items()]

    def _kernel(
        self, caster: Caster, motion: Kinematics, ocean: Ocean, directions: Array, own: Array, key: noise.Key
    ) -> Results:
        position, _ = sensor_pose(motion, self.config)
        _, hits = self._shot(caster, motion, directions, own)
        t = jit.Float64(motion.t_ns) * 1e-9
        temperature, salinity = ocean.temperature(position, t), ocean.salinity(position, t)
        medium = Medium(ocean.sound_speed(position, t), temperature, salinity, -position[2])
        rays = dr.width(directions)
        found = self.read(hits, medium, lambda count: noise.normals64(key, motion, count), rays)
        return self._by_lane(found, dr.width(motion.tick), rays)

    def _by_lane(self, found: Results, lanes: int, rays: int) -> Results:
        """Results with one value a lane; constants are spread over the lanes.

        Raises:
            KernelError: `data` or `truth` is not among them, or one has another number of values.
        """
        read = f"{type(self).__name__}.read"
        if not isinstance(found, Mapping) or not {"data", "truth"} <= found.keys():
            given = sorted(found) if isinstance(found, Mapping) else type(found).__name__
            raise KernelError(f"{read} returns results by name, at least 'data' and 'truth', not {given}")
        widths = {name: dr.width(values) for name, values in found.items()}
        for name, width in widths.items():
            if width not in (0, 1, lanes):
                cure = ": make one value a lane of those of its rays, e.g. dr.block_reduce(dr.ReduceOp.Min, x, rays)"
                raise KernelError(
                    f"{read}: {name!r} has {width} values for {lanes} lanes of {rays} rays"
                    + (cure if width == rays * lanes else "")
                )
        return found if max(widths.values()) == lanes else {**found, "truth": _spread(found["truth"], lanes)}

    def _shot(self, caster: Caster, motion: Kinematics, directions: Array, own: Array) -> tuple[Rays, Hits]:
        """All rays of all lanes, those of a lane side by side, and what they hit; evaluated."""
        position, attitude = sensor_pose(motion, self.config)
        attitude = jit.Array4f(attitude)
        dr.eval(position, attitude)  # in one kernel: each component that is gathered from would be one
        rays, lanes = dr.width(directions), dr.width(motion.tick)
        index = dr.arange(jit.UInt32, rays * lanes)
        lane, ray = index // rays, index % rays
        copy = dr.gather(jit.UInt32, motion.copy, lane)
        turn = dr.gather(jit.Array4f, attitude, lane)
        shot = Rays(
            origin=dr.gather(jit.Array3f64, position, lane),
            direction=rotate(turn, dr.gather(jit.Array3f, directions, ray)),
            max_range=dr.full(jit.Float, self.reach(self.config), rays * lanes),
            copy=copy,
            own=dr.gather(jit.UInt32, own, copy),
        )
        hits = caster.cast(shot)
        dr.eval(hits)
        return shot, hits


def _spread(values: Any, lanes: int) -> Any:
    """A constant as one value a lane."""
    if not dr.is_array_v(values):
        return [_spread(v, lanes) for v in values] if isinstance(values, (list, tuple)) else values
    return dr.gather(type(values), values, dr.zeros(jit.UInt32, lanes))
