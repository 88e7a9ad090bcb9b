"""Noise of vehicles, one's own and others', as the beams of a sonar hear it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.spreading import from_db
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sonar.ping.emitter import Emitter, headed
from pelagos.sensors.sonar.ping.fan import Lanes

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sensors.sensor import Kinematics
    from pelagos.sensors.sonar.ping.interference import Neighbours

_NEAREST: Final = 1.0  # [m], nearer than which a source level says nothing
_UNNOTICED: Final = 1e-3  # of a sonar's other noise: what is fainter in every beam is left out


@dataclass(frozen=True)
class NoiseSource:
    """A vehicle that makes noise.

    Attributes:
        level: (frequency [Hz], speeds through the water [m/s]) -> spectral source levels [dB re 1 uPa^2/Hz at 1 m].
        hull_m: how far from its origin its own hull reaches, which stands in nobody's way [m].
    """

    level: Callable[[float, NDArray[np.float64]], NDArray[np.float64]]
    hull_m: float


@jit.struct
class VehicleNoise:
    """Noise by source and lane, a Dr.Jit struct.

    Attributes:
        distance: `Float`, sources by lanes [m]; infinite where nothing is heard.
        direction: `Array3f`, the same, world frame, from the sonar to the source.
        level: `Float`, sources by lanes by beams: noise intensity without absorption, behind matched filter and
            beamformer, re the sonar's source level at 1 m.
        hull: `Float`, by source, see `NoiseSource`.
    """

    distance: Array
    direction: Array
    level: Array
    hull: Array

    @property
    def size_key(self) -> tuple[int, int, int]:
        """Sources, lanes and beams in three numbers."""
        return len(self.hull), len(self.distance), len(self.level)


class Ear(Protocol):
    """A sonar's keys for the noise of vehicles."""

    @property
    def vehicle_noise(self) -> str | None:
        """Whose noise is heard: "all", "others", "own" or "none"; None as "none", which goes without saying."""

    @property
    def frequency_hz(self) -> float:
        """Middle of its band, where noise is taken [Hz]."""


