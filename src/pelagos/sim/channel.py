"""`channel`: the paths of sound between two places of a world or a simulation, and what they do to a waveform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.acoustics import channel as waveform
from pelagos.acoustics.eigenrays import BOUNCES, RAYS
from pelagos.acoustics.section import Section
from pelagos.acoustics.transmission_loss import Field, field
from pelagos.errors import CommandError, LookupFailed
from pelagos.math.so3 import rotate_np
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.surface_wind import surface_wind
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.comms.link.water_paths import Paths, WaterPaths, doppler
from pelagos.sim.bodies import hull_rows
from pelagos.sim.simulation import Simulation
from pelagos.world.world import World

if TYPE_CHECKING:
    from pelagos.sensors.sensor import SensorConfig

_WIDEST: Final = np.radians(85.0)  # half the fan of a picture
_BURIED: Final = 0.01  # [m] by which an end may lie in the ground: what stands on it, to single precision


@dataclass(frozen=True)
class ChannelArrivals:
    """The arrivals of a channel, by delay; `(k,)` unless said.

    Attributes:
        delay: [s].
        amplitude: complex pressure re that at 1 m; the transfer function is the sum of amplitude exp(-i omega delay).
        departure, arrival: `(k, 3)` unit vectors NWU of the ray at both ends.
        departure_angle, arrival_angle: above the horizontal [rad].
        surface, bottom, caustics: numbers of bounces, and of caustics touched.
        doppler: received over sent frequency [1].
        length: of the ray [m].
        blocked: a structure or a hull stands in the way; such arrivals bring nothing.
    """

    delay: NDArray[np.float64]
    amplitude: NDArray[np.complex128]
    departure: NDArray[np.float64]
    arrival: NDArray[np.float64]
    departure_angle: NDArray[np.float64]
    arrival_angle: NDArray[np.float64]
    surface: NDArray[np.int64]
    bottom: NDArray[np.int64]
    caustics: NDArray[np.int64]
    doppler: NDArray[np.float64]
    length: NDArray[np.float64]
    blocked: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.delay)

    @property
    def loss_db(self) -> NDArray[np.float64]:
        """Transmission loss of each [dB re 1 m]."""
        return np.asarray(-20.0 * np.log10(np.maximum(np.abs(self.amplitude), 1e-300)))

    @property
    def phase(self) -> NDArray[np.float64]:
        """Of the amplitude: bounces and caustics, without the delay [rad]."""
        return np.asarray(np.angle(self.amplitude))


class Channel:
    """The water between a transmitter and a receiver as it is at one time.

    Attributes:
        section: what sound meets on its way.
        source, receiver: places NWU [m].
        frequency_hz: for which absorption, bottom and surface are taken.
    """

    def __init__(
        self, paths: Paths, section: Section, source: NDArray[np.float64], receiver: NDArray[np.float64],
        velocities: NDArray[np.float64], frequency_hz: float, noise: tuple[float, float], level: float,
    ) -> None:  # fmt: skip
        self.section, self.source, self.receiver, self.frequency_hz = section, source, receiver, frequency_hz
        self._wind, self._shipping = noise
        self._level = level
        a = paths.arrivals
        ratio = doppler(paths, velocities[None, 0], velocities[None, 1])
        kept = np.where(paths.blocked, 0.0, a.amplitude)
        self._arrivals = ChannelArrivals(
            a.delay, kept, paths.departure, paths.arrival, -a.departure, -a.arrival, a.surface, a.bottom, a.caustics,
            ratio, a.length, paths.blocked,
        )  # fmt: skip

    def arrivals(self) -> ChannelArrivals:
        """Every path, the first one first."""
        return self._arrivals

    def transmission_loss(self, *, coherent: bool = False) -> float:
        """Of all paths together [dB re 1 m]: powers added, or pressures at `frequency_hz`; infinite without any."""
        a = self._arrivals
        turn = np.exp(-2j * np.pi * self.frequency_hz * a.delay)
        power = abs(np.sum(a.amplitude * turn)) ** 2 if coherent else np.sum(np.abs(a.amplitude) ** 2)
        return float(-10.0 * np.log10(power)) if power > 0 else np.inf

    def impulse_response(self, sample_rate_hz: float, *, taps: int | None = None) -> tuple[float, NDArray[Any]]:
        """Complex baseband taps about `frequency_hz`, and the time of the first one [s]."""
        a = self._arrivals
        _positive(sample_rate_hz, "sample_rate_hz")
        return waveform.impulse_response(
            a.delay, a.amplitude, carrier=self.frequency_hz, sample_rate=sample_rate_hz, taps=taps
        )

    def transmit(
        self, samples: ArrayLike, sample_rate_hz: float, *, source_level_db: float = 0.0, noise_seed: int | None = None
    ) -> tuple[float, NDArray[np.complex128]]:
        """A baseband waveform as it arrives, each path delayed, turned and resampled by its Doppler.

        Args:
            samples: sent from t = 0 on, of unit power at full level.
            sample_rate_hz: of it, and of what arrives [Hz].
            source_level_db: of a sample of size 1 [dB re 1 uPa at 1 m].
            noise_seed: adds the sea's noise in this band, drawn with this seed; none where not given.

        Returns:
            time of the first sample [s], and samples [uPa].
        """
        _positive(sample_rate_hz, "sample_rate_hz")
        sent = np.asarray(samples, complex)
        if sent.ndim != 1 or not np.isfinite(sent).all():
            raise CommandError(f"a waveform is a row of finite numbers, not an array of shape {sent.shape}")
        a = self._arrivals
        if len(a) == 0:
            return 0.0, np.zeros(0, complex)
        start = float(a.delay.min())
        stretch = 1.0 / float(a.doppler.min())
        count = int(np.ceil((float(a.delay.max()) * stretch - start) * sample_rate_hz + len(sent) * stretch)) + 32
        got = waveform.received(
            sent * 10.0 ** (source_level_db / 20.0), a.delay, a.amplitude, a.doppler, carrier=self.frequency_hz,
            sample_rate=sample_rate_hz, start=start, count=count,
        )  # fmt: skip
        if noise_seed is not None:
            rng = np.random.Generator(np.random.PCG64(noise_seed))
            size = np.sqrt(10.0 ** (self.noise_level_db() / 10.0) * sample_rate_hz / 2.0)
            got = got + size * (rng.standard_normal(count) + 1j * rng.standard_normal(count))
        return start, got

    def noise_level_db(self, frequency_hz: float | None = None) -> float:
        """Of the sea at the receiver after Wenz [dB re 1 uPa^2/Hz]."""
        f = self.frequency_hz if frequency_hz is None else frequency_hz
        return float(waveform.spectral_level(f, wind_speed=self._wind, shipping=self._shipping)[0])

    def field(self, *, columns: int = 240, rows: int = 120, beams: int = 1000) -> Field:
        """The transmission loss in the vertical plane through both ends, a fifth beyond the receiver."""
        reach = 1.2 * max(float(np.hypot(*(self.receiver - self.source)[:2])), 1.0)
        lowest = float(np.max(self.section.bottom_depth))
        if lowest > 11_000.0:
            lowest = 3.0 * max(self.depths)
        depths = np.linspace(0.0, lowest, rows)
        return field(
            self.section, self.depths[0], reach=reach, columns=columns, depths=depths, widest=_WIDEST, beams=beams
        )

    @property
    def depths(self) -> tuple[float, float]:
        """Of source and receiver below the sea's level [m]."""
        return self._level - float(self.source[2]), self._level - float(self.receiver[2])


