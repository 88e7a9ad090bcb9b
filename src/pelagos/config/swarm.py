"""Groups of agents: one entry of a scenario that stands for many vehicles of one kind, and how its members differ.

`agents: {auv: {count: 3, ...}}` names `auv[0]`, `auv[1]` and `auv[2]`. What is drawn for a member depends on the
scenario's seed, its name and the key alone: a group that grows changes none of its first members.
"""

from __future__ import annotations

import hashlib
import math
import random
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from pelagos.config.strict import Strict

if TYPE_CHECKING:
    from pelagos.config.agent import Agent

MAX_MEMBERS: Final = 100_000
_SEPARATOR: Final = "\x1f"


class Draw(Strict):
    """A number drawn for every member of a group; give one of its keys."""

    uniform: tuple[float, float] | None = None
    """Lowest and highest value."""
    normal: tuple[float, float] | None = None
    """Mean and standard deviation."""
    choice: tuple[float, ...] | None = Field(default=None, min_length=1)
    """Values, each as likely as the others."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in ("uniform", "normal", "choice") if getattr(self, name) is not None]
        if len(given) != 1:
            text = "give one of 'uniform', 'normal' and 'choice', not {given}"
            raise PydanticCustomError("distribution", text, {"given": " and ".join(given) or "none"})
        if self.uniform is not None and self.uniform[0] > self.uniform[1]:
            text = "uniform goes from the lowest to the highest value, not from {low} to {high}"
            raise PydanticCustomError("uniform", text, {"low": self.uniform[0], "high": self.uniform[1]})
        if self.normal is not None and self.normal[1] < 0:
            text = "a standard deviation is 0 or positive, not {given}"
            raise PydanticCustomError("normal", text, {"given": self.normal[1]})
        return self

    @property
    def below_zero(self) -> bool:
        """True where a bound, a mean or a value to choose is negative; of `normal` the tails may be."""
        mean = self.normal[0] if self.normal is not None else 0.0
        return any(value < 0 for value in (mean, *(self.uniform or ()), *(self.choice or ())))

    def steps(self, count: int) -> tuple[float, ...]:
        """Even steps over what can be drawn: three standard deviations about a mean; all values of a choice."""
        if self.choice is not None:
            return tuple(sorted(set(self.choice)))
        mean, deviation = self.normal or (0.0, 0.0)
        low, high = self.uniform or (mean - 3 * deviation, mean + 3 * deviation)
        return tuple(low + (high - low) * k / (count - 1) for k in range(count)) if high > low else (low,)

    def draw(self, seed: int, name: str) -> float:
        """The value of `name` ("member.key") among the draws of a seed."""
        digest = hashlib.blake2b(f"{seed}{_SEPARATOR}{name}".encode(), digest_size=16, person=b"members").digest()
        stream = random.Random(int.from_bytes(digest, "little"))
        if self.uniform is not None:
            return stream.uniform(*self.uniform)
        if self.normal is not None:
            return stream.gauss(*self.normal)
        assert self.choice is not None
        return self.choice[stream.randrange(len(self.choice))]


def member_names(name: str, count: int | None) -> list[str]:
    """Names of the agents that an entry of a scenario stands for: its own, or "auv[0]", "auv[1]", ..."""
    return [name] if count is None else [f"{name}[{i}]" for i in range(count)]


def group_of(member: str) -> str:
    """The entry of a scenario that an agent's name comes from: "auv" of "auv[3]" and of "auv"."""
    return member.partition("[")[0]


def topic_name(agent: str) -> str:
    """An agent's name as topics and frames have it: `auv[3]` is `auv_3` there."""
    return agent.replace("[", "_").replace("]", "")


def members(name: str, agent: Agent, seed: int) -> dict[str, Agent]:
    """The agents that an entry of a scenario stands for, by name.

    Raises:
        ValidationError: an override or a distribution asks for what cannot be.
    """
    if agent.count is None:
        return {name: agent}
    offsets = grid(agent.count, agent.start.grid, agent.start.spacing_m)
    plain = agent.model_copy(update=_ALONE | {"start": agent.start.model_copy(update=_NO_GRID)})
    found = {}
    for i, member in enumerate(member_names(name, agent.count)):
        one = _moved(plain, offsets[i], with_mission=agent.mission_from == "start")
        changes = {key: d.draw(seed, f"{member}.{key}") for key, d in agent.distributions.items()}
        override = agent.overrides.get(i)
        found[member] = one if not changes and override is None else _changed(one, member, changes, override or {})
    return found


