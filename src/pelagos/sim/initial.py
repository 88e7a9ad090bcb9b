"""Where every agent begins, checked against the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.config.agent import Start
from pelagos.errors import ScenarioError
from pelagos.math.frames import flip_quaternion_np
from pelagos.math.so3 import from_euler, rotate_np
from pelagos.sim.model import AgentModel, Model
from pelagos.world.world import World


@dataclass(frozen=True)
class StartState:
    """`(n, 3)` position NWU, `(n, 4)` attitude, `(n, 3)` velocity FLU."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]


def start_states(model: Model) -> dict[str, StartState]:
    """By agent.

    Raises:
        ScenarioError: an agent starts outside the world, inside the seabed, or inside something that stands there.
    """
    return {name: _start(agent, model) for name, agent in model.agents.items()}


def _start(agent: AgentModel, model: Model) -> StartState:
    start = agent.config.start
    where = model.scenario.where("agents", agent.name, "start")
    position = _position(start, model.world, where)
    angles = (math.radians(a) for a in (start.roll_deg, start.pitch_deg, start.heading_deg))
    attitude = flip_quaternion_np(np.array([float(c) for c in from_euler(*angles)]))
    why = model.world.inside(position[None]) or _touched(agent, model.world, position, attitude)
    if why is not None:
        raise ScenarioError(f"{agent.name} cannot start here: {why}", where=where)
    n = model.n
    return StartState(
        np.tile(position, (n, 1)), np.tile(attitude, (n, 1)), np.tile(np.array([start.speed_mps, 0.0, 0.0]), (n, 1))
    )


def _touched(
    agent: AgentModel, world: World, position: NDArray[np.float64], attitude: NDArray[np.float64]
) -> str | None:
    """What the hull would overlap, found by its contact probes."""
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
