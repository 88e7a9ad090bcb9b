"""Noise that depends on nothing but its name: a stream is a key, and a number is a key and a counter.

The key is a hash of (seed, "agent.sensor", purpose); the counter is (index in the sample, environment, tick, kind),
where environment names the copy's episode, and ticks count from its beginning.
So a reading has the same noise whether the run goes tick by tick or in blocks, alone or as one of thousands of
copies, and a new sensor changes nobody else's noise. Sensors of many vehicles that read in one call keep the streams
of their own names: there the key is a table, and the lane's `environment` the row of it.

White noise of density N [unit/sqrt(Hz)] has the standard deviation N sqrt(rate) in each sample. Slow noise (bias
instability, random walk) depends on time, not on the tick, and is built without history: the midpoint of a Gaussian
Markov process between two known values has a known distribution, so a few bisections lead from far apart values to
any moment (P. Levy's construction of Brownian motion; for the Ornstein-Uhlenbeck process with its own conditional
mean and variance). Between its finest values the process is interpolated linearly; what that loses lies far below any
white noise.

Sources: Allan deviations, IEEE Std 952-1997, Annex C; bridge sampling, P. Glasserman, Monte Carlo Methods in Financial
Engineering (2003), Section 3.1, doi 10.1007/978-0-387-21617-1.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Self, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair64, philox

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics

Key: TypeAlias = "tuple[int, int] | tuple[Array, Array] | KeyTable"

_SAMPLE: Final = 0  # last word of the counter: what kind of number it is
_ELEMENT: Final = 1
_MARKOV: Final = 2
_WALK: Final = 3
_CONSTANT: Final = 4

FLOOR: Final = math.sqrt(2 * math.log(2) / math.pi)  # Allan deviation of flicker noise of bias instability 1: 0.664
_MARKOV_PEAK: Final = 0.617266  # largest Allan deviation of a Gauss-Markov process of unit variance

_FINEST: Final = 16  # values of a Gauss-Markov process per correlation time
_MARKOV_LEVELS: Final = 9  # bisections, from independent values 32 correlation times apart (correlation 1e-14)
_WALK_STEP_NS: Final = 4_000_000_000  # finest values of a random walk
_WALK_LEVELS: Final = 14  # from spans of 2^14 * 4 s = 18 h


class BatchPath(str):
    """The path of a sensor that many vehicles carry alike and that reads for all of them: the first one's.

    Attributes:
        members: "agent.sensor" of each vehicle.
        environments: index of each copy of the fleet; rows go vehicle by vehicle, and copy by copy within.
        tables: those that were made of it; where copies begin new episodes, their environments are exchanged.
    """

    members: tuple[str, ...]
    environments: range
    tables: list[KeyTable]

    @classmethod
    def of(cls, members: tuple[str, ...], environments: range, tables: list[KeyTable] | None = None) -> Self:
        """That of these sensors in these copies."""
        path = cls(members[0])
        path.members, path.environments, path.tables = members, environments, [] if tables is None else tables
        return path


@jit.struct
class KeyTable:
    """Keys of many streams, by row: a Dr.Jit struct.

    Attributes:
        first, second: `UInt32`, the words of each row's key.
        environment: `UInt32`, index of the copy that each row belongs to.
    """

    first: Array
    second: Array
    environment: Array


def part_path(path: str, name: str) -> str:
    """The path of a part of a sensor, which draws noise of its own."""
    if isinstance(path, BatchPath):
        return BatchPath.of(tuple(f"{member}.{name}" for member in path.members), path.environments, path.tables)
    return f"{path}.{name}"


def stream_key(seed: int, path: str, purpose: str) -> Any:
    """Two 32-bit words that name a random stream: seed of the run, "agent.sensor", and what the numbers are for.

    Of a `BatchPath`, a `KeyTable`.
    """
    if isinstance(path, BatchPath):
        words = np.array([stream_key(seed, str(member), purpose) for member in path.members], dtype=np.uint32)
        first, second = np.repeat(words, len(path.environments), axis=0).T
        copies = np.tile(np.array(path.environments, dtype=np.uint32), len(path.members))
        made = KeyTable(*(jit.from_numpy(jit.UInt32, np.ascontiguousarray(words)) for words in (first, second, copies)))
        path.tables.append(made)
        return made
    text = f"{int(seed)}\x1f{path}\x1f{purpose}".encode()
    digest = hashlib.blake2b(text, digest_size=8, person=b"pelagos").digest()
    return int.from_bytes(digest[:4], "little"), int.from_bytes(digest[4:], "little")


def opaque_key(key: Any) -> Any:
    """The key as arguments of a frozen function (two `UInt32`, or a `KeyTable`): another seed is no other kernel."""
    if isinstance(key, KeyTable):
        return key
    return dr.opaque(jit.UInt32, key[0]), dr.opaque(jit.UInt32, key[1])


def lane_stream(key: Key, environment: Array) -> tuple[tuple[Array, Array], Array]:
    """Key and environment of lanes, looked up where the key is a table and `environment` its row."""
    if not isinstance(key, KeyTable):
        return key, environment
    first, second = (dr.gather(jit.UInt32, words, environment) for words in (key.first, key.second))
    return (first, second), dr.gather(jit.UInt32, key.environment, environment)


def normals64(key: Key, motion: Kinematics, count: int) -> list[Array]:
    """`count` independent standard normal `Float64` for every lane of `motion`, new ones each tick."""
    return _normals64(*lane_stream(key, motion.environment), motion.tick, count, _SAMPLE)


def normals64_from(key: Key, environment: Array, tick: Array, pair: Array, count: int) -> list[Array]:
    """`count` of the numbers of `normals64`, for lanes of their own, from a pair of numbers on that each lane names."""
    return _normals64(*lane_stream(key, environment), tick, count, _SAMPLE, pair)


class NumpyNoise:
    """Noise of a sensor in NumPy: new numbers each tick, from a random stream with the sensor's own name.

    Two sensors of one type draw different numbers; one sensor draws the same, whether asked tick by tick or in blocks.

    Args:
        seed: of the run, `SensorContext.seed`.
        path: "agent.sensor", `SensorContext.path`.
    """

    def __init__(self, seed: int, path: str) -> None:
        self._key = opaque_key(stream_key(seed, path, "noise"))

    def normals(self, motion: Kinematics, count: int = 1) -> NDArray[np.float64]:
        """Independent standard normal numbers, `(m, count)` for the m lanes of `motion`."""
        return np.stack([np.array(v) for v in normals64(self._key, motion, count)], axis=-1)


def constants64(key: Key, motion: Kinematics, count: int) -> list[Array]:
    """`count` independent standard normal `Float64` for every lane of `motion`, the same at all times of one copy."""
    return _normals64(*lane_stream(key, motion.environment), jit.UInt32(0), count, _CONSTANT)


def words32(key: Key, index: Array, environment: Array, tick: Array) -> tuple[Array, Array, Array, Array]:
    """Four random `UInt32` for element `index` (pixel, bin, ray) of the sample of `environment` at `tick`."""
    words, environment = lane_stream(key, environment)
    return philox((index, environment, tick, jit.UInt32(_ELEMENT)), words)


def gauss_markov(key: Key, motion: Kinematics, count: int, *, correlation_time: float) -> list[Array]:
    """`count` independent stationary first-order Gauss-Markov processes of unit variance at every lane's time.

    Args:
        key: see `stream_key`.
        motion: gives time and environment of each lane.
        count: how many.
        correlation_time: T [s] in the autocorrelation exp(-|t|/T).

    Returns:
        `Float64` each. The Allan variance at averaging time a is (T/a)(2 - (T/a)(3 - 4 exp(-a/T) + exp(-2a/T))).
    """
    step_ns = max(round(correlation_time * 1e9 / _FINEST), 1)
    knot, fraction = _knot(_age(motion), step_ns)
    top = knot >> _MARKOV_LEVELS << _MARKOV_LEVELS
    span = 1 << _MARKOV_LEVELS
    words, environment = lane_stream(key, motion.environment)
    low = _normals64(words, environment, top, count, _MARKOV)
    high = _normals64(words, environment, top + span, count, _MARKOV)

    def midpoint(width: Array) -> tuple[Array, Array]:
        rho = dr.exp(width * (-0.5 / _FINEST))
        return rho / (1 + rho * rho), dr.sqrt((1 - rho * rho) / (1 + rho * rho))

    low, high = _bisect(words, environment, knot, top, span, low, high, midpoint, _MARKOV)
    return [a + fraction * (b - a) for a, b in zip(low, high, strict=True)]


def bias_instability(key: Key, motion: Kinematics, count: int, *, correlation_time: float) -> list[Array]:
    """`count` Gauss-Markov processes whose Allan deviation peaks, at 1.89 correlation times, at 0.664.

    Times a bias instability B [unit] they peak where flicker noise of that B has its floor (IEEE 952, Annex C.1.3.3).
    """
    scale = FLOOR / _MARKOV_PEAK
    return [scale * x for x in gauss_markov(key, motion, count, correlation_time=correlation_time)]


def random_walk(key: Key, motion: Kinematics, count: int) -> list[Array]:
    """`count` independent random walks that are 0 at t = 0 and have the variance t [s] afterwards, `Float64` each.

    Times a coefficient K [unit/sqrt(s)] the Allan deviation at averaging time a is K sqrt(a/3) (IEEE 952 Annex C).
    """
    knot, fraction = _knot(_age(motion), _WALK_STEP_NS)
    span = 1 << _WALK_LEVELS
    whole = knot >> _WALK_LEVELS
    step_s = _WALK_STEP_NS * 1e-9
    long_step = math.sqrt(span * step_s)
    words, environment = lane_stream(key, motion.environment)

    def advance(i: Array, *sums: Array) -> tuple[Array, ...]:
        steps = _normals64(words, environment, (i + 1) << _WALK_LEVELS, count, _WALK)
        return i + 1, *(a + long_step * n for a, n in zip(sums, steps, strict=True))

    width = dr.width(motion.t_ns)
    start = (dr.zeros(jit.UInt32, width), *(dr.zeros(jit.Float64, width) for _ in range(count)))
    state = dr.while_loop(start, lambda i, *_: i < whole, advance, mode="symbolic")
    low = list(state[1:])
    high = list(advance(state[0], *low)[1:])

    def midpoint(cells: Array) -> tuple[Array, Array]:
        return jit.Float64(0.5), dr.sqrt(cells * (0.25 * step_s))

    top = whole << _WALK_LEVELS
    low, high = _bisect(words, environment, knot, top, span, low, high, midpoint, _WALK)
    return [a + fraction * (b - a) for a, b in zip(low, high, strict=True)]


def _normals64(
    key: tuple[Array, Array], environment: Array, moment: Array, count: int, kind: int, first: Array = 0
) -> list[Array]:
    values: list[Array] = []
    for j in range((count + 1) // 2):
        values += normal_pair64(philox((jit.UInt32(first + j), environment, moment, jit.UInt32(kind)), key))
    return values[:count]


def _age(motion: Kinematics) -> Array:
    """Time since the copy's episode began [ns]."""
    return motion.t_ns if motion.age_ns is None else motion.age_ns


