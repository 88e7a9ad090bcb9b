"""An agent, or a group of agents: a vehicle, where it starts, what it is to do, and what it carries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.component import Component
from pelagos.config.mission import EarthPoint, Leg
from pelagos.config.navigation import Navigation, TruthNavigation
from pelagos.config.radiated_noise import RadiatedNoise
from pelagos.config.strict import Strict
from pelagos.config.swarm import MAX_MEMBERS, Draw


class Start(Strict):
    """Place and motion of an agent when the run begins."""

    position_m: tuple[float, ...] = Field(default=(0.0, 0.0), min_length=2, max_length=3)
    """World x (north), y (west) [m], or x, y, z with z up from the mean sea surface. Without a height, what floats
    starts on the surface, waves and tide included, and moves with its water; all else at the mean sea surface."""
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
    """Speed forward over the ground [m/s], as velocities of `reset` and `set_state` are: 1 m/s against a current of
    0.5 m/s is 1.5 m/s through the water. What floats and is given no height has its water's motion in waves besides."""
    anywhere: bool = False
    """Start even inside the seabed or where the hull touches something; contact then pushes it out."""
    grid: tuple[int, int] | None = None
    """Of a group: its rows, one after another northwards, and how many stand in a row, westwards; the first member
    stands at `position_m`. Not given: a square that grows from the first member."""
    spacing_m: float | tuple[float, float] | None = None
    """Of a group: distance between its members, or northwards and westwards [m]."""

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

    @field_validator("grid")
    @classmethod
    def _some_rows(cls, value: tuple[int, int] | None) -> tuple[int, int] | None:
        if value is not None and min(value) < 1:
            raise PydanticCustomError("grid", "a grid has at least one row and one column, not {g}", {"g": list(value)})
        return value


class Agent(Strict):
    """One vehicle with its sensors and its mission, or a group of such vehicles."""

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
    radiated_noise: RadiatedNoise | None = None
    """Noise that the vehicle makes and that sonars hear, its own and others' (`vehicle_noise` of each): a mapping that
    begins with `type: ship` or `type: thrusters`; absent: none."""
    count: int | None = Field(default=None, ge=1, le=MAX_MEMBERS)
    """How many such vehicles there are: `auv` stands for `auv[0]`, `auv[1]` and so on then."""
    mission_from: Literal["world", "start"] = "world"
    """Of a group: whether the places of the mission are the world's, or count from where each member starts."""
    distributions: dict[str, Draw] = Field(default_factory=dict)
    """Of a group: numbers that are drawn for every member, by dotted key, such as `start.heading_deg`."""
    overrides: dict[int, dict[str, Any]] = Field(default_factory=dict)
    """Of a group: what is different for some members, by their number from 0: any keys of an agent."""

    @field_validator("sensors", mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            refuse_bad_names(value, "an agent's sensor")
        return value

    @model_validator(mode="after")
    def _mission_or_command(self) -> Self:
        if self.mission and self.command is not None:
            raise PydanticCustomError("both", "give either 'mission' or 'command', not both")
        return self

    @model_validator(mode="after")
    def _stand(self) -> Self:
        """Put sensors that say no place where the vehicle has one for their kind, if it names any."""
        places = getattr(self.vehicle, "mounts", {})
        for name, sensor in self.sensors.items():
            place = places.get(getattr(sensor, "STANDS", ""))
            if place is not None and "position_m" not in sensor.model_fields_set:
                self.sensors[name] = sensor.model_copy(update={"position_m": place})
        return self

    @model_validator(mode="after")
    def _group(self) -> Self:
        """Check the keys that only groups have, and those that every group needs."""
        if self.count is None:
            written = self._written
            given = [f"'{key}'" for key in ("mission_from", "distributions", "overrides") if key in written]
            given += [f"'start.{key}'" for key in ("grid", "spacing_m") if getattr(self.start, key) is not None]
            if given:
                text = "{what} is for groups of agents; give 'count' too, or leave it out"
                raise PydanticCustomError("group", text, {"what": " and ".join(given)})
            return self
        placed = any(key.startswith("start.position_m") for key in self.distributions)
        if self.count > 1 and self.start.spacing_m is None and not placed:
            text = "a group needs room: give 'start.spacing_m', or a distribution of 'start.position_m.0'"
            raise PydanticCustomError("spacing", "{text}", {"text": text})
        if self.mission_from == "start" and any(map(_on_earth, self.mission)):
            text = "a place by latitude and longitude counts from no start; give x and y, or leave out 'mission_from'"
            raise PydanticCustomError("place", "{text}", {"text": text})
        wide = self.start.grid
        if wide is not None and wide[0] * wide[1] < self.count:
            text = "a grid of {rows} x {columns} has no room for {count} members"
            raise PydanticCustomError("grid", text, {"rows": wide[0], "columns": wide[1], "count": self.count})
        beyond = [i for i in self.overrides if not 0 <= i < self.count]
        if beyond:
            text = "there is no member {i}; members of this group are 0 to {last}"
            raise PydanticCustomError("member", text, {"i": beyond[0], "last": self.count - 1})
        return self

    @property
    def _written(self) -> set[str]:
        """Keys that were given, and are not what they would be anyway."""
        fields = type(self).model_fields
        return {
            k for k in self.model_fields_set if getattr(self, k) != fields[k].get_default(call_default_factory=True)
        }


def _on_earth(leg: Leg) -> bool:
    """True for a leg with a place by latitude and longitude."""
    values = [item for _, value in leg for item in (value if isinstance(value, tuple) else (value,))]
    return any(isinstance(value, EarthPoint) for value in values)


def refuse_bad_names(value: Mapping[Any, Any], kind: str) -> None:
    """Names of agents, sensors and props become parts of topics and paths: letters, digits and underscores only."""
    for name in value:
        if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
            text = f"{name!r} cannot be the name of {kind}: use letters, digits and underscores, a letter first"
            raise PydanticCustomError("name", "{text}", {"text": text})
