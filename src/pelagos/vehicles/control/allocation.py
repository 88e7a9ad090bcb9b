"""Sharing a wanted wrench among thrusters: pseudo-inverse, then saturation that keeps the direction.

Source: T. I. Fossen, T. A. Johansen, "A survey of control allocation methods for ships and underwater
vehicles", MED 2006, doi 10.1109/MED.2006.328749; F21 Chapter 11.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import drjit as dr
import numpy as np

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Matrix, Vector, matvec
from pelagos.jit import Array
from pelagos.vehicles.actuators.t200 import T200
from pelagos.vehicles.actuators.thruster import Thruster
from pelagos.vehicles.model import Model
from pelagos.vehicles.part import numbers


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
        wanted = matvec(self.inverse, wrench)
        excess: Array = 1.0
        for force, (low, high) in zip(wanted, self.limits, strict=True):
            excess = dr.maximum(excess, force / high)
            if low < 0:
                excess = dr.maximum(excess, force / low)
        return [dr.clip(force / excess, low, high) for force, (low, high) in zip(wanted, self.limits, strict=True)]

    def commands(self, wrench: Vector) -> dict[str, Array]:
        """Command of each thruster for a wrench (6) [N], [N m]."""
        shares = zip(self.thrusters.items(), self.thrusts(wrench), strict=True)
        return {name: part.command(thrust) for (name, part), thrust in shares}


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
