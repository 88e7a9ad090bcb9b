"""Watchers: callbacks that hear what a block of ticks gave, and ask for no boundaries of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pelagos.sensors.sensor import Reading
from pelagos.sim.sampled import Sampled


class BlockReadings(Mapping[str, Sequence[Reading]]):
    """Readings of a block in order of time, by "agent.sensor"; made when they are looked at."""

    def __init__(self, sampled: Sequence[Sampled], *, n: int, dt_ns: int) -> None:
        self._n, self._dt_ns = n, dt_ns
        self._found: dict[str, tuple[Sampled, int]] = {
            f"{agent}.{one.model.name}": (one, member) for one in sampled for member, agent in enumerate(one.members)
        }

    def __getitem__(self, name: str) -> Sequence[Reading]:
        one, member = self._found[name]
        return list(one.of(member, self._n).readings(self._n, self._dt_ns))

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def newest(self, name: str) -> Reading | None:
        """The last reading of a sensor; None where it gave none."""
        one, member = self._found[name]
        return one.of(member, self._n).newest(self._n, self._dt_ns)


@dataclass(eq=False)
class Watcher:
    """A callback that stands.

    Attributes:
        callback: what is called.
        begun: it has heard the readings of the start.
    """

    callback: Callable[[BlockReadings], object]
    begun: bool = False
