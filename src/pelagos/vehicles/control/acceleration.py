"""Accelerations instead of an equation of motion, in water that may move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import drjit as dr

from pelagos.hydro.algebra import Vector, add, cross, dot, matvec, minus, mul, scaled, transpose
from pelagos.jit import Array
from pelagos.vehicles.actuators.t200 import T200
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.model import Model
from pelagos.vehicles.part import PartConfig
from pelagos.vehicles.wetness import shares_of


class AccelerationConfig(PartConfig):
    """Accelerations in still water, forward-right-down [m/s^2], [rad/s^2], instead of the equation of motion.

    A current, waves and wind carry the vehicle along besides, as they would the same hull without drive. What it
    touches stops it.
    """

    type: Literal["acceleration"]

    def build(self, plant: Plant) -> Carried:
        """The mode."""
        return Carried(plant.model)


@dataclass(frozen=True)
class Carried:
    """Two motions on top of each other: the one that is commanded, and the drift of the hull with the water.

    The drift's velocity obeys the equation of motion of the hull that does not turn, with all forces that depend on the
    velocity past it. Kept are that velocity in NED, and the part of the body's velocity that is due to it.
    """

    model: Model
    memory: int = 6

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return tuple(f"{axis}_acceleration" for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw"))

    def start(self, flow: Flow) -> list[Array]:
        """Part of the present velocity that counts as drift with the water: none at rest, all for who drifts."""
        water = _water(flow)
        share = dr.clip(dot(flow.nu[:3], water) / dr.maximum(dot(water, water), 1e-12), 0.0, 1.0)
        drift = scaled(share, water)
        return [*matvec(flow.rotation, drift), *drift]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The command, and what brings the drift's part of the velocity to where it should be after this step."""
        back, water, turning = transpose(flow.rotation), _water(flow), flow.nu[3:]
        drift = matvec(back, memory[:3])
        wave = add(flow.current_rate[:3], cross(turning, water))  # what is left is the water's own acceleration
        push = add(wave, self._push(flow, drift, add(drift, minus(water))))
        drift = add(drift, scaled(h, push))
        change = scaled(1 / h, add(drift, minus(memory[3:])))
        return Demand(acceleration=add(command, [*change, 0.0, 0.0, 0.0])), [*matvec(flow.rotation, drift), *drift]

    def _push(self, flow: Flow, nu: Vector, nu_r: Vector) -> list[Array]:
        """Acceleration (3) of a hull that drifts, less what it would be at rest in still water and air."""
        none = [0 * v for v in flow.nu]
        here = replace(flow, nu=[*nu, *none[3:]], nu_r=[*nu_r, *none[3:]], seaway=None)
        rest = replace(here, nu=none, nu_r=none, air=None)
        wrench = add(self._wrench(here, none[0]), minus(self._wrench(rest, none[0])))
        return list(self.model.inertia.accelerate(wrench)[:3])

    def _wrench(self, flow: Flow, nothing: Array) -> list[Array]:
        """All terms, as far as they are wet, and actuators at rest: a ship's hull forces come with its rudder."""
        flow = replace(flow, actuators=dict.fromkeys(self.model.actuators, nothing))
        loads = [self.model.left(term, term.wrench(flow), flow) for term in self.model.terms.values()]
        idle = [actuator for actuator in self.model.actuators.values() if not isinstance(actuator, T200)]
        shares = shares_of([actuator.site for actuator in idle], flow)
        for actuator, share in zip(idle, shares, strict=True):
            loads.append([mul(share, x) for x in actuator.wrench(nothing, flow)])
        return add([nothing] * 6, *loads)


def _water(flow: Flow) -> list[Array]:
    """Velocity of the water, body axes (3)."""
    return [over - past for over, past in zip(flow.nu[:3], flow.nu_r[:3], strict=True)]
