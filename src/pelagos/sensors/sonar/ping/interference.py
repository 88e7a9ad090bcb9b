"""Sonars that hear one another: who pings when, where and how loud, and what a receiver's beams get of it."""

from __future__ import annotations

import math
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
from pelagos.sensors.sonar.ping.vehicle_noise import NoiseSource

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics

_NEAREST: Final = 0.3  # [m], distance at which spreading begins
_HULL: Final = 2.0  # [m] before the other sonar, within which what stands in the way is its own vehicle; assumed


@jit.struct
class Heard:
    """Other sonars by source and lane, a Dr.Jit struct.

    Attributes:
        distance: `Float`, sources by lanes [m].
        direction: `Array3f`, the same, world frame, from the receiver to the source.
        since: `Float`, the same: how long ago it has pinged when the receiver does [s].
        level: `Float`, sources by lanes by beams: intensity at the receiver without absorption, through both patterns,
            re the receiver's source level at 1 m, of a pulse that its filter compresses.
        period, frequency: `Float`, by source [s], [Hz].
        signal: `Float`, two a sample: the pulses behind the receiver's filter, one after another.
        first, taps: `UInt32`, by source: where its pulse begins in `signal`, and its samples.
        lead, step: `Float`, by source, see `Filtered` [s].
    """

    distance: Array
    direction: Array
    since: Array
    level: Array
    period: Array
    frequency: Array
    signal: Array
    first: Array
    taps: Array
    lead: Array
    step: Array

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
        noises: vehicles that make noise, by name.
    """

    paths: Sequence[str] = ()
    motion_of: Callable[[str], Kinematics] | None = None
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

    def heard(self, own: Emitter, paths: Sequence[str], motion: Kinematics) -> Heard | None:
        """Signal at a receiver; None where nothing of it lies in its band."""
        sources = [self._emitters[p] for p in paths if p != own.path]
        sources = [s for s in sources if _shares(own, s)]
        if not sources or self.motion_of is None:
            return None
        pulses = self._pulses_of(own, sources)
        motions = [self.motion_of(source.agent) for source in sources]
        dr.eval(motion.position, motion.attitude, [(m.position, m.attitude) for m in motions])
        ours, near = _Placed.of([own], [motion]), _Placed.of(sources, motions)
        tick, now = (np.array(v).astype(np.int64) for v in (motion.tick, motion.t_ns))
        way = near.position - ours.position
        distance = np.maximum(np.linalg.norm(way, axis=-1), 1e-6)  # (sources, m)
        heard = [k for k, s in enumerate(sources) if _loudest(s, float(distance[k].min())) >= own.faintest_db]
        if not heard:
            return None
        sources, distance = [sources[k] for k in heard], distance[heard]
        direction = way[heard] / distance[..., None]
        towards_us = _turned(near.attitude[heard], -direction, sources, tick)
        sent = np.empty(distance.shape)
        for apertures, rows in _alike(sources).items():
            sent[rows] = apertures.loudest(towards_us[rows].reshape(-1, 3)).reshape(len(rows), -1)
        gain = 10.0 ** ((np.array([s.source_level_db for s in sources]) - own.source_level_db) / 10.0)
        level = gain[:, None] * sent / np.maximum(distance, _NEAREST) ** 2
        since = (now % np.array([[s.period_ns] for s in sources])) * 1e-9
        from_them = _turned(np.broadcast_to(ours.attitude, (*distance.shape, 4)), direction, [own] * len(sources), tick)
        received = own.apertures.power(from_them) * level[..., None]  # (sources, m, beams)
        return _heard(sources, Arriving(distance, direction, since, received), pulses)

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
    """Arrays `(sources, m, ...)`, see `Heard`."""

    distance: NDArray[np.float64]
    direction: NDArray[np.float64]
    since: NDArray[np.float64]
    level: NDArray[np.float64]


def _heard(sources: Sequence[Emitter], coming: Arriving, pulses: Pulses) -> Heard:
    """Sources side by side, and silent ones up to a power of two: a ping is recorded for few different numbers."""
    silent = (1 << (len(sources) - 1).bit_length()) - len(sources)

    def padded(values: NDArray[Any], filler: float = 0.0) -> NDArray[np.float32]:
        width = ((0, silent), *((0, 0) for _ in values.shape[1:]))
        return np.pad(values.astype(np.float32), width, constant_values=filler)

    rows = np.array([pulses.rows[s.sent] for s in sources])
    way = padded(coming.direction)
    way[len(sources) :, :, 0] = 1.0
    made = Heard(
        jit.Float(padded(coming.distance, np.inf).ravel()),
        jit.Array3f(np.ascontiguousarray(way.reshape(-1, 3).T)),
        jit.Float(padded(coming.since).ravel()),
        jit.Float(padded(coming.level).ravel()),
        jit.Float(padded(np.array([s.period_ns * 1e-9 for s in sources]), 1.0)),
        jit.Float(padded(np.array([s.frequency_hz for s in sources]))),
        pulses.signal,
        jit.UInt32(padded(rows[:, 0]).astype(np.uint32)),
        jit.UInt32(padded(rows[:, 1]).astype(np.uint32)),
        jit.Float(padded(rows[:, 2])),
        jit.Float(padded(rows[:, 3], 1.0)),
    )
    dr.make_opaque(made)
    return made


def _alike(sources: Sequence[Emitter]) -> dict[Apertures, list[int]]:
    """Rows of the sources that share their apertures."""
    rows: dict[Apertures, list[int]] = {}
    for k, source in enumerate(sources):
        rows.setdefault(source.apertures, []).append(k)
    return rows


def _shares(own: Emitter, source: Emitter) -> bool:
    return band_overlap(own.frequency_hz, own.bandwidth_hz, source.frequency_hz, source.bandwidth_hz) > 0.0


def _loudest(source: Emitter, distance: float) -> float:
    """Level at a distance [dB re 1 uPa], at the most: on axis, in fresh and warm water."""
    least = 0.5 * _absorption(source.frequency_hz)
    return source.source_level_db - 20.0 * math.log10(max(distance, _NEAREST)) - least * distance


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


@dataclass(frozen=True)
class _Placed:
    """Places of sonars `(sources, m, 3)` [m], and their attitudes `(sources, m, 4)`."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]

    @classmethod
    def of(cls, emitters: Sequence[Emitter], motions: Sequence[Kinematics]) -> _Placed:
        """Of evaluated motions."""
        arm, turn = (
            np.array([getattr(e.mounting, name) for e in emitters], dtype=np.float64)[:, None]
            for name in ("position_m", "q_body_sensor")
        )
        body, q = (np.stack([_rows(getattr(m, name)) for m in motions]) for name in ("position", "attitude"))
        w, v, w2, v2 = q[..., :1], q[..., 1:], turn[..., :1], turn[..., 1:]
        real = w * w2 - (v * v2).sum(axis=-1, keepdims=True)
        return cls(body + _rotated(q, arm), np.concatenate([real, w * v2 + w2 * v + np.cross(v, v2)], axis=-1))


def _rows(vectors: Array) -> NDArray[np.float64]:
    """Evaluated vectors as rows: component by component no kernel is needed for it."""
    return np.stack([np.array(part) for part in vectors], axis=-1)


def _rotated(q: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(q) v for `(..., 4)` and `(..., 3)`."""
    t = 2.0 * np.cross(q[..., 1:], vector)
    return np.asarray(vector + q[..., :1] * t + np.cross(q[..., 1:], t))


def _turned(
    attitude: NDArray[np.float64], direction: NDArray[np.float64], emitters: Sequence[Emitter], tick: NDArray[np.int64]
) -> NDArray[np.float64]:
    """World directions `(sources, m, 3)` in the sensor frames, of the heads where those turn."""
    local = _rotated(attitude * np.array([1.0, -1.0, -1.0, -1.0]), direction)
    for k, emitter in enumerate(emitters):
        if emitter.angle is not None:
            angle = emitter.angle(tick)
            c, s = np.cos(angle), np.sin(angle)
            x, y = local[k, :, 0].copy(), local[k, :, 1].copy()
            local[k, :, 0], local[k, :, 1] = c * x + s * y, c * y - s * x
    return local
