"""A task and its vehicle's physics as two kernels: one that steps, one that begins episodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Literal

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.envs.draws import Draws
from pelagos.envs.task import Start, Task
from pelagos.envs.view import View
from pelagos.errors import CommandError, ScenarioError
from pelagos.jit import Array
from pelagos.math.frames import flip_quaternion, flip_yz
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.waves import Changed
from pelagos.vehicles.state import VehicleState, channels_of, pack, unpack
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.varied import check_names, varied
from pelagos.vehicles.vehicle import Vehicle

Autoreset = Literal["same_step", "next_step", "disabled"]
TERMINATED: Final = 1
TRUNCATED: Final = 2
NOT_FINITE: Final = 4
CLIPPED: Final = 8
NO_NUMBER: Final = 16
LARGEST: Final = 1e6  # number of an observation: what is beyond is clipped
FIRST_EPISODE: Final = 0xFFFFFFFF  # the next one is number 0
_FARTHEST_M: Final = 1e9  # from there no vehicle comes back
_DRAWING: Final = 0xFFFFFFFF  # moment of the numbers that an episode begins with
_CURRENT: Final = ("current.x", "current.y", "current.z")
_SEA: Final = ("sea.scale", "sea.turn_rad", "sea.moment_s")


@jit.struct
class Constants:
    """h: tick [s]; decision: [s]; seed; first: environment of copy 0; limit: decisions of an episode; ticks: of one."""

    h: Array
    decision: Array
    seed: Array
    first: Array
    limit: Array
    ticks: Array
    tables: Tables | None


@dataclass
class _Life:
    """A copy's state between two steps."""

    state: VehicleState
    memory: dict[str, Array]


