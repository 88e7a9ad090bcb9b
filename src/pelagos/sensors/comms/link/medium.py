"""The water between modems: who is in it, and the links between them, traced when they are needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.channel import spectral_level
from pelagos.acoustics.interference import band_overlap
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.math.so3 import rotate_np
from pelagos.ocean.surface_wind import surface_wind
from pelagos.sensors.comms.link.budget import NOTHING, HeardSignal, sum_arrivals, sum_db
from pelagos.sensors.comms.link.modem_port import FIRST_MMSI, ModemPort
from pelagos.sensors.comms.link.packet import BROADCAST
from pelagos.sensors.comms.link.water_paths import Paths, WaterPaths, doppler, sea_level, shift_arrivals
from pelagos.sensors.mount import Mounted, sensor_pose, sensor_velocity
from pelagos.sensors.noise import BatchPath

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics, SensorContext

_SHIPPING: Final = 0.5  # Wenz's, of 0 to 1
_MOVED: Final = 0.02  # of the distance that an end moves until a link is traced again
_MOVED_M: Final = 0.25  # [m], at least
_FRESH_S: Final = (
    60.0,
    2.0,
)  # how long a link holds: where nothing moves but its ends, and where something may stand in
_RAYS: Final = 256
_BOUNCES: Final = 6
_ADDRESSES: Final = 65_536


@dataclass(frozen=True)
class ModemPose:
    """Pose of a modem in every copy: `(n, 3)` [m], `(n, 4)`, `(n, 3)` [m/s] in the world."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]


@dataclass(frozen=True)
class _Link:
    paths: Paths
    ends: NDArray[np.float64]  # (1, 2, 3)
    t: float
    waters: int  # of the medium, when it was traced


