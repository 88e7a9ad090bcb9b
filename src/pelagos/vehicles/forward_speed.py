"""Speed ahead in the waves that a floating hull radiates: strip theory's terms in the time domain.

`hydro.forward_speed` has them in one line: the water that goes along has a momentum P, and the hull's axes move. With
P = A(inf) nu and what the memory holds of the rest, pitch is pushed by U P3 and yaw by -U P2, and the coefficients of
strip theory at a speed follow, at every frequency. A vehicle's Coriolis forces have A(inf) nu in them already, with the
added mass in surge, which strip theory leaves out; added here are the memory's part, what the waves' own motion takes
from A(inf) nu, and a transom's. The speed is the hull's own, ahead through the water, at each step. Astern, a table of
scattered waves holds that of zero speed (`diffraction.py`), and so do the moments here, which have to cancel it in long
waves. The moment U A(inf) v in yaw, by which a hull has no course stability, remains at any speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import drjit as dr
import numpy as np

from pelagos.errors import InputError
from pelagos.hydro.algebra import Matrix, Vector, add, matvec, minus, scaled, transpose
from pelagos.hydro.coriolis import coriolis_force
from pelagos.hydro.forward_speed import section_motion
from pelagos.jit import Array
from pelagos.vehicles.afloat_config import AfloatConfig, TransomConfig
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.inertia import CoriolisConfig
from pelagos.vehicles.part import Body, numbers
from pelagos.vehicles.radiation_kernels import Kernel, fitted_kernels, momentum, remember


@dataclass(frozen=True)
class CutOff:
    """A transom, compiled: its section's motion by that of the hull `(3, 6)`, added mass at infinite frequency per
    length `(3, 3)`, and kernels of its memory.
    """

    motion: Matrix
    added: Matrix
    kernels: tuple[Kernel, ...]


@dataclass(frozen=True)
class ForwardSpeed:
    """Changes of radiation by speed ahead, compiled.

    Attributes:
        added: M_A at infinite frequency `(6, 6)`.
        upright: M_RB + M_A `(6, 6)` where the vehicle's own equations have no Coriolis forces in heave and pitch; None:
            they have.
        yaws: whether the moment in yaw is added; not where measured derivatives contain it.
        transom: None: the hull ends in a point.
        astern: whether the terms count astern too; not where the table of scattered waves begins at zero speed.
    """

    added: Matrix
    upright: Matrix | None
    yaws: bool
    transom: CutOff | None
    astern: bool = True

    @property
    def kernels(self) -> tuple[Kernel, ...]:
        """Those of the transom's memory."""
        return () if self.transom is None else self.transom.kernels

    def remember(self, memory: Sequence[Array], velocity: Vector, h: Array) -> list[Array]:
        """The transom's memory after h [s] at a velocity (6) of the hull relative to the water."""
        if self.transom is None:
            return []
        return remember(self.kernels, memory, matvec(self.transom.motion, velocity), h)[0]

    def load(self, flow: Flow, radiated: Vector, before: Sequence[Array], after: Sequence[Array]) -> list[Array]:
        """Wrench (6); `radiated`: momentum (6) of the hull's memory; the transom's memory before and after the step."""
        seaway = flow.seaway
        assert seaway is not None
        assert seaway.speed is not None
        speed, velocity = seaway.speed, seaway.velocity
        beyond = add(matvec(self.added, add(velocity, minus(flow.nu_c))), radiated)
        if self.upright is None:
            wrench: list[Array] = [0.0] * 6
        else:  # what is missing from such equations: all that moves in the hull's upright plane
            whole = coriolis_force(self.upright, flow.nu_c)
            wrench = [0.0, 0.0, -whole[2], 0.0, -whole[4], 0.0]
        counted = speed if self.astern else dr.maximum(speed, 0.0)
        wrench[4] = wrench[4] + counted * beyond[2]
        if self.yaws:
            wrench[5] = wrench[5] - counted * beyond[1]
        if not self.astern:  # Coriolis forces push pitch by U A(inf) w, which the held table's waves do not balance
            wrench[4] = wrench[4] + dr.maximum(-speed, 0.0) * matvec(self.added, flow.nu_c)[2]
        if self.transom is None:
            return wrench
        left = add(
            matvec(self.transom.added, matvec(self.transom.motion, velocity)),
            momentum(self.kernels, before, after, count=3),
        )
        lost = scaled(-dr.maximum(speed, 0.0), matvec(transpose(self.transom.motion), left))
        return add(wrench, lost)


def compile_forward_speed(
    config: AfloatConfig, body: Body, coriolis: CoriolisConfig, added: Matrix
) -> ForwardSpeed | None:
    """Terms of speed for a hull whose added mass at infinite frequency is `added` `(6, 6)`; None where none are asked.

    Raises:
        InputError: a model whose Coriolis forces leave out what these terms add to.
    """
    if config.forward_speed == "none":
        return None
    missing = [(row, column) for row, column in coriolis.without if row in (3, 4, 5)]
    if missing:
        text = f"coriolis.without takes {missing} from the added mass's part, which forward_speed: strip adds to"
        raise InputError(f"{text}; only entries of surge, sway and yaw may be left out")
    without = coriolis.rigid == "none"
    found = config.coefficients
    assert found is not None
    return ForwardSpeed(
        added=added,
        upright=numbers(body.rigid + np.array(added)) if without else None,
        yaws=not without and not any(row == 6 for row, _ in coriolis.without),
        transom=None if found.transom is None else _cut_off(found.transom, found.omega_radps, body.density),
        astern=found.diffraction is None,
    )


def _cut_off(config: TransomConfig, omega: Sequence[float], density: float) -> CutOff:
    damping = density * np.array(config.damping)
    return CutOff(
        motion=numbers(section_motion(config.position_x_m)),
        added=numbers(density * np.array(config.added_mass_infinite)),
        kernels=fitted_kernels(np.array(omega), damping),
    )
