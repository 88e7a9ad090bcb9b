"""The contract of a sensor: a frozen configuration, and a function from its motion to its readings.

A sensor sees lanes. One lane is one copy of the fleet at one tick: a fleet of n over a block of k ticks is n * k lanes,
ordered tick-major (lane = tick_in_block * n + copy). `sense` never loops over lanes and keeps no state of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict

from pelagos import jit
from pelagos.config.described import Described
from pelagos.config.rate import Rate
from pelagos.errors import CommandError
from pelagos.jit import Array
from pelagos.sensors.lazy import keeps_promises, promised

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.raycast.scene import Scene
    from pelagos.sensors.comms.link.medium import SharedMedium
    from pelagos.sensors.navigation.collision import Blows
    from pelagos.sensors.sonar.ping.interference import Neighbours
    from pelagos.world.world import Hits, World


class SensorConfig(Described):
    """Keys that every sensor has: a rate and a place on the vehicle. Its own keys stand in its own file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    STANDS: ClassVar[str] = ""
    """Name of the vehicle's place (`mounts`) where it stands unless it says where: `antenna`, `mast` or `keel`."""

    type: str
    """The sensor's kind: one of `pelagos list sensors`."""
    rate_hz: Rate
    """Samples per second [Hz]; must divide the tick rate."""
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place of the sensor in the body frame, forward-left-up of the vehicle's origin [m]. Where not given: the
    vehicle's `antenna`, `mast` or `keel`, if it has one, for what needs the sky, a view over the water, or the water;
    else the origin."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw of the sensor frame in the body frame FLU [deg], R = Rz Ry Rx; positive pitch looks down."""

    @property
    def q_body_sensor(self) -> tuple[float, float, float, float]:
        """The mounting rotation as a quaternion (w, x, y, z): sensor vectors to body vectors."""
        from pelagos.math.so3 import from_euler

        roll, pitch, yaw = (math.radians(a) for a in self.orientation_deg)
        w, x, y, z = from_euler(roll, pitch, yaw)
        return float(w), float(x), float(y), float(z)


@jit.struct
class Kinematics:
    """Motion of one agent's body, a Dr.Jit struct, one lane a copy and tick (see the module's docstring).

    Attributes:
        position: `Array3f64`, world NWU [m].
        attitude: `Array4f64`, (w, x, y, z), body FLU to world NWU.
        velocity: `Array3f64`, over ground, in the body frame FLU [m/s].
        angular_velocity: `Array3f64`, body FLU [rad/s].
        acceleration: `Array3f64`, inertial acceleration of the body's origin, in the body frame FLU [m/s^2], without
            gravity.
        angular_acceleration: `Array3f64`, body FLU [rad/s^2].
        t_ns: `UInt64`, simulation time [ns].
        tick: `UInt32`, ticks since the copy's episode began; without partial resets t_ns / dt_ns.
        environment: `UInt32`, names the random streams of the copy's episode; in the first episode the index of the
            copy, counted from the run's first environment. Where one sensor reads for several vehicles, the row of its
            key tables (see `noise.KeyTable`), which is `copy`.
        copy: `UInt32`, row of the fleet axis, 0 .. n-1; of several vehicles vehicle * n + copy.
        age_ns: `UInt64`, time since the episode began [ns]; None: as t_ns.
        lamps: `Float`, factor on the light of the sensor's lamps and lasers; None: 1.
        turbidity: `UInt32`, which of `Ocean.turbidities` the water has; None: `Ocean.turbidity`.
    """

    position: Array
    attitude: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    t_ns: Array
    tick: Array
    environment: Array
    copy: Array
    age_ns: Array | None = None
    lamps: Array | None = None
    turbidity: Array | None = None

    @property
    def size_key(self) -> int:
        """Number of lanes, which all fields have."""
        return len(self.tick)


