"""Bodies on scripted paths, kept where they belong at each tick."""

from __future__ import annotations

from collections.abc import Sequence

from pelagos.sim.bodies import Bodies, Body
from pelagos.world.mover import MoverConfig
from pelagos.world.world import World


class Movers:
    """The movers of a world as bodies of the moving scene; where they are depends on the tick alone."""

    def __init__(self, world: World, bodies: Bodies, *, dt_ns: int) -> None:
        self._dt_ns = dt_ns
        self._tick: int | None = None
        self._moving: list[tuple[MoverConfig, Body]] = []
        there = [b for b in bodies.bodies if b.fastest_mps is not None]  # of a twin: those of its model
        made = []
        for config in world.movers if not there else ():
            geometry = config.geometry(instance=bodies.new_instance(), world=world)
            made.append((config.name, geometry, config.path.fastest_mps))
        self._moving = list(zip(world.movers, there or bodies.add_scripted(made), strict=True))

    @property
    def names(self) -> Sequence[str]:
        """Their names, in the order of the world's."""
        return [config.name for config, _ in self._moving]

    def place(self, tick: int) -> None:
        """Put every mover where it is at a tick; the scene follows with `Bodies.place`."""
        if not self._moving or tick == self._tick:
            return
        self._tick = tick
        t = tick * self._dt_ns * 1e-9
        for config, body in self._moving:
            pose = config.pose(t)
            body.move(
                position=pose.position,
                attitude=pose.attitude,
                velocity=pose.velocity,
                angular_velocity=pose.angular_velocity,
            )
