"""Sonars that hear one another: who pings when, where and how loud, and what a receiver's beams get of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.interference import Sent, band_overlap, through_filter
from pelagos.errors import LookupFailed
from pelagos.jit import Array
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sonar.ping.emitter import Apertures, Emitter
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.placed import Placed, Pose, ReceiverLanes, rotated
from pelagos.sensors.sonar.ping.vehicle_noise import NoiseSource

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics

_NEAREST: Final = 0.3  # [m], distance at which spreading begins
_HULL: Final = 2.0  # [m] before the other sonar, within which what stands in the way is its own vehicle; assumed


@jit.struct
class Heard:
    """Other sonars by lane, a Dr.Jit struct: those that a lane hears, the first of each lane, the second, and so on.

    Attributes:
        distance: `Float`, places in the lists by lanes [m]; infinite where a lane hears no more.
        direction: `Array3f`, the same, world frame, from the receiver to the source.
        since: `Float`, the same: how long ago it has pinged when the receiver does [s].
        level: `Float`, places by lanes by beams: intensity at the receiver without absorption, through both patterns,
            re the receiver's source level at 1 m, of a pulse that its filter compresses.
        source: `UInt32`, places by lanes: the row of what follows.
        period, frequency: `Float`, by source [s], [Hz].
        signal: `Float`, two a sample: the pulses behind the receiver's filter, one after another.
        first, taps: `UInt32`, by source: where its pulse begins in `signal`, and its samples.
        lead, step: `Float`, by source, see `Filtered` [s].
    """

    distance: Array
    direction: Array
    since: Array
    level: Array
    source: Array
    period: Array
    frequency: Array
    signal: Array
    first: Array
    taps: Array
    lead: Array
    step: Array

    @property
    def size_key(self) -> tuple[int, int, int]:
        """Sources, the most that a lane hears, lanes and beams in three numbers."""
        return len(self.period), len(self.distance), len(self.level)


@dataclass
class Neighbours:
    """All sonars of a scenario; the simulation says how their vehicles move.

    Attributes:
        paths: of all sensors that can be heard, known before any is built.
        motion_of: agent -> its motion on the lanes of the sensor that is asked; set by the simulation.
        motions_of: agent -> the motion of all that are moved together with it, and its rows of each tick; likewise.
        noises: vehicles that make noise, by name.
    """

    paths: Sequence[str] = ()
    motion_of: Callable[[str], Kinematics] | None = None
    motions_of: Callable[[str], tuple[Kinematics, slice]] | None = None
    noises: Mapping[str, NoiseSource] = field(default_factory=dict)
    _emitters: dict[str, Emitter] = field(default_factory=dict)
    _pulses: dict[tuple[Any, ...], Pulses] = field(default_factory=dict)

    @property
    def emitters(self) -> Mapping[str, Emitter]:
        """Those that have been built, by path."""
        return self._emitters

    def add(self, emitter: Emitter) -> None:
        """Let a sonar be heard: one of each vehicle that carries it alike."""
        paths = emitter.path.members if isinstance(emitter.path, BatchPath) else (emitter.path,)
        shared = next((e.apertures for e in self._emitters.values() if e.apertures.same(emitter.apertures)), None)
        if shared is not None:
            emitter = replace(emitter, apertures=shared)
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

    def heard(self, own: Emitter, paths: Sequence[str], motion: Kinematics, *, others: bool = True) -> Heard | None:
        """Signal at a receiver; None where nothing of it lies in its band.

        Args:
            own: the receiver; one of each vehicle that carries it alike.
            paths: the sonars that any of them hears.
            motion: of the receiver's vehicles.
            others: a vehicle does not hear any sonar of its own; else it does not hear the receiver alone.
        """
        carriers = own.path.members if isinstance(own.path, BatchPath) else (own.path,)
        sources = [self._emitters[p] for p in paths if len(carriers) > 1 or p != own.path]
        sources = [s for s in sources if _shares(own, s)]
        if not sources or self.motion_of is None:
            return None
        dr.eval(motion.position, motion.attitude)
        copies = len(own.path.environments) if isinstance(own.path, BatchPath) else 0
        lanes = ReceiverLanes.of(motion, len(carriers), copies)
        ours, near = Placed.of([own], [lanes.pose(motion)]), Placed.of(sources, self._poses(sources, lanes))
        tick, now = (np.array(v).astype(np.int64) for v in (motion.tick, motion.t_ns))
        way = near.position - ours.position
        distance = np.maximum(np.linalg.norm(way, axis=-1), 1e-6)  # (sources, m)
        audible = _loudest(sources, distance) >= own.faintest_db
        if len(carriers) > 1:
            theirs, mine = (
                [_by_vehicle(p) if others else p for p in found] for found in ([s.path for s in sources], carriers)
            )
            number = {name: i for i, name in enumerate(mine)}
            audible &= np.array([[number.get(name, -1)] for name in theirs]) != lanes.carrier
        most = int(audible.sum(axis=0).max())
        if most == 0:
            return None
        # of each lane those that it hears, in the order of the scenario: a vehicle hears them in the order as if alone
        chosen = np.argsort(~audible, axis=0, kind="stable")[:most]  # (most, m)
        lane, there = np.arange(chosen.shape[1]), np.take_along_axis(audible, chosen, axis=0)
        distance = distance[chosen, lane]
        direction = way[chosen, lane] / distance[..., None]
        towards_us = _turned(near.attitude[chosen, lane], -direction, [s.angle for s in sources], chosen, tick)
        sent = np.empty(distance.shape)
        for apertures, rows in _alike(sources).items():
            at = np.isin(chosen, rows)
            sent[at] = apertures.loudest(towards_us[at])
        gain = 10.0 ** ((np.array([s.source_level_db for s in sources]) - own.source_level_db) / 10.0)
        level = gain[chosen] * sent / np.maximum(distance, _NEAREST) ** 2
        since = (now % np.array([s.period_ns for s in sources])[chosen]) * 1e-9
        facing = np.broadcast_to(ours.attitude, (*distance.shape, 4))
        from_them = _turned(facing, direction, [own.angle], np.zeros_like(chosen), tick)
        received = own.apertures.power(from_them) * level[..., None]  # (most, m, beams)
        coming = Arriving(
            np.where(there, distance, np.inf), direction, np.where(there, since, 0.0),
            np.where(there[..., None], received, 0.0), np.where(there, chosen, 0),
        )  # fmt: skip
        return _heard(sources, coming, self._pulses_of(own, sources))

    def _poses(self, sources: Sequence[Emitter], lanes: ReceiverLanes) -> list[Pose]:
        """Positions and attitudes of the vehicles of sources on the receiver's lanes."""
        found: dict[str, Pose] = {}
        known: dict[int, Pose] = {}  # of all that are moved together, by the first tick's lanes
        assert self.motion_of is not None
        for agent in dict.fromkeys(source.agent for source in sources):
            if self.motions_of is None:
                found[agent] = lanes.pose(self.motion_of(agent))
                continue
            whole, rows = self.motions_of(agent)
            if id(whole) not in known:
                known[id(whole)] = Pose.of(whole)
            found[agent] = known[id(whole)].of_rows(rows, lanes)
        return [found[source.agent] for source in sources]

    def _pulses_of(self, own: Emitter, sources: Sequence[Emitter]) -> Pulses:
        """All pulses that may be heard behind the filter of `own`: made once."""
        key = (own.sent, *(s.sent for s in sources))
        if key not in self._pulses:
            self._pulses[key] = Pulses.of(own.sent, [s.sent for s in sources])
        return self._pulses[key]