class Program:
    """Two frozen functions over packed arrays; see `step` and `begin`.

    Attributes:
        n: copies.
        size: numbers of an observation.
        actions: numbers of an action.
        metrics: names.
        channels: `Float64` numbers that are kept of a copy.
        ticks: of the physics a decision.
    """

    def __init__(self, task: Task, n: int, *, seed: int, environment: int, autoreset: Autoreset) -> None:
        self.task, self.n, self.autoreset = task, n, autoreset
        self.vehicle = _vehicle(task)
        self.mode = task.control or self.vehicle.default_mode
        self.set_points = len(self.vehicle.command_names(self.mode))
        self.actions = task.actions or self.set_points
        self.size = len(task.observations)
        check_names(self.vehicle, task.vary, f"{_name(task)}.vary")
        self.ticks, limit = _whole(task)
        self.ocean = build_ocean(OceanConfig.model_validate(dict(task.ocean)), seed=seed)
        self._controller = len(_blank(self.vehicle).controller)
        self.constants = self._constants(seed, environment, limit)
        self._probe()
        self.channels = len(channels_of(_blank(self.vehicle))) + len(self.names)
        self._step, self._begin = jit.freeze(self._stepping()), jit.freeze(self._beginning())

    def name(self, seed: int, environment: int) -> None:
        """Other random streams."""
        self.constants = self._constants(seed, environment, int(self.constants.limit[0]))

    def step(self, packed: Array, counters: Array, actions: Array) -> tuple[Array, Array, Array]:
        """One decision of all copies.

        Args:
            packed: `Float64` (channels * n).
            counters: `UInt32` (3 n): decisions since the episode began, number of the episode, whether it is over.
            actions: `Float` (n * actions), a copy after the other.

        Returns:
            The next two, and `Float`: observations `(n, size)`, with `same_step` those before a reset `(n, size)`,
            rewards `(n,)`, codes `(n,)`, and a row of `(n,)` for each metric.
        """
        found: tuple[Array, Array, Array] = self._step(packed, counters, actions, self.ocean, self.constants)
        return found

    def begin(self, packed: Array, counters: Array, where: Array) -> tuple[Array, Array, Array]:
        """The next episode of the copies where `where`, `Bool` (n); and the observations of all."""
        found: tuple[Array, Array, Array] = self._begin(packed, counters, where, self.ocean, self.constants)
        return found

    # how they are made

    def _constants(self, seed: int, environment: int, limit: int) -> Constants:
        u32, f64 = jit.UInt32, jit.Float64
        h, decision = 1.0 / self.task.tick_rate_hz, 1.0 / self.task.rate_hz
        made: Constants = jit.without_constants(
            Constants(
                dr.opaque(f64, h),
                dr.opaque(f64, decision),
                dr.opaque(u32, seed & 0xFFFFFFFF),
                dr.opaque(u32, environment),
                dr.opaque(u32, limit),
                dr.opaque(u32, self.ticks),
                self.vehicle.tables,
            )
        )
        return made

    def _probe(self) -> None:
        """Ask the task once for everything, to learn its names, and to tell its author of mistakes."""
        task, zero = self.task, jit.UInt32(0)
        start = task.draw(Draws(jit.UInt32(1), zero, zero, zero))
        self.own_current = start.current is not None
        self.factors, self.remembered = list(task.vary), list(start.memory)
        self.own_sea = start.sea is not None
        if self.own_sea and self.ocean.waves is None:
            raise CommandError(f"{_name(task)}: draw gives a sea, but there are no waves in `ocean`")
        water = [*(_CURRENT if self.own_current else ()), *(_SEA if self.own_sea else ())]
        self.names = [*(f"task.{m}" for m in self.remembered), *water, *(f"vary.{f}" for f in self.factors)]
        life = self._born(start, [jit.Float64(1.0)] * len(self.factors))
        now = self._view(life, zero, self.constants, self.ocean)
        seen, where = task.observe(now, Draws(zero, zero, zero, zero)), _name(task)
        if len(seen) != self.size:
            raise CommandError(
                f"{where}: observe gives {len(seen)} numbers, but observations names {self.size}: "
                f"{', '.join(task.observations)}"
            )
        action = [jit.Float64(0.0)] * self.actions
        given = task.command(action, now)
        if len(given) != self.set_points:
            names = ", ".join(self.vehicle.command_names(self.mode))
            raise CommandError(f"{where}: command gives {len(given)} set-points of {self.mode}, which has {names}")
        outcome = task.reward(now, action)
        unknown = sorted(set(outcome.memory) - set(self.remembered))
        if unknown:
            raise CommandError(
                f"{where}: reward changes {', '.join(unknown)}, which draw does not put into the memory "
                f"({', '.join(self.remembered) or 'empty'})"
            )
        self.metrics = list(outcome.metrics)

    def _born(self, start: Start, factors: list[Array]) -> _Life:
        """The state at an episode's beginning."""
        f64, zero = jit.Float64, jit.Array3f64(0.0, 0.0, 0.0)
        attitude = jit.Array4f64(*(f64(c) for c in start.attitude))
        state = VehicleState(
            position=flip_yz(jit.Array3f64(*(f64(c) for c in start.position))),
            attitude=flip_quaternion(attitude / dr.norm(attitude)),
            velocity=flip_yz(jit.Array3f64(*(f64(c) for c in start.velocity))),
            angular_velocity=flip_yz(jit.Array3f64(*(f64(c) for c in start.angular_velocity))),
            acceleration=jit.Array3f64(zero),
            angular_acceleration=jit.Array3f64(zero),
            **self.vehicle.sizes.lists([f64(0.0) for _ in range(self.vehicle.sizes.kept)]),
            mode=f64(0.0),
            controller=[f64(0.0) for _ in range(self._controller)],
        )
        sea = () if start.sea is None else (start.sea.scale, start.sea.turn_rad, start.sea.moment_s)
        values = [*start.memory.values(), *(start.current or []), *sea, *factors]
        return _Life(state, dict(zip(self.names, (f64(v) for v in values), strict=True)))

    def _drawn(self, environment: Array, episode: Array, seed: Array) -> _Life:
        random = Draws(seed, environment, episode, jit.UInt32(_DRAWING))
        start = self.task.draw(random)
        return self._born(start, [random.uniform(*self.task.vary[f]) for f in self.factors])

    def _view(self, life: _Life, step: Array, constants: Constants, ocean: Any) -> View:
        memory = {name: life.memory[f"task.{name}"] for name in self.remembered}
        t = jit.Float64(step) * constants.decision
        count = len(self.vehicle.actuator_names)
        return View(life.state, memory, actuators=count, t=t, step=step, ocean=self._around(ocean, life))

    def _around(self, ocean: Any, life: _Life) -> Any:
        """The ocean, with a copy's own current and sea."""
        own: dict[str, Any] = {}
        if self.own_current:
            own = {"currents": [], "own": jit.Array3f64(*(life.memory[c] for c in _CURRENT))}
        if self.own_sea:
            scale, turn, moment = (life.memory[c] for c in _SEA)
            sine, cosine = dr.sincos(turn)
            own["own_waves"] = ocean.waves.with_change(Changed(scale, cosine, sine, moment))
        return ocean.with_(**own) if own else ocean

    def _read(self, packed: Array) -> _Life:
        state = unpack(packed, self.n, self.vehicle.sizes)
        memory = state.controller[self._controller :]
        state.controller = state.controller[: self._controller]
        return _Life(state, dict(zip(self.names, memory, strict=True)))

    def _write(self, life: _Life, end: Array, lane: Array) -> None:
        pack(life.state, end, lane, self.n)
        first = self.channels - len(self.names)
        for i, value in enumerate(life.memory.values()):
            dr.scatter(end, value, lane + (first + i) * self.n)

    def _choose(self, mask: Array, one: _Life, other: _Life) -> _Life:
        state = dr.select(mask, one.state, other.state)
        return _Life(state, {k: dr.select(mask, one.memory[k], other.memory[k]) for k in self.names})

    def _observed(self, life: _Life, environment: Array, episode: Array, step: Array, c: Constants, ocean: Any) -> Any:
        random = Draws(c.seed, environment, episode, step)
        seen = self.task.observe(self._view(life, step, c, ocean), random)
        return [jit.Float(dr.clip(jit.Float64(o), -LARGEST, LARGEST)) for o in seen]

    def _beginning(self) -> Callable[..., tuple[Array, Array, Array]]:
        n = self.n

        def begin(packed: Array, counters: Array, where: Array, ocean: Any, constants: Constants) -> Any:
            lane = dr.arange(jit.UInt32, n)
            step, episode, over = (dr.gather(jit.UInt32, counters, lane + i * n) for i in range(3))
            number = dr.select(where, episode + 1, episode)
            environment = constants.first + lane
            life = self._choose(where, self._drawn(environment, number, constants.seed), self._read(packed))
            step = dr.select(where, 0, step)
            obs = dr.empty(jit.Float, n * self.size)
            seen = self._observed(life, environment, number, step, constants, ocean)
            end = dr.empty(jit.Float64, self.channels * n)
            counts = dr.empty(jit.UInt32, 3 * n)
            for i, value in enumerate(seen):
                dr.scatter(obs, value, lane * self.size + i)
            self._write(life, end, lane)
            for i, count in enumerate((step, number, dr.select(where, 0, over))):
                dr.scatter(counts, count, lane + i * n)
            return end, counts, obs

        return begin

    def _stepping(self) -> Callable[..., tuple[Array, Array, Array]]:
        from pelagos.envs.turn import Turn

        n, size = self.n, self.size
        final = size if self.autoreset == "same_step" else 0
        width = size + final + 2 + len(self.metrics)

        def step(packed: Array, counters: Array, actions: Array, ocean: Any, constants: Constants) -> Any:
            end, counts = dr.empty(jit.Float64, self.channels * n), dr.empty(jit.UInt32, 3 * n)
            out = dr.empty(jit.Float, n * width)
            lane = dr.arange(jit.UInt32, n)
            before = self._read(packed)
            turn = Turn(self, lane, counters, actions, before, ocean, constants)
            factors = {f: before.memory[f"vary.{f}"] for f in self.factors}
            vehicle, around = varied(self.vehicle, factors), self._around(ocean, before)
            none = jit.Array3f64(0.0, 0.0, 0.0)

            def finish(i: Array, state: VehicleState) -> Array:  # behind the loop every scatter would be a kernel
                turn.finish(state, end, counts, out)
                return i + 0

            def advance(i: Array, state: VehicleState) -> tuple[Array, VehicleState]:
                t = turn.t + jit.Float64(i) * constants.h
                made = vehicle.step(
                    state, turn.commands, around, t, (none, none), constants.h, self.mode, constants.tables
                )
                dr.if_stmt((i, made), i + 1 == constants.ticks, finish, lambda i, made: i + 0, mode="symbolic")
                return i + 1, made

            first = dr.zeros(jit.UInt32, n)
            dr.while_loop((first, before.state), lambda i, _: i < constants.ticks, advance, mode="symbolic")
            return end, counts, out

        return step


