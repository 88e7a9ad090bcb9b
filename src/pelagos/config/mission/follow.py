"""The leg that follows something: another vehicle, a wall, a pipeline."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.mission.part import Levelled


class Follow(Levelled):
    """Follow another agent, a wall that a ranging sensor sees abeam, or a pipeline of the chart."""

    type: Literal["follow"] = "follow"
    """The kind of leg."""
    agent: str | None = None
    """Name of another agent, whose position is known to this one."""
    offset_m: tuple[float, float, float] = (-5.0, 0.0, 0.0)
    """Place to keep beside the agent: ahead, to the left and above of it, in its own heading [m]."""
    wall: str | None = None
    """Name of a ranging sensor (altimeter, singlebeam) of this vehicle that looks sideways, to the wall."""
    distance_m: float = Field(default=5.0, gt=0)
    """Distance kept from the wall [m]."""
    pipeline: str | None = None
    """Name of a long body of the world, such as `pipeline`; its middle line, through slices 2 m thick, is
    followed from the nearer end."""
    seconds: float | None = Field(default=None, gt=0)
    """How long [s]; a pipeline's end ends the leg by itself."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed [m/s]; the vehicle's cruising speed where not given. Behind an agent: the largest."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in ("agent", "wall", "pipeline") if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(f"'{name}'" for name in given) or "none"
            raise PydanticCustomError(
                "follow", "give one of 'agent', 'wall' and 'pipeline'; {found} given", {"found": found}
            )
        for name, what in (("offset_m", "agent"), ("distance_m", "wall")):
            if what not in given and getattr(self, name) != type(self).model_fields[name].default:
                text = "'{name}' is kept from '{what}'; leave it out"
                raise PydanticCustomError("follow", text, {"name": name, "what": what})
        if self.pipeline is None and self.seconds is None and self.until is None:
            raise PydanticCustomError("end", "give 'seconds' or 'until': nothing else ends this leg")
        return self
