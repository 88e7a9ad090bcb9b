"""Hull forces by derivatives of the second degree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

from pydantic import Field, model_validator

from pelagos.hydro.algebra import Vector
from pelagos.hydro.derivatives import NAME, Derivative, derivative_force, dimensional
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Number, PartConfig


def check_names(derivatives: dict[str, float], *, deflections: bool) -> None:
    """Refuse names of derivatives that cannot be.

    Raises:
        ValueError: names the derivative and what it may be.
    """
    for name in derivatives:
        match = NAME.fullmatch(name)
        if match is None or (match.group(3) and not deflections):
            may = " and then none, one or two d" if deflections else ""
            raise ValueError(f"derivative {name!r} must be X, Y, Z, K, M or N, then two of u, v, w, p, q, r{may}")


class DerivativesConfig(PartConfig):
    """Forces by products of two velocities: `Yur` multiplies u r, `Muw` u w (`hydro/derivatives.py`)."""

    type: Literal["derivatives"]
    derivatives: dict[str, Number] = Field(min_length=1)
    """By name; non-dimensional by rho/2 and the length."""

    @model_validator(mode="after")
    def _named(self) -> Self:
        check_names(self.derivatives, deflections=False)
        return self

    def build(self, body: Body) -> HullDerivatives:
        """The term."""
        return HullDerivatives(dimensional(self.derivatives, body.density, body.length))


@dataclass(frozen=True)
class HullDerivatives:
    """derivatives: with their dimensions."""

    derivatives: tuple[Derivative, ...]

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6)."""
        return derivative_force(self.derivatives, flow.nu_r)
