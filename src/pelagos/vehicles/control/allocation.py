"""Sharing a wanted wrench among thrusters: pseudo-inverse, and at saturation the more important axes first.

Source: T. I. Fossen, T. A. Johansen, "A survey of control allocation methods for ships and underwater
vehicles", MED 2006, doi 10.1109/MED.2006.328749; F21 Chapter 11.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Matrix, Vector, matvec
from pelagos.jit import Array
from pelagos.vehicles.actuators.t200 import T200
from pelagos.vehicles.actuators.thruster import Thruster
from pelagos.vehicles.model import Model
from pelagos.vehicles.part import numbers

PRIORITY: Final = ((3, 4), (2,), (5,), (0, 1))
"""Axes of a wrench that share a fate at saturation, the most important first: a vehicle keeps upright, then its depth,
then its heading, and drives with the thrust that is left."""
_TINY_N: Final = 1e-9  # a thrust below this takes part in nothing


@dataclass(frozen=True)
class Allocation:
    """Thrusters that share a wrench.

    Attributes:
        thrusters: by name.
        inverse: wrench (6) -> thrusts `(k, 6)`; columns of axes that are not controlled are 0.
        limits: thrust of each astern (negative) and ahead [N].
    """

    thrusters: Mapping[str, Thruster | T200]
    inverse: Matrix
    limits: Sequence[tuple[float, float]]

    def thrusts(self, wrench: Vector) -> list[Array]:
        """Thrust of each [N]: the smallest that gives the wrench; all scaled down together where one would saturate."""
        return self.prioritised(wrench, (tuple(range(6)),))[0]

    def prioritised(
        self, wrench: Vector, groups: Sequence[Sequence[int]] = PRIORITY
    ) -> tuple[list[Array], list[Array]]:
        """Thrust of each [N], and the share (6) of every axis of the wrench that they give.

        Each group of axes is scaled down together, keeping its direction, to the thrust that those before it left.
        """
        given: list[Array] = [0.0] * len(self.limits)
        shares: list[Array] = [1.0] * 6
        for group in groups:
            part = [w if i in group else 0.0 for i, w in enumerate(wrench)]
            wanted = matvec(self.inverse, part)
            share: Array = 1.0
            for force, now, (low, high) in zip(wanted, given, self.limits, strict=True):
                if isinstance(force, float) and force == 0.0:
                    continue
                share = dr.minimum(share, dr.select(force > _TINY_N, (high - now) / force, 1.0))
                if low < 0:
                    share = dr.minimum(share, dr.select(force < -_TINY_N, (low - now) / force, 1.0))
            share = dr.maximum(share, 0.0)
            given = [now + share * force for now, force in zip(given, wanted, strict=True)]
            shares = [share if i in group else s for i, s in enumerate(shares)]
        return [dr.clip(force, low, high) for force, (low, high) in zip(given, self.limits, strict=True)], shares

    def commands(self, wrench: Vector) -> dict[str, Array]:
        """Command of each thruster for a wrench (6) [N], [N m]; at saturation the wrench keeps its direction."""
        return self.commands_of(self.thrusts(wrench))

    def commands_of(self, thrusts: Sequence[Array]) -> dict[str, Array]:
        """Command of each thruster for its thrust [N]."""
        return {
            name: part.command(thrust) for (name, part), thrust in zip(self.thrusters.items(), thrusts, strict=True)
        }


def unsaturated(share: Array, asked: Array, step: Array) -> Array:
    """An integral's next step, 0 where it would ask for more of an axis that saturates (conditional integration)."""
    return dr.select((share >= 1.0) | (asked * step < 0), step, 0.0)


def allocation_of(model: Model, axes: Sequence[int]) -> Allocation:
    """Allocation among all thrusters of a vehicle, for the wrench's `axes` (0 surge .. 5 yaw).

    Raises:
        ScenarioError: the thrusters cannot act on one of the axes.
    """
    thrusters = {name: a for name, a in model.actuators.items() if isinstance(a, (Thruster, T200))}
    effects = np.array([t.effect for t in thrusters.values()], dtype=np.float64).reshape(-1, 6).T
    rows = effects[list(axes)]
    if len(thrusters) == 0 or np.linalg.matrix_rank(rows, tol=1e-9) < len(axes):
        raise ScenarioError(f"the thrusters {', '.join(thrusters) or '(none)'} cannot act on all axes {list(axes)}")
    inverse = np.zeros((len(thrusters), 6))
    inverse[:, list(axes)] = np.linalg.pinv(rows)
    limits = [t.thrust_limits for t in thrusters.values()]
    return Allocation(thrusters, numbers(inverse), limits)
