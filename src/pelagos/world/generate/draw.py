"""Numbers that a scenario gives as a distribution, drawn from the world's seed: the means of domain randomisation."""

from __future__ import annotations

from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from pydantic import AfterValidator, BeforeValidator, ConfigDict, model_validator

from pelagos.config.described import Described


class Distribution(Described):
    """A random number; exactly one of the keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")

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
        for name in ("uniform", "loguniform"):
            limits = getattr(self, name)
            if limits is not None and limits[0] > limits[1]:
                raise ValueError(f"{name} goes from the least to the greatest value, not {list(limits)}")
        for name in ("normal", "lognormal"):
            values = getattr(self, name)
            if values is not None and values[1] < 0:
                raise ValueError(f"the standard deviation of {name} must be at least 0, not {values[1]:g}")
        if self.choice is not None and not self.choice:
            raise ValueError("choice needs at least one value")
        if self.loguniform is not None and min(self.loguniform) <= 0:
            raise ValueError("loguniform needs values greater than zero")
        if self.lognormal is not None and self.lognormal[0] <= 0:
            raise ValueError("lognormal needs a median greater than zero")
        return self

    @property
    def range(self) -> tuple[float, float]:
        """The least and the greatest number that it gives; of a normal one, two standard deviations about its mean."""
        if self.normal is not None:
            return self.normal[0] - 2 * self.normal[1], self.normal[0] + 2 * self.normal[1]
        if self.lognormal is not None:
            return 0.0, float(self.lognormal[0] * np.exp(2 * self.lognormal[1]))
        values = self.uniform or self.loguniform or self.choice or ()
        return min(values), max(values)

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


Drawn: TypeAlias = Annotated[float | Distribution, BeforeValidator(_from_pair)]
"""A number, or a distribution that the seed draws it from."""


def bounded(*, least: float = -np.inf, most: float = np.inf, above: float = -np.inf) -> AfterValidator:
    """Refuses numbers, and distributions that give them, below `least`, above `most`, or not above `above`."""

    def check(value: Drawn) -> Drawn:
        low, high = value.range if isinstance(value, Distribution) else (value, value)
        shown = f"not {value:g}" if not isinstance(value, Distribution) else f"but this gives {low:g} .. {high:g}"
        if low < least or low < above or (low == above and not isinstance(value, Distribution)):
            raise ValueError(
                f"must be {'greater than' if above > least else 'at least'} {max(least, above):g}, {shown}"
            )
        if high > most:
            raise ValueError(f"must be at most {most:g}, {shown}")
        return value

    return AfterValidator(check)


def draw(value: Drawn, rng: np.random.Generator) -> float:
    """The number itself, or one drawn."""
    return value.draw(rng) if isinstance(value, Distribution) else float(value)
