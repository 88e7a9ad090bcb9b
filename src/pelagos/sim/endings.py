"""Ends of episodes: a copy of a fleet whose state is not finite any more ends alone, and the fleet goes on.

Its vehicles return to where its episode began and stand still there, its readings are not valid, and
`Simulation.ended` says so, until it is reset. A fleet of one, or one in which all copies have ended, stops with
`NotFinite`.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import EndedWarning
from pelagos.sim.batch import Batch
from pelagos.sim.batch_run import BatchRun
from pelagos.sim.episodes import Episodes
from pelagos.sim.model import Model
from pelagos.sim.not_finite import NotFinite
from pelagos.sim.state import mixed
from pelagos.sim.trajectory import Trajectory

FARTHEST_M: Final = 1e9  # from there no vehicle comes back: it will not be finite soon


class Endings:
    """Watches the motion of all agents, and holds the copies that have ended."""

    def __init__(self, model: Model, episodes: Episodes) -> None:
        self._model, self._episodes = model, episodes

    def watch(self, runs: Mapping[str, BatchRun], moved: Mapping[str, Trajectory]) -> Mapping[str, Trajectory]:
        """The trajectories of a block by batch, with the copies that have ended held at their beginning from that tick
        on, and in `runs` too, whose rows become those of the block's end.

        A state that is not finite stays so: the last tick tells of all.

        Raises:
            NotFinite: of a fleet no copy is left.
        """
        last = {name: trajectory.last() for name, trajectory in moved.items()}
        unsound = [name for name, rows in last.items() if not _sound(rows)]
        if not unsound and not self._episodes.any_over:
            for name, rows in last.items():
                runs[name].row = rows
            return moved
        motions = {name: trajectory.numpy() for name, trajectory in moved.items()}
        for name in unsound:
            self._end(self._model.batches[name], runs[name], moved[name].first_tick, motions[name])
        return {name: self._held(name, runs[name], trajectory, motions[name]) for name, trajectory in moved.items()}

    def _held(self, name: str, run: BatchRun, trajectory: Trajectory, motion: NDArray[np.float64]) -> Trajectory:
        members = len(self._model.batches[name].members)
        run.vehicle = mixed(run.vehicle, run.begin_vehicle, np.tile(self._episodes.over, members))
        ticks = trajectory.first_tick + np.arange(len(motion))
        over = ticks[:, None] >= np.tile(self._episodes.ended, members)  # (ticks, rows)
        held = np.where(over[..., None], run.begin_row[None], motion)
        run.row = held[-1]
        return replace(trajectory, packed=jit.from_numpy(jit.Float64, held))

    def _end(self, batch: Batch, run: BatchRun, first: int, motion: NDArray[np.float64]) -> None:
        bad = ~(np.isfinite(motion).all(axis=2) & (np.abs(motion[..., 0:3]) <= FARTHEST_M).all(axis=2))  # (ticks, rows)
        bad &= ~np.tile(self._episodes.over, len(batch.members))
        rows = np.flatnonzero(bad.any(axis=0))
        if not len(rows):
            return
        ticks = bad[:, rows].argmax(axis=0)
        for row, tick in zip(rows.tolist(), ticks.tolist(), strict=True):
            self._episodes.end(np.array([row % batch.n]), np.array([first + tick]))
        errors = [self._error(batch, run, int(r), first, int(k), motion) for r, k in zip(rows, ticks, strict=True)]
        if self._episodes.over.all():
            raise errors[0]
        for error in errors[:1]:
            more = f", as {len(errors) - 1} other copies have" if len(errors) > 1 else ""
            warnings.warn(f"its episode has ended: {error}{more}", EndedWarning, stacklevel=2)

    def _error(
        self, batch: Batch, run: BatchRun, row: int, first: int, k: int, motion: NDArray[np.float64]
    ) -> NotFinite:
        t_s = (first + k) * self._model.clock.dt_ns * 1e-9
        last = motion[k - 1, row] if k else run.row[row]
        lacking = self._model.ocean.uncovered(jit.Array3f64(*(float(v) for v in last[:3])), jit.Float64(t_s))
        agent = self._model.agents[batch.members[row // batch.n]]
        return NotFinite(agent, row % batch.n, t_s, last, run.command_of(row), lacking)


def _sound(rows: NDArray[np.float64]) -> bool:
    """Whether all of `(n, CHANNELS)` is finite, and nothing is too far to come back."""
    if len(rows) == 1:  # NumPy's calls take longer than the sums
        row = rows[0].tolist()
        return math.isfinite(sum(row)) and max(map(abs, row[:3])) <= FARTHEST_M
    return math.isfinite(float(rows.sum())) and float(np.abs(rows[:, 0:3]).max()) <= FARTHEST_M
