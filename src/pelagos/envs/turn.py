"""The parts of a step around the physics: the command before it; outcome, reset and observation in its last tick."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.vehicles.state import VehicleState

if TYPE_CHECKING:
    from pelagos.envs.program import Constants, Program, _Life


class Turn:
    """One decision of all lanes.

    Attributes:
        commands: set-points.
        t: at the beginning, since each episode began [s].
    """

    def __init__(
        self, program: Program, lane: Array, counters: Array, actions: Array, before: _Life, ocean: Any, c: Constants
    ) -> None:
        n, p = program.n, program
        self._p, self._lane, self._before, self._ocean, self._c = p, lane, before, ocean, c
        self._step, self._episode, over = (dr.gather(jit.UInt32, counters, lane + i * n) for i in range(3))
        self._over = over != 0
        self._environment = c.first + lane
        raw = [dr.gather(jit.Float, actions, lane * p.actions + i) for i in range(p.actions)]
        self._no_number = ~dr.isfinite(sum(raw))
        self._clipped = sum((jit.UInt32(dr.abs(a) > 1) for a in raw), jit.UInt32(0)) > 0
        self.action = [dr.select(dr.isfinite(a), dr.clip(jit.Float64(a), -1.0, 1.0), 0.0) for a in raw]
        now = p._view(before, self._step, c, ocean)
        self.commands = [jit.Float64(v) for v in p.task.command(self.action, now)]
        self.t = now.t

    def finish(self, state: VehicleState, end: Array, counts: Array, out: Array) -> None:
        """Write what the step came to: the next states and counts, and what the caller gets."""
        from pelagos.envs import program as codes

        p, c, step = self._p, self._c, self._step + 1
        fine = codes.sound(state)
        life = type(self._before)(dr.select(fine, state, self._before.state), dict(self._before.memory))
        outcome = p.task.reward(p._view(life, step, c, self._ocean), self.action)
        for name, value in outcome.memory.items():
            key = f"task.{name}"
            life.memory[key] = dr.select(fine, jit.Float64(value), life.memory[key])
        terminated = jit.Bool(outcome.terminated) | ~fine
        truncated = ~terminated & (step >= c.limit)
        reward = dr.select(fine, jit.Float(outcome.reward), 0)
        metrics = [jit.Float(v) for v in outcome.metrics.values()]
        seen = p._observed(life, self._environment, self._episode, step, c, self._ocean)
        done = terminated | truncated
        anew = {"same_step": done, "next_step": self._over, "disabled": jit.Bool(False)}[p.autoreset]
        if p.autoreset == "same_step":
            self._scatter_rows(out, seen, p.n * p.size)
        code = dr.select(terminated, jit.UInt32(codes.TERMINATED), 0) | dr.select(truncated, codes.TRUNCATED, 0)
        code |= dr.select(fine, 0, codes.NOT_FINITE) | dr.select(self._clipped, codes.CLIPPED, 0)
        code |= dr.select(self._no_number, codes.NO_NUMBER, 0)
        if p.autoreset == "next_step":
            code, reward = dr.select(anew, 0, code), dr.select(anew, 0, reward)
        number, over = self._episode, dr.select(done, jit.UInt32(1), 0)
        if p.autoreset != "disabled":
            life, seen, step, number = self._renewed(anew, life, seen, step)
            over = dr.select(anew, 0, over)
        self._write(end, counts, life, (step, number, over))
        self._scatter_rows(out, seen, 0)
        first = p.n * p.size * (2 if p.autoreset == "same_step" else 1)
        for i, value in enumerate((reward, jit.Float(code), *metrics)):
            dr.scatter(out, value, self._lane + (first + i * p.n))

    def _renewed(self, anew: Array, life: Any, seen: list[Array], step: Array) -> Any:
        """The same where an episode goes on, and its successor's beginning where it does not."""
        p, c, kind = self._p, self._c, type(life)

        def fresh(state: VehicleState, memory: dict[str, Array], seen: list[Array], step: Array, number: Array) -> Any:
            number = number + 1
            born = p._drawn(self._environment, number, c.seed)
            zero = jit.UInt32(0)
            obs = p._observed(born, self._environment, number, zero, c, self._ocean)
            return born.state, born.memory, obs, zero, number

        def same(state: VehicleState, memory: dict[str, Array], seen: list[Array], step: Array, number: Array) -> Any:
            return state, memory, seen, step, number

        given = (life.state, life.memory, seen, step, self._episode)
        state, memory, seen, step, number = dr.if_stmt(given, anew, fresh, same, mode="symbolic")
        return kind(state, memory), seen, step, number

    def _scatter_rows(self, out: Array, values: list[Array], first: int) -> None:
        for i, value in enumerate(values):
            dr.scatter(out, value, self._lane * self._p.size + (first + i))

    def _write(self, end: Array, counts: Array, life: Any, counters: tuple[Array, ...]) -> None:
        self._p._write(life, end, self._lane)
        for i, count in enumerate(counters):
            dr.scatter(counts, count, self._lane + i * self._p.n)