def channel(
    where: Simulation | World, tx: str | Sequence[float], rx: str | Sequence[float], *, frequency_hz: float = 25_000.0,
    ocean: Ocean | None = None, bounces: int = BOUNCES, shipping: float = 0.5, copy: int = 0,
) -> Channel:  # fmt: skip
    """Trace the sound between two places through the water as it is now.

    Args:
        where: a simulation, with its ocean, its time and everything that moves; or a world, in still water of 12 degC.
        tx, rx: "auv0", "auv0.modem", or a place NWU [m].
        frequency_hz: of the sound.
        ocean: instead of the simulation's.
        bounces: most of a path.
        shipping: 0 (none) to 1 (heavy), for the noise.
        copy: of the fleet.

    Raises:
        LookupFailed: no agent or sensor has this name.
        CommandError: a place is not three finite numbers, is in the air or the ground, or both are the same; a number
            is beyond its range, or the fleet has no such copy.
    """
    sim = where if isinstance(where, Simulation) else None
    world = sim.world if sim is not None else where
    if not isinstance(world, World):
        raise CommandError(f"channel takes a simulation or a world, not {type(where).__name__}")
    _positive(frequency_hz, "frequency_hz")
    if not (_is_number(shipping) and 0.0 <= shipping <= 1.0):
        raise CommandError(f"shipping is a number from 0 (none) to 1 (heavy), not {shipping!r}")
    if not (_is_whole(bounces) and bounces >= 0):
        raise CommandError(f"bounces is a whole number, 0 or more, not {bounces!r}")
    copies = 1 if sim is None else sim.n
    if not (_is_whole(copy) and 0 <= copy < copies):
        there = f"a whole number from 0 to {copies - 1}" if copies > 1 else "0, as there is but one"
        raise CommandError(f"copy is {there}, not {copy!r}")
    frequency_hz, shipping, bounces, copy = float(frequency_hz), float(shipping), int(bounces), int(copy)
    water = ocean or (sim.model.ocean if sim is not None else build_ocean(OceanConfig(), world))
    scene = sim.model.scene if sim is not None else world._scene()
    if sim is not None:
        sim._show_now()
    ends = [_place(sim, end, copy) for end in (tx, rx)]
    places = np.stack([p for p, _ in ends])
    time = 0.0 if sim is None else sim.time_ns * 1e-9
    tracer = WaterPaths(scene, world, water, frequency=frequency_hz, rays=RAYS, bounces=bounces)
    level = tracer.level(time)
    for name, place in zip((tx, rx), places, strict=True):
        if place[2] > level:
            raise CommandError(f"{name} is {place[2] - level:.3g} m above the water; sound of the channel runs in it")
    if np.linalg.norm(places[1] - places[0]) < 1e-3:
        raise CommandError(f"the ends of a channel are two places, not twice {places[0].tolist()}")
    rows = np.array([copy])
    section = tracer.sections(places[None, 0], places[None, 1], time, rows)[0]
    away = float(np.hypot(*(places[1] - places[0])[:2]))
    for name, place, x in zip((tx, rx), places, (0.0, away), strict=True):
        below = (level - place[2]) - float(section.bottom_at(x))
        if below > _BURIED and not isinstance(name, str):
            raise CommandError(f"{name} is {below:.3g} m below the ground; sound of the channel runs in the water")
    paths = tracer.trace(places[None, 0], places[None, 1], time, rows, _own_hull(sim, tx, copy))
    velocities = np.stack([v for _, v in ends])
    wind = surface_wind(water)[0]
    return Channel(paths, section, places[0], places[1], velocities, frequency_hz, (wind, shipping), level)


