"""Start states of all agents, checked against the world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.config.agent import Start
from pelagos.errors import CommandError, LookupFailed, ScenarioError
from pelagos.math.frames import flip_quaternion_np
from pelagos.math.so3 import from_euler, rotate_back_np, rotate_np, yaw_np
from pelagos.ocean.ocean import Ocean
from pelagos.sim.bodies import rows, unit_rows
from pelagos.sim.model import AgentModel, Model
from pelagos.vehicles.wetness import Floating
from pelagos.world.world import World

_QUANTITIES: Final = {"position": 3, "attitude": 4, "velocity": 3, "angular_velocity": 3}


@dataclass(frozen=True)
class StartState:
    """`(n, 3)` position NWU, `(n, 4)` attitude, `(n, 3)` velocity and (0 where None) angular velocity FLU."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    angular_velocity: NDArray[np.float64] | None = None


def start_states(model: Model) -> dict[str, StartState]:
    """By agent.

    Raises:
        ScenarioError: an agent starts outside the world, inside the seabed, or inside something that stands there.
    """
    places = {
        name: _position(agent.config.start, model.world, model.scenario.where("agents", name, "start"))
        for name, agent in model.agents.items()
    }
    motions = {}
    for name, agent in model.agents.items():
        if _rides(agent, model.ocean):
            heading, first = np.array([math.radians(agent.config.start.heading_deg)]), np.zeros(1, dtype=np.uint32)
            height, motion = _surface(agent, model.ocean, places[name][None], heading, first)
            places[name][2], motions[name] = height[0], motion[0]
    found = {}
    for batch in model.batches.values():
        near = model.world.near(np.array([places[name] for name in batch.members]), batch.vehicle.bounding_radius_m)
        for name, close in zip(batch.members, near.tolist(), strict=True):
            found[name] = _start(model.agents[name], model, places[name], motions.get(name), close=close)
    return {name: found[name] for name in model.agents}


def starts(
    begin: Mapping[str, StartState], state: Mapping[str, Mapping[str, Any]] | None, where: NDArray[np.bool_]
) -> dict[str, StartState]:
    """The scenario's starts, changed by agent and quantity in some copies; see `Simulation.reset`.

    Raises:
        CommandError: an unknown agent or quantity, a wrong shape, a value that is not finite.
    """
    changed = dict(begin)
    for name, parts in (state or {}).items():
        if name not in begin:
            raise CommandError(str(LookupFailed("agent", name, begin)))
        made = {k: _spread(v, where, f"{name}: {k}", k) for k, v in parts.items()}
        was = {k: v for k, v in vars(begin[name]).items() if v is not None}
        kept = {k: np.where(where[:, None], v, was.get(k, 0.0)) for k, v in made.items()}
        changed[name] = replace(begin[name], **kept)
    return changed


def _spread(values: object, where: NDArray[np.bool_], what: str, quantity: str) -> NDArray[np.float64]:
    """`(k,)`, `(n, k)`, or `(m, k)` for the m copies chosen, as `(n, k)`."""
    if quantity not in _QUANTITIES:
        raise CommandError(str(LookupFailed("quantity of a state", quantity, _QUANTITIES)))
    n, m = len(where), int(where.sum())
    if m < n and np.shape(np.asarray(values))[:-1] == (m,):
        full = np.ones((n, _QUANTITIES[quantity]))
        full[where] = (
            unit_rows(values, m, what) if quantity == "attitude" else rows(values, m, _QUANTITIES[quantity], what)
        )
        return full
    return unit_rows(values, n, what) if quantity == "attitude" else rows(values, n, _QUANTITIES[quantity], what)


def _start(
    agent: AgentModel, model: Model, position: NDArray[np.float64], motion: NDArray[np.float64] | None, *, close: bool
) -> StartState:
    """`motion`: of the water that it goes with (3) NWU [m/s]; `close` says that something may be within reach."""
    start = agent.config.start
    where = model.scenario.where("agents", agent.name, "start")
    angles = (math.radians(a) for a in (start.roll_deg, start.pitch_deg, start.heading_deg))
    attitude = flip_quaternion_np(np.array([float(c) for c in from_euler(*angles)]))
    close = close and not start.anywhere
    why = (model.world.inside(position[None]) or _touched(agent, model.world, position, attitude)) if close else None
    if why is not None:
        raise ScenarioError(f"{agent.name} cannot start here: {why}", where=where)
    n, velocity = model.n, np.array([start.speed_mps, 0.0, 0.0])
    if motion is not None:
        velocity = velocity + rotate_back_np(attitude[None], motion[None])[0]
    return StartState(np.tile(position, (n, 1)), np.tile(attitude, (n, 1)), np.tile(velocity, (n, 1)))


