"""What a mission knows of its vehicle's motion: the truth, an estimator's solution, or what somebody outside says."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from pelagos.config.strict import Strict


class TruthNavigation(Strict):
    """The true motion, without error."""

    type: Literal["truth"] = "truth"
    """The kind of navigation."""


class ExternalNavigation(Strict):
    """A solution that a program outside gives (`Simulation.navigate`); the start until the first one."""

    type: Literal["external"] = "external"
    """The kind of navigation."""


def _named(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


Navigation = Annotated[
    Annotated[TruthNavigation | ExternalNavigation, Field(discriminator="type")],
    BeforeValidator(_named),
]
