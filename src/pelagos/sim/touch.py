"""Contact of an agent by hull rays, cast only where a coarse test says that something may be near."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.contact.probe import HullProbes, hull_probes, probe_wrench
from pelagos.jit import Array
from pelagos.math.frames import flip_quaternion, flip_yz
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY
from pelagos.sim.bodies import Bodies
from pelagos.sim.state import AgentState
from pelagos.vehicles.state import unpack

if TYPE_CHECKING:
    from pelagos.sim.model import AgentModel, Model

GAP_M = 0.05  # bodies nearer than this to the swept sphere are asked for by rays


class Touch:
    """The contact of one agent with everything around it."""

    def __init__(self, agent: AgentModel, model: Model, bodies: Bodies) -> None:
        self._agent, self._model, self._bodies = agent, model, bodies
        self._call: Callable[..., tuple[Array, Array]] | None = None
        self._arguments: tuple[Any, ...] = ()

    def possible(
        self,
        position: NDArray[np.float64],
        way: NDArray[np.float64],
        agents: Callable[[], Mapping[str, AgentState]],
        *,
        now: bool = False,
    ) -> bool:
        """Whether a hull at `position` `(n, 3)` may touch anything before it has gone `way` `(n,)` [m], or `now`."""
        margin = self._agent.vehicle.bounding_radius_m + way + GAP_M
        if bool(np.any(self._model.world.near(position, margin))):
            return True
        return self._bodies.any and self._bodies.near(
            position, margin, agent=self._agent.name, agents=agents(), now=now
        )

    def wrench(self, state: Array) -> tuple[Array, Array]:
        """Force and moment about the body's origin, FRD, `Array3f64` of `n` lanes [N], [N m], of a packed state."""
        if self._call is None:
            self._call, self._arguments = self._build()
        force, moment = self._call(state, *self._arguments)
        return force, moment

    def _build(self) -> tuple[Callable[..., tuple[Array, Array]], tuple[Any, ...]]:
        n, vehicle = self._model.n, self._agent.vehicle
        starts, vectors = vehicle.probes
        turn = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # FRD -> FLU
        own = self._bodies.own_rows(self._agent.name)
        arguments = (
            self._model.world.material_tables(),
            hull_probes(starts, vectors, turn @ vehicle.config.body.mass_matrix @ turn),
            jit.UInt32(np.full(n, NO_BODY, dtype=np.uint32) if own is None else own),
            dr.arange(jit.UInt32, n),
            dr.opaque(jit.Float64, self._model.clock.dt_ns * 1e-9),
        )
        dr.make_opaque(arguments)
        actuators = vehicle.kept_actuators
        return self._model.scene.compile(_touch(n, actuators)), arguments


def _touch(n: int, actuators: int) -> Callable[..., tuple[Array, Array]]:
    def touch(
        caster: Caster, packed: Array, materials: Any, probes: HullProbes, own: Array, copy: Array, h: Array
    ) -> tuple[Array, Array]:
        state = unpack(packed, n, actuators=actuators)
        force, moment = probe_wrench(
            caster,
            materials,
            probes,
            position=flip_yz(state.position),
            attitude=flip_quaternion(state.attitude),
            velocity=flip_yz(state.velocity),
            angular_velocity=flip_yz(state.angular_velocity),
            own=own,
            copy=copy,
            h=h,
        )
        return flip_yz(force), flip_yz(moment)

    return touch