def _knot(t_ns: Array, step_ns: int) -> tuple[Array, Array]:
    """Number of the value before `t_ns`, and how far on to the next one."""
    knot = t_ns // jit.UInt64(step_ns)
    return jit.UInt32(knot), jit.Float64(t_ns - knot * jit.UInt64(step_ns)) * (1 / step_ns)


def _bisect(
    key: tuple[Array, Array],
    environment: Array,
    knot: Array,
    first: Array,
    span: int,
    low: list[Array],
    high: list[Array],
    midpoint: Callable[[Array], tuple[Array, Array]],
    kind: int,
) -> tuple[list[Array], list[Array]]:
    """Values at `knot` and `knot + 1` of a Markov process that is `low` at `first` and `high` at `first + span`.

    `midpoint(width)` is (factor of low + high, standard deviation) of the value in the middle of `width` steps. A
    knot has the same counter on whichever way it is reached.
    """
    count = len(low)

    def halve(left: Array, half: Array, *ends: Array) -> tuple[Array, ...]:
        middle = left + half
        weight, sigma = midpoint(jit.Float64(2 * half))
        right = knot >= middle
        new_low, new_high = [], []
        for a, b, n in zip(ends[:count], ends[count:], _normals64(key, environment, middle, count, kind), strict=True):
            m = weight * (a + b) + sigma * n
            new_low.append(dr.select(right, m, a))
            new_high.append(dr.select(right, b, m))
        return dr.select(right, middle, left), half >> 1, *new_low, *new_high

    start = (first, jit.UInt32(span // 2), *low, *high)
    state = dr.while_loop(start, lambda left, half, *_: half > 0, halve, mode="symbolic")
    return list(state[2 : 2 + count]), list(state[2 + count :])


def digitise(value: Array, *, resolution: float, lowest: float, highest: float) -> Array:
    """Rounded to multiples of `resolution` (0: not at all), and held between `lowest` and `highest`."""
    rounded = dr.round(value * (1 / resolution)) * resolution if resolution > 0 else value
    return dr.clip(rounded, lowest, highest)