@keeps_promises("truth")
@dataclass(frozen=True)
class Measurement:
    """Result of `sense`: NumPy arrays with the lanes as leading axis.

    Attributes:
        data: `(m, ...)`, with noise.
        truth: `(m, ...)`, the same before noise; computed when somebody looks at it, where that takes long.
        valid: `(m,)` bool, or None where every lane has a reading.
        extras: further arrays `(m, ...)` by name, documented by the sensor.
        tables: constant arrays by name (beam angles, range of each bin).
    """

    data: NDArray[Any]
    truth: NDArray[Any]
    valid: NDArray[np.bool_] | None = None
    extras: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    tables: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def reading(
        self, lanes: slice, valid: NDArray[np.bool_], t_ns: int, frame: str, kind: str = ""
    ) -> Reading:  # fmt: skip
        """That of one tick, whose lanes are `lanes`; see `Reading`."""
        extras = {name: values[lanes] for name, values in self.extras.items()} | dict(self.tables)
        return Reading(self.data[lanes], promised(lambda: self.truth[lanes]), t_ns, frame, valid, extras, kind)


@keeps_promises("truth")
@dataclass(frozen=True)
class Reading:
    """One sensor's reading of one tick.

    Attributes:
        data: `(n, ...)`, as the sensor reports it; the leading axis is the fleet.
        truth: `(n, ...)`, before noise; computed when somebody looks at it, where that takes long.
        t_ns: simulation time [ns].
        frame: frame id, "agent/sensor".
        valid: `(n,)` bool: copies that have a reading (a fleet of one has no reading at all where it has none).
        extras: further arrays by name, see the sensor's docstring.
        kind: type of the sensor, as scenarios name it.
    """

    data: NDArray[Any]
    truth: NDArray[Any]
    t_ns: int
    frame: str
    valid: NDArray[np.bool_]
    extras: Mapping[str, NDArray[Any]]
    kind: str = ""

    @property
    def array(self) -> Array:
        """`data` as a tensor of Dr.Jit, `(n, ...)`: for its arithmetic, and for others by DLPack.

        Numbers of single precision stay so; all others come in double precision.
        """
        kind = jit.TensorXf if self.data.dtype == np.float32 else jit.TensorXf64
        return kind(np.ascontiguousarray(self.data, dtype=np.float32 if kind is jit.TensorXf else np.float64))

    def _repr_html_(self) -> str:
        return str(import_module("pelagos.drawing.notebook").reading_html(self))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "truth": self.truth}

    @property
    def packets(self) -> Any:
        """Of a modem: the packets that it received, `Packet`; a list of them for each copy of a fleet of several."""
        found = self.extras.get("packets")
        if found is None:
            raise AttributeError(f"the reading of {self.frame} has no packets; modems have")
        return list(found[0]) if len(found) == 1 else [list(packets) for packets in found]


