"""A benchmark case, and the result of running it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Reference:
    """Peer or limit that a value is compared with.

    Attributes:
        text: where it comes from: a publication, or a limit that was measured in the same run.
        value: in the case's unit; None where there is nothing to divide by.
    """

    text: str
    value: float | None = None


@dataclass(frozen=True)
class Measured:
    """Result of a case's function.

    Attributes:
        value: in the case's unit.
        reference: what the run itself measured to compare with; replaces the declared one.
        detail: what was checked of the output, in a few words.
    """

    value: float
    reference: Reference | None = None
    detail: str = ""


@dataclass(frozen=True)
class Case:
    """A benchmark, as data.

    Attributes:
        name: what `pelagos bench NAME` calls it; ends in its unit.
        title: what is measured, one line.
        measure: does the work; raises `BenchError` where the output is not what it must be.
        unit: of the value.
        goal: on two CPU cores.
        better: which way is good.
        reference: what it is compared with.
    """

    name: str
    title: str
    measure: Callable[[], Measured]
    unit: str
    goal: float
    better: Literal["higher", "lower"]
    reference: Reference


@dataclass(frozen=True)
class Result:
    """One case, measured.

    Attributes:
        case: what was measured.
        value: in the case's unit; None where it could not be measured.
        reference: what it is compared with.
        detail: what was checked, or why there is no value.
    """

    case: Case
    value: float | None
    reference: Reference
    detail: str

    @property
    def met(self) -> bool:
        """Whether the goal is reached."""
        if self.value is None:
            return False
        return self.value >= self.case.goal if self.case.better == "higher" else self.value <= self.case.goal

    @property
    def ratio(self) -> float | None:
        """Value over reference."""
        if self.value is None or not self.reference.value:
            return None
        return self.value / self.reference.value