@dataclass(frozen=True)
class Pulses:
    """Pulses behind a filter: all samples on the device, and where each pulse's are (first, taps, lead, step)."""

    signal: Array
    rows: Mapping[Sent, tuple[int, int, float, float]]

    @classmethod
    def of(cls, own: Sent, others: Iterable[Sent]) -> Pulses:
        """Each different one once."""
        rows: dict[Sent, tuple[int, int, float, float]] = {}
        samples: list[NDArray[np.complex64]] = []
        for sent in dict.fromkeys(others):
            found = through_filter(own, sent)
            rows[sent] = (sum(map(len, samples)), len(found.signal), found.lead_s, found.step_s)
            samples.append(found.signal)
        return cls(jit.from_numpy(jit.Float, np.concatenate(samples).view(np.float32)), rows)


@dataclass(frozen=True)
class Arriving:
    """Arrays `(places, m, ...)`, see `Heard`."""

    distance: NDArray[np.float64]
    direction: NDArray[np.float64]
    since: NDArray[np.float64]
    level: NDArray[np.float64]
    source: NDArray[np.int64]


def _heard(sources: Sequence[Emitter], coming: Arriving, pulses: Pulses) -> Heard:
    """Places and sources up to powers of two, with silent ones: a ping is recorded for few different numbers."""

    def padded(values: NDArray[Any], filler: float = 0.0) -> NDArray[np.float32]:
        silent = (1 << (len(values) - 1).bit_length()) - len(values)
        width = ((0, silent), *((0, 0) for _ in values.shape[1:]))
        return np.pad(values.astype(np.float32), width, constant_values=filler)

    rows = np.array([pulses.rows[s.sent] for s in sources])
    way = padded(coming.direction)
    way[len(coming.direction) :, :, 0] = 1.0
    made = Heard(
        jit.Float(padded(coming.distance, np.inf).ravel()),
        jit.Array3f(np.ascontiguousarray(way.reshape(-1, 3).T)),
        jit.Float(padded(coming.since).ravel()),
        jit.Float(padded(coming.level).ravel()),
        jit.UInt32(padded(coming.source).ravel().astype(np.uint32)),
        jit.Float(padded(np.array([s.period_ns * 1e-9 for s in sources]), 1.0)),
        jit.Float(padded(np.array([s.frequency_hz for s in sources]))),
        pulses.signal,
        jit.UInt32(padded(rows[:, 0]).astype(np.uint32)),
        jit.UInt32(padded(rows[:, 1]).astype(np.uint32)),
        jit.Float(padded(rows[:, 2])),
        jit.Float(padded(rows[:, 3], 1.0)),
    )
    jit.align(made)
    return made


