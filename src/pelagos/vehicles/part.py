"""Common base of a vehicle's parts: strict configurations, and the constants of the body they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from pelagos.config.described import Described
from pelagos.errors import ScenarioError
from pelagos.vehicles.nearby import GroundMass

if TYPE_CHECKING:
    from pelagos.vehicles.afloat_config import AfloatConfig

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0, lt=1)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Three = tuple[Number, Number, Number]
Six = tuple[Number, Number, Number, Number, Number, Number]


class PartConfig(Described):
    """Frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def check_limits(config: PartConfig, low: str, high: str) -> None:
    """Refuse limits, named by their keys, of which the lower one is not below the other.

    Raises:
        ValueError: names both.
    """
    least, largest = getattr(config, low), getattr(config, high)
    if least >= largest:
        raise ValueError(f"{low} {least:g} must be below {high} {largest:g}")


@dataclass(frozen=True)
class Body:
    """Constants of a vehicle that its terms follow from, about the origin CO, FRD, SI units.

    Attributes:
        density: of the water [kg/m^3].
        gravity: [m/s^2].
        length, beam, height: of the hull [m].
        rigid: M_RB `(6, 6)`.
        displaced: that of the water displaced, turned like the body's own mass `(6, 6)`.
        added: M_A `(6, 6)`.
        weight, buoyancy: W, B [N].
        center_of_gravity, center_of_buoyancy: r_g, r_b `(3,)` [m].
        in_air: whether the density is that of air.
        stiffness: diagonal `(6,)` of a floating hull's G about its centre of flotation; 0 for one that does not float.
        flotation: forward of the origin, the centre of a floating hull's waterplane [m].
        shallow: draught over the depth of water under the keel; 0 in deep water.
        ground: what the ground does to the added mass, where the depth is the world's.
        afloat: the hull in the water, of vehicles that have one.
    """

    density: float
    gravity: float
    length: float
    beam: float
    height: float
    rigid: NDArray[np.float64]
    displaced: NDArray[np.float64]
    added: NDArray[np.float64]
    weight: float
    buoyancy: float
    center_of_gravity: NDArray[np.float64]
    center_of_buoyancy: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    in_air: bool = False
    flotation: float = 0.0
    shallow: float = 0.0
    ground: GroundMass | None = None
    afloat: AfloatConfig | None = None

    @property
    def mass_matrix(self) -> NDArray[np.float64]:
        """M = M_RB + M_A `(6, 6)`."""
        return self.rigid + self.added

    @property
    def metacentric_height(self) -> float:
        """Height of the centre of buoyancy above the centre of gravity [m]."""
        return float(self.center_of_gravity[2] - self.center_of_buoyancy[2])


def check_floats(body: Body, term: str) -> None:
    """Refuse what does not float, for a term that is of ships.

    Raises:
        ScenarioError: names the term, and the one for vehicles under water.
    """
    if not body.stiffness.any():
        where = "moves in the air" if body.in_air else "is under water, for which there is the term boundary"
        raise ScenarioError(f"a {term} term is for ships, with a hydrostatic term; this vehicle {where}")


def numbers(matrix: NDArray[np.floating[Any]]) -> list[list[float]]:
    """A matrix as lists of Python numbers, for `hydro.algebra`; entries below 1e-15 of the largest are 0."""
    floor = 1e-15 * float(np.abs(matrix).max(initial=0.0))
    return [[float(x) if abs(x) > floor else 0.0 for x in row] for row in matrix]