@dataclass(frozen=True)
class SensorContext:
    """Surroundings that a sensor is built with.

    Attributes:
        path: "agent.sensor", which also names its random stream.
        seed: the run's seed.
        dt_ns: the tick [ns].
        scene: what rays are cast into.
        world: geometry, materials, labels, geographic origin.
        ocean: currents, water masses, waves, optics.
        own_body: `(n,)` uint32 rows of the moving-body table that are this agent's own hull (`NO_BODY` where it has
            none there).
        neighbours: the scenario's sonars, which hear one another; None where there is only this sensor.
        blows: what hulls have touched lately; likewise.
        medium: the water between modems; likewise.
    """

    path: str
    seed: int
    dt_ns: int
    scene: Scene
    world: World
    ocean: Ocean
    own_body: NDArray[np.uint32]
    neighbours: Neighbours | None = None
    blows: Blows | None = None
    medium: SharedMedium | None = None

    @classmethod
    def alone(
        cls,
        path: str = "vehicle.sensor",
        *,
        world: World | Mapping[str, Any] | None = None,
        ocean: Ocean | Mapping[str, Any] | None = None,
        copies: int = 1,
        seed: int = 0,
        dt_ns: int = 5_000_000,
    ) -> Self:
        """A context without a simulation: to try or to test one sensor.

        Args:
            path: "agent.sensor", which names the random stream.
            world: or the keys that a scenario writes under `world`; absent: open water without a bottom, at latitude
                and longitude 0.
            ocean: or the keys that a scenario writes under `ocean`; absent: its defaults.
            copies: of the fleet.
            seed: of noise and waves.
            dt_ns: the tick [ns].
        """
        from pelagos.ocean.config import OceanConfig, build_ocean
        from pelagos.ocean.ocean import Ocean
        from pelagos.raycast.rays import NO_BODY
        from pelagos.world.material import MATERIALS
        from pelagos.world.world import World

        if isinstance(world, World):
            around = world
        else:
            from pelagos.config.loader import load_scenario
            from pelagos.world.build import build_world

            empty = World((), tuple(MATERIALS.values()))
            around = empty if world is None else build_world(load_scenario({"world": world, "agents": {}}).world)
        if not isinstance(ocean, Ocean):
            ocean = build_ocean(OceanConfig.model_validate(ocean or {}), around, seed=seed)
        nobody = np.full(copies, NO_BODY, dtype=np.uint32)
        return cls(path, seed, dt_ns, around.scene(copies), around, ocean, nobody)

    def cast(self, motion: Kinematics, origins: ArrayLike, directions: ArrayLike, max_range: ArrayLike = 100.0) -> Hits:
        """Rays of every lane in NumPy, past the vehicle's own hull.

        Args:
            motion: of the lanes, m of them, as `sense` got it.
            origins: `(m, 3)`, or `(m, r, 3)` for r rays a lane, world NWU [m].
            directions: the same shape; of any length but zero.
            max_range: one number [m], or of the shape `(m, r)`.

        Returns:
            `Hits` of m r rays, lane after lane.

        Raises:
            CommandError: a wrong shape, a value that is not finite, or a direction of no length.
        """
        start, along = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
        m = motion.size_key
        if start.shape != along.shape or start.ndim not in (2, 3) or start.shape[0] != m or start.shape[-1] != 3:
            raise CommandError(
                f"cast: origins {start.shape} and directions {along.shape} for {m} lanes; both are ({m}, 3), or "
                f"({m}, rays, 3) (np.array(motion.position).T is ({m}, 3))"
            )
        rays = start.shape[1] if start.ndim == 3 else 1
        copy = np.repeat(np.array(motion.copy), rays)
        reach = np.broadcast_to(np.asarray(max_range, np.float64), start.shape[:-1]).reshape(-1)
        return self.world.cast(
            start.reshape(-1, 3), along.reshape(-1, 3), reach, copy=copy, own_body=self.own_body[copy]
        )


class Sensor(Protocol):
    """A sensor: built once, asked at its rate. The class names its configuration in `Config`.

    `SEES_SCENE = False`: the sensor casts no rays, so up to one second of motion is passed in one call. `WAITS = True`:
    the sensor casts rays but may also be batched, if nothing in the scene moves and no mission uses it.
    `ASKS_SCENE = False`: it is asked at its own tick, but nothing has to be moved in the scene for it.
    `EVENTS = True`: it tells what has happened since it was asked last, and is asked when it is due alone.
    `OF_A_RUN = True`: what it tells is of a run; at a pose alone (`Simulation.observe`) it has nothing to say, as
    `EVENTS` have not.
    `ONE_VEHICLE = True`: it reads for one vehicle and its copies only; vehicles that carry it are not moved together.
    `ALTITUDE = "name"`: the part of a reading that is the altitude where the sensor looks down; `""`: its data are the
    range along -z, so that it also serves to follow a wall. Guidance asks for it.
    `FIXES = True`: a valid reading is a fix of the place, which a surfaced vehicle waits for.
    `MAY_LACK = True`: data of valid lanes may be NaN or infinite (no echo, nothing in sight); where a class does not
    say so, that stops the run.
    `ERRS = True`: data are the truth and an error that adds to it, which a scenario's `vary` may scale.
    """

    Config: ClassVar[type[SensorConfig]]
    SOURCES: ClassVar[tuple[str, ...]]
    """Where the model's equations come from, for `pelagos explain` and `pelagos cite`."""
    KERNELS: ClassVar[int]
    """Most kernels that a reading takes with the default configuration; a contract test counts them."""
    CASTS: ClassVar[int]
    """Places in these kernels where rays are cast: one, where hits are evaluated before anything gathers from them."""

    def __init__(self, config: Any, context: SensorContext) -> None: ...

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        ...