def _alike(sources: Sequence[Emitter]) -> dict[Apertures, list[int]]:
    """Rows of the sources that share their apertures."""
    rows: dict[Apertures, list[int]] = {}
    for k, source in enumerate(sources):
        rows.setdefault(source.apertures, []).append(k)
    return rows


def _shares(own: Emitter, source: Emitter) -> bool:
    return band_overlap(own.frequency_hz, own.bandwidth_hz, source.frequency_hz, source.bandwidth_hz) > 0.0


def _loudest(sources: Sequence[Emitter], distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Levels at distances `(sources, m)` [dB re 1 uPa], at the most: on axis, in fresh and warm water."""
    least = np.array([[0.5 * _absorption(s.frequency_hz)] for s in sources])
    level = np.array([[s.source_level_db] for s in sources])
    return np.asarray(level - 20.0 * np.log10(np.maximum(distance, _NEAREST)) - least * distance)


def _by_vehicle(path: str) -> str:
    return path.split(".")[0]


@lru_cache(maxsize=64)
def _absorption(frequency_hz: float) -> float:
    water = jit.Float64(20.0), jit.Float64(5.0), jit.Float64(0.0)
    return float(np.array(absorption(jit.Float64(frequency_hz), *water))[0])


def silence_blocked(caster: Caster, heard: Heard, lanes: Lanes) -> Heard:
    """Silence the sources that something stands before; the receiver's own hull does not count, nor the source's."""
    count = dr.width(lanes.position)
    lane = dr.arange(jit.UInt32, dr.width(heard.distance)) % count
    copy, own = dr.gather(jit.UInt32, lanes.copy, lane), dr.gather(jit.UInt32, lanes.own, lane)
    reach = dr.select(heard.distance < dr.inf, dr.maximum(heard.distance - _HULL, 0.0), 0.0)
    hits = caster.cast(Rays(dr.gather(jit.Array3f64, lanes.position, lane), heard.direction, reach,
                                             copy, own))  # fmt: skip
    heard.distance = dr.select(hits.valid, dr.inf, heard.distance)
    dr.eval(heard.distance)
    return heard


def _turned(
    attitude: NDArray[np.float64],
    direction: NDArray[np.float64],
    angles: Sequence[Callable[[NDArray[np.int64]], NDArray[np.float64]] | None],
    which: NDArray[np.int64],
    tick: NDArray[np.int64],
) -> NDArray[np.float64]:
    """World directions `(places, m, 3)` in the frames of sonars, of their heads where those turn.

    Args:
        attitude: `(places, m, 4)` of the sonars.
        direction: `(places, m, 3)`.
        angles: directions of heads at ticks, by sonar.
        which: `(places, m)` rows of `angles`.
        tick: `(m,)`.
    """
    local = rotated(attitude * np.array([1.0, -1.0, -1.0, -1.0]), direction)
    for k, angle_at in enumerate(angles):
        if angle_at is not None:
            place, lane = np.nonzero(which == k)
            angle = angle_at(tick[lane])
            c, s = np.cos(angle), np.sin(angle)
            x, y = local[place, lane, 0], local[place, lane, 1]
            local[place, lane, 0], local[place, lane, 1] = c * x + s * y, c * y - s * x
    return local