def sound(state: VehicleState) -> Array:
    """Lanes whose state is finite, and not so far away that it will not be soon."""
    whole = sum(channels_of(state))
    near = dr.max(dr.abs(state.position)) < _FARTHEST_M
    return dr.isfinite(whole) & near


def _blank(vehicle: Vehicle) -> VehicleState:
    return vehicle.initial_state(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]))


def _name(task: Task) -> str:
    return type(task).__name__


def _vehicle(task: Task) -> Vehicle:
    given = task.vehicle
    vehicle = Vehicle.from_catalogue(given) if isinstance(given, str) else Vehicle.from_dict(given)
    if task.control:
        vehicle.check_mode(task.control)
    if vehicle.model.on_host:
        raise ScenarioError(f"{_name(task)}: a vehicle with a term in NumPy cannot be compiled into a kernel")
    return vehicle


def _whole(task: Task) -> tuple[int, int]:
    """Ticks of a decision, and decisions of an episode."""
    ticks, steps = task.tick_rate_hz / task.rate_hz, task.seconds * task.rate_hz
    if abs(ticks - round(ticks)) > 1e-9 or round(ticks) < 1:
        raise CommandError(
            f"{_name(task)}: tick_rate_hz {task.tick_rate_hz:g} is no whole multiple of rate_hz {task.rate_hz:g}"
        )
    if round(steps) < 1:
        raise CommandError(f"{_name(task)}: seconds {task.seconds:g} at rate_hz {task.rate_hz:g} is less than a step")
    return round(ticks), round(steps)
