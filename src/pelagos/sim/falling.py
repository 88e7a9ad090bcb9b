"""Props that fall: straight down, until the seabed, or something that stands there, holds them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from pelagos.math.constants import GRAVITY
from pelagos.sim.bodies import Body

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

_FAR: Final = 10_000.0  # [m]: no ground below


class Falling:
    """A spawned body in free fall, without drag or buoyancy; what it lands on does not move.

    Args:
        body: the spawned body, in every copy.
        reach: from its origin to its lowest point [m].
    """

    def __init__(self, body: Body, reach: float) -> None:
        self.body, self._reach = body, float(reach)
        self.rests = False

    def step(self, sim: Simulation, h: float) -> None:
        """Fall for h [s], at most to what lies below in the world; other bodies and vehicles are passed through, and
        push each other apart by contact."""
        body = self.body
        down = np.tile([0.0, 0.0, -1.0], (len(body.position), 1))
        hits = sim.world.cast(body.position, down, _FAR)
        solid = hits.valid & ~np.isin(hits.instance, [b.geometry.instance for b in sim.bodies.bodies])
        room = np.where(solid, hits.t, np.inf) - self._reach
        speed = body.velocity[:, 2] - GRAVITY * h
        drop = np.minimum(-speed * h, np.maximum(room, 0.0))
        held = drop < -speed * h - 1e-12
        position, velocity = body.position.copy(), np.zeros_like(body.velocity)
        position[:, 2] -= drop
        velocity[:, 2] = np.where(held, 0.0, speed)
        body.move(position=position, velocity=velocity)
        self.rests = bool(held.all())