class Bystanders:
    """Vehicles whose noise a sonar hears.

    Args:
        ear: the sonar's keys.
        own: the sonar.
        neighbours: vehicles that make noise, and where they are; None: there are none.
        ocean: whose current vehicles' speeds through the water count from.
        behind_filter: of noise of one spectral density from one direction, on the axis of a beam, what is left behind
            the matched filter, re the source level at 1 m.
        noise: all other noise, the same way.
    """

    def __init__(
        self, ear: Ear, own: Emitter, neighbours: Neighbours | None, ocean: Ocean, *, behind_filter: float, noise: float
    ) -> None:
        self._frequency, self._own, self._neighbours, self._ocean = ear.frequency_hz, own, neighbours, ocean
        self._gain, self._faint = behind_filter, _UNNOTICED * noise
        path = own.path
        members: tuple[str, ...] = (path,)
        self._copies = 1
        if isinstance(path, BatchPath):
            members, self._copies = path.members, len(path.environments)
        self._carriers = [p.split(".")[0] for p in members]
        makers = {} if neighbours is None else neighbours.noises
        self._sources = _chosen(makers, ear.vehicle_noise, self._carriers)
        if makers and ear.vehicle_noise not in (None, "all"):
            left_out = sorted(set(makers) - set(self._sources))
            whose = ", ".join(left_out[:3]) + (" and more" if len(left_out) > 3 else "")
            if whose:
                message = f"{path}: vehicle_noise {ear.vehicle_noise!r} leaves out the noise of {whose}"
                warnings.warn(message, ValidityWarning, stacklevel=4)
        self._which = ear.vehicle_noise

    @property
    def some(self) -> bool:
        """Whether there are any."""
        return bool(self._sources)

    def heard(self, motion: Kinematics) -> VehicleNoise | None:
        """Their noise on every lane of the sonar's vehicle; None where nobody would notice it."""
        neighbours = self._neighbours
        if not self._sources or neighbours is None or neighbours.motion_of is None:
            return None
        position, attitude = sensor_pose(motion, self._own.mounting)
        motions = [neighbours.motion_of(agent) for agent in self._sources]
        dr.eval(position, attitude, [(m.position, m.attitude, m.velocity, m.copy) for m in motions])
        here, q, copy = jit.to_rows(position), jit.to_rows(attitude), np.array(motion.copy).astype(np.int64)
        tick = np.array(motion.tick).astype(np.int64)
        carrier = copy // self._copies if len(self._carriers) > 1 else np.zeros(len(copy), np.int64)
        at = _Here(here, q, copy, tick, carrier)
        lanes = [at.lanes_of(dr.width(m.position), self._copies, len(self._carriers)) for m in motions]
        places = np.concatenate([jit.to_rows(m.position)[lane] for m, lane in zip(motions, lanes, strict=True)])
        copies = np.concatenate([np.array(m.copy)[lane] for m, lane in zip(motions, lanes, strict=True)])
        t = jit.from_numpy(jit.Float64, np.tile(np.array(motion.t_ns) * 1e-9, len(motions)))
        place = jit.Array3f64(*(jit.from_numpy(jit.Float64, part) for part in places.T))
        water = jit.to_rows(self._ocean.current(place, t, jit.from_numpy(jit.UInt32, copies)))
        water = np.broadcast_to(water, places.shape).reshape(len(motions), -1, 3)
        found = [
            self._of(agent, source, _Moving.of(m, lane, w), at)
            for (agent, source), m, lane, w in zip(self._sources.items(), motions, lanes, water, strict=True)
        ]
        kept = [row for row in found if row.level.any()]
        return _struct(kept, len(here)) if kept else None

    def _of(self, agent: str, source: NoiseSource, moving: _Moving, here: _Here) -> _Row:
        """The noise of one vehicle."""
        place = moving.position
        way = place - here.position
        distance = np.linalg.norm(way, axis=-1)
        direction = np.where(distance[:, None] > 1e-6, way, (0.0, 0.0, 1.0)) / np.maximum(distance, 1e-6)[:, None]
        density = source.level(self._frequency, np.linalg.norm(moving.through, axis=-1))
        density = density - 20.0 * np.log10(np.maximum(distance, _NEAREST))
        local = rotate_back_np(here.attitude, direction)
        if self._own.angle is not None:
            local = headed(local, self._own.angle(here.tick))
        level = 10.0 ** (density[:, None] / 10.0) * self._gain * self._own.apertures.power(local)
        mine = np.array([name == agent for name in self._carriers])[here.carrier]
        deaf = mine if self._which == "others" else ~mine if self._which == "own" else np.zeros_like(mine)
        deaf = deaf | (place[:, 2] > source.hull_m) | (level.max(axis=-1) < self._faint)
        return _Row(distance, direction, np.where(deaf[:, None], 0.0, level), source.hull_m)


