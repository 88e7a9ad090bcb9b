"""Numbers of a scenario that are drawn anew for every copy of a fleet and every episode."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from pelagos.errors import did_you_mean

if TYPE_CHECKING:
    from pelagos.config.agent import Agent
    from pelagos.config.swarm import Draw

ANGLES: Final = ("roll_deg", "pitch_deg", "heading_deg")
AXES: Final = 3
STARTS: Final = (*(f"position_m.{i}" for i in range(AXES)), *ANGLES, "speed_mps")
MOUNT: Final = tuple(f"{key}.{i}" for key in ("position_m", "orientation_deg") for i in range(AXES))
ERROR: Final = "error"
LAMPS: Final = "lamps"
_OF_SENSORS: Final = (*MOUNT, ERROR, LAMPS)
PROPS: Final = "props"
TURBIDITY: Final = "ocean.turbidity"
WAVES: Final = "waves"
_SYSTEM: Final = re.compile(r"ocean\.waves\.(\d{1,3})\.(\w+)")
_WATERS: Final = 33
_MURKIEST: Final = 1000.0
_ALIKE: Final = ("components_count",)  # numbers of a wave system that all copies have
CURRENTS: Final = tuple(f"ocean.current_mps.{i}" for i in range(AXES))
_FORMS: Final = (
    "'agents.NAME.start.heading_deg', 'agents.NAME.factors.mass', 'agents.NAME.sensors.SENSOR.position_m.0', "
    "'agents.NAME.sensors.SENSOR.error', 'agents.NAME.sensors.CAMERA.lamps', 'props.NAME.position_m.0', "
    "'ocean.current_mps.0', 'ocean.turbidity' or 'ocean.waves.0.significant_height_m'"
)


@dataclass(frozen=True)
class Varied:
    """Number that a key of `vary` names: agent, `start`, `factors` or `sensors`, and the number in it; of the ocean and
    of props, no agent; of a sensor or a prop, its name; of a wave system, its place in the list.
    """

    agent: str
    group: str
    number: str
    name: str = ""


def parse(key: str) -> Varied:
    """A key of `vary`.

    Raises:
        PydanticCustomError: no such key.
    """
    if key in CURRENTS:
        return Varied("", "current", key.rpartition(".")[2])
    if key == TURBIDITY:
        return Varied("", "turbidity", "")
    if (system := _SYSTEM.fullmatch(key)) is not None:
        return Varied("", WAVES, system[2], system[1])
    first, _, rest = key.partition(".")
    agent, _, rest = rest.partition(".")
    if first == PROPS and agent and rest:
        if rest not in MOUNT:
            raise _unknown(key, f"props.{agent}.", MOUNT)
        return Varied("", PROPS, rest, agent)
    group, _, number = rest.partition(".")
    if first != "agents" or not agent or group not in ("start", "factors", "sensors") or not number:
        text = (
            "'{key}' cannot differ from copy to copy; {forms} can. Whole runs differ by `pelagos sweep` and `dataset`"
        )
        raise PydanticCustomError("vary", text, {"key": key, "forms": _FORMS})
    if group == "start" and number not in STARTS:
        raise _unknown(key, f"agents.{agent}.start.", STARTS)
    if group == "sensors":
        sensor, _, number = number.partition(".")
        if number not in _OF_SENSORS:
            raise _unknown(key, f"agents.{agent}.sensors.{sensor}.", _OF_SENSORS)
        return Varied(agent, group, number, sensor)
    return Varied(agent, group, number)


def turbidities(draw: Draw) -> tuple[float, ...]:
    """Turbidities that copies may have: daylight is solved for each, and what is drawn is rounded to one of them."""
    return tuple(dict.fromkeys(min(max(t, 0.0), _MURKIEST) for t in draw.steps(_WATERS)))


def check_ocean(key: str, draw: Draw, systems: Sequence[BaseModel]) -> None:
    """Check that the ocean of a scenario may have what can be drawn for it, and its wave systems what is to vary.

    Raises:
        PydanticCustomError: it has not, or may not.
    """
    varied = parse(key)
    if key == TURBIDITY and not all(0 <= t <= _MURKIEST for t in draw.steps(2) if draw.normal is None):
        raise PydanticCustomError("vary", "a turbidity is from 0 to {most}", {"most": f"{_MURKIEST:g}"})
    if varied.group != WAVES:
        return
    if int(varied.name) >= len(systems):
        text = "there is no 'ocean.waves.{place}'; the scenario has {count} wave systems"
        raise PydanticCustomError("vary", text, {"place": int(varied.name), "count": len(systems)})
    system = systems[int(varied.name)]
    known = [name for name, field in type(system).model_fields.items() if _is_number(field.annotation)]
    known = [name for name in known if name not in _ALIKE]
    if varied.number not in known:
        raise _unknown(key, f"ocean.waves.{varied.name}.", known)
    for value in draw.uniform or draw.choice or (draw.normal or ())[:1]:
        try:
            with_number(system, varied.number, value)
        except ValueError as error:
            raise PydanticCustomError("vary", "{text}", {"text": str(error)}) from None


def with_number(system: BaseModel, name: str, value: float) -> BaseModel:
    """A wave system with another number; whole numbers are rounded.

    Raises:
        ValueError: it may not have it.
    """
    whole = type(system).model_fields[name].annotation is int
    try:
        return type(system).model_validate(system.model_dump() | {name: round(value) if whole else value})
    except ValidationError as error:
        why = error.errors()[0]["msg"]
        raise ValueError(f"{name} of waves of type {getattr(system, 'type', '')} cannot be {value:g}: {why}") from None


def _is_number(kind: object) -> bool:
    return kind in (int, float, float | None)


def check(keys: Collection[str], agents: Mapping[str, Agent], props: Collection[str]) -> None:
    """Check that the agents and props of a scenario have what is to vary.

    Raises:
        PydanticCustomError: they have not.
    """
    for key in keys:
        varied = parse(key)
        if varied.group == PROPS and varied.name not in props:
            text = "there is no 'props.{prop}'{meant}"
            meant = did_you_mean(varied.name, props)
            raise PydanticCustomError("vary", text, {"prop": varied.name, "meant": meant})
        if not varied.agent:
            continue
        if varied.agent not in agents:
            text = "there is no 'agents.{agent}'; known: {known}"
            raise PydanticCustomError("vary", text, {"agent": varied.agent, "known": ", ".join(agents)})
        if agents[varied.agent].count is not None:
            text = "{agent} is a group of agents, whose members differ by 'distributions'"
            raise PydanticCustomError("vary", text, {"agent": varied.agent})
        if varied.group == "sensors" and varied.name not in agents[varied.agent].sensors:
            known = [f"agents.{varied.agent}.sensors.{name}." for name in agents[varied.agent].sensors]
            meant = did_you_mean(f"agents.{varied.agent}.sensors.{varied.name}.", known)
            text = "'{agent}' has no sensor '{sensor}'{meant}"
            raise PydanticCustomError("vary", text, {"agent": varied.agent, "sensor": varied.name, "meant": meant})


def _unknown(key: str, before: str, known: Collection[str]) -> PydanticCustomError:
    meant = did_you_mean(key, [before + name for name in known])
    return PydanticCustomError("vary", "there is no '{key}'{meant}", {"key": key, "meant": meant})
