"""Props that fall: straight down, until the seabed, or something that stands there, holds them.

A vehicle that a prop has come down on, so that it lies within, is pushed out sideways: rays of contact from a hull
inside a body meet none of its faces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from pelagos.math.constants import GRAVITY
from pelagos.math.so3 import rotate_back_np
from pelagos.sim.bodies import Body

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

_FAR: Final = 10_000.0  # [m]: no ground below
_PUSH_MPS: Final = 3.0  # of what lies within a prop, as game engines part bodies that overlap


class Falling:
    """A spawned body in free fall, without drag or buoyancy; what it lands on does not move.

    Args:
        body: the spawned body, in every copy.
        reach: from its origin to its lowest point [m].
        radius: of a vertical cylinder about it, within which vehicles are pushed aside [m].
    """

    def __init__(self, body: Body, reach: float, radius: float = 0.0) -> None:
        self.body, self._reach, self._radius = body, float(reach), float(radius)
        self.rests = False

    def step(self, sim: Simulation, h: float) -> None:
        """Fall for h [s], at most to what lies below in the world; other bodies and vehicles are passed through, and
        push each other apart by contact."""
        body = self.body
        down = np.tile([0.0, 0.0, -1.0], (len(body.position), 1))
        below = sim.world.cast(body.position, down, _FAR, bodies=False)
        room = np.where(below.valid, below.t, np.inf) - self._reach
        speed = body.velocity[:, 2] - GRAVITY * h
        drop = np.minimum(-speed * h, np.maximum(room, 0.0))
        held = drop < -speed * h - 1e-12
        position, velocity = body.position.copy(), np.zeros_like(body.velocity)
        position[:, 2] -= drop
        velocity[:, 2] = np.where(held, 0.0, speed)
        body.move(position=position, velocity=velocity)
        self.rests = bool(held.all()) and not self._push_aside(sim)

    def _push_aside(self, sim: Simulation) -> bool:
        """Move vehicles whose origin lies within outwards; whether there was one."""
        found = False
        for name, state in sim.state.items():
            apart = state.position - self.body.position
            way = np.hypot(apart[:, 0], apart[:, 1])
            within = (way < self._radius) & (np.abs(apart[:, 2]) < self._reach)
            if not within.any():
                continue
            found = True
            out = np.where(way[:, None] > 1e-6, apart[:, :2] / np.maximum(way, 1e-6)[:, None], [1.0, 0.0])
            pushed = np.concatenate([_PUSH_MPS * out, np.zeros((len(out), 1))], axis=1)
            body_axes = rotate_back_np(state.attitude, pushed)
            sim.set_state(name, velocity=body_axes, where=within)
        return found