def grid(
    count: int, shape: tuple[int, int] | None, spacing: float | tuple[float, float] | None
) -> list[tuple[float, float]]:
    """Places x (north) and y (west) of a group's members from its first [m].

    A row after another, or, without a shape, about the first one: in a square that grows by what lies at its far sides,
    so that no place depends on how many follow.
    """
    apart = (0.0, 0.0) if spacing is None else spacing if isinstance(spacing, tuple) else (spacing, spacing)
    places = []
    for i in range(count):
        if shape is None:
            shell = math.isqrt(i)
            k = i - shell * shell
            row, column = min(k, shell), min(2 * shell - k, shell)
        else:
            row, column = divmod(i, shape[1])
        places.append((row * apart[0], column * apart[1]))
    return places


_ALONE: Final[dict[str, Any]] = {"count": None, "distributions": {}, "overrides": {}, "mission_from": "world"}
_NO_GRID: Final[dict[str, Any]] = {"grid": None, "spacing_m": None}
_PLACES: Final = ("points", "corner", "center", "area", "face", "point")  # keys of legs that hold x and y


def _moved(agent: Agent, offset: Any, *, with_mission: bool) -> Agent:
    """The same agent elsewhere."""
    x, y, *z = agent.start.position_m
    place = (x + float(offset[0]), y + float(offset[1]), *z)
    update: dict[str, Any] = {"start": agent.start.model_copy(update={"position_m": place})}
    if with_mission:
        update["mission"] = tuple(_leg_moved(leg, place[:2]) for leg in agent.mission)
    return agent.model_copy(update=update)


def _leg_moved(leg: Any, by: tuple[float, ...]) -> Any:
    given = {key: getattr(leg, key, None) for key in _PLACES}
    return leg.model_copy(update={key: _shifted(value, by) for key, value in given.items() if value is not None})


def _shifted(places: Any, by: tuple[float, ...]) -> Any:
    """One place, or a list of them, shifted in x and y."""
    if isinstance(places[0], int | float):
        return (places[0] + by[0], places[1] + by[1], *places[2:])
    return tuple(_shifted(place, by) for place in places)


def _changed(agent: Agent, name: str, values: Mapping[str, float], override: Mapping[str, Any]) -> Agent:
    """An agent with values by dotted key, and then with those of an override.

    Only keys that change are checked anew: all others stay the same objects, by which members are known to be alike.
    """
    changes = {key.split(".")[0] for key in values} | set(override)
    data: dict[str, Any] = {key: _opened(getattr(agent, key, {})) for key in changes}
    for dotted, value in values.items():
        _put(data, dotted, value)
    data = {"vehicle": agent.vehicle, **_merged(data, override)}
    for key in ("mission", "command"):  # one of them excludes the other
        data.setdefault(key, getattr(agent, key))
    try:
        checked = type(agent).model_validate(data)
    except ValidationError as error:
        lines = [InitErrorDetails(type=_as_custom(e), loc=e["loc"], input=e["input"]) for e in error.errors()]
        raise ValidationError.from_exception_data(name, lines) from None
    return agent.model_copy(update={key: getattr(checked, key) for key in changes})


def _opened(value: Any) -> Any:
    """A model as the mapping that was written, one level deep, and a tuple as a list; copies."""
    if isinstance(value, BaseModel):
        return {
            key: getattr(value, key) for key in type(value).model_fields if key in value.model_fields_set | {"type"}
        }
    if isinstance(value, Mapping):
        return dict(value)
    return list(value) if isinstance(value, tuple) else value


def _as_custom(line: Any) -> PydanticCustomError | str:
    return (
        "extra_forbidden" if line["type"] == "extra_forbidden" else PydanticCustomError("x", "{m}", {"m": line["msg"]})
    )


def _put(data: Any, dotted: str, value: float) -> None:
    """Set the number at a dotted key; items of lists are named by their number."""
    *outer, last = dotted.split(".")
    for part in outer:
        key: Any = part
        if isinstance(data, list) and _is_item(data, part):
            key = int(part)
        elif not isinstance(data, dict):
            raise _not_a_number(dotted)
        data[key] = _opened(data[key] if isinstance(data, list) else data.get(key, {}))
        data = data[key]
    if isinstance(data, list) and _is_item(data, last):
        data[int(last)] = value
    elif isinstance(data, dict) and isinstance(data.get(last, 0.0), int | float):
        data[last] = value
    else:
        raise _not_a_number(dotted)


def _is_item(data: list[Any], part: str) -> bool:
    return part in map(str, range(len(data)))


def _not_a_number(dotted: str) -> PydanticCustomError:
    text = "'{key}' names no number of an agent; 'start.heading_deg' and 'start.position_m.0' do"
    return PydanticCustomError("distribution", text, {"key": dotted})


def _merged(data: Any, change: Any) -> Any:
    """Mappings merged key by key; anything else is replaced."""
    if not isinstance(data, Mapping | BaseModel) or not isinstance(change, Mapping):
        return change
    both = _opened(data)
    for key, value in change.items():
        both[key] = _merged(both[key], value) if key in both else value
    return both
