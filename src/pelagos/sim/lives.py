"""The face of a simulation that turns time: resets, episodes of single copies, checkpoints and forks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError
from pelagos.sensors.sensor import Reading
from pelagos.sim import checkpoint, props
from pelagos.sim.bodies import Bodies
from pelagos.sim.checkpoint import Checkpoint
from pelagos.sim.encounters import Encounters
from pelagos.sim.initial import StartState, starts
from pelagos.sim.later import Later
from pelagos.sim.model import compile_model, encounters_of, with_changes
from pelagos.sim.outside import Outside
from pelagos.sim.sampled import Sampled
from pelagos.sim.seed import seed_of
from pelagos.sim.state import chosen
from pelagos.sim.step import Stepper

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

Observations = Mapping[str, Mapping[str, Reading]]


class Lives(Outside):
    """Copies that begin anew, go back, or go on elsewhere.

    Attributes:
        n: copies.
        seed: of every random stream.
        bodies: what stands in the moving scene.
    """

    n: int
    seed: int
    bodies: Bodies
    _begin: dict[str, StartState]
    _encounters: Encounters

    def reset(
        self,
        seed: int | None = None,
        *,
        environment: int | None = None,
        episode: int = 0,
        where: object = None,
        state: Mapping[str, Mapping[str, Any]] | None = None,
        tick: int = 0,
    ) -> Observations:
        """Back to the start: time 0, no spawned bodies, missions from their first leg; or some copies only.

        With `where`, those copies begin their next episode at the present time: their vehicles with actuators and
        controllers, missions, sensors' memory and contacts; their random streams are those of the new episode. The
        other copies' bytes, the time, spawned bodies and control modes stay.

        Args:
            seed: other random streams.
            environment: another index of the first copy.
            episode: which episode of theirs all copies begin with, to see one again.
            where: `(n,)` bool or indices of copies.
            state: where agents begin instead, by name: `position`, `attitude`, `velocity`, `angular_velocity`, each
                `(k,)`, `(n, k)`, or `(m, k)` for the m copies of `where`; what is not given is the scenario's.
            tick: number of the tick at which all copies begin, instead of 0: sensors are due at whole multiples of
                their periods from tick 0 on.

        Returns:
            The readings of every sensor, computed when looked at.

        Raises:
            CommandError: wrong shapes or values, or within a step, a run or a recording.
        """
        self._refuse_within("reset", in_recording=where is not None)
        if where is not None:
            if seed is not None or environment is not None or episode or tick:
                raise CommandError("seed, environment, episode and tick are those of all copies; leave out where")
            mask = chosen(where, self.n)
            drawn = self._stepper.variety.starts(self._begin, mask, self._stepper.episodes.number + 1)
            self._stepper.restart(starts(drawn, state, mask), mask)
            props.put(self.model, self.bodies, self._stepper.variety, mask, self._stepper.episodes.number)
            checkpoint.forget(cast("Simulation", self), mask)
            return self._later(self._stepper.read_all)
        if isinstance(episode, bool) or not isinstance(episode, int | np.integer) or episode < 0:
            raise CommandError(f"an episode is a whole number from 0 on, not {episode!r}")
        if isinstance(tick, bool) or not isinstance(tick, int | np.integer) or tick < 0:
            raise CommandError(f"tick is a whole number from 0 on, not {tick!r}")
        first = self.model.first_environment
        if (seed is not None and seed != self.seed) or (environment is not None and environment != first):
            self._rename(self.seed if seed is None else seed_of(seed), first if environment is None else environment)
        whole, number = np.ones(self.n, dtype=bool), np.full(self.n, int(episode))
        begin = starts(self._stepper.variety.starts(self._begin, whole, number), state, whole)
        self.bodies.clear()
        props.put(self.model, self.bodies, self._stepper.variety, whole, number)
        self.listeners.restart(int(tick))
        self._stepper.start(begin, episode=int(episode), tick=int(tick))
        self._tell_reset()
        return self._later(self._stepper.read_now)

    def _later(self, read: Callable[[], list[Sampled]]) -> Observations:
        """Readings of now, computed when they are looked at, even if the simulation has gone on by then."""
        then, stepper = checkpoint.Moment(cast("Simulation", self)), self._stepper

        def look() -> Observations:
            with then.again(cast("Simulation", self)):
                return stepper.observed(read())

        return Later(look)

    @property
    def ended(self) -> NDArray[np.bool_]:
        """`(n,)` copies whose state is not finite any more: they stand where their episode began until it is reset."""
        return self._stepper.episodes.over

    @property
    def episode(self) -> NDArray[np.int64]:
        """`(n,)` number of the episode of each copy."""
        return self._stepper.episodes.number.copy()

    @property
    def drawn(self) -> dict[str, NDArray[np.float64]]:
        """By key of the scenario's `vary`, `(n,)` what was drawn for the present episode of each copy."""
        now = self._stepper.variety.drawn(self._stepper.episodes)
        return {key: values.copy() for key, values in now.items()}

    def _rename(self, seed: int, environment: int) -> None:
        """Other random streams: sensors and ocean anew, the rest as it is."""
        if isinstance(environment, bool) or not isinstance(environment, int | np.integer) or environment < 0:
            raise CommandError(f"environment is a whole number from 0 on, not {environment!r}")
        first, asked, old = int(environment), encounters_of(self.model.scenario), self.model
        if seed == self.seed:
            self.model = replace(old, first_environment=first)
        else:
            self.model = compile_model(
                self.model.scenario, asked, n=self.n, seed=seed, first_environment=first, like=old
            )
            self._encounters = asked
        self.seed = int(seed)
        own = self._stepper.own_current
        if own is not None and self.model.ocean.own is None:
            ocean = self.model.ocean.with_(own=own)
            self.model = with_changes(self.model, self.model.scenario, asked, seed=self.seed, ocean=ocean)
        self._stepper = Stepper(self.model, self.bodies, self._encounters, self.listeners)
        self._stepper.own_current = own

    def checkpoint(self) -> Checkpoint:
        """Everything that the run depends on from here: actuators, controllers, missions, contacts, bodies, time.

        It can be pickled, and saved to a file (`Checkpoint.save`, `Checkpoint.load`). What it does not hold: callbacks,
        recordings, and what comes with the scenario.
        """
        return checkpoint.take(cast("Simulation", self))

    def restore(self, kept: Checkpoint) -> None:
        """Go back, or on, to a checkpoint of this scenario: from there, bytes are those of the run that went on.

        The checkpoint may come from another simulation or process, and be restored more than once. Its seed becomes
        this simulation's. Callbacks stay; handles of spawned bodies stay good where the checkpoint has them.

        Raises:
            CommandError: it is of another scenario, number of copies or environment.
        """
        self._refuse_within("restore")
        checkpoint.require_same(cast("Simulation", self), kept)
        if kept.seed != self.seed:
            self._rename(kept.seed, kept.environment)
        own = kept.parts["stepper"]["own_current"]
        if own is not None and self.model.ocean.own is None:
            cast("Simulation", self).ocean.set(current=own.T)
        elif own is None and self.model.ocean.own is not None and not self._stepper.variety.has_current:
            cast("Simulation", self).ocean.set(current=None)
        checkpoint.put_back(cast("Simulation", self), kept.parts)
        self.listeners.restart(self._stepper.tick)

    def fork(self) -> Self:
        """A second simulation that stands where this one stands, and goes its own way: for predictions.

        It costs milliseconds, because both share what is constant: world, vehicles, sensors, recorded kernels. So they
        must run in one thread; for another process, pickle a checkpoint. It has no callbacks and no recordings.
        """
        model = replace(self.model, world=self.model.world.twin())
        made: Self = cast("Any", type(self))(model, self._encounters, seed=self.seed, like=self)
        checkpoint.put_back(cast("Simulation", made), checkpoint.parts_of(cast("Simulation", self)))
        made.listeners.restart(self._stepper.tick)
        return made