@dataclass
class SharedMedium:
    """All modems of a scenario; the simulation says which run asks.

    Attributes:
        agents: names of all vehicles, in the scenario's order.
        modems: by path, in that order.
        traffic: of the run that asks at present.
        ticks: at which it asks.
        motions_of: agent -> the motion at the tick that is asked for of all rows that are moved with it, and which of
            them are its own; set by the simulation.
        place: bring the moving scene up to date; likewise.
        sonars: emitters whose pulses fall into modems' bands, by path.
        waters: counts oceans: links through another one hold no longer.
    """

    agents: Sequence[str] = ()
    modems: dict[str, ModemPort] = field(default_factory=dict)
    traffic: Any = None
    ticks: range = range(0)
    motions_of: Callable[[str], tuple[Any, slice]] | None = None
    place: Callable[[], None] = lambda: None
    sonars: Callable[[], Mapping[str, Any]] = field(default=dict)
    seed: int = 0
    dt_ns: int = 0
    copies: int = 1
    waters: int = 0
    _context: Any = None
    _given: dict[str, ModemPort] = field(default_factory=dict)  # with the addresses of the scenario
    _posed: dict[Any, tuple[Any, ModemPose]] = field(default_factory=dict)
    _own_rows: dict[str, NDArray[np.uint32]] = field(default_factory=dict)
    _tracers: dict[float, WaterPaths] = field(default_factory=dict)

    def add(self, port: ModemPort, context: SensorContext) -> None:
        """Let a modem take part: one of each vehicle that carries it alike.

        Raises:
            ScenarioError: another one has its address.
        """
        paths = port.path.members if isinstance(port.path, BatchPath) else (port.path,)
        rows = context.own_body.reshape(len(paths), -1)
        if self._context is not None and context.ocean is not self._context.ocean:
            self._tracers.clear()
            self.waters += 1
        self._context, self.seed, self.dt_ns, self.copies = context, context.seed, context.dt_ns, rows.shape[1]
        for path, own in zip(paths, rows, strict=True):
            self._given[path] = replace(port, path=str(path))
            self._own_rows[path] = own
        self._number()

    def _number(self) -> None:
        """Order the modems as the scenario does, and give addresses to those that have none."""
        place = {name: k for k, name in enumerate(self.agents)}
        ports = sorted(self._given.values(), key=lambda port: place.get(port.agent, 0))
        taken: dict[int, str] = {}
        for port in (p for p in ports if p.address >= 0):
            if port.address in taken:
                raise ScenarioError(
                    f"{port.path}: address {port.address} is that of {taken[port.address]} already; addresses are "
                    "unique; without `address` each modem has its own"
                )
            taken[port.address] = port.path
        free = (a for a in range(_ADDRESSES) if a not in taken)
        numbered = [port if port.address >= 0 else replace(port, address=next(free)) for port in ports]
        ships: dict[int, str] = {}
        for port in (p for p in ports if p.mmsi):
            assert port.mmsi is not None
            if port.mmsi in ships:
                raise ScenarioError(
                    f"{port.path}: MMSI {port.mmsi} is that of {ships[port.mmsi]} already; without `mmsi` each ship "
                    "has its own"
                )
            ships[port.mmsi] = port.path
        unused = (number for number in count(FIRST_MMSI) if number not in ships)
        numbered = [replace(port, mmsi=next(unused)) if port.mmsi == 0 else port for port in numbered]
        self.modems.clear()
        self.modems |= {port.path: port for port in numbered}

    def check_names(self) -> None:
        """Check that there is whom modems send to by themselves.

        Raises:
            LookupFailed: there is not.
        """
        for path, port in self.modems.items():
            where = "agents.{}.sensors.{}".format(*path.split(".", 1))
            if port.beacon_s is not None and port.beacon_to != BROADCAST:
                self.find(port.beacon_to, where=f"{where}.beacon_to")
            for name in port.interrogate:
                self.find(name, where=f"{where}.interrogate")

    def find(self, name: str, *, where: str = "") -> str:
        """The path of a modem: "agent.modem", or an agent that has one only.

        Raises:
            LookupFailed: there is none.
        """
        if name in self.modems:
            return name
        own = [p for p in self.modems if p.split(".")[0] == name]
        if len(own) == 1:
            return own[0]
        by_address = [p for p, port in self.modems.items() if str(port.address) == name]
        if by_address:
            return by_address[0]
        raise LookupFailed("modem", name, self.modems, where=where)

    def pose(self, path: str) -> ModemPose:
        """Present pose of a modem."""
        port = self.modems[path]
        return self.pose_of(port.agent, port.mount)

    def pose_of(self, agent: str, mount: Mounted) -> ModemPose:
        """Present pose of something with `position_m` and `q_body_sensor` on a vehicle."""
        assert self.motions_of is not None
        motion, rows = self.motions_of(agent)
        key = (id(motion), mount.position_m, mount.q_body_sensor)
        known = self._posed.get(key)
        if known is None or known[0] is not motion:
            if len(self._posed) > len(self.modems):
                self._posed.clear()
            known = self._posed[key] = (motion, _posed(motion, mount))
        whole = known[1]
        return ModemPose(whole.position[rows], whole.attitude[rows], whole.velocity[rows])

    def level(self, t: float) -> float:
        """Of the sea [m]; waves left out."""
        return sea_level(self._context.ocean, t)

    def hear(
        self, pairs: Sequence[tuple[int, int, int]], poses: Mapping[int, ModemPose], t: float,
        cache: dict[tuple[int, int, int], _Link], lag: Sequence[float],
    ) -> list[HeardSignal]:  # fmt: skip
        """Signals of senders at receivers: pairs of (sender, receiver, copy), modems by index.

        Args:
            pairs: all of senders of one frequency.
            poses: of all modems in them.
            t: [s].
            cache: links of this run.
            lag: how long ago each was sent [s]; ends stood elsewhere then.
        """
        ports = list(self.modems.values())
        crowded = self._context.scene.moving is not None
        ends = np.array([[poses[a].position[c], poses[b].position[c]] for a, b, c in pairs])  # (m, 2, 3)
        ends -= np.array(lag)[:, None, None] * np.array(
            [[poses[a].velocity[c], poses[b].velocity[c]] for a, b, c in pairs]
        )
        known = [link if link and link.waters == self.waters else None for link in map(cache.get, pairs)]
        stale = [k for k, link in enumerate(known) if not _holds(link, ends[k], t, crowded)]
        for frequency in sorted({ports[pairs[k][0]].frequency_hz for k in stale}):
            rows = [k for k in stale if ports[pairs[k][0]].frequency_hz == frequency]
            copy = np.array([pairs[k][2] for k in rows])
            own = np.array([self._own_rows[ports[pairs[k][0]].path][pairs[k][2]] for k in rows], np.uint32)
            found = self._tracer(frequency).trace(ends[rows, 0], ends[rows, 1], t, copy, own)
            for j, k in enumerate(rows):
                cache[pairs[k]] = _Link(_one(found, j), ends[k : k + 1], t, self.waters)
        made = []
        for k, (a, b, c) in enumerate(pairs):
            link = cache[a, b, c]
            arrivals = shift_arrivals(link.paths, link.ends, ends[k : k + 1])
            ratio = doppler(link.paths, poses[a].velocity[c : c + 1], poses[b].velocity[c : c + 1])
            closing = 1.0 - (link.paths.arrival * poses[b].velocity[c]).sum(axis=1) / link.paths.speed[0, 1]
            made.append(
                sum_arrivals(
                    ports[b], ports[a].source_level_db, arrivals.delay / closing, arrivals.amplitude, ratio,
                    link.paths.arrival, link.paths.blocked,
                )
            )  # fmt: skip
        return made

    def noise(self, port: ModemPort) -> float:
        """Of the sea and of the own vehicle in a modem's band [dB re 1 uPa]."""
        wind = surface_wind(self._context.ocean)[0]
        sea = float(spectral_level(port.frequency_hz, wind_speed=wind, shipping=_SHIPPING)[0])
        return sum_db(sea, port.noise_db) + 10.0 * math.log10(port.bandwidth_hz)

    def sonar_noise(self, port: ModemPort, pose: ModemPose, copy: int) -> float:
        """Mean level of sonars' pulses in a modem's band [dB re 1 uPa]: spherical spreading, share of time and band."""
        total = NOTHING
        for emitter in self.sonars().values():
            share = band_overlap(port.frequency_hz, port.bandwidth_hz, emitter.frequency_hz, emitter.bandwidth_hz)
            if share <= 0.0 or self.motions_of is None:
                continue
            there = self.pose_of(emitter.agent, emitter.mounting).position[copy]
            away = max(float(np.linalg.norm(there - pose.position[copy])), 1.0)
            duty = min(emitter.pulse_s * 1e9 / emitter.period_ns, 1.0)
            total = sum_db(total, emitter.source_level_db - 20.0 * math.log10(away) + 10.0 * math.log10(share * duty))
        return total

    def _tracer(self, frequency: float) -> WaterPaths:
        if frequency not in self._tracers:
            c = self._context
            self._tracers[frequency] = WaterPaths(
                c.scene, c.world, c.ocean, frequency=frequency, rays=_RAYS, bounces=_BOUNCES
            )
        return self._tracers[frequency]


def _posed(motion: Kinematics, mount: Mounted) -> ModemPose:
    """Of a mount on every row of a motion."""
    position, attitude = (np.array(v).T for v in sensor_pose(motion, mount))
    return ModemPose(position, attitude, rotate_np(attitude, np.array(sensor_velocity(motion, mount)).T))


def _holds(link: _Link | None, ends: NDArray[np.float64], t: float, crowded: bool) -> bool:
    if link is None or not 0.0 <= t - link.t <= _FRESH_S[crowded]:
        return False
    way = float(np.linalg.norm(ends[1] - ends[0]))
    shift = float(np.max(np.linalg.norm(ends - link.ends[0], axis=1)))
    return shift <= max(_MOVED * way, _MOVED_M)


def _one(paths: Paths, k: int) -> Paths:
    """The paths of one pair, as a set of its own."""
    rows = paths.arrivals.path == k
    alone = paths.arrivals.take(rows)
    alone.path[:] = 0
    return Paths(alone, paths.departure[rows], paths.arrival[rows], paths.blocked[rows], paths.speed[k : k + 1])
