"""Hull forces by products of velocities, of their magnitudes and of the heel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

from pydantic import Field, model_validator

from pelagos.hydro.algebra import Vector
from pelagos.hydro.modulus import Product, is_name, modulus_force, products_of
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Number, PartConfig


class ModulusConfig(PartConfig):
    """Forces by products: `Yur` multiplies u r, `Nr|r|` r |r|, `Kphi|uv|` phi |u v| (`hydro/modulus.py`)."""

    type: Literal["modulus"]
    coefficients: dict[str, Number] = Field(min_length=1)
    """By name: X, Y, Z, K, M or N, then u, v, w, p, q, r or phi, those in bars by their magnitude; [N], [N m] over the
    product's unit."""

    @model_validator(mode="after")
    def _named(self) -> Self:
        for name in self.coefficients:
            if not is_name(name):
                raise ValueError(
                    f"coefficient {name!r} must be X, Y, Z, K, M or N and then u, v, w, p, q, r, phi, in bars for "
                    "their magnitude, such as Yur, Nr|r| or Kphi|uv|"
                )
        return self

    def build(self, body: Body) -> Modulus:
        """The term."""
        return Modulus(products_of(self.coefficients))


@dataclass(frozen=True)
class Modulus:
    """products: with their coefficients."""

    products: tuple[Product, ...]

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6)."""
        return modulus_force(self.products, flow.nu_r, flow.roll)