def _rides(agent: AgentModel, ocean: Ocean) -> bool:
    """Whether it floats, and starts at whatever height the surface has, which is not the mean."""
    if (ocean.waves is None and ocean.tide is None) or not isinstance(agent.vehicle.model.wetting, Floating):
        return False
    start = agent.config.start
    return len(start.position_m) == 2 and start.depth_m is None and start.altitude_m is None


def on_its_sea(agent: AgentModel, ocean: Ocean, begin: StartState, state: StartState) -> StartState:
    """The start of what floats, in each copy at the height and with the motion of that copy's sea.

    Args:
        agent: what starts.
        ocean: with the sea of each copy.
        begin: the scenario's start.
        state: where and how it begins in each copy, at the height and with the motion of the scenario's sea.
    """
    if not _rides(agent, ocean):
        return state
    copy = np.arange(len(state.position), dtype=np.uint32)
    was, moved = _surface(agent, ocean.with_(own_waves=None), begin.position, -yaw_np(begin.attitude), copy)
    height, motion = _surface(agent, ocean, state.position, -yaw_np(state.attitude), copy)
    position = state.position + np.outer(height - was, (0, 0, 1))
    velocity = state.velocity + rotate_back_np(state.attitude, motion) - rotate_back_np(begin.attitude, moved)
    return replace(state, position=position, velocity=velocity)


def _surface(
    agent: AgentModel, ocean: Ocean, position: NDArray[np.float64], heading: NDArray[np.float64],
    copy: NDArray[np.uint32],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Height of the surface under hulls at t = 0 `(m,)` [m], and the velocity of its water under the waves `(m, 3)` NWU
    [m/s], at positions `(m, 3)`, headings `(m,)` [rad] and in copies `(m,)`.

    Means over the waterplane, as a hull longer than the waves follows them.
    """
    size = agent.vehicle.config
    ahead, aside = np.meshgrid(np.linspace(-0.4, 0.4, 9) * size.length_m, np.linspace(-0.4, 0.4, 3) * size.beam)
    sin, cos = (f(heading)[:, None] for f in (np.sin, np.cos))
    x = jit.Float64((position[:, :1] + cos * ahead.ravel() - sin * aside.ravel()).ravel())
    y = jit.Float64((position[:, 1:2] - sin * ahead.ravel() - cos * aside.ravel()).ravel())
    now, row = jit.Float64(0.0), jit.from_numpy(jit.UInt32, np.repeat(copy, ahead.size))
    height = ocean.elevation(x, y, now, row)
    motion = ocean.wave_motion(jit.Array3f64(x, y, height), now, row)
    velocity = np.zeros((3, len(position)))
    if motion is not None:
        velocity = np.array(motion.velocity).reshape(3, len(position), -1).mean(axis=2)
    return np.broadcast_to(np.array(height), (len(x),)).reshape(len(position), -1).mean(axis=1), velocity.T


def _touched(
    agent: AgentModel, world: World, position: NDArray[np.float64], attitude: NDArray[np.float64]
) -> str | None:
    """Things that the hull would overlap, found by its contact probes."""
    starts, vectors = agent.vehicle.probes
    q = np.repeat(attitude[None], len(starts), axis=0)
    length = np.linalg.norm(vectors, axis=1)
    hits = world.cast(position + rotate_np(q, starts), rotate_np(q, vectors), length)
    if not hits.valid.any():
        return None
    x, y, z = (f"{c:.2f}" for c in position)
    name = world.names.get(int(hits.instance[np.argmin(hits.t)]), "something")
    return f"at ({x}, {y}, {z}) m its hull would touch {name}"


def _position(start: Start, world: World, where: str) -> NDArray[np.float64]:
    x, y = start.position_m[:2]
    if len(start.position_m) == 3:
        return np.array(start.position_m, dtype=np.float64)
    if start.altitude_m is None:
        return np.array([x, y, -(start.depth_m or 0.0)])
    bottom = float(np.asarray(world.height(np.array([x]), np.array([y]))).ravel()[0])
    if not math.isfinite(bottom):
        raise ScenarioError(f"there is no seabed below x {x:g}, y {y:g} m to measure altitude_m from", where=where)
    return np.array([x, y, bottom + start.altitude_m])
