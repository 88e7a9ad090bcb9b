"""`Scenario`: everything that a run is made of, except its length of fleet and its device."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from pelagos.config.agent import Agent, refuse_bad_names
from pelagos.config.component import Component
from pelagos.config.document import join_place
from pelagos.config.limits import beyond, outside_text
from pelagos.config.prop import PropConfig
from pelagos.config.rate import Rate, divides, rate_text
from pelagos.config.strict import Strict
from pelagos.config.swarm import Draw, group_of, members, topic_name
from pelagos.config.vary import check as check_varied
from pelagos.config.vary import check_ocean


class Origin(Strict):
    """Place of the world's origin on Earth (WGS 84)."""

    latitude_deg: float
    """Geographic latitude, north positive [deg]."""
    longitude_deg: float
    """Geographic longitude, east positive [deg]."""

    @field_validator("latitude_deg")
    @classmethod
    def _on_earth(cls, value: float) -> float:
        if abs(value) > 90:
            text = "a latitude lies between -90 and 90 degrees, not {value}; are latitude and longitude swapped?"
            raise PydanticCustomError("latitude", text, {"value": value})
        return value

    @field_validator("longitude_deg")
    @classmethod
    def _round_earth(cls, value: float) -> float:
        if abs(value) > 360:
            raise PydanticCustomError(
                "longitude", "a longitude lies between -180 and 180 degrees, not {value}", {"value": value}
            )
        return (value + 180) % 360 - 180 if abs(value) > 180 else value


class Record(Strict):
    """Contents of a recording beside the readings of the sensors."""

    state_rate_hz: Rate = 50.0
    """Rate of the true motion of every vehicle [Hz]; divides the tick rate. Not given: 50 Hz or the nearest below."""
    groups: Literal["by_member", "together"] = "by_member"
    """Channels of a group of agents: `by_member` one for every member and topic; `together` one for a topic of all
    members, whose messages hold a row of numbers for each (what is no row of numbers stays by member)."""
    commands: bool = False
    """Record the commands to every vehicle's actuators too, at the times of its motion, such as for `pelagos fit`."""


