"""Checkpoints: everything that a run depends on at one moment, to go on from it later, elsewhere, or more than once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError, RecordingError
from pelagos.sim import plain

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

_FORMAT: Final = 1
_FREE: Final = ("name", "description", "seed", "record")  # keys of a scenario that may differ


@runtime_checkable
class Remembers(Protocol):
    """A sensor that keeps something from one reading to the next, and can say it.

    Sensors of this package keep nothing: noise is counted, lags look back. One that does keep something is repeatable
    only if it is one of these.
    """

    def memory(self) -> Any:
        """Memory: plain values, lists, dictionaries, arrays, all of them copies."""

    def recall(self, memory: Any) -> None:
        """Keep that instead."""

    def forget(self, copies: NDArray[np.bool_]) -> None:
        """Begin anew in some copies `(n,)`."""


@dataclass(frozen=True)
class Checkpoint:
    """The state of a simulation at a tick. It can be pickled, and saved to a file that holds no code.

    Attributes:
        scenario: resolved, as YAML.
        seed, n, environment: of the simulation.
        time_ns: simulation time [ns].
        parts: what each part of the simulation keeps: plain values and arrays.
    """

    scenario: str
    seed: int
    n: int
    environment: int
    time_ns: int
    parts: Mapping[str, Any]

    def save(self, path: str | Path) -> None:
        """Write it to a file.

        Raises:
            RecordingError: it cannot be written.
        """
        plain.write(Path(path), {"format": _FORMAT, **{k: getattr(self, k) for k in self.__dataclass_fields__}})

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote.

        Raises:
            RecordingError: it cannot be read, or is something else.
        """
        found = plain.read(Path(path))
        if not isinstance(found, dict) or found.pop("format", None) != _FORMAT:
            raise RecordingError(f"{path} is no checkpoint of this version")
        return cls(**found)


def take(sim: Simulation) -> Checkpoint:
    """See `Simulation.checkpoint`."""
    environment, t_ns = sim.model.first_environment, sim.stepper.tick * sim.dt_ns
    return Checkpoint(sim.written, sim.seed, sim.n, environment, t_ns, parts_of(sim))


def parts_of(sim: Simulation) -> dict[str, Any]:
    """Parts of a simulation with what each keeps."""
    sensors = {path: sensor.memory() for path, sensor in _remembering(sim).items()}
    return {"stepper": sim.stepper.memory(), "bodies": sim.bodies.memory(), "sensors": sensors}


def put_back(sim: Simulation, parts: Mapping[str, Any]) -> None:
    """Have each part keep that instead; seed and environment are the same already."""
    sim.bodies.recall(parts["bodies"])
    sim.stepper.recall(parts["stepper"])
    for path, sensor in _remembering(sim).items():
        sensor.recall(parts["sensors"][path])


class Moment:
    """A moment of a simulation to which one can return for a look."""

    def __init__(self, sim: Simulation) -> None:
        self._stepper, self._count = sim.stepper, (sim.stepper.changes, sim.bodies.changes)
        self._parts = parts_of(sim)

    @contextmanager
    def again(self, sim: Simulation) -> Iterator[None]:
        """Within it, the simulation stands where it stood then; after it, where it stands now.

        Raises:
            CommandError: it has gone on, and is stepping at present.
        """
        if sim.stepper is not self._stepper:
            raise CommandError("these readings were not looked at before the simulation got other random streams")
        if (sim.stepper.changes, sim.bodies.changes) == self._count:
            yield
            return
        sim.gate.refuse("reset's readings, looked at for the first time,")
        now = parts_of(sim)
        put_back(sim, self._parts)
        try:
            yield
        finally:
            put_back(sim, now)


def require_same(sim: Simulation, checkpoint: Checkpoint) -> None:
    """Check that a checkpoint is of a simulation such as this one.

    Raises:
        CommandError: another scenario, another number of copies, or another first environment.
    """
    if not isinstance(checkpoint, Checkpoint):
        raise CommandError(f"restore takes what sim.checkpoint() returned, not {type(checkpoint).__name__}")
    first = sim.model.first_environment
    if (checkpoint.n, checkpoint.environment) != (sim.n, first):
        theirs = f"{checkpoint.n} copies from environment {checkpoint.environment} on"
        raise CommandError(f"the checkpoint is of {theirs}, this simulation has {sim.n} from {first} on")
    given, own = _compared(checkpoint.scenario), _compared(sim.written)
    if given != own:
        raise CommandError(f"the checkpoint is of another scenario: {_difference(given, own)}")


def _compared(text: str) -> list[str]:
    """Lines of a scenario but for those keys that may differ."""
    kept, keeps = [], True
    for line in text.splitlines():
        if not line.startswith(" "):
            keeps = line.split(":")[0] not in _FREE
        if keeps:
            kept.append(line)
    return kept


def _difference(theirs: list[str], ours: list[str]) -> str:
    pairs = zip([*theirs, *[""] * len(ours)], [*ours, *[""] * len(theirs)], strict=False)
    one, other = next((a, b) for a, b in pairs if a != b)
    return f"it has {one.strip()!r} where this one has {other.strip()!r}"


def forget(sim: Simulation, where: NDArray[np.bool_]) -> None:
    """Sensors that keep something begin anew in some copies."""
    for sensor in _remembering(sim).values():
        sensor.forget(where)


def _remembering(sim: Simulation) -> dict[str, Remembers]:
    return {
        f"{agent.name}.{name}": model.sensor
        for agent in sim.model.agents.values()
        for name, model in agent.sensors.items()
        if isinstance(model.sensor, Remembers)
    }
