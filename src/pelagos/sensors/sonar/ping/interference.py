"""Sonars that hear one another: who pings when, where and how loud, and what a receiver's beams get of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, line_np
from pelagos.acoustics.interference import band_overlap, is_arriving
from pelagos.acoustics.pulse import processing_gain_db
from pelagos.acoustics.spreading import from_db
from pelagos.errors import LookupFailed
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays
from pelagos.sensors.mount import Mounted, sensor_pose
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sonar.ping.fan import Lanes

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics

_LEAK: Final = 1e-4  # of the power on axis, beside all lobes; assumed
_BEHIND: Final = 1e-3  # of what would be heard in front, behind an array's baffle; assumed
_NEAREST: Final = 0.3  # [m], distance at which spreading begins
_HULL: Final = 2.0  # [m] before the other sonar, within which what stands in the way is its own vehicle; assumed


@dataclass(frozen=True)
class Apertures:
    """How beams hear or send, as rectangular apertures: arrays `(beams, 3)` of unit vectors in the sensor frame.

    Attributes:
        axis: where each beam looks.
        side, up: along the edges of its aperture.
        side_length, up_length: of the edges [wavelengths].
    """

    axis: NDArray[np.float64]
    side: NDArray[np.float64]
    up: NDArray[np.float64]
    side_length: float
    up_length: float

    @classmethod
    def of_fan(cls, rays: dict[str, NDArray[Any]], beams: int, across: float, along: float) -> Apertures:
        """Beams of a ray pattern: half-power widths `along` the thin direction of its strata and `across` it [rad]."""
        order = np.argsort(rays["beam"], kind="stable").reshape(beams, -1)
        weight = rays["weight"][order][..., None]
        middle = rays["direction"] + rays["aside"]  # rays stand at places across their beams
        axis = _unit((middle[order] * weight).sum(axis=1))
        thin = (rays["along"][order] * weight).sum(axis=1) / weight.sum(axis=1)
        round_ = np.linalg.norm(thin, axis=-1, keepdims=True) < 0.3  # a cone: any direction square to its axis
        thin = np.where(round_, np.eye(3)[np.abs(axis).argmin(axis=-1)], thin)
        up = _unit(thin - (thin * axis).sum(axis=-1, keepdims=True) * axis)
        return cls(axis, np.cross(up, axis), up, line_length(across), line_length(along))

    def power(self, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """One-way power pattern `(..., beams)` in directions `(..., 3)`, 1 on axis."""
        side, up, ahead = (direction @ v.T for v in (self.side, self.up, self.axis))
        pattern = (line_np(side, self.side_length) * line_np(up, self.up_length)) ** 2
        return np.asarray(np.maximum(pattern, _LEAK) * np.where(ahead > 0.0, 1.0, _BEHIND))


@dataclass(frozen=True)
class Emitter:
    """A sonar as others hear it.

    Attributes:
        path: "agent.sensor".
        mounting: where it sits on its vehicle.
        apertures: its beams.
        frequency_hz, bandwidth_hz, pulse_s, source_level_db: of its pulse.
        period_ns: between two pings; the first is at t = 0.
        angle: for heads that turn, their direction about z [rad] at ticks `(m,)`.
    """

    path: str
    mounting: Mounted
    apertures: Apertures
    frequency_hz: float
    bandwidth_hz: float
    pulse_s: float
    source_level_db: float
    period_ns: int
    angle: Callable[[NDArray[np.int64]], NDArray[np.float64]] | None = None

    @property
    def agent(self) -> str:
        """The vehicle that carries it."""
        return self.path.split(".")[0]


@jit.struct
class Heard:
    """Other sonars by source and lane, a Dr.Jit struct.

    Attributes:
        distance: `Float`, sources by lanes [m].
        direction: `Array3f`, the same, world frame, from the receiver to the source.
        since: `Float`, the same: how long ago it has pinged when the receiver does [s].
        level: `Float`, sources by lanes by beams: intensity at the receiver without absorption, through both patterns,
            re the receiver's source level at 1 m.
        period, duration: `Float`, by source [s].
    """

    distance: Array
    direction: Array
    since: Array
    level: Array
    period: Array
    duration: Array

    @property
    def size_key(self) -> tuple[int, int, int]:
        """Sources, lanes and beams in three numbers."""
        return len(self.period), len(self.distance), len(self.level)


@dataclass
class Neighbours:
    """All sonars of a scenario; the simulation says how their vehicles move.

    Attributes:
        paths: of all sensors that can be heard, known before any is built.
        motion_of: agent -> its motion on the lanes of the sensor that is asked; set by the simulation.
    """

    paths: Sequence[str] = ()
    motion_of: Callable[[str], Kinematics] | None = None
    _emitters: dict[str, Emitter] = field(default_factory=dict)

    @property
    def emitters(self) -> Mapping[str, Emitter]:
        """Those that have been built, by path."""
        return self._emitters

    def add(self, emitter: Emitter) -> None:
        """Let a sonar be heard: one of each vehicle that carries it alike."""
        paths = emitter.path.members if isinstance(emitter.path, BatchPath) else (emitter.path,)
        self._emitters |= {path: replace(emitter, path=str(path)) for path in paths}

    def chosen(self, names: str | Iterable[str], own: str) -> list[str]:
        """The paths that a sonar `own` hears: those of other vehicles for "others", or those that are named.

        Raises:
            LookupFailed: there is no such sonar.
        """
        if isinstance(names, str):
            agent = own.split(".")[0]
            return [] if names == "none" else [p for p in self.paths if p.split(".")[0] != agent]
        chosen, where = list(names), "agents.{}.sensors.{}.hears".format(*own.split(".", 1))
        for name in chosen:
            if name not in self.paths:
                raise LookupFailed("sonar that can be heard", name, self.paths, where=where)
        return chosen

    def heard(self, own: Emitter, paths: Sequence[str], motion: Kinematics) -> Heard | None:
        """What arrives at a receiver; None where nothing of it lies in its band."""
        sources = [self._emitters[p] for p in paths if p != own.path]
        shares = [band_overlap(own.frequency_hz, own.bandwidth_hz, s.frequency_hz, s.bandwidth_hz) for s in sources]
        sources = [s for s, share in zip(sources, shares, strict=True) if share > 0.0]
        if not sources or self.motion_of is None:
            return None
        here, frame = _places(own, motion)
        tick, now = np.array(motion.tick).astype(np.int64), np.array(motion.t_ns).astype(np.int64)
        parts = []
        for source, share in zip(sources, (s for s in shares if s > 0.0), strict=True):
            there, their_frame = _places(source, self.motion_of(source.agent))
            way = there - here
            distance = np.maximum(np.linalg.norm(way, axis=-1), 1e-6)
            direction = way / distance[:, None]
            sent = source.apertures.power(_turned(their_frame, -direction, source, tick)).max(axis=-1)
            received = own.apertures.power(_turned(frame, direction, own, tick))  # (m, beams)
            level = share * _filtered(own, source) * 10.0 ** ((source.source_level_db - own.source_level_db) / 10.0)
            level = level * (sent / np.maximum(distance, _NEAREST) ** 2)[:, None] * received
            parts.append((distance, direction, (now % source.period_ns) * 1e-9, level))
        distance, direction, since, level = (np.stack(p) for p in zip(*parts, strict=True))
        made = Heard(
            jit.Float(distance.astype(np.float32).ravel()),
            jit.Array3f(np.ascontiguousarray(direction.reshape(-1, 3).T, dtype=np.float32)),
            jit.Float(since.astype(np.float32).ravel()),
            jit.Float(level.astype(np.float32).ravel()),
            jit.Float(np.array([s.period_ns * 1e-9 for s in sources], np.float32)),
            jit.Float(np.array([_duration(own, s) for s in sources], np.float32)),
        )
        dr.make_opaque(made)
        return made


def unblocked(caster: Caster, heard: Heard, lanes: Lanes) -> Heard:
    """Silence the sources that something stands before; the receiver's own hull does not count, nor the source's."""
    count = dr.width(lanes.position)
    lane = dr.arange(jit.UInt32, dr.width(heard.distance)) % count
    copy, own = dr.gather(jit.UInt32, lanes.copy, lane), dr.gather(jit.UInt32, lanes.own, lane)
    reach = dr.maximum(heard.distance - _HULL, 0.0)
    hits = caster.cast(Rays(dr.gather(jit.Array3f64, lanes.position, lane), heard.direction, reach,
                                             copy, own))  # fmt: skip
    heard.distance = dr.select(hits.valid, dr.inf, heard.distance)
    dr.eval(heard.distance)
    return heard


def interference_at(
    heard: Heard, lanes: Lanes, ping: Array, beam: Array, distance: Array, *, beams: int, bin_width: float
) -> Array:
    """Intensity of all other sonars' pulses in a cell, re the receiver's source level at 1 m.

    Args:
        ping, beam: `Int32`.
        distance: middle of the cell in range [m].
        beams: of a ping.
        bin_width: of the cell [m]: a shorter pulse falls into one cell.
    """
    lane, count = jit.UInt32(ping), dr.width(lanes.position)
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    time, shortest = (2.0 * distance + bin_width) / speed, 2.0 * bin_width / speed
    column = dr.minimum(jit.UInt32(beam), beams - 1)
    total = jit.Float(0)
    for k in range(dr.width(heard.period)):
        row = k * count + lane
        way = dr.gather(jit.Float, heard.distance, row)
        since, source = dr.gather(jit.Float, heard.since, row), jit.UInt32(k)
        period, duration = dr.gather(jit.Float, heard.period, source), dr.gather(jit.Float, heard.duration, source)
        level = dr.gather(jit.Float, heard.level, row * beams + column) * from_db(-loss * way)
        heard_now = (way < dr.inf) & is_arriving(time, way / speed, since, period, dr.maximum(duration, shortest))
        total += dr.select(heard_now, level, 0.0)
    return total


def _same(own: Emitter, source: Emitter) -> bool:
    keys = ("frequency_hz", "bandwidth_hz", "pulse_s")
    return all(getattr(own, k) == getattr(source, k) for k in keys)


def _filtered(own: Emitter, source: Emitter) -> float:
    """Part of a pulse's intensity behind the receiver's matched filter: all of its own kind, else as of noise."""
    return 1.0 if _same(own, source) else 10.0 ** (-processing_gain_db(own.bandwidth_hz, own.pulse_s) / 10.0)


def _duration(own: Emitter, source: Emitter) -> float:
    """Duration [s] of a pulse behind the receiver's matched filter."""
    return 1.0 / own.bandwidth_hz if _same(own, source) else max(source.pulse_s, 1.0 / own.bandwidth_hz)


def _places(emitter: Emitter, motion: Kinematics) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where a sonar is `(m, 3)` [m], and its attitude `(m, 4)`."""
    position, attitude = sensor_pose(motion, emitter.mounting)
    return np.array(position).T, np.array(attitude).T


def _turned(
    attitude: NDArray[np.float64], direction: NDArray[np.float64], emitter: Emitter, tick: NDArray[np.int64]
) -> NDArray[np.float64]:
    """World directions `(m, 3)` in the sensor frame, of the head where that turns."""
    q, d = (jit.Array4f64 if v.shape[-1] == 4 else jit.Array3f64 for v in (attitude, direction))
    local = np.array(rotate_back(q(np.ascontiguousarray(attitude.T)), d(np.ascontiguousarray(direction.T)))).T
    if emitter.angle is None:
        return local
    angle = emitter.angle(tick)
    c, s = np.cos(angle), np.sin(angle)
    x, y = local[:, 0].copy(), local[:, 1].copy()
    return np.stack([c * x + s * y, c * y - s * x, local[:, 2]], axis=-1)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