class Scenario(Strict):
    """A scenario: world, ocean, agents and their missions, as data; needs no device to build or to check."""

    name: str = Field(default="scenario", min_length=1, max_length=200)
    """A short name, which also names the folder of results."""
    description: str = ""
    """What the scenario is for."""
    seed: int = Field(default=0, ge=0, lt=2**63)
    """Seed of every random stream."""
    tick_rate_hz: Rate = Field(default=200.0, le=100_000)
    """Ticks per second [Hz]; every sensor's rate must divide it."""
    duration_s: float = Field(default=60.0, gt=0)
    """How long a run lasts unless told otherwise [s]."""
    origin: Origin | None = None
    """Where on Earth the world's origin lies, instead of the world's own latitude_deg and longitude_deg."""
    world: Annotated[Any, Component("world")]
    """The world: a mapping that begins with its `type` (`pelagos list worlds`)."""
    ocean: Annotated[Any, Component("ocean", default="standard")] = Field(default_factory=dict, validate_default=True)
    """Currents, waves, water masses and light."""
    agents: dict[str, Agent] = Field(default_factory=dict)
    """The vehicles, by a name of your choice; one entry may be a group of them."""
    props: dict[str, PropConfig] = Field(default_factory=dict)
    """Things apart from the world, which may differ from copy to copy and be moved in a run: a name of your choice, and
    a mapping that begins with its `shape`."""
    vary: dict[str, Draw] = Field(default_factory=dict)
    """Numbers that are drawn anew for every copy of a fleet and every episode, by dotted key: where and how agents
    start (`agents.auv0.start.heading_deg`), factors on their parameters (`agents.auv0.factors.mass`), where their
    sensors sit and look (`agents.auv0.sensors.dvl.position_m.0`, `.orientation_deg.2`) how many times as much they err
    (`agents.auv0.sensors.imu.error`) and their lamps and lasers shine (`agents.auv0.sensors.camera.lamps`), the water's
    velocity (`ocean.current_mps.0` north, `.1` west, `.2` up) in place of the scenario's currents, its
    `ocean.turbidity` and the numbers of its wave systems (`ocean.waves.0.significant_height_m`)."""
    record: Record = Record()
    """What goes into a recording."""
    bridges: dict[str, Annotated[Any, Component("bridge", shorthand=True)]] = Field(default_factory=dict)
    """Doors to other software that `pelagos run` opens: a name of your choice, and a mapping that begins with its
    `type` (`pelagos list bridges`)."""

    _places: Mapping[tuple[str | int, ...], str] = PrivateAttr(default_factory=dict)
    _members: Mapping[str, Agent] = PrivateAttr(default_factory=dict)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self.__dict__ == other.__dict__  # not where it was written

    @property
    def members(self) -> Mapping[str, Agent]:
        """Every single agent by name: those of a group `auv` are `auv[0]`, `auv[1]` and so on."""
        return self._members

    @property
    def dt_ns(self) -> int:
        """The tick, a whole number of nanoseconds [ns]."""
        return round(1e9 / self.tick_rate_hz)

    def with_agents(self, agents: Mapping[str, Agent]) -> Self:
        """The same scenario with other agents, checked each for itself."""
        scenario = self.model_copy(update={"agents": dict(agents)})
        scenario._members = {k: v for name, agent in agents.items() for k, v in members(name, agent, self.seed).items()}
        return scenario

    @property
    def places(self) -> Mapping[tuple[str | int, ...], str]:
        """Place at which each value was written, "file:line" by its path of keys."""
        return self._places

    def placed(self, places: Mapping[tuple[str | int, ...], str]) -> Self:
        """The same scenario, which knows where its values were written."""
        scenario = self.model_copy()
        scenario._places = places
        return scenario

    def where(self, *path: str | int) -> str:
        """Place at which a value was written, "file:line: key.path", as in `where("agents", "auv0", "start")`."""
        dotted = ".".join(str(part) for part in path)
        path = tuple(group_of(part) if i == 1 and isinstance(part, str) else part for i, part in enumerate(path))
        for length in range(len(path), -1, -1):
            if path[:length] in self._places:
                return join_place(self._places[path[:length]], dotted, exact=length == len(path))
        return dotted

    @property
    def located_world(self) -> Any:
        """The world's configuration, at the scenario's `origin` where that is given."""
        if self.origin is None:
            return self.world
        place = {"latitude_deg": self.origin.latitude_deg, "longitude_deg": self.origin.longitude_deg}
        return self.world.model_copy(update=place)

    @model_validator(mode="after")
    def _one_origin(self) -> Self:
        if self.origin is not None and getattr(self.world, "latitude_deg", None) is not None:
            text = "the world gives latitude_deg and longitude_deg already; give its origin in one of the two places"
            raise ValidationError.from_exception_data(
                "Scenario",
                [InitErrorDetails(type=PydanticCustomError("origin", text), loc=("origin",), input=self.origin)],
            )
        return self

    @field_validator("agents", mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            refuse_bad_names(value, "an agent")
        return value

    @model_validator(mode="before")
    @classmethod
    def _state_rate(cls, data: Any) -> Any:
        """A rate of the recorded motion that suits the tick rate, where the scenario gives none."""
        tick_rate = data.get("tick_rate_hz") if isinstance(data, Mapping) else None
        record = data.get("record", {}) if isinstance(data, Mapping) else None
        if (
            not isinstance(tick_rate, int | float)
            or not tick_rate > 0
            or not isinstance(record, Mapping)
            or "state_rate_hz" in record
        ):
            return data
        return {**data, "record": {**record, "state_rate_hz": tick_rate / max(1, math.ceil(tick_rate / 50.0 - 1e-6))}}

    @model_validator(mode="after")
    def _expanded(self) -> Self:
        """The single agents, so that members that cannot be are told at once."""
        found: dict[str, Agent] = {}
        for name, agent in self.agents.items():
            try:
                found |= members(name, agent, self.seed)
            except PydanticCustomError as error:
                line = InitErrorDetails(type=error, loc=("agents", name, "distributions"), input=agent.distributions)
                raise ValidationError.from_exception_data("Scenario", [line]) from None
            except ValidationError as error:
                what = PydanticCustomError("member", "{text}", {"text": _member_text(error)})
                raise ValidationError.from_exception_data(
                    "Scenario", [InitErrorDetails(type=what, loc=("agents", name), input=name)]
                ) from None
        topics: dict[str, str] = {}
        for name in found:
            other = topics.setdefault(topic_name(name), name)
            if other != name:
                text = f"{other} and {name} would have the same topics, /{topic_name(name)}/...; give one another name"
                what = PydanticCustomError("topics", "{text}", {"text": text})
                raise ValidationError.from_exception_data(
                    "Scenario", [InitErrorDetails(type=what, loc=("agents",), input=name)]
                )
        self._members = found
        return self

    @field_validator("props", mode="before")
    @classmethod
    def _prop_names(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            refuse_bad_names(value, "a prop")
        return value

    @model_validator(mode="after")
    def _one_name(self) -> Self:
        for name in self.props.keys() & self.agents.keys():
            what = PydanticCustomError("name", "{name} is an agent already; give the prop another name", {"name": name})
            line = InitErrorDetails(type=what, loc=("props", name), input=name)
            raise ValidationError.from_exception_data("Scenario", [line])
        return self

    @model_validator(mode="after")
    def _variable(self) -> Self:
        for key, draw in self.vary.items():
            try:
                check_varied([key], self.agents, self.props)
                check_ocean(key, draw, self.ocean.waves)
            except PydanticCustomError as error:
                line = InitErrorDetails(type=error, loc=("vary", key), input=draw)
                raise ValidationError.from_exception_data("Scenario", [line]) from None
        return self

    @model_validator(mode="after")
    def _rates_divide(self) -> Self:
        wrong = [
            InitErrorDetails(
                type=PydanticCustomError("rate", "{text}", {"text": rate_text(rate, self.tick_rate_hz)}),
                loc=path,
                input=rate,
            )
            for path, rate in self._rates()
            if not divides(rate, self.tick_rate_hz)
        ]
        if wrong:
            raise ValidationError.from_exception_data("Scenario", wrong)
        return self

    @model_validator(mode="after")
    def _within_ranges(self) -> Self:
        wrong = [
            InitErrorDetails(
                type=PydanticCustomError("range", "{text}", {"text": outside_text(path, value, within)}),
                loc=path,
                input=value,
            )
            for path, value, within in beyond(self)
        ]
        if wrong:
            raise ValidationError.from_exception_data("Scenario", wrong)
        return self

    def _rates(self) -> Iterator[tuple[tuple[str | int, ...], float]]:
        for name, agent in self.agents.items():
            for sensor, config in agent.sensors.items():
                yield ("agents", name, "sensors", sensor, "rate_hz"), config.rate_hz
            for i in agent.overrides:
                for sensor, config in self._members[f"{name}[{i}]"].sensors.items():
                    if config.rate_hz != getattr(agent.sensors.get(sensor), "rate_hz", None):
                        yield ("agents", name, "overrides", i, "sensors", sensor, "rate_hz"), config.rate_hz
        yield ("record", "state_rate_hz"), self.record.state_rate_hz


def _member_text(error: ValidationError) -> str:
    """Complaint about a member of a group, whose overrides or drawn values do not make an agent."""
    first = error.errors()[0]
    key = ".".join(str(part) for part in first["loc"])
    why = "there is no such key" if first["type"] == "extra_forbidden" else first["msg"]
    return f"{error.title}: {key}: {why}"
