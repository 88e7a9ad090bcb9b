"""Callbacks of a simulation: at ticks, and for readings. What viewers, bridges and loggers live on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import TYPE_CHECKING, Any

from pelagos.sensors.sensor import Reading
from pelagos.sim.sampled import Sampled

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

OnTick = Callable[["Simulation"], object]
OnReading = Callable[[Reading], object]


@dataclass(frozen=True, eq=False)
class Subscription:
    """A callback that stands; `cancel` ends it, as does leaving a `with` block.

    Attributes:
        what: "auv0.imaging", or "tick".
        callback: what is called.
        period: of a callback at ticks, how many of them lie between two calls; 0 otherwise.
        invalid: it hears also readings that are valid in no copy.
    """

    what: str
    callback: Callable[[Any], object]
    period: int = 0
    invalid: bool = False
    _kept: list[Subscription] = field(default_factory=list, repr=False)
    _changed: Callable[[], None] = field(default=lambda: None, repr=False)

    @property
    def active(self) -> bool:
        """The callback is still called."""
        return self in self._kept

    def cancel(self) -> None:
        """Call it no more; to cancel again does nothing."""
        if self in self._kept:
            self._kept.remove(self)
            self._changed()

    def __enter__(self) -> Subscription:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.cancel()


class Listeners:
    """Everything that is called at the boundaries of steps, in a fixed order.

    First come the readings, by agent and sensor as the scenario has them, and for one sensor in the order of
    subscribing; then the callbacks at ticks, in the order in which they were added. Each tick is told once.

    Attributes:
        sensors: (agent, sensor) of every reading that somebody listens to: blocks of ticks end where it is due.
        periods: ticks between two boundaries that somebody asks for.
    """

    def __init__(self) -> None:
        self._all: list[Subscription] = []
        self.sensors: frozenset[tuple[str, ...]] = frozenset()
        self.periods: tuple[int, ...] = ()
        self._told = -1

    @property
    def any(self) -> bool:
        """Somebody listens."""
        return bool(self._all)

    def add(
        self, what: str, callback: Callable[[Any], object], *, period: int = 0, invalid: bool = False
    ) -> Subscription:
        """Listen from the next boundary on."""
        made = Subscription(what, callback, period, invalid, self._all, self._index)
        self._all.append(made)
        self._index()
        return made

    def restart(self, tick: int = 0) -> None:
        """Time goes on from a tick: those after it will be told (again), as will tick 0."""
        self._told = tick or -1

    def has_heard(self, tick: int) -> bool:
        """Whether a tick was told already."""
        return self._told >= tick

    def tell(self, sim: Simulation, tick: int, sampled: Sequence[Sampled]) -> None:
        """Call everybody whom the boundary at `tick` concerns, with the readings of the block that ends there."""
        if self._told >= tick:
            return
        self._told = tick
        for name, one in self._heard(sim, sampled):
            listeners = self._of(name)
            for reading in one.readings(sim.n, sim.dt_ns, invalid=any(each.invalid for each in listeners)):
                found = bool(reading.valid.any())
                for listener in listeners:
                    if found or listener.invalid:
                        _call(listener, reading, tick * sim.dt_ns)
        for listener in self._of("tick"):
            if tick % listener.period == 0:
                _call(listener, sim, tick * sim.dt_ns)

    def _heard(self, sim: Simulation, sampled: Sequence[Sampled]) -> list[tuple[str, Sampled]]:
        """Readings that are listened to, "agent.sensor" and its readings, in the scenario's order."""
        if not self.sensors:
            return []
        found = {
            (agent, one.model.name): one.of(member, sim.n)
            for one in sampled
            for member, agent in enumerate(one.members)
            if (agent, one.model.name) in self.sensors
        }
        agents = {name: place for place, name in enumerate(sim.model.agents)}
        order = sorted(found, key=lambda key: agents[key[0]])
        return [(f"{agent}.{sensor}", found[agent, sensor]) for agent, sensor in order]

    def _of(self, what: str) -> list[Subscription]:
        return [s for s in self._all if s.what == what]

    def _index(self) -> None:
        self.sensors = frozenset(tuple(s.what.split(".", 1)) for s in self._all if not s.period)
        self.periods = tuple(sorted({s.period for s in self._all if s.period}))


def _call(listener: Subscription, value: Any, t_ns: int) -> None:
    if not listener.active:  # cancelled by one before it at the same boundary
        return
    try:
        listener.callback(value)
    except Exception as error:
        name = getattr(listener.callback, "__qualname__", repr(listener.callback))
        of = "on_tick" if listener.period else f"subscribe({listener.what!r})"
        error.add_note(f"raised by {name}, a callback of sim.{of}, at t = {t_ns * 1e-9:.3f} s")
        raise