def _place(
    sim: Simulation | None, end: str | Sequence[float], copy: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place of an end [m], and its velocity [m/s]."""
    if isinstance(end, str):
        if sim is None:
            raise CommandError(f"{end!r} names an agent, but a world has none; give a place, or a simulation")
        agent, _, sensor = end.partition(".")
        if agent not in sim.model.agents:
            raise LookupFailed("agent", agent, sim.model.agents)
        sensors = sim.model.agents[agent].sensors
        if sensor and sensor not in sensors:
            raise LookupFailed("sensor", sensor, sensors, where=agent)
        config: SensorConfig | None = sensors[sensor].config if sensor else None
        arm = np.array((0.0, 0.0, 0.0) if config is None else config.position_m)
        state = sim.state[agent]
        q, spin = state.attitude[copy : copy + 1], state.angular_velocity[copy]
        moving = state.velocity[copy] + np.cross(spin, arm)
        return state.position[copy] + rotate_np(q, arm[None])[0], rotate_np(q, moving[None])[0]
    place = np.asarray(end, np.float64)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise CommandError(f"a place is three finite numbers, x north, y west, z up [m]; given {end!r}")
    return place, np.zeros(3)


def _own_hull(sim: Simulation | None, tx: str | Sequence[float], copy: int) -> NDArray[np.uint32]:
    """Row of the moving scene that is the transmitter's own hull, which does not stand in its way."""
    if sim is None or not isinstance(tx, str) or len(sim.model.agents) < 2:
        return np.array([NO_BODY], np.uint32)
    index = list(sim.model.scenario.members).index(tx.partition(".")[0])
    return hull_rows(index, sim.n)[copy : copy + 1]


def _positive(value: float, name: str) -> None:
    if not (_is_number(value) and value > 0):
        raise CommandError(f"{name} is a positive number, not {value!r}")


def _is_number(value: object) -> bool:
    """True for one finite real number."""
    return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)


def _is_whole(value: object) -> bool:
    return not isinstance(value, bool) and isinstance(value, Integral)
