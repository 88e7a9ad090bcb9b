"""An agent: a vehicle, where it starts, what it is to do, and what it carries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.component import Component
from pelagos.config.mission import Leg
from pelagos.config.navigation import Navigation, TruthNavigation
from pelagos.config.strict import Strict


class Start(Strict):
    """Where an agent is when the run begins, and how it moves."""

    position_m: tuple[float, ...] = Field(default=(0.0, 0.0), min_length=2, max_length=3)
    """World x (north), y (west) [m], or x, y, z with z up from the mean sea surface."""
    depth_m: float | None = Field(default=None, ge=0)
    """Depth of the origin of the body below the mean sea surface [m]; with a position of two numbers."""
    altitude_m: float | None = Field(default=None, gt=0)
    """Altitude of the origin of the body above the seabed [m]; with a position of two numbers."""
    heading_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass heading [deg]: 0 north, 90 east."""
    roll_deg: float = Field(default=0.0, ge=-180, le=180)
    """Roll, starboard side down positive [deg]."""
    pitch_deg: float = Field(default=0.0, ge=-90, le=90)
    """Pitch, nose up positive [deg]."""
    speed_mps: float = 0.0
    """Speed forward through the water [m/s]."""

    @model_validator(mode="after")
    def _one_height(self) -> Self:
        given = [f"'{name}'" for name in ("depth_m", "altitude_m") if getattr(self, name) is not None]
        if len(self.position_m) == 3:
            given.append("z of 'position_m'")
        if len(given) > 1:
            raise PydanticCustomError(
                "level", "the height is given {n} times: {how}", {"n": len(given), "how": ", ".join(given)}
            )
        return self


class Agent(Strict):
    """One vehicle with its sensors and its mission."""

    vehicle: Annotated[Any, Component("vehicle", shorthand=True)]
    """A vehicle by name (`pelagos list vehicles`), or a mapping of `type` and of parameters to change."""
    start: Start = Start()
    """Where it is when the run begins."""
    control: str | None = None
    """Control mode in which commands are understood; the vehicle's own default where not given."""
    command: tuple[float, ...] | None = None
    """The command that is held until another is given; without it, the vehicle's idle command."""
    mission: tuple[Leg, ...] = ()
    """What to do, leg after leg; without legs the vehicle obeys commands only."""
    navigation: Navigation = TruthNavigation()
    """What its mission knows of its motion: `truth`, `ekf` (an estimator of its sensors), `external` (told from outside
    by `Simulation.navigate`), or a mapping that begins with such a `type`."""
    sensors: dict[str, Annotated[Any, Component("sensor")]] = Field(default_factory=dict)
    """What it carries: a name of your choice, and a mapping that begins with its `type` (`pelagos list sensors`)."""

    @field_validator("sensors", mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            refuse_bad_names(value, "agent's sensor")
        return value

    @model_validator(mode="after")
    def _mission_or_command(self) -> Self:
        if self.mission and self.command is not None:
            raise PydanticCustomError("both", "give either 'mission' or 'command', not both")
        return self


def refuse_bad_names(value: Mapping[Any, Any], kind: str) -> None:
    """Names of agents and sensors become parts of topics and paths: letters, digits and underscores only."""
    for name in value:
        if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
            text = f"{name!r} cannot be the name of an {kind}: use letters, digits and underscores, a letter first"
            raise PydanticCustomError("name", "{text}", {"text": text})
