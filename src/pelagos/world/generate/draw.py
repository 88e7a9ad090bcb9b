"""Numbers that a scenario gives as a distribution, drawn from the world's seed: the means of domain randomisation."""

from __future__ import annotations

from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator


class Distribution(BaseModel):
    """A random number; exactly one of the keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    uniform: tuple[float, float] | None = None
    """Evenly between two values."""
    loguniform: tuple[float, float] | None = None
    """Evenly in the logarithm between two values greater than zero."""
    normal: tuple[float, float] | None = None
    """Mean and standard deviation."""
    lognormal: tuple[float, float] | None = None
    """Median and standard deviation of the natural logarithm."""
    choice: tuple[float, ...] | None = None
    """One of these values."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [k for k, v in self if v is not None]
        if len(given) != 1:
            raise ValueError(
                f"a distribution has exactly one of uniform, loguniform, normal, lognormal, choice, not {given}"
            )
        if self.loguniform is not None and min(self.loguniform) <= 0:
            raise ValueError("loguniform needs values greater than zero")
        if self.lognormal is not None and self.lognormal[0] <= 0:
            raise ValueError("lognormal needs a median greater than zero")
        return self

    def draw(self, rng: np.random.Generator) -> float:
        """One number."""
        if self.uniform is not None:
            return float(rng.uniform(*self.uniform))
        if self.loguniform is not None:
            return float(np.exp(rng.uniform(*np.log(self.loguniform))))
        if self.normal is not None:
            return float(rng.normal(*self.normal))
        if self.lognormal is not None:
            return float(self.lognormal[0] * np.exp(self.lognormal[1] * rng.standard_normal()))
        assert self.choice is not None
        return float(self.choice[int(rng.integers(len(self.choice)))])


def _from_pair(value: Any) -> Any:
    """[low, high] stands for an even distribution."""
    if isinstance(value, list | tuple) and len(value) == 2:
        return {"uniform": tuple(value)}
    return value


Drawn: TypeAlias = float | Distribution
"""A number, or a distribution that the seed draws it from."""

SizeRange: TypeAlias = Annotated[Distribution | float, Field(union_mode="left_to_right")]


def draw(value: Drawn, rng: np.random.Generator) -> float:
    """The number itself, or one drawn."""
    return value.draw(rng) if isinstance(value, Distribution) else float(value)