@dataclass(frozen=True)
class _Here:
    """The sonar by lane: place and attitude in the world, row of the fleet, tick, and which vehicle carries it."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    copy: NDArray[np.int64]
    tick: NDArray[np.int64]
    carrier: NDArray[np.int64]

    def lanes_of(self, count: int, copies: int, carriers: int) -> NDArray[np.int64]:
        """The lane of the same copy and tick among `count` lanes of another vehicle, by lane."""
        lane = np.arange(len(self.copy))
        return lane if count == len(lane) else lane // (copies * carriers) * copies + self.copy % copies


@dataclass(frozen=True)
class _Moving:
    """A vehicle that makes noise, by lane of the sonar: its place, and its velocity through the water, world frame."""

    position: NDArray[np.float64]
    through: NDArray[np.float64]

    @classmethod
    def of(cls, motion: Kinematics, lane: NDArray[np.int64], water: NDArray[np.float64]) -> _Moving:
        """By the motion of the vehicle, of which `lane` counts, in a current."""
        over_ground = rotate_np(jit.to_rows(motion.attitude)[lane], jit.to_rows(motion.velocity)[lane])
        return cls(jit.to_rows(motion.position)[lane], over_ground - water)


@dataclass(frozen=True)
class _Row:
    """One source: arrays by lane, `level` also by beam; see `VehicleNoise`."""

    distance: NDArray[np.float64]
    direction: NDArray[np.float64]
    level: NDArray[np.float64]
    hull_m: float


def noise_by_beam(caster: Caster, noise: VehicleNoise, lanes: Lanes, beams: int) -> Array:
    """Noise intensity of vehicles for each of lanes by beams, re the source level at 1 m.

    What stands in the way keeps it off, but for the sonar's own hull and the source's; in the air nothing is heard.
    Sources are summed in one order.
    """
    count = dr.width(lanes.position)
    row = dr.arange(jit.UInt32, dr.width(noise.distance))
    lane = row % count
    copy, own = dr.gather(jit.UInt32, lanes.copy, lane), dr.gather(jit.UInt32, lanes.own, lane)
    clear = noise.distance - dr.gather(jit.Float, noise.hull, row // count)
    reach = dr.select(noise.distance < dr.inf, dr.maximum(clear, 0.0), 0.0)
    if lanes.wet is not None:
        reach = dr.select(dr.gather(jit.Bool, lanes.wet, lane), reach, 0.0)
    start = dr.gather(jit.Array3f64, lanes.position, lane)
    hits = caster.cast(Rays(start, noise.direction, reach, copy, own))
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    there = (noise.distance < dr.inf) & ~hits.valid
    if lanes.wet is not None:
        there &= dr.gather(jit.Bool, lanes.wet, lane)
    kept = dr.select(there, from_db(-loss * dr.select(there, noise.distance, 0.0)), 0.0)
    dr.eval(kept)
    cell = dr.arange(jit.UInt32, count * beams)
    sources = dr.width(noise.hull)

    def add(k: Array, total: Array) -> tuple[Array, Array]:
        share = dr.gather(jit.Float, kept, k * count + cell // beams)
        return k + 1, dr.fma(dr.gather(jit.Float, noise.level, k * (count * beams) + cell), share, total)

    state = (dr.zeros(jit.UInt32, count * beams), dr.zeros(jit.Float, count * beams))
    total: Array = dr.while_loop(state, lambda k, _: k < sources, add, mode="symbolic", labels=("source", "sum"))[1]
    dr.eval(total)
    return total


def _chosen(makers: Mapping[str, NoiseSource], which: str | None, carriers: Sequence[str]) -> Mapping[str, NoiseSource]:
    """Vehicles that any of some carriers may hear."""
    if which in (None, "none"):
        return {}
    if which == "own":
        return {name: source for name, source in makers.items() if name in carriers}
    alone = set(carriers) if which == "others" and len(carriers) == 1 else set()
    return {name: source for name, source in makers.items() if name not in alone}


def _struct(rows: Sequence[_Row], lanes: int) -> VehicleNoise:
    """Sources side by side, and silent ones up to a power of two: a ping is recorded for few different numbers."""
    silent = (1 << (len(rows) - 1).bit_length()) - len(rows)
    beams = rows[0].level.shape[1]
    nothing = _Row(np.full(lanes, np.inf), np.tile((1.0, 0.0, 0.0), (lanes, 1)), np.zeros((lanes, beams)), 0.0)
    rows = [*rows, *[nothing] * silent]
    whole: Callable[[str], NDArray[Any]] = lambda name: np.concatenate([getattr(r, name) for r in rows])
    made = VehicleNoise(
        jit.Float(whole("distance").astype(np.float32)),
        jit.Array3f(np.ascontiguousarray(whole("direction").T.astype(np.float32))),
        jit.Float(whole("level").astype(np.float32).ravel()),
        jit.Float(np.array([r.hull_m for r in rows], np.float32)),
    )
    jit.align(made)
    return made
