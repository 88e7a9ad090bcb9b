"""The log of a run: readings, true motion and movers, on their way into a recording."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pelagos.config.loader import to_yaml
from pelagos.config.swarm import group_of
from pelagos.math.so3 import rotate_back_np
from pelagos.sim.command_log import COMMANDS, CommandLog, declare_commands
from pelagos.sim.guidance.outline import outline, start_of
from pelagos.sim.prop_log import PropLog
from pelagos.sim.record import Recorder
from pelagos.sim.sampled import Sampled
from pelagos.world.legend import legend

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation


class RunLog:
    """Writes what a simulation does, from the tick at which it stands, into a recorder.

    Attributes:
        recorder: where it goes.
    """

    def __init__(self, sim: Simulation, recorder: Recorder) -> None:
        self._sim, self.recorder = sim, recorder
        tick = sim.stepper.tick
        self._moved = tick if tick == 0 else tick + 1  # movers are written down from this tick on
        self._props, self._commands = PropLog(sim, recorder), CommandLog(sim, recorder)
        self._begins = tick == 0
        self._navigated = tick - 1

    def begin(self, sampled: Sequence[Sampled] | None = None) -> None:
        """Write down tick 0 with its readings, where the log begins there; the second time nothing."""
        if self._begins:
            self._begins = False
            self.readings(self._sim.stepper.read_now() if sampled is None else sampled)
            self.motion()

    def readings(self, sampled: Sequence[Sampled]) -> None:
        """Write down readings."""
        start = time.perf_counter()
        for one in sampled:
            t_ns = np.array(one.ticks, dtype=np.int64) * self._sim.dt_ns
            for part in one.each(self._sim.n):
                self.recorder.write_block(part.members[0], part.model.name, t_ns, part.measurement, n=self._sim.n)
        self.recorder.gather()
        if sampled:
            self._sim.stepper.timings.add("record", start)

    def look(self) -> None:
        """Note what was moved before the block that begins."""
        self._props.look()

    def motion(self) -> None:
        """Write down the motion of the last block of ticks."""
        start = time.perf_counter()
        stepper, clock = self._sim.stepper, self._sim.model.clock
        period = clock.period(self._sim.scenario.record.state_rate_hz)
        first, self._moved = -(-self._moved // period) * period, self._sim.stepper.tick + 1
        ticks = np.arange(first, self._moved, period, dtype=np.int64)
        self._movers(ticks)
        self._props.write(ticks)
        for batch in self._sim.model.batches.values():
            trajectory = stepper.trajectories[batch.name]
            due = np.array(trajectory.due(period), dtype=np.int64)
            for name in batch.members:
                self._commands.write(name, trajectory, period)
            if not len(due):
                continue
            whole = trajectory.numpy()[due - trajectory.first_tick]
            for member, name in enumerate(batch.members):
                motion = whole[:, batch.rows_of(member)]
                parts = (motion[..., 0:3], motion[..., 3:7], motion[..., 7:10], motion[..., 10:13])
                self.recorder.write_truth_block(name, due * clock.dt_ns, *parts)
        self._navigation()
        self.recorder.gather()
        stepper.timings.add("record", start)

    def _navigation(self) -> None:
        """Write down what the navigation of agents has known since."""
        since, dt_ns = self._navigated, self._sim.dt_ns
        for name, solutions in self._sim.stepper.missions.solutions.items():
            new = [s for s in solutions if s.tick > since]
            if not new:
                continue
            self._navigated = max(self._navigated, new[-1].tick)
            t_ns = np.array([s.tick for s in new], dtype=np.int64) * dt_ns
            position, attitude, world, rate = (
                np.stack([getattr(s, k) for s in new]) for k in ("position", "attitude", "velocity", "rate")
            )
            velocity = rotate_back_np(attitude.reshape(-1, 4), world.reshape(-1, 3)).reshape(world.shape)
            self.recorder.write_navigation_block(name, t_ns, position, attitude, velocity, rate)

    def _movers(self, ticks: NDArray[np.int64]) -> None:
        """Write down where movers were at the same ticks: where they are depends on the tick alone."""
        for mover in self._sim.world.movers:
            if mover.name in self.recorder.movers and len(ticks):
                poses = [mover.pose(tick * self._sim.dt_ns * 1e-9) for tick in ticks.tolist()]
                q = np.stack([p.attitude for p in poses])
                self.recorder.write_mover_block(
                    mover.name,
                    ticks * self._sim.dt_ns,
                    np.stack([p.position for p in poses]),
                    q,
                    rotate_back_np(q, np.stack([p.velocity for p in poses])),
                    rotate_back_np(q, np.stack([p.angular_velocity for p in poses])),
                )


def open_recorder(path: Path, sim: Simulation, *, writer: Any = None, by_member: bool = False) -> Recorder:
    """A recorder for every sensor of `sim`.

    Args:
        path: the file.
        sim: the simulation.
        writer: stands in for the file, see `Recorder`.
        by_member: record every member of a group for itself, whatever the scenario asks for.

    Raises:
        RecordingError: the file cannot be written.
    """
    scenario = sim.scenario
    sensors = {name: {s: m.config for s, m in agent.sensors.items()} for name, agent in sim.model.agents.items()}
    origin = (sim.world.origin.latitude, sim.world.origin.longitude)
    moving = sim.moving
    names = legend(sim.world, moving)
    together = () if by_member or scenario.record.groups == "by_member" else tuple(sim.model.groups)
    made = Recorder(
        path, to_yaml(scenario), sim.seed, sensors, None, origin, sim.dt_ns,
        copies=sim.n, legend=names, together=together, writer=writer,
    )  # fmt: skip
    for name, agent in sim.model.agents.items():
        if agent.config.navigation.type != "truth":
            made.add_navigation(name, agent.config.navigation.type)
        if agent.tasks:
            made.add_plan(name, outline(agent.tasks, start_of(agent.config.start, sim.world.height), sim.world.height))
    if scenario.record.commands:
        declare_commands(made, sim)
    for mover in sim.world.movers:
        number, instance = next((g.label, g.instance) for g in moving if g.name == mover.name)
        made.add_mover(
            mover.name,
            {"mover": mover.name, "body": mover.body, "label": names["labels"][str(number)]["name"],
             "label_number": str(number), "instance": str(instance)},
        )  # fmt: skip
    made.begin()
    return made


def of_the_next_step(recorder: Recorder, sim: Simulation) -> set[int]:
    """Numbers of the channels whose messages at a tick come with the step that begins there, not with that before.

    These are the commands that act in it, and what navigation knows, which is worked out when a step asks for it.
    """
    topics: set[str] = set()
    for name, agent in sim.model.agents.items():
        if sim.scenario.record.commands:
            topics |= {f"/{place}/{COMMANDS}" for place in recorder.places(name)}
        if agent.config.navigation.type != "truth":
            topics |= {f"/{place}/navigation" for who in (name, group_of(name)) for place in recorder.places(who)}
    return {number for number in map(recorder.number, topics) if number is not None}
