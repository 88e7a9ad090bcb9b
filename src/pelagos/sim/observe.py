"""Readings at given poses without a step: what sensors of a vehicle would say there, for a batch of poses at once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import CommandError, LookupFailed
from pelagos.sensors.sensor import Kinematics, Reading
from pelagos.sim.bodies import rows, unit_rows
from pelagos.sim.episodes import stream_of
from pelagos.sim.trajectory import CHANNELS, kinematics

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation


def of_a_run(sensor: object) -> bool:
    """True of a sensor, or its class, that tells of a run, and has nothing to say at a pose alone (see `Sensor`)."""
    return bool(getattr(sensor, "EVENTS", False) or getattr(sensor, "OF_A_RUN", False))


def observe(
    sim: Simulation,
    agent: str,
    motion: tuple[object, object, object, object],
    *,
    sensors: Iterable[str] | None,
    copy: int,
    episode: int,
) -> dict[str, Reading]:
    """See `Simulation.observe`; `motion` is position, attitude, velocity and angular velocity."""
    built = sim.model.agents[agent].sensors
    chosen = [name for name, m in built.items() if not of_a_run(m.sensor)] if sensors is None else list(sensors)
    for name in chosen:
        if name not in built:
            raise LookupFailed("sensor", name, built, where=agent)
        if of_a_run(built[name].sensor):
            raise CommandError(f"{agent}.{name} says what happened in a run; at a pose alone it has nothing to say")
    if not 0 <= copy < sim.n:
        raise CommandError(f"copy is one of 0 to {sim.n - 1}, not {copy!r}")
    if episode < 0:
        raise CommandError(f"an episode is a whole number from 0 on, not {episode!r}")
    table = _table(*motion)
    lanes = _lanes(sim, table, copy, episode)
    sim.show_now(table[:, 0:3])
    return dict(sim.stepper.sensing.read_at([built[name] for name in chosen], agent, lanes))


def _table(position: object, attitude: object, velocity: object, angular_velocity: object) -> NDArray[np.float64]:
    """`(m, CHANNELS)` motion, without acceleration."""
    places = np.atleast_2d(np.asarray(position, dtype=np.float64))
    m = len(places)
    table = np.zeros((m, CHANNELS))
    table[:, 0:3] = rows(places, m, 3, "position")
    table[:, 3:7] = unit_rows(attitude, m, "attitude")
    table[:, 7:10] = rows(velocity, m, 3, "velocity")
    table[:, 10:13] = rows(angular_velocity, m, 3, "angular_velocity")
    return table


def _lanes(sim: Simulation, table: NDArray[np.float64], copy: int, episode: int) -> Kinematics:
    m, tick = len(table), sim.stepper.tick
    first = sim.model.first_environment
    streams = stream_of(np.arange(first, first + m, dtype=np.int64), np.full(m, episode, dtype=np.int64))
    c: list[Any] = [jit.from_numpy(jit.Float64, np.ascontiguousarray(column)) for column in table.T]
    t_ns = tick * sim.dt_ns
    made = kinematics(
        c,
        tick=dr.full(jit.UInt32, tick, m),
        t_ns=dr.full(jit.UInt64, t_ns, m),
        age_ns=dr.full(jit.UInt64, t_ns, m),
        environment=jit.from_numpy(jit.UInt32, streams),
        copy=dr.full(jit.UInt32, copy, m),
    )
    dr.make_opaque(made)
    return made
